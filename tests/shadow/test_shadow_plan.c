/* What shadow maps see and where they lie: cascades hold what they promise and stay at whole texels, maps of lamps hold
 * all directions, nothing overlaps, and what has no room is counted. By random views and lights, in double. */
#include "shadow/shadow.h"
#include "support/test.h"

#include <math.h>
#include <string.h>

#define RANDOM_VIEWS 200

static uint64_t seed = 7;

/* Between low and high. */
static double uniform(double low, double high)
{
	seed = seed * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
	return low + (high - low) * (double)(seed >> 11) * 0x1p-53;
}

static void direction(float out[3])
{
	double z = uniform(-1.0, 1.0), angle = uniform(0.0, 6.2831853), r = sqrt(1.0 - z * z);
	out[0] = (float)(r * cos(angle));
	out[1] = (float)z;
	out[2] = (float)(r * sin(angle));
}

/* A camera somewhere that looks somewhere. */
static stilb_shadow_view view_somewhere(void)
{
	stilb_shadow_view view = {.height = 360};
	for (int i = 0; i < 3; i++)
		view.camera_position[i] = (float)uniform(-20.0, 20.0);
	stilb_mat4 turn =
		stilb_mat4_view(stilb_vec3_make(view.camera_position[0], view.camera_position[1], view.camera_position[2]),
	                    (float)uniform(0.0, 6.28), (float)uniform(-1.4, 1.4));
	view.view_projection = stilb_mat4_multiply(
		stilb_mat4_perspective((float)uniform(0.4, 1.5), (float)uniform(0.5, 2.0), 0.1f, 1000.0f), turn);
	view.bounds = (stilb_sphere){(float)uniform(-9.0, 9.0), 1.0f, 2.0f, (float)uniform(1.0, 60.0)};
	return view;
}

static stilb_scene_light sun(void)
{
	stilb_scene_light light = {.kind = STILB_SCENE_LIGHT_DIRECTIONAL, .intensity = {1.0f, 1.0f, 1.0f}};
	direction(light.direction);
	return light;
}

static stilb_scene_light lamp(stilb_scene_light_kind kind)
{
	stilb_scene_light light = {.kind = kind,
	                           .intensity = {1.0f, 1.0f, 1.0f},
	                           .cos_inner = 0.95f,
	                           .cos_outer = (float)uniform(0.55, 0.95),
	                           .radius = 0.1f,
	                           .half_x = {0.1f, 0.0f, 0.0f},
	                           .half_y = {0.0f, 0.1f, 0.0f},
	                           .falloff = STILB_SCENE_LIGHT_WINDOWED,
	                           .reach = (float)uniform(1.0, 10.0)};
	direction(light.direction);
	for (int i = 0; i < 3; i++)
		light.position[i] = (float)uniform(-10.0, 10.0);
	return light;
}

/* Where a map has a point: texels of the page, depth; at[3] is w. */
static void place_of(const stilb_shadow_map *map, const double p[3], double at[4])
{
	const float *m = map->view_projection.m;
	double clip[4];
	for (int r = 0; r < 4; r++)
		clip[r] = (double)m[r] * p[0] + (double)m[4 + r] * p[1] + (double)m[8 + r] * p[2] + (double)m[12 + r];
	for (int i = 0; i < 2; i++)
		at[i] = map->area[i] + (0.5 + 0.5 * clip[i] / clip[3]) * map->area[2 + i];
	at[2] = clip[2] / clip[3];
	at[3] = clip[3];
}

/* Texels from a place to the nearest side of the map's area; negative outside. */
static double inside(const stilb_shadow_map *map, const double at[4])
{
	double least = HUGE_VAL;
	for (int i = 0; i < 2; i++)
		least = fmin(least, fmin(at[i] - map->area[i], map->area[i] + map->area[2 + i] - at[i]));
	return least;
}

static void plan_of(stilb_shadow_plan *plan, const stilb_shadow_desc *desc, const stilb_shadow_view *view,
                    const stilb_scene_light *lights, uint32_t count)
{
	assert_int_equal(stilb_shadow_plan_make(plan, desc, view, lights, count), STILB_OK);
	for (uint32_t a = 0; a < plan->map_count; a++) { /* in its page, and nobody else's */
		const stilb_shadow_map *one = &plan->maps[a];
		assert_true(one->page < plan->page_count && plan->page_count <= desc->pages);
		assert_true(one->area[0] + one->area[2] <= desc->page && one->area[1] + one->area[3] <= desc->page);
		assert_true(one->area[2] >= STILB_SHADOW_MIN_SIZE && one->area[2] == one->area[3]);
		for (uint32_t b = 0; b < a; b++) {
			const stilb_shadow_map *other = &plan->maps[b];
			bool apart = one->page != other->page || one->area[0] >= other->area[0] + other->area[2] ||
			             other->area[0] >= one->area[0] + one->area[2] ||
			             one->area[1] >= other->area[1] + other->area[3] ||
			             other->area[1] >= one->area[1] + one->area[3];
			assert_true(apart);
		}
	}
	for (uint32_t l = 0; l < count; l++)
		for (uint32_t m = 0; m < plan->lights[l].count; m++)
			assert_int_equal(plan->maps[plan->lights[l].first + m].light, l);
}

/* A point that the camera sees, so far ahead. */
static void seen_point(const stilb_shadow_view *view, double ahead, double p[3])
{
	stilb_mat4 back = stilb_mat4_inverse(&view->view_projection);
	const float *m = view->view_projection.m;
	/* Depth of clip space at that w: rows 2 and 3 are the same direction. */
	double z = 0.0, w = 0.0, out[4];
	for (int c = 0; c < 3; c++) {
		z += (double)m[4 * c + 2] * (double)m[4 * c + 3];
		w += (double)m[4 * c + 3] * (double)m[4 * c + 3];
	}
	double depth = z / w * ahead + (double)m[14] - z / w * (double)m[15];
	double clip[4] = {ahead * uniform(-1.0, 1.0), ahead * uniform(-1.0, 1.0), depth, ahead};
	for (int r = 0; r < 4; r++) {
		out[r] = 0.0;
		for (int c = 0; c < 4; c++)
			out[r] += (double)back.m[4 * c + r] * clip[c];
	}
	for (int i = 0; i < 3; i++)
		p[i] = out[i] / out[3];
}

/* The last cascade holds the whole scene. With a distance each holds what is seen nearer than its end, beyond where it
 * gives way; all have what casts in front of them. */
static void cascades_hold_what_they_promise(void **state)
{
	(void)state;
	stilb_shadow_plan plan = {0};
	for (int v = 0; v < RANDOM_VIEWS; v++) {
		stilb_shadow_view view = view_somewhere();
		stilb_shadow_desc desc = {.page = 256, .pages = 8, .maps = 8, .cascades = 1 + v % 4, .filter = 1 + v % 3};
		stilb_scene_light light = sun();
		plan_of(&plan, &desc, &view, &light, 1);
		assert_int_equal(plan.map_count, desc.cascades);
		const stilb_shadow_map *last = &plan.maps[desc.cascades - 1];
		assert_true(last->blend == 0.0f);
		for (int p = 0; p < 50; p++) {
			float away[3];
			double point[3], at[4], radius = (double)view.bounds.radius * uniform(0.0, 1.0);
			direction(away);
			const double center[3] = {(double)view.bounds.x, (double)view.bounds.y, (double)view.bounds.z};
			for (int i = 0; i < 3; i++)
				point[i] = center[i] + radius * (double)away[i];
			place_of(last, point, at);
			assert_true(inside(last, at) >= desc.filter && at[2] >= 0.0 && at[2] <= 1.0);
		}
		desc.distance = (float)uniform(1.0, 100.0);
		plan_of(&plan, &desc, &view, &light, 1);
		last = &plan.maps[desc.cascades - 1];
		assert_true(last->blend > 0.0f);
		for (int p = 0; p < 50; p++) {
			double point[3], at[4];
			seen_point(&view, uniform(0.11, (double)desc.distance), point);
			double least = -HUGE_VAL;
			for (uint32_t c = 0; c < desc.cascades; c++) {
				place_of(&plan.maps[c], point, at);
				least = fmax(least, inside(&plan.maps[c], at) - desc.filter - (double)plan.maps[c].blend);
			}
			assert_true(least >= -0.01); /* one of them has it all */
		}
	}
	stilb_shadow_plan_finish(&plan);
}

/* A parallel view: x and y within half a size, and depth from `behind` metres before the camera to as many past it. */
static stilb_shadow_view view_parallel(double half, double behind)
{
	stilb_shadow_view view = view_somewhere();
	const float *p = view.camera_position;
	stilb_mat4 turn =
		stilb_mat4_view(stilb_vec3_make(p[0], p[1], p[2]), (float)uniform(0.0, 6.28), (float)uniform(-1.4, 1.4));
	stilb_mat4 lens = {{0}};
	lens.m[0] = (float)(1.0 / half);
	lens.m[5] = (float)(-1.0 / half);
	lens.m[10] = (float)(0.5 / behind);
	lens.m[14] = 0.5f;
	lens.m[15] = 1.0f;
	view.view_projection = stilb_mat4_multiply(lens, turn);
	return view;
}

/* What a parallel view sees nearer than the distance is in one of its cascades, before and behind the camera, and each
 * is larger than the one before; without a distance the last one holds the whole scene. */
static void parallel_views_have_cascades(void **state)
{
	(void)state;
	stilb_shadow_plan plan = {0};
	for (int v = 0; v < RANDOM_VIEWS; v++) {
		double behind = uniform(5.0, 60.0);
		stilb_shadow_view view = view_parallel(uniform(1.0, 20.0), behind);
		stilb_shadow_desc desc = {.page = 256, .pages = 8, .maps = 8, .cascades = 3, .filter = 1 + v % 3};
		stilb_scene_light light = sun();
		desc.distance = v % 4 == 0 ? 0.0f : (float)uniform(5.0, 100.0);
		plan_of(&plan, &desc, &view, &light, 1);
		assert_true(plan.maps[2].far == desc.distance);
		stilb_mat4 back = stilb_mat4_inverse(&view.view_projection);
		for (int p = 0; p < 50; p++) {
			double clip[4] = {uniform(-1.0, 1.0), uniform(-1.0, 1.0), uniform(0.0, 1.0), 1.0}, point[3], at[4],
				   away = 0.0;
			for (int i = 0; i < 3; i++) {
				point[i] = 0.0;
				for (int c = 0; c < 4; c++)
					point[i] += (double)back.m[4 * c + i] * clip[c];
				away += pow(point[i] - (double)view.camera_position[i], 2.0);
			}
			for (uint32_t c = 0; c < 3; c++) {
				const stilb_shadow_map *map = &plan.maps[c];
				place_of(map, point, at);
				if (map->far > 0.0f && sqrt(away) < (double)map->far)
					assert_true(inside(map, at) - desc.filter - (double)map->blend >= -0.01);
				assert_true(map->caster_count == 0);
			}
		}
		for (uint32_t c = 1; c < 3; c++)
			assert_true(plan.maps[c].far == 0.0f || plan.maps[c].far > plan.maps[c - 1].far);
	}
	stilb_shadow_plan_finish(&plan);
}

/* A map of near things holds the sphere around them, by texels of few sizes, and ends at the distance. Of nothing there
 * is none, and nothing is counted. */
static void near_things_have_a_map(void **state)
{
	(void)state;
	stilb_shadow_plan plan = {0};
	for (int v = 0; v < RANDOM_VIEWS; v++) {
		stilb_shadow_view view = view_somewhere();
		stilb_shadow_desc desc = {.page = 256, .pages = 8, .maps = 8, .cascades = 1, .filter = 1 + v % 3};
		stilb_scene_light light = sun();
		desc.objects = true;
		desc.distance = (float)uniform(1.0, 100.0);
		plan_of(&plan, &desc, &view, &light, 1);
		assert_true(plan.map_count == 0 && plan.left_out == 0);
		view.near =
			(stilb_sphere){(float)uniform(-9.0, 9.0), (float)uniform(-1.0, 1.0), 2.0f, (float)uniform(0.01, 30.0)};
		plan_of(&plan, &desc, &view, &light, 1);
		const stilb_shadow_map *map = &plan.maps[0];
		assert_true(plan.map_count == 1 && map->far == desc.distance && map->blend > 0.0f && map->caster_count == 0);
		for (int p = 0; p < 50; p++) {
			float away[3];
			double point[3], at[4];
			direction(away);
			const double center[3] = {(double)view.near.x, (double)view.near.y, (double)view.near.z};
			for (int i = 0; i < 3; i++)
				point[i] = center[i] + (double)view.near.radius * (double)away[i];
			place_of(map, point, at);
			assert_true(inside(map, at) >= desc.filter + (double)map->blend - 0.01);
		}
		for (int p = 0; p < 50; p++) { /* also what lies far behind them gets their shadow */
			float away[3];
			double point[3], at[4];
			direction(away);
			const double center[3] = {(double)view.bounds.x, (double)view.bounds.y, (double)view.bounds.z};
			for (int i = 0; i < 3; i++)
				point[i] = center[i] + (double)view.bounds.radius * (double)away[i];
			place_of(map, point, at);
			assert_true(at[2] >= 0.0 && at[2] <= 1.0);
		}
		const float *m = map->view_projection.m;
		double radius = 2.0 / sqrt((double)(m[0] * m[0] + m[4] * m[4] + m[8] * m[8])) *
		                (256.0 - 2.0 * (desc.filter + (double)map->blend) - 2.0) / 512.0;
		double steps = log(radius) / log(1.25);
		assert_true(fabs(steps - round(steps)) < 1e-3);
		assert_true(radius >= 0.999 * (double)view.near.radius && radius <= 1.251 * (double)view.near.radius);
	}
	stilb_shadow_plan_finish(&plan);
}

static void look(stilb_shadow_view *view, const double at[3], double yaw, double pitch, double fov)
{
	for (int i = 0; i < 3; i++)
		view->camera_position[i] = (float)at[i];
	stilb_mat4 turn =
		stilb_mat4_view(stilb_vec3_make((float)at[0], (float)at[1], (float)at[2]), (float)yaw, (float)pitch);
	view->view_projection = stilb_mat4_multiply(stilb_mat4_perspective((float)fov, 1.6f, 0.1f, 1000.0f), turn);
}

/* Where a cascade of 256 texels begins to give way, metres from the camera. */
static double gives_way(const stilb_shadow_map *map)
{
	const float *m = map->view_projection.m;
	double texel = 2.0 / (256.0 * sqrt((double)(m[0] * m[0] + m[4] * m[4] + m[8] * m[8])));
	return (double)map->far - 0.5 * (double)map->blend * texel;
}

/* A map that follows the camera holds what is seen from where the one before gives way to its own end, and what it has
 * no casters of throws no shadow there. */
static void casters_are_there(const stilb_shadow_map *map, uint32_t filter, double first, const stilb_shadow_view *view,
                              const float along[3])
{
	for (int p = 0; p < 30; p++) {
		double point[3], at[4], square = 0.0, before = uniform(0.0, 80.0), radius = uniform(0.0, 5.0);
		float away[3];
		seen_point(view, uniform(0.11, (double)map->far), point);
		for (int i = 0; i < 3; i++)
			square += (point[i] - (double)view->camera_position[i]) * (point[i] - (double)view->camera_position[i]);
		if (square > (double)map->far * (double)map->far || square < first * first)
			continue;
		place_of(map, point, at);
		assert_true(at[2] >= 0.0 && inside(map, at) - filter - (double)map->blend >= -0.01);
		direction(away);
		for (int i = 0; i < 3; i++)
			point[i] += radius * (double)away[i] - before * (double)along[i];
		assert_true(stilb_shadow_casters_have(
			map, (stilb_sphere){(float)point[0], (float)point[1], (float)point[2], (float)radius * 1.0001f}));
	}
}

static void casters_are_those_of_what_is_seen(void **state)
{
	(void)state;
	stilb_shadow_plan plan = {0}, next = {0};
	uint32_t out = 0, all = 0, holds = 0, ends = 0, still = 0;
	for (int v = 0; v < RANDOM_VIEWS; v++) {
		double at[3] = {uniform(-20.0, 20.0), uniform(-20.0, 20.0), uniform(-20.0, 20.0)}, yaw = uniform(0.0, 6.28);
		double pitch = uniform(-1.4, 1.4), fov = uniform(0.4, 1.5), step = uniform(0.0, 0.4);
		stilb_shadow_view view = view_somewhere();
		stilb_shadow_desc desc = {.page = 256, .pages = 8, .maps = 8, .cascades = 3, .filter = 1 + v % 3};
		stilb_scene_light light = sun();
		desc.distance = v % 2 == 0 ? 0.0f : (float)uniform(5.0, 100.0);
		look(&view, at, yaw, pitch, fov);
		plan_of(&plan, &desc, &view, &light, 1);
		assert_true(plan.maps[2].far == desc.distance);
		stilb_shadow_view turned = view;
		at[0] += step;
		look(&turned, at, yaw + step, pitch, fov);
		plan_of(&next, &desc, &turned, &light, 1);
		for (uint32_t c = 0; c < 3; c++) {
			const stilb_shadow_map *map = &plan.maps[c];
			assert_true((map->far > 0.0f) == (map->blend > 0.0f));
			if (map->far == 0.0f) {
				assert_int_equal(map->caster_count, 0);
				continue;
			}
			casters_are_there(map, desc.filter, c > 0 ? gives_way(map - 1) : 0.0, &view, light.direction);
			assert_true(stilb_shadow_casters_hold(map, map, &view));
			for (int p = 0; p < 20; p++) {
				stilb_sphere sphere = {(float)uniform(-60.0, 60.0), (float)uniform(-60.0, 60.0),
				                       (float)uniform(-60.0, 60.0), 1.0f};
				out += !stilb_shadow_casters_have(map, sphere);
				all++;
			}
			stilb_shadow_map moved = next.maps[c];
			bool enough = stilb_shadow_casters_hold(map, &moved, &turned);
			memcpy(moved.casters, map->casters, sizeof moved.casters);
			moved.caster_count = map->caster_count;
			if (enough)
				casters_are_there(&moved, desc.filter, c > 0 ? gives_way(&next.maps[c - 1]) : 0.0, &turned,
				                  light.direction);
			holds += enough;
			ends += !enough;
		}
		at[0] -= step - 1e-3; /* by a millimetre: hardly a map moves on */
		look(&turned, at, yaw, pitch, fov);
		plan_of(&next, &desc, &turned, &light, 1);
		still += memcmp(&plan.maps[1].view_projection, &next.maps[1].view_projection, sizeof(stilb_mat4)) == 0;
		view.others = true;
		plan_of(&next, &desc, &view, &light, 1);
		assert_int_equal(next.maps[0].caster_count, 0);
		assert_true(stilb_shadow_casters_hold(&next.maps[0], &plan.maps[0], &view));
		assert_true(plan.maps[0].caster_count == 0 || !stilb_shadow_casters_hold(&plan.maps[0], &next.maps[0], &view));
	}
	assert_true(out > all * 23 / 25); /* without the planes along edges some are fewer */
	assert_true(still > RANDOM_VIEWS * 3 / 4);
	assert_true(holds > 50 && ends > 50);
	stilb_shadow_plan_finish(&plan);
	stilb_shadow_plan_finish(&next);
}

/* Depth grows towards the light, in all maps. */
static void nearer_to_the_light_is_larger(void **state)
{
	(void)state;
	stilb_shadow_plan plan = {0};
	for (int v = 0; v < RANDOM_VIEWS; v++) {
		stilb_shadow_view view = view_somewhere();
		stilb_shadow_desc desc = {.page = 256, .pages = 8, .maps = 8, .cascades = 2, .filter = 1};
		stilb_scene_light light = v % 2 == 0 ? sun() : lamp(STILB_SCENE_LIGHT_SPOT);
		plan_of(&plan, &desc, &view, &light, 1);
		for (uint32_t m = 0; m < plan.map_count; m++) {
			double last = 2.0;
			for (int step = 0; step < 4; step++) {
				double p[3], at[4], along = ((double)step + 1.0) * 0.2;
				bool far = light.kind == STILB_SCENE_LIGHT_DIRECTIONAL;
				const float *from = far ? &view.bounds.x : light.position;
				for (int i = 0; i < 3; i++)
					p[i] = (double)from[i] + along * (double)light.direction[i];
				place_of(&plan.maps[m], p, at);
				assert_true(at[2] < last && at[3] > 0.0);
				last = at[2];
			}
		}
	}
	stilb_shadow_plan_finish(&plan);
}

/* A camera that moves on and turns: a point that stands still keeps its place within a texel. */
static void maps_move_by_whole_texels(void **state)
{
	(void)state;
	stilb_shadow_plan plan = {0};
	for (int v = 0; v < RANDOM_VIEWS; v++) {
		stilb_shadow_view view = view_somewhere();
		stilb_shadow_desc desc = {
			.page = 256, .pages = 8, .maps = 8, .cascades = 3, .filter = 1, .distance = v % 2 == 0 ? 0.0f : 30.0f};
		stilb_scene_light light = sun();
		double before[3][2];
		for (int step = 0; step < 8; step++) {
			const double point[3] = {0.3, 1.1, -0.7};
			plan_of(&plan, &desc, &view, &light, 1);
			for (uint32_t c = 0; c < 3; c++) {
				double at[4];
				place_of(&plan.maps[c], point, at);
				for (int i = 0; i < 2; i++) {
					double moved = at[i] - before[c][i];
					if (step > 0) /* floats of the matrix step by 2e-5 of a map 256 texels wide, times how far it is */
						assert_true(fabs(moved - floor(moved + 0.5)) < 0.02);
					before[c][i] = at[i];
				}
			}
			float move = 0.013f * (float)(step + 1);
			view.camera_position[0] += move;
			stilb_mat4 shift = stilb_mat4_scale_translate(1.0f, -move, 0.0f, 0.0f);
			view.view_projection = stilb_mat4_multiply(view.view_projection, shift);
		}
	}
	stilb_shadow_plan_finish(&plan);
}

/* Any direction from a lamp lies in one of its maps, with the filter's width around it; of a spot those of its cone. */
static void lamps_see_all_around(void **state)
{
	(void)state;
	static const stilb_scene_light_kind kinds[] = {STILB_SCENE_LIGHT_POINT, STILB_SCENE_LIGHT_SPOT,
	                                               STILB_SCENE_LIGHT_SPHERE, STILB_SCENE_LIGHT_DISK,
	                                               STILB_SCENE_LIGHT_RECTANGLE};
	stilb_shadow_plan plan = {0};
	int planned = 0;
	for (int v = 0; v < RANDOM_VIEWS; v++) {
		stilb_shadow_view view = view_somewhere();
		stilb_shadow_desc desc = {.page = 512, .pages = 8, .maps = 8, .cascades = 1, .filter = 1 + v % 3};
		stilb_scene_light light = lamp(kinds[v % 5]);
		plan_of(&plan, &desc, &view, &light, 1);
		assert_int_equal(plan.left_out, 0);
		if (plan.map_count == 0)
			continue;
		planned++;
		bool spot = light.kind == STILB_SCENE_LIGHT_SPOT;
		assert_int_equal(plan.map_count, spot ? 1 : 6);
		for (int p = 0; p < 100; p++) {
			float away[3], cosine = 0.0f;
			double point[3], at[4], most = -HUGE_VAL;
			direction(away);
			for (int i = 0; i < 3; i++) {
				cosine += away[i] * light.direction[i];
				point[i] = (double)light.position[i] + 0.5 * (double)light.reach * (double)away[i];
			}
			if (spot && cosine < light.cos_outer)
				continue;
			int axis = fabsf(away[0]) >= fabsf(away[1]) && fabsf(away[0]) >= fabsf(away[2]) ? 0
			           : fabsf(away[1]) >= fabsf(away[2])                                   ? 1
			                                                                                : 2;
			const stilb_shadow_map *map = &plan.maps[spot ? 0 : 2 * axis + (away[axis] < 0.0f)];
			place_of(map, point, at);
			most = inside(map, at);
			assert_true(at[3] > 0.0 && most >= (double)desc.filter + 1.0);
		}
	}
	assert_true(planned > RANDOM_VIEWS / 10);
	stilb_shadow_plan_finish(&plan);
}

/* In a large scene a lamp without an end casts shadows of what is near; a cone of no width has a map; and lamps that
 * the view does not see have one if others read it. */
static void lamps_are_of_any_kind(void **state)
{
	(void)state;
	stilb_shadow_plan plan = {0};
	stilb_shadow_view view = view_somewhere();
	stilb_shadow_desc desc = {.page = 512, .pages = 4, .maps = 8, .cascades = 1, .filter = 2};
	stilb_scene_light light = lamp(STILB_SCENE_LIGHT_SPOT);
	view.bounds.radius = 5000.0f;
	light.falloff = STILB_SCENE_LIGHT_PHYSICAL;
	light.cos_inner = light.cos_outer = 1.0f;
	view.others = true;
	plan_of(&plan, &desc, &view, &light, 1);
	assert_int_equal(plan.map_count, 1);
	for (int i = 0; i < 2; i++) {
		double p[3], at[4];
		for (int c = 0; c < 3; c++)
			p[c] = (double)light.position[c] + (i == 0 ? 0.02 : 4000.0) * (double)light.direction[c];
		place_of(&plan.maps[0], p, at);
		assert_true(at[2] > 0.0 && at[2] < 1.0 && inside(&plan.maps[0], at) > 200.0);
	}
	memcpy(view.camera_position, (float[3]){0.0f, 0.0f, 30.0f}, sizeof view.camera_position);
	view.view_projection = stilb_mat4_multiply(stilb_mat4_perspective(1.0f, 1.0f, 0.1f, 100.0f),
	                                           stilb_mat4_view(stilb_vec3_make(0, 0, 30), 0, 0));
	light = lamp(STILB_SCENE_LIGHT_POINT);
	light.position[2] = 60.0f; /* behind the camera */
	plan_of(&plan, &desc, &view, &light, 1);
	assert_int_equal(plan.map_count, 6);
	view.others = false;
	plan_of(&plan, &desc, &view, &light, 1);
	assert_int_equal(plan.map_count, 0);
	stilb_shadow_plan_finish(&plan);
}

/* What sends nothing to what is seen has no map; what has no room is counted, and what fits is smaller. */
static void rooms_end(void **state)
{
	(void)state;
	static stilb_scene_light lights[1000];
	stilb_shadow_plan plan = {0};
	stilb_shadow_view view = view_somewhere();
	stilb_shadow_desc desc = {.page = 512, .pages = 4, .maps = 6000, .cascades = 2, .filter = 2};
	view.view_projection = stilb_mat4_multiply(stilb_mat4_perspective(1.0f, 1.0f, 0.1f, 100.0f),
	                                           stilb_mat4_view(stilb_vec3_make(0, 0, 30), 0, 0));
	memcpy(view.camera_position, (float[3]){0.0f, 0.0f, 30.0f}, sizeof view.camera_position);
	view.bounds = (stilb_sphere){0.0f, 0.0f, 0.0f, 20.0f};
	for (int l = 0; l < 1000; l++)
		lights[l] = lamp(l % 2 == 0 ? STILB_SCENE_LIGHT_POINT : STILB_SCENE_LIGHT_SPOT);
	uint16_t sizes[40];
	desc.pages = 200;
	plan_of(&plan, &desc, &view, lights, 40);
	assert_int_equal(plan.halved, 0);
	assert_int_equal(plan.left_out, 0);
	for (int l = 0; l < 40; l++)
		sizes[l] = plan.maps[plan.lights[l].first].area[2];
	desc.pages = 4;
	plan_of(&plan, &desc, &view, lights, 40);
	assert_true(plan.halved > 0);
	assert_int_equal(plan.left_out, 0);
	for (int l = 0; l < 40; l++) {
		uint32_t smaller = (uint32_t)sizes[l] >> plan.halved, least = STILB_SHADOW_MIN_SIZE;
		assert_int_equal(plan.maps[plan.lights[l].first].area[2], smaller > least ? smaller : least);
	}
	plan_of(&plan, &desc, &view, lights, 1000);
	uint32_t with = 0;
	for (int l = 0; l < 1000; l++)
		with += plan.lights[l].count > 0;
	assert_true(plan.left_out > 0 && with > 0);
	assert_int_equal(with + plan.left_out, 1000);
	desc.maps = 9; /* a cube's and three spots', or two suns' */
	plan_of(&plan, &desc, &view, lights, 1000);
	assert_true(plan.map_count > 3 && plan.map_count <= 9);
	for (int l = 0; l < 3; l++)
		lights[l] = sun();
	plan_of(&plan, &desc, &view, lights, 3);
	assert_int_equal(plan.left_out, 1); /* four pages are two suns' */
	lights[0].use = STILB_SCENE_LIGHT_BAKED;
	memset(lights[1].intensity, 0, sizeof lights[1].intensity);
	lights[2] = lamp(STILB_SCENE_LIGHT_POINT);
	memcpy(lights[2].position, (float[3]){0.0f, 0.0f, 60.0f}, sizeof lights[2].position); /* behind the camera */
	plan_of(&plan, &desc, &view, lights, 3);
	assert_int_equal(plan.map_count, 0);
	assert_int_equal(plan.left_out, 0);
	plan_of(&plan, &desc, &view, NULL, 0);
	stilb_shadow_plan_finish(&plan);
	stilb_shadow_plan_finish(&plan);
	stilb_shadow_plan_finish(NULL);
}

/* The share of its shadow that a light has. */
static float left_of(const stilb_shadow_plan *plan, uint32_t light)
{
	const stilb_shadow_of *of = &plan->lights[light];
	assert_true(of->faded >= 0.0f && of->faded < 1.0f && (of->count > 0 || of->faded == 0.0f));
	assert_false(of->count > 0 && of->left_out);
	return of->count > 0 ? 1.0f - of->faded : 0.0f;
}

/* A camera flies along a row of more lamps than have room: none gets or loses its shadow in one frame, three quarters
 * of those that have maps have whole shadows, and all that have none are counted. */
static void shadows_go_bit_by_bit(void **state)
{
	(void)state;
	enum { LAMPS = 60, STEPS = 1000 };
	static stilb_scene_light lights[LAMPS];
	float before[LAMPS] = {0.0f}, first[LAMPS];
	stilb_shadow_plan plan = {0};
	stilb_shadow_desc desc = {.page = 512, .pages = 64, .maps = 60, .cascades = 1, .filter = 2, .fade = 16.0f};
	stilb_shadow_view view = {.height = 360, .bounds = {0.0f, 0.0f, 0.0f, 100.0f}, .others = true};
	uint32_t came = 0, went = 0;
	for (int l = 0; l < LAMPS; l++) {
		lights[l] = lamp(STILB_SCENE_LIGHT_POINT);
		lights[l].reach = 5.0f;
		memcpy(lights[l].position, (float[3]){3.0f * (float)l, 0.0f, -10.0f}, sizeof lights[l].position);
	}
	for (int step = 0; step < STEPS; step++) {
		float x = 60.0f + 0.02f * (float)step;
		view.view_projection = stilb_mat4_multiply(stilb_mat4_perspective(1.0f, 2.0f, 0.1f, 1000.0f),
		                                           stilb_mat4_view(stilb_vec3_make(x, 0.0f, 0.0f), 0.0f, 0.0f));
		memcpy(view.camera_position, (float[3]){x, 0.0f, 0.0f}, sizeof view.camera_position);
		plan_of(&plan, &desc, &view, lights, LAMPS);
		uint32_t with = 0, whole = 0, left = 0;
		for (uint32_t l = 0; l < LAMPS; l++) {
			float now = left_of(&plan, l);
			with += now > 0.0f;
			whole += now == 1.0f;
			left += plan.lights[l].left_out;
			if (step > 0 && fabsf(now - before[l]) > 0.02f)
				fail_msg("step %d, lamp %u: of its shadow %f is left, and was %f", step, l, (double)now,
				         (double)before[l]);
			first[l] = step == 0 ? now : first[l];
			came += step == STEPS - 1 && first[l] == 0.0f && now > 0.9f;
			went += step == STEPS - 1 && first[l] > 0.9f && now == 0.0f;
			before[l] = now;
		}
		assert_true(with >= 5 && 4 * whole >= 3 * with && with < LAMPS);
		assert_int_equal(left, plan.left_out);
		assert_int_equal(with + left + plan.faded, LAMPS);
	}
	assert_true(came >= 3 && went >= 3);
	stilb_shadow_plan_finish(&plan);
}

/* A lamp that goes away loses its shadow along the range that the desc says, and then has no maps; of lamps that look
 * the same size those that have room keep theirs. */
static void small_lamps_have_none(void **state)
{
	(void)state;
	static stilb_scene_light lights[20];
	stilb_shadow_plan plan = {0};
	stilb_shadow_desc desc = {.page = 512, .pages = 64, .maps = 60, .cascades = 1, .filter = 2, .fade = 16.0f};
	stilb_shadow_view view = {.height = 360, .bounds = {0.0f, 0.0f, 0.0f, 1000.0f}};
	view.view_projection = stilb_mat4_multiply(stilb_mat4_perspective(1.0f, 2.0f, 0.1f, 10000.0f),
	                                           stilb_mat4_view(stilb_vec3_make(0.0f, 0.0f, 0.0f), 0.0f, 0.0f));
	float up = 1.0f / tanf(0.5f), before = 1.0f;
	lights[0] = lamp(STILB_SCENE_LIGHT_POINT);
	lights[0].reach = 5.0f;
	for (int step = 1; step < 800; step++) {
		memcpy(lights[0].position, (float[3]){0.0f, 0.0f, (float)-step}, sizeof lights[0].position);
		plan_of(&plan, &desc, &view, lights, 1);
		float pixels = 5.0f * up * 360.0f / fmaxf((float)step, 5.0f), now = left_of(&plan, 0);
		assert_true(fabsf(now - fminf(fmaxf(pixels / 16.0f - 1.0f, 0.0f), 1.0f)) < 1e-4f);
		assert_true(now <= before && before - now < 0.02f);
		assert_int_equal(plan.map_count, now > 0.0f ? 6 : 0);
		assert_int_equal(plan.faded, now == 0.0f);
		assert_int_equal(plan.left_out, 0);
		before = now;
	}
	assert_true(before == 0.0f);
	for (int l = 0; l < 20; l++) {
		lights[l] = lights[0];
		memcpy(lights[l].position, (float[3]){0.0f, 0.0f, -20.0f}, sizeof lights[l].position);
	}
	plan_of(&plan, &desc, &view, lights, 20);
	for (uint32_t l = 0; l < 20; l++)
		assert_true(left_of(&plan, l) == (l < 10 ? 1.0f : 0.0f));
	assert_int_equal(plan.left_out, 10);
	stilb_shadow_plan_finish(&plan);
}

static bool lies_elsewhere(const stilb_shadow_plan *plan, const stilb_shadow_plan *before, uint32_t light)
{
	const stilb_shadow_of *now = &plan->lights[light], *then = &before->lights[light];
	bool same = now->count == then->count;
	for (uint32_t m = 0; m < now->count && same; m++) {
		const stilb_shadow_map *one = &plan->maps[now->first + m], *other = &before->maps[then->first + m];
		same = one->page == other->page && memcmp(one->area, other->area, sizeof one->area) == 0;
	}
	return now->count > 0 && then->count > 0 && !same;
}

/* Under a camera that walks, and then jumps back, few lamps have maps of another size or place in a step; at its end
 * all have a size near that of a plan without a past. */
static void lamps_keep_their_places(void **state)
{
	(void)state;
	enum { LAMPS = 48, STEPS = 80 };
	static stilb_scene_light lights[LAMPS];
	stilb_shadow_plan plan = {0}, other = {0}, fresh = {0}, *kept = &plan;
	stilb_shadow_desc desc = {.page = 1024, .pages = 64, .maps = 300, .cascades = 2, .filter = 2, .keep = true};
	stilb_shadow_map before[300];
	stilb_shadow_of of[LAMPS];
	uint32_t most = 0, most_fresh = 0, changes = 0;
	for (int l = 0; l < LAMPS; l++)
		lights[l] = lamp(l % 3 == 0 ? STILB_SCENE_LIGHT_POINT : STILB_SCENE_LIGHT_SPOT);
	lights[0] = sun();
	for (int step = 0; step < STEPS + 20; step++) {
		double at[3] = {0.0, 2.0, 60.0 - 0.5 * (step < STEPS ? step : 0)};
		stilb_shadow_view view = {.height = 720, .bounds = {0.0f, 0.0f, 0.0f, 40.0f}};
		look(&view, at, 0.0, 0.0, 1.0);
		plan_of(kept, &desc, &view, lights, LAMPS);
		assert_int_equal(kept->left_out, 0);
		desc.keep = false;
		stilb_shadow_plan last = {.maps = before, .lights = of};
		uint32_t moved = 0, moved_fresh = 0;
		if (step > 0)
			for (uint32_t l = 1; l < LAMPS; l++)
				moved += lies_elsewhere(kept, &last, l);
		memcpy(before, kept->maps, kept->map_count * sizeof *before);
		memcpy(of, kept->lights, sizeof of);
		plan_of(&other, &desc, &view, lights, LAMPS);
		for (uint32_t l = 1; l < LAMPS && step > 0; l++)
			moved_fresh += lies_elsewhere(&other, &fresh, l);
		stilb_shadow_plan swap = fresh;
		fresh = other;
		other = swap;
		desc.keep = true;
		most = moved > most ? moved : most;
		most_fresh = moved_fresh > most_fresh ? moved_fresh : most_fresh;
		changes += moved;
	}
	for (uint32_t l = 1; l < LAMPS; l++) {
		assert_int_equal(kept->lights[l].count, fresh.lights[l].count);
		if (kept->lights[l].count == 0)
			continue;
		uint32_t size = kept->maps[kept->lights[l].first].area[2], own = fresh.maps[fresh.lights[l].first].area[2];
		assert_true(size == own || size == 2 * own || 2 * size == own);
	}
	assert_true(most <= 4 && changes > 20);
	assert_true(most_fresh > 20);
	stilb_shadow_plan_finish(kept);
	stilb_shadow_plan_finish(&other);
	stilb_shadow_plan_finish(&fresh);
}

/* A figure close to a lamp that reaches far, near the camera: while there is room for its map, a texel covers at most
 * four pixels of the picture there. */
static void near_figures_have_fine_texels(void **state)
{
	(void)state;
	stilb_shadow_plan plan = {0};
	double worst = 0.0;
	for (int v = 0; v < RANDOM_VIEWS; v++) {
		stilb_shadow_view view = {.height = v % 2 ? 360 : 1080, .bounds = {0.0f, 0.0f, 0.0f, 40.0f}};
		stilb_shadow_desc desc = {.page = 4096, .pages = 8, .maps = 8, .cascades = 1, .filter = 2};
		stilb_scene_light light = lamp(v % 3 ? STILB_SCENE_LIGHT_POINT : STILB_SCENE_LIGHT_SPOT);
		double fov = uniform(0.5, 1.4), close = uniform(0.3, 2.0), before = uniform(1.5, 6.0), figure[3], at[3];
		light.reach = (float)uniform(8.0, 30.0);
		for (int i = 0; i < 3; i++) {
			figure[i] = (double)light.position[i] + close * (double)light.direction[i];
			at[i] = figure[i] + (i == 2 ? before : 0.0);
		}
		look(&view, at, 0.0, 0.0, fov);
		plan_of(&plan, &desc, &view, &light, 1);
		assert_true(plan.map_count > 0 && plan.halved == 0);
		double pixel = before * 2.0 * tan(0.5 * fov) / view.height, finest = HUGE_VAL;
		for (uint32_t m = 0; m < plan.map_count; m++) {
			double here[4], texels = 0.0;
			place_of(&plan.maps[m], figure, here);
			if (!(here[3] > 0.0) || inside(&plan.maps[m], here) < 0.0)
				continue;
			for (int axis = 0; axis < 3; axis++) { /* across the light's rays at least one axis lies well */
				double moved[3] = {figure[0], figure[1], figure[2]}, there[4];
				moved[axis] += 1e-3;
				place_of(&plan.maps[m], moved, there);
				texels = fmax(texels, hypot(there[0] - here[0], there[1] - here[1]));
			}
			finest = fmin(finest, 1e-3 / texels);
		}
		worst = fmax(worst, finest / pixel);
	}
	print_message("a texel covers %.2f pixels at most\n", worst);
	assert_true(worst > 0.0 && worst <= 4.0);
	stilb_shadow_plan_finish(&plan);
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(cascades_hold_what_they_promise),
		cmocka_unit_test(parallel_views_have_cascades),
		cmocka_unit_test(near_things_have_a_map),
		cmocka_unit_test(nearer_to_the_light_is_larger),
		cmocka_unit_test(maps_move_by_whole_texels),
		cmocka_unit_test(lamps_see_all_around),
		cmocka_unit_test(lamps_are_of_any_kind),
		cmocka_unit_test(rooms_end),
		cmocka_unit_test(shadows_go_bit_by_bit),
		cmocka_unit_test(small_lamps_have_none),
		cmocka_unit_test(casters_are_those_of_what_is_seen),
		cmocka_unit_test(lamps_keep_their_places),
		cmocka_unit_test(near_figures_have_fine_texels),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
