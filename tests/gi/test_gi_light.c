/* gi_light: what arrives from lights against closed forms; densities against what is chosen; what bad input does. */
#include "support/shade_proof.h"

#include "gi/gi_vector.h"
#include "gi/light/gi_environment.h"
#include "gi/light/gi_light_shape.h"
#include "gi/light/gi_light_tree.h"
#include "gi/sample/gi_sampler.h"
#include "numeric/numeric_sh.h"
#include "shading/shade_sampling.h"

#include <string.h>

static gi_sampler sampler;

static int make_sampler(void **state)
{
	(void)state;
	sampler = gi_sampler_make(STILB_GI_SAMPLER_SOBOL, 1, 1);
	return 0;
}

/* ---- scenes ------------------------------------------------------------------------------------------------------ */

static stilb_vec3 vec(float x, float y, float z)
{
	return stilb_vec3_make(x, y, z);
}

static gi_emitter triangle(stilb_vec3 a, stilb_vec3 b, stilb_vec3 c, float radiance)
{
	gi_emitter emitter = {.emission = {radiance, radiance, radiance}};
	for (int i = 0; i < 3; i++) {
		emitter.position[0][i] = a[i];
		emitter.position[1][i] = b[i];
		emitter.position[2][i] = c[i];
	}
	return emitter;
}

/* The parallelogram at corner with these edges; its front is where edge_1 x edge_2 points. */
static void quad(gi_emitter emitters[2], stilb_vec3 corner, stilb_vec3 edge_1, stilb_vec3 edge_2, float radiance)
{
	emitters[0] = triangle(corner, corner + edge_1, corner + edge_1 + edge_2, radiance);
	emitters[1] = triangle(corner, corner + edge_1 + edge_2, corner + edge_2, radiance);
}

static gi_lights lights_of(const stilb_scene *scene, const gi_emitter *emitters, uint32_t count)
{
	static const stilb_scene dark;
	gi_lights lights;
	if (gi_lights_create(scene ? scene : &dark, emitters, count, &lights) != STILB_OK)
		fail_msg("%s", stilb_error_message());
	return lights;
}

static float length_of(stilb_vec3 v)
{
	return sqrtf(stilb_vec3_dot(v, v));
}

/* The i-th of a row of sampler points; another stream gives a row of other random numbers. */
static gi_point numbered(uint64_t stream, uint32_t i)
{
	return (gi_point){.hash = stream, .index = i, .count = 1};
}

/* The estimate of the irradiance (colour channel 0) of a receiver at position with this normal, of one light sample of
 * each group. */
static double contribution(const gi_lights *lights, stilb_vec3 position, stilb_vec3 normal, gi_point point)
{
	float u[8];
	double sum = 0.0;
	gi_sample_8(&sampler, point, 8, u);
	for (gi_light_group group = 0; group < GI_LIGHT_GROUPS; group++) {
		gi_light_sample sample;
		if (!gi_light_is_asked(lights, group, true) ||
		    !gi_light_sample_at(lights, group, true, position, normal, u[4], (stilb_vec2){u[2], u[3]}, &sample))
			continue;
		float cosine = stilb_vec3_dot(normal, sample.direction);
		sum += cosine > 0.0f ? (double)(sample.radiance[0] * cosine / sample.pdf) : 0.0;
	}
	return sum;
}

/* Irradiance as the mean of count such estimates. */
static double irradiance(const gi_lights *lights, stilb_vec3 position, stilb_vec3 normal, uint32_t count)
{
	double sum = 0.0;
	for (uint32_t i = 0; i < count; i++)
		sum += contribution(lights, position, normal, numbered(17, i));
	return sum / count;
}

/* ---- triangles and rectangles: irradiance ------------------------------------------------------------------------ */

/* Irradiance from a polygon of radiance 1 above the horizon, seen counter-clockwise: Lambert, "Photometria" (1760). */
static double polygon_irradiance(const stilb_vec3 *corners, int count, stilb_vec3 position, stilb_vec3 normal)
{
	double sum = 0.0;
	for (int i = 0; i < count; i++) {
		double a[3], b[3], c[3], la = 0.0, lb = 0.0, lc = 0.0, ab = 0.0, n = 0.0;
		for (int k = 0; k < 3; k++) {
			a[k] = (double)corners[i][k] - (double)position[k];
			b[k] = (double)corners[(i + 1) % count][k] - (double)position[k];
			la += a[k] * a[k];
			lb += b[k] * b[k];
			ab += a[k] * b[k];
		}
		for (int k = 0; k < 3; k++) {
			c[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
			lc += c[k] * c[k];
			n += c[k] * (double)normal[k];
		}
		sum += acos(fmin(fmax(ab / sqrt(la * lb), -1.0), 1.0)) * n / sqrt(lc);
	}
	return fabs(0.5 * sum);
}

enum { ONE_TRIANGLE, TWO_TRIANGLES, RECTANGLE };

/* A shape over the origin, looking down more or less, from very near to far away. */
static gi_lights shape_over(shade_proof_random *random, int kind, gi_emitter emitters[2], stilb_vec3 corners[4])
{
	stilb_vec3 up = vec(0.0f, 1.0f, 0.0f);
	float turn = shade_proof_range(random, 0.0f, 6.0f), tilt = shade_proof_range(random, 0.0f, 0.5f);
	stilb_vec3 x = vec(cosf(turn), 0.0f, sinf(turn)), z = vec(-sinf(turn), 0.0f, cosf(turn));
	stilb_vec3 edge_1 = x * shade_proof_range(random, 0.2f, 2.0f) + z * (kind == RECTANGLE ? 0.0f : 0.3f);
	stilb_vec3 edge_2 = z * cosf(tilt) + up * sinf(tilt);
	corners[0] = vec(shade_proof_range(random, -1.0f, 1.0f), shade_proof_log_range(random, 0.02f, 20.0f),
	                 shade_proof_range(random, -1.0f, 1.0f));
	corners[1] = corners[0] + edge_1;
	corners[2] = corners[1] + edge_2;
	corners[3] = corners[0] + edge_2;
	quad(emitters, corners[0], edge_1, edge_2, 2.0f);
	return lights_of(NULL, emitters, kind == ONE_TRIANGLE ? 1 : 2);
}

/* The irradiance from a shape is that of Lambert's formula. Points are sampled by solid angle, so a single rectangle or
 * triangle has little noise; of two triangles one is chosen at random, which adds noise. */
static void irradiance_is_lamberts(void **state)
{
	(void)state;
	static const double bars[] = {[ONE_TRIANGLE] = 1e-3, [TWO_TRIANGLES] = 3e-2, [RECTANGLE] = 3e-4};
	shade_proof_random random = {.seed = 1};
	stilb_vec3 origin = {0}, up = vec(0.0f, 1.0f, 0.0f);
	int dark = 0;
	for (int trial = 0; trial < 90; trial++) {
		int kind = trial % 3;
		gi_emitter emitters[2];
		stilb_vec3 corners[4];
		gi_lights lights = shape_over(&random, kind, emitters, corners);
		assert_int_equal(lights.shape_count, kind == TWO_TRIANGLES ? 2 : 1);
		double want = 2.0 * polygon_irradiance(corners, kind == ONE_TRIANGLE ? 3 : 4, origin, up);
		if (stilb_vec3_dot(lights.shapes[0].normal, corners[0]) >= 0.0f) { /* the origin sees the dark back */
			want = 0.0;
			dark++;
		}
		SHADE_PROOF_NEAR(irradiance(&lights, origin, up, 4096), want, bars[kind], 0.0);
		gi_lights_destroy(&lights);
	}
	assert_in_range(dark, 5, 45);
}

/* The triangles of a ball of radius 1 whose middle is at least so high; facing inwards or outwards. area: of all of
 * them. */
static gi_lights lights_of_ball(bool inwards, float least_height, double *area)
{
	stilb_scene_mesh mesh;
	assert_int_equal(stilb_scene_mesh_sphere(4, &mesh), STILB_OK);
	gi_emitter *emitters = calloc(mesh.index_count / 3, sizeof *emitters);
	uint32_t count = 0;
	*area = 0.0;
	for (uint32_t i = 0; i < mesh.index_count; i += 3) {
		stilb_vec3 p[3];
		for (int k = 0; k < 3; k++) {
			const float *position = mesh.vertices[mesh.indices[i + (uint32_t)k]].position;
			p[k] = vec(position[0], position[1], position[2]);
		}
		if (p[0][1] + p[1][1] + p[2][1] < 3.0f * least_height)
			continue;
		emitters[count++] = inwards ? triangle(p[0], p[2], p[1], 3.0f) : triangle(p[0], p[1], p[2], 3.0f);
		*area += 0.5 * (double)length_of(stilb_vec3_cross(p[1] - p[0], p[2] - p[0]));
	}
	gi_lights lights = lights_of(NULL, emitters, count);
	free(emitters);
	stilb_scene_mesh_finish(&mesh);
	return lights;
}

/* A patch of the inside of a sphere of radius R, with the radiance L and the area A, gives every point of the inside
 * the irradiance L A / (4 R^2); here R = 1 and L = 3. The patch is within 60 degrees of the top, the receivers are on
 * the lower half. */
static void patch_of_a_sphere_lights_its_inside_evenly(void **state)
{
	(void)state;
	double area;
	gi_lights lights = lights_of_ball(true, 0.5f, &area);
	for (uint32_t i = 0; i < 3; i++) {
		stilb_vec3 normal = shade_sample_hemisphere((stilb_vec2){0.2f * (float)i, 0.37f * (float)i}).direction;
		normal = vec(normal[0], normal[2], normal[1]);
		SHADE_PROOF_NEAR(irradiance(&lights, -normal, normal, 16384), 3.0 * area / 4.0, 2e-3, 0.0);
	}
	gi_lights_destroy(&lights);
}

/* A ball of radius R and radiance L gives a receiver that faces it, d from its centre, the irradiance pi L (R / d)^2.
 * The ball is a mesh, so R^2 is its area / (4 pi). Half of its triangles look away, and samples seldom choose them. */
static void ball_is_seen_as_a_disk(void **state)
{
	(void)state;
	double area;
	gi_lights lights = lights_of_ball(false, -2.0f, &area);
	assert_int_equal(lights.placed_count, 5120);
	stilb_vec3 up = vec(0.0f, 1.0f, 0.0f);
	for (float d = 1.5f; d < 20.0f; d *= 2.0f) {
		stilb_vec3 position = vec(0.0f, -d, 0.0f);
		SHADE_PROOF_NEAR(irradiance(&lights, position, up, 8192), 3.0 * area / 4.0 / (double)(d * d), 1e-2, 0.0);
		int found = 0;
		for (uint32_t i = 0; i < 512; i++)
			found += contribution(&lights, position, up, numbered(41, i)) > 0.0;
		assert_true(found > 512 * (d < 2.0f ? 0.65 : 0.8));
	}
	gi_lights_destroy(&lights);
}

/* ---- form factors ------------------------------------------------------------------------------------------------ */

#define RECEIVERS 4096
#define ASKED 32 /* light samples of each receiver */

/* The form factor F12, the share of the light leaving surface 1 that arrives at surface 2, which are the lights, of
 * radiance 1: their irradiance on surface 1 over pi, mean over its points corner + edge_1 s + edge_2 t. (s, t) fills
 * the unit square; disk: the unit disk. */
static double form_factor(const gi_lights *lights, stilb_vec3 corner, stilb_vec3 edge_1, stilb_vec3 edge_2, bool disk,
                          stilb_vec3 normal)
{
	double sum = 0.0;
	for (uint32_t i = 0; i < RECEIVERS; i++) {
		gi_point receiver = numbered(23, i);
		stilb_vec2 at = gi_sample_2d(&sampler, receiver, 0);
		if (disk)
			at = shade_sample_disk(at);
		for (uint32_t k = 0; k < ASKED; k++)
			sum += contribution(lights, corner + edge_1 * at[0] + edge_2 * at[1], normal,
			                    gi_sampler_branch(&sampler, receiver, 8, k, ASKED));
	}
	return sum / RECEIVERS / ASKED / M_PI;
}

/* Where the expected form factors come from: docs/gi.md. */
static void form_factors_of_rectangles(void **state)
{
	(void)state;
	stilb_vec3 x = vec(1.0f, 0.0f, 0.0f), y = vec(0.0f, 1.0f, 0.0f), z = vec(0.0f, 0.0f, 1.0f), o = {0};
	gi_emitter emitters[2];
	quad(emitters, y, x, z, 1.0f); /* looks down */
	gi_lights lights = lights_of(NULL, emitters, 2);
	SHADE_PROOF_NEAR(form_factor(&lights, o, x, z, false, y), 0.1998249, 1e-3, 0.0);
	gi_lights_destroy(&lights);
	quad(emitters, y * 0.5f, x * 2.0f, z, 1.0f);
	lights = lights_of(NULL, emitters, 2);
	SHADE_PROOF_NEAR(form_factor(&lights, o, x * 2.0f, z, false, y), 0.5089887, 1e-3, 0.0);
	gi_lights_destroy(&lights);
	quad(emitters, o, y, z, 1.0f); /* looks along x, with an edge in common */
	lights = lights_of(NULL, emitters, 2);
	SHADE_PROOF_NEAR(form_factor(&lights, o, x, z, false, y), 0.2000438, 1e-3, 0.0);
	gi_lights_destroy(&lights);
}

#define DISK_TRIANGLES 64

/* A disk of this radius as a fan of triangles, which has the disk's area, at height h over the origin, looking down. */
static gi_lights disk_of(float radius, float h)
{
	static gi_emitter emitters[DISK_TRIANGLES];
	double step = 2.0 * M_PI / DISK_TRIANGLES;
	radius *= (float)sqrt(step / sin(step));
	for (int i = 0; i < DISK_TRIANGLES; i++) {
		stilb_vec3 a = vec(radius * (float)cos(step * i), h, radius * (float)sin(step * i));
		stilb_vec3 b = vec(radius * (float)cos(step * (i + 1)), h, radius * (float)sin(step * (i + 1)));
		emitters[i] = triangle(vec(0.0f, h, 0.0f), a, b, 1.0f);
	}
	return lights_of(NULL, emitters, DISK_TRIANGLES);
}

static void form_factors_of_disks_and_reciprocity(void **state)
{
	(void)state;
	stilb_vec3 x = vec(1.0f, 0.0f, 0.0f), y = vec(0.0f, 1.0f, 0.0f), z = vec(0.0f, 0.0f, 1.0f), o = {0};
	gi_lights lights = disk_of(1.0f, 1.0f);
	SHADE_PROOF_NEAR(form_factor(&lights, o, x, z, true, y), 0.5 * (3.0 - sqrt(5.0)), 1e-3, 0.0);
	gi_lights_destroy(&lights);
	lights = disk_of(0.5f, 2.0f);
	double small = form_factor(&lights, o, x, z, true, y);
	SHADE_PROOF_NEAR(small, 0.0480590, 1e-3, 0.0);
	gi_lights_destroy(&lights);
	lights = disk_of(1.0f, 2.0f); /* the roles exchanged: A1 F12 = A2 F21, with the areas A1 = 4 A2 */
	double large = form_factor(&lights, o, x * 0.5f, z * 0.5f, true, y);
	SHADE_PROOF_NEAR(0.25 * large, small, 2e-3, 0.0);
	gi_lights_destroy(&lights);
}

/* ---- densities --------------------------------------------------------------------------------------------------- */

/* A scene with lights of every kind. */
static stilb_scene busy_scene(stilb_scene_light points[4])
{
	points[0] = (stilb_scene_light){
		.kind = STILB_SCENE_LIGHT_POINT, .position = {2.0f, 3.0f, 1.0f}, .intensity = {5.0f, 5.0f, 5.0f}};
	points[1] = (stilb_scene_light){.kind = STILB_SCENE_LIGHT_SPOT,
	                                .position = {-2.0f, 3.0f, 1.0f},
	                                .direction = {0.6f, -0.8f, 0.0f},
	                                .intensity = {9.0f, 9.0f, 9.0f},
	                                .cos_inner = 0.9f,
	                                .cos_outer = 0.7f};
	points[2] = (stilb_scene_light){
		.kind = STILB_SCENE_LIGHT_DIRECTIONAL, .direction = {0.0f, -0.8f, 0.6f}, .intensity = {2.0f, 2.0f, 2.0f}};
	points[3] = (stilb_scene_light){
		.kind = STILB_SCENE_LIGHT_DIRECTIONAL, .direction = {-0.6f, -0.8f, 0.0f}, .intensity = {1.0f, 1.0f, 1.0f}};
	return (stilb_scene){
		.light_count = 4,
		.lights = points,
		.surroundings = {.sky = {0.5f, 0.5f, 0.5f}, .ground = {0.1f, 0.1f, 0.1f}},
	};
}

#define BUSY_TRIANGLES 41

/* Triangles of all sizes around, facing anywhere, and a rectangle. */
static gi_lights busy_lights(gi_emitter emitters[BUSY_TRIANGLES])
{
	static stilb_scene_light points[4];
	stilb_scene scene = busy_scene(points);
	shade_proof_random random = {.seed = 3};
	for (int i = 0; i < BUSY_TRIANGLES; i++) {
		stilb_vec3 p[3];
		float size = shade_proof_log_range(&random, 0.05f, 3.0f);
		for (int k = 0; k < 3; k++)
			for (int axis = 0; axis < 3; axis++) {
				p[k][axis] = k ? p[0][axis] : shade_proof_range(&random, -5.0f, 5.0f);
				p[k][axis] += k ? shade_proof_range(&random, -size, size) : 0.0f;
			}
		emitters[i] = triangle(p[0], p[1], p[2], shade_proof_log_range(&random, 0.1f, 10.0f));
	}
	quad(emitters + 7, vec(1.0f, 4.0f, 1.0f), vec(1.0f, 0.0f, 0.0f), vec(0.0f, 0.0f, 2.0f), 4.0f);
	return lights_of(&scene, emitters, BUSY_TRIANGLES);
}

/* Which emitter a sample lies on: the one whose plane and triangle its end is in. */
static int emitter_at(const gi_emitter *emitters, stilb_vec3 position, stilb_vec3 direction, float *distance)
{
	int found = -1;
	double nearest = 1e-3;
	for (int i = 0; i < BUSY_TRIANGLES; i++) {
		const float(*p)[3] = emitters[i].position;
		stilb_vec3 a = vec(p[0][0], p[0][1], p[0][2]), e1 = vec(p[1][0], p[1][1], p[1][2]) - a;
		stilb_vec3 e2 = vec(p[2][0], p[2][1], p[2][2]) - a, normal = stilb_vec3_cross(e1, e2);
		float t = stilb_vec3_dot(a - position, normal) / stilb_vec3_dot(direction, normal);
		stilb_vec3 q = position + direction * t - a;
		float area2 = stilb_vec3_dot(normal, normal);
		float v = stilb_vec3_dot(stilb_vec3_cross(q, e2), normal) / area2;
		float w = stilb_vec3_dot(stilb_vec3_cross(e1, q), normal) / area2;
		double off = fabs((double)(t / *distance - 1.0f));
		if (stilb_vec3_dot(direction, normal) < 0.0f && v > -1e-3f && w > -1e-3f && v + w < 1.001f && off < nearest) {
			found = i;
			nearest = off;
			*distance = t;
		}
	}
	return found;
}

/* The density that a light sample comes with is what gi_light_pdf and gi_environment_pdf give for its direction; and
 * its distance is a little less than the distance to the light, so that a shadow ray does not hit the light. */
static void density_of_a_sample_is_that_of_its_direction(void **state)
{
	(void)state;
	gi_emitter emitters[BUSY_TRIANGLES];
	gi_lights lights = busy_lights(emitters);
	shade_proof_random random = {.seed = 4};
	int surfaces = 0, skies = 0, deltas = 0;
	for (uint32_t i = 0; i < 20000; i++) {
		stilb_vec3 position = vec(shade_proof_range(&random, -4.0f, 4.0f), shade_proof_range(&random, -4.0f, 4.0f),
		                          shade_proof_range(&random, -4.0f, 4.0f));
		stilb_vec2 u = {shade_proof_uniform(&random), shade_proof_uniform(&random)};
		stilb_vec3 normal = shade_sample_sphere((stilb_vec2){shade_proof_uniform(&random), u[0]}).direction;
		gi_light_sample sample;
		gi_light_group group = (gi_light_group)(i % GI_LIGHT_GROUPS);
		if (!gi_light_sample_at(&lights, group, true, position, normal, shade_proof_uniform(&random), u, &sample))
			continue;
		assert_true(sample.pdf > 0.0f && isfinite(sample.pdf));
		SHADE_PROOF_NEAR(length_of(sample.direction), 1.0, 1e-6, 0.0);
		if (sample.delta) {
			deltas++;
		} else if (isinf(sample.distance)) {
			skies++;
			SHADE_PROOF_NEAR(gi_environment_pdf(&lights, normal, sample.direction, true), sample.pdf, 1e-4, 1e-6);
		} else {
			float distance = sample.distance;
			int emitter = emitter_at(emitters, position, sample.direction, &distance);
			if (emitter < 0) /* grazing: the plane is met too badly to find it again */
				continue;
			surfaces++;
			assert_true(sample.distance < distance && sample.distance > 0.999f * distance);
			SHADE_PROOF_NEAR(gi_light_pdf(&lights, position, normal, (uint32_t)emitter, distance), sample.pdf, 2e-3,
			                 0.0);
		}
	}
	assert_true(surfaces > 3000 && skies > 1000 && deltas > 3000);
	gi_lights_destroy(&lights);
}

/* The light tree tells the probabilities with which it chooses its leaves, the lights, for a point. They add up to 1,
 * less those of boxes that seemed to hold light for the point and do not; leaves are chosen as often as they say; and
 * every leaf that shines on the point has one above 0. */
static void tree_chooses_with_its_probabilities(void **state)
{
	(void)state;
	gi_emitter emitters[BUSY_TRIANGLES];
	gi_lights lights = busy_lights(emitters);
	assert_int_equal(lights.shape_count, BUSY_TRIANGLES - 1);
	assert_int_equal(lights.placed_count, BUSY_TRIANGLES - 1 + 2);
	shade_proof_random random = {.seed = 5};
	uint32_t nodes = lights.tree.node_count;
	double found = 0.0;
	for (int trial = 0; trial < 40; trial++) {
		stilb_vec3 position = vec(shade_proof_range(&random, -6.0f, 6.0f), shade_proof_range(&random, -6.0f, 6.0f),
		                          shade_proof_range(&random, -6.0f, 6.0f));
		stilb_vec3 normal =
			shade_sample_sphere((stilb_vec2){shade_proof_uniform(&random), shade_proof_uniform(&random)}).direction;
		double sum = 0.0;
		for (uint32_t i = 0; i < nodes; i++) {
			if (lights.tree.nodes[i].child != GI_LIGHT_LEAF)
				continue;
			float chance = gi_light_tree_probability(&lights.tree, position, normal, i);
			sum += (double)chance;
			gi_light_sample sample;
			uint32_t light = lights.tree.nodes[i].light;
			bool lit = light < lights.shape_count &&
			           gi_light_shape_sample(&lights.shapes[light], position, (stilb_vec2){0.3f, 0.6f}, &sample) &&
			           stilb_vec3_dot(normal, sample.direction) > 0.0f;
			assert_true(!lit || chance > 0.0f);
		}
		assert_true(sum < 1.00001);
		found += sum;
		uint32_t chosen[2 * (BUSY_TRIANGLES + 2)] = {0};
		for (uint32_t i = 0; i < 4096; i++) {
			float probability;
			uint32_t leaf =
				gi_light_tree_choose(&lights.tree, position, normal, ((float)i + 0.5f) / 4096.0f, &probability);
			if (leaf == GI_LIGHT_LEAF)
				continue;
			chosen[leaf]++;
			SHADE_PROOF_NEAR(gi_light_tree_probability(&lights.tree, position, normal, leaf), probability, 1e-5, 0.0);
		}
		for (uint32_t i = 0; i < nodes; i++)
			if (lights.tree.nodes[i].child == GI_LIGHT_LEAF)
				SHADE_PROOF_NEAR(chosen[i] / 4096.0, gi_light_tree_probability(&lights.tree, position, normal, i), 0.0,
				                 3.0 / 4096.0);
	}
	assert_true(found > 0.9 * 40);
	gi_lights_destroy(&lights);
}

/* Every instruction set weighs a node's children with the same bits. */
static void children_weigh_the_same_everywhere(void **state)
{
	(void)state;
	gi_emitter emitters[BUSY_TRIANGLES];
	gi_lights lights = busy_lights(emitters);
	shade_proof_random random = {.seed = 6};
	uint32_t weighed = 0;
	for (uint32_t trial = 0; trial < 400; trial++) {
		stilb_vec3 position = vec(shade_proof_range(&random, -6.0f, 6.0f), shade_proof_range(&random, -6.0f, 6.0f),
		                          shade_proof_range(&random, -6.0f, 6.0f));
		stilb_vec3 normal =
			shade_sample_sphere((stilb_vec2){shade_proof_uniform(&random), shade_proof_uniform(&random)}).direction;
		const gi_light_node *node = &lights.tree.nodes[trial % lights.tree.node_count];
		if (node->child == GI_LIGHT_LEAF)
			node = &lights.tree.nodes[0];
		uint32_t eights = (node->child_count + 7) / 8;
		gi_light_weights scalar = {{0.0f}, {0.0f}}, wide = scalar;
		const gi_light_eight *children = &lights.tree.eights[node->eight];
		gi_light_weigh_scalar(children, eights, position, normal, &scalar);
#if defined(__x86_64__)
		if (stilb_cpu_widest_isa() >= STILB_ISA_AVX2)
			gi_light_weigh_avx2(children, eights, position, normal, &wide);
		else
			wide = scalar;
#else
		wide = scalar;
#endif
		assert_memory_equal(&scalar, &wide, sizeof wide);
		for (uint32_t i = node->child_count; i < 8 * eights; i++)
			assert_true(scalar.each[i] == 0.0f);
		for (uint32_t i = 0; i < node->child_count; i++)
			weighed += scalar.each[i] > 0.0f;
	}
	assert_true(weighed > 400);
	gi_lights_destroy(&lights);
}

/* Box and cone of directions of a node of the light tree enclose those of its children, and its power is their sum. */
static void nodes_hold_their_children(void **state)
{
	(void)state;
	gi_emitter emitters[BUSY_TRIANGLES];
	gi_lights lights = busy_lights(emitters);
	for (uint32_t i = 0; i < lights.tree.node_count; i++) {
		const gi_light_node *node = &lights.tree.nodes[i];
		if (node->child == GI_LIGHT_LEAF)
			continue;
		float sum[3] = {0.0f}, lamps = 0.0f, power = 0.0f;
		assert_in_range(node->child_count, 2, GI_LIGHT_CHILDREN);
		for (uint32_t c = node->child; c < node->child + node->child_count; c++) {
			const gi_light_node *child = &lights.tree.nodes[c];
			assert_int_equal(child->parent, i);
			for (int k = 0; k < 3; k++)
				assert_true(child->low[k] >= node->low[k] && child->high[k] <= node->high[k]);
			float between =
				node->axis[0] * child->axis[0] + node->axis[1] * child->axis[1] + node->axis[2] * child->axis[2];
			float angle = acosf(fminf(fmaxf(between, -1.0f), 1.0f)) + acosf(child->cos_cone);
			assert_true(node->cos_cone == -1.0f || angle <= acosf(node->cos_cone) + 1e-4f);
			assert_true(child->cos_beam >= node->cos_beam);
			for (int k = 0; k < 3; k++)
				sum[k] += child->sum[k];
			lamps += child->lamps;
			power += child->power;
		}
		for (int k = 0; k < 3; k++)
			SHADE_PROOF_NEAR(sum[k], node->sum[k], 1e-5, 1e-3);
		SHADE_PROOF_NEAR(lamps, node->lamps, 1e-6, 0.0);
		SHADE_PROOF_NEAR(power, node->power, 1e-6, 0.0);
	}
	gi_lights_destroy(&lights);
}

/* The irradiance from all lights of a scene together is the sum of those of each light alone. */
static void lights_add_up(void **state)
{
	(void)state;
	gi_emitter emitters[BUSY_TRIANGLES];
	static stilb_scene_light points[4];
	gi_lights lights = busy_lights(emitters);
	stilb_vec3 position = vec(0.3f, -0.2f, 0.1f), normal = vec(0.0f, 1.0f, 0.0f);
	double sum = 0.0;
	for (uint32_t i = 0; i < BUSY_TRIANGLES; i++) {
		gi_lights one = lights_of(NULL, &emitters[i], 1);
		sum += irradiance(&one, position, normal, 2048);
		gi_lights_destroy(&one);
	}
	stilb_scene scene = busy_scene(points);
	gi_lights rest = lights_of(&scene, NULL, 0);
	sum += irradiance(&rest, position, normal, 16384);
	SHADE_PROOF_NEAR(irradiance(&lights, position, normal, 65536), sum, 1e-2, 0.0);
	gi_lights_destroy(&rest);
	/* Two suns, of which one is asked, and the sky. */
	scene.light_count = 2;
	scene.lights = &points[2];
	rest = lights_of(&scene, NULL, 0);
	assert_int_equal(rest.sun_count, 2);
	SHADE_PROOF_NEAR(irradiance(&rest, position, normal, 65536), 2.0 * 0.8 + 1.0 * 0.8 + 0.5 * M_PI, 1e-3, 0.0);
	gi_lights_destroy(&rest);
	gi_lights_destroy(&lights);
}

/* ---- lights without a size --------------------------------------------------------------------------------------- */

static void lights_without_a_size_follow_their_formulas(void **state)
{
	(void)state;
	stilb_vec3 up = vec(0.0f, 1.0f, 0.0f);
	stilb_scene_light light = {
		.kind = STILB_SCENE_LIGHT_POINT, .position = {3.0f, 4.0f, 0.0f}, .intensity = {10, 20, 30}};
	stilb_scene scene = {.light_count = 1, .lights = &light};
	gi_light_sample sample;
	gi_lights lights = lights_of(&scene, NULL, 0);
	assert_true(
		gi_light_sample_at(&lights, GI_LIGHT_PLACED, true, vec(0, 0, 0), up, 0.5f, (stilb_vec2){0.5f, 0.5f}, &sample));
	assert_true(sample.delta && sample.pdf == 1.0f && sample.distance == 5.0f);
	SHADE_PROOF_NEAR(sample.radiance[1], 20.0 / 25.0, 1e-6, 0.0);
	SHADE_PROOF_NEAR(sample.direction[0], 0.6, 1e-6, 0.0);
	gi_lights_destroy(&lights);

	light = (stilb_scene_light){.kind = STILB_SCENE_LIGHT_SPOT,
	                            .position = {0.0f, 2.0f, 0.0f},
	                            .direction = {0.0f, -1.0f, 0.0f},
	                            .intensity = {8.0f, 8.0f, 8.0f},
	                            .cos_inner = cosf(0.3f),
	                            .cos_outer = cosf(0.5f)};
	lights = lights_of(&scene, NULL, 0);
	double before = 1e9;
	for (float angle = 0.0f; angle < 0.6f; angle += 0.01f) { /* full, then falling without a step, then nothing */
		stilb_vec3 position = vec(2.0f * tanf(angle), 0.0f, 0.0f);
		double intensity = 0.0;
		if (gi_light_sample_at(&lights, GI_LIGHT_PLACED, true, position, up, 0.5f, (stilb_vec2){0.5f, 0.5f}, &sample))
			intensity = (double)(sample.radiance[0] * sample.distance * sample.distance);
		if (angle < 0.295f)
			SHADE_PROOF_NEAR(intensity, 8.0, 1e-5, 0.0);
		else
			assert_true(intensity <= before && before - intensity < 1.0);
		assert_true(angle < 0.505f || intensity == 0.0);
		before = intensity;
	}
	/* The intensity falls as t^2 (3 - 2 t), with t from 1 at cos_inner to 0 at cos_outer; here t = 1/4. */
	float quarter = acosf(light.cos_outer + 0.25f * (light.cos_inner - light.cos_outer));
	assert_true(gi_light_sample_at(&lights, GI_LIGHT_PLACED, true, vec(2.0f * tanf(quarter), 0, 0), up, 0.5f,
	                               (stilb_vec2){0.5f, 0.5f}, &sample));
	SHADE_PROOF_NEAR(sample.radiance[0] * sample.distance * sample.distance, 8.0 * 0.15625, 1e-4, 0.0);
	gi_lights_destroy(&lights);

	light = (stilb_scene_light){
		.kind = STILB_SCENE_LIGHT_DIRECTIONAL, .direction = {0.0f, -0.6f, -0.8f}, .intensity = {1.0f, 2.0f, 3.0f}};
	lights = lights_of(&scene, NULL, 0);
	assert_true(
		gi_light_sample_at(&lights, GI_LIGHT_SUNS, true, vec(9, 9, 9), up, 0.5f, (stilb_vec2){0.5f, 0.5f}, &sample));
	assert_true(sample.delta && sample.pdf == 1.0f && isinf(sample.distance) && sample.radiance[2] == 3.0f);
	SHADE_PROOF_NEAR(sample.direction[2], 0.8, 1e-6, 0.0);
	gi_lights_destroy(&lights);
}

/* Of three suns each is chosen as often as its samples say, by Pearson's chi-square over independent numbers, which
 * must be within four standard deviations; and together they give the sum. */
static void suns_are_chosen_with_their_probabilities(void **state)
{
	(void)state;
	stilb_scene_light suns[3] = {{.direction = {0.0f, -1.0f, 0.0f}, .intensity = {1.0f, 1.0f, 1.0f}},
	                             {.direction = {0.0f, -0.6f, -0.8f}, .intensity = {4.0f, 4.0f, 4.0f}},
	                             {.direction = {0.8f, 0.6f, 0.0f}, .intensity = {9.0f, 9.0f, 9.0f}}};
	stilb_scene scene = {.light_count = 3, .lights = suns};
	enum { COUNT = 30000 };
	for (int i = 0; i < 3; i++)
		suns[i].kind = STILB_SCENE_LIGHT_DIRECTIONAL;
	gi_lights lights = lights_of(&scene, NULL, 0);
	shade_proof_random random = {.seed = 9};
	uint32_t seen[3] = {0};
	double chance[3] = {0.0}, chi = 0.0;
	for (uint32_t k = 0; k < COUNT; k++) {
		gi_light_sample sample;
		assert_true(gi_light_sample_at(&lights, GI_LIGHT_SUNS, true, vec(0, 0, 0), vec(0, 1, 0),
		                               shade_proof_uniform(&random), (stilb_vec2){0.5f, 0.5f}, &sample));
		int sun = sample.radiance[0] == 1.0f ? 0 : sample.radiance[0] == 4.0f ? 1 : 2;
		seen[sun]++;
		chance[sun] = (double)sample.pdf;
	}
	SHADE_PROOF_NEAR(chance[0] + chance[1] + chance[2], 1.0, 1e-6, 0.0);
	for (int i = 0; i < 3; i++)
		chi += (seen[i] - chance[i] * COUNT) * (seen[i] - chance[i] * COUNT) / (chance[i] * COUNT);
	assert_true(chi < 2.0 + 4.0 * sqrt(2.0 * 2.0));
	SHADE_PROOF_NEAR(irradiance(&lights, vec(0, 0, 0), vec(0, 1, 0), 1 << 14), 1.0 + 4.0 * 0.6, 1e-3, 0.0);
	gi_lights_destroy(&lights);
}

/* Lights with a size: irradiance against closed forms. A sphere above the horizon gives I / d^2 times the cosine to its
 * centre; from a point in its surface half of it is seen; a disk and a rectangle that faces give Foote's and Lambert's
 * values; a falloff takes its share. */
static void listed_lights_with_a_size_follow_their_formulas(void **state)
{
	(void)state;
	stilb_vec3 o = vec(0, 0, 0), up = vec(0.0f, 1.0f, 0.0f);
	stilb_scene_light light = {.kind = STILB_SCENE_LIGHT_SPHERE,
	                           .position = {3.0f, 4.0f, 0.0f},
	                           .direction = {0.0f, -1.0f, 0.0f},
	                           .intensity = {10, 20, 30},
	                           .radius = 1.5f};
	stilb_scene scene = {.light_count = 1, .lights = &light};
	gi_lights lights = lights_of(&scene, NULL, 0);
	double sphere = irradiance(&lights, o, up, 4096);
	SHADE_PROOF_NEAR(sphere, 10.0 / 25.0 * 0.8, 1e-3, 0.0);
	gi_lights_destroy(&lights);
	for (int falloff = STILB_SCENE_LIGHT_WINDOWED; falloff < STILB_SCENE_LIGHT_FALLOFFS; falloff++) {
		light.falloff = (stilb_scene_light_falloff)falloff;
		light.reach = 10.0f;
		lights = lights_of(&scene, NULL, 0);
		static const double shares[STILB_SCENE_LIGHT_FALLOFFS] = {[STILB_SCENE_LIGHT_WINDOWED] = 0.75 * 0.75,
		                                                          [STILB_SCENE_LIGHT_SUBTRACTED] = 0.75,
		                                                          [STILB_SCENE_LIGHT_RANGED] = 1.0 - 0.25 * 0.25};
		SHADE_PROOF_NEAR(irradiance(&lights, o, up, 4096), shares[falloff] * sphere, 1e-5, 0.0);
		gi_lights_destroy(&lights);
	}
	light.falloff = STILB_SCENE_LIGHT_PHYSICAL;
	light.kind = STILB_SCENE_LIGHT_DISK;
	light.position[0] = 0.0f;
	lights = lights_of(&scene, NULL, 0);
	SHADE_PROOF_NEAR(irradiance(&lights, o, up, 4096), 10.0 / (16.0 + 2.25), 1e-3, 0.0); /* pi L r^2 / (h^2 + r^2) */
	assert_true(irradiance(&lights, vec(0, 5, 0), up * -1.0f, 64) == 0.0);               /* behind it */
	gi_lights_destroy(&lights);
	light.kind = STILB_SCENE_LIGHT_RECTANGLE;
	light.half_x[0] = 2.0f;
	light.half_y[2] = 1.0f;
	for (int turned = 0; turned < 2; turned++) {
		light.half_y[2] = turned ? -1.0f : 1.0f; /* either way it shines along direction */
		lights = lights_of(&scene, NULL, 0);
		/* Of each quarter: L / 2 (A / X atan(B / X) + B / Y atan(A / Y)), A and B: side / height, X^2 = 1 + A^2. */
		double a = 0.5, b = 0.25, x = sqrt(1.0 + a * a), y = sqrt(1.0 + b * b);
		double corner = 0.5 * (a / x * atan(b / x) + b / y * atan(a / y));
		SHADE_PROOF_NEAR(irradiance(&lights, o, up, 4096), 10.0 / 8.0 * 4.0 * corner, 1e-3, 0.0);
		assert_true(irradiance(&lights, vec(0, 5, 0), up * -1.0f, 64) == 0.0);
		gi_lights_destroy(&lights);
	}
}

/* A light with a face is left out, since the face's triangles emit its light. */
static void lights_with_a_face_count_once(void **state)
{
	(void)state;
	stilb_scene_light light = {.intensity = {1, 1, 1}, .position = {0, 2, 0}, .face = 1};
	stilb_scene scene = {.light_count = 1, .lights = &light};
	gi_lights lights = lights_of(&scene, NULL, 0);
	assert_int_equal(lights.listed_count, 0);
	gi_lights_destroy(&lights);
}

/* ---- surroundings ------------------------------------------------------------------------------------------------ */

/* The irradiance from a sky of radiance 1 on a level receiver is pi; with everything below the elevation a hidden it is
 * pi cos^2 a. */
static void raised_horizon_leaves_a_squared_cosine(void **state)
{
	(void)state;
	stilb_scene scene = {.surroundings = {.sky = {1.0f, 1.0f, 1.0f}, .ground = {1.0f, 1.0f, 1.0f}}};
	stilb_vec3 up = vec(0.0f, 1.0f, 0.0f);
	gi_lights lights = lights_of(&scene, NULL, 0);
	for (double a = 0.0; a < 1.5; a += 0.3) {
		double sum = 0.0;
		for (uint32_t i = 0; i < 1 << 17; i++) {
			gi_light_sample sample;
			if (gi_light_sample_at(&lights, GI_LIGHT_AROUND, true, vec(0, 0, 0), up, 0.5f,
			                       gi_sample_2d(&sampler, numbered(29, i), 0), &sample) &&
			    (double)sample.direction[1] > sin(a))
				sum += (double)(sample.radiance[0] * sample.direction[1] / sample.pdf);
		}
		SHADE_PROOF_NEAR(sum / (1 << 17), M_PI * cos(a) * cos(a), 1e-3, 0.0);
	}
	gi_lights_destroy(&lights);
}

/* Surroundings of two colours are asked only where nobody says that rays find them, and their density says the same. */
static void an_even_sky_is_left_to_rays(void **state)
{
	(void)state;
	stilb_scene scene = {.surroundings = {.sky = {1.0f, 1.0f, 1.0f}}};
	stilb_vec3 up = vec(0.0f, 1.0f, 0.0f), slant = vec(0.6f, 0.8f, 0.0f);
	gi_lights lights = lights_of(&scene, NULL, 0);
	assert_true(gi_light_is_asked(&lights, GI_LIGHT_AROUND, true));
	assert_false(gi_light_is_asked(&lights, GI_LIGHT_AROUND, false));
	SHADE_PROOF_NEAR(gi_environment_pdf(&lights, up, slant, true), 0.8 / M_PI, 1e-6, 0.0);
	assert_true(gi_environment_pdf(&lights, up, slant, false) == 0.0f);
	gi_lights_destroy(&lights);
}

static stilb_image map_of(uint32_t width, uint32_t height, uint32_t channels)
{
	stilb_image map;
	assert_int_equal(stilb_image_create(&map, width, height, channels, STILB_IMAGE_F32_LINEAR), STILB_OK);
	return map;
}

/* A sky of radiance 1 in the hemisphere +Y and 0 below, given as two colours and as a map. A receiver whose normal has
 * the angle t to +Y gets the irradiance pi / 2 (1 + cos t). Light samples of the map, projected onto the 9 spherical
 * harmonics sh, give their integrals over the hemisphere: sqrt(pi) for the constant sh[0], 0.488603 pi for sh[1], the
 * linear one along Y (whose sign is a convention), and 0 for all others. */
static void hemisphere_of_sky_has_its_closed_form(void **state)
{
	(void)state;
	stilb_scene two = {.surroundings = {.sky = {1.0f, 1.0f, 1.0f}}};
	stilb_scene mapped = {.surroundings = {.panorama = map_of(64, 32, 3)}};
	for (uint32_t i = 0; i < 64 * 16 * 3; i++)
		((float *)mapped.surroundings.panorama.pixels)[i] = 1.0f;
	for (int kind = 0; kind < 2; kind++) {
		gi_lights lights = lights_of(kind ? &mapped : &two, NULL, 0);
		for (float t = 0.0f; t <= 3.1f; t += 0.5f) {
			double want = M_PI / 2.0 * (1.0 + cos((double)t));
			SHADE_PROOF_NEAR(irradiance(&lights, vec(0, 0, 0), vec(0.0f, cosf(t), sinf(t)), 1 << 17), want, 1e-3, 1e-4);
		}
		gi_lights_destroy(&lights);
	}
	gi_lights lights = lights_of(&mapped, NULL, 0);
	double sh[9] = {0.0};
	for (uint32_t i = 0; i < 16384; i++) {
		gi_light_sample sample;
		stilb_vec2 u = gi_sample_2d(&sampler, numbered(31, i), 0);
		assert_true(gi_light_sample_at(&lights, GI_LIGHT_AROUND, true, vec(0, 0, 0), vec(0, 1, 0), 0.5f, u, &sample));
		shade_sh basis = shade_sh_basis(sample.direction);
		for (int k = 0; k < 9; k++)
			sh[k] += (double)(basis.c[k] * sample.radiance[0] / sample.pdf) / 16384.0;
	}
	SHADE_PROOF_NEAR(sh[0], sqrt(M_PI), 1e-5, 0.0);
	SHADE_PROOF_NEAR(fabs(sh[1]), 0.488603 * M_PI, 1e-4, 0.0);
	for (int k = 2; k < 9; k++)
		SHADE_PROOF_NEAR(sh[k], 0.0, 0.0, 1e-3);
	gi_lights_destroy(&lights);
	stilb_image_finish(&mapped.surroundings.panorama);
}

/* A map turned by k columns is the same as one whose columns lie k farther to the left: for looks and samples. */
static void a_turned_map_is_a_shifted_one(void **state)
{
	(void)state;
	enum { W = 16, H = 8, K = 3 };
	stilb_scene turned = {.surroundings = {.panorama = map_of(W, H, 3), .rotation = 2.0f * (float)M_PI * K / W}};
	stilb_scene shifted = {.surroundings = {.panorama = map_of(W, H, 3)}};
	float *from = turned.surroundings.panorama.pixels, *to = shifted.surroundings.panorama.pixels;
	for (uint32_t i = 0; i < W * H * 3; i++)
		from[i] = stilb_random_float(3, i);
	for (uint32_t y = 0; y < H; y++)
		for (uint32_t x = 0; x < W; x++)
			memcpy(to + 3 * (y * W + (x + W - K) % W), from + 3 * (y * W + x), 3 * sizeof *to);
	gi_lights one = lights_of(&turned, NULL, 0), other = lights_of(&shifted, NULL, 0);
	for (uint32_t i = 0; i < W * H; i++) { /* the middles of the texels */
		float phi = 2.0f * (float)M_PI * ((float)(i % W) + 0.5f) / W, theta = (float)M_PI * ((float)(i / W) + 0.5f) / H;
		stilb_vec3 d = vec(sinf(theta) * sinf(phi), cosf(theta), -sinf(theta) * cosf(phi));
		stilb_vec3 a = gi_environment_radiance(&one, d), b = gi_environment_radiance(&other, d);
		assert_true(a[0] == b[0] && a[1] == b[1] && a[2] == b[2]);
	}
	stilb_vec3 slant = vec(0.6f, 0.0f, 0.8f);
	SHADE_PROOF_NEAR(irradiance(&one, vec(0, 0, 0), slant, 1 << 15), irradiance(&other, vec(0, 0, 0), slant, 1 << 15),
	                 5e-3, 0.0);
	gi_lights_destroy(&one);
	gi_lights_destroy(&other);
	stilb_image_finish(&turned.surroundings.panorama);
	stilb_image_finish(&shifted.surroundings.panorama);
}

/* A map with a sun 1e5 times as bright as its dim and partly black sky: the light samples, projected onto spherical
 * harmonics, give the coefficients of the exact integral over the map, radiance over density is the same for all
 * samples, densities integrate to 1, and each texel is chosen as often as it should. */
static void map_is_chosen_by_its_brightness(void **state)
{
	(void)state;
	enum { W = 32, H = 16 };
	stilb_scene scene = {.surroundings = {.panorama = map_of(W, H, 3)}};
	float *texels = scene.surroundings.panorama.pixels;
	for (uint32_t i = 0; i < W * H * 3; i++)
		texels[i] = i / 3 % 5 == 0 ? 0.0f : stilb_random_float(8, i / 3) * (float)(1 + i % 3);
	texels[3 * (3 * W + 20) + 1] = 1e5f;
	gi_lights lights = lights_of(&scene, NULL, 0);
	stilb_vec3 o = {0}, up = vec(0.0f, 1.0f, 0.0f);
	float mean = lights.environment->mean;
	double whole[2] = {0.0, 0.0}, chosen[2][W * H] = {{0.0}};
	shade_sh_rgb want;
	assert_int_equal(stilb_numeric_sh_project_map(&scene.surroundings.panorama, &want), STILB_OK);
	double have[9] = {0.0};
	uint32_t count = 65536;
	for (uint32_t i = 0; i < 2 * count; i++) {
		gi_light_sample sample;
		bool all = i < count;
		stilb_vec2 u = gi_sample_2d(&sampler, numbered(37, i % count), 0);
		assert_true(gi_light_sample_at(&lights, GI_LIGHT_AROUND, all, o, up, 0.5f, u, &sample));
		SHADE_PROOF_NEAR(gi_environment_pdf(&lights, up, sample.direction, all), sample.pdf, 1e-5, 0.0);
		assert_true(all || gi_brightness(sample.radiance) > mean);
		stilb_vec3 radiance = gi_environment_radiance(&lights, sample.direction);
		assert_true(radiance[0] == sample.radiance[0] && radiance[2] == sample.radiance[2]);
		double u_at = atan2((double)sample.direction[0], -(double)sample.direction[2]) / (2.0 * M_PI) + 0.5;
		double v_at = acos((double)sample.direction[1]) / M_PI;
		chosen[all][(int)(v_at * H) * W + (int)fmin(u_at * W, W - 1)] += 1.0 / count;
		shade_sh basis = shade_sh_basis(sample.direction);
		for (int k = 0; all && k < 9; k++)
			have[k] += (double)(basis.c[k] * sample.radiance[1] / sample.pdf) / count;
	}
	for (int k = 0; k < 9; k++)
		SHADE_PROOF_NEAR(have[k], want.g.c[k], 2e-3, 2e-3 * (double)want.g.c[0]);
	for (uint32_t i = 0; i < 2 * W * H; i++) {
		uint32_t all = i / (W * H), y = i / W % H, x = i % W;
		double d[3], solid = 2.0 * M_PI / W * (cos(M_PI * y / H) - cos(M_PI * (y + 1.0) / H));
		stilb_numeric_latlong_direction((x + 0.5) / W, (y + 0.5) / H, d);
		double share = solid * (double)gi_environment_pdf(&lights, up, vec((float)d[0], (float)d[1], (float)d[2]), all);
		whole[all] += share;
		SHADE_PROOF_NEAR(chosen[all][y * W + x], share, 0.0, 40.0 / count);
	}
	SHADE_PROOF_NEAR(whole[0], 1.0, 1e-5, 0.0);
	SHADE_PROOF_NEAR(whole[1], 1.0, 1e-5, 0.0);
	gi_lights_destroy(&lights);
	stilb_image_finish(&scene.surroundings.panorama);
}

/* ---- what files hold --------------------------------------------------------------------------------------------- */

static void maps_with_odd_numbers_are_read_as_light(void **state)
{
	(void)state;
	stilb_scene scene = {.surroundings = {.panorama = map_of(8, 4, 1)}};
	float *texels = scene.surroundings.panorama.pixels;
	for (int i = 0; i < 32; i++)
		texels[i] = 1.0f;
	texels[3] = NAN;
	texels[9] = -5.0f;
	texels[20] = INFINITY;
	gi_lights lights = lights_of(&scene, NULL, 0);
	for (uint32_t i = 0; i < 100; i++) {
		gi_light_sample sample;
		assert_true(gi_light_sample_at(&lights, GI_LIGHT_AROUND, true, vec(0, 0, 0), vec(0, 1, 0), 0.5f,
		                               (stilb_vec2){stilb_random_float(1, i), stilb_random_float(2, i)}, &sample));
		assert_true(isfinite(sample.radiance[0]) && sample.radiance[0] > 0.0f && isfinite(sample.pdf));
	}
	gi_lights_destroy(&lights);
	for (int i = 0; i < 32; i++)
		texels[i] = NAN;
	lights = lights_of(&scene, NULL, 0);
	assert_false(gi_light_is_asked(&lights, GI_LIGHT_AROUND, true));
	assert_true(gi_environment_pdf(&lights, vec(0, 1, 0), vec(0, 1, 0), true) == 0.0f);
	gi_lights_destroy(&lights);
	stilb_image_finish(&scene.surroundings.panorama);

	stilb_scene bytes = {0};
	assert_int_equal(stilb_image_create(&bytes.surroundings.panorama, 4, 2, 3, STILB_IMAGE_U8_SRGB), STILB_OK);
	assert_int_equal(gi_lights_create(&bytes, NULL, 0, &lights), STILB_ERROR_ARGUMENT);
	assert_non_null(strstr(stilb_error_message(), "environment map"));
	gi_lights_destroy(&lights);
	stilb_image_finish(&bytes.surroundings.panorama);
}

void *__real_aligned_alloc(size_t alignment, size_t size);
void *__wrap_aligned_alloc(size_t alignment, size_t size);

static int allocations_left = -1; /* until one fails; -1: none does */

void *__wrap_aligned_alloc(size_t alignment, size_t size)
{
	return allocations_left >= 0 && allocations_left-- == 0 ? NULL : __real_aligned_alloc(alignment, size);
}

/* Each allocation of gi_lights_create fails once, which gives a message and leaves no memory behind (the address
 * sanitizer would see it). */
static void no_memory_is_an_error(void **state)
{
	(void)state;
	stilb_scene scene = {.surroundings = {.panorama = map_of(4, 2, 3)}};
	gi_emitter emitter = triangle(vec(0, 0, 0), vec(1, 0, 0), vec(0, 1, 0), 1.0f);
	gi_lights lights;
	int failures = 0;
	stilb_result result;
	do {
		allocations_left = failures;
		result = gi_lights_create(&scene, &emitter, 1, &lights);
		assert_true(result == STILB_OK || (result == STILB_ERROR_MEMORY && !lights.environment && !lights.tree.nodes));
		failures += result != STILB_OK;
	} while (result != STILB_OK);
	allocations_left = -1;
	assert_int_equal(failures, 14);
	gi_lights_destroy(&lights);
	stilb_image_finish(&scene.surroundings.panorama);
}

static void lights_that_give_nothing_are_never_asked(void **state)
{
	(void)state;
	stilb_scene_light dark = {.kind = STILB_SCENE_LIGHT_POINT}, odd = {.intensity = {NAN, 1.0f, 1.0f}};
	stilb_scene_light points[] = {dark, odd};
	stilb_scene scene = {.light_count = 2, .lights = points};
	const gi_emitter emitters[] = {
		triangle(vec(0, 1, 0), vec(0, 1, 0), vec(1, 1, 0), 1.0f),                  /* no area */
		triangle(vec(0, 1, 0), vec(1, 1, 0), vec(2, 1, 0), 1.0f),                  /* a line */
		triangle(vec(0, 1, 0), vec(1, 1, 0), vec(0, 1, 1), 0.0f),                  /* black */
		triangle(vec(0, 1e30f, 0), vec(1e30f, 1e30f, 0), vec(0, 1e30f, 1e30f), 1), /* its area is no number */
	};
	gi_lights lights = lights_of(&scene, emitters, 4);
	for (gi_light_group group = 0; group < GI_LIGHT_GROUPS; group++)
		assert_false(gi_light_is_asked(&lights, group, true));
	for (uint32_t i = 0; i < 4; i++)
		assert_true(gi_light_pdf(&lights, vec(0, 0, 0), vec(0, 1, 0), i, 1.0f) == 0.0f);
	gi_lights_destroy(&lights);
	gi_lights_destroy(&(gi_lights){0});
}

/* Two triangles are joined to one shape only where together they are a rectangle. */
static void only_rectangles_are_joined(void **state)
{
	(void)state;
	stilb_vec3 o = {0}, x = vec(2, 0, 0), y = vec(0, 1, 0);
	gi_light_shape shape;
	gi_emitter pair[2];
	quad(pair, o, x, y, 1.0f);
	for (int turn = 0; turn < 3; turn++) { /* whichever corner comes first */
		gi_emitter turned = pair[1];
		for (int i = 0; i < 3; i++)
			memcpy(turned.position[i], pair[1].position[(i + turn) % 3], sizeof turned.position[i]);
		assert_true(gi_light_shape_join(&pair[0], &turned, &shape));
		SHADE_PROOF_NEAR(shape.area, 2.0, 1e-6, 0.0);
		assert_true(shape.rectangle && shape.normal[2] == 1.0f);
		SHADE_PROOF_NEAR(shape.center[0], 1.0, 1e-6, 0.0);
	}
	gi_emitter other = pair[1];
	other.emission[1] = 2.0f; /* of another colour */
	assert_false(gi_light_shape_join(&pair[0], &other, &shape));
	other = triangle(o, y, x + y, 1.0f); /* of another front */
	assert_false(gi_light_shape_join(&pair[0], &other, &shape));
	other = triangle(o, x + y, y + vec(0, 0, 0.1f), 1.0f); /* folded */
	assert_false(gi_light_shape_join(&pair[0], &other, &shape));
	quad(pair, o, x, y + x * 0.01f, 1.0f); /* askew */
	assert_false(gi_light_shape_join(&pair[0], &pair[1], &shape));
	quad(pair, o, x, y, 1.0f);
	other = triangle(x + y, x + y + x, x + y + y, 1.0f); /* a corner in common */
	assert_false(gi_light_shape_join(&pair[0], &other, &shape));
	assert_false(gi_light_shape_join(&pair[0], &pair[0], &shape));
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(irradiance_is_lamberts),
		cmocka_unit_test(patch_of_a_sphere_lights_its_inside_evenly),
		cmocka_unit_test(ball_is_seen_as_a_disk),
		cmocka_unit_test(form_factors_of_rectangles),
		cmocka_unit_test(form_factors_of_disks_and_reciprocity),
		cmocka_unit_test(density_of_a_sample_is_that_of_its_direction),
		cmocka_unit_test(tree_chooses_with_its_probabilities),
		cmocka_unit_test(children_weigh_the_same_everywhere),
		cmocka_unit_test(nodes_hold_their_children),
		cmocka_unit_test(lights_add_up),
		cmocka_unit_test(lights_without_a_size_follow_their_formulas),
		cmocka_unit_test(suns_are_chosen_with_their_probabilities),
		cmocka_unit_test(listed_lights_with_a_size_follow_their_formulas),
		cmocka_unit_test(lights_with_a_face_count_once),
		cmocka_unit_test(raised_horizon_leaves_a_squared_cosine),
		cmocka_unit_test(hemisphere_of_sky_has_its_closed_form),
		cmocka_unit_test(an_even_sky_is_left_to_rays),
		cmocka_unit_test(a_turned_map_is_a_shifted_one),
		cmocka_unit_test(map_is_chosen_by_its_brightness),
		cmocka_unit_test(maps_with_odd_numbers_are_read_as_light),
		cmocka_unit_test(no_memory_is_an_error),
		cmocka_unit_test(lights_that_give_nothing_are_never_asked),
		cmocka_unit_test(only_rectangles_are_joined),
	};
	return cmocka_run_group_tests(tests, make_sampler, NULL);
}
