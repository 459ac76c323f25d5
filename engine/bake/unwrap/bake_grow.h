/*
 * bake_grow: cuts a surface into charts that are nearly flat: connected triangles whose normals lie within a cone.
 * [one-writer]
 */
#ifndef BAKE_GROW_H
#define BAKE_GROW_H

#include "bake/unwrap/bake_topology.h"

/* Writes the chart of each triangle, BAKE_NONE for those of area 0, and how many there are: numbered by their first
 * triangles. Charts are connected. STILB_ERROR_MEMORY. */
stilb_result bake_grow(const bake_topology *topology, const stilb_bake_unwrap_options *options, uint32_t *chart,
                       uint32_t *chart_count);

#endif
