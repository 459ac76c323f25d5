/* Reading a dump: every field is checked before it is used. */
#include "render/render_dump_format.h"
#include "render/render_internal.h"
#include "shading/shade_brdf.h"
#include "shading/shade_tonemap.h"

#include <ctype.h>
#include <errno.h>
#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- layout ------------------------------------------------------------------------------------------------------ */

uint32_t render_dump_streams(const stilb_scene_streams *table)
{
	uint64_t hash = stilb_hash_fnv1a64(STILB_FNV1A64_START, &table->size, sizeof table->size);
	for (uint32_t s = 0; s < table->count; s++) {
		const stilb_scene_stream *stream = &table->streams[s];
		const uint32_t numbers[3] = {stream->kind, stream->components, stream->offset};
		hash = stilb_hash_fnv1a64(hash, stream->name, strlen(stream->name) + 1);
		hash = stilb_hash_fnv1a64(hash, numbers, sizeof numbers);
	}
	return (uint32_t)(hash ^ hash >> 32);
}

bool render_dump_layout(const render_dump_header *header, uint64_t begin[RENDER_DUMP_PARTS + 1])
{
	struct {
		uint64_t count, size;
	} parts[RENDER_DUMP_PARTS] = {
		[RENDER_DUMP_HEADER] = {1, sizeof(render_dump_header)},
		[RENDER_DUMP_VIEWS] = {header->views, sizeof(render_dump_view)},
		[RENDER_DUMP_LIGHTS] = {header->lights, sizeof(render_dump_light)},
		[RENDER_DUMP_PASSES] = {header->passes, sizeof(render_dump_pass)},
		[RENDER_DUMP_TARGETS] = {header->targets, sizeof(render_dump_target)},
		[RENDER_DUMP_TEXTURES] = {header->textures, sizeof(render_dump_texture)},
		[RENDER_DUMP_MATERIALS] = {header->materials, sizeof(render_dump_material)},
		[RENDER_DUMP_SURFACES] = {header->surfaces, sizeof(render_dump_surface)},
		[RENDER_DUMP_FUNCTIONS] = {header->functions, sizeof(render_dump_function)},
		[RENDER_DUMP_MESHES] = {header->meshes, sizeof(render_dump_mesh)},
		[RENDER_DUMP_LEVELS] = {header->levels, sizeof(render_dump_level)},
		[RENDER_DUMP_SEGMENTS] = {header->segments, sizeof(uint32_t)},
		[RENDER_DUMP_DRAWS] = {header->draws, sizeof(render_dump_draw)},
		[RENDER_DUMP_VERTICES] = {header->vertices, stilb_scene_vertex_streams.size},
		[RENDER_DUMP_EXTRAS] = {header->extras, sizeof(render_extra)},
		[RENDER_DUMP_INDICES] = {header->indices, sizeof(uint32_t)},
		[RENDER_DUMP_PIXELS] = {header->pixel_bytes, 1},
		[RENDER_DUMP_CODE] = {header->function_bytes, 1},
		[RENDER_DUMP_BACKDROPS] = {header->backdrop_bytes, 1},
		[RENDER_DUMP_CHECKSUM] = {1, sizeof(uint64_t)},
	};
	begin[0] = 0;
	for (int p = 0; p < RENDER_DUMP_PARTS; p++) {
		uint64_t bytes;
		if (__builtin_mul_overflow(parts[p].count, parts[p].size, &bytes) || bytes > UINT64_MAX - 7 ||
		    __builtin_add_overflow(begin[p], render_dump_fill(bytes), &begin[p + 1]))
			return false;
	}
	return true;
}

uint64_t render_dump_pixel_bytes(const render_dump_texture *texture)
{
	STILB_ASSERT(texture->format < STILB_IMAGE_FORMAT_COUNT);
	STILB_ASSERT(texture->width <= 16384 && texture->height <= 16384);
	render_array_kind kind = {texture->width, texture->height,
	                          render_texture_format((stilb_image_format)texture->format), texture->levels};
	return render_array_layer(&kind);
}

/* ---- the file as a whole ----------------------------------------------------------------------------------------- */

/* Returns STILB_ERROR_FILE with the message "cannot read 'NAME': FIELD AND REASON". */
static stilb_result load_refuse(const char *name, const char *format, ...) __attribute__((format(printf, 2, 3)));

static stilb_result load_refuse(const char *name, const char *format, ...)
{
	char reason[512];
	va_list arguments;
	va_start(arguments, format);
	vsnprintf(reason, sizeof reason, format, arguments);
	va_end(arguments);
	return stilb_fail(STILB_ERROR_FILE, "cannot read '%s': %s", name, reason);
}

static bool load_is_zero(const uint8_t *bytes, uint64_t begin, uint64_t end)
{
	for (; begin < end; begin++)
		if (bytes[begin] != 0)
			return false;
	return true;
}

/* Checks that it is a dump of this version with as many bytes as its header says. */
static stilb_result load_check_size(const uint8_t *bytes, size_t size, const char *name)
{
	render_dump_header header;
	uint64_t begin[RENDER_DUMP_PARTS + 1];
	size_t magic = size < sizeof header.magic ? size : sizeof header.magic;
	if (size == 0)
		return load_refuse(name, "it is empty");
	if (memcmp(bytes, RENDER_DUMP_MAGIC, magic) != 0)
		return load_refuse(name, "it is not a frame dump; 'stilb demo --dump FILE' writes one");
	if (size < sizeof header)
		return load_refuse(name, "it ends in the header, after %zu bytes", size);
	memcpy(&header, bytes, sizeof header);
	if (header.byte_order != RENDER_DUMP_BYTE_ORDER)
		return load_refuse(name, "header: byte order %08" PRIx32 ", not %08x", header.byte_order,
		                   RENDER_DUMP_BYTE_ORDER);
	if (header.version != RENDER_DUMP_VERSION)
		return load_refuse(name,
		                   "header: version %" PRIu32 ", but this program reads version %u; 'stilb demo --dump FILE' "
		                   "writes it",
		                   header.version, RENDER_DUMP_VERSION);
	if (size < header.file_size)
		return load_refuse(name, "it is truncated: %zu bytes of %" PRIu64, size, header.file_size);
	if (size > header.file_size)
		return load_refuse(name, "it continues after its last byte, %" PRIu64, header.file_size);
	if (!render_dump_layout(&header, begin) || begin[RENDER_DUMP_PARTS] != size)
		return load_refuse(name, "header: its counts do not add up to the %zu bytes of the file", size);
	return STILB_OK;
}

/* Checks the checksum and the padding between parts; load_check_size has passed. */
static stilb_result load_check_bytes(const uint8_t *bytes, const char *name)
{
	const render_dump_header *header = (const render_dump_header *)bytes;
	uint64_t begin[RENDER_DUMP_PARTS + 1], checksum;
	render_dump_layout(header, begin);
	memcpy(&checksum, bytes + begin[RENDER_DUMP_CHECKSUM], sizeof checksum);
	uint64_t found = stilb_hash_fnv1a64(STILB_FNV1A64_START, bytes, begin[RENDER_DUMP_CHECKSUM]);
	if (found != checksum)
		return load_refuse(name, "it is damaged: the checksum is %016" PRIx64 ", but %016" PRIx64 " is stored", found,
		                   checksum);
	uint64_t segments_end = begin[RENDER_DUMP_SEGMENTS] + header->segments * sizeof(uint32_t);
	if (!load_is_zero(bytes, segments_end, begin[RENDER_DUMP_DRAWS]))
		return load_refuse(name, "the bytes behind the segments are not zero");
	uint64_t indices_end = begin[RENDER_DUMP_INDICES] + header->indices * sizeof(uint32_t);
	if (!load_is_zero(bytes, indices_end, begin[RENDER_DUMP_PIXELS]))
		return load_refuse(name, "the bytes behind the indices are not zero");
	return STILB_OK;
}

/* ---- parts ------------------------------------------------------------------------------------------------------- */

static bool load_finite(const float *values, size_t count)
{
	bool finite = true;
	for (size_t i = 0; i < count; i++)
		finite &= (bool)isfinite(values[i]);
	return finite;
}

static stilb_result load_check_header(const stilb_render_dump *dump, const char *name)
{
	const render_dump_header *h = dump->header;
	if (h->width < 1 || h->width > 16384 || h->height < 1 || h->height > 16384)
		return load_refuse(name, "header: a picture of %ux%u pixels; a side has 1..16384", h->width, h->height);
	if (h->samples != 1 && h->samples != 4)
		return load_refuse(name, "header: %u samples per pixel; there are 1 or 4", h->samples);
	if (h->output > STILB_RENDER_OUTPUT_LINEAR)
		return load_refuse(name, "header: unknown output %u", h->output);
	if (h->views < 1 || h->views > RENDER_DUMP_MAX_VIEWS)
		return load_refuse(name, "header: %u views; there are 1..%u", h->views, RENDER_DUMP_MAX_VIEWS);
	if (h->passes < 1 || h->passes > RENDER_DUMP_MAX_VIEWS)
		return load_refuse(name, "header: %u passes; there are 1..%u", h->passes, RENDER_DUMP_MAX_VIEWS);
	if (h->targets > RENDER_DUMP_MAX_VIEWS)
		return load_refuse(name, "header: %u targets; there are 0..%u", h->targets, RENDER_DUMP_MAX_VIEWS);
	if (h->backdrop_bytes % 8 != 0)
		return load_refuse(name, "header: %u bytes of backgrounds, not a multiple of 8", h->backdrop_bytes);
	if (h->streams != render_dump_streams(&stilb_scene_vertex_streams))
		return load_refuse(name,
		                   "header: its vertices have other streams than this program's (%08" PRIx32 "); 'stilb "
		                   "demo --dump FILE' writes it anew",
		                   h->streams);
	if (h->draws > UINT32_MAX)
		return load_refuse(name, "header: %" PRIu64 " draws; at most %u can be recorded", h->draws, UINT32_MAX);
	return STILB_OK;
}

static bool load_lighting_is_known(uint32_t lighting)
{
	return (lighting & 0xff) < STILB_RENDER_LIGHTING_WAYS && (lighting >> 8 & 0xff) < STILB_RENDER_COVERAGE_WAYS &&
	       (lighting >> 16 & 0xff) < STILB_RENDER_GBUFFER_KINDS && lighting >> 24 < STILB_RENDER_AMBIENT_KINDS;
}

static bool load_tolerance_is_sound(const render_dump_view *view)
{
	bool none = view->light_tolerance == 0.0f;
	return view->light_tolerance >= 0.0f && view->light_tolerance <= 1.0f && isfinite(view->light_peak) &&
	       (none || view->light_peak >= 0.318f);
}

static stilb_result load_check_views(const stilb_render_dump *dump, const char *name)
{
	uint64_t lights = 0;
	for (uint32_t v = 0; v < dump->header->views; v++) {
		const render_dump_view *view = &dump->views[v];
		if (!load_finite(view->view_projection, offsetof(render_dump_view, brdf) / sizeof(float)))
			return load_refuse(name, "view %u: a number is not finite", v);
		if (!(fabsf(view->exposure) <= 100.0f))
			return load_refuse(name, "view %u: its exposure is not within 100 stops", v);
		if (view->tone >= SHADE_TONE_COUNT || view->dither >= STILB_RENDER_DITHERS)
			return load_refuse(name, "view %u: unknown tone map %u, dither %u", v, view->tone, view->dither);
		if (view->target > dump->header->targets)
			return load_refuse(name, "view %u: target %u, but there are %u", v, view->target, dump->header->targets);
		if (view->brdf >= SHADE_BRDF_COUNT || view->ndf >= SHADE_NDF_COUNT || view->g >= SHADE_G_COUNT ||
		    view->f >= SHADE_F_COUNT || view->glossy > 1 || view->both_sides > 1)
			return load_refuse(name, "view %u: unknown shading: model %u, D %u, G %u, F %u, glossy %u, both sides %u",
			                   v, view->brdf, view->ndf, view->g, view->f, view->glossy, view->both_sides);
		if (!isfinite(view->time) || !load_lighting_is_known(view->lighting))
			return load_refuse(name, "view %u: its time is not finite, or way %u of lighting unknown", v,
			                   view->lighting);
		if (!load_tolerance_is_sound(view))
			return load_refuse(name,
			                   "view %u: tolerance %g of light, peak %g; at least 0, and above 0 with a peak of 1 / pi",
			                   v, (double)view->light_tolerance, (double)view->light_peak);
		if (!(view->light_fade >= 0.0f && isfinite(view->light_fade)) ||
		    (view->light_fade > 0.0f) != (view->light_fade_height > 0) || view->light_fade_height > 16384)
			return load_refuse(name, "view %u: its lights fade at %g of %u pixels of height", v,
			                   (double)view->light_fade, view->light_fade_height);
		lights += view->lights;
	}
	if (lights != dump->header->lights)
		return load_refuse(name, "header: %u lights, but views have %" PRIu64, dump->header->lights, lights);
	return STILB_OK;
}

stilb_scene_light render_dump_light_get(const render_dump_light *from)
{
	stilb_scene_light light = {.kind = (stilb_scene_light_kind)from->kind,
	                           .cos_inner = from->cos_inner,
	                           .cos_outer = from->cos_outer,
	                           .radius = from->radius,
	                           .reach = from->reach,
	                           .unit = (stilb_scene_light_unit)from->unit,
	                           .falloff = (stilb_scene_light_falloff)from->falloff,
	                           .use = (stilb_scene_light_use)from->use};
	memcpy(light.position, from->position, sizeof from->position);
	memcpy(light.direction, from->direction, sizeof from->direction);
	memcpy(light.intensity, from->intensity, sizeof from->intensity);
	memcpy(light.half_x, from->half_x, sizeof from->half_x);
	memcpy(light.half_y, from->half_y, sizeof from->half_y);
	return light;
}

static stilb_result load_check_lights(const stilb_render_dump *dump, const char *name)
{
	for (uint32_t i = 0; i < dump->header->lights; i++) {
		const render_dump_light *from = &dump->lights[i];
		size_t floats = (sizeof *from - offsetof(render_dump_light, position)) / sizeof(float);
		if (!load_finite(from->position, floats))
			return load_refuse(name, "light %u: a number is not finite", i);
		stilb_scene_light light = render_dump_light_get(from);
		const char *mistake = stilb_scene_light_mistake(&light);
		if (mistake)
			return load_refuse(name, "light %u: %s", i, mistake);
		if (from->unused != 0)
			return load_refuse(name, "light %u: its unused bytes are not zero", i);
	}
	return STILB_OK;
}

/* True for less than `size` bytes without control characters, padded with zeros. */
static bool load_check_name(const char *name, size_t size)
{
	size_t length = strnlen(name, size);
	for (size_t i = 0; i < length; i++)
		if (iscntrl((unsigned char)name[i]))
			return false;
	for (size_t i = length; i < size; i++)
		if (name[i] != '\0')
			return false;
	return length < size;
}

static stilb_result load_check_targets(const stilb_render_dump *dump, const char *name)
{
	const render_dump_header *h = dump->header;
	for (uint32_t t = 0; t < h->targets; t++) {
		const render_dump_target *target = &dump->targets[t];
		if (!load_check_name(target->name, sizeof target->name) || target->name[0] == '\0' ||
		    strlen(target->name) > STILB_RENDER_TARGET_NAME)
			return load_refuse(name, "target %u: its name has not 1..%u bytes, or has a control character", t,
			                   STILB_RENDER_TARGET_NAME);
		for (uint32_t other = 0; other < t; other++)
			if (strcmp(dump->targets[other].name, target->name) == 0)
				return load_refuse(name, "targets %u and %u have the same name", other, t);
		if (target->width < 1 || target->width > 16384 || target->height < 1 || target->height > 16384)
			return load_refuse(name, "target %u: %ux%u pixels; a side has 1..16384", t, target->width, target->height);
		if (target->border > UINT8_MAX || target->unused != 0)
			return load_refuse(name, "target %u: a border of %u pixels, unused bytes %u; 0..255, 0", t, target->border,
			                   target->unused);
		const uint16_t *place = target->place;
		bool none = !(place[0] | place[1] | place[2] | place[3]);
		bool inside = place[2] > 0 && place[3] > 0 && place[0] + place[2] <= (int)h->width &&
		              place[1] + place[3] <= (int)h->height && target->kind == STILB_RENDER_TARGET_LIGHT;
		if (target->kind > STILB_RENDER_TARGET_DEPTH || target->output > 1 || !(none || inside))
			return load_refuse(name,
			                   "target %u: unknown kind %u, output %u, or a place outside the picture: %ux%u at %u, %u",
			                   t, target->kind, target->output, place[2], place[3], place[0], place[1]);
	}
	return STILB_OK;
}

static stilb_result load_check_passes(const stilb_render_dump *dump, const char *name)
{
	const render_dump_header *h = dump->header;
	const uint32_t *segment = dump->segments;
	uint64_t segments = 0, draws = 0;
	for (uint32_t p = 0; p < h->passes; p++) {
		const render_dump_pass *pass = &dump->passes[p];
		if (!load_check_name(pass->name, sizeof pass->name))
			return load_refuse(name, "pass %u: its name does not end with a zero, or has a control character", p);
		if (pass->view >= h->views)
			return load_refuse(name, "pass %u: view %u, but there are %u", p, pass->view, h->views);
		if (pass->sort > 1)
			return load_refuse(name, "pass %u: unknown sort %u", p, pass->sort);
		segments += pass->segments;
		if (segments > h->segments)
			return load_refuse(name, "pass %u: its %u segments go beyond all %u", p, pass->segments, h->segments);
		uint64_t sum = 0;
		for (uint32_t s = 0; s < pass->segments; s++)
			sum += *segment++;
		if (sum != pass->draws)
			return load_refuse(name, "pass %u: %" PRIu64 " draws, but its segments have %" PRIu64, p, pass->draws, sum);
		draws += sum;
	}
	if (segments != h->segments || draws != h->draws)
		return load_refuse(name,
		                   "header: %u segments and %" PRIu64 " draws, but its passes have %" PRIu64 " and %" PRIu64,
		                   h->segments, h->draws, segments, draws);
	return STILB_OK;
}

/* Checks that id is in *next .. end - 1, and moves *next behind it: ids ascend. */
static stilb_result load_check_id(const char *name, const char *kind, uint32_t place, uint32_t id, uint32_t *next,
                                  uint32_t end)
{
	if (id < *next || id >= end)
		return load_refuse(name, "%s %u: id %u, not in %u..%u", kind, place, id, *next, end - 1);
	*next = id + 1;
	return STILB_OK;
}

static stilb_result load_check_textures(const stilb_render_dump *dump, const char *name)
{
	uint64_t at = 0, bytes = dump->header->pixel_bytes;
	uint32_t next = 1; /* id 0 means no texture */
	for (uint32_t t = 0; t < dump->header->textures; t++) {
		const render_dump_texture *texture = &dump->textures[t];
		stilb_result result = load_check_id(name, "texture", t, texture->id, &next, STILB_RENDER_MAX_TEXTURES);
		if (result != STILB_OK)
			return result;
		if (texture->width < 1 || texture->width > 16384 || texture->height < 1 || texture->height > 16384 ||
		    texture->format >= STILB_IMAGE_FORMAT_COUNT || texture->format == STILB_IMAGE_U16_SRGB)
			return load_refuse(name,
			                   "texture %u: %ux%u pixels of format %u; a side has 1..16384, and formats are 0 to %d "
			                   "without 3",
			                   t, texture->width, texture->height, texture->format, STILB_IMAGE_FORMAT_COUNT - 1);
		uint32_t most = render_mip_count(texture->width, texture->height);
		if (texture->levels < 1 || texture->levels > most || texture->unused != 0)
			return load_refuse(name, "texture %u: %u mip levels (and %u); %ux%u pixels have 1 to %u", t,
			                   texture->levels, texture->unused, texture->width, texture->height, most);
		uint64_t used = render_dump_pixel_bytes(texture), filled = render_dump_fill(used);
		if (filled > bytes - at)
			return load_refuse(name, "texture %u: its pixels go beyond all %" PRIu64 " bytes of pixels", t, bytes);
		if (!load_is_zero(dump->pixels, at + used, at + filled))
			return load_refuse(name, "texture %u: the bytes behind its pixels are not zero", t);
		at += filled;
	}
	if (at != bytes)
		return load_refuse(name, "header: %" PRIu64 " bytes of pixels, but textures have %" PRIu64, bytes, at);
	return STILB_OK;
}

static stilb_result load_check_materials(const stilb_render_dump *dump, const char *name)
{
	uint32_t next = 0;
	for (uint32_t m = 0; m < dump->header->materials; m++) {
		const render_dump_material *material = &dump->materials[m];
		stilb_result result = load_check_id(name, "material", m, material->id, &next, STILB_RENDER_MAX_MATERIALS);
		if (result != STILB_OK)
			return result;
		if (material->texture > dump->header->textures)
			return load_refuse(name, "material %u: texture %u, but there are %u", m, material->texture,
			                   dump->header->textures);
		if (!load_finite(material->diffuse,
		                 (offsetof(render_dump_material, impostor) - offsetof(render_dump_material, diffuse)) /
		                     sizeof(float)))
			return load_refuse(name, "material %u: a number is not finite", m);
		if (material->impostor > 1 || (material->impostor == 1 && material->texture == 0))
			return load_refuse(name, "material %u: it is of an impostor (%u) and its texture is %u", m,
			                   material->impostor, material->texture);
	}
	return STILB_OK;
}

/* Where the next mesh's data begin, and how much of it the file has. */
typedef struct load_data {
	uint64_t vertices, indices;
	uint32_t levels;
} load_data;

/* Checks indices of mesh m or of its level l, 0: the mesh itself, behind the last: its clusters; and moves behind
 * them. */
static stilb_result load_check_indices(const stilb_render_dump *dump, const char *name, load_data *at, uint32_t m,
                                       uint32_t l, uint32_t count, uint32_t vertices)
{
	if (count > dump->header->indices - at->indices)
		return load_refuse(name, "mesh %u: its %u indices of level %u go beyond all %" PRIu64, m, count, l,
		                   dump->header->indices);
	for (uint32_t i = 0; i < count; i++)
		if (dump->indices[at->indices + i] >= vertices)
			return load_refuse(name, "mesh %u: index %u of level %u is vertex %u, but it has %u", m, i, l,
			                   dump->indices[at->indices + i], vertices);
	at->indices += count;
	return STILB_OK;
}

static stilb_result load_check_levels(const stilb_render_dump *dump, const char *name, load_data *at, uint32_t m)
{
	const render_dump_mesh *mesh = &dump->meshes[m];
	uint32_t count = render_dump_mesh_levels(mesh);
	bool morphs = mesh->levels & RENDER_DUMP_MORPHS, clusters = mesh->levels & RENDER_DUMP_CLUSTERS;
	float error = 0.0f;
	if (count > STILB_SCENE_MAX_LEVELS || count > dump->header->levels - at->levels ||
	    (morphs && (count == 0 || clusters)))
		return load_refuse(name, "mesh %u: %u levels%s%s; there are 0..%u, and %u in the file", m, count,
		                   morphs ? " that morph" : "", clusters ? " and clusters" : "", STILB_SCENE_MAX_LEVELS,
		                   dump->header->levels);
	if (mesh->clusters > 0 && !clusters)
		return load_refuse(name, "mesh %u: %u indices of clusters that it does not have", m, mesh->clusters);
	for (uint32_t l = 0; l < count; l++) {
		const render_dump_level *level = &dump->levels[at->levels++];
		if (level->indices == 0 || level->vertices > mesh->vertices || level->unused != 0 || !(level->error >= error) ||
		    !load_finite(&level->error, 1))
			return load_refuse(name, "mesh %u: level %u has %u indices, %u vertices, an error of %g, unused bytes %u",
			                   m, l + 1, level->indices, level->vertices, (double)level->error, level->unused);
		error = level->error;
		stilb_result result = load_check_indices(dump, name, at, m, l + 1, level->indices, level->vertices);
		if (result != STILB_OK)
			return result;
	}
	return load_check_indices(dump, name, at, m, count + 1, mesh->clusters, mesh->vertices);
}

static stilb_result load_check_mesh(const stilb_render_dump *dump, const char *name, load_data *at, uint32_t m)
{
	const render_dump_mesh *mesh = &dump->meshes[m];
	uint64_t vertices = mesh->levels & RENDER_DUMP_MORPHS ? 2 * (uint64_t)mesh->vertices : mesh->vertices;
	if (mesh->vertices == 0 || mesh->indices == 0)
		return load_refuse(name, "mesh %u: %u vertices, %u indices", m, mesh->vertices, mesh->indices);
	if (vertices > dump->header->vertices - at->vertices)
		return load_refuse(name, "mesh %u: its %u vertices go beyond all %" PRIu64, m, mesh->vertices,
		                   dump->header->vertices);
	if (!load_finite(dump->vertices[at->vertices].position, vertices * sizeof(stilb_scene_vertex) / sizeof(float)))
		return load_refuse(name, "mesh %u: a vertex is not finite", m);
	at->vertices += vertices;
	stilb_result result = load_check_indices(dump, name, at, m, 0, mesh->indices, mesh->vertices);
	return result == STILB_OK ? load_check_levels(dump, name, at, m) : result;
}

static stilb_result load_check_meshes(const stilb_render_dump *dump, const char *name)
{
	const render_dump_header *h = dump->header;
	load_data at = {0};
	uint32_t next = 0;
	for (uint32_t m = 0; m < h->meshes; m++) {
		stilb_result result = load_check_id(name, "mesh", m, dump->meshes[m].id, &next, STILB_RENDER_MAX_MESHES);
		if (result == STILB_OK)
			result = load_check_mesh(dump, name, &at, m);
		if (result != STILB_OK)
			return result;
	}
	if (at.vertices != h->vertices || at.indices != h->indices || at.levels != h->levels)
		return load_refuse(name,
		                   "header: %" PRIu64 " vertices, %" PRIu64 " indices and %u levels, but meshes have %" PRIu64
		                   ", %" PRIu64 " and %u",
		                   h->vertices, h->indices, h->levels, at.vertices, at.indices, at.levels);
	return STILB_OK;
}

/* True if the draw names pieces of a mesh that has clusters, or a level and no pieces. */
static bool load_draw_has_indices(const render_dump_draw *draw, const render_dump_mesh *mesh)
{
	if (render_dump_draw_level(draw) != RENDER_DUMP_SOME)
		return draw->first_index == 0 && draw->index_count == 0;
	return mesh->levels & RENDER_DUMP_CLUSTERS && draw->index_count > 0 &&
	       (uint64_t)draw->first_index + draw->index_count <= (uint64_t)mesh->indices + mesh->clusters;
}

/* True if the draw's mesh has its level, and the level what its detail needs. */
static bool load_draw_is_possible(const render_dump_draw *draw, const render_dump_mesh *mesh)
{
	uint32_t levels = render_dump_mesh_levels(mesh), level = render_dump_draw_level(draw);
	uint32_t detail = draw->mesh >> 26, kind = draw->material >> 24;
	level = level == RENDER_DUMP_SOME ? levels : level;
	switch (kind) {
	case 1: /* RENDER_STATE_FADE */
		return level <= levels && (detail & (RENDER_DETAIL_OUT - 1)) > 0;
	case 2: /* RENDER_STATE_MORPH */
		return level <= levels && (detail == 0 || (level < levels && mesh->levels & RENDER_DUMP_MORPHS));
	default:
		return level <= levels && (kind == 0 ? detail == 0 : kind < RENDER_DETAIL_KINDS);
	}
}

static stilb_result load_check_draws(const stilb_render_dump *dump, const char *name)
{
	const render_dump_header *h = dump->header;
	for (uint64_t d = 0; d < h->draws; d++) {
		const render_dump_draw *draw = &dump->draws[d];
		uint32_t mesh = render_dump_draw_mesh(draw), material = render_dump_draw_material(draw);
		if (mesh >= h->meshes || material >= h->materials)
			return load_refuse(name, "draw %" PRIu64 ": mesh %u and material %u, but there are %u and %u", d, mesh,
			                   material, h->meshes, h->materials);
		if (!load_draw_has_indices(draw, &dump->meshes[mesh]))
			return load_refuse(name, "draw %" PRIu64 ": %u indices from %u on of the clusters of mesh %u", d,
			                   draw->index_count, draw->first_index, mesh);
		if (!load_draw_is_possible(draw, &dump->meshes[mesh]))
			return load_refuse(name, "draw %" PRIu64 ": mesh %u cannot be drawn in level %u with detail %u of kind %u",
			                   d, mesh, render_dump_draw_level(draw), draw->mesh >> 26, draw->material >> 24);
		if (!load_finite(draw->transform, 12))
			return load_refuse(name, "draw %" PRIu64 ": its transform is not finite", d);
	}
	return STILB_OK;
}

static stilb_result load_check_backdrops(const stilb_render_dump *dump, const char *name)
{
	char reason[256];
	if (render_dump_check_backdrops(dump) == STILB_OK)
		return STILB_OK;
	snprintf(reason, sizeof reason, "%s", stilb_error_message());
	return load_refuse(name, "%s", reason);
}

static stilb_result load_check_surfaces(const stilb_render_dump *dump, const char *name)
{
	char reason[256];
	if (render_dump_check_functions(dump) == STILB_OK && render_dump_check_surfaces(dump) == STILB_OK)
		return STILB_OK;
	snprintf(reason, sizeof reason, "%s", stilb_error_message());
	return load_refuse(name, "%s", reason);
}

static void load_find_parts(stilb_render_dump *dump)
{
	uint64_t begin[RENDER_DUMP_PARTS + 1];
	dump->header = (const render_dump_header *)dump->bytes;
	render_dump_layout(dump->header, begin);
	dump->views = (const render_dump_view *)(dump->bytes + begin[RENDER_DUMP_VIEWS]);
	dump->lights = (const render_dump_light *)(dump->bytes + begin[RENDER_DUMP_LIGHTS]);
	dump->passes = (const render_dump_pass *)(dump->bytes + begin[RENDER_DUMP_PASSES]);
	dump->targets = (const render_dump_target *)(dump->bytes + begin[RENDER_DUMP_TARGETS]);
	dump->textures = (const render_dump_texture *)(dump->bytes + begin[RENDER_DUMP_TEXTURES]);
	dump->materials = (const render_dump_material *)(dump->bytes + begin[RENDER_DUMP_MATERIALS]);
	dump->surfaces = (const render_dump_surface *)(dump->bytes + begin[RENDER_DUMP_SURFACES]);
	dump->functions = (const render_dump_function *)(dump->bytes + begin[RENDER_DUMP_FUNCTIONS]);
	dump->code = dump->bytes + begin[RENDER_DUMP_CODE];
	dump->extras = (const render_extra *)(dump->bytes + begin[RENDER_DUMP_EXTRAS]);
	dump->meshes = (const render_dump_mesh *)(dump->bytes + begin[RENDER_DUMP_MESHES]);
	dump->levels = (const render_dump_level *)(dump->bytes + begin[RENDER_DUMP_LEVELS]);
	dump->segments = (const uint32_t *)(dump->bytes + begin[RENDER_DUMP_SEGMENTS]);
	dump->draws = (const render_dump_draw *)(dump->bytes + begin[RENDER_DUMP_DRAWS]);
	dump->vertices = (const stilb_scene_vertex *)(dump->bytes + begin[RENDER_DUMP_VERTICES]);
	dump->indices = (const uint32_t *)(dump->bytes + begin[RENDER_DUMP_INDICES]);
	dump->pixels = dump->bytes + begin[RENDER_DUMP_PIXELS];
	dump->backdrops = (const render_dump_backdrop *)(dump->bytes + begin[RENDER_DUMP_BACKDROPS]);
}

stilb_result render_dump_read(uint8_t *bytes, size_t size, const char *name, stilb_render_dump **out)
{
	stilb_result (*const checks[])(const stilb_render_dump *, const char *) = {
		load_check_header,  load_check_views,     load_check_lights,    load_check_passes,
		load_check_targets, load_check_textures,  load_check_materials, load_check_meshes,
		load_check_draws,   load_check_backdrops, load_check_surfaces,
	};
	*out = NULL;
	stilb_result result = load_check_size(bytes, size, name);
	if (result == STILB_OK)
		result = load_check_bytes(bytes, name);
	stilb_render_dump *dump = result == STILB_OK ? calloc(1, sizeof *dump) : NULL;
	if (!dump) {
		free(bytes);
		return result == STILB_OK ? stilb_fail(STILB_ERROR_MEMORY, "no memory for a frame dump") : result;
	}
	dump->bytes = bytes;
	load_find_parts(dump);
	for (size_t c = 0; c < sizeof checks / sizeof *checks && result == STILB_OK; c++)
		result = checks[c](dump, name);
	if (result == STILB_OK)
		*out = dump;
	else
		stilb_render_dump_destroy(dump);
	return result;
}

/* ---- files ------------------------------------------------------------------------------------------------------- */

/* How many bytes to read, of which `size` have been: first the header, then the size that the header gives and one
 * more. */
static uint64_t load_wanted(const uint8_t *bytes, size_t size)
{
	render_dump_header header;
	if (size < sizeof header)
		return sizeof header;
	memcpy(&header, bytes, sizeof header);
	bool foreign = memcmp(header.magic, RENDER_DUMP_MAGIC, sizeof header.magic) != 0;
	return foreign || header.file_size == UINT64_MAX ? sizeof header
	                                                 : header.file_size + 1; /* + 1: shows if the file is longer */
}

/* Reads the bytes of a dump, and one more if there is one. The buffer grows with the bytes read, so a header that
 * claims a huge file costs nothing. Returns 0 or an errno. */
static int load_stream(FILE *stream, uint8_t **bytes, size_t *size)
{
	size_t capacity = 0;
	*bytes = NULL;
	*size = 0;
	for (uint64_t wanted; *size < (wanted = load_wanted(*bytes, *size));) {
		if (*size == capacity) {
			capacity = capacity ? capacity * 2 : 65536;
			uint8_t *grown = realloc(*bytes, capacity);
			if (!grown)
				return ENOMEM;
			*bytes = grown;
		}
		STILB_ASSERT(*size < capacity);
		uint64_t left = capacity - *size, missing = wanted - *size;
		size_t step = (size_t)(left < missing ? left : missing);
		errno = 0;
		size_t read = fread(*bytes + *size, 1, step, stream);
		*size += read;
		if (read < step)
			return ferror(stream) ? (errno ? errno : EIO) : 0;
	}
	return 0;
}

stilb_result stilb_render_dump_load(const char *path, stilb_render_dump **out)
{
	STILB_ASSERT(path && out);
	uint8_t *bytes;
	size_t size;
	*out = NULL;
	bool standard = strcmp(path, "-") == 0;
	FILE *stream = standard ? stdin : fopen(path, "rb");
	if (!stream)
		return stilb_fail(STILB_ERROR_FILE, "cannot read '%s': %s", path, strerror(errno));
	int error = load_stream(stream, &bytes, &size);
	if (!standard)
		fclose(stream);
	if (error == 0)
		return render_dump_read(bytes, size, path, out);
	free(bytes);
	return stilb_fail(error == ENOMEM ? STILB_ERROR_MEMORY : STILB_ERROR_FILE, "cannot read '%s': %s", path,
	                  strerror(error));
}

void stilb_render_dump_destroy(stilb_render_dump *dump)
{
	if (!dump)
		return;
	free(dump->bytes);
	free(dump->ready);
	free(dump->first_draw);
	free(dump->light_table);
	free(dump);
}
