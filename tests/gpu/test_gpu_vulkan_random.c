/* Random plans on the Vulkan device, under validation with synchronization checks: images with mips, layers, faces and
 * samples, buffers, all kinds of passes, what is kept from the last frame, what the program owns and uploads to, odd
 * sizes, and frames that are dropped. Each output is read back, at once or some frames later, and compared with what
 * the CPU works out (gpu_mix.h). STILB_RANDOM_PLANS=N runs N plans in place of a thousand. */
#include "gpu_mix.h"

#include "gpu/gpu_internal.h"
#include "support/test.h"

#include <stdlib.h>
#include <string.h>
#include <vulkan/vulkan.h>

#define SHADER(code)                                                                                                   \
	{                                                                                                                  \
		.words = code, .bytes = sizeof code                                                                            \
	}

static const uint32_t flat_frag[] =
#include "random_flat.frag.inc"
	;
static const uint32_t two_frag[] =
#include "random_two.frag.inc"
	;
static const uint32_t color_frag[] =
#include "random_color.frag.inc"
	;
static const uint32_t flat_comp[] =
#include "random_flat.comp.inc"
	;
static const uint32_t array_comp[] =
#include "random_array.comp.inc"
	;

#define PASSES 9u /* random ones of a frame */
#define READS 256u

/* Things in the order of their rows. */
enum { F0, F1, F2, C0, C1, Q0, Q1, S0, S1, B0, B1, OF, OC, OA, OQ, OB, THINGS };
static const char *const names[THINGS] = {"flat0",     "flat1",     "flat2",    "color0",    "color1",  "cube0",
                                          "cube1",     "samples0",  "samples1", "buffer0",   "buffer1", "own_flat",
                                          "own_color", "own_array", "own_cube", "own_buffer"};
static const mix_kind kinds[THINGS] = {MIX_FLAT,  MIX_FLAT,    MIX_FLAT,    MIX_COLOR,  MIX_COLOR,  MIX_CUBE,
                                       MIX_CUBE,  MIX_SAMPLES, MIX_SAMPLES, MIX_BUFFER, MIX_BUFFER, MIX_FLAT,
                                       MIX_COLOR, MIX_FLAT,    MIX_CUBE,    MIX_BUFFER};
/* What stands in for an input that no thing of a frame offers. */
static const uint32_t stand_in[MIX_INPUTS] = {OF, OC, OA, OQ, S0, OB};

/* A read-back that was not waited for, and what it must give. */
typedef struct pending {
	uint64_t ticket, frame;
	uint32_t *wanted, count, age, mip, layer;
	const char *name;
} pending;

static struct {
	stilb_gpu *gpu;
	stilb_gpu_plan *plan;
	stilb_gpu_program flat, two, color, compute, compute_array;
	stilb_gpu_sampler all_mips;
	mix_thing things[THINGS];
	uint32_t width, height; /* of the picture */
	uint64_t seed, index;
	uint32_t number;                /* of passes so far */
	uint8_t busy[THINGS][MIX_SUBS]; /* by the pass: 1 read, 2 written */
	pending reads[READS];
	uint64_t reads_begun, plans, passes, dropped, handed_over;
} w;

static uint32_t pick(uint32_t below)
{
	return (uint32_t)(stilb_random_u64(w.seed, w.index++) % below);
}

static bool chance(uint32_t percent)
{
	return pick(100) < percent;
}

/* ---- things ------------------------------------------------------------------------------------------------------ */

static uint32_t width_of(const mix_thing *t, uint32_t mip)
{
	return mix_side(t->width, mip);
}

static uint32_t texels_of(const mix_thing *t, uint32_t mip)
{
	return width_of(t, mip) * mix_side(t->height, mip);
}

static bool is_words(const mix_thing *t) /* r32_ui */
{
	return t->kind == MIX_FLAT || t->kind == MIX_CUBE;
}

/* New sizes for all that the program does not own. */
static void things_resize(void)
{
	/* Few are powers of two, for which Mesa's software device has shaders of their own. */
	static const uint32_t sizes[][2] = {{33, 9}, {5, 11}, {61, 13}, {1, 1}, {4099, 3}, {3, 4099}};
	uint32_t size = chance(80) ? pick(3) : 3 + pick(3);
	w.width = sizes[size][0];
	w.height = sizes[size][1];
	for (uint32_t i = 0; i < OF; i++) {
		mix_thing *t = &w.things[i];
		static const uint32_t cubes[] = {5, 6, 7};
		uint32_t side = chance(5) ? 1 : cubes[pick(3)];
		bool share = t->kind != MIX_CUBE && chance(70), half = chance(20);
		t->width = t->kind == MIX_BUFFER ? MIX_WORDS : share ? (half ? (w.width + 1) / 2 : w.width) : side;
		t->height = t->kind == MIX_BUFFER ? 1 : share ? (half ? (w.height + 1) / 2 : w.height) : side;
		uint32_t most = 32u - (uint32_t)__builtin_clz(t->width > t->height ? t->width : t->height);
		bool plain = t->kind == MIX_BUFFER || t->kind == MIX_SAMPLES;
		t->mips = plain ? 1 : 1 + pick(most < 3 ? most : 3);
		t->layers = t->kind == MIX_CUBE ? 6 : t->kind == MIX_BUFFER ? 1 : 1 + pick(3);
		t->keep = chance(35);
	}
}

static void thing_add(mix_thing *t)
{
	if (t->kind == MIX_BUFFER) {
		t->id = stilb_gpu_plan_buffer(
			w.plan,
			&(stilb_gpu_plan_buffer_row){
				.name = t->name, .bytes = 4 * MIX_WORDS, .keep = t->keep, .output = t->output, .owned = t->owned});
		return;
	}
	t->id = stilb_gpu_plan_image(
		w.plan, &(stilb_gpu_plan_image_row){.name = t->name,
	                                        .format = is_words(t) ? STILB_GPU_R32_UI : STILB_GPU_RGBA8_U,
	                                        .shape = t->kind == MIX_CUBE ? STILB_GPU_SHAPE_CUBE : STILB_GPU_SHAPE_2D,
	                                        .width = t->width,
	                                        .height = t->height,
	                                        .layers = (uint16_t)t->layers,
	                                        .mips = (uint16_t)t->mips,
	                                        .samples = t->kind == MIX_SAMPLES ? 4 : 1,
	                                        .keep = t->keep,
	                                        .output = t->output,
	                                        .owned = t->owned});
}

/* The frame's rows of images and buffers, and what last frame has left of them. */
static void things_begin(void)
{
	for (uint32_t i = 0; i < THINGS; i++) {
		mix_thing *t = &w.things[i];
		t->output = t->kind != MIX_SAMPLES && chance(i < OF ? 30 : 15);
		thing_add(t);
		bool kept = t->keep && stilb_gpu_plan_kept(w.plan, t->id);
		for (uint32_t s = 0; s < t->mips * t->layers; s++) {
			t->written[s] = t->owned != 0;
			if (t->keep && !kept)
				memset(t->before[s], 0, texels_of(t, s % t->mips) * sizeof(uint32_t));
		}
	}
}

/* The frame has run: what it wrote is last frame's. */
static void things_end(void)
{
	for (uint32_t i = 0; i < THINGS; i++) {
		mix_thing *t = &w.things[i];
		bool any = false;
		for (uint32_t s = 0; s < t->mips * t->layers; s++)
			any = any || t->written[s];
		for (uint32_t s = 0; t->keep && any && s < t->mips * t->layers; s++) {
			size_t bytes = texels_of(t, s % t->mips) * sizeof(uint32_t);
			if (t->written[s])
				memcpy(t->before[s], t->now[s], bytes);
			else
				memset(t->before[s], 0, bytes);
		}
	}
}

/* ---- what a pass reads and writes -------------------------------------------------------------------------------- */

static bool range_is(const mix_thing *t, const mix_input *in, bool (*is)(uint32_t thing, uint32_t sub))
{
	for (uint32_t layer = in->layer; layer < in->layer + in->layers; layer++)
		for (uint32_t mip = in->mip; mip < in->mip + in->mips; mip++)
			if (!is((uint32_t)(t - w.things), mix_sub(t, mip, layer)))
				return false;
	return true;
}

static bool sub_readable(uint32_t thing, uint32_t sub)
{
	return w.things[thing].written[sub] && w.busy[thing][sub] != 2;
}

static bool sub_written(uint32_t thing, uint32_t sub)
{
	return w.things[thing].written[sub];
}

static bool sub_free(uint32_t thing, uint32_t sub)
{
	return w.busy[thing][sub] == 0;
}

static void range_busy(const mix_thing *t, const mix_input *in, uint8_t how)
{
	for (uint32_t layer = in->layer; layer < in->layer + in->layers; layer++)
		for (uint32_t mip = in->mip; mip < in->mip + in->mips; mip++)
			w.busy[t - w.things][mix_sub(t, mip, layer)] = how;
}

/* A random range of a thing that an input's binding can be. False: it has none. */
static bool input_range(uint32_t binding, const mix_thing *t, mix_input *in)
{
	*in = (mix_input){.thing = t, .mips = 1, .layers = 1};
	in->mip = pick(t->mips);
	switch (binding) {
	case MIX_INPUT_FLAT:
		in->layer = pick(t->layers);
		return is_words(t);
	case MIX_INPUT_COLOR:
		in->layer = pick(t->layers);
		return t->kind == MIX_COLOR;
	case MIX_INPUT_ARRAY:
		if (!is_words(t) || t->layers < 2)
			return false;
		in->mips = 1 + pick(t->mips - in->mip);
		in->layer = pick(t->layers - 1);
		in->layers = 2 + pick(t->layers - in->layer - 1);
		return t->kind != MIX_CUBE || in->layers < 6; /* all six are a cube */
	case MIX_INPUT_CUBE:
		in->mips = 1 + pick(t->mips - in->mip);
		in->layers = 6;
		return t->kind == MIX_CUBE;
	case MIX_INPUT_SAMPLES:
		in->layer = pick(t->layers);
		return t->kind == MIX_SAMPLES;
	default:
		return t->kind == MIX_BUFFER;
	}
}

/* any: of any thing, else of the one that stands in. */
static bool pick_input(uint32_t binding, bool any, mix_input *in)
{
	for (uint32_t try = any ? 0 : 11; try < 12; try++) {
		const mix_thing *t = &w.things[try < 11 ? pick(THINGS) : stand_in[binding]];
		if (!input_range(binding, t, in))
			continue;
		bool readable = range_is(t, in, sub_readable);
		in->previous = t->keep && (!readable || chance(30));
		if (!in->previous && !readable)
			continue;
		if (!in->previous)
			range_busy(t, in, 1);
		return true;
	}
	return false;
}

/* A random range of one mip, of a thing for which `kind` holds, that the pass does not touch yet. */
static bool pick_target(bool (*fits)(const mix_thing *t), uint32_t layers, mix_input *out)
{
	for (uint32_t try = 0; try < 8; try++) {
		mix_thing *t = &w.things[pick(THINGS)];
		if (!fits(t) || t->layers < layers)
			continue;
		*out = (mix_input){.thing = t, .mip = pick(t->mips), .mips = 1, .layers = layers};
		out->layer = pick(t->layers - layers + 1);
		if (!range_is(t, out, sub_free))
			continue;
		range_busy(t, out, 2);
		return true;
	}
	return false;
}

static bool fits_color(const mix_thing *t)
{
	return t->kind == MIX_COLOR;
}

static bool fits_samples(const mix_thing *t)
{
	return t->kind == MIX_SAMPLES;
}

static bool fits_image(const mix_thing *t)
{
	return t->kind != MIX_BUFFER;
}

static bool fits_buffer(const mix_thing *t)
{
	return t->kind == MIX_BUFFER;
}

static mix_thing *thing_of(const mix_input *in)
{
	return &w.things[in->thing - w.things];
}

/* The values that a pass has written to one mip and layer. */
static void write_values(const mix_input *target, uint32_t layer, const uint32_t *values)
{
	mix_thing *t = thing_of(target);
	uint32_t sub = mix_sub(t, target->mip, target->layer + layer);
	memcpy(t->now[sub], values, texels_of(t, target->mip) * sizeof *values);
	t->written[sub] = true;
}

static uint32_t target_width(const mix_input *in)
{
	return width_of(in->thing, in->mip);
}

static uint32_t target_height(const mix_input *in)
{
	return mix_side(in->thing->height, in->mip);
}

static bool same_size(const mix_input *a, const mix_input *b)
{
	return target_width(a) == target_width(b) && target_height(a) == target_height(b);
}

static void add_use(stilb_gpu_pass *pass, const mix_input *in, stilb_gpu_use_kind how, uint32_t slot)
{
	bool buffer = in->thing->kind == MIX_BUFFER;
	pass->uses[pass->use_count++] = (stilb_gpu_use){.resource = in->thing->id,
	                                                .how = (uint8_t)how,
	                                                .previous = in->previous,
	                                                .slot = (uint16_t)slot,
	                                                .mip = (uint8_t)in->mip,
	                                                .mips = buffer ? 0 : (uint8_t)in->mips,
	                                                .layer = (uint16_t)in->layer,
	                                                .layers = buffer ? 0 : (uint16_t)in->layers};
}

/* Gives a pass its inputs and constants. False: there are none, and the pass cannot be. */
static bool add_inputs(stilb_gpu_pass *pass, mix_input inputs[MIX_INPUTS])
{
	/* Two images are any: Mesa's software device compiles a shader anew for each combination of kinds of images. */
	uint32_t first = pick(MIX_INPUT_BUFFER), second = pick(MIX_INPUT_BUFFER);
	for (uint32_t i = 0; i < MIX_INPUTS; i++) {
		if (!pick_input(i, i == first || i == second || i == MIX_INPUT_BUFFER, &inputs[i]))
			return false;
		bool buffer = i == MIX_INPUT_BUFFER;
		add_use(pass, &inputs[i], buffer ? STILB_GPU_USE_STORAGE_READ : STILB_GPU_USE_SAMPLED, buffer ? 0 : i);
		pass->uses[pass->use_count - 1].sampler = i == MIX_INPUT_CUBE ? w.all_mips.id : 0;
	}
	w.number++;
	pass->constant_bytes = 20;
	memcpy(pass->constants + 16, &w.number, sizeof w.number);
	return true;
}

static void add_pass(const stilb_gpu_pass *pass)
{
	stilb_gpu_plan_pass(w.plan, pass);
	w.passes++;
}

static stilb_gpu_attachment attachment_of(const mix_input *in, stilb_gpu_load load)
{
	return (stilb_gpu_attachment){.image = in->thing->id,
	                              .mip = (uint8_t)in->mip,
	                              .layer = (uint16_t)in->layer,
	                              .layers = (uint16_t)in->layers,
	                              .load = (uint8_t)load};
}

/* ---- passes ------------------------------------------------------------------------------------------------------ */

static uint32_t values[MIX_TEXELS];

static void make_values(const mix_input inputs[MIX_INPUTS], const mix_input *target, uint32_t layer)
{
	mix_values(inputs, w.number, layer, target_width(target), target_height(target), values);
}

/* One triangle over one or two attachments of words. */
static void random_flat(void)
{
	mix_input target, second, inputs[MIX_INPUTS];
	if (!pick_target(is_words, 1, &target))
		return;
	bool two = chance(40) && pick_target(is_words, 1, &second) && same_size(&target, &second);
	stilb_gpu_pass pass = {.name = "flat",
	                       .kind = STILB_GPU_PASS_FULLSCREEN,
	                       .color = {attachment_of(&target, STILB_GPU_LOAD_DISCARD)},
	                       .color_count = two ? 2 : 1,
	                       .program = two ? w.two.id : w.flat.id};
	if (two)
		pass.color[1] = attachment_of(&second, STILB_GPU_LOAD_CLEAR);
	if (!add_inputs(&pass, inputs))
		return;
	add_pass(&pass);
	make_values(inputs, &target, 0);
	write_values(&target, 0, values);
	for (uint32_t i = 0; two && i < texels_of(target.thing, target.mip); i++)
		values[i] = mix_step(values[i], 1);
	if (two)
		write_values(&second, 0, values);
}

/* One triangle over bytes, of one sample, or of four that may be resolved. */
static void random_color(void)
{
	mix_input target, resolved, inputs[MIX_INPUTS];
	bool many = chance(60);
	if (!pick_target(many ? fits_samples : fits_color, 1, &target))
		return;
	stilb_gpu_pass pass = {.name = many ? "samples" : "color",
	                       .kind = STILB_GPU_PASS_FULLSCREEN,
	                       .color = {attachment_of(&target, STILB_GPU_LOAD_DISCARD)},
	                       .color_count = 1,
	                       .program = w.color.id};
	/* Mesa's software device resolves the first layer alone; others are an error there. */
	bool resolves = many && target.layer == 0 && chance(70) && pick_target(fits_color, 1, &resolved) &&
	                resolved.mip == 0 && resolved.layer == 0 && same_size(&target, &resolved);
	if (resolves)
		pass.color[0].resolve = resolved.thing->id;
	if (!add_inputs(&pass, inputs))
		return;
	add_pass(&pass);
	make_values(inputs, &target, 0);
	write_values(&target, 0, values);
	if (resolves)
		write_values(&resolved, 0, values);
}

/* A dispatch into one layer or several, and into a buffer. */
static void random_dispatch(void)
{
	mix_input target, words, inputs[MIX_INPUTS];
	bool array = chance(40);
	if (!pick_target(is_words, array ? 2 + pick(5) : 1, &target) || !pick_target(fits_buffer, 1, &words))
		return;
	stilb_gpu_pass pass = {
		.name = array ? "layers" : "dispatch",
		.kind = STILB_GPU_PASS_DISPATCH,
		.program = array ? w.compute_array.id : w.compute.id,
		.groups = {(target_width(&target) + 7) / 8, (target_height(&target) + 7) / 8, target.layers}};
	if (!add_inputs(&pass, inputs))
		return;
	add_use(&pass, &target, STILB_GPU_USE_STORAGE_WRITE, 5);
	add_use(&pass, &words, STILB_GPU_USE_STORAGE_WRITE, 8);
	add_pass(&pass);
	uint32_t first = 0;
	for (uint32_t layer = 0; layer < target.layers; layer++) {
		make_values(inputs, &target, layer);
		write_values(&target, layer, values);
		first = layer == 0 ? values[0] : first;
	}
	for (uint32_t i = 0; i < MIX_WORDS; i++)
		values[i] = mix_step(first, i);
	write_values(&words, 0, values);
}

/* Texels of some layers as they are, or bytes between a buffer and one layer. */
static void random_copy(void)
{
	mix_input from = {.thing = &w.things[pick(THINGS)], .mips = 1, .layers = 1}, to;
	const mix_thing *t = from.thing;
	if (t->kind == MIX_SAMPLES)
		return;
	from.mip = pick(t->mips);
	from.layer = pick(t->layers);
	from.layers = 1 + pick(t->layers - from.layer);
	bool from_buffer = t->kind == MIX_BUFFER;
	bool bytes = chance(40);
	if (!pick_target(bytes         ? (from_buffer ? is_words : fits_buffer)
	                 : from_buffer ? fits_buffer
	                 : is_words(t) ? is_words
	                               : fits_color,
	                 bytes ? 1 : from.layers, &to))
		return;
	from.layers = to.layers;
	from.previous = t->keep && chance(40);
	if (!from.previous && !range_is(t, &from, sub_readable))
		return;
	uint32_t taken = texels_of(t, from.mip), room = texels_of(to.thing, to.mip);
	bool to_buffer = to.thing->kind == MIX_BUFFER;
	if (from_buffer != to_buffer ? from_buffer ? taken < room : taken > room : !same_size(&from, &to))
		return;
	/* What a copy leaves of a buffer is there only if it was written before. */
	if (to_buffer && taken < room && !range_is(to.thing, &to, sub_written))
		return;
	stilb_gpu_pass pass = {.name = "copy", .kind = STILB_GPU_PASS_COPY};
	add_use(&pass, &from, STILB_GPU_USE_COPY_FROM, 0);
	add_use(&pass, &to, STILB_GPU_USE_COPY_TO, 0);
	add_pass(&pass);
	for (uint32_t layer = 0; layer < to.layers; layer++) {
		uint32_t sub = mix_sub(t, from.mip, from.layer + layer), count = taken < room ? taken : room;
		memcpy(values, thing_of(&to)->now[mix_sub(to.thing, to.mip, to.layer + layer)], room * sizeof *values);
		memcpy(values, from.previous ? t->before[sub] : t->now[sub], count * sizeof *values);
		write_values(&to, layer, values);
	}
}

/* Draws nothing: the target's layers are cleared, or stay. */
static void clear_pass(const mix_input *target, bool keep)
{
	static const stilb_gpu_load loads[] = {STILB_GPU_LOAD_CLEAR, STILB_GPU_LOAD_KEEP};
	stilb_gpu_pass pass = {.name = keep ? "nothing" : "clear",
	                       .kind = STILB_GPU_PASS_DRAWS,
	                       .color = {attachment_of(target, loads[keep])},
	                       .color_count = 1};
	uint32_t code = pick(256);
	bool words = is_words(target->thing);
	for (uint32_t c = 0; c < 4; c++)
		pass.color[0].clear[c] = words ? (float)code : (float)code / 255.0f;
	add_pass(&pass);
	for (uint32_t i = 0; i < texels_of(target->thing, target->mip); i++)
		values[i] = words ? code : code * 0x1010101u;
	for (uint32_t layer = 0; layer < target->layers && !keep; layer++)
		write_values(target, layer, values);
}

static void random_clear(void)
{
	mix_input target;
	if (!pick_target(fits_image, 1 + pick(2), &target))
		return;
	clear_pass(&target, range_is(target.thing, &target, sub_written) && chance(50));
}

/* Outputs must be written. */
static void write_outputs(void)
{
	for (uint32_t i = 0; i < THINGS; i++) {
		const mix_thing *t = &w.things[i];
		bool any = !t->output;
		for (uint32_t s = 0; s < t->mips * t->layers; s++)
			any = any || t->written[s];
		mix_input target = {.thing = t, .mips = 1, .layers = t->layers}, own = {.thing = &w.things[OB]};
		if (any)
			continue;
		if (t->kind != MIX_BUFFER) {
			clear_pass(&target, false);
			continue;
		}
		stilb_gpu_pass pass = {.name = "copy", .kind = STILB_GPU_PASS_COPY};
		add_use(&pass, &own, STILB_GPU_USE_COPY_FROM, 0);
		add_use(&pass, &target, STILB_GPU_USE_COPY_TO, 0);
		add_pass(&pass);
		write_values(&target, 0, own.thing->now[0]);
	}
}

/* ---- read-back and uploads --------------------------------------------------------------------------------------- */

static void read_end(pending *r, const uint32_t *bytes, uint64_t frame)
{
	assert_int_equal(frame, r->frame);
	for (uint32_t i = 0; i < r->count; i++)
		if (bytes[i] != r->wanted[i])
			fail_msg("seed %llu: texel %u of mip %u, layer %u of %s of frame %llu is %#x, and not %#x",
			         (unsigned long long)w.seed, i, r->mip, r->layer, r->name, (unsigned long long)frame, bytes[i],
			         r->wanted[i]);
	stilb_gpu_read_end(w.gpu, r->ticket);
	free(r->wanted);
	*r = (pending){0};
}

/* Looks after reads that are under way; waits for those that are three frames old, or for all. */
static void reads_poll(bool all)
{
	for (uint32_t i = 0; i < READS; i++) {
		pending *r = &w.reads[i];
		const void *bytes = NULL;
		uint64_t frame;
		if (r->ticket == 0)
			continue;
		r->age++;
		if (stilb_gpu_read_get(w.gpu, r->ticket, all || r->age > 3, &bytes, &frame) != STILB_OK)
			fail_msg("%s", stilb_error_message());
		if (bytes)
			read_end(r, bytes, frame);
	}
}

static void reads_begin(void)
{
	for (uint32_t i = 0, free_at = 0; i < THINGS; i++) {
		const mix_thing *t = &w.things[i];
		for (uint32_t s = 0; t->output && s < t->mips * t->layers; s++) {
			uint32_t mip = s % t->mips, layer = s / t->mips;
			assert_int_equal(stilb_gpu_plan_ready(w.plan, t->id, (uint8_t)mip, (uint16_t)layer), t->written[s]);
			while (free_at < READS && w.reads[free_at].ticket != 0)
				free_at++;
			if (!t->written[s] || free_at == READS)
				continue;
			pending *r = &w.reads[free_at];
			r->name = t->name;
			r->count = texels_of(t, mip);
			r->mip = mip;
			r->layer = layer;
			r->frame = stilb_gpu_stats_get(w.gpu).frame;
			r->wanted = malloc(r->count * sizeof *r->wanted);
			assert_non_null(r->wanted);
			memcpy(r->wanted, t->now[s], r->count * sizeof *r->wanted);
			if (stilb_gpu_read_begin(w.gpu, w.plan, t->id, (uint8_t)mip, (uint16_t)layer, &r->ticket) != STILB_OK)
				fail_msg("%s", stilb_error_message());
			w.reads_begun++;
		}
	}
}

/* New contents for a part of what the program owns. */
static void upload_random(uint32_t thing)
{
	mix_thing *t = &w.things[thing];
	for (uint32_t s = 0; s < t->mips * t->layers; s++) {
		uint32_t mip = s % t->mips, count = texels_of(t, mip);
		stilb_gpu_upload upload = {.bytes = count * sizeof(uint32_t)};
		if (t->kind == MIX_BUFFER)
			upload.buffer.id = t->owned;
		else {
			upload.image.id = t->owned;
			upload.mip = (uint16_t)mip;
			upload.layer = (uint16_t)(s / t->mips);
			upload.width = width_of(t, mip);
			upload.height = mix_side(t->height, mip);
			upload.depth = 1;
		}
		void *bytes;
		assert_int_equal(stilb_gpu_upload_begin(w.gpu, &upload, &bytes), STILB_OK);
		if (!bytes) /* dropped frames have copied none */
			continue;
		for (uint32_t i = 0; i < count; i++)
			t->now[s][i] = (uint32_t)stilb_random_u64(w.seed, w.index++);
		memcpy(bytes, t->now[s], upload.bytes);
		stilb_gpu_upload_end(w.gpu, bytes);
	}
}

/* ---- memory that changes its owner ------------------------------------------------------------------------------- */

/* Validation does not know that images share memory, and the software device runs one command after the other: what is
 * recorded is the only witness (linked with --wrap). */
static VkMemoryBarrier2 recorded[4096];
static uint32_t recorded_count;

void __real_vkCmdPipelineBarrier2(VkCommandBuffer commands, const VkDependencyInfo *info);
void __wrap_vkCmdPipelineBarrier2(VkCommandBuffer commands, const VkDependencyInfo *info);
void __wrap_vkCmdPipelineBarrier2(VkCommandBuffer commands, const VkDependencyInfo *info)
{
	for (uint32_t i = 0; i < info->memoryBarrierCount; i++) {
		assert_true(recorded_count < 4096);
		recorded[recorded_count++] = info->pMemoryBarriers[i];
	}
	__real_vkCmdPipelineBarrier2(commands, info);
}

/* Stages of which one must be named for an access, and what it must make available. */
static const struct {
	VkPipelineStageFlags2 stages;
	VkAccessFlags2 writes;
} meanings[STILB_GPU_ACCESSES] = {
	[STILB_GPU_ACCESS_COLOR] = {VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT,
                                VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT},
	[STILB_GPU_ACCESS_RESOLVE] = {VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT,
                                  VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT},
	[STILB_GPU_ACCESS_SAMPLED_FRAGMENT] = {VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT, 0},
	[STILB_GPU_ACCESS_SAMPLED_COMPUTE] = {VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, 0},
	[STILB_GPU_ACCESS_STORAGE_READ_GRAPHICS] = {VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT, 0},
	[STILB_GPU_ACCESS_STORAGE_READ_COMPUTE] = {VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, 0},
	[STILB_GPU_ACCESS_STORAGE_COMPUTE] = {VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
                                          VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT | VK_ACCESS_2_SHADER_WRITE_BIT},
	[STILB_GPU_ACCESS_COPY_FROM] = {VK_PIPELINE_STAGE_2_COPY_BIT | VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, 0},
	[STILB_GPU_ACCESS_COPY_TO] = {VK_PIPELINE_STAGE_2_COPY_BIT | VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT,
                                  VK_ACCESS_2_TRANSFER_WRITE_BIT},
	[STILB_GPU_ACCESS_HOST] = {VK_PIPELINE_STAGE_2_HOST_BIT, 0},
	[STILB_GPU_ACCESS_OUTPUT] = {VK_PIPELINE_STAGE_2_COPY_BIT | VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, 0},
};

/* True if what was recorded orders the access that a barrier is for after all that used the memory before. */
static bool hands_over(const VkMemoryBarrier2 *memory, const stilb_gpu_barrier *b)
{
	VkPipelineStageFlags2 behind = meanings[b->to].stages;
	if (b->zero)
		behind = VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT | VK_PIPELINE_STAGE_2_CLEAR_BIT;
	if (memory->srcStageMask & VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT || !(memory->dstStageMask & behind))
		return false; /* all commands: the device's own, around uploads */
	for (uint32_t a = 1; a < STILB_GPU_ACCESSES; a++)
		if (b->from_all & 1u << a && (!(memory->srcStageMask & meanings[a].stages) ||
		                              (meanings[a].writes != 0 && !(memory->srcAccessMask & meanings[a].writes))))
			return false;
	return true;
}

/* Each barrier of the plan that takes over memory was recorded, in its order. */
static void check_memory(void)
{
	const stilb_gpu_barrier *barriers;
	uint32_t count = stilb_gpu_plan_barriers(w.plan, &barriers), at = 0;
	for (uint32_t i = 0; i < count; i++) {
		if (!barriers[i].memory)
			continue;
		while (at < recorded_count && !hands_over(&recorded[at], &barriers[i]))
			at++;
		if (at == recorded_count)
			fail_msg("seed %llu: %s takes over memory, and no barrier says so", (unsigned long long)w.seed,
			         stilb_gpu_plan_name(w.plan, barriers[i].resource));
		w.handed_over++;
	}
}

/* ---- frames ------------------------------------------------------------------------------------------------------ */

static void random_rows(void)
{
	static void (*const passes[])(void) = {random_flat, random_color, random_dispatch, random_copy, random_clear};
	mix_input samples = {.thing = &w.things[S0], .mips = 1, .layers = w.things[S0].layers};
	things_begin();
	clear_pass(&samples, false); /* an input of all others */
	for (uint32_t i = 1 + pick(PASSES); i > 0; i--) {
		memset(w.busy, 0, sizeof w.busy);
		passes[pick(5)]();
	}
	write_outputs();
}

static void random_frame(uint64_t seed)
{
	static uint32_t own[THINGS - OF][MIX_SUBS][64]; /* before a frame that is dropped */
	w.seed = seed;
	w.index = 0;
	if (seed == 1 || chance(12))
		things_resize();
	for (uint32_t i = OF; i < THINGS; i++)
		if (seed == 1 || chance(5))
			upload_random(i);
	bool drop = seed > 1 && chance(5);
	assert_int_equal(stilb_gpu_frame_begin(w.gpu), STILB_OK);
	for (uint32_t i = OF; i < THINGS && drop; i++)
		for (uint32_t s = 0; s < MIX_SUBS; s++)
			memcpy(own[i - OF][s], w.things[i].now[s], sizeof own[0][0]);
	stilb_gpu_plan_begin(w.plan, w.width, w.height);
	random_rows();
	stilb_gpu_planner planner = stilb_gpu_planner_of(w.gpu);
	stilb_gpu_draws nothing = {0};
	recorded_count = 0;
	if (stilb_gpu_plan_make(w.plan, &planner) != STILB_OK ||
	    (!drop && stilb_gpu_frame_run(w.gpu, w.plan, &nothing, 1, NULL) != STILB_OK))
		fail_msg("seed %llu: %s", (unsigned long long)seed, stilb_error_message());
	w.plans++;
	w.dropped += drop;
	if (drop) {
		stilb_gpu_plan_dropped(w.plan);
		for (uint32_t i = OF; i < THINGS; i++)
			for (uint32_t s = 0; s < MIX_SUBS; s++)
				memcpy(w.things[i].now[s], own[i - OF][s], sizeof own[0][0]);
	} else {
		check_memory();
		reads_begin();
		things_end();
	}
	reads_poll(chance(30));
	if (w.gpu->validation_messages > 0)
		fail_msg("seed %llu: the validation layer complains", (unsigned long long)seed);
}

/* ---- the device -------------------------------------------------------------------------------------------------- */

static stilb_gpu_program program_make(const char *name, stilb_gpu_shader fragment, stilb_gpu_shader compute)
{
	stilb_gpu_program program;
	stilb_gpu_program_desc desc = {
		.name = name, .fragment = fragment, .compute = compute, .samplers = 5, .storage_images = compute.words ? 1 : 0};
	if (stilb_gpu_program_create(w.gpu, &desc, &program) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return program;
}

static void own_make(mix_thing *t, uint32_t side, uint32_t mips, uint32_t layers)
{
	t->width = t->kind == MIX_BUFFER ? MIX_WORDS : side;
	t->height = t->kind == MIX_BUFFER ? 1 : side;
	t->mips = mips;
	t->layers = layers;
	if (t->kind == MIX_BUFFER) {
		stilb_gpu_buffer buffer;
		stilb_gpu_buffer_desc desc = {
			.name = t->name, .bytes = 4 * MIX_WORDS, .uses = STILB_GPU_BUFFER_ADDRESS | STILB_GPU_BUFFER_COPY};
		assert_int_equal(stilb_gpu_buffer_create(w.gpu, &desc, &buffer), STILB_OK);
		t->owned = buffer.id;
		return;
	}
	uint32_t uses = 1u << STILB_GPU_USE_SAMPLED | 1u << STILB_GPU_USE_COPY_FROM | 1u << STILB_GPU_USE_COPY_TO |
	                STILB_GPU_EXTENT_ATTACHMENT;
	stilb_gpu_image image;
	stilb_gpu_image_desc desc = {
		.name = t->name,
		.extent = {.format = is_words(t) ? STILB_GPU_R32_UI : STILB_GPU_RGBA8_U,
	               .shape = t->kind == MIX_CUBE ? STILB_GPU_SHAPE_CUBE : STILB_GPU_SHAPE_2D,
	               .width = side,
	               .height = side,
	               .depth = 1,
	               .layers = (uint16_t)layers,
	               .mips = (uint16_t)mips,
	               .samples = 1,
	               .uses = (uint16_t)(uses | (is_words(t) ? 1u << STILB_GPU_USE_STORAGE_WRITE : 0))}};
	if (stilb_gpu_image_create(w.gpu, &desc, &image) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	t->owned = image.id;
}

static int world_open(void **state)
{
	(void)state;
	stilb_gpu_desc desc = {.validate = true, .upload_bytes = 1 << 20};
	if (stilb_gpu_create(&desc, &w.gpu) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	w.plan = stilb_gpu_plan_create();
	assert_non_null(w.plan);
	stilb_gpu_shader none = {0};
	w.flat = program_make("flat", (stilb_gpu_shader)SHADER(flat_frag), none);
	w.two = program_make("two", (stilb_gpu_shader)SHADER(two_frag), none);
	w.color = program_make("color", (stilb_gpu_shader)SHADER(color_frag), none);
	w.compute = program_make("compute", none, (stilb_gpu_shader)SHADER(flat_comp));
	w.compute_array = program_make("compute array", none, (stilb_gpu_shader)SHADER(array_comp));
	assert_int_equal(stilb_gpu_sampler_get(w.gpu, &(stilb_gpu_sampler_desc){.mips = true}, &w.all_mips), STILB_OK);
	for (uint32_t i = 0; i < THINGS; i++) {
		w.things[i].name = names[i];
		w.things[i].kind = kinds[i];
	}
	own_make(&w.things[OF], 5, 1, 1);
	own_make(&w.things[OC], 6, 2, 1);
	own_make(&w.things[OA], 7, 3, 3);
	own_make(&w.things[OQ], 5, 2, 6);
	own_make(&w.things[OB], 0, 1, 1);
	return 0;
}

static int world_close(void **state)
{
	(void)state;
	assert_int_equal(stilb_gpu_wait(w.gpu), STILB_OK);
	assert_int_equal(w.gpu->validation_messages, 0);
	stilb_gpu_plan_destroy(w.plan);
	stilb_gpu_destroy(w.gpu);
	return 0;
}

static void random_plans(void **state)
{
	(void)state;
	const char *wanted = getenv("STILB_RANDOM_PLANS");
	uint64_t count = wanted ? strtoull(wanted, NULL, 10) : TEST_ASAN ? 100 : 1000, most = 0;
	for (uint64_t seed = 1; seed <= count; seed++) {
		random_frame(seed);
		uint64_t allocations = stilb_gpu_memory_measure(w.gpu).allocations;
		most = allocations > most ? allocations : most;
	}
	reads_poll(true);
	print_message("%llu plans, %llu of them dropped, %llu passes, %llu read back, %llu times memory changed "
	              "its owner; %llu allocations at most\n",
	              (unsigned long long)w.plans, (unsigned long long)w.dropped, (unsigned long long)w.passes,
	              (unsigned long long)w.reads_begun, (unsigned long long)w.handed_over, (unsigned long long)most);
	assert_true(w.passes > 2 * w.plans && w.reads_begun > w.plans && w.handed_over > w.plans / 4);
	assert_true(most < 200);
}

int main(void)
{
	setenv("GALLIVM_PERF", "nopt", 0); /* Mesa's software device compiles shaders in half the time */
	const struct CMUnitTest tests[] = {cmocka_unit_test_setup_teardown(random_plans, world_open, world_close)};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
