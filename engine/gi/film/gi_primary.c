#include "gi/film/gi_primary.h"

#include "gi/trace/gi_cover.h"

#include <string.h>

const gi_primary_kernels *gi_primary_kernels_for(stilb_isa isa)
{
	STILB_ASSERT(isa < STILB_ISA_COUNT && isa <= stilb_cpu_widest_isa());
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

/* The two random numbers of a dimension (gi_sample_2d) for all samples: Sobol points by the kernel, in whole packets of
 * sixteen, all others one by one. */
static void primary_numbers(const gi_primary_kernels *kernels, const gi_sampler *sampler,
                            const gi_primary_samples *samples, uint32_t dimension, float *u, float *v)
{
	STILB_ASSERT(dimension % 2 == 0);
	uint32_t done = 0;
	if (sampler->kind == STILB_GI_SAMPLER_SOBOL || sampler->kind == STILB_GI_SAMPLER_BLUE_NOISE) {
		done = samples->count & ~15u;
		kernels->sobol(samples->points, dimension, done, u, v);
	}
	for (; done < samples->count; done++) {
		stilb_vec2 pair = gi_sample_2d(sampler, samples->points[done], dimension);
		u[done] = pair[0];
		v[done] = pair[1];
	}
}

/* Positions in the picture of all samples, in pixels. Unused lanes of the last packet get the picture's corner. */
static void primary_places(const gi_primary_kernels *kernels, const gi_view *view, bool lens,
                           const gi_primary_samples *samples, gi_primary_places *places)
{
	uint32_t count = samples->count;
	primary_numbers(kernels, &view->sampler, samples, GI_DIMENSION_PIXEL, places->x, places->y);
	if (lens)
		primary_numbers(kernels, &view->sampler, samples, GI_DIMENSION_LENS, places->lens_u, places->lens_v);
	if (view->scene->blends && view->settings.integrator == STILB_GI_INTEGRATOR_CHANNEL) {
		for (uint32_t i = 0; i < GI_BATCH; i++)
			places->chance[i] = GI_CHANCE_ALL;
	} else if (view->scene->blends) {
		float unused[GI_BATCH];
		primary_numbers(kernels, &view->sampler, samples, GI_DIMENSION_SEEN, places->chance, unused);
	}
	if (view->settings.filter != STILB_GI_FILTER_BOX)
		for (uint32_t i = 0; i < count; i++) {
			stilb_vec2 offset = gi_filter_offset(view->settings.filter, (stilb_vec2){places->x[i], places->y[i]});
			places->x[i] = offset[0] + 0.5f;
			places->y[i] = offset[1] + 0.5f;
		}
	for (uint32_t i = 0; i < count; i++) {
		places->x[i] += (float)samples->x[i];
		places->y[i] += (float)samples->y[i];
	}
	for (uint32_t i = count; i % 16; i++)
		places->x[i] = places->y[i] = places->lens_u[i] = places->lens_v[i] = places->chance[i] = 0.0f;
}

static void primary_fetch_triangles(const stilb_gi_scene *scene, gi_primary_packet *packet)
{
	for (uint32_t lane = 0; lane < 16; lane++) {
		packet->parts[lane] = NULL;
		if (packet->rays.hit.part[lane] == GI_NO_PART)
			continue;
		STILB_ASSERT(packet->rays.hit.part[lane] < scene->part_count);
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

/* Makes the camera rays first .. first + 15 and finds what they hit. lanes: how many of them belong to samples, the
 * others being padding; more than sixteen count as sixteen. */
static void primary_hits(const gi_primary_kernels *kernels, const stilb_gi_scene *scene, const gi_camera *camera,
                         const gi_primary_places *places, uint32_t first, uint32_t lanes, gi_primary_packet *packet)
{
	const gi_tracer *tracer = &scene->tracer;
	int valid[16] __attribute__((aligned(64)));
	for (uint32_t lane = 0; lane < 16; lane++)
		valid[lane] = lane < lanes ? -1 : 0;
	kernels->rays(camera, places, first, &packet->rays);
	if (scene->blends)
		memcpy(packet->rays.ray.time, places->chance + first, sizeof packet->rays.ray.time);
	tracer->intersect16(tracer, valid, &packet->rays);
	primary_fetch_triangles(scene, packet);
}

/* Packets of sixteen go through three stages: rays and hits, vertices, surfaces. Each stage prefetches what the next
 * one reads, and between two stages of one packet runs a stage of another, so that the data has arrived when it is
 * needed. */
void gi_primary_trace(const gi_primary_kernels *kernels, const gi_view *view, const gi_camera *camera,
                      const gi_primary_samples *samples, gi_primary *out)
{
	STILB_ASSERT(samples->count <= GI_BATCH);
	STILB_ASSERT(samples->count == 0 || (samples->x && samples->y && samples->points));
	gi_primary_places places;
	gi_primary_packet packets[3];
	uint32_t packet_count = (samples->count + 15) / 16;
	primary_places(kernels, view, camera->lens.radius > 0.0f, samples, &places);
	for (uint32_t k = 0; k < packet_count + 2; k++) {
		if (k < packet_count)
			primary_hits(kernels, view->scene, camera, &places, 16 * k, samples->count - 16 * k, &packets[k % 3]);
		if (k >= 1 && k - 1 < packet_count)
			primary_fetch_vertices(&packets[(k - 1) % 3]);
		if (k >= 2)
			kernels->surfaces(view->scene, camera, &packets[(k - 2) % 3], 16 * (k - 2), out);
	}
}
