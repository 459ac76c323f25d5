/* Meshes and the models that show them. */
#include "scene/importer/gltf/gltf.h"

#include <math.h>
#include <stdlib.h>

/* ---- instances --------------------------------------------------------------------------------------------------- */

enum { MESH_TRANSLATION, MESH_ROTATION, MESH_SCALE, MESH_INSTANCE_NUMBERS };

/* The instances of a node: EXT_mesh_gpu_instancing, or the node alone. */
typedef struct mesh_instances {
	const gltf_node *node;
	uint64_t count;
	bool several;                                 /* the file has instances of it: each becomes a node on this one */
	gltf_accessor numbers[MESH_INSTANCE_NUMBERS]; /* {0}: not given */
} mesh_instances;

static void mesh_close_instances(mesh_instances *instances)
{
	for (int i = 0; i < MESH_INSTANCE_NUMBERS; i++)
		gltf_accessor_finish(&instances->numbers[i]);
}

static stilb_result mesh_open_instances(gltf *from, const gltf_node *node, mesh_instances *instances)
{
	static const char *const names[MESH_INSTANCE_NUMBERS] = {"TRANSLATION", "ROTATION", "SCALE"};
	uint32_t extension = gltf_extension(from, node->item, "EXT_mesh_gpu_instancing");
	uint32_t attributes = scene_json_member(&from->json, extension, "attributes");
	stilb_result result = STILB_OK;
	*instances = (mesh_instances){.node = node, .count = 1};
	for (int i = 0; result == STILB_OK && i < MESH_INSTANCE_NUMBERS; i++) {
		gltf_accessor *numbers = &instances->numbers[i];
		uint32_t index = gltf_reference(from, attributes, names[i], GLTF_ACCESSORS);
		if (index == GLTF_NONE)
			continue;
		result = gltf_accessor_open(from, index, i == MESH_ROTATION ? 1u << 3 : 1u << 2, numbers);
		if (result == STILB_OK && instances->several && numbers->count != instances->count)
			result = stilb_fail(STILB_ERROR_FILE, "accessor %u has %llu elements for %llu instances", index,
			                    (unsigned long long)numbers->count, (unsigned long long)instances->count);
		instances->count = numbers->count;
		instances->several = true;
	}
	if (result == STILB_OK)
		result = scene_json_check(&from->json);
	if (result != STILB_OK)
		mesh_close_instances(instances);
	return result;
}

/* The transform of an instance, in the node's space and to the world; false: it is not finite. */
static bool mesh_instance(const mesh_instances *instances, uint64_t i, stilb_mat4 *own, stilb_mat4 *to_world)
{
	stilb_scene_pose pose = {.rotation = {0, 0, 0, 1}, .scale = {1, 1, 1}};
	float *const numbers[MESH_INSTANCE_NUMBERS] = {pose.translation, pose.rotation, pose.scale};
	for (int k = 0; k < MESH_INSTANCE_NUMBERS; k++)
		if (instances->numbers[k].components)
			gltf_accessor_read(&instances->numbers[k], i, numbers[k]);
	*own = stilb_scene_pose_matrix(&pose);
	*to_world = instances->several ? stilb_mat4_multiply(instances->node->to_world, *own) : instances->node->to_world;
	return gltf_is_finite(to_world);
}

/* ---- parts ------------------------------------------------------------------------------------------------------- */

/* Converts the primitives of a mesh. */
static stilb_result mesh_convert_primitives(gltf *from, uint32_t mesh)
{
	scene_json *json = &from->json;
	gltf_parts *parts = &from->parts;
	uint32_t array = scene_json_array(json, from->lists[GLTF_MESHES].items[mesh], "primitives");
	uint32_t list = scene_json_array(json, SCENE_JSON_ROOT, "meshes"); /* tokens of it are how far we are */
	stilb_result result = scene_json_check(json);
	for (uint32_t at = scene_json_first(json, array); result == STILB_OK && at != GLTF_NONE;
	     at = scene_json_after(json, array, at)) {
		if (parts->count == parts->capacity) {
			uint32_t capacity = 2 * parts->capacity + 64;
			gltf_part *more =
				capacity <= 2 * STILB_SCENE_MAX_MODELS ? realloc(parts->parts, capacity * sizeof *more) : NULL;
			if (!more)
				return stilb_fail(STILB_ERROR_MEMORY, "no memory for its meshes");
			parts->parts = more;
			parts->capacity = capacity;
		}
		gltf_part *part = &parts->parts[parts->count];
		result = gltf_primitive_convert(from, mesh, at, part);
		if (result == STILB_OK && part->mesh.index_count > 0)
			parts->count++;
		importer_advance_meshes(from->import, json->tokens[at].next - list, json->tokens[list].next - list);
	}
	return result;
}

/* The mesh of a node, or GLTF_NONE. */
static uint32_t mesh_of(gltf *from, const gltf_node *node)
{
	return gltf_reference(from, node->item, "mesh", GLTF_MESHES);
}

/* Converts the meshes that nodes of the scene show. */
static stilb_result mesh_convert_all(gltf *from)
{
	uint32_t count = from->lists[GLTF_MESHES].count;
	bool *shown = calloc(count + 1ull, sizeof *shown);
	from->parts.first = calloc(count + 1ull, sizeof *from->parts.first);
	if (!shown || !from->parts.first) {
		free(shown);
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for its meshes");
	}
	for (uint32_t n = 0; n < from->node_count; n++) {
		uint32_t mesh = mesh_of(from, &from->nodes[n]);
		if (mesh != GLTF_NONE)
			shown[mesh] = true;
	}
	stilb_result result = scene_json_check(&from->json);
	for (uint32_t m = 0; result == STILB_OK && m < count; m++) {
		if (shown[m])
			result = mesh_convert_primitives(from, m);
		from->parts.first[m + 1] = from->parts.count;
	}
	free(shown);
	return result;
}

/* ---- models ------------------------------------------------------------------------------------------------------ */

typedef struct mesh_models {
	uint32_t models, parts, instances; /* so far */
} mesh_models;

/* Names a model by its node, which may have no name. */
static void mesh_name_model(gltf *from, const gltf_node *node, uint32_t model)
{
	stilb_scene_names *names = &from->import->scene->names;
	if (names->models)
		scene_json_string(&from->json, node->item, "name", names->models[model], STILB_SCENE_NAME);
}

/* Adds a node for an instance of a node, and returns its index. */
static uint32_t mesh_add_instance(stilb_scene_nodes *nodes, uint32_t parent, const stilb_mat4 *own,
                                  const stilb_mat4 *to_world)
{
	uint32_t node = nodes->count++;
	nodes->parent[node] = parent;
	nodes->pose[node] = stilb_scene_pose_of(own);
	nodes->local[node] = *own;
	nodes->to_world[node] = *to_world;
	return node;
}

static bool mesh_mirrors(const stilb_mat4 *to_world)
{
	const float *m = to_world->m;
	stilb_vec3 x = stilb_vec3_make(m[0], m[1], m[2]), y = stilb_vec3_make(m[4], m[5], m[6]);
	return stilb_vec3_dot(stilb_vec3_cross(x, y), stilb_vec3_make(m[8], m[9], m[10])) < 0.0f;
}

/* What extras may say of models, true or false, and the flag of those of which it is false. */
static const struct mesh_extra {
	const char *key;
	uint32_t flag;
} mesh_extras[] = {
	{"seen", STILB_SCENE_MODEL_UNSEEN},
	{"castShadow", STILB_SCENE_MODEL_CASTS_NO_SHADOW},
	{"receiveShadow", STILB_SCENE_MODEL_RECEIVES_NO_SHADOW},
};

/* The flags of a model after what the extras of an object, its mesh or its node, say of it; *wrong: they say neither
 * true nor false, which some programs write as 1 and 0. Extras are the file's own: most say nothing of it. */
static uint32_t mesh_read_extras(gltf *from, uint32_t object, uint32_t flags, bool *wrong)
{
	uint32_t extras = scene_json_member(&from->json, object, "extras");
	if (extras == GLTF_NONE || from->json.tokens[extras].kind != SCENE_JSON_OBJECT)
		return flags;
	for (size_t i = 0; i < sizeof mesh_extras / sizeof *mesh_extras; i++) {
		uint32_t value = scene_json_member(&from->json, extras, mesh_extras[i].key);
		if (value == GLTF_NONE)
			continue;
		scene_json_kind kind = from->json.tokens[value].kind;
		double number = scene_json_value(&from->json, value);
		if (kind == SCENE_JSON_FALSE || number == 0.0)
			flags |= mesh_extras[i].flag;
		else if (kind == SCENE_JSON_TRUE || number == 1.0)
			flags &= ~mesh_extras[i].flag;
		else
			*wrong = true;
	}
	return flags;
}

/* The flags of the models of a node: its mesh's, unless the node says otherwise. */
static uint32_t mesh_model_flags(gltf *from, const gltf_node *node, uint32_t mesh)
{
	char name[96];
	bool wrong = false;
	uint32_t flags = mesh_read_extras(from, from->lists[GLTF_MESHES].items[mesh], 0, &wrong);
	flags = mesh_read_extras(from, node->item, flags, &wrong);
	if (wrong) {
		gltf_name(from, GLTF_NODES, node->index, name);
		importer_lose(from->import, IMPORTER_LOSS_EXTRAS, name);
	}
	return flags;
}

/* Counts a model for each instance of a node or, if there is a scene, fills it. */
static stilb_result mesh_add_node(gltf *from, gltf_node *node, mesh_models *made)
{
	stilb_scene *scene = from->import->scene;
	uint32_t mesh = mesh_of(from, node);
	uint32_t first = mesh == GLTF_NONE ? 0 : from->parts.first[mesh];
	uint32_t end = mesh == GLTF_NONE ? 0 : from->parts.first[mesh + 1];
	mesh_instances instances;
	stilb_mat4 own, to_world;
	node->first_model = made->models;
	if (first == end)
		return STILB_OK;
	uint32_t flags = scene ? mesh_model_flags(from, node, mesh) : 0;
	stilb_result result = mesh_open_instances(from, node, &instances);
	for (uint64_t i = 0; result == STILB_OK && i < instances.count; i++) {
		bool finite = mesh_instance(&instances, i, &own, &to_world);
		from->import->bad_nodes += !finite && !scene;
		bool mirrored = scene && finite && mesh_mirrors(&to_world);
		for (uint32_t p = first; mirrored && p < end; p++)
			gltf_show_materials(from, from->parts.parts[p].item, from->parts.parts[p].material, GLTF_SHOWN_MIRRORED);
		for (uint32_t p = first; scene && finite && p < end; p++) {
			scene->part_mesh[made->parts + p - first] = p;
			scene->part_material[made->parts + p - first] = from->parts.parts[p].material;
			scene->part_transform[made->parts + p - first] = to_world;
		}
		uint32_t hangs_on = (uint32_t)(node - from->nodes);
		if (scene && finite && instances.several)
			hangs_on = mesh_add_instance(&scene->nodes, hangs_on, &own, &to_world);
		if (scene && finite) {
			scene->model_node[made->models] = 1 + hangs_on;
			scene_set_model_flags(scene, made->models, flags);
		}
		made->parts += finite ? end - first : 0;
		made->models += finite;
		made->instances += finite && instances.several;
		if (scene && finite) {
			scene->first_part[made->models] = made->parts;
			mesh_name_model(from, node, made->models - 1);
		}
		if (made->parts > STILB_SCENE_MAX_MODELS)
			result = stilb_fail(STILB_ERROR_FILE, "it shows more than %u meshes", STILB_SCENE_MAX_MODELS);
	}
	mesh_close_instances(&instances);
	node->model_count = made->models - node->first_model;
	return result;
}

static stilb_result mesh_add_models(gltf *from, mesh_models *made)
{
	stilb_result result = STILB_OK;
	*made = (mesh_models){0};
	for (uint32_t n = 0; result == STILB_OK && n < from->node_count; n++)
		result = mesh_add_node(from, &from->nodes[n], made);
	return result;
}

stilb_result gltf_add_meshes(gltf *from)
{
	STILB_ASSERT(!from->import->scene);
	mesh_models counted, made;
	gltf_parts *parts = &from->parts;
	stilb_result result = mesh_convert_all(from);
	if (result == STILB_OK)
		result = mesh_add_models(from, &counted);
	if (result == STILB_OK && counted.parts == 0)
		result = stilb_fail(STILB_ERROR_FILE, "it has no triangles, and nothing else is shown");
	uint32_t materials = from->lists[GLTF_MATERIALS].count + from->needs_default_material;
	if (result == STILB_OK)
		result =
			scene_create(counted.models, counted.parts, parts->count, materials ? materials : 1, &from->import->scene);
	if (result == STILB_OK)
		result = scene_add_names(from->import->scene);
	if (result != STILB_OK)
		return result;
	stilb_scene *scene = from->import->scene;
	for (uint32_t p = 0; p < parts->count; p++) {
		scene->meshes[p] = parts->parts[p].mesh;
		parts->parts[p].mesh = (stilb_scene_mesh){0};
	}
	result = gltf_add_nodes(from, counted.instances);
	if (result == STILB_OK)
		result = mesh_add_models(from, &made);
	STILB_ASSERT(result != STILB_OK || (made.parts == counted.parts && made.models == counted.models));
	if (result == STILB_OK)
		scene_fit_all_bounds(scene);
	return result;
}
