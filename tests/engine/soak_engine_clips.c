/*
 * A long run of clips in an engine: frames play a file with a skin and morph targets, and figures of the stress test;
 * figures come, change what they play, and go; the file is opened again and again and swapped with the other scene,
 * while both play. Memory must not grow: `cmake --build --preset release --target soak-clips` draws an hour of frames
 * on the null device. "vulkan" draws them, small.
 */
#include "engine.h"
#include "scene/edit/scene_node.h"
#include "scene/play/scene_play.h"
#include "tests/scene/play/glb_moving.h"

#include <malloc.h>

#define ROUND 3000u      /* frames, after which everything is as it was in the round before */
#define SWAP 250u        /* frames that a scene is shown, at least */
#define MOST_FIGURES 12u /* that are added */
#define IN_USE_MAX 16.0  /* the most growth of what malloc has handed out, KiB from one half of the run to the other */
#define RESIDENT_MAX 256.0
#define HOUR_FRAMES 216000ul

static const char usage[] = "usage: soak_engine_clips [FRAMES [null|vulkan]]\n\n"
							"  Draws FRAMES (216000, at least 120000) and prints the memory in use every 3000. Exit "
							"status 0: it did not grow in\n"
							"  the second half, when all arrays have their largest size; 1: it did.\n";

typedef struct soak {
	stilb_engine *engine;
	stilb_scene *file, *stress;
	uint32_t figures[MOST_FIGURES], figure_count; /* added to the file's scene */
	uint64_t ended, edits;
} soak;

static uint32_t below(uint32_t bound)
{
	static uint64_t index;
	return (uint32_t)(stilb_random_u64(22, index++) % bound);
}

static void must(stilb_result result)
{
	if (result == STILB_OK)
		return;
	fprintf(stderr, "soak_engine_clips: %s\n", stilb_error_message());
	exit(1);
}

static void on_end(void *user, uint32_t figure, uint32_t play)
{
	soak *s = user;
	(void)figure;
	(void)play;
	s->ended++;
}

/* Up to three plays of random clips. */
static void play_something(soak *s, stilb_scene *scene, uint32_t figure)
{
	stilb_scene_play plays[3];
	uint32_t count = below(4);
	for (uint32_t p = 0; p < count; p++) {
		plays[p] = stilb_scene_play_make(below(scene->animation->clip_count));
		plays[p].time = 0.01 * below(300);
		plays[p].speed = 0.25f * (float)below(12) - 1.0f;
		plays[p].weight = 0.25f * (float)below(5);
		plays[p].repeat = (stilb_scene_repeat)below(STILB_SCENE_REPEATS);
		plays[p].ended = on_end;
		plays[p].user = s;
	}
	must(stilb_scene_set_plays(scene, figure, plays, count));
}

static void add_figure(soak *s)
{
	stilb_scene_pose place = stilb_scene_pose_identity();
	place.translation[0] = (float)below(8);
	must(stilb_scene_add_figure(s->file, &place, &s->figures[s->figure_count]));
	play_something(s, s->file, s->figures[s->figure_count++]);
}

static void remove_figure(soak *s, uint32_t which)
{
	must(stilb_scene_remove_figure(s->file, s->figures[which]));
	s->figures[which] = s->figures[--s->figure_count];
}

/* What a program does between two frames. */
static void soak_edit(soak *s)
{
	uint32_t any = below(s->figure_count + 1), figure = any < s->figure_count ? s->figures[any] : 0;
	stilb_scene_rates rates = {.angle = 0.02f * (float)below(3), .still = 0.001f * (float)below(3)};
	s->edits++;
	switch (below(12)) {
	case 0:
	case 1:
		if (s->figure_count < MOST_FIGURES)
			add_figure(s);
		break;
	case 2:
		if (any < s->figure_count)
			remove_figure(s, any);
		break;
	case 3:
		must(stilb_scene_rest_figure(s->file, figure));
		break;
	case 4:
		must(stilb_scene_set_rates(s->file, &rates));
		break;
	case 5:
		must(stilb_scene_set_node_pose(s->file, stilb_scene_figure_node(s->file, figure, 1 + below(8)),
		                               &(stilb_scene_pose){{0, 1, 0}, {0, 0, 0, 1}, {1, 1, 1}}));
		break;
	case 6:
		play_something(s, s->stress, 1 + below(3));
		break;
	case 7:
		must(stilb_scene_sweep(s->file, below(2)));
		break;
	default:
		play_something(s, s->file, figure);
		break;
	}
}

static void soak_open(soak *s)
{
	must(stilb_scene_open_with("test.glb", &(stilb_scene_open_options){.quiet = true}, &s->file));
	s->figure_count = 0;
}

/* Shows the other scene. The file's is opened anew while it is not shown; afresh: and then shown. */
static void soak_swap(soak *s, bool afresh)
{
	if (stilb_engine_scene(s->engine) == s->file || afresh) {
		must(stilb_engine_set_scene(s->engine, s->stress));
		stilb_scene_destroy(s->file);
		soak_open(s);
	}
	if (stilb_engine_scene(s->engine) != s->file && (afresh || below(2) == 0))
		must(stilb_engine_set_scene(s->engine, s->file));
}

static void soak_start(soak *s, bool draws)
{
	static const moving_file moving = {
		"", MOVING_STEP | MOVING_LINEAR | MOVING_CUBIC | MOVING_NORMALS | MOVING_OWN, 12, 2, 3, 9, 0, 0.5f, 1.5f};
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.device = draws ? STILB_RENDER_DEVICE_VULKAN : STILB_RENDER_DEVICE_NULL;
	desc.workers = 1;
	desc.profile = false;
	desc.width = 64;
	desc.height = 36;
	moving_write(&moving, 5);
	write_picture("leaf.png");
	soak_open(s);
	must(stilb_scene_create_stress(20, 7, &s->stress));
	must(stilb_scene_stress_add_figures(s->stress, 4));
	must(stilb_engine_create(&desc, &s->engine));
	must(stilb_engine_set_scene(s->engine, s->file));
}

/* ---- memory ------------------------------------------------------------------------------------------------------ */

static double resident_kib(void)
{
	long pages = 0;
	FILE *file = fopen("/proc/self/statm", "r");
	if (!file || fscanf(file, "%*d %ld", &pages) != 1)
		pages = 0;
	if (file)
		fclose(file);
	return (double)pages * (double)sysconf(_SC_PAGESIZE) / 1024.0;
}

/* What malloc has handed out, KiB, in a state that all rounds come to: a file that was just opened, and shown. */
static double in_use_kib(void)
{
	struct mallinfo2 info = mallinfo2();
	return (double)(info.uordblks + info.hblkhd) / 1024.0;
}

/* The most of each half of the run, KiB: drivers keep now more, now less, so that single values say little. */
typedef struct peaks {
	double in_use[2], resident[2];
} peaks;

int main(int argc, char **argv)
{
	unsigned long frames = argc > 1 ? strtoul(argv[1], NULL, 10) : HOUR_FRAMES;
	bool draws = argc > 2 && strcmp(argv[2], "vulkan") == 0;
	if (argc > 3 || frames < 40 * ROUND || (argc > 2 && !draws && strcmp(argv[2], "null") != 0)) {
		fputs(usage, stderr);
		return 2;
	}
	soak s = {0};
	peaks most = {{0}, {0}};
	if (folder_make(NULL) != 0)
		return 1;
	soak_start(&s, draws);
	for (unsigned long frame = 1; frame <= frames; frame++) {
		stilb_engine_report report;
		must(stilb_engine_frame(s.engine, &report));
		if (below(3) == 0)
			soak_edit(&s);
		if (frame % SWAP == 0)
			soak_swap(&s, frame % ROUND == 0);
		if (frame % ROUND > 0)
			continue;
		int half = frame > frames / 2;
		double kib = in_use_kib(), pages = resident_kib();
		printf("%7lu frames: %.2f KiB in use, %.0f KiB resident\n", frame, kib, pages);
		fflush(stdout);
		most.in_use[half] = fmax(most.in_use[half], kib);
		most.resident[half] = fmax(most.resident[half], pages);
	}
	stilb_engine_destroy(s.engine);
	stilb_scene_destroy(s.file);
	stilb_scene_destroy(s.stress);
	folder_clear();
	folder_remove();
	double in_use = most.in_use[1] - most.in_use[0], resident = most.resident[1] - most.resident[0];
	printf("%lu frames, %llu edits, %llu ends of clips: the second half had %.1f KiB more in use, %.0f more resident\n",
	       frames, (unsigned long long)s.edits, (unsigned long long)s.ended, in_use, resident);
	return in_use <= IN_USE_MAX && resident <= RESIDENT_MAX ? 0 : 1;
}
