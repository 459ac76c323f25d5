/* own_compute: a compute shader of one's own in every frame, and reading back what it wrote: the mean brightness of the
 * frame, in W sr^-1 m^-2. Needs no window. */
#include <stdio.h>
#include <stilb/engine.h>

static const uint32_t shader[] =
#include "own_compute.comp.inc"
	;

#define GROUP 8u /* pixels along a work group's side, as in the shader */

typedef struct meter {
	stilb_gpu_program program;
	uint32_t groups[2];
	uint16_t sums; /* the buffer's number in the frame's plan */
} meter;

/* Adds a buffer and a dispatch, which reads the light and writes a sum for each work group. */
static stilb_result meter_add(void *user, stilb_gpu_plan *plan, uint16_t *image)
{
	meter *m = user;
	const stilb_gpu_extent *light = stilb_gpu_plan_extent(plan, *image);
	m->groups[0] = (light->width + GROUP - 1) / GROUP;
	m->groups[1] = (light->height + GROUP - 1) / GROUP;
	stilb_gpu_plan_buffer_row row = {
		.name = "sums", .bytes = (uint64_t)m->groups[0] * m->groups[1] * sizeof(float), .output = true};
	m->sums = stilb_gpu_plan_buffer(plan, &row);
	stilb_gpu_pass pass = {
		.name = "light meter",
		.kind = STILB_GPU_PASS_DISPATCH,
		.program = m->program.id,
		.groups = {m->groups[0], m->groups[1], 1},
		.uses = {{.resource = *image, .how = STILB_GPU_USE_SAMPLED},
	             {.resource = m->sums,
	              .how = STILB_GPU_USE_STORAGE_WRITE}}, /* its address is the shader's first constant */
		.use_count = 2,
		.constant_bytes = sizeof(uint64_t),
	};
	stilb_gpu_plan_pass(plan, &pass);
	return STILB_OK;
}

/* Reads the sums of the last frame; here it waits for them, a program in a window would ask again a frame later. */
static stilb_result meter_read(const meter *m, stilb_engine *engine, double *mean)
{
	uint64_t ticket, frame;
	const void *bytes;
	uint32_t width, height;
	stilb_gpu *gpu = stilb_engine_gpu(engine);
	stilb_engine_size(engine, &width, &height);
	stilb_result result = stilb_gpu_read_begin(gpu, stilb_engine_plan(engine), m->sums, 0, 0, &ticket);
	if (result != STILB_OK)
		return result;
	result = stilb_gpu_read_get(gpu, ticket, true, &bytes, &frame);
	double sum = 0.0;
	for (uint32_t g = 0; g < m->groups[0] * m->groups[1] && result == STILB_OK; g++)
		sum += (double)((const float *)bytes)[g];
	stilb_gpu_read_end(gpu, ticket);
	*mean = sum / ((double)width * height);
	return result;
}

int main(void)
{
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.width = 484; /* no multiple of the group's side */
	desc.height = 270;
	stilb_scene *scene = NULL;
	stilb_engine *engine = NULL;
	stilb_engine_report report;
	meter m = {0};
	stilb_gpu_program_desc own = {
		.name = "light meter", .compute = {.words = shader, .bytes = sizeof shader}, .samplers = 1};
	stilb_render_feature feature = {.stage = STILB_RENDER_STAGE_LIGHT, .add = meter_add, .user = &m};
	stilb_result result = stilb_scene_create_stress(300, 1, &scene);
	if (result == STILB_OK)
		result = stilb_engine_create(&desc, &engine);
	if (result == STILB_OK)
		result = stilb_engine_set_scene(engine, scene);
	if (result == STILB_OK)
		result = stilb_gpu_program_create(stilb_engine_gpu(engine), &own, &m.program);
	if (result == STILB_OK)
		result = stilb_engine_add_feature(engine, &feature);
	for (int f = 0; f < 3 && result == STILB_OK; f++) {
		double mean = 0.0;
		result = stilb_engine_frame(engine, &report);
		if (result == STILB_OK)
			result = meter_read(&m, engine, &mean);
		if (result == STILB_OK)
			printf("frame %d: %.4f W sr^-1 m^-2 in the mean\n", f, mean);
	}
	if (result != STILB_OK)
		fprintf(stderr, "%s\n", stilb_error_message());
	stilb_engine_destroy(engine); /* and the program */
	stilb_scene_destroy(scene);
	return result == STILB_OK ? 0 : 1;
}
