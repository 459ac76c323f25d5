/*
 * Work that only one thread may do: jobs decode pictures on any thread, but hand each to the main thread for an
 * interface that is not thread-safe. Pinned jobs of the owner run inside its waits and loops, and in
 * stilb_job_run_pinned.
 *
 * Prints: 8 uploads, all on the main thread
 */
#include <stilb/job.h>

#include <pthread.h>
#include <stdio.h>

enum { PICTURES = 8 };

typedef struct screen {
	stilb_job_pool *pool;
	stilb_job_group done;
	pthread_t main_thread;
	int uploads, elsewhere; /* written by the main thread alone */
} screen;

static void upload(void *data, uint32_t worker)
{
	(void)worker;
	screen *s = data;
	s->uploads++;
	s->elsewhere += !pthread_equal(pthread_self(), s->main_thread);
}

static void decode(void *data, uint32_t worker)
{
	screen *s = data;
	/* ... the long part, on any thread ... */
	stilb_job_options options = {.pinned = true, .target = 0}; /* 0 is the owner */
	if (stilb_job_submit_with(s->pool, upload, s, &s->done, &options, worker) != 0)
		fputs("out of memory\n", stderr);
}

int main(void)
{
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	screen s = {.main_thread = pthread_self()};
	if (stilb_job_pool_create(&desc, &s.pool) != 0)
		return 1;
	for (int i = 0; i < PICTURES; i++)
		if (stilb_job_submit(s.pool, decode, &s, &s.done, 0) != 0)
			return 1;
	stilb_job_wait(s.pool, &s.done, 0); /* a job may submit into its own group: this waits for the uploads, too */
	printf("%d uploads, %s on the main thread\n", s.uploads, s.elsewhere ? "not all" : "all");
	stilb_job_pool_destroy(s.pool);
	return 0;
}
