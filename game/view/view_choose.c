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

void view_choose_part(const view *v, float x, float y)
{
	stilb_engine_hit hit;
	char text[192];
	if (!stilb_engine_pick(v->run->engine, (double)x, (double)y, &hit))
		return;
	const stilb_scene_material *material = &v->scene->materials[v->scene->part_material[hit.part]];
	snprintf(text, sizeof text, "model %u, part %u, %.3g m away; material %u: colour %.2f %.2f %.2f, roughness %.2f",
	         hit.model, hit.part, hit.distance, v->scene->part_material[hit.part],
	         (double)(material->diffuse[0] + material->specular[0]),
	         (double)(material->diffuse[1] + material->specular[1]),
	         (double)(material->diffuse[2] + material->specular[2]), (double)material->roughness);
	choose_tell(v, text);
}
