/*
 * panorama_exact: the irradiance that a panorama gives to a normal, without sampling: the sum over its texels of their
 * radiance times the integral of the cosine, which has a closed form where the horizon does not cut a texel; one that
 * it cuts is read in pieces. The truth for frames, and for rays without their noise.
 */
#ifndef PANORAMA_EXACT_H
#define PANORAMA_EXACT_H

#include "image/image.h"

#include <math.h>
#include <stdlib.h>

#define PANORAMA_EXACT_PIECE 0.002 /* radians: most of a piece's side */

/* The integral over a rectangle of longitudes and angles from the pole of the direction times the solid angle. */
static inline void panorama_exact_integral(double phi, double phi_end, double theta, double theta_end, double out[3])
{
	double wide = 0.5 * (theta_end - theta) - 0.25 * (sin(2.0 * theta_end) - sin(2.0 * theta));
	out[0] = wide * (cos(phi) - cos(phi_end));
	out[1] = 0.5 * (sin(theta_end) * sin(theta_end) - sin(theta) * sin(theta)) * (phi_end - phi);
	out[2] = wide * (sin(phi) - sin(phi_end));
}

static inline double panorama_exact_dot(const double a[3], const double b[3])
{
	return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* The integral of max(n . w, 0) over such a rectangle that the horizon cuts. */
static inline double panorama_exact_cut(double phi, double phi_end, double theta, double theta_end, const double n[3])
{
	int across = (int)((phi_end - phi) * sin(0.5 * (theta + theta_end)) / PANORAMA_EXACT_PIECE) + 1;
	int down = (int)((theta_end - theta) / PANORAMA_EXACT_PIECE) + 1;
	double sum = 0.0, step = (phi_end - phi) / across, fall = (theta_end - theta) / down;
	double first[2] = {cos(phi), sin(phi)}, turn[2] = {cos(step), sin(step)};
	for (int j = 0; j < down; j++) {
		double unit[3], at[2] = {first[0], first[1]}, top = theta + j * fall;
		panorama_exact_integral(0.0, M_PI, top, top + fall, unit); /* [0]: twice `wide` */
		for (int i = 0; i < across; i++) {
			double next[2] = {at[0] * turn[0] - at[1] * turn[1], at[1] * turn[0] + at[0] * turn[1]};
			double part[3] = {0.5 * unit[0] * (at[0] - next[0]), unit[1] * step / M_PI,
			                  0.5 * unit[0] * (at[1] - next[1])};
			double cosine = panorama_exact_dot(part, n);
			sum += cosine > 0.0 ? cosine : 0.0;
			at[0] = next[0];
			at[1] = next[1];
		}
	}
	return sum;
}

/* W m^-2. map: of floats, [height][width][3], radiance >= 0. n: unit, in the world, in which the panorama is turned by
 * rotation. */
static inline void panorama_exact(const stilb_image *map, double rotation, const double n[3], double out[3])
{
	double s = sin(rotation), c = cos(rotation);
	double own[3] = {c * n[0] - s * n[2], n[1], s * n[0] + c * n[2]};
	double step = 2.0 * M_PI / map->width, fall = M_PI / map->height;
	double *edges = malloc((map->width + 1) * sizeof(double[2]));
	out[0] = out[1] = out[2] = 0.0;
	for (uint32_t x = 0; edges && x <= map->width; x++) {
		edges[2 * x] = sin((x - 0.5 * map->width) * step);
		edges[2 * x + 1] = cos((x - 0.5 * map->width) * step);
	}
	for (uint32_t y = 0; edges && y < map->height; y++) {
		const float *texel = (const float *)map->pixels + (size_t)y * map->width * 3;
		double unit[3], theta = y * fall;
		panorama_exact_integral(0.0, M_PI, theta, theta + fall, unit); /* [0]: twice `wide` */
		double solid = cos(theta) - cos(theta + fall), reach = 0.75 * (fall + step * sin(theta + 0.5 * fall));
		for (uint32_t x = 0; x < map->width; x++, texel += 3) {
			double part[3] = {0.5 * unit[0] * (edges[2 * x + 1] - edges[2 * x + 3]), unit[1] * step / M_PI,
			                  0.5 * unit[0] * (edges[2 * x] - edges[2 * x + 2])};
			double cosine = panorama_exact_dot(part, own), size = solid * step;
			if (cosine < -reach * size)
				continue;
			if (cosine < reach * size)
				cosine = panorama_exact_cut((x - 0.5 * map->width) * step, (x + 1 - 0.5 * map->width) * step, theta,
				                            theta + fall, own);
			for (int k = 0; k < 3; k++)
				out[k] += (double)texel[k] * cosine;
		}
	}
	free(edges);
}

#endif
