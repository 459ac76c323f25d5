/* What the picture tests hold the renderer against: a camera, a triangle by triangle ray tracer and the shading
 * formulas, all in double and written down once more, from the sources that the engine's headers name. Also how a
 * picture is made. */
#ifndef PICTURE_REFERENCE_H
#define PICTURE_REFERENCE_H

#include "render/render.h"
#include "scene/scene_internal.h"
#include "support/test.h"

#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define REFERENCE_PI 3.14159265358979323846

typedef struct dvec {
	double x, y, z;
} dvec;

static inline dvec dvec_of(const float v[3])
{
	return (dvec){(double)v[0], (double)v[1], (double)v[2]};
}

static inline dvec dvec_mad(dvec a, double scale, dvec b)
{
	return (dvec){a.x + scale * b.x, a.y + scale * b.y, a.z + scale * b.z};
}

static inline double dvec_dot(dvec a, dvec b)
{
	return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline dvec dvec_cross(dvec a, dvec b)
{
	return (dvec){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static inline dvec dvec_unit(dvec v)
{
	return dvec_mad((dvec){0, 0, 0}, 1.0 / sqrt(dvec_dot(v, v)), v);
}

/* ---- camera ------------------------------------------------------------------------------------------------------ */

typedef struct reference_camera {
	dvec position, right, up, forward; /* unit, at right angles */
	double focal;                      /* 1 / tan(half the vertical angle) */
	uint32_t width, height;
} reference_camera;

static inline reference_camera reference_camera_at(dvec position, dvec target, dvec up, double focal, uint32_t width,
                                                   uint32_t height)
{
	dvec forward = dvec_unit(dvec_mad(target, -1.0, position)), right = dvec_unit(dvec_cross(forward, up));
	return (reference_camera){position, right, dvec_cross(right, forward), forward, focal, width, height};
}

/* World to clip, y down, depth near / distance: 1 near, 0 infinitely far. */
static inline stilb_mat4 reference_matrix(const reference_camera *c)
{
	double aspect = (double)c->width / c->height, near_z = 0.05;
	const double scale[4] = {c->focal / aspect, -c->focal, 0.0, 1.0};
	const dvec axis[4] = {c->right, c->up, {0, 0, 0}, c->forward};
	stilb_mat4 matrix;
	for (int row = 0; row < 4; row++) {
		matrix.m[row] = (float)(scale[row] * axis[row].x);
		matrix.m[4 + row] = (float)(scale[row] * axis[row].y);
		matrix.m[8 + row] = (float)(scale[row] * axis[row].z);
		matrix.m[12 + row] = row == 2 ? (float)near_z : (float)(-scale[row] * dvec_dot(axis[row], c->position));
	}
	return matrix;
}

/* The direction, not unit, through a place of the picture; pixel centres are at halves. */
static inline dvec reference_ray(const reference_camera *c, double x, double y)
{
	double aspect = (double)c->width / c->height;
	double u = (2.0 * x / c->width - 1.0) * aspect / c->focal, v = (1.0 - 2.0 * y / c->height) / c->focal;
	return dvec_mad(dvec_mad(c->forward, u, c->right), v, c->up);
}

/* ---- shading ----------------------------------------------------------------------------------------------------- */

/* The roughness whose Blinn-Phong highlight has this exponent: n = 2 / alpha^2 - 2 (Karis), alpha = roughness^2. */
static inline float reference_roughness(double exponent)
{
	return (float)pow(2.0 / (exponent + 2.0), 0.25);
}

/* Lambert, Schueler's modified Blinn-Phong, the scene's directional light and a sky of two halves; n and v unit. */
static inline double reference_radiance(const stilb_scene *scene, const stilb_scene_material *m, int channel, dvec n,
                                        dvec v)
{
	dvec l = dvec_mad((dvec){0, 0, 0}, -1.0, dvec_of(scene->lights[0].direction)), h = dvec_unit(dvec_mad(l, 1.0, v));
	double n_dot_l = fmax(dvec_dot(n, l), 0.0), n_dot_h = fmax(dvec_dot(n, h), 0.0),
		   s = 2.0 / pow((double)m->roughness, 4.0) - 2.0;
	double factor = (s + 2.0) * (s + 4.0) / (8.0 * REFERENCE_PI * (exp2(-s / 2.0) + s));
	double brdf = (double)m->diffuse[channel] / REFERENCE_PI + (double)m->specular[channel] * factor * pow(n_dot_h, s);
	double above = (double)scene->surroundings.sky[channel] * (1.0 + n.y) / 2.0;
	double below = (double)scene->surroundings.ground[channel] * (1.0 - n.y) / 2.0;
	return brdf * (double)scene->lights[0].intensity[channel] * n_dot_l + (double)m->diffuse[channel] * (above + below);
}

/* ---- rays -------------------------------------------------------------------------------------------------------- */

#define REFERENCE_MISS UINT32_MAX

typedef struct reference_hit {
	uint32_t part; /* REFERENCE_MISS: the sky */
	double distance;
	dvec position, normal; /* the normal interpolated in the model's space, unit in the world */
} reference_hit;

static inline dvec reference_point(const stilb_mat4 *t, const float p[3])
{
	const float *m = t->m;
	double x = (double)p[0], y = (double)p[1], z = (double)p[2];
	return (dvec){(double)m[0] * x + (double)m[4] * y + (double)m[8] * z + (double)m[12],
	              (double)m[1] * x + (double)m[5] * y + (double)m[9] * z + (double)m[13],
	              (double)m[2] * x + (double)m[6] * y + (double)m[10] * z + (double)m[14]};
}

/* A normal in the world is what is at right angles to the transformed tangents. */
static inline dvec reference_normal(const stilb_mat4 *t, dvec model)
{
	dvec n = dvec_unit(model), other = fabs(n.x) < 0.5 ? (dvec){1, 0, 0} : (dvec){0, 1, 0};
	dvec tangent = dvec_unit(dvec_cross(other, n)), bitangent = dvec_cross(n, tangent);
	const float a[3] = {(float)tangent.x, (float)tangent.y, (float)tangent.z};
	const float b[3] = {(float)bitangent.x, (float)bitangent.y, (float)bitangent.z}, zero[3] = {0};
	dvec origin = reference_point(t, zero), u = dvec_mad(reference_point(t, a), -1.0, origin);
	return dvec_unit(dvec_cross(u, dvec_mad(reference_point(t, b), -1.0, origin)));
}

/* The front side of one triangle. Source: Moeller and Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection",
 * 1997. */
static inline void reference_triangle(const dvec p[3], const dvec n[3], dvec origin, dvec d, uint32_t part,
                                      reference_hit *nearest)
{
	dvec e1 = dvec_mad(p[1], -1.0, p[0]), e2 = dvec_mad(p[2], -1.0, p[0]), q = dvec_cross(d, e2);
	double determinant = dvec_dot(e1, q);
	if (determinant <= 0.0)
		return; /* from behind */
	dvec s = dvec_mad(origin, -1.0, p[0]), r = dvec_cross(s, e1);
	double u = dvec_dot(s, q) / determinant, v = dvec_dot(d, r) / determinant, t = dvec_dot(e2, r) / determinant;
	if (u < 0.0 || v < 0.0 || u + v > 1.0 || t <= 0.0 || t >= nearest->distance)
		return;
	dvec normal = dvec_mad(dvec_mad(dvec_mad((dvec){0, 0, 0}, 1.0 - u - v, n[0]), u, n[1]), v, n[2]);
	*nearest = (reference_hit){part, t, dvec_mad(origin, t, d), normal};
}

/* The nearest hit of the ray from origin in direction d on the scene's parts. */
static inline reference_hit reference_trace(const stilb_scene *scene, dvec origin, dvec d)
{
	reference_hit nearest = {REFERENCE_MISS, HUGE_VAL, {0, 0, 0}, {0, 0, 0}};
	for (uint32_t part = 0; part < scene->part_count; part++) {
		const stilb_scene_mesh *mesh = &scene->meshes[scene->part_mesh[part]];
		const stilb_mat4 *transform = &scene->part_transform[part];
		dvec *points = malloc(mesh->vertex_count * sizeof *points);
		assert_non_null(points);
		for (uint32_t i = 0; i < mesh->vertex_count; i++)
			points[i] = reference_point(transform, mesh->vertices[i].position);
		for (const uint32_t *k = mesh->indices; k < mesh->indices + mesh->index_count; k += 3) {
			dvec p[3], n[3];
			for (int i = 0; i < 3; i++) {
				p[i] = points[k[i]];
				n[i] = dvec_of(mesh->vertices[k[i]].normal);
			}
			reference_triangle(p, n, origin, d, part, &nearest);
		}
		free(points);
	}
	if (nearest.part != REFERENCE_MISS)
		nearest.normal = reference_normal(&scene->part_transform[nearest.part], nearest.normal);
	return nearest;
}

/* ---- scenes ------------------------------------------------------------------------------------------------------ */

/* One model of part_count parts, all of them unit spheres (mesh 0) with a material each. Its only light is directional,
 * black, and shines down. */
static inline stilb_scene *reference_scene(uint32_t part_count)
{
	stilb_scene *scene;
	assert_int_equal(scene_create(1, part_count, 2, part_count, &scene), STILB_OK);
	assert_int_equal(stilb_scene_mesh_sphere(2, &scene->meshes[0]), STILB_OK);
	assert_int_equal(stilb_scene_mesh_plane(&scene->meshes[1]), STILB_OK);
	scene->first_part[1] = part_count;
	for (uint32_t p = 0; p < part_count; p++) {
		scene->part_material[p] = p;
		scene->part_transform[p] = stilb_mat4_identity();
		scene->materials[p].roughness = reference_roughness(10.0);
	}
	assert_int_equal(scene_add_lights(scene, 1), STILB_OK);
	scene->lights[0] = (stilb_scene_light){.kind = STILB_SCENE_LIGHT_DIRECTIONAL, .direction = {0.0f, -1.0f, 0.0f}};
	return scene;
}

static inline void reference_set3(float out[3], float x, float y, float z)
{
	out[0] = x;
	out[1] = y;
	out[2] = z;
}

/* The direction to a directional light, unit. */
static inline void reference_sun_from(stilb_scene *scene, float x, float y, float z)
{
	reference_set3(scene->lights[0].direction, -x, -y, -z);
}

/* ---- pictures ---------------------------------------------------------------------------------------------------- */

typedef struct picture_desc {
	stilb_render_replay_mode replay;
	stilb_render_materials materials;
	stilb_render_output output;
	uint32_t samples; /* 0 counts as 1 */
	uint32_t workers;
	const stilb_render_shading *shading; /* NULL: the default */
	stilb_render_stats *stats;           /* gets the frame's, or NULL */
} picture_desc;

/* Every model of scene as the camera sees it, drawn by a device of its own. */
static inline stilb_image picture_make(const stilb_scene *scene, const reference_camera *camera, picture_desc how)
{
	stilb_render_desc desc = {
		.replay = how.replay,
		.materials = how.materials,
		.output = how.output,
		.width = camera->width,
		.height = camera->height,
		.samples = how.samples ? how.samples : 1,
		.context_count = how.workers + 1,
	};
	stilb_render_pass pass = {.name = "main"};
	stilb_render_view view = {
		.view_projection = reference_matrix(camera),
		.lights = scene->lights,
		.light_count = scene->light_count,
		.surroundings = scene->surroundings,
		.shading = how.shading ? *how.shading : stilb_render_shading_default(),
		.backdrop = {.kind = STILB_SCENE_BACKDROP_COLOR}, /* the sky's colour, below the horizon, too */
	};
	memcpy(view.backdrop.color, scene->surroundings.sky, sizeof view.backdrop.color);
	reference_set3(view.camera_position, (float)camera->position.x, (float)camera->position.y,
	               (float)camera->position.z);
	stilb_render *render;
	stilb_job_pool *pool;
	stilb_image image = {0};
	uint32_t *ids = calloc(scene->model_count, sizeof *ids);
	assert_non_null(ids);
	for (uint32_t i = 0; i < scene->model_count; i++)
		ids[i] = i;
	assert_int_equal(stilb_job_pool_create(&(stilb_job_pool_desc){.worker_count = how.workers}, &pool), 0);
	if (stilb_render_create(&desc, &render) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	assert_int_equal(stilb_render_set_scene(render, scene), STILB_OK);
	assert_int_equal(stilb_render_frame_begin(render), STILB_OK);
	assert_int_equal(stilb_render_record(render, 0, scene, ids, scene->model_count, pool, 0), STILB_OK);
	assert_int_equal(stilb_render_replay(render, &pass, 1, &view, 1, pool, 0), STILB_OK);
	assert_int_equal(stilb_render_read_image(render, &image), STILB_OK);
	if (how.stats)
		*how.stats = stilb_render_stats_get(render);
	stilb_render_destroy(render);
	stilb_job_pool_destroy(pool);
	free(ids);
	assert_int_equal(image.width, camera->width);
	assert_int_equal(image.height, camera->height);
	assert_int_equal(image.channels, 3);
	return image;
}

/* IEEE binary16. */
static inline double reference_half(uint16_t bits)
{
	int exponent = (bits >> 10) & 31, mantissa = bits & 1023;
	double value = exponent == 0    ? ldexp(mantissa, -24)
	               : exponent == 31 ? (mantissa ? (double)NAN : HUGE_VAL)
	                                : ldexp(1024 + mantissa, exponent - 25);
	return bits & 0x8000 ? -value : value;
}

/* A channel of a linear picture. */
static inline double picture_value(const stilb_image *image, uint32_t x, uint32_t y, int channel)
{
	const uint16_t *pixels = image->pixels;
	return reference_half(pixels[3 * ((size_t)y * image->width + x) + (size_t)channel]);
}

/* Each channel between low and high, give or take tolerance of it: a half float has 11 bits. */
static inline void assert_pixel_between(const stilb_image *image, uint32_t x, uint32_t y, const double low[3],
                                        const double high[3], double tolerance)
{
	for (int c = 0; c < 3; c++) {
		double got = picture_value(image, x, y, c);
		if (!(got >= low[c] * (1.0 - tolerance) - 1e-6 && got <= high[c] * (1.0 + tolerance) + 1e-6))
			fail_msg("pixel %u, %u channel %d is %.6f, not %.6f..%.6f", x, y, c, got, low[c], high[c]);
	}
}

static inline void assert_pixel(const stilb_image *image, uint32_t x, uint32_t y, const double want[3],
                                double tolerance)
{
	assert_pixel_between(image, x, y, want, want, tolerance);
}

/* True if the pixel shows nothing but the sky's colour. */
static inline bool picture_is_sky(const stilb_image *image, const stilb_scene *scene, uint32_t x, uint32_t y)
{
	for (int c = 0; c < 3; c++)
		if (!(fabs(picture_value(image, x, y, c) - (double)scene->surroundings.sky[c]) <=
		      1e-3 * (double)scene->surroundings.sky[c]))
			return false;
	return true;
}

/* Programs end with this when there is no Vulkan driver at all; any other trouble is a failure. */
static inline bool reference_no_driver(void)
{
	stilb_gpu_listed gpu;
	uint32_t count;
	if (stilb_gpu_list(&gpu, 1, &count) == STILB_OK && count > 0)
		return false;
	printf("skipped: no Vulkan driver (apt install mesa-vulkan-drivers)\n");
	return true;
}

#endif
