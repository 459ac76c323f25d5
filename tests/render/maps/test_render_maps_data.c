/* Surfaces without a device: mips against means in double, what packing rounds, what is made of a surface, what the
 * stream hash covers, and resources that come and go. */
#include "render/maps/maps_stage.h"
#include "support/render_fixture.h"

/* ---- mips -------------------------------------------------------------------------------------------------------- */

/* The mean of `from` values, `to` of them in equal parts: part number i of a row of values. */
static double part_mean(const double *values, uint32_t from, uint32_t to, uint32_t i)
{
	double begin = (double)from * i / to, end = (double)from * (i + 1) / to, sum = 0.0;
	for (uint32_t k = 0; k < from; k++)
		sum += values[k] * fmax(fmin(end, k + 1.0) - fmax(begin, (double)k), 0.0);
	return sum / (end - begin);
}

static double decoded(stilb_image_format format, const void *pixels, size_t i)
{
	float value;
	stilb_image one = {.width = 1, .height = 1, .channels = 1, .format = format};
	static const size_t sizes[] = {1, 2, 4, 2, 1, 2};
	/* Alpha is linear in every format. */
	one.format = format == STILB_IMAGE_U8_SRGB && i % 4 == 3 ? STILB_IMAGE_U8_LINEAR : format;
	one.pixels = (uint8_t *)(uintptr_t)pixels + i * sizes[format];
	stilb_image_row_to_light(&one, 0, &value);
	return (double)value;
}

/* One step of a format at a value; of sRGB the slope of its transfer, and a little for its curve. */
static double step(stilb_image_format format, double value)
{
	return format == STILB_IMAGE_U8_SRGB      ? 0.0091 * pow(value, 1.4 / 2.4) + 4e-4
	       : format == STILB_IMAGE_U8_LINEAR  ? 1.0 / 255
	       : format == STILB_IMAGE_U16_LINEAR ? 1.0 / 65535
	                                          : value / 1024 + 1e-6;
}

static void assert_mip(const stilb_image *from, const uint8_t *mip, uint32_t width, uint32_t height)
{
	double row[64], columns[64];
	for (uint32_t i = 0; i < width * height * 4; i++) {
		uint32_t x = i / 4 % width, y = i / 4 / width;
		for (uint32_t v = 0; v < from->height; v++) {
			for (uint32_t u = 0; u < from->width; u++)
				row[u] = decoded(from->format, from->pixels, 4 * ((size_t)v * from->width + u) + i % 4);
			columns[v] = part_mean(row, from->width, width, x);
		}
		double want = part_mean(columns, from->height, height, y), got = decoded(from->format, mip, i);
		assert_near(
			"a texel of a mip", got, want,
			0.51 * step(i % 4 == 3 && from->format == STILB_IMAGE_U8_SRGB ? STILB_IMAGE_U8_LINEAR : from->format,
		                want) +
				1e-6);
	}
}

static void mips_are_means(void **state)
{
	(void)state;
	static const uint32_t sides[][2] = {{2, 2}, {1, 2}, {3, 3}, {5, 1}, {7, 4}, {8, 16}, {13, 27}, {64, 1}};
	static const size_t texels[] = {4, 8, 16, 8, 4, 8};
	for (uint32_t kind = 0; kind < STILB_IMAGE_BC1_SRGB * sizeof sides / sizeof *sides; kind++) {
		stilb_image_format format = (stilb_image_format)(kind % STILB_IMAGE_BC1_SRGB);
		const uint32_t *side = sides[kind / STILB_IMAGE_BC1_SRGB];
		stilb_image image;
		if (format == STILB_IMAGE_U16_SRGB)
			continue;
		assert_int_equal(stilb_image_create(&image, side[0], side[1], 4, format), STILB_OK);
		for (uint32_t i = 0; i < side[0] * side[1] * 4; i++) {
			float value = stilb_random_float(kind, i);
			if (texels[format] == 4)
				((uint8_t *)image.pixels)[i] = (uint8_t)(value * 255.0f);
			else if (format == STILB_IMAGE_F32_LINEAR)
				((float *)image.pixels)[i] = 4.0f * value;
			else
				((uint16_t *)image.pixels)[i] = format == STILB_IMAGE_F16_LINEAR
				                                    ? stilb_image_half_from_float(4.0f * value)
				                                    : (uint16_t)(value * 65535.0f);
		}
		size_t bytes, seen = 0;
		uint8_t *mips = render_mips_make(&image, &bytes);
		assert_non_null(mips);
		stilb_image from = image;
		for (uint32_t m = 1; m < render_mip_count(side[0], side[1]); m++) {
			uint32_t width = from.width > 1 ? from.width / 2 : 1, height = from.height > 1 ? from.height / 2 : 1;
			assert_mip(&from, mips + seen, width, height);
			from = (stilb_image){width, height, 4, format, mips + seen, 0};
			seen += texels[format] * width * height;
		}
		assert_int_equal(seen, bytes);
		assert_int_equal(from.width * from.height, 1);
		free(mips);
		stilb_image_finish(&image);
	}
	size_t none = 1;
	stilb_image one = {1, 1, 4, STILB_IMAGE_U8_SRGB, (uint8_t[4]){0}, 0};
	assert_null(render_mips_make(&one, &none));
	assert_int_equal(none, 0);
}

/* ---- extras ------------------------------------------------------------------------------------------------------ */

static void extras_are_packed(void **state)
{
	(void)state;
	for (uint32_t i = 0; i < 10000; i++) {
		stilb_scene_vertex_extra extra = {.uv = {1e5f * stilb_random_float(1, i), -stilb_random_float(2, i)}}, back;
		dvec t = {(double)stilb_random_float(3, i) - 0.5, (double)stilb_random_float(4, i) - 0.5,
		          (double)stilb_random_float(5, i) - 0.5};
		t = dvec_unit(t);
		for (int c = 0; c < 4; c++)
			extra.color[c] = 3.0f * stilb_random_float(6 + (uint64_t)c, i);
		if (i % 7) {
			reference_set3(extra.tangent, (float)t.x, (float)t.y, (float)t.z);
			extra.tangent[3] = i % 2 ? 1.0f : -1.0f;
		}
		render_extra packed, again;
		render_extras_pack(&extra, 1, &packed);
		render_extras_unpack(&packed, 1, &back);
		render_extras_pack(&back, 1, &again);
		assert_memory_equal(&packed, &again, sizeof packed);
		assert_memory_equal(back.uv, extra.uv, sizeof back.uv);
		assert_true(back.tangent[3] == extra.tangent[3]);
		for (int c = 0; c < 3; c++)
			assert_near("a tangent", (double)back.tangent[c], (double)extra.tangent[c], (double)RENDER_PACKED_ANGLE);
		for (int c = 0; c < 4; c++)
			assert_near("a colour", (double)back.color[c], (double)extra.color[c],
			            (double)extra.color[c] / 2048 + 1e-7);
	}
}

/* ---- surfaces ---------------------------------------------------------------------------------------------------- */

static void surfaces_become_records(void **state)
{
	(void)state;
	stilb_scene_surface surface = stilb_scene_surface_make();
	render_maps maps = render_maps_make(&surface, 0, 0);
	assert_int_equal(maps.bits, RENDER_MAPS_TOGETHER);
	for (int c = 0; c < 3; c++)
		assert_near("a dielectric", (double)maps.record.specular[c], 0.04, 1e-6);
	surface.maps[STILB_SCENE_MAP_NORMAL] = (stilb_scene_map){
		.texture = 7, .set = 1, .wrap_u = STILB_SCENE_CLAMP, .wrap_v = STILB_SCENE_MIRROR, .nearest = true};
	surface.alpha = STILB_SCENE_MASK;
	surface.one_sided = true;
	maps = render_maps_make(&surface, 2, 0);
	assert_int_equal(maps.bits, 1u << STILB_SCENE_MAP_NORMAL | RENDER_MAPS_TWO | RENDER_MAPS_MASK |
	                                RENDER_MAPS_ONE_SIDED | RENDER_MAPS_TOGETHER);
	assert_int_equal(maps.samplers[STILB_SCENE_MAP_NORMAL], 2 + 3 * 1 + 9);
	assert_true(maps.record.places[STILB_SCENE_MAP_NORMAL].set == 1.0f);
	surface.maps[STILB_SCENE_MAP_COLOR].texture = 7; /* which lies on the first uv */
	maps = render_maps_make(&surface, 3, 0);
	assert_int_equal(maps.bits & (RENDER_MAPS_TOGETHER | RENDER_MAPS_TWO), 0);
	surface.unlit = true; /* the other maps do not count */
	surface.workflow = STILB_SCENE_SPECULAR;
	maps = render_maps_make(&surface, 3, 0);
	assert_int_equal(maps.bits, 1u << STILB_SCENE_MAP_COLOR | RENDER_MAPS_MASK | RENDER_MAPS_ONE_SIDED |
	                                RENDER_MAPS_UNLIT | RENDER_MAPS_TOGETHER);
}

/* A layer that shows nothing has no code, and none of its maps. */
static void layers_become_bits(void **state)
{
	(void)state;
	stilb_scene_surface surface = stilb_scene_surface_make();
	for (uint32_t i = RENDER_MAPS_PLAIN; i < RENDER_MAPS; i++)
		surface.maps[i].texture = 1;
	uint32_t specular = 1u << STILB_SCENE_MAP_SPECULAR | 1u << STILB_SCENE_MAP_SPECULAR_COLOR;
	uint32_t always = RENDER_MAPS_TOGETHER | RENDER_MAPS_LAYERS | specular;
	surface.specular_weight = 0.5f;
	render_maps maps = render_maps_make(&surface, 0, 2);
	assert_int_equal(maps.bits, always);
	assert_near("a tint that is not weighted", (double)maps.record.specular[0], 0.04, 1e-6);
	assert_near("a weight", (double)maps.record.specular_weight, 0.5, 0.0);
	surface.clearcoat = 0.5f;
	assert_int_equal(render_maps_make(&surface, 0, 2).bits,
	                 always | RENDER_MAPS_COAT | RENDER_MAPS_COAT_TWO | 1u << STILB_SCENE_MAP_CLEARCOAT |
	                     1u << STILB_SCENE_MAP_CLEARCOAT_ROUGHNESS | 1u << STILB_SCENE_MAP_CLEARCOAT_NORMAL);
	surface.clearcoat = 0.0f;
	surface.sheen_color[1] = surface.anisotropy = 0.5f;
	maps = render_maps_make(&surface, 0, 0);
	uint32_t sheen = RENDER_MAPS_SHEEN | 1u << STILB_SCENE_MAP_SHEEN_COLOR | 1u << STILB_SCENE_MAP_SHEEN_ROUGHNESS;
	uint32_t brushed = RENDER_MAPS_BRUSHED | 1u << STILB_SCENE_MAP_ANISOTROPY;
	assert_int_equal(maps.bits, always | sheen | brushed);
	assert_int_equal(
		render_maps_program_bits(RENDER_MAPS_COAT_TWO | 1u << STILB_SCENE_MAP_CLEARCOAT_NORMAL, false, true, false),
		0); /* without tangents */
	assert_int_equal(render_maps_program_bits(maps.bits, true, true, true), 0);
	surface.sheen_color[1] = surface.anisotropy = 0.0f;
	surface.transmission = 0.5f;
	uint32_t through = RENDER_MAPS_THROUGH | 1u << STILB_SCENE_MAP_TRANSMISSION;
	assert_int_equal(render_maps_make(&surface, 0, 0).bits, always | through);
	surface.thickness = 0.5f;
	surface.attenuation[2] = 0.25f;
	surface.attenuation_distance = 2.0f;
	maps = render_maps_make(&surface, 0, 0);
	assert_int_equal(maps.bits, always | through | RENDER_MAPS_SOLID | 1u << STILB_SCENE_MAP_THICKNESS);
	assert_near("what is absorbed", (double)maps.record.absorption[2], log(4.0) / 2.0, 1e-6);
	assert_near("nothing is absorbed", (double)maps.record.absorption[0], 0.0, 0.0);
	surface.unlit = true;
	assert_int_equal(render_maps_make(&surface, 0, 0).bits, RENDER_MAPS_UNLIT | RENDER_MAPS_TOGETHER);
}

/* Everything that is drawn is in the hash. */
static void the_hash_covers_surfaces(void **state)
{
	(void)state;
	uint64_t seen[32];
	uint32_t count = 0;
	for (int what = 0; what < 25; what++) {
		stilb_scene_surface s = stilb_scene_surface_make();
		s.maps[STILB_SCENE_MAP_COLOR].texture = what == 1 ? 2 : 1;
		s.color[3] = what == 2 ? 0.5f : 1.0f;
		s.roughness = what == 3 ? 0.5f : 1.0f;
		s.ior = what == 4 ? 2.0f : 1.5f;
		s.cutoff = what == 5 ? 0.25f : 0.5f;
		s.occlusion = what == 6 ? 0.5f : 1.0f;
		s.maps[STILB_SCENE_MAP_COLOR].to_v[2] = what == 7 ? 0.5f : 0.0f;
		s.maps[STILB_SCENE_MAP_COLOR].wrap_v = what == 8 ? STILB_SCENE_CLAMP : STILB_SCENE_REPEAT;
		s.maps[STILB_SCENE_MAP_COLOR].nearest = what == 9;
		s.one_sided = what == 10;
		s.alpha = what == 11 ? STILB_SCENE_BLEND : STILB_SCENE_OPAQUE;
		s.clearcoat = what == 12 ? 0.5f : 1.0f;
		s.clearcoat_roughness = what == 13 ? 0.5f : 0.0f;
		s.clearcoat_normal_scale = what == 14 ? 0.5f : 1.0f;
		s.sheen_color[2] = what == 15 ? 0.5f : 1.0f;
		s.sheen_roughness = what == 16 ? 0.5f : 0.0f;
		s.anisotropy = what == 17 ? 0.5f : 1.0f;
		s.anisotropy_rotation = what == 18 ? 0.5f : 0.0f;
		s.transmission = what == 19 ? 0.5f : 1.0f;
		s.thickness = what == 20 ? 0.5f : 1.0f;
		s.attenuation[1] = what == 21 ? 0.25f : 0.5f;
		s.attenuation_distance = what == 22 ? 2.0f : 1.0f;
		s.maps[STILB_SCENE_MAP_SHEEN_COLOR].texture = what == 23;
		s.maps[STILB_SCENE_MAP_SPECULAR].texture = what == 24;
		render_maps maps = render_maps_make(&s, 0, 0);
		seen[count++] = render_maps_hash(&maps);
		for (uint32_t i = 0; i + 1 < count; i++)
			assert_true(seen[i] != seen[count - 1]);
	}
}

/* ---- resources on the null device -------------------------------------------------------------------------------- */

/* Surfaces, extras and textures of scenes that replace one another leave nothing behind. */
static void nothing_is_left_behind(void **state)
{
	(void)state;
	static const uint8_t codes[4] = {1, 2, 3, 4};
	stage s = stage_open((stilb_render_desc){.device = STILB_RENDER_DEVICE_NULL}, 0);
	stilb_image image = image_even(3, codes, STILB_IMAGE_U8_SRGB);
	square q;
	square_make(&q, 1.0f);
	uint32_t live = 0, extras = 0;
	for (int turn = 0; turn < 12; turn++) {
		stilb_scene_surface surface = surface_matt();
		for (uint32_t i = 0; i < RENDER_MAPS; i++)
			surface.maps[i].texture = 1;
		stage_show_square(&s, &q, &surface, &image, 1);
		for (int f = 0; f < 4; f++)
			stage_frame(&s);
		const render_resources *resources = &s.render->resources;
		if (turn > 0) {
			assert_int_equal(resources->live, live);
			assert_true(resources->heaps[RENDER_HEAP_EXTRAS].size <= 2 * extras);
			assert_true(resources->indices[RENDER_RESOURCE_MAPS].next_unused <= 2);
		}
		live = resources->live;
		extras = turn ? extras : resources->heaps[RENDER_HEAP_EXTRAS].size;
	}
	assert_int_equal(extras, 4);
	stilb_scene_material plain = s.scene->materials[0]; /* which loses its surface */
	plain.surface = 0;
	assert_int_equal(stilb_scene_set_material(s.scene, 0, &plain), STILB_OK);
	stilb_scene_changes changes = stilb_scene_changes_read(s.scene);
	assert_int_equal(stilb_render_update_scene(s.render, s.scene, &changes), STILB_OK);
	for (int f = 0; f < 4; f++)
		stage_frame(&s);
	assert_int_equal(s.render->resources.live, live - 1);
	for (uint32_t i = 0; i < s.render->resources.indices[RENDER_RESOURCE_MAPS].next_unused; i++)
		assert_int_equal(s.render->device->maps[i].set.id, 0);
	stilb_image_finish(&image);
	stage_close(&s);
}

/* A scene without surfaces has none of their memory. */
static void nothing_for_scenes_without(void **state)
{
	(void)state;
	stilb_render *render = fixture_render(1, 0, 0);
	stilb_scene *scene = fixture_scene(20);
	assert_int_equal(stilb_render_set_scene(render, scene), STILB_OK);
	assert_int_equal(render->resources.heaps[RENDER_HEAP_EXTRAS].size, 0);
	assert_int_equal(render->resources.heaps[RENDER_HEAP_EXTRA_PLACES].size, 0);
	assert_int_equal(render->resources.heaps[RENDER_HEAP_MAPS].size, 0);
	stilb_render_destroy(render);
	stilb_scene_destroy(scene);
}

/* What frames need is compiled before them. */
static void programs_are_made_before(void **state)
{
	(void)state;
	for (int depth = 0; depth < 2; depth++) {
		stage s = stage_open((stilb_render_desc){.device = STILB_RENDER_DEVICE_NULL}, 0);
		stilb_render_target target = {
			.name = "shadow", .kind = STILB_RENDER_TARGET_DEPTH, .width = 8, .height = 8, .output = true};
		s.view.target = depth ? &target : NULL;
		square q;
		square_make(&q, 1.0f);
		stilb_scene_surface surface = surface_matt();
		surface.alpha = STILB_SCENE_MASK;
		stage_show_square(&s, &q, &surface, NULL, 0);
		assert_int_equal(stilb_render_prepare_view(s.render, &s.view), STILB_OK);
		const render_programs *programs = &s.render->device->programs;
		assert_int_equal(programs->choice_count, 1);
		assert_int_equal(programs->choices[0]->map_count, 1);
		stage_frame(&s);
		assert_int_equal(programs->choice_count, 1);
		assert_int_equal(programs->choices[0]->map_count, 1);
		stage_close(&s);
	}
}

/* ---- no memory --------------------------------------------------------------------------------------------------- */

static int64_t allocations_left = INT64_MAX;

void *__real_stilb_memory_alloc(size_t count, size_t size);
void *__wrap_stilb_memory_alloc(size_t count, size_t size);
void *__real_realloc(void *memory, size_t size);
void *__wrap_realloc(void *memory, size_t size);

void *__wrap_stilb_memory_alloc(size_t count, size_t size)
{
	return --allocations_left == 0 ? NULL : __real_stilb_memory_alloc(count, size);
}

void *__wrap_realloc(void *memory, size_t size)
{
	return --allocations_left == 0 ? NULL : __real_realloc(memory, size);
}

static void assert_memory_or_ok(stilb_result result)
{
	assert_true(result == STILB_OK || (result == STILB_ERROR_MEMORY && allocations_left <= 0));
}

static stilb_result record_and_replay(stage *s)
{
	stilb_render_pass pass = {.name = "main"};
	uint32_t ids[1] = {0};
	stilb_result result = stilb_render_frame_begin(s->render);
	if (result == STILB_OK)
		result = stilb_render_record(s->render, 0, s->scene, ids, 1, s->pool, 0);
	return result == STILB_OK ? stilb_render_replay(s->render, &pass, 1, &s->view, 1, s->pool, 0) : result;
}

static void frames_pass(stage *s)
{
	for (int f = 0; f < 4; f++)
		assert_int_equal(stilb_render_frame_begin(s->render), STILB_OK);
}

/* A scene is set, changed and drawn while allocation `number` fails; what failed succeeds when it is done again. False:
 * there were fewer. */
static bool a_life_without_memory(int64_t number, uint64_t *hash)
{
	static const uint8_t codes[4] = {1, 2, 3, 4};
	stage s = stage_open((stilb_render_desc){.device = STILB_RENDER_DEVICE_NULL}, 0);
	stilb_image image = image_even(3, codes, STILB_IMAGE_U8_SRGB);
	square q;
	square_make(&q, 1.0f);
	stilb_scene_surface surface = surface_matt();
	surface.maps[STILB_SCENE_MAP_COLOR].texture = 1;
	surface.alpha = STILB_SCENE_BLEND;
	stage_show_square(&s, &q, &surface, &image, 1);
	assert_int_equal(stilb_render_set_scene(s.render, NULL), STILB_OK);
	frames_pass(&s);
	surface.color[1] = 0.5f;
	assert_int_equal(stilb_scene_set_surface(s.scene, 0, &surface), STILB_OK);
	stilb_scene_changes changes = stilb_scene_changes_read(s.scene);
	allocations_left = number;
	stilb_result result = stilb_render_set_scene(s.render, s.scene);
	assert_memory_or_ok(result);
	if (result != STILB_OK)
		assert_int_equal(stilb_render_set_scene(s.render, s.scene), STILB_OK);
	result = stilb_render_update_scene(s.render, s.scene, &changes);
	assert_memory_or_ok(result);
	if (result != STILB_OK)
		assert_int_equal(stilb_render_update_scene(s.render, s.scene, &changes), STILB_OK);
	result = record_and_replay(&s);
	assert_memory_or_ok(result);
	bool failed = allocations_left <= 0;
	allocations_left = INT64_MAX;
	assert_int_equal(record_and_replay(&s), STILB_OK);
	assert_true(*hash == 0 || stilb_render_stream_hash(s.render) == *hash);
	*hash = stilb_render_stream_hash(s.render);
	assert_int_equal(stilb_render_set_scene(s.render, NULL), STILB_OK);
	frames_pass(&s);
	assert_int_equal(s.render->resources.live, 0);
	stilb_image_finish(&image);
	stage_close(&s);
	return failed;
}

static void every_allocation_fails_once(void **state)
{
	(void)state;
	int64_t number = 1;
	uint64_t hash = 0;
	while (a_life_without_memory(number, &hash))
		number++;
	assert_true(number > 20);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		test_one_thread(mips_are_means),
		test_one_thread(extras_are_packed),
		cmocka_unit_test(surfaces_become_records),
		cmocka_unit_test(layers_become_bits),
		cmocka_unit_test(the_hash_covers_surfaces),
		cmocka_unit_test(nothing_is_left_behind),
		cmocka_unit_test(nothing_for_scenes_without),
		cmocka_unit_test(programs_are_made_before),
		test_one_thread(every_allocation_fails_once),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
