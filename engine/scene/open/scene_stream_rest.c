#include "scene/open/scene_stream_rest.h"

#include "scene/edit/scene_variant.h"
#include "scene/scene_internal.h"

void scene_stream_clean_name(char *name, size_t size)
{
	for (size_t i = 0; i < size && name[i] != 0; i++)
		if ((unsigned char)name[i] < ' ' || name[i] == 0x7f)
			name[i] = ' ';
}

/* ---- variants ---------------------------------------------------------------------------------------------------- */

#define STREAM_MAX_VARIANT_MATERIALS (1u << 28) /* of all variants and parts, 1 GiB */

static bool stream_put_variants(int file, const stilb_scene_variants *variants)
{
	uint32_t count = variants ? variants->count : 0;
	if (!scene_stream_put(file, &count, sizeof count) || count == 0)
		return count == 0;
	return scene_stream_put(file, variants->names, count * sizeof *variants->names) &&
	       scene_stream_put(file, variants->materials,
	                        (count + (size_t)1) * variants->part_count * sizeof *variants->materials);
}

static stilb_result stream_get_variants(scene_stream *stream, stilb_scene *scene)
{
	uint32_t count;
	if (!scene_stream_get(stream, &count, sizeof count))
		return scene_stream_broken(stream);
	if (count == 0)
		return STILB_OK;
	uint64_t materials = (count + 1ull) * scene->part_count;
	if (count > STILB_SCENE_MAX_VARIANTS || materials > STREAM_MAX_VARIANT_MATERIALS)
		return scene_stream_wrong("variants");
	stilb_result result = scene_add_variants(scene, count);
	if (result != STILB_OK)
		return result;
	stilb_scene_variants *variants = scene->variants;
	bool good = scene_stream_get(stream, variants->names, count * sizeof *variants->names) &&
	            scene_stream_get(stream, variants->materials, materials * sizeof *variants->materials);
	for (uint32_t v = 0; good && v < count; v++)
		scene_stream_clean_name(variants->names[v], sizeof variants->names[v]);
	return good ? STILB_OK : scene_stream_broken(stream);
}

/* ---- all --------------------------------------------------------------------------------------------------------- */

bool scene_stream_write_rest(int file, const stilb_scene *scene)
{
	return stream_put_variants(file, scene->variants);
}

stilb_result scene_stream_read_rest(scene_stream *stream, stilb_scene *scene)
{
	return stream_get_variants(stream, scene);
}
