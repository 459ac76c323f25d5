/* Pixels to rays: the same picture as the renderer of frames projects, and the thin lens by its closed form. */

#include "gi_world_fixture.h"

#include "gi/film/gi_camera.h"

#define WIDTH 640u
#define HEIGHT 360u

static const stilb_gi_lens pinhole = {.focus = 1.0f};

static stilb_scene_camera some_camera(float roll)
{
	return (stilb_scene_camera){.position = {1.0f, -2.0f, 3.0f},
	                            .yaw = 0.7f,
	                            .pitch = -0.4f,
	                            .roll = roll,
	                            .fov_y = 0.9f,
	                            .near_z = 0.1f,
	                            .far_z = 100.0f};
}

static stilb_vec3 point_of(const gi_ray_hit *ray, float t)
{
	return stilb_vec3_make(ray->ray.origin[0] + t * ray->ray.direction[0],
	                       ray->ray.origin[1] + t * ray->ray.direction[1],
	                       ray->ray.origin[2] + t * ray->ray.direction[2]);
}

/* A point on each ray, projected by the rasteriser's camera matrix, comes back to the ray's pixel. */
static void rays_undo_the_projection(void **state)
{
	(void)state;
	for (float roll = -0.5f; roll < 1.0f; roll += 0.5f) {
		stilb_scene_camera from = some_camera(roll);
		gi_camera camera = gi_camera_make(&from, &pinhole, WIDTH, HEIGHT);
		stilb_mat4 clip = stilb_scene_camera_matrix(&from, (float)WIDTH / (float)HEIGHT);
		for (float y = 0.0f; y <= (float)HEIGHT; y += 45.0f)
			for (float x = 0.0f; x <= (float)WIDTH; x += 40.0f) {
				gi_ray_hit ray;
				gi_camera_ray(&camera, x, y, (stilb_vec2){0.3f, 0.9f}, &ray);
				assert_false(gi_is_hit(&ray));
				const float ends[2] = {ray.ray.t_min, ray.ray.t_max}, planes[2] = {1.0f, 0.0f};
				for (int e = 0; e < 2; e++) { /* depth in clip space: 1 near, 0 far */
					stilb_vec3 at = point_of(&ray, ends[e]);
					const float *m = clip.m;
					float z = m[2] * at[0] + m[6] * at[1] + m[10] * at[2] + m[14];
					float w = m[3] * at[0] + m[7] * at[1] + m[11] * at[2] + m[15];
					SHADE_PROOF_NEAR(z / w, planes[e], 0.0, 2e-5);
				}
				stilb_vec3 p = point_of(&ray, 5.0f);
				float q[4];
				for (int row = 0; row < 4; row++)
					q[row] = clip.m[row] * p[0] + clip.m[4 + row] * p[1] + clip.m[8 + row] * p[2] + clip.m[12 + row];
				SHADE_PROOF_NEAR((q[0] / q[3] * 0.5f + 0.5f) * (float)WIDTH, x, 0.0, 2e-3);
				SHADE_PROOF_NEAR((q[1] / q[3] * 0.5f + 0.5f) * (float)HEIGHT, y, 0.0, 2e-3);
				double length =
					(double)(ray.ray.direction[0] * ray.ray.direction[0] + ray.ray.direction[1] * ray.ray.direction[1] +
				             ray.ray.direction[2] * ray.ray.direction[2]);
				SHADE_PROOF_NEAR(length, 1.0, 0.0, 4e-7);
			}
	}
}

/* The depth of a point: its distance from the camera along the direction of view, in metres. */
static float depth_of(const gi_camera *camera, stilb_vec3 p)
{
	return stilb_vec3_dot(p - camera->position, camera->forward);
}

/* Rays of one pixel meet in one point of the focal plane, wherever on the lens they start. */
static void the_focal_plane_is_sharp(void **state)
{
	(void)state;
	shade_proof_random random = {.seed = 2};
	for (uint32_t blades = 0; blades < 9; blades += 4) {
		stilb_scene_camera from = some_camera(0.2f);
		stilb_gi_lens lens = {.radius = 0.3f, .focus = 7.0f, .blades = blades, .rotation = 0.3f};
		gi_camera sharp = gi_camera_make(&from, &pinhole, WIDTH, HEIGHT);
		gi_camera camera = gi_camera_make(&from, &lens, WIDTH, HEIGHT);
		for (int i = 0; i < 1000; i++) {
			float x = shade_proof_range(&random, 0.0f, (float)WIDTH),
				  y = shade_proof_range(&random, 0.0f, (float)HEIGHT);
			stilb_vec2 u = {shade_proof_uniform(&random), shade_proof_uniform(&random)};
			gi_ray_hit ray, straight;
			gi_camera_ray(&camera, x, y, u, &ray);
			gi_camera_ray(&sharp, x, y, u, &straight);
			stilb_vec3 forward = camera.forward;
			float along = ray.ray.direction[0] * forward[0] + ray.ray.direction[1] * forward[1] +
			              ray.ray.direction[2] * forward[2];
			float direct = straight.ray.direction[0] * forward[0] + straight.ray.direction[1] * forward[1] +
			               straight.ray.direction[2] * forward[2];
			stilb_vec3 a = point_of(&ray, 7.0f / along), b = point_of(&straight, 7.0f / direct);
			SHADE_PROOF_NEAR(depth_of(&camera, a), 7.0, 0.0, 2e-5);
			SHADE_PROOF_NEAR3(a, b[0], b[1], b[2], 0.0, 2e-5);
			SHADE_PROOF_NEAR(depth_of(&camera, point_of(&ray, 0.0f)), 0.0, 0.0, 1e-6); /* starts on the lens */
		}
	}
}

/* At depth z the rays of one pixel fill a disk of radius r |z - f| / f: to its rim, evenly, and not beyond. */
static void the_circle_of_confusion(void **state)
{
	(void)state;
	enum { COUNT = 20000 };
	shade_proof_random random = {.seed = 4};
	float radius = 0.25f, focus = 4.0f;
	stilb_scene_camera from = some_camera(0.0f);
	gi_camera camera = gi_camera_make(&from, &(stilb_gi_lens){.radius = radius, .focus = focus}, WIDTH, HEIGHT);
	for (float z = 1.0f; z < 20.0f; z += 2.5f) {
		double largest = 0.0, squares = 0.0, confusion = (double)(radius * fabsf(z - focus) / focus);
		stilb_vec3 middle =
			camera.position + (camera.forward + camera.right * (100.0f * camera.to_u - camera.half_width) +
		                       camera.up * (camera.half_height - 50.0f * camera.to_v)) *
								  z;
		for (int i = 0; i < COUNT; i++) {
			gi_ray_hit ray;
			gi_camera_ray(&camera, 100.0f, 50.0f,
			              (stilb_vec2){shade_proof_uniform(&random), shade_proof_uniform(&random)}, &ray);
			float along = ray.ray.direction[0] * camera.forward[0] + ray.ray.direction[1] * camera.forward[1] +
			              ray.ray.direction[2] * camera.forward[2];
			stilb_vec3 off = point_of(&ray, z / along) - middle;
			double square = (double)stilb_vec3_dot(off, off);
			largest = fmax(largest, sqrt(square));
			squares += square;
		}
		SHADE_PROOF_NEAR(largest, confusion, 2e-3, 1e-5);
		assert_true(largest <= confusion * 1.0001 + 1e-5);
		SHADE_PROOF_NEAR(squares / COUNT, 0.5 * confusion * confusion, 0.02, 1e-9); /* the mean square of a disk */
	}
}

/* Inside the polygon, and as many in each of its sectors and in the halves of its area. */
static void polygons(void **state)
{
	(void)state;
	enum { COUNT = 60000 };
	shade_proof_random random = {.seed = 6};
	stilb_scene_camera from = some_camera(0.0f);
	for (uint32_t blades = 3; blades <= 16; blades += blades < 6 ? 1 : 5) {
		stilb_gi_lens lens = {.radius = 2.0f, .focus = 1.0f, .blades = blades, .rotation = 0.4f};
		gi_camera camera = gi_camera_make(&from, &lens, WIDTH, HEIGHT);
		double pi = 3.14159265358979, step = 2.0 * pi / blades, inner = 2.0 * cos(0.5 * step);
		uint32_t sectors[16] = {0}, small = 0;
		double farthest = 0.0;
		for (int i = 0; i < COUNT; i++) {
			stilb_vec2 p =
				gi_camera_aperture(&camera, (stilb_vec2){shade_proof_uniform(&random), shade_proof_uniform(&random)});
			double angle = atan2((double)p[1], (double)p[0]) - 0.4, radius = hypot((double)p[0], (double)p[1]);
			angle -= 2.0 * pi * floor(angle / (2.0 * pi));
			uint32_t sector = (uint32_t)(angle / step);
			double height = radius * cos(angle - (sector + 0.5) * step);
			assert_true(height <= inner * (1.0 + 1e-6));
			sectors[sector % blades]++;
			small += height <= inner * sqrt(0.5);
			farthest = fmax(farthest, radius);
		}
		assert_true(farthest > 1.9 && farthest <= 2.0 * (1.0 + 1e-6));
		double share = COUNT / (double)blades;
		for (uint32_t k = 0; k < blades; k++)
			SHADE_PROOF_NEAR(sectors[k], share, 0.0, 5.0 * sqrt(share));
		SHADE_PROOF_NEAR(small, 0.5 * COUNT, 0.0, 5.0 * sqrt(0.25 * COUNT));
	}
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(rays_undo_the_projection),
		cmocka_unit_test(the_focal_plane_is_sharp),
		cmocka_unit_test(the_circle_of_confusion),
		cmocka_unit_test(polygons),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
