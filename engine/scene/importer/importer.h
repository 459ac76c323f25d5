/*
 * importer: converts scenes to Stilb's, in the import process: a program of its own that reads files which Stilb does
 * not trust (scene_import.h). glTF 2.0 is read here (gltf/gltf.h), every other format by the library Assimp.
 *
 * Life cycle.  For each request an importer begins as {0}: gltf_import, or Assimp reads the file ->
 *              importer_load_textures -> importer_list_nodes -> importer_add_meshes -> importer_add_materials ->
 *              importer_add_view -> importer_add_animation. Then importer_tell_losses -> the scene is sent ->
 *              everything is freed.
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
#include <math.h>

/* A node of the hierarchy of transforms in Assimp's scene. */
typedef struct importer_node {
	const struct aiNode *node;
	stilb_mat4 to_world;
	uint32_t parent; /* among the listed nodes, or STILB_SCENE_NONE */
	stilb_mat4 local;
} importer_node;

typedef struct importer_texture {
	char name[MAXLEN];    /* as materials name it, or of glTF as its user knows it */
	stilb_image image;    /* {0}: it could not be loaded */
	float mean[3];        /* mean of its texels as linear light */
	float stored_mean[4]; /* mean of its values as stored, codes scaled to [0, 1]: for maps of numbers, not colours.
	                         The fourth is alpha's */
	char trouble[256];    /* why it could not be loaded */
	uint32_t file_width, file_height; /* of the file's picture, before importer_mend_sides */
	uint64_t mended;                  /* values that were NaN or infinite */
	bool warned[2];                   /* the user was warned of the trouble, as data and as a colour */
	stilb_image_format format;        /* of its image, once that is taken */
	uint32_t taken[2]; /* 1 + the scene's texture of it, as data and as a colour; 0: it is not needed as that */

	int file;                       /* the descriptor of its file until it is read, or -1 */
	importer_bytes inside;          /* its file inside of the scene's file, not owned, or {0} */
	char hint[HINTMAXTEXTURELEN];   /* the format of that file, "tga"; "": unknown */
	const struct aiTexture *texels; /* its texels inside of the scene's file, or NULL */
} importer_texture;

/* What of a file is not shown. The words are in importer_loss.c. */
typedef enum importer_loss {
	IMPORTER_LOSS_CUTOUTS,
	IMPORTER_LOSS_UNSEEN,
	IMPORTER_LOSS_NORMAL_MAPS,
	IMPORTER_LOSS_OCCLUSION_MAPS,
	IMPORTER_LOSS_METAL_MAPS,
	IMPORTER_LOSS_SPECULAR_MAPS,
	IMPORTER_LOSS_VARIANT_MAPPINGS,
	IMPORTER_LOSS_SETS,
	IMPORTER_LOSS_LINES,
	IMPORTER_LOSS_POSITIONS,
	IMPORTER_LOSS_TRIANGLES,
	IMPORTER_LOSS_INFINITE,
	IMPORTER_LOSS_ANIMATIONS,
	IMPORTER_LOSS_BAD_DEFORMS,
	IMPORTER_LOSS_BAD_SKINS,
	IMPORTER_LOSS_BAD_ANIMATIONS,
	IMPORTER_LOSS_INFLUENCES,
	IMPORTER_LOSS_NAMESAKES,
	IMPORTER_LOSS_STRAYS,
	IMPORTER_LOSS_REPEATS,
	IMPORTER_LOSS_MESH_FRAMES,
	IMPORTER_LOSS_EXTRAS,
	IMPORTER_LOSS_SCENES,
	IMPORTER_LOSS_CAMERAS,
	IMPORTER_LOSS_LIGHTS,
	IMPORTER_LOSS_FALLOFFS,
	IMPORTER_LOSS_MIRRORS,
	IMPORTER_LOSS_LAYERS,
	IMPORTER_LOSS_WIRES,
	IMPORTER_LOSSES,
} importer_loss;

typedef struct importer_lost {
	uint32_t count;
	char first[96]; /* the name of the first thing that has it; "": it has no name */
} importer_lost;

typedef struct importer {
	const struct aiScene *from; /* NULL: the file is glTF 2.0 */
	const char *path;
	bool gltf;           /* Assimp read glTF 1.0, whose lights have physical units */
	bool shares;         /* it has no normals, and its triangles share vertices across edges */
	bool up_is_y;        /* the file says so where its format leaves that open */
	importer_node world; /* node NULL: the space of the file's scene in ours, whose up is y */

	importer_node *nodes; /* [node_count], a node before its children */
	uint32_t node_count;
	uint32_t bad_nodes;         /* nodes left out because their transform is not finite */
	importer_texture *textures; /* [texture_count], in the order in which materials name them */
	uint32_t texture_count;

	struct importer_motion *motion; /* importer_motion.h; NULL: before importer_add_meshes, and of glTF 2.0 */
	bool joins; /* something changes the shapes of meshes: we join vertices that are the same, not Assimp */

	bool *colored; /* [materials of Assimp's + 1]: a mesh with colours of vertices shows it */
	importer_lost lost[IMPORTER_LOSSES];
	stilb_scene *scene; /* the result; from importer_add_meshes or gltf_add_meshes on */
} importer;

#define IMPORTER_MAX_NODES 4000000u
#define IMPORTER_MOVING_MOST (1ull << 28) /* numbers of all clips, skins and morph targets of a file, 1 GiB */

/* Sends a warning for the user: something of the file is lost, but the scene is read. */
void importer_warn(const char *format, ...) __attribute__((format(printf, 1, 2)));

/* Tells Stilb, every 20 ms at most, that `done` of `count` textures are loaded, or of meshes are converted, which come
 * after the textures. Main thread. */
void importer_advance_textures(uint32_t done, uint32_t count);
void importer_advance_meshes(const importer *import, uint32_t done, uint32_t count);

/* importer_loss.c: counts a thing that is not shown as it should be. name: the material's, the mesh's, ...; NULL: it
 * has none. */
void importer_lose(importer *import, importer_loss loss, const char *name);

/* Warns once of each kind of loss. */
void importer_tell_losses(const importer *import);

/* NaN becomes low. */
static inline float importer_clamp(float value, float low, float high)
{
	STILB_ASSERT(low < high);
	return !(value > low) ? low : value < high ? value : high;
}

/* importer_axes.c: the transform from the axes of the file's scene to ours. up_is_y: importer_up_is_y of its bytes. */
stilb_mat4 importer_axes(const struct aiScene *scene, bool up_is_y);

/* True if the file at path is of a format that leaves open which way is up, and says that y is. */
bool importer_up_is_y(const char *path, const importer_bytes *bytes);

/* True if what Assimp calls the format begins so. */
bool importer_is_format(const struct aiScene *scene, const char *begins);

/* importer_assimp.c: reads the file by Assimp into import->from, with all polygons split into triangles, and counts
 * what of it is not shown. STILB_ERROR_FILE, STILB_ERROR_MEMORY. */
stilb_result importer_read(importer *import);

/* importer_nodes.c: a stilb_mat4, which is column-major, of a matrix of Assimp's, which is row-major. */
stilb_mat4 importer_matrix(const struct aiMatrix4x4 *m);
bool importer_is_finite(const stilb_mat4 *m);

/* Fills nodes from Assimp's hierarchy. Nodes whose transform to the world is not finite are left out, with their
 * children, and counted in bad_nodes. STILB_ERROR_FILE: no root, one of NaN, or more than IMPORTER_MAX_NODES nodes;
 * STILB_ERROR_MEMORY. */
stilb_result importer_list_nodes(importer *import);

/* Adds the listed nodes to the scene, in their order. STILB_ERROR_MEMORY. */
stilb_result importer_add_nodes(importer *import);

/* The first node of this name; without one `world`. */
const importer_node *importer_find_node(const importer *import, const struct aiString *name);

static inline stilb_vec3 importer_vector(const struct aiVector3D *v)
{
	return stilb_vec3_make(v->x, v->y, v->z);
}

/* False: a coordinate is NaN or infinite. */
static inline bool importer_is_point(const struct aiVector3D *v)
{
	return isfinite(v->x) && isfinite(v->y) && isfinite(v->z);
}

/* A point of the node's space in the world. */
stilb_vec3 importer_point(const importer_node *node, stilb_vec3 p);

/* importer_mesh.c: creates the scene with every mesh that has triangles, and a model with its parts and bounds for each
 * node with such meshes. STILB_ERROR_FILE: there are no triangles, or too many parts; STILB_ERROR_MEMORY. */
stilb_result importer_add_meshes(importer *import);

/* importer_tangents.c: gives a mesh with extras tangents for a map of normals that lies so (MikkTSpace); vertices that
 * need more than one are there once for each. sources: [vertex_count] which vertex of before each one is, of malloc,
 * for the caller to free; NULL: nobody asks. STILB_ERROR_MEMORY; then the mesh is as it was. */
stilb_result importer_make_tangents(stilb_scene_mesh *mesh, const stilb_scene_map *map, uint32_t **sources);

/* importer_texture.c: lists the textures of all materials and loads them in several threads. One that cannot be loaded
 * has no pixels. */
void importer_load_textures(importer *import);
void importer_free_textures(importer *import);

/* importer_mend.c: values of a picture of floats that are NaN or infinite become 0. How many. */
uint64_t importer_mend_values(stilb_image *image);

/* Halves a picture of stilb_image_create_shared, by means of four values as they are stored, until a scene can hold it.
 * STILB_ERROR_MEMORY; then it may be smaller than before. */
stilb_result importer_mend_sides(stilb_image *image);

/* importer_material.c: true if the material of Assimp's has a map of normals that is shown. */
bool importer_material_has_normals(const struct aiMaterial *material);

/* False for no name, and for the one that Assimp gives where a format has textures and the file names none (MD2, MDL):
 * such a material has the colour that Assimp gives it. */
bool importer_texture_is_named(const struct aiString *path);

/* Decodes all listed textures and takes their means, in several threads. One that cannot be loaded has no pixels. */
void importer_decode_textures(importer *import);

/* True if the texture of this index could be loaded; if not, warns of it the first time. material: the name of the
 * material that uses it. color: without it, the material becomes magenta. */
bool importer_texture_is_there(importer *import, uint32_t index, const char *material, bool color);

/* In place of a texture's number in a material or a surface until importer_take_textures: the texture of this index, as
 * colours or as data. */
static inline uint32_t importer_texture_number(uint32_t index, bool color)
{
	return 1 + 2 * index + color;
}

/* The index of the texture of this name; UINT32_MAX, and a warning the first time, if it could not be loaded. material:
 * the name of the material that uses it. */
uint32_t importer_texture_of(importer *import, const char *name, const char *material, bool color);

/* importer_surface.c: makes a surface, the picture of whose colour could not be loaded, magenta. It keeps its emission,
 * alpha and normals. */
void importer_magenta(stilb_scene_surface *surface);

/* True if the factors of the surface leave nothing of a map of this kind to be seen, so that nobody needs its
 * picture. */
bool importer_hides_map(const stilb_scene_surface *surface, stilb_scene_map_kind kind);

/* True if the surface has more than a base: a coat, sheen, light that passes through it, or a direction of brushing. */
bool importer_has_layers(const stilb_scene_surface *surface);

/* Makes a material's constants, the means of a surface whose maps name textures by importer_texture_number; colours of
 * vertices do not count. Its surface is 0. */
void importer_constants(const importer *import, const stilb_scene_surface *surface, stilb_scene_material *material);

/* importer_picture.c: decodes the file in bytes into a picture of stilb_image_create_shared. name tells TGA files;
 * flags: of stilb_image_import_flags. STILB_ERROR_FILE, STILB_ERROR_MEMORY; image is {0} then. [any-thread] */
stilb_result importer_decode(const char *name, const importer_bytes *bytes, uint32_t flags, stilb_image *image);

/* Replaces image by three channels of linear floats; NaN, infinite and negative values become 0. STILB_ERROR_MEMORY;
 * image is {0} then. */
stilb_result importer_picture_to_light(stilb_image *image);

/* importer_material.c: fills the scene's materials, one for each of Assimp's or a grey one if there are none, and moves
 * the textures that they use into the scene. STILB_ERROR_MEMORY. */
stilb_result importer_add_materials(importer *import);

#define IMPORTER_DIELECTRIC 0.04f /* reflectance of glass and plastic at normal incidence, an index of 1.5 */

/* Moves the textures that the scene's materials and surfaces refer to by importer_texture_number into the scene and
 * renumbers them. STILB_ERROR_MEMORY. */
stilb_result importer_take_textures(importer *import);

/* importer_view.c: adds lights, ambient light and cameras. Needs meshes.
 * STILB_ERROR_MEMORY. */
stilb_result importer_add_view(importer *import);

/* Adds a camera on a node of this place, with an angle of the picture's height in radians. scene_add_cameras and
 * scene_add_mounts have made room for it, and camera_count is that of the cameras so far. False: it is out of range. */
bool importer_add_camera(importer *import, const char *name, const stilb_scene_mount *mount, const stilb_mat4 *to_world,
                         float fov_y);

#endif
