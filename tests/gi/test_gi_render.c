/* Renders: the same bits for every number of workers, order of passes and interruption; limits, stop, progress,
 * preview. */
#include "gi_render_fixture.h"

#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <time.h>

/* ---- the same bits ----------------------------------------------------------------------------------------------- */

static const stilb_gi_integrator INTEGRATORS[] = {STILB_GI_INTEGRATOR_PATH, STILB_GI_INTEGRATOR_SPLIT,
                                                  STILB_GI_INTEGRATOR_AO, STILB_GI_INTEGRATOR_IRRADIANCE_CACHE};
#define INTEGRATOR_COUNT (sizeof INTEGRATORS / sizeof *INTEGRATORS)

static void same_bits_for_workers_and_passes(void **state)
{
	(void)state;
	static const uint32_t workers[] = {0, 6, 1, 2};
	uint64_t hashes[INTEGRATOR_COUNT][2];
	for (size_t w = 0; w < (TEST_TSAN ? 2 : 4); w++) {
		render_fixture fixture = render_fixture_make("cornell", workers[w]);
		stilb_gi_settings settings = render_fixture_settings(&fixture);
		settings.samples = 3;
		if (TEST_TSAN)
			settings.width = 19, settings.height = 11;
		for (size_t i = 0; i < INTEGRATOR_COUNT; i++) {
			settings.integrator = INTEGRATORS[i];
			for (int weighted = 0; weighted < 2; weighted++) {
				settings.firefly_weight = weighted;
				settings.progressive = (w + (size_t)weighted) % 2;
				uint64_t hash = render_whole(&fixture, &settings);
				if (w == 0)
					hashes[i][weighted] = hash;
				assert_int_equal(hash, hashes[i][weighted]);
			}
			assert_int_not_equal(hashes[i][0], hashes[i][1]);
		}
		render_fixture_finish(&fixture);
	}
}

static void other_settings_other_bits(void **state)
{
	(void)state;
	render_fixture fixture = render_fixture_make("cornell", 1);
	stilb_gi_settings settings = render_fixture_settings(&fixture), other;
	if (TEST_TSAN)
		settings.width = 19, settings.height = 11;
	other = settings;
	uint64_t hash = render_whole(&fixture, &settings);
	other.seed = 1;
	assert_int_not_equal(render_whole(&fixture, &other), hash);
	other = settings;
	other.samples++;
	assert_int_not_equal(render_whole(&fixture, &other), hash);
	other = settings;
	other.camera.yaw += 0.01f;
	assert_int_not_equal(render_whole(&fixture, &other), hash);
	render_fixture_finish(&fixture);
}

/* ---- stop, and others who look on -------------------------------------------------------------------------------- */

typedef struct onlooker {
	stilb_gi_render *render;
	float *rgb;
	_Atomic uint32_t looks; /* stops asked for so far; release by the onlooker, acquire by the main thread */
	bool monotonic, finite;
	_Atomic bool done; /* tells the onlooker to end; release by the main thread, acquire by the onlooker */
} onlooker;

static void rest(long us)
{
	nanosleep(&(struct timespec){.tv_nsec = us * 1000}, NULL);
}

/* Stops the render again and again, and reads all there is to be read meanwhile. */
static void *look_on(void *context)
{
	onlooker *looker = context;
	double done = 0.0;
	uint64_t rays = 0;
	while (!atomic_load_explicit(&looker->done, memory_order_acquire)) {
		rest(300);
		stilb_gi_progress progress;
		stilb_gi_render_progress(looker->render, &progress);
		stilb_gi_render_preview(looker->render, looker->rgb);
		looker->monotonic &= progress.done >= done && progress.rays >= rays && progress.done <= 1.0;
		looker->finite &= isfinite(looker->rgb[0]) && isfinite(looker->rgb[3 * 37 * 21 - 1]);
		done = progress.done;
		rays = progress.rays;
		stilb_gi_render_stop(looker->render);
		atomic_fetch_add_explicit(&looker->looks, 1, memory_order_release); /* pairs with stopped_again_and_again */
	}
	return NULL;
}

static void stopped_again_and_again(void **state)
{
	(void)state;
	render_fixture fixture = render_fixture_make("cornell", 2);
	stilb_gi_settings settings = render_fixture_settings(&fixture);
	settings.samples = TEST_TSAN ? 6 : 12;
	for (int progressive = 0; progressive < 2; progressive++) {
		settings.progressive = progressive;
		uint64_t hash = render_whole(&fixture, &settings);
		onlooker looker = {.render = render_fixture_create(&fixture, &settings), .monotonic = true, .finite = true};
		looker.rgb = calloc(3 * 37 * 21, sizeof *looker.rgb);
		pthread_t thread;
		assert_int_equal(pthread_create(&thread, NULL, look_on, &looker), 0);
		uint32_t runs = 0;
		for (; !progress_of(looker.render).finished; runs++) {
			/* The first runs each meet a stop that was asked for after the run before: of two looks from here on the
			 * second one asks after this line. Acquire, pairs with look_on. */
			uint32_t seen = atomic_load_explicit(&looker.looks, memory_order_acquire);
			while (runs < 4 && atomic_load_explicit(&looker.looks, memory_order_acquire) < seen + 2)
				rest(100);
			assert_int_equal(stilb_gi_render_run(looker.render), STILB_OK);
		}
		atomic_store_explicit(&looker.done, true, memory_order_release); /* pairs with look_on's acquire */
		pthread_join(thread, NULL);
		assert_int_equal(film_hash(looker.render), hash);
		assert_true(runs > 4 && looker.monotonic && looker.finite);
		stilb_gi_render_destroy(looker.render);
		free(looker.rgb);
	}
	render_fixture_finish(&fixture);
}

typedef struct watcher {
	pthread_t thread;
	uint32_t calls, stop_at; /* the number of the call that stops the run; 0: none */
	double done;
	bool sound;
} watcher;

static bool on_watch(void *user, const stilb_gi_progress *progress)
{
	watcher *w = user;
	w->sound &= pthread_equal(pthread_self(), w->thread) != 0 && progress->done >= w->done && !progress->finished;
	w->done = progress->done;
	return ++w->calls != w->stop_at;
}

/* The program's function sees progress on the thread in run, and ends it; the picture is the same. */
static void watched(void **state)
{
	(void)state;
	for (uint32_t workers = 0; workers < 3; workers += 2) {
		render_fixture fixture = render_fixture_make("cornell", workers);
		stilb_gi_settings settings = render_fixture_settings(&fixture);
		settings.width = 19;
		settings.height = 11;
		stilb_gi_render *plain = render_fixture_create(&fixture, &settings);
		stilb_gi_render *render = render_fixture_create(&fixture, &settings);
		assert_int_equal(stilb_gi_render_run(plain), STILB_OK);
		watcher w = {.thread = pthread_self(), .stop_at = 1, .sound = true};
		stilb_gi_render_watch(render, on_watch, &w);
		assert_int_equal(stilb_gi_render_run(render), STILB_OK);
		if (workers == 0) { /* else the others may have done it all */
			assert_int_equal(w.calls, 1);
			assert_int_equal(progress_of(render).end, STILB_GI_END_STOPPED);
			assert_int_equal(progress_of(render).camera_rays, 0);
		}
		w.stop_at = 0;
		while (!progress_of(render).finished)
			assert_int_equal(stilb_gi_render_run(render), STILB_OK);
		assert_true(w.sound);
		assert_true((double)w.calls <= 3.0 + progress_of(render).seconds / 0.05);
		assert_true(film_hash(render) == film_hash(plain));
		stilb_gi_render_watch(render, NULL, NULL);
		stilb_gi_render_destroy(render);
		stilb_gi_render_destroy(plain);
		render_fixture_finish(&fixture);
	}
}

/* ---- a pool that is shared --------------------------------------------------------------------------------------- */

typedef struct guest {
	render_fixture *fixture;
	stilb_gi_settings settings;
	uint64_t hash;
	_Atomic bool done; /* release by the guest, acquire by the main thread */
} guest;

/* Makes the scene ready and renders, from a thread that is not of the pool. */
static void *guest_render(void *context)
{
	guest *own = context;
	stilb_gi_scene_desc desc = {
		.pool = own->fixture->pool, .caller = STILB_JOB_OUTSIDE, .intersector = &stilb_gi_brute};
	stilb_gi_scene *gi;
	stilb_gi_render *render;
	assert_int_equal(stilb_gi_scene_create(own->fixture->scene, &desc, &gi), STILB_OK);
	assert_int_equal(stilb_gi_render_create(gi, &own->settings, own->fixture->pool, &render), STILB_OK);
	stilb_gi_render_share(render, STILB_JOB_OUTSIDE, 1e-4);
	for (int i = 0; !progress_of(render).finished; i++) {
		if (i == 0)
			stilb_gi_render_stop(render);
		assert_int_equal(stilb_gi_render_run(render), STILB_OK);
	}
	own->hash = film_hash(render);
	stilb_gi_render_destroy(render);
	stilb_gi_scene_destroy(gi);
	atomic_store_explicit(&own->done, true, memory_order_release);
	return NULL;
}

/* stilb_job_range_fn */
static void count_on(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)worker;
	atomic_fetch_add_explicit((_Atomic uint32_t *)context, end - begin, memory_order_relaxed);
}

/* While the pool's own thread runs loops of its own, in which workers take part between slices of the guest's. */
static void same_bits_in_slices_beside_others(void **state)
{
	(void)state;
	for (uint32_t workers = 1; workers <= 3; workers += 2) {
		render_fixture fixture = render_fixture_make("cornell", workers);
		guest other = {.fixture = &fixture, .settings = render_fixture_settings(&fixture)};
		other.settings.progressive = workers == 1;
		other.settings.samples = 2;
		uint64_t hash = render_whole(&fixture, &other.settings);
		pthread_t thread;
		assert_int_equal(pthread_create(&thread, NULL, guest_render, &other), 0);
		do {
			_Atomic uint32_t counted = 0; /* relaxed: the loop's end orders the additions before the read */
			stilb_job_parallel_for(fixture.pool, 1000, 1, count_on, &counted, 0);
			assert_int_equal(atomic_load_explicit(&counted, memory_order_relaxed), 1000);
			rest(100);
		} while (!atomic_load_explicit(&other.done, memory_order_acquire));
		pthread_join(thread, NULL);
		assert_int_equal(other.hash, hash);
		render_fixture_finish(&fixture);
	}
}

static void stopped_before_it_runs(void **state)
{
	(void)state;
	render_fixture fixture = render_fixture_make("cornell", 1);
	stilb_gi_settings settings = render_fixture_settings(&fixture);
	stilb_gi_render *render = render_fixture_create(&fixture, &settings);
	assert_int_equal(progress_of(render).end, STILB_GI_END_NOT);
	stilb_gi_render_stop(render);
	assert_int_equal(stilb_gi_render_run(render), STILB_OK);
	assert_int_equal(progress_of(render).end, STILB_GI_END_STOPPED);
	assert_int_equal(progress_of(render).camera_rays, 0);
	assert_int_equal(stilb_gi_render_run(render), STILB_OK);
	assert_int_equal(progress_of(render).end, STILB_GI_END_SAMPLES);
	uint64_t hash = film_hash(render);
	assert_int_equal(stilb_gi_render_run(render), STILB_OK); /* nothing is left to do */
	assert_int_equal(film_hash(render), hash);
	stilb_gi_render_destroy(render);
	render_fixture_finish(&fixture);
}

#define PASS(at, first, count)                                                                                         \
	{                                                                                                                  \
		.block = at, .first_sample = first, .sample_count = count                                                      \
	}

/* One pass; or a first round over coarse grids; or, with a limit, one sample first. Then the samples double. */
static void passes(void **state)
{
	(void)state;
	static const struct {
		bool progressive;
		uint32_t samples;
		float error;
		uint32_t count;
		stilb_gi_pass passes[9];
	} cases[] = {
		{false, 40, 0.0f, 1, {PASS(1, 0, 40)}},
		{false, 6, 1e-9f, 4, {PASS(1, 0, 1), PASS(1, 1, 1), PASS(1, 2, 2), PASS(1, 4, 2)}},
		{true,
	     6,
	     0.0f,
	     6,
	     {PASS(32, 0, 6), PASS(16, 0, 6), PASS(8, 0, 6), PASS(4, 0, 6), PASS(2, 0, 6), PASS(1, 0, 6)}},
		{true,
	     40,
	     0.0f,
	     8,
	     {PASS(32, 0, 16), PASS(16, 0, 16), PASS(8, 0, 16), PASS(4, 0, 16), PASS(2, 0, 16), PASS(1, 0, 16),
	      PASS(1, 16, 16), PASS(1, 32, 8)}},
		{true,
	     6,
	     1e-9f,
	     9,
	     {PASS(32, 0, 1), PASS(16, 0, 1), PASS(8, 0, 1), PASS(4, 0, 1), PASS(2, 0, 1), PASS(1, 0, 1), PASS(1, 1, 1),
	      PASS(1, 2, 2), PASS(1, 4, 2)}},
	};
	render_fixture fixture = render_fixture_make("cornell", 1);
	stilb_gi_settings settings = render_fixture_settings(&fixture);
	settings.width = 19;
	settings.height = 11;
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i += TEST_TSAN ? 2 : 1) {
		settings.progressive = cases[i].progressive;
		settings.error = cases[i].error;
		settings.samples = cases[i].samples;
		stilb_gi_render *render = render_fixture_create(&fixture, &settings);
		assert_int_equal(stilb_gi_render_run(render), STILB_OK);
		stilb_gi_progress progress = progress_of(render);
		assert_int_equal(progress.pass_count, cases[i].count);
		double seconds = 0.0;
		for (uint32_t p = 0; p < progress.pass_count; p++) {
			const stilb_gi_pass *pass = &progress.passes[p], *expected = &cases[i].passes[p];
			assert_true(pass->finished && pass->seconds > 0.0);
			seconds += pass->seconds;
			assert_int_equal(pass->block, expected->block);
			assert_int_equal(pass->first_sample, expected->first_sample);
			assert_int_equal(pass->sample_count, expected->sample_count);
		}
		assert_true(seconds <= progress.seconds);
		assert_int_equal(progress.samples, settings.samples);
		assert_int_equal(progress.block, 1);
		assert_int_equal(progress.camera_rays, 19 * 11 * settings.samples);
		assert_true(progress.rays > progress.camera_rays + progress.shadow_rays && progress.shadow_rays > 0);
		assert_true(progress.done == 1.0 && progress.bad_samples == 0);
		stilb_gi_render_destroy(render);
	}
	render_fixture_finish(&fixture);
}

/* ---- limits ------------------------------------------------------------------------------------------------------ */

static void time_limit(void **state)
{
	(void)state;
	render_fixture fixture = render_fixture_make("cornell", 1);
	stilb_gi_settings settings = render_fixture_settings(&fixture);
	settings.samples = 65536;
	settings.seconds = 0.1;
	for (int progressive = 0; progressive < 2; progressive++) {
		settings.progressive = progressive;
		stilb_gi_render *render = render_fixture_create(&fixture, &settings);
		assert_int_equal(stilb_gi_render_run(render), STILB_OK);
		stilb_gi_progress progress = progress_of(render);
		assert_int_equal(progress.end, STILB_GI_END_SECONDS);
		/* On a busy machine not every pixel has had its turn. */
		assert_true(progress.finished && progress.camera_rays > 0 && progress.done == 1.0);
		assert_true(progress.seconds >= settings.seconds);
		uint64_t rays = progress.rays;
		assert_int_equal(stilb_gi_render_run(render), STILB_OK); /* the time is over */
		assert_int_equal(progress_of(render).rays, rays);
		stilb_gi_render_destroy(render);
	}
	render_fixture_finish(&fixture);
}

/* Ends after the first whole pass that is good enough: for every worker count after the same one. */
static void error_limit(void **state)
{
	(void)state;
	uint64_t hash = 0;
	for (uint32_t workers = TEST_TSAN ? 1 : 0; workers < 3; workers++) {
		render_fixture fixture = render_fixture_make("cornell", workers);
		stilb_gi_settings settings = render_fixture_settings(&fixture);
		settings.width = 19;
		settings.height = 11;
		settings.samples = 65536;
		settings.error = 1.0f;
		stilb_gi_render *render = render_fixture_create(&fixture, &settings);
		assert_int_equal(stilb_gi_render_run(render), STILB_OK);
		stilb_gi_progress progress = progress_of(render);
		assert_int_equal(progress.end, STILB_GI_END_ERROR);
		assert_true(progress.error > 0.0 && progress.error <= 1.0 && progress.samples >= 8 && progress.samples < 65536);
		assert_true(hash == 0 || film_hash(render) == hash);
		hash = film_hash(render);
		stilb_gi_render_destroy(render);
		settings.samples = progress.samples / 2; /* half as many are not enough */
		render = render_fixture_create(&fixture, &settings);
		assert_int_equal(stilb_gi_render_run(render), STILB_OK);
		assert_int_equal(progress_of(render).end, STILB_GI_END_SAMPLES);
		stilb_gi_render_destroy(render);
		render_fixture_finish(&fixture);
	}
}

/* ---- settings ---------------------------------------------------------------------------------------------------- */

#define REFUSED(member, value)                                                                                         \
	do {                                                                                                               \
		stilb_gi_settings wrong = settings;                                                                            \
		stilb_gi_render *render = (stilb_gi_render *)&wrong;                                                           \
		wrong.member = value;                                                                                          \
		assert_int_equal(stilb_gi_render_create(fixture.gi, &wrong, fixture.pool, &render), STILB_ERROR_ARGUMENT);     \
		assert_null(render);                                                                                           \
		assert_non_null(strstr(stilb_error_message(), #member));                                                       \
	} while (0)

static void settings_out_of_range(void **state)
{
	(void)state;
	render_fixture fixture = render_fixture_make("cornell", 0);
	stilb_gi_settings settings = render_fixture_settings(&fixture);
	REFUSED(width, 0);
	REFUSED(height, 65537);
	REFUSED(samples, 0);
	REFUSED(samples, 65537);
	REFUSED(seconds, (double)NAN);
	REFUSED(seconds, -1.0);
	REFUSED(error, -0.1f);
	REFUSED(integrator, STILB_GI_INTEGRATOR_COUNT);
	REFUSED(sampler, STILB_GI_SAMPLER_COUNT);
	REFUSED(filter, STILB_GI_FILTER_COUNT);
	REFUSED(camera.position[2], NAN);
	REFUSED(camera.yaw, INFINITY);
	REFUSED(camera.fov_y, 0.0f);
	REFUSED(lens.radius, -1.0f);
	REFUSED(lens.focus, 0.0f);
	REFUSED(lens.blades, 2);
	REFUSED(lens.blades, 17);
	REFUSED(depth, 1025);
	REFUSED(model.kind, SHADE_BRDF_COUNT);
	REFUSED(model.ndf, -1);
	REFUSED(only, 2);
	REFUSED(roulette, 1.5f);
	REFUSED(rays, 0);
	REFUSED(ao_distance, NAN);
	REFUSED(exposure, INFINITY);
	REFUSED(cache.error, 0.0f);
	settings.ao_distance = 0.0f;
	REFUSED(ao_weighted, true);
	settings.height = 8192;
	REFUSED(width, 8193);
	render_fixture_finish(&fixture);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(same_bits_for_workers_and_passes),
		cmocka_unit_test(other_settings_other_bits),
		cmocka_unit_test(stopped_again_and_again),
		cmocka_unit_test(watched),
		cmocka_unit_test(same_bits_in_slices_beside_others),
		cmocka_unit_test(stopped_before_it_runs),
		cmocka_unit_test(passes),
		cmocka_unit_test(time_limit),
		cmocka_unit_test(error_limit),
		cmocka_unit_test(settings_out_of_range),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
