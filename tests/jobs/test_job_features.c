/* Features beyond submit and wait: priorities, pinned jobs, followers, arrays, outside threads, phases. With 0,
 * 1, 2 and 8 workers and both kinds of shared queues. */
#include "job_pool_fixture.h"

#include <sys/resource.h>

/* ---- priorities ------------------------------------------------------------------------------------------------ */

enum { EACH = 100, ORDERED = 3 * EACH };

typedef struct order order;

typedef struct order_job {
	order *order;
	uint32_t tag;
} order_job;

/* The tags of jobs in the order in which they start. Only one thread runs them. */
struct order {
	stilb_job_pool *pool;
	stilb_job_group group;
	uint32_t worker; /* of the thread that submits next */
	uint32_t begin, end;
	counter wrong, ran;
	uint32_t tag[ORDERED];
	order_job job[ORDERED];
};

static void note_start(void *data, uint32_t worker)
{
	order_job *job = data;
	(void)worker;
	order *o = job->order;
	o->tag[count_of(&o->ran)] = job->tag;
	count_up(&o->ran);
}

/* Submits jobs of one priority, tagged in the order of submission. */
static void submit_some(order *o, stilb_job_priority priority, uint32_t rank)
{
	for (uint32_t i = o->begin; i < o->end; i++) {
		order_job *job = &o->job[rank * EACH + i];
		*job = (order_job){o, rank * EACH + i};
		stilb_job_options options = {.priority = priority};
		if (stilb_job_submit_with(o->pool, note_start, job, &o->group, &options, o->worker) != 0)
			count_up(&o->wrong);
	}
}

static void *submit_ordered(void *data)
{
	order *o = data;
	submit_some(o, STILB_JOB_LOW, 2);
	if (o->worker == STILB_JOB_OUTSIDE) { /* the owner's jobs go to its deque, which is popped newest first */
		uint32_t begin = o->begin;
		o->begin = 0;
		submit_some(o, STILB_JOB_NORMAL, 1);
		o->begin = begin;
	}
	submit_some(o, STILB_JOB_HIGH, 0);
	return NULL;
}

static void test_priorities(void **state)
{
	(void)state;
	static order o;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		if (s.workers > 1)
			continue; /* with several threads the order of starts is not observable */
		blocker b = {0};
		o = (order){.pool = pool_with(s)};
		hold_workers(o.pool, &b, NULL, 1, s.workers);
		o.end = EACH / 2; /* half of the jobs from the owner, half from an outside thread */
		submit_ordered(&o);
		o.worker = STILB_JOB_OUTSIDE;
		o.begin = EACH / 2;
		o.end = EACH;
		outside_run(submit_ordered, &o);
		assert_int_equal(count_of(&o.ran), 0);
		blocker_release(&b);
		if (s.workers == 0)
			stilb_job_wait(o.pool, &o.group, 0);
		assert_true(await(&o.ran, ORDERED));
		for (uint32_t i = 0; i < ORDERED; i++)
			assert_int_equal(o.tag[i], i);
		assert_int_equal(o.wrong, 0);
		stilb_job_pool_destroy(o.pool);
	}
}

/* Runs children; the third one to start submits a job of high priority, which must be the next to start. */
typedef struct jumper {
	stilb_job_pool *pool;
	stilb_job_group group;
	counter wrong, ran, place; /* place: number of children that ran before the high job, plus one */
} jumper;

static void jump(void *data, uint32_t worker)
{
	jumper *j = data;
	(void)worker;
	atomic_store_explicit(&j->place, count_up(&j->ran) + 1, memory_order_release);
}

static void jumped_over(void *data, uint32_t worker)
{
	jumper *j = data;
	stilb_job_options high = {.priority = STILB_JOB_HIGH};
	if (count_up(&j->ran) == 2 && stilb_job_submit_with(j->pool, jump, j, &j->group, &high, worker) != 0)
		count_up(&j->wrong);
}

static void submit_jumped_over(void *data, uint32_t worker)
{
	jumper *j = data;
	for (int i = 0; i < 10; i++)
		if (stilb_job_submit(j->pool, jumped_over, j, &j->group, worker) != 0)
			count_up(&j->wrong);
}

static void test_high_comes_next(void **state)
{
	(void)state;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		if (s.workers > 1)
			continue;
		jumper j = {.pool = pool_with(s)};
		assert_int_equal(stilb_job_submit(j.pool, submit_jumped_over, &j, &j.group, 0), 0);
		if (s.workers == 0)
			stilb_job_wait(j.pool, &j.group, 0);
		assert_true(await(&j.ran, 11));
		assert_int_equal(j.place, 4);
		assert_int_equal(j.wrong, 0);
		stilb_job_pool_destroy(j.pool);
	}
}

/* A job that submits itself again until a job from outside has run; it must not starve that one. */
typedef struct selfish {
	stilb_job_pool *pool;
	counter wrong, turns, other, over;
} selfish;

enum { SELFISH_TURNS = 100000 };

static void again(void *data, uint32_t worker)
{
	selfish *s = data;
	if (count_of(&s->other) > 0 || count_up(&s->turns) == SELFISH_TURNS)
		count_up(&s->over);
	else if (stilb_job_submit(s->pool, again, s, NULL, worker) != 0)
		count_up(&s->wrong);
}

static void count_other(void *data, uint32_t worker)
{
	selfish *s = data;
	(void)worker;
	count_up(&s->other);
}

static void *submit_other(void *data)
{
	selfish *s = data;
	if (stilb_job_submit(s->pool, count_other, s, NULL, STILB_JOB_OUTSIDE) != 0)
		count_up(&s->wrong);
	return NULL;
}

static void test_own_jobs_starve_nobody(void **state)
{
	(void)state;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		blocker b = {0};
		selfish own = {.pool = pool_with(s)};
		hold_workers(own.pool, &b, NULL, 1, s.workers);
		outside_run(submit_other, &own);
		assert_int_equal(stilb_job_submit(own.pool, again, &own, NULL, 0), 0);
		blocker_release(&b);
		stilb_job_pool_destroy(own.pool);
		assert_int_equal(own.over, 1);
		assert_in_range(own.turns, 0, SELFISH_TURNS - 1);
		assert_int_equal(own.wrong, 0);
	}
}

/* ---- pinned jobs ----------------------------------------------------------------------------------------------- */

typedef struct pinning pinning;

typedef struct pinned_job {
	pinning *pinning;
	uint32_t target;
} pinned_job;

struct pinning {
	stilb_job_pool *pool;
	stilb_job_group group;
	uint32_t threads;
	counter ran, wrong;
	pinned_job job[MOST_THREADS];
};

static void check_target(void *data, uint32_t worker)
{
	pinned_job *job = data;
	if (worker != job->target)
		count_up(&job->pinning->wrong);
	count_up(&job->pinning->ran);
}

static void pin_to_all(void *data, uint32_t worker)
{
	pinning *p = data;
	for (uint32_t i = 0; i < p->threads; i++) {
		stilb_job_options options = {.pinned = true, .target = i};
		if (stilb_job_submit_with(p->pool, check_target, &p->job[i], &p->group, &options, worker) != 0)
			count_up(&p->wrong);
	}
}

static void *pin_to_all_from_outside(void *data)
{
	for (int i = 0; i < 50; i++)
		pin_to_all(data, STILB_JOB_OUTSIDE);
	return NULL;
}

static void pinning_init(pinning *p, stilb_job_pool *pool)
{
	*p = (pinning){.pool = pool, .threads = stilb_job_pool_worker_count(pool) + 1};
	for (uint32_t i = 0; i < p->threads; i++)
		p->job[i] = (pinned_job){p, i};
}

static void test_pinned_jobs_run_on_their_target(void **state)
{
	(void)state;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		pinning p;
		pinning_init(&p, pool_with(s));
		pthread_t outside = outside_start(pin_to_all_from_outside, &p);
		for (int i = 0; i < 50; i++)
			pin_to_all(&p, 0);
		for (int i = 0; i < 50; i++)
			assert_int_equal(stilb_job_submit(p.pool, pin_to_all, &p, &p.group, 0), 0);
		pthread_join(outside, NULL);
		stilb_job_wait(p.pool, &p.group, 0);
		assert_int_equal(p.ran, 150 * p.threads);
		assert_int_equal(p.wrong, 0);
		stilb_job_pool_destroy(p.pool);
	}
}

static void test_pinned_job_wakes_its_target(void **state)
{
	(void)state;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		sleep_log log = {0};
		pinning p;
		pinning_init(&p, pool_with_hooks(s, sleep_log_hooks(&log)));
		for (uint32_t round = 0; round < 2; round++)
			for (uint32_t i = 1; i < p.threads; i++) {
				assert_true(await(&log.asleep, s.workers));
				submit_pinned(p.pool, check_target, &p.job[i], NULL, i, 0);
				assert_true(await(&p.ran, round * s.workers + i));
			}
		assert_int_equal(p.wrong, 0);
		stilb_job_pool_destroy(p.pool);
	}
}

/* Several threads pin numbered jobs to one target thread. */
enum { PINNERS = 3, PINNED_EACH = 300 };

typedef struct pinner pinner;

typedef struct numbered {
	pinner *from;
	uint32_t number;
} numbered;

struct pinner {
	stilb_job_pool *pool;
	uint32_t target;
	uint32_t next; /* written by the target thread only */
	counter ran, wrong;
	numbered job[PINNED_EACH];
};

static void check_number(void *data, uint32_t worker)
{
	numbered *job = data;
	if (worker != job->from->target || job->number != job->from->next++)
		count_up(&job->from->wrong);
	count_up(&job->from->ran);
}

static void pin_numbered(pinner *p, uint32_t worker)
{
	for (uint32_t i = 0; i < PINNED_EACH; i++) {
		p->job[i] = (numbered){p, i};
		stilb_job_options options = {.pinned = true, .target = p->target};
		if (stilb_job_submit_with(p->pool, check_number, &p->job[i], NULL, &options, worker) != 0)
			count_up(&p->wrong);
	}
}

static void *pin_numbered_from_outside(void *data)
{
	pin_numbered(data, STILB_JOB_OUTSIDE);
	return NULL;
}

static void test_pinned_jobs_keep_their_order(void **state)
{
	(void)state;
	static pinner pinners[PINNERS];
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		pthread_t thread[PINNERS];
		stilb_job_pool *pool = pool_with(s);
		for (int i = 0; i < PINNERS; i++)
			pinners[i] = (pinner){.pool = pool, .target = s.workers};
		for (int i = 1; i < PINNERS; i++)
			thread[i] = outside_start(pin_numbered_from_outside, &pinners[i]);
		pin_numbered(&pinners[0], 0);
		for (int i = 1; i < PINNERS; i++)
			pthread_join(thread[i], NULL);
		if (s.workers == 0)
			assert_int_equal(stilb_job_run_pinned(pool, 0), PINNERS * PINNED_EACH);
		for (int i = 0; i < PINNERS; i++) {
			assert_true(await(&pinners[i].ran, PINNED_EACH));
			assert_int_equal(pinners[i].wrong, 0);
		}
		stilb_job_pool_destroy(pool);
	}
}

/* A job pinned to its own thread that submits itself again, like work to be done once in each frame. */
typedef struct each_frame {
	stilb_job_pool *pool;
	counter ran, wrong;
} each_frame;

static void submit_for_next_frame(void *data, uint32_t worker)
{
	each_frame *e = data;
	stilb_job_options options = {.pinned = true, .target = worker};
	/* A bound, so that the test ends if run_pinned also runs jobs that were submitted while it ran. */
	if (count_up(&e->ran) < 20 && stilb_job_submit_with(e->pool, submit_for_next_frame, e, NULL, &options, worker) != 0)
		count_up(&e->wrong);
}

static void run_own_pinned(void *data, uint32_t worker)
{
	pinning *p = data;
	for (int i = 0; i < 3; i++) {
		stilb_job_options options = {.pinned = true, .target = worker};
		if (stilb_job_submit_with(p->pool, check_target, &p->job[worker], NULL, &options, worker) != 0)
			count_up(&p->wrong);
	}
	if (stilb_job_run_pinned(p->pool, worker) != 3)
		count_up(&p->wrong);
}

static void test_run_pinned_says_how_many(void **state)
{
	(void)state;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		pinning p;
		pinning_init(&p, pool_with(s));
		assert_int_equal(stilb_job_run_pinned(p.pool, 0), 0);
		for (int i = 0; i < 5; i++)
			submit_pinned(p.pool, check_target, &p.job[0], &p.group, 0, 0);
		assert_int_equal(p.ran, 0);
		assert_int_equal(stilb_job_run_pinned(p.pool, 0), 5);
		assert_int_equal(p.ran, 5);
		assert_int_equal(stilb_job_run_pinned(p.pool, 0), 0);
		for (uint32_t i = 0; i <= s.workers; i++)
			submit_pinned(p.pool, run_own_pinned, &p, &p.group, i, 0);
		stilb_job_wait(p.pool, &p.group, 0);
		assert_int_equal(p.ran, 5 + 3 * p.threads);
		each_frame e = {.pool = p.pool};
		submit_pinned(p.pool, submit_for_next_frame, &e, NULL, 0, 0);
		for (uint32_t frame = 1; frame <= 3; frame++) {
			assert_int_equal(stilb_job_run_pinned(p.pool, 0), 1);
			assert_int_equal(e.ran, frame);
		}
		assert_int_equal(p.wrong, 0);
		assert_int_equal(e.wrong, 0);
		stilb_job_pool_destroy(p.pool);
	}
}

/* ---- jobs that follow a group (options.after) ------------------------------------------------------------------ */

enum { LINKS = 1000 };

typedef struct chain chain;

typedef struct chain_link {
	chain *chain;
	uint32_t number;
} chain_link;

struct chain {
	stilb_job_pool *pool;
	uint32_t worker; /* of the thread that submits */
	uint32_t length; /* not atomic: handed on from link to link */
	uint32_t wrong;
	counter refused;
	stilb_job_group gate;
	stilb_job_group group[LINKS];
	chain_link link[LINKS];
};

static void do_nothing(void *data, uint32_t worker)
{
	(void)data;
	(void)worker;
}

static void append_link(void *data, uint32_t worker)
{
	chain_link *link = data;
	(void)worker;
	if (link->chain->length++ != link->number)
		link->chain->wrong++;
}

static void *submit_chain(void *data)
{
	chain *c = data;
	for (uint32_t i = 0; i < LINKS; i++) {
		c->link[i] = (chain_link){c, i};
		stilb_job_options options = {.after = i ? &c->group[i - 1] : &c->gate};
		if (stilb_job_submit_with(c->pool, append_link, &c->link[i], &c->group[i], &options, c->worker) != 0)
			count_up(&c->refused);
	}
	return NULL;
}

static void test_chain(void **state)
{
	(void)state;
	static chain c;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s))
		for (int way = 0; way < 3; way++) {
			c = (chain){.pool = pool_with(s), .worker = way == 1 ? STILB_JOB_OUTSIDE : 0};
			if (way < 2) /* else the first link starts at once, and later ones start while others are being submitted */
				submit_pinned(c.pool, do_nothing, NULL, &c.gate, 0, 0);
			if (way == 1)
				outside_run(submit_chain, &c);
			else
				submit_chain(&c);
			if (way < 2)
				assert_int_equal(stilb_job_run_pinned(c.pool, 0), 1);
			stilb_job_wait(c.pool, &c.group[LINKS - 1], 0);
			assert_int_equal(c.length, LINKS);
			assert_int_equal(c.wrong, 0);
			assert_int_equal(c.refused, 0);
			stilb_job_pool_destroy(c.pool);
		}
}

enum { FAN = 100 };

/* One job before many, or many before one. */
typedef struct fan {
	stilb_job_pool *pool;
	stilb_job_group first, then;
	uint32_t cell[FAN]; /* not atomic: written by the preceding jobs, read by the followers */
	uint32_t next;      /* cell to write, if the owner writes */
	counter ran, wrong;
} fan;

static void write_all(void *data, uint32_t worker)
{
	fan *f = data;
	(void)worker;
	for (uint32_t i = 0; i < FAN; i++)
		f->cell[i] = i + 1;
}

static void write_cell(void *data, uint32_t worker)
{
	uint32_t *cell = data;
	(void)worker;
	nap_us(1);
	*cell = 1;
}

static void read_all(void *data, uint32_t worker)
{
	fan *f = data;
	(void)worker;
	for (uint32_t i = 0; i < FAN; i++)
		if (f->cell[i] == 0)
			count_up(&f->wrong);
	count_up(&f->ran);
}

static void test_fan_out_and_in(void **state)
{
	(void)state;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		fan out = {.pool = pool_with(s)};
		stilb_job_options after = {.after = &out.first};
		submit_pinned(out.pool, write_all, &out, &out.first, 0, 0);
		for (int i = 0; i < FAN; i++)
			assert_int_equal(stilb_job_submit_with(out.pool, read_all, &out, &out.then, &after, 0), 0);
		nap_us(1000);
		assert_int_equal(count_of(&out.ran), 0);
		assert_int_equal(stilb_job_run_pinned(out.pool, 0), 1);
		stilb_job_wait(out.pool, &out.then, 0);
		assert_int_equal(out.ran, FAN);
		assert_int_equal(out.wrong, 0);

		fan in = {.pool = out.pool};
		after.after = &in.first;
		for (int i = 0; i < FAN; i++)
			assert_int_equal(stilb_job_submit(in.pool, write_cell, &in.cell[i], &in.first, 0), 0);
		for (int i = 0; i < 3; i++)
			assert_int_equal(stilb_job_submit_with(in.pool, read_all, &in, &in.then, &after, 0), 0);
		stilb_job_wait(in.pool, &in.then, 0);
		assert_int_equal(in.ran, 3);
		assert_int_equal(in.wrong, 0);
		stilb_job_wait(in.pool, &in.first, 0); /* the group has finished: returns at once */
		stilb_job_pool_destroy(in.pool);
	}
}

/* The follower is submitted just when the group finishes. The same groups are used again and again. */
static void test_follower_of_a_group_that_finishes(void **state)
{
	(void)state;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		fan f = {.pool = pool_with(s)};
		stilb_job_options after = {.after = &f.first};
		for (uint32_t i = 1; i <= 1000; i++) {
			memset(f.cell, 0, sizeof f.cell);
			if (i % 10 > 0) /* else the follower has nothing to wait for */
				assert_int_equal(stilb_job_submit(f.pool, write_all, &f, &f.first, 0), 0);
			else
				write_all(&f, 0);
			assert_int_equal(stilb_job_submit_with(f.pool, read_all, &f, &f.then, &after, 0), 0);
			stilb_job_wait(f.pool, i % 2 ? &f.first : &f.then, 0);
			stilb_job_wait(f.pool, i % 2 ? &f.then : &f.first, 0);
			assert_int_equal(f.ran, i);
			assert_int_equal(f.wrong, 0);
			assert_int_equal(f.first.state, 0);
			assert_int_equal(f.then.state, 0);
			assert_null(f.first.after);
		}
		stilb_job_pool_destroy(f.pool);
	}
}

static void test_followers_keep_priority_and_target(void **state)
{
	(void)state;
	static order o;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		stilb_job_group gate = {0};
		o = (order){.pool = pool_with(s)};
		static const stilb_job_priority priority[] = {STILB_JOB_HIGH, STILB_JOB_NORMAL, STILB_JOB_LOW};
		submit_pinned(o.pool, do_nothing, NULL, &gate, s.workers, 0); /* its thread starts the followers */
		pinning p;
		pinning_init(&p, o.pool);
		for (uint32_t i = 0; i < p.threads; i++) {
			stilb_job_options options = {.pinned = true, .target = i, .after = &gate};
			assert_int_equal(stilb_job_submit_with(p.pool, check_target, &p.job[i], &p.group, &options, 0), 0);
		}
		stilb_job_wait(p.pool, &p.group, 0);
		assert_int_equal(p.ran, p.threads);
		assert_int_equal(p.wrong, 0);
		if (s.workers < 2) { /* a single thread runs jobs: the order is observable */
			blocker b = {0};
			stilb_job_group held = {0};
			hold_workers(o.pool, &b, &held, 1, s.workers);
			if (s.workers == 0)
				submit_pinned(o.pool, do_nothing, NULL, &held, 0, 0);
			for (uint32_t i = 0; i < 30; i++) {
				uint32_t rank = 2 - i % 3;
				o.job[i] = (order_job){&o, rank};
				stilb_job_options options = {.priority = priority[rank], .after = &held};
				assert_int_equal(stilb_job_submit_with(o.pool, note_start, &o.job[i], &o.group, &options, 0), 0);
			}
			blocker_release(&b);
			if (s.workers == 0)
				stilb_job_wait(o.pool, &o.group, 0);
			assert_true(await(&o.ran, 30));
			for (uint32_t i = 0; i < 30; i++)
				assert_int_equal(o.tag[i], i / 10);
		}
		stilb_job_pool_destroy(o.pool);
	}
}

/* ---- arrays ---------------------------------------------------------------------------------------------------- */

enum { CELLS = 5000 };

typedef struct cover {
	stilb_job_pool *pool;
	stilb_job_group *group;
	uint32_t threads, count, grain;
	counter wrong;
	counter runs[CELLS];
} cover;

static void cover_range(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	cover *c = context;
	if (begin >= end || end > c->count || end - begin > c->grain || worker >= c->threads)
		count_up(&c->wrong);
	for (uint32_t i = begin; i < end && i < CELLS; i++)
		count_up(&c->runs[i]);
}

static void submit_cover(void *data, uint32_t worker)
{
	cover *c = data;
	if (stilb_job_submit_array(c->pool, c->count, c->grain, cover_range, c, c->group, worker) != 0)
		count_up(&c->wrong);
}

static void *submit_cover_from_outside(void *data)
{
	submit_cover(data, STILB_JOB_OUTSIDE);
	return NULL;
}

static void cover_check(cover *c, uint32_t times)
{
	uint32_t bad = 0;
	for (uint32_t i = 0; i < CELLS; i++)
		bad += c->runs[i] != (i < c->count ? times : 0);
	assert_int_equal(bad, 0);
	assert_int_equal(c->wrong, 0);
}

static void test_arrays_cover_every_index_once(void **state)
{
	(void)state;
	static const uint32_t counts[] = {0, 1, 2, 63, 1000, CELLS}, grains[] = {1, 64, CELLS};
	static cover c;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		stilb_job_group group = {0};
		stilb_job_pool *pool = pool_with(s);
		for (size_t i = 0; i < sizeof counts / sizeof *counts; i++)
			for (size_t k = 0; k < sizeof grains / sizeof *grains; k++) {
				c = (cover){.pool = pool, .group = &group, .threads = s.workers + 1};
				c.count = counts[i];
				c.grain = grains[k];
				/* From the owner twice, from outside and from a job, together with a plain job. */
				submit_cover(&c, 0);
				assert_int_equal(stilb_job_submit(pool, do_nothing, NULL, &group, 0), 0);
				outside_run(submit_cover_from_outside, &c);
				assert_int_equal(stilb_job_submit(pool, submit_cover, &c, &group, 0), 0);
				submit_cover(&c, 0);
				stilb_job_wait(pool, &group, 0);
				cover_check(&c, 4);
			}
		stilb_job_pool_destroy(pool);
	}
}

static void test_array_of_nothing(void **state)
{
	(void)state;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		stilb_job_group group = {0};
		static cover c;
		c = (cover){.pool = pool_with(s), .group = &group, .threads = s.workers + 1, .grain = 1};
		submit_cover(&c, 0);
		outside_run(submit_cover_from_outside, &c);
		assert_int_equal(group.state, 0);
		stilb_job_wait(c.pool, &group, 0);
		cover_check(&c, 0);
		stilb_job_pool_destroy(c.pool);
	}
}

static void add_extent(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	_Atomic uint64_t *sum = context;
	(void)worker;
	atomic_fetch_add_explicit(sum, end - begin, memory_order_relaxed);
}

static void test_huge_arrays(void **state)
{
	(void)state;
	static const struct {
		uint32_t count, grain;
	} sizes[] = {{UINT32_MAX, 1u << 20}, {UINT32_MAX - 1, UINT32_MAX}, {1u << 31, (1u << 30) + 1}, {1u << 20, 0}};
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		stilb_job_group group = {0};
		stilb_job_pool *pool = pool_with(s);
		uint64_t expected = 0;
		_Atomic uint64_t sum = 0;
		for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
			if (sizes[i].grain == 0 && s.workers != 2)
				continue; /* a million slices: one round is enough */
			assert_int_equal(stilb_job_submit_array(pool, sizes[i].count, sizes[i].grain, add_extent, &sum, &group, 0),
			                 0);
			expected += sizes[i].count;
		}
		stilb_job_wait(pool, &group, 0);
		assert_true(sum == expected);
		stilb_job_pool_destroy(pool);
	}
}

/* Every level opens three of each kind, down to the leaves. */
enum { WIDTH = 3 };

typedef struct nest {
	stilb_job_pool *pool;
	counter *leaves, *wrong;
	uint32_t levels; /* number of levels below this one */
} nest;

static void nested_array(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	const nest *outer = context;
	for (uint32_t i = begin; i < end; i++) {
		if (outer->levels == 0) {
			count_up(outer->leaves);
			continue;
		}
		nest inner = *outer;
		inner.levels--;
		stilb_job_group group = {0};
		if (stilb_job_submit_array(inner.pool, WIDTH, 1, nested_array, &inner, &group, worker) != 0)
			count_up(inner.wrong);
		stilb_job_wait(inner.pool, &group, worker);
	}
}

static void nested_loop(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	const nest *outer = context;
	for (uint32_t i = begin; i < end; i++) {
		if (outer->levels == 0) {
			count_up(outer->leaves);
			continue;
		}
		nest inner = *outer;
		inner.levels--;
		stilb_job_parallel_for(inner.pool, WIDTH, 1, nested_loop, &inner, worker);
	}
}

/* Nested more deeply than the number of loops that a thread can offer to helpers at once (JOB_LOOP_DEPTH). */
static void test_arrays_and_loops_nest(void **state)
{
	(void)state;
	enum { LEVELS = 7 };
	uint32_t expected = 1;
	for (int i = 0; i < LEVELS; i++)
		expected *= WIDTH;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		counter leaves = 0, wrong = 0;
		nest n = {.pool = pool_with(s), .leaves = &leaves, .wrong = &wrong, .levels = LEVELS - 1};
		stilb_job_group group = {0};
		assert_int_equal(stilb_job_submit_array(n.pool, WIDTH, 1, nested_array, &n, &group, 0), 0);
		stilb_job_wait(n.pool, &group, 0);
		assert_int_equal(leaves, expected);
		stilb_job_parallel_for(n.pool, WIDTH, 1, nested_loop, &n, 0);
		assert_int_equal(leaves, 2 * expected);
		assert_int_equal(stilb_job_submit_array(n.pool, WIDTH, 1, nested_loop, &n, &group, 0), 0);
		stilb_job_parallel_for(n.pool, WIDTH, 1, nested_array, &n, 0);
		stilb_job_wait(n.pool, &group, 0);
		assert_int_equal(leaves, 4 * expected);
		assert_int_equal(wrong, 0);
		stilb_job_pool_destroy(n.pool);
	}
}

/* ---- outside threads ------------------------------------------------------------------------------------------- */

typedef struct guest {
	stilb_job_pool *pool;
	uint32_t rounds, jobs;
	counter ran, wrong;
} guest;

static void count_guest_job(void *data, uint32_t worker)
{
	guest *g = data;
	(void)worker;
	count_up(&g->ran);
}

static void *submit_and_wait(void *data)
{
	guest *g = data;
	for (uint32_t round = 1; round <= g->rounds; round++) {
		stilb_job_group group = {0};
		for (uint32_t i = 0; i < g->jobs; i++)
			if (stilb_job_submit(g->pool, count_guest_job, g, &group, STILB_JOB_OUTSIDE) != 0)
				count_up(&g->wrong);
		stilb_job_wait(g->pool, &group, STILB_JOB_OUTSIDE);
		if (count_of(&g->ran) != round * g->jobs)
			count_up(&g->wrong);
	}
	return NULL;
}

static void run_guests(shape s, uint32_t guests, uint32_t rounds, uint32_t jobs)
{
	enum { MOST_GUESTS = 40 };
	static guest g[MOST_GUESTS];
	pthread_t thread[MOST_GUESTS];
	stilb_job_pool *pool = pool_with(s);
	for (uint32_t i = 0; i < guests; i++) {
		g[i] = (guest){.pool = pool, .rounds = rounds, .jobs = jobs};
		thread[i] = outside_start(submit_and_wait, &g[i]);
	}
	for (uint32_t i = 0; i < guests; i++) {
		pthread_join(thread[i], NULL);
		assert_int_equal(g[i].ran, rounds * jobs);
		assert_int_equal(g[i].wrong, 0);
	}
	stilb_job_pool_destroy(pool);
}

static void test_threads_from_outside(void **state)
{
	(void)state;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s))
		/* without workers only the owner's waits run jobs, and here the owner joins those threads */
		if (s.workers > 0) {
			run_guests(s, 8, 1, TEST_TSAN ? 1000 : 10000);
			run_guests(s, 40, 10, 20); /* more threads than can be inside calls at once */
		}
}

/* Threads that sleep in a wait must not keep others from submitting the job that they wait for. */
typedef struct crowd {
	stilb_job_pool *pool;
	stilb_job_group group;
	blocker held;
	counter waiting, wrong;
} crowd;

static void *wait_in_a_crowd(void *data)
{
	crowd *c = data;
	count_up(&c->waiting);
	stilb_job_wait(c->pool, &c->group, STILB_JOB_OUTSIDE);
	if (count_of(&c->held.go) == 0)
		count_up(&c->wrong);
	return NULL;
}

static void release(void *data, uint32_t worker)
{
	crowd *c = data;
	(void)worker;
	blocker_release(&c->held);
}

static void *submit_release(void *data)
{
	crowd *c = data;
	if (stilb_job_submit(c->pool, release, c, &c->group, STILB_JOB_OUTSIDE) != 0)
		count_up(&c->wrong);
	return NULL;
}

static void test_threads_that_wait_leave_room(void **state)
{
	(void)state;
	enum { CROWD = 40 };
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		if (s.workers < 2)
			continue; /* the only worker would be held */
		pthread_t thread[CROWD];
		crowd c = {.pool = pool_with(s)};
		hold_workers(c.pool, &c.held, &c.group, 1, 1);
		for (int i = 0; i < CROWD; i++)
			thread[i] = outside_start(wait_in_a_crowd, &c);
		assert_true(await(&c.waiting, CROWD));
		nap_us(1000); /* by now they sleep */
		outside_run(submit_release, &c);
		for (int i = 0; i < CROWD; i++)
			pthread_join(thread[i], NULL);
		assert_int_equal(c.wrong, 0);
		stilb_job_pool_destroy(c.pool);
	}
}

static void *submit_only(void *data)
{
	fan *f = data;
	for (uint32_t i = 0; i < FAN; i++)
		if (stilb_job_submit(f->pool, write_cell, &f->cell[i], &f->first, STILB_JOB_OUTSIDE) != 0)
			count_up(&f->wrong);
	return NULL;
}

static void test_owner_runs_what_came_from_outside(void **state)
{
	(void)state;
	for (shape s = shape_first(); !shape_is_end(s); s = shape_next(s)) {
		fan f = {.pool = pool_with(s)};
		outside_run(submit_only, &f);
		stilb_job_wait(f.pool, &f.first, 0);
		read_all(&f, 0);
		assert_int_equal(f.wrong, 0);
		stilb_job_pool_destroy(f.pool);
	}
}

/* ---- phases ---------------------------------------------------------------------------------------------------- */

/* A pool with as many workers as spin in a phase (stilb_job_phase_begin) on this machine. */
static shape spinning_shape(stilb_job_queue_kind queue)
{
	uint32_t cpus = stilb_job_cpu_count();
	return (shape){.workers = cpus < 3 ? 1 : cpus - 1 < MOST_WORKERS ? cpus - 1 : MOST_WORKERS, .queue = queue};
}

static void test_nobody_sleeps_in_a_phase(void **state)
{
	(void)state;
	for (int queue = 0; queue < 2; queue++) {
		sleep_log log = {0};
		guest c = {0};
		shape s = spinning_shape((stilb_job_queue_kind)queue);
		c.pool = pool_with_hooks(s, sleep_log_hooks(&log));
		for (int round = 0; round < 2; round++) {
			assert_true(await(&log.asleep, s.workers));
			stilb_job_phase_begin(c.pool);
			stilb_job_phase_begin(c.pool);
			assert_true(await(&log.asleep, 0));
			uint32_t parks = count_of(&log.parks);
			nap_us(20000);
			for (uint32_t i = 1; i <= 100; i++) {
				assert_int_equal(stilb_job_submit(c.pool, count_guest_job, &c, NULL, 0), 0);
				assert_true(await(&c.ran, (uint32_t)round * 100 + i));
			}
			stilb_job_phase_end(c.pool);
			nap_us(20000); /* the outer phase continues */
			assert_int_equal(count_of(&log.parks), parks);
			stilb_job_phase_end(c.pool);
			assert_true(await(&log.asleep, s.workers));
		}
		stilb_job_pool_destroy(c.pool);
	}
}

static uint64_t cpu_time_us(void)
{
	struct rusage usage;
	getrusage(RUSAGE_SELF, &usage);
	return (uint64_t)(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) * 1000000u +
	       (uint64_t)(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
}

static void test_idle_workers_burn_nothing(void **state)
{
	(void)state;
	sleep_log log = {0};
	shape s = {.workers = MOST_WORKERS};
	stilb_job_pool *pool = pool_with_hooks(s, sleep_log_hooks(&log));
	stilb_job_phase_begin(pool);
	stilb_job_phase_end(pool);
	assert_true(await(&log.asleep, s.workers));
	uint64_t start = cpu_time_us();
	nap_us(200000);
	assert_in_range(cpu_time_us() - start, 0, 10000);
	stilb_job_pool_destroy(pool);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(test_priorities),
		cmocka_unit_test(test_high_comes_next),
		cmocka_unit_test(test_own_jobs_starve_nobody),
		cmocka_unit_test(test_pinned_jobs_run_on_their_target),
		cmocka_unit_test(test_pinned_job_wakes_its_target),
		cmocka_unit_test(test_pinned_jobs_keep_their_order),
		cmocka_unit_test(test_run_pinned_says_how_many),
		cmocka_unit_test(test_chain),
		cmocka_unit_test(test_fan_out_and_in),
		cmocka_unit_test(test_follower_of_a_group_that_finishes),
		cmocka_unit_test(test_followers_keep_priority_and_target),
		cmocka_unit_test(test_arrays_cover_every_index_once),
		cmocka_unit_test(test_array_of_nothing),
		cmocka_unit_test(test_huge_arrays),
		cmocka_unit_test(test_arrays_and_loops_nest),
		cmocka_unit_test(test_threads_from_outside),
		cmocka_unit_test(test_threads_that_wait_leave_room),
		cmocka_unit_test(test_owner_runs_what_came_from_outside),
		cmocka_unit_test(test_nobody_sleeps_in_a_phase),
		cmocka_unit_test(test_idle_workers_burn_nothing),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
