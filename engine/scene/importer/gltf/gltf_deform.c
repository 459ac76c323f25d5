/* What deforms a primitive: the joints and weights of its vertices, and its morph targets. */
#include "scene/importer/gltf/gltf.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define DEFORM_SETS 8u /* JOINTS_0 to JOINTS_7: 32 influences of a vertex */

stilb_result gltf_leave_out(gltf *from, stilb_result result, importer_loss loss, const char *name)
{
	char words[256];
	if (result == STILB_ERROR_MEMORY)
		return result;
	snprintf(words, sizeof words, "%s: %s", name, stilb_error_message());
	importer_lose(from->import, loss, words);
	from->json.fault[0] = '\0';
	return STILB_OK;
}

/* A primitive whose deform is being read. */
typedef struct deform_reader {
	gltf *from;
	const uint32_t *source;            /* [vertex_count] vertices of the file */
	const gltf_accessor *packed;       /* joints and weights of the first set, decompressed, or {0} */
	uint32_t vertex_count, file_count; /* vertices of the mesh, and 1 + the highest of the file that it uses */
	uint32_t item, names;              /* tokens: the primitive, its attributes */
	stilb_scene_deform *deform;
} deform_reader;

/* ---- skins ------------------------------------------------------------------------------------------------------- */

/* The accessor of an attribute by name and set, with room for all vertices. Not there: it is {0}. */
static stilb_result deform_open(const deform_reader *reader, const char *name, uint32_t set, gltf_accessor *accessor)
{
	char key[24];
	gltf *from = reader->from;
	snprintf(key, sizeof key, "%s_%u", name, set);
	uint32_t index = gltf_reference(from, reader->names, key, GLTF_ACCESSORS);
	*accessor = (gltf_accessor){0};
	if (index == GLTF_NONE)
		return scene_json_check(&from->json);
	stilb_result result = gltf_accessor_open(from, index, 1u << 3, accessor);
	if (result == STILB_OK && accessor->count < reader->file_count)
		result = stilb_fail(STILB_ERROR_FILE, "accessor %u has too few elements", index);
	if (result != STILB_OK)
		gltf_accessor_finish(accessor);
	return result;
}

/* Writes a set of four influences of each vertex. */
static stilb_result deform_fill_set(const deform_reader *reader, uint32_t set, const gltf_accessor *joints,
                                    const gltf_accessor *weights)
{
	stilb_scene_deform *deform = reader->deform;
	for (uint32_t v = 0; v < reader->vertex_count; v++) {
		float j[4], w[4];
		gltf_accessor_read(joints, reader->source[v], j);
		gltf_accessor_read(weights, reader->source[v], w);
		size_t at = (size_t)v * deform->influences + 4ull * set;
		for (int i = 0; i < 4; i++) {
			if (!(w[i] <= 1e9f) || !(j[i] >= 0.0f && j[i] <= 65535.0f))
				return stilb_fail(STILB_ERROR_FILE, "vertex %u has joint %g with weight %g", reader->source[v],
				                  (double)j[i], (double)w[i]);
			bool used = w[i] > 0.0f; /* programs write anything as the joint of a weight of 0 */
			deform->joints[at + (size_t)i] = used ? (uint16_t)j[i] : 0;
			deform->weights[at + (size_t)i] = used ? w[i] : 0.0f;
		}
	}
	return STILB_OK;
}

static stilb_result deform_read_set(const deform_reader *reader, uint32_t set)
{
	gltf_accessor joints, weights;
	if (set == 0 && reader->packed[0].components && reader->packed[1].components)
		return deform_fill_set(reader, set, &reader->packed[0], &reader->packed[1]);
	stilb_result result = deform_open(reader, "JOINTS", set, &joints);
	if (result != STILB_OK)
		return result;
	result = deform_open(reader, "WEIGHTS", set, &weights);
	if (result == STILB_OK && (joints.normalized || !joints.components || !weights.components))
		result = stilb_fail(STILB_ERROR_FILE, "JOINTS_%u and WEIGHTS_%u do not go together", set, set);
	if (result == STILB_OK)
		result = deform_fill_set(reader, set, &joints, &weights);
	gltf_accessor_finish(&joints);
	gltf_accessor_finish(&weights);
	return result;
}

/* The number of sets that follow one another from 0 on. */
static uint32_t deform_count_sets(const deform_reader *reader)
{
	uint32_t sets = 0;
	char key[24] = "JOINTS_0";
	while (sets < DEFORM_SETS && scene_json_member(&reader->from->json, reader->names, key) != GLTF_NONE)
		snprintf(key, sizeof key, "JOINTS_%u", ++sets);
	return sets;
}

/* ---- morph targets ----------------------------------------------------------------------------------------------- */

/* Writes what a target adds to an attribute of each vertex; nothing if it has no such attribute. */
static stilb_result deform_read_attribute(const deform_reader *reader, uint32_t target, const char *name, float *out)
{
	gltf *from = reader->from;
	gltf_accessor accessor;
	uint32_t index = gltf_reference(from, target, name, GLTF_ACCESSORS);
	if (index == GLTF_NONE)
		return scene_json_check(&from->json);
	stilb_result result = gltf_accessor_open(from, index, 1u << 2, &accessor);
	if (result == STILB_OK && accessor.count < reader->file_count)
		result = stilb_fail(STILB_ERROR_FILE, "accessor %u has too few elements", index);
	float sum = 0.0f;
	for (uint32_t v = 0; result == STILB_OK && v < reader->vertex_count; v++) {
		gltf_accessor_read(&accessor, reader->source[v], out + 3ull * v);
		for (int i = 0; i < 3; i++)
			sum += out[3ull * v + (size_t)i] * 0.0f; /* NaN for NaN and infinity */
	}
	if (result == STILB_OK && sum != 0.0f)
		result = stilb_fail(STILB_ERROR_FILE, "accessor %u is NaN or infinite somewhere", index);
	gltf_accessor_finish(&accessor);
	return result;
}

static stilb_result deform_read_targets(const deform_reader *reader, uint32_t targets)
{
	scene_json *json = &reader->from->json;
	stilb_scene_deform *deform = reader->deform;
	stilb_result result = scene_json_check(json);
	uint32_t count = 0;
	for (uint32_t at = scene_json_first(json, targets); result == STILB_OK && at != GLTF_NONE;
	     at = scene_json_after(json, targets, at), count++) {
		size_t first = 3ull * count * reader->vertex_count;
		result = deform_read_attribute(reader, at, "POSITION", deform->positions + first);
		if (result == STILB_OK && deform->normals)
			result = deform_read_attribute(reader, at, "NORMAL", deform->normals + first);
		if (result == STILB_OK && deform->tangents)
			result = deform_read_attribute(reader, at, "TANGENT", deform->tangents + first);
	}
	return result;
}

/* True if the mesh has the tangents of the file. Those that were made here, where the file has none, or no normals, are
 * no base for what a target adds. glTF 2.0, 3.7.2.1 and 3.7.2.2. */
static bool deform_has_tangents(const deform_reader *reader, const stilb_scene_mesh *mesh)
{
	scene_json *json = &reader->from->json;
	bool found = false;
	for (uint32_t v = 0; mesh->extras && v < mesh->vertex_count && !found; v++)
		found = mesh->extras[v].tangent[3] != 0.0f;
	return found && scene_json_member(json, reader->names, "TANGENT") != GLTF_NONE &&
	       scene_json_member(json, reader->names, "NORMAL") != GLTF_NONE;
}

/* The number of targets; *normals, *tangents: one of them changes these. */
static uint32_t deform_count_targets(const deform_reader *reader, uint32_t targets, bool *normals, bool *tangents)
{
	scene_json *json = &reader->from->json;
	uint32_t count = 0;
	*normals = *tangents = false;
	for (uint32_t at = scene_json_first(json, targets); at != GLTF_NONE; at = scene_json_after(json, targets, at)) {
		*normals |= scene_json_member(json, at, "NORMAL") != GLTF_NONE;
		*tangents |= scene_json_member(json, at, "TANGENT") != GLTF_NONE;
		count++;
	}
	return count;
}

/* ---- all --------------------------------------------------------------------------------------------------------- */

static stilb_result deform_read(deform_reader *reader, uint32_t sets, uint32_t targets, const stilb_scene_mesh *mesh)
{
	bool normals, tangents;
	stilb_scene_deform *deform = reader->deform;
	*deform = (stilb_scene_deform){.influences = 4 * sets,
	                               .targets = deform_count_targets(reader, targets, &normals, &tangents)};
	tangents = tangents && deform_has_tangents(reader, mesh);
	uint64_t each = 3ull * (1u + normals + tangents); /* numbers of a target for a vertex */
	uint64_t numbers = reader->vertex_count * (2ull * deform->influences + each * deform->targets);
	if (numbers > IMPORTER_MOVING_MOST - reader->from->moving)
		return stilb_fail(STILB_ERROR_FILE, "%u morph targets of %u vertices are too many", deform->targets,
		                  reader->vertex_count);
	reader->from->moving += numbers;
	stilb_result result = scene_deform_create(deform, reader->vertex_count, normals, tangents);
	for (uint32_t set = 0; result == STILB_OK && set < sets; set++)
		result = deform_read_set(reader, set);
	return result == STILB_OK ? deform_read_targets(reader, targets) : result;
}

stilb_result gltf_deform_read(gltf *from, const uint32_t *source, const gltf_accessor packed[2], const char *name,
                              gltf_part *part)
{
	scene_json *json = &from->json;
	deform_reader reader = {.from = from,
	                        .source = source,
	                        .packed = packed,
	                        .vertex_count = part->mesh.vertex_count,
	                        .item = part->item,
	                        .names = scene_json_member(json, part->item, "attributes"),
	                        .deform = &part->deform};
	uint32_t sets = from->lists[GLTF_SKINS].count > 0 ? deform_count_sets(&reader) : 0;
	uint32_t targets = scene_json_array(json, part->item, "targets");
	stilb_result result = scene_json_check(json);
	if (result == STILB_OK && sets == 0 && scene_json_first(json, targets) == GLTF_NONE)
		return STILB_OK;
	for (uint32_t v = 0; v < reader.vertex_count; v++)
		reader.file_count = source[v] >= reader.file_count ? source[v] + 1 : reader.file_count;
	if (result == STILB_OK)
		result = deform_read(&reader, sets, targets, &part->mesh);
	if (result == STILB_OK)
		return STILB_OK;
	scene_deform_finish(&part->deform);
	part->deform = (stilb_scene_deform){0};
	return gltf_leave_out(from, result, IMPORTER_LOSS_BAD_DEFORMS, name);
}
