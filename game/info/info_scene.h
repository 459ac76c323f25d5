/* info_scene: what a scene has, for `stilb info SCENE`. [main-thread] */
#ifndef STILB_INFO_SCENE_H
#define STILB_INFO_SCENE_H

#include <stdbool.h>

/* Opens the scene, prints what is in it, and writes that as JSON to the file json unless it is NULL; allow_outside and
 * quiet as in stilb_scene_open_options. Returns the exit code, after a line on stderr if that is not EXIT_DONE. */
int info_scene(const char *name, bool allow_outside, bool quiet, const char *json);

#endif
