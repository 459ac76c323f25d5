/* The simulator of bench/sim against closed forms: what it says of programs so small that their time is a formula. */
#include "support/test.h"

#include "support/program.h"

#include "bench/sim/sim_costs.h"

#include <sched.h>
#include <unistd.h>

/* Costs with which each part of a sum can be told from its number: rows of 2 cores with one cache, 4 in a socket. */
static const sim_machine machine = {.name = "test",
                                    .cores = 4,
                                    .sockets = 2,
                                    .threads = 1,
                                    .cluster = 2,
                                    .smt = 5,
                                    .near = 10,
                                    .socket = 100,
                                    .far = 1000,
                                    .rmw = 3,
                                    .pause = 1,
                                    .block = 0,
                                    .function = 0,
                                    .call = 0,
                                    .wake = 2000,
                                    .latency = 7000,
                                    .sleep = 500,
                                    .create = 10000,
                                    .timeslice = 3e6};

/* One line each, in the simulated memory. */
typedef struct shared {
	_Alignas(64) uint32_t word[16];
	_Alignas(64) uint32_t counter;
	/* When the first thread has finished, and the last one. */
	_Alignas(64) double first, end;
} shared;

static shared *make_shared(void)
{
	return sim_allocate(64, sizeof(shared));
}

/* A thread of the program that each test writes, on a CPU of its own. */
typedef struct actor {
	shared *all;
	uint32_t cpu, number, times;
} actor;

static uint32_t start(void *(*fn)(void *), actor *a)
{
	uint32_t thread = sim_thread_create(fn, a);
	sim_thread_bind(thread, a->cpu);
	return thread;
}

static void *wake_next(void *data)
{
	actor *a = data;
	uint32_t *word = &a->all->word[a->number];
	sim_futex_wait(word, 0, UINT64_MAX);
	a->all->end = sim_now();
	word[1] = 1;
	sim_futex_wake(word + 1, 1);
	return NULL;
}

/* What a program has measured; it runs on a stack of its own, where no assert may fail. */
typedef struct result {
	double time;
	uint64_t count;
} result;

/* Five threads sleep; each that wakes up wakes the next. */
static void chain(void *data)
{
	enum { LINKS = 5 };
	shared *all = make_shared();
	actor actors[LINKS];
	uint32_t threads[LINKS];
	for (uint32_t i = 0; i < LINKS; i++) {
		actors[i] = (actor){.all = all, .cpu = i + 1, .number = i};
		threads[i] = start(wake_next, &actors[i]);
	}
	sim_sleep(1e6);
	sim_take_counts();
	double begin = sim_now();
	sim_futex_wake(all->word, 1);
	for (uint32_t i = 0; i < LINKS; i++)
		sim_thread_join(threads[i]);
	*(result *)data = (result){.time = all->end - begin, .count = sim_take_counts().wakes};
}

static void test_a_chain_of_n_wakes_costs_n_wakes(void **state)
{
	(void)state;
	result r = {0};
	sim_run(&machine, 8, chain, &r);
	assert_true(r.time == 5 * machine.latency);
	assert_int_equal(r.count, 5);
}

#define START_NS 1e6 /* by then all threads exist, and wait */

static void start_together(void)
{
	sim_work(START_NS - sim_now());
}

static void finish(shared *all)
{
	double now = sim_now();
	all->end = all->end < now ? now : all->end;
}

static void *play(void *data)
{
	actor *a = data;
	start_together();
	for (uint32_t i = 0; i < a->times; i++) {
		/* Waits until the word says that it is this thread's turn; its own transfers are those of the line. */
		while (sim_read(a->all->word, NULL), a->all->word[0] % 2 != a->number)
			sim_pause();
		sim_rmw(a->all->word, NULL);
		a->all->word[0]++;
	}
	finish(a->all);
	return NULL;
}

typedef struct match {
	uint32_t cpu;
	double time;
	uint64_t transfers;
} match;

static void ping_pong(void *data)
{
	enum { TIMES = 100 };
	match *m = data;
	shared *all = make_shared();
	actor other = {.all = all, .cpu = m->cpu, .number = 1, .times = TIMES}, self = {.all = all, .times = TIMES};
	uint32_t thread = start(play, &other);
	sim_take_counts();
	play(&self);
	sim_thread_join(thread);
	m->time = (all->end - START_NS) / (2.0 * TIMES);
	m->transfers = sim_take_counts().transfers;
}

/* Two CPUs pass a line to and fro: each time the reader fetches it and then takes it from the other one, which has a
 * copy. So a pass costs two transfers over their distance, the read-modify-write, and a pause at most. */
static void test_a_pass_costs_the_transfers_over_the_distance(void **state)
{
	(void)state;
	static const struct {
		uint32_t cpu;
		double distance;
	} cases[] = {{1, 10}, {2, 100}, {4, 1000}};
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
		match m = {.cpu = cases[i].cpu};
		sim_run(&machine, 8, ping_pong, &m);
		double least = 2 * cases[i].distance + machine.rmw;
		assert_true(m.time > 0.97 * least && m.time < 1.03 * least + machine.pause);
		assert_in_range(m.transfers, 390, 410);
	}
}

static void *add(void *data)
{
	actor *a = data;
	start_together();
	for (uint32_t i = 0; i < a->times; i++) {
		sim_rmw(&a->all->counter, NULL);
		a->all->counter++;
	}
	finish(a->all);
	return NULL;
}

static void counter(void *data)
{
	enum { THREADS = 2, TIMES = 18000 };
	shared *all = make_shared();
	actor actors[THREADS];
	uint32_t threads[THREADS];
	for (uint32_t i = 0; i < THREADS; i++) {
		actors[i] = (actor){.all = all, .cpu = 2 * i + 1, .times = TIMES};
		threads[i] = start(add, &actors[i]);
	}
	for (uint32_t i = 0; i < THREADS; i++)
		sim_thread_join(threads[i]);
	*(result *)data = (result){.time = (all->end - START_NS) / (THREADS * TIMES), .count = all->counter};
}

/* Two CPUs with a distance of 100 ns add to one counter. Each gets the line in 100 ns, and until it leaves, half that
 * time after its first addition, begins one every 3 ns: 18 additions of both in 103 ns. */
static void test_additions_to_one_counter_follow_one_another(void **state)
{
	(void)state;
	result r = {0};
	sim_run(&machine, 8, counter, &r);
	assert_int_equal(r.count, 36000);
	double turn = (machine.socket + machine.rmw) / 18;
	assert_true(r.time > 0.97 * turn && r.time < 1.03 * turn);
}

static void *compute(void *data)
{
	actor *a = data;
	sim_work(1e7);
	if (a->all->first == 0.0)
		a->all->first = sim_now();
	finish(a->all);
	return NULL;
}

static void shared_cpu(void *data)
{
	shared *all = make_shared();
	actor a = {.all = all, .cpu = 1};
	uint32_t one = start(compute, &a), two = start(compute, &a);
	double begin = sim_now();
	sim_thread_join(one);
	sim_thread_join(two);
	((double *)data)[0] = all->first - begin;
	((double *)data)[1] = all->end - begin;
}

static void test_threads_that_share_a_cpu_take_turns(void **state)
{
	(void)state;
	double times[2] = {0.0};
	sim_run(&machine, 2, shared_cpu, times);
	assert_true(times[0] > 2e7 - 2 * machine.timeslice && times[0] < times[1] - 1e5);
	assert_true(times[1] > 1.99e7 && times[1] < 2.01e7);
}

static void everything(void *data)
{
	result *results = data;
	chain(&results[0]);
	match m = {.cpu = 4};
	ping_pong(&m);
	results[1].time = m.time;
	counter(&results[2]);
}

static void test_a_run_repeats(void **state)
{
	(void)state;
	result first[3] = {{0}}, second[3] = {{0}};
	sim_run(&machine, 8, everything, first);
	sim_run(&machine, 8, everything, second);
	assert_memory_equal(first, second, sizeof first);
}

static void test_nearer_is_cheaper_on_every_machine(void **state)
{
	(void)state;
	assert_true(sim_machine_count >= 4);
	for (size_t i = 0; i < sim_machine_count; i++) {
		const sim_machine *m = &sim_machines[i];
		assert_true(m->near <= m->socket && m->socket <= m->far && m->cores % m->cluster == 0);
	}
}

static const char *simulator, *measurer;

/* The number that the program prints for a case on 8 CPUs of a machine: flag is --machine or --costs. */
static double value_on(const char *flag, const char *value_of_flag, const char *name, program_run *run)
{
	const char *words[] = {simulator, flag, value_of_flag, "--cores", "8", "--case", name, "--json", NULL};
	assert_true(program_start(run, words, NULL, -1));
	program_wait(run);
	assert_int_equal(run->code, 0);
	const char *value = strstr(run->out, "\"value\":");
	assert_non_null(value);
	return strtod(value + strlen("\"value\":"), NULL);
}

static double value_of(const char *name, program_run *run)
{
	return value_on("--machine", "epyc", name, run);
}

/* The pool itself: loops cost what their slices take on 8 CPUs and a little more, and twice the same. */
static void test_the_pool_runs_on_simulated_cpus(void **state)
{
	(void)state;
	static program_run first, second;
	double join = value_of("join-64", &first);
	assert_true(join > 8.0 && join < 16.0);
	assert_true(value_of("join-64", &second) == join);
	assert_string_equal(first.out, second.out);
	double phase = value_of("phase", &first);
	assert_true(phase > 20.0 && phase < 7 * 27.0); /* between one wake-up and a chain of seven */
}

/* ---- files of costs ---------------------------------------------------------------------------------------------- */

/* A file with this text, to be unlinked. */
static const char *file_with(const char *text)
{
	static char path[32];
	strcpy(path, "sim_costs_XXXXXX");
	int fd = mkstemp(path);
	assert_true(fd >= 0);
	assert_int_equal(write(fd, text, strlen(text)), (ssize_t)strlen(text));
	close(fd);
	return path;
}

static const sim_machine *epyc(void)
{
	size_t i = 0;
	while (strcmp(sim_machines[i].name, "epyc") != 0)
		i++;
	return &sim_machines[i];
}

/* The text of a machine's costs. */
static const char *text_of(const sim_machine *m)
{
	static char text[2048];
	FILE *out = fmemopen(text, sizeof text, "w");
	assert_non_null(out);
	sim_costs_write(out, m);
	fclose(out);
	return text;
}

static void test_a_machine_from_a_file_costs_what_the_table_says(void **state)
{
	(void)state;
	static program_run run;
	const char *path = file_with(text_of(epyc()));
	double value = value_on("--costs", path, "join-64", &run);
	unlink(path);
	assert_true(value == value_of("join-64", &run));
}

/* Runs the program with a file of this text, which it must refuse with these words. */
static void refuses(const char *text, const char *words)
{
	static program_run run;
	const char *path = file_with(text);
	const char *line[] = {simulator, "--costs", path, NULL};
	assert_true(program_start(&run, line, NULL, -1));
	program_wait(&run);
	unlink(path);
	assert_int_equal(run.code, 2);
	assert_string_equal(run.out, "");
	assert_non_null(strstr(run.err, words));
	assert_non_null(strstr(run.err, path));
}

/* The costs of epyc, and this line at the end. */
static const char *and_line(const char *line)
{
	static char text[4096];
	snprintf(text, sizeof text, "%s%s\n", text_of(epyc()), line);
	return text;
}

/* The costs of epyc with another near. */
static const char *with_near(double near)
{
	sim_machine m = *epyc();
	m.near = near;
	return text_of(&m);
}

static void test_bad_files_of_costs_are_refused(void **state)
{
	(void)state;
	refuses("", "has no line for cores");
	refuses("cores 2.5\n", "line 1 has a number that is not whole or not in 1..256");
	refuses("# a comment\n\ncores 300\n", "line 3 has a number that is not whole or not in 1..256");
	refuses(and_line("colour 3"), "line 19 has a name that is no cost");
	refuses(and_line("near 3"), "line 19 has a cost that an earlier line has");
	refuses(and_line("near"), "line 19 is not a name and a number");
	refuses(and_line("near 3 4"), "line 19 is not a name and a number");
	refuses("near nan\n", "line 1 has a time that is not in 0..1e9 ns");
	refuses("near -1\n", "line 1 has a time that is not in 0..1e9 ns");
	refuses(with_near(200), "near, socket and far are not in rising order");
}

/* What is measured here is a file that the simulator reads. */
static void test_this_machine_can_be_measured(void **state)
{
	(void)state;
	static program_run run;
	cpu_set_t allowed;
	assert_int_equal(sched_getaffinity(0, sizeof allowed, &allowed), 0);
	if (CPU_COUNT(&allowed) < 2)
		skip();
	const char *words[] = {measurer, "--costs", NULL};
	assert_true(program_start(&run, words, NULL, -1));
	program_wait(&run);
	assert_int_equal(run.code, 0);
	sim_machine m = {0};
	const char *path = file_with(run.out);
	bool read = sim_costs_read(&m, path);
	unlink(path);
	assert_true(read);
	assert_true(m.rmw > 0.3 && m.pause > 0.1 && m.near > 1.0 && m.wake > 100.0 && m.latency > 0.0 && m.create > 100.0);
}

int main(int argc, char **argv)
{
	if (argc != 3) {
		fprintf(stderr, "usage: test_bench_sim STILB-BENCH-SIM STILB-BENCH-SIM-HERE\n");
		return 1;
	}
	simulator = argv[1];
	measurer = argv[2];
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_a_chain_of_n_wakes_costs_n_wakes),
		cmocka_unit_test(test_a_pass_costs_the_transfers_over_the_distance),
		cmocka_unit_test(test_additions_to_one_counter_follow_one_another),
		cmocka_unit_test(test_threads_that_share_a_cpu_take_turns),
		cmocka_unit_test(test_a_run_repeats),
		cmocka_unit_test(test_nearer_is_cheaper_on_every_machine),
		cmocka_unit_test(test_the_pool_runs_on_simulated_cpus),
		cmocka_unit_test(test_a_machine_from_a_file_costs_what_the_table_says),
		cmocka_unit_test(test_bad_files_of_costs_are_refused),
		cmocka_unit_test(test_this_machine_can_be_measured),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
