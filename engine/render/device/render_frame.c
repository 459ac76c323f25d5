/* A frame as a plan: its passes become rows, and a pass's draws a list. */
#include "render/device/render_images.h"
#include "render/render_internal.h"
#include "shading/shade_encoding.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* ---- features ---------------------------------------------------------------------------------------------------- */

/* What a feature gives for an image must be like it. */
static stilb_result frame_check_image(const render_device *device, uint16_t from, uint16_t to)
{
	const stilb_gpu_extent *a = stilb_gpu_plan_extent(device->plan, from);
	stilb_gpu_extent wanted = *a, given = {0};
	if (to > 0 && to <= stilb_gpu_plan_resources(device->plan))
		given = *stilb_gpu_plan_extent(device->plan, to);
	if (given.format == wanted.format && given.width == wanted.width && given.height == wanted.height &&
	    given.samples == wanted.samples)
		return STILB_OK;
	return stilb_fail(STILB_ERROR_ARGUMENT,
	                  "a feature gives image %u in the place of '%s', which is %ux%u of format %s; give one like it",
	                  to, stilb_gpu_plan_name(device->plan, from), wanted.width, wanted.height,
	                  stilb_gpu_format_describe(wanted.format)->name);
}

/* Adds the rows of the features of a stage. *image: as stilb_render_feature.add has it. */
static stilb_result frame_stage(render_device *device, stilb_render_stage stage, uint16_t *image)
{
	stilb_result result = STILB_OK;
	for (uint32_t f = 0; f < device->feature_count && result == STILB_OK; f++) {
		const stilb_render_feature *feature = &device->features[f];
		if (feature->stage != stage)
			continue;
		uint16_t given = *image;
		bool replaces =
			stage != STILB_RENDER_STAGE_FIRST && stage != STILB_RENDER_STAGE_DRAWN && stage != STILB_RENDER_STAGE_LAST;
		device->frame.added[f].first = stilb_gpu_plan_passes(device->plan);
		result = feature->add(feature->user, device->plan, &given);
		device->frame.added[f].end = stilb_gpu_plan_passes(device->plan);
		if (result != STILB_OK || !replaces || given == *image)
			continue;
		result = frame_check_image(device, *image, given);
		if (result == STILB_OK && stage == STILB_RENDER_STAGE_PICTURE)
			stilb_gpu_plan_show(device->plan, given); /* it is read after the frame */
		*image = given;
	}
	return result;
}

static stilb_result frame_begin(render_device *device)
{
	render_frame *frame = &device->frame;
	uint16_t none = 0;
	stilb_gpu_plan_begin(device->plan, device->width, device->height);
	frame->begun = true;
	stilb_result result = frame_stage(device, STILB_RENDER_STAGE_FIRST, &none);
	if (result == STILB_OK)
		frame->picture =
			stilb_gpu_plan_image(device->plan, &(stilb_gpu_plan_image_row){.name = STILB_RENDER_IMAGE_PICTURE,
		                                                                   .format = render_picture_format(device),
		                                                                   .scale = 1.0f,
		                                                                   .output = true});
	return result;
}

/* ---- views ------------------------------------------------------------------------------------------------------- */

static void frame_copy3(float out[4], const float in[3])
{
	memcpy(out, in, 3 * sizeof *out);
	out[3] = 0.0f;
}

/* Writes the stream's view to the slot's array, and returns what passes have of it as constants. width, height: of what
 * they draw into, pixels. exposure: of the target, by whose first view all its light is kept. */
static render_view_push frame_write_view(render_device *device, const render_stream *stream, uint32_t width,
                                         uint32_t height, float exposure)
{
	const render_slot *slot = render_slot_now(device);
	const stilb_render_view *view = stream->view;
	uint32_t index = device->frame.views++;
	STILB_ASSERT(index < STILB_RENDER_MAX_PASSES);
	STILB_ASSERT(fabsf(view->jitter[0]) * (float)width < 1.0f && fabsf(view->jitter[1]) * (float)height < 1.0f);
	render_view_data *out = (render_view_data *)slot->views.mapped + index;
	stilb_mat4 drawn = stilb_render_view_drawn(view), last = stilb_render_view_drawn_last(view);
	stilb_mat4 from_clip = stilb_mat4_inverse(&drawn);
	memcpy(out->view_projection, drawn.m, sizeof out->view_projection);
	render_ambient ambient;
	render_ambient_of(view, stream->panorama, &ambient);
	memcpy(out->sky, ambient.sky, sizeof out->sky);
	memcpy(out->ground, ambient.ground, sizeof out->ground);
	memcpy(out->harmonics, ambient.harmonics, sizeof out->harmonics);
	memcpy(out->mirrored, ambient.mirrored, sizeof out->mirrored);
	out->extras = device->heaps[RENDER_HEAP_EXTRAS].address;
	out->extra_places = device->heaps[RENDER_HEAP_EXTRA_PLACES].address;
	out->time = view->time;
	out->half_size[0] = 0.5f * (float)width;
	out->half_size[1] = 0.5f * (float)height;
	out->far = render_deferred_far(view);
	memcpy(out->last_view_projection, last.m, sizeof out->last_view_projection);
	memcpy(out->from_clip, from_clip.m, sizeof out->from_clip);
	memcpy(out->jitter, view->jitter, sizeof out->jitter);
	out->last_vertices = device->heaps[RENDER_HEAP_LAST].address;
	out->exposure = exposure;
	out->shadows = slot->memory[RENDER_MEMORY_LIGHT_LISTS].address + stream->lights.shadows * sizeof(float[4]);
	render_view_push push = {
		.added = {view->shading.roughness, view->shading.anisotropy, view->shading.wrap, view->shading.specular},
		.turn = {sinf(view->surroundings.rotation), cosf(view->surroundings.rotation)},
		.light_count = stream->lights.everywhere,
		.pixels = render_view_pixels(view, height),
		.lights = slot->memory[RENDER_MEMORY_LIGHTS].address + stream->lights.first * sizeof(render_light),
		.maps = device->heaps[RENDER_HEAP_MAPS].address,
		.panorama = stream->panorama ? device->panorama.address : 0,
		.lists = slot->memory[RENDER_MEMORY_LIGHT_LISTS].address + stream->lights.lists * sizeof(float[4]),
		.grid = {stream->lights.grid[0], stream->lights.grid[1]},
		.rest = slot->views.address + index * sizeof(render_view_data),
	};
	frame_copy3(push.camera_position, view->camera_position);
	const float *m = view->view_projection.m;
	bool parallel = m[3] == 0.0f && m[7] == 0.0f && m[11] == 0.0f;
	push.camera_position[3] = parallel ? m[15] : 0.0f;
	return push;
}

/* ---- lists ------------------------------------------------------------------------------------------------------- */

/* Which of a list's bindings a state needs, but for maps. */
static uint32_t list_binding(const render_device *device, uint64_t state)
{
	if (state & RENDER_STATE_2D)
		return state & RENDER_STATE_PICTURE       ? RENDER_FLAT_PICTURE
		       : render_state_texture(state) != 0 ? RENDER_FLAT_TEXTURE
		                                          : RENDER_FLAT_PLAIN;
	bool odd = device->materials == STILB_RENDER_MATERIALS_PIPELINE && render_state_material(state) != 0;
	uint32_t surface = state & RENDER_STATE_IMPOSTOR      ? RENDER_SURFACE_IMPOSTOR
	                   : render_state_texture(state) != 0 ? RENDER_SURFACE_TEXTURE
	                                                      : RENDER_SURFACE_PLAIN;
	uint32_t wide = (state & RENDER_STATE_WIDE) != 0;
	return ((render_state_detail(state) * RENDER_SURFACES + surface) * 2 + wide) * 2 + odd;
}

/* The materials that a scene pass's program draws. */
static render_drawn list_drawn(const render_device *device, const render_formula_programs *choice, bool odd)
{
	return render_formulas_are_depth(choice)                   ? RENDER_DRAWN_ALL
	       : device->materials == STILB_RENDER_MATERIALS_BIND  ? RENDER_DRAWN_BOUND
	       : device->materials == STILB_RENDER_MATERIALS_INDEX ? RENDER_DRAWN_ALL
	       : odd                                               ? RENDER_DRAWN_ODD
	                                                           : RENDER_DRAWN_EVEN;
}

static stilb_gpu_binding list_bind_program(const render_device *device, stilb_gpu_program program, bool wide)
{
	return (stilb_gpu_binding){
		.program = program.id,
		.index_bytes = wide ? 4 : 2,
		.indices = device->heaps[wide ? RENDER_HEAP_INDICES : RENDER_HEAP_INDICES_16].buffer.id,
		.vertices = device->heaps[RENDER_HEAP_VERTICES].buffer.id,
	};
}

/* That binding of a scene pass, whose programs are choice. */
static stilb_gpu_binding list_bind_meshes(const render_device *device, const render_formula_programs *choice,
                                          uint32_t binding)
{
	bool odd = binding & 1, wide = binding & 2;
	uint32_t surface = binding / 4 % RENDER_SURFACES, detail = binding / 4 / RENDER_SURFACES;
	render_drawn drawn = list_drawn(device, choice, odd);
	return list_bind_program(device, choice->programs[detail][surface][drawn], wide);
}

static stilb_gpu_binding list_bind_flats(render_device *device, uint32_t binding)
{
	const render_slot *slot = render_slot_now(device);
	return (stilb_gpu_binding){
		.program = device->programs.flats[binding].id,
		.index_bytes = 4,
		.indices = slot->memory[RENDER_MEMORY_INDICES_2D].buffer.id,
		.vertices = slot->memory[RENDER_MEMORY_VERTICES_2D].buffer.id,
	};
}

/* Which of a stream's draws a list has. */
typedef enum frame_draws {
	FRAME_DRAWS_ALL,
	FRAME_DRAWS_PLAIN, /* those that can be lit later, or in several passes (render_maps_are_plain) */
	FRAME_DRAWS_OTHERS,
	FRAME_DRAWS_BLENDED, /* into depth: those that blend, as if they were masks */
} frame_draws;

/* A list that is being made. */
typedef struct list_maker {
	render_device *device;
	render_list *list;
	render_formula_programs *choice;  /* NULL: of a 2D pass */
	uint16_t places[RENDER_BINDINGS]; /* 1 + where a binding is in the list */
	uint32_t count;                   /* of its bindings */
	bool depth;                       /* depth alone is drawn, or what is seen with it */
	bool seen;                        /* the second one */
	frame_draws draws;
} list_maker;

/* maps: as of render_list.maps. */
static stilb_result list_add(list_maker *maker, stilb_gpu_binding binding, uint64_t maps)
{
	render_list *list = maker->list;
	uint32_t count = maker->count + 1;
	if (!render_reserve((void **)&list->bindings, &list->binding_capacity, count, sizeof *list->bindings) ||
	    !render_reserve((void **)&list->maps, &list->map_capacity, count, sizeof *list->maps))
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the programs of a pass");
	list->bindings[maker->count] = binding;
	list->maps[maker->count++] = maps;
	return STILB_OK;
}

/* Finds the binding of a draw with maps, whose programs are for these bits; adds it if it is new. */
static stilb_result list_find_maps(list_maker *maker, uint64_t state, uint64_t bits, uint32_t *place)
{
	render_device *device = maker->device;
	bool odd = device->materials == STILB_RENDER_MATERIALS_PIPELINE && render_state_material(state) != 0;
	bool wide = (state & RENDER_STATE_WIDE) != 0;
	uint64_t key = render_maps_key(bits, render_state_detail(state), list_drawn(device, maker->choice, odd));
	for (*place = 0; *place < maker->count; *place += 1)
		if (maker->list->maps[*place] == 1 + (key << 1 | wide))
			return STILB_OK;
	stilb_gpu_program program;
	stilb_result result = render_programs_maps(device, maker->choice, key, &program);
	STILB_ASSERT(result != STILB_OK || program.id != 0);
	return result == STILB_OK ? list_add(maker, list_bind_program(device, program, wide), 1 + (key << 1 | wide))
	                          : result;
}

static stilb_result list_find(list_maker *maker, uint64_t state, uint32_t *place)
{
	render_device *device = maker->device;
	uint32_t b = list_binding(device, state);
	if (maker->places[b] == 0) {
		stilb_gpu_binding binding =
			maker->choice ? list_bind_meshes(device, maker->choice, b) : list_bind_flats(device, b);
		stilb_result result = list_add(maker, binding, 0);
		if (result != STILB_OK)
			return result;
		maker->places[b] = (uint16_t)maker->count;
	}
	*place = maker->places[b] - 1u;
	return STILB_OK;
}

/* The state of a draw into depth alone: of materials and textures it needs those of impostors, which have their depth
 * in them. */
static uint64_t list_depth_state(uint64_t state)
{
	uint64_t shape = RENDER_STATE_DETAIL | RENDER_STATE_WIDE | RENDER_STATE_IMPOSTOR;
	return state & RENDER_STATE_IMPOSTOR ? state & (shape | (RENDER_STATE_IMPOSTOR - 1)) : state & shape;
}

/* What the program of a draw with maps is compiled for. */
static uint64_t list_maps_bits(const list_maker *maker, uint64_t state)
{
	bool sides = maker->choice->formulas[RENDER_FORMULA_LIGHTS] & RENDER_LIGHTS_SIDES;
	uint64_t bits = maker->device->maps[render_state_group(state)].bits;
	if (maker->draws == FRAME_DRAWS_BLENDED)
		bits = (bits & ~(uint64_t)RENDER_MAPS_BLEND) | RENDER_MAPS_MASK;
	return render_maps_program_bits(bits, state & RENDER_STATE_EXTRAS, sides, maker->depth && !maker->seen);
}

/* Fills in what a run binds. *drawn: false if it is not drawn. */
static stilb_result list_run(list_maker *maker, const render_run *from, stilb_gpu_run *run, bool *drawn)
{
	const render_device *device = maker->device;
	uint64_t bits = from->state & RENDER_STATE_MAPS && maker->choice ? list_maps_bits(maker, from->state) : 0;
	*run = (stilb_gpu_run){.first = from->first, .count = from->count};
	uint64_t own = from->state & RENDER_STATE_MAPS ? device->maps[render_state_group(from->state)].bits : 0;
	*drawn = maker->draws == FRAME_DRAWS_BLENDED
	             ? (own & (RENDER_MAPS_BLEND | RENDER_MAPS_THROUGH)) == RENDER_MAPS_BLEND
	             : maker->draws == FRAME_DRAWS_ALL || render_maps_are_plain(own) == (maker->draws == FRAME_DRAWS_PLAIN);
	if (!*drawn)
		return STILB_OK;
	if (maker->depth && bits & RENDER_MAPS_BLEND) {
		*drawn = false;
		return STILB_OK;
	}
	if (from->state & RENDER_STATE_MAPS && (!maker->depth || bits != 0)) {
		bool reads = !maker->depth || maker->seen || bits & RENDER_MAPS_MASK;
		run->set = reads ? device->maps[render_state_group(from->state)].set.id : 0;
		return list_find_maps(maker, from->state, bits, &run->binding);
	}
	uint64_t state = maker->depth ? list_depth_state(from->state) : from->state;
	uint32_t texture = render_state_texture(state);
	STILB_ASSERT(texture < STILB_RENDER_MAX_TEXTURES);
	stilb_result result = texture ? render_device_texture_set(maker->device, texture, &run->set) : STILB_OK;
	return result == STILB_OK ? list_find(maker, state, &run->binding) : result;
}

/* Makes one run of two if the second goes on where the first ends. */
static bool list_join(stilb_gpu_run *run, const stilb_gpu_run *next)
{
	if (run->first + run->count != next->first || run->binding != next->binding || run->set != next->set)
		return false;
	run->count += next->count;
	return true;
}

/* Some of a stream's runs, first .. end - 1. */
typedef struct frame_part {
	uint32_t first, end;
} frame_part;

/* Makes the list of a part of a stream's draws; returns its number among the frame's. choice: of scene passes. */
static stilb_result frame_list(render_device *device, const render_stream *stream, frame_part part, frame_draws draws,
                               render_formula_programs *choice, uint32_t *number)
{
	render_frame *frame = &device->frame;
	*number = frame->list_count;
	STILB_ASSERT(*number < RENDER_MAX_LISTS);
	if (!render_reserve((void **)&device->runs, &device->run_capacity, frame->run_count + part.end - part.first,
	                    sizeof *device->runs))
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for %u runs of draws", part.end - part.first);
	render_list *list = &device->lists[frame->list_count++];
	uint32_t made = 0;
	list_maker maker = {.device = device,
	                    .list = list,
	                    .choice = choice,
	                    .depth = stream->lights.bits & RENDER_LIGHTS_DEPTH,
	                    .seen = choice && render_formulas_are_seen(choice),
	                    .draws = draws};
	bool bind = choice && !maker.depth && device->materials == STILB_RENDER_MATERIALS_BIND;
	uint64_t materials = device->heaps[RENDER_HEAP_MATERIALS].address;
	stilb_gpu_run *out = part.end > part.first ? device->runs + frame->run_count : NULL;
	for (uint32_t r = part.first; r < part.end; r++) {
		stilb_gpu_run run;
		bool drawn;
		stilb_result result = list_run(&maker, &stream->runs[r], &run, &drawn);
		if (result != STILB_OK)
			return result;
		run.constant = bind ? materials + render_state_material(stream->runs[r].state) * sizeof(render_material) : 0;
		if (!drawn || (maker.depth && made > 0 && list_join(&out[made - 1], &run)))
			continue;
		out[made++] = run;
	}
	list->first_run = frame->run_count;
	frame->run_count += made;
	device->draws[*number] = (stilb_gpu_draws){
		.draws = stream->commands,
		.commands = render_slot_now(device)->memory[RENDER_MEMORY_COMMANDS].buffer,
		.bindings = list->bindings,
		.binding_count = maker.count,
		.run_count = made,
		.replay = (stilb_gpu_replay)render_stream_mode(device, stream),
		.has_constants = bind,
		.constant_place = offsetof(render_push, materials),
	};
	return STILB_OK;
}

static_assert((int)STILB_GPU_REPLAY_INDIRECT == (int)STILB_RENDER_REPLAY_INDIRECT &&
                  (int)STILB_GPU_REPLAY_DIRECT == (int)STILB_RENDER_REPLAY_DIRECT &&
                  (int)STILB_GPU_REPLAY_SECONDARY == (int)STILB_RENDER_REPLAY_SECONDARY,
              "the same modes");

/* ---- rows -------------------------------------------------------------------------------------------------------- */

static void row_constants(stilb_gpu_pass *row, const void *constants, size_t bytes)
{
	STILB_ASSERT(bytes <= sizeof row->constants);
	memcpy(row->constants, constants, bytes);
	row->constant_bytes = (uint8_t)bytes;
}

/* Ends the scene: makes the picture of what its passes have drawn. */
static stilb_result frame_end_scene(render_device *device)
{
	render_frame *frame = &device->frame;
	if (frame->ended || frame->target_count == 0)
		return STILB_OK;
	frame->ended = true;
	const render_frame_target *main = render_target_main(device);
	uint16_t light = main ? main->color : 0, drawn = main ? render_target_light(main) : 0;
	/* Without a number its row is wrong, which the plan will say. */
	stilb_result result = drawn != 0 ? frame_stage(device, STILB_RENDER_STAGE_DRAWN, &drawn) : STILB_OK;
	if (result != STILB_OK)
		return result;
	render_targets_resolve(device);
	result = light != 0 ? frame_stage(device, STILB_RENDER_STAGE_LIGHT, &light) : STILB_OK;
	if (result == STILB_OK && light != 0 && main->tone == RENDER_TONE_ERROR)
		result = render_target_compare(device, main, &light);
	if (result != STILB_OK)
		return result;
	render_targets_show(device, light);
	if (frame->shown)
		result = frame_stage(device, STILB_RENDER_STAGE_PICTURE, &frame->picture);
	if (result == STILB_OK && frame->atlas != 0 && device->until[0] == '\0')
		result = render_show_layers(device, frame->atlas);
	bool shows = device->shown.name && strcmp(device->shown.name, STILB_RENDER_IMAGE_PICTURE) != 0;
	return result == STILB_OK && shows && device->until[0] == '\0' ? render_show_image(device, &device->shown) : result;
}

/* The resource of the panorama's texels. */
static uint16_t frame_texels(render_device *device, const render_stream *stream)
{
	render_frame *frame = &device->frame;
	stilb_gpu_plan_image_row row = {.name = "panorama",
	                                .format = STILB_GPU_RGBA16_F,
	                                .width = stream->panorama->width,
	                                .height = stream->panorama->height,
	                                .owned = device->texels.id};
	if (frame->texels == 0)
		frame->texels = stilb_gpu_plan_image(device->plan, &row);
	return frame->texels;
}

/* What is seen where no model is. */
static stilb_result frame_backdrop(render_device *device, const render_stream *stream,
                                   const render_frame_target *target)
{
	render_backdrop_push push;
	render_backdrop_kind kind = render_backdrop_kind_of(stream->view, stream->panorama);
	stilb_result result = render_programs_backdrop(device, kind, target->hdr);
	if (result == STILB_OK)
		result = render_backdrop_write(device, stream->view, stream->panorama, &push);
	if (result != STILB_OK)
		return result;
	stilb_gpu_pass row = {
		.name = "backdrop",
		.kind = STILB_GPU_PASS_FULLSCREEN,
		.color_count = 1,
		.program = device->programs.backdrops[target->hdr][kind].id,
		.color = {{.image = render_target_light(target), .load = STILB_GPU_LOAD_DISCARD}},
	};
	if (kind == RENDER_BACKDROP_PANORAMA) {
		row.uses[0] = (stilb_gpu_use){.resource = frame_texels(device, stream), .how = STILB_GPU_USE_SAMPLED};
		row.use_count = 1;
	}
	row_constants(&row, &push, sizeof push);
	stilb_gpu_plan_pass(device->plan, &row);
	return STILB_OK;
}

/* The row of a pass that draws list number `list`. what: comes behind the pass's name. */
static stilb_gpu_pass frame_row(render_device *device, const render_stream *stream, uint32_t list, const char *what)
{
	char *name = device->lists[list].name;
	int room = (int)(sizeof device->lists[list].name - 1 - strlen(what));
	snprintf(name, sizeof device->lists[list].name, "%.*s%s", room, stream->pass->name ? stream->pass->name : "pass",
	         what);
	return (stilb_gpu_pass){.name = name, .kind = STILB_GPU_PASS_DRAWS, .draws = list};
}

/* Counts are added up in all channels but alpha, so that these are not transparent. */
static bool frame_is_transparent(const stilb_render_view *view)
{
	bool counts = view->show == STILB_RENDER_SHOW_OVERDRAW || render_view_counts(view);
	return view->backdrop.kind == STILB_SCENE_BACKDROP_NOTHING && !counts;
}

/* The first pass into a target says how the picture shows it. */
static stilb_result frame_first(render_device *device, const render_stream *stream, render_frame_target *target,
                                bool backdrop)
{
	const stilb_render_view *view = stream->view;
	if (target->color == 0)
		return STILB_OK;
	target->data = render_view_is_data(view);
	target->transparent = frame_is_transparent(view);
	target->exposure = target->data ? 1.0f : exp2f(view->exposure);
	target->dither = target->data || view->show == STILB_RENDER_SHOW_ERROR ? STILB_RENDER_DITHER_OFF : view->dither;
	target->tone = render_view_tone(view);
	target->grade = device->output == STILB_RENDER_OUTPUT_DISPLAY && !target->data && target->tone < SHADE_TONE_COUNT
	                    ? view->grade
	                    : NULL;
	stilb_gpu_program graded;
	stilb_result result = render_programs_tone(device, target->tone, target->from);
	if (result == STILB_OK && target->grade)
		result = render_programs_grade(device, target->tone, target->from, target->grade->curves, &graded);
	if (result == STILB_OK && target->hdr != STILB_RENDER_HDR_HALF)
		result = render_programs_hdr(device, target->hdr);
	return result == STILB_OK && backdrop ? frame_backdrop(device, stream, target) : result;
}

/* What light is cleared to, as it is kept. */
static void frame_clear(const stilb_render_view *view, const render_frame_target *target, float clear[4])
{
	render_backdrop_clear(view, clear);
	if (target->hdr == STILB_RENDER_HDR_HALF)
		return;
	float exposure = target->exposure;
	stilb_vec3 exposed = stilb_vec3_make(clear[0] * exposure, clear[1] * exposure, clear[2] * exposure);
	stilb_vec4 kept = target->hdr == STILB_RENDER_HDR_RGBM
	                      ? shade_rgbm_encode(exposed, SHADE_RGBM_FACTOR, SHADE_RGBM_GAMMA)
	                      : shade_logluv_encode(exposed);
	for (int c = 0; c < 4; c++)
		clear[c] = kept[c];
}

/* What a scene pass draws into. */
static void frame_attach(const render_stream *stream, render_frame_target *target, bool backdrop, stilb_gpu_pass *row)
{
	row->depth = (stilb_gpu_attachment){
		.image = target->depth, .load = target->drawn ? STILB_GPU_LOAD_KEEP : STILB_GPU_LOAD_CLEAR, /* to 0: far away */
	};
	if (target->color == 0) {
		uint16_t layer = stream->view->layer;
		uint64_t *drawn = &target->layers_drawn[layer / 64], bit = UINT64_C(1) << layer % 64;
		row->depth.layer = layer;
		row->depth.load = target->from->lasting ? STILB_GPU_LOAD_CLEAR_AREA
		                  : *drawn & bit        ? STILB_GPU_LOAD_KEEP
		                                        : STILB_GPU_LOAD_CLEAR;
		*drawn |= bit;
		memcpy(row->area, stream->view->area, sizeof row->area);
		return;
	}
	row->color_count = 1;
	row->color[0] = (stilb_gpu_attachment){
		.image = render_target_light(target),
		.load = target->drawn || backdrop ? STILB_GPU_LOAD_KEEP : STILB_GPU_LOAD_CLEAR,
	};
	if (!target->data)
		frame_clear(stream->view, target, row->color[0].clear);
	else if (!target->transparent)
		row->color[0].clear[3] = 1.0f;
}

/* The three images that programs read of a panorama. */
static void frame_gloss(render_device *device, stilb_gpu_pass *row)
{
	render_frame *frame = &device->frame;
	if (frame->cube == 0) {
		stilb_gpu_plan_image_row cube = {.name = "panorama cube",
		                                 .format = STILB_GPU_RGBA16_F,
		                                 .shape = STILB_GPU_SHAPE_CUBE,
		                                 .width = RENDER_PANORAMA_FACE,
		                                 .height = RENDER_PANORAMA_FACE,
		                                 .mips = RENDER_PANORAMA_MIPS,
		                                 .owned = device->cube.id};
		stilb_gpu_plan_image_row dfg = {.name = "gloss table",
		                                .format = STILB_GPU_RG16_F,
		                                .width = RENDER_PANORAMA_DFG,
		                                .height = RENDER_PANORAMA_DFG,
		                                .owned = device->dfg.id};
		stilb_gpu_plan_image_row light = {.name = "panorama light",
		                                  .format = STILB_GPU_RGBA32_F,
		                                  .width = RENDER_PANORAMA_COLUMNS,
		                                  .height = RENDER_PANORAMA_ROWS,
		                                  .owned = device->light.id};
		frame->cube = stilb_gpu_plan_image(device->plan, &cube);
		frame->dfg = stilb_gpu_plan_image(device->plan, &dfg);
		frame->light = stilb_gpu_plan_image(device->plan, &light);
	}
	row->use_count = 3;
	row->uses[0] = (stilb_gpu_use){
		.resource = frame->cube, .how = STILB_GPU_USE_SAMPLED, .slot = 0, .sampler = device->cube_sampler.id};
	row->uses[1] =
		(stilb_gpu_use){.resource = frame->dfg, .how = STILB_GPU_USE_SAMPLED, .slot = 1, .sampler = device->linear.id};
	row->uses[2] = (stilb_gpu_use){.resource = frame->light, .how = STILB_GPU_USE_SAMPLED, .slot = 2};
}

/* The images that programs of a pass read, the first ones of its row. */
static stilb_result frame_images(render_device *device, const render_stream *stream, const render_frame_target *target,
                                 const render_formula_programs *choice, stilb_gpu_pass *row)
{
	if (render_formulas_are_gloss(choice))
		frame_gloss(device, row);
	return render_formulas_have_shadows(choice) ? render_shadow_use(device, stream, target, row) : STILB_OK;
}

/* The surfaces that the stream's draws have, but for maps, as of render_programs_choose. */
static uint32_t frame_surfaces(const render_stream *stream)
{
	uint64_t states = stream->states & ~RENDER_STATE_MAPS;
	if (stream->states & RENDER_STATE_MAPS) {
		states = 0;
		for (uint32_t r = 0; r < stream->run_count; r++)
			states |= stream->runs[r].state & RENDER_STATE_MAPS ? 0 : stream->runs[r].state;
	}
	return 1u << RENDER_SURFACE_PLAIN | (render_state_texture(states) != 0 ? 1u << RENDER_SURFACE_TEXTURE : 0) |
	       (states & RENDER_STATE_IMPOSTOR ? 1u << RENDER_SURFACE_IMPOSTOR : 0);
}

/* The part of a scene pass's draws from `first` on that one row draws: up to the first with transmission, those, and
 * what comes behind them (render_maps_order). *through: it is the second one. */
static frame_part frame_part_from(const render_device *device, const render_stream *stream, uint32_t first,
                                  bool *through)
{
	frame_part part = {first, first};
	*through = false;
	if (device->through == 0 || !render_view_is_lit(stream->view)) {
		part.end = stream->run_count;
		return part;
	}
	for (; part.end < stream->run_count; part.end++) {
		uint64_t state = stream->runs[part.end].state;
		bool here = state & RENDER_STATE_MAPS && device->maps[render_state_group(state)].bits & RENDER_MAPS_THROUGH;
		if (part.end > first && here != *through)
			break;
		*through = here;
	}
	return part;
}

/* Adds the rows of a scene pass: one, or with transmission up to three and the copies between. push: their
 * constants. */
static stilb_result frame_rows(render_device *device, const render_stream *stream, frame_draws draws,
                               render_formula_programs *choice, render_frame_target *target, bool backdrop,
                               const render_push *push)
{
	frame_part part = {0};
	stilb_result result = STILB_OK;
	bool through;
	do {
		uint32_t list;
		part = frame_part_from(device, stream, part.end, &through);
		if (through && !target->drawn) { /* what they show must be there */
			part.end = part.first;
			through = false;
		}
		if (through && draws == FRAME_DRAWS_PLAIN)
			continue; /* none of these is */
		if (through)
			result = render_through_copy(device, stream, target);
		if (result == STILB_OK)
			result = frame_list(device, stream, part, draws, choice, &list);
		if (result != STILB_OK)
			return result;
		if (draws != FRAME_DRAWS_ALL && target->drawn && device->draws[list].run_count == 0)
			continue;
		stilb_gpu_pass row = frame_row(device, stream, list, "");
		frame_attach(stream, target, backdrop, &row);
		render_target_attach(device, choice, target, &row);
		result = frame_images(device, stream, target, choice, &row);
		if (through && result == STILB_OK)
			result = render_through_use(device, target, row.use_count, &row.uses[row.use_count]);
		row.use_count += through;
		render_cells_use(device, offsetof(render_push, view.lists), &row);
		row_constants(&row, push, sizeof *push);
		stilb_gpu_plan_pass(device->plan, &row);
		target->drawn = true;
	} while (part.end < stream->run_count && result == STILB_OK);
	return result;
}

/* Adds the row of a scene pass that draws velocities, and what else is seen, alone. */
static stilb_result frame_velocity(render_device *device, const render_stream *stream, render_frame_target *target,
                                   const render_push *push)
{
	uint32_t list;
	render_stream moved = *stream;
	render_formula_programs *choice;
	moved.lights.bits = render_velocity_bits(stream->view);
	stilb_result result =
		render_programs_choose_beside(device, &stream->view->shading, moved.lights.bits, 0,
	                                  render_seen_bits(stream->view), stream->kinds, frame_surfaces(stream), &choice);
	if (result == STILB_OK)
		result = frame_list(device, &moved, (frame_part){0, stream->run_count}, FRAME_DRAWS_ALL, choice, &list);
	if (result != STILB_OK)
		return result;
	stilb_gpu_pass row = frame_row(device, stream, list, " velocity");
	row.depth = render_velocity_depth(device, stream->view, target);
	render_target_attach(device, choice, target, &row);
	row_constants(&row, push, sizeof *push);
	stilb_gpu_plan_pass(device->plan, &row);
	return STILB_OK;
}

/* True if a scene pass is drawn again for further lights. */
static bool frame_is_multipass(const render_stream *stream)
{
	return stream->lights.count > STILB_RENDER_LIGHTS_A_PASS &&
	       render_added_bits(stream->view, stream->lights.bits) != 0;
}

/* Adds the rows of what is plain in a scene pass that is drawn again for further lights. choice: of the first ones. */
static stilb_result frame_multipass(render_device *device, const render_stream *stream, render_formula_programs *choice,
                                    render_frame_target *target, bool backdrop, const render_push *push)
{
	render_formula_programs *further;
	uint32_t added = render_added_bits(stream->view, stream->lights.bits), surfaces = frame_surfaces(stream), list;
	uint32_t count = stream->lights.count, rows = render_light_rows_left(device->frame.light_rows);
	uint32_t each = rows > 0 ? (count + rows - 1) / rows : count;
	each = each > STILB_RENDER_LIGHTS_A_PASS ? each : STILB_RENDER_LIGHTS_A_PASS;
	render_push part = *push;
	part.view.light_count = each;
	stilb_result result = frame_rows(device, stream, FRAME_DRAWS_PLAIN, choice, target, backdrop, &part);
	if (result == STILB_OK)
		result = render_programs_choose(device, &stream->view->shading, added, stream->lights.shadow_bits,
		                                stream->kinds, surfaces, &further);
	if (result == STILB_OK)
		result = frame_list(device, stream, (frame_part){0, stream->run_count}, FRAME_DRAWS_PLAIN, further, &list);
	if (result != STILB_OK)
		return result;
	stilb_gpu_pass row = frame_row(device, stream, list, " further lights");
	frame_attach(stream, target, backdrop, &row);
	result = frame_images(device, stream, target, further, &row);
	if (result != STILB_OK)
		return result;
	for (uint32_t first = each; first < count && device->draws[list].run_count > 0; first += each) {
		device->frame.light_rows++;
		part.view.lights = push->view.lights + first * sizeof(render_light);
		part.view.light_count = count - first < each ? count - first : each;
		row_constants(&row, &part, sizeof part);
		stilb_gpu_plan_pass(device->plan, &row);
	}
	return STILB_OK;
}

/* Makes the row that draws the buffer of shadows: of what is plain once more, or, where there are images of surfaces,
 * over the picture. */
static stilb_result frame_terms_row(render_device *device, const render_stream *terms,
                                    const render_frame_target *target, stilb_gpu_pass *row)
{
	render_way way = render_view_way(device, terms->view);
	bool images = way.surfaces || way.apart;
	render_formula_programs *choice;
	uint32_t list, bits = terms->lights.bits;
	stilb_result result =
		render_programs_choose(device, &terms->view->shading, bits, terms->lights.shadow_bits,
	                           images ? 0 : terms->kinds, images ? 0 : frame_surfaces(terms), &choice);
	if (result == STILB_OK && images)
		result = render_programs_deferred(device, choice, false);
	else if (result == STILB_OK)
		result = frame_list(device, terms, (frame_part){0, terms->run_count}, FRAME_DRAWS_PLAIN, choice, &list);
	if (result != STILB_OK)
		return result;
	if (images) {
		*row = (stilb_gpu_pass){
			.name = "shadow buffer", .kind = STILB_GPU_PASS_FULLSCREEN, .program = choice->deferred.id};
		render_deferred_use_surfaces(target, bits, row);
	} else {
		*row = frame_row(device, terms, list, " shadow buffer");
		row->depth = (stilb_gpu_attachment){.image = target->depth, .load = STILB_GPU_LOAD_KEEP, .read_only = true};
	}
	return STILB_OK;
}

/* Adds the rows that draw the buffer of shadows of what is plain, whose depth is there: four lights each. */
static stilb_result frame_terms(render_device *device, const render_stream *stream, render_frame_target *target,
                                const render_push *push)
{
	const render_view_lights *lights = &stream->lights;
	render_stream terms = *stream;
	render_way way = render_view_way(device, stream->view);
	stilb_gpu_pass first;
	uint16_t mask;
	if (lights->terms == 0)
		return STILB_OK;
	terms.lights.bits = way.surfaces || way.apart ? render_terms_image_bits(stream->view, lights->bits)
	                                              : render_terms_bits(lights->bits);
	stilb_result result = render_terms_mask(device, target, &mask);
	terms.lights.shadow_bits = render_terms_shadow_bits(render_shadow_bits(stream->view), mask != 0);
	if (result == STILB_OK)
		result = frame_terms_row(device, &terms, target, &first);
	device->stats.shadow_terms += lights->terms;
	for (uint16_t layer = 0; result == STILB_OK && RENDER_SHADOW_LAYER * layer < lights->terms; layer++) {
		device->stats.shadow_bytes += (uint64_t)target->width * target->height * RENDER_SHADOW_LAYER;
		uint32_t left = lights->terms - RENDER_SHADOW_LAYER * layer;
		render_push part = *push;
		part.view.light_count = left < RENDER_SHADOW_LAYER ? left : RENDER_SHADOW_LAYER;
		part.view.lists = render_slot_now(device)->memory[RENDER_MEMORY_LIGHT_LISTS].address +
		                  (lights->term_list + layer) * sizeof(uint32_t[RENDER_SHADOW_LAYER]);
		stilb_gpu_pass row = first;
		result = render_terms_attach(device, &terms, target, mask, layer, &row);
		row_constants(&row, &part, sizeof part);
		if (result == STILB_OK)
			stilb_gpu_plan_pass(device->plan, &row);
	}
	return result;
}

/* Adds the rows of what is plain in a scene pass whose lights are deferred: its surfaces, and the lights. */
static stilb_result frame_deferred(render_device *device, const render_stream *stream, render_frame_target *target,
                                   bool backdrop, const render_push *push)
{
	render_formula_programs *surfaces;
	uint32_t bits = render_gbuffer_bits(stream->view, stream->lights.bits);
	stilb_result result = render_programs_choose_beside(device, &stream->view->shading, bits, 0, stream->beside,
	                                                    stream->kinds, frame_surfaces(stream), &surfaces);
	uint32_t list;
	if (result == STILB_OK)
		result = frame_list(device, stream, (frame_part){0, stream->run_count}, FRAME_DRAWS_PLAIN, surfaces, &list);
	if (result != STILB_OK)
		return result;
	stilb_gpu_pass row = frame_row(device, stream, list, " surfaces");
	frame_attach(stream, target, backdrop, &row);
	render_deferred_attach(device, stream->view, target, &row);
	render_target_attach(device, surfaces, target, &row);
	result = frame_images(device, stream, target, surfaces, &row);
	if (result != STILB_OK)
		return result;
	row_constants(&row, push, sizeof *push);
	stilb_gpu_plan_pass(device->plan, &row);
	target->drawn = true;
	result = frame_terms(device, stream, target, push);
	return result == STILB_OK ? render_deferred_lights(device, stream, target, push) : result;
}

/* Adds the row that draws depth, or, of a way that keeps surfaces and light apart, also normals, of what is plain. */
static stilb_result frame_depth(render_device *device, const render_stream *stream, render_frame_target *target,
                                const render_push *push)
{
	bool apart = render_view_way(device, stream->view).apart;
	uint32_t sides = stream->lights.bits & RENDER_LIGHTS_SIDES, list;
	render_formula_programs *choice;
	render_stream laid = *stream;
	laid.lights.bits = apart ? render_gbuffer_bits(stream->view, stream->lights.bits) : RENDER_LIGHTS_DEPTH | sides;
	stilb_result result = render_programs_choose(device, &stream->view->shading, laid.lights.bits, 0, stream->kinds,
	                                             frame_surfaces(stream), &choice);
	if (result == STILB_OK)
		result = frame_list(device, &laid, (frame_part){0, stream->run_count}, FRAME_DRAWS_PLAIN, choice, &list);
	if (result != STILB_OK)
		return result;
	stilb_gpu_pass row = frame_row(device, stream, list, apart ? " surfaces" : " depth");
	row.depth = (stilb_gpu_attachment){.image = target->depth, .load = STILB_GPU_LOAD_CLEAR};
	if (apart)
		render_deferred_attach(device, stream->view, target, &row);
	row_constants(&row, push, sizeof *push);
	stilb_gpu_plan_pass(device->plan, &row);
	return STILB_OK;
}

/* Adds the rows of what is plain in a scene pass that draws depth first, and what is seen after it. */
static stilb_result frame_laid(render_device *device, const render_stream *stream, render_frame_target *target,
                               bool backdrop, const render_push *push)
{
	render_formula_programs *seen;
	uint32_t bits = render_laid_bits(stream->view, stream->lights.bits), list;
	bool apart = bits & RENDER_LIGHTS_APART, lists = bits & (RENDER_LIGHTS_TILES | RENDER_LIGHTS_INDEXED);
	stilb_gpu_use tiles;
	stilb_result result = frame_depth(device, stream, target, push);
	if (result == STILB_OK)
		result = frame_terms(device, stream, target, push);
	if (result == STILB_OK && apart)
		result = render_deferred_lights(device, stream, target, push);
	if (result == STILB_OK && lists)
		result = render_tiles_make(device, stream, target, push, &tiles);
	if (result == STILB_OK)
		result = render_programs_choose_beside(device, &stream->view->shading, bits, stream->lights.shadow_bits,
		                                       stream->beside, stream->kinds, frame_surfaces(stream), &seen);
	if (result == STILB_OK)
		result = frame_list(device, stream, (frame_part){0, stream->run_count}, FRAME_DRAWS_PLAIN, seen, &list);
	if (result != STILB_OK)
		return result;
	stilb_gpu_pass row = frame_row(device, stream, list, "");
	frame_attach(stream, target, backdrop, &row);
	row.depth.load = STILB_GPU_LOAD_KEEP;
	row.depth.read_only = true;
	render_target_attach(device, seen, target, &row);
	result = frame_images(device, stream, target, seen, &row);
	if (result != STILB_OK)
		return result;
	if (apart)
		render_deferred_use(target, row.use_count, &row);
	if (lists)
		row.uses[row.use_count++] = tiles;
	render_cells_use(device, lists ? STILB_GPU_NO_SLOT : offsetof(render_push, view.lists), &row);
	row_constants(&row, push, sizeof *push);
	stilb_gpu_plan_pass(device->plan, &row);
	target->drawn = true;
	return STILB_OK;
}

/* Adds the rows of what is plain in a scene pass by its view's way of lighting. */
static stilb_result frame_plain(render_device *device, const render_stream *stream, render_frame_target *target,
                                bool backdrop, const render_push *push)
{
	const stilb_render_view *view = stream->view;
	render_way way = target->drawn ? (render_way){0} : render_view_way(device, view);
	render_formula_programs *choice;
	render_stream lit = *stream;
	if (lit.lights.terms > 0)
		lit.lights.shadow_bits = RENDER_SHADOW_BUFFER | RENDER_SHADOW_HDR * (uint32_t)target->hdr;
	if (way.surfaces)
		return frame_deferred(device, &lit, target, backdrop, push);
	if (way.laid)
		return frame_laid(device, &lit, target, backdrop, push);
	stilb_result result =
		render_programs_choose_beside(device, &view->shading, stream->lights.bits, stream->lights.shadow_bits,
	                                  stream->beside, stream->kinds, frame_surfaces(stream), &choice);
	if (result != STILB_OK)
		return result;
	return frame_is_multipass(stream) ? frame_multipass(device, stream, choice, target, backdrop, push)
	                                  : frame_rows(device, stream, FRAME_DRAWS_PLAIN, choice, target, backdrop, push);
}

/* Adds the row that draws the surroundings' light on what is plain alone, where its depth is. */
static stilb_result frame_around(render_device *device, const render_stream *stream, render_frame_target *target,
                                 const render_push *push)
{
	render_formula_programs *around;
	uint32_t bits = render_around_bits(stream->lights.bits), list;
	uint32_t beside = render_around_beside_bits(device, stream->view) | RENDER_BESIDE_ALONE;
	stilb_result result = render_programs_choose_beside(device, &stream->view->shading, bits, 0, beside, stream->kinds,
	                                                    frame_surfaces(stream), &around);
	if (result == STILB_OK)
		result = frame_list(device, stream, (frame_part){0, stream->run_count}, FRAME_DRAWS_PLAIN, around, &list);
	if (result != STILB_OK)
		return result;
	stilb_gpu_pass row = frame_row(device, stream, list, " ambient");
	row.depth = (stilb_gpu_attachment){.image = target->depth, .load = STILB_GPU_LOAD_KEEP, .read_only = true};
	render_target_attach(device, around, target, &row);
	result = frame_images(device, stream, target, around, &row);
	row_constants(&row, push, sizeof *push);
	if (result == STILB_OK)
		stilb_gpu_plan_pass(device->plan, &row);
	return result;
}

/* Adds the rows of what is plain whose light of the surroundings is apart: all other light and that, and the sum. */
static stilb_result frame_apart(render_device *device, const render_stream *stream, render_frame_target *target,
                                bool backdrop, const render_push *push)
{
	bool alone = !(stream->beside & RENDER_BESIDE_AROUND), main = target == render_target_main(device);
	render_stream rest = *stream;
	if (alone)
		rest.lights.bits = render_unlit_around_bits(stream->lights.bits);
	stilb_result result = frame_plain(device, &rest, target, backdrop, push);
	if (result == STILB_OK && alone)
		result = frame_around(device, stream, target, push);
	uint16_t parts[2] = {target->beside[RENDER_BESIDE_IMAGE_AMBIENT], target->beside[RENDER_BESIDE_IMAGE_REFLECTION]};
	if (result == STILB_OK && main)
		result = frame_stage(device, STILB_RENDER_STAGE_AMBIENT, &parts[0]);
	if (result == STILB_OK && main)
		result = frame_stage(device, STILB_RENDER_STAGE_REFLECTION, &parts[1]);
	return result == STILB_OK ? render_around_add(device, target, parts) : result;
}

/* True if some of the stream's surfaces have one of these RENDER_MAPS_... */
static bool frame_has_maps(const render_device *device, const render_stream *stream, uint64_t bits)
{
	for (uint32_t r = 0; r < stream->run_count; r++) {
		uint64_t state = stream->runs[r].state;
		if (state & RENDER_STATE_MAPS && device->maps[render_state_group(state)].bits & bits)
			return true;
	}
	return false;
}

/* Adds the row that draws the depth of what blends, if the stream has some. */
static stilb_result frame_blended(render_device *device, const render_stream *stream, const render_frame_target *target,
                                  const render_push *push)
{
	if (!stream->view->blended || target != render_target_main(device) || device->samples > 1 ||
	    stilb_gpu_plan_find(device->plan, STILB_RENDER_IMAGE_BLENDED_DEPTH) != 0 ||
	    !frame_has_maps(device, stream, RENDER_MAPS_BLEND))
		return STILB_OK;
	render_formula_programs *choice;
	render_stream laid = *stream;
	laid.lights.bits = RENDER_LIGHTS_DEPTH | (stream->lights.bits & RENDER_LIGHTS_SIDES);
	uint32_t list;
	stilb_result result = render_programs_choose(device, &stream->view->shading, laid.lights.bits, 0, stream->kinds,
	                                             frame_surfaces(stream), &choice);
	if (result == STILB_OK)
		result = frame_list(device, &laid, (frame_part){0, stream->run_count}, FRAME_DRAWS_BLENDED, choice, &list);
	if (result != STILB_OK)
		return result;
	stilb_gpu_pass row = frame_row(device, stream, list, " blended depth");
	row.depth = (stilb_gpu_attachment){
		.image = render_target_image(device, target, STILB_RENDER_IMAGE_BLENDED_DEPTH, STILB_GPU_D32_F, false),
		.load = STILB_GPU_LOAD_CLEAR};
	row_constants(&row, push, sizeof *push);
	stilb_gpu_plan_pass(device->plan, &row);
	return STILB_OK;
}

/* What the rows of a scene pass that draw surfaces draw beside the picture. The first pass into a target decides
 * whether rows of their own draw what is seen. */
static uint32_t frame_beside(const render_device *device, const stilb_render_view *view,
                             const render_frame_target *target)
{
	uint32_t bits = target->color != 0 ? render_beside_bits(device, view) : 0;
	bool begun = target->beside[RENDER_BESIDE_IMAGE_VELOCITY] != 0;
	if (begun && target->velocity_depth != 0)
		bits &= ~RENDER_BESIDE_SEEN;
	return target->drawn ? bits & RENDER_BESIDE_SEEN : bits;
}

/* Adds the rows that come before those that draw a scene pass whose view has `last`. */
static stilb_result frame_seen(render_device *device, const render_stream *stream, render_frame_target *target,
                               const render_push *push)
{
	bool begun = target->beside[RENDER_BESIDE_IMAGE_VELOCITY] != 0;
	stilb_result result = render_velocity_begin(device, stream, push->view.rest, target);
	if (result != STILB_OK)
		return result;
	if (stream->beside & RENDER_BESIDE_VELOCITY) {
		if (stream->view->surfaces)
			stilb_gpu_plan_show(device->plan, target->depth); /* it is read with them */
		return STILB_OK;
	}
	bool alone = !begun || target->velocity_depth != 0;
	return alone ? frame_velocity(device, stream, target, push) : STILB_OK;
}

static stilb_result frame_scene_into(render_device *device, const render_stream *pass, render_frame_target *target)
{
	render_stream drawn = *pass;
	const render_stream *stream = &drawn;
	const stilb_render_view *view = stream->view;
	render_formula_programs *choice;
	bool backdrop = !target->drawn && target->color != 0 && render_view_is_lit(view) && !render_view_counts(view) &&
	                render_backdrop_is_drawn(view, stream->panorama);
	uint32_t surfaces = frame_surfaces(stream);
	drawn.beside = frame_beside(device, view, target);
	stilb_result result =
		render_programs_choose_beside(device, &view->shading, stream->lights.bits, stream->lights.shadow_bits,
	                                  stream->beside & RENDER_BESIDE_SEEN, stream->kinds, surfaces, &choice);
	if (result == STILB_OK && !target->drawn)
		result = frame_first(device, stream, target, backdrop);
	if (result != STILB_OK)
		return result;
	const render_slot *slot = render_slot_now(device);
	render_push push = {
		.view = frame_write_view(device, stream, view->area[2] > 0 ? view->area[2] : target->width,
	                             view->area[3] > 0 ? view->area[3] : target->height, target->exposure),
		.rows = stream->rows ? stream->rows->address : 0,
		.frame_rows = slot->memory[RENDER_MEMORY_ROWS].address,
		.materials = device->heaps[RENDER_HEAP_MATERIALS].address,
		.vertices = device->heaps[RENDER_HEAP_VERTICES].address,
	};
	result = render_cells_make(device, stream);
	if (result == STILB_OK && view->last && target->color != 0)
		result = frame_seen(device, stream, target, &push);
	if (result != STILB_OK)
		return result;
	if (view->show == STILB_RENDER_SHOW_ATLAS && target == render_target_main(device) && view->shadows &&
	    view->shadows->map_count > 0)
		device->frame.atlas = render_target_get(device, view->shadows->target, STILB_RENDER_HDR_HALF)->depth;
	bool apart = !target->drawn && render_view_is_apart(device, view);
	render_way way = target->drawn ? (render_way){0} : render_view_way(device, view);
	result = frame_blended(device, stream, target, &push);
	if (result != STILB_OK)
		return result;
	if (!apart && !way.surfaces && !way.laid && !frame_is_multipass(stream))
		return frame_rows(device, stream, FRAME_DRAWS_ALL, choice, target, backdrop, &push);
	result = apart ? frame_apart(device, stream, target, backdrop, &push)
	               : frame_plain(device, stream, target, backdrop, &push);
	return result == STILB_OK ? frame_rows(device, stream, FRAME_DRAWS_OTHERS, choice, target, backdrop, &push)
	                          : result;
}

/* What the stream's light can be kept in. Surfaces that blend add to the light behind them, and two colours encoded in
 * 8 bits cannot be added: with such surfaces it stays half floats. */
static stilb_render_hdr frame_hdr(const render_device *device, const render_stream *stream)
{
	stilb_render_hdr hdr = render_view_hdr(stream->view);
	bool kept =
		hdr == STILB_RENDER_HDR_HALF || !frame_has_maps(device, stream, RENDER_MAPS_BLEND | RENDER_MAPS_THROUGH);
	return kept ? hdr : STILB_RENDER_HDR_HALF;
}

static stilb_result frame_scene(render_device *device, const render_stream *stream)
{
	render_stream kept = *stream;
	stilb_render_hdr hdr = frame_hdr(device, stream);
	render_frame_target *target = render_target_get(device, stream->view->target, hdr);
	if (target->result != STILB_OK)
		return target->result;
	if (target->hdr != hdr && target->hdr != STILB_RENDER_HDR_HALF)
		return stilb_fail(
			STILB_ERROR_ARGUMENT,
			"pass '%s' blends or adds light, which earlier passes have kept in 8 bits; let all views into "
			"the main images keep it in half floats",
			stream->pass->name ? stream->pass->name : "pass");
	kept.lights.shadow_bits =
		(stream->lights.shadow_bits & (RENDER_SHADOW_HDR - 1)) | RENDER_SHADOW_HDR * (uint32_t)target->hdr;
	return frame_scene_into(device, &kept, target);
}

static stilb_result frame_2d(render_device *device, const render_stream *stream)
{
	render_frame *frame = &device->frame;
	uint32_t list;
	stilb_result result = frame_end_scene(device);
	if (result != STILB_OK || (frame->shown && stream->draws == 0))
		return result;
	result = frame_list(device, stream, (frame_part){0, stream->run_count}, FRAME_DRAWS_ALL, NULL, &list);
	if (result != STILB_OK)
		return result;
	stilb_gpu_pass row = frame_row(device, stream, list, "");
	row.color_count = 1;
	row.color[0] = (stilb_gpu_attachment){
		.image = frame->picture,
		.load = frame->shown ? STILB_GPU_LOAD_KEEP : STILB_GPU_LOAD_CLEAR,
		.clear = {0.0f, 0.0f, 0.0f, 1.0f},
	};
	render_push_2d push = {
		.scale = {2.0f / (float)device->width, 2.0f / (float)device->height},
		.rows = render_slot_now(device)->memory[RENDER_MEMORY_ROWS].address,
	};
	row_constants(&row, &push, sizeof push);
	stilb_gpu_plan_pass(device->plan, &row);
	frame->shown = true;
	return STILB_OK;
}

/* The picture of a frame that shows nothing. */
static void frame_black(render_device *device)
{
	render_frame *frame = &device->frame;
	stilb_gpu_plan_pass(
		device->plan,
		&(stilb_gpu_pass){
			.name = "black",
			.kind = STILB_GPU_PASS_DRAWS,
			.color_count = 1,
			.color = {{.image = frame->picture, .load = STILB_GPU_LOAD_CLEAR, .clear = {0.0f, 0.0f, 0.0f, 1.0f}}},
			.draws = render_target_nothing(device),
		});
	frame->shown = true;
}

stilb_result render_device_pass(render_device *device, const render_stream *stream)
{
	bool scene = stream->pass->kind == STILB_RENDER_PASS_SCENE;
	STILB_ASSERT(scene == (bool)stream->view);
	stilb_result result = device->frame.begun ? STILB_OK : frame_begin(device);
	if (result != STILB_OK)
		return result;
	return scene ? frame_scene(device, stream) : frame_2d(device, stream);
}

/* ---- running ----------------------------------------------------------------------------------------------------- */

typedef struct frame_threads {
	stilb_job_pool *pool;
	uint32_t worker;
	void (*task)(uint32_t index, void *context);
	void *context;
} frame_threads;

static void frame_slice(uint32_t begin, uint32_t end, uint32_t worker, void *user)
{
	const frame_threads *threads = user;
	(void)worker;
	for (uint32_t i = begin; i < end; i++)
		threads->task(i, threads->context);
}

static void frame_run_tasks(void *user, uint32_t count, void (*task)(uint32_t index, void *context), void *context)
{
	frame_threads *threads = user;
	threads->task = task;
	threads->context = context;
	stilb_job_parallel_for(threads->pool, count, 1, frame_slice, threads, threads->worker);
}

stilb_result render_device_run(render_device *device, stilb_job_pool *pool, uint32_t worker)
{
	render_frame *frame = &device->frame;
	STILB_ASSERT(frame->begun && "replay has at least one pass");
	device->drawn = device->lit = false;
	stilb_result result = frame_end_scene(device);
	if (result == STILB_OK && !frame->shown)
		frame_black(device);
	uint16_t last = frame->picture;
	if (result == STILB_OK)
		result = frame_stage(device, STILB_RENDER_STAGE_LAST, &last);
	if (result == STILB_OK && device->until[0] != '\0')
		result = render_until(device);
	if (result != STILB_OK)
		return result;
	for (uint32_t l = 0; l < frame->list_count; l++)
		if (!device->draws[l].runs && device->draws[l].run_count > 0) /* features' have their own */
			device->draws[l].runs = device->runs + device->lists[l].first_run;
	frame_threads work = {.pool = pool, .worker = worker};
	stilb_gpu_threads threads = {&work, pool ? stilb_job_pool_worker_count(pool) + 1 : 0, frame_run_tasks};
	stilb_gpu_planner planner = stilb_gpu_planner_of(device->gpu);
	result = stilb_gpu_plan_make(device->plan, &planner);
	if (result == STILB_OK) {
		result = stilb_gpu_frame_run(device->gpu, device->plan, device->draws, frame->list_count, &threads);
		if (result != STILB_OK || device->gpu->keep_back)
			stilb_gpu_plan_dropped(device->plan);
	}
	if (result != STILB_OK || device->gpu->keep_back)
		render_cells_forget(device);
	if (result != STILB_OK)
		return result;
	stilb_gpu_stats stats = stilb_gpu_stats_get(device->gpu);
	device->stats.draw_commands += stats.draw_commands;
	device->stats.indirect_commands += stats.indirect_commands;
	device->stats.execute_commands += stats.execute_commands;
	device->stats.binds_sent += stats.binds;
	device->drawn = !device->gpu->keep_back;
	const render_frame_target *main = render_target_main(device);
	device->stats.hdr = main ? main->hdr : STILB_RENDER_HDR_HALF;
	device->lit = device->drawn && main && stilb_gpu_plan_ready(device->plan, main->color, 0, 0);
	return STILB_OK;
}
