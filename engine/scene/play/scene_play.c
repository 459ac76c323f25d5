/* Figures come and go, and what they play. */
#include "scene/play/scene_play.h"

#include "scene/edit/scene_node.h"
#include "scene/play/scene_play_internal.h"
#include "scene/scene_animation_internal.h"
#include "scene/scene_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static stilb_result play_memory(void)
{
	return stilb_fail(STILB_ERROR_MEMORY, "no memory for another figure");
}

static play_figure *play_find(const stilb_scene *scene, uint32_t figure)
{
	stilb_scene_figures *all = scene->figures;
	return all && figure < all->count && all->figures[figure].next == EDIT_IN_USE ? &all->figures[figure] : NULL;
}

static stilb_result play_check(stilb_scene *scene, uint32_t figure, play_figure **found)
{
	STILB_ASSERT(scene && found);
	*found = play_find(scene, figure);
	if (*found)
		return STILB_OK;
	if (!scene->figures)
		return stilb_fail(STILB_ERROR_ARGUMENT, "there is no figure %u: nothing of the scene moves", figure);
	return stilb_fail(STILB_ERROR_ARGUMENT, "there is no figure %u", figure);
}

/* ---- room -------------------------------------------------------------------------------------------------------- */

/* A figure of nothing yet, with the weights that the file has. */
static stilb_result play_make(const stilb_scene *scene, play_figure *figure)
{
	const stilb_scene_animation *a = scene->animation;
	const play_shared *shared = &scene->figures->shared;
	*figure = (play_figure){
		.next = EDIT_IN_USE,
		.place = STILB_SCENE_NONE,
		.nodes = malloc((a->node_count + 1ull) * sizeof *figure->nodes),
		.models = malloc((shared->model_count + 1ull) * sizeof *figure->models),
		.meshes = calloc(shared->posed_count + 1ull, sizeof *figure->meshes),
		.places = calloc(shared->carrier_count > 0 ? a->node_count : 1, sizeof *figure->places),
		.joints = calloc(a->joint_count + 1ull, sizeof *figure->joints),
		.weights = calloc(a->weight_count + 1ull, sizeof *figure->weights),
		.shown_weights = calloc(a->weight_count + 1ull, sizeof *figure->weights),
		.turned = calloc(a->skin_count + 1ull, sizeof *figure->turned),
	};
	if (!figure->nodes || !figure->models || !figure->meshes || !figure->places || !figure->joints ||
	    !figure->weights || !figure->shown_weights || !figure->turned) {
		scene_play_free_figure(figure);
		return play_memory();
	}
	memset(figure->nodes, 0xff, (a->node_count + 1ull) * sizeof *figure->nodes);
	memset(figure->models, 0xff, (shared->model_count + 1ull) * sizeof *figure->models);
	for (uint32_t p = 0; p < shared->posed_count; p++)
		figure->meshes[p] = (play_mesh){STILB_SCENE_NONE, true};
	if (a->weight_count > 0)
		memcpy(figure->weights, a->weights, a->weight_count * sizeof *figure->weights);
	return STILB_OK;
}

/* Makes room for one more figure, and for the work of all. */
static stilb_result play_reserve(stilb_scene_figures *all)
{
	uint64_t chunks = 0, more = all->capacity + (uint64_t)all->capacity / 2 + 4;
	if (all->first_free || all->count < all->capacity)
		return STILB_OK;
	for (uint32_t p = 0; p < all->shared.posed_count; p++)
		chunks += play_chunks(&all->shared.rests[all->shared.posed[p].deform]);
	if (more * (chunks + 1) > UINT32_MAX || more * (all->shared.posed_count + 1ull) > UINT32_MAX)
		return stilb_fail(STILB_ERROR_ARGUMENT, "more than %u figures", all->capacity);
	void *arrays[4] = {
		realloc(all->figures, more * sizeof *all->figures),
		realloc(all->due, more * sizeof *all->due),
		realloc(all->work, (more * all->shared.posed_count + 1) * sizeof *all->work),
		realloc(all->boxes, (more * chunks + 1) * sizeof *all->boxes),
	};
	all->figures = arrays[0] ? arrays[0] : all->figures;
	all->due = arrays[1] ? arrays[1] : all->due;
	all->work = arrays[2] ? arrays[2] : all->work;
	all->boxes = arrays[3] ? arrays[3] : all->boxes;
	for (int i = 0; i < 4; i++)
		if (!arrays[i])
			return play_memory();
	all->capacity = (uint32_t)more;
	return STILB_OK;
}

/* ---- the first figure -------------------------------------------------------------------------------------------- */

/* Gives a posed mesh to a part of all models of its node. */
static stilb_result play_show(stilb_scene *scene, play_figure *figure, const play_posed *posed, uint32_t mesh)
{
	const stilb_scene_rest *node = &scene->animation->nodes[posed->node];
	stilb_result result = STILB_OK;
	for (uint32_t m = 0; result == STILB_OK && m < node->model_count; m++) {
		uint32_t model = figure->models[node->first_model - scene->figures->shared.first_model + m];
		uint32_t part = scene->first_part[model] + posed->part;
		if (scene->part_mesh[part] != mesh)
			result = stilb_scene_set_part(scene, model, posed->part,
			                              (stilb_scene_build_part){mesh, scene->part_material[part]});
	}
	return result;
}

/* Takes the mesh that the file has for a posed one, or makes a copy where other models show it, too. */
static stilb_result play_take_mesh(stilb_scene *scene, uint32_t figure, uint32_t posed)
{
	stilb_scene_figures *all = scene->figures;
	const play_posed *from = &all->shared.posed[posed];
	uint32_t mesh = scene->animation->deforms[from->deform].mesh;
	stilb_result result = STILB_OK;
	stilb_scene_mesh_drop_levels(&scene->meshes[mesh]);
	bool shared = scene->edits->mesh_figure[mesh] ||
	              scene->edits->meshes.users[mesh] > scene->animation->nodes[from->node].model_count;
	if (shared) {
		uint32_t copy;
		result = stilb_scene_add_mesh(scene, &scene->meshes[mesh], &copy);
		if (result != STILB_OK)
			return result;
		mesh = copy;
	}
	scene->edits->mesh_figure[mesh] = figure + 1;
	all->figures[figure].meshes[posed].mesh = mesh;
	return play_show(scene, &all->figures[figure], from, mesh);
}

/* Models with a skin stand where their figure does. */
static stilb_result play_place_skinned(stilb_scene *scene, const play_figure *figure)
{
	const stilb_scene_animation *animation = scene->animation;
	stilb_mat4 world = stilb_mat4_identity();
	stilb_result result = STILB_OK;
	for (uint32_t n = 0; n < animation->node_count; n++) {
		const stilb_scene_rest *node = &animation->nodes[n];
		for (uint32_t m = 0; node->skin != STILB_SCENE_NONE && result == STILB_OK && m < node->model_count; m++) {
			uint32_t model = figure->models[node->first_model - scene->figures->shared.first_model + m];
			if (!scene_play_is_skinned(scene, n))
				break;
			result = stilb_scene_attach_model(scene, model, figure->place);
			if (result == STILB_OK && figure->place == STILB_SCENE_NONE)
				result = stilb_scene_set_transform(scene, model, &world);
		}
	}
	return result;
}

bool scene_play_is_skinned(const stilb_scene *scene, uint32_t node)
{
	const play_shared *shared = &scene->figures->shared;
	for (uint32_t p = 0; p < shared->posed_count; p++)
		if (shared->posed[p].node == node && shared->posed[p].skin != STILB_SCENE_NONE)
			return true;
	return false;
}

static stilb_result play_begin(stilb_scene *scene)
{
	stilb_scene_figures *all = scene->figures;
	all->skin = scene_play_skin_choose();
	stilb_result result = scene_play_share(scene, &all->shared);
	if (result == STILB_OK)
		result = scene_edit_begin(scene);
	if (result == STILB_OK)
		result = scene_play_reserve_scratch(all, 1) ? play_reserve(all) : play_memory();
	if (result == STILB_OK)
		result = play_make(scene, &all->figures[0]);
	if (result != STILB_OK)
		return result;
	play_figure *figure = &all->figures[all->count++];
	all->in_use = 1;
	for (uint32_t n = 0; n < scene->animation->node_count; n++) {
		figure->nodes[n] = n;
		scene->edits->nodes.figure[n] = 1;
	}
	for (uint32_t m = 0; m < all->shared.model_count; m++) {
		figure->models[m] = all->shared.first_model + m;
		scene->edits->models[figure->models[m]].figure = 1;
	}
	for (uint32_t p = 0; result == STILB_OK && p < all->shared.posed_count; p++)
		result = play_take_mesh(scene, 0, p);
	if (result == STILB_OK)
		result = play_place_skinned(scene, figure);
	if (result == STILB_OK) {
		figure->posing = true;
		scene_play_pose(scene, NULL, 0);
		stilb_scene_changes_read(scene);
		stilb_scene_changes_clear(scene); /* nobody has read the scene yet */
	}
	return result;
}

stilb_result scene_play_begin(stilb_scene *scene)
{
	STILB_ASSERT(scene && !scene->figures);
	if (!scene->animation || scene->animation->node_count > scene->nodes.count)
		return STILB_OK;
	scene->figures = calloc(1, sizeof *scene->figures);
	return scene->figures ? play_begin(scene) : play_memory();
}

/* ---- plays ------------------------------------------------------------------------------------------------------- */

stilb_scene_play stilb_scene_play_make(uint32_t clip)
{
	return (stilb_scene_play){.clip = clip, .speed = 1.0f, .weight = 1.0f};
}

uint32_t stilb_scene_find_clip(const stilb_scene *scene, const char *name)
{
	STILB_ASSERT(scene && name);
	uint32_t count = scene->animation ? scene->animation->clip_count : 0;
	for (uint32_t c = 0; c < count; c++)
		if (strcmp(scene->animation->clips[c].name, name) == 0)
			return c;
	char *end;
	unsigned long number = strtoul(name, &end, 10);
	bool digits = name[0] >= '0' && name[0] <= '9' && *end == '\0';
	return digits && number >= 1 && number <= count ? (uint32_t)number - 1 : STILB_SCENE_NONE;
}

/* A time within a clip that begins anew. */
static double play_wrap(double time, double duration)
{
	if (duration <= 0.0)
		return 0.0;
	double wrapped = fmod(time, duration);
	wrapped = wrapped < 0.0 ? wrapped + duration : wrapped;
	return wrapped < duration ? wrapped : 0.0;
}

static stilb_result play_check_play(const stilb_scene *scene, uint32_t figure, uint32_t index,
                                    const stilb_scene_play *play)
{
	const char *mistake = NULL;
	if (play->clip >= scene->animation->clip_count)
		return stilb_fail(STILB_ERROR_ARGUMENT, "play %u of figure %u: there is no clip %u, but %u", index, figure,
		                  play->clip, scene->animation->clip_count);
	if (!isfinite(play->time))
		mistake = "time is not finite";
	else if (!isfinite(play->speed))
		mistake = "speed is not finite";
	else if (!(play->weight >= 0.0f && play->weight <= 1e18f))
		mistake = "weight is not between 0 and 1e18";
	else if ((uint32_t)play->repeat >= STILB_SCENE_REPEATS)
		mistake = "repeat is unknown";
	return mistake ? stilb_fail(STILB_ERROR_ARGUMENT, "play %u of figure %u: its %s", index, figure, mistake)
	               : STILB_OK;
}

stilb_result stilb_scene_set_plays(stilb_scene *scene, uint32_t figure, const stilb_scene_play *plays, uint32_t count)
{
	STILB_ASSERT(plays || count == 0);
	play_figure *to;
	stilb_result result = play_check(scene, figure, &to);
	if (result == STILB_OK && count > STILB_SCENE_MAX_PLAYS)
		result = stilb_fail(STILB_ERROR_ARGUMENT, "figure %u: %u plays are more than %u", figure, count,
		                    STILB_SCENE_MAX_PLAYS);
	for (uint32_t p = 0; result == STILB_OK && p < count; p++)
		result = play_check_play(scene, figure, p, &plays[p]);
	if (result != STILB_OK)
		return result;
	stilb_scene_play *copy = NULL;
	if (count > 0) {
		copy = malloc(count * sizeof *copy);
		if (!copy)
			return play_memory();
		memcpy(copy, plays, count * sizeof *copy);
	}
	for (uint32_t p = 0; p < count; p++) {
		double duration = (double)scene->animation->clips[copy[p].clip].duration;
		copy[p].time = copy[p].repeat == STILB_SCENE_LOOP ? play_wrap(copy[p].time, duration)
		                                                  : fmin(fmax(copy[p].time, 0.0), duration);
	}
	free(to->plays);
	to->plays = copy;
	to->play_count = count;
	to->fresh = true;
	return STILB_OK;
}

const stilb_scene_play *stilb_scene_plays_of(const stilb_scene *scene, uint32_t figure, uint32_t *count)
{
	STILB_ASSERT(scene && count);
	const play_figure *from = play_find(scene, figure);
	*count = from ? from->play_count : 0;
	return *count > 0 ? from->plays : NULL;
}

/* Gives a node the pose that the file has, or the matrix, which no pose may make. */
static void play_rest_node(stilb_scene *scene, uint32_t own, const stilb_scene_rest *rest)
{
	stilb_scene_pose *pose = &scene->nodes.pose[own];
	scene->nodes.local[own] = rest->local;
	if (rest->moves) {
		memcpy(pose->translation, rest->translation, sizeof pose->translation);
		memcpy(pose->rotation, rest->rotation, sizeof pose->rotation);
		memcpy(pose->scale, rest->scale, sizeof pose->scale);
	} else {
		*pose = stilb_scene_pose_of(&rest->local);
	}
	scene_edit_node_changed(&scene->edits->nodes, own);
}

stilb_result stilb_scene_rest_figure(stilb_scene *scene, uint32_t figure)
{
	play_figure *to;
	stilb_result result = play_check(scene, figure, &to);
	if (result != STILB_OK)
		return result;
	const stilb_scene_animation *a = scene->animation;
	for (uint32_t n = 0; n < a->node_count; n++) {
		if (to->nodes[n] != STILB_SCENE_NONE)
			play_rest_node(scene, to->nodes[n], &a->nodes[n]);
	}
	if (a->weight_count > 0)
		memcpy(to->weights, a->weights, a->weight_count * sizeof *to->weights);
	to->posing = true;
	return STILB_OK;
}

stilb_result stilb_scene_set_weights(stilb_scene *scene, uint32_t figure, uint32_t node, const float *weights,
                                     uint32_t count)
{
	STILB_ASSERT(weights || count == 0);
	play_figure *to;
	stilb_result result = play_check(scene, figure, &to);
	if (result != STILB_OK)
		return result;
	if (node >= scene->animation->node_count || scene->animation->nodes[node].weight_count != count)
		return stilb_fail(STILB_ERROR_ARGUMENT, "figure %u: node %u has no %u weights", figure, node, count);
	for (uint32_t w = 0; w < count; w++)
		if (!isfinite(weights[w]))
			return stilb_fail(STILB_ERROR_ARGUMENT, "figure %u: weight %u of node %u is not finite", figure, w, node);
	if (count > 0)
		memcpy(to->weights + scene->animation->nodes[node].first_weight, weights, count * sizeof *weights);
	to->posing = true;
	return STILB_OK;
}

/* ---- time -------------------------------------------------------------------------------------------------------- */

/* Moves a play on. True if its time has changed; *ended: it has come to an end. */
static bool play_move(stilb_scene_play *play, double duration, double seconds, bool *ended)
{
	double before = play->time, after = before + seconds * (double)play->speed;
	*ended = false;
	if (after == before)
		return false;
	if (play->repeat == STILB_SCENE_LOOP) {
		*ended = after >= duration || after < 0.0;
		play->time = play_wrap(after, duration);
		return true;
	}
	play->time = fmin(fmax(after, 0.0), duration);
	*ended = (after >= duration && before < duration) || (after <= 0.0 && before > 0.0);
	return play->time != before;
}

/* Keeps that a play has ended, for its callback; without memory the callback comes at the next end. */
static void play_keep_end(stilb_scene_figures *all, uint32_t figure, uint32_t play)
{
	const stilb_scene_play *from = &all->figures[figure].plays[play];
	if (!from->ended)
		return;
	if (all->end_count == all->end_capacity) {
		uint32_t more = 2 * all->end_capacity + 16;
		play_end *grown = realloc(all->ends, more * sizeof *grown);
		if (!grown)
			return;
		all->ends = grown;
		all->end_capacity = more;
	}
	all->ends[all->end_count++] = (play_end){figure, play, from->ended, from->user};
}

/* Moves all times on. Returns how many figures are to be sampled. */
static uint32_t play_move_all(stilb_scene *scene, double seconds)
{
	stilb_scene_figures *all = scene->figures;
	uint32_t due = 0;
	all->counts = (stilb_scene_play_counts){0};
	for (uint32_t f = 0; f < all->count; f++) {
		play_figure *figure = &all->figures[f];
		bool moved = figure->fresh, ended;
		for (uint32_t p = 0; p < figure->play_count; p++) {
			stilb_scene_play *play = &figure->plays[p];
			moved |= play_move(play, (double)scene->animation->clips[play->clip].duration, seconds, &ended);
			if (ended)
				play_keep_end(all, f, p);
		}
		figure->behind |= moved && figure->play_count > 0;
		bool sampled = figure->behind && scene_play_is_due(scene, f);
		if (figure->fresh) /* other plays take hold at once, and in all nodes */
			figure->least = 0.0f;
		if (sampled || (figure->behind && figure->fresh))
			all->due[due++] = f;
		all->counts.waiting += figure->behind;
		figure->fresh = false;
	}
	all->calls++;
	all->counts.figures = all->in_use;
	all->counts.sampled = due;
	all->counts.waiting -= due;
	return due;
}

void stilb_scene_advance(stilb_scene *scene, double seconds, stilb_job_pool *pool, uint32_t worker)
{
	STILB_ASSERT(scene && isfinite(seconds));
	stilb_scene_figures *all = scene->figures;
	if (!all)
		return;
	all->end_count = 0;
	uint32_t due = play_move_all(scene, seconds);
	if (due > 0)
		scene_play_sample(scene, due, pool, worker);
	for (uint32_t e = 0; e < all->end_count; e++) {
		play_end end = all->ends[e];
		end.ended(end.user, end.figure, end.play);
	}
	all->end_count = 0;
}

/* The box around the vertices of all visible models; false: there is none. */
static bool play_box_of(const stilb_scene *scene, play_box *box)
{
	*box = (play_box){{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
	for (uint32_t m = 0; m < scene->model_count; m++)
		for (uint32_t p = scene->first_part[m]; p < scene->first_part[m + 1] && !isnan(scene->bounds.radius[m]); p++) {
			const stilb_scene_mesh *mesh = &scene->meshes[scene->part_mesh[p]];
			const float *t = scene->part_transform[p].m;
			for (uint32_t v = 0; v < mesh->vertex_count; v++)
				for (int i = 0; i < 3; i++) {
					const float *at = mesh->vertices[v].position;
					float x = t[i] * at[0] + t[4 + i] * at[1] + t[8 + i] * at[2] + t[12 + i];
					bool usable = fabsf(x) <= 1e18f;
					box->low[i] = usable && x < box->low[i] ? x : box->low[i];
					box->high[i] = usable && x > box->high[i] ? x : box->high[i];
				}
		}
	return box->low[0] <= box->high[0] && box->low[1] <= box->high[1] && box->low[2] <= box->high[2];
}

/* Shows the pose of figure 0 that its plays have. */
static void play_show_now(stilb_scene *scene)
{
	stilb_scene_advance(scene, 0.0, NULL, 0);
	stilb_scene_update_nodes(scene, NULL, 0);
}

stilb_result stilb_scene_sweep(stilb_scene *scene, uint32_t clip)
{
	play_figure *figure;
	stilb_result result = play_check(scene, 0, &figure);
	if (result != STILB_OK)
		return result;
	stilb_scene_figures *all = scene->figures;
	all->swept_count = 0;
	if (clip == STILB_SCENE_NONE || scene_is_placed_often(scene))
		return STILB_OK;
	stilb_scene_play *plays = figure->plays, play = stilb_scene_play_make(clip);
	uint32_t count = figure->play_count;
	figure->plays = NULL;
	play.repeat = STILB_SCENE_ONCE;
	for (uint32_t i = 0; result == STILB_OK && i < STILB_SCENE_SWEEP; i++) {
		double duration = clip < scene->animation->clip_count ? (double)scene->animation->clips[clip].duration : 0.0;
		play.time = duration * i / (STILB_SCENE_SWEEP - 1);
		result = stilb_scene_set_plays(scene, 0, &play, 1);
		if (result == STILB_OK)
			play_show_now(scene);
		if (result == STILB_OK && play_box_of(scene, &all->swept[all->swept_count]))
			all->swept_count++;
	}
	figure = &all->figures[0];
	free(figure->plays);
	figure->plays = plays;
	figure->play_count = count;
	figure->fresh = true;
	stilb_scene_rest_figure(scene, 0);
	play_show_now(scene);
	return result;
}

/* ---- more figures ------------------------------------------------------------------------------------------------ */

bool stilb_scene_mesh_is_posed(const stilb_scene *scene, uint32_t mesh)
{
	STILB_ASSERT(scene && mesh < scene->mesh_count);
	return scene->figures && scene->edits->mesh_figure[mesh] > 0;
}

uint64_t stilb_scene_mesh_pose(const stilb_scene *scene, uint32_t mesh)
{
	STILB_ASSERT(scene && mesh < scene->mesh_count);
	return scene->figures && scene->edits ? scene->edits->mesh_pose[mesh] : 0;
}

uint32_t stilb_scene_figure_count(const stilb_scene *scene)
{
	STILB_ASSERT(scene);
	return scene->figures ? scene->figures->count : 0;
}

uint32_t stilb_scene_figure_node(const stilb_scene *scene, uint32_t figure, uint32_t node)
{
	STILB_ASSERT(scene);
	const play_figure *from = play_find(scene, figure);
	if (!from)
		return STILB_SCENE_NONE;
	if (node == STILB_SCENE_NONE)
		return from->place;
	return node < scene->animation->node_count ? from->nodes[node] : STILB_SCENE_NONE;
}

/* Copies the nodes below the figure's place. */
static stilb_result play_add_nodes(stilb_scene *scene, uint32_t index)
{
	const stilb_scene_animation *a = scene->animation;
	stilb_result result = STILB_OK;
	for (uint32_t n = 0; result == STILB_OK && n < a->node_count; n++) {
		play_figure *figure = &scene->figures->figures[index];
		const stilb_scene_rest *rest = &a->nodes[n];
		uint32_t parent = rest->parent == STILB_SCENE_NONE ? figure->place : figure->nodes[rest->parent];
		stilb_scene_pose pose = stilb_scene_pose_identity();
		result = stilb_scene_add_node(scene, parent, &pose, &figure->nodes[n]);
		if (result != STILB_OK) {
			figure->nodes[n] = STILB_SCENE_NONE;
			break;
		}
		scene->edits->nodes.figure[figure->nodes[n]] = index + 1;
		play_rest_node(scene, figure->nodes[n], rest);
		result = stilb_scene_set_node_name(scene, figure->nodes[n], rest->name);
	}
	return result;
}

/* Adds a posed mesh to a figure: a copy of the one at rest. */
static stilb_result play_add_mesh(stilb_scene *scene, uint32_t index, uint32_t posed)
{
	stilb_scene_figures *all = scene->figures;
	const play_rest *rest = &all->shared.rests[all->shared.posed[posed].deform];
	uint32_t from = all->figures[0].meshes[posed].mesh, mesh;
	if (from == STILB_SCENE_NONE || scene->meshes[from].vertex_count != rest->vertex_count)
		return stilb_fail(STILB_ERROR_ARGUMENT, "a mesh of figure 0 was replaced or removed: it has no copies");
	stilb_scene_mesh copied = scene->meshes[from]; /* the array may move */
	stilb_result result = stilb_scene_add_mesh(scene, &copied, &mesh);
	if (result != STILB_OK)
		return result;
	scene->edits->mesh_figure[mesh] = index + 1;
	all->figures[index].meshes[posed].mesh = mesh;
	return STILB_OK;
}

/* Adds a copy of a model of figure 0, and gives it the figure's own meshes. */
static stilb_result play_add_model(stilb_scene *scene, uint32_t index, uint32_t n, uint32_t number)
{
	stilb_scene_figures *all = scene->figures;
	const stilb_scene_rest *node = &scene->animation->nodes[n];
	uint32_t at = node->first_model - all->shared.first_model + number, from = all->figures[0].models[at], model;
	if (from == STILB_SCENE_NONE)
		return STILB_OK; /* it was removed: copies lack it, too */
	uint32_t first = scene->first_part[from], count = scene->first_part[from + 1] - first;
	stilb_scene_build_part *parts = malloc(count * sizeof *parts);
	if (!parts)
		return play_memory();
	for (uint32_t p = 0; p < count; p++)
		parts[p] = (stilb_scene_build_part){scene->part_mesh[first + p], scene->part_material[first + p]};
	for (uint32_t p = 0; p < all->shared.posed_count; p++)
		if (all->shared.posed[p].node == n && all->shared.posed[p].part < count)
			parts[all->shared.posed[p].part].mesh = all->figures[index].meshes[p].mesh;
	stilb_mat4 world = stilb_mat4_identity();
	stilb_result result = stilb_scene_add_model(scene, &world, parts, count, &model);
	free(parts);
	if (result != STILB_OK)
		return result;
	play_figure *figure = &all->figures[index];
	figure->models[at] = model;
	scene->edits->models[model].figure = index + 1;
	scene_set_model_flags(scene, model, scene->model_flags[from]);
	uint32_t hangs = scene->model_node[from], on = figure->nodes[n];
	if (scene_play_is_skinned(scene, n))
		return stilb_scene_attach_model(scene, model, figure->place);
	/* An instance of the node hangs on a node of its own below it. */
	if (hangs && hangs - 1 != all->figures[0].nodes[n]) {
		stilb_scene_pose own = scene->nodes.pose[hangs - 1]; /* the array may move */
		result = stilb_scene_add_node(scene, on, &own, &on);
		if (result == STILB_OK)
			scene->edits->nodes.figure[on] = index + 1;
	}
	return result == STILB_OK ? stilb_scene_attach_model(scene, model, on) : result;
}

static stilb_result play_fill(stilb_scene *scene, uint32_t index, const stilb_scene_pose *place)
{
	const stilb_scene_animation *a = scene->animation;
	stilb_scene_figures *all = scene->figures;
	stilb_result result = stilb_scene_add_node(scene, STILB_SCENE_NONE, place, &all->figures[index].place);
	if (result != STILB_OK) {
		all->figures[index].place = STILB_SCENE_NONE;
		return result;
	}
	scene->edits->nodes.figure[all->figures[index].place] = index + 1;
	result = play_add_nodes(scene, index);
	for (uint32_t p = 0; result == STILB_OK && p < all->shared.posed_count; p++)
		result = play_add_mesh(scene, index, p);
	for (uint32_t n = 0; n < a->node_count; n++)
		for (uint32_t m = 0; result == STILB_OK && m < a->nodes[n].model_count; m++)
			result = play_add_model(scene, index, n, m);
	all->figures[index].posing = true;
	return result;
}

/* Removes a node, unless other things hang on it: it is the program's then. */
static void play_drop_node(stilb_scene *scene, uint32_t node)
{
	if (stilb_scene_remove_node(scene, node) != STILB_OK)
		scene->edits->nodes.figure[node] = 0;
}

/* Removes what a figure has. Nodes on which other things hang stay, as do meshes that other models show. */
static void play_empty(stilb_scene *scene, uint32_t index)
{
	stilb_scene_figures *all = scene->figures;
	play_figure *figure = &all->figures[index];
	for (uint32_t m = 0; m < all->shared.model_count; m++) {
		uint32_t model = figure->models[m];
		if (model == STILB_SCENE_NONE)
			continue;
		uint32_t hangs = scene->model_node[model];
		stilb_scene_remove_model(scene, model);
		bool instance = hangs && scene->edits->nodes.figure[hangs - 1] == index + 1;
		for (uint32_t n = 0; instance && n < scene->animation->node_count; n++)
			instance = figure->nodes[n] != hangs - 1;
		if (instance && hangs - 1 != figure->place)
			play_drop_node(scene, hangs - 1);
	}
	for (uint32_t p = 0; p < all->shared.posed_count; p++) {
		uint32_t mesh = figure->meshes[p].mesh;
		if (mesh != STILB_SCENE_NONE && scene->edits->meshes.users[mesh] == 0)
			stilb_scene_remove_mesh(scene, mesh);
		else if (mesh != STILB_SCENE_NONE)
			scene->edits->mesh_figure[mesh] = 0;
	}
	for (uint32_t n = scene->animation->node_count; n-- > 0;)
		if (figure->nodes[n] != STILB_SCENE_NONE)
			play_drop_node(scene, figure->nodes[n]);
	if (figure->place != STILB_SCENE_NONE)
		play_drop_node(scene, figure->place);
	scene_play_free_figure(figure);
	figure->next = all->first_free;
	all->first_free = index + 1;
	all->in_use--;
}

stilb_result stilb_scene_add_figure(stilb_scene *scene, const stilb_scene_pose *place, uint32_t *figure)
{
	STILB_ASSERT(place && figure);
	play_figure *first, made;
	stilb_result result = play_check(scene, 0, &first);
	if (result == STILB_OK)
		result = play_reserve(scene->figures);
	if (result == STILB_OK)
		result = play_make(scene, &made);
	if (result != STILB_OK)
		return result;
	stilb_scene_figures *all = scene->figures;
	uint32_t index = all->first_free ? all->first_free - 1 : all->count;
	if (all->first_free)
		all->first_free = all->figures[index].next;
	else
		all->count++;
	all->figures[index] = made;
	all->in_use++;
	result = play_fill(scene, index, place);
	if (result != STILB_OK) {
		play_empty(scene, index);
		return result;
	}
	*figure = index;
	return STILB_OK;
}

stilb_result stilb_scene_remove_figure(stilb_scene *scene, uint32_t figure)
{
	play_figure *from;
	stilb_result result = play_check(scene, figure, &from);
	if (result == STILB_OK && figure == 0)
		return stilb_fail(STILB_ERROR_ARGUMENT, "figure 0 is the file's own; remove or hide its models");
	if (result == STILB_OK)
		play_empty(scene, figure);
	return result;
}
