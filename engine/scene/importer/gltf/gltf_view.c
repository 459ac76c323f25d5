/* Lights, of KHR_lights_punctual, and cameras. Both look along -Z of their node; up is +Y. */
#include "scene/importer/gltf/gltf.h"

#include <math.h>

/* At the origin of a node, along its -Z. */
static stilb_scene_mount view_mount(const gltf *from, const gltf_node *node)
{
	return (stilb_scene_mount){
		.node = 1 + (uint32_t)(node - from->nodes), .direction = {0.0f, 0.0f, -1.0f}, .up = {0.0f, 1.0f, 0.0f}};
}

/* ---- lights ------------------------------------------------------------------------------------------------------ */

/* The cones of a spot: angles from its axis, 0 <= inner < outer <= pi / 2. */
static void view_spot(gltf *from, uint32_t item, stilb_scene_light *light)
{
	scene_json *json = &from->json;
	uint32_t spot = scene_json_member(json, item, "spot");
	float inner = (float)scene_json_number(json, spot, "innerConeAngle", 0.0);
	float outer = (float)scene_json_number(json, spot, "outerConeAngle", 0.78539816339); /* pi / 4 */
	light->cos_inner = cosf(importer_clamp(inner, 0.0f, 1.5707963f));
	light->cos_outer = fminf(cosf(importer_clamp(outer, 0.0f, 1.5707963f)), light->cos_inner);
}

/* Converts a light at a node. Its numbers are candela, of directional ones lux. False: it is left out, having no
 * brightness, or a position that is too far away. */
static bool view_light(gltf *from, const gltf_node *node, uint32_t index, stilb_scene_light *light,
                       stilb_scene_mount *mount)
{
	scene_json *json = &from->json;
	uint32_t item = from->lists[GLTF_LIGHTS].items[index], type = scene_json_member(json, item, "type");
	float color[3] = {1, 1, 1}, strength = (float)scene_json_number(json, item, "intensity", 1.0);
	bool good = false;
	scene_json_numbers(json, item, "color", color, 3);
	*light = (stilb_scene_light){
		.kind = STILB_SCENE_LIGHT_POINT, .unit = STILB_SCENE_LIGHT_PHOTOMETRIC, .cos_inner = 1.0f, .cos_outer = 1.0f};
	if (scene_json_is(json, type, "directional"))
		light->kind = STILB_SCENE_LIGHT_DIRECTIONAL;
	else if (scene_json_is(json, type, "spot"))
		light->kind = STILB_SCENE_LIGHT_SPOT;
	if (light->kind == STILB_SCENE_LIGHT_SPOT)
		view_spot(from, item, light);
	float range = (float)scene_json_number(json, item, "range", 0.0);
	if (range > 1e-9f && range < 1e18f)
		light->falloff = STILB_SCENE_LIGHT_RANGED, light->reach = range;
	for (int i = 0; i < 3; i++) {
		float intensity = color[i] * strength;
		light->intensity[i] = intensity > 0.0f && intensity < 1e18f ? intensity : 0.0f;
		good |= light->intensity[i] > 0.0f;
	}
	*mount = view_mount(from, node);
	return scene_mount_light(mount, &node->to_world, light) && good;
}

/* The light of a node, or GLTF_NONE. */
static uint32_t view_light_of(gltf *from, const gltf_node *node)
{
	return gltf_reference(from, gltf_extension(from, node->item, "KHR_lights_punctual"), "light", GLTF_LIGHTS);
}

static stilb_result view_lights(gltf *from)
{
	stilb_scene *scene = from->import->scene;
	uint32_t count = 0;
	for (uint32_t n = 0; n < from->node_count; n++)
		count += view_light_of(from, &from->nodes[n]) != GLTF_NONE;
	stilb_result result = scene_add_lights(scene, count);
	if (result == STILB_OK && count > 0)
		result = scene_add_mounts(&scene->light_mounts, count);
	if (result != STILB_OK)
		return result;
	scene->light_count = 0;
	for (uint32_t n = 0; n < from->node_count; n++) {
		uint32_t index = view_light_of(from, &from->nodes[n]);
		if (index == GLTF_NONE)
			continue;
		char name[96];
		gltf_name(from, GLTF_LIGHTS, index, name);
		uint32_t next = scene->light_count;
		if (view_light(from, &from->nodes[n], index, &scene->lights[next], &scene->light_mounts[next]))
			scene->light_count++;
		else
			importer_lose(from->import, IMPORTER_LOSS_LIGHTS, name);
	}
	return scene_json_check(&from->json);
}

/* ---- cameras ----------------------------------------------------------------------------------------------------- */

/* Adds a perspective camera at a node. False: it is of another kind or out of range. */
static bool view_camera(gltf *from, const gltf_node *node, uint32_t index, const char *name)
{
	scene_json *json = &from->json;
	uint32_t perspective = scene_json_member(json, from->lists[GLTF_CAMERAS].items[index], "perspective");
	if (perspective == GLTF_NONE)
		return false;
	stilb_scene_mount mount = view_mount(from, node);
	return importer_add_camera(from->import, name, &mount, &node->to_world,
	                           (float)scene_json_number(json, perspective, "yfov", 0.0));
}

/* The index of a node's camera, or GLTF_NONE. */
static uint32_t view_camera_of(gltf *from, const gltf_node *node)
{
	return gltf_reference(from, node->item, "camera", GLTF_CAMERAS);
}

static stilb_result view_cameras(gltf *from)
{
	stilb_scene *scene = from->import->scene;
	uint32_t count = 0;
	char name[96];
	for (uint32_t n = 0; n < from->node_count; n++)
		count += view_camera_of(from, &from->nodes[n]) != GLTF_NONE;
	stilb_result result = scene_add_cameras(scene, count);
	if (result == STILB_OK && count > 0)
		result = scene_add_mounts(&scene->camera_mounts, count);
	if (result != STILB_OK)
		return result;
	scene->camera_count = 0;
	for (uint32_t n = 0; n < from->node_count; n++) {
		uint32_t index = view_camera_of(from, &from->nodes[n]);
		if (index == GLTF_NONE)
			continue;
		gltf_name(from, GLTF_CAMERAS, index, name);
		if (!view_camera(from, &from->nodes[n], index, name))
			importer_lose(from->import, IMPORTER_LOSS_CAMERAS, name);
	}
	return scene_json_check(&from->json);
}

stilb_result gltf_add_view(gltf *from)
{
	stilb_result result = view_lights(from);
	if (result == STILB_OK)
		result = view_cameras(from);
	return result;
}
