/*
 * gi_scene: a scene made ready for rays: triangles in Embree's tree, lights in a table. Made once, then only read.
 *
 * Life cycle.  stilb_gi_scene_create -> any number of renders (gi_render.h) -> stilb_gi_scene_destroy.
 * Build.       Embree runs on the threads that ask: its tree is built by the pool's own workers, one join each, and
 *              Embree keeps no threads of its own.
 * Threads.     create and destroy: [main-thread] of the pool; a finished scene is read by any thread.
 */
#ifndef STILB_GI_SCENE_H
#define STILB_GI_SCENE_H

#include "base/base.h"
#include "jobs/job.h"
#include "scene/scene.h"

typedef struct stilb_gi_scene stilb_gi_scene;

/* What Embree may use. The same bits need the same one: they walk the tree in other ways. */
#define STILB_GI_ISAS(X) X(AUTO, auto) X(SSE2, sse2) X(SSE42, sse42) X(AVX, avx) X(AVX2, avx2) X(AVX512, avx512)

typedef enum stilb_gi_isa {
#define STILB_GI_ISA_ENUM(id, name) STILB_GI_ISA_##id,
	STILB_GI_ISAS(STILB_GI_ISA_ENUM)
#undef STILB_GI_ISA_ENUM
		STILB_GI_ISA_COUNT
} stilb_gi_isa;

/* How rays meet triangles. A program that names only BRUTE does not load Embree. */
typedef struct stilb_gi_intersector stilb_gi_intersector;
extern const stilb_gi_intersector stilb_gi_embree;
extern const stilb_gi_intersector stilb_gi_brute; /* every ray against every triangle, in double: the truth of tests */

typedef struct stilb_gi_scene_desc {
	stilb_job_pool *pool; /* builds the tree */
	const stilb_gi_intersector *intersector;
	stilb_gi_isa isa;
	uint64_t memory; /* bytes that the tree may take; 0: what the machine has free */
} stilb_gi_scene_desc;

/* Embree, every instruction set. */
stilb_gi_scene_desc stilb_gi_scene_desc_default(stilb_job_pool *pool);

/* What was made: for --stats and the bench. */
typedef struct stilb_gi_scene_info {
	uint64_t triangles; /* of the scene: a mesh counts once for each of its parts */
	uint64_t flat;      /* left out: triangles of area 0, such as those at the poles of a sphere; nothing is missing */
	uint64_t invalid;   /* left out: triangles with a corner that is NaN, infinite, beyond 1e10 m or not in the mesh */
	uint64_t bytes;     /* of Embree's tree, and of ours */
	uint32_t lights;    /* emitting triangles and lights without a size */
	double build_s;     /* Embree's part */
	const char *isa;    /* "avx512", ...: what Embree runs on */
	float low[3], high[3]; /* a box around all triangles; low > high: there are none */
} stilb_gi_scene_info;

/* Copies what it needs: scene may go afterwards, but for its textures and environment, which must stay.
 * STILB_ERROR_ARGUMENT: an isa this machine lacks, too many triangles; STILB_ERROR_MEMORY. */
stilb_result stilb_gi_scene_create(const stilb_scene *scene, const stilb_gi_scene_desc *desc, stilb_gi_scene **out);

void stilb_gi_scene_destroy(stilb_gi_scene *scene);

const stilb_gi_scene_info *stilb_gi_scene_info_of(const stilb_gi_scene *scene);

/* Embree's version, as the program was built for: "3.13.5". [any-thread] */
const char *stilb_gi_library_version(void);

#endif
