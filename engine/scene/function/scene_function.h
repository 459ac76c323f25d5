/*
 * scene_function: a program's own function of a surface. It changes what a material's factors and maps say, pixel by
 * pixel, before light falls on it: stripes that move, rust that grows, a ball that dissolves.
 *
 * Writing one.  In GLSL, against share/stilb/shaders/render/shaders/surface.glsl, whose comment says what it is given
 *               and returns:
 *
 *                 Surface surface_function(Surface surface, SurfacePoint point)
 *                 {
 *                     surface.color *= 0.5 + 0.5 * sin(surface_parameter(0).x * point.local.y + point.time);
 *                     return surface;
 *                 }
 *
 * Compiling.    When the program is built, with glslc; nothing is compiled from GLSL at run time, and no library for it
 *               is needed. The function becomes a part of each of Stilb's shaders for materials with a surface, so that
 *               passes of colour, of channels and of depth alone see the same. In CMake, which needs glslc (Debian:
 *               glslc, part of shaderc), 28 shaders of together some 10 s of CPU time and 3 MB:
 *
 *                 find_package(stilb REQUIRED COMPONENTS engine)
 *                 stilb_surface(my_program stripes stripes.glsl)   # makes "stripes.surface.h" for my_program
 *
 * Using it.     The header stripes.surface.h defines stripes, a stilb_scene_function. stilb_scene_build_function or
 *               stilb_scene_add_function gives a copy of it to a scene; a surface (scene_surface.h) names it and has
 *               four parameters of four numbers, which mean what the function takes them for. Changing them costs what
 *               changing the surface costs. Materials with functions sort and batch like others: draws are one run
 *               where maps, samplers and function are the same.
 *
 *                 uint32_t id = stilb_scene_build_function(build, &stripes);
 *                 stilb_scene_surface surface = stilb_scene_surface_make();
 *                 surface.function = 1 + id;
 *                 surface.parameters[0][0] = 40.0f;
 *
 * Alpha.        The surface's stilb_scene_alpha says what alpha does, with a function, too: of OPAQUE none has a say,
 *               and depth alone is drawn without the function; MASK drops pixels, in all passes; BLEND covers.
 * Not.          Rays (stilb_gi_scene_create, `stilb render`) show the material without its function, and say so by its
 *               name; so do impostors, and the meter of exposure, which go by the material's constants. Geometry, coat,
 *               sheen and transmission are not changed.
 * Safety.       What is passed in is checked: sizes, version, instructions, entry point, then inputs, outputs, bindings
 *               and constants of each shader. A mistake is an error that names the function. The GPU's driver trusts
 *               the rest, as of any Vulkan program: SPIR-V that was written to harm it may.
 * Threads.      Plain data. [any-thread]
 */
#ifndef STILB_SCENE_FUNCTION_H
#define STILB_SCENE_FUNCTION_H

#include "base/base.h"

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

#define STILB_SCENE_FUNCTION_CODES 36u
#define STILB_SCENE_FUNCTION_NAME 63u /* bytes of a name at most */
#define STILB_SCENE_FUNCTION_CODE_BYTES (1u << 24)
#define STILB_SCENE_MAX_FUNCTIONS 1023u /* of a scene */
#define STILB_SCENE_PARAMETERS 4u       /* of a surface, four numbers each */

/* SPIR-V of a fragment shader. */
typedef struct stilb_scene_function_code {
	const uint32_t *words;
	size_t bytes; /* a multiple of 4, at most STILB_SCENE_FUNCTION_CODE_BYTES */
} stilb_scene_function_code;

typedef struct stilb_scene_function {
	const char *name; /* for messages and dumps: letters, digits and _ alone */
	uint64_t shaders; /* stilb_scene_function_shaders() of the Stilb that it was compiled with */
	stilb_scene_function_code codes[STILB_SCENE_FUNCTION_CODES]; /* in the order of stilb_surface() */
} stilb_scene_function;

/* The number of this Stilb's shaders: another one when any of them has changed, and functions must be compiled again.
 * [any-thread] */
uint64_t stilb_scene_function_shaders(void);

/* What is wrong with a function, in words, as far as one sees without a device; NULL: nothing. Takes a millisecond or
 * two. [any-thread] */
const char *stilb_scene_function_mistake(const stilb_scene_function *function);

/* A copy with memory of its own. STILB_ERROR_MEMORY. [any-thread] */
stilb_result stilb_scene_function_copy(const stilb_scene_function *from, stilb_scene_function *to);

/* Frees a copy; accepts {0}, which it is then. [any-thread] */
void stilb_scene_function_finish(stilb_scene_function *copy);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#endif
