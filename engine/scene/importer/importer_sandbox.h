/* importer_sandbox: the import process gives up its rights before it reads anything. [main-thread] */
#ifndef STILB_SCENE_IMPORTER_SANDBOX_H
#define STILB_SCENE_IMPORTER_SANDBOX_H

#include <stdbool.h>
#include <stdint.h>

/* Under sanitizers there is no limit of memory, of which they map terabytes, and standard error stays open for their
 * reports. */
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define IMPORTER_SANITIZED 1
#elif defined(__has_feature)
#define IMPORTER_SANITIZED (__has_feature(address_sanitizer) || __has_feature(thread_sanitizer))
#else
#define IMPORTER_SANITIZED 0
#endif

/* Enters the sandbox, before the first thread is started. bytes, > 0: the limit of memory. Returns the flags of
 * scene_protection that this kernel supports; a missing one is not an error. Afterwards the process can open no files
 * but libraries, start no process and no program, open no sockets, and signal nobody but itself. */
uint32_t importer_sandbox_enter(uint64_t bytes);

/* Limits CPU time from now on to `seconds` for each CPU of the machine. */
void importer_sandbox_allow_time(uint64_t seconds);

#endif
