/* own_pass [PICTURE.png]: a pass of one's own in every frame, between the scene's light and the tone map, with its own
 * shader. Needs no window. */
#include <stdio.h>
#include <stilb/engine.h>
#include <string.h>

static const uint32_t shader[] =
#include "own_pass.frag.inc"
	;

/* The shader's push constants. */
typedef struct photograph_push {
	float hue[4], dark;
} photograph_push;

/* Adds an image and a fullscreen pass, which reads the light and writes that image; it takes the light's place. */
static stilb_result photograph(void *user, stilb_gpu_plan *plan, uint16_t *image)
{
	const stilb_gpu_program *program = user;
	photograph_push push = {.hue = {1.15f, 1.0f, 0.75f, 1.0f}, .dark = 0.8f};
	const stilb_gpu_extent *light =
		stilb_gpu_plan_extent(plan, *image); /* which may have another size than the picture */
	stilb_gpu_plan_image_row row = {
		.name = "photograph", .format = STILB_GPU_RGBA16_F, .width = light->width, .height = light->height};
	uint16_t out = stilb_gpu_plan_image(plan, &row);
	stilb_gpu_pass pass = {
		.name = "photograph",
		.kind = STILB_GPU_PASS_FULLSCREEN,
		.program = program->id,
		.color = {{.image = out, .load = STILB_GPU_LOAD_DISCARD}},
		.color_count = 1,
		.uses = {{.resource = *image, .how = STILB_GPU_USE_SAMPLED}},
		.use_count = 1,
		.constant_bytes = sizeof push,
	};
	memcpy(pass.constants, &push, sizeof push);
	stilb_gpu_plan_pass(plan, &pass);
	*image = out;
	return STILB_OK;
}

int main(int argc, char **argv)
{
	const char *path = argc > 1 ? argv[1] : "own_pass.png";
	stilb_engine_desc desc = stilb_engine_desc_default();
	desc.width = 480;
	desc.height = 270;
	stilb_scene *scene = NULL;
	stilb_engine *engine = NULL;
	stilb_engine_report report;
	stilb_gpu_program program = {0};
	stilb_gpu_program_desc own = {
		.name = "photograph", .fragment = {.words = shader, .bytes = sizeof shader}, .samplers = 1};
	stilb_render_feature feature = {.stage = STILB_RENDER_STAGE_LIGHT, .add = photograph, .user = &program};
	stilb_result result = stilb_scene_create_stress(300, 1, &scene);
	if (result == STILB_OK)
		result = stilb_engine_create(&desc, &engine);
	if (result == STILB_OK)
		result = stilb_engine_set_scene(engine, scene);
	if (result == STILB_OK)
		result = stilb_gpu_program_create(stilb_engine_gpu(engine), &own, &program);
	if (result == STILB_OK)
		result = stilb_engine_add_feature(engine, &feature);
	if (result == STILB_OK)
		result = stilb_engine_frame(engine, &report);
	if (result == STILB_OK)
		result = stilb_engine_screenshot(engine, path);
	if (result == STILB_OK)
		printf("%u of %u models drawn as a photograph: %s\n", report.visible, scene->model_count, path);
	else
		fprintf(stderr, "%s\n", stilb_error_message());
	stilb_engine_destroy(engine); /* and the program */
	stilb_scene_destroy(scene);
	return result == STILB_OK ? 0 : 1;
}
