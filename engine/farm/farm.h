/*
 * farm: the unit of work that many machines share, whatever they compute.
 *
 * Work that can be shared consists of numbered units, each of which gives a result of the same size. What a unit means
 * only the module that made the work knows: for rays it is a small square of the picture. The bits of a result depend
 * on the unit's number and on the work's identity, and on nothing else: not on the machine, not on other units, not on
 * the order. So any machine may compute any unit, one that two machines have computed is the same twice, and a whole
 * that is put together from results is the same as one that was computed in one place.
 *
 *   identity   lines "name value\n": the program's version and binary, the instruction set, hashes of what is read,
 *              the settings and the seed. Two works with the same identity have the same results.
 *   range      consecutive units. A share is one of N ranges that cover all units. Units are numbered so that every
 *              range costs about as much as any other of its length.
 *   part       a file with the results of a range, and the identity.
 *   merging    the work's `set` puts a result where it belongs.
 *
 * Life cycle.  A part: compute a share's units, stilb_farm_part_save. The whole: stilb_farm_part_open each file ->
 *              stilb_farm_parts_check -> stilb_farm_part_merge each into one work -> stilb_farm_part_close.
 *              On machines that talk to each other: farm_crew.h.
 * Threads.     [any-thread]; a part and a work have one user at a time unless `get` and `set` say otherwise.
 * Errors.      A stilb_result, with a line for the user in stilb_error_message.
 */
#ifndef STILB_FARM_H
#define STILB_FARM_H

#include "base/base_file.h"

/* ---- work -------------------------------------------------------------------------------------------------------- */

typedef struct stilb_farm_range {
	uint32_t first, count;
} stilb_farm_range;

/* Share number `index` of `of` that cover so many units; 1 <= index <= of. Their sizes differ by one unit at most; with
 * more shares than units some are empty. */
stilb_farm_range stilb_farm_share(uint32_t units, uint32_t index, uint32_t of);

typedef enum stilb_farm_state {
	STILB_FARM_NEW,
	STILB_FARM_BEGUN, /* a part of its result is there, with which the computation goes on */
	STILB_FARM_WHOLE, /* its result is there */
} stilb_farm_state;

typedef struct stilb_farm_work {
	const char *identity;
	uint32_t unit_count;
	uint32_t unit_size; /* bytes of a result, a multiple of 8 */
	/* All of these may be called while others compute other units. */
	stilb_farm_state (*state)(void *user, uint32_t unit);
	/* Copies the result of a unit, or what there is of it; result has unit_size bytes, aligned to 8. */
	void (*get)(void *user, uint32_t unit, void *result);
	/* Takes over the result of a unit that was computed elsewhere, or, if not `whole`, what there is of it. False: no
	 * such result has these numbers. */
	bool (*set)(void *user, uint32_t unit, const void *result, bool whole);
	void *user;
} stilb_farm_work;

/* Where threads that compute units get the numbers of those from. All functions are called by any number of threads. */
typedef enum stilb_farm_taken {
	STILB_FARM_TAKEN,   /* *unit is to be computed now */
	STILB_FARM_LATER,   /* there is none now; ask again soon */
	STILB_FARM_NO_MORE, /* there will be none */
} stilb_farm_taken;
typedef struct stilb_farm_feed {
	stilb_farm_taken (*take)(void *user, uint32_t *unit);
	/* The unit that was taken is computed. */
	void (*done)(void *user, uint32_t unit);
	/* It is not, because the computation was stopped; it may be taken again. */
	void (*back)(void *user, uint32_t unit);
	void *user;
} stilb_farm_feed;

/* ---- identity ---------------------------------------------------------------------------------------------------- */

/* Of the running program's file, so that results of another build, which may differ in their last bits, are told apart.
 * Read once. 0 if the file cannot be read. */
uint64_t stilb_farm_binary(void);

/* The first line in which the identities a and b differ, by its name and the two values, which point into a and b; the
 * value of a line that is not there has the length 0. False: a and b are equal. */
typedef struct stilb_farm_difference {
	const char *name, *a, *b;
	int name_length, a_length, b_length;
} stilb_farm_difference;
bool stilb_farm_differ(const char *a, const char *b, stilb_farm_difference *difference);

/* The value of the line with that name, up to its end, which *length excludes; NULL: there is none. */
const char *stilb_farm_value(const char *identity, const char *name, int *length);

/* ---- parts ------------------------------------------------------------------------------------------------------- */

#define STILB_FARM_NOTES 8
#define STILB_FARM_MAX_IDENTITY 16384u /* bytes with the final zero */

/* What a part's file begins with. Of the machine's byte order and floats. */
typedef struct stilb_farm_head {
	uint32_t index, of; /* the share: number `index` of `of` */
	uint32_t unit_count, unit_size;
	stilb_farm_range range;
	uint64_t notes[STILB_FARM_NOTES]; /* for who made the part: times, counts; merging ignores them */
} stilb_farm_head;

typedef struct stilb_farm_part {
	char *path;
	FILE *stream;        /* NULL but while it is read */
	uint64_t hash, left; /* of what has been read; bytes that have not */
	int64_t offset;      /* of the results in the file */
	stilb_farm_head head;
	char identity[STILB_FARM_MAX_IDENTITY];
} stilb_farm_part;

/* Writes the results of share `index` of `of` of the work, whole or not at all. STILB_ERROR_FILE,
 * STILB_ERROR_MEMORY. */
stilb_result stilb_farm_part_save(const stilb_farm_work *work, uint32_t index, uint32_t of,
                                  const uint64_t notes[STILB_FARM_NOTES], const char *path);

/* Opens a part and reads its head and identity. STILB_ERROR_FILE: it cannot be read, is no part, is cut short, or its
 * head is damaged; STILB_ERROR_MEMORY. Then *out is NULL. */
stilb_result stilb_farm_part_open(const char *path, stilb_farm_part **out);

/* Accepts NULL. */
void stilb_farm_part_close(stilb_farm_part *part);

/* STILB_OK if the parts, in any order, are of one work and cover all its units, each once. Else STILB_ERROR_ARGUMENT,
 * and the message names what does not belong, is there twice, or is missing. count >= 1. */
stilb_result stilb_farm_parts_check(stilb_farm_part *const *parts, uint32_t count);

/* Reads the part's results into a work of the same identity. STILB_ERROR_FILE: the file is damaged, of which the work
 * then has taken over some; STILB_ERROR_MEMORY. Once for each part. */
stilb_result stilb_farm_part_merge(stilb_farm_part *part, const stilb_farm_work *work);

#endif
