/* Materials of glTF files with known contents, which the test writes: textures and how they lie, factors, surfaces, and
 * variants. */
#include "glb_made.h"
#include "scene/edit/scene_edit.h"
#include "scene/edit/scene_variant.h"

/* ---- textures ---------------------------------------------------------------------------------------------------- */

/* KHR_texture_transform by the matrix of its specification: offset * rotation * scale, on the set that it names. */
static void texture_transforms(void **state)
{
	(void)state;
	static const float sets[2][6] = {{0, 0, 0, 0, 0, 0}, {0.25f, 0.5f, 1, 0, 0, 1}};
	static const struct {
		const char *json;
		float offset[2], angle, scale[2];
	} rows[] = {
		{"\"scale\":[2,3]", {0, 0}, 0, {2, 3}},
		{"\"rotation\":0.5", {0, 0}, 0.5f, {1, 1}},
		{"\"offset\":[0.125,-4],\"rotation\":-1.25,\"scale\":[-2,0.5]", {0.125f, -4}, -1.25f, {-2, 0.5f}},
	};
	write_picture("two words.png");
	for (size_t r = 0; r < sizeof rows / sizeof *rows; r++) {
		char json[1024];
		begin();
		put(triangle, sizeof triangle);
		put(sets, sizeof sets);
		snprintf(json, sizeof json,
		         NODE
		         ",\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":1,\"TEXCOORD_1\":2},"
		         "\"material\":0}]}],\"accessors\":[%s,"
		         "{\"bufferView\":1,\"componentType\":5126,\"count\":3,\"type\":\"VEC2\"},"
		         "{\"bufferView\":1,\"byteOffset\":24,\"componentType\":5126,\"count\":3,\"type\":\"VEC2\"}],"
		         "\"textures\":[{\"source\":0}],\"images\":[{\"uri\":\"two%%20words.png\"}],\"materials\":[{"
		         "\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0,\"extensions\":{"
		         "\"KHR_texture_transform\":{%s,\"texCoord\":1}}}}}]",
		         VEC3(0), rows[r].json);
		stilb_scene *scene = open_glb(json);
		assert_int_equal(scene->texture_count, 1);
		float c = cosf(rows[r].angle), s = sinf(rows[r].angle);
		for (uint32_t v = 0; v < 3; v++) {
			float u = sets[1][2 * v] * rows[r].scale[0], w = sets[1][2 * v + 1] * rows[r].scale[1];
			const stilb_scene_map *map = &scene->surfaces[0].maps[STILB_SCENE_MAP_COLOR];
			const float *place = scene->meshes[0].extras[v].uv;
			float lies[2];
			for (int i = 0; i < 2; i++) {
				const float *row = i == 0 ? map->to_u : map->to_v;
				lies[i] = row[0] * place[0] + row[1] * place[1] + row[2];
			}
			assert_int_equal(map->set, 1);
			/* Counter-clockwise where v points down. */
			assert_numbers(lies, (const float[]){c * u + s * w + rows[r].offset[0], -s * u + c * w + rows[r].offset[1]},
			               2);
		}
		stilb_scene_destroy(scene);
	}
	remove("two words.png");
}

#define TEXTURED                                                                                                       \
	NODE "," TRIANGLE_OF_0                                                                                             \
		 ",\"accessors\":[" VEC3(0) "],\"materials\":[{\"name\":\"paint\","                                            \
									"\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}}}],"
#define TRIANGLE_OF_0 "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"material\":0}]}]"

static void pictures_of_other_formats(void **state)
{
	(void)state;
	/* Four texels of (255, 0, 128), written by libwebp without loss. */
	static const uint8_t webp[] = {0x52, 0x49, 0x46, 0x46, 0x1c, 0x00, 0x00, 0x00, 0x57, 0x45, 0x42, 0x50,
	                               0x56, 0x50, 0x38, 0x4c, 0x10, 0x00, 0x00, 0x00, 0x2f, 0x01, 0x40, 0x00,
	                               0x00, 0x07, 0x10, 0xfd, 0x2f, 0x60, 0xff, 0x03, 0x11, 0xd1, 0xff, 0x00};
	static const uint8_t ktx[] = {0xAB, 'K', 'T', 'X', ' ', '2', '0', 0xBB, '\r', '\n', 0x1A, '\n', 0};
	begin();
	put(triangle, sizeof triangle);
	put(webp, sizeof webp);
	stilb_scene *scene = open_glb(TEXTURED "\"textures\":[{\"extensions\":{\"EXT_texture_webp\":{\"source\":0}}}],"
	                                       "\"images\":[{\"bufferView\":1,\"mimeType\":\"image/webp\"}],"
	                                       "\"extensionsUsed\":[\"EXT_texture_webp\"]");
	assert_int_equal(scene->texture_count, 1);
	assert_int_equal(scene->textures[0].width, 2);
	assert_memory_equal(scene->textures[0].pixels, ((const uint8_t[]){255, 0, 128}), 3);
	assert_null(strstr(said, "webp"));
	stilb_scene_destroy(scene);
	write_file("cold.ktx2", ktx, sizeof ktx);
	scene = open_glb(TEXTURED "\"textures\":[{\"extensions\":{\"KHR_texture_basisu\":{\"source\":0}}}],"
	                          "\"images\":[{\"uri\":\"cold.ktx2\"}]");
	assert_int_equal(scene->texture_count, 0);
	assert_numbers(scene->materials[0].diffuse, (const float[]){1, 0, 1}, 3);
	assert_said("material 'paint': texture 'cold.ktx2': it is KTX2");
	assert_said("ktx extract --transcode rgba8");
	stilb_scene_destroy(scene);
	remove("cold.ktx2");
}

/* ---- materials --------------------------------------------------------------------------------------------------- */

static void materials(void **state)
{
	(void)state;
	begin();
	put(triangle, sizeof triangle);
	stilb_scene *scene = open_glb(NODE ",\"accessors\":[" VEC3(
		0) "],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}},"
	       "{\"attributes\":{\"POSITION\":0},\"material\":0},{\"attributes\":{\"POSITION\":0},"
	       "\"material\":1},{\"attributes\":{\"POSITION\":0},\"material\":2}]}],"
	       "\"materials\":[{\"pbrMetallicRoughness\":{\"metallicFactor\":0,\"roughnessFactor\":"
	       "0.25,\"baseColorFactor\":[0.5,0.5,0.5,1]},\"extensions\":{\"KHR_materials_ior\":{"
	       "\"ior\":3}}},{\"emissiveFactor\":[0.5,1,0],\"extensions\":{"
	       "\"KHR_materials_emissive_strength\":{\"emissiveStrength\":8},"
	       "\"KHR_materials_specular\":{\"specularFactor\":0.5,\"specularColorFactor\":[1,0,1]}},"
	       "\"pbrMetallicRoughness\":{\"metallicFactor\":0}},{\"extensions\":{"
	       "\"KHR_materials_pbrSpecularGlossiness\":{\"diffuseFactor\":[0.25,0.5,0.125,1],"
	       "\"specularFactor\":[0.5,0.25,0.25],\"glossinessFactor\":0.75}}}]");
	assert_int_equal(scene->material_count, 4);
	const stilb_scene_material *m = scene->materials;
	assert_int_equal(scene->part_material[0], 3); /* without one: white, metal, rough */
	assert_numbers(m[3].specular, (const float[]){1, 1, 1}, 3);
	assert_numbers(&m[3].roughness, (const float[]){1}, 1);
	assert_numbers(m[0].specular, (const float[]){0.25f, 0.25f, 0.25f}, 3); /* ((3 - 1) / (3 + 1))^2 */
	assert_numbers(m[0].diffuse, (const float[]){0.375f, 0.375f, 0.375f}, 3);
	assert_numbers(m[1].emission, (const float[]){4, 8, 0}, 3);
	assert_numbers(m[1].specular, (const float[]){0.02f, 0, 0.02f}, 3);
	assert_numbers(m[2].diffuse, (const float[]){0.125f, 0.25f, 0.0625f}, 3); /* what the highlight leaves */
	assert_numbers(m[2].specular, (const float[]){0.5f, 0.25f, 0.25f}, 3);
	assert_numbers(&m[2].roughness, (const float[]){0.25f}, 1);
	stilb_scene_destroy(scene);
}

static void assert_numbers_of(const stilb_scene_surface *s)
{
	assert_numbers(s->color, (const float[]){0.25f, 0.5f, 0.75f, 0.125f}, 4);
	assert_numbers(s->specular, (const float[]){2, 1, 0.5f}, 3);
	const float got[] = {s->metalness,    s->roughness, s->specular_weight, s->ior,
	                     s->normal_scale, s->occlusion, s->cutoff};
	assert_numbers(got, (const float[]){0.25f, 0.75f, 0.5f, 1.25f, -2, 0.375f, 0.875f}, 7);
	assert_numbers(s->emission, (const float[]){4, 0, 2}, 3);
	assert_true(s->alpha == STILB_SCENE_MASK && !s->one_sided && !s->unlit);
}

/* Every factor; what is out of its range is brought into it. Vertices' colours, tangents of the file and made ones. */
static void surfaces(void **state)
{
	(void)state;
	static const char json[] = NODE ",\"accessors\":[" VEC3(
		0) ","
		   "{\"bufferView\":1,\"componentType\":5126,\"count\":3,\"type\":\"VEC2\"},"
		   "{\"bufferView\":2,\"componentType\":5121,\"normalized\":true,\"count\":3,\"type\":\"VEC4\"},"
		   "{\"bufferView\":3,\"componentType\":5126,\"count\":3,\"type\":\"VEC4\"}," VEC3(
			   4) "],"
				  "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":4,\"TEXCOORD_0\":1,\"COLOR_"
				  "0\":2,"
				  "\"TANGENT\":3},\"material\":0},{\"attributes\":{\"POSITION\":0,\"NORMAL\":4,\"TEXCOORD_0\":1},"
				  "\"material\":0},"
				  "{\"attributes\":{\"POSITION\":0,\"COLOR_0\":2}}]}],"
				  "\"textures\":[{\"source\":0}],\"images\":[{\"uri\":\"bump.png\"}],\"materials\":[{"
				  "\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.25,0.5,0.75,0.125],\"metallicFactor\":0.25,"
				  "\"roughnessFactor\":0.75},\"normalTexture\":{\"index\":0,\"scale\":-2},\"occlusionTexture\":{"
				  "\"index\":0,"
				  "\"strength\":0.375},\"emissiveFactor\":[1,-3,0.5],\"alphaMode\":\"MASK\",\"alphaCutoff\":0.875,"
				  "\"doubleSided\":true,\"extensions\":{\"KHR_materials_emissive_strength\":"
				  "{"
				  "\"emissiveStrength\":4},\"KHR_materials_ior\":{\"ior\":1.25},\"KHR_materials_specular\":{"
				  "\"specularFactor\":0.5,\"specularColorFactor\":[2,1,0.5]}}}]";
	begin();
	put(triangle, sizeof triangle);
	put((const float[]){0, 0, -1, 0, 0, 1}, 24); /* mirrored: u goes along -x */
	put((const uint8_t[]){255, 0, 51, 255, 0, 0, 0, 0, 255, 255, 255, 255}, 12);
	put((const float[]){0, 3, 0, 1, 0, 0, 0, 1, 1, 0, 0, -1}, 48);
	put((const float[]){0, 0, 1, 0, 0, 1, 0, 0, 1}, 36);
	write_picture("bump.png");
	stilb_scene *scene = open_glb(json);
	assert_int_equal(scene->surface_count, 2); /* of the default material, too, for its colours */
	assert_numbers_of(&scene->surfaces[0]);
	assert_true(scene->materials[1].surface == 2 && scene->surfaces[1].metalness == 1.0f);
	const stilb_scene_vertex_extra *given = scene->meshes[0].extras, *made = scene->meshes[1].extras;
	assert_numbers(given[0].tangent, (const float[]){0, 1, 0, 1}, 4);
	assert_numbers(given[1].tangent, (const float[]){0, 0, 0, 0}, 4);
	assert_numbers(given[2].tangent, (const float[]){1, 0, 0, -1}, 4);
	assert_numbers(given[0].color, (const float[]){1, 0, 0.2f, 1}, 4);
	assert_numbers(given[1].color, (const float[]){0, 0, 0, 0}, 4);
	for (uint32_t v = 0; v < 3; v++)
		assert_numbers(made[v].tangent, (const float[]){-1, 0, 0, 1}, 4);
	assert_numbers(made[1].color, (const float[]){1, 1, 1, 1}, 4);
	assert_numbers(scene->meshes[2].extras[0].color, (const float[]){1, 0, 0.2f, 1}, 4);
	stilb_scene_destroy(scene);
	remove("bump.png");
}

/* Of a normal map on a third uv no vertex needs a tangent. */
static void maps_on_a_third_uv_are_left_out(void **state)
{
	(void)state;
	begin();
	put(triangle, sizeof triangle);
	put((const float[]){0, 0, 1, 0, 0, 1}, 24);
	write_picture("bump.png");
	stilb_scene *scene = open_glb(NODE ",\"accessors\":[" VEC3(
		0) ",{\"bufferView\":1,\"componentType\":5126,\"count\":3,\"type\":\"VEC2\"}],"
	       "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":1,\"TEXCOORD_1\":1,"
	       "\"TEXCOORD_2\":1},\"material\":0}]}],\"textures\":[{\"source\":0}],\"images\":[{\"uri\":\"bump.png\"}],"
	       "\"materials\":[{\"name\":\"wall\",\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}},"
	       "\"occlusionTexture\":{\"index\":0,\"texCoord\":1},\"normalTexture\":{\"index\":0,\"texCoord\":2}}]");
	assert_said("of maps on three and more uv, those on the highest are left out: 1 material ('wall')");
	assert_int_equal(scene->surfaces[0].maps[STILB_SCENE_MAP_NORMAL].texture, 0);
	assert_true(scene->surfaces[0].maps[STILB_SCENE_MAP_OCCLUSION].texture > 0);
	for (uint32_t v = 0; v < 3; v++)
		assert_numbers(scene->meshes[0].extras[v].tangent, (const float[]){0, 0, 0, 0}, 4);
	stilb_scene_destroy(scene);
	remove("bump.png");
}

/* A glow of factor 0, and all but the colour of what is unlit: no picture, no surface, no tangents. */
static void maps_that_show_nothing_are_not_read(void **state)
{
	(void)state;
	begin();
	put(triangle, sizeof triangle);
	put((const float[]){0, 0, 1, 0, 0, 1}, 24);
	stilb_scene *scene = open_glb(NODE ",\"accessors\":[" VEC3(
		0) ",{\"bufferView\":1,\"componentType\":5126,\"count\":3,\"type\":\"VEC2\"}],"
	       "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":1},\"material\":0},"
	       "{\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":1},\"material\":1}]}],\"textures\":[{\"source\":0}],"
	       "\"images\":[{\"uri\":\"nowhere.png\"}],\"materials\":[{\"emissiveTexture\":{\"index\":0}},"
	       "{\"emissiveFactor\":[1,1,1],\"emissiveTexture\":{\"index\":0},\"normalTexture\":{\"index\":0},"
	       "\"extensions\":{\"KHR_materials_unlit\":{}}}]");
	assert_null(strstr(said, "nowhere.png"));
	assert_int_equal(scene->texture_count, 0);
	assert_int_equal(scene->materials[0].surface, 0);
	assert_true(scene->surface_count == 1 && scene->surfaces[0].unlit);
	assert_null(scene->meshes[1].extras);
	stilb_scene_destroy(scene);
}

/* What lacks the picture of its colour is magenta, and still shines and has its alpha; each use of a picture that is
 * not there is told. */
static void a_missing_colour_is_magenta(void **state)
{
	(void)state;
	begin();
	put(triangle, sizeof triangle);
	stilb_scene *scene = open_glb(NODE "," TRIANGLE ",\"accessors\":[" VEC3(
		0) "],\"textures\":[{\"source\":0}],"
	       "\"images\":[{\"uri\":\"gone.png\"}],\"materials\":[{\"normalTexture\":{\"index\":0}},"
	       "{\"alphaMode\":\"MASK\",\"emissiveFactor\":[1,0.5,0.25],\"pbrMetallicRoughness\":{"
	       "\"baseColorTexture\":{\"index\":0},\"metallicRoughnessTexture\":{\"index\":0}}}]");
	assert_said("texture 'gone.png'");
	assert_said("; it is left out");
	assert_said("; the material becomes magenta");
	assert_numbers(scene->materials[1].diffuse, (const float[]){1, 0, 1}, 3);
	assert_numbers(scene->materials[1].emission, (const float[]){1, 0.5f, 0.25f}, 3);
	const stilb_scene_surface *surface = &scene->surfaces[scene->materials[1].surface - 1];
	assert_true(surface->alpha == STILB_SCENE_MASK);
	assert_numbers(surface->emission, (const float[]){1, 0.5f, 0.25f}, 3);
	stilb_scene_destroy(scene);
}

/* ---- layers ------------------------------------------------------------------------------------------------------ */

#define LAYERS_OF(rest)                                                                                                \
	NODE ",\"accessors\":[" VEC3(                                                                                      \
		0) ",{\"bufferView\":1,\"componentType\":5126,\"count\":3,\"type\":\"VEC2\"}],"                                \
		   "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":1},\"material\":0}]}],"        \
		   "\"textures\":[{\"source\":0}],\"images\":[{\"uri\":\"layer.png\"}],\"materials\":[{\"name\":\"car\","      \
		   "\"extensions\":{" rest "}}]"
#define LAYER_MAP "{\"index\":0}"

static const char layers_coat[] = "\"KHR_materials_clearcoat\":{\"clearcoatFactor\":0.5,\"clearcoatTexture\":" LAYER_MAP
								  ",\"clearcoatRoughnessFactor\":0.25,\"clearcoatRoughnessTexture\":" LAYER_MAP
								  ",\"clearcoatNormalTexture\":{\"index\":0,\"scale\":0.75}}";
static const char layers_sheen[] =
	"\"KHR_materials_sheen\":{\"sheenColorFactor\":[0.5,2,0.25],\"sheenColorTexture\":" LAYER_MAP
	",\"sheenRoughnessFactor\":0.375,\"sheenRoughnessTexture\":" LAYER_MAP "}";
static const char layers_brushed[] = "\"KHR_materials_anisotropy\":{\"anisotropyStrength\":0.625,"
									 "\"anisotropyRotation\":-4,\"anisotropyTexture\":" LAYER_MAP "}";
static const char layers_through[] =
	"\"KHR_materials_transmission\":{\"transmissionFactor\":0.875,\"transmissionTexture\":" LAYER_MAP
	"},\"KHR_materials_volume\":{\"thicknessFactor\":3,\"thicknessTexture\":" LAYER_MAP
	",\"attenuationColor\":[0.5,0.25,0],\"attenuationDistance\":2}";
static const char layers_specular[] =
	"\"KHR_materials_specular\":{\"specularFactor\":0.5,\"specularTexture\":" LAYER_MAP
	",\"specularColorFactor\":[1,2,0.5],\"specularColorTexture\":" LAYER_MAP "}";

/* Reads a triangle with the uv of a material with these extensions. */
static stilb_scene *open_layers(const char *extensions)
{
	char json[4096];
	begin();
	put(triangle, sizeof triangle);
	put((const float[]){0, 0, -1, 0, 0, 1}, 24); /* mirrored: u goes along -x */
	snprintf(json, sizeof json, LAYERS_OF("%s"), extensions);
	return open_glb(json);
}

/* Factors and maps of every layer; maps of colours are colours, the others data. */
static void layers(void **state)
{
	(void)state;
	char all[2048];
	write_picture("layer.png");
	snprintf(all, sizeof all, "%s,%s,%s,%s,%s", layers_coat, layers_sheen, layers_brushed, layers_through,
	         layers_specular);
	stilb_scene *scene = open_layers(all);
	assert_int_equal(scene->surface_count, 1);
	const stilb_scene_surface *s = &scene->surfaces[0];
	const float got[] = {s->clearcoat,       s->clearcoat_roughness, s->clearcoat_normal_scale, s->sheen_roughness,
	                     s->anisotropy,      s->anisotropy_rotation, s->transmission,           s->thickness,
	                     s->specular_weight, s->attenuation_distance};
	assert_numbers(got, (const float[]){0.5f, 0.25f, 0.75f, 0.375f, 0.625f, -4, 0.875f, 3, 0.5f, 2}, 10);
	assert_numbers(s->sheen_color, (const float[]){0.5f, 1, 0.25f}, 3);
	assert_numbers(s->attenuation, (const float[]){0.5f, 0.25f, 0}, 3);
	assert_true(s->attenuation[2] > 0.0f);
	for (int kind = STILB_SCENE_MAP_CLEARCOAT; kind < STILB_SCENE_MAPS; kind++) {
		uint32_t texture = s->maps[kind].texture;
		bool color = kind == STILB_SCENE_MAP_SPECULAR_COLOR || kind == STILB_SCENE_MAP_SHEEN_COLOR;
		assert_in_range(texture, 1, scene->texture_count);
		assert_int_equal(scene->textures[texture - 1].format, color ? STILB_IMAGE_U8_SRGB : STILB_IMAGE_U8_LINEAR);
	}
	assert_null(strstr(said, "it uses extensions"));
	stilb_scene_destroy(scene);
	remove("layer.png");
}

/* Without a factor nothing is seen of maps: nobody asks for the picture, which is not there. With one somebody does. */
static void maps_of_layers_that_are_not_there(void **state)
{
	(void)state;
	static const struct {
		const char *extensions;
		bool reads;
	} rows[] = {
		{"\"KHR_materials_clearcoat\":{\"clearcoatTexture\":" LAYER_MAP ",\"clearcoatRoughnessFactor\":1,"
	     "\"clearcoatRoughnessTexture\":" LAYER_MAP ",\"clearcoatNormalTexture\":" LAYER_MAP "}",
	     false},
		{"\"KHR_materials_clearcoat\":{\"clearcoatFactor\":1,\"clearcoatRoughnessTexture\":" LAYER_MAP "}", false},
		{"\"KHR_materials_clearcoat\":{\"clearcoatFactor\":1,\"clearcoatNormalTexture\":" LAYER_MAP "}", true},
		{"\"KHR_materials_sheen\":{\"sheenColorTexture\":" LAYER_MAP
	     ",\"sheenRoughnessFactor\":1,\"sheenRoughnessTexture\":" LAYER_MAP "}",
	     false},
		{"\"KHR_materials_sheen\":{\"sheenColorFactor\":[0,0,1],\"sheenRoughnessFactor\":1,"
	     "\"sheenRoughnessTexture\":" LAYER_MAP "}",
	     true},
		{"\"KHR_materials_anisotropy\":{\"anisotropyTexture\":" LAYER_MAP "}", false},
		{"\"KHR_materials_transmission\":{\"transmissionTexture\":" LAYER_MAP
	     "},\"KHR_materials_volume\":{\"thicknessFactor\":1,\"thicknessTexture\":" LAYER_MAP "}",
	     false},
		{"\"KHR_materials_specular\":{\"specularFactor\":0,\"specularTexture\":" LAYER_MAP
	     ",\"specularColorTexture\":" LAYER_MAP "}",
	     false},
		{"\"KHR_materials_specular\":{\"specularColorFactor\":[0,0,0],\"specularColorTexture\":" LAYER_MAP "}", false},
		{"\"KHR_materials_specular\":{\"specularColorTexture\":" LAYER_MAP "}", true},
		{"\"KHR_materials_specular\":{\"specularTexture\":" LAYER_MAP
	     "},\"KHR_materials_pbrSpecularGlossiness\":{\"glossinessFactor\":0.5}",
	     false},
	};
	for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
		stilb_scene *scene = open_layers(rows[i].extensions);
		if (!strstr(said, "layer.png") == rows[i].reads)
			fail_msg("row %zu: '%s'", i, said);
		stilb_scene_destroy(scene);
	}
}

/* Each layer by itself needs a surface, also without maps, and what needs tangents gets some. */
static void each_layer_needs_a_surface(void **state)
{
	(void)state;
	static const struct {
		const char *extensions;
		bool needs, tangents;
	} rows[] = {
		{"\"KHR_materials_clearcoat\":{\"clearcoatFactor\":1}", true, false},
		{"\"KHR_materials_sheen\":{\"sheenColorFactor\":[0,0,1]}", true, false},
		{"\"KHR_materials_transmission\":{\"transmissionFactor\":0.5}", true, false},
		{"\"KHR_materials_anisotropy\":{\"anisotropyStrength\":0.5}", true, true},
		{"\"KHR_materials_clearcoat\":{},\"KHR_materials_sheen\":{},\"KHR_materials_transmission\":{},"
	     "\"KHR_materials_anisotropy\":{},\"KHR_materials_volume\":{\"thicknessFactor\":1,\"attenuationDistance\":0}",
	     false, false},
	};
	for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
		stilb_scene *scene = open_layers(rows[i].extensions);
		const stilb_scene_vertex_extra *extras = scene->meshes[0].extras;
		if ((scene->surface_count > 0) != rows[i].needs || !extras == rows[i].tangents)
			fail_msg("row %zu: %u surfaces", i, scene->surface_count);
		if (extras)
			assert_numbers(extras[0].tangent, (const float[]){-1, 0, 0, 1}, 4);
		assert_null(strstr(said, "car"));
		stilb_scene_destroy(scene);
	}
}

/* ---- variants ---------------------------------------------------------------------------------------------------- */

#define MAPS(material, variants) "{\"material\":" #material ",\"variants\":[" variants "]}"
#define HAS_VARIANTS(maps) "\"extensions\":{\"KHR_materials_variants\":{\"mappings\":[" maps "]}}"
#define VARIANTS "\"extensions\":{\"KHR_materials_variants\":{\"variants\":[{\"name\":\"red\"},{\"name\":\"\"},{}]}}"

/* Two nodes show mesh 0: its first primitive has variants 0 and 2, the second, without a material, variant 1. */
static void variants(void **state)
{
	(void)state;
	static const char json[] =
		"\"nodes\":[{\"mesh\":0},{\"mesh\":0}],\"scenes\":[{\"nodes\":[0,1]}],"
		"\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}],"
		"\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"material\":0," HAS_VARIANTS(MAPS(
			1,
			"2,0")) "},{\"attributes\":{\"POSITION\":0}," HAS_VARIANTS(MAPS(2,
	                                                                        "1")) "}]}],"
																				  "\"materials\":[{},{},{}]," VARIANTS;
	static const char wrong[] =
		NODE "," VARIANTS ",\"materials\":[{}],"
			 "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}],"
			 "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}," HAS_VARIANTS(MAPS(0, "3")) "}]}]";
	begin();
	put(triangle, sizeof triangle);
	stilb_scene *scene = open_glb(json);
	static const uint32_t wanted[4][4] = {{0, 3, 0, 3}, {1, 3, 1, 3}, {0, 2, 0, 2}, {1, 3, 1, 3}};
	const stilb_scene_variants *found = scene->variants;
	assert_non_null(found);
	assert_int_equal(found->count, 3);
	assert_int_equal(found->part_count, 4);
	assert_string_equal(found->names[0], "red");
	assert_string_equal(found->names[2], "number 2");
	assert_memory_equal(found->materials, wanted, sizeof wanted);
	for (uint32_t v = 0; v < 4; v++) {
		uint64_t models = stilb_scene_revisions_read(scene).models;
		stilb_scene_changes_clear(scene);
		assert_int_equal(stilb_scene_show_variant(scene, v), STILB_OK);
		assert_int_equal(found->shown, v);
		assert_true((scene->moved_count > 0) == (v > 0)); /* frames must draw these models anew */
		assert_true((stilb_scene_revisions_read(scene).models > models) == (v > 0));
		assert_memory_equal(scene->part_material, wanted[v], sizeof wanted[v]);
	}
	assert_int_equal(stilb_scene_show_variant(scene, 4), STILB_ERROR_ARGUMENT);
	assert_int_equal(stilb_scene_show_variant_named(scene, "blue"), STILB_ERROR_ARGUMENT);
	assert_string_equal(stilb_error_message(),
	                    "there is no variant 'blue' of its materials; there are 'red', 'number 1', 'number 2'");
	/* What edits have changed stays, and a material that a part shows cannot be removed. */
	assert_int_equal(stilb_scene_show_variant(scene, 0), STILB_OK);
	assert_int_equal(stilb_scene_set_part(scene, 1, 0, (stilb_scene_build_part){0, 2}), STILB_OK);
	assert_int_equal(stilb_scene_remove_material(scene, 1), STILB_OK);
	assert_int_equal(stilb_scene_show_variant_named(scene, "red"), STILB_ERROR_ARGUMENT);
	assert_non_null(strstr(stilb_error_message(), "material 1 was removed"));
	assert_int_equal(stilb_scene_show_variant(scene, 2), STILB_OK);
	assert_memory_equal(scene->part_material, ((const uint32_t[]){0, 2, 2, 2}), 16);
	assert_int_equal(stilb_scene_remove_material(scene, 2), STILB_ERROR_ARGUMENT);
	assert_int_equal(stilb_scene_remove_model(scene, 0), STILB_OK);
	assert_int_equal(stilb_scene_show_variant(scene, 0), STILB_OK);
	assert_int_equal(scene->part_material[0], STILB_SCENE_NONE);
	assert_int_equal(scene->part_material[3], 3);
	stilb_scene_destroy(scene);
	assert_int_equal(stilb_scene_open("cornell", &scene), STILB_OK);
	assert_int_equal(stilb_scene_show_variant(scene, 0), STILB_OK);
	assert_int_equal(stilb_scene_show_variant_named(scene, "red"), STILB_ERROR_ARGUMENT);
	stilb_scene_destroy(scene);
	assert_refused(wrong, "it names variant 3, but there are 3");
}

/* A mesh has one set of texture coordinates: of the first material that draws a texture. */
static void variants_share_their_coordinates(void **state)
{
	(void)state;
	static const char json[] =
		NODE ",\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"},"
			 "{\"bufferView\":1,\"componentType\":5126,\"count\":3,\"type\":\"VEC2\"},"
			 "{\"bufferView\":1,\"byteOffset\":24,\"componentType\":5126,\"count\":3,\"type\":\"VEC2\"}],"
			 "\"meshes\":[{\"name\":\"shoe\",\"primitives\":[{\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":1,"
			 "\"TEXCOORD_1\":2},\"material\":0," HAS_VARIANTS(MAPS(1, "0") "," MAPS(
				 2, "1")) "}]}],"
						  "\"textures\":[{\"source\":0}],\"images\":[{\"uri\":\"paint.png\"}],\"materials\":[{},"
						  "{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0,\"texCoord\":1}}},"
						  "{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}}}]," VARIANTS;
	begin();
	put(triangle, sizeof triangle);
	put((const float[]){0, 0, 0, 0, 0, 0, 0.25f, 0.5f, 1, 0, 0, 1}, 48);
	write_picture("paint.png");
	stilb_scene *scene = open_glb(json);
	assert_numbers(scene->meshes[0].vertices[0].uv, (const float[]){0, 0}, 2);
	assert_numbers(scene->meshes[0].extras[0].uv, (const float[]){0.25f, 0.5f}, 2);
	assert_int_equal(scene->surfaces[0].maps[STILB_SCENE_MAP_COLOR].set, 1);
	assert_int_equal(scene->surfaces[1].maps[STILB_SCENE_MAP_COLOR].set, 0);
	assert_null(strstr(said, "textures of variants"));
	stilb_scene_destroy(scene);
	/* A third uv: vertices have two. */
	char third[2048];
	const char *at = strstr(json, "\"texCoord\":1");
	snprintf(third, sizeof third, "%.*s\"texCoord\":2%s", (int)(at - json), json, at + strlen("\"texCoord\":1"));
	scene = open_glb(third);
	assert_said("textures of variants lie on the uv of the first: 1 mesh ('shoe')");
	stilb_scene_destroy(scene);
	remove("paint.png");
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(texture_transforms),
		cmocka_unit_test(pictures_of_other_formats),
		cmocka_unit_test(materials),
		cmocka_unit_test(surfaces),
		cmocka_unit_test(maps_on_a_third_uv_are_left_out),
		cmocka_unit_test(maps_that_show_nothing_are_not_read),
		cmocka_unit_test(a_missing_colour_is_magenta),
		cmocka_unit_test(layers),
		cmocka_unit_test(maps_of_layers_that_are_not_there),
		cmocka_unit_test(each_layer_needs_a_surface),
		cmocka_unit_test(variants),
		cmocka_unit_test(variants_share_their_coordinates),
	};
	return cmocka_run_group_tests(tests, folder_make, glb_clear);
}
