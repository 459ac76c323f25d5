/*
 * Chrome trace JSON from a snapshot. Source of the format: Google, "Trace Event Format", where times are microseconds;
 * what the importers of Perfetto and chrome://tracing need beyond it: displayTimeUnit "ns" (otherwise they round to
 * microseconds and lose nesting), parents before children at equal times, and times with three decimals at least, that
 * is to the nanosecond.
 *
 * Ends that touch. Viewers written in JavaScript add ts (begin) and dur (duration) as doubles, so ends that are equal
 * in decimals may come out in either order, and speedscope then drops zones. It also takes a zone that begins where one
 * of the same name ends for a child of that one. Therefore times are counted in tenths of nanoseconds here, and each
 * zone ends a tenth before its next sibling begins and before its parent ends: such times have a fourth decimal.
 * Doubles tell tenths apart for three days. Rounding to the nearest nanosecond restores the true ends.
 *
 * The cost is in formatting: three million zones are 250 MB. Repeated text is made once: the beginning of an event for
 * each lane, and the name for each label. So writing a zone takes four copies of text and two formatted numbers.
 */
#include "profiler/prof_internal.h"
#include "profiler/write/prof_text.h"

#include <assert.h>
#include <errno.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define CHROME_TID_FRAMES 1
#define CHROME_TID_LANE(lane) (2 + 2 * (uint64_t)(lane))
#define CHROME_TID_OFF_CPU(lane) (3 + 2 * (uint64_t)(lane))
#define CHROME_PREFIX_MAX 80
#define CHROME_PHASE_AT 9 /* index of the phase's letter in the prefix */

/* Text that is formatted once and written often. */
typedef struct chrome_piece {
	const char *text;
	size_t size;
} chrome_piece;

/* Indices of points or flows by lane, each lane's ascending by time: those of lane i are index[start[i]] ..
 * index[start[i + 1] - 1]. */
typedef struct chrome_list {
	uint32_t *index;
	uint32_t *start;
} chrome_list;

enum {
	CHROME_POINTS,
	CHROME_FROMS, /* flows where they begin */
	CHROME_TOS,   /* flows where they end */
	CHROME_LISTS,
};

/* The begin and end of a zone as they are written, in tenths of nanoseconds. */
typedef struct chrome_span {
	uint64_t begin, end;
} chrome_span;

typedef struct chrome {
	const stilb_prof_snapshot *snapshot;
	prof_text *text;
	uint64_t pid;
	chrome_piece *names; /* of labels: ,"name":"..." */
	char *name_bytes;
	chrome_list lists[CHROME_LISTS];
	uint32_t next[CHROME_LISTS]; /* next entry of each list for the lane that is being written */
	chrome_span *spans;          /* for each level: the times of the last zone written at that level */
	uint64_t zones_written;
} chrome;

/* ---- events ------------------------------------------------------------------------------------------------------ */

/* Writes ,\n{"ph":"X","pid":1,"tid":2 */
static char *chrome_put_prefix(char *at, char phase, uint64_t pid, uint64_t tid)
{
	static const char start[] = ",\n{\"ph\":\"X\",\"pid\":";
	char *end = prof_put(at, start, sizeof start - 1);
	at[CHROME_PHASE_AT] = phase;
	end = prof_put(prof_put_u64(end, pid), ",\"tid\":", 7);
	return prof_put_u64(end, tid);
}

static void chrome_open(chrome *c, char phase, uint64_t tid)
{
	char *at = prof_text_room(c->text, CHROME_PREFIX_MAX);
	prof_text_fill(c->text, chrome_put_prefix(at, phase, c->pid, tid));
}

static void chrome_time(chrome *c, const char *key, uint64_t tenths)
{
	prof_text_add(c->text, key);
	prof_text_fill(c->text, prof_put_us(prof_text_room(c->text, PROF_PUT_US_MAX), tenths));
}

static void chrome_name(chrome *c, uint32_t label)
{
	assert(label < c->snapshot->label_count);
	/* NOLINTNEXTLINE(clang-analyzer-core.CallAndMessage): each label has a name */
	prof_text_bytes(c->text, c->names[label].text, c->names[label].size);
}

static void chrome_slice(chrome *c, uint64_t tid, const char *name, uint64_t begin, uint64_t end)
{
	assert(begin <= end);
	chrome_open(c, 'X', tid);
	chrome_time(c, ",\"ts\":", begin);
	chrome_time(c, ",\"dur\":", end - begin);
	prof_text_add(c->text, ",\"name\":\"");
	prof_text_add(c->text, name);
	prof_text_add(c->text, "\"}");
}

static uint64_t chrome_min(uint64_t a, uint64_t b)
{
	return a < b ? a : b;
}

/* The end to be written for something that begins at begin and must end before limit; all in tenths of nanoseconds. */
static uint64_t chrome_end(uint64_t begin, uint64_t end, uint64_t limit)
{
	if (end <= begin)
		end = begin + 1; /* speedscope leaves out what has no length */
	if (end >= limit)
		end = limit > 0 ? limit - 1 : 0;
	return end > begin ? end : begin;
}

/* ---- names ------------------------------------------------------------------------------------------------------- */

/* Writes the events that give a thread its place and its name, which is `name` followed by `more`. The last event's
 * "args" stay open, so that the caller can add members: ..."args":{"name":"main" */
static void chrome_thread_name(chrome *c, uint64_t tid, const char *name, const char *more)
{
	chrome_open(c, 'M', tid);
	prof_text_add(c->text, ",\"name\":\"thread_sort_index\",\"args\":{\"sort_index\":");
	prof_text_u64(c->text, tid);
	prof_text_add(c->text, "}}");
	chrome_open(c, 'M', tid);
	prof_text_add(c->text, ",\"name\":\"thread_name\",\"args\":{\"name\":\"");
	prof_text_escaped(c->text, name);
	prof_text_add(c->text, more);
	prof_text_add(c->text, "\"");
}

static void chrome_lane_names(chrome *c, uint32_t i)
{
	const stilb_prof_lane *lane = &c->snapshot->lanes[i];
	chrome_thread_name(c, CHROME_TID_LANE(i), lane->name, "");
	if (lane->kind == STILB_PROF_LANE_DEVICE) {
		prof_text_add(c->text, ",\"device\":true");
	} else if (lane->tid != 0) {
		prof_text_add(c->text, ",\"tid\":");
		prof_text_u64(c->text, lane->tid);
	}
	if (lane->no_switches) {
		prof_text_add(c->text, ",\"no_switches\":");
		prof_text_json(c->text, lane->no_switches);
	}
	prof_text_add(c->text, "}}");
	if (lane->switch_count > 0) {
		chrome_thread_name(c, CHROME_TID_OFF_CPU(i), lane->name, ": off the CPU");
		prof_text_add(c->text, ",\"switches_from\":");
		prof_text_u64(c->text, lane->switches_ns);
		prof_text_add(c->text, "}}");
	}
}

static void chrome_head(chrome *c, const char *process_name)
{
	prof_text_add(c->text, "{\"displayTimeUnit\":\"ns\",\"traceEvents\":[\n{\"ph\":\"M\",\"pid\":");
	prof_text_u64(c->text, c->pid);
	prof_text_add(c->text, ",\"tid\":1,\"name\":\"process_name\",\"args\":{\"name\":");
	prof_text_json(c->text, process_name);
	prof_text_add(c->text, "}}");
	chrome_thread_name(c, CHROME_TID_FRAMES, "frames", "");
	prof_text_add(c->text, "}}");
	for (uint32_t i = 0; i < c->snapshot->lane_count; i++)
		chrome_lane_names(c, i);
}

static void chrome_frames(chrome *c)
{
	const stilb_prof_snapshot *s = c->snapshot;
	for (uint32_t i = 0; i < s->frame_count; i++) {
		const stilb_prof_frame *frame = &s->frames[i];
		uint64_t limit = i + 1 < s->frame_count ? 10 * s->frames[i + 1].begin_ns : UINT64_MAX;
		chrome_slice(c, CHROME_TID_FRAMES, "frame", 10 * frame->begin_ns,
		             chrome_end(10 * frame->begin_ns, 10 * frame->end_ns, limit));
		chrome_open(c, 'i', CHROME_TID_FRAMES);
		chrome_time(c, ",\"ts\":", 10 * frame->begin_ns);
		prof_text_add(c->text, ",\"s\":\"g\",\"name\":\"frame\",\"args\":{\"number\":");
		prof_text_u64(c->text, frame->number);
		prof_text_add(c->text, "}}");
	}
}

/* ---- points and flows -------------------------------------------------------------------------------------------- */

/* Only flows with both ends are written: viewers do not draw an s without an f, and an f without an s is wrong. */
static bool chrome_flow_is_whole(const stilb_prof_snapshot *s, const stilb_prof_flow *flow)
{
	return flow->from_lane < s->lane_count && flow->to_lane < s->lane_count;
}

static uint64_t chrome_flows_cut(const stilb_prof_snapshot *s)
{
	uint64_t cut = 0;
	for (uint32_t i = 0; i < s->flow_count; i++)
		cut += !chrome_flow_is_whole(s, &s->flows[i]);
	return cut;
}

/* The lane and time of points[index] or flows[index], whichever the list is of. False: it is not written, so it belongs
 * on no lane's list. */
static bool chrome_listed(const stilb_prof_snapshot *s, int list, uint32_t index, uint32_t *lane, uint64_t *ns)
{
	if (list == CHROME_POINTS) {
		*lane = s->points[index].lane;
		*ns = s->points[index].ns;
		return *lane < s->lane_count && (!s->points[index].counter || isfinite(s->points[index].value));
	}
	const stilb_prof_flow *flow = &s->flows[index];
	*lane = list == CHROME_FROMS ? flow->from_lane : flow->to_lane;
	*ns = list == CHROME_FROMS ? flow->from_ns : flow->to_ns;
	return chrome_flow_is_whole(s, flow);
}

static void chrome_point(chrome *c, uint64_t tid, const stilb_prof_point *point)
{
	chrome_open(c, point->counter ? 'C' : 'i', tid);
	chrome_time(c, ",\"ts\":", 10 * point->ns);
	chrome_name(c, point->label);
	if (!point->counter) {
		prof_text_add(c->text, ",\"s\":\"t\"}");
		return;
	}
	prof_text_add(c->text, ",\"args\":{\"value\":");
	prof_text_double(c->text, point->value);
	prof_text_add(c->text, "}}");
}

/* Each flow gets an id of its own, since viewers join one s with one f. */
static void chrome_flow(chrome *c, uint64_t tid, const stilb_prof_flow *flow, bool from)
{
	chrome_open(c, from ? 's' : 'f', tid);
	chrome_time(c, ",\"ts\":", 10 * (from ? flow->from_ns : flow->to_ns));
	chrome_name(c, flow->label);
	prof_text_add(c->text, ",\"cat\":\"flow\",\"id\":");
	prof_text_u64(c->text, (uint64_t)(flow - c->snapshot->flows) + 1);
	if (!from)
		prof_text_add(c->text, ",\"bp\":\"e\"");
	if (!from && flow->frame < c->snapshot->frame_count) {
		prof_text_add(c->text, ",\"args\":{\"frame\":");
		prof_text_u64(c->text, c->snapshot->frames[flow->frame].number);
		prof_text_add(c->text, "}");
	}
	prof_text_add(c->text, "}");
}

static void chrome_write_listed(chrome *c, uint64_t tid, int list, uint32_t index)
{
	if (list == CHROME_POINTS)
		chrome_point(c, tid, &c->snapshot->points[index]);
	else
		chrome_flow(c, tid, &c->snapshot->flows[index], list == CHROME_FROMS);
}

/* The list whose next entry for this lane is the earliest, if that is before limit_ns; else -1. */
static int chrome_next_list(const chrome *c, uint32_t lane, uint64_t limit_ns)
{
	int first = -1;
	for (int list = 0; list < CHROME_LISTS; list++) {
		uint32_t unused;
		uint64_t ns;
		assert(c->next[list] <= c->lists[list].start[lane + 1] && "within the lane's part of the list");
		if (c->next[list] == c->lists[list].start[lane + 1])
			continue;
		chrome_listed(c->snapshot, list, c->lists[list].index[c->next[list]], &unused, &ns);
		if (ns < limit_ns) {
			limit_ns = ns;
			first = list;
		}
	}
	return first;
}

/* Writes all points and flow ends of the lane that are before limit_ns, the begin of the next zone. Those at limit_ns
 * itself come after that zone, since it encloses them. */
static void chrome_points_before(chrome *c, uint32_t lane, uint64_t limit_ns)
{
	for (int list; (list = chrome_next_list(c, lane, limit_ns)) >= 0;)
		chrome_write_listed(c, CHROME_TID_LANE(lane), list, c->lists[list].index[c->next[list]++]);
}

/* ---- lanes ------------------------------------------------------------------------------------------------------- */

/* The begin and end to be written for a zone, in tenths of nanoseconds: it ends before its parent ends, and before its
 * next sibling begins. */
static chrome_span chrome_place(chrome *c, const stilb_prof_lane *lane, uint32_t i)
{
	assert(lane->zones[i].size > 0 && i + lane->zones[i].size <= lane->zone_count);
	const stilb_prof_zone *zone = &lane->zones[i], *next = zone + zone->size;
	chrome_span around = zone->level > 0 ? c->spans[zone->level - 1] : (chrome_span){0, UINT64_MAX};
	/* NOLINTNEXTLINE(clang-analyzer-core.CallAndMessage): the parent has been written before */
	uint64_t latest = chrome_end(around.begin, UINT64_MAX, around.end);
	bool followed = i + zone->size < lane->zone_count && next->parent == zone->parent;
	chrome_span span = {.begin = chrome_min(10 * zone->begin_ns, latest)};
	span.end =
		chrome_end(span.begin, 10 * zone->end_ns, followed ? chrome_min(10 * next->begin_ns, latest) : around.end);
	c->spans[zone->level] = span;
	return span;
}

static void chrome_zone(chrome *c, const chrome_piece *prefix, const stilb_prof_zone *zone, chrome_span span)
{
	assert(prefix->size <= CHROME_PREFIX_MAX && prefix->text[CHROME_PHASE_AT] == 'X');
	char *at = prof_text_room(c->text, CHROME_PREFIX_MAX + 2 * PROF_PUT_US_MAX + 16);
	memcpy(at, prefix->text, prefix->size);
	if (zone->open)
		at[CHROME_PHASE_AT] = 'B';
	at = prof_put_us(at + prefix->size, span.begin);
	if (!zone->open)
		at = prof_put_us(prof_put(at, ",\"dur\":", 7), span.end - span.begin);
	prof_text_fill(c->text, at);
	chrome_name(c, zone->label);
	prof_text_bytes(c->text, "}", 1);
	c->zones_written++;
}

static void chrome_lane(chrome *c, uint32_t index)
{
	const stilb_prof_lane *lane = &c->snapshot->lanes[index];
	char prefix_text[CHROME_PREFIX_MAX];
	char *prefix_end = chrome_put_prefix(prefix_text, 'X', c->pid, CHROME_TID_LANE(index));
	prefix_end = prof_put(prefix_end, ",\"ts\":", 6);
	chrome_piece prefix = {prefix_text, (size_t)(prefix_end - prefix_text)};
	for (int list = 0; list < CHROME_LISTS; list++)
		c->next[list] = c->lists[list].start[index];
	for (uint32_t i = 0; i < lane->zone_count && c->text->error == 0; i++) {
		prof_give_way(i);
		chrome_points_before(c, index, lane->zones[i].begin_ns);
		chrome_zone(c, &prefix, &lane->zones[i], chrome_place(c, lane, i));
	}
	chrome_points_before(c, index, UINT64_MAX);
	for (int list = 0; list < CHROME_LISTS; list++)
		assert(c->next[list] == c->lists[list].start[index + 1] && "all of the lane's are written");
}

static void chrome_switches(chrome *c, uint32_t index)
{
	const stilb_prof_lane *lane = &c->snapshot->lanes[index];
	for (uint32_t i = 0; i < lane->switch_count; i++) {
		const stilb_prof_switch *out = &lane->switches[i];
		uint64_t limit = i + 1 < lane->switch_count ? 10 * lane->switches[i + 1].out_ns : UINT64_MAX;
		chrome_slice(c, CHROME_TID_OFF_CPU(index), out->preempted ? "preempted" : "sleeping", 10 * out->out_ns,
		             chrome_end(10 * out->out_ns, 10 * out->in_ns, limit));
	}
}

/* ---- otherData --------------------------------------------------------------------------------------------------- */

static void chrome_account(chrome *c, const char *name, uint64_t value)
{
	prof_text_add(c->text, ",\"");
	prof_text_add(c->text, name);
	prof_text_add(c->text, "\":");
	prof_text_u64(c->text, value);
}

/* A member of otherData: a number of nanoseconds, rounded to three decimals. */
static void chrome_account_ns(chrome *c, const char *name, double ns)
{
	uint64_t thousandths = ns > 0 && ns < 1e12 ? (uint64_t)(ns * 1000 + 0.5) : 0;
	prof_text_add(c->text, ",\"");
	prof_text_add(c->text, name);
	chrome_time(c, "\":", 10 * thousandths);
}

static void chrome_tail(chrome *c)
{
	const stilb_prof_snapshot *s = c->snapshot;
	prof_text_add(c->text, "\n],\"otherData\":{\"clock\":");
	prof_text_json(c->text, s->clock ? s->clock : "");
	chrome_account(c, "hz", s->hz > 0 && s->hz < 1e18 ? (uint64_t)(s->hz + 0.5) : 0);
	chrome_account_ns(c, "resolution_ns", s->resolution_ns);
	chrome_account_ns(c, "bias_ns", s->bias_ns);
	chrome_account_ns(c, "zone_cost_ns", s->zone_cost_ns);
	chrome_account(c, "epoch_ns", s->epoch_ns);
	chrome_account(c, "begin_ns", s->begin_ns);
	chrome_account(c, "end_ns", s->end_ns);
	chrome_account(c, "events_recorded", s->events_recorded);
	chrome_account(c, "events_lost", s->events_lost);
	chrome_account(c, "events_held", s->events_held);
	chrome_account(c, "too_deep", s->too_deep);
	chrome_account(c, "without_ring", s->without_ring);
	chrome_account(c, "zones_written", c->zones_written);
	chrome_account(c, "flows_cut", chrome_flows_cut(s));
	prof_text_add(c->text, "}}\n");
}

/* ---- preparation ------------------------------------------------------------------------------------------------- */

static bool chrome_make_names(chrome *c)
{
	const stilb_prof_snapshot *s = c->snapshot;
	size_t room = 1;
	for (uint32_t i = 0; i < s->label_count; i++)
		room += 8 + PROF_PUT_JSON_MAX(strlen(s->labels[i].name));
	c->names = malloc(((size_t)s->label_count + 1) * sizeof *c->names);
	c->name_bytes = malloc(room);
	if (!c->names || !c->name_bytes)
		return false;
	char *at = c->name_bytes;
	for (uint32_t i = 0; i < s->label_count; i++) {
		c->names[i].text = at;
		at = prof_put_json(prof_put(at, ",\"name\":", 8), s->labels[i].name);
		c->names[i].size = (size_t)(at - c->names[i].text);
	}
	assert((size_t)(at - c->name_bytes) < room);
	return true;
}

static int chrome_compare_froms(const void *a, const void *b, void *flows)
{
	const stilb_prof_flow *x = (const stilb_prof_flow *)flows + *(const uint32_t *)a;
	const stilb_prof_flow *y = (const stilb_prof_flow *)flows + *(const uint32_t *)b;
	return x->from_ns != y->from_ns ? (x->from_ns > y->from_ns) - (x->from_ns < y->from_ns) : (x > y) - (x < y);
}

/* Makes a list. Points and the ends of flows ascend already; the begins of flows are sorted. False: no memory. */
static bool chrome_make_list(chrome *c, int list, uint32_t count)
{
	const stilb_prof_snapshot *s = c->snapshot;
	chrome_list *made = &c->lists[list];
	uint32_t lane;
	uint64_t ns;
	made->index = malloc(((size_t)count + 1) * sizeof *made->index);
	made->start = calloc((size_t)s->lane_count + 2, sizeof *made->start);
	if (!made->index || !made->start)
		return false;
	/* A counting sort in one array. The first loop makes start[lane + 2] the number of the lane's entries; the second
	 * makes start[lane + 1] the index of its first entry; the third, which fills in the entries, advances that to the
	 * index after its last entry, which is where the next lane begins, as chrome_list promises. */
	for (uint32_t i = 0; i < count; i++)
		if (chrome_listed(s, list, i, &lane, &ns))
			made->start[lane + 2]++;
	for (uint32_t i = 0; i < s->lane_count; i++)
		made->start[i + 2] += made->start[i + 1];
	for (uint32_t i = 0; i < count; i++)
		if (chrome_listed(s, list, i, &lane, &ns))
			made->index[made->start[lane + 1]++] = i;
	assert(made->start[0] == 0 && made->start[s->lane_count] <= count);
	for (uint32_t i = 0; list == CHROME_FROMS && i < s->lane_count; i++)
		qsort_r(made->index + made->start[i], made->start[i + 1] - made->start[i], sizeof *made->index,
		        chrome_compare_froms, (void *)s->flows);
	return true;
}

static bool chrome_make(chrome *c)
{
	const stilb_prof_snapshot *s = c->snapshot;
	/* Room for every level; pages of levels that do not occur are never touched, so they take no memory. */
	c->spans = malloc(((size_t)UINT16_MAX + 1) * sizeof *c->spans);
	return c->spans && chrome_make_names(c) && chrome_make_list(c, CHROME_POINTS, s->point_count) &&
	       chrome_make_list(c, CHROME_FROMS, s->flow_count) && chrome_make_list(c, CHROME_TOS, s->flow_count);
}

static void chrome_free(chrome *c)
{
	for (int list = 0; list < CHROME_LISTS; list++) {
		free(c->lists[list].index);
		free(c->lists[list].start);
	}
	free(c->spans);
	free(c->name_bytes);
	free(c->names);
}

int stilb_prof_trace_write_chrome(const stilb_prof_snapshot *snapshot, const char *process_name, stilb_prof_sink sink)
{
	assert(snapshot && sink.write);
	chrome c = {.snapshot = snapshot, .text = prof_text_create(sink), .pid = (uint64_t)getpid()};
	bool made = c.text && chrome_make(&c);
	if (made) {
		chrome_head(&c, process_name ? process_name : program_invocation_short_name);
		chrome_frames(&c);
		for (uint32_t i = 0; i < snapshot->lane_count && c.text->error == 0; i++) {
			chrome_lane(&c, i);
			chrome_switches(&c, i);
		}
		chrome_tail(&c);
	}
	chrome_free(&c);
	return prof_text_finish(c.text, made ? 0 : -ENOMEM);
}
