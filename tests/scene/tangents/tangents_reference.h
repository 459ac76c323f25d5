/* What the public implementation of MikkTSpace says of the meshes of tangents_meshes.h.
 *
 * Made outside of the repository by the npm package mikktspace 1.1.1 (the crate mikktspace 0.3 as WebAssembly) under
 * node 20, from the file that `test_scene_tangents FILE` writes; the build that @khronosgroup/gltf-viewer 1.1.0 ships
 * gave the same. A script takes the file apart, hands each mesh's corners without indices to generateTangents, and
 * negates w, as that viewer does. Where the result is no tangent (step 4 of scene_tangents.h fails or there was no
 * triangle) it is projected onto the plane of the normal, and if that fails too, the X axis or then the Y axis is, all
 * in float (Math.fround) as scene_tangents.h says. */
#ifndef TANGENTS_REFERENCE_H
#define TANGENTS_REFERENCE_H

#include "tangents_meshes.h"

/* A random mesh, in short. Of each corner in the order of the indices: FNV-1a of two numbers of 32 bits, the first
 * corner with the same eight values and the same tangent, and 1 if w is negative, else 0: so all splits and signs are
 * in `splits`. sums[j] is the sum over all corners c and components k of tangents[c][k] * (b / 128 - 1), where b is
 * byte j + 1 of (3 c + k + 1) * 2654435761 modulo 2^32: a direction that is off by x moves it by about x / 2. */
typedef struct tangents_sum {
	uint64_t splits;
	double sums[2];
} tangents_sum;

extern const tangents_sum tangents_sums[TANGENTS_RANDOM];

/* The bits of all corners' tangents of the classic meshes, one mesh after the other. */
extern const uint32_t tangents_classic_bits[][4];

#endif
