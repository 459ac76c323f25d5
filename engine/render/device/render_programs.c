/* Programs: for meshes one for each choice of formulas, surface and kind of detail, for 2D passes three, and those of
 * the backdrop and the tone map. They are made when they are first needed, or before. */
#include "render/render_internal.h"
#include "shading/shade_brdf.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const surface_names[RENDER_SURFACES] = {
	[RENDER_SURFACE_PLAIN] = "mesh",
	[RENDER_SURFACE_TEXTURE] = "mesh with a texture",
	[RENDER_SURFACE_IMPOSTOR] = "impostor",
};

/* ---- making ------------------------------------------------------------------------------------------------------ */

static_assert(RENDER_PROGRAM_KINDS == RENDER_DETAIL_KINDS, "render_device.h comes before render_detail's");

static void program_constant(stilb_gpu_program_desc *desc, uint32_t id, uint32_t value)
{
	STILB_ASSERT(desc->constant_count < STILB_GPU_MAX_SPECIALIZATIONS);
	desc->constants[desc->constant_count].id = id;
	desc->constants[desc->constant_count++].value = value;
}

/* Makes a program unless it is there. The caller holds the lock of programs. */
static stilb_result program_once(render_device *device, const stilb_gpu_program_desc *desc, stilb_gpu_program *program)
{
	return program->id != 0 ? STILB_OK : stilb_gpu_program_create(device->gpu, desc, program);
}

/* What a program reads of vertices: input number s is stream number s of the table. */
void render_program_vertices(const render_device *device, render_surface surface, stilb_gpu_program_desc *desc)
{
	static const stilb_gpu_format floats[] = {STILB_GPU_NONE, STILB_GPU_R32_F, STILB_GPU_RG32_F, STILB_GPU_RGB32_F,
	                                          STILB_GPU_RGBA32_F};
	/* Kinds of streams that no shader of a surface reads: fetching them costs a CPU time. */
	static const uint32_t unread[RENDER_SURFACES] = {
		[RENDER_SURFACE_PLAIN] = 1u << STILB_SCENE_STREAM_TEXTURE,
		[RENDER_SURFACE_IMPOSTOR] = 1u << STILB_SCENE_STREAM_DIRECTION,
	};
	desc->vertex_bytes = (uint16_t)device->layout.size;
	for (uint32_t s = 0; s < device->layout.count; s++) {
		const render_attribute *a = &device->layout.attributes[s];
		if (unread[surface] >> a->kind & 1u)
			continue;
		STILB_ASSERT(desc->input_count < STILB_GPU_MAX_VERTEX_INPUTS);
		desc->inputs[desc->input_count++] = (stilb_gpu_vertex_input){
			.location = (uint8_t)s,
			.format = (uint8_t)(a->octahedral ? STILB_GPU_R32_UI : floats[a->components]),
			.offset = (uint16_t)a->to,
		};
	}
}

bool render_formulas_are_depth(const render_formula_programs *programs)
{
	return programs->formulas[RENDER_FORMULA_LIGHTS] & RENDER_LIGHTS_DEPTH;
}

bool render_formulas_are_velocity(const render_formula_programs *programs)
{
	return render_formulas_are_depth(programs) && programs->formulas[RENDER_FORMULA_BESIDE] & RENDER_BESIDE_VELOCITY;
}

bool render_formulas_are_seen(const render_formula_programs *programs)
{
	return render_formulas_are_depth(programs) && programs->formulas[RENDER_FORMULA_BESIDE] & RENDER_BESIDE_ID;
}

bool render_formulas_are_gbuffer(const render_formula_programs *programs)
{
	return programs->formulas[RENDER_FORMULA_LIGHTS] & RENDER_LIGHTS_GBUFFER;
}

bool render_formulas_are_gloss(const render_formula_programs *programs)
{
	uint32_t brdf = programs->formulas[RENDER_FORMULA_BRDF];
	uint32_t lights = programs->formulas[RENDER_FORMULA_LIGHTS];
	return lights & RENDER_LIGHTS_PANORAMA && (lights & RENDER_LIGHTS_AMBIENT) != RENDER_LIGHTS_DARK &&
	       brdf != SHADE_BRDF_LAMBERT && brdf != SHADE_BRDF_WRAPPED;
}

bool render_formulas_have_shadows(const render_formula_programs *programs)
{
	uint32_t bits = programs->formulas[RENDER_FORMULA_LIGHTS];
	bool images = bits & RENDER_LIGHTS_APART && bits & RENDER_LIGHTS_LAID; /* lit before */
	return !(bits & (RENDER_LIGHTS_DEPTH | RENDER_LIGHTS_GBUFFER)) && !images && render_lights_channel(bits) == 0;
}

/* 1 + the channel that they show in the place of light; 0: none. */
static uint32_t formulas_channel(const render_formula_programs *programs)
{
	return render_lights_channel(programs->formulas[RENDER_FORMULA_LIGHTS]);
}

/* How the programs of channel - 1 differ from those of light: nothing blends, but counts are added up, and a wireframe
 * is made of lines. */
static void program_channel(stilb_gpu_program_desc *desc, uint32_t channel)
{
	bool counts = channel == 1 + STILB_SCENE_CHANNEL_OVERDRAW;
	desc->lines = channel == 1 + STILB_SCENE_CHANNEL_WIREFRAME;
	desc->depth_write |= !counts;
	desc->blend = counts ? STILB_GPU_BLEND_ADD : STILB_GPU_BLEND_NONE;
}

/* How programs of further lights differ: they add to what is drawn already, where it is seen. */
static void program_added(stilb_gpu_program_desc *desc, const render_formula_programs *choice)
{
	if (!(choice->formulas[RENDER_FORMULA_LIGHTS] & RENDER_LIGHTS_ADDED))
		return;
	desc->depth = STILB_GPU_COMPARE_GREATER_EQUAL;
	desc->depth_write = false;
	desc->blend = STILB_GPU_BLEND_ADD;
}

/* How programs of surfaces whose depth is there differ. */
static void program_laid(stilb_gpu_program_desc *desc, const render_formula_programs *choice)
{
	if (!(choice->formulas[RENDER_FORMULA_LIGHTS] & RENDER_LIGHTS_LAID))
		return;
	desc->depth = STILB_GPU_COMPARE_GREATER_EQUAL;
	desc->depth_write = false;
}

/* How programs of shadow maps differ: a surface that is lit must not be taken to be behind itself. Depth is moved by
 * what it changes by from a texel to the next, and some steps of its rounding. */
static void program_shadow(stilb_gpu_program_desc *desc, const render_formula_programs *choice)
{
	if (!render_formulas_are_depth(choice) || !(choice->formulas[RENDER_FORMULA_LIGHTS] & RENDER_LIGHTS_SHADOWS))
		return;
	desc->depth_bias = -8.0f;
	desc->depth_bias_slope = choice->formulas[RENDER_FORMULA_SHADOWS] & RENDER_SHADOW_FLAT ? 0.0f : -1.0f;
}

/* How programs of counted lights differ: what they draw is added up, but for surfaces that are lit later. */
static void program_counted(stilb_gpu_program_desc *desc, const render_formula_programs *choice)
{
	if (choice->formulas[RENDER_FORMULA_LIGHTS] & RENDER_LIGHTS_COUNTED && !render_formulas_are_gbuffer(choice))
		desc->blend = STILB_GPU_BLEND_ADD;
}

/* True if the choice's programs keep light and surfaces apart (RENDER_LIGHTS_APART). */
static bool formulas_are_apart(const render_formula_programs *choice)
{
	return choice->formulas[RENDER_FORMULA_LIGHTS] & RENDER_LIGHTS_APART;
}

/* True if they draw the buffer of shadows. */
static bool formulas_are_terms(const render_formula_programs *choice)
{
	return choice->formulas[RENDER_FORMULA_SHADOWS] & RENDER_SHADOW_TERMS;
}

/* How these differ: they read the mask, or an image in its place, too. */
static void program_terms(stilb_gpu_program_desc *desc, const render_formula_programs *choice, stilb_gpu_shader code)
{
	if (!formulas_are_terms(choice))
		return;
	desc->fragment = code;
	desc->samplers = 2;
}

/* The shader of draws into depth, which without velocities most need not. */
static stilb_gpu_shader program_depth_code(uint32_t detail, render_surface surface, bool velocity)
{
	if (surface == RENDER_SURFACE_IMPOSTOR)
		return render_impostor_depth_fragment[velocity];
	bool fades = render_state_of_detail(detail) == RENDER_STATE_FADE;
	return fades || velocity ? render_depth_fragment[velocity] : (stilb_gpu_shader){0};
}

/* What all programs of meshes are compiled for. */
static void program_formulas(const render_device *device, const render_formula_programs *choice, uint32_t detail,
                             render_drawn drawn, stilb_gpu_program_desc *desc)
{
	program_constant(desc, 1, drawn);
	for (uint32_t f = 0; f < RENDER_FORMULA_SHADOWS; f++)
		program_constant(desc, 2 + f, choice->formulas[f]);
	program_constant(desc, 11, choice->formulas[RENDER_FORMULA_SHADOWS]);
	program_constant(desc, 12, choice->formulas[RENDER_FORMULA_BESIDE]);
	program_constant(desc, 13, choice->formulas[RENDER_FORMULA_HDR]);
	program_constant(desc, 7, detail);
	program_constant(desc, 8, render_formulas_are_depth(choice) ? 1 : device->samples);
}

static stilb_result program_mesh(render_device *device, render_formula_programs *choice, uint32_t detail,
                                 render_surface surface, render_drawn drawn)
{
	bool sides = (choice->formulas[RENDER_FORMULA_LIGHTS] & RENDER_LIGHTS_SIDES) != 0;
	bool depth = render_formulas_are_depth(choice), gloss = render_formulas_are_gloss(choice);
	bool velocity = render_formulas_are_velocity(choice);
	uint32_t channel = formulas_channel(choice);
	stilb_gpu_program_desc desc = {
		.name = surface_names[surface],
		.vertex = render_mesh_vertex[device->packed][surface],
		.fragment = depth ? program_depth_code(detail, surface, velocity) : render_mesh_fragment[gloss][surface],
		.samplers = (uint8_t)(3 * gloss + render_formulas_have_shadows(choice)),
		.set_items = surface != RENDER_SURFACE_PLAIN,
		.depth = STILB_GPU_COMPARE_GREATER, /* reversed: near is 1 */
		.depth_write = true,
		.cull_back = !sides && surface != RENDER_SURFACE_IMPOSTOR,
	};
	program_added(&desc, choice);
	program_laid(&desc, choice);
	program_shadow(&desc, choice);
	program_counted(&desc, choice);
	bool gbuffer = render_formulas_are_gbuffer(choice), apart = formulas_are_apart(choice);
	if (gbuffer || apart)
		desc.fragment = gbuffer && apart ? render_slim_mesh_fragment[surface]
		                : gbuffer        ? render_gbuffer_mesh_fragment[gloss][surface]
		                                 : render_images_mesh_fragment[gloss][surface];
	desc.samplers += apart && !gbuffer ? RENDER_APART_IMAGES : 0;
	if (render_formulas_are_seen(choice))
		desc.fragment = render_seen_mesh_fragment[surface];
	program_terms(&desc, choice, render_terms_mesh_fragment[surface]);
	if (channel > 0) {
		program_channel(&desc, channel);
		desc.fragment = render_channel_mesh_fragment[surface];
		if (surface != RENDER_SURFACE_IMPOSTOR)
			desc.vertex = render_channel_vertex[device->packed][RENDER_CHANNEL_MESH];
	}
	/* Channels of what has no texture show places on textures, too. */
	bool places = channel > 0 && surface == RENDER_SURFACE_PLAIN;
	render_program_vertices(device, places ? RENDER_SURFACE_TEXTURE : surface, &desc);
	program_formulas(device, choice, detail, drawn, &desc);
	return program_once(device, &desc, &choice->programs[detail][surface][drawn]);
}

/* The function of programs for these bits; NULL: there is none. The caller holds the lock. */
static const render_function *program_function(const render_device *device, uint64_t bits)
{
	uint32_t index = render_maps_function(bits);
	return index > 0 ? device->programs.functions[index] : NULL;
}

/* The program of meshes with maps that a key stands for. */
static stilb_result program_maps(render_device *device, render_formula_programs *choice, uint64_t key,
                                 stilb_gpu_program *program)
{
	uint64_t bits = key >> 5;
	uint32_t detail = key >> 3 & 3u, drawn = key & 7u;
	const render_function *function = program_function(device, bits);
	bool sides = (choice->formulas[RENDER_FORMULA_LIGHTS] & RENDER_LIGHTS_SIDES) != 0;
	bool depth = render_formulas_are_depth(choice), extras = bits & RENDER_MAPS_EXTRAS;
	bool velocity = render_formulas_are_velocity(choice);
	bool layers = bits & RENDER_MAPS_LAYERS && (!depth || function);
	bool seen = render_formulas_are_seen(choice);
	bool blends = bits & RENDER_MAPS_BLEND, reads = !depth || seen || bits & RENDER_MAPS_MASK;
	bool coverage = bits & RENDER_MAPS_MASK && device->samples > 1, gloss = render_formulas_are_gloss(choice);
	render_surface inputs = reads ? RENDER_SURFACE_TEXTURE : RENDER_SURFACE_PLAIN;
	uint32_t channel = formulas_channel(choice);
	/* Masks of what light goes through have no samples of their own. */
	bool through = bits & RENDER_MAPS_THROUGH && !depth && channel == 0;
	stilb_gpu_program_desc desc = {
		.name = "mesh with maps",
		.vertex =
			reads ? render_maps_vertex[layers][device->packed][extras] : render_mesh_vertex[device->packed][inputs],
		.fragment = through  ? render_through_fragment[gloss][extras]
	                : !depth ? render_maps_fragment[layers][gloss][coverage][extras]
	                : !reads ? program_depth_code(detail, inputs, velocity)
	                         : render_maps_depth[velocity][extras],
		.samplers = (uint8_t)(3 * gloss + render_formulas_have_shadows(choice) + through),
		.set_items = !reads                      ? 0
	                 : bits & RENDER_MAPS_LAYERS ? RENDER_MAPS
	                                             : RENDER_MAPS_PLAIN,
		.depth = STILB_GPU_COMPARE_GREATER,
		.depth_write = !blends,
		.blend = blends ? STILB_GPU_BLEND_PREMULTIPLIED : STILB_GPU_BLEND_NONE,
		.cull_back = !sides || bits & RENDER_MAPS_ONE_SIDED,
	};
	program_added(&desc, choice);
	program_laid(&desc, choice);
	program_shadow(&desc, choice);
	program_counted(&desc, choice);
	bool gbuffer = render_formulas_are_gbuffer(choice), apart = formulas_are_apart(choice);
	if (gbuffer || apart)
		desc.fragment = gbuffer && apart ? render_slim_maps_fragment[extras]
		                : gbuffer        ? render_gbuffer_maps_fragment[gloss][extras]
		                                 : render_images_maps_fragment[gloss][extras];
	desc.samplers += apart && !gbuffer ? RENDER_APART_IMAGES : 0;
	if (seen)
		desc.fragment = render_seen_maps_fragment[extras];
	if (blends && choice->formulas[RENDER_FORMULA_BESIDE] != 0)
		desc.colors = 1; /* what is beside is of what it covers */
	program_terms(&desc, choice, render_terms_maps_fragment[extras]);
	if (channel > 0) {
		program_channel(&desc, channel);
		desc.vertex = render_channel_vertex[device->packed][RENDER_CHANNEL_MAPS + extras];
		desc.fragment = render_channel_maps_fragment[coverage][extras];
	}
	if (function && reads) {
		render_function_kind kind = channel > 0 ? RENDER_FUNCTION_CHANNEL
		                            : seen      ? RENDER_FUNCTION_SEEN
		                            : velocity  ? RENDER_FUNCTION_VELOCITY
		                            : depth     ? RENDER_FUNCTION_DEPTH
		                            : through   ? RENDER_FUNCTION_THROUGH
		                                        : RENDER_FUNCTION_MAPS;
		desc.name = function->program;
		desc.vertex = channel > 0 ? render_function_channel_vertex[device->packed][extras]
		                          : render_function_vertex[layers][device->packed][extras];
		desc.fragment = render_function_code(&function->own, kind, layers, gloss, coverage, extras);
	}
	render_program_vertices(device, inputs, &desc);
	program_formulas(device, choice, detail, drawn, &desc);
	program_constant(&desc, 9, (uint32_t)bits);
	program_constant(&desc, 10, (uint32_t)device->anisotropy);
	return stilb_gpu_program_create(device->gpu, &desc, program);
}

static stilb_result program_flat(render_device *device, render_flat kind)
{
	bool textured = kind != RENDER_FLAT_PLAIN;
	stilb_gpu_program_desc desc = {
		.name = "flat",
		.vertex = render_flat_shaders[kind][0],
		.fragment = render_flat_shaders[kind][1],
		.set_items = textured,
		.blend = kind == RENDER_FLAT_PICTURE ? STILB_GPU_BLEND_NONE : STILB_GPU_BLEND_PREMULTIPLIED,
		.vertex_bytes = sizeof(stilb_render_vertex_2d),
		.input_count = textured ? 3 : 2,
		.inputs = {{0, STILB_GPU_RG32_F, offsetof(stilb_render_vertex_2d, position)},
	               {1, STILB_GPU_RGBA8_U, offsetof(stilb_render_vertex_2d, color)},
	               {2, STILB_GPU_RG32_F, offsetof(stilb_render_vertex_2d, uv)}},
	};
	if (kind == RENDER_FLAT_PICTURE)
		program_constant(&desc, 0, device->output == STILB_RENDER_OUTPUT_DISPLAY);
	return program_once(device, &desc, &device->programs.flats[kind]);
}

/* A program of one triangle over the whole area, which samples an image if it has constants. */
static stilb_result program_screen(render_device *device, const char *name, stilb_gpu_shader fragment,
                                   const uint32_t *constants, uint32_t count, stilb_gpu_program *program)
{
	stilb_gpu_program_desc desc = {.name = name, .fragment = fragment, .samplers = count > 0 ? 1 : 0};
	for (uint32_t c = 0; c < count; c++)
		program_constant(&desc, c, constants[c]);
	return program_once(device, &desc, program);
}

/* ---- the backdrop, the tone map ---------------------------------------------------------------------------------- */

stilb_result render_programs_backdrop(render_device *device, render_backdrop_kind kind, stilb_render_hdr hdr)
{
	stilb_gpu_format color = render_hdr_formats[hdr];
	stilb_gpu_program *program = &device->programs.backdrops[hdr][kind];
	bool panorama = kind == RENDER_BACKDROP_PANORAMA;
	stilb_gpu_program_desc desc = {
		.name = "backdrop", .fragment = render_backdrop_fragment[panorama], .samplers = panorama};
	program_constant(&desc, 0, kind);
	program_constant(&desc, 1, hdr);
	pthread_mutex_lock(&device->programs.lock);
	stilb_result result = program_once(device, &desc, program);
	pthread_mutex_unlock(&device->programs.lock);
	return result == STILB_OK
	           ? stilb_gpu_program_prepare(device->gpu, *program, &color, 1, STILB_GPU_NONE, device->samples)
	           : result;
}

stilb_result render_programs_velocity(render_device *device)
{
	stilb_gpu_format color = STILB_GPU_RG16_F;
	stilb_gpu_program *program = &device->programs.velocity_far;
	pthread_mutex_lock(&device->programs.lock);
	stilb_result result = program_screen(device, "velocity far away", render_velocity_far_fragment, NULL, 0, program);
	pthread_mutex_unlock(&device->programs.lock);
	return result == STILB_OK ? stilb_gpu_program_prepare(device->gpu, *program, &color, 1, STILB_GPU_NONE, 1) : result;
}

stilb_result render_programs_around(render_device *device)
{
	stilb_gpu_format color = STILB_GPU_RGBA16_F;
	stilb_gpu_program *program = &device->programs.around;
	stilb_gpu_program_desc desc = {.name = "surroundings' light added",
	                               .fragment = render_around_fragment,
	                               .samplers = 2,
	                               .blend = STILB_GPU_BLEND_ADD};
	pthread_mutex_lock(&device->programs.lock);
	stilb_result result = program_once(device, &desc, program);
	pthread_mutex_unlock(&device->programs.lock);
	return result == STILB_OK ? stilb_gpu_program_prepare(device->gpu, *program, &color, 1, STILB_GPU_NONE, 1) : result;
}

stilb_result render_programs_difference(render_device *device)
{
	stilb_gpu_format color = STILB_GPU_RGBA16_F;
	stilb_gpu_program *program = &device->programs.difference;
	stilb_gpu_program_desc desc = {.name = "difference", .fragment = render_difference_fragment, .samplers = 2};
	pthread_mutex_lock(&device->programs.lock);
	stilb_result result = program_once(device, &desc, program);
	pthread_mutex_unlock(&device->programs.lock);
	return result == STILB_OK ? stilb_gpu_program_prepare(device->gpu, *program, &color, 1, STILB_GPU_NONE, 1) : result;
}

stilb_result render_programs_behind(render_device *device)
{
	render_programs *programs = &device->programs;
	stilb_gpu_format color = STILB_GPU_RGBA16_F;
	stilb_gpu_program_desc desc = {
		.name = "behind", .fragment = render_behind_fragment[device->samples > 1], .samplers = 2};
	if (device->samples > 1)
		program_constant(&desc, 0, device->samples);
	stilb_gpu_program_desc half = {.name = "behind, half", .fragment = render_behind_half_fragment, .samplers = 1};
	pthread_mutex_lock(&programs->lock);
	stilb_result result = program_once(device, &desc, &programs->behind);
	if (result == STILB_OK)
		result = program_once(device, &half, &programs->behind_half);
	pthread_mutex_unlock(&programs->lock);
	if (result == STILB_OK)
		result = stilb_gpu_program_prepare(device->gpu, programs->behind, &color, 1, STILB_GPU_NONE, 1);
	return result == STILB_OK
	           ? stilb_gpu_program_prepare(device->gpu, programs->behind_half, &color, 1, STILB_GPU_NONE, 1)
	           : result;
}

stilb_result render_programs_hdr(render_device *device, stilb_render_hdr hdr)
{
	stilb_gpu_format color = STILB_GPU_RGBA16_F;
	bool samples = device->samples > 1;
	const uint32_t resolve[2] = {device->samples, hdr}, decode[1] = {hdr};
	stilb_gpu_program *program = samples ? &device->programs.resolves[hdr] : &device->programs.decodes[hdr];
	STILB_ASSERT(samples || hdr != STILB_RENDER_HDR_HALF);
	pthread_mutex_lock(&device->programs.lock);
	stilb_result result = samples ? program_screen(device, "resolve", render_resolve_fragment, resolve, 2, program)
	                              : program_screen(device, "decode", render_decode_fragment, decode, 1, program);
	pthread_mutex_unlock(&device->programs.lock);
	return result == STILB_OK ? stilb_gpu_program_prepare(device->gpu, *program, &color, 1, STILB_GPU_NONE, 1) : result;
}

stilb_result render_programs_tone(render_device *device, uint32_t tone, bool placed)
{
	STILB_ASSERT(tone < RENDER_TONES);
	render_programs *programs = &device->programs;
	stilb_gpu_format picture = render_picture_format(device);
	bool display = device->output == STILB_RENDER_OUTPUT_DISPLAY;
	uint32_t curve[3] = {tone, display, placed};
	stilb_gpu_program *toned = &programs->tones[placed][tone];
	pthread_mutex_lock(&programs->lock);
	stilb_result result = program_screen(device, "tone", render_tone_fragment[0], curve, 3, toned);
	pthread_mutex_unlock(&programs->lock);
	if (result == STILB_OK)
		result = stilb_gpu_program_prepare(device->gpu, *toned, &picture, 1, STILB_GPU_NONE, 1);
	return result == STILB_OK && device->samples > 1 ? render_programs_hdr(device, STILB_RENDER_HDR_HALF) : result;
}

stilb_result render_programs_grade(render_device *device, uint32_t tone, bool placed, bool curves,
                                   stilb_gpu_program *program)
{
	STILB_ASSERT(tone < SHADE_TONE_COUNT);
	render_programs *programs = &device->programs;
	stilb_gpu_format picture = render_picture_format(device);
	stilb_gpu_program *graded = &programs->grades[placed][tone][curves];
	stilb_gpu_program_desc desc = {.name = "tone, grade", .fragment = render_tone_fragment[1], .samplers = 2};
	uint32_t constants[4] = {tone, device->output == STILB_RENDER_OUTPUT_DISPLAY, placed, curves};
	for (uint32_t c = 0; c < 4; c++)
		program_constant(&desc, c, constants[c]);
	pthread_mutex_lock(&programs->lock);
	stilb_result result = program_once(device, &desc, graded);
	pthread_mutex_unlock(&programs->lock);
	*program = *graded;
	return result == STILB_OK ? stilb_gpu_program_prepare(device->gpu, *graded, &picture, 1, STILB_GPU_NONE, 1)
	                          : result;
}

/* ---- meshes ------------------------------------------------------------------------------------------------------ */

/* The entry for these formulas, which may be a new one without programs. NULL: no memory. The caller holds the lock. */
static render_formula_programs *choice_find(render_programs *programs, const uint32_t formulas[RENDER_FORMULAS])
{
	for (uint32_t c = 0; c < programs->choice_count; c++)
		if (memcmp(programs->choices[c]->formulas, formulas, sizeof programs->choices[c]->formulas) == 0)
			return programs->choices[c];
	if (!render_reserve((void **)&programs->choices, &programs->choice_capacity, programs->choice_count + 1,
	                    sizeof(*programs->choices)))
		return NULL;
	render_formula_programs *choice = calloc(1, sizeof *choice);
	if (!choice)
		return NULL;
	memcpy(choice->formulas, formulas, sizeof choice->formulas);
	programs->choices[programs->choice_count++] = choice;
	return choice;
}

static const stilb_gpu_format *formulas_gbuffer_formats(const render_formula_programs *choice)
{
	bool narrow = choice->formulas[RENDER_FORMULA_LIGHTS] & RENDER_LIGHTS_GBUFFER8;
	return render_gbuffer_formats[narrow ? STILB_RENDER_GBUFFER_RGBA8 : STILB_RENDER_GBUFFER_WIDE];
}

/* Compiles a program of the choice. */
static stilb_result choice_compile(render_device *device, const render_formula_programs *choice,
                                   stilb_gpu_program program)
{
	bool depth = render_formulas_are_depth(choice);
	bool alone = choice->formulas[RENDER_FORMULA_BESIDE] & RENDER_BESIDE_ALONE;
	stilb_gpu_format color = render_hdr_formats[choice->formulas[RENDER_FORMULA_HDR]];
	stilb_gpu_format formats[STILB_GPU_MAX_COLORS] = {alone                        ? STILB_GPU_NONE
	                                                  : formulas_are_terms(choice) ? STILB_GPU_RGBA8_U
	                                                                               : color};
	uint32_t count = depth ? 0 : 1;
	if (render_formulas_are_gbuffer(choice)) {
		bool slim = formulas_are_apart(choice);
		count = slim ? 1 : 1 + RENDER_GBUFFER_IMAGES;
		memcpy(formats, formulas_gbuffer_formats(choice) + slim, count * sizeof *formats);
	}
	count = render_beside_formats(choice, formats, count);
	return stilb_gpu_program_prepare(device->gpu, program, formats, count, STILB_GPU_D32_F,
	                                 depth || render_formulas_are_gbuffer(choice) ? 1 : device->samples);
}

/* How draws of the choice find their materials: a range of one kind, or of the two for even and odd ids. */
typedef struct choice_drawn {
	render_drawn first;
	uint32_t count;
} choice_drawn;

static choice_drawn choice_drawn_of(const render_device *device, const render_formula_programs *choice)
{
	if (device->materials == STILB_RENDER_MATERIALS_INDEX || render_formulas_are_depth(choice))
		return (choice_drawn){RENDER_DRAWN_ALL, 1};
	if (device->materials == STILB_RENDER_MATERIALS_BIND)
		return (choice_drawn){RENDER_DRAWN_BOUND, 1};
	static_assert(RENDER_DRAWN_ODD == RENDER_DRAWN_EVEN + 1, "a range");
	return (choice_drawn){RENDER_DRAWN_EVEN, 2};
}

/* Makes and compiles a program. */
static stilb_result choice_make_one(render_device *device, render_formula_programs *choice, uint32_t detail,
                                    render_surface surface, render_drawn drawn)
{
	pthread_mutex_lock(&device->programs.lock);
	stilb_result result = program_mesh(device, choice, detail, surface, drawn);
	stilb_gpu_program program = choice->programs[detail][surface][drawn];
	pthread_mutex_unlock(&device->programs.lock);
	return result == STILB_OK ? choice_compile(device, choice, program) : result;
}

static stilb_result choice_make(render_device *device, render_formula_programs *choice, uint32_t detail,
                                render_surface surface)
{
	choice_drawn drawn = choice_drawn_of(device, choice);
	stilb_result result = STILB_OK;
	for (uint32_t i = 0; i < drawn.count && result == STILB_OK; i++)
		result = choice_make_one(device, choice, detail, surface, (render_drawn)(drawn.first + i));
	return result;
}

/* Of RENDER_SHADOW_... those that programs with these bits read. */
static uint32_t choice_shadow_bits(uint32_t light_bits, uint32_t shadow_bits)
{
	shadow_bits &= RENDER_SHADOW_HDR - 1;
	if (!(light_bits & RENDER_LIGHTS_SHADOWS) || light_bits & RENDER_LIGHTS_GBUFFER)
		return 0;
	return shadow_bits & (light_bits & RENDER_LIGHTS_DEPTH ? RENDER_SHADOW_FLAT : ~RENDER_SHADOW_FLAT);
}

stilb_result render_programs_choose_beside(render_device *device, const stilb_render_shading *wanted,
                                           uint32_t light_bits, uint32_t shadow_bits, uint32_t beside, uint32_t kinds,
                                           uint32_t surfaces, render_formula_programs **chosen)
{
	bool lit = !(light_bits & RENDER_LIGHTS_DEPTH) && render_lights_channel(light_bits) == 0;
	bool microfacet = lit && wanted->brdf == SHADE_BRDF_MICROFACET; /* other models do not depend on D, G and F */
	STILB_ASSERT(wanted->brdf < SHADE_BRDF_COUNT);
	STILB_ASSERT(!microfacet ||
	             (wanted->ndf < SHADE_NDF_COUNT && wanted->g < SHADE_G_COUNT && wanted->f < SHADE_F_COUNT));
	uint32_t formulas[RENDER_FORMULAS] = {
		[RENDER_FORMULA_BRDF] = lit ? wanted->brdf : 0,
		[RENDER_FORMULA_NDF] = microfacet ? wanted->ndf : 0,
		[RENDER_FORMULA_G] = microfacet ? wanted->g : 0,
		[RENDER_FORMULA_F] = microfacet ? wanted->f : 0,
		[RENDER_FORMULA_LIGHTS] = light_bits,
		[RENDER_FORMULA_SHADOWS] = choice_shadow_bits(light_bits, shadow_bits),
		[RENDER_FORMULA_BESIDE] = beside,
		[RENDER_FORMULA_HDR] = lit ? shadow_bits / RENDER_SHADOW_HDR : STILB_RENDER_HDR_HALF,
	};
	pthread_mutex_lock(&device->programs.lock);
	render_formula_programs *choice = choice_find(&device->programs, formulas);
	pthread_mutex_unlock(&device->programs.lock);
	*chosen = choice;
	if (!choice)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for another kind of shading");
	stilb_result result = STILB_OK;
	uint32_t ready = atomic_load_explicit(&choice->ready, memory_order_acquire); /* see ready */
	for (uint32_t v = 0; v < RENDER_SURFACES * RENDER_DETAIL_KINDS && result == STILB_OK; v++) {
		bool wants = (kinds >> v / RENDER_SURFACES & 1u) != 0 && (surfaces >> v % RENDER_SURFACES & 1u) != 0;
		if (!wants || (ready >> v & 1u) != 0)
			continue;
		result = choice_make(device, choice, v / RENDER_SURFACES, (render_surface)(v % RENDER_SURFACES));
		if (result == STILB_OK)
			atomic_fetch_or_explicit(&choice->ready, 1u << v, memory_order_release); /* see ready */
	}
	return result;
}

stilb_result render_programs_choose(render_device *device, const stilb_render_shading *wanted, uint32_t light_bits,
                                    uint32_t shadow_bits, uint32_t kinds, uint32_t surfaces,
                                    render_formula_programs **chosen)
{
	return render_programs_choose_beside(device, wanted, light_bits, shadow_bits, 0, kinds, surfaces, chosen);
}

/* Makes what draws bodies around lights. The caller holds the lock. */
static stilb_result program_volumes(render_device *device, render_formula_programs *choice,
                                    const stilb_gpu_program_desc *deferred)
{
	render_programs *programs = &device->programs;
	stilb_gpu_program_desc depth = {
		.name = "light volumes depth", .fragment = render_volume_depth_fragment, .samplers = 1, .depth_write = true};
	stilb_gpu_program_desc count = {.name = "light volumes",
	                                .vertex = render_volume_vertex,
	                                .samplers = deferred->samplers,
	                                .depth = STILB_GPU_COMPARE_GREATER,
	                                .stencil = STILB_GPU_STENCIL_COUNT};
	stilb_gpu_program_desc lit = *deferred;
	lit.vertex = render_volume_vertex;
	lit.stencil = STILB_GPU_STENCIL_COUNTED;
	stilb_result result = program_once(device, &depth, &programs->volume_depth);
	if (result == STILB_OK)
		result = program_once(device, &count, &programs->volume_count[formulas_are_apart(choice)]);
	return result == STILB_OK ? program_once(device, &lit, &choice->volumes) : result;
}

stilb_result render_programs_deferred(render_device *device, render_formula_programs *choice, bool volumes)
{
	static const stilb_gpu_format light[RENDER_APART_IMAGES] = {STILB_GPU_RGBA16_F, STILB_GPU_RGBA16_F};
	static const stilb_gpu_format shares[1] = {STILB_GPU_RGBA8_U};
	bool apart = formulas_are_apart(choice), terms = formulas_are_terms(choice);
	const stilb_gpu_format *colors = terms ? shares : light;
	uint32_t count = terms ? 1 : render_deferred_colors(choice->formulas[RENDER_FORMULA_LIGHTS]);
	stilb_gpu_program_desc desc = {.name = terms ? "deferred shadow buffer" : "deferred lights",
	                               .fragment =
	                                   terms ? render_deferred_terms_fragment[apart] : render_deferred_fragment[apart],
	                               .samplers = apart ? 3 : 2 + RENDER_GBUFFER_IMAGES, /* the last: shadows */
	                               .blend = terms ? STILB_GPU_BLEND_NONE : STILB_GPU_BLEND_ADD};
	desc.samplers += terms; /* the mask */
	program_formulas(device, choice, 0, RENDER_DRAWN_ALL, &desc);
	pthread_mutex_lock(&device->programs.lock);
	stilb_result result = program_once(device, &desc, &choice->deferred);
	if (result == STILB_OK && volumes)
		result = program_volumes(device, choice, &desc);
	pthread_mutex_unlock(&device->programs.lock);
	if (result == STILB_OK && volumes)
		result = stilb_gpu_program_prepare(device->gpu, device->programs.volume_depth, NULL, 0, STILB_GPU_D32_F_S8, 1);
	if (result == STILB_OK && volumes)
		result = stilb_gpu_program_prepare(device->gpu, device->programs.volume_count[apart], colors, count,
		                                   STILB_GPU_D32_F_S8, 1);
	if (result == STILB_OK && volumes)
		result = stilb_gpu_program_prepare(device->gpu, choice->volumes, colors, count, STILB_GPU_D32_F_S8, 1);
	return result == STILB_OK
	           ? stilb_gpu_program_prepare(device->gpu, choice->deferred, colors, count, STILB_GPU_NONE, 1)
	           : result;
}

stilb_result render_programs_cells(render_device *device)
{
	static const char *const names[RENDER_CELLS_PASSES] = {"count light lists", "place light lists",
	                                                       "fill light lists"};
	stilb_result result = STILB_OK;
	pthread_mutex_lock(&device->programs.lock);
	for (int pass = 0; pass < RENDER_CELLS_PASSES && result == STILB_OK; pass++) {
		stilb_gpu_program_desc desc = {.name = names[pass], .compute = render_cells_compute[pass]};
		result = program_once(device, &desc, &device->programs.cells[pass]);
	}
	pthread_mutex_unlock(&device->programs.lock);
	for (int pass = 0; pass < RENDER_CELLS_PASSES && result == STILB_OK; pass++)
		result = stilb_gpu_program_prepare(device->gpu, device->programs.cells[pass], NULL, 0, STILB_GPU_NONE, 1);
	return result;
}

stilb_result render_programs_tiles(render_device *device, const stilb_render_shading *shading, render_tiles kind,
                                   uint32_t bits, stilb_gpu_program *program)
{
	static const char *const names[RENDER_TILES_KINDS] = {"tiles", "tiles with normals", "tiles with gloss",
	                                                      "light indices"};
	static const uint8_t samplers[RENDER_TILES_KINDS] = {1, 2, 3, 1};
	bool narrow = samplers[kind] > 1 && bits & RENDER_LIGHTS_GBUFFER8;
	render_formula_programs *choice;
	stilb_gpu_program_desc desc = {
		.name = names[kind], .compute = render_tiles_compute[kind], .samplers = samplers[kind]};
	STILB_ASSERT((bits & ~RENDER_LIGHTS_GBUFFER8) == 0);
	stilb_result result = render_programs_choose(device, shading, bits, 0, 0, 0, &choice);
	if (result != STILB_OK)
		return result;
	for (uint32_t f = 0; f < RENDER_FORMULA_LIGHTS && kind == RENDER_TILES_GLOSS; f++)
		program_constant(&desc, 2 + f, choice->formulas[f]);
	if (samplers[kind] > 1)
		program_constant(&desc, 6, bits);
	stilb_gpu_program *made = kind == RENDER_TILES_GLOSS ? &choice->gloss : &device->programs.tiles[kind][narrow];
	pthread_mutex_lock(&device->programs.lock);
	result = program_once(device, &desc, made);
	*program = *made;
	pthread_mutex_unlock(&device->programs.lock);
	return result == STILB_OK ? stilb_gpu_program_prepare(device->gpu, *program, NULL, 0, STILB_GPU_NONE, 1) : result;
}

stilb_result render_programs_tiles_of(render_device *device, const stilb_render_view *view, uint32_t light_bits,
                                      stilb_gpu_program *program)
{
	uint32_t bits = render_deferred_bits(view, light_bits) & RENDER_LIGHTS_GBUFFER8;
	return render_programs_tiles(device, &view->shading, render_view_tiles(device, view), bits, program);
}

/* Finds the program of a key among the choice's, or makes it. */
static stilb_result choice_find_maps(render_device *device, render_formula_programs *choice, uint64_t key,
                                     stilb_gpu_program *program)
{
	for (uint32_t m = 0; m < choice->map_count; m++)
		if (choice->maps[m].key == key) {
			*program = choice->maps[m].program;
			return STILB_OK;
		}
	*program = (stilb_gpu_program){0};
	if (render_maps_function(key >> 5) > 0 && !program_function(device, key >> 5))
		return STILB_OK; /* a thread that prepares programs has found it just before it went */
	if (!render_reserve((void **)&choice->maps, &choice->map_capacity, choice->map_count + 1, sizeof *choice->maps))
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for another kind of surface");
	stilb_result result = program_maps(device, choice, key, program);
	if (result == STILB_OK)
		choice->maps[choice->map_count++] = (render_maps_program){key, *program};
	return result;
}

stilb_result render_programs_maps(render_device *device, render_formula_programs *choice, uint64_t key,
                                  stilb_gpu_program *program)
{
	pthread_mutex_lock(&device->programs.lock);
	stilb_result result = choice_find_maps(device, choice, key, program);
	pthread_mutex_unlock(&device->programs.lock);
	return result == STILB_OK && program->id != 0 ? choice_compile(device, choice, *program) : result;
}

/* Destroys the choice's programs of a function. The caller holds the lock. */
static void choice_drop_function(render_device *device, render_formula_programs *choice, uint32_t index)
{
	uint32_t kept = 0;
	for (uint32_t m = 0; m < choice->map_count; m++) {
		if (render_maps_function(choice->maps[m].key >> 5) == index)
			stilb_gpu_program_destroy(device->gpu, choice->maps[m].program);
		else
			choice->maps[kept++] = choice->maps[m];
	}
	choice->map_count = kept;
}

void render_programs_set_function(render_device *device, uint32_t index, render_function *function)
{
	render_programs *programs = &device->programs;
	STILB_ASSERT(index > 0 && index < RENDER_MAX_FUNCTIONS);
	pthread_mutex_lock(&programs->lock);
	render_function *old = programs->functions[index];
	STILB_ASSERT(!old != !function);
	for (uint32_t c = 0; old && c < programs->choice_count; c++)
		choice_drop_function(device, programs->choices[c], index);
	programs->functions[index] = function;
	pthread_mutex_unlock(&programs->lock);
	render_function_free(old);
}

/* Makes the programs of one kind of maps, which must not be left out. */
static stilb_result prepare_maps(render_device *device, render_formula_programs *choice, uint32_t kinds, uint64_t bits)
{
	choice_drawn drawn = choice_drawn_of(device, choice);
	stilb_result result = STILB_OK;
	for (uint32_t kind = 0; kind < RENDER_PROGRAM_KINDS && result == STILB_OK; kind++)
		for (uint32_t i = 0; kinds >> kind & 1u && i < drawn.count && result == STILB_OK; i++) {
			stilb_gpu_program program = {0};
			uint64_t key = render_maps_key(bits, kind, (render_drawn)(drawn.first + i));
			result = render_programs_maps(device, choice, key, &program);
		}
	return result;
}

/* True if only surfaces of render_maps_are_plain are drawn with them. */
static bool formulas_are_of_some(const render_formula_programs *choice)
{
	return choice->formulas[RENDER_FORMULA_LIGHTS] &
	           (RENDER_LIGHTS_GBUFFER | RENDER_LIGHTS_ADDED | RENDER_LIGHTS_LAID) ||
	       choice->formulas[RENDER_FORMULA_BESIDE] & RENDER_BESIDE_AROUND;
}

/* Makes the programs of all kinds of maps that draws of the view may have, on meshes with extras and without. */
static stilb_result prepare_all_maps(render_device *device, const stilb_render_view *view,
                                     render_formula_programs *choice, uint32_t kinds, const render_known_maps *maps)
{
	bool depth = render_formulas_are_depth(choice);
	stilb_result result = STILB_OK;
	for (uint32_t m = 0; m < 2 * maps->count && result == STILB_OK; m++) {
		bool extras = m % 2 == 1;
		bool depth_alone = depth && !render_formulas_are_seen(choice);
		uint64_t bits = render_maps_program_bits(maps->bits[m / 2], extras, view->both_sides, depth_alone);
		if (!(extras ? maps->extras : maps->plain) || (formulas_are_of_some(choice) && !render_maps_are_plain(bits)))
			continue;
		if (!depth || (bits != 0 && !(bits & RENDER_MAPS_BLEND)))
			result = prepare_maps(device, choice, kinds, bits);
		if (result == STILB_OK && bits & RENDER_MAPS_THROUGH && !depth && render_view_is_lit(view))
			result = render_programs_behind(device);
	}
	return result;
}

/* Makes the programs that draw a view's surfaces with these bits. */
static stilb_result prepare_surfaces(render_device *device, const stilb_render_view *view, uint32_t bits,
                                     uint32_t shadow_bits, uint32_t beside, uint32_t kinds, uint32_t surfaces,
                                     const render_known_maps *maps)
{
	render_formula_programs *choice;
	stilb_result result =
		render_programs_choose_beside(device, &view->shading, bits, shadow_bits, beside, kinds, surfaces, &choice);
	return result == STILB_OK ? prepare_all_maps(device, view, choice, kinds, maps) : result;
}

/* Makes what draws the surroundings' light apart, and all other light of what is plain. beside: as of
 * render_beside_bits. */
static stilb_result prepare_around(render_device *device, const stilb_render_view *view, uint32_t light_bits,
                                   uint32_t beside, uint32_t kinds, uint32_t surfaces, const render_known_maps *maps)
{
	render_way way = render_view_way(device, view);
	bool alone = !(beside & RENDER_BESIDE_AROUND);
	uint32_t rest = alone ? render_unlit_around_bits(light_bits) : light_bits;
	stilb_result result = STILB_OK;
	if (alone)
		result = prepare_surfaces(device, view, render_around_bits(light_bits), 0,
		                          render_around_beside_bits(device, view) | RENDER_BESIDE_ALONE, kinds, surfaces, maps);
	if (result == STILB_OK && !way.surfaces && !way.laid)
		result = prepare_surfaces(device, view, rest, render_shadow_bits(view), beside, kinds, surfaces, maps);
	return result == STILB_OK ? render_programs_around(device) : result;
}

/* Makes what draws the buffer of shadows: by the images of surfaces, or by the surfaces. */
static stilb_result prepare_terms(render_device *device, const stilb_render_view *view, uint32_t light_bits,
                                  uint32_t kinds, uint32_t surfaces, const render_known_maps *maps)
{
	render_way way = render_view_way(device, view);
	render_formula_programs *choice;
	uint32_t shadow_bits = render_terms_shadow_bits(render_shadow_bits(view), false);
	if (!(way.surfaces || way.apart))
		return prepare_surfaces(device, view, render_terms_bits(light_bits), shadow_bits, 0, kinds, surfaces, maps);
	stilb_result result = render_programs_choose(device, &view->shading, render_terms_image_bits(view, light_bits),
	                                             shadow_bits, 0, 0, &choice);
	return result == STILB_OK ? render_programs_deferred(device, choice, false) : result;
}

/* Makes what a view's way of lighting needs besides the programs for light_bits. */
static stilb_result prepare_way(render_device *device, const stilb_render_view *view, uint32_t light_bits,
                                uint32_t beside, uint32_t kinds, uint32_t surfaces, const render_known_maps *maps)
{
	render_way way = render_view_way(device, view);
	uint32_t depth = RENDER_LIGHTS_DEPTH | (light_bits & RENDER_LIGHTS_SIDES);
	uint32_t first = way.surfaces || way.apart ? render_gbuffer_bits(view, light_bits) : way.laid ? depth : 0;
	uint32_t added = render_added_bits(view, light_bits);
	uint32_t again = way.laid ? render_laid_bits(view, light_bits) : added;
	uint32_t shadow_bits = render_shadow_bits(view);
	stilb_result result = STILB_OK;
	if (first != 0)
		result = prepare_surfaces(device, view, first, 0, way.surfaces ? beside : 0, kinds, surfaces, maps);
	if (light_bits & RENDER_LIGHTS_SHADOWS && render_view_has_buffer(device, view)) {
		if (result == STILB_OK)
			result = prepare_terms(device, view, light_bits, kinds, surfaces, maps);
		shadow_bits = RENDER_SHADOW_BUFFER | (shadow_bits & ~(RENDER_SHADOW_HDR - 1));
	}
	if (result == STILB_OK && again != 0)
		result = prepare_surfaces(device, view, again, shadow_bits, way.laid ? beside : 0, kinds, surfaces, maps);
	if (result == STILB_OK && light_bits & RENDER_LIGHTS_LISTS && (way.tiles || way.indexed)) {
		stilb_gpu_program tiles;
		result = render_programs_tiles_of(device, view, light_bits, &tiles);
	}
	if (result != STILB_OK || !(way.surfaces || way.apart))
		return result;
	render_formula_programs *lights;
	result = render_programs_choose(device, &view->shading, render_deferred_bits(view, light_bits),
	                                shadow_bits & (RENDER_SHADOW_HDR - 1), 0, 0, &lights);
	bool volumes = render_view_has_volumes(device, view);
	return result == STILB_OK ? render_programs_deferred(device, lights, volumes) : result;
}

/* The kinds of draws that the view may have, as of render_programs_choose, and the surfaces. */
static uint32_t prepare_kinds(const stilb_render_view *view, uint32_t *surfaces)
{
	uint32_t kinds = render_view_kinds(view);
	bool drawn = view->impostors && view->detail.mode != STILB_RENDER_DETAIL_OFF;
	*surfaces = 1u << RENDER_SURFACE_PLAIN | 1u << RENDER_SURFACE_TEXTURE | (uint32_t)drawn << RENDER_SURFACE_IMPOSTOR;
	if (drawn && view->show != STILB_RENDER_SHOW_LEVELS && view->detail.mode != STILB_RENDER_DETAIL_POP)
		kinds |= 1u << render_state_detail(RENDER_STATE_FADE); /* also models that morph fade to their impostor */
	return kinds;
}

stilb_result render_device_prepare_seen(render_device *device, const stilb_render_view *view,
                                        const render_known_maps *maps)
{
	uint32_t surfaces, kinds = prepare_kinds(view, &surfaces), seen = render_seen_bits(view);
	stilb_result result = seen != 0 ? render_programs_velocity(device) : STILB_OK;
	if (result != STILB_OK || (seen & ~render_beside_bits(device, view)) == 0)
		return result;
	return prepare_surfaces(device, view, render_velocity_bits(view), 0, seen, kinds, surfaces, maps);
}

stilb_result render_device_prepare(render_device *device, const stilb_render_view *view, uint32_t light_bits,
                                   const render_known_maps *maps)
{
	uint32_t surfaces, kinds = prepare_kinds(view, &surfaces);
	bool depth = light_bits & RENDER_LIGHTS_DEPTH, apart = render_view_is_apart(device, view) && !depth;
	uint32_t beside = depth ? 0 : render_beside_bits(device, view);
	stilb_result result = prepare_surfaces(device, view, light_bits, render_shadow_bits(view),
	                                       beside & RENDER_BESIDE_SEEN, kinds, surfaces, maps);
	bool compute = view->light_lists == STILB_RENDER_LIGHT_LISTS_COMPUTE && light_bits & RENDER_LIGHTS_LISTS;
	if (result == STILB_OK && compute)
		result = render_programs_cells(device);
	if (result == STILB_OK && apart)
		result = prepare_around(device, view, light_bits, beside, kinds, surfaces, maps);
	if (apart && !(beside & RENDER_BESIDE_AROUND))
		light_bits = render_unlit_around_bits(light_bits);
	if (result == STILB_OK && !depth)
		result = prepare_way(device, view, light_bits, beside, kinds, surfaces, maps);
	if (result != STILB_OK || depth)
		return result;
	stilb_render_hdr hdr = render_view_hdr(view);
	/* Of surroundings with a panorama sky and ground are shown until that is made. */
	if (view->backdrop.kind != STILB_SCENE_BACKDROP_NOTHING)
		result = render_programs_backdrop(device, render_backdrop_kind_of(view, false), hdr);
	if (result == STILB_OK && view->backdrop.kind == STILB_SCENE_BACKDROP_SURROUNDINGS &&
	    render_panorama_is_good(&view->surroundings.panorama))
		result = render_programs_backdrop(device, RENDER_BACKDROP_PANORAMA, hdr);
	if (result == STILB_OK && hdr != STILB_RENDER_HDR_HALF)
		result = render_programs_hdr(device, hdr);
	if (result == STILB_OK && view->show == STILB_RENDER_SHOW_ERROR)
		result = render_programs_difference(device);
	/* Both: which one frames need may change with the size and the cameras beside. */
	if (result == STILB_OK)
		result = render_programs_tone(device, render_view_tone(view), false);
	return result == STILB_OK ? render_programs_tone(device, render_view_tone(view), true) : result;
}

/* ---- life -------------------------------------------------------------------------------------------------------- */

stilb_result render_programs_create(render_device *device)
{
	render_programs *programs = &device->programs;
	programs->lock_made = pthread_mutex_init(&programs->lock, NULL) == 0;
	if (!programs->lock_made)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the lock of programs");
	programs->functions = calloc(RENDER_MAX_FUNCTIONS, sizeof(*programs->functions));
	if (!programs->functions)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the table of surface functions");
	stilb_gpu_format picture = render_picture_format(device);
	stilb_result result = STILB_OK;
	for (uint32_t kind = 0; kind < RENDER_FLATS && result == STILB_OK; kind++) {
		pthread_mutex_lock(&programs->lock);
		result = program_flat(device, (render_flat)kind);
		pthread_mutex_unlock(&programs->lock);
		if (result == STILB_OK)
			result = stilb_gpu_program_prepare(device->gpu, programs->flats[kind], &picture, 1, STILB_GPU_NONE, 1);
	}
	return result;
}

void render_programs_destroy(render_device *device)
{
	render_programs *programs = &device->programs;
	for (uint32_t c = 0; c < programs->choice_count; c++) {
		free(programs->choices[c]->maps);
		free(programs->choices[c]);
	}
	free(programs->choices);
	for (uint32_t i = 0; programs->functions && i < RENDER_MAX_FUNCTIONS; i++)
		render_function_free(programs->functions[i]);
	free(programs->functions);
	if (programs->lock_made)
		pthread_mutex_destroy(&programs->lock);
}
