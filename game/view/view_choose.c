/* What the user of `stilb view` chooses by a key or a click: one of the file's cameras, a part of the model. */
#include "view.h"

#include <inttypes.h>
#include <stdio.h>

static void choose_tell(const view *v, const char *text)
{
	fprintf(live_message_stream(&v->options), "%s\n", text);
	fflush(live_message_stream(&v->options));
	live_run_tell(v->run, text);
}

void view_choose_camera(view *v, uint32_t index)
{
	stilb_scene *scene = v->scene;
	char text[128];
	if (index >= scene->camera_count) {
		snprintf(text, sizeof text, "the file has %s%.0u camera%s", scene->camera_count > 0 ? "" : "no",
		         scene->camera_count, scene->camera_count == 1 ? "" : "s");
		choose_tell(v, text);
		return;
	}
	scene->camera = scene->cameras[index].camera;
	v->distance = stilb_scene_camera_distance(scene, &scene->camera);
	v->framed = false;
	snprintf(text, sizeof text, "camera %u of %u: %s", index + 1, scene->camera_count, scene->cameras[index].name);
	choose_tell(v, text);
}

/* The name of a thing of the file, or its number. */
static const char *choose_name(char (*names)[STILB_SCENE_NAME], uint32_t count, uint32_t index, char number[static 32])
{
	snprintf(number, 32, "%u", index);
	return index < count && names[index][0] ? names[index] : number;
}

void view_choose_part(const view *v, float x, float y)
{
	stilb_engine_hit hit;
	char text[256], model[32], material[32];
	const stilb_scene_names *names = &v->scene->names;
	if (!stilb_engine_pick(v->run->engine, (double)x, (double)y, &hit))
		return;
	uint32_t of = v->scene->part_material[hit.part];
	const stilb_scene_material *m = &v->scene->materials[of];
	snprintf(text, sizeof text, "model %s, %.3g m away; material %s: colour %.2f %.2f %.2f, roughness %.2f",
	         choose_name(names->models, names->model_count, hit.model, model), hit.distance,
	         choose_name(names->materials, names->material_count, of, material),
	         (double)(m->diffuse[0] + m->specular[0]), (double)(m->diffuse[1] + m->specular[1]),
	         (double)(m->diffuse[2] + m->specular[2]), (double)m->roughness);
	choose_tell(v, text);
}
