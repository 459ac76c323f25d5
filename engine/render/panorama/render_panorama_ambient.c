/* What lights in place of surroundings (stilb_render_ambient): of a panorama its halves' means and its harmonics, once;
 * and of a view what its kind takes of them. */
#include "base/base_contract.h"
#include "render/panorama/render_panorama_work.h"
#include "render/render_internal.h"

#include <math.h>
#include <string.h>

#define AMBIENT_LOOKS 2048 /* directions in which light is looked for that is negative */
#define AMBIENT_HALVINGS 8 /* of the blur */

/* ---- a panorama ------------------------------------------------------------------------------------------------- */

/* Adds the cells' light to the sums of the two halves and to the harmonics. */
static void ambient_sum(const render_panorama_work *work, double halves[2][3], double harmonics[3][9])
{
	double step = 2.0 * M_PI / PANORAMA_ACROSS;
	float sine[PANORAMA_ACROSS], cosine[PANORAMA_ACROSS];
	for (uint32_t x = 0; x < PANORAMA_ACROSS; x++) {
		sine[x] = (float)sin((x + 0.5) * step - M_PI);
		cosine[x] = (float)cos((x + 0.5) * step - M_PI);
	}
	for (uint32_t y = 0; y < PANORAMA_DOWN; y++) {
		float high = (float)cos((y + 0.5) * step), wide = (float)sin((y + 0.5) * step);
		for (uint32_t x = 0; x < PANORAMA_ACROSS; x++) {
			const float *light = work->cells[y][x];
			shade_sh basis = shade_sh_basis(stilb_vec3_make(wide * sine[x], high, -wide * cosine[x]));
			for (int c = 0; c < 3; c++) {
				halves[y >= PANORAMA_DOWN / 2][c] += (double)light[c];
				for (int i = 0; i < 9; i++)
					harmonics[c][i] += (double)(light[c] * basis.c[i]);
			}
		}
	}
}

/* True if the light with this blur is negative in one of many directions, evenly spread on a spiral: its irradiance, or
 * its radiance. */
static bool ambient_rings(const shade_sh_rgb *light, float blur, bool radiance)
{
	shade_sh_rgb windowed = shade_sh_rgb_window(*light, blur);
	for (int i = 0; i < AMBIENT_LOOKS; i++) {
		float y = 1.0f - (2.0f * (float)i + 1.0f) / AMBIENT_LOOKS, wide = sqrtf(1.0f - y * y);
		float angle = 2.3999632f * (float)i; /* the golden angle */
		stilb_vec3 n = stilb_vec3_make(wide * cosf(angle), y, wide * sinf(angle));
		stilb_vec3 seen = radiance ? shade_sh_rgb_evaluate(windowed, n) : shade_sh_rgb_irradiance(windowed, n);
		if (seen[0] < 0.0f || seen[1] < 0.0f || seen[2] < 0.0f)
			return true;
	}
	return false;
}

/* The least blur with which nothing is negative, to 1 / 256 of the largest one that is ever needed. */
static float ambient_blur(const shade_sh_rgb *light, bool radiance)
{
	if (!ambient_rings(light, 0.0f, radiance))
		return 0.0f;
	float few = 0.0f, enough = radiance ? SHADE_SH_WINDOW_RADIANCE : SHADE_SH_WINDOW_IRRADIANCE;
	for (int i = 0; i < AMBIENT_HALVINGS; i++) {
		float middle = 0.5f * (few + enough);
		if (ambient_rings(light, middle, radiance))
			few = middle;
		else
			enough = middle;
	}
	return enough;
}

void render_panorama_find_ambient(render_panorama_work *work)
{
	double halves[2][3] = {{0.0}}, harmonics[3][9] = {{0.0}};
	ambient_sum(work, halves, harmonics);
	render_panorama_around *around = &work->around;
	for (int c = 0; c < 3; c++) {
		around->sky[c] = (float)(halves[0][c] / (2.0 * M_PI));
		around->ground[c] = (float)(halves[1][c] / (2.0 * M_PI));
	}
	for (int i = 0; i < 9; i++) {
		around->harmonics.r.c[i] = (float)harmonics[0][i];
		around->harmonics.g.c[i] = (float)harmonics[1][i];
		around->harmonics.b.c[i] = (float)harmonics[2][i];
	}
	around->harmonics = shade_sh_rgb_window(around->harmonics, ambient_blur(&around->harmonics, false));
	float further = ambient_blur(&around->harmonics, true);
	for (int l = 0; l < 3; l++)
		around->mirrored[l] = expf(-(float)(l * (l + 1)) * further);
}

/* ---- a view ------------------------------------------------------------------------------------------------------ */

/* The harmonics of sky and ground: their mean, and along the world's +Y the integral of the height above the horizon,
 * pi, times their difference. Bands of even degree are the same above and below the horizon. */
static shade_sh_rgb ambient_of_halves(const float sky[3], const float ground[3])
{
	float mean[3], along[3];
	for (int c = 0; c < 3; c++) {
		mean[c] = 0.5f * (sky[c] + ground[c]);
		along[c] = -SHADE_SH_Y1 * SHADE_PI * (sky[c] - ground[c]);
	}
	shade_sh_rgb light = shade_sh_rgb_ambient(stilb_vec3_make(mean[0], mean[1], mean[2]));
	light.r.c[1] = along[0];
	light.g.c[1] = along[1];
	light.b.c[1] = along[2];
	return light;
}

/* What is left of their bands when radiance is nowhere negative: it is the mean -+ 3 / 4 of the difference, straight up
 * and down. */
static void ambient_mirrored_of_halves(const float sky[3], const float ground[3], float mirrored[3])
{
	mirrored[0] = mirrored[1] = mirrored[2] = 1.0f; /* there is no band 2 */
	for (int c = 0; c < 3; c++) {
		float mean = 0.5f * (sky[c] + ground[c]), most = 0.75f * fabsf(sky[c] - ground[c]);
		mirrored[1] = most > mean ? fminf(mirrored[1], mean / most) : mirrored[1];
	}
}

/* The panorama's harmonics in the world. */
static shade_sh_rgb ambient_turned(const render_panorama *panorama, float rotation)
{
	static const float axes[3][3] = {{1.0f, 0.0f, 0.0f}, {0.0f, 1.0f, 0.0f}, {0.0f, 0.0f, 1.0f}};
	stilb_vec3 turned[3];
	for (int i = 0; i < 3; i++) {
		float world[3];
		render_panorama_turn(axes[i], rotation, world);
		turned[i] = stilb_vec3_make(world[0], world[1], world[2]);
	}
	return shade_sh_rgb_rotate(panorama->around.harmonics, (shade_frame){turned[0], turned[1], turned[2]});
}

static void ambient_put_harmonics(const shade_sh_rgb *light, float out[9][4])
{
	for (int i = 0; i < 9; i++) {
		out[i][0] = light->r.c[i];
		out[i][1] = light->g.c[i];
		out[i][2] = light->b.c[i];
	}
}

void render_ambient_of(const stilb_render_view *view, const render_panorama *panorama, render_ambient *out)
{
	const stilb_scene_surroundings *around = &view->surroundings;
	bool exact = view->ambient == STILB_RENDER_AMBIENT_ENVIRONMENT; /* which needs sky and ground without a panorama */
	const float *sky = panorama && !exact ? panorama->around.sky : around->sky;
	const float *ground = panorama && !exact ? panorama->around.ground : around->ground;
	*out = (render_ambient){.sky = {0.0f}};
	if (view->ambient == STILB_RENDER_AMBIENT_NONE)
		return;
	for (int c = 0; c < 3; c++) {
		bool even = view->ambient == STILB_RENDER_AMBIENT_CONSTANT;
		out->sky[c] = even ? 0.5f * (sky[c] + ground[c]) : sky[c];
		out->ground[c] = even ? out->sky[c] : ground[c];
	}
	if (view->ambient != STILB_RENDER_AMBIENT_SH_VERTEX && view->ambient != STILB_RENDER_AMBIENT_SH_PIXEL)
		return;
	shade_sh_rgb light = panorama ? ambient_turned(panorama, around->rotation) : ambient_of_halves(sky, ground);
	ambient_put_harmonics(&light, out->harmonics);
	if (panorama)
		memcpy(out->mirrored, panorama->around.mirrored, sizeof panorama->around.mirrored);
	else
		ambient_mirrored_of_halves(sky, ground, out->mirrored);
}
