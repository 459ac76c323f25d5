/* Vertices of posed meshes: morph targets first, then skins. Joints are in the space of their figure's place, so that a
 * figure far from the origin loses no digits, and one that is moved as a whole is not posed again. */
#include "profiler/prof.h"
#include "scene/play/scene_play_internal.h"
#include "scene/scene_pose.h"

#include <math.h>
#include <string.h>

#define POSE_BLOCK 256u /* vertices that stay in the first cache between morph targets and skin */

/* ---- joints ------------------------------------------------------------------------------------------------------ */

/* The inverse of an affine matrix; false: it has none. */
static bool pose_invert(const stilb_mat4 *matrix, stilb_mat4 *inverse)
{
	double m[12], cofactor[3][3];
	for (size_t column = 0; column < 4; column++)
		for (size_t row = 0; row < 3; row++)
			m[3 * column + row] = (double)matrix->m[4 * column + row];
	for (size_t i = 0; i < 3; i++)
		for (size_t j = 0; j < 3; j++) {
			const double *a = &m[3 * ((i + 1) % 3)], *b = &m[3 * ((i + 2) % 3)];
			cofactor[i][j] = a[(j + 1) % 3] * b[(j + 2) % 3] - a[(j + 2) % 3] * b[(j + 1) % 3];
		}
	double determinant = m[0] * cofactor[0][0] + m[1] * cofactor[0][1] + m[2] * cofactor[0][2];
	*inverse = stilb_mat4_identity();
	if (!(fabs(determinant) > 1e-60))
		return false;
	for (size_t i = 0; i < 3; i++) {
		double move = 0.0;
		for (size_t j = 0; j < 3; j++) {
			inverse->m[4 * j + i] = (float)(cofactor[i][j] / determinant);
			move -= cofactor[i][j] / determinant * m[9 + j];
		}
		inverse->m[12 + i] = (float)move;
	}
	return true;
}

/* Brings the places of joints, and of what is above them, in the space of the figure's place up to date. They are the
 * products of the matrices below it: the same bits wherever the figure stands. A node that the program has hung
 * elsewhere comes there by way of the world; one that it has removed stays where it was. */
static void pose_places(const stilb_scene *scene, play_figure *figure)
{
	const play_shared *shared = &scene->figures->shared;
	const stilb_scene_nodes *nodes = &scene->nodes;
	for (uint32_t i = 0; i < shared->carrier_count; i++) {
		uint32_t n = shared->carriers[i], own = figure->nodes[n], above = scene->animation->nodes[n].parent;
		if (own == STILB_SCENE_NONE)
			continue;
		stilb_mat4 from_world;
		uint32_t hangs = nodes->parent[own];
		if (above == STILB_SCENE_NONE && hangs == figure->place)
			figure->places[n] = nodes->local[own];
		else if (above != STILB_SCENE_NONE && hangs == figure->nodes[above])
			scene_multiply(&figure->places[above], &nodes->local[own], &figure->places[n]);
		else if (pose_invert(&nodes->to_world[figure->place], &from_world))
			scene_multiply(&from_world, &nodes->to_world[own], &figure->places[n]);
	}
}

/* Brings the joints of a skin up to date. True if one of them has changed. */
static bool pose_joints(const stilb_scene *scene, play_figure *figure, const stilb_scene_skin *skin)
{
	bool changed = false, placed = figure->place != STILB_SCENE_NONE;
	for (uint32_t j = skin->first_joint; j < skin->first_joint + skin->joint_count; j++) {
		uint32_t n = scene->animation->joints[j], node = figure->nodes[n];
		if (node == STILB_SCENE_NONE)
			continue; /* it was removed, and stays where it was */
		stilb_mat4 joint;
		scene_multiply(placed ? &figure->places[n] : &scene->nodes.to_world[node], &scene->animation->inverse_binds[j],
		               &joint);
		play_rows rows;
		for (size_t i = 0; i < 12; i++)
			rows.m[i] = joint.m[4 * (i % 4) + i / 4];
		if (memcmp(&rows, &figure->joints[j], sizeof rows) == 0)
			continue;
		figure->joints[j] = rows;
		changed = true;
	}
	return changed;
}

/* Finds the meshes of a figure that have another pose than they show. */
static void pose_figure(const stilb_scene *scene, play_figure *figure)
{
	const play_shared *shared = &scene->figures->shared;
	const stilb_scene_animation *animation = scene->animation;
	if (figure->place != STILB_SCENE_NONE)
		pose_places(scene, figure);
	for (uint32_t s = 0; s < animation->skin_count; s++)
		figure->turned[s] = pose_joints(scene, figure, &animation->skins[s]);
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

/* Streams of vertices that morph targets have changed. */
typedef struct pose_morphed {
	float streams[PLAY_STREAMS][POSE_BLOCK];
} pose_morphed;

/* Adds what the targets change of three streams. deltas: [targets][vertices][3], from the first vertex on. */
static void pose_add(float streams[3][POSE_BLOCK], const float *deltas, const stilb_scene_deform *deform,
                     const float *weights, uint32_t vertices, uint32_t count)
{
	for (uint32_t t = 0; t < deform->targets; t++) {
		const float *delta = deltas + 3 * (size_t)t * vertices;
		float weight = weights[t];
		for (uint32_t v = 0; weight != 0.0f && v < count; v++)
			for (int i = 0; i < 3; i++)
				streams[i][v] += weight * delta[3 * (size_t)v + (size_t)i];
	}
}

/* Makes directions unit again; one without a length is what it was at rest. */
static void pose_unit(float streams[3][POSE_BLOCK], const float *rest, uint32_t stride, uint32_t count)
{
	for (uint32_t v = 0; v < count; v++) {
		float x = streams[0][v], y = streams[1][v], z = streams[2][v], square = x * x + y * y + z * z;
		bool good = square > 1e-36f && square < 1e36f;
		float scale = good ? 1.0f / sqrtf(square) : 1.0f;
		for (size_t i = 0; i < 3; i++)
			streams[i][v] = good ? streams[i][v] * scale : rest[i * stride + v];
	}
}

/* Writes count vertices from `first` on as morph targets have them, and has the skin read these. */
static void pose_morph(const play_rest *rest, const stilb_scene_deform *deform, const float *weights, uint32_t first,
                       pose_morphed *to, play_skin *skin)
{
	uint32_t streams = rest->tangents ? PLAY_STREAMS : PLAY_STREAMS_PLAIN, count = skin->count;
	size_t from = 3 * (size_t)first;
	for (uint32_t s = 0; s < streams; s++)
		memcpy(to->streams[s], play_stream(rest, s, first),
		       (size_t)((count + PLAY_LANES - 1) / PLAY_LANES) * PLAY_LANES * sizeof(float));
	pose_add(to->streams + PLAY_POSITION, deform->positions + from, deform, weights, rest->vertex_count, count);
	if (deform->normals) {
		pose_add(to->streams + PLAY_NORMAL, deform->normals + from, deform, weights, rest->vertex_count, count);
		pose_unit(to->streams + PLAY_NORMAL, play_stream(rest, PLAY_NORMAL, first), rest->stride, count);
	}
	if (rest->tangents && deform->tangents) {
		pose_add(to->streams + PLAY_TANGENT, deform->tangents + from, deform, weights, rest->vertex_count, count);
		pose_unit(to->streams + PLAY_TANGENT, play_stream(rest, PLAY_TANGENT, first), rest->stride, count);
	}
	for (int i = 0; i < 3; i++) {
		skin->position[i] = to->streams[PLAY_POSITION + i];
		skin->normal[i] = to->streams[PLAY_NORMAL + i];
	}
	for (int i = 0; rest->tangents && i < 4; i++)
		skin->tangent[i] = to->streams[PLAY_TANGENT + i];
}

/* The vertices first .. first + count - 1 of a mesh, from those at rest. */
static play_skin pose_block(const play_rest *rest, const play_rows *joints, const stilb_scene_mesh *mesh,
                            uint32_t first, uint32_t count)
{
	play_skin skin = {
		.joints = joints,
		.starts = joints ? rest->starts + first / PLAY_LANES : NULL,
		.indices = rest->joints,
		.weights = rest->weights,
		.count = count,
		.vertices = mesh->vertices + first,
		.extras = rest->tangents ? mesh->extras + first : NULL,
	};
	for (uint32_t i = 0; i < 3; i++) {
		skin.position[i] = play_stream(rest, PLAY_POSITION + i, first);
		skin.normal[i] = play_stream(rest, PLAY_NORMAL + i, first);
	}
	for (uint32_t i = 0; i < 2; i++)
		skin.uv[i] = play_stream(rest, PLAY_UV + i, first);
	for (uint32_t i = 0; rest->tangents && i < 4; i++)
		skin.tangent[i] = play_stream(rest, PLAY_TANGENT + i, first);
	return skin;
}

/* Poses a chunk of a mesh. */
static void pose_chunk(stilb_scene *scene, const play_work *work, uint32_t chunk)
{
	stilb_scene_figures *all = scene->figures;
	const play_posed *posed = &all->shared.posed[work->posed];
	play_figure *figure = &all->figures[work->figure];
	const stilb_scene_animation *animation = scene->animation;
	const stilb_scene_skin *carried = posed->skin == STILB_SCENE_NONE ? NULL : &animation->skins[posed->skin];
	const play_rows *joints = carried ? figure->joints + carried->first_joint : NULL;
	const play_rest *rest = &all->shared.rests[posed->deform];
	const stilb_scene_deform *deform = &animation->deforms[posed->deform];
	const stilb_scene_mesh *mesh = &scene->meshes[figure->meshes[work->posed].mesh];
	uint32_t first = (chunk - work->first_chunk) * PLAY_CHUNK, end = first + PLAY_CHUNK;
	end = end < rest->vertex_count ? end : rest->vertex_count;
	play_box *box = &all->boxes[chunk];
	*box = (play_box){{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
	pose_morphed morphed;
	for (uint32_t block = deform->targets > 0 ? POSE_BLOCK : PLAY_CHUNK; first < end; first += block) {
		uint32_t count = end - first < block ? end - first : block;
		play_skin skin = pose_block(rest, joints, mesh, first, count);
		if (deform->targets > 0)
			pose_morph(rest, deform, figure->weights + animation->nodes[posed->node].first_weight, first, &morphed,
			           &skin);
		all->skin(&skin);
		for (int i = 0; i < 3; i++) {
			box->low[i] = fminf(box->low[i], skin.low[i]);
			box->high[i] = fmaxf(box->high[i], skin.high[i]);
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
