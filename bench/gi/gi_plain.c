/*
 * The plain path tracer (gi_run.h): it shares Embree, the compiler's flags and engine/shading's formulas with
 * engine/gi, and nothing else. One path at a time; Owen-scrambled Sobol points (Burley 2020); at each hit one light,
 * chosen by its power; power heuristic; Russian roulette from the third bounce. Robust mode, as in engine/gi.
 */
#include "bench/gi/gi_run.h"

#include "shading/shade_brdf.h"
#include "shading/shade_luminance.h"
#include "shading/shade_sampling.h"

#include <embree3/rtcore.h>
#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#define TILE 32u
#define ROULETTE_FROM 3u
#define EPSILON 1e-4f    /* offset of ray origins from their surface, metres; the scenes are a metre to 20 wide */
#define SEEN_LEAST 1e-3f /* shading normals that face away from the viewer are bent to this cosine, as in engine/gi */

typedef struct triangle {
	stilb_vec3 normal[3];
	float uv[3][2];
	uint32_t material, light; /* light: 1 + its number */
} triangle;

/* A triangle, a point, a sun, or, without a scene light and an area, the panorama. */
typedef struct light {
	stilb_vec3 a, ab, ac, normal, radiance;
	float area, chance; /* chance: that it is asked */
	const stilb_scene_light *listed;
} light;

struct gi_plain {
	RTCDevice device;
	RTCScene scene;
	const stilb_scene *from;
	triangle *triangles;
	light *lights;
	float *choice;   /* [light_count] sums of the lights' chances */
	float *texels;   /* sums of the panorama's texels, brightness x solid angle, the last is 1 */
	float map_scale; /* density of asking for a direction of the panorama, over its brightness there */
	float map_chance;
	uint32_t triangle_count, light_count;
};

/* ---- numbers ----------------------------------------------------------------------------------------------------- */

static uint32_t mixed(uint32_t x)
{
	x = (x ^ (x >> 16)) * 0x7feb352du;
	x = (x ^ (x >> 15)) * 0x846ca68bu;
	return x ^ (x >> 16);
}

static uint32_t reversed(uint32_t x)
{
	x = ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
	x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
	x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
	return __builtin_bswap32(x);
}

/* Scrambles each bit by those below it. */
static uint32_t scrambled(uint32_t x, uint32_t seed)
{
	x += seed;
	x ^= x * 0x6c50b47cu;
	x ^= x * 0xb82f1e52u;
	x ^= x * 0xc7afe638u;
	return x ^ (x * 0x8d22f6e6u);
}

typedef struct numbers {
	uint32_t pixel, sample, dimension;
} numbers;

/* The next two dimensions of the sample. */
static stilb_vec2 next_2d(numbers *of)
{
	uint32_t seed = mixed(of->pixel ^ mixed(++of->dimension));
	uint32_t i = reversed(scrambled(reversed(of->sample), seed)), pascal = i;
	pascal ^= (pascal >> 1) & 0x55555555u;
	pascal ^= (pascal >> 2) & 0x33333333u;
	pascal ^= (pascal >> 4) & 0x0f0f0f0fu;
	pascal ^= (pascal >> 8) & 0x00ff00ffu;
	pascal ^= (pascal >> 16) & 0x0000ffffu;
	uint32_t x = reversed(scrambled(i, mixed(seed ^ 1u))), y = reversed(scrambled(pascal, mixed(seed ^ 2u)));
	return (stilb_vec2){(float)(x >> 8) * 0x1p-24f, (float)(y >> 8) * 0x1p-24f};
}

/* ---- the scene --------------------------------------------------------------------------------------------------- */

static stilb_vec3 vector(const float v[3])
{
	return stilb_vec3_make(v[0], v[1], v[2]);
}

static float length_of(stilb_vec3 v)
{
	return sqrtf(stilb_vec3_dot(v, v));
}

static stilb_vec3 transformed(const stilb_mat4 *by, const float p[3], float w)
{
	const float *m = by->m;
	return stilb_vec3_make(m[0] * p[0] + m[4] * p[1] + m[8] * p[2] + m[12] * w,
	                       m[1] * p[0] + m[5] * p[1] + m[9] * p[2] + m[13] * w,
	                       m[2] * p[0] + m[6] * p[1] + m[10] * p[2] + m[14] * w);
}

static stilb_vec3 map_at(const stilb_image *map, stilb_vec3 d, uint32_t *texel)
{
	uint32_t x = (uint32_t)((atan2f(d[0], -d[2]) * 0.15915494f + 0.5f) * (float)map->width);
	uint32_t y = (uint32_t)(acosf(fminf(fmaxf(d[1], -1.0f), 1.0f)) * 0.31830989f * (float)map->height);
	x = x < map->width ? x : map->width - 1;
	y = y < map->height ? y : map->height - 1;
	*texel = y * map->width + x;
	return vector((const float *)map->pixels + 3 * (size_t)*texel);
}

static float row_height(const stilb_image *map, uint32_t row)
{
	return cosf(3.14159265f * (float)row / (float)map->height);
}

/* Sums the panorama up; returns its power. */
static float map_prepare(gi_plain *plain)
{
	const stilb_image *map = &plain->from->surroundings.panorama;
	double sum = 0.0;
	plain->texels = calloc((size_t)map->width * map->height, sizeof *plain->texels);
	for (uint32_t i = 0; i < map->width * map->height; i++) {
		float solid =
			6.2831853f / (float)map->width * (row_height(map, i / map->width) - row_height(map, i / map->width + 1));
		sum += (double)(shade_luminance(vector((const float *)map->pixels + 3 * (size_t)i)) * solid);
		plain->texels[i] = (float)sum;
	}
	for (uint32_t i = 0; i < map->width * map->height; i++)
		plain->texels[i] /= (float)sum;
	plain->map_scale = (float)(1.0 / sum);
	return (float)sum;
}

/* The texel of the material's colour at a point of a triangle; white without one. */
static stilb_vec4 texel_at(const gi_plain *plain, const triangle *t, float u, float v)
{
	const stilb_scene_material *m = &plain->from->materials[t->material];
	if (m->surface == 0)
		return (stilb_vec4){1, 1, 1, 1};
	const stilb_image *image =
		&plain->from->textures[plain->from->surfaces[m->surface - 1].maps[STILB_SCENE_MAP_COLOR].texture - 1];
	float x = t->uv[0][0] + u * (t->uv[1][0] - t->uv[0][0]) + v * (t->uv[2][0] - t->uv[0][0]);
	float y = t->uv[0][1] + u * (t->uv[1][1] - t->uv[0][1]) + v * (t->uv[2][1] - t->uv[0][1]);
	uint32_t column = (uint32_t)((x - floorf(x)) * (float)image->width) % image->width;
	uint32_t row = (uint32_t)((y - floorf(y)) * (float)image->height) % image->height;
	const uint8_t *texel = (const uint8_t *)image->pixels + 4 * ((size_t)row * image->width + column);
	return (stilb_vec4){texel[0], texel[1], texel[2], texel[3]} * (1.0f / 255.0f);
}

static void cut_out(const struct RTCFilterFunctionNArguments *args)
{
	const gi_plain *plain = args->geometryUserPtr;
	if (args->valid[0] != -1)
		return;
	const struct RTCHit *hit = (const struct RTCHit *)args->hit; /* of one lane, which is as the structure is */
	const triangle *t = &plain->triangles[hit->primID];
	uint32_t surface = plain->from->materials[t->material].surface;
	if (surface && texel_at(plain, t, hit->u, hit->v)[3] < plain->from->surfaces[surface - 1].cutoff)
		args->valid[0] = 0;
}

static void add_light(gi_plain *plain, light l, float power)
{
	l.chance = power;
	plain->choice[plain->light_count] = power + (plain->light_count ? plain->choice[plain->light_count - 1] : 0.0f);
	plain->lights[plain->light_count++] = l;
}

static void add_part(gi_plain *plain, uint32_t p, float *positions, uint32_t *t)
{
	const stilb_scene *scene = plain->from;
	const stilb_scene_mesh *mesh = &scene->meshes[scene->part_mesh[p]];
	stilb_vec3 emission = vector(scene->materials[scene->part_material[p]].emission);
	for (uint32_t i = 0; i < mesh->index_count; i += 3, (*t)++) {
		triangle *out = &plain->triangles[*t];
		stilb_vec3 corner[3];
		*out = (triangle){.material = scene->part_material[p]};
		for (uint32_t k = 0; k < 3; k++) {
			const stilb_scene_vertex *v = &mesh->vertices[mesh->indices[i + k]];
			corner[k] = transformed(&scene->part_transform[p], v->position, 1.0f);
			out->normal[k] = stilb_vec3_normalize(transformed(&scene->part_transform[p], v->normal, 0.0f));
			memcpy(out->uv[k], v->uv, sizeof v->uv);
			for (uint32_t c = 0; c < 3; c++)
				positions[9 * (size_t)*t + 3 * k + c] = corner[k][c];
		}
		if (emission[0] <= 0.0f)
			continue;
		light l = {.a = corner[0], .ab = corner[1] - corner[0], .ac = corner[2] - corner[0], .radiance = emission};
		stilb_vec3 n = stilb_vec3_cross(l.ab, l.ac);
		l.area = 0.5f * length_of(n);
		l.normal = stilb_vec3_normalize(n);
		add_light(plain, l, l.area * shade_luminance(emission) * 3.14159265f);
		out->light = plain->light_count;
	}
}

static void add_listed(gi_plain *plain)
{
	const stilb_scene *scene = plain->from;
	for (uint32_t i = 0; i < scene->light_count; i++) {
		const stilb_scene_light *listed = &scene->lights[i];
		if (listed->face)
			continue;
		if (listed->kind != STILB_SCENE_LIGHT_POINT && listed->kind != STILB_SCENE_LIGHT_DIRECTIONAL)
			bench_child_fail("the plain tracer has no lights of kind %d", (int)listed->kind);
		light l = {.listed = listed, .radiance = vector(listed->intensity)};
		add_light(plain, l, 12.566371f * shade_luminance(l.radiance));
	}
	if (scene->surroundings.panorama.pixels)
		add_light(plain, (light){0}, map_prepare(plain));
	float all = plain->light_count ? plain->choice[plain->light_count - 1] : 1.0f;
	for (uint32_t i = 0; i < plain->light_count; i++) {
		plain->lights[i].chance /= all;
		plain->choice[i] /= all;
	}
	if (plain->texels)
		plain->map_chance = plain->lights[plain->light_count - 1].chance;
}

gi_plain *gi_plain_make(const stilb_scene *scene)
{
	gi_plain *plain = calloc(1, sizeof *plain);
	if (!plain)
		bench_child_fail("no memory for the scene");
	plain->from = scene;
	for (uint32_t p = 0; p < scene->part_count; p++)
		plain->triangle_count += scene->meshes[scene->part_mesh[p]].index_count / 3;
	size_t lights = (size_t)plain->triangle_count + scene->light_count + 1;
	plain->triangles = stilb_memory_alloc(plain->triangle_count, sizeof *plain->triangles);
	plain->lights = stilb_memory_alloc(lights, sizeof *plain->lights);
	plain->choice = stilb_memory_alloc(lights, sizeof *plain->choice);
	if (!plain->triangles || !plain->lights || !plain->choice)
		bench_child_fail("no memory for the scene");
	plain->device = rtcNewDevice(NULL);
	plain->scene = rtcNewScene(plain->device);
	rtcSetSceneFlags(plain->scene, RTC_SCENE_FLAG_ROBUST);
	RTCGeometry geometry = rtcNewGeometry(plain->device, RTC_GEOMETRY_TYPE_TRIANGLE);
	float *positions = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12,
	                                           (size_t)plain->triangle_count * 3);
	uint32_t *indices =
		rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, plain->triangle_count);
	for (uint32_t i = 0; i < 3 * plain->triangle_count; i++)
		indices[i] = i;
	for (uint32_t p = 0, t = 0; p < scene->part_count; p++)
		add_part(plain, p, positions, &t);
	add_listed(plain);
	if (scene->surface_count > 0) {
		rtcSetGeometryUserData(geometry, plain);
		rtcSetGeometryIntersectFilterFunction(geometry, cut_out);
		rtcSetGeometryOccludedFilterFunction(geometry, cut_out);
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
	free(plain->triangles);
	free(plain->lights);
	free(plain->choice);
	free(plain->texels);
	free(plain);
}

/* ---- one path ---------------------------------------------------------------------------------------------------- */

typedef struct vertex {
	stilb_vec3 position, geometric, to_viewer, diffuse;
	shade_frame frame;
	shade_brdf_parameters highlight;
	float share; /* chance that the highlight is sampled */
} vertex;

static const shade_brdf_model model = {SHADE_BRDF_MICROFACET, SHADE_NDF_GGX, SHADE_G_SMITH_GGX, SHADE_F_SCHLICK};

static stilb_vec3 reflected(const vertex *at, stilb_vec3 direction)
{
	float cosine = stilb_vec3_dot(at->frame.n, direction);
	if (cosine <= 0.0f || stilb_vec3_dot(at->geometric, direction) <= 0.0f)
		return (stilb_vec3){0};
	stilb_vec3 sum = at->diffuse * (0.31830989f * cosine);
	return at->share > 0.0f ? sum + shade_brdf_cos(model, at->highlight, at->frame, direction, at->to_viewer) : sum;
}

static shade_alphas alphas_of(const vertex *at)
{
	float alpha = shade_alpha_from_roughness(at->highlight.roughness);
	return (shade_alphas){alpha, alpha};
}

static float density(const vertex *at, stilb_vec3 direction)
{
	float cosine = fmaxf(stilb_vec3_dot(at->frame.n, direction), 0.0f) * 0.31830989f;
	if (at->share == 0.0f)
		return cosine;
	stilb_vec3 v = shade_frame_to_local(at->frame, at->to_viewer), l = shade_frame_to_local(at->frame, direction);
	return cosine * (1.0f - at->share) + shade_pdf_ggx_visible(alphas_of(at), v, l) * at->share;
}

static float power_heuristic(float a, float b)
{
	return a * a / (a * a + b * b);
}

static struct RTCRayHit ray_from(stilb_vec3 origin, stilb_vec3 direction)
{
	return (struct RTCRayHit){.ray = {.org_x = origin[0],
	                                  .org_y = origin[1],
	                                  .org_z = origin[2],
	                                  .dir_x = direction[0],
	                                  .dir_y = direction[1],
	                                  .dir_z = direction[2],
	                                  .tnear = EPSILON,
	                                  .tfar = INFINITY,
	                                  .mask = UINT32_MAX},
	                          .hit = {.geomID = RTC_INVALID_GEOMETRY_ID, .instID = {RTC_INVALID_GEOMETRY_ID}}};
}

/* A point of the light that is asked, by its density per steradian; 0: it sends nothing. A point's and a sun's is the
 * chance of asking them alone. */
static float light_sample(const gi_plain *plain, const light *l, stilb_vec3 position, stilb_vec2 u,
                          stilb_vec3 *direction, float *distance, stilb_vec3 *radiance)
{
	*radiance = l->radiance;
	*distance = INFINITY;
	if (l->listed && l->listed->kind == STILB_SCENE_LIGHT_DIRECTIONAL) {
		*direction = -vector(l->listed->direction);
		return l->chance;
	}
	if (!l->listed && l->area == 0.0f) {
		const stilb_image *map = &plain->from->surroundings.panorama;
		uint32_t texel = gi_run_find(plain->texels, map->width * map->height, u[0]), row = texel / map->width;
		float before = texel ? plain->texels[texel - 1] : 0.0f;
		float across = fminf((u[0] - before) / (plain->texels[texel] - before), 0.999999f);
		float y = row_height(map, row) + (row_height(map, row + 1) - row_height(map, row)) * u[1];
		float phi = 6.2831853f * (((float)(texel % map->width) + across) / (float)map->width - 0.5f);
		float r = sqrtf(fmaxf(1.0f - y * y, 0.0f));
		*direction = stilb_vec3_make(r * sinf(phi), y, -r * cosf(phi));
		*radiance = vector((const float *)map->pixels + 3 * (size_t)texel);
		return shade_luminance(*radiance) * plain->map_scale * l->chance;
	}
	stilb_vec3 target = l->listed ? vector(l->listed->position) : l->a;
	float su = sqrtf(u[0]);
	if (!l->listed)
		target += l->ab * (su * (1.0f - u[1])) + l->ac * (su * u[1]);
	stilb_vec3 to = target - position;
	*distance = length_of(to);
	*direction = to * (1.0f / *distance);
	if (l->listed) {
		*radiance *= 1.0f / (*distance * *distance);
		return l->chance;
	}
	float cosine = -stilb_vec3_dot(l->normal, *direction);
	return cosine > 0.0f ? *distance * *distance / (cosine * l->area) * l->chance : 0.0f;
}

/* Radiance reflected directly from one light, with its weight of multiple importance sampling. */
static stilb_vec3 direct(const gi_plain *plain, const vertex *at, float choice, stilb_vec2 u, uint64_t *rays)
{
	stilb_vec3 direction, radiance;
	float distance;
	if (plain->light_count == 0)
		return (stilb_vec3){0};
	const light *l = &plain->lights[gi_run_find(plain->choice, plain->light_count, choice)];
	float pdf = light_sample(plain, l, at->position, u, &direction, &distance, &radiance);
	stilb_vec3 sent = pdf > 0.0f ? reflected(at, direction) * radiance : (stilb_vec3){0};
	if (!(sent[0] + sent[1] + sent[2] > 0.0f))
		return (stilb_vec3){0};
	struct RTCRayHit shadow = ray_from(at->position, direction);
	shadow.ray.tfar = distance - EPSILON;
	struct RTCIntersectContext context;
	rtcInitIntersectContext(&context);
	rtcOccluded1(plain->scene, &context, &shadow.ray);
	(*rays)++;
	if (shadow.ray.tfar < 0.0f)
		return (stilb_vec3){0};
	return sent * ((l->listed ? 1.0f : power_heuristic(pdf, density(at, direction))) / pdf);
}

static vertex vertex_at(const gi_plain *plain, const triangle *t, const struct RTCRayHit *ray, stilb_vec3 origin,
                        stilb_vec3 direction, stilb_vec3 geometric)
{
	const stilb_scene_material *m = &plain->from->materials[t->material];
	stilb_vec4 texel = texel_at(plain, t, ray->hit.u, ray->hit.v);
	stilb_vec3 normal = stilb_vec3_normalize(t->normal[0] * (1.0f - ray->hit.u - ray->hit.v) +
	                                         t->normal[1] * ray->hit.u + t->normal[2] * ray->hit.v);
	if (stilb_vec3_dot(normal, geometric) < 0.0f)
		normal = -normal;
	float seen = -stilb_vec3_dot(normal, direction);
	if (seen < SEEN_LEAST) {
		normal = stilb_vec3_normalize(normal - direction * (SEEN_LEAST - seen));
		seen = SEEN_LEAST;
	}
	vertex at = {.position = origin + direction * ray->ray.tfar,
	             .geometric = geometric,
	             .to_viewer = -direction,
	             .diffuse = m->surface ? stilb_vec3_make(texel[0], texel[1], texel[2]) : vector(m->diffuse),
	             .frame = shade_frame_from_normal(normal),
	             .highlight = {.specular = vector(m->specular), .roughness = m->roughness}};
	float highlight = m->surface ? 0.0f : shade_luminance(at.highlight.specular);
	if (highlight > 0.0f) {
		at.diffuse *= shade_brdf_diffuse_left(model, seen, m->roughness);
		float diffuse = shade_luminance(at.diffuse);
		at.share = diffuse > 0.0f ? fmaxf(highlight / (highlight + diffuse), 0.25f) : 1.0f;
	}
	return at;
}

/* Light of the surroundings that a ray found; pdf: the density of its direction, 0 of a camera ray. */
static stilb_vec3 missed(const gi_plain *plain, stilb_vec3 direction, float pdf)
{
	const stilb_scene_surroundings *around = &plain->from->surroundings;
	uint32_t texel;
	if (!plain->texels)
		return vector(direction[1] < 0.0f ? around->ground : around->sky);
	stilb_vec3 radiance = map_at(&around->panorama, direction, &texel);
	float asked = shade_luminance(radiance) * plain->map_scale * plain->map_chance;
	return pdf > 0.0f ? radiance * power_heuristic(pdf, asked) : radiance;
}

/* Light that the triangle itself emits. */
static stilb_vec3 emitted(const gi_plain *plain, const triangle *t, float cosine, float distance, float pdf)
{
	const light *l = &plain->lights[t->light - 1];
	float asked = distance * distance / (cosine * l->area) * l->chance;
	return l->radiance * (pdf > 0.0f ? power_heuristic(pdf, asked) : 1.0f);
}

/* Chooses the next direction; returns its density, 0 if it carries nothing. */
static float go_on(const vertex *at, float lobe, stilb_vec2 u, stilb_vec3 *direction, stilb_vec3 *throughput)
{
	stilb_vec3 local =
		lobe < at->share
			? shade_sample_ggx_visible(alphas_of(at), shade_frame_to_local(at->frame, at->to_viewer), u).direction
			: shade_sample_cosine(u).direction;
	*direction = stilb_vec3_normalize(shade_frame_to_world(at->frame, local));
	float pdf = density(at, *direction);
	stilb_vec3 sent = reflected(at, *direction);
	if (!(pdf > 0.0f) || !(sent[0] + sent[1] + sent[2] > 0.0f))
		return 0.0f;
	*throughput *= sent * (1.0f / pdf);
	return pdf;
}

static stilb_vec3 trace(const gi_plain *plain, stilb_vec3 origin, stilb_vec3 direction, uint32_t depth, numbers *random,
                        uint64_t *rays)
{
	stilb_vec3 sum = {0}, throughput = stilb_vec3_make(1, 1, 1);
	float pdf = 0.0f; /* density with which `direction` was sampled; 0: a camera ray, which needs no weight */
	for (uint32_t bounce = 0;; bounce++) {
		struct RTCRayHit ray = ray_from(origin, direction);
		struct RTCIntersectContext context;
		rtcInitIntersectContext(&context);
		rtcIntersect1(plain->scene, &context, &ray);
		(*rays)++;
		if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID)
			return sum + throughput * missed(plain, direction, pdf);
		const triangle *t = &plain->triangles[ray.hit.primID];
		stilb_vec3 geometric = stilb_vec3_normalize(stilb_vec3_make(ray.hit.Ng_x, ray.hit.Ng_y, ray.hit.Ng_z));
		float cosine = -stilb_vec3_dot(geometric, direction);
		if (cosine > 0.0f && t->light)
			sum += throughput * emitted(plain, t, cosine, ray.ray.tfar, pdf);
		if (bounce == depth)
			return sum;
		vertex at = vertex_at(plain, t, &ray, origin, direction, cosine > 0.0f ? geometric : -geometric);
		stilb_vec2 place = next_2d(random), choice = next_2d(random), u = next_2d(random);
		sum += throughput * direct(plain, &at, choice[0], place, rays);
		pdf = go_on(&at, choice[1], u, &direction, &throughput);
		if (pdf == 0.0f)
			return sum;
		origin = at.position;
		if (bounce + 1 >= ROULETTE_FROM) {
			float survival = fminf(0.95f, fmaxf(throughput[0], fmaxf(throughput[1], throughput[2])));
			if (next_2d(random)[0] >= survival)
				return sum;
			throughput *= 1.0f / survival;
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

static stilb_vec3 pixel(const render_job *job, uint32_t x, uint32_t y, uint64_t *rays)
{
	const stilb_gi_settings *s = job->settings;
	const stilb_scene_camera *c = &s->camera;
	uint32_t hash = (uint32_t)stilb_random_u64(s->seed, (uint64_t)y * s->width + x);
	float half = tanf(0.5f * c->fov_y), aspect = (float)s->width / (float)s->height;
	stilb_vec3 forward = {-sinf(c->yaw) * cosf(c->pitch), sinf(c->pitch), -cosf(c->yaw) * cosf(c->pitch)};
	stilb_vec3 right = {cosf(c->yaw), 0.0f, -sinf(c->yaw)}, up = stilb_vec3_cross(right, forward), sum = {0};
	for (uint32_t i = 0; i < s->samples; i++) {
		numbers random = {hash, i, 0};
		stilb_vec2 at = next_2d(&random);
		float px = ((float)x + at[0]) / (float)s->width * 2.0f - 1.0f;
		float py = 1.0f - ((float)y + at[1]) / (float)s->height * 2.0f;
		stilb_vec3 direction = stilb_vec3_normalize(right * (px * half * aspect) + up * (py * half) + forward);
		sum += trace(job->plain, vector(c->position), direction, s->depth, &random, rays);
	}
	return sum * (1.0f / (float)s->samples);
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
				stilb_vec3 color = pixel(job, x, y, &rays);
				for (size_t c = 0; c < 3; c++)
					job->rgb[3 * ((size_t)y * width + x) + c] = color[c];
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
	gi_run_clock begin = gi_run_now();
	pthread_t others[64];
	uint32_t started = 0;
	while (started + 1 < threads && started < 64 && pthread_create(&others[started], NULL, render_tiles, &job) == 0)
		started++;
	render_tiles(&job);
	for (uint32_t i = 0; i < started; i++)
		pthread_join(others[i], NULL);
	gi_run_clock end = gi_run_now();
	return (gi_run_picture){.rgb = job.rgb,
	                        .seconds = end.seconds - begin.seconds,
	                        .cpu_seconds = end.cpu_seconds - begin.cpu_seconds,
	                        .rays = job.rays};
}
