/*
 * scene: what there is to see, as plain data: models, meshes, materials, lights, camera. No GPU, no traversal.
 *
 * A model is a bounding sphere and a run of parts; a part is a mesh, a material and a transform. Arrays are indexed by
 * id; whoever holds the scene may read them directly, and only scene_... functions and the stage `update_scene` write.
 *
 * Life cycle.  stilb_scene_open or stilb_scene_create_stress -> stilb_scene_animate once a frame (the stress test
 *              alone) -> stilb_scene_destroy.
 * Threads.     One writer, and nobody reads while it writes: main thread in update_scene, any thread reads after it.
 * Units.       Metres, seconds, radians; linear Rec.709; radiance in W sr^-1 m^-2, irradiance in W m^-2.
 */
#ifndef STILB_SCENE_H
#define STILB_SCENE_H

#include "base/base.h"
#include "base/base_math.h"
#include "image/image.h"

/* Position and unit normal in model space; uv in widths and heights of a texture, (0, 0) its top left. */
typedef struct stilb_scene_vertex {
	float position[3];
	float normal[3];
	float uv[2];
} stilb_scene_vertex;

/* Triangles, counter-clockwise seen from the front. */
typedef struct stilb_scene_mesh {
	stilb_scene_vertex *vertices;
	uint32_t *indices;
	uint32_t vertex_count, index_count;
} stilb_scene_mesh;

/* Reflectances per channel in [0, 1]; diffuse + specular <= 1 per channel holds for every material that went through
 * stilb_scene_material_make. specular is what a highlight reflects, at normal incidence where the model has a Fresnel
 * term. Which model shades it is the view's business (stilb_render_shading); what a model has no use for it leaves
 * out. */
typedef struct stilb_scene_material {
	float diffuse[3];
	float specular[3];
	float roughness;   /* [0, 1]; alpha is its square */
	float anisotropy;  /* (-1, 1), 0: none; above 0 a highlight is stretched along the tangent, below across it */
	float wrap;        /* [0, 1]: how far diffuse light reaches around the terminator; 0: not at all */
	float emission[3]; /* radiance that leaves the front, in all directions; the renderer of frames draws none */
	uint32_t diffuse_texture; /* 1 + its index in textures: multiplies diffuse; 0: none */
} stilb_scene_material;

/* direction points from the surface to the sun, unit; irradiance is measured across the beam. */
typedef struct stilb_scene_sun {
	float direction[3];
	float irradiance[3];
} stilb_scene_sun;

/* Radiance of the upper and of the lower half of the surroundings. */
typedef struct stilb_scene_sky {
	float sky[3];
	float ground[3];
} stilb_scene_sky;

/* A glowing ball, or a disk of that radius: for views whose light it is (stilb_render_shading). What each number means
 * is shade_light.h's. */
typedef struct stilb_scene_lamp {
	float position[3];
	float axis[3];      /* unit: where the disk faces */
	float intensity[3]; /* W sr^-1, along the axis of a disk */
	float radius;       /* metres, >= 0 */
	float reach;        /* metres, > radius: where windowed and subtracted light end */
} stilb_scene_lamp;

typedef enum stilb_scene_light_kind {
	STILB_SCENE_LIGHT_POINT,
	STILB_SCENE_LIGHT_SPOT,
	STILB_SCENE_LIGHT_DIRECTIONAL,
} stilb_scene_light_kind;

/* Lights without a size, beside the sun: what scene files hold. */
typedef struct stilb_scene_light {
	stilb_scene_light_kind kind;
	float position[3];          /* not DIRECTIONAL */
	float direction[3];         /* unit, the way it shines; not POINT */
	float intensity[3];         /* W sr^-1; DIRECTIONAL: irradiance across the beam, W m^-2 */
	float cos_inner, cos_outer; /* SPOT: full inside the inner angle from the axis, smoothly to nothing at the outer */
} stilb_scene_light;

/* Yaw 0 looks along -Z and grows to the left; pitch raises the view; roll then turns the camera about its view,
 * positive lowers its right side: the axis to the right is cos roll * right - sin roll * up of the upright camera. */
typedef struct stilb_scene_camera {
	float position[3];
	float yaw, pitch, roll;
	float fov_y;
	float near_z, far_z;
} stilb_scene_camera;

/* Bounding spheres, one array a component (culling reads them sixteen at a time): 64-byte aligned. */
typedef struct stilb_scene_bounds {
	float *x, *y, *z, *radius;
} stilb_scene_bounds;

typedef struct stilb_scene {
	uint32_t model_count;
	stilb_scene_bounds bounds; /* [model_count] */
	uint32_t *first_part;      /* [model_count + 1]: model m owns parts first_part[m] .. first_part[m + 1] - 1 */

	uint32_t part_count;
	uint32_t *part_mesh;        /* [part_count] */
	uint32_t *part_material;    /* [part_count] */
	stilb_mat4 *part_transform; /* [part_count] model to world, affine */

	uint32_t mesh_count;
	stilb_scene_mesh *meshes; /* [mesh_count] */
	uint32_t material_count;
	stilb_scene_material *materials; /* [material_count] */

	uint32_t moved_count; /* models whose bounds changed in this frame's update_scene ... */
	uint32_t *moved;      /* ... and their ids, ascending: [model_count] */

	uint32_t texture_count;
	stilb_image *textures; /* [texture_count]; of 1 to 4 channels; row 0 is v = 0, and repeated outside [0, 1] */
	uint32_t light_count;
	stilb_scene_light *lights; /* [light_count] */

	stilb_scene_sun sun; /* irradiance 0: there is none */
	stilb_scene_sky sky;
	stilb_image environment; /* latitude-longitude map of the surroundings' radiance in the place of sky: 3 channels,
	                          F32_LINEAR (stilb_scene_set_environment); {0}: none */
	stilb_scene_lamp lamp;
	stilb_scene_camera camera;
	uint64_t seed; /* of the stress test */
} stilb_scene;

/* ---- opening ----------------------------------------------------------------------------------------------------- */

/* X(name, what it shows). furnace takes a number: whatever the view, its radiance is 1 / (1 - RHO). In the middle of
 * the picture of plane-wall, at (1, 0, 0), the open share of the sky is (1 + cos 45 deg) / 2. */
#define STILB_SCENE_BUILTINS(X)                                                                                        \
	X("cornell", "the Cornell box: two blocks, a light in the ceiling")                                                \
	X("outdoor", "nine bumpy spheres on a field under a blue sky and a small bright sun")                              \
	X("furnace:RHO", "inside a ball that shines with radiance 1 and reflects RHO, 0 <= RHO < 1")                       \
	X("plane-wall", "a plane and a black wall 1 high along x = 0, under a sky of radiance 1")                          \
	X("stress", "10,000 spheres over tiles, as stilb demo shows them")                                                 \
	X("spheres", "seven spheres of different materials under a sky and an area light")

/* "cornell, outdoor, furnace:RHO, ...". [any-thread] */
const char *stilb_scene_builtin_names(void);

/* The scene that name stands for: a built-in, or else a file of any format that Assimp reads (./cornell is a file): its
 * triangles, materials, textures, lights, first camera. A file without a camera is seen whole; one without any light
 * gets a grey sky. What cannot be kept is told with stilb_log: a texture that is missing (its material becomes
 * magenta), transparency.
 *
 * Files are read by another process, stilb-scene-import: what crashes or never ends there is an error here. It is given
 * the file, and what the file names below its folder, and below that folder's parent where it says ../; nothing else,
 * and nothing through a symbolic link that leads out. It may take
 * three quarters of the machine's memory, 8 GiB at most, and 120 s, or as many as the environment's
 * STILB_IMPORT_SECONDS says.
 *
 * [main-thread] STILB_ERROR_ARGUMENT: a built-in's number is out of its range, there is no such file. STILB_ERROR_FILE:
 * no importer knows the file, it is damaged, it has no triangle. STILB_ERROR_MEMORY. *scene is NULL then. */
stilb_result stilb_scene_open(const char *name, stilb_scene **scene);

typedef struct stilb_scene_open_options {
	bool allow_outside; /* a file may name files outside of its folder and its parent: any that the user may read */
} stilb_scene_open_options;

/* The same with options. */
stilb_result stilb_scene_open_with(const char *name, const stilb_scene_open_options *options, stilb_scene **scene);

/* The surroundings from a latitude-longitude map, EXR or HDR (radiance), or sRGB of 8 or 16 bits: top row up, its
 * middle column at -Z, +X a quarter of the width to the right of that. Numbers that are none or below 0 become 0.
 * [one-writer] Read by the import process, too. STILB_ERROR_FILE, STILB_ERROR_MEMORY; then the scene is as before. */
stilb_result stilb_scene_set_environment(stilb_scene *scene, const char *path);

/* The same radiance from everywhere, in the place of sky and map. [one-writer] */
void stilb_scene_set_sky(stilb_scene *scene, const float radiance[3]);

/* What reads files of others, and what guards Stilb against it (docs/import.md). */
typedef struct stilb_scene_import_info {
	char assimp[32], openimageio[32]; /* versions, "5.2.4"; "not found" when the process cannot be started */
	bool privileges, landlock, seccomp, limits;
} stilb_scene_import_info;

/* Starts the import process and asks it. [main-thread] */
stilb_scene_import_info stilb_scene_import_query(void);

/* ---- the stress test ------------------------------------------------------------------------------------------- */

#define STILB_SCENE_MAX_MODELS 4000000u
#define STILB_SCENE_TILE 2.0f /* side of a ground tile, metres */

typedef enum stilb_scene_stress_view {
	STILB_SCENE_VIEW_ALL,  /* every model is in the picture */
	STILB_SCENE_VIEW_HALF, /* about half of them */
	STILB_SCENE_VIEW_FEW,  /* about one in a hundred */
} stilb_scene_stress_view;

/* model_count spheres over ground tiles on a square grid of side ceil(sqrt(model_count)), row by row; the last row may
 * be short. Tile corners lie at integer coordinates, exact in float, so that neighbours share the same floats.
 * Part 2m is model m's sphere and part 2m + 1 its tile; each has its own material. Everything that varies comes from
 * seed. 1 <= model_count <= STILB_SCENE_MAX_MODELS. The camera is left at stilb_scene_stress_camera(..., VIEW_ALL,
 * 16/9). */
stilb_result stilb_scene_create_stress(uint32_t model_count, uint64_t seed, stilb_scene **scene);

/* A camera for the stress test; aspect = width / height. VIEW_ALL holds for every aspect. */
stilb_scene_camera stilb_scene_stress_camera(const stilb_scene *scene, stilb_scene_stress_view view, float aspect);

/* Moves every tenth model (ids that are 0 modulo 10): its sphere bobs above its tile. seconds is the scene's time, not
 * the step, so the same time gives the same bits. Fills moved. */
void stilb_scene_animate(stilb_scene *scene, double seconds);

void stilb_scene_destroy(stilb_scene *scene);

/* ---- pieces ------------------------------------------------------------------------------------------------------ */

/* The closest material that conserves energy: reflectances clamped to >= 0, then scaled per channel so that diffuse +
 * specular <= 1 (shade_limit_to_one). roughness is clamped to [0, 1]; no anisotropy, no wrap. */
stilb_scene_material stilb_scene_material_make(const float diffuse[3], const float specular[3], float roughness);

/* Unit sphere from an icosahedron split `splits` times (0..6), 20 * 4^splits triangles, vertices on the sphere. u is
 * the longitude, 0 at -Z and growing eastward to 1 there again; v the latitude, 0 at the top, +Y, and 1 at the bottom.
 * Vertices are shared, so triangles across -Z and at the poles show a texture squeezed. */
stilb_result stilb_scene_mesh_sphere(uint32_t splits, stilb_scene_mesh *mesh);

/* The square x, z in [-1, 1] at y = 0, facing +Y, two triangles. u grows with x, v with z, each from 0 to 1. */
stilb_result stilb_scene_mesh_plane(stilb_scene_mesh *mesh);

void stilb_scene_mesh_finish(stilb_scene_mesh *mesh);

/* World to clip for a picture of this aspect. */
stilb_mat4 stilb_scene_camera_matrix(const stilb_scene_camera *camera, float aspect);

#endif
