/* The stilb program without a GPU: help, refusals, full disks, interrupts, and the numbers of the null device. */
#include "support/stilb_program.h"

#define SMALL "demo --headless --device null --models 400 --size 320x180 --frames 5 "

/* ---- words ------------------------------------------------------------------------------------------------------- */

static void test_help_and_version(void **state)
{
	(void)state;
	stilb_good("--version");
	assert_int_equal(program_lines(run.out), 1);
	assert_memory_equal(run.out, "stilb ", 6);
	stilb_good("--help");
	assert_said(run.out, "demo");
	assert_said(run.out, "info");
	assert_said(run.out, "bench");
	assert_int_equal(stilb_code(no_display, "rendr cornell"), 2);
	assert_error_lines(1);
	assert_said(run.err, "unknown command 'rendr'; did you mean 'stilb render'?");
	stilb_good("demo --help");
	static const char *const flags[] = {"--models",
	                                    "--workers",
	                                    "--frames",
	                                    "--headless",
	                                    "--no-present",
	                                    "--animate",
	                                    "--validate",
	                                    "--size",
	                                    "--view",
	                                    "--cull",
	                                    "--replay",
	                                    "--device",
	                                    "--gpu",
	                                    "--msaa",
	                                    "--seed",
	                                    "--screenshot",
	                                    "--trace",
	                                    "--stats",
	                                    "--materials",
	                                    "--fault",
	                                    "--capture",
	                                    "--spike",
	                                    "--ui-aa",
	                                    "--overlay",
	                                    "--profile-ring",
	                                    "--no-profile",
	                                    "--brdf",
	                                    "--ndf",
	                                    "--g",
	                                    "--f",
	                                    "--light-model",
	                                    "--inspector",
	                                    "--roughness",
	                                    "--wrap",
	                                    "--anisotropy",
	                                    "--specular",
	                                    "--gamepad",
	                                    "--track",
	                                    "--invert-y",
	                                    "--sensitivity",
	                                    "--watch-shaders",
	                                    "--shaders",
	                                    "--max-anisotropy",
	                                    "--wait-textures"};
	for (size_t i = 0; i < sizeof flags / sizeof *flags; i++) {
		char line[32];
		snprintf(line, sizeof line, "\n  %s ", flags[i]);
		assert_said(run.out, line);
	}
	for (const char *at = run.out, *end; (end = strchr(at, '\n')); at = end + 1)
		assert_true(end - at <= 110); /* columns of a usual terminal window */
	stilb_good("info --help");
	assert_said(run.out, "--json");
	assert_int_equal(folder_entries(), 0);
}

static void test_words_that_cannot_be_written(void **state)
{
	(void)state;
	static const char *const lines[] = {"--version", "--help", "demo --help", SMALL};
	for (size_t i = 0; i < 4; i++) {
		int full = open("/dev/full", O_WRONLY | O_CLOEXEC);
		stilb_start(no_display, full, lines[i]);
		program_wait(&run);
		close(full);
		assert_int_equal(run.code, 1);
		assert_error_lines(1);
		assert_said(run.err, "standard output");
	}
}

/* The table of materials is the one that docs/materials.md has. */
static void test_info_of_materials(void **state)
{
	(void)state;
	static char text[65536];
	stilb_good("info --materials");
	FILE *file = fopen(SOURCE_FOLDER "/docs/materials.md", "r");
	assert_non_null(file);
	text[fread(text, 1, sizeof text - 1, file)] = '\0';
	fclose(file);
	assert_true(strlen(run.out) > 500);
	assert_non_null(strstr(text, run.out));
}

static void test_info_of_a_scene(void **state)
{
	(void)state;
	stilb_good("info cornell");
	assert_said(run.out, "  1 model of 4 parts; 4 meshes with 38 triangles and 76 vertices\n");
	assert_said(run.out, "  from 0, 0, 0 to 1, 1, 1 m\n");
	assert_said(run.out, "lights: 1 rectangle\n  surroundings: black\n"); /* once, though its face emits */
	stilb_good("info furnace:0.5");
	assert_said(run.out, "lights: 320 emitting triangles\n");
	assert_said(run.out, "only in traced pictures, not in live ones: light from emitting triangles\n");
	stilb_good("info spheres --json a.json");
	assert_said(run.out, "drawn as 143364 triangles");
	assert_said(run.out, "texture 0: 256x256, 3 channels of 8 bits\n");
	read_stats("a.json");
	assert_int_equal(stat_int("triangles"), 20484);
	assert_int_equal(stat_int("drawn_triangles"), 143364);
	assert_int_equal(stat_int("materials"), 9);
	assert_int_equal(stilb_code(NULL, "info stress --json -"), 0);
	assert_said(run.err, "lights: 1 directional\n");
	assert_said(run.out, "\"not_live\": []");
	assert_int_equal(stilb_code(NULL, "info missing.gltf"), 2);
	assert_error_lines(1);
	assert_said(run.err, "missing.gltf");
	FILE *file = fopen("one.obj", "w");
	fputs("v 0 0 0\nv 2 0 0\nv 0 3 0\nvn 0 0 1\nf 1//1 2//1 3//1\n", file);
	assert_int_equal(fclose(file), 0);
	assert_int_equal(stilb_code(NULL, "info one.obj"), 0);
	assert_said(run.out, "1 mesh with 1 triangle and 3 vertices; 2 nodes\n");
	assert_said(run.out, "from 0, 0, 0 to 2, 3, 0 m");
	assert_said(run.out, "lights: none\n  nothing lights it: pictures show it in a studio");
	assert_int_equal(stilb_code(NULL, "info one.obj --json /dev/full"), 1);
	assert_error_lines(1); /* the full disk */
}

/* What models of a file differ in is counted. */
static void test_info_of_flags(void **state)
{
	(void)state;
	FILE *file = fopen("flags.gltf", "w");
	fputs("{\"asset\":{\"version\":\"2.0\"},\"nodes\":[{\"mesh\":0,\"extras\":{\"seen\":false}},"
	      "{\"mesh\":0,\"extras\":{\"seen\":false,\"receiveShadow\":false}},{\"mesh\":0}],"
	      "\"scenes\":[{\"nodes\":[0,1,2]}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],"
	      "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}],"
	      "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],\"buffers\":[{\"byteLength\":36,\"uri\":"
	      "\"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA\"}]}",
	      file);
	assert_int_equal(fclose(file), 0);
	stilb_good("info flags.gltf --json flags.json");
	assert_said(run.out, "  models: 2 unseen, 1 on which no shadow falls\n");
	read_stats("flags.json");
	assert_int_equal(stat_int("unseen_models"), 2);
	assert_int_equal(stat_int("shadowless_models"), 0);
	assert_int_equal(stat_int("unshadowed_models"), 1);
	stilb_good("info cornell");
	assert_null(strstr(run.out, "models:"));
}

static void test_info(void **state)
{
	(void)state;
	assert_int_equal(stilb_code(no_driver, "info"), 0); /* without Vulkan too */
	assert_string_equal(run.err, "");
	assert_said(run.out, "CPU:");
	assert_said(run.out, "mesa-vulkan-drivers");
	assert_said(run.out, "OpenImageIO");
	assert_int_equal(stilb_code(no_driver, "info --json -"), 0);
	json_flat_finish(&stats);
	assert_true(json_flat_text(run.out, strlen(run.out), &stats)); /* nothing but JSON on stdout */
	assert_string_not_equal(stat_text("version", '"'), "");
	assert_true(stat_int("cpu.usable") >= 1);
	stat_text("cpu.name", '"');
	stat_text("cpu.features.avx2", 'w');
	stat_text("gpus", '[');
	assert_null(json_flat_find(&stats, "gpus[0]"));
	stat_text("libraries.Vulkan loader", '"');
	assert_int_equal(stilb_code(no_driver, "info --json info.json"), 0);
	read_stats("info.json");
	stat_text("libraries.GLFW", '"');
	assert_int_equal(stilb_code(no_driver, "info --json /dev/full"), 1);
	assert_error_lines(1);
	assert_int_equal(folder_entries(), 1);
}

/* ---- refused ----------------------------------------------------------------------------------------------------- */

/* Command lines that are refused, and a part of the message. */
static const char *const refusals[][2] = {
	{"", "no command"},
	{"bogus", "'bogus'"},
	{"{}", "''"},
	{"demo --bogus", "'--bogus'"},
	{"demo extra", "'extra'"},
	{"demo --models -1", "'-1'"},
	{"demo --models 0", "1..4000000"},
	{"demo --models 5000000000", "1..4000000"},
	{"demo --models banana", "'banana'"},
	{"demo --models {}", "--models"},
	{"demo --models", "missing"},
	{"demo --size 0x0", "'0x0'"},
	{"demo --size 1x", "'1x'"},
	{"demo --size 99999x1", "16384"},
	{"demo --workers 999999999", "0..256"},
	{"demo --workers -1", "'-1'"},
	{"demo --frames 0", "1..1000000"},
	{"demo --msaa 2", "1 or 4"},
	{"demo --max-anisotropy 17", "1..16"},
	{"view --specular-aa on", "vmf, toksvig, off"},
	{"view --ambient dim", "'dim' is not one of: environment, none, constant, hemisphere, sh-vertex, sh-pixel"},
	{"demo --ambient=", "--ambient"},
	{"demo --view sideways", "all, half, few"},
	{"demo --device none", "vulkan, null"},
	{"demo --gpu {}", "--gpu"},
	{"demo --animate=1", "no value"},
	{"demo --stats {}", "--stats"},
	{"demo --screenshot=", "--screenshot"},
	{"demo --screenshot a.bmp", ".png, .exr or .hdr"},
	{"demo --screenshot a", ".png, .exr or .hdr"},
	{"demo --screenshot missing/a.png", "does not exist"},
	{"demo --screenshot folder.png", "folder"},
	{"demo --device null --screenshot a.png", "null device"},
	{"demo --stats missing/a.json", "does not exist"},
	{"demo --trace missing/a.json", "'missing/a.json'"},
	{"demo --trace plain/a.json", "file"},
	{"demo --stats good.json --trace missing/a.json", "'missing/a.json'"},
	{"demo --stats a.json --trace a.json", "two outputs"},
	{"demo --stats ./a.json --trace folder.png/../a.json", "two outputs"},
	{"demo --stats - --trace /dev/stdout", "two outputs"},
	{"demo --capture a.json --trace a.json", "two outputs"},
	{"demo --capture missing/a.json", "does not exist"},
	{"demo --capture -", "--capture"},
	{"demo --trace x.foo", "--trace: 'x.foo' is not the name of a trace; give one that ends in .json, .folded or .csv"},
	{"demo --trace trace", ".json, .folded or .csv"},
	{"demo --trace csv", ".json, .folded or .csv"},
	{"demo --capture x.foo", "--capture: 'x.foo' is not the name of a trace"},
	{"render cornell -o x.png --trace x.foo", "--trace: 'x.foo' is not the name of a trace"},
	{"demo --spike never", "'never'"},
	{"demo --spike 0", "off, auto"},
	{"demo --spike -5", "'-5'"},
	{"demo --spike 1e99", "'1e99'"},
	{"demo --profile-ring 3", "power of two"},
	{"demo --profile-ring 2048", "1..1024"},
	{"demo --no-profile --trace a.json", "--no-profile"},
	{"demo --no-profile --spike auto", "--no-profile"},
	{"demo --ui-aa soft", "feather, article, off"},
	{"demo --brdf none",
     "lambert, wrapped, phong, phong-modified, blinn-phong, blinn-phong-modified, minimalist, microfacet"},
	{"demo --ndf none", "blinn, beckmann, ggx, ggx-anisotropic"},
	{"demo --g none",
     "implicit, neumann, cook-torrance, kelemen, smith-beckmann, smith-ggx, schlick-beckmann, schlick-ggx"},
	{"demo --f any", "none, schlick, cook-torrance"},
	{"demo --light-model moon", "sun, hemisphere, sphere, disk, windowed, subtracted"},
	{"demo --brdf phong --f schlick", "parts of --brdf microfacet"},
	{"demo --g kelemen --brdf blinn-phong", "blinn-phong has no D, G and F"},
	{"demo --roughness 1.01", "-1..1"},
	{"demo --wrap wide", "'wide'"},
	{"demo --anisotropy {}", "--anisotropy"},
	{"demo --specular", "missing"},
	{"demo --fault slow:0", "slow:N"},
	{"info --bogus", "'--bogus'"},
	{"info --json missing/a.json", "does not exist"},
};

static void test_refusals(void **state)
{
	(void)state;
	assert_int_equal(mkdir("folder.png", 0777), 0);
	FILE *plain = fopen("plain", "w");
	assert_non_null(plain);
	fclose(plain);
	for (size_t i = 0; i < sizeof refusals / sizeof *refusals; i++) {
		int code = stilb_code(no_display, refusals[i][0]);
		if (code != 2)
			print_error("stilb %s: %s", refusals[i][0], run.err);
		assert_int_equal(code, 2);
		assert_string_equal(run.out, "");
		assert_error_lines(1);
		assert_said(run.err, refusals[i][1]);
		assert_int_equal(folder_entries(), 2); /* no new file */
	}
}

/* Runs a copy of stilb that lies in the present folder. */
static int alone_code(const char *line)
{
	char home[PATH_MAX], command[PATH_MAX + 32];
	memcpy(home, stilb_path, sizeof home);
	snprintf(command, sizeof command, "cp '%s' alone", home);
	assert_int_equal(system(command), 0);
	assert_non_null(realpath("alone", stilb_path));
	int code = stilb_code(no_display, line);
	memcpy(stilb_path, home, sizeof home);
	return code;
}

static void test_bench_is_another_program(void **state)
{
	(void)state;
	assert_int_equal(alone_code("bench queue"), 2);
	assert_error_lines(1);
	assert_said(run.err, "stilb-bench");
	assert_said(run.err, "./dev build");
	FILE *other = fopen("stilb-bench", "w");
	assert_non_null(other);
	fputs("#!/bin/sh\nprintf '<%s>' \"$@\"\nexit 5\n", other);
	fclose(other);
	assert_int_equal(chmod("stilb-bench", 0755), 0);
	assert_int_equal(alone_code("bench queue --json {} --quick"), 5);
	assert_string_equal(run.out, "<queue><--json><><--quick>");
	assert_string_equal(run.err, "");
}

/* A copy of the program without the modules that it loads from ../lib/stilb runs and writes pictures; for foreign
 * formats it names the missing folder. */
static void test_pictures_need_no_module(void **state)
{
	(void)state;
	assert_int_equal(alone_code(SMALL), 0);
	assert_int_equal(alone_code("shade spheres --size 64x64 -o a.png"), 0);
	assert_int_equal(alone_code("shade spheres --size 64x64 -o a.exr"), 0);
	assert_int_equal(alone_code("shade spheres --size 64x64 -o a.hdr"), 0);
	assert_int_equal(folder_entries(), 4);
	FILE *picture = fopen("a.gif", "w");
	assert_non_null(picture);
	fputs("GIF89a", picture);
	fclose(picture);
	assert_int_equal(alone_code("render cornell --environment a.gif --size 16x16 -o b.png"), 2);
	assert_error_lines(1);
	assert_said(run.err, "../lib/stilb");
}

static void test_no_driver(void **state)
{
	(void)state;
	assert_int_equal(stilb_code(no_driver, "demo --headless --models 1 --size 8x8 --frames 1 --stats a.json"), 2);
	assert_error_lines(1);
	assert_said(run.err, "mesa-vulkan-drivers");
	assert_said(run.err, "--device null");
	assert_string_equal(run.out, "");
	assert_int_equal(folder_entries(), 0);
	assert_int_equal(stilb_code(no_driver, "demo --models 1 --size 8x8 --frames 1"),
	                 2); /* refused, also if a window was wanted */
	assert_said(run.err, "mesa-vulkan-drivers");
	assert_int_equal(stilb_code(no_driver, SMALL), 0);
	assert_string_equal(run.err, "");
}

/* ---- what it writes ---------------------------------------------------------------------------------------------- */

static void test_full_disk(void **state)
{
	(void)state;
	assert_int_equal(stilb_code(no_display, SMALL "--stats /dev/full"), 1);
	assert_error_lines(1);
	assert_said(run.err, "/dev/full");
	assert_int_equal(stilb_code(no_display, SMALL "--trace /dev/full"), 1);
	assert_error_lines(1);
	assert_int_equal(stilb_code(no_display, SMALL "--trace /dev/full --stats a.json"), 1);
	assert_error_lines(1);
	read_stats("a.json"); /* the other output is written all the same */
	assert_int_equal(stilb_code(no_display, SMALL "--trace /dev/full --stats /dev/full"), 1);
	assert_error_lines(2);
	assert_int_equal(folder_entries(), 1);
}

/* If standard output is a closed pipe, only the output that goes there fails; the other file is still written. */
static void test_closed_pipe(void **state)
{
	(void)state;
	int ends[2];
	assert_int_equal(pipe2(ends, O_CLOEXEC), 0);
	close(ends[0]);
	stilb_start(no_display, ends[1], SMALL "--trace t.json --stats -");
	program_wait(&run);
	assert_int_equal(run.code, 1);
	assert_said(run.err, "stilb: cannot write '-': ");
	assert_said(run.err, strerror(EPIPE));
	assert_trace("t.json", 1, 5);
	stilb_start(no_display, ends[1], "--help");
	program_wait(&run);
	assert_int_equal(run.code, 1);
	assert_error_lines(1);
	close(ends[1]);
}

static void test_stats_of_the_null_device(void **state)
{
	(void)state;
	stilb_good(SMALL "--workers 1 --stats a.json --trace t.json");
	assert_said(run.out, "bound by: ");
	assert_said(run.out, "stats: a.json");
	assert_said(run.out, "trace: t.json");
	read_stats("a.json");
	assert_stats("null", "indirect", "auto", 400, 1, 5);
	assert_int_equal(stat_int("visible"), 400);
	assert_stages(true);
	assert_trace("t.json", 1, 5);
	stilb_good(
		"demo --headless --device=null --models=7 --size=1x1 --frames=31 --replay=direct --cull=flat --workers=0 "
		"--no-present --seed=0 --gpu=ignored --msaa=1 --stats=b.json");
	read_stats("b.json");
	assert_stats("null", "direct", "flat", 7, 0, 31);
	assert_stages(false);
	stilb_good("demo --headless --device null --models 1 --frames 1 --size 16384x1 --workers 256 --shadows off --stats "
	           "c.json");
	read_stats("c.json");
	assert_stats("null", "indirect", "auto", 1, 256, 1);
	assert_int_equal(folder_entries(), 4); /* no temporary file */
}

static void test_stats_to_standard_output(void **state)
{
	(void)state;
	assert_int_equal(stilb_code(no_display, SMALL "--workers auto --stats -"), 0);
	json_flat_finish(&stats);
	json_flat_text(run.out, strlen(run.out), &stats); /* nothing but JSON */
	assert_string_equal(stats.error, "");
	assert_true(stat_int("workers") >= 1);
	assert_said(run.err, "bound by: ");
	assert_int_equal(folder_entries(), 0);
}

static void test_defaults(void **state)
{
	(void)state;
	stilb_good("demo --device null --stats a.json");
	read_stats("a.json");
	assert_stats("null", "indirect", "auto", 10000, stat_int("workers"), 120);
	assert_int_equal(stat_int("visible"), 10000);
	assert_true(stat_int("workers") >= 1);
}

/* STILB_ISA selects the instruction set, which does not change the draws (their hash stays the same); an unknown one is
 * refused at the start. */
static void test_isa(void **state)
{
	(void)state;
	char hash[32];
	setenv("STILB_ISA", "scalar", 1);
	stilb_good("demo --device null --models 500 --view half --stats a.json");
	read_stats("a.json");
	snprintf(hash, sizeof hash, "%s", stat_text("stream_hash", '"'));
	unsetenv("STILB_ISA");
	stilb_good("demo --device null --models 500 --view half --stats a.json");
	read_stats("a.json");
	assert_string_equal(stat_text("stream_hash", '"'), hash);
	setenv("STILB_ISA", "avx3", 1);
	assert_int_equal(stilb_code(NULL, "demo --device null"), 2);
	unsetenv("STILB_ISA");
	assert_error_lines(1);
	assert_said(run.err, "STILB_ISA=avx3");
	assert_said(run.err, "avx512");
}

/* Any method of culling, recording and replay gives the same draws, whose hash is the stream hash; another seed or
 * moving models give other draws. */
static void test_stream_hash(void **state)
{
	(void)state;
	static const char *const same[] = {"--workers 0",
	                                   "--workers 1",
	                                   "--workers 2",
	                                   "--workers 3",
	                                   "--workers 8",
	                                   "--workers 0 --cull flat",
	                                   "--workers 2 --cull flat",
	                                   "--workers 2 --cull octree",
	                                   "--workers 8 --replay direct",
	                                   "--workers 0 --replay direct --cull flat",
	                                   "--workers 2 --no-present"};
	static const char *const others[] = {"",
	                                     "--animate",
	                                     "--seed 2",
	                                     "--animate --seed 2",
	                                     "--view half",
	                                     "--view few",
	                                     "--animate --frames 6",
	                                     "--models 401",
	                                     "--brdf lambert",
	                                     "--brdf microfacet",
	                                     "--ndf ggx-anisotropic",
	                                     "--g neumann",
	                                     "--f none",
	                                     "--light-model disk"};
	enum { SAME = sizeof same / sizeof *same, OTHERS = sizeof others / sizeof *others };
	uint64_t hashes[OTHERS];
	for (size_t o = 0; o < OTHERS; o++) {
		for (size_t i = 0; i < (o < 2 ? SAME : 1); i += 1 + o) {
			stilb_good(SMALL "%s %s --stats a.json", same[i], others[o]);
			uint64_t hash = stat_hash("a.json");
			assert_true(i == 0 || hash == hashes[o]);
			hashes[o] = hash;
		}
		for (size_t k = 0; k < o; k++)
			assert_true(hashes[k] != hashes[o]);
	}
}

/* Shadows are there unless they are refused, and --stats has what the device's kind makes of them. */
static void test_shadows(void **state)
{
	(void)state;
	char hash[32];
	stilb_good(SMALL "--stats a.json");
	read_stats("a.json");
	assert_string_equal(stat_text("shadows.kind", '"'), "map");
	assert_int_equal(stat_int("shadows.cascades"), 4);
	assert_int_equal(stat_int("shadows.cascade_size"), 2048);
	assert_int_equal(stat_int("shadows.samples"), 16);
	assert_int_equal(stat_int("shadows.maps"), 4);
	assert_int_equal(stat_int("shadows.drawn"), 0); /* nothing moves */
	assert_int_equal(stat_int("shadows.lights_left_out"), 0);
	assert_said(run.out, "shadows: 4 maps, 0 of them drawn in the last frame; 4 cascades of 2048 texels\n");
	snprintf(hash, sizeof hash, "%s", stat_text("stream_hash", '"'));
	stilb_good(SMALL "--shadows map --cascades 2 --cascade-size 512 --shadow-samples 4 --animate --stats a.json");
	read_stats("a.json");
	assert_int_equal(stat_int("shadows.cascades"), 2);
	assert_int_equal(stat_int("shadows.cascade_size"), 512);
	assert_int_equal(stat_int("shadows.samples"), 4);
	assert_in_range(stat_int("shadows.drawn"), 1, 2); /* those that something moves in */
	/* What casts none is named. */
	stilb_good(SMALL "--lights 20 --lighting combined --frames 1 --stats a.json");
	assert_said(run.out, "shadows: the sum of a model's further lights: none\n");
	assert_int_equal(stilb_code(NULL, SMALL "--lights 200 --frames 1 --stats a.json"), 0);
	read_stats("a.json");
	assert_true(stat_int("shadows.lights_left_out") > 100);
	assert_said(run.err, "lights that are seen cast no shadow (number ");
	assert_error_lines(1);
	stilb_good(SMALL "--frames 1 --shadows off --stats b.json");
	read_stats("b.json");
	assert_string_equal(stat_text("shadows.kind", '"'), "off");
	assert_string_equal(stat_text("stream_hash", '"'), hash);
	assert_false(strstr(run.out, "shadows:"));
	stilb_good(SMALL "--frames 1 --stats a.json"); /* the first frame draws the maps */
	read_stats("a.json");
	assert_int_equal(stat_int("shadows.drawn"), 4);
	assert_string_equal(stat_text("stream_hash", '"'), hash); /* which leaves maps out, drawn or not */
}

static void test_views(void **state)
{
	(void)state;
	long long visible[3];
	static const char *const views[] = {"all", "half", "few"};
	for (int i = 0; i < 3; i++) {
		stilb_good("demo --headless --device null --frames 1 --shadows off --view %s --stats a.json", views[i]);
		read_stats("a.json");
		visible[i] = stat_int("visible");
		assert_int_equal(stat_int("draws"), 2 * visible[i]);
	}
	assert_int_equal(visible[0], 10000);
	assert_in_range(visible[1], 4500, 5500);
	assert_in_range(visible[2], 50, 200);
}

/* ---- interrupts -------------------------------------------------------------------------------------------------- */

static void test_interrupts_end_it_well(void **state)
{
	(void)state;
	const int signals[] = {SIGINT, SIGTERM};
	for (int i = 0; i < 2; i++) {
		stilb_start(
			no_display, -1,
			"demo --headless --device null --models 100 --frames 1000000 --workers 1 --stats a.json --trace t.json");
		bool ready = catches_interrupts(run.pid);
		kill(run.pid, ready ? signals[i] : SIGKILL);
		program_wait(&run);
		assert_true(ready);
		assert_int_equal(run.code, 0);
		assert_string_equal(run.err, "");
		assert_said(run.out, i == 0 ? "stopped by SIGINT after " : "stopped by SIGTERM after ");
		assert_said(run.out, " of 1000000 frames\n");
		assert_said(run.out, "bound by: ");
		read_stats("a.json");
		assert_in_range(stat_int("frames"), 1, 999999);
		trace_check_report report;
		trace_check_file("t.json", &report);
		assert_string_equal(report.error, "");
		trace_check_finish(&report);
		assert_int_equal(folder_entries(), 2);
	}
}

/* A long headless run shows its progress on a terminal, and clears the line at its end. */
static void test_progress_on_a_terminal(void **state)
{
	(void)state;
	static char said[65536];
	size_t length = 0;
	int master = posix_openpt(O_RDWR | O_NOCTTY), status;
	assert_true(master >= 0 && grantpt(master) == 0 && unlockpt(master) == 0);
	int terminal = open(ptsname(master), O_RDWR | O_NOCTTY);
	assert_true(terminal >= 0);
	pid_t pid = fork();
	assert_true(pid >= 0);
	if (pid == 0) {
		dup2(terminal, STDERR_FILENO);
		dup2(open("/dev/null", O_WRONLY), STDOUT_FILENO);
		close(terminal);
		close(master);
		setenv("TERM", "xterm", 1);
		execl(stilb_path, stilb_path, "demo", "--headless", "--device", "null", "--frames", "1000000", NULL);
		_exit(127);
	}
	close(terminal);
	bool stopped = false;
	for (ssize_t got; (got = read(master, said + length, sizeof said - 1 - length)) > 0;) {
		length += (size_t)got;
		if (!stopped && strstr(said, " of 1000000 frames, ") && strstr(said, " s left\033[K"))
			stopped = kill(pid, SIGINT) == 0;
	}
	close(master);
	assert_int_equal(waitpid(pid, &status, 0), pid);
	assert_int_equal(status, 0);
	assert_true(stopped);
	assert_true(length >= 4 && strcmp(said + length - 4, "\r\033[K") == 0);
}

#define FRESH_TEST(name) cmocka_unit_test_setup(name, folder_fresh)

int main(int argc, char **argv)
{
	const struct CMUnitTest tests[] = {
		FRESH_TEST(test_help_and_version),
		FRESH_TEST(test_words_that_cannot_be_written),
		FRESH_TEST(test_info),
		FRESH_TEST(test_info_of_materials),
		FRESH_TEST(test_info_of_a_scene),
		FRESH_TEST(test_info_of_flags),
		FRESH_TEST(test_refusals),
		FRESH_TEST(test_bench_is_another_program),
		FRESH_TEST(test_pictures_need_no_module),
		FRESH_TEST(test_no_driver),
		FRESH_TEST(test_full_disk),
		FRESH_TEST(test_closed_pipe),
		FRESH_TEST(test_stats_of_the_null_device),
		FRESH_TEST(test_stats_to_standard_output),
		FRESH_TEST(test_defaults),
		FRESH_TEST(test_isa),
		FRESH_TEST(test_stream_hash),
		FRESH_TEST(test_shadows),
		FRESH_TEST(test_views),
		FRESH_TEST(test_interrupts_end_it_well),
		FRESH_TEST(test_progress_on_a_terminal),
	};
	if (argc != 2 || !folder_enter(argv[1], "test_game_cli")) {
		fprintf(stderr, "usage: test_game_cli STILB\n");
		return 1;
	}
	return cmocka_run_group_tests(tests, NULL, folder_leave);
}
