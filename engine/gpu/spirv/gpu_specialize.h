/* gpu: shaders without the code that their specialization constants never reach.
 *
 * A driver, and the validation layer before it, work through all of a shader and fold its specialization constants
 * late. The shaders of surfaces hold every way of lighting, of which a program uses one: without the others a fifth of
 * their code is left. */
#ifndef STILB_GPU_SPECIALIZE_H
#define STILB_GPU_SPECIALIZE_H

#include "gpu/gpu.h"

/* The SPIR-V of a shader, `count` words, without the blocks that are never reached if its specialization constants have
 * the values of desc->constants. Constants stay specialization constants: the values must be given to the pipeline
 * nevertheless. *out_count: its words. NULL: nothing can be left out, or there is no memory, or the module is not
 * understood (it is not checked here); then the shader is used as it is. The caller frees it. [any-thread] */
uint32_t *gpu_specialize(const uint32_t *words, size_t count, const stilb_gpu_program_desc *desc, size_t *out_count);

#endif
