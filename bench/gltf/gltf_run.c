/* The program of the suite `gltf`: writes a file, opens it by tinygltf in this process and by the import process in
 * turn, and checks that all triangles and textures came. */
#include "bench/gltf/gltf_cases.h"
#include "bench/gltf/gltf_tinygltf.h"
#include "bench/harness/bench_child.h"
#include "scene/scene.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>
#include <sys/resource.h>

#define ROUNDS_MOST 200u

typedef struct gltf_case {
	const char *name;
	uint32_t parts, side, textures, pixels;
} gltf_case;

static const gltf_case cases[] = {
#define CASE(NAME, TITLE, PARTS, SIDE, TEXTURES, PIXELS, LENGTH) {NAME, PARTS, SIDE, TEXTURES, PIXELS},
	GLTF_CASES(CASE)
#undef CASE
};

/* ---- the file ---------------------------------------------------------------------------------------------------- */

static char folder[256];

static const char *in_folder(const char *name)
{
	static char path[512];
	snprintf(path, sizeof path, "%s/%s", folder, name);
	return path;
}

static FILE *file_open(const char *name)
{
	FILE *file = fopen(in_folder(name), "wb");
	if (!file)
		bench_child_fail("cannot write %s", in_folder(name));
	return file;
}

static void file_close(FILE *file)
{
	bool good = !ferror(file);
	if (fclose(file) != 0 || !good)
		bench_child_fail("cannot write to %s; the bench needs 100 MB there", folder);
}

static void put_floats(FILE *file, const float *numbers, size_t count)
{
	fwrite(numbers, sizeof *numbers, count, file);
}

/* A part's positions, normals, texture coordinates and indices, one after the other. */
static void put_part(FILE *file, const gltf_case *on, uint32_t part)
{
	uint32_t row = on->side + 1;
	for (int kind = 0; kind < 3; kind++)
		for (uint32_t v = 0; v < row * row; v++) {
			float x = (float)(v % row), y = (float)(v / row);
			if (kind == 0)
				put_floats(file, (const float[]){x, y, sinf(0.3f * x + (float)part) * cosf(0.2f * y)}, 3);
			else if (kind == 1)
				put_floats(file, (const float[]){0, 0, 1}, 3);
			else
				put_floats(file, (const float[]){x / (float)on->side, y / (float)on->side}, 2);
		}
	for (uint32_t y = 0; y < on->side; y++)
		for (uint32_t x = 0; x < on->side; x++) {
			uint32_t a = y * row + x;
			const uint32_t two[] = {a, a + 1, a + row, a + row, a + 1, a + row + 1};
			fwrite(two, sizeof two, 1, file);
		}
}

static void put_geometry(FILE *file, const gltf_case *on)
{
	uint32_t row = on->side + 1, vertices = row * row, indices = 6 * on->side * on->side;
	const uint32_t sizes[4] = {12 * vertices, 12 * vertices, 8 * vertices, 4 * indices};
	uint32_t offset = 0;
	fprintf(file, "\"bufferViews\":[");
	for (uint32_t i = 0; i < 4 * on->parts; i++) {
		fprintf(file, "%s{\"buffer\":0,\"byteOffset\":%u,\"byteLength\":%u}", i ? "," : "", offset, sizes[i % 4]);
		offset += sizes[i % 4];
	}
	fprintf(file, "],\"buffers\":[{\"byteLength\":%u,\"uri\":\"parts.bin\"}],\"accessors\":[", offset);
	for (uint32_t i = 0; i < 4 * on->parts; i++)
		fprintf(file, "%s{\"bufferView\":%u,\"componentType\":%s,\"count\":%u,\"type\":\"%s\"}", i ? "," : "", i,
		        i % 4 == 3 ? "5125" : "5126", i % 4 == 3 ? indices : vertices,
		        i % 4 == 3   ? "SCALAR"
		        : i % 4 == 2 ? "VEC2"
		                     : "VEC3");
	fprintf(file, "],\"meshes\":[");
	for (uint32_t i = 0; i < on->parts; i++)
		fprintf(file,
		        "%s{\"primitives\":[{\"attributes\":{\"POSITION\":%u,\"NORMAL\":%u,\"TEXCOORD_0\":%u},\"indices\":%u,"
		        "\"material\":%u}]}",
		        i ? "," : "", 4 * i, 4 * i + 1, 4 * i + 2, 4 * i + 3, on->textures ? i % on->textures : 0);
	fprintf(file, "],\"nodes\":[");
	for (uint32_t i = 0; i < on->parts; i++)
		fprintf(file, "%s{\"mesh\":%u,\"translation\":[%u,%u,0]}", i ? "," : "", i, 60 * (i % 20), 60 * (i / 20));
	fputs("]", file);
}

static void put_materials(FILE *file, uint32_t textures)
{
	fprintf(file, ",\"materials\":[");
	for (uint32_t i = 0; i < textures; i++)
		fprintf(file, "%s{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":%u}}}", i ? "," : "", i);
	fprintf(file, "%s],\"textures\":[", textures ? "" : "{}");
	for (uint32_t i = 0; i < textures; i++)
		fprintf(file, "%s{\"source\":%u}", i ? "," : "", i);
	fprintf(file, "],\"images\":[");
	for (uint32_t i = 0; i < textures; i++)
		fprintf(file, "%s{\"uri\":\"texture%u.png\"}", i ? "," : "", i);
	fputs("]", file);
}

/* Waves with a little noise, which PNG compresses to a half; one file with as many names as there are textures. */
static void write_pictures(const gltf_case *on)
{
	stilb_image image;
	char first[512], name[32];
	uint32_t state = 1;
	if (on->textures == 0)
		return;
	if (stilb_image_create(&image, on->pixels, on->pixels, 3, STILB_IMAGE_U8_SRGB) != STILB_OK)
		bench_child_fail("%s", stilb_error_message());
	uint8_t *out = image.pixels;
	for (uint32_t y = 0; y < on->pixels; y++)
		for (uint32_t x = 0; x < on->pixels; x++)
			for (uint32_t c = 0; c < 3; c++) {
				state = state * 1664525u + 1013904223u;
				*out++ = (uint8_t)((((x >> 4) * (c + 1) + (y >> 3)) & 255) ^ (state >> 30));
			}
	snprintf(first, sizeof first, "%s", in_folder("texture0.png"));
	if (stilb_image_save(&image, first) != STILB_OK)
		bench_child_fail("%s", stilb_error_message());
	stilb_image_finish(&image);
	for (uint32_t i = 1; i < on->textures; i++) {
		snprintf(name, sizeof name, "texture%u.png", i);
		if (link(first, in_folder(name)) != 0)
			bench_child_fail("cannot link %s", in_folder(name));
	}
}

static void write_scene(const gltf_case *on)
{
	const char *place = getenv("TMPDIR");
	snprintf(folder, sizeof folder, "%s/stilb-bench-gltf-XXXXXX", place && place[0] ? place : "/tmp");
	if (!mkdtemp(folder))
		bench_child_fail("cannot make the folder %s", folder);
	FILE *file = file_open("parts.bin");
	for (uint32_t part = 0; part < on->parts; part++)
		put_part(file, on, part);
	file_close(file);
	file = file_open("scene.gltf");
	fprintf(file, "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[");
	for (uint32_t i = 0; i < on->parts; i++)
		fprintf(file, "%s%u", i ? "," : "", i);
	fprintf(file, "]}],");
	put_geometry(file, on);
	put_materials(file, on->textures);
	fputs("}", file);
	file_close(file);
	write_pictures(on);
}

static void remove_scene(const gltf_case *on)
{
	char name[32];
	for (uint32_t i = 0; i < on->textures; i++) {
		snprintf(name, sizeof name, "texture%u.png", i);
		remove(in_folder(name));
	}
	remove(in_folder("scene.gltf"));
	remove(in_folder("parts.bin"));
	rmdir(folder);
}

/* ---- the two ways ------------------------------------------------------------------------------------------------ */

static volatile unsigned char seen;

/* Reads a byte of every page: a caller needs the textures in its own memory. */
static void see(const unsigned char *pixels, size_t size)
{
	for (size_t i = 0; i < size; i += 4096)
		seen = pixels[i];
}

static void check(const gltf_case *on, const stilb_scene *scene)
{
	uint64_t triangles = 0;
	for (uint32_t m = 0; m < scene->mesh_count; m++)
		triangles += scene->meshes[m].index_count / 3;
	if (triangles != 2ull * on->side * on->side * on->parts || scene->texture_count != on->textures ||
	    scene->model_count != on->parts)
		bench_child_fail("the import process sent another scene");
	for (uint32_t t = 0; t < scene->texture_count; t++)
		if (scene->textures[t].width != on->pixels)
			bench_child_fail("the import process sent another texture");
}

static double open_stilb(const gltf_case *on)
{
	stilb_scene *scene;
	uint64_t bytes = 0;
	stilb_scene_open_options options = {.quiet = true, .import_bytes = &bytes};
	if (stilb_scene_open_with(in_folder("scene.gltf"), &options, &scene) != STILB_OK)
		bench_child_fail("%s", stilb_error_message());
	for (uint32_t t = 0; t < scene->texture_count; t++)
		see(scene->textures[t].pixels, stilb_image_size(&scene->textures[t]));
	check(on, scene);
	stilb_scene_destroy(scene);
	return (double)bytes / 1048576.0;
}

static void open_tinygltf(const gltf_case *on)
{
	char why[256];
	size_t bytes = gltf_tinygltf_read(in_folder("scene.gltf"), why);
	if (bytes <= (size_t)on->textures * on->pixels * on->pixels)
		bench_child_fail("tinygltf read no textures: %s", why);
}

/* ---- a run ------------------------------------------------------------------------------------------------------- */

/* CPU time of this process and of those that it started and that have ended, ms. */
static double cpu_ms(void)
{
	double sum = 0.0;
	for (int i = 0; i < 2; i++) {
		struct rusage used;
		getrusage(i ? RUSAGE_CHILDREN : RUSAGE_SELF, &used);
		sum += 1e3 * (double)(used.ru_utime.tv_sec + used.ru_stime.tv_sec) +
		       1e-3 * (double)(used.ru_utime.tv_usec + used.ru_stime.tv_usec);
	}
	return sum;
}

static int compare(const void *a, const void *b)
{
	double x = *(const double *)a, y = *(const double *)b;
	return (x > y) - (x < y);
}

static double median(double *values, uint32_t count)
{
	qsort(values, count, sizeof *values, compare);
	return values[count / 2];
}

typedef struct gltf_time {
	double elapsed_ms, cpu_ms, memory_mib;
} gltf_time;

static gltf_time time_of(const gltf_case *on, bool stilb)
{
	gltf_time time = {.cpu_ms = -cpu_ms()};
	uint64_t begin = bench_child_now_ns();
	if (stilb)
		time.memory_mib = open_stilb(on);
	else
		open_tinygltf(on);
	time.elapsed_ms = 1e-6 * (double)(bench_child_now_ns() - begin);
	time.cpu_ms += cpu_ms();
	return time;
}

static void measure(const gltf_case *on, double seconds)
{
	static double peer[ROUNDS_MOST], own[ROUNDS_MOST], elapsed[ROUNDS_MOST], cpu[ROUNDS_MOST], memory[ROUNDS_MOST];
	uint64_t end = bench_child_now_ns() + (uint64_t)(seconds * 1e9);
	uint32_t rounds = 0;
	while (rounds < 1 || (rounds < ROUNDS_MOST && bench_child_now_ns() < end)) {
		gltf_time times[2]; /* each round begins with the other one */
		for (uint32_t i = 0; i < 2; i++)
			times[(rounds + i) % 2] = time_of(on, (rounds + i) % 2);
		peer[rounds] = times[0].elapsed_ms;
		own[rounds] = times[1].elapsed_ms;
		elapsed[rounds] = times[1].elapsed_ms / times[0].elapsed_ms;
		cpu[rounds] = times[1].cpu_ms / fmax(times[0].cpu_ms, 0.001);
		memory[rounds++] = times[1].memory_mib;
	}
	bench_child_metric("tinygltf", median(peer, rounds));
	bench_child_metric("stilb", median(own, rounds));
	bench_child_metric("of-tinygltf", median(elapsed, rounds));
	bench_child_metric("of-cpu", median(cpu, rounds));
	bench_child_metric("memory", median(memory, rounds));
}

int main(int argc, char **argv)
{
	bench_child child = bench_child_args(argc, argv);
	const gltf_case *on = NULL;
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
		if (strcmp(child.case_name, cases[i].name) == 0)
			on = &cases[i];
	if (!on)
		return BENCH_CHILD_SKIP;
	write_scene(on);
	measure(on, child.seconds);
	remove_scene(on);
	return 0;
}
