#include "gi/film/gi_primary.h"

const gi_primary_kernels *gi_primary_kernels_for(stilb_isa isa)
{
#if defined(__x86_64__)
	if (isa == STILB_ISA_AVX512)
		return &gi_primary_kernels_avx512;
	if (isa == STILB_ISA_AVX2)
		return &gi_primary_kernels_avx2;
#endif
	(void)isa;
	return &gi_primary_kernels_scalar;
}

static_assert(GI_BATCH % 16 == 0, "packets are whole");

/* gi_sample_2d of all points. */
static void primary_numbers(const gi_view *view, const gi_camera *camera, const gi_point *points, uint32_t dimension,
                            uint32_t count, float *u, float *v)
{
	uint32_t done = 0;
	if (view->sampler.kind == STILB_GI_SAMPLER_SOBOL || view->sampler.kind == STILB_GI_SAMPLER_BLUE_NOISE) {
		done = count & ~15u;
		camera->kernels->sobol(points, dimension, done, u, v);
	}
	for (; done < count; done++) {
		stilb_vec2 pair = gi_sample_2d(&view->sampler, points[done], dimension);
		u[done] = pair[0];
		v[done] = pair[1];
	}
}

/* Those behind count are some place of the picture. */
static void primary_places(const gi_view *view, const gi_camera *camera, const uint16_t *x, const uint16_t *y,
                           const gi_point *points, uint32_t count, gi_primary_places *places)
{
	primary_numbers(view, camera, points, GI_DIMENSION_PIXEL, count, places->x, places->y);
	if (camera->lens.radius > 0.0f)
		primary_numbers(view, camera, points, GI_DIMENSION_LENS, count, places->lens_u, places->lens_v);
	if (view->settings.filter != STILB_GI_FILTER_BOX)
		for (uint32_t i = 0; i < count; i++) {
			stilb_vec2 offset = gi_filter_offset(view->settings.filter, (stilb_vec2){places->x[i], places->y[i]});
			places->x[i] = offset[0] + 0.5f;
			places->y[i] = offset[1] + 0.5f;
		}
	for (uint32_t i = 0; i < count; i++) {
		places->x[i] += (float)x[i];
		places->y[i] += (float)y[i];
	}
	for (uint32_t i = count; i % 16; i++)
		places->x[i] = places->y[i] = places->lens_u[i] = places->lens_v[i] = 0.0f;
}

static void primary_fetch_triangles(const stilb_gi_scene *scene, gi_primary_packet *packet)
{
	for (uint32_t lane = 0; lane < 16; lane++) {
		packet->parts[lane] = NULL;
		if (packet->rays.hit.part[lane] == GI_NO_PART)
			continue;
		const gi_part *part = &scene->parts[packet->rays.hit.part[lane]];
		packet->parts[lane] = part;
		packet->triangles[lane] = &part->triangles[packet->rays.hit.triangle[lane]];
		__builtin_prefetch(packet->triangles[lane]);
	}
}

static void primary_fetch_vertices(const gi_primary_packet *packet)
{
	for (uint32_t lane = 0; lane < 16; lane++)
		for (int corner = 0; packet->parts[lane] && corner < 3; corner++)
			__builtin_prefetch(&packet->parts[lane]->vertices[packet->triangles[lane]->vertex[corner]]);
}

/* The first `lanes` of the camera rays from first on, and what they hit. */
static void primary_hits(const gi_view *view, const gi_camera *camera, const gi_primary_places *places, uint32_t first,
                         uint32_t lanes, gi_primary_packet *packet)
{
	const gi_tracer *tracer = &view->scene->tracer;
	int valid[16] __attribute__((aligned(64)));
	for (uint32_t lane = 0; lane < 16; lane++)
		valid[lane] = lane < lanes ? -1 : 0;
	camera->kernels->rays(camera, places, first, &packet->rays);
	tracer->intersect16(tracer, valid, &packet->rays);
	primary_fetch_triangles(view->scene, packet);
}

/* Packets go through three stages: rays and hits, vertices, surfaces. Each asks the memory for what the next one reads, and
 * between two stages of one packet comes a stage of another: by then it is there. */
void gi_primary_trace(const gi_view *view, const gi_camera *camera, const uint16_t *x, const uint16_t *y,
                      const gi_point *points, uint32_t count, gi_primary *out)
{
	gi_primary_places places;
	gi_primary_packet packets[3];
	uint32_t packet_count = (count + 15) / 16;
	primary_places(view, camera, x, y, points, count, &places);
	for (uint32_t k = 0; k < packet_count + 2; k++) {
		if (k < packet_count)
			primary_hits(view, camera, &places, 16 * k, count - 16 * k, &packets[k % 3]);
		if (k >= 1 && k - 1 < packet_count)
			primary_fetch_vertices(&packets[(k - 1) % 3]);
		if (k >= 2)
			camera->kernels->surfaces(view->scene, camera, &packets[(k - 2) % 3], 16 * (k - 2), out);
	}
}
