#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
// The lists of a view's cells: a group finds the lights of one row of one slice, in their order, so that lists need not
// be sorted. Without CELLS_FILL it counts them; then cells_sum.comp says where each row's lists lie; with it they are
// written there, as far as there is room. Source: Olsson, Billeter and Assarsson, "Clustered Deferred and Forward
// Shading" (2012); the order of the passes is that of any stable counting sort.
layout(local_size_x = 64) in;
const uint GROUP = 64u, MOST_COLUMNS = 2048u;

#include "cells.glsl"

shared uint cursors[MOST_COLUMNS]; // of each column: the lights so far, and with CELLS_FILL what lies before them
shared uint spans[GROUP];          // of the last GROUP lights: first | last << 16
shared uint kept[2];               // a bit for each of them that reaches the row

// Adds the last GROUP lights, of which the first is number `from`, to the lists of the columns.
void add_lights(uint self, uint from, uint ids)
{
	for (uint c = self; c < push.cells.columns; c += GROUP) {
		uint at = cursors[c];
		for (uint k = 0u; k < 2u; k++)
			for (uint bits = kept[k]; bits != 0u; bits &= bits - 1u) {
				uint i = 32u * k + uint(findLSB(bits));
				if (c < (spans[i] & 0xffffu) || c > spans[i] >> 16)
					continue;
#ifdef CELLS_FILL
				if (at < push.room)
					push.lists.words[ids + at] = from + i;
#endif
				at++;
			}
		cursors[c] = at;
	}
}

#ifdef CELLS_FILL
// What is there once: how depth is cut, where the last list ends, and the list that cells without room have, of all.
void fill_rest(uint self, uint cells)
{
	uint across = gl_NumWorkGroups.x, groups = across * gl_NumWorkGroups.y;
	uint group = gl_WorkGroupID.x + across * gl_WorkGroupID.y;
	for (uint i = group * GROUP + self; i < push.cells.light_count; i += groups * GROUP)
		push.lists.words[cells + 1u + i] = i;
	if (group + self > 0u)
		return;
	push.lists.depth_plane = push.cells.depth_plane;
	push.lists.slice = push.cells.slice;
	push.lists.room = push.room;
	push.lists.all = push.cells.light_count;
	push.lists.words[cells] = push.rows.sums[groups];
}
#endif

void main()
{
	uint self = gl_LocalInvocationIndex, row = gl_WorkGroupID.x, slice = gl_WorkGroupID.y;
	uint columns = push.cells.columns, count = push.cells.light_count;
	uint number = row + push.cells.rows * slice, cell = columns * number;
	uint cells = columns * push.cells.rows * push.cells.slices, ids = cells + 1u + count;
	for (uint c = self; c < columns; c += GROUP) {
		cursors[c] = 0u;
#ifdef CELLS_FILL
		cursors[c] = push.rows.sums[number] + push.lists.words[cell + c];
		push.lists.words[cell + c] = cursors[c];
#endif
	}
	barrier(); // where no light follows, the cursors are read as they are
	CellRow here = cell_row(row, slice);
	for (uint from = 0u; from < count; from += GROUP) {
		uvec2 span = from + self < count ? span_of(push.reached.lights[from + self], here) : NO_SPAN;
		spans[self] = span.x | span.y << 16;
		if (self < 2u)
			kept[self] = 0u;
		barrier();
		if (span.x <= span.y)
			atomicOr(kept[self / 32u], 1u << self % 32u);
		barrier();
		if ((kept[0] | kept[1]) != 0u)
			add_lights(self, from, ids);
		barrier();
	}
#ifdef CELLS_FILL
	fill_rest(self, cells);
#else
	if (self > 0u)
		return;
	uint sum = 0u;
	for (uint c = 0u; c < columns; c++) {
		push.lists.words[cell + c] = sum;
		sum += cursors[c];
	}
	push.rows.sums[number] = sum;
#endif
}
