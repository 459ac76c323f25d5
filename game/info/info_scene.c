#include "info_scene.h"

#include "base/base_file.h"
#include "base/base_json.h"
#include "engine.h"
#include "game/cli/flags.h"
#include "game/cli/picture_flags.h"

#include <float.h>
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#define INFO_DEGREES 57.29577951308232 /* in a radian */

typedef struct info_contents {
	const stilb_scene *scene;
	double seconds; /* that opening took */
	uint64_t vertices, triangles;
	uint64_t drawn;        /* triangles of all parts: a mesh counts once for each part that shows it */
	uint64_t emitting;     /* of these, those whose material emits */
	uint64_t bytes;        /* of meshes, textures and environment */
	uint64_t import_bytes; /* the most memory of the import process at once; 0: unknown */
	uint32_t lights[STILB_SCENE_LIGHT_KINDS];
	uint64_t hidden;       /* of emitting, those of parts that are no light's face: frames are not lit by them */
	bool metered;          /* the camera's exposure is */
	float low[3], high[3]; /* the box around all vertices, metres; low > high: there are none */
} info_contents;

static bool info_shines(const float light[3])
{
	return light[0] > 0.0f || light[1] > 0.0f || light[2] > 0.0f;
}

/* Grows the box to hold the vertices of a part, in the world. */
static void info_box_part(info_contents *c, const stilb_scene_mesh *mesh, const stilb_mat4 *transform)
{
	const float *m = transform->m;
	for (uint32_t v = 0; v < mesh->vertex_count; v++) {
		const float *p = mesh->vertices[v].position;
		for (int i = 0; i < 3; i++) {
			float world = m[i] * p[0] + m[4 + i] * p[1] + m[8 + i] * p[2] + m[12 + i];
			c->low[i] = world < c->low[i] ? world : c->low[i];
			c->high[i] = world > c->high[i] ? world : c->high[i];
		}
	}
}

static info_contents info_count(const stilb_scene *scene, double seconds)
{
	info_contents c = {
		.scene = scene,
		.seconds = seconds,
		.bytes = stilb_image_size(&scene->surroundings.panorama),
		.low = {FLT_MAX, FLT_MAX, FLT_MAX},
		.high = {-FLT_MAX, -FLT_MAX, -FLT_MAX},
	};
	for (uint32_t i = 0; i < scene->mesh_count; i++) {
		c.vertices += scene->meshes[i].vertex_count;
		c.triangles += scene->meshes[i].index_count / 3;
	}
	c.bytes += c.vertices * sizeof(stilb_scene_vertex) + 3 * c.triangles * sizeof(uint32_t);
	for (uint32_t p = 0; p < scene->part_count; p++) {
		const stilb_scene_mesh *mesh = &scene->meshes[scene->part_mesh[p]];
		uint32_t triangles = mesh->index_count / 3;
		info_box_part(&c, mesh, &scene->part_transform[p]);
		c.drawn += triangles;
		c.emitting += info_shines(scene->materials[scene->part_material[p]].emission) ? triangles : 0;
	}
	for (uint32_t i = 0; i < scene->texture_count; i++)
		c.bytes += stilb_image_levels_size(&scene->textures[i]);
	c.hidden = c.emitting;
	for (uint32_t i = 0; i < scene->light_count; i++) {
		const stilb_scene_light *light = &scene->lights[i];
		c.lights[light->kind]++;
		uint32_t face = light->face ? scene->meshes[scene->part_mesh[light->face - 1]].index_count / 3 : 0;
		c.hidden -= face < c.hidden ? face : c.hidden;
	}
	return c;
}

/* The letter that makes a plural. */
static const char *info_s(uint64_t count)
{
	return count == 1 ? "" : "s";
}

/* The bits of a channel; of blocks those of their texels. */
static int info_bits(const stilb_image *image)
{
	stilb_image texel = *image;
	texel.width = texel.height = 1;
	texel.format = stilb_image_decoded_format(image->format);
	return (int)(stilb_image_size(&texel) * 8 / image->channels);
}

/* The kind of blocks that a picture is made of; NULL: of none. */
static const char *info_blocks(const stilb_image *image)
{
	static const char *const names[STILB_IMAGE_FORMAT_COUNT] = {
		[STILB_IMAGE_BC1_SRGB] = "BC1",   [STILB_IMAGE_BC1_LINEAR] = "BC1", [STILB_IMAGE_BC3_SRGB] = "BC3",
		[STILB_IMAGE_BC3_LINEAR] = "BC3", [STILB_IMAGE_BC4_LINEAR] = "BC4", [STILB_IMAGE_BC5_LINEAR] = "BC5",
		[STILB_IMAGE_BC7_SRGB] = "BC7",   [STILB_IMAGE_BC7_LINEAR] = "BC7"};
	return names[image->format];
}

static void info_print_texture(FILE *out, const stilb_image *image, uint32_t id)
{
	const char *blocks = info_blocks(image);
	uint32_t levels = stilb_image_level_count(image);
	fprintf(out, "    texture %u: %ux%u, %u channel%s of %d bits", id, image->width, image->height, image->channels,
	        info_s(image->channels), info_bits(image));
	if (blocks)
		fprintf(out, " in blocks of %s", blocks);
	if (levels > 1)
		fprintf(out, ", %u mips", levels);
	fprintf(out, "\n");
}

/* How many of these hang on nodes; mounts: NULL, or [count]. */
static uint32_t info_mounted(const stilb_scene_mount *mounts, uint32_t count)
{
	uint32_t mounted = 0;
	for (uint32_t i = 0; mounts && i < count; i++)
		mounted += mounts[i].node > 0;
	return mounted;
}

static void info_print_nodes(FILE *out, const stilb_scene *scene)
{
	uint32_t lights = info_mounted(scene->light_mounts, scene->light_count);
	uint32_t cameras = info_mounted(scene->camera_mounts, scene->camera_count);
	fprintf(out, "; %u node%s", scene->nodes.count, info_s(scene->nodes.count));
	if (lights > 0)
		fprintf(out, ", with %u light%s", lights, info_s(lights));
	if (cameras > 0)
		fprintf(out, "%s%u camera%s", lights > 0 ? " and " : ", with ", cameras, info_s(cameras));
}

/* What frames do not draw, of what is there: X(words, is it there). */
#define INFO_NOT_LIVE(X) X("light from emitting triangles", c->hidden > 0)

static void info_print_lights(FILE *out, const info_contents *c)
{
	const stilb_scene *scene = c->scene;
	const char *comma = "  lights: ";
	for (int i = 0; i < STILB_SCENE_LIGHT_KINDS; i++)
		if (c->lights[i] > 0) {
			fprintf(out, "%s%u %s", comma, c->lights[i], stilb_scene_light_kind_names[i]);
			comma = ", ";
		}
	if (c->hidden > 0) {
		fprintf(out, "%s%" PRIu64 " emitting triangle%s", comma, c->hidden, info_s(c->hidden));
		comma = ", ";
	}
	fprintf(out, "%s\n", comma[0] == ',' ? "" : "  lights: none");
	if (scene->unlit)
		fprintf(out, "  nothing lights it: pictures show it in a studio, see --studio\n");
	if (scene->surroundings.panorama.pixels)
		fprintf(out, "  surroundings: a panorama of %ux%u pixels\n", scene->surroundings.panorama.width,
		        scene->surroundings.panorama.height);
	else if (info_shines(scene->surroundings.sky) || info_shines(scene->surroundings.ground))
		fprintf(out, "  surroundings: a sky of %.3g, %.3g, %.3g over a ground of %.3g, %.3g, %.3g\n",
		        (double)scene->surroundings.sky[0], (double)scene->surroundings.sky[1],
		        (double)scene->surroundings.sky[2], (double)scene->surroundings.ground[0],
		        (double)scene->surroundings.ground[1], (double)scene->surroundings.ground[2]);
	else
		fprintf(out, "  surroundings: black\n");
}

/* What models may differ in: the flag, words for one model, a key for JSON. */
static const struct info_flag {
	uint32_t flag;
	const char *words, *key;
} info_flags[] = {
	{STILB_SCENE_MODEL_UNSEEN, "unseen", "unseen_models"},
	{STILB_SCENE_MODEL_CASTS_NO_SHADOW, "without a shadow", "shadowless_models"},
	{STILB_SCENE_MODEL_RECEIVES_NO_SHADOW, "on which no shadow falls", "unshadowed_models"},
};

static uint32_t info_flagged(const stilb_scene *scene, uint32_t bit)
{
	uint32_t count = 0;
	for (uint32_t m = 0; m < scene->model_count; m++)
		count += (scene->model_flags[m] & bit) != 0;
	return count;
}

static void info_print_flags(FILE *out, const stilb_scene *scene)
{
	const char *comma = "  models: ";
	for (size_t i = 0; i < sizeof info_flags / sizeof *info_flags && scene->flags_used; i++) {
		uint32_t count = info_flagged(scene, info_flags[i].flag);
		if (count == 0)
			continue;
		fprintf(out, "%s%u %s", comma, count, info_flags[i].words);
		comma = ", ";
	}
	if (comma[0] == ',')
		fprintf(out, "\n");
}

static void info_print_variants(FILE *out, const stilb_scene_variants *variants)
{
	for (uint32_t v = 0; variants && v < variants->count; v++)
		fprintf(out, "%s'%s'", v == 0 ? "  variants of materials: " : ", ", variants->names[v]);
	if (variants)
		fprintf(out, "\n");
}

/* number: of a camera of the file, from 1 on; 0: it is Stilb's own. */
static void info_print_camera(FILE *out, uint32_t number, const char *name, const stilb_scene_camera *camera)
{
	if (number > 0)
		fprintf(out, "  camera %u '%s':", number, name);
	else
		fprintf(out, "  camera:");
	/* + 0.0 makes 0 of -0. */
	fprintf(out, " --camera %.6g,%.6g,%.6g,%.6g,%.6g,%.6g\n", (double)camera->position[0], (double)camera->position[1],
	        (double)camera->position[2], (double)camera->yaw * INFO_DEGREES + 0.0,
	        (double)camera->pitch * INFO_DEGREES + 0.0, (double)camera->fov_y * INFO_DEGREES);
}

static void info_print_animation(FILE *out, const stilb_scene_animation *a)
{
	uint32_t skinned = 0, morphed = 0, targets = 0;
	if (!a)
		return;
	for (uint32_t d = 0; d < a->deform_count; d++) {
		skinned += a->deforms[d].influences > 0;
		morphed += a->deforms[d].targets > 0;
		targets += a->deforms[d].targets;
	}
	const char *comma = "  ";
	if (a->clip_count > 0)
		fprintf(out, "%s%u animation%s", comma, a->clip_count, info_s(a->clip_count));
	comma = a->clip_count > 0 ? ", " : comma;
	if (a->skin_count > 0)
		fprintf(out, "%s%u skin%s of %u joint%s on %u mesh%s", comma, a->skin_count, info_s(a->skin_count),
		        a->joint_count, info_s(a->joint_count), skinned, skinned == 1 ? "" : "es");
	comma = a->skin_count > 0 ? ", " : comma;
	if (targets > 0)
		fprintf(out, "%s%u morph target%s of %u mesh%s", comma, targets, info_s(targets), morphed,
		        morphed == 1 ? "" : "es");
	fprintf(out, "\n");
	for (uint32_t c = 0; c < a->clip_count; c++)
		fprintf(out, "    animation %u '%s': %.3f s, %u channel%s\n", c + 1, a->clips[c].name,
		        (double)a->clips[c].duration, a->clips[c].channel_count, info_s(a->clips[c].channel_count));
}

static void info_print_scene(FILE *out, const char *name, const info_contents *c)
{
	const stilb_scene *scene = c->scene;
	fprintf(out, "%s, opened in %.2f s, %.1f MiB", name, c->seconds, (double)c->bytes / 1048576.0);
	if (c->import_bytes > 0)
		fprintf(out, "; the import process had %.1f MiB at most", (double)c->import_bytes / 1048576.0);
	fprintf(out, "\n");
	fprintf(out, "  %u model%s of %u part%s; %u mesh%s with %" PRIu64 " triangle%s and %" PRIu64 " vertices",
	        scene->model_count, info_s(scene->model_count), scene->part_count, info_s(scene->part_count),
	        scene->mesh_count, scene->mesh_count == 1 ? "" : "es", c->triangles, info_s(c->triangles), c->vertices);
	if (c->drawn != c->triangles)
		fprintf(out, ", drawn as %" PRIu64 " triangles", c->drawn);
	if (scene->nodes.count > 0)
		info_print_nodes(out, scene);
	fprintf(out, "\n");
	if (c->low[0] <= c->high[0])
		fprintf(out, "  from %.4g, %.4g, %.4g to %.4g, %.4g, %.4g m\n", (double)c->low[0], (double)c->low[1],
		        (double)c->low[2], (double)c->high[0], (double)c->high[1], (double)c->high[2]);
	fprintf(out, "  %u material%s, %u texture%s\n", scene->material_count, info_s(scene->material_count),
	        scene->texture_count, info_s(scene->texture_count));
	for (uint32_t i = 0; i < scene->texture_count; i++)
		info_print_texture(out, &scene->textures[i], i);
	info_print_flags(out, scene);
	info_print_variants(out, scene->variants);
	info_print_animation(out, scene->animation);
	info_print_lights(out, c);
	for (uint32_t i = 0; i < scene->camera_count; i++)
		info_print_camera(out, i + 1, scene->cameras[i].name, &scene->cameras[i].camera);
	if (scene->camera_count == 0)
		info_print_camera(out, 0, "", &scene->camera);
	if (c->metered)
		fprintf(out, "  exposure: %.2f EV, metered from the first camera\n", (double)scene->camera.exposure);
	const char *comma = "  only in traced pictures, not in live ones: ";
#define INFO_PRINT(words, there)                                                                                       \
	if (there) {                                                                                                       \
		fprintf(out, "%s%s", comma, words);                                                                            \
		comma = ", ";                                                                                                  \
	}
	INFO_NOT_LIVE(INFO_PRINT)
#undef INFO_PRINT
	if (comma[0] == ',')
		fprintf(out, "\n");
}

static void info_json_vector(stilb_json *json, const char *name, const float v[3])
{
	stilb_json_begin(json, name, '[');
	for (int i = 0; i < 3; i++)
		stilb_json_double(json, NULL, (double)v[i]);
	stilb_json_end(json, ']');
}

static void info_json_textures(stilb_json *json, const stilb_scene *scene)
{
	stilb_json_begin(json, "textures", '[');
	for (uint32_t i = 0; i < scene->texture_count; i++) {
		stilb_json_begin(json, NULL, '{');
		stilb_json_int(json, "width", scene->textures[i].width);
		stilb_json_int(json, "height", scene->textures[i].height);
		stilb_json_int(json, "channels", scene->textures[i].channels);
		stilb_json_int(json, "bits", info_bits(&scene->textures[i]));
		stilb_json_int(json, "mips", stilb_image_level_count(&scene->textures[i]));
		if (info_blocks(&scene->textures[i]))
			stilb_json_string(json, "blocks", info_blocks(&scene->textures[i]));
		stilb_json_end(json, '}');
	}
	stilb_json_end(json, ']');
}

static void info_json_variants(stilb_json *json, const stilb_scene_variants *variants)
{
	stilb_json_begin(json, "variants", '[');
	for (uint32_t v = 0; variants && v < variants->count; v++)
		stilb_json_string(json, NULL, variants->names[v]);
	stilb_json_end(json, ']');
}

static void info_json_cameras(stilb_json *json, const stilb_scene *scene)
{
	stilb_json_begin(json, "cameras", '[');
	for (uint32_t i = 0; i < scene->camera_count; i++)
		stilb_json_string(json, NULL, scene->cameras[i].name);
	stilb_json_end(json, ']');
}

static void info_json_animation(stilb_json *json, const stilb_scene_animation *a)
{
	stilb_json_begin(json, "animations", '[');
	for (uint32_t c = 0; a && c < a->clip_count; c++) {
		stilb_json_begin(json, NULL, '{');
		stilb_json_string(json, "name", a->clips[c].name);
		stilb_json_double(json, "seconds", (double)a->clips[c].duration);
		stilb_json_int(json, "channels", a->clips[c].channel_count);
		stilb_json_end(json, '}');
	}
	stilb_json_end(json, ']');
	stilb_json_begin(json, "skins", '[');
	for (uint32_t s = 0; a && s < a->skin_count; s++) {
		stilb_json_begin(json, NULL, '{');
		stilb_json_string(json, "name", a->skins[s].name);
		stilb_json_int(json, "joints", a->skins[s].joint_count);
		stilb_json_end(json, '}');
	}
	stilb_json_end(json, ']');
	int64_t targets = 0;
	for (uint32_t d = 0; a && d < a->deform_count; d++)
		targets += a->deforms[d].targets;
	stilb_json_int(json, "morph_targets", targets);
}

static stilb_result info_scene_save(const char *path, const char *name, const info_contents *c)
{
	const stilb_scene *scene = c->scene;
	stilb_json json = {0};
	stilb_json_begin(&json, NULL, '{');
	stilb_json_string(&json, "scene", name);
	stilb_json_double(&json, "seconds", c->seconds);
	stilb_json_int(&json, "bytes", (int64_t)c->bytes);
	stilb_json_int(&json, "import_bytes", (int64_t)c->import_bytes);
	stilb_json_int(&json, "models", scene->model_count);
	stilb_json_int(&json, "parts", scene->part_count);
	stilb_json_int(&json, "nodes", scene->nodes.count);
	stilb_json_int(&json, "lights_on_nodes", info_mounted(scene->light_mounts, scene->light_count));
	stilb_json_int(&json, "cameras_on_nodes", info_mounted(scene->camera_mounts, scene->camera_count));
	for (size_t i = 0; i < sizeof info_flags / sizeof *info_flags; i++)
		stilb_json_int(&json, info_flags[i].key, info_flagged(scene, info_flags[i].flag));
	stilb_json_int(&json, "meshes", scene->mesh_count);
	stilb_json_int(&json, "vertices", (int64_t)c->vertices);
	stilb_json_int(&json, "triangles", (int64_t)c->triangles);
	stilb_json_int(&json, "drawn_triangles", (int64_t)c->drawn);
	stilb_json_int(&json, "emitting_triangles", (int64_t)c->emitting);
	stilb_json_int(&json, "materials", scene->material_count);
	info_json_textures(&json, scene);
	info_json_variants(&json, scene->variants);
	info_json_animation(&json, scene->animation);
	stilb_json_begin(&json, "lights", '{');
	for (int i = 0; i < STILB_SCENE_LIGHT_KINDS; i++)
		stilb_json_int(&json, stilb_scene_light_kind_names[i], c->lights[i]);
	stilb_json_bool(&json, "environment", scene->surroundings.panorama.pixels);
	stilb_json_bool(&json, "none", scene->unlit);
	stilb_json_end(&json, '}');
	info_json_cameras(&json, scene);
	stilb_json_double(&json, "exposure", (double)scene->camera.exposure);
	if (c->low[0] <= c->high[0]) {
		info_json_vector(&json, "low", c->low);
		info_json_vector(&json, "high", c->high);
	}
	stilb_json_begin(&json, "not_live", '[');
#define INFO_JSON(words, there)                                                                                        \
	if (there)                                                                                                         \
		stilb_json_string(&json, NULL, words);
	INFO_NOT_LIVE(INFO_JSON)
#undef INFO_JSON
	stilb_json_end(&json, ']');
	stilb_json_end(&json, '}');
	return stilb_json_save(&json, path);
}

int info_scene(const char *name, bool allow_outside, bool quiet, const char *json)
{
	stilb_scene *scene;
	uint64_t start = stilb_time_ns();
	uint64_t import_bytes = 0;
	stilb_scene_open_options options = {
		.allow_outside = allow_outside, .quiet = quiet, .dark = true, .import_bytes = &import_bytes};
	stilb_result result = stilb_scene_open_with(name, &options, &scene);
	if (result != STILB_OK) {
		stilb_log("%s", stilb_error_message());
		return exit_code_of(result);
	}
	bool metered = false;
	picture_flags flags = picture_flags_default();
	if (picture_flags_expose(&flags, scene, &metered) != STILB_OK)
		stilb_log("%s", stilb_error_message());
	info_contents contents = info_count(scene, (double)(stilb_time_ns() - start) * 1e-9);
	contents.import_bytes = import_bytes;
	contents.metered = metered;
	info_print_scene(json && stilb_file_is_stdout(json) ? stderr : stdout, name, &contents);
	if (json && (result = info_scene_save(json, name, &contents)) != STILB_OK)
		stilb_log("%s", stilb_error_message());
	stilb_scene_destroy(scene);
	return result == STILB_OK ? EXIT_DONE : EXIT_FAILED;
}
