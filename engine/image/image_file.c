/* Pictures as files of our own codecs: saving with conversion, and loading by extension. */
#include "image/image.h"

#include "base/base_file.h"
#include "image/image_blocks.h"
#include "image/image_internal.h"
#include "image/image_srgb.h"
#include "shading/shade_srgb.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

static const image_codec *const image_codecs[] = {&image_codec_png, &image_codec_exr, &image_codec_hdr};

#define IMAGE_EXTENSIONS ".png, .exr or .hdr"
#define IMAGE_EXTENSIONS_READ ".png, .exr, .hdr or .dds"

/* The part of the last name from its last dot on, or NULL if there is none. A leading dot marks a hidden file, not an
 * extension. */
static const char *image_extension(const char *path)
{
	const char *slash = strrchr(path, '/');
	const char *name = slash ? slash + 1 : path;
	const char *dot = strrchr(name, '.');
	return dot == name ? NULL : dot;
}

static const image_codec *image_codec_find(const char *extension)
{
	for (size_t i = 0; i < sizeof image_codecs / sizeof image_codecs[0]; i++)
		if (strcasecmp(extension, image_codecs[i]->extension) == 0)
			return image_codecs[i];
	return NULL;
}

/* The codec for path's extension; NULL with a message if there is none. verb: "read" or "write". */
static const image_codec *image_codec_of(const char *path, const char *verb)
{
	const char *names = strcmp(verb, "read") == 0 ? IMAGE_EXTENSIONS_READ : IMAGE_EXTENSIONS;
	const char *extension = image_extension(path);
	const image_codec *codec = extension ? image_codec_find(extension) : NULL;
	if (!extension)
		stilb_fail(STILB_ERROR_ARGUMENT, "cannot %s '%s': it has no extension; pictures are %s", verb, path, names);
	else if (!codec)
		stilb_fail(STILB_ERROR_ARGUMENT, "cannot %s '%s': pictures of type '%s' are not supported; use %s", verb, path,
		           extension, names);
	return codec;
}

bool stilb_image_path_is_light(const char *path)
{
	STILB_ASSERT(path);
	const char *extension = image_extension(path);
	const image_codec *codec = extension ? image_codec_find(extension) : NULL;
	return codec && !codec->codes;
}

stilb_result stilb_image_path_check(const char *path)
{
	STILB_ASSERT(path);
	return image_codec_of(path, "write") ? stilb_file_check(path) : STILB_ERROR_ARGUMENT;
}

/* ---- conversion: the sRGB transfer applies to colour channels, not to alpha -------------------------------------- */

/* True if a value is of the alpha channel. index counts all values of all channels from the picture's first one. */
static bool image_channel_is_alpha(const stilb_image *image, size_t index)
{
	uint32_t channels = image->channels;
	return channels % 2 == 0 && index % channels == channels - 1;
}

static uint8_t image_code(float light, bool alpha)
{
	if (!(light > 0.0f))
		return 0; /* also NaN */
	float clamped = light < 1.0f ? light : 1.0f;
	float code = alpha ? clamped : shade_srgb_from_linear(clamped);
	return (uint8_t)(code * 255.0f + 0.5f);
}

static void image_convert_to_codes(const stilb_image *image, uint8_t *codes)
{
	image_scalar scalar = image_format_scalars[image->format];
	STILB_ASSERT(scalar != IMAGE_SCALAR_U8 && "codes need no conversion");
	const float *floats = image->pixels;
	const uint16_t *words = image->pixels;
	size_t count = (size_t)image->width * image->height * image->channels;
	for (size_t i = 0; i < count; i++) {
		if (scalar == IMAGE_SCALAR_U16) {
			codes[i] = (uint8_t)((words[i] * 255u + 32767u) / 65535u);
			continue;
		}
		float light = scalar == IMAGE_SCALAR_F32 ? floats[i] : stilb_image_half_to_float(words[i]);
		codes[i] = image_code(light, image_channel_is_alpha(image, i));
	}
}

const uint8_t *image_codes(const stilb_image *image, void **made)
{
	STILB_ASSERT(image_is_sound(image));
	*made = NULL;
	if (stilb_image_format_is_blocks(image->format)) {
		stilb_image texels;
		stilb_image_decode(image, &texels);
		const uint8_t *codes = texels.pixels ? image_codes(&texels, made) : NULL;
		if (codes != texels.pixels)
			stilb_image_finish(&texels);
		else
			*made = texels.pixels;
		return codes;
	}
	if (image_format_scalars[image->format] == IMAGE_SCALAR_U8)
		return image->pixels;
	*made = stilb_memory_alloc((size_t)image->width * image->height, image->channels);
	if (*made)
		image_convert_to_codes(image, *made);
	return *made;
}

/* Codes of 8 bits to linear floats; first as image_convert_to_light has it. */
static void image_bytes_to_light(const stilb_image *image, size_t first, size_t count, float *light)
{
	const uint8_t *codes = (const uint8_t *)image->pixels + first;
	bool srgb = image->format == STILB_IMAGE_U8_SRGB;
	for (size_t i = 0; i < count; i++) {
		bool linear = !srgb || image_channel_is_alpha(image, first + i);
		light[i] = linear ? (float)codes[i] / 255.0f : stilb_image_srgb_to_light[codes[i]];
	}
}

/* Converts `count` values of the picture, from value number `first` on, to linear floats. */
static void image_convert_to_light(const stilb_image *image, size_t first, size_t count, float *light)
{
	STILB_ASSERT(first + count <= (size_t)image->width * image->height * image->channels);
	STILB_ASSERT(!stilb_image_format_is_blocks(image->format));
	const uint16_t *words = (const uint16_t *)image->pixels + first;
	switch (image_format_scalars[image->format]) {
	case IMAGE_SCALAR_F32:
		memcpy(light, (const float *)image->pixels + first, count * sizeof *light);
		return;
	case IMAGE_SCALAR_U8:
		image_bytes_to_light(image, first, count, light);
		return;
	case IMAGE_SCALAR_F16:
		for (size_t i = 0; i < count; i++)
			light[i] = stilb_image_half_to_float(words[i]);
		return;
	case IMAGE_SCALAR_U16:
		for (size_t i = 0; i < count; i++) {
			bool linear = image->format == STILB_IMAGE_U16_LINEAR || image_channel_is_alpha(image, first + i);
			float code = (float)words[i] / 65535.0f;
			light[i] = linear ? code : shade_srgb_to_linear(code);
		}
		return;
	}
}

#define IMAGE_BLOCK_PART 256u /* texels of a row of blocks that are converted together; a multiple of 4 */

static void image_blocks_to_light(const stilb_image *image, uint32_t y, float *light)
{
	union {
		uint8_t bytes[4 * IMAGE_BLOCK_PART];
		uint16_t words[2 * IMAGE_BLOCK_PART];
	} texels;
	for (uint32_t x = 0; x < image->width; x += IMAGE_BLOCK_PART) {
		uint32_t count = image->width - x < IMAGE_BLOCK_PART ? image->width - x : IMAGE_BLOCK_PART;
		stilb_image part = {.width = count, .height = 1, .channels = image->channels, .pixels = &texels};
		part.format = image_block_formats[image->format].texels;
		image_block_row(image, image->pixels, y, x, count, &texels);
		image_convert_to_light(&part, 0, (size_t)count * part.channels, light + (size_t)x * part.channels);
	}
}

void stilb_image_row_to_light(const stilb_image *image, uint32_t y, float *light)
{
	size_t row = (size_t)image->width * image->channels;
	STILB_ASSERT(image_is_sound(image));
	STILB_ASSERT(y < image->height);
	STILB_ASSERT(light);
	if (stilb_image_format_is_blocks(image->format))
		image_blocks_to_light(image, y, light);
	else
		image_convert_to_light(image, y * row, row, light);
}

/* ---- saving ------------------------------------------------------------------------------------------------------ */

/* The input of an encoder. */
typedef struct image_source {
	image_input input; /* its pixels are the picture's own, or converted */
	void *converted;   /* to be freed; NULL if no conversion was needed */
} image_source;

/* PNG takes U8, EXR takes F16 and F32, HDR takes F32; others are converted. False: out of memory. */
static bool image_source_make(const stilb_image *image, const image_codec *codec, image_source *source)
{
	STILB_ASSERT(image_is_sound(image));
	image_scalar own = image_format_scalars[image->format];
	image_input *input = &source->input;
	*source = (image_source){{{image->width, image->height, image->channels, own}, own, image->pixels, 0, NULL}, NULL};
	bool floats = own == IMAGE_SCALAR_F32 || (own == IMAGE_SCALAR_F16 && codec == &image_codec_exr);
	if (codec->codes ? own == IMAGE_SCALAR_U8 : floats)
		return true;
	input->shape.scalar = codec->codes ? IMAGE_SCALAR_U8 : IMAGE_SCALAR_F32;
	input->stored = own == IMAGE_SCALAR_U16 ? IMAGE_SCALAR_F32 : IMAGE_SCALAR_F16; /* a half holds 8 bits of sRGB */
	size_t count = (size_t)image->width * image->height * image->channels;
	source->converted = stilb_memory_alloc(count, image_scalar_bytes[input->shape.scalar]);
	if (!source->converted)
		return false;
	if (codec->codes)
		image_convert_to_codes(image, source->converted);
	else
		image_convert_to_light(image, 0, count, source->converted);
	input->pixels = source->converted;
	return true;
}

stilb_result image_fail(image_outcome outcome, const char *verb, const char *path, const image_message *message)
{
	STILB_ASSERT(outcome == IMAGE_OUTCOME_MEMORY || outcome == IMAGE_OUTCOME_CODEC);
	if (outcome == IMAGE_OUTCOME_MEMORY)
		return stilb_fail(STILB_ERROR_MEMORY, "cannot %s '%s': out of memory", verb, path);
	return stilb_fail(STILB_ERROR_FILE, "cannot %s '%s': %s", verb, path, message->text);
}

stilb_result stilb_image_save(const stilb_image *image, const char *path)
{
	return stilb_image_save_with(image, path, NULL, 0);
}

/* True if every format can hold a text of this name. */
static bool image_name_is_sound(const char *name)
{
	size_t length = name ? strlen(name) : 0;
	if (length < 1 || length > 79 || name[0] == ' ' || name[length - 1] == ' ')
		return false;
	for (const char *c = name; *c; c++)
		if (*c < ' ' || *c > '~' || *c == '=')
			return false;
	return true;
}

/* stilb_image_save_with of the largest level of a picture of blocks. */
static stilb_result image_save_blocks(const stilb_image *image, const char *path,
                                      const stilb_image_attribute *attributes, uint32_t attribute_count)
{
	stilb_image texels;
	stilb_result result = stilb_image_decode(image, &texels);
	if (result == STILB_OK)
		result = stilb_image_save_with(&texels, path, attributes, attribute_count);
	stilb_image_finish(&texels);
	return result;
}

stilb_result stilb_image_save_with(const stilb_image *image, const char *path, const stilb_image_attribute *attributes,
                                   uint32_t attribute_count)
{
	STILB_ASSERT(image && path && (attributes || attribute_count == 0));
	for (uint32_t i = 0; i < attribute_count; i++)
		STILB_ASSERT(image_name_is_sound(attributes[i].name) && attributes[i].text);
	const image_codec *codec = image_codec_of(path, "write");
	if (!codec)
		return STILB_ERROR_ARGUMENT;
	const char *refusal = image->pixels ? image_refusal(image) : "the picture is empty";
	if (refusal)
		return stilb_fail(STILB_ERROR_ARGUMENT, "cannot write '%s': %s", path, refusal);
	if (stilb_image_format_is_blocks(image->format))
		return image_save_blocks(image, path, attributes, attribute_count);
	stilb_result result = stilb_file_check(path); /* before the work of encoding */
	if (result != STILB_OK)
		return result;
	image_source source;
	if (!image_source_make(image, codec, &source))
		return stilb_fail(STILB_ERROR_MEMORY, "cannot write '%s': out of memory", path);
	image_bytes file = {0};
	image_message message = {0};
	source.input.attribute_count = attribute_count;
	source.input.attributes = attributes;
	image_outcome outcome = codec->encode(&source.input, &file, &message);
	free(source.converted);
	if (outcome == IMAGE_OUTCOME_DONE)
		result = stilb_file_save(path, file.data, file.size);
	else
		result = image_fail(outcome, "write", path, &message);
	free(file.data);
	return result;
}

/* ---- loading ----------------------------------------------------------------------------------------------------- */

void *image_load_allocate(void *context, image_shape *shape)
{
	static const stilb_image_format formats[] = {[IMAGE_SCALAR_U8] = STILB_IMAGE_U8_SRGB,
	                                             [IMAGE_SCALAR_U16] = STILB_IMAGE_U16_SRGB,
	                                             [IMAGE_SCALAR_F16] = STILB_IMAGE_F16_LINEAR,
	                                             [IMAGE_SCALAR_F32] = STILB_IMAGE_F32_LINEAR};
	image_load *load = context;
	STILB_ASSERT((unsigned)shape->scalar <= IMAGE_SCALAR_U16);
	if (!load->exact && shape->scalar == IMAGE_SCALAR_U16)
		shape->scalar = IMAGE_SCALAR_U8;
	if (!load->exact && shape->scalar == IMAGE_SCALAR_F16)
		shape->scalar = IMAGE_SCALAR_F32;
	stilb_image made = {.width = shape->width, .height = shape->height, .channels = shape->channels};
	made.format = formats[shape->scalar];
	return image_load_make(load, made, 1);
}

/* Reads exactly size bytes. Returns NULL, or the reason of the failure. */
static const char *image_read_all(int file, char *data, size_t size)
{
	for (size_t got = 0; got < size;) {
		ssize_t more = read(file, data + got, size - got);
		if (more < 0 && errno == EINTR)
			continue;
		if (more <= 0)
			return more < 0 ? strerror(errno) : "the file ended early";
		got += (size_t)more;
	}
	return NULL;
}

const char *image_file_read(const char *path, void **data, size_t *size)
{
	STILB_ASSERT(path && size && data && !*data);
	struct stat info;
	int file = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK); /* of a pipe: without waiting for a writer */
	const char *trouble = NULL;
	if (file < 0 || fstat(file, &info) != 0)
		trouble = strerror(errno);
	else if (!S_ISREG(info.st_mode))
		trouble = S_ISDIR(info.st_mode) ? "it is a folder, not a file" : "it is not a regular file";
	else if (info.st_size == 0)
		trouble = "the file is empty";
	if (!trouble) {
		*size = (size_t)info.st_size; /* NOLINT(clang-analyzer-core.uninitialized.Assign): strerror is never NULL */
		*data = malloc(*size);
		trouble = *data ? image_read_all(file, *data, *size) : strerror(ENOMEM);
	}
	if (file >= 0)
		close(file);
	return trouble;
}

stilb_result image_load_end(image_load *load, image_outcome outcome, const image_message *message)
{
	STILB_ASSERT((outcome != IMAGE_OUTCOME_DONE || image_is_sound(load->image)) && "decoded into a picture");
	STILB_ASSERT((outcome != IMAGE_OUTCOME_CALLBACK || load->result != STILB_OK) && "a refusal has a result");
	stilb_image_finish(&load->memory);
	if (outcome == IMAGE_OUTCOME_DONE)
		return STILB_OK;
	stilb_image_finish(load->image);
	return outcome == IMAGE_OUTCOME_CALLBACK ? load->result : image_fail(outcome, "read", load->path, message);
}

stilb_result stilb_image_load(const char *path, stilb_image *image)
{
	STILB_ASSERT(path && image);
	*image = (stilb_image){0};
	const char *extension = image_extension(path);
	bool dds = extension && strcasecmp(extension, ".dds") == 0;
	const image_codec *codec = dds ? NULL : image_codec_of(path, "read");
	if (!codec && !dds)
		return STILB_ERROR_ARGUMENT;
	image_load load = {.path = path, .image = image, .blocks = true};
	image_message message = {0};
	image_outcome outcome = IMAGE_OUTCOME_CODEC;
	void *data = NULL;
	size_t size = 0;
	const char *trouble = image_file_read(path, &data, &size);
	if (trouble)
		image_message_set(&message, trouble);
	else if (codec)
		outcome = codec->decode(data, size, image_load_allocate, &load, &message);
	else
		outcome = image_dds_decode(data, size, &load, &message);
	free(data);
	return image_load_end(&load, outcome, &message);
}
