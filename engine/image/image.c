#include "image/image.h"

#include "image/image_blocks.h"
#include "image/image_internal.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

/* Values of stilb_image.storage: where the pixels are. In a picture that can be shared with another process, storage is
 * IMAGE_STORAGE_SHARED plus the descriptor of the memory file that the pixels are in. */
enum { IMAGE_STORAGE_MEMORY, IMAGE_STORAGE_MAPPED, IMAGE_STORAGE_SHARED };

/* Of a picture in memory of its own, storage counts above that the levels behind the largest one. */
#define IMAGE_LEVEL_SHIFT 24

const size_t image_scalar_bytes[] = {
	[IMAGE_SCALAR_U8] = 1, [IMAGE_SCALAR_F16] = 2, [IMAGE_SCALAR_F32] = 4, [IMAGE_SCALAR_U16] = 2};
const image_scalar image_format_scalars[] = {
	[STILB_IMAGE_U8_SRGB] = IMAGE_SCALAR_U8,     [STILB_IMAGE_F16_LINEAR] = IMAGE_SCALAR_F16,
	[STILB_IMAGE_F32_LINEAR] = IMAGE_SCALAR_F32, [STILB_IMAGE_U16_SRGB] = IMAGE_SCALAR_U16,
	[STILB_IMAGE_U8_LINEAR] = IMAGE_SCALAR_U8,   [STILB_IMAGE_U16_LINEAR] = IMAGE_SCALAR_U16,
	[STILB_IMAGE_BC1_SRGB] = IMAGE_SCALAR_U8,    [STILB_IMAGE_BC1_LINEAR] = IMAGE_SCALAR_U8,
	[STILB_IMAGE_BC3_SRGB] = IMAGE_SCALAR_U8,    [STILB_IMAGE_BC3_LINEAR] = IMAGE_SCALAR_U8,
	[STILB_IMAGE_BC4_LINEAR] = IMAGE_SCALAR_U16, [STILB_IMAGE_BC5_LINEAR] = IMAGE_SCALAR_U16,
	[STILB_IMAGE_BC7_SRGB] = IMAGE_SCALAR_U8,    [STILB_IMAGE_BC7_LINEAR] = IMAGE_SCALAR_U8};

const image_block_format image_block_formats[STILB_IMAGE_FORMAT_COUNT] = {
	[STILB_IMAGE_BC1_SRGB] = {8, 4, STILB_IMAGE_U8_SRGB},
	[STILB_IMAGE_BC1_LINEAR] = {8, 4, STILB_IMAGE_U8_LINEAR},
	[STILB_IMAGE_BC3_SRGB] = {16, 4, STILB_IMAGE_U8_SRGB},
	[STILB_IMAGE_BC3_LINEAR] = {16, 4, STILB_IMAGE_U8_LINEAR},
	[STILB_IMAGE_BC4_LINEAR] = {8, 1, STILB_IMAGE_U16_LINEAR},
	[STILB_IMAGE_BC5_LINEAR] = {16, 2, STILB_IMAGE_U16_LINEAR},
	[STILB_IMAGE_BC7_SRGB] = {16, 4, STILB_IMAGE_U8_SRGB},
	[STILB_IMAGE_BC7_LINEAR] = {16, 4, STILB_IMAGE_U8_LINEAR},
};

size_t stilb_image_size(const stilb_image *image)
{
	STILB_ASSERT(image->width <= STILB_IMAGE_MAX_SIDE && image->height <= STILB_IMAGE_MAX_SIDE);
	STILB_ASSERT(image->channels <= 4);
	STILB_ASSERT((unsigned)image->format < STILB_IMAGE_FORMAT_COUNT);
	size_t block = image_block_formats[image->format].bytes;
	if (block > 0)
		return (size_t)((image->width + 3) / 4) * ((image->height + 3) / 4) * block;
	return (size_t)image->width * image->height * image->channels *
	       image_scalar_bytes[image_format_scalars[image->format]];
}

bool stilb_image_format_is_blocks(stilb_image_format format)
{
	STILB_ASSERT((unsigned)format < STILB_IMAGE_FORMAT_COUNT);
	return image_block_formats[format].bytes > 0;
}

uint32_t stilb_image_format_channels(stilb_image_format format)
{
	STILB_ASSERT((unsigned)format < STILB_IMAGE_FORMAT_COUNT);
	return image_block_formats[format].channels;
}

/* Codes of colour, and the same bytes as data. */
static const stilb_image_format image_pairs[][2] = {{STILB_IMAGE_U8_SRGB, STILB_IMAGE_U8_LINEAR},
                                                    {STILB_IMAGE_U16_SRGB, STILB_IMAGE_U16_LINEAR},
                                                    {STILB_IMAGE_BC1_SRGB, STILB_IMAGE_BC1_LINEAR},
                                                    {STILB_IMAGE_BC3_SRGB, STILB_IMAGE_BC3_LINEAR},
                                                    {STILB_IMAGE_BC7_SRGB, STILB_IMAGE_BC7_LINEAR}};

/* The other one of the format's pair, if it is its number `from`; else the format itself. */
static stilb_image_format image_other(stilb_image_format format, int from)
{
	STILB_ASSERT((unsigned)format < STILB_IMAGE_FORMAT_COUNT);
	for (size_t i = 0; i < sizeof image_pairs / sizeof *image_pairs; i++)
		if (image_pairs[i][from] == format)
			return image_pairs[i][1 - from];
	return format;
}

stilb_image_format stilb_image_format_as_data(stilb_image_format format)
{
	return image_other(format, 0);
}

stilb_image_format stilb_image_format_as_color(stilb_image_format format)
{
	return image_other(format, 1);
}

bool image_is_sound(const stilb_image *image)
{
	return image->pixels && !image_refusal(image);
}

/* Sides and channels are checked first, so that the product that is the size in bytes cannot overflow. */
const char *image_refusal(const stilb_image *image)
{
	if (image->width < 1 || image->height < 1 || image->width > STILB_IMAGE_MAX_SIDE ||
	    image->height > STILB_IMAGE_MAX_SIDE)
		return "width and height must be 1 to 65536";
	if (image->channels < 1 || image->channels > 4)
		return "1 to 4 channels are supported";
	if ((unsigned)image->format >= STILB_IMAGE_FORMAT_COUNT)
		return "unknown pixel format";
	uint32_t channels = image_block_formats[image->format].channels;
	if (channels > 0 && image->channels != channels)
		return "its blocks have another number of channels";
	if (stilb_image_size(image) > STILB_IMAGE_MAX_BYTES)
		return "its pixels would take more than 4 GiB";
	return NULL;
}

/* Sets image to the shape, without pixels. STILB_ERROR_ARGUMENT: the shape is refused, and image is {0}. */
static stilb_result image_shape_check(stilb_image *image, uint32_t width, uint32_t height, uint32_t channels,
                                      stilb_image_format format)
{
	STILB_ASSERT(image);
	stilb_image made = {.width = width, .height = height, .channels = channels, .format = format};
	const char *refusal = image_refusal(&made);
	*image = (stilb_image){0};
	if (refusal)
		return stilb_fail(STILB_ERROR_ARGUMENT, "cannot make a picture of %u x %u pixels with %u channels: %s", width,
		                  height, channels, refusal);
	*image = made;
	return STILB_OK;
}

/* Fails with STILB_ERROR_MEMORY for a picture of image's size, and sets image to {0}. */
static stilb_result image_no_memory(stilb_image *image)
{
	uint32_t width = image->width, height = image->height;
	*image = (stilb_image){0};
	return stilb_fail(STILB_ERROR_MEMORY, "out of memory for a picture of %u x %u pixels", width, height);
}

stilb_result stilb_image_create(stilb_image *image, uint32_t width, uint32_t height, uint32_t channels,
                                stilb_image_format format)
{
	stilb_result result = image_shape_check(image, width, height, channels, format);
	if (result != STILB_OK)
		return result;
	image->pixels = stilb_memory_alloc(stilb_image_size(image), 1);
	if (!image->pixels)
		return image_no_memory(image);
	memset(image->pixels, 0, stilb_image_size(image));
	STILB_ASSERT(image_is_sound(image) && (uintptr_t)image->pixels % 64 == 0);
	return STILB_OK;
}

/* ---- levels ------------------------------------------------------------------------------------------------------ */

uint32_t image_most_levels(uint32_t width, uint32_t height)
{
	uint32_t longer = width > height ? width : height;
	STILB_ASSERT(longer > 0);
	return 32 - (uint32_t)__builtin_clz(longer);
}

uint32_t stilb_image_level_count(const stilb_image *image)
{
	return 1 + (image->storage >> IMAGE_LEVEL_SHIFT);
}

/* Gives a level the sides of the next one. */
static void image_level_halve(stilb_image *level)
{
	level->width = level->width > 1 ? level->width / 2 : 1;
	level->height = level->height > 1 ? level->height / 2 : 1;
}

stilb_image stilb_image_level(const stilb_image *image, uint32_t level)
{
	STILB_ASSERT(image_is_sound(image));
	STILB_ASSERT(level < stilb_image_level_count(image));
	stilb_image view = *image;
	view.storage = IMAGE_STORAGE_MEMORY;
	for (uint32_t l = 0; l < level; l++) {
		view.pixels = (uint8_t *)view.pixels + stilb_image_size(&view);
		image_level_halve(&view);
	}
	return view;
}

stilb_image stilb_image_view_levels(const stilb_image *image, uint32_t levels)
{
	stilb_image view = *image;
	STILB_ASSERT(image_is_sound(image) && image->storage == IMAGE_STORAGE_MEMORY);
	STILB_ASSERT(levels >= 1 && levels <= image_most_levels(image->width, image->height));
	view.storage = (levels - 1) << IMAGE_LEVEL_SHIFT;
	return view;
}

uint64_t image_levels_size(const stilb_image *image, uint32_t levels)
{
	stilb_image level = *image;
	uint64_t size = 0;
	for (uint32_t l = 0; l < levels; l++) {
		size += stilb_image_size(&level);
		image_level_halve(&level);
	}
	return size;
}

uint64_t stilb_image_levels_size(const stilb_image *image)
{
	return image_levels_size(image, stilb_image_level_count(image));
}

bool image_levels_allocate(stilb_image *image, uint32_t levels)
{
	STILB_ASSERT(levels >= 1 && levels <= IMAGE_MAX_LEVELS);
	image->pixels = stilb_memory_alloc(image_levels_size(image, levels), 1);
	image->storage = image->pixels ? (levels - 1) << IMAGE_LEVEL_SHIFT : IMAGE_STORAGE_MEMORY;
	return image->pixels;
}

/* image_shape_check, of the number of levels too. */
static stilb_result image_levels_check(stilb_image *image, uint32_t width, uint32_t height, uint32_t channels,
                                       stilb_image_format format, uint32_t levels)
{
	stilb_result result = image_shape_check(image, width, height, channels, format);
	if (result != STILB_OK)
		return result;
	bool right = levels >= 1 && levels <= image_most_levels(width, height);
	if (right && image_levels_size(image, levels) <= STILB_IMAGE_MAX_BYTES)
		return STILB_OK;
	*image = (stilb_image){0};
	return stilb_fail(STILB_ERROR_ARGUMENT,
	                  "cannot make a picture of %u x %u pixels with %u mip levels: it has 1 to %u, of 4 GiB together",
	                  width, height, levels, image_most_levels(width, height));
}

stilb_result stilb_image_create_levels(stilb_image *image, uint32_t width, uint32_t height, uint32_t channels,
                                       stilb_image_format format, uint32_t levels)
{
	stilb_result result = image_levels_check(image, width, height, channels, format, levels);
	if (result != STILB_OK)
		return result;
	if (!image_levels_allocate(image, levels))
		return image_no_memory(image);
	memset(image->pixels, 0, stilb_image_levels_size(image));
	return STILB_OK;
}

/* ---- the end ----------------------------------------------------------------------------------------------------- */

/* Where the pixels are: storage without its count of levels. */
static uint32_t image_place(const stilb_image *image)
{
	return image->storage & ((1u << IMAGE_LEVEL_SHIFT) - 1);
}

/* The descriptor of the memory file that the picture is in. */
static int image_memory_file(const stilb_image *image)
{
	STILB_ASSERT(image_place(image) >= IMAGE_STORAGE_SHARED && "made by stilb_image_create_shared");
	return (int)(image_place(image) - IMAGE_STORAGE_SHARED);
}

/* Bytes of that memory file, which may hold more than the picture. */
static size_t image_memory_size(const stilb_image *image)
{
	struct stat info = {0};
	fstat(image_memory_file(image), &info); /* cannot fail: the descriptor is open */
	STILB_ASSERT((uint64_t)info.st_size >= stilb_image_levels_size(image));
	return (size_t)info.st_size;
}

void stilb_image_finish(stilb_image *image)
{
	if (!image)
		return;
	STILB_ASSERT((image->pixels || image->storage == IMAGE_STORAGE_MEMORY) && "mapped memory has an address");
	if (image_place(image) == IMAGE_STORAGE_MEMORY)
		free(image->pixels);
	else if (image_place(image) == IMAGE_STORAGE_MAPPED)
		munmap(image->pixels, stilb_image_levels_size(image));
	else
		munmap(image->pixels, image_memory_size(image));
	if (image_place(image) >= IMAGE_STORAGE_SHARED)
		close(image_memory_file(image));
	*image = (stilb_image){0};
}

/* ---- halves ------------------------------------------------------------------------------------------------------ */

uint16_t stilb_image_half_from_float(float value)
{
	uint32_t bits;
	memcpy(&bits, &value, sizeof bits);
	uint32_t sign = bits >> 16 & 0x8000u, exponent = bits >> 23 & 0xffu;
	if (exponent < 102) /* below half of the smallest half, 2^-25 */
		return (uint16_t)sign;
	if (exponent > 142) /* at least 65536, or NaN */
		return (uint16_t)(sign | (isnan(value) ? 0x7e00u : 0x7c00u));
	uint32_t mantissa = (bits & 0x7fffffu) | 0x800000u;
	uint32_t shift = exponent < 113 ? 126 - exponent : 13; /* smaller than 2^-14: denormal */
	uint32_t kept = mantissa >> shift, rest = mantissa & ((1u << shift) - 1), tie = 1u << (shift - 1);
	kept += rest > tie || (rest == tie && (kept & 1u)); /* a carry goes on into the exponent, up to infinity */
	return (uint16_t)(sign | (exponent < 113 ? kept : kept + ((exponent - 113) << 10)));
}

/* ---- pictures that one process hands to another ------------------------------------------------------------------ */

#define IMAGE_SEALS (F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_WRITE)

/* Pictures up to this many bytes get their memory when they are mapped, which is faster than page by page. Larger ones
 * get it when they are written: a short file may claim a huge picture. */
#define IMAGE_POPULATE_MAX (16u << 20)

/* Maps new memory for image's shape with so many levels. False: there is none. */
static bool image_memory_create(stilb_image *image, uint32_t levels)
{
	size_t size = image_levels_size(image, levels);
	int file = memfd_create("picture", MFD_CLOEXEC | MFD_ALLOW_SEALING);
	void *pixels = MAP_FAILED;
	if (file >= 0 && ftruncate(file, (off_t)size) == 0)
		pixels = mmap(NULL, size, PROT_READ | PROT_WRITE, MAP_SHARED | (size <= IMAGE_POPULATE_MAX ? MAP_POPULATE : 0),
		              file, 0);
	if (pixels == MAP_FAILED) {
		if (file >= 0)
			close(file);
		return false;
	}
	image->pixels = pixels;
	image->storage = (IMAGE_STORAGE_SHARED + (uint32_t)file) | (levels - 1) << IMAGE_LEVEL_SHIFT;
	return true;
}

/* stilb_image_reshape_shared with levels. */
static stilb_result image_reshape_levels(stilb_image *image, const stilb_image *shape, uint32_t levels)
{
	stilb_image old = *image;
	stilb_result result = image_shape_check(image, shape->width, shape->height, shape->channels, shape->format);
	STILB_ASSERT(result != STILB_OK || levels <= image_most_levels(shape->width, shape->height));
	if (result == STILB_OK && old.pixels && image_memory_size(&old) >= image_levels_size(image, levels)) {
		image->pixels = old.pixels;
		image->storage = image_place(&old) | (levels - 1) << IMAGE_LEVEL_SHIFT;
		return STILB_OK;
	}
	stilb_image_finish(&old);
	if (result == STILB_OK && !image_memory_create(image, levels))
		result = image_no_memory(image);
	STILB_ASSERT(result != STILB_OK || image_is_sound(image));
	return result;
}

stilb_result stilb_image_reshape_shared(stilb_image *image, uint32_t width, uint32_t height, uint32_t channels,
                                        stilb_image_format format)
{
	STILB_ASSERT(image);
	stilb_image shape = {.width = width, .height = height, .channels = channels, .format = format};
	return image_reshape_levels(image, &shape, 1);
}

stilb_result stilb_image_create_shared(stilb_image *image, uint32_t width, uint32_t height, uint32_t channels,
                                       stilb_image_format format)
{
	STILB_ASSERT(image);
	*image = (stilb_image){0};
	return stilb_image_reshape_shared(image, width, height, channels, format);
}

int stilb_image_share(stilb_image *image)
{
	int file = image_memory_file(image);
	size_t size = stilb_image_levels_size(image);
	STILB_ASSERT(image_is_sound(image));
	munmap(image->pixels, image_memory_size(image)); /* a writable mapping would forbid F_SEAL_WRITE */
	*image = (stilb_image){0};
	if (ftruncate(file, (off_t)size) == 0 && fcntl(file, F_ADD_SEALS, IMAGE_SEALS | F_SEAL_SEAL) == 0)
		return file;
	stilb_fail(STILB_ERROR_FILE, "a picture's memory cannot be sealed: %s", strerror(errno));
	close(file);
	return -1;
}

int stilb_image_lend(const stilb_image *image)
{
	int file = image_memory_file(image);
	STILB_ASSERT(image_is_sound(image));
	STILB_ASSERT(stilb_image_levels_size(image) <= STILB_IMAGE_LEND_MAX);
	return file;
}

/* Copies image's pixels, of so many levels, from a memory file that other processes may write to. */
static stilb_result image_copy_lent(int file, uint32_t levels, stilb_image *image)
{
	size_t size = image_levels_size(image, levels);
	if (!image_levels_allocate(image, levels))
		return image_no_memory(image);
	if (pread(file, image->pixels, size, 0) == (ssize_t)size)
		return STILB_OK;
	stilb_image_finish(image);
	return stilb_fail(STILB_ERROR_FILE, "a picture's memory is smaller than its shape needs");
}

stilb_result stilb_image_receive(int file, uint32_t width, uint32_t height, uint32_t channels,
                                 stilb_image_format format, uint32_t levels, stilb_image *image)
{
	stilb_result result = image_levels_check(image, width, height, channels, format, levels);
	if (result != STILB_OK)
		return result;
	STILB_ASSERT(file >= 0);
	struct stat info;
	size_t size = image_levels_size(image, levels);
	int seals = fcntl(file, F_GET_SEALS); /* fails for everything but memory files: reading these never waits */
	bool sealed = seals >= 0 && (seals & IMAGE_SEALS) == IMAGE_SEALS;
	if (seals >= 0 && !sealed && size <= STILB_IMAGE_LEND_MAX)
		return image_copy_lent(file, levels, image);
	if (!sealed || fstat(file, &info) != 0 || (size_t)info.st_size != size) {
		*image = (stilb_image){0};
		return stilb_fail(STILB_ERROR_FILE,
		                  "a picture's memory is not sealed, or not of the size that its shape needs");
	}
	void *pixels = mmap(NULL, size, PROT_READ | PROT_WRITE, MAP_PRIVATE, file, 0);
	if (pixels == MAP_FAILED)
		return image_no_memory(image);
	image->pixels = pixels;
	image->storage = IMAGE_STORAGE_MAPPED | (levels - 1) << IMAGE_LEVEL_SHIFT;
	STILB_ASSERT(image_is_sound(image));
	return STILB_OK;
}

stilb_result stilb_image_copy(const stilb_image *image, bool shared, stilb_image *copy)
{
	STILB_ASSERT(image && copy);
	stilb_image from = *image;
	uint32_t levels = stilb_image_level_count(image);
	const char *refusal = from.pixels ? image_refusal(&from) : "it is empty";
	*copy = (stilb_image){0};
	if (refusal)
		return stilb_fail(STILB_ERROR_ARGUMENT, "cannot copy a picture of %u x %u pixels: %s", from.width, from.height,
		                  refusal);
	stilb_result result = STILB_OK;
	if (shared) {
		result = image_reshape_levels(copy, &from, levels);
	} else {
		*copy = from;
		result = image_levels_allocate(copy, levels) ? STILB_OK : image_no_memory(copy);
	}
	if (result == STILB_OK)
		memcpy(copy->pixels, from.pixels, stilb_image_levels_size(&from));
	return result;
}

/* ---- shared by the codecs ---------------------------------------------------------------------------------------- */

void image_message_set(image_message *message, const char *text)
{
	STILB_ASSERT(message && text);
	snprintf(message->text, sizeof message->text, "%.*s", (int)strcspn(text, "\n"), text);
}

void *image_load_make(image_load *load, stilb_image made, uint32_t levels)
{
	STILB_ASSERT(!load->image->pixels && "a codec allocates once");
	stilb_image light = {made.width, made.height, 3, STILB_IMAGE_F32_LINEAR, NULL, 0};
	const char *refusal = image_refusal(&made);
	if (!refusal && load->for_light)
		refusal = image_refusal(&light);
	if (refusal) {
		load->result = stilb_fail(STILB_ERROR_FILE, "cannot read '%s': it has %u x %u pixels; %s", load->path,
		                          made.width, made.height, refusal);
		return NULL;
	}
	if (load->shared) {
		image_reshape_levels(&load->memory, &made, levels);
		made = load->memory;
		load->memory = (stilb_image){0};
	} else {
		image_levels_allocate(&made, levels);
	}
	if (!made.pixels)
		load->result = stilb_fail(STILB_ERROR_MEMORY, "cannot read '%s': out of memory", load->path);
	else
		*load->image = made;
	return made.pixels;
}

bool image_bytes_write(image_bytes *bytes, size_t offset, const void *data, size_t size)
{
	STILB_ASSERT(offset <= bytes->size && "no gap");
	STILB_ASSERT(bytes->size <= bytes->capacity && (bytes->data || bytes->capacity == 0));
	if (offset + size > bytes->capacity) {
		size_t capacity = (offset + size) / 2 * 3 + 65536;
		unsigned char *grown = realloc(bytes->data, capacity);
		if (!grown)
			return false;
		bytes->data = grown;
		bytes->capacity = capacity;
	}
	memcpy(bytes->data + offset, data, size);
	if (offset + size > bytes->size)
		bytes->size = offset + size;
	return true;
}
