#include "image/image_layers.h"

#include "base/base_file.h"
#include "image/image_exr.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* The reason why a picture of this shape is refused, or NULL. Sides and channels are bounded first, so that the product
 * cannot overflow. */
static const char *layers_refusal(uint32_t width, uint32_t height, uint32_t channels)
{
	if (width < 1 || height < 1 || width > STILB_IMAGE_MAX_SIDE || height > STILB_IMAGE_MAX_SIDE)
		return "width and height must be 1 to 65536";
	if (channels < 1 || channels > STILB_IMAGE_MAX_CHANNELS)
		return "1 to 64 channels are supported";
	if ((uint64_t)width * height * channels * sizeof(float) > STILB_IMAGE_MAX_BYTES)
		return "its pixels would take more than 4 GiB";
	return NULL;
}

static bool layers_path_is_exr(const char *path)
{
	size_t length = strlen(path);
	return length > 4 && strcasecmp(path + length - 4, ".exr") == 0;
}

/* STILB_ERROR_ARGUMENT if two channels have the same name, of which a reader would find only one, or one has none. */
static stilb_result layers_names_check(const stilb_image_layers *layers, const char *path)
{
	for (uint32_t i = 0; i < layers->channel_count; i++) {
		const char *name = layers->channels[i].name;
		if (!name[0])
			return stilb_fail(STILB_ERROR_ARGUMENT, "cannot write '%s': channel %u has no name", path, i);
		for (uint32_t j = 0; j < i; j++) {
			if (strcmp(layers->channels[j].name, name) == 0)
				return stilb_fail(STILB_ERROR_ARGUMENT, "cannot write '%s': it has the channel '%s' twice", path, name);
		}
	}
	return STILB_OK;
}

/* ---- saving ------------------------------------------------------------------------------------------------------ */

static image_outcome layers_encode(const stilb_image_layers *layers, image_bytes *file, image_message *message)
{
	image_exr_channel channels[STILB_IMAGE_MAX_CHANNELS];
	for (uint32_t i = 0; i < layers->channel_count; i++) {
		const stilb_image_channel *channel = &layers->channels[i];
		STILB_ASSERT(channel->values && channel->stride >= 1);
		size_t step = channel->stride * sizeof(float);
		channels[i] = (image_exr_channel){channel->name, channel->values, step, step * layers->width};
	}
	image_exr_file from = {.width = layers->width,
	                       .height = layers->height,
	                       .channel_count = layers->channel_count,
	                       .attribute_count = layers->attribute_count,
	                       .channels = channels,
	                       .attributes = layers->attributes,
	                       .scalar = IMAGE_SCALAR_F32,
	                       .stored = IMAGE_SCALAR_F32};
	return image_exr_encode(&from, file, message);
}

stilb_result stilb_image_layers_save(const stilb_image_layers *layers, const char *path)
{
	STILB_ASSERT(layers && path);
	STILB_ASSERT((layers->channels || layers->channel_count == 0) &&
	             (layers->attributes || layers->attribute_count == 0));
	const char *refusal = layers_refusal(layers->width, layers->height, layers->channel_count);
	if (!layers_path_is_exr(path))
		refusal = "pictures of many channels are .exr";
	if (refusal)
		return stilb_fail(STILB_ERROR_ARGUMENT, "cannot write '%s': %s", path, refusal);
	stilb_result checked = layers_names_check(layers, path);
	if (checked == STILB_OK)
		checked = stilb_file_check(path); /* before the work of encoding */
	if (checked != STILB_OK)
		return checked;
	image_bytes file = {0};
	image_message message = {0};
	image_outcome outcome = layers_encode(layers, &file, &message);
	stilb_result result = outcome == IMAGE_OUTCOME_DONE ? stilb_file_save(path, file.data, file.size)
	                                                    : image_fail(outcome, "write", path, &message);
	free(file.data);
	return result;
}

/* ---- loading ----------------------------------------------------------------------------------------------------- */

/* A loaded picture with its memory. layers is the public part, and the first member, so that finish finds the rest. */
typedef struct layers_owned {
	stilb_image_layers layers;
	stilb_image_channel *channels; /* [channel_capacity]; the same as layers.channels */
	uint32_t channel_capacity;
	stilb_image_attribute *attributes; /* the same as layers.attributes */
	float *pixels;                     /* [height][width][channel_capacity] */
} layers_owned;

typedef struct layers_load {
	const char *path;
	layers_owned *owned;
	stilb_result result;
} layers_load;

static float *layers_load_create(void *context, uint32_t width, uint32_t height, uint32_t channels)
{
	layers_load *load = context;
	STILB_ASSERT(!load->owned->pixels && "the decoder creates once");
	const char *refusal = layers_refusal(width, height, channels);
	if (refusal) {
		load->result = stilb_fail(STILB_ERROR_FILE, "cannot read '%s': it has %u x %u pixels and %u channels; %s",
		                          load->path, width, height, channels, refusal);
		return NULL;
	}
	layers_owned *owned = load->owned;
	owned->layers = (stilb_image_layers){.width = width, .height = height};
	owned->pixels = stilb_memory_alloc((size_t)width * height * channels, sizeof(float));
	owned->channels = calloc(channels, sizeof *owned->channels);
	owned->channel_capacity = channels;
	owned->layers.channels = owned->channels;
	for (uint32_t i = 0; owned->pixels && owned->channels && i < channels; i++)
		owned->channels[i] = (stilb_image_channel){.values = owned->pixels + i, .stride = channels};
	return owned->channels ? owned->pixels : NULL;
}

static bool layers_load_channel(void *context, const char *name)
{
	layers_owned *owned = ((layers_load *)context)->owned;
	STILB_ASSERT(owned->layers.channel_count < owned->channel_capacity);
	char *copy = strdup(name);
	if (copy)
		owned->channels[owned->layers.channel_count++].name = copy;
	return copy;
}

static bool layers_load_attribute(void *context, const char *name, const char *text)
{
	layers_owned *owned = ((layers_load *)context)->owned;
	uint32_t count = owned->layers.attribute_count;
	stilb_image_attribute *grown = realloc(owned->attributes, (count + 1) * sizeof *grown);
	if (!grown)
		return false;
	owned->layers.attributes = owned->attributes = grown;
	grown[count] = (stilb_image_attribute){.name = strdup(name), .text = strdup(text)};
	owned->layers.attribute_count++;
	return grown[count].name && grown[count].text;
}

static image_outcome layers_decode(layers_load *load, image_message *message)
{
	void *data = NULL;
	size_t size = 0;
	image_exr_sink sink = {load, layers_load_create, layers_load_channel, layers_load_attribute};
	image_outcome outcome = IMAGE_OUTCOME_CODEC;
	const char *trouble = image_file_read(load->path, &data, &size);
	if (trouble)
		image_message_set(message, trouble);
	else
		outcome = image_exr_decode(data, size, &sink, message);
	free(data);
	return outcome;
}

stilb_result stilb_image_layers_load(const char *path, stilb_image_layers **layers)
{
	STILB_ASSERT(path && layers);
	*layers = NULL;
	if (!layers_path_is_exr(path))
		return stilb_fail(STILB_ERROR_ARGUMENT, "cannot read '%s': pictures of many channels are .exr", path);
	layers_load load = {.path = path, .owned = calloc(1, sizeof *load.owned), .result = STILB_OK};
	if (!load.owned)
		return stilb_fail(STILB_ERROR_MEMORY, "cannot read '%s': out of memory", path);
	image_message message = {0};
	image_outcome outcome = layers_decode(&load, &message);
	if (outcome == IMAGE_OUTCOME_DONE) {
		STILB_ASSERT(load.owned->layers.channel_count == load.owned->channel_capacity && "every channel has a name");
		*layers = &load.owned->layers;
		return STILB_OK;
	}
	stilb_image_layers_finish(&load.owned->layers);
	if (outcome == IMAGE_OUTCOME_CALLBACK && load.result != STILB_OK)
		return load.result;
	return image_fail(outcome == IMAGE_OUTCOME_CALLBACK ? IMAGE_OUTCOME_MEMORY : outcome, "read", path, &message);
}

void stilb_image_layers_finish(stilb_image_layers *layers)
{
	if (!layers)
		return;
	layers_owned *owned = (layers_owned *)layers; /* layers is its first member */
	STILB_ASSERT(layers->channels == owned->channels && "a loaded picture");
	for (uint32_t i = 0; i < layers->channel_count; i++)
		free((char *)owned->channels[i].name);
	for (uint32_t i = 0; i < layers->attribute_count; i++) {
		free((char *)owned->attributes[i].name);
		free((char *)owned->attributes[i].text);
	}
	free(owned->channels);
	free(owned->attributes);
	free(owned->pixels);
	free(owned);
}

const stilb_image_channel *stilb_image_layers_channel(const stilb_image_layers *layers, const char *name)
{
	STILB_ASSERT(layers && name);
	for (uint32_t i = 0; i < layers->channel_count; i++) {
		if (strcmp(layers->channels[i].name, name) == 0)
			return &layers->channels[i];
	}
	return NULL;
}

const char *stilb_image_layers_attribute(const stilb_image_layers *layers, const char *name)
{
	STILB_ASSERT(layers && name);
	for (uint32_t i = 0; i < layers->attribute_count; i++) {
		if (strcmp(layers->attributes[i].name, name) == 0)
			return layers->attributes[i].text;
	}
	return NULL;
}
