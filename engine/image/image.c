#include "image/image.h"

#include "base/base_file.h"
#include "image/image_internal.h"
#include "shading/shade_srgb.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

static const size_t IMAGE_SCALAR_BYTES[] = {
	[STILB_IMAGE_U8_SRGB] = 1, [STILB_IMAGE_F16_LINEAR] = 2, [STILB_IMAGE_F32_LINEAR] = 4};
static const image_scalar IMAGE_SCALARS[] = {[STILB_IMAGE_U8_SRGB] = IMAGE_SCALAR_U8,
                                             [STILB_IMAGE_F16_LINEAR] = IMAGE_SCALAR_F16,
                                             [STILB_IMAGE_F32_LINEAR] = IMAGE_SCALAR_F32};

/* ---- pictures in memory ------------------------------------------------------------------------------------------ */

size_t stilb_image_size(const stilb_image *image)
{
	return (size_t)image->width * image->height * image->channels * IMAGE_SCALAR_BYTES[image->format];
}

/* Why a picture of this shape is refused, or NULL. The sides are bounded first, so that the product cannot overflow. */
static const char *image_refusal(const stilb_image *image)
{
	if (image->width < 1 || image->height < 1 || image->width > STILB_IMAGE_MAX_SIDE ||
	    image->height > STILB_IMAGE_MAX_SIDE)
		return "width and height must be 1 to 65536";
	if (image->channels < 1 || image->channels > 4)
		return "1 to 4 channels are supported";
	if ((unsigned)image->format > STILB_IMAGE_F32_LINEAR)
		return "unknown pixel format";
	if (stilb_image_size(image) > STILB_IMAGE_MAX_BYTES)
		return "its pixels would take more than 4 GiB";
	return NULL;
}

stilb_result stilb_image_create(stilb_image *image, uint32_t width, uint32_t height, uint32_t channels,
                                stilb_image_format format)
{
	stilb_image made = {.width = width, .height = height, .channels = channels, .format = format};
	*image = (stilb_image){0};
	const char *refusal = image_refusal(&made);
	if (refusal)
		return stilb_fail(STILB_ERROR_ARGUMENT, "cannot make a picture of %u x %u pixels with %u channels: %s", width,
		                  height, channels, refusal);
	made.pixels = stilb_memory_alloc(stilb_image_size(&made), 1);
	if (!made.pixels)
		return stilb_fail(STILB_ERROR_MEMORY, "out of memory for a picture of %u x %u pixels", width, height);
	memset(made.pixels, 0, stilb_image_size(&made));
	*image = made;
	return STILB_OK;
}

void stilb_image_finish(stilb_image *image)
{
	if (!image)
		return;
	free(image->pixels);
	*image = (stilb_image){0};
}

/* ---- files --------------------------------------------------------------------------------------------------------- */

typedef struct image_kind {
	const char *extension;
	const char *codec;
} image_kind;

static const image_kind IMAGE_KINDS[] = {{".png", IMAGE_CODEC_PNG}, {".exr", IMAGE_CODEC_EXR}};

/* From the last name's extension; NULL with a message ("cannot <verb> ...") for an unknown one. A leading dot hides a file
 * and starts no extension. */
static const image_kind *image_kind_of(const char *path, const char *verb)
{
	const char *slash = strrchr(path, '/');
	const char *name = slash ? slash + 1 : path;
	const char *dot = strrchr(name, '.');
	if (!dot || dot == name) {
		stilb_fail(STILB_ERROR_ARGUMENT, "cannot %s '%s': it has no extension; pictures are .png or .exr", verb, path);
		return NULL;
	}
	for (size_t i = 0; i < sizeof IMAGE_KINDS / sizeof IMAGE_KINDS[0]; i++) {
		if (strcasecmp(dot, IMAGE_KINDS[i].extension) == 0)
			return &IMAGE_KINDS[i];
	}
	stilb_fail(STILB_ERROR_ARGUMENT, "cannot %s '%s': pictures of type '%s' are not supported; use .png or .exr", verb,
	           path, dot);
	return NULL;
}

stilb_result stilb_image_path_check(const char *path)
{
	image_message message;
	if (!image_kind_of(path, "write"))
		return STILB_ERROR_ARGUMENT;
	if (!image_codec_load(&message)) /* better now than after the work */
		return stilb_fail(STILB_ERROR_FILE, "cannot write '%s': %s", path, message.text);
	return stilb_file_check(path);
}

static stilb_result image_fail(image_outcome outcome, const char *verb, const char *path, const image_message *message)
{
	if (outcome == IMAGE_OUTCOME_MEMORY)
		return stilb_fail(STILB_ERROR_MEMORY, "cannot %s '%s': out of memory", verb, path);
	return stilb_fail(STILB_ERROR_FILE, "cannot %s '%s': %s", verb, path, message->text);
}

/* ---- conversion: the colour channels go through the transfer, alpha does not ----------------------------------------- */

static bool image_channel_is_alpha(const stilb_image *image, size_t index)
{
	uint32_t channels = image->channels;
	return channels % 2 == 0 && index % channels == channels - 1;
}

/* Exact: every binary16 is a float. */
static float image_half_to_float(uint16_t half)
{
	int exponent = half >> 10 & 31;
	float mantissa = (float)(half & 1023);
	float magnitude = exponent == 0 ? ldexpf(mantissa, -24) : ldexpf(mantissa + 1024.0f, exponent - 25);
	if (exponent == 31)
		magnitude = mantissa == 0.0f ? INFINITY : NAN;
	return half & 0x8000 ? -magnitude : magnitude;
}

static uint8_t image_code(float light, bool alpha)
{
	if (!(light > 0.0f))
		return 0; /* NaN too */
	float clamped = light < 1.0f ? light : 1.0f;
	float code = alpha ? clamped : shade_srgb_from_linear(clamped);
	return (uint8_t)(code * 255.0f + 0.5f);
}

static void image_convert_to_codes(const stilb_image *image, uint8_t *codes)
{
	const float *floats = image->pixels;
	const uint16_t *halves = image->pixels;
	size_t count = stilb_image_size(image) / IMAGE_SCALAR_BYTES[image->format];
	for (size_t i = 0; i < count; i++) {
		float light = image->format == STILB_IMAGE_F32_LINEAR ? floats[i] : image_half_to_float(halves[i]);
		codes[i] = image_code(light, image_channel_is_alpha(image, i));
	}
}

static void image_convert_to_light(const stilb_image *image, float *light)
{
	float table[256];
	for (int code = 0; code < 256; code++)
		table[code] = shade_srgb_to_linear((float)code / 255.0f);
	const uint8_t *codes = image->pixels;
	for (size_t i = 0; i < stilb_image_size(image); i++)
		light[i] = image_channel_is_alpha(image, i) ? (float)codes[i] / 255.0f : table[codes[i]];
}

/* ---- saving ------------------------------------------------------------------------------------------------------- */

typedef struct image_save {
	const char *path;
	stilb_result result;
} image_save;

static int image_save_sink(void *context, const void *data, size_t size)
{
	image_save *save = context;
	save->result = stilb_file_save(save->path, data, size);
	return save->result == STILB_OK ? 0 : -1;
}

/* What the encoder is given: the picture's own pixels, or a converted copy to be freed; and what the file holds. */
typedef struct image_source {
	image_shape shape;
	image_scalar stored;
	const void *pixels;
	void *converted;
} image_source;

static bool image_source_make(const stilb_image *image, const image_kind *kind, image_source *source)
{
	bool to_codes = strcmp(kind->codec, IMAGE_CODEC_PNG) == 0;
	image_scalar own = IMAGE_SCALARS[image->format];
	*source = (image_source){.shape = {image->width, image->height, image->channels, own}, .stored = own};
	source->pixels = image->pixels;
	if (to_codes == (image->format == STILB_IMAGE_U8_SRGB))
		return true;
	source->shape.scalar = to_codes ? IMAGE_SCALAR_U8 : IMAGE_SCALAR_F32;
	source->stored = to_codes ? IMAGE_SCALAR_U8 : IMAGE_SCALAR_F16; /* 8 bits of sRGB fit into halves */
	size_t count = (size_t)image->width * image->height * image->channels;
	source->converted = stilb_memory_alloc(count, to_codes ? sizeof(uint8_t) : sizeof(float));
	if (!source->converted)
		return false;
	if (to_codes)
		image_convert_to_codes(image, source->converted);
	else
		image_convert_to_light(image, source->converted);
	source->pixels = source->converted;
	return true;
}

stilb_result stilb_image_save(const stilb_image *image, const char *path)
{
	const image_kind *kind = image_kind_of(path, "write");
	if (!kind)
		return STILB_ERROR_ARGUMENT;
	const char *refusal = image->pixels ? image_refusal(image) : "the picture is empty";
	if (refusal)
		return stilb_fail(STILB_ERROR_ARGUMENT, "cannot write '%s': %s", path, refusal);
	stilb_result checked = stilb_file_check(path); /* before the work of encoding */
	if (checked != STILB_OK)
		return checked;
	image_source source;
	if (!image_source_make(image, kind, &source))
		return stilb_fail(STILB_ERROR_MEMORY, "cannot write '%s': out of memory", path);
	image_save save = {.path = path};
	image_message message = {0};
	image_outcome outcome = IMAGE_OUTCOME_CODEC;
	const image_codec *codec = image_codec_load(&message);
	if (codec)
		outcome =
			codec->encode(kind->codec, &source.shape, source.pixels, source.stored, image_save_sink, &save, &message);
	free(source.converted);
	if (outcome == IMAGE_OUTCOME_DONE || outcome == IMAGE_OUTCOME_CALLBACK)
		return save.result;
	return image_fail(outcome, "write", path, &message);
}

/* ---- loading ------------------------------------------------------------------------------------------------------ */

typedef struct image_load {
	const char *path;
	stilb_image *image;
	stilb_result result;
} image_load;

/* Pixels stay untouched until they are decoded: a short file that claims to be huge costs address space only. */
static void *image_load_allocate(void *context, const image_shape *shape)
{
	image_load *load = context;
	stilb_image made = {.width = shape->width, .height = shape->height, .channels = shape->channels};
	made.format = shape->scalar == IMAGE_SCALAR_U8 ? STILB_IMAGE_U8_SRGB : STILB_IMAGE_F32_LINEAR;
	const char *refusal = image_refusal(&made);
	if (refusal) {
		load->result = stilb_fail(STILB_ERROR_FILE, "cannot read '%s': it has %u x %u pixels; %s", load->path,
		                          made.width, made.height, refusal);
		return NULL;
	}
	made.pixels = stilb_memory_alloc(stilb_image_size(&made), 1);
	if (!made.pixels)
		load->result = stilb_fail(STILB_ERROR_MEMORY, "cannot read '%s': out of memory", load->path);
	else
		*load->image = made;
	return made.pixels;
}

const char *image_file_read(const char *path, void **data, size_t *size)
{
	struct stat info;
	if (stat(path, &info) != 0)
		return strerror(errno);
	if (!S_ISREG(info.st_mode))
		return S_ISDIR(info.st_mode) ? "it is a folder, not a file" : "it is not a regular file";
	if (info.st_size == 0)
		return "the file is empty";
	*size = (size_t)info.st_size;
	*data = malloc(*size);
	FILE *stream = fopen(path, "rb");
	if (!stream || !*data) {
		const char *why = strerror(errno);
		if (stream)
			fclose(stream);
		return why;
	}
	size_t got = fread(*data, 1, *size, stream);
	fclose(stream);
	return got == *size ? NULL : "the file ended early";
}

static image_outcome image_decode(const char *name, const void *data, size_t size, image_load *load,
                                  image_message *message)
{
	const image_codec *codec = image_codec_load(message);
	bool png = strcmp(name, IMAGE_CODEC_PNG) == 0;
	bool light = strcmp(name, IMAGE_CODEC_EXR) == 0 || strcmp(name, IMAGE_CODEC_HDR) == 0;
	if (!codec || (png && !image_png_is_whole(data, size, message)))
		return IMAGE_OUTCOME_CODEC;
	return codec->decode(name, data, size, light ? IMAGE_SCALAR_F32 : IMAGE_SCALAR_U8, image_load_allocate, load,
	                     message);
}

/* Leaves {0} in the picture unless all went well. */
static stilb_result image_load_end(image_load *load, image_outcome outcome, const image_message *message)
{
	if (outcome == IMAGE_OUTCOME_DONE)
		return STILB_OK;
	stilb_image_finish(load->image);
	return outcome == IMAGE_OUTCOME_CALLBACK ? load->result : image_fail(outcome, "read", load->path, message);
}

stilb_result stilb_image_load(const char *path, stilb_image *image)
{
	*image = (stilb_image){0};
	const image_kind *kind = image_kind_of(path, "read");
	if (!kind)
		return STILB_ERROR_ARGUMENT;
	image_load load = {.path = path, .image = image};
	image_message message = {0};
	image_outcome outcome = IMAGE_OUTCOME_CODEC;
	void *data = NULL;
	size_t size = 0;
	const char *trouble = image_file_read(path, &data, &size);
	if (trouble)
		snprintf(message.text, sizeof message.text, "%s", trouble);
	else
		outcome = image_decode(kind->codec, data, size, &load, &message);
	free(data);
	return image_load_end(&load, outcome, &message);
}

/* ---- pictures made elsewhere ------------------------------------------------------------------------------------- */

/* How files of a kind begin. RIFF and TIFF share their first bytes with others, which the decoder then refuses. */
static const struct image_signature {
	const char *bytes;
	size_t size;
	const char *codec;
} IMAGE_SIGNATURES[] = {
	{"\x89PNG", 4, IMAGE_CODEC_PNG},
	{"\x76\x2f\x31\x01", 4, IMAGE_CODEC_EXR},
	{"#?", 2, IMAGE_CODEC_HDR},
	{"\xff\xd8\xff", 3, "jpeg"},
	{"BM", 2, "bmp"},
	{"GIF8", 4, "gif"},
	{"DDS ", 4, "dds"},
	{"8BPS", 4, "psd"},
	{"II*\0", 4, "tiff"},
	{"MM\0*", 4, "tiff"},
	{"RIFF", 4, "webp"},
};

/* The codec for a file that begins so; TGA has no signature, so name decides there. NULL: none. */
static const char *image_codec_of(const char *name, const void *data, size_t size)
{
	for (size_t i = 0; i < sizeof IMAGE_SIGNATURES / sizeof *IMAGE_SIGNATURES; i++) {
		const struct image_signature *signature = &IMAGE_SIGNATURES[i];
		if (size >= signature->size && memcmp(data, signature->bytes, signature->size) == 0)
			return signature->codec;
	}
	const char *dot = strrchr(name, '.');
	return dot && strcasecmp(dot, ".tga") == 0 ? "targa" : NULL;
}

stilb_result stilb_image_import_memory(const char *name, const void *data, size_t size, stilb_image *image)
{
	*image = (stilb_image){0};
	image_load load = {.path = name, .image = image};
	image_message message = {.text = "it is no picture of a known kind"};
	const char *codec = image_codec_of(name, data, size);
	return image_load_end(&load, codec ? image_decode(codec, data, size, &load, &message) : IMAGE_OUTCOME_CODEC,
	                      &message);
}

stilb_result stilb_image_import(const char *path, stilb_image *image)
{
	*image = (stilb_image){0};
	void *data = NULL;
	size_t size = 0;
	const char *trouble = image_file_read(path, &data, &size);
	stilb_result result = trouble ? stilb_fail(STILB_ERROR_FILE, "cannot read '%s': %s", path, trouble)
	                              : stilb_image_import_memory(path, data, size, image);
	free(data);
	return result;
}

const char *stilb_image_library_version(void)
{
	image_message message;
	const image_codec *codec = image_codec_load(&message);
	return codec ? codec->version() : "not found";
}
