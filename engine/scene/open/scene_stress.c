/* The stress test: spheres over ground tiles, two materials for each model, cameras that see all or some of them. */
#include "scene/edit/scene_edit_internal.h"
#include "scene/scene_internal.h"

#include <float.h>
#include <string.h>

/* The random numbers of one model, each with an index of its own. Adding one changes STRESS_STREAMS and with it all
 * numbers that a seed gives. */
enum stress_stream {
	STRESS_RADIUS,
	STRESS_LIFT,
	STRESS_SPHERE_HUE,
	STRESS_SPHERE_SATURATION,
	STRESS_SPHERE_VALUE,
	STRESS_SPHERE_SPECULAR,
	STRESS_SPHERE_GLOSS,
	STRESS_TILE_HUE,
	STRESS_TILE_VALUE,
	STRESS_STREAMS
};

#define STRESS_SPHERE_SPLITS 2
#define STRESS_BOB_HEIGHT 0.6f /* metres that animated spheres rise */
#define STRESS_TOP 2.75f       /* metres; nothing is higher: 2 * radius + lift + bob is at most 2.7 */

static float stress_random(uint64_t seed, uint32_t model, enum stress_stream stream, float low, float high)
{
	STILB_ASSERT(low < high && stream < STRESS_STREAMS);
	return low + (high - low) * stilb_random_float(seed, (uint64_t)model * STRESS_STREAMS + stream);
}

void scene_stress_color(float hue, float saturation, float value, float rgb[3])
{
	STILB_ASSERT(hue >= 0.0f && hue <= 1.0f);
	for (int i = 0; i < 3; i++) {
		float h = fmodf(hue * 6.0f + (i == 0 ? 0.0f : i == 1 ? 4.0f : 2.0f), 6.0f);
		float ramp = fabsf(h - 3.0f) - 1.0f;
		ramp = ramp < 0.0f ? 0.0f : ramp > 1.0f ? 1.0f : ramp;
		rgb[i] = value * (1.0f - saturation + saturation * ramp);
	}
}

/* The roughness of a Blinn-Phong highlight: exponent n = 2 / alpha^2 - 2, alpha = roughness^2. n >= 0.
 * Source: Karis, "Specular BRDF Reference" (2013). */
static float stress_roughness(float exponent)
{
	STILB_ASSERT(exponent >= 0.0f);
	return sqrtf(sqrtf(2.0f / (exponent + 2.0f)));
}

static stilb_scene_material stress_sphere_material(uint64_t seed, uint32_t model)
{
	float diffuse[3], specular[3];
	scene_stress_color(stress_random(seed, model, STRESS_SPHERE_HUE, 0.0f, 1.0f),
	                   stress_random(seed, model, STRESS_SPHERE_SATURATION, 0.45f, 0.9f),
	                   stress_random(seed, model, STRESS_SPHERE_VALUE, 0.35f, 0.85f), diffuse);
	specular[0] = specular[1] = specular[2] = stress_random(seed, model, STRESS_SPHERE_SPECULAR, 0.03f, 0.25f);
	float exponent = exp2f(stress_random(seed, model, STRESS_SPHERE_GLOSS, 4.0f, 8.0f));
	return stilb_scene_material_make(diffuse, specular, stress_roughness(exponent));
}

static stilb_scene_material stress_tile_material(uint64_t seed, uint32_t model)
{
	float diffuse[3];
	const float specular[3] = {0.02f, 0.02f, 0.02f};
	scene_stress_color(stress_random(seed, model, STRESS_TILE_HUE, 0.0f, 1.0f), 0.18f,
	                   stress_random(seed, model, STRESS_TILE_VALUE, 0.18f, 0.5f), diffuse);
	return stilb_scene_material_make(diffuse, specular, stress_roughness(16.0f));
}

/* Sets the smallest bounding sphere with its centre on the vertical axis: it touches the tile's corners (sqrt 2 from
 * the axis, y = 0) and the top of the model's sphere, or the corners alone if the sphere is low. */
static void stress_set_bounds(stilb_scene *scene, uint32_t model, float x, float z, float top)
{
	float center = top > 1.41421356f ? (top * top - 2.0f) / (2.0f * top) : 0.0f;
	scene->bounds.x[model] = x;
	scene->bounds.y[model] = center;
	scene->bounds.z[model] = z;
	scene->bounds.radius[model] = sqrtf(2.0f + center * center) + 1e-3f; /* a margin for rounding */
}

/* Moves the sphere of a model to `bob` metres above its position at rest. */
static void stress_place_sphere(stilb_scene *scene, uint32_t model, float bob)
{
	STILB_ASSERT(bob >= 0.0f && bob <= STRESS_BOB_HEIGHT);
	float radius = stress_random(scene->seed, model, STRESS_RADIUS, 0.3f, 0.9f);
	float lift = stress_random(scene->seed, model, STRESS_LIFT, 0.0f, 0.3f);
	float x = scene->bounds.x[model], z = scene->bounds.z[model], height = radius + lift + bob;
	STILB_ASSERT(height + radius <= STRESS_TOP);
	scene->part_transform[(size_t)2 * model] = stilb_mat4_scale_translate(radius, x, height, z);
	stress_set_bounds(scene, model, x, z, height + radius);
}

static void stress_add_model(stilb_scene *scene, uint32_t model, uint32_t side)
{
	STILB_ASSERT(model < scene->model_count && model / side < side);
	/* Centres have integer coordinates, so corners, one metre away, have, too. */
	float x = (float)(2 * (int64_t)(model % side) - ((int64_t)side - 1));
	float z = (float)(2 * (int64_t)(model / side) - ((int64_t)side - 1));
	uint32_t sphere = 2 * model, tile = sphere + 1;
	scene->first_part[model] = sphere;
	scene->part_mesh[sphere] = 0;
	scene->part_mesh[tile] = 1;
	scene->part_material[sphere] = sphere;
	scene->part_material[tile] = tile;
	scene->materials[sphere] = stress_sphere_material(scene->seed, model);
	scene->materials[tile] = stress_tile_material(scene->seed, model);
	scene->part_transform[tile] = stilb_mat4_scale_translate(STILB_SCENE_TILE * 0.5f, x, 0.0f, z);
	scene->bounds.x[model] = x;
	scene->bounds.z[model] = z;
	stress_place_sphere(scene, model, 0.0f);
}

/* The smallest side with side * side >= model_count. */
static uint32_t stress_side(uint32_t model_count)
{
	uint32_t side = (uint32_t)sqrt((double)model_count);
	while ((uint64_t)side * side < model_count)
		side++;
	return side;
}

const char *const stilb_scene_stress_light_names[] = {
#define STRESS_LIGHT_NAME(id, name, words) #name,
	STILB_SCENE_STRESS_LIGHTS(STRESS_LIGHT_NAME)
#undef STRESS_LIGHT_NAME
		NULL};

/* A light above the middle of side x side tiles, so high that it lights the edges as well. Its irradiance on the ground
 * below it is 6 W m^-2, twice the sun's. */
static stilb_scene_light stress_lamp(stilb_scene_light_kind kind, stilb_scene_light_falloff falloff, float side)
{
	float half_side = 0.5f * side * STILB_SCENE_TILE, height = STRESS_TOP + 0.5f * half_side;
	float intensity = 6.0f * height * height;
	return (stilb_scene_light){
		.kind = kind,
		.position = {0.0f, height, 0.0f},
		.direction = {0.0f, -1.0f, 0.0f},
		.intensity = {intensity, 0.86f * intensity, 0.66f * intensity},
		.radius = 0.1f * height,
		.reach = height + half_side,
		.falloff = falloff,
	};
}

static const float stress_sky[3] = {0.30f, 0.42f, 0.62f}, stress_ground[3] = {0.10f, 0.09f, 0.08f}; /* by day */

void stilb_scene_stress_set_light(stilb_scene *scene, stilb_scene_stress_light light)
{
	STILB_ASSERT(scene && scene->lights && scene->stress_models > 0 && "a scene of stilb_scene_create_stress");
	STILB_ASSERT((unsigned)light < STILB_SCENE_STRESS_LIGHT_COUNT);
	float side = (float)stress_side(scene->stress_models);
	stilb_vec3 sun = stilb_vec3_normalize(stilb_vec3_make(-0.62f, 0.68f, 0.38f));
	stilb_scene_light lights[STILB_SCENE_STRESS_LIGHT_COUNT] = {
		[STILB_SCENE_STRESS_LIGHT_SUN] = {.kind = STILB_SCENE_LIGHT_DIRECTIONAL,
	                                      .direction = {-sun[0], -sun[1], -sun[2]},
	                                      .intensity = {3.0f, 2.8f, 2.5f}},
		[STILB_SCENE_STRESS_LIGHT_SPHERE] = stress_lamp(STILB_SCENE_LIGHT_SPHERE, STILB_SCENE_LIGHT_PHYSICAL, side),
		[STILB_SCENE_STRESS_LIGHT_DISK] = stress_lamp(STILB_SCENE_LIGHT_DISK, STILB_SCENE_LIGHT_PHYSICAL, side),
		[STILB_SCENE_STRESS_LIGHT_WINDOWED] = stress_lamp(STILB_SCENE_LIGHT_SPHERE, STILB_SCENE_LIGHT_WINDOWED, side),
		[STILB_SCENE_STRESS_LIGHT_SUBTRACTED] =
			stress_lamp(STILB_SCENE_LIGHT_SPHERE, STILB_SCENE_LIGHT_SUBTRACTED, side),
		[STILB_SCENE_STRESS_LIGHT_NIGHT] = {.kind = STILB_SCENE_LIGHT_DIRECTIONAL,
	                                        .direction = {-sun[0], -sun[1], -sun[2]},
	                                        .intensity = {0.06f, 0.08f, 0.12f}},
	};
	bool none = light == STILB_SCENE_STRESS_LIGHT_HEMISPHERE;
	lights[STILB_SCENE_STRESS_LIGHT_HEMISPHERE] = lights[STILB_SCENE_STRESS_LIGHT_SUN]; /* before lamps: dark */
	memset(lights[STILB_SCENE_STRESS_LIGHT_HEMISPHERE].intensity, 0, sizeof lights->intensity);
	float day = light == STILB_SCENE_STRESS_LIGHT_NIGHT ? 0.03f : 1.0f;
	for (int c = 0; c < 3; c++) {
		scene->surroundings.sky[c] = day * stress_sky[c];
		scene->surroundings.ground[c] = day * stress_ground[c];
	}
	scene->lights[0] = lights[light];
	uint32_t lamps = scene->stress_lamps + scene->stress_carried;
	scene->light_count = lamps > 0 ? 1 + lamps : !none;
	scene->surroundings.glossy = light == STILB_SCENE_STRESS_LIGHT_HEMISPHERE;
}

stilb_result stilb_scene_create_stress(uint32_t model_count, uint64_t seed, stilb_scene **out)
{
	STILB_ASSERT(model_count >= 1 && model_count <= STILB_SCENE_MAX_MODELS);
	STILB_ASSERT(out);
	*out = NULL;
	stilb_scene *scene;
	stilb_result result = scene_create(model_count, 2 * model_count, 2, 2 * model_count, &scene);
	if (result == STILB_OK)
		result = stilb_scene_mesh_sphere(STRESS_SPHERE_SPLITS, &scene->meshes[0]);
	if (result == STILB_OK)
		result = stilb_scene_mesh_plane(&scene->meshes[1]);
	if (result == STILB_OK)
		result = scene_add_lights(scene, 1);
	if (result != STILB_OK) {
		stilb_scene_destroy(scene);
		return result;
	}
	scene->seed = seed;
	scene->stress_models = model_count;
	uint32_t side = stress_side(model_count);
	for (uint32_t m = 0; m < model_count; m++)
		stress_add_model(scene, m, side);
	scene->first_part[model_count] = 2 * model_count;
	stilb_scene_stress_set_light(scene, STILB_SCENE_STRESS_LIGHT_SUN);
	scene->camera = stilb_scene_stress_camera(scene, STILB_SCENE_VIEW_ALL, 16.0f / 9.0f);
	STILB_CHECK(scene_is_sound(scene));
	*out = scene;
	return STILB_OK;
}

void stilb_scene_animate(stilb_scene *scene, double seconds)
{
	STILB_ASSERT(scene && scene->stress_models > 0 && "a scene of stilb_scene_create_stress");
	STILB_ASSERT(isfinite(seconds));
	scene->revisions.places++;
	if (!scene->edits)
		scene->moved_count = 0;
	for (uint32_t m = 0; m < scene->stress_models; m += 10) {
		double phase = seconds * 2.0 + 0.7 * (double)(m % 97);
		stress_place_sphere(scene, m, STRESS_BOB_HEIGHT * 0.5f * (1.0f - (float)cos(phase)));
		if (scene->edits)
			scene_edit_moved(scene, m);
		else
			scene->moved[scene->moved_count++] = m;
	}
}

/* ---- cameras ----------------------------------------------------------------------------------------------------- */

/* Pitch of each view's camera, radians, chosen so that the models in view fill the picture. */
static const float stress_pitch[] = {
	[STILB_SCENE_VIEW_ALL] = -0.72f,
	[STILB_SCENE_VIEW_HALF] = -0.6f,
	[STILB_SCENE_VIEW_FEW] = -0.85f,
};

/* Position of a camera relative to the centre of the grid, metres: `distance` backwards along its view and `up` along
 * the vertical axis of its picture. */
typedef struct stress_stand {
	float distance, up;
} stress_stand;

static stilb_scene_camera stress_camera_at(float pitch, stress_stand stand, float far_z)
{
	stilb_scene_camera camera = {.pitch = pitch, .fov_y = 0.85f, .near_z = 0.1f, .far_z = far_z};
	camera.position[1] = -sinf(pitch) * stand.distance + cosf(pitch) * stand.up;
	camera.position[2] = cosf(pitch) * stand.distance + sinf(pitch) * stand.up;
	return camera;
}

/* The nearest position from which the box around the whole grid is in the picture: d is stress_stand.distance, tan_x
 * and tan_y are the tangents of half the picture's angles. A corner at (x, y, z) along the camera's axes, relative to
 * the grid's centre, is in it if |x| <= tan_x (d - z) and |y - up| <= tan_y (d - z). The highest and the lowest corner
 * need d >= high - up / tan_y and d >= low + up / tan_y, with high = y / tan_y + z and low = -y / tan_y + z; the best
 * up makes both equal their mean. If the sides need a larger d, up is chosen so that the margins above and below are
 * the same: (y_high - up) / (d - z_high) = (up - y_low) / (d - z_low). */
static stress_stand stress_stand_all(float pitch, float half_side, float aspect)
{
	float tan_y = tanf(stress_camera_at(pitch, (stress_stand){0}, 1.0f).fov_y * 0.5f), tan_x = tan_y * aspect;
	float sides = 0.0f, high = -FLT_MAX, low = -FLT_MAX, v_high[3] = {0}, v_low[3] = {0};
	stilb_mat4 view = stilb_mat4_view(stilb_vec3_make(0, 0, 0), 0.0f, pitch);
	for (int corner = 0; corner < 8; corner++) {
		float p[3] = {corner & 1 ? half_side : -half_side, corner & 2 ? STRESS_TOP : 0.0f,
		              corner & 4 ? half_side : -half_side};
		float v[3];
		for (int row = 0; row < 3; row++)
			v[row] = view.m[row] * p[0] + view.m[4 + row] * p[1] + view.m[8 + row] * p[2];
		sides = fmaxf(sides, fabsf(v[0]) / tan_x + v[2]);
		if (v[1] / tan_y + v[2] > high) {
			high = v[1] / tan_y + v[2];
			memcpy(v_high, v, sizeof v);
		}
		if (-v[1] / tan_y + v[2] > low) {
			low = -v[1] / tan_y + v[2];
			memcpy(v_low, v, sizeof v);
		}
	}
	float d = fmaxf(sides, 0.5f * (high + low)) * 1.001f; /* a margin for rounding */
	float up = (v_high[1] * (d - v_low[2]) + v_low[1] * (d - v_high[2])) / (2.0f * d - v_high[2] - v_low[2]);
	return (stress_stand){d, up};
}

/* The position with distance and up multiplied by factor, and 3 m farther away, so that it is never inside a sphere. */
static stress_stand stress_stand_scale(stress_stand stand, float factor)
{
	return (stress_stand){3.0f + stand.distance * factor, stand.up * factor};
}

/* The share of models in view, estimated from at most about 16,000 of them. */
static double stress_visible_share(const stilb_scene *scene, const stilb_scene_camera *camera, float aspect)
{
	stilb_mat4 matrix = stilb_scene_camera_matrix(camera, aspect);
	stilb_frustum frustum = stilb_frustum_from_matrix(&matrix);
	uint32_t step = scene->stress_models / 16384 | 1, tested = 0, visible = 0;
	for (uint32_t m = 0; m < scene->stress_models; m += step, tested++) {
		bool inside = true;
		for (int p = 0; p < 6; p++) {
			stilb_plane plane = frustum.planes[p];
			inside &= plane.x * scene->bounds.x[m] + plane.y * scene->bounds.y[m] + plane.z * scene->bounds.z[m] +
			              plane.distance >=
			          -scene->bounds.radius[m];
		}
		visible += inside;
	}
	return (double)visible / (double)tested;
}

stilb_scene_camera stilb_scene_stress_camera(const stilb_scene *scene, stilb_scene_stress_view view, float aspect)
{
	STILB_ASSERT(scene && scene->stress_models > 0 && "a scene of stilb_scene_create_stress");
	STILB_ASSERT((unsigned)view <= STILB_SCENE_VIEW_FEW);
	STILB_ASSERT(aspect > 0.0f);
	float half_side = (float)stress_side(scene->stress_models) + 1.0f; /* with a margin of 1 m */
	float pitch = stress_pitch[view];
	stress_stand all = stress_stand_all(pitch, half_side, aspect);
	float far_z = 4.0f * (all.distance + fabsf(all.up) + half_side);
	if (view == STILB_SCENE_VIEW_ALL)
		return stress_camera_at(pitch, all, far_z);
	double share = view == STILB_SCENE_VIEW_HALF ? 0.5 : 0.01;
	float near = 0.0f, far = 1.0f; /* factors; a nearer camera sees fewer models: bisection */
	for (int i = 0; i < 24; i++) {
		float middle = 0.5f * (near + far);
		stilb_scene_camera camera = stress_camera_at(pitch, stress_stand_scale(all, middle), far_z);
		if (stress_visible_share(scene, &camera, aspect) > share)
			far = middle;
		else
			near = middle;
	}
	return stress_camera_at(pitch, stress_stand_scale(all, far), far_z);
}
