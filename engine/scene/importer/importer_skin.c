/* Which bones of Assimp's make which skins. */
#include "scene/importer/importer_motion.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SKIN_MOST_JOINTS 65535u /* vertices name them by 16 bits, and the node's own comes before them */
#define SKIN_MOST_WEIGHT 1e9f

/* A bone that moves vertices. */
typedef struct skin_bone {
	uint32_t group;      /* the first mesh of those that share a skin */
	uint32_t node, slot; /* slot: in joint_of */
	stilb_mat4 inverse_bind;
} skin_bone;

typedef struct skin_planner {
	importer *import;
	const uint32_t *place;
	uint32_t *group;  /* [meshes] while groups are united a mesh before it in its group, or itself; then the first */
	skin_bone *bones; /* [bone_count] */
	uint32_t bone_count;
	bool *with_node; /* [meshes] of groups: some of their vertices have no bones */
} skin_planner;

void importer_motion_finish(importer_motion *motion)
{
	if (!motion)
		return;
	free(motion->names);
	free(motion->skin_of);
	free(motion->first_bone);
	free(motion->joint_of);
	free(motion->skins);
	free(motion->joints);
	for (uint32_t m = 0; motion->deforms && m < motion->mesh_count; m++)
		scene_deform_finish(&motion->deforms[m]);
	free(motion->deforms);
	free(motion->deform_from);
	free(motion);
}

/* ---- names ------------------------------------------------------------------------------------------------------- */

static int skin_compare_names(const void *left, const void *right)
{
	const importer_name *a = left, *b = right;
	int order = strcmp(a->name, b->name);
	return order != 0 ? order : a->node < b->node ? -1 : 1;
}

uint32_t importer_find_moving(importer *import, const char *name)
{
	importer_name *names = import->motion->names;
	uint32_t low = 0, high = import->node_count;
	while (low < high) {
		uint32_t middle = low + (high - low) / 2;
		if (strcmp(names[middle].name, name) < 0)
			low = middle + 1;
		else
			high = middle;
	}
	if (low == import->node_count || strcmp(names[low].name, name) != 0)
		return STILB_SCENE_NONE;
	if (low + 1 < import->node_count && strcmp(names[low + 1].name, name) == 0 && !names[low].told) {
		importer_lose(import, IMPORTER_LOSS_NAMESAKES, name);
		names[low].told = true;
	}
	return names[low].node;
}

stilb_result importer_count_moving(importer *import, uint64_t numbers)
{
	if (numbers > IMPORTER_MOVING_MOST - import->motion->numbers)
		return stilb_fail(STILB_ERROR_FILE, "it has more than %llu numbers that move", IMPORTER_MOVING_MOST);
	import->motion->numbers += numbers;
	return STILB_OK;
}

/* ---- groups ------------------------------------------------------------------------------------------------------ */

static uint32_t skin_first_of_group(const skin_planner *planner, uint32_t m)
{
	uint32_t *group = planner->group;
	while (group[m] != m)
		m = group[m] = group[group[m]];
	return m;
}

/* Meshes that a node shows are in one group. */
static void skin_unite(skin_planner *planner)
{
	const importer *import = planner->import;
	for (uint32_t m = 0; m < import->from->mNumMeshes; m++)
		planner->group[m] = m;
	for (uint32_t n = 0; n < import->node_count; n++) {
		const struct aiNode *node = import->nodes[n].node;
		uint32_t first = UINT32_MAX;
		for (uint32_t i = 0; i < node->mNumMeshes; i++) {
			uint32_t m = node->mMeshes[i];
			if (m >= import->from->mNumMeshes || planner->place[m] == UINT32_MAX)
				continue;
			uint32_t a = skin_first_of_group(planner, m), b = first == UINT32_MAX ? a : first;
			first = a < b ? a : b;
			planner->group[a] = planner->group[b] = first;
		}
	}
	for (uint32_t m = 0; m < import->from->mNumMeshes; m++)
		planner->group[m] = skin_first_of_group(planner, m);
}

/* ---- bones ------------------------------------------------------------------------------------------------------- */

/* False, with the reason: its bones cannot be used. */
static bool skin_mesh_is_sound(const struct aiMesh *mesh, char why[static 192])
{
	for (uint32_t b = 0; b < mesh->mNumBones; b++) {
		const struct aiBone *bone = mesh->mBones ? mesh->mBones[b] : NULL;
		if (!bone || (bone->mNumWeights > 0 && !bone->mWeights)) {
			snprintf(why, 192, "%.63s: bone %u is not there", mesh->mName.data, b);
			return false;
		}
		for (uint32_t w = 0; w < bone->mNumWeights; w++) {
			const struct aiVertexWeight *weight = &bone->mWeights[w];
			if (weight->mVertexId < mesh->mNumVertices && weight->mWeight <= SKIN_MOST_WEIGHT)
				continue;
			snprintf(why, 192, "%.63s: bone '%.63s' has vertex %u of %u with weight %g", mesh->mName.data,
			         bone->mName.data, weight->mVertexId, mesh->mNumVertices, (double)weight->mWeight);
			return false;
		}
	}
	return true;
}

static bool skin_moves_something(const struct aiBone *bone)
{
	for (uint32_t w = 0; w < bone->mNumWeights; w++)
		if (bone->mWeights[w].mWeight > 0.0f)
			return true;
	return false;
}

/* Lists a mesh's bones that can be used, and counts the others as lost. */
static void skin_list_bones(skin_planner *planner, uint32_t m)
{
	importer *import = planner->import;
	const struct aiMesh *mesh = import->from->mMeshes[m];
	char why[192];
	bool sound = skin_mesh_is_sound(mesh, why);
	if (!sound)
		importer_lose(import, IMPORTER_LOSS_BAD_DEFORMS, why);
	for (uint32_t b = 0; sound && b < mesh->mNumBones; b++) {
		const struct aiBone *bone = mesh->mBones[b];
		if (!skin_moves_something(bone))
			continue;
		uint32_t node = importer_find_moving(import, bone->mName.data);
		stilb_mat4 bind = importer_matrix(&bone->mOffsetMatrix);
		if (node == STILB_SCENE_NONE || !importer_is_finite(&bind)) {
			snprintf(why, sizeof why, "%.63s: bone '%.63s' %s", mesh->mName.data, bone->mName.data,
			         node == STILB_SCENE_NONE ? "is no node of the scene" : "has a matrix that is NaN or infinite");
			importer_lose(import, IMPORTER_LOSS_BAD_SKINS, why);
			continue;
		}
		planner->bones[planner->bone_count++] = (skin_bone){
			.group = planner->group[m], .node = node, .slot = import->motion->first_bone[m] + b, .inverse_bind = bind};
	}
}

static int skin_compare_bones(const void *left, const void *right)
{
	const skin_bone *a = left, *b = right;
	if (a->group != b->group)
		return a->group < b->group ? -1 : 1;
	if (a->node != b->node)
		return a->node < b->node ? -1 : 1;
	int order = memcmp(&a->inverse_bind, &b->inverse_bind, sizeof a->inverse_bind);
	return order != 0 ? order : a->slot < b->slot ? -1 : 1;
}

/* Gives the bones from `first` on, of one group, joints; returns where the next group begins. */
static uint32_t skin_make(skin_planner *planner, uint32_t first, uint32_t *joints)
{
	importer *import = planner->import;
	importer_motion *motion = import->motion;
	const skin_bone *bones = planner->bones;
	uint32_t end = first, group = bones[first].group;
	importer_skin skin = {.first_joint = *joints, .with_node = planner->with_node[group]};
	snprintf(skin.name, sizeof skin.name, "%.63s", import->from->mMeshes[group]->mName.data);
	if (!skin.name[0])
		snprintf(skin.name, sizeof skin.name, "number %u", motion->skin_count);
	for (; end < planner->bone_count && bones[end].group == group; end++) {
		const skin_bone *bone = &bones[end];
		bool same = end > first && bone[-1].node == bone->node &&
		            memcmp(&bone[-1].inverse_bind, &bone->inverse_bind, sizeof bone->inverse_bind) == 0;
		if (!same)
			motion->joints[skin.first_joint + skin.joint_count++] = (importer_joint){bone->node, bone->inverse_bind};
		motion->joint_of[bone->slot] = skin.joint_count - 1;
	}
	if (skin.joint_count > SKIN_MOST_JOINTS) {
		char why[192];
		snprintf(why, sizeof why, "%s: it has more than %u joints", skin.name, SKIN_MOST_JOINTS);
		importer_lose(import, IMPORTER_LOSS_BAD_SKINS, why);
		return end;
	}
	*joints += skin.joint_count;
	motion->skins[motion->skin_count++] = skin;
	motion->skin_of[group] = motion->skin_count;
	return end;
}

/* True if a vertex of the mesh has no bone that is used. False also without memory, in *result. */
static bool skin_leaves_vertices(const skin_planner *planner, uint32_t m, stilb_result *result)
{
	const importer_motion *motion = planner->import->motion;
	const struct aiMesh *mesh = planner->import->from->mMeshes[m];
	bool *moved = calloc(mesh->mNumVertices + 1ull, sizeof *moved), leaves = false;
	if (!moved) {
		*result = stilb_fail(STILB_ERROR_MEMORY, "no memory for its skins");
		return false;
	}
	for (uint32_t b = 0; b < mesh->mNumBones; b++)
		for (uint32_t w = 0;
		     motion->joint_of[motion->first_bone[m] + b] != STILB_SCENE_NONE && w < mesh->mBones[b]->mNumWeights; w++)
			if (mesh->mBones[b]->mWeights[w].mWeight > 0.0f)
				moved[mesh->mBones[b]->mWeights[w].mVertexId] = true;
	for (uint32_t v = 0; v < mesh->mNumVertices && !leaves; v++)
		leaves = !moved[v];
	free(moved);
	return leaves;
}

/* ---- all --------------------------------------------------------------------------------------------------------- */

static stilb_result skin_plan(skin_planner *planner, uint64_t bones)
{
	importer *import = planner->import;
	importer_motion *motion = import->motion;
	uint32_t meshes = import->from->mNumMeshes;
	planner->group = malloc((meshes + 1ull) * sizeof *planner->group);
	planner->with_node = calloc(meshes + 1ull, sizeof *planner->with_node);
	planner->bones = malloc((bones + 1) * sizeof *planner->bones);
	motion->joint_of = malloc((bones + 1) * sizeof *motion->joint_of);
	motion->joints = malloc((bones + 1) * sizeof *motion->joints);
	motion->skins = malloc((bones + 1) * sizeof *motion->skins);
	if (!planner->group || !planner->with_node || !planner->bones || !motion->joint_of || !motion->joints ||
	    !motion->skins)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for its skins");
	for (uint64_t b = 0; b < bones; b++)
		motion->joint_of[b] = STILB_SCENE_NONE;
	skin_unite(planner);
	for (uint32_t m = 0; m < meshes; m++)
		if (planner->place[m] != UINT32_MAX)
			skin_list_bones(planner, m);
	for (uint32_t b = 0; b < planner->bone_count; b++)
		motion->joint_of[planner->bones[b].slot] = 0; /* it is used; which joint it is, is decided below */
	stilb_result result = STILB_OK;
	for (uint32_t m = 0; result == STILB_OK && m < meshes; m++)
		if (planner->place[m] != UINT32_MAX)
			planner->with_node[planner->group[m]] |= skin_leaves_vertices(planner, m, &result);
	qsort(planner->bones, planner->bone_count, sizeof *planner->bones, skin_compare_bones);
	uint32_t joints = 0;
	for (uint32_t first = 0; result == STILB_OK && first < planner->bone_count;)
		first = skin_make(planner, first, &joints);
	for (uint32_t m = 0; m < meshes; m++)
		motion->skin_of[m] = motion->skin_of[planner->group[m]]; /* group[m] <= m has its own */
	return result;
}

stilb_result importer_plan_skins(importer *import, const uint32_t *place, uint32_t meshes)
{
	STILB_ASSERT(!import->motion && import->node_count > 0);
	uint32_t count = import->from->mNumMeshes;
	importer_motion *motion = import->motion = calloc(1, sizeof *motion);
	if (!motion)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for what moves");
	motion->mesh_count = meshes;
	motion->names = malloc(import->node_count * sizeof *motion->names);
	motion->skin_of = calloc(count + 1ull, sizeof *motion->skin_of);
	motion->first_bone = calloc(count + 1ull, sizeof *motion->first_bone);
	motion->deforms = calloc(meshes + 1ull, sizeof *motion->deforms);
	motion->deform_from = calloc(meshes + 1ull, sizeof(const struct aiMesh *));
	if (!motion->names || !motion->skin_of || !motion->first_bone || !motion->deforms || !motion->deform_from)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for what moves");
	for (uint32_t n = 0; n < import->node_count; n++)
		motion->names[n] = (importer_name){.name = import->nodes[n].node->mName.data, .node = n};
	qsort(motion->names, import->node_count, sizeof *motion->names, skin_compare_names);
	uint64_t bones = 0;
	for (uint32_t m = 0; m < count; m++) {
		motion->first_bone[m] = (uint32_t)bones;
		bones += place[m] == UINT32_MAX ? 0 : import->from->mMeshes[m]->mNumBones;
	}
	if (bones == 0)
		return STILB_OK;
	if (bones > STILB_SCENE_MAX_MODELS) {
		importer_lose(import, IMPORTER_LOSS_BAD_SKINS, "they have too many bones");
		return STILB_OK;
	}
	skin_planner planner = {.import = import, .place = place};
	stilb_result result = skin_plan(&planner, bones);
	free(planner.group);
	free(planner.with_node);
	free(planner.bones);
	return result;
}
