#include "gi/cache/gi_cache_strata.h"

#include "shading/shade_constants.h"

#include <stdlib.h>

/* ---- tables ------------------------------------------------------------------------------------------------------ */

/* The integral of tan(t) d(sin^2 t) for t from 0 to theta, the polar angle: tan(theta) over projected area, divided by
 * pi. A ring uses the mean of tan(theta) that follows, since the tan(theta) of a single ray has infinite variance. */
static double tangent_integral(double theta)
{
	return theta - sin(theta) * cos(theta);
}

static gi_cache_ring ring_make(uint32_t ring, uint32_t ring_count, double sector_angle)
{
	STILB_ASSERT(ring < ring_count);
	double inner = asin(sqrt((double)ring / ring_count));
	double outer = asin(sqrt((double)(ring + 1) / ring_count));
	double moved = cos(inner) * cos(inner) * sin(inner);
	return (gi_cache_ring){
		.tangent = (float)((tangent_integral(outer) - tangent_integral(inner)) * ring_count),
		.inner = (float)(moved * 2.0 * sin(0.5 * sector_angle)),
		.inner2 = (float)(4.0 * moved * sin(inner)),
		.sine_step = (float)(sin(outer) - sin(inner)),
	};
}

static gi_cache_sector sector_make(uint32_t sector, double angle)
{
	double edge = angle * sector;
	double middle = edge + 0.5 * angle;
	double even = 0.5 * angle;
	double odd = 0.5 * sin(angle);
	return (gi_cache_sector){
		.middle = {(float)cos(middle), (float)sin(middle)},
		.edge = {(float)cos(edge), (float)sin(edge)},
		.spread = {(float)(even + odd * cos(2.0 * middle)), (float)(odd * sin(2.0 * middle)),
	               (float)(even - odd * cos(2.0 * middle))},
	};
}

stilb_result gi_cache_strata_create(uint32_t rays, gi_cache_strata *strata)
{
	STILB_ASSERT(rays >= 16 && strata);
	uint32_t ring_count = (uint32_t)sqrt(rays / (double)SHADE_PI);
	uint32_t sector_count = rays / ring_count;
	*strata = (gi_cache_strata){.ring_count = ring_count,
	                            .sector_count = sector_count,
	                            .rings = malloc(ring_count * sizeof(gi_cache_ring)),
	                            .sectors = malloc(sector_count * sizeof(gi_cache_sector))};
	if (!strata->rings || !strata->sectors) {
		gi_cache_strata_destroy(strata);
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for %u gather rays; take fewer", rays);
	}
	double angle = 2.0 * M_PI / sector_count;
	for (uint32_t i = 0; i < ring_count; i++)
		strata->rings[i] = ring_make(i, ring_count, angle);
	for (uint32_t i = 0; i < sector_count; i++)
		strata->sectors[i] = sector_make(i, angle);
	return STILB_OK;
}

void gi_cache_strata_destroy(gi_cache_strata *strata)
{
	free(strata->rings);
	free(strata->sectors);
	*strata = (gi_cache_strata){0};
}

uint32_t gi_cache_strata_cells(const gi_cache_strata *strata)
{
	return strata->ring_count * strata->sector_count;
}

stilb_vec3 gi_cache_strata_direction(const gi_cache_strata *strata, uint32_t cell, stilb_vec2 u)
{
	STILB_ASSERT(cell < gi_cache_strata_cells(strata));
	STILB_ASSERT(u[0] >= 0.0f && u[0] < 1.0f && u[1] >= 0.0f && u[1] < 1.0f);
	uint32_t ring = cell / strata->sector_count;
	uint32_t sector = cell % strata->sector_count;
	float sine2 = ((float)ring + u[0]) / (float)strata->ring_count;
	float phi = 2.0f * SHADE_PI * (((float)sector + u[1]) / (float)strata->sector_count);
	float sine = sqrtf(sine2);
	return stilb_vec3_make(sine * cosf(phi), sine * sinf(phi), sqrtf(fmaxf(1.0f - sine2, 1e-12f)));
}

/* ---- sums -------------------------------------------------------------------------------------------------------- */

/* Adds to the sum what the edge between a cell and its neighbour in the ring inside contributes to the derivatives. */
static void add_ring_edge(const gi_cache_ring *ring, const gi_cache_sector *sector, const gi_cache_cell *cell,
                          const gi_cache_cell *inner, gi_cache_gathered *sum)
{
	stilb_vec3 step = cell->radiance - inner->radiance;
	float nearness = fmaxf(cell->nearness, inner->nearness);
	stilb_vec3 moved = step * (ring->inner * nearness);
	sum->translation[0] += moved * sector->middle[0];
	sum->translation[1] += moved * sector->middle[1];
	float bent = gi_cache_mean(step) * ring->inner2 * nearness * nearness;
	for (int i = 0; i < 3; i++)
		sum->hessian[i] += bent * sector->spread[i];
}

/* Adds to the sum what the edge between a cell and its neighbour in the sector before contributes to the derivatives.
 * width: extent of a ring in sin^2(theta), the same for all rings. */
static void add_sector_edge(const gi_cache_ring *ring, const gi_cache_sector *sector, const gi_cache_cell *cell,
                            const gi_cache_cell *before, float width, gi_cache_gathered *sum)
{
	stilb_vec3 step = cell->radiance - before->radiance;
	float nearness = fmaxf(cell->nearness, before->nearness);
	stilb_vec3 moved = step * (ring->sine_step * nearness);
	float u[2] = {sector->edge[0], sector->edge[1]};
	sum->translation[0] -= moved * u[1];
	sum->translation[1] += moved * u[0];
	float bent = gi_cache_mean(step) * 2.0f * width * nearness * nearness;
	sum->hessian[0] -= bent * u[0] * u[1];
	sum->hessian[1] += bent * 0.5f * (u[0] * u[0] - u[1] * u[1]);
	sum->hessian[2] += bent * u[0] * u[1];
}

gi_cache_gathered gi_cache_strata_gather(const gi_cache_strata *strata, const gi_cache_cell *cells)
{
	STILB_ASSERT(strata->ring_count > 0 && strata->sector_count > 0 && cells);
	uint32_t sectors = strata->sector_count;
	float width = 1.0f / (float)strata->ring_count;
	gi_cache_gathered sum = {0};
	for (uint32_t i = 0; i < strata->ring_count; i++) {
		const gi_cache_ring *ring = &strata->rings[i];
		for (uint32_t k = 0; k < sectors; k++) {
			const gi_cache_sector *sector = &strata->sectors[k];
			const gi_cache_cell *cell = &cells[i * sectors + k];
			sum.irradiance += cell->radiance;
			sum.rotation[0] += cell->radiance * (ring->tangent * sector->middle[0]);
			sum.rotation[1] += cell->radiance * (ring->tangent * sector->middle[1]);
			sum.nearness += cell->nearness;
			if (i > 0)
				add_ring_edge(ring, sector, cell, cell - sectors, &sum);
			add_sector_edge(ring, sector, cell, k > 0 ? cell - 1 : cell + sectors - 1, width, &sum);
		}
	}
	float count = (float)gi_cache_strata_cells(strata);
	float share = SHADE_PI / count;
	sum.irradiance *= share;
	sum.rotation[0] *= share;
	sum.rotation[1] *= share;
	sum.nearness /= count;
	return sum;
}
