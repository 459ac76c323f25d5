/* What changes the shape of one of Assimp's meshes: its bones and morph targets. */
#include "scene/importer/importer_motion.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define INFLUENCES_MOST 32u /* of a vertex, as glTF's are read */

typedef struct influence {
	float weight;
	uint32_t joint;
} influence;

/* The influences of the vertices of a mesh of Assimp's: of vertex v all[first[v]] .. all[first[v + 1] - 1], the
 * INFLUENCES_MOST of the most weight first. */
typedef struct influence_list {
	uint32_t *first; /* [vertices + 1] */
	influence *all;
	uint32_t most; /* of a vertex */
} influence_list;

/* A mesh whose deform is read. */
typedef struct influence_reader {
	importer *import;
	const struct aiMesh *from;
	uint32_t m;             /* from is this one of Assimp's */
	const uint32_t *source; /* [vertices of the mesh] those of the file, or NULL: the same */
	bool flipped;
	stilb_scene_mesh *mesh;
	stilb_scene_deform *deform;
} influence_reader;

static uint32_t influence_source(const influence_reader *reader, uint32_t v)
{
	return reader->source ? reader->source[v] : v;
}

/* ---- bones ------------------------------------------------------------------------------------------------------- */

/* Sorts the influences of a vertex, as many as may be: those behind them are none any more. */
static void influence_sort(influence *all, uint32_t count)
{
	uint32_t kept = 0;
	for (uint32_t i = 0; i < count; i++) {
		influence one = all[i];
		uint32_t at = kept;
		while (at > 0 && all[at - 1].weight < one.weight)
			at--;
		if (at == INFLUENCES_MOST)
			continue;
		kept += kept < INFLUENCES_MOST;
		memmove(&all[at + 1], &all[at], (kept - 1 - at) * sizeof *all);
		all[at] = one;
	}
}

/* The bones were checked when the skins were planned. */
static stilb_result influence_list_make(const influence_reader *reader, const importer_skin *skin, influence_list *list)
{
	const importer_motion *motion = reader->import->motion;
	const struct aiMesh *from = reader->from;
	const uint32_t *joint_of = motion->joint_of + motion->first_bone[reader->m];
	uint64_t count = 0, vertices = from->mNumVertices;
	for (uint32_t b = 0; b < from->mNumBones; b++)
		count += joint_of[b] == STILB_SCENE_NONE ? 0 : from->mBones[b]->mNumWeights;
	list->first = count < UINT32_MAX ? calloc(vertices + 1, sizeof *list->first) : NULL;
	list->all = list->first ? malloc((count + 1) * sizeof *list->all) : NULL;
	if (!list->all)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the skin of %u vertices", from->mNumVertices);
	for (int pass = 0; pass < 2; pass++) {
		for (uint32_t b = 0; b < from->mNumBones; b++)
			for (uint32_t w = 0; joint_of[b] != STILB_SCENE_NONE && w < from->mBones[b]->mNumWeights; w++) {
				const struct aiVertexWeight *weight = &from->mBones[b]->mWeights[w];
				if (!(weight->mWeight > 0.0f))
					continue;
				uint32_t place = list->first[weight->mVertexId + 1]++;
				if (pass == 1)
					list->all[place] = (influence){weight->mWeight, joint_of[b] + skin->with_node};
			}
		/* The first pass counts: then each vertex's first place stands behind its number, and moves to its end. */
		uint32_t before = 0;
		for (uint64_t v = 0; pass == 0 && v < vertices; v++) {
			uint32_t own = list->first[v + 1];
			list->first[v + 1] = before;
			before += own;
		}
	}
	for (uint32_t v = 0; v < vertices; v++) {
		uint32_t own = list->first[v + 1] - list->first[v];
		list->most = own > list->most ? own : list->most;
		influence_sort(list->all + list->first[v], own);
	}
	return STILB_OK;
}

static void influence_write(const influence_reader *reader, const influence_list *list)
{
	stilb_scene_deform *deform = reader->deform;
	for (uint32_t v = 0; v < reader->mesh->vertex_count; v++) {
		uint32_t from = influence_source(reader, v), count = list->first[from + 1] - list->first[from];
		const influence *own = &list->all[list->first[from]];
		size_t at = (size_t)v * deform->influences;
		for (uint32_t i = 0; i < count && i < INFLUENCES_MOST; i++) {
			deform->joints[at + i] = (uint16_t)own[i].joint;
			deform->weights[at + i] = own[i].weight;
		}
		if (count == 0)
			deform->weights[at] = 1.0f; /* joint 0 is the node itself */
	}
}

/* ---- morph targets ----------------------------------------------------------------------------------------------- */

/* True if targets of this mesh can be read. False, with the reason: they are damaged. */
static bool influence_targets_are_sound(const influence_reader *reader, char why[static 192])
{
	const struct aiMesh *from = reader->from;
	for (uint32_t t = 0; t < from->mNumAnimMeshes; t++) {
		const struct aiAnimMesh *target = from->mAnimMeshes ? from->mAnimMeshes[t] : NULL;
		if (target && target->mNumVertices == from->mNumVertices)
			continue;
		snprintf(why, 192, "%.63s: morph target %u has %u vertices of %u", from->mName.data, t,
		         target ? target->mNumVertices : 0, from->mNumVertices);
		return false;
	}
	return true;
}

/* Assimp's targets are where vertices go to, not how far. False: a number is NaN or infinite. */
static bool influence_read_target(const influence_reader *reader, uint32_t t)
{
	const struct aiAnimMesh *target = reader->from->mAnimMeshes[t];
	const stilb_scene_mesh *mesh = reader->mesh;
	float sum = 0.0f, side = reader->flipped ? -1.0f : 1.0f;
	for (uint32_t v = 0; v < mesh->vertex_count; v++) {
		uint32_t from = influence_source(reader, v);
		size_t at = 3 * ((size_t)t * mesh->vertex_count + v);
		stilb_vec3 zero = {0}, to = target->mVertices ? importer_vector(&target->mVertices[from]) : zero;
		stilb_vec3 normal = target->mNormals ? importer_vector(&target->mNormals[from]) : zero;
		float length = sqrtf(stilb_vec3_dot(normal, normal));
		for (int k = 0; k < 3; k++) {
			if (target->mVertices)
				reader->deform->positions[at + (size_t)k] = to[k] - mesh->vertices[v].position[k];
			sum += reader->deform->positions[at + (size_t)k] * 0.0f; /* NaN for NaN and infinity */
			if (reader->deform->normals && length > 1e-18f && length < 1e18f)
				reader->deform->normals[at + (size_t)k] = side * normal[k] / length - mesh->vertices[v].normal[k];
		}
	}
	return sum == 0.0f;
}

/* ---- joining vertices -------------------------------------------------------------------------------------------- */

/* Two vertices and all that is known of them. */
static bool influence_same(const influence_reader *reader, uint32_t a, uint32_t b)
{
	const stilb_scene_mesh *mesh = reader->mesh;
	const stilb_scene_deform *d = reader->deform;
	if (memcmp(&mesh->vertices[a], &mesh->vertices[b], sizeof *mesh->vertices) != 0 ||
	    (mesh->extras && memcmp(&mesh->extras[a], &mesh->extras[b], sizeof *mesh->extras) != 0))
		return false;
	size_t own = d->influences, i = own * a, k = own * b;
	if (own > 0 && (memcmp(d->joints + i, d->joints + k, own * sizeof *d->joints) != 0 ||
	                memcmp(d->weights + i, d->weights + k, own * sizeof *d->weights) != 0))
		return false;
	for (uint32_t t = 0; t < d->targets; t++) {
		size_t first = (size_t)t * mesh->vertex_count;
		if (memcmp(d->positions + 3 * (first + a), d->positions + 3 * (first + b), 12) != 0 ||
		    (d->normals && memcmp(d->normals + 3 * (first + a), d->normals + 3 * (first + b), 12) != 0))
			return false;
	}
	return true;
}

/* The vertices that triangles use, without repeats: kept lists them, and indices are theirs. Returns their number. */
static uint32_t influence_find_same(const influence_reader *reader, uint32_t *table, uint64_t mask, uint32_t *place,
                                    uint32_t *kept)
{
	stilb_scene_mesh *mesh = reader->mesh;
	uint32_t count = 0;
	for (uint32_t v = 0; v < mesh->vertex_count; v++)
		place[v] = UINT32_MAX;
	for (uint32_t i = 0; i < mesh->index_count; i++)
		place[mesh->indices[i]] = 0;
	for (uint32_t v = 0; v < mesh->vertex_count; v++) {
		if (place[v] == UINT32_MAX)
			continue; /* no triangle uses it */
		uint64_t slot = stilb_hash_fnv1a64(STILB_FNV1A64_START, &mesh->vertices[v], sizeof *mesh->vertices) & mask;
		while (table[slot] && !influence_same(reader, v, kept[table[slot] - 1]))
			slot = (slot + 1) & mask;
		if (!table[slot]) {
			kept[count] = v;
			table[slot] = ++count;
		}
		place[v] = table[slot] - 1;
	}
	for (uint32_t i = 0; i < mesh->index_count; i++)
		mesh->indices[i] = place[mesh->indices[i]];
	return count;
}

/* Moves the numbers of the kept vertices, [count] in ascending order, to the beginning of each block of an array. */
static void influence_pack(void *array, size_t size, uint32_t blocks, uint32_t old, const uint32_t *kept,
                           uint32_t count)
{
	for (uint32_t b = 0; array && b < blocks; b++)
		for (uint32_t v = 0; v < count; v++)
			memmove((char *)array + size * ((size_t)b * count + v), (char *)array + size * ((size_t)b * old + kept[v]),
			        size);
}

/* Assimp's step for this does not look at bones: it is left out for scenes that have any. */
static stilb_result influence_join(const influence_reader *reader)
{
	stilb_scene_mesh *mesh = reader->mesh;
	stilb_scene_deform *d = reader->deform;
	uint32_t old = mesh->vertex_count;
	uint64_t slots = 64;
	while (slots < 2ull * old)
		slots *= 2;
	uint32_t *table = calloc(slots, sizeof *table);
	uint32_t *place = malloc((old + 1ull) * sizeof *place), *kept = malloc((old + 1ull) * sizeof *kept);
	if (table && place && kept) {
		uint32_t count = influence_find_same(reader, table, slots - 1, place, kept);
		influence_pack(mesh->vertices, sizeof *mesh->vertices, 1, old, kept, count);
		influence_pack(mesh->extras, sizeof *mesh->extras, 1, old, kept, count);
		influence_pack(d->joints, d->influences * sizeof *d->joints, 1, old, kept, count);
		influence_pack(d->weights, d->influences * sizeof *d->weights, 1, old, kept, count);
		influence_pack(d->positions, 3 * sizeof *d->positions, d->targets, old, kept, count);
		influence_pack(d->normals, 3 * sizeof *d->normals, d->targets, old, kept, count);
		mesh->vertex_count = count;
	}
	bool good = table && place && kept;
	free(table);
	free(place);
	free(kept);
	return good ? STILB_OK : stilb_fail(STILB_ERROR_MEMORY, "no memory to join %u vertices", old);
}

/* ---- all --------------------------------------------------------------------------------------------------------- */

static stilb_result influence_read(influence_reader *reader, const importer_skin *skin, bool targets)
{
	importer *import = reader->import;
	const struct aiMesh *from = reader->from;
	stilb_scene_deform *deform = reader->deform;
	influence_list list = {0};
	bool normals = false;
	stilb_result result = skin ? influence_list_make(reader, skin, &list) : STILB_OK;
	if (list.most > INFLUENCES_MOST)
		importer_lose(import, IMPORTER_LOSS_INFLUENCES, from->mName.data);
	uint32_t most = list.most > INFLUENCES_MOST ? INFLUENCES_MOST : list.most ? list.most : 1;
	*deform = (stilb_scene_deform){.influences = skin ? (most + 3) / 4 * 4 : 0,
	                               .targets = targets ? from->mNumAnimMeshes : 0};
	for (uint32_t t = 0; t < deform->targets; t++)
		normals |= from->mAnimMeshes[t]->mNormals && !import->shares;
	uint64_t each = normals ? 6 : 3, vertices = reader->mesh->vertex_count;
	if (result == STILB_OK)
		result = importer_count_moving(import, vertices * (2ull * deform->influences + each * deform->targets));
	if (result == STILB_OK)
		result = scene_deform_create(deform, reader->mesh->vertex_count, normals, false);
	if (result == STILB_OK && skin)
		influence_write(reader, &list);
	for (uint32_t t = 0; result == STILB_OK && t < deform->targets; t++)
		if (!influence_read_target(reader, t))
			result = stilb_fail(STILB_ERROR_FILE, "morph target %u is NaN or infinite somewhere", t);
	free(list.first);
	free(list.all);
	return result;
}

stilb_result importer_read_deform(importer *import, uint32_t m, const uint32_t *source, bool flipped, uint32_t place,
                                  stilb_scene_mesh *mesh)
{
	importer_motion *motion = import->motion;
	const struct aiMesh *from = import->from->mMeshes[m];
	influence_reader reader = {.import = import,
	                           .from = from,
	                           .m = m,
	                           .source = source,
	                           .flipped = flipped,
	                           .mesh = mesh,
	                           .deform = &motion->deforms[place]};
	char why[192];
	uint32_t number = motion->skin_of[m];
	bool targets = from->mNumAnimMeshes > 0;
	if (targets && !influence_targets_are_sound(&reader, why)) {
		importer_lose(import, IMPORTER_LOSS_BAD_DEFORMS, why);
		targets = false;
	}
	stilb_result result = STILB_OK;
	if (number > 0 || targets)
		result = influence_read(&reader, number > 0 ? &motion->skins[number - 1] : NULL, targets);
	if (result != STILB_OK && result != STILB_ERROR_MEMORY) {
		snprintf(why, sizeof why, "%.63s: %.120s", from->mName.data, stilb_error_message());
		importer_lose(import, IMPORTER_LOSS_BAD_DEFORMS, why);
		result = STILB_OK;
		scene_deform_finish(reader.deform);
		*reader.deform = (stilb_scene_deform){0};
	}
	if (reader.deform->influences > 0 || reader.deform->targets > 0)
		motion->deform_from[place] = from;
	return result == STILB_OK && import->joins ? influence_join(&reader) : result;
}
