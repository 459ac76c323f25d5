/* Light at texels against closed forms: an even sky, a furnace, a wall beside a plane, a square that shines on another;
 * what lies inside of something; the same bits for any number of workers. */
#include "bake_made.h"

#include "bake/bake_fill.h"
#include "bake/bake_light.h"

typedef struct baked {
	stilb_scene *scene;
	stilb_job_pool *pool;
	stilb_gi_scene *gi;
	stilb_gi_gather *gather;
	stilb_bake_atlas *atlas;
	stilb_bake_texels *texels;
	stilb_bake_layers layers;
} baked;

typedef struct bake_how {
	float density;
	uint32_t side, samples, workers, depth;
	stilb_gi_only only;
	bool keep_hidden, directional;
} bake_how;

static baked bake(stilb_scene *scene, bake_how how)
{
	baked b = {.scene = scene, .pool = made_pool(how.workers)};
	stilb_gi_scene_desc desc = {.pool = b.pool, .intersector = &stilb_gi_embree};
	stilb_bake_atlas_options options = stilb_bake_atlas_options_default();
	stilb_gi_settings settings = stilb_gi_settings_default(scene);
	options.density = how.density;
	options.side = how.side;
	settings.samples = how.samples;
	settings.depth = how.depth;
	settings.only = how.only;
	assert_int_equal(stilb_gi_scene_create(scene, &desc, &b.gi), STILB_OK);
	assert_int_equal(stilb_gi_gather_create(b.gi, &settings, how.workers + 1, &b.gather), STILB_OK);
	assert_int_equal(stilb_bake_atlas_create(scene, &options, b.pool, &b.atlas), STILB_OK);
	assert_int_equal(b.atlas->page_count, 1);
	assert_int_equal(stilb_bake_texels_create(b.atlas, 0, b.pool, &b.texels), STILB_OK);
	size_t count = (size_t)how.side * how.side;
	b.layers.light = calloc(count, sizeof *b.layers.light);
	b.layers.open = calloc(count, sizeof *b.layers.open);
	b.layers.state = calloc(count, 1);
	b.layers.directional = how.directional ? calloc(count, sizeof *b.layers.directional) : NULL;
	stilb_bake_light_options light = {.samples = how.samples, .ao_distance = INFINITY, .keep_hidden = how.keep_hidden};
	assert_int_equal(stilb_bake_light(scene, b.atlas, b.texels, b.gather, b.pool, &light, &b.layers), STILB_OK);
	return b;
}

static void baked_finish(baked *b)
{
	free(b->layers.light);
	free(b->layers.directional);
	free(b->layers.open);
	free(b->layers.state);
	stilb_bake_texels_destroy(b->texels);
	stilb_bake_atlas_destroy(b->atlas);
	stilb_gi_gather_destroy(b->gather);
	stilb_gi_scene_destroy(b->gi);
	stilb_scene_destroy(b->scene);
	stilb_job_pool_destroy(b->pool);
}

static stilb_scene *opened(const char *name)
{
	stilb_scene *scene;
	assert_int_equal(stilb_scene_open(name, &scene), STILB_OK);
	return scene;
}

/* The part that a texel shows; STILB_SCENE_NONE: none. */
static uint32_t part_of(const baked *b, size_t texel)
{
	uint32_t place = b->texels->place[texel];
	return place == STILB_BAKE_NO_CHART ? STILB_SCENE_NONE : b->texels->part[place];
}

/* The place of a texel's spot in the world. False: there is none. */
static bool spot_at(const baked *b, size_t texel, uint32_t cell, double at[3])
{
	const stilb_bake_spot *spot = &b->texels->spots[texel][cell];
	if (!(spot->share > 0.0f))
		return false;
	uint32_t part = part_of(b, texel);
	const stilb_scene_mesh *mesh = &b->scene->meshes[b->scene->part_mesh[part]];
	const float *m = b->scene->part_transform[part].m;
	float share[3] = {1.0f - spot->u - spot->v, spot->u, spot->v}, p[3] = {0.0f, 0.0f, 0.0f};
	for (uint32_t i = 0; i < 3; i++)
		for (int k = 0; k < 3; k++)
			p[k] += share[i] * mesh->vertices[mesh->indices[3 * spot->triangle + i]].position[k];
	for (int k = 0; k < 3; k++)
		at[k] = (double)(m[k] * p[0] + m[4 + k] * p[1] + m[8 + k] * p[2] + m[12 + k]);
	return true;
}

/* The mean over a texel's spots of their places, and of what f says of them; f NULL: 0. */
static double mean_over(const baked *b, size_t texel, double (*f)(const double at[3]), double mean[3])
{
	double sum = 0.0, at[3];
	uint32_t count = 0;
	memset(mean, 0, 3 * sizeof *mean);
	for (uint32_t c = 0; c < STILB_BAKE_CELLS; c++) {
		if (!spot_at(b, texel, c, at))
			continue;
		for (int k = 0; k < 3; k++)
			mean[k] += at[k];
		sum += f ? f(at) : 0.0;
		count++;
	}
	for (int k = 0; k < 3; k++)
		mean[k] /= count;
	return sum / count;
}

/* ---- closed forms ------------------------------------------------------------------------------------------------ */

/* A square of side 2 * half at height y that faces up, or down. */
static void square_mesh(stilb_scene_mesh *mesh, float half, float y, bool up)
{
	assert_int_equal(scene_mesh_create(mesh, 4, 6), STILB_OK);
	const uint32_t indices[2][6] = {{0, 1, 2, 2, 1, 3}, {0, 2, 1, 2, 3, 1}};
	for (uint32_t i = 0; i < 4; i++) {
		mesh->vertices[i] = (stilb_scene_vertex){.normal = {0.0f, up ? 1.0f : -1.0f, 0.0f}};
		made_set(mesh->vertices[i].position, i & 1 ? half : -half, y, i & 2 ? half : -half);
	}
	memcpy(mesh->indices, indices[up], sizeof indices[up]);
}

static stilb_scene *squares(uint32_t count)
{
	stilb_scene *scene;
	assert_int_equal(scene_create(1, count, count, count, &scene), STILB_OK);
	scene->first_part[1] = count;
	for (uint32_t i = 0; i < count; i++) {
		scene->part_mesh[i] = scene->part_material[i] = i;
		scene->part_transform[i] = stilb_mat4_identity();
		scene->materials[i] = (stilb_scene_material){.diffuse = {0.5f, 0.5f, 0.5f}, .roughness = 1.0f};
	}
	return scene;
}

/* Under an even sky of radiance L a plane has irradiance pi L, and is open: to the last digits, as every ray finds the
 * same. */
static void test_an_even_sky(void **state)
{
	(void)state;
	stilb_scene *scene = squares(1);
	const float sky[3] = {1.0f, 2.0f, 0.5f};
	square_mesh(&scene->meshes[0], 1.0f, 0.0f, true);
	stilb_scene_set_sky(scene, sky);
	baked b = bake(scene, (bake_how){.side = 64, .samples = 16, .depth = 8});
	for (size_t i = 0; i < 64 * 64; i++) {
		if (part_of(&b, i) == STILB_SCENE_NONE) {
			assert_int_equal(b.layers.state[i], STILB_BAKE_EMPTY);
			continue;
		}
		assert_int_equal(b.layers.state[i], STILB_BAKE_LIT);
		assert_float_equal(b.layers.open[i], 1.0f, 0.0f);
		for (int k = 0; k < 3; k++)
			assert_float_equal(b.layers.light[i][k], sky[k], 1e-5f * sky[k]);
	}
	baked_finish(&b);
}

typedef struct sums {
	double sum, squares;
	uint32_t count;
} sums;

static void sums_add(sums *s, double value)
{
	s->sum += value;
	s->squares += value * value;
	s->count++;
}

/* Asserts that the mean is the truth within 4 standard errors, and within a share of it. */
static void assert_mean(const sums *s, double truth, double share)
{
	double mean = s->sum / s->count, variance = s->squares / s->count - mean * mean, error = sqrt(variance / s->count);
	if (!(fabs(mean - truth) <= 4.0 * error + 1e-6) || !(fabs(mean / truth - 1.0) <= share))
		fail_msg("%.6f +- %.6f of %u texels, not %.6f", mean, error, s->count, truth);
}

/* Asserts that the mean is the truth within a share of it. */
static void assert_mean_near(const sums *s, double truth, double share)
{
	double mean = s->sum / s->count;
	if (!(fabs(mean / truth - 1.0) <= share))
		fail_msg("%.6f, not %.6f", mean, truth);
}

/* Squares that are turned, stretched, mirrored, under a white sky over black ground, with normals that lean off. All is
 * about the z axis: directions above the normal's horizon, above the square and above the ground are those between two
 * angles, which a normal weighs with (sin high - sin low) / 2, counted from it. */
static void test_parts_that_lean(void **state)
{
	(void)state;
	static const float leans[4] = {0.4f, 1.1f, 0.7f, 0.2f},
					   scales[4][3] = {
						   {1.0f, 1.0f, 1.0f}, {0.5f, 3.0f, 1.2f}, {1.0f, 1.0f, -1.0f}, {-2.0f, 0.5f, 1.0f}};
	stilb_scene *scene = squares(4);
	const float black[3] = {0.0f, 0.0f, 0.0f};
	double truths[4];
	for (uint32_t p = 0; p < 4; p++) {
		float c = cosf(leans[p]), s = sinf(leans[p]);
		stilb_mat4 *m = &scene->part_transform[p];
		square_mesh(&scene->meshes[p], 1.0f, 0.0f, true);
		made_set(&m->m[0], c * scales[p][0], s * scales[p][0], 0.0f);
		made_set(&m->m[4], -s * scales[p][1], c * scales[p][1], 0.0f);
		made_set(&m->m[8], 0.0f, 0.0f, scales[p][2]);
		m->m[12] = 100.0f * (float)p;
		/* Leans by 0.2 towards x before it is stretched: (0.2, 1) becomes (0.2 / x scale, 1 / y scale). */
		for (uint32_t v = 0; v < 4; v++)
			made_set(scene->meshes[p].vertices[v].normal, 0.2f, 1.0f, 0.0f);
		float x = 0.2f / scales[p][0], y = 1.0f / scales[p][1];
		double normal = (double)atan2f(x * c - y * s, x * s + y * c), own = -(double)leans[p];
		double low = fmax(fmax(normal, own), 0.0) - 0.5 * M_PI, high = fmin(fmin(normal, own), 0.0) + 0.5 * M_PI;
		truths[p] = 0.5 * (sin(high - normal) - sin(low - normal));
	}
	stilb_scene_set_sky(scene, black);
	made_set(scene->surroundings.sky, 1.0f, 1.0f, 1.0f);
	baked b = bake(scene, (bake_how){.density = 8.0f, .side = 128, .samples = 64, .depth = 1});
	for (uint32_t p = 0; p < 4; p++) {
		sums light = {0};
		for (size_t i = 0; i < 128 * 128; i++)
			if (part_of(&b, i) == p)
				sums_add(&light, (double)b.layers.light[i][0]);
		assert_true(light.count > 100);
		assert_mean_near(&light, truths[p], 2e-3);
	}
	baked_finish(&b);
}

/* Inside a ball that shines with 1 and reflects rho: radiance, and so what a white surface sends, is 1 / (1 - rho).
 * Its light alone is 1, what is reflected the rest. */
static void test_a_furnace(void **state)
{
	(void)state;
	static const struct {
		uint32_t depth;
		stilb_gi_only only;
		double truth;
	} cases[] = {{64, STILB_GI_ALL_LIGHT, 2.0},
	             {64, STILB_GI_ONLY_INDIRECT, 1.0},
	             {1, STILB_GI_ALL_LIGHT, 1.0},
	             {2, STILB_GI_ALL_LIGHT, 1.5}};
	for (size_t c = 0; c < sizeof cases / sizeof *cases; c++) {
		baked b = bake(opened("furnace:0.5"),
		               (bake_how){.side = 64, .samples = 16, .depth = cases[c].depth, .only = cases[c].only});
		sums all = {0};
		for (size_t i = 0; i < 64 * 64; i++)
			if (part_of(&b, i) != STILB_SCENE_NONE)
				sums_add(&all, (double)b.layers.light[i][1]);
		assert_true(all.count > 1000);
		assert_mean(&all, cases[c].truth, 0.01);
		baked_finish(&b);
	}
}

/* Beside a wall of height 1, at distance d, (1 + cos atan(1 / d)) / 2 of the sky is seen: openness, and, as the wall is
 * black, light. */
static double open_beside_wall(const double at[3])
{
	return 0.5 * (1.0 + cos(atan2(1.0, at[0])));
}

static void test_a_wall_beside_a_plane(void **state)
{
	(void)state;
	stilb_scene *scene = opened("plane-wall");
	for (uint32_t m = 0; m < scene->mesh_count; m++) /* smaller, so that texels are: what lies beyond hides little */
		for (uint32_t v = 0; v < scene->meshes[m].vertex_count; v++)
			if (m == 0)
				for (int k = 0; k < 3; k += 2)
					scene->meshes[m].vertices[v].position[k] *= 0.04f;
	baked b = bake(scene, (bake_how){.density = 12.0f, .side = 2048, .samples = 64, .depth = 1});
	sums open = {0}, light = {0};
	for (size_t i = 0; i < (size_t)2048 * 2048; i++) {
		double at[3];
		if (part_of(&b, i) != 0)
			continue;
		double truth = mean_over(&b, i, open_beside_wall, at);
		if (at[0] < 0.2 || at[0] > 4.0 || fabs(at[2]) > 3.0)
			continue;
		sums_add(&open, (double)b.layers.open[i] - truth + 1.0);
		sums_add(&light, (double)b.layers.light[i][0] - truth + 1.0);
	}
	assert_true(open.count > 1000);
	assert_mean(&open, 1.0, 1e-3);
	assert_mean(&light, 1.0, 1e-3);
	baked_finish(&b);
}

/* The form factor of a rectangle a x b parallel to a small surface below its corner, at distance 1: Howell's catalogue,
 * B-4. */
static double corner_factor(double a, double b)
{
	double x = a / sqrt(1.0 + a * a), y = b / sqrt(1.0 + b * b);
	return (x * atan(b / sqrt(1.0 + a * a)) + y * atan(a / sqrt(1.0 + b * b))) / (2.0 * 3.14159265358979);
}

/* Of a square of side 1 at height 1: the rectangles to its corners with their signs. */
static double square_factor(const double at[3])
{
	double sum = 0.0;
	for (int i = 0; i < 4; i++) {
		double a = 0.5 + (i & 1 ? at[0] : -at[0]), b = 0.5 + (i & 2 ? at[2] : -at[2]);
		sum += copysign(corner_factor(fabs(a), fabs(b)), a * b);
	}
	return sum;
}

/* A square that shines with radiance 1 above another one: light is the form factor, texel by texel. */
static void test_form_factors(void **state)
{
	(void)state;
	stilb_scene *scene = squares(2);
	const float black[3] = {0.0f, 0.0f, 0.0f};
	square_mesh(&scene->meshes[0], 1.0f, 0.0f, true);
	square_mesh(&scene->meshes[1], 0.5f, 1.0f, false);
	stilb_scene_set_sky(scene, black);
	scene->materials[1] = (stilb_scene_material){.roughness = 1.0f, .emission = {1.0f, 1.0f, 1.0f}};
	baked b = bake(scene, (bake_how){.side = 64, .samples = 1024, .depth = 1});
	sums all = {0};
	double worst = 0.0;
	for (size_t i = 0; i < 64 * 64; i++) {
		double at[3];
		if (part_of(&b, i) != 0)
			continue;
		double truth = mean_over(&b, i, square_factor, at), value = (double)b.layers.light[i][0];
		worst = fmax(worst, fabs(value - truth));
		sums_add(&all, value - truth + 1.0);
	}
	assert_true(all.count > 500);
	assert_mean(&all, 1.0, 1e-4);
	if (worst > 1e-3)
		fail_msg("a texel is off by %g", worst);
	baked_finish(&b);
}

/* ---- three directions -------------------------------------------------------------------------------------------- */

/* The directions of the basis in the world at the texel of a square: by its corners on the page and in the world. */
static void world_basis(const baked *b, size_t texel, double basis[STILB_BAKE_BASIS][3])
{
	uint32_t part = part_of(b, texel), page, t = b->texels->spots[texel][0].triangle;
	const stilb_scene_mesh *mesh = &b->scene->meshes[b->scene->part_mesh[part]];
	const float *m = b->scene->part_transform[part].m;
	float at[3][2];
	double world[3][3], u[3], v[3], n[3], lengths[3] = {0.0, 0.0, 0.0};
	assert_true(stilb_bake_atlas_corners(b->atlas, part, t, &page, at));
	for (int i = 0; i < 3; i++) {
		const float *p = mesh->vertices[mesh->indices[3 * t + (uint32_t)i]].position;
		for (int k = 0; k < 3; k++)
			world[i][k] = (double)(m[k] * p[0] + m[4 + k] * p[1] + m[8 + k] * p[2]);
	}
	/* Squares on pages are not sheared, so u and v are perpendicular already; the front of the squares here is up. */
	double bx = (double)(at[1][0] - at[0][0]), by = (double)(at[1][1] - at[0][1]), cx = (double)(at[2][0] - at[0][0]),
		   cy = (double)(at[2][1] - at[0][1]);
	for (int k = 0; k < 3; k++) {
		u[k] = (cy * (world[1][k] - world[0][k]) - by * (world[2][k] - world[0][k])) / (bx * cy - by * cx);
		v[k] = (bx * (world[2][k] - world[0][k]) - cx * (world[1][k] - world[0][k])) / (bx * cy - by * cx);
		n[k] = (double)m[4 + k];
	}
	for (int k = 0; k < 3; k++) {
		lengths[0] += u[k] * u[k];
		lengths[1] += v[k] * v[k];
		lengths[2] += n[k] * n[k];
	}
	for (uint32_t d = 0; d < STILB_BAKE_BASIS; d++) {
		stilb_vec3 local = stilb_bake_basis(d);
		for (int k = 0; k < 3; k++)
			basis[d][k] = (double)local[0] * u[k] / sqrt(lengths[0]) + (double)local[1] * v[k] / sqrt(lengths[1]) +
			              (double)local[2] * n[k] / sqrt(lengths[2]);
	}
}

#define SUNS 2

static const double suns[SUNS][3] = {{0.48, 0.8, 0.36}, {-0.936, 0.28, 0.2134}};
static const float sun_colors[SUNS][3] = {{3.0f, 2.0f, 1.0f}, {1.0f, 4.0f, 2.0f}};

/* The mean of what the three colours of part `part` are off, over the lightmap; all of them are asserted to have it as
 * their mean. */
static double off_suns(const baked *b, uint32_t part)
{
	double off = 0.0;
	uint32_t count = 0;
	for (size_t i = 0; i < 64 * 64; i++) {
		double basis[STILB_BAKE_BASIS][3];
		if (part_of(b, i) != part || !(b->texels->spots[i][0].share > 0.0f))
			continue;
		world_basis(b, i, basis);
		for (int ch = 0; ch < 3; ch++) {
			double expected[STILB_BAKE_BASIS] = {0.0}, mean = 0.0, sum = 0.0, light = (double)b->layers.light[i][ch];
			for (uint32_t k = 0; k < STILB_BAKE_BASIS; k++) {
				for (int s = 0; s < SUNS; s++)
					expected[k] +=
						(double)sun_colors[s][ch] *
						fmax(basis[k][0] * suns[s][0] + basis[k][1] * suns[s][1] + basis[k][2] * suns[s][2], 0.0);
				mean += expected[k] / 3.0;
			}
			for (uint32_t k = 0; k < STILB_BAKE_BASIS; k++) {
				double value = (double)b->layers.directional[i][k][ch];
				sum += value;
				off += fabs(value / light - expected[k] / mean) / 9.0;
			}
			assert_true(fabs(sum / (3.0 * light) - 1.0) < 1e-5);
		}
		count++;
	}
	assert_true(count > 100);
	return off / count;
}

/* Two suns of different colours, one near the horizon: E_k is the sum of max(b_k . l, 0) of them, on a square, one that
 * is turned, and one that is mirrored. */
static void test_three_directions_of_suns(void **state)
{
	(void)state;
	stilb_scene *scene = squares(3);
	const float black[3] = {0.0f, 0.0f, 0.0f};
	float c = cosf(0.15f), s = sinf(0.15f);
	for (uint32_t p = 0; p < 3; p++)
		square_mesh(&scene->meshes[p], 1.0f, 0.0f, true);
	made_set(&scene->part_transform[1].m[0], c, s, 0.0f);
	made_set(&scene->part_transform[1].m[4], -s, c, 0.0f);
	made_set(&scene->part_transform[2].m[8], 0.0f, 0.0f, -1.0f);
	scene->part_transform[1].m[12] = 50.0f;
	scene->part_transform[2].m[12] = 100.0f;
	stilb_scene_set_sky(scene, black);
	scene->lights = calloc(SUNS, sizeof *scene->lights);
	scene->light_count = SUNS;
	for (int i = 0; i < SUNS; i++) {
		scene->lights[i] = (stilb_scene_light){.kind = STILB_SCENE_LIGHT_DIRECTIONAL};
		for (int k = 0; k < 3; k++) {
			scene->lights[i].direction[k] = -(float)suns[i][k];
			scene->lights[i].intensity[k] = sun_colors[i][k];
		}
	}
	baked b = bake(scene, (bake_how){.side = 64, .samples = 256, .depth = 1, .directional = true});
	for (uint32_t part = 0; part < 3; part++)
		assert_true(off_suns(&b, part) < 0.01);
	baked_finish(&b);
}

/* Under an even sky all three are the lightmap, but for noise: a bump changes nothing. */
static void test_three_directions_of_an_even_sky(void **state)
{
	(void)state;
	stilb_scene *scene = squares(1);
	const float sky[3] = {1.0f, 2.0f, 0.5f};
	square_mesh(&scene->meshes[0], 1.0f, 0.0f, true);
	stilb_scene_set_sky(scene, sky);
	baked b = bake(scene, (bake_how){.side = 64, .samples = 64, .depth = 1, .directional = true});
	sums each[STILB_BAKE_BASIS] = {{0}};
	for (size_t i = 0; i < 64 * 64; i++) {
		float intensities[STILB_BAKE_BASIS];
		if (part_of(&b, i) == STILB_SCENE_NONE)
			continue;
		stilb_bake_intensities(b.layers.directional[i], intensities);
		assert_float_equal(intensities[0] + intensities[1] + intensities[2], 3.0f, 1e-5f);
		for (uint32_t k = 0; k < STILB_BAKE_BASIS; k++) {
			assert_float_equal(b.layers.directional[i][k][1], 2.0f * intensities[k], 1e-4f);
			sums_add(&each[k], (double)b.layers.directional[i][k][0]);
		}
	}
	for (uint32_t k = 0; k < STILB_BAKE_BASIS; k++)
		assert_mean(&each[k], 1.0, 5e-3);
	stilb_vec3 flat = stilb_bake_basis_weights(stilb_vec3_make(0.0f, 0.0f, 1.0f)),
			   first = stilb_bake_basis_weights(stilb_bake_basis(0));
	for (int k = 0; k < 3; k++) {
		assert_float_equal(flat[k], 1.0f / 3.0f, 1e-6f);
		assert_float_equal(first[k], k == 0, 1e-6f);
	}
	baked_finish(&b);
}

/* ---- beside pictures --------------------------------------------------------------------------------------------- */

#define BESIDE_SAMPLES 2048u

/* What the path tracer's picture shows at a place of a surface of this diffuse colour, as a white one would: mean and
 * square of the standard error, green. */
static double seen_at(const baked *b, const double at[3], const float normal[3], float diffuse, double *square)
{
	stilb_gi_settings settings = stilb_gi_settings_default(b->scene);
	stilb_gi_render *render;
	settings.width = settings.height = 1;
	settings.samples = BESIDE_SAMPLES;
	settings.depth = 16;
	settings.camera = (stilb_scene_camera){.fov_y = 1e-3f, .near_z = 1e-3f, .far_z = 10.0f};
	for (int k = 0; k < 3; k++)
		settings.camera.position[k] = (float)at[k] + 0.01f * normal[k];
	settings.camera.yaw = atan2f(normal[0], normal[2]); /* looks along -normal */
	settings.camera.pitch = -asinf(normal[1]);
	assert_int_equal(stilb_gi_render_create(b->gi, &settings, b->pool, &render), STILB_OK);
	assert_int_equal(stilb_gi_render_run(render), STILB_OK);
	stilb_gi_film film = stilb_gi_render_film(render);
	double mean = (double)film.radiance[1] / (double)diffuse;
	*square = (double)film.variance[1] / (double)(diffuse * diffuse);
	stilb_gi_render_destroy(render);
	return mean;
}

/* Some texels of the Cornell box, each beside pictures of its spots. */
static void test_texels_beside_pictures(void **state)
{
	(void)state;
	baked b = bake(opened("cornell"), (bake_how){.side = 64, .samples = 1, .depth = 16});
	uint32_t chosen[12], count = 0;
	uint64_t random = 5;
	while (count < 12) {
		uint32_t i = (uint32_t)(4096.0f * made_random(&random));
		uint32_t part = part_of(&b, i);
		if (part == STILB_SCENE_NONE || b.layers.state[i] != STILB_BAKE_LIT ||
		    b.scene->materials[b.scene->part_material[part]].diffuse[1] < 0.1f)
			continue;
		chosen[count++] = i;
	}
	for (uint32_t i = 0; i < 4096; i++) {
		bool kept = false;
		for (uint32_t k = 0; k < count; k++)
			kept |= chosen[k] == i;
		if (!kept)
			b.texels->place[i] = STILB_BAKE_NO_CHART;
	}
	stilb_gi_settings settings = stilb_gi_settings_default(b.scene);
	settings.samples = BESIDE_SAMPLES;
	settings.depth = 16;
	stilb_gi_gather_destroy(b.gather);
	assert_int_equal(stilb_gi_gather_create(b.gi, &settings, 1, &b.gather), STILB_OK);
	stilb_bake_light_options light = {.samples = BESIDE_SAMPLES, .ao_distance = 1.0f};
	assert_int_equal(stilb_bake_light(b.scene, b.atlas, b.texels, b.gather, b.pool, &light, &b.layers), STILB_OK);
	for (uint32_t k = 0; k < count; k++) {
		uint32_t part = part_of(&b, chosen[k]), spots = 0;
		const stilb_scene_mesh *mesh = &b.scene->meshes[b.scene->part_mesh[part]];
		float diffuse = b.scene->materials[b.scene->part_material[part]].diffuse[1];
		double mean = 0.0, squares = 0.0;
		for (uint32_t c = 0; c < STILB_BAKE_CELLS; c++) {
			double at[3], square;
			if (!spot_at(&b, chosen[k], c, at))
				continue;
			uint32_t corner = mesh->indices[3 * b.texels->spots[chosen[k]][c].triangle];
			mean += seen_at(&b, at, mesh->vertices[corner].normal, diffuse, &square);
			squares += square;
			spots++;
		}
		mean /= spots;
		double error = sqrt(2.0 * squares) / spots, value = (double)b.layers.light[chosen[k]][1];
		if (!(fabs(value - mean) <= 4.5 * error) || !(error < 0.03 * mean))
			fail_msg("texel %u: %.5f, the picture %.5f +- %.5f", chosen[k], value, mean, error);
	}
	baked_finish(&b);
}

/* ---- inside of something ----------------------------------------------------------------------------------------- */

/* A box stands on a floor under an even sky: texels below it are hidden, and then filled with light from around; those
 * beside it are not black. */
static void test_texels_below_a_box(void **state)
{
	(void)state;
	stilb_scene *scene = squares(2);
	const float sky[3] = {1.0f, 1.0f, 1.0f};
	made_mesh cube = made_cube();
	square_mesh(&scene->meshes[0], 2.0f, 0.0f, true);
	assert_int_equal(scene_mesh_create(&scene->meshes[1], 24, 36), STILB_OK);
	for (uint32_t v = 0; v < 24; v++) {
		scene->meshes[1].vertices[v] = (stilb_scene_vertex){0};
		memcpy(scene->meshes[1].vertices[v].position, cube.positions[v], sizeof cube.positions[v]);
	}
	memcpy(scene->meshes[1].indices, cube.indices, 36 * sizeof *cube.indices);
	made_finish(&cube);
	stilb_scene_set_sky(scene, sky);
	baked b = bake(scene, (bake_how){.side = 64, .samples = 16, .depth = 4});
	uint32_t hidden = 0;
	for (size_t i = 0; i < 64 * 64; i++) {
		double at[3];
		if (part_of(&b, i) != 0)
			continue;
		mean_over(&b, i, NULL, at);
		bool below = at[0] > 0.06 && at[0] < 0.94 && at[2] > 0.06 && at[2] < 0.94;
		bool beside = at[0] < -0.06 || at[0] > 1.06 || at[2] < -0.06 || at[2] > 1.06;
		if (below)
			assert_int_equal(b.layers.state[i], STILB_BAKE_HIDDEN);
		if (beside)
			assert_int_equal(b.layers.state[i], STILB_BAKE_LIT);
		hidden += below;
	}
	assert_true(hidden > 20);
	assert_int_equal(stilb_bake_fill(64, b.texels->place, 3, b.layers.state, true, b.layers.light[0], 3), STILB_OK);
	for (size_t i = 0; i < 64 * 64; i++)
		if (part_of(&b, i) == 0)
			assert_true(b.layers.light[i][0] > 0.3f && b.layers.state[i] != STILB_BAKE_HIDDEN);
	baked_finish(&b);
}

/* What a page is filled with: a border of three texels around the chart has light, nothing beyond. */
static void test_the_border_is_filled(void **state)
{
	(void)state;
	uint32_t place[16 * 16];
	uint8_t states[16 * 16] = {0};
	float values[16 * 16] = {0};
	memset(place, 0xff, sizeof place);
	for (int y = 6; y < 9; y++)
		for (int x = 6; x < 9; x++) {
			place[16 * y + x] = 0;
			states[16 * y + x] = x == 7 && y == 7 ? STILB_BAKE_HIDDEN : STILB_BAKE_LIT;
			values[16 * y + x] = x == 7 && y == 7 ? 0.0f : 3.0f;
		}
	assert_int_equal(stilb_bake_fill(16, place, 3, states, true, values, 1), STILB_OK);
	for (int y = 0; y < 16; y++)
		for (int x = 0; x < 16; x++) {
			bool within = x >= 3 && x < 12 && y >= 3 && y < 12;
			assert_float_equal(values[16 * y + x], within ? 3.0f : 0.0f, 1e-6f);
			assert_true((states[16 * y + x] == STILB_BAKE_EMPTY) == !within);
		}
}

/* ---- bits -------------------------------------------------------------------------------------------------------- */

static uint64_t bits_of(uint32_t workers)
{
	baked b = bake(opened("cornell"), (bake_how){.side = 64, .samples = 6, .depth = 8, .workers = workers});
	uint64_t hash = stilb_hash_fnv1a64(STILB_FNV1A64_START, b.layers.light, 64 * 64 * sizeof *b.layers.light);
	hash = stilb_hash_fnv1a64(hash, b.layers.open, 64 * 64 * sizeof *b.layers.open);
	hash = stilb_hash_fnv1a64(hash, b.layers.state, 64 * 64);
	baked_finish(&b);
	return hash;
}

static void test_the_same_bits_for_any_workers(void **state)
{
	(void)state;
	uint64_t alone = bits_of(0);
	assert_true(alone == bits_of(1));
	assert_true(alone == bits_of(3));
}

static bool give_up(void *user, double done)
{
	(void)user;
	assert_true(done >= 0.0 && done <= 1.0);
	return false;
}

static void test_it_can_be_given_up(void **state)
{
	(void)state;
	baked b = bake(opened("cornell"), (bake_how){.side = 64, .samples = 1, .depth = 1});
	stilb_bake_light_options light = {.samples = 64, .ao_distance = 1.0f, .watch = give_up};
	assert_int_equal(stilb_bake_light(b.scene, b.atlas, b.texels, b.gather, b.pool, &light, &b.layers),
	                 STILB_ERROR_GIVEN_UP);
	baked_finish(&b);
}

int main(void)
{
	static const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_an_even_sky),
		cmocka_unit_test(test_parts_that_lean),
		cmocka_unit_test(test_a_furnace),
		cmocka_unit_test(test_a_wall_beside_a_plane),
		cmocka_unit_test(test_form_factors),
		cmocka_unit_test(test_three_directions_of_suns),
		cmocka_unit_test(test_three_directions_of_an_even_sky),
		cmocka_unit_test(test_texels_beside_pictures),
		cmocka_unit_test(test_texels_below_a_box),
		cmocka_unit_test(test_the_border_is_filled),
		cmocka_unit_test(test_the_same_bits_for_any_workers),
		cmocka_unit_test(test_it_can_be_given_up),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
