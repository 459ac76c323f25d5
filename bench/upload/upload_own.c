/* The subject `stilb` of the suite `upload`: uploads of engine/gpu (engine/gpu/gpu.h) on lavapipe. What arrives is
 * compared with what was written. */
#include "bench/harness/bench_child.h"
#include "bench/upload/upload_cases.h"
#include "gpu/gpu.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <string.h>
#include <vulkan/vulkan.h>

static const uint32_t blur_frag[] =
#include "blur.frag.inc"
	;

static stilb_gpu *gpu;
static stilb_gpu_plan *plan;
static uint8_t *source;

static void check(stilb_result result)
{
	if (result != STILB_OK)
		bench_child_fail("%s", stilb_error_message());
}

/* ---- waits (linked with --wrap) ---------------------------------------------------------------------------------- */

/* Waits for the device by a thread that is in a call which must not wait. */
static _Thread_local bool must_not_wait;
static _Atomic uint32_t waits; /* relaxed: a counter that orders nothing */

VkResult __real_vkWaitSemaphores(VkDevice device, const VkSemaphoreWaitInfo *info, uint64_t timeout);
VkResult __wrap_vkWaitSemaphores(VkDevice device, const VkSemaphoreWaitInfo *info, uint64_t timeout);
VkResult __wrap_vkWaitSemaphores(VkDevice device, const VkSemaphoreWaitInfo *info, uint64_t timeout)
{
	if (must_not_wait)
		atomic_fetch_add_explicit(&waits, 1, memory_order_relaxed);
	return __real_vkWaitSemaphores(device, info, timeout);
}

/* ---- frames ------------------------------------------------------------------------------------------------------ */

static void open_all(uint64_t frame_bytes)
{
	stilb_gpu_desc desc = {.name = "llvmpipe", .upload_bytes = UPLOAD_RING_BYTES, .upload_frame = frame_bytes};
	if (stilb_gpu_create(&desc, &gpu) != STILB_OK) {
		fprintf(stderr, "%s\n", stilb_error_message());
		exit(BENCH_CHILD_SKIP);
	}
	plan = stilb_gpu_plan_create();
	source = malloc(UPLOAD_SOURCE_BYTES);
	if (!plan || !source)
		bench_child_fail("no memory");
	for (size_t i = 0; i < UPLOAD_SOURCE_BYTES / 4; i++)
		((uint32_t *)source)[i] = (uint32_t)i * 2654435761u;
}

static void close_all(void)
{
	stilb_gpu_plan_destroy(plan);
	stilb_gpu_destroy(gpu);
	free(source);
}

static void frame_make_and_run(void)
{
	stilb_gpu_planner planner = stilb_gpu_planner_of(gpu);
	check(stilb_gpu_plan_make(plan, &planner));
	must_not_wait = true;
	check(stilb_gpu_frame_run(gpu, plan, NULL, 0, NULL));
	must_not_wait = false;
}

/* A frame without passes: its uploads alone. */
static void frame_of_uploads(void)
{
	check(stilb_gpu_frame_begin(gpu));
	stilb_gpu_plan_begin(plan, 16, 16);
	frame_make_and_run();
}

/* Writes one upload from place `at` of the source. False: the ring has no room now. */
static bool upload_one(const stilb_gpu_upload *upload, uint64_t at)
{
	void *bytes;
	must_not_wait = true;
	check(stilb_gpu_upload_begin(gpu, upload, &bytes));
	if (bytes) {
		memcpy(bytes, source + at, upload->bytes);
		stilb_gpu_upload_end(gpu, bytes);
	}
	must_not_wait = false;
	return bytes;
}

static uint64_t next_place(uint64_t at, uint64_t bytes)
{
	return at + 2 * bytes <= UPLOAD_SOURCE_BYTES ? at + bytes : 0;
}

/* ---- the caller's part ------------------------------------------------------------------------------------------- */

static void run_caller(double seconds, uint32_t bytes)
{
	static upload_samples samples;
	uint32_t count = upload_batch(bytes);
	stilb_gpu_buffer buffer;
	check(stilb_gpu_buffer_create(gpu,
	                              &(stilb_gpu_buffer_desc){.name = "target",
	                                                       .bytes = (uint64_t)count * bytes,
	                                                       .memory = STILB_GPU_MEMORY_READ,
	                                                       .uses = STILB_GPU_BUFFER_COPY},
	                              &buffer));
	uint64_t end = bench_child_now_ns() + (uint64_t)(seconds * 1e9), at = 0;
	for (uint32_t round = 0; round < 8 || bench_child_now_ns() < end; round++) {
		uint64_t first = at, begin = bench_child_now_ns();
		for (uint32_t i = 0; i < count; i++, at = next_place(at, bytes))
			if (!upload_one(&(stilb_gpu_upload){.buffer = buffer, .offset = (uint64_t)i * bytes, .bytes = bytes}, at))
				bench_child_fail("the ring has no room for upload %u of round %u", i, round);
		double time = (double)(bench_child_now_ns() - begin);
		if (round >= 4) /* by then every page of the ring was written */
			upload_sample(&samples, (double)count * bytes / time);
		frame_of_uploads();
		check(stilb_gpu_wait(gpu));
		const uint8_t *arrived = stilb_gpu_buffer_mapped(gpu, buffer);
		if (memcmp(arrived, source + first, bytes) != 0)
			bench_child_fail("round %u: what arrived is not what was written", round);
	}
	bench_child_metric("written", upload_quantile(&samples, 0.5));
}

/* ---- to images --------------------------------------------------------------------------------------------------- */

static stilb_gpu_image make_image(uint32_t side)
{
	stilb_gpu_image image;
	stilb_gpu_extent extent = {
		.format = STILB_GPU_RGBA8_U,
		.width = side,
		.height = side,
		.depth = 1,
		.layers = 1,
		.mips = 1,
		.samples = 1,
		.uses = 1u << STILB_GPU_USE_SAMPLED | 1u << STILB_GPU_USE_COPY_TO | 1u << STILB_GPU_USE_COPY_FROM,
	};
	check(stilb_gpu_image_create(gpu, &(stilb_gpu_image_desc){.name = "target", .extent = extent}, &image));
	return image;
}

static uint32_t side_of(uint32_t bytes)
{
	return (uint32_t)sqrt((double)bytes / 4.0);
}

static stilb_gpu_upload whole_image(stilb_gpu_image image, uint32_t bytes)
{
	uint32_t side = side_of(bytes);
	return (stilb_gpu_upload){.image = image, .width = side, .height = side, .depth = 1, .bytes = bytes};
}

/* The image holds what lies at place `at` of the source. */
static void check_image(stilb_gpu_image image, uint32_t bytes, uint64_t at)
{
	check(stilb_gpu_frame_begin(gpu));
	stilb_gpu_plan_begin(plan, 16, 16);
	uint32_t side = side_of(bytes);
	uint16_t number = stilb_gpu_plan_image(plan, &(stilb_gpu_plan_image_row){.name = "target",
	                                                                         .format = STILB_GPU_RGBA8_U,
	                                                                         .width = side,
	                                                                         .height = side,
	                                                                         .output = true,
	                                                                         .owned = image.id});
	frame_make_and_run();
	uint64_t ticket, frame;
	const void *texels;
	check(stilb_gpu_read_begin(gpu, plan, number, 0, 0, &ticket));
	check(stilb_gpu_read_get(gpu, ticket, true, &texels, &frame));
	if (memcmp(texels, source + at, bytes) != 0)
		bench_child_fail("an image does not hold what was written");
	stilb_gpu_read_end(gpu, ticket);
}

static void run_image(double seconds, uint32_t bytes)
{
	static upload_samples samples;
	static stilb_gpu_image images[UPLOAD_BATCH_MOST];
	uint32_t count = upload_batch(bytes);
	for (uint32_t i = 0; i < count; i++)
		images[i] = make_image(side_of(bytes));
	uint64_t end = bench_child_now_ns() + (uint64_t)(seconds * 1e9), at = 0, last = 0;
	for (uint32_t round = 0; round < 8 || bench_child_now_ns() < end; round++) {
		for (uint32_t i = 0; i < count; i++, at = next_place(at, bytes)) {
			stilb_gpu_upload upload = whole_image(images[i], bytes);
			if (!upload_one(&upload, at))
				bench_child_fail("the ring has no room for upload %u of round %u", i, round);
			last = at;
		}
		uint64_t begin = bench_child_now_ns();
		frame_of_uploads();
		check(stilb_gpu_wait(gpu));
		if (round >= 4)
			upload_sample(&samples, (double)(bench_child_now_ns() - begin) / count);
	}
	check_image(images[count - 1], bytes, last);
	bench_child_metric("copied", upload_quantile(&samples, 0.5) * 1e-3);
}

/* ---- while frames run -------------------------------------------------------------------------------------------- */

#define STREAM_IMAGES 64u
#define STREAM_BYTES 1000000000u
#define STREAM_PASSES 6u
#define STREAM_FRAME_BYTES (4ull << 20) /* that one frame copies */

typedef struct stream {
	stilb_gpu_image images[STREAM_IMAGES];
	uint32_t bytes;      /* of an upload */
	uint64_t most;       /* bytes to upload */
	uint64_t uploaded;   /* by the second thread; read once it has ended */
	_Atomic bool ended;  /* release by the second thread, acquire by the main thread's loop */
	_Atomic bool cancel; /* relaxed: ends the second thread's loop, and orders nothing */
} stream;

static void *stream_thread(void *context)
{
	stream *s = context;
	uint64_t at = 0;
	uint32_t image = 0;
	while (s->uploaded < s->most && !atomic_load_explicit(&s->cancel, memory_order_relaxed)) {
		stilb_gpu_upload upload = whole_image(s->images[image], s->bytes);
		if (!upload_one(&upload, at)) {
			nanosleep(&(struct timespec){.tv_nsec = 200000}, NULL);
			continue;
		}
		s->uploaded += s->bytes;
		at = next_place(at, s->bytes);
		image = (image + 1) % STREAM_IMAGES;
	}
	atomic_store_explicit(&s->ended, true, memory_order_release); /* see `ended` */
	return NULL;
}

/* A frame of fullscreen passes: each reads the picture of the one before, the first that of the last frame. */
static void draw_frame(uint32_t program)
{
	static const char *const names[STREAM_PASSES] = {"a", "b", "c", "d", "e", "picture"};
	uint16_t images[STREAM_PASSES];
	check(stilb_gpu_frame_begin(gpu));
	stilb_gpu_plan_begin(plan, 640, 360);
	for (uint32_t i = 0; i < STREAM_PASSES; i++)
		images[i] = stilb_gpu_plan_image(
			plan, &(stilb_gpu_plan_image_row){
					  .name = names[i], .format = STILB_GPU_RGBA8_U, .scale = 1.0f, .keep = i + 1 == STREAM_PASSES});
	for (uint32_t i = 0; i < STREAM_PASSES; i++)
		stilb_gpu_plan_pass(plan,
		                    &(stilb_gpu_pass){.name = names[i],
		                                      .kind = STILB_GPU_PASS_FULLSCREEN,
		                                      .color = {{.image = images[i], .load = STILB_GPU_LOAD_DISCARD}},
		                                      .color_count = 1,
		                                      .uses = {{.resource = images[(i + STREAM_PASSES - 1) % STREAM_PASSES],
		                                                .how = STILB_GPU_USE_SAMPLED,
		                                                .previous = i == 0}},
		                                      .use_count = 1,
		                                      .program = program});
	frame_make_and_run();
}

/* Draws frames until `s` has ended, or, without it, until the time is over; returns the bytes that they uploaded.
 * A frame's time is that between two frames which were handed over. */
static uint64_t draw_frames(uint32_t program, stream *s, uint64_t end, upload_samples *ms)
{
	uint64_t uploaded = 0, last = 0;
	for (;;) {
		bool over =
			s ? atomic_load_explicit(&s->ended, memory_order_acquire) && uploaded == s->uploaded /* see `ended` */
			  : bench_child_now_ns() > end;
		if (over)
			return uploaded;
		draw_frame(program);
		uint64_t now = bench_child_now_ns();
		if (last > 0)
			upload_sample(ms, (double)(now - last) * 1e-6);
		last = now;
		uploaded += stilb_gpu_stats_get(gpu).uploaded_bytes;
		if (s && now > end)
			atomic_store_explicit(&s->cancel, true, memory_order_relaxed); /* see `cancel` */
	}
}

static void run_stream(double seconds, uint32_t bytes)
{
	static upload_samples quiet, busy;
	static stream s;
	pthread_t thread;
	stilb_gpu_program program;
	check(stilb_gpu_program_create(
		gpu,
		&(stilb_gpu_program_desc){
			.name = "blur", .fragment = {.words = blur_frag, .bytes = sizeof blur_frag}, .samplers = 1},
		&program));
	for (uint32_t i = 0; i < STREAM_IMAGES; i++)
		s.images[i] = make_image(side_of(bytes));
	s.bytes = bytes;
	s.most = STREAM_BYTES;
	uint64_t now = bench_child_now_ns(), share = (uint64_t)(seconds * 1e9 / 6);
	draw_frames(program.id, NULL, now + share / 2, &busy);
	busy.count = 0; /* those before were for warmth */
	draw_frames(program.id, NULL, now + share, &quiet);
	uint64_t begin = bench_child_now_ns();
	if (pthread_create(&thread, NULL, stream_thread, &s) != 0)
		bench_child_fail("no thread");
	uint64_t uploaded = draw_frames(program.id, &s, begin + 4 * share, &busy);
	double time = (double)(bench_child_now_ns() - begin);
	pthread_join(thread, NULL);
	draw_frames(program.id, NULL, bench_child_now_ns() + share, &quiet);
	double before = upload_quantile(&quiet, 0.95), during = upload_quantile(&busy, 0.95);
	bench_child_metric("quiet", before);
	bench_child_metric("busy", during);
	bench_child_metric("ratio", during / before);
	bench_child_metric("median", upload_quantile(&busy, 0.5) / upload_quantile(&quiet, 0.5));
	bench_child_metric("streamed", (double)uploaded * 1e-6);
	bench_child_metric("rate", (double)uploaded / time * 1e3);
	bench_child_metric("waits", (double)atomic_load_explicit(&waits, memory_order_relaxed)); /* see `waits` */
}

int main(int argc, char **argv)
{
	bench_child child = bench_child_args(argc, argv);
	open_all(strcmp(child.case_name, "stream") == 0 ? STREAM_FRAME_BYTES : 0);
#define CASE(NAME, TITLE, KIND, BYTES)                                                                                 \
	if (strcmp(child.case_name, NAME) == 0)                                                                            \
		UPLOAD_##KIND == UPLOAD_CALLER  ? run_caller(child.seconds, BYTES)                                             \
		: UPLOAD_##KIND == UPLOAD_IMAGE ? run_image(child.seconds, BYTES)                                              \
										: run_stream(child.seconds, BYTES);
	UPLOAD_CASES(CASE)
#undef CASE
	close_all();
	return 0;
}
