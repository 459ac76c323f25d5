/* Loads textures that lie in the scene's file itself or in files of their own. */
#include "scene/importer/importer.h"

#include "image/image_import.h"
#include "shading/shade_srgb.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* ---- in the scene's file ----------------------------------------------------------------------------------------- */

/* The texture in the scene's file that a material calls name: "*N" is number N, others have the same last name. NULL:
 * it is a file of its own. */
static const struct aiTexture *texture_embedded(const importer *import, const char *name)
{
	const struct aiScene *from = import->from;
	if (name[0] == '*') {
		char *end;
		unsigned long index = strtoul(name + 1, &end, 10);
		return end > name + 1 && index < from->mNumTextures ? from->mTextures[index] : NULL;
	}
	const char *slash = strrchr(name, '/'), *last = slash ? slash + 1 : name;
	for (uint32_t i = 0; i < from->mNumTextures; i++) {
		const char *own = from->mTextures[i]->mFilename.data, *own_slash = strrchr(own, '/');
		if (own[0] && strcmp(own_slash ? own_slash + 1 : own, last) == 0)
			return from->mTextures[i];
	}
	return NULL;
}

static stilb_result texture_from_texels(const struct aiTexture *texture, stilb_image *image)
{
	if (!texture->pcData)
		return stilb_fail(STILB_ERROR_FILE, "it is empty");
	stilb_result result = stilb_image_create_shared(image, texture->mWidth, texture->mHeight, 3, STILB_IMAGE_U8_SRGB);
	uint8_t *out = image->pixels;
	for (size_t i = 0; result == STILB_OK && i < (size_t)texture->mWidth * texture->mHeight; i++) {
		*out++ = texture->pcData[i].r;
		*out++ = texture->pcData[i].g;
		*out++ = texture->pcData[i].b;
	}
	return result;
}

/* Decodes a file that lies inside of the scene's. */
static stilb_result texture_from_inside(importer_texture *texture)
{
	char called[MAXLEN + HINTMAXTEXTURELEN + 2]; /* with the ending that tells TGA */
	if (texture->inside.size == 0)
		return stilb_fail(STILB_ERROR_FILE, "it is empty");
	snprintf(called, sizeof called, "%s.%s", texture->name, texture->hint);
	return importer_decode(called, &texture->inside, STILB_IMAGE_IMPORT_BLOCKS, &texture->image);
}

/* ---- means ------------------------------------------------------------------------------------------------------- */

/* The channel of red, green, blue or alpha, i = 0..3: of one or two channels the first is grey. -1: it has no alpha. */
static int texture_channel(const stilb_image *image, int i)
{
	STILB_ASSERT(i < 4);
	if (i == 3)
		return image->channels % 2 == 0 ? (int)image->channels - 1 : -1;
	return image->channels < 3 ? 0 : i;
}

/* The means of one channel of a picture of 8-bit codes, by a histogram. light: as light; NULL: not asked for. */
static float texture_average_channel(const stilb_image *image, int channel, float *light)
{
	size_t count = (size_t)image->width * image->height;
	const uint8_t *code = (const uint8_t *)image->pixels + channel;
	uint64_t times[256] = {0};
	double sum = 0, stored = 0;
	for (size_t p = 0; p < count; p++, code += image->channels)
		times[*code]++;
	for (int c = 0; c < 256; c++) {
		stored += (double)times[c] * c / 255.0;
		if (light && times[c])
			sum += (double)times[c] * (double)shade_srgb_to_linear((float)c / 255.0f);
	}
	if (light)
		*light = (float)(sum / (double)count);
	return (float)(stored / (double)count);
}

/* The means of a picture of 8-bit codes. */
static void texture_average_codes(importer_texture *texture, const stilb_image *image)
{
	STILB_ASSERT(image->format == STILB_IMAGE_U8_SRGB && image->pixels);
	for (int i = 0; i < 4; i++) {
		int channel = texture_channel(image, i);
		bool again = i > 0 && channel == texture_channel(image, i - 1); /* grey */
		if (i < 3 && again)
			texture->mean[i] = texture->mean[i - 1];
		texture->stored_mean[i] = channel < 0 ? 1.0f
		                          : again     ? texture->stored_mean[i - 1]
		                                  : texture_average_channel(image, channel, i < 3 ? &texture->mean[i] : NULL);
	}
}

/* Adds a row's values to the sums. light: of the row. */
static void texture_add_row(const stilb_image *image, uint32_t y, const float *light, double sum[4], double stored[4])
{
	size_t row = (size_t)image->width * image->channels;
	for (size_t x = 0; x < image->width; x++)
		for (int i = 0; i < 4; i++) {
			int channel = texture_channel(image, i);
			size_t at = x * image->channels + (size_t)(channel < 0 ? 0 : channel);
			sum[i] += (double)light[at];
			stored[i] += channel < 0 ? 1.0
			             : image->format == STILB_IMAGE_U16_SRGB
			                 ? ((const uint16_t *)image->pixels)[y * row + at] / 65535.0
			                 : (double)light[at];
		}
}

/* Sets a texture's means to those of these texels. STILB_ERROR_MEMORY. */
static stilb_result texture_average_of(importer_texture *texture, const stilb_image *image)
{
	if (image->format == STILB_IMAGE_U8_SRGB) {
		texture_average_codes(texture, image);
		return STILB_OK;
	}
	double count = (double)image->width * (double)image->height, sum[4] = {0}, stored[4] = {0};
	float *light = malloc((size_t)image->width * image->channels * sizeof *light);
	if (!light)
		return stilb_fail(STILB_ERROR_MEMORY, "out of memory");
	for (uint32_t y = 0; y < image->height; y++) {
		stilb_image_row_to_light(image, y, light);
		texture_add_row(image, y, light, sum, stored);
	}
	free(light);
	for (int i = 0; i < 4; i++) {
		if (i < 3)
			texture->mean[i] = (float)(sum[i] / count);
		texture->stored_mean[i] = (float)(stored[i] / count);
	}
	return STILB_OK;
}

/* Sets the means of a loaded texture. STILB_ERROR_MEMORY. */
static stilb_result texture_average(importer_texture *texture)
{
	stilb_image texels;
	if (!stilb_image_format_is_blocks(texture->image.format))
		return texture_average_of(texture, &texture->image);
	stilb_result result = stilb_image_decode(&texture->image, &texels);
	if (result == STILB_OK)
		result = texture_average_of(texture, &texels);
	stilb_image_finish(&texels);
	return result;
}

/* ---- all --------------------------------------------------------------------------------------------------------- */

static void texture_load(importer_texture *texture)
{
	importer_bytes bytes = {0};
	stilb_result result;
	if (texture->texels)
		result = texture_from_texels(texture->texels, &texture->image);
	else if (texture->inside.data)
		result = texture_from_inside(texture);
	else if (texture->file < 0)
		return; /* importer_files_ask has set its trouble */
	else if (!importer_bytes_read(texture->file, &bytes))
		result = stilb_fail(STILB_ERROR_FILE, "it cannot be read, or is too large");
	else
		result = bytes.size ? importer_decode(texture->name, &bytes, STILB_IMAGE_IMPORT_BLOCKS, &texture->image)
		                    : stilb_fail(STILB_ERROR_FILE, "the file is empty");
	texture->file = -1;
	importer_bytes_free(&bytes);
	if (result == STILB_OK) {
		/* What it is used for, not what its file says, makes it data. */
		texture->image.format = stilb_image_format_as_color(texture->image.format);
		texture->file_width = texture->image.width;
		texture->file_height = texture->image.height;
		texture->mended = importer_mend_values(&texture->image);
		result = importer_mend_sides(&texture->image);
	}
	if (result == STILB_OK)
		result = texture_average(texture);
	if (result == STILB_OK)
		return;
	stilb_image_finish(&texture->image);
	snprintf(texture->trouble, sizeof texture->trouble, "%.255s", stilb_error_message());
}

typedef struct texture_queue {
	importer *import;
	pthread_t main;
	atomic_uint next, done;
} texture_queue;

/* Progress, which the main thread tells: also of what the others have done. */
static void texture_done(texture_queue *queue)
{
	/* relaxed: for progress alone */
	unsigned done = atomic_fetch_add_explicit(&queue->done, 1, memory_order_relaxed) + 1;
	if (pthread_equal(pthread_self(), queue->main))
		importer_advance_textures(done, queue->import->texture_count);
}

static void *texture_work(void *context)
{
	texture_queue *queue = context;
	for (;;) {
		/* relaxed: a number is given to one thread only; pthread_create and pthread_join order everything else */
		unsigned i = atomic_fetch_add_explicit(&queue->next, 1, memory_order_relaxed);
		if (i >= queue->import->texture_count)
			return NULL;
		texture_load(&queue->import->textures[i]);
		texture_done(queue);
	}
}

bool importer_texture_is_named(const struct aiString *path)
{
	return path->data[0] != '\0' && strcmp(path->data, "$texture_dummy.bmp") != 0;
}

/* Lists the material's texture of this kind, if there is one and it is not in the list yet. */
static void texture_list(importer *import, const struct aiMaterial *material, enum aiTextureType kind)
{
	struct aiString path;
	if (aiGetMaterialTexture(material, kind, 0, &path, NULL, NULL, NULL, NULL, NULL, NULL) != aiReturn_SUCCESS ||
	    !importer_texture_is_named(&path))
		return;
	for (uint32_t i = 0; i < import->texture_count; i++)
		if (strcmp(import->textures[i].name, path.data) == 0)
			return;
	importer_texture *texture = &import->textures[import->texture_count++];
	snprintf(texture->name, sizeof texture->name, "%s", path.data);
	texture->file = -1;
	const struct aiTexture *embedded = texture_embedded(import, texture->name);
	if (!embedded) {
		texture->file = importer_files_ask(texture->name, true, texture->trouble);
	} else if (embedded->mHeight == 0 && embedded->pcData) { /* a file, mWidth bytes long */
		texture->inside = (importer_bytes){(unsigned char *)embedded->pcData, embedded->mWidth};
		snprintf(texture->hint, sizeof texture->hint, "%.*s", HINTMAXTEXTURELEN - 1, embedded->achFormatHint);
	} else {
		texture->texels = embedded;
	}
}

/* Tells what was changed of a texture that was loaded. */
static void texture_tell(const importer_texture *texture)
{
	const stilb_image *image = &texture->image;
	if (!image->pixels)
		return;
	if (texture->mended > 0)
		importer_warn("texture '%s': %llu of its values are NaN or infinite, and count as 0", texture->name,
		              (unsigned long long)texture->mended);
	if (image->width != texture->file_width || image->height != texture->file_height)
		importer_warn("texture '%s': of its %u x %u pixels %u x %u are kept: a side has 16384 at most", texture->name,
		              texture->file_width, texture->file_height, image->width, image->height);
}

#define TEXTURE_THREADS 16

void importer_load_textures(importer *import)
{
	/* The kinds that importer_material.c reads. */
	static const enum aiTextureType kinds[] = {
		aiTextureType_BASE_COLOR,     aiTextureType_DIFFUSE,  aiTextureType_UNKNOWN, aiTextureType_DIFFUSE_ROUGHNESS,
		aiTextureType_EMISSION_COLOR, aiTextureType_EMISSIVE, aiTextureType_NORMALS};
	size_t most = sizeof kinds / sizeof *kinds * import->from->mNumMaterials;
	import->textures = calloc(most + 1, sizeof *import->textures);
	for (unsigned m = 0; import->textures && m < import->from->mNumMaterials; m++)
		for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++)
			texture_list(import, import->from->mMaterials[m], kinds[k]);
	STILB_ASSERT(import->texture_count <= most);
	importer_decode_textures(import);
}

void importer_decode_textures(importer *import)
{
	pthread_t threads[TEXTURE_THREADS];
	texture_queue queue = {.import = import, .main = pthread_self()};
	long cpus = sysconf(_SC_NPROCESSORS_ONLN);
	unsigned started = 0;
	while (started < TEXTURE_THREADS && started + 1 < import->texture_count && started + 1 < cpus &&
	       pthread_create(&threads[started], NULL, texture_work, &queue) == 0)
		started++;
	texture_work(&queue);
	for (unsigned i = 0; i < started; i++)
		pthread_join(threads[i], NULL);
	for (uint32_t i = 0; i < import->texture_count; i++)
		texture_tell(&import->textures[i]);
}

void importer_free_textures(importer *import)
{
	for (uint32_t i = 0; i < import->texture_count; i++)
		stilb_image_finish(&import->textures[i].image);
	free(import->textures);
}

bool importer_texture_is_there(importer *import, uint32_t index, const char *material, bool color)
{
	STILB_ASSERT(index < import->texture_count);
	importer_texture *texture = &import->textures[index];
	if (!texture->image.pixels && !texture->warned[color])
		importer_warn("material '%s': texture '%s': %s; %s", material, texture->name, texture->trouble,
		              color ? "the material becomes magenta" : "it is left out");
	texture->warned[color] |= !texture->image.pixels;
	return texture->image.pixels;
}

uint32_t importer_texture_of(importer *import, const char *name, const char *material, bool color)
{
	uint32_t i = 0;
	while (i < import->texture_count && strcmp(import->textures[i].name, name) != 0)
		i++;
	if (i == import->texture_count)
		return UINT32_MAX;
	return importer_texture_is_there(import, i, material, color) ? i : UINT32_MAX;
}

/* ---- into the scene ---------------------------------------------------------------------------------------------- */

/* Moves the picture of a number of importer_texture_number into the scene, or copies it if it is there with the other
 * meaning, and puts the scene's number in its place. */
static stilb_result texture_take(importer *import, uint32_t *number)
{
	if (*number == 0)
		return STILB_OK;
	stilb_scene *scene = import->scene;
	importer_texture *texture = &import->textures[(*number - 1) / 2];
	bool color = (*number - 1) % 2;
	stilb_image made = texture->image;
	stilb_result result = STILB_OK;
	STILB_ASSERT((*number - 1) / 2 < import->texture_count);
	if (texture->taken[color] == 0 && texture->taken[!color] > 0) {
		result = stilb_image_copy(&scene->textures[texture->taken[!color] - 1], true, &made);
		made.format = texture->format;
	}
	if (result == STILB_OK && texture->taken[color] == 0) {
		texture->format = made.format;
		made.format = color ? made.format : stilb_image_format_as_data(made.format);
		scene->textures[scene->texture_count++] = made;
		texture->image = (stilb_image){0};
		texture->taken[color] = scene->texture_count;
	}
	*number = texture->taken[color];
	return result;
}

stilb_result importer_take_textures(importer *import)
{
	stilb_scene *scene = import->scene;
	stilb_result result = scene_add_textures(scene, 2 * import->texture_count);
	if (result != STILB_OK)
		return result;
	scene->texture_count = 0;
	for (uint32_t m = 0; result == STILB_OK && m < scene->material_count; m++)
		result = texture_take(import, &scene->materials[m].diffuse_texture);
	for (uint32_t s = 0; result == STILB_OK && s < scene->surface_count; s++)
		for (int kind = 0; result == STILB_OK && kind < STILB_SCENE_MAPS; kind++)
			result = texture_take(import, &scene->surfaces[s].maps[kind].texture);
	return result;
}
