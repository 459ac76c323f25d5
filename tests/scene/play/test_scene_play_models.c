/* The animated files of Debian's package assimp-testmodels, at times of all their clips, beside the reference in double
 * precision. With an argument the errors of each are printed. */
#include "play_check.h"
#include "scene/edit/scene_node.h"
#include "scene/open/scene_import.h"
#include "scene/scene_internal.h"
#include "support/test.h"

#include <fts.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

#define MODELS "/usr/share/assimp/models"

static bool models_told;

/* Formats that have animations, skins or morph targets. */
static bool may_move(const char *path)
{
	static const char *const ends[] = {".3ds", ".ase",  ".b3d", ".bvh", ".csm", ".dae", ".fbx",
	                                   ".glb", ".gltf", ".iqm", ".irr", ".lws", ".m3d", ".md5mesh",
	                                   ".mdl", ".ms3d", ".smd", ".x",   ".zae"};
	const char *dot = strrchr(path, '.');
	for (size_t i = 0; dot && i < sizeof ends / sizeof *ends; i++)
		if (strcasecmp(dot, ends[i]) == 0)
			return true;
	return false;
}

/* Plays one clip, or two at once. */
static void play_at(const stilb_scene *rest, stilb_scene *scene, const stilb_scene_play *plays, uint32_t count,
                    const char *path, play_errors *errors)
{
	stilb_mat4 world = stilb_mat4_identity();
	assert_int_equal(stilb_scene_rest_figure(scene, 0), STILB_OK);
	assert_int_equal(stilb_scene_set_plays(scene, 0, plays, count), STILB_OK);
	stilb_scene_advance(scene, 0.0, NULL, 0);
	stilb_scene_update_nodes(scene, NULL, 0);
	play_compare(rest, scene, 0, &world, plays, count, path, errors);
}

static void play_file(const char *path, const stilb_scene *rest, stilb_scene *scene, play_errors *errors)
{
	const stilb_scene_animation *a = rest->animation;
	play_at(rest, scene, NULL, 0, path, errors);
	for (uint32_t c = 0; c < a->clip_count; c++) {
		static const double shares[] = {0.0, 0.123, 0.5, 0.877, 1.0};
		for (size_t i = 0; i < sizeof shares / sizeof *shares; i++) {
			stilb_scene_play plays[2] = {stilb_scene_play_make(c), stilb_scene_play_make(a->clip_count - 1 - c)};
			plays[0].repeat = plays[1].repeat = STILB_SCENE_ONCE;
			plays[0].time = shares[i] * (double)a->clips[c].duration;
			plays[1].time = 0.5 * (double)a->clips[plays[1].clip].duration;
			plays[1].weight = 0.75f;
			play_at(rest, scene, plays, 1, path, errors);
			plays[0].weight = 0.25f;
			if (i == 1)
				play_at(rest, scene, plays, 2, path, errors);
		}
	}
}

static void animated_files_look_as_the_reference(void **state)
{
	(void)state;
	char *roots[] = {MODELS, NULL};
	FTS *walk = fts_open(roots, FTS_PHYSICAL, NULL);
	assert_non_null(walk);
	uint32_t files = 0, clips = 0;
	play_errors most = {0};
	for (FTSENT *entry; (entry = fts_read(walk));) {
		const char *path = entry->fts_path;
		if (entry->fts_info != FTS_F || !may_move(path))
			continue;
		scene_import_limits limits = scene_import_limits_default();
		stilb_scene *rest, *scene;
		limits.quiet = true;
		if (scene_import_within(path, &limits, &rest) != STILB_OK)
			continue;
		if (rest->animation) {
			play_errors errors = {0};
			assert_int_equal(stilb_scene_open_with(path, &(stilb_scene_open_options){.quiet = true}, &scene), STILB_OK);
			play_file(path, rest, scene, &errors);
			if (models_told)
				print_message("%-70s positions %.1e, normals %.1e, bounds %.1e\n", path + sizeof MODELS,
				              errors.position, errors.normal, errors.bound);
			play_assert(&errors, path);
			files++;
			clips += rest->animation->clip_count;
			most.position = fmax(most.position, errors.position);
			most.normal = fmax(most.normal, errors.normal);
			most.vertices += errors.vertices;
			stilb_scene_destroy(scene);
		}
		stilb_scene_destroy(rest);
	}
	fts_close(walk);
	print_message("%u files with %u clips: positions to %.1e of the size, normals to %.1e; %llu vertices\n", files,
	              clips, most.position, most.normal, (unsigned long long)most.vertices);
	assert_true(files > 50 && clips > 80);
}

int main(int argc, char **argv)
{
	(void)argv;
	models_told = argc > 1;
	if (access(MODELS, R_OK) != 0) {
		printf("skipped: no " MODELS "; install assimp-testmodels\n");
		return 77;
	}
	const struct CMUnitTest tests[] = {cmocka_unit_test(animated_files_look_as_the_reference)};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
