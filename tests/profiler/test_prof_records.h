/* For the profiler's tests: names and numbers of the events in a copy of the rings (prof_copy_take). */
#ifndef STILB_TEST_PROF_RECORDS_H
#define STILB_TEST_PROF_RECORDS_H

#include "profiler/prof_internal.h"

#include <stdio.h>
#include <string.h>

static inline prof_record record_at(const prof_copy *copy, uint32_t lane, size_t i)
{
	return prof_event_unpack(&copy->lanes[lane].events[i], copy->lanes[lane].limit);
}

/* The names of a lane's events in the order of their ends, then "|" and those of its open zones, outermost first. */
static inline void record_names(const prof_copy *copy, uint32_t lane, char *names, size_t size)
{
	const prof_lane_copy *l = &copy->lanes[lane];
	size_t used = 0;
	names[0] = 0;
	for (size_t i = 0; i < l->event_count && used < size; i++)
		used += (size_t)snprintf(names + used, size - used, "%s%s", used > 0 ? " " : "",
		                         record_at(copy, lane, i).site->name);
	for (uint32_t i = 0; i < l->open_count && used < size; i++)
		used += (size_t)snprintf(names + used, size - used, "%s%s", i == 0 ? "|" : " ", l->open[i].site->name);
}

/* How many events of that name a lane holds. */
static inline uint64_t record_count(const prof_copy *copy, uint32_t lane, const char *name)
{
	uint64_t count = 0;
	for (size_t i = 0; i < copy->lanes[lane].event_count; i++)
		count += strcmp(record_at(copy, lane, i).site->name, name) == 0;
	return count;
}

/* Compares the events of the first lane, in the form of record_names, with expected. */
#define assert_records(expected)                                                                                       \
	do {                                                                                                               \
		prof_copy records_ = {0};                                                                                      \
		char names_[1024];                                                                                             \
		assert_int_equal(prof_copy_take(&records_, NULL), 0);                                                          \
		assert_int_not_equal(records_.lane_count, 0);                                                                  \
		record_names(&records_, 0, names_, sizeof names_);                                                             \
		prof_copy_free(&records_);                                                                                     \
		assert_string_equal(names_, expected);                                                                         \
	} while (0)

#endif
