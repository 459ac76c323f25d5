/*
 * gi_checkpoint: writes and reads checkpoints, files from which another process continues a render.
 *
 * The file: a line that identifies the format; the length of a text and the text, with a line "name value" for
 * everything that must be the same; checkpoint_state; the film's sums; and the FNV-1a hash of all that. Byte order
 * and floats are the machine's.
 */
#include "gi/gi_render_internal.h"

#include "base/base_file.h"
#include "gi/gi_scene_hash.h"
#include "gi/gi_settings.h"
#include "profiler/prof.h"

#include <errno.h>
#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#define CHECKPOINT_MAGIC "stilb gi checkpoint 1\n"
#define CHECKPOINT_MAX_TEXT 16384u

/* ---- what must be the same --------------------------------------------------------------------------------------- */

/* FNV-1a of a file that the render reads; 0 if there is none. */
static uint64_t hash_file(const char *path)
{
	FILE *stream;
	if (!path || stilb_file_read_open(path, &stream) != STILB_OK)
		return 0;
	char part[4096];
	uint64_t hash = STILB_FNV1A64_START;
	for (size_t got; (got = fread(part, 1, sizeof part, stream)) > 0;)
		hash = stilb_hash_fnv1a64(hash, part, got);
	fclose(stream);
	return hash;
}

typedef struct checkpoint_text {
	uint32_t length;
	char text[CHECKPOINT_MAX_TEXT];
} checkpoint_text;

static void __attribute__((format(printf, 2, 3))) text_line(checkpoint_text *text, const char *format, ...)
{
	va_list arguments;
	va_start(arguments, format);
	int length = vsnprintf(text->text + text->length, sizeof text->text - text->length, format, arguments);
	va_end(arguments);
	text->length += (uint32_t)length;
	STILB_ASSERT(text->length < sizeof text->text);
}

static void text_make(const stilb_gi_render *render, checkpoint_text *text)
{
	const stilb_gi_scene *scene = render->view.scene;
	text->length = 0;
	text_line(text, "version %s\n", STILB_VERSION);
	text_line(text, "isa %s\n", scene->info.isa);
	text_line(text, "scene %016" PRIx64 "\n", gi_scene_hash(scene));
	for (uint32_t i = 0; i < gi_settings_count(); i++) {
		gi_setting setting = gi_settings_get(&render->view.settings, i);
		if (setting.role == GI_SETTING_SAMPLE)
			text_line(text, "%s %s\n", setting.name, setting.value);
	}
	text_line(text, "cache.load %016" PRIx64 "\n", hash_file(render->view.settings.cache.load));
}

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

stilb_result stilb_gi_render_checkpoint(const stilb_gi_render *render, const char *path)
{
	STILB_ASSERT_OWNER(render->owner);
	STILB_ASSERT(render->begun_ns == 0 && "run does not run");
	STILB_ASSERT(path);
	PROFILE("gi.checkpoint");
	checkpoint_text text;
	checkpoint_state state;
	stilb_file file;
	stilb_result result = stilb_file_open(&file, path);
	if (result != STILB_OK)
		return result;
	text_make(render, &text);
	state_make(render, &state);
	uint64_t hash = STILB_FNV1A64_START;
	const gi_film *film = &render->film;
	checkpoint_write_hashed(&file, &hash, CHECKPOINT_MAGIC, sizeof CHECKPOINT_MAGIC - 1);
	checkpoint_write_hashed(&file, &hash, &text.length, sizeof text.length);
	checkpoint_write_hashed(&file, &hash, text.text, text.length);
	checkpoint_write_hashed(&file, &hash, &state, sizeof state);
	checkpoint_write_hashed(&file, &hash, film->pixels, film_pixels(film) * sizeof *film->pixels);
	if (film->weights)
		checkpoint_write_hashed(&file, &hash, film->weights, film_pixels(film) * sizeof *film->weights);
	stilb_file_write(&file, &hash, sizeof hash);
	return stilb_file_commit(&file);
}

/* ---- reading it -------------------------------------------------------------------------------------------------- */

typedef struct checkpoint_reader {
	const char *path;
	FILE *stream;
	uint64_t hash, left; /* left: bytes of the file that are not read yet */
	checkpoint_state state;
	gi_film film; /* the film's sums as read; of this struct only pixels and weights are set */
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

/* Length of the text up to the first of the characters in ends. */
static int text_word(const char *line, const char *ends)
{
	return (int)strcspn(line, ends);
}

/* Fails with the name of the first line that differs between two texts. */
static stilb_result resume_differs(const checkpoint_reader *reader, const char *theirs, const char *ours)
{
	while (*theirs && *ours) {
		int their_length = text_word(theirs, "\n"), our_length = text_word(ours, "\n");
		if (their_length != our_length || memcmp(theirs, ours, (size_t)our_length) != 0)
			break;
		theirs += their_length + (theirs[their_length] == '\n');
		ours += our_length + (ours[our_length] == '\n');
	}
	int name = text_word(ours, " \n");
	if (!*ours || strncmp(theirs, ours, (size_t)name) != 0 || theirs[name] != ' ')
		return resume_fail(reader, "it was made by another version");
	if (strncmp(ours, "scene", 5) == 0)
		return resume_fail(reader, "it belongs to another scene");
	if (strncmp(ours, "cache.load", 10) == 0)
		return resume_fail(reader, "the loaded irradiance cache is another one");
	const char *their_value = theirs + name + 1, *our_value = ours + name + 1;
	return stilb_fail(STILB_ERROR_FILE, "cannot resume from '%s': it was made with %.*s %.*s, not %.*s", reader->path,
	                  name, ours, text_word(their_value, "\n"), their_value, text_word(our_value, "\n"), our_value);
}

static stilb_result read_text(checkpoint_reader *reader, const stilb_gi_render *render)
{
	char magic[sizeof CHECKPOINT_MAGIC - 1];
	if (!checkpoint_read_hashed(reader, magic, sizeof magic) || memcmp(magic, CHECKPOINT_MAGIC, sizeof magic) != 0)
		return resume_fail(reader, "it is not a checkpoint of this version");
	checkpoint_text theirs, ours;
	if (!checkpoint_read_hashed(reader, &theirs.length, sizeof theirs.length) || theirs.length >= sizeof theirs.text ||
	    !checkpoint_read_hashed(reader, theirs.text, theirs.length))
		return resume_damaged(reader);
	theirs.text[theirs.length] = '\0';
	text_make(render, &ours);
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
	if (reader->left != count * (sizeof *shape->pixels + weights) + sizeof reader->hash)
		return resume_damaged(reader);
	gi_film *film = &reader->film;
	film->pixels = stilb_memory_alloc(count, sizeof *film->pixels);
	film->weights = weights ? stilb_memory_alloc(count, weights) : NULL;
	if (!film->pixels || (weights && !film->weights))
		return stilb_fail(STILB_ERROR_MEMORY, "cannot resume from '%s': out of memory", reader->path);
	bool whole = checkpoint_read_hashed(reader, film->pixels, count * sizeof *film->pixels) &&
	             (!weights || checkpoint_read_hashed(reader, film->weights, count * weights));
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
	return read_film(reader, &render->film);
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
	STILB_ASSERT(loaded->pixels && !loaded->weights == !film->weights);
	gi_film_pixel *pixels = film->pixels;
	gi_film_weight *weights = film->weights;
	film->pixels = loaded->pixels;
	film->weights = loaded->weights;
	loaded->pixels = pixels; /* the old arrays: freed with the reader, to which loaded belongs */
	loaded->weights = weights;
	for (size_t i = 0; i < film_pixels(film); i++)
		gi_film_resolve(film, i);
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
		take_film(&render->film, &reader.film);
		stilb_lock_take(&render->lock);
		take_passes(render, &reader.state);
		render->seconds = reader.state.seconds;
		render->estimate = reader.state.estimate;
		render->resumed = reader.state.totals;
		stilb_lock_give(&render->lock);
	}
	gi_film_finish(&reader.film);
	return result;
}
