/* Grading: which tables weigh where the camera stands, and what the device has of them. */
#include "post/post_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define GRADE_ROW 256u /* entries of curves in a row of the image */

/* ---- weights ----------------------------------------------------------------------------------------------------- */

/* Metres from the box's sides, below 0 inside. */
static float grade_distance(const stilb_post_area *area, const float position[3])
{
	float outside = 0.0f, inside = -INFINITY;
	for (int c = 0; c < 3; c++) {
		float away = fmaxf(area->low[c] - position[c], position[c] - area->high[c]);
		outside += fmaxf(away, 0.0f) * fmaxf(away, 0.0f);
		inside = fmaxf(inside, away);
	}
	return inside > 0.0f ? sqrtf(outside) : inside;
}

static float grade_weight(const stilb_post_area *area, const float position[3])
{
	float distance = grade_distance(area, position);
	if (area->blend == 0.0f)
		return distance <= 0.0f ? 1.0f : 0.0f;
	float share = fminf(fmaxf(0.5f - distance / area->blend, 0.0f), 1.0f);
	return share * share * (3.0f - 2.0f * share);
}

float post_grade_weights(const stilb_post_area *areas, uint32_t count, const float position[3], float *weights)
{
	float sum = 0.0f;
	for (uint32_t a = 0; a < count; a++)
		sum += weights[a] = grade_weight(&areas[a], position);
	for (uint32_t a = 0; a < count && sum > 1.0f; a++)
		weights[a] /= sum;
	return fmaxf(1.0f - sum, 0.0f);
}

/* ---- what is set ------------------------------------------------------------------------------------------------- */

static stilb_post_table *grade_copy(const stilb_post_table *from)
{
	size_t bytes =
		(from->curves ? (size_t)from->size : (size_t)from->size * from->size * from->size) * 3 * sizeof(float);
	stilb_post_table *to = malloc(sizeof *to);
	if (!to)
		return NULL;
	*to = *from;
	to->values = malloc(bytes);
	if (!to->values) {
		free(to);
		return NULL;
	}
	memcpy(to->values, from->values, bytes);
	return to;
}

static void grade_drop(post_grading *grading)
{
	for (uint32_t a = 0; a <= STILB_POST_MAX_AREAS; a++)
		stilb_post_table_destroy(grading->tables[a]);
	memset(grading->tables, 0, sizeof grading->tables);
}

static bool grade_area_is_valid(const stilb_post_area *area)
{
	bool valid = area->blend >= 0.0f && isfinite(area->blend) && fabsf(area->exposure) <= 32.0f;
	for (int c = 0; c < 3; c++)
		valid &= area->low[c] < area->high[c];
	return valid;
}

stilb_result stilb_post_set_grade(stilb_post *post, const stilb_post_table *table, const stilb_post_area *areas,
                                  uint32_t count)
{
	STILB_ASSERT(post && (areas || count == 0));
	STILB_ASSERT(count <= STILB_POST_MAX_AREAS);
	post_grading *grading = &post->grading, set = {.count = count};
	bool copied = !table || (set.tables[STILB_POST_MAX_AREAS] = grade_copy(table));
	for (uint32_t a = 0; a < count; a++) {
		STILB_ASSERT(grade_area_is_valid(&areas[a]));
		set.areas[a] = areas[a];
		copied = copied && (!areas[a].table || (set.tables[a] = grade_copy(areas[a].table)));
		set.areas[a].table = areas[a].table ? set.tables[a] : set.tables[STILB_POST_MAX_AREAS];
	}
	if (!copied) {
		grade_drop(&set);
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for tables of colours");
	}
	grade_drop(grading);
	memcpy(grading->tables, set.tables, sizeof set.tables);
	memcpy(grading->areas, set.areas, sizeof set.areas);
	grading->count = count;
	grading->known = false;
	return STILB_OK;
}

void post_grade_finish(stilb_post *post)
{
	grade_drop(&post->grading);
	stilb_gpu_image_destroy(stilb_render_gpu(post->render), post->grading.image);
	post->grading = (post_grading){0};
}

/* ---- the device's part ------------------------------------------------------------------------------------------- */

/* An image for a table; the one that there is, if it fits. */
static stilb_result grade_image(stilb_post *post, const stilb_post_table *table)
{
	post_grading *grading = &post->grading;
	uint32_t size = table->size, width = table->curves ? GRADE_ROW : size;
	uint32_t height = table->curves ? (size + GRADE_ROW - 1) / GRADE_ROW : size, depth = table->curves ? 1 : size;
	if (grading->image.id != 0 && grading->width == width && grading->height == height && grading->depth == depth)
		return STILB_OK;
	stilb_gpu *gpu = stilb_render_gpu(post->render);
	stilb_gpu_image_desc desc = {.name = "grade",
	                             .extent = {.format = STILB_GPU_RGBA32_F,
	                                        .shape = STILB_GPU_SHAPE_3D,
	                                        .width = width,
	                                        .height = height,
	                                        .depth = depth,
	                                        .layers = 1,
	                                        .mips = 1,
	                                        .samples = 1,
	                                        .uses = 1u << STILB_GPU_USE_SAMPLED | 1u << STILB_GPU_USE_COPY_TO}};
	stilb_gpu_image image;
	stilb_result result = stilb_gpu_image_create(gpu, &desc, &image);
	if (result != STILB_OK)
		return result;
	stilb_gpu_image_destroy(gpu, grading->image);
	grading->image = image;
	grading->width = width;
	grading->height = height;
	grading->depth = depth;
	return STILB_OK;
}

/* Room for an upload; where the ring is full it waits until it is not. */
static stilb_result grade_room(stilb_gpu *gpu, const stilb_gpu_upload *upload, void **bytes)
{
	stilb_result result = stilb_gpu_upload_begin(gpu, upload, bytes);
	while (result == STILB_OK && !*bytes) {
		result = stilb_gpu_upload_flush(gpu);
		if (result == STILB_OK)
			result = stilb_gpu_upload_begin(gpu, upload, bytes);
	}
	return result;
}

/* Gives the device a table, a slice at a time. */
static stilb_result grade_send(stilb_post *post, const stilb_post_table *table)
{
	post_grading *grading = &post->grading;
	stilb_gpu *gpu = stilb_render_gpu(post->render);
	stilb_result result = grade_image(post, table);
	uint32_t entries = table->curves ? table->size : table->size * table->size; /* of a slice */
	for (uint32_t z = 0; z < grading->depth && result == STILB_OK; z++) {
		uint32_t texels = grading->width * grading->height;
		stilb_gpu_upload upload = {.image = grading->image,
		                           .z = z,
		                           .width = grading->width,
		                           .height = grading->height,
		                           .depth = 1,
		                           .bytes = (uint64_t)texels * 4 * sizeof(float)};
		void *bytes;
		result = grade_room(gpu, &upload, &bytes);
		if (result != STILB_OK)
			return result;
		float *out = bytes;
		const float *in = table->values + 3 * (size_t)z * entries;
		for (uint32_t i = 0; i < texels; i++, out += 4) {
			const float *value = in + 3 * (size_t)(i < entries ? i : entries - 1);
			memcpy(out, (const float[4]){value[0], value[1], value[2], 1.0f}, 4 * sizeof *out);
		}
		stilb_gpu_upload_end(gpu, bytes);
	}
	if (result != STILB_OK)
		return result;
	grading->shown = (stilb_render_grade){.table = grading->image, .size = table->size, .curves = table->curves};
	memcpy(grading->shown.low, table->low, sizeof table->low);
	memcpy(grading->shown.high, table->high, sizeof table->high);
	return STILB_OK;
}

/* ---- where the camera stands ------------------------------------------------------------------------------------- */

/* A table, NULL: colours as they are, and what it weighs. */
typedef struct grade_part {
	const stilb_post_table *table;
	float weight;
} grade_part;

/* What weighs, each table once. */
static uint32_t grade_parts(const post_grading *grading, const float *weights, float left,
                            grade_part parts[STILB_POST_MAX_AREAS + 1])
{
	uint32_t count = 0;
	for (uint32_t a = 0; a <= grading->count; a++) {
		bool last = a == grading->count;
		grade_part part = {last ? grading->tables[STILB_POST_MAX_AREAS] : grading->areas[a].table,
		                   last ? left : weights[a]};
		uint32_t p = 0;
		while (p < count && parts[p].table != part.table)
			p++;
		if (part.weight <= 0.0f)
			continue;
		if (p == count)
			parts[count++] = part;
		else
			parts[p].weight += part.weight;
	}
	return count;
}

/* The mean of several tables; to be destroyed. */
static stilb_result grade_blend(const grade_part *parts, uint32_t count, stilb_post_table **blended)
{
	uint32_t size = 2;
	for (uint32_t p = 0; p < count; p++) {
		uint32_t needed = parts[p].table ? parts[p].table->size : 2;
		size = needed > size ? needed : size;
	}
	stilb_result result = stilb_post_table_identity(size < POST_GRADE_BLENDED ? size : POST_GRADE_BLENDED, blended);
	if (result != STILB_OK)
		return result;
	size = (*blended)->size;
	for (uint32_t i = 0; i < size * size * size; i++) {
		float *value = (*blended)->values + 3 * (size_t)i, code[3] = {value[0], value[1], value[2]}, sum[3] = {0};
		for (uint32_t p = 0; p < count; p++) {
			float shown[3] = {code[0], code[1], code[2]};
			if (parts[p].table)
				stilb_post_table_at(parts[p].table, code, shown);
			for (int c = 0; c < 3; c++)
				sum[c] += parts[p].weight * shown[c];
		}
		memcpy(value, sum, sizeof sum);
	}
	return STILB_OK;
}

/* Shows what weighs. */
static stilb_result grade_show(stilb_post *post, const grade_part *parts, uint32_t count)
{
	bool plain = count == 1 && (!parts->table || stilb_post_table_is_identity(parts->table));
	stilb_post_table *blended = NULL;
	stilb_result result = STILB_OK;
	if (count > 1)
		result = grade_blend(parts, count, &blended);
	if (result == STILB_OK && !plain)
		result = grade_send(post, blended ? blended : parts->table);
	stilb_post_table_destroy(blended);
	if (result == STILB_OK)
		post->grading.shows = !plain;
	return result;
}

stilb_result stilb_post_stand(stilb_post *post, const float position[3])
{
	STILB_ASSERT(post && position);
	post_grading *grading = &post->grading;
	float weights[STILB_POST_MAX_AREAS] = {0};
	grade_part parts[STILB_POST_MAX_AREAS + 1] = {0};
	float left = post_grade_weights(grading->areas, grading->count, position, weights);
	if (grading->known && memcmp(weights, grading->weights, sizeof weights) == 0)
		return STILB_OK;
	stilb_result result = grade_show(post, parts, grade_parts(grading, weights, left, parts));
	if (result != STILB_OK)
		return result;
	grading->known = true;
	grading->exposure = 0.0f;
	for (uint32_t a = 0; a < grading->count; a++)
		grading->exposure += weights[a] * grading->areas[a].exposure;
	memcpy(grading->weights, weights, sizeof weights);
	return STILB_OK;
}

const stilb_render_grade *stilb_post_grade(const stilb_post *post)
{
	STILB_ASSERT(post);
	return post->grading.shows ? &post->grading.shown : NULL;
}
