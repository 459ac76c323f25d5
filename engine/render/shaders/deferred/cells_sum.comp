#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
// Where the lists of each row of each slice begin: the sums of the lengths before it. One group, of which each thread
// adds up a part of the rows. Source: Blelloch, "Prefix Sums and Their Applications" (1990).
layout(local_size_x = 256) in;
const uint GROUP = 256u;

#include "cells.glsl"

shared uint parts[GROUP];

void main()
{
	uint self = gl_LocalInvocationIndex, count = push.cells.rows * push.cells.slices;
	uint each = (count + GROUP - 1u) / GROUP, first = self * each, end = min(first + each, count), sum = 0u;
	for (uint i = first; i < end; i++)
		sum += push.rows.sums[i];
	parts[self] = sum;
	for (uint step = 1u; step < GROUP; step *= 2u) {
		barrier();
		uint before = self >= step ? parts[self - step] : 0u;
		barrier();
		parts[self] += before;
	}
	uint at = parts[self] - sum;
	for (uint i = first; i < end; i++) {
		uint length = push.rows.sums[i];
		push.rows.sums[i] = at;
		at += length;
	}
	if (self == GROUP - 1u) {
		push.rows.sums[count] = parts[self];
		push.counts.counts[push.pass] = parts[self];
	}
}
