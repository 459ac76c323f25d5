/* A scene's frame for comparison with rays, of which each pixel is the mean over a square. */
#ifndef FRAMED_H
#define FRAMED_H

#include "engine.h"
#include "engine_internal.h"
#include "support/test.h"

#include <stdlib.h>

/* Draws one frame of the scene; the picture, linear floats of three channels, has a pixel for fine x fine of its. */
static inline stilb_image framed_by(stilb_engine *engine, stilb_scene *scene, uint32_t fine)
{
	stilb_engine_report report;
	stilb_image frame = {0}, image;
	assert_int_equal(stilb_engine_set_scene(engine, scene), STILB_OK);
	if (stilb_engine_frame(engine, &report) != STILB_OK || stilb_render_read_image(engine->render, &frame) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	uint32_t width = frame.width / fine, height = frame.height / fine;
	float *row = malloc(sizeof *row * frame.width * frame.channels);
	assert_non_null(row);
	assert_int_equal(stilb_image_create(&image, width, height, 3, STILB_IMAGE_F32_LINEAR), STILB_OK);
	for (uint32_t y = 0; y < height * fine; y++) {
		stilb_image_row_to_light(&frame, y, row);
		for (uint32_t x = 0; x < width * fine; x++)
			for (uint32_t c = 0; c < 3; c++)
				((float *)image.pixels)[3 * (y / fine * width + x / fine) + c] +=
					row[x * frame.channels + c] / (float)(fine * fine);
	}
	free(row);
	stilb_image_finish(&frame);
	assert_int_equal(stilb_engine_set_scene(engine, NULL), STILB_OK);
	return image;
}

#endif
