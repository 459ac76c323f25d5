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

/* All mips of a picture but the first, from larger to smaller, to be freed; made a few rows at a time if a pool helps.
 * *bytes: of all. */
static uint8_t *mips_of_kind(const stilb_image *image, render_mips_kind kind, stilb_render_specular_aa aa,
                             stilb_job_pool *pool, size_t *bytes)
{
	size_t texel = stilb_image_size(image) / image->width / image->height;
	uint32_t count = render_mip_count(image->width, image->height);
	uint64_t texels = render_mip_texels(image->width, image->height, count) - (uint64_t)image->width * image->height;
	render_mips_codes codes;
	render_mips_codes_make(image->format, kind, aa, &codes);
	uint8_t *mips = malloc(texels * texel + 1);
	stilb_image from = *image, to = from;
	assert_non_null(mips);
	to.pixels = mips;
	for (uint32_t m = 1; m < count; m++) {
		to.width = from.width > 1 ? from.width / 2 : 1;
		to.height = from.height > 1 ? from.height / 2 : 1;
		for (uint32_t row = 0, step = pool ? 37 : to.height; row < to.height; row += step)
			render_mips_rows(&codes, &from, row, row + step < to.height ? row + step : to.height, pool, &to);
		from = to;
		to.pixels = (uint8_t *)to.pixels + stilb_image_size(&from);
	}
	*bytes = texels * texel;
	assert_ptr_equal(to.pixels, mips + *bytes);
	return mips;
}

static uint8_t *mips_of(const stilb_image *image, stilb_job_pool *pool, size_t *bytes)
{
	return mips_of_kind(image, RENDER_MIPS_MEANS, STILB_RENDER_SPECULAR_AA_VMF, pool, bytes);
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
		uint8_t *mips = mips_of(&image, NULL, &bytes);
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
}

/* A picture of random codes. */
static stilb_image image_random(uint32_t width, uint32_t height, stilb_image_format format)
{
	stilb_image image;
	assert_int_equal(stilb_image_create(&image, width, height, 4, format), STILB_OK);
	for (uint32_t i = 0; i < 4 * width * height; i++)
		((uint8_t *)image.pixels)[i] = (uint8_t)(256.0f * stilb_random_float(width, i));
	return image;
}

/* Threads that help change nothing; also of mips that are made in several blocks, of odd sizes. */
static void mips_are_the_same_with_help(void **state)
{
	(void)state;
	static const uint32_t sides[][2] = {{1031, 517}, {1024, 600}, {259, 300}};
	stilb_job_pool *pool;
	assert_int_equal(stilb_job_pool_create(&(stilb_job_pool_desc){.worker_count = 3}, &pool), 0);
	for (uint32_t i = 0; i < 3; i++) {
		stilb_image image =
			image_random(sides[i][0], sides[i][1], i == 1 ? STILB_IMAGE_U8_LINEAR : STILB_IMAGE_U8_SRGB);
		size_t bytes, again;
		uint8_t *alone = mips_of(&image, NULL, &bytes), *helped = mips_of(&image, pool, &again);
		assert_true(alone && helped && bytes == again);
		assert_memory_equal(alone, helped, bytes);
		stilb_image first = {4, 4, 4, image.format, NULL, 0}, corner = first; /* the last block's texels, alone */
		uint8_t cut[4 * 16];
		uint32_t left = (image.width / 2 - 2) * 2;
		if (image.width % 2 == 0 && image.height % 2 == 0) {
			for (uint32_t y = 0; y < 4; y++)
				memcpy(cut + 16 * y, (uint8_t *)image.pixels + 4 * ((size_t)y * image.width + left), 16);
			corner.pixels = cut;
			size_t few;
			uint8_t *small = mips_of(&corner, NULL, &few);
			assert_memory_equal(small, alone + 4 * (size_t)(left / 2), 8);
			free(small);
		}
		free(alone);
		free(helped);
		stilb_image_finish(&image);
	}
	stilb_job_pool_destroy(pool);
}

/* Puts a normal into a texel of four channels. */
static void normal_put(const stilb_image *image, size_t texel, dvec n, render_mips_kind kind)
{
	bool two = kind == RENDER_MIPS_NORMALS_TWO;
	double x = 0.5 + 0.5 * n.x, y = 0.5 + 0.5 * n.y, z = 0.5 + 0.5 * n.z;
	const double values[4] = {x, two ? x : y, two ? x : z, two ? y : 0.3 /* what a file may have there */};
	for (size_t c = 0; c < 4; c++) {
		size_t i = 4 * texel + c;
		if (image->format == STILB_IMAGE_F32_LINEAR)
			((float *)image->pixels)[i] = (float)values[c];
		else if (image->format == STILB_IMAGE_F16_LINEAR)
			((uint16_t *)image->pixels)[i] = stilb_image_half_from_float((float)values[c]);
		else if (image->format == STILB_IMAGE_U16_LINEAR)
			((uint16_t *)image->pixels)[i] = (uint16_t)(values[c] * 65535.0 + 0.5);
		else
			((uint8_t *)image->pixels)[i] = (uint8_t)(values[c] * 255.0 + 0.5);
	}
}

/* The spread of normals whose mean has this length: of the lobe with that mean, coth(k) - 1 / k = length, alpha^2 =
 * 2 / k; of Toksvig alpha^2 = 2 (1 - length) / length. */
static double spread_of_length(double length, stilb_render_specular_aa aa)
{
	double low = 1e-3, high = 1e7;
	if (aa == STILB_RENDER_SPECULAR_AA_TOKSVIG)
		return fmin(sqrt(2.0 * (1.0 - length) / length), 1.0);
	for (int i = 0; i < 200; i++) {
		double k = sqrt(low * high);
		if (1.0 / tanh(k) - 1.0 / k < length)
			low = k;
		else
			high = k;
	}
	return fmin(sqrt(2.0 / low), 1.0);
}

/* 8 x 4 normals around a tilted axis, in cones of rising angles: what the spread of all mips is, in every format. */
static void mips_hold_the_spread_of_cones(void **state)
{
	(void)state;
	static const stilb_image_format formats[] = {STILB_IMAGE_U8_LINEAR, STILB_IMAGE_U16_LINEAR, STILB_IMAGE_F16_LINEAR,
	                                             STILB_IMAGE_F32_LINEAR};
	static const double finest[] = {1.0 / 255, 1.0 / 65535, 1.0 / 2048, 1e-4};
	for (uint32_t k = 0; k < 4 * 2 * 2 * 6; k++) {
		uint32_t format = k % 4, cone = k / 16;
		render_mips_kind kind = k / 4 % 2 ? RENDER_MIPS_NORMALS_TWO : RENDER_MIPS_NORMALS;
		stilb_render_specular_aa aa = (stilb_render_specular_aa)(k / 8 % 2);
		/* Of two channels z is made, so the mean of a tilted cone is another one. */
		double angle = 0.02 * pow(2.0, cone), tilt = kind == RENDER_MIPS_NORMALS ? 0.3 : 0.0;
		stilb_image image;
		assert_int_equal(stilb_image_create(&image, 8, 4, 4, formats[format]), STILB_OK);
		for (uint32_t i = 0; i < 32; i++) {
			double turn = REFERENCE_PI * (0.25 + 0.5 * (i % 2 + 2 * (i / 8 % 2))), x = sin(angle) * cos(turn);
			dvec n = {x * cos(tilt) + cos(angle) * sin(tilt), sin(angle) * sin(turn),
			          cos(angle) * cos(tilt) - x * sin(tilt)};
			normal_put(&image, i, n, kind);
		}
		size_t bytes, size = stilb_image_size(&image) / 32;
		stilb_image copy = image;
		assert_int_equal(stilb_image_create(&copy, 8, 4, 4, formats[format]), STILB_OK);
		memcpy(copy.pixels, image.pixels, 32 * size);
		render_mips_prepare(&image, kind);
		uint8_t *mips = mips_of_kind(&image, kind, aa, NULL, &bytes), *means;
		means = mips_of(&copy, NULL, &bytes);
		assert_true(mips && means && bytes / size == 8 + 2 + 1);
		uint32_t channel = kind == RENDER_MIPS_NORMALS ? 3 : 1;
		double want = spread_of_length(cos(angle), aa), code = finest[format];
		for (size_t i = 0; i < 4 * (bytes / size); i++) {
			double got = decoded(formats[format], mips, i);
			if (i % 4 == channel) /* a normal's own codes are off by half a step each */
				assert_near("a spread", 1.0 - got, want, 0.51 * code + code * 0.8 + 1e-3 * want);
			else /* the others are means as they always were */
				assert_near("a mean", got, decoded(formats[format], means, i), 0.0);
		}
		for (size_t i = channel; i < 128; i += 4)
			assert_near("no spread", decoded(formats[format], image.pixels, i), 1.0, 0.0);
		free(mips);
		free(means);
		stilb_image_finish(&image);
		stilb_image_finish(&copy);
	}
}

/* Flat and evenly tilted maps spread nowhere, also of odd sizes. Normals all around have no mean: the widest spread. */
static void mips_of_flat_maps_do_not_spread(void **state)
{
	(void)state;
	for (uint32_t k = 0; k < 4 * 3; k++) {
		stilb_image_format format = k % 4 == 0   ? STILB_IMAGE_U8_LINEAR
		                            : k % 4 == 1 ? STILB_IMAGE_U16_LINEAR
		                            : k % 4 == 2 ? STILB_IMAGE_F16_LINEAR
		                                         : STILB_IMAGE_F32_LINEAR;
		stilb_image image;
		size_t bytes;
		assert_int_equal(stilb_image_create(&image, 13, 6, 4, format), STILB_OK);
		for (uint32_t i = 0; i < 13 * 6; i++) {
			dvec n = k / 4 == 0 ? (dvec){0, 0, 1} : dvec_unit((dvec){0.3, -0.5, 0.8});
			if (k / 4 == 2)
				n = i % 13 == 12 || i / 13 > 3 ? n : (dvec){i % 2 ? 1 : -1, 0, 0};
			normal_put(&image, i, n, RENDER_MIPS_NORMALS);
		}
		render_mips_prepare(&image, RENDER_MIPS_NORMALS);
		uint8_t *mips = mips_of_kind(&image, RENDER_MIPS_NORMALS, STILB_RENDER_SPECULAR_AA_VMF, NULL, &bytes);
		assert_non_null(mips);
		size_t texels = bytes / (stilb_image_size(&image) / (13 * 6));
		for (size_t i = 0; i < texels && k / 4 < 2; i++)
			assert_near("a flat texel", decoded(format, mips, 4 * i + 3), 1.0, 0.0);
		if (k / 4 == 2)
			assert_near("normals all around", decoded(format, mips, 3), 0.0, 1e-2);
		free(mips);
		stilb_image_finish(&image);
	}
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
	assert_int_equal(s.render->resources.live, live - 2); /* the maps and their group */
	for (uint32_t i = 0; i < s.render->resources.indices[RENDER_RESOURCE_MAPS].next_unused; i++)
		assert_int_equal(s.render->device->maps[i].set.id, 0);
	stilb_image_finish(&image);
	stage_close(&s);
}

/* Shows a scene of `count` squares, each with a surface and a texture of its own. */
static void show_textures(stage *s, const stilb_image *image, uint32_t count)
{
	square q;
	square_make(&q, 1.0f);
	stilb_scene_build *build = stilb_scene_build_begin();
	uint32_t mesh = stilb_scene_build_mesh(build, &q.mesh);
	for (uint32_t t = 0; t < count; t++) {
		stilb_scene_surface surface = surface_unlit();
		stilb_scene_build_texture(build, image);
		surface.maps[STILB_SCENE_MAP_COLOR].texture = t + 1;
		stage_model(build, mesh, stage_material(build, &surface), stilb_mat4_identity());
	}
	stage_show(s, build);
}

/* Large scenes leave no copies of their textures behind: what comes with a scene is sent while it is set. */
static void textures_do_not_wait_in_memory(void **state)
{
	(void)state;
	stage s = stage_open((stilb_render_desc){.device = STILB_RENDER_DEVICE_NULL}, 1);
	stilb_render_set_pool(s.render, s.pool);
	stilb_image image = image_random(2048, 2048, STILB_IMAGE_U8_SRGB); /* 16 MiB */
	show_textures(&s, &image, 7);
	assert_int_equal(s.render->resources.upload_count, 3);
	assert_int_equal(render_resources_pending(&s.render->resources) >> 20, 64); /* 3 with mips */
	stage_frame(&s);
	assert_int_equal(s.render->resources.upload_count, 0);
	stilb_render_set_pool(s.render, NULL);
	stilb_image_finish(&image);
	stage_close(&s);
}

/* Of a patient upload a frame copies RENDER_UPLOAD_A_FRAME bytes, mips included. */
static void patient_uploads_count_mips(void **state)
{
	(void)state;
	stage s = stage_open((stilb_render_desc){.device = STILB_RENDER_DEVICE_NULL}, 0);
	stilb_image image = image_random(2048, 2048, STILB_IMAGE_U8_SRGB); /* 16 MiB and 5.3 MiB of mips */
	stilb_render_texture texture;
	uint64_t left = (((uint64_t)16 << 20) * 4 - 4) / 3;
	show_textures(&s, &image, 0);
	stage_frame(&s);
	assert_int_equal(
		render_texture_create(s.render, &image, (render_texture_way){.patient = true, .mips = true}, &texture),
		STILB_OK);
	for (int f = 0; f < 2; f++) {
		assert_int_equal(render_resources_pending(&s.render->resources), left);
		stage_frame(&s);
		left = left > RENDER_UPLOAD_A_FRAME ? left - RENDER_UPLOAD_A_FRAME : 0;
	}
	assert_int_equal(render_resources_pending(&s.render->resources), 0);
	assert_int_equal(s.render->resources.upload_count, 0);
	stilb_image_finish(&image);
	stage_close(&s);
}

/* A texture and a surface that come together are made once. */
static void new_textures_are_made_once(void **state)
{
	(void)state;
	stage s = stage_open((stilb_render_desc){.device = STILB_RENDER_DEVICE_NULL}, 0);
	stilb_image image = image_random(8, 8, STILB_IMAGE_U8_SRGB);
	show_textures(&s, &image, 1);
	stage_frame(&s);
	uint32_t id;
	stilb_scene_surface surface = surface_unlit();
	assert_int_equal(stilb_scene_add_texture(s.scene, &image, &id), STILB_OK);
	surface.maps[STILB_SCENE_MAP_COLOR].texture = id + 1;
	assert_int_equal(stilb_scene_set_surface(s.scene, 0, &surface), STILB_OK);
	stilb_scene_changes changes = stilb_scene_changes_read(s.scene);
	assert_int_equal(stilb_render_update_scene(s.render, s.scene, &changes), STILB_OK);
	assert_int_equal(s.render->resources.upload_count, 1);
	assert_non_null(s.render->resources.uploads[0].pixels.mips);
	assert_int_equal(s.render->resources.retired_count, 1); /* the group that the material has left */
	stilb_image_finish(&image);
	stage_close(&s);
}

/* Many surfaces are released over several frames, as meshes are. */
static void surfaces_are_released_in_turns(void **state)
{
	(void)state;
	stage s = stage_open((stilb_render_desc){.device = STILB_RENDER_DEVICE_NULL}, 0);
	stilb_scene_surface surface = surface_unlit();
	stilb_scene_build *build = stilb_scene_build_begin();
	for (uint32_t m = 0; m < 3000; m++)
		stage_material(build, &surface);
	stage_show(&s, build);
	assert_int_equal(stilb_render_set_scene(s.render, NULL), STILB_OK);
	const render_indices *maps = &s.render->resources.indices[RENDER_RESOURCE_MAPS];
	uint32_t frames = 0;
	for (uint32_t before = 3000; before > 0; frames++) {
		assert_int_equal(stilb_render_frame_begin(s.render), STILB_OK);
		uint32_t now = maps->next_unused - maps->free_count;
		assert_true(before - now <= 1024 && frames < 10);
		before = now;
	}
	assert_int_equal(s.render->resources.live, 0);
	stage_close(&s);
}

/* A renderer that ends while a texture is being made leaves nothing: the address sanitizer sees what it does. */
static void ends_while_textures_are_made(void **state)
{
	(void)state;
	for (uint32_t frames = 0; frames < 4; frames++) {
		stage s = stage_open((stilb_render_desc){.device = STILB_RENDER_DEVICE_NULL}, 0);
		stilb_render_set_textures(s.render, STILB_RENDER_TEXTURES_EVEN);
		stilb_image image = image_random(2300, 1500, STILB_IMAGE_U8_SRGB);
		stilb_scene_surface surface = surface_unlit();
		surface.maps[STILB_SCENE_MAP_COLOR].texture = 1;
		square q;
		square_make(&q, 1.0f);
		stage_show_square(&s, &q, &surface, &image, 1);
		for (uint32_t f = 0; f < frames; f++) {
			stilb_scene_changes changes = stilb_scene_changes_read(s.scene);
			assert_int_equal(stilb_render_update_scene(s.render, s.scene, &changes), STILB_OK);
			stage_frame(&s);
		}
		assert_int_equal(s.render->scene.textures[0].loading == RENDER_LOADING_MADE, frames == 1);
		assert_int_equal(stilb_render_textures_left(s.render), 1);
		stilb_image_finish(&image);
		stage_close(&s);
	}
}

/* ---- array images ------------------------------------------------------------------------------------------------ */

static uint32_t arrays_alive(const render_arrays *arrays)
{
	uint32_t count = 0;
	for (uint32_t a = 0; a < arrays->count; a++)
		count += arrays->items[a].image.id != 0;
	return count;
}

/* Layers are taken from images that grow, given back, and taken again; images without textures are gone. */
static void arrays_grow_and_shrink(void **state)
{
	(void)state;
	stage s = stage_open((stilb_render_desc){.device = STILB_RENDER_DEVICE_NULL}, 0);
	render_device *device = s.render->device;
	render_arrays *arrays = &device->arrays;
	render_array_kind kind = {16, 8, STILB_GPU_RGBA8_U, 5}, large = {2048, 1024, STILB_GPU_RGBA8_U, 12};
	render_array_kind other = {8, 16, STILB_GPU_RGBA8_U, 5};
	uint32_t array[40];
	uint16_t layer[40];
	stilb_lock_take(&s.render->resources.lock);
	assert_int_equal(render_array_layer(&kind), 4 * (16 * 8 + 8 * 4 + 4 * 2 + 2 + 1));
	for (int i = 0; i < 32; i++) {
		assert_int_equal(render_array_take(device, &kind, &array[i], &layer[i]), STILB_OK);
		for (int k = 0; k < i; k++)
			assert_true(array[k] != array[i] || layer[k] != layer[i]);
	}
	assert_int_equal(arrays_alive(arrays), 6); /* of 1, 1, 2, 4, 8 and 16 layers */
	uint32_t serial = arrays->items[array[31]].serial;
	render_array_give(device, array[20], layer[20]);
	assert_int_equal(render_array_take(device, &other, &array[32], &layer[32]), STILB_OK);
	assert_int_equal(render_array_take(device, &kind, &array[33], &layer[33]), STILB_OK);
	assert_true(array[33] == array[20] && layer[33] == layer[20] && array[32] != array[20]);
	for (int i = 0; i < 34; i++)
		if (i != 20)
			render_array_give(device, array[i], layer[i]);
	assert_int_equal(arrays_alive(arrays), 0);
	for (int i = 0; i < 100; i++) /* what is expected has one image */
		assert_true(render_array_expect(arrays, &kind));
	for (int i = 0; i < 40; i++)
		assert_int_equal(render_array_take(device, &kind, &array[i], &layer[i]), STILB_OK);
	assert_true(arrays_alive(arrays) == 1 && arrays->items[array[0]].layers == 100);
	assert_true(arrays->items[array[0]].serial > serial);
	render_array_expect_none(arrays);
	assert_false(render_array_is_large(&kind));
	assert_true(render_array_is_large(&large));
	for (int i = 0; i < 3; i++)
		assert_int_equal(render_array_take(device, &large, &array[i], &layer[i]), STILB_OK);
	assert_true(arrays_alive(arrays) == 4 && layer[2] == 0);
	stilb_lock_give(&s.render->resources.lock);
	stage_close(&s);
}

/* Squares by turns with textures of two sizes, and with one large texture. large: its material draws each seventh. */
static void show_two_sizes(stage *s, bool large, bool one_by_one)
{
	square q;
	square_make(&q, 1.0f);
	stilb_scene_build *build = stilb_scene_build_begin();
	uint32_t mesh = stilb_scene_build_mesh(build, &q.mesh), materials[20], last = 0;
	for (uint32_t t = 0; t < 20u + large; t++) {
		stilb_image image = t < 20 ? image_random(t % 2 ? 4 : 8, 8, STILB_IMAGE_U8_SRGB) : (stilb_image){0};
		if (t == 20)
			assert_int_equal(stilb_image_create(&image, 1024, 1024, 4, STILB_IMAGE_U8_SRGB), STILB_OK);
		stilb_scene_build_texture(build, &image);
		stilb_image_finish(&image);
	}
	for (uint32_t t = 0; t < 20; t++) {
		stilb_scene_surface surface = surface_unlit();
		surface.maps[STILB_SCENE_MAP_COLOR].texture = large && t % 7 == 6 ? 21 : t + 1;
		materials[t] = stage_material(build, &surface);
		last = t;
	}
	for (uint32_t m = 0; m < 60; m++)
		stage_model(build, mesh, materials[m % (last + 1)], stilb_mat4_identity());
	stilb_scene *scene;
	assert_int_equal(stilb_scene_build_end(build, &scene), STILB_OK);
	if (one_by_one) { /* textures come as edits: nothing is expected */
		stilb_scene_changes changes = stilb_scene_changes_read(scene);
		assert_int_equal(stilb_render_set_scene(s->render, NULL), STILB_OK);
		stilb_image images[21];
		for (uint32_t t = 0; t < scene->texture_count; t++) {
			images[t] = scene->textures[t];
			scene->textures[t].pixels = NULL;
		}
		assert_int_equal(stilb_render_set_scene(s->render, scene), STILB_OK);
		for (uint32_t t = scene->texture_count; t > 0; t--) {
			scene->textures[t - 1].pixels = images[t - 1].pixels;
			uint32_t id = t - 1;
			changes = (stilb_scene_changes){.textures = &id, .texture_count = 1};
			assert_int_equal(stilb_render_update_scene(s->render, scene, &changes), STILB_OK);
		}
	} else {
		assert_int_equal(stilb_render_set_scene(s->render, scene), STILB_OK);
	}
	stilb_scene_destroy(s->scene);
	s->scene = scene;
}

/* Textures of one size share what is bound; the order of draws does not depend on which images they have got. */
static void draws_share_images(void **state)
{
	(void)state;
	for (int large = 0; large < 2; large++) {
		uint64_t hashes[2];
		for (int one_by_one = 0; one_by_one < 2; one_by_one++) {
			stage s = stage_open((stilb_render_desc){.device = STILB_RENDER_DEVICE_NULL}, 0);
			show_two_sizes(&s, large, one_by_one);
			stage_frame(&s);
			const render_pass_lists *lists = &s.render->passes[0];
			hashes[one_by_one] = stilb_render_stream_hash(s.render);
			assert_int_equal(lists->draws, 60);
			if (one_by_one)
				assert_true(lists->run_count > 4); /* 1, 1, 2, 4 and 8 layers of each */
			else                                   /* the large texture's two materials are alone */
				assert_int_equal(lists->run_count, large ? 4 : 2);
			for (int f = 0; f < 4; f++)
				stage_frame(&s);
			assert_int_equal(arrays_alive(&s.render->device->arrays), one_by_one ? 10 + large : 2 + large);
			stage_close(&s);
		}
		assert_true(hashes[0] == hashes[1]);
	}
}

/* A frame that was recorded before its material changed is drawn with what it was recorded with; so are groups that
 * materials leave and join again. */
static void groups_outlive_changes(void **state)
{
	(void)state;
	stage s = stage_open((stilb_render_desc){.device = STILB_RENDER_DEVICE_NULL}, 0);
	stilb_image image = image_random(8, 8, STILB_IMAGE_U8_SRGB);
	show_textures(&s, &image, 1);
	stage_frame(&s);
	stilb_scene_surface surface = surface_unlit();
	const render_resources *resources = &s.render->resources;
	stilb_render_material material = stilb_render_scene_material(s.render, 0);
	uint32_t before = resources->materials[material.id & RENDER_INDEX_MASK] & (RENDER_STATE_MAPS - 1), ids[1] = {0};
	for (int turn = 0; turn < 4; turn++) {
		stilb_render_pass pass = {.name = "main"};
		assert_int_equal(stilb_render_frame_begin(s.render), STILB_OK);
		assert_int_equal(stilb_render_record(s.render, 0, s.scene, ids, 1, s.pool, 0), STILB_OK);
		surface.maps[STILB_SCENE_MAP_COLOR].texture = turn % 2;
		assert_int_equal(stilb_scene_set_surface(s.scene, 0, &surface), STILB_OK);
		stilb_scene_changes changes = stilb_scene_changes_read(s.scene);
		assert_int_equal(stilb_render_update_scene(s.render, s.scene, &changes), STILB_OK);
		stilb_scene_changes_clear(s.scene);
		assert_int_equal(stilb_render_replay(s.render, &pass, 1, &s.view, 1, s.pool, 0), STILB_OK);
		assert_true(s.render->device->maps[before].set.id != 0);
	}
	surface.maps[STILB_SCENE_MAP_COLOR].texture = 0;
	assert_int_equal(stilb_scene_set_surface(s.scene, 0, &surface), STILB_OK);
	stilb_scene_changes changes = stilb_scene_changes_read(s.scene);
	assert_int_equal(stilb_render_update_scene(s.render, s.scene, &changes), STILB_OK);
	stage_frame(&s);
	assert_true(s.render->device->maps[before].set.id != 0);
	for (int f = 0; f < 4; f++)
		stage_frame(&s);
	assert_int_equal(s.render->device->maps[before].set.id, 0);
	assert_int_equal(resources->retired_count, 0);
	assert_int_equal(resources->indices[RENDER_RESOURCE_GROUP].next_unused -
	                     resources->indices[RENDER_RESOURCE_GROUP].free_count,
	                 1);
	assert_int_equal(resources->indices[RENDER_RESOURCE_CLASS].next_unused -
	                     resources->indices[RENDER_RESOURCE_CLASS].free_count,
	                 1);
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

/* Also where meshes with extras stand beside such without, and of more kinds of surfaces than anybody counts. */
static void programs_of_all_kinds_are_made_before(void **state)
{
	(void)state;
	stage s = stage_open((stilb_render_desc){.device = STILB_RENDER_DEVICE_NULL}, 0);
	const uint8_t normal[4] = {128, 128, 255, 255};
	stilb_image image = image_even(4, normal, STILB_IMAGE_U8_LINEAR);
	stilb_scene_build *build = stilb_scene_build_begin();
	square q;
	square_make(&q, 1.0f);
	uint32_t mesh[2], texture = stilb_scene_build_texture(build, &image), kinds = 0;
	for (int extras = 0; extras < 2; extras++) {
		q.mesh.extras = extras ? q.extras : NULL;
		mesh[extras] = stilb_scene_build_mesh(build, &q.mesh);
	}
	for (uint32_t bits = 0; bits < 96; bits++) { /* which maps there are, and how alpha is used */
		stilb_scene_surface surface = surface_matt();
		surface.alpha = (stilb_scene_alpha)(bits / 32);
		for (uint32_t map = 0; map < RENDER_MAPS; map++)
			surface.maps[map].texture = bits >> map & 1u ? texture + 1 : 0;
		uint32_t material = stage_material(build, &surface);
		for (int extras = 0; extras < 2; extras++)
			stage_model(build, mesh[extras], material, stilb_mat4_identity());
	}
	stage_show(&s, build);
	assert_int_equal(stilb_render_prepare_view(s.render, &s.view), STILB_OK);
	const render_programs *programs = &s.render->device->programs;
	assert_int_equal(programs->choice_count, 1);
	kinds = programs->choices[0]->map_count;
	assert_int_equal(kinds, 96 + 48); /* without extras there is no map of normals */
	stage_frame(&s);
	assert_int_equal(programs->choice_count, 1);
	assert_int_equal(programs->choices[0]->map_count, kinds);
	stilb_image_finish(&image);
	stage_close(&s);
}

/* A panorama is mirrored whatever the surroundings say of sky and ground, and needs no program more for it. */
static void a_panorama_has_one_gloss(void **state)
{
	(void)state;
	stilb_render_view view = {0};
	uint32_t bits[2][2];
	for (int glossy = 0; glossy < 2; glossy++)
		for (int panorama = 0; panorama < 2; panorama++) {
			view.surroundings.glossy = glossy;
			bits[panorama][glossy] = render_light_bits(&view, panorama, 0);
		}
	assert_int_equal(bits[0][0] ^ bits[0][1], RENDER_LIGHTS_GLOSS);
	assert_int_equal(bits[1][0], bits[1][1]);
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
		test_one_thread(mips_hold_the_spread_of_cones),
		test_one_thread(mips_of_flat_maps_do_not_spread),
		test_one_thread(extras_are_packed),
		cmocka_unit_test(surfaces_become_records),
		cmocka_unit_test(layers_become_bits),
		cmocka_unit_test(the_hash_covers_surfaces),
		test_one_thread(mips_are_the_same_with_help),
		cmocka_unit_test(nothing_is_left_behind),
		test_one_thread(textures_do_not_wait_in_memory),
		cmocka_unit_test(patient_uploads_count_mips),
		cmocka_unit_test(new_textures_are_made_once),
		cmocka_unit_test(surfaces_are_released_in_turns),
		cmocka_unit_test(ends_while_textures_are_made),
		cmocka_unit_test(arrays_grow_and_shrink),
		cmocka_unit_test(draws_share_images),
		cmocka_unit_test(groups_outlive_changes),
		cmocka_unit_test(nothing_for_scenes_without),
		cmocka_unit_test(programs_are_made_before),
		cmocka_unit_test(programs_of_all_kinds_are_made_before),
		cmocka_unit_test(a_panorama_has_one_gloss),
		test_one_thread(every_allocation_fails_once),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
