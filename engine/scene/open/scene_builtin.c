/* The built-in scenes: tables of data, and functions that make meshes of them. */
#include "scene/open/scene_builtin.h"
#include "scene/scene_internal.h"

#include <math.h>
#include <string.h>

/* Four corners in one plane, counter-clockwise seen from the front. */
typedef struct builtin_quad {
	float corner[4][3];
} builtin_quad;

static stilb_vec3 builtin_vector(const float p[3])
{
	return stilb_vec3_make(p[0], p[1], p[2]);
}

static void builtin_set_normal(stilb_scene_vertex *vertex, stilb_vec3 normal)
{
	for (int i = 0; i < 3; i++)
		vertex->normal[i] = normal[i];
}

/* A mesh of quads that share no vertices, each of the triangles 0 1 2 and 0 2 3. uv covers [0, 1]^2 on each. */
static stilb_result builtin_mesh_quads(const builtin_quad *quads, uint32_t count, stilb_scene_mesh *mesh)
{
	STILB_ASSERT(quads && count > 0);
	static const uint32_t order[6] = {0, 1, 2, 0, 2, 3};
	static const float uv[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
	stilb_result result = scene_mesh_create(mesh, 4 * count, 6 * count);
	if (result != STILB_OK)
		return result;
	for (uint32_t q = 0; q < count; q++) {
		const float(*corner)[3] = quads[q].corner;
		stilb_vec3 a = builtin_vector(corner[0]), b = builtin_vector(corner[1]), c = builtin_vector(corner[2]);
		stilb_vec3 normal = stilb_vec3_normalize(stilb_vec3_cross(b - a, c - a));
		STILB_ASSERT(fabsf(stilb_vec3_dot(normal, builtin_vector(corner[3]) - a)) < 1e-4f && "in one plane");
		for (int i = 0; i < 4; i++) {
			stilb_scene_vertex *vertex = &mesh->vertices[4 * q + (uint32_t)i];
			memcpy(vertex->position, corner[i], sizeof vertex->position);
			memcpy(vertex->uv, uv[i], sizeof vertex->uv);
			builtin_set_normal(vertex, normal);
		}
		for (uint32_t i = 0; i < 6; i++)
			mesh->indices[6 * q + i] = 4 * q + order[i];
	}
	return STILB_OK;
}

static bool builtin_is_reflectance(float r, float g, float b)
{
	return r >= 0.0f && r <= 1.0f && g >= 0.0f && g <= 1.0f && b >= 0.0f && b <= 1.0f;
}

/* A matt material of exactly this reflectance. */
static stilb_scene_material builtin_matt(float r, float g, float b)
{
	STILB_ASSERT(builtin_is_reflectance(r, g, b));
	return (stilb_scene_material){.diffuse = {r, g, b}, .roughness = 1.0f};
}

/* A black material that emits this radiance. */
static stilb_scene_material builtin_lamp(float r, float g, float b)
{
	STILB_ASSERT(r >= 0.0f && g >= 0.0f && b >= 0.0f);
	return (stilb_scene_material){.emission = {r, g, b}, .roughness = 1.0f};
}

/* Puts the lamp that part shows, a quad that is a rectangle, into the scene's list of lights: its only one. */
static stilb_result builtin_add_lamp(stilb_scene *scene, uint32_t part, const builtin_quad *quad)
{
	STILB_ASSERT(part < scene->part_count);
	stilb_result result = scene_add_lights(scene, 1);
	if (result != STILB_OK)
		return result;
	const float *emission = scene->materials[scene->part_material[part]].emission;
	stilb_vec3 corner = builtin_vector(quad->corner[0]);
	stilb_vec3 x = builtin_vector(quad->corner[1]) - corner, y = builtin_vector(quad->corner[3]) - corner;
	stilb_vec3 across = stilb_vec3_cross(x, y), normal = stilb_vec3_normalize(across);
	float area = stilb_vec3_dot(across, normal);
	stilb_scene_light *light = scene->lights;
	*light = (stilb_scene_light){.kind = STILB_SCENE_LIGHT_RECTANGLE, .face = part + 1};
	for (int i = 0; i < 3; i++) {
		light->position[i] = corner[i] + 0.5f * x[i] + 0.5f * y[i];
		light->direction[i] = normal[i];
		light->intensity[i] = emission[i] * area;
		light->half_x[i] = 0.5f * x[i];
		light->half_y[i] = 0.5f * y[i];
	}
	return STILB_OK;
}

/* A material with specular reflection only. */
static stilb_scene_material builtin_metal(float r, float g, float b, float roughness)
{
	STILB_ASSERT(builtin_is_reflectance(r, g, b) && roughness >= 0.0f && roughness <= 1.0f);
	return (stilb_scene_material){.specular = {r, g, b}, .roughness = roughness};
}

/* A scene of one model. Part i has material i and mesh i, or the last mesh if there are fewer meshes. */
static stilb_result builtin_create(uint32_t part_count, uint32_t mesh_count, stilb_scene **scene)
{
	STILB_ASSERT(mesh_count >= 1 && mesh_count <= part_count);
	stilb_result result = scene_create(1, part_count, mesh_count, part_count, scene);
	if (result != STILB_OK)
		return result;
	(*scene)->first_part[1] = part_count;
	for (uint32_t i = 0; i < part_count; i++) {
		(*scene)->part_mesh[i] = i < mesh_count ? i : mesh_count - 1;
		(*scene)->part_material[i] = i;
		(*scene)->part_transform[i] = stilb_mat4_identity();
	}
	return STILB_OK;
}

/* Ends every create function: completes the scene, or destroys it if result is a failure. */
static stilb_result builtin_done(stilb_result result, stilb_scene *scene, stilb_scene **out)
{
	*out = NULL;
	if (result != STILB_OK) {
		stilb_scene_destroy(scene);
		return result;
	}
	STILB_CHECK(scene_is_sound(scene));
	scene_fit_bounds(scene, 0);
	*out = scene;
	return STILB_OK;
}

/* ---- cornell ----------------------------------------------------------------------------------------------------- */

static const builtin_quad cornell_white[] = {
	{{{0, 0, 0}, {0, 0, 1}, {1, 0, 1}, {1, 0, 0}}}, /* floor, back */
	{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}},
	{{{0, 1, 0}, {1, 1, 0}, {1, 1, 0.35f}, {0, 1, 0.35f}}}, /* the ceiling around its hole */
	{{{0, 1, 0.65f}, {1, 1, 0.65f}, {1, 1, 1}, {0, 1, 1}}},
	{{{0, 1, 0.35f}, {0.35f, 1, 0.35f}, {0.35f, 1, 0.65f}, {0, 1, 0.65f}}},
	{{{0.65f, 1, 0.35f}, {1, 1, 0.35f}, {1, 1, 0.65f}, {0.65f, 1, 0.65f}}},
	/* the tall block: top and sides */
	{{{0.2453491f, 0.6f, 0.5522569f},
      {0.5272569f, 0.6f, 0.4496509f},
      {0.4246509f, 0.6f, 0.1677431f},
      {0.1427431f, 0.6f, 0.2703491f}}},
	{{{0.1427431f, 0, 0.2703491f},
      {0.1427431f, 0.6f, 0.2703491f},
      {0.4246509f, 0.6f, 0.1677431f},
      {0.4246509f, 0, 0.1677431f}}},
	{{{0.4246509f, 0, 0.1677431f},
      {0.4246509f, 0.6f, 0.1677431f},
      {0.5272569f, 0.6f, 0.4496509f},
      {0.5272569f, 0, 0.4496509f}}},
	{{{0.5272569f, 0, 0.4496509f},
      {0.5272569f, 0.6f, 0.4496509f},
      {0.2453491f, 0.6f, 0.5522569f},
      {0.2453491f, 0, 0.5522569f}}},
	{{{0.2453491f, 0, 0.5522569f},
      {0.2453491f, 0.6f, 0.5522569f},
      {0.1427431f, 0.6f, 0.2703491f},
      {0.1427431f, 0, 0.2703491f}}},
	/* the short block: top and sides */
	{{{0.4926985f, 0.3f, 0.77959f},
      {0.77959f, 0.3f, 0.8673015f},
      {0.8673015f, 0.3f, 0.58041f},
      {0.58041f, 0.3f, 0.4926985f}}},
	{{{0.58041f, 0, 0.4926985f},
      {0.58041f, 0.3f, 0.4926985f},
      {0.8673015f, 0.3f, 0.58041f},
      {0.8673015f, 0, 0.58041f}}},
	{{{0.8673015f, 0, 0.58041f},
      {0.8673015f, 0.3f, 0.58041f},
      {0.77959f, 0.3f, 0.8673015f},
      {0.77959f, 0, 0.8673015f}}},
	{{{0.77959f, 0, 0.8673015f},
      {0.77959f, 0.3f, 0.8673015f},
      {0.4926985f, 0.3f, 0.77959f},
      {0.4926985f, 0, 0.77959f}}},
	{{{0.4926985f, 0, 0.77959f},
      {0.4926985f, 0.3f, 0.77959f},
      {0.58041f, 0.3f, 0.4926985f},
      {0.58041f, 0, 0.4926985f}}},
};
static const builtin_quad cornell_red = {{{0, 0, 0}, {0, 1, 0}, {0, 1, 1}, {0, 0, 1}}};
static const builtin_quad cornell_green = {{{1, 0, 0}, {1, 0, 1}, {1, 1, 1}, {1, 1, 0}}};
static const builtin_quad cornell_light = {
	{{0.35f, 1, 0.35f}, {0.65f, 1, 0.35f}, {0.65f, 1, 0.65f}, {0.35f, 1, 0.65f}}};

stilb_result scene_create_cornell(float number, stilb_scene **out)
{
	(void)number;
	const struct {
		const builtin_quad *quads;
		uint32_t count;
		stilb_scene_material material;
	} parts[] = {
		{cornell_white, sizeof cornell_white / sizeof *cornell_white, builtin_matt(0.73f, 0.73f, 0.73f)},
		{&cornell_red, 1, builtin_matt(0.63f, 0.065f, 0.05f)},
		{&cornell_green, 1, builtin_matt(0.14f, 0.45f, 0.091f)},
		{&cornell_light, 1, builtin_lamp(15, 15, 15)},
	};
	stilb_scene *scene;
	stilb_result result = builtin_create(4, 4, &scene);
	for (int i = 0; result == STILB_OK && i < 4; i++) {
		result = builtin_mesh_quads(parts[i].quads, parts[i].count, &scene->meshes[i]);
		scene->materials[i] = parts[i].material;
	}
	if (result == STILB_OK)
		result = builtin_add_lamp(scene, 3, &cornell_light);
	if (result == STILB_OK)
		scene->camera = scene_camera_look(stilb_vec3_make(0.5f, 0.5f, 2.4f), stilb_vec3_make(0.5f, 0.5f, 0),
		                                  2.0f * atanf(0.5f / 1.4f));
	return builtin_done(result, scene, out);
}

/* ---- furnace ----------------------------------------------------------------------------------------------------- */

/* A sphere seen from inside. Every triangle has its own vertices with its geometric normal: with a normal that differs
 * from it, shading would lose light. */
static stilb_result builtin_mesh_inward(uint32_t splits, stilb_scene_mesh *mesh)
{
	stilb_scene_mesh ball = {0};
	stilb_result result = stilb_scene_mesh_sphere(splits, &ball);
	if (result == STILB_OK)
		result = scene_mesh_create(mesh, ball.index_count, ball.index_count);
	for (uint32_t i = 0; result == STILB_OK && i < ball.index_count; i += 3) {
		stilb_vec3 p[3];
		for (uint32_t k = 0; k < 3; k++) {
			mesh->vertices[i + k] = ball.vertices[ball.indices[i + 2 - k]];
			mesh->indices[i + k] = i + k;
			p[k] = builtin_vector(mesh->vertices[i + k].position);
		}
		stilb_vec3 normal = stilb_vec3_normalize(stilb_vec3_cross(p[1] - p[0], p[2] - p[0]));
		for (uint32_t k = 0; k < 3; k++)
			builtin_set_normal(&mesh->vertices[i + k], normal);
	}
	stilb_scene_mesh_finish(&ball);
	return result;
}

stilb_result scene_create_furnace(float reflectance, stilb_scene **out)
{
	STILB_ASSERT(reflectance >= 0.0f && reflectance < 1.0f);
	stilb_scene *scene;
	stilb_result result = builtin_create(1, 1, &scene);
	if (result == STILB_OK)
		result = builtin_mesh_inward(2, &scene->meshes[0]);
	if (result == STILB_OK) {
		scene->materials[0] = builtin_matt(reflectance, reflectance, reflectance);
		for (int i = 0; i < 3; i++)
			scene->materials[0].emission[i] = 1.0f;
		scene->camera = scene_camera_look(stilb_vec3_make(0, 0, 0), stilb_vec3_make(0, 0, -1), 1.0f);
	}
	return builtin_done(result, scene, out);
}

/* ---- plane-wall -------------------------------------------------------------------------------------------------- */

#define WALL_FAR 100.0f /* metres, nearly infinite: a point 1 m from the wall sees 1e-7 of the sky past its ends */

stilb_result scene_create_plane_wall(float number, stilb_scene **out)
{
	(void)number;
	static const builtin_quad plane = {
		{{-WALL_FAR, 0, WALL_FAR}, {WALL_FAR, 0, WALL_FAR}, {WALL_FAR, 0, -WALL_FAR}, {-WALL_FAR, 0, -WALL_FAR}}};
	static const builtin_quad wall = {{{0, 0, WALL_FAR}, {0, 0, -WALL_FAR}, {0, 1, -WALL_FAR}, {0, 1, WALL_FAR}}};
	stilb_scene *scene;
	stilb_result result = builtin_create(2, 2, &scene);
	if (result == STILB_OK)
		result = builtin_mesh_quads(&plane, 1, &scene->meshes[0]);
	if (result == STILB_OK)
		result = builtin_mesh_quads(&wall, 1, &scene->meshes[1]);
	if (result == STILB_OK) {
		scene->materials[0] = builtin_matt(0.5f, 0.5f, 0.5f);
		scene->materials[1] = builtin_matt(0, 0, 0);
		scene->surroundings = (stilb_scene_surroundings){.sky = {1, 1, 1}, .ground = {1, 1, 1}};
		scene->camera = scene_camera_look(stilb_vec3_make(3.5f, 2.5f, 2.5f), stilb_vec3_make(1, 0, 0), 0.9f);
	}
	return builtin_done(result, scene, out);
}

/* ---- outdoor ----------------------------------------------------------------------------------------------------- */

#define BUMPS_AROUND 140u /* quads of a bumpy sphere around its axis */
#define BUMPS_DOWN 70u    /* and from pole to pole: 2 * 140 * 69 triangles */

/* The radius of the bumpy sphere in unit direction d: 1 plus four waves. *gradient: of the radius with respect to d. */
static float builtin_bumps(stilb_vec3 d, stilb_vec3 *gradient)
{
	static const float waves[][5] = {/* amplitude, wave vector, phase */
	                                 {0.06f, 5.1f, 1.3f, -2.7f, 0.4f},
	                                 {0.05f, -2.2f, 6.4f, 3.9f, 1.7f},
	                                 {0.03f, 8.3f, -5.6f, 7.7f, 2.9f},
	                                 {0.012f, -11.0f, 9.6f, 13.2f, 0.8f}};
	STILB_ASSERT(fabsf(stilb_vec3_dot(d, d) - 1.0f) < 1e-4f);
	float radius = 1.0f;
	*gradient = (stilb_vec3){0};
	for (size_t i = 0; i < sizeof waves / sizeof *waves; i++) {
		stilb_vec3 k = stilb_vec3_make(waves[i][1], waves[i][2], waves[i][3]);
		float angle = stilb_vec3_dot(k, d) + waves[i][4];
		radius += waves[i][0] * sinf(angle);
		*gradient += k * (waves[i][0] * cosf(angle));
	}
	return radius;
}

/* The vertex of the bumpy sphere at p = r(d) d, d the direction with longitude 2 pi u and polar angle pi v and r the
 * radius there (builtin_bumps). Its tangents are r t + (g.t) d for all t perpendicular to d, g the gradient of r; so
 * the normal is r d - (g - (g.d) d), perpendicular to all of them. */
static stilb_scene_vertex builtin_bumpy_vertex(float u, float v)
{
	float longitude = 6.2831853071795865f * u, latitude = 3.1415926535897932f * v;
	stilb_vec3 gradient,
		d = stilb_vec3_make(sinf(latitude) * sinf(longitude), cosf(latitude), sinf(latitude) * cosf(longitude));
	float radius = builtin_bumps(d, &gradient);
	stilb_vec3 normal = d * radius - (gradient - d * stilb_vec3_dot(gradient, d));
	stilb_scene_vertex vertex = {.position = {radius * d[0], radius * d[1], radius * d[2]}, .uv = {u, v}};
	builtin_set_normal(&vertex, stilb_vec3_normalize(normal));
	return vertex;
}

static stilb_result builtin_mesh_bumpy(stilb_scene_mesh *mesh)
{
	uint32_t across = BUMPS_AROUND + 1; /* vertices on the seam exist twice, with u = 0 and u = 1 */
	stilb_result result = scene_mesh_create(mesh, across * (BUMPS_DOWN + 1), 6 * BUMPS_AROUND * (BUMPS_DOWN - 1));
	if (result != STILB_OK)
		return result;
	uint32_t *index = mesh->indices;
	for (uint32_t row = 0; row <= BUMPS_DOWN; row++)
		for (uint32_t column = 0; column <= BUMPS_AROUND; column++) {
			/* The last column has the same positions as the first, bit for bit. */
			stilb_scene_vertex *vertex = &mesh->vertices[row * across + column];
			*vertex = builtin_bumpy_vertex((float)(column % BUMPS_AROUND) / BUMPS_AROUND, (float)row / BUMPS_DOWN);
			vertex->uv[0] = (float)column / BUMPS_AROUND;
		}
	for (uint32_t row = 0; row < BUMPS_DOWN; row++)
		for (uint32_t column = 0; column < BUMPS_AROUND; column++) {
			/* b lies below a; a + 1 and b + 1 are their eastern neighbours. */
			uint32_t a = row * across + column, b = a + across;
			const uint32_t triangles[6] = {a, b, b + 1, a, b + 1, a + 1};
			uint32_t first = row == BUMPS_DOWN - 1 ? 3 : 0, end = row == 0 ? 3 : 6; /* one triangle at a pole */
			for (uint32_t i = first; i < end; i++)
				*index++ = triangles[i];
		}
	STILB_ASSERT(index == mesh->indices + mesh->index_count);
	return STILB_OK;
}

/* Rotates by `turn` radians about +Y, scales, then translates. */
static stilb_mat4 builtin_place(float turn, float scale, float x, float y, float z)
{
	STILB_ASSERT(scale > 0.0f);
	float c = scale * cosf(turn), s = scale * sinf(turn);
	return (stilb_mat4){.m = {c, 0, -s, 0, 0, scale, 0, 0, s, 0, c, 0, x, y, z, 1}};
}

stilb_result scene_create_outdoor(float number, stilb_scene **out)
{
	(void)number;
	static const builtin_quad ground = {{{-10, 0, 10}, {10, 0, 10}, {10, 0, -10}, {-10, 0, -10}}};
	static const builtin_quad sun = {{{6, 20, 4}, {8, 20, 4}, {8, 20, 6}, {6, 20, 6}}};
	static const float colors[9][3] = {{0.70f, 0.65f, 0.55f}, {0.55f, 0.20f, 0.15f}, {0.25f, 0.45f, 0.25f},
	                                   {0.60f, 0.45f, 0.20f}, {0.75f, 0.75f, 0.75f}, {0.20f, 0.35f, 0.60f},
	                                   {0.45f, 0.30f, 0.50f}, {0.35f, 0.55f, 0.55f}, {0.65f, 0.50f, 0.40f}};
	stilb_scene *scene;
	stilb_result result = builtin_create(11, 3, &scene);
	if (result == STILB_OK)
		result = builtin_mesh_quads(&ground, 1, &scene->meshes[0]);
	if (result == STILB_OK)
		result = builtin_mesh_quads(&sun, 1, &scene->meshes[1]);
	if (result == STILB_OK)
		result = builtin_mesh_bumpy(&scene->meshes[2]);
	for (int i = 0; result == STILB_OK && i < 9; i++) {
		int column = i % 3, row = i / 3;
		float radius = 1.3f + 0.1f * (float)(i * 4 % 9), x = 5.0f * (float)(column - 1), z = 5.0f * (float)(row - 1);
		scene->part_transform[2 + i] = builtin_place(0.7f * (float)i, radius, x, 1.05f * radius, z);
		scene->materials[2 + i] = builtin_matt(colors[i][0], colors[i][1], colors[i][2]);
	}
	if (result == STILB_OK) {
		scene->materials[0] = builtin_matt(0.4f, 0.42f, 0.3f);
		scene->materials[1] = builtin_lamp(400, 400, 400);
		scene->surroundings = (stilb_scene_surroundings){.sky = {0.5f, 0.7f, 1.0f}, .ground = {0.5f, 0.7f, 1.0f}};
		scene->camera = scene_camera_look(stilb_vec3_make(1.5f, 6, 15), stilb_vec3_make(0, 0.8f, 0), 0.75f);
		result = builtin_add_lamp(scene, 1, &sun);
	}
	return builtin_done(result, scene, out);
}

/* ---- stress ------------------------------------------------------------------------------------------------------ */

stilb_result scene_create_stress_default(float number, stilb_scene **scene)
{
	(void)number;
	return stilb_scene_create_stress(10000, 1, scene);
}

/* ---- spheres ----------------------------------------------------------------------------------------------------- */

#define CHECKER_CELLS 16u  /* across the texture */
#define CHECKER_PIXELS 16u /* across a cell: enough that edges look sharp when the texture is interpolated */

static stilb_result builtin_checker(stilb_image *image)
{
	uint32_t side = CHECKER_CELLS * CHECKER_PIXELS;
	stilb_result result = stilb_image_create(image, side, side, 3, STILB_IMAGE_U8_SRGB);
	if (result != STILB_OK)
		return result;
	uint8_t *pixel = image->pixels;
	for (uint32_t y = 0; y < side; y++)
		for (uint32_t x = 0; x < side; x++)
			for (int i = 0; i < 3; i++)
				*pixel++ = (x / CHECKER_PIXELS + y / CHECKER_PIXELS) % 2 ? 255 : 130;
	return STILB_OK;
}

stilb_result scene_create_spheres(float number, stilb_scene **out)
{
	(void)number;
	static const builtin_quad ground = {{{-96, 0, 96}, {96, 0, 96}, {96, 0, -96}, {-96, 0, -96}}};
	static const builtin_quad lamp = {{{-4, 9.5f, 2}, {4, 9.5f, 2}, {4, 8.5f, 5}, {-4, 8.5f, 5}}};
	static const float clay[3] = {0.60f, 0.22f, 0.12f}, blue[3] = {0.05f, 0.15f, 0.50f},
					   white[3] = {0.80f, 0.80f, 0.78f};
	static const float green[3] = {0.10f, 0.40f, 0.12f}, coat[3] = {0.04f, 0.04f, 0.04f};
	stilb_scene *scene;
	stilb_result result = builtin_create(9, 3, &scene);
	if (result == STILB_OK)
		result = scene_add_textures(scene, 1);
	if (result == STILB_OK)
		result = builtin_checker(&scene->textures[0]);
	if (result == STILB_OK)
		result = builtin_mesh_quads(&ground, 1, &scene->meshes[0]);
	if (result == STILB_OK)
		result = builtin_mesh_quads(&lamp, 1, &scene->meshes[1]);
	if (result == STILB_OK)
		result = stilb_scene_mesh_sphere(5, &scene->meshes[2]);
	if (result == STILB_OK) {
		for (uint32_t v = 0; v < 4; v++) /* so that a cell is 2 m wide */
			for (int i = 0; i < 2; i++)
				scene->meshes[0].vertices[v].uv[i] *= 96.0f / CHECKER_CELLS;
		stilb_scene_material *material = scene->materials;
		material[0] = builtin_matt(0.6f, 0.6f, 0.6f);
		material[0].diffuse_texture = 1;
		material[1] = builtin_lamp(22, 20, 18);
		material[2] = builtin_matt(clay[0], clay[1], clay[2]);
		material[3] = stilb_scene_material_make(green, coat, 0.6f);
		material[4] = stilb_scene_material_make(blue, coat, 0.25f);
		material[5] = stilb_scene_material_make(white, coat, 0.4f);
		material[6] = builtin_metal(1.00f, 0.77f, 0.34f, 0.35f); /* gold */
		material[7] = builtin_metal(0.95f, 0.64f, 0.54f, 0.55f); /* copper, brushed */
		material[7].anisotropy = 0.7f;
		material[8] = builtin_metal(0.91f, 0.92f, 0.92f, 0.2f); /* aluminium */
		for (int i = 0; i < 7; i++)
			scene->part_transform[2 + i] = stilb_mat4_scale_translate(1.0f, 2.1f * (float)(i - 3), 1.0f, 0.0f);
		scene->surroundings = (stilb_scene_surroundings){.sky = {0.35f, 0.48f, 0.70f}, .ground = {0.12f, 0.10f, 0.08f}};
		scene->camera = scene_camera_look(stilb_vec3_make(0, 4.5f, 19), stilb_vec3_make(0, 0.9f, 0), 0.74f);
		result = builtin_add_lamp(scene, 1, &lamp);
	}
	return builtin_done(result, scene, out);
}
