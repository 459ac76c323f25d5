/* The traced references of live shadows: shadows whose edges and penumbrae are known in closed form, distances to edges
 * against a search, and live pictures that are wrong by a known distance. */
#include "gi/gi_world_fixture.h"

#include "scene/scene_build.h"
#include "support/shadow/shadow_truth.h"
#include "support/test.h"

#include <math.h>
#include <stdlib.h>

static stilb_job_pool *pool;

static int begin(void **state)
{
	(void)state;
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	desc.worker_count = 1;
	return stilb_job_pool_create(&desc, &pool);
}

static int end(void **state)
{
	(void)state;
	stilb_job_pool_destroy(pool);
	return 0;
}

/* ---- scenes ------------------------------------------------------------------------------------------------------ */

/* A horizontal rectangle that faces up. */
typedef struct sheet {
	float x, y, z;        /* its middle */
	float half_x, half_z; /* metres */
	uint32_t flags;       /* STILB_SCENE_MODEL_... */
} sheet;

static stilb_gi_scene *traced(const sheet *sheets, uint32_t count)
{
	static const float grey[3] = {0.5f, 0.5f, 0.5f}, none[3] = {0};
	stilb_scene_material matt = stilb_scene_material_make(grey, none, 1.0f);
	stilb_scene_build *build = stilb_scene_build_begin();
	stilb_scene_mesh plane;
	assert_int_equal(stilb_scene_mesh_plane(&plane), STILB_OK);
	stilb_scene_build_part part = {stilb_scene_build_mesh(build, &plane), stilb_scene_build_material(build, &matt)};
	for (uint32_t i = 0; i < count; i++) {
		stilb_mat4 place = stilb_mat4_scale_translate(1.0f, sheets[i].x, sheets[i].y, sheets[i].z);
		place.m[0] = sheets[i].half_x;
		place.m[10] = sheets[i].half_z;
		uint32_t node = stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &place);
		stilb_scene_build_model_flags(build, stilb_scene_build_model(build, node, &part, 1), sheets[i].flags);
	}
	stilb_scene_mesh_finish(&plane);
	stilb_scene *scene;
	if (stilb_scene_build_end(build, &scene) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	stilb_gi_scene *gi;
	stilb_gi_scene_desc desc = stilb_gi_scene_desc_default(pool);
	assert_int_equal(stilb_gi_scene_create(scene, &desc, &gi), STILB_OK);
	stilb_scene_destroy(scene);
	return gi;
}

/* Looks straight down from a height; `across` metres of y = 0 fill the picture's height. */
static stilb_scene_camera above(float x, float height, float across)
{
	return (stilb_scene_camera){.position = {x, height, 0.0f},
	                            .pitch = -1.57079632679f,
	                            .fov_y = 2.0f * atanf(0.5f * across / height),
	                            .near_z = 0.01f,
	                            .far_z = 100.0f};
}

/* ---- a square in the sun ----------------------------------------------------------------------------------------- */

#define SUN_WIDTH 96u
#define SUN_HEIGHT 64u
#define SUN_ACROSS 4.0f
#define PIXEL (SUN_ACROSS / SUN_HEIGHT) /* metres */

static const sheet square[] = {{0, 0, 0, 20, 20, 0}, {0, 1, 0, 0.5f, 0.5f, 0}};

/* The shadow lies beside the square, as the camera sees it: by (1.5, 0.3) at the height 1. */
static const stilb_scene_light sun = {
	.kind = STILB_SCENE_LIGHT_DIRECTIONAL, .direction = {0.8207827f, -0.5471885f, 0.1641565f}, .intensity = {1, 1, 1}};

/* How far a point of the floor is from the shadow's outline, metres: < 0 inside. */
static double outside_shadow(const float at[3])
{
	double x = fabs((double)at[0] - 1.5) - 0.5, z = fabs((double)at[2] - 0.3) - 0.5;
	if (x > 0.0 && z > 0.0)
		return hypot(x, z);
	return fmax(x, z);
}

static shadow_truth in_the_sun(stilb_gi_scene **gi, shadow_asked *asked)
{
	static stilb_scene_camera camera;
	camera = above(1.0f, 10.0f, SUN_ACROSS);
	*asked = (shadow_asked){&camera, SUN_WIDTH, SUN_HEIGHT, &sun, true};
	*gi = traced(square, 2);
	return shadow_truth_trace(*gi, asked, pool);
}

/* Every pixel sees the sun or not as geometry says, and edges are where it says, to a pixel. */
static void edges_are_where_geometry_says(void **state)
{
	(void)state;
	stilb_gi_scene *gi;
	shadow_asked asked;
	shadow_truth truth = in_the_sun(&gi, &asked);
	shadow_edges edges = shadow_edges_find(&truth, 0.0f);
	static float distance[SUN_WIDTH * SUN_HEIGHT];
	shadow_edges_pixels(&edges, SUN_WIDTH, SUN_HEIGHT, distance);
	uint32_t dark = 0, floor = 0;
	assert_true(truth.error == 0.0f);
	for (uint32_t i = 0; i < SUN_WIDTH * SUN_HEIGHT; i++) {
		const float *at = truth.position[i];
		if (at[1] > 0.5f) { /* the square itself */
			assert_true(truth.visible[i] == 1.0f);
			continue;
		}
		floor++;
		SHADE_PROOF_NEAR(at[0], 1.0 + ((double)(i % SUN_WIDTH) + 0.5 - SUN_WIDTH / 2) * (double)PIXEL, 0.0, 2e-4);
		SHADE_PROOF_NEAR(at[2], ((double)(i / SUN_WIDTH) + 0.5 - SUN_HEIGHT / 2) * (double)PIXEL, 0.0, 2e-4);
		assert_true(truth.normal[i][1] > 0.9999f);
		double outside = outside_shadow(at);
		dark += truth.visible[i] == 0.0f;
		if (fabs(outside) > 1e-4)
			assert_true(truth.visible[i] == (outside > 0.0 ? 1.0f : 0.0f));
		SHADE_PROOF_NEAR(distance[i], fabs(outside) / (double)PIXEL, 0.0, 0.75);
		SHADE_PROOF_NEAR(shadow_edges_distance(&edges, at), fabs(outside), 0.0, 0.75 * (double)PIXEL);
	}
	assert_in_range(floor, 5000, SUN_WIDTH * SUN_HEIGHT - 1);
	SHADE_PROOF_NEAR((float)dark * PIXEL * PIXEL, 1.0, 0.0, 0.02); /* the square's area */
	assert_in_range(edges.count, 60, 72);                          /* its outline, 4 m */
	shadow_edges_finish(&edges);
	shadow_truth_finish(&truth);
	stilb_gi_scene_destroy(gi);
}

/* A live shadow that is moved by three pixels is wrong in the middle of pixels up to two from those beside an edge, and
 * not up to one and a half; a pixel that is wrong alone is found, with its distance. */
static void wrong_pixels_are_near_edges(void **state)
{
	(void)state;
	stilb_gi_scene *gi;
	shadow_asked asked;
	shadow_truth truth = in_the_sun(&gi, &asked);
	shadow_edges edges = shadow_edges_find(&truth, 0.0f);
	static float live[SUN_WIDTH * SUN_HEIGHT], allowed[SUN_WIDTH * SUN_HEIGHT];
	for (uint32_t i = 0; i < SUN_WIDTH * SUN_HEIGHT; i++) {
		live[i] = truth.visible[i % SUN_WIDTH < 3 ? i : i - 3];
		allowed[i] = 2.01f * PIXEL;
	}
	shadow_compared near = shadow_compare(NULL, &asked, &truth, &edges, live, 0.5f, allowed);
	assert_int_equal(near.compared, SUN_WIDTH * SUN_HEIGHT);
	assert_in_range(near.wrong, 2 * 3 * 15, 2 * 3 * 17); /* both sides of the shadow, 16 pixels long */
	assert_true(near.outside == 0 && near.hidden == 0 && near.worst == 0.0f);
	for (uint32_t i = 0; i < SUN_WIDTH * SUN_HEIGHT; i++)
		allowed[i] = 1.5f * PIXEL;
	near = shadow_compare(gi, &asked, &truth, &edges, live, 0.5f, allowed);
	assert_in_range(near.outside, 16, near.wrong - 1);
	SHADE_PROOF_NEAR(near.worst, 2.0 / 1.5, 0.0, 0.01);
	assert_int_equal(shadow_compare(gi, &asked, &truth, &edges, live, 1.0f, allowed).wrong, 0);
	memcpy(live, truth.visible, sizeof live);
	uint32_t lone = 5 * SUN_WIDTH + 7;
	live[lone] = NAN;
	live[4 * SUN_WIDTH + 40] = live[6 * SUN_WIDTH + 40] = 0.0f; /* these are nearer */
	near = shadow_compare(gi, &asked, &truth, &edges, live, 0.5f, allowed);
	assert_true(near.wrong == 3 && near.outside == 3 && near.worst_x == 7 && near.worst_y == 5);
	SHADE_PROOF_NEAR(near.worst, outside_shadow(truth.position[lone]) / (1.5 * (double)PIXEL), 0.0, 0.5);
	shadow_edges_finish(&edges);
	shadow_truth_finish(&truth);
	stilb_gi_scene_destroy(gi);
}

/* Something that casts no shadow hides one side of the shadow's outline from the camera: where it ends is no edge, and
 * a pixel that is wrong close to the hidden one is told apart from one that is wrong without a reason. */
static void hidden_edges_are_found(void **state)
{
	(void)state;
	sheet sheets[3] = {square[0], square[1], {2.0f, 2.0f, 0.3f, 0.1f, 2.0f, STILB_SCENE_MODEL_CASTS_NO_SHADOW}};
	stilb_scene_camera camera = above(2.0f, 10.0f, SUN_ACROSS);
	shadow_asked asked = {&camera, SUN_WIDTH, SUN_HEIGHT, &sun, false};
	stilb_gi_scene *gi = traced(sheets, 3);
	shadow_truth truth = shadow_truth_trace(gi, &asked, pool);
	shadow_edges edges = shadow_edges_find(&truth, 0.0f);
	static float live[SUN_WIDTH * SUN_HEIGHT], allowed[SUN_WIDTH * SUN_HEIGHT];
	memcpy(live, truth.visible, sizeof live);
	uint32_t near = SUN_WIDTH * SUN_HEIGHT, row = SUN_HEIGHT / 2 + 5; /* z = 0.34 */
	for (uint32_t x = 0; x < SUN_WIDTH; x++) {
		uint32_t pixel = row * SUN_WIDTH + x;
		if (truth.position[pixel][1] < 0.5f && truth.position[pixel][0] > 1.7f && truth.position[pixel][0] < 2.0f)
			near = pixel; /* the last before the sheet */
	}
	assert_true(near < SUN_WIDTH * SUN_HEIGHT && truth.visible[near] == 0.0f);
	assert_true(truth.visible[near + 1] == 1.0f && truth.position[near + 1][1] > 1.5f);
	assert_true(shadow_edges_distance(&edges, truth.position[near]) > 0.3f);
	for (uint32_t i = 0; i < SUN_WIDTH * SUN_HEIGHT; i++)
		allowed[i] = 0.2f;
	live[near] = live[near - 4] = 1.0f;
	shadow_compared seen = shadow_compare(NULL, &asked, &truth, &edges, live, 0.5f, allowed);
	assert_true(seen.wrong == 2 && seen.outside == 2 && seen.hidden == 0);
	seen = shadow_compare(gi, &asked, &truth, &edges, live, 0.5f, allowed);
	assert_true(seen.wrong == 2 && seen.outside == 1 && seen.hidden == 1 && seen.worst_x == near % SUN_WIDTH - 4);
	shadow_edges_finish(&edges);
	shadow_truth_finish(&truth);
	stilb_gi_scene_destroy(gi);
}

/* ---- penumbrae --------------------------------------------------------------------------------------------------- */

#define WIDE 80u    /* pixels in a row across the edge, */
#define WIDTH 0.12f /* which is so many metres */
#define LAMP 5.0f   /* height of the lights, */
#define SIZE 0.1f   /* and their half size: far less, so that they are flat as seen from the floor */

/* The share of a disk that lies beyond a line at this distance from its middle, in radii; negative: less than half. */
static double beyond_line(double t)
{
	return t >= 1.0 ? 1.0 : t <= -1.0 ? 0.0 : 1.0 - (acos(t) - t * sqrt(1.0 - t * t)) / M_PI;
}

/* Under the edge x = 0 of a half plane at the height 1, which is above x < 0, lights stand over the edge. The line from
 * (x, 0) over the edge passes the light's middle, at LAMP, at the distance (LAMP - 1) x / sqrt(1 + x^2). */
static void penumbrae_are_as_wide_as_geometry_says(void **state)
{
	(void)state;
	static const sheet half[] = {{0, 0, 0, 40, 40, 0}, {-30, 1, 0, 30, 60, 0}};
	static const stilb_scene_light_kind kinds[] = {STILB_SCENE_LIGHT_SPHERE, STILB_SCENE_LIGHT_DISK,
	                                               STILB_SCENE_LIGHT_RECTANGLE, STILB_SCENE_LIGHT_POINT,
	                                               STILB_SCENE_LIGHT_SPOT};
	stilb_gi_scene *gi = traced(half, 2);
	stilb_scene_camera camera = above(0.0f, 0.5f, 2.0f * WIDTH / WIDE);
	for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++) {
		stilb_scene_light light = {.kind = kinds[k],
		                           .position = {0, LAMP, 0},
		                           .direction = {0, -1, 0},
		                           .intensity = {3, 2, 1},
		                           .cos_inner = 0.9f,
		                           .cos_outer = 0.8f,
		                           .radius = SIZE,
		                           .half_x = {SIZE, 0, 0},
		                           .half_y = {0, 0, SIZE}};
		for (int soft = 0; soft < 2; soft++) {
			shadow_asked asked = {&camera, WIDE, 2, &light, soft};
			shadow_truth truth = shadow_truth_trace(gi, &asked, pool);
			bool wide = soft && kinds[k] >= STILB_SCENE_LIGHT_SPHERE;
			double first = 1.0, last = -1.0, squares = 0.0;
			assert_true(wide ? truth.error > 0.0f && truth.error <= 1.0f / 255.0f : truth.error == 0.0f);
			for (uint32_t i = 0; i < 2 * WIDE; i++) {
				double x = (double)truth.position[i][0],
					   t = (double)(LAMP - 1.0f) * x / sqrt(1.0 + x * x) / (double)SIZE;
				double wanted =
					kinds[k] == STILB_SCENE_LIGHT_RECTANGLE ? fmin(fmax(0.5 + 0.5 * t, 0.0), 1.0) : beyond_line(t);
				if (!wide)
					wanted = x > 0.0;
				SHADE_PROOF_NEAR(truth.visible[i], wanted, 0.0, wide ? 4.0 / 255.0 : 0.0);
				squares += ((double)truth.visible[i] - wanted) * ((double)truth.visible[i] - wanted);
				if (truth.visible[i] > 0.0f && truth.visible[i] < 1.0f) {
					first = fmin(first, x);
					last = fmax(last, x);
				}
			}
			assert_true(sqrt(squares / (2 * WIDE)) < 1.0 / 255.0);
			/* From where the light begins to be seen to where all of it is: 2 SIZE / (LAMP - 1), 5 cm. Of the ends of a
			 * disk so little is seen that no ray may meet them. */
			if (wide)
				SHADE_PROOF_NEAR((float)(last - first), 2.0 * (double)SIZE / (double)(LAMP - 1.0f), 0.0,
				                 3.0 * (double)WIDTH / WIDE);
			shadow_truth_finish(&truth);
		}
	}
	stilb_gi_scene_destroy(gi);
}

/* A lamp so large that its parts light the floor at other angles: the share is that of the irradiance. Under the same
 * half plane, by a sum over the lamp. */
static void shares_are_of_irradiance(void **state)
{
	(void)state;
	static const sheet half[] = {{0, 0, 0, 40, 40, 0}, {-30, 1, 0, 30, 60, 0}};
	static const float middle[3] = {2, 3, 0}, half_side = 2;
	stilb_scene_light lamp = {.kind = STILB_SCENE_LIGHT_RECTANGLE,
	                          .position = {middle[0], middle[1], middle[2]},
	                          .direction = {0, -1, 0},
	                          .intensity = {3, 2, 1},
	                          .half_x = {half_side, 0, 0},
	                          .half_y = {0, 0, half_side}};
	stilb_gi_scene *gi = traced(half, 2);
	stilb_scene_camera camera = above(0.0f, 0.5f, 0.1f);
	shadow_asked asked = {&camera, 16, 1, &lamp, true};
	shadow_truth truth = shadow_truth_trace(gi, &asked, pool);
	for (uint32_t i = 0; i < 16; i++) {
		double all = 0.0, seen = 0.0, x = (double)truth.position[i][0], z = (double)truth.position[i][2];
		for (uint32_t k = 0; k < 200 * 200; k++) {
			double lx = (double)middle[0] + (double)half_side * (((double)(k % 200) + 0.5) / 100.0 - 1.0) - x;
			double lz = (double)half_side * (((double)(k / 200) + 0.5) / 100.0 - 1.0) - z, y = (double)middle[1];
			double square_distance = lx * lx + y * y + lz * lz, sent = y * y / (square_distance * square_distance);
			all += sent;
			seen += x + lx / y > 0.0 ? sent : 0.0;
		}
		SHADE_PROOF_NEAR(truth.visible[i], seen / all, 0.0, 4.0 / 255.0);
		assert_true(seen > 0.0 && truth.visible[i] > 0.0f);
	}
	assert_true(truth.visible[0] < 0.5f && truth.visible[15] > 0.99f);
	shadow_truth_finish(&truth);
	stilb_gi_scene_destroy(gi);
}

/* A lamp's ball, its light's face, is in the way of no ray to the lamp, whether its middle is asked or all of it. */
static void lamps_do_not_hide_themselves(void **state)
{
	(void)state;
	static const float grey[3] = {0.5f, 0.5f, 0.5f}, none[3] = {0};
	stilb_scene_light lamp = {
		.kind = STILB_SCENE_LIGHT_SPHERE, .position = {0, 2, 0}, .intensity = {1, 1, 1}, .radius = 0.5f};
	stilb_scene_material matt = stilb_scene_material_make(grey, none, 1.0f);
	stilb_scene_build *build = stilb_scene_build_begin();
	stilb_scene_mesh mesh[2];
	assert_int_equal(stilb_scene_mesh_plane(&mesh[0]), STILB_OK);
	assert_int_equal(stilb_scene_mesh_sphere(3, &mesh[1]), STILB_OK);
	uint32_t material = stilb_scene_build_material(build, &matt);
	for (int i = 0; i < 2; i++) {
		stilb_mat4 place = stilb_mat4_scale_translate(i == 0 ? 1.0f : 0.5f, 0.0f, i == 0 ? 0.0f : 2.0f, 0.0f);
		stilb_scene_build_part part = {stilb_scene_build_mesh(build, &mesh[i]), material};
		stilb_scene_build_model(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &place), &part, 1);
		stilb_scene_mesh_finish(&mesh[i]);
	}
	stilb_scene *scene;
	assert_int_equal(stilb_scene_build_end(build, &scene), STILB_OK);
	stilb_gi_scene *gi;
	stilb_gi_scene_desc desc = stilb_gi_scene_desc_default(pool);
	assert_int_equal(stilb_gi_scene_create(scene, &desc, &gi), STILB_OK);
	stilb_scene_destroy(scene);
	stilb_scene_camera camera = above(0.0f, 1.2f, 1.6f);
	for (int soft = 0; soft < 2; soft++) {
		shadow_asked asked = {&camera, 20, 20, &lamp, soft};
		shadow_truth truth = shadow_truth_trace(gi, &asked, pool);
		for (uint32_t i = 0; i < 400; i++)
			assert_true(truth.visible[i] == 1.0f);
		shadow_truth_finish(&truth);
	}
	stilb_gi_scene_destroy(gi);
}

/* No light would arrive: beyond a spot's cone, behind a disk or a rectangle, and from below the surface; and where
 * there is nothing. */
static void what_no_light_reaches_is_left_out(void **state)
{
	(void)state;
	static const sheet floor[] = {{0, 0, 0, 1, 1, 0}};
	stilb_gi_scene *gi = traced(floor, 1);
	stilb_scene_camera camera = above(0.0f, 10.0f, 4.0f);
	stilb_scene_light light = {.kind = STILB_SCENE_LIGHT_SPOT,
	                           .position = {0, 2, 0},
	                           .direction = {0, -1, 0},
	                           .intensity = {1, 1, 1},
	                           .cos_inner = 0.99f,
	                           .cos_outer = 0.9701425f, /* 0.5 m around */
	                           .radius = 0.1f,
	                           .half_x = {0.1f, 0, 0},
	                           .half_y = {0, 0, 0.1f}};
	for (int round = 0; round < 8; round++) {
		light.kind = round == 0   ? STILB_SCENE_LIGHT_SPOT
		             : round == 1 ? STILB_SCENE_LIGHT_POINT
		             : round < 5  ? STILB_SCENE_LIGHT_DISK
		                          : STILB_SCENE_LIGHT_RECTANGLE;
		light.position[1] = round == 1 ? -2.0f : 2.0f;
		light.direction[1] = round > 2 ? 1.0f : -1.0f; /* upwards */
		shadow_asked asked = {&camera, 40, 40, &light, round & 1};
		shadow_truth truth = shadow_truth_trace(gi, &asked, pool);
		uint32_t lit = 0, on_floor = 0;
		for (uint32_t i = 0; i < 1600; i++) {
			double x = 0.1 * ((double)(i % 40) - 19.5), z = 0.1 * ((double)(i / 40) - 19.5);
			bool here = fabs(x) < 1.0 && fabs(z) < 1.0;
			bool reached = here && (round == 0 ? hypot(x, z) < 0.5 : round == 2);
			on_floor += here;
			lit += !isnan(truth.visible[i]);
			assert_int_equal(!isnan(truth.visible[i]), reached);
			assert_true(!reached || truth.visible[i] == 1.0f);
		}
		assert_int_equal(on_floor, 400);
		assert_int_equal(lit > 0, round == 0 || round == 2);
		shadow_truth_finish(&truth);
	}
	stilb_gi_scene_destroy(gi);
}

/* ---- distances --------------------------------------------------------------------------------------------------- */

/* Against a search over all pairs, in pictures of random shadows with holes. */
static void distances_are_exact(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 5};
	for (uint32_t round = 0; round < 20; round++) {
		uint32_t width = 1 + round * 2, height = 31 - round, count = 0;
		static float visible[1600], distance[1600], position[1600][3], normal[1600][3];
		shadow_truth truth = {width, height, visible, position, normal, .eye = {0, 50, 0}};
		for (uint32_t i = 0; i < width * height; i++) {
			float u = shade_proof_uniform(&random);
			visible[i] = u < 0.1f ? NAN : u < 0.1f + 0.002f * (float)round ? 0.0f : 1.0f;
			memcpy(position[i], (float[3]){(float)(i % width), 0.0f, (float)(i / width)}, sizeof position[i]);
			memcpy(normal[i], (float[3]){0.0f, 1.0f, 0.0f}, sizeof normal[i]);
		}
		shadow_edges edges = shadow_edges_find(&truth, 0.5f);
		shadow_edges_pixels(&edges, width, height, distance);
		for (uint32_t i = 0; i < width * height; i++) {
			uint32_t x = i % width, y = i / width;
			double least = (double)INFINITY, metres = (double)INFINITY;
			count += x + 1 < width && visible[i] + visible[i + 1] == 1.0f;
			count += y + 1 < height && visible[i] + visible[i + width] == 1.0f;
			for (uint32_t k = 0; k < width * height; k++) {
				double kx = k % width, ky = k / width;
				if (k % width + 1 < width && visible[k] + visible[k + 1] == 1.0f) {
					least = fmin(least, hypot(kx + 0.5 - x, ky - y));
					metres = fmin(metres, hypot(fmax(fabs(kx + 0.5 - x) - 0.5, 0.0), ky - y));
				}
				if (k / width + 1 < height && visible[k] + visible[k + width] == 1.0f) {
					least = fmin(least, hypot(kx - x, ky + 0.5 - y));
					metres = fmin(metres, hypot(kx - x, fmax(fabs(ky + 0.5 - y) - 0.5, 0.0)));
				}
			}
			assert_true(distance[i] == (float)least);
			float away = shadow_edges_distance(&edges, position[i]);
			assert_true(away == (float)metres || fabs((double)away - metres) <= 1e-5);
		}
		assert_int_equal(edges.count, count);
		assert_true(round > 0 || count == 0);
		shadow_edges_finish(&edges);
	}
}

/* The same bits from any number of threads. */
static void workers_change_nothing(void **state)
{
	(void)state;
	stilb_scene_camera camera = above(0.0f, 3.0f, 4.0f);
	stilb_scene_light light = {
		.kind = STILB_SCENE_LIGHT_SPHERE, .position = {0.5f, 3, 0}, .intensity = {1, 1, 1}, .radius = 0.5f};
	shadow_asked asked = {&camera, 16, 12, &light, true};
	stilb_gi_scene *gi = traced(square, 2);
	shadow_truth first = {0};
	for (uint32_t workers = 0; workers < 4; workers += 3) {
		stilb_job_pool_desc desc = stilb_job_pool_desc_default();
		stilb_job_pool *other;
		desc.worker_count = workers;
		assert_int_equal(stilb_job_pool_create(&desc, &other), 0);
		shadow_truth truth = shadow_truth_trace(gi, &asked, other);
		stilb_job_pool_destroy(other);
		if (workers == 0) {
			first = truth;
			continue;
		}
		assert_true(first.error > 0.0f && first.error == truth.error);
		assert_memory_equal(first.visible, truth.visible, sizeof(float[16 * 12]));
		shadow_truth_finish(&truth);
	}
	shadow_truth_finish(&first);
	stilb_gi_scene_destroy(gi);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(edges_are_where_geometry_says),
		cmocka_unit_test(wrong_pixels_are_near_edges),
		cmocka_unit_test(hidden_edges_are_found),
		cmocka_unit_test(penumbrae_are_as_wide_as_geometry_says),
		cmocka_unit_test(shares_are_of_irradiance),
		cmocka_unit_test(lamps_do_not_hide_themselves),
		cmocka_unit_test(what_no_light_reaches_is_left_out),
		cmocka_unit_test(distances_are_exact),
		cmocka_unit_test(workers_change_nothing),
	};
	return cmocka_run_group_tests(tests, begin, end);
}
