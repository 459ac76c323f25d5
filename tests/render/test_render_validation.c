/* The validation layer with synchronization checks gives no message for any kind of frame; a message makes the program
 * fail; without the layer --validate is an error. The first argument is the stilb program. */
#include "engine_internal.h"
#include "gpu/vulkan/gpu_vulkan_internal.h"
#include "render/render_internal.h"
#include "support/picture_reference.h"
#include "tests/engine/stress_engine.h"

#include <sys/wait.h>

static const char *stilb_program;

/* What start shows; validated sets it. */
static stress_engine stress;

static stilb_engine_desc validated(void)
{
	stress = (stress_engine){.models = 300, .seed = 1, .animate = true};
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.workers = 2;
	desc.width = 80;
	desc.height = 60;
	desc.validate = true;
	return desc;
}

static stilb_engine *start(const stilb_engine_desc *desc)
{
	stilb_engine *engine;
	if (stress_engine_create(desc, &stress, &engine) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return engine;
}

static void frames(stilb_engine *engine, int count)
{
	stilb_engine_report report;
	for (int i = 0; i < count; i++)
		assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
}

/* Reads the picture twice; both are equal. */
static void read_twice(stilb_engine *engine)
{
	stilb_image first = {0}, second = {0};
	uint32_t width, height;
	stilb_engine_size(engine, &width, &height);
	assert_int_equal(stilb_render_read_image(engine->render, &first), STILB_OK);
	assert_int_equal(stilb_render_read_image(engine->render, &second), STILB_OK);
	assert_int_equal(first.width, width);
	assert_int_equal(first.height, height);
	assert_memory_equal(first.pixels, second.pixels, stilb_image_size(&first));
	stilb_image_finish(&first);
	stilb_image_finish(&second);
}

/* Messages during destruction cannot be counted here: the_program_fails counts them on stderr. */
static void finish(stilb_engine *engine)
{
	double gpu_ms;
	assert_int_equal(stilb_engine_wait(engine, &gpu_ms), STILB_OK);
	assert_int_equal(stilb_engine_validation_messages(engine), 0);
	stress_engine_destroy(engine);
}

/* Resources besides the scene's: new ones are created, then the old ones destroyed. */
typedef struct extras {
	stilb_render_mesh mesh;
	stilb_render_texture texture;
	stilb_render_material material;
} extras;

static void extras_renew(stilb_engine *engine, extras *e)
{
	stilb_render *render = engine->render;
	const stilb_scene *scene = stilb_engine_scene(engine);
	stilb_image image;
	extras made;
	assert_int_equal(stilb_image_create(&image, 8, 4, 3, STILB_IMAGE_U8_SRGB), STILB_OK);
	assert_int_equal(stilb_render_mesh_create(render, &scene->meshes[0], &made.mesh), STILB_OK);
	assert_int_equal(stilb_render_texture_create(render, &image, &made.texture), STILB_OK);
	assert_int_equal(stilb_render_material_create(render, &scene->materials[0], made.texture, &made.material),
	                 STILB_OK);
	stilb_image_finish(&image);
	stilb_render_material_destroy(render, e->material);
	stilb_render_texture_destroy(render, e->texture);
	stilb_render_mesh_destroy(render, e->mesh);
	*e = made;
}

/* Every replay mode with every way of binding materials, twice, with other settings varied. */
static void frames_of_every_kind(void **state)
{
	(void)state;
	for (int kind = 0; kind < 18; kind++) {
		stilb_engine_desc desc = validated();
		extras e = {{0}, {0}, {0}};
		desc.replay = (stilb_render_replay_mode)(kind % 3);
		desc.materials = (stilb_render_materials)(kind / 3 % 3);
		desc.present = kind < 9;
		desc.samples = kind & 1 ? 4 : 1;
		desc.output = kind & 2 ? STILB_RENDER_OUTPUT_LINEAR : STILB_RENDER_OUTPUT_DISPLAY;
		stilb_engine *engine = start(&desc);
		for (int f = 0; f < 6; f++) {
			extras_renew(engine, &e);
			frames(engine, 1);
			if (f == 3)
				assert_int_equal(stilb_engine_resize(engine, 90, 50), STILB_OK);
		}
		read_twice(engine);
		frames(engine, 2);
		finish(engine);
	}
}

static void other_sizes_between_frames(void **state)
{
	(void)state;
	static const uint32_t sizes[][2] = {{1, 1}, {200, 40}, {33, 257}, {80, 60}};
	for (uint32_t samples = 1; samples <= 4; samples += 3) {
		stilb_engine_desc desc = validated();
		desc.samples = samples;
		stilb_engine *engine = start(&desc);
		stilb_image image = {0};
		for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
			frames(engine, 3);
			assert_int_equal(stilb_engine_resize(engine, sizes[s][0], sizes[s][1]), STILB_OK);
			assert_int_equal(stilb_render_read_image(engine->render, &image), STILB_ERROR_DEVICE);
			frames(engine, 2);
			read_twice(engine);
		}
		finish(engine);
	}
}

static void rows_and_passes_that_grow(void **state)
{
	(void)state;
	stilb_engine_desc desc = validated();
	stress.models = 18000; /* more rows than a new frame's memory holds */
	desc.width = desc.height = 16;
	stilb_engine *engine = start(&desc);
	frames(engine, 2);
	engine->passes[1] = (stilb_render_pass){.name = "again", .view = 0, .order = 1};
	engine->pass_count = 2;
	frames(engine, 2);
	read_twice(engine);
	finish(engine);
}

static void nothing_to_see(void **state)
{
	(void)state;
	stilb_engine_desc desc = validated();
	stilb_engine_report report;
	stilb_engine *engine = start(&desc);
	stilb_engine_scene(engine)->camera.pitch = 1.5f; /* into the sky */
	assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
	assert_int_equal(report.visible, 0);
	frames(engine, 3);
	read_twice(engine);
	finish(engine);
}

static void a_picture_before_the_first_frame(void **state)
{
	(void)state;
	stilb_engine_desc desc = validated();
	stilb_engine *engine = start(&desc);
	stilb_image image = {0};
	assert_int_equal(stilb_render_read_image(engine->render, &image), STILB_ERROR_DEVICE);
	assert_null(image.pixels);
	frames(engine, 1);
	read_twice(engine);
	finish(engine);
}

/* ---- frames that fail -------------------------------------------------------------------------------------------- */

static const gpu_functions *real_functions;
static bool recorded; /* the frame is recorded, and then not given to the GPU; else it is not even recorded */

static stilb_result failing_run(stilb_gpu *gpu, const stilb_gpu_plan *plan, const stilb_gpu_draws *lists,
                                uint32_t list_count, const stilb_gpu_threads *threads, const gpu_upload_ready *uploads,
                                uint32_t upload_count)
{
	gpu->keep_back = true;
	stilb_result result =
		recorded ? real_functions->run(gpu, plan, lists, list_count, threads, uploads, upload_count) : STILB_OK;
	gpu->keep_back = false;
	return result == STILB_OK ? stilb_fail(STILB_ERROR_MEMORY, "no memory for this pass") : result;
}

static void frames_that_break_off_harm_no_other(void **state)
{
	(void)state;
	stilb_engine_desc desc = validated();
	stilb_engine_report report;
	stilb_engine *engine = start(&desc);
	engine->passes[1] = (stilb_render_pass){.name = "again", .view = 0, .order = 1};
	engine->pass_count = 2;
	stilb_gpu *gpu = engine->render->device->gpu;
	real_functions = gpu->functions;
	gpu_functions failing = *real_functions;
	failing.run = failing_run;
	frames(engine, 1);
	for (int good = 0; good < 4; good++) {
		stilb_image image = {0};
		recorded = good % 2;
		gpu->functions = &failing;
		assert_int_equal(stilb_engine_frame(engine, &report), STILB_ERROR_MEMORY);
		gpu->functions = real_functions;
		assert_int_equal(stilb_render_read_image(engine->render, &image), STILB_ERROR_DEVICE);
		frames(engine, 1 + good);
		read_twice(engine);
	}
	finish(engine);
}

/* ---- limits ------------------------------------------------------------------------------------------------------ */

/* A size beyond the GPU's limit is refused before the driver gets it, and a valid size works afterwards. */
static void too_large_a_picture(void **state)
{
	(void)state;
	stilb_engine_desc desc = validated();
	stilb_engine_report report;
	stilb_engine *engine = start(&desc);
	frames(engine, 1);
	stilb_gpu_limits *limits = &engine->render->device->gpu->limits;
	uint32_t real_side = limits->attachment_side;
	limits->attachment_side = 4096; /* the limit of smaller GPUs */
	assert_int_equal(stilb_engine_resize(engine, 4097, 60), STILB_ERROR_DEVICE);
	assert_non_null(strstr(stilb_error_message(), "4096x"));
	assert_non_null(strstr(stilb_error_message(), "--size"));
	assert_int_equal(stilb_engine_frame(engine, &report), STILB_ERROR_DEVICE); /* nothing to draw into */
	limits->attachment_side = real_side;
	assert_int_equal(stilb_engine_resize(engine, 90, 60), STILB_OK);
	frames(engine, 3);
	read_twice(engine);
	finish(engine);
}

/* A GPU with a small maxDrawIndirectCount gets several commands for one range; the picture is the same. */
static void few_draws_a_command(void **state)
{
	(void)state;
	stilb_engine_desc desc = validated();
	stilb_engine_report report;
	stress.animate = false;
	desc.workers = 0; /* one range of commands */
	stilb_engine *engine = start(&desc);
	stilb_image whole = {0}, cut = {0};
	assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
	assert_int_equal(report.render.indirect_commands, 1);
	assert_int_equal(stilb_render_read_image(engine->render, &whole), STILB_OK);
	((gpu_vulkan *)engine->render->device->gpu)->properties.limits.maxDrawIndirectCount = 7;
	assert_int_equal(stilb_engine_frame(engine, &report), STILB_OK);
	assert_int_equal(report.render.draws, 600);
	assert_int_equal(report.render.indirect_commands, (600 + 6) / 7);
	assert_int_equal(stilb_render_read_image(engine->render, &cut), STILB_OK);
	assert_memory_equal(whole.pixels, cut.pixels, stilb_image_size(&whole));
	stilb_image_finish(&whole);
	stilb_image_finish(&cut);
	finish(engine);
}

/* Clocks with few bits wrap; the time between two of their readings does not. */
static void a_short_clock_wraps(void **state)
{
	(void)state;
	stilb_engine_desc desc = validated();
	stilb_engine *engine = start(&desc);
	gpu_vulkan *gpu = (gpu_vulkan *)engine->render->device->gpu;
	double gpu_ms;
	assert_true(gpu->timestamp_mask != 0);
	for (uint32_t bits = 64; bits >= 36; bits -= 28) {
		gpu->timestamp_mask = UINT64_MAX >> (64 - bits);
		frames(engine, 3);
		assert_int_equal(stilb_engine_wait(engine, &gpu_ms), STILB_OK);
		assert_true(gpu_ms > 0.0 && gpu_ms < 60000.0);
	}
	finish(engine);
}

/* ---- messages ---------------------------------------------------------------------------------------------------- */

static void a_bad_argument_is_seen(void **state)
{
	(void)state;
	stilb_engine_desc desc = validated();
	stilb_engine *engine = start(&desc);
	gpu_vulkan *gpu = (gpu_vulkan *)engine->render->device->gpu;
	VkBufferCreateInfo nothing = {.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, .size = 16, .usage = 0};
	VkBuffer buffer = VK_NULL_HANDLE;
	vkCreateBuffer(gpu->device, &nothing, NULL, &buffer);
	vkDestroyBuffer(gpu->device, buffer, NULL);
	assert_true(stilb_engine_validation_messages(engine) > 0);
	assert_true(stilb_render_validation_messages(engine->render) > 0);
	stress_engine_destroy(engine);
}

/* Two writes to the same bytes without a barrier: only the synchronization checks find that. */
static void a_missing_barrier_is_seen(void **state)
{
	(void)state;
	stilb_engine_desc desc = validated();
	stilb_engine *engine = start(&desc);
	gpu_vulkan *gpu = (gpu_vulkan *)engine->render->device->gpu;
	VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
	VkCommandBuffer commands = gpu->slots[0].show;
	gpu_vulkan_buffer buffer;
	assert_int_equal(
		gpu_vulkan_buffer_create(gpu, 64, VK_BUFFER_USAGE_TRANSFER_DST_BIT, STILB_GPU_MEMORY_DEVICE, &buffer),
		STILB_OK);
	vkBeginCommandBuffer(commands, &begin);
	vkCmdFillBuffer(commands, buffer.buffer, 0, 64, 1);
	assert_int_equal(stilb_engine_validation_messages(engine), 0);
	vkCmdFillBuffer(commands, buffer.buffer, 0, 64, 2);
	vkEndCommandBuffer(commands);
	assert_true(stilb_engine_validation_messages(engine) > 0);
	gpu_vulkan_buffer_destroy(gpu, &buffer);
	stress_engine_destroy(engine);
}

/* Runs stilb demo with further arguments; words: its stderr. */
static int run_demo(const char *environment, const char *flags, char *words, size_t size)
{
	char command[4096];
	snprintf(command, sizeof command, "%s '%s' demo --headless --frames 3 --models 50 --size 64x48 %s 2>&1 >/dev/null",
	         environment, stilb_program, flags);
	FILE *pipe = popen(command, "r");
	assert_non_null(pipe);
	size_t length = fread(words, 1, size - 1, pipe);
	words[length] = '\0';
	while (fgetc(pipe) != EOF)
		continue;
	return WEXITSTATUS(pclose(pipe));
}

/* The layer's best-practices checks are on, so that a correct program gets messages, too. */
static void a_message_fails_the_program(void **state)
{
	(void)state;
	const char *strict = "VK_LAYER_ENABLES=VK_VALIDATION_FEATURE_ENABLE_BEST_PRACTICES_EXT";
	char words[1 << 16];
	assert_int_equal(run_demo("", "--validate", words, sizeof words), 0);
	assert_string_equal(words, ""); /* also none at exit */
	assert_int_equal(run_demo("", "--validate --replay direct --msaa 4 --animate", words, sizeof words), 0);
	assert_string_equal(words, "");
	assert_int_equal(run_demo("", "--validate --replay secondary --materials bind", words, sizeof words), 0);
	assert_string_equal(words, "");
	assert_int_equal(run_demo(strict, "--validate", words, sizeof words), 1);
	assert_non_null(strstr(words, "stilb: validation: "));
	assert_non_null(strstr(words, "stilb: the validation layer had "));
	assert_int_equal(run_demo(strict, "", words, sizeof words), 0);
}

static const char *const *no_extensions(void *user, uint32_t *count)
{
	(void)user;
	*count = 0;
	return NULL;
}

static int32_t no_surface(void *user, void *instance, uint64_t *surface)
{
	(void)user, (void)instance, (void)surface;
	return VK_ERROR_INITIALIZATION_FAILED;
}

/* The result that lets a program continue without a window. */
static void a_window_without_a_surface(void **state)
{
	(void)state;
	stilb_gpu_surface surface = {NULL, no_extensions, no_surface};
	stilb_render_desc desc = {.surface = &surface, .width = 64, .height = 48, .context_count = 1, .validate = true};
	stilb_render *render;
	assert_int_equal(stilb_render_create(&desc, &render), STILB_ERROR_WINDOW);
	assert_null(render);
	assert_non_null(strstr(stilb_error_message(), "surface for the window"));
}

/* True if the program has a driver's library loaded; that of the loader is libvulkan.so. */
static bool has_driver(void)
{
	char line[4096];
	bool found = false;
	FILE *maps = fopen("/proc/self/maps", "r");
	assert_non_null(maps);
	while (!found && fgets(line, sizeof line, maps))
		found = strstr(line, "/libvulkan_") && !strstr(line, "/libvulkan.so");
	fclose(maps);
	return found;
}

static void without_the_layer(void **state)
{
	(void)state;
	stilb_engine_desc desc = validated();
	stilb_engine *engine;
	char words[4096];
	assert_int_equal(run_demo("VK_LAYER_PATH=/nonexistent", "--validate", words, sizeof words), 2);
	assert_non_null(strstr(words, "stilb: "));
	assert_non_null(strstr(words, "vulkan-validationlayers"));
	setenv("VK_LAYER_PATH", "/nonexistent", 1);
	assert_int_equal(stress_engine_create(&desc, &stress, &engine), STILB_ERROR_DEVICE);
	assert_null(engine);
	desc.validate = false;
	engine = start(&desc);
	frames(engine, 1);
	assert_true(has_driver());
	stress_engine_destroy(engine);
	unsetenv("VK_LAYER_PATH");
	assert_true(has_driver()); /* for the next engine: some cannot be loaded again */
}

int main(int argc, char **argv)
{
	if (reference_no_driver())
		return 77;
	if (argc != 2) {
		fprintf(stderr, "usage: test_render_validation STILB\n");
		return 2;
	}
	stilb_program = argv[1];
	struct CMUnitTest tests[] = {
		cmocka_unit_test(frames_of_every_kind),
		cmocka_unit_test(other_sizes_between_frames),
		cmocka_unit_test(rows_and_passes_that_grow),
		cmocka_unit_test(nothing_to_see),
		cmocka_unit_test(a_picture_before_the_first_frame),
		cmocka_unit_test(frames_that_break_off_harm_no_other),
		cmocka_unit_test(too_large_a_picture),
		cmocka_unit_test(few_draws_a_command),
		cmocka_unit_test(a_short_clock_wraps),
		cmocka_unit_test(a_bad_argument_is_seen),
		cmocka_unit_test(a_missing_barrier_is_seen),
		cmocka_unit_test(a_message_fails_the_program),
		cmocka_unit_test(a_window_without_a_surface),
		cmocka_unit_test(without_the_layer),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
