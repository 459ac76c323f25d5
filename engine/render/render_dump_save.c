/* Writing a dump: first the resources that the draws use are collected, which gives the size; then the bytes are
 * written to memory, and the file from there. */
#include "base/base_file.h"
#include "render/render_clusters.h"
#include "render/render_dump_format.h"
#include "render/render_internal.h"

#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define SAVE_UNUSED UINT32_MAX

/* The resources of one kind that draws use, and their positions in the file's table. */
typedef struct save_table {
	uint32_t *place;   /* [end] by index: the position, or SAVE_UNUSED */
	uint32_t *indices; /* [count] by position, in ascending order of their ids in the file */
	uint32_t end, count;
} save_table;

/* What the file calls a resource: of meshes and materials the name, of textures the index. */
typedef uint32_t save_id_fn(const render_resources *resources, uint32_t index);

typedef struct save_job {
	stilb_render *render;
	const stilb_render_pass *passes;
	const stilb_render_view *views;
	uint32_t pass[STILB_RENDER_MAX_PASSES]; /* [header.passes] indices of the scene passes in `passes` */
	render_dump_header header;
	uint64_t begin[RENDER_DUMP_PARTS + 1];
	uint8_t *bytes;
	save_table meshes, materials, textures;
	render_dump_functions functions;
	render_dump_backdrop backdrops[RENDER_DUMP_MAX_VIEWS];     /* [header.views] */
	const stilb_render_target *targets[RENDER_DUMP_MAX_VIEWS]; /* [header.targets] of the views */
} save_job;

/* ---- draws in recorded order ------------------------------------------------------------------------------------- */

typedef void save_draw_fn(void *user, const render_command *command, const render_row *row, uint64_t state);

static void save_each_draw_of_segment(const stilb_render *render, const render_segment *segment, save_draw_fn *fn,
                                      void *user)
{
	for (uint32_t r = 0; r < segment->run_count; r++) {
		const render_run *run = &segment->context->runs[segment->first_run + r];
		for (uint32_t c = run->first; c < run->first + run->count; c++) {
			const render_command *command = &render_commands(render)[c];
			fn(user, command, render_row_of(render, command), run->state);
		}
	}
}

static void save_each_draw(const save_job *job, save_draw_fn *fn, void *user)
{
	for (uint32_t p = 0; p < job->header.passes; p++) {
		const render_pass_lists *lists = &job->render->passes[job->pass[p]];
		for (uint32_t s = 0; s < lists->segment_count; s++)
			save_each_draw_of_segment(job->render, &lists->segments[s], fn, user);
	}
}

static uint32_t save_segment_draws(const render_segment *segment)
{
	uint32_t draws = 0;
	for (uint32_t r = 0; r < segment->run_count; r++)
		draws += segment->context->runs[segment->first_run + r].count;
	return draws;
}

/* ---- resources of the draws -------------------------------------------------------------------------------------- */

/* Number of draws, and one more than their highest ids. */
typedef struct save_most {
	uint32_t mesh, material;
	uint64_t draws;
} save_most;

static void save_find_most(void *user, const render_command *command, const render_row *row, uint64_t state)
{
	(void)state;
	save_most *most = user;
	most->mesh = row->mesh >= most->mesh ? row->mesh + 1 : most->mesh;
	most->material = command->material >= most->material ? command->material + 1 : most->material;
	most->draws++;
}

static void save_mark(void *user, const render_command *command, const render_row *row, uint64_t state)
{
	(void)state;
	save_job *job = user;
	STILB_ASSERT(row->mesh < job->meshes.end && command->material < job->materials.end);
	job->meshes.place[row->mesh] = 0;
	job->materials.place[command->material] = 0;
}

static bool save_table_create(save_table *table, uint32_t end)
{
	table->end = end;
	table->place = malloc((end ? end : 1) * sizeof *table->place);
	table->indices = calloc(end ? end : 1, sizeof *table->indices);
	if (table->place)
		memset(table->place, 0xff, end * sizeof *table->place);
	return table->place && table->indices;
}

static uint32_t save_mesh_id(const render_resources *resources, uint32_t index)
{
	return resources->meshes[index].name;
}

static uint32_t save_material_id(const render_resources *resources, uint32_t index)
{
	STILB_ASSERT_LOCKED(&resources->lock);
	return ((const render_material *)resources->heaps[RENDER_HEAP_MATERIALS].data)[index].name;
}

static uint32_t save_texture_id(const render_resources *resources, uint32_t index)
{
	(void)resources;
	return index;
}

/* Gives every resource that save_mark has met its position in the file's table, in ascending order of ids.
 * STILB_ERROR_ARGUMENT: two have the same id. */
static stilb_result save_table_close(const save_job *job, save_table *table, save_id_fn *id_of)
{
	const render_resources *resources = &job->render->resources;
	uint32_t end = 0;
	for (uint32_t i = 0; i < table->end; i++)
		if (table->place[i] != SAVE_UNUSED && id_of(resources, i) >= end)
			end = id_of(resources, i) + 1;
	uint32_t *with_id = calloc((size_t)end + 1, sizeof *with_id); /* 1 + the index; 0: none */
	if (!with_id)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for what a frame's draws use");
	bool unique = true;
	for (uint32_t i = 0; i < table->end; i++)
		if (table->place[i] != SAVE_UNUSED) {
			uint32_t *entry = &with_id[id_of(resources, i)];
			unique = unique && !*entry;
			*entry = i + 1;
		}
	for (uint32_t id = 0; id < end; id++)
		if (with_id[id]) {
			table->indices[table->count] = with_id[id] - 1;
			table->place[with_id[id] - 1] = table->count++;
		}
	free(with_id);
	return unique
	           ? STILB_OK
	           : stilb_fail(STILB_ERROR_ARGUMENT, "cannot dump a frame that draws a scene's meshes or materials and, "
	                                              "by hand, others with the same ids");
}

static void save_table_finish(save_table *table)
{
	free(table->place);
	free(table->indices);
}

/* Index of a material's texture; 0: none. */
static uint32_t save_texture_of(const save_job *job, uint32_t material)
{
	return render_state_texture(job->render->resources.materials[material] & RENDER_INDEX_MASK);
}

/* Puts what the draws use in order. Under the lock of resources. */
static stilb_result save_order_used(save_job *job)
{
	stilb_result result = save_table_close(job, &job->meshes, save_mesh_id);
	if (result == STILB_OK)
		result = save_table_close(job, &job->materials, save_material_id);
	for (uint32_t m = 0; m < job->materials.count && result == STILB_OK; m++) {
		uint32_t material = job->materials.indices[m], texture = save_texture_of(job, material), maps[RENDER_MAPS];
		job->header.surfaces += render_dump_surface_textures(&job->render->resources, material, maps);
		render_dump_functions_note(job->render, material, &job->functions);
		if (texture != 0)
			job->textures.place[texture] = 0;
		for (uint32_t i = 0; i < RENDER_MAPS; i++)
			if (maps[i] != 0)
				job->textures.place[maps[i]] = 0;
	}
	return result == STILB_OK ? save_table_close(job, &job->textures, save_texture_id) : result;
}

static stilb_result save_find_used(save_job *job)
{
	save_most most = {0};
	save_each_draw(job, save_find_most, &most);
	job->header.draws = most.draws;
	if (!save_table_create(&job->meshes, most.mesh) || !save_table_create(&job->materials, most.material) ||
	    !save_table_create(&job->textures, STILB_RENDER_MAX_TEXTURES))
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for what a frame's draws use");
	save_each_draw(job, save_mark, job);
	return STILB_OK;
}

/* ---- sizes ------------------------------------------------------------------------------------------------------- */

/* The entry of the file's table of textures; its width is 0 if the pixels were not kept. */
static render_dump_texture save_texture(const save_job *job, uint32_t place)
{
	STILB_ASSERT_LOCKED(&job->render->resources.lock);
	STILB_ASSERT(place < job->textures.count);
	uint32_t id = job->textures.indices[place];
	const render_pixels *pictures = job->render->resources.pictures;
	render_pixels pixels = pictures ? pictures[id] : (render_pixels){0};
	return (render_dump_texture){.id = id,
	                             .width = pixels.image.width,
	                             .height = pixels.image.height,
	                             .format = pixels.image.format,
	                             .levels = pixels.given};
}

/* How many indices the coarser versions of a mesh's clusters have. */
static uint32_t save_cluster_indices(const render_levels *levels)
{
	return render_levels_have_clusters(levels) ? levels->indices[0].count - levels->clusters->coarser : 0;
}

/* Fills in the counts in the header, and job->begin: the parts' offsets from the beginning of the file. */
static stilb_result save_size(save_job *job)
{
	STILB_ASSERT_LOCKED(&job->render->resources.lock);
	render_dump_header *header = &job->header;
	header->meshes = job->meshes.count;
	header->materials = job->materials.count;
	header->textures = job->textures.count;
	header->functions = job->functions.count;
	header->function_bytes = job->functions.bytes;
	for (uint32_t v = 0; v < header->views; v++)
		header->lights += job->views[v].light_count;
	for (uint32_t p = 0; p < header->passes; p++)
		header->segments += job->render->passes[job->pass[p]].segment_count;
	for (uint32_t m = 0; m < header->meshes; m++) {
		const render_mesh_slot *slot = &job->render->resources.meshes[job->meshes.indices[m]];
		const render_levels *levels = job->render->resources.levels[job->meshes.indices[m]];
		header->vertices += levels && levels->morphs ? 2 * (uint64_t)slot->vertex_count : slot->vertex_count;
		header->extras += slot->flags & RENDER_MESH_EXTRAS ? slot->vertex_count : 0;
		header->indices += slot->index_count;
		header->levels += levels ? levels->count : 0;
		header->indices += save_cluster_indices(levels);
		for (uint32_t l = 1; levels && l <= levels->count; l++)
			header->indices += render_levels_level(levels)[l].index_count;
	}
	for (uint32_t t = 0; t < header->textures; t++) {
		render_dump_texture texture = save_texture(job, t);
		if (texture.width == 0)
			return stilb_fail(STILB_ERROR_ARGUMENT,
			                  "cannot dump a frame that uses texture %u: its pixels were not kept; create the renderer "
			                  "or the engine with keep_textures",
			                  texture.id);
		header->pixel_bytes += render_dump_fill(render_dump_pixel_bytes(&texture));
	}
	render_dump_layout(header, job->begin); /* cannot overflow: all of it is in memory */
	header->file_size = job->begin[RENDER_DUMP_PARTS];
	STILB_ASSERT(header->file_size > sizeof *header);
	return STILB_OK;
}

/* ---- parts ------------------------------------------------------------------------------------------------------- */

static void *save_part(const save_job *job, render_dump_part part)
{
	STILB_ASSERT(job->bytes && job->begin[part] < job->header.file_size);
	return job->bytes + job->begin[part];
}

static void save_put_shading(render_dump_view *out, const stilb_render_shading *shading)
{
	out->brdf = shading->brdf;
	out->ndf = shading->ndf;
	out->g = shading->g;
	out->f = shading->f;
	out->roughness = shading->roughness;
	out->anisotropy = shading->anisotropy;
	out->wrap = shading->wrap;
	out->specular = shading->specular;
}

/* Position of a target among those that are saved, their number if it is not: of views that no pass shows. */
static uint32_t save_target(const save_job *job, const stilb_render_target *target)
{
	uint32_t t = 0;
	while (t < job->header.targets && job->targets[t] != target)
		t++;
	return t;
}

/* Finds the targets of the passes, each once. */
static void save_find_targets(save_job *job)
{
	for (uint32_t p = 0; p < job->header.passes; p++) {
		const stilb_render_target *target = job->views[job->passes[job->pass[p]].view].target;
		if (target && save_target(job, target) == job->header.targets)
			job->targets[job->header.targets++] = target;
	}
}

static void save_put_views(const save_job *job)
{
	render_dump_view *out = save_part(job, RENDER_DUMP_VIEWS);
	for (uint32_t v = 0; v < job->header.views; v++, out++) {
		const stilb_render_view *view = &job->views[v];
		memcpy(out->view_projection, view->view_projection.m, sizeof out->view_projection);
		memcpy(out->camera_position, view->camera_position, sizeof out->camera_position);
		memcpy(out->sky, view->surroundings.sky, sizeof out->sky);
		memcpy(out->ground, view->surroundings.ground, sizeof out->ground);
		out->glossy = view->surroundings.glossy;
		out->lights = view->light_count;
		out->both_sides = view->both_sides;
		out->exposure = view->exposure;
		out->tone = view->tone;
		out->dither = view->dither;
		out->time = view->time;
		out->lighting = (uint32_t)view->lighting | (uint32_t)view->deferred.coverage << 8 |
		                (uint32_t)view->deferred.gbuffer << 16 | (uint32_t)view->ambient << 24;
		out->light_tolerance = view->light_tolerance;
		out->light_peak = view->light_tolerance > 0.0f ? view->light_peak : 0.0f;
		out->light_fade = view->light_fade;
		out->light_fade_height = view->light_fade > 0.0f ? render_view_fade_height(job->render, view) : 0;
		uint32_t target = view->target ? save_target(job, view->target) : job->header.targets;
		out->target = target < job->header.targets ? 1 + target : 0;
		save_put_shading(out, &view->shading);
	}
}

static void save_put_targets(const save_job *job)
{
	render_dump_target *out = save_part(job, RENDER_DUMP_TARGETS);
	for (uint32_t t = 0; t < job->header.targets; t++, out++) {
		const stilb_render_target *target = job->targets[t];
		for (size_t c = 0; target->name[c] && c < STILB_RENDER_TARGET_NAME; c++)
			out->name[c] = iscntrl((unsigned char)target->name[c]) ? '?' : target->name[c];
		out->kind = target->kind;
		out->width = target->width;
		out->height = target->height;
		out->output = target->output;
		out->border = target->border;
		if (target->place[2] > 0)
			memcpy(out->place, target->place, sizeof out->place);
	}
}

static void save_put_lights(const save_job *job)
{
	render_dump_light *out = save_part(job, RENDER_DUMP_LIGHTS);
	for (uint32_t v = 0; v < job->header.views; v++)
		for (uint32_t i = 0; i < job->views[v].light_count; i++, out++) {
			const stilb_scene_light *light = &job->views[v].lights[i];
			*out = (render_dump_light){.kind = light->kind,
			                           .unit = light->unit,
			                           .falloff = light->falloff,
			                           .use = light->use,
			                           .cos_inner = light->cos_inner,
			                           .cos_outer = light->cos_outer,
			                           .radius = light->radius,
			                           .reach = light->reach};
			memcpy(out->position, light->position, sizeof out->position);
			memcpy(out->direction, light->direction, sizeof out->direction);
			memcpy(out->intensity, light->intensity, sizeof out->intensity);
			memcpy(out->half_x, light->half_x, sizeof out->half_x);
			memcpy(out->half_y, light->half_y, sizeof out->half_y);
		}
}

static void save_put_passes(const save_job *job)
{
	render_dump_pass *out = save_part(job, RENDER_DUMP_PASSES);
	uint32_t *segment = save_part(job, RENDER_DUMP_SEGMENTS);
	for (uint32_t p = 0; p < job->header.passes; p++, out++) {
		const stilb_render_pass *pass = &job->passes[job->pass[p]];
		const render_pass_lists *lists = &job->render->passes[job->pass[p]];
		for (size_t c = 0; pass->name && pass->name[c] && c < sizeof out->name - 1; c++)
			out->name[c] = iscntrl((unsigned char)pass->name[c]) ? '?' : pass->name[c];
		out->view = pass->view;
		out->order = pass->order;
		out->sort = pass->sort;
		out->segments = lists->segment_count;
		for (uint32_t s = 0; s < lists->segment_count; s++) {
			*segment = save_segment_draws(&lists->segments[s]);
			out->draws += *segment++;
		}
	}
}

static void save_put_textures(const save_job *job)
{
	STILB_ASSERT_LOCKED(&job->render->resources.lock);
	render_dump_texture *out = save_part(job, RENDER_DUMP_TEXTURES);
	uint8_t *pixels = save_part(job, RENDER_DUMP_PIXELS);
	for (uint32_t t = 0; t < job->header.textures; t++, out++) {
		*out = save_texture(job, t);
		uint64_t bytes = render_dump_pixel_bytes(out);
		const render_pixels *from = &job->render->resources.pictures[out->id];
		size_t first = stilb_image_size(&from->image);
		memcpy(pixels, from->image.pixels, first);
		if (bytes > first)
			memcpy(pixels + first, from->mips, bytes - first);
		pixels += render_dump_fill(bytes);
	}
}

static void save_put_materials(const save_job *job)
{
	STILB_ASSERT_LOCKED(&job->render->resources.lock);
	const render_material *heap = (const render_material *)job->render->resources.heaps[RENDER_HEAP_MATERIALS].data;
	render_dump_material *out = save_part(job, RENDER_DUMP_MATERIALS);
	render_dump_surface *surfaces = save_part(job, RENDER_DUMP_SURFACES);
	render_dump_functions_put(job->render, &job->functions, save_part(job, RENDER_DUMP_FUNCTIONS),
	                          save_part(job, RENDER_DUMP_CODE));
	uint32_t made = 0;
	for (uint32_t m = 0; m < job->header.materials; m++, out++) {
		uint32_t index = job->materials.indices[m], texture = save_texture_of(job, index);
		if (job->render->resources.materials[index] & RENDER_STATE_MAPS) {
			render_dump_surface_put(&job->render->resources, index, job->textures.place, job->functions.place,
			                        &surfaces[made]);
			out->surface = ++made;
		}
		out->id = heap[index].name;
		out->texture = texture ? job->textures.place[texture] + 1 : 0;
		out->impostor = (job->render->resources.materials[index] & RENDER_STATE_IMPOSTOR) != 0;
		memcpy(out->diffuse, heap[index].diffuse, sizeof out->diffuse);
		memcpy(out->specular, heap[index].specular, sizeof out->specular);
		out->roughness = heap[index].roughness;
		out->anisotropy = heap[index].anisotropy;
		out->wrap = heap[index].wrap;
		memcpy(out->emission, heap[index].emission, sizeof out->emission);
	}
}

/* Copies a mesh's vertices from the heap; of pairs first all first ones, then all second ones. Returns the end. */
static stilb_scene_vertex *save_put_vertices(const render_resources *resources, stilb_scene_vertex *out,
                                             const render_mesh_slot *slot, bool pairs)
{
	const render_layout *layout = &resources->layout;
	const uint8_t *from =
		resources->heaps[RENDER_HEAP_VERTICES].data + (size_t)(uint32_t)slot->vertex_offset * layout->size;
	size_t count = slot->vertex_count;
	for (size_t v = 0; v < count && pairs; v++, from += (size_t)2 * layout->size) {
		stilb_scene_vertex pair[2];
		render_vertices_unpack(layout, from, 2, true, pair);
		out[v] = pair[0];
		out[count + v] = pair[1];
	}
	if (!pairs)
		render_vertices_unpack(layout, from, count, false, out);
	return out + (pairs ? 2 * count : count);
}

/* Copies a level's indices from their heap; those of pairs count vertices. Returns the end. */
static uint32_t *save_put_indices(const render_resources *resources, uint32_t *out, const render_level *from, bool wide,
                                  bool pairs)
{
	const uint8_t *heap = resources->heaps[wide ? RENDER_HEAP_INDICES : RENDER_HEAP_INDICES_16].data;
	for (uint32_t i = from->first_index; i < from->first_index + from->index_count; i++)
		*out++ = (wide ? ((const uint32_t *)heap)[i] : ((const uint16_t *)heap)[i]) >> pairs;
	return out;
}

static void save_put_meshes(const save_job *job)
{
	STILB_ASSERT_LOCKED(&job->render->resources.lock);
	const render_resources *resources = &job->render->resources;
	render_dump_mesh *out = save_part(job, RENDER_DUMP_MESHES);
	render_dump_level *level = save_part(job, RENDER_DUMP_LEVELS);
	stilb_scene_vertex *vertices = save_part(job, RENDER_DUMP_VERTICES);
	uint32_t *indices = save_part(job, RENDER_DUMP_INDICES);
	render_extra *extras = save_part(job, RENDER_DUMP_EXTRAS);
	for (uint32_t m = 0; m < job->header.meshes; m++, out++) {
		const render_mesh_slot *slot = &resources->meshes[job->meshes.indices[m]];
		const render_levels *levels = resources->levels[job->meshes.indices[m]];
		bool pairs = levels && levels->morphs;
		out->id = slot->name;
		out->vertices = slot->vertex_count;
		out->indices = slot->index_count;
		bool clusters = render_levels_have_clusters(levels);
		out->levels =
			(levels ? levels->count : 0) | (pairs ? RENDER_DUMP_MORPHS : 0) | (clusters ? RENDER_DUMP_CLUSTERS : 0);
		out->clusters = save_cluster_indices(levels);
		out->extras = slot->flags & RENDER_MESH_EXTRAS ? 1 : 0;
		extras = render_dump_extras_put(resources, job->meshes.indices[m], extras);
		vertices = save_put_vertices(resources, vertices, slot, pairs);
		indices =
			save_put_indices(resources, indices, (const render_level *)slot, slot->flags & RENDER_MESH_WIDE, pairs);
		for (uint32_t l = 1; levels && l <= levels->count; l++, level++) {
			const render_level *from = &render_levels_level(levels)[l];
			*level = (render_dump_level){.indices = from->index_count,
			                             .vertices = render_levels_vertices(levels)[l - 1],
			                             .error = sqrtf(render_levels_squared(levels)[l - 1])};
			indices = save_put_indices(resources, indices, from, l < levels->wide, pairs);
		}
		if (clusters) {
			render_level coarser = {.index_count = out->clusters,
			                        .first_index = slot->first_index + levels->clusters->coarser};
			indices = save_put_indices(resources, indices, &coarser, true, false);
		}
	}
}

typedef struct save_draws {
	const save_job *job;
	render_dump_draw *out;
} save_draws;

/* The level that a command draws: the one whose indices it names, in the heap that the state tells; or
 * RENDER_DUMP_SOME. */
static uint32_t save_level(const render_resources *resources, const render_command *command, uint32_t mesh,
                           uint64_t state)
{
	const render_levels *levels = resources->levels[mesh];
	for (uint32_t l = 0; levels && l <= levels->count; l++) {
		const render_level *level = render_levels_level(levels) + l;
		if ((state & RENDER_STATE_WIDE) != render_state_of_level(levels, l) ||
		    (levels->clusters && command->index_count != level->index_count))
			continue;
		if (command->first_index == level->first_index ||
		    (levels->morphs && l < levels->count && command->first_index == level[levels->count + 1].first_index))
			return l;
	}
	return render_levels_have_clusters(levels) ? RENDER_DUMP_SOME : 0;
}

static void save_put_draw(void *user, const render_command *command, const render_row *row, uint64_t state)
{
	save_draws *draws = user;
	render_dump_draw *out = draws->out++;
	STILB_ASSERT((uint8_t *)(out + 1) <= draws->job->bytes + draws->job->begin[RENDER_DUMP_VERTICES]);
	out->key = command->key;
	const render_resources *resources = &draws->job->render->resources;
	uint32_t level = save_level(resources, command, row->mesh, state);
	if (level == RENDER_DUMP_SOME) {
		const render_mesh_slot *slot = &resources->meshes[row->mesh];
		out->first_index = command->first_index - slot->first_index;
		if (out->first_index >= slot->index_count)
			out->first_index -= resources->levels[row->mesh]->clusters->coarser - slot->index_count;
		out->index_count = command->index_count;
	}
	out->mesh = draws->job->meshes.place[row->mesh] | level << 20 | render_command_detail(command) << 26;
	out->material = draws->job->materials.place[command->material] | render_state_detail(state) << 24;
	memcpy(out->transform, row->transform, sizeof out->transform);
}

static stilb_result save_put(save_job *job, const char *path)
{
	save_draws draws = {job, save_part(job, RENDER_DUMP_DRAWS)};
	memcpy(job->bytes, &job->header, sizeof job->header);
	save_put_views(job);
	save_put_lights(job);
	save_put_passes(job);
	save_put_targets(job);
	if (job->header.backdrop_bytes > 0)
		render_dump_backdrops_put(job->backdrops, job->views, job->header.views, save_part(job, RENDER_DUMP_BACKDROPS));
	save_each_draw(job, save_put_draw, &draws);
	uint64_t end = job->begin[RENDER_DUMP_CHECKSUM];
	uint64_t checksum = stilb_hash_fnv1a64(STILB_FNV1A64_START, job->bytes, end);
	memcpy(job->bytes + end, &checksum, sizeof checksum);
	return stilb_file_save(path, job->bytes, job->header.file_size);
}

/* Puts in order what is used, computes the file's size, and fills in what is copied from render_resources. All under
 * its lock, since other threads may create and destroy resources. */
static stilb_result save_put_resources(save_job *job)
{
	stilb_lock_take(&job->render->resources.lock);
	stilb_result result = save_order_used(job);
	if (result == STILB_OK)
		result = save_size(job);
	job->bytes = result == STILB_OK ? calloc(1, job->header.file_size) : NULL;
	if (job->bytes) {
		save_put_textures(job);
		save_put_materials(job);
		save_put_meshes(job);
	}
	stilb_lock_give(&job->render->resources.lock);
	if (result != STILB_OK || job->bytes)
		return result;
	return stilb_fail(STILB_ERROR_MEMORY, "no memory for a dump of %llu bytes",
	                  (unsigned long long)job->header.file_size);
}

/* Counts what the views have of backgrounds, and takes the stream's hash, which covers the panorama that is kept. */
static stilb_result save_backdrops(save_job *job, bool *without_panorama)
{
	render_dump_header *header = &job->header;
	bool any = render_dump_backdrops_fill(job->render, job->views, header->views, job->backdrops, without_panorama);
	uint64_t bytes = any ? render_dump_backdrop_bytes(job->backdrops, header->views) : 0;
	if (bytes > UINT32_MAX - 7)
		return stilb_fail(STILB_ERROR_ARGUMENT, "cannot dump a panorama of %ux%u texels: it has 4 GiB or more",
		                  job->backdrops[0].width, job->backdrops[0].height);
	header->backdrop_bytes = (uint32_t)bytes;
	bool kept = false;
	for (uint32_t v = 0; v < header->views; v++)
		kept |= job->backdrops[v].width > 0;
	header->stream_hash = kept ? stilb_render_stream_hash(job->render) : render_hash_plain(job->render);
	return STILB_OK;
}

/* ---- what is left out -------------------------------------------------------------------------------------------- */

/* Names for a message: "a, b, c", each once. */
typedef struct save_names {
	char text[512];
	size_t used;
	uint32_t more; /* names for which there was no room */
} save_names;

static void save_name(save_names *names, const char *name)
{
	size_t length = strnlen(name, sizeof names->text);
	for (const char *at = names->text; (at = strstr(at, name)); at++)
		if ((at == names->text || at[-1] == ' ') && (at[length] == '\0' || at[length] == ','))
			return;
	if (names->used + length + 3 > sizeof names->text) {
		names->more++;
		return;
	}
	names->used += (size_t)snprintf(names->text + names->used, sizeof names->text - names->used, "%s%s",
	                                names->used > 0 ? ", " : "", name);
}

static void save_say_names(const char *path, const char *what, const save_names *names)
{
	if (names->used > 0 && names->more > 0)
		stilb_log("'%s': without %s: %s and %u more", path, what, names->text, names->more);
	else if (names->used > 0)
		stilb_log("'%s': without %s: %s", path, what, names->text);
}

/* Says which passes of the frame are not in the file. */
static void save_say_left_out(const save_job *job, uint32_t pass_count, const char *path)
{
	const render_device *device = job->render->device;
	save_names flat = {0}, added = {0};
	for (uint32_t p = 0; p < pass_count; p++)
		if (job->passes[p].kind == STILB_RENDER_PASS_2D && job->render->passes[p].draws > 0)
			save_name(&flat, job->passes[p].name ? job->passes[p].name : "pass");
	for (uint32_t f = 0; f < STILB_RENDER_MAX_FEATURES; f++)
		for (uint32_t row = device->frame.added[f].first; row < device->frame.added[f].end; row++)
			save_name(&added, stilb_gpu_plan_row(device->plan, row)->name);
	save_say_names(path, "the frame's 2D passes", &flat);
	save_say_names(path, "the program's own passes", &added);
}

stilb_result stilb_render_dump_save(stilb_render *render, const stilb_render_pass *passes, uint32_t pass_count,
                                    const stilb_render_view *views, uint32_t view_count, const char *path)
{
	STILB_ASSERT_OWNER(render->owner);
	STILB_ASSERT(passes && views && path && view_count >= 1 && view_count <= RENDER_DUMP_MAX_VIEWS);
	if (render->replayed_count == 0)
		return stilb_fail(STILB_ERROR_ARGUMENT, "there is no frame to dump: none has been replayed");
	STILB_ASSERT(pass_count <= render->replayed_count && "passes that were replayed");
	save_job job = {
		.render = render,
		.passes = passes,
		.views = views,
		.header = {.magic = RENDER_DUMP_MAGIC,
	               .version = RENDER_DUMP_VERSION,
	               .byte_order = RENDER_DUMP_BYTE_ORDER,
	               .streams = render_dump_streams(&stilb_scene_vertex_streams),
	               .width = render->device->width,
	               .height = render->device->height,
	               .samples = render->device->samples,
	               .output = render->output,
	               .views = view_count},
	};
	for (uint32_t p = 0; p < pass_count; p++)
		if (passes[p].kind == STILB_RENDER_PASS_SCENE)
			job.pass[job.header.passes++] = p;
	if (job.header.passes == 0)
		return stilb_fail(STILB_ERROR_ARGUMENT, "there is no frame to dump: the last one has 2D passes alone");
	for (uint32_t p = 0; p < job.header.passes; p++) {
		const stilb_render_view *view = &views[passes[job.pass[p]].view];
		if (render_view_is_data(view) || view->show == STILB_RENDER_SHOW_ERROR)
			return stilb_fail(STILB_ERROR_ARGUMENT,
			                  "cannot dump the frame: it shows '%s' in the place of light, which dumps do not hold; "
			                  "dump one that is lit",
			                  stilb_render_show_names[view->show]);
	}
	save_find_targets(&job);
	bool without_panorama;
	stilb_result result = save_backdrops(&job, &without_panorama);
	if (result == STILB_OK)
		result = save_find_used(&job);
	if (result == STILB_OK)
		result = save_put_resources(&job);
	if (result == STILB_OK)
		result = save_put(&job, path);
	if (result == STILB_OK && without_panorama)
		stilb_log("'%s': without a panorama that the frame did not show yet, or that was not its first", path);
	if (result == STILB_OK)
		save_say_left_out(&job, pass_count, path);
	free(job.bytes);
	save_table_finish(&job.meshes);
	save_table_finish(&job.materials);
	save_table_finish(&job.textures);
	return result;
}
