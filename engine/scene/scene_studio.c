/* A studio: light and a backdrop for scenes that have no light of their own. */
#include "scene/scene_internal.h"
#include "scene/scene_look.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- is a scene lit? --------------------------------------------------------------------------------------------- */

#define LIT_POINTS 64   /* on surfaces and on emitters, between which light is summed */
#define LIT_SHARE 0.01f /* of the studio's light, from which on a scene counts as lit */

/* A triangle in the world. */
typedef struct lit_triangle {
	stilb_vec3 center, normal; /* unit */
	float area;
	float radiance; /* the largest channel of its emission */
} lit_triangle;

/* Both sums run over triangles in the scene's order, and the points are where the sum passes equal steps. */
typedef struct lit_points {
	double area, power; /* m^2; W sr^-1: area times radiance */
	double area_step, power_step;
	lit_triangle surfaces[LIT_POINTS], emitters[LIT_POINTS];
	uint32_t surface_count, emitter_count;
} lit_points;

static stilb_vec3 lit_cross(stilb_vec3 a, stilb_vec3 b)
{
	return stilb_vec3_make(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]);
}

static stilb_vec3 lit_corner(const stilb_mat4 *to_world, const float p[3])
{
	const float *m = to_world->m;
	stilb_vec3 at = {0};
	for (int k = 0; k < 3; k++)
		at[k] = m[k] * p[0] + m[4 + k] * p[1] + m[8 + k] * p[2] + m[12 + k];
	return at;
}

/* False: it has no area, or none that is finite. */
static bool lit_triangle_of(const stilb_scene *scene, uint32_t part, uint32_t triangle, lit_triangle *out)
{
	const stilb_scene_mesh *mesh = &scene->meshes[scene->part_mesh[part]];
	const float *emission = scene->materials[scene->part_material[part]].emission;
	stilb_vec3 corner[3];
	for (int i = 0; i < 3; i++)
		corner[i] = lit_corner(&scene->part_transform[part],
		                       mesh->vertices[mesh->indices[3 * (size_t)triangle + (size_t)i]].position);
	stilb_vec3 across = lit_cross(corner[1] - corner[0], corner[2] - corner[0]);
	float length = sqrtf(stilb_vec3_dot(across, across));
	if (!(length > 0.0f && isfinite(length)))
		return false;
	out->center = (corner[0] + corner[1] + corner[2]) * (1.0f / 3.0f);
	out->normal = across * (1.0f / length);
	out->area = 0.5f * length;
	out->radiance = fmaxf(fmaxf(emission[0], emission[1]), emission[2]);
	return isfinite(out->radiance);
}

/* choose: false in the first walk, which sums up; true in the second, which picks the points. */
static void lit_walk(const stilb_scene *scene, lit_points *points, bool choose)
{
	double area = 0.0, power = 0.0;
	lit_triangle at;
	for (uint32_t part = 0; part < scene->part_count; part++) {
		uint32_t mesh = scene->part_mesh[part];
		for (uint32_t t = 0; mesh != STILB_SCENE_NONE && t < scene->meshes[mesh].index_count / 3; t++) {
			if (!lit_triangle_of(scene, part, t, &at))
				continue;
			area += (double)at.area;
			power += (double)at.area * (double)at.radiance;
			while (choose && points->surface_count < LIT_POINTS &&
			       area > points->area_step * (points->surface_count + 0.5))
				points->surfaces[points->surface_count++] = at;
			while (choose && points->emitter_count < LIT_POINTS &&
			       power > points->power_step * (points->emitter_count + 0.5))
				points->emitters[points->emitter_count++] = at;
		}
	}
	points->area = area;
	points->power = power;
	points->area_step = area / LIT_POINTS;
	points->power_step = power / LIT_POINTS;
}

/* What an emitter of this power, W sr^-1, sends to a surface, W m^-2. */
static double lit_between(const lit_triangle *from, const lit_triangle *to, double power)
{
	stilb_vec3 away = to->center - from->center;
	double square = fmax((double)stilb_vec3_dot(away, away), (double)from->area);
	double out = (double)stilb_vec3_dot(from->normal, away), in = -(double)stilb_vec3_dot(to->normal, away);
	return out > 0.0 && in > 0.0 ? power * out * in / (square * square) : 0.0;
}

/* The mean irradiance that emission gives to the scene's surfaces, as if nothing were in between. */
static double lit_by_emission(const stilb_scene *scene)
{
	lit_points *points = calloc(1, sizeof *points);
	double sum = 0.0;
	if (!points)
		return 0.0; /* a scene whose light is not known gets some */
	lit_walk(scene, points, false);
	if (points->power > 0.0)
		lit_walk(scene, points, true);
	for (uint32_t s = 0; s < points->surface_count; s++)
		for (uint32_t e = 0; e < points->emitter_count; e++)
			sum += lit_between(&points->emitters[e], &points->surfaces[s], points->power_step);
	sum /= points->surface_count > 0 ? points->surface_count : 1;
	free(points);
	return sum;
}

static bool studio_emits(const stilb_scene *scene)
{
	for (uint32_t m = 0; m < scene->material_count; m++)
		for (int i = 0; i < 3; i++)
			if (scene->materials[m].emission[i] > 0.0f)
				return true;
	return false;
}

/* ---- the lights -------------------------------------------------------------------------------------------------- */

/* Irradiances at the model's middle, directions as seen from the camera, radians: to the right of it and above. With
 * the surroundings they give a white ball (reflectance 0.8), shown by the neutral tone map, which takes 0.04 from it, a
 * mean of half the display's range, and about 3 : 1 between its bright and its dark side. */
static const struct studio_light {
	float irradiance, right, up;
} studio_lights[] = {
	{3.1f, -0.70f, 0.73f}, /* key, from the left and above */
	{0.55f, 0.96f, 0.21f}, /* fill, from the right */
	{1.0f, 2.88f, 0.70f},  /* rim, from behind */
};

#define STUDIO_LIGHTS (sizeof studio_lights / sizeof *studio_lights)
#define STUDIO_AROUND 0.27f   /* radiance of the surroundings */
#define STUDIO_BACKDROP 0.34f /* of what is seen behind the model, shown as 0.3 */
#define STUDIO_AWAY 8.0f      /* distance of the lights, in radii of the model */
#define STUDIO_WIDE 2.4f      /* their radius likewise: 17 degrees, for soft shadows */

bool scene_is_lit(const stilb_scene *scene)
{
	const stilb_scene_surroundings *around = &scene->surroundings;
	float light = (float)scene->light_count, studio = 3.1415927f * STUDIO_AROUND;
	for (int i = 0; i < 3; i++)
		light += around->sky[i] + around->ground[i];
	if (light > 0.0f || around->panorama.pixels)
		return true;
	for (size_t i = 0; i < STUDIO_LIGHTS; i++) /* a convex body gets a quarter of what it would if it faced the light */
		studio += 0.25f * studio_lights[i].irradiance;
	return studio_emits(scene) && lit_by_emission(scene) >= (double)(LIT_SHARE * studio);
}

static stilb_scene_light studio_light_of(const struct studio_light *from, float yaw, const stilb_sphere *sphere)
{
	float across = from->right - yaw, level = cosf(from->up), radius = sphere->radius;
	float away[3] = {sinf(across) * level, sinf(from->up), cosf(across) * level};
	stilb_scene_light light = {.kind = STILB_SCENE_LIGHT_DISK, .radius = STUDIO_WIDE * radius};
	const float center[3] = {sphere->x, sphere->y, sphere->z};
	for (int i = 0; i < 3; i++) {
		light.position[i] = center[i] + STUDIO_AWAY * radius * away[i];
		light.direction[i] = -away[i];
		/* E = I / (d^2 + r^2) on the disk's axis */
		light.intensity[i] =
			from->irradiance * (STUDIO_AWAY * STUDIO_AWAY + STUDIO_WIDE * STUDIO_WIDE) * radius * radius;
	}
	return light;
}

stilb_result stilb_scene_set_studio(stilb_scene *scene, float yaw)
{
	STILB_ASSERT(scene && isfinite(yaw));
	stilb_sphere sphere = scene_sphere(scene);
	if (!(sphere.radius > 1e-9f))
		sphere.radius = 1.0f;
	stilb_scene_light *lights = stilb_memory_alloc(STUDIO_LIGHTS, sizeof *lights);
	stilb_scene_floor *floor = calloc(1, sizeof *floor);
	if (!lights || !floor || !scene_floor_cover(scene, &sphere, floor)) {
		free(lights);
		free(floor);
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for the studio");
	}
	for (size_t i = 0; i < STUDIO_LIGHTS; i++)
		lights[i] = studio_light_of(&studio_lights[i], yaw, &sphere);
	free(scene->lights);
	free(scene->light_mounts);
	scene->light_mounts = NULL;
	scene->lights = lights;
	scene->light_count = STUDIO_LIGHTS;
	scene->studio = true;
	stilb_scene_set_sky(scene, (const float[3]){STUDIO_AROUND, STUDIO_AROUND, STUDIO_AROUND});
	scene->surroundings.glossy = true;
	snprintf(scene->surroundings.name, sizeof scene->surroundings.name, "studio");
	scene_backdrop_finish(&scene->backdrop);
	scene->backdrop = (stilb_scene_backdrop){.kind = STILB_SCENE_BACKDROP_COLOR, .floor = floor};
	for (int i = 0; i < 3; i++)
		scene->backdrop.color[i] = STUDIO_BACKDROP;
	return STILB_OK;
}
