# Model tests: every interleaving of the real sources (job_model.h); and the same of a copy with one fault put in, which the
# test must find. Each fault is a test of its own.

if(STILB_SANITIZE)
	return() # the checker moves stacks about, which sanitizers cannot follow
endif()

# model_test(NAME): from NAME.c.
function(model_test name)
	stilb_test(${name} SOURCES ${name}.c job_model.c LABELS model TIMEOUT 300)
endfunction()

# model_fault(TEST NAME FILE TEXT FAULT [ARGS must-fail]): FILE of jobs/ with FAULT in the place of TEXT.
function(model_fault test name file text fault)
	cmake_parse_arguments(arg "" "" "ARGS" ${ARGN})
	if(NOT DEFINED arg_ARGS)
		set(arg_ARGS must-fail)
	endif()
	set(copy ${CMAKE_CURRENT_BINARY_DIR}/faults/${test}_${name})
	set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/jobs/${file})
	file(READ ${PROJECT_SOURCE_DIR}/jobs/${file} source)
	string(REPLACE "${text}" "${fault}" faulty "${source}")
	if(faulty STREQUAL source)
		message(FATAL_ERROR "jobs/${file} has no \"${text}\" any more: the fault ${name} of ${test} needs another place")
	endif()
	file(GENERATE OUTPUT ${copy}/jobs/${file} CONTENT "${faulty}")
	stilb_test(${test}_${name} SOURCES ${test}.c job_model.c LABELS model TIMEOUT 300 ARGS ${arg_ARGS})
	if(TARGET ${test}_${name})
		target_include_directories(${test}_${name} BEFORE PRIVATE ${copy})
		target_compile_options(${test}_${name} PRIVATE -w)
	endif()
endfunction()

model_test(test_job_model)
model_fault(test_job_model no_look_before_sleep job_work.c
	"if (!rescue && !job_work_exists(slot, scope))" "if (!rescue)")
model_fault(test_job_model token_without_wake job_park.c
	"\tif (asleep)\n\t\tjob_sys_futex_wake_one" "\tif (asleep && false)\n\t\tjob_sys_futex_wake_one")
model_fault(test_job_model no_token job_park.c
	"bool asleep = leave_token(parker);\n\tjob_lock_give" "bool asleep = false;\n\tjob_lock_give")
model_fault(test_job_model no_announce job_wait.c
	"return !group_announce(group, slot->index + 1);" "return (void)group, (void)slot, false;")
model_fault(test_job_model guest_does_not_announce job_wait.c "if (group_announce(group, WAITERS_OUTSIDE))" "")
model_fault(test_job_model pop_looks_first job_deque.h
	"\tatomic_exchange_explicit(&deque->bottom, bottom, memory_order_seq_cst);
	int64_t top = atomic_load_explicit(&deque->top, memory_order_seq_cst);"
	"\tint64_t top = atomic_load_explicit(&deque->top, memory_order_seq_cst);
	atomic_exchange_explicit(&deque->bottom, bottom, memory_order_seq_cst);")
model_fault(test_job_model pop_takes_what_was_stolen job_deque.h "\t\trecord = NULL;" "\t\t(void)0;")
model_fault(test_job_model loop_returns_early job_for.c "\t\tloop_wait(loop, slot, span, loop->finished);" "")
model_fault(test_job_model loop_one_generation job_for.c ">> 32) + 1;" ">> 32);")
model_fault(test_job_model no_rescue job_park.c "list->waiting < list->workers)" "list->waiting <= list->workers)")
model_fault(test_job_model no_rescue_of_itself job_work.c "rescue = alone &&" "rescue = false && alone &&")
model_fault(test_job_model followers_for_all job_wait.c "wanted &= ~FOLLOWED;" "(void)0;")
model_fault(test_job_model group_let_go_early job_wait.c
	"followed = word_count(wanted) == 1 && (old & FOLLOWED);"
	"followed = word_count(wanted) <= 1 && (old & FOLLOWED); if (followed) wanted &= ~UINT64_C(1);")
model_fault(test_job_model inbox_without_wake job_submit.c
	"\tjob_idle_wake_thread(&target->pool->idle, &target->parker);" "")
model_fault(test_job_model shared_without_wake job_submit.c
	"if (job_idle_wanted_strict(&pool->idle))" "if (false)")

model_test(test_job_model_lock_free)
model_fault(test_job_model_lock_free hazards_ignored job_queue_lock_free.c
	"if (!segment_in_use(queue, segment))\n\t\t\t\treturn segment;" "return segment;")
model_fault(test_job_model_lock_free no_second_look job_queue_lock_free.c "while (seen != segment);" "while (false);")
model_fault(test_job_model_lock_free hazard_after_look job_queue_lock_free.c
	"atomic_exchange_explicit(&self->hazard[end], segment, memory_order_seq_cst);
		/* Also acquire, pairs with end_advance: the segment's constants are there. */
		seen = atomic_load_explicit(&queue->end[end].segment, memory_order_seq_cst);"
	"seen = atomic_load_explicit(&queue->end[end].segment, memory_order_seq_cst);
		atomic_exchange_explicit(&self->hazard[end], segment, memory_order_seq_cst);")
model_fault(test_job_model_lock_free last_thread_ignored job_queue_lock_free.c
	"i < count; ++i)\n\t\tfor (uint32_t end" "i + 1 < count; ++i)\n\t\tfor (uint32_t end")
model_fault(test_job_model_lock_free retired_twice job_queue_lock_free.c
	"unlinked = end_advance(queue, HEAD, segment, next);" "unlinked = true, end_advance(queue, HEAD, segment, next);")
model_fault(test_job_model_lock_free rest_keeps_place job_queue_lock_free.c "self->place[end].segment = NULL;" "")
model_fault(test_job_model_lock_free linked_before_ready job_queue_lock_free.c
	"\tif (atomic_compare_exchange_strong_explicit(&last->next, next, segment, memory_order_acq_rel, memory_order_acquire))"
	"\tvoid *ready = segment->empty; segment->empty = taken_mark(ready);
	bool linked = atomic_compare_exchange_strong_explicit(&last->next, next, segment, memory_order_acq_rel, memory_order_acquire);
	model_step(NULL, \"ready\", __LINE__); segment->empty = ready;
	if (linked)")
model_fault(test_job_model_lock_free item_taken_twice job_queue_lock_free.c
	"cell_change(place, &seen, taken_mark(place->empty)))" "(cell_change(place, &seen, taken_mark(place->empty)), true))")
model_fault(test_job_model_lock_free no_seal job_queue_lock_free.c "return cell_change(place, &seen, SEAL) || seen == SEAL ? -EPIPE : 0;" "return -EPIPE;")
model_fault(test_job_model_lock_free seal_without_look job_queue_lock_free.c
	"return cell_change(place, &seen, SEAL) || seen == SEAL ? -EPIPE : 0;" "cell_change(place, &seen, SEAL); return -EPIPE;")
model_fault(test_job_model_lock_free no_link_seal job_queue_lock_free.c "\tjob_segment *next = NULL;\n\t/* Release and" "\treturn -EPIPE; job_segment *next = NULL;\n\t/* Release and")
model_fault(test_job_model_lock_free seal_passed_over job_queue_lock_free.c "if (cell_is(place->segment, place->index - 1, SEAL))" "if (false)")
model_fault(test_job_model_lock_free capacity_of_old job_queue_lock_free.c "pushed - self->popped >= queue->capacity;" "pushed - self->popped > queue->capacity;")
model_fault(test_job_model_lock_free full_for_ever job_queue_lock_free.c
	"self->popped = head->segment->first + head->index;" "(void)head;")
# Not wrong, but no longer lock-free: whoever appends a segment must move the tail; if it stops, pushes go round for ever.
model_fault(test_job_model_lock_free tail_not_helped job_queue_lock_free.c
	"\t\tint error = next ? 0 : segment_append(queue, self, segment, &next);
		if (error)
			return error;
		if (next == SEAL)
			return -EPIPE;
		end_advance(queue, TAIL, segment, next);"
	"\t\tbool mine = !next;
		int error = next ? 0 : segment_append(queue, self, segment, &next);
		if (error)
			return error;
		if (next == SEAL)
			return -EPIPE;
		if (mine)
			end_advance(queue, TAIL, segment, next);")

model_test(test_job_model_low_lock)
set(publish "atomic_store_explicit(&self->push.count, pushed + COUNT, memory_order_release);")
string(REPLACE COUNT 1 publish_one "${publish}")
string(REPLACE COUNT count publish_n "${publish}")
model_fault(test_job_model_low_lock count_before_cell job_queue_low_lock.c
	"self->push.at->cell[pushed % JOB_SEGMENT_CELLS] = item;"
	"${publish_one} model_step(NULL, \"\", __LINE__); self->push.at->cell[pushed % JOB_SEGMENT_CELLS] = item;")
model_fault(test_job_model_low_lock count_before_cells job_queue_low_lock.c
	"while (count > 0) {" "${publish_n} while (count > 0) { model_step(NULL, \"\", __LINE__);")
model_fault(test_job_model_low_lock reuse_too_early job_queue_low_lock.c "(popped - 1) / JOB" "popped / JOB")
model_fault(test_job_model_low_lock reuse_never job_queue_low_lock.c
	"return self->push.segments - " "return 0 * self->push.segments - 0 * ")
model_fault(test_job_model_low_lock no_capacity job_queue_low_lock.c
	"self->capacity - (pushed - popped)" "SIZE_MAX - (pushed - popped)")
model_fault(test_job_model_low_lock close_before_lock job_queue_low_lock.c
	"job_lock_take(&self->push.lock);\n\t/* Release pairs with the acquire in pop_refused"
	"atomic_store_explicit(&self->push.closed, true, memory_order_release);\n\tjob_lock_take(&self->push.lock);\n\t/*")
model_fault(test_job_model_low_lock closed_no_recheck job_queue_low_lock.c
	"return low_lock_empty(&self->base, 0) ? -EPIPE : -EAGAIN;" "return -EPIPE;")
model_fault(test_job_model_low_lock pushed_before_popped job_queue_low_lock.c
	"uint64_t popped = atomic_load_explicit(&self->pop.count, memory_order_acquire);\n\treturn"
	"uint64_t pushed = atomic_load_explicit(&self->push.count, memory_order_acquire);
	uint64_t popped = atomic_load_explicit(&self->pop.count, memory_order_acquire);
	return pushed == popped ||")
model_fault(test_job_model_low_lock woken_says_nothing job_lock.h "for (;;) {"
	"for (bool woken = false;; woken = true) {
		if (woken && job_lock_try(lock))
			return;
		if (woken)
			continue;")
model_fault(test_job_model_low_lock clears_before_giving job_lock.h
	"atomic_store_explicit(&lock->held, 0, memory_order_release); /* pairs with job_lock_try */"
	"if (atomic_exchange_explicit(&lock->sleepers, 0, memory_order_relaxed)) job_sys_futex_wake_one(&lock->sleepers);
	atomic_store_explicit(&lock->held, 0, memory_order_release); return;")
model_fault(test_job_model_low_lock sleep_no_second_look job_lock.h "if (job_lock_try(lock))\n\t\t\treturn;\n\t\tjob_sys_futex" "job_sys_futex")

model_test(test_job_model_spsc)
set(publish_last "atomic_store_explicit(&queue->last, node, memory_order_release); model_step(NULL, \"\", __LINE__);")
set(publish_divider "atomic_store_explicit(&queue->divider, node, memory_order_release); model_step(NULL, \"\", __LINE__);")
model_fault(test_job_model_spsc last_before_item job_spsc.c "*node = item;" "${publish_last} *node = item;")
model_fault(test_job_model_spsc last_before_link job_spsc.c "queue->writing->next = block;"
	"queue->writing->next = queue->writing; ${publish_last} queue->writing->next = block;")
model_fault(test_job_model_spsc past_divider job_spsc.c "if (block_holds(block, divider))"
	"if (block_holds(block, divider) && block == queue->writing)")
model_fault(test_job_model_spsc divider_too job_spsc.c "block_holds(block, divider)" "block_holds(block, divider + 1)")
model_fault(test_job_model_spsc closed_after_last job_spsc.c "divider == queue->seen)\n\t\t\treturn closed"
	"divider == queue->seen)\n\t\t\treturn closed |= atomic_load_explicit(&queue->closed, memory_order_acquire), closed")
# No fault after all, "by a happy accident" as the article says of the same change: the producer leaves the divider's own
# node alone. The checker agrees.
model_fault(test_job_model_spsc divider_before_item job_spsc.c "*item = *node;" "${publish_divider} *item = *node;" ARGS ends-well)

# A fixed -O level keeps the number of states in bounds.
set_source_files_properties(test_job_model.c test_job_model_low_lock.c test_job_model_spsc.c test_job_model_lock_free.c
	job_model.c PROPERTIES COMPILE_OPTIONS -O2)
