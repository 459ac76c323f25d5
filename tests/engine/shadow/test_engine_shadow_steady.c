/* Shadows of a sun stand still while the camera moves, and change nowhere at once where one cascade gives way to the
 * next. A camera looks straight down on the straight edge of a shadow, along which texels of all maps lie in rows: what
 * changes along the edge is the cascades' doing alone. Pixels are about a seventh of the first cascade's texels. The
 * camera moves on by one of them a frame, so that each picture shows the points of the one before, beside. */
#include "shadow/shadow.h"
#include "support/shadow/shadow_stage.h"
#include "support/test.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define WIDTH 7680
#define HEIGHT 24
#define SLANT 1.0f /* half of the picture's width at a distance of 1 */
#define PART 7     /* pixels in a texel, about */
#define HIGH 0.9f  /* the camera's height, of where the first cascade ends */
#define ALONG 3.5f /* metres of the edge to each side of the camera; its ends are at 4 */
#define FRAMES 22  /* some texels of the first cascade */

/* What the test takes from the plan to see itself fail. */
static bool blends = true, snaps = true;
static uint32_t plans;
static float end; /* of the first cascade, metres from the camera */

stilb_result __real_stilb_shadow_plan_make(stilb_shadow_plan *plan, const stilb_shadow_desc *desc,
                                           const stilb_shadow_view *view, const stilb_scene_light *lights,
                                           uint32_t count);
stilb_result __wrap_stilb_shadow_plan_make(stilb_shadow_plan *plan, const stilb_shadow_desc *desc,
                                           const stilb_shadow_view *view, const stilb_scene_light *lights,
                                           uint32_t count);
stilb_result __wrap_stilb_shadow_plan_make(stilb_shadow_plan *plan, const stilb_shadow_desc *desc,
                                           const stilb_shadow_view *view, const stilb_scene_light *lights,
                                           uint32_t count)
{
	stilb_result result = __real_stilb_shadow_plan_make(plan, desc, view, lights, count);
	end = plan->map_count > 0 ? plan->maps[0].far : 0.0f;
	for (uint32_t m = 0; m < plan->map_count; m++) {
		plan->maps[m].blend *= blends ? 1.0f : 0.0f;
		for (int r = 0; r < 2 && !snaps; r++) /* by sevenths of a texel */
			plan->maps[m].view_projection.m[12 + r] += 2.0f / (float)desc->page * (float)(plans % PART) / PART;
	}
	plans++;
	return result;
}

/* The largest changes of the share of light: from a pixel to the next along the edge, and of a point from a frame to
 * the next; and how much shares differ along the edge at all. */
typedef struct changes {
	float beside, later, along;
	uint32_t edges; /* pixels that are partly lit */
} changes;

static const float *share_of(shadow_stage *stage)
{
	const float *share = shadow_stage_share(stage);
	for (uint32_t i = 0; i < WIDTH * HEIGHT; i++)
		assert_false(isnan(share[i]));
	return share;
}

static changes fly(stilb_engine_shadows shadows, int frames)
{
	stilb_scene_light sun = {
		.kind = STILB_SCENE_LIGHT_DIRECTIONAL, .intensity = {3, 3, 3}, .direction = {0.6f, -0.8f, 0.0f}};
	static float before[WIDTH * HEIGHT];
	changes found = {0};
	shadow_stage stage = shadow_stage_open(SHADOW_STAGE_BOARD, 0, &sun, shadows, WIDTH, HEIGHT);
	stilb_scene_camera *camera = &stage.scene->camera;
	*camera = (stilb_scene_camera){.position = {0.75f, 2.0f, 0.0f},
	                               .yaw = 1.57079633f,
	                               .pitch = -1.57079633f,
	                               .fov_y = 2.0f * atanf(SLANT * HEIGHT / WIDTH),
	                               .near_z = 0.05f,
	                               .far_z = 100.0f};
	share_of(&stage);
	assert_true(end > 0.0f);
	camera->position[1] = HIGH * end; /* so the cascade ends within the picture */
	float pixel = 2.0f * SLANT * camera->position[1] / WIDTH;
	stilb_scene_ray ray = stilb_scene_camera_ray(camera, WIDTH, HEIGHT, WIDTH, 0.5 * HEIGHT);
	float way = ray.direction[2] > 0.0 ? 1.0f : -1.0f;
	int half = (int)fminf(ALONG / pixel, WIDTH / 2 - 1), last = WIDTH / 2 + half;
	for (int f = 0; f < frames; f++) {
		camera->position[2] = way * pixel * (float)f;
		const float *share = share_of(&stage);
		for (int y = 0; y < HEIGHT; y++) {
			float least = 1.0f, most = 0.0f;
			for (int x = WIDTH / 2 - half; x < last; x++) {
				float here = share[y * WIDTH + x];
				least = fminf(least, here);
				most = fmaxf(most, here);
				found.edges += here > 0.1f && here < 0.9f;
				found.beside = fmaxf(found.beside, fabsf(here - share[y * WIDTH + x + 1]));
				if (f > 0)
					found.later = fmaxf(found.later, fabsf(here - before[y * WIDTH + x + 1]));
			}
			found.along = fmaxf(found.along, most - least);
		}
		memcpy(before, share, sizeof before);
	}
	shadow_stage_close(&stage);
	print_message("%u cascades, %.0f m: from pixel to pixel %.4f, from frame to frame %.4f; along the edge %.3f\n",
	              shadows.cascades, (double)shadows.distance, (double)found.beside, (double)found.later,
	              (double)found.along);
	assert_true(found.edges > 1000);
	return found;
}

static const stilb_engine_shadows settings[] = {
	{.kind = STILB_ENGINE_SHADOWS_MAP, .cascades = 3, .size = 1024},
	{.kind = STILB_ENGINE_SHADOWS_MAP, .cascades = 3, .size = 512},
	{.kind = STILB_ENGINE_SHADOWS_MAP, .cascades = 2, .size = 1024, .distance = 6.0f},
	{.kind = STILB_ENGINE_SHADOWS_MAP, .cascades = 1, .size = 1024, .distance = 2.0f},
};

/* Across the borders of cascades there is no jump, and with borders that blend nothing there is. */
static void borders_are_continuous(void **state)
{
	(void)state;
	for (int s = 0; s < 4; s++) {
		blends = true;
		changes smooth = fly(settings[s], 1);
		assert_true(smooth.along > 0.1f); /* the cascades differ */
		assert_true(smooth.beside <= 1.0f / 16.0f);
		blends = false;
		changes sharp = fly(settings[s], 1);
		blends = true;
		assert_true(sharp.beside > 1.0f / 16.0f);
	}
}

/* A camera that moves by sevenths of a texel: a point changes by what the blend changes by over a texel, of two
 * cascades at most. Maps that do not move by whole texels change more. */
static void flights_are_steady(void **state)
{
	(void)state;
	for (int s = 0; s < 4; s++) {
		float slope = 2.5f / (0.1f * (float)settings[s].size);
		changes steady = fly(settings[s], FRAMES);
		assert_true(steady.later <= slope);
		if (s != 0)
			continue;
		snaps = false;
		changes loose = fly(settings[s], FRAMES);
		snaps = true;
		assert_true(loose.later > slope);
		blends = false;
		changes sharp = fly(settings[s], FRAMES);
		blends = true;
		assert_true(sharp.later > slope);
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(borders_are_continuous),
		cmocka_unit_test(flights_are_steady),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
