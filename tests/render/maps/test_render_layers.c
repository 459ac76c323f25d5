/* Clear coat, sheen, brushed metal and maps of specular in frames: each pixel of a square under one light is what the
 * formulas of shading/ say, put together here once more in C. */
#include "shading/shade_gltf.h"
#include "shading/shade_layers.h"
#include "shading/shade_surface.h"

#include "maps_stage.h" /* names a type as these name variables */

#define OFF 2e-3 /* a share of the largest: half floats, and a tangent of 16 bits */

static const stilb_scene_light light = {
	.kind = STILB_SCENE_LIGHT_DIRECTIONAL, .direction = {-0.48f, -0.8f, 0.36f}, .intensity = {3, 3, 3}};

static stilb_vec3 vector(const float v[3])
{
	return stilb_vec3_make(v[0], v[1], v[2]);
}

/* The codes of a kind's texture, the same all over. */
static const uint8_t texels[RENDER_MAPS][4] = {
	[STILB_SCENE_MAP_COLOR] = {230, 200, 180, 255},
	[STILB_SCENE_MAP_REFLECTION] = {0, 200, 130, 255},
	[STILB_SCENE_MAP_NORMAL] = {110, 150, 240, 255},
	[STILB_SCENE_MAP_OCCLUSION] = {255, 255, 255, 255},
	[STILB_SCENE_MAP_EMISSION] = {200, 100, 50, 255},
	[STILB_SCENE_MAP_CLEARCOAT] = {180, 10, 20, 30},
	[STILB_SCENE_MAP_CLEARCOAT_ROUGHNESS] = {10, 190, 20, 30},
	[STILB_SCENE_MAP_CLEARCOAT_NORMAL] = {150, 110, 245, 255},
	[STILB_SCENE_MAP_SPECULAR] = {10, 20, 30, 170},
	[STILB_SCENE_MAP_SPECULAR_COLOR] = {250, 120, 60, 10},
	[STILB_SCENE_MAP_SHEEN_COLOR] = {90, 180, 220, 10},
	[STILB_SCENE_MAP_SHEEN_ROUGHNESS] = {10, 20, 30, 160},
	[STILB_SCENE_MAP_ANISOTROPY] = {200, 60, 210, 10},
	[STILB_SCENE_MAP_TRANSMISSION] = {140, 10, 20, 30},
	[STILB_SCENE_MAP_THICKNESS] = {10, 150, 20, 30},
};

/* A texel's channel; 1 where the surface has no such map. */
static float texel(const stilb_scene_surface *s, stilb_scene_map_kind kind, int channel)
{
	return s->maps[kind].texture ? (float)texels[kind][channel] / 255.0f : 1.0f;
}

static stilb_vec3 texel3(const stilb_scene_surface *s, stilb_scene_map_kind kind)
{
	return stilb_vec3_make(texel(s, kind, 0), texel(s, kind, 1), texel(s, kind, 2));
}

/* The square's normal as a map turns it: tangent x, normal y, so bitangent -z. */
static stilb_vec3 turned(const stilb_scene_surface *s, stilb_scene_map_kind kind, float scale)
{
	if (!s->maps[kind].texture)
		return stilb_vec3_make(0.0f, 1.0f, 0.0f);
	stilb_vec3 local = shade_gltf_normal(texel3(s, kind), scale);
	return stilb_vec3_make(local[0], local[2], -local[1]);
}

/* What the surface sends to v. */
static stilb_vec3 expected(const stilb_scene_surface *s, shade_brdf_model model, stilb_vec3 v)
{
	stilb_vec3 n = turned(s, STILB_SCENE_MAP_NORMAL, s->normal_scale);
	shade_sun seen = {-vector(light.direction), vector(light.intensity)};
	stilb_vec3 dielectric =
		shade_gltf_dielectric(s->ior, vector(s->specular) * texel3(s, STILB_SCENE_MAP_SPECULAR_COLOR),
	                          s->specular_weight * texel(s, STILB_SCENE_MAP_SPECULAR, 3));
	shade_gltf_base base = shade_gltf_metallic(vector(s->color) * texel3(s, STILB_SCENE_MAP_COLOR),
	                                           s->metalness * texel(s, STILB_SCENE_MAP_REFLECTION, 2),
	                                           s->roughness * texel(s, STILB_SCENE_MAP_REFLECTION, 1), dielectric);
	shade_material material = {base.diffuse, base.specular, base.roughness, 0.0f, 0.0f};
	shade_frame frame = shade_frame_from_normal(n);
	if (s->anisotropy > 0.0f) {
		bool mapped = s->maps[STILB_SCENE_MAP_ANISOTROPY].texture;
		float x = mapped ? 2.0f * texel(s, STILB_SCENE_MAP_ANISOTROPY, 0) - 1.0f : 1.0f;
		float y = mapped ? 2.0f * texel(s, STILB_SCENE_MAP_ANISOTROPY, 1) - 1.0f : 0.0f;
		float angle = atan2f(y, x) + s->anisotropy_rotation;
		stilb_vec2 brushed =
			shade_gltf_brushed(base.roughness, s->anisotropy * texel(s, STILB_SCENE_MAP_ANISOTROPY, 2));
		frame = shade_frame_from_tangent(n, stilb_vec3_make(cosf(angle), 0.0f, -sinf(angle)));
		material.roughness = brushed[0];
		material.anisotropy = brushed[1];
		model.ndf = SHADE_NDF_GGX_ANISOTROPIC;
	}
	material.diffuse *= shade_brdf_diffuse_left(model, stilb_vec3_dot(n, v), base.roughness);
	material.diffuse *= 1.0f - s->transmission * texel(s, STILB_SCENE_MAP_TRANSMISSION, 0);
	stilb_vec3 sent = shade_surface_lit(model, material, frame, seen, false, stilb_vec3_make(0, 0, 0), v);
	stilb_vec3 sheen = vector(s->sheen_color) * texel3(s, STILB_SCENE_MAP_SHEEN_COLOR);
	float rough = s->sheen_roughness * texel(s, STILB_SCENE_MAP_SHEEN_ROUGHNESS, 3);
	if (sheen[0] > 0.0f)
		sent = sent * shade_sheen_left(sheen, stilb_vec3_dot(n, v), rough) +
		       sheen * seen.irradiance * shade_sheen_cos(rough, n, seen.direction, v);
	sent += vector(s->emission) * texel3(s, STILB_SCENE_MAP_EMISSION);
	stilb_vec3 coat_n = turned(s, STILB_SCENE_MAP_CLEARCOAT_NORMAL, s->clearcoat_normal_scale);
	float share = shade_coat_share(s->clearcoat * texel(s, STILB_SCENE_MAP_CLEARCOAT, 0), stilb_vec3_dot(coat_n, v));
	float coat_rough = s->clearcoat_roughness * texel(s, STILB_SCENE_MAP_CLEARCOAT_ROUGHNESS, 1);
	return sent * (1.0f - share) + seen.irradiance * (share * shade_coat_cos(coat_rough, coat_n, seen.direction, v));
}

/* One square with this surface: all pixels are what the formulas say, and vary. */
static void assert_lit(stage *s, square *q, const stilb_scene_surface *surface, const char *what)
{
	stilb_image images[RENDER_MAPS];
	for (int i = 0; i < (int)RENDER_MAPS; i++)
		images[i] = image_even(4, texels[i], STILB_IMAGE_U8_LINEAR);
	stage_show_square(s, q, surface, images, RENDER_MAPS);
	stilb_image picture = stage_picture(s);
	shade_brdf_model model = {SHADE_BRDF_MICROFACET, SHADE_NDF_GGX, SHADE_G_SMITH_GGX, SHADE_F_SCHLICK};
	double largest = 0.0, apart = 0.0;
	for (int pass = 0; pass < 2; pass++)
		for (uint32_t y = 0; y < picture.height; y++)
			for (uint32_t x = 0; x < picture.width; x++) {
				float px = 2.0f * ((float)x + 0.5f) / (float)picture.width - 1.0f;
				float pz = 2.0f * ((float)y + 0.5f) / (float)picture.height - 1.0f;
				stilb_vec3 v = stilb_vec3_make(-px, 4.0f, -pz) / sqrtf(16.0f + px * px + pz * pz);
				stilb_vec3 want = expected(surface, model, v);
				for (int c = 0; c < 3; c++) {
					double off = fabs(picture_value(&picture, x, y, c) - (double)want[c]);
					largest = fmax(largest, (double)want[c]);
					apart = fmax(apart, off);
					if (pass == 1 && !(off <= OFF * largest))
						fail_msg("%s: pixel %u, %u channel %d: %.6f, not %.6f", what, x, y, c,
						         picture_value(&picture, x, y, c), (double)want[c]);
				}
			}
	print_message("%-32s apart %.5f of %.3f\n", what, apart / largest, largest);
	stilb_image_finish(&picture);
	for (int i = 0; i < (int)RENDER_MAPS; i++)
		stilb_image_finish(&images[i]);
}

static stage lit_stage(void)
{
	stage s = stage_open((stilb_render_desc){0}, 0);
	reference_set3(s.view.surroundings.sky, 0.0f, 0.0f, 0.0f);
	s.view.shading.brdf = SHADE_BRDF_MICROFACET;
	s.view.shading.ndf = SHADE_NDF_GGX;
	s.view.shading.g = SHADE_G_SMITH_GGX;
	s.view.shading.f = SHADE_F_SCHLICK;
	s.view.lights = &light;
	s.view.light_count = 1;
	return s;
}

static stilb_scene_surface plain(void)
{
	stilb_scene_surface surface = stilb_scene_surface_make();
	reference_set3(surface.color, 0.3f, 0.2f, 0.1f);
	surface.roughness = 0.6f;
	return surface;
}

static void map(stilb_scene_surface *surface, stilb_scene_map_kind kind)
{
	surface->maps[kind].texture = 1 + (uint32_t)kind;
}

static void maps_of_specular(void **state)
{
	(void)state;
	stage s = lit_stage();
	square q;
	square_make(&q, 1.0f);
	stilb_scene_surface surface = plain();
	surface.ior = 2.0f;
	surface.specular_weight = 0.9f;
	reference_set3(surface.specular, 1.0f, 5.0f, 20.0f); /* what is above 1 is cut after the map, before the weight */
	map(&surface, STILB_SCENE_MAP_SPECULAR_COLOR);
	assert_lit(&s, &q, &surface, "specular colour");
	map(&surface, STILB_SCENE_MAP_SPECULAR);
	assert_lit(&s, &q, &surface, "specular colour and weight");
	stage_close(&s);
}

static void brushed_metal(void **state)
{
	(void)state;
	stage s = lit_stage();
	square q;
	square_make(&q, 1.0f);
	stilb_scene_surface surface = plain();
	surface.metalness = 1.0f;
	surface.anisotropy = 0.8f;
	assert_lit(&s, &q, &surface, "brushed");
	surface.anisotropy_rotation = 0.7f;
	assert_lit(&s, &q, &surface, "brushed, turned");
	map(&surface, STILB_SCENE_MAP_ANISOTROPY);
	assert_lit(&s, &q, &surface, "brushed by a map");
	map(&surface, STILB_SCENE_MAP_NORMAL);
	assert_lit(&s, &q, &surface, "brushed, with normals");
	stage_close(&s);
}

static void clear_coat(void **state)
{
	(void)state;
	stage s = lit_stage();
	square q;
	square_make(&q, 1.0f);
	stilb_scene_surface surface = plain();
	surface.clearcoat = 0.9f;
	surface.clearcoat_roughness = 0.5f;
	reference_set3(surface.emission, 0.2f, 0.3f, 0.4f);
	assert_lit(&s, &q, &surface, "coat");
	map(&surface, STILB_SCENE_MAP_CLEARCOAT);
	map(&surface, STILB_SCENE_MAP_CLEARCOAT_ROUGHNESS);
	assert_lit(&s, &q, &surface, "coat by maps");
	map(&surface, STILB_SCENE_MAP_NORMAL);
	assert_lit(&s, &q, &surface, "even coat on bumps");
	map(&surface, STILB_SCENE_MAP_CLEARCOAT_NORMAL);
	surface.clearcoat_normal_scale = 0.5f;
	assert_lit(&s, &q, &surface, "coat with its own bumps");
	stage_close(&s);
}

static void sheen(void **state)
{
	(void)state;
	stage s = lit_stage();
	square q;
	square_make(&q, 1.0f);
	stilb_scene_surface surface = plain();
	reference_set3(surface.sheen_color, 0.9f, 0.5f, 0.2f);
	surface.sheen_roughness = 0.7f;
	assert_lit(&s, &q, &surface, "sheen");
	map(&surface, STILB_SCENE_MAP_SHEEN_COLOR);
	map(&surface, STILB_SCENE_MAP_SHEEN_ROUGHNESS);
	assert_lit(&s, &q, &surface, "sheen by maps");
	stage_close(&s);
}

/* All at once, with every map, also if these lie in different ways. */
static void layers_on_one_another(void **state)
{
	(void)state;
	stage s = lit_stage();
	square q;
	square_make(&q, 1.0f);
	stilb_scene_surface surface = plain();
	surface.metalness = 0.5f;
	surface.clearcoat = surface.clearcoat_roughness = surface.anisotropy = 0.8f;
	reference_set3(surface.sheen_color, 0.5f, 0.5f, 0.2f);
	surface.sheen_roughness = 0.8f;
	reference_set3(surface.emission, 0.1f, 0.1f, 0.1f);
	for (int i = 0; i < STILB_SCENE_MAP_TRANSMISSION; i++)
		map(&surface, (stilb_scene_map_kind)i);
	assert_lit(&s, &q, &surface, "all layers");
	for (int i = 0; i < STILB_SCENE_MAP_TRANSMISSION; i++)
		surface.maps[i].set = i % 2;
	assert_lit(&s, &q, &surface, "all layers on both uv");
	stage_close(&s);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(maps_of_specular),
		cmocka_unit_test(brushed_metal),
		cmocka_unit_test(clear_coat),
		cmocka_unit_test(sheen),
		cmocka_unit_test(layers_on_one_another),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
