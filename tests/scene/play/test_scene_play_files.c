/*
 * Generated glTF files at times before, on, between and after their keys, with one clip and with two: what scenes show
 * of them beside the reference in double precision. With an argument the errors of each are printed.
 */
#include "glb_moving.h"
#include "play_check.h"
#include "scene/edit/scene_node.h"
#include "scene/open/scene_import.h"
#include "scene/scene_internal.h"

#define ALL (MOVING_STEP | MOVING_LINEAR | MOVING_CUBIC)

static const moving_file files[] = {
	{"linear", MOVING_LINEAR, 8, 0, 0, 5, 0, 1, 1},
	{"step", MOVING_STEP, 8, 1, 0, 5, 0, 1, 1},
	{"cubic", MOVING_CUBIC, 8, 1, 0, 5, 0, 1, 1},
	{"near -q", MOVING_LINEAR | MOVING_MINUS, 8, 1, 0, 6, 0, 1, 1},
	{"near q, cubic", MOVING_CUBIC | MOVING_MINUS, 8, 1, 0, 6, 0, 1, 1},
	{"zero scale", MOVING_LINEAR | MOVING_FLAT, 6, 1, 0, 5, 0, 1, 1},
	{"zero scale, no skin", ALL | MOVING_FLAT, 6, 0, 0, 5, 0, 1, 1},
	{"negative scale", ALL | MOVING_MIRROR, 6, 1, 0, 5, 0, 1, 1},
	{"two skins share joints", ALL | MOVING_TWO_SKINS, 9, 1, 0, 4, 0, 1, 1},
	{"weights of other sums", ALL, 8, 1, 0, 4, 0, 0.3f, 2.5f},
	{"no joints", ALL, 0, 1, 0, 4, 0, 0, 0},
	{"no weights", ALL, 4, 1, 0, 4, 0, 0, 0},
	{"one joint", ALL, 1, 1, 0, 4, 0, 1, 1},
	{"300 joints", ALL, 300, 2, 0, 3, 0, 1, 1},
	{"late keys", ALL, 8, 1, 2, 4, 1.5f, 1, 1},
	{"one key", ALL, 8, 1, 2, 1, 0.5f, 1, 1},
	{"12 influences", ALL, 20, 3, 0, 4, 0, 0.5f, 1.5f},
	{"32 influences", ALL, 40, 8, 0, 4, 0, 0.5f, 1.5f},
	{"sparse targets", ALL | MOVING_SPARSE, 4, 0, 3, 4, 0, 1, 1},
	{"targets and a skin", ALL | MOVING_NORMALS, 8, 1, 2, 4, 0, 1, 1},
	{"tangents, mirrored", ALL | MOVING_NORMALS | MOVING_MIRROR, 5, 1, 6, 4, 0, 1, 1},
	{"the skinned node moves", ALL | MOVING_OWN, 8, 1, 1, 4, 0, 1, 1},
	{"instances", ALL | MOVING_INSTANCES | MOVING_OWN, 8, 1, 2, 4, 0, 1, 1},
	{"instances, no skin", ALL | MOVING_INSTANCES, 8, 0, 2, 4, 0, 1, 1},
	{"weights by steps", MOVING_STEP, 3, 0, 9, 6, 0, 1, 1},
	{"a chain of 64", ALL | MOVING_CHAIN, 64, 1, 0, 4, 0, 1, 1},
	{"matrices", ALL | MOVING_MATRIX, 10, 1, 0, 4, 0, 1, 1},
	{"normalised integers", ALL | MOVING_SHORT, 8, 2, 0, 4, 0, 1, 1},
};

/* Opens test.glb twice: as it is at rest, and to be played. */
static void open_both(stilb_scene **rest, stilb_scene **scene)
{
	scene_import_limits limits = scene_import_limits_default();
	if (scene_import_within("test.glb", &limits, rest) != STILB_OK ||
	    stilb_scene_open_with("test.glb", &(stilb_scene_open_options){.quiet = true}, scene) != STILB_OK)
		fail_msg("%s", stilb_error_message());
}

/* The time that a play comes to. */
static double time_within(const stilb_scene_play *play, const stilb_scene_animation *a)
{
	double duration = (double)a->clips[play->clip].duration;
	if (play->repeat == STILB_SCENE_ONCE)
		return fmin(fmax(play->time, 0.0), duration);
	double time = duration > 0.0 ? fmod(play->time, duration) : 0.0;
	return time < 0.0 ? time + duration : time;
}

static void play_at(const stilb_scene *rest, stilb_scene *scene, const stilb_scene_play *plays, uint32_t count,
                    const char *name, play_errors *errors)
{
	stilb_scene_play wanted[2];
	stilb_mat4 world = stilb_mat4_identity();
	assert_int_equal(stilb_scene_rest_figure(scene, 0), STILB_OK);
	assert_int_equal(stilb_scene_set_plays(scene, 0, plays, count), STILB_OK);
	stilb_scene_advance(scene, 0.0, NULL, 0);
	stilb_scene_update_nodes(scene, NULL, 0);
	for (uint32_t p = 0; p < count; p++) {
		wanted[p] = plays[p];
		wanted[p].time = time_within(&plays[p], rest->animation);
	}
	play_compare(rest, scene, 0, &world, wanted, count, name, errors);
}

static void play_clips(const stilb_scene *rest, stilb_scene *scene, const char *name, play_errors *errors)
{
	/* Weights of the clips a and b. */
	static const float weights[][2] = {{1, 0}, {0, 1}, {0.25f, 0.75f}, {0.3f, 0.2f}, {1.5f, 0.75f}, {0.4f, 0}};
	const stilb_scene_animation *a = rest->animation;
	assert_int_equal(a->clip_count, 2);
	play_at(rest, scene, NULL, 0, name, errors);
	for (size_t w = 0; w < sizeof weights / sizeof *weights; w++)
		for (int i = 0; i < 9; i++) {
			stilb_scene_play plays[2] = {stilb_scene_play_make(0), stilb_scene_play_make(1)};
			for (int p = 0; p < 2; p++) {
				double duration = (double)a->clips[p].duration;
				const double times[9] = {-1,
				                         0,
				                         duration,
				                         duration + 1,
				                         0.3 * duration,
				                         0.55 * duration,
				                         2.4 * duration,
				                         0.8 * duration,
				                         0.95 * duration};
				plays[p].time = times[(i + 2 * p) % 9];
				plays[p].repeat = (i + p) % 2 ? STILB_SCENE_LOOP : STILB_SCENE_ONCE;
				plays[p].weight = weights[w][p];
			}
			bool second = weights[w][1] > 0.0f;
			play_at(rest, scene, weights[w][0] > 0.0f ? plays : plays + 1, weights[w][0] > 0.0f ? 1 + second : 1, name,
			        errors);
		}
	/* On each key of a channel. */
	for (uint32_t c = 0; c < a->channel_count; c += 1 + a->channel_count / 8)
		for (uint32_t k = 0; k < a->channels[c].key_count; k++) {
			stilb_scene_play play = stilb_scene_play_make(c >= a->clips[1].first_channel);
			play.repeat = STILB_SCENE_ONCE;
			play.time = (double)a->times[a->channels[c].first_time + k];
			play_at(rest, scene, &play, 1, name, errors);
		}
}

static bool files_told;

static void files_look_as_the_reference(void **state)
{
	(void)state;
	play_errors most = {0};
	write_picture("leaf.png");
	for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
		stilb_scene *rest, *scene;
		play_errors errors = {0};
		moving_write(&files[i], 100 + i);
		open_both(&rest, &scene);
		assert_non_null(rest->animation);
		play_clips(rest, scene, files[i].name, &errors);
		if (files_told)
			print_message("%-24s positions %.1e (%s), normals %.1e, tangents %.1e\n", files[i].name, errors.position,
			              errors.where, errors.normal, errors.tangent);
		play_assert(&errors, files[i].name);
		most.position = fmax(most.position, errors.position);
		most.normal = fmax(most.normal, errors.normal);
		most.tangent = fmax(most.tangent, errors.tangent);
		most.vertices += errors.vertices;
		stilb_scene_destroy(rest);
		stilb_scene_destroy(scene);
	}
	remove("leaf.png");
	print_message("%zu files: positions to %.1e of the size, normals to %.1e, tangents to %.1e; %llu vertices\n",
	              sizeof files / sizeof *files, most.position, most.normal, most.tangent,
	              (unsigned long long)most.vertices);
}

int main(int argc, char **argv)
{
	(void)argv;
	files_told = argc > 1;
	const struct CMUnitTest tests[] = {cmocka_unit_test(files_look_as_the_reference)};
	return cmocka_run_group_tests(tests, folder_make, glb_clear);
}
