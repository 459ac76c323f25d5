/*
 * gi_embree_team: threads that build trees of Embree together, while one of them alone has to do with how a build ends.
 *
 * With rtcJoinCommitScene, Embree's own way, each thread that joined gets the exception that ends a build early (given
 * up, no memory), and two of them free it: Embree 3.13 crashes then, now and then. Here one thread commits the scene in
 * an arena of oneTBB, whose tasks are what Embree builds with. The others only wait in the arena, each for an event of
 * its own, and a thread that waits in an arena runs the arena's tasks meanwhile. Where Embree was built without oneTBB
 * they have nothing to do, and the tree is built all the same.
 */
#ifndef STILB_GI_EMBREE_TEAM_H
#define STILB_GI_EMBREE_TEAM_H

#include <embree3/rtcore.h>
#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct gi_embree_team gi_embree_team;

/* A team of so many threads, 1 or more: one that commits, and helpers, counted from 0. It starts none. NULL: no memory.
 * [any-thread] */
gi_embree_team *gi_embree_team_create(uint32_t threads);

/* Frees the team; no build is running. NULL is ignored. [any-thread] */
void gi_embree_team_destroy(gi_embree_team *team);

/* From now until the next commit is done, helpers help. false: no memory. [any-thread] */
bool gi_embree_team_call(gi_embree_team *team);

/* Helps; returns when the commit is done, at once if it already is. Each helper once for a call. [any-thread] */
void gi_embree_team_help(gi_embree_team *team, uint32_t index);

/* Builds the scene's tree, alone or with the helpers that were called. Embree tells errors by the device's error
 * function. false: no memory, and Embree was not asked. [any-thread] */
bool gi_embree_team_commit(gi_embree_team *team, RTCScene scene);

#ifdef __cplusplus
}
#endif

#endif
