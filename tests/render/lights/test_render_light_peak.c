/* stilb_render_light_peak: the brightest that materials can be, and what makes one count as a mirror. And what frames
 * that show lights or errors say in numbers. */
#include "render/render.h"
#include "shading/shade_brdf.h"
#include "support/test.h"

#include <math.h>

/* A scene of two materials, of which the second has a surface. */
typedef struct looks {
	stilb_scene scene;
	stilb_scene_material materials[2];
	stilb_scene_surface surface;
	stilb_render_shading shading;
} looks;

static void looks_make(looks *l)
{
	*l = (looks){.shading = stilb_render_shading_default(), .surface = stilb_scene_surface_make()};
	l->materials[0] = (stilb_scene_material){
		.diffuse = {0.1f, 0.6f, 0.2f}, .specular = {0.3f, 0.1f, 0.2f}, .roughness = 0.8f, .anisotropy = -0.5f};
	l->materials[1] = (stilb_scene_material){.diffuse = {0.5f, 0.5f, 0.5f}, .roughness = 0.6f, .anisotropy = 0.2f};
	l->surface.roughness = 0.7f;
	l->scene.materials = l->materials;
	l->scene.material_count = 2;
	l->scene.surfaces = &l->surface;
	l->scene.surface_count = 1;
}

static void assert_peak(const looks *l, double want)
{
	double got = (double)stilb_render_light_peak(&l->scene, &l->shading);
	if (!(fabs(got - want) <= 1e-5 * want))
		fail_msg("the peak is %g in place of %g", got, want);
}

static double highlight(const looks *l, float roughness, float anisotropy)
{
	const stilb_render_shading *s = &l->shading;
	shade_brdf_model model = {(int)s->brdf, (int)s->ndf, (int)s->g, (int)s->f};
	return (double)shade_brdf_peak(model, roughness, anisotropy);
}

static void extremes_of_all_materials(void **state)
{
	(void)state;
	looks l;
	looks_make(&l);
	assert_peak(&l, 0.6 / M_PI + 0.3 * highlight(&l, 0.6f, 0.5f));
	l.shading.specular = 0.2f;
	l.shading.roughness = -0.1f;
	assert_peak(&l, 0.6 / M_PI + 0.5 * highlight(&l, 0.5f, 0.5f));
	l.shading = (stilb_render_shading){.brdf = SHADE_BRDF_MICROFACET,
	                                   .ndf = SHADE_NDF_GGX_ANISOTROPIC,
	                                   .g = SHADE_G_SMITH_GGX,
	                                   .f = SHADE_F_SCHLICK,
	                                   .anisotropy = -0.1f};
	assert_peak(&l, 0.6 / M_PI + highlight(&l, 0.6f, 0.6f)); /* Fresnel's term: flat, all is a mirror */
	l.shading.f = SHADE_F_NONE;
	assert_peak(&l, 0.6 / M_PI + 0.3 * highlight(&l, 0.6f, 0.6f));
	l.shading.brdf = SHADE_BRDF_LAMBERT;
	assert_peak(&l, 1.0 / M_PI); /* no less */
}

static void surfaces_and_layers(void **state)
{
	(void)state;
	looks l;
	looks_make(&l);
	l.shading = (stilb_render_shading){
		.brdf = SHADE_BRDF_MICROFACET, .ndf = SHADE_NDF_GGX, .g = SHADE_G_SMITH_GGX, .f = SHADE_F_SCHLICK};
	l.materials[1].surface = 1;
	double base = 1.0 / M_PI + highlight(&l, 0.6f, 0.0f); /* maps may be white */
	assert_peak(&l, base);
	l.surface.clearcoat = 0.5f;
	l.surface.clearcoat_roughness = 0.3f;
	assert_peak(&l, base + 0.5 * highlight(&l, 0.3f, 0.0f));
	l.surface.maps[STILB_SCENE_MAP_CLEARCOAT_ROUGHNESS].texture = 1;
	assert_peak(&l, base + 0.5 * highlight(&l, 0.0f, 0.0f));
	l.surface.clearcoat = 0.0f;
	l.surface.sheen_color[1] = 0.4f;
	l.surface.sheen_roughness = 0.5f;
	assert_peak(&l, base + 0.4 * (2.0 + 4.0) / (8.0 * M_PI));
	l.surface.sheen_color[1] = 0.0f;
	l.surface.transmission = 0.3f;
	assert_peak(&l, base + 0.3 * highlight(&l, 0.6f, 0.0f));
	l.surface.transmission = 0.0f;
	l.surface.maps[STILB_SCENE_MAP_REFLECTION].texture = 1;
	assert_peak(&l, 1.0 / M_PI + highlight(&l, 0.0f, 0.0f));
	l.surface.maps[STILB_SCENE_MAP_REFLECTION].texture = 0;
	l.surface.function = 1;
	assert_peak(&l, 1.0 / M_PI + highlight(&l, 0.0f, 0.0f));
}

static void counted_lights_are_cut_where_halves_end(void **state)
{
	(void)state;
	static const uint16_t texels[4][4] = {{0x4000, 0x3c00}, {0x7bff, 0x3c00}, {0x7c00, 0x3c00}, {0, 0}};
	stilb_render_light_counts counts = stilb_render_count_lights(texels, 4);
	assert_true(counts.pixels == 4 && counts.shown == 3 && counts.cut == 2);
	assert_true(counts.lights == 2.0 + 2 * 65504.0 && counts.shadings == 3.0);
}

static void errors_are_measured_as_shown(void **state)
{
	(void)state;
	static const uint16_t texels[2][4] = {{0x3c00, 0, 0}, {0, 0, 0}}; /* 1 and nothing */
	stilb_render_error error = stilb_render_measure_error(texels, 2, -2.0f);
	assert_true(error.pixels == 2 && error.most == 0.25 && error.share == 0.5);
	assert_true(fabs(error.rms - 0.25 / sqrt(6.0)) < 1e-12);
	assert_true(stilb_render_measure_error(texels, 1, -8.0f).share == 0.0); /* 1/256 is less than a step */
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(extremes_of_all_materials), cmocka_unit_test(surfaces_and_layers),
		cmocka_unit_test(counted_lights_are_cut_where_halves_end), cmocka_unit_test(errors_are_measured_as_shown)};
	return cmocka_run_group_tests_name("render_light_peak", tests, NULL, NULL);
}
