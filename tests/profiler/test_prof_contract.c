/* The contracts of the profiler, each broken on purpose. */
#include "profiler/prof_capture_internal.h"
#include "profiler/prof_diff.h"
#include "profiler/prof_frames.h"
#include "profiler/prof_trace.h"
#include "profiler/read/prof_sort.h"
#include "profiler/write/prof_file.h"
#include "profiler/write/prof_text.h"

#include "support/contract.h"
#include "support/test.h"

#include <math.h>
#include <sys/mman.h>

STILB_PROF_SITE(zone_site, "zone", 0);
STILB_PROF_FLOW(arrow, "arrow", 0);

/* ---- recording --------------------------------------------------------------------------------------------------- */

/* An event holds the distance of its site from the program's other sites in 30 bits; memory from mmap is further
 * away. */
static void record_a_mapped_site(void)
{
	stilb_prof_site *site = mmap(NULL, sizeof *site, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
	if (site == MAP_FAILED)
		_exit(0);
	*site = (stilb_prof_site){.name = "allocated", .kind = STILB_PROF_KIND_ZONE};
	stilb_prof_zone_begin(site);
	stilb_prof_zone_end();
}

static void sites_are_what_they_are_used_as(void **state)
{
	(void)state;
	contract_breaks("sites lie in the program", (record_a_mapped_site(), 0));
	contract_breaks("a site of zones", (stilb_prof_zone_begin(arrow), 0));
	contract_breaks("a site of zones", (stilb_prof_zone_begin(NULL), 0));
	contract_breaks("STILB_PROF_KIND_COUNTER", (stilb_prof_counter(&zone_site, 1.0), 0));
	contract_breaks("STILB_PROF_KIND_INSTANT", (stilb_prof_instant(&zone_site), 0));
	contract_breaks("flow", stilb_prof_flow_begin(NULL));
}

static void list_a_site_of_the_array(void)
{
	stilb_prof_site_list((stilb_prof_site *)(uintptr_t)&zone_site, 1);
}

static void sites_come_from_the_list(void **state)
{
	(void)state;
	contract_breaks("a site that stilb_prof_site_next gave", stilb_prof_site_next(&(stilb_prof_site){.name = "other"}));
	contract_breaks("!prof_site_is_in_array(sites)", (list_a_site_of_the_array(), 0));
	contract_breaks("name && rgb <= 0xffffff", stilb_prof_site_make(NULL, 0));
	contract_breaks("name && rgb <= 0xffffff", stilb_prof_site_make("transparent", 0xff000000));
}

static void mark_again(uint64_t number, uint64_t duration_ns)
{
	(void)number;
	(void)duration_ns;
	prof_frame_hook_set(NULL);
	stilb_prof_frame_mark();
}

static void mark_inside_a_mark(void)
{
	stilb_prof_frame_mark();
	prof_frame_hook_set(mark_again);
	stilb_prof_frame_mark();
}

static void set_two_hooks(void)
{
	prof_frame_hook_set(mark_again);
	prof_frame_hook_set(mark_again);
}

static void one_thread_marks_frames(void **state)
{
	(void)state;
	contract_breaks("one call at a time", (mark_inside_a_mark(), 0));
	contract_breaks("one hook at a time", (set_two_hooks(), 0));
}

static stilb_prof_lane_handle *lane_of(void)
{
	stilb_prof_lane_handle *lane;
	if (stilb_prof_lane_create("device", &lane) != 0)
		_exit(0);
	return lane;
}

static void destroy_a_lane_twice(void)
{
	stilb_prof_lane_handle *lane = lane_of();
	stilb_prof_lane_destroy(lane);
	stilb_prof_lane_destroy(lane);
}

static void record_to_a_destroyed_lane(void)
{
	stilb_prof_lane_handle *lane = lane_of();
	stilb_prof_lane_destroy(lane);
	stilb_prof_lane_zone(lane, &zone_site, 0, 1, 2);
}

static void destroy_a_threads_ring(void)
{
	stilb_prof_thread_begin("main");
	stilb_prof_lane_destroy((stilb_prof_lane_handle *)stilb_prof_thread_ring);
}

static void lanes_live_once(void **state)
{
	(void)state;
	contract_breaks("a ring is left once", (destroy_a_lane_twice(), 0));
	contract_breaks("the lane lives", (record_to_a_destroyed_lane(), 0));
	contract_breaks("the handle of a lane", (destroy_a_threads_ring(), 0));
	contract_breaks("prof_kind_is_zone(site->kind)", (stilb_prof_lane_zone(lane_of(), arrow, 0, 1, 2), 0));
	contract_breaks("lane", stilb_prof_lane_create("device", NULL));
}

static void close_a_handle_twice(void)
{
	uint32_t handle = prof_schedstat_open("twice");
	prof_schedstat_close(handle);
	prof_schedstat_close(handle);
}

static void lock_twice(void)
{
	prof_mutex mutex = PROF_MUTEX_INIT;
	prof_mutex_lock(&mutex);
	prof_mutex_lock(&mutex);
}

static void unlock_unlocked(void)
{
	prof_mutex mutex = PROF_MUTEX_INIT;
	prof_mutex_unlock(&mutex);
}

static void locks_and_handles(void **state)
{
	(void)state;
	contract_breaks("the lock is not taken twice", (lock_twice(), 0));
	contract_breaks("the caller holds the lock", (unlock_unlocked(), 0));
	if (access("/proc/thread-self/schedstat", R_OK) == 0)
		contract_breaks("a handle is closed once", (close_a_handle_twice(), 0));
}

/* ---- clock and frames -------------------------------------------------------------------------------------------- */

static void force_late(void)
{
	prof_clock_now();
	prof_clock_force_monotonic();
}

static void read_an_empty_timeline(void)
{
	static prof_timeline timeline;
	prof_timeline_ns(&timeline, 1);
}

static void clocks(void **state)
{
	(void)state;
	contract_breaks("before the clock is first read", (force_late(), 0));
	contract_breaks("the timeline is made", (read_an_empty_timeline(), 0));
}

static void add_to_unsorted(void)
{
	prof_frame_window window = {.count = 2, .sorted = {2, 1}};
	prof_frame_window_add(&window, 3);
}

static void make_stats(uint64_t begin_ns, uint64_t end_ns, double budget_ms)
{
	stilb_prof_frame_stats stats;
	stilb_prof_frame_stats_make(&stats, &(stilb_prof_frame){0, begin_ns, end_ns}, 1, budget_ms);
}

static void frame_times(void **state)
{
	(void)state;
	contract_breaks("prof_window_is_sound(window)", (add_to_unsorted(), 0));
	contract_breaks("percent >= 1", prof_frame_window_rank(&(prof_frame_window){0}, 0) > 0);
	contract_breaks("frames end after they begin", (make_stats(2, 1, 16.0), 0));
	contract_breaks("budget_ms >= 0", (make_stats(1, 2, (double)NAN), 0));
}

/* ---- captures ---------------------------------------------------------------------------------------------------- */

static stilb_prof_capture_desc capture_desc(void (*done)(void *user, const stilb_prof_captured *captured))
{
	stilb_prof_capture_desc desc = stilb_prof_capture_desc_default();
	desc.path = "/dev/null";
	desc.done = done;
	return desc;
}

static void shut_down_while_capturing(void)
{
	stilb_prof_capture_desc desc = capture_desc(NULL);
	if (stilb_prof_capture_start(&desc) != 0)
		_exit(0);
	stilb_prof_shutdown();
}

static void start_again(void *user, const stilb_prof_captured *captured)
{
	(void)user;
	(void)captured;
	stilb_prof_capture_desc desc = capture_desc(NULL);
	stilb_prof_capture_start(&desc);
}

static void start_from_done(void)
{
	stilb_prof_capture_desc desc = capture_desc(start_again);
	if (stilb_prof_capture_start(&desc) != 0 || stilb_prof_capture_now() != 0)
		_exit(0);
	stilb_prof_capture_stop();
}

static void captures(void **state)
{
	(void)state;
	contract_breaks("captures have stopped", (shut_down_while_capturing(), 0));
	contract_breaks("not from done", (start_from_done(), 0));
	contract_breaks("prof_capture_is_thread", prof_capture_write(STILB_PROF_CAUSE_ASKED, 0, 0, 0));
}

/* ---- snapshots and tables ---------------------------------------------------------------------------------------- */

static const stilb_prof_label labels[] = {{.name = "a", .function = "", .file = ""}};

/* A zone of label 0 at the level given, alone on its lane. */
static stilb_prof_snapshot snapshot_of(uint16_t level)
{
	static stilb_prof_zone zone;
	static stilb_prof_lane lane;
	zone = (stilb_prof_zone){.begin_ns = 1,
	                         .end_ns = 2,
	                         .self_ns = 1,
	                         .size = 1,
	                         .parent = STILB_PROF_NONE,
	                         .frame = STILB_PROF_NONE,
	                         .level = level};
	lane = (stilb_prof_lane){.name = "main", .zones = &zone, .zone_count = 1};
	return (stilb_prof_snapshot){.labels = labels, .label_count = 1, .lanes = &lane, .lane_count = 1};
}

static int write_nothing(void *user, const void *data, size_t size)
{
	(void)user;
	(void)data;
	(void)size;
	return 0;
}

static void sort_with_another_snapshot(void)
{
	stilb_prof_snapshot snapshot = snapshot_of(0);
	stilb_prof_stats stats = {0};
	if (stilb_prof_stats_take(&stats, &snapshot, NULL) != 0)
		_exit(0);
	stilb_prof_stats_sort(&stats, &(stilb_prof_snapshot){0}, STILB_PROF_BY_SELF);
}

static int compare_by(unsigned sample)
{
	stilb_prof_snapshot snapshot = snapshot_of(0);
	stilb_prof_diff diff = {0};
	stilb_prof_diff_desc desc = {.sample = (stilb_prof_diff_sample)sample};
	return stilb_prof_diff_make(&diff, &snapshot, &snapshot, &desc);
}

static void write_table(uint16_t level)
{
	stilb_prof_snapshot snapshot = snapshot_of(level);
	stilb_prof_trace_write_frames_csv(&snapshot, (stilb_prof_sink){.write = write_nothing});
}

static void snapshots_and_tables(void **state)
{
	(void)state;
	uint64_t descending[] = {2, 1};
	contract_breaks("snapshot", stilb_prof_snapshot_take(NULL, NULL));
	contract_breaks("the snapshot that the rows were taken from", (sort_with_another_snapshot(), 0));
	contract_breaks("desc->sample <= STILB_PROF_DIFF_PER_FRAME", compare_by(2));
	contract_breaks("samples_ascend(a, a_count)", stilb_prof_mann_whitney(descending, 2, descending, 1) > 0.0);
	contract_breaks("count > 0", prof_quantile(descending, 0, 50) > 0);
	contract_breaks("values && scratch", (prof_sort(descending, descending, 2), 0));
	contract_breaks("a zone stands behind its parent", (write_table(1), 0));
}

/* Snapshots that each break one promise of prof_snapshot.h: the check must find it. */
static void unsound_snapshots(void **state)
{
	(void)state;
	stilb_prof_snapshot good = snapshot_of(0), snapshot = good;
	assert_true(prof_snapshot_is_sound(&snapshot));
	stilb_prof_zone zone = good.lanes[0].zones[0];
	stilb_prof_lane lane = good.lanes[0];
	lane.zones = &zone;
	snapshot.lanes = &lane;
	assert_true(prof_snapshot_is_sound(&snapshot));
	stilb_prof_zone whole = zone;
#define zone_breaks(member, value)                                                                                     \
	do {                                                                                                               \
		zone = whole;                                                                                                  \
		zone.member = value;                                                                                           \
		assert_false(prof_snapshot_is_sound(&snapshot));                                                               \
		zone = whole;                                                                                                  \
	} while (0)
	zone_breaks(end_ns, 0);
	zone_breaks(self_ns, 2);
	zone_breaks(off_cpu_ns, 2);
	zone_breaks(size, 0);
	zone_breaks(size, 2);
	zone_breaks(label, 1);
	zone_breaks(frame, 0);
	zone_breaks(level, 1);
	zone_breaks(parent, 0);
	lane.name = NULL;
	assert_false(prof_snapshot_is_sound(&snapshot));
	const stilb_prof_zone pair[][2] = {
		{{.begin_ns = 1, .end_ns = 3, .size = 1, .parent = STILB_PROF_NONE, .frame = STILB_PROF_NONE},
	     {.begin_ns = 2, .end_ns = 4, .size = 1, .parent = STILB_PROF_NONE, .frame = STILB_PROF_NONE}}, /* overlap */
		{{.begin_ns = 1, .end_ns = 3, .size = 2, .parent = STILB_PROF_NONE, .frame = STILB_PROF_NONE},
	     {.begin_ns = 2, .end_ns = 4, .size = 1, .parent = 0, .level = 1, .frame = STILB_PROF_NONE}}, /* sticks out */
		{{.begin_ns = 1, .end_ns = 3, .size = 2, .parent = STILB_PROF_NONE, .frame = STILB_PROF_NONE},
	     {.begin_ns = 2, .end_ns = 3, .size = 1, .parent = 0, .frame = STILB_PROF_NONE}}, /* not a level deeper */
		{{.begin_ns = 1, .end_ns = 3, .size = 1, .parent = STILB_PROF_NONE, .frame = STILB_PROF_NONE},
	     {.begin_ns = 3, .end_ns = 3, .size = 1, .parent = 0, .level = 1, .frame = STILB_PROF_NONE}}, /* not in size */
	};
	lane = (stilb_prof_lane){.name = "main", .zone_count = 2};
	for (size_t i = 0; i < sizeof pair / sizeof *pair; i++) {
		lane.zones = pair[i];
		assert_false(prof_snapshot_is_sound(&snapshot));
	}
	const stilb_prof_switch switches[] = {{.out_ns = 1, .in_ns = 3}, {.out_ns = 2, .in_ns = 4}};
	lane = (stilb_prof_lane){.name = "main", .switches = switches, .switch_count = 2};
	assert_false(prof_snapshot_is_sound(&snapshot));
	const stilb_prof_point points[] = {{.ns = 2, .lane = STILB_PROF_NONE}, {.ns = 1, .lane = STILB_PROF_NONE}};
	stilb_prof_flow late = {.from_ns = 2, .to_ns = 1, .from_lane = 0, .to_lane = 0, .frame = STILB_PROF_NONE};
	const stilb_prof_frame frames[] = {{.number = 1, .begin_ns = 1, .end_ns = 2},
	                                   {.number = 1, .begin_ns = 2, .end_ns = 3}};
	snapshot = good, snapshot.points = points, snapshot.point_count = 1;
	assert_true(prof_snapshot_is_sound(&snapshot));
	snapshot.point_count = 2;
	assert_false(prof_snapshot_is_sound(&snapshot));
	snapshot = good, snapshot.flows = &late, snapshot.flow_count = 1;
	assert_false(prof_snapshot_is_sound(&snapshot));
	snapshot = good, snapshot.frames = frames, snapshot.frame_count = 2;
	assert_false(prof_snapshot_is_sound(&snapshot));
	snapshot.frame_count = 1;
	assert_true(prof_snapshot_is_sound(&snapshot));
}

/* ---- files ------------------------------------------------------------------------------------------------------- */

static prof_file committed_file(void)
{
	prof_file file;
	if (prof_file_open(&file, "/dev/null", false) != 0 || prof_file_commit(&file, 0) != 0)
		_exit(0);
	return file;
}

static void write_after_commit(void)
{
	prof_file file = committed_file();
	prof_file_write(&file, "x", 1);
}

static void commit_twice(void)
{
	prof_file file = committed_file();
	prof_file_commit(&file, 0);
}

static void write_not_a_number(void)
{
	prof_text_double(prof_text_create((stilb_prof_sink){.write = write_nothing}), (double)NAN);
}

static void fill_beyond(void)
{
	prof_text *text = prof_text_create((stilb_prof_sink){.write = write_nothing});
	prof_text_fill(text, text->bytes + PROF_TEXT_SIZE + 1);
}

static void files(void **state)
{
	(void)state;
	contract_breaks("between open and commit", (write_after_commit(), 0));
	contract_breaks("committed once", (commit_twice(), 0));
	contract_breaks("neither JSON nor CSV has others", (write_not_a_number(), 0));
	contract_breaks("within the room that was made", (fill_beyond(), 0));
	contract_breaks("sink.write", prof_text_create((stilb_prof_sink){0}));
	contract_breaks("path", stilb_prof_trace_check(NULL));
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(sites_are_what_they_are_used_as),
		cmocka_unit_test(sites_come_from_the_list),
		cmocka_unit_test(one_thread_marks_frames),
		cmocka_unit_test(lanes_live_once),
		cmocka_unit_test(locks_and_handles),
		cmocka_unit_test(clocks),
		cmocka_unit_test(frame_times),
		cmocka_unit_test(captures),
		cmocka_unit_test(snapshots_and_tables),
		cmocka_unit_test(unsound_snapshots),
		cmocka_unit_test(files),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
