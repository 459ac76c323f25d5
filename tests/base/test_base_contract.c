/* The contracts of base, each broken on purpose. */
#include "base/base_contract.h"
#include "base/base_file.h"
#include "base/base_json.h"
#include "base/base_math.h"
#include "support/contract.h"
#include "support/test.h"
#include <errno.h>
#include <pthread.h>
#include <unistd.h>

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
	check_owner(&owner); /* it belongs to nobody */
	stilb_owner_take(&owner);
	check_owner(&owner);
	another_thread_owns(&owner);
	contract_breaks("called on the owner's thread", check_owner(&owner));
	contract_breaks("`owner'", stilb_owner_take(NULL));
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
	contract_breaks("`lock'", stilb_lock_init(NULL));
}

static void results_and_small_functions(void **state)
{
	(void)state;
	contract_breaks("a failure has a result of its own", stilb_fail(STILB_OK, "all is well"));
	contract_breaks("bytes > 0", stilb_memory_is_scarce(0));
	contract_breaks("count > 0", stilb_fail_threads(0, EAGAIN));
	contract_breaks("error > 0", stilb_fail_threads(1, -EAGAIN));
	contract_breaks("data || size == 0", stilb_hash_fnv1a64(STILB_FNV1A64_START, NULL, 1));
	contract_breaks("isa < STILB_ISA_COUNT", stilb_isa_text(STILB_ISA_COUNT));
	contract_breaks("`isa'", stilb_cpu_isa(NULL));
}

static void projections(void **state)
{
	(void)state;
	contract_breaks("fov_y > 0.0f", stilb_mat4_perspective(0.0f, 1.0f, 0.1f, 10.0f));
	contract_breaks("fov_y > 0.0f", stilb_mat4_perspective(NAN, 1.0f, 0.1f, 10.0f));
	contract_breaks("aspect > 0.0f", stilb_mat4_perspective(1.0f, 0.0f, 0.1f, 10.0f));
	contract_breaks("near_z < far_z", stilb_mat4_perspective(1.0f, 1.0f, 10.0f, 0.1f));
	contract_breaks("0.0f < near_z", stilb_mat4_perspective(1.0f, 1.0f, 0.0f, 0.1f));
	contract_breaks("view_projection", stilb_frustum_from_matrix(NULL));
}

static stilb_json open_object(void)
{
	stilb_json json = {0};
	stilb_json_begin(&json, NULL, '{');
	return json;
}

static void nest(uint32_t depth)
{
	stilb_json json = {0};
	for (uint32_t i = 0; i < depth; i++)
		stilb_json_begin(&json, NULL, '[');
	stilb_json_finish(&json);
}

static void two_values(void)
{
	stilb_json json = {0};
	stilb_json_int(&json, NULL, 1);
	stilb_json_int(&json, NULL, 2);
}

static void documents(void **state)
{
	(void)state;
	stilb_json empty = {0}, json = open_object();
	contract_breaks("a value in an object has a key", stilb_json_int(&json, NULL, 1));
	contract_breaks("a value in an object has a key", stilb_json_int(&empty, "key", 1));
	contract_breaks("bracket == '{'", stilb_json_begin(&json, "key", '('));
	contract_breaks("closes the innermost bracket", stilb_json_end(&json, ']'));
	contract_breaks("json->depth > 0", stilb_json_end(&empty, '}'));
	contract_breaks("`value'", stilb_json_string(&json, "key", NULL));
	contract_breaks("every bracket is closed", stilb_json_save(&json, "-"));
	contract_breaks("there is a value", stilb_json_save(&empty, "-"));
	contract_breaks("one value at the top", two_values());
	nest(STILB_JSON_MAX_DEPTH);
	contract_breaks("json->depth <", nest(STILB_JSON_MAX_DEPTH + 1));
	json.length++; /* damage */
	contract_breaks("json_is_sound(json)", stilb_json_int(&json, "key", 1));
	json.length--;
	stilb_json_finish(&json);
}

static void files(void **state)
{
	(void)state;
	stilb_file file = {0};
	FILE *stream;
	char part[STILB_FILE_PART_MAX];
	contract_breaks("`path'", stilb_file_check(NULL));
	contract_breaks("file && path", stilb_file_open(&file, NULL));
	contract_breaks("\"open\"", stilb_file_write(&file, "x", 1));
	contract_breaks("\"open\"", stilb_file_commit(&file));
	contract_breaks("data || size == 0", stilb_file_save("/dev/null", NULL, 1));
	contract_breaks("path && stream", stilb_file_read_open(NULL, &stream));
	contract_breaks("name[0]", stilb_file_find_part("", part));
	contract_breaks("strchr(name, '/')", stilb_file_find_part("../part", part));
	assert_int_equal(stilb_file_open(&file, "/dev/null"), STILB_OK);
	contract_breaks("data || size == 0", stilb_file_write(&file, NULL, 1));
	file.temporary = file.path; /* damage: a temporary name without a target */
	contract_breaks("file_is_sound(file)", stilb_file_commit(&file));
	contract_breaks("file_is_sound(file)", stilb_file_finish(&file));
	file.temporary = NULL;
	stilb_file_finish(&file);
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(an_object_is_used_by_its_owner_alone),
		cmocka_unit_test(a_lock_knows_its_holder),
		cmocka_unit_test(results_and_small_functions),
		cmocka_unit_test(projections),
		cmocka_unit_test(documents),
		cmocka_unit_test(files),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
