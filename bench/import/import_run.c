/* The program of the suite `import`: decodes a PNG by libpng in this process and by the import process in turn, and
 * checks that both give the same pixels. */
#include "bench/harness/bench_child.h"

#include "bench/import/import_cases.h"
#include "scene/open/scene_import.h"

#include <malloc.h>
#include <math.h>
#include <png.h>
#include <stdbool.h>
#include <string.h>
#include <sys/mman.h>

#define SIDE 1024u /* pixels */
#define ROUNDS_LEAST 5u
#define ROUNDS_MOST 1000u

typedef struct import_case {
	const char *name;
	int color, bits;
	bool interlace;
	double noise;
} import_case;

static const import_case cases[] = {
#define CASE(NAME, TITLE, COLOR, BITS, INTERLACE, NOISE) {NAME, COLOR, BITS, INTERLACE, NOISE},
	IMPORT_CASES(CASE)
#undef CASE
};

/* ---- the file ---------------------------------------------------------------------------------------------------- */

/* A file in memory. */
typedef struct file_bytes {
	unsigned char *data;
	size_t size, at; /* at: the next byte to read */
} file_bytes;

static void file_put(png_structp png, png_bytep data, size_t size)
{
	file_bytes *file = png_get_io_ptr(png);
	unsigned char *grown = realloc(file->data, file->size + size);
	if (!grown)
		png_error(png, "out of memory");
	memcpy(grown + file->size, data, size);
	file->data = grown;
	file->size += size;
}

static void file_flush(png_structp png)
{
	(void)png;
}

static void file_get(png_structp png, png_bytep out, size_t size)
{
	file_bytes *file = png_get_io_ptr(png);
	if (size > file->size - file->at)
		png_error(png, "the file is cut off");
	memcpy(out, file->data + file->at, size);
	file->at += size;
}

static uint32_t noise_next(uint32_t *state)
{
	*state = *state * 1664525u + 1013904223u;
	return *state >> 8;
}

/* The 16-bit code of channel c at (x, y): waves and noise. */
static uint32_t picture_code(const import_case *on, uint32_t x, uint32_t y, uint32_t c, uint32_t *state)
{
	double wave = 0.5 + 0.25 * sin(0.01 * x * (c + 1)) + 0.2 * cos(0.013 * y + c);
	double noise = noise_next(state) / (double)(1u << 24);
	return (uint32_t)(65535.0 * (on->noise < 1.0 ? wave + on->noise * (noise - 0.5) : noise));
}

/* Fills a row of `values` values of on->bits each. */
static void picture_row(const import_case *on, uint32_t y, uint32_t channels, uint32_t *state, unsigned char *row)
{
	for (uint32_t i = 0; i < SIDE * channels; i++) {
		uint32_t code = picture_code(on, i / channels, y, i % channels, state);
		*row++ = (unsigned char)(code >> 8);
		if (on->bits == 16)
			*row++ = (unsigned char)code;
	}
}

/* Encodes the case's picture. A failure of libpng ends the program. */
static file_bytes file_make(const import_case *on, uint32_t seed)
{
	file_bytes file = {0};
	png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, NULL);
	png_infop info = png ? png_create_info_struct(png) : NULL;
	if (!info)
		bench_child_fail("no memory for libpng");
	png_set_write_fn(png, &file, file_put, file_flush);
	png_set_IHDR(png, info, SIDE, SIDE, on->bits, on->color, on->interlace ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE,
	             PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
	if (on->color == PNG_COLOR_TYPE_PALETTE) {
		png_color colors[256];
		for (int i = 0; i < 256; i++)
			colors[i] = (png_color){(png_byte)i, (png_byte)(255 - i), (png_byte)(i / 2)};
		png_set_PLTE(png, info, colors, 256);
	}
	png_write_info(png, info);
	uint32_t channels = png_get_channels(png, info);
	size_t row = png_get_rowbytes(png, info);
	unsigned char *pixels = malloc(row * SIDE), *rows[SIDE];
	for (uint32_t y = 0; pixels && y < SIDE; y++) {
		rows[y] = pixels + y * row;
		picture_row(on, y, channels, &seed, rows[y]);
	}
	if (!pixels)
		bench_child_fail("no memory for the picture");
	png_write_image(png, rows);
	png_write_end(png, NULL);
	png_destroy_write_struct(&png, &info);
	free(pixels);
	return file;
}

/* Writes the file where others can open it: a path of this process. */
static void file_publish(const file_bytes *file, char path[static 64])
{
	int descriptor = memfd_create("picture.png", MFD_CLOEXEC);
	if (descriptor < 0 || write(descriptor, file->data, file->size) != (ssize_t)file->size)
		bench_child_fail("no memory file for the picture");
	snprintf(path, 64, "/proc/self/fd/%d", descriptor);
}

/* ---- the two ways ------------------------------------------------------------------------------------------------ */

/* Decodes the file to 8 or 16 bits a channel into pixels, which has room for it, and returns the number of bytes. A
 * failure of libpng ends the program. */
static size_t decode(file_bytes file, unsigned char *pixels)
{
	png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, NULL);
	png_infop info = png ? png_create_info_struct(png) : NULL;
	if (!info)
		bench_child_fail("no memory for libpng");
	png_set_read_fn(png, &file, file_get);
	png_read_info(png, info);
	png_set_expand(png);
	if (png_get_bit_depth(png, info) == 16)
		png_set_swap(png);
	int passes = png_set_interlace_handling(png);
	png_read_update_info(png, info);
	size_t row = png_get_rowbytes(png, info);
	for (int pass = 0; pass < passes; pass++)
		for (uint32_t y = 0; y < SIDE; y++)
			png_read_row(png, pixels + y * row, NULL);
	png_read_end(png, NULL);
	png_destroy_read_struct(&png, &info, NULL);
	return row * SIDE;
}

static volatile unsigned char seen;

/* Reads a byte of every page: a caller needs the pixels in its own memory. */
static void see(const unsigned char *pixels, size_t size)
{
	for (size_t i = 0; i < size; i += 4096)
		seen = pixels[i];
}

static unsigned char *memory_of(size_t size)
{
	unsigned char *memory = malloc(size);
	if (!memory)
		bench_child_fail("no memory for pixels");
	return memory;
}

static void import(scene_importer *importer, const char *path, stilb_image *image)
{
	if (scene_importer_picture(importer, path, false, image) != STILB_OK)
		bench_child_fail("%s", stilb_error_message());
}

/* ---- time -------------------------------------------------------------------------------------------------------- */

static clockid_t importer_clock;

/* The clock of the CPU time of the only child process. */
static clockid_t child_clock(void)
{
	int id = 0;
	clockid_t clock;
	FILE *children = fopen("/proc/thread-self/children", "r");
	if (!children || fscanf(children, "%d", &id) != 1 || clock_getcpuclockid(id, &clock) != 0)
		bench_child_fail("the CPU time of the import process is unknown");
	fclose(children);
	return clock;
}

static double clock_ms(clockid_t clock)
{
	struct timespec now;
	clock_gettime(clock, &now);
	return 1e3 * (double)now.tv_sec + 1e-6 * (double)now.tv_nsec;
}

/* CPU time of this process, which has one thread, and the import process, ms. Of a process with a limit of CPU time, as
 * both have, the clock of the process lags by up to a tick while it runs; that of a thread does not, and the import
 * process sleeps here. */
static double cpu_ms(void)
{
	return clock_ms(CLOCK_THREAD_CPUTIME_ID) + clock_ms(importer_clock);
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

/* ---- a run ------------------------------------------------------------------------------------------------------- */

enum { LIBPNG, KEPT, STILB, WAYS };

typedef struct import_run {
	file_bytes file;
	char path[64];
	scene_importer *importer;
	size_t size;         /* bytes of the decoded picture */
	unsigned char *kept; /* [size], memory that was written to before */
} import_run;

/* The CPU time of decoding the picture in one of the ways, ms. */
static double time_of(const import_run *run, int way)
{
	double begin = cpu_ms();
	if (way == LIBPNG) {
		unsigned char *pixels = memory_of(run->size);
		see(pixels, decode(run->file, pixels));
		free(pixels);
	} else if (way == KEPT) {
		see(run->kept, decode(run->file, run->kept));
	} else {
		stilb_image image;
		import(run->importer, run->path, &image);
		see(image.pixels, stilb_image_size(&image));
		stilb_image_finish(&image);
	}
	return cpu_ms() - begin;
}

/* Decodes the picture in both processes for the first time: sets its size. */
static void check_pixels(import_run *run)
{
	stilb_image image;
	import(run->importer, run->path, &image);
	run->size = stilb_image_size(&image);
	run->kept = memory_of(run->size);
	if (decode(run->file, run->kept) != run->size || memcmp(run->kept, image.pixels, run->size) != 0)
		bench_child_fail("the import process gave other pixels than libpng");
	stilb_image_finish(&image);
}

static void measure(const import_run *run, double seconds)
{
	static double times[WAYS][ROUNDS_MOST], ratios[2][ROUNDS_MOST];
	uint64_t end = bench_child_now_ns() + (uint64_t)(seconds * 1e9);
	uint32_t rounds = 0;
	for (int i = 0; i < 3 * WAYS; i++) /* first requests and first rounds are slower */
		time_of(run, i % WAYS);
	while (rounds < ROUNDS_LEAST || (rounds < ROUNDS_MOST && bench_child_now_ns() < end)) {
		for (int i = 0; i < WAYS; i++) { /* each round begins with the next way */
			int way = (int)(rounds + (uint32_t)i) % WAYS;
			times[way][rounds] = time_of(run, way);
		}
		ratios[LIBPNG][rounds] = times[STILB][rounds] / times[LIBPNG][rounds];
		ratios[KEPT][rounds] = times[STILB][rounds] / times[KEPT][rounds];
		rounds++;
	}
	bench_child_metric("libpng", median(times[LIBPNG], rounds));
	bench_child_metric("libpng-kept", median(times[KEPT], rounds));
	bench_child_metric("stilb", median(times[STILB], rounds));
	bench_child_metric("of-libpng", median(ratios[LIBPNG], rounds));
	bench_child_metric("of-libpng-kept", median(ratios[KEPT], rounds));
}

int main(int argc, char **argv)
{
	bench_child child = bench_child_args(argc, argv);
	const import_case *on = NULL;
	for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
		if (strcmp(child.case_name, cases[i].name) == 0)
			on = &cases[i];
	if (!on)
		return BENCH_CHILD_SKIP;
	/* Blocks of pixels come from the kernel, as in a program that keeps the pictures it decodes: without this, malloc
	 * hands out the one freed before. */
	mallopt(M_MMAP_THRESHOLD, 128 << 10);
	scene_import_limits limits = scene_import_limits_default();
	import_run run = {.file = file_make(on, child.round)};
	file_publish(&run.file, run.path);
	if (scene_importer_start(&limits, &run.importer) != STILB_OK)
		bench_child_fail("%s", stilb_error_message());
	importer_clock = child_clock();
	check_pixels(&run);
	measure(&run, child.seconds);
	scene_importer_stop(run.importer);
	free(run.kept);
	free(run.file.data);
	return 0;
}
