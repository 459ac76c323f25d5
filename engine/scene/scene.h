/*
 * scene: the world as plain data: models, meshes, materials, textures, lights, surroundings, camera. No GPU, no
 * traversal.
 *
 * A model is a bounding sphere and parts that follow one another; a part is a mesh, a material and a transform. The id
 * of a model, part, mesh, ... is its index in the arrays. Everybody may read them; only stilb_scene_... functions and
 * the frame's stage `update_scene` write. scene_build.h makes a scene, scene_edit.h changes one.
 *
 * Life cycle.  stilb_scene_open or stilb_scene_create_stress -> stilb_scene_destroy. Between them the
 *              surroundings, the lights and the camera may be replaced.
 * Per frame.   stilb_scene_animate, for the stress test only; other scenes do not move.
 * Threads.     [one-writer]: nobody reads while somebody writes. In the engine the main thread writes in update_scene
 *              and any thread reads after it. Functions that create a scene or a mesh, and those that only read, are
 *              [any-thread].
 * Units.       Metres, seconds, radians; linear Rec.709; radiance in W sr^-1 m^-2, irradiance in W m^-2.
 * Errors.      A result and a message; *scene is NULL and a mesh is {0} after one.
 * Example.     The triangles of a file:
 *
 *   stilb_scene *scene;
 *   uint64_t triangles = 0;
 *   stilb_result result = stilb_scene_open("model.gltf", &scene);
 *   if (result != STILB_OK)
 *       return result;
 *   for (uint32_t part = 0; part < scene->part_count; part++)
 *       triangles += scene->meshes[scene->part_mesh[part]].index_count / 3;
 *   stilb_scene_destroy(scene);
 */
#ifndef STILB_SCENE_H
#define STILB_SCENE_H

#include "base/base.h"
#include "base/base_math.h"
#include "image/image.h"
#include "scene/scene_surface.h"

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/* Position and unit normal in model space; uv in units of the texture's width and height, (0, 0) at its top left. */
typedef struct stilb_scene_vertex {
	float position[3];
	float normal[3];
	float uv[2];
} stilb_scene_vertex;

/* What vertices have besides, where something needs it. */
typedef struct stilb_scene_vertex_extra {
	/* Unit, in the triangle's plane or near it, as MikkTSpace has it; the fourth is 1 or -1: the bitangent is that
	 * times cross(normal, tangent). Along it u of the map of normals grows, along the bitangent v decreases. All 0:
	 * there is none. */
	float tangent[4];
	float uv[2];    /* the second one */
	float color[4]; /* linear, 0..65504; multiplies the color and alpha of surfaces. 1, 1, 1, 1: it has none */
} stilb_scene_vertex_extra;

#define STILB_SCENE_MAX_LEVELS 32

/* A coarser version of a mesh: other triangles over the first of its vertices. */
typedef struct stilb_scene_level {
	uint32_t first_index, index_count; /* in stilb_scene_mesh.level_indices; fewer indices than the finer level has */
	uint32_t vertex_count; /* its triangles use vertices 0 .. vertex_count - 1 alone; at most as many as the finer level
	                          has */
	float error; /* metres in the mesh's space, >= 0, at least the finer level's: no point of this surface is farther
	                from the mesh's own, and none of that one is farther from this */
} stilb_scene_level;

/* A piece of a large mesh, of about a hundred triangles: of the mesh itself, or of a coarser version of some place. */
typedef struct stilb_scene_cluster {
	float center[3], radius; /* a sphere around its triangles, metres in the mesh's space */
	/* Of the mesh itself: in stilb_scene_mesh.indices, all of which are in such clusters, one after the other; else in
	 * cluster_indices, in the same way. */
	uint32_t first_index, index_count;
	/* The group that it is, with others, the coarser version of; STILB_SCENE_NONE: it is of the mesh itself. */
	uint32_t from;
} stilb_scene_cluster;

/* Clusters that are replaced together, by the clusters that are `from` this group, with which they share their outline
 * edge by edge. Groups that are drawn and the coarser versions of others then meet without cracks. */
typedef struct stilb_scene_cluster_group {
	float center[3], radius; /* a sphere around the triangles of its clusters, and around the spheres of all groups that
	                            these are from */
	/* Metres in the mesh's space, >= 0, at least those of all groups that its clusters are from: no point of its
	 * coarser version is farther from the mesh's own surface, and no point of the piece of that surface which it stands
	 * for is farther from it. INFINITY: nothing replaces it. */
	float error;
	uint32_t first_cluster, cluster_count; /* first_cluster: where those of the group before end */
} stilb_scene_cluster_group;

/* Triangles, counter-clockwise seen from the front, and coarser versions of them to draw where the difference is not
 * seen. Rays, bounds and all else that does not say so go by the mesh itself. */
typedef struct stilb_scene_mesh {
	stilb_scene_vertex *vertices;     /* [vertex_count] */
	stilb_scene_vertex_extra *extras; /* [vertex_count]; NULL: there are none */
	uint32_t *indices;                /* [index_count], three for each triangle, each < vertex_count */
	uint32_t vertex_count, index_count;
	uint32_t level_count, level_index_count; /* 0: there is no coarser version */
	stilb_scene_level *levels; /* [level_count] from finer to coarser; the mesh itself comes before them */
	uint32_t *level_indices;   /* [level_index_count] */
	/* [vertex_count] Where a vertex goes on the way to the first level that does not use it: with all of these vertices
	 * there, the finer triangles lie on the coarser ones and have their normals and uv. Normals are at most unit: the
	 * mean of two is shorter. Vertices that every level uses have entries that nobody reads. NULL: unknown. */
	stilb_scene_vertex *morph;
	/* Coarser versions of places of a mesh that is much larger than what is seen of it: some groups of clusters are
	 * drawn in place of others. Each cluster is in one group, and is from none or from one before that. 0: there are
	 * none. */
	uint32_t cluster_count, group_count, cluster_index_count;
	stilb_scene_cluster *clusters;     /* [cluster_count] in the order of the groups */
	stilb_scene_cluster_group *groups; /* [group_count] */
	uint32_t *cluster_indices; /* [cluster_index_count] of the clusters that are from groups; all vertices may be
	                                      used */
} stilb_scene_mesh;

/* The view selects the reflection model (stilb_render_shading); a model ignores the parameters that it does not use.
 * diffuse and specular are reflectances per channel in [0, 1]; a material of stilb_scene_material_make has
 * diffuse + specular <= 1 per channel. specular is the reflectance of the highlight, at normal incidence for a model
 * with a Fresnel term. */
typedef struct stilb_scene_material {
	float diffuse[3];
	float specular[3];
	float roughness;   /* [0, 1], 0: a mirror; its square is alpha, the width of a microfacet model's highlight */
	float anisotropy;  /* (-1, 1), 0: none; > 0 stretches the highlight along the tangent, < 0 across it */
	float wrap;        /* [0, 1]: how far diffuse light reaches past the border of light and shade; 0: Lambert */
	float emission[3]; /* radiance from the front in all directions; frames show it, but are not lit by it */
	uint32_t diffuse_texture; /* 1 + the index in textures of the one that multiplies diffuse; 0: none */
	uint32_t surface; /* 1 + an index in surfaces; 0: none. With a surface the constants above are its means, which
	                     stand for it in pictures of distant models, and diffuse_texture is 0 */
} stilb_scene_material;

/* ---- light: one list and one surroundings ---------------------------------------------------------------------------
 * Frames and traced pictures read the same list. Numbers are radiometric, W sr^-1 and W m^-2, or photometric, candela
 * and lux: stilb_scene_light.unit says which. No number is converted from one to the other, since every formula holds
 * for both alike; the numbers of a scene's lights, emission and surroundings are compared with each other, so all of
 * them are of one kind. A file's photometric numbers stay as they are, and such a picture needs an exposure.
 * shade_light.h has the formulas. */

typedef enum stilb_scene_light_kind {
	STILB_SCENE_LIGHT_POINT,
	STILB_SCENE_LIGHT_SPOT,
	STILB_SCENE_LIGHT_DIRECTIONAL, /* infinitely far away: a sun */
	STILB_SCENE_LIGHT_SPHERE,
	STILB_SCENE_LIGHT_DISK,
	STILB_SCENE_LIGHT_RECTANGLE,
	STILB_SCENE_LIGHT_KINDS,
} stilb_scene_light_kind;

typedef enum stilb_scene_light_unit {
	STILB_SCENE_LIGHT_RADIOMETRIC, /* W sr^-1; DIRECTIONAL: W m^-2 */
	STILB_SCENE_LIGHT_PHOTOMETRIC, /* candela; DIRECTIONAL: lux */
	STILB_SCENE_LIGHT_UNITS,
} stilb_scene_light_unit;

/* How light fades with the distance d from the light's centre, beyond what geometry does to it. DIRECTIONAL does not
 * fade. */
typedef enum stilb_scene_light_falloff {
	STILB_SCENE_LIGHT_PHYSICAL,   /* not at all: I / d^2 */
	STILB_SCENE_LIGHT_WINDOWED,   /* times (1 - d^2 / reach^2)^2: it ends softly at reach */
	STILB_SCENE_LIGHT_SUBTRACTED, /* times 1 - d^2 / reach^2, which keeps more light and ends with an edge */
	STILB_SCENE_LIGHT_RANGED,     /* times 1 - d^4 / reach^4, as glTF's range: more light still, and an edge */
	STILB_SCENE_LIGHT_FALLOFFS,
} stilb_scene_light_falloff;

/* Which pictures a light takes part in. Traced pictures show every light. */
typedef enum stilb_scene_light_use {
	STILB_SCENE_LIGHT_MIXED, /* its direct light in frames, its indirect light in baked data */
	STILB_SCENE_LIGHT_LIVE,  /* frames alone: it may change at any time */
	STILB_SCENE_LIGHT_BAKED, /* baked data alone: frames leave it out */
	STILB_SCENE_LIGHT_USES,
} stilb_scene_light_use;

typedef struct stilb_scene_light {
	stilb_scene_light_kind kind;
	float position[3];  /* of its centre; unused by DIRECTIONAL */
	float direction[3]; /* unit, from the light into the scene; unused by POINT and SPHERE. DISK and RECTANGLE are flat,
	                     perpendicular to it, and shine to that side alone */
	/* Colour and brightness, linear Rec.709: the intensity as seen from far away, of DISK and RECTANGLE along
	 * direction, so that it stays when the size changes. Radiance of the surface is intensity / (pi radius^2), of
	 * RECTANGLE intensity / area. DIRECTIONAL: irradiance on a surface perpendicular to direction. */
	float intensity[3];
	float cos_inner, cos_outer; /* SPOT: full intensity up to the inner angle from direction, 0 from the outer angle on;
	                             cos_inner >= cos_outer */
	float radius;               /* SPHERE, DISK: metres, > 0 */
	float half_x[3], half_y[3]; /* RECTANGLE: from its centre to the middles of two neighbouring sides, metres;
	                             perpendicular to each other and to direction */
	float reach;                /* of falloffs that are not PHYSICAL: metres, > 0 and > radius */
	stilb_scene_light_unit unit;
	stilb_scene_light_falloff falloff;
	stilb_scene_light_use use;
	/* 1 + the part that shows the light to who looks at it, 0: nothing is seen of it. The part has the light's shape,
	 * and its material emits the light's radiance. It is the same light and counts once: traced pictures sample the
	 * part in place of the light; frames are lit by the light and draw the part. PHYSICAL only. */
	uint32_t face;
} stilb_scene_light;

/* What lies behind everything: two hemispheres of constant radiance, or one if both are the same, or a panorama. */
typedef struct stilb_scene_surroundings {
	float sky[3];    /* radiance from above the horizon, y > 0 */
	float ground[3]; /* from below it */
	stilb_image
		panorama;   /* latitude-longitude map of radiance, 3 channels, F32_LINEAR, in place of sky and ground; {0}:
	                       none */
	float rotation; /* of the panorama about +Y, radians, finite; positive to the left, as a camera's yaw */
	char name[64];  /* what they are called, UTF-8: the panorama's file without its folder, "studio", or "" */
	/* Frames: highlights mirror sky and ground, too, by an approximation (shade_hemisphere_radiance). Without it frames
	 * reflect them evenly alone. Traced pictures always do both. */
	bool glossy;
} stilb_scene_surroundings;

/* What pictures show where no model is. Nothing is lit by it or mirrors it: that is the surroundings' part. */
typedef enum stilb_scene_backdrop_kind {
	STILB_SCENE_BACKDROP_SURROUNDINGS, /* the surroundings themselves */
	STILB_SCENE_BACKDROP_MAP,          /* map */
	STILB_SCENE_BACKDROP_COLOR,        /* color */
	STILB_SCENE_BACKDROP_NOTHING,      /* files with alpha are transparent there, all else is black */
	STILB_SCENE_BACKDROPS,
} stilb_scene_backdrop_kind;

#define STILB_SCENE_BACKDROP_WIDTH 64
#define STILB_SCENE_BACKDROP_HEIGHT 32
#define STILB_SCENE_FLOOR_SIDE 64
#define STILB_SCENE_FLOOR_REACH 2.0f /* half a side of the square that `covered` spans, in radii */

/* A level floor that shows the models' shadow and nothing else, and is no part of the scene: light, rays after the
 * first and baking do not meet it. */
typedef struct stilb_scene_floor {
	float center[3]; /* below the models' middle, metres; its y is the floor's height */
	float radius;    /* of the models' sphere, metres, > 0 */
	/* [z][x] The share of the hemisphere above the floor, weighted by the cosine, that models hide, [0, 1], over the
	 * square about the center: the shadow that frames show. Traced pictures trace it. */
	float covered[STILB_SCENE_FLOOR_SIDE][STILB_SCENE_FLOOR_SIDE];
} stilb_scene_floor;

typedef struct stilb_scene_backdrop {
	stilb_scene_backdrop_kind kind;
	float color[3];           /* radiance */
	float *map;               /* [HEIGHT][WIDTH][3] radiance, as a panorama in the world, interpolated; MAP */
	stilb_scene_floor *floor; /* COLOR: darkens it; NULL: none */
} stilb_scene_backdrop;

/* Yaw turns about +Y: 0 looks along -Z, positive to the left. Pitch then raises the view. Roll then turns the camera
 * about its view, positive lowers its right side: its right axis is cos(roll) * right - sin(roll) * up of the camera
 * without roll. */
typedef struct stilb_scene_camera {
	float position[3];
	float yaw, pitch, roll; /* radians, of any size */
	float fov_y;            /* angle of the picture's whole height, (0, pi) */
	float near_z, far_z;    /* distances of the clip planes, 0 < near_z < far_z */
	float exposure; /* stops, -100..100: pictures for display are brighter by 2^exposure; radiance stays as it is */
	uint32_t
		tone; /* SHADE_TONE_... of shading/shade_tonemap.h: how pictures for display show it; of the cameras of files
	                   SHADE_TONE_NEUTRAL */
} stilb_scene_camera;

#define STILB_SCENE_NAME 64 /* bytes of a name with its end */

/* A camera of a file or a build, under its name there, UTF-8, cut to fit; "": it has none. */
typedef struct stilb_scene_named_camera {
	char name[STILB_SCENE_NAME];
	stilb_scene_camera camera;
} stilb_scene_named_camera;

/* Names of a file's models (their nodes) and materials, UTF-8, cut to fit; "": it has none there. Of those that the
 * file had when it was opened; none at all if it has more than 65,536. */
typedef struct stilb_scene_names {
	uint32_t model_count, material_count;
	char (*models)[STILB_SCENE_NAME];    /* [model_count] */
	char (*materials)[STILB_SCENE_NAME]; /* [material_count] */
} stilb_scene_names;

/* A place in the space of a parent: scaled first, then turned, then moved. */
typedef struct stilb_scene_pose {
	float translation[3];
	float rotation[4]; /* a unit quaternion x, y, z, w */
	float scale[3];    /* along the axes before they are turned; of any sign */
} stilb_scene_pose;

/* A hierarchy of places, on which models, lights and cameras hang. scene_node.h changes it. Scenes of files have the
 * file's nodes, every parent before its children, and a node for each instance of an instanced one. */
typedef struct stilb_scene_nodes {
	uint32_t count;
	uint32_t *parent;       /* [count] STILB_SCENE_NONE: the world; of a removed node: itself */
	stilb_scene_pose *pose; /* [count] */
	stilb_mat4 *local;    /* [count] to the parent's space: pose as a matrix, unless the node was given a matrix, which
	                         pose then comes close to */
	stilb_mat4 *to_world; /* [count] as of the last frame or stilb_scene_update_nodes */
	char (*name)[64];     /* [count] UTF-8, cut to fit; "": it has none */
} stilb_scene_nodes;

/* How a light or a camera stands in the space of the node on which it hangs. What the list of lights or cameras says of
 * it is its place in the world (stilb_scene_attach_light). */
typedef struct stilb_scene_mount {
	uint32_t node;              /* 1 + the node; 0: it hangs on none, and the other members are unused */
	float position[3];          /* within 1e18 */
	float direction[3];         /* of a light, or along a camera's view */
	float half_x[3], half_y[3]; /* of a RECTANGLE */
	float radius;               /* of a SPHERE or DISK */
	float up[3];                /* of a camera: the direction that is up in its picture */
} stilb_scene_mount;

/* Bounding spheres, one array for each component (culling reads them sixteen at a time): 64-byte aligned. */
typedef struct stilb_scene_bounds {
	float *x, *y, *z, *radius; /* a NaN radius: the model is hidden or removed, and no view sees it */
} stilb_scene_bounds;

#define STILB_SCENE_NONE UINT32_MAX /* in place of an id: the part of a removed model */

/* How a model differs from most, in frames and traced pictures alike: bits of stilb_scene.model_flags. */
/* Nobody sees it: not the camera, nor rays that a surface mirrors or is lit by indirectly. It casts its shadow. */
#define STILB_SCENE_MODEL_UNSEEN 1u
/* Light goes through it on its way from a light, or from the surroundings, to a surface. */
#define STILB_SCENE_MODEL_CASTS_NO_SHADOW 2u
/* Lights and surroundings light it as if nothing were in between. */
#define STILB_SCENE_MODEL_RECEIVES_NO_SHADOW 4u
#define STILB_SCENE_MODEL_FLAGS 7u /* all of them */

/* How many changes there were of each kind, for readers that keep something made of the scene: a number that is still
 * the same means that nothing of its kind has changed (stilb_scene_revisions_read). One edit may count more than
 * once. */
typedef struct stilb_scene_revisions {
	uint64_t models;    /* added, removed; other meshes or materials of their parts */
	uint64_t places;    /* models moved, shown, hidden */
	uint64_t geometry;  /* meshes */
	uint64_t materials; /* with their textures */
	uint64_t textures;  /* their pixels alone */
	uint64_t lights, surroundings, camera;
	uint64_t poses; /* of geometry those that moved vertices of posed meshes alone: stilb_scene_mesh_pose */
} stilb_scene_revisions;

typedef struct stilb_scene {
	uint32_t model_count;
	stilb_scene_bounds bounds; /* [model_count] */
	uint32_t *first_part;      /* [model_count + 1]: model m owns parts first_part[m] .. first_part[m + 1] - 1 */

	uint32_t *model_node; /* [model_count] 1 + the node on which the model hangs, whose place its parts have; 0: none */
	uint8_t *model_flags; /* [model_count] STILB_SCENE_MODEL_...; 0: it is seen, casts shadows and receives them */
	uint32_t flags_used;  /* no model has other flags than these; 0: none has any */

	uint32_t part_count;
	uint32_t *part_mesh;        /* [part_count], or STILB_SCENE_NONE */
	uint32_t *part_material;    /* [part_count], or STILB_SCENE_NONE */
	stilb_mat4 *part_transform; /* [part_count] model to world, affine */

	uint32_t mesh_count;
	stilb_scene_mesh *meshes; /* [mesh_count]; {0}: a removed one */
	uint32_t material_count;
	stilb_scene_material *materials; /* [material_count] */
	uint32_t surface_count;
	stilb_scene_surface *surfaces; /* [surface_count] */
	uint32_t function_count;
	stilb_scene_function *functions; /* [function_count] of surfaces, the scene's own copies; {0}: a removed one */

	stilb_scene_nodes nodes;

	/* What models look like from afar: see scene_impostor.h, whose functions write these members. */
	uint32_t impostor_count, impostor_model_count;
	struct stilb_scene_impostor *impostors; /* [impostor_count] */
	uint32_t
		*model_impostor; /* [impostor_model_count] of the first models: 1 + the one that shows the model in the space
	                             of its first part, 0: none; models beyond have none */
	uint64_t impostors_geometry, impostors_materials; /* the revisions that they show (scene_impostor.h) */
	uint64_t impostors_removed;                       /* how often all of them were */

	/* Models whose bounds, transforms, meshes or materials have changed since the last frame; the engine sets the count
	 * back to 0. The functions of scene_edit.h and its like list them; frames show no other change of theirs. */
	uint32_t moved_count;
	uint32_t *moved; /* their ids, each once, in any order; room for model_count */

	uint32_t texture_count;
	stilb_image *textures; /* [texture_count]; 1 to 4 channels; row 0 is v = 0; repeated outside [0, 1] */
	uint32_t light_count;
	stilb_scene_light *lights;                   /* [light_count] */
	stilb_scene_mount *light_mounts;             /* [light_count]; NULL: no light hangs on a node */
	struct stilb_scene_lights_file *lights_file; /* of open/scene_lights.h; NULL: the scene is of no file */

	stilb_scene_surroundings surroundings;
	stilb_scene_backdrop backdrop; /* map and floor are the scene's own, as scene_look.h makes them */
	stilb_scene_names names;
	bool studio;                       /* the lights are those of stilb_scene_set_studio, not the file's */
	bool unlit;                        /* of a file without any light: see stilb_scene_open_options.dark */
	stilb_scene_camera camera;         /* the one to look with; of a file at first its first camera */
	uint32_t camera_count;             /* of the file's cameras */
	stilb_scene_named_camera *cameras; /* [camera_count] in the order of the file */
	stilb_scene_mount *camera_mounts;  /* [camera_count]; NULL: no camera hangs on a node */
	bool framed; /* the camera is stilb_scene_frame's for a square picture, because the file has none */
	/* Frames show triangles from behind, too, as rays do, with the normal on the viewer's side; they emit from the
	 * front alone. True of files, whose triangles do not all face outwards. It costs what is drawn of back sides. */
	bool both_sides;
	uint64_t seed;                           /* of the stress test, else 0 */
	uint32_t stress_lamps;                   /* of the stress test its lamps, lights 1 .. stress_lamps */
	bool stress_strings;                     /* these hang on strings */
	uint32_t stress_carried;                 /* and those that its figures carry, behind them */
	uint32_t stress_models;                  /* of the stress test its spheres over tiles, the first models; else 0 */
	struct stilb_scene_edits *edits;         /* of scene_edit.h; NULL: there was none */
	struct stilb_scene_animation *animation; /* of scene_animation.h; NULL: nothing of the file moves */
	struct stilb_scene_figures *figures;     /* of scene_play.h; NULL: nothing moves */
	struct stilb_scene_variants *variants;   /* of scene_variant.h; NULL: the file has none */
	stilb_scene_revisions revisions;         /* as of stilb_scene_revisions_read */
	uint64_t values[3];                      /* hashes of lights, surroundings and camera at that time */
} stilb_scene;

/* ---- opening ----------------------------------------------------------------------------------------------------- */

/* The scenes that are built in: X(name, description). Two have results that are known exactly, for tests. furnace takes
 * a number, RHO: the radiance in every direction is 1 / (1 - RHO). The middle of the picture of plane-wall shows the
 * point (1, 0, 0), where the visible fraction of the sky, weighted by the cosine, is (1 + cos 45 deg) / 2. */
#define STILB_SCENE_BUILTINS(X)                                                                                        \
	X("cornell", "the Cornell box: two blocks, a light in the ceiling")                                                \
	X("outdoor", "nine bumpy spheres on a field under a blue sky and a small bright sun")                              \
	X("furnace:RHO", "inside a ball that shines with radiance 1 and reflects RHO, 0 <= RHO < 1")                       \
	X("plane-wall", "a plane and a black wall 1 high along x = 0, under a sky of radiance 1")                          \
	X("stress", "10,000 spheres over tiles, as stilb demo shows them")                                                 \
	X("spheres", "seven spheres of different materials under a sky and an area light")

/* The names of the built-in scenes in one line: "cornell, outdoor, furnace:RHO, ...". Static. [any-thread] */
const char *stilb_scene_builtin_names(void);

/* Opens a scene by name: a built-in, or else a file (./cornell is one) of glTF 2.0 or any format that Assimp reads: its
 * triangles, materials, textures, lights and cameras, and looks with the first. A file without a camera gets one that
 * sees the whole scene (`framed`), and so does one whose cameras are those that the FBX format always has ("Producer
 * Perspective", ...); a file without any light gets a grey sky. Losses are logged with stilb_log, one line for each
 * kind: a texture that is missing (its material becomes magenta), maps on a third uv, animations, ...
 * (docs/import.md has the list).
 *
 * What FILE.lights.json beside the file says of the scene's lights counts (open/scene_lights.h); a line names it.
 *
 * Files are read by another process, stilb-scene-import: a crash or an endless loop there is an error here. It can read
 * the file, the files that it names below its folder and, by ../, below that folder's parent; no others, and none
 * through a symbolic link that leads out. It may use three quarters of the machine's memory, 8 GiB at most, and 120 s,
 * or the seconds that the environment variable STILB_IMPORT_SECONDS names.
 *
 * [any-thread] STILB_ERROR_ARGUMENT: the number of a built-in is out of its range, there is no such file.
 * STILB_ERROR_FILE: the format is unknown, the file is damaged or has no triangles. STILB_ERROR_MEMORY. *scene is NULL
 * then. */
stilb_result stilb_scene_open(const char *name, stilb_scene **scene);

/* Options of stilb_scene_open_with; {0} is the default. */
typedef struct stilb_scene_open_options {
	bool allow_outside; /* a scene may name any file that the user may read, not only those near it */
	/* Asked again and again while a file is read, on the same thread; true: the user gives it up, which is
	 * STILB_ERROR_FILE. NULL: never. */
	bool (*give_up)(void *user);
	/* Told of each file that the scene's file names and that is read, by its path from the root, and of
	 * FILE.lights.json beside it, which need not be there; on the same thread. NULL: nobody asks. */
	void (*opened)(void *user, const char *path);
	/* Told how much of a file is read, on the same thread: (0, 1], never less than before, 1 when the scene is there.
	 * It stands still while Assimp reads a file of its formats. NULL: nobody asks. */
	void (*progress)(void *user, float done);
	void *user;
	/* A file without any light (no light, no ambient light, and emission that gives its surfaces less than a hundredth
	 * of a studio's light) stays dark, and the scene's `unlit` is true: the caller lights it. Otherwise it gets a grey
	 * sky, and a line says so. */
	bool dark;
	bool quiet; /* log nothing of what the file has and is not shown */
	/* Out: the most memory that the import process has had at once, bytes; 0: it is unknown, or the scene is built in.
	 * NULL: nobody asks. */
	uint64_t *import_bytes;
} stilb_scene_open_options;

/* stilb_scene_open with options. [any-thread] */
stilb_result stilb_scene_open_with(const char *name, const stilb_scene_open_options *options, stilb_scene **scene);

/* Sets the panorama to the latitude-longitude map in a file, EXR or HDR (radiance), or codes of 8 or 16 bits (sRGB).
 * The top row is +Y, the middle column -Z, and +X lies a quarter of the width to the right of that. NaN, infinite and
 * negative values become 0. Sky and ground become its means above and below the horizon, which dumps keep. The import
 * process reads it, with the limits of stilb_scene_open. [one-writer] STILB_ERROR_FILE, STILB_ERROR_MEMORY; then the
 * scene is as before. */
stilb_result stilb_scene_set_environment(stilb_scene *scene, const char *path);

/* Replaces sky, ground and panorama by one radiance (finite, >= 0 per channel) from all directions. [one-writer] */
void stilb_scene_set_sky(stilb_scene *scene, const float radiance[3]);

/* The libraries of the import process, and the protections that this kernel offers against them (docs/import.md). */
typedef struct stilb_scene_import_info {
	char assimp[32], openimageio[32]; /* versions, "5.2.4"; "not found" if the process cannot be started */
	bool privileges;                  /* no_new_privs: it cannot gain rights */
	bool landlock;                    /* it can open no files but the system's libraries */
	bool seccomp;                     /* it can use only the system calls that decoding needs */
	bool limits;                      /* of memory, file size, descriptors and time */
} stilb_scene_import_info;

/* Starts the import process and asks it, for at most 10 s. Never fails. [any-thread] */
stilb_scene_import_info stilb_scene_import_query(void);

/* ---- the stress test --------------------------------------------------------------------------------------------- */

#define STILB_SCENE_MAX_MODELS 4000000u
#define STILB_SCENE_TILE 2.0f /* side of a ground tile, metres */

typedef enum stilb_scene_stress_view {
	STILB_SCENE_VIEW_ALL,  /* all models are in view */
	STILB_SCENE_VIEW_HALF, /* about half of them are */
	STILB_SCENE_VIEW_FEW,  /* about one in a hundred is */
} stilb_scene_stress_view;

/* model_count spheres over ground tiles on a square grid of side ceil(sqrt(model_count)), row by row; the last row may
 * be short. Corners of tiles have integer coordinates, exact in float, so that neighbours share the same floats.
 * Part 2m is the sphere of model m and part 2m + 1 its tile; each has its own material. Radii, heights and colours are
 * random, from seed. 1 <= model_count <= STILB_SCENE_MAX_MODELS. The camera is
 * stilb_scene_stress_camera(scene, STILB_SCENE_VIEW_ALL, 16/9). [any-thread] STILB_ERROR_MEMORY; then *scene is
 * NULL. */
stilb_result stilb_scene_create_stress(uint32_t model_count, uint64_t seed, stilb_scene **scene);

/* A camera for a scene of stilb_scene_create_stress; aspect = width / height > 0. VIEW_ALL keeps its promise for every
 * aspect. [any-thread] */
stilb_scene_camera stilb_scene_stress_camera(const stilb_scene *scene, stilb_scene_stress_view view, float aspect);

/* What lights the stress test: X(ENUM, identifier, words for users). */
#define STILB_SCENE_STRESS_LIGHTS(X)                                                                                   \
	X(SUN, sun, "a directional light")                                                                                 \
	X(HEMISPHERE, hemisphere, "the sky alone, which is mirrored, too")                                                 \
	X(SPHERE, sphere, "a sphere above the middle")                                                                     \
	X(DISK, disk, "a disk there, which faces down")                                                                    \
	X(WINDOWED, windowed, "the sphere, ending softly at the border")                                                   \
	X(SUBTRACTED, subtracted, "the sphere, ending with an edge")                                                       \
	X(NIGHT, night, "a moon and a dark sky")

#define STILB_SCENE_STRESS_LIGHT_ENUM(id, ...) STILB_SCENE_STRESS_LIGHT_##id,
typedef enum stilb_scene_stress_light {
	STILB_SCENE_STRESS_LIGHTS(STILB_SCENE_STRESS_LIGHT_ENUM) STILB_SCENE_STRESS_LIGHT_COUNT
} stilb_scene_stress_light;
#undef STILB_SCENE_STRESS_LIGHT_ENUM

/* Their identifiers, NULL-terminated; the index is the stilb_scene_stress_light. */
extern const char *const stilb_scene_stress_light_names[];

/* Puts a light into the list of a scene of stilb_scene_create_stress, in place of the one before; at first it is SUN.
 * [one-writer] */
void stilb_scene_stress_set_light(stilb_scene *scene, stilb_scene_stress_light light);

#define STILB_SCENE_MAX_LAMPS 1000000u

/* Adds count lamps, 1..STILB_SCENE_MAX_LAMPS, to the lights of a scene of stilb_scene_create_stress that has none, and
 * makes the other one NIGHT. They hang over the tiles, coloured and placed by the scene's seed, and end softly at a
 * reach by which some eight light a point: points, small spheres, and spots that face down. STILB_ERROR_MEMORY: nothing
 * has changed. [one-writer] */
stilb_result stilb_scene_stress_add_lamps(stilb_scene *scene, uint32_t count);

#define STILB_SCENE_STRING 50u /* bulbs of a string */

/* Hangs these lamps on strings in place of that: warm bulbs of the same small size, STILB_SCENE_STRING a string,
 * between posts that stand by the scene's seed. [one-writer] */
void stilb_scene_stress_hang_strings(stilb_scene *scene);

#define STILB_SCENE_CARRIED 3u /* lamps of a figure */

/* Gives each figure of stilb_scene_stress_add_figures STILB_SCENE_CARRIED small lamps that hang on its nodes, one on
 * the head and one in each hand. After any stilb_scene_stress_add_lamps. STILB_ERROR_MEMORY. [one-writer] */
stilb_result stilb_scene_stress_add_carried(stilb_scene *scene);

/* Moves the lamps over the tiles: a quarter goes in circles, and the spots swing; strings sway. seconds as of
 * stilb_scene_animate. [one-writer] */
void stilb_scene_stress_move_lamps(stilb_scene *scene, double seconds);

/* Moves the spheres of models 0, 10, 20, ... of a scene of stilb_scene_create_stress up and down, and lists these
 * models in moved. seconds, finite, is the time since the start, not the step: the same time gives the same bits.
 * [one-writer] */
void stilb_scene_animate(stilb_scene *scene, double seconds);

/* Adds count > 0 figures (scene_play.h) to a scene of stilb_scene_create_stress that was not edited yet: copies of one
 * of 11 joints and 550 vertices, 0.9 m high, each of which walks on the spot at its own time. STILB_ERROR_MEMORY,
 * STILB_ERROR_ARGUMENT: more than there can be; then the scene is to be destroyed. [one-writer] */
stilb_result stilb_scene_stress_add_figures(stilb_scene *scene, uint32_t count);

/* Frees the scene with its meshes, textures and panorama. Accepts NULL. [one-writer] */
void stilb_scene_destroy(stilb_scene *scene);

/* ---- pieces ------------------------------------------------------------------------------------------------------ */

/* A material that conserves energy: reflectances are clamped to >= 0 (NaN becomes 0), then scaled per channel so that
 * diffuse + specular <= 1 (shade_limit_to_one). roughness is clamped to [0, 1]. All other members are 0.
 * [any-thread] */
stilb_scene_material stilb_scene_material_make(const float diffuse[3], const float specular[3], float roughness);

/* What is wrong with a light, as words that go on after its name ("its radius is not above 0"); NULL: nothing. Numbers
 * must be finite, intensity >= 0, positions and sizes within 1e18 m, direction unit to 1 %; members that the kind and
 * the falloff do not use may have any value. Does not check that there is a part `face`. [any-thread] */
const char *stilb_scene_light_mistake(const stilb_scene_light *light);

/* The unit sphere as an icosahedron split `splits` times (0..6): 20 * 4^splits triangles with vertices on the sphere. u
 * is the longitude, 0 at -Z, growing eastward (towards -X) to 1 at -Z again; v is the polar angle / pi, 0 at +Y, 1 at
 * -Y. Triangles share their vertices, so a texture is squeezed in those across u = 0 and at the poles. Its levels are
 * the spheres of fewer splits, and the vertices that a split adds morph to the middles of the edges that it halves; the
 * last one is an octahedron of six of the icosahedron's vertices, onto which the other six morph. A sphere that is not
 * split has no levels. [any-thread] STILB_ERROR_MEMORY; then mesh is {0}. */
stilb_result stilb_scene_mesh_sphere(uint32_t splits, stilb_scene_mesh *mesh);

/* The square x, z in [-1, 1] at y = 0, facing +Y, two triangles. u grows with x, v with z, each from 0 to 1.
 * [any-thread] STILB_ERROR_MEMORY; then mesh is {0}. */
stilb_result stilb_scene_mesh_plane(stilb_scene_mesh *mesh);

/* The pose that changes nothing. [any-thread] */
stilb_scene_pose stilb_scene_pose_identity(void);

/* As a matrix: translation * rotation * scale. [any-thread] */
stilb_mat4 stilb_scene_pose_matrix(const stilb_scene_pose *pose);

/* The pose of an affine matrix. What shears is lost; of a mirrored space one scale is negative. [any-thread] */
stilb_scene_pose stilb_scene_pose_of(const stilb_mat4 *matrix);

/* Frees the arrays and leaves {0}. Accepts {0}. [one-writer] */
void stilb_scene_mesh_finish(stilb_scene_mesh *mesh);

/* Frees levels, clusters and morph, if there are any: the mesh itself is left. [any-thread] */
void stilb_scene_mesh_drop_levels(stilb_scene_mesh *mesh);

/* A camera that looks in this direction, radians, and sees all vertices that triangles of visible models use, where
 * they are and where a clip takes them, if one was swept (stilb_scene_sweep). They fill nine tenths of the width or the
 * height of a picture of aspect = width / height > 0, and the same space is left over on both sides. What has no size
 * is 1 m away. Its angle is 0.7 radians, its exposure and its tone are those of scene->camera. The direction of
 * STILB_SCENE_FRAME_YAW and _PITCH is from the front, a little from the right and above. Takes time proportional to the
 * number of triangles. [any-thread] */
#define STILB_SCENE_FRAME_YAW 0.42f
#define STILB_SCENE_FRAME_PITCH (-0.31f)
stilb_scene_camera stilb_scene_frame(const stilb_scene *scene, float yaw, float pitch, float aspect);

/* Leaves out of ids[0 .. count - 1] the models that have any of these flags, STILB_SCENE_MODEL_...; the others move up
 * in their order. Returns how many are left. Costs nothing where no model of the scene has such a flag. [any-thread] */
uint32_t stilb_scene_leave_out(const stilb_scene *scene, uint32_t flags, uint32_t *ids, uint32_t count);

/* What has changed, counted since the scene was made. Any number of readers may compare it with what they read before.
 * Lights, surroundings and camera, which programs assign, are compared by a hash of their values at this call with
 * that at the last one; values that were changed and changed back in between are not noticed, nor is a panorama whose
 * pixels were written in place. Reads the whole list of lights, and gives moved nodes their places
 * (stilb_scene_update_nodes). [one-writer] */
stilb_scene_revisions stilb_scene_revisions_read(stilb_scene *scene);

/* A sphere around all visible models, about the centre of their box; radius 0 if there are none. [any-thread] */
stilb_sphere stilb_scene_sphere(const stilb_scene *scene);

/* How far ahead of the camera the middle of the scene is, metres, > 0: what it turns about. If the scene is not ahead,
 * its radius. [any-thread] */
float stilb_scene_camera_distance(const stilb_scene *scene, const stilb_scene_camera *camera);

/* World to clip (stilb_mat4_perspective) for a picture of aspect = width / height > 0. [any-thread] */
stilb_mat4 stilb_scene_camera_matrix(const stilb_scene_camera *camera, float aspect);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#endif
