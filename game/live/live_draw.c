#include "live_draw.h"

#include "shading/shade_srgb.h"

#include <math.h>
#include <string.h>

#define DRAW_GRID 10     /* cells from the origin to the grid's side */
#define DRAW_SLICE 1024u /* models that a job looks at */
#define DRAW_DOT 3.0f    /* pixels: bounds of a smaller radius are dots */
#define DRAW_RAYS 4      /* lines along a cone */

bool live_draw_parse(const char *text, live_draw *draw)
{
	*draw = (live_draw){0};
	const struct {
		const char *word;
		bool *value;
	} words[] = {{"bounds", &draw->bounds}, {"lights", &draw->lights}, {"axes", &draw->axes}};
	while (text) {
		size_t length = strcspn(text, ","), w = 0;
		while (w < 3 && (strlen(words[w].word) != length || strncmp(words[w].word, text, length) != 0))
			w++;
		if (w == 3 || *words[w].value)
			return false;
		*words[w].value = true;
		text = text[length] == ',' ? text + length + 1 : NULL;
	}
	return true;
}

/* ---- bounds ------------------------------------------------------------------------------------------------------ */

typedef struct draw_bounds {
	stilb_debug *debug;
	const stilb_scene *scene;
	stilb_frustum frustum;
	float pixels; /* of a metre, 1 m in front of the camera */
} draw_bounds;

/* As culling does it (cull.h). */
static bool draw_sees(const stilb_frustum *frustum, const float center[3], float radius)
{
	for (int p = 0; p < 6; p++) {
		const stilb_plane *plane = &frustum->planes[p];
		if (!(center[0] * plane->x + center[1] * plane->y + center[2] * plane->z + plane->distance >= -radius))
			return false;
	}
	return true;
}

static void draw_slice_bounds(uint32_t begin, uint32_t end, uint32_t worker, void *context)
{
	const draw_bounds *work = context;
	const stilb_scene_bounds *bounds = &work->scene->bounds;
	const float *eye = work->scene->camera.position;
	stilb_debug_style green = {.rgba = 0x40ff60ff};
	(void)worker;
	for (uint32_t m = begin; m < end; m++) {
		float center[3] = {bounds->x[m], bounds->y[m], bounds->z[m]}, radius = bounds->radius[m];
		float axis[3] = {eye[0] - center[0], eye[1] - center[1], eye[2] - center[2]};
		float square = axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2];
		if (!draw_sees(&work->frustum, center, radius) || !isfinite(radius) || !(square > radius * radius))
			continue;
		float pixels = work->pixels * radius / sqrtf(square);
		if (pixels < DRAW_DOT) { /* a circle would be a blot of 48 lines */
			stilb_debug_style dot = {.rgba = green.rgba, .width = fmaxf(2.0f * pixels, 1.0f)};
			stilb_debug_line(work->debug, center, center, dot);
			continue;
		}
		/* The outline of a sphere is the circle in which the lines of sight touch it. */
		float nearer = radius * radius / square, outline = radius * sqrtf(1.0f - nearer), at[3];
		for (int a = 0; a < 3; a++)
			at[a] = center[a] + nearer * axis[a];
		stilb_debug_circle(work->debug, at, axis, outline, green);
	}
}

static void draw_all_bounds(stilb_engine *engine, const stilb_scene *scene)
{
	uint32_t width, height;
	stilb_engine_size(engine, &width, &height);
	stilb_mat4 matrix = stilb_scene_camera_matrix(&scene->camera, (float)width / (float)height);
	draw_bounds work = {
		.debug = stilb_engine_debug(engine),
		.scene = scene,
		.frustum = stilb_frustum_from_matrix(&matrix),
		.pixels = 0.5f * (float)height / tanf(0.5f * scene->camera.fov_y),
	};
	stilb_job_parallel_for(stilb_engine_pool(engine), scene->model_count, DRAW_SLICE, draw_slice_bounds, &work, 0);
}

/* ---- lights ------------------------------------------------------------------------------------------------------ */

/* A sphere around all models. */
static stilb_sphere draw_scene_sphere(const stilb_scene *scene)
{
	const stilb_scene_bounds *b = &scene->bounds;
	float low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY}, half[3];
	for (uint32_t m = 0; m < scene->model_count; m++) {
		float center[3] = {b->x[m], b->y[m], b->z[m]}, radius = b->radius[m];
		if (!isfinite(radius))
			continue;
		for (int a = 0; a < 3; a++) {
			low[a] = fminf(low[a], center[a] - radius);
			high[a] = fmaxf(high[a], center[a] + radius);
		}
	}
	if (!(low[0] <= high[0]))
		return (stilb_sphere){.radius = 1.0f};
	for (int a = 0; a < 3; a++)
		half[a] = 0.5f * (high[a] - low[a]);
	float radius = sqrtf(half[0] * half[0] + half[1] * half[1] + half[2] * half[2]);
	return (stilb_sphere){low[0] + half[0], low[1] + half[1], low[2] + half[2], radius > 0.0f ? radius : 1.0f};
}

/* The light's colour, as bright as a screen shows it. */
static uint32_t draw_light_color(const stilb_scene_light *light)
{
	const float *i = light->intensity;
	float most = fmaxf(fmaxf(i[0], i[1]), i[2]);
	uint32_t rgba = 0;
	for (int c = 0; c < 3; c++) {
		float code = most > 0.0f ? shade_srgb_from_linear(fminf(i[c] / most, 1.0f)) : 0.5f;
		rgba = rgba << 8 | (uint32_t)(255.0f * code + 0.5f);
	}
	return rgba << 8 | 0xff;
}

static void draw_along(float out[3], const float from[3], const float direction[3], float distance)
{
	for (int a = 0; a < 3; a++)
		out[a] = from[a] + distance * direction[a];
}

/* A cone of light: its edge at `length` from the light. */
static void draw_cone(stilb_debug *debug, const stilb_scene_light *light, float length, stilb_debug_style style)
{
	float sine = sqrtf(fmaxf(1.0f - light->cos_outer * light->cos_outer, 0.0f)), center[3], end[3];
	const float *n = light->direction;
	stilb_vec3 axis = stilb_vec3_make(n[0], n[1], n[2]);
	stilb_vec3 other = fabsf(n[1]) < 0.9f ? stilb_vec3_make(0, 1, 0) : stilb_vec3_make(1, 0, 0);
	stilb_vec3 u = stilb_vec3_normalize(stilb_vec3_cross(axis, other)), v = stilb_vec3_cross(axis, u);
	draw_along(center, light->position, n, length * light->cos_outer);
	stilb_debug_circle(debug, center, n, length * sine, style);
	for (int r = 0; r < DRAW_RAYS; r++) {
		float angle = 6.2831853f * (float)r / DRAW_RAYS, x = length * sine * cosf(angle),
			  y = length * sine * sinf(angle);
		for (int a = 0; a < 3; a++)
			end[a] = center[a] + x * u[a] + y * v[a];
		stilb_debug_line(debug, light->position, end, style);
	}
}

static void draw_rectangle(stilb_debug *debug, const stilb_scene_light *light, stilb_debug_style style)
{
	float corners[4][3];
	for (int a = 0; a < 3; a++) {
		float c = light->position[a], x = light->half_x[a], y = light->half_y[a];
		corners[0][a] = c - x - y;
		corners[1][a] = c + x - y;
		corners[2][a] = c + x + y;
		corners[3][a] = c - x + y;
	}
	for (int i = 0; i < 4; i++)
		stilb_debug_line(debug, corners[i], corners[(i + 1) % 4], style);
}

/* An arrow of a light from infinitely far away, beside the scene. */
static void draw_sun(stilb_debug *debug, const stilb_scene_light *light, stilb_sphere scene, float place[3],
                     stilb_debug_style style)
{
	float center[3] = {scene.x, scene.y, scene.z}, tip[3], back[3];
	draw_along(place, center, light->direction, -1.2f * scene.radius);
	draw_along(tip, place, light->direction, 0.4f * scene.radius);
	draw_along(back, tip, light->direction, -0.05f * scene.radius);
	stilb_debug_line(debug, place, tip, style);
	stilb_debug_circle(debug, back, light->direction, 0.02f * scene.radius, style);
	stilb_debug_circle(debug, place, light->direction, 0.05f * scene.radius, style);
}

/* One light; unit: the length of what has none, metres. */
static void draw_one_light(stilb_debug *debug, const stilb_scene_light *light, uint32_t number, stilb_sphere scene)
{
	float unit = 0.05f * scene.radius, place[3], end[3];
	bool flat = light->kind == STILB_SCENE_LIGHT_DISK || light->kind == STILB_SCENE_LIGHT_RECTANGLE;
	bool ends = light->falloff != STILB_SCENE_LIGHT_PHYSICAL && light->kind != STILB_SCENE_LIGHT_DIRECTIONAL;
	stilb_debug_style shape = {.rgba = draw_light_color(light), .width = 2.0f}, reach = shape;
	reach.rgba = (shape.rgba & ~0xffu) | 0x60;
	reach.width = 1.0f;
	memcpy(place, light->position, sizeof place);
	switch (light->kind) {
	case STILB_SCENE_LIGHT_POINT:
		stilb_debug_sphere(debug, place, 0.1f * unit, shape);
		break;
	case STILB_SCENE_LIGHT_SPOT:
		draw_cone(debug, light, ends ? light->reach : 4.0f * unit, shape);
		break;
	case STILB_SCENE_LIGHT_DIRECTIONAL:
		draw_sun(debug, light, scene, place, shape);
		break;
	case STILB_SCENE_LIGHT_SPHERE:
		stilb_debug_sphere(debug, place, light->radius, shape);
		break;
	case STILB_SCENE_LIGHT_DISK:
		stilb_debug_circle(debug, place, light->direction, light->radius, shape);
		break;
	default:
		draw_rectangle(debug, light, shape);
		break;
	}
	if (flat) { /* the side to which it shines */
		draw_along(end, place, light->direction, unit);
		stilb_debug_line(debug, place, end, shape);
	}
	if (ends && light->kind != STILB_SCENE_LIGHT_SPOT)
		stilb_debug_sphere(debug, place, light->reach, reach);
	shape.on_top = true;
	stilb_debug_text(debug, place, shape, "light %u", number);
}

/* ---- axes -------------------------------------------------------------------------------------------------------- */

/* A cell is a power of ten of a metre, and the grid as large as the scene or up to ten times that. */
static void draw_axes(stilb_debug *debug, stilb_sphere scene)
{
	static const uint32_t colors[3] = {0xff4050ff, 0x40c040ff, 0x4080ffff}; /* as stilb_debug_axes has them */
	float cell = powf(10.0f, ceilf(log10f(scene.radius / (float)DRAW_GRID))), side = cell * (float)DRAW_GRID;
	stilb_mat4 origin = stilb_mat4_identity();
	for (int i = -DRAW_GRID; i <= DRAW_GRID; i++) {
		float at = cell * (float)i, x[2][3] = {{-side, 0, at}, {side, 0, at}},
			  z[2][3] = {{at, 0, -side}, {at, 0, side}};
		stilb_debug_style grey = {.rgba = i == 0 ? 0xb0b0b0c0 : 0x90909060};
		stilb_debug_line(debug, x[0], x[1], grey);
		stilb_debug_line(debug, z[0], z[1], grey);
	}
	stilb_debug_axes(debug, &origin, side, (stilb_debug_style){.rgba = 0xff, .width = 2.0f});
	for (int a = 0; a < 3; a++) {
		float end[3] = {0};
		end[a] = side;
		stilb_debug_text(debug, end, (stilb_debug_style){.rgba = colors[a], .on_top = true}, "%c  %g m", "xyz"[a],
		                 (double)side);
	}
}

void live_draw_frame(const live_draw *draw, stilb_engine *engine)
{
	const stilb_scene *scene = stilb_engine_scene(engine);
	stilb_debug *debug = stilb_engine_debug(engine);
	if (!scene || !(draw->bounds || draw->lights || draw->axes))
		return;
	stilb_sphere sphere = draw_scene_sphere(scene);
	if (draw->axes)
		draw_axes(debug, sphere);
	for (uint32_t l = 0; draw->lights && l < scene->light_count; l++)
		draw_one_light(debug, &scene->lights[l], l, sphere);
	if (draw->bounds)
		draw_all_bounds(engine, scene);
}
