/* Maps of lights that have a place. */
#include "shadow/shadow_internal.h"

#include <math.h>
#include <string.h>

#define LAMP_WIDE 0.5f       /* cosine of a spot's half angle from which on it has a cube's maps */
#define LAMP_NEAR 1e-3f      /* of what a lamp reaches: nothing nearer casts a shadow */
#define LAMP_METRES 0.01f    /* and nothing nearer than that, metres, if it is less */
#define LAMP_NARROW 0.99999f /* cosine of a spot's half angle: a narrower one's map is as wide */
#define LAMP_SOFT 0.125f     /* of a map's side: as wide may the edge of a shadow of a lamp with a size be */
#define LAMP_MARGIN 2.0f     /* texels at the sides of a map besides the filter's */

/* How far it sends light to what casts and gets shadows. */
static float lamp_reach(const stilb_shadow_view *view, const stilb_scene_light *light)
{
	const stilb_sphere *bounds = &view->bounds;
	float away[3] = {light->position[0] - bounds->x, light->position[1] - bounds->y, light->position[2] - bounds->z};
	float most = sqrtf(away[0] * away[0] + away[1] * away[1] + away[2] * away[2]) + bounds->radius;
	return light->falloff == STILB_SCENE_LIGHT_PHYSICAL ? most : fminf(light->reach, most);
}

/* Pixels that a length at a place has in the picture. */
static float lamp_pixels(const stilb_shadow_view *view, const float at[3], float length)
{
	const float *m = view->view_projection.m;
	float up = sqrtf(m[1] * m[1] + m[5] * m[5] + m[9] * m[9]), along = sqrtf(m[3] * m[3] + m[7] * m[7] + m[11] * m[11]);
	float away = 0.0f;
	for (int i = 0; i < 3; i++)
		away += (at[i] - view->camera_position[i]) * (at[i] - view->camera_position[i]);
	/* From its middle, or within it as from its edge. */
	float distance = along > 0.0f ? along * fmaxf(sqrtf(away), length) : fabsf(m[15]);
	return length * up * (float)view->height / distance;
}

bool shadow_lamp_of(const stilb_shadow_view *view, const stilb_frustum *frustum, const stilb_scene_light *light,
                    shadow_lamp *lamp)
{
	const float *i = light->intensity;
	float reach = lamp_reach(view, light);
	stilb_sphere sphere = {light->position[0], light->position[1], light->position[2], reach};
	if (light->use == STILB_SCENE_LIGHT_BAKED || !(i[0] > 0.0f || i[1] > 0.0f || i[2] > 0.0f) || !(reach > 0.0f) ||
	    (!view->others && !stilb_frustum_may_see(frustum, sphere)))
		return false;
	lamp->maps = light->kind == STILB_SCENE_LIGHT_SPOT && light->cos_outer > LAMP_WIDE ? 1 : 6;
	lamp->seen = lamp_pixels(view, light->position, reach);
	return true;
}

/* World to clip space of what a pyramid sees: 1 / slope is half its side at the distance 1. */
static stilb_mat4 lamp_matrix(const float eye[3], const float right[3], const float up[3], const float along[3],
                              float slope, float near, float far)
{
	const float *rows[4] = {right, up, along, along};
	const float scales[4] = {slope, slope, -near / (far - near), 1.0f};
	stilb_mat4 matrix = {0};
	for (int r = 0; r < 4; r++)
		for (int c = 0; c < 3; c++) {
			matrix.m[4 * c + r] = scales[r] * rows[r][c];
			matrix.m[12 + r] -= scales[r] * rows[r][c] * eye[c];
		}
	matrix.m[14] += near * far / (far - near); /* over the distance: 1 at near, 0 at far */
	return matrix;
}

stilb_mat4 shadow_lamp_fit(const stilb_shadow_desc *desc, const stilb_shadow_view *view, const stilb_scene_light *light,
                           const shadow_lamp *lamp, uint32_t index)
{
	bool sized = light->kind == STILB_SCENE_LIGHT_SPHERE || light->kind == STILB_SCENE_LIGHT_DISK ||
	             light->kind == STILB_SCENE_LIGHT_RECTANGLE;
	float side = (float)lamp->size, soft = sized ? LAMP_SOFT * side : 0.0f;
	float inner = side - 2.0f * fmaxf((float)desc->filter + LAMP_MARGIN, soft);
	float far = lamp_reach(view, light), face = light->kind == STILB_SCENE_LIGHT_SPHERE ? 1.001f * light->radius : 0.0f;
	float near = fminf(fmaxf(face, fminf(LAMP_NEAR * far, LAMP_METRES)), 0.5f * far);
	float right[3], up[3], along[3] = {0.0f, 0.0f, 0.0f}, slope = inner / side;
	if (lamp->maps == 1) {
		memcpy(along, light->direction, sizeof along);
		float cosine = fminf(light->cos_outer, LAMP_NARROW);
		slope *= cosine / sqrtf(1.0f - cosine * cosine);
	} else {
		along[index / 2] = index % 2 == 0 ? 1.0f : -1.0f;
	}
	shadow_axes(along, right, up);
	return lamp_matrix(light->position, right, up, along, slope, near, far);
}

float shadow_lamp_wanted(const shadow_lamp *lamp, uint32_t halved)
{
	float wanted = lamp->maps > 1 ? 0.5f * lamp->seen : lamp->seen; /* a cube's sides see half of the reach each */
	wanted = ldexpf(wanted, -(int)(halved < 16 ? halved : 16));
	return wanted > (float)STILB_SHADOW_MIN_SIZE ? wanted : (float)STILB_SHADOW_MIN_SIZE;
}
