/* The contracts of job_prof, each broken on purpose. */
#include <stilb/job_prof.h>

#include "support/contract.h"
#include "support/test.h"

static void leave_a_zone_open(void *data, uint32_t worker)
{
	(void)data;
	(void)worker;
	PROFILE_BEGIN("left open");
}

static void run(stilb_job_fn *job, stilb_job_hooks hooks)
{
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	desc.worker_count = 0;
	desc.hooks = hooks;
	stilb_job_pool *pool = NULL;
	stilb_job_group group = {0};
	if (stilb_job_pool_create(&desc, &pool) != 0)
		_exit(0);
	stilb_job_submit(pool, job, NULL, &group, 0);
	stilb_job_wait(pool, &group, 0);
	stilb_job_pool_destroy(pool);
}

static void end_a_wait(void)
{
	stilb_job_prof_wait_end(NULL, 0);
}

static void wait_across_zones(void)
{
	stilb_job_prof_wait_begin(NULL, 0);
	PROFILE_BEGIN("not the wait's");
	stilb_job_prof_wait_end(NULL, 0);
}

static void wake_without_parking(void)
{
	PROFILE_BEGIN("awake");
	stilb_job_prof_wake(NULL, 0);
}

static void hooks_keep_their_zones(void **state)
{
	(void)state;
	contract_breaks("a job ends the zones that it begins", (run(leave_a_zone_open, stilb_job_prof_hooks(NULL)), 0));
	contract_breaks("a wait ends after it has begun", (end_a_wait(), 0));
	contract_breaks("stilb_job_prof_innermost_is(\"wait for workers\")", (wait_across_zones(), 0));
	contract_breaks("stilb_job_prof_innermost_is(\"parked\")", (wake_without_parking(), 0));
}

static void names_fit(void **state)
{
	(void)state;
	char name[54];
	memset(name, 'w', sizeof name);
	name[53] = '\0';
	contract_breaks("strlen(workers) <= 52", stilb_job_prof_hooks(name).user ? 1 : 0);
	contract_breaks("hooks made by stilb_job_prof_hooks", (stilb_job_prof_thread_start(NULL, 1), 0));
	name[52] = '\0';
	assert_ptr_equal(stilb_job_prof_hooks(name).user, name);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(hooks_keep_their_zones),
		cmocka_unit_test(names_fit),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
