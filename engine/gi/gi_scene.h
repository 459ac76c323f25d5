/*
 * gi_scene: a scene made ready for ray tracing: its triangles in an acceleration structure, its lights in tables.
 *
 * Life cycle.  stilb_gi_scene_create -> any number of renders (gi_render.h) -> stilb_gi_scene_update after edits of the
 *              scene, and renders again -> stilb_gi_scene_destroy. In between it does not change, whatever becomes of
 *              the scene, but for pixels.
 *
 *   stilb_gi_scene_desc desc = stilb_gi_scene_desc_default(pool);
 *   stilb_gi_scene *gi_scene;
 *   if (stilb_gi_scene_create(scene, &desc, &gi_scene) != STILB_OK)
 *       return stilb_error_message();
 *   ...
 *   stilb_gi_scene_destroy(gi_scene);
 *
 * Build.       Embree (the ray tracing library) builds its tree on the pool's threads, one job pinned to each, and
 *              keeps no threads of its own.
 * Moving.      With desc.movable, what moves costs the top of the tree, not the triangles:
 *
 *   desc.movable = true;
 *   result = stilb_gi_scene_create(scene, &desc, &gi_scene);
 *   while (result == STILB_OK && next_picture(scene)) {        moves models: scene_edit.h
 *       result = stilb_gi_scene_update(gi_scene, scene, &desc);
 *       if (result == STILB_OK)
 *           result = render_picture(gi_scene);                 stilb_gi_render_create ... _destroy
 *   }
 *
 * Threads.     create, update and destroy: [main-thread] of the pool, or a thread outside it (desc.caller), the same
 *              one. In between the scene is read by any thread.
 */
#ifndef STILB_GI_SCENE_H
#define STILB_GI_SCENE_H

#include "base/base.h"
#include "jobs/job.h"
#include "scene/scene.h"

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

typedef struct stilb_gi_scene stilb_gi_scene;

/* Instruction sets that Embree may use: X(ENUM, identifier). AUTO is the widest this CPU has. Each walks the tree in
 * another way, so pictures have the same bits only with the same one. */
#define STILB_GI_ISAS(X) X(AUTO, auto) X(SSE2, sse2) X(SSE42, sse42) X(AVX, avx) X(AVX2, avx2) X(AVX512, avx512)

typedef enum stilb_gi_isa {
#define STILB_GI_ISA_ENUM(id, name) STILB_GI_ISA_##id,
	STILB_GI_ISAS(STILB_GI_ISA_ENUM)
#undef STILB_GI_ISA_ENUM
		STILB_GI_ISA_COUNT
} stilb_gi_isa;

/* A method to intersect rays with triangles. */
typedef struct stilb_gi_intersector stilb_gi_intersector;

/* By the library Embree 3. A program that never names this intersector does not load the library. */
extern const stilb_gi_intersector stilb_gi_embree;

/* Every ray against every triangle, in double: the reference in tests, far too slow for pictures. */
extern const stilb_gi_intersector stilb_gi_brute;

typedef struct stilb_gi_scene_desc {
	/* Its threads build the tree; it is not used after stilb_gi_scene_create. caller: the index in it of the thread
	 * that calls that: 0, or STILB_JOB_OUTSIDE for a thread that is not of the pool, which then builds in place of one
	 * worker. */
	stilb_job_pool *pool;
	uint32_t caller;
	const stilb_gi_intersector *intersector;
	/* The instruction set that Embree may use; stilb_gi_brute ignores it. */
	stilb_gi_isa isa;
	/* Bytes that Embree may take; 0: what the machine has free (MemAvailable). */
	uint64_t memory;
	/* Models will move: each part whose transform is nearly a similarity and which does not shine is traced as an
	 * instance of its mesh, with a tree of its own, and the others have trees of their own. Updates are cheap then,
	 * rays cost more, and where a part is an instance only because of this, numbers are rounded otherwise: pictures
	 * differ in their last bits from those of the same scene without movable. */
	bool movable;
	/* Asked again and again in create and update, on any thread that builds, several at once; true: the caller gives it
	 * up, which is STILB_ERROR_GIVEN_UP soon: a million triangles were given up after 20 ms, 135 at most beside nine
	 * busy programs.
	 * NULL: never. */
	bool (*give_up)(void *user);
	void *user;
} stilb_gi_scene_desc;

/* Embree, the widest instruction set, all free memory. [any-thread] */
stilb_gi_scene_desc stilb_gi_scene_desc_default(stilb_job_pool *pool);

/* Counts and sizes of a created scene, for reports. */
typedef struct stilb_gi_scene_info {
	/* Triangles that rays can hit; a mesh counts once for each part that shows it. */
	uint64_t triangles;
	/* Triangles of area 0 that were left out, such as those at the poles of a sphere; nothing is missing in the
	 * picture. */
	uint64_t flat;
	/* Triangles that were left out because a corner is NaN, infinite, beyond 1e10 m or not in the mesh. */
	uint64_t invalid;
	/* Memory: the acceleration structure, vertices, triangles and parts. */
	uint64_t bytes;
	/* Emitting triangles, of maps of emission those that glow, and lights of the list that shine and have no face. */
	uint32_t lights;
	/* Seconds in Embree's build, that of the last update; 0: it has built nothing. */
	double build_s;
	/* Embree's instruction set, "avx512", ...; "none" for brute. */
	const char *isa;
	/* Box around all triangles in world space, metres; low > high: there are none. */
	float low[3], high[3];
} stilb_gi_scene_info;

/* Copies meshes, materials and lights, and decodes textures of compressed blocks. scene may be destroyed afterwards,
 * except for the pixels of its textures and of its panorama, which must outlive the result. A mesh of many parts is
 * kept once, as instances, where that saves more than 65,536 triangles.
 * Errors: STILB_ERROR_ARGUMENT: an instruction set this CPU lacks, more than 2^30 triangles, a panorama that has no
 * linear floats; STILB_ERROR_MEMORY; STILB_ERROR_DEVICE: Embree fails; STILB_ERROR_GIVEN_UP. Then *out is NULL.
 * [main-thread] */
stilb_result stilb_gi_scene_create(const stilb_scene *scene, const stilb_gi_scene_desc *desc, stilb_gi_scene **out);

/* Brings it up to date with the scene that it was created from, which was edited (scene_edit.h; where nodes have moved,
 * stilb_scene_update_nodes comes first): pictures are those of a scene that is created now, bit for bit. No render of
 * it may exist, but for those between two poses (stilb_gi_render_until). desc: as for create, of any pool; intersector,
 * isa and memory stay as they were.
 * What it costs: after other materials, lights or surroundings nothing is built. In a movable scene, after models were
 * moved, hidden or shown, only the top of the tree is, and the triangles of those parts that are no instances; 10,000
 * parts take some milliseconds. After poses (scene_play.h) the trees of the meshes that have other ones are built, too,
 * from all their triangles: 0.2 us each, on one thread for a mesh of less than 4,096. In a scene that is not movable
 * one tree has all triangles and is built whole, but nothing else is unless a model has moved as well. All else, as
 * models and meshes that come, go or change, and surfaces that rays begin or cease to go through (alpha, one_sided), is
 * built anew.
 * After an error only update, which then builds all of it, and destroy may follow. Errors: as of create.
 * [main-thread], the one that created it. */
stilb_result stilb_gi_scene_update(stilb_gi_scene *gi_scene, const stilb_scene *scene, const stilb_gi_scene_desc *desc);

/* After all renders of it. Accepts NULL. [main-thread], the one that created it. */
void stilb_gi_scene_destroy(stilb_gi_scene *scene);

/* Valid as long as the scene. [any-thread] */
const stilb_gi_scene_info *stilb_gi_scene_info_of(const stilb_gi_scene *scene);

/* The version of Embree that the program was built with, "3.13.5". [any-thread] */
const char *stilb_gi_library_version(void);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#endif
