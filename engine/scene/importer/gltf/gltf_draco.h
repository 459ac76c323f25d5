/*
 * gltf_draco: meshes compressed by KHR_draco_mesh_compression, decompressed with Google's library. It is C++: this file
 * and gltf_draco.cpp are all that knows it, no exception leaves them, and what comes out is plain arrays.
 *
 * Threads.     [any-thread]
 */
#ifndef STILB_SCENE_GLTF_DRACO_H
#define STILB_SCENE_GLTF_DRACO_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define GLTF_DRACO_VALUES 8

/* The values of one attribute of all points, to be decoded. */
typedef struct gltf_draco_values {
	bool wanted;
	uint32_t id;         /* the library's unique id, as the glTF file names it */
	uint32_t components; /* of a point */
	bool alpha;          /* a fourth one that is missing is 1 */
	float *data;         /* out: [points][components], normalised integers scaled; NULL: not wanted */
} gltf_draco_values;

/* The three arrays of numbers are of malloc. */
typedef struct gltf_draco_mesh {
	uint32_t *indices; /* [index_count], each < point_count */
	uint32_t index_count, point_count;
	gltf_draco_values values[GLTF_DRACO_VALUES];
} gltf_draco_mesh;

/* Decodes size bytes. mesh->values say what is wanted; all other members are {0}. Returns NULL, or the reason why it
 * failed: static, and the arrays are NULL then. *memory: the reason is a lack of memory. */
const char *gltf_draco_decode(const unsigned char *data, size_t size, gltf_draco_mesh *mesh, bool *memory);

/* Frees the arrays; accepts {0}. */
void gltf_draco_finish(gltf_draco_mesh *mesh);

#ifdef __cplusplus
}
#endif

#endif
