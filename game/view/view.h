/* view: what `stilb view` shows: a scene, and the camera that orbits it. [main-thread] */
#ifndef STILB_VIEW_H
#define STILB_VIEW_H

#include "game/live/live_run.h"
#include "geometry/geometry_detail.h"
#include "view_load.h"
#include "view_rays.h"
#include "view_watch.h"

/* Rows of the table of actions; view.c says which keys they have. */
enum {
	VIEW_TURN = STILB_ENGINE_ACTIONS,
	VIEW_PAN,
	VIEW_ZOOM,
	VIEW_FRAME,
	VIEW_HOME,
	VIEW_NEXT,
	VIEW_PREVIOUS,
	VIEW_DROP,
	VIEW_VARIANT,
	VIEW_GIVE_UP,
	VIEW_RAYS,
	VIEW_CAMERA_1, /* of the file; eight more follow */
	VIEW_CAMERA_9 = VIEW_CAMERA_1 + 8,
	VIEW_ACTIONS
};

/* A scene that has been opened and is on its way to the device. {0}: there is none. */
typedef struct view_coming {
	stilb_scene *scene; /* NULL: none */
	char *name;
	view_load_cost cost;
	view_watch watch;    /* of its file, unless `again` */
	bool looks, own;     /* its pictures have another look than those before: one of their own, or none */
	bool again, metered; /* a new state of the file that is shown; its exposure was metered */
} view_coming;

struct view {
	live_options options;
	char *name;                    /* of the scene that is shown; before that, of the first that is wanted */
	view_load *load;               /* what is being opened; NULL: nothing */
	view_coming coming;            /* what has been opened and is not yet shown */
	stilb_geometry_detail *detail; /* levels of the scene's meshes that are being made; NULL: all are there */
	view_watch watch;              /* of the scene's file */
	const char *environment;       /* of --environment; NULL: none */
	char *dropped;                 /* the panorama that takes its place since it was dropped; NULL: none was */
	char *dropping;                /* the one that is being read; NULL: none is */
	uint64_t turntable;            /* pictures of a whole turn; 0: none */
	const char *inset;             /* of --inset; NULL: none */
	stilb_scene_camera inset_camera;
	bool has_inset; /* the scene has that camera */
	bool own_look;  /* frames have the look of a scene, from the file beside it */
	live_run *run;
	stilb_scene *scene;
	float distance;          /* of the point that the camera orbits */
	float exposure;          /* of the pictures, stops, whichever camera takes them */
	uint32_t tone;           /* likewise, SHADE_TONE_... */
	float aspect;            /* of the picture that the scene was framed for */
	bool framed;             /* the camera frames the scene, and does so again in a picture of another aspect */
	stilb_scene_camera home; /* the camera at the start */
	stilb_scene_camera last; /* the camera as the last frame left it */
	view_rays rays;
};

/* Sets variant, camera, studio and exposure of a scene that will be shown. again: it is a new state of the same file.
 * *metered: its exposure was metered. */
stilb_result view_ready(view *v, stilb_scene *scene, bool again, bool *metered);

/* Shows a scene that was made ready, which is the view's from then on, in place of the one before, which is freed.
 * again: the camera stays. On failure the old one stays, and the new one is freed. */
stilb_result view_show(view *v, stilb_scene *scene, bool again, bool metered);

/* view_variant.c: shows the variant of --variant in a new scene; in a new state of the same file the one that was shown
 * before. Only of the first scene STILB_ERROR_ARGUMENT: it has none of that name. */
stilb_result view_variant_begin(const view *v, stilb_scene *scene, bool again);

/* Goes on to the next variant, after the last one to the file's own materials, and says so. */
void view_variant_next(view *v);

/* view_choose.c: looks with camera number `index` of the file, from 0 on, and says its name. */
void view_choose_camera(view *v, uint32_t index);

/* Says what the picture shows at a point, pixels from its upper left corner: part and material. */
void view_choose_part(const view *v, float x, float y);

/* Shows the camera of --inset, if the scene has it, in this frame. */
void view_show_inset(const view *v);

/* Moves the camera as the user asks for in this frame. */
void view_move(view *v, const stilb_engine_update *update);

#endif
