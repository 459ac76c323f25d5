/*
 * gpu: what all devices have, and what each must do. gpu.c and the files beside it check what a user gives, know what
 * there is by number, and free what was destroyed once no frame can use it; devices make and run.
 */
#ifndef STILB_GPU_INTERNAL_H
#define STILB_GPU_INTERNAL_H

#include "base/base_contract.h"
#include "gpu/gpu.h"
#include "gpu/gpu_memory_internal.h"
#include "gpu/gpu_plan_internal.h"
#include "profiler/prof.h"

#include <stdatomic.h>
#include <string.h>

/* ---- tables ------------------------------------------------------------------------------------------------------ */

#define GPU_TABLE_CHUNK 1024u
#define GPU_TABLE_CHUNKS 1024u
#define GPU_INDEX_BITS 20u /* of an id: the index + 1; above them the element's generation */

/* What each element of a table begins with. */
typedef struct gpu_entry {
	uint32_t generation; /* of the id that is valid, or was last */
	uint32_t next;       /* of elements that are unused, index + 1 */
	bool used, hidden;   /* hidden: used, and no id names it any more */
} gpu_entry;

/* Elements with numbers, which never move: a valid id can be looked up without a lock. */
typedef struct gpu_table {
	size_t element;
	uint32_t count, unused; /* elements that were ever used; the first unused one, index + 1 */
	uint32_t used;
	void *chunks[GPU_TABLE_CHUNKS];
} gpu_table;

/* A new element, all zero but for its entry; its id fits into id_bits bits. NULL: no memory, or there are 2^20 - 1
 * already. The caller holds the lock. */
void *gpu_table_add(gpu_table *table, uint32_t id_bits, uint64_t *id);
/* The element of an id; NULL: there is none, or no longer. */
void *gpu_table_get(const gpu_table *table, uint64_t id);
/* Makes the element's id invalid, so that nobody finds it any more. */
void gpu_table_hide(gpu_table *table, void *element);
/* Makes the element unused. The caller holds the lock. */
void gpu_table_drop(gpu_table *table, void *element, uint32_t index);
/* The used element, also if hidden, with this index; NULL. */
void *gpu_table_at(const gpu_table *table, uint32_t index);
void gpu_table_finish(gpu_table *table);

/* ---- what there is ----------------------------------------------------------------------------------------------- */

#define GPU_NAME 48u /* longer names are cut in messages */

typedef struct gpu_buffer {
	gpu_entry entry;
	char name[GPU_NAME];
	uint64_t bytes;
	stilb_gpu_memory memory;
	uint32_t uses;
	void *mapped;
	uint64_t address;
	void *own; /* the device's */
} gpu_buffer;

typedef struct gpu_image {
	gpu_entry entry;
	char name[GPU_NAME];
	stilb_gpu_extent extent;
	stilb_gpu_channels channels;
	uint8_t *layouts; /* [layers][mips] stilb_gpu_layout, as the last frame left them */
	void *own;
} gpu_image;

typedef struct gpu_set {
	gpu_entry entry;
	uint32_t count;
	stilb_gpu_set_item items[STILB_GPU_MAX_SET_ITEMS];
	void *own;
} gpu_set;

/* The source of shaders (stilb_gpu_shader.source), known from the first program on that has one. Guarded by the
 * lock. */
typedef struct gpu_source {
	char *text;
	stilb_gpu_shader code; /* what took the place of the programs' own; words NULL: nothing did */
	uint32_t version;      /* of it: how often it was replaced */
} gpu_source;

enum { GPU_STAGE_VERTEX, GPU_STAGE_FRAGMENT, GPU_STAGE_COMPUTE, GPU_STAGES };

typedef struct gpu_program {
	gpu_entry entry;
	char name[GPU_NAME];
	stilb_gpu_program_desc desc;       /* its shaders' words say only that there is one: `code` has them */
	stilb_gpu_shader code[GPU_STAGES]; /* words are its own */
	gpu_source *sources[GPU_STAGES];   /* NULL: it is never replaced */
	uint32_t versions[GPU_STAGES];     /* of the sources, that it was made of */
	/* Guarded by the lock: threads that compile its pipelines outside of frames, so that it is neither swapped nor
	 * freed; and whether it is made and of a source, so that stilb_gpu_shaders_replace finds it. */
	uint32_t pins;
	bool named;
	void *own;
} gpu_program;

/* A program that will take another's place: gpu_program.c. */
typedef struct gpu_successor gpu_successor;

typedef enum gpu_kind { GPU_BUFFER, GPU_IMAGE, GPU_SET, GPU_PROGRAM, GPU_KINDS } gpu_kind;

/* Something that was destroyed, until no frame can use it. */
typedef struct gpu_retired {
	gpu_kind kind;
	uint32_t index;
	uint64_t frame; /* the one that was begun last */
} gpu_retired;

/* ---- uploads ----------------------------------------------------------------------------------------------------- */

#define GPU_UPLOAD_ALIGN 16u
#define GPU_UPLOAD_BYTES ((uint64_t)32 << 20)
#define GPU_UPLOADS 4096u /* that are there at once: those of the frames in flight, and those that follow */

/* One upload: a range of the ring. Ranges lie in the order in which they were begun. */
typedef struct gpu_upload_item {
	stilb_gpu_upload upload;
	uint64_t offset, end; /* bytes of the ring that it takes, counted on and on: modulo the ring's size */
	uint64_t batch;       /* of gpu_ring_ready, that took it; 0: it waits */
	uint64_t frame;       /* in which it was copied; 0: not yet */
	_Atomic uint64_t
		writing; /* the place of its bytes + 1 until its end, then 0. Release by stilb_gpu_upload_end, acquire
	                             by gpu_ring_ready */
} gpu_upload_item;

/* An upload to copy, and where its bytes lie in the ring's buffer. */
typedef struct gpu_upload_ready {
	stilb_gpu_upload upload;
	uint64_t place;
} gpu_upload_ready;

typedef struct gpu_ring {
	gpu_buffer buffer;
	stilb_lock lock; /* guards all below but for gpu_upload_item.writing */
	bool lock_made;
	gpu_upload_ready *ready; /* [GPU_UPLOADS] of the main thread: those that were taken last */
	gpu_upload_item *items;  /* [GPU_UPLOADS], by number modulo that */
	uint32_t first;          /* the oldest that is there; numbers are counted on and on */
	_Atomic uint32_t
		begun; /* the number of the next. Relaxed: the lock orders it, and stilb_gpu_upload_end needs a hint */
	uint64_t frame_bytes; /* that one frame copies */
	uint64_t head;        /* where the next one begins, counted on and on */
	uint64_t batch;       /* the last one that was taken */
} gpu_ring;

/* ---- read-back --------------------------------------------------------------------------------------------------- */

typedef struct gpu_read {
	uint64_t ticket;   /* 0: unused */
	gpu_buffer buffer; /* where the copy goes */
	uint64_t bytes;
	uint64_t frame; /* whose content it is */
	uint64_t done;  /* the device's: when the copy is there */
	bool given_up;  /* waits for the device, then it is unused */
} gpu_read;

/* ---- the device -------------------------------------------------------------------------------------------------- */

/* What a format can be on a device: bits of stilb_gpu_extent.uses, and these above them. */
#define GPU_FORMAT_LINEAR (1u << (STILB_GPU_USE_KINDS + 1))
#define GPU_FORMAT_BLIT_FROM (1u << (STILB_GPU_USE_KINDS + 2))
#define GPU_FORMAT_BLIT_TO (1u << (STILB_GPU_USE_KINDS + 3))

/* How a device does what gpu.h says. What it is given has been checked. Errors have their message. */
typedef struct gpu_functions {
	void (*destroy)(stilb_gpu *gpu);
	stilb_result (*buffer_make)(stilb_gpu *gpu, gpu_buffer *buffer);
	void (*buffer_free)(stilb_gpu *gpu, gpu_buffer *buffer);
	stilb_result (*image_make)(stilb_gpu *gpu, gpu_image *image);
	void (*image_free)(stilb_gpu *gpu, gpu_image *image);
	stilb_result (*sampler_make)(stilb_gpu *gpu, uint32_t index, const stilb_gpu_sampler_desc *desc);
	stilb_result (*set_make)(stilb_gpu *gpu, gpu_set *set);
	void (*set_free)(stilb_gpu *gpu, gpu_set *set);
	stilb_result (*program_make)(stilb_gpu *gpu, gpu_program *program);
	void (*program_free)(stilb_gpu *gpu, gpu_program *program);
	stilb_result (*program_prepare)(stilb_gpu *gpu, gpu_program *program, const stilb_gpu_format *colors,
	                                uint32_t color_count, stilb_gpu_format depth, uint32_t samples);
	/* `to` is to have each pipeline that `from` has; program_compile makes them. The caller holds the lock. */
	stilb_result (*program_follow)(stilb_gpu *gpu, const gpu_program *from, gpu_program *to);
	stilb_result (*program_compile)(stilb_gpu *gpu, gpu_program *program);
	/* Waits for the frame before the last. */
	stilb_result (*begin)(stilb_gpu *gpu);
	/* uploads: those to copy first, in order. */
	stilb_result (*run)(stilb_gpu *gpu, const stilb_gpu_plan *plan, const stilb_gpu_draws *lists, uint32_t list_count,
	                    const stilb_gpu_threads *threads, const gpu_upload_ready *uploads, uint32_t upload_count);
	stilb_result (*present)(stilb_gpu *gpu, const stilb_gpu_plan *plan, uint16_t image);
	/* Begins the copy to read->buffer. */
	stilb_result (*read)(stilb_gpu *gpu, const stilb_gpu_plan *plan, uint16_t resource, uint8_t mip, uint16_t layer,
	                     gpu_read *read);
	/* True once the copy is there. wait: waits for it. */
	stilb_result (*read_done)(stilb_gpu *gpu, const gpu_read *read, bool wait, bool *done);
	/* Copies these now, and waits for all that the device was given. */
	stilb_result (*flush)(stilb_gpu *gpu, const gpu_upload_ready *uploads, uint32_t upload_count);
	stilb_result (*set_surface)(stilb_gpu *gpu, const stilb_gpu_surface *surface);
	stilb_result (*wait)(stilb_gpu *gpu);
	stilb_result (*image_needs)(stilb_gpu *gpu, const stilb_gpu_extent *extent, stilb_gpu_needs *needs);
	stilb_result (*buffer_needs)(stilb_gpu *gpu, uint64_t bytes, stilb_gpu_needs *needs);
	stilb_gpu_memory_report (*measure)(stilb_gpu *gpu);
} gpu_functions;

#define GPU_MAX_SAMPLERS 256u

struct stilb_gpu {
	const gpu_functions *functions;
	char name[256];
	bool software, in_window;
	stilb_gpu_presentation presentation; /* the one in use */
	uint32_t validation_messages;
	stilb_gpu_faults faults;
	_Atomic uint32_t allocations; /* made so far. Relaxed: a counter that orders nothing; any thread allocates */
	uint32_t frames;              /* submitted so far */
	double gpu_ms;                /* of the last frame whose time is known */

	stilb_owner owner; /* the main thread */
	stilb_gpu_limits limits;
	uint32_t formats[STILB_GPU_FORMAT_COUNT]; /* what each can be: uses, GPU_FORMAT_... */
	bool begun;                               /* a frame was begun and has not run */
	uint64_t frame;                           /* the number of the frame that was begun last */
	bool keep_back; /* for measurements: frames are recorded and not given to the device; the plan was dropped */
	stilb_gpu_stats stats;
	const stilb_prof_site **sites; /* [site_capacity] by step: names its pass in the profiler */
	uint32_t site_capacity;

	stilb_lock lock; /* guards all below but for elements of tables, which who has their id reads */
	bool lock_made;
	gpu_table tables[GPU_KINDS];
	gpu_retired *retired; /* [retired_capacity] */
	uint32_t retired_count, retired_capacity;
	gpu_source **sources;      /* [source_count] each stays where it is */
	gpu_successor *successors; /* [successor_count] wait for the next frame */
	uint32_t source_count, successor_count;
	stilb_lock replacing; /* held by stilb_gpu_shaders_replace, and taken before `lock` */
	stilb_gpu_sampler_desc samplers[GPU_MAX_SAMPLERS];
	_Atomic uint32_t sampler_count; /* release with the sampler made, acquire by who looks one up without the lock */
	gpu_ring ring;
	gpu_read *reads; /* [read_capacity], of the main thread alone */
	uint32_t read_capacity;
	uint64_t last_ticket;
};

/* ---- entries/gpu_entry.c, gpu_program.c -------------------------------------------------------------------------- */

/* Copies a name, cut to its place; NULL: "". */
void gpu_name_copy(char to[GPU_NAME], const char *name);
/* A new entry. NULL: an error of memory. */
void *gpu_entry_add(stilb_gpu *gpu, gpu_kind kind, uint64_t *id);
/* Ends an entry that could not be made. */
void gpu_entry_drop(stilb_gpu *gpu, gpu_kind kind, void *entry, uint64_t id);
/* Destroys what an id names, or 0, once no frame can use it. Without memory for the list it stays until the device
 * ends. */
void gpu_entry_retire(stilb_gpu *gpu, gpu_kind kind, uint64_t id);
/* The same of an entry that is hidden already. The caller holds the lock. */
void gpu_entry_retire_hidden(stilb_gpu *gpu, gpu_kind kind, uint32_t index);
/* Frees what an entry has on the device. */
void gpu_entry_free(stilb_gpu *gpu, gpu_kind kind, void *entry);
/* Frees what was destroyed before the frame `done` began. */
void gpu_retired_free(stilb_gpu *gpu, uint64_t done);
static inline uint32_t gpu_entry_index(uint64_t id)
{
	return (uint32_t)(id & ((1u << GPU_INDEX_BITS) - 1)) - 1;
}
/* Frees the code of its shaders. */
void gpu_program_forget(gpu_program *program);
/* Puts programs with other shaders in their place, for the frame that begins. The caller holds the lock. */
void gpu_programs_swap(stilb_gpu *gpu);
void gpu_sources_finish(stilb_gpu *gpu);

/* The profiler's site of step number `step`, for its pass's name; looking a name up takes a lock. */
const stilb_prof_site *gpu_step_site(stilb_gpu *gpu, uint32_t step, const char *name);

/* Which of a list's bindings a run has to bind after another; NULL: after none. */
typedef struct gpu_binds {
	bool program, set, constant, indices, vertices, scissor;
} gpu_binds;

static inline const stilb_gpu_binding *gpu_binding_of(const stilb_gpu_draws *list, const stilb_gpu_run *run)
{
	return &list->bindings[run->binding];
}

static inline gpu_binds gpu_binds_between(const stilb_gpu_draws *list, const stilb_gpu_run *from,
                                          const stilb_gpu_run *to)
{
	const stilb_gpu_binding *b = gpu_binding_of(list, to), *a = from ? gpu_binding_of(list, from) : NULL;
	bool program = !a || a->program != b->program;
	return (gpu_binds){
		.program = program,
		.set = to->set != 0 && (program || to->set != from->set),
		.constant = list->has_constants && (program || to->constant != from->constant),
		.indices = !a || a->indices != b->indices || a->index_bytes != b->index_bytes,
		.vertices = b->vertices != 0 && (!a || a->vertices != b->vertices),
		.scissor = a ? memcmp(a->scissor, b->scissor, sizeof a->scissor) != 0 : b->scissor[2] > 0,
	};
}

/* Of stilb_gpu_stats.binds: a program with what it needs at once, a set or constant of a run, a buffer of indices. */
static inline uint32_t gpu_binds_count(gpu_binds binds)
{
	return (uint32_t)binds.program + (uint32_t)(binds.set || binds.constant) + (uint32_t)binds.indices;
}

/* Draws of a list. */
static inline uint64_t gpu_draws_count(const stilb_gpu_draws *list)
{
	uint64_t draws = 0;
	for (uint32_t r = 0; r < list->run_count; r++)
		draws += list->runs[r].count;
	return draws;
}

/* How many parts a list is cut into for threads, and the first draw of a part, or where the last one ends. */
#define GPU_MOST_PARTS 256u
static inline uint32_t gpu_draws_parts(const stilb_gpu_threads *threads)
{
	uint32_t parts = threads && threads->run && threads->count > 0 ? threads->count : 1;
	return parts < GPU_MOST_PARTS ? parts : GPU_MOST_PARTS;
}

static inline uint64_t gpu_draws_part(uint64_t draws, uint32_t parts, uint32_t part)
{
	return draws / parts * part + draws % parts * part / parts;
}

/* The parts of stilb_gpu_create that all devices share; destroy calls finish last but for its own memory. */
stilb_result gpu_start(stilb_gpu *gpu, const stilb_gpu_desc *desc);
/* Frees everything that there is. The device is idle. */
void gpu_clear(stilb_gpu *gpu);
void gpu_finish(stilb_gpu *gpu);

stilb_result gpu_null_create(const stilb_gpu_desc *desc, stilb_gpu **gpu);
stilb_result gpu_vulkan_open(const stilb_gpu_desc *desc, stilb_gpu **gpu);

static inline gpu_buffer *gpu_buffer_of(const stilb_gpu *gpu, uint64_t id)
{
	return gpu_table_get(&gpu->tables[GPU_BUFFER], id);
}

static inline gpu_image *gpu_image_of(const stilb_gpu *gpu, uint64_t id)
{
	return gpu_table_get(&gpu->tables[GPU_IMAGE], id);
}

static inline gpu_set *gpu_set_of(const stilb_gpu *gpu, uint64_t id)
{
	return gpu_table_get(&gpu->tables[GPU_SET], id);
}

static inline gpu_program *gpu_program_of(const stilb_gpu *gpu, uint64_t id)
{
	return gpu_table_get(&gpu->tables[GPU_PROGRAM], id);
}

/* A program that draws one triangle over the area: no vertex shader of its own. */
static inline bool gpu_program_is_fullscreen(const stilb_gpu_program_desc *desc)
{
	return !desc->compute.words && !desc->vertex.words;
}

/* ---- gpu_check.c: rules that follow from limits and formats ------------------------------------------------------ */

stilb_result gpu_check_buffer(const stilb_gpu *gpu, const stilb_gpu_buffer_desc *desc);
/* name: for the message; NULL: of a plan, which names it itself. */
stilb_result gpu_check_image(const stilb_gpu *gpu, const char *name, const stilb_gpu_extent *extent);
stilb_result gpu_check_channels(const stilb_gpu_image_desc *desc);
stilb_result gpu_check_sampler(const stilb_gpu *gpu, const stilb_gpu_sampler_desc *desc);
stilb_result gpu_check_program(const stilb_gpu *gpu, const stilb_gpu_program_desc *desc);
stilb_result gpu_check_upload(const stilb_gpu *gpu, const stilb_gpu_upload *upload);
/* What is wrong with a row; NULL: nothing. */
const char *gpu_check_pass(const stilb_gpu *gpu, const stilb_gpu_plan *plan, const stilb_gpu_pass *pass);
/* The lists of a frame: their buffers, programs and sets are there and fit the passes. */
stilb_result gpu_check_lists(const stilb_gpu *gpu, const stilb_gpu_plan *plan, const stilb_gpu_draws *lists,
                             uint32_t list_count);
/* True if mips of two images have one format and size: then they are copied texel by texel. */
static inline bool gpu_copy_is_exact(const stilb_gpu_extent *from, uint32_t from_mip, const stilb_gpu_extent *to,
                                     uint32_t to_mip)
{
	return from->format == to->format && gpu_mip_side(from->width, from_mip) == gpu_mip_side(to->width, to_mip) &&
	       gpu_mip_side(from->height, from_mip) == gpu_mip_side(to->height, to_mip) &&
	       gpu_mip_side(from->depth, from_mip) == gpu_mip_side(to->depth, to_mip);
}
/* Bytes of a mip of one layer, tightly packed. */
uint64_t gpu_mip_bytes(const stilb_gpu_extent *extent, uint32_t mip);

/* ---- spirv/gpu_spirv.c ------------------------------------------------------------------------------------------- */

/* Which bindings a shader has, and what it is given and hands on: bits of bindings and locations 0..31. */
typedef struct gpu_spirv {
	uint32_t sampled, storage;       /* of set 0 */
	uint32_t uniforms;               /* likewise: uniform buffers */
	uint32_t uniform_bytes;          /* of the largest of them, at least */
	uint32_t items;                  /* sampled images of set 1 */
	uint32_t inputs, integer_inputs; /* what it reads of the stage before it, or of vertices */
	uint32_t outputs;                /* what it writes for the stage behind it, or attachments */
	uint32_t wide_constant; /* number + 1 of a specialization constant that has not 32 bits; 0: there is none */
	const char *wrong;      /* what Stilb does not have: a text; NULL: nothing */
	bool no_memory;         /* to read it */
	uint32_t group_size[3]; /* of compute shaders; 0: given by specialization constants */
} gpu_spirv;

/* False: it is no SPIR-V. */
bool gpu_spirv_read(const stilb_gpu_shader *shader, gpu_spirv *out);

/* ---- injected faults --------------------------------------------------------------------------------------------- */

/* Counts an allocation of the device; true if it must fail (stilb_gpu_faults). [any-thread] */
bool gpu_fault_allocation(stilb_gpu *gpu);
/* True if the device must be lost with the frame that is submitted now (stilb_gpu_faults). */
bool gpu_fault_lost(const stilb_gpu *gpu);
/* True if the window's surface must be lost now that the submitted frame is shown; once (stilb_gpu_faults). */
bool gpu_fault_surface(stilb_gpu *gpu);

/* ---- gpu_upload.c ------------------------------------------------------------------------------------------------ */

/* The ring's room, and how much of it one frame copies, 0: all; the device's buffers can be made. */
stilb_result gpu_ring_create(stilb_gpu *gpu, uint64_t bytes, uint64_t frame_bytes);
void gpu_ring_destroy(stilb_gpu *gpu);
/* Gives back the room of uploads whose frame is done. */
void gpu_ring_frame(stilb_gpu *gpu, uint64_t done);
/* Takes the uploads that have ended and were not copied, for the frame that was begun last, into gpu->ring.ready, and
 * returns how many they are: up to `most` bytes, at least one. Their targets are there. */
uint32_t gpu_ring_ready(stilb_gpu *gpu, uint64_t most);
/* The uploads that were taken last were not copied: they wait again. */
void gpu_ring_untake(stilb_gpu *gpu);

#endif
