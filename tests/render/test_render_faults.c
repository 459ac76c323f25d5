/* Every allocation fails once, and devices are lost, on the null device and on the GPU. Each fault ends in an error
 * that says what happened, the next frame is drawn completely, and nothing leaks. */
#include "gpu/vulkan/gpu_vulkan_internal.h"
#include "render/render_internal.h"
#include "support/picture_reference.h"

#include <dlfcn.h>
#include <execinfo.h>
#include <inttypes.h>
#include <malloc.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#define SIZE 48u

/* ---- messages of the validation layer, also during destruction --------------------------------------------------- */

static uint32_t messages;

void __wrap_stilb_log(const char *format, ...) __attribute__((format(printf, 1, 2)));
void __wrap_stilb_log(const char *format, ...)
{
	char text[4096];
	va_list values;
	va_start(values, format);
	vsnprintf(text, sizeof text, format, values);
	va_end(values);
	printf("%s\n", text);
	messages += !strstr(text, "validation: VK_ERROR_"); /* lavapipe logs the errors that it returns: no failure */
}

/* ---- the driver's host memory ------------------------------------------------------------------------------------ */

/* Numbers of allocations so far, and of the one that fails; allocations that live. Accessed atomically, since the
 * driver's threads allocate too; relaxed, since the test reads them between trials, when no thread allocates. */
static uint32_t host_allocations, host_fault;
static int32_t host_live;

static void *host_failed_call;

/* The return address in this program of the call into the driver or the layer; NULL outside of such calls. */
static void *driver_call(void)
{
	void *stack[64];
	int depth = backtrace(stack, 64);
	bool inside = false;
	Dl_info self, frame;
	dladdr((void *)(uintptr_t)&driver_call, &self);
	for (int i = 0; i < depth; i++) {
		if (!dladdr(stack[i], &frame) || !frame.dli_fname)
			continue;
		if (strstr(frame.dli_fname, "libvulkan") || strstr(frame.dli_fname, "libVkLayer"))
			inside = true;
		else if (inside && frame.dli_fbase == self.dli_fbase)
			return stack[i];
	}
	return NULL;
}

static bool host_fails(void)
{
	if (__atomic_add_fetch(&host_allocations, 1, __ATOMIC_RELAXED) != host_fault)
		return false;
	host_failed_call = driver_call();
	return true;
}

static VKAPI_ATTR void *VKAPI_CALL host_allocate(void *user, size_t size, size_t alignment,
                                                 VkSystemAllocationScope scope)
{
	(void)user, (void)scope;
	if (size == 0 || host_fails())
		return NULL;
	alignment = alignment < sizeof(void *) ? sizeof(void *) : alignment;
	void *memory = aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
	__atomic_fetch_add(&host_live, memory ? 1 : 0, __ATOMIC_RELAXED);
	return memory;
}

static VKAPI_ATTR void VKAPI_CALL host_free(void *user, void *memory)
{
	(void)user;
	__atomic_fetch_sub(&host_live, memory ? 1 : 0, __ATOMIC_RELAXED);
	free(memory);
}

static VKAPI_ATTR void *VKAPI_CALL host_reallocate(void *user, void *memory, size_t size, size_t alignment,
                                                   VkSystemAllocationScope scope)
{
	if (size == 0) {
		host_free(user, memory);
		return NULL;
	}
	void *grown = host_allocate(user, size, alignment, scope);
	if (!grown || !memory)
		return grown;
	size_t old = malloc_usable_size(memory);
	memcpy(grown, memory, old < size ? old : size);
	host_free(user, memory);
	return grown;
}

static const VkAllocationCallbacks host_allocator = {
	.pfnAllocation = host_allocate,
	.pfnReallocation = host_reallocate,
	.pfnFree = host_free,
};

/* ---- a trial ----------------------------------------------------------------------------------------------------- */

/* A trial runs everything that allocates, with one fault. The call that fails is repeated and must then succeed,
 * because a fault is injected once. */
typedef struct trial {
	stilb_render_desc desc;
	uint32_t far_draws; /* draws outside the view, in the second frame; many make it outgrow its memory */
	stilb_result wanted;
	int errors;
	stilb_render *render;
	stilb_job_pool *pool;
	stilb_scene *scene;
	stilb_render_view view;
	stilb_render_texture texture;
	stilb_render_material material;
	stilb_image picture;
} trial;

typedef stilb_result trial_step(trial *t);

static void trial_must(trial *t, trial_step *step)
{
	stilb_result result = step(t);
	if (result == STILB_OK)
		return;
	t->errors++;
	assert_int_equal(result, t->wanted);
	assert_non_null(strstr(stilb_error_message(), "memory"));
	result = step(t);
	if (result != STILB_OK)
		fail_msg("and again: %s", stilb_error_message());
}

static stilb_result step_create(trial *t)
{
	stilb_result result = stilb_render_create(&t->desc, &t->render);
	assert_true((result == STILB_OK) == !!t->render);
	if (result != STILB_OK)
		t->desc.faults = (stilb_render_faults){0}; /* a new device would count from 1 again */
	return result;
}

static stilb_result step_scene(trial *t)
{
	return stilb_render_set_scene(t->render, t->scene);
}

static stilb_result step_texture(trial *t)
{
	uint8_t codes[16 * 16 * 3];
	memset(codes, 200, sizeof codes);
	stilb_image image = {16, 16, 3, STILB_IMAGE_U8_SRGB, codes, 0};
	return stilb_render_texture_create(t->render, &image, &t->texture);
}

static stilb_result step_material(trial *t)
{
	return stilb_render_material_create(t->render, &t->scene->materials[0], t->texture, &t->material);
}

/* Triangles over the picture, with and without a texture. */
static stilb_result trial_overlay(trial *t, uint32_t pass, uint32_t triangles)
{
	static const stilb_render_vertex_2d corners[3] = {{{4, 4}, {0, 0}, {200, 90, 10, 255}},
	                                                  {{30, 4}, {1, 0}, {20, 90, 210, 128}},
	                                                  {{4, 25}, {0, 1}, {20, 190, 10, 255}}};
	static const uint32_t indices[3] = {0, 1, 2};
	static const float clip[4] = {6, 0, 100, 20};
	stilb_result result = stilb_render_pass_begin(t->render, pass, 1);
	if (result != STILB_OK)
		return result;
	stilb_render_context *context = stilb_render_context_get(t->render, 0);
	stilb_render_segment_begin(context, pass, 0);
	for (uint32_t i = 0; i < triangles; i++)
		stilb_render_draw_2d(context, stilb_render_geometry_2d(context, corners, 3, indices, 3), 3, clip,
		                     i % 2 ? t->texture : (stilb_render_texture){0});
	stilb_render_segment_end(context);
	return stilb_render_pass_end(t->render, pass);
}

/* Two passes draw the scene, one of them sorted, the first part with a texture; a 2D pass draws over them. */
static stilb_result trial_frame(trial *t, uint32_t far_draws)
{
	static const stilb_render_pass passes[3] = {{.name = "main"},
	                                            {.name = "again", .order = 1, .sort = true},
	                                            {.name = "overlay", .kind = STILB_RENDER_PASS_2D}};
	uint32_t model = 0;
	stilb_mat4 away = stilb_mat4_scale_translate(0.01f, 0.0f, -50.0f, 0.0f);
	stilb_result result = stilb_render_frame_begin(t->render);
	if (result == STILB_OK)
		result = stilb_render_record(t->render, 0, t->scene, &model, 1, t->pool, 0);
	if (result == STILB_OK)
		result = stilb_render_pass_begin(t->render, 1, 1);
	if (result != STILB_OK)
		return result;
	stilb_render_context *context = stilb_render_context_get(t->render, 0);
	stilb_render_segment_begin(context, 1, 0);
	for (uint32_t d = 0; d < far_draws; d++)
		stilb_render_draw_with_key(context, d % 7, stilb_render_scene_mesh(t->render, 1), t->material, &away);
	stilb_render_draw_with_key(context, 9, stilb_render_scene_mesh(t->render, 0), t->material,
	                           &t->scene->part_transform[1]);
	stilb_render_segment_end(context);
	result = stilb_render_pass_end(t->render, 1);
	if (result == STILB_OK)
		result = trial_overlay(t, 2, 2 + far_draws / 64);
	if (result == STILB_OK)
		result = stilb_render_replay(t->render, passes, 3, &t->view, 1, t->pool, 0);
	if (result == STILB_OK)
		result = stilb_render_present(t->render);
	return result;
}

static stilb_result step_frame(trial *t)
{
	return trial_frame(t, 0);
}

static stilb_result step_far_frame(trial *t)
{
	return trial_frame(t, t->far_draws);
}

static stilb_result step_resize(trial *t)
{
	return stilb_render_resize(t->render, SIZE, SIZE);
}

static stilb_result step_wait(trial *t)
{
	return stilb_render_wait(t->render);
}

static stilb_result step_picture(trial *t)
{
	if (t->desc.device == STILB_RENDER_DEVICE_NULL)
		return STILB_OK;
	return stilb_render_read_image(t->render, &t->picture);
}

static stilb_scene *trial_scene(void)
{
	stilb_scene *scene = reference_scene(2);
	scene->part_mesh[1] = 1;
	scene->part_transform[1] = stilb_mat4_scale_translate(0.6f, 0.5f, 0.3f, 0.5f);
	reference_set3(scene->surroundings.sky, 0.4f, 0.5f, 0.6f);
	for (int c = 0; c < 3; c++)
		scene->lights[0].intensity[c] = 2.0f;
	for (int p = 0; p < 2; p++)
		reference_set3(scene->materials[p].diffuse, 0.7f, 0.2f + 0.5f * (float)p, 0.1f);
	return scene;
}

static trial trial_make(stilb_render_desc desc, uint32_t far_draws)
{
	trial t = {.desc = desc, .far_draws = far_draws, .wanted = STILB_ERROR_MEMORY, .scene = trial_scene()};
	reference_camera camera = reference_camera_at((dvec){0, 4, 1}, (dvec){0, 0, 0}, (dvec){0, 1, 0}, 2.0, SIZE, SIZE);
	t.desc.width = SIZE + 8;
	t.desc.height = SIZE - 8;
	t.desc.samples = 1;
	t.desc.context_count = 3;
	t.view = (stilb_render_view){.view_projection = reference_matrix(&camera),
	                             .camera_position = {0.0f, 4.0f, 1.0f},
	                             .lights = t.scene->lights,
	                             .light_count = t.scene->light_count,
	                             .surroundings = t.scene->surroundings,
	                             .shading = stilb_render_shading_default()};
	assert_int_equal(stilb_job_pool_create(&(stilb_job_pool_desc){.worker_count = 2}, &t.pool), 0);
	return t;
}

static uint32_t device_allocations; /* that the last trial made */

static void trial_finish(trial *t)
{
	uint32_t before = messages;
	device_allocations = atomic_load_explicit(&t->render->device->gpu->allocations, memory_order_relaxed);
	stilb_render_destroy(t->render);
	assert_int_equal(messages, before);
	stilb_job_pool_destroy(t->pool);
	stilb_scene_destroy(t->scene);
	t->render = NULL;
}

/* Returns how many calls failed. The caller compares the picture with that of a trial without faults. */
static int trial_run(stilb_render_desc desc, uint32_t far_draws, stilb_image *picture)
{
	trial t = trial_make(desc, far_draws);
	trial_must(&t, step_create);
	trial_must(&t, step_scene);
	trial_must(&t, step_texture);
	trial_must(&t, step_material);
	trial_must(&t, step_frame);
	trial_must(&t, step_frame);
	trial_must(&t, step_resize);
	trial_must(&t, step_far_frame);
	trial_must(&t, step_frame);
	trial_must(&t, step_far_frame);
	trial_must(&t, step_wait);
	trial_must(&t, step_picture);
	trial_finish(&t);
	*picture = t.picture;
	return t.errors;
}

static void assert_same_picture(const stilb_image *want, stilb_image *got)
{
	if (want->pixels)
		assert_memory_equal(want->pixels, got->pixels, stilb_image_size(want));
	stilb_image_finish(got);
}

/* ---- memory ------------------------------------------------------------------------------------------------------ */

static const stilb_render_desc ways[] = {
	{.replay = STILB_RENDER_REPLAY_INDIRECT, .validate = true},
	{.replay = STILB_RENDER_REPLAY_SECONDARY, .materials = STILB_RENDER_MATERIALS_BIND, .validate = true},
	{.replay = STILB_RENDER_REPLAY_DIRECT, .materials = STILB_RENDER_MATERIALS_PIPELINE, .validate = true},
	{.replay = STILB_RENDER_REPLAY_INDIRECT, .device = STILB_RENDER_DEVICE_NULL},
	{.replay = STILB_RENDER_REPLAY_SECONDARY, .device = STILB_RENDER_DEVICE_NULL},
	{.replay = STILB_RENDER_REPLAY_DIRECT, .device = STILB_RENDER_DEVICE_NULL},
};
#define WAYS (sizeof ways / sizeof *ways)
#define GPU_WAYS 3u /* the first so many run on the GPU */

/* Lets allocation 1 fail, in the next trial allocation 2, and so on until there are no more. Frames that outgrow their
 * memory need many draws, so they are tried only on the null device and in the cheapest mode of the GPU. The other
 * modes share nearly all allocations with that one: the sanitizer build, which sees what is lost, looks at every second
 * of its, every sixth of the GPU's other modes, and every third of the null device's. Other builds, where the
 * validation layer checks calls, look at each eighth. */
static void every_device_allocation_fails_once(void **state)
{
	(void)state;
	for (size_t w = 0; w < WAYS; w++) {
		stilb_render_desc desc = ways[w];
		uint32_t far_draws = w == 0 || desc.device == STILB_RENDER_DEVICE_NULL ? RENDER_FIRST_COMMANDS + 1000 : 10;
		uint32_t n = TEST_ASAN ? 1 : 1 + (uint32_t)w, step = !TEST_ASAN ? 8 : w == 0 ? 2 : w < GPU_WAYS ? 6 : 3;
		stilb_image want, got;
		assert_int_equal(trial_run(desc, far_draws, &want), 0);
		for (;; n += step) {
			desc.faults.allocation = n;
			int errors = trial_run(desc, far_draws, &got);
			assert_same_picture(&want, &got);
			assert_in_range(errors, 0, 1); /* 0: frame_begin does without the memory that it allocates ahead of need */
			if (device_allocations < n)
				break;
		}
		assert_in_range(n, 8, 60);
		stilb_image_finish(&want);
	}
}

/* ---- the driver's host memory: one process for each fault, since a driver may not survive it --------------------- */

enum host_status {
	HOST_SURVIVED = 0, /* 1 is the exit status of cmocka failures */
	HOST_DRIVER_DIED = 3,
	HOST_DRIVER_SILENT, /* a wrong picture without an error from any call */
	HOST_DIED,
};
/* Every so many of some 500 allocations for each mode: all of them take too long. */
#define HOST_STRIDE 200u

/* A crash inside the call whose allocation failed is the driver's fault. */
static void host_died(int signal)
{
	(void)signal;
	_exit(host_failed_call && driver_call() == host_failed_call ? HOST_DRIVER_DIED : HOST_DIED);
}

static size_t host_way;
static uint64_t host_picture; /* hash of the picture without a fault */

/* The child process: prints the number of host allocations, and the picture's hash. */
static void one_host_allocation_fails(void **state)
{
	(void)state;
	stilb_image image;
	driver_call(); /* its first call loads libraries: now, while there is memory */
	signal(SIGSEGV, host_died);
	signal(SIGABRT, host_died);
	gpu_vulkan_host_allocator = &host_allocator;
	int errors = trial_run(ways[host_way], 10, &image);
	assert_in_range(errors, 0, host_fault > 0);
	uint64_t picture = stilb_hash_fnv1a64(STILB_FNV1A64_START, image.pixels, stilb_image_size(&image));
	printf("allocations %u picture %" PRIx64 "\n", host_allocations, picture);
	fflush(stdout);
	if (host_failed_call && errors == 0 && picture != host_picture)
		_exit(HOST_DRIVER_SILENT);
	assert_true(host_fault == 0 || picture == host_picture);
	stilb_image_finish(&image);
}

/* Returns the child's exit status and its output in words. picture: the hash that its picture must have. */
static int host_child(size_t way, uint32_t fault, uint64_t picture, char *words, size_t size)
{
	char program[1024] = {0}, command[1400];
	assert_true(readlink("/proc/self/exe", program, sizeof program - 1) > 0);
	/* The address sanitizer must not handle the driver's crash: the signal itself tells the parent. */
	snprintf(command, sizeof command,
	         "ASAN_OPTIONS=handle_segv=0:handle_abort=0:abort_on_error=1:detect_leaks=0 '%s' %zu %u %" PRIx64 " 2>&1",
	         program, way, fault, picture);
	FILE *pipe = popen(command, "r");
	assert_non_null(pipe);
	size_t length = fread(words, 1, size - 1, pipe);
	words[length] = '\0';
	while (fgetc(pipe) != EOF)
		continue;
	return WEXITSTATUS(pclose(pipe));
}

/* Mesa 22.3's lavapipe dereferences NULL in vkCreatePipelineLayout, and in the vkCmd calls that copy an array
 * (barriers, copies, vkCmdBeginRendering, vkCmdBindDescriptorSets), if there is no memory for the copy. Without memory
 * for the command itself vkCmdBindDescriptorSets silently does nothing. Trials in which the driver fails so say nothing
 * about Stilb; the test demands that most trials are others. */
static void host_allocations_fail(void **state)
{
	(void)state;
	uint32_t trials = 0, died = 0, silent = 0;
	for (size_t way = 0; way < GPU_WAYS; way++) {
		char words[1 << 14];
		assert_int_equal(host_child(way, 0, 0, words, sizeof words), 0);
		const char *line = strstr(words, "allocations ");
		uint32_t all;
		uint64_t picture;
		assert_non_null(line);
		assert_int_equal(sscanf(line, "allocations %" SCNu32 " picture %" SCNx64, &all, &picture), 2);
		assert_true(all > 100);
		for (uint32_t n = 1 + (uint32_t)way; n <= all; n += HOST_STRIDE, trials++) {
			int status = host_child(way, n, picture, words, sizeof words);
			if (status != HOST_SURVIVED && status != HOST_DRIVER_DIED && status != HOST_DRIVER_SILENT)
				fail_msg("way %zu, host allocation %u of %u: status %d: %s", way, n, all, status, words);
			died += status == HOST_DRIVER_DIED;
			silent += status == HOST_DRIVER_SILENT;
		}
	}
	printf("%u host allocations failed; the driver died of %u of them and was silent about %u\n", trials, died, silent);
	assert_true(died < trials / 2 && silent <= trials / 10);
}

/* ---- commands that cannot be recorded ---------------------------------------------------------------------------- */

/* Numbers of command buffers that were ended, and of the one that fails. Relaxed, as host_allocations. */
static uint32_t ends, end_fault;

VkResult __real_vkEndCommandBuffer(VkCommandBuffer commands);
VkResult __wrap_vkEndCommandBuffer(VkCommandBuffer commands);
VkResult __wrap_vkEndCommandBuffer(VkCommandBuffer commands)
{
	VkResult result = __real_vkEndCommandBuffer(commands);
	return __atomic_add_fetch(&ends, 1, __ATOMIC_RELAXED) == end_fault ? VK_ERROR_OUT_OF_HOST_MEMORY : result;
}

/* Vulkan reports a failure to record commands when their buffer is ended, also a secondary one. */
static void every_end_of_commands_fails_once(void **state)
{
	(void)state;
	trial t = trial_make(ways[1], 0);
	assert_int_equal(step_create(&t), STILB_OK);
	assert_int_equal(stilb_render_set_scene(t.render, t.scene), STILB_OK);
	assert_int_equal(step_texture(&t), STILB_OK);
	assert_int_equal(step_material(&t), STILB_OK);
	do {
		int errors = t.errors;
		ends = 0;
		end_fault = (uint32_t)errors + 1;
		trial_must(&t, step_frame);
		assert_int_equal(t.errors - errors, ends >= end_fault);
	} while (ends >= end_fault);
	end_fault = 0;
	printf("%d ends of command buffers failed\n", t.errors);
	assert_true(t.errors > 2); /* at least two secondary ones and the frame's own */
	trial_finish(&t);
}

/* ---- the device is lost ------------------------------------------------------------------------------------------ */

static void lost_trial(stilb_render_desc desc, uint32_t lost, stilb_image *picture)
{
	desc.faults.lost_frame = lost;
	trial t = trial_make(desc, 0);
	assert_int_equal(step_create(&t), STILB_OK);
	assert_int_equal(stilb_render_set_scene(t.render, t.scene), STILB_OK);
	assert_int_equal(step_texture(&t), STILB_OK);
	assert_int_equal(step_material(&t), STILB_OK);
	for (uint32_t frame = 1; frame < lost; frame++)
		assert_int_equal(step_frame(&t), STILB_OK);
	if (lost > 0) {
		assert_int_equal(step_frame(&t), STILB_ERROR_DEVICE_LOST);
		assert_non_null(strstr(stilb_error_message(), stilb_render_device_name(t.render)));
		assert_non_null(strstr(stilb_error_message(), "lost"));
		if (desc.device == STILB_RENDER_DEVICE_VULKAN)
			assert_non_null(strstr(stilb_error_message(), "--gpu"));
	}
	/* The loss was only pretended (faults.lost_frame), so the device still works: the next frame uploads again what the
	 * lost one was to upload. */
	assert_int_equal(step_frame(&t), STILB_OK);
	assert_int_equal(step_picture(&t), STILB_OK);
	trial_finish(&t);
	*picture = t.picture;
}

static void lost_with_every_frame(void **state)
{
	(void)state;
	for (size_t w = 0; w < WAYS; w++) {
		stilb_image want, got;
		lost_trial(ways[w], 0, &want);
		for (uint32_t lost = 1; lost <= 4; lost++) {
			lost_trial(ways[w], lost, &got);
			assert_same_picture(&want, &got);
		}
		stilb_image_finish(&want);
	}
}

int main(int argc, char **argv)
{
	if (reference_no_driver())
		return 77;
	if (argc == 4) {
		struct CMUnitTest one[] = {cmocka_unit_test(one_host_allocation_fails)};
		host_way = strtoul(argv[1], NULL, 10);
		host_fault = (uint32_t)strtoul(argv[2], NULL, 10);
		host_picture = strtoull(argv[3], NULL, 16);
		return host_way < GPU_WAYS ? cmocka_run_group_tests(one, NULL, NULL) : 2;
	}
	struct CMUnitTest tests[] = {
		cmocka_unit_test(every_device_allocation_fails_once),
		cmocka_unit_test(every_end_of_commands_fails_once),
		cmocka_unit_test(lost_with_every_frame),
		cmocka_unit_test(host_allocations_fail),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
