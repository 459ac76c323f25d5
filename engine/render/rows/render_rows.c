/* The rows of the scene's parts: one table for all, and rows of the frame for what moves. See render_rows.h. */
#include "render/rows/render_rows.h"

#include "profiler/prof.h"
#include "render/render_internal.h"

#include <stdlib.h>
#include <string.h>

#define ROWS_GRAIN 256u /* models that move in one step of the loop that writes their rows: some 10 us */

/* ---- tables ------------------------------------------------------------------------------------------------------ */

static void rows_free(stilb_render *render, render_rows *rows)
{
	if (rows)
		render_device_rows_free(render->device, rows);
}

/* Frees a table when the frames begun so far are done. */
static void rows_retire(stilb_render *render, render_rows *rows)
{
	STILB_ASSERT_OWNER(render->owner);
	if (!rows)
		return;
	rows->frame = render->resources.frame;
	rows->next = render->replaced_rows;
	render->replaced_rows = rows;
}

void render_rows_frame(stilb_render *render)
{
	STILB_ASSERT_OWNER(render->owner);
	render_rows **link = &render->replaced_rows;
	while (*link) {
		render_rows *rows = *link;
		if (rows->frame + STILB_GPU_FRAMES > render->resources.frame) {
			link = &rows->next;
			continue;
		}
		*link = rows->next;
		rows_free(render, rows);
	}
}

void render_rows_finish(stilb_render *render)
{
	while (render->replaced_rows) {
		render_rows *rows = render->replaced_rows;
		render->replaced_rows = rows->next;
		rows_free(render, rows);
	}
}

/* ---- writing ----------------------------------------------------------------------------------------------------- */

/* Writes the row of a part of a model; one of a removed model has none. last: of render_row. */
static inline void rows_put(render_row *row, const render_scene *tables, const stilb_scene *scene, uint32_t model,
                            uint32_t part, uint32_t last, bool stream)
{
	if (scene->part_mesh[part] == STILB_SCENE_NONE)
		return;
	const stilb_mat4 *transform = &scene->part_transform[part];
	STILB_ASSERT(transform->m[3] == 0.0f && transform->m[7] == 0.0f && transform->m[11] == 0.0f);
	STILB_ASSERT(transform->m[15] == 1.0f && "the transform is affine");
	render_row_write(row, transform, tables->materials[scene->part_material[part]].id & RENDER_INDEX_MASK,
	                 tables->meshes[scene->part_mesh[part]].id & RENDER_INDEX_MASK, last,
	                 render_row_model(scene, model), stream);
}

static void rows_put_all(render_rows *rows, const render_scene *tables, const stilb_scene *scene)
{
	PROFILE("write all rows");
	STILB_ASSERT(scene->part_count <= rows->capacity);
	bool stream = scene->part_count > RENDER_CACHED_ROWS;
	for (uint32_t m = 0; m < scene->model_count; m++)
		for (uint32_t p = scene->first_part[m]; p < scene->first_part[m + 1]; p++)
			rows_put(&rows->data[p], tables, scene, m, p, 0, stream);
	render_row_drain();
}

/* ---- creation, growth -------------------------------------------------------------------------------------------- */

/* Makes room for so many parts: another table, not written yet. */
static stilb_result rows_make(stilb_render *render, uint32_t count, uint32_t capacity, render_rows **rows)
{
	*rows = NULL;
	if (count > RENDER_MAX_ROWS)
		return stilb_fail(STILB_ERROR_ARGUMENT, "%u parts; a scene that is drawn has at most %u", count,
		                  RENDER_MAX_ROWS);
	capacity = capacity < RENDER_MAX_ROWS ? capacity : RENDER_MAX_ROWS;
	return render_device_rows_make(render->device, capacity, rows);
}

stilb_result render_places_make(stilb_render *render, render_scene *tables, const stilb_scene *scene)
{
	STILB_ASSERT(!tables->places.rows);
	if (scene->part_count == 0)
		return STILB_OK;
	stilb_result result = rows_make(render, scene->part_count, scene->part_count, &tables->places.rows);
	if (result == STILB_OK)
		rows_put_all(tables->places.rows, tables, scene);
	return result;
}

void render_places_finish(stilb_render *render, render_places *places, bool shown)
{
	if (shown)
		rows_retire(render, places->rows);
	else
		rows_free(render, places->rows);
	free(places->words);
	free(places->stretches);
	free(places->last);
	free(places->states);
	free(places->moving);
	*places = (render_places){0};
}

/* Makes the words as long as a table of `capacity` rows; from part `first` on they are those of the table. */
static bool places_fit_words(render_places *places, uint32_t first, uint32_t capacity)
{
	uint32_t *words = realloc(places->words, (size_t)capacity * sizeof *words);
	if (!words)
		return false;
	for (uint32_t p = first; p < capacity; p++)
		words[p] = p;
	places->words = words;
	return true;
}

/* Makes the stretches as long as a table of `capacity` rows; those of the scene's parts from `first` on are new. */
static bool places_fit_stretches(render_places *places, const stilb_scene *scene, uint32_t first, uint32_t capacity)
{
	float *stretches = realloc(places->stretches, (size_t)capacity * sizeof *stretches);
	if (!stretches)
		return false;
	for (uint32_t p = first; p < scene->part_count; p++)
		stretches[p] = render_place_stretch(&scene->part_transform[p]);
	places->stretches = stretches;
	return true;
}

/* The transform and mesh of a part as they are now. */
static void place_keep(render_place_last *last, const render_scene *tables, const stilb_scene *scene, uint32_t part)
{
	uint32_t mesh = scene->part_mesh[part];
	const float *m = scene->part_transform[part].m;
	last->mesh = mesh == STILB_SCENE_NONE ? 0 : 1 + (tables->meshes[mesh].id & RENDER_INDEX_MASK);
	for (int r = 0; r < 3; r++)
		for (int c = 0; c < 4; c++)
			last->transform[4 * r + c] = m[4 * c + r];
}

/* Makes the last places as long as a table of `capacity` rows; the scene's parts from `first` on have not moved. */
static bool places_fit_last(render_places *places, const render_scene *tables, const stilb_scene *scene, uint32_t first,
                            uint32_t capacity)
{
	render_place_last *last = realloc(places->last, (size_t)capacity * sizeof *last);
	if (!last)
		return false;
	memset(last + first, 0, (capacity - first) * sizeof *last);
	for (uint32_t p = first; p < scene->part_count; p++)
		place_keep(&last[p], tables, scene, p);
	places->last = last;
	return true;
}

static stilb_result places_no_memory(const stilb_scene *scene)
{
	return stilb_fail(STILB_ERROR_MEMORY, "no memory for the places of %u models", scene->model_count);
}

/* Replaces a table that is too small for the scene by one with room for as many parts again. */
static stilb_result places_grow(stilb_render *render, const stilb_scene *scene)
{
	render_places *places = &render->scene.places;
	uint32_t before = places->rows ? places->rows->capacity : 0;
	uint32_t capacity = before > 0 && scene->part_count / 2 < before ? 2 * before : scene->part_count;
	render_rows *rows;
	stilb_result result = rows_make(render, scene->part_count, capacity, &rows);
	if (result != STILB_OK)
		return result;
	if ((places->words && !places_fit_words(places, before, rows->capacity)) ||
	    (places->stretches && !places_fit_stretches(places, scene, 0, rows->capacity)) ||
	    (places->last && !places_fit_last(places, &render->scene, scene, before, rows->capacity))) {
		rows_free(render, rows);
		return places_no_memory(scene);
	}
	rows_put_all(rows, &render->scene, scene);
	rows_retire(render, places->rows);
	places->rows = rows;
	return STILB_OK;
}

/* ---- what has changed -------------------------------------------------------------------------------------------- */

/* Makes an array of bytes as long as `count`; new ones are zeros. */
static bool places_fit_bytes(uint8_t **bytes, uint32_t *capacity, uint32_t count)
{
	uint32_t before = *capacity;
	if (!render_reserve((void **)bytes, capacity, count, 1))
		return false;
	if (*capacity > before)
		memset(*bytes + before, 0, *capacity - before);
	return true;
}

stilb_result render_places_note(render_places *places, const stilb_scene *scene)
{
	if (scene->moved_count == 0)
		return STILB_OK;
	/* Models that rest are added to the list once, so that it has never more than all. */
	uint64_t most = (uint64_t)places->moving_count + scene->moved_count;
	most = most < scene->model_count ? most : scene->model_count;
	if (!places_fit_bytes(&places->states, &places->state_capacity, scene->model_count) ||
	    !render_reserve((void **)&places->moving, &places->moving_capacity, (uint32_t)most, sizeof *places->moving))
		return places_no_memory(scene);
	uint8_t *states = places->states;
	uint32_t *moving = places->moving, count = places->moving_count;
	for (uint32_t i = 0; i < scene->moved_count; i++) {
		uint32_t model = scene->moved[i];
		STILB_ASSERT(model < scene->model_count);
		if (states[model] == RENDER_PLACE_RESTS)
			moving[count++] = model;
		states[model] = RENDER_PLACE_NOTED;
	}
	STILB_ASSERT(count <= places->moving_capacity);
	places->moving_count = count;
	return STILB_OK;
}

/* ---- a frame ----------------------------------------------------------------------------------------------------- */

/* Ages the models that move: those that have rested for two frames go back to their rows in the table. Returns the
 * number of parts of the others. */
static uint32_t places_age(render_places *places, const render_scene *tables, const stilb_scene *scene)
{
	static const uint8_t after[] = {[RENDER_PLACE_NOTED] = RENDER_PLACE_MOVED,
	                                [RENDER_PLACE_MOVED] = RENDER_PLACE_SETTLED,
	                                [RENDER_PLACE_SETTLED] = RENDER_PLACE_RESTS};
	uint32_t kept = 0, parts = 0;
	for (uint32_t i = 0; i < places->moving_count; i++) {
		uint32_t model = places->moving[i], first = scene->first_part[model], end = scene->first_part[model + 1];
		uint8_t state = after[places->states[model]];
		places->states[model] = state;
		if (state != RENDER_PLACE_RESTS) {
			places->moving[kept++] = model;
			parts += end - first;
			continue;
		}
		for (uint32_t p = first; p < end; p++) {
			rows_put(&places->rows->data[p], tables, scene, model, p, 0, false);
			places->words[p] = p;
		}
	}
	places->moving_count = kept;
	return parts;
}

/* Shared by the slices of the loop; each writes the rows of its models alone. */
typedef struct rows_job {
	const render_scene *tables;
	const stilb_scene *scene;
	const render_resources *resources;
	render_row *rows; /* of the frame, from the one with index `first` on */
	uint32_t first;
	uint32_t parts; /* that move: behind their rows come those of their last places, if these are kept */
	bool stream;
} rows_job;

/* Writes where a part that has moved was in the frame before, unless another mesh is there now, and keeps where it is.
 * number: of the part among those that move. Returns render_row.last. */
static uint32_t rows_put_last(const rows_job *job, uint32_t number, uint32_t part, bool moved)
{
	render_place_last *last = &job->tables->places.last[part], before = *last;
	uint32_t row = job->parts + number;
	place_keep(last, job->tables, job->scene, part);
	last->row = 0;
	if (!moved || last->mesh == 0 || before.mesh != last->mesh)
		return 0;
	render_last_row *out = (render_last_row *)(void *)(job->rows + row);
	uint32_t shift = 0;
	bool vertices = render_mesh_last(job->resources, last->mesh - 1, &shift);
	*out = (render_last_row){.shift = shift, .vertices = vertices};
	memcpy(out->transform, before.transform, sizeof out->transform);
	last->row = 1 + job->first + row;
	return last->row;
}

static void rows_slice(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	PROFILE("write rows");
	(void)worker;
	const rows_job *job = context;
	const render_places *places = &job->tables->places;
	const uint32_t *first_part = job->scene->first_part;
	for (uint32_t i = begin; i < end; i++) {
		uint32_t model = places->moving[i];
		bool moved = places->states[model] == RENDER_PLACE_MOVED;
		for (uint32_t p = first_part[model]; p < first_part[model + 1]; p++) {
			uint32_t number = (places->words[p] & (RENDER_MAX_ROWS - 1)) - job->first;
			uint32_t last = places->last ? rows_put_last(job, number, p, moved) : 0;
			rows_put(job->rows + number, job->tables, job->scene, model, p, last, job->stream);
			if (places->stretches)
				places->stretches[p] = render_place_stretch(&job->scene->part_transform[p]);
		}
	}
	render_row_drain();
}

/* Brings what does not need the frame's memory up to date. */
static stilb_result places_settle(stilb_render *render, const stilb_scene *scene)
{
	render_places *places = &render->scene.places;
	stilb_result result = render_places_note(places, scene);
	if (result == STILB_OK && (!places->rows || scene->part_count > places->rows->capacity))
		result = places_grow(render, scene);
	if (result == STILB_OK && places->moving_count > 0 && !places->words &&
	    !places_fit_words(places, 0, places->rows->capacity))
		result = places_no_memory(scene);
	return result;
}

/* Makes what frames need besides the rows. */
static stilb_result places_fit(stilb_render *render, const stilb_scene *scene, uint32_t needs)
{
	render_places *places = &render->scene.places;
	uint32_t capacity = places->rows->capacity;
	bool fits =
		!(needs & RENDER_PLACES_STRETCHES) || places->stretches || places_fit_stretches(places, scene, 0, capacity);
	fits = fits && (!(needs & RENDER_PLACES_LAST) || places->last ||
	                places_fit_last(places, &render->scene, scene, 0, capacity));
	return fits ? STILB_OK : places_no_memory(scene);
}

stilb_result render_places_frame(stilb_render *render, const stilb_scene *scene, uint32_t needs, uint32_t *rows)
{
	STILB_ASSERT_OWNER(render->owner);
	render_places *places = &render->scene.places;
	*rows = 0;
	render->resources.keeps_last = needs & RENDER_PLACES_LAST;
	if (scene->part_count == 0)
		return STILB_OK;
	stilb_result result = render->shown_rows ? STILB_OK : places_settle(render, scene);
	if (result == STILB_OK)
		result = places_fit(render, scene, needs);
	if (result != STILB_OK || render->shown_rows)
		return result;
	if (places->moving_count > 0)
		*rows = places_age(places, &render->scene, scene) * (places->last ? 2u : 1u);
	if (*rows == 0)
		render->shown_rows = places->rows;
	return STILB_OK;
}

void render_places_move(stilb_render *render, const stilb_scene *scene, render_row *rows, uint32_t first,
                        uint32_t count, stilb_job_pool *pool, uint32_t worker)
{
	STILB_ASSERT_OWNER(render->owner);
	const render_places *places = &render->scene.places;
	uint32_t word = RENDER_ROW_FRAME | first;
	for (uint32_t i = 0; i < places->moving_count; i++) {
		uint32_t model = places->moving[i];
		for (uint32_t p = scene->first_part[model]; p < scene->first_part[model + 1]; p++)
			places->words[p] = word++;
	}
	uint32_t parts = word - (RENDER_ROW_FRAME | first);
	STILB_ASSERT(count == parts * (places->last ? 2u : 1u));
	(void)count;
	rows_job job = {.tables = &render->scene,
	                .scene = scene,
	                .resources = &render->resources,
	                .rows = rows,
	                .first = first,
	                .parts = parts,
	                .stream = parts > RENDER_CACHED_ROWS};
	stilb_job_parallel_for(pool, places->moving_count, ROWS_GRAIN, rows_slice, &job, worker);
	render->shown_rows = places->rows;
}
