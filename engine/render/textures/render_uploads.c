/* Pixels of textures on their way to the device. See render_textures.h. */
#include "render/render_internal.h"

#include <stdlib.h>

/* ---- one upload -------------------------------------------------------------------------------------------------- */

static void upload_measure(render_upload_mip *mip)
{
	mip->side = stilb_image_format_is_blocks(mip->image.format) ? 4 : 1;
	mip->rows = (mip->image.height + mip->side - 1) / mip->side;
	mip->row = stilb_image_size(&mip->image) / mip->rows;
}

render_upload_mip render_upload_first(const render_texture_upload *upload)
{
	render_upload_mip mip = {.image = upload->pixels.image};
	upload_measure(&mip);
	return mip;
}

bool render_upload_next(const render_texture_upload *upload, render_upload_mip *mip)
{
	stilb_image *image = &mip->image;
	if (mip->mip + 1 == upload->pixels.levels)
		return false;
	mip->first_row += mip->rows;
	image->pixels = mip->mip == 0 ? upload->pixels.mips : (uint8_t *)image->pixels + stilb_image_size(image);
	image->width = image->width > 1 ? image->width / 2 : 1;
	image->height = image->height > 1 ? image->height / 2 : 1;
	upload_measure(mip);
	mip->mip++;
	return true;
}

/* What has yet to be copied: rows upload->rows .. count - 1. *bytes: of it, at most `most`; returns the row with which
 * those end. */
static uint32_t upload_rows(const render_texture_upload *upload, uint64_t most, uint64_t *bytes)
{
	render_upload_mip mip = render_upload_first(upload);
	uint32_t end = upload->rows;
	*bytes = 0;
	do {
		uint32_t last = mip.first_row + mip.rows;
		if (last <= end)
			continue;
		uint64_t rows = (most - *bytes) / mip.row;
		rows = rows < last - end ? rows : last - end;
		*bytes += rows * mip.row;
		end += (uint32_t)rows;
		if (end < last)
			break;
	} while (render_upload_next(upload, &mip));
	return end;
}

render_texture_upload render_upload_make(uint32_t texture, render_pixels pixels, bool patient)
{
	render_texture_upload upload = {.texture = texture, .pixels = pixels, .patient = patient};
	render_upload_mip mip = render_upload_first(&upload);
	do
		upload.count = mip.first_row + mip.rows;
	while (render_upload_next(&upload, &mip));
	return upload;
}

void render_upload_finish(render_texture_upload *upload)
{
	render_pixels_finish(&upload->pixels);
}

/* ---- all of them ------------------------------------------------------------------------------------------------- */

render_texture_upload *render_upload_of(render_resources *resources, uint32_t index)
{
	STILB_ASSERT_LOCKED(&resources->lock);
	for (uint32_t u = 0; u < resources->upload_count; u++)
		if (resources->uploads[u].texture == index)
			return &resources->uploads[u];
	return NULL;
}

void render_uploads_forget(render_resources *resources, uint32_t texture)
{
	STILB_ASSERT(!resources->sending && "no frame is between update and sent");
	uint32_t kept = 0;
	for (uint32_t u = 0; u < resources->upload_count; u++) {
		if (resources->uploads[u].texture == texture)
			render_upload_finish(&resources->uploads[u]);
		else
			resources->uploads[kept++] = resources->uploads[u];
	}
	resources->upload_count = kept;
}

void render_uploads_choose(render_resources *resources)
{
	uint64_t room = RENDER_UPLOAD_A_FRAME;
	for (uint32_t u = 0; u < resources->upload_count; u++) {
		render_texture_upload *upload = &resources->uploads[u];
		uint64_t bytes = 0;
		STILB_ASSERT(upload->rows < upload->count);
		if (upload->end_frame > 0 && resources->frame >= upload->end_frame)
			upload->sent = upload->rows;
		else
			upload->sent = upload->patient ? upload_rows(upload, room, &bytes) : upload->count;
		room -= bytes;
	}
}

void render_uploads_sent(render_resources *resources)
{
	uint32_t kept = 0;
	for (uint32_t u = 0; u < resources->upload_count; u++) {
		render_texture_upload *upload = &resources->uploads[u];
		upload->rows = upload->sent > upload->rows ? upload->sent : upload->rows;
		if (upload->rows < upload->count) {
			resources->uploads[kept++] = *upload;
			continue;
		}
		if (!resources->pictures) {
			render_pixels_finish(&upload->pixels);
			continue;
		}
		if (upload->pixels.given == 1) { /* the mips can be made again */
			free(upload->pixels.mips);
			upload->pixels.mips = NULL;
		}
		render_pixels_finish(&resources->pictures[upload->texture]); /* of a texture that was written again */
		resources->pictures[upload->texture] = upload->pixels;
	}
	resources->upload_count = kept;
}

void render_resources_hurry(render_resources *resources)
{
	stilb_lock_take(&resources->lock);
	for (uint32_t u = 0; u < resources->upload_count; u++)
		resources->uploads[u].patient = false;
	stilb_lock_give(&resources->lock);
}

uint64_t render_uploads_left(const render_resources *resources)
{
	uint64_t bytes = 0;
	STILB_ASSERT_LOCKED(&resources->lock);
	for (uint32_t u = 0; u < resources->upload_count; u++) {
		uint64_t left = 0;
		if (resources->uploads[u].end_frame == 0)
			upload_rows(&resources->uploads[u], UINT64_MAX, &left);
		bytes += left;
	}
	return bytes;
}
