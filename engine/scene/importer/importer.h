/*
 * importer: converts scenes as the library Assimp reads them to Stilb's, in the import process: a program of its own
 * that reads files which Stilb does not trust (scene_import.h).
 *
 * Life cycle.  For each request an importer begins as {0}: Assimp reads the file -> importer_load_textures ->
 *              importer_list_nodes -> importer_add_meshes -> importer_add_materials -> importer_add_view -> the scene
 *              is sent -> everything is freed.
 * Errors.      Files hold anything: every index, count and number of Assimp's is checked before use. Messages are
 *              reasons without the file's name.
 * Threads.     The process's main thread, but for importer_decode and the decoding of textures.
 */
#ifndef STILB_SCENE_IMPORTER_H
#define STILB_SCENE_IMPORTER_H

#include "scene/importer/importer_files.h"
#include "scene/scene_internal.h"

#include <assimp/scene.h>
#include <limits.h>

/* A node of the hierarchy of transforms in Assimp's scene. */
typedef struct importer_node {
	const struct aiNode *node;
	stilb_mat4 to_world;
} importer_node;

typedef struct importer_texture {
	char name[MAXLEN];    /* as materials name it */
	stilb_image image;    /* {0}: it could not be loaded */
	float mean[3];        /* mean of its texels as linear light */
	float stored_mean[3]; /* mean of its values as stored, codes scaled to [0, 1]: for maps of numbers, not colours */
	char trouble[256];    /* why it could not be loaded */
	bool warned;          /* the user was warned of the trouble */

	int file;                         /* the descriptor of its file until it is read, or -1 */
	const struct aiTexture *embedded; /* the texture inside of the scene's file, or NULL */
} importer_texture;

typedef struct importer {
	const struct aiScene *from;
	const char *path;
	bool gltf; /* the file is glTF: its lights have physical units */

	importer_node *nodes; /* [node_count], a node before its children */
	uint32_t node_count;
	uint32_t bad_nodes;         /* nodes left out because their transform is not finite */
	importer_texture *textures; /* [texture_count], in the order in which materials name them */
	uint32_t texture_count;

	uint32_t transparent_materials;
	stilb_scene *scene; /* the result; from importer_add_meshes on */
} importer;

#define IMPORTER_MAX_NODES 4000000u

/* Sends a warning for the user: something of the file is lost, but the scene is read. */
void importer_warn(const char *format, ...) __attribute__((format(printf, 1, 2)));

/* importer_nodes.c: fills nodes from Assimp's hierarchy. Nodes whose transform to the world is not finite are left out,
 * with their children, and counted in bad_nodes. STILB_ERROR_FILE: no root, or more than IMPORTER_MAX_NODES;
 * STILB_ERROR_MEMORY. */
stilb_result importer_list_nodes(importer *import);

/* The first node of this name, or NULL. */
const importer_node *importer_find_node(const importer *import, const struct aiString *name);

static inline stilb_vec3 importer_vector(const struct aiVector3D *v)
{
	return stilb_vec3_make(v->x, v->y, v->z);
}

/* A point of the node's space in the world; the same point if node is NULL. */
stilb_vec3 importer_point(const importer_node *node, stilb_vec3 p);

/* A direction of the node's space in the world, unit length; -Z if it has no length. node may be NULL. */
stilb_vec3 importer_direction(const importer_node *node, stilb_vec3 d);

/* importer_mesh.c: creates the scene with every mesh that has triangles, and a model with its parts and bounds for each
 * node with such meshes. STILB_ERROR_FILE: there are no triangles, or too many parts; STILB_ERROR_MEMORY. */
stilb_result importer_add_meshes(importer *import);

/* importer_texture.c: lists the textures of all materials and loads them in several threads. One that cannot be loaded
 * has no pixels. */
void importer_load_textures(importer *import);
void importer_free_textures(importer *import);

/* The index of the texture of this name; UINT32_MAX, and a warning the first time, if it could not be loaded. material:
 * the name of the material that uses it. */
uint32_t importer_texture_of(importer *import, const char *name, const char *material);

/* importer_picture.c: decodes the file in bytes into a picture of stilb_image_create_shared. name tells TGA files;
 * flags: of stilb_image_import_flags. STILB_ERROR_FILE, STILB_ERROR_MEMORY; image is {0} then. [any-thread] */
stilb_result importer_decode(const char *name, const importer_bytes *bytes, uint32_t flags, stilb_image *image);

/* Replaces image by three channels of linear floats; NaN, infinite and negative values become 0. STILB_ERROR_MEMORY;
 * image is {0} then. */
stilb_result importer_picture_to_light(stilb_image *image);

/* importer_material.c: fills the scene's materials, one for each of Assimp's or a grey one if there are none, and moves
 * the textures that they use into the scene. STILB_ERROR_MEMORY. */
stilb_result importer_add_materials(importer *import);

/* importer_view.c: adds lights and the first camera; a sky if there is no light, a camera if there is none. Needs
 * meshes and materials. STILB_ERROR_MEMORY. */
stilb_result importer_add_view(importer *import);

#endif
