/* Planted violations of the contracts of engine/gi: each must abort with its assert. No pool has workers here: a child
 * process would not have their threads. */
#include "gi_render_fixture.h"

#include "gi/cache/gi_cache_octree.h"
#include "gi/cache/gi_cache_slab.h"
#include "gi/film/gi_film.h"
#include "gi/film/gi_primary.h"
#include "gi/gi_render_internal.h"
#include "gi/gi_settings.h"
#include "gi/gi_texture.h"
#include "gi/light/gi_light_tree.h"
#include "gi/trace/gi_cover.h"
#include "gi/trace/gi_ray.h"
#include "support/contract.h"

#include <pthread.h>

static render_fixture fixture;
static stilb_gi_render *render;

static int group_setup(void **state)
{
	(void)state;
	fixture = render_fixture_make("cornell", 0);
	stilb_gi_settings settings = render_fixture_settings(&fixture);
	render = render_fixture_create(&fixture, &settings);
	return 0;
}

static int group_teardown(void **state)
{
	(void)state;
	stilb_gi_render_destroy(render);
	render_fixture_finish(&fixture);
	return 0;
}

/* Calls the function on another thread and waits for it. */
static int on_another_thread(void *(*function)(void *))
{
	pthread_t thread;
	return pthread_create(&thread, NULL, function, NULL) || pthread_join(thread, NULL);
}

static void *destroy_scene(void *unused)
{
	stilb_gi_scene_destroy(fixture.gi);
	return unused;
}

static void *run_render(void *unused)
{
	stilb_gi_render_run(render);
	return unused;
}

static void *save_checkpoint(void *unused)
{
	stilb_gi_render_checkpoint(render, "unused");
	return unused;
}

static void *update_scene(void *unused)
{
	stilb_gi_scene_desc desc = {.pool = fixture.pool, .intersector = fixture.gi->intersector};
	stilb_gi_scene_update(fixture.gi, fixture.scene, &desc);
	return unused;
}

static void *share_render(void *unused)
{
	stilb_gi_render_share(render, 0, 0.0);
	return unused;
}

static void *watch_render(void *unused)
{
	stilb_gi_render_watch(render, NULL, NULL);
	return unused;
}

static void threads(void **state)
{
	(void)state;
	contract_breaks("called on the owner's thread", on_another_thread(update_scene));
	contract_breaks("called on the owner's thread", on_another_thread(share_render));
	contract_breaks("called on the owner's thread", on_another_thread(watch_render));
	contract_breaks("called on the owner's thread", on_another_thread(destroy_scene));
	contract_breaks("called on the owner's thread", on_another_thread(run_render));
	contract_breaks("called on the owner's thread", on_another_thread(save_checkpoint));
}

static stilb_gi_film film_during_run(void)
{
	render->begun_ns = 1;
	return stilb_gi_render_film(render);
}

static bool share_during_run(void)
{
	render->begun_ns = 1;
	stilb_gi_render_share(render, 0, 0.0);
	return true;
}

static bool add_outside(void)
{
	static const float none[3];
	gi_film_sample sample = {.albedo = none, .normal = none};
	return gi_film_add(&render->film, (size_t)render->film.width * render->film.height, &sample);
}

static void pictures(void **state)
{
	(void)state;
	stilb_gi_scene_desc desc = {.pool = fixture.pool, .intersector = &stilb_gi_embree};
	contract_breaks("run does not run", film_during_run());
	contract_breaks("before the first run", share_during_run());
	contract_breaks("caller == 0 || caller == ", (stilb_gi_render_share(render, 1, 0.0), 0));
	contract_breaks("slice >= 0.0", (stilb_gi_render_share(render, 0, -1.0), 0));
	contract_breaks("render", (stilb_gi_render_stop(NULL), 0));
	contract_breaks("render->view.settings.denoise", stilb_gi_render_denoise(render));
	contract_breaks("render && rgb", (stilb_gi_render_preview(render, NULL), 0));
	contract_breaks("a scene keeps its intersector", stilb_gi_scene_update(fixture.gi, fixture.scene, &desc));
	contract_breaks("index < (size_t)film->width * film->height", add_outside());
	contract_breaks("index < gi_settings_count()", gi_settings_get(&render->view.settings, gi_settings_count()));
	contract_breaks("name < STILB_GI_INTEGRATOR_COUNT", gi_integrator_of(STILB_GI_INTEGRATOR_COUNT));
}

static gi_camera camera_of(stilb_gi_lens lens)
{
	return gi_camera_make(&fixture.scene->camera, &lens, 8, 8);
}

static void rays(void **state)
{
	(void)state;
	static gi_primary out;
	static const gi_primary_samples too_many = {.count = GI_BATCH + 1};
	const gi_tracer *tracer = &fixture.gi->tracer;
	gi_ray_hit ray = gi_ray_hit_make(stilb_vec3_make(0.0f, 1.0f, 3.0f), stilb_vec3_make(0.0f, 0.0f, -1.0f));
	gi_ray_hit16 packet = {0};
	gi_surface surface;
	contract_breaks("gi_is_hit(ray)", (gi_surface_at(fixture.gi, &ray, &surface), 0));
	contract_breaks("lane < 16", gi_ray_of(&packet, GI_PACKET));
	contract_breaks("samples->count <= 1024",
	                (gi_primary_trace(render->kernels, &render->view, &render->camera, &too_many, &out), 0));
	contract_breaks("lens->focus > 0.0f", camera_of((stilb_gi_lens){.radius = 0.1f}));
	contract_breaks("lens->blades >= 3", camera_of((stilb_gi_lens){.blades = 2}));
	ray.hit.part = 0;
	contract_breaks("nothing hit before", (tracer->intersect(tracer, &ray), 0));
}

static void samples(void **state)
{
	(void)state;
	gi_sampler sampler = gi_sampler_make(STILB_GI_SAMPLER_SOBOL, 0, 4);
	gi_point point = gi_sampler_point(&sampler, 1, 2, 3);
	gi_light_sample light;
	float numbers[8];
	contract_breaks("samples >= 1", gi_sampler_make(STILB_GI_SAMPLER_SOBOL, 0, 0));
	contract_breaks("dimension % 2 == 0", gi_sample_2d(&sampler, point, 3));
	contract_breaks("first % 8 == 0", (gi_sample_8(&sampler, point, 4, numbers), 0));
	contract_breaks("i < n", gi_sampler_branch(&sampler, point, 8, 5, 5));
	contract_breaks("u_choice < 1.0f",
	                gi_light_sample_at(&fixture.gi->lights, GI_LIGHT_PLACED, true, (stilb_vec3){0},
	                                   stilb_vec3_make(0.0f, 1.0f, 0.0f), 1.0f, (stilb_vec2){0.5f, 0.5f}, &light));
	contract_breaks("light < lights->emitter_count",
	                gi_light_pdf(&fixture.gi->lights, (stilb_vec3){0}, (stilb_vec3){0}, 1000, 1.0f));
	contract_breaks("leaf_count >= 1", (gi_light_tree_build(NULL, 0, NULL), 0));
}

static bool insert_without_radius(void)
{
	static const float low[3] = {0.0f, 0.0f, 0.0f}, high[3] = {1.0f, 1.0f, 1.0f};
	gi_cache_octree *octree;
	return gi_cache_octree_create(low, high, &octree) == STILB_OK &&
	       gi_cache_octree_insert(octree, &(gi_cache_record){.position = {0.5f, 0.5f, 0.5f, 0.0f}});
}

static const void *item_beyond_the_last(void)
{
	gi_cache_slab slab;
	gi_cache_slab_init(&slab, 16);
	gi_cache_slab_take(&slab);
	return gi_cache_slab_item(&slab, 1);
}

static gi_cache_strata strata_of(uint32_t rays)
{
	gi_cache_strata strata;
	gi_cache_strata_create(rays, &strata);
	return strata;
}

static void cache(void **state)
{
	(void)state;
	contract_breaks("source->position[3] > 0.0f", insert_without_radius());
	contract_breaks("i < gi_cache_slab_count(slab)", item_beyond_the_last());
	contract_breaks("rays >= 16", strata_of(15));
	contract_breaks("turn > 0.0f",
	                gi_cache_record_error(&(gi_cache_record){0}, (stilb_vec3){0}, (stilb_vec3){0}, 0.0f) > 0.0f);
}

/* An intersector that damages the scene it is made for: the check of the whole scene must find it. */
static stilb_result damage(const stilb_gi_scene *gi, const stilb_gi_scene_desc *desc, gi_tracer *tracer,
                           stilb_gi_scene_info *info)
{
	stilb_result result = stilb_gi_brute.create(gi, desc, tracer, info);
	((gi_triangle *)gi->triangles)->vertex[1] = UINT32_MAX;
	return result;
}

static stilb_gi_scene *scene_damaged(void)
{
	static stilb_gi_intersector damaging;
	damaging = stilb_gi_brute;
	damaging.create = damage;
	stilb_gi_scene_desc desc = {.pool = fixture.pool, .intersector = &damaging};
	stilb_gi_scene *gi;
	stilb_gi_scene_create(fixture.scene, &desc, &gi);
	return gi;
}

static void structures(void **state)
{
	(void)state;
	stilb_gi_scene_desc other = stilb_gi_scene_desc_default(fixture.pool);
	contract_breaks("desc->intersector == gi->intersector", stilb_gi_scene_update(fixture.gi, fixture.scene, &other));
	contract_breaks("gi_scene_is_sound(gi)", scene_damaged());
}

static void surfaces(void **state)
{
	(void)state;
	static uint8_t block[16];
	stilb_scene_surface surface = stilb_scene_surface_make();
	gi_maps maps = {.surface = &surface};
	gi_place place = {.color = {1.0f, 1.0f, 1.0f, 1.0f}};
	gi_glow same = {.maps = {.surface = NULL}};
	stilb_image blocks = {4, 4, 4, STILB_IMAGE_BC7_SRGB, block, 0}, wide = {1, 1, 5, STILB_IMAGE_U8_SRGB, block, 0};
	gi_crossing nowhere = {.part = fixture.gi->part_count};
	contract_breaks("blocks were decoded", gi_texture_at(&blocks, (stilb_vec2){0})[0] > 0.0f);
	contract_breaks("image->channels <= 4", gi_texture_at(&wide, (stilb_vec2){0})[0] > 0.0f);
	contract_breaks("gi_maps_have(maps, kind)", gi_maps_normal(&maps, STILB_SCENE_MAP_NORMAL, 1.0f, &place)[0] > 0.0f);
	contract_breaks("glow->maps.surface", gi_glow_at(&same, 0.0f, 0.0f)[0] > 0.0f);
	contract_breaks("crossing->part < scene->part_count", gi_cover_meets(fixture.gi, &nowhere));
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(threads), cmocka_unit_test(pictures),   cmocka_unit_test(rays),     cmocka_unit_test(samples),
		cmocka_unit_test(cache),   cmocka_unit_test(structures), cmocka_unit_test(surfaces),
	};
	return cmocka_run_group_tests(tests, group_setup, group_teardown);
}
