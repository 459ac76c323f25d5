/*
 * gi_checkpoint: writes and reads checkpoints, files from which another process continues a render.
 *
 * The file: a line that identifies the format; the length of a text and the text, with a line "name value" for
 * everything that must be the same; checkpoint_state; the film's sums, of a share of the picture (gi_farm.h) those of
 * its units alone; and the FNV-1a hash of all that. Byte order and floats are the machine's.
 */
#include "gi/gi_render_internal.h"

#include "base/base_file.h"
#include "gi/film/gi_identity.h"
#include "profiler/prof.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#define CHECKPOINT_MAGIC "stilb gi checkpoint 1\n"

/* ---- the file ---------------------------------------------------------------------------------------------------- */

typedef struct checkpoint_pass {
	double seconds;
	uint32_t block, first_sample, sample_count, finished;
} checkpoint_pass;

typedef struct checkpoint_state {
	double seconds;
	gi_render_totals totals;
	uint32_t pass_count, weighted;
	checkpoint_pass passes[STILB_GI_MAX_PASSES];
	double estimate;
} checkpoint_state;

static void state_make(const stilb_gi_render *render, checkpoint_state *state)
{
	STILB_ASSERT(render->pass_count <= STILB_GI_MAX_PASSES);
	memset(state, 0, sizeof *state);
	state->seconds = render->seconds;
	state->totals = gi_render_totals_of(render);
	state->pass_count = render->pass_count;
	state->weighted = render->film.weights ? 1 : 0;
	state->estimate = render->estimate;
	for (uint32_t i = 0; i < render->pass_count; i++) {
		const stilb_gi_pass *pass = &render->passes[i];
		state->passes[i] =
			(checkpoint_pass){pass->seconds, pass->block, pass->first_sample, pass->sample_count, pass->finished};
	}
}

static size_t film_pixels(const gi_film *film)
{
	return (size_t)film->width * film->height;
}

static void checkpoint_write_hashed(stilb_file *file, uint64_t *hash, const void *data, size_t size)
{
	*hash = stilb_hash_fnv1a64(*hash, data, size);
	stilb_file_write(file, data, size); /* its failure is reported by stilb_file_commit later */
}

/* The units of the render's share. */
static stilb_result write_share(const stilb_gi_render *render, stilb_file *file, uint64_t *hash)
{
	uint32_t size = gi_unit_size(&render->units, &render->film);
	stilb_farm_range range = stilb_farm_share(render->units.count, render->share_index, render->share_of);
	void *result = stilb_memory_alloc(1, size);
	if (!result)
		return stilb_fail(STILB_ERROR_MEMORY, "cannot write '%s': out of memory", file->path);
	for (uint32_t i = 0; i < range.count; i++) {
		gi_unit_get(&render->units, &render->film, range.first + i, result);
		checkpoint_write_hashed(file, hash, result, size);
	}
	free(result);
	return STILB_OK;
}

stilb_result stilb_gi_render_checkpoint(const stilb_gi_render *render, const char *path)
{
	STILB_ASSERT_OWNER(render->owner);
	STILB_ASSERT(render->begun_ns == 0 && "run does not run");
	STILB_ASSERT(path);
	PROFILE("gi.checkpoint");
	gi_identity text;
	checkpoint_state state;
	stilb_file file;
	stilb_result result = stilb_file_open(&file, path);
	if (result != STILB_OK)
		return result;
	gi_identity_make(render, GI_IDENTITY_CHECKPOINT, &text);
	state_make(render, &state);
	uint64_t hash = STILB_FNV1A64_START;
	const gi_film *film = &render->film;
	checkpoint_write_hashed(&file, &hash, CHECKPOINT_MAGIC, sizeof CHECKPOINT_MAGIC - 1);
	checkpoint_write_hashed(&file, &hash, &text.length, sizeof text.length);
	checkpoint_write_hashed(&file, &hash, text.text, text.length);
	checkpoint_write_hashed(&file, &hash, &state, sizeof state);
	if (render->share_of > 0) {
		result = write_share(render, &file, &hash);
	} else {
		checkpoint_write_hashed(&file, &hash, film->pixels, film_pixels(film) * sizeof *film->pixels);
		if (film->weights)
			checkpoint_write_hashed(&file, &hash, film->weights, film_pixels(film) * sizeof *film->weights);
		if (film->halves)
			checkpoint_write_hashed(&file, &hash, film->halves, film_pixels(film) * sizeof *film->halves);
	}
	if (result != STILB_OK) {
		stilb_file_finish(&file);
		return result;
	}
	stilb_file_write(&file, &hash, sizeof hash);
	return stilb_file_commit(&file);
}

/* ---- reading it -------------------------------------------------------------------------------------------------- */

typedef struct checkpoint_reader {
	const char *path;
	FILE *stream;
	uint64_t hash, left; /* left: bytes of the file that are not read yet */
	checkpoint_state state;
	gi_film film; /* the film's sums as read; of this struct only pixels, weights and halves are set */
	char *share;  /* of a share, its units in their place */
} checkpoint_reader;

static stilb_result resume_fail(const checkpoint_reader *reader, const char *why)
{
	return stilb_fail(STILB_ERROR_FILE, "cannot resume from '%s': %s", reader->path, why);
}

static stilb_result resume_damaged(const checkpoint_reader *reader)
{
	return resume_fail(reader, "the file is damaged; start anew");
}

static bool checkpoint_read_hashed(checkpoint_reader *reader, void *data, size_t size)
{
	if (size > reader->left || fread(data, 1, size, reader->stream) != size)
		return false;
	reader->left -= size;
	reader->hash = stilb_hash_fnv1a64(reader->hash, data, size);
	return true;
}

/* Fails with the name of the first line that differs between two texts. */
static stilb_result resume_differs(const checkpoint_reader *reader, const char *theirs, const char *ours)
{
	stilb_farm_difference d;
	bool differ = stilb_farm_differ(theirs, ours, &d);
	if (differ && strncmp(d.name, "part ", 5) == 0)
		return stilb_fail(STILB_ERROR_FILE, "cannot resume from '%s': it is of %s%.*s", reader->path,
		                  d.a ? "part " : "the whole picture", d.a_length, d.a ? d.a : "");
	if (!differ || !d.a || !d.b)
		return resume_fail(reader, "it was made by another version");
	if (strncmp(d.name, "scene ", 6) == 0)
		return resume_fail(reader, "it belongs to another scene");
	if (strncmp(d.name, "cache.load ", 11) == 0)
		return resume_fail(reader, "the loaded irradiance cache is another one");
	return stilb_fail(STILB_ERROR_FILE, "cannot resume from '%s': it was made with %.*s %.*s, not %.*s", reader->path,
	                  d.name_length, d.name, d.a_length, d.a, d.b_length, d.b);
}

static stilb_result read_text(checkpoint_reader *reader, const stilb_gi_render *render)
{
	char magic[sizeof CHECKPOINT_MAGIC - 1];
	if (!checkpoint_read_hashed(reader, magic, sizeof magic) || memcmp(magic, CHECKPOINT_MAGIC, sizeof magic) != 0)
		return resume_fail(reader, "it is not a checkpoint of this version");
	gi_identity theirs, ours;
	if (!checkpoint_read_hashed(reader, &theirs.length, sizeof theirs.length) || theirs.length >= sizeof theirs.text ||
	    !checkpoint_read_hashed(reader, theirs.text, theirs.length))
		return resume_damaged(reader);
	theirs.text[theirs.length] = '\0';
	gi_identity_make(render, GI_IDENTITY_CHECKPOINT, &ours);
	if (theirs.length == ours.length && memcmp(theirs.text, ours.text, ours.length) == 0)
		return STILB_OK;
	return resume_differs(reader, theirs.text, ours.text);
}

static bool pass_is_possible(const checkpoint_pass *pass)
{
	bool block = pass->block >= 1 && pass->block <= GI_FILM_LARGEST_BLOCK && (pass->block & (pass->block - 1)) == 0;
	return block && pass->sample_count >= 1 && pass->sample_count <= 65536 && pass->first_sample <= 65536 &&
	       pass->finished <= 1 && pass->seconds >= 0.0;
}

static bool state_is_possible(const checkpoint_state *state, const gi_film *film)
{
	bool possible = state->seconds >= 0.0 && state->estimate >= 0.0 && state->pass_count <= STILB_GI_MAX_PASSES;
	for (uint32_t i = 0; possible && i < state->pass_count; i++)
		possible = pass_is_possible(&state->passes[i]);
	return possible && state->weighted == (film->weights ? 1u : 0u);
}

static stilb_result read_film(checkpoint_reader *reader, const gi_film *shape)
{
	size_t count = film_pixels(shape), weights = shape->weights ? sizeof *shape->weights : 0;
	size_t halves = shape->halves ? sizeof *shape->halves : 0;
	if (reader->left != count * (sizeof *shape->pixels + weights + halves) + sizeof reader->hash)
		return resume_damaged(reader);
	gi_film *film = &reader->film;
	film->pixels = stilb_memory_alloc(count, sizeof *film->pixels);
	film->weights = weights ? stilb_memory_alloc(count, weights) : NULL;
	film->halves = halves ? stilb_memory_alloc(count, halves) : NULL;
	if (!film->pixels || (weights && !film->weights) || (halves && !film->halves))
		return stilb_fail(STILB_ERROR_MEMORY, "cannot resume from '%s': out of memory", reader->path);
	bool whole = checkpoint_read_hashed(reader, film->pixels, count * sizeof *film->pixels) &&
	             (!weights || checkpoint_read_hashed(reader, film->weights, count * weights)) &&
	             (!halves || checkpoint_read_hashed(reader, film->halves, count * halves));
	uint64_t hash = reader->hash, written = 0;
	whole = whole && checkpoint_read_hashed(reader, &written, sizeof written) && written == hash;
	return whole ? STILB_OK : resume_damaged(reader);
}

static stilb_result read_share(checkpoint_reader *reader, const stilb_gi_render *render)
{
	uint32_t size = gi_unit_size(&render->units, &render->film);
	stilb_farm_range range = stilb_farm_share(render->units.count, render->share_index, render->share_of);
	if (reader->left != (uint64_t)range.count * size + sizeof reader->hash)
		return resume_damaged(reader);
	reader->share = stilb_memory_alloc(range.count, size);
	if (!reader->share)
		return stilb_fail(STILB_ERROR_MEMORY, "cannot resume from '%s': out of memory", reader->path);
	bool whole = checkpoint_read_hashed(reader, reader->share, (size_t)range.count * size);
	uint64_t hash = reader->hash, written = 0;
	whole = whole && checkpoint_read_hashed(reader, &written, sizeof written) && written == hash;
	return whole ? STILB_OK : resume_damaged(reader);
}

static stilb_result read_all(checkpoint_reader *reader, const stilb_gi_render *render)
{
	struct stat info;
	if (fstat(fileno(reader->stream), &info) != 0 || !S_ISREG(info.st_mode))
		return resume_fail(reader, "it is not a regular file");
	reader->left = (uint64_t)info.st_size;
	stilb_result result = read_text(reader, render);
	if (result != STILB_OK)
		return result;
	if (!checkpoint_read_hashed(reader, &reader->state, sizeof reader->state) ||
	    !state_is_possible(&reader->state, &render->film))
		return resume_damaged(reader);
	return render->share_of > 0 ? read_share(reader, render) : read_film(reader, &render->film);
}

/* ---- going on ---------------------------------------------------------------------------------------------------- */

/* Takes over the checkpoint's list of passes. If fewer samples are wanted now than its last pass was planned for, that
 * pass is cut to them. If the list is full, its first pass is dropped, so that there is room for one that renders the
 * rest. */
static void take_passes(stilb_gi_render *render, const checkpoint_state *state)
{
	STILB_ASSERT_LOCKED(&render->lock);
	uint32_t samples = render->view.settings.samples;
	uint32_t forgotten = state->pass_count == STILB_GI_MAX_PASSES;
	render->pass_count = state->pass_count - forgotten;
	for (uint32_t i = 0; i < render->pass_count; i++) {
		const checkpoint_pass *from = &state->passes[i + forgotten];
		render->passes[i] =
			(stilb_gi_pass){from->block, from->first_sample, from->sample_count, from->seconds, from->finished != 0};
	}
	stilb_gi_pass *last = render->pass_count ? &render->passes[render->pass_count - 1] : NULL;
	if (last && !last->finished && last->first_sample >= samples)
		render->pass_count--;
	else if (last && !last->finished && last->sample_count > samples - last->first_sample)
		last->sample_count = samples - last->first_sample;
}

static void take_film(gi_film *film, gi_film *loaded)
{
	STILB_ASSERT(loaded->pixels && !loaded->weights == !film->weights && !loaded->halves == !film->halves);
	gi_film old = *film;
	film->pixels = loaded->pixels;
	film->weights = loaded->weights;
	film->halves = loaded->halves;
	loaded->pixels = old.pixels; /* freed with the reader, to which loaded belongs */
	loaded->weights = old.weights;
	loaded->halves = old.halves;
	for (size_t i = 0; i < film_pixels(film); i++)
		gi_film_resolve(film, i);
}

/* The units were read from a file whose hash is right, so their numbers are taken as they are. */
static void take_share(stilb_gi_render *render, const char *share)
{
	uint32_t size = gi_unit_size(&render->units, &render->film);
	stilb_farm_range range = stilb_farm_share(render->units.count, render->share_index, render->share_of);
	for (uint32_t i = 0; i < range.count; i++)
		gi_unit_set(&render->units, &render->film, range.first + i, 0, UINT32_MAX, share + (size_t)i * size);
}

stilb_result stilb_gi_render_resume(stilb_gi_render *render, const char *path)
{
	STILB_ASSERT_OWNER(render->owner);
	STILB_ASSERT(render->begun_ns == 0 && "run does not run");
	STILB_ASSERT(path);
	PROFILE("gi.resume");
	if (render->pass_count > 0)
		return stilb_fail(STILB_ERROR_ARGUMENT, "cannot resume from '%s': the render has begun already", path);
	checkpoint_reader reader = {.path = path, .hash = STILB_FNV1A64_START};
	stilb_result result = stilb_file_read_open(path, &reader.stream);
	if (result != STILB_OK)
		return result;
	result = read_all(&reader, render);
	fclose(reader.stream);
	if (result == STILB_OK) {
		if (reader.share)
			take_share(render, reader.share);
		else
			take_film(&render->film, &reader.film);
		stilb_lock_take(&render->lock);
		take_passes(render, &reader.state);
		render->seconds = reader.state.seconds;
		render->estimate = reader.state.estimate;
		render->resumed = reader.state.totals;
		stilb_lock_give(&render->lock);
	}
	gi_film_finish(&reader.film);
	free(reader.share);
	return result;
}
