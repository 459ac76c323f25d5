/*
 * Where the parts of the scene that was set stand: rows that are kept from frame to frame. Inside render/.
 *
 * Rows.     A table on the device has one row for each part, written when the scene is set. Draws of a part name its
 *           row, in every pass of every frame, and write none.
 * Movement. A part that has moved in the last two frames is drawn from a row of the frame's memory instead, which is
 *           written anew for each of these frames. Then its row in the table is written again: the frames in flight do
 *           not read it. So no row changes while the device may read it, and nothing is copied by the device.
 * Changes.  Which models have moved is what the scene lists (stilb_scene.moved), as it does those that show another
 *           mesh or material, or whose mesh was replaced: render_places_note takes the list, at any time before the
 *           frame's first pass of the scene; render_places_frame, when that pass begins, reads the transforms.
 * Velocity. For frames that show velocities each part's place in the frame before is kept by the CPU, too. A row of the
 *           frame whose part has just moved then names another one, that has it.
 * Growth.   A scene that outgrows its table gets another one, written in full; the old one is kept until the frames in
 *           flight are done. */
#ifndef STILB_RENDER_ROWS_H
#define STILB_RENDER_ROWS_H

#include "base/base_contract.h"
#include "jobs/job.h"
#include "render/render.h"

#if defined(__SSE2__)
#include <emmintrin.h>
#else
#include <math.h>
#endif

/* One draw as the vertex shader reads it (shaders/row.glsl): the upper three rows of the affine transform, then the
 * material's index. A 2D draw has only its clip rectangle, in the first row. */
typedef struct render_row {
	float transform[12];
	uint32_t material;
	uint32_t mesh;  /* index; for the stream hash, dumps and the extras of vertices */
	uint32_t last;  /* 1 + the index among the frame's rows of its render_last_row; 0: it has not moved in this frame */
	uint32_t model; /* of render_row_model: the scene's model that it draws a part of; 0: it is drawn by hand */
} render_row;

#define RENDER_ROW_FLAGS_SHIFT 24u

static_assert(STILB_SCENE_MAX_MODELS < 1u << RENDER_ROW_FLAGS_SHIFT && STILB_SCENE_MODEL_FLAGS < 256u,
              "a model's number and its flags share a word");

/* render_row.model: 1 + the model, and above it its flags, STILB_SCENE_MODEL_... */
static inline uint32_t render_row_model(const stilb_scene *scene, uint32_t model)
{
	return (1 + model) | (uint32_t)scene->model_flags[model] << RENDER_ROW_FLAGS_SHIFT;
}

/* Where a part was in the frame before, in the place of a row. */
typedef struct render_last_row {
	float transform[12];
	uint32_t shift;    /* what leads, modulo 2^32, from a vertex's index to its last place in RENDER_HEAP_LAST */
	uint32_t vertices; /* 1: they have moved, too; else 0, and shift does not matter */
	uint32_t unused[2];
} render_last_row;

static_assert(sizeof(render_row) == 64 && sizeof(render_last_row) == sizeof(render_row), "a row is a cache line");

/* The word by which a draw names its row: an index into the frame's rows, with RENDER_ROW_FRAME, or into the scene's
 * table. */
#define RENDER_MAX_ROWS (1u << 25) /* of each */
#define RENDER_ROW_FRAME RENDER_MAX_ROWS

/* A table of rows in memory of the device. */
typedef struct render_rows {
	render_row *data;         /* [capacity] written by the CPU alone */
	uint64_t address, buffer; /* the device's; stilb_gpu_buffer.id */
	uint32_t capacity;        /* > 0 */
	uint64_t frame;           /* of a replaced one: the last frame that may use it, as render_resources.frame counts */
	struct render_rows *next; /* of a replaced one */
} render_rows;

/* How long ago a model has moved. */
typedef enum render_place_state {
	RENDER_PLACE_RESTS,   /* its parts' rows are those of the table */
	RENDER_PLACE_NOTED,   /* it has moved since the last frame */
	RENDER_PLACE_MOVED,   /* in the last frame */
	RENDER_PLACE_SETTLED, /* in the frame before the last */
} render_place_state;

/* Where a part was in the frame before. */
typedef struct render_place_last {
	float transform[12];
	uint32_t mesh; /* index + 1; another one has come since: it is not the same part */
	uint32_t row;  /* render_row.last, while the part has a row of the frame */
} render_place_last;

/* What frames need of places besides the rows. */
#define RENDER_PLACES_STRETCHES 1u
#define RENDER_PLACES_LAST 2u /* for velocities */

/* The places of a scene's parts. {0} is empty. */
typedef struct render_places {
	render_rows *rows; /* NULL: no part so far */
	uint32_t *words;   /* [rows->capacity] by part: its word; NULL: none has ever moved, it is the part's number */
	float *stretches;  /* [rows->capacity] by part: render_place_stretch; NULL: nobody has asked for them so far */
	render_place_last *last; /* [rows->capacity] by part; NULL: nobody has asked for them so far */
	uint8_t *states;         /* [state_capacity] by model: render_place_state */
	uint32_t *moving;        /* [moving_count] the models that do not rest */
	uint32_t state_capacity; /* models beyond it rest */
	uint32_t moving_count, moving_capacity;
} render_places;

struct render_scene;

/* Makes the table of a scene whose meshes and materials are in `tables`, and writes it. STILB_ERROR_ARGUMENT: more than
 * RENDER_MAX_ROWS parts. STILB_ERROR_MEMORY. [any-thread] */
stilb_result render_places_make(stilb_render *render, struct render_scene *tables, const stilb_scene *scene);

/* Frees them; shown: frames may have used the table, so that it is kept until they are done [main-thread], else
 * [any-thread]. Leaves {0}. */
void render_places_finish(stilb_render *render, render_places *places, bool shown);

/* Notes the models that the scene lists as moved. STILB_ERROR_MEMORY; the same call may be made again.
 * [main-thread] */
stilb_result render_places_note(render_places *places, const stilb_scene *scene);

/* Brings the places up to date for the frame, before its draws of the scene; does nothing from its second call on.
 * needs: RENDER_PLACES_..., which stay up to date from then on. *rows: so many rows of the frame are needed for what
 * moves; if there are any, render_places_move follows. STILB_ERROR_MEMORY, STILB_ERROR_ARGUMENT as render_places_make.
 * [main-thread] */
stilb_result render_places_frame(stilb_render *render, const stilb_scene *scene, uint32_t needs, uint32_t *rows);

/* Writes these `count` rows. rows: where, the one with index `first` among the frame's. [main-thread] */
void render_places_move(stilb_render *render, const stilb_scene *scene, render_row *rows, uint32_t first,
                        uint32_t count, stilb_job_pool *pool, uint32_t worker);

/* When a frame has begun: frees the tables that no frame in flight uses. [main-thread] */
void render_rows_frame(stilb_render *render);

/* Frees all replaced tables; the device is idle. [main-thread] */
void render_rows_finish(stilb_render *render);

/* The word of a part. words, rows: of the places, in locals. */
static inline uint32_t render_place_word(const uint32_t *words, uint32_t part)
{
	return words ? words[part] : part;
}

/* render_row.last of a part that is drawn by a row of its own, as impostors are. */
static inline uint32_t render_place_last_row(const render_places *places, uint32_t part)
{
	bool frame = places->last && places->words && places->words[part] & RENDER_ROW_FRAME;
	return frame ? places->last[part].row : 0;
}

/* ---- stretches --------------------------------------------------------------------------------------------------- */

/* The square of the largest length of a column: how much a transform stretches, for a similarity exactly. Others may
 * stretch by up to sqrt(3) times that, where columns are no longer perpendicular. */
#if defined(__SSE2__)
static inline float render_place_stretch(const stilb_mat4 *transform)
{
	__m128 x = _mm_loadu_ps(transform->m), y = _mm_loadu_ps(transform->m + 4);
	__m128 z = _mm_loadu_ps(transform->m + 8), w = _mm_loadu_ps(transform->m + 12);
	_MM_TRANSPOSE4_PS(x, y, z, w);
	__m128 squares = _mm_add_ps(_mm_add_ps(_mm_mul_ps(x, x), _mm_mul_ps(y, y)), _mm_mul_ps(z, z));
	__m128 most = _mm_max_ss(squares, _mm_shuffle_ps(squares, squares, _MM_SHUFFLE(1, 1, 1, 1)));
	return _mm_cvtss_f32(_mm_max_ss(most, _mm_movehl_ps(squares, squares)));
}
#else
static inline float render_place_stretch(const stilb_mat4 *transform)
{
	float most = 0.0f;
	for (int c = 0; c < 3; c++) {
		const float *v = transform->m + 4 * c;
		most = fmaxf(most, v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
	}
	return most;
}
#endif

/* ---- writing ----------------------------------------------------------------------------------------------------- */

/* The GPU is the next to read a row. If there are more rows than the caches hold, rows are written with streaming
 * stores, a whole cache line each: no line is fetched only to be overwritten, and none evicts data that recording
 * reads. Fewer rows are written with ordinary stores: memory bandwidth for streaming stores is shared by all CPUs, so a
 * second worker would gain 1.5 times instead of 1.9 (measured). The thread sanitizer does not see streaming stores, so
 * its build has none. */
#define RENDER_CACHED_ROWS 65536u /* up to so many rows (4 MiB) stay in the CPU's caches until the GPU reads them */

#if defined(__SSE2__) && !defined(__SANITIZE_THREAD__)

/* Writes the upper three rows of the matrix, then material, mesh, last and model. stream: with non-temporal stores.
 * Without loops: gcc 12 turns a loop of loads into a copy of the matrix through the stack (measured: 5.0 ns a draw
 * instead of 4.1). */
static inline void render_row_write(render_row *row, const stilb_mat4 *transform, uint32_t material, uint32_t mesh,
                                    uint32_t last, uint32_t model, bool stream)
{
	__m128i ids = _mm_set_epi32((int32_t)model, (int32_t)last, (int32_t)mesh, (int32_t)material);
	__m128 x = _mm_loadu_ps(transform->m), y = _mm_loadu_ps(transform->m + 4);
	__m128 z = _mm_loadu_ps(transform->m + 8), w = _mm_loadu_ps(transform->m + 12);
	_MM_TRANSPOSE4_PS(x, y, z, w); /* columns to rows */
	if (stream) {
		_mm_stream_ps(row->transform, x);
		_mm_stream_ps(row->transform + 4, y);
		_mm_stream_ps(row->transform + 8, z);
		_mm_stream_si128((__m128i *)&row->material, ids);
	} else {
		_mm_store_ps(row->transform, x);
		_mm_store_ps(row->transform + 4, y);
		_mm_store_ps(row->transform + 8, z);
		_mm_store_si128((__m128i *)&row->material, ids);
	}
}

/* Orders streaming stores before what is published next: a release store alone does not. */
static inline void render_row_drain(void)
{
	_mm_sfence();
}
#else
static inline void render_row_write(render_row *row, const stilb_mat4 *transform, uint32_t material, uint32_t mesh,
                                    uint32_t last, uint32_t model, bool stream)
{
	(void)stream;
	for (int r = 0; r < 3; r++)
		for (int c = 0; c < 4; c++)
			row->transform[4 * r + c] = transform->m[4 * c + r];
	row->material = material;
	row->mesh = mesh;
	row->last = last;
	row->model = model;
}

static inline void render_row_drain(void)
{
}
#endif

#endif
