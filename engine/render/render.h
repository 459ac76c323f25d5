/*
 * render: many threads record draws as plain commands; one thread replays them on a device, in an order that does not
 * depend on the threads.
 *
 * How it works.  Every worker owns a render context. Recording appends 32-byte commands to blocks of memory that belong
 *                to the context for this frame. The transforms of a scene's parts are rows that stay from frame to
 *                frame, which commands name; only what moves, and what is drawn by hand, writes rows of 64 bytes for
 *                a frame. With indirect replay all of it is memory that the GPU reads, never copied. A pass is cut
 *                into segments, numbered by the scene; any worker may record any segment, and replay takes the segments
 *                in number order. So the command stream, and the picture, are the same for any number of workers.
 * Life cycle.    stilb_render_create -> stilb_render_set_scene, stilb_render_mesh_create, ... -> frames ->
 *                stilb_render_destroy.
 * Per frame.     stilb_render_frame_begin, stilb_render_record for each pass, stilb_render_replay,
 *                stilb_render_present. A frame that fails between begin and replay is dropped: begin the next one, or
 *                destroy the renderer.
 * Threads.       [main-thread] is the thread that called stilb_render_create. [one-writer]: any thread, but one at a
 *                time for each context. [any-thread]: any thread, at any time. Every function says which. Functions
 *                that take a pool spread their work over it and return when all of it is done; `worker` is the caller's
 *                index in it.
 * Devices.       `null` counts and writes what a GPU would be given, and draws nothing: it needs no driver. `vulkan`
 *                draws, and shows GPU times in the profiler's lane "GPU": a zone for each frame, in it one for each
 *                pass.
 * Limits.        33,554,432 parts of a scene, and as many draws by hand a frame; lists and buffers grow, and running
 *                out of either is an error of the frame. Nothing is ever dropped.
 * Example.       A scene in a picture of 1280 x 720; `visible` comes from stilb_cull_run:
 *
 *   stilb_render_desc desc = {.width = 1280, .height = 720, .context_count = stilb_job_pool_worker_count(pool) + 1};
 *   stilb_render_pass pass = {.name = "scene"};
 *   stilb_render_view view = {.view_projection = ..., .shading = stilb_render_shading_default()};
 *   view.lights = scene->lights;
 *   view.light_count = scene->light_count;
 *   stilb_render *render;
 *   stilb_result result = stilb_render_create(&desc, &render);
 *   if (result == STILB_OK)
 *       result = stilb_render_set_scene(render, scene);
 *   while (result == STILB_OK && running()) {
 *       result = stilb_render_frame_begin(render);
 *       if (result == STILB_OK)
 *           result = stilb_render_record(render, 0, scene, visible.ids, visible.count, pool, 0);
 *       if (result == STILB_OK)
 *           result = stilb_render_replay(render, &pass, 1, &view, 1, pool, 0);
 *       if (result == STILB_OK)
 *           result = stilb_render_present(render);
 *   }
 */
#ifndef STILB_RENDER_H
#define STILB_RENDER_H

#include "base/base.h"
#include "base/base_math.h"
#include "gpu/gpu.h"
#include "image/image.h"
#include "jobs/job.h"
#include "scene/edit/scene_edit.h"
#include "scene/scene.h"
#include "scene/scene_channel.h"
#include "scene/scene_impostor.h"

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

typedef struct stilb_render stilb_render;
typedef struct stilb_render_context stilb_render_context;

/* ---- creation ---------------------------------------------------------------------------------------------------- */

typedef enum stilb_render_device_kind {
	STILB_RENDER_DEVICE_VULKAN,
	STILB_RENDER_DEVICE_NULL,
} stilb_render_device_kind;

/* How a command list becomes device commands. All modes give the same pixels. */
typedef enum stilb_render_replay_mode {
	STILB_RENDER_REPLAY_INDIRECT,  /* multi-draw-indirect: the GPU reads the workers' commands where they lie */
	STILB_RENDER_REPLAY_DIRECT,    /* one device command a draw, in one primary command buffer */
	STILB_RENDER_REPLAY_SECONDARY, /* as direct, but in a secondary command buffer per worker, in parallel */
} stilb_render_replay_mode;

/* How a draw gets its material. All ways give the same pixels; the last two exist to measure what they cost. */
typedef enum stilb_render_materials {
	STILB_RENDER_MATERIALS_INDEX,    /* an index in the draw's row: no device command */
	STILB_RENDER_MATERIALS_BIND,     /* its address as constants, for each change of material */
	STILB_RENDER_MATERIALS_PIPELINE, /* two pipelines, for materials with even and with odd ids: the worst case */
} stilb_render_materials;

/* Errors that a device makes on purpose, for tests. Counted from 1; 0: none. */
typedef struct stilb_render_faults {
	uint32_t allocation;   /* the device's n-th allocation of memory fails */
	uint32_t lost_frame;   /* the device is lost when its n-th frame is submitted */
	uint32_t texture_side; /* it has no larger textures; 0: its own limit */
	uint32_t textures;     /* it has no more of them at once; 0: STILB_RENDER_MAX_TEXTURES - 1 */
	uint32_t surface_lost; /* the window's surface is lost when the n-th frame is shown */
} stilb_render_faults;

/* The format of the picture. */
typedef enum stilb_render_output {
	STILB_RENDER_OUTPUT_DISPLAY, /* tone mapped, 8-bit sRGB */
	STILB_RENDER_OUTPUT_LINEAR,  /* linear radiance in W sr^-1 m^-2, 16-bit float */
} stilb_render_output;

/* What a highlight has of normals that a pixel is too large to show: mips of maps of normals hold how far the normals
 * below a texel spread, and the roughness is widened by it (shade_gltf_widened). */
typedef enum stilb_render_specular_aa {
	STILB_RENDER_SPECULAR_AA_VMF,     /* as a von Mises-Fisher lobe: shade_filter_convolution */
	STILB_RENDER_SPECULAR_AA_TOKSVIG, /* shade_filter_variance */
	STILB_RENDER_SPECULAR_AA_OFF,     /* nothing: highlights far away are too sharp, and sparkle */
} stilb_render_specular_aa;

/* Zero-initialised it means: Vulkan, indirect replay, indexed materials, display output, best GPU, no window, samples
 * chosen by the GPU. Sizes and context_count must be set. */
typedef struct stilb_render_desc {
	stilb_render_device_kind device;
	stilb_render_replay_mode replay;
	stilb_render_materials materials;
	stilb_render_output output;
	const char *gpu;                  /* a number or a part of a name as `stilb info` prints them; NULL: the best */
	const stilb_gpu_surface *surface; /* NULL: no window; stilb_render_read_image gets the picture */
	stilb_gpu_presentation presentation;
	uint32_t width, height; /* pixels, 1..16384 */
	uint32_t samples;       /* 1 or 4 per pixel; 0: 4 on a GPU, 1 on a software device */
	/* Of textures of surfaces that are filtered linearly: how many times longer than wide a pixel's footprint may be
	 * before it blurs, 1..16, at most the GPU's; 1: mips alone. 0: 8 on a GPU, 1 on a software device, where 8 costs a
	 * read five times as much. */
	uint32_t max_anisotropy;
	stilb_render_specular_aa specular_aa;
	uint32_t context_count; /* threads that may record: the pool's workers + 1 for its caller; >= 1 */
	bool validate;          /* use the Vulkan validation layer, with synchronization checks */
	bool keep_textures;     /* keep a copy of all pixels: stilb_render_dump_save needs it */
	bool float_vertices;    /* the device has vertices as scenes have them, 32 bytes each; else packed ones of 24 bytes,
	                           whose normals are off by up to 6.6e-5 */
	bool morph;             /* keep where vertices morph to, for STILB_RENDER_DETAIL_MORPH: twice the memory of meshes
	                           that say it */
	stilb_render_faults faults;
} stilb_render_desc;

/* Opens the device and takes the calling thread as the main thread. On failure *render is NULL. STILB_ERROR_ARGUMENT:
 * no GPU has the name or number desc->gpu. STILB_ERROR_DEVICE: there is no driver, or the GPU lacks a feature that the
 * message names, with the way to get it. STILB_ERROR_WINDOW: this GPU cannot present to this window; without a surface
 * it may work. STILB_ERROR_MEMORY. */
stilb_result stilb_render_create(const stilb_render_desc *desc, stilb_render **render);

/* From now on the calling thread is the main thread of every [main-thread] function of this render: for a program that
 * records and replays on a thread of its own. The former main thread must not be inside a call. [any-thread] */
void stilb_render_own(stilb_render *render);

/* Waits for the device, then frees everything: every mesh, texture and material too. Accepts NULL. [main-thread] */
void stilb_render_destroy(stilb_render *render);

/* The GPU's name, or "null". Valid as long as render. [any-thread] */
const char *stilb_render_device_name(const stilb_render *render);

/* True if the device runs on the CPU, as lavapipe does. False for the null device. [any-thread] */
bool stilb_render_device_is_software(const stilb_render *render);

/* Samples per pixel that are in use: 1 or 4. [any-thread] */
uint32_t stilb_render_samples(const stilb_render *render);

/* How pictures get to the window's screen; FIFO without one. [main-thread] */
stilb_gpu_presentation stilb_render_presentation_used(const stilb_render *render);

/* How many warnings and errors the validation layer has given so far; 0 without desc.validate. [main-thread] */
uint32_t stilb_render_validation_messages(const stilb_render *render);

/* ---- meshes, textures, materials ---------------------------------------------------------------------------------
 * Any thread may create and destroy them at any time, also while frames are recorded; creation and destruction share
 * one lock, draws take none. id 0 is no handle, and destroying it does nothing.
 * Life time. A handle may be used in draws that are recorded after its creation has returned. Destroying it is safe
 * while frames that use it are in flight: its memory is reused only after they are drawn. No thread may draw with a
 * handle while or after another thread destroys it.
 * Errors of creation: STILB_ERROR_ARGUMENT for data that cannot be drawn, STILB_ERROR_MEMORY for no memory or no free
 * id of a mesh or material. *out is then {0}.
 *
 *   stilb_render_texture texture;
 *   stilb_render_material material;
 *   stilb_result result = stilb_render_texture_create(render, &image, &texture);
 *   if (result == STILB_OK)
 *       result = stilb_render_material_create(render, &(stilb_scene_material){.roughness = 0.5f}, texture, &material);
 *   ...
 *   stilb_render_material_destroy(render, material);
 *   stilb_render_texture_destroy(render, texture);
 */

typedef struct stilb_render_mesh {
	uint32_t id;
} stilb_render_mesh;

typedef struct stilb_render_texture {
	uint32_t id;
} stilb_render_texture;

typedef struct stilb_render_material {
	uint32_t id;
} stilb_render_material;

/* How many of each can exist at once. All meshes share one array of vertices and one of indices; where destroyed meshes
 * have left n holes in them, creating a mesh takes time in proportion to n: 0.2 us for 1,000, 5 us for 100,000. */
#define STILB_RENDER_MAX_MESHES (1u << 20)
#define STILB_RENDER_MAX_MATERIALS (1u << 24)
#define STILB_RENDER_MAX_TEXTURES (1u << 20) /* one less in fact: index 0 stands for no texture */

/* Copies vertices (metres, unit normals), indices (three a triangle), levels and clusters; a mesh with clusters does
 * not morph. STILB_ERROR_ARGUMENT: no vertex, no index, an index that is not below vertex_count, or levels or clusters
 * that are not as stilb_scene_level and stilb_scene_cluster say. [any-thread] */
stilb_result stilb_render_mesh_create(stilb_render *render, const stilb_scene_mesh *mesh, stilb_render_mesh *out);

/* [any-thread] */
void stilb_render_mesh_destroy(stilb_render *render, stilb_render_mesh mesh);

/* Copies the pixels: 1..16384 a side, 1..4 channels (grey, grey and alpha, RGB, RGBA), any stilb_image_format;
 * U16_SRGB becomes halves of light, and blocks are decoded. Sampled with linear filtering, repeated in both directions,
 * without mip levels. STILB_ERROR_ARGUMENT: out of these ranges, larger than this GPU's textures, a format that it
 * cannot filter, or there are as many as can exist. [any-thread] */
stilb_result stilb_render_texture_create(stilb_render *render, const stilb_image *image, stilb_render_texture *out);

/* Destroy the materials that use it first. [any-thread] */
void stilb_render_texture_destroy(stilb_render *render, stilb_render_texture texture);

/* Copies the material. texture multiplies its diffuse reflectance; {0}: none. [any-thread] */
stilb_result stilb_render_material_create(stilb_render *render, const stilb_scene_material *material,
                                          stilb_render_texture texture, stilb_render_material *out);

/* [any-thread] */
void stilb_render_material_destroy(stilb_render *render, stilb_render_material material);

/* What draws an impostor in place of a model: draws of this mesh with this material show the model that it was baked
 * of, under the same transform. It faces the camera of the view by itself, is lit like meshes, and has their depth.
 * Each counts as a mesh, a material and a texture. With one sample a pixel it covers the pixels that the model covers
 * by at least half, with four as many samples as it covers. */
typedef struct stilb_render_impostor {
	stilb_render_mesh mesh;
	stilb_render_material material;
	stilb_render_texture texture;
} stilb_render_impostor;

/* Copies the impostor. STILB_ERROR_ARGUMENT: stilb_scene_impostor_mistake finds one; and as
 * stilb_render_texture_create. [any-thread] */
stilb_result stilb_render_impostor_create(stilb_render *render, const stilb_scene_impostor *impostor,
                                          stilb_render_impostor *out);

/* [any-thread] */
void stilb_render_impostor_destroy(stilb_render *render, stilb_render_impostor impostor);

/* Copies all meshes, materials and textures of a scene, and where its parts stand, to the device, for
 * stilb_render_record, and destroys those of the scene that was set before; between frames. NULL: only destroys. On
 * failure the scene before stays. STILB_ERROR_ARGUMENT, STILB_ERROR_DEVICE: see stilb_render_mesh_create and
 * stilb_render_texture_create; more than 33,554,432 parts. STILB_ERROR_MEMORY; STILB_ERROR_DEVICE_LOST: textures are
 * sent while the scene is set. [main-thread] */
stilb_result stilb_render_set_scene(stilb_render *render, const stilb_scene *scene);

/* When the textures of a scene are made: with it, or while frames are drawn, which show a texture's mean color until it
 * is there. Then each stilb_render_update_scene, of which there is one a frame, makes a part of what is left,
 * and each frame copies some 16 MiB. */
typedef enum stilb_render_textures {
	STILB_RENDER_TEXTURES_AT_ONCE,
	STILB_RENDER_TEXTURES_EVEN,  /* as many texels a frame as always: what a frame shows depends on its number alone */
	STILB_RENDER_TEXTURES_SPARE, /* as many as go into 4 ms */
} stilb_render_textures;

/* For scenes that are set or made ready from now on; AT_ONCE at first. While it is not AT_ONCE the pictures of textures
 * must live as long as the scene is shown, unless edits tell that they have gone. A texture that is edited on its way
 * begins anew, one that is removed is given up; edits of others are made at once. With AT_ONCE the next update makes
 * all that is left. [main-thread] */
void stilb_render_set_textures(stilb_render *render, stilb_render_textures textures);
/* How many textures of the scene are on their way. [main-thread] */
uint32_t stilb_render_textures_left(const stilb_render *render);

/* Makes a scene ready beside the frames, for stilb_render_show_scene: creates what it needs, while each frame copies
 * some 16 MiB of it to the device, until all is there. Meanwhile frames go on, and the scene must not change. `pace` is
 * called every millisecond or so with the share that is on the device, 0..1, and says how fast to go; who is in a hurry
 * gets all that is left with the next frame, and this then needs no frames. On failure *prepared is NULL. Errors as
 * stilb_render_set_scene; STILB_ERROR_GIVEN_UP. [any-thread], one call at a time */
typedef struct stilb_render_prepared stilb_render_prepared;
typedef enum stilb_render_speed {
	STILB_RENDER_PACED,
	STILB_RENDER_HURRY,
	STILB_RENDER_GIVE_UP,
} stilb_render_speed;
typedef stilb_render_speed stilb_render_pace(void *user, float done);
stilb_result stilb_render_prepare_scene(stilb_render *render, const stilb_scene *scene, stilb_render_pace *pace,
                                        void *user, stilb_render_prepared **prepared);

/* As stilb_render_set_scene of the scene that was made ready, and frees `prepared`; takes no time. [main-thread] */
void stilb_render_show_scene(stilb_render *render, stilb_render_prepared *prepared);

/* Destroys what was made ready, if it is not shown after all. Accepts NULL. [any-thread] */
void stilb_render_drop_scene(stilb_render *render, stilb_render_prepared *prepared);

/* Brings these up to date with what has changed in the scene that was set (stilb_scene_changes_read): copies what is
 * new, changed vertices as ranges, and destroys what was removed; notes the models in scene->moved, which therefore is
 * cleared after it, not before; in a frame before stilb_render_record, or between frames. The device does not wait:
 * frames that it still draws show what they were recorded with. Errors as stilb_render_set_scene: then part of the
 * changes may have been made, and the same call may be made again.
 * STILB_ERROR_ARGUMENT: the device does not take a texture, which the line names; what was drawn in its place before
 * stays, all other changes were made, and the same call made again leaves this image out and is done. [main-thread] */
stilb_result stilb_render_update_scene(stilb_render *render, const stilb_scene *scene,
                                       const stilb_scene_changes *changes);

/* Handles of that scene's mesh and material `id`, an index into scene->meshes or scene->materials. [any-thread] */
stilb_render_mesh stilb_render_scene_mesh(const stilb_render *render, uint32_t id);
stilb_render_material stilb_render_scene_material(const stilb_render *render, uint32_t id);

/* ---- views and passes: the frame as data ------------------------------------------------------------------------- */

/* How surfaces are shaded. The first four members choose formulas by the constants of the shading headers. The others
 * are added to the parameters of every material, to try out values; each sum is clamped to the parameter's range. */
typedef struct stilb_render_shading {
	uint32_t brdf;      /* SHADE_BRDF_... of shading/shade_brdf.h */
	uint32_t ndf, g, f; /* its D, G and F: SHADE_NDF_..., SHADE_G_..., SHADE_F_...; for SHADE_BRDF_MICROFACET alone */
	float roughness;    /* added, [-1, 1] */
	float anisotropy;   /* added, [-1, 1] */
	float wrap;         /* added, [-1, 1] */
	float specular;     /* added to all channels, [-1, 1]; then diffuse + specular is limited to one again */
} stilb_render_shading;

/* Modified Blinn-Phong, nothing added. Who sets brdf to SHADE_BRDF_MICROFACET gets, unless ndf, g or f
 * is set too, GGX's distribution of facets, Smith's shadowing term for it and Schlick's Fresnel term. [any-thread] */
stilb_render_shading stilb_render_shading_default(void);

/* How levels of meshes (stilb_scene_level) give way to one another. */
typedef enum stilb_render_detail_mode {
	STILB_RENDER_DETAIL_OFF,  /* there are none: every mesh is drawn in full */
	STILB_RENDER_DETAIL_POP,  /* from one frame to the next */
	STILB_RENDER_DETAIL_FADE, /* over 16 frames, in which both are drawn, the new one in ever more of the pixels */
	/* Vertices move to their places in the coarser level while the distance grows by half; the frame in which it takes
	 * over shows no difference. Meshes that do not say where their vertices go fade. Needs stilb_render_desc.morph. */
	STILB_RENDER_DETAIL_MORPH,
} stilb_render_detail_mode;

#define STILB_RENDER_FADE_FRAMES 16u

/* Which level is drawn: the coarsest one whose error is at most `error` pixels as seen from the nearest point of the
 * model's bounding sphere, straight ahead; towards the picture's corners perspective makes things larger. POP and FADE
 * go back to a coarser level only at nine tenths of it, so that a camera that trembles does not switch back and
 * forth.
 *
 * Unless mode is OFF, a model that has an impostor (stilb_scene_set_impostor) is drawn as that, from where four texels
 * of the impostor's pictures are a pixel wide or less; in the modes FADE and MORPH it fades. */
typedef struct stilb_render_detail {
	stilb_render_detail_mode mode;
	float error; /* pixels, > 0; not read if mode is OFF */
} stilb_render_detail;

/* What pictures show, a row for each module that has something to show: X(ENUM, identifier, words for users, ...).
 *   LEVELS  each level of detail in a colour of its own, lit from the viewer: white the mesh in full, then red, orange,
 *           yellow, green, blue, violet and red again; grey what has no levels. Clusters have the colour of how often
 *           their place has been made coarser. There are no transitions.
 *   LIGHTS  how many lights a pixel has asked, by the view's way of lighting and as often as it was shaded: what is
 *           hidden later counts, too. Black none, then a colour for 1, 2, 4, ... 64, white 128 or more. The image
 *           "color" has the number in its first channel, in the second how often the pixel was lit, both exact up to
 *           2,048 and at most 65,504 (stilb_render_count_lights). No backdrop, and exposure, tone and dither are not
 *           read.
 *   ERROR   how far light is from that of the target STILB_RENDER_IMAGE_REFERENCE, which another view of the frame
 *           draws in the same size: of the three channels the one that is off most, exposed, in linear light. Black
 *           none, then a colour for 1/16, 1/8, ... 4 times 1/255 of display white, white 8 or more. Tone and dither are
 *           not read. For the view of the main images alone. The image "error" has the difference of radiance by
 *           channel (stilb_render_measure_error).
 *   CASCADES
 *           light of suns in the colour of the cascade that keeps it from the surface (red, green, blue, yellow,
 *           violet, cyan, orange, grey), mixed where they blend; shadows are a quarter as bright. Lamps' light and what
 *           lies beyond the cascades is grey.
 *   ATLAS   all layers of the image STILB_RENDER_IMAGE_SHADOW, side by side: the fourth root of depth, so that lamps'
 *           maps are not all black.
 *   ACNE    light of shadowed lights in grey, and over it two colours by the shares of the filter's texels. Red: what
 *           keeps the light away is nearer to the surface, along the way to the light, than twice as far as the bias
 *           moves the point on it (stilb_render_shadows): most likely the surface itself. Blue: it is as near as that
 *           and would keep it away if the point were not moved: what the bias rescues, or detaches.
 *           These three are drawn from maps, also where there is a buffer, and ATLAS of the frame's last maps.
 *   BASE, ... OVERDRAW
 *           the channels of scene_channel.h: no light, no backdrop, and exposure, tone and dither are not read. Levels
 *           and impostors are drawn as usual; an impostor has base colour, normal and roughness alone. WIREFRAME: lines
 *           of one pixel, also those behind others; the GPU must have fillModeNonSolid. OVERDRAW counts what passes the
 *           test of depth, in the order of the draws. Views with the same target show the same. */
#define STILB_RENDER_SHOWN(X)                                                                                          \
	X(SHADED, shaded, "surfaces in their light")                                                                       \
	X(LEVELS, lod, "levels of detail, each in a colour")                                                               \
	X(LIGHTS, lights, "how many lights each pixel asked, as a colour")                                                 \
	X(ERROR, error, "how far light is from that of forward lighting, as a colour")                                     \
	X(CASCADES, cascades, "the shadow maps of suns that each pixel asks, each in a colour")                            \
	X(ATLAS, atlas, "the shadow maps themselves: depth as lights see it, nearer is brighter")                          \
	X(ACNE, acne, "red what its own surface seems to shade, blue what the way to the light alone keeps lit")           \
	STILB_SCENE_CHANNELS_OF_SURFACES(X)

#define STILB_RENDER_SHOW_ENUM(id, ...) STILB_RENDER_SHOW_##id,
typedef enum stilb_render_show { STILB_RENDER_SHOWN(STILB_RENDER_SHOW_ENUM) STILB_RENDER_SHOWS } stilb_render_show;
#undef STILB_RENDER_SHOW_ENUM

/* True if it is a channel, which *channel is then. [any-thread] */
static inline bool stilb_render_show_channel(stilb_render_show show, stilb_scene_surface_channel *channel)
{
	*channel = (stilb_scene_surface_channel)((int)show - STILB_RENDER_SHOW_BASE);
	return (int)show >= STILB_RENDER_SHOW_BASE;
}

/* What a frame that shows LIGHTS has counted, over all pixels of its image. */
typedef struct stilb_render_light_counts {
	uint64_t pixels, shown; /* of the image; those of them that were lit at least once */
	uint64_t cut;           /* those that asked more lights than half floats hold, which count as 65,504 */
	double lights;          /* that were asked */
	double shadings;        /* how often pixels were lit; divided by `shown` it is the overdraw */
} stilb_render_light_counts;

/* texels: of that frame's image "color", [count][4] half floats. [any-thread] */
stilb_render_light_counts stilb_render_count_lights(const uint16_t (*texels)[4], uint64_t count);

/* How far a frame that shows ERROR is from its reference, exposed: 1 is display white. */
typedef struct stilb_render_error {
	uint64_t pixels;  /* of the image; 0: not known */
	double rms, most; /* of all channels of all pixels; of the channel that is off most */
	double share;     /* of the pixels that are off by more than 1/255 */
} stilb_render_error;

/* texels: of that frame's image "error", [count][4] half floats; exposure: of its view. [any-thread] */
stilb_render_error stilb_render_measure_error(const uint16_t (*texels)[4], uint64_t count, float exposure);

/* Their identifiers, NULL-terminated; the index is the stilb_render_show. */
extern const char *const stilb_render_show_names[];
/* And their words for users. */
extern const char *const stilb_render_show_words[];

/* The identifiers of stilb_render_detail_mode, NULL-terminated. */
extern const char *const stilb_render_detail_names[];

/* How a pixel finds the lights that reach it; all ways but PREPASS, PRELIGHT and COMBINED show the same picture.
 * Lights that end somewhere are those whose falloff is not PHYSICAL, but for DIRECTIONAL ones.
 *   MULTIPASS surfaces that blend, those with layers, and those with a function of the program's are drawn once, as
 *             FORWARD draws them. Where two surfaces lie in the very same place, both get the further lights. Source:
 *             Schueler, "Minimalist Cook-Torrance" (2011): up to eight lights a pass.
 *   COMBINED  does not show the same where more than four lights reach a model: the four that send the most to its
 *             centre stay as they are, the others light its diffuse reflectance by the normal alone, as nine
 *             coefficients of spherical harmonics. A light moves between the two within sixteen frames. Passes must be
 *             recorded with the view (stilb_render_record_views); what is drawn by hand, and dumps, ask every light.
 *             Source: Karis, "Deferred rendering 2" (2009).
 * The other ways are for pictures of one sample a pixel, and the first pass into a target; else
 * they are as AUTO. What they cannot hold is drawn after the rest, with lists of cells: surfaces that blend, those with
 * layers, and those with a function of the program's.
 *   TILED_... the lists of tiles, of 16 x 16 pixels, hold lights that may reach what the tile shows: between its
 *             nearest and farthest depth, in the box of its points, deferred also before the cone of its normals.
 *   INDEXED   a pixel has places of up to eight lights; where more reach it, it asks its cell's list.
 *   PREPASS   highlights have no colour, no Fresnel's term, and the roughness STILB_RENDER_PREPASS_ROUGHNESS, of
 *             Phong's model: alpha of the one image has them. Source: Engel, "Light Pre-Pass Renderer" (2008).
 *   PRELIGHT  highlights have their material's roughness; Fresnel's term is taken at the viewer's angle, after all
 *             lights are summed, and nothing is brushed. Source: Naughty Dog's pre-lighting, as Karis tells it in
 *             "Deferred rendering 2" (2009). */
#define STILB_RENDER_LIGHTINGS(X)                                                                                      \
	X(AUTO, "auto", "clustered if more than eight lights end somewhere, else forward")                                 \
	X(FORWARD, "forward", "each pixel asks every light of the scene")                                                  \
	X(MULTIPASS, "multipass", "surfaces are drawn again for every eight lights of the scene, and added")               \
	X(CLUSTERED, "clustered", "the view is cut into cells, and a pixel asks the lights that reach its cell")           \
	X(DEFERRED, "deferred", "surfaces are drawn first, and lights ask the pixels that show them")                      \
	X(TILED_DEFERRED, "tiled-deferred", "likewise, and a tile asks the lights that reach what it shows")               \
	X(TILED_FORWARD, "tiled-forward",                                                                                  \
	  "depth is drawn first; surfaces ask the lights that reach what their tile shows")                                \
	X(INDEXED, "indexed", "depth is drawn first, and each pixel gets the numbers of its lights")                       \
	X(PREPASS, "prepass", "depth and normals first, lights add to an image, surfaces are drawn again with it")         \
	X(PRELIGHT, "prelight", "likewise with roughness, an image of scattered light and one of highlights")              \
	X(COMBINED, "combined", "each model has four lights of its own, and the others as one sum")

#define STILB_RENDER_LIGHTING_ENUM(id, ...) STILB_RENDER_LIGHTING_##id,
typedef enum stilb_render_lighting {
	STILB_RENDER_LIGHTINGS(STILB_RENDER_LIGHTING_ENUM) STILB_RENDER_LIGHTING_WAYS
} stilb_render_lighting;
#undef STILB_RENDER_LIGHTING_ENUM

/* Their identifiers, NULL-terminated; the index is the stilb_render_lighting. */
extern const char *const stilb_render_lighting_names[];
/* And their words for users. */
extern const char *const stilb_render_lighting_words[];

/* True if the way is for pictures of one sample a pixel. [any-thread] */
bool stilb_render_lighting_is_of_one_sample(stilb_render_lighting way);

#define STILB_RENDER_PREPASS_ROUGHNESS 0.4f

#define STILB_RENDER_LIGHTS_A_PASS                                                                                     \
	8u /* of MULTIPASS; more where a view would need more than half of the 2,048 passes left to a frame's views */

/* Which pixels a light of DEFERRED, PREPASS and PRELIGHT asks. RECTANGLES takes a pass for each light: where a view's
 * would be more than half of the 2,048 that are left to a frame's views, the lights behind are asked by every pixel;
 * and a frame is planned anew as lights or the camera move. VOLUMES takes one pass, in which the stencil marks the
 * pixels whose surface lies inside the light's body; on GPUs without depthClamp it is RECTANGLES. Both round to half
 * floats with each light: of 100,000 weak ones a twelfth is lost. */
#define STILB_RENDER_COVERAGES(X)                                                                                      \
	X(CELLS, cells, "a pixel is written once, with the lights that reach its cell of the view")                        \
	X(SCREEN, screen, "a pixel is written once, with all lights")                                                      \
	X(RECTANGLES, rectangles, "each light is added within the rectangle that holds its reach")                         \
	X(VOLUMES, volumes, "each light is added where what is seen lies in a body around its reach")

#define STILB_RENDER_COVERAGE_ENUM(id, ...) STILB_RENDER_COVERAGE_##id,
typedef enum stilb_render_coverage {
	STILB_RENDER_COVERAGES(STILB_RENDER_COVERAGE_ENUM) STILB_RENDER_COVERAGE_WAYS
} stilb_render_coverage;
#undef STILB_RENDER_COVERAGE_ENUM

/* What DEFERRED and TILED_DEFERRED keep of surfaces. */
#define STILB_RENDER_GBUFFERS(X)                                                                                       \
	X(WIDE, wide, "24 bytes a pixel: 16 bits a number, and depth")                                                     \
	X(RGBA8, rgba8, "12 bytes a pixel: 8 bits a number, depth in 16, the normal as x and y across the pixel's ray")

#define STILB_RENDER_GBUFFER_ENUM(id, ...) STILB_RENDER_GBUFFER_##id,
typedef enum stilb_render_gbuffer {
	STILB_RENDER_GBUFFERS(STILB_RENDER_GBUFFER_ENUM) STILB_RENDER_GBUFFER_KINDS
} stilb_render_gbuffer;
#undef STILB_RENDER_GBUFFER_ENUM

typedef struct stilb_render_deferred {
	stilb_render_coverage coverage;
	stilb_render_gbuffer gbuffer;
} stilb_render_deferred;

/* Who makes the lists of the lights that reach a view's cells. Of COMPUTE the first frame's are by jobs, as it is not
 * known how long they are; where a later frame's are longer than there is room for, pixels without a list ask all
 * lights of the view, for the sake of the same picture, until two frames later. The lists are the same, but for what a
 * device may round otherwise, which sends nothing. With a light_tolerance, which jobs alone keep, they are by jobs.
 * Jobs also make lists that might have 2^32 pairs of light and cell, and on software devices those of so many lights
 * that the loops of compute would be cut short there. */
#define STILB_RENDER_LIGHT_LISTS(X)                                                                                    \
	X(JOBS, jobs, "on the CPU")                                                                                        \
	X(COMPUTE, compute, "on the device")

#define STILB_RENDER_LIGHT_LISTS_ENUM(id, ...) STILB_RENDER_LIGHT_LISTS_##id,
typedef enum stilb_render_light_lists {
	STILB_RENDER_LIGHT_LISTS(STILB_RENDER_LIGHT_LISTS_ENUM) STILB_RENDER_LIGHT_LISTS_WAYS
} stilb_render_light_lists;
#undef STILB_RENDER_LIGHT_LISTS_ENUM

/* Identifiers of these, NULL-terminated; the index is the enumeration's. */
extern const char *const stilb_render_light_lists_names[];
extern const char *const stilb_render_coverage_names[];
extern const char *const stilb_render_gbuffer_names[];

/* What lights surfaces in place of the surroundings. A frame is emitted light + the sum over the lights + the
 * surroundings' light x diffuse reflectance + what highlights mirror of them; a kind says what the surroundings are
 * taken for in the last two, so that what a metal mirrors is as bright as what lights it. A panorama's small bright
 * lamps, as a sun, are among the lights, and not among what is approximated, but with NONE. Backdrops show the
 * surroundings themselves.
 *   ENVIRONMENT of a panorama a table of its irradiance and a prefiltered cube; of sky and ground the exact irradiance,
 *               and they are mirrored if stilb_scene_surroundings.glossy. The other kinds always mirror.
 *   NONE        no light at all. What rough glass blurs of the surroundings is black, too.
 *   CONSTANT    their mean radiance, from everywhere. A highlight mirrors it, too: a metal, which has no diffuse
 *               reflectance, would be black otherwise.
 *   HEMISPHERE  two colours, above and below the horizon: sky and ground, of a panorama the means of its halves. They
 *               are mirrored (shade_hemisphere_radiance): a metal whose map of diffuse reflectance is black shows them.
 *               Source: Schueler, "Blinn-Phong Normalization: A paradigm shift for texturing" (2011).
 *   SH_VERTEX   nine spherical harmonics of their radiance (shading/shade_sh.h), the irradiance summed for each vertex
 *               in each frame and interpolated: without maps of normals. Impostors and surfaces with a function of the
 *               program's have it by pixel. Source: maxest, "Spherical Harmonic Lighting - Analytical Lights" (2015).
 *   SH_PIXEL    the same sum for each pixel and its mapped normal. Of sky and ground it is exact.
 * Both SH mirror the harmonics, each band as a Phong lobe of the material's exponent leaves it (shade_sh_lobe):
 * blurred, since three bands hold nothing narrow. Where light is so narrow that its irradiance would be negative
 * somewhere, the harmonics are blurred just enough (shade_sh_window), for highlights until radiance is not negative
 * either. */
#define STILB_RENDER_AMBIENTS(X)                                                                                       \
	X(ENVIRONMENT, "environment", "the surroundings as they are")                                                      \
	X(NONE, "none", "surroundings light nothing")                                                                      \
	X(CONSTANT, "constant", "the surroundings' mean from everywhere")                                                  \
	X(HEMISPHERE, "hemisphere", "two colours, above and below the horizon")                                            \
	X(SH_VERTEX, "sh-vertex", "nine spherical harmonics, summed for each vertex")                                      \
	X(SH_PIXEL, "sh-pixel", "nine spherical harmonics, summed for each pixel")

#define STILB_RENDER_AMBIENT_ENUM(id, ...) STILB_RENDER_AMBIENT_##id,
typedef enum stilb_render_ambient {
	STILB_RENDER_AMBIENTS(STILB_RENDER_AMBIENT_ENUM) STILB_RENDER_AMBIENT_KINDS
} stilb_render_ambient;
#undef STILB_RENDER_AMBIENT_ENUM

/* Their identifiers, NULL-terminated; the index is the stilb_render_ambient. */
extern const char *const stilb_render_ambient_names[];
/* And their words for users. */
extern const char *const stilb_render_ambient_words[];

/* What scene passes draw into, in place of the picture's own images: for a second camera, or for what a light sees. Its
 * images are the frame's, in its plan, where features find them by name. Passes whose views point to the same target
 * draw into the same images; of these the first pass says exposure, tone map and backdrop. */
typedef enum stilb_render_target_kind {
	STILB_RENDER_TARGET_LIGHT, /* linear radiance NAME, rgba16_f; its depth NAME " depth", d32_f; like the picture's */
	STILB_RENDER_TARGET_DEPTH, /* depth alone, NAME, d32_f, one sample a pixel: nothing is lit */
} stilb_render_target_kind;

#define STILB_RENDER_TARGET_NAME 48u /* bytes of a target's name at most */

typedef struct stilb_render_target {
	const char *name; /* no other image's; "color": these are the main images, in another size: features of the stage
	                     LIGHT get them, and stilb_render_read_radiance reads them; their depth is called "depth" */
	stilb_render_target_kind kind;
	uint32_t width, height; /* pixels, 1..16384 */
	bool output;            /* it is read after the frame (stilb_gpu_read_begin); else only if a pass reads it */
	uint16_t place[4];      /* of LIGHT: left, top, width, height of the rectangle of the picture that shows it, tone
	                           mapped, filtered if its size is another one; width 0: none. Later targets lie over
	                           earlier ones. What no target covers is black */
	uint8_t border;         /* pixels at the edges of its place that are black */
	uint16_t layers;        /* of DEPTH, 0..256: its image is an array of so many; 0: it is none */
	/* Of DEPTH: what views have drawn stays for the next frames, in the rectangles that no view fills. Undefined in the
	 * first frame, and after one without it, of another size, or that failed. One target of a frame. */
	bool lasting;
} stilb_render_target;

/* Makes the image of a lasting target before the frame that draws it, or leaves it, if it is as large. On failure there
 * is none, and a smaller one can be tried: STILB_ERROR_MEMORY, ... [one-writer], before the frame is replayed */
stilb_result stilb_render_reserve_target(stilb_render *render, const stilb_render_target *target);

/* ---- shadows ---- */

/* A map: depth as a light sees it, which a view has drawn into a rectangle of a layer of the shadows' target. */
typedef struct stilb_render_shadow_map {
	stilb_mat4 view_projection; /* the view's */
	uint16_t layer;             /* and its layer and area */
	uint16_t area[4];
	/* Texels at the map's sides, inside of the filter's, along which it gives way to the light's next map, the last one
	 * to light, and half as many before `far`; 0: what lies beyond the map is in light. Of directional lights alone. */
	float blend;
	float far; /* of these: metres from the camera where it ends; 0: nowhere */
} stilb_render_shadow_map;

/* The maps of a light, first_map .. first_map + map_count - 1; 0: nothing keeps it from surfaces. A directional light
 * asks them in turn. Others have one, outside of which they shine freely, or six: of the sides of a cube around the
 * light, +X -X +Y -Y +Z -Z, whose views see a little more than 90 degrees, so that the filter finds what it needs. Maps
 * of directional lights are whole layers. */
typedef struct stilb_render_shadow {
	uint32_t first_map, map_count;
	float faded; /* 0..1: the share of its shadow that is in light all the same; of a directional light 0 */
} stilb_render_shadow;

/* What keeps lights from surfaces. The passes that draw the maps come before those that read them. Maps are filtered
 * about the point, by the cosine: weights 1 + cos(pi d / filter) of texels at the distance d along a row and along a
 * column, which add up to the same everywhere. Each texel is compared with the plane through the point across its
 * normal, which the map's own slope and depth's rounding move away from the light (stilb_render_view.shadow). Sources:
 * Isidoro, "Shadow Mapping: GPU-based Tips and Techniques" (2006), for the plane; Karis, "Uncharted 2" (2010), for
 * filters of many samples. */
#define STILB_RENDER_MAX_SHADOW_FILTER 3u
typedef struct stilb_render_shadows {
	const stilb_render_target *target; /* of kind DEPTH, with two layers or more, of equal sides; without maps NULL */
	const stilb_render_shadow_map *maps;
	const stilb_render_shadow *lights; /* [light_count of the view] */
	uint32_t map_count;                /* 0..65,536; 0: lights shine freely, by the programs that are there for maps */
	/* 1, 2, 3: half the filter's width in texels; it takes 4, 16, 36 samples. 0: there is none, one texel is asked. */
	uint32_t filter;
	/* By how much surfaces may be off, >= 0: levels of detail in maps, texels, and those that are seen, pixels. So much
	 * nearer to the light a point is taken to be. */
	float map_error, view_error;
} stilb_render_shadows;

/* How shadows are read; {0}: as stilb_render_shadows says. */
typedef struct stilb_render_shadow_reading {
	bool no_plane; /* texels are compared with the point's own depth */
	bool no_way;   /* the point stays where it is: surfaces are not off */
	bool things;   /* maps of directional lights hold near things alone; what all else keeps back is in
	                  STILB_RENDER_IMAGE_MASK, and a pixel gets the less of both shares */
	uint32_t
		taps; /* 1, 4, 12: so many comparisons, each of the four texels around a place, in a pattern that alternates
	                  from pixel to pixel, in place of the filter, whose width the bias has. 0: none */
	/* Of what can be lit later or in several passes (STILB_RENDER_IMAGE_SHADOW_BUFFER): the shares of light that arrive
	 * are drawn into an image before light is added up, and read from that. Its depth is drawn before, in all ways of
	 * lighting; MULTIPASS is as FORWARD. Of one sample a pixel and up to STILB_RENDER_SHADOW_BUFFER_LIGHTS lights with
	 * maps; else maps are read. */
	bool buffer;
} stilb_render_shadow_reading;

#define STILB_RENDER_SHADOW_BUFFER_LIGHTS 64u

/* How what lies between two 8-bit codes is shown as a fine pattern of both, so that no bands are seen; the same for all
 * channels, by the pixel alone.
 *   ORDERED     up to half a code, by an 8 x 8 pattern of blue noise: what is a code stays it
 *   TRIANGULAR  up to a code, more often less, so that neither the mean nor the noise depends on where between two
 *               codes the light is; at the ends as much as the display has room for. By interleaved gradient noise,
 *               which no tile repeats.
 * Sources: Jimenez, "Next Generation Post Processing in Call of Duty: Advanced Warfare" (2014), for that noise;
 * Lipshitz, Wannamaker, Vanderkooy, "Quantization and dither: a theoretical survey" (1992), for triangles. */
typedef enum stilb_render_dither {
	STILB_RENDER_DITHER_OFF,
	STILB_RENDER_DITHER_ORDERED,
	STILB_RENDER_DITHER_TRIANGULAR,
	STILB_RENDER_DITHERS
} stilb_render_dither;

/* A table of colours in which the tone map looks up what it shows, before dither. What is looked up, and what stands
 * there, are codes of sRGB over 255, which may lie outside of 0..1. Between entries it is linear in each of the six
 * tetrahedra that share the grey diagonal of a cell of eight entries; so greys depend on greys alone. */
typedef struct stilb_render_grade {
	stilb_gpu_image table; /* rgba32_f, of shape 3D: size x size x size, red along x, green along y; curves: 256 wide,
	                          entry i at x = i % 256, y = i / 256 */
	uint32_t size;         /* entries a side, 2..256; curves: 2..65,536 */
	bool curves;           /* each channel has a curve of its own */
	float low[3], high[3]; /* the codes of the first and the last entry; beyond these the nearest counts */
} stilb_render_grade;

/* What passes into the main images keep light in; the frame's light, which features and the tone map get, is half
 * floats. In 8 bits it is multiplied by 2^exposure, so that display white is 1 (shading/shade_encoding.h): with a row
 * that decodes it or, of several samples, makes the mean of what they decode to. Frames that add or blend light keep
 * half floats: with lighting MULTIPASS, DEFERRED and TILED_DEFERRED, ambient_apart, a backdrop of nothing, surfaces
 * that blend or let light through, and other things than SHADED (stilb_render_stats.hdr). PREPASS and PRELIGHT add up
 * in images of half floats beside it. */
#define STILB_RENDER_HDR_KINDS(X)                                                                                      \
	X(HALF, half, "half floats, 8 bytes")                                                                              \
	X(RGBM, rgbm, "4 bytes: colour and multiplier, up to 51.5 times display white")                                    \
	X(LOGLUV, logluv, "4 bytes: hue and the logarithm of luminance; any brightness")

#define STILB_RENDER_HDR_ENUM(id, ...) STILB_RENDER_HDR_##id,
typedef enum stilb_render_hdr { STILB_RENDER_HDR_KINDS(STILB_RENDER_HDR_ENUM) STILB_RENDER_HDRS } stilb_render_hdr;
#undef STILB_RENDER_HDR_ENUM

/* Their identifiers, NULL-terminated; the index is the stilb_render_hdr. */
extern const char *const stilb_render_hdr_names[];

/* A camera, its lights and its formulas. A pass names its view by index. Formulas that the device has not used before
 * are compiled during stilb_render_replay, which then takes some milliseconds, and kept. */
typedef struct stilb_render_view {
	const stilb_render_target *target; /* NULL: the main images, as large as the picture, which show in all of it */
	stilb_mat4 view_projection;        /* world to clip space: depth 1 is near, 0 is far, y points down */
	/* Moves what is drawn, and what `last` says of it, right and down by shares of half the picture, by less than half
	 * a pixel: temporal antialiasing. Lists of lights, fading and the stream hash are as without, since what a pixel
	 * shows stays within it. */
	float jitter[2];
	float camera_position[3]; /* world space, metres */
	/* Of a target of kind DEPTH: the layer and the rectangle of it (left, top, width, height) that the view fills, and
	 * leaves the rest of the layer; all 0: all of it. The first pass into a layer clears it, if the target is lasting
	 * each its rectangle. */
	uint16_t layer, area[4];
	bool shadow; /* of such a target: it is a map of a light. Depth is moved away from the light by a texel's slope */
	bool shadow_flat; /* likewise: but that by the slope */
	/* The view_projection of the frame before; its passes then also draw the image "velocity", of a target with
	 * another name NAME " velocity" (render_images.h), of all but what blends. What has moved are the models that
	 * the scene lists as moved, and of these the vertices that were written. In the first frame with it models, and in
	 * the first two vertices, are taken to stand still. Costs 56 bytes a part, and 12 a vertex that moves. NULL: no
	 * such image. Read during recording and replay. */
	const stilb_mat4 *last;
	bool surfaces; /* besides `last`: those passes draw "surface normal" and "id", too (render_images.h) */
	bool ids;      /* likewise "id" alone, which costs less */
	/* The surroundings' light on what is opaque, and has neither layers nor a function of the program's, is drawn apart
	 * from all other: "ambient" and "reflection" (render_images.h). Then it is added, which rounds to half floats three
	 * times more; before what else there is. Of one sample a pixel alone: else they are not drawn. */
	bool ambient_apart;
	bool blended; /* passes also draw "blended depth" (render_images.h), of one sample a pixel */
	bool mirrors; /* with ambient_apart: its passes also draw "mirror" and "mirror normal" (render_images.h) */
	const stilb_scene_light
		*lights; /* [light_count] without a mistake (stilb_scene_light_mistake); BAKED ones are left out. Read
	                                  during stilb_render_replay. */
	uint32_t light_count;
	const stilb_render_shadows *shadows;        /* what keeps these from surfaces; NULL: nothing. Likewise */
	stilb_render_shadow_reading shadow_reading; /* how that is read */
	stilb_render_lighting lighting;
	stilb_render_deferred deferred; /* how, for ways that have these */
	stilb_render_light_lists light_lists;
	/* What lights that are left out of a pixel may send, all of them together, whatever the material: a share of
	 * display white, which is the radiance 2^-exposure W sr^-1 m^-2, in each channel; 0..1. Display codes are finer in
	 * the dark: a step of sRGB next to black is 1/13 of 1/255. 0: nothing is left out. Above 0 lamps without end have
	 * one, too, where lists are used: with AUTO, CLUSTERED, and DEFERRED by CELLS. With TILED_DEFERRED a tile leaves
	 * out a light that ends if the bounds of its scattered light and of its highlight are both below the light's share;
	 * the highlight's is low where the light lies outside of the cone of mirrored directions. Other ways leave nothing
	 * out, also where they are as AUTO. */
	float light_tolerance;
	/* Pixels, >= 0: a light with an end fades out with the distance of the camera: where its reach is seen as twice so
	 * many pixels it is whole, where as so many it is gone, smoothly in between, in all ways of lighting. 0: none */
	float light_fade;
	uint32_t light_fade_height; /* pixels of height at which light_fade counts; 0: those of what is drawn into */
	float light_peak; /* stilb_render_light_peak of the scene; read if light_tolerance is above 0, and then >= 1 / pi */
	stilb_render_ambient ambient; /* what lights in place of the surroundings */
	/* The panorama in place of sky and ground if it has floats; read during stilb_render_replay, which makes what the
	 * frames need of it when another one comes (some ten milliseconds on the pool): pixels that were changed in place
	 * may go unnoticed. One panorama a frame, that of the first view with one. */
	stilb_scene_surroundings surroundings;
	stilb_scene_backdrop backdrop; /* of the target's first pass; SURROUNDINGS: the panorama, or the sky's radiance */
	stilb_render_shading shading;
	bool both_sides;            /* triangles are seen from behind, too: see stilb_scene.both_sides */
	bool impostors;             /* the scene has some: stilb_render_prepare_view compiles what draws them, too */
	stilb_render_detail detail; /* of stilb_render_record_view; {0}: everything is drawn in full */
	stilb_render_show show;
	float time; /* seconds; surface functions get it (scene_function.h). Beyond 16,384 s it goes by steps of 2 ms */
	/* How the picture shows radiance with output DISPLAY; those of the target's first pass count. */
	float exposure;                  /* stops: radiance is multiplied by 2^exposure before the tone map */
	uint32_t tone;                   /* SHADE_TONE_... of shading/shade_tonemap.h */
	const stilb_render_grade *grade; /* NULL: none. Of light alone; likewise with output DISPLAY. Read during replay */
	stilb_render_dither dither;
	stilb_render_hdr hdr; /* of views into the main images; others are as HALF */
} stilb_render_view;

/* The matrices by which the view is drawn, moved by its jitter: its view_projection, and that of the frame before,
 * which without a `last` is the same. [any-thread] */
stilb_mat4 stilb_render_view_drawn(const stilb_render_view *view);
stilb_mat4 stilb_render_view_drawn_last(const stilb_render_view *view);

/* The largest BRDF times cosine that a surface of the scene may have, sr^-1, shaded like that: the bound of
 * shade_brdf_peak for the lowest roughness, the highest reflectances and the layers of all materials. A roughness from
 * a map or a program's function may be anything, and counts as 0: of such scenes hardly any light can be left out.
 * 1 / pi or more. Reads all materials. [any-thread] */
float stilb_render_light_peak(const stilb_scene *scene, const stilb_render_shading *shading);

/* Compiles what passes with this view may need, with textures and without, and for the surfaces of scenes that have
 * been set or prepared, unless it is there; frames go on meanwhile, and one that needs what is being compiled waits for
 * it. Read are the lights' number, kinds and falloffs, whether there are shadows, shadow_reading, lighting,
 * light_tolerance, light_fade, ambient, ambient_apart, surroundings, backdrop's kind, sides, shading, detail,
 * impostors, tone, show, whether it is a shadow's, and how, the target's kind, surfaces, ids, mirrors, and whether
 * there is a `last`. STILB_ERROR_MEMORY, STILB_ERROR_DEVICE. [any-thread] */
stilb_result stilb_render_prepare_view(stilb_render *render, const stilb_render_view *view);

typedef enum stilb_render_pass_kind {
	STILB_RENDER_PASS_SCENE, /* meshes, seen from a view, into its target */
	STILB_RENDER_PASS_2D,    /* triangles over the finished picture, in the order of their recording */
} stilb_render_pass_kind;

typedef struct stilb_render_pass {
	const char *name; /* for the profiler, the validation layer and dumps; NULL: "pass" */
	stilb_render_pass_kind kind;
	uint32_t view;  /* index into the frame's views; not read for 2D passes */
	uint32_t order; /* passes are replayed by ascending order, 2D passes after all scene passes; ties by table index */
	bool sort;      /* true: draws by ascending key, equal keys as recorded; false: as recorded. Not for 2D passes */
} stilb_render_pass;

#define STILB_RENDER_MAX_PASSES 256

/* ---- frames ------------------------------------------------------------------------------------------------------ */

/* Replaces the contexts, for another number of workers; between frames. stilb_render_stream_hash of the last frame can
 * no longer be asked for. On STILB_ERROR_MEMORY everything is as before. [main-thread] */
stilb_result stilb_render_set_context_count(stilb_render *render, uint32_t context_count);

/* Lets the threads of this pool help stilb_render_set_scene and _update_scene with the mips of textures. Its owner is
 * the main thread; it must live until another one is set, or NULL for none, as before the first call. [main-thread] */
void stilb_render_set_pool(stilb_render *render, stilb_job_pool *pool);

/* The next frame chooses levels of detail as if there had been none before; between frames. [main-thread] */
void stilb_render_forget_levels(stilb_render *render);

/* Changes the picture's size, 1..16384 pixels a side; between frames. The last picture is lost. STILB_ERROR_DEVICE
 * (larger than this GPU draws): no frame can begin until a resize succeeds. The images are made by the next frame's
 * replay, which may have no memory for them. [main-thread] */
stilb_result stilb_render_resize(stilb_render *render, uint32_t width, uint32_t height);

/* The picture's size, pixels. [main-thread] */
void stilb_render_size(const stilb_render *render, uint32_t *width, uint32_t *height);

/* Begins a frame: waits until the device has finished the frame before the last, whose memory this one reuses, and
 * makes all contexts empty. STILB_ERROR_MEMORY, STILB_ERROR_DEVICE, STILB_ERROR_DEVICE_LOST. [main-thread] */
stilb_result stilb_render_frame_begin(stilb_render *render);

/* Records a whole pass: every part of the models visible[0 .. visible_count - 1], in that order, spread over the pool.
 * The scene is the one that was set. The frame's first call reads the transforms of models that have moved: those that
 * stilb_render_update_scene has noted and those still in scene->moved. What others have is what they had when they were
 * last listed. A program that changes part_transform without scene_edit.h lists the model, too. pass:
 * 0..STILB_RENDER_MAX_PASSES - 1, not yet recorded in this frame. STILB_ERROR_MEMORY. [main-thread] */
stilb_result stilb_render_record(stilb_render *render, uint32_t pass, const stilb_scene *scene, const uint32_t *visible,
                                 uint32_t visible_count, stilb_job_pool *pool, uint32_t worker);

/* stilb_render_record with the levels and clusters of meshes that view->detail asks for, as seen from the view, by
 * which the pass is then replayed. Clusters out of its sight are left out. Which levels were drawn last is remembered
 * for each pass number, but for shadow maps with POP: each has what its view alone asks for, whatever was drawn before.
 * [main-thread] */
stilb_result stilb_render_record_view(stilb_render *render, uint32_t pass, const stilb_scene *scene,
                                      const uint32_t *visible, uint32_t visible_count, const stilb_render_view *view,
                                      stilb_job_pool *pool, uint32_t worker);

/* A pass of stilb_render_record_views: the members are as the arguments of stilb_render_record_view; view NULL: as
 * stilb_render_record. */
typedef struct stilb_render_recording {
	uint32_t pass;
	uint32_t visible_count;
	const uint32_t *visible; /* [visible_count] */
	const stilb_render_view *view;
} stilb_render_recording;

/* Records several passes of different numbers at once, their work spread over the pool as if they were one.
 * STILB_ERROR_MEMORY. [main-thread] */
stilb_result stilb_render_record_views(stilb_render *render, const stilb_scene *scene,
                                       const stilb_render_recording *passes, uint32_t count, stilb_job_pool *pool,
                                       uint32_t worker);

/* Turns the lists of passes 0 .. pass_count - 1 (1..STILB_RENDER_MAX_PASSES, each recorded) into device commands and
 * submits them; once a frame. Passes and views are read during the call only. The pool records secondary command
 * buffers.
 * STILB_ERROR_ARGUMENT: a target has the name of another image, or its place lies outside the picture.
 * STILB_ERROR_MEMORY, STILB_ERROR_DEVICE, STILB_ERROR_DEVICE_LOST: the frame is not drawn. [main-thread] */
stilb_result stilb_render_replay(stilb_render *render, const stilb_render_pass *passes, uint32_t pass_count,
                                 const stilb_render_view *views, uint32_t view_count, stilb_job_pool *pool,
                                 uint32_t worker);

/* Shows the replayed picture in the window; without one it does nothing. An outdated or minimised window is no error:
 * the frame is then not shown. STILB_ERROR_WINDOW: the window or its display has gone; later pictures are not shown
 * until stilb_render_set_surface gives another one. STILB_ERROR_MEMORY, STILB_ERROR_DEVICE, STILB_ERROR_DEVICE_LOST.
 * [main-thread] */
stilb_result stilb_render_present(stilb_render *render);

/* From the next stilb_render_present on pictures are shown in this window instead of the one before, which may be lost,
 * have been closed or be the same; NULL: they are not shown. The old surface is destroyed, so call it with NULL
 * before the old window closes. The presentation that desc asks for is tried again. Scene and last picture stay.
 * Between frames. STILB_ERROR_WINDOW: the renderer was created without a surface, or this GPU cannot present to this
 * window. STILB_ERROR_MEMORY, STILB_ERROR_DEVICE: the window cannot be used now. After these pictures are not shown,
 * and the call may be made again. STILB_ERROR_DEVICE_LOST. [main-thread] */
stilb_result stilb_render_set_surface(stilb_render *render, const stilb_gpu_surface *surface);

/* A copy of the last replayed picture, RGB, top row first, in the format of desc.output; waits for the device; between
 * frames. If the backdrop of the first pass into the main images is nothing there is alpha, too, the share of the pixel
 * that models cover; radiance is premultiplied by it, as EXR files have it, codes are not. stilb_image_finish it.
 * STILB_ERROR_DEVICE: no frame of this size has been drawn yet, the last one failed, or the null device.
 * STILB_ERROR_MEMORY. [main-thread] */
stilb_result stilb_render_read_image(stilb_render *render, stilb_image *image);

/* As stilb_render_read_image, but of the main images, what scene passes alone have drawn: linear radiance,
 * STILB_IMAGE_F16_LINEAR, without exposure, tone map and 2D passes, whatever desc.output is. STILB_ERROR_DEVICE also if
 * the last frame had no scene pass into them. [main-thread] */
stilb_result stilb_render_read_radiance(stilb_render *render, stilb_image *image);

/* What belongs into a file of this name: with output DISPLAY stilb_render_read_radiance for .exr and .hdr, else
 * stilb_render_read_image. [main-thread] */
stilb_result stilb_render_read_for_file(stilb_render *render, const char *path, stilb_image *image);

/* Waits until the device has drawn every submitted frame; stats.gpu_ms is then the last frame's. [main-thread] */
stilb_result stilb_render_wait(stilb_render *render);

/* Counters of the last replayed frame. */
typedef struct stilb_render_stats {
	uint64_t draws;
	uint64_t recorded_bytes;    /* commands and 2D geometry of these draws, and the rows that the frame wrote */
	uint64_t draw_commands;     /* device commands that make a single draw */
	uint64_t indirect_commands; /* device commands that make many: all consecutive draws with the same bindings */
	uint64_t execute_commands;  /* secondary command buffers executed */
	uint64_t binds_asked;       /* pipeline, buffers and material of every draw: three a draw */
	uint64_t binds_sent;        /* programs, indices, and textures or materials that went to the device */
	uint64_t lights;            /* of all passes' views that are lit, without BAKED ones */
	uint64_t light_faded;       /* those of them that stilb_render_view.light_fade makes darker, gone ones included */
	uint64_t light_gone;        /* those that it leaves nothing of */
	uint64_t light_pairs;       /* of light and cell in the lists of all passes; by compute those of a frame before */
	uint64_t light_left_out;    /* such pairs that stilb_render_view.light_tolerance kept out of them */
	uint64_t shadow_terms;      /* of lights in buffers of shadows, of all passes; and the bytes of these */
	uint64_t shadow_bytes;
	stilb_render_hdr hdr; /* what the main images' light was kept in */
	double gpu_ms;        /* GPU time of the last frame whose time is known, ms; 0 on the null device */
} stilb_render_stats;

/* [main-thread] */
stilb_render_stats stilb_render_stats_get(const stilb_render *render);

/* Triangles of the last replayed frame's scene passes; reads all of its commands. Valid as stilb_render_stream_hash.
 * [main-thread] */
uint64_t stilb_render_triangles(const stilb_render *render);

/* FNV-1a 64 over the last frame's scene passes in replay order, little endian: the members of the view's
 * stilb_render_shading (32 bits each), sky and ground (3 floats each), glossy + 2 ambient, both_sides and the number of
 * lights (32 bits each), and the lights that frames show (20 floats each, render_light), those that end nowhere first;
 * of a view lit by lists only those that may reach it; without passes and lights' parts that are of shadows; then for
 * each draw mesh id, material id (32 bits each: those of the scene that was set, or of other handles their indices,
 * counted from 0), the 16 floats of
 * the transform (column-major) and the index count (32 bits), which tells the level; of a draw that fades or morphs
 * also how far it has come (32 bits). The same for every device, replay mode and number of workers.
 * Valid from stilb_render_replay until the next frame begins; without a replayed frame it is the hash of nothing.
 * [main-thread] */
uint64_t stilb_render_stream_hash(const stilb_render *render);

/* ---- rows of one's own --------------------------------------------------------------------------------------------
 * Each frame is a plan (gpu_plan.h), to which a program may add images, buffers and passes of its own: at a stage,
 * every frame, in the order in which features were added. Programs, buffers and what else they need is made with the
 * device that stilb_render_gpu gives. stilb_gpu_plan_find finds render's own images: "color", "depth", "picture". */

typedef enum stilb_render_stage {
	STILB_RENDER_STAGE_FIRST,      /* before all other passes; image: 0 */
	STILB_RENDER_STAGE_AMBIENT,    /* of main views with ambient_apart; image: "ambient" (render_images.h) */
	STILB_RENDER_STAGE_REFLECTION, /* likewise "reflection"; then both are added to the main radiance */
	/* image: what scene passes have drawn into the main images, before the mean of its samples is taken, and 8 bits
	 * become radiance (stilb_render_hdr): rgba16_f or rgba8_u, of the samples that it has */
	STILB_RENDER_STAGE_DRAWN,
	STILB_RENDER_STAGE_LIGHT,   /* image: the main linear radiance, rgba16_f, a sample a pixel; then the tone map */
	STILB_RENDER_STAGE_PICTURE, /* image: the picture after the tone map; 2D passes follow */
	STILB_RENDER_STAGE_LAST,    /* image: the picture with everything over it */
	STILB_RENDER_STAGES,
} stilb_render_stage;

typedef struct stilb_render_feature {
	stilb_render_stage stage;
	/* Adds rows to the plan. *image may become another image of the same size and format, which then takes the place
	 * of the one that was given; not in stages FIRST, DRAWN and LAST. An error, with its message, ends the frame.
	 * Called by stilb_render_replay; frames without a scene pass into the main images have no stages DRAWN and LIGHT,
	 * frames that show no target no stage PICTURE. The main images, and so those of DRAWN and LIGHT, may have another
	 * size than the picture. */
	stilb_result (*add)(void *user, stilb_gpu_plan *plan, uint16_t *image);
	void *user;
} stilb_render_feature;

#define STILB_RENDER_MAX_FEATURES 32u

/* Adds a list of draws, which may be empty, to the frame, for a row of kind DRAWS that a feature adds; *number is for
 * its stilb_gpu_pass.draws. What the list points to stays until stilb_render_replay returns. Within
 * stilb_render_feature.add. STILB_ERROR_ARGUMENT: the frame has STILB_RENDER_MAX_FEATURES of them already.
 * [main-thread] */
stilb_result stilb_render_add_draws(stilb_render *render, const stilb_gpu_draws *draws, uint32_t *number);

/* From the next replay on frames have its rows. STILB_ERROR_ARGUMENT: there are STILB_RENDER_MAX_FEATURES already.
 * [main-thread] */
stilb_result stilb_render_add_feature(stilb_render *render, const stilb_render_feature *feature);
/* Removes the features with this user. [main-thread] */
void stilb_render_remove_feature(stilb_render *render, const void *user);

/* An image of the plan that frames show in the place of the picture, under the 2D passes: nearest texels, stretched
 * over the picture; depth and images of one channel grey, of two red and green, numbers as colours. Of an image with
 * several samples a pixel the first sample. */
typedef struct stilb_render_shown {
	const char *name; /* copied */
	uint32_t mip, layer;
	float low, high; /* the values that are black and white, linearly in between; both 0: 0 and 1 */
	bool optional;   /* a frame that has no such image shows the picture */
} stilb_render_shown;

/* From the next replay on, in frames with a scene pass; NULL: frames show the picture. An image that a frame has not,
 * or has only later, or that is not 2D is an error of the frame, which names those that there are. [main-thread] */
void stilb_render_show_image(stilb_render *render, const stilb_render_shown *shown);

/* From the next replay on frames end with this pass of their plan: the rows behind it are left out
 * (stilb_gpu_plan_cut). The picture then shows the image of stilb_render_show_image, or else the one that the pass has
 * drawn into, its first one if there are several. pass: copied, 63 bytes at most; a name, of which the frame's last row
 * with that name counts, or a number as stilb_gpu_plan_text prints it. NULL or "": frames are whole. Errors of the
 * frame, STILB_ERROR_ARGUMENT: it has no such pass, the message names those that there are; the image has no content by
 * then; the pass draws into none, and no other is shown. [main-thread] */
void stilb_render_until(stilb_render *render, const char *pass);

/* The device, for programs, buffers and images of one's own: destroy them before the renderer. Frames are render's to
 * begin and run. [any-thread] */
stilb_gpu *stilb_render_gpu(stilb_render *render);
/* The plan of the last replayed frame, for stilb_gpu_read_begin, stilb_gpu_plan_text and stilb_gpu_plan_svg, until the
 * next replay. [main-thread] */
const stilb_gpu_plan *stilb_render_plan(const stilb_render *render);

/* ---- recording by hand -------------------------------------------------------------------------------------------
 * stilb_render_record does this for a scene. For own draws: pass_begin on the main thread; then each segment 0 ..
 * segment_count - 1 exactly once, on any thread and in any order: segment_begin, draws, segment_end; at last pass_end
 * on the main thread. Draws are replayed by segment number, within a segment as recorded.
 *
 *   result = stilb_render_pass_begin(render, 0, 1);
 *   if (result == STILB_OK) {
 *       stilb_render_context *context = stilb_render_context_get(render, 0);
 *       stilb_render_segment_begin(context, 0, 0);
 *       for (uint32_t i = 0; i < count; i++)
 *           stilb_render_draw(context, mesh, material, &transforms[i]);
 *       stilb_render_segment_end(context);
 *       result = stilb_render_pass_end(render, 0);
 *   }
 */

/* Begins a pass (0..STILB_RENDER_MAX_PASSES - 1) of segment_count segments, which may be 0, inside a frame.
 * STILB_ERROR_MEMORY. [main-thread] */
stilb_result stilb_render_pass_begin(stilb_render *render, uint32_t pass, uint32_t segment_count);

/* The context of a worker, 0..context_count - 1. Valid until stilb_render_set_context_count. [any-thread] */
stilb_render_context *stilb_render_context_get(stilb_render *render, uint32_t worker);

/* Begins and ends a segment, which is a numbered part of a pass. In between, all draws of this context belong to it,
 * and are made by the thread that began it. [one-writer] */
void stilb_render_segment_begin(stilb_render_context *context, uint32_t pass, uint32_t segment);
void stilb_render_segment_end(stilb_render_context *context);

/* Records one draw with the sort key 0. transform: model to world, affine (its last row is 0 0 0 1), copied. If there
 * is no memory for the draw, stilb_render_pass_end reports it. [one-writer] */
void stilb_render_draw(stilb_render_context *context, stilb_render_mesh mesh, stilb_render_material material,
                       const stilb_mat4 *transform);

/* As stilb_render_draw, with a sort key: a pass with .sort set draws in ascending order of it. [one-writer] */
void stilb_render_draw_with_key(stilb_render_context *context, uint64_t key, stilb_render_mesh mesh,
                                stilb_render_material material, const stilb_mat4 *transform);

/* 2D passes: text and flat shapes over the picture, alpha blended in linear light, not tone mapped, without depth, one
 * sample a pixel even if the scene has four. Without a scene pass the picture below is black. A 2D pass without draws
 * costs nothing. They are no part of the stream hash and of dumps. In a segment of such a pass:
 *
 *   uint32_t first = stilb_render_geometry_2d(context, corners, 4, (uint32_t[]){0, 1, 2, 2, 3, 0}, 6);
 *   stilb_render_draw_2d(context, first, 6, (float[]){0.0f, 0.0f, width, height}, glyphs);
 */
typedef struct stilb_render_vertex_2d {
	float position[2]; /* pixels from the picture's top left corner; the first pixel's centre is at 0.5, 0.5 */
	float uv[2];       /* 0, 0 is the texture's top left corner, 1, 1 its bottom right one */
	uint8_t color[4];  /* sRGB and straight alpha; interpolated in linear light, premultiplied */
} stilb_render_vertex_2d;

/* Copies triangles into the frame's memory; each index is below vertex_count. Returns the place of the first index
 * among all the frame's 2D indices, for stilb_render_draw_2d in this frame. If there is no memory it returns 0, and
 * stilb_render_pass_end reports it. Inside a segment of a 2D pass. [one-writer] */
uint32_t stilb_render_geometry_2d(stilb_render_context *context, const stilb_render_vertex_2d *vertices,
                                  uint32_t vertex_count, const uint32_t *indices, uint32_t index_count);

/* Draws index_count of the copied indices, from first_index on, where pixel centres lie in the clip rectangle: left,
 * top, right, bottom in pixels. The texture multiplies the colour and alpha (a glyph is white with its coverage as
 * alpha); {0}: none. With indirect replay consecutive draws of one texture are one device command, whatever their
 * clips. [one-writer] */
void stilb_render_draw_2d(stilb_render_context *context, uint32_t first_index, uint32_t index_count,
                          const float clip[4], stilb_render_texture texture);

/* Shows a picture: the texture's pixels fill the rectangle `place` (left, top, right, bottom in pixels), each pixel the
 * texel that its centre lies in, unfiltered; where the rectangle is as large as the texture they are the same pixels.
 * In place of what is below, alpha is not read. factor > 0: the texels are linear radiance and are shown as frames show
 * it: with output DISPLAY multiplied by factor and tone mapped by `tone`, SHADE_TONE_..., with LINEAR as they are.
 * factor 0: as they are. In a segment of a 2D pass; clip as above. [one-writer] */
void stilb_render_draw_picture(stilb_render_context *context, const float place[4], const float clip[4],
                               stilb_render_texture texture, float factor, uint32_t tone);

/* Ends the recording of a pass; every segment has ended. STILB_ERROR_MEMORY: a context ran out of memory while it
 * recorded. [main-thread] */
stilb_result stilb_render_pass_end(stilb_render *render, uint32_t pass);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#endif
