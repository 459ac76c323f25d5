#include "picture_flags.h"

#include "shading/shade_brdf.h"

#include <float.h>
#include <inttypes.h>
#include <math.h>

const char *const picture_replay_choices[] = {"indirect", "direct", "secondary", NULL};
const char *const picture_materials_choices[] = {"index", "bind", "pipeline", NULL};
const char *const picture_device_choices[] = {"vulkan", "null", NULL};

picture_flags picture_flags_default(void)
{
	return (picture_flags){
		.brdf = PICTURE_NOT_GIVEN,
		.ndf = PICTURE_NOT_GIVEN,
		.g = PICTURE_NOT_GIVEN,
		.f = PICTURE_NOT_GIVEN,
		.roughness = NAN,
		.anisotropy = NAN,
		.wrap = NAN,
		.specular = NAN,
	};
}

/* ---- the table --------------------------------------------------------------------------------------------------- */

static void picture_add_drawing(picture_flags *p, picture_flags_group group, flag_rows *table)
{
	const flag commands[] = {
		{"--replay", FLAG_CHOICE, &p->replay, "MODE",
	     "indirect, direct (a command a draw) or secondary (those in parallel) (indirect)", 0, 0,
	     picture_replay_choices},
		{"--materials", FLAG_CHOICE, &p->materials, "MODE",
	     "index, bind (a descriptor set each) or pipeline (two pipelines) (index)", 0, 0, picture_materials_choices},
	};
	const flag device[] = {
		{"--device", FLAG_CHOICE, &p->device, "vulkan|null", "null draws nothing: for the CPU's part alone (vulkan)", 0,
	     0, picture_device_choices},
		{"--gpu", FLAG_TEXT, &p->gpu, "N|NAME", "number of a GPU or part of its name, see 'stilb info'", 0, 0, NULL},
		{"--validate", FLAG_SWITCH, &p->validate, NULL, "Vulkan validation; any message fails the run", 0, 0, NULL},
	};
	const flag samples[] = {
		{"--msaa", FLAG_NUMBER, &p->samples, "1|4", "samples per pixel (4 on a GPU, 1 in software)", 1, 4, NULL},
	};
	if (group == PICTURE_COMMANDS)
		flag_rows_add(table, commands, sizeof commands / sizeof *commands);
	if (group == PICTURE_DEVICE)
		flag_rows_add(table, device, sizeof device / sizeof *device);
	if (group == PICTURE_SAMPLES)
		flag_rows_add(table, samples, sizeof samples / sizeof *samples);
}

static void picture_add_shading(picture_flags *p, picture_flags_group group, flag_rows *table)
{
	const flag brdf[] = {
		{"--brdf", FLAG_CHOICE, &p->brdf, "NAME",
	     "reflection model: lambert, phong, ... (microfacet; demo: blinn-phong-modified)", 0, 0,
	     stilb_engine_brdf_names},
		{"--ndf", FLAG_CHOICE, &p->ndf, "NAME", "distribution D of --brdf microfacet, which it implies (ggx)", 0, 0,
	     stilb_engine_ndf_names},
		{"--g", FLAG_CHOICE, &p->g, "NAME", "shadowing term G of --brdf microfacet, which it implies (smith-ggx)", 0, 0,
	     stilb_engine_g_names},
		{"--f", FLAG_CHOICE, &p->f, "NAME", "Fresnel term F of --brdf microfacet, which it implies (schlick)", 0, 0,
	     stilb_engine_f_names},
	};
	const flag added[] = {
		{"--roughness", FLAG_DECIMAL, &p->roughness, "X", "added to the roughness of every material, -1..1 (0)", 0, 1,
	     NULL},
		{"--anisotropy", FLAG_DECIMAL, &p->anisotropy, "X",
	     "added to the anisotropy, -1..1 (0; 0.6 with --ndf ggx-anisotropic)", 0, 1, NULL},
		{"--wrap", FLAG_DECIMAL, &p->wrap, "X", "added to the wrap, -1..1 (0; 0.5 with --brdf wrapped)", 0, 1, NULL},
		{"--specular", FLAG_DECIMAL, &p->specular, "X", "added to the specular reflectance, -1..1 (0)", 0, 1, NULL},
	};
	if (group == PICTURE_BRDF)
		flag_rows_add(table, brdf, sizeof brdf / sizeof *brdf);
	if (group == PICTURE_ADDED)
		flag_rows_add(table, added, sizeof added / sizeof *added);
}

static void picture_add_place(picture_flags *p, flag_rows *table)
{
	const flag place[] = {
		{"--camera", FLAG_LIST, &p->camera, "X,Y,Z,YAW,PITCH[,FOV]",
	     "position in metres, angles in degrees (the scene's camera)", 5, 6, NULL},
		{"--environment", FLAG_TEXT, &p->environment, "FILE|R,G,B",
	     "a panorama (.hdr, .exr, ...) or a radiance around the scene (its own)", 0, 0, NULL},
		{"--variant", FLAG_TEXT, &p->variant, "NAME",
	     "materials of this variant of a glTF file, see 'stilb info SCENE'", 0, 0, NULL},
		{"--allow-outside", FLAG_SWITCH, &p->allow_outside, NULL,
	     "let the scene's file name files outside its folder and the parent of that", 0, 0, NULL},
		{"--quiet", FLAG_SWITCH, &p->quiet, NULL, "do not list what the scene's file has that is not shown", 0, 0,
	     NULL},
	};
	flag_rows_add(table, place, sizeof place / sizeof *place);
}

void picture_flags_add(picture_flags *picture, picture_flags_group group, flag_rows *table)
{
	STILB_ASSERT(picture && table);
	STILB_ASSERT((unsigned)group <= PICTURE_ADDED);
	picture_add_drawing(picture, group, table);
	picture_add_shading(picture, group, table);
	if (group == PICTURE_PLACE)
		picture_add_place(picture, table);
}

/* ---- what the flags mean ----------------------------------------------------------------------------------------- */

bool picture_flags_parts(const picture_flags *p)
{
	return p->ndf != PICTURE_NOT_GIVEN || p->g != PICTURE_NOT_GIVEN || p->f != PICTURE_NOT_GIVEN;
}

bool picture_flags_check(const picture_flags *p)
{
	if (p->samples != 0 && p->samples != 1 && p->samples != 4) {
		stilb_log("--msaa: %" PRIu64 " samples are not possible; give 1 or 4", p->samples);
		return false;
	}
	if (p->camera.count == 6 && !(p->camera.numbers[5] > 0.0f && p->camera.numbers[5] < 180.0f)) {
		stilb_log("--camera: '%g' is not a field of view; give degrees between 0 and 180",
		          (double)p->camera.numbers[5]);
		return false;
	}
	return true;
}

static uint32_t picture_choice(int given, uint32_t otherwise)
{
	return given == PICTURE_NOT_GIVEN ? otherwise : (uint32_t)given;
}

static float picture_added(float given, float otherwise)
{
	return isnan(given) ? otherwise : given;
}

stilb_render_shading picture_flags_shading(const picture_flags *p, uint32_t brdf)
{
	stilb_render_shading before = stilb_render_shading_default();
	stilb_render_shading shading = before;
	shading.brdf = picture_choice(p->brdf, picture_flags_parts(p) ? SHADE_BRDF_MICROFACET : brdf);
	shading.ndf = picture_choice(p->ndf, shading.ndf);
	shading.g = picture_choice(p->g, shading.g);
	shading.f = picture_choice(p->f, shading.f);
	stilb_engine_shading_chosen(&before, &shading); /* sets defaults that suit the chosen BRDF */
	shading.roughness = picture_added(p->roughness, shading.roughness);
	shading.anisotropy = picture_added(p->anisotropy, shading.anisotropy);
	shading.wrap = picture_added(p->wrap, shading.wrap);
	shading.specular = picture_added(p->specular, shading.specular);
	return shading;
}

static float picture_radians(float degrees)
{
	return degrees * (float)M_PI / 180.0f;
}

void picture_flags_place(const picture_flags *p, float aspect, stilb_scene *scene)
{
	stilb_scene_camera *camera = &scene->camera;
	if (scene->framed)
		*camera = stilb_scene_frame(scene, STILB_SCENE_FRAME_YAW, STILB_SCENE_FRAME_PITCH, aspect);
	if (p->camera.count == 0)
		return;
	scene->framed = false;
	for (int i = 0; i < 3; i++)
		camera->position[i] = p->camera.numbers[i];
	camera->yaw = picture_radians(p->camera.numbers[3]);
	camera->pitch = picture_radians(p->camera.numbers[4]);
	camera->roll = 0.0f;
	if (p->camera.count > 5)
		camera->fov_y = picture_radians(p->camera.numbers[5]);
}

stilb_result picture_flags_variant(const picture_flags *p, stilb_scene *scene)
{
	if (!p->variant)
		return STILB_OK;
	stilb_result result = stilb_scene_show_variant_named(scene, p->variant);
	return result == STILB_OK ? result : stilb_fail(result, "--variant: %s", stilb_error_message());
}

stilb_result picture_flags_surroundings(const picture_flags *p, stilb_scene *scene)
{
	flag_list color;
	if (!p->environment)
		return STILB_OK;
	if (!flags_numbers(p->environment, 3, 3, &color))
		return stilb_scene_set_environment(scene, p->environment);
	for (int i = 0; i < 3; i++)
		if (!(color.numbers[i] >= 0.0f && isfinite(color.numbers[i])))
			return stilb_fail(STILB_ERROR_ARGUMENT, "--environment: '%s' is out of range; give radiances in 0..%.2g",
			                  p->environment, (double)FLT_MAX);
	stilb_scene_set_sky(scene, color.numbers);
	return STILB_OK;
}
