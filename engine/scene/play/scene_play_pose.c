/* Vertices of posed meshes: morph targets first, then skins. Joints come to the space of their figure's place, so that a
 * figure far from the origin loses no digits. */
#include "profiler/prof.h"
#include "scene/play/scene_play_internal.h"

#include <math.h>
#include <string.h>

#define POSE_BLOCK 256u /* vertices that stay in the first cache between morph targets and skin */

/* ---- joints ------------------------------------------------------------------------------------------------------ */

/* The inverse of an affine matrix; false: it has none. */
static bool pose_invert(const stilb_mat4 *matrix, stilb_mat4 *inverse)
{
	double m[12], cofactor[3][3];
	for (int column = 0; column < 4; column++)
		for (int row = 0; row < 3; row++)
			m[3 * column + row] = (double)matrix->m[4 * column + row];
	for (int i = 0; i < 3; i++)
		for (int j = 0; j < 3; j++) {
			const double *a = &m[3 * ((i + 1) % 3)], *b = &m[3 * ((i + 2) % 3)];
			cofactor[i][j] = a[(j + 1) % 3] * b[(j + 2) % 3] - a[(j + 2) % 3] * b[(j + 1) % 3];
		}
	double determinant = m[0] * cofactor[0][0] + m[1] * cofactor[0][1] + m[2] * cofactor[0][2];
	*inverse = stilb_mat4_identity();
	if (!(fabs(determinant) > 1e-60))
		return false;
	for (int i = 0; i < 3; i++) {
		double move = 0.0;
		for (int j = 0; j < 3; j++) {
			inverse->m[4 * j + i] = (float)(cofactor[i][j] / determinant);
			move -= cofactor[i][j] / determinant * m[9 + j];
		}
		inverse->m[12 + i] = (float)move;
	}
	return true;
}

/* The sums of stilb_mat4_multiply. */
static inline void pose_multiply(const stilb_mat4 *a, const stilb_mat4 *b, stilb_mat4 *product)
{
	stilb_vec4 columns[4];
	memcpy(columns, a->m, sizeof columns);
	for (size_t i = 0; i < 4; i++) {
		const float *v = &b->m[4 * i];
		stilb_vec4 sum = ((columns[0] * v[0] + columns[1] * v[1]) + columns[2] * v[2]) + columns[3] * v[3];
		memcpy(&product->m[4 * i], &sum, sizeof sum);
	}
}

/* Brings the joints of a skin up to date. True if one of them has changed. */
static bool pose_joints(const stilb_scene *scene, play_figure *figure, const stilb_scene_skin *skin,
                        const stilb_mat4 *from_world)
{
	bool changed = false;
	for (uint32_t j = skin->first_joint; j < skin->first_joint + skin->joint_count; j++) {
		uint32_t node = figure->nodes[scene->animation->joints[j]];
		if (node == STILB_SCENE_NONE)
			continue; /* it was removed, and stays where it was */
		stilb_mat4 joint;
		pose_multiply(&scene->nodes.to_world[node], &scene->animation->inverse_binds[j], &joint);
		if (from_world)
			pose_multiply(from_world, &joint, &joint);
		if (memcmp(&joint, &figure->joints[j], sizeof joint) == 0)
			continue;
		figure->joints[j] = joint;
		changed = true;
	}
	return changed;
}

/* Finds the meshes of a figure that have another pose than they show. */
static void pose_figure(const stilb_scene *scene, play_figure *figure)
{
	const play_shared *shared = &scene->figures->shared;
	const stilb_scene_animation *animation = scene->animation;
	stilb_mat4 from_world;
	bool placed = figure->place != STILB_SCENE_NONE, known = true;
	if (placed)
		known = pose_invert(&scene->nodes.to_world[figure->place], &from_world);
	for (uint32_t s = 0; s < animation->skin_count; s++)
		figure->turned[s] = known && pose_joints(scene, figure, &animation->skins[s], placed ? &from_world : NULL);
	for (uint32_t i = 0; i < shared->posed_count; i++) {
		const play_posed *posed = &shared->posed[i];
		const stilb_scene_rest *node = &animation->nodes[posed->node];
		bool stale = posed->skin != STILB_SCENE_NONE && figure->turned[posed->skin];
		stale |= animation->deforms[posed->deform].targets > 0 &&
		         memcmp(figure->weights + node->first_weight, figure->shown_weights + node->first_weight,
		                node->weight_count * sizeof(float)) != 0;
		figure->meshes[i].stale |= stale;
	}
	memcpy(figure->shown_weights, figure->weights, animation->weight_count * sizeof(float));
}

static void pose_figures(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	stilb_scene *scene = context;
	(void)worker;
	for (uint32_t i = begin; i < end; i++)
		pose_figure(scene, &scene->figures->figures[scene->figures->due[i]]);
}

/* ---- vertices ---------------------------------------------------------------------------------------------------- */

/* Vertices of a mesh that are posed together. */
typedef struct pose_block {
	const play_rest *rest;
	const stilb_scene_deform *deform;
	const stilb_mat4 *joints; /* of the skin; NULL: it has none */
	const float *weights;     /* [targets] */
	stilb_scene_mesh *mesh;
	uint32_t first, end;
} pose_block;

static inline stilb_vec4 pose_load(const float v[3])
{
	return (stilb_vec4){v[0], v[1], v[2], 0.0f};
}

static inline void pose_store(stilb_vec4 v, float out[3])
{
	out[0] = v[0];
	out[1] = v[1];
	out[2] = v[2];
}

static inline stilb_vec4 pose_cross(stilb_vec4 a, stilb_vec4 b)
{
	stilb_vec4 next_a = __builtin_shufflevector(a, a, 1, 2, 0, 3), next_b = __builtin_shufflevector(b, b, 1, 2, 0, 3);
	stilb_vec4 turned = a * next_b - next_a * b;
	return __builtin_shufflevector(turned, turned, 1, 2, 0, 3);
}

/* v made unit; a vector without a length: `other`. */
static inline stilb_vec4 pose_unit(stilb_vec4 v, stilb_vec4 other)
{
	stilb_vec4 square = v * v;
	float length = square[0] + square[1] + square[2];
	return length > 1e-36f && length < 1e36f ? v * (1.0f / sqrtf(length)) : other;
}

/* Adds what a target changes: to + weight * delta, elements `step` floats apart in `to`. */
static inline void pose_add(float *to, size_t step, const float *delta, float weight, uint32_t count)
{
	for (uint32_t v = 0; v < count; v++)
		for (size_t i = 0; i < 3; i++)
			to[v * step + i] += weight * delta[3 * (size_t)v + i];
}

#define POSE_VERTEX (sizeof(stilb_scene_vertex) / sizeof(float))
#define POSE_EXTRA (sizeof(stilb_scene_vertex_extra) / sizeof(float))

/* The vertices at rest, changed by the morph targets, in the mesh. */
static void pose_morph(const pose_block *b)
{
	const stilb_scene_deform *deform = b->deform;
	stilb_scene_vertex *vertices = b->mesh->vertices + b->first;
	stilb_scene_vertex_extra *extras = b->rest->tangents ? b->mesh->extras + b->first : NULL;
	uint32_t count = b->end - b->first;
	memcpy(vertices, b->rest->vertices + b->first, count * sizeof *vertices);
	for (uint32_t v = 0; extras && v < count; v++)
		memcpy(extras[v].tangent, b->rest->tangents + 4 * ((size_t)b->first + v), sizeof extras[v].tangent);
	for (uint32_t t = 0; t < deform->targets; t++) {
		size_t from = 3 * ((size_t)t * b->rest->vertex_count + b->first);
		if (b->weights[t] == 0.0f)
			continue;
		pose_add(vertices->position, POSE_VERTEX, deform->positions + from, b->weights[t], count);
		if (deform->normals)
			pose_add(vertices->normal, POSE_VERTEX, deform->normals + from, b->weights[t], count);
		if (extras && deform->tangents)
			pose_add(extras->tangent, POSE_EXTRA, deform->tangents + from, b->weights[t], count);
	}
	for (uint32_t v = 0; deform->normals && v < count; v++)
		pose_store(pose_unit(pose_load(vertices[v].normal), pose_load(b->rest->vertices[b->first + v].normal)),
		           vertices[v].normal);
	for (uint32_t v = 0; extras && deform->tangents && v < count; v++)
		pose_store(pose_unit(pose_load(extras[v].tangent), pose_load(b->rest->tangents + 4 * ((size_t)b->first + v))),
		           extras[v].tangent);
}

/* The weighted sum of a vertex's joints. */
static inline void pose_blend(const play_rest *rest, const stilb_mat4 *joints, size_t vertex, stilb_vec4 sum[4])
{
	const float *weights = rest->weights + vertex * rest->influences;
	const uint16_t *indices = rest->joints + vertex * rest->influences;
	for (int c = 0; c < 4; c++)
		sum[c] = (stilb_vec4){0.0f, 0.0f, 0.0f, 0.0f};
	for (uint32_t i = 0; i < rest->influences; i++) {
		stilb_vec4 columns[4];
		if (i >= 4 && weights[i] == 0.0f)
			continue;
		memcpy(columns, joints[indices[i]].m, sizeof columns);
		for (int c = 0; c < 4; c++)
			sum[c] += weights[i] * columns[c];
	}
}

/* Carries vertices with the joints. They come from the mesh itself where morph targets have changed them. A matrix
 * that mirrors turns the direction of the bitangent round. */
static void pose_skin(const pose_block *b, bool morphed)
{
	const stilb_scene_vertex *from = morphed ? b->mesh->vertices : b->rest->vertices;
	for (uint32_t v = b->first; v < b->end; v++) {
		stilb_vec4 m[4], p = pose_load(from[v].position), n = pose_load(from[v].normal);
		pose_blend(b->rest, b->joints, v, m);
		stilb_vec4 at = m[0] * p[0] + m[1] * p[1] + m[2] * p[2] + m[3];
		stilb_vec4 x = pose_cross(m[1], m[2]), y = pose_cross(m[2], m[0]), z = pose_cross(m[0], m[1]);
		stilb_vec4 product = m[0] * x, normal = x * n[0] + y * n[1] + z * n[2];
		float side = product[0] + product[1] + product[2] < 0.0f ? -1.0f : 1.0f;
		pose_store(at, b->mesh->vertices[v].position);
		pose_store(pose_unit(normal * side, n), b->mesh->vertices[v].normal);
		if (!b->rest->tangents)
			continue;
		const float *t = morphed ? b->mesh->extras[v].tangent : b->rest->tangents + 4 * (size_t)v;
		float mirror = b->rest->tangents[4 * (size_t)v + 3] * side;
		stilb_vec4 tangent = pose_unit(m[0] * t[0] + m[1] * t[1] + m[2] * t[2], pose_load(t));
		pose_store(tangent, b->mesh->extras[v].tangent);
		b->mesh->extras[v].tangent[3] = mirror;
	}
}

/* The box of vertices, those that are usable. */
static play_box pose_box(const stilb_scene_mesh *mesh, uint32_t first, uint32_t end)
{
	stilb_vec4 low = {INFINITY, INFINITY, INFINITY, 0.0f}, high = -low;
	for (uint32_t v = first; v < end; v++) {
		stilb_vec4 p = pose_load(mesh->vertices[v].position);
		for (int i = 0; i < 3; i++) {
			low[i] = p[i] < low[i] ? p[i] : low[i];
			high[i] = p[i] > high[i] ? p[i] : high[i];
		}
	}
	play_box box;
	pose_store(low, box.low);
	pose_store(high, box.high);
	return box;
}

/* Poses a chunk of a mesh. */
static void pose_chunk(stilb_scene *scene, const play_work *work, uint32_t chunk)
{
	stilb_scene_figures *all = scene->figures;
	const play_posed *posed = &all->shared.posed[work->posed];
	play_figure *figure = &all->figures[work->figure];
	const stilb_scene_animation *animation = scene->animation;
	const stilb_scene_skin *skin = posed->skin == STILB_SCENE_NONE ? NULL : &animation->skins[posed->skin];
	pose_block block = {
		.rest = &all->shared.rests[posed->deform],
		.deform = &animation->deforms[posed->deform],
		.joints = skin ? figure->joints + skin->first_joint : NULL,
		.weights = figure->weights + animation->nodes[posed->node].first_weight,
		.mesh = &scene->meshes[figure->meshes[work->posed].mesh],
	};
	uint32_t first = (chunk - work->first_chunk) * PLAY_CHUNK, end = first + PLAY_CHUNK;
	end = end < block.rest->vertex_count ? end : block.rest->vertex_count;
	play_box *box = &all->boxes[chunk];
	*box = (play_box){{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
	for (block.first = first; block.first < end; block.first = block.end) {
		block.end = block.first + POSE_BLOCK < end ? block.first + POSE_BLOCK : end;
		bool morphs = block.deform->targets > 0;
		if (morphs)
			pose_morph(&block);
		if (skin)
			pose_skin(&block, morphs);
		play_box part = pose_box(block.mesh, block.first, block.end);
		for (int i = 0; i < 3; i++) {
			box->low[i] = part.low[i] < box->low[i] ? part.low[i] : box->low[i];
			box->high[i] = part.high[i] > box->high[i] ? part.high[i] : box->high[i];
		}
	}
}

static void pose_chunks(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	stilb_scene *scene = context;
	const play_work *work = scene->figures->work;
	uint32_t low = 0, high = scene->figures->work_count;
	(void)worker;
	while (high - low > 1) { /* the last that begins at or before `begin` */
		uint32_t middle = low + (high - low) / 2;
		if (work[middle].first_chunk <= begin)
			low = middle;
		else
			high = middle;
	}
	for (uint32_t chunk = begin; chunk < end; chunk++) {
		if (low + 1 < scene->figures->work_count && work[low + 1].first_chunk <= chunk)
			low++;
		pose_chunk(scene, &work[low], chunk);
	}
}

/* ---- all --------------------------------------------------------------------------------------------------------- */

/* Lists the figures to look at. */
static uint32_t pose_list_figures(stilb_scene_figures *all)
{
	uint32_t count = 0;
	for (uint32_t f = 0; f < all->count; f++) {
		if (all->figures[f].posing)
			all->due[count++] = f;
		all->figures[f].posing = false;
	}
	return count;
}

/* Lists the meshes to pose. Returns the number of their chunks. */
static uint32_t pose_list_meshes(stilb_scene_figures *all, uint32_t due)
{
	uint32_t chunks = 0;
	all->work_count = 0;
	for (uint32_t i = 0; i < due; i++) {
		play_figure *figure = &all->figures[all->due[i]];
		for (uint32_t p = 0; p < all->shared.posed_count; p++) {
			play_mesh *mesh = &figure->meshes[p];
			bool wanted = mesh->stale && mesh->mesh != STILB_SCENE_NONE;
			mesh->stale = false;
			if (!wanted)
				continue;
			all->work[all->work_count++] = (play_work){all->due[i], p, chunks};
			chunks += play_chunks(&all->shared.rests[all->shared.posed[p].deform]);
		}
	}
	return chunks;
}

/* Gives the meshes their spheres, and lists them and their models as changed. */
static void pose_settle(stilb_scene *scene, uint32_t chunks)
{
	stilb_scene_figures *all = scene->figures;
	for (uint32_t w = 0; w < all->work_count; w++) {
		const play_work *work = &all->work[w];
		uint32_t end = w + 1 < all->work_count ? all->work[w + 1].first_chunk : chunks;
		play_box box = all->boxes[work->first_chunk];
		for (uint32_t c = work->first_chunk + 1; c < end; c++)
			for (int i = 0; i < 3; i++) {
				box.low[i] = fminf(box.low[i], all->boxes[c].low[i]);
				box.high[i] = fmaxf(box.high[i], all->boxes[c].high[i]);
			}
		const stilb_scene_rest *node = &scene->animation->nodes[all->shared.posed[work->posed].node];
		scene_edit_mesh_posed(scene, all->figures[work->figure].meshes[work->posed].mesh, box.low, box.high,
		                      node->model_count);
	}
	for (uint32_t w = 0; w < all->work_count; w++) {
		const play_work *work = &all->work[w];
		const stilb_scene_rest *node = &scene->animation->nodes[all->shared.posed[work->posed].node];
		const play_figure *figure = &all->figures[work->figure];
		for (uint32_t m = 0; m < node->model_count; m++) {
			uint32_t model = figure->models[node->first_model - all->shared.first_model + m];
			if (model != STILB_SCENE_NONE)
				scene_edit_refit(scene, model);
		}
	}
}

void scene_play_pose(stilb_scene *scene, stilb_job_pool *pool, uint32_t worker)
{
	stilb_scene_figures *all = scene->figures;
	uint32_t due = pose_list_figures(all);
	if (due == 0)
		return;
	PROFILE("scene poses");
	if (pool && due > 1)
		stilb_job_parallel_for(pool, due, 8, pose_figures, scene, worker);
	else
		pose_figures(0, due, worker, scene);
	uint32_t chunks = pose_list_meshes(all, due);
	if (pool && chunks > 1)
		stilb_job_parallel_for(pool, chunks, 1, pose_chunks, scene, worker);
	else if (chunks > 0)
		pose_chunks(0, chunks, worker, scene);
	pose_settle(scene, chunks);
}
