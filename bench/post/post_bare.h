/* Bare programs with the reads and writes of an effect's rows, in its place. */
#ifndef BENCH_POST_BARE_H
#define BENCH_POST_BARE_H

#include "engine.h"

typedef struct post_bare post_bare;

/* Learns the rows that the engine's last frame has and `without`, [count] names, has not, and adds rows to all frames
 * from now on that read and write the same, while it is switched on. Fails the run for what cannot be. */
post_bare *post_bare_learn(stilb_engine *engine, const char (*without)[64], uint32_t count);
void post_bare_switch(post_bare *bare, bool on);
/* Before the engine. Accepts NULL. */
void post_bare_destroy(post_bare *bare, stilb_engine *engine);

#endif
