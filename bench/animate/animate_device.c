/* The subject `device` of the suite `animate`: the same vertices carried by a compute shader, on the device that the
 * engine would take. A frame begins with the joints in the CPU's memory and ends with the vertices in the device's. All
 * of them are compared with those that jobs make. */
#include "bench/animate/animate_cases.h"
#include "bench/animate/animate_scene.h"
#include "bench/harness/bench_child.h"
#include "gpu/gpu.h"
#include "scene/edit/scene_edit.h"
#include "scene/play/scene_play_internal.h"

#include <math.h>
#include <string.h>

static const uint32_t skin_comp[] =
#include "skin.comp.inc"
	;

#define GROUP 64u         /* vertices of a work group, as in the shader */
#define MOST_FIGURES 100u /* of which buffers hold the vertices: 32 MB */

/* As in the shader. */
typedef struct device_vertex {
	float position[3], u, normal[3], v, weights[4];
	uint32_t joints[4];
} device_vertex;

typedef struct device {
	stilb_gpu *gpu;
	stilb_gpu_plan *plan;
	stilb_gpu_program program;
	stilb_gpu_buffer rest, joints, posed;
	uint32_t figures, joint_count, vertices;
} device;

static stilb_gpu_buffer make_buffer(stilb_gpu *gpu, const char *name, uint64_t bytes, stilb_gpu_memory memory)
{
	stilb_gpu_buffer buffer;
	uint32_t uses = STILB_GPU_BUFFER_ADDRESS | STILB_GPU_BUFFER_COPY;
	animate_check(stilb_gpu_buffer_create(
		gpu, &(stilb_gpu_buffer_desc){.name = name, .bytes = bytes, .memory = memory, .uses = uses}, &buffer));
	return buffer;
}

static void write_rest(const device *d, const stilb_scene *scene)
{
	const stilb_scene_deform *deform = &scene->animation->deforms[0];
	const play_rest *rest = &scene->figures->shared.rests[0];
	device_vertex *to = stilb_gpu_buffer_mapped(d->gpu, d->rest);
	for (uint32_t v = 0; v < d->vertices; v++) {
		to[v] = (device_vertex){.u = *play_stream(rest, PLAY_UV, v), .v = *play_stream(rest, PLAY_UV + 1, v)};
		for (uint32_t i = 0; i < 3; i++) {
			to[v].position[i] = *play_stream(rest, PLAY_POSITION + i, v);
			to[v].normal[i] = *play_stream(rest, PLAY_NORMAL + i, v);
		}
		for (uint32_t i = 0; i < 4; i++) {
			to[v].weights[i] = deform->weights[4 * v + i];
			to[v].joints[i] = deform->joints[4 * v + i];
		}
	}
}

static device open_device(const stilb_scene *scene, uint32_t figures, uint32_t joints, uint32_t vertices)
{
	device d = {.figures = figures, .joint_count = joints, .vertices = vertices};
	if (stilb_gpu_create(&(stilb_gpu_desc){.upload_bytes = 1u << 20}, &d.gpu) != STILB_OK) {
		fprintf(stderr, "%s\n", stilb_error_message());
		exit(BENCH_CHILD_SKIP);
	}
	d.plan = stilb_gpu_plan_create();
	if (!d.plan)
		bench_child_fail("no memory");
	stilb_gpu_program_desc desc = {.name = "skin", .compute = {.words = skin_comp, .bytes = sizeof skin_comp}};
	animate_check(stilb_gpu_program_create(d.gpu, &desc, &d.program));
	d.rest = make_buffer(d.gpu, "rest", vertices * sizeof(device_vertex), STILB_GPU_MEMORY_WRITE);
	d.joints = make_buffer(d.gpu, "joints", (uint64_t)figures * joints * sizeof(play_rows), STILB_GPU_MEMORY_WRITE);
	d.posed =
		make_buffer(d.gpu, "posed", (uint64_t)figures * vertices * sizeof(stilb_scene_vertex), STILB_GPU_MEMORY_DEVICE);
	write_rest(&d, scene);
	return d;
}

static uint16_t add_buffer(const device *d, const char *name, stilb_gpu_buffer buffer, uint64_t bytes, bool output)
{
	return stilb_gpu_plan_buffer(
		d->plan, &(stilb_gpu_plan_buffer_row){.name = name, .bytes = bytes, .owned = buffer.id, .output = output});
}

/* Hands over the joints, carries all vertices, and waits for them. Returns the number of their buffer in the plan. */
static uint16_t run_frame(const device *d, const stilb_scene *scene)
{
	play_rows *joints = stilb_gpu_buffer_mapped(d->gpu, d->joints);
	uint64_t joint_bytes = d->joint_count * sizeof *joints;
	animate_check(stilb_gpu_frame_begin(d->gpu));
	for (uint32_t f = 0; f < d->figures; f++)
		memcpy(joints + (size_t)f * d->joint_count, scene->figures->figures[f].joints, joint_bytes);
	stilb_gpu_plan_begin(d->plan, 16, 16);
	uint16_t rest = add_buffer(d, "rest", d->rest, d->vertices * sizeof(device_vertex), false);
	uint16_t turned = add_buffer(d, "joints", d->joints, d->figures * joint_bytes, false);
	uint16_t posed =
		add_buffer(d, "posed", d->posed, (uint64_t)d->figures * d->vertices * sizeof(stilb_scene_vertex), true);
	stilb_gpu_pass pass = {.name = "skin",
	                       .kind = STILB_GPU_PASS_DISPATCH,
	                       .program = d->program.id,
	                       .groups = {(d->vertices + GROUP - 1) / GROUP, d->figures, 1},
	                       .uses = {{.resource = rest, .how = STILB_GPU_USE_STORAGE_READ, .slot = 0},
	                                {.resource = turned, .how = STILB_GPU_USE_STORAGE_READ, .slot = 8},
	                                {.resource = posed, .how = STILB_GPU_USE_STORAGE_WRITE, .slot = 16}},
	                       .use_count = 3,
	                       .constant_bytes = 32};
	memcpy(pass.constants + 24, (uint32_t[2]){d->vertices, d->joint_count}, 8);
	stilb_gpu_plan_pass(d->plan, &pass);
	stilb_gpu_planner planner = stilb_gpu_planner_of(d->gpu);
	animate_check(stilb_gpu_plan_make(d->plan, &planner));
	animate_check(stilb_gpu_frame_run(d->gpu, d->plan, NULL, 0, NULL));
	animate_check(stilb_gpu_wait(d->gpu));
	return posed;
}

/* Compares the vertices of the last frame with those of the scene. */
static void check_frame(const device *d, const stilb_scene *scene, uint16_t posed)
{
	uint64_t ticket, frame;
	const void *bytes;
	animate_check(stilb_gpu_read_begin(d->gpu, d->plan, posed, 0, 0, &ticket));
	animate_check(stilb_gpu_read_get(d->gpu, ticket, true, &bytes, &frame));
	const stilb_scene_vertex *shown = bytes;
	for (uint32_t f = 0; f < d->figures; f++) {
		const stilb_scene_vertex *right = scene->meshes[scene->figures->figures[f].meshes[0].mesh].vertices;
		for (uint32_t v = 0; v < d->vertices; v++, shown++, right++)
			for (int i = 0; i < 3; i++)
				if (!(fabsf(shown->position[i] - right->position[i]) < 6e-5f) || /* 1e-5 of their length */
				    !(fabsf(shown->normal[i] - right->normal[i]) < 1e-4f))
					bench_child_fail("figure %u, vertex %u: the device makes (%g %g %g) of it, jobs (%g %g %g)", f, v,
					                 (double)shown->position[0], (double)shown->position[1], (double)shown->position[2],
					                 (double)right->position[0], (double)right->position[1],
					                 (double)right->position[2]);
	}
	stilb_gpu_read_end(d->gpu, ticket);
}

static void run(const bench_child *child, uint32_t figures, uint32_t joints, uint32_t vertices, bool torn)
{
	figures = figures < MOST_FIGURES ? figures : MOST_FIGURES;
	stilb_scene *scene = animate_scene(figures, joints, vertices, torn);
	device d = open_device(scene, figures, joints, vertices);
	double cpu = (double)INFINITY;
	uint64_t end = bench_child_now_ns() + (uint64_t)(child->seconds * 1e9);
	for (int i = 0; i < 2 || bench_child_now_ns() < end; i++) {
		stilb_scene_advance(scene, 1.0 / 64, NULL, 0);
		stilb_scene_update_nodes(scene, NULL, 0);
		stilb_scene_changes_clear(scene);
		animate_cpu start = animate_cpu_now();
		uint16_t posed = run_frame(&d, scene);
		cpu = fmin(cpu, (double)(animate_cpu_now().all_ns - start.all_ns));
		if (i < 2)
			check_frame(&d, scene, posed);
	}
	bench_child_metric("cpu", cpu / figures / vertices);
	stilb_gpu_plan_destroy(d.plan);
	stilb_gpu_destroy(d.gpu);
	stilb_scene_destroy(scene);
}

int main(int argc, char **argv)
{
	bench_child child = bench_child_args(argc, argv);
#define CASE(NAME, TITLE, FIGURES, JOINTS, VERTICES, TORN)                                                             \
	if (strcmp(child.case_name, NAME) == 0 && (VERTICES) >= 10000) {                                                   \
		run(&child, FIGURES, JOINTS, VERTICES, TORN);                                                                  \
		return 0;                                                                                                      \
	}
	ANIMATE_CASES(CASE)
#undef CASE
	return BENCH_CHILD_SKIP;
}
