/* Texels of a page: what a triangle touches has a spot on that triangle, and nothing else has; shares are areas; charts
 * keep their distance; the same bits for any number of workers. */
#include "bake_made.h"

#include "bake/bake_atlas.h"

/* A scene of these meshes, each shown by as many parts as there are transforms in turn. */
static stilb_scene *scene_of(const made_mesh *made, uint32_t meshes, const stilb_mat4 *transforms, uint32_t parts)
{
	stilb_scene *scene;
	assert_int_equal(scene_create(1, parts, meshes, 1, &scene), STILB_OK);
	scene->first_part[1] = parts;
	scene->materials[0] = (stilb_scene_material){.diffuse = {0.5f, 0.5f, 0.5f}, .roughness = 1.0f};
	for (uint32_t m = 0; m < meshes; m++) {
		const stilb_bake_mesh *from = &made[m].mesh;
		assert_int_equal(scene_mesh_create(&scene->meshes[m], from->vertex_count, 3 * from->triangle_count), STILB_OK);
		for (uint32_t v = 0; v < from->vertex_count; v++)
			memcpy(scene->meshes[m].vertices[v].position, made[m].positions[v], 3 * sizeof(float));
		memcpy(scene->meshes[m].indices, made[m].indices, 3 * from->triangle_count * sizeof *made[m].indices);
	}
	for (uint32_t part = 0; part < parts; part++) {
		scene->part_mesh[part] = part % meshes;
		scene->part_material[part] = 0;
		scene->part_transform[part] = transforms[part];
	}
	return scene;
}

/* A cube, a torus, a small torus and a cube that is stretched. */
static stilb_scene *made_scene(void)
{
	made_mesh made[2] = {made_cube(), made_grid(24, 12, made_place_torus)};
	stilb_mat4 transforms[4] = {stilb_mat4_identity(), stilb_mat4_scale_translate(0.5f, 1.0f, 2.0f, 3.0f),
	                            stilb_mat4_scale_translate(2.0f, 0.0f, 4.0f, 0.0f),
	                            stilb_mat4_scale_translate(0.1f, 0.0f, 0.0f, 0.0f)};
	transforms[2].m[5] = 0.25f;
	stilb_scene *scene = scene_of(made, 2, transforms, 4);
	for (int m = 0; m < 2; m++)
		made_finish(&made[m]);
	return scene;
}

static stilb_bake_atlas *atlas_of(const stilb_scene *scene, stilb_job_pool *pool, float density, uint32_t side)
{
	stilb_bake_atlas *atlas;
	stilb_bake_atlas_options options = stilb_bake_atlas_options_default();
	options.density = density;
	options.side = side;
	assert_int_equal(stilb_bake_atlas_create(scene, &options, pool, &atlas), STILB_OK);
	return atlas;
}

/* ---- places ------------------------------------------------------------------------------------------------------ */

static void test_parts_have_as_many_texels_as_they_have_area(void **state)
{
	(void)state;
	stilb_job_pool *pool = made_pool(0);
	stilb_scene *scene = made_scene();
	stilb_bake_atlas *atlas = atlas_of(scene, pool, 10.0f, 256);
	static const double areas[4] = {6.0, 0.0, 2.0 * 4.0 + 4.0 * 0.5, 0.0};
	assert_int_equal(atlas->uv_count, 3); /* both tori share one */
	for (uint32_t part = 0; part < 4; part++) {
		double area = 0.0;
		const stilb_scene_mesh *mesh = &scene->meshes[scene->part_mesh[part]];
		for (uint32_t t = 0; t < mesh->index_count / 3; t++) {
			uint32_t page;
			float c[3][2];
			assert_true(stilb_bake_atlas_corners(atlas, part, t, &page, c));
			area +=
				0.5 * (double)((c[1][0] - c[0][0]) * (c[2][1] - c[0][1]) - (c[1][1] - c[0][1]) * (c[2][0] - c[0][0]));
		}
		if (areas[part] > 0.0)
			assert_true(fabs(area / (100.0 * areas[part]) - 1.0) < 1e-3);
		else /* a torus of radii 2 and 0.7, smaller: 24 x 12 faces have a little less than all of it */
			assert_true(fabs(area / (100.0 * 4.0 * 9.8696 * 2.0 * 0.7 * (part == 1 ? 0.25 : 0.01)) - 1.0) < 0.06);
	}
	stilb_bake_atlas_destroy(atlas);
	stilb_scene_destroy(scene);
	stilb_job_pool_destroy(pool);
}

static void test_without_a_density_all_is_on_one_page(void **state)
{
	(void)state;
	stilb_job_pool *pool = made_pool(0);
	stilb_scene *scene = made_scene();
	stilb_bake_atlas *atlas = atlas_of(scene, pool, 0.0f, 128);
	assert_int_equal(atlas->page_count, 1);
	assert_true(atlas->covered > 0.2);
	stilb_bake_atlas_destroy(atlas);
	/* Far more texels than a page has room for: charts get fewer, and there are more pages. */
	atlas = atlas_of(scene, pool, 200.0f, 128);
	assert_true(atlas->page_count > 1 && atlas->coarser > 0);
	for (uint32_t i = 0; i < atlas->place_count; i++)
		assert_true(atlas->places[i].page < atlas->page_count);
	stilb_bake_atlas_destroy(atlas);
	stilb_scene_destroy(scene);
	stilb_job_pool_destroy(pool);
}

static void test_hidden_and_empty(void **state)
{
	(void)state;
	stilb_job_pool *pool = made_pool(0);
	stilb_scene *scene = made_scene();
	scene->bounds.radius[0] = NAN;
	stilb_bake_atlas *atlas = atlas_of(scene, pool, 0.0f, 128);
	assert_int_equal(atlas->page_count, 0);
	stilb_bake_atlas_destroy(atlas);
	stilb_scene_destroy(scene);
	stilb_job_pool_destroy(pool);
}

/* ---- spots ------------------------------------------------------------------------------------------------------- */

/* The place on the page of a spot. */
static void place_of_spot(const stilb_bake_atlas *atlas, uint32_t part, const stilb_bake_spot *spot, float at[2])
{
	uint32_t page;
	float c[3][2];
	assert_true(stilb_bake_atlas_corners(atlas, part, spot->triangle, &page, c));
	for (int k = 0; k < 2; k++)
		at[k] = c[0][k] + spot->u * (c[1][k] - c[0][k]) + spot->v * (c[2][k] - c[0][k]);
}

static void assert_spots(const stilb_bake_atlas *atlas, const stilb_bake_texels *texels)
{
	uint64_t covered = 0;
	for (size_t i = 0; i < (size_t)texels->side * texels->side; i++) {
		uint32_t spots = 0;
		for (uint32_t c = 0; c < STILB_BAKE_CELLS; c++) {
			const stilb_bake_spot *spot = &texels->spots[i][c];
			if (!(spot->share > 0.0f))
				continue;
			float at[2], x = (float)(i % texels->side) + 0.5f * (float)(c & 1),
						 y = (float)(i / texels->side) + 0.5f * (float)(c >> 1);
			place_of_spot(atlas, texels->part[texels->place[i]], spot, at);
			assert_true(at[0] >= x - 1e-3f && at[0] <= x + 0.501f && at[1] >= y - 1e-3f && at[1] <= y + 0.501f);
			assert_true(spot->u >= 0.0f && spot->v >= 0.0f && spot->u + spot->v <= 1.0f + 1e-5f);
			spots++;
		}
		assert_true((spots > 0) == (texels->place[i] != STILB_BAKE_NO_CHART));
		covered += spots > 0;
	}
	assert_true(covered == texels->covered);
}

/* Every point of every triangle lies on a texel of its chart: random ones, those at corners among them. */
static void assert_conservative(const stilb_scene *scene, const stilb_bake_atlas *atlas,
                                const stilb_bake_texels *texels)
{
	uint64_t random = 3;
	for (uint32_t part = 0; part < scene->part_count; part++)
		for (uint32_t t = 0; t < scene->meshes[scene->part_mesh[part]].index_count / 3; t++)
			for (int i = 0; i < 12; i++) {
				uint32_t page;
				float c[3][2], u = made_random(&random), v = (1.0f - u) * made_random(&random), at[2];
				assert_true(stilb_bake_atlas_corners(atlas, part, t, &page, c));
				if (i < 3) {
					u = i == 1 ? 0.99f : 0.005f;
					v = i == 2 ? 0.99f : 0.005f;
				}
				for (int k = 0; k < 2; k++)
					at[k] = c[0][k] + u * (c[1][k] - c[0][k]) + v * (c[2][k] - c[0][k]);
				if (page != texels->page)
					continue;
				uint32_t place = texels->place[(size_t)at[1] * texels->side + (size_t)at[0]];
				assert_true(place != STILB_BAKE_NO_CHART);
				assert_int_equal(texels->part[place], part);
			}
}

/* Texels of two charts are at least twice the border apart. */
static void assert_apart(const stilb_bake_atlas *atlas, const stilb_bake_texels *texels)
{
	int side = (int)texels->side, reach = (int)(2 * atlas->border);
	for (int y = 0; y < side; y++)
		for (int x = 0; x < side; x++) {
			uint32_t own = texels->place[y * side + x];
			for (int dx = 1; dx <= reach && own != STILB_BAKE_NO_CHART && x + dx < side; dx++) {
				uint32_t other = texels->place[y * side + x + dx];
				assert_true(other == STILB_BAKE_NO_CHART || other == own);
			}
			for (int dy = 1; dy <= reach && own != STILB_BAKE_NO_CHART && y + dy < side; dy++) {
				uint32_t other = texels->place[(y + dy) * side + x];
				assert_true(other == STILB_BAKE_NO_CHART || other == own);
			}
		}
}

static void test_spots_lie_on_their_triangles(void **state)
{
	(void)state;
	stilb_job_pool *pool = made_pool(1);
	stilb_scene *scene = made_scene();
	stilb_bake_atlas *atlas = atlas_of(scene, pool, 9.0f, 192);
	for (uint32_t page = 0; page < atlas->page_count; page++) {
		stilb_bake_texels *texels;
		assert_int_equal(stilb_bake_texels_create(atlas, page, pool, &texels), STILB_OK);
		assert_spots(atlas, texels);
		assert_conservative(scene, atlas, texels);
		assert_apart(atlas, texels);
		stilb_bake_texels_destroy(texels);
	}
	stilb_bake_atlas_destroy(atlas);
	stilb_scene_destroy(scene);
	stilb_job_pool_destroy(pool);
}

/* One triangle: no cell has two, so the shares add up to its area, 4 cells a texel, and the mean of the spots, weighed
 * by them, is its middle. */
static void test_shares_are_areas(void **state)
{
	(void)state;
	stilb_job_pool *pool = made_pool(0);
	made_mesh made = made_empty(3, 1);
	made_set(made.positions[1], 3.1f, 0.4f, 0.0f);
	made_set(made.positions[2], 0.7f, 2.3f, 0.5f);
	made.indices[1] = 1;
	made.indices[2] = 2;
	stilb_mat4 identity = stilb_mat4_identity();
	stilb_scene *scene = scene_of(&made, 1, &identity, 1);
	stilb_bake_atlas *atlas = atlas_of(scene, pool, 10.0f, 64);
	stilb_bake_texels *texels;
	assert_int_equal(stilb_bake_texels_create(atlas, 0, pool, &texels), STILB_OK);
	double sum = 0.0, u = 0.0, v = 0.0, nx = 0.4 * 0.5, ny = -3.1 * 0.5, nz = 3.1 * 2.3 - 0.4 * 0.7;
	for (size_t i = 0; i < 64 * 64; i++)
		for (uint32_t c = 0; c < STILB_BAKE_CELLS; c++) {
			const stilb_bake_spot *spot = &texels->spots[i][c];
			sum += (double)spot->share;
			u += (double)(spot->share * spot->u);
			v += (double)(spot->share * spot->v);
		}
	assert_true(fabs(u / sum - 1.0 / 3.0) < 1e-5 && fabs(v / sum - 1.0 / 3.0) < 1e-5);
	assert_true(fabs(sum / (4.0 * 100.0 * 0.5 * sqrt(nx * nx + ny * ny + nz * nz)) - 1.0) < 1e-4);
	stilb_bake_texels_destroy(texels);
	stilb_bake_atlas_destroy(atlas);
	stilb_scene_destroy(scene);
	made_finish(&made);
	stilb_job_pool_destroy(pool);
}

static uint64_t bits_of(const stilb_scene *scene, uint32_t workers)
{
	stilb_job_pool *pool = made_pool(workers);
	stilb_bake_atlas *atlas = atlas_of(scene, pool, 9.0f, 256);
	stilb_bake_texels *texels;
	assert_int_equal(stilb_bake_texels_create(atlas, 0, pool, &texels), STILB_OK);
	size_t count = (size_t)texels->side * texels->side;
	uint64_t hash = stilb_hash_fnv1a64(STILB_FNV1A64_START, texels->spots, count * sizeof *texels->spots);
	hash = stilb_hash_fnv1a64(hash, texels->place, count * sizeof *texels->place);
	stilb_bake_texels_destroy(texels);
	stilb_bake_atlas_destroy(atlas);
	stilb_job_pool_destroy(pool);
	return hash;
}

static void test_the_same_bits_for_any_workers(void **state)
{
	(void)state;
	stilb_scene *scene = made_scene();
	uint64_t alone = bits_of(scene, 0);
	assert_true(alone == bits_of(scene, 1));
	assert_true(alone == bits_of(scene, 3));
	stilb_scene_destroy(scene);
}

int main(void)
{
	static const struct CMUnitTest tests[] = {
		test_one_thread(test_parts_have_as_many_texels_as_they_have_area),
		test_one_thread(test_without_a_density_all_is_on_one_page),
		test_one_thread(test_hidden_and_empty),
		test_one_thread(test_spots_lie_on_their_triangles),
		test_one_thread(test_shares_are_areas),
		cmocka_unit_test(test_the_same_bits_for_any_workers),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
