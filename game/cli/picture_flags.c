#include "picture_flags.h"

#include "shading/shade_brdf.h"
#include "shading/shade_srgb.h"
#include "shading/shade_tonemap.h"

#include <float.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *const picture_replay_choices[] = {"indirect", "direct", "secondary", NULL};
const char *const picture_materials_choices[] = {"index", "bind", "pipeline", NULL};
const char *const picture_specular_aa_choices[] = {"vmf", "toksvig", "off", NULL};
const char *const picture_device_choices[] = {"vulkan", "null", NULL};
static const char *const picture_studio_choices[] = {"auto", "on", "off", NULL};

#define PICTURE_DETAIL_DEFAULT STILB_RENDER_DETAIL_MORPH
#define PICTURE_ERROR_LEAST 0.01f /* pixels, of --lod-error */
#define PICTURE_ERROR_MOST 1000

picture_flags picture_flags_default(void)
{
	return (picture_flags){
		.brdf = PICTURE_NOT_GIVEN,
		.ndf = PICTURE_NOT_GIVEN,
		.g = PICTURE_NOT_GIVEN,
		.f = PICTURE_NOT_GIVEN,
		.tone = PICTURE_NOT_GIVEN,
		.roughness = NAN,
		.anisotropy = NAN,
		.wrap = NAN,
		.specular = NAN,
		.shadows = STILB_ENGINE_SHADOWS_MAP,
		.detail = PICTURE_DETAIL_DEFAULT,
		.detail_error = 0.5f,
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
	     "index, bind (an address each) or pipeline (two pipelines) (index)", 0, 0, picture_materials_choices},
	};
	const flag device[] = {
		{"--device", FLAG_CHOICE, &p->device, "vulkan|null", "null draws nothing: for the CPU's part alone (vulkan)", 0,
	     0, picture_device_choices},
		{"--gpu", FLAG_TEXT, &p->gpu, "N|NAME", "number of a GPU or part of its name, see 'stilb info'", 0, 0, NULL},
		{"--validate", FLAG_SWITCH, &p->validate, NULL, "Vulkan validation; any message fails the run", 0, 0, NULL},
	};
	const flag samples[] = {
		{"--msaa", FLAG_NUMBER, &p->samples, "1|4", "samples per pixel (4 on a GPU, 1 in software)", 1, 4, NULL},
		{"--max-anisotropy", FLAG_NUMBER, &p->max_anisotropy, "1..16",
	     "sharpness of textures seen at a slant (8 on a GPU, 1 in software)", 1, 16, NULL},
		{"--specular-aa", FLAG_CHOICE, &p->specular_aa, "MODE",
	     "highlights of bumps that are too small to be seen: vmf, toksvig or off (vmf)", 0, 0,
	     picture_specular_aa_choices},
	};
	const flag lighting[] = {
		{"--lighting", FLAG_CHOICE, &p->lighting, "WAY", "how pixels find lights, see below (auto)", 0, 0,
	     stilb_render_lighting_names},
		{"--light-coverage", FLAG_CHOICE, &p->coverage, "WAY",
	     "of deferred, prepass, prelight: cells, screen, rectangles or volumes (cells)", 0, 0,
	     stilb_render_coverage_names},
		{"--gbuffer", FLAG_CHOICE, &p->gbuffer, "WAY",
	     "of deferred and tiled-deferred, how surfaces are kept: wide or rgba8 (wide)", 0, 0,
	     stilb_render_gbuffer_names},
		{"--light-lists", FLAG_CHOICE, &p->light_lists, "WHO", "makes lists of lights: jobs or compute (jobs)", 0, 0,
	     stilb_render_light_lists_names},
		{"--light-tolerance", FLAG_AMOUNT, &p->light_tolerance, "T",
	     "of display white, what lights left out of a pixel may send together, 0..1 (0)", 0, 1, NULL},
		{"--light-fade", FLAG_AMOUNT, &p->light_fade, "PIXELS",
	     "lights whose reach has fewer pixels are out; up to twice that they fade (0)", 0, 1000, NULL},
		{"--shadows", FLAG_CHOICE, &p->shadows, "off|map|buffer",
	     "map: what lights see is drawn into maps; buffer: read before lights (map)", 0, 0, stilb_engine_shadow_names},
		{"--cascades", FLAG_NUMBER, &p->cascades, "1..8", "shadow maps of a sun (4 on a GPU, 2 in software)", 1, 8,
	     NULL},
		{"--cascade-size", FLAG_NUMBER, &p->cascade_size, "TEXELS",
	     "a shadow map's side, a power of two, 64..8192 (2048 on a GPU, 1024 in software)", 64, 8192, NULL},
		{"--shadow-distance", FLAG_AMOUNT, &p->shadow_distance, "METRES",
	     "where shadows of suns have faded out; 0: nowhere (0)", 0, 1000000000, NULL},
		{"--shadow-objects", FLAG_SWITCH, &p->shadow_objects, NULL,
	     "a sun has one map, around what is small and nearer than --shadow-distance", 0, 0, NULL},
		{"--shadow-filter", FLAG_CHOICE, &p->shadow_filter, "gather|compare",
	     "how maps are read: all texels of a square, or few comparisons (gather)", 0, 0,
	     stilb_engine_shadow_filter_names},
		{"--shadow-samples", FLAG_NUMBER, &p->shadow_samples, "N",
	     "gather: texels, 1, 4, 16 or 36 (16); compare: comparisons, 1, 4 or 12 (12)", 1, 36, NULL},
		{"--shadow-bias", FLAG_CHOICE, &p->shadow_bias, "KIND",
	     "against self-shading: all, or slope, plane, way alone, or none (all)", 0, 0, stilb_engine_shadow_bias_names},
		{"--shadow-faces", FLAG_CHOICE, &p->shadow_faces, "both|front|back",
	     "sides of triangles, as a light sees them, that maps have (both)", 0, 0, stilb_engine_shadow_faces_names},
		{"--ambient", FLAG_CHOICE, &p->ambient, "KIND",
	     "what the surroundings' light is taken for, see below (environment)", 0, 0, stilb_render_ambient_names},
	};
	const flag range[] = {
		{"--show-range", FLAG_TEXT, &p->show_range, "LOW,HIGH", "values of that image shown black and white (0,1)", 0,
	     0, NULL},
	};
	const flag image[] = {
		{"--show", FLAG_TEXT, &p->show, "IMAGE[:MIP[:LAYER]]", "an image of --plan in the place of the picture", 0, 0,
	     NULL},
	};
	const flag detail[] = {
		{"--lod", FLAG_CHOICE, &p->detail, "MODE",
	     "coarser meshes far away: off, pop, fade (for 16 frames) or morph (morph)", 0, 0, stilb_render_detail_names},
		{"--lod-error", FLAG_AMOUNT, &p->detail_error, "PIXELS", "by which they may differ at most, 0.01..1000 (0.5)",
	     0, PICTURE_ERROR_MOST, NULL},
		{"--show", FLAG_TEXT, &p->show, "WHAT",
	     "what pictures show, see below, or IMAGE[:MIP[:LAYER]] of --plan (shaded)", 0, 0, NULL},
	};
	if (group == PICTURE_DETAIL)
		flag_rows_add(table, detail, sizeof detail / sizeof *detail);
	if (group == PICTURE_IMAGE)
		flag_rows_add(table, image, sizeof image / sizeof *image);
	if (group == PICTURE_LIGHTING)
		flag_rows_add(table, lighting, sizeof lighting / sizeof *lighting);
	if (group == PICTURE_DETAIL || group == PICTURE_IMAGE)
		flag_rows_add(table, range, sizeof range / sizeof *range);
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
		{"--camera", FLAG_TEXT, &p->camera, "X,Y,Z,YAW,PITCH[,FOV]|NAME|N",
	     "metres and degrees, or a camera of the file, see 'stilb info SCENE' (the first)", 0, 0, NULL},
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

static void picture_add_pose(picture_flags *p, flag_rows *table)
{
	const flag pose[] = {
		{"--animation", FLAG_TEXT, &p->animation, "NAME|N|none",
	     "a clip of the file that plays, see 'stilb info SCENE' (the first, which stands still without a window)", 0, 0,
	     NULL},
		{"--at", FLAG_AMOUNT, &p->at, "S", "seconds in that clip at the start (0)", 0, 1000000, NULL},
	};
	flag_rows_add(table, pose, sizeof pose / sizeof *pose);
}

static void picture_add_look(picture_flags *p, flag_rows *table)
{
	const flag look[] = {
		{"--studio", FLAG_CHOICE, &p->studio, "auto|on|off",
	     "soft light and a floor in place of the scene's light; auto: if it has none (auto)", 0, 0,
	     picture_studio_choices},
		{"--background", FLAG_TEXT, &p->background, "NAME|COLOR",
	     "environment, blur, transparent (in files with alpha), #RRGGBB or R,G,B, linear (environment)", 0, 0, NULL},
	};
	flag_rows_add(table, look, sizeof look / sizeof *look);
}

static void picture_add_exposure(picture_flags *p, flag_rows *table)
{
	const flag exposure[] = {{"--exposure", FLAG_TEXT, &p->exposure, "EV|auto|adapt",
	                          "brighter by 2^EV, -32..32; auto: by the lights; adapt: by what is seen (0)", 0, 0,
	                          NULL}};
	flag_rows_add(table, exposure, 1);
}

static void picture_add_tone(picture_flags *p, flag_rows *table)
{
	const flag tone[] = {{"--tone", FLAG_CHOICE, &p->tone, "NAME",
	                      "knee, neutral, filmic, luminance, piecewise, hable or none (files: neutral)", 0, 0,
	                      stilb_scene_tone_names}};
	flag_rows_add(table, tone, 1);
}

static void picture_add_post(picture_flags *p, flag_rows *table)
{
	const flag post[] = {
		{"--aa", FLAG_CHOICE, &p->aa, "KIND", "antialiasing beside --msaa: none, post or temporal (none)", 0, 0,
	     stilb_post_aa_names},
		{"--ao", FLAG_AMOUNT, &p->occlusion, "S",
	     "ambient occlusion: ambient light is darker by it where it is hidden, 0..1 (0)", 0, 1, NULL},
		{"--ao-radius", FLAG_AMOUNT, &p->occlusion_radius, "METRES", "what is nearer hides it (1)", 0, 1000000, NULL},
		{"--motion-blur", FLAG_AMOUNT, &p->motion_blur, "SHUTTER",
	     "motion blur: for which share of a frame the shutter is open, 0..1 (0)", 0, 1, NULL},
		{"--motion-blur-most", FLAG_AMOUNT, &p->motion_blur_most, "S",
	     "its longest way, a share of the picture's height, 0..1 (0.1)", 0, 1, NULL},
		{"--motion-blur-of", FLAG_CHOICE, &p->motion, "WHAT",
	     "all, or far: by the camera alone, in a quarter of the pixels (all)", 0, 0, stilb_post_motion_names},
		{"--motion-blur-far", FLAG_AMOUNT, &p->motion_blur_far, "METRES", "from where on that sets in (10)", 0, 1000000,
	     NULL},
		{"--bloom", FLAG_AMOUNT, &p->bloom, "S", "share of each pixel's light that the lens scatters, 0..1 (0)", 0, 1,
	     NULL},
		{"--bloom-width", FLAG_AMOUNT, &p->bloom_width, "S",
	     "of it, what goes on from each pattern to the one twice as wide, 0..1 (0.6)", 0, 1, NULL},
		{"--bloom-format", FLAG_CHOICE, &p->bloom_format, "KIND",
	     "images that add it up: half, or fixed, 8 bits through a tone curve (half)", 0, 0,
	     stilb_post_bloom_format_names},
		{"--post", FLAG_CHOICE, &p->post_place, "WHO",
	     "computes bloom and --ao: gpu, cpu, or auto: cpu on software devices (auto)", 0, 0, stilb_post_place_names},
		{"--dither", FLAG_CHOICE, &p->dither, "KIND",
	     "of 8-bit codes: ordered (by half a code), triangular (by one) or off (ordered)", 0, 0,
	     stilb_post_dither_names},
		{"--hdr", FLAG_CHOICE, &p->hdr, "KIND",
	     "what passes keep light in: half floats, or 8 bits: rgbm or logluv (half)", 0, 0, stilb_render_hdr_names},
		{"--grade", FLAG_TEXT, &p->grade, "FILE.cube", "a table of colours that the picture is shown through (none)", 0,
	     0, NULL},
		{"--reflections", FLAG_CHOICE, &p->reflections, "KIND",
	     "surfaces mirror what the picture shows: off, cones, crude or linear (off)", 0, 0,
	     stilb_post_reflections_names},
		{"--dof", FLAG_CHOICE, &p->dof, "KIND", "depth of field: off, bokeh, or lerp, between two blurs (off)", 0, 0,
	     stilb_post_dof_names},
		{"--aperture", FLAG_AMOUNT, &p->aperture, "R", "radius of the lens, metres, with --dof", 0, 1000000, NULL},
		{"--focus", FLAG_AMOUNT, &p->focus, "D", "distance of the plane in focus, metres, with --dof", 0, 1000000,
	     NULL},
		{"--blades", FLAG_NUMBER, &p->blades, "N", "corners of the aperture, 3..16; 0: a circle (0)", 0, 16, NULL},
		{"--preset", FLAG_TEXT, &p->preset, "FILE.json", "a look: all of these settings, as far as no flag says others",
	     0, 0, NULL},
	};
	flag_rows_add(table, post, sizeof post / sizeof *post);
}

void picture_flags_add(picture_flags *picture, picture_flags_group group, flag_rows *table)
{
	STILB_ASSERT(picture && table);
	STILB_ASSERT((unsigned)group <= PICTURE_ADDED);
	picture_add_drawing(picture, group, table);
	picture_add_shading(picture, group, table);
	if (group == PICTURE_POSE)
		picture_add_pose(picture, table);
	if (group == PICTURE_PLACE)
		picture_add_place(picture, table);
	if (group == PICTURE_EXPOSURE)
		picture_add_exposure(picture, table);
	if (group == PICTURE_LOOK)
		picture_add_look(picture, table);
	if (group == PICTURE_POST)
		picture_add_post(picture, table);
	if (group == PICTURE_TONE)
		picture_add_tone(picture, table);
}

/* ---- what the flags mean ----------------------------------------------------------------------------------------- */

stilb_render_detail picture_flags_detail(const picture_flags *p)
{
	return (stilb_render_detail){(stilb_render_detail_mode)p->detail, p->detail_error};
}

stilb_post_settings picture_flags_post(const picture_flags *p)
{
	stilb_post_settings settings = p->post;
	settings.occlusion = p->occlusion;
	settings.occlusion_radius = p->occlusion_radius;
	settings.bloom = p->bloom;
	settings.bloom_width = p->bloom_width;
	settings.bloom_format = (stilb_post_bloom_format)p->bloom_format;
	settings.place = (stilb_post_place)p->post_place;
	settings.dither = (stilb_post_dither)p->dither;
	settings.exposure_adapts = picture_flags_adapt(p);
	settings.aa = (stilb_post_aa)p->aa;
	settings.motion_blur = p->motion_blur;
	settings.motion_blur_most = p->motion_blur_most;
	settings.motion = (stilb_post_motion)p->motion;
	settings.motion_blur_far = p->motion_blur_far;
	settings.reflections = (stilb_post_reflections)p->reflections;
	settings.dof = (stilb_post_dof)p->dof;
	settings.aperture = p->aperture;
	settings.focus = p->focus;
	settings.blades = (uint32_t)p->blades;
	return settings;
}

bool picture_flags_parts(const picture_flags *p)
{
	return p->ndf != PICTURE_NOT_GIVEN || p->g != PICTURE_NOT_GIVEN || p->f != PICTURE_NOT_GIVEN;
}

bool picture_flags_show(const picture_flags *p, stilb_render_show *show, picture_shown *image)
{
	flag_list range;
	*show = STILB_RENDER_SHOW_SHADED;
	*image = (picture_shown){.high = 1.0f};
	for (int s = 0; p->show && s < STILB_RENDER_SHOWS; s++)
		if (strcmp(p->show, stilb_render_show_names[s]) == 0) {
			*show = (stilb_render_show)s;
			return false;
		}
	if (!p->show)
		return false;
	size_t length = strcspn(p->show, ":");
	snprintf(image->name, sizeof image->name, "%.*s", (int)length, p->show);
	if (p->show[length] == ':') /* picture_check_show has looked at these */
		sscanf(p->show + length, ":%" SCNu32 ":%" SCNu32, &image->mip, &image->layer);
	if (p->show_range && flags_numbers(p->show_range, 2, 2, &range)) {
		image->low = range.numbers[0];
		image->high = range.numbers[1];
	}
	return true;
}

static bool picture_check_show(const picture_flags *p)
{
	flag_list range;
	const char *colon = p->show ? strchr(p->show, ':') : NULL;
	uint32_t mip, layer;
	int end = 0;
	if (colon && !((sscanf(colon, ":%" SCNu32 "%n", &mip, &end) == 1 && colon[end] == '\0') ||
	               (sscanf(colon, ":%" SCNu32 ":%" SCNu32 "%n", &mip, &layer, &end) == 2 && colon[end] == '\0'))) {
		stilb_log("--show: '%s' is no IMAGE:MIP or IMAGE:MIP:LAYER; give numbers from 0 on", p->show);
		return false;
	}
	stilb_render_show kind;
	picture_shown image;
	picture_flags_show(p, &kind, &image);
	bool of_shadows =
		kind == STILB_RENDER_SHOW_CASCADES || kind == STILB_RENDER_SHOW_ATLAS || kind == STILB_RENDER_SHOW_ACNE;
	if (of_shadows && p->shadows == STILB_ENGINE_SHADOWS_OFF) {
		stilb_log("--show %s is of shadows; leave out --shadows off", p->show);
		return false;
	}
	if (p->show_range && !picture_flags_show(p, &kind, &image)) {
		stilb_log("--show-range is of an image; name one with --show");
		return false;
	}
	if (p->show_range && (!flags_numbers(p->show_range, 2, 2, &range) || range.numbers[0] == range.numbers[1] ||
	                      !isfinite(range.numbers[0]) || !isfinite(range.numbers[1]))) {
		stilb_log("--show-range: '%s' is not LOW,HIGH; give two different numbers separated by a comma", p->show_range);
		return false;
	}
	if (picture_flags_show(p, &kind, &image) && stilb_engine_image_is_of_one_sample(image.name) && p->samples > 1) {
		stilb_log("--show %s has one sample a pixel; leave out --msaa", image.name);
		return false;
	}
	return true;
}

#define PICTURE_CAMERA "X,Y,Z,YAW,PITCH[,FOV]"
#define PICTURE_STOPS 32.0f   /* the largest --exposure, and the smallest is its negative */
#define PICTURE_WHITE (-3.0f) /* a metered exposure below it: white would be shown as more than 8 */

/* True if text is meant as numbers with commas between: no camera of a file is asked for. */
static bool picture_is_list(const char *text)
{
	return strchr(text, ',') && strspn(text, "+-.,0123456789eE ") == strlen(text);
}

bool picture_flags_check_camera(const char *name, const char *text)
{
	flag_list list;
	if (!text || !picture_is_list(text))
		return true;
	if (!flags_numbers(text, 5, 6, &list)) {
		stilb_log("%s: '%s' is not " PICTURE_CAMERA "; give numbers separated by commas", name, text);
		return false;
	}
	for (uint32_t i = 0; i < list.count; i++)
		if (!isfinite(list.numbers[i])) {
			stilb_log("%s: '%s' is out of range in number %" PRIu32 "; give numbers in -%.2g..%.2g", name, text, i + 1,
			          (double)FLT_MAX, (double)FLT_MAX);
			return false;
		}
	if (list.count == 6 && !(list.numbers[5] > 0.0f && list.numbers[5] < 180.0f)) {
		stilb_log("%s: '%g' is not a field of view; give degrees between 0 and 180", name, (double)list.numbers[5]);
		return false;
	}
	return true;
}

bool picture_flags_adapt(const picture_flags *p)
{
	return p->exposure && strcmp(p->exposure, "adapt") == 0;
}

/* Reads --exposure, a number of stops, "adapt", which is 0, or "auto", which is NaN. Returns false if it is none. */
static bool picture_parse_exposure(const char *text, float *stops)
{
	flag_list list;
	*stops = NAN;
	if (strcmp(text, "auto") == 0)
		return true;
	if (strcmp(text, "adapt") == 0) {
		*stops = 0.0f;
		return true;
	}
	if (!flags_numbers(text, 1, 1, &list) || !(fabsf(list.numbers[0]) <= PICTURE_STOPS))
		return false;
	*stops = list.numbers[0];
	return true;
}

/* Reads the color of --background, "#RRGGBB" in codes or "R,G,B" as linear light, each 0..1. False: it is none. */
static bool picture_parse_color(const char *text, float color[3])
{
	unsigned red, green, blue;
	flag_list list;
	int end = 0;
	if (sscanf(text, "#%2x%2x%2x%n", &red, &green, &blue, &end) == 3 && end == 7 && text[7] == '\0') {
		const unsigned codes[3] = {red, green, blue};
		for (int i = 0; i < 3; i++)
			color[i] = shade_srgb_to_linear((float)codes[i] / 255.0f);
		return true;
	}
	if (!flags_numbers(text, 3, 3, &list))
		return false;
	for (int i = 0; i < 3; i++) {
		color[i] = list.numbers[i];
		if (!(color[i] >= 0.0f && color[i] <= 1.0f))
			return false;
	}
	return true;
}

static bool picture_is_background(const char *text)
{
	float color[3];
	return strcmp(text, "environment") == 0 || strcmp(text, "blur") == 0 || strcmp(text, "transparent") == 0 ||
	       picture_parse_color(text, color);
}

bool picture_flags_are_transparent(const picture_flags *p)
{
	return p->background && strcmp(p->background, "transparent") == 0;
}

static bool picture_check_shadows(const picture_flags *p)
{
	bool gathers = p->shadow_filter == STILB_ENGINE_SHADOW_FILTER_GATHER;
	bool few = p->shadow_samples == 0 || p->shadow_samples == 1 || p->shadow_samples == 4;
	if (!few && !(gathers ? p->shadow_samples == 16 || p->shadow_samples == 36 : p->shadow_samples == 12)) {
		stilb_log("--shadow-samples: %" PRIu64 " are not possible; give %s with --shadow-filter %s", p->shadow_samples,
		          gathers ? "1, 4, 16 or 36" : "1, 4 or 12", stilb_engine_shadow_filter_names[p->shadow_filter]);
		return false;
	}
	if (p->cascade_size & (p->cascade_size - 1)) {
		stilb_log("--cascade-size: %" PRIu64 " is not a power of two; give 512, 1024, 2048, ...", p->cascade_size);
		return false;
	}
	if (p->shadow_objects && (!(p->shadow_distance > 0.0f) || p->cascades > 1)) {
		stilb_log("--shadow-objects has one map that ends somewhere; give --shadow-distance, and leave out --cascades");
		return false;
	}
	if (p->shadows != STILB_ENGINE_SHADOWS_BUFFER)
		return true;
	if (p->samples > 1) {
		stilb_log("--shadows buffer has one sample a pixel; leave out --msaa, or give --shadows map");
		return false;
	}
	if (p->lighting == STILB_RENDER_LIGHTING_MULTIPASS) {
		stilb_log("--shadows buffer is not of --lighting multipass; give --shadows map, or another way");
		return false;
	}
	return true;
}

/* Of --lighting and what goes with it. */
static bool picture_check_lighting(const picture_flags *p)
{
	stilb_render_lighting way = (stilb_render_lighting)p->lighting;
	bool surfaces = way == STILB_RENDER_LIGHTING_DEFERRED || way == STILB_RENDER_LIGHTING_TILED_DEFERRED;
	bool covers = way == STILB_RENDER_LIGHTING_DEFERRED || way == STILB_RENDER_LIGHTING_PREPASS ||
	              way == STILB_RENDER_LIGHTING_PRELIGHT;
	if (stilb_render_lighting_is_of_one_sample(way) && p->samples > 1) {
		stilb_log("--lighting %s has one sample a pixel; leave out --msaa, or light in another way",
		          stilb_render_lighting_names[way]);
		return false;
	}
	if (!covers && p->coverage != 0) {
		stilb_log("--light-coverage is of --lighting deferred, prepass and prelight; give one of these, too");
		return false;
	}
	bool prunes = way == STILB_RENDER_LIGHTING_AUTO || way == STILB_RENDER_LIGHTING_CLUSTERED ||
	              way == STILB_RENDER_LIGHTING_TILED_DEFERRED ||
	              (way == STILB_RENDER_LIGHTING_DEFERRED && p->coverage == STILB_RENDER_COVERAGE_CELLS);
	if (!prunes && p->light_tolerance > 0.0f) {
		stilb_log("--light-tolerance is of --lighting auto, clustered, tiled-deferred and deferred by cells; take one");
		return false;
	}
	if (p->light_lists == STILB_RENDER_LIGHT_LISTS_COMPUTE && p->light_tolerance > 0.0f) {
		stilb_log("--light-tolerance shortens lists by jobs alone; leave out --light-lists compute");
		return false;
	}
	if (!surfaces && p->gbuffer != 0) {
		stilb_log("--gbuffer is of --lighting deferred and tiled-deferred; give one of these, too");
		return false;
	}
	return true;
}

static bool picture_check_dof(const picture_flags *p)
{
	bool dof = p->dof != STILB_POST_DOF_OFF;
	if (dof && p->samples > 1)
		stilb_log("--dof has one sample a pixel; leave out --msaa");
	else if (dof && !p->preset && p->aperture <= 0.0f)
		stilb_log("--dof needs --aperture R, the radius of the lens in metres");
	else if (dof && p->aperture > 0.0f && p->focus <= 0.0f)
		stilb_log("--dof needs --focus D, the distance of the plane in focus in metres");
	else if (!dof && !p->preset && (p->aperture > 0.0f || p->focus > 0.0f || p->blades > 0))
		stilb_log("%s needs --dof bokeh: without it everything is in focus", p->aperture > 0.0f ? "--aperture"
		                                                                     : p->focus > 0.0f  ? "--focus"
		                                                                                        : "--blades");
	else if (p->blades == 1 || p->blades == 2)
		stilb_log("--blades: '%u' corners are too few; give 3..16, or 0 for a circle", (unsigned)p->blades);
	else
		return true;
	return false;
}

/* Light in 8 bits is written once: nothing can be added to it. */
static bool picture_check_hdr(const picture_flags *p)
{
	stilb_render_lighting way = (stilb_render_lighting)p->lighting;
	const char *hdr = stilb_render_hdr_names[p->hdr];
	bool adds = way == STILB_RENDER_LIGHTING_MULTIPASS || way == STILB_RENDER_LIGHTING_DEFERRED ||
	            way == STILB_RENDER_LIGHTING_TILED_DEFERRED;
	if (p->hdr == STILB_RENDER_HDR_HALF)
		return true;
	if (adds)
		stilb_log("--hdr %s: --lighting %s adds light, which needs --hdr half; light in another way", hdr,
		          stilb_render_lighting_names[way]);
	else if (p->occlusion > 0.0f || p->reflections != STILB_POST_REFLECTIONS_OFF)
		stilb_log("--hdr %s: %s adds the surroundings' light, which needs --hdr half; leave out one of them", hdr,
		          p->occlusion > 0.0f ? "--ao" : "--reflections");
	else if (picture_flags_are_transparent(p))
		stilb_log("--hdr %s: --background transparent needs alpha, which --hdr half alone has", hdr);
	else
		return true;
	return false;
}

static bool picture_check_post(const picture_flags *p)
{
	if (p->occlusion > 0.0f && p->samples > 1) {
		stilb_log("--ao has one sample a pixel; leave out --msaa");
		return false;
	}
	stilb_render_show show;
	picture_shown image;
	picture_flags_show(p, &show, &image);
	if (p->aa != STILB_POST_AA_NONE && show != STILB_RENDER_SHOW_SHADED) {
		stilb_log("--aa %s is of light, and --show %s shows numbers; leave out one of them", stilb_post_aa_names[p->aa],
		          p->show);
		return false;
	}
	if (p->reflections != STILB_POST_REFLECTIONS_OFF && p->samples > 1) {
		stilb_log("--reflections has one sample a pixel; leave out --msaa");
		return false;
	}
	return picture_check_hdr(p) && picture_check_dof(p);
}

bool picture_flags_check_look(const picture_flags *p)
{
	float color[3];
	if (p->background && picture_flags_adapt(p) && picture_parse_color(p->background, color)) {
		stilb_log("--background %s is shown as it is, which --exposure adapt cannot; give EV or auto", p->background);
		return false;
	}
	return picture_check_post(p);
}

bool picture_flags_check(const picture_flags *p)
{
	float stops;
	if (p->samples != 0 && p->samples != 1 && p->samples != 4) {
		stilb_log("--msaa: %" PRIu64 " samples are not possible; give 1 or 4", p->samples);
		return false;
	}
	if (!picture_check_lighting(p) || !picture_check_shadows(p) || !picture_flags_check_look(p))
		return false;
	if (!(p->detail_error >= PICTURE_ERROR_LEAST)) {
		stilb_log("--lod-error: %g pixels are not possible; give 0.01..%d, or --lod off", (double)p->detail_error,
		          PICTURE_ERROR_MOST);
		return false;
	}
	if (p->exposure && !picture_parse_exposure(p->exposure, &stops)) {
		stilb_log("--exposure: '%s' is neither auto nor adapt nor a number in -%.0f..%.0f", p->exposure,
		          (double)PICTURE_STOPS, (double)PICTURE_STOPS);
		return false;
	}
	if (p->background && !picture_is_background(p->background)) {
		stilb_log("--background: '%s' is not known; give environment, blur, transparent, #RRGGBB, or R,G,B in 0..1",
		          p->background);
		return false;
	}
	return picture_check_show(p) && picture_flags_check_camera("--camera", p->camera);
}

void picture_flags_log_start(const picture_flags *p, stilb_result result)
{
	bool device = result == STILB_ERROR_DEVICE && p->device != STILB_RENDER_DEVICE_NULL;
	stilb_log("%s%s", stilb_error_message(), device ? ", or run without a GPU with --device null" : "");
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

/* Appends the file's cameras to a message, as many as fit: "1 'Front', 2 'Top'". */
static void picture_list_cameras(const stilb_scene *scene, char *text, size_t size)
{
	size_t used = 0;
	text[0] = '\0';
	for (uint32_t i = 0; i < scene->camera_count && used < size; i++)
		used +=
			(size_t)snprintf(text + used, size - used, "%s%u '%s'", i > 0 ? ", " : "", i + 1, scene->cameras[i].name);
}

stilb_result picture_flags_camera(const char *name, const char *text, const stilb_scene *scene, uint32_t *index)
{
	STILB_ASSERT(name && text && scene && index);
	*index = 0;
	char list[256], *end;
	unsigned long number = strtoul(text, &end, 10);
	for (uint32_t i = 0; i < scene->camera_count; i++)
		if (strcmp(scene->cameras[i].name, text) == 0) {
			*index = i;
			return STILB_OK;
		}
	if (*end == '\0' && number >= 1 && number <= scene->camera_count) {
		*index = (uint32_t)number - 1;
		return STILB_OK;
	}
	picture_list_cameras(scene, list, sizeof list);
	if (scene->camera_count == 0)
		return stilb_fail(STILB_ERROR_ARGUMENT,
		                  "%s: there is no camera '%s', since the scene has none; give " PICTURE_CAMERA, name, text);
	return stilb_fail(STILB_ERROR_ARGUMENT, "%s: there is no camera '%s'; the scene has %s", name, text, list);
}

static void picture_place_numbers(const flag_list *list, stilb_scene_camera *camera)
{
	for (int i = 0; i < 3; i++)
		camera->position[i] = list->numbers[i];
	camera->yaw = picture_radians(list->numbers[3]);
	camera->pitch = picture_radians(list->numbers[4]);
	camera->roll = 0.0f;
	if (list->count > 5)
		camera->fov_y = picture_radians(list->numbers[5]);
}

stilb_result picture_flags_look(const char *name, const char *text, const stilb_scene *scene,
                                stilb_scene_camera *camera)
{
	flag_list list;
	uint32_t index;
	STILB_ASSERT(camera);
	if (flags_numbers(text, 5, 6, &list)) {
		*camera = scene->camera;
		picture_place_numbers(&list, camera);
		return STILB_OK;
	}
	stilb_result result = picture_flags_camera(name, text, scene, &index);
	if (result == STILB_OK)
		*camera = scene->cameras[index].camera;
	return result;
}

stilb_result picture_flags_place(const picture_flags *p, float aspect, stilb_scene *scene)
{
	if (scene->framed)
		scene->camera = stilb_scene_frame(scene, STILB_SCENE_FRAME_YAW, STILB_SCENE_FRAME_PITCH, aspect);
	if (!p->camera)
		return STILB_OK;
	stilb_result result = picture_flags_look("--camera", p->camera, scene, &scene->camera);
	scene->framed = scene->framed && result != STILB_OK;
	return result;
}

static bool picture_has_photometric(const stilb_scene *scene)
{
	for (uint32_t i = 0; i < scene->light_count; i++)
		if (scene->lights[i].unit == STILB_SCENE_LIGHT_PHOTOMETRIC)
			return true;
	return false;
}

/* The largest light of a background: shown as code 255, while the tone map's inverse is still far from infinite. */
#define PICTURE_BRIGHTEST 0.998f

/* True if the tone map shows some radiance, *light, as this color, within half a code. */
static bool picture_shows(uint32_t tone, stilb_vec3 color, stilb_vec3 *light)
{
	*light = shade_tone_inverse((int)tone, color);
	stilb_vec3 error = shade_tone((int)tone, *light) - color;
	for (int i = 0; i < 3; i++)
		if (!(fabsf(error[i]) < 1.0f / 512.0f))
			return false;
	return true;
}

/* The radiance that is shown as this color. NEUTRAL whitens what is bright: instead of a color that it shows nothing
 * as, it is the most saturated one of the same largest channel; false then. */
static bool picture_light_shown_as(uint32_t tone, stilb_vec3 color, stilb_vec3 *light)
{
	float largest = fmaxf(fmaxf(color[0], color[1]), color[2]), low = 0.0f, high = 1.0f; /* shares of white */
	if (picture_shows(tone, color, light))
		return true;
	for (int i = 0; i < 20; i++) {
		float white = 0.5f * (low + high);
		if (picture_shows(tone, color + (largest - color) * white, light))
			high = white;
		else
			low = white;
	}
	picture_shows(tone, color + (largest - color) * high, light);
	return false;
}

/* Sets a color of --background to the radiance that is shown as this color. */
static void picture_color_background(const picture_flags *p, stilb_scene *scene)
{
	float color[3];
	stilb_vec3 radiance;
	if (!p->background || !picture_parse_color(p->background, color))
		return;
	stilb_vec3 shown = stilb_vec3_make(fminf(color[0], PICTURE_BRIGHTEST), fminf(color[1], PICTURE_BRIGHTEST),
	                                   fminf(color[2], PICTURE_BRIGHTEST));
	if (!picture_light_shown_as(scene->camera.tone, shown, &radiance))
		stilb_log("--background: the tone map '%s' whitens what is as bright as '%s'; --tone knee shows it as it is",
		          stilb_scene_tone_names[scene->camera.tone], p->background);
	radiance *= exp2f(-scene->camera.exposure);
	stilb_scene_set_backdrop(scene, (const float[3]){radiance[0], radiance[1], radiance[2]});
}

static stilb_result picture_expose(const picture_flags *p, stilb_scene *scene, bool *metered)
{
	float stops = 0.0f, light = 0.0f;
	stilb_scene_camera camera = scene->camera;
	*metered = false;
	scene->camera.exposure = 0.0f;
	if (p->exposure)
		picture_parse_exposure(p->exposure, &stops);
	else if (scene->light_count > 0 && !scene->studio)
		stops = NAN;
	if (!isnan(stops)) {
		scene->camera.exposure = stops;
		return STILB_OK;
	}
	if (scene->framed)
		camera = stilb_scene_frame(scene, STILB_SCENE_FRAME_YAW, STILB_SCENE_FRAME_PITCH, 1.0f);
	stilb_result result = stilb_scene_meter(scene, &camera, &light);
	*metered = result == STILB_OK && (p->exposure || picture_has_photometric(scene) || light < PICTURE_WHITE);
	scene->camera.exposure = *metered ? light : 0.0f;
	return result;
}

void picture_flags_tone(const picture_flags *p, stilb_scene *scene)
{
	if (p->tone == PICTURE_NOT_GIVEN)
		return;
	scene->camera.tone = (uint32_t)p->tone;
	for (uint32_t i = 0; i < scene->camera_count; i++)
		scene->cameras[i].camera.tone = (uint32_t)p->tone;
}

stilb_result picture_flags_expose(const picture_flags *p, stilb_scene *scene, bool *metered)
{
	picture_flags_tone(p, scene);
	stilb_result result = picture_expose(p, scene, metered);
	picture_color_background(p, scene);
	return result;
}

/* The clips of a scene as a list of names, cut to fit. */
static void picture_list_clips(const stilb_scene *scene, char *text, size_t size)
{
	size_t used = 0;
	text[0] = '\0';
	for (uint32_t c = 0; c < scene->animation->clip_count && used < size; c++)
		used += (size_t)snprintf(text + used, size - used, "%s%s", c > 0 ? ", " : "", scene->animation->clips[c].name);
}

stilb_result picture_flags_pose(const picture_flags *p, stilb_scene *scene)
{
	char names[512];
	uint32_t count = scene->animation && scene->figures ? scene->animation->clip_count : 0, clip = 0;
	if (count == 0)
		return !p->animation || strcmp(p->animation, "none") == 0
		           ? STILB_OK
		           : stilb_fail(STILB_ERROR_ARGUMENT, "--animation: the scene has no animation '%s', and no other",
		                        p->animation);
	if (p->animation) {
		clip = stilb_scene_find_clip(scene, p->animation);
		if (clip == STILB_SCENE_NONE && strcmp(p->animation, "none") == 0)
			return STILB_OK;
	}
	if (clip == STILB_SCENE_NONE) {
		picture_list_clips(scene, names, sizeof names);
		return stilb_fail(STILB_ERROR_ARGUMENT, "--animation: there is no '%s'; the scene has %u: %s", p->animation,
		                  count, names);
	}
	stilb_scene_play play = stilb_scene_play_make(clip);
	play.time = (double)p->at;
	stilb_result result = scene->framed ? stilb_scene_sweep(scene, clip) : STILB_OK;
	if (result == STILB_OK)
		result = stilb_scene_set_plays(scene, 0, &play, 1);
	if (result != STILB_OK)
		return result;
	stilb_scene_advance(scene, 0.0, NULL, 0);
	stilb_scene_update_nodes(scene, NULL, 0);
	return STILB_OK;
}

stilb_result picture_flags_variant(const picture_flags *p, stilb_scene *scene)
{
	if (!p->variant)
		return STILB_OK;
	stilb_result result = stilb_scene_show_variant_named(scene, p->variant);
	return result == STILB_OK ? result : stilb_fail(result, "--variant: %s", stilb_error_message());
}

static stilb_result picture_environment(const char *environment, stilb_scene *scene)
{
	flag_list color;
	if (!flags_numbers(environment, 3, 3, &color))
		return stilb_scene_set_environment(scene, environment);
	for (int i = 0; i < 3; i++)
		if (!(color.numbers[i] >= 0.0f && isfinite(color.numbers[i])))
			return stilb_fail(STILB_ERROR_ARGUMENT, "--environment: '%s' is out of range; give radiances in 0..%.2g",
			                  environment, (double)FLT_MAX);
	stilb_scene_set_sky(scene, color.numbers);
	scene->surroundings.glossy = true; /* as rays mirror it */
	return STILB_OK;
}

/* The yaw of the camera that the flags choose; a camera that is not there is told later. */
static float picture_yaw(const picture_flags *p, const stilb_scene *scene)
{
	flag_list list;
	uint32_t index;
	if (p->camera && flags_numbers(p->camera, 5, 6, &list))
		return picture_radians(list.numbers[3]);
	if (p->camera && picture_flags_camera("--camera", p->camera, scene, &index) == STILB_OK)
		return scene->cameras[index].camera.yaw;
	return scene->camera.yaw;
}

/* Light for a scene without --environment. */
static stilb_result picture_light(const picture_flags *p, const char *name, stilb_scene *scene)
{
	bool studio = p->studio == PICTURE_STUDIO_ON || (p->studio == PICTURE_STUDIO_AUTO && scene->unlit);
	if (scene->unlit && p->studio != PICTURE_STUDIO_ON && !p->quiet)
		stilb_log("%s: it has no light: a %s shines on it", name, studio ? "studio" : "grey sky");
	if (studio)
		return stilb_scene_set_studio(scene, picture_yaw(p, scene));
	if (scene->unlit)
		scene->surroundings = (stilb_scene_surroundings){.sky = {1, 1, 1}, .ground = {0.4f, 0.4f, 0.4f}};
	return STILB_OK;
}

stilb_result picture_flags_surroundings(const picture_flags *p, const char *name, stilb_scene *scene)
{
	STILB_ASSERT(p && name && scene);
	stilb_result result = STILB_OK;
	if (p->studio == PICTURE_STUDIO_ON || !p->environment)
		result = picture_light(p, name, scene);
	if (result == STILB_OK && p->environment)
		result = picture_environment(p->environment, scene);
	if (result != STILB_OK || !p->background)
		return result;
	if (picture_flags_are_transparent(p))
		stilb_scene_set_backdrop(scene, NULL);
	else if (strcmp(p->background, "blur") == 0 || strcmp(p->background, "environment") == 0)
		result = stilb_scene_show_surroundings(scene, p->background[0] == 'b');
	return result;
}
