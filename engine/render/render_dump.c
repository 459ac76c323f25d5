/* Playing a dump: its resources, its recording, its replay, through the public calls of render.h. */
#include "render/render_dump_format.h"
#include "render/render_internal.h"

#include "profiler/prof.h"

#include <stdlib.h>
#include <string.h>

stilb_render_dump_info stilb_render_dump_info_get(const stilb_render_dump *dump)
{
	STILB_ASSERT(dump);
	const render_dump_header *header = dump->header;
	bool morph = false;
	for (uint32_t m = 0; m < header->meshes; m++)
		morph |= (dump->meshes[m].levels & RENDER_DUMP_MORPHS) != 0;
	return (stilb_render_dump_info){
		.morph = morph,
		.stream_hash = header->stream_hash,
		.draws = header->draws,
		.passes = header->passes,
		.meshes = header->meshes,
		.materials = header->materials,
		.textures = header->textures,
		.width = header->width,
		.height = header->height,
		.samples = header->samples,
		.output = (stilb_render_output)header->output,
	};
}

/* ---- resources ------------------------------------------------------------------------------------------------------
 * A new renderer gives out ids in ascending order. For each id that the file leaves out, because no draw uses it, the
 * smallest possible resource is created, so that the others get the ids of the file. */

static stilb_result upload_texture(stilb_render *render, const render_dump_texture *texture, const uint8_t *pixels,
                                   render_texture_way way, stilb_render_texture *out)
{
	stilb_image_format format = (stilb_image_format)texture->format;
	stilb_image image = {texture->width, texture->height, 4, format, (void *)pixels, 0};
	uint32_t channels = stilb_image_format_channels(format);
	image.channels = channels > 0 ? channels : 4;
	image = stilb_image_view_levels(&image, texture->levels);
	return render_texture_create(render, &image, way, out);
}

static stilb_result upload_textures(const stilb_render_dump *dump, stilb_render *render, stilb_render_texture *textures)
{
	static const uint8_t white[4] = {255, 255, 255, 255};
	render_dump_texture none = {.width = 1, .height = 1, .format = STILB_IMAGE_U8_SRGB, .levels = 1};
	const uint8_t *pixels = dump->pixels;
	uint32_t next = 1;
	stilb_result result = STILB_OK;
	for (uint32_t t = 0; t < dump->header->textures && result == STILB_OK; t++) {
		const render_dump_texture *texture = &dump->textures[t];
		for (; next < texture->id && result == STILB_OK; next++)
			result = upload_texture(render, &none, white, (render_texture_way){0}, &textures[t]);
		if (result == STILB_OK)
			result = upload_texture(render, texture, pixels, render_dump_texture_way(dump, t), &textures[t]);
		STILB_ASSERT(result != STILB_OK || ((textures[t].id & RENDER_INDEX_MASK) == texture->id && "a new renderer"));
		next++;
		pixels += render_dump_fill(render_dump_pixel_bytes(texture));
	}
	return result;
}

static stilb_result upload_materials(const stilb_render_dump *dump, stilb_render *render,
                                     const stilb_render_texture *textures, const uint32_t *functions,
                                     stilb_render_material *materials)
{
	stilb_scene_material none = {.roughness = 1.0f};
	stilb_render_texture no_texture = {0};
	uint32_t next = 0;
	stilb_result result = STILB_OK;
	for (uint32_t m = 0; m < dump->header->materials && result == STILB_OK; m++) {
		const render_dump_material *from = &dump->materials[m];
		for (; next < from->id && result == STILB_OK; next++)
			result = stilb_render_material_create(render, &none, no_texture, &materials[m]);
		stilb_scene_material material = {
			.roughness = from->roughness, .anisotropy = from->anisotropy, .wrap = from->wrap};
		memcpy(material.diffuse, from->diffuse, sizeof material.diffuse);
		memcpy(material.specular, from->specular, sizeof material.specular);
		memcpy(material.emission, from->emission, sizeof material.emission);
		stilb_render_texture texture = from->texture ? textures[from->texture - 1] : no_texture;
		render_maps maps;
		if (from->surface)
			maps = render_dump_surface_get(render, &dump->surfaces[from->surface - 1], textures, functions);
		if (result == STILB_OK && from->surface)
			result = render_material_create_maps(render, &material, &maps, &materials[m]);
		else if (result == STILB_OK && from->impostor)
			result = render_material_create_impostor(render, &material, texture, &materials[m]);
		else if (result == STILB_OK)
			result = stilb_render_material_create(render, &material, texture, &materials[m]);
		STILB_ASSERT(result != STILB_OK || ((materials[m].id & RENDER_INDEX_MASK) == from->id && "a new renderer"));
		next++;
	}
	return result;
}

/* The casts drop const only because the scene's struct has no const pointers: the mesh is read, not written. */
static stilb_result upload_mesh(stilb_render *render, const render_dump_mesh *from, const render_dump_level *levels,
                                const stilb_scene_vertex *vertices, const render_extra *extras, const uint32_t *indices,
                                stilb_render_mesh *out)
{
	stilb_scene_level level[STILB_SCENE_MAX_LEVELS];
	/* The file does not say which clusters there are: one of the mesh itself, and one of all their coarser versions. */
	bool coarser = from->clusters > 0;
	stilb_scene_cluster clusters[2] = {{.index_count = from->indices, .from = STILB_SCENE_NONE},
	                                   {.index_count = from->clusters, .from = 0}};
	stilb_scene_cluster_group groups[2] = {{.error = coarser ? 0.0f : INFINITY, .cluster_count = 1},
	                                       {.error = INFINITY, .first_cluster = 1, .cluster_count = 1}};
	stilb_scene_mesh mesh = {.vertices = (stilb_scene_vertex *)vertices,
	                         .indices = (uint32_t *)indices,
	                         .vertex_count = from->vertices,
	                         .index_count = from->indices,
	                         .level_count = render_dump_mesh_levels(from),
	                         .levels = level,
	                         .level_indices = (uint32_t *)indices + from->indices};
	if (from->levels & RENDER_DUMP_MORPHS)
		mesh.morph = mesh.vertices + from->vertices;
	STILB_ASSERT(mesh.level_count == 0 || levels);
	for (uint32_t l = 0; l < mesh.level_count; l++) {
		level[l] = (stilb_scene_level){mesh.level_index_count, levels[l].indices, levels[l].vertices, levels[l].error};
		mesh.level_index_count += levels[l].indices;
	}
	if (from->levels & RENDER_DUMP_CLUSTERS) {
		mesh.cluster_count = mesh.group_count = coarser ? 2 : 1;
		mesh.clusters = clusters;
		mesh.groups = groups;
		mesh.cluster_indices = mesh.level_indices + mesh.level_index_count;
		mesh.cluster_index_count = from->clusters;
	}
	if (from->extras)
		mesh.extras = stilb_memory_alloc(from->vertices, sizeof *mesh.extras);
	if (from->extras && !mesh.extras)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the extras of %u vertices", from->vertices);
	if (mesh.extras)
		render_extras_unpack(extras, from->vertices, mesh.extras);
	stilb_result result = stilb_render_mesh_create(render, &mesh, out);
	free(mesh.extras);
	return result;
}

static stilb_result upload_meshes(const stilb_render_dump *dump, stilb_render *render, stilb_render_mesh *meshes)
{
	static const stilb_scene_vertex no_vertex[1];
	static const uint32_t zero[1];
	static const render_dump_mesh none = {.vertices = 1, .indices = 1};
	const stilb_scene_vertex *vertices = dump->vertices;
	const render_dump_level *levels = dump->levels;
	const uint32_t *indices = dump->indices;
	const render_extra *extras = dump->extras;
	uint32_t next = 0;
	stilb_result result = STILB_OK;
	for (uint32_t m = 0; m < dump->header->meshes && result == STILB_OK; m++) {
		const render_dump_mesh *mesh = &dump->meshes[m];
		for (; next < mesh->id && result == STILB_OK; next++)
			result = upload_mesh(render, &none, NULL, no_vertex, NULL, zero, &meshes[m]);
		if (result == STILB_OK)
			result = upload_mesh(render, mesh, levels, vertices, extras, indices, &meshes[m]);
		STILB_ASSERT(result != STILB_OK || ((meshes[m].id & RENDER_INDEX_MASK) == mesh->id && "a new renderer"));
		next++;
		vertices += mesh->vertices * (mesh->levels & RENDER_DUMP_MORPHS ? (size_t)2 : 1);
		extras += mesh->extras ? mesh->vertices : 0;
		indices += mesh->indices;
		for (uint32_t l = 0; l < render_dump_mesh_levels(mesh); l++)
			indices += levels++->indices;
		indices += mesh->clusters;
	}
	return result;
}

/* ---- tables ------------------------------------------------------------------------------------------------------ */

static stilb_render_shading upload_shading(const render_dump_view *from)
{
	return (stilb_render_shading){
		.brdf = from->brdf,
		.ndf = from->ndf,
		.g = from->g,
		.f = from->f,
		.roughness = from->roughness,
		.anisotropy = from->anisotropy,
		.wrap = from->wrap,
		.specular = from->specular,
	};
}

/* Where an edge of the file's picture lies in one of another size. */
static uint32_t upload_edge(uint32_t edge, uint32_t from, uint32_t to)
{
	return (uint32_t)(((uint64_t)edge * to + from / 2) / from);
}

/* A target's place, in the file's picture and in one of width x height pixels. */
static void upload_place(const render_dump_header *header, const uint16_t from[4], uint32_t width, uint32_t height,
                         uint16_t to[4])
{
	const uint32_t old[2] = {header->width, header->height}, now[2] = {width, height};
	memset(to, 0, 4 * sizeof *to);
	for (uint32_t axis = 0; axis < 2 && from[2] > 0; axis++) {
		uint32_t begin = upload_edge(from[axis], old[axis], now[axis]);
		uint32_t end = upload_edge((uint32_t)from[axis] + from[2 + axis], old[axis], now[axis]);
		begin = begin < now[axis] ? begin : now[axis] - 1;
		to[axis] = (uint16_t)begin;
		to[2 + axis] = (uint16_t)(end > begin ? end - begin : 1);
	}
}

static void upload_tables(stilb_render_dump *dump, uint32_t width, uint32_t height)
{
	const stilb_scene_light *lights = dump->light_table;
	for (uint32_t i = 0; i < dump->header->lights; i++)
		dump->light_table[i] = render_dump_light_get(&dump->lights[i]);
	for (uint32_t p = 0; p < dump->header->passes; p++) {
		const render_dump_pass *pass = &dump->passes[p];
		dump->pass_table[p] =
			(stilb_render_pass){.name = pass->name, .view = pass->view, .order = pass->order, .sort = pass->sort};
	}
	for (uint32_t t = 0; t < dump->header->targets; t++) {
		const render_dump_target *from = &dump->targets[t];
		stilb_render_target *target = &dump->target_table[t];
		*target = (stilb_render_target){.name = from->name,
		                                .kind = (stilb_render_target_kind)from->kind,
		                                .width = from->width,
		                                .height = from->height,
		                                .output = from->output,
		                                .border = (uint8_t)from->border};
		upload_place(dump->header, from->place, width, height, target->place);
	}
	for (uint32_t v = 0; v < dump->header->views; v++) {
		const render_dump_view *from = &dump->views[v];
		stilb_render_view *view = &dump->view_table[v];
		memcpy(view->view_projection.m, from->view_projection, sizeof from->view_projection);
		memcpy(view->camera_position, from->camera_position, sizeof from->camera_position);
		memcpy(view->surroundings.sky, from->sky, sizeof from->sky);
		memcpy(view->surroundings.ground, from->ground, sizeof from->ground);
		view->surroundings.glossy = from->glossy;
		view->lights = lights;
		view->light_count = from->lights;
		lights += from->lights;
		view->shading = upload_shading(from);
		view->both_sides = from->both_sides;
		view->exposure = from->exposure;
		view->tone = from->tone;
		view->dither = (stilb_render_dither)from->dither;
		view->time = from->time;
		view->lighting = (stilb_render_lighting)(from->lighting & 0xff);
		view->deferred.coverage = (stilb_render_coverage)(from->lighting >> 8 & 0xff);
		view->deferred.gbuffer = (stilb_render_gbuffer)(from->lighting >> 16 & 0xff);
		view->ambient = (stilb_render_ambient)(from->lighting >> 24);
		view->light_tolerance = from->light_tolerance;
		view->light_peak = from->light_peak;
		view->light_fade = from->light_fade;
		view->light_fade_height = from->light_fade_height;
		view->target = from->target > 0 ? &dump->target_table[from->target - 1] : NULL;
		render_dump_backdrop_get(dump, v, view);
	}
	uint32_t draws = 0; /* fits: the header's count is at most UINT32_MAX */
	for (uint32_t s = 0; s <= dump->header->segments; s++) {
		dump->first_draw[s] = draws;
		draws += s < dump->header->segments ? dump->segments[s] : 0;
	}
	STILB_ASSERT(draws == dump->header->draws && "segments hold all draws");
}

static void upload_draws(stilb_render_dump *dump, const stilb_render_mesh *meshes,
                         const stilb_render_material *materials)
{
	for (uint64_t d = 0; d < dump->header->draws; d++) {
		const render_dump_draw *from = &dump->draws[d];
		render_dump_ready *draw = &dump->ready[d];
		*draw = (render_dump_ready){.transform.m[15] = 1.0f,
		                            .key = from->key,
		                            .mesh = meshes[render_dump_draw_mesh(from)],
		                            .material = materials[render_dump_draw_material(from)],
		                            .level = render_dump_draw_level(from),
		                            .detail = from->mesh >> 26,
		                            .kind = from->material >> 24,
		                            .first_index = from->first_index,
		                            .index_count = from->index_count};
		for (int row = 0; row < 3; row++)
			for (int column = 0; column < 4; column++)
				draw->transform.m[4 * column + row] = from->transform[4 * row + column];
	}
}

stilb_result stilb_render_dump_upload(stilb_render_dump *dump, stilb_render *render)
{
	STILB_ASSERT_OWNER(render->owner);
	const render_dump_header *header = dump->header;
	STILB_ASSERT(!stilb_render_dump_info_get(dump).morph || render->resources.morph);
	stilb_render_texture *textures = stilb_memory_alloc(header->textures, sizeof *textures);
	stilb_render_material *materials = stilb_memory_alloc(header->materials, sizeof *materials);
	stilb_render_mesh *meshes = stilb_memory_alloc(header->meshes, sizeof *meshes);
	uint32_t functions[STILB_SCENE_MAX_FUNCTIONS];
	free(dump->ready);
	free(dump->first_draw);
	free(dump->light_table);
	dump->light_table = stilb_memory_alloc(header->lights, sizeof *dump->light_table);
	dump->ready = stilb_memory_alloc(header->draws, sizeof *dump->ready);
	dump->first_draw = stilb_memory_alloc((size_t)header->segments + 1, sizeof *dump->first_draw);
	stilb_result result = STILB_OK;
	if (!textures || !materials || !meshes || !dump->ready || !dump->first_draw || !dump->light_table)
		result =
			stilb_fail(STILB_ERROR_MEMORY, "no memory for the %llu draws of a dump", (unsigned long long)header->draws);
	if (result == STILB_OK)
		result = upload_textures(dump, render, textures);
	if (result == STILB_OK)
		result = render_dump_functions_upload(dump, render, functions);
	if (result == STILB_OK)
		result = upload_materials(dump, render, textures, functions, materials);
	if (result == STILB_OK)
		result = upload_meshes(dump, render, meshes);
	if (result == STILB_OK) {
		upload_tables(dump, render->device->width, render->device->height);
		upload_draws(dump, meshes, materials);
	}
	free(textures);
	free(materials);
	free(meshes);
	return result;
}

/* ---- frames ------------------------------------------------------------------------------------------------------ */

/* A pass that is being recorded: shared by the slices of its loop. */
typedef struct play_pass {
	const stilb_render_dump *dump;
	stilb_render *render;
	uint32_t pass, first_segment; /* the pass's first among the file's segments */
} play_pass;

static void play_slice(uint32_t begin, uint32_t end, uint32_t worker, void *user)
{
	PROFILE("record segments of a dump");
	const play_pass *play = user;
	const stilb_render_dump *dump = play->dump;
	stilb_render_context *context = stilb_render_context_get(play->render, worker);
	for (uint32_t segment = begin; segment < end; segment++) {
		STILB_ASSERT(play->first_segment + segment < dump->header->segments);
		const uint32_t *first = &dump->first_draw[play->first_segment + segment];
		stilb_render_segment_begin(context, play->pass, segment);
		for (const render_dump_ready *draw = dump->ready + first[0]; draw < dump->ready + first[1]; draw++) {
			if (draw->level == RENDER_DUMP_SOME)
				render_draw_clusters(context, draw->key, draw->mesh, draw->material, &draw->transform,
				                     (render_cluster_range){draw->first_index, draw->index_count, 0}, draw->detail,
				                     draw->kind);
			else
				render_draw_level(context, draw->key, draw->mesh, draw->material, &draw->transform, draw->level,
				                  draw->detail, draw->kind);
		}
		stilb_render_segment_end(context);
	}
}

stilb_result stilb_render_dump_record(const stilb_render_dump *dump, stilb_render *render, stilb_job_pool *pool,
                                      uint32_t worker)
{
	STILB_ASSERT(dump->ready && dump->first_draw && "stilb_render_dump_upload has been called");
	play_pass play = {.dump = dump, .render = render};
	stilb_result result = STILB_OK;
	for (uint32_t p = 0; p < dump->header->passes && result == STILB_OK; p++) {
		play.pass = p;
		result = stilb_render_pass_begin(render, p, dump->passes[p].segments);
		if (result != STILB_OK)
			break;
		stilb_job_parallel_for(pool, dump->passes[p].segments, 1, play_slice, &play, worker);
		play.first_segment += dump->passes[p].segments;
		result = stilb_render_pass_end(render, p);
	}
	return result;
}

stilb_result stilb_render_dump_replay(const stilb_render_dump *dump, stilb_render *render, stilb_job_pool *pool,
                                      uint32_t worker)
{
	STILB_ASSERT(dump->ready && "stilb_render_dump_upload has been called");
	return stilb_render_replay(render, dump->pass_table, dump->header->passes, dump->view_table, dump->header->views,
	                           pool, worker);
}
