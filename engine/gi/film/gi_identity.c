#include "gi/film/gi_identity.h"

#include "base/base_file.h"
#include "gi/gi_scene_hash.h"
#include "gi/gi_settings.h"
#include "gi/integrate/gi_backdrop.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>

/* Counts the changes of the code that gave samples other bits: what was begun before them is not gone on with. */
#define SAMPLES_VERSION 3u

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

static void __attribute__((format(printf, 2, 3))) identity_line(gi_identity *identity, const char *format, ...)
{
	va_list arguments;
	va_start(arguments, format);
	int length =
		vsnprintf(identity->text + identity->length, sizeof identity->text - identity->length, format, arguments);
	va_end(arguments);
	identity->length += (uint32_t)length;
	STILB_ASSERT(identity->length < sizeof identity->text);
}

void gi_identity_make(const stilb_gi_render *render, gi_identity_kind kind, gi_identity *identity)
{
	const stilb_gi_scene *scene = render->view.scene;
	bool part = kind == GI_IDENTITY_PART;
	identity->length = 0;
	identity_line(identity, "version %s, samples %u\n", STILB_VERSION, SAMPLES_VERSION);
	if (part)
		identity_line(identity, "binary %016" PRIx64 "\n", stilb_farm_binary());
	identity_line(identity, "isa %s\n", scene->info.isa);
	identity_line(identity, "scene %016" PRIx64 "\n", gi_scene_hash(scene));
	for (uint32_t i = 0; i < gi_settings_count(); i++) {
		gi_setting setting = gi_settings_get(&render->view.settings, i);
		if (part || setting.role == GI_SETTING_SAMPLE)
			identity_line(identity, "%s %s\n", setting.name, setting.value);
	}
	identity_line(identity, "cache.load %016" PRIx64 "\n", hash_file(render->view.settings.cache.load));
	if (!part && render->share_of > 0)
		identity_line(identity, "part %u/%u of %u units\n", render->share_index, render->share_of, render->units.count);
	if (!part)
		return;
	identity_line(identity, "alpha %s\n", gi_backdrop_is_nothing(scene->backdrop) ? "yes" : "no");
	identity_line(identity, "surroundings %s\n", scene->surroundings);
}
