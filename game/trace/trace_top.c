/* stilb trace top: the zones of a trace in the order of the time that they take. */
#include "game/cli/flags.h"
#include "trace.h"

#include "base/base_file.h"
#include "profiler/prof_stats.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

typedef struct top_options {
	const char *file, *frame, *lane, *json;
	uint64_t lines;
	int sort;
} top_options;

/* How long jobs waited in a queue, from their submission until a worker began to run them. */
typedef struct top_delays {
	uint32_t jobs;
	uint64_t p50_ns, p99_ns, max_ns;
} top_delays;

typedef struct top_run {
	top_options options;
	stilb_prof_snapshot trace;
	stilb_prof_stats stats;
	stilb_prof_stats_range range;
	uint64_t self_ns; /* sum of the self times of all rows */
	top_delays delays;
} top_run;

static const char *const sort_choices[] = {"total", "self", "off-cpu", "calls", "p50", "p99", "max", "name", NULL};

static flags_result top_parse(top_options *o, int argc, char **argv)
{
	const flag flags[] = {
		{"--sort", FLAG_CHOICE, &o->sort, "KEY", "total, self, off-cpu, calls, p50, p99, max or name (self)", 0, 0,
	     sort_choices},
		{"--lines", FLAG_NUMBER, &o->lines, "N", "zones to list, 1..1000000 (30)", 1, 1000000, NULL},
		{"--frame", FLAG_TEXT, &o->frame, "N|slowest", "only zones charged to that frame (all)", 0, 0, NULL},
		{"--lane", FLAG_TEXT, &o->lane, "NAME", "only zones of the thread or device of that name (all)", 0, 0, NULL},
		{"--json", FLAG_TEXT, &o->json, "FILE", "all rows as JSON; - is standard output", 0, 0, NULL},
	};
	size_t count = sizeof flags / sizeof *flags;
	flags_result result = flags_parse(flags, count, argc, argv);
	if (result == FLAGS_HELP) {
		printf("stilb trace top FILE [FLAGS]: lists the zones that take the most time. FILE is what 'stilb demo\n"
		       "--trace' wrote, or Chrome trace JSON of another program; - is standard input.\n\n");
		flags_print(flags, count);
	}
	return result;
}

static bool top_choose_frame(top_run *run)
{
	if (!run->options.frame)
		return true;
	run->range.frame_count = 1;
	return trace_choose_frame(&run->trace, run->options.file, run->options.frame, &run->range.first_frame);
}

static bool top_choose_lane(top_run *run)
{
	if (!run->options.lane)
		return true;
	for (uint32_t i = 0; i < run->trace.lane_count; i++)
		if (strcmp(run->trace.lanes[i].name, run->options.lane) == 0) {
			run->range.first_lane = i;
			run->range.lane_count = 1;
			return true;
		}
	stilb_log("--lane: '%s' has no thread or device '%s'", run->options.file, run->options.lane);
	return false;
}

/* ---- queue delays ------------------------------------------------------------------------------------------------ */

static int top_compare_ns(const void *a, const void *b)
{
	uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
	return (x > y) - (x < y);
}

static bool top_is_in_frame(const top_run *run, uint64_t ns)
{
	const stilb_prof_stats_range *range = &run->range;
	if (range->frame_count == 0)
		return true;
	const stilb_prof_frame *frame = &run->trace.frames[range->first_frame];
	return ns >= frame->begin_ns && ns < frame->end_ns;
}

/* A flow leads from the submission of a job to its start. True if both were recorded, and the job started in the chosen
 * lane and frame. */
static bool top_has_job(const top_run *run, const stilb_prof_flow *flow)
{
	return flow->from_lane != STILB_PROF_NONE && flow->to_lane != STILB_PROF_NONE &&
	       (run->range.lane_count == 0 || flow->to_lane == run->range.first_lane) && top_is_in_frame(run, flow->to_ns);
}

static bool top_take_delays(top_run *run)
{
	const stilb_prof_snapshot *trace = &run->trace;
	top_delays *delays = &run->delays;
	uint64_t *ns = malloc(((size_t)trace->flow_count + 1) * sizeof *ns);
	if (!ns)
		return false;
	for (uint32_t i = 0; i < trace->flow_count; i++)
		if (top_has_job(run, &trace->flows[i]))
			ns[delays->jobs++] = trace->flows[i].to_ns - trace->flows[i].from_ns;
	if (delays->jobs > 0) { /* percentiles by nearest rank */
		qsort(ns, delays->jobs, sizeof *ns, top_compare_ns);
		delays->p50_ns = ns[((uint64_t)delays->jobs * 50 + 99) / 100 - 1];
		delays->p99_ns = ns[((uint64_t)delays->jobs * 99 + 99) / 100 - 1];
		delays->max_ns = ns[delays->jobs - 1];
	}
	free(ns);
	return true;
}

/* ---- output ------------------------------------------------------------------------------------------------------ */

static void top_print(FILE *out, const top_run *run)
{
	trace_print_summary(out, run->options.file, &run->trace);
	if (run->options.frame) {
		const stilb_prof_frame *frame = &run->trace.frames[run->range.first_frame];
		fprintf(out, "frame %" PRIu64 ": %.3f ms\n", frame->number, trace_ms(trace_frame_ns(frame)));
	}
	fprintf(out, "\n%9s %11s %11s %6s %11s %10s %10s %10s  zone\n", "calls", "total ms", "self ms", "self %",
	        "off-CPU ms", "p50 us", "p99 us", "max us");
	uint32_t lines = run->options.lines < run->stats.row_count ? (uint32_t)run->options.lines : run->stats.row_count;
	for (uint32_t i = 0; i < lines; i++) {
		const stilb_prof_row *row = &run->stats.rows[i];
		double share = run->self_ns > 0 ? 100.0 * (double)row->self_ns / (double)run->self_ns : 0.0;
		fprintf(out, "%9" PRIu32 " %11.3f %11.3f %6.2f %11.3f %10.3f %10.3f %10.3f  ", row->calls,
		        trace_ms(row->inclusive_ns), trace_ms(row->self_ns), share, trace_ms(row->off_cpu_ns),
		        trace_us(row->p50_ns), trace_us(row->p99_ns), trace_us(row->max_ns));
		trace_print_name(out, run->trace.labels[row->label].name, row->kind);
	}
	if (lines < run->stats.row_count)
		fprintf(out, "and %" PRIu32 " more: --lines %" PRIu32 "\n", run->stats.row_count - lines, run->stats.row_count);
	const top_delays *delays = &run->delays;
	if (delays->jobs > 0)
		fprintf(out, "\n%" PRIu32 " job%s ran after a delay of p50 %.3f us, p99 %.3f us, max %.3f us in the queue\n",
		        delays->jobs, delays->jobs == 1 ? "" : "s", trace_us(delays->p50_ns), trace_us(delays->p99_ns),
		        trace_us(delays->max_ns));
}

static stilb_result top_save(const top_run *run)
{
	stilb_json json = {0};
	stilb_json_begin(&json, NULL, '{');
	stilb_json_string(&json, "file", run->options.file);
	stilb_json_int(&json, "frames", run->trace.frame_count);
	stilb_json_int(&json, "zones", (int64_t)trace_zone_count(&run->trace));
	stilb_json_begin(&json, "queue_delay", '{');
	stilb_json_int(&json, "jobs", run->delays.jobs);
	trace_json_ns(&json, "p50_ns", run->delays.p50_ns);
	trace_json_ns(&json, "p99_ns", run->delays.p99_ns);
	trace_json_ns(&json, "max_ns", run->delays.max_ns);
	stilb_json_end(&json, '}');
	stilb_json_begin(&json, "rows", '[');
	for (uint32_t i = 0; i < run->stats.row_count; i++) {
		const stilb_prof_row *row = &run->stats.rows[i];
		stilb_json_begin(&json, NULL, '{');
		stilb_json_string(&json, "zone", run->trace.labels[row->label].name);
		stilb_json_bool(&json, "device", row->kind == STILB_PROF_LANE_DEVICE);
		stilb_json_int(&json, "calls", row->calls);
		trace_json_ns(&json, "total_ns", row->inclusive_ns);
		trace_json_ns(&json, "self_ns", row->self_ns);
		trace_json_ns(&json, "off_cpu_ns", row->off_cpu_ns);
		trace_json_ns(&json, "min_ns", row->min_ns);
		trace_json_ns(&json, "p50_ns", row->p50_ns);
		trace_json_ns(&json, "p99_ns", row->p99_ns);
		trace_json_ns(&json, "max_ns", row->max_ns);
		stilb_json_end(&json, '}');
	}
	stilb_json_end(&json, ']');
	stilb_json_end(&json, '}');
	return stilb_json_save(&json, run->options.json);
}

static bool top_take(top_run *run)
{
	if (!top_take_delays(run) || stilb_prof_stats_take(&run->stats, &run->trace, &run->range) != 0) {
		stilb_log("no memory for a table of %" PRIu64 " zones", trace_zone_count(&run->trace));
		return false;
	}
	stilb_prof_stats_sort(&run->stats, &run->trace, (stilb_prof_order)run->options.sort);
	for (uint32_t i = 0; i < run->stats.row_count; i++)
		run->self_ns += run->stats.rows[i].self_ns;
	return true;
}

static int top_main(top_run *run)
{
	const char *json = run->options.json;
	if (!trace_load(run->options.file, &run->trace) || !top_choose_frame(run) || !top_choose_lane(run))
		return EXIT_REFUSED;
	if (!top_take(run))
		return EXIT_FAILED;
	top_print(json && stilb_file_is_stdout(json) ? stderr : stdout, run);
	if (json && top_save(run) != STILB_OK) {
		stilb_log("%s", stilb_error_message());
		return EXIT_FAILED;
	}
	return EXIT_DONE;
}

int trace_top_command(int argc, char **argv)
{
	top_run run = {.options = {.lines = 30, .sort = STILB_PROF_BY_SELF}};
	trace_files files = trace_take_files(1, &argc, &argv);
	flags_result parsed = top_parse(&run.options, argc, argv);
	if (parsed == FLAGS_HELP)
		return EXIT_DONE;
	if (parsed == FLAGS_REFUSED)
		return EXIT_REFUSED;
	if (!trace_check("top", &files, run.options.json))
		return EXIT_REFUSED;
	run.options.file = files.path[0];
	int code = top_main(&run);
	stilb_prof_stats_finish(&run.stats);
	stilb_prof_snapshot_finish(&run.trace);
	return code;
}
