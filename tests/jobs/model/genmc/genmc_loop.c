/* Two loops of two slices, one after the other in the same place, and a thread that helps with either: genmc.h. */
#include "genmc.h"

#include "jobs/job_park.h"
#define job_idle_awake(list) ((list)->workers) /* for -O1 makes an instruction of it that GenMC does not know */
#include "jobs/job_for.c"

#undef NDEBUG
#include <assert.h>

enum { LOOPS = 2, SLICES = 2 };

const job_scope job_scope_all = {.all = true, .jobs = true, .high = true};
typedef struct loop_data {
	int input, output[SLICES]; /* the input is written before the loop, the output by its slices */
} loop_data;

static job_loop loop;
static job_slot owner;
static loop_data data_of[LOOPS];

static void slice(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	(void)worker;
	loop_data *data = context;
	assert(data->input == 1 && end == begin + 1);
	data->output[begin]++;
}

static void *help(void *unused)
{
	(void)unused;
	loop_span span;
	for (int looks = 0; looks < LOOPS; looks++) {
		if (!loop_claim(&loop, &job_scope_all, 2, 0, &span))
			continue;
		span_run(&span, 1);
		loop_count(&loop, &owner, span.slices);
	}
	return NULL;
}

/* As stilb_job_parallel_for does it. wanted: the slices that the helper has to finish, of all loops so far. */
static void run_loop(int number, uint64_t *wanted)
{
	loop_span span = {
		.fn = slice, .context = &data_of[number], .count = SLICES, .grain = 1, .wake_slices = 1, .left = SLICES};
	data_of[number].input = 1;
	loop_open(&loop, &span, SLICES, 1);
	*wanted += SLICES;
	for (; loop_claim(&loop, &job_scope_all, 2, 1, &span); (*wanted)--)
		span_run(&span, 0);
	__VERIFIER_assume(loop_finished(&loop, *wanted));
	for (int i = 0; i < SLICES; i++)
		assert(data_of[number].output[i] == 1);
}

int main(void)
{
	pthread_t helper;
	uint64_t wanted = 0;
	pthread_create(&helper, NULL, help, NULL);
	for (int i = 0; i < LOOPS; i++)
		run_loop(i, &wanted);
	pthread_join(helper, NULL);
	return 0;
}
