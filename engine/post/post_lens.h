/* Inside post/: depth of field. */
#ifndef POST_LENS_H
#define POST_LENS_H

#include "post/post.h"

#define POST_LENS_MAX_BLADES 16u

/* Settings that make sense: the aperture, and with depth of field a plane in focus. */
bool post_lens_is_valid(const stilb_post_settings *settings);

/* Adds its rows, and puts the image that is seen through the lens in the place of *light. */
stilb_result post_lens_add(stilb_post *post, stilb_gpu_plan *plan, uint16_t *light);

/* Destroys its programs. */
void post_lens_finish(stilb_post *post);

#endif
