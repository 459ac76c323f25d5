#include "geometry/geometry_detail.h"

#include "geometry/geometry_levels.h"
#include "scene/edit/scene_edit.h"
#include "scene/play/scene_play.h"
#include "scene/scene_impostor.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

#define DETAIL_NICE 10 /* frames, rays and the window come first */

struct stilb_geometry_detail {
	pthread_t thread;
	uint32_t count;
	uint32_t *ids;            /* [count] of meshes */
	stilb_scene_mesh *meshes; /* [count] copies of them; those from `given` to `made` have been made */
	uint32_t given;
	atomic_uint made;       /* written by the thread: release, and acquire where it is read, so that meshes are seen */
	atomic_bool given_up;   /* set by the main thread; relaxed: nothing else depends on it */
	uint32_t *index_counts; /* [count] of the meshes when they were copied */
};

/* True if levels can be made of a mesh, and there are none. */
static bool detail_is_wanted(const stilb_scene *scene, uint32_t id)
{
	const stilb_scene_mesh *mesh = &scene->meshes[id];
	return mesh->level_count == 0 && mesh->index_count / 3 >= STILB_GEOMETRY_DETAIL_LEAST &&
	       !stilb_scene_animation_deform(scene->animation, id) && !stilb_scene_mesh_is_posed(scene, id);
}

void stilb_geometry_detail_find(stilb_scene *scene)
{
	stilb_geometry_levels_desc desc = stilb_geometry_levels_desc_default();
	for (uint32_t id = 0; id < scene->mesh_count; id++)
		if (detail_is_wanted(scene, id))
			stilb_geometry_levels_find(&scene->meshes[id], &desc);
}

/* A pool for this thread; NULL: it works alone. */
static stilb_job_pool *detail_pool(void)
{
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	desc.name = "stilb-detail";
	desc.affinity = STILB_JOB_AFFINITY_NONE;
	stilb_job_pool *pool;
	return stilb_job_pool_create(&desc, &pool) == 0 ? pool : NULL;
}

void stilb_geometry_detail_make(stilb_scene *scene)
{
	stilb_geometry_levels_desc desc = stilb_geometry_levels_desc_default();
	stilb_job_pool *pool = NULL;
	for (uint32_t id = 0; id < scene->mesh_count; id++) {
		if (!detail_is_wanted(scene, id))
			continue;
		if (!pool)
			pool = detail_pool();
		stilb_geometry_levels_cached(&scene->meshes[id], &desc, pool, 0);
	}
	stilb_job_pool_destroy(pool);
}

static bool detail_is_given_up(void *user)
{
	const stilb_geometry_detail *detail = user;
	return atomic_load_explicit(&detail->given_up, memory_order_relaxed);
}

static void *detail_run(void *data)
{
	stilb_geometry_detail *detail = data;
	setpriority(PRIO_PROCESS, 0, DETAIL_NICE); /* of this thread alone, on Linux; its pool's threads inherit it */
	stilb_geometry_levels_desc desc = stilb_geometry_levels_desc_default();
	desc.give_up = detail_is_given_up;
	desc.user = detail;
	stilb_job_pool *pool = detail_pool();
	for (uint32_t i = 0; i < detail->count && !detail_is_given_up(detail); i++) {
		stilb_geometry_levels_cached(&detail->meshes[i], &desc, pool, 0); /* without memory there are none */
		atomic_store_explicit(&detail->made, i + 1, memory_order_release);
	}
	stilb_job_pool_destroy(pool);
	return NULL;
}

static bool detail_copy(const stilb_scene_mesh *mesh, stilb_scene_mesh *copy)
{
	*copy = (stilb_scene_mesh){.vertex_count = mesh->vertex_count, .index_count = mesh->index_count};
	copy->vertices = stilb_memory_alloc(mesh->vertex_count, sizeof *mesh->vertices);
	copy->indices = stilb_memory_alloc(mesh->index_count, sizeof *mesh->indices);
	if (!copy->vertices || !copy->indices)
		return false;
	memcpy(copy->vertices, mesh->vertices, mesh->vertex_count * sizeof *mesh->vertices);
	memcpy(copy->indices, mesh->indices, mesh->index_count * sizeof *mesh->indices);
	return true;
}

static void detail_free(stilb_geometry_detail *detail)
{
	for (uint32_t i = 0; detail->meshes && i < detail->count; i++)
		stilb_scene_mesh_finish(&detail->meshes[i]);
	free(detail->meshes);
	free(detail->ids);
	free(detail->index_counts);
	free(detail);
}

stilb_result stilb_geometry_detail_start(const stilb_scene *scene, stilb_geometry_detail **out)
{
	STILB_ASSERT(scene && out);
	*out = NULL;
	uint32_t count = 0;
	for (uint32_t id = 0; id < scene->mesh_count; id++)
		count += detail_is_wanted(scene, id);
	if (count == 0)
		return STILB_OK;
	stilb_geometry_detail *detail = calloc(1, sizeof *detail);
	bool made = detail;
	if (made) {
		detail->ids = calloc(count, sizeof *detail->ids);
		detail->meshes = calloc(count, sizeof *detail->meshes);
		detail->index_counts = calloc(count, sizeof *detail->index_counts);
		made = detail->ids && detail->meshes && detail->index_counts;
	}
	for (uint32_t id = 0; made && id < scene->mesh_count; id++) {
		if (!detail_is_wanted(scene, id))
			continue;
		uint32_t i = detail->count++;
		detail->ids[i] = id;
		detail->index_counts[i] = scene->meshes[id].index_count;
		made = detail_copy(&scene->meshes[id], &detail->meshes[i]);
	}
	int error = made ? pthread_create(&detail->thread, NULL, detail_run, detail) : 0;
	if (!made || error != 0) {
		if (detail)
			detail_free(detail);
		return made ? stilb_fail_threads(1, error)
		            : stilb_fail(STILB_ERROR_MEMORY, "no memory for coarser levels of %u meshes", count);
	}
	*out = detail;
	return STILB_OK;
}

/* True if a mesh of the scene still is the one that was copied, as far as its size tells; programs of this one edit
 * none. */
static bool detail_fits(const stilb_geometry_detail *detail, const stilb_scene *scene, uint32_t i)
{
	uint32_t id = detail->ids[i];
	const stilb_scene_mesh *made = &detail->meshes[i];
	return id < scene->mesh_count && made->level_count > 0 &&
	       scene->meshes[id].index_count == detail->index_counts[i] &&
	       scene->meshes[id].vertex_count == made->vertex_count && scene->meshes[id].level_count == 0;
}

/* Gives a mesh its levels. Its surface is the same, so that what impostors show stays true. */
static void detail_set(stilb_scene *scene, uint32_t id, const stilb_scene_mesh *mesh)
{
	bool current = stilb_scene_impostors_are_current(scene);
	stilb_scene_set_mesh(scene, id, mesh); /* without memory it stays as it is */
	if (current)
		scene->impostors_geometry = stilb_scene_impostors_revision(scene);
}

bool stilb_geometry_detail_give(stilb_geometry_detail *detail, stilb_scene *scene)
{
	if (!detail)
		return true;
	uint32_t made = atomic_load_explicit(&detail->made, memory_order_acquire);
	while (detail->given < made) {
		uint32_t i = detail->given++;
		bool fits = detail_fits(detail, scene, i);
		if (fits)
			detail_set(scene, detail->ids[i], &detail->meshes[i]);
		stilb_scene_mesh_finish(&detail->meshes[i]);
		if (fits)
			break;
	}
	return detail->given == detail->count;
}

void stilb_geometry_detail_end(stilb_geometry_detail *detail)
{
	if (!detail)
		return;
	atomic_store_explicit(&detail->given_up, true, memory_order_relaxed);
	pthread_join(detail->thread, NULL);
	detail_free(detail);
}
