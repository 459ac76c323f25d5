/* The program of the suites `lod` and `pop`: frames of the stress test in each mode of --lod, by turns. */
#include "bench/detail/detail_run.h"
#include "bench/detail/detail_cases.h"
#include "bench/harness/bench_child.h"

#include "geometry/geometry_impostor.h"
#include "geometry/geometry_levels.h"
#include "render/render.h"
#include "scene/scene.h"
#include "scene/scene_build.h"

#include <math.h>
#include <string.h>
#include <sys/resource.h>

#define MODES (STILB_RENDER_DETAIL_MORPH + 1)
#define MOST_ROUNDS 64u

static void check(stilb_result result)
{
	if (result != STILB_OK)
		bench_child_fail("%s", stilb_error_message());
}

/* ---- what is drawn ----------------------------------------------------------------------------------------------- */

typedef struct world {
	stilb_scene *scene;
	uint32_t *ids; /* [scene->model_count] all */
	stilb_job_pool *pool;
	stilb_render *render;
	stilb_render_view view;
} world;

static void world_look(world *w, const stilb_scene_camera *camera)
{
	uint32_t width, height;
	stilb_render_size(w->render, &width, &height);
	w->view.view_projection = stilb_scene_camera_matrix(camera, (float)width / (float)height);
	memcpy(w->view.camera_position, camera->position, sizeof camera->position);
}

/* A world of the scene that `make` makes. workers: threads besides this one. */
static world world_of(stilb_scene *make(stilb_job_pool *pool), stilb_render_desc desc, uint32_t workers)
{
	world w = {0};
	stilb_job_pool_desc pool = {.worker_count = workers};
	if (stilb_job_pool_create(&pool, &w.pool) != 0)
		bench_child_fail("no threads");
	w.scene = make(w.pool);
	w.ids = stilb_memory_alloc(w.scene->model_count, sizeof *w.ids);
	if (!w.ids)
		bench_child_fail("no memory for %u models", w.scene->model_count);
	for (uint32_t m = 0; m < w.scene->model_count; m++)
		w.ids[m] = m;
	desc.context_count = pool.worker_count + 1;
	desc.morph = true;
	check(stilb_render_create(&desc, &w.render));
	check(stilb_render_set_scene(w.render, w.scene));
	w.view = (stilb_render_view){.lights = w.scene->lights,
	                             .light_count = w.scene->light_count,
	                             .surroundings = w.scene->surroundings,
	                             .shading = stilb_render_shading_default()};
	world_look(&w, &w.scene->camera);
	return w;
}

static uint32_t stress_models;

static stilb_scene *stress_scene(stilb_job_pool *pool)
{
	(void)pool;
	stilb_scene *scene;
	check(stilb_scene_create_stress(stress_models, 1, &scene));
	return scene;
}

/* The stress test with all models in view. */
static world world_open(uint32_t models, stilb_render_desc desc, uint32_t workers)
{
	stress_models = models;
	world w = world_of(stress_scene, desc, workers);
	stilb_scene_camera camera =
		stilb_scene_stress_camera(w.scene, STILB_SCENE_VIEW_ALL, (float)desc.width / (float)desc.height);
	world_look(&w, &camera);
	return w;
}

static void world_close(world *w)
{
	stilb_render_destroy(w->render);
	stilb_job_pool_destroy(w->pool);
	stilb_scene_destroy(w->scene);
	free(w->ids);
}

double detail_cpu_ms(void)
{
	struct rusage usage;
	getrusage(RUSAGE_SELF, &usage);
	return 1e3 * (double)(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
	       1e-3 * (double)(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
}

/* Draws a frame and waits for it. record_ms: this thread's time in recording; NULL: not asked for. Returns its CPU
 * time. */
static double draw(world *w, stilb_render_detail_mode mode, float error, double *record_ms)
{
	static const stilb_render_pass pass = {.name = "scene"};
	double start = detail_cpu_ms();
	w->view.detail = (stilb_render_detail){mode, error};
	check(stilb_render_frame_begin(w->render));
	uint64_t from = bench_child_now_ns();
	check(stilb_render_record_view(w->render, 0, w->scene, w->ids, w->scene->model_count, &w->view, w->pool, 0));
	if (record_ms)
		*record_ms = 1e-6 * (double)(bench_child_now_ns() - from);
	check(stilb_render_replay(w->render, &pass, 1, &w->view, 1, w->pool, 0));
	check(stilb_render_wait(w->render));
	return detail_cpu_ms() - start;
}

static int by_size(const void *a, const void *b)
{
	double x = *(const double *)a, y = *(const double *)b;
	return (x > y) - (x < y);
}

double detail_median(double *values, uint32_t count)
{
	qsort(values, count, sizeof *values, by_size);
	return values[count / 2];
}

/* ---- the suite lod ----------------------------------------------------------------------------------------------- */

static void put_times(double times[MODES][MOST_ROUNDS], uint32_t rounds)
{
	double off = detail_median(times[0], rounds);
	for (int mode = 0; mode < MODES; mode++) {
		char ratio[32];
		double ms = mode == 0 ? off : detail_median(times[mode], rounds);
		snprintf(ratio, sizeof ratio, "%s/off", stilb_render_detail_names[mode]);
		bench_child_metric(stilb_render_detail_names[mode], ms);
		if (mode > 0)
			bench_child_metric(ratio, ms / off);
	}
}

static void run_frame(const bench_child *child, uint32_t models, uint32_t width, uint32_t height)
{
	world w = world_open(models, (stilb_render_desc){.width = width, .height = height, .samples = 1}, 1);
	double times[MODES][MOST_ROUNDS], triangles[MODES];
	for (int mode = 0; mode < MODES; mode++) { /* pipelines are made, memory grows */
		draw(&w, (stilb_render_detail_mode)mode, 0.5f, NULL);
		triangles[mode] = 1e-3 * (double)stilb_render_triangles(w.render);
	}
	uint32_t rounds = 0;
	for (double spent = 0.0; rounds < 3 || (spent < 1e3 * child->seconds && rounds < MOST_ROUNDS); rounds++)
		for (int mode = 0; mode < MODES; mode++)
			spent += times[mode][rounds] = draw(&w, (stilb_render_detail_mode)mode, 0.5f, NULL);
	put_times(times, rounds);
	bench_child_metric("triangles-off", triangles[0]);
	bench_child_metric("triangles-pop", triangles[STILB_RENDER_DETAIL_POP]);
	bench_child_metric("triangles-morph", triangles[STILB_RENDER_DETAIL_MORPH]);
	world_close(&w);
}

static void run_record(const bench_child *child, uint32_t models, uint32_t width, uint32_t height)
{
	world w = world_open(
		models, (stilb_render_desc){.device = STILB_RENDER_DEVICE_NULL, .width = width, .height = height, .samples = 1},
		0);
	double times[MODES][MOST_ROUNDS];
	uint64_t end = bench_child_now_ns() + (uint64_t)(1e9 * child->seconds);
	for (int mode = 0; mode < MODES; mode++)
		times[mode][0] = (double)INFINITY;
	/* The least of all rounds: whoever else wants the CPU only makes a frame longer. */
	for (uint32_t rounds = 0; rounds < 10 || bench_child_now_ns() < end; rounds++)
		for (int mode = 0; mode < MODES; mode++) {
			double ms;
			for (int frame = 0; frame < 16; frame++) /* parts come to rest in this mode */
				draw(&w, (stilb_render_detail_mode)mode, 0.5f, NULL);
			draw(&w, (stilb_render_detail_mode)mode, 0.5f, &ms);
			times[mode][0] = fmin(times[mode][0], ms);
		}
	put_times(times, 1);
	world_close(&w);
}

/* The camera's place in frame f of a flight of `frames`, from near to where all models are in view: by 1 % a frame. */
static stilb_scene_camera flight_camera(const world *w, uint32_t f, uint32_t frames)
{
	stilb_scene_camera camera = w->scene->camera;
	float near = powf(1.01f, (float)f - (float)frames);
	camera.position[1] = 2.0f + (camera.position[1] - 2.0f) * near;
	camera.position[2] *= near;
	return camera;
}

static void run_flight(const bench_child *child, uint32_t models, uint32_t width, uint32_t height)
{
	enum { FRAMES = 24 };
	(void)child;
	world w = world_open(models, (stilb_render_desc){.width = width, .height = height, .samples = 1}, 1);
	double times[MODES][MOST_ROUNDS];
	for (int mode = 0; mode < MODES; mode++)
		for (uint32_t f = 0; f <= FRAMES; f++) {
			stilb_scene_camera camera = flight_camera(&w, f, FRAMES);
			world_look(&w, &camera);
			double ms = draw(&w, (stilb_render_detail_mode)mode, 0.5f, NULL);
			if (f > 0) /* the first makes pipelines and ends what the mode before has left */
				times[mode][f - 1] = ms;
		}
	put_times(times, FRAMES);
	world_close(&w);
}

/* Memory in use, bytes. */
static double memory_bytes(void)
{
	long pages = 0, resident = 0;
	FILE *file = fopen("/proc/self/statm", "r");
	if (!file || fscanf(file, "%ld %ld", &pages, &resident) != 2)
		bench_child_fail("/proc/self/statm cannot be read");
	fclose(file);
	return (double)resident * (double)sysconf(_SC_PAGESIZE);
}

static void run_million(const bench_child *child, uint32_t models, uint32_t width, uint32_t height)
{
	(void)child;
	world w = world_open(models, (stilb_render_desc){.width = width, .height = height, .samples = 1}, 1);
	double off = 0.0, pop = 0.0;
	for (int frame = 0; frame < 2; frame++)
		off = draw(&w, STILB_RENDER_DETAIL_OFF, 0.5f, NULL);
	double before = memory_bytes();
	for (int frame = 0; frame < 2; frame++)
		pop = draw(&w, STILB_RENDER_DETAIL_POP, 0.5f, NULL);
	bench_child_metric("off", off);
	bench_child_metric("pop", pop);
	bench_child_metric("pop/off", pop / off);
	bench_child_metric("memory", 100.0 * (memory_bytes() - before) / before);
	world_close(&w);
}

/* ---- the suite pop ----------------------------------------------------------------------------------------------- */

#define SWEEP_FRAMES 64u
#define SWEEP_FIRST 0.36 /* of the allowed error; the last is 0.68, the middle 0.5 */
#define SWEEP_STEP 1.01

/* The frames of a sweep in display codes. */
typedef struct film {
	uint8_t *codes; /* [SWEEP_FRAMES][height][width][3] */
	uint32_t width, height;
} film;

static size_t film_size(const film *f)
{
	return (size_t)f->width * f->height * 3;
}

/* scale: of all allowed errors. */
static film film_make(world *w, stilb_render_detail_mode mode, double scale)
{
	film f = {0};
	stilb_render_size(w->render, &f.width, &f.height);
	f.codes = stilb_memory_alloc(SWEEP_FRAMES, film_size(&f));
	if (!f.codes)
		bench_child_fail("no memory for a flight");
	check(stilb_render_set_scene(w->render, w->scene)); /* without history */
	for (uint32_t frame = 0; frame < SWEEP_FRAMES; frame++) {
		stilb_image image;
		draw(w, mode, (float)(scale * SWEEP_FIRST * pow(SWEEP_STEP, frame)), NULL);
		check(stilb_render_read_image(w->render, &image));
		memcpy(f.codes + frame * film_size(&f), image.pixels, film_size(&f));
		stilb_image_finish(&image);
	}
	return f;
}

/* A scene twice: as it is lit, and each model in a colour of its own without light. */
typedef struct stage {
	world lit, named;
} stage;

/* Six bumpy balls, about a hundred pixels wide in the pictures of the suite, with all the levels that can be made of
 * them. Beside smaller ones their insides are large. */
static stilb_scene *boulders_scene(stilb_job_pool *pool)
{
	stilb_scene_build *build = stilb_scene_build_begin();
	stilb_scene_mesh ball;
	check(stilb_scene_mesh_sphere(5, &ball));
	for (uint32_t v = 0; v < ball.vertex_count; v++) {
		float *p = ball.vertices[v].position, *n = ball.vertices[v].normal, slope[3], along = 0.0f;
		float bump = 0.05f * sinf(5.0f * p[0] + 1.0f) * sinf(6.0f * p[1]) * sinf(4.0f * p[2] + 2.0f);
		slope[0] = 0.25f * cosf(5.0f * p[0] + 1.0f) * sinf(6.0f * p[1]) * sinf(4.0f * p[2] + 2.0f);
		slope[1] = 0.3f * sinf(5.0f * p[0] + 1.0f) * cosf(6.0f * p[1]) * sinf(4.0f * p[2] + 2.0f);
		slope[2] = 0.2f * sinf(5.0f * p[0] + 1.0f) * sinf(6.0f * p[1]) * cosf(4.0f * p[2] + 2.0f);
		for (int i = 0; i < 3; i++)
			along += slope[i] * p[i];
		stilb_vec3 normal = {0};
		for (int i = 0; i < 3; i++) /* of the surface |p| = 1 + bump, to first order */
			normal[i] = p[i] * (1.0f + along) - slope[i];
		normal = stilb_vec3_normalize(normal);
		for (int i = 0; i < 3; i++) {
			n[i] = normal[i];
			p[i] *= 1.0f + bump;
		}
	}
	stilb_geometry_levels_desc levels = stilb_geometry_levels_desc_default();
	check(stilb_geometry_levels(&ball, &levels, pool, 0));
	uint32_t mesh = stilb_scene_build_mesh(build, &ball);
	stilb_scene_mesh_finish(&ball);
	for (uint32_t m = 0; m < 6; m++) {
		stilb_scene_material paint = {.diffuse = {0.5f, 0.45f, 0.3f}, .roughness = 0.6f};
		stilb_scene_build_part part = {mesh, stilb_scene_build_material(build, &paint)};
		float size = 1.0f - 0.04f * (float)m, angle = (float)m, c = size * cosf(angle), s = size * sinf(angle);
		stilb_mat4 place = {{c, 0, -s, 0, 0, size, 0, 0, s, 0, c, 0, 0, 0, 0, 1}};
		place.m[12] = 2.2f * ((float)(m % 3) - 1.0f);
		place.m[13] = 2.2f * ((float)(m / 3) - 0.5f);
		stilb_scene_build_model(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &place), &part, 1);
	}
	stilb_scene_light sun = {
		.kind = STILB_SCENE_LIGHT_DIRECTIONAL, .direction = {-0.48f, -0.6f, -0.64f}, .intensity = {2.5f, 2.4f, 2.2f}};
	stilb_scene_surroundings around = {.sky = {0.35f, 0.4f, 0.5f}, .ground = {0.15f, 0.13f, 0.1f}};
	stilb_scene_build_light(build, &sun);
	stilb_scene_build_surroundings(build, &around);
	stilb_scene *scene;
	check(stilb_scene_build_end(build, &scene));
	scene->camera = (stilb_scene_camera){.position = {0, 0, 12}, .fov_y = 0.37f, .near_z = 1.0f, .far_z = 30.0f};
	return scene;
}

/* models: of the stress test; 0: the boulders. */
static stage stage_open(uint32_t models, uint32_t width, uint32_t height)
{
	stage s;
	stilb_render_desc desc = {.width = width, .height = height, .samples = 4};
	for (int named = 0; named < 2; named++) {
		world *w = named ? &s.named : &s.lit;
		*w = models > 0 ? world_open(models, desc, 1) : world_of(boulders_scene, desc, 1);
		if (!named)
			continue;
		for (uint32_t m = 0; m < w->scene->material_count; m++) {
			stilb_scene_material *material = &w->scene->materials[m];
			*material = (stilb_scene_material){.roughness = 1.0f};
			for (uint32_t c = 0; c < 3; c++)
				material->emission[c] = stilb_random_float(5, 3 * (uint64_t)m + c);
		}
		w->view.light_count = 0;
		w->view.surroundings = (stilb_scene_surroundings){0};
	}
	return s;
}

static void stage_close(stage *s)
{
	world_close(&s->lit);
	world_close(&s->named);
}

/* True for pixels in which no frame of the sweep shows more or less of any model than the others do. */
static bool *static_pixels(stage *s, stilb_render_detail_mode mode, double scale)
{
	film f = film_make(&s->named, mode, scale);
	bool *still = stilb_memory_alloc(film_size(&f) / 3, 1);
	if (!still)
		bench_child_fail("no memory for a picture");
	for (size_t i = 0; i < film_size(&f) / 3; i++) {
		still[i] = true;
		for (uint32_t frame = 1; frame < SWEEP_FRAMES && still[i]; frame++)
			still[i] = memcmp(f.codes + 3 * i, f.codes + frame * film_size(&f) + 3 * i, 3) == 0;
	}
	free(f.codes);
	return still;
}

/* The largest change from one frame to the next, % of white. */
typedef struct change {
	double pixel, block;             /* of a pixel's channel; of its mean over any 8 x 8 pixels */
	double still_pixel, still_block; /* the same, of static pixels alone */
} change;

/* Sums over rectangles: [(height + 1) * (width + 1)], of what lies above and left of a corner. */
static void sum_up(int32_t *sums, uint32_t width, uint32_t y, uint32_t x, int32_t value)
{
	size_t at = (size_t)(y + 1) * (width + 1) + x + 1;
	sums[at] = value + sums[at - 1] + sums[at - width - 1] - sums[at - width - 2];
}

static int32_t sum_of_block(const int32_t *sums, uint32_t width, uint32_t y, uint32_t x)
{
	const int32_t *first = sums + (size_t)y * (width + 1) + x, *last = first + (size_t)8 * (width + 1);
	return last[8] - last[0] - first[8] + first[0];
}

/* Adds the change from one frame to the next. sums: two of f's size; the first has how many pixels are static. */
static void frame_change(const film *f, uint32_t frame, const bool *is_still, int32_t *sums[2], change *worst)
{
	const uint8_t *now = f->codes + frame * film_size(f), *before = now - film_size(f);
	if (memcmp(now, before, film_size(f)) == 0)
		return;
	for (size_t c = 0; c < 3; c++) {
		for (uint32_t y = 0; y < f->height; y++)
			for (uint32_t x = 0; x < f->width; x++) {
				size_t at = (size_t)y * f->width + x;
				int32_t step = now[3 * at + c] - before[3 * at + c];
				double here = fabs((double)step) / 2.55;
				sum_up(sums[1], f->width, y, x, step);
				worst->pixel = fmax(worst->pixel, here);
				worst->still_pixel = is_still[at] ? fmax(worst->still_pixel, here) : worst->still_pixel;
			}
		for (uint32_t y = 0; y + 8 <= f->height; y++)
			for (uint32_t x = 0; x + 8 <= f->width; x++) {
				double here = fabs((double)sum_of_block(sums[1], f->width, y, x)) / 64.0 / 2.55;
				bool still = sum_of_block(sums[0], f->width, y, x) == 64;
				worst->block = fmax(worst->block, here);
				worst->still_block = still ? fmax(worst->still_block, here) : worst->still_block;
			}
	}
}

static change film_change(const film *f, const bool *is_still)
{
	change worst = {0};
	size_t corners = (size_t)(f->width + 1) * (f->height + 1);
	int32_t *sums[2] = {calloc(corners, sizeof *sums[0]), calloc(corners, sizeof *sums[1])};
	if (!sums[0] || !sums[1])
		bench_child_fail("no memory for a picture");
	for (uint32_t y = 0; y < f->height; y++)
		for (uint32_t x = 0; x < f->width; x++)
			sum_up(sums[0], f->width, y, x, is_still[(size_t)y * f->width + x]);
	for (uint32_t frame = 1; frame < SWEEP_FRAMES; frame++)
		frame_change(f, frame, is_still, sums, &worst);
	free(sums[0]);
	free(sums[1]);
	return worst;
}

static change sweep(stage *s, stilb_render_detail_mode mode, double scale)
{
	film f = film_make(&s->lit, mode, scale);
	bool *still = static_pixels(s, mode, scale);
	change found = film_change(&f, still);
	free(still);
	free(f.codes);
	return found;
}

/* Difference of two pictures, root of the mean square over pixels that are not background, % of white. */
static double picture_rms(const stilb_image *a, const stilb_image *b)
{
	const uint8_t *p = a->pixels, *q = b->pixels, *background = p;
	double square = 0.0;
	size_t covered = 0;
	for (size_t i = 0; i < (size_t)a->width * a->height; i++, p += 3, q += 3) {
		if (memcmp(p, background, 3) == 0 && memcmp(q, background, 3) == 0)
			continue;
		covered++;
		for (int c = 0; c < 3; c++)
			square += ((double)p[c] - q[c]) * ((double)p[c] - q[c]);
	}
	return sqrt(square / (3.0 * (double)covered)) / 2.55;
}

static void pop_metric(stilb_render_detail_mode mode, const char *name, double value)
{
	char metric[32];
	snprintf(metric, sizeof metric, "%s-%s", stilb_render_detail_names[mode], name);
	bench_child_metric(metric, value);
}

static void run_pop(const bench_child *child, uint32_t models, uint32_t width, uint32_t height)
{
	(void)child;
	stage s = stage_open(models, width, height);
	stilb_image full;
	draw(&s.lit, STILB_RENDER_DETAIL_OFF, 0.5f, NULL);
	check(stilb_render_read_image(s.lit.render, &full));
	for (int mode = STILB_RENDER_DETAIL_POP; mode <= STILB_RENDER_DETAIL_MORPH; mode++) {
		stilb_image image;
		change found = sweep(&s, (stilb_render_detail_mode)mode, 1.0);
		pop_metric((stilb_render_detail_mode)mode, "pixel", found.pixel);
		pop_metric((stilb_render_detail_mode)mode, "8x8", found.block);
		pop_metric((stilb_render_detail_mode)mode, "static", found.still_pixel);
		pop_metric((stilb_render_detail_mode)mode, "static-8x8", found.still_block);
		check(stilb_render_set_scene(s.lit.render, s.lit.scene));
		draw(&s.lit, (stilb_render_detail_mode)mode, 0.5f, NULL);
		check(stilb_render_read_image(s.lit.render, &image));
		pop_metric((stilb_render_detail_mode)mode, "rms", picture_rms(&full, &image));
		stilb_image_finish(&image);
	}
	stilb_image_finish(&full);
	stage_close(&s);
}

/* The three changes that are compared: of 8 x 8 static pixels, of 8 x 8 pixels anywhere, of a static pixel. */
#define NEARER_KINDS 3
static void nearer_changes(stage *s, stilb_render_detail_mode mode, double factor, double out[NEARER_KINDS])
{
	change found = sweep(s, mode, factor);
	memcpy(out, (double[NEARER_KINDS]){found.still_block, found.block, found.still_pixel}, NEARER_KINDS * sizeof *out);
}

static void run_nearer(const bench_child *child, uint32_t models, uint32_t width, uint32_t height)
{
	static const char *const kinds[NEARER_KINDS] = {"static-8x8", "8x8", "static"};
	(void)child;
	stage s = stage_open(models, width, height);
	double bound[NEARER_KINDS], here[NEARER_KINDS];
	nearer_changes(&s, STILB_RENDER_DETAIL_POP, 1.0, bound);
	for (int mode = STILB_RENDER_DETAIL_FADE; mode <= STILB_RENDER_DETAIL_MORPH; mode++) {
		double factor[NEARER_KINDS] = {0.0};
		bool ended[NEARER_KINDS] = {false};
		for (double next = 1.0; next <= 16.01 && !(ended[0] && ended[1] && ended[2]); next *= M_SQRT2) {
			nearer_changes(&s, (stilb_render_detail_mode)mode, next, here);
			for (int k = 0; k < NEARER_KINDS; k++) {
				ended[k] |= here[k] > bound[k];
				factor[k] = ended[k] ? factor[k] : next;
			}
		}
		for (int k = 0; k < NEARER_KINDS; k++)
			pop_metric((stilb_render_detail_mode)mode, kinds[k], factor[k]);
	}
	stage_close(&s);
}

/* ---- the horde --------------------------------------------------------------------------------------------------- */

#define HORDE_MODEL "/usr/share/assimp/models/BLEND/HUMAN.blend" /* 8,560 triangles; Debian's assimp-testmodels */
#define HORDE_SHARE 100u                                         /* every so many-th model is drawn as meshes */

/* Models on a square grid in the plane y = 0, each turned by a random angle. */
static stilb_scene *horde_scene(const stilb_scene *person, uint32_t models)
{
	stilb_scene_build *build = stilb_scene_build_begin();
	stilb_scene_build_part parts[8];
	uint32_t count = person->first_part[1], side = (uint32_t)ceil(sqrt(models));
	float space = 1.2f * person->bounds.radius[0];
	for (uint32_t p = 0; p < count && p < 8; p++) {
		stilb_scene_material material = person->materials[person->part_material[p]];
		material.diffuse_texture = 0;
		parts[p] = (stilb_scene_build_part){stilb_scene_build_mesh(build, &person->meshes[person->part_mesh[p]]),
		                                    stilb_scene_build_material(build, &material)};
	}
	for (uint32_t m = 0; m < models; m++) {
		float angle = 6.2831853f * stilb_random_float(1, m), c = cosf(angle), s = sinf(angle);
		stilb_mat4 place = {{c, 0, -s, 0, 0, 1, 0, 0, s, 0, c, 0, 0, 0, 0, 1}};
		place.m[12] = ((float)(m % side) - 0.5f * (float)side) * space;
		place.m[14] = ((float)(m / side) - 0.5f * (float)side) * space;
		place = stilb_mat4_multiply(place, person->part_transform[0]);
		stilb_scene_build_model(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &place), parts, count);
	}
	stilb_scene_light sun = {
		.kind = STILB_SCENE_LIGHT_DIRECTIONAL, .direction = {-0.6f, -0.64f, -0.48f}, .intensity = {2.5f, 2.4f, 2.2f}};
	stilb_scene_surroundings around = {.sky = {0.35f, 0.4f, 0.5f}, .ground = {0.15f, 0.13f, 0.1f}};
	stilb_scene_build_light(build, &sun);
	stilb_scene_build_surroundings(build, &around);
	stilb_scene *scene;
	check(stilb_scene_build_end(build, &scene));
	return scene;
}

/* A world of the horde with a camera above its front edge. impostor: NULL: none. */
static world horde_open(const stilb_scene *person, uint32_t models, stilb_render_desc desc, stilb_job_pool *pool,
                        stilb_scene_impostor *impostor)
{
	world w = {.scene = horde_scene(person, models), .pool = pool};
	uint32_t id;
	if (impostor)
		check(stilb_scene_add_impostor(w.scene, impostor, &id));
	for (uint32_t m = 0; impostor && m < models; m++)
		check(stilb_scene_set_impostor(w.scene, m, id + 1));
	w.ids = stilb_memory_alloc(models, sizeof *w.ids);
	for (uint32_t m = 0; m < models; m++)
		w.ids[m] = m;
	desc.context_count = 2;
	check(stilb_render_create(&desc, &w.render));
	check(stilb_render_set_scene(w.render, w.scene));
	w.view = (stilb_render_view){.lights = w.scene->lights,
	                             .light_count = w.scene->light_count,
	                             .surroundings = w.scene->surroundings,
	                             .both_sides = person->both_sides,
	                             .backdrop = {.kind = STILB_SCENE_BACKDROP_NOTHING},
	                             .shading = stilb_render_shading_default()};
	return w;
}

/* RMS between the mean pixels of two pictures, which have 8 x 8 points a pixel, over those that one of them covers, %
 * of white. */
static void horde_compare(const stilb_image *a, const stilb_image *b, double *square, uint32_t *covered)
{
	uint32_t side = a->width / 8;
	for (uint32_t i = 0; i < side * side; i++) {
		double sum[2][4] = {{0.0}};
		for (uint32_t p = 0; p < 64; p++) {
			size_t at = 4 * ((size_t)(i / side * 8 + p / 8) * a->width + i % side * 8 + p % 8);
			for (int k = 0; k < 2; k++) {
				const uint8_t *q = (const uint8_t *)(k ? b : a)->pixels + at;
				for (int c = 0; c < 4; c++)
					sum[k][c] += (c < 3 ? q[c] * q[3] / 255.0 : q[3]) / 64.0 / 2.55;
			}
		}
		if (sum[0][3] == 0.0 && sum[1][3] == 0.0)
			continue;
		*covered += 1;
		for (int c = 0; c < 3; c++)
			*square += (sum[0][c] - sum[1][c]) * (sum[0][c] - sum[1][c]) / 3.0;
	}
}

/* The difference of a person from 26 directions whose sphere is so many pixels high. */
static double horde_rms(const stilb_scene *person, stilb_job_pool *pool, stilb_scene_impostor *impostor, float pixels)
{
	uint32_t side = 8 * ((uint32_t)pixels + 4), covered = 0;
	double square = 0.0;
	world w = horde_open(person, 1, (stilb_render_desc){.width = side, .height = side, .samples = 1}, pool, impostor);
	float radius = w.scene->bounds.radius[0], far = radius * (float)side / 8.0f / (pixels * tanf(0.15f));
	for (int i = 0; i < 27; i++) {
		if (i == 13)
			continue;
		stilb_vec3 d = stilb_vec3_normalize(
			stilb_vec3_make((float)(i % 3) - 0.87f, (float)(i / 3 % 3) - 0.93f, (float)(i / 9) - 1.05f));
		stilb_scene_camera camera = {.position = {w.scene->bounds.x[0] + far * d[0], w.scene->bounds.y[0] + far * d[1],
		                                          w.scene->bounds.z[0] + far * d[2]},
		                             .yaw = atan2f(d[0], d[2]),
		                             .pitch = -asinf(d[1]),
		                             .fov_y = 0.3f,
		                             .near_z = 0.1f * far,
		                             .far_z = 10.0f * far};
		stilb_image meshes, one;
		world_look(&w, &camera);
		draw(&w, STILB_RENDER_DETAIL_OFF, 0.5f, NULL);
		check(stilb_render_read_image(w.render, &meshes));
		/* The picture has 8 x 8 points a pixel: the impostor is recorded by hand, though it is that much too near. */
		static const stilb_render_pass pass = {.name = "scene"};
		stilb_render_impostor handle;
		check(stilb_render_impostor_create(w.render, &w.scene->impostors[0], &handle));
		check(stilb_render_frame_begin(w.render));
		check(stilb_render_pass_begin(w.render, 0, 1));
		stilb_render_context *context = stilb_render_context_get(w.render, 0);
		stilb_render_segment_begin(context, 0, 0);
		stilb_render_draw(context, handle.mesh, handle.material, &w.scene->part_transform[0]);
		stilb_render_segment_end(context);
		check(stilb_render_pass_end(w.render, 0));
		check(stilb_render_replay(w.render, &pass, 1, &w.view, 1, w.pool, 0));
		check(stilb_render_read_image(w.render, &one));
		stilb_render_impostor_destroy(w.render, handle);
		horde_compare(&meshes, &one, &square, &covered);
		stilb_image_finish(&meshes);
		stilb_image_finish(&one);
	}
	*impostor = w.scene->impostors[0]; /* back */
	w.scene->impostors[0] = (stilb_scene_impostor){0};
	stilb_render_destroy(w.render);
	stilb_scene_destroy(w.scene);
	free(w.ids);
	return sqrt(square / covered);
}

/* CPU time of a frame of every HORDE_SHARE-th person in the coarsest level that may be drawn, without impostors, times
 * HORDE_SHARE. */
static void horde_levels(const stilb_scene *person, uint32_t models, stilb_render_desc desc,
                         const stilb_scene_camera *camera, stilb_job_pool *pool)
{
	stilb_geometry_levels_desc levels = stilb_geometry_levels_desc_default();
	for (uint32_t m = 0; m < person->mesh_count; m++)
		check(stilb_geometry_levels(&person->meshes[m], &levels, pool, 0));
	world w = horde_open(person, models, desc, pool, NULL);
	world_look(&w, camera);
	w.view.detail = (stilb_render_detail){STILB_RENDER_DETAIL_POP, 0.5f};
	for (uint32_t m = 0; m < models / HORDE_SHARE; m++)
		w.ids[m] = m * HORDE_SHARE;
	double least = (double)INFINITY;
	for (int round = 0; round < 4; round++) {
		static const stilb_render_pass pass = {.name = "scene"};
		double from = detail_cpu_ms();
		check(stilb_render_frame_begin(w.render));
		check(stilb_render_record_view(w.render, 0, w.scene, w.ids, models / HORDE_SHARE, &w.view, w.pool, 0));
		check(stilb_render_replay(w.render, &pass, 1, &w.view, 1, w.pool, 0));
		check(stilb_render_wait(w.render));
		least = fmin(least, detail_cpu_ms() - from);
	}
	bench_child_metric("levels", least * HORDE_SHARE);
	bench_child_metric("level-triangles", (double)stilb_render_triangles(w.render) / (models / HORDE_SHARE));
	stilb_render_destroy(w.render);
	stilb_scene_destroy(w.scene);
	free(w.ids);
}

static void run_horde(const bench_child *child, uint32_t models, uint32_t width, uint32_t height)
{
	stilb_scene_open_options quiet = {.quiet = true};
	stilb_scene *person;
	if (stilb_scene_open_with(HORDE_MODEL, &quiet, &person) != STILB_OK)
		bench_child_fail("%s; install assimp-testmodels", stilb_error_message());
	stilb_job_pool_desc workers = {.worker_count = 1};
	stilb_job_pool *pool;
	if (stilb_job_pool_create(&workers, &pool) != 0)
		bench_child_fail("no threads");
	stilb_geometry_impostor_desc desc = stilb_geometry_impostor_desc_default();
	stilb_scene_impostor impostor;
	double start = detail_cpu_ms(), times[2][MOST_ROUNDS];
	check(stilb_geometry_impostor_of_model(person, 0, &desc, pool, 0, &impostor));
	bench_child_metric("bake", detail_cpu_ms() - start);
	bench_child_metric("maps", (double)stilb_image_size(&impostor.maps) / 1048576.0);
	bench_child_metric("rms-8", horde_rms(person, pool, &impostor, 8.0f));
	bench_child_metric("rms-16", horde_rms(person, pool, &impostor, 16.0f));
	world w = horde_open(person, models, (stilb_render_desc){.width = width, .height = height, .samples = 1}, pool,
	                     &impostor);
	float half = 0.6f * person->bounds.radius[0] * sqrtf((float)models);
	stilb_scene_camera camera = {.position = {0.0f, 0.9f * half, 2.2f * half},
	                             .pitch = -0.36f,
	                             .fov_y = 0.75f,
	                             .near_z = 1.0f,
	                             .far_z = 8.0f * half};
	world_look(&w, &camera);
	bench_child_metric("pixels", (double)(person->bounds.radius[0] * (float)height /
	                                      (hypotf(camera.position[1], camera.position[2]) * tanf(0.375f))));
	uint32_t *few = stilb_memory_alloc(models / HORDE_SHARE, sizeof *few), *all = w.ids, rounds = 0;
	for (uint32_t m = 0; m < models / HORDE_SHARE; m++)
		few[m] = m * HORDE_SHARE;
	for (double spent = 0.0; rounds < 4 || (spent < 1e3 * child->seconds && rounds < MOST_ROUNDS); rounds++)
		for (int meshes = 0; meshes < 2; meshes++) {
			static const stilb_render_pass pass = {.name = "scene"};
			w.ids = meshes ? few : all;
			double from = detail_cpu_ms();
			w.view.detail = (stilb_render_detail){meshes ? STILB_RENDER_DETAIL_OFF : STILB_RENDER_DETAIL_POP, 0.5f};
			check(stilb_render_frame_begin(w.render));
			check(stilb_render_record_view(w.render, 0, w.scene, w.ids, meshes ? models / HORDE_SHARE : models, &w.view,
			                               w.pool, 0));
			check(stilb_render_replay(w.render, &pass, 1, &w.view, 1, w.pool, 0));
			check(stilb_render_wait(w.render));
			times[meshes][rounds] = (detail_cpu_ms() - from) * (meshes ? HORDE_SHARE : 1);
			spent += detail_cpu_ms() - from;
		}
	/* The first round makes pipelines. */
	double impostors = detail_median(times[0] + 1, rounds - 1), meshes = detail_median(times[1] + 1, rounds - 1);
	bench_child_metric("impostors", impostors);
	bench_child_metric("meshes", meshes);
	bench_child_metric("impostors/meshes", impostors / meshes);
	free(few);
	w.ids = all;
	horde_levels(person, models, (stilb_render_desc){.width = width, .height = height, .samples = 1}, &camera, pool);
	world_close(&w);
	stilb_scene_destroy(person);
}

/* ---- a mesh of millions of triangles ----------------------------------------------------------------------------- */

/* Random numbers at the corners of a grid of 1 m, interpolated: [-1, 1]. */
static float rock_noise(stilb_vec3 p, uint32_t seed)
{
	float low[3], share[3], sum = 0.0f;
	for (int i = 0; i < 3; i++) {
		low[i] = floorf(p[i]);
		share[i] = p[i] - low[i];
		share[i] *= share[i] * (3.0f - 2.0f * share[i]);
	}
	for (uint32_t c = 0; c < 8; c++) {
		uint64_t place = 0;
		float weight = 1.0f;
		for (uint32_t i = 0; i < 3; i++) {
			place = place << 20 | (uint64_t)((int64_t)low[i] + (c >> i & 1) + 400000);
			weight *= c >> i & 1 ? share[i] : 1.0f - share[i];
		}
		sum += weight * (2.0f * stilb_random_float(seed, place) - 1.0f);
	}
	return sum;
}

/* A ring of rock, 3 m and 1 m in radius about the Y axis, with heights of 0.2 m down to 1 mm: u and v go around it. */
static stilb_vec3 rock_place(uint32_t u, uint32_t v, uint32_t wide, uint32_t high)
{
	float a = 6.2831853f * (float)u / (float)wide, b = 6.2831853f * (float)v / (float)high;
	stilb_vec3 n = stilb_vec3_make(cosf(b) * cosf(a), sinf(b), cosf(b) * sinf(a));
	stilb_vec3 p = stilb_vec3_make(3.0f * cosf(a), 0.0f, 3.0f * sinf(a)) + n;
	float height = 0.0f;
	for (uint32_t octave = 0; octave < 8; octave++)
		height += rock_noise(p * (float)(1u << octave), octave) / (float)(8u << octave);
	return p + n * height;
}

static void rock_put_normals(stilb_scene_mesh *mesh)
{
	for (uint32_t t = 0; t < mesh->index_count; t += 3) {
		stilb_vec3 p[3];
		for (uint32_t k = 0; k < 3; k++) {
			const float *at = mesh->vertices[mesh->indices[t + k]].position;
			p[k] = stilb_vec3_make(at[0], at[1], at[2]);
		}
		stilb_vec3 n = stilb_vec3_cross(p[1] - p[0], p[2] - p[0]);
		for (uint32_t k = 0; k < 3; k++)
			for (int i = 0; i < 3; i++)
				mesh->vertices[mesh->indices[t + k]].normal[i] += n[i];
	}
	for (uint32_t v = 0; v < mesh->vertex_count; v++) {
		float *normal = mesh->vertices[v].normal;
		stilb_vec3 n = stilb_vec3_normalize(stilb_vec3_make(normal[0], normal[1], normal[2]));
		for (int i = 0; i < 3; i++)
			normal[i] = n[i];
	}
}

/* The ring of about so many triangles, nearly squares. */
static stilb_scene_mesh rock_make(uint32_t triangles)
{
	uint32_t high = (uint32_t)sqrt((double)triangles / 6.0), wide = triangles / 2 / high;
	stilb_scene_mesh mesh = {.vertex_count = wide * high, .index_count = 6 * wide * high};
	mesh.vertices = stilb_memory_alloc(mesh.vertex_count, sizeof *mesh.vertices);
	mesh.indices = stilb_memory_alloc(mesh.index_count, sizeof *mesh.indices);
	if (!mesh.vertices || !mesh.indices)
		bench_child_fail("no memory for a mesh of %u triangles", triangles);
	uint32_t *out = mesh.indices;
	for (uint32_t v = 0; v < high; v++)
		for (uint32_t u = 0; u < wide; u++) {
			stilb_vec3 p = rock_place(u, v, wide, high);
			uint32_t a = v * wide + u, b = v * wide + (u + 1) % wide, up = (v + 1) % high * wide;
			const uint32_t square[6] = {a, up + u, b, b, up + u, up + (u + 1) % wide};
			mesh.vertices[a] = (stilb_scene_vertex){.position = {p[0], p[1], p[2]},
			                                        .uv = {(float)u / (float)wide, (float)v / (float)high}};
			memcpy(out, square, sizeof square);
			out += 6;
		}
	rock_put_normals(&mesh);
	return mesh;
}

static world rock_open(uint32_t triangles, stilb_render_desc desc)
{
	world w = {0};
	stilb_job_pool_desc workers = {.worker_count = 1};
	if (stilb_job_pool_create(&workers, &w.pool) != 0)
		bench_child_fail("no threads");
	stilb_scene_mesh mesh = rock_make(triangles);
	stilb_geometry_levels_desc levels = stilb_geometry_levels_desc_default();
	uint64_t start = bench_child_now_ns();
	check(stilb_geometry_levels(&mesh, &levels, w.pool, 0));
	bench_child_metric("make", 1e-9 * (double)(bench_child_now_ns() - start));
	bench_child_metric("triangles", 1e-3 * (double)(mesh.index_count / 3));
	stilb_scene_build *build = stilb_scene_build_begin();
	stilb_scene_material grey = {.diffuse = {0.4f, 0.36f, 0.3f}, .roughness = 1.0f};
	stilb_scene_light sun = {
		.kind = STILB_SCENE_LIGHT_DIRECTIONAL, .direction = {-0.6f, -0.64f, -0.48f}, .intensity = {2.5f, 2.4f, 2.2f}};
	stilb_scene_surroundings around = {.sky = {0.35f, 0.4f, 0.5f}, .ground = {0.15f, 0.13f, 0.1f}};
	stilb_scene_build_part part = {stilb_scene_build_mesh(build, &mesh), stilb_scene_build_material(build, &grey)};
	stilb_scene_mesh_finish(&mesh);
	stilb_mat4 here = stilb_mat4_identity();
	stilb_scene_build_model(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &here), &part, 1);
	stilb_scene_build_light(build, &sun);
	stilb_scene_build_surroundings(build, &around);
	check(stilb_scene_build_end(build, &w.scene));
	w.ids = stilb_memory_alloc(1, sizeof *w.ids);
	if (!w.ids)
		bench_child_fail("no memory");
	w.ids[0] = 0;
	desc.context_count = 2;
	check(stilb_render_create(&desc, &w.render));
	check(stilb_render_set_scene(w.render, w.scene));
	w.view = (stilb_render_view){.lights = w.scene->lights,
	                             .light_count = w.scene->light_count,
	                             .surroundings = w.scene->surroundings,
	                             .backdrop = {.kind = STILB_SCENE_BACKDROP_NOTHING},
	                             .shading = stilb_render_shading_default()};
	return w;
}

/* Pixels that the last frame's meshes cover. */
static double covered_pixels(const world *w)
{
	stilb_image image;
	uint32_t covered = 0;
	check(stilb_render_read_image(w->render, &image));
	for (size_t i = 0; i < (size_t)image.width * image.height; i++)
		covered += ((const uint8_t *)image.pixels)[4 * i + 3] > 0;
	stilb_image_finish(&image);
	return (double)covered;
}

static void rock_view(const bench_child *child, world *w, const char *view, const stilb_scene_camera *camera)
{
	double times[2][MOST_ROUNDS], records[MOST_ROUNDS], spent = 0.0;
	char metric[32];
	uint32_t rounds = 0;
	world_look(w, camera);
	draw(w, STILB_RENDER_DETAIL_OFF, 0.5f, NULL); /* pipelines are made, memory grows */
	draw(w, STILB_RENDER_DETAIL_POP, 0.5f, NULL);
	double pixels = covered_pixels(w), triangles = (double)stilb_render_triangles(w->render);
	double draws = (double)stilb_render_stats_get(w->render).draws;
	for (; rounds < 3 || (spent < 1e3 * child->seconds && rounds < MOST_ROUNDS); rounds++) {
		times[0][rounds] = draw(w, STILB_RENDER_DETAIL_OFF, 0.5f, NULL);
		times[1][rounds] = draw(w, STILB_RENDER_DETAIL_POP, 0.5f, &records[rounds]);
		spent += times[0][rounds] + times[1][rounds];
	}
	double off = detail_median(times[0], rounds), pop = detail_median(times[1], rounds);
	const struct {
		const char *name;
		double value;
	} found[] = {{"off", off},           {"pop", pop},
	             {"pop/off", pop / off}, {"record", detail_median(records, rounds)},
	             {"draws", draws},       {"triangles", triangles / pixels}};
	for (size_t i = 0; i < sizeof found / sizeof *found; i++) {
		snprintf(metric, sizeof metric, "%s-%s", view, found[i].name);
		bench_child_metric(metric, found[i].value);
	}
}

static void run_clusters(const bench_child *child, uint32_t triangles, uint32_t width, uint32_t height)
{
	world w = rock_open(triangles, (stilb_render_desc){.width = width, .height = height, .samples = 1});
	/* A few centimetres above the top of the ring, along it and a little down; then from where all of it is seen. */
	stilb_scene_camera near = {
		.position = {0.5f, 1.25f, 3.1f}, .yaw = 1.7f, .pitch = -0.3f, .fov_y = 0.8f, .near_z = 0.02f, .far_z = 100.0f};
	stilb_scene_camera whole = {
		.position = {0.0f, 8.0f, 10.5f}, .pitch = -0.65f, .fov_y = 0.6f, .near_z = 0.02f, .far_z = 100.0f};
	rock_view(child, &w, "near", &near);
	rock_view(child, &w, "whole", &whole);
	world_close(&w);
}

/* ---- cases ------------------------------------------------------------------------------------------------------- */

typedef struct detail_case {
	const char *name;
	void (*run)(const bench_child *child, uint32_t models, uint32_t width, uint32_t height);
	uint32_t models, width, height;
} detail_case;

int main(int argc, char **argv)
{
#define CASE(NAME, TITLE, RUN, MODELS, WIDTH, HEIGHT) {NAME, run_##RUN, MODELS, WIDTH, HEIGHT},
#define run_vertices detail_run_vertices
#define run_memory detail_run_memory
	static const detail_case lod[] = {DETAIL_FRAMES(CASE) DETAIL_OTHERS(CASE)}, pop[] = {DETAIL_POPS(CASE)};
#undef CASE
#undef run_vertices
#undef run_memory
	bench_child child = bench_child_args(argc, argv);
	for (size_t i = 0; i < sizeof lod / sizeof *lod; i++)
		if (strcmp(child.case_name, lod[i].name) == 0) {
			lod[i].run(&child, lod[i].models, lod[i].width, lod[i].height);
			return 0;
		}
	for (size_t i = 0; i < sizeof pop / sizeof *pop; i++)
		if (strcmp(child.case_name, pop[i].name) == 0) {
			pop[i].run(&child, pop[i].models, pop[i].width, pop[i].height);
			return 0;
		}
	return BENCH_CHILD_SKIP;
}
