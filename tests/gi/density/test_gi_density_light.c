/* Lights are chosen, and points of them, as often as their densities say: lights of the list by closed forms, emitters
 * by gi_light_pdf, surroundings, suns, and the light tree: support/chi_square.h. With the argument "long" more of
 * each. */
#include "support/chi_square.h"

#include "gi/gi_vector.h"
#include "gi/light/gi_environment.h"
#include "gi/light/gi_light_listed.h"

static bool is_long;
static uint32_t draws;

static stilb_vec3 random_point(shade_proof_random *random, float reach)
{
	return stilb_vec3_make(shade_proof_range(random, -reach, reach), shade_proof_range(random, -reach, reach),
	                       shade_proof_range(random, -reach, reach));
}

static gi_emitter triangle(stilb_vec3 a, stilb_vec3 b, stilb_vec3 c, float radiance)
{
	gi_emitter emitter = {.emission = {radiance, radiance, radiance}};
	for (int i = 0; i < 3; i++) {
		emitter.position[0][i] = a[i];
		emitter.position[1][i] = b[i];
		emitter.position[2][i] = c[i];
	}
	return emitter;
}

static gi_lights lights_of(const stilb_scene *scene, const gi_emitter *emitters, uint32_t count)
{
	static const stilb_scene dark;
	gi_lights lights;
	if (gi_lights_create(scene ? scene : &dark, emitters, count, &lights) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return lights;
}

/* ---- all that is asked at a point -------------------------------------------------------------------------------- */

/* A point that asks one group of lights. */
typedef struct asker {
	const gi_lights *lights;
	const gi_emitter *emitters; /* of the group PLACED, */
	uint32_t emitter_count;
	gi_light_group group;
	bool all;
	stilb_vec3 position, normal;
	shade_frame frame;
	double off; /* the density is multiplied by this: 1, but to see that the test sees it */
} asker;

static asker asker_at(const gi_lights *lights, gi_light_group group, stilb_vec3 position, stilb_vec3 normal)
{
	return (asker){.lights = lights,
	               .group = group,
	               .all = true,
	               .position = position,
	               .normal = normal,
	               .frame = shade_frame_from_normal(normal),
	               .off = 1.0};
}

/* A point of an emitter as seen from the asker. */
typedef struct seen_point {
	double distance; /* along the direction; below 0: behind the asker */
	double cosine;   /* at the emitter; below 0: its back */
	double s, t;     /* the point is corner + edge_1 s (1 - t) + edge_2 s t */
	double twice_area;
} seen_point;

static stilb_vec3 corner_of(const gi_emitter *emitter, int i)
{
	return gi_vector(emitter->position[i]);
}

/* Where the direction meets the emitter's plane. */
static seen_point seen_along(const gi_emitter *emitter, stilb_vec3 position, stilb_vec3 direction)
{
	double from[3], e1[3], e2[3], n[3], v[3], above = 0.0, slope = 0.0, n2 = 0.0, a = 0.0, b = 0.0;
	for (int k = 0; k < 3; k++) {
		from[k] = (double)emitter->position[0][k] - (double)position[k];
		e1[k] = (double)emitter->position[1][k] - (double)emitter->position[0][k];
		e2[k] = (double)emitter->position[2][k] - (double)emitter->position[0][k];
	}
	for (int k = 0; k < 3; k++) {
		int p = (k + 1) % 3, q = (k + 2) % 3;
		n[k] = e1[p] * e2[q] - e1[q] * e2[p];
		n2 += n[k] * n[k];
		above += n[k] * from[k];
		slope += n[k] * (double)direction[k];
	}
	double distance = above / slope;
	for (int k = 0; k < 3; k++)
		v[k] = distance * (double)direction[k] - from[k];
	for (int k = 0; k < 3; k++) {
		int p = (k + 1) % 3, q = (k + 2) % 3;
		a += (v[p] * e2[q] - v[q] * e2[p]) * n[k] / n2;
		b += (e1[p] * v[q] - e1[q] * v[p]) * n[k] / n2;
	}
	return (seen_point){distance, -slope / sqrt(n2), a + b, a + b > 0.0 ? b / (a + b) : 0.0, sqrt(n2)};
}

/* A point of the square is one of an emitter: as many columns as there may be emitters, with s across and t along. So
 * a light that is seen edge on is as wide as any other. */
enum { COLUMNS = 32 }; /* a power of two: cells end at the columns' sides */

/* The emitter whose plane is met at the sample's distance, within its sides. */
static void place_of(const asker *a, const gi_light_sample *sample, double at[2])
{
	double nearest = HUGE_VAL;
	for (uint32_t i = 0; i < a->emitter_count; i++) {
		seen_point seen = seen_along(&a->emitters[i], a->position, sample->direction);
		double off = fabs(seen.distance / (double)sample->distance - 1.0);
		off += fmax(seen.s - 1.0, 0.0) + fmax(-seen.t, 0.0) + fmax(seen.t - 1.0, 0.0) + fmax(-seen.s, 0.0);
		if (!(off < nearest) || seen.cosine <= 0.0)
			continue;
		nearest = off;
		at[0] = (i + fmin(fmax(seen.s, 0.0), 0.9999999)) / COLUMNS;
		at[1] = fmin(fmax(seen.t, 0.0), 0.9999999);
	}
	assert_true(nearest < 0.02);
}

static bool asker_draw(const void *context, shade_proof_random *random, double at[2])
{
	const asker *a = context;
	gi_light_sample sample;
	float u_choice = shade_proof_uniform(random);
	stilb_vec2 u = {shade_proof_uniform(random), shade_proof_uniform(random)};
	if (!gi_light_sample_at(a->lights, a->group, a->all, a->position, a->normal, u_choice, u, &sample))
		return false;
	if (a->group == GI_LIGHT_PLACED)
		place_of(a, &sample, at);
	else
		chi_square_place(a->frame, sample.direction, at);
	return true;
}

static double asker_density(const void *context, const double at[2])
{
	const asker *a = context;
	if (a->group == GI_LIGHT_AROUND)
		return a->off * 4.0 * M_PI *
		       (double)gi_environment_pdf(a->lights, a->normal, chi_square_direction(a->frame, at), a->all);
	uint32_t i = (uint32_t)(at[0] * COLUMNS);
	if (i >= a->emitter_count)
		return 0.0;
	const gi_emitter *emitter = &a->emitters[i];
	double s = at[0] * COLUMNS - i;
	stilb_vec3 corner = corner_of(emitter, 0), e1 = corner_of(emitter, 1) - corner, e2 = corner_of(emitter, 2) - corner;
	stilb_vec3 to = corner + e1 * (float)(s * (1.0 - at[1])) + e2 * (float)(s * at[1]) - a->position;
	seen_point seen = seen_along(emitter, a->position, stilb_vec3_normalize(to));
	if (seen.cosine <= 0.0)
		return 0.0;
	double solid = (double)gi_light_pdf(a->lights, a->position, a->normal, i, (float)seen.distance);
	return a->off * solid * seen.cosine / (seen.distance * seen.distance) * seen.twice_area * s * COLUMNS;
}

static chi_square_result compare(const asker *a, uint64_t seed)
{
	return chi_square_compare(&(chi_square_subject){asker_draw, asker_density, a}, seed, draws);
}

/* ---- triangles and rectangles ------------------------------------------------------------------------------------ */

enum { ONE_TRIANGLE, TWO_TRIANGLES, RECTANGLE, KINDS };

/* A shape of up to two metres at the height h above the origin, tilted, facing down. */
static uint32_t shape_over(shade_proof_random *random, int kind, float h, gi_emitter emitters[2])
{
	float turn = shade_proof_range(random, 0.0f, 6.0f), tilt = shade_proof_range(random, 0.0f, 0.4f);
	stilb_vec3 x = {cosf(turn), 0.0f, sinf(turn)}, z = {-sinf(turn), 0.0f, cosf(turn)};
	stilb_vec3 edge_1 = x * shade_proof_range(random, 0.3f, 2.0f) + z * (kind == RECTANGLE ? 0.0f : 0.3f);
	stilb_vec3 edge_2 = z * cosf(tilt) + stilb_vec3_make(0.0f, sinf(tilt), 0.0f);
	stilb_vec3 middle = {shade_proof_range(random, -1.0f, 1.0f), h, shade_proof_range(random, -1.0f, 1.0f)};
	stilb_vec3 a = middle - edge_1 * 0.5f - edge_2 * (0.5f * (tilt > 0.2f ? 0.2f : 1.0f));
	emitters[0] = triangle(a, a + edge_1, a + edge_1 + edge_2, 2.0f);
	emitters[1] = triangle(a, a + edge_1 + edge_2, a + edge_2, 2.0f);
	return kind == ONE_TRIANGLE ? 1 : 2;
}

static void points_of_shapes(void **state)
{
	(void)state;
	static const float heights[] = {0.3f, 3.0f, 0.05f, 1.0f, 20.0f};
	uint32_t rounds = is_long ? 5 : 2;
	chi_square_family family = chi_square_family_of(KINDS * rounds * (is_long ? 5 : 2));
	for (uint32_t i = 0; i < family.planned; i++) {
		shade_proof_random random = {.seed = 10 + i};
		gi_emitter emitters[2];
		float height = heights[i / KINDS / rounds];
		uint32_t count = shape_over(&random, (int)(i % KINDS), height, emitters);
		gi_lights lights = lights_of(NULL, emitters, count);
		assert_int_equal(lights.shape_count, i % KINDS == TWO_TRIANGLES ? 2 : 1);
		stilb_vec3 normal = stilb_vec3_normalize(stilb_vec3_make(0.3f, 1.0f, 0.2f));
		asker a = asker_at(&lights, GI_LIGHT_PLACED, (stilb_vec3){0}, normal);
		a.emitters = emitters;
		a.emitter_count = count;
		chi_square_result got = compare(&a, 20 + i);
		if (!chi_square_passes(&family, got.p))
			fail_msg("%u, kind %u, height %g: p %.2g, integral %.5f", i, i % KINDS, (double)height, got.p, got.mass);
		gi_lights_destroy(&lights);
	}
	chi_square_end(&family);
}

/* Many of all sizes, facing anywhere, with a rectangle: the tree's choice and the point together. */
static void points_of_many(void **state)
{
	(void)state;
	enum { MANY = 31 };
	gi_emitter emitters[MANY];
	shade_proof_random random = {.seed = 3};
	for (int i = 0; i < MANY; i++) {
		float size = shade_proof_log_range(&random, 0.2f, 3.0f);
		stilb_vec3 corner = random_point(&random, 5.0f);
		stilb_vec3 b = corner + random_point(&random, size), c = corner + random_point(&random, size);
		emitters[i] = triangle(corner, b, c, shade_proof_log_range(&random, 0.1f, 10.0f));
	}
	stilb_vec3 corner = {1.0f, 4.0f, 1.0f}, x = {1.0f, 0.0f, 0.0f}, z = {0.0f, 0.0f, 2.0f};
	emitters[7] = triangle(corner, corner + x, corner + x + z, 4.0f);
	emitters[8] = triangle(corner, corner + x + z, corner + z, 4.0f);
	gi_lights lights = lights_of(NULL, emitters, MANY);
	assert_int_equal(lights.shape_count, MANY - 1);
	chi_square_family family = chi_square_family_of(is_long ? 12 : 2);
	for (uint32_t i = 0; i < family.planned; i++) {
		asker a =
			asker_at(&lights, GI_LIGHT_PLACED, random_point(&random, 4.0f), shade_proof_random_direction(&random));
		a.emitters = emitters;
		a.emitter_count = MANY;
		chi_square_result got = compare(&a, 50 + i);
		if (!chi_square_passes(&family, got.p))
			fail_msg("%u: p %.2g, integral %.5f", i, got.p, got.mass);
	}
	chi_square_end(&family);
	gi_lights_destroy(&lights);
}

/* ---- lights of the list ------------------------------------------------------------------------------------------ */

typedef struct listed {
	gi_light_listed light;
	shade_frame frame;
} listed;

/* Closed forms, seen from the origin: a cone's solid angle, or that of a piece of the light's plane over its area. */
static double listed_solid_density(const stilb_scene_light *light, stilb_vec3 direction)
{
	double along = 0.0, distance2 = 0.0, slope = 0.0, above = 0.0, radius = (double)light->radius;
	for (int k = 0; k < 3; k++) {
		along += (double)light->position[k] * (double)direction[k];
		distance2 += (double)light->position[k] * (double)light->position[k];
		slope -= (double)light->direction[k] * (double)direction[k];
		above -= (double)light->direction[k] * (double)light->position[k];
	}
	if (light->kind == STILB_SCENE_LIGHT_SPHERE) {
		double cosine = sqrt(fmax(1.0 - radius * radius / distance2, 0.0));
		return along >= cosine * sqrt(distance2) ? 1.0 / (2.0 * M_PI * (1.0 - cosine)) : 0.0;
	}
	if (slope <= 0.0 || above <= 0.0)
		return 0.0;
	double t = above / slope, off2 = 0.0, x = 0.0, y = 0.0, x2 = 0.0, y2 = 0.0;
	for (int k = 0; k < 3; k++) {
		double off = t * (double)direction[k] - (double)light->position[k];
		off2 += off * off;
		x += off * (double)light->half_x[k];
		y += off * (double)light->half_y[k];
		x2 += (double)(light->half_x[k] * light->half_x[k]);
		y2 += (double)(light->half_y[k] * light->half_y[k]);
	}
	if (light->kind == STILB_SCENE_LIGHT_DISK)
		return off2 <= radius * radius ? t * t / (slope * M_PI * radius * radius) : 0.0;
	return fabs(x) <= x2 && fabs(y) <= y2 ? t * t / (slope * 4.0 * sqrt(x2 * y2)) : 0.0;
}

static double listed_density(const void *context, const double at[2])
{
	const listed *l = context;
	stilb_vec3 direction = chi_square_direction(l->frame, at);
	double by_area = listed_solid_density(&l->light.light, direction);
	if (by_area == 0.0 || l->light.light.kind != STILB_SCENE_LIGHT_RECTANGLE)
		return 4.0 * M_PI * by_area;
	double slope = -(double)stilb_vec3_dot(l->light.shape.normal, direction);
	double above = -(double)stilb_vec3_dot(l->light.shape.normal, l->light.shape.center);
	return 4.0 * M_PI * (double)gi_light_shape_density(&l->light.shape, (stilb_vec3){0}, (float)(above / slope));
}

static bool listed_draw(const void *context, shade_proof_random *random, double at[2])
{
	const listed *l = context;
	gi_light_sample sample;
	stilb_vec2 u = {shade_proof_uniform(random), shade_proof_uniform(random)};
	if (!gi_light_listed_sample(&l->light, (stilb_vec3){0}, u, &sample))
		return false;
	chi_square_place(l->frame, sample.direction, at);
	return true;
}

/* Of a disk and a sphere the density that a choice comes with is the closed form's. */
static void check_listed_choices(const listed *l, shade_proof_random *random)
{
	for (int i = 0; i < 500; i++) {
		gi_light_sample sample;
		stilb_vec2 u = {shade_proof_range(random, 0.01f, 0.99f), shade_proof_uniform(random)};
		if (gi_light_listed_sample(&l->light, (stilb_vec3){0}, u, &sample) &&
		    l->light.light.kind != STILB_SCENE_LIGHT_RECTANGLE)
			SHADE_PROOF_NEAR(sample.pdf, listed_solid_density(&l->light.light, sample.direction), 1e-3, 0.0);
	}
}

static void lights_with_a_size(void **state)
{
	(void)state;
	static const stilb_scene_light_kind kinds[] = {STILB_SCENE_LIGHT_SPHERE, STILB_SCENE_LIGHT_DISK,
	                                               STILB_SCENE_LIGHT_RECTANGLE};
	static const float distances[] = {2.0f, 0.5f, 20.0f, 0.9f};
	uint32_t rounds = is_long ? 4 : 1;
	chi_square_family family = chi_square_family_of(3 * rounds * (is_long ? 4 : 2));
	for (uint32_t i = 0; i < family.planned; i++) {
		shade_proof_random random = {.seed = 80 + i};
		float distance = distances[i / 3 / rounds];
		stilb_vec3 to = shade_proof_random_direction(&random), lean = random_point(&random, 0.5f);
		stilb_vec3 down = stilb_vec3_normalize(lean - to);
		shade_frame plane = shade_frame_from_normal(down);
		stilb_scene_light light = {
			.kind = kinds[i % 3], .intensity = {1.0f, 2.0f, 3.0f}, .radius = shade_proof_range(&random, 0.6f, 1.0f)};
		for (int k = 0; k < 3; k++) {
			light.position[k] = to[k] * distance;
			light.direction[k] = down[k];
			light.half_x[k] = plane.t[k] * 0.8f;
			light.half_y[k] = plane.b[k] * 0.4f;
		}
		listed l = {gi_light_listed_make(&light), shade_frame_from_normal(to)};
		check_listed_choices(&l, &random);
		chi_square_subject subject = {listed_draw, listed_density, &l};
		chi_square_result got = chi_square_compare(&subject, 100 + i, draws);
		if (!chi_square_passes(&family, got.p))
			fail_msg("%u: kind %d, distance %g, radius %g: p %.2g, integral %.5f", i, (int)light.kind, (double)distance,
			         (double)light.radius, got.p, got.mass);
	}
	chi_square_end(&family);
}

/* ---- surroundings ------------------------------------------------------------------------------------------------ */

/* A dim sky, partly black, with a sun of one texel; even: the same all over, of which MIS compensation asks nothing. */
static stilb_image sky_of(shade_proof_random *random, uint32_t width, uint32_t height, float sun)
{
	stilb_image map;
	assert_int_equal(stilb_image_create(&map, width, height, 3, STILB_IMAGE_F32_LINEAR), STILB_OK);
	float *texels = map.pixels;
	for (uint32_t i = 0; i < width * height; i++)
		for (uint32_t c = 0; c < 3; c++)
			texels[3 * i + c] = i % 5 == 0 ? 0.0f : shade_proof_uniform(random) * (float)(1 + c);
	texels[3 * (width * height / 3) + 1] = sun;
	return map;
}

static void surroundings(void **state)
{
	(void)state;
	static const uint32_t sizes[][2] = {{8, 4}, {16, 8}, {1, 1}, {2, 7}, {32, 16}};
	static const float suns[] = {20.0f, 1e4f};
	chi_square_family family = chi_square_family_of(is_long ? 5 * 2 * 2 : 4);
	for (uint32_t i = 0; i < family.planned; i++) {
		shade_proof_random random = {.seed = 140 + i};
		const uint32_t *size = sizes[i / 4];
		stilb_scene scene = {.surroundings = {.rotation = shade_proof_range(&random, -4.0f, 4.0f),
		                                      .panorama = sky_of(&random, size[0], size[1], suns[i / 2 % 2])}};
		gi_lights lights = lights_of(&scene, NULL, 0);
		asker a = asker_at(&lights, GI_LIGHT_AROUND, (stilb_vec3){0}, shade_proof_random_direction(&random));
		a.all = i % 2 == 0;
		bool asked = gi_light_is_asked(&lights, GI_LIGHT_AROUND, a.all);
		assert_true(asked || (!a.all && size[0] == 1)); /* one texel is no brighter than the mean */
		chi_square_result got = asked ? compare(&a, 160 + i) : (chi_square_result){1.0, 0.0};
		if (!chi_square_passes(&family, got.p))
			fail_msg("%u: %u x %u texels, %s: p %.2g, integral %.5f", i, size[0], size[1],
			         a.all ? "all" : "what is above the mean", got.p, got.mass);
		gi_lights_destroy(&lights);
		stilb_image_finish(&scene.surroundings.panorama);
	}
	chi_square_end(&family);
}

static void two_colours(void **state)
{
	(void)state;
	stilb_scene scene = {.surroundings = {.sky = {1.0f, 1.0f, 1.0f}, .ground = {0.1f, 0.2f, 0.3f}}};
	gi_lights lights = lights_of(&scene, NULL, 0);
	asker a =
		asker_at(&lights, GI_LIGHT_AROUND, (stilb_vec3){0}, stilb_vec3_normalize(stilb_vec3_make(0.7f, 0.1f, 0.2f)));
	assert_true(compare(&a, 180).p > CHI_SQUARE_FALSE_ALARM);
	gi_lights_destroy(&lights);
}

/* ---- choices ----------------------------------------------------------------------------------------------------- */

static void suns(void **state)
{
	(void)state;
	enum { MOST = 24 };
	stilb_scene_light list[MOST];
	chi_square_family family = chi_square_family_of(is_long ? 60 : 6);
	for (uint32_t i = 0; i < family.planned; i++) {
		shade_proof_random random = {.seed = 200 + i};
		uint32_t count = 2 + i % 6 * 4, found[MOST] = {0};
		double expected[MOST] = {0.0};
		for (uint32_t k = 0; k < count; k++) {
			stilb_vec3 d = shade_proof_random_direction(&random);
			float intensity = shade_proof_log_range(&random, 0.01f, 100.0f);
			list[k] = (stilb_scene_light){.kind = STILB_SCENE_LIGHT_DIRECTIONAL,
			                              .direction = {d[0], d[1], d[2]},
			                              .intensity = {intensity, intensity, (float)k + 1.0f}};
		}
		stilb_scene scene = {.light_count = count, .lights = list};
		gi_lights lights = lights_of(&scene, NULL, 0);
		stilb_vec3 normal = shade_proof_random_direction(&random);
		for (uint32_t k = 0; k < draws; k++) {
			gi_light_sample sample;
			assert_true(gi_light_sample_at(&lights, GI_LIGHT_SUNS, true, (stilb_vec3){0}, normal,
			                               shade_proof_uniform(&random), (stilb_vec2){0.5f, 0.5f}, &sample));
			uint32_t sun = (uint32_t)sample.radiance[2] - 1;
			found[sun]++;
			expected[sun] = (double)sample.pdf * draws;
		}
		double p = chi_square_p(expected, found, count, 0.0), sum = 0.0;
		for (uint32_t k = 0; k < count; k++)
			sum += expected[k] / draws;
		SHADE_PROOF_NEAR(sum, 1.0, 1e-5, 0.0); /* each has half of an even share at least: all were found */
		if (!chi_square_passes(&family, p))
			fail_msg("%u: %u suns: p %.2g", i, count, p);
		gi_lights_destroy(&lights);
	}
	chi_square_end(&family);
}

#define LIGHTS_MOST 1000u

/* Lamps of all kinds that have a place, some in a cluster, some in one point. */
static void lamp_make(shade_proof_random *random, uint32_t i, stilb_scene_light *lamp)
{
	static const stilb_scene_light_kind kinds[] = {STILB_SCENE_LIGHT_POINT, STILB_SCENE_LIGHT_SPOT,
	                                               STILB_SCENE_LIGHT_SPHERE, STILB_SCENE_LIGHT_DISK};
	stilb_vec3 d = shade_proof_random_direction(random);
	stilb_vec3 at = i % 7 == 0   ? stilb_vec3_make(1.0f, 1.0f, 1.0f)
	                : i % 3 == 0 ? stilb_vec3_make(3.0f, 0.0f, 0.0f) + random_point(random, 0.3f)
	                             : random_point(random, 5.0f);
	float intensity = shade_proof_log_range(random, 0.01f, 100.0f);
	*lamp = (stilb_scene_light){.kind = kinds[i % 4],
	                            .position = {at[0], at[1], at[2]},
	                            .direction = {d[0], d[1], d[2]},
	                            .intensity = {intensity, intensity, intensity},
	                            .cos_inner = 0.9f,
	                            .cos_outer = 0.6f,
	                            .radius = shade_proof_range(random, 0.05f, 0.5f)};
}

static void check_tree(chi_square_family *family, const gi_lights *lights, shade_proof_random *random)
{
	static double expected[2 * LIGHTS_MOST + 1];
	static uint32_t found[2 * LIGHTS_MOST + 1];
	stilb_vec3 position = random_point(random, 6.0f), normal = shade_proof_random_direction(random);
	uint32_t nodes = lights->tree.node_count;
	double sum = 0.0;
	for (uint32_t i = 0; i < nodes; i++) {
		bool leaf = lights->tree.nodes[i].child == GI_LIGHT_LEAF;
		double chance = leaf ? (double)gi_light_tree_probability(&lights->tree, position, normal, i) : 0.0;
		sum += chance;
		expected[i] = chance * draws;
	}
	assert_true(sum < 1.0 + 1e-5);
	expected[nodes] = fmax(1.0 - sum, 0.0) * draws;
	memset(found, 0, sizeof found);
	for (uint32_t i = 0; i < draws; i++) {
		float probability;
		uint32_t leaf =
			gi_light_tree_choose(&lights->tree, position, normal, shade_proof_uniform(random), &probability);
		found[leaf == GI_LIGHT_LEAF ? nodes : leaf]++;
		if (leaf != GI_LIGHT_LEAF)
			SHADE_PROOF_NEAR(probability * (float)draws, expected[leaf], 1e-5, 0.0);
	}
	double p = chi_square_p(expected, found, nodes + 1, 0.0);
	if (!chi_square_passes(family, p))
		fail_msg("%u lights at %g %g %g: p %.2g, probabilities add up to %.6f", lights->placed_count,
		         (double)position[0], (double)position[1], (double)position[2], p, sum);
}

static void the_tree_chooses_as_it_says(void **state)
{
	(void)state;
	static const uint32_t counts[] = {1, 2, 3, 5, 17, 200, LIGHTS_MOST};
	static stilb_scene_light list[LIGHTS_MOST];
	uint32_t places = is_long ? 20 : 2;
	chi_square_family family = chi_square_family_of(7 * places);
	for (uint32_t i = 0; i < 7; i++) {
		shade_proof_random random = {.seed = 300 + i};
		for (uint32_t k = 0; k < counts[i]; k++)
			lamp_make(&random, k, &list[k]);
		stilb_scene scene = {.light_count = counts[i], .lights = list};
		gi_lights lights = lights_of(&scene, NULL, 0);
		assert_int_equal(lights.placed_count, counts[i]);
		for (uint32_t k = 0; k < places; k++)
			check_tree(&family, &lights, &random);
		gi_lights_destroy(&lights);
	}
	chi_square_end(&family);
}

/* What this test is for: a density that is off by 5 % is found, too small and too large. */
static void five_percent_are_found(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 12};
	gi_emitter emitters[2];
	uint32_t count = shape_over(&random, RECTANGLE, 0.4f, emitters);
	gi_lights lights = lights_of(NULL, emitters, count);
	for (int i = 0; i < 2; i++) {
		asker a = asker_at(&lights, GI_LIGHT_PLACED, (stilb_vec3){0}, stilb_vec3_make(0.0f, 1.0f, 0.0f));
		a.emitters = emitters;
		a.emitter_count = count;
		a.off = i ? 1.05 : 0.95;
		assert_true(compare(&a, 1).p < 1e-9);
	}
	gi_lights_destroy(&lights);
}

int main(int argc, char **argv)
{
	is_long = argc > 1 && strcmp(argv[1], "long") == 0;
	draws = is_long ? 40000 : TEST_ASAN || TEST_EMULATED ? 10000 : 30000;
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(points_of_shapes),
		cmocka_unit_test(points_of_many),
		cmocka_unit_test(lights_with_a_size),
		cmocka_unit_test(surroundings),
		cmocka_unit_test(two_colours),
		cmocka_unit_test(suns),
		cmocka_unit_test(the_tree_chooses_as_it_says),
		cmocka_unit_test(five_percent_are_found),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
