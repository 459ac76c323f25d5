/* Cameras that show all of a scene. */
#include "scene/play/scene_play_internal.h"
#include "scene/scene_internal.h"

#include <float.h>
#include <math.h>

#define FRAME_FOV 0.7f            /* radians, of the picture's height */
#define FRAME_STEPS 4             /* of centring; the third changes a pixel at most */
#define FRAME_FILLED 0.9f         /* share of the picture that the scene fills in its tighter direction */
#define FRAME_FAR 1e18f           /* metres: vertices beyond it are left out, as in bounds */
#define FRAME_ROUNDING 1e-6f      /* relative error of coordinates, for a scene far from the origin */
#define FRAME_LEAST_METRES 1e-15f /* smallest size of a scene that is framed: squares of less underflow */

/* What is known of the scene's vertices in the axes of a camera at the origin: x to the right, y up, z ahead. A camera
 * at c sees all of them if |x - c.x| <= s (z - c.z) for the slope s of the picture's sides, and likewise y: if
 *
 *     c.x - s c.z >= right = max(x - s z)   and   -c.x - s c.z >= left = max(-x - s z)
 *
 * The largest c.z that satisfies both is -(right + left) / 2s, at c.x = (right - left) / 2. */
typedef struct frame_extent {
	float slope_x, slope_y;
	float right, left, up, down;
	float nearest, farthest; /* smallest and largest z; nearest > farthest: there are no vertices */
} frame_extent;

static void frame_add(frame_extent *extent, stilb_vec3 p)
{
	extent->right = fmaxf(extent->right, p[0] - extent->slope_x * p[2]);
	extent->left = fmaxf(extent->left, -p[0] - extent->slope_x * p[2]);
	extent->up = fmaxf(extent->up, p[1] - extent->slope_y * p[2]);
	extent->down = fmaxf(extent->down, -p[1] - extent->slope_y * p[2]);
	extent->nearest = fminf(extent->nearest, p[2]);
	extent->farthest = fmaxf(extent->farthest, p[2]);
}

/* The outermost vertices as seen from the camera's place, in the same axes: x / z and y / z, and their z. */
typedef struct frame_outline {
	float at[3];                         /* the camera's place */
	float right, left, up, down;         /* the largest x / z, -x / z, y / z, -y / z */
	float z_right, z_left, z_up, z_down; /* distances ahead of the camera, > 0 */
} frame_outline;

static void frame_outline_add(float ratio, float z, float *largest, float *largest_z)
{
	if (ratio <= *largest)
		return;
	*largest = ratio;
	*largest_z = z;
}

static void frame_look(frame_outline *o, stilb_vec3 p)
{
	float x = p[0] - o->at[0], y = p[1] - o->at[1], z = p[2] - o->at[2];
	frame_outline_add(x / z, z, &o->right, &o->z_right);
	frame_outline_add(-x / z, z, &o->left, &o->z_left);
	frame_outline_add(y / z, z, &o->up, &o->z_up);
	frame_outline_add(-y / z, z, &o->down, &o->z_down);
}

/* Adds the vertices that the part's triangles use to one of both, the other is NULL. to_view: world to the camera's
 * axes, z backwards. */
static void frame_add_part(frame_extent *extent, frame_outline *outline, const stilb_scene *scene, uint32_t part,
                           const stilb_mat4 *to_view)
{
	const stilb_scene_mesh *mesh = &scene->meshes[scene->part_mesh[part]];
	stilb_mat4 full = stilb_mat4_multiply(*to_view, scene->part_transform[part]);
	const float *m = full.m;
	for (uint32_t i = 0; i < mesh->index_count; i++) {
		const float *p = mesh->vertices[mesh->indices[i]].position;
		stilb_vec3 at = {0};
		for (int k = 0; k < 3; k++)
			at[k] = m[k] * p[0] + m[4 + k] * p[1] + m[8 + k] * p[2] + m[12 + k];
		if (!(fabsf(at[0]) < FRAME_FAR && fabsf(at[1]) < FRAME_FAR && fabsf(at[2]) < FRAME_FAR))
			continue;
		at[2] = -at[2];
		if (extent)
			frame_add(extent, at);
		else
			frame_look(outline, at);
	}
}

static bool frame_sees(const stilb_scene *scene, uint32_t model)
{
	return !isnan(scene->bounds.radius[model]) && (scene->model_flags[model] & STILB_SCENE_MODEL_UNSEEN) == 0;
}

/* Adds the corners of the cubes around the models' bounds, with sides along the camera's axes. */
static void frame_add_bounds(frame_extent *extent, frame_outline *outline, const stilb_scene *scene,
                             const stilb_mat4 *to_view)
{
	const stilb_scene_bounds *b = &scene->bounds;
	const float *m = to_view->m;
	for (uint32_t i = 0; i < scene->model_count; i++)
		for (int corner = 0; corner < 8 && frame_sees(scene, i); corner++) {
			stilb_vec3 at = {0};
			for (int k = 0; k < 3; k++)
				at[k] = m[k] * b->x[i] + m[4 + k] * b->y[i] + m[8 + k] * b->z[i] +
				        (corner >> k & 1 ? b->radius[i] : -b->radius[i]);
			at[2] = -at[2];
			if (extent)
				frame_add(extent, at);
			else
				frame_look(outline, at);
		}
}

/* Adds the corners of the boxes of the poses that a clip has (stilb_scene_sweep). */
static void frame_add_swept(frame_extent *extent, frame_outline *outline, const stilb_scene *scene,
                            const stilb_mat4 *to_view)
{
	const float *m = to_view->m;
	for (uint32_t i = 0; scene->figures && i < 8 * scene->figures->swept_count; i++) {
		const play_box *box = &scene->figures->swept[i / 8];
		float x = i & 1 ? box->high[0] : box->low[0], y = i & 2 ? box->high[1] : box->low[1];
		float z = i & 4 ? box->high[2] : box->low[2];
		stilb_vec3 at = {0};
		for (int k = 0; k < 3; k++)
			at[k] = m[k] * x + m[4 + k] * y + m[8 + k] * z + m[12 + k];
		at[2] = -at[2];
		if (extent)
			frame_add(extent, at);
		else
			frame_look(outline, at);
	}
}

/* If scene_is_placed_often, the models' bounds stand for their vertices. */
static void frame_add_scene(frame_extent *extent, frame_outline *outline, const stilb_scene *scene,
                            const stilb_mat4 *to_view)
{
	frame_add_swept(extent, outline, scene, to_view);
	if (scene_is_placed_often(scene)) {
		frame_add_bounds(extent, outline, scene, to_view);
		return;
	}
	for (uint32_t m = 0; m < scene->model_count; m++)
		for (uint32_t p = scene->first_part[m]; p < scene->first_part[m + 1] && frame_sees(scene, m); p++)
			frame_add_part(extent, outline, scene, p, to_view);
}

/* Moves the camera sideways and up until the scene leaves the same space on both sides of the picture: by Newton's
 * method, as moving by d changes x / z of a vertex by -d / z. */
static void frame_center(const stilb_scene *scene, const stilb_mat4 *view, float at[3])
{
	for (int step = 0; step < FRAME_STEPS; step++) {
		frame_outline o = {
			.at = {at[0], at[1], at[2]}, .right = -FLT_MAX, .left = -FLT_MAX, .up = -FLT_MAX, .down = -FLT_MAX};
		frame_add_scene(NULL, &o, scene, view);
		at[0] += (o.right - o.left) / (1.0f / o.z_right + 1.0f / o.z_left);
		at[1] += (o.up - o.down) / (1.0f / o.z_up + 1.0f / o.z_down);
	}
}

stilb_scene_camera stilb_scene_frame(const stilb_scene *scene, float yaw, float pitch, float aspect)
{
	STILB_ASSERT(scene && isfinite(yaw) && isfinite(pitch));
	STILB_ASSERT(aspect > 0.0f && isfinite(aspect));
	stilb_mat4 view = stilb_mat4_view((stilb_vec3){0}, yaw, pitch);
	float slope = FRAME_FILLED * tanf(0.5f * FRAME_FOV);
	frame_extent e = {slope * aspect, slope, -FLT_MAX, -FLT_MAX, -FLT_MAX, -FLT_MAX, FLT_MAX, -FLT_MAX};
	frame_add_scene(&e, NULL, scene, &view);
	bool empty = e.nearest > e.farthest;
	if (empty)
		e = (frame_extent){.slope_x = 1.0f, .slope_y = 1.0f};
	float at[3] = {0.5f * (e.right - e.left), 0.5f * (e.up - e.down),
	               fminf(-0.5f * (e.right + e.left) / e.slope_x, -0.5f * (e.up + e.down) / e.slope_y)};
	float middle = 0.5f * (e.nearest + e.farthest), depth = e.farthest - e.nearest;
	float far = fmaxf(fabsf(middle), fmaxf(fabsf(at[0]), fabsf(at[1])));
	at[2] = fminf(at[2], e.nearest - 0.05f * depth); /* a line along the view would touch the camera */
	if (!(middle - at[2] > FRAME_ROUNDING * far + FRAME_LEAST_METRES))
		at[2] = middle - fmaxf(1.0f, 1e3f * FRAME_ROUNDING * far); /* a point, or nothing */
	if (!empty && e.nearest > at[2])
		frame_center(scene, &view, at);
	/* From the camera's axes to the world: the rows of the view matrix are the axes. */
	const float *m = view.m;
	stilb_vec3 position = {0};
	stilb_vec3 ahead = stilb_vec3_make(-m[2], -m[6], -m[10]);
	for (int i = 0; i < 3; i++, m += 4)
		position[i] = at[0] * m[0] + at[1] * m[1] - at[2] * m[2];
	stilb_scene_camera camera = scene_camera_along(position, ahead * (middle - at[2]), FRAME_FOV);
	camera.yaw = yaw; /* exactly, also straight up and down */
	camera.pitch = pitch;
	camera.exposure = scene->camera.exposure;
	camera.tone = scene->camera.tone;
	return camera;
}

stilb_sphere stilb_scene_sphere(const stilb_scene *scene)
{
	STILB_ASSERT(scene);
	return scene_sphere(scene);
}

float stilb_scene_camera_distance(const stilb_scene *scene, const stilb_scene_camera *camera)
{
	STILB_ASSERT(scene && camera);
	stilb_sphere sphere = scene_sphere(scene);
	stilb_mat4 view = stilb_mat4_view((stilb_vec3){0}, camera->yaw, camera->pitch);
	float ahead = view.m[2] * (camera->position[0] - sphere.x) + view.m[6] * (camera->position[1] - sphere.y) +
	              view.m[10] * (camera->position[2] - sphere.z);
	float size = sphere.radius > FRAME_LEAST_METRES ? sphere.radius : 1.0f;
	return ahead > 0.01f * size ? ahead : size;
}
