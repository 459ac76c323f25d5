/* Clusters of large meshes on the null device: which are drawn, against a plain statement of the rule in double; that
 * what is drawn of a closed mesh is closed; and the same stream for any number of workers and in dumps. */
#include "render/clusters/clusters_made.h"
#include "render/render_clusters.h"
#include "render/render_dump.h"
#include "scene/scene_build.h"
#include "support/test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define WIDTH 640u
#define HEIGHT 360u
#define MODELS 6u
#define INDICES (6 * TORUS_SIDE * TORUS_SIDE)

/* A torus whose clusters are drawn in full, and one with a level as well: models 0 .. 5, of which 4 and 5 have it. */
static stilb_scene_mesh torus, leveled;
static stilb_scene *scene;
static uint32_t ids[MODELS] = {0, 1, 2, 3, 4, 5};

/* ---- a scene ----------------------------------------------------------------------------------------------------- */

/* A torus whose level is the coarser versions that are from the groups of the third size. */
static stilb_scene_mesh leveled_make(void)
{
	stilb_scene_mesh mesh = torus_make();
	mesh.levels = calloc(1, sizeof *mesh.levels);
	mesh.level_indices = calloc(INDICES, sizeof *mesh.level_indices);
	assert_true(mesh.levels && mesh.level_indices);
	for (uint32_t c = 0; c < mesh.cluster_count; c++) {
		const stilb_scene_cluster *cluster = &mesh.clusters[c];
		if (cluster->from == STILB_SCENE_NONE || cluster->from < TORUS_GROUPS - 5)
			continue;
		memcpy(mesh.level_indices + mesh.level_index_count, mesh.cluster_indices + cluster->first_index,
		       cluster->index_count * sizeof *mesh.level_indices);
		mesh.level_index_count += cluster->index_count;
	}
	mesh.level_count = 1;
	mesh.levels[0] =
		(stilb_scene_level){.index_count = mesh.level_index_count, .vertex_count = mesh.vertex_count, .error = 0.2f};
	return mesh;
}

/* Stretched, sheared, mirrored, flattened, and far from where everything else is. */
static const stilb_mat4 places[MODELS] = {
	{{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}},
	{{0.5f, 0, 0, 0, 0, 4, 0, 0, 0, 0, 1, 0, 9, 1, 0, 1}},
	{{1, 0, 0, 0, 1, 1, 0, 0, 0.5f, 1, 1, 0, -12, 2, 3, 1}},
	{{-1, 0, 0, 0, 0, 0.6f, 0.8f, 0, 0, -0.8f, 0.6f, 0, 2, 0, -20, 1}},
	{{2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 2, 0, 3, -2, 8, 1}},
	{{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 500, 0, -900, 1}},
};

#define MIRRORED 3u

static int scene_make(void **state)
{
	(void)state;
	torus = torus_make();
	leveled = leveled_make();
	stilb_scene_build *build = stilb_scene_build_begin();
	uint32_t meshes[2] = {stilb_scene_build_mesh(build, &torus), stilb_scene_build_mesh(build, &leveled)};
	stilb_scene_material grey = {.diffuse = {0.5f, 0.5f, 0.5f}, .roughness = 1.0f};
	uint32_t material = stilb_scene_build_material(build, &grey);
	for (uint32_t m = 0; m < MODELS; m++) {
		stilb_scene_build_part part = {meshes[m >= 4], material};
		stilb_scene_build_model(build, stilb_scene_build_node(build, STILB_SCENE_NO_PARENT, &places[m]), &part, 1);
	}
	if (stilb_scene_build_end(build, &scene) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return 0;
}

static int scene_free(void **state)
{
	(void)state;
	stilb_scene_destroy(scene);
	stilb_scene_mesh_finish(&torus);
	stilb_scene_mesh_finish(&leveled);
	return 0;
}

static stilb_render *make_render(stilb_render_replay_mode replay, uint32_t workers)
{
	stilb_render_desc desc = {.device = STILB_RENDER_DEVICE_NULL,
	                          .replay = replay,
	                          .width = WIDTH,
	                          .height = HEIGHT,
	                          .context_count = workers + 1};
	stilb_render *render;
	assert_int_equal(stilb_render_create(&desc, &render), STILB_OK);
	assert_int_equal(stilb_render_set_scene(render, scene), STILB_OK);
	return render;
}

static stilb_job_pool *make_pool(uint32_t workers)
{
	stilb_job_pool_desc desc = {.worker_count = workers};
	stilb_job_pool *pool;
	assert_int_equal(stilb_job_pool_create(&desc, &pool), 0);
	return pool;
}

static float near_z = 0.1f; /* of all cameras, metres */

static stilb_render_view look(const float position[3], float yaw, float pitch, float fov, float error)
{
	stilb_scene_camera camera = {.yaw = yaw, .pitch = pitch, .fov_y = fov, .near_z = near_z, .far_z = 5000.0f};
	memcpy(camera.position, position, sizeof camera.position);
	stilb_render_view view = {.view_projection = stilb_scene_camera_matrix(&camera, (float)WIDTH / HEIGHT),
	                          .shading = stilb_render_shading_default(),
	                          .detail = {STILB_RENDER_DETAIL_POP, error}};
	memcpy(view.camera_position, position, sizeof view.camera_position);
	return view;
}

/* Numbers in [0, 1) that look random. */
static float next(void)
{
	static uint32_t seed = 12345;
	seed = seed * 1664525u + 1013904223u;
	return (float)(seed >> 8) * 0x1p-24f;
}

/* A view from somewhere, most of them of somewhere. */
static stilb_render_view view_any(void)
{
	float far = 1.0f + 60.0f * next() * next() * next();
	float yaw = 6.2831853f * next(), pitch = 2.0f * next() - 1.0f;
	const float position[3] = {far * sinf(yaw) * cosf(pitch) + 6.0f * next(), -far * sinf(pitch),
	                           far * cosf(yaw) * cosf(pitch)};
	return look(position, yaw, pitch, 0.1f + 1.4f * next(), 0.1f + 4.0f * next() * next());
}

static void draw(stilb_render *render, const stilb_render_view *view, stilb_job_pool *pool)
{
	static const stilb_render_pass pass = {.name = "scene"};
	assert_int_equal(stilb_render_frame_begin(render), STILB_OK);
	assert_int_equal(stilb_render_record_view(render, 0, scene, ids, MODELS, view, pool, 0), STILB_OK);
	assert_int_equal(stilb_render_replay(render, &pass, 1, view, 1, pool, 0), STILB_OK);
}

/* ---- what a frame has drawn -------------------------------------------------------------------------------------- */

#define MOST_DRAWS 4096u

typedef struct drawn {
	const render_command *command;
	const render_row *row;
	uint32_t model, kind;
} drawn;

static uint32_t drawn_list(const stilb_render *render, drawn out[MOST_DRAWS])
{
	const render_pass_lists *lists = &render->passes[0];
	uint32_t count = 0;
	for (uint32_t r = 0; r < lists->run_count; r++)
		for (uint32_t c = lists->runs[r].first; c < lists->runs[r].first + lists->runs[r].count; c++) {
			const render_command *command = &render_commands(render)[c];
			const render_row *row = render_row_of(render, command);
			uint32_t model = 0;
			while (model < MODELS &&
			       (places[model].m[12] != row->transform[3] || places[model].m[14] != row->transform[11]))
				model++;
			assert_true(model < MODELS && count < MOST_DRAWS);
			for (uint32_t i = 0; i < 12; i++)
				assert_true(row->transform[i] == places[model].m[i % 4 * 4 + i / 4]);
			out[count++] = (drawn){command, row, model, render_state_detail(lists->runs[r].state)};
		}
	return count;
}

/* Copies the indices that are drawn of a model; returns how many. */
static uint32_t drawn_indices(const stilb_render *render, const drawn *list, uint32_t count, uint32_t model,
                              uint32_t out[INDICES])
{
	const uint32_t *heap = (const uint32_t *)render->resources.heaps[RENDER_HEAP_INDICES].data;
	uint32_t indices = 0;
	for (uint32_t i = 0; i < count; i++) {
		if (list[i].model != model)
			continue;
		assert_true(indices + list[i].command->index_count <= INDICES);
		memcpy(out + indices, heap + list[i].command->first_index, list[i].command->index_count * sizeof *out);
		indices += list[i].command->index_count;
	}
	return indices;
}

/* ---- the rule ---------------------------------------------------------------------------------------------------- */

static void to_world(const stilb_mat4 *m, const float p[3], double out[3])
{
	for (int i = 0; i < 3; i++)
		out[i] = (double)m->m[i] * (double)p[0] + (double)m->m[4 + i] * (double)p[1] +
		         (double)m->m[8 + i] * (double)p[2] + (double)m->m[12 + i];
}

/* How much a matrix stretches at most: of many directions, made better by applying the matrix and its transpose. */
static double stretch_of(const stilb_mat4 *m)
{
	double best = 0.0;
	for (int start = 0; start < 3; start++) {
		double v[3] = {start == 0 ? 1.0 : 0.1, start == 1 ? 1.0 : 0.2, start == 2 ? 1.0 : 0.3}, length = 0.0;
		for (int step = 0; step < 200; step++) {
			double w[3], u[3], size = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
			for (int i = 0; i < 3; i++)
				w[i] = ((double)m->m[i] * v[0] + (double)m->m[4 + i] * v[1] + (double)m->m[8 + i] * v[2]) / size;
			length = sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
			for (int i = 0; i < 3; i++)
				u[i] = (double)m->m[4 * i] * w[0] + (double)m->m[4 * i + 1] * w[1] + (double)m->m[4 * i + 2] * w[2];
			memcpy(v, u, sizeof v);
		}
		best = fmax(best, length);
	}
	return best;
}

/* The group's error in pixels, over the allowed one: at most 1 if it suffices. */
static double excess(const stilb_scene_cluster_group *group, const stilb_mat4 *place, const stilb_render_view *view,
                     double stretch, double fov)
{
	double center[3], d = 0.0;
	to_world(place, group->center, center);
	for (int i = 0; i < 3; i++)
		d += pow(center[i] - (double)view->camera_position[i], 2.0);
	d = fmax(sqrt(d) - (double)group->radius * stretch, (double)near_z);
	return (double)group->error * stretch * 0.5 * HEIGHT / tan(0.5 * fov) / d / (double)view->detail.error;
}

/* True if all of a sphere's points are outside of the view, by a margin. */
static bool is_out(const float center[3], float radius, const stilb_mat4 *place, const stilb_render_view *view,
                   double stretch)
{
	stilb_frustum frustum = stilb_frustum_from_matrix(&view->view_projection);
	double p[3];
	to_world(place, center, p);
	for (int i = 0; i < 6; i++) {
		const stilb_plane *plane = &frustum.planes[i];
		double d =
			(double)plane->x * p[0] + (double)plane->y * p[1] + (double)plane->z * p[2] + (double)plane->distance;
		if (d < -(double)radius * stretch * 1.01 - 0.001)
			return true;
	}
	return false;
}

/* True if a corner of the cluster's triangles is in the view, by a margin. */
static bool is_in(const stilb_scene_mesh *mesh, const stilb_scene_cluster *cluster, const stilb_mat4 *place,
                  const stilb_render_view *view)
{
	const uint32_t *indices = cluster->from == STILB_SCENE_NONE ? mesh->indices : mesh->cluster_indices;
	for (uint32_t i = 0; i < cluster->index_count; i++) {
		double p[3], clip[4];
		to_world(place, mesh->vertices[indices[cluster->first_index + i]].position, p);
		for (int r = 0; r < 4; r++) {
			const float *m = view->view_projection.m + r;
			clip[r] = (double)m[0] * p[0] + (double)m[4] * p[1] + (double)m[8] * p[2] + (double)m[12];
		}
		double w = clip[3] * 0.999;
		if (fabs(clip[0]) < w && fabs(clip[1]) < w && clip[2] > 0.0 && clip[2] < w)
			return true;
	}
	return false;
}

/* True if the camera sees no front of the cluster's triangles: each shows its back or its edge. */
static bool is_back(const stilb_scene_mesh *mesh, const stilb_scene_cluster *cluster, const stilb_mat4 *place,
                    const stilb_render_view *view)
{
	const uint32_t *indices = cluster->from == STILB_SCENE_NONE ? mesh->indices : mesh->cluster_indices;
	for (uint32_t i = 0; i < cluster->index_count; i += 3) {
		double p[3][3], facing = 0.0;
		for (uint32_t k = 0; k < 3; k++)
			to_world(place, mesh->vertices[indices[cluster->first_index + i + k]].position, p[k]);
		for (int k = 0; k < 3; k++) {
			int l = (k + 1) % 3, m = (k + 2) % 3;
			double normal = (p[1][l] - p[0][l]) * (p[2][m] - p[0][m]) - (p[1][m] - p[0][m]) * (p[2][l] - p[0][l]);
			facing += normal * ((double)view->camera_position[k] - p[0][k]);
		}
		if (facing > 1e-5)
			return false;
	}
	return true;
}

/* Whether a cluster's indices are among those of a draw of the model: 1, 0 or, if in part, 2. */
static int drawn_share(const drawn *list, uint32_t count, uint32_t model, uint32_t first, uint32_t index_count)
{
	uint32_t there = 0;
	for (uint32_t i = 0; i < count; i++) {
		if (list[i].model != model)
			continue;
		uint32_t begin = list[i].command->first_index, end = begin + list[i].command->index_count;
		uint32_t low = begin > first ? begin : first, high = end < first + index_count ? end : first + index_count;
		there += high > low ? high - low : 0;
	}
	return there == 0 ? 0 : there == index_count ? 1 : 2;
}

static uint32_t left_out; /* clusters that turn their back */

/* Compares what is drawn of a model with the rule; returns how many clusters are. */
static uint32_t check_model(const stilb_render *render, const drawn *list, uint32_t count, uint32_t model,
                            const stilb_render_view *view, double fov)
{
	const stilb_scene_mesh *mesh = &torus;
	uint32_t first = render->resources.meshes[stilb_render_scene_mesh(render, 0).id & RENDER_INDEX_MASK].first_index;
	double stretch = stretch_of(&places[model]);
	uint32_t shown = 0;
	for (uint32_t g = 0; g < mesh->group_count; g++)
		for (uint32_t c = 0; c < mesh->groups[g].cluster_count; c++) {
			const stilb_scene_cluster *cluster = &mesh->clusters[mesh->groups[g].first_cluster + c];
			bool own = cluster->from == STILB_SCENE_NONE;
			double over = excess(&mesh->groups[g], &places[model], view, stretch, fov);
			double under = own ? 0.0 : excess(&mesh->groups[cluster->from], &places[model], view, stretch, fov);
			int is = drawn_share(list, count, model, first + cluster->first_index + (own ? 0 : mesh->index_count),
			                     cluster->index_count);
			assert_int_not_equal(is, 2);
			shown += (uint32_t)is;
			if (fabs(over - 1.0) < 1e-4 || fabs(under - 1.0) < 1e-4)
				continue;
			bool cut = over > 1.0 && under <= 1.0;
			if (is && (!cut || is_out(cluster->center, cluster->radius, &places[model], view, stretch)))
				fail_msg("cluster %u of group %u of model %u is drawn: %g over, %g under", c, g, model, over, under);
			bool back = !view->both_sides && model != MIRRORED && is_back(mesh, cluster, &places[model], view);
			left_out += !is && cut && back;
			if (!is && cut && !back && is_in(mesh, cluster, &places[model], view))
				fail_msg("cluster %u of group %u of model %u is missing: %g over, %g under", c, g, model, over, under);
		}
	return shown;
}

static void the_rule_says_what_is_drawn(void **state)
{
	(void)state;
	static drawn list[MOST_DRAWS];
	stilb_job_pool *pool = make_pool(0);
	stilb_render *render = make_render(STILB_RENDER_REPLAY_INDIRECT, 0);
	uint32_t shown = 0, views = TEST_TSAN ? 5 : TEST_ASAN ? 40 : 300;
	for (uint32_t v = 0; v < views; v++) {
		near_z = v % 4 == 3 ? 3.0f : 0.1f;
		stilb_render_view view = view_any();
		view.both_sides = v % 5 == 4;
		const float *m = view.view_projection.m;
		double fov = 2.0 * atan(1.0 / sqrt(pow((double)m[1], 2.0) + pow((double)m[5], 2.0) + pow((double)m[9], 2.0)));
		draw(render, &view, pool);
		uint32_t count = drawn_list(render, list);
		for (uint32_t model = 0; model < 4; model++)
			shown += check_model(render, list, count, model, &view, fov);
	}
	near_z = 0.1f;
	assert_true(shown > 20 * views && left_out > views);
	stilb_render_destroy(render);
	stilb_job_pool_destroy(pool);
}

/* In views that see all of the torus, what is drawn of it is closed, whatever the error; the finer, the more. */
static void cuts_are_closed(void **state)
{
	(void)state;
	static drawn list[MOST_DRAWS];
	static uint32_t indices[INDICES];
	stilb_job_pool *pool = make_pool(0);
	stilb_render *render = make_render(STILB_RENDER_REPLAY_INDIRECT, 0);
	uint32_t mixed = 0, views = TEST_TSAN ? 3 : TEST_ASAN ? 60 : 1000;
	for (uint32_t v = 0; v < views; v++) {
		float yaw = 6.2831853f * next(), pitch = 2.0f * next() - 1.0f, far = 4.5f + 10.0f * next();
		const float at[3] = {far * sinf(yaw) * cosf(pitch), -far * sinf(pitch), far * cosf(yaw) * cosf(pitch)};
		stilb_render_view view = look(at, yaw, pitch, 2.2f, 0.05f * powf(200.0f, next()));
		view.both_sides = true; /* else what turns its back would be missing */
		draw(render, &view, pool);
		uint32_t count = drawn_list(render, list), found = drawn_indices(render, list, count, 0, indices);
		assert_true(found > 0 && is_closed(indices, found));
		mixed += found > 3 * 576 && found < INDICES;
		view.detail.error *= 0.5f;
		draw(render, &view, pool);
		count = drawn_list(render, list);
		assert_true(drawn_indices(render, list, count, 0, indices) >= found);
	}
	assert_true(mixed > views / 3); /* neither the root alone nor the mesh in full */
	stilb_render_destroy(render);
	stilb_job_pool_destroy(pool);
}

/* A group suffices from farther away, too, and then so do all groups below it. */
static void the_cut_is_monotone(void **state)
{
	(void)state;
	render_clusters *clusters = render_clusters_make(&torus, torus.index_count);
	assert_non_null(clusters);
	uint32_t words = clusters->group_padded / 32, one[8], four[8];
	assert_true(words <= 8);
	for (uint32_t v = 0; v < (TEST_TSAN ? 20u : 2000u); v++) {
		stilb_render_view view = view_any();
		render_detail_view detail = render_detail_view_make(&view, WIDTH, HEIGHT);
		render_cluster_view seen = render_cluster_view_make(&detail, &view, &places[v % MODELS]);
		render_clusters_suffice(clusters, &seen, four);
		render_clusters_suffice_scalar(clusters, &seen, one);
		assert_memory_equal(one, four, words * sizeof *one);
		for (uint32_t g = 0; g < torus.group_count; g++)
			for (uint32_t c = 0; c < torus.groups[g].cluster_count; c++) {
				uint32_t from = torus.clusters[torus.groups[g].first_cluster + c].from;
				bool above = four[g / 32] >> g % 32 & 1;
				assert_true(from == STILB_SCENE_NONE || !above || (four[from / 32] >> from % 32 & 1));
			}
		assert_int_equal(four[torus.group_count / 32] >> torus.group_count % 32, 1);
		assert_false(four[(TORUS_GROUPS - 1) / 32] >> (TORUS_GROUPS - 1) % 32 & 1); /* the root's never does */
	}
	render_clusters_free(clusters);
}

/* What is left out for turning its back does, seen from near a cluster, too; and most of what does is found. */
static void backs_are_backs(void **state)
{
	(void)state;
	render_clusters *clusters = render_clusters_make(&torus, torus.index_count);
	uint32_t backs = 0, found = 0, wrong = 0;
	assert_non_null(clusters);
	for (uint32_t i = 0; i < (TEST_TSAN ? 200u : 40000u); i++) {
		uint32_t c = (uint32_t)(next() * (float)torus.cluster_count) % torus.cluster_count;
		const stilb_scene_cluster *cluster = &torus.clusters[c];
		float far = cluster->radius * 20.0f * next() * next(), at[3];
		double center[3];
		to_world(&places[i % 3], cluster->center, center);
		for (int k = 0; k < 3; k++)
			at[k] = (float)center[k] + far * (2.0f * next() - 1.0f);
		stilb_render_view view = look(at, 0.0f, 0.0f, 1.0f, 0.5f);
		render_detail_view detail = render_detail_view_make(&view, WIDTH, HEIGHT);
		render_cluster_view seen = render_cluster_view_make(&detail, &view, &places[i % 3]);
		assert_true(seen.backs);
		bool is = is_back(&torus, cluster, &places[i % 3], &view);
		bool says = render_cluster_is_back(&seen, &clusters->clusters[c]);
		backs += is;
		found += is && says;
		wrong += says && !is;
	}
	assert_int_equal(wrong, 0);
	if (backs == 0 || found < backs / 4)
		fail_msg("%u of %u clusters that turn their back are found", found, backs);
	render_clusters_free(clusters);
}

/* Without perspective the error is the same everywhere. */
static void views_without_perspective(void **state)
{
	(void)state;
	static drawn list[MOST_DRAWS];
	static uint32_t indices[INDICES];
	stilb_job_pool *pool = make_pool(0);
	stilb_render *render = make_render(STILB_RENDER_REPLAY_INDIRECT, 0);
	stilb_render_view view = {.detail = {STILB_RENDER_DETAIL_POP, 0.5f}, .shading = stilb_render_shading_default()};
	static const uint32_t triangles[4] = {2 * TORUS_SIDE * TORUS_SIDE, 64 * 48, 16 * 80, 4 * 144};
	/* Errors of groups are 0.016, 0.064 and 0.256 m; half of the picture's height shows so many metres. */
	static const float half[4] = {5.0f, 8.0f, 30.0f, 120.0f};
	for (int i = 0; i < 4; i++) {
		view.view_projection = (stilb_mat4){
			{HEIGHT / (WIDTH * half[i]), 0, 0, 0, 0, 1.0f / half[i], 0, 0, 0, 0, 0.0001f, 0, 0, 0, 0.5f, 1}};
		draw(render, &view, pool);
		uint32_t found = drawn_indices(render, list, drawn_list(render, list), 0, indices);
		assert_int_equal(found / 3, triangles[i]);
		assert_true(is_closed(indices, found));
	}
	stilb_render_destroy(render);
	stilb_job_pool_destroy(pool);
}

/* ---- levels, transitions, colours -------------------------------------------------------------------------------- */

/* `off` is one draw of the mesh in full; where a level suffices, it is drawn; else clusters are. While a level fades,
 * the clusters are drawn in the other pixels. */
static void levels_come_after_clusters(void **state)
{
	(void)state;
	static drawn list[MOST_DRAWS];
	stilb_job_pool *pool = make_pool(0);
	const float near[3] = {500.0f, 0.0f, -886.0f}, far[3] = {500.0f, 0.0f, -705.0f};
	for (int mode = 0; mode < 4; mode++) {
		stilb_render *render = make_render(STILB_RENDER_REPLAY_INDIRECT, 0);
		uint32_t draws[2][3] = {0}, pieces = 0; /* [whole][kind] of model 5 */
		for (int frame = 0; frame < 3; frame++) {
			stilb_render_view view = look(frame == 0 ? near : far, 0.0f, 0.0f, 0.8f, 0.5f);
			view.detail.mode = (stilb_render_detail_mode)mode;
			draw(render, &view, pool);
			uint32_t count = drawn_list(render, list);
			memset(draws, 0, sizeof draws);
			pieces = 0;
			for (uint32_t i = 0; i < count; i++)
				if (list[i].model == 5) {
					uint32_t indices = list[i].command->index_count;
					bool whole = indices == (mode == 0 ? INDICES : leveled.level_index_count);
					draws[whole][list[i].kind]++;
					pieces += !whole;
					assert_true(list[i].kind != 1 ||
					            (render_command_detail(list[i].command) != 0 && indices < INDICES));
				}
			if (mode == 0) {
				assert_true(pieces == 0 && draws[1][0] == 1);
			} else if (frame == 0) {
				if (pieces <= 3 || draws[1][0] + draws[1][1] + draws[1][2] > 0)
					fail_msg("mode %d: %u pieces, %u, %u and %u levels", mode, pieces, draws[1][0], draws[1][1],
					         draws[1][2]);
				assert_int_equal(draws[0][mode == 3 ? 2 : 0], pieces);
			} else if (mode == 1) {
				assert_true(pieces == 0 && draws[1][0] == 1);
			} else {
				assert_true(draws[1][1] == 1 && draws[0][1] == pieces && pieces > 0);
			}
		}
		stilb_render_destroy(render);
	}
	stilb_job_pool_destroy(pool);
}

/* Clusters have the colour of their depth, levels those behind the deepest. */
static void colours_tell_depths(void **state)
{
	(void)state;
	static drawn list[MOST_DRAWS];
	stilb_job_pool *pool = make_pool(0);
	stilb_render *render = make_render(STILB_RENDER_REPLAY_INDIRECT, 0);
	uint32_t first = render->resources.meshes[stilb_render_scene_mesh(render, 0).id & RENDER_INDEX_MASK].first_index;
	const float at[3] = {0.0f, 0.3f, 5.0f};
	uint32_t seen[8] = {0};
	stilb_render_view view = look(at, 0.0f, 0.0f, 1.5f, 1.5f);
	view.show = STILB_RENDER_SHOW_LEVELS;
	draw(render, &view, pool);
	uint32_t count = drawn_list(render, list);
	for (uint32_t i = 0; i < count; i++) {
		uint32_t detail = render_command_detail(list[i].command);
		assert_int_equal(list[i].kind, 3);
		if (list[i].model >= 4)
			continue;
		uint32_t begin = list[i].command->first_index - first, depth = 0;
		for (uint32_t c = 0; c < torus.cluster_count; c++) {
			const stilb_scene_cluster *cluster = &torus.clusters[c];
			if (cluster->from != STILB_SCENE_NONE && torus.index_count + cluster->first_index == begin)
				depth = cluster->from < 64 ? 1 : cluster->from < 80 ? 2 : 3;
		}
		assert_int_equal(detail, depth + 1);
		seen[detail]++;
	}
	assert_true(seen[1] > 0 && seen[2] > 0 && seen[3] > 0);
	const float far[3] = {500.0f, 0.0f, 0.0f};
	view = look(far, 0.0f, 0.0f, 0.8f, 0.5f);
	view.show = STILB_RENDER_SHOW_LEVELS;
	for (int off = 0; off < 2; off++) {
		view.detail.mode = off ? STILB_RENDER_DETAIL_OFF : STILB_RENDER_DETAIL_POP;
		draw(render, &view, pool);
		count = drawn_list(render, list);
		for (uint32_t i = 0; i < count; i++)
			assert_true(list[i].model != 5 || render_command_detail(list[i].command) == (off ? 1u : 3u + 2u));
		assert_true(!off || count == MODELS);
	}
	stilb_render_destroy(render);
	stilb_job_pool_destroy(pool);
}

/* ---- the same everywhere ----------------------------------------------------------------------------------------- */

static void streams_do_not_depend_on_workers(void **state)
{
	(void)state;
	static const uint32_t workers[] = {0, 1, 3};
	uint64_t first[6] = {0};
	for (uint32_t w = 0; w < 9; w++) {
		stilb_job_pool *pool = make_pool(workers[w % 3]);
		stilb_render *render = make_render((stilb_render_replay_mode)(w / 3), workers[w % 3]);
		for (uint32_t f = 0; f < 6; f++) {
			const float at[3] = {0.3f, 1.0f, 4.0f + (float)(f * f)};
			stilb_render_view view = look(at, 0.1f, -0.1f, 0.9f, 0.5f);
			view.detail.mode = f < 3 ? STILB_RENDER_DETAIL_FADE : STILB_RENDER_DETAIL_MORPH;
			draw(render, &view, pool);
			uint64_t hash = stilb_render_stream_hash(render);
			assert_true(w == 0 || hash == first[f]);
			first[f] = hash;
			for (uint32_t before = 0; before < f && w == 0; before++)
				assert_true(first[before] != hash);
		}
		stilb_render_destroy(render);
		stilb_job_pool_destroy(pool);
	}
}

/* Draws of as many triangles, but others, have different streams. */
static void the_stream_tells_which(void **state)
{
	(void)state;
	static const stilb_render_pass pass = {.name = "scene"};
	static const uint32_t firsts[4] = {0, 96, INDICES - 96, INDICES};
	stilb_job_pool *pool = make_pool(0);
	stilb_render *render = make_render(STILB_RENDER_REPLAY_INDIRECT, 0);
	stilb_render_view view = view_any();
	uint64_t hash[4];
	for (int i = 0; i < 4; i++) {
		stilb_render_context *context = stilb_render_context_get(render, 0);
		assert_int_equal(stilb_render_frame_begin(render), STILB_OK);
		assert_int_equal(stilb_render_pass_begin(render, 0, 1), STILB_OK);
		stilb_render_segment_begin(context, 0, 0);
		render_draw_clusters(context, 0, stilb_render_scene_mesh(render, 0), render->scene.materials[0], &places[0],
		                     (render_cluster_range){firsts[i], 96, 0}, 0, 0);
		stilb_render_segment_end(context);
		assert_int_equal(stilb_render_pass_end(render, 0), STILB_OK);
		assert_int_equal(stilb_render_replay(render, &pass, 1, &view, 1, pool, 0), STILB_OK);
		hash[i] = stilb_render_stream_hash(render);
		for (int before = 0; before < i; before++)
			assert_true(hash[before] != hash[i]);
	}
	stilb_render_destroy(render);
	stilb_job_pool_destroy(pool);
}

static void dumps_hold_clusters(void **state)
{
	(void)state;
	char path[64];
	snprintf(path, sizeof path, "/tmp/test_render_clusters_%d.dump", (int)getpid());
	stilb_job_pool *pool = make_pool(1);
	static const stilb_render_pass pass = {.name = "scene"};
	for (int mode = 0; mode < 5; mode++) {
		stilb_render *render = make_render(STILB_RENDER_REPLAY_INDIRECT, 1), *played;
		const float at[2][3] = {{500.0f, 0.0f, -886.0f}, {500.0f, 0.0f, -705.0f}};
		stilb_render_view view = {0};
		for (int f = 0; f < 2; f++) {
			view = look(at[f], 0.0f, 0.0f, 1.8f, 0.5f);
			view.detail.mode = (stilb_render_detail_mode)(mode % 4);
			view.show = mode == 4 ? STILB_RENDER_SHOW_LEVELS : STILB_RENDER_SHOW_SHADED;
			draw(render, &view, pool);
		}
		if (stilb_render_dump_save(render, &pass, 1, &view, 1, path) != STILB_OK)
			fail_msg("%s", stilb_error_message());
		uint64_t hash = stilb_render_stream_hash(render), triangles = stilb_render_triangles(render);
		stilb_render_destroy(render);
		stilb_render_dump *dump;
		if (stilb_render_dump_load(path, &dump) != STILB_OK)
			fail_msg("%s", stilb_error_message());
		stilb_render_desc desc = {
			.device = STILB_RENDER_DEVICE_NULL, .width = WIDTH, .height = HEIGHT, .context_count = 2};
		assert_int_equal(stilb_render_create(&desc, &played), STILB_OK);
		assert_int_equal(stilb_render_dump_upload(dump, played), STILB_OK);
		assert_int_equal(stilb_render_frame_begin(played), STILB_OK);
		assert_int_equal(stilb_render_dump_record(dump, played, pool, 0), STILB_OK);
		assert_int_equal(stilb_render_dump_replay(dump, played, pool, 0), STILB_OK);
		assert_true(stilb_render_stream_hash(played) == hash);
		assert_true(stilb_render_triangles(played) == triangles);
		stilb_render_destroy(played);
		stilb_render_dump_destroy(dump);
	}
	remove(path);
	stilb_job_pool_destroy(pool);
}

static void refuses(stilb_render *render, const stilb_scene_mesh *mesh, const char *words)
{
	stilb_render_mesh made;
	assert_int_equal(stilb_render_mesh_create(render, mesh, &made), STILB_ERROR_ARGUMENT);
	if (!strstr(stilb_error_message(), words))
		fail_msg("'%s' does not say '%s'", stilb_error_message(), words);
}

static void wrong_clusters_are_refused(void **state)
{
	(void)state;
	stilb_render *render = make_render(STILB_RENDER_REPLAY_INDIRECT, 0);
	stilb_scene_mesh mesh = torus_make();
	stilb_scene_cluster before = mesh.clusters[300];
	mesh.clusters[300].from = TORUS_GROUPS - 1;
	refuses(render, &mesh, "cluster 300 of a mesh, in group ");
	mesh.clusters[300] = before;
	mesh.clusters[300].first_index = mesh.cluster_index_count - 3;
	refuses(render, &mesh, "cluster 300 of a mesh, in group ");
	mesh.clusters[300] = before;
	mesh.groups[1].first_cluster++;
	refuses(render, &mesh, "group 1 of a mesh has 4 clusters from 5 on, not from 4");
	mesh.groups[1].first_cluster--;
	mesh.cluster_count++;
	refuses(render, &mesh, "the groups of a mesh have");
	mesh.cluster_count--;
	mesh.cluster_indices[7] = mesh.vertex_count;
	refuses(render, &mesh, "index 7 of the clusters of a mesh is vertex 4096, but it has 4096");
	mesh.cluster_indices[7] = 0;
	/* Made and destroyed again and again, the heaps do not grow. */
	uint32_t size = 0;
	for (uint32_t frame = 0; frame < 20; frame++) {
		stilb_render_mesh made;
		assert_int_equal(stilb_render_mesh_create(render, &mesh, &made), STILB_OK);
		stilb_render_mesh_destroy(render, made);
		for (int i = 0; i < 3; i++)
			assert_int_equal(stilb_render_frame_begin(render), STILB_OK);
		assert_true(frame < 3 || render->resources.heaps[RENDER_HEAP_INDICES].size == size);
		size = render->resources.heaps[RENDER_HEAP_INDICES].size;
	}
	stilb_scene_mesh_finish(&mesh);
	stilb_render_destroy(render);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(the_rule_says_what_is_drawn), cmocka_unit_test(cuts_are_closed),
		cmocka_unit_test(the_cut_is_monotone),         cmocka_unit_test(backs_are_backs),
		cmocka_unit_test(views_without_perspective),   cmocka_unit_test(levels_come_after_clusters),
		cmocka_unit_test(colours_tell_depths),         cmocka_unit_test(streams_do_not_depend_on_workers),
		cmocka_unit_test(the_stream_tells_which),      cmocka_unit_test(dumps_hold_clusters),
		cmocka_unit_test(wrong_clusters_are_refused),
	};
	return cmocka_run_group_tests(tests, scene_make, scene_free);
}
