/*
 * live_draw: what --draw shows in the world of a frame: bounds of the models in view, lights, the world's axes.
 *
 *   live_draw draw;
 *   if (live_draw_parse(options.draw, &draw))
 *       live_draw_frame(&draw, engine);   // in each frame's update, after the scene and its camera have changed
 *
 * Threads.  [main-thread]
 */
#ifndef STILB_LIVE_DRAW_H
#define STILB_LIVE_DRAW_H

#include "engine.h"

typedef struct live_draw {
	bool bounds; /* of each model in view: the outline of its bounding sphere, by which it is culled, or a dot */
	bool lights; /* their shapes, and how far they reach if that ends somewhere */
	bool axes;   /* x, y and z at the origin, and a grid of y = 0 */
} live_draw;

/* Reads words separated by commas; NULL: none. False: something else is among them, or a word twice. */
bool live_draw_parse(const char *text, live_draw *draw);

/* Draws into the next frame. */
void live_draw_frame(const live_draw *draw, stilb_engine *engine);

#endif
