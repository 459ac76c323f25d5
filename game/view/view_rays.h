/*
 * view_rays: the path tracer in place of the frames of `stilb view`, or beside them, to the right of a divider.
 *
 * While what is seen changes, and while a clip plays, frames show it: they are sharp at once, and rays would have to
 * begin anew for each. When it has been still for a moment rays take over, coarse at first. In a window they run beside
 * the frames, on the same workers; without one, frames wait for them.
 *
 * Threads.  [main-thread]
 */
#ifndef STILB_VIEW_RAYS_H
#define STILB_VIEW_RAYS_H

#include "game/cli/flags.h"
#include "game/render/render_rays.h"
#include "view_seen.h"
#include "view_trace.h"

#include "engine.h"

typedef struct view_rays {
	/* Of the flags. */
	rays_flags flags;
	float split;  /* NaN: not given */
	uint64_t spp; /* 0: not given */

	bool on;
	float from;          /* where the divider is, as a share of the width: frames are left of it */
	view_trace *trace;   /* of the scene; NULL: none */
	bool held;           /* the scene may be edited */
	bool plays;          /* a clip has moved the scene in this frame */
	bool edits;          /* the window of lights is open */
	uint64_t begun_ns;   /* when the trace began, and then the picture */
	view_seen seen;      /* in the last frame */
	uint64_t changed_ns; /* when that was other than in the frame before */
	bool redraw;         /* frames show something else since the last one, and rays do not */
	bool asked;          /* for a picture of what is seen */
	bool shown, whole;   /* the engine shows it; all of it */
	uint64_t paused_ns;  /* when rays were turned off while there was a picture; 0: there was none */
	float *radiance;     /* [seen.height][seen.width][3] */
	uint64_t looked_ns;  /* when it was copied */
	uint64_t frame_ns;   /* when the last frame ended */
} view_rays;

typedef struct view view;

/* Without flags. */
view_rays view_rays_default(void);

/* Appends the flags' rows. */
void view_rays_add(view_rays *rays, flag_rows *table);

/* Checks them. Returns false after one line on stderr. */
bool view_rays_check(const view *v);

/* Turns rays on if --split is given. */
void view_rays_begin(view_rays *rays);

/* Turns rays on, or off. What they have found stays meanwhile, and goes on if nothing has changed. */
void view_rays_switch(view *v);

/* First in each frame, when clips have given nodes their poses and nothing that rays read follows from them yet: rays
 * read nothing of the scene while one plays. */
void view_rays_give_way(view *v);

/* In each frame, after the camera was moved. STILB_ERROR_..., only without a window: the picture cannot be traced. */
stilb_result view_rays_frame(view *v, uint64_t frame);

/* Between frames: waits if they need not come sooner, so that rays get the time. */
void view_rays_wait(view *v);

/* Before each edit of the scene: rays read nothing of it until the next frame, which begins with what has changed. */
void view_rays_hold(view *v);

/* Before the scene is replaced, the workers are, or the engine ends: forgets it. Rays begin anew with the next
 * frame. */
void view_rays_forget(view *v);

/* Frees all of it. */
void view_rays_finish(view *v);

#endif
