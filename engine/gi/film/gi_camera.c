#include "gi/film/gi_camera.h"
#include "gi/trace/gi_ray.h"

#include "shading/shade_sampling.h"

gi_camera gi_camera_make(const stilb_scene_camera *camera, const stilb_gi_lens *lens, uint32_t width, uint32_t height)
{
	STILB_ASSERT(width > 0 && height > 0);
	STILB_ASSERT(camera->fov_y > 0.0f && camera->fov_y < 3.1415927f);
	STILB_ASSERT(camera->near_z > 0.0f && camera->near_z < camera->far_z);
	STILB_ASSERT(lens->radius == 0.0f || (lens->radius > 0.0f && lens->focus > 0.0f));
	STILB_ASSERT(lens->blades == 0 || (lens->blades >= 3 && lens->blades <= 16));
	/* The camera's axes are taken from the rows of the rasteriser's matrix from world to clip space, which are the
	 * axes, scaled: so both renderers show the same picture. */
	stilb_mat4 clip = stilb_scene_camera_matrix(camera, 1.0f);
	float half_height = tanf(0.5f * camera->fov_y), half_width = half_height * ((float)width / (float)height);
	const float *m = clip.m;
	return (gi_camera){
		.position = stilb_vec3_make(camera->position[0], camera->position[1], camera->position[2]),
		.right = stilb_vec3_normalize(stilb_vec3_make(m[0], m[4], m[8])),
		.up = stilb_vec3_normalize(-stilb_vec3_make(m[1], m[5], m[9])),
		.forward = stilb_vec3_normalize(stilb_vec3_make(m[3], m[7], m[11])),
		.half_width = half_width,
		.half_height = half_height,
		.to_u = 2.0f * half_width / (float)width,
		.to_v = 2.0f * half_height / (float)height,
		.near_z = camera->near_z,
		.far_z = camera->far_z,
		.lens = *lens,
	};
}

/* A point of the aperture where it is a regular polygon, uniform over it: u[0] chooses one of the triangles between the
 * centre and a side, and what is left of it, with u[1], a point in that. */
static stilb_vec2 camera_polygon(const stilb_gi_lens *lens, stilb_vec2 u)
{
	STILB_ASSERT(lens->blades >= 3);
	float place = u[0] * (float)lens->blades, sector = floorf(place);
	float step = 2.0f * SHADE_PI / (float)lens->blades;
	float from = lens->rotation + sector * step, to = from + step;
	float radius = sqrtf(place - sector), along = u[1];
	float a = radius * (1.0f - along), b = radius * along;
	return (stilb_vec2){a * cosf(from) + b * cosf(to), a * sinf(from) + b * sinf(to)};
}

stilb_vec2 gi_camera_aperture(const gi_camera *camera, stilb_vec2 u)
{
	STILB_ASSERT(u[0] >= 0.0f && u[0] < 1.0f && u[1] >= 0.0f && u[1] < 1.0f);
	stilb_vec2 place = camera->lens.blades ? camera_polygon(&camera->lens, u) : shade_sample_disk(u);
	return place * camera->lens.radius;
}

void gi_camera_ray(const gi_camera *camera, float x, float y, stilb_vec2 lens, gi_ray_hit *ray)
{
	/* Operations in the order of lanes_pinhole (gi_primary_lanes.h), so that both give the same bits. */
	float across = x * camera->to_u - camera->half_width, up = camera->half_height - y * camera->to_v;
	stilb_vec3 direction = camera->forward + camera->right * across + camera->up * up;
	stilb_vec3 origin = camera->position;
	if (camera->lens.radius > 0.0f) {
		stilb_vec2 place = gi_camera_aperture(camera, lens);
		stilb_vec3 offset = camera->right * place[0] + camera->up * place[1];
		origin += offset;
		direction = direction * camera->lens.focus - offset;
	}
	direction = stilb_vec3_normalize(direction);
	*ray = gi_ray_hit_make(origin, direction);
	float cosine =
		direction[0] * camera->forward[0] + direction[1] * camera->forward[1] + direction[2] * camera->forward[2];
	ray->ray.t_min = camera->near_z / cosine;
	ray->ray.t_max = camera->far_z / cosine;
}
