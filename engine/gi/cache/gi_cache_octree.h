/*
 * gi_cache_octree: records by place. A record lies in the cells that its ellipsoid's box touches, up to eight, at the
 * depth where cells are as large as the box or larger; so a lookup walks from the root to the cell of its place and
 * tries what lies on the way.
 *
 * Threads.  Any number of threads insert and look up at once, without a lock: cells, records and mentions of them are
 *           only ever added, and a list grows at its head. What a lookup sees is whole.
 * Order.    Lookups add up a cell's newest record first: who inserts the same records in the same order gets the same
 *           bits.
 */
#ifndef STILB_GI_CACHE_OCTREE_H
#define STILB_GI_CACHE_OCTREE_H

#include "gi/cache/gi_cache_record.h"

typedef struct gi_cache_octree gi_cache_octree;

/* low, high: the box that holds all places. STILB_ERROR_MEMORY. */
stilb_result gi_cache_octree_create(const float low[3], const float high[3], gi_cache_octree **out);
void gi_cache_octree_destroy(gi_cache_octree *octree);

/* Copies the record. False: there is no memory left, and it is not in the tree. [any-thread] */
bool gi_cache_octree_insert(gi_cache_octree *octree, const gi_cache_record *record);

/* Irradiance at a place from all records that hold there. False: there are none. [any-thread] */
bool gi_cache_octree_lookup(const gi_cache_octree *octree, stilb_vec3 position, stilb_vec3 normal, float turn,
                            stilb_vec3 *irradiance);

/* Whether there is one whose error there is below reach. [any-thread] */
bool gi_cache_octree_covers(const gi_cache_octree *octree, stilb_vec3 position, stilb_vec3 normal, float turn,
                            float reach);

/* Whether a record whose radii cover the place lies within distance of it. [any-thread] */
bool gi_cache_octree_record_near(const gi_cache_octree *octree, stilb_vec3 position, float distance);

/* Neighbour clamping: distances to what is seen obey the triangle inequality, so a record's radius is at most its
 * neighbour's and the way to it. Limits a record that is about to be inserted by those that cover its place; those stay
 * as they are, so that no place they cover ever loses them. [any-thread]
 * Source: Krivanek et al. (2006), which clamps in both directions. */
void gi_cache_octree_clamp(const gi_cache_octree *octree, gi_cache_record *record);

/* Records so far [any-thread], and the i-th of them, in the order of insertion where one thread inserted: while nobody
 * does. */
uint32_t gi_cache_octree_count(const gi_cache_octree *octree);
const gi_cache_record *gi_cache_octree_record(const gi_cache_octree *octree, uint32_t i);

#endif
