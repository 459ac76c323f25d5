/* Inside post/: what surfaces mirror of the picture. */
#ifndef POST_REFLECTIONS_H
#define POST_REFLECTIONS_H

#include "post/post.h"

/* Adds its rows, and puts the image with them in the place of *reflection. */
stilb_result post_reflections_add(stilb_post *post, stilb_gpu_plan *plan, uint16_t *reflection);

/* Destroys its programs. */
void post_reflections_finish(stilb_post *post);

#endif
