/* The suite `queue`: the goals (bounds of the measured numbers), each printed as met or missed. */
#include "bench/queue/bench_queue.h"

#define COUNT(array) (sizeof(array) / sizeof *(array))

/* The subject's throughput divided by that of the fastest of the others must be at least `times`. */
typedef struct ratio_goal {
	const char *subject, *on;
	const char *others[3];
	double times;
} ratio_goal;

#define LINEARISABLE                                                                                                   \
	{                                                                                                                  \
		"ck_fifo", "tbb", "boost"                                                                                      \
	}

static const ratio_goal ratio_goals[] = {
	{"stilb-low-lock", "1P1C", {"moodycamel-tokens"}, 2.5},
	{"stilb-low-lock", "2P2C", {"moodycamel-tokens"}, 1.3},
	{"stilb-low-lock", "4P4C", {"moodycamel-tokens"}, 1.5},
	{"stilb-low-lock", "8P8C", {"moodycamel-tokens"}, 1.5},
	{"stilb-low-lock", "pinned-1P1C", {"moodycamel-tokens"}, 2.5},
	{"stilb-low-lock", "pinned-2P2C", {"moodycamel-tokens"}, 1.2},
	{"stilb-low-lock", "1P1C", LINEARISABLE, 8.0},
	{"stilb-low-lock", "2P2C", LINEARISABLE, 7.0},
	{"stilb-low-lock", "4P4C", LINEARISABLE, 7.0},
	{"stilb-low-lock", "8P8C", LINEARISABLE, 7.0},
	{"stilb-low-lock", "1P1C", {"sutter"}, 15.0},
	{"stilb-low-lock", "2P2C", {"sutter"}, 15.0},
	{"stilb-low-lock", "4P4C", {"sutter"}, 15.0},
	{"stilb-low-lock", "8P8C", {"sutter"}, 15.0},
	{"stilb-low-lock", "pinned-1P1C", {"sutter"}, 15.0},
	{"stilb-low-lock", "pinned-2P2C", {"sutter"}, 15.0},
	{"stilb-low-lock", "batch16-1P1C", {"moodycamel-bulk"}, 2.0},
	{"stilb-low-lock", "batch16-2P2C", {"moodycamel-bulk"}, 1.0},
	{"stilb-low-lock", "batch16-4P4C", {"moodycamel-bulk"}, 1.0},
	{"stilb-low-lock", "batch16-8P8C", {"moodycamel-bulk"}, 1.0},
};

/* The median of the subject's metric must be at most `most`. */
typedef struct value_goal {
	const char *subject, *on, *metric;
	double most;
} value_goal;

static const value_goal value_goals[] = {
	{"stilb-low-lock", "latency-4P4C", "push-p99.9", 250.0},  {"stilb-low-lock", "latency-4P4C", "pop-p99.9", 100.0},
	{"stilb-lock-free", "latency-4P4C", "push-p99.9", 400.0}, {"stilb-lock-free", "latency-4P4C", "pop-p99.9", 150.0},
	{"stilb-lock-free", "stall-4P4C", "push-gap", 8.0},       {"stilb-lock-free", "stall-4P4C", "pop-gap", 8.0},
};

/* The subject's slowest run must have at least this share of the median throughput. */
typedef struct steady_goal {
	const char *subject, *on;
	double share;
} steady_goal;

static const steady_goal steady_goals[] = {
	{"stilb-low-lock", "8P8C", 0.7},  {"stilb-lock-free", "8P8C", 0.6},        {"stilb-low-lock", "1P1C", 0.5},
	{"stilb-low-lock", "2P2C", 0.5},  {"stilb-low-lock", "4P4C", 0.5},         {"stilb-low-lock", "pinned-1P1C", 0.5},
	{"stilb-lock-free", "1P1C", 0.5}, {"stilb-low-lock", "pinned-2P2C", 0.5},  {"stilb-lock-free", "2P2C", 0.5},
	{"stilb-lock-free", "4P4C", 0.5}, {"stilb-lock-free", "pinned-1P1C", 0.5}, {"stilb-lock-free", "pinned-2P2C", 0.5},
};

static const char *verdict(bool met)
{
	return met ? "met" : "MISSED";
}

/* The row of the fastest of goal->others; NULL if none of them ran. */
static const bench_row *fastest(const bench_results *results, const ratio_goal *goal)
{
	const bench_row *best = NULL;
	for (size_t i = 0; i < COUNT(goal->others) && goal->others[i]; i++) {
		const bench_row *row = bench_find(results, goal->on, goal->others[i], "throughput");
		if (row && (!best || row->median > best->median))
			best = row;
	}
	return best;
}

static void print_ratio_goal(FILE *out, const bench_results *results, const ratio_goal *goal)
{
	const bench_row *our = bench_find(results, goal->on, goal->subject, "throughput"), *their = fastest(results, goal);
	bench_ratio ratio;
	if (our && their && bench_paired_ratio(results, our, their, &ratio))
		fprintf(out, "  %-16s %-20s throughput / %-20s >= %5.2f: %6.2f [%.2f-%.2f] %s\n", goal->subject, goal->on,
		        their->name, goal->times, ratio.median, ratio.min, ratio.max, verdict(ratio.median >= goal->times));
}

static void print_value_goal(FILE *out, const bench_results *results, const value_goal *goal)
{
	const bench_row *row = bench_find(results, goal->on, goal->subject, goal->metric);
	const bench_row *counter = bench_find(results, goal->on, "counter", goal->metric);
	if (!row)
		return;
	fprintf(out, "  %-16s %-20s %-10s, %-21s <= %5.4g: %6.3g [%.3g-%.3g] %s", goal->subject, goal->on, goal->metric,
	        row->unit, goal->most, row->median, row->min, row->max, verdict(row->median <= goal->most));
	if (counter)
		fprintf(out, " (bare counter: %.3g [%.3g-%.3g])", counter->median, counter->min, counter->max);
	fputc('\n', out);
}

static void print_steady_goal(FILE *out, const bench_results *results, const steady_goal *goal)
{
	const bench_row *row = bench_find(results, goal->on, goal->subject, "throughput");
	const bench_row *counter = bench_find(results, goal->on, "counter", "throughput");
	if (!row)
		return;
	double share = row->min / row->median;
	fprintf(out, "  %-16s %-20s worst run / median                >= %5.2f: %6.2f %s", goal->subject, goal->on,
	        goal->share, share, verdict(share >= goal->share));
	if (counter)
		fprintf(out, " (bare counter: %.2f)", counter->min / counter->median);
	fputc('\n', out);
}

void bench_queue_goals(FILE *out, const bench_results *results)
{
	fprintf(out, "\ngoals, set on the CPU named in docs/benchmarks.md; median [least-most] of the rounds\n");
	for (size_t i = 0; i < COUNT(ratio_goals); i++)
		print_ratio_goal(out, results, &ratio_goals[i]);
	for (size_t i = 0; i < COUNT(value_goals); i++)
		print_value_goal(out, results, &value_goals[i]);
	for (size_t i = 0; i < COUNT(steady_goals); i++)
		print_steady_goal(out, results, &steady_goals[i]);
}
