#include "bake/bake_picture.h"

#include <math.h>

/* A colour of the hue circle, hue in [0, 1), value in [0, 1]; saturation one half. */
static void hue_color(double hue, double value, uint8_t color[3])
{
	for (int k = 0; k < 3; k++) {
		double x = fmod(6.0 * hue + 4.0 - 2.0 * k + 6.0, 6.0);
		double ramp = fmin(fmax(fabs(x - 3.0) - 1.0, 0.0), 1.0);
		color[k] = (uint8_t)(255.0 * value * (0.5 + 0.5 * ramp) + 0.5);
	}
}

void stilb_bake_picture_charts(const stilb_bake_texels *texels, uint8_t (*srgb)[3])
{
	for (size_t i = 0; i < (size_t)texels->side * texels->side; i++) {
		uint32_t place = texels->place[i], triangle = 0;
		float most = 0.0f;
		if (place == STILB_BAKE_NO_CHART) {
			srgb[i][0] = srgb[i][1] = srgb[i][2] = 24;
			continue;
		}
		for (int c = 0; c < STILB_BAKE_CELLS; c++)
			if (texels->spots[i][c].share > most) {
				most = texels->spots[i][c].share;
				triangle = texels->spots[i][c].triangle;
			}
		/* Multiples of the golden ratio lie far apart on the circle. */
		hue_color(fmod((double)place * 0.6180339887, 1.0), 0.75 + 0.05 * (triangle % 6), srgb[i]);
	}
}

void stilb_bake_picture_texels(const stilb_bake_texels *texels, uint8_t (*srgb)[3])
{
	for (size_t i = 0; i < (size_t)texels->side * texels->side; i++) {
		float share = 0.0f;
		for (int c = 0; c < STILB_BAKE_CELLS; c++)
			share += 0.25f * texels->spots[i][c].share;
		bool odd = (i % texels->side + i / texels->side) & 1;
		bool covered = texels->place[i] != STILB_BAKE_NO_CHART;
		srgb[i][0] = srgb[i][1] = srgb[i][2] = covered ? odd ? 200 : 120 : 24;
		if (covered && share < 0.999f)
			srgb[i][2] = (uint8_t)(40.0f + 100.0f * share);
	}
}
