/* Lights, ambient light and cameras for the scene. */
#include "scene/importer/importer.h"

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

/* Sets the halves of an area light's sides, which lie across its direction, one of them across `up` too. False: it has
 * no size, and is a point. */
static bool light_spread(const struct aiLight *from, const importer_node *node, stilb_scene_light *light)
{
	stilb_vec3 direction = importer_direction(node, importer_vector(&from->mDirection));
	stilb_vec3 up = importer_direction(node, importer_vector(&from->mUp));
	stilb_vec3 x = stilb_vec3_cross(direction, up);
	float length = sqrtf(stilb_vec3_dot(x, x)), scale = 1.0f;
	if (node) {
		const float *m = node->to_world.m;
		scale = cbrtf(fabsf(m[0] * (m[5] * m[10] - m[6] * m[9]) - m[4] * (m[1] * m[10] - m[2] * m[9]) +
		                    m[8] * (m[1] * m[6] - m[2] * m[5])));
	}
	float width = 0.5f * scale * from->mSize.x, height = 0.5f * scale * from->mSize.y;
	if (!(length > 0.01f && width > 1e-6f && height > 1e-6f && width < 1e9f && height < 1e9f))
		return false;
	x *= 1.0f / length;
	stilb_vec3 y = stilb_vec3_cross(x, direction);
	for (int i = 0; i < 3; i++) {
		light->half_x[i] = width * x[i];
		light->half_y[i] = height * y[i];
	}
	return true;
}

/* Converts one of Assimp's lights. False: it is left out, having no brightness or a position that is not finite. */
static bool light_convert(const importer *import, const struct aiLight *from, stilb_scene_light *light)
{
	const importer_node *node = importer_find_node(import, &from->mName);
	stilb_vec3 position = importer_point(node, importer_vector(&from->mPosition));
	stilb_vec3 direction = importer_direction(node, importer_vector(&from->mDirection));
	float scale = light_scale(import, from, position);
	const float color[3] = {from->mColorDiffuse.r, from->mColorDiffuse.g, from->mColorDiffuse.b};
	bool good = false;
	/* KHR_lights_punctual has candela and lux; other formats have no units, and light_scale gives them W sr^-1. */
	*light = (stilb_scene_light){.kind = STILB_SCENE_LIGHT_POINT,
	                             .unit = import->gltf ? STILB_SCENE_LIGHT_PHOTOMETRIC : STILB_SCENE_LIGHT_RADIOMETRIC};
	if (from->mType == aiLightSource_DIRECTIONAL)
		light->kind = STILB_SCENE_LIGHT_DIRECTIONAL;
	else if (from->mType == aiLightSource_SPOT)
		light->kind = STILB_SCENE_LIGHT_SPOT;
	else if (from->mType == aiLightSource_AREA && light_spread(from, node, light))
		light->kind = STILB_SCENE_LIGHT_RECTANGLE;
	for (int i = 0; i < 3; i++) {
		float intensity = color[i] * scale;
		light->position[i] = position[i];
		light->direction[i] = direction[i];
		light->intensity[i] = intensity > 0.0f && intensity < 1e18f ? intensity : 0.0f;
		good |= light->intensity[i] > 0.0f;
		if (!(fabsf(position[i]) < 1e18f))
			return false;
	}
	light->cos_inner = light_cone_cosine(import, from->mAngleInnerCone);
	light->cos_outer = fminf(light_cone_cosine(import, from->mAngleOuterCone), light->cos_inner);
	STILB_ASSERT(!stilb_scene_light_mistake(light));
	return good;
}

static stilb_result view_add_lights(importer *import)
{
	const struct aiScene *from = import->from;
	stilb_scene *scene = import->scene;
	stilb_result result = scene_add_lights(scene, from->mNumLights);
	if (result != STILB_OK)
		return result;
	scene->light_count = 0;
	for (uint32_t i = 0; i < from->mNumLights; i++) {
		const struct aiLight *light = from->mLights[i];
		const struct aiColor3D *ambient = &light->mColorAmbient;
		if (light->mType != aiLightSource_AMBIENT) {
			if (light_convert(import, light, &scene->lights[scene->light_count]))
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

/* The roll of an upright camera that brings its up axis to `up`. The camera's axes are the rows of its view matrix. */
static float camera_roll(const stilb_scene_camera *camera, stilb_vec3 up)
{
	stilb_mat4 view = stilb_mat4_view((stilb_vec3){0}, camera->yaw, camera->pitch);
	stilb_vec3 upright_right = stilb_vec3_make(view.m[0], view.m[4], view.m[8]);
	stilb_vec3 upright_up = stilb_vec3_make(view.m[1], view.m[5], view.m[9]);
	float sine = stilb_vec3_dot(up, upright_right), cosine = stilb_vec3_dot(up, upright_up);
	return fabsf(sine) > 1e-5f || cosine < 0.0f ? atan2f(sine, cosine) : 0.0f;
}

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

bool importer_add_camera(importer *import, const char *name, stilb_vec3 position, stilb_vec3 view, stilb_vec3 up,
                         float fov_y)
{
	stilb_sphere scene = scene_sphere(import->scene);
	if (!(fov_y > 0.03f && fov_y < 3.1f) || !(fabsf(position[0]) + fabsf(position[1]) + fabsf(position[2]) < 1e18f))
		return false;
	stilb_vec3 away = position - stilb_vec3_make(scene.x, scene.y, scene.z);
	float distance = fmaxf(sqrtf(stilb_vec3_dot(away, away)) + scene.radius, CAMERA_LEAST_METRES);
	STILB_ASSERT(import->scene->cameras && "scene_add_cameras has made room");
	stilb_scene_named_camera *added = &import->scene->cameras[import->scene->camera_count++];
	added->camera = scene_camera_along(position, view, fov_y);
	added->camera.near_z = 1e-4f * distance;
	added->camera.far_z = 10.0f * distance;
	added->camera.roll = camera_roll(&added->camera, up);
	snprintf(added->name, sizeof added->name, "%s", name);
	return true;
}

/* Adds one of Assimp's cameras. False: its position or its angle is out of range. */
static bool camera_convert(importer *import, const struct aiCamera *from)
{
	const importer_node *node = importer_find_node(import, &from->mName);
	/* A glTF camera is at its node's origin; Assimp 5.2 adds the node's translation to mPosition a second time. */
	stilb_vec3 own = import->gltf ? (stilb_vec3){0} : importer_vector(&from->mPosition);
	return importer_add_camera(import, from->mName.data, importer_point(node, own),
	                           importer_direction(node, importer_vector(&from->mLookAt)),
	                           importer_direction(node, importer_vector(&from->mUp)), camera_fov_y(import, from));
}

stilb_result importer_add_view(importer *import)
{
	STILB_ASSERT(import->scene && import->scene->part_count > 0);
	stilb_result result = view_add_lights(import);
	if (result == STILB_OK)
		result = scene_add_cameras(import->scene, import->from->mNumCameras);
	import->scene->camera_count = 0;
	for (uint32_t i = 0; result == STILB_OK && i < import->from->mNumCameras; i++) {
		const struct aiCamera *camera = import->from->mCameras[i];
		if (!camera_is_default(camera) && !camera_convert(import, camera))
			importer_lose(import, IMPORTER_LOSS_CAMERAS, camera->mName.data);
	}
	return result;
}
