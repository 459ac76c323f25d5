#include "bake/bake_atlas.h"

#include "bake/bake_pack.h"
#include "profiler/prof.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#define FILL 0.7       /* share of a page that charts are first made to cover, where no density is given */
#define FILL_STEP 0.93 /* of the density, until all fits */
#define FILL_TRIES 20
#define EVEN 1e-3       /* relative: a transform whose axes are as long, and as perpendicular, scales evenly */
#define ROUND_OFF 1e-3f /* texels that a chart may be wider than a whole number of them */

stilb_bake_atlas_options stilb_bake_atlas_options_default(void)
{
	return (stilb_bake_atlas_options){.unwrap = stilb_bake_unwrap_options_default(), .side = 1024, .mips = 1};
}

/* A lookup between texels of mip level m reads texels whose middles are less than 2^m away, and which are means of what
 * is half as far around them. */
static uint32_t border_of(uint32_t mips)
{
	return mips == 0 ? 1 : 3u << (mips - 1);
}

/* ---- unwrapping -------------------------------------------------------------------------------------------------- */

/* An unwrapping to make: of a mesh, or of a part as it lies in the world. */
typedef struct atlas_work {
	uint32_t mesh, part; /* part STILB_SCENE_NONE: the mesh in its own space */
	double stretch;
} atlas_work;

typedef struct atlas_make {
	const stilb_scene *scene;
	const stilb_bake_atlas_options *options;
	stilb_job_pool *pool;
	stilb_bake_atlas *atlas;
	atlas_work *work;  /* [atlas.uv_count] */
	float *part_scale; /* [part_count] metres of the world in one of its uv's units */
	/* Some unwrapping failed for want of memory. Relaxed: read after the loop over them, which orders it. */
	_Atomic bool failed;
} atlas_make;

/* The factor of a transform that scales evenly; 0: it does not. */
static float even_scale(const stilb_mat4 *m)
{
	double square[3], most = 0.0;
	for (int a = 0; a < 3; a++) {
		square[a] = 0.0;
		for (int k = 0; k < 3; k++)
			square[a] += (double)m->m[4 * a + k] * (double)m->m[4 * a + k];
		most = fmax(most, square[a]);
	}
	for (int a = 0; a < 3; a++) {
		double dot = 0.0;
		for (int k = 0; k < 3; k++)
			dot += (double)m->m[4 * a + k] * (double)m->m[4 * ((a + 1) % 3) + k];
		if (!(square[a] > most * (1.0 - EVEN)) || !(fabs(dot) < most * EVEN))
			return 0.0f;
	}
	return (float)sqrt(most);
}

static bool part_is_shown(const stilb_scene *scene, uint32_t model, uint32_t part)
{
	return !isnan(scene->bounds.radius[model]) && scene->part_mesh[part] != STILB_SCENE_NONE &&
	       scene->meshes[scene->part_mesh[part]].index_count > 0;
}

/* Lists what to unwrap. False: no memory. */
static bool list_work(atlas_make *make)
{
	const stilb_scene *scene = make->scene;
	stilb_bake_atlas *atlas = make->atlas;
	uint32_t *of_mesh = stilb_memory_alloc(scene->mesh_count, sizeof *of_mesh);
	make->work = stilb_memory_alloc((size_t)scene->part_count + 1, sizeof *make->work);
	make->part_scale = stilb_memory_alloc(scene->part_count, sizeof *make->part_scale);
	atlas->parts = stilb_memory_alloc(scene->part_count, sizeof *atlas->parts);
	if (of_mesh && make->work && make->part_scale && atlas->parts) {
		atlas->part_count = scene->part_count;
		memset(of_mesh, 0xff, scene->mesh_count * sizeof *of_mesh);
		memset(atlas->parts, 0xff, scene->part_count * sizeof *atlas->parts);
		for (uint32_t model = 0; model < scene->model_count; model++)
			for (uint32_t part = scene->first_part[model]; part < scene->first_part[model + 1]; part++) {
				if (!part_is_shown(scene, model, part))
					continue;
				uint32_t mesh = scene->part_mesh[part];
				float scale = even_scale(&scene->part_transform[part]);
				make->part_scale[part] = scale > 0.0f ? scale : 1.0f;
				if (scale > 0.0f && of_mesh[mesh] != UINT32_MAX) {
					atlas->parts[part].uv = of_mesh[mesh];
					continue;
				}
				if (scale > 0.0f)
					of_mesh[mesh] = atlas->uv_count;
				make->work[atlas->uv_count] = (atlas_work){mesh, scale > 0.0f ? STILB_SCENE_NONE : part, 1.0};
				atlas->parts[part].uv = atlas->uv_count++;
			}
	}
	free(of_mesh);
	return atlas->part_count == scene->part_count && make->part_scale && make->work && atlas->parts;
}

/* [vertex_count][3] the mesh's positions as a part shows them; NULL: no memory. */
static float *positions_in_world(const stilb_scene_mesh *mesh, const stilb_mat4 *to_world)
{
	float *positions = stilb_memory_alloc(mesh->vertex_count, 3 * sizeof *positions);
	const float *m = to_world->m;
	for (uint32_t v = 0; v < mesh->vertex_count && positions; v++) {
		const float *p = mesh->vertices[v].position;
		for (int k = 0; k < 3; k++)
			positions[3 * (size_t)v + (size_t)k] = m[k] * p[0] + m[4 + k] * p[1] + m[8 + k] * p[2] + m[12 + k];
	}
	return positions;
}

static stilb_result unwrap_one(const atlas_make *make, uint32_t index, uint32_t worker)
{
	atlas_work *work = &make->work[index];
	const stilb_scene_mesh *mesh = &make->scene->meshes[work->mesh];
	float *positions = NULL;
	stilb_bake_mesh soup = {.positions = mesh->vertices->position,
	                        .position_step = sizeof *mesh->vertices,
	                        .indices = mesh->indices,
	                        .vertex_count = mesh->vertex_count,
	                        .triangle_count = mesh->index_count / 3};
	if (work->part != STILB_SCENE_NONE) {
		positions = positions_in_world(mesh, &make->scene->part_transform[work->part]);
		if (!positions)
			return STILB_ERROR_MEMORY;
		soup.positions = positions;
		soup.position_step = 3 * sizeof *positions;
	}
	stilb_bake_uv *uv = &make->atlas->uvs[index];
	stilb_result result = stilb_bake_unwrap(&soup, &make->options->unwrap, make->pool, worker, uv);
	if (result == STILB_OK)
		work->stretch = stilb_bake_stretch(&soup, uv);
	free(positions);
	return result;
}

/* stilb_job_range_fn */
static void unwrap_some(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	atlas_make *make = context;
	for (uint32_t i = begin; i < end; i++)
		if (unwrap_one(make, i, worker) != STILB_OK)
			atomic_store_explicit(&make->failed, true, memory_order_relaxed); /* relaxed: see atlas_make.failed */
}

/* ---- places ------------------------------------------------------------------------------------------------------ */

/* Gives each part its range of places. False: too many. */
static bool count_places(stilb_bake_atlas *atlas)
{
	uint64_t count = 0;
	for (uint32_t part = 0; part < atlas->part_count; part++)
		if (atlas->parts[part].uv != STILB_BAKE_NO_CHART) {
			atlas->parts[part].first_place = (uint32_t)count;
			count += atlas->uvs[atlas->parts[part].uv].chart_count;
			if (count > INT32_MAX)
				return false;
		}
	atlas->place_count = (uint32_t)count;
	return true;
}

static uint32_t texels_of(float length, float scale)
{
	float texels = ceilf(length * scale - ROUND_OFF);
	return texels < 1.0f ? 1 : (uint32_t)texels;
}

/* Sizes of all charts at this density; one that is too large for a page has less. */
static void size_charts(const atlas_make *make, float density, stilb_bake_rect *rects)
{
	stilb_bake_atlas *atlas = make->atlas;
	float room = (float)(atlas->side - 2 * atlas->border);
	atlas->coarser = 0;
	for (uint32_t part = 0; part < atlas->part_count; part++) {
		if (atlas->parts[part].uv == STILB_BAKE_NO_CHART)
			continue;
		const stilb_bake_uv *uv = &atlas->uvs[atlas->parts[part].uv];
		for (uint32_t c = 0; c < uv->chart_count; c++) {
			uint32_t at = atlas->parts[part].first_place + c;
			float scale = density * make->part_scale[part], width = uv->charts[c].width;
			if (width * scale > room) {
				scale = room / width;
				atlas->coarser++;
			}
			atlas->places[at].scale = scale;
			rects[at].width = texels_of(width, scale) + 2 * atlas->border;
			rects[at].height = texels_of(uv->charts[c].height, scale) + 2 * atlas->border;
		}
	}
}

/* World area of all charts, square metres. */
static double area_of(const atlas_make *make)
{
	const stilb_bake_atlas *atlas = make->atlas;
	double sum = 0.0;
	for (uint32_t part = 0; part < atlas->part_count; part++) {
		if (atlas->parts[part].uv == STILB_BAKE_NO_CHART)
			continue;
		const stilb_bake_uv *uv = &atlas->uvs[atlas->parts[part].uv];
		double scale = (double)make->part_scale[part], area2 = 0.0;
		for (uint32_t t = 0; t < uv->triangle_count; t++) {
			const float(*at)[2] = (const float(*)[2]) & uv->corners[3 * (size_t)t];
			if (uv->chart[t] != STILB_BAKE_NO_CHART)
				area2 += (double)(at[1][0] - at[0][0]) * (double)(at[2][1] - at[0][1]) -
				         (double)(at[1][1] - at[0][1]) * (double)(at[2][0] - at[0][0]);
		}
		sum += 0.5 * area2 * scale * scale;
	}
	return sum;
}

static stilb_result pack_at(const atlas_make *make, float density, stilb_bake_rect *rects)
{
	size_charts(make, density, rects);
	make->atlas->density = density;
	return stilb_bake_pack(rects, make->atlas->place_count, make->atlas->side, &make->atlas->page_count);
}

static stilb_result place_charts(const atlas_make *make)
{
	stilb_bake_atlas *atlas = make->atlas;
	stilb_bake_rect *rects = stilb_memory_alloc(atlas->place_count, sizeof *rects);
	atlas->places = stilb_memory_alloc(atlas->place_count, sizeof *atlas->places);
	stilb_result result = rects && atlas->places
	                          ? STILB_OK
	                          : stilb_fail(STILB_ERROR_MEMORY, "out of memory for %u charts", atlas->place_count);
	double area = area_of(make), texels = (double)atlas->side * atlas->side;
	float density = make->options->density;
	bool given = density > 0.0f;
	if (!given)
		density = area > 0.0 ? (float)sqrt(FILL * texels / area) : 1.0f;
	if (result == STILB_OK && area * (double)density * (double)density > texels * STILB_BAKE_MAX_PAGES)
		result = stilb_fail(STILB_ERROR_ARGUMENT,
		                    "%g texels a metre are %.3g texels, more than %u pages of %u x %u; give %g at most",
		                    (double)density, area * (double)density * (double)density, STILB_BAKE_MAX_PAGES,
		                    atlas->side, atlas->side, sqrt(texels * STILB_BAKE_MAX_PAGES / area));
	for (int tries = 0; tries < FILL_TRIES && result == STILB_OK; tries++) {
		result = pack_at(make, density, rects);
		if (given || atlas->page_count <= 1)
			break;
		density *= (float)FILL_STEP;
	}
	if (result == STILB_OK && atlas->page_count > STILB_BAKE_MAX_PAGES)
		result = stilb_fail(STILB_ERROR_ARGUMENT,
		                    "%u charts with their borders take %u pages of %u x %u, and there are up to %u; give "
		                    "larger pages, or fewer texels a metre",
		                    atlas->place_count, atlas->page_count, atlas->side, atlas->side, STILB_BAKE_MAX_PAGES);
	for (uint32_t i = 0; i < atlas->place_count && result == STILB_OK; i++) {
		atlas->places[i].page = rects[i].page;
		atlas->places[i].x = rects[i].x + atlas->border;
		atlas->places[i].y = rects[i].y + atlas->border;
	}
	if (result == STILB_OK && atlas->page_count > 0)
		atlas->covered = area * (double)atlas->density * (double)atlas->density / (texels * atlas->page_count);
	free(rects);
	return result;
}

/* ---- life -------------------------------------------------------------------------------------------------------- */

static void sum_up(const atlas_make *make)
{
	stilb_bake_atlas *atlas = make->atlas;
	double squares = 0.0;
	for (uint32_t part = 0; part < atlas->part_count; part++) {
		uint32_t index = atlas->parts[part].uv;
		if (index == STILB_BAKE_NO_CHART)
			continue;
		const stilb_bake_uv *uv = &atlas->uvs[index];
		uint64_t count = uv->triangle_count - uv->flat - uv->invalid;
		squares += (double)count * make->work[index].stretch * make->work[index].stretch;
		atlas->triangles += count;
		atlas->flat += uv->flat;
		atlas->invalid += uv->invalid;
	}
	atlas->stretch = atlas->triangles > 0 ? sqrt(squares / (double)atlas->triangles) : 1.0;
}

static stilb_result atlas_fill(atlas_make *make)
{
	stilb_bake_atlas *atlas = make->atlas;
	if (!list_work(make))
		return stilb_fail(STILB_ERROR_MEMORY, "out of memory for %u parts", make->scene->part_count);
	atlas->uvs = calloc((size_t)atlas->uv_count + 1, sizeof *atlas->uvs);
	if (!atlas->uvs)
		return stilb_fail(STILB_ERROR_MEMORY, "out of memory for %u parts", make->scene->part_count);
	{
		PROFILE("bake.atlas.unwrap");
		stilb_job_parallel_for(make->pool, atlas->uv_count, 1, unwrap_some, make, 0);
	}
	if (atomic_load_explicit(&make->failed, memory_order_relaxed)) /* relaxed: see atlas_make.failed */
		return stilb_fail(STILB_ERROR_MEMORY, "out of memory to unwrap the scene");
	if (!count_places(atlas))
		return stilb_fail(STILB_ERROR_ARGUMENT, "the scene has more than 2^31 charts");
	sum_up(make);
	PROFILE("bake.atlas.pack");
	return place_charts(make);
}

stilb_result stilb_bake_atlas_create(const stilb_scene *scene, const stilb_bake_atlas_options *options,
                                     stilb_job_pool *pool, stilb_bake_atlas **out)
{
	STILB_ASSERT(scene && options && pool && out);
	STILB_ASSERT(options->side >= 64 && options->side <= STILB_BAKE_MAX_SIDE && options->mips <= 6);
	atlas_make make = {.scene = scene, .options = options, .pool = pool};
	*out = NULL;
	make.atlas = calloc(1, sizeof *make.atlas);
	if (!make.atlas)
		return stilb_fail(STILB_ERROR_MEMORY, "out of memory for an atlas");
	make.atlas->side = options->side;
	make.atlas->border = border_of(options->mips);
	if (4 * make.atlas->border > options->side) {
		free(make.atlas);
		return stilb_fail(STILB_ERROR_ARGUMENT, "borders for %u mip levels leave no room on pages of %u texels",
		                  options->mips, options->side);
	}
	stilb_result result = atlas_fill(&make);
	free(make.work);
	free(make.part_scale);
	if (result == STILB_OK)
		*out = make.atlas;
	else
		stilb_bake_atlas_destroy(make.atlas);
	return result;
}

void stilb_bake_atlas_destroy(stilb_bake_atlas *atlas)
{
	if (!atlas)
		return;
	for (uint32_t i = 0; i < atlas->uv_count && atlas->uvs; i++)
		stilb_bake_uv_finish(&atlas->uvs[i]);
	free(atlas->uvs);
	free(atlas->parts);
	free(atlas->places);
	free(atlas);
}

bool stilb_bake_atlas_corners(const stilb_bake_atlas *atlas, uint32_t part, uint32_t triangle, uint32_t *page,
                              float corners[3][2])
{
	STILB_ASSERT(part < atlas->part_count);
	const stilb_bake_part *own = &atlas->parts[part];
	if (own->uv == STILB_BAKE_NO_CHART)
		return false;
	const stilb_bake_uv *uv = &atlas->uvs[own->uv];
	STILB_ASSERT(triangle < uv->triangle_count);
	if (uv->chart[triangle] == STILB_BAKE_NO_CHART)
		return false;
	const stilb_bake_place *place = &atlas->places[own->first_place + uv->chart[triangle]];
	*page = place->page;
	for (int i = 0; i < 3; i++) {
		const float *at = uv->corners[3 * (size_t)triangle + (size_t)i];
		corners[i][0] = (float)place->x + at[0] * place->scale;
		corners[i][1] = (float)place->y + at[1] * place->scale;
	}
	return true;
}
