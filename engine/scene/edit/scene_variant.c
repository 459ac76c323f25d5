/* Variants of materials: which part shows which. */
#include "scene/edit/scene_variant.h"

#include "scene/edit/scene_edit_internal.h"
#include "scene/scene_internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

stilb_result scene_add_variants(stilb_scene *scene, uint32_t count)
{
	STILB_ASSERT(!scene->variants && count > 0 && count <= STILB_SCENE_MAX_VARIANTS);
	uint64_t numbers = (count + 1ull) * scene->part_count;
	stilb_scene_variants *made = calloc(1, sizeof *made);
	if (made) {
		*made = (stilb_scene_variants){.count = count,
		                               .part_count = scene->part_count,
		                               .names = calloc(count, sizeof *made->names),
		                               .materials = calloc(numbers + 1, sizeof *made->materials)};
		scene->variants = made;
	}
	if (made && made->names && made->materials)
		return STILB_OK;
	return stilb_fail(STILB_ERROR_MEMORY, "no memory for %u variants of %u parts", count, scene->part_count);
}

void scene_variants_finish(stilb_scene_variants *variants)
{
	if (!variants)
		return;
	free(variants->names);
	free(variants->materials);
	free(variants);
}

bool scene_variants_are_sound(const stilb_scene *scene)
{
	const stilb_scene_variants *variants = scene->variants;
	if (!variants)
		return true;
	bool sound = variants->part_count <= scene->part_count && variants->shown <= variants->count;
	for (uint32_t v = 0; sound && v < variants->count; v++)
		sound = memchr(variants->names[v], 0, sizeof variants->names[v]);
	for (uint64_t i = 0; sound && i < (variants->count + 1ull) * variants->part_count; i++)
		sound = variants->materials[i] < scene->material_count;
	return sound;
}

/* Gives the parts of a model that show what the variant before says the material of the next one. */
static void variant_paint(stilb_scene *scene, uint32_t model, const uint32_t *from, const uint32_t *to)
{
	edit_ids *ids = &scene->edits->materials;
	bool changed = false;
	for (uint32_t p = scene->first_part[model]; p < scene->first_part[model + 1]; p++) {
		if (scene->part_material[p] != from[p] || from[p] == to[p])
			continue;
		ids->users[from[p]]--;
		ids->users[to[p]]++;
		scene->part_material[p] = to[p];
		changed = true;
	}
	if (!changed)
		return;
	scene_impostor_forget(scene, model);
	scene_edit_moved(scene, model);
	scene->revisions.models++;
}

stilb_result stilb_scene_show_variant(stilb_scene *scene, uint32_t variant)
{
	STILB_ASSERT(scene);
	stilb_scene_variants *variants = scene->variants;
	if (variant > (variants ? variants->count : 0))
		return stilb_fail(STILB_ERROR_ARGUMENT, "there is no variant %u of its materials", variant);
	if (!variants || variant == variants->shown)
		return STILB_OK;
	stilb_result result = scene_edit_begin(scene);
	if (result != STILB_OK)
		return result;
	const edit_ids *ids = &scene->edits->materials;
	const uint32_t *from = variants->materials + (size_t)variants->shown * variants->part_count;
	const uint32_t *to = variants->materials + (size_t)variant * variants->part_count;
	for (uint32_t p = 0; p < variants->part_count; p++)
		if (scene->part_material[p] == from[p] && !scene_edit_has(ids, scene->material_count, to[p]))
			return stilb_fail(STILB_ERROR_ARGUMENT, "variant %u: its material %u was removed", variant, to[p]);
	for (uint32_t m = 0; m < scene->model_count && scene->first_part[m] < variants->part_count; m++)
		variant_paint(scene, m, from, to);
	variants->shown = variant;
	return STILB_OK;
}

stilb_result stilb_scene_show_variant_named(stilb_scene *scene, const char *name)
{
	STILB_ASSERT(scene && name);
	const stilb_scene_variants *variants = scene->variants;
	char list[512] = "";
	size_t size = 0;
	if (!variants)
		return stilb_fail(STILB_ERROR_ARGUMENT, "there is no variant '%s' of its materials: it has none", name);
	for (uint32_t v = 0; v < variants->count; v++) {
		if (strncmp(variants->names[v], name, sizeof variants->names[v] - 1) == 0)
			return stilb_scene_show_variant(scene, v + 1);
		size_t length = strlen(variants->names[v]);
		if (size + length + 8 < sizeof list)
			size += (size_t)snprintf(list + size, sizeof list - size, "%s'%s'", v > 0 ? ", " : "", variants->names[v]);
	}
	return stilb_fail(STILB_ERROR_ARGUMENT, "there is no variant '%s' of its materials; there are %s", name, list);
}
