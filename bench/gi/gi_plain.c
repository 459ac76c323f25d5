/* The baseline of the case `efficiency` (gi_run.h): a path tracer that uses no part of engine/gi. */
#include "bench/gi/gi_run.h"

#include <embree3/rtcore.h>
#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#define TILE 32u
#define ROULETTE_FROM 3u
#define EPSILON 1e-4f /* offset of ray origins from their surface, metres; the scene is a metre wide */

typedef struct vec {
	float x, y, z;
} vec;

static vec add(vec a, vec b)
{
	return (vec){a.x + b.x, a.y + b.y, a.z + b.z};
}
static vec sub(vec a, vec b)
{
	return (vec){a.x - b.x, a.y - b.y, a.z - b.z};
}
static vec scale(vec a, float s)
{
	return (vec){a.x * s, a.y * s, a.z * s};
}
static vec times(vec a, vec b)
{
	return (vec){a.x * b.x, a.y * b.y, a.z * b.z};
}
static float dot(vec a, vec b)
{
	return a.x * b.x + a.y * b.y + a.z * b.z;
}
static vec cross(vec a, vec b)
{
	return (vec){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static vec unit(vec a)
{
	return scale(a, 1.0f / sqrtf(dot(a, a)));
}

typedef struct light {
	vec a, ab, ac, normal, radiance;
	float area;
} light;

struct gi_plain {
	RTCDevice device;
	RTCScene scene;
	vec *diffuse, *emission; /* [triangle_count] diffuse reflectance, and emitted radiance */
	light *lights;
	uint32_t triangle_count, light_count;
	float light_area;
};

/* PCG-XSH-RR 64/32. Source: O'Neill, "PCG: A Family of Simple Fast Space-Efficient Statistically Good Algorithms for
 * Random Number Generation" (2014). */
static float random_next(uint64_t *state)
{
	uint64_t old = *state;
	*state = old * 6364136223846793005u + 1442695040888963407u;
	uint32_t shifted = (uint32_t)(((old >> 18) ^ old) >> 27), turn = (uint32_t)(old >> 59);
	uint32_t bits = (shifted >> turn) | (shifted << (-turn & 31));
	return (float)(bits >> 8) * 0x1p-24f;
}

static vec vertex_of(const stilb_scene_mesh *mesh, uint32_t i)
{
	const float *p = mesh->vertices[mesh->indices[i]].position;
	return (vec){p[0], p[1], p[2]};
}

gi_plain *gi_plain_make(const stilb_scene *scene)
{
	gi_plain *plain = calloc(1, sizeof *plain);
	if (!plain)
		bench_child_fail("no memory for the scene");
	for (uint32_t p = 0; p < scene->part_count; p++)
		plain->triangle_count += scene->meshes[scene->part_mesh[p]].index_count / 3;
	size_t places = (size_t)plain->triangle_count + 1; /* calloc(0) may return NULL */
	plain->diffuse = calloc(places, sizeof(vec));
	plain->emission = calloc(places, sizeof(vec));
	plain->lights = calloc(places, sizeof(light));
	if (!plain->diffuse || !plain->emission || !plain->lights)
		bench_child_fail("no memory for the scene");
	plain->device = rtcNewDevice(NULL);
	plain->scene = rtcNewScene(plain->device);
	RTCGeometry geometry = rtcNewGeometry(plain->device, RTC_GEOMETRY_TYPE_TRIANGLE);
	float *positions = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12,
	                                           (size_t)plain->triangle_count * 3);
	uint32_t *indices =
		rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, plain->triangle_count);
	uint32_t t = 0;
	for (uint32_t p = 0; p < scene->part_count; p++) {
		const stilb_scene_mesh *mesh = &scene->meshes[scene->part_mesh[p]];
		const stilb_scene_material *m = &scene->materials[scene->part_material[p]];
		for (uint32_t i = 0; i < mesh->index_count; i += 3, t++) {
			vec corner[3] = {vertex_of(mesh, i), vertex_of(mesh, i + 1), vertex_of(mesh, i + 2)};
			memcpy(positions + 9 * (size_t)t, corner, sizeof corner);
			for (uint32_t k = 0; k < 3; k++)
				indices[3 * t + k] = 3 * t + k;
			plain->diffuse[t] = (vec){m->diffuse[0], m->diffuse[1], m->diffuse[2]};
			plain->emission[t] = (vec){m->emission[0], m->emission[1], m->emission[2]};
			if (m->emission[0] <= 0.0f)
				continue;
			light *l = &plain->lights[plain->light_count++];
			*l = (light){.a = corner[0],
			             .ab = sub(corner[1], corner[0]),
			             .ac = sub(corner[2], corner[0]),
			             .radiance = plain->emission[t]};
			vec n = cross(l->ab, l->ac);
			l->area = 0.5f * sqrtf(dot(n, n));
			l->normal = unit(n);
			plain->light_area += l->area;
		}
	}
	rtcCommitGeometry(geometry);
	rtcAttachGeometry(plain->scene, geometry);
	rtcReleaseGeometry(geometry);
	rtcCommitScene(plain->scene);
	return plain;
}

void gi_plain_finish(gi_plain *plain)
{
	rtcReleaseScene(plain->scene);
	rtcReleaseDevice(plain->device);
	free(plain->diffuse);
	free(plain->emission);
	free(plain->lights);
	free(plain);
}

/* ---- one path ---------------------------------------------------------------------------------------------------- */

static struct RTCRayHit ray_from(vec origin, vec direction)
{
	return (struct RTCRayHit){.ray = {.org_x = origin.x,
	                                  .org_y = origin.y,
	                                  .org_z = origin.z,
	                                  .dir_x = direction.x,
	                                  .dir_y = direction.y,
	                                  .dir_z = direction.z,
	                                  .tnear = EPSILON,
	                                  .tfar = INFINITY,
	                                  .mask = UINT32_MAX},
	                          .hit = {.geomID = RTC_INVALID_GEOMETRY_ID}};
}

static vec cosine_direction(vec n, uint64_t *random)
{
	float u = random_next(random), phi = 6.2831853f * random_next(random), r = sqrtf(u);
	vec t = unit(cross(fabsf(n.x) > 0.5f ? (vec){0, 1, 0} : (vec){1, 0, 0}, n)), b = cross(n, t);
	return add(add(scale(t, r * cosf(phi)), scale(b, r * sinf(phi))), scale(n, sqrtf(1.0f - u)));
}

static float power_heuristic(float a, float b)
{
	return a * a / (a * a + b * b);
}

/* Radiance reflected directly from one point on a light, chosen uniformly over the area of all lights, with the weight
 * of multiple importance sampling (MIS). */
static vec direct(const gi_plain *plain, vec position, vec n, vec diffuse, uint64_t *random, uint64_t *rays)
{
	float at = random_next(random) * plain->light_area;
	const light *l = plain->lights;
	while (at >= l->area && l + 1 < plain->lights + plain->light_count)
		at -= l++->area;
	float su = sqrtf(random_next(random)), v = random_next(random);
	vec target = add(l->a, add(scale(l->ab, su * (1.0f - v)), scale(l->ac, su * v)));
	vec to = sub(target, position);
	float distance2 = dot(to, to), distance = sqrtf(distance2);
	vec direction = scale(to, 1.0f / distance);
	float cosine = dot(n, direction), light_cosine = -dot(l->normal, direction);
	if (cosine <= 0.0f || light_cosine <= 0.0f)
		return (vec){.x = 0.0f};
	struct RTCRayHit shadow = ray_from(position, direction);
	shadow.ray.tfar = distance - EPSILON;
	struct RTCIntersectContext context;
	rtcInitIntersectContext(&context);
	rtcOccluded1(plain->scene, &context, &shadow.ray);
	(*rays)++;
	if (shadow.ray.tfar < 0.0f)
		return (vec){.x = 0.0f};
	float pdf = distance2 / (light_cosine * plain->light_area), other = cosine * 0.31830989f;
	return scale(times(diffuse, l->radiance), 0.31830989f * cosine / pdf * power_heuristic(pdf, other));
}

static vec trace(const gi_plain *plain, vec origin, vec direction, uint32_t depth, uint64_t *random, uint64_t *rays)
{
	vec sum = {0}, throughput = {1, 1, 1};
	float pdf = 0.0f; /* density with which `direction` was sampled, for MIS; 0: a camera ray, which needs no weight */
	for (uint32_t bounce = 0;; bounce++) {
		struct RTCRayHit ray = ray_from(origin, direction);
		struct RTCIntersectContext context;
		rtcInitIntersectContext(&context);
		rtcIntersect1(plain->scene, &context, &ray);
		(*rays)++;
		if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID)
			return sum;
		vec geometric = unit((vec){ray.hit.Ng_x, ray.hit.Ng_y, ray.hit.Ng_z});
		bool front = dot(geometric, direction) < 0.0f;
		vec emission = plain->emission[ray.hit.primID], diffuse = plain->diffuse[ray.hit.primID];
		if (front && emission.x > 0.0f) {
			float light_pdf = ray.ray.tfar * ray.ray.tfar / (-dot(geometric, direction) * plain->light_area);
			float weight = pdf > 0.0f ? power_heuristic(pdf, light_pdf) : 1.0f;
			sum = add(sum, scale(times(throughput, emission), weight));
		}
		if (bounce == depth)
			return sum;
		vec n = front ? geometric : scale(geometric, -1.0f);
		origin = add(origin, scale(direction, ray.ray.tfar));
		sum = add(sum, times(throughput, direct(plain, origin, n, diffuse, random, rays)));
		direction = cosine_direction(n, random);
		pdf = dot(n, direction) * 0.31830989f;
		throughput = times(throughput, diffuse);
		if (bounce + 1 >= ROULETTE_FROM) {
			float survival = fminf(0.95f, fmaxf(throughput.x, fmaxf(throughput.y, throughput.z)));
			if (random_next(random) >= survival)
				return sum;
			throughput = scale(throughput, 1.0f / survival);
		}
	}
}

/* ---- a picture --------------------------------------------------------------------------------------------------- */

typedef struct render_job {
	const gi_plain *plain;
	const stilb_gi_settings *settings;
	float *rgb;
	_Atomic uint32_t next_tile;
	_Atomic uint64_t rays;
} render_job;

static vec pixel(const render_job *job, uint32_t x, uint32_t y, uint64_t *rays)
{
	const stilb_gi_settings *s = job->settings;
	uint64_t random = stilb_random_u64(s->seed, (uint64_t)y * s->width + x);
	float half = tanf(0.5f * s->camera.fov_y), aspect = (float)s->width / (float)s->height;
	vec eye = {s->camera.position[0], s->camera.position[1], s->camera.position[2]}, sum = {0};
	for (uint32_t i = 0; i < s->samples; i++) {
		float px = ((float)x + random_next(&random)) / (float)s->width * 2.0f - 1.0f;
		float py = 1.0f - ((float)y + random_next(&random)) / (float)s->height * 2.0f;
		vec direction = unit((vec){px * half * aspect, py * half, -1.0f});
		sum = add(sum, trace(job->plain, eye, direction, s->depth, &random, rays));
	}
	return scale(sum, 1.0f / (float)s->samples);
}

static void *render_tiles(void *data)
{
	render_job *job = data;
	uint32_t width = job->settings->width, height = job->settings->height;
	uint32_t columns = (width + TILE - 1) / TILE, rows = (height + TILE - 1) / TILE;
	uint64_t rays = 0;
	for (;;) {
		uint32_t tile = atomic_fetch_add_explicit(
			&job->next_tile, 1, memory_order_relaxed); /* relaxed: hands out numbers, orders nothing */
		if (tile >= columns * rows)
			break;
		for (uint32_t y = tile / columns * TILE; y < (tile / columns + 1) * TILE && y < height; y++)
			for (uint32_t x = tile % columns * TILE; x < (tile % columns + 1) * TILE && x < width; x++) {
				vec color = pixel(job, x, y, &rays);
				memcpy(job->rgb + 3 * ((size_t)y * width + x), &color, sizeof color);
			}
	}
	atomic_fetch_add_explicit(&job->rays, rays, memory_order_relaxed); /* relaxed: read after the threads were joined */
	return NULL;
}

gi_run_picture gi_plain_render(const gi_plain *plain, const stilb_gi_settings *settings, uint32_t threads)
{
	render_job job = {.plain = plain, .settings = settings};
	job.rgb = calloc((size_t)settings->width * settings->height, 3 * sizeof(float));
	if (!job.rgb)
		bench_child_fail("no memory for a picture");
	uint64_t begin = bench_child_now_ns();
	pthread_t others[64];
	uint32_t started = 0;
	while (started + 1 < threads && started < 64 && pthread_create(&others[started], NULL, render_tiles, &job) == 0)
		started++;
	render_tiles(&job);
	for (uint32_t i = 0; i < started; i++)
		pthread_join(others[i], NULL);
	return (gi_run_picture){.rgb = job.rgb, .seconds = 1e-9 * (double)(bench_child_now_ns() - begin), .rays = job.rays};
}
