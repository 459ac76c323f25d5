/* gi_embree: Embree's own handle, for measurements of Embree alone. */
#ifndef STILB_GI_EMBREE_H
#define STILB_GI_EMBREE_H

#include "gi/gi_scene.h"

#include <embree3/rtcore.h>

/* Of a scene that was made with stilb_gi_embree; lives as long as that. [any-thread] */
RTCScene gi_embree_scene(const stilb_gi_scene *scene);

#endif
