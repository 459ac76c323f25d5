/*
 * Jobs that start when others have finished: load -> (shade, light) -> show. Each step has a group; a job submitted
 * `after` a group waits for it without blocking a thread.
 *
 * Prints: loaded 4, shaded 40, lit 400, shown 440
 */
#include <stilb/job.h>

#include <stdio.h>

typedef struct picture {
	int loaded[4], shaded, lit, shown;
} picture;

static void load(void *data, uint32_t worker)
{
	(void)worker;
	*(int *)data = 1;
}

static int loaded_count(const picture *p)
{
	return p->loaded[0] + p->loaded[1] + p->loaded[2] + p->loaded[3];
}

static void shade(void *data, uint32_t worker)
{
	(void)worker;
	picture *p = data;
	p->shaded = 10 * loaded_count(p);
}

static void light(void *data, uint32_t worker)
{
	(void)worker;
	picture *p = data;
	p->lit = 100 * loaded_count(p);
}

static void show(void *data, uint32_t worker)
{
	(void)worker;
	picture *p = data;
	p->shown = p->shaded + p->lit;
}

int main(void)
{
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	stilb_job_pool *pool;
	if (stilb_job_pool_create(&desc, &pool) != 0)
		return 1;
	picture p = {0};
	stilb_job_group loading = {0}, drawing = {0}, showing = {0};
	stilb_job_options after_loading = {.after = &loading}, after_drawing = {.after = &drawing};
	int errors = 0;
	for (int i = 0; i < 4; i++)
		errors += stilb_job_submit(pool, load, &p.loaded[i], &loading, 0) != 0;
	errors += stilb_job_submit_with(pool, shade, &p, &drawing, &after_loading, 0) != 0;
	errors += stilb_job_submit_with(pool, light, &p, &drawing, &after_loading, 0) != 0;
	errors += stilb_job_submit_with(pool, show, &p, &showing, &after_drawing, 0) != 0;
	stilb_job_wait(pool, &showing, 0);
	printf("loaded %d, shaded %d, lit %d, shown %d\n", loaded_count(&p), p.shaded, p.lit, p.shown);
	stilb_job_pool_destroy(pool);
	return errors;
}
