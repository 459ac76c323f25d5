/* The meshes, materials and textures of the scene that is shown: created with it, and brought up to date with the lists
 * of what has changed in it. */
#include "render/render_internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void render_scene_finish(render_scene *scene)
{
	render_loading_drop(scene);
	free(scene->meshes);
	free(scene->materials);
	free(scene->textures);
	free(scene->functions);
	free(scene->impostors);
	*scene = (render_scene){0};
}

/* Materials before their textures and functions. */
void render_scene_destroy(stilb_render *render, render_scene *scene)
{
	render_places_finish(render, &scene->places, false);
	render_loading_finish(render, scene);
	for (uint32_t i = 0; i < scene->impostor_count; i++)
		stilb_render_impostor_destroy(render, scene->impostors[i]);
	for (uint32_t i = 0; i < scene->mesh_count; i++)
		stilb_render_mesh_destroy(render, scene->meshes[i]);
	for (uint32_t i = 0; i < scene->material_count; i++)
		stilb_render_material_destroy(render, scene->materials[i]);
	for (uint32_t i = 0; i < scene->texture_count; i++)
		stilb_render_texture_destroy(render, scene->textures[i].texture);
	for (uint32_t i = 0; i < scene->function_count; i++)
		render_function_destroy(render, scene->functions[i].index);
	render_scene_finish(scene);
}

/* Makes one table at least `count` long; new entries are zeros, handles that nothing needs to destroy. */
static bool shown_table_fit(void **table, uint32_t *capacity, uint32_t count, size_t size)
{
	uint32_t before = *capacity;
	if (!render_reserve(table, capacity, count, size))
		return false;
	if (*capacity > before)
		memset((char *)*table + before * size, 0, (*capacity - before) * size);
	return true;
}

stilb_result render_scene_fit(render_scene *tables, const stilb_scene *scene)
{
	if (!shown_table_fit((void **)&tables->meshes, &tables->mesh_capacity, scene->mesh_count, sizeof *tables->meshes) ||
	    !shown_table_fit((void **)&tables->materials, &tables->material_capacity, scene->material_count,
	                     sizeof *tables->materials) ||
	    !shown_table_fit((void **)&tables->textures, &tables->texture_capacity, scene->texture_count,
	                     sizeof *tables->textures) ||
	    !shown_table_fit((void **)&tables->functions, &tables->function_capacity, scene->function_count,
	                     sizeof *tables->functions))
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the scene's tables");
	tables->mesh_count = scene->mesh_count;
	tables->material_count = scene->material_count;
	tables->texture_count = scene->texture_count;
	tables->function_count = scene->function_count;
	return STILB_OK;
}

/* Textures that the surface names get mips when they are next made. */
static void shown_mark_textures(render_scene *tables, const stilb_scene_surface *surface)
{
	for (uint32_t i = 0; i < RENDER_MAPS; i++) {
		uint32_t texture = surface->maps[i].texture;
		STILB_ASSERT(texture == 0 || (tables->textures && texture <= tables->texture_count));
		if (texture == 0)
			continue;
		render_scene_texture *named = &tables->textures[texture - 1];
		bool normals = i == STILB_SCENE_MAP_NORMAL || i == STILB_SCENE_MAP_CLEARCOAT_NORMAL;
		named->mapped = true;
		named->as_normals |= normals;
		named->as_other |= !normals;
	}
}

/* What the texture's mips shall hold: the spread of normals where no map needs all channels, and mips are made. */
static render_mips_kind shown_texture_kind(const stilb_render *render, const render_scene_texture *texture,
                                           const stilb_image *image)
{
	if (!image->pixels) /* it was removed */
		return RENDER_MIPS_MEANS;
	render_texture_shape shape = render_texture_shape_of(render->device, image, true);
	bool data = stilb_image_format_as_data(image->format) == image->format;
	if (!texture->as_normals || texture->as_other || !data || stilb_image_format_is_blocks(shape.format) ||
	    shape.given > 1 || render->specular_aa == STILB_RENDER_SPECULAR_AA_OFF)
		return RENDER_MIPS_MEANS;
	return image->channels == 2 ? RENDER_MIPS_NORMALS_TWO : RENDER_MIPS_NORMALS;
}

void render_scene_mark(stilb_render *render, render_scene *tables, const stilb_scene *scene)
{
	for (uint32_t s = 0; s < scene->surface_count; s++)
		shown_mark_textures(tables, &scene->surfaces[s]);
	for (uint32_t t = 0; t < scene->texture_count; t++)
		if (tables->textures[t].mapped && scene->textures[t].pixels)
			render_resources_expect_texture(render, &scene->textures[t]);
}

/* ---- one thing --------------------------------------------------------------------------------------------------- */

stilb_result render_scene_mesh(stilb_render *render, render_scene *tables, const stilb_scene *scene, uint32_t id)
{
	stilb_render_mesh mesh = {0};
	stilb_result result = STILB_OK;
	if (scene->meshes[id].vertices || scene->meshes[id].vertex_count > 0)
		result = stilb_render_mesh_create(render, &scene->meshes[id], &mesh);
	if (result != STILB_OK)
		return result;
	if (mesh.id)
		render_mesh_name(render, mesh, id);
	stilb_render_mesh_destroy(render, tables->meshes[id]);
	tables->meshes[id] = mesh;
	return STILB_OK;
}

static stilb_render_texture shown_material_texture(const render_scene *tables, const stilb_scene *scene, uint32_t id)
{
	uint32_t texture = scene->materials[id].diffuse_texture;
	STILB_ASSERT(texture <= scene->texture_count);
	return texture ? tables->textures[texture - 1].texture : (stilb_render_texture){0};
}

/* The surface of a material; NULL: it has none. */
static const stilb_scene_surface *shown_material_surface(const stilb_scene *scene, uint32_t id)
{
	uint32_t surface = scene->materials[id].surface;
	STILB_ASSERT(surface <= scene->surface_count);
	return surface ? &scene->surfaces[surface - 1] : NULL;
}

/* The surface as the device has it; a map or function that the device does not take is left out. */
static render_maps shown_maps(const stilb_render *render, const render_scene *tables, const stilb_scene *scene,
                              const stilb_scene_surface *surface)
{
	uint32_t normals = surface->maps[STILB_SCENE_MAP_NORMAL].texture;
	uint32_t coat = surface->maps[STILB_SCENE_MAP_CLEARCOAT_NORMAL].texture;
	render_maps maps = render_maps_make(surface, normals ? scene->textures[normals - 1].channels : 0,
	                                    coat ? scene->textures[coat - 1].channels : 0);
	for (uint32_t i = 0; i < RENDER_MAPS; i++) {
		uint32_t texture = surface->maps[i].texture;
		STILB_ASSERT(texture <= scene->texture_count);
		maps.textures[i] = texture ? tables->textures[texture - 1].texture.id : 0;
		if (maps.textures[i] == 0)
			maps.bits &= ~(uint64_t)(i == STILB_SCENE_MAP_NORMAL ? 1u << i | RENDER_MAPS_TWO : 1u << i);
	}
	if (maps.bits >> STILB_SCENE_MAP_NORMAL & 1u && tables->textures[normals - 1].kind != RENDER_MIPS_MEANS)
		maps.bits |= RENDER_MAPS_SPREAD;
	if (maps.bits >> STILB_SCENE_MAP_CLEARCOAT_NORMAL & 1u && tables->textures[coat - 1].kind != RENDER_MIPS_MEANS)
		maps.bits |= RENDER_MAPS_COAT_SPREAD;
	render_function_name(render, surface->function ? tables->functions[surface->function - 1].index : 0, &maps);
	return maps;
}

/* Creates or writes a material with this surface. */
static stilb_result shown_material_maps(stilb_render *render, const render_scene *tables, const stilb_scene *scene,
                                        uint32_t id, const stilb_scene_surface *surface)
{
	stilb_render_material *material = &tables->materials[id];
	render_maps maps = shown_maps(render, tables, scene, surface);
	return material->id
	           ? render_material_write_maps(render, *material, &scene->materials[id], (stilb_render_texture){0}, &maps)
	           : render_material_create_maps(render, &scene->materials[id], &maps, material);
}

stilb_result render_scene_material(stilb_render *render, render_scene *tables, const stilb_scene *scene, uint32_t id)
{
	stilb_render_material *material = &tables->materials[id];
	const stilb_scene_surface *surface = shown_material_surface(scene, id);
	bool is_new = material->id == 0;
	stilb_render_texture texture = shown_material_texture(tables, scene, id);
	stilb_result result = surface  ? shown_material_maps(render, tables, scene, id, surface)
	                      : is_new ? stilb_render_material_create(render, &scene->materials[id], texture, material)
	                               : render_material_write(render, *material, &scene->materials[id], texture);
	if (result == STILB_OK && is_new)
		render_material_name(render, *material, id);
	return result;
}

/* The image cannot be drawn: names it, and remembers that it was told. */
static stilb_result shown_texture_refuse(render_scene *tables, const stilb_image *image, uint32_t id)
{
	char reason[400];
	snprintf(reason, sizeof reason, "%s", stilb_error_message());
	tables->textures[id].refused = *image;
	tables->refused = true;
	return stilb_fail(STILB_ERROR_ARGUMENT, "texture %u of the scene: %s", id, reason);
}

/* Writes into the texture if it has the image's size and format, else replaces it; an image without pixels is no
 * texture. *replaced: the materials that name it must be written again. On failure the one before stays; an image that
 * the device does not take fails once. */
static stilb_result shown_texture_set(stilb_render *render, render_scene *tables, const stilb_scene *scene, uint32_t id,
                                      render_texture_way way, bool *replaced)
{
	const stilb_image *image = &scene->textures[id];
	render_scene_texture *now = &tables->textures[id], next = {.width = image->width, .height = image->height};
	stilb_result result = STILB_OK;
	render_mips_kind kind = shown_texture_kind(render, now, image);
	next.format = image->format;
	next.levels = stilb_image_level_count(image);
	*replaced = false;
	if (image->pixels && image->pixels == now->refused.pixels && image->width == now->refused.width &&
	    image->height == now->refused.height)
		return STILB_OK;
	bool loads = now->loading != RENDER_LOADING_DONE;
	if (image->pixels && (way.later || loads)) {
		*replaced = true;
		now->kind = kind;
		result = render_loading_begin(render, tables, image, id);
		return result == STILB_ERROR_ARGUMENT ? shown_texture_refuse(tables, image, id) : result;
	}
	if (now->texture.id && !loads && image->pixels && now->width == next.width && now->height == next.height &&
	    now->format == next.format && now->levels == next.levels && (now->mips || !now->mapped) && now->kind == kind)
		return render_texture_write(render, now->texture, image, kind);
	way.mips = next.mips = next.mapped = now->mapped;
	way.kind = next.kind = kind;
	next.as_normals = now->as_normals;
	next.as_other = now->as_other;
	if (image->pixels)
		result = render_texture_create(render, image, way, &next.texture);
	if (result == STILB_ERROR_ARGUMENT)
		return shown_texture_refuse(tables, image, id);
	if (result != STILB_OK)
		return result;
	render_loading_cancel(render, tables, id);
	stilb_render_texture_destroy(render, now->texture);
	*now = next;
	*replaced = true;
	return STILB_OK;
}

stilb_result render_scene_texture_patient(stilb_render *render, render_scene *tables, const stilb_scene *scene,
                                          uint32_t id)
{
	bool replaced, later = render_textures_mode(render) != STILB_RENDER_TEXTURES_AT_ONCE;
	return shown_texture_set(render, tables, scene, id, (render_texture_way){.patient = true, .later = later},
	                         &replaced);
}

/* Replaces a function; one without code is none. On failure there is none, either; one that the device does not take
 * fails once. */
stilb_result render_scene_function(stilb_render *render, render_scene *tables, const stilb_scene *scene, uint32_t id)
{
	render_scene_function_entry *now = &tables->functions[id];
	const stilb_scene_function *function = &scene->functions[id];
	uint64_t hash = function->codes[0].words ? render_function_hash(function) : 0;
	if (hash == now->hash)
		return STILB_OK;
	render_function_destroy(render, now->index);
	*now = (render_scene_function_entry){.hash = hash};
	return hash ? render_function_create(render, function, &now->index) : STILB_OK;
}

stilb_result render_scene_impostors(stilb_render *render, render_scene *tables, const stilb_scene *scene)
{
	if (tables->impostors_removed != scene->impostors_removed) {
		for (uint32_t i = 0; i < tables->impostor_count; i++)
			stilb_render_impostor_destroy(render, tables->impostors[i]);
		tables->impostor_count = 0;
		tables->impostors_removed = scene->impostors_removed;
	}
	if (!render_reserve((void **)&tables->impostors, &tables->impostor_capacity, scene->impostor_count,
	                    sizeof *tables->impostors))
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the scene's impostors");
	stilb_result result = STILB_OK;
	while (tables->impostor_count < scene->impostor_count && result == STILB_OK) {
		uint32_t i = tables->impostor_count;
		tables->impostors[i] = (stilb_render_impostor){0};
		result = stilb_render_impostor_create(render, &scene->impostors[i], &tables->impostors[i]);
		tables->impostor_count += result == STILB_OK;
	}
	for (uint32_t i = 0; i < tables->impostor_count; i++) {
		render_mesh_name(render, tables->impostors[i].mesh, scene->mesh_count + i);
		render_material_name(render, tables->impostors[i].material, scene->material_count + i);
	}
	return result;
}

/* ---- the whole scene --------------------------------------------------------------------------------------------- */

stilb_result render_scene_check_parts(const stilb_scene *scene, const render_scene *tables)
{
	for (uint32_t p = 0; p < scene->part_count; p++)
		if (scene->part_mesh[p] != STILB_SCENE_NONE && !tables->meshes[scene->part_mesh[p]].id)
			return stilb_fail(STILB_ERROR_ARGUMENT, "part %u of the scene is mesh %u, which has no vertices", p,
			                  scene->part_mesh[p]);
	return STILB_OK;
}

static stilb_result shown_fill(stilb_render *render, const stilb_scene *scene, render_scene *tables)
{
	bool replaced, later = render_textures_mode(render) != STILB_RENDER_TEXTURES_AT_ONCE;
	render_texture_way way = {.pool = render->pool, .later = later};
	stilb_result result = render_scene_fit(tables, scene);
	if (result == STILB_OK)
		render_scene_mark(render, tables, scene);
	for (uint32_t i = 0; i < scene->mesh_count && result == STILB_OK; i++)
		result = render_scene_mesh(render, tables, scene, i);
	if (result == STILB_OK)
		result = render_scene_check_parts(scene, tables);
	uint64_t queued = 0;
	for (uint32_t i = 0; i < scene->texture_count && result == STILB_OK; i++) {
		const stilb_image *image = &scene->textures[i];
		result = shown_texture_set(render, tables, scene, i, way, &replaced);
		queued += later ? 0 : stilb_image_levels_size(image);
		if (result == STILB_OK && queued >= RENDER_UPLOAD_QUEUED) {
			result = render_resources_send(render);
			queued = 0;
		}
	}
	if (!later)
		render_resources_expect_no_textures(render);
	for (uint32_t i = 0; i < scene->function_count && result == STILB_OK; i++)
		result = render_scene_function(render, tables, scene, i);
	for (uint32_t i = 0; i < scene->material_count && result == STILB_OK; i++)
		result = render_scene_material(render, tables, scene, i);
	if (result == STILB_OK)
		result = render_scene_impostors(render, tables, scene);
	return result == STILB_OK ? render_places_make(render, tables, scene) : result;
}

stilb_result stilb_render_set_scene(stilb_render *render, const stilb_scene *scene)
{
	STILB_ASSERT_OWNER(render->owner);
	render_scene next = {0};
	stilb_result result = scene ? shown_fill(render, scene, &next) : STILB_OK;
	if (result != STILB_OK) {
		render_scene_destroy(render, &next);
		return result;
	}
	render_scene_replace(render, &next);
	return STILB_OK;
}

void stilb_render_forget_levels(stilb_render *render)
{
	STILB_ASSERT_OWNER(render->owner);
	for (render_pass_lists *lists = render->passes; lists < render->passes + STILB_RENDER_MAX_PASSES; lists++) {
		if (lists->impostor_capacity > 0)
			memset(lists->impostors, 0, lists->impostor_capacity);
		if (lists->history_capacity > 0)
			memset(lists->history, 0, lists->history_capacity * sizeof *lists->history);
	}
}

void render_scene_replace(stilb_render *render, render_scene *next)
{
	render_places_finish(render, &render->scene.places, true);
	render_scene_destroy(render, &render->scene);
	stilb_render_forget_levels(render);
	for (uint32_t p = 0; p < STILB_RENDER_MAX_PASSES; p++)
		render_combined_renew(&render->passes[p].combined);
	render_panorama_renew(&render->panorama);
	render->scene = *next;
}

/* ---- what has changed in it -------------------------------------------------------------------------------------- */

/* True if the material shows a texture that has arrived. */
static bool shown_material_awaits(const render_scene *tables, const stilb_scene *scene, uint32_t id)
{
	const stilb_scene_surface *surface = shown_material_surface(scene, id);
	uint32_t texture = scene->materials[id].diffuse_texture;
	bool awaits = texture && tables->textures[texture - 1].arrived;
	for (uint32_t i = 0; surface && i < RENDER_MAPS; i++)
		awaits |= surface->maps[i].texture && tables->textures[surface->maps[i].texture - 1].arrived;
	return awaits;
}

/* Textures that are on their way go on; materials show those that have arrived. */
static stilb_result shown_load(stilb_render *render, const stilb_scene *scene)
{
	render_scene *tables = &render->scene;
	uint32_t arrived;
	stilb_result loaded = render_loading_advance(render, tables, &arrived), result = STILB_OK;
	for (uint32_t m = 0; m < scene->material_count && arrived > 0 && result == STILB_OK; m++)
		if (shown_material_awaits(tables, scene, m))
			result = render_scene_material(render, tables, scene, m);
	for (uint32_t t = 0; t < tables->texture_count && arrived > 0 && result == STILB_OK; t++)
		tables->textures[t].arrived = false;
	return result == STILB_OK ? loaded : result;
}

/* True if the material shows the texture. */
static bool shown_material_names(const stilb_scene *scene, uint32_t id, uint32_t texture)
{
	const stilb_scene_surface *surface = shown_material_surface(scene, id);
	bool names = scene->materials[id].diffuse_texture == texture + 1;
	for (uint32_t i = 0; surface && i < RENDER_MAPS; i++)
		names |= surface->maps[i].texture == texture + 1;
	return names;
}

/* Brings a texture up to date, and the materials that show it if there is another one in its place. */
static stilb_result shown_update_texture(stilb_render *render, const stilb_scene *scene, uint32_t texture)
{
	render_scene *tables = &render->scene;
	bool replaced;
	stilb_result result =
		shown_texture_set(render, tables, scene, texture, (render_texture_way){.pool = render->pool}, &replaced);
	for (uint32_t m = 0; replaced && m < scene->material_count && result == STILB_OK; m++)
		if (shown_material_names(scene, m, texture))
			result = render_scene_material(render, tables, scene, m);
	return result;
}

/* Gives the textures that a changed material's surface names mips, if they have none or other ones; all are marked. */
static stilb_result shown_update_mips(stilb_render *render, const stilb_scene *scene, uint32_t material)
{
	render_scene *tables = &render->scene;
	const stilb_scene_surface *surface = shown_material_surface(scene, material);
	stilb_result result = STILB_OK;
	for (uint32_t i = 0; surface && i < RENDER_MAPS && result == STILB_OK; i++) {
		uint32_t texture = surface->maps[i].texture;
		if (texture == 0 || !tables->textures[texture - 1].texture.id)
			continue;
		const render_scene_texture *named = &tables->textures[texture - 1];
		if (!named->mips || named->kind != shown_texture_kind(render, named, &scene->textures[texture - 1]))
			result = shown_update_texture(render, scene, texture - 1);
	}
	return result;
}

/* Textures come before the materials that name them. One that the device does not take is an error when the others are
 * done. */
static stilb_result shown_update_textures(stilb_render *render, const stilb_scene *scene,
                                          const stilb_scene_changes *changes)
{
	stilb_result result = STILB_OK, refused = STILB_OK;
	for (uint32_t i = 0; i < changes->texture_count && result == STILB_OK; i++) {
		result = shown_update_texture(render, scene, changes->textures[i]);
		if (result == STILB_ERROR_ARGUMENT) {
			refused = result;
			result = STILB_OK;
		}
	}
	return result == STILB_OK ? refused : result;
}

/* Likewise functions. */
static stilb_result shown_update_functions(stilb_render *render, const stilb_scene *scene,
                                           const stilb_scene_changes *changes)
{
	stilb_result result = STILB_OK, refused = STILB_OK;
	for (uint32_t i = 0; i < changes->function_count && result == STILB_OK; i++) {
		result = render_scene_function(render, &render->scene, scene, changes->functions[i]);
		if (result == STILB_ERROR_ARGUMENT) {
			refused = result;
			result = STILB_OK;
		}
	}
	return result == STILB_OK ? refused : result;
}

static stilb_result shown_update_meshes(stilb_render *render, const stilb_scene *scene,
                                        const stilb_scene_changes *changes)
{
	stilb_result result = STILB_OK;
	for (uint32_t i = 0; i < changes->mesh_count && result == STILB_OK; i++)
		result = render_scene_mesh(render, &render->scene, scene, changes->meshes[i]);
	for (uint32_t i = 0; i < changes->vertices_count && result == STILB_OK; i++) {
		stilb_scene_vertices range = changes->vertices[i];
		const stilb_scene_mesh *mesh = &scene->meshes[range.mesh];
		result = render_mesh_write(render, render->scene.meshes[range.mesh], range.first, range.count,
		                           mesh->vertices + range.first, range.extras ? mesh->extras + range.first : NULL);
	}
	return result;
}

/* Marks the textures of changed materials, so that those that are new are made once, with mips. */
static void shown_mark_changed(render_scene *tables, const stilb_scene *scene, const stilb_scene_changes *changes)
{
	for (uint32_t i = 0; i < changes->material_count; i++) {
		const stilb_scene_surface *surface = shown_material_surface(scene, changes->materials[i]);
		if (surface)
			shown_mark_textures(tables, surface);
	}
}

/* From now on another image may lie where a refused one lay. */
static void shown_forget_refused(render_scene *tables)
{
	for (uint32_t t = 0; t < tables->texture_count; t++)
		tables->textures[t].refused = (stilb_image){0};
	tables->refused = false;
}

stilb_result stilb_render_update_scene(stilb_render *render, const stilb_scene *scene,
                                       const stilb_scene_changes *changes)
{
	STILB_ASSERT_OWNER(render->owner);
	STILB_ASSERT(scene && changes);
	stilb_result result = render_scene_fit(&render->scene, scene);
	if (result == STILB_OK)
		shown_mark_changed(&render->scene, scene, changes);
	if (result == STILB_OK)
		result = shown_update_meshes(render, scene, changes);
	stilb_result textures = result == STILB_OK ? shown_update_textures(render, scene, changes) : result;
	result = textures == STILB_ERROR_ARGUMENT ? STILB_OK : textures;
	stilb_result functions = result == STILB_OK ? shown_update_functions(render, scene, changes) : result;
	result = functions == STILB_ERROR_ARGUMENT ? STILB_OK : functions;
	for (uint32_t i = 0; i < changes->material_count && result == STILB_OK; i++)
		result = shown_update_mips(render, scene, changes->materials[i]);
	for (uint32_t i = 0; i < changes->material_count && result == STILB_OK; i++)
		result = render_scene_material(render, &render->scene, scene, changes->materials[i]);
	if (result == STILB_OK)
		result = render_scene_impostors(render, &render->scene, scene);
	if (result == STILB_OK)
		result = render_places_note(&render->scene.places, scene);
	result = result == STILB_OK ? textures : result;
	result = result == STILB_OK ? functions : result;
	if (result == STILB_OK && render->scene.refused)
		shown_forget_refused(&render->scene);
	return result == STILB_OK ? shown_load(render, scene) : result;
}

stilb_render_mesh stilb_render_scene_mesh(const stilb_render *render, uint32_t id)
{
	STILB_ASSERT(id < render->scene.mesh_count);
	return render->scene.meshes[id];
}

stilb_render_material stilb_render_scene_material(const stilb_render *render, uint32_t id)
{
	STILB_ASSERT(id < render->scene.material_count);
	return render->scene.materials[id];
}
