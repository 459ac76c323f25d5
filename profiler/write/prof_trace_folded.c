/* Folded stacks, the text format of flame graphs: the zones of all frames are merged into one tree per lane, and each
 * node with self time (time outside its children) becomes a line "lane;zone;zone inside NANOSECONDS". */
#include "profiler/prof_internal.h"
#include "profiler/write/prof_text.h"

#include <assert.h>
#include <errno.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#define FOLDED_NONE UINT32_MAX

typedef struct folded_node {
	uint32_t parent; /* index of a node; FOLDED_NONE: the node is a lane */
	uint32_t label;  /* of the zones merged into the node; of a lane: its index in the snapshot */
	uint64_t self_ns;
} folded_node;

typedef struct folded {
	const stilb_prof_snapshot *snapshot;
	folded_node *nodes; /* parents first */
	uint32_t count, capacity;
	uint32_t *slots;   /* hash table by parent and label: 1 + index of the node, 0: free; 2 * capacity slots */
	uint32_t *of_zone; /* for each zone of the lane being read: its node */
} folded;

static uint32_t *folded_slot(const folded *f, uint32_t parent, uint32_t label)
{
	assert(f->capacity > 0 && f->count <= f->capacity && "a slot is free, or the search would not end");
	uint32_t mask = 2 * f->capacity - 1;
	uint64_t key = (uint64_t)parent << 32 | label;
	uint32_t at = (uint32_t)(key * UINT64_C(0x9e3779b97f4a7c15) >> 32) & mask; /* Fibonacci hashing */
	while (f->slots[at] != 0 &&
	       (f->nodes[f->slots[at] - 1].parent != parent || f->nodes[f->slots[at] - 1].label != label))
		at = (at + 1) & mask;
	return &f->slots[at];
}

static bool folded_grow(folded *f)
{
	uint32_t capacity = f->capacity > 0 ? 2 * f->capacity : 256;
	folded_node *nodes = realloc(f->nodes, capacity * sizeof *nodes);
	if (nodes)
		f->nodes = nodes;
	uint32_t *slots = nodes ? calloc(2 * (size_t)capacity, sizeof *slots) : NULL;
	if (!slots)
		return false;
	free(f->slots);
	f->slots = slots;
	f->capacity = capacity;
	for (uint32_t i = 0; i < f->count; i++)
		*folded_slot(f, nodes[i].parent, nodes[i].label) = i + 1;
	return true;
}

/* The node of a label under parent, made if there is none. FOLDED_NONE: no memory. */
static uint32_t folded_node_of(folded *f, uint32_t parent, uint32_t label)
{
	if (f->count == f->capacity && !folded_grow(f))
		return FOLDED_NONE;
	uint32_t *slot = folded_slot(f, parent, label);
	if (*slot == 0) {
		f->nodes[f->count++] = (folded_node){.parent = parent, .label = label};
		*slot = f->count;
	}
	return *slot - 1;
}

static bool folded_lane(folded *f, uint32_t index)
{
	const stilb_prof_lane *lane = &f->snapshot->lanes[index];
	uint32_t root = folded_node_of(f, FOLDED_NONE, index);
	uint32_t *of_zone = realloc(f->of_zone, ((size_t)lane->zone_count + 1) * sizeof *of_zone);
	if (of_zone)
		f->of_zone = of_zone;
	if (root == FOLDED_NONE || !of_zone)
		return false;
	for (uint32_t i = 0; i < lane->zone_count; i++) {
		const stilb_prof_zone *zone = &lane->zones[i];
		prof_give_way(i);
		assert(zone->parent < i || zone->parent == STILB_PROF_NONE);
		of_zone[i] = folded_node_of(f, zone->parent < i ? of_zone[zone->parent] : root, zone->label);
		if (of_zone[i] == FOLDED_NONE)
			return false;
		f->nodes[of_zone[i]].self_ns += zone->self_ns;
	}
	return true;
}

/* ';' separates the names of a line, so it becomes ',' inside one; ends of lines become spaces. */
static void folded_name(prof_text *text, const char *name)
{
	for (const char *at = name; *at != 0; at++)
		prof_text_bytes(text, *at == ';' ? "," : *at == '\n' || *at == '\r' ? " " : at, 1);
}

static void folded_line(const folded *f, uint32_t node, prof_text *text, uint32_t *path)
{
	assert(node < f->count);
	uint32_t depth = 0;
	for (uint32_t i = node; i != FOLDED_NONE; i = f->nodes[i].parent)
		path[depth++] = i;
	assert(depth > 0 && f->nodes[path[depth - 1]].label < f->snapshot->lane_count && "the root is a lane");
	folded_name(text, f->snapshot->lanes[f->nodes[path[--depth]].label].name);
	while (depth-- > 0) {
		prof_text_bytes(text, ";", 1);
		folded_name(text, f->snapshot->labels[f->nodes[path[depth]].label].name);
	}
	prof_text_bytes(text, " ", 1);
	prof_text_u64(text, f->nodes[node].self_ns);
	prof_text_bytes(text, "\n", 1);
}

int stilb_prof_trace_write_folded(const stilb_prof_snapshot *snapshot, stilb_prof_sink sink)
{
	assert(snapshot && sink.write);
	folded f = {.snapshot = snapshot};
	prof_text *text = prof_text_create(sink);
	bool good = text;
	for (uint32_t i = 0; i < snapshot->lane_count && good; i++)
		good = folded_lane(&f, i);
	uint32_t *path = good ? malloc(((size_t)f.count + 1) * sizeof *path) : NULL;
	for (uint32_t i = 0; path && i < f.count && text->error == 0; i++)
		if (f.nodes[i].self_ns > 0)
			folded_line(&f, i, text, path);
	good = path;
	free(path);
	free(f.of_zone);
	free(f.slots);
	free(f.nodes);
	return prof_text_finish(text, good ? 0 : -ENOMEM);
}
