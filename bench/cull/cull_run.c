/* The program of the suite `cull`: runs one case (a scene and its views, cull_cases.h) with one way of culling, and
 * compares the ids of the visible models with those that a plain loop finds. */
#include "bench/cull/cull_cases.h"
#include "bench/harness/bench_child.h"

#include "culling/cull_internal.h"
#include "profiler/prof.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

#define SPACING 4.0f /* metres: one sphere for each cube of this side, on average */
#define VIEWS 4u
#define TURN 0.00872664626f /* angle between two successive views: half a degree, in radians */
#define MAX_SAMPLES (1u << 16)

typedef struct run {
	const cull_case *on;
	stilb_scene scene;
	float *home_x; /* metres: models move along x around these positions */
	stilb_frustum views[VIEWS];
	uint32_t *expected; /* scratch memory: visible ids by plain_cull */
	stilb_cull *cull;
	stilb_cull_visible visible;
	stilb_job_pool *pool; /* NULL: one thread */
	stilb_cull_method method;
	uint64_t frame;
	uint64_t sum; /* of what stream_frame read, so that the compiler keeps the reads */
	uint32_t sample_count;
	double samples[MAX_SAMPLES]; /* ns */
} run;

static void check(stilb_result result)
{
	if (result != STILB_OK)
		bench_child_fail("%s", stilb_error_message());
}

static void *allocate(size_t count, size_t size)
{
	void *memory = stilb_memory_alloc(count, size);
	if (!memory)
		bench_child_fail("out of memory");
	return memory;
}

/* ---- scene and views --------------------------------------------------------------------------------------------- */

static float half_side(const cull_case *on)
{
	return SPACING * 0.5f * cbrtf((float)on->models);
}

static void make_scene(run *r)
{
	uint32_t count = r->on->models;
	float side = 2.0f * half_side(r->on);
	stilb_scene_bounds *b = &r->scene.bounds;
	r->scene.model_count = count;
	b->x = allocate(count, sizeof(float));
	b->y = allocate(count, sizeof(float));
	b->z = allocate(count, sizeof(float));
	b->radius = allocate(count, sizeof(float));
	r->scene.moved = allocate(count, sizeof(uint32_t));
	r->home_x = allocate(count, sizeof(float));
	r->expected = allocate(count, sizeof(uint32_t));
	for (uint32_t i = 0; i < count; i++) {
		b->x[i] = r->home_x[i] = (stilb_random_float(1, 4 * (uint64_t)i) - 0.5f) * side;
		b->y[i] = (stilb_random_float(1, 4 * (uint64_t)i + 1) - 0.5f) * side;
		b->z[i] = (stilb_random_float(1, 4 * (uint64_t)i + 2) - 0.5f) * side;
		b->radius[i] = 0.5f + 1.5f * stilb_random_float(1, 4 * (uint64_t)i + 3);
	}
}

/* The reference for verification: writes the ids of the models that are not wholly outside one of the frustum's first
 * `planes` planes; returns their number. */
static uint32_t plain_cull(const stilb_scene *scene, const stilb_frustum *frustum, uint32_t planes, uint32_t *ids)
{
	const stilb_scene_bounds *b = &scene->bounds;
	uint32_t found = 0;
	for (uint32_t i = 0; i < scene->model_count; i++) {
		uint32_t visible = 1;
		for (uint32_t p = 0; p < planes; p++) {
			stilb_plane plane = frustum->planes[p];
			float sum = ((b->x[i] * plane.x + b->y[i] * plane.y) + b->z[i] * plane.z) + plane.distance;
			visible &= sum >= -b->radius[i];
		}
		ids[found] = i;
		found += visible;
	}
	return found;
}

static int compare_floats(const void *a, const void *b)
{
	float x = *(const float *)a, y = *(const float *)b;
	return (x > y) - (x < y);
}

/* Moves the far plane so that the case's share of the models is visible. */
static void set_far_plane(run *r, stilb_frustum *view)
{
	const stilb_scene_bounds *b = &r->scene.bounds;
	stilb_plane *far_plane = &view->planes[5];
	uint32_t wanted = (uint32_t)(r->on->share * r->on->models);
	uint32_t count = plain_cull(&r->scene, view, 5, r->expected);
	if (count < wanted)
		bench_child_fail("the view holds only %u of %u models", count, wanted);
	float *distances = allocate(count, sizeof *distances); /* plane distance from which on each model is visible */
	for (uint32_t i = 0; i < count; i++) {
		uint32_t id = r->expected[i];
		float sum = (b->x[id] * far_plane->x + b->y[id] * far_plane->y) + b->z[id] * far_plane->z;
		distances[i] = -(sum + b->radius[id]);
	}
	qsort(distances, count, sizeof *distances, compare_floats);
	far_plane->distance = wanted == r->on->models ? 1e6f : distances[wanted - 1];
	free(distances);
}

static void make_views(run *r)
{
	for (uint32_t v = 0; v < VIEWS; v++) {
		float yaw = 0.35f + (float)v * TURN, pitch = -0.2f, back = (float)r->on->back * half_side(r->on);
		stilb_vec3 eye =
			stilb_vec3_make(sinf(yaw) * cosf(pitch) * back, -sinf(pitch) * back, cosf(yaw) * cosf(pitch) * back);
		stilb_mat4 view = stilb_mat4_view(eye, yaw, pitch);
		stilb_mat4 projection = stilb_mat4_perspective(1.04719755f, 16.0f / 9.0f, 0.1f, 1000.0f);
		stilb_mat4 matrix = stilb_mat4_multiply(projection, view);
		r->views[v] = stilb_frustum_from_matrix(&matrix);
		set_far_plane(r, &r->views[v]);
	}
}

/* The view of a frame, in the order 0, 1, 2, 3, 3, 2, 1, 0, 0, ... */
static const stilb_frustum *view_of(const run *r, uint64_t frame)
{
	uint32_t v = (uint32_t)(frame % (2 * VIEWS));
	return &r->views[v < VIEWS ? v : 2 * VIEWS - 1 - v];
}

static void verify(run *r, const stilb_frustum *view)
{
	uint32_t count = plain_cull(&r->scene, view, CULL_PLANES, r->expected);
	if (r->visible.count != count || memcmp(r->visible.ids, r->expected, count * sizeof *r->expected) != 0)
		bench_child_fail("wrong result: %u models are visible, or other ones than the %u that a plain loop finds",
		                 r->visible.count, count);
}

/* ---- subjects ---------------------------------------------------------------------------------------------------- */

/* Moves a tenth of the models, another tenth in each frame, to up to 25 cm beside their home positions. */
static void move_models(run *r)
{
	r->scene.moved_count = 0;
	for (uint32_t i = (uint32_t)(r->frame % 10); i < r->scene.model_count; i += 10) {
		r->scene.bounds.x[i] = r->home_x[i] + 0.5f * stilb_random_float(r->frame, i) - 0.25f;
		r->scene.moved[r->scene.moved_count++] = i;
	}
}

static void cull_frame(run *r, const stilb_frustum *view)
{
	if (r->on->moves)
		check(stilb_cull_update(r->cull, &r->scene, r->scene.moved, r->scene.moved_count));
	check(stilb_cull_run(r->cull, r->method, &r->scene, view, r->pool, 0, &r->visible));
}

/* Builds a new octree instead of updating the old one. */
static void rebuild_frame(run *r, const stilb_frustum *view)
{
	stilb_cull_destroy(r->cull);
	check(stilb_cull_create(&r->scene, &r->cull));
	check(stilb_cull_run(r->cull, STILB_CULL_OCTREE, &r->scene, view, NULL, 0, &r->visible));
}

/* Only reads the 16 bytes of each model's bounding sphere: the lower bound for every method that tests each sphere. */
static void stream_frame(run *r, const stilb_frustum *view)
{
	typedef uint64_t two __attribute__((vector_size(16), may_alias)); /* 4 models */
	const stilb_scene_bounds *b = &r->scene.bounds;
	const two *x = (const two *)b->x, *y = (const two *)b->y, *z = (const two *)b->z, *radius = (const two *)b->radius;
	two sum = {0}, other = {0};
	(void)view;
	for (uint32_t i = 0; i < r->scene.model_count / 4; i += 2) {
		sum ^= (x[i] ^ y[i]) ^ (z[i] ^ radius[i]);
		other ^= (x[i + 1] ^ y[i + 1]) ^ (z[i + 1] ^ radius[i + 1]);
	}
	r->sum += sum[0] ^ sum[1] ^ other[0] ^ other[1];
}

typedef struct subject {
	const char *name;
	void (*frame)(run *r, const stilb_frustum *view);
	stilb_cull_method method;
	const char *isa;  /* instruction set; NULL: the widest of this CPU */
	uint32_t workers; /* threads besides the caller */
	bool sees;        /* true: it finds the visible models, which are verified; false: it only reads memory */
} subject;

static const subject subjects[] = {
	{"stilb-flat-scalar", cull_frame, STILB_CULL_FLAT, "scalar", 0, true},
	{"stilb-flat-avx2", cull_frame, STILB_CULL_FLAT, "avx2", 0, true},
	{"stilb-flat-avx512", cull_frame, STILB_CULL_FLAT, "avx512", 0, true},
	{"stilb-octree", cull_frame, STILB_CULL_OCTREE, NULL, 0, true},
	{"stilb-auto", cull_frame, STILB_CULL_AUTO, NULL, 0, true},
	{"stilb-flat-2", cull_frame, STILB_CULL_FLAT, NULL, 1, true},
	{"stilb-octree-2", cull_frame, STILB_CULL_OCTREE, NULL, 1, true},
	{"stilb-auto-2", cull_frame, STILB_CULL_AUTO, NULL, 1, true},
	{"rebuild", rebuild_frame, STILB_CULL_OCTREE, NULL, 0, true},
	{"stream", stream_frame, STILB_CULL_FLAT, NULL, 0, false},
};

/* ---- measuring --------------------------------------------------------------------------------------------------- */

/* One sample: ns of a frame. Frames in which nothing moves are timed eight at a time, since some of them take less than
 * the clock's resolution. */
static double sample(run *r, const subject *s)
{
	uint32_t frames = r->on->moves ? 1 : 2 * VIEWS;
	if (r->on->moves)
		move_models(r);
	uint64_t begin = bench_child_now_ns();
	for (uint32_t i = 0; i < frames; i++)
		s->frame(r, view_of(r, r->frame++));
	return (double)(bench_child_now_ns() - begin) / frames;
}

static void verify_all(run *r, const subject *s)
{
	for (uint32_t i = 0; s->sees && i < 2 * VIEWS; i++, r->frame++) {
		if (r->on->moves)
			move_models(r);
		s->frame(r, view_of(r, r->frame));
		verify(r, view_of(r, r->frame));
	}
}

static int compare_doubles(const void *a, const void *b)
{
	double x = *(const double *)a, y = *(const double *)b;
	return (x > y) - (x < y);
}

static void measure(run *r, const subject *s, double seconds)
{
	verify_all(r, s); /* also warms the caches */
	if (r->pool)
		stilb_job_phase_begin(r->pool); /* workers stay awake, as in a frame of the engine */
	uint64_t end = bench_child_now_ns() + (uint64_t)(seconds * 1e9);
	while (r->sample_count < MAX_SAMPLES && (r->sample_count < 3 || bench_child_now_ns() < end))
		r->samples[r->sample_count++] = sample(r, s);
	if (r->pool)
		stilb_job_phase_end(r->pool);
	verify_all(r, s);
	qsort(r->samples, r->sample_count, sizeof *r->samples, compare_doubles);
	double p50 = r->samples[r->sample_count / 2], p99 = r->samples[r->sample_count * 99 / 100];
	bench_child_metric("p50", p50 * 1e-3);
	bench_child_metric("p99", p99 * 1e-3);
	bench_child_metric("per-model", p50 / r->on->models);
	if (s->sees)
		bench_child_metric("visible", 100.0 * r->visible.count / r->on->models);
}

/* ---- the program ------------------------------------------------------------------------------------------------- */

static const cull_case cases[] = {
#define CASE(NAME, TITLE, ...) {NAME, __VA_ARGS__},
	CULL_CASES(CASE)
#undef CASE
};

static const cull_case *find_case(const char *name)
{
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
		if (strcmp(cases[i].name, name) == 0)
			return &cases[i];
	bench_child_fail("no case %s", name);
}

static const subject *find_subject(const char *name)
{
	for (size_t i = 0; i < sizeof subjects / sizeof *subjects; i++)
		if (strcmp(subjects[i].name, name) == 0)
			return &subjects[i];
	bench_child_fail("no subject %s", name);
}

int main(int argc, char **argv)
{
	static run r;
	bench_child child = bench_child_args(argc, argv);
	stilb_prof_record_set(false); /* else the cost of recording profiler zones would be measured, too */
	const subject *s = find_subject(child.subject);
	r.on = find_case(child.case_name);
	r.method = s->method;
	if (s->isa) {
		setenv("STILB_ISA", s->isa, 1);
		stilb_isa isa;
		if (stilb_cpu_isa(&isa) != STILB_OK)
			return BENCH_CHILD_SKIP; /* this CPU has no such instructions */
	}
	if (s->workers) {
		stilb_job_pool_desc desc = stilb_job_pool_desc_default();
		desc.worker_count = s->workers;
		if (stilb_job_pool_create(&desc, &r.pool) != 0)
			bench_child_fail("cannot start a worker");
	}
	make_scene(&r);
	make_views(&r);
	if (s->sees)
		check(stilb_cull_create(&r.scene, &r.cull));
	measure(&r, s, child.seconds);
	stilb_job_pool_destroy(r.pool);
	stilb_cull_visible_finish(&r.visible);
	stilb_cull_destroy(r.cull);
	return r.sum == 1 ? 3 : 0; /* uses r.sum, so that the compiler keeps stream_frame's reads; it is never 1 */
}
