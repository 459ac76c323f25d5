/* Records of the irradiance cache and the octree that they lie in: up to which distance a record is valid, that a
 * lookup finds exactly the records that are valid at a position, and that several threads may insert at once. */
#include "gi/cache/gi_cache_octree.h"
#include "support/test.h"

#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>

static const float low[3] = {-1.0f, 0.0f, 2.0f}, high[3] = {1.0f, 3.0f, 4.0f};

static const gi_cache_limits limits = {
	.error = 0.5f, .turn = 0.5f, .gradients = true, .shortest = 0.01f, .longest = 0.5f, .unit = 0.2f};

static gi_cache_record record_of(const gi_cache_gathered *gathered, stilb_vec3 position, stilb_gi_cache_radius radius)
{
	gi_cache_limits with = limits;
	with.radius = radius;
	return gi_cache_record_make(gathered, shade_frame_from_normal(stilb_vec3_make(0.0f, 1.0f, 0.0f)), position, &with);
}

static gi_cache_gathered gathered_grey(float irradiance, float nearness)
{
	return (gi_cache_gathered){.irradiance = {irradiance, irradiance, irradiance}, .nearness = nearness};
}

static float error_at(const gi_cache_record *record, float x, float y, float z)
{
	return gi_cache_record_error(record, stilb_vec3_make(x, y, z), record->normal, limits.turn);
}

/* ---- records ----------------------------------------------------------------------------------------------------- */

static void split_sphere_has_wards_radius(void **state)
{
	(void)state;
	gi_cache_gathered gathered = gathered_grey(1.0f, 2.5f);
	gi_cache_record record = record_of(&gathered, stilb_vec3_make(0.0f, 1.0f, 3.0f), STILB_GI_CACHE_SPLIT_SPHERE);
	assert_true(fabsf(error_at(&record, 0.1f, 1.0f, 3.0f) - 0.1f / (0.5f / 2.5f)) < 1e-5f);
	assert_true(fabsf(error_at(&record, 0.0f, 1.0f, 3.1f) - 0.1f / (0.5f / 2.5f)) < 1e-5f);
	stilb_vec3 turned = stilb_vec3_normalize(stilb_vec3_make(0.2f, 1.0f, 0.0f));
	float error = gi_cache_record_error(&record, record.position, turned, limits.turn);
	assert_true(fabsf(error - sqrtf(1.0f - turned[1]) / 0.5f) < 1e-4f);
}

/* The rule HARMONIC alone does not shorten a radius at which extrapolation along the gradient would bring the
 * irradiance to 0. */
static void harmonic_radius_is_not_bounded_by_gradients(void **state)
{
	(void)state;
	gi_cache_gathered gathered = gathered_grey(1.0f, 2.5f);
	gathered.translation[0] = stilb_vec3_make(10.0f, 10.0f, 10.0f);
	gi_cache_record bounded = record_of(&gathered, stilb_vec3_make(0.0f, 1.0f, 3.0f), STILB_GI_CACHE_SPLIT_SPHERE);
	gi_cache_record plain = record_of(&gathered, stilb_vec3_make(0.0f, 1.0f, 3.0f), STILB_GI_CACHE_HARMONIC);
	assert_true(fabsf(1.0f / bounded.irradiance[3] - 0.1f) < 1e-6f);
	assert_true(fabsf(1.0f / plain.irradiance[3] - 0.5f / 2.5f) < 1e-6f);
}

static void a_place_below_is_another_surface(void **state)
{
	(void)state;
	gi_cache_gathered gathered = gathered_grey(1.0f, 2.5f);
	gi_cache_record record = record_of(&gathered, stilb_vec3_make(0.0f, 1.0f, 3.0f), STILB_GI_CACHE_SPLIT_SPHERE);
	assert_true(error_at(&record, 0.0f, 1.05f, 3.0f) < 1.0f);
	assert_true(error_at(&record, 0.0f, 0.95f, 3.0f) == INFINITY);
}

/* A second derivative that is 16 times as large along one axis gives half the radius there: the radius goes with its
 * fourth root. */
static void hessian_makes_an_ellipse(void **state)
{
	(void)state;
	gi_cache_gathered gathered = gathered_grey(1.0f, 0.1f);
	float c = cosf(0.4f), s = sinf(0.4f), across = 16.0f, along = 1.0f;
	gathered.hessian[0] = across * c * c + along * s * s;
	gathered.hessian[1] = (across - along) * c * s;
	gathered.hessian[2] = across * s * s + along * c * c;
	gi_cache_record record = record_of(&gathered, stilb_vec3_make(0.0f, 1.0f, 3.0f), STILB_GI_CACHE_HESSIAN);
	shade_frame frame = shade_frame_from_normal(record.normal);
	float radius = powf(4.0f / (float)M_PI * 0.5f * 0.2f * 0.2f / across, 0.25f);
	stilb_vec3 bent = frame.t * c + frame.b * s, straight = frame.b * c - frame.t * s;
	float steep = gi_cache_record_error(&record, record.position + bent * 0.05f, record.normal, limits.turn);
	float flat = gi_cache_record_error(&record, record.position + straight * 0.05f, record.normal, limits.turn);
	assert_true(fabsf(steep - 0.05f / radius) < 1e-3f);
	assert_true(fabsf(flat - 0.5f * steep) < 1e-3f);
}

static void radii_stay_within_limits(void **state)
{
	(void)state;
	for (stilb_gi_cache_radius kind = STILB_GI_CACHE_SPLIT_SPHERE; kind <= STILB_GI_CACHE_HARMONIC; kind++) {
		gi_cache_gathered far = gathered_grey(1.0f, 0.0f), near = gathered_grey(1.0f, 1e9f),
						  black = gathered_grey(0.0f, 0.0f);
		near.hessian[0] = near.hessian[2] = 1e20f;
		gi_cache_record a = record_of(&far, stilb_vec3_make(0.0f, 1.0f, 3.0f), kind);
		gi_cache_record b = record_of(&near, stilb_vec3_make(0.0f, 1.0f, 3.0f), kind);
		gi_cache_record c = record_of(&black, stilb_vec3_make(0.0f, 1.0f, 3.0f), kind);
		assert_true(fabsf(1.0f / a.irradiance[3] - limits.longest) < 1e-6f);
		assert_true(fabsf(1.0f / b.irradiance[3] - limits.shortest) < 1e-6f);
		assert_true(fabsf(1.0f / c.irradiance[3] - limits.longest) < 1e-6f);
		gi_cache_record_limit(&a, 0.25f);
		assert_true(fabsf(error_at(&a, 0.125f, 1.0f, 3.0f) - 0.5f) < 1e-5f);
	}
}

/* Within the radii no colour channel goes below 0 along its gradient; limiting the gradient of one leaves those of the
 * others as they are. */
static void gradients_are_limited_by_colour(void **state)
{
	(void)state;
	gi_cache_gathered gathered = gathered_grey(1.0f, 0.1f);
	gathered.translation[0] = stilb_vec3_make(-10.0f, 1.0f, 0.0f);
	gi_cache_record record = record_of(&gathered, stilb_vec3_make(0.0f, 1.0f, 3.0f), STILB_GI_CACHE_SPLIT_SPHERE);
	float radius = 1.0f / record.irradiance[3];
	stilb_vec3 there = record.position + record.tangent * radius;
	stilb_vec3 irradiance = gi_cache_record_irradiance(&record, there, record.normal);
	assert_true(irradiance[0] >= -1e-5f && irradiance[0] < 0.1f);
	assert_true(fabsf(irradiance[1] - (1.0f + radius)) < 1e-5f && irradiance[2] == 1.0f);
}

/* With Hessian radii irradiance follows its second derivative, E + H x^2 / 2, along the axes of that: here -8 along one
 * and 2 across it; but by no more than a quarter of it at the radius, and not without gradients. */
static void hessian_bends_irradiance(void **state)
{
	(void)state;
	gi_cache_gathered gathered = gathered_grey(4.0f, 0.1f), steep = gathered;
	const float along[3] = {-8.0f, 0.0f, 2.0f}, steeper[3] = {-8000.0f, 0.0f, 2.0f};
	memcpy(gathered.hessian, along, sizeof along);
	memcpy(steep.hessian, steeper, sizeof steeper);
	shade_frame frame = shade_frame_from_normal(stilb_vec3_make(0.0f, 1.0f, 0.0f));
	gi_cache_record record = record_of(&gathered, stilb_vec3_make(0.0f, 1.0f, 3.0f), STILB_GI_CACHE_HESSIAN);
	for (float x = -0.2f; x <= 0.2f; x += 0.05f) {
		stilb_vec3 at = record.position + frame.t * x, across = record.position + frame.b * x;
		stilb_vec3 bent = gi_cache_record_irradiance(&record, at, record.normal);
		assert_true(fabsf(bent[0] - (4.0f - 4.0f * x * x)) < 1e-5f && bent[0] == bent[2]);
		assert_true(fabsf(gi_cache_record_irradiance(&record, across, record.normal)[1] - (4.0f + x * x)) < 1e-5f);
	}
	record = record_of(&steep, stilb_vec3_make(0.0f, 1.0f, 3.0f), STILB_GI_CACHE_HESSIAN);
	float radius = fminf(1.0f / record.position[3], 1.0f / record.normal[3]);
	stilb_vec3 there = record.position + frame.t * radius;
	assert_true(fabsf(gi_cache_record_irradiance(&record, there, record.normal)[0] - 3.0f) < 1e-4f);
	steep.translation[0] = stilb_vec3_make(-100.0f, 0.0f, 0.0f); /* with both no colour falls below 0 */
	record = record_of(&steep, stilb_vec3_make(0.0f, 1.0f, 3.0f), STILB_GI_CACHE_HESSIAN);
	float least = gi_cache_record_irradiance(&record, there, record.normal)[0];
	assert_true(least >= -1e-4f && least < 0.1f);
	gi_cache_limits flat = limits;
	flat.radius = STILB_GI_CACHE_HESSIAN;
	flat.gradients = false;
	record = gi_cache_record_make(&steep, frame, stilb_vec3_make(0.0f, 1.0f, 3.0f), &flat);
	assert_true(gi_cache_record_irradiance(&record, there, record.normal)[0] == 4.0f);
}

static void weight_is_bounded_and_ends_at_nothing(void **state)
{
	(void)state;
	assert_true(isfinite(gi_cache_record_weight(0.0f)) && gi_cache_record_weight(0.0f) > 0.0f);
	assert_true(gi_cache_record_weight(1.0f) == 0.0f);
	for (float e = 0.0f; e < 0.99f; e += 0.01f)
		assert_true(gi_cache_record_weight(e) >= gi_cache_record_weight(e + 0.01f));
}

/* ---- the tree ---------------------------------------------------------------------------------------------------- */

static float number(uint64_t seed, uint64_t index, float from, float to)
{
	return from + (to - from) * stilb_random_float(seed, index);
}

static stilb_vec3 place(uint64_t seed, uint64_t i)
{
	stilb_vec3 p = {0};
	for (int axis = 0; axis < 3; axis++)
		p[axis] = number(seed, 3 * i + (uint64_t)axis, low[axis], high[axis]);
	return p;
}

/* A random unit normal near +y. */
static stilb_vec3 random_normal(uint64_t seed, uint64_t i)
{
	return stilb_vec3_normalize(
		stilb_vec3_make(number(seed, 2 * i, -0.3f, 0.3f), 1.0f, number(seed, 2 * i + 1, -0.3f, 0.3f)));
}

static gi_cache_record random_record(uint64_t i)
{
	gi_cache_gathered gathered = gathered_grey(number(1, i, 0.5f, 2.0f), number(2, i, 0.5f, 20.0f));
	gathered.translation[1][2] = number(3, i, -1.0f, 1.0f);
	gi_cache_limits with = limits;
	return gi_cache_record_make(&gathered, shade_frame_from_normal(random_normal(4, i)), place(6, i), &with);
}

static gi_cache_octree *octree_with(uint32_t count)
{
	gi_cache_octree *octree;
	assert_int_equal(gi_cache_octree_create(low, high, &octree), STILB_OK);
	for (uint32_t i = 0; i < count; i++) {
		gi_cache_record record = random_record(i);
		assert_true(gi_cache_octree_insert(octree, &record));
	}
	return octree;
}

/* The reference for lookups: tries all records, one after the other. */
static bool lookup_slowly(uint32_t count, stilb_vec3 position, stilb_vec3 normal, stilb_vec3 *irradiance)
{
	stilb_vec3 sum = {0};
	float weights = 0.0f;
	for (uint32_t i = 0; i < count; i++) {
		gi_cache_record record = random_record(i);
		float error = gi_cache_record_error(&record, position, normal, limits.turn);
		if (!(error < 1.0f))
			continue;
		sum += gi_cache_record_irradiance(&record, position, normal) * gi_cache_record_weight(error);
		weights += gi_cache_record_weight(error);
	}
	*irradiance = sum / weights;
	return weights > 0.0f;
}

static void tree_finds_what_all_records_say(void **state)
{
	(void)state;
	enum { COUNT = 2000, LOOKUPS = 500 };
	gi_cache_octree *octree = octree_with(COUNT);
	assert_int_equal(gi_cache_octree_count(octree), COUNT);
	uint32_t found = 0;
	for (uint32_t i = 0; i < LOOKUPS; i++) {
		stilb_vec3 position = place(7, i), normal = random_normal(8, i);
		stilb_vec3 fast, slow;
		bool there = gi_cache_octree_lookup(octree, position, normal, limits.turn, &fast);
		assert_int_equal(there, lookup_slowly(COUNT, position, normal, &slow));
		assert_int_equal(there, gi_cache_octree_covers(octree, position, normal, limits.turn, 1.0f));
		for (int c = 0; c < 3 && there; c++)
			assert_true(fabsf(fast[c] - fmaxf(slow[c], 0.0f)) <= 1e-4f);
		found += there;
	}
	assert_in_range(found, LOOKUPS / 10, LOOKUPS - LOOKUPS / 10);
	gi_cache_octree_destroy(octree);
}

static void places_outside_are_no_harm(void **state)
{
	(void)state;
	gi_cache_octree *octree = octree_with(10);
	stilb_vec3 irradiance;
	for (int i = 0; i < 4; i++) {
		const float far[] = {1e30f, -1e30f, INFINITY, NAN};
		stilb_vec3 position = stilb_vec3_make(far[i], far[i], 3.0f);
		assert_false(gi_cache_octree_lookup(octree, position, position, limits.turn, &irradiance));
		assert_false(gi_cache_octree_record_near(octree, position, 0.1f));
	}
	gi_cache_octree_destroy(octree);
}

/* A record of radius 0.5 that is inserted 0.03 from one of radius 0.05 is limited to 0.08. */
static void a_neighbour_clamps_what_comes_after_it(void **state)
{
	(void)state;
	gi_cache_octree *octree = octree_with(0);
	gi_cache_gathered far = gathered_grey(1.0f, 1.0f), near = gathered_grey(1.0f, 10.0f);
	gi_cache_record shorter = record_of(&near, stilb_vec3_make(0.03f, 1.0f, 3.0f), STILB_GI_CACHE_SPLIT_SPHERE);
	gi_cache_record longer = record_of(&far, stilb_vec3_make(0.0f, 1.0f, 3.0f), STILB_GI_CACHE_SPLIT_SPHERE);
	assert_true(gi_cache_octree_insert(octree, &shorter));
	gi_cache_octree_clamp(octree, &longer);
	assert_true(fabsf(1.0f / longer.irradiance[3] - 0.08f) < 1e-6f);
	gi_cache_octree_destroy(octree);
}

/* ---- threads ----------------------------------------------------------------------------------------------------- */

enum { THREADS = 3, EACH = 1000 };

typedef struct filler {
	gi_cache_octree *octree;
	uint32_t first;
	uint32_t unseen; /* own records that a lookup right after their insertion did not find */
	uint32_t torn;   /* lookups that gave no number */
} filler;

static void *fill(void *context)
{
	filler *self = context;
	for (uint32_t i = 0; i < EACH; i++) {
		gi_cache_record record = random_record(self->first + i);
		stilb_vec3 irradiance;
		gi_cache_octree_insert(self->octree, &record);
		self->unseen += !gi_cache_octree_lookup(self->octree, record.position, record.normal, limits.turn, &irradiance);
		stilb_vec3 position = place(10, self->first + i), normal = random_normal(8, i);
		if (gi_cache_octree_lookup(self->octree, position, normal, limits.turn, &irradiance))
			self->torn += !isfinite(irradiance[0] + irradiance[1] + irradiance[2]);
	}
	return NULL;
}

static void threads_fill_one_tree(void **state)
{
	(void)state;
	gi_cache_octree *octree = octree_with(0);
	filler fillers[THREADS];
	pthread_t threads[THREADS];
	for (uint32_t t = 0; t < THREADS; t++) {
		fillers[t] = (filler){.octree = octree, .first = t * EACH};
		assert_int_equal(pthread_create(&threads[t], NULL, fill, &fillers[t]), 0);
	}
	for (uint32_t t = 0; t < THREADS; t++) {
		pthread_join(threads[t], NULL);
		assert_int_equal(fillers[t].unseen, 0);
		assert_int_equal(fillers[t].torn, 0);
	}
	assert_int_equal(gi_cache_octree_count(octree), THREADS * EACH);
	for (uint32_t i = 0; i < THREADS * EACH; i++) {
		gi_cache_record record = random_record(i);
		assert_true(gi_cache_octree_covers(octree, record.position, record.normal, limits.turn, 0.01f));
	}
	gi_cache_octree_destroy(octree);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(split_sphere_has_wards_radius),
		cmocka_unit_test(harmonic_radius_is_not_bounded_by_gradients),
		cmocka_unit_test(a_place_below_is_another_surface),
		cmocka_unit_test(hessian_makes_an_ellipse),
		cmocka_unit_test(radii_stay_within_limits),
		cmocka_unit_test(gradients_are_limited_by_colour),
		cmocka_unit_test(hessian_bends_irradiance),
		cmocka_unit_test(weight_is_bounded_and_ends_at_nothing),
		cmocka_unit_test(tree_finds_what_all_records_say),
		cmocka_unit_test(places_outside_are_no_harm),
		cmocka_unit_test(a_neighbour_clamps_what_comes_after_it),
		cmocka_unit_test(threads_fill_one_tree),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
