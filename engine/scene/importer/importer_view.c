/* Lights, ambient light and cameras for the scene. */
#include "scene/importer/importer.h"

#include "scene/edit/scene_check.h"
#include "shading/shade_constants.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* ---- lights ------------------------------------------------------------------------------------------------------ */

/* The factor from a light's colour in the file to its intensity here, where light falls with the square of the
 * distance. It is 1 in glTF, which has physical units. In other formats a light of brightness 1 makes a white surface
 * that faces it white, which is an irradiance of pi. So the intensity is chosen to give pi, times the file's own
 * attenuation, at the distance of the scene's centre, or of a tenth of the scene's radius if that is farther. */
static float light_scale(const importer *import, const struct aiLight *light, stilb_vec3 position)
{
	bool directional = light->mType == aiLightSource_DIRECTIONAL;
	if (import->gltf)
		return 1.0f;
	if (directional)
		return SHADE_PI;
	stilb_sphere scene = scene_sphere(import->scene);
	stilb_vec3 away = position - stilb_vec3_make(scene.x, scene.y, scene.z);
	float distance = fmaxf(sqrtf(stilb_vec3_dot(away, away)), 0.1f * scene.radius);
	float left = light->mAttenuationConstant + light->mAttenuationLinear * distance +
	             light->mAttenuationQuadratic * distance * distance;
	return SHADE_PI * distance * distance / (left > 0.0f ? left : 1.0f);
}

/* The cosine of the angle between the axis of a spot's cone and its edge. In glTF `angle` is that angle, in other
 * formats the whole cone's, twice as large. */
static float light_cone_cosine(const importer *import, float angle)
{
	float half = import->gltf ? angle : 0.5f * angle;
	return half > 0.0f ? cosf(fminf(half, 0.5f * SHADE_PI)) : 1.0f;
}

/* True if the file has another falloff than that with the square. A light of which a format says nothing has a linear
 * one in Assimp. */
static bool light_fades_otherwise(const importer *import, const struct aiLight *light)
{
	bool unsaid = light->mAttenuationConstant == 0.0f && light->mAttenuationLinear == 1.0f &&
	              light->mAttenuationQuadratic == 0.0f;
	return !import->gltf && light->mType != aiLightSource_DIRECTIONAL && !unsaid &&
	       (light->mAttenuationConstant > 0.0f || light->mAttenuationLinear > 0.0f);
}

/* Sets the halves of an area light's sides in the node's space, across its direction, one of them across `up` too.
 * False: it has no size. */
static bool light_spread(const struct aiLight *from, stilb_scene_mount *mount)
{
	stilb_vec3 direction = importer_vector(&from->mDirection), up = importer_vector(&from->mUp);
	stilb_vec3 x = stilb_vec3_cross(direction, up), y = stilb_vec3_cross(x, direction);
	float x_length = sqrtf(stilb_vec3_dot(x, x)), y_length = sqrtf(stilb_vec3_dot(y, y));
	float lengths = sqrtf(stilb_vec3_dot(direction, direction) * stilb_vec3_dot(up, up));
	if (!(x_length > 0.01f * lengths && y_length > 0.0f))
		return false;
	for (int i = 0; i < 3; i++) {
		mount->half_x[i] = 0.5f * from->mSize.x / x_length * x[i];
		mount->half_y[i] = 0.5f * from->mSize.y / y_length * y[i];
	}
	return true;
}

/* Makes an area light of a point, if it has a size in the world, which is not below 2e-6 m. */
static void light_make_rectangle(const struct aiLight *from, const importer_node *node, stilb_scene_mount *mount,
                                 stilb_scene_light *light)
{
	stilb_scene_mount spread = *mount;
	stilb_scene_light area = *light;
	area.kind = STILB_SCENE_LIGHT_RECTANGLE;
	if (!light_spread(from, &spread) || !scene_mount_light(&spread, &node->to_world, &area))
		return;
	float least = 1e-6f, most = 1e9f, lengths[2] = {0};
	for (int i = 0; i < 3; i++) {
		lengths[0] += area.half_x[i] * area.half_x[i];
		lengths[1] += area.half_y[i] * area.half_y[i];
	}
	if (!scene_is_within(lengths, 2, least * least, most * most))
		return;
	*light = area;
	*mount = spread;
}

/* How a thing of a name stands on the node of that name. */
static stilb_scene_mount view_hang(const importer *import, const importer_node *node)
{
	return (stilb_scene_mount){.node = node == &import->world ? 0 : 1 + (uint32_t)(node - import->nodes)};
}

/* Copies a position or a direction of a file, or this instead where a number is not finite or beyond 1e18. */
static void view_put(const struct aiVector3D *v, const float instead[3], float out[3])
{
	const float values[3] = {v->x, v->y, v->z};
	bool good = scene_is_within(values, 3, -SCENE_FAR, SCENE_FAR);
	for (int i = 0; i < 3; i++)
		out[i] = good ? values[i] : instead[i];
}

static const float view_ahead[3] = {0.0f, 0.0f, -1.0f}, view_origin[3];

/* False for a position that is no place; a directional light needs none. */
static bool light_is_near(const struct aiLight *from)
{
	const float at[3] = {from->mPosition.x, from->mPosition.y, from->mPosition.z};
	return from->mType == aiLightSource_DIRECTIONAL || scene_is_within(at, 3, -SCENE_FAR, SCENE_FAR);
}

/* Converts one of Assimp's lights. False: it is left out, having no brightness or a position that is not finite. */
static bool light_convert(const importer *import, const struct aiLight *from, stilb_scene_light *light,
                          stilb_scene_mount *mount)
{
	const importer_node *node = importer_find_node(import, &from->mName);
	float scale = light_scale(import, from, importer_point(node, importer_vector(&from->mPosition)));
	const float color[3] = {from->mColorDiffuse.r, from->mColorDiffuse.g, from->mColorDiffuse.b};
	bool good = false;
	/* KHR_lights_punctual has candela and lux; other formats have no units, and light_scale gives them W sr^-1. */
	*light = (stilb_scene_light){.kind = STILB_SCENE_LIGHT_POINT,
	                             .unit = import->gltf ? STILB_SCENE_LIGHT_PHOTOMETRIC : STILB_SCENE_LIGHT_RADIOMETRIC};
	if (from->mType == aiLightSource_DIRECTIONAL)
		light->kind = STILB_SCENE_LIGHT_DIRECTIONAL;
	else if (from->mType == aiLightSource_SPOT)
		light->kind = STILB_SCENE_LIGHT_SPOT;
	for (int i = 0; i < 3; i++) {
		float intensity = color[i] * scale;
		light->intensity[i] = intensity > 0.0f && intensity < 1e18f ? intensity : 0.0f;
		good |= light->intensity[i] > 0.0f;
	}
	light->cos_inner = light_cone_cosine(import, from->mAngleInnerCone);
	light->cos_outer = fminf(light_cone_cosine(import, from->mAngleOuterCone), light->cos_inner);
	*mount = view_hang(import, node);
	view_put(&from->mPosition, view_origin, mount->position);
	view_put(&from->mDirection, view_ahead, mount->direction);
	bool placed = scene_mount_light(mount, &node->to_world, light);
	if (placed && from->mType == aiLightSource_AREA)
		light_make_rectangle(from, node, mount, light);
	return placed && good && light_is_near(from);
}

static stilb_result view_add_lights(importer *import)
{
	const struct aiScene *from = import->from;
	stilb_scene *scene = import->scene;
	stilb_result result = scene_add_lights(scene, from->mNumLights);
	if (result == STILB_OK && from->mNumLights > 0)
		result = scene_add_mounts(&scene->light_mounts, from->mNumLights);
	if (result != STILB_OK)
		return result;
	scene->light_count = 0;
	for (uint32_t i = 0; i < from->mNumLights; i++) {
		const struct aiLight *light = from->mLights[i];
		const struct aiColor3D *ambient = &light->mColorAmbient;
		if (light->mType != aiLightSource_AMBIENT) {
			uint32_t next = scene->light_count;
			if (light_convert(import, light, &scene->lights[next], &scene->light_mounts[next]))
				scene->light_count++;
			else
				importer_lose(import, IMPORTER_LOSS_LIGHTS, light->mName.data);
			if (light_fades_otherwise(import, light))
				importer_lose(import, IMPORTER_LOSS_FALLOFFS, light->mName.data);
		} else if (ambient->r >= 0.0f && ambient->g >= 0.0f && ambient->b >= 0.0f &&
		           ambient->r + ambient->g + ambient->b < 1e9f)
			stilb_scene_set_sky(scene, (const float[3]){ambient->r, ambient->g, ambient->b});
	}
	return STILB_OK;
}

/* ---- camera ------------------------------------------------------------------------------------------------------ */

#define CAMERA_LEAST_METRES 1e-15f /* smallest distance of a camera: squares of less underflow */

/* The angle of the picture's height. Assimp's field holds the angle of the width, for the file's aspect ratio or 4 : 3;
 * of glTF, Assimp 5.2 stores the angle of the height times the aspect ratio there. */
static float camera_fov_y(const importer *import, const struct aiCamera *from)
{
	bool has_ratio = from->mAspect > 0.01f && from->mAspect < 100.0f;
	if (import->gltf)
		return from->mHorizontalFOV / (has_ratio ? from->mAspect : 1.0f);
	return 2.0f * atanf(tanf(0.5f * from->mHorizontalFOV) / (has_ratio ? from->mAspect : 4.0f / 3.0f));
}

/* True for the cameras that every FBX file has, wherever its model is: "Producer Perspective", "Producer Front", ... */
static bool camera_is_default(const struct aiCamera *from)
{
	return strncmp(from->mName.data, "Producer ", strlen("Producer ")) == 0;
}

bool importer_add_camera(importer *import, const char *name, const stilb_scene_mount *mount, const stilb_mat4 *to_world,
                         float fov_y)
{
	stilb_scene *scene = import->scene;
	stilb_sphere sphere = scene_sphere(scene);
	STILB_ASSERT(scene->cameras && scene->camera_mounts && "there is room");
	stilb_scene_camera camera = {.fov_y = fov_y};
	if (!(fov_y > 0.03f && fov_y < 3.1f) || !scene_mount_camera(mount, to_world, &camera))
		return false;
	stilb_vec3 away = stilb_vec3_make(camera.position[0], camera.position[1], camera.position[2]) -
	                  stilb_vec3_make(sphere.x, sphere.y, sphere.z);
	float distance = fmaxf(sqrtf(stilb_vec3_dot(away, away)) + sphere.radius, CAMERA_LEAST_METRES);
	camera.near_z = 1e-4f * distance;
	camera.far_z = 10.0f * distance;
	stilb_scene_named_camera *added = &scene->cameras[scene->camera_count];
	added->camera = camera;
	snprintf(added->name, sizeof added->name, "%s", name);
	scene->camera_mounts[scene->camera_count++] = *mount;
	return true;
}

/* Adds one of Assimp's cameras. False: its position or its angle is out of range. */
static bool camera_convert(importer *import, const struct aiCamera *from)
{
	static const float up[3] = {0.0f, 1.0f, 0.0f};
	const importer_node *node = importer_find_node(import, &from->mName);
	const float at[3] = {from->mPosition.x, from->mPosition.y, from->mPosition.z};
	stilb_scene_mount mount = view_hang(import, node);
	/* A glTF camera is at its node's origin; Assimp 5.2 adds the node's translation to mPosition a second time. */
	if (!import->gltf)
		view_put(&from->mPosition, view_origin, mount.position);
	view_put(&from->mLookAt, view_ahead, mount.direction);
	view_put(&from->mUp, up, mount.up);
	return (import->gltf || scene_is_within(at, 3, -SCENE_FAR, SCENE_FAR)) &&
	       importer_add_camera(import, from->mName.data, &mount, &node->to_world, camera_fov_y(import, from));
}

stilb_result importer_add_view(importer *import)
{
	stilb_scene *scene = import->scene;
	STILB_ASSERT(scene && scene->part_count > 0);
	uint32_t count = import->from->mNumCameras;
	stilb_result result = view_add_lights(import);
	if (result == STILB_OK)
		result = scene_add_cameras(scene, count);
	if (result == STILB_OK && count > 0)
		result = scene_add_mounts(&scene->camera_mounts, count);
	scene->camera_count = 0;
	for (uint32_t i = 0; result == STILB_OK && i < count; i++) {
		const struct aiCamera *camera = import->from->mCameras[i];
		if (!camera_is_default(camera) && !camera_convert(import, camera))
			importer_lose(import, IMPORTER_LOSS_CAMERAS, camera->mName.data);
	}
	return result;
}
