/* Scenes and pipelines that a thread makes ready beside the frames. */
#include "render/render_internal.h"

#include <stdlib.h>
#include <time.h>

#define PREPARE_PENDING (4 * RENDER_UPLOAD_A_FRAME) /* bytes that wait for frames; beyond that the thread waits, too */
#define PREPARE_LOOK_NS 1000000                     /* between two looks at whether frames have taken some */

struct stilb_render_prepared {
	render_scene tables;
};

/* ---- a scene ----------------------------------------------------------------------------------------------------- */

/* A scene that is on its way. */
typedef struct prepare {
	stilb_render *render;
	const stilb_scene *scene;
	render_scene *tables;
	stilb_render_pace *pace;
	void *user;
	uint64_t total, made; /* bytes of the scene on the device; of what has been created */
	bool hurry;
} prepare;

/* True if the mesh's indices have 16 bits. */
static bool prepare_is_narrow(const stilb_scene_mesh *mesh)
{
	return mesh->vertex_count <= RENDER_NARROW_VERTICES && mesh->cluster_count == 0;
}

static uint64_t prepare_mesh_bytes(const stilb_render *render, const stilb_scene_mesh *mesh)
{
	size_t index = prepare_is_narrow(mesh) ? sizeof(uint16_t) : sizeof(uint32_t);
	uint64_t indices = (uint64_t)mesh->index_count + mesh->cluster_index_count;
	uint64_t vertex = render->resources.layout.size + (mesh->extras ? sizeof(render_extra) : 0);
	return mesh->vertex_count * vertex + indices * index;
}

/* As the device takes it, with mips if there shall be some; 0 of one that comes later, while the scene is shown. */
static uint64_t prepare_texture_bytes(const stilb_render *render, const stilb_image *image, bool mapped)
{
	if (!image->pixels || render_textures_mode(render) != STILB_RENDER_TEXTURES_AT_ONCE)
		return 0;
	render_texture_shape shape = render_texture_shape_of(render->device, image, mapped);
	return render_texture_shape_bytes(&shape);
}

/* Bytes of the whole scene, and what it adds to the heaps. Its textures are marked. */
static uint64_t prepare_count(const prepare *p, uint32_t more[RENDER_HEAPS])
{
	const stilb_scene *scene = p->scene;
	uint64_t bytes = scene->material_count * sizeof(render_material), counts[RENDER_HEAPS] = {0};
	for (uint32_t i = 0; i < scene->mesh_count; i++) {
		const stilb_scene_mesh *mesh = &scene->meshes[i];
		bytes += prepare_mesh_bytes(p->render, mesh);
		counts[RENDER_HEAP_VERTICES] += mesh->vertex_count;
		counts[prepare_is_narrow(mesh) ? RENDER_HEAP_INDICES_16 : RENDER_HEAP_INDICES] +=
			(uint64_t)mesh->index_count + mesh->cluster_index_count;
		counts[RENDER_HEAP_EXTRAS] += mesh->extras ? mesh->vertex_count : 0;
		counts[RENDER_HEAP_EXTRA_PLACES] = counts[RENDER_HEAP_EXTRAS] > 0 ? i + 1 : 0;
	}
	for (uint32_t i = 0; i < scene->texture_count; i++)
		bytes += prepare_texture_bytes(p->render, &scene->textures[i], p->tables->textures[i].mapped);
	counts[RENDER_HEAP_MATERIALS] = scene->material_count;
	for (uint32_t i = 0; i < scene->material_count; i++)
		counts[RENDER_HEAP_MAPS] += scene->materials[i].surface > 0;
	for (int h = 0; h < RENDER_HEAPS; h++)
		more[h] = counts[h] < UINT32_MAX ? (uint32_t)counts[h] : UINT32_MAX;
	return bytes;
}

/* Waits until frames have taken so much that at most `most` bytes are pending, or somebody is in a hurry. The pending
 * bytes of others count, too: frames have to copy them first. */
static stilb_result prepare_wait(prepare *p, uint64_t most)
{
	for (;;) {
		uint64_t pending = render_resources_pending(&p->render->resources);
		uint64_t done = p->made > pending ? p->made - pending : 0;
		stilb_render_speed speed = p->pace(p->user, p->total > 0 ? (float)((double)done / (double)p->total) : 1.0f);
		if (speed == STILB_RENDER_GIVE_UP)
			return stilb_fail(STILB_ERROR_GIVEN_UP, "the scene was given up before it was on the device");
		p->hurry = speed == STILB_RENDER_HURRY;
		if (p->hurry || pending <= most)
			return STILB_OK;
		nanosleep(&(struct timespec){.tv_nsec = PREPARE_LOOK_NS}, NULL);
	}
}

static stilb_result prepare_fill(prepare *p)
{
	const stilb_scene *scene = p->scene;
	stilb_result result = STILB_OK;
	for (uint32_t i = 0; i < scene->mesh_count && result == STILB_OK; i++) {
		result = render_scene_mesh(p->render, p->tables, scene, i);
		p->made += prepare_mesh_bytes(p->render, &scene->meshes[i]);
		if (result == STILB_OK)
			result = prepare_wait(p, PREPARE_PENDING);
	}
	if (result == STILB_OK)
		result = render_scene_check_parts(scene, p->tables);
	for (uint32_t i = 0; i < scene->texture_count && result == STILB_OK; i++) {
		result = render_scene_texture_patient(p->render, p->tables, scene, i);
		p->made += prepare_texture_bytes(p->render, &scene->textures[i], p->tables->textures[i].mapped);
		if (result == STILB_OK)
			result = prepare_wait(p, PREPARE_PENDING);
	}
	for (uint32_t i = 0; i < scene->function_count && result == STILB_OK; i++)
		result = render_scene_function(p->render, p->tables, scene, i);
	for (uint32_t i = 0; i < scene->material_count && result == STILB_OK; i++)
		result = render_scene_material(p->render, p->tables, scene, i);
	p->made += scene->material_count * sizeof(render_material);
	if (result == STILB_OK)
		result = render_scene_impostors(p->render, p->tables, scene);
	if (result == STILB_OK)
		result = render_places_make(p->render, p->tables, scene);
	return result == STILB_OK ? prepare_wait(p, 0) : result;
}

stilb_result stilb_render_prepare_scene(stilb_render *render, const stilb_scene *scene, stilb_render_pace *pace,
                                        void *user, stilb_render_prepared **out)
{
	STILB_ASSERT(render && scene && pace && out);
	PROFILE("prepare a scene");
	*out = NULL;
	stilb_render_prepared *prepared = calloc(1, sizeof *prepared);
	if (!prepared)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the scene's tables");
	prepare p = {.render = render, .scene = scene, .tables = &prepared->tables, .pace = pace, .user = user};
	stilb_result result = render_scene_fit(p.tables, scene);
	if (result == STILB_OK) {
		uint32_t more[RENDER_HEAPS];
		render_scene_mark(render, p.tables, scene);
		p.total = prepare_count(&p, more);
		render_resources_expect(&render->resources, more);
		result = prepare_fill(&p);
		render_resources_expect(&render->resources, NULL);
		if (!prepared->tables.loading)
			render_resources_expect_no_textures(render);
	}
	if (result == STILB_OK)
		*out = prepared;
	else
		stilb_render_drop_scene(render, prepared);
	return result;
}

void stilb_render_show_scene(stilb_render *render, stilb_render_prepared *prepared)
{
	STILB_ASSERT_OWNER(render->owner);
	STILB_ASSERT(prepared);
	render_resources_hurry(&render->resources);
	render_scene_replace(render, &prepared->tables);
	free(prepared);
}

void stilb_render_drop_scene(stilb_render *render, stilb_render_prepared *prepared)
{
	if (!prepared)
		return;
	render_scene_destroy(render, &prepared->tables);
	free(prepared);
}

/* ---- pipelines --------------------------------------------------------------------------------------------------- */

/* How many lamps a panorama has is known only once it has been made ready: 0, 1 and more may need three pipelines. */
#define PREPARE_LAMPS 3u

/* Adds a kind of maps to the list unless it is there. False: no memory. */
static bool prepare_know(render_known_maps *known, uint64_t bits)
{
	for (uint32_t k = 0; k < known->count; k++)
		if (known->bits[k] == bits)
			return true;
	if (!render_reserve((void **)&known->bits, &known->capacity, known->count + 1, sizeof bits))
		return false;
	known->bits[known->count++] = bits;
	return true;
}

/* What materials and meshes have of surfaces now. *known: its bits are to be freed. */
static stilb_result prepare_known_maps(render_resources *resources, render_known_maps *known)
{
	bool memory = true;
	*known = (render_known_maps){0};
	stilb_lock_take(&resources->lock);
	for (uint32_t i = 0; i < resources->indices[RENDER_RESOURCE_MESH].next_unused; i++) {
		bool extras = resources->meshes[i].flags & RENDER_MESH_EXTRAS;
		known->extras |= extras;
		known->plain |= !extras;
	}
	for (uint32_t i = 0; i < resources->indices[RENDER_RESOURCE_GROUP].next_unused && memory; i++) {
		const render_group *group = render_group_of(resources, i);
		memory = group->head.users == 0 || prepare_know(known, group->key.bits);
	}
	stilb_lock_give(&resources->lock);
	return memory ? STILB_OK : stilb_fail(STILB_ERROR_MEMORY, "no memory for the list of kinds of surfaces");
}

stilb_result stilb_render_prepare_view(stilb_render *render, const stilb_render_view *view)
{
	STILB_ASSERT(render && view && render_view_lighting_is_known(view));
	PROFILE("prepare a view");
	bool panorama = view->surroundings.panorama.pixels;
	bool lamps_light = panorama && view->ambient != STILB_RENDER_AMBIENT_NONE;
	uint32_t made[PREPARE_LAMPS];
	render_known_maps maps;
	stilb_result result = prepare_known_maps(&render->resources, &maps);
	for (uint32_t lamps = 0; lamps < (lamps_light ? PREPARE_LAMPS : 1u) && result == STILB_OK; lamps++) {
		made[lamps] = render_light_bits(view, panorama, lamps);
		bool known = false;
		for (uint32_t i = 0; i < lamps; i++)
			known |= made[i] == made[lamps];
		if (!known)
			result = render_device_prepare(render->device, view, made[lamps], &maps);
	}
	if (result == STILB_OK)
		result = render_device_prepare_seen(render->device, view, &maps);
	free(maps.bits);
	return result;
}
