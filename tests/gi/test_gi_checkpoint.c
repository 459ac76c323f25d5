/* Checkpoints: a render that goes on elsewhere has the same bits, and a file that is not its own is refused by name. */
#include "gi_render_fixture.h"
#include "support/folder.h"

#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <time.h>

static const char path[] = "a.checkpoint";

static int tear_down(void **state)
{
	(void)state;
	remove(path);
	return folder_remove();
}

/* ---- stopped, written, read -------------------------------------------------------------------------------------- */

typedef struct stopper {
	stilb_gi_render *render;
	uint64_t rays;
	_Atomic bool done; /* tells the stopper's thread to end; release by the main thread, acquire by the stopper */
} stopper;

static void *stop_it(void *context)
{
	stopper *self = context;
	while (!atomic_load_explicit(&self->done, memory_order_acquire)) {
		nanosleep(&(struct timespec){.tv_nsec = 20000}, NULL);
		if (progress_of(self->render).rays >= self->rays)
			stilb_gi_render_stop(self->render);
	}
	return NULL;
}

/* Calls run, and stops it from another thread when so many more rays have been traced. */
static void run_for(stilb_gi_render *render, uint64_t rays)
{
	stopper timer = {.render = render, .rays = progress_of(render).rays + rays};
	pthread_t thread;
	assert_int_equal(pthread_create(&thread, NULL, stop_it, &timer), 0);
	assert_int_equal(stilb_gi_render_run(render), STILB_OK);
	atomic_store_explicit(&timer.done, true, memory_order_release); /* pairs with stop_it's acquire */
	pthread_join(thread, NULL);
}

/* Renders in parts, as if each were a process of its own: every part resumes the checkpoint of the one before. */
static uint64_t render_in_parts(const stilb_gi_settings *settings, uint32_t *parts)
{
	uint64_t hash = 0, camera_rays = 0;
	double done = 0.0;
	bool finished = false;
	for (*parts = 0; !finished; (*parts)++) {
		assert_true(*parts < 10000);
		render_fixture fixture = render_fixture_make("cornell", *parts % 3); /* other workers each time */
		stilb_gi_render *render = render_fixture_create(&fixture, settings);
		if (*parts > 0 && stilb_gi_render_resume(render, path) != STILB_OK)
			fail_msg("%s", stilb_error_message());
		assert_true(progress_of(render).camera_rays == camera_rays);
		assert_true(progress_of(render).done >= done);
		run_for(render, 1000 + 2500 * *parts);
		camera_rays = progress_of(render).camera_rays;
		if (settings->integrator != STILB_GI_INTEGRATOR_IRRADIANCE_CACHE) /* whose overture begins anew */
			done = progress_of(render).done;
		assert_int_equal(stilb_gi_render_checkpoint(render, path), STILB_OK);
		finished = progress_of(render).finished;
		if (settings->denoise)
			assert_int_equal(stilb_gi_render_denoise(render), STILB_OK);
		hash = film_hash(render);
		stilb_gi_render_destroy(render);
		render_fixture_finish(&fixture);
	}
	assert_int_equal(camera_rays, (uint64_t)settings->width * settings->height * settings->samples);
	return hash;
}

static void same_bits_in_parts(void **state)
{
	(void)state;
	render_fixture fixture = render_fixture_make("cornell", 1);
	stilb_gi_settings settings = render_fixture_settings(&fixture);
	uint32_t stops = 0;
	settings.samples = TEST_TSAN ? 6 : 16;
	for (int variant = TEST_TSAN ? 3 : 0; variant < 6; variant++) {
		settings.progressive = variant % 2;
		settings.firefly_weight = variant / 2 % 2;
		settings.denoise = variant >= 3;
		settings.integrator = variant < 5 ? STILB_GI_INTEGRATOR_PATH : STILB_GI_INTEGRATOR_IRRADIANCE_CACHE;
		settings.error = variant == 4 ? 0.01f : 0.0f; /* not reached */
		uint32_t parts;
		assert_int_equal(render_in_parts(&settings, &parts), render_whole(&fixture, &settings));
		stops += parts - 1;
	}
	assert_true(stops > (TEST_TSAN ? 2 : 5)); /* at least one of each, on a fast machine, too */
	render_fixture_finish(&fixture);
}

/* A resumed render may have other limits and another order of pixels, and another number of samples if its sampler does
 * not depend on that. */
static void other_limits(void **state)
{
	(void)state;
	render_fixture fixture = render_fixture_make("cornell", 1);
	stilb_gi_settings settings = render_fixture_settings(&fixture), more = settings;
	stilb_gi_render *render = render_fixture_create(&fixture, &settings);
	assert_int_equal(stilb_gi_render_run(render), STILB_OK);
	assert_int_equal(stilb_gi_render_checkpoint(render, path), STILB_OK);
	stilb_gi_render_destroy(render);
	more.samples = 11;
	more.progressive = true;
	more.exposure = 3.0f;
	render = render_fixture_create(&fixture, &more);
	assert_int_equal(stilb_gi_render_resume(render, path), STILB_OK);
	assert_int_equal(stilb_gi_render_run(render), STILB_OK);
	assert_int_equal(progress_of(render).camera_rays, 37 * 21 * 11);
	assert_int_equal(film_hash(render), render_whole(&fixture, &more));
	stilb_gi_render_destroy(render);
	more.samples = 2; /* it has more already */
	render = render_fixture_create(&fixture, &more);
	assert_int_equal(stilb_gi_render_resume(render, path), STILB_OK);
	assert_int_equal(stilb_gi_render_run(render), STILB_OK);
	assert_int_equal(film_hash(render), render_whole(&fixture, &settings));
	assert_int_equal(stilb_gi_render_resume(render, path), STILB_ERROR_ARGUMENT); /* has begun */
	stilb_gi_render_destroy(render);
	render_fixture_finish(&fixture);
}

/* Goes on from the checkpoint with so many samples, stopped before its first batch if `stop`, and leaves another. */
static uint64_t go_on(const render_fixture *fixture, stilb_gi_settings settings, uint32_t samples, bool stop)
{
	settings.samples = samples;
	stilb_gi_render *render = render_fixture_create(fixture, &settings);
	assert_int_equal(stilb_gi_render_resume(render, path), STILB_OK);
	if (stop)
		stilb_gi_render_stop(render);
	assert_int_equal(stilb_gi_render_run(render), STILB_OK);
	assert_int_equal(progress_of(render).end, stop ? STILB_GI_END_STOPPED : STILB_GI_END_SAMPLES);
	assert_int_equal(stilb_gi_render_checkpoint(render, path), STILB_OK);
	uint64_t hash = film_hash(render);
	stilb_gi_render_destroy(render);
	return hash;
}

/* A pass that was begun wants more samples than are wanted now: part of it is left, or nothing. */
static void fewer_samples(void **state)
{
	(void)state;
	render_fixture fixture = render_fixture_make("cornell", 1);
	stilb_gi_settings settings = render_fixture_settings(&fixture), two = settings, three = settings;
	settings.error = 1e-9f; /* passes of 1, 1, 2 ... samples */
	two.samples = 2;
	three.samples = 3;
	stilb_gi_render *render = render_fixture_create(&fixture, &two);
	assert_int_equal(stilb_gi_render_run(render), STILB_OK);
	assert_int_equal(stilb_gi_render_checkpoint(render, path), STILB_OK);
	stilb_gi_render_destroy(render);
	go_on(&fixture, settings, 8, true); /* begins with 2 and 3 */
	assert_int_equal(go_on(&fixture, settings, 2, false), render_whole(&fixture, &two));
	go_on(&fixture, settings, 8, true);
	assert_int_equal(go_on(&fixture, settings, 3, false), render_whole(&fixture, &three));
	render_fixture_finish(&fixture);
}

/* ---- what is refused --------------------------------------------------------------------------------------------- */

static void write_checkpoint(const render_fixture *fixture, const stilb_gi_settings *settings)
{
	stilb_gi_render *render = render_fixture_create(fixture, settings);
	assert_int_equal(stilb_gi_render_run(render), STILB_OK);
	assert_int_equal(stilb_gi_render_checkpoint(render, path), STILB_OK);
	stilb_gi_render_destroy(render);
}

/* Refused with these words; and the render is as it was. */
static void refuses(const render_fixture *fixture, const stilb_gi_settings *settings, const char *from,
                    const char *words)
{
	stilb_gi_render *render = render_fixture_create(fixture, settings);
	uint64_t hash = film_hash(render);
	assert_int_equal(stilb_gi_render_resume(render, from), STILB_ERROR_FILE);
	if (!strstr(stilb_error_message(), words) || !strstr(stilb_error_message(), from))
		fail_msg("\"%s\" does not say \"%s\"", stilb_error_message(), words);
	assert_int_equal(film_hash(render), hash);
	assert_int_equal(progress_of(render).camera_rays, 0);
	stilb_gi_render_destroy(render);
}

static void foreign_settings(void **state)
{
	(void)state;
	render_fixture fixture = render_fixture_make("cornell", 0), sphere = render_fixture_make("furnace:0.5", 0);
	stilb_gi_settings settings = render_fixture_settings(&fixture), other = settings;
	settings.samples = 1;
	write_checkpoint(&fixture, &settings);
	other.samples = 1;
	other.width = 36;
	refuses(&fixture, &other, path, "width 37, not 36");
	other = settings;
	other.integrator = STILB_GI_INTEGRATOR_AO;
	refuses(&fixture, &other, path, "integrator path, not ao");
	other = settings;
	other.seed = UINT64_MAX;
	refuses(&fixture, &other, path, "seed 0, not 18446744073709551615");
	other = settings;
	other.lens.radius = 0.125f;
	refuses(&fixture, &other, path, "lens.radius 0, not 0.125");
	other = settings;
	other.firefly_weight = true;
	refuses(&fixture, &other, path, "firefly_weight no, not yes");
	other = settings;
	other.cache.load = path; /* any file */
	refuses(&fixture, &other, path, "loaded irradiance cache");
	refuses(&sphere, &settings, path, "another scene");
	settings.sampler = STILB_GI_SAMPLER_STRATIFIED;
	write_checkpoint(&fixture, &settings);
	other = settings;
	other.samples = 2;
	refuses(&fixture, &other, path, "samples 1, not 2");
	render_fixture_finish(&fixture);
	render_fixture_finish(&sphere);
}

static void write_file(const void *data, size_t size)
{
	FILE *file = fopen(path, "wb");
	assert_non_null(file);
	assert_int_equal(fwrite(data, 1, size, file), size);
	assert_int_equal(fclose(file), 0);
}

static size_t read_file(unsigned char *data, size_t size)
{
	FILE *file = fopen(path, "rb");
	assert_non_null(file);
	size_t got = fread(data, 1, size, file);
	fclose(file);
	return got;
}

/* A line of the checkpoint's text has a name that is not known here, as after a setting was renamed; or its samples had
 * other bits. */
static void another_version(void **state)
{
	(void)state;
	static unsigned char whole[200000];
	render_fixture fixture = render_fixture_make("cornell", 0);
	stilb_gi_settings settings = render_fixture_settings(&fixture);
	settings.samples = 1;
	write_checkpoint(&fixture, &settings);
	size_t size = read_file(whole, sizeof whole);
	char *line = memmem(whole, size, "\nwidth 37\n", 10);
	assert_non_null(line);
	line[1] = 'W';
	write_file(whole, size);
	refuses(&fixture, &settings, path, "it was made by another version");
	line[1] = 'w';
	line = memmem(whole, size, ", samples ", 10);
	assert_non_null(line);
	line[10]++;
	write_file(whole, size);
	refuses(&fixture, &settings, path, "it was made with version " STILB_VERSION ", samples ");
	render_fixture_finish(&fixture);
}

/* Checkpoints with a changed byte, cut anywhere, or too long are refused. */
static void damaged_files(void **state)
{
	(void)state;
	static unsigned char whole[200000], damaged[sizeof whole + 1];
	render_fixture fixture = render_fixture_make("cornell", 0);
	stilb_gi_settings settings = render_fixture_settings(&fixture);
	settings.samples = 1;
	settings.firefly_weight = true;
	write_checkpoint(&fixture, &settings);
	size_t size = read_file(whole, sizeof whole);
	assert_in_range(size, 1000, sizeof whole - 1);
	for (size_t at = 0; at < size; at += 1 + size / 150) {
		memcpy(damaged, whole, size);
		damaged[at] ^= (unsigned char)(1 << at % 8);
		write_file(damaged, size);
		refuses(&fixture, &settings, path, "cannot resume");
		write_file(whole, at);
		refuses(&fixture, &settings, path, "cannot resume");
	}
	memcpy(damaged, whole, size);
	write_file(damaged, size + 1);
	refuses(&fixture, &settings, path, "damaged");
	write_file(whole, size);
	stilb_gi_render *render = render_fixture_create(&fixture, &settings);
	assert_int_equal(stilb_gi_render_resume(render, path), STILB_OK);
	stilb_gi_render_destroy(render);
	render_fixture_finish(&fixture);
}

/* Also a file that was made to fit: its hash is right, its numbers are not. pass_count is the fifth number of 8
 * bytes. */
static void forged_files(void **state)
{
	(void)state;
	static unsigned char data[200000];
	render_fixture fixture = render_fixture_make("cornell", 0);
	stilb_gi_settings settings = render_fixture_settings(&fixture);
	settings.samples = 1;
	write_checkpoint(&fixture, &settings);
	size_t size = read_file(data, sizeof data), body = size - sizeof(uint64_t);
	uint32_t text_length, count = 4000000000u, forged = 0;
	memcpy(&text_length, data + 22, sizeof text_length);
	unsigned char *state_at = data + 26 + text_length;
	for (size_t at = 0; at + 4 <= 80; at += 4) {
		uint32_t kept;
		memcpy(&kept, state_at + at, 4);
		memcpy(state_at + at, &count, 4);
		uint64_t hash = stilb_hash_fnv1a64(STILB_FNV1A64_START, data, body);
		memcpy(data + body, &hash, sizeof hash);
		write_file(data, size);
		stilb_gi_render *render = render_fixture_create(&fixture, &settings);
		stilb_result result = stilb_gi_render_resume(render, path); /* a count of rays may be anything */
		if (result == STILB_OK)
			assert_int_equal(stilb_gi_render_run(render), STILB_OK);
		forged += result != STILB_OK;
		stilb_gi_render_destroy(render);
		memcpy(state_at + at, &kept, 4);
	}
	assert_true(forged >= 5); /* pass_count, weighted, block, first_sample, sample_count */
	render_fixture_finish(&fixture);
}

static void no_files(void **state)
{
	(void)state;
	render_fixture fixture = render_fixture_make("cornell", 0);
	stilb_gi_settings settings = render_fixture_settings(&fixture);
	remove(path);
	refuses(&fixture, &settings, path, "No such file");
	refuses(&fixture, &settings, ".", "it is a folder");
	refuses(&fixture, &settings, "/dev/zero", "regular");
	write_file("", 0);
	refuses(&fixture, &settings, path, "not a checkpoint");
	write_file("#include <stdio.h>\nint main(void)\n", 33);
	refuses(&fixture, &settings, path, "not a checkpoint");
	render_fixture_finish(&fixture);
}

/* ---- no memory --------------------------------------------------------------------------------------------------- */

static uint32_t allocations_left = UINT32_MAX; /* of stilb_memory_alloc, until one fails; by this thread alone */
static bool allocation_failed;

void *__real_stilb_memory_alloc(size_t count, size_t size);
void *__wrap_stilb_memory_alloc(size_t count, size_t size);

void *__wrap_stilb_memory_alloc(size_t count, size_t size)
{
	if (allocations_left == 0) {
		allocations_left = UINT32_MAX;
		allocation_failed = true;
		return NULL;
	}
	if (allocations_left != UINT32_MAX)
		allocations_left--;
	return __real_stilb_memory_alloc(count, size);
}

/* Each allocation fails once, in create and in resume: a message, and nothing is left behind. */
static void no_memory(void **state)
{
	(void)state;
	render_fixture fixture = render_fixture_make("cornell", 0);
	stilb_gi_settings settings = render_fixture_settings(&fixture);
	settings.integrator = STILB_GI_INTEGRATOR_IRRADIANCE_CACHE;
	settings.firefly_weight = settings.denoise = true;
	settings.samples = 2;
	write_checkpoint(&fixture, &settings);
	bool resumed = false;
	uint32_t failures = 0;
	for (uint32_t i = 0; !resumed; i++) {
		stilb_gi_render *render;
		allocations_left = i;
		allocation_failed = false;
		stilb_result result = stilb_gi_render_create(fixture.gi, &settings, fixture.pool, &render);
		if (result == STILB_OK)
			result = stilb_gi_render_resume(render, path);
		allocations_left = UINT32_MAX;
		resumed = result == STILB_OK;
		failures += result == STILB_ERROR_MEMORY;
		assert_int_equal(result, allocation_failed ? STILB_ERROR_MEMORY : STILB_OK);
		stilb_gi_render_destroy(render);
	}
	assert_true(failures > 10);
	render_fixture_finish(&fixture);
}

/* ---- full disks -------------------------------------------------------------------------------------------------- */

static void full_disk(void **state)
{
	(void)state;
	static unsigned char before[200000], after[sizeof before];
	render_fixture fixture = render_fixture_make("cornell", 0);
	stilb_gi_settings settings = render_fixture_settings(&fixture);
	settings.samples = 1;
	write_checkpoint(&fixture, &settings);
	size_t size = read_file(before, sizeof before);
	stilb_gi_render *render = render_fixture_create(&fixture, &settings);
	assert_int_equal(stilb_gi_render_checkpoint(render, "/dev/full"), STILB_ERROR_FILE);
	assert_non_null(strstr(stilb_error_message(), "/dev/full"));
	struct rlimit old, small = {.rlim_cur = 50000};
	assert_int_equal(getrlimit(RLIMIT_FSIZE, &old), 0);
	small.rlim_max = old.rlim_max;
	signal(SIGXFSZ, SIG_IGN);
	assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
	stilb_result result = stilb_gi_render_checkpoint(render, path);
	assert_int_equal(setrlimit(RLIMIT_FSIZE, &old), 0);
	assert_int_equal(result, STILB_ERROR_FILE);
	assert_non_null(strstr(stilb_error_message(), path));
	assert_int_equal(read_file(after, sizeof after), size); /* the old one is whole */
	assert_memory_equal(before, after, size);
	assert_int_equal(stilb_gi_render_checkpoint(render, "no/such/folder/a"), STILB_ERROR_FILE);
	stilb_gi_render_destroy(render);
	render_fixture_finish(&fixture);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(same_bits_in_parts), cmocka_unit_test(other_limits),    cmocka_unit_test(fewer_samples),
		cmocka_unit_test(foreign_settings),   cmocka_unit_test(another_version), test_one_thread(damaged_files),
		test_one_thread(forged_files),        cmocka_unit_test(no_files),        test_one_thread(no_memory),
		cmocka_unit_test(full_disk),
	};
	return cmocka_run_group_tests(tests, folder_make, tear_down);
}
