/*
 * Plans as text, so that tests can be read: one row a line.
 *
 *   image NAME FORMAT [WIDTHxHEIGHT | scale S] [cube | 3d D | 1d] [mips N] [layers N] [samples N]
 *         [keep] [output] [owned N]
 *   buffer NAME BYTES [keep] [output] [owned N]
 *   draws | screen | dispatch | copy NAME ITEM...
 *   show NAME
 *   cut NAME          the frame ends with this pass
 *
 * An item is WORD:NAME. Attachments, of colour or depth by the image's format: clear, over (kept), fresh (discarded),
 * test (read-only depth); clear:A>B resolves into B. Uses: sample, load, store, modify (storage: read, write, both),
 * vertices, indirect, from, to. NAME' reads last frame's. NAME[M], NAME[M-N], NAME[M/L], NAME[M-N/L-K], NAME[a/L]:
 * mips and layers, `a` for all mips. Dispatches have 1 x 1 x 1 groups unless an item is groups:0. queue:compute and
 * queue:copy say where a pass runs. Buffers' addresses
 * take the places 0, 8, 16, ... among the constants, sampled and storage images the slots 0, 1, 2, ....
 */
#ifndef GPU_SCRIPT_H
#define GPU_SCRIPT_H

#include "gpu/gpu_plan.h"

/* Adds the script's rows to a plan that has begun. The texts stay until the next call but fifteen. */
void script_rows(stilb_gpu_plan *plan, const char *script);

/* Begins a plan of 64 x 64 pixels, adds the rows, makes it, and fails the test if that fails. */
void script_make(stilb_gpu_plan *plan, const char *script);

/* The barriers, one a line: "PASS: RESOURCE[RANGE] FROM+FROM > TO+TO [discard] [zero] [previous] [memory]", ranges only
 * of resources with several mips or layers, `a` for all mips or layers, the pass "end" after the last. free() it. */
char *script_barriers(const stilb_gpu_plan *plan);

/* The waits between queues, one a line: "PASS waits for PASS", the pass "end" for the frame's end. free() it. */
char *script_waits(const stilb_gpu_plan *plan);

#endif
