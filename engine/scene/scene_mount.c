/* Where lights and cameras stand that hang on nodes. */
#include "scene/edit/scene_check.h"
#include "scene/scene_internal.h"

#include <math.h>
#include <string.h>

static void mount_put(stilb_vec3 v, float out[3])
{
	for (int i = 0; i < 3; i++)
		out[i] = v[i];
}

/* Applies the upper left 3 x 3 of m. */
static stilb_vec3 mount_turn(const stilb_mat4 *m, const float v[3])
{
	stilb_vec3 turned = {0};
	for (int row = 0; row < 3; row++)
		turned[row] = m->m[row] * v[0] + m->m[4 + row] * v[1] + m->m[8 + row] * v[2];
	return turned;
}

static stilb_vec3 mount_point(const stilb_mat4 *m, const float p[3])
{
	return mount_turn(m, p) + stilb_vec3_make(m->m[12], m->m[13], m->m[14]);
}

/* Along v, unit length; -Z if it has no length. */
static stilb_vec3 mount_unit(stilb_vec3 v)
{
	float length = sqrtf(stilb_vec3_dot(v, v));
	return length > 1e-18f && length < 1e18f ? v * (1.0f / length) : stilb_vec3_make(0, 0, -1);
}

/* ---- lights ------------------------------------------------------------------------------------------------------ */

static bool mount_is_round(const stilb_scene_light *light)
{
	return light->kind == STILB_SCENE_LIGHT_SPHERE || light->kind == STILB_SCENE_LIGHT_DISK;
}

static bool mount_has_position(const stilb_scene_light *light)
{
	return light->kind != STILB_SCENE_LIGHT_DIRECTIONAL;
}

static bool mount_has_direction(const stilb_scene_light *light)
{
	return light->kind != STILB_SCENE_LIGHT_POINT && light->kind != STILB_SCENE_LIGHT_SPHERE;
}

stilb_scene_mount scene_mount_of_light(const stilb_scene_light *light, uint32_t node)
{
	STILB_ASSERT(light);
	stilb_scene_mount mount = {.node = node};
	if (mount_has_position(light))
		memcpy(mount.position, light->position, sizeof mount.position);
	if (mount_has_direction(light))
		memcpy(mount.direction, light->direction, sizeof mount.direction);
	if (light->kind == STILB_SCENE_LIGHT_RECTANGLE) {
		memcpy(mount.half_x, light->half_x, sizeof mount.half_x);
		memcpy(mount.half_y, light->half_y, sizeof mount.half_y);
	}
	if (mount_is_round(light))
		mount.radius = light->radius;
	return mount;
}

/* The cube root of what volumes become. */
static float mount_scale(const stilb_mat4 *m)
{
	const float *a = m->m;
	float volume =
		a[0] * (a[5] * a[10] - a[6] * a[9]) - a[4] * (a[1] * a[10] - a[2] * a[9]) + a[8] * (a[1] * a[6] - a[2] * a[5]);
	return cbrtf(fabsf(volume));
}

/* The plane of the sides is that of the node's; where the node shears, the second side is cut to what is across the
 * first. */
static void mount_rectangle(const stilb_scene_mount *mount, const stilb_mat4 *to_world, stilb_scene_light *light)
{
	stilb_vec3 x = mount_turn(to_world, mount->half_x), y = mount_turn(to_world, mount->half_y);
	stilb_vec3 along = mount_unit(x);
	y -= along * stilb_vec3_dot(along, y);
	stilb_vec3 normal = mount_unit(stilb_vec3_cross(along, mount_unit(y)));
	if (stilb_vec3_dot(normal, mount_turn(to_world, mount->direction)) < 0.0f)
		normal = -normal;
	mount_put(x, light->half_x);
	mount_put(y, light->half_y);
	mount_put(normal, light->direction);
}

bool scene_mount_light(const stilb_scene_mount *mount, const stilb_mat4 *to_world, stilb_scene_light *light)
{
	STILB_ASSERT(mount && to_world && light);
	stilb_scene_light placed = *light;
	if (mount_has_position(light))
		mount_put(mount_point(to_world, mount->position), placed.position);
	if (mount_has_direction(light))
		mount_put(mount_unit(mount_turn(to_world, mount->direction)), placed.direction);
	if (light->kind == STILB_SCENE_LIGHT_RECTANGLE)
		mount_rectangle(mount, to_world, &placed);
	if (mount_is_round(light))
		placed.radius = mount->radius * mount_scale(to_world);
	if (stilb_scene_light_mistake(&placed))
		return false;
	*light = placed;
	return true;
}

/* ---- cameras ----------------------------------------------------------------------------------------------------- */

/* The axes of an upright camera are the rows of its view matrix. */
static stilb_vec3 mount_view_row(const stilb_mat4 *view, int row)
{
	return stilb_vec3_make(view->m[row], view->m[4 + row], view->m[8 + row]);
}

stilb_scene_mount scene_mount_of_camera(const stilb_scene_camera *camera, uint32_t node)
{
	STILB_ASSERT(camera);
	stilb_mat4 view = stilb_mat4_view((stilb_vec3){0}, camera->yaw, camera->pitch);
	stilb_scene_mount mount = {.node = node};
	memcpy(mount.position, camera->position, sizeof mount.position);
	mount_put(-mount_view_row(&view, 2), mount.direction);
	mount_put(mount_view_row(&view, 1) * cosf(camera->roll) + mount_view_row(&view, 0) * sinf(camera->roll), mount.up);
	return mount;
}

/* The roll of an upright camera that brings its up axis to `up`. */
static float mount_roll(const stilb_scene_camera *camera, stilb_vec3 up)
{
	stilb_mat4 view = stilb_mat4_view((stilb_vec3){0}, camera->yaw, camera->pitch);
	float sine = stilb_vec3_dot(up, mount_view_row(&view, 0)), cosine = stilb_vec3_dot(up, mount_view_row(&view, 1));
	return fabsf(sine) > 1e-5f || cosine < 0.0f ? atan2f(sine, cosine) : 0.0f;
}

bool scene_mount_camera(const stilb_scene_mount *mount, const stilb_mat4 *to_world, stilb_scene_camera *camera)
{
	STILB_ASSERT(mount && to_world && camera);
	stilb_vec3 position = mount_point(to_world, mount->position);
	stilb_scene_camera placed = scene_camera_along(position, mount_unit(mount_turn(to_world, mount->direction)), 1.0f);
	if (!scene_is_within(placed.position, 3, -SCENE_FAR, SCENE_FAR))
		return false;
	memcpy(camera->position, placed.position, sizeof camera->position);
	camera->yaw = placed.yaw;
	camera->pitch = placed.pitch;
	camera->roll = mount_roll(camera, mount_unit(mount_turn(to_world, mount->up)));
	return true;
}
