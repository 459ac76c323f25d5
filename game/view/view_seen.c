#include "view_seen.h"

#include <string.h>

view_seen view_seen_read(stilb_scene *scene, const stilb_render_shading *shading, stilb_render_show show,
                         uint32_t width, uint32_t height)
{
	view_seen seen = {.camera = scene->camera, .shading = *shading, .width = width, .height = height, .show = show};
	seen.scene = stilb_scene_revisions_read(scene);
	seen.scene.camera = 0;
	return seen;
}

bool view_seen_same_scene(const view_seen *a, const view_seen *b)
{
	return memcmp(&a->scene, &b->scene, sizeof a->scene) == 0;
}

bool view_seen_same_rays(const view_seen *a, const view_seen *b)
{
	const stilb_scene_camera *c = &a->camera, *d = &b->camera;
	const stilb_render_shading *s = &a->shading, *t = &b->shading;
	return a->width == b->width && a->height == b->height && a->show == b->show && view_seen_same_scene(a, b) &&
	       memcmp(c->position, d->position, sizeof c->position) == 0 && c->near_z == d->near_z &&
	       c->far_z == d->far_z && c->yaw == d->yaw && c->pitch == d->pitch && c->roll == d->roll &&
	       c->fov_y == d->fov_y && s->brdf == t->brdf && s->ndf == t->ndf && s->g == t->g && s->f == t->f;
}

bool view_seen_same_frame(const view_seen *a, const view_seen *b)
{
	return memcmp(&a->camera, &b->camera, sizeof a->camera) == 0 &&
	       memcmp(&a->shading, &b->shading, sizeof a->shading) == 0 && view_seen_same_rays(a, b);
}
