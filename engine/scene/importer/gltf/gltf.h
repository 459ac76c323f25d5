/*
 * gltf: reads files of glTF 2.0, .gltf and .glb, in the import process. Our own reader, for what Assimp and tinygltf
 * refuse or lose: sparse accessors of every kind, compressed meshes, uv sets, transforms of textures, instances. It
 * goes over the JSON where it lies (scene_json.h); vertices are converted from the file's bytes straight into the
 * scene's, and only those that a triangle of the shown scene uses.
 *
 * Sources: the glTF 2.0 specification and the extensions of Khronos' registry that gltf_extensions.c lists.
 *
 * Life cycle.  gltf_is -> gltf_import, which goes through: gltf_open -> gltf_list_nodes -> gltf_load_textures ->
 *              gltf_add_meshes -> gltf_add_materials -> gltf_add_variants ->
 *              gltf_add_animation -> gltf_add_view -> gltf_close.
 * Errors.      Files hold anything: every index, offset, count and stride is checked before use. Messages are reasons
 *              without the file's name. What cannot be shown is counted with importer_lose.
 * Threads.     The process's main thread.
 */
#ifndef STILB_SCENE_GLTF_H
#define STILB_SCENE_GLTF_H

#include "scene/importer/importer.h"
#include "scene/open/scene_json.h"
#include "scene/scene_animation_internal.h"

#define GLTF_NONE SCENE_JSON_NONE /* no token, no index */

/* The arrays of a file's JSON whose values others name by their index: X(name in C, key). */
#define GLTF_LISTS(X)                                                                                                  \
	X(ACCESSORS, "accessors")                                                                                          \
	X(ANIMATIONS, "animations")                                                                                        \
	X(BUFFERS, "buffers")                                                                                              \
	X(VIEWS, "bufferViews")                                                                                            \
	X(CAMERAS, "cameras")                                                                                              \
	X(IMAGES, "images")                                                                                                \
	X(MATERIALS, "materials")                                                                                          \
	X(MESHES, "meshes")                                                                                                \
	X(NODES, "nodes")                                                                                                  \
	X(SAMPLERS, "samplers")                                                                                            \
	X(SCENES, "scenes")                                                                                                \
	X(SKINS, "skins")                                                                                                  \
	X(TEXTURES, "textures")                                                                                            \
	X(LIGHTS, "lights")     /* of the extension KHR_lights_punctual */                                                 \
	X(VARIANTS, "variants") /* of KHR_materials_variants */

typedef enum gltf_list_kind {
#define GLTF_LIST_KIND(name, key) GLTF_##name,
	GLTF_LISTS(GLTF_LIST_KIND)
#undef GLTF_LIST_KIND
		GLTF_LIST_COUNT,
} gltf_list_kind;

typedef struct gltf_list {
	uint32_t *items; /* [count]: tokens */
	uint32_t count;
} gltf_list;

typedef struct gltf_buffer {
	const unsigned char *data; /* [size]; NULL: it has none, as a buffer that only a compressed view replaces */
	uint64_t size;
	unsigned char *own; /* data if it is not a part of the file; else NULL */
} gltf_buffer;

/* A buffer view whose range has been checked. */
typedef struct gltf_view {
	const unsigned char *data; /* [size]; NULL: it was not used yet */
	uint64_t size;
	uint32_t stride;    /* bytes from one element to the next; 0: they follow one another */
	unsigned char *own; /* data if the view was compressed; else NULL */
} gltf_view;

/* A node of the scene that is shown. */
typedef struct gltf_node {
	uint32_t item;   /* its token */
	uint32_t index;  /* in the file's list */
	uint32_t parent; /* among the nodes of the scene; GLTF_NONE: it has none */
	stilb_mat4 to_world;
	uint32_t first_model, model_count; /* that show its mesh; once they are there */
} gltf_node;

/* One primitive of a mesh, converted. */
typedef struct gltf_part {
	stilb_scene_mesh mesh;
	uint32_t item;             /* its token */
	uint32_t material;         /* of the scene */
	stilb_scene_deform deform; /* {0}: its vertices have neither joints nor morph targets */
} gltf_part;

/* The parts of mesh m are parts[first[m]] .. parts[first[m + 1] - 1]; a mesh that the scene does not show has none. */
typedef struct gltf_parts {
	gltf_part *parts; /* [count] */
	uint32_t count, capacity;
	uint32_t *first; /* [meshes + 1] */
} gltf_parts;

typedef struct gltf {
	importer *import;
	scene_json json;
	gltf_list lists[GLTF_LIST_COUNT];
	importer_bytes binary; /* the binary part of a .glb, inside of the file's bytes; {0}: none */
	uint64_t bytes;        /* of the file and its buffers together */
	gltf_buffer *buffers;  /* [lists[GLTF_BUFFERS].count] */
	gltf_view *views;      /* [lists[GLTF_VIEWS].count] */
	gltf_node *nodes;      /* [node_count], a node before its children */
	uint32_t node_count;
	uint32_t *picture;        /* [lists[GLTF_IMAGES].count]: 1 + the index in import->textures; 0: it is not used */
	unsigned char **unpacked; /* [lists[GLTF_IMAGES].count]: bytes of a picture from a data: name, or NULL */
	gltf_parts parts;
	uint64_t moving;             /* numbers of all deforms and clips so far */
	bool needs_default_material; /* a part has no material: the scene's last one is for these */
	uint8_t *shown;              /* [materials + 1]: how parts show the material: GLTF_SHOWN_... */
} gltf;

/* ---- gltf_open.c: the file and its buffers ----------------------------------------------------------------------- */

/* True if the file at path with these bytes is glTF 2.0, or is named .gltf and of no other version. Version 1 is left
 * to Assimp. */
bool gltf_is(const char *path, const importer_bytes *bytes);

/* Converts the file into import->scene. Errors of the steps. */
stilb_result gltf_import(importer *import, const importer_bytes *bytes);

/* STILB_ERROR_FILE: it is damaged, or a buffer cannot be read; STILB_ERROR_MEMORY. Afterwards gltf_close. */
stilb_result gltf_open(gltf *from, const importer_bytes *bytes);
void gltf_close(gltf *from);

/* Lists the tokens of the objects in the array of this key, to be freed by its caller, also after a failure.
 * STILB_ERROR_FILE: a value is no object; STILB_ERROR_MEMORY. */
stilb_result gltf_list_items(gltf *from, uint32_t object, const char *key, gltf_list *list);

/* The index of this key's value in a list; GLTF_NONE: there is no such key, or it is out of range, which is a fault. */
uint32_t gltf_reference(gltf *from, uint32_t object, const char *key, gltf_list_kind kind);

/* The value of an extension of an object; GLTF_NONE: it has none. */
uint32_t gltf_extension(gltf *from, uint32_t object, const char *name);

/* The name of an item of a list for messages: its own, or "number 3". */
void gltf_name(gltf *from, gltf_list_kind kind, uint32_t index, char name[static 96]);

/* Makes a buffer view usable; *view stays until gltf_close. STILB_ERROR_FILE: it is out of range of its buffer, or does
 * not decompress; STILB_ERROR_MEMORY. */
stilb_result gltf_view_use(gltf *from, uint32_t index, const gltf_view **view);

/* The bytes behind the `data:` of a name, to be freed; NULL: it is no such name, or there is no memory. */
unsigned char *gltf_unpack(gltf *from, uint32_t uri, size_t *size);

/* The name of a file, with %20 and the like resolved; false: it is too long or empty. */
bool gltf_file_name(gltf *from, uint32_t uri, char *name, size_t room);

/* gltf_meshopt.c: decompresses a view by EXT_meshopt_compression. extension: its token. Errors of gltf_view_use. */
stilb_result gltf_meshopt_decode(gltf *from, uint32_t extension, gltf_view *view);

/* ---- gltf_accessor.c --------------------------------------------------------------------------------------------- */

/* The numbers of an accessor, in range of its view. */
typedef struct gltf_accessor {
	const unsigned char *data; /* of the first element; NULL: all are 0 */
	uint64_t count;
	uint32_t stride;
	uint32_t components; /* 1..4, 9, 16 */
	uint32_t type;       /* glTF's componentType, 5120..5126 */
	bool normalized;
	void *own; /* data if it is a copy, as of a sparse or a compressed one, freed by gltf_accessor_finish; else NULL */
} gltf_accessor;

/* components: those that it must have, as a mask of 1 << (components - 1). STILB_ERROR_FILE: the accessor is out of
 * range or of another shape, the message has its number; STILB_ERROR_MEMORY. accessor is {0} then. */
stilb_result gltf_accessor_open(gltf *from, uint32_t index, uint32_t components, gltf_accessor *accessor);

/* Accepts {0}. */
void gltf_accessor_finish(gltf_accessor *accessor);

/* Element i < count as floats, normalised integers scaled to [-1, 1] or [0, 1]. out has room for its components. */
void gltf_accessor_read(const gltf_accessor *accessor, uint64_t i, float *out);

/* Element i < count of one component as a whole number; of floats, negative and larger ones GLTF_NONE. */
uint32_t gltf_accessor_index(const gltf_accessor *accessor, uint64_t i);

/* ---- nodes, meshes, materials, view ------------------------------------------------------------------------------ */

/* Lists the nodes of the scene that is shown: the default one, the first, or without scenes all nodes without parents.
 * STILB_ERROR_FILE: the hierarchy is recursive; STILB_ERROR_MEMORY. */
stilb_result gltf_list_nodes(gltf *from);

bool gltf_is_finite(const stilb_mat4 *m);

/* Decodes the pictures that materials need. STILB_ERROR_FILE, STILB_ERROR_MEMORY. */
stilb_result gltf_load_textures(gltf *from);

/* The picture of a texture info (an object with index, texCoord, ...): its index in import->textures; GLTF_NONE: there
 * is none. */
uint32_t gltf_texture_picture(gltf *from, uint32_t info);

#define GLTF_SETS_MOST 1000u /* uv of higher numbers count as of this one */

/* What a material needs of vertices. */
typedef struct gltf_sets {
	uint32_t set[2];        /* the attributes TEXCOORD_<n> of the two uv that vertices have; GLTF_NONE: none */
	bool any;               /* it has maps */
	bool second;            /* one of them lies on the second uv */
	bool normals;           /* it needs tangents */
	stilb_scene_map normal; /* how the map lies that they are for */
} gltf_sets;

/* gltf_surface.c: the uv 0 and 1 if all maps lie on these, else the lowest two that maps lie on. material: of the file;
 * GLTF_NONE: the default one. */
gltf_sets gltf_material_sets(gltf *from, uint32_t material);

/* The token of the texture info of a material's map; GLTF_NONE: there is none, or nothing of it is shown. item: the
 * material's token. */
uint32_t gltf_map_info(gltf *from, uint32_t item, stilb_scene_map_kind kind);

/* Reads how a map lies, but not its texture. False: it lies on a uv that vertices do not have. */
bool gltf_map_read(gltf *from, uint32_t info, const gltf_sets *sets, stilb_scene_map *map);

/* Reads all of a surface but its maps. item: the material's token. */
void gltf_surface_factors(gltf *from, uint32_t item, stilb_scene_surface *surface);

/* True if the material, of the scene, has more than constants. */
bool gltf_material_needs_surface(gltf *from, uint32_t material);

/* gltf_variant.c: what a primitive's material and those of its variants need together; material: its own or GLTF_NONE.
 * If they disagree on the sets, that is counted as lost. name: of the mesh. */
gltf_sets gltf_variant_sets(gltf *from, uint32_t primitive, uint32_t material, const char *name);

#define GLTF_SHOWN_COLORED 1u  /* with colours of vertices */
#define GLTF_SHOWN_MIRRORED 2u /* by a node that mirrors it */

/* Notes how a primitive's material, one of the scene, and those of its variants are shown. */
void gltf_show_materials(gltf *from, uint32_t primitive, uint32_t material, uint8_t how);

/* Adds the variants of the materials of the scene's parts. STILB_ERROR_FILE, STILB_ERROR_MEMORY. */
stilb_result gltf_add_variants(gltf *from);

/* The matrix of a node in its parent; of translation, rotation and scale if it has no matrix of its own. */
typedef struct gltf_place {
	bool moves; /* it is made of the pose, whose rotation is as the file has it, of any length */
	stilb_scene_pose pose;
	stilb_mat4 local;
} gltf_place;
gltf_place gltf_node_place(gltf *from, uint32_t item);

/* gltf_deform.c: reads the skin and the morph targets of a primitive. source: for each vertex of the mesh that of the
 * file; packed: the joints and weights that were compressed with it, or {0}. What is damaged is counted as lost.
 * STILB_ERROR_MEMORY. name: of the mesh. */
stilb_result gltf_deform_read(gltf *from, const uint32_t *source, const gltf_accessor packed[2], const char *name,
                              gltf_part *part);

/* Counts what is damaged as lost, with the reason, so that reading goes on. STILB_ERROR_MEMORY is not damage, and
 * returned. */
stilb_result gltf_leave_out(gltf *from, stilb_result result, importer_loss loss, const char *name);

/* gltf_animation.c: adds nodes, clips, skins and morph targets to the scene, if anything of it moves.
 * STILB_ERROR_MEMORY. */
stilb_result gltf_add_animation(gltf *from);

/* Adds the listed nodes to the scene, in their order, and reserves room for more. STILB_ERROR_FILE,
 * STILB_ERROR_MEMORY. */
stilb_result gltf_add_nodes(gltf *from, uint32_t instances);

/* Creates the scene with its nodes and the meshes that it shows, and a model for each node, or instance of one, that
 * has any. STILB_ERROR_FILE: there are no triangles, or too many parts; STILB_ERROR_MEMORY. */
stilb_result gltf_add_meshes(gltf *from);

/* gltf_primitive.c: converts a primitive. No triangles: part->mesh is {0}. Errors of gltf_accessor_open. */
stilb_result gltf_primitive_convert(gltf *from, uint32_t mesh, uint32_t primitive, gltf_part *part);

/* Fills the scene's materials. STILB_ERROR_FILE, STILB_ERROR_MEMORY. */
stilb_result gltf_add_materials(gltf *from);

/* Adds lights and cameras. STILB_ERROR_FILE, STILB_ERROR_MEMORY. */
stilb_result gltf_add_view(gltf *from);

/* gltf_extensions.c: names the extensions, animations, skins, ... of the file that are not shown. */
void gltf_tell_extensions(gltf *from);

#endif
