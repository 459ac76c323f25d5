/* --animation, --at, --frames and --shutter of `stilb render` against files that stand still in the same pose. With the
 * argument "view" those of `stilb view --headless`, which needs a device. */
#include "image/image.h"
#include "support/stilb_program.h"

#include <math.h>
#include <stdarg.h>
#include <sys/resource.h>

#define WIDTH 48
#define HEIGHT 32
#define SIZE "--size 48x32 --environment 1,1,1 " /* no studio, whose lights stand around the pose of the file */
#define SHARP                                                                                                          \
	"--integrator direct --spp 64 " /* of materials without light: a picture has the noise of its edges alone */
#define BLUR_BOUND 0.002
#define VIEW_BOUND 0.009

/* ---- files ------------------------------------------------------------------------------------------------------- */

/* A pose that a file has at rest. All numbers are sums of few powers of two, so that a clip's are exact. */
typedef struct pose {
	float moves;          /* x of the node of the upper square */
	float morphs;         /* weight of the target of the middle one, which moves it by 1 along x */
	float bone;           /* x of the joint of the lower one */
	float turn_z, turn_w; /* rotation of the upper one */
} pose;

static const pose rest = {.moves = -1.5f, .turn_w = 1.0f};

/* The pose of the clip "slide" after that part of its second. */
static pose slid(float part)
{
	return (pose){.moves = -1.0f + 2.0f * part, .morphs = part, .bone = 0.5f * part, .turn_w = 1.0f};
}

/* Numbers of a file. */
typedef struct buffer {
	float corners[4][3], normals[4][3], target[4][3], weights[4][4];
	float seconds[2], moves[2][3], morphs[2], bone[2][3], turns[2][4];
	uint16_t indices[6];
	uint8_t joints[4][4];
} buffer;

#define HALF_ROOT 0.707106781f

static const buffer numbers = {
	.corners = {{-0.5f, -0.25f, 0.0f}, {0.5f, -0.25f, 0.0f}, {0.5f, 0.25f, 0.0f}, {-0.5f, 0.25f, 0.0f}},
	.normals = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {0, 0, 1}},
	.target = {{1, 0, 0}, {1, 0, 0}, {1, 0, 0}, {1, 0, 0}},
	.weights = {{1, 0, 0, 0}, {1, 0, 0, 0}, {1, 0, 0, 0}, {1, 0, 0, 0}},
	.seconds = {0, 1},
	.moves = {{-1, 0.75f, 0}, {1, 0.75f, 0}},
	.morphs = {0, 1},
	.bone = {{0, -0.75f, 0}, {0.5f, -0.75f, 0}},
	.turns = {{0, 0, HALF_ROOT, HALF_ROOT}, {0, 0, 0, 1}},
	.indices = {0, 1, 2, 0, 2, 3},
};

/* Writes text in which ' stands for ". */
__attribute__((format(printf, 2, 3))) static void say(FILE *file, const char *format, ...)
{
	char text[2048];
	va_list arguments;
	va_start(arguments, format);
	int length = vsnprintf(text, sizeof text, format, arguments);
	va_end(arguments);
	assert_true(length >= 0 && (size_t)length < sizeof text);
	for (char *at = text; *at; at++)
		fputc(*at == '\'' ? '"' : *at, file);
}

/* What a file's buffer holds: an accessor each, of these numbers in this order. */
static const struct {
	size_t offset, size;
	int type, count;
	const char *shape, *rest;
} accessors[] = {
#define FLOATS(member, count, shape, rest)                                                                             \
	{                                                                                                                  \
		offsetof(buffer, member), sizeof numbers.member, 5126, count, shape, rest                                      \
	}
	FLOATS(corners, 4, "VEC3", ",'min':[-0.5,-0.25,0],'max':[0.5,0.25,0]"),
	FLOATS(normals, 4, "VEC3", ""),
	FLOATS(target, 4, "VEC3", ",'min':[1,0,0],'max':[1,0,0]"),
	FLOATS(weights, 4, "VEC4", ""),
	FLOATS(seconds, 2, "SCALAR", ",'min':[0],'max':[1]"),
	FLOATS(moves, 2, "VEC3", ""),
	FLOATS(morphs, 2, "SCALAR", ""),
	FLOATS(bone, 2, "VEC3", ""),
	FLOATS(turns, 2, "VEC4", ""),
	{offsetof(buffer, indices), sizeof numbers.indices, 5123, 6, "SCALAR", ""},
	{offsetof(buffer, joints), sizeof numbers.joints, 5121, 4, "VEC4", ""},
};

static void say_numbers(FILE *file)
{
	FILE *bytes = fopen("numbers.bin", "wb");
	assert_non_null(bytes);
	assert_int_equal(fwrite(&numbers, sizeof numbers, 1, bytes), 1);
	assert_int_equal(fclose(bytes), 0);
	size_t count = sizeof accessors / sizeof *accessors;
	for (size_t i = 0; i < count; i++)
		say(file, "%s{'buffer':0,'byteOffset':%zu,'byteLength':%zu}", i ? "," : "'bufferViews':[", accessors[i].offset,
		    accessors[i].size);
	for (size_t i = 0; i < count; i++) {
		say(file, "%s{'bufferView':%zu,'componentType':%d,", i ? "," : "],'accessors':[", i, accessors[i].type);
		say(file, "'count':%d,'type':'%s'%s}", accessors[i].count, accessors[i].shape, accessors[i].rest);
	}
	say(file, "],'buffers':[{'uri':'numbers.bin','byteLength':%zu}],", sizeof numbers);
}

/* Writes a file of three squares before a camera, with two clips of a second or none: "slide" moves all three, "turn"
 * begins with the upper one turned by a right angle. unlit: they have their colours whatever the light. */
static void write_model(const char *path, pose at, bool clips, bool unlit)
{
	static const char *const colors[] = {"1,0.25,0.25,1", "0.25,1,0.25,1", "0.25,0.25,1,1"};
	FILE *file = fopen(path, "w");
	assert_non_null(file);
	say(file, "{'asset':{'version':'2.0'},'extensionsUsed':['KHR_materials_unlit'],");
	say_numbers(file);
	for (int i = 0; i < 3; i++)
		say(file, "%s{'pbrMetallicRoughness':{'baseColorFactor':[%s],'metallicFactor':0}%s}", i ? "," : "'materials':[",
		    colors[i], unlit ? ",'extensions':{'KHR_materials_unlit':{}}" : "");
#define SQUARE "{'primitives':[{'indices':9,'material':%d,'attributes':{'POSITION':0,'NORMAL':1%s}%s}]%s}"
	say(file, "],'meshes':[" SQUARE, 0, "", "", "");
	say(file, "," SQUARE, 1, "", ",'targets':[{'POSITION':2}]", ",'weights':[0]");
	say(file, "," SQUARE, 2, ",'JOINTS_0':10,'WEIGHTS_0':3", "", "");
	say(file, "],'skins':[{'joints':[3]}],'scenes':[{'nodes':[0,1,2,3,4]}],'scene':0,");
	say(file, "'cameras':[{'type':'perspective','perspective':{'yfov':0.75,'znear':0.125,'zfar':64}}],'nodes':[");
	say(file, "{'mesh':0,'translation':[%.9g,0.75,0],'rotation':[0,0,%.9g,%.9g]},", (double)at.moves, (double)at.turn_z,
	    (double)at.turn_w);
	say(file, "{'mesh':1,'weights':[%.9g]},{'mesh':2,'skin':0},", (double)at.morphs);
	say(file, "{'translation':[%.9g,-0.75,0]},{'camera':0,'translation':[0,0,4]}]", (double)at.bone);
	if (clips) {
		say(file, ",'animations':[{'name':'slide',");
		say(file, "'samplers':[{'input':4,'output':5},{'input':4,'output':6},{'input':4,'output':7}],'channels':[");
		say(file, "{'sampler':0,'target':{'node':0,'path':'translation'}},");
		say(file, "{'sampler':1,'target':{'node':1,'path':'weights'}},");
		say(file, "{'sampler':2,'target':{'node':3,'path':'translation'}}]},");
		say(file, "{'name':'turn','samplers':[{'input':4,'output':8}],");
		say(file, "'channels':[{'sampler':0,'target':{'node':0,'path':'rotation'}}]}]");
	}
	say(file, "}");
	assert_int_equal(fclose(file), 0);
}

/* ---- pictures ---------------------------------------------------------------------------------------------------- */

typedef struct picture {
	float value[HEIGHT][WIDTH][3];
} picture;

/* The picture of a file with `fine` times as many points along each side of a pixel: their means. */
static picture load_fine(const char *path, uint32_t fine)
{
	static picture out;
	stilb_image image;
	if (stilb_image_load(path, &image) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	assert_true(image.width == fine * WIDTH && image.height == fine * HEIGHT && image.channels >= 3);
	assert_int_equal(image.format, STILB_IMAGE_F32_LINEAR);
	memset(&out, 0, sizeof out);
	for (uint32_t i = 0; i < image.width * image.height; i++)
		for (uint32_t c = 0; c < 3; c++)
			out.value[i / image.width / fine][i % image.width / fine][c] +=
				((const float *)image.pixels)[i * image.channels + c] / (float)(fine * fine);
	stilb_image_finish(&image);
	return out;
}

static picture load(const char *path)
{
	return load_fine(path, 1);
}

static bool same(const char *a, const char *b)
{
	picture first = load(a), second = load(b);
	return memcmp(&first, &second, sizeof first) == 0;
}

/* Root of the mean square of the difference. */
static double apart(const picture *a, const picture *b)
{
	double sum = 0.0;
	for (int y = 0; y < HEIGHT; y++)
		for (int x = 0; x < WIDTH; x++)
			for (int c = 0; c < 3; c++)
				sum += pow((double)a->value[y][x][c] - (double)b->value[y][x][c], 2.0);
	return sqrt(sum / (3.0 * WIDTH * HEIGHT));
}

static bool exists(const char *path)
{
	return access(path, F_OK) == 0;
}

static void assert_refused(const char *line, const char *words)
{
	int code = stilb_code(no_display, line);
	if (code != 1 && code != 2)
		print_error("'%s' ends with %d\n", line, code);
	assert_true(code == 1 || code == 2);
	assert_error_lines(1);
	assert_said(run.err, words);
}

/* ---- render ------------------------------------------------------------------------------------------------------ */

/* A time of a clip gives the picture of a file that has that pose at rest, whatever of it moves. */
static void a_time_is_a_pose(void **state)
{
	(void)state;
	static const float times[] = {0.0f, 0.25f, 0.625f, 0.96875f};
	write_model("moving.gltf", rest, true, false);
	for (size_t i = 0; i < sizeof times / sizeof *times; i++) {
		write_model("still.gltf", slid(times[i]), false, false);
		stilb_good("render moving.gltf --animation slide --at %g -o a.exr --spp 4 --quiet " SIZE, (double)times[i]);
		stilb_good("render still.gltf -o b.exr --spp 4 --quiet " SIZE);
		assert_true(same("a.exr", "b.exr"));
	}
	stilb_good("render moving.gltf --animation slide --at 0.5 -o b.exr --spp 4 --quiet " SIZE);
	assert_false(same("a.exr", "b.exr"));
	/* Clips begin anew after their end. Without --animation the first one stands at --at. */
	stilb_good("render moving.gltf --animation slide --at 3.5 -o a.exr --spp 4 --quiet " SIZE);
	assert_true(same("a.exr", "b.exr"));
	stilb_good("render moving.gltf --at 0.5 -o a.exr --spp 4 --quiet " SIZE);
	assert_true(same("a.exr", "b.exr"));
}

static void clips_have_names_and_numbers(void **state)
{
	(void)state;
	pose turned = rest;
	turned.turn_z = turned.turn_w = HALF_ROOT;
	write_model("moving.gltf", rest, true, false);
	write_model("turned.gltf", turned, false, false);
	write_model("rest.gltf", rest, false, false);
	stilb_good("render turned.gltf -o still.exr --spp 4 --quiet " SIZE);
	stilb_good("render moving.gltf --animation turn --at 0 -o a.exr --spp 4 --quiet " SIZE);
	assert_true(same("a.exr", "still.exr"));
	stilb_good("render moving.gltf --animation 2 -o a.exr --spp 4 --quiet " SIZE);
	assert_true(same("a.exr", "still.exr"));
	stilb_good("render moving.gltf --animation 1 -o a.exr --spp 4 --quiet " SIZE);
	assert_false(same("a.exr", "still.exr"));
	stilb_good("render rest.gltf -o still.exr --spp 4 --quiet " SIZE);
	stilb_good("render moving.gltf --animation none --at 1 -o a.exr --spp 4 --quiet " SIZE);
	assert_true(same("a.exr", "still.exr"));
	stilb_good("render rest.gltf --animation none -o a.exr --spp 4 --quiet " SIZE);
	assert_true(same("a.exr", "still.exr"));
}

static void wrong_names_list_the_clips(void **state)
{
	(void)state;
	static const char *const wrong[] = {"slid", "Slide", "0", "3", "-1", "none2"};
	write_model("moving.gltf", rest, true, false);
	write_model("still.gltf", rest, false, false);
	for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
		char line[128];
		snprintf(line, sizeof line, "render moving.gltf -o a.exr --spp 1 --quiet " SIZE "--animation %s", wrong[i]);
		assert_refused(line, "2: slide, turn");
	}
	assert_refused("render still.gltf --animation slide -o a.exr --quiet " SIZE, "no animation 'slide'");
	assert_refused("render moving.gltf --at -1 -o a.exr --quiet " SIZE, "--at");
	assert_refused("render moving.gltf --at nan -o a.exr --quiet " SIZE, "--at");
	assert_false(exists("a.exr"));
}

/* ---- frames ------------------------------------------------------------------------------------------------------ */

static void frames_are_times(void **state)
{
	(void)state;
	write_model("moving.gltf", rest, true, false);
	stilb_good(
		"render moving.gltf --animation slide --frames 3..5 --fps 8 --at 0.125 -o row.exr --spp 4 --quiet " SIZE);
	assert_int_equal(folder_entries(), 2 + 3);
	for (int frame = 3; frame <= 5; frame++) {
		char name[32];
		snprintf(name, sizeof name, "row-%04d.exr", frame);
		stilb_good("render moving.gltf --animation slide --at %g -o a.exr --spp 4 --quiet " SIZE, 0.125 + frame / 8.0);
		assert_true(same(name, "a.exr"));
	}
	assert_false(same("row-0003.exr", "row-0004.exr"));
	/* The number comes before the extension, in a folder as well, and where there is none. */
	assert_int_equal(mkdir("a.b", 0777), 0);
	stilb_good("render moving.gltf --frames 12345..12345 -o a.b/c.d.png --spp 1 --quiet " SIZE);
	assert_true(exists("a.b/c.d-12345.png"));
	assert_said(run.out, "picture: a.b/c.d-12345.png\n");
	assert_said(run.out, "1 of 1 pictures were written\n");
	assert_int_equal(remove("a.b/c.d-12345.png"), 0);
	assert_int_equal(rmdir("a.b"), 0);
}

static void wrong_frames_are_refused(void **state)
{
	(void)state;
	static const char *const wrong[] = {"5..3",  "3",     "3..",   "..3",    "a..b",          "0..3x",
	                                    "-1..3", "0...3", "0,3",   "{}",     "0..100000",     "0..4294967297",
	                                    "0..-1", "+1..3", "0..+3", "0x0..3", "4294967296..3", "1.5..3"};
	static const struct {
		const char *flags, *words;
	} with[] = {
		{"--frames 0..1 --resume -o a.png", "--resume"},
		{"--frames 0..1 --time 1 -o a.png", "--time"},
		{"--frames 0..1 --error 0.1 -o a.png", "--error"},
		{"--frames 0..1 --integrator irradiance-cache -o a.png", "irradiance cache"},
		{"--frames 0..1 --fps 0 -o a.png", "--fps"},
		{"--frames 0..1 -o -", "-o FILE"},
		{"--shutter 0.5 --resume -o a.png", "--resume"},
		{"--shutter 0.5 --time 1 -o a.png", "--time"},
		{"--shutter 0.5 --error 0.1 -o a.png", "--error"},
		{"--shutter 0.5 --integrator irradiance-cache -o a.png", "irradiance cache"},
		{"--shutter 0.5 --spp 15 -o a.png", "--moments"},
		{"--shutter 0.5 --moments 1 --spp 64 -o a.png", "--moments"},
		{"--shutter 0.5 --moments 33 --spp 64 -o a.png", "--moments"},
		{"--shutter -0.5 -o a.png", "--shutter"},
		{"--shutter 1.5 -o a.png", "--shutter"},
	};
	char line[256];
	write_model("moving.gltf", rest, true, false);
	for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
		snprintf(line, sizeof line, "render moving.gltf -o a.png --spp 1 --quiet " SIZE "--frames %s", wrong[i]);
		assert_refused(line, "--frames");
	}
	for (size_t i = 0; i < sizeof with / sizeof *with; i++) {
		snprintf(line, sizeof line, "render moving.gltf --quiet " SIZE "%s", with[i].flags);
		assert_refused(line, with[i].words);
	}
	assert_int_equal(folder_entries(), 2);
}

/* An interrupt ends a row with the pictures that were finished. */
static void an_interrupt_leaves_whole_pictures(void **state)
{
	(void)state;
	write_model("moving.gltf", rest, true, false);
	stilb_start(no_display, -1, "render moving.gltf --frames 0..9999 --shutter 0.5 --spp 256 -o row.exr --quiet " SIZE);
	for (int i = 0; i < 60000 && !exists("row-0001.exr"); i++)
		usleep(1000);
	kill(run.pid, SIGINT);
	program_wait(&run);
	if (run.code != 0)
		print_error("%s", run.err);
	assert_int_equal(run.code, 0);
	char words[64], name[32];
	int pictures = 0;
	for (; snprintf(name, sizeof name, "row-%04d.exr", pictures) > 0 && exists(name); pictures++)
		load(name);
	assert_true(pictures >= 2 && pictures < 9999);
	assert_int_equal(folder_entries(), 2 + pictures);
	snprintf(words, sizeof words, "%d of 10000 pictures were written\n", pictures);
	assert_said(run.out, words);
	/* The last one has all its samples. */
	stilb_good("render moving.gltf --frames %d..%d --shutter 0.5 --spp 256 -o again.exr --quiet " SIZE, pictures - 1,
	           pictures - 1);
	char again[32];
	snprintf(name, sizeof name, "row-%04d.exr", pictures - 1);
	snprintf(again, sizeof again, "again-%04d.exr", pictures - 1);
	assert_true(same(name, again));
}

/* Files are limited to a kilobyte: no part of a picture is left, and the row ends. */
static void a_full_disk_ends_a_row(void **state)
{
	(void)state;
	struct rlimit kilobyte = {1024, RLIM_INFINITY}, before;
	write_model("moving.gltf", rest, true, false);
	assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
	signal(SIGXFSZ, SIG_IGN);
	assert_int_equal(setrlimit(RLIMIT_FSIZE, &(struct rlimit){kilobyte.rlim_cur, before.rlim_max}), 0);
	int code = stilb_code(no_display, "render moving.gltf --frames 0..3 -o row.exr --spp 1 --quiet " SIZE);
	assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
	assert_int_equal(code, 1);
	assert_error_lines(1);
	assert_said(run.err, "row-0000.exr");
	assert_int_equal(folder_entries(), 2);
}

/* ---- blur -------------------------------------------------------------------------------------------------------- */

/* A shutter that is open for half a frame of half a second: a quarter of the clip's path. The mean of 64 sharp
 * pictures in the middles of its 64ths is the same but for where edges are, which are 16 here and 64 there. */
static void blur_is_the_mean_of_moments(void **state)
{
	(void)state;
	static picture mean, sharp[64];
	memset(&mean, 0, sizeof mean);
	write_model("moving.gltf", rest, true, true);
	stilb_good("render moving.gltf --animation slide --frames 1..1 --fps 2 --shutter 0.5 -o blurred.exr "
	           "--integrator direct --spp 512 --quiet " SIZE);
	stilb_good("render moving.gltf --animation slide --frames 0..63 --fps 256 --at 0.501953125 -o row.exr " SHARP
	           "--quiet " SIZE);
	for (int i = 0; i < 64; i++) {
		char name[32];
		snprintf(name, sizeof name, "row-%04d.exr", i);
		sharp[i] = load(name);
		for (size_t k = 0; k < sizeof mean / sizeof(float); k++)
			(&mean.value[0][0][0])[k] += (&sharp[i].value[0][0][0])[k] / 64.0f;
	}
	picture blurred = load("blurred-0001.exr");
	double error = apart(&blurred, &mean), unlike = apart(&blurred, &sharp[32]);
	printf("blurred by %.4f from the mean, by %.4f from the middle\n", error, unlike);
	assert_true(error < BLUR_BOUND);
	assert_true(unlike > 10.0 * BLUR_BOUND);
}

static void no_shutter_is_no_blur(void **state)
{
	(void)state;
	write_model("moving.gltf", rest, true, false);
	stilb_good("render moving.gltf --at 0.25 -o a.exr --spp 16 --quiet " SIZE);
	stilb_good("render moving.gltf --at 0.25 --shutter 0 -o b.exr --spp 16 --quiet " SIZE);
	assert_true(same("a.exr", "b.exr"));
	stilb_good("render moving.gltf --at 0.25 --shutter 1 -o b.exr --spp 16 --quiet " SIZE);
	assert_false(same("a.exr", "b.exr"));
	/* What stands still is as sharp as without. */
	stilb_good("render moving.gltf --animation none -o a.exr --spp 16 --quiet " SIZE);
	stilb_good("render moving.gltf --animation none --shutter 1 -o b.exr --spp 16 --quiet " SIZE);
	assert_true(same("a.exr", "b.exr"));
}

static void blur_has_the_same_bits_from_any_workers(void **state)
{
	(void)state;
	write_model("moving.gltf", rest, true, false);
	for (int workers = 1; workers <= 3; workers++)
		stilb_good(
			"render moving.gltf --frames 1..2 --fps 4 --shutter 0.5 --spp 32 -o %d.exr --workers %d --quiet " SIZE,
			workers, workers);
	for (int workers = 2; workers <= 3; workers++)
		for (int frame = 1; frame <= 2; frame++) {
			char first[32], other[32];
			snprintf(first, sizeof first, "1-%04d.exr", frame);
			snprintf(other, sizeof other, "%d-%04d.exr", workers, frame);
			assert_true(same(first, other));
		}
	assert_false(same("1-0001.exr", "1-0002.exr"));
}

/* ---- view -------------------------------------------------------------------------------------------------------- */

#define HEADLESS "--headless --quiet "
#define FINE 8
#define FINE_SIZE "--size 384x256 --environment 1,1,1 "

/* Frame n shows --at and (n - 1) / 60 s of the clip, if it is asked for. */
static void frames_of_view_are_times(void **state)
{
	(void)state;
	write_model("moving.gltf", rest, true, false);
	write_model("still.gltf", slid(0.75f), false, false);
	write_model("rest.gltf", rest, false, false);
	stilb_good("view still.gltf --screenshot still.exr " HEADLESS SIZE);
	stilb_good("view moving.gltf --animation slide --at 0.5 --frames 16 --screenshot a.exr " HEADLESS SIZE);
	assert_true(same("a.exr", "still.exr"));
	stilb_good("view moving.gltf --animation slide --at 0.5 --frames 15 --screenshot a.exr " HEADLESS SIZE);
	assert_false(same("a.exr", "still.exr"));
	stilb_good(
		"view moving.gltf --at 0.75 --frames 4 --screenshot a.exr " HEADLESS SIZE); /* not asked for: stands still */
	assert_true(same("a.exr", "still.exr"));
	stilb_good("view rest.gltf --screenshot still.exr " HEADLESS SIZE);
	stilb_good("view moving.gltf --animation none --frames 4 --screenshot a.exr " HEADLESS SIZE);
	assert_true(same("a.exr", "still.exr"));
	assert_refused("view moving.gltf --animation run " HEADLESS SIZE, "2: slide, turn");
}

/* Frames and rays show the same pose: they differ by how edges are smoothed, less than by a fiftieth of a second. */
static void frames_and_rays_show_the_same_pose(void **state)
{
	(void)state;
	static const float times[] = {0.0f, 0.5f, 0.75f};
	write_model("moving.gltf", rest, true, true);
	for (size_t i = 0; i < sizeof times / sizeof *times; i++) {
		stilb_good("view moving.gltf --animation slide --at %g --screenshot v.exr " HEADLESS FINE_SIZE,
		           (double)times[i]);
		stilb_good("render moving.gltf --animation slide --at %g -o r.exr --quiet " SHARP SIZE, (double)times[i]);
		stilb_good("render moving.gltf --animation slide --at %g -o later.exr --quiet " SHARP SIZE,
		           (double)times[i] + 0.02);
		picture view = load_fine("v.exr", FINE), rays = load("r.exr"), later = load("later.exr");
		double error = apart(&view, &rays), unlike = apart(&view, &later);
		printf("at %g s: %.4f from rays, %.4f from those of 0.02 s later\n", (double)times[i], error, unlike);
		assert_true(error < VIEW_BOUND);
		assert_true(unlike > 2.0 * VIEW_BOUND);
	}
}

/* Rays of a run without a window follow the clip to the frame that is saved. */
static void rays_beside_frames_follow_clips(void **state)
{
	(void)state;
	write_model("moving.gltf", rest, true, false);
	stilb_good("render moving.gltf --animation slide --at 0.75 -o r.exr --spp 3 --quiet " SIZE);
	stilb_good(
		"view moving.gltf --animation slide --at 0.5 --frames 16 --split 0 --spp 3 --screenshot v.exr " HEADLESS SIZE);
	picture traced = load("r.exr"), viewed = load("v.exr");
	for (int i = 0; i < WIDTH * HEIGHT * 3; i++) { /* the frame's numbers are halves */
		float want = traced.value[i / 3 / WIDTH][i / 3 % WIDTH][i % 3];
		float got = viewed.value[i / 3 / WIDTH][i / 3 % WIDTH][i % 3];
		assert_true(fabsf(got - want) < fmaxf(want, 1.0f / 16384) / 1024);
	}
}

int main(int argc, char **argv)
{
	const struct CMUnitTest rays[] = {
		cmocka_unit_test_setup(a_time_is_a_pose, folder_fresh),
		cmocka_unit_test_setup(clips_have_names_and_numbers, folder_fresh),
		cmocka_unit_test_setup(wrong_names_list_the_clips, folder_fresh),
		cmocka_unit_test_setup(frames_are_times, folder_fresh),
		cmocka_unit_test_setup(wrong_frames_are_refused, folder_fresh),
		cmocka_unit_test_setup(an_interrupt_leaves_whole_pictures, folder_fresh),
		cmocka_unit_test_setup(a_full_disk_ends_a_row, folder_fresh),
		cmocka_unit_test_setup(blur_is_the_mean_of_moments, folder_fresh),
		cmocka_unit_test_setup(no_shutter_is_no_blur, folder_fresh),
		cmocka_unit_test_setup(blur_has_the_same_bits_from_any_workers, folder_fresh),
	};
	const struct CMUnitTest frames[] = {
		cmocka_unit_test_setup(frames_of_view_are_times, folder_fresh),
		cmocka_unit_test_setup(frames_and_rays_show_the_same_pose, folder_fresh),
		cmocka_unit_test_setup(rays_beside_frames_follow_clips, folder_fresh),
	};
	if (!folder_enter(argc > 1 ? argv[1] : NULL, "game_animation")) {
		fprintf(stderr, "usage: %s PATH-OF-STILB [view]\n", argv[0]);
		return 2;
	}
	if (argc > 2)
		return cmocka_run_group_tests_name("view", frames, NULL, folder_leave);
	return cmocka_run_group_tests_name("render", rays, NULL, folder_leave);
}
