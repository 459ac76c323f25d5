/*
 * Textures: handles, their pixels as the device takes them, and uploads, pixels that frames have yet to copy. Inside
 * render/, part of render_resources.h, which has the tables.
 *
 * Life.     A texture is created with an upload. Destroyed, it takes no further rows, and is released when the frames
 *           that may draw it are done.
 * Threads.  Creation and destruction are [any-thread] and take the lock of render_resources. Where the caller holds
 *           that lock, a function says so.
 */
#ifndef STILB_RENDER_TEXTURES_H
#define STILB_RENDER_TEXTURES_H

#include "render/maps/render_maps.h"
#include "render/render.h"

typedef struct render_resources render_resources;

/* ---- pixels ------------------------------------------------------------------------------------------------------ */

/* What the device has of a picture. */
typedef struct render_texture_shape {
	uint32_t width, height, channels; /* four, but of blocks */
	stilb_image_format format;        /* no U16_SRGB, and blocks if the device reads them as they are */
	uint32_t levels;                  /* with mips; 1 unless it is mapped */
	uint32_t given;                   /* levels that the picture has; the others are made of the last of these */
	bool mapped;                      /* it is for maps: a layer of an array, with mips */
} render_texture_shape;

typedef struct render_device render_device;

/* Blocks stay blocks where the device filters them, BC7 not on a software device, if the picture has levels down to a
 * single block, or needs none; the mips behind it are missing then. All else becomes texels. [any-thread] */
render_texture_shape render_texture_shape_of(const render_device *device, const stilb_image *image, bool mapped);
/* Bytes of all levels. */
uint64_t render_texture_shape_bytes(const render_texture_shape *shape);

/* Pixels as the device takes them. */
typedef struct render_pixels {
	stilb_image image; /* the largest level alone */
	void *mips;        /* the others, from larger to smaller, tightly packed; NULL: there are none */
	uint32_t levels, given;
} render_pixels;

/* Accepts {0}. */
void render_pixels_finish(render_pixels *pixels);

/* Pixels that are being made, a few rows at a time. */
typedef struct render_pixels_work {
	stilb_image from; /* somebody else's, who keeps it until the work is done or given up */
	render_texture_shape shape;
	render_pixels to;
	uint64_t left;             /* texels to be made; 0: done, `to` is whole */
	stilb_image level, before; /* that is being made, from row `row` on; the one before */
	uint32_t number, row;
	render_mips_kind kind;
	render_mips_codes codes;
} render_pixels_work;

/* For maps, and what their mips hold: a kind of normals is for shapes of texels alone. spread: as of
 * render_mips_codes. */
typedef struct render_pixels_way {
	bool mapped;
	render_mips_kind kind;
	stilb_render_specular_aa spread;
} render_pixels_way;

/* STILB_ERROR_MEMORY; there is nothing to be freed then. Else work->to is for render_pixels_finish. */
stilb_result render_pixels_begin(const render_device *device, const stilb_image *image, render_pixels_way way,
                                 render_pixels_work *work);
/* Makes so many texels, or a few more, if as many are left. pool: whose threads help, its owner is the caller; NULL:
 * none. STILB_ERROR_MEMORY. */
stilb_result render_pixels_step(render_pixels_work *work, uint64_t texels, stilb_job_pool *pool);
/* All at once. *pixels is {0} after an error. */
stilb_result render_pixels_make(const render_device *device, const stilb_image *image, render_pixels_way way,
                                stilb_job_pool *pool, render_pixels *pixels);

/* ---- textures ---------------------------------------------------------------------------------------------------- */

/* How a texture is made: with mips, which samplers of maps read, of a kind; with a patient upload; of a scene, later:
 * while frames are drawn (render_loading.h). pool: whose threads help to make mips, its owner is the caller; NULL:
 * none. */
typedef struct render_texture_way {
	bool patient, mips, later;
	render_mips_kind kind;
	stilb_job_pool *pool;
} render_texture_way;

/* stilb_render_texture_create in that way. */
stilb_result render_texture_create(stilb_render *render, const stilb_image *image, render_texture_way way,
                                   stilb_render_texture *out);

/* A texture of pixels that were made, which it takes over, also on failure. Errors as stilb_render_texture_create. */
stilb_result render_texture_create_made(stilb_render *render, const render_texture_shape *shape, render_pixels pixels,
                                        bool patient, stilb_render_texture *out);

/* Writes an image of the texture's size, format and kind of mips into it; the next frame copies it, after the draws of
 * the frames before it. STILB_ERROR_MEMORY: nothing has changed. [main-thread], between frames or before replay */
stilb_result render_texture_write(stilb_render *render, stilb_render_texture texture, const stilb_image *image,
                                  render_mips_kind kind);

/* Announces a texture of such an image with mips: those of one size and format then lie in as few images as can be. */
void render_resources_expect_texture(stilb_render *render, const stilb_image *image);
/* No further one is expected. */
void render_resources_expect_no_textures(stilb_render *render);

/* Sends the pixels of all textures to the device now, and frees them. Between frames. [main-thread] */
stilb_result render_resources_send(stilb_render *render);

/* True for a handle that render_texture_create returned and that is not destroyed. The caller holds the lock. */
bool render_texture_is_valid(const render_resources *resources, uint32_t handle);

/* ---- uploads ----------------------------------------------------------------------------------------------------- */

/* Pixels that the next frame copies to a texture. Of a patient one, which nothing draws yet, as many rows as the frame
 * has room for (RENDER_UPLOAD_A_FRAME); of others all. Rows, of texels or of blocks, are numbered through the mips,
 * those of the image come first. */
typedef struct render_texture_upload {
	uint32_t texture;
	render_pixels pixels;
	uint32_t count;      /* of rows */
	uint32_t rows, sent; /* rows 0 .. rows - 1 are on the device; rows .. sent - 1 are part of the frame */
	bool patient;
	uint64_t end_frame; /* the texture was destroyed: this frame and later ones copy no more of it; 0: it was not */
} render_texture_upload;

/* A mip of an upload. */
typedef struct render_upload_mip {
	stilb_image image; /* not to be finished */
	uint32_t mip, first_row;
	uint32_t rows, side; /* side: rows of texels in a row, 1 or 4 */
	uint64_t row;        /* bytes */
} render_upload_mip;

/* The first one. */
render_upload_mip render_upload_first(const render_texture_upload *upload);
/* Goes on to the next one. False: there is none. */
bool render_upload_next(const render_texture_upload *upload, render_upload_mip *mip);

/* Takes the pixels over. */
render_texture_upload render_upload_make(uint32_t texture, render_pixels pixels, bool patient);
void render_upload_finish(render_texture_upload *upload);

/* Bytes that patient uploads take of a frame. Copying them takes a CPU some 3 to 6 ms, and lavapipe as much again. */
#define RENDER_UPLOAD_A_FRAME ((uint64_t)16 << 20)

/* Bytes of texels that wait while a scene is set, before they are sent. */
#define RENDER_UPLOAD_QUEUED ((uint64_t)64 << 20)

/* Makes all uploads impatient: their textures may be drawn from now on. [any-thread] */
void render_resources_hurry(render_resources *resources);

/* For the following the caller holds the lock. */

/* The upload of the texture with this index, or NULL. */
render_texture_upload *render_upload_of(render_resources *resources, uint32_t texture);
/* Drops it: the texture may be released before a frame has copied it. */
void render_uploads_forget(render_resources *resources, uint32_t texture);
/* Chooses the rows that the frame copies: all, but of patient uploads as many as it has room for, in their order. */
void render_uploads_choose(render_resources *resources);
/* Removes the uploads that the device has copied whole. One that came since the update has sent 0. */
void render_uploads_sent(render_resources *resources);
/* Bytes that frames have yet to copy. */
uint64_t render_uploads_left(const render_resources *resources);

#endif
