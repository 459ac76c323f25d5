/*
 * gi_cache_octree: finds the records of the irradiance cache by position. A record is valid in an ellipsoid, and is
 * listed in the cells that the box around that touches, at most eight, at the depth where cells are at least as large
 * as the box. A lookup walks from the root to the smallest cell at its position and tries the records listed on the
 * way.
 *
 * Threads.  Any number of threads insert and look up at once, without a lock: cells, records and their entries in the
 *           cells' lists are only ever added, and a list grows at its head. A lookup sees a record wholly or not at
 *           all.
 * Order.    A lookup sums the newest record of a cell first: the same records inserted in the same order give the
 *           same bits.
 */
#ifndef STILB_GI_CACHE_OCTREE_H
#define STILB_GI_CACHE_OCTREE_H

#include "gi/cache/gi_cache_record.h"

typedef struct gi_cache_octree gi_cache_octree;

/* low, high: a box around all positions, metres; positions outside it are treated as at its border. STILB_ERROR_MEMORY;
 * then *out is NULL. */
stilb_result gi_cache_octree_create(const float low[3], const float high[3], gi_cache_octree **out);
void gi_cache_octree_destroy(gi_cache_octree *octree);

/* Copies the record, whose radii are positive. False: no memory; then lookups find it in a part of its ellipsoid, or
 * nowhere. [any-thread] */
bool gi_cache_octree_insert(gi_cache_octree *octree, const gi_cache_record *record);

/* Irradiance at a position, the weighted mean of all records that are valid there. False: none is, and irradiance is
 * not written. turn: see gi_cache_record.h. [any-thread] */
bool gi_cache_octree_lookup(const gi_cache_octree *octree, stilb_vec3 position, stilb_vec3 normal, float turn,
                            stilb_vec3 *irradiance);

/* True if a record has an error (gi_cache_record_error) below reach at that position and normal. [any-thread] */
bool gi_cache_octree_covers(const gi_cache_octree *octree, stilb_vec3 position, stilb_vec3 normal, float turn,
                            float reach);

/* True if a record lies closer than distance, metres, to the position. Only records are tried that are listed in cells
 * which contain the position, as all are that are valid there. [any-thread] */
bool gi_cache_octree_record_near(const gi_cache_octree *octree, stilb_vec3 position, float distance);

/* Neighbour clamping: distances to what records see obey the triangle inequality, so a record's radius is at most
 * that of a neighbour plus the distance to it. Limits the radii of a record that is about to be inserted by the
 * records that cover its position; those are not changed, so that what they cover stays covered. [any-thread]
 * Source: Krivanek et al. (2006), which clamps in both directions. */
void gi_cache_octree_clamp(const gi_cache_octree *octree, gi_cache_record *record);

/* Number of records [any-thread], and record i < count, in the order of insertion if one thread inserted; NULL if
 * memory ran out for it. Not while others insert. */
uint32_t gi_cache_octree_count(const gi_cache_octree *octree);
const gi_cache_record *gi_cache_octree_record(const gi_cache_octree *octree, uint32_t i);

#endif
