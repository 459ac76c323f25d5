/* The whole engine, for engine*.c and frame.c only. */
#ifndef STILB_ENGINE_INTERNAL_H
#define STILB_ENGINE_INTERNAL_H

#include "base/base_contract.h"
#include "engine.h"
#include "input/device/input_pads.h"
#include "input/input_recording.h"
#include "input/input_window.h"
#include "jobs/job.h"
#include "render/device/render_images.h"
#include "scene/scene_look.h"
#include "shadow/shadow.h"
#include "ui/ui.h"
#include "ui/ui_profiler.h"
#include "window/window.h"

#include <pthread.h>

#define ENGINE_MAX_SHADOWS 224u
#define ENGINE_MAX_VIEWS (17u + ENGINE_MAX_SHADOWS)

/* The materials' window, in which shading models are chosen; {0} at first. */
typedef struct engine_inspector {
	stilb_ui_rect place; /* its place in the picture; empty: it has not been drawn yet */
	bool beside;         /* the sliders are beside the lists instead of below */
	stilb_ui_list_state
		lists[5]; /* model (BRDF), the program's choice; of microfacets: normals D, shadowing G, Fresnel term F */
} engine_inspector;

/* The animation's window. */
typedef struct engine_clips {
	bool open;
	stilb_ui_rect place;
	stilb_ui_list_state list;
} engine_clips;

/* The lights' window. */
typedef struct engine_lights {
	bool open, solo; /* solo: frames show the picked light alone while the window is open */
	stilb_ui_rect place;
	stilb_ui_list_state list;
	uint32_t picked;           /* index of a light, or STILB_UI_NO_ROW */
	float seen[3];             /* its intensity as the window left it */
	float intensity, color[3]; /* of its brightest channel when it was picked; of that as 1 */
	float kelvin, reach;       /* of the sliders of temperature and place */
} engine_lights;

/* The effects' window. */
typedef struct engine_effects {
	bool open, without, changed; /* without: frames have none, so that both can be compared; changed: by the user */
	bool saves, save;            /* there is a button that saves them; it was pressed */
	stilb_ui_rect place;
	stilb_post_settings chosen;     /* by the user, if changed */
	stilb_post_settings kept, last; /* what the window shows; amounts of effects that are off, when they were on */
} engine_effects;

/* A panel, shown for a while, that names the gamepads that may not be opened and the udev rule that would permit it.
 * {0}: it is not shown. */
#define ENGINE_NOTICE_PADS 3u
#define ENGINE_NOTICE_FILE "/etc/udev/rules.d/70-stilb-pads.rules"
typedef struct engine_notice {
	struct {
		uint32_t pad;             /* its number, stilb_input_event.pad */
		char who[256], rule[512]; /* its name with ids and path; the udev rule for it */
	} pads[ENGINE_NOTICE_PADS];   /* [pad_count] in the order in which they came */
	uint32_t pad_count;
	float seconds; /* for which the panel is still shown */
} engine_notice;

/* Lines that say for a few seconds what has just been done. {0}: none is shown. */
#define ENGINE_TOASTS 3u
typedef struct engine_toast {
	char text[256];
	float seconds; /* for which it is still shown */
} engine_toast;
typedef struct engine_toasts {
	engine_toast lines[ENGINE_TOASTS]; /* [count], the oldest first */
	uint32_t count;
	bool hidden; /* in this frame, because its picture is saved; so are the first line and the times */
} engine_toasts;

/* The key card; {0} at first. */
typedef struct engine_keys {
	bool open;
	stilb_ui_rect place;      /* where it was drawn last */
	stilb_ui_list_state list; /* where its lines are scrolled to if they do not fit */
	float hint_seconds;       /* for which the line of main keys is still shown */
} engine_keys;

/* Frame rate and time, measured over half a second. {0} at first. */
typedef struct engine_rate {
	bool open;
	uint64_t since_ns;         /* clock at which what is being measured began; 0: not yet */
	uint32_t frames;           /* drawn since then */
	double sum_ms, longest_ms; /* of their times */
	float rate, ms, longest;   /* of the half second before: frames/s, mean, milliseconds; 0: not yet known */
} engine_rate;

/* The windows over the picture; {0} until one of them is opened for the first time. */
typedef struct engine_overlay {
	stilb_ui *ui; /* NULL: none has been open yet */
	stilb_ui_profiler *profiler;
	engine_inspector inspector;
	engine_clips clips;
	engine_lights lights;
	engine_effects effects;
	engine_notice notice;
	engine_toasts toasts;
	engine_keys keys;
	engine_rate rate;
	stilb_ui_input input; /* of this frame; {0} but for its size when headless */
	char *shader_error;   /* what a panel shows of shaders that could not be replaced; NULL: there is none */
	bool profiler_open, inspector_open;
	bool divider_open, caption_open; /* of the program's picture; hidden with the toasts */
	bool value_open;                 /* the pixel's value beside the pointer; hidden with the toasts */
	bool counts_open;                /* what colours of counted lights mean; likewise */
} engine_overlay;

/* The value of the pixel under the pointer. {0}: it is not shown. */
typedef struct engine_value {
	bool open;        /* the user wants it beside pictures of light, too */
	bool known;       /* value is that of a frame before */
	float value[3];   /* linear */
	uint64_t ticket;  /* of the image that is being read; 0: none is */
	uint32_t size[2]; /* of that image */
} engine_value;

/* What stilb_render_light_peak has said of the scene, shaded like that. {0}: nothing is known. */
typedef struct engine_peak {
	bool known;
	stilb_render_shading shading;
	float value;
} engine_peak;

/* What frames have counted, or measured of their error. */
typedef struct engine_counts {
	stilb_render_light_counts last;
	stilb_render_error error;
	stilb_render_show show;  /* what the image that is being read holds */
	float exposure;          /* likewise */
	uint64_t ticket, pixels; /* of the image that is being read; ticket 0: none is */
} engine_counts;

/* The program's picture in place of the scene. {0}: there is none. */
typedef struct engine_shown {
	bool shown, still; /* see stilb_engine_shown */
	bool hides_scene;  /* in this frame: nothing of the scene is seen, or what it looks like is known */
	float *from;
	stilb_image radiance;         /* F32_LINEAR, four channels */
	bool stale;                   /* the texture has not got these pixels yet */
	stilb_render_texture texture; /* of the radiance */
	stilb_render_texture scene;   /* what the still scene looks like; {0}: not known */
	uint32_t scene_size[2];       /* of that */
} engine_shown;

/* The input that moves the camera; {0}: there is none, as in a headless run without gamepads. */
typedef struct engine_input {
	stilb_input_control *control;
	stilb_input_pads *pads;           /* NULL: the kernel's gamepads are not read */
	stilb_input_recording *recording; /* NULL: none is replayed */
	stilb_input_window window;        /* the window library's gamepads */
	stilb_input_pose pose;            /* the pose that this module has set the camera to last */
	int64_t time_us;                  /* the time of the frame that set it, microseconds */
	bool focused;                     /* the window has the keyboard */
	bool pad_captures;                /* in the last frame a gamepad's button, not a key, asked for a capture */
	bool replayed;                    /* the recording has ended */
	int64_t start_us;                 /* clock at which a replay in a window began; 0: not yet */
	int64_t newest_us;                /* time of this frame's newest report; 0: none came since the last frame */
	uint64_t reports, corrupt;        /* see stilb_engine_gamepad_counts; corrupt: only of pads that were removed */
	bool is_given;                    /* stilb_engine_input was called */
	stilb_window_state given;         /* by it, for the next frame */
} engine_input;

/* Pictures that are written by a thread of their own. */
typedef struct engine_pictures engine_pictures;
#define ENGINE_PICTURES 4u /* that wait or are being written, at most */

/* What a thread makes ready beside the frames. */
typedef struct engine_prepare engine_prepare;

/* What frames are compiled for, and the user changes while they go on. */
typedef struct engine_formulas {
	stilb_render_shading shading;
	stilb_render_lighting lighting;
	bool error; /* STILB_RENDER_SHOW_ERROR is shown: programs of the reference are needed, too */
} engine_formulas;

/* A press of the left button that may become a click; {0}: there is none. */
typedef struct engine_press {
	bool still; /* the pointer is where it was pressed */
	float x, y; /* pixels */
} engine_press;

/* A surface that is shown in. {0}: it is not lost. */
typedef struct engine_surface {
	bool lost;         /* and there is no other yet: pictures are copied to memory */
	uint64_t since_ns; /* the clock when it was lost */
	uint64_t tried_ns; /* the clock when another one was tried last; 0: not yet */
} engine_surface;

/* A camera of stilb_engine_set_cameras. */
typedef struct engine_camera {
	stilb_engine_camera asked; /* but for its name */
	char name[STILB_RENDER_TARGET_NAME + 1];
} engine_camera;

/* How a view saw the frame before. */
typedef struct engine_last {
	bool known;
	char name[STILB_RENDER_TARGET_NAME + 1]; /* of its camera; "": the scene's own */
	stilb_mat4 view_projection;
} engine_last;

/* The part of a larger picture that frames show, pixels. {0}: all of their own. */
typedef struct engine_part {
	uint32_t width, height; /* of the larger picture */
	uint32_t left, top;     /* of the part, which is as large as frames are */
} engine_part;

/* The shadow maps of a frame; {0} at first. */
typedef struct engine_shadows {
	stilb_sphere bounds; /* of what is drawn, and some room */
	stilb_shadow_plan plan;
	stilb_render_target target;
	stilb_render_shadows shadows;
	stilb_render_shadow_map *maps;
	stilb_render_shadow *lights;
	bool told, told_cameras; /* that lights have none; what cameras beside see */
	bool told_buffer;        /* that lights are too many for the buffer */
	uint32_t room;           /* texels of maps' sides at most, as memory has no room for more; 0: none was short */
	/* What the maps of the frame before show: of the scene as it was then. */
	bool valid, loading;
	uint64_t impostors_removed;
	uint32_t impostor_count;
	const stilb_scene *scene;
	stilb_scene_revisions revisions;
	stilb_render_detail detail;
	stilb_shadow_map *kept; /* [kept_count] what is in the image */
	uint32_t kept_count;
	bool *stays;                            /* by map of the plan: it need not be drawn */
	stilb_sphere *models;                   /* by model: its bounds in the frame before */
	uint32_t drawn;                         /* maps, in this frame */
	uint32_t lights_drawn;                  /* lights of these */
	uint32_t first_view;                    /* of those of the maps that are drawn */
	uint32_t view_maps[ENGINE_MAX_SHADOWS]; /* [drawn] which map of the plan each of their views draws */
} engine_shadows;

/* How the clips of the scene play. */
typedef struct engine_playing {
	double seconds;    /* the engine's time up to which they have played */
	double step;       /* seconds that they move besides in the next frame */
	float pace;        /* their seconds in one of the engine's; 0: they stand still */
	float pace_before; /* while they were paused: 0, or the one to go on with */
} engine_playing;

#define ENGINE_STEP (1.0 / 60.0) /* seconds that a step of what plays takes */

struct stilb_engine {
	engine_press press;
	stilb_owner owner; /* the main thread: the one that created it */
	stilb_engine_desc desc;
	stilb_input_table actions; /* the camera's rows, the engine's and the program's */
	stilb_job_pool *pool;
	stilb_scene *scene;   /* the program's; NULL: none */
	stilb_cull *cull;     /* of the scene; NULL: there is none */
	stilb_window *window; /* NULL when headless */
	stilb_render *render;
	stilb_debug *debug;
	stilb_post *post;
	engine_input input;

	/* The frame as data: frame.c culls once for each view, records each pass and replays all of them. */
	/* [view_count] of the scene's own camera, then of the others, then the reference, then of the shadow maps */
	stilb_render_view views[ENGINE_MAX_VIEWS];
	engine_shadows shadows;
	stilb_render_target targets[ENGINE_MAX_VIEWS];
	char target_names[ENGINE_MAX_VIEWS][STILB_RENDER_TARGET_NAME + 1];
	stilb_cull_visible visible[ENGINE_MAX_VIEWS]; /* the models that each view sees in this frame */
	engine_last lasts[ENGINE_MAX_VIEWS];          /* by view */
	engine_part part;                             /* while a photo is taken */
	/* Stops of the scene's camera that do not count while the exposure adapts, since the user has switched that on:
	 * they may have been metered. */
	float exposure_base;
	bool exposure_based; /* the user has switched that on, so a scene that comes sets exposure_base anew */
	bool holds;          /* nothing has moved since clips were paused: motion blur shows what moved before */
	/* The image that the program shows is of velocities, or in the same passes; of surfaces; of ambient_apart. */
	bool shows_velocity, shows_surfaces, shows_ambient;
	uint32_t view_count;
	stilb_render_pass passes[STILB_RENDER_MAX_PASSES]; /* [pass_count] of the scene, and after them the overlay's */
	uint32_t pass_count;
	uint32_t frame_passes;                           /* in this frame: pass_count, or one more for the overlay */
	engine_camera cameras[STILB_ENGINE_MAX_CAMERAS]; /* [camera_count] */
	uint32_t camera_count;
	float place[4];                 /* of the scene's own camera in the picture */
	engine_formulas frame_formulas; /* of this frame's views */
	engine_overlay overlay;
	engine_pictures *pictures;  /* NULL: none has been taken yet */
	struct engine_watch *watch; /* NULL: shaders are not watched */
	engine_shown picture;
	engine_value value;
	engine_counts counts;
	engine_peak peak;
	char caption[128];
	/* Of the plan, that keys have chosen; "": the picture, or the program's choice. */
	char image[STILB_GPU_MAX_NAME + 1];
	uint32_t image_part;          /* of that image: its mip + layer * mips */
	stilb_render_shading shading; /* of the next frame */
	engine_prepare *prepare;      /* the scene that stilb_engine_prepare was given; NULL: none */
	engine_prepare *compiling;    /* pipelines for other formulas; NULL: none */
	const void *panorama;         /* the pixels of the last frame's */
	engine_formulas compiled;     /* those whose pipelines were made last; {0}: none */

	bool profiled, captures;            /* it has started the profiler; its captures */
	stilb_scene_pick_index *pick_index; /* of the scene's meshes; NULL: nothing has been picked */
	engine_surface surface;             /* of the window, the engine's or the program's */
	bool dumpable;                      /* the last frame has drawn this scene */
	uint32_t culled_size[2]; /* of the last frame that has drawn it, whose visible models are known; 0: none has */
	uint64_t frame;          /* frames drawn */
	uint64_t last_ns;        /* clock at which the last frame began; 0 before the first */
	double seconds;          /* the engine's time, from 0 */
	engine_playing playing;  /* of the scene's clips */
	float step;              /* the time that this frame advances, seconds */
	stilb_engine_report report;
};

/* engine.c */

/* Forgets what the index of stilb_engine_pick knows of meshes that have changed. */
void engine_pick_forget(const stilb_engine *engine, const stilb_scene_changes *changes);

/* True if frames draw normals and models of surfaces; models at least; velocities. */
static inline bool engine_draws_surfaces(const stilb_engine *engine)
{
	return engine->desc.surfaces || engine->shows_surfaces;
}

static inline bool engine_draws_ids(const stilb_engine *engine)
{
	return engine_draws_surfaces(engine) || engine->desc.post.aa == STILB_POST_AA_TEMPORAL;
}

static inline bool engine_draws_velocity(const stilb_engine *engine)
{
	return engine->desc.velocity || engine->shows_velocity || engine->desc.post.motion_blur > 0.0f ||
	       engine_draws_ids(engine);
}

/* engine_cameras.c */

/* Fills the tables of views, targets and passes for this frame, which has a scene. */
void engine_cameras_frame(stilb_engine *engine);

/* Gives the scene's own view the jitter of temporal antialiasing, if that is on. */
void engine_cameras_jitter(stilb_engine *engine);

/* Turns the scene's own view into that of engine->part, and takes it for one that has not moved. Shadow maps are those
 * of the larger picture. */
void engine_cameras_part(stilb_engine *engine);

/* Draws the moment of the last frame again, without windows over it, for nobody: frame.c. hidden: that frame was
 * without the scene, so that it left no shadow maps. */
stilb_result engine_frame_again(stilb_engine *engine, bool hidden);

/* The device has got the frame. */
void engine_cameras_drawn(stilb_engine *engine);

/* The ray through a point of the picture, pixels, from the camera that is shown there. False: none is. */
bool engine_cameras_ray(const stilb_engine *engine, double x, double y, stilb_scene_ray *ray);

/* True if the scene's own camera is shown at a point of the picture, pixels; *x, *y: then as pixels of a picture of its
 * own, of size[2] pixels. */
bool engine_cameras_own(const stilb_engine *engine, double *x, double *y, uint32_t size[2]);

/* engine_shadows.c */

/* What views of maps share, for a camera's view. */
stilb_render_view engine_shadows_view(const stilb_render_view *seen, const stilb_engine_shadows *desc);
/* How views of cameras read them. */
stilb_render_shadow_reading engine_shadows_reading(const stilb_engine *engine);
/* Adds the views and passes of shadow maps to those of this frame's cameras. STILB_ERROR_MEMORY. */
stilb_result engine_shadows_frame(stilb_engine *engine);
/* Takes those out of what the view of a map sees that throw no shadow on what the cameras see. */
void engine_shadows_leave_out(const stilb_engine *engine, uint32_t view, stilb_cull_visible *visible);
/* The device has got the frame. */
void engine_shadows_drawn(stilb_engine *engine);
/* What maps show is not that of the next frame's scene. */
void engine_shadows_forget(engine_shadows *shadows);
void engine_shadows_finish(engine_shadows *shadows);

/* engine_prepare.c */

/* The view of a scene, but for what depends on the picture's size, and light_peak. */
stilb_render_view engine_view_of(const stilb_engine *engine, const stilb_scene *scene);
/* The most lights for which FORWARD is the reference of STILB_RENDER_SHOW_ERROR; of more CLUSTERED is, which shows the
 * same bits. */
#define ENGINE_FORWARD_LIGHTS 1000u

/* Makes of a camera's view that of the reference. */
void engine_reference_view(stilb_render_view *view);

/* How the textures of a scene come that is set or made ready now. */
stilb_render_textures engine_textures_now(const stilb_engine *engine);

/* Ends it without its outcome being used, and sets it to NULL, which is accepted. */
void engine_prepare_drop(engine_prepare **prepare);

bool engine_prepare_is_of(const engine_prepare *prepare, const stilb_scene *scene);

/* Waits for a scene, which then makes haste, and frees it. */
stilb_result engine_prepare_take(engine_prepare **prepare, stilb_cull **cull, stilb_render_prepared **made);

/* How this frame is lit and shaded: as engine->shading and desc.lighting say, but in a window with the formulas and the
 * way of lighting of the frame before while pipelines for others are being made. */
engine_formulas engine_prepare_formulas(stilb_engine *engine);

/* engine_profile.c */

/* Sets the profiler up, which all engines share, and begins captures; to be called before workers are started. The
 * calling thread gets the lane "main". STILB_ERROR_ARGUMENT: desc.profile_ring_mib. STILB_ERROR_FILE:
 * desc.capture.path. */
stilb_result engine_profile_start(stilb_engine *engine);

/* Ends the profiler's frame, if its frames are this engine's. */
void engine_profile_frame(const stilb_engine *engine);

/* engine_profile_stop_capture writes the captures that were requested, while all threads' rings (their recorded events)
 * still exist; engine_profile_stop, after the workers have ended, shuts the profiler down if this is the last engine.
 * Both may be called after a failed start. */
void engine_profile_stop_capture(stilb_engine *engine);
void engine_profile_stop(stilb_engine *engine);

/* engine_overlay.c */

/* Creates the user interface unless it exists. STILB_ERROR_MEMORY, STILB_ERROR_DEVICE. */
stilb_result engine_overlay_create(stilb_engine *engine);

/* Opens what the engine's description asks for. STILB_ERROR_MEMORY, STILB_ERROR_DEVICE. */
stilb_result engine_overlay_start(stilb_engine *engine);

/* Opens and closes the profiler's and the materials' windows. STILB_ERROR_MEMORY, STILB_ERROR_DEVICE: they cannot be
 * created, and nothing changes. */
stilb_result engine_overlay_open(stilb_engine *engine, bool profiler, bool inspector);
static inline bool engine_overlay_is_open(const engine_overlay *overlay)
{
	return overlay->profiler_open || overlay->inspector_open || overlay->clips.open || overlay->lights.open ||
	       overlay->effects.open || overlay->notice.pad_count > 0 || overlay->keys.open ||
	       (!overlay->toasts.hidden &&
	        (overlay->toasts.count > 0 || overlay->shader_error || overlay->keys.hint_seconds > 0.0f ||
	         overlay->rate.open || overlay->divider_open || overlay->caption_open || overlay->value_open ||
	         overlay->counts_open));
}

/* Frees the overlay's windows, before the renderer is destroyed. Accepts {0}. */
void engine_overlay_finish(engine_overlay *overlay);

/* Gives the window's input to the overlay. If the overlay has the keys, they are removed from *input. */
void engine_overlay_input(stilb_engine *engine, const stilb_window_state *window, stilb_input_state *input);

/* Logs that there is no permission to open a gamepad, and shows the notice with the rule that gives it. */
void engine_overlay_deny(stilb_engine *engine, uint32_t pad, const stilb_input_pad_info *info);

/* Shows a toast. One that cannot be shown is logged with the reason. */
void engine_overlay_tell(stilb_engine *engine, const char *text);

/* Opens, closes and freezes windows as keys and gamepads ask for it, and lets the window capture the mouse for the
 * camera unless it is over the overlay. */
void engine_overlay_act(stilb_engine *engine, const stilb_input_state *input);

/* A window's state as input of the user interface, all members but the picture's size and the time. */
stilb_ui_input engine_ui_input(const stilb_window_state *window);

/* Builds the overlay, of which a window is open, and records it as pass number `pass`, of kind 2D. Fails as
 * stilb_ui_record does. */
stilb_result engine_overlay_record(stilb_engine *engine, uint32_t pass, uint32_t worker);

/* engine_picture.c */

/* Shows the scene alone again and frees the picture. Also before the renderer is destroyed, or if there is none. */
void engine_picture_finish(stilb_engine *engine);

/* A frame without windows over it is to be drawn, to see what the still scene looks like. */
bool engine_picture_wants_scene(const stilb_engine *engine);

/* Takes that frame's picture. Fails as stilb_render_texture_create does. */
stilb_result engine_picture_keep_scene(stilb_engine *engine, const stilb_image *image);

/* True if the program's picture, of the scene's own camera, is shown in this column of the picture. */
bool engine_picture_covers(const stilb_engine *engine, double x);

/* Forgets what the scene looks like. */
void engine_picture_forget_scene(stilb_engine *engine);

/* Sets hides_scene for the frame. */
void engine_picture_decide(stilb_engine *engine);

/* Records the picture, which is shown, as pass number `pass`, of kind 2D. STILB_ERROR_MEMORY, STILB_ERROR_DEVICE. */
stilb_result engine_picture_record(stilb_engine *engine, uint32_t pass, uint32_t worker);

/* Draw the divider, if there is one, which the user can drag, and the caption, whose place is returned, between
 * stilb_ui_begin and stilb_ui_end. */
void engine_picture_divider(stilb_engine *engine, stilb_ui *ui);
stilb_ui_rect engine_picture_caption(const stilb_engine *engine, stilb_ui *ui);

/* engine_input.c */

/* Opens the gamepads or the recording; the window, if any, and the scene exist. STILB_ERROR_MEMORY, STILB_ERROR_FILE,
 * STILB_ERROR_DEVICE, STILB_ERROR_THREAD. */
stilb_result engine_input_start(stilb_engine *engine);

/* Takes what the program has given for this frame, with the picture's size: what is held stays for the next, what has
 * happened goes. False: nothing was ever given. */
bool engine_input_take_given(stilb_engine *engine, stilb_window_state *state);

/* Closes the gamepads or the recording and frees the control. Accepts {0}. */
void engine_input_finish(engine_input *input);

/* Combines the window's input in *state with all gamepad events since the last frame, and moves the scene's camera.
 * Returns the camera's time, microseconds. Never waits. */
int64_t engine_input_frame(stilb_engine *engine, stilb_input_state *state);

/* The age of this frame's newest gamepad report, milliseconds; 0: it had none. To be called when the frame's draws have
 * been handed to the device. */
double engine_input_latency(const stilb_engine *engine);

/* To be called when a capture has been requested: rumbles if a gamepad asked for it. */
void engine_input_captured(stilb_engine *engine);

/* engine_notice.c */

/* Adds a gamepad, in place of the oldest if there are ENGINE_NOTICE_PADS, and restarts the notice's time. */
void engine_notice_add(engine_notice *notice, uint32_t pad, const stilb_input_pad_info *info);

/* Removes the gamepad of that number if the notice names it. */
void engine_notice_remove(engine_notice *notice, uint32_t pad);

/* The number of bytes of the text that fit into one line of this width, broken after a blank or comma or at a newline
 * if possible. */
size_t engine_notice_line(const stilb_ui_font *font, const char *text, float width);

/* Draws the text in as many lines as it needs and cuts them off the area's top, as many as it has room for. ui NULL:
 * only measures. */
void engine_notice_text(stilb_ui *ui, const stilb_ui_font *font, stilb_ui_rect *area, stilb_ui_color color,
                        const char *text);

/* Draws the notice, between stilb_ui_begin and stilb_ui_end, and counts its time down. */
void engine_notice_draw(engine_notice *notice, stilb_ui *ui);

/* engine_surface.c */

/* The window as stilb_render_create takes it. */
stilb_gpu_surface engine_surface_of(stilb_window *window);

/* stilb_render_present; a surface that is lost is no error, and if `window` is not NULL another one is made of it. */
stilb_result engine_surface_present(engine_surface *surface, stilb_render *render, stilb_window *window);

/* True if the surface is lost and `window` has given no other for a while, or is NULL. */
bool engine_surface_is_gone(const engine_surface *surface, const stilb_window *window);

/* engine_images.c */

/* Shows another image of the last frame's plan, the next or the one before, if keys have asked for it. */
void engine_images_act(stilb_engine *engine, const stilb_input_state *input);

/* engine_toasts.c */

/* Adds a toast, in place of the oldest if there are ENGINE_TOASTS. The text is copied and cut off after 255 bytes. */
void engine_toasts_add(engine_toasts *toasts, const char *text);

/* Draws the toasts, between stilb_ui_begin and stilb_ui_end, and counts their time down. `below` pixels are left free
 * at the picture's lower edge. */
void engine_toasts_draw(engine_toasts *toasts, stilb_ui *ui, float below);

/* engine_keys.c */

/* Draws the key card, which is open, between stilb_ui_begin and stilb_ui_end. */
void engine_keys_draw(engine_keys *keys, const stilb_input_table *table, stilb_ui *ui);

/* Draws the line of main keys `below` pixels above the picture's lower edge, unless something covers it, and counts its
 * time down. Returns the height that it takes, pixels. */
float engine_keys_hint(engine_keys *keys, const stilb_input_table *table, stilb_ui *ui, float below, bool covered);

/* engine_rate.c */

/* Takes in a frame of this time that ended at now_ns. */
void engine_rate_add(engine_rate *rate, uint64_t now_ns, double frame_ms);

/* Draws rate and time in the upper left corner, between stilb_ui_begin and stilb_ui_end, once they are known, unless a
 * panel of places[0 .. count - 1] covers a part of them. Where they would reach the caption, {0}: there is none, they
 * stand below it. */
void engine_rate_draw(const engine_rate *rate, stilb_ui *ui, stilb_ui_rect caption, const stilb_ui_rect *places,
                      uint32_t count);

/* engine_value.c */

/* True if the value of the pixel under the pointer is to be shown: of a channel in the place of light, or of any
 * picture if a key has asked for it; unless a panel is there, or an image of the plan is shown. */
bool engine_value_wanted(const stilb_engine *engine);

/* After a frame was given to the device: takes the value that an earlier one has had, if it is there, and asks for the
 * next; nothing waits. */
void engine_value_frame(stilb_engine *engine);

/* Gives up what is being read, and the value. Before the renderer is destroyed. */
void engine_value_forget(stilb_engine *engine);

/* Draws the value, which is known, beside the pointer, between stilb_ui_begin and stilb_ui_end. */
void engine_value_draw(const stilb_engine *engine, stilb_ui *ui);

/* After a frame was given to the device: sums what it, or in a window an earlier one, has counted of lights, if it
 * shows that. */
void engine_counts_frame(stilb_engine *engine);

/* Gives up what is being read. Before the renderer is destroyed. */
void engine_counts_forget(stilb_engine *engine);

/* Draws what the colours mean, and the means, between stilb_ui_begin and stilb_ui_end. */
void engine_counts_draw(const stilb_engine *engine, stilb_ui *ui);

/* engine_pictures.c */

/* Starts a thread of the engine's. Signals are the program's threads' to handle, but for those of the thread's own
 * faults. Returns 0 or an errno. */
int engine_thread_start(pthread_t *thread, void *(*run)(void *user), void *user);

/* Writes a picture, as stilb_scene_look_save does. */
typedef stilb_result engine_picture_save(const stilb_scene_look *look, const stilb_image *image, const char *path);

/* `save` is called on the thread of pictures. NULL: no memory. */
engine_pictures *engine_pictures_create(engine_picture_save *save);

/* Waits for pictures that are being written, and ends their thread. NULL is accepted. */
void engine_pictures_destroy(engine_pictures *pictures);

/* Hands over the image, which is {0} afterwards, to be written as stilb_engine_picture describes.
 * STILB_ERROR_MEMORY. */
stilb_result engine_pictures_add(engine_pictures *pictures, stilb_image *image, const stilb_scene_look *look,
                                 const char *path, bool created);

/* How this view is shown. */
stilb_scene_look engine_look(const stilb_render_view *view);

/* Tells the program of pictures that have been written since the last call. */
void engine_pictures_tell(stilb_engine *engine);

/* watch/engine_watch_show.c */

/* Starts to watch shaders if the description says so; the renderer exists. */
void engine_watch_start(stilb_engine *engine);
void engine_watch_finish(stilb_engine *engine);
/* Tells the user of shaders that have changed since the last call. */
void engine_watch_tell(stilb_engine *engine);

/* watch/engine_watch_panel.c */

/* Draws the panel with what is wrong with shaders, between stilb_ui_begin and stilb_ui_end. False: the user has closed
 * it. */
bool engine_watch_draw(const char *text, stilb_ui *ui);

/* engine_clips.c: the animation's window. */
void engine_clips_draw(stilb_engine *engine, stilb_ui *ui);

/* windows/engine_effects.c: the effects' window. */
/* settings: those of frames. What the user has chosen the next frame takes. */
void engine_effects_draw(engine_effects *effects, stilb_ui *ui, const stilb_post_settings *settings);

/* windows/engine_lights.c: the lights' window. */
void engine_lights_draw(stilb_engine *engine, stilb_ui *ui);
/* True if the user wants to see one light alone. */
bool engine_lights_solo(const stilb_engine *engine, uint32_t *light);

/* engine_playing.c: pauses what plays, or lets it go on. */
void engine_playing_pause(stilb_engine *engine);

/* engine_inspector.c */

/* Draws the materials' window, between stilb_ui_begin and stilb_ui_end; the user's choices change *shading, and closing
 * it sets *open to false. */
void engine_inspector_draw(engine_inspector *inspector, stilb_ui *ui, stilb_render_shading *shading,
                           stilb_engine_choice *choice, bool *open);

#endif
