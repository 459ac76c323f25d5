#include "scene/scene_picture.h"

#include "scene/scene.h"
#include "shading/shade_srgb.h"

/* Channels of the source that stand for red, green and blue: with one or two it is grey. */
static uint32_t picture_channel(uint32_t channels, uint32_t i)
{
	return channels < 3 ? 0 : i;
}

stilb_result scene_picture_to_rgb(stilb_image *image)
{
	const bool codes = image->format == STILB_IMAGE_U8_SRGB;
	if (image->channels == 3)
		return STILB_OK;
	stilb_image rgb;
	stilb_result result = stilb_image_create(&rgb, image->width, image->height, 3, image->format);
	size_t count = (size_t)image->width * image->height;
	for (size_t p = 0; result == STILB_OK && p < count; p++)
		for (uint32_t i = 0; i < 3; i++) {
			size_t to = 3 * p + i, from = p * image->channels + picture_channel(image->channels, i);
			if (codes)
				((uint8_t *)rgb.pixels)[to] = ((const uint8_t *)image->pixels)[from];
			else
				((float *)rgb.pixels)[to] = ((const float *)image->pixels)[from];
		}
	stilb_image_finish(image);
	*image = rgb;
	return result;
}

stilb_result scene_picture_to_light(stilb_image *image)
{
	stilb_result result = scene_picture_to_rgb(image);
	if (result != STILB_OK)
		return result;
	stilb_image light;
	result = stilb_image_create(&light, image->width, image->height, 3, STILB_IMAGE_F32_LINEAR);
	const uint8_t *codes = image->format == STILB_IMAGE_U8_SRGB ? image->pixels : NULL;
	const float *floats = image->pixels;
	float table[256], *out = light.pixels;
	for (int code = 0; code < 256; code++)
		table[code] = shade_srgb_to_linear((float)code / 255.0f);
	size_t count = (size_t)image->width * image->height * 3;
	for (size_t i = 0; result == STILB_OK && i < count; i++) {
		float value = codes ? table[codes[i]] : floats[i];
		out[i] = value > 0.0f && value < INFINITY ? value : 0.0f;
	}
	stilb_image_finish(image);
	*image = light;
	return result;
}

stilb_result stilb_scene_set_environment(stilb_scene *scene, const char *path)
{
	stilb_image map;
	stilb_result result = stilb_image_import(path, &map);
	if (result == STILB_OK)
		result = scene_picture_to_light(&map);
	if (result != STILB_OK)
		return result;
	stilb_image_finish(&scene->environment);
	scene->environment = map;
	return STILB_OK;
}

void stilb_scene_set_sky(stilb_scene *scene, const float radiance[3])
{
	stilb_image_finish(&scene->environment);
	for (int i = 0; i < 3; i++)
		scene->sky.sky[i] = scene->sky.ground[i] = radiance[i];
}
