/* What the programs of the suite `animate` share. */
#ifndef ANIMATE_SCENE_H
#define ANIMATE_SCENE_H

#include "scene/scene.h"

#include <stdint.h>

#define ANIMATE_CHANNELS 3u /* of a joint */

/* Ends the program with the error's message. */
void animate_check(stilb_result result);

/* Figures of so many joints and vertices, 0: a triangle; each plays one clip, at a time of its own. torn: as of
 * ANIMATE_CASES. */
stilb_scene *animate_scene(uint32_t figures, uint32_t joints, uint32_t vertices, bool torn);

/* CPU time, which other programs lengthen less than the clock's: of this thread, and of all. */
typedef struct animate_cpu {
	uint64_t own_ns, all_ns;
} animate_cpu;

animate_cpu animate_cpu_now(void);

/* Since then: the longer one of this thread's time and that of the other, if there are two. So long it would take by
 * the clock on a machine with nothing else to do, but for times in which both wait. */
double animate_busier_ns(animate_cpu since);

#endif
