/*
 * importer_motion: what moves in a scene of Assimp's: its bones, morph targets and animations become skins, deforms and
 * clips of scene_animation.h. Node n of importer->nodes is node n there.
 *
 * Life cycle.  importer_plan_skins, once the nodes are listed -> importer_read_deform for each mesh ->
 *              importer_add_animation, once the models are there -> importer_motion_finish.
 * Errors.      Every index and number of Assimp's is checked. What is damaged is left out and counted with
 *              importer_lose.
 * Threads.     The process's main thread.
 */
#ifndef STILB_SCENE_IMPORTER_MOTION_H
#define STILB_SCENE_IMPORTER_MOTION_H

#include "scene/importer/importer.h"
#include "scene/scene_animation_internal.h"

/* A node's name; importer_motion.names is sorted by them. */
typedef struct importer_name {
	const char *name;
	uint32_t node;
	bool told; /* that other nodes have it, too */
} importer_name;

typedef struct importer_joint {
	uint32_t node;
	stilb_mat4 inverse_bind;
} importer_joint;

/* Nodes have one skin each: meshes that are shown by the same node, or have to do with each other by way of several
 * nodes, share theirs. */
typedef struct importer_skin {
	uint32_t first_joint, joint_count; /* in importer_motion.joints */
	bool with_node; /* joint 0, before these, is the node that shows the mesh: vertices without bones stay with it */
	char name[64];
} importer_skin;

typedef struct importer_motion {
	importer_name *names; /* [node_count] */
	uint32_t *skin_of;    /* [meshes of Assimp's] 1 + its skin; 0: none */
	uint32_t *first_bone; /* [meshes of Assimp's + 1] of a mesh's bones, in joint_of */
	uint32_t *joint_of;   /* of each bone its joint among those of the skin; STILB_SCENE_NONE: it is left out */
	importer_skin *skins; /* [skin_count] */
	importer_joint *joints;
	uint32_t skin_count, mesh_count;
	stilb_scene_deform *deforms;       /* [meshes of the scene] {0}: it does not change */
	const struct aiMesh **deform_from; /* [meshes of the scene] */
	uint64_t numbers;                  /* of all deforms and clips so far */
} importer_motion;

/* Accepts NULL, and frees the struct, too. */
void importer_motion_finish(importer_motion *motion);

/* importer_skin.c: decides which bones and nodes make which skins. place: of each mesh of Assimp's its mesh in the
 * scene, UINT32_MAX: it is not shown. meshes: of the scene. STILB_ERROR_MEMORY. */
stilb_result importer_plan_skins(importer *import, const uint32_t *place, uint32_t meshes);

/* The first listed node of this name, STILB_SCENE_NONE: there is none. Another one of the same name is counted as
 * lost. */
uint32_t importer_find_moving(importer *import, const char *name);

/* Counts `numbers` more that move. STILB_ERROR_FILE: these are too many. */
stilb_result importer_count_moving(importer *import, uint64_t numbers);

/* importer_deform.c: reads the bones and morph targets of mesh m of Assimp's, which has become this one, mesh `place`
 * of the scene. source: for each of its vertices that of the file; NULL: it is the same. flipped: its normals are the
 * file's, turned around. Vertices that are the same in everything are joined afterwards. STILB_ERROR_MEMORY. */
stilb_result importer_read_deform(importer *import, uint32_t m, const uint32_t *source, bool flipped, uint32_t place,
                                  stilb_scene_mesh *mesh);

/* importer_animation.c: adds nodes, clips, skins and morph targets to the scene, if anything of it moves.
 * STILB_ERROR_MEMORY. */
stilb_result importer_add_animation(importer *import);

#endif
