/* record_cases: the cases (workloads) of the suite `record`, which measures recording and replay of draws. Included by
 * stilb-bench and by the programs that it starts, one for each group of subjects (implementations to compare). */
#ifndef RECORD_CASES_H
#define RECORD_CASES_H

#include <stdint.h>

/* The kinds of measurement. A draw is a mesh, a material and a transform; a model has two draws. */
typedef enum record_kind {
	RECORD_DRAWS,   /* recording on one thread */
	RECORD_PHASE,   /* recording on two threads and on one; workers are awake */
	RECORD_PARKED,  /* the same, but workers are asleep when recording begins */
	RECORD_VIEWS,   /* six views of the scene recorded together, on one thread and on two that are awake */
	RECORD_REPLAY,  /* converting recorded lists to device commands, on the null device */
	RECORD_SORT,    /* sorting recorded draws by their keys */
	RECORD_FRAME,   /* cull + record + replay, on the null device */
	RECORD_PICTURE, /* whole frames on lavapipe; the picture's checksum is compared */
} record_kind;

/* The way in which a draw refers to its material. */
typedef enum record_materials {
	RECORD_INDEX,    /* an index in the draw's row, the data of the draw that the shader reads */
	RECORD_BIND,     /* a material bound for each draw */
	RECORD_PIPELINE, /* two pipelines that alternate */
} record_materials;

/* A texture of a surface for each draw's material. */
typedef enum record_textures {
	RECORD_NO_TEXTURES,
	RECORD_ONE_SIZE,  /* all of one size and format */
	RECORD_SIZES,     /* of 12 sizes and 3 formats, with 2 samplers, by turns */
	RECORD_ALL_SIZES, /* all of different sizes */
} record_textures;

typedef struct record_case {
	const char *name;
	record_kind kind;
	uint32_t models;
	uint32_t threads; /* the caller included */
	record_materials materials;
	record_textures textures; /* with some, only the number of draws is checked */
} record_case;

#define RECORD_MODELS 10000u
#define RECORD_MANY_MODELS 500000u
#define RECORD_WIDTH 640u
#define RECORD_HEIGHT 360u

/* X(name, title, KIND, more fields of record_case...) */
#define RECORD_CASES(X)                                                                                                \
	X("draws", "20,000 draws recorded on one thread", DRAWS, .models = RECORD_MODELS, .threads = 1)                    \
	X("draws-1000000", "1,000,000 draws recorded on one thread", DRAWS, .models = RECORD_MANY_MODELS, .threads = 1)    \
	X("phase", "20,000 draws recorded on two threads that are awake", PHASE, .models = RECORD_MODELS, .threads = 2)    \
	X("parked", "20,000 draws recorded on two threads, one of them asleep at the start", PARKED,                       \
	  .models = RECORD_MODELS, .threads = 2)                                                                           \
	X("views", "six views of 20,000 draws recorded together, on one thread and on two", VIEWS,                         \
	  .models = RECORD_MODELS, .threads = 2)                                                                           \
	X("views-small", "six views of 1,000 draws, the same", VIEWS, .models = RECORD_MODELS / 20, .threads = 2)          \
	X("replay-1", "ordering and replay of 20,000 draws, null device, 1 thread", REPLAY, .models = RECORD_MODELS,       \
	  .threads = 1)                                                                                                    \
	X("replay-2", "ordering and replay of 20,000 draws, null device, 2 threads", REPLAY, .models = RECORD_MODELS,      \
	  .threads = 2)                                                                                                    \
	X("textures", "20,000 draws with a texture each, all of one size", REPLAY, .models = RECORD_MODELS, .threads = 1,  \
	  .textures = RECORD_ONE_SIZE)                                                                                     \
	X("textures-sizes", "the same, textures of 12 sizes and 3 formats, 2 samplers", REPLAY, .models = RECORD_MODELS,   \
	  .threads = 1, .textures = RECORD_SIZES)                                                                          \
	X("textures-all", "the same, all textures of different sizes", REPLAY, .models = RECORD_MODELS, .threads = 1,      \
	  .textures = RECORD_ALL_SIZES)                                                                                    \
	X("sort", "20,000 draws sorted by 24-bit keys", SORT, .models = RECORD_MODELS, .threads = 1)                       \
	X("frame-1", "cull + record + replay of 20,000 draws, null device, 1 thread", FRAME, .models = RECORD_MODELS,      \
	  .threads = 1)                                                                                                    \
	X("frame-2", "cull + record + replay of 20,000 draws, null device, 2 threads", FRAME, .models = RECORD_MODELS,     \
	  .threads = 2)                                                                                                    \
	X("picture", "frames of 20,000 draws on lavapipe, 640x360", PICTURE, .models = RECORD_MODELS, .threads = 2)        \
	X("picture-bind", "frames of 20,000 draws on lavapipe, a material bound for each draw", PICTURE,                   \
	  .models = RECORD_MODELS, .threads = 2, .materials = RECORD_BIND)                                                 \
	X("picture-pipeline", "frames of 20,000 draws on lavapipe, two pipelines alternating", PICTURE,                    \
	  .models = RECORD_MODELS, .threads = 2, .materials = RECORD_PIPELINE)

#endif
