/* vulkan-bare, a plain Vulkan program with which the suite `record` compares the engine: draws and times frames, and
 * checks the last picture. vulkan_bare.h describes it. */
#include "bench/subjects/vulkan_bare.h"

#include "bench/record/record_child.h"

/* ---- data of a frame --------------------------------------------------------------------------------------------- */

static void write_draws(const bare *b, const bare_frame *frame, const stilb_scene *scene)
{
	bare_row *rows = frame->rows.mapped;
	VkDrawIndexedIndirectCommand *indirect = frame->indirect.mapped;
	for (uint32_t i = 0; i < scene->part_count; i++) {
		const float *m = scene->part_transform[i].m;
		const bare_mesh *mesh = &b->meshes[scene->part_mesh[i]];
		rows[i] = (bare_row){
			.transform = {m[0], m[4], m[8], m[12], m[1], m[5], m[9], m[13], m[2], m[6], m[10], m[14]},
			.material = scene->part_material[i],
		};
		indirect[i] = (VkDrawIndexedIndirectCommand){
			.indexCount = mesh->index_count,
			.instanceCount = 1,
			.firstIndex = mesh->first_index,
			.vertexOffset = mesh->vertex_offset,
			.firstInstance = i,
		};
	}
}

static void write_view(const bare_frame *frame, const stilb_scene *scene)
{
	stilb_mat4 matrix = stilb_scene_camera_matrix(&scene->camera, (float)RECORD_WIDTH / (float)RECORD_HEIGHT);
	bare_view view = {0};
	memcpy(view.view_projection, matrix.m, sizeof view.view_projection);
	memcpy(view.sky, scene->surroundings.sky, 3 * sizeof(float));
	memcpy(view.ground, scene->surroundings.ground, 3 * sizeof(float));
	view.sun[3] = STILB_SCENE_LIGHT_DIRECTIONAL;
	memcpy(&view.sun[4], scene->lights[0].direction, 3 * sizeof(float));
	memcpy(&view.sun[8], scene->lights[0].intensity, 3 * sizeof(float));
	memcpy(frame->view.mapped, &view, sizeof view);
}

/* ---- commands ---------------------------------------------------------------------------------------------------- */

static void draw_all(const bare *b, const bare_frame *frame, const stilb_scene *scene)
{
	bare_push push = {
		.light_count = scene->light_count, /* 1: the stress test's sun */
		.lights = frame->view.address + offsetof(bare_view, sun),
		.view = frame->view.address,
		.rows = frame->rows.address,
		.materials = b->materials.address,
	};
	memcpy(push.camera_position, scene->camera.position, 3 * sizeof(float));
	vkCmdBindPipeline(frame->commands, VK_PIPELINE_BIND_POINT_GRAPHICS, b->pipeline);
	vkCmdPushConstants(frame->commands, b->layout, VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT, 0,
	                   sizeof push, &push);
	vkCmdBindVertexBuffers(frame->commands, 0, 1, &b->vertices.buffer, &(VkDeviceSize){0});
	vkCmdBindIndexBuffer(frame->commands, b->indices.buffer, 0, VK_INDEX_TYPE_UINT32);
	vkCmdDrawIndexedIndirect(frame->commands, frame->indirect.buffer, 0, scene->part_count,
	                         sizeof(VkDrawIndexedIndirectCommand));
}

static void draw_frame(const bare *b, const bare_frame *frame, const stilb_scene *scene)
{
	bare_frame_wait(b, frame);
	write_draws(b, frame, scene);
	write_view(frame, scene);
	bare_frame_begin(b, frame, scene->surroundings.sky);
	draw_all(b, frame, scene);
	bare_frame_end(b, frame);
}

/* ---- the program ------------------------------------------------------------------------------------------------- */

/* The checksum of a finished frame's picture, without alpha. */
static uint64_t picture_sum(const bare *b, const bare_frame *frame)
{
	size_t pixels = (size_t)RECORD_WIDTH * RECORD_HEIGHT;
	bare_frame_wait(b, frame);
	unsigned char *rgb = record_alloc(pixels, 3);
	for (size_t i = 0; i < pixels; i++)
		memcpy(rgb + 3 * i, (const unsigned char *)frame->picture.mapped + 4 * i, 3);
	uint64_t sum = record_picture_sum(rgb, pixels);
	free(rgb);
	return sum;
}

static void measure(const bare *b, const stilb_scene *scene, const bench_child *child)
{
	static record_samples samples;
	record_picture_times times = {0};
	const bare_frame *frame;
	uint64_t until = record_deadline(child->seconds);
	do {
		frame = &b->frames[times.frames % BARE_FRAMES];
		draw_frame(b, frame, scene);
	} while (record_picture_frame(&times, &samples, until));
	record_picture_check(picture_sum(b, frame), child->argument);
	record_picture_print(&times, &samples);
}

/* Draws one frame and prints the upper and lower 24 bits of its checksum, from which the suite's `prepare` makes the
 * reference for all subjects. */
static void show_sum(const bare *b, const stilb_scene *scene)
{
	draw_frame(b, &b->frames[0], scene);
	uint64_t sum = picture_sum(b, &b->frames[0]);
	bench_child_metric("high", (double)(sum >> 24));
	bench_child_metric("low", (double)(sum & 0xffffff));
}

int main(int argc, char **argv)
{
	bench_child child = bench_child_args(argc, argv);
	const record_case *on = record_case_find(child.case_name);
	stilb_scene *scene;
	bare b;
	if (on->materials != RECORD_INDEX || !bare_open(&b))
		return BENCH_CHILD_SKIP;
	if (stilb_scene_create_stress(on->models, 1, &scene) != STILB_OK)
		bench_child_fail("%s", stilb_error_message());
	bare_prepare(&b, scene, RECORD_WIDTH, RECORD_HEIGHT);
	if (child.argument)
		measure(&b, scene, &child);
	else
		show_sum(&b, scene);
	bare_close(&b);
	stilb_scene_destroy(scene);
	return 0;
}
