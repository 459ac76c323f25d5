/* importer_sandbox: what the import process gives up before it reads anything. */
#ifndef STILB_SCENE_IMPORTER_SANDBOX_H
#define STILB_SCENE_IMPORTER_SANDBOX_H

#include <stdbool.h>
#include <stdint.h>

/* Sanitizers map more memory than any limit, and write their reports to standard error. */
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define IMPORTER_SANITIZED 1
#elif defined(__has_feature)
#define IMPORTER_SANITIZED (__has_feature(address_sanitizer) || __has_feature(thread_sanitizer))
#else
#define IMPORTER_SANITIZED 0
#endif

/* Before the first thread. bytes: of memory. Returns the flags of scene_protection that this kernel has: what could not
 * be switched on is no failure. Afterwards the process opens no file but libraries, starts no process and no program,
 * has no sockets but those it has, and signals nobody but itself. */
uint32_t importer_sandbox_enter(uint64_t bytes);

/* Gives the process seconds of CPU time for every CPU from now on. */
void importer_sandbox_allow_time(uint64_t seconds);

#endif
