/* What the tests of renders share: a small scene made ready for rays, with the intersector stilb_gi_brute where no
 * other library (Embree) may take part. */
#ifndef GI_RENDER_FIXTURE_H
#define GI_RENDER_FIXTURE_H

#include "gi/gi_render.h"
#include "support/test.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef struct render_fixture {
	stilb_job_pool *pool;
	stilb_scene *scene;
	stilb_gi_scene *gi;
} render_fixture;

static inline render_fixture render_fixture_with(const char *name, uint32_t workers,
                                                 const stilb_gi_intersector *intersector)
{
	render_fixture fixture;
	stilb_job_pool_desc desc = stilb_job_pool_desc_default();
	desc.worker_count = workers;
	assert_int_equal(stilb_job_pool_create(&desc, &fixture.pool), 0);
	assert_int_equal(stilb_scene_open(name, &fixture.scene), STILB_OK);
	stilb_gi_scene_desc scene = {.pool = fixture.pool, .intersector = intersector};
	assert_int_equal(stilb_gi_scene_create(fixture.scene, &scene, &fixture.gi), STILB_OK);
	return fixture;
}

static inline render_fixture render_fixture_make(const char *name, uint32_t workers)
{
	return render_fixture_with(name, workers, &stilb_gi_brute);
}

static inline void render_fixture_finish(render_fixture *fixture)
{
	stilb_gi_scene_destroy(fixture->gi);
	stilb_scene_destroy(fixture->scene);
	stilb_job_pool_destroy(fixture->pool);
}

/* Settings of a picture whose sides are no multiples of a tile's or a block's. */
static inline stilb_gi_settings render_fixture_settings(const render_fixture *fixture)
{
	stilb_gi_settings settings = stilb_gi_settings_default(fixture->scene);
	settings.width = 37;
	settings.height = 21;
	settings.samples = 6;
	settings.depth = 4;
	settings.rays = 4;
	settings.ao_distance = 0.5f;
	settings.cache.rays = 16;
	settings.cache.error = 0.5f;
	return settings;
}

static inline stilb_gi_render *render_fixture_create(const render_fixture *fixture, const stilb_gi_settings *settings)
{
	stilb_gi_render *render;
	if (stilb_gi_render_create(fixture->gi, settings, fixture->pool, &render) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return render;
}

/* A hash of every number of the film, also of the denoised picture if there is one. */
static inline uint64_t film_hash(const stilb_gi_render *render)
{
	stilb_gi_film film = stilb_gi_render_film(render);
	size_t pixels = (size_t)film.width * film.height;
	const struct {
		const void *plane;
		size_t size;
	} planes[] = {{film.radiance, 12}, {film.albedo, 12},   {film.normal, 12},
	              {film.depth, 4},     {film.variance, 12}, {film.samples, 4}};
	uint64_t hash = STILB_FNV1A64_START;
	for (size_t i = 0; i < sizeof planes / sizeof *planes; i++)
		hash = stilb_hash_fnv1a64(hash, planes[i].plane, pixels * planes[i].size);
	return film.denoised ? stilb_hash_fnv1a64(hash, film.denoised, 12 * pixels) : hash;
}

static inline stilb_gi_progress progress_of(stilb_gi_render *render)
{
	stilb_gi_progress progress;
	stilb_gi_render_progress(render, &progress);
	return progress;
}

/* The film of a render that nobody stops. */
static inline uint64_t render_whole(const render_fixture *fixture, const stilb_gi_settings *settings)
{
	stilb_gi_render *render = render_fixture_create(fixture, settings);
	if (stilb_gi_render_run(render) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	assert_true(progress_of(render).finished);
	if (settings->denoise)
		assert_int_equal(stilb_gi_render_denoise(render), STILB_OK);
	uint64_t hash = film_hash(render);
	stilb_gi_render_destroy(render);
	return hash;
}

#endif
