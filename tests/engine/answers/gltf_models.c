#include "gltf_models.h"

#include "image/image.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265f
#define ACROSS 122u /* squares of the helmet along its equator: an even number, both halves have as many */
#define UP 62u
#define SPHERE_ACROSS 48u
#define SPHERE_UP 24u
#define MOST ((ACROSS + 2) * (UP + 1))

/* ---- the helmet's relief, of which normals and occlusion are made ------------------------------------------------ */

/* A number in [0, 1] for a place of a lattice, always the same. */
static float lattice(int x, int y)
{
	uint32_t h = (uint32_t)x * 73856093u ^ (uint32_t)y * 19349663u;
	h = (h ^ h >> 15) * 0x85ebca6bu;
	h = (h ^ h >> 13) * 0xc2b2ae35u;
	return (float)((h ^ h >> 16) & 0xffffu) / 65535.0f;
}

static float smooth(float low, float high, float x)
{
	float t = fminf(fmaxf((x - low) / (high - low), 0.0f), 1.0f);
	return t * t * (3.0f - 2.0f * t);
}

/* Between the numbers of the lattice, [0, 1]. */
static float noise(float x, float y)
{
	int i = (int)floorf(x), j = (int)floorf(y);
	float s = smooth(0.0f, 1.0f, x - (float)i), t = smooth(0.0f, 1.0f, y - (float)j);
	float above = lattice(i, j) + (lattice(i + 1, j) - lattice(i, j)) * s;
	float below = lattice(i, j + 1) + (lattice(i + 1, j + 1) - lattice(i, j + 1)) * s;
	return above + (below - above) * t;
}

static float clouds(float x, float y)
{
	return 0.5f * noise(x, y) + 0.3f * noise(2.1f * x, 2.1f * y) + 0.2f * noise(4.3f * x, 4.3f * y);
}

/* 1 in the grooves between panels, 0 elsewhere. */
static float groove(float u, float v)
{
	float across = fabsf(fmodf(u * 4.0f, 1.0f) - 0.5f) / 4.0f, up = fabsf(fmodf(v * 6.0f, 1.0f) - 0.5f) / 6.0f;
	return 1.0f - smooth(0.002f, 0.006f, fminf(across, up));
}

/* 1 on the visor, in front, 0 elsewhere. */
static float visor(float u, float v)
{
	return (1.0f - smooth(0.26f, 0.28f, u)) * smooth(0.38f, 0.4f, v) * (1.0f - smooth(0.52f, 0.54f, v));
}

static float height(float u, float v)
{
	return 0.02f * clouds(24.0f * u, 24.0f * v) - 0.006f * groove(u, v) + 0.01f * visor(u, v);
}

/* ---- pictures ---------------------------------------------------------------------------------------------------- */

typedef void texel_function(float u, float v, float out[3]);

/* How worn the paint is, [0, 1]. */
static float wear(float u, float v)
{
	return smooth(0.58f, 0.66f, clouds(11.0f * u + 3.0f, 11.0f * v)) * (1.0f - visor(u, v));
}

static void color_texel(float u, float v, float out[3])
{
	float bare = wear(u, v), tone = 0.8f + 0.4f * clouds(40.0f * u, 40.0f * v);
	const float paint[3] = {0.75f, 0.32f, 0.12f}, metal[3] = {0.72f, 0.7f, 0.66f}, glass[3] = {0.08f, 0.1f, 0.12f};
	for (int c = 0; c < 3; c++) {
		float mixed = (paint[c] + (metal[c] - paint[c]) * bare) * tone * (1.0f - 0.6f * groove(u, v));
		out[c] = mixed + (glass[c] - mixed) * visor(u, v);
	}
}

static void reflection_texel(float u, float v, float out[3])
{
	float bare = wear(u, v);
	out[0] = 1.0f;
	out[1] = 0.45f + 0.3f * clouds(30.0f * u, 30.0f * v) + 0.1f * bare - 0.3f * visor(u, v);
	out[2] = bare;
}

static void normal_texel(float u, float v, float out[3])
{
	float step = 1.0f / 2048.0f;
	float x = (height(u - step, v) - height(u + step, v)) / (2.0f * step);
	float y = (height(u, v + step) - height(u, v - step)) / (2.0f * step);
	float length = sqrtf(x * x + y * y + 1.0f);
	out[0] = 0.5f + 0.5f * x / length;
	out[1] = 0.5f + 0.5f * y / length;
	out[2] = 0.5f + 0.5f / length;
}

static void occlusion_texel(float u, float v, float out[3])
{
	out[0] = out[1] = out[2] = 1.0f - 0.6f * groove(u, v) - 0.2f * (1.0f - clouds(24.0f * u, 24.0f * v));
}

static void emission_texel(float u, float v, float out[3])
{
	float lit = visor(u, v) * smooth(0.3f, 0.7f, noise(60.0f * v, 8.0f * u));
	out[0] = 0.1f * lit;
	out[1] = 0.6f * lit;
	out[2] = 0.9f * lit;
}

static bool write_picture(const char *name, uint32_t side, texel_function *texel)
{
	stilb_image image;
	if (stilb_image_create(&image, side, side, 3, STILB_IMAGE_U8_SRGB) != STILB_OK)
		return false;
	uint8_t *code = image.pixels;
	for (uint32_t y = 0; y < side; y++)
		for (uint32_t x = 0; x < side; x++) {
			float values[3];
			texel(((float)x + 0.5f) / (float)side, ((float)y + 0.5f) / (float)side, values);
			for (int c = 0; c < 3; c++)
				*code++ = (uint8_t)(255.0f * fminf(fmaxf(values[c], 0.0f), 1.0f) + 0.5f);
		}
	bool good = stilb_image_save(&image, name) == STILB_OK;
	stilb_image_finish(&image);
	return good;
}

/* ---- shapes ------------------------------------------------------------------------------------------------------ */

typedef struct model_shape {
	float positions[MOST][3], normals[MOST][3], uvs[MOST][2];
	uint32_t indices[6 * ACROSS * UP], vertex_count, index_count;
} model_shape;

static void helmet_place(float longitude, float latitude, float out[3])
{
	float sine = sinf(latitude), front = 0.5f + 0.5f * cosf(longitude);
	float radius = 1.0f + 0.08f * front * sine * sine + 0.04f * cosf(3.0f * latitude);
	out[0] = radius * sine * sinf(longitude) * 0.9f;
	out[1] = radius * cosf(latitude) * 1.1f;
	out[2] = radius * sine * cosf(longitude);
}

/* The unit normal, by differences. */
static void helmet_normal(float longitude, float latitude, float out[3])
{
	float step = 1e-3f;
	float a[3], b[3], c[3], d[3];
	latitude = fminf(fmaxf(latitude, 2.0f * step), PI - 2.0f * step);
	helmet_place(longitude - step, latitude, a);
	helmet_place(longitude + step, latitude, b);
	helmet_place(longitude, latitude - step, c);
	helmet_place(longitude, latitude + step, d);
	float length = 0.0f;
	for (int i = 0; i < 3; i++) {
		int j = (i + 1) % 3, k = (i + 2) % 3;
		out[i] = (d[j] - c[j]) * (b[k] - a[k]) - (d[k] - c[k]) * (b[j] - a[j]);
		length += out[i] * out[i];
	}
	for (int i = 0; i < 3; i++)
		out[i] /= sqrtf(length);
}

/* A grid around the vertical axis; column 0 is behind. The helmet's column in front stands twice, once for each half's
 * uv. */
static void make_shape(model_shape *shape, bool helmet)
{
	uint32_t across = helmet ? ACROSS : SPHERE_ACROSS, up = helmet ? UP : SPHERE_UP;
	*shape = (model_shape){0};
	for (uint32_t j = 0; j <= up; j++)
		for (uint32_t i = 0; i <= across; i++) {
			float longitude = PI * (2.0f * (float)i / (float)across - 1.0f), latitude = PI * (float)j / (float)up;
			float p[3] = {sinf(latitude) * sinf(longitude), cosf(latitude), sinf(latitude) * cosf(longitude)};
			float n[3] = {p[0], p[1], p[2]};
			if (helmet) {
				helmet_place(longitude, latitude, p);
				helmet_normal(longitude, latitude, n);
			}
			uint32_t at = shape->vertex_count++;
			memcpy(shape->positions[at], p, sizeof p);
			memcpy(shape->normals[at], n, sizeof n);
			shape->uvs[at][0] = helmet ? fabsf(longitude) / PI : (float)i / (float)across;
			shape->uvs[at][1] = (float)j / (float)up;
		}
	for (uint32_t j = 0; j < up; j++)
		for (uint32_t i = 0; i < across; i++) {
			uint32_t a = j * (across + 1) + i, c = a + across + 1;
			const uint32_t corners[6] = {a, c, a + 1, a + 1, c, c + 1};
			memcpy(shape->indices + shape->index_count, corners, sizeof corners);
			shape->index_count += 6;
		}
}

/* ---- files ------------------------------------------------------------------------------------------------------- */

/* Writes NAME.bin and NAME.gltf with one mesh; materials and nodes are JSON, without brackets. */
static bool write_model(const char *name, const model_shape *shape, const char *materials, const char *meshes,
                        const char *nodes, const char *rest, float distance)
{
	char path[64];
	uint32_t count = shape->vertex_count, bytes[4] = {12 * count, 12 * count, 8 * count, 4 * shape->index_count};
	snprintf(path, sizeof path, "%s.bin", name);
	FILE *file = fopen(path, "wb");
	if (!file)
		return false;
	fwrite(shape->positions, 1, bytes[0], file);
	fwrite(shape->normals, 1, bytes[1], file);
	fwrite(shape->uvs, 1, bytes[2], file);
	fwrite(shape->indices, 1, bytes[3], file);
	bool good = !ferror(file);
	good &= fclose(file) == 0;
	snprintf(path, sizeof path, "%s.gltf", name);
	if (!good || !(file = fopen(path, "w")))
		return false;
	uint32_t root_count = 1;
	for (const char *at = nodes; (at = strstr(at, "\"mesh\"")); at++)
		root_count++;
	fprintf(file, "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0");
	for (uint32_t i = 1; i < root_count; i++)
		fprintf(file, ",%u", i);
	fprintf(file,
	        "]}],\"nodes\":[{\"camera\":0,\"translation\":[0,0,%g]},%s],\"cameras\":[{\"type\":\"perspective\","
	        "\"perspective\":{\"yfov\":0.6,\"znear\":0.1,\"zfar\":100}}],\"materials\":[%s],\"meshes\":[%s],",
	        (double)distance, nodes, materials, meshes);
	fprintf(file,
	        "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":%u,\"type\":\"VEC3\",\"min\":[-2,-2,-2],"
	        "\"max\":[2,2,2]},{\"bufferView\":1,\"componentType\":5126,\"count\":%u,\"type\":\"VEC3\"},"
	        "{\"bufferView\":2,\"componentType\":5126,\"count\":%u,\"type\":\"VEC2\"},"
	        "{\"bufferView\":3,\"componentType\":5125,\"count\":%u,\"type\":\"SCALAR\"}],\"bufferViews\":[",
	        count, count, count, shape->index_count);
	for (uint32_t i = 0, offset = 0; i < 4; offset += bytes[i++])
		fprintf(file, "%s{\"buffer\":0,\"byteOffset\":%u,\"byteLength\":%u}", i ? "," : "", offset, bytes[i]);
	fprintf(file, "],\"buffers\":[{\"uri\":\"%s.bin\",\"byteLength\":%u}]%s}\n", name,
	        bytes[0] + bytes[1] + bytes[2] + bytes[3], rest);
	good = !ferror(file);
	return fclose(file) == 0 && good;
}

#define MESH                                                                                                           \
	"{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":1,\"TEXCOORD_0\":2},\"indices\":3,\"material\":%u}]}"

bool gltf_model_helmet(uint32_t side)
{
	static model_shape shape;
	char mesh[256];
	static const struct {
		const char *name;
		texel_function *texel;
	} pictures[] = {{"helmet-color.png", color_texel},
	                {"helmet-reflection.png", reflection_texel},
	                {"helmet-normal.png", normal_texel},
	                {"helmet-occlusion.png", occlusion_texel},
	                {"helmet-emission.png", emission_texel}};
	for (int i = 0; i < 5; i++)
		if (!write_picture(pictures[i].name, side, pictures[i].texel))
			return false;
	make_shape(&shape, true);
	snprintf(mesh, sizeof mesh, MESH, 0u);
	return write_model("helmet", &shape,
	                   "{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0},\"metallicRoughnessTexture\":{"
	                   "\"index\":1}},\"normalTexture\":{\"index\":2},\"occlusionTexture\":{\"index\":3},"
	                   "\"emissiveTexture\":{\"index\":4},\"emissiveFactor\":[1,1,1]}",
	                   mesh, "{\"mesh\":0,\"rotation\":[0.0871557,0.2588190,0,0.9619398]}",
	                   ",\"samplers\":[{\"wrapS\":33071,\"wrapT\":33071}],\"textures\":[{\"source\":0,\"sampler\":0},"
	                   "{\"source\":1,\"sampler\":0},{\"source\":2,\"sampler\":0},{\"source\":3,\"sampler\":0},"
	                   "{\"source\":4,\"sampler\":0}],"
	                   "\"images\":[{\"uri\":\"helmet-color.png\"},{\"uri\":\"helmet-reflection.png\"},"
	                   "{\"uri\":\"helmet-normal.png\"},{\"uri\":\"helmet-occlusion.png\"},"
	                   "{\"uri\":\"helmet-emission.png\"}]",
	                   4.6f);
}

/* Appends to a list in JSON. */
__attribute__((format(printf, 3, 4))) static void add(char *list, size_t size, const char *format, ...)
{
	va_list arguments;
	size_t used = strlen(list);
	if (used > 0 && used + 1 < size)
		list[used++] = ',';
	va_start(arguments, format);
	vsnprintf(list + used, size - used, format, arguments);
	va_end(arguments);
}

bool gltf_model_spheres(void)
{
	static model_shape shape;
	static char materials[8192], meshes[8192], nodes[8192];
	materials[0] = meshes[0] = nodes[0] = '\0';
	make_shape(&shape, false);
	for (unsigned i = 0; i < 49; i++) {
		double column = i % 7, row = i / 7;
		add(materials, sizeof materials,
		    "{\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.8,0.5,0.3,1],\"metallicFactor\":%.4f,"
		    "\"roughnessFactor\":%.4f}}",
		    row / 6, 0.1 + 0.15 * column);
		add(meshes, sizeof meshes, MESH, i);
		add(nodes, sizeof nodes, "{\"mesh\":%u,\"translation\":[%g,%g,0]}", i, 2.2 * (column - 3), 2.2 * (row - 3));
	}
	return write_model("spheres", &shape, materials, meshes, nodes, "", 27.0f);
}

bool gltf_model_room(const char *path, uint32_t width)
{
	stilb_image image;
	if (stilb_image_create(&image, width, width / 2, 3, STILB_IMAGE_F32_LINEAR) != STILB_OK)
		return false;
	static const float lamps[][7] = {/* direction, cosine of its radius, colour */
	                                 {0.5f, 0.6f, 0.62f, 0.93f, 9.0f, 8.5f, 8.0f},
	                                 {-0.8f, 0.3f, 0.52f, 0.9f, 2.0f, 3.0f, 5.0f},
	                                 {0.2f, 0.1f, -0.97f, 0.85f, 4.0f, 3.0f, 2.0f}};
	for (uint32_t y = 0; y < width / 2; y++)
		for (uint32_t x = 0; x < width; x++) {
			float longitude = 2.0f * PI * (((float)x + 0.5f) / (float)width - 0.5f);
			float latitude = PI * ((float)y + 0.5f) / ((float)width / 2.0f);
			float d[3] = {sinf(latitude) * sinf(longitude), cosf(latitude), -sinf(latitude) * cosf(longitude)};
			float *out = (float *)image.pixels + 3 * ((size_t)y * width + x), grey = 0.25f + 0.2f * d[1];
			for (int c = 0; c < 3; c++)
				out[c] = grey;
			for (size_t i = 0; i < sizeof lamps / sizeof *lamps; i++) {
				const float *l = lamps[i];
				float lit = smooth(l[3], l[3] + 0.03f, d[0] * l[0] + d[1] * l[1] + d[2] * l[2]);
				for (int c = 0; c < 3; c++)
					out[c] += lit * l[4 + c];
			}
		}
	bool good = stilb_image_save(&image, path) == STILB_OK;
	stilb_image_finish(&image);
	return good;
}
