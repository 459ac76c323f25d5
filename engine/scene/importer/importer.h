/*
 * importer: Assimp's scene into Stilb's, in the process that scene_import.h tells of. It sends one scene or one error
 * and ends; what it allocates goes with it.
 */
#ifndef STILB_SCENE_IMPORTER_H
#define STILB_SCENE_IMPORTER_H

#include "scene/importer/importer_files.h"
#include "scene/scene_internal.h"

#include <assimp/scene.h>
#include <limits.h>

/* A place in the hierarchy, in the order of a walk that visits a node before its children. */
typedef struct importer_node {
	const struct aiNode *node;
	stilb_mat4 to_world;
} importer_node;

/* A texture by the name that materials call it by. */
typedef struct importer_texture {
	char name[MAXLEN];
	stilb_image image;    /* {0}: it could not be loaded */
	float mean[3];        /* of its texels' light */
	float stored_mean[3]; /* of the numbers in the file: what they are when they are no colours */
	char trouble[256];    /* why it could not be loaded */
	bool told;            /* its trouble was */

	int file; /* while they are loaded: the descriptor of its file, or -1 */
	const struct aiTexture *embedded;
} importer_texture;

typedef struct importer {
	const struct aiScene *from;
	const char *path;
	bool gltf; /* its lights have physical units */

	importer_node *nodes;
	uint32_t node_count, odd_nodes;
	importer_texture *textures; /* [texture_count], in the order in which materials name them */
	uint32_t texture_count;

	uint32_t clear_materials; /* that ask for transparency */
	stilb_scene *scene;
} importer;

#define IMPORTER_MAX_NODES 4000000u

/* Tells the reader something that does not keep the scene from being read. */
void importer_warn(const char *format, ...) __attribute__((format(printf, 1, 2)));

/* importer_nodes.c: lists the nodes; those whose place is no number are left out and counted in odd_nodes. */
stilb_result importer_list_nodes(importer *import);

/* The node of this name, or NULL. */
const importer_node *importer_find_node(const importer *import, const struct aiString *name);

static inline stilb_vec3 importer_vector(const struct aiVector3D *v)
{
	return stilb_vec3_make(v->x, v->y, v->z);
}

stilb_vec3 importer_point(const importer_node *node, stilb_vec3 p); /* to the world; node NULL: it is there already */
stilb_vec3 importer_direction(const importer_node *node, stilb_vec3 d); /* the same, unit */

/* importer_mesh.c: creates the scene, with every mesh that has triangles, a model for each node with such meshes, its
 * parts and bounds. STILB_ERROR_FILE: there are no triangles. */
stilb_result importer_add_meshes(importer *import);

/* importer_texture.c: lists the textures of all materials and loads them, by several threads. One that cannot be loaded
 * has no pixels. */
void importer_load_textures(importer *import);
void importer_free_textures(importer *import);

/* The index of a texture; UINT32_MAX, with a warning the first time: it could not be loaded. */
uint32_t importer_texture_of(importer *import, const char *name, const char *material);

/* importer_picture.c: decodes a picture into memory that can be shared. flags: of stilb_image_import_flags. Messages
 * start without a name. [any-thread] */
stilb_result importer_decode(const char *name, const importer_bytes *bytes, uint32_t flags, stilb_image *image);

/* Replaces image by three channels of linear floats, nothing below 0 nor infinite; image is {0} after an error. */
stilb_result importer_picture_to_light(stilb_image *image);

/* importer_material.c: fills the scene's materials, which there are as many of as Assimp's, and textures. */
stilb_result importer_add_materials(importer *import);

/* importer_view.c: lights and the first camera; a sky where nothing shines, a camera where there is none. After meshes
 * and materials. */
stilb_result importer_add_view(importer *import);

#endif
