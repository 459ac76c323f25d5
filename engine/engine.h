/*
 * engine: owns a device, a window and a pool of workers, and draws frames of the program's scene: what a program needs
 * of Stilb to show something in real time.
 *
 * Life cycle.  stilb_engine_create -> stilb_engine_set_scene -> stilb_engine_frame until done -> stilb_engine_destroy;
 *              then the program destroys its scene.
 * Per frame.   stilb_engine_frame; between frames, and in desc.update, everything else: change the scene, take
 *              screenshots, read results. frame.c tells the stages of a frame.
 * Scene.       The program owns it and may set another one at any time. Without one the picture is black.
 * Threads.     [main-thread]: the thread that creates the engine makes all other calls; the workers are the engine's
 *              own. Functions that take no engine are [any-thread].
 * Several.     Each engine has its own thread, or shares one; those with windows share the process's main thread. All
 *              share the profiler: its frames are those of the engine that was there first, it records while one of
 *              them wants it, and the last one's end empties it.
 * A guest.     The libraries install no signal handler unless desc.capture asks for one, register nothing to run at
 *              exit, and change neither locale nor working directory. Opening a window makes Xlib report a lost
 *              display here instead of ending the program. What there is to say goes through stilb_log_set.
 * Time.        In a window, the engine's or the program's, frames step by the clock, 0.1 s at most; headless by 1/60 s,
 *              so that every run gives the same pictures.
 * Errors.      A stilb_result and the line of stilb_error_message. After an error of stilb_engine_frame or
 *              stilb_engine_set_workers only stilb_engine_destroy may follow, unless their comments say otherwise.
 * Example.     A picture of a file, without a window:
 *
 *   stilb_engine_desc desc = stilb_engine_desc_default();
 *   stilb_engine *engine = NULL;
 *   stilb_engine_report report;
 *   stilb_scene *scene;
 *   stilb_result result = stilb_scene_open("model.gltf", &scene);
 *   if (result == STILB_OK)
 *       result = stilb_engine_create(&desc, &engine);
 *   if (result == STILB_OK)
 *       result = stilb_engine_set_scene(engine, scene);
 *   if (result == STILB_OK)
 *       result = stilb_engine_frame(engine, &report);
 *   if (result == STILB_OK)
 *       result = stilb_engine_screenshot(engine, "model.png");
 *   if (result != STILB_OK)
 *       stilb_log("%s", stilb_error_message());
 *   stilb_engine_destroy(engine);
 *   stilb_scene_destroy(scene);
 */
#ifndef STILB_ENGINE_H
#define STILB_ENGINE_H

#include "base/base.h"
#include "culling/cull.h"
#include "debug/debug_draw.h"
#include "input/input.h"
#include "input/input_control.h"
#include "jobs/job.h"
#include "post/post.h"
#include "post/post_preset.h"
#include "profiler/prof_capture.h"
#include "render/render.h"
#include "scene/edit/scene_variant.h"
#include "scene/open/scene_lights.h"
#include "scene/play/scene_play.h"
#include "scene/scene.h"
#include "scene/scene_animation.h"
#include "scene/scene_look.h"
#include "scene/scene_pick.h"
#include "ui/ui_draw.h"

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

typedef struct stilb_engine stilb_engine;

/* The source of gamepads. */
typedef enum stilb_engine_gamepad {
	STILB_ENGINE_GAMEPAD_AUTO,   /* HIDRAW in a window, where errors are logged and ignored; OFF without a window */
	STILB_ENGINE_GAMEPAD_OFF,    /* none */
	STILB_ENGINE_GAMEPAD_HIDRAW, /* the kernel's hidraw devices; in a window also the window library's gamepads */
	STILB_ENGINE_GAMEPAD_HIDAPI, /* as HIDRAW, but through hidapi */
	STILB_ENGINE_GAMEPAD_REPLAY  /* a recorded file, which moves the camera the same way in every run */
} stilb_engine_gamepad;

/* Whether shaders whose files change are compiled again and shown at once (stilb_engine_desc.watch_shaders). */
typedef enum stilb_engine_watch {
	STILB_ENGINE_WATCH_OFF,
	STILB_ENGINE_WATCH_ON,   /* where that is impossible a line says why, and frames go on without */
	STILB_ENGINE_WATCH_AUTO, /* likewise, without the line */
} stilb_engine_watch;

/* The rows of the engine's table of actions that follow those of the camera (input_actions.h); then come the program's,
 * the first with the number STILB_ENGINE_ACTIONS. */
enum {
	STILB_ENGINE_KEYS = STILB_INPUT_ACTIONS, /* open or close the key card, which lists this table */
	STILB_ENGINE_TIMES,                      /* show frame rate and time in a corner, or hide them */
	STILB_ENGINE_PROFILER,                   /* open or close the profiler's window */
	STILB_ENGINE_FREEZE,                     /* freeze the open profiler, or let it go on; else pause what plays */
	STILB_ENGINE_MATERIALS,                  /* open or close the materials' window */
	STILB_ENGINE_CAPTURE,                    /* asked for: a trace of the frames around this moment */
	STILB_ENGINE_PICTURE,                    /* asked for: a picture; its frame has no toasts, first line and times */
	STILB_ENGINE_IMAGE,                      /* show the next image of the frame's plan in the picture's place */
	STILB_ENGINE_IMAGE_BACK,                 /* the one before */
	STILB_ENGINE_IMAGE_PART,                 /* show that image's next mip, or the first mip of its next layer */
	STILB_ENGINE_IMAGE_PART_BACK,            /* the one before */
	STILB_ENGINE_SHOW,                       /* pictures show the next of stilb_render_show, which a toast names */
	STILB_ENGINE_SHOW_BACK,                  /* the one before */
	STILB_ENGINE_LIGHTING,                   /* pixels find their lights in the next way of stilb_render_lighting */
	STILB_ENGINE_LIGHTING_BACK,              /* the one before */
	STILB_ENGINE_VALUE,     /* show the linear light under the pointer, or hide it; channels always show it */
	STILB_ENGINE_CLIPS,     /* open or close the animation's window */
	STILB_ENGINE_LIGHTS,    /* open or close the lights' window, in which they are listed and changed */
	STILB_ENGINE_EFFECTS,   /* open or close the effects' window, with what happens to the light of frames */
	STILB_ENGINE_STEP,      /* move what plays on by 1/60 s */
	STILB_ENGINE_STEP_BACK, /* and back */
	STILB_ENGINE_ACTIONS
};

/* What a frame tells the program's part of it. */
typedef struct stilb_engine_update {
	uint64_t frame;                 /* number of the frame that is being made, from 1 */
	double seconds;                 /* the engine's time: 0 in the first frame, then the sum of all steps before */
	const stilb_input_state *input; /* this frame's keys, mouse and gamepads */
} stilb_engine_update;

/* A picture of the program's, such as one that is ray traced, in place of the scene; see stilb_engine_show. */
typedef struct stilb_engine_shown {
	/* [height][width][3] linear radiance in W sr^-1 m^-2, row 0 at the top, which is copied; NULL: the pixels of the
	 * call before. It fills the frame; where it has the frame's size, pixel by pixel. */
	const float *radiance;
	uint32_t width, height; /* of radiance, 1..16384 */
	/* The picture is shown right of this share of the width, the scene left of it: 0: the picture alone; 1: the scene
	 * alone. The program's, valid as long as a picture is shown; the user's drags change it in frames' stage ui. */
	float *from;
	bool still;   /* all that the scene shows is as in the frame before, its camera too: it is not drawn again */
	bool divider; /* in a window: a line that the user can drag is between them */
} stilb_engine_shown;

/* What lies under a point of the picture; see scene_pick.h. */
typedef stilb_scene_hit stilb_engine_hit;

/* Called once in each frame, in its stage scene update, after input has moved the camera and before anything reads the
 * scene: the program changes the scene for this frame. It may call the functions that only ask the engine something.
 * [main-thread] */
typedef void stilb_engine_update_fn(void *user, const stilb_engine_update *update);

/* A picture of stilb_engine_picture that has been written, or could not be. */
typedef struct stilb_engine_pictured {
	const char *path; /* as it was given; valid during the call, as is message */
	stilb_result result;
	const char *message; /* the line for the user; "" if it was written */
} stilb_engine_pictured;

/* Called between two frames, or while the program waits for pictures; it may call the engine's other functions, but
 * neither wait for pictures nor destroy the engine. [main-thread] */
typedef void stilb_engine_pictured_fn(void *user, const stilb_engine_pictured *pictured);

/* A choice of the program's own, which the materials' window lists below the models. The user changes chosen in frames'
 * stage ui; the program reads it in update. */
typedef struct stilb_engine_choice {
	const char *heading;
	const char *const *names; /* [count], count >= 1 */
	uint32_t count, chosen;   /* chosen: an index into names */
	uint32_t initial;         /* what the window's button Default chooses */
} stilb_engine_choice;

/* When the textures of a scene are there. LATER: frames show a texture's mean color until it is. In a window they spend
 * some milliseconds each on what is left; headless each does as much of it as any other, so that its picture depends on
 * its number alone. Once all are there, pictures are those of WAIT, bit for bit. A texture that is edited on its way
 * begins anew; edits of others are there with the next frame, as always. */
typedef enum stilb_engine_textures {
	STILB_ENGINE_TEXTURES_AUTO, /* LATER in a window, the engine's or the program's; WAIT headless */
	STILB_ENGINE_TEXTURES_WAIT, /* stilb_engine_set_scene makes and copies them all */
	STILB_ENGINE_TEXTURES_LATER,
} stilb_engine_textures;

/* How lights are kept from surfaces by others in front of them. */
#define STILB_ENGINE_SHADOW_KINDS(X)                                                                                   \
	X(OFF, "off", "every light shines through everything")                                                             \
	X(MAP, "map", "what a light sees is drawn into maps, by which surfaces are lit")                                   \
	X(BUFFER, "buffer", "maps, read into an image of each light's shares before surfaces are lit")

#define STILB_ENGINE_SHADOW_ENUM(id, ...) STILB_ENGINE_SHADOWS_##id,
typedef enum stilb_engine_shadow_kind {
	STILB_ENGINE_SHADOW_KINDS(STILB_ENGINE_SHADOW_ENUM) STILB_ENGINE_SHADOWS_COUNT
} stilb_engine_shadow_kind;
#undef STILB_ENGINE_SHADOW_ENUM

/* Their identifiers, NULL-terminated; the index is the stilb_engine_shadow_kind. */
extern const char *const stilb_engine_shadow_names[];

/* Which sides of triangles are drawn into shadow maps: X(identifier, name, what it does). Rays are stopped by both. */
#define STILB_ENGINE_SHADOW_FACES(X)                                                                                   \
	X(BOTH, "both", "all, as rays are stopped by either")                                                              \
	X(FRONT, "front", "those that the light sees: less to draw, and sheets cast from one side alone")                  \
	X(BACK, "back", "those that the light does not see: closed things cast from behind, and cannot shade their fronts")

#define STILB_ENGINE_SHADOW_FACES_ENUM(id, ...) STILB_ENGINE_SHADOW_FACES_##id,
typedef enum stilb_engine_shadow_faces {
	STILB_ENGINE_SHADOW_FACES(STILB_ENGINE_SHADOW_FACES_ENUM) STILB_ENGINE_SHADOW_FACES_COUNT
} stilb_engine_shadow_faces;
#undef STILB_ENGINE_SHADOW_FACES_ENUM

/* Their identifiers, NULL-terminated; the index is the stilb_engine_shadow_faces. */
extern const char *const stilb_engine_shadow_faces_names[];

/* What keeps surfaces from shading themselves: X(identifier, name, what it does). ALL is what each of the others is a
 * part of; these are there to see what for. */
#define STILB_ENGINE_SHADOW_BIASES(X)                                                                                  \
	X(ALL, "all", "slope, plane and way")                                                                              \
	X(SLOPE, "slope", "maps are drawn as much farther from the light as depth changes by from a texel to the next")    \
	X(PLANE, "plane", "texels are compared with the plane of the point, not with its depth")                           \
	X(WAY, "way", "points are moved towards the light, by a part of the filter's width")                               \
	X(NONE, "none", "nothing")

#define STILB_ENGINE_SHADOW_BIAS_ENUM(id, ...) STILB_ENGINE_SHADOW_BIAS_##id,
typedef enum stilb_engine_shadow_bias {
	STILB_ENGINE_SHADOW_BIASES(STILB_ENGINE_SHADOW_BIAS_ENUM) STILB_ENGINE_SHADOW_BIAS_COUNT
} stilb_engine_shadow_bias;
#undef STILB_ENGINE_SHADOW_BIAS_ENUM

/* Their identifiers, NULL-terminated; the index is the stilb_engine_shadow_bias. */
extern const char *const stilb_engine_shadow_bias_names[];

/* How maps are read: X(identifier, name, what it does). */
#define STILB_ENGINE_SHADOW_FILTERS(X)                                                                                 \
	X(GATHER, "gather", "all texels of a square, by a cosine's weights: 1, 4, 16 or 36")                               \
	X(COMPARE, "compare", "few comparisons, in a pattern that alternates from pixel to pixel: 1, 4 or 12")

#define STILB_ENGINE_SHADOW_FILTER_ENUM(id, ...) STILB_ENGINE_SHADOW_FILTER_##id,
typedef enum stilb_engine_shadow_filter {
	STILB_ENGINE_SHADOW_FILTERS(STILB_ENGINE_SHADOW_FILTER_ENUM) STILB_ENGINE_SHADOW_FILTER_COUNT
} stilb_engine_shadow_filter;
#undef STILB_ENGINE_SHADOW_FILTER_ENUM

/* Their identifiers, NULL-terminated; the index is the stilb_engine_shadow_filter. */
extern const char *const stilb_engine_shadow_filter_names[];

/* Shadows of frames. Not of rays: those have their own. */
typedef struct stilb_engine_shadows {
	/* BUFFER is of one sample a pixel: samples 0 is 1 then, and more are refused. In frames in which more lights cast
	 * shadows than it holds (STILB_RENDER_SHADOW_BUFFER_LIGHTS) maps are read, which a line says once. */
	stilb_engine_shadow_kind kind;
	uint32_t cascades; /* maps of each directional light, 1..8; 0: 4, on a software device 2 */
	uint32_t size;     /* texels of such a map's side, and the most of a lamp's: a power of two, 64..8192; 0: 2048, on a
	                      software device 1024 */
	/* A directional light has one map, around models within `distance`, which must be above 0, whose radius is at most
	 * a quarter of it: finer than cascades, as long as little is near. What lies outside of it casts no shadow.
	 * cascades is not read. */
	bool objects;
	float distance; /* of directional lights: metres from the camera where shadows have faded out, >= 0; 0: nowhere */
	stilb_engine_shadow_faces faces;
	/* Texels of a map that a pixel asks: 1, 4, 16, 36; with COMPARE comparisons, of four texels each: 1, 4, 12. 0: 16,
	 * or 12 comparisons. */
	uint32_t samples;
	stilb_engine_shadow_bias bias;
	stilb_engine_shadow_filter filter;
} stilb_engine_shadows;

typedef struct stilb_engine_desc {
	uint32_t workers;       /* threads besides the main thread, 0..STILB_JOB_MAX_WORKERS */
	stilb_cull_method cull; /* how visible models are found */

	stilb_engine_update_fn *update;     /* NULL: none */
	stilb_engine_pictured_fn *pictured; /* is told how each stilb_engine_picture went; NULL: nobody is */
	void *user;                         /* passed to update and pictured */
	stilb_engine_choice *choice;        /* the program's, valid as long as the engine; NULL: none */

	/* The device and how it draws, see stilb_render_desc; shading may change between frames. */
	stilb_render_device_kind device;
	stilb_render_replay_mode replay;
	stilb_render_materials materials;
	stilb_render_output output;
	stilb_render_shading shading;
	stilb_render_detail detail; /* which levels of meshes are drawn; {0}: every mesh in full */
	/* How pixels find their lights, at first. Of ways of one sample a pixel samples 0 is 1; with 4 frames are lit as
	 * AUTO lights them. */
	stilb_render_lighting lighting;
	stilb_render_deferred deferred;       /* see stilb_render_view */
	stilb_render_light_lists light_lists; /* see stilb_render_view */
	float light_tolerance;                /* see stilb_render_view, at first; 0..1 */
	float light_fade;                     /* likewise, for all frames; pixels, >= 0 */
	stilb_render_ambient ambient;         /* what lights in place of the surroundings, at first */
	stilb_engine_shadows shadows;         /* {0}: none, as by default; `stilb demo` and `stilb view` ask for MAP */
	stilb_post_settings post;             /* effects on the light of frames, at first; {0}: none */
	stilb_render_hdr hdr;                 /* what passes keep light in, as far as frames allow it (stilb_render_hdr) */
	stilb_render_show show;               /* what pictures show at first */
	bool velocity; /* frames have the image "velocity" (gpu_plan.h finds it): where each pixel was in the frame before.
	                  They also have it while they show it (stilb_engine_show_image) */
	bool surfaces; /* likewise besides it "surface normal" and "id": the normal and the model that each pixel shows */
	/* Likewise "ambient" and "reflection": the surroundings' light apart from all other (stilb_render_view). With
	 * samples 0 there is one; more are refused. */
	bool ambient_apart;

	/* All strings are the caller's and live until the engine is destroyed. */
	const char *gpu;         /* a number or a part of a name as `stilb info` prints them; NULL: the best */
	uint32_t width, height;  /* of the picture, pixels, 1..16384 */
	uint32_t samples;        /* of multisampling: 1, 4, or 0 for the device's own choice */
	uint32_t max_anisotropy; /* stilb_render_desc.max_anisotropy */
	stilb_render_specular_aa specular_aa;
	stilb_engine_textures textures;
	/* The scene is drawn in so many times the picture's width and height, and filtered linearly: STILB_ENGINE_MIN_SCALE
	 * .. STILB_ENGINE_MAX_SCALE; 0: 1. Windows over it, and text, are always as fine as the picture. */
	float scale;
	bool window;  /* true: in a window of the engine's; false: to `surface`, or headless, to memory */
	bool present; /* false: pictures are drawn, but not shown in the window */
	/* A window of the program's own, if `window` is false; NULL: none. Needed only during stilb_engine_create; the
	 * window lives until the engine is destroyed or stilb_engine_set_surface takes another one. The program handles its
	 * events and tells its size by stilb_engine_resize. */
	const stilb_gpu_surface *surface;
	stilb_gpu_presentation presentation; /* how pictures get to the screen */
	bool validate;                       /* with Vulkan's validation layer */
	bool keep_textures; /* keep a copy of all textures in memory: stilb_engine_dump of a scene with textures needs it */
	bool overlay;       /* the profiler's window is open from the start */
	bool inspector;     /* the materials' window is open from the start */
	bool clips;         /* the animation's window is open from the start */
	bool lights;        /* the lights' window is open from the start */
	bool effects;       /* likewise, the effects' window */
	bool keys;          /* the key card is open from the start */
	bool times;         /* frame rate and time are shown from the start */
	bool hint;          /* a line names the main keys for the first seconds; only in a window */
	stilb_ui_aa ui_aa;  /* how edges in these two windows are smoothed */

	/* Record what every thread does, for the overlay and for files. Each thread keeps its last profile_ring_mib MiB of
	 * records, a power of two, 1..STILB_ENGINE_PROFILE_RING_MAX; memory is taken as it is used. */
	bool profile;
	uint32_t profile_ring_mib;
	stilb_prof_capture_desc capture; /* files of the frames around a moment; path NULL: none */

	stilb_engine_gamepad gamepad;
	const char *gamepad_recording;         /* for REPLAY: the file, see input_recording.h */
	const char *gamepad_sys, *gamepad_dev; /* folders to look in for gamepads, for tests; NULL: /sys and /dev */
	stilb_input_control_settings control;  /* how gamepads and keys move the camera; but its table is the engine's */

	/* For work on shaders: when a GLSL file, or one that it includes, is written, a thread of the engine's compiles it
	 * with glslc, and frames go on with the new shader; or with the old one, if it is wrong: then a panel in the window
	 * shows what glslc says, and stilb_log has all of it. Which shaders: the engine's own, and those of programs with
	 * stilb_gpu_shader.source, a file below `shaders` or with its whole path, and behind it " -DNAME" for
	 * definitions. */
	stilb_engine_watch watch_shaders;
	const char *shaders; /* the folder `engine` of Stilb's sources; NULL: where Stilb was built */

	const stilb_input_action *actions; /* [action_count] the program's rows of the table; copied, but for the strings */
	uint32_t action_count;
	/* The program does what STILB_ENGINE_CAPTURE and _PICTURE ask for; false: they have no keys. */
	bool saves;
} stilb_engine_desc;

#define STILB_ENGINE_PROFILE_RING_MAX 1024u
#define STILB_ENGINE_MIN_SCALE 0.1f
#define STILB_ENGINE_MAX_SCALE 4.0f

/* CPUs - 1 workers (at least 1), automatic culling, Vulkan, indirect draws, 1280 x 720, headless; profiled with rings
 * of 64 MiB, no captures; gamepads AUTO. [any-thread] */
stilb_engine_desc stilb_engine_desc_default(void);

/* The default number of workers. [any-thread] */
uint32_t stilb_engine_default_workers(void);

/* The table of actions that an engine of this description has: the camera's rows, the engine's and the program's.
 * STILB_ERROR_ARGUMENT: a row of the program's cannot be added (stilb_input_table_add). [any-thread] */
stilb_result stilb_engine_table(const stilb_engine_desc *desc, stilb_input_table *table);

/* Creates the engine and its workers, and opens the window; there is no scene yet. On failure *engine is NULL.
 * STILB_ERROR_ARGUMENT: profile_ring_mib is no power of two in its range, STILB_ISA is wrong, or two actions have the
 * same key or another fault (stilb_input_table_add).
 * STILB_ERROR_WINDOW: no window can be opened here; headless works.
 * STILB_ERROR_DEVICE: no usable GPU, or none that desc.gpu names.
 * STILB_ERROR_FILE: the recording cannot be read, or captures cannot be written.
 * STILB_ERROR_THREAD: too many workers. STILB_ERROR_MEMORY. */
stilb_result stilb_engine_create(const stilb_engine_desc *desc, stilb_engine **engine);

/* Ends captures, waits for the device and for pictures that are being written, and frees everything. NULL is
 * accepted. */
void stilb_engine_destroy(stilb_engine *engine);

/* Shows this scene from the next frame on, in place of the one before, and copies its meshes, materials and textures
 * to the device. The program owns the scene; it must live until another one is set or the engine is destroyed. Between
 * frames, and in desc.update, the program may change it: what it consists of with scene_edit.h; lights, surroundings
 * and camera are members of the scene, which it assigns. One engine at a time shows a scene. NULL: no scene. On failure
 * the scene before stays. STILB_ERROR_ARGUMENT: a mesh has no triangles, or an index beyond its vertices.
 * STILB_ERROR_DEVICE: a texture is too large for this GPU. STILB_ERROR_MEMORY. */
stilb_result stilb_engine_set_scene(stilb_engine *engine, stilb_scene *scene);

/* Makes a scene ready for stilb_engine_set_scene beside the frames, which go on with the scene that is shown: a thread
 * of the engine's makes what is needed, pipelines included, and each frame copies some 16 MiB of it to the device;
 * textures that come later are made when it is set. The scene may not change until it is set, another one is given, or
 * this returns from NULL, which gives it up. May be set at any time: set_scene then makes haste with what is left. An
 * error of the scene's is set_scene's to return. STILB_ERROR_MEMORY, STILB_ERROR_THREAD. */
stilb_result stilb_engine_prepare(stilb_engine *engine, stilb_scene *scene);

/* A camera beside the scene's own, culled, recorded and drawn in the same frames, into an image of its own of linear
 * radiance, which the frame's plan has under its name (render.h, targets). */
typedef struct stilb_engine_camera {
	const char *name; /* 1..STILB_RENDER_TARGET_NAME bytes, no other image's; copied */
	stilb_scene_camera camera;
	/* Left, top, right and bottom of the part of the picture that shows it, as shares of the picture's sides, 0..1,
	 * over what cameras before it show; all 0: none does, and the image is an output of the plan
	 * (stilb_gpu_read_begin). */
	float place[4];
	uint8_t border;         /* pixels at the edges of its place that are black */
	uint32_t width, height; /* of its image, pixels, 0..16384; 0: those of its place, times desc.scale */
} stilb_engine_camera;

#define STILB_ENGINE_MAX_CAMERAS 15u

/* From the next frame on, or with this one in desc.update, these are drawn in place of those of the call before;
 * stilb_engine_pick asks them at once. While the program's picture hides a still scene, none is drawn. */
void stilb_engine_set_cameras(stilb_engine *engine, const stilb_engine_camera *cameras, uint32_t count);

/* Likewise the part of the picture that the scene's own camera fills, as in stilb_engine_camera; at first 0, 0, 1, 1:
 * all of it. What no camera covers is black. */
void stilb_engine_set_place(stilb_engine *engine, const float place[4]);

/* Likewise desc.scale, not 0. */
void stilb_engine_set_scale(stilb_engine *engine, float scale);

/* The share of the prepared scene that is on the device, below 1 until it is ready; 1: set_scene does not wait, for it
 * is ready, has an error, or there is none. Frames must be drawn meanwhile. */
float stilb_engine_prepared(const stilb_engine *engine);

/* The scene that was set, or NULL. */
stilb_scene *stilb_engine_scene(const stilb_engine *engine);

/* The time of a frame, milliseconds:
 *   frame                the main thread's time for all of it
 *   update .. present    its stages, see frame.c
 *   gpu                  the device's own measure of a frame some two frames earlier; 0: none is known
 *   pad                  the age of the newest gamepad report when the frame's draws were handed to the device; 0 if
 *                        none came since the last frame, and in replays */
typedef struct stilb_engine_times {
	double frame, update, cull, record, ui, replay, present, gpu, pad;
} stilb_engine_times;

/* The result of a frame. */
typedef struct stilb_engine_report {
	uint64_t frame; /* frames drawn so far, this one included */
	stilb_engine_times times;
	uint32_t textures_left; /* of the scene: not yet there (stilb_engine_textures) */
	uint32_t visible;       /* number of models that the scene's own camera sees; render.draws are of all cameras */
	float exposure;         /* stops that the scene's own camera shows light with: its own, and what adapts */
	stilb_cull_method cull; /* the method by which they were found; never AUTO */
	stilb_render_stats render;
	uint32_t shadow_maps, shadow_maps_drawn; /* of the frame; those of them that nothing had drawn before as they are */
	uint32_t shadow_lights_left;  /* lights that are seen and cast no shadow: there is no room for their maps */
	uint32_t shadow_lights_faded; /* likewise, for their reach has 16 pixels or fewer; up to 32 their shadows fade */
	uint32_t shadow_lights_drawn; /* the lights of these: a lamp's six maps count as one */
	/* With STILB_RENDER_SHOW_LIGHTS: of this frame, in a window of one or two before; {0}: not known */
	stilb_render_light_counts light_counts;
	stilb_render_error light_error; /* likewise with STILB_RENDER_SHOW_ERROR */
	stilb_input_state input;        /* {0} without a window and gamepads */
	int64_t time_us; /* the camera's time, microseconds: since the start if headless, since a recording's begin in its
	                    replay, else CLOCK_MONOTONIC */
	bool replayed;   /* the gamepads' recording has ended */
	bool close;      /* the user closed the window */
	/* The left button was pressed and let go in the same place, outside of the engine's windows: pixels from the
	 * picture's upper left corner, as stilb_engine_pick takes them. */
	bool clicked;
	float click_x, click_y;
	const char *const *dropped; /* [dropped_count] paths of files that the user dropped onto the window meanwhile; */
	uint32_t dropped_count;     /* valid until the next frame */
	bool lost;  /* the window or its display has gone, the engine's or the program's: frames are drawn to memory, in the
	               last size. The program's: until stilb_engine_set_surface gives another one. The engine's: a surface
	               that is lost while the window lives is made anew, at once if that is possible, and `lost` says so
	               only after a second in vain; a display that has gone does not come back in this process */
	bool drawn; /* false: the window is minimised, and only input was handled */
	bool ui_keys, ui_mouse; /* the engine's panels took the keys, the mouse: they are for nobody else */
	bool saves_look;        /* the user asks for the effects in a file (stilb_post_preset_save); with desc.saves */
} stilb_engine_report;

/* How fast the clips of the scene play (scene_play.h), in a window and headless: their seconds in one of the engine's.
 * 1 at first; 0: all stand still; below 0: backwards. Finite. */
void stilb_engine_set_pace(stilb_engine *engine, float pace);
float stilb_engine_pace(const stilb_engine *engine);

/* Moves all clips on by seconds, finite, below 0: back, in the next frame, besides what the pace does. */
void stilb_engine_step(stilb_engine *engine, double seconds);

/* Runs one frame and fills *report. While the window is minimised it waits up to 50 ms and draws nothing.
 * STILB_ERROR_MEMORY, STILB_ERROR_DEVICE, STILB_ERROR_DEVICE_LOST. */
stilb_result stilb_engine_frame(stilb_engine *engine, stilb_engine_report *report);

/* Gives the next frame what happened in the program's own window since the frame before: keys, mouse and the wish to
 * close, as stilb_window_poll gives them, so that the camera, the table of actions, the profiler's and the materials'
 * window and report.input work as in a window of the engine's. Call it before each frame, without a window too, where
 * tests may give keys. *state is copied; the files in `dropped` live until the frame has returned. Without another
 * call what is held stays held, and nothing is pressed or moved. width and height are the picture's new size; 0: as it
 * is. lost, and gamepads, are not read from it: desc.gamepad chooses their source. The program captures and shows the
 * pointer itself. Not in a window of the engine's. STILB_ERROR_MEMORY; then nothing is given. */
stilb_result stilb_engine_input(stilb_engine *engine, const stilb_window_state *state);

/* Waits until the device has drawn every frame; *gpu_ms is the last frame's time on it, milliseconds, 0 if unknown.
 * STILB_ERROR_DEVICE_LOST. */
stilb_result stilb_engine_wait(stilb_engine *engine, double *gpu_ms);

/* Sets the number of workers from the next frame on, 0..STILB_JOB_MAX_WORKERS. STILB_ERROR_THREAD, STILB_ERROR_MEMORY:
 * after an error only stilb_engine_destroy may follow. */
stilb_result stilb_engine_set_workers(stilb_engine *engine, uint32_t workers);

/* The number of workers. */
uint32_t stilb_engine_workers(const stilb_engine *engine);

/* What the workers and the engine's thread have done since the workers were started. */
stilb_job_pool_stats stilb_engine_job_stats(const stilb_engine *engine);

/* The hash of the last frame's command stream (render.h): equal for every number of workers. */
uint64_t stilb_engine_stream_hash(const stilb_engine *engine);

/* Triangles of the last frame, those of shadow maps included; reads all of its commands. */
uint64_t stilb_engine_triangles(const stilb_engine *engine);

/* Writes the last frame's picture as .png, or the radiance of the scene's own camera, in the size that it was drawn in,
 * without windows and other cameras over it, as .exr or .hdr. Fails as
 * stilb_render_read_image and stilb_image_save do. */
stilb_result stilb_engine_screenshot(stilb_engine *engine, const char *path);

/* As stilb_engine_screenshot, but only reads the picture back; a thread of the engine's encodes and writes it, and
 * desc.pictured is told how that went. If four pictures are pending, it waits for one. created: there is an empty file
 * of this name, which the caller has created so that nobody else takes it (O_EXCL); it is removed if no picture
 * replaces it. Fails as stilb_render_read_image; STILB_ERROR_MEMORY. */
stilb_result stilb_engine_picture(stilb_engine *engine, const char *path, bool created);

/* A picture of any size, of the moment that the last frame showed. */
typedef struct stilb_engine_photo {
	const char *path;       /* .png, or .exr and .hdr, radiance as of stilb_engine_screenshot */
	uint32_t width, height; /* pixels, 1..STILB_ENGINE_PHOTO_SIDE */
	/* The side of tiles without what is drawn around them, pixels, a multiple of STILB_ENGINE_PHOTO_STEP up to 8192; 0:
	 * 1024. */
	uint32_t tile;
} stilb_engine_photo;

#define STILB_ENGINE_PHOTO_SIDE 65536u
#define STILB_ENGINE_PHOTO_STEP 64u

/* What keeps a photo from being taken by tiles, as a part of a sentence: an effect that looks at all of the picture.
 * NULL: nothing does. */
const char *stilb_engine_photo_whole(const stilb_engine *engine);

/* Draws the scene's own camera again, without windows and other cameras over it, and writes the picture: by tiles, each
 * with what lies around it as far as effects reach, so that the pixels are those of a picture in one piece
 * (engine/photo/engine_photo.c tells where they round otherwise); with stilb_engine_photo_whole in one piece of up to
 * 16384 pixels a side. Time stands still, and the exposure stays. Temporal antialiasing takes 64 frames a tile; nothing
 * is blurred by its movement. STILB_ERROR_ARGUMENT: no frame of a scene has been drawn, the program's picture is shown
 * (stilb_engine_show), or the picture is larger than its one piece, or than 4 GiB. STILB_ERROR_MEMORY,
 * STILB_ERROR_DEVICE, STILB_ERROR_FILE: the next frame is as after a photo. STILB_ERROR_DEVICE_LOST. After a photo
 * temporal antialiasing begins anew, and a paused step has no motion blur. Features of the program's own may look 64
 * pixels around a pixel; what they find beyond is cut at tiles. */
stilb_result stilb_engine_photo_take(stilb_engine *engine, const stilb_engine_photo *photo);

/* Waits until all pictures of stilb_engine_picture are written and desc.pictured has been told of them; so does
 * stilb_engine_destroy. */
void stilb_engine_pictures_wait(stilb_engine *engine);

/* Writes the last frame's command stream for `stilb replay` (render_dump.h), with the lights that the scene has now.
 * STILB_ERROR_ARGUMENT: no frame of this scene has been drawn, or a draw uses a texture and the engine was created
 * without keep_textures. STILB_ERROR_FILE. */
stilb_result stilb_engine_dump(stilb_engine *engine, const char *path);

/* Writes the plan of the last frame (gpu_plan.h), its passes, images, barriers and memory: as a drawing if the name
 * ends in .svg, else as text. STILB_ERROR_ARGUMENT: no frame has been drawn. STILB_ERROR_FILE, STILB_ERROR_MEMORY. */
stilb_result stilb_engine_save_plan(stilb_engine *engine, const char *path);

/* Adds rows of the program's own to each frame's plan, and removes those with this user; what stilb_render_add_feature
 * says, but with STILB_ENGINE_MAX_FEATURES as the limit: the engine's own effects and lines take the rest. The device
 * for programs, buffers and images of its own, which are destroyed before the engine; and the plan of the last frame,
 * for stilb_gpu_read_begin. */
#define STILB_ENGINE_MAX_FEATURES (STILB_RENDER_MAX_FEATURES - 5u)
stilb_result stilb_engine_add_feature(stilb_engine *engine, const stilb_render_feature *feature);
void stilb_engine_remove_feature(stilb_engine *engine, const void *user);
stilb_gpu *stilb_engine_gpu(stilb_engine *engine);
/* Frames show an image of the plan in the place of the picture; what stilb_render_show_image says. */
void stilb_engine_show_image(stilb_engine *engine, const stilb_render_shown *shown);
/* True of images that only frames with one sample a pixel have, while they show them: of stilb_engine_desc.
 * ambient_apart. [any-thread] */
bool stilb_engine_image_is_of_one_sample(const char *name);
const stilb_gpu_plan *stilb_engine_plan(const stilb_engine *engine);

/* Draws lines, shapes and text in the scene's world, from any thread; see debug_draw.h. What desc.update and its jobs
 * draw is seen in that frame. Valid as long as the engine. [any-thread] */
stilb_debug *stilb_engine_debug(const stilb_engine *engine);

/* Writes the newest frames that the profiler still holds, at most last_frames (0: all), as a trace; the name's ending
 * chooses the format (prof_trace.h). STILB_ERROR_FILE: also without memory. */
stilb_result stilb_engine_trace(stilb_engine *engine, const char *path, uint32_t last_frames);

/* Requests a trace of the frames around this moment, as desc.capture describes; a gamepad whose button asked for it in
 * the last frame rumbles. STILB_ERROR_ARGUMENT: the profiler is off or captures are. */
stilb_result stilb_engine_capture(stilb_engine *engine);

/* Shows a line of UTF-8 text, of which it copies 255 bytes at most, at the lower edge of the window for five seconds;
 * the newest three are shown. A frame whose input has STILB_ENGINE_PICTURE set is drawn without them. It does nothing
 * without a window of the engine's and without stilb_engine_input. */
void stilb_engine_tell(stilb_engine *engine, const char *text);

/* Shows a picture of the program's from the next frame on, or in this frame if desc.update calls it; with the exposure
 * and the tone map that frames have, and as it is with output LINEAR. The scene must be set. NULL: the scene alone
 * again, and its memory is freed. While `still` holds, frames cost little more than copying the picture. After an error
 * the scene is shown. STILB_ERROR_MEMORY, STILB_ERROR_DEVICE. */
stilb_result stilb_engine_show(stilb_engine *engine, const stilb_engine_shown *picture);

/* Shows a line of UTF-8 text, of which it copies 127 bytes at most, in the upper right corner of the window until
 * another one or NULL is given. A frame of which a picture is asked for is drawn without it. Without a window of the
 * engine's it does nothing. */
void stilb_engine_caption(stilb_engine *engine, const char *text);

/* The pool of the workers, which a program may use between frames and, from other threads as STILB_JOB_OUTSIDE, at any
 * time; frames need it 60 times a second, so jobs should be short. stilb_engine_set_workers replaces it: all jobs must
 * have ended before. */
stilb_job_pool *stilb_engine_pool(const stilb_engine *engine);

/* The device: its name for the user, true if it is a software rasteriser, the samples per pixel that it draws with, and
 * the number of validation messages so far. The name is valid until the engine is destroyed. */
const char *stilb_engine_device_name(const stilb_engine *engine);
bool stilb_engine_device_is_software(const stilb_engine *engine);
uint32_t stilb_engine_samples(const stilb_engine *engine);
uint32_t stilb_engine_validation_messages(const stilb_engine *engine);

/* desc.shadows, with what this kind of device has in place of zeros. */
stilb_engine_shadows stilb_engine_shadows_used(const stilb_engine *engine);

/* Finds what the scene's camera sees at a point of the picture, pixels from its top left corner; the first pixel's
 * centre is (0.5, 0.5). On the CPU, in the scene as it is now, with an index of large meshes; scene_pick.h says what
 * that costs. False: nothing is there, and *hit is as before. */
bool stilb_engine_pick(stilb_engine *engine, double x, double y, stilb_engine_hit *hit);

/* How pictures get to the screen: desc.presentation, or FIFO if the window does not offer that. */
stilb_gpu_presentation stilb_engine_presentation(const stilb_engine *engine);

/* The picture's size, pixels; in a window of the engine's it follows that. */
void stilb_engine_size(const stilb_engine *engine, uint32_t *width, uint32_t *height);

/* Sets the picture's size, 1..16384 pixels a side, from the next frame on; not in a window of the engine's.
 * STILB_ERROR_MEMORY, STILB_ERROR_DEVICE (larger than this GPU draws): no frame can be drawn until a resize
 * succeeds. */
stilb_result stilb_engine_resize(stilb_engine *engine, uint32_t width, uint32_t height);

/* Shows frames from the next one on in this window of the program's, in place of the one before, which may be lost,
 * have been closed or be the same; NULL: draws them to memory. Scene, camera and everything else stay. Who closes a
 * window and opens another one later gives NULL before; if desc.surface was a window that has gone by itself, the new
 * one may be given at once. The size is the program's to tell, as ever (stilb_engine_resize). Only if desc.surface was
 * given; needed only during the call, from the thread of the frames, between frames. STILB_ERROR_WINDOW: the engine was
 * created without a surface, or this GPU cannot draw to this window. STILB_ERROR_MEMORY, STILB_ERROR_DEVICE: the window
 * cannot be used now. After these frames are drawn to memory, and the call may be made again.
 * STILB_ERROR_DEVICE_LOST. */
stilb_result stilb_engine_set_surface(stilb_engine *engine, const stilb_gpu_surface *surface);

/* Sets the window's title, UTF-8; does nothing without a window. */
void stilb_engine_set_title(stilb_engine *engine, const char *title);

/* A library that is loaded, and its version; both are static strings. */
typedef struct stilb_engine_library {
	const char *name, *version;
} stilb_engine_library;

/* Fills libraries and returns how many there are, STILB_ENGINE_LIBRARIES at most. [any-thread] */
#define STILB_ENGINE_LIBRARIES 2
uint32_t stilb_engine_libraries(stilb_engine_library libraries[STILB_ENGINE_LIBRARIES]);

/* How the next frame is shaded. The user changes it in the materials' window, the program by the second function. In a
 * window, formulas that this device has not used yet are compiled beside the frames, which show those before until
 * then. */
stilb_render_shading stilb_engine_shading(const stilb_engine *engine);
void stilb_engine_set_shading(stilb_engine *engine, const stilb_render_shading *shading);

/* What the next frame shows. The user changes it by keys, the program by the second function. What this device has not
 * shown yet is compiled in that frame. */
stilb_render_show stilb_engine_shows(const stilb_engine *engine);
void stilb_engine_set_shows(stilb_engine *engine, stilb_render_show show);

/* How pixels find their lights from the next frame on; likewise, but in a window new ways are compiled beside the
 * frames, as new formulas of shading are. */
stilb_render_lighting stilb_engine_lighting(const stilb_engine *engine);
void stilb_engine_set_lighting(stilb_engine *engine, stilb_render_lighting lighting);

/* What lights that are left out of a pixel may send, a share of display white, 0..1: see
 * stilb_render_view.light_tolerance. */
float stilb_engine_light_tolerance(const stilb_engine *engine);
void stilb_engine_set_light_tolerance(stilb_engine *engine, float tolerance);

/* Likewise what lights surfaces in place of the surroundings. [main-thread] */
stilb_render_ambient stilb_engine_ambient(const stilb_engine *engine);
void stilb_engine_set_ambient(stilb_engine *engine, stilb_render_ambient ambient);

/* The effects on the light of frames from the next one on. Settings are valid (post.h). Occlusion has one sample a
 * pixel, which desc.samples 0 gives if desc.post has it; an engine with several draws none, and a line says so.
 * Temporal antialiasing, too, gets one sample by desc.samples 0, and goes with several; frames then draw velocities and
 * models, as with desc.surfaces.
 * Pictures that files keep as radiance, dumps, and the program's picture (stilb_engine_picture) are without effects.
 * [main-thread] */
stilb_post_settings stilb_engine_post(const stilb_engine *engine);
void stilb_engine_set_post(stilb_engine *engine, const stilb_post_settings *settings);

/* Takes copies of a table of colours that frames look up after the tone map, NULL: none, and of areas with tables of
 * their own, where the scene's camera stands (post.h). Errors as stilb_post_set_grade. [main-thread] */
stilb_result stilb_engine_set_grade(stilb_engine *engine, const stilb_post_table *table, const stilb_post_area *areas,
                                    uint32_t area_count);

/* True while the window of lights is open, by which the user changes lights of the scene: who reads the scene on other
 * threads waits until it is closed. [main-thread] */
bool stilb_engine_lights_shown(const stilb_engine *engine);

/* To be called after another BRDF or normal distribution was chosen; *before is the shading before the choice. Wrapped
 * light and anisotropic GGX look different from the others only if materials have wrap or anisotropy: choosing one of
 * them sets the value added to all materials to wrap 0.5 or anisotropy 0.6 if it is 0, and choosing another model sets
 * it back to 0 if it still has that value.
 * [any-thread] */
void stilb_engine_shading_chosen(const stilb_render_shading *before, stilb_render_shading *shading);

/* The names of all models that stilb_render_shading can choose, one table for each choice; the index of a name is the
 * value of that choice's field there. NULL-terminated. */
extern const char *const stilb_engine_brdf_names[];
extern const char *const stilb_engine_ndf_names[];
extern const char *const stilb_engine_g_names[];
extern const char *const stilb_engine_f_names[];

/* Fills pads with the connected gamepads, including those without permission to open them; returns how many. Their
 * texts are valid until the next frame. */
uint32_t stilb_engine_gamepads(const stilb_engine *engine, stilb_input_control_pad pads[STILB_INPUT_PADS_MAX]);

/* Reports of all gamepads since the engine was created. */
typedef struct stilb_engine_gamepad_counts {
	uint64_t reports; /* reports that frames have taken */
	uint64_t corrupt; /* those of them that were refused: damaged, or too short */
	uint64_t lost;    /* reports that no frame could take: more came between two frames than the buffer holds */
} stilb_engine_gamepad_counts;

/* {0} without gamepads. */
stilb_engine_gamepad_counts stilb_engine_gamepad_counts_get(const stilb_engine *engine);

/* Sets how fast keys and gamepads fly, m/s, finite and >= 0, in place of desc.control.camera.speed; the camera stands
 * still for a moment. For scenes of different sizes. */
void stilb_engine_set_speed(stilb_engine *engine, float speed);

/* The position and direction of the scene's camera; {0} without a scene. */
stilb_input_pose stilb_engine_pose(const stilb_engine *engine);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#endif
