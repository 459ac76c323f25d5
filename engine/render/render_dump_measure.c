/* Measures the cost of each kind of command of a dump: render_dump.h describes the method and the variants. */
#include "render/render_dump_format.h"
#include "render/render_internal.h"

#include <stdlib.h>
#include <string.h>

#define MEASURE_MAX_ROUNDS 2001u
#define MEASURE_LEAST_COMMANDS 16u /* two frames must differ by so many commands to tell the cost of one */

typedef enum measure_variant {
	MEASURE_REAL,
	MEASURE_FEW,
	MEASURE_PLAIN,
	MEASURE_ONE_PIPELINE,
	MEASURE_SPLIT,
	MEASURE_VARIANTS,
} measure_variant;

/* One frame: nanoseconds of each stage, and counts of the commands that the device was given. `pass` is the time in
 * which the device made its commands from all passes. */
typedef struct measure_frame {
	double record, order, pass, submit;
	uint64_t draws, runs, material_binds, pipeline_binds;
} measure_frame;

typedef struct measure_job {
	const stilb_render_dump *dump;
	stilb_render *render;
	stilb_job_pool *pool;
	uint32_t worker;
	uint32_t order[STILB_RENDER_MAX_PASSES]; /* indices of the passes in replay order */
	uint32_t lists;                          /* command buffers of a pass: 1, or one for each thread */
	/* [draws of the dump] The runs of all streams, one stream after the other; a run is a group of consecutive draws
	 * with the same bindings, and a stream is one pass as the device gets it: its runs in their final order. */
	render_run *runs;
	render_stream streams[STILB_RENDER_MAX_PASSES];
} measure_job;

/* ---- variants ---------------------------------------------------------------------------------------------------- */

/* Index of the first texture that a pass uses; 0: none. */
static uint32_t measure_first_texture(const render_pass_lists *lists)
{
	uint32_t texture = 0;
	for (uint32_t r = 0; r < lists->run_count && texture == 0; r++)
		texture = render_state_texture(lists->runs[r].state);
	return texture;
}

/* Replaces the parts of a state that choose the pipeline, so that all draws of the variant share one: the pipeline
 * number of the first draw, and a texture for every draw if any has one. *texture: the texture bound so far. */
static uint64_t measure_one_pipeline(const measure_job *job, uint64_t state, uint64_t first_state, uint32_t *texture)
{
	bool numbered = job->render->device->materials == STILB_RENDER_MATERIALS_PIPELINE;
	*texture = render_state_texture(state) ? render_state_texture(state) : *texture;
	uint64_t rest = (numbered ? first_state : state) & ~(uint64_t)RENDER_INDEX_MASK;
	return rest | *texture;
}

/* Writes the runs of a variant of a pass to `out` and returns their count. */
static uint32_t measure_runs(const measure_job *job, measure_variant variant, const render_pass_lists *lists,
                             render_run *out)
{
	uint32_t count = 0, texture = measure_first_texture(lists);
	uint64_t left = variant == MEASURE_FEW && lists->draws > job->lists ? job->lists : lists->draws;
	for (const render_run *from = lists->runs; left > 0; from++) {
		STILB_ASSERT(from < lists->runs + lists->run_count && from->count > 0);
		render_run run = *from;
		if (variant == MEASURE_ONE_PIPELINE)
			run.state = measure_one_pipeline(job, run.state, lists->runs[0].state, &texture);
		else if (variant != MEASURE_REAL)
			run.state = lists->runs[0].state;
		run.count = run.count < left ? run.count : (uint32_t)left;
		left -= run.count;
		if (variant != MEASURE_SPLIT) {
			out[count++] = run;
			continue;
		}
		for (uint32_t d = 0; d < run.count; d++)
			out[count++] = (render_run){run.first + d, 1, run.state};
	}
	return count;
}

/* Adds a pass's commands to the counts of its frame. */
static void measure_count(const render_stream *stream, stilb_render_materials materials, measure_frame *frame)
{
	/* Starts from the first run's own state, so its bindings are not counted: they are part of KIND_BEGIN's cost. */
	uint64_t state = stream->run_count > 0 ? stream->runs[0].state : 0;
	for (uint32_t r = 0; r < stream->run_count; r++) {
		uint32_t binds = render_binds_between(materials, state, stream->runs[r].state);
		frame->material_binds += (binds & RENDER_BIND_MATERIAL) != 0;
		frame->pipeline_binds += (binds & RENDER_BIND_PIPELINE) != 0;
		state = stream->runs[r].state;
	}
	frame->draws += stream->draws;
	frame->runs += stream->run_count;
}

/* Builds the streams of all passes for a variant and counts their commands into *frame. The caller does this before it
 * reads the clock, so that it times the device's work alone. */
static void measure_streams(measure_job *job, measure_variant variant, measure_frame *frame)
{
	stilb_render *render = job->render;
	render_run *runs = job->runs;
	for (uint32_t p = 0; p < job->dump->header->passes; p++) {
		const stilb_render_pass *pass = &job->dump->pass_table[job->order[p]];
		uint32_t count = measure_runs(job, variant, &render->passes[job->order[p]], runs);
		render_stream *stream = &job->streams[p];
		*stream = (render_stream){.pass = pass,
		                          .view = &job->dump->view_table[pass->view],
		                          .commands = render_commands(render),
		                          .runs = runs,
		                          .run_count = count,
		                          .states = render->passes[job->order[p]].states,
		                          .kinds = render->passes[job->order[p]].kinds};
		for (uint32_t r = 0; r < count; r++)
			stream->draws += runs[r].count;
		measure_count(stream, render->device->materials, frame);
		runs += count;
	}
	STILB_ASSERT((uint64_t)(runs - job->runs) <= job->dump->header->draws && "no more runs than draws");
}

/* ---- frames ------------------------------------------------------------------------------------------------------ */

/* Nanoseconds since *start, which becomes now. */
static double measure_since(uint64_t *start)
{
	uint64_t now = stilb_time_ns(), before = *start;
	*start = now;
	return (double)(now - before);
}

static stilb_result measure_order_pass(const measure_job *job, uint32_t index)
{
	const stilb_render_pass *pass = &job->dump->pass_table[index];
	const stilb_render_view *view = &job->dump->view_table[pass->view];
	stilb_result result = render_order(job->render, pass, &job->render->passes[index]);
	return result == STILB_OK ? render_maps_order(job->render, view, pass->sort, &job->render->passes[index]) : result;
}

static stilb_result measure_order(measure_job *job)
{
	stilb_result result = render_memory_place(job->render);
	for (uint32_t p = 0; p < job->dump->header->passes && result == STILB_OK; p++)
		result = measure_order_pass(job, job->order[p]);
	return result;
}

/* Runs and times one frame. Without `submit` its commands are recorded and not given to the device. */
static stilb_result measure_frame_run(measure_job *job, measure_variant variant, bool submit, measure_frame *frame)
{
	render_device *device = job->render->device;
	*frame = (measure_frame){.submit = (double)NAN};
	stilb_result result = stilb_render_wait(job->render);
	if (result == STILB_OK)
		result = stilb_render_frame_begin(job->render);
	uint64_t clock = stilb_time_ns();
	if (result == STILB_OK)
		result = stilb_render_dump_record(job->dump, job->render, job->pool, job->worker);
	frame->record = measure_since(&clock);
	if (result == STILB_OK)
		result = measure_order(job);
	frame->order = measure_since(&clock);
	if (result != STILB_OK)
		return result;
	measure_streams(job, variant, frame);
	clock = stilb_time_ns();
	for (uint32_t p = 0; p < job->dump->header->passes && result == STILB_OK; p++)
		result = render_device_pass(device, &job->streams[p]);
	device->gpu->keep_back = !submit;
	if (result == STILB_OK)
		result = render_device_run(device, job->pool, job->worker);
	device->gpu->keep_back = false;
	double given = (double)stilb_gpu_stats_get(device->gpu).submit_ns;
	frame->pass = measure_since(&clock) - given;
	if (submit)
		frame->submit = given;
	return result;
}

/* ---- numbers ----------------------------------------------------------------------------------------------------- */

enum { KIND_RECORD, KIND_ORDER, KIND_BEGIN, KIND_DRAW, KIND_INDIRECT, KIND_MATERIAL, KIND_PIPELINE, KIND_SUBMIT };
static_assert(KIND_SUBMIT + 1 == STILB_RENDER_DUMP_COSTS, "one row a kind");

/* What one round gives, in nanoseconds: ns, the cost of one command of each kind (KIND_...), NAN where it is unknown;
 * frame, the time of the whole frame `real` without its submission. */
typedef struct measure_round {
	double ns[STILB_RENDER_DUMP_COSTS], frame;
} measure_round;

/* The cost of one command, ns, from two frames that differ only in how many of them they have: count_with and
 * count_without. NAN: the difference is too small to tell. */
static double measure_difference(const measure_frame *with, const measure_frame *without, uint64_t count_with,
                                 uint64_t count_without)
{
	if (count_with < count_without + MEASURE_LEAST_COMMANDS)
		return (double)NAN;
	return (with->pass - without->pass) / (double)(count_with - count_without);
}

/* Cost of a pipeline bind, ns: the frame `real` has more of them than `one`, the variant with one pipeline; it may have
 * more material binds too, whose cost is subtracted. NAN: the difference is too small to tell. */
static double measure_pipeline(const measure_frame *real, const measure_frame *one, double material_ns)
{
	uint64_t materials = real->material_binds - one->material_binds;
	if (real->pipeline_binds < one->pipeline_binds + MEASURE_LEAST_COMMANDS)
		return (double)NAN;
	double binds = materials == 0 ? 0.0 : (double)materials * material_ns;
	return (real->pass - one->pass - binds) / (double)(real->pipeline_binds - one->pipeline_binds);
}

/* The costs from the frames of one round, one frame of each variant; NAN where unknown. */
static measure_round measure_divide(const measure_job *job, const measure_frame frames[MEASURE_VARIANTS])
{
	const measure_frame *real = &frames[MEASURE_REAL], *few = &frames[MEASURE_FEW], *plain = &frames[MEASURE_PLAIN];
	const measure_frame *one = &frames[MEASURE_ONE_PIPELINE], *split = &frames[MEASURE_SPLIT];
	bool indirect = job->render->device->replay == STILB_RENDER_REPLAY_INDIRECT;
	double material_ns = measure_difference(one, plain, one->material_binds, plain->material_binds);
	double draws = (double)real->draws, lists = (double)job->lists * job->dump->header->passes;
	return (measure_round){
		.ns = {[KIND_RECORD] = draws > 0 ? real->record / draws : (double)NAN,
	           [KIND_ORDER] = draws > 0 ? real->order / draws : (double)NAN,
	           [KIND_BEGIN] = few->pass / lists,
	           [KIND_DRAW] = indirect ? (double)NAN : measure_difference(plain, few, plain->draws, few->draws),
	           [KIND_INDIRECT] = indirect ? measure_difference(split, few, split->runs, few->runs) : (double)NAN,
	           [KIND_MATERIAL] = material_ns,
	           [KIND_PIPELINE] = measure_pipeline(real, one, material_ns),
	           [KIND_SUBMIT] = real->submit},
		.frame = real->record + real->order + real->pass,
	};
}

static int measure_compare(const void *a, const void *b)
{
	double x = *(const double *)a, y = *(const double *)b;
	return (x > y) - (x < y);
}

/* Sorts values[count] and fills in their median and quartiles, by nearest rank; without values the cost is unknown. */
static void measure_summarise(double *values, uint32_t count, stilb_render_dump_cost *cost)
{
	qsort(values, count, sizeof *values, measure_compare);
	cost->known = count > 0;
	if (count == 0)
		return;
	cost->low = values[(count - 1) / 4];
	cost->ns = values[(count - 1) / 2];
	cost->high = values[(count - 1) - (count - 1) / 4];
}

static void measure_rows(const measure_job *job, const measure_round *rounds, const measure_frame *real, double *values,
                         stilb_render_dump_costs *costs)
{
	bool secondary = job->render->device->replay == STILB_RENDER_REPLAY_SECONDARY;
	bool indirect = job->render->device->replay == STILB_RENDER_REPLAY_INDIRECT;
	uint32_t passes = job->dump->header->passes;
	stilb_render_dump_cost rows[STILB_RENDER_DUMP_COSTS] = {
		[KIND_RECORD] = {"record a draw", "real: its recording", real->draws, false, 0, 0, 0},
		[KIND_ORDER] = {"order a draw", "real: its ordering", real->draws, false, 0, 0, 0},
		[KIND_BEGIN] = {secondary ? "execute" : "begin a pass",
	                    secondary ? "few: begin, first binds, end, execute"
	                              : "few: targets, buffers, first binds, a draw",
	                    secondary ? (uint64_t)passes * job->lists : passes, false, 0, 0, 0},
		[KIND_DRAW] = {"draw", "plain - few", indirect ? 0 : real->draws, false, 0, 0, 0},
		[KIND_INDIRECT] = {"draw indirect", "split - few", indirect ? real->runs : 0, false, 0, 0, 0},
		[KIND_MATERIAL] = {"bind a material", "one pipeline - plain", real->material_binds, false, 0, 0, 0},
		[KIND_PIPELINE] = {"bind a pipeline", "real - one pipeline", real->pipeline_binds, false, 0, 0, 0},
		[KIND_SUBMIT] = {"submit", "real: the call", 1, false, 0, 0, 0},
	};
	memcpy(costs->kinds, rows, sizeof rows);
	for (int k = 0; k < STILB_RENDER_DUMP_COSTS; k++) {
		uint32_t count = 0;
		for (uint32_t r = 0; r < costs->rounds; r++)
			if (!isnan(rounds[r].ns[k]))
				values[count++] = rounds[r].ns[k];
		measure_summarise(values, count, &costs->kinds[k]);
	}
	for (uint32_t r = 0; r < costs->rounds; r++)
		values[r] = rounds[r].frame;
	stilb_render_dump_cost frame = {0};
	measure_summarise(values, costs->rounds, &frame);
	costs->frame_ns = frame.ns;
}

static stilb_result measure_rounds(measure_job *job, double seconds, measure_round *rounds, double *values,
                                   stilb_render_dump_costs *costs)
{
	measure_frame frames[MEASURE_VARIANTS] = {0};
	bool indirect = job->render->device->replay == STILB_RENDER_REPLAY_INDIRECT;
	uint64_t end = 0;
	costs->rounds = 0;
	while (costs->rounds < MEASURE_MAX_ROUNDS &&
	       (costs->rounds < STILB_RENDER_DUMP_MIN_ROUNDS || stilb_time_ns() < end)) {
		bool submit = costs->rounds < STILB_RENDER_DUMP_MIN_ROUNDS; /* not in all: drawing may take the device long */
		for (int v = 0; v < MEASURE_VARIANTS; v++) {
			if (v == MEASURE_SPLIT && !indirect)
				continue;
			stilb_result result = measure_frame_run(job, (measure_variant)v, submit && v == MEASURE_REAL, &frames[v]);
			if (result != STILB_OK)
				return result;
		}
		rounds[costs->rounds++] = measure_divide(job, frames);
		if (submit)
			end = stilb_time_ns() + (uint64_t)(seconds * 1e9);
	}
	measure_rows(job, rounds, &frames[MEASURE_REAL], values, costs);
	return stilb_render_wait(job->render);
}

/* Draws a frame by the public calls, before anything is measured: this uploads the resources, and tells the order in
 * which the passes are replayed. */
static stilb_result measure_first_frame(measure_job *job)
{
	stilb_result result = stilb_render_frame_begin(job->render);
	if (result == STILB_OK)
		result = stilb_render_dump_record(job->dump, job->render, job->pool, job->worker);
	if (result == STILB_OK)
		result = stilb_render_dump_replay(job->dump, job->render, job->pool, job->worker);
	STILB_ASSERT(result != STILB_OK || job->render->replayed_count == job->dump->header->passes);
	memcpy(job->order, job->render->replayed, sizeof job->order);
	return result;
}

/* The whole measurement. rounds and values: [MEASURE_MAX_ROUNDS]. They and job->runs may be NULL, which means that
 * there was no memory for them. */
static stilb_result measure_all(measure_job *job, double seconds, measure_round *rounds, double *values,
                                stilb_render_dump_costs *costs)
{
	if (!job->runs || !rounds || !values)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for measuring the commands of a dump");
	stilb_result result = measure_first_frame(job);
	return result == STILB_OK ? measure_rounds(job, seconds, rounds, values, costs) : result;
}

stilb_result stilb_render_dump_measure(const stilb_render_dump *dump, stilb_render *render, stilb_job_pool *pool,
                                       uint32_t worker, double seconds, stilb_render_dump_costs *costs)
{
	STILB_ASSERT_OWNER(render->owner);
	STILB_ASSERT(dump->ready && costs && seconds >= 0.0);
	bool secondary = render->device->replay == STILB_RENDER_REPLAY_SECONDARY;
	measure_job job = {.dump = dump,
	                   .render = render,
	                   .pool = pool,
	                   .worker = worker,
	                   .lists = secondary ? stilb_job_pool_worker_count(pool) + 1 : 1,
	                   .runs = stilb_memory_alloc(dump->header->draws, sizeof(render_run))};
	measure_round *rounds = stilb_memory_alloc(MEASURE_MAX_ROUNDS, sizeof *rounds);
	double *values = stilb_memory_alloc(MEASURE_MAX_ROUNDS, sizeof *values);
	*costs = (stilb_render_dump_costs){0};
	stilb_result result = measure_all(&job, seconds, rounds, values, costs);
	free(job.runs);
	free(rounds);
	free(values);
	return result;
}
