#include "scene/open/scene_stream_rest.h"

#include "scene/open/scene_stream_bytes.h"

#include "scene/edit/scene_variant.h"
#include "scene/scene_animation_internal.h"
#include "scene/scene_internal.h"

#include <stdlib.h>

void scene_stream_clean_name(char *name, size_t size)
{
	for (size_t i = 0; i < size && name[i] != 0; i++)
		if ((unsigned char)name[i] < ' ' || name[i] == 0x7f)
			name[i] = ' ';
}

/* ---- variants ---------------------------------------------------------------------------------------------------- */

#define STREAM_MAX_VARIANT_MATERIALS (1u << 28) /* of all variants and parts, 1 GiB */

static bool stream_put_variants(int file, const stilb_scene_variants *variants)
{
	uint32_t count = variants ? variants->count : 0;
	if (!scene_stream_put(file, &count, sizeof count) || count == 0)
		return count == 0;
	return scene_stream_put(file, variants->names, count * sizeof *variants->names) &&
	       scene_stream_put(file, variants->materials,
	                        (count + (size_t)1) * variants->part_count * sizeof *variants->materials);
}

static stilb_result stream_get_variants(scene_stream *stream, stilb_scene *scene)
{
	uint32_t count;
	if (!scene_stream_get(stream, &count, sizeof count))
		return scene_stream_broken(stream);
	if (count == 0)
		return STILB_OK;
	uint64_t materials = (count + 1ull) * scene->part_count;
	if (count > STILB_SCENE_MAX_VARIANTS || materials > STREAM_MAX_VARIANT_MATERIALS)
		return scene_stream_wrong("variants");
	stilb_result result = scene_add_variants(scene, count);
	if (result != STILB_OK)
		return result;
	stilb_scene_variants *variants = scene->variants;
	bool good = scene_stream_get(stream, variants->names, count * sizeof *variants->names) &&
	            scene_stream_get(stream, variants->materials, materials * sizeof *variants->materials);
	for (uint32_t v = 0; good && v < count; v++)
		scene_stream_clean_name(variants->names[v], sizeof variants->names[v]);
	return good ? STILB_OK : scene_stream_broken(stream);
}

/* ---- what moves -------------------------------------------------------------------------------------------------- */

#define STREAM_MAX_MOVING                                                                                              \
	(1u << 28) /* elements of an array: what is of them at once is limited by the import's bytes */

/* What a stilb_scene_deform has besides its arrays. */
typedef struct stream_deform {
	uint32_t mesh, influences, targets, normals, tangents;
} stream_deform;

static bool stream_put_deform(int file, const stilb_scene *scene, const stilb_scene_deform *deform)
{
	scene_animation_array arrays[SCENE_DEFORM_ARRAYS];
	stream_deform head = {deform->mesh, deform->influences, deform->targets, deform->normals ? 1 : 0,
	                      deform->tangents ? 1 : 0};
	stilb_scene_deform copy = *deform;
	bool good = scene_stream_put(file, &head, sizeof head);
	scene_deform_arrays(&copy, scene->meshes[deform->mesh].vertex_count, arrays);
	for (int i = 0; good && i < SCENE_DEFORM_ARRAYS; i++)
		good = !*arrays[i].at || scene_stream_put(file, *arrays[i].at, arrays[i].count * arrays[i].size);
	return good;
}

/* The counts of the animation's arrays go first, as a struct whose pointers are NULL; all 0: there is none. */
static bool stream_put_animation(int file, const stilb_scene *scene)
{
	scene_animation_array arrays[SCENE_ANIMATION_ARRAYS];
	stilb_scene_animation counts = {0};
	if (!scene->animation)
		return scene_stream_put(file, &counts, sizeof counts);
	counts = *scene->animation;
	counts.deforms = NULL;
	scene_animation_arrays(&counts, arrays);
	for (int i = 0; i < SCENE_ANIMATION_ARRAYS; i++)
		*arrays[i].at = NULL;
	bool good = scene_stream_put(file, &counts, sizeof counts);
	scene_animation_arrays(scene->animation, arrays);
	for (int i = 0; good && i < SCENE_ANIMATION_ARRAYS; i++)
		good = scene_stream_put(file, *arrays[i].at, arrays[i].count * arrays[i].size);
	for (uint32_t d = 0; good && d < counts.deform_count; d++)
		good = stream_put_deform(file, scene, &scene->animation->deforms[d]);
	return good;
}

static stilb_result stream_get_deform(scene_stream *stream, const stilb_scene *scene, stilb_scene_deform *deform)
{
	scene_animation_array arrays[SCENE_DEFORM_ARRAYS];
	stream_deform head;
	if (!scene_stream_get(stream, &head, sizeof head))
		return scene_stream_broken(stream);
	if (head.mesh >= scene->mesh_count)
		return scene_stream_wrong("animation");
	uint32_t vertices = scene->meshes[head.mesh].vertex_count;
	stilb_scene_deform made = {.mesh = head.mesh, .influences = head.influences, .targets = head.targets};
	if ((uint64_t)vertices * head.influences > STREAM_MAX_MOVING || 3ull * vertices * head.targets > STREAM_MAX_MOVING)
		return scene_stream_wrong("animation");
	stilb_result result = scene_deform_create(&made, vertices, head.normals > 0, head.tangents > 0);
	*deform = made;
	if (result != STILB_OK)
		return result;
	bool good = true;
	scene_deform_arrays(deform, vertices, arrays);
	for (int i = 0; good && i < SCENE_DEFORM_ARRAYS; i++)
		good = !*arrays[i].at || scene_stream_get(stream, *arrays[i].at, arrays[i].count * arrays[i].size);
	return good ? STILB_OK : scene_stream_broken(stream);
}

static stilb_result stream_get_animation(scene_stream *stream, stilb_scene *scene)
{
	scene_animation_array arrays[SCENE_ANIMATION_ARRAYS];
	stilb_scene_animation counts;
	if (!scene_stream_get(stream, &counts, sizeof counts))
		return scene_stream_broken(stream);
	uint64_t all = counts.deform_count;
	uint32_t most = STILB_SCENE_MAX_MODELS;
	bool possible = counts.deform_count <= scene->mesh_count && counts.node_count <= most &&
	                counts.clip_count <= most && counts.channel_count <= most && counts.skin_count <= most &&
	                counts.joint_count <= most;
	scene_animation_arrays(&counts, arrays);
	for (int i = 0; i < SCENE_ANIMATION_ARRAYS; i++) {
		possible &= arrays[i].count <= STREAM_MAX_MOVING;
		all += arrays[i].count;
	}
	if (all == 0)
		return STILB_OK;
	if (!possible)
		return scene_stream_wrong("animation");
	stilb_result result = scene_animation_create(&counts, &scene->animation);
	if (result != STILB_OK)
		return result;
	stilb_scene_animation *made = scene->animation;
	bool good = true;
	scene_animation_arrays(made, arrays);
	for (int i = 0; good && i < SCENE_ANIMATION_ARRAYS; i++)
		good = scene_stream_get(stream, *arrays[i].at, arrays[i].count * arrays[i].size);
	if (!good)
		return scene_stream_broken(stream);
	for (uint32_t n = 0; n < made->node_count; n++) {
		unsigned char *moves = (unsigned char *)&made->nodes[n].moves;
		*moves = *moves > 0; /* a bool has no other values */
		scene_stream_clean_name(made->nodes[n].name, sizeof made->nodes[n].name);
	}
	for (uint32_t c = 0; c < made->clip_count; c++)
		scene_stream_clean_name(made->clips[c].name, sizeof made->clips[c].name);
	for (uint32_t s = 0; s < made->skin_count; s++)
		scene_stream_clean_name(made->skins[s].name, sizeof made->skins[s].name);
	for (uint32_t d = 0; result == STILB_OK && d < made->deform_count; d++)
		result = stream_get_deform(stream, scene, &made->deforms[d]);
	return result;
}

/* ---- names ------------------------------------------------------------------------------------------------------- */

static bool stream_put_names(int file, const stilb_scene_names *names)
{
	bool there = names->models;
	if (!scene_stream_put(file, &there, sizeof there) || !there)
		return !there;
	return scene_stream_put(file, names->models, names->model_count * sizeof *names->models) &&
	       scene_stream_put(file, names->materials, names->material_count * sizeof *names->materials);
}

static void stream_end_names(char (*names)[STILB_SCENE_NAME], uint32_t count)
{
	for (uint32_t i = 0; i < count; i++) {
		names[i][STILB_SCENE_NAME - 1] = '\0';
		scene_stream_clean_name(names[i], STILB_SCENE_NAME);
	}
}

static stilb_result stream_get_names(scene_stream *stream, stilb_scene *scene)
{
	unsigned char there;
	stilb_scene_names *names = &scene->names;
	if (!scene_stream_get(stream, &there, sizeof there))
		return scene_stream_broken(stream);
	if (there == 0)
		return STILB_OK;
	stilb_result result = scene_add_names(scene);
	if (result != STILB_OK)
		return result;
	if (!names->models)
		return scene_stream_wrong("names");
	if (!scene_stream_get(stream, names->models, names->model_count * sizeof *names->models) ||
	    !scene_stream_get(stream, names->materials, names->material_count * sizeof *names->materials))
		return scene_stream_broken(stream);
	stream_end_names(names->models, names->model_count);
	stream_end_names(names->materials, names->material_count);
	return STILB_OK;
}

/* ---- nodes ------------------------------------------------------------------------------------------------------- */

/* Where lights or cameras hang; mounts: NULL, or [count]. */
static bool stream_put_mounts(int file, const stilb_scene_mount *mounts, uint32_t count)
{
	bool there = mounts;
	return scene_stream_put(file, &there, sizeof there) &&
	       (!there || scene_stream_put(file, mounts, count * sizeof *mounts));
}

static stilb_result stream_get_mounts(scene_stream *stream, stilb_scene_mount **mounts, uint32_t count)
{
	unsigned char there;
	if (!scene_stream_get(stream, &there, sizeof there))
		return scene_stream_broken(stream);
	stilb_result result = there > 0 ? scene_add_mounts(mounts, count) : STILB_OK;
	if (result == STILB_OK && there > 0 && !scene_stream_get(stream, *mounts, count * sizeof **mounts))
		return scene_stream_broken(stream);
	return result;
}

static bool stream_put_nodes(int file, const stilb_scene *scene)
{
	const stilb_scene_nodes *nodes = &scene->nodes;
	size_t count = nodes->count;
	if (!scene_stream_put(file, &nodes->count, sizeof nodes->count) || count == 0)
		return count == 0;
	return stream_put_mounts(file, scene->light_mounts, scene->light_count) &&
	       stream_put_mounts(file, scene->camera_mounts, scene->camera_count) &&
	       scene_stream_put(file, nodes->parent, count * sizeof *nodes->parent) &&
	       scene_stream_put(file, nodes->pose, count * sizeof *nodes->pose) &&
	       scene_stream_put(file, nodes->local, count * sizeof *nodes->local) &&
	       scene_stream_put(file, nodes->name, count * sizeof *nodes->name) &&
	       scene_stream_put(file, scene->model_node, scene->model_count * sizeof *scene->model_node);
}

/* The places in the world follow from the others. */
static stilb_result stream_get_nodes(scene_stream *stream, stilb_scene *scene)
{
	stilb_scene_nodes *nodes = &scene->nodes;
	uint32_t count;
	if (!scene_stream_get(stream, &count, sizeof count))
		return scene_stream_broken(stream);
	if (count > 2 * STILB_SCENE_MAX_MODELS)
		return scene_stream_wrong("nodes");
	stilb_result result = count > 0 ? scene_add_nodes(scene, count) : STILB_OK;
	if (result == STILB_OK && count > 0)
		result = stream_get_mounts(stream, &scene->light_mounts, scene->light_count);
	if (result == STILB_OK && count > 0)
		result = stream_get_mounts(stream, &scene->camera_mounts, scene->camera_count);
	if (result != STILB_OK || count == 0)
		return result;
	if (!scene_stream_get(stream, nodes->parent, count * sizeof *nodes->parent) ||
	    !scene_stream_get(stream, nodes->pose, count * sizeof *nodes->pose) ||
	    !scene_stream_get(stream, nodes->local, count * sizeof *nodes->local) ||
	    !scene_stream_get(stream, nodes->name, count * sizeof *nodes->name) ||
	    !scene_stream_get(stream, scene->model_node, scene->model_count * sizeof *scene->model_node))
		return scene_stream_broken(stream);
	for (uint32_t n = 0; n < count; n++) {
		nodes->name[n][sizeof *nodes->name - 1] = 0;
		scene_stream_clean_name(nodes->name[n], sizeof *nodes->name);
	}
	if (!scene_nodes_are_sound(scene))
		return scene_stream_wrong("nodes");
	for (uint32_t n = 0; n < count; n++) {
		uint32_t parent = nodes->parent[n];
		nodes->to_world[n] = nodes->local[n];
		if (parent != STILB_SCENE_NONE)
			nodes->to_world[n] = stilb_mat4_multiply(nodes->to_world[parent], nodes->local[n]);
	}
	return STILB_OK;
}

static bool stream_put_flags(int file, const stilb_scene *scene)
{
	return scene_stream_put(file, scene->model_flags, scene->model_count * sizeof *scene->model_flags);
}

static stilb_result stream_get_flags(scene_stream *stream, stilb_scene *scene)
{
	if (!scene_stream_get(stream, scene->model_flags, scene->model_count * sizeof *scene->model_flags))
		return scene_stream_broken(stream);
	for (uint32_t m = 0; m < scene->model_count; m++) {
		if (scene->model_flags[m] > STILB_SCENE_MODEL_FLAGS)
			return scene_stream_wrong("models");
		scene->flags_used |= scene->model_flags[m];
	}
	return STILB_OK;
}

/* ---- all --------------------------------------------------------------------------------------------------------- */

bool scene_stream_write_rest(int file, const stilb_scene *scene)
{
	return stream_put_nodes(file, scene) && stream_put_flags(file, scene) &&
	       stream_put_variants(file, scene->variants) && stream_put_names(file, &scene->names) &&
	       stream_put_animation(file, scene);
}

stilb_result scene_stream_read_rest(scene_stream *stream, stilb_scene *scene)
{
	stilb_result result = stream_get_nodes(stream, scene);
	if (result == STILB_OK)
		result = stream_get_flags(stream, scene);
	if (result == STILB_OK)
		result = stream_get_variants(stream, scene);
	if (result == STILB_OK)
		result = stream_get_names(stream, scene);
	return result == STILB_OK ? stream_get_animation(stream, scene) : result;
}
