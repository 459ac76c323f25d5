/* The cases of the suite `upload`, and what its programs have in common: sizes, and medians.
 * X(NAME, TITLE, KIND, BYTES): bytes of one upload; images are square, of 4 bytes a texel. */
#ifndef UPLOAD_CASES_H
#define UPLOAD_CASES_H

#include <math.h>
#include <stdint.h>
#include <stdlib.h>

#define UPLOAD_CASES(X)                                                                                                \
	X("caller-4k", "the caller's part: uploads of 4 KiB are begun, written and ended", CALLER, 4096)                   \
	X("caller-64k", "the same of 64 KiB", CALLER, 65536)                                                               \
	X("caller-1m", "the same of 1 MiB", CALLER, 1 << 20)                                                               \
	X("image-64", "from the ring to images of 64 x 64 texels, 16 KiB each", IMAGE, 64 * 64 * 4)                        \
	X("image-256", "to images of 256 x 256 texels, 256 KiB each", IMAGE, 256 * 256 * 4)                                \
	X("image-1024", "to images of 1,024 x 1,024 texels, 4 MiB each", IMAGE, 1024 * 1024 * 4)                           \
	X("stream", "a second thread uploads 1 GB while frames run", STREAM, 1 << 20)

/* What a subject can do (bench_subject.abilities). */
#define UPLOAD_CALLER 1u
#define UPLOAD_IMAGE 2u
#define UPLOAD_STREAM 4u

/* Uploads that are made at once: as many as a frame takes, or 16 MiB. */
#define UPLOAD_BATCH_BYTES (16u << 20)
#define UPLOAD_BATCH_MOST 1024u
#define UPLOAD_RING_BYTES (4ull * UPLOAD_BATCH_BYTES)
/* What is written comes from here: more than the caches that belong to one processor. */
#define UPLOAD_SOURCE_BYTES (64u << 20)

static inline uint32_t upload_batch(uint32_t bytes)
{
	uint32_t count = UPLOAD_BATCH_BYTES / bytes;
	return count < UPLOAD_BATCH_MOST ? count : UPLOAD_BATCH_MOST;
}

#define UPLOAD_SAMPLES 4096u

/* Measured values; those beyond the capacity are dropped. */
typedef struct upload_samples {
	uint32_t count;
	double at[UPLOAD_SAMPLES];
} upload_samples;

static inline void upload_sample(upload_samples *set, double value)
{
	if (set->count < UPLOAD_SAMPLES)
		set->at[set->count++] = value;
}

static inline int upload_order(const void *a, const void *b)
{
	double x = *(const double *)a, y = *(const double *)b;
	return (x > y) - (x < y);
}

/* The value below which a share of them lies, 0..1; NaN without any. */
static inline double upload_quantile(upload_samples *set, double share)
{
	if (set->count == 0)
		return (double)NAN;
	qsort(set->at, set->count, sizeof *set->at, upload_order);
	return set->at[(uint32_t)(share * (set->count - 1) + 0.5)];
}

#endif
