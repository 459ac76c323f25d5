/*
 * gpu: programs, and shaders that take the place of those that programs were made of.
 *
 * How a shader is replaced. For each program that has it, another one is made beside the frames, in a hidden entry:
 * with the new code, and a pipeline for each combination of attachments that the old one has. Once all are there, they
 * wait for the next frame's begin, which swaps what is in the two entries; the id stays, and the hidden entry is freed
 * with what was in the program before, once no frame can use that. Who compiles a program's pipelines outside of frames
 * pins it meanwhile: it is neither swapped nor freed.
 */
#include "gpu/gpu_internal.h"
#include "shader_sources.h"

#include <stdlib.h>
#include <string.h>

static const uint32_t fullscreen_vert[] =
#include "fullscreen.vert.inc"
	;

/* A program that will take the place of another. */
struct gpu_successor {
	uint64_t id;       /* of the one whose place it takes */
	uint32_t index;    /* its hidden entry's */
	gpu_program *made; /* in that entry */
};

static stilb_gpu_shader *shader_of(stilb_gpu_program_desc *desc, int stage)
{
	stilb_gpu_shader *const shaders[GPU_STAGES] = {&desc->vertex, &desc->fragment, &desc->compute};
	return shaders[stage];
}

/* Gives a shader words of its own. */
static bool shader_copy(const stilb_gpu_shader *from, stilb_gpu_shader *to)
{
	*to = (stilb_gpu_shader){0};
	if (!from->words)
		return true;
	uint32_t *words = malloc(from->bytes);
	if (words)
		memcpy(words, from->words, from->bytes);
	*to = (stilb_gpu_shader){.words = words, .bytes = from->bytes};
	return words;
}

/* ---- sources ----------------------------------------------------------------------------------------------------- */

/* The entry of a source, which may be a new one; it never moves. NULL: no memory. */
static gpu_source *source_find(stilb_gpu *gpu, const char *text)
{
	STILB_ASSERT_LOCKED(&gpu->lock);
	for (uint32_t s = 0; s < gpu->source_count; s++)
		if (strcmp(gpu->sources[s]->text, text) == 0)
			return gpu->sources[s];
	gpu_source **grown = realloc(gpu->sources, (gpu->source_count + 1) * sizeof(*grown));
	if (!grown)
		return NULL;
	gpu->sources = grown;
	gpu_source *source = calloc(1, sizeof *source);
	char *copy = strdup(text);
	if (!source || !copy) {
		free(source);
		free(copy);
		return NULL;
	}
	source->text = copy;
	grown[gpu->source_count++] = source;
	return source;
}

void gpu_sources_finish(stilb_gpu *gpu)
{
	for (uint32_t s = 0; s < gpu->source_count; s++) {
		free((void *)gpu->sources[s]->code.words);
		free(gpu->sources[s]->text);
		free(gpu->sources[s]);
	}
	free(gpu->sources);
	free(gpu->successors);
	gpu->sources = NULL;
	gpu->successors = NULL;
	gpu->source_count = gpu->successor_count = 0;
}

const char *stilb_gpu_shader_source(stilb_gpu *gpu, uint32_t index)
{
	stilb_lock_take(&gpu->lock);
	const char *text = index < gpu->source_count ? gpu->sources[index]->text : NULL;
	stilb_lock_give(&gpu->lock);
	return text;
}

/* ---- programs ---------------------------------------------------------------------------------------------------- */

/* The description with all shaders that its program is made of. */
static stilb_gpu_program_desc code_given(const stilb_gpu_program_desc *desc)
{
	stilb_gpu_program_desc given = *desc;
	if (gpu_program_is_fullscreen(desc))
		given.vertex = (stilb_gpu_shader){fullscreen_vert, sizeof fullscreen_vert, SOURCE_fullscreen_vert};
	return given;
}

/* The code of each stage: that which took its source's place, or the description's. False: no memory. */
static bool code_take(stilb_gpu *gpu, gpu_program *program, const stilb_gpu_program_desc *desc)
{
	stilb_gpu_program_desc given = code_given(desc);
	bool good = true;
	stilb_lock_take(&gpu->lock);
	for (int s = 0; s < GPU_STAGES && good; s++) {
		stilb_gpu_shader *own = shader_of(&given, s);
		bool named = own->words && own->source;
		if (named && !program->sources[s])
			program->sources[s] = source_find(gpu, own->source);
		const gpu_source *source = program->sources[s];
		program->versions[s] = source ? source->version : 0;
		good = (source || !named) && shader_copy(source && source->code.words ? &source->code : own, &program->code[s]);
	}
	stilb_lock_give(&gpu->lock);
	return good;
}

/* The program's description with the code that it has. */
static stilb_gpu_program_desc code_desc(const gpu_program *program)
{
	stilb_gpu_program_desc desc = program->desc;
	for (int s = 0; s < GPU_STAGES; s++)
		*shader_of(&desc, s) = program->code[s];
	return desc;
}

/* Code that took the place of a shader does not fit this program, which was made after it: it gets its own. */
static bool code_refuse(gpu_program *program, const stilb_gpu_program_desc *desc)
{
	stilb_log("%s; it keeps the shaders that it was built with", stilb_error_message());
	stilb_gpu_program_desc given = code_given(desc);
	bool good = true;
	gpu_program_forget(program);
	for (int s = 0; s < GPU_STAGES; s++)
		good &= shader_copy(shader_of(&given, s), &program->code[s]);
	return good;
}

/* False: one of its shaders has been replaced since its code was taken. */
static bool program_is_current(stilb_gpu *gpu, gpu_program *program)
{
	stilb_lock_take(&gpu->lock);
	bool current = true, named = false;
	for (int s = 0; s < GPU_STAGES; s++) {
		const gpu_source *source = program->sources[s];
		named = named || source;
		current = current && (!source || program->versions[s] == source->version);
	}
	program->named = named && current;
	stilb_lock_give(&gpu->lock);
	return current;
}

static stilb_result program_make(stilb_gpu *gpu, gpu_program *program, const stilb_gpu_program_desc *desc)
{
	for (;;) {
		bool copied = code_take(gpu, program, desc);
		bool replaced = program->versions[0] > 0 || program->versions[1] > 0 || program->versions[2] > 0;
		stilb_gpu_program_desc with = code_desc(program);
		if (copied && replaced && gpu_check_program(gpu, &with) != STILB_OK)
			copied = code_refuse(program, desc);
		if (!copied)
			return stilb_fail(STILB_ERROR_MEMORY, "no memory for the shaders of program '%s'", program->name);
		stilb_result result = gpu->functions->program_make(gpu, program);
		if (result != STILB_OK || program_is_current(gpu, program))
			return result;
		gpu->functions->program_free(gpu, program);
		gpu_program_forget(program);
	}
}

/* What an entry has of a description: of the shaders it says only that they are there. */
static void program_describe(gpu_program *program, const stilb_gpu_program_desc *desc)
{
	static const uint32_t there[1];
	gpu_name_copy(program->name, desc->name);
	program->desc = *desc;
	program->desc.name = program->name;
	for (int s = 0; s < GPU_STAGES; s++) {
		stilb_gpu_shader *shader = shader_of(&program->desc, s);
		*shader = (stilb_gpu_shader){.words = shader->words ? there : NULL};
	}
}

stilb_result stilb_gpu_program_create(stilb_gpu *gpu, const stilb_gpu_program_desc *desc, stilb_gpu_program *out)
{
	STILB_ASSERT(gpu && desc && out);
	*out = (stilb_gpu_program){0};
	stilb_result result = gpu_check_program(gpu, desc);
	if (result != STILB_OK)
		return result;
	uint64_t id;
	gpu_program *program = gpu_entry_add(gpu, GPU_PROGRAM, &id);
	if (!program)
		return STILB_ERROR_MEMORY;
	program_describe(program, desc);
	result = program_make(gpu, program, desc);
	if (result == STILB_OK)
		out->id = (uint32_t)id;
	else {
		gpu_program_forget(program);
		gpu_entry_drop(gpu, GPU_PROGRAM, program, id);
	}
	return result;
}

void stilb_gpu_program_destroy(stilb_gpu *gpu, stilb_gpu_program program)
{
	gpu_entry_retire(gpu, GPU_PROGRAM, program.id);
}

stilb_result stilb_gpu_program_prepare(stilb_gpu *gpu, stilb_gpu_program program, const stilb_gpu_format *colors,
                                       uint32_t color_count, stilb_gpu_format depth, uint32_t samples)
{
	stilb_lock_take(&gpu->lock);
	gpu_program *entry = gpu_program_of(gpu, program.id);
	STILB_ASSERT(entry && color_count <= STILB_GPU_MAX_COLORS && (colors || color_count == 0) && samples > 0);
	entry->pins++;
	stilb_lock_give(&gpu->lock);
	stilb_result result = gpu->functions->program_prepare(gpu, entry, colors, color_count, depth, samples);
	stilb_lock_take(&gpu->lock);
	entry->pins--;
	stilb_lock_give(&gpu->lock);
	return result;
}

/* ---- other shaders in their place -------------------------------------------------------------------------------- */

typedef struct replace_work {
	const stilb_gpu_shader *shaders; /* [count] */
	stilb_gpu_shader *copies;        /* [count] of them, for programs that will be made */
	uint32_t count;
	gpu_successor *made; /* [made_count] */
	uint32_t made_count, made_capacity;
} replace_work;

/* The new shader of a source; NULL: there is none. */
static const stilb_gpu_shader *replace_shader(const replace_work *work, const gpu_source *source)
{
	for (uint32_t i = 0; source && i < work->count; i++)
		if (strcmp(work->shaders[i].source, source->text) == 0)
			return &work->shaders[i];
	return NULL;
}

/* True if the program with this id has one of the shaders, and was not made anew yet. */
static bool replace_concerns(const replace_work *work, const gpu_program *program, uint64_t id)
{
	for (uint32_t m = 0; m < work->made_count; m++)
		if (work->made[m].id == id)
			return false;
	for (int s = 0; s < GPU_STAGES; s++)
		if (replace_shader(work, program->sources[s]))
			return true;
	return false;
}

static bool replace_reserve(replace_work *work)
{
	if (work->made_count < work->made_capacity)
		return true;
	uint32_t capacity = work->made_capacity ? 2 * work->made_capacity : 8;
	gpu_successor *grown = realloc(work->made, capacity * sizeof *grown);
	if (!grown)
		return false;
	work->made = grown;
	work->made_capacity = capacity;
	return true;
}

static void replace_drop(stilb_gpu *gpu, const gpu_successor *next)
{
	if (next->made->named)
		gpu->functions->program_free(gpu, next->made);
	gpu_program_forget(next->made);
	gpu_table_drop(&gpu->tables[GPU_PROGRAM], next->made, next->index);
}

/* Makes what is waiting under the same id superfluous, and lets the new programs wait. The caller holds the lock. */
static bool replace_publish(stilb_gpu *gpu, replace_work *work)
{
	uint32_t most = gpu->successor_count + work->made_count;
	gpu_successor *grown = most > 0 ? realloc(gpu->successors, most * sizeof *grown) : gpu->successors;
	gpu_source *sources[work->count + 1];
	if (!grown && most > 0)
		return false;
	gpu->successors = grown;
	for (uint32_t i = 0; i < work->count; i++)
		if (!(sources[i] = source_find(gpu, work->shaders[i].source)))
			return false;
	for (uint32_t i = 0; i < work->count; i++) {
		free((void *)sources[i]->code.words);
		sources[i]->code = work->copies[i];
		sources[i]->version++;
		work->copies[i] = (stilb_gpu_shader){0};
	}
	for (uint32_t m = 0; m < work->made_count; m++) {
		gpu_successor *next = &work->made[m];
		uint32_t at = 0;
		for (int s = 0; s < GPU_STAGES; s++)
			next->made->versions[s] = next->made->sources[s] ? next->made->sources[s]->version : 0;
		while (at < gpu->successor_count && gpu->successors[at].id != next->id)
			at++;
		if (at < gpu->successor_count) { /* no frame has seen it */
			replace_drop(gpu, &gpu->successors[at]);
		} else {
			gpu->successor_count++;
		}
		gpu->successors[at] = *next;
	}
	return true;
}

/* Makes `made` a copy of a program with the new shaders, but for what it has on the device. The caller holds the lock.
 * False: no memory. */
static bool replace_describe(const replace_work *work, const gpu_program *old, gpu_program *made)
{
	program_describe(made, &old->desc);
	for (int s = 0; s < GPU_STAGES; s++) {
		const gpu_source *source = made->sources[s] = old->sources[s];
		const stilb_gpu_shader *now = replace_shader(work, source);
		now = now ? now : source && source->code.words ? &source->code : &old->code[s];
		if (!shader_copy(now, &made->code[s]))
			return false;
	}
	return true;
}

/* Describes the next program that has one of the shaders; or, if all have been made anew, publishes them: *id is 0
 * then. False: no memory. */
static bool replace_next(stilb_gpu *gpu, replace_work *work, gpu_program *made, uint64_t *id)
{
	const gpu_table *table = &gpu->tables[GPU_PROGRAM];
	bool good = true;
	*id = 0;
	stilb_lock_take(&gpu->lock);
	for (uint32_t i = 0; i < table->count && *id == 0; i++) {
		const gpu_program *program = gpu_table_at(table, i);
		if (!program || program->entry.hidden || !program->named)
			continue;
		uint64_t of = (uint64_t)program->entry.generation << GPU_INDEX_BITS | (i + 1);
		if (replace_concerns(work, program, of)) {
			*id = of;
			good = replace_describe(work, program, made);
		}
	}
	if (*id == 0)
		good = replace_publish(gpu, work);
	stilb_lock_give(&gpu->lock);
	return good;
}

/* Makes what `made` is described as, with the pipelines that the program has whose place it will take. */
static stilb_result replace_make(stilb_gpu *gpu, gpu_program *made, uint64_t id)
{
	stilb_gpu_program_desc desc = code_desc(made);
	stilb_result result = gpu_check_program(gpu, &desc);
	if (result == STILB_OK)
		result = gpu->functions->program_make(gpu, made);
	if (result != STILB_OK)
		return result;
	stilb_lock_take(&gpu->lock);
	const gpu_program *old = gpu_program_of(gpu, id); /* NULL: it has been destroyed meanwhile */
	made->named = true;                               /* it has something on the device */
	result = old ? gpu->functions->program_follow(gpu, old, made) : STILB_OK;
	stilb_lock_give(&gpu->lock);
	return result == STILB_OK ? gpu->functions->program_compile(gpu, made) : result;
}

/* Makes another program anew, if there is one, or publishes them all. */
static stilb_result replace_step(stilb_gpu *gpu, replace_work *work, bool *published)
{
	uint64_t id, entry;
	gpu_program *made = replace_reserve(work) ? gpu_entry_add(gpu, GPU_PROGRAM, &entry) : NULL;
	if (!made)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for a program with another shader");
	stilb_lock_take(&gpu->lock);
	gpu_table_hide(&gpu->tables[GPU_PROGRAM], made);
	stilb_lock_give(&gpu->lock);
	bool good = replace_next(gpu, work, made, &id);
	*published = good && id == 0;
	if (!*published)
		work->made[work->made_count++] = (gpu_successor){id, gpu_entry_index(entry), made};
	else
		gpu_entry_drop(gpu, GPU_PROGRAM, made, entry);
	if (!good)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory to replace %u shaders", work->count);
	return *published ? STILB_OK : replace_make(gpu, made, id);
}

/* Ends the work; what was not published is freed. */
static void replace_end(stilb_gpu *gpu, replace_work *work, bool published)
{
	stilb_lock_take(&gpu->lock);
	for (uint32_t m = 0; m < work->made_count && !published; m++)
		replace_drop(gpu, &work->made[m]);
	stilb_lock_give(&gpu->lock);
	for (uint32_t i = 0; work->copies && i < work->count; i++)
		free((void *)work->copies[i].words);
	free(work->copies);
	free(work->made);
}

stilb_result stilb_gpu_shaders_replace(stilb_gpu *gpu, const stilb_gpu_shader *shaders, uint32_t count,
                                       uint32_t *programs)
{
	STILB_ASSERT(gpu && shaders && count > 0);
	stilb_lock_take(&gpu->replacing);
	replace_work work = {.shaders = shaders, .count = count, .copies = calloc(count, sizeof *work.copies)};
	bool copied = work.copies, published = false;
	for (uint32_t i = 0; i < count && copied; i++) {
		STILB_ASSERT(shaders[i].words && shaders[i].source);
		copied = shader_copy(&shaders[i], &work.copies[i]);
	}
	stilb_result result = copied ? STILB_OK : stilb_fail(STILB_ERROR_MEMORY, "no memory to replace %u shaders", count);
	while (result == STILB_OK && !published)
		result = replace_step(gpu, &work, &published);
	if (programs)
		*programs = published ? work.made_count : 0;
	replace_end(gpu, &work, published);
	stilb_lock_give(&gpu->replacing);
	return result;
}

void gpu_programs_swap(stilb_gpu *gpu)
{
	STILB_ASSERT_LOCKED(&gpu->lock);
	for (uint32_t n = 0; n < gpu->successor_count; n++) {
		const gpu_program *program = gpu_program_of(gpu, gpu->successors[n].id);
		if (program && program->pins > 0)
			return; /* all in one frame, so in a later one */
	}
	for (uint32_t n = 0; n < gpu->successor_count; n++) {
		gpu_program *program = gpu_program_of(gpu, gpu->successors[n].id), *made = gpu->successors[n].made;
		if (program) {
			stilb_gpu_shader code[GPU_STAGES];
			void *own = program->own;
			memcpy(code, program->code, sizeof code);
			memcpy(program->code, made->code, sizeof code);
			memcpy(program->versions, made->versions, sizeof program->versions);
			program->own = made->own;
			memcpy(made->code, code, sizeof code);
			made->own = own;
		}
		gpu_entry_retire_hidden(gpu, GPU_PROGRAM, gpu->successors[n].index);
	}
	gpu->successor_count = 0;
}
