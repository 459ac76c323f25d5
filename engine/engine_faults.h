/*
 * engine_faults: errors that tests and `stilb demo --fault` ask the engine's device to make.
 */
#ifndef STILB_ENGINE_FAULTS_H
#define STILB_ENGINE_FAULTS_H

#include "render/render.h"

/* The device of every engine that is created from now on makes these errors, once each. NULL: none. [main-thread] */
void stilb_engine_set_faults(const stilb_render_faults *faults);

#endif
