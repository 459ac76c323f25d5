/* What lights in place of the surroundings (stilb_render_ambient): each kind is its own definition, computed here in
 * double: a frame is emitted light + the lights + the surroundings' light x diffuse reflectance + what highlights
 * mirror of them. Triangles whose corners have different normals fill the picture, seen in parallel, so that each
 * pixel's place in its triangle is known. Under sky and ground, and under panoramas, turned. Under the validation
 * layer. */
#include "geometry/geometry_impostor.h"
#include "numeric/numeric_sh.h"
#include "shading/shade_energy.h"
#include "shading/shade_surface.h"
#include "support/shade_proof.h"

#include "render/lights/lights_surfaces.h" /* names a type as these name variables */

#define TILE 16u
#define TILES 6u /* of a side */
#define SIDE (TILE * TILES)
#define CORNERS (TILES * TILES * 3)

/* What a value may be off by: 2^-10 of itself, since devices may cut half floats; and of the picture's largest value
 * what floats and the driver's exp2 and log2 round off. Where harmonics are blurred, also what 1 / 256 of the blur's
 * range, and looking for negative light in 2,048 directions alone, make of band 2. A panorama of texels has 5e-4 less
 * of band 2 than the function that the texels are of. */
#define OFF_HALF 0x1p-10
#define OFF_FLOAT 3e-4
#define OFF_BLUR 4e-3
#define OFF_TEXELS 5e-4

static const char *const *const names = stilb_render_ambient_names;

/* ---- the scene --------------------------------------------------------------------------------------------------- */

static const stilb_scene_material materials[] = {
	{.diffuse = {0.7f, 0.4f, 0.2f}, .roughness = 1.0f, .emission = {0.02f, 0.05f, 0.03f}},
	{.specular = {0.9f, 0.7f, 0.4f}, .roughness = 0.3f}, /* metal: its diffuse reflectance is black */
	{.diffuse = {0.2f, 0.3f, 0.5f}, .specular = {0.4f, 0.3f, 0.2f}, .roughness = 0.8f},
};
#define MATERIALS (sizeof materials / sizeof *materials)

static const stilb_scene_light sun = {
	.kind = STILB_SCENE_LIGHT_DIRECTIONAL, .direction = {0.48f, -0.8f, 0.36f}, .intensity = {0.4f, 0.5f, 0.3f}};

/* Seen from above: x to the right and z down, in [-1, 1]. */
static const stilb_mat4 from_above = {{1, 0, 0, 0, 0, 0, 0.05f, 0, 0, 1, 0, 0, 0, 0, 0.5f, 1}};

static stilb_vec3 normals[CORNERS];
static bool seen_from_behind; /* they emit nothing there */
static bool sun_shines = true;

/* Normals in all directions, or within `spread` of one; those of a triangle are within a radian or so. */
static void make_normals(bool up)
{
	shade_proof_random random = {.seed = 5};
	for (uint32_t t = 0; t < TILES * TILES; t++) {
		stilb_vec3 middle = shade_proof_random_direction(&random);
		if (up)
			middle = stilb_vec3_normalize(middle * 0.5f + stilb_vec3_make(0.0f, 1.0f, 0.0f));
		for (uint32_t k = 0; k < 3; k++)
			normals[3 * t + k] = stilb_vec3_normalize(middle + 0.5f * shade_proof_random_direction(&random));
	}
}

/* Triangles below the diagonals of tiles; row r of tiles has material r % MATERIALS. behind: they are seen from
 * behind, and have the normals of that side. */
static void show_triangles(stage *s, bool behind)
{
	seen_from_behind = behind;
	static stilb_scene_vertex vertices[CORNERS];
	static uint32_t indices[MATERIALS][CORNERS];
	static const float corners[3][2] = {{0, 0}, {0, 1}, {1, 1}};
	uint32_t counts[MATERIALS] = {0};
	for (uint32_t i = 0; i < CORNERS; i++) {
		uint32_t tile = i / 3, row = tile / TILES, column = tile % TILES, m = row % MATERIALS;
		float x = 2.0f * ((float)column + corners[i % 3][0]) / TILES - 1.0f;
		float z = 2.0f * ((float)row + corners[i % 3][1]) / TILES - 1.0f;
		stilb_vec3 n = behind ? -normals[i] : normals[i];
		vertices[i] = (stilb_scene_vertex){.position = {x, 0.0f, z}, .normal = {n[0], n[1], n[2]}};
		uint32_t turned = behind && i % 3 > 0 ? 3 * tile + 3 - i % 3 : i;
		indices[m][counts[m]++] = turned;
	}
	stilb_scene_build *build = stilb_scene_build_begin();
	for (uint32_t m = 0; m < MATERIALS; m++) {
		stilb_scene_mesh mesh = {
			.vertices = vertices, .indices = indices[m], .vertex_count = CORNERS, .index_count = counts[m]};
		stage_model(build, stilb_scene_build_mesh(build, &mesh), stilb_scene_build_material(build, &materials[m]),
		            stilb_mat4_identity());
	}
	stage_show(s, build);
}

static stage open_stage(void)
{
	stage s = stage_open((stilb_render_desc){.width = SIDE, .float_vertices = true}, 1);
	s.view.view_projection = from_above;
	s.view.lights = &sun;
	s.view.light_count = 1;
	s.view.shading = stilb_render_shading_default();
	return s;
}

/* ---- surroundings ------------------------------------------------------------------------------------------------ */

/* What they are, and what the definitions take of them. */
typedef struct around {
	const char *name;
	stilb_scene_surroundings given;
	double sky[3], ground[3]; /* means of the halves */
	double harmonics[3][9];   /* in the panorama's own axes, windowed */
	double blur;              /* by which */
	double mirrored[3];       /* what highlights have of each band at most */
	double off;
} around;

static const double bands[9] = {0, 1, 1, 1, 2, 2, 2, 2, 2};

/* The harmonics' sum with a weight of each band, in own axes. */
static double sum_of(const double harmonics[9], const double weights[3], const double d[3])
{
	shade_sh basis = shade_sh_basis(stilb_vec3_make((float)d[0], (float)d[1], (float)d[2]));
	double sum = 0.0;
	for (int i = 0; i < 9; i++)
		sum += harmonics[i] * weights[(int)bands[i]] * (double)basis.c[i];
	return sum;
}

static const double cosine_bands[3] = {M_PI, 2.0 * M_PI / 3.0, M_PI / 4.0};

static const double all_bands[3] = {1.0, 1.0, 1.0};

/* True if the light's irradiance, or with all_bands its radiance, is negative somewhere with that blur. */
static bool is_negative(const around *a, const double of[3], double blur)
{
	double weights[3];
	for (int l = 0; l < 3; l++)
		weights[l] = of[l] * exp(-l * (l + 1) * blur);
	for (int i = 0; i < 20000; i++) {
		double y = 1.0 - (2.0 * i + 1.0) / 20000.0, wide = sqrt(1.0 - y * y), angle = 2.39996322972865 * i;
		const double d[3] = {wide * cos(angle), y, wide * sin(angle)};
		for (int c = 0; c < 3; c++)
			if (sum_of(a->harmonics[c], weights, d) < 0.0)
				return true;
	}
	return false;
}

static double least_blur(const around *a, const double of[3])
{
	double few = 0.0, enough = 0.4;
	if (!is_negative(a, of, 0.0))
		return 0.0;
	for (int i = 0; i < 16; i++) {
		double middle = 0.5 * (few + enough);
		*(is_negative(a, of, middle) ? &few : &enough) = middle;
	}
	return enough;
}

/* Finds the least blurs, and blurs. */
static void find_window(around *a)
{
	a->blur = least_blur(a, cosine_bands);
	for (int l = 0; l < 3; l++)
		a->mirrored[l] = exp(-l * (l + 1) * (least_blur(a, all_bands) - a->blur));
	for (int c = 0; c < 3; c++)
		for (int i = 0; i < 9; i++)
			a->harmonics[c][i] *= exp(-bands[i] * (bands[i] + 1.0) * a->blur);
}

static around sky_and_ground(void)
{
	around a = {.name = "sky and ground", .off = OFF_FLOAT};
	a.given = (stilb_scene_surroundings){.sky = {0.6f, 0.8f, 1.2f}, .ground = {0.4f, 0.3f, 0.02f}};
	for (int c = 0; c < 3; c++) {
		a.sky[c] = (double)a.given.sky[c];
		a.ground[c] = (double)a.given.ground[c];
		a.harmonics[c][0] = (a.sky[c] + a.ground[c]) * sqrt(M_PI); /* mean times the root of 4 pi */
		a.harmonics[c][1] = -sqrt(3.0 / (4.0 * M_PI)) * M_PI * (a.sky[c] - a.ground[c]);
	}
	find_window(&a);
	assert_true(a.blur == 0.0 && a.mirrored[1] < 0.8); /* the dark ground would be negative */
	return a;
}

/* A panorama of the function, its halves' means, and that it is turned. */
static around panorama_of(const char *name, void (*radiance)(const double d[3], double out[3]))
{
	enum { WIDE = 256, HIGH = 128 };
	around a = {.name = name};
	a.given.rotation = 0.7f;
	assert_int_equal(stilb_image_create(&a.given.panorama, WIDE, HIGH, 3, STILB_IMAGE_F32_LINEAR), STILB_OK);
	float *texel = a.given.panorama.pixels;
	for (int y = 0; y < HIGH; y++)
		for (int x = 0; x < WIDE; x++, texel += 3) {
			double d[3], value[3], share = cos(M_PI * y / HIGH) - cos(M_PI * (y + 1) / HIGH);
			stilb_numeric_latlong_direction((x + 0.5) / WIDE, (y + 0.5) / HIGH, d);
			radiance(d, value);
			for (int c = 0; c < 3; c++) {
				texel[c] = (float)value[c];
				*(y < HIGH / 2 ? &a.sky[c] : &a.ground[c]) += value[c] * share / WIDE;
			}
		}
	return a;
}

/* A function of three bands. */
static const double known[3][9] = {{3.0, -0.5, 0.4, 0.3, 0.3, -0.2, 0.25, 0.2, 0.1},
                                   {2.0, -0.6, -0.2, 0.2, -0.2, 0.1, 0.1, -0.1, 0.2},
                                   {1.5, -0.3, 0.1, -0.2, 0.1, 0.1, -0.2, 0.1, -0.1}};

static void smooth_radiance(const double d[3], double out[3])
{
	for (int c = 0; c < 3; c++) {
		out[c] = sum_of(known[c], all_bands, d);
		assert_true(out[c] > 0.0);
	}
}

/* A window of 50 degrees and a smaller one below the horizon, no lamps, in the dark. */
static void narrow_radiance(const double d[3], double out[3])
{
	bool window = d[0] * 0.6 + d[1] * 0.64 - d[2] * 0.48 > cos(25.0 * M_PI / 180.0);
	bool small = -d[0] * 0.8 - d[1] * 0.6 > cos(6.0 * M_PI / 180.0);
	out[0] = window ? 6.0 : small ? 6.0 : 0.01;
	out[1] = window ? 5.0 : small ? 4.0 : 0.01;
	out[2] = window ? 7.0 : small ? 2.0 : 0.01;
}

static around smooth(void)
{
	around a = panorama_of("a smooth panorama", smooth_radiance);
	memcpy(a.harmonics, known, sizeof known);
	find_window(&a);
	assert_true(a.blur == 0.0 && a.mirrored[1] == 1.0);
	a.off = OFF_FLOAT + OFF_TEXELS;
	return a;
}

static around narrow(void)
{
	around a = panorama_of("a narrow light", narrow_radiance);
	shade_sh_rgb light;
	assert_int_equal(stilb_numeric_sh_project_map(&a.given.panorama, &light), STILB_OK);
	for (int i = 0; i < 9; i++) {
		a.harmonics[0][i] = (double)light.r.c[i];
		a.harmonics[1][i] = (double)light.g.c[i];
		a.harmonics[2][i] = (double)light.b.c[i];
	}
	find_window(&a);
	assert_true(a.blur > 0.02);
	a.off = OFF_FLOAT + OFF_BLUR;
	return a;
}

/* ---- what pixels are --------------------------------------------------------------------------------------------- */

static void own_axes(const around *a, stilb_vec3 d, double own[3])
{
	double s = sin((double)a->given.rotation), c = cos((double)a->given.rotation);
	own[0] = c * (double)d[0] - s * (double)d[2];
	own[1] = (double)d[1];
	own[2] = s * (double)d[0] + c * (double)d[2];
}

/* Irradiance that the kind gives to a unit normal. */
static double irradiance_of(const around *a, stilb_render_ambient kind, int c, stilb_vec3 n)
{
	double own[3], up = 0.5 + 0.5 * (double)n[1];
	own_axes(a, n, own);
	switch (kind) {
	case STILB_RENDER_AMBIENT_NONE:
		return 0.0;
	case STILB_RENDER_AMBIENT_CONSTANT:
		return M_PI * 0.5 * (a->sky[c] + a->ground[c]);
	case STILB_RENDER_AMBIENT_HEMISPHERE:
		return M_PI * (a->ground[c] + (a->sky[c] - a->ground[c]) * up);
	default:
		return sum_of(a->harmonics[c], cosine_bands, own);
	}
}

/* Radiance that a lobe of that exponent about a unit direction has. */
static double mirrored_of(const around *a, stilb_render_ambient kind, int c, stilb_vec3 toward, double exponent)
{
	double own[3];
	own_axes(a, toward, own);
	double share = (double)shade_hemisphere_share(toward[1], (float)exponent);
	const double lobe[3] = {1.0, fmin((exponent + 1.0) / (exponent + 2.0), a->mirrored[1]),
	                        fmin(exponent / (exponent + 3.0), a->mirrored[2])};
	switch (kind) {
	case STILB_RENDER_AMBIENT_NONE:
		return 0.0;
	case STILB_RENDER_AMBIENT_CONSTANT:
		return 0.5 * (a->sky[c] + a->ground[c]);
	case STILB_RENDER_AMBIENT_HEMISPHERE:
		return a->ground[c] + (a->sky[c] - a->ground[c]) * share;
	default:
		return fmax(sum_of(a->harmonics[c], lobe, own), 0.0);
	}
}

/* The radiance of the pixel's middle; false: no triangle is there, or it is at an edge. */
static bool expected(const around *a, stilb_render_ambient kind, uint32_t x, uint32_t y, double out[3])
{
	uint32_t tile = y / TILE * TILES + x / TILE;
	const stilb_scene_material *m = &materials[y / TILE % MATERIALS];
	float u = ((float)(x % TILE) + 0.5f) / TILE, v = ((float)(y % TILE) + 0.5f) / TILE;
	const float weights[3] = {1.0f - v, v - u, u};
	if (v - u < 1.0f / TILE)
		return false;
	const stilb_vec3 *corners = &normals[3 * tile];
	stilb_vec3 n = stilb_vec3_normalize(corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2]);
	stilb_vec3 place =
		stilb_vec3_make(((float)x + 0.5f) / SIDE * 2.0f - 1.0f, 0.0f, ((float)y + 0.5f) / SIDE * 2.0f - 1.0f);
	stilb_vec3 to_camera = stilb_vec3_normalize(stilb_vec3_make(0.0f, 4.0f, 0.0f) - place);
	stilb_vec3 mirrored = n * (2.0f * stilb_vec3_dot(n, to_camera)) - to_camera;
	double alpha = (double)m->roughness * (double)m->roughness, exponent = 0.25 * (2.0 / (alpha * alpha) - 2.0);
	shade_material material = {.diffuse = stilb_vec3_make(m->diffuse[0], m->diffuse[1], m->diffuse[2]),
	                           .specular = stilb_vec3_make(m->specular[0], m->specular[1], m->specular[2]),
	                           .roughness = m->roughness};
	shade_light light = {.kind = SHADE_LIGHT_DIRECTIONAL,
	                     .direction = stilb_vec3_make(sun.direction[0], sun.direction[1], sun.direction[2]),
	                     .intensity = stilb_vec3_make(sun.intensity[0], sun.intensity[1], sun.intensity[2])};
	shade_frame frame = shade_frame_from_tangent(n, stilb_vec3_make(n[2], 0.0f, -n[0]));
	stilb_vec3 lit = shade_surface_light((shade_brdf_model){.kind = SHADE_BRDF_BLINN_PHONG_MODIFIED}, material, frame,
	                                     light, place, to_camera);
	for (int c = 0; c < 3; c++) {
		double irradiance = 0.0;
		if (kind == STILB_RENDER_AMBIENT_SH_VERTEX)
			for (int k = 0; k < 3; k++)
				irradiance += (double)weights[k] * irradiance_of(a, kind, c, corners[k]);
		else
			irradiance = irradiance_of(a, kind, c, n);
		out[c] = (seen_from_behind ? 0.0 : (double)m->emission[c]) + (sun_shines ? (double)lit[c] : 0.0) +
		         (double)m->diffuse[c] / M_PI * fmax(irradiance, 0.0) +
		         (double)m->specular[c] * mirrored_of(a, kind, c, mirrored, exponent);
	}
	return true;
}

/* How far a picture is from the kind's definition, as a multiple of the bound, and where. */
static void assert_is_defined(const around *a, stilb_render_ambient kind, const stilb_image *image, const char *how)
{
	double most = 0.0, worst = 0.0, value[3];
	uint32_t seen = 0, at[2] = {0};
	for (uint32_t i = 0; i < SIDE * SIDE; i++)
		if (expected(a, kind, i % SIDE, i / SIDE, value))
			most = fmax(most, fmax(value[0], fmax(value[1], value[2])));
	for (uint32_t y = 0; y < SIDE; y++)
		for (uint32_t x = 0; x < SIDE; x++) {
			if (!expected(a, kind, x, y, value))
				continue;
			seen++;
			for (int c = 0; c < 3; c++) {
				double off = fabs(picture_value(image, x, y, c) - value[c]);
				double share = off / (OFF_HALF * value[c] + a->off * most);
				if (share > worst) {
					worst = share;
					at[0] = x;
					at[1] = y;
				}
			}
		}
	printf("%-20s %-12s %-8s %.2f of the bound\n", a->name, names[kind], how, worst);
	assert_true(seen > SIDE * SIDE / 3);
	if (!(worst <= 1.0))
		fail_msg("%s, %s, %s: pixel %u, %u is off by %.2f times the bound", a->name, names[kind], how, at[0], at[1],
		         worst);
}

/* ---- tests ------------------------------------------------------------------------------------------------------- */

static void show_around(stage *s, const around *a, stilb_render_ambient kind)
{
	s->view.surroundings = a->given;
	s->view.ambient = kind;
}

/* behind: triangles are seen from behind, which the view shows. */
static void assert_kinds(stage *s, bool behind)
{
	around arounds[] = {sky_and_ground(), smooth(), narrow()};
	s->view.both_sides = behind;
	make_normals(behind); /* those that face away would be bent to the viewer */
	show_triangles(s, behind);
	for (size_t i = 0; i < sizeof arounds / sizeof *arounds; i++) {
		for (int kind = STILB_RENDER_AMBIENT_NONE; kind < STILB_RENDER_AMBIENT_KINDS; kind++) {
			show_around(s, &arounds[i], (stilb_render_ambient)kind);
			stilb_image image = stage_picture(s);
			assert_is_defined(&arounds[i], (stilb_render_ambient)kind, &image, behind ? "behind" : "before");
			stilb_image_finish(&image);
		}
		stilb_image_finish(&arounds[i].given.panorama);
	}
}

static void each_kind_is_its_definition(void **state)
{
	(void)state;
	stage s = open_stage();
	assert_kinds(&s, false);
	stage_close(&s);
}

/* Deferred lighting leaves lights to later passes, and not this; without the lights, which it rounds. */
static void deferred_lighting_has_each_kind(void **state)
{
	(void)state;
	stage s = open_stage();
	sun_shines = false;
	s.view.light_count = 0;
	s.view.lighting = STILB_RENDER_LIGHTING_DEFERRED;
	assert_kinds(&s, false);
	sun_shines = true;
	stage_close(&s);
}

static void from_behind_it_is_that_of_the_other_side(void **state)
{
	(void)state;
	stage s = open_stage();
	assert_kinds(&s, true);
	stage_close(&s);
}

static void assert_same_pictures(const char *what, const stilb_image *a, const stilb_image *b)
{
	assert_int_equal(stilb_image_size(a), stilb_image_size(b));
	if (memcmp(a->pixels, b->pixels, stilb_image_size(a)) != 0)
		fail_msg("%s: pictures differ", what);
}

/* Of sky and ground that are mirrored, environment is hemisphere; without, nothing is mirrored. */
static void hemisphere_is_what_a_glossy_environment_is(void **state)
{
	(void)state;
	stage s = open_stage();
	around a = sky_and_ground();
	make_normals(false);
	show_triangles(&s, false);
	show_around(&s, &a, STILB_RENDER_AMBIENT_HEMISPHERE);
	stilb_image hemisphere = stage_picture(&s);
	a.given.glossy = true;
	show_around(&s, &a, STILB_RENDER_AMBIENT_ENVIRONMENT);
	stilb_image glossy = stage_picture(&s);
	assert_same_pictures("hemisphere", &hemisphere, &glossy);
	a.given.glossy = false;
	show_around(&s, &a, STILB_RENDER_AMBIENT_ENVIRONMENT);
	stilb_image even = stage_picture(&s);
	assert_true(memcmp(glossy.pixels, even.pixels, stilb_image_size(&even)) != 0);
	stilb_image_finish(&hemisphere);
	stilb_image_finish(&glossy);
	stilb_image_finish(&even);
	stage_close(&s);
}

/* Schueler's armour: metal whose diffuse reflectance is black. Where it faces up it mirrors the sky, where it mirrors
 * what is below it the ground, each in the metal's colour. */
static void black_metal_mirrors_sky_and_ground(void **state)
{
	(void)state;
	stage s = open_stage();
	around a = sky_and_ground();
	const stilb_scene_material *metal = &materials[1];
	s.view.light_count = 0;
	for (int below = 0; below < 2; below++) {
		for (uint32_t i = 0; i < CORNERS; i++) /* turned by 60 degrees the viewer's direction is mirrored down */
			normals[i] = below ? stilb_vec3_make(0.8660254f, 0.5f, 0.0f) : stilb_vec3_make(0.0f, 1.0f, 0.0f);
		show_triangles(&s, false);
		show_around(&s, &a, STILB_RENDER_AMBIENT_HEMISPHERE);
		stilb_image image = stage_picture(&s);
		uint32_t x = SIDE / 2 + TILE / 4,
				 y = TILE + TILE / 2 + TILE / 4; /* the second row of tiles, left of the diagonal */
		const double *wanted = below ? a.ground : a.sky;
		for (int c = 0; c < 3; c++) /* half of a lobe 25 degrees wide is 30 degrees from the horizon */
			assert_near("metal", picture_value(&image, x, y, c), (double)metal->specular[c] * wanted[c], 0.02);
		stilb_image_finish(&image);
	}
	stage_close(&s);
}

/* A panorama that is dark where its sun may be, with it or without: a texel. */
static bool sun_is_up;

static void sunny_radiance(const double d[3], double out[3])
{
	double middle[3];
	stilb_numeric_latlong_direction(160.5 / 256.0, 40.5 / 128.0, middle);
	double cosine = d[0] * middle[0] + d[1] * middle[1] + d[2] * middle[2];
	bool near = cosine > cos(6.0 * M_PI / 180.0), within = cosine > cos(0.5 * M_PI / 180.0);
	for (int c = 0; c < 3; c++)
		out[c] = near ? 0.0 : sum_of(known[c], all_bands, d);
	for (int c = 0; c < 3 && within && sun_is_up; c++)
		out[c] = 5000.0 - 1000.0 * c;
}

/* A panorama's lamps add the same light whatever the rest is taken for, but for NONE, where they add nothing. */
static void lamps_are_lights_besides(void **state)
{
	(void)state;
	stage s = open_stage();
	stilb_image pictures[2][STILB_RENDER_AMBIENT_KINDS];
	s.view.shading.brdf = SHADE_BRDF_LAMBERT;
	make_normals(false);
	show_triangles(&s, false);
	for (int up = 0; up < 2; up++) {
		sun_is_up = up;
		around a = panorama_of("a sun", sunny_radiance);
		for (int kind = 0; kind < STILB_RENDER_AMBIENT_KINDS; kind++) {
			show_around(&s, &a, (stilb_render_ambient)kind);
			pictures[up][kind] = stage_picture(&s);
		}
		stilb_image_finish(&a.given.panorama);
	}
	double most = 0.0;
	for (uint32_t i = 0; i < SIDE * SIDE * 3; i++) {
		double added[STILB_RENDER_AMBIENT_KINDS], largest = 0.0;
		for (int kind = 0; kind < STILB_RENDER_AMBIENT_KINDS; kind++) {
			double with = picture_value(&pictures[1][kind], i / 3 % SIDE, i / 3 / SIDE, (int)(i % 3));
			added[kind] = with - picture_value(&pictures[0][kind], i / 3 % SIDE, i / 3 / SIDE, (int)(i % 3));
			largest = fmax(largest, with);
		}
		most = fmax(most, added[STILB_RENDER_AMBIENT_ENVIRONMENT]);
		for (int kind = 0; kind < STILB_RENDER_AMBIENT_KINDS; kind++) {
			double wanted = kind == STILB_RENDER_AMBIENT_NONE ? 0.0 : added[STILB_RENDER_AMBIENT_ENVIRONMENT];
			if (!(fabs(added[kind] - wanted) <= 4.0 * OFF_HALF * largest))
				fail_msg("%s: a sun adds %g, not %g", names[kind], added[kind], wanted);
		}
	}
	assert_true(most > 0.1);
	for (int up = 0; up < 2; up++)
		for (int kind = 0; kind < STILB_RENDER_AMBIENT_KINDS; kind++)
			stilb_image_finish(&pictures[up][kind]);
	stage_close(&s);
}

/* ---- surfaces of every kind -------------------------------------------------------------------------------------- */

static void show_surfaces(stage *s)
{
	surface_textures textures;
	square q;
	square_make(&q, 1.0f);
	stilb_scene_build *build = stilb_scene_build_begin();
	surface_textures_add(&textures, build);
	uint32_t mesh = stilb_scene_build_mesh(build, &q.mesh);
	for (int k = 0; k < SURFACE_KINDS; k++) {
		stilb_scene_surface surface = surface_of(k);
		stage_model(build, mesh, stage_material(build, &surface),
		            stilb_mat4_scale_translate(0.22f, 0.5f * (float)(k % 4) - 0.75f, 0.01f * (float)k,
		                                       0.5f * (float)(k / 4) - 0.75f));
	}
	stage_show(s, build);
	surface_textures_finish(&textures);
}

/* Draws the scene's models, and an impostor beside them. */
static stilb_image surfaces_picture(stage *s, const stilb_render_impostor *impostor)
{
	stilb_render_pass passes[2] = {{.name = "surfaces"}, {.name = "impostor", .order = 1}};
	uint32_t ids[SURFACE_KINDS];
	for (uint32_t i = 0; i < SURFACE_KINDS; i++)
		ids[i] = i;
	stilb_mat4 place = stilb_mat4_scale_translate(0.2f, 0.6f, 0.0f, 0.6f);
	stilb_image image = {0};
	assert_int_equal(stilb_render_frame_begin(s->render), STILB_OK);
	assert_int_equal(stilb_render_record(s->render, 0, s->scene, ids, SURFACE_KINDS, s->pool, 0), STILB_OK);
	assert_int_equal(stilb_render_pass_begin(s->render, 1, 1), STILB_OK);
	stilb_render_context *context = stilb_render_context_get(s->render, 0);
	stilb_render_segment_begin(context, 1, 0);
	stilb_render_draw(context, impostor->mesh, impostor->material, &place);
	stilb_render_segment_end(context);
	assert_int_equal(stilb_render_pass_end(s->render, 1), STILB_OK);
	if (stilb_render_replay(s->render, passes, 2, &s->view, 1, s->pool, 0) != STILB_OK ||
	    stilb_render_read_image(s->render, &image) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return image;
}

static stilb_render_impostor make_impostor(stage *s)
{
	static const stilb_scene_material material = {
		.diffuse = {0.2f, 0.6f, 0.3f}, .specular = {0.1f, 0.1f, 0.1f}, .roughness = 0.5f};
	stilb_scene_mesh ball;
	assert_int_equal(stilb_scene_mesh_sphere(2, &ball), STILB_OK);
	stilb_geometry_impostor_part part = {.mesh = &ball, .material = &material};
	stilb_geometry_impostor_desc desc = {.grid = 5, .side = 24, .samples = 2};
	stilb_scene_impostor baked;
	stilb_render_impostor impostor;
	assert_int_equal(stilb_geometry_impostor_bake(&part, 1, &desc, s->pool, 0, &baked), STILB_OK);
	assert_int_equal(stilb_render_impostor_create(s->render, &baked, &impostor), STILB_OK);
	stilb_scene_impostor_finish(&baked);
	stilb_scene_mesh_finish(&ball);
	return impostor;
}

static double picture_apart(const stilb_image *a, const stilb_image *b)
{
	double apart = 0.0;
	for (uint32_t y = 0; y < a->height; y++)
		for (uint32_t x = 0; x < a->width; x++)
			for (int c = 0; c < 3; c++)
				apart = fmax(apart, fabs(picture_value(a, x, y, c) - picture_value(b, x, y, c)));
	return apart;
}

/* Surroundings of one radiance everywhere light every kind of surface the same whatever they are taken for, by each way
 * of lighting; and where they light nothing, all but what is unlit and the backdrop is black, rough glass,
 * too. Half floats are off by 2^-11 of values up to 1, and twice that where something is added to the picture. */
static void even_surroundings_are_the_same_for_all(void **state)
{
	(void)state;
	stage s = open_stage();
	show_surfaces(&s);
	stilb_render_impostor impostor = make_impostor(&s);
	s.view.light_count = 0;
	s.view.shading.brdf = SHADE_BRDF_MICROFACET;
	s.view.surroundings = (stilb_scene_surroundings){.sky = {1, 1, 1}, .ground = {1, 1, 1}, .glossy = true};
	for (int way = 0; way < STILB_RENDER_LIGHTING_WAYS; way++) {
		s.view.lighting = (stilb_render_lighting)way;
		s.view.ambient = STILB_RENDER_AMBIENT_ENVIRONMENT;
		stilb_image environment = surfaces_picture(&s, &impostor);
		for (int kind = 1; kind < STILB_RENDER_AMBIENT_KINDS; kind++) {
			s.view.ambient = (stilb_render_ambient)kind;
			stilb_image image = surfaces_picture(&s, &impostor);
			double apart = picture_apart(&environment, &image);
			if (kind != STILB_RENDER_AMBIENT_NONE && !(apart <= 0x1p-10))
				fail_msg("%s by %s is off by %g", names[kind], stilb_render_lighting_names[way], apart);
			if (kind == STILB_RENDER_AMBIENT_NONE)
				for (int k = 0; k < SURFACE_KINDS; k++) {
					uint32_t x = (uint32_t)(SIDE * (0.5 * (k % 4) + 0.25) / 2.0);
					uint32_t y = (uint32_t)(SIDE * (0.5 * (k / 4) + 0.25) / 2.0);
					double light = picture_value(&image, x, y, 0);
					bool seen = k == UNLIT || k == BLENDS; /* over the backdrop */
					if ((light > 0.0) != seen)
						fail_msg("surface %d by %s shows %g in the dark", k, stilb_render_lighting_names[way], light);
				}
			stilb_image_finish(&image);
		}
		stilb_image_finish(&environment);
	}
	stilb_render_impostor_destroy(s.render, impostor);
	stage_close(&s);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(each_kind_is_its_definition),
		cmocka_unit_test(deferred_lighting_has_each_kind),
		cmocka_unit_test(from_behind_it_is_that_of_the_other_side),
		cmocka_unit_test(hemisphere_is_what_a_glossy_environment_is),
		cmocka_unit_test(black_metal_mirrors_sky_and_ground),
		cmocka_unit_test(lamps_are_lights_besides),
		cmocka_unit_test(even_surroundings_are_the_same_for_all),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
