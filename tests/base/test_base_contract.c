/* The contracts of base, each broken on purpose. */
#include "base/base_contract.h"
#include "support/contract.h"
#include "support/test.h"
#include <pthread.h>

static void check_owner(stilb_owner *owner)
{
	STILB_ASSERT_OWNER(*owner);
}

static void check_locked(stilb_lock *lock)
{
	STILB_ASSERT_LOCKED(lock);
}

static void *own(void *owner)
{
	stilb_owner_take(owner);
	return NULL;
}

static void another_thread_owns(stilb_owner *owner)
{
	pthread_t thread;
	pthread_attr_t attributes;
	pthread_attr_init(&attributes);
	pthread_create(&thread, &attributes, own, owner);
	pthread_join(thread, NULL);
	pthread_attr_destroy(&attributes);
}

static void an_object_is_used_by_its_owner_alone(void **state)
{
	(void)state;
	stilb_owner owner = {0};
	check_owner(&owner); /* nobody's */
	stilb_owner_take(&owner);
	check_owner(&owner);
	another_thread_owns(&owner);
	contract_breaks("called on the owner's thread", check_owner(&owner));
}

static void twice(stilb_lock *lock)
{
	stilb_lock_take(lock);
	stilb_lock_take(lock);
}

static void finish_held(stilb_lock *lock)
{
	stilb_lock_take(lock);
	stilb_lock_finish(lock);
}

static void a_lock_knows_its_holder(void **state)
{
	(void)state;
	stilb_lock lock;
	assert_true(stilb_lock_init(&lock));
	contract_breaks("the caller holds the lock", check_locked(&lock));
	contract_breaks("the caller holds the lock", stilb_lock_give(&lock));
	contract_breaks("the lock is not taken twice", twice(&lock));
	contract_breaks("nobody holds the lock", finish_held(&lock));
	stilb_lock_take(&lock);
	check_locked(&lock);
	stilb_lock_give(&lock);
	stilb_lock_finish(&lock);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(an_object_is_used_by_its_owner_alone),
		cmocka_unit_test(a_lock_knows_its_holder),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
