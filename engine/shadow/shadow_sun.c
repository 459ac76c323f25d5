/* Cascades of directional lights. */
#include "shadow/shadow_internal.h"

#include <math.h>
#include <string.h>

#define SUN_STEP 4.0  /* each cascade reaches so many times farther than the one before */
#define SUN_SPLIT 0.8 /* with a distance: from equal lengths, 0, to equal factors, 1 */
#define SUN_NEAR 0.01 /* of the distance: where cascades by equal factors begin */

#define SUN_GROWS 1.25  /* a map of near things by this factor */
#define SUN_BESIDE 0.05 /* of a sphere's radius: so far beside what is seen casters are drawn, too */

typedef struct sun_sphere {
	double center[3], radius;
} sun_sphere;

bool shadow_lens(const stilb_shadow_view *view, double ahead[3], double *slant)
{
	const float *m = view->view_projection.m;
	double square[3] = {0.0, 0.0, 0.0};
	for (int c = 0; c < 3; c++) {
		for (int r = 0; r < 2; r++)
			square[r] += (double)m[4 * c + r] * (double)m[4 * c + r];
		square[2] += (double)m[4 * c + 3] * (double)m[4 * c + 3];
	}
	*slant = sqrt(square[2] / square[0] + square[2] / square[1]);
	for (int c = 0; c < 3; c++)
		ahead[c] = (double)m[4 * c + 3] / sqrt(square[2]);
	return square[2] > 0.0 && isfinite(*slant);
}

/* The smallest sphere, around a point ahead of the camera, that holds what it sees between two depths. */
static sun_sphere sun_sphere_of(const stilb_shadow_view *view, const double ahead[3], double slant, double near,
                                double far)
{
	double middle = fmin(0.5 * (near + far) * (1.0 + slant * slant), far);
	sun_sphere sphere = {.radius = hypot(far - middle, far * slant)};
	for (int i = 0; i < 3; i++)
		sphere.center[i] = (double)view->camera_position[i] + middle * ahead[i];
	return sphere;
}

/* All that is so near to a parallel view's camera, which sees as far behind it as its matrix says. */
static sun_sphere sun_sphere_around(const stilb_shadow_view *view, double far)
{
	const float *p = view->camera_position;
	return (sun_sphere){{(double)p[0], (double)p[1], (double)p[2]}, far};
}

/* A sphere that holds the near things; its radius is one of few, so that the map's texels stay as large. */
static sun_sphere sun_objects(const stilb_shadow_view *view)
{
	const stilb_sphere *near = &view->near;
	double steps = ceil(log((double)near->radius) / log(SUN_GROWS));
	return (sun_sphere){{(double)near->x, (double)near->y, (double)near->z}, pow(SUN_GROWS, steps)};
}

/* Where the cascade ends, metres from the camera. */
static double sun_end(const stilb_shadow_desc *desc, const stilb_shadow_view *view, uint32_t cascade)
{
	if (desc->objects)
		return (double)desc->distance;
	double share = (double)(cascade + 1) / desc->cascades, distance = (double)desc->distance;
	if (desc->distance > 0.0f)
		return distance * (SUN_SPLIT * pow(SUN_NEAR, 1.0 - share) + (1.0 - SUN_SPLIT) * share);
	return 2.0 * (double)view->bounds.radius * pow(SUN_STEP, (double)cascade + 1.0 - desc->cascades);
}

/* The matrix of a map that holds the sphere within its inner part. right, up: the map's columns and rows go along them,
 * and light along `along`. inner: texels of that part. ends: what lies behind the sphere gets no shadow from it. */
static stilb_mat4 sun_matrix(const stilb_shadow_view *view, const sun_sphere *sphere, float right[3], float up[3],
                             const float along[3], double size, double inner, bool ends)
{
	/* A texel less on each side: the map lies at whole texels. */
	double texel = 2.0 * sphere->radius / (inner - 2.0), middle[2] = {0.0, 0.0}, depth = 0.0, below = 0.0;
	double range = (double)view->bounds.radius * 1.001;
	const double bounds[3] = {(double)view->bounds.x, (double)view->bounds.y, (double)view->bounds.z};
	for (int i = 0; i < 3; i++) {
		middle[0] += (double)right[i] * sphere->center[i];
		middle[1] += (double)up[i] * sphere->center[i];
		depth += (double)along[i] * bounds[i];
		below += (double)along[i] * sphere->center[i];
	}
	stilb_mat4 matrix = {0};
	for (int r = 0; r < 2; r++) {
		const float *axis = r == 0 ? right : up;
		double scale = 2.0 / (size * texel);
		for (int c = 0; c < 3; c++)
			matrix.m[4 * c + r] = (float)(scale * (double)axis[c]);
		matrix.m[12 + r] = (float)(-scale * texel * floor(middle[r] / texel + 0.5));
	}
	/* Depth is 1 where the bounds begin and 0 where they end, or as far below the sphere as the map's sides are beside
	 * it: what lies behind throws no shadow on what the map is for. */
	double first = depth - range, last = depth + range;
	if (ends)
		last = texel * (floor(below / texel + 0.5) + 0.5 * size);
	double span = fmax(last - first, texel);
	for (int c = 0; c < 3; c++)
		matrix.m[4 * c + 2] = (float)(-(double)along[c] / span);
	matrix.m[14] = (float)((first + span) / span);
	matrix.m[15] = 1.0f;
	return matrix;
}

void shadow_sun_fit(const stilb_shadow_desc *desc, const stilb_shadow_view *view, const float direction[3],
                    stilb_shadow_map *maps)
{
	double ahead[3], slant, near = 0.0, size = (double)desc->page;
	bool lens = shadow_lens(view, ahead, &slant);
	float right[3], up[3];
	shadow_axes(direction, right, up);
	for (uint32_t c = 0; c < desc->cascades; c++) {
		bool last = c + 1 == desc->cascades, whole = last && !(desc->distance > 0.0f);
		double far = sun_end(desc, view, c), blend = whole ? 0.0 : (double)SHADOW_BLEND * size;
		sun_sphere sphere = {{(double)view->bounds.x, (double)view->bounds.y, (double)view->bounds.z},
		                     (double)view->bounds.radius};
		/* Who else looks sees what is behind, and so may a parallel view. */
		bool ends = !whole && lens && !view->others && !desc->objects;
		if (!whole)
			sphere = desc->objects ? sun_objects(view)
			         : lens        ? sun_sphere_of(view, ahead, slant, near, far)
			                       : sun_sphere_around(view, far);
		maps[c].view_projection =
			sun_matrix(view, &sphere, right, up, direction, size, size - 2.0 * (desc->filter + blend), ends);
		maps[c].blend = (float)blend;
		for (int i = 0; i < 3; i++)
			maps[c].eye[i] = (float)(sphere.center[i] - 4.0 * (double)view->bounds.radius * (double)direction[i]);
		maps[c].caster_count = 0;
		maps[c].far = whole ? 0.0f : (float)far;
		double texel = 2.0 * sphere.radius / (size - 2.0 * (desc->filter + blend) - 2.0);
		if (ends)
			shadow_casters_choose(view, direction, (float)far, (float)((desc->filter + 2.0) * texel),
			                      (float)(SUN_BESIDE * sphere.radius), &maps[c]);
		/* Already before its end it gives way to the next one, at the picture's corners less far ahead. */
		near = (far - 0.5 * blend * texel) / sqrt(1.0 + slant * slant);
	}
}
