/* glTF files that move: skins, morph targets and two clips "a" and "b" of random numbers, as a description asks for.
 * Include it in one file of a test, after glb_made.h. */
#ifndef GLB_MOVING_H
#define GLB_MOVING_H

#include "tests/scene/glb_made.h"

/* What is special in a file. */
enum {
	MOVING_STEP = 1 << 0, /* the interpolations that channels have, one of these at random */
	MOVING_LINEAR = 1 << 1,
	MOVING_CUBIC = 1 << 2,
	MOVING_MINUS = 1 << 3,     /* a rotation is nearly the last one, as -q */
	MOVING_FLAT = 1 << 4,      /* scales are 0 in one direction at some keys */
	MOVING_MIRROR = 1 << 5,    /* scales are negative in some directions */
	MOVING_TWO_SKINS = 1 << 6, /* a second node shows the mesh by another skin of the same joints */
	MOVING_OWN = 1 << 7,       /* the node that shows the skinned mesh moves, too */
	MOVING_INSTANCES = 1 << 8, /* other nodes show the meshes, too, and one of them three times */
	MOVING_SPARSE = 1 << 9,    /* morph targets are sparse accessors */
	MOVING_NORMALS = 1 << 10,  /* they change normals and tangents */
	MOVING_CHAIN = 1 << 11,    /* each joint hangs on the one before */
	MOVING_MATRIX = 1 << 12,   /* some nodes have a matrix, sheared, and stand still */
	MOVING_SHORT = 1 << 13,    /* rotations are normalised 16-bit integers, weights of vertices bytes */
};

typedef struct moving_file {
	const char *name;
	unsigned flags;
	uint32_t joints, sets, targets; /* sets: of four influences a vertex; 0: there is no skin */
	uint32_t keys;
	float first_time;        /* of the first key, at least */
	float sum_low, sum_high; /* of the weights of a vertex */
} moving_file;

#define MOVING_VERTICES 30u

static char moving_accessors[1 << 19], moving_json[1 << 20];
static uint32_t moving_views, moving_accessor_count;
static uint64_t moving_seed, moving_index;

static inline float moving_between(float low, float high)
{
	return low + (high - low) * stilb_random_float(moving_seed, moving_index++);
}

static inline uint32_t moving_below(uint32_t bound)
{
	return (uint32_t)(stilb_random_u64(moving_seed, moving_index++) % bound);
}

__attribute__((format(printf, 3, 4))) static inline void moving_say(char *text, size_t room, const char *format, ...)
{
	size_t used = strlen(text);
	va_list arguments;
	va_start(arguments, format);
	int length = vsnprintf(text + used, room - used, format, arguments);
	va_end(arguments);
	assert_true(length >= 0 && (size_t)length < room - used);
}

#define MOVING_SAY(...) moving_say(moving_json, sizeof moving_json, __VA_ARGS__)

/* Adds an accessor of these bytes; rest: further JSON of it, after a comma, or "". Returns its index. */
static inline uint32_t moving_add(const void *bytes, size_t size, uint32_t count, int type, const char *shape,
                                  const char *rest)
{
	put(bytes, size);
	moving_say(moving_accessors, sizeof moving_accessors,
	           "%s{\"bufferView\":%u,\"componentType\":%d,\"count\":%u,\"type\":\"%s\"%s}",
	           moving_accessor_count ? "," : "", moving_views++, type, count, shape, rest);
	return moving_accessor_count++;
}

static inline uint32_t moving_add_floats(const float *numbers, uint32_t count, uint32_t width)
{
	static const char *const shapes[] = {"SCALAR", "VEC2", "VEC3", "VEC4"};
	return moving_add(numbers, (size_t)count * width * sizeof *numbers, count, 5126,
	                  width == 16 ? "MAT4" : shapes[width - 1], "");
}

static inline void moving_make_unit(float *v, int count)
{
	float square = 0.0f;
	for (int i = 0; i < count; i++)
		square += v[i] * v[i];
	for (int i = 0; i < count; i++)
		v[i] /= sqrtf(square);
}

static inline void moving_random(float *v, int count, float most)
{
	for (int i = 0; i < count; i++)
		v[i] = moving_between(-most, most);
}

/* ---- meshes ------------------------------------------------------------------------------------------------------ */

static inline uint32_t moving_add_deltas(const moving_file *file, float most)
{
	float deltas[MOVING_VERTICES][3];
	moving_random(deltas[0], 3 * MOVING_VERTICES, most);
	if (!(file->flags & MOVING_SPARSE))
		return moving_add_floats(deltas[0], MOVING_VERTICES, 3);
	uint16_t places[4];
	for (uint16_t i = 0; i < 4; i++)
		places[i] = (uint16_t)(moving_below(7) + 7u * i);
	put(places, sizeof places);
	put(deltas, 4 * sizeof *deltas);
	moving_say(moving_accessors, sizeof moving_accessors,
	           "%s{\"componentType\":5126,\"count\":%u,\"type\":\"VEC3\",\"sparse\":{\"count\":4,\"indices\":{"
	           "\"bufferView\":%u,"
	           "\"componentType\":5123},\"values\":{\"bufferView\":%u}}}",
	           moving_accessor_count ? "," : "", MOVING_VERTICES, moving_views, moving_views + 1);
	moving_views += 2;
	return moving_accessor_count++;
}

/* Adds joints and weights of the vertices, and says their attributes. */
static inline void moving_add_influences(const moving_file *file)
{
	float weights[MOVING_VERTICES][32];
	for (uint32_t v = 0; v < MOVING_VERTICES; v++) {
		float sum = 0.0f, wanted = moving_between(file->sum_low, file->sum_high);
		for (uint32_t i = 0; i < 4 * file->sets; i++)
			sum += weights[v][i] = moving_below(4) == 0 ? 0.0f : moving_between(0.1f, 1.0f);
		for (uint32_t i = 0; i < 4 * file->sets; i++)
			weights[v][i] *= sum > 0.0f ? wanted / sum : 0.0f; /* now and then it has none */
	}
	for (uint32_t set = 0; set < file->sets; set++) {
		uint16_t joints[MOVING_VERTICES][4];
		float own[MOVING_VERTICES][4];
		uint8_t bytes[MOVING_VERTICES][4];
		for (uint32_t v = 0; v < MOVING_VERTICES; v++)
			for (uint32_t i = 0; i < 4; i++) {
				joints[v][i] = (uint16_t)(file->joints > 0 ? moving_below(file->joints) : 0);
				own[v][i] = weights[v][4 * set + i];
				bytes[v][i] = (uint8_t)(fminf(own[v][i], 1.0f) * 255.0f);
			}
		uint32_t j = moving_add(joints, sizeof joints, MOVING_VERTICES, 5123, "VEC4", "");
		uint32_t w = file->flags & MOVING_SHORT
		                 ? moving_add(bytes, sizeof bytes, MOVING_VERTICES, 5121, "VEC4", ",\"normalized\":true")
		                 : moving_add_floats(own[0], MOVING_VERTICES, 4);
		MOVING_SAY(",\"JOINTS_%u\":%u,\"WEIGHTS_%u\":%u", set, j, set, w);
	}
}

/* Says mesh 0, which changes its shape, and mesh 1, which does not. */
static inline void moving_add_meshes(const moving_file *file)
{
	float positions[MOVING_VERTICES][3], normals[MOVING_VERTICES][3], uvs[MOVING_VERTICES][2];
	float tangents[MOVING_VERTICES][4];
	uint16_t corners[3 * MOVING_VERTICES];
	for (uint32_t v = 0; v < MOVING_VERTICES; v++) {
		moving_random(positions[v], 3, 1.0f);
		moving_random(normals[v], 3, 1.0f);
		moving_make_unit(normals[v], 3);
		moving_random(uvs[v], 2, 1.0f);
		moving_random(tangents[v], 3, 1.0f);
		moving_make_unit(tangents[v], 3);
		tangents[v][3] = v % 2 ? 1.0f : -1.0f;
	}
	for (uint32_t i = 0; i < 3 * MOVING_VERTICES; i++)
		corners[i] = (uint16_t)(i < MOVING_VERTICES ? i : moving_below(MOVING_VERTICES));
	bool all = file->flags & MOVING_NORMALS;
	uint32_t p = moving_add_floats(positions[0], MOVING_VERTICES, 3);
	uint32_t n = moving_add_floats(normals[0], MOVING_VERTICES, 3);
	uint32_t c = moving_add(corners, sizeof corners, 3 * MOVING_VERTICES, 5123, "SCALAR", "");
	MOVING_SAY(
		"\"meshes\":[{\"primitives\":[{\"indices\":%u,\"material\":%d,\"attributes\":{\"POSITION\":%u,\"NORMAL\":%u", c,
		all, p, n);
	if (all) {
		uint32_t u = moving_add_floats(uvs[0], MOVING_VERTICES, 2),
				 t = moving_add_floats(tangents[0], MOVING_VERTICES, 4);
		MOVING_SAY(",\"TEXCOORD_0\":%u,\"TANGENT\":%u", u, t);
	}
	moving_add_influences(file);
	MOVING_SAY("}");
	for (uint32_t t = 0; t < file->targets; t++) {
		uint32_t deltas = moving_add_deltas(file, 0.5f);
		MOVING_SAY("%s{\"POSITION\":%u", t == 0 ? ",\"targets\":[" : ",", deltas);
		for (int i = 0; all && i < 2; i++)
			MOVING_SAY(",\"%s\":%u", i == 0 ? "NORMAL" : "TANGENT", moving_add_deltas(file, 0.2f));
		MOVING_SAY("}%s", t + 1 == file->targets ? "]" : "");
	}
	MOVING_SAY("}]");
	if (file->targets > 0) {
		MOVING_SAY(",\"weights\":[0.25");
		for (uint32_t t = 1; t < file->targets; t++)
			MOVING_SAY(",%g", (double)moving_between(-0.5f, 0.5f));
		MOVING_SAY("]");
	}
	MOVING_SAY("},{\"primitives\":[{\"indices\":%u,\"attributes\":{\"POSITION\":%u,\"NORMAL\":%u}}]}],", c, p, n);
	MOVING_SAY("\"materials\":[{},{\"normalTexture\":{\"index\":0}}],\"textures\":[{\"source\":0}],"
	           "\"images\":[{\"uri\":\"leaf.png\"}],");
}

/* ---- nodes and skins --------------------------------------------------------------------------------------------- */

static inline void moving_random_scale(const moving_file *file, float scale[3])
{
	for (int i = 0; i < 3; i++) {
		scale[i] = moving_between(0.8f, 1.25f);
		if (file->flags & MOVING_MIRROR && moving_below(3) == 0)
			scale[i] = -scale[i];
	}
	if (file->flags & MOVING_FLAT && moving_below(3) == 0)
		scale[moving_below(3)] = 0.0f;
}

/* A number so that reading the JSON gives this float again. */
static inline void moving_say_numbers(const char *key, const float *numbers, int count)
{
	MOVING_SAY(",\"%s\":[", key);
	for (int i = 0; i < count; i++)
		MOVING_SAY("%s%.9g", i ? "," : "", (double)numbers[i]);
	MOVING_SAY("]");
}

/* Says a node with a random pose; children: JSON after the key's comma, or "". */
static inline void moving_say_node(const moving_file *file, const char *rest, bool stands_still)
{
	float translation[3], rotation[4], scale[3];
	moving_random(translation, 3, file->flags & MOVING_CHAIN ? 0.2f : 1.0f);
	moving_random(rotation, 4, 1.0f);
	moving_make_unit(rotation, 4);
	moving_random_scale(file, scale);
	MOVING_SAY("{\"extras\":0%s", rest);
	if (stands_still) {
		MOVING_SAY(",\"matrix\":[1,0.25,0,0,-0.5,1,0,0,0.125,0,1,0,0.5,0.25,-0.5,1]");
	} else {
		moving_say_numbers("translation", translation, 3);
		moving_say_numbers("rotation", rotation, 4);
		if (!(file->flags & MOVING_CHAIN))
			moving_say_numbers("scale", scale, 3);
	}
	MOVING_SAY("}");
}

static inline bool moving_stands_still(const moving_file *file, uint32_t joint)
{
	return file->flags & MOVING_MATRIX && joint % 3 == 1;
}

/* Nodes: 0 the root, 1 .. joints, then those that show mesh 0 (one to four). Returns how many there are. */
static inline uint32_t moving_add_nodes(const moving_file *file)
{
	uint32_t joints = file->joints, first = 1 + joints, end = first + 1, second = 0;
	if (file->flags & MOVING_TWO_SKINS)
		second = end++;
	uint32_t instances = end;
	if (file->flags & MOVING_INSTANCES)
		end += 2;
	uint32_t *parent = malloc((joints + 1) * sizeof *parent), *list = malloc((end + 1) * sizeof *list);
	char rest[4096];
	for (uint32_t j = 0; j < joints; j++)
		parent[j] = file->flags & MOVING_CHAIN ? j : moving_below(j + 1); /* node numbers: 0 is the root */
	MOVING_SAY("\"scenes\":[{\"nodes\":[0]}],\"nodes\":[");
	for (uint32_t n = 0; n < end; n++) {
		uint32_t count = 0;
		for (uint32_t j = 0; n <= joints && j < joints; j++)
			if (parent[j] == n)
				list[count++] = 1 + j;
		for (uint32_t s = first; n == joints / 2 && s < end; s++)
			list[count++] = s;
		rest[0] = '\0';
		for (uint32_t i = 0; i < count; i++)
			moving_say(rest, sizeof rest, "%s%u%s", i ? "," : ",\"children\":[", list[i], i + 1 == count ? "]" : "");
		if (n >= first)
			moving_say(rest, sizeof rest, ",\"mesh\":0");
		else if (n % 2 == 1 || joints == 0)
			moving_say(rest, sizeof rest, ",\"mesh\":1");
		if (n >= first && file->sets > 0 && n != instances)
			moving_say(rest, sizeof rest, ",\"skin\":%d", n == second && second > 0);
		if (n == instances + 1) /* its own weights at rest */
			moving_say(rest, sizeof rest, ",\"weights\":[1,0.5]");
		if (n == 1 && file->flags & MOVING_INSTANCES) {
			static const float places[3][3] = {{1, 2, 3}, {-1, 0, 2}, {0, -3, 1}};
			moving_say(rest, sizeof rest,
			           ",\"extensions\":{\"EXT_mesh_gpu_instancing\":{\"attributes\":{\"TRANSLATION\":%u}}}",
			           moving_add_floats(places[0], 3, 3));
		}
		MOVING_SAY("%s", n ? "," : "");
		moving_say_node(file, rest, n >= 1 && n <= joints && moving_stands_still(file, n - 1));
	}
	MOVING_SAY("],");
	free(parent);
	free(list);
	return end;
}

static inline void moving_add_skins(const moving_file *file)
{
	float(*binds)[16] = calloc(file->joints + 1u, sizeof *binds);
	MOVING_SAY("\"skins\":[");
	for (int s = 0; s < (file->flags & MOVING_TWO_SKINS ? 2 : 1); s++) {
		for (uint32_t j = 0; j < file->joints; j++) {
			moving_random(binds[j], 12, 0.3f);
			for (int i = 0; i < 4; i++)
				binds[j][4 * i + 3] = (float)(i == 3);
			for (int i = 0; i < 3; i++)
				binds[j][5 * i] += 1.0f;
			moving_random(binds[j] + 12, 3, 0.3f);
		}
		MOVING_SAY("%s{\"joints\":[", s ? "," : "");
		for (uint32_t j = 0; j < file->joints; j++)
			MOVING_SAY("%s%u", j ? "," : "", s ? file->joints - j : 1 + j);
		MOVING_SAY("]");
		if (file->joints > 0)
			MOVING_SAY(",\"inverseBindMatrices\":%u", moving_add_floats(binds[0], file->joints, 16));
		MOVING_SAY("}");
	}
	MOVING_SAY("],");
	free(binds);
}

/* ---- clips ------------------------------------------------------------------------------------------------------- */

enum { MOVING_PATH_TRANSLATION, MOVING_PATH_ROTATION, MOVING_PATH_SCALE, MOVING_PATH_WEIGHTS };

/* A random value of a path; before: the key's before, or NULL. */
static inline void moving_value(const moving_file *file, int path, bool cubic, const float *before, float *out,
                                int width)
{
	if (path == MOVING_PATH_SCALE) {
		moving_random_scale(file, out);
		return;
	}
	moving_random(out, width, 1.0f);
	if (path != MOVING_PATH_ROTATION) {
		for (int i = 0; path == MOVING_PATH_TRANSLATION && file->flags & MOVING_CHAIN && i < 3; i++)
			out[i] *= 0.2f;
		return;
	}
	/* Splines of rotations that are far apart go through 0. */
	float near = file->flags & MOVING_MINUS ? 0.01f : 0.5f;
	for (int i = 0; before && (cubic || file->flags & MOVING_MINUS) && i < 4; i++)
		out[i] = before[i] + near * out[i];
	moving_make_unit(out, 4);
	for (int i = 0; before && file->flags & MOVING_MINUS && !cubic && i < 4; i++)
		out[i] = -out[i];
}

/* Adds a sampler, and says it. */
static inline void moving_add_sampler(const moving_file *file, int path, bool comma)
{
	static const char *const names[] = {"STEP", "LINEAR", "CUBICSPLINE"};
	int kind = (int)moving_below(3);
	while (!(file->flags & (1u << kind)))
		kind = (kind + 1) % 3;
	bool cubic = kind == 2, turns = path == MOVING_PATH_ROTATION;
	int width = turns ? 4 : path == MOVING_PATH_WEIGHTS ? (int)file->targets : 3;
	uint32_t each = cubic ? 3 : 1, keys = file->keys;
	float *times = malloc(keys * sizeof *times),
		  *values = malloc((size_t)keys * each * (uint32_t)width * sizeof *values);
	for (uint32_t k = 0; k < keys; k++) {
		times[k] = k ? times[k - 1] + moving_between(0.05f, 0.5f) : file->first_time + moving_between(0.0f, 0.3f);
		float *at = values + (size_t)k * each * (uint32_t)width, *middle = at + (cubic ? width : 0);
		moving_value(file, path, cubic, k ? middle - each * (uint32_t)width : NULL, middle, width);
		if (cubic) {
			moving_random(at, width, turns ? 0.3f : 2.0f);
			moving_random(at + 2 * width, width, turns ? 0.3f : 2.0f);
		}
	}
	uint32_t input = moving_add_floats(times, keys, 1), output;
	if (turns && file->flags & MOVING_SHORT) {
		int16_t *shorts = malloc(4 * keys * each * sizeof *shorts);
		for (uint32_t i = 0; i < 4 * keys * each; i++)
			shorts[i] = (int16_t)(values[i] * 32767.0f);
		output = moving_add(shorts, 8ull * keys * each, keys * each, 5122, "VEC4", ",\"normalized\":true");
		free(shorts);
	} else if (path == MOVING_PATH_WEIGHTS) {
		output = moving_add_floats(values, keys * each * (uint32_t)width, 1);
	} else {
		output = moving_add_floats(values, keys * each, (uint32_t)width);
	}
	MOVING_SAY("%s{\"input\":%u,\"output\":%u,\"interpolation\":\"%s\"}", comma ? "," : "", input, output, names[kind]);
	free(times);
	free(values);
}

/* True if a clip moves this of a node. Nodes of the skinned mesh move by MOVING_OWN alone. */
static inline bool moving_takes(const moving_file *file, uint32_t node, int path)
{
	bool shows = node > file->joints;
	if (path == MOVING_PATH_WEIGHTS)
		return shows && file->targets > 0;
	if (node >= 1 && node <= file->joints && moving_stands_still(file, node - 1))
		return false;
	if (shows && file->sets > 0 && !(file->flags & MOVING_OWN))
		return false;
	if (path == MOVING_PATH_SCALE && file->flags & MOVING_CHAIN)
		return false;
	return moving_below(4) != 0;
}

static inline void moving_add_clips(const moving_file *file, uint32_t nodes)
{
	static const char *const paths[] = {"translation", "rotation", "scale", "weights"};
	static bool taken[4096][4];
	MOVING_SAY("\"animations\":[");
	for (int clip = 0; clip < 2; clip++) {
		uint32_t samplers = 0, channels = 0;
		MOVING_SAY("%s{\"name\":\"%c\",\"samplers\":[", clip ? "," : "", 'a' + clip);
		for (uint32_t n = 0; n < nodes; n++)
			for (int path = 0; path < 4; path++) {
				taken[n][path] = (clip == 0 || n % 3 != 2) && moving_takes(file, n, path);
				if (taken[n][path])
					moving_add_sampler(file, path, samplers++ > 0);
			}
		MOVING_SAY("],\"channels\":[");
		for (uint32_t n = 0; n < nodes; n++)
			for (int path = 0; path < 4; path++)
				if (taken[n][path]) {
					MOVING_SAY("%s{\"sampler\":%u,\"target\":{\"node\":%u,\"path\":\"%s\"}}", channels ? "," : "",
					           channels, n, paths[path]);
					channels++;
				}
		MOVING_SAY("]}");
	}
	MOVING_SAY("],");
}

/* Writes test.glb. */
static inline void moving_write(const moving_file *file, uint64_t seed)
{
	moving_seed = seed;
	moving_index = moving_views = moving_accessor_count = 0;
	moving_json[0] = moving_accessors[0] = '\0';
	begin();
	moving_add_meshes(file);
	uint32_t nodes = moving_add_nodes(file);
	if (file->sets > 0)
		moving_add_skins(file);
	moving_add_clips(file, nodes);
	MOVING_SAY("\"accessors\":[%s]", moving_accessors);
	write_glb(moving_json);
}

#endif
