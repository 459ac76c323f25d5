/* A thread outlives a shared object in which it recorded zones: nothing of the profiler there is called when it
 * exits. */
#include <dlfcn.h>
#include <pthread.h>
#include <semaphore.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

static const char *module_path;

typedef struct caller {
	void (*record)(void);
	sem_t recorded, unloaded;
} caller;

static void wait_for(sem_t *event)
{
	while (sem_wait(event) != 0)
		;
}

static void *call(void *data)
{
	caller *c = data;
	c->record();
	sem_post(&c->recorded);
	wait_for(&c->unloaded);
	return NULL;
}

static void a_thread_outlives_the_module(void **state)
{
	(void)state;
	pthread_t thread;
	caller c;
	sem_init(&c.recorded, 0, 0);
	sem_init(&c.unloaded, 0, 0);
	void *module = dlopen(module_path, RTLD_NOW | RTLD_LOCAL);
	if (!module)
		fail_msg("%s", dlerror());
	*(void **)&c.record = dlsym(module, "module_record");
	assert_non_null(c.record);
	assert_int_equal(pthread_create(&thread, NULL, call, &c), 0);
	wait_for(&c.recorded);
	assert_int_equal(dlclose(module), 0);
	assert_null(dlopen(module_path, RTLD_NOW | RTLD_NOLOAD));
	sem_post(&c.unloaded);
	assert_int_equal(pthread_join(thread, NULL), 0);
	sem_destroy(&c.recorded);
	sem_destroy(&c.unloaded);
}

int main(int argc, char **argv)
{
	const struct CMUnitTest tests[] = {cmocka_unit_test(a_thread_outlives_the_module)};
	module_path = argc > 1 ? argv[1] : "";
	return cmocka_run_group_tests(tests, NULL, NULL);
}
