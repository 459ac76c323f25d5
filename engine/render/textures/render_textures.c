/* Textures: their pixels as the device takes them, their handles. See render_textures.h. */
#include "render/render_internal.h"

#include <stdlib.h>
#include <string.h>

bool render_texture_is_valid(const render_resources *resources, uint32_t handle)
{
	uint32_t index = handle & RENDER_INDEX_MASK;
	STILB_ASSERT_LOCKED(&resources->lock);
	return index > 0 && index < STILB_RENDER_MAX_TEXTURES && handle >> RENDER_GENERATION_SHIFT &&
	       resources->textures[index] == handle >> RENDER_GENERATION_SHIFT;
}

/* ---- textures ---------------------------------------------------------------------------------------------------- */

/* Takes an index and queues the pixels. False: no memory or no id; then nothing has changed. */
static bool texture_add(render_resources *resources, render_pixels pixels, bool patient, uint32_t *index)
{
	if (!render_resource_reserve(resources, 1) ||
	    !render_reserve((void **)&resources->uploads, &resources->upload_capacity, resources->upload_count + 1,
	                    sizeof *resources->uploads) ||
	    !render_index_take(&resources->indices[RENDER_RESOURCE_TEXTURE], index))
		return false;
	resources->live++;
	uint32_t *generation = &resources->textures[*index];
	*generation = *generation ? *generation : 1;
	resources->uploads[resources->upload_count++] = render_upload_make(*index, pixels, patient);
	return true;
}

/* Undoes the last texture_add; the lock was held since. */
static void texture_drop(render_resources *resources, uint32_t index)
{
	STILB_ASSERT(resources->upload_count > 0 && resources->uploads[resources->upload_count - 1].texture == index);
	render_index_give_back(&resources->indices[RENDER_RESOURCE_TEXTURE], index);
	resources->upload_count--;
	resources->live--;
}

stilb_result render_texture_write(stilb_render *render, stilb_render_texture texture, const stilb_image *image,
                                  render_mips_kind kind)
{
	render_resources *resources = &render->resources;
	uint32_t index = texture.id & RENDER_INDEX_MASK;
	render_pixels pixels;
	render_pixels_way way = {render->device->textures[index].array > 0, kind, render->specular_aa};
	stilb_result result = render_pixels_make(render->device, image, way, render->pool, &pixels);
	if (result != STILB_OK)
		return result;
	stilb_lock_take(&resources->lock);
	STILB_ASSERT(render_texture_is_valid(resources, texture.id));
	render_texture_upload *queued = render_upload_of(resources, index);
	if (queued) {
		render_upload_finish(queued);
		*queued = render_upload_make(index, pixels, queued->patient);
	} else if (render_reserve((void **)&resources->uploads, &resources->upload_capacity, resources->upload_count + 1,
	                          sizeof *resources->uploads)) {
		resources->uploads[resources->upload_count++] = render_upload_make(index, pixels, false);
	} else {
		render_pixels_finish(&pixels);
		result = stilb_fail(STILB_ERROR_MEMORY, "no memory for the pixels of a texture");
	}
	stilb_lock_give(&resources->lock);
	return result;
}

stilb_result render_texture_create_made(stilb_render *render, const render_texture_shape *shape, render_pixels pixels,
                                        bool patient, stilb_render_texture *out)
{
	render_resources *resources = &render->resources;
	uint32_t index;
	stilb_result result;
	*out = (stilb_render_texture){0};
	stilb_lock_take(&resources->lock);
	if (!texture_add(resources, pixels, patient, &index)) {
		result = render_resource_no_memory(resources, RENDER_RESOURCE_TEXTURE);
	} else {
		result = render_device_texture_create(render->device, index, shape);
		if (result == STILB_OK)
			out->id = render_handle_make(resources->textures[index], index);
		else
			texture_drop(resources, index);
	}
	stilb_lock_give(&resources->lock);
	if (result != STILB_OK)
		render_pixels_finish(&pixels);
	return result;
}

stilb_result render_texture_create(stilb_render *render, const stilb_image *image, render_texture_way way,
                                   stilb_render_texture *out)
{
	STILB_ASSERT(image && out);
	render_pixels pixels;
	*out = (stilb_render_texture){0};
	if (image->channels < 1 || image->channels > 4 || (uint32_t)image->format >= STILB_IMAGE_FORMAT_COUNT)
		return stilb_fail(STILB_ERROR_ARGUMENT, "a texture of %u channels in format %u: there are 1..4 and 0..%d",
		                  image->channels, (unsigned)image->format, STILB_IMAGE_FORMAT_COUNT - 1);
	uint32_t channels = stilb_image_format_channels(image->format);
	if (channels > 0 && image->channels != channels)
		return stilb_fail(STILB_ERROR_ARGUMENT, "a texture of %u channels in blocks that have %u", image->channels,
		                  channels);
	if (image->width < 1 || image->width > 16384 || image->height < 1 || image->height > 16384)
		return stilb_fail(STILB_ERROR_ARGUMENT, "a texture of %ux%u pixels: a side has 1..16384", image->width,
		                  image->height);
	STILB_ASSERT(image->pixels);
	render_texture_shape shape = render_texture_shape_of(render->device, image, way.mips);
	stilb_result result = render_device_texture_check(render->device, &shape);
	if (result == STILB_OK)
		result = render_pixels_make(render->device, image, (render_pixels_way){way.mips, way.kind, render->specular_aa},
		                            way.pool, &pixels);
	if (result == STILB_OK)
		result = render_texture_create_made(render, &shape, pixels, way.patient, out);
	return result;
}

void render_resources_expect_texture(stilb_render *render, const stilb_image *image)
{
	render_texture_shape shape = render_texture_shape_of(render->device, image, true);
	render_array_kind kind = {shape.width, shape.height, render_texture_format(shape.format), shape.levels};
	stilb_lock_take(&render->resources.lock);
	render_array_expect(&render->device->arrays, &kind); /* without memory for it there are more images */
	stilb_lock_give(&render->resources.lock);
}

void render_resources_expect_no_textures(stilb_render *render)
{
	stilb_lock_take(&render->resources.lock);
	render_array_expect_none(&render->device->arrays);
	stilb_lock_give(&render->resources.lock);
}

stilb_result render_resources_send(stilb_render *render)
{
	STILB_ASSERT_OWNER(render->owner);
	render_resources *resources = &render->resources;
	stilb_lock_take(&resources->lock);
	STILB_ASSERT(!resources->sending && "between frames");
	for (uint32_t u = 0; u < resources->upload_count; u++) {
		render_texture_upload *upload = &resources->uploads[u];
		bool lives = upload->end_frame == 0 && !upload->patient;
		upload->sent = lives ? upload->count : upload->rows;
	}
	stilb_result result = render_device_textures_update(render->device, resources);
	if (result == STILB_OK)
		render_uploads_sent(resources);
	for (uint32_t u = 0; u < resources->upload_count; u++)
		resources->uploads[u].sent = 0;
	stilb_lock_give(&resources->lock);
	return result;
}

stilb_result stilb_render_texture_create(stilb_render *render, const stilb_image *image, stilb_render_texture *out)
{
	return render_texture_create(render, image, (render_texture_way){0}, out);
}

void stilb_render_texture_destroy(stilb_render *render, stilb_render_texture texture)
{
	render_resources *resources = &render->resources;
	uint32_t index = texture.id & RENDER_INDEX_MASK;
	if (texture.id == 0)
		return;
	stilb_lock_take(&resources->lock);
	STILB_ASSERT(render_texture_is_valid(resources, texture.id));
	render_texture_upload *queued = render_upload_of(resources, index);
	if (queued)
		queued->end_frame = resources->frame + 1; /* the release waits for this one, in which it may be drawn */
	resources->textures[index] = render_generation_after(resources->textures[index]);
	render_resource_retire(resources, RENDER_RESOURCE_TEXTURE, index);
	stilb_lock_give(&resources->lock);
}
