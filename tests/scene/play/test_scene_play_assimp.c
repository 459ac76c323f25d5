/*
 * The animated files of Debian's package assimp-testmodels, corner by corner of all their triangles, beside what
 * Assimp's own data say in double precision: the importer loses no bone, no key and no axis on the way. This test reads
 * the files by Assimp itself, as nothing else outside of the import process does. And a file with a morph target, which
 * none of these has: Assimp writes it.
 */
#include "scene/edit/scene_node.h"
#include "scene/play/scene_play.h"
#include "scene/scene_internal.h"
#include "support/folder.h"
#include "support/test.h"

#include <assimp/cexport.h>
#include <assimp/cimport.h>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fts.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

#define MODELS "/usr/share/assimp/models"

/* A matrix of rows, as Assimp's. */
typedef struct rows {
	double m[4][4];
} rows;

static rows rows_of(const struct aiMatrix4x4 *from)
{
	const float *a = &from->a1;
	rows out;
	for (int i = 0; i < 16; i++)
		out.m[i / 4][i % 4] = (double)a[i];
	return out;
}

static rows product(const rows *a, const rows *b)
{
	rows out = {{{0}}};
	for (int r = 0; r < 4; r++)
		for (int c = 0; c < 4; c++)
			for (int k = 0; k < 4; k++)
				out.m[r][c] += a->m[r][k] * b->m[k][c];
	return out;
}

static void carry(const rows *m, const struct aiVector3D *p, double out[3])
{
	for (int r = 0; r < 3; r++)
		out[r] = m->m[r][0] * (double)p->x + m->m[r][1] * (double)p->y + m->m[r][2] * (double)p->z + m->m[r][3];
}

/* ---- keys -------------------------------------------------------------------------------------------------------- */

static double key_time(const void *keys, size_t size, uint32_t k)
{
	return *(const double *)(const void *)((const char *)keys + k * size);
}

/* The key at or before a time, and how far it is to the next. */
static uint32_t find_key(const void *keys, size_t size, uint32_t count, double ticks, double *share)
{
	uint32_t k = 0;
	*share = 0.0;
	while (k + 1 < count && key_time(keys, size, k + 1) <= ticks)
		k++;
	double at = key_time(keys, size, k);
	if (k + 1 < count && ticks > at)
		*share = (ticks - at) / (key_time(keys, size, k + 1) - at);
	return k;
}

static void vector_at(const struct aiVectorKey *keys, uint32_t count, double ticks, double out[3])
{
	double share;
	uint32_t k = find_key(keys, sizeof *keys, count, ticks, &share), next = k + 1 < count ? k + 1 : k;
	const struct aiVector3D *a = &keys[k].mValue, *b = &keys[next].mValue;
	out[0] = (double)a->x + share * ((double)b->x - (double)a->x);
	out[1] = (double)a->y + share * ((double)b->y - (double)a->y);
	out[2] = (double)a->z + share * ((double)b->z - (double)a->z);
}

/* w, x, y, z, unit. */
static void turn_at(const struct aiQuatKey *keys, uint32_t count, double ticks, double out[4])
{
	double share, dot = 0.0, q[2][4], sum = 0.0;
	uint32_t k = find_key(keys, sizeof *keys, count, ticks, &share), next = k + 1 < count ? k + 1 : k;
	for (int i = 0; i < 2; i++) {
		const struct aiQuaternion *from = &keys[i ? next : k].mValue;
		const double own[4] = {(double)from->w, (double)from->x, (double)from->y, (double)from->z};
		double length = sqrt(own[0] * own[0] + own[1] * own[1] + own[2] * own[2] + own[3] * own[3]);
		for (int c = 0; c < 4; c++)
			q[i][c] = own[c] / length;
	}
	for (int c = 0; c < 4; c++)
		dot += q[0][c] * q[1][c];
	double angle = acos(fmin(fabs(dot), 1.0)), sine = sin(angle), side = dot < 0.0 ? -1.0 : 1.0;
	for (int c = 0; c < 4; c++) {
		out[c] =
			sine > 1e-9 ? (sin((1 - share) * angle) * q[0][c] + side * sin(share * angle) * q[1][c]) / sine : q[0][c];
		sum += out[c] * out[c];
	}
	for (int c = 0; c < 4; c++)
		out[c] /= sqrt(sum);
}

/* The matrix of a node that a channel moves; what it has no keys of is as at rest. */
static rows place_at(const struct aiNode *node, const struct aiNodeAnim *channel, double ticks)
{
	struct aiVector3D scale, position;
	struct aiQuaternion rotation;
	aiDecomposeMatrix(&node->mTransformation, &scale, &rotation, &position);
	double t[3] = {(double)position.x, (double)position.y, (double)position.z};
	double s[3] = {(double)scale.x, (double)scale.y, (double)scale.z};
	double q[4] = {(double)rotation.w, (double)rotation.x, (double)rotation.y, (double)rotation.z};
	if (channel->mNumPositionKeys > 0)
		vector_at(channel->mPositionKeys, channel->mNumPositionKeys, ticks, t);
	if (channel->mNumScalingKeys > 0)
		vector_at(channel->mScalingKeys, channel->mNumScalingKeys, ticks, s);
	if (channel->mNumRotationKeys > 0)
		turn_at(channel->mRotationKeys, channel->mNumRotationKeys, ticks, q);
	double w = q[0], x = q[1], y = q[2], z = q[3];
	return (rows){{{(1 - 2 * (y * y + z * z)) * s[0], 2 * (x * y - z * w) * s[1], 2 * (x * z + y * w) * s[2], t[0]},
	               {2 * (x * y + z * w) * s[0], (1 - 2 * (x * x + z * z)) * s[1], 2 * (y * z - x * w) * s[2], t[1]},
	               {2 * (x * z - y * w) * s[0], 2 * (y * z + x * w) * s[1], (1 - 2 * (x * x + y * y)) * s[2], t[2]},
	               {0, 0, 0, 1}}};
}

/* ---- a scene of Assimp's ----------------------------------------------------------------------------------------- */

/* Its nodes, breadth first, with their places at a time. */
typedef struct hierarchy {
	const struct aiNode **nodes;
	uint32_t *parents;
	rows *to_world;
	uint32_t count;
} hierarchy;

static uint32_t count_nodes(const struct aiNode *node)
{
	uint32_t count = 1;
	for (uint32_t c = 0; c < node->mNumChildren; c++)
		count += count_nodes(node->mChildren[c]);
	return count;
}

static hierarchy list_nodes(const struct aiScene *from)
{
	uint32_t all = count_nodes(from->mRootNode);
	hierarchy h = {.nodes = calloc(all, sizeof(const struct aiNode *)),
	               .parents = calloc(all, sizeof *h.parents),
	               .to_world = calloc(all, sizeof *h.to_world),
	               .count = 1};
	h.nodes[0] = from->mRootNode;
	for (uint32_t n = 0; n < h.count; n++)
		for (uint32_t c = 0; c < h.nodes[n]->mNumChildren; c++) {
			const struct aiNode *child = h.nodes[n]->mChildren[c];
			uint32_t parent = h.count - 1; /* what is listed with it, as Half-Life's bones are, or what lists it */
			while (parent > n && h.nodes[parent] != child->mParent)
				parent--;
			h.parents[h.count] = parent;
			h.nodes[h.count++] = child;
		}
	assert_int_equal(h.count, all);
	return h;
}

static uint32_t find_node(const hierarchy *h, const char *name)
{
	for (uint32_t n = 0; n < h->count; n++)
		if (strcmp(h->nodes[n]->mName.data, name) == 0)
			return n;
	return UINT32_MAX;
}

/* axes: from the file's to ours. */
static void place_nodes(hierarchy *h, const struct aiAnimation *animation, double ticks, const rows *axes)
{
	const struct aiNodeAnim **channels = calloc(h->count, sizeof(const struct aiNodeAnim *));
	for (uint32_t c = animation->mNumChannels; c-- > 0;) { /* the first counts */
		uint32_t node = find_node(h, animation->mChannels[c]->mNodeName.data);
		if (node != UINT32_MAX)
			channels[node] = animation->mChannels[c];
	}
	for (uint32_t n = 0; n < h->count; n++) {
		rows local = channels[n] ? place_at(h->nodes[n], channels[n], ticks) : rows_of(&h->nodes[n]->mTransformation);
		h->to_world[n] = product(n ? &h->to_world[h->parents[n]] : axes, &local);
	}
	free(channels);
}

/* Where the vertices of a mesh are that a node shows, [mNumVertices][3]. */
static double *pose_mesh(const hierarchy *h, const struct aiMesh *mesh, uint32_t node)
{
	double *out = calloc(3ull * mesh->mNumVertices + 1, sizeof *out),
		   *sums = calloc(mesh->mNumVertices + 1ull, sizeof *sums);
	for (uint32_t b = 0; b < mesh->mNumBones; b++) {
		const struct aiBone *bone = mesh->mBones[b];
		uint32_t joint = find_node(h, bone->mName.data);
		if (joint == UINT32_MAX)
			continue;
		rows bind = rows_of(&bone->mOffsetMatrix), place = product(&h->to_world[joint], &bind);
		for (uint32_t w = 0; w < bone->mNumWeights; w++) {
			uint32_t v = bone->mWeights[w].mVertexId;
			double weight = (double)bone->mWeights[w].mWeight, at[3];
			carry(&place, &mesh->mVertices[v], at);
			for (int k = 0; k < 3; k++)
				out[3 * v + (uint32_t)k] += weight * at[k];
			sums[v] += weight;
		}
	}
	for (uint32_t v = 0; v < mesh->mNumVertices; v++) {
		if (!(sums[v] > 0.0))
			carry(&h->to_world[node], &mesh->mVertices[v], out + 3 * v);
		for (uint32_t k = 0; sums[v] > 0.0 && k < 3; k++)
			out[3 * v + k] /= sums[v];
	}
	free(sums);
	return out;
}

/* ---- comparing --------------------------------------------------------------------------------------------------- */

typedef struct corners_found {
	double worst, low[3], high[3];
	uint64_t corners;
} corners_found;

static double corner_error(const stilb_scene *scene, uint32_t part, uint32_t index, const double wanted[3])
{
	const stilb_scene_mesh *mesh = &scene->meshes[scene->part_mesh[part]];
	const float *p = mesh->vertices[mesh->indices[index]].position, *m = scene->part_transform[part].m;
	double sum = 0.0;
	for (int r = 0; r < 3; r++) {
		double at = (double)m[12 + r];
		for (int c = 0; c < 3; c++)
			at += (double)m[4 * c + r] * (double)p[c];
		sum += (at - wanted[r]) * (at - wanted[r]);
	}
	return sqrt(sum);
}

/* Compares the triangles of a part; corners 1 and 2 of all may have changed places. */
static void compare_part(const stilb_scene *scene, uint32_t part, const struct aiMesh *mesh, const double *places,
                         corners_found *found)
{
	double worst[2] = {0, 0};
	uint32_t index = 0, count = scene->meshes[scene->part_mesh[part]].index_count;
	for (uint32_t f = 0; f < mesh->mNumFaces; f++) {
		if (mesh->mFaces[f].mNumIndices != 3)
			continue;
		assert_true(index + 3 <= count);
		for (uint32_t i = 0; i < 3; i++) {
			const double *wanted = places + 3ull * mesh->mFaces[f].mIndices[i];
			worst[0] = fmax(worst[0], corner_error(scene, part, index + i, wanted));
			worst[1] = fmax(worst[1], corner_error(scene, part, index + (3 - i) % 3, wanted));
			for (int k = 0; k < 3; k++) {
				found->low[k] = fmin(found->low[k], wanted[k]);
				found->high[k] = fmax(found->high[k], wanted[k]);
			}
		}
		index += 3;
	}
	assert_int_equal(index, count);
	found->worst = fmax(found->worst, fmin(worst[0], worst[1]));
	found->corners += count;
}

static bool has_triangles(const struct aiMesh *mesh)
{
	for (uint32_t f = 0; f < mesh->mNumFaces; f++)
		if (mesh->mFaces[f].mNumIndices == 3)
			return true;
	return false;
}

/* The largest distance of all corners, as a share of the diagonal. */
static double compare(const stilb_scene *scene, const struct aiScene *from, const hierarchy *h, uint64_t *corners)
{
	corners_found found = {.low = {1e30, 1e30, 1e30}, .high = {-1e30, -1e30, -1e30}};
	uint32_t part = 0;
	for (uint32_t n = 0; n < h->count; n++)
		for (uint32_t i = 0; i < h->nodes[n]->mNumMeshes; i++) {
			const struct aiMesh *mesh = from->mMeshes[h->nodes[n]->mMeshes[i]];
			if (!has_triangles(mesh))
				continue;
			double *places = pose_mesh(h, mesh, n);
			compare_part(scene, part++, mesh, places, &found);
			free(places);
		}
	assert_int_equal(part, scene->part_count);
	*corners += found.corners;
	double square = 0.0;
	for (int k = 0; k < 3; k++)
		square += (found.high[k] - found.low[k]) * (found.high[k] - found.low[k]);
	return found.worst / sqrt(square);
}

/* ---- files ------------------------------------------------------------------------------------------------------- */

/* The same steps as in the import process. */
static const struct aiScene *read_file(const char *path)
{
	unsigned steps = aiProcess_Triangulate | aiProcess_SortByPType | aiProcess_GenSmoothNormals |
	                 aiProcess_GenUVCoords | aiProcess_TransformUVCoords | aiProcess_FlipUVs |
	                 aiProcess_RemoveComponent;
	struct aiPropertyStore *properties = aiCreatePropertyStore();
	aiSetImportPropertyInteger(properties, AI_CONFIG_PP_RVC_FLAGS, aiComponent_TANGENTS_AND_BITANGENTS);
	aiSetImportPropertyFloat(properties, AI_CONFIG_PP_GSN_MAX_SMOOTHING_ANGLE, 60.0f);
	const struct aiScene *from = aiImportFileExWithProperties(path, 0, NULL, properties);
	aiReleasePropertyStore(properties);
	bool deforms = false;
	for (uint32_t m = 0; from && m < from->mNumMeshes; m++)
		deforms |= from->mMeshes[m]->mNumBones > 0 || from->mMeshes[m]->mNumAnimMeshes > 0;
	if (!deforms)
		steps |= aiProcess_JoinIdenticalVertices | aiProcess_ImproveCacheLocality;
	return from ? aiApplyPostProcessing(from, steps) : NULL;
}

/* The axes of the file in ours, from what the importer made of the root at rest. */
static rows find_axes(const stilb_scene *scene, const struct aiScene *from)
{
	struct aiMatrix4x4 inverse = from->mRootNode->mTransformation;
	aiMatrix4Inverse(&inverse);
	const float *m = scene->animation->nodes[0].local.m;
	rows own = {{{0}}}, back = rows_of(&inverse);
	for (int r = 0; r < 4; r++)
		for (int c = 0; c < 4; c++)
			own.m[r][c] = (double)m[4 * c + r];
	rows axes = product(&own, &back);
	for (int i = 0; i < 16; i++)
		axes.m[i / 4][i % 4] = rint(axes.m[i / 4][i % 4]); /* -1, 0 or 1 */
	return axes;
}

static bool may_move(const char *path)
{
	static const char *const ends[] = {".3ds", ".ase", ".b3d", ".bvh",     ".csm",  ".dae", ".fbx", ".iqm", ".irr",
	                                   ".lws", ".m3d", ".mdl", ".md5mesh", ".ms3d", ".smd", ".x",   ".zae"};
	const char *dot = strrchr(path, '.');
	for (size_t i = 0; dot && i < sizeof ends / sizeof *ends; i++)
		if (strcasecmp(dot, ends[i]) == 0)
			return true;
	return false;
}

/* Plays the clips of a file that both have. Returns how many there are. */
static uint32_t play_file(const char *path, stilb_scene *scene, const struct aiScene *from, double *most,
                          uint64_t *corners)
{
	const stilb_scene_animation *a = scene->animation;
	rows axes = find_axes(scene, from);
	hierarchy h = list_nodes(from);
	uint32_t played = 0, clip = 0;
	assert_int_equal(h.count, a->node_count);
	for (uint32_t i = 0; i < from->mNumAnimations && clip < a->clip_count; i++) {
		const struct aiAnimation *animation = from->mAnimations[i];
		if (animation->mName.length > 0 && strncmp(animation->mName.data, a->clips[clip].name, 63) != 0)
			continue; /* it was left out */
		double second = animation->mTicksPerSecond > 0.0 ? animation->mTicksPerSecond : 25.0;
		for (int t = 0; t < 4; t++) {
			stilb_scene_play play = stilb_scene_play_make(clip);
			play.time = (double)a->clips[clip].duration * (0.07 + 0.31 * t);
			play.repeat = STILB_SCENE_ONCE;
			place_nodes(&h, animation, play.time * second, &axes);
			assert_int_equal(stilb_scene_rest_figure(scene, 0), STILB_OK);
			assert_int_equal(stilb_scene_set_plays(scene, 0, &play, 1), STILB_OK);
			stilb_scene_advance(scene, 0.0, NULL, 0);
			stilb_scene_update_nodes(scene, NULL, 0);
			double error = compare(scene, from, &h, corners);
			if (!(error <= 1e-5))
				fail_msg("%s, '%s' at %g s: corners are %g of the size away", path, a->clips[clip].name, play.time,
				         error);
			*most = fmax(*most, error);
		}
		clip++;
		played++;
	}
	assert_int_equal(clip, a->clip_count);
	free(h.nodes);
	free(h.parents);
	free(h.to_world);
	return played;
}

static void files_move_as_assimp_says(void **state)
{
	(void)state;
	char *roots[] = {MODELS, NULL};
	FTS *walk = fts_open(roots, FTS_PHYSICAL, NULL);
	assert_non_null(walk);
	uint32_t files = 0, clips = 0;
	uint64_t corners = 0;
	double most = 0.0;
	for (FTSENT *entry; (entry = fts_read(walk));) {
		stilb_scene *scene;
		if (entry->fts_info != FTS_F || !may_move(entry->fts_path) ||
		    stilb_scene_open_with(entry->fts_path, &(stilb_scene_open_options){.quiet = true}, &scene) != STILB_OK)
			continue;
		if (scene->animation && scene->animation->clip_count > 0) {
			const struct aiScene *from = read_file(entry->fts_path);
			assert_non_null(from);
			clips += play_file(entry->fts_path, scene, from, &most, &corners);
			files++;
			aiReleaseImport(from);
		}
		stilb_scene_destroy(scene);
	}
	fts_close(walk);
	print_message("%u files with %u clips: corners to %.1e of the size; %llu corners\n", files, clips, most,
	              (unsigned long long)corners);
	assert_true(files > 40 && clips > 70);
}

/* At rest bones move nothing: each vertex is where the mesh has it, on the node that shows it. */
static void bones_of_half_life_hang_together(void **state)
{
	(void)state;
	static const char *const paths[] = {MODELS "/MDL/MDL (HL1)/man.mdl", MODELS "/MDL/MDL (HL1)/unnamed_bones.mdl"};
	for (size_t i = 0; i < sizeof paths / sizeof *paths; i++) {
		stilb_scene *scene;
		uint64_t corners = 0;
		assert_int_equal(stilb_scene_open_with(paths[i], &(stilb_scene_open_options){.quiet = true}, &scene), STILB_OK);
		const struct aiScene *from = read_file(paths[i]);
		assert_non_null(from);
		rows axes = find_axes(scene, from);
		hierarchy h = list_nodes(from);
		place_nodes(&h, &(struct aiAnimation){0}, 0.0, &axes);
		for (uint32_t m = 0; m < from->mNumMeshes; m++)
			for (uint32_t b = 0; b < from->mMeshes[m]->mNumBones; b++)
				from->mMeshes[m]->mBones[b]->mNumWeights = 0;
		double error = compare(scene, from, &h, &corners);
		if (!(error <= 1e-5 && corners > 200))
			fail_msg("%s: corners are %g of the size away", paths[i], error);
		free(h.nodes);
		free(h.parents);
		free(h.to_world);
		aiReleaseImport(from);
		stilb_scene_destroy(scene);
	}
}

/* ---- morph targets ----------------------------------------------------------------------------------------------- */

#define PLACE(x, y)                                                                                                    \
	{                                                                                                                  \
		.a1 = 1, .b2 = 1, .c3 = 1, .d4 = 1, .a4 = x, .b4 = y                                                           \
	}

/* Writes a square at (2, 3) whose last corner a target moves by 5 and turns up. */
static void write_morph(const char *name)
{
	struct aiVector3D corners[4] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, moved[4];
	struct aiVector3D normals[4] = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {0, 0, 1}}, turned[4];
	uint32_t indices[2][3] = {{0, 1, 2}, {0, 2, 3}};
	struct aiFace faces[2] = {{3, indices[0]}, {3, indices[1]}};
	memcpy(moved, corners, sizeof moved);
	memcpy(turned, normals, sizeof turned);
	moved[3].z = 5;
	turned[3] = (struct aiVector3D){0, 1, 0};
	struct aiAnimMesh target = {.mVertices = moved, .mNormals = turned, .mNumVertices = 4, .mWeight = 0.25f};
	strcpy(target.mName.data, "bent");
	target.mName.length = 4;
	struct aiMesh mesh = {.mPrimitiveTypes = aiPrimitiveType_TRIANGLE,
	                      .mNumVertices = 4,
	                      .mNumFaces = 2,
	                      .mVertices = corners,
	                      .mNormals = normals,
	                      .mFaces = faces,
	                      .mNumAnimMeshes = 1,
	                      .mAnimMeshes = (struct aiAnimMesh *[]){&target}};
	struct aiNode root = {.mTransformation = PLACE(0, 0)}, node = {.mTransformation = PLACE(2, 3)};
	strcpy(node.mName.data, "thing");
	node.mName.length = 5;
	node.mParent = &root;
	node.mMeshes = (uint32_t[]){0};
	node.mNumMeshes = 1;
	root.mChildren = (struct aiNode *[]){&node};
	root.mNumChildren = 1;
	struct aiMaterial material = {0};
	struct aiScene scene = {.mRootNode = &root,
	                        .mMeshes = (struct aiMesh *[]){&mesh},
	                        .mNumMeshes = 1,
	                        .mMaterials = (struct aiMaterial *[]){&material},
	                        .mNumMaterials = 1};
	assert_int_equal(aiExportScene(&scene, "fbxa", name, 0), aiReturn_SUCCESS);
}

static void a_file_of_fbx_has_a_morph_target(void **state)
{
	(void)state;
	stilb_scene *scene;
	write_morph("test.fbx");
	if (stilb_scene_open_with("test.fbx", &(stilb_scene_open_options){.quiet = true}, &scene) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	remove("test.fbx");
	const stilb_scene_animation *a = scene->animation;
	assert_non_null(a);
	assert_true(a->deform_count == 1 && a->deforms[0].targets == 1 && a->weight_count == 1 && a->weights[0] == 0.0f);
	uint32_t node = 0;
	while (a->nodes[node].weight_count == 0)
		node++;
	static const float weights[] = {0, 1, 0.5f, -1};
	for (size_t w = 0; w < sizeof weights / sizeof *weights; w++) {
		assert_int_equal(stilb_scene_set_weights(scene, 0, node, &weights[w], 1), STILB_OK);
		stilb_scene_update_nodes(scene, NULL, 0);
		const stilb_scene_mesh *mesh = &scene->meshes[scene->part_mesh[0]];
		assert_int_equal(mesh->vertex_count, 4);
		const float *place = scene->part_transform[0].m;
		for (uint32_t v = 0; v < 4; v++) {
			const stilb_scene_vertex *vertex = &mesh->vertices[v];
			bool moves = vertex->position[0] == 0.0f && vertex->position[1] == 1.0f;
			float up = 1.0f - weights[w], side = weights[w], length = moves ? sqrtf(up * up + side * side) : 1.0f;
			assert_true(fabsf(vertex->position[2] - (moves ? 5.0f * weights[w] : 0.0f)) < 1e-5f);
			assert_true(fabsf(vertex->normal[1] - (moves ? side / length : 0.0f)) < 1e-5f);
			assert_true(fabsf(vertex->normal[2] - (moves ? up / length : 1.0f)) < 1e-5f);
		}
		assert_true(fabsf(place[12] / place[0] - 2.0f) < 1e-5f && fabsf(place[13] / place[5] - 3.0f) < 1e-5f);
	}
	stilb_scene_destroy(scene);
}

static int group_end(void **state)
{
	(void)state;
	return folder_remove();
}

int main(void)
{
	if (access(MODELS, R_OK) != 0) {
		printf("skipped: no " MODELS "; install assimp-testmodels\n");
		return 77;
	}
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(files_move_as_assimp_says),
		cmocka_unit_test(bones_of_half_life_hang_together),
		cmocka_unit_test(a_file_of_fbx_has_a_morph_target),
	};
	return cmocka_run_group_tests(tests, folder_make, group_end);
}
