#include "render/render_vertex.h"

#include "base/base_contract.h"
#include "shading/shade_impostor.h"

#include <math.h>
#include <string.h>

render_layout render_layout_make(const stilb_scene_streams *table, bool packed)
{
	STILB_ASSERT(table->count >= 1 && table->count <= STILB_SCENE_MOST_STREAMS);
	render_layout layout = {.count = table->count, .from = table->size};
	for (uint32_t s = 0; s < table->count; s++) {
		const stilb_scene_stream *stream = &table->streams[s];
		bool octahedral = packed && stream->packing == STILB_SCENE_STREAM_OCTAHEDRAL;
		STILB_ASSERT(!octahedral || stream->components == 3);
		layout.attributes[s] = (render_attribute){.kind = stream->kind,
		                                          .components = stream->components,
		                                          .from = stream->offset,
		                                          .to = packed ? layout.size : stream->offset,
		                                          .octahedral = octahedral};
		layout.size += octahedral ? (uint32_t)sizeof(uint32_t) : stream->components * (uint32_t)sizeof(float);
	}
	STILB_ASSERT(packed || layout.size == table->size);
	return layout;
}

/* A number of -1..1, or one that rounding has brought beyond, in steps of 1 / most, as a two's complement number. NaN
 * becomes one, too. */
static uint32_t vertex_code(float x, float most)
{
	return (uint32_t)(int32_t)lrintf(fminf(fmaxf(x, -1.0f), 1.0f) * most);
}

/* The other way, of the `bits` bits from `shift` on. */
static float vertex_number(uint32_t code, uint32_t shift, uint32_t bits, float most)
{
	return (float)((int32_t)(code << (32 - bits - shift)) >> (32 - bits)) / most;
}

uint32_t render_direction_pack(const float n[3])
{
	stilb_vec2 e = shade_octahedral_from_direction(stilb_vec3_make(n[0], n[1], n[2]));
	return (vertex_code(e[0], 32767.0f) & 0xffffu) | vertex_code(e[1], 32767.0f) << 16;
}

static uint32_t vertex_encode(const float n[3], bool morph)
{
	if (morph)
		return (vertex_code(n[0], 1023.0f) & 0x7ffu) | (vertex_code(n[1], 1023.0f) & 0x7ffu) << 11 |
		       vertex_code(n[2], 511.0f) << 22;
	return render_direction_pack(n);
}

void render_direction_unpack(uint32_t code, float n[3])
{
	/* shade_direction_from_octahedral of 32767 times the numbers: whole ones, so that what is 0 comes out as 0,
	 * although two codes may stand for it. */
	float x = vertex_number(code, 0, 16, 1.0f), y = vertex_number(code, 16, 16, 1.0f);
	float z = 32767.0f - fabsf(x) - fabsf(y), fold = fmaxf(-z, 0.0f);
	x -= x < 0.0f ? -fold : fold;
	y -= y < 0.0f ? -fold : fold;
	float length = sqrtf(x * x + y * y + z * z);
	n[0] = x / length;
	n[1] = y / length;
	n[2] = z / length;
}

static void vertex_decode(uint32_t code, bool morph, float n[3])
{
	if (!morph) {
		render_direction_unpack(code, n);
		return;
	}
	n[0] = vertex_number(code, 0, 11, 1023.0f);
	n[1] = vertex_number(code, 11, 11, 1023.0f);
	n[2] = vertex_number(code, 22, 10, 511.0f);
}

/* Copies a stream of so many floats; a constant, so that each number has a loop of its own. */
__attribute__((always_inline)) static inline void vertex_copy(const uint8_t *from, uint32_t from_size, uint8_t *to,
                                                              uint32_t to_size, size_t count, size_t floats)
{
	for (size_t v = 0; v < count; v++, from += from_size, to += to_size)
		memcpy(to, from, floats * sizeof(float));
}

static void vertex_copy_floats(const uint8_t *from, uint32_t from_size, uint8_t *to, uint32_t to_size, size_t count,
                               uint32_t floats)
{
	if (floats == 1)
		vertex_copy(from, from_size, to, to_size, count, 1);
	else if (floats == 2)
		vertex_copy(from, from_size, to, to_size, count, 2);
	else if (floats == 3)
		vertex_copy(from, from_size, to, to_size, count, 3);
	else
		vertex_copy(from, from_size, to, to_size, count, 4);
}

static void vertex_pack_vectors(const uint8_t *from, uint32_t from_size, uint8_t *to, uint32_t to_size, size_t count,
                                bool pairs)
{
	for (size_t v = 0; v < count; v++, from += from_size, to += to_size) {
		float n[3];
		memcpy(n, from, sizeof n);
		uint32_t code = vertex_encode(n, pairs && v % 2 == 1);
		memcpy(to, &code, sizeof code);
	}
}

#define VERTEX_BLOCK 256u /* vertices, even: what is read for each stream stays in the first cache */

void render_vertices_pack(const render_layout *layout, const void *vertices, size_t count, bool pairs, void *out)
{
	if (layout->size == layout->from) {
		memcpy(out, vertices, count * layout->size);
		return;
	}
	for (size_t first = 0; first < count; first += VERTEX_BLOCK) {
		size_t block = count - first < VERTEX_BLOCK ? count - first : VERTEX_BLOCK;
		const uint8_t *from = (const uint8_t *)vertices + first * layout->from;
		uint8_t *to = (uint8_t *)out + first * layout->size;
		for (uint32_t s = 0; s < layout->count; s++) {
			const render_attribute *a = &layout->attributes[s];
			if (a->octahedral)
				vertex_pack_vectors(from + a->from, layout->from, to + a->to, layout->size, block, pairs);
			else
				vertex_copy_floats(from + a->from, layout->from, to + a->to, layout->size, block, a->components);
		}
	}
}

void render_vertices_unpack(const render_layout *layout, const void *packed, size_t count, bool pairs, void *out)
{
	if (layout->size == layout->from) {
		memcpy(out, packed, count * layout->size);
		return;
	}
	const uint8_t *from = packed;
	uint8_t *to = out;
	for (size_t v = 0; v < count; v++, from += layout->size, to += layout->from)
		for (uint32_t s = 0; s < layout->count; s++) {
			const render_attribute *a = &layout->attributes[s];
			if (a->octahedral) {
				uint32_t code;
				float values[3];
				memcpy(&code, from + a->to, sizeof code);
				vertex_decode(code, pairs && v % 2 == 1, values);
				memcpy(to + a->from, values, sizeof values);
			} else {
				memcpy(to + a->from, from + a->to, a->components * sizeof(float));
			}
		}
}
