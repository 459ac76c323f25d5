#include "gltf_answers.h"

#include "png_made.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>

#define PBR "\"pbrMetallicRoughness\":"
#define ROUGH ",\"metallicFactor\":0,\"roughnessFactor\":0.75"
#define BASE PBR "{\"baseColorTexture\":{\"index\":0}" ROUGH "}"
#define PLAIN PBR "{\"baseColorFactor\":[0.5,0.5,0.5,1]" ROUGH "}"
#define TRANSFORM "KHR_texture_transform"
#define UNLIT "KHR_materials_unlit"
#define GLOSS "KHR_materials_pbrSpecularGlossiness"
#define METAL PBR "{\"baseColorFactor\":[0.9,0.7,0.4,1],\"metallicFactor\":1,\"roughnessFactor\":0.45}"
#define CLEARCOAT "\"KHR_materials_clearcoat\""
#define COAT CLEARCOAT ":"
#define SHEEN "\"KHR_materials_sheen\":"
#define ANISOTROPY "\"KHR_materials_anisotropy\""
#define BRUSHED ANISOTROPY ":"
#define TRANSMISSION "\"KHR_materials_transmission\""
#define THROUGH TRANSMISSION ":"

/* Pictures: c 4 x 4 colours, C the same with 16 bits, o 7 x 3, g 4 x 4 grey, s with soft alpha, m metalness and
 * roughness, w waves of normals, k occlusion, e glow, z specular and gloss, x a file that is missing. */
const gltf_answer gltf_answers[] = {
	{.name = "base factor", .material = PBR "{\"baseColorFactor\":[0.8,0.4,0.1,1]" ROUGH "}"},
	{.name = "base texture", .material = BASE, .pictures = "c"},
	{.name = "base texture and factor",
     .material = PBR "{\"baseColorFactor\":[0.5,1,0.25,1],\"baseColorTexture\":{\"index\":0}" ROUGH "}",
     .pictures = "c"},
	{.name = "default material", .material = ""},
	{.name = "vertex colours", .material = PBR "{\"metallicFactor\":0}", .attributes = GLTF_ANSWER_COLORS},
	{.name = "vertex colours of bytes and a texture",
     .material = BASE,
     .pictures = "c",
     .attributes = GLTF_ANSWER_COLORS_U8},
	{.name = "metal",
     .material = PBR "{\"baseColorFactor\":[1,0.8,0.3,1],\"metallicFactor\":1,\"roughnessFactor\":0.5}",
     .attributes = GLTF_ANSWER_BALL},
	{.name = "half a metal",
     .material = PBR "{\"baseColorFactor\":[1,0.8,0.3,1],\"metallicFactor\":0.5,\"roughnessFactor\":0.4}"},
	{.name = "metal and roughness by texture",
     .material = PBR "{\"baseColorFactor\":[1,0.8,0.3,1],\"metallicRoughnessTexture\":{\"index\":0}}",
     .pictures = "m"},
	{.name = "smooth dielectric",
     .material = PBR "{\"metallicFactor\":0,\"roughnessFactor\":0.3}",
     .attributes = GLTF_ANSWER_BALL},
	{.name = "normal map", .material = PLAIN ",\"normalTexture\":{\"index\":0}", .pictures = "w"},
	{.name = "normal map and tangents",
     .material = PLAIN ",\"normalTexture\":{\"index\":0}",
     .pictures = "w",
     .attributes = GLTF_ANSWER_TANGENTS},
	{.name = "normal map scaled", .material = PLAIN ",\"normalTexture\":{\"index\":0,\"scale\":0.5}", .pictures = "w"},
	{.name = "normal map on mirrored uv",
     .material = PLAIN ",\"normalTexture\":{\"index\":0}",
     .pictures = "w",
     .attributes = GLTF_ANSWER_MIRRORED,
     .edges = true},
	{.name = "normal map and a negative scale",
     .material = PLAIN ",\"normalTexture\":{\"index\":0}",
     .pictures = "w",
     .node = "\"scale\":[-1,1,1]"},
	{.name = "normal map, turned",
     .material =
         PLAIN ",\"normalTexture\":{\"index\":0,\"extensions\":{\"" TRANSFORM "\":{\"rotation\":0.5,\"scale\":[2,1]}}}",
     .pictures = "w",
     .extensions = "\"" TRANSFORM "\""},
	{.name = "normal map on the second uv",
     .material = PLAIN ",\"normalTexture\":{\"index\":0,\"texCoord\":1}",
     .pictures = "w",
     .attributes = GLTF_ANSWER_UV1},
	{.name = "occlusion", .flat = true, .material = PLAIN ",\"occlusionTexture\":{\"index\":0}", .pictures = "k"},
	{.name = "emission", .material = PLAIN ",\"emissiveFactor\":[0.2,0.1,0.5]"},
	{.name = "emission by texture",
     .material = PLAIN ",\"emissiveFactor\":[1,0.5,0.5],\"emissiveTexture\":{\"index\":0}",
     .pictures = "e"},
	{.name = "strong emission",
     .material = PLAIN
     ",\"emissiveFactor\":[0.2,0.1,0.5],\"extensions\":{\"KHR_materials_emissive_strength\":{\"emissiveStrength\":5}}",
     .extensions = "\"KHR_materials_emissive_strength\""},
	{.name = "texture moved and scaled",
     .material = PBR "{\"baseColorTexture\":{\"index\":0,\"extensions\":{\"" TRANSFORM
                     "\":{\"offset\":[0.3,0.1],\"scale\":[0.5,1.5]}}}" ROUGH "}",
     .pictures = "c",
     .extensions = "\"" TRANSFORM "\""},
	{.name = "texture turned",
     .material =
         PBR "{\"baseColorTexture\":{\"index\":0,\"extensions\":{\"" TRANSFORM "\":{\"rotation\":0.7}}}" ROUGH "}",
     .pictures = "c",
     .extensions = "\"" TRANSFORM "\""},
	{.name = "second uv",
     .material = PBR "{\"baseColorTexture\":{\"index\":0,\"texCoord\":1}" ROUGH "}",
     .pictures = "c",
     .attributes = GLTF_ANSWER_UV1},
	{.name = "both uv",
     .material = BASE ",\"emissiveFactor\":[0.5,0.5,0.5],\"emissiveTexture\":{\"index\":1,\"texCoord\":1}",
     .pictures = "ce",
     .attributes = GLTF_ANSWER_UV1},
	{.name = "clamped",
     .material = PBR "{\"baseColorTexture\":{\"index\":0,\"extensions\":{\"" TRANSFORM
                     "\":{\"offset\":[-0.5,-0.5],\"scale\":[2,2]}}}" ROUGH "}",
     .pictures = "c",
     .samplers = "\"wrapS\":33071,\"wrapT\":33071",
     .extensions = "\"" TRANSFORM "\""},
	{.name = "mirrored",
     .material = PBR "{\"baseColorTexture\":{\"index\":0,\"extensions\":{\"" TRANSFORM
                     "\":{\"offset\":[-0.5,-0.5],\"scale\":[2,2]}}}" ROUGH "}",
     .pictures = "c",
     .samplers = "\"wrapS\":33648,\"wrapT\":33648",
     .extensions = "\"" TRANSFORM "\""},
	{.name = "repeated and clamped",
     .material = PBR "{\"baseColorTexture\":{\"index\":0,\"extensions\":{\"" TRANSFORM
                     "\":{\"offset\":[-0.5,-0.5],\"scale\":[2,2]}}}" ROUGH "}",
     .pictures = "c",
     .samplers = "\"wrapS\":10497,\"wrapT\":33071",
     .extensions = "\"" TRANSFORM "\""},
	{.name = "hard texels",
     .material = BASE,
     .pictures = "c",
     .samplers = "\"magFilter\":9728,\"minFilter\":9728",
     .edges = true},
	{.name = "odd sizes", .material = BASE, .pictures = "o"},
	{.name = "sixteen bits", .material = BASE, .pictures = "C"},
	{.name = "grey", .material = BASE, .pictures = "g"},
	{.name = "alpha that does not count", .material = BASE, .pictures = "s"},
	{.name = "missing file", .flat = true, .material = BASE, .pictures = "x", .says = "the material becomes magenta"},
	{.name = "mask",
     .material = BASE ",\"alphaMode\":\"MASK\"",
     .pictures = "s",
     .attributes = GLTF_ANSWER_BEHIND,
     .edges = true},
	{.name = "mask with a cutoff",
     .material = BASE ",\"alphaMode\":\"MASK\",\"alphaCutoff\":0.8",
     .pictures = "s",
     .attributes = GLTF_ANSWER_BEHIND,
     .edges = true},
	{.name = "blend",
     .chance = true,
     .material = PBR "{\"baseColorFactor\":[0.9,0.2,0.2,0.4]" ROUGH "},\"alphaMode\":\"BLEND\"",
     .attributes = GLTF_ANSWER_BEHIND},
	{.name = "blend by texture",
     .chance = true,
     .material = BASE ",\"alphaMode\":\"BLEND\"",
     .pictures = "s",
     .attributes = GLTF_ANSWER_BEHIND},
	{.name = "blend by vertex colours",
     .chance = true,
     .material = PBR "{\"metallicFactor\":0},\"alphaMode\":\"BLEND\"",
     .attributes = GLTF_ANSWER_BEHIND | GLTF_ANSWER_COLORS_U8},
	{.name = "double sided from behind",
     .material = BASE ",\"doubleSided\":true",
     .pictures = "c",
     .attributes = GLTF_ANSWER_BACK},
	{.name = "one sided from behind",
     .material = BASE,
     .pictures = "c",
     .attributes = GLTF_ANSWER_BACK | GLTF_ANSWER_BEHIND},
	{.name = "unlit",
     .material = BASE ",\"extensions\":{\"" UNLIT "\":{}}",
     .pictures = "c",
     .extensions = "\"" UNLIT "\""},
	{.name = "specular and gloss",
     .material = "\"extensions\":{\"" GLOSS
                 "\":{\"diffuseFactor\":[0.6,0.3,0.2,1],\"specularFactor\":[0.3,0.3,0.2],\"glossinessFactor\":0.6}}",
     .extensions = "\"" GLOSS "\"",
     .attributes = GLTF_ANSWER_BALL},
	{.name = "specular and gloss by texture",
     .material =
         "\"extensions\":{\"" GLOSS
         "\":{\"diffuseTexture\":{\"index\":0},\"specularGlossinessTexture\":{\"index\":1},\"glossinessFactor\":0.8}}",
     .pictures = "cz",
     .extensions = "\"" GLOSS "\""},
	{.name = "index of refraction",
     .material =
         PBR "{\"metallicFactor\":0,\"roughnessFactor\":0.4},\"extensions\":{\"KHR_materials_ior\":{\"ior\":2.2}}",
     .extensions = "\"KHR_materials_ior\"",
     .attributes = GLTF_ANSWER_BALL},
	{.name = "specular weight and tint",
     .material =
         PBR "{\"baseColorFactor\":[0.2,0.2,0.2,1],\"metallicFactor\":0,\"roughnessFactor\":0.4},\"extensions\":{\"KHR_"
             "materials_specular\":{\"specularFactor\":0.8,\"specularColorFactor\":[4,2,1]}}",
     .extensions = "\"KHR_materials_specular\"",
     .attributes = GLTF_ANSWER_BALL},
	{.name = "specular textures",
     .material =
         PBR "{\"baseColorFactor\":[0.2,0.2,0.2,1],\"metallicFactor\":0,\"roughnessFactor\":0.4},\"extensions\":{"
             "\"KHR_materials_specular\":{\"specularColorFactor\":[8,4,2],\"specularTexture\":{\"index\":0},"
             "\"specularColorTexture\":{\"index\":1}}}",
     .pictures = "zc",
     .extensions = "\"KHR_materials_specular\""},
	{.name = "anisotropy",
     .ggx = true,
     .material = METAL ",\"extensions\":{" BRUSHED "{\"anisotropyStrength\":0.7,\"anisotropyRotation\":0.5}}",
     .extensions = ANISOTROPY,
     .attributes = GLTF_ANSWER_BALL},
	{.name = "anisotropy by texture",
     .ggx = true,
     .material = METAL ",\"extensions\":{" BRUSHED "{\"anisotropyStrength\":1,\"anisotropyTexture\":{\"index\":0}}}",
     .pictures = "z",
     .extensions = ANISOTROPY},
	{.name = "clear coat",
     .material = PLAIN ",\"extensions\":{" COAT "{\"clearcoatFactor\":0.9,\"clearcoatRoughnessFactor\":0.3}}",
     .extensions = CLEARCOAT,
     .attributes = GLTF_ANSWER_BALL},
	{.name = "clear coat over emission",
     .material = PLAIN ",\"emissiveFactor\":[0.2,0.1,0.5],\"extensions\":{" COAT
                       "{\"clearcoatFactor\":1,\"clearcoatRoughnessFactor\":0.6}}",
     .extensions = CLEARCOAT,
     .attributes = GLTF_ANSWER_BALL},
	{.name = "clear coat by textures",
     .material = BASE ",\"extensions\":{" COAT
                      "{\"clearcoatFactor\":1,\"clearcoatTexture\":{\"index\":1},\"clearcoatRoughnessFactor\":0.8,"
                      "\"clearcoatRoughnessTexture\":{\"index\":2}}}",
     .pictures = "ckm",
     .extensions = CLEARCOAT},
	{.name = "clear coat that is even, on bumps",
     .material = PLAIN ",\"normalTexture\":{\"index\":0},\"extensions\":{" COAT
                       "{\"clearcoatFactor\":1,\"clearcoatRoughnessFactor\":0.5}}",
     .pictures = "w",
     .extensions = CLEARCOAT},
	{.name = "clear coat with bumps",
     .material = PLAIN ",\"extensions\":{" COAT "{\"clearcoatFactor\":1,\"clearcoatRoughnessFactor\":0.5,"
                       "\"clearcoatNormalTexture\":{\"index\":0,\"scale\":0.5}}}",
     .pictures = "w",
     .extensions = CLEARCOAT},
	{.name = "sheen",
     .material = PLAIN ",\"extensions\":{" SHEEN "{\"sheenColorFactor\":[0.9,0.5,0.2],\"sheenRoughnessFactor\":0.4}}",
     .extensions = "\"KHR_materials_sheen\"",
     .attributes = GLTF_ANSWER_BALL},
	{.name = "sheen by textures",
     .material = PBR "{\"baseColorFactor\":[0,0,0,1]" ROUGH
                     "},\"extensions\":{\"KHR_materials_specular\":{\"specularFactor\":0}," SHEEN
                     "{\"sheenColorFactor\":[1,1,1],\"sheenColorTexture\":{\"index\":0},\"sheenRoughnessFactor\":1,"
                     "\"sheenRoughnessTexture\":{\"index\":1}}}",
     .pictures = "cz",
     .extensions = "\"KHR_materials_sheen\",\"KHR_materials_specular\""},
	{.name = "clear coat, sheen and anisotropy",
     .ggx = true,
     .material = METAL ",\"extensions\":{" COAT "{\"clearcoatFactor\":0.8,\"clearcoatRoughnessFactor\":0.4}," SHEEN
                       "{\"sheenColorFactor\":[0.2,0.4,0.3],\"sheenRoughnessFactor\":0.7}," BRUSHED
                       "{\"anisotropyStrength\":0.5}}",
     .extensions = CLEARCOAT ",\"KHR_materials_sheen\"," ANISOTROPY,
     .attributes = GLTF_ANSWER_BALL},
	{.name = "pane",
     .chance = true,
     .material = PBR "{\"baseColorFactor\":[0.4,0.7,0.9,1],\"metallicFactor\":0,\"roughnessFactor\":0},"
                     "\"extensions\":{" THROUGH "{\"transmissionFactor\":0.8}}",
     .extensions = TRANSMISSION,
     .attributes = GLTF_ANSWER_BEHIND},
	{.name = "pane by texture",
     .chance = true,
     .material = PBR "{\"metallicFactor\":0,\"roughnessFactor\":0},\"extensions\":{" THROUGH
                     "{\"transmissionFactor\":0.9,\"transmissionTexture\":{\"index\":0}}}",
     .pictures = "s",
     .extensions = TRANSMISSION,
     .attributes = GLTF_ANSWER_BEHIND},
	{.name = "frosted wall",
     .material = PBR "{\"baseColorFactor\":[0.4,0.7,0.9,1],\"metallicFactor\":0.25,\"roughnessFactor\":0.5},"
                     "\"extensions\":{" THROUGH "{\"transmissionFactor\":0.8}}",
     .extensions = TRANSMISSION,
     .attributes = GLTF_ANSWER_BALL},
	{.name = "frosted wall, lit from behind",
     .material = PBR "{\"baseColorFactor\":[0.4,0.7,0.9,1],\"metallicFactor\":0,\"roughnessFactor\":0.6},"
                     "\"extensions\":{" THROUGH "{\"transmissionFactor\":0.8}," COAT "{\"clearcoatFactor\":1}}",
     .node = "\"translation\":[0.15,0.08,2],\"scale\":[0.4,0.4,1]",
     .light = "\"type\":\"point\",\"intensity\":2",
     .extensions = TRANSMISSION "," CLEARCOAT},
	{.name = "point light", .material = BASE, .pictures = "c", .light = "\"type\":\"point\",\"intensity\":8"},
	{.name = "spot light",
     .material = BASE,
     .pictures = "c",
     .light = "\"type\":\"spot\",\"intensity\":10,\"spot\":{\"innerConeAngle\":0.2,\"outerConeAngle\":0.6}"},
	{.name = "all maps",
     .material = PBR
     "{\"baseColorTexture\":{\"index\":0},\"metallicRoughnessTexture\":{\"index\":1}},\"normalTexture\":{\"index\":2},"
     "\"occlusionTexture\":{\"index\":1},\"emissiveFactor\":[0.3,0.3,0.3],\"emissiveTexture\":{\"index\":3}",
     .pictures = "cmwe"},
};
const uint32_t gltf_answer_count = sizeof gltf_answers / sizeof *gltf_answers;

/* ---- bytes ------------------------------------------------------------------------------------------------------- */

/* A file while it is made: its binary part, and JSON of views, accessors, images and textures. */
typedef struct answer_file {
	unsigned char binary[1 << 20];
	size_t size;
	char views[8192], accessors[8192], images[4096], textures[2048], attributes[1024];
	uint32_t view_count, accessor_count, image_count;
} answer_file;

__attribute__((format(printf, 2, 3))) static void add(char *list, const char *format, ...)
{
	va_list arguments;
	size_t used = strlen(list);
	if (used > 0)
		list[used++] = ',';
	va_start(arguments, format);
	vsnprintf(list + used, 2000, format, arguments);
	va_end(arguments);
}

static uint32_t add_view(answer_file *file, const void *data, size_t size)
{
	file->size = (file->size + 3) / 4 * 4;
	if (file->size + size > sizeof file->binary)
		abort();
	memcpy(file->binary + file->size, data, size);
	add(file->views, "{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu}", file->size, size);
	file->size += size;
	return file->view_count++;
}

/* type: "VEC3"; component: 5126 floats, 5121 bytes, 5125 whole numbers. */
static uint32_t add_accessor(answer_file *file, const void *data, uint32_t count, const char *type, uint32_t component)
{
	uint32_t numbers = type[0] == 'V' ? (uint32_t)(type[3] - '0') : 1u;
	uint32_t view = add_view(file, data, (size_t)count * numbers * (component == 5121 ? 1 : 4));
	add(file->accessors, "{\"bufferView\":%u,\"componentType\":%u,\"count\":%u,\"type\":\"%s\"%s}", view, component,
	    count, type, component == 5121 ? ",\"normalized\":true" : "");
	return file->accessor_count++;
}

static void add_attribute(answer_file *file, const char *name, const void *data, uint32_t count, const char *type,
                          uint32_t component)
{
	add(file->attributes, "\"%s\":%u", name, add_accessor(file, data, count, type, component));
}

/* ---- pictures ---------------------------------------------------------------------------------------------------- */

/* A number in [0, 1] for a texel and channel, always the same. */
static float texel_of(uint32_t x, uint32_t y, uint32_t channel, uint32_t seed)
{
	uint32_t h = (x * 73856093u) ^ (y * 19349663u) ^ (channel * 83492791u) ^ (seed * 2654435761u);
	h = (h ^ h >> 15) * 0x85ebca6bu;
	h = (h ^ h >> 13) * 0xc2b2ae35u;
	return (float)((h ^ h >> 16) & 0xffffu) / 65535.0f;
}

/* The texel of picture `letter`, four channels. */
static void texel(char letter, uint32_t x, uint32_t y, uint32_t side, float out[4])
{
	for (uint32_t c = 0; c < 3; c++)
		out[c] = 0.2f + 0.7f * texel_of(x, y, c, 1);
	out[3] = 1.0f;
	float u = ((float)x + 0.5f) / (float)side, v = ((float)y + 0.5f) / (float)side;
	switch (letter) {
	case 'g':
		out[0] = out[1] = out[2];
		break;
	case 's': /* smooth, so that a pixel's mean is its middle */
		for (int c = 0; c < 3; c++)
			out[c] = 0.5f + 0.3f * sinf(6.2831853f * u + (float)c) * cosf(3.1415927f * v);
		out[3] = 0.5f + 0.45f * sinf(6.2831853f * u) * cosf(6.2831853f * v);
		break;
	case 'm': /* roughness in green, metalness in blue; red is occlusion */
		out[0] = 0.5f;
		out[1] = 0.4f + 0.5f * texel_of(x, y, 1, 2);
		out[2] = texel_of(x, y, 2, 2);
		break;
	case 'k':
		out[0] = 0.3f + 0.7f * texel_of(x, y, 0, 3);
		break;
	case 'e':
		out[0] = x < side / 2 ? 0.8f : 0.0f;
		out[1] = y < side / 2 ? 0.6f : 0.0f;
		out[2] = 0.3f;
		break;
	case 'z':
		for (uint32_t c = 0; c < 3; c++)
			out[c] = 0.1f + 0.3f * texel_of(x, y, c, 4);
		out[3] = 0.4f + 0.4f * texel_of(x, y, 3, 4);
		break;
	case 'w': { /* two waves across, one down, and others if they are mirrored */
		float a = 0.5f * sinf(12.566371f * u + 0.7f), b = 0.35f * sinf(6.2831853f * v);
		float length = sqrtf(1.0f + a * a + b * b);
		out[0] = 0.5f - 0.5f * a / length;
		out[1] = 0.5f + 0.5f * b / length;
		out[2] = 0.5f + 0.5f / length;
		break;
	}
	default:
		break;
	}
}

static void add_picture(answer_file *file, char letter, bool sampler)
{
	static unsigned char pixels[64 * 64 * 8];
	uint32_t width = letter == 'o' ? 7 : letter == 'w' ? 64 : letter == 's' ? 32 : 4;
	uint32_t height = letter == 'o' ? 3 : width, depth = letter == 'C' ? 16 : 8;
	bool alpha = letter == 's' || letter == 'z';
	uint32_t channels = letter == 'g' ? 1 : alpha ? 4 : 3;
	add(file->textures, "{\"source\":%u%s}", file->image_count, sampler ? ",\"sampler\":0" : "");
	if (letter == 'x') {
		add(file->images, "{\"uri\":\"nowhere.png\"}");
		file->image_count++;
		return;
	}
	unsigned char *at = pixels;
	for (uint32_t y = 0; y < height; y++)
		for (uint32_t x = 0; x < width; x++) {
			float values[4];
			texel(letter, x, y, width, values);
			for (uint32_t c = 0; c < channels; c++) {
				uint32_t code = (uint32_t)(values[c] * (depth == 16 ? 65535.0f : 255.0f) + 0.5f);
				if (depth == 16)
					*at++ = (unsigned char)(code >> 8);
				*at++ = (unsigned char)code;
			}
		}
	png_made_bytes png = png_made(width, height,
	                              channels == 1 ? PNG_MADE_GREY
	                              : alpha       ? PNG_MADE_RGBA
	                                            : PNG_MADE_RGB,
	                              depth, pixels);
	add(file->images, "{\"bufferView\":%u,\"mimeType\":\"image/png\"}", add_view(file, png.data, png.size));
	file->image_count++;
	free(png.data);
}

/* ---- shapes ------------------------------------------------------------------------------------------------------ */

#define CARD_SIDE 2u /* squares along a side */
#define BALL_SIDE 48u
#define MOST_VERTICES ((BALL_SIDE + 1) * (BALL_SIDE + 1))

typedef struct answer_shape {
	float positions[MOST_VERTICES][3], normals[MOST_VERTICES][3], uvs[MOST_VERTICES][2];
	uint32_t indices[6 * BALL_SIDE * BALL_SIDE], vertex_count, index_count, side;
} answer_shape;

/* A grid of side x side squares: the card of side 2 in the plane z = 0, or a ball of radius 1. u to the right, v
 * down. */
static void make_shape(answer_shape *shape, bool ball)
{
	uint32_t side = ball ? BALL_SIDE : CARD_SIDE;
	*shape = (answer_shape){.side = side};
	for (uint32_t j = 0; j <= side; j++)
		for (uint32_t i = 0; i <= side; i++) {
			float u = (float)i / (float)side, v = (float)j / (float)side;
			float longitude = 6.2831853f * u, latitude = 3.1415927f * v;
			float n[3] = {0, 0, 1}, p[3] = {2 * u - 1, 1 - 2 * v, 0};
			if (ball) {
				n[0] = p[0] = sinf(latitude) * sinf(longitude);
				n[1] = p[1] = cosf(latitude);
				n[2] = p[2] = sinf(latitude) * cosf(longitude);
			}
			uint32_t at = shape->vertex_count++;
			memcpy(shape->positions[at], p, sizeof p);
			memcpy(shape->normals[at], n, sizeof n);
			shape->uvs[at][0] = u;
			shape->uvs[at][1] = v;
		}
	for (uint32_t j = 0; j < side; j++)
		for (uint32_t i = 0; i < side; i++) {
			uint32_t a = j * (side + 1) + i, c = a + side + 1;
			const uint32_t corners[6] = {a, c, a + 1, a + 1, c, c + 1};
			memcpy(shape->indices + shape->index_count, corners, sizeof corners);
			shape->index_count += 6;
		}
}

static void add_shape(answer_file *file, const answer_shape *shape, uint32_t attributes)
{
	static float second[MOST_VERTICES][2], tangents[MOST_VERTICES][4], colors[MOST_VERTICES][3], uvs[MOST_VERTICES][2];
	static uint8_t bytes[MOST_VERTICES][4];
	uint32_t count = shape->vertex_count;
	for (uint32_t v = 0; v < count; v++) {
		float a = shape->uvs[v][0], b = shape->uvs[v][1];
		uvs[v][0] = attributes & GLTF_ANSWER_MIRRORED && a > 0.5f ? 1.0f - a : a;
		uvs[v][1] = b;
		second[v][0] = b;
		second[v][1] = 1.0f - a;
		tangents[v][0] = 1.0f; /* of the card */
		tangents[v][3] = 1.0f;
		colors[v][0] = a;
		colors[v][1] = b;
		colors[v][2] = 0.5f;
		const float numbers[4] = {a, 1.0f - b, 1.0f, 0.25f + 0.5f * b};
		for (int c = 0; c < 4; c++)
			bytes[v][c] = (uint8_t)(255.0f * numbers[c] + 0.5f);
	}
	add_attribute(file, "POSITION", shape->positions, count, "VEC3", 5126);
	add_attribute(file, "NORMAL", shape->normals, count, "VEC3", 5126);
	add_attribute(file, "TEXCOORD_0", uvs, count, "VEC2", 5126);
	if (attributes & GLTF_ANSWER_UV1)
		add_attribute(file, "TEXCOORD_1", second, count, "VEC2", 5126);
	if (attributes & GLTF_ANSWER_TANGENTS)
		add_attribute(file, "TANGENT", tangents, count, "VEC4", 5126);
	if (attributes & GLTF_ANSWER_COLORS)
		add_attribute(file, "COLOR_0", colors, count, "VEC3", 5126);
	if (attributes & GLTF_ANSWER_COLORS_U8)
		add_attribute(file, "COLOR_0", bytes, count, "VEC4", 5121);
}

/* ---- files ------------------------------------------------------------------------------------------------------- */

static void put_u32(FILE *file, uint32_t value)
{
	fwrite(&value, sizeof value, 1, file);
}

static bool write_glb(const char *path, const char *json, const answer_file *made)
{
	uint32_t length = ((uint32_t)strlen(json) + 3) / 4 * 4, size = ((uint32_t)made->size + 3) / 4 * 4;
	FILE *file = fopen(path, "wb");
	if (!file)
		return false;
	put_u32(file, 0x46546c67);
	put_u32(file, 2);
	put_u32(file, 12 + 8 + length + 8 + size);
	put_u32(file, length);
	put_u32(file, 0x4e4f534a);
	fprintf(file, "%-*s", (int)length, json);
	put_u32(file, size);
	put_u32(file, 0x004e4942);
	fwrite(made->binary, 1, size, file);
	bool good = !ferror(file);
	return fclose(file) == 0 && good;
}

bool gltf_answer_write(const gltf_answer *answer, const char *path)
{
	static answer_file file;
	static answer_shape shape;
	static char json[65536];
	memset(&file, 0, sizeof file);
	make_shape(&shape, answer->attributes & GLTF_ANSWER_BALL);
	add_shape(&file, &shape, answer->attributes);
	uint32_t indices = add_accessor(&file, shape.indices, shape.index_count, "SCALAR", 5125);
	for (const char *letter = answer->pictures ? answer->pictures : ""; *letter; letter++)
		add_picture(&file, *letter, answer->samplers);
	bool behind = answer->attributes & GLTF_ANSWER_BEHIND, back = answer->attributes & GLTF_ANSWER_BACK;
	char green[512] = "";
	if (behind) /* the same card, larger, half a metre behind, turned to the camera */
		snprintf(green, sizeof green,
		         ",{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":1},\"indices\":%u,\"material\":1}]}",
		         indices);
	snprintf(json, sizeof json,
	         "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0,1,2%s]}],"
	         "\"nodes\":[{\"mesh\":0%s%s},{\"camera\":0,\"translation\":[0.2,0.1,3]},"
	         "{\"translation\":[0.5,0.8,1.5],\"rotation\":[-0.2334,0.1584,0.0386,0.9586],\"extensions\":{\"KHR_lights_"
	         "punctual\":{\"light\":0}}}%s],"
	         "\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":0.8,\"znear\":0.1,\"zfar\":100}}],"
	         "\"meshes\":[{\"primitives\":[{\"attributes\":{%s},\"indices\":%u,\"material\":0}]}%s],"
	         "\"materials\":[{%s},{" PBR "{\"baseColorFactor\":[0.1,0.6,0.2,1]" ROUGH "}}],"
	         "\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[{%s}]}},"
	         "\"extensionsUsed\":[\"KHR_lights_punctual\"%s%s],"
	         "\"accessors\":[%s],\"bufferViews\":[%s],\"buffers\":[{\"byteLength\":%zu}]",
	         behind ? ",3" : "", answer->node || back ? "," : "",
	         answer->node ? answer->node
	         : back       ? "\"rotation\":[0,1,0,0]"
	                      : "",
	         behind ? ",{\"mesh\":1,\"translation\":[0,0,-0.5],\"scale\":[1.5,1.5,1]}" : "", file.attributes, indices,
	         green, answer->material, answer->light ? answer->light : "\"type\":\"directional\",\"intensity\":2.5",
	         answer->extensions ? "," : "", answer->extensions ? answer->extensions : "", file.accessors, file.views,
	         file.size);
	if (answer->pictures)
		snprintf(json + strlen(json), sizeof json - strlen(json), ",\"textures\":[%s],\"images\":[%s]", file.textures,
		         file.images);
	if (answer->samplers)
		snprintf(json + strlen(json), sizeof json - strlen(json), ",\"samplers\":[{%s}]", answer->samplers);
	strcat(json, "}");
	return write_glb(path, json, &file);
}
