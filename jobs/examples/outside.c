/*
 * Threads outside the pool submit jobs to it, with STILB_JOB_OUTSIDE in place of a worker index, and wait for them: the
 * connections of a server that share one pool.
 *
 * Prints: 4 connections, 400 requests answered
 */
#include <stilb/job.h>

#include <pthread.h>
#include <stdio.h>

enum { CONNECTIONS = 4, REQUESTS = 100 };

typedef struct connection {
	pthread_t thread;
	stilb_job_pool *pool;
	int answers[REQUESTS];
	int errors;
} connection;

static void answer(void *data, uint32_t worker)
{
	(void)worker;
	*(int *)data = 1;
}

static void *serve(void *data)
{
	connection *self = data;
	stilb_job_group group = {0};
	for (int i = 0; i < REQUESTS; i++)
		self->errors += stilb_job_submit(self->pool, answer, &self->answers[i], &group, STILB_JOB_OUTSIDE) != 0;
	stilb_job_wait(self->pool, &group, STILB_JOB_OUTSIDE);
	return NULL;
}

int main(void)
{
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	stilb_job_pool *pool;
	if (stilb_job_pool_create(&desc, &pool) != 0)
		return 1;
	static connection connections[CONNECTIONS];
	for (int i = 0; i < CONNECTIONS; i++) {
		connections[i].pool = pool;
		if (pthread_create(&connections[i].thread, NULL, serve, &connections[i]) != 0)
			return 1;
	}
	int answered = 0, errors = 0;
	for (int i = 0; i < CONNECTIONS; i++) {
		pthread_join(connections[i].thread, NULL);
		errors += connections[i].errors;
		for (int k = 0; k < REQUESTS; k++)
			answered += connections[i].answers[k];
	}
	stilb_job_pool_destroy(pool);
	printf("%d connections, %d requests answered\n", CONNECTIONS, answered);
	return errors;
}
