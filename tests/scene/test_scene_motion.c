/* What moves in scenes of Assimp's, as the import process reads it: scenes that are made here, with known contents and
 * with damage of every kind. */
#include "scene/importer/importer_motion.h"
#include "support/test.h"

#include <assimp/commonMetaData.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- what the import process has besides ------------------------------------------------------------------------- */

static bool has_normal_maps;

bool importer_material_has_normals(const struct aiMaterial *material)
{
	(void)material;
	return has_normal_maps;
}

void importer_warn(const char *format, ...)
{
	(void)format;
}

void importer_advance_meshes(const importer *import, uint32_t done, uint32_t count)
{
	(void)import, (void)done, (void)count;
}

/* ---- a scene of Assimp's ----------------------------------------------------------------------------------------- */

#define IDENTITY                                                                                                       \
	{                                                                                                                  \
		.a1 = 1, .b2 = 1, .c3 = 1, .d4 = 1                                                                             \
	}
#define NAMED(text)                                                                                                    \
	{                                                                                                                  \
		.length = sizeof text - 1, .data = text                                                                        \
	}

/* A square of two triangles, whose corners 4 and 5 are 0 and 2 again. Its nodes: root, left and right below it, tip
 * below left. Left shows `mesh`. */
typedef struct made {
	struct aiVector3D positions[6], normals[6], uvs[6];
	struct aiFace faces[2];
	uint32_t corners[2][3];
	struct aiMesh mesh, *meshes[3];
	struct aiNode root, left, right, tip, *below_root[2], *below_left[1];
	uint32_t shown[3];
	struct aiAnimation animation, *animations[1];
	struct aiScene scene;
	importer import;
} made;

static void make(made *m)
{
	static const float corners[6][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0, 0}, {1, 1}};
	*m = (made){.corners = {{0, 1, 2}, {4, 5, 3}},
	            .root = {.mName = NAMED("root"), .mTransformation = IDENTITY},
	            .left = {.mName = NAMED("left"), .mTransformation = IDENTITY},
	            .right = {.mName = NAMED("right"), .mTransformation = IDENTITY},
	            .tip = {.mName = NAMED("tip"), .mTransformation = IDENTITY},
	            .animation = {.mName = NAMED("wave")}};
	for (int v = 0; v < 6; v++) {
		m->positions[v] = (struct aiVector3D){corners[v][0], corners[v][1], 0};
		m->normals[v] = (struct aiVector3D){0, 0, 1};
		m->uvs[v] = m->positions[v];
	}
	for (int f = 0; f < 2; f++)
		m->faces[f] = (struct aiFace){3, m->corners[f]};
	m->mesh = (struct aiMesh){.mName = NAMED("card"),
	                          .mVertices = m->positions,
	                          .mNormals = m->normals,
	                          .mNumVertices = 6,
	                          .mFaces = m->faces,
	                          .mNumFaces = 2};
	m->meshes[0] = &m->mesh;
	m->left.mTransformation.a4 = 3;
	m->below_root[0] = &m->left;
	m->below_root[1] = &m->right;
	m->below_left[0] = &m->tip;
	m->root.mChildren = m->below_root;
	m->root.mNumChildren = 2;
	m->left.mChildren = m->below_left;
	m->left.mNumChildren = 1;
	m->left.mMeshes = m->shown;
	m->left.mNumMeshes = 1;
	m->animations[0] = &m->animation;
	m->scene =
		(struct aiScene){.mRootNode = &m->root, .mMeshes = m->meshes, .mNumMeshes = 1, .mAnimations = m->animations};
	m->import = (importer){.from = &m->scene, .world.to_world = stilb_mat4_identity(), .joins = true};
	has_normal_maps = false;
}

/* Converts the scene. NULL: nothing of it moves. */
static const stilb_scene_animation *convert(made *m)
{
	importer *import = &m->import;
	const struct aiAnimation *a = &m->animation;
	if (a->mNumChannels + a->mNumMorphMeshChannels + a->mNumMeshChannels > 0 && m->scene.mNumAnimations == 0)
		m->scene.mNumAnimations = 1;
	stilb_result result = importer_list_nodes(import);
	if (result == STILB_OK)
		result = importer_add_meshes(import);
	if (result == STILB_OK)
		result = importer_add_animation(import);
	if (result != STILB_OK)
		fail_msg("%s", stilb_error_message());
	assert_true(scene_is_sound(import->scene));
	return import->scene->animation;
}

static void finish(made *m)
{
	free(m->import.nodes);
	free(m->import.colored);
	importer_motion_finish(m->import.motion);
	stilb_scene_destroy(m->import.scene);
}

/* So many things of this kind were lost, the first of which is called so; nothing of any other kind was. */
static void assert_lost(const made *m, importer_loss loss, uint32_t count, const char *first)
{
	for (int i = 0; i < IMPORTER_LOSSES; i++)
		if (m->import.lost[i].count != (i == (int)loss ? count : 0))
			fail_msg("%u of loss %d ('%s')", m->import.lost[i].count, i, m->import.lost[i].first);
	if (count > 0 && !strstr(m->import.lost[loss].first, first))
		fail_msg("'%s' does not say '%s'", m->import.lost[loss].first, first);
}

static void assert_near(const float *got, const float *wanted, uint32_t count)
{
	for (uint32_t i = 0; i < count; i++)
		if (!(fabsf(got[i] - wanted[i]) <= 1e-6f * fmaxf(1.0f, fabsf(wanted[i]))))
			fail_msg("number %u of %u is %g instead of %g", i, count, (double)got[i], (double)wanted[i]);
}

/* ---- skins ------------------------------------------------------------------------------------------------------- */

static struct aiVertexWeight all_one[6] = {{0, 1}, {1, 1}, {2, 1}, {3, 1}, {4, 1}, {5, 1}};

static struct aiBone bone_of(const char *name, struct aiVertexWeight *weights, uint32_t count, float offset)
{
	struct aiBone bone = {.mNumWeights = count, .mWeights = weights, .mOffsetMatrix = IDENTITY};
	bone.mName.length = (uint32_t)strlen(name);
	strcpy(bone.mName.data, name);
	bone.mOffsetMatrix.a4 = offset;
	return bone;
}

/* The vertex of the scene's mesh at this place: there is one alone. */
static uint32_t vertex_at(const stilb_scene_mesh *mesh, float x, float y)
{
	uint32_t found = UINT32_MAX;
	for (uint32_t v = 0; v < mesh->vertex_count; v++)
		if (mesh->vertices[v].position[0] == x && mesh->vertices[v].position[1] == y) {
			assert_true(found == UINT32_MAX);
			found = v;
		}
	assert_true(found != UINT32_MAX);
	return found;
}

/* Every vertex has bones: one skin of these alone, the heaviest first, and what is the same is one vertex. */
static void bones_become_a_skin(void **state)
{
	(void)state;
	made m;
	make(&m);
	struct aiVertexWeight some[] = {{0, 0.25f}, {4, 0.25f}, {1, 3}, {3, 0}};
	struct aiBone right = bone_of("right", all_one, 6, 7), tip = bone_of("tip", some, 4, 8);
	struct aiBone none = bone_of("root", some + 3, 1, 9); /* of no weight: it is no joint */
	m.mesh.mBones = (struct aiBone *[]){&tip, &none, &right};
	m.mesh.mNumBones = 3;
	const stilb_scene_animation *a = convert(&m);
	assert_true(a->node_count == 4 && a->skin_count == 1 && a->joint_count == 2 && a->deform_count == 1);
	assert_string_equal(a->skins[0].name, "card");
	assert_string_equal(a->nodes[1].name, "left");
	assert_true(a->nodes[1].skin == 0 && a->nodes[0].skin == STILB_SCENE_NONE && a->nodes[1].model_count == 1);
	assert_true(a->joints[0] == 2 && a->joints[1] == 3 && a->nodes[3].parent == 1);
	assert_near(a->inverse_binds[0].m + 12, (const float[]){7, 0, 0, 1}, 4);
	assert_near(a->inverse_binds[1].m + 12, (const float[]){8, 0, 0, 1}, 4);
	const stilb_scene_mesh *mesh = &m.import.scene->meshes[0];
	const stilb_scene_deform *d = a->deforms;
	assert_true(mesh->vertex_count == 4 && mesh->index_count == 6 && d->influences == 4 && d->targets == 0);
	uint32_t v = vertex_at(mesh, 0, 0), w = vertex_at(mesh, 1, 0);
	assert_near(d->weights + 4 * v, (const float[]){1, 0.25f, 0, 0}, 4);
	assert_memory_equal(d->joints + 4 * v, ((const uint16_t[]){0, 1, 0, 0}), 8);
	assert_near(d->weights + 4 * w, (const float[]){3, 1, 0, 0}, 4);
	assert_memory_equal(d->joints + 4 * w, ((const uint16_t[]){1, 0, 0, 0}), 8);
	assert_lost(&m, IMPORTER_LOSSES, 0, "");
	finish(&m);
}

/* Vertices of the same place that other bones move stay apart. */
static void vertices_with_other_bones_are_not_joined(void **state)
{
	(void)state;
	made m;
	make(&m);
	struct aiVertexWeight first[] = {{0, 1}, {1, 1}, {2, 1}}, second[] = {{3, 1}, {4, 1}, {5, 1}};
	struct aiBone right = bone_of("right", first, 3, 0), tip = bone_of("tip", second, 3, 0);
	m.mesh.mBones = (struct aiBone *[]){&right, &tip};
	m.mesh.mNumBones = 2;
	const stilb_scene_animation *a = convert(&m);
	const stilb_scene_mesh *mesh = &m.import.scene->meshes[0];
	assert_int_equal(mesh->vertex_count, 6);
	for (uint32_t i = 0; i < 6; i++)
		assert_int_equal(a->deforms[0].joints[4 * mesh->indices[i]], i / 3);
	finish(&m);
	make(&m); /* the same bones, with other weights */
	struct aiVertexWeight third[] = {{0, 1}, {1, 1}, {2, 1}, {3, 0.5f}, {4, 0.5f}, {5, 0.5f}};
	struct aiVertexWeight quarters[6];
	for (uint32_t v = 0; v < 6; v++)
		quarters[v] = (struct aiVertexWeight){v, 0.25f};
	right = bone_of("right", third, 6, 0), tip = bone_of("tip", quarters, 6, 0);
	m.mesh.mBones = (struct aiBone *[]){&right, &tip};
	m.mesh.mNumBones = 2;
	a = convert(&m);
	mesh = &m.import.scene->meshes[0];
	assert_int_equal(mesh->vertex_count, 6);
	for (uint32_t i = 0; i < 6; i++)
		assert_true(a->deforms[0].weights[4 * mesh->indices[i]] == (i < 3 ? 1.0f : 0.5f));
	finish(&m);
}

/* A node shows three meshes: one whose last vertices have no bones, one without any, and one with a bone that the first
 * has, too. Another node shows the second one alone. */
static void what_has_no_bones_stays_with_its_node(void **state)
{
	(void)state;
	made m;
	make(&m);
	struct aiBone tip = bone_of("tip", all_one, 3, 8), again = bone_of("tip", all_one, 6, 8);
	struct aiBone other = bone_of("tip", all_one, 6, 9);
	struct aiMesh plain = m.mesh, third = m.mesh;
	strcpy(plain.mName.data, "plain");
	m.mesh.mBones = (struct aiBone *[]){&tip};
	m.mesh.mNumBones = 1;
	third.mBones = (struct aiBone *[]){&again, &other};
	third.mNumBones = 2;
	m.meshes[1] = &plain;
	m.meshes[2] = &third;
	m.scene.mNumMeshes = 3;
	m.shown[1] = 2;
	m.shown[2] = 1;
	m.left.mNumMeshes = 3;
	m.right.mMeshes = (uint32_t[]){1};
	m.right.mNumMeshes = 1;
	const stilb_scene_animation *a = convert(&m);
	assert_true(a->skin_count == 2 && a->joint_count == 6 && a->deform_count == 3);
	assert_true(a->nodes[1].skin == 0 && a->nodes[2].skin == 1 && a->skins[1].first_joint == 3);
	assert_memory_equal(a->joints, ((const uint32_t[]){1, 3, 3, 2, 3, 3}), 24);
	assert_string_equal(a->skins[0].name, "card");
	for (uint32_t j = 0; j < 6; j++)
		assert_near(a->inverse_binds[j].m + 12, (const float[]){j % 3 ? 7.0f + (float)(j % 3) : 0, 0, 0, 1}, 4);
	for (uint32_t i = 0; i < 6; i++) {
		const stilb_scene_mesh *meshes = m.import.scene->meshes;
		uint32_t v = meshes[0].indices[i], p = meshes[1].indices[i], t = meshes[2].indices[i];
		assert_true(a->deforms[0].joints[4 * v] == (i < 3) && a->deforms[0].weights[4 * v] == 1.0f);
		assert_true(a->deforms[1].joints[4 * p] == 0 && a->deforms[1].weights[4 * p] == 1.0f);
		assert_memory_equal(a->deforms[2].joints + 4 * t, ((const uint16_t[]){1, 2, 0, 0}), 8);
	}
	assert_lost(&m, IMPORTER_LOSSES, 0, "");
	finish(&m);
}

/* 40 bones move each vertex: 32 of the most weight are kept. 12 are all kept. */
static void the_heaviest_influences_are_kept(void **state)
{
	(void)state;
	for (int round = 0; round < 2; round++) {
		made m;
		make(&m);
		uint32_t count = round ? 12 : 40;
		struct aiVertexWeight weights[40][6];
		struct aiBone bones[40], *list[40];
		for (uint32_t b = 0; b < count; b++) {
			for (uint32_t v = 0; v < 6; v++)
				weights[b][v] = (struct aiVertexWeight){v, 1.0f + (float)(b * 7 % count)};
			bones[b] = bone_of("tip", weights[b], 6, (float)b);
			list[b] = &bones[b];
		}
		m.mesh.mBones = list;
		m.mesh.mNumBones = count;
		const stilb_scene_animation *a = convert(&m);
		const stilb_scene_deform *d = a->deforms;
		assert_true(a->joint_count == count && d->influences == (round ? 12 : 32));
		for (uint32_t v = 0; v < m.import.scene->meshes[0].vertex_count; v++)
			for (uint32_t i = 0; i < d->influences; i++) {
				uint16_t joint = d->joints[v * d->influences + i];
				assert_true(d->weights[v * d->influences + i] == (float)(count - i));
				uint32_t bone = (uint32_t)a->inverse_binds[joint].m[12];
				assert_true(1.0f + (float)(bone * 7 % count) == (float)(count - i));
			}
		assert_lost(&m, IMPORTER_LOSS_INFLUENCES, !round, "card");
		finish(&m);
	}
}

static void damaged_bones_are_left_out(void **state)
{
	(void)state;
	static const struct {
		uint32_t vertex;
		float weight, offset;
		const char *name, *says;
		importer_loss loss;
	} rows[] = {
		{6, 1, 0, "tip", "card: bone 'tip' has vertex 6 of 6", IMPORTER_LOSS_BAD_DEFORMS},
		{0, NAN, 0, "tip", "with weight nan", IMPORTER_LOSS_BAD_DEFORMS},
		{0, INFINITY, 0, "tip", "with weight inf", IMPORTER_LOSS_BAD_DEFORMS},
		{0, 1, NAN, "tip", "bone 'tip' has a matrix that is NaN or infinite", IMPORTER_LOSS_BAD_SKINS},
		{0, 1, 0, "nobody", "bone 'nobody' is no node of the scene", IMPORTER_LOSS_BAD_SKINS},
	};
	for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
		made m;
		make(&m);
		struct aiVertexWeight weight = {rows[i].vertex, rows[i].weight};
		struct aiBone tip = bone_of(rows[i].name, &weight, 1, rows[i].offset), right = bone_of("right", all_one, 6, 0);
		m.mesh.mBones = (struct aiBone *[]){&right, &tip};
		m.mesh.mNumBones = 2;
		const stilb_scene_animation *a = convert(&m);
		assert_lost(&m, rows[i].loss, 1, rows[i].says);
		assert_int_equal(a ? a->joint_count : 0, rows[i].loss == IMPORTER_LOSS_BAD_SKINS);
		finish(&m);
		make(&m); /* weights that are not there */
		tip = bone_of("tip", NULL, 3, 0);
		m.mesh.mBones = (struct aiBone *[]){&tip, NULL};
		m.mesh.mNumBones = 1 + i % 2;
		convert(&m);
		assert_lost(&m, IMPORTER_LOSS_BAD_DEFORMS, 1, "card: bone 0 is not there");
		finish(&m);
	}
}

/* Where tangents need a vertex twice, its bones and targets go with it; sharp: and where normals
 * do. */
static void assert_split(bool sharp)
{
	made m;
	make(&m);
	struct aiMaterial material = {0}, *materials[] = {&material};
	m.scene.mMaterials = materials;
	m.scene.mNumMaterials = 1;
	m.corners[1][0] = 0; /* triangles share corners 0 and 2, on mirrored sides of the map */
	m.corners[1][1] = 2;
	m.uvs[3] = (struct aiVector3D){1, 0, 0};
	if (sharp) {
		m.positions[3] = (struct aiVector3D){0, 0, 1};
		m.mesh.mNormals = NULL;
		m.import.shares = true;
	}
	m.mesh.mTextureCoords[0] = m.uvs;
	struct aiVertexWeight weights[4] = {{0, 1}, {1, 2}, {2, 3}, {3, 4}};
	struct aiVector3D moved[6];
	for (int v = 0; v < 6; v++)
		moved[v] = (struct aiVector3D){m.positions[v].x, m.positions[v].y, m.positions[v].z + 1.0f + (float)v};
	struct aiAnimMesh target = {.mVertices = moved, .mNumVertices = 6};
	struct aiBone tip = bone_of("tip", weights, 4, 0), right = bone_of("right", all_one, 6, 0);
	m.mesh.mBones = (struct aiBone *[]){&tip, &right};
	m.mesh.mNumBones = 2;
	m.mesh.mAnimMeshes = (struct aiAnimMesh *[]){&target};
	m.mesh.mNumAnimMeshes = 1;
	has_normal_maps = true;
	const stilb_scene_animation *a = convert(&m);
	const stilb_scene_mesh *mesh = &m.import.scene->meshes[0];
	const stilb_scene_deform *d = a->deforms;
	assert_true(mesh->vertex_count == 6 && mesh->extras && d->targets == 1);
	for (uint32_t i = 0; i < 6; i++) {
		uint32_t v = mesh->indices[i], file = m.corners[i / 3][i % 3];
		float sum = 0.0f;
		for (int k = 0; k < 4; k++)
			sum += d->joints[4 * v + (uint32_t)k] == 1 ? d->weights[4 * v + (uint32_t)k] : 0.0f;
		assert_true(sum == 1.0f + (float)file && d->positions[3 * v + 2] == 1.0f + (float)file);
		assert_true(mesh->extras[v].tangent[3] != 0.0f);
	}
	finish(&m);
}

static void split_vertices_keep_their_bones(void **state)
{
	(void)state;
	assert_split(false);
	assert_split(true);
}

/* ---- clips ------------------------------------------------------------------------------------------------------- */

static void three_paths_become_channels(void **state)
{
	(void)state;
	made m;
	make(&m);
	struct aiVectorKey places[] = {{0, {1, 2, 3}}, {10, {4, 5, 6}}}, sizes[] = {{5, {2, 2, 2}}};
	struct aiQuatKey turns[] = {{0, {.w = 1}}, {10, {.w = 0, .y = 2}}}; /* not unit */
	struct aiNodeAnim channel = {.mNodeName = NAMED("tip"),
	                             .mPositionKeys = places,
	                             .mNumPositionKeys = 2,
	                             .mRotationKeys = turns,
	                             .mNumRotationKeys = 2,
	                             .mScalingKeys = sizes,
	                             .mNumScalingKeys = 1};
	struct aiNodeAnim again = channel; /* of the same node: the first counts */
	m.animation.mChannels = (struct aiNodeAnim *[]){&channel, &again, NULL};
	m.animation.mNumChannels = 3;
	const stilb_scene_animation *a = convert(&m);
	assert_true(a->clip_count == 1 && a->channel_count == 3 && a->skin_count == 0 && a->deform_count == 0);
	assert_string_equal(a->clips[0].name, "wave");
	assert_true(a->clips[0].duration == 0.4f); /* 10 of 25 ticks a second */
	const stilb_scene_channel *c = a->channels;
	assert_true(c[0].path == STILB_SCENE_PATH_TRANSLATION && c[1].path == STILB_SCENE_PATH_ROTATION &&
	            c[2].path == STILB_SCENE_PATH_SCALE);
	for (int i = 0; i < 3; i++)
		assert_true(c[i].node == 3 && c[i].interpolation == STILB_SCENE_LINEAR);
	assert_true(c[0].first_time == c[1].first_time && a->time_count == 3);
	assert_near(a->times, (const float[]){0, 0.4f, 0.2f}, 3);
	assert_near(a->values + c[0].first_value, (const float[]){1, 2, 3, 4, 5, 6}, 6);
	assert_near(a->values + c[1].first_value, (const float[]){0, 0, 0, 1, 0, 1, 0, 0}, 8);
	assert_near(a->values + c[2].first_value, (const float[]){2, 2, 2}, 3);
	assert_lost(&m, IMPORTER_LOSSES, 0, "");
	finish(&m);
	make(&m);
	m.animation.mChannels = (struct aiNodeAnim *[]){&channel};
	m.animation.mNumChannels = 1;
	m.animation.mTicksPerSecond = 4800;
	m.animation.mName.data[0] = '\0';
	channel.mPostState = aiAnimBehaviour_REPEAT;
	a = convert(&m);
	assert_true(a->clips[0].duration == 10.0f / 4800.0f);
	assert_string_equal(a->clips[0].name, "number 0");
	assert_lost(&m, IMPORTER_LOSS_REPEATS, 1, "number 0");
	finish(&m);
}

/* Matrices that are products of translation, rotation and scale move, others do if a clip moves them. */
static void nodes_have_poses(void **state)
{
	(void)state;
	made m;
	make(&m);
	m.right.mTransformation = (struct aiMatrix4x4){.a2 = -2, .b1 = 3, .c3 = -4, .d4 = 1, .a4 = 5};
	m.left.mTransformation.a2 = m.tip.mTransformation.a2 = 0.5f; /* sheared */
	struct aiVectorKey places[] = {{0, {1, 2, 3}}};
	struct aiNodeAnim channel = {.mNodeName = NAMED("tip"), .mPositionKeys = places, .mNumPositionKeys = 1};
	m.animation.mChannels = (struct aiNodeAnim *[]){&channel};
	m.animation.mNumChannels = 1;
	const stilb_scene_animation *a = convert(&m);
	assert_true(a->nodes[0].moves && a->nodes[2].moves && !a->nodes[1].moves && a->nodes[3].moves);
	for (int n = 0; n < 4; n++) {
		const stilb_scene_rest *node = &a->nodes[n];
		stilb_scene_pose pose;
		memcpy(pose.translation, node->translation, sizeof pose.translation);
		memcpy(pose.rotation, node->rotation, sizeof pose.rotation);
		memcpy(pose.scale, node->scale, sizeof pose.scale);
		stilb_mat4 product = stilb_scene_pose_matrix(&pose);
		if (n % 2 == 0)
			assert_near(product.m, node->local.m, 16);
		assert_memory_equal(&node->local, &m.import.scene->nodes.local[n], sizeof node->local);
	}
	assert_true(a->nodes[3].local.m[4] == 0.5f && fabsf(a->nodes[3].scale[1] - sqrtf(1.25f)) < 1e-6f);
	assert_true(a->nodes[1].scale[1] == 1.0f);
	finish(&m);
}

/* A clip of the root moves it in the file's axes, which are not ours: z is up, or also right and left are changed. */
static void the_root_moves_in_our_axes(void **state)
{
	(void)state;
	for (int mirrored = 0; mirrored < 2; mirrored++) {
		made m;
		make(&m);
		struct aiVectorKey places[] = {{0, {1, 2, 3}}}, sizes[] = {{0, {2, 3, 4}}};
		struct aiQuatKey turns[] = {{0, {.w = 0.5f, .x = 0.5f, .y = -0.5f, .z = 0.5f}}};
		struct aiNodeAnim channel = {.mNodeName = NAMED("root"),
		                             .mPositionKeys = places,
		                             .mNumPositionKeys = 1,
		                             .mRotationKeys = turns,
		                             .mNumRotationKeys = 1,
		                             .mScalingKeys = sizes,
		                             .mNumScalingKeys = 1};
		m.animation.mChannels = (struct aiNodeAnim *[]){&channel};
		m.animation.mNumChannels = 1;
		m.import.world.to_world =
			(stilb_mat4){.m = {[0] = mirrored ? -1 : 1, [6] = -1, [9] = 1, [15] = 1}}; /* (x, z, -y) */
		stilb_scene_pose file = {.translation = {1, 2, 3}, .rotation = {0.5f, -0.5f, 0.5f, 0.5f}, .scale = {2, 3, 4}};
		const stilb_scene_animation *a = convert(&m);
		stilb_scene_pose ours = stilb_scene_pose_identity();
		memcpy(ours.translation, a->values + a->channels[0].first_value, 12);
		memcpy(ours.rotation, a->values + a->channels[1].first_value, 16);
		memcpy(ours.scale, a->values + a->channels[2].first_value, 12);
		stilb_mat4 own = stilb_scene_pose_matrix(&file);
		stilb_mat4 wanted = stilb_mat4_multiply(m.import.world.to_world, own), got = stilb_scene_pose_matrix(&ours);
		assert_near(got.m, wanted.m, 16);
		finish(&m);
	}
}

static void damaged_clips_are_left_out(void **state)
{
	(void)state;
	static const struct {
		double ticks, times[2];
		float value;
		bool turns, none;
		const char *says;
	} rows[] = {
		{25, {0, (double)NAN}, 0, false, false, "wave: the times of 'tip' are negative, NaN or descend"},
		{25, {(double)NAN, 1}, 0, false, false, "wave: the times of 'tip' are negative, NaN or descend"},
		{25, {1, 0.5}, 0, false, false, "negative, NaN or descend"},
		{25, {-1, 0}, 0, false, false, "negative, NaN or descend"},
		{1e-9, {0, 1e30}, 0, false, false, "negative, NaN or descend"},
		{(double)NAN, {0, 1}, 0, false, false, "wave: it has nan ticks a second"},
		{-25, {0, 1}, 0, false, false, "wave: it has -25 ticks a second"},
		{(double)INFINITY, {0, 1}, 0, false, false, "ticks a second"},
		{25, {0, 1}, NAN, false, false, "key 1 of 'tip' is NaN or infinite"},
		{25, {0, 1}, INFINITY, false, false, "key 1 of 'tip' is NaN or infinite"},
		{25, {0, 1}, NAN, true, false, "key 1 of 'tip' is NaN or infinite"},
		{25, {0, 1}, 0, true, false, "or turns by nothing"},
		{25, {0, 1}, 0, false, true, "2 keys are not there"},
	};
	for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
		made m;
		make(&m);
		struct aiVectorKey places[] = {{rows[i].times[0], {1, 2, 3}}, {rows[i].times[1], {4, rows[i].value, 6}}};
		struct aiQuatKey turns[] = {{rows[i].times[0], {.w = 1}}, {rows[i].times[1], {.y = rows[i].value}}};
		struct aiNodeAnim channel = {.mNodeName = NAMED("tip"), .mNumPositionKeys = 2, .mPositionKeys = places};
		if (rows[i].turns)
			channel = (struct aiNodeAnim){.mNodeName = NAMED("tip"), .mNumRotationKeys = 2, .mRotationKeys = turns};
		if (rows[i].none)
			channel.mPositionKeys = NULL;
		struct aiVectorKey good[] = {{0, {1, 2, 3}}};
		struct aiNodeAnim before = {.mNodeName = NAMED("left"), .mNumPositionKeys = 1, .mPositionKeys = good};
		struct aiAnimation sound = {.mName = NAMED("sound"), .mNumChannels = 1};
		sound.mChannels = (struct aiNodeAnim *[]){&before};
		m.animation.mChannels = (struct aiNodeAnim *[]){&before, &channel};
		m.animation.mNumChannels = 2;
		m.animation.mTicksPerSecond = rows[i].ticks;
		m.scene.mAnimations = (struct aiAnimation *[]){&m.animation, NULL, &sound};
		m.scene.mNumAnimations = 3;
		const stilb_scene_animation *a = convert(&m);
		assert_lost(&m, IMPORTER_LOSS_BAD_ANIMATIONS, 1, rows[i].says);
		assert_true(a->clip_count == 1 && a->channel_count == 1 && a->value_count == 3 && a->time_count == 1);
		assert_string_equal(a->clips[0].name, "sound");
		finish(&m);
	}
	made m;
	make(&m);
	m.animation.mNumChannels = 2;
	assert_null(convert(&m));
	assert_lost(&m, IMPORTER_LOSS_BAD_ANIMATIONS, 1, "wave: its channels are not there");
	finish(&m);
}

/* Names that no node has, and one that two have. */
static void names_mean_the_first_node(void **state)
{
	(void)state;
	made m;
	make(&m);
	struct aiVectorKey places[] = {{0, {1, 2, 3}}};
	struct aiNodeAnim first = {.mNodeName = NAMED("right"), .mNumPositionKeys = 1, .mPositionKeys = places};
	struct aiNodeAnim second = first;
	m.tip.mName = m.right.mName;
	m.animation.mChannels = (struct aiNodeAnim *[]){&first, &second};
	m.animation.mNumChannels = 2;
	struct aiBone bone = bone_of("right", all_one, 6, 0);
	m.mesh.mBones = (struct aiBone *[]){&bone};
	m.mesh.mNumBones = 1;
	const stilb_scene_animation *a = convert(&m);
	assert_true(a->channel_count == 1 && a->channels[0].node == 2 && a->joints[0] == 2);
	assert_lost(&m, IMPORTER_LOSS_NAMESAKES, 1, "right");
	finish(&m);
	make(&m);
	strcpy(first.mNodeName.data, "nobody");
	m.animation.mChannels = (struct aiNodeAnim *[]){&first, &second};
	m.animation.mNumChannels = 2;
	a = convert(&m);
	assert_true(a->clip_count == 1 && a->channel_count == 1);
	assert_lost(&m, IMPORTER_LOSS_STRAYS, 1, "wave");
	finish(&m);
	make(&m);
	m.animation.mNumMeshChannels = 1;
	assert_null(convert(&m));
	assert_lost(&m, IMPORTER_LOSS_MESH_FRAMES, 1, "wave");
	finish(&m);
}

/* ---- morph targets ----------------------------------------------------------------------------------------------- */

/* Two targets: the first moves vertex 1, the second vertex 3, and turns the normal of vertex 2. */
typedef struct made_targets {
	struct aiVector3D positions[6], others[6], normals[6];
	struct aiAnimMesh first, second, *list[2];
} made_targets;

static void add_targets(made *m, made_targets *t)
{
	memcpy(t->positions, m->positions, sizeof t->positions);
	memcpy(t->normals, m->normals, sizeof t->normals);
	memcpy(t->others, m->positions, sizeof t->others);
	t->positions[1] = (struct aiVector3D){4, 5, 6};
	t->others[3].z = 7;
	t->normals[2] = (struct aiVector3D){0, 2, 0};
	t->first = (struct aiAnimMesh){.mVertices = t->positions, .mNumVertices = 6, .mWeight = 0.25f};
	t->second = (struct aiAnimMesh){.mVertices = t->others, .mNormals = t->normals, .mNumVertices = 6, .mWeight = 1};
	t->list[0] = &t->first;
	t->list[1] = &t->second;
	m->mesh.mAnimMeshes = t->list;
	m->mesh.mNumAnimMeshes = 2;
}

static void targets_are_differences(void **state)
{
	(void)state;
	made m;
	made_targets t;
	make(&m);
	add_targets(&m, &t);
	const stilb_scene_animation *a = convert(&m);
	const stilb_scene_mesh *mesh = &m.import.scene->meshes[0];
	const stilb_scene_deform *d = a->deforms;
	assert_true(a->deform_count == 1 && d->targets == 2 && d->influences == 0 && d->normals && !d->tangents);
	/* Vertices 2 and 5 are the same but for the second target. */
	assert_true(mesh->vertex_count == 5 && a->nodes[1].weight_count == 2);
	assert_near(a->weights, (const float[]){0.25f, 1}, 2);
	for (uint32_t i = 0; i < 6; i++) {
		uint32_t v = mesh->indices[i], file = m.corners[i / 3][i % 3], second = 5 + v;
		assert_near(d->positions + 3 * v, file == 1 ? (const float[]){3, 5, 6} : (const float[]){0, 0, 0}, 3);
		assert_near(d->positions + 3 * second, file == 3 ? (const float[]){0, 0, 7} : (const float[]){0, 0, 0}, 3);
		assert_near(d->normals + 3 * v, (const float[]){0, 0, 0}, 3);
		assert_near(d->normals + 3 * second, file == 2 ? (const float[]){0, 1, -1} : (const float[]){0, 0, 0}, 3);
	}
	finish(&m);
	/* Triangles that face away from the normals of a closed mesh turn these around, and those of targets with them. */
	make(&m);
	add_targets(&m, &t);
	struct aiVector3D corners[6] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {9, 9, 9}, {9, 9, 9}};
	uint32_t faces[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
	struct aiFace list[4];
	for (int f = 0; f < 4; f++)
		list[f] = (struct aiFace){3, faces[f]};
	memcpy(m.positions, corners, sizeof corners);
	t.second.mVertices = NULL;  /* it moves nothing */
	for (int v = 0; v < 4; v++) /* inwards */
		m.normals[v] = (struct aiVector3D){0.25f - corners[v].x, 0.25f - corners[v].y, 0.25f - corners[v].z};
	m.mesh.mFaces = list;
	m.mesh.mNumFaces = 4;
	memcpy(t.normals, m.normals, sizeof t.normals);
	t.normals[2] = (struct aiVector3D){0, 0, 3};
	a = convert(&m);
	mesh = &m.import.scene->meshes[0];
	assert_int_equal(mesh->vertex_count, 4); /* those that no triangle uses are gone */
	for (uint32_t v = 0; v < 4; v++) {
		float sum[3];
		for (uint32_t k = 0; k < 3; k++)
			sum[k] = mesh->vertices[v].normal[k] + a->deforms[0].normals[3 * (4 + v) + k];
		assert_true(mesh->vertices[v].normal[1] * (corners[v].y - 0.25f) > 0.0f);
		assert_near(a->deforms[0].positions + 3 * (4 + v), (const float[]){0, 0, 0}, 3);
		assert_near(sum, v == 2 ? (const float[]){0, 0, -1} : mesh->vertices[v].normal, 3);
	}
	finish(&m);
}

/* The weight of a target that a key does not name lies between those of the keys that do. */
static void weights_of_targets_are_played(void **state)
{
	(void)state;
	static const char *const names[] = {"left", "left*0", "card"};
	for (int i = 0; i < 3; i++) {
		made m;
		made_targets t;
		make(&m);
		add_targets(&m, &t);
		uint32_t both[] = {1, 0}, second[] = {1};
		double weights[] = {0.5, 0.125, 1.0, 0.75};
		struct aiMeshMorphKey keys[] = {
			{.mTime = 0},
			{.mTime = 25, .mValues = both, .mWeights = weights, .mNumValuesAndWeights = 2},
			{.mTime = 75, .mValues = NULL},
			{.mTime = 125, .mValues = second, .mWeights = weights + 2, .mNumValuesAndWeights = 1}};
		struct aiMeshMorphAnim channel = {.mNumKeys = 4, .mKeys = keys};
		strcpy(channel.mName.data, names[i]);
		m.animation.mMorphMeshChannels = (struct aiMeshMorphAnim *[]){&channel, NULL};
		m.animation.mNumMorphMeshChannels = 2;
		const stilb_scene_animation *a = convert(&m);
		assert_true(a->clip_count == 1 && a->channel_count == 1 && a->clips[0].duration == 5.0f);
		const stilb_scene_channel *c = a->channels;
		assert_true(c->path == STILB_SCENE_PATH_WEIGHTS && c->width == 2 && c->node == 1 && c->key_count == 4);
		assert_near(a->values, (const float[]){0.125f, 0.5f, 0.125f, 0.5f, 0.125f, 0.75f, 0.125f, 1}, 8);
		assert_lost(&m, IMPORTER_LOSSES, 0, "");
		finish(&m);
	}
}

static void damaged_targets_are_left_out(void **state)
{
	(void)state;
	made m;
	made_targets t;
	make(&m);
	add_targets(&m, &t);
	t.second.mNumVertices = 5;
	assert_null(convert(&m));
	assert_lost(&m, IMPORTER_LOSS_BAD_DEFORMS, 1, "card: morph target 1 has 5 vertices of 6");
	finish(&m);
	make(&m);
	add_targets(&m, &t);
	t.positions[2].y = NAN;
	assert_null(convert(&m));
	assert_lost(&m, IMPORTER_LOSS_BAD_DEFORMS, 1, "card: morph target 0 is NaN or infinite somewhere");
	finish(&m);
	static const struct {
		uint32_t value;
		double weight;
		const char *name, *says;
		importer_loss loss;
	} rows[] = {
		{2, 1, "card", "has target 2 of 2", IMPORTER_LOSS_BAD_ANIMATIONS},
		{0, (double)NAN, "card", "with weight nan", IMPORTER_LOSS_BAD_ANIMATIONS},
		{0, 1, "nobody", "wave", IMPORTER_LOSS_ANIMATIONS},
	};
	for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
		make(&m);
		add_targets(&m, &t);
		t.second.mWeight = NAN;
		uint32_t value = rows[i].value;
		double weight = rows[i].weight;
		struct aiMeshMorphKey key = {.mValues = &value, .mWeights = &weight, .mNumValuesAndWeights = 1};
		struct aiMeshMorphAnim channel = {.mNumKeys = 1, .mKeys = &key};
		strcpy(channel.mName.data, rows[i].name);
		m.animation.mMorphMeshChannels = (struct aiMeshMorphAnim *[]){&channel};
		m.animation.mNumMorphMeshChannels = 1;
		const stilb_scene_animation *a = convert(&m);
		assert_true(a->clip_count == 0 && a->weights[1] == 0.0f);
		assert_lost(&m, rows[i].loss, 1, rows[i].says);
		finish(&m);
	}
}

/* ---- any damage -------------------------------------------------------------------------------------------------- */

#define ROUNDS (TEST_ASAN ? 3000u : 20000u)

static uint64_t random_index;

static uint32_t below(uint32_t bound)
{
	return (uint32_t)(stilb_random_u64(9, random_index++) % bound);
}

static float wrong_number(void)
{
	static const float numbers[] = {0.0f, -1.0f, 1e-30f, 1e30f, 3e38f, NAN, INFINITY, -INFINITY};
	return numbers[below(8)];
}

static uint32_t wrong_index(void)
{
	static const uint32_t numbers[] = {0, 3, 5, 6, 7, 1000, 0x7fffffff, UINT32_MAX};
	return numbers[below(8)];
}

/* All that the scenes of this test have, with some numbers wrong: what comes out can be used, whatever it is. */
static void random_damage_is_survived(void **state)
{
	(void)state;
	uint32_t moving = 0;
	for (uint32_t round = 0; round < ROUNDS; round++) {
		made m;
		made_targets t;
		make(&m);
		add_targets(&m, &t);
		struct aiMaterial material = {0}, *materials[] = {&material};
		struct aiVertexWeight weights[2][6];
		for (uint32_t v = 0; v < 6; v++)
			weights[0][v] = weights[1][v] = (struct aiVertexWeight){v, 0.5f};
		struct aiBone right = bone_of("right", weights[0], 6, 1), tip = bone_of("tip", weights[1], 6, 2);
		struct aiMesh plain = m.mesh;
		plain.mNumAnimMeshes = 0;
		m.mesh.mBones = (struct aiBone *[]){&right, &tip};
		m.mesh.mNumBones = 2;
		m.mesh.mTextureCoords[0] = m.uvs;
		m.meshes[1] = &plain;
		m.scene.mNumMeshes = 2;
		m.shown[1] = 1;
		m.left.mNumMeshes = 2;
		m.scene.mMaterials = materials;
		m.scene.mNumMaterials = 1;
		has_normal_maps = below(2) > 0;
		struct aiVectorKey places[] = {{0, {1, 2, 3}}, {10, {4, 5, 6}}};
		struct aiQuatKey turns[] = {{0, {.w = 1}}, {10, {.y = 1}}};
		struct aiNodeAnim channel = {.mNodeName = NAMED("tip"),
		                             .mPositionKeys = places,
		                             .mNumPositionKeys = 2,
		                             .mRotationKeys = turns,
		                             .mNumRotationKeys = 2};
		struct aiNodeAnim root = channel;
		root.mNodeName = m.root.mName;
		m.animation.mChannels = (struct aiNodeAnim *[]){&channel, &root};
		m.animation.mNumChannels = 2;
		uint32_t both[] = {1, 0};
		double keyed[] = {0.5, 0.125};
		struct aiMeshMorphKey keys[] = {{.mTime = 0},
		                                {.mTime = 25, .mValues = both, .mWeights = keyed, .mNumValuesAndWeights = 2}};
		struct aiMeshMorphAnim morph = {.mName = NAMED("left"), .mNumKeys = 2, .mKeys = keys};
		m.animation.mMorphMeshChannels = (struct aiMeshMorphAnim *[]){&morph};
		m.animation.mNumMorphMeshChannels = 1;
		uint32_t *const indices[] = {&weights[0][3].mVertexId,
		                             &weights[1][0].mVertexId,
		                             &m.corners[0][1],
		                             &m.corners[1][2],
		                             &m.shown[0],
		                             &m.shown[1],
		                             &m.mesh.mMaterialIndex,
		                             &both[0],
		                             &both[1],
		                             &plain.mMaterialIndex};
		float *const numbers[] = {
			&weights[0][2].mWeight,    &weights[1][5].mWeight, &right.mOffsetMatrix.a4,   &tip.mOffsetMatrix.b2,
			&m.positions[1].x,         &m.positions[4].z,      &m.normals[2].y,           &m.uvs[3].x,
			&t.positions[1].y,         &t.others[2].z,         &t.normals[3].x,           &t.first.mWeight,
			&places[1].mValue.y,       &turns[1].mValue.w,     &m.tip.mTransformation.a4, &m.right.mTransformation.b2,
			&m.root.mTransformation.c3};
		double *const times[] = {&places[0].mTime, &places[1].mTime, &turns[1].mTime,
		                         &keys[1].mTime,   &keyed[0],        &m.animation.mTicksPerSecond};
		for (uint32_t n = below(3); n > 0; n--)
			*indices[below(10)] = wrong_index();
		for (uint32_t n = below(3); n > 0; n--)
			*numbers[below(17)] = wrong_number();
		for (uint32_t n = below(2); n > 0; n--)
			*times[below(6)] = (double)wrong_number();
		if (below(8) == 0)
			t.second.mNumVertices = below(6);
		if (below(8) == 0)
			m.tip.mName = m.right.mName;
		stilb_result result = importer_list_nodes(&m.import);
		if (result == STILB_OK)
			result = importer_add_meshes(&m.import);
		if (result == STILB_OK)
			result = importer_add_animation(&m.import);
		if (result != STILB_OK && !strstr(stilb_error_message(), "no triangles") &&
		    !strstr(stilb_error_message(), "of its root is NaN or infinite"))
			fail_msg("round %u: %s", round, stilb_error_message());
		assert_true(result != STILB_OK || scene_is_sound(m.import.scene));
		moving += result == STILB_OK && m.import.scene->animation;
		finish(&m);
	}
	assert_true(moving > ROUNDS / 2);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(bones_become_a_skin),
		cmocka_unit_test(vertices_with_other_bones_are_not_joined),
		cmocka_unit_test(what_has_no_bones_stays_with_its_node),
		cmocka_unit_test(the_heaviest_influences_are_kept),
		cmocka_unit_test(damaged_bones_are_left_out),
		cmocka_unit_test(split_vertices_keep_their_bones),
		cmocka_unit_test(three_paths_become_channels),
		cmocka_unit_test(nodes_have_poses),
		cmocka_unit_test(the_root_moves_in_our_axes),
		cmocka_unit_test(damaged_clips_are_left_out),
		cmocka_unit_test(names_mean_the_first_node),
		cmocka_unit_test(targets_are_differences),
		cmocka_unit_test(weights_of_targets_are_played),
		cmocka_unit_test(damaged_targets_are_left_out),
		cmocka_unit_test(random_damage_is_survived),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
