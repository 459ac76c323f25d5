/* stilb view without a window: pictures of scenes, the same for any number of workers, and what it refuses. */
#include "image/image.h"
#include "support/stilb_program.h"

#include <math.h>
#include <stdlib.h>

static void write_text(const char *name, const char *text)
{
	FILE *file = fopen(name, "w");
	assert_non_null(file);
	fputs(text, file);
	fclose(file);
}

/* A square of side 2 with two sides, across Z, as an OBJ file. */
#define SQUARE "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3\nf 1 3 4\nf 3 2 1\nf 4 3 1\n"

/* The picture's pixels that are not of the background, the colour of the upper left corner: their box, pixels. */
static void drawn_box(const char *path, int box[4])
{
	stilb_image image;
	assert_int_equal(stilb_image_load(path, &image), STILB_OK);
	assert_int_equal(image.format, STILB_IMAGE_U8_SRGB);
	const uint8_t *pixels = image.pixels;
	box[0] = (int)image.width, box[1] = -1, box[2] = (int)image.height, box[3] = -1;
	for (int y = 0; y < (int)image.height; y++)
		for (int x = 0; x < (int)image.width; x++)
			/* more than the dither's code apart from the background's */
			if (abs(pixels[0] - pixels[((size_t)y * image.width + (size_t)x) * image.channels]) > 1) {
				box[0] = x < box[0] ? x : box[0], box[1] = x > box[1] ? x : box[1];
				box[2] = y < box[2] ? y : box[2], box[3] = y > box[3] ? y : box[3];
			}
	stilb_image_finish(&image);
}

/* The model fills nine tenths of the picture and is in its middle. */
static void frames_a_file(void **state)
{
	(void)state;
	int box[4];
	write_text("square.obj", SQUARE);
	assert_int_equal(
		stilb_code(no_display,
	               "view square.obj --headless --size 320x180 --screenshot a.png --stats a.json --studio off "
	               "--background #000000"),
		0);
	drawn_box("a.png", box);
	assert_in_range(box[3] - box[2], 155, 165);
	assert_in_range(box[0] + box[1], 315, 323);
	assert_in_range(box[2] + box[3], 175, 183);
	assert_int_equal(stilb_code(no_display,
	                            "view square.obj --headless --size 100x300 --workers 3 --screenshot b.png --studio off "
	                            "--background #000000"),
	                 0);
	assert_true(says_in_png("b.png", "stilb:tone", "neutral"));
	assert_true(says_in_png("b.png", "stilb:environment", "1,1,1 over 0.4,0.4,0.4"));
	drawn_box("b.png", box);
	assert_in_range(box[1] - box[0], 86, 93);
}

static void turns_a_table(void **state)
{
	(void)state;
	write_text("square.obj", SQUARE);
	assert_int_equal(
		stilb_code(no_display, "view square.obj --turntable 4 --size 64x64 --screenshot t.png --environment 1,1,1"), 0);
	int boxes[4][4];
	for (int i = 0; i < 4; i++) {
		char name[16];
		snprintf(name, sizeof name, "t-%03d.png", i + 1);
		drawn_box(name, boxes[i]);
	}
	assert_int_equal(access("t.png", F_OK), -1);
	/* A quarter turn further the square is seen from its side, nearly edge-on. */
	assert_true(boxes[1][1] - boxes[1][0] < (boxes[0][1] - boxes[0][0]) * 3 / 4);
	assert_true(abs((boxes[2][1] - boxes[2][0]) - (boxes[0][1] - boxes[0][0])) <= 6);
	/* A second series leaves the first alone. */
	stilb_image before, after;
	assert_int_equal(stilb_image_load("t-002.png", &before), STILB_OK);
	assert_int_equal(stilb_code(no_display, "view square.obj --turntable 2 --size 16x16 --screenshot t.png"), 0);
	assert_non_null(strstr(run.out, "picture: t-2-001.png"));
	assert_non_null(strstr(run.out, "picture: t-2-002.png"));
	assert_int_equal(stilb_image_load("t-002.png", &after), STILB_OK);
	assert_int_equal(after.width, before.width);
	stilb_image_finish(&before);
	stilb_image_finish(&after);
	assert_int_equal(stilb_image_load("t-2-002.png", &after), STILB_OK);
	assert_int_equal(after.width, 16);
	stilb_image_finish(&after);
	/* Frames draw all of a panorama: nothing is said. */
	assert_int_equal(stilb_code(no_display, "view square.obj --size 64x64 --screenshot p.png --environment t-001.png"),
	                 0);
	assert_null(strstr(run.err, "panorama"));
	assert_true(says_in_png("p.png", "stilb:environment", "t-001.png"));
}

static stilb_image load_light(const char *path)
{
	stilb_image image = {0};
	assert_int_equal(stilb_image_load(path, &image), STILB_OK);
	assert_int_equal(image.format, STILB_IMAGE_F32_LINEAR);
	return image;
}

/* Each number is a half beside the one of `stilb render`, which writes floats; frames are left of column `from`. */
static void assert_traced(const char *path, const char *rendered, const char *framed, uint32_t from)
{
	stilb_image got = load_light(path), want = load_light(rendered), left = load_light(framed);
	assert_int_equal(got.width, want.width);
	for (uint32_t y = 0; y < got.height; y++)
		for (uint32_t x = 0; x < got.width; x++)
			for (uint32_t c = 0; c < 3; c++) {
				float a = ((float *)got.pixels)[(y * got.width + x) * got.channels + c];
				float b = ((float *)want.pixels)[(y * want.width + x) * want.channels + c];
				float l = ((float *)left.pixels)[(y * left.width + x) * left.channels + c];
				bool good = x < from ? a == l : fabsf(a - b) < fmaxf(b, 1.0f / 16384) / 1024;
				if (!good)
					fail_msg("%s: pixel %u, %u: %g; traced %g, frame %g", path, x, y, (double)a, (double)b, (double)l);
			}
	stilb_image_finish(&got);
	stilb_image_finish(&want);
	stilb_image_finish(&left);
}

#define DIRECT " --integrator direct --shadows off --brdf lambert"

/* What rays show beside frames is what `stilb render` gives with the same flags and samples. */
static void rays_beside_frames(void **state)
{
	(void)state;
	stilb_good("view spheres --headless --size 48x30 --screenshot frame.exr");
	stilb_good("render spheres --size 48x30 --spp 3 -o path.exr");
	stilb_good("view spheres --headless --size 48x30 --screenshot a.exr --split 0 --spp 3");
	assert_traced("a.exr", "path.exr", "frame.exr", 0);
	stilb_good("view spheres --headless --size 48x30 --screenshot b.exr --split 0.5 --spp 3 --workers 0");
	assert_traced("b.exr", "path.exr", "frame.exr", 24);
	stilb_good("view spheres --headless --size 48x30 --screenshot c.exr --split 1 --spp 3 --frames 2");
	assert_traced("c.exr", "path.exr", "frame.exr", 48);
	stilb_good("render spheres --size 48x30 --spp 2 -o direct.exr" DIRECT);
	stilb_good("view spheres --headless --size 48x30 --screenshot d.exr --split 0 --spp 2" DIRECT);
	assert_traced("d.exr", "direct.exr", "direct.exr", 0);
	assert_said(run.out, "picture: d.exr");
	/* Both say how they show it. */
	stilb_good("view spheres --headless --size 48x30 --screenshot a.png --tone filmic --exposure -1.5");
	stilb_good("render spheres --size 48x30 --spp 1 -o b.png --tone filmic --exposure -1.5");
	for (int i = 0; i < 2; i++) {
		assert_true(says_in_png(i ? "b.png" : "a.png", "stilb:tone", "filmic"));
		assert_true(says_in_png(i ? "b.png" : "a.png", "stilb:exposure", "-1.5"));
		assert_true(says_in_png(i ? "b.png" : "a.png", "stilb:environment", "0.35,0.48,0.7 over 0.12,0.1,0.08"));
	}
}

/* Ctrl-C while frames wait for rays, which say on a terminal how far they are: the picture is written as it is then. */
static void rays_are_stopped(void **state)
{
	(void)state;
	static char said[65536];
	size_t length = 0;
	int master = posix_openpt(O_RDWR | O_NOCTTY), status;
	assert_true(master >= 0 && grantpt(master) == 0 && unlockpt(master) == 0);
	int terminal = open(ptsname(master), O_RDWR | O_NOCTTY), out = open("out", O_RDWR | O_CREAT | O_CLOEXEC, 0600);
	assert_true(terminal >= 0 && out >= 0);
	pid_t pid = fork();
	assert_true(pid >= 0);
	if (pid == 0) {
		dup2(terminal, STDERR_FILENO);
		dup2(out, STDOUT_FILENO);
		close(terminal);
		close(master);
		setenv("TERM", "xterm", 1);
		execl(stilb_path, stilb_path, "view", "spheres", "--headless", "--size", "48x30", "--screenshot", "cut.exr",
		      "--split", "0", "--spp", "65536", NULL);
		_exit(127);
	}
	close(terminal);
	bool stopped = false;
	for (ssize_t got; length < sizeof said - 1 && (got = read(master, said + length, sizeof said - 1 - length)) > 0;) {
		length += (size_t)got;
		if (!stopped && strstr(said, " samples a pixel, ") && strstr(said, " left\033[K"))
			stopped = kill(pid, SIGINT) == 0;
	}
	close(master);
	assert_int_equal(waitpid(pid, &status, 0), pid);
	assert_int_equal(status, 0);
	assert_true(stopped);
	ssize_t size = pread(out, said, sizeof said - 1, 0);
	said[size > 0 ? size : 0] = '\0';
	close(out);
	assert_said(said, "rays stopped early: of 65536 samples the picture has ");
	assert_said(said, "\npicture: cut.exr\nstopped by SIGINT after 1 of 1 frames\n");
	stilb_image picture = load_light("cut.exr");
	assert_int_equal(picture.width, 48);
	stilb_image_finish(&picture);
}

static void opens_what_ships(void **state)
{
	(void)state;
	int box[4];
	stilb_good("view --headless --size 160x90 --screenshot s.png --brdf lambert");
	drawn_box("s.png", box);
	assert_true(box[1] - box[0] > 100);
	stilb_good("view cornell --headless --size 64x64 --screenshot c.png --camera 0.5,0.5,2.4,0,0,40");
	stilb_good("view cornell --device null --frames 3");
}

/* A triangle of side 2 across Z, as glTF, under a sun of 30,000 lux, with two cameras. */
#define TRIANGLE                                                                                                       \
	"{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0,1,2,3]}],\"nodes\":[{\"mesh\":0},"         \
	"{\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}},{\"camera\":0,\"translation\":[0,0,3]},"                 \
	"{\"camera\":1,\"translation\":[0,0,6]}],\"cameras\":[{\"type\":\"perspective\",\"name\":\"Near\","                \
	"\"perspective\":{"                                                                                                \
	"\"yfov\":0.8,\"znear\":0.1}},{\"type\":\"perspective\",\"name\":\"Far\",\"perspective\":{\"yfov\":0.8,\"znear\":" \
	"0.1}}],"                                                                                                          \
	"\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"material\":0}]}],\"materials\":[{"                \
	"\"pbrMetallicRoughness\":{\"metallicFactor\":0}}],\"accessors\":[{\"bufferView\":0,"                              \
	"\"componentType\":5126,\"count\":3,\"type\":\"VEC3\",\"min\":[-1,-1,0],\"max\":[1,1,0]}],\"bufferViews\":[{"      \
	"\"buffer\":0,\"byteLength\":36}],\"buffers\":[{\"byteLength\":36,\"uri\":\"data:application/octet-stream;base64," \
	"AACAvwAAgL8AAAAAAACAPwAAgL8AAAAAAAAAAAAAgD8AAAAA\"}],\"extensionsUsed\":[\"KHR_lights_punctual\"],"               \
	"\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[{\"type\":\"directional\",\"intensity\":30000}]}}}"

/* log2(pi / 30000) stops show the white triangle at 1, which the tone map makes .87; in frames and traced pictures. */
static void exposes_physical_light(void **state)
{
	(void)state;
	int box[4];
	stilb_image image;
	write_text("sun.gltf", TRIANGLE);
	stilb_good("info sun.gltf --json i.json");
	assert_said(run.out, "exposure: -13.22 EV, metered");
	stilb_good("view sun.gltf --headless --size 90x60 --screenshot a.png --brdf lambert");
	assert_said(run.out, "exposure: -13.22 EV, metered");
	assert_int_equal(stilb_image_load("a.png", &image), STILB_OK);
	uint8_t light = ((const uint8_t *)image.pixels)[3 * (30 * 90 + 45)];
	stilb_image_finish(&image);
	assert_in_range(light, 240 - 3, 240 + 1); /* sRGB of .87; some materials keep 4 % for their highlight */
	stilb_good("render sun.gltf --size 60x60 --spp 4 --integrator direct --brdf lambert -o b.png");
	assert_said(run.out, "exposure: -13.22 EV, metered");
	assert_int_equal(stilb_image_load("b.png", &image), STILB_OK);
	assert_in_range(((const uint8_t *)image.pixels)[3 * (30 * 60 + 30)], light - 1, light + 1);
	stilb_image_finish(&image);
	/* The exposure is the display's: radiance stays. The number that was printed gives the same picture. */
	stilb_good("view sun.gltf --headless --size 90x60 --screenshot c.png --brdf lambert --exposure -13.22");
	assert_null(strstr(run.out, "metered"));
	assert_true(same_file("a.png", "c.png"));
	stilb_good("view sun.gltf --headless --size 90x60 --screenshot d.png --brdf lambert --exposure 0");
	drawn_box("d.png", box);
	assert_false(same_file("a.png", "d.png"));
	/* Built-in scenes are made for 0. */
	stilb_good("view cornell --headless --size 8x8");
	assert_null(strstr(run.out, "exposure"));
	stilb_good("view cornell --headless --size 8x8 --exposure auto");
	assert_said(run.out, "EV, metered");
}

/* --camera by name and by number; the second camera is twice as far away. */
static void chooses_a_camera(void **state)
{
	(void)state;
	int boxes[4][4];
	write_text("sun.gltf", TRIANGLE);
	static const char *const cameras[] = {"Near", "2", "Far", "0,0,6,0,0,45.8366"};
	for (int i = 0; i < 4; i++) {
		char line[160];
		snprintf(line, sizeof line, "view sun.gltf --headless --size 90x60 --screenshot a.png --camera %s", cameras[i]);
		stilb_good("%s", line);
		drawn_box("a.png", boxes[i]);
	}
	assert_in_range(boxes[0][3] - boxes[0][2] + 1, 46, 48);
	assert_in_range(boxes[1][3] - boxes[1][2] + 1, 23, 24);
	assert_memory_equal(boxes[1], boxes[2], sizeof boxes[1]);
	assert_memory_equal(boxes[1], boxes[3], sizeof boxes[1]);
	assert_int_equal(stilb_code(no_display, "view sun.gltf --headless --camera Top"), 2);
	assert_said(run.err, "there is no camera 'Top'; the scene has 1 'Near', 2 'Far'");
	assert_int_equal(stilb_code(no_display, "render sun.gltf -o a.png --camera 3"), 2);
	assert_said(run.err, "there is no camera '3'");
	assert_int_equal(stilb_code(no_display, "view cornell --headless --camera 1"), 2);
	assert_said(run.err, "the scene has none");
	stilb_good("info sun.gltf");
	assert_said(run.out, "camera 2 'Far': --camera 0,0,6,0,0,45.8366");
}

/* A ball of radius 1 at height 3, white but for the fifth of the light that it keeps, as an OBJ file. */
static void write_ball(void)
{
	FILE *file = fopen("ball.obj", "w");
	assert_non_null(file);
	write_text("ball.mtl", "newmtl white\nKd 0.8 0.8 0.8\nKs 0 0 0\n");
	fprintf(file, "mtllib ball.mtl\nusemtl white\n");
	for (int row = 0; row <= 24; row++)
		for (int column = 0; column < 48; column++) {
			double theta = M_PI * row / 24, phi = 2 * M_PI * column / 48;
			fprintf(file, "v %.6f %.6f %.6f\n", sin(theta) * cos(phi), 3 + cos(theta), sin(theta) * sin(phi));
		}
	for (int row = 0; row < 24; row++)
		for (int column = 0; column < 48; column++) {
			int a = row * 48 + column + 1, b = row * 48 + (column + 1) % 48 + 1;
			fprintf(file, "f %d %d %d %d\n", a, b, b + 48, a + 48);
		}
	fclose(file);
}

static float linear(uint8_t code)
{
	float c = (float)code / 255.0f;
	return c <= 0.04045f ? c / 12.92f : powf((c + 0.055f) / 1.055f, 2.4f);
}

static int compare_bytes(const void *a, const void *b)
{
	return *(const uint8_t *)a - *(const uint8_t *)b;
}

/* The ball of a picture with alpha: half of the display's range on average, nothing clipped, 3 : 1 from bright to
 * dark. */
static void assert_ball(const char *path)
{
	stilb_image image;
	uint8_t codes[96 * 96];
	double sum = 0.0;
	int count = 0;
	assert_int_equal(stilb_image_load(path, &image), STILB_OK);
	assert_true(image.channels == 4 && image.width == 96 && image.height == 96);
	const uint8_t *pixels = image.pixels;
	assert_true(pixels[3] == 0 && pixels[0] == 0 && pixels[4 * (48 * 96 + 48) + 3] == 255);
	for (int i = 0; i < 96 * 96; i++)
		if (pixels[4 * i + 3] == 255) {
			codes[count] = pixels[4 * i + 1];
			sum += (double)linear(codes[count++]);
		}
	stilb_image_finish(&image);
	assert_in_range(count, 5000, 6100); /* nine tenths of the picture's height: pi 43.2^2 = 5863 */
	qsort(codes, (size_t)count, 1, compare_bytes);
	double mean = sum / count, ratio = (double)(linear(codes[count * 95 / 100]) / linear(codes[count / 20]));
	if (!(fabs(mean - 0.5) < 0.1 && ratio > 2.4 && ratio < 3.6 && codes[count - 1] < 250))
		print_error("%s: mean %.3f, %.2f : 1, at most %d\n", path, mean, ratio, codes[count - 1]);
	assert_true(fabs(mean - 0.5) < 0.1 && ratio > 2.4 && ratio < 3.6 && codes[count - 1] < 250);
}

/* The pixel of a picture of 96 x 96, its green code. */
static int green_at(const char *path, int x, int y)
{
	stilb_image image;
	assert_int_equal(stilb_image_load(path, &image), STILB_OK);
	int code = ((const uint8_t *)image.pixels)[(size_t)image.channels * (size_t)(y * 96 + x) + 1];
	stilb_image_finish(&image);
	return code;
}

#define SMALL "--quiet --size 96x96"

static void lights_what_has_no_light(void **state)
{
	(void)state;
	write_ball();
	stilb_good(
		"view ball.obj --headless --screenshot v.png --background transparent --brdf lambert --workers 0 " SMALL);
	assert_ball("v.png");
	stilb_good("render ball.obj -o r.png --spp 64 --background transparent " SMALL);
	assert_ball("r.png");
	/* The floor takes the shadow, above it is the backdrop, the same from edge to edge: there is no horizon. */
	const char *const pictures[] = {"v.png", "r.png"};
	stilb_good("view ball.obj --headless --screenshot v.png " SMALL);
	stilb_good("render ball.obj -o r.png --spp 64 " SMALL);
	for (int i = 0; i < 2; i++) {
		int behind = green_at(pictures[i], 1, 1);
		assert_in_range(behind, 148, 150);                                     /* sRGB of .3 */
		assert_in_range(green_at(pictures[i], 94, 1), behind - 1, behind + 1); /* dithered */
		assert_true(green_at(pictures[i], 48, 94) < behind - 15);
	}
	assert_int_equal(stilb_code(no_display, "view ball.obj --headless --size 8x8"), 0);
	assert_said(run.err, "ball.obj: it has no light: a studio shines on it");
	assert_int_equal(stilb_code(no_display, "view ball.obj --headless --size 8x8 --studio off"), 0);
	assert_said(run.err, "ball.obj: it has no light: a grey sky shines on it");
	stilb_good("view ball.obj --headless --size 8x8 --environment 1,1,1");
}

/* A look is --preset's, or else that of the file beside the scene; flags count over both, and mistakes end the run. */
static void shows_looks(void **state)
{
	(void)state;
	write_ball();
	write_text("dark.cube", "LUT_1D_SIZE 2\n0 0 0\n0.1 0.1 0.1\n");
	write_text("p.json", "{\"tone\": \"hable\", \"exposure\": -2, \"bloom\": 0.1}");
	write_text("ball.obj.post.json", "{\"tone\": \"piecewise\", \"exposure\": 1, \"grade\": \"dark.cube\"}");
	stilb_good("view ball.obj --headless --screenshot a.png --plan a.txt " SMALL);
	assert_true(says_in_png("a.png", "stilb:tone", "piecewise") && says_in_png("a.png", "stilb:exposure", "1"));
	assert_in_range(green_at("a.png", 1, 94), 1, 26);
	assert_null(strstr(run.err, "this file says"));
	const char *loud = "view ball.obj --headless --screenshot b.png --tone knee --exposure 0.5 --size 96x96";
	assert_int_equal(stilb_code(no_display, loud), 0);
	assert_said(run.err, "ball.obj.post.json: pictures are shown as this file says");
	assert_true(says_in_png("b.png", "stilb:tone", "knee") && says_in_png("b.png", "stilb:exposure", "0.5"));
	stilb_good("view ball.obj --headless --screenshot c.png --preset p.json --plan c.txt " SMALL);
	assert_true(says_in_png("c.png", "stilb:tone", "hable") && says_in_png("c.png", "stilb:exposure", "-2"));
	assert_null(strstr(run.err, "this file says"));
	stilb_good("demo --models 4 --headless --frames 1 --screenshot d.png --preset p.json --size 32x32");
	assert_true(says_in_png("d.png", "stilb:tone", "hable") && says_in_png("d.png", "stilb:exposure", "-2"));
	stilb_good("view ball.obj --headless --preset p.json --bloom 0.25 --save-preset q.json " SMALL);
	stilb_good("view ball.obj --headless --screenshot e.png --preset q.json " SMALL);
	assert_true(says_in_png("e.png", "stilb:tone", "hable") && says_in_png("e.png", "stilb:exposure", "-2"));
	write_text("ball.obj.post.json", "{\"aa\": \"post\"}"); /* checked as flags are */
	assert_int_equal(stilb_code(no_display, "view ball.obj --headless --screenshot a.exr --size 8x8"), 2);
	assert_said(run.err, "ball.obj.post.json: what it says does not go with the flags that are given");
	write_text("ball.obj.post.json", "{\"tones\": \"piecewise\"}");
	assert_int_equal(stilb_code(no_display, "view ball.obj --headless --screenshot a.png " SMALL), 2);
	assert_said(run.err, "ball.obj.post.json: JSON line 1, column 3: 'tones' is no member of a preset");
	assert_int_equal(stilb_code(no_display, "view ball.obj --headless --preset none.json " SMALL), 2);
	assert_said(run.err, "--preset: cannot read 'none.json'");
	assert_int_equal(stilb_code(no_display, "view ball.obj --headless --grade p.json --preset p.json " SMALL), 2);
	assert_said(run.err, "p.json: line 1: it begins with no word");
}

/* What is shown behind a model is what was asked for, whatever the exposure. */
static void shows_backgrounds(void **state)
{
	(void)state;
	write_ball();
	stilb_good("view ball.obj --headless --screenshot a.png --background #4080c0 --exposure 2 " SMALL);
	assert_in_range(green_at("a.png", 1, 94), 0x80 - 1, 0x80 + 1);
	stilb_good("render ball.obj -o b.png --spp 1 --background #4080c0 --exposure 2 " SMALL);
	assert_in_range(green_at("b.png", 1, 94), 0x80 - 1, 0x80 + 1);
	stilb_good("view ball.obj --headless --screenshot a.png --background #4080fe --tone knee " SMALL);
	assert_in_range(green_at("a.png", 1, 94), 0x80 - 1, 0x80 + 1);
	/* The neutral tone map shows no blue that is as bright. */
	assert_int_equal(stilb_code(no_display, "view ball.obj --headless --screenshot a.png --background #4080fe " SMALL),
	                 0);
	assert_said(run.err, "the tone map 'neutral' whitens what is as bright as '#4080fe'; --tone knee shows it");
	assert_in_range(green_at("a.png", 1, 94), 0x80 + 30, 0xfe - 30);
	stilb_good("view ball.obj --headless --screenshot a.png --background 1,1,1 --replay secondary " SMALL);
	assert_int_equal(green_at("a.png", 1, 94), 255);
	/* The sky is 1 above and .4 below; the camera looks down, and its upper edge is at the horizon. */
	stilb_good("view ball.obj --headless --screenshot a.png --background blur --studio off --camera 0,3,5,0,0,60 "
	           "--replay secondary " SMALL);
	stilb_good("render ball.obj -o b.png --spp 1 --background blur --studio off --camera 0,3,5,0,0,60 " SMALL);
	assert_in_range(green_at("a.png", 1, 0), 229, 241);  /* at most .87 */
	assert_in_range(green_at("a.png", 1, 95), 160, 172); /* .4 and some of the sky, less .04 */
	assert_in_range(green_at("a.png", 1, 47), 185, 218); /* in between */
	for (int y = 0; y < 96; y += 19)
		assert_in_range(green_at("b.png", 1, y), green_at("a.png", 1, y) - 2, green_at("a.png", 1, y) + 2);
	assert_int_equal(stilb_code(no_display, "view ball.obj --headless --background transparent --screenshot a.hdr"), 2);
	assert_said(run.err, "has no alpha");
	assert_int_equal(stilb_code(no_display, "render ball.obj --background transparent -o a.hdr"), 2);
	assert_said(run.err, "has no alpha");
	assert_int_equal(stilb_code(no_display, "view ball.obj --background green"), 2);
	assert_said(run.err, "--background: 'green' is not known");
}

/* Axes, lights and bounds are drawn over the scene, each in pixels of its own. */
static void draws_into_the_world(void **state)
{
	(void)state;
	static const char *const what[] = {"axes", "lights", "bounds", "bounds,lights,axes"};
	uint32_t changed[4] = {0};
	stilb_image plain, drawn;
	stilb_good("view cornell --headless --size 96x64 --screenshot plain.png");
	assert_int_equal(stilb_image_load("plain.png", &plain), STILB_OK);
	for (size_t i = 0; i < 4; i++) {
		char line[128];
		snprintf(line, sizeof line, "view cornell --headless --size 96x64 --screenshot drawn.png --draw %s", what[i]);
		stilb_good("%s", line);
		assert_int_equal(stilb_image_load("drawn.png", &drawn), STILB_OK);
		for (uint32_t p = 0; p < 96 * 64; p++)
			changed[i] += memcmp((uint8_t *)plain.pixels + 3 * p, (uint8_t *)drawn.pixels + 3 * p, 3) != 0;
		stilb_image_finish(&drawn);
	}
	stilb_image_finish(&plain);
	for (size_t i = 0; i < 3; i++)
		assert_true(changed[i] > 20 && changed[3] > changed[i]);
}

/* An inset changes its corner alone; drawn twice as large the scene gives the same picture, with smooth edges. */
static void insets_and_scales(void **state)
{
	(void)state;
	write_text("square.obj", SQUARE);
	stilb_image plain, inset, scaled;
	stilb_good("view square.obj --headless --size 100x100 --screenshot p.png --environment 1,1,1 --background #000000");
	stilb_good("view square.obj --headless --size 100x100 --screenshot i.png --environment 1,1,1 --background #000000 "
	           "--inset 0,0,50,180,0");
	stilb_good("view square.obj --headless --size 100x100 --screenshot s.png --environment 1,1,1 --background #000000 "
	           "--render-scale 2");
	assert_int_equal(stilb_image_load("p.png", &plain), STILB_OK);
	assert_int_equal(stilb_image_load("i.png", &inset), STILB_OK);
	assert_int_equal(stilb_image_load("s.png", &scaled), STILB_OK);
	uint32_t changed = 0, outside = 0, far = 0;
	for (uint32_t i = 0; i < 100 * 100; i++) {
		const uint8_t *a = (uint8_t *)plain.pixels + 3 * i, *b = (uint8_t *)inset.pixels + 3 * i;
		const uint8_t *c = (uint8_t *)scaled.pixels + 3 * i;
		bool in = i % 100 >= 68 && i % 100 < 98 && i / 100 >= 68 && i / 100 < 98;
		outside += !in && memcmp(a, b, 3) != 0;
		changed += in && memcmp(a, b, 3) != 0;
		far += abs(a[1] - c[1]) > 3;
	}
	assert_int_equal(outside, 0);
	assert_true(changed > 100);
	assert_in_range(far, 1, 500); /* the square's edges are smooth */
	stilb_image_finish(&plain);
	stilb_image_finish(&inset);
	stilb_image_finish(&scaled);
}

/* The pixel in the middle of the lowest row. */
static void lowest_pixel(const char *path, float pixel[3])
{
	stilb_image image;
	float row[3 * 32];
	assert_int_equal(stilb_image_load(path, &image), STILB_OK);
	assert_true(image.width == 32 && image.height == 24 && image.channels == 3);
	if (image.format == STILB_IMAGE_U8_SRGB) { /* codes */
		for (int c = 0; c < 3; c++)
			pixel[c] = ((const uint8_t *)image.pixels)[3 * (23 * 32 + 16) + c];
	} else {
		stilb_image_row_to_light(&image, 23, row);
		memcpy(pixel, row + 3 * 16, 3 * sizeof *pixel);
	}
	stilb_image_finish(&image);
}

/* The floor of plane-wall reflects 1/2 and points up: values in .exr, codes of light or of data in .png, the same from
 * both commands, whatever exposure and tone map are. */
static void shows_channels(void **state)
{
	(void)state;
	static const struct {
		const char *flags, *file;
		float pixel[3];
	} rows[] = {
		{"--show normal", "a.png", {128, 255, 128}},
		{"--show normal", "a.exr", {0.5f, 1.0f, 0.5f}},
		{"--show base", "a.png", {188, 188, 188}},
		{"--show base", "a.exr", {0.5f, 0.5f, 0.5f}},
		{"--show metalness", "a.png", {0, 0, 0}},
		{"--show alpha", "a.png", {255, 255, 255}},
		{"--show normal --exposure 3", "a.png", {128, 255, 128}},
		{"--show base --tone filmic", "a.png", {188, 188, 188}},
	};
	for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
		for (int rays = 0; rays < 2; rays++) {
			float pixel[3];
			char line[128];
			snprintf(line, sizeof line, "%s plane-wall %s --size 32x24 %s %s", rays ? "render" : "view --headless",
			         rows[i].flags, rays ? "-o" : "--screenshot", rows[i].file);
			assert_int_equal(stilb_code(no_display, line), 0);
			lowest_pixel(rows[i].file, pixel);
			for (int c = 0; c < 3; c++)
				if (!(fabsf(pixel[c] - rows[i].pixel[c]) <= (rows[i].pixel[0] > 1.0f ? 1.0f : 1e-3f)))
					fail_msg("%s %s: %g %g %g", rays ? "render" : "view", rows[i].flags, (double)pixel[0],
					         (double)pixel[1], (double)pixel[2]);
		}
	assert_int_equal(stilb_code(no_display, "view cornell --headless --size 32x24 --show alpha --dump a.dump"), 1);
	assert_non_null(strstr(run.err, "it shows 'alpha' in the place of light, which dumps do not hold"));
	assert_int_equal(access("a.dump", F_OK), -1);
	assert_int_equal(stilb_code(no_display, "view cornell --headless --show nose"), 1);
	assert_non_null(strstr(run.err, "no image 'nose' to show; this frame has picture"));
	assert_non_null(strstr(run.err, ", lod, lights, error, cascades, atlas, acne, base, normal, tangent, roughness, "
	                                "metalness, occlusion, "));
}

static void refuses(void **state)
{
	(void)state;
	write_text("words.txt", "not a scene\n");
	write_text("empty.obj", "v 0 0 0\n");
	assert_int_equal(mkdir("folder", 0700), 0);
	static const char *const lines[][2] = {
		{"view none.gltf --headless", "no such file"},
		{"view folder --headless", "a folder"},
		{"view words.txt --headless", "cannot read 'words.txt'"},
		{"view empty.obj --headless", "cannot read 'empty.obj'"},
		{"view furnace:2 --headless", "furnace:2"},
		{"view a.obj b.obj", "one word too many"},
		{"view --turntable 3", "--turntable needs --screenshot"},
		{"view cornell --headless --inset 1,2,3", "--inset: '1,2,3' is not X,Y,Z,YAW,PITCH[,FOV]"},
		{"view cornell --headless --inset nobody", "--inset: there is no camera 'nobody'"},
		{"view cornell --headless --render-scale 0.05", "--render-scale: 0.05 is too small; give 0.1..4"},
		{"view cornell --headless --render-scale 5", "--render-scale"},
		{"view --turntable 3 --frames 2 --screenshot a.png", "leave --frames out"},
		{"view --camera 1,2,3,4,5,180 --headless", "field of view"},
		{"view --camera 1,2,3 --headless", "is not X,Y,Z,YAW,PITCH[,FOV]"},
		{"view --exposure bright --headless", "neither auto nor adapt nor a number in -32..32"},
		{"view --exposure 33 --headless", "neither auto nor adapt nor a number in -32..32"},
		{"view --exposure adapt --background 1,0,0 --headless", "--background 1,0,0 is shown as it is"},
		{"render cornell -o a.png --exposure adapt", "--exposure adapt is of frames"},
		{"view cornell --headless --dither blue", "--dither"},
		{"view --msaa 2 --headless", "--msaa"},
		{"view cornell --headless --show color:one", "is no IMAGE:MIP"},
		{"view cornell --headless --show color:0:1:2", "is no IMAGE:MIP"},
		{"view cornell --headless --show-range 0,1", "name one with --show"},
		{"view cornell --headless --show lod --show-range 0,1", "name one with --show"},
		{"view cornell --headless --show depth --show-range 1,1", "is not LOW,HIGH"},
		{"view cornell --headless --show depth --show-range 1", "is not LOW,HIGH"},
		{"view cornell --headless --show normal --show-range 0,1", "name one with --show"},
		{"view cornell --headless --split 0.5 --show overdraw", "--show overdraw: rays have none"},
		{"view cornell --headless --draw lights,none", "give bounds, lights and axes, each once"},
		{"view cornell --headless --draw axes,axes", "give bounds, lights and axes, each once"},
		{"view cornell --headless --environment -1,0,0", "out of range"},
		{"view cornell --headless --environment none.hdr", "none.hdr"},
		{"view cornell --headless --spp 4", "only --split"},
		{"view cornell --split 0.5 --device null", "the null device"},
		{"view cornell --headless --split 1.5", "--split"},
		{"view cornell --split 0 --integrator irradiance-cache", "no place beside frames"},
	};
	for (size_t i = 0; i < sizeof lines / sizeof *lines; i++) {
		int code = stilb_code(no_display, lines[i][0]);
		if (code != 2 || !strstr(run.err, lines[i][1]))
			print_error("stilb %s: %d\n%s", lines[i][0], code, run.err);
		assert_int_equal(code, 2);
		assert_non_null(strstr(run.err, lines[i][1]));
	}
}

int main(int argc, char **argv)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test_setup(frames_a_file, folder_fresh),
		cmocka_unit_test_setup(turns_a_table, folder_fresh),
		cmocka_unit_test_setup(rays_beside_frames, folder_fresh),
		cmocka_unit_test_setup(rays_are_stopped, folder_fresh),
		cmocka_unit_test_setup(opens_what_ships, folder_fresh),
		cmocka_unit_test_setup(exposes_physical_light, folder_fresh),
		cmocka_unit_test_setup(chooses_a_camera, folder_fresh),
		cmocka_unit_test_setup(lights_what_has_no_light, folder_fresh),
		cmocka_unit_test_setup(shows_backgrounds, folder_fresh),
		cmocka_unit_test_setup(shows_looks, folder_fresh),
		cmocka_unit_test_setup(shows_channels, folder_fresh),
		cmocka_unit_test_setup(draws_into_the_world, folder_fresh),
		cmocka_unit_test_setup(insets_and_scales, folder_fresh),
		cmocka_unit_test_setup(refuses, folder_fresh),
	};
	if (argc != 2 || !folder_enter(argv[1], "test_game_view")) {
		fprintf(stderr, "usage: test_game_view STILB\n");
		return 1;
	}
	if (stilb_code(no_display, "view --headless --size 8x8") != 0 && strstr(run.err, "mesa-vulkan-drivers")) {
		folder_leave(NULL);
		printf("skipped: %s", run.err);
		return 77;
	}
	return cmocka_run_group_tests(tests, NULL, folder_leave);
}
