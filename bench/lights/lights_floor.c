/* A floor under lamps that is cut at their bounds, so that few lights reach each piece. */
#include "bench/lights/lights_floor.h"

#include "geometry/geometry_lights.h"

#include <math.h>

#define LAMPS 18u
#define SIDE 12.0f   /* metres, of the floor */
#define HEIGHT 0.9f  /* metres, of the lamps */
#define REACH 3.0f   /* metres */
#define LEAST 0.3f   /* metres, of a piece */
#define ENOUGH 4u    /* lights of a model's own with STILB_RENDER_LIGHTING_COMBINED */
#define LAMPS_SEED 3 /* as in test_render_combined.c */

static stilb_geometry_pieces cut(const stilb_scene_mesh *floor, const stilb_sphere *lamps)
{
	stilb_geometry_lights_desc desc = {.lights = lamps, .light_count = LAMPS, .enough = ENOUGH, .least = LEAST};
	stilb_geometry_pieces pieces;
	if (stilb_geometry_cut_at_lights(floor, &desc, &pieces) != STILB_OK)
		bench_child_fail("%s", stilb_error_message());
	return pieces;
}

void lights_floor_measure(const bench_child *child)
{
	stilb_scene_mesh floor;
	stilb_sphere lamps[LAMPS];
	if (stilb_scene_mesh_plane(&floor) != STILB_OK)
		bench_child_fail("%s", stilb_error_message());
	for (uint32_t v = 0; v < floor.vertex_count; v++)
		for (int k = 0; k < 3; k++)
			floor.vertices[v].position[k] *= 0.5f * SIDE;
	for (uint32_t l = 0; l < LAMPS; l++)
		lamps[l] = (stilb_sphere){SIDE * (stilb_random_float(LAMPS_SEED, 2 * l) - 0.5f), HEIGHT,
		                          SIDE * (stilb_random_float(LAMPS_SEED, 2 * l + 1) - 0.5f), REACH};
	double best = (double)INFINITY;
	uint64_t end = bench_child_now_ns() + (uint64_t)(child->seconds * 1e9);
	stilb_geometry_pieces pieces = {0};
	do {
		stilb_geometry_pieces_finish(&pieces);
		uint64_t begin = bench_child_now_ns();
		pieces = cut(&floor, lamps);
		best = fmin(best, (double)(bench_child_now_ns() - begin));
	} while (bench_child_now_ns() < end);
	bench_child_metric("cut", best * 1e-3);
	bench_child_metric("triangles", (double)(pieces.triangles - floor.index_count / 3));
	bench_child_metric("draws", (double)(pieces.count - 1));
	bench_child_metric("reach", (double)pieces.most);
	stilb_geometry_pieces_finish(&pieces);
	stilb_scene_mesh_finish(&floor);
}
