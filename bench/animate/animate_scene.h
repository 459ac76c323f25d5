/* What the programs of the suite `animate` share. */
#ifndef ANIMATE_SCENE_H
#define ANIMATE_SCENE_H

#include "scene/scene.h"

#define ANIMATE_CHANNELS 3u /* of a joint */

/* Ends the program with the error's message. */
void animate_check(stilb_result result);

/* Figures of so many joints and vertices, 0: a triangle; each plays one clip, at a time of its own. torn: as of
 * ANIMATE_CASES. */
stilb_scene *animate_scene(uint32_t figures, uint32_t joints, uint32_t vertices, bool torn);

#endif
