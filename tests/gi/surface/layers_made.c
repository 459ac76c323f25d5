/* layers_made FILE.glb: writes the scene of docs/gi/layers.png, balls of every layer that glTF's materials have, over a
 * checked floor between lamps: docs/gi/layers.sh renders it. */
#include <math.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#define COLUMNS 48u /* of a ball */
#define ROWS 24u
#define BALL_VERTICES ((COLUMNS + 1) * (ROWS + 1))
#define BALL_INDICES (6 * COLUMNS * ROWS)
#define TILES 24u /* of the floor, along a side */
#define FLOOR_VERTICES (4 * TILES * TILES)
#define FLOOR_INDICES (6 * TILES * TILES)

typedef struct vertex {
	float position[3], normal[3], uv[2], tangent[4];
} vertex;

/* Everything that the file's binary part has, in its order. */
static struct geometry {
	vertex ball[BALL_VERTICES];
	float floor[FLOOR_VERTICES][3], colors[FLOOR_VERTICES][3], lamp[4][3];
	uint32_t ball_indices[BALL_INDICES], floor_indices[FLOOR_INDICES], lamp_indices[6];
} geometry;

#define PLACE(member) offsetof(struct geometry, member), sizeof geometry.member

/* Balls from left to right, from the back row to the front; JSON of their materials. */
#define PBR(color, metal, rough)                                                                                       \
	"\"pbrMetallicRoughness\":{\"baseColorFactor\":[" color ",1],\"metallicFactor\":" metal                            \
	",\"roughnessFactor\":" rough "}"
#define KHR(name, members) "\"KHR_materials_" name "\":{" members "}"
#define WITH(extensions) ",\"extensions\":{" extensions "}"
#define GLASS(share) KHR("transmission", "\"transmissionFactor\":" share)
#define VOLUME(members) KHR("volume", "\"thicknessFactor\":0.45" members)

static const char *const materials[] = {
	/* lacquer on paint, on a rough metal; sheen, two roughnesses */
	PBR("0.5,0.02,0.02", "0", "0.7") WITH(KHR("clearcoat", "\"clearcoatFactor\":1")),
	PBR("0.7,0.35,0.1", "1", "0.5") WITH(KHR("clearcoat", "\"clearcoatFactor\":1,\"clearcoatRoughnessFactor\":0.15")),
	PBR("0.05,0.06,0.25", "0", "0.9")
		WITH(KHR("sheen", "\"sheenColorFactor\":[0.7,0.75,1],\"sheenRoughnessFactor\":0.35")),
	PBR("0.35,0.03,0.06", "0", "1") WITH(KHR("sheen", "\"sheenColorFactor\":[1,0.6,0.5],\"sheenRoughnessFactor\":0.8")),
	/* brushed round and up; thin walls, smooth, tinted and frosted */
	PBR("0.9,0.9,0.9", "1", "0.3") WITH(KHR("anisotropy", "\"anisotropyStrength\":0.8")),
	PBR("0.95,0.7,0.4", "1", "0.3")
		WITH(KHR("anisotropy", "\"anisotropyStrength\":0.8,\"anisotropyRotation\":1.5707963")),
	PBR("0.5,0.85,0.95", "0", "0") WITH(GLASS("1")),
	PBR("0.95,0.95,0.95", "0", "0.4") WITH(GLASS("1")),
	/* volumes: clear, rough, of amber, of a high index and a deep green */
	PBR("1,1,1", "0", "0") WITH(GLASS("1") "," VOLUME("")),
	PBR("1,1,1", "0", "0.3") WITH(GLASS("1") "," VOLUME("")),
	PBR("1,1,1", "0", "0")
		WITH(GLASS("1") "," VOLUME(",\"attenuationColor\":[0.95,0.55,0.1],\"attenuationDistance\":0.4")),
	PBR("1,1,1", "0", "0.05") WITH(GLASS("1") "," KHR("ior", "\"ior\":2") "," VOLUME(
		",\"attenuationColor\":[0.1,0.8,0.4],\"attenuationDistance\":0.5")),
};
#define MATERIALS (sizeof materials / sizeof *materials)

static void make_ball(void)
{
	uint32_t *index = geometry.ball_indices;
	for (uint32_t row = 0; row <= ROWS; row++)
		for (uint32_t column = 0; column <= COLUMNS; column++) {
			double polar = M_PI * row / ROWS, turn = 2.0 * M_PI * column / COLUMNS;
			vertex *v = &geometry.ball[row * (COLUMNS + 1) + column];
			*v = (vertex){
				.normal = {(float)(sin(polar) * sin(turn)), (float)cos(polar), (float)(sin(polar) * cos(turn))},
				.uv = {(float)column / COLUMNS, (float)row / ROWS},
				.tangent = {(float)cos(turn), 0.0f, (float)-sin(turn), 1.0f}};
			for (int i = 0; i < 3; i++)
				v->position[i] = 0.45f * v->normal[i];
		}
	for (uint32_t row = 0; row < ROWS; row++)
		for (uint32_t column = 0; column < COLUMNS; column++) {
			uint32_t a = row * (COLUMNS + 1) + column, b = a + COLUMNS + 1;
			const uint32_t corners[6] = {a, b, a + 1, a + 1, b, b + 1};
			memcpy(index, corners, sizeof corners);
			index += 6;
		}
}

static void make_floor(void)
{
	static const uint32_t order[6] = {0, 1, 2, 2, 1, 3};
	for (uint32_t tile = 0; tile < TILES * TILES; tile++) {
		uint32_t x = tile % TILES, z = tile / TILES;
		for (uint32_t corner = 0; corner < 4; corner++) {
			float *p = geometry.floor[4 * tile + corner], *color = geometry.colors[4 * tile + corner];
			p[0] = 0.5f * ((float)(x + (corner >> 1)) - 0.5f * TILES);
			p[2] = 0.5f * ((float)(z + (corner & 1)) - 0.5f * TILES);
			color[0] = color[1] = color[2] = (x + z) % 2 ? 0.65f : 0.15f;
		}
		for (int i = 0; i < 6; i++)
			geometry.floor_indices[6 * tile + (uint32_t)i] = 4 * tile + order[i];
	}
	for (uint32_t corner = 0; corner < 4; corner++) { /* facing down */
		geometry.lamp[corner][0] = corner & 1 ? 1.0f : -1.0f;
		geometry.lamp[corner][2] = corner >> 1 ? 1.0f : -1.0f;
	}
	memcpy(geometry.lamp_indices, order, sizeof order);
}

/* ---- JSON -------------------------------------------------------------------------------------------------------- */

static char json[16384];
static size_t json_size;

static void add(const char *format, ...) __attribute__((format(printf, 1, 2)));
static void add(const char *format, ...)
{
	va_list arguments;
	va_start(arguments, format);
	json_size += (size_t)vsnprintf(json + json_size, sizeof json - json_size, format, arguments);
	va_end(arguments);
}

static void add_view(size_t offset, size_t size, size_t stride)
{
	add("%s{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu", offset ? "," : "", offset, size);
	add(stride ? ",\"byteStride\":%zu}" : "}", stride);
}

static void add_accessor(int view, size_t offset, bool index, uint32_t count, int components)
{
	add("%s{\"bufferView\":%d,\"byteOffset\":%zu,\"componentType\":%d,\"count\":%u,\"type\":\"%s%c\"}",
	    view || offset ? "," : "", view, offset, index ? 5125 : 5126, count, index ? "SCALA" : "VEC",
	    index ? 'R' : '0' + components);
}

static void add_geometry(void)
{
	add("\"bufferViews\":[");
	add_view(PLACE(ball), sizeof(vertex));
	add_view(PLACE(floor), 0);
	add_view(PLACE(colors), 0);
	add_view(PLACE(lamp), 0);
	add_view(PLACE(ball_indices), 0);
	add_view(PLACE(floor_indices), 0);
	add_view(PLACE(lamp_indices), 0);
	add("],\"accessors\":[");
	add_accessor(0, offsetof(vertex, position), false, BALL_VERTICES, 3);
	add_accessor(0, offsetof(vertex, normal), false, BALL_VERTICES, 3);
	add_accessor(0, offsetof(vertex, uv), false, BALL_VERTICES, 2);
	add_accessor(0, offsetof(vertex, tangent), false, BALL_VERTICES, 4);
	add_accessor(1, 0, false, FLOOR_VERTICES, 3);
	add_accessor(2, 0, false, FLOOR_VERTICES, 3);
	add_accessor(3, 0, false, 4, 3);
	add_accessor(4, 0, true, BALL_INDICES, 0);
	add_accessor(5, 0, true, FLOOR_INDICES, 0);
	add_accessor(6, 0, true, 6, 0);
	add("],");
}

static void add_scene(void)
{
	add("\"materials\":[");
	for (size_t i = 0; i < MATERIALS; i++)
		add("{%s},", materials[i]);
	add("{" PBR("1,1,1", "0", "1") "},{" PBR("0,0,0", "0", "1") ",\"emissiveFactor\":[1,1,1]" WITH(
		KHR("emissive_strength", "\"emissiveStrength\":12")) "}],\"meshes\":[");
	for (size_t i = 0; i < MATERIALS; i++)
		add("{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":1,\"TEXCOORD_0\":2,\"TANGENT\":3},\"indices\":"
		    "7,"
		    "\"material\":%zu}]},",
		    i);
	add("{\"primitives\":[{\"attributes\":{\"POSITION\":4,\"COLOR_0\":5},\"indices\":8,\"material\":%zu}]},",
	    MATERIALS);
	add("{\"primitives\":[{\"attributes\":{\"POSITION\":6},\"indices\":9,\"material\":%zu}]}],\"nodes\":[",
	    MATERIALS + 1);
	for (size_t i = 0; i < MATERIALS; i++)
		add("{\"mesh\":%zu,\"translation\":[%g,0.45,%g]},", i, 1.1 * ((double)(i % 4) - 1.5),
		    1.3 * ((double)(i / 4) - 1.0));
	add("{\"mesh\":%zu},{\"mesh\":%zu,\"translation\":[-3,4,1]},", MATERIALS, MATERIALS + 1);
	add("{\"mesh\":%zu,\"translation\":[3.5,3,-1],\"rotation\":[0,0,-0.35,0.937],\"scale\":[0.5,1,1.5]},",
	    MATERIALS + 1);
	/* looks down by 0.4 rad */
	add("{\"camera\":0,\"translation\":[0,3.3,6.2],\"rotation\":[-0.2156,0,0,0.9765]}],");
	add("\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":0.5,\"znear\":0.1}}],\"scenes\":[{\"nodes\":"
	    "[");
	for (size_t i = 0; i < MATERIALS + 4; i++)
		add("%s%zu", i ? "," : "", i);
	add("]}],\"extensionsUsed\":[\"KHR_materials_clearcoat\",\"KHR_materials_sheen\",\"KHR_materials_anisotropy\","
	    "\"KHR_materials_transmission\",\"KHR_materials_volume\",\"KHR_materials_ior\","
	    "\"KHR_materials_emissive_strength\"]");
}

static void write_u32(FILE *file, uint32_t value)
{
	fwrite(&value, sizeof value, 1, file);
}

int main(int argc, char **argv)
{
	FILE *file = argc == 2 ? fopen(argv[1], "wb") : NULL;
	if (!file) {
		fprintf(stderr, "layers_made FILE.glb: needs a file that can be written\n");
		return 2;
	}
	make_ball();
	make_floor();
	add("{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":%zu}],", sizeof geometry);
	add_geometry();
	add_scene();
	add("}");
	while (json_size % 4)
		add(" ");
	fputs("glTF", file);
	write_u32(file, 2);
	write_u32(file, (uint32_t)(12 + 8 + json_size + 8 + sizeof geometry));
	write_u32(file, (uint32_t)json_size);
	write_u32(file, 0x4E4F534A);
	fwrite(json, 1, json_size, file);
	write_u32(file, sizeof geometry);
	write_u32(file, 0x004E4942);
	fwrite(&geometry, sizeof geometry, 1, file);
	return fclose(file) == 0 ? 0 : 1;
}
