/* A scene is written and read back the same; a damaged stream gives a scene that can be used or an error. */
#include "scene/edit/scene_variant.h"
#include "scene/open/scene_stream.h"
#include "scene/scene_animation_internal.h"
#include "scene/scene_internal.h"
#include "support/test.h"

#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

/* The bytes of a scene, to be freed. */
static unsigned char *bytes_of(const stilb_scene *scene, size_t *size)
{
	FILE *file = tmpfile();
	assert_true(scene_stream_write(fileno(file), scene));
	*size = (size_t)lseek(fileno(file), 0, SEEK_END);
	unsigned char *bytes = malloc(*size);
	assert_int_equal(pread(fileno(file), bytes, *size, 0), *size);
	fclose(file);
	return bytes;
}

static stilb_result read_bytes(const unsigned char *bytes, size_t size, stilb_scene **scene)
{
	FILE *file = tmpfile();
	assert_int_equal(pwrite(fileno(file), bytes, size, 0), size);
	scene_stream stream = {.file = fileno(file), .deadline_ns = UINT64_MAX};
	stilb_image texture = {0};
	stilb_image_create(&texture, 3, 2, 3, STILB_IMAGE_U8_SRGB); /* as in the scene of make() */
	stilb_result result = scene_stream_read(&stream, &texture, 1, scene);
	assert_null(texture.pixels);
	fclose(file);
	return result;
}

/* A small scene with one of everything. */
static stilb_scene *make(void)
{
	stilb_scene *scene;
	assert_int_equal(stilb_scene_open("furnace:0.5", &scene), STILB_OK);
	scene->light_count = 1;
	scene->lights = calloc(1, sizeof *scene->lights);
	scene->lights[0] = (stilb_scene_light){.kind = STILB_SCENE_LIGHT_SPOT,
	                                       .direction = {0, 1, 0},
	                                       .intensity = {1, 2, 3},
	                                       .cos_inner = 0.75f,
	                                       .cos_outer = 0.5f};
	assert_int_equal(scene_add_cameras(scene, 1), STILB_OK);
	scene->cameras[0] = (stilb_scene_named_camera){.name = "Front", .camera = scene->camera};
	scene->texture_count = 1;
	scene->textures = calloc(1, sizeof *scene->textures);
	assert_int_equal(stilb_image_create(scene->textures, 3, 2, 3, STILB_IMAGE_U8_SRGB), STILB_OK);
	((uint8_t *)scene->textures[0].pixels)[7] = 99;
	scene->materials[0].diffuse_texture = 1;
	scene->surroundings.ground[1] = 0.25f;
	assert_int_equal(scene_add_surfaces(scene, 1), STILB_OK);
	scene->surfaces[0] = stilb_scene_surface_make();
	scene->surfaces[0].maps[STILB_SCENE_MAP_NORMAL].texture = 1;
	assert_int_equal(scene_mesh_add_extras(&scene->meshes[0]), STILB_OK);
	scene->meshes[0].extras[1].uv[1] = 0.375f;
	assert_int_equal(scene_add_variants(scene, 2), STILB_OK);
	strcpy(scene->variants->names[1], "blue");
	assert_int_equal(scene_add_nodes(scene, 3), STILB_OK);
	for (uint32_t n = 0; n < 3; n++) {
		scene->nodes.parent[n] = n == 0 ? STILB_SCENE_NONE : 0;
		scene->nodes.pose[n] = stilb_scene_pose_identity();
		scene->nodes.local[n] = stilb_mat4_scale_translate(2.0f, 1.0f, (float)n, 0.0f);
	}
	strcpy(scene->nodes.name[2], "hand\tle");
	scene->model_node[0] = 3;
	scene_set_model_flags(scene, 0, STILB_SCENE_MODEL_UNSEEN | STILB_SCENE_MODEL_RECEIVES_NO_SHADOW);
	assert_int_equal(scene_add_mounts(&scene->light_mounts, 1), STILB_OK);
	assert_int_equal(scene_add_mounts(&scene->camera_mounts, 1), STILB_OK);
	scene->light_mounts[0] = scene_mount_of_light(&scene->lights[0], 2);
	scene->camera_mounts[0] = scene_mount_of_camera(&scene->cameras[0].camera, 3);
	return scene;
}

static void a_scene_comes_back_the_same(void **state)
{
	(void)state;
	stilb_scene *scene = make(), *back;
	size_t size, again;
	unsigned char *bytes = bytes_of(scene, &size);
	assert_int_equal(read_bytes(bytes, size, &back), STILB_OK);
	assert_memory_equal(back->meshes[0].vertices, scene->meshes[0].vertices,
	                    scene->meshes[0].vertex_count * sizeof *scene->meshes[0].vertices);
	assert_memory_equal(back->meshes[0].extras, scene->meshes[0].extras,
	                    scene->meshes[0].vertex_count * sizeof *scene->meshes[0].extras);
	assert_memory_equal(back->surfaces, scene->surfaces, sizeof *scene->surfaces);
	assert_memory_equal(back->lights, scene->lights, sizeof *scene->lights);
	assert_memory_equal(back->materials, scene->materials, sizeof *scene->materials);
	assert_memory_equal(back->cameras, scene->cameras, sizeof *scene->cameras);
	assert_memory_equal(&back->camera, &scene->cameras[0].camera, sizeof scene->camera);
	assert_int_equal(back->textures[0].width, 3);
	assert_int_equal(back->variants->count, 2);
	assert_string_equal(back->variants->names[1], "blue");
	assert_int_equal(back->nodes.count, 3);
	assert_string_equal(back->nodes.name[2], "hand le"); /* what could move a terminal's cursor is gone */
	assert_memory_equal(back->nodes.pose, scene->nodes.pose, 3 * sizeof *scene->nodes.pose);
	assert_true(back->model_node[0] == 3 && back->nodes.to_world[2].m[13] == 2.0f * 2.0f + 0.0f);
	assert_true(back->nodes.to_world[2].m[0] == 4.0f && back->nodes.to_world[2].m[12] == 3.0f);
	assert_true(back->model_flags[0] == 5 && back->flags_used == 5);
	assert_memory_equal(back->light_mounts, scene->light_mounts, sizeof *scene->light_mounts);
	assert_memory_equal(back->camera_mounts, scene->camera_mounts, sizeof *scene->camera_mounts);
	assert_true(back->surroundings.ground[1] == 0.25f && back->bounds.radius[0] == scene->bounds.radius[0]);
	unsigned char *second = bytes_of(back, &again);
	assert_int_equal(again, size);
	free(second);
	stilb_scene_destroy(back);
	/* Every shorter stream is refused. */
	for (size_t cut = 0; cut < size; cut += 1 + cut / 8) {
		assert_int_equal(read_bytes(bytes, cut, &back), STILB_ERROR_FILE);
		assert_null(back);
	}
	free(bytes);
	stilb_scene_destroy(scene);
}

/* What announces more than an import may be is refused before there is memory for it; bools become 0 or 1, and what is
 * no tangent or no material is refused. */
static void what_is_announced_is_not_believed(void **state)
{
	(void)state;
	stilb_scene *scene = make(), *back;
	size_t size;
	scene->surfaces[0].unlit = true;
	unsigned char *bytes = bytes_of(scene, &size);
	uint32_t counts[8];
	memcpy(counts, bytes, sizeof counts);
	assert_int_equal(counts[4], 1);
	counts[4] = 4000000; /* surfaces: 2.5 GB */
	FILE *file = tmpfile();
	assert_int_equal(pwrite(fileno(file), counts, sizeof counts, 0), sizeof counts);
	scene_stream stream = {.file = fileno(file), .deadline_ns = UINT64_MAX, .limit = 1u << 24};
	assert_int_equal(scene_stream_read(&stream, NULL, 0, &back), STILB_ERROR_FILE);
	assert_true(stream.too_much && !stream.ended);
	fclose(file);
	/* The byte of the surface's bool. */
	unsigned char *surface = memmem(bytes, size, scene->surfaces, sizeof *scene->surfaces);
	assert_non_null(surface);
	surface[offsetof(stilb_scene_surface, unlit)] = 0xff;
	surface[offsetof(stilb_scene_surface, maps) + offsetof(stilb_scene_map, nearest)] = 0x7f;
	assert_int_equal(read_bytes(bytes, size, &back), STILB_OK);
	assert_true(back->surfaces[0].unlit == 1 && back->surfaces[0].maps[0].nearest == 1);
	stilb_scene_destroy(back);
	free(bytes);
	scene->meshes[0].extras[0].tangent[0] = 0.5f;
	bytes = bytes_of(scene, &size);
	assert_int_equal(read_bytes(bytes, size, &back), STILB_ERROR_FILE);
	assert_non_null(strstr(stilb_error_message(), "tangents or colours"));
	free(bytes);
	scene->meshes[0].extras[0].tangent[0] = 0.0f;
	scene->model_flags[0] = 8;
	bytes = bytes_of(scene, &size);
	assert_int_equal(read_bytes(bytes, size, &back), STILB_ERROR_FILE);
	assert_non_null(strstr(stilb_error_message(), "models"));
	free(bytes);
	scene->model_flags[0] = 0;
	scene->materials[0].surface = 1; /* and a texture */
	bytes = bytes_of(scene, &size);
	assert_int_equal(read_bytes(bytes, size, &back), STILB_ERROR_FILE);
	assert_non_null(strstr(stilb_error_message(), "materials"));
	free(bytes);
	stilb_scene_destroy(scene);
}

static void assert_usable(const stilb_scene *scene)
{
	for (uint32_t p = 0; p < scene->part_count; p++)
		assert_true(scene->part_mesh[p] < scene->mesh_count && scene->part_material[p] < scene->material_count);
	for (uint32_t m = 0; m < scene->mesh_count; m++)
		for (uint32_t i = 0; i < scene->meshes[m].index_count; i++)
			assert_true(scene->meshes[m].indices[i] < scene->meshes[m].vertex_count);
	for (uint32_t m = 0; m < scene->material_count; m++)
		assert_true(scene->materials[m].diffuse_texture <= scene->texture_count);
	for (uint32_t s = 0; s < scene->surface_count; s++) {
		assert_null(stilb_scene_surface_mistake(&scene->surfaces[s]));
		assert_true(scene->surfaces[s].maps[STILB_SCENE_MAP_NORMAL].texture <= scene->texture_count);
	}
	for (uint32_t i = 0; i < scene->light_count; i++)
		assert_null(stilb_scene_light_mistake(&scene->lights[i]));
	assert_true(scene_nodes_are_sound(scene));
}

/* Changes each byte before the vertices in turn, and some after. */
static void damaged_streams_give_no_damaged_scene(void **state)
{
	(void)state;
	stilb_scene *scene = make(), *back;
	size_t size;
	int refused = 0, tried = 0;
	unsigned char *bytes = bytes_of(scene, &size);
	for (size_t at = 0; at < size; at += at < 512 ? 1 : 509) {
		unsigned char old = bytes[at];
		bytes[at] = (unsigned char)(stilb_random_u64(1, at) | 1) ^ old;
		stilb_result result = read_bytes(bytes, size, &back);
		if (result == STILB_OK)
			assert_usable(back);
		refused += result != STILB_OK;
		tried++;
		stilb_scene_destroy(back);
		bytes[at] = old;
	}
	assert_true(refused > 30);
	assert_true(refused < tried);
	free(bytes);
	stilb_scene_destroy(scene);
}

/* Each index in turn is one too large. */
static void nothing_points_past_the_end(void **state)
{
	(void)state;
	stilb_scene *scene = make(), *back;
	uint32_t *const places[] = {&scene->meshes[0].indices[7],
	                            &scene->part_mesh[0],
	                            &scene->part_material[0],
	                            &scene->materials[0].diffuse_texture,
	                            &scene->first_part[1],
	                            (uint32_t *)&scene->lights[0].kind,
	                            &scene->lights[0].face,
	                            &scene->variants->materials[1],
	                            &scene->nodes.parent[1],
	                            &scene->model_node[0],
	                            &scene->light_mounts[0].node,
	                            &scene->camera_mounts[0].node,
	                            (uint32_t *)&scene->camera_mounts[0].up[2],
	                            (uint32_t *)&scene->nodes.local[2].m[5]};
	const uint32_t wrong[] = {scene->meshes[0].vertex_count,
	                          scene->mesh_count,
	                          scene->material_count,
	                          scene->texture_count + 1,
	                          scene->part_count + 1,
	                          STILB_SCENE_LIGHT_KINDS,
	                          scene->part_count + 1,
	                          scene->material_count,
	                          1,
	                          scene->nodes.count + 1,
	                          scene->nodes.count + 1,
	                          scene->nodes.count + 1,
	                          0x7fc00000u /* NaN */,
	                          0x7f800000u /* infinity */};
	for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
		size_t size;
		uint32_t old = *places[i];
		*places[i] = wrong[i];
		unsigned char *bytes = bytes_of(scene, &size);
		*places[i] = old;
		assert_int_equal(read_bytes(bytes, size, &back), STILB_ERROR_FILE);
		assert_non_null(strstr(stilb_error_message(), "impossible"));
		free(bytes);
	}
	stilb_scene_destroy(scene);
}

/* ---- what moves -------------------------------------------------------------------------------------------------- */

/* Two nodes, a clip that turns one of them and weighs the other's morph target, a skin of both, on the scene's mesh. */
static void add_animation(stilb_scene *scene)
{
	static const stilb_scene_animation counts = {.node_count = 2,
	                                             .clip_count = 1,
	                                             .channel_count = 2,
	                                             .skin_count = 1,
	                                             .joint_count = 2,
	                                             .deform_count = 1,
	                                             .time_count = 2,
	                                             .value_count = 10,
	                                             .weight_count = 1};
	assert_int_equal(scene_animation_create(&counts, &scene->animation), STILB_OK);
	stilb_scene_animation *a = scene->animation;
	for (uint32_t n = 0; n < 2; n++)
		a->nodes[n] = (stilb_scene_rest){.parent = n ? 0 : STILB_SCENE_NONE,
		                                 .local = stilb_mat4_identity(),
		                                 .scale = {1, 1, 1},
		                                 .moves = true,
		                                 .model_count = n,
		                                 .skin = n ? 0 : STILB_SCENE_NONE,
		                                 .weight_count = n};
	a->channels[0] = (stilb_scene_channel){
		.node = 0, .path = STILB_SCENE_PATH_ROTATION, .interpolation = STILB_SCENE_LINEAR, .key_count = 2, .width = 4};
	a->channels[1] = (stilb_scene_channel){.node = 1,
	                                       .path = STILB_SCENE_PATH_WEIGHTS,
	                                       .interpolation = STILB_SCENE_STEP,
	                                       .key_count = 2,
	                                       .width = 1,
	                                       .first_value = 8};
	a->clips[0] = (stilb_scene_clip){.name = "turn\n", .duration = 3, .channel_count = 2};
	a->skins[0] = (stilb_scene_skin){.joint_count = 2};
	a->joints[1] = 1;
	a->times[1] = 3;
	a->values[9] = 0.5f;
	a->deforms[0] = (stilb_scene_deform){.influences = 4, .targets = 1};
	assert_int_equal(scene_deform_create(a->deforms, scene->meshes[0].vertex_count, false, true), STILB_OK);
	a->deforms[0].joints[3] = 1;
	a->deforms[0].weights[3] = 0.25f;
	a->deforms[0].positions[2] = 7.0f;
	a->deforms[0].tangents[1] = 6.0f;
}

static void what_moves_comes_back_the_same(void **state)
{
	(void)state;
	stilb_scene *scene = make(), *back;
	size_t size;
	add_animation(scene);
	unsigned char *bytes = bytes_of(scene, &size);
	assert_int_equal(read_bytes(bytes, size, &back), STILB_OK);
	const stilb_scene_animation *a = scene->animation, *b = back->animation;
	assert_string_equal(b->clips[0].name, "turn ");
	assert_memory_equal(a->nodes, b->nodes, 2 * sizeof *a->nodes);
	assert_memory_equal(a->channels, b->channels, 2 * sizeof *a->channels);
	assert_memory_equal(a->values, b->values, 10 * sizeof *a->values);
	assert_true(b->joints[1] == 1 && b->times[1] == 3.0f && b->deforms[0].joints[3] == 1 && !b->deforms[0].normals);
	assert_true(b->deforms[0].weights[3] == 0.25f && b->deforms[0].positions[2] == 7.0f);
	assert_true(b->deforms[0].tangents[1] == 6.0f);
	stilb_scene_destroy(back);
	for (size_t cut = 1; cut < 30000; cut += 1 + cut / 4) {
		assert_int_equal(read_bytes(bytes, size - cut, &back), STILB_ERROR_FILE);
		assert_null(back);
	}
	free(bytes);
	stilb_scene_destroy(scene);
}

/* Each of these numbers in turn is wrong: what names too much, and what is no number. */
static void what_moves_is_checked(void **state)
{
	(void)state;
	stilb_scene *scene = make(), *back;
	add_animation(scene);
	stilb_scene_animation *a = scene->animation;
	const struct {
		uint32_t *place, wrong;
	} counts[] = {
		{&a->nodes[0].parent, 0},
		{&a->nodes[1].parent, 1},
		{&a->nodes[1].skin, 1},
		{&a->nodes[1].model_count, 2},
		{&a->nodes[1].first_model, UINT32_MAX},
		{&a->nodes[1].first_weight, 1},
		{&a->nodes[1].weight_count, 0},
		{&a->nodes[0].model_count, 1}, /* the model of node 1 */
		{&a->channels[0].node, 2},
		{(uint32_t *)&a->channels[0].path, STILB_SCENE_PATHS},
		{(uint32_t *)&a->channels[0].interpolation, STILB_SCENE_INTERPOLATIONS},
		{(uint32_t *)&a->channels[0].interpolation, STILB_SCENE_CUBIC}, /* three times as many numbers */
		{&a->channels[0].key_count, 0},
		{&a->channels[0].key_count, UINT32_MAX},
		{&a->channels[0].width, 3},
		{&a->channels[0].first_time, 1},
		{&a->channels[1].first_value, 9},
		{&a->channels[1].first_value, UINT32_MAX},
		{&a->clips[0].channel_count, 3},
		{&a->clips[0].first_channel, UINT32_MAX},
		{&a->skins[0].joint_count, 3},
		{&a->skins[0].first_joint, 1},
		{&a->joints[0], 2},
	};
	const struct {
		float *place, wrong;
	} numbers[] = {
		{&a->times[0], -1.0f},
		{&a->times[0], 4.0f},
		{&a->times[1], NAN},
		{&a->values[9], INFINITY},
		{&a->clips[0].duration, NAN},
		{&a->nodes[0].local.m[5], NAN},
		{&a->nodes[1].rotation[3], NAN},
		{&a->inverse_binds[1].m[2], INFINITY},
		{&a->weights[0], NAN},
		{&a->deforms[0].weights[1], -0.5f},
		{&a->deforms[0].positions[0], NAN},
		{&a->deforms[0].tangents[2], NAN},
	};
	size_t count = sizeof counts / sizeof *counts, all = count + sizeof numbers / sizeof *numbers, size;
	for (size_t i = 0; i < all; i++) {
		uint32_t *place = i < count ? counts[i].place : (uint32_t *)numbers[i - count].place, old = *place;
		memcpy(place, i < count ? (const void *)&counts[i].wrong : (const void *)&numbers[i - count].wrong, sizeof old);
		unsigned char *bytes = bytes_of(scene, &size);
		*place = old;
		if (read_bytes(bytes, size, &back) != STILB_ERROR_FILE)
			fail_msg("row %zu is taken", i);
		free(bytes);
	}
	a->deforms[0].joints[3] = 2; /* more than the skin has */
	unsigned char *bytes = bytes_of(scene, &size);
	assert_int_equal(read_bytes(bytes, size, &back), STILB_ERROR_FILE);
	free(bytes);
	a->deforms[0].joints[3] = 1;
	stilb_scene_vertex_extra *extras = scene->meshes[0].extras;
	scene->meshes[0].extras = NULL; /* whose tangents a target changes */
	bytes = bytes_of(scene, &size);
	scene->meshes[0].extras = extras;
	assert_int_equal(read_bytes(bytes, size, &back), STILB_ERROR_FILE);
	free(bytes);
	memset(a->nodes[1].name, 'x', sizeof a->nodes[1].name);
	bytes = bytes_of(scene, &size);
	assert_int_equal(read_bytes(bytes, size, &back), STILB_ERROR_FILE);
	free(bytes);
	stilb_scene_destroy(scene);
}

/* Counts that need more than there is are refused before memory is asked for. */
static void what_moves_has_an_end(void **state)
{
	(void)state;
	stilb_scene *scene = make(), *back;
	add_animation(scene);
	size_t size, last;
	unsigned char *bytes = bytes_of(scene, &size);
	/* The counts stand between the variants and the nodes: so far from the end as the animation is long. */
	stilb_scene_animation *moving = scene->animation;
	scene->animation = NULL;
	free(bytes_of(scene, &last));
	scene->animation = moving;
	size_t counts = last - sizeof *moving;
	for (size_t i = 0; i < 9; i++) {
		uint32_t old, huge = 0xFFFFFFF0u;
		memcpy(&old, bytes + counts + 4 * i, 4);
		memcpy(bytes + counts + 4 * i, &huge, 4);
		assert_int_equal(read_bytes(bytes, size, &back), STILB_ERROR_FILE);
		assert_non_null(strstr(stilb_error_message(), "impossible animation"));
		memcpy(bytes + counts + 4 * i, &old, 4);
	}
	/* The deform is last: its mesh, influences and targets stand before the arrays. */
	size_t vertices = scene->meshes[0].vertex_count, head = size - vertices * (4 * 2 + 4 * 4 + 2 * 3 * 4) - 20;
	static const uint32_t wrong[3] = {1, UINT32_MAX - 3, 0x0FFFFFFFu};
	for (size_t i = 0; i < 3; i++) {
		uint32_t old;
		memcpy(&old, bytes + head + 4 * i, 4);
		assert_int_equal(old, i == 0 ? 0 : i == 1 ? 4 : 1);
		memcpy(bytes + head + 4 * i, &wrong[i], 4);
		assert_int_equal(read_bytes(bytes, size, &back), STILB_ERROR_FILE);
		assert_non_null(strstr(stilb_error_message(), "impossible animation"));
		memcpy(bytes + head + 4 * i, &old, 4);
	}
	free(bytes);
	stilb_scene_destroy(scene);
}

/* A projection asserts its ranges, so a camera must not come out of them. */
static void a_camera_can_project(void **state)
{
	(void)state;
	stilb_scene *scene = make(), *back;
	stilb_scene_named_camera good = scene->cameras[0];
	stilb_scene_camera *camera = &scene->cameras[0].camera;
	float *const places[] = {&camera->fov_y,       &camera->fov_y, &camera->fov_y,    &camera->near_z, &camera->near_z,
	                         &camera->position[1], &camera->roll,  &camera->exposure, &camera->far_z};
	const float wrong[] = {-1.0f, 3.2f, NAN, 0.0f, camera->far_z, NAN, INFINITY, 101.0f, INFINITY};
	size_t size;
	for (size_t i = 0; i <= sizeof places / sizeof *places; i++) {
		if (i < sizeof places / sizeof *places)
			*places[i] = wrong[i];
		else
			memset(scene->cameras[0].name, 'a', sizeof scene->cameras[0].name); /* a name without an end */
		unsigned char *bytes = bytes_of(scene, &size);
		scene->cameras[0] = good;
		assert_int_equal(read_bytes(bytes, size, &back), STILB_ERROR_FILE);
		assert_non_null(strstr(stilb_error_message(), "impossible cameras"));
		free(bytes);
	}
	scene->camera_count = 0; /* none: the reader frames the scene */
	unsigned char *bytes = bytes_of(scene, &size);
	assert_int_equal(read_bytes(bytes, size, &back), STILB_OK);
	assert_true(back->framed && back->camera.fov_y > 0.0f && isfinite(back->camera.position[0]));
	stilb_scene_destroy(back);
	free(bytes);
	stilb_scene_destroy(scene);
}

static void the_deadline_ends_waiting(void **state)
{
	(void)state;
	int ends[2];
	scene_message message;
	int passed;
	assert_int_equal(socketpair(AF_UNIX, SOCK_STREAM, 0, ends), 0);
	uint64_t start = stilb_time_ns();
	scene_stream stream = {.file = ends[0], .deadline_ns = start + 20000000};
	assert_false(scene_stream_read_message(&stream, &message, &passed));
	assert_true(stream.late && !stream.ended);
	assert_true(stilb_time_ns() - start >= 20000000);
	close(ends[1]);
	stream = (scene_stream){.file = ends[0], .deadline_ns = UINT64_MAX};
	assert_false(scene_stream_read_message(&stream, &message, &passed));
	assert_true(stream.ended && !stream.late);
	close(ends[0]);
}

/* A taken-over process could send until its deadline: the limit of bytes ends reading. */
static void what_is_sent_has_an_end(void **state)
{
	(void)state;
	stilb_scene *scene = make(), *back;
	size_t size;
	unsigned char *bytes = bytes_of(scene, &size);
	for (int i = 0; i < 2; i++) {
		FILE *file = tmpfile();
		assert_int_equal(pwrite(fileno(file), bytes, size, 0), size);
		stilb_image texture = {0};
		stilb_image_create(&texture, 3, 2, 3, STILB_IMAGE_U8_SRGB);
		scene_stream stream = {.file = fileno(file), .deadline_ns = UINT64_MAX, .limit = i ? size : size - 1};
		assert_int_equal(scene_stream_read(&stream, &texture, 1, &back), i ? STILB_OK : STILB_ERROR_FILE);
		assert_int_equal(stream.too_much, !i);
		stilb_scene_destroy(back);
		fclose(file);
	}
	free(bytes);
	stilb_scene_destroy(scene);
}

/* A picture that is handed over is accepted only if its memory is sealed and as large as its shape says. */
static void pictures_are_sealed(void **state)
{
	(void)state;
	int ends[2], passed;
	scene_message sent = {.kind = SCENE_MESSAGE_PICTURE,
	                      .width = 5,
	                      .height = 4,
	                      .channels = 2,
	                      .levels = 1,
	                      .format = STILB_IMAGE_U16_SRGB},
				  got;
	assert_int_equal(socketpair(AF_UNIX, SOCK_STREAM, 0, ends), 0);
	scene_stream stream = {.file = ends[0], .deadline_ns = UINT64_MAX, .limit = 60000};
	for (int i = 0; i < 5; i++) {
		stilb_image image, back;
		assert_int_equal(stilb_image_create_shared(&image, 5, 4, 2, STILB_IMAGE_U16_SRGB), STILB_OK);
		((uint16_t *)image.pixels)[39] = 40000;
		int file = stilb_image_share(&image);
		assert_true(file >= 0 && !image.pixels);
		if (i == 1) { /* not sealed, and too small to be copied */
			close(file);
			file = memfd_create("open", MFD_ALLOW_SEALING);
			assert_int_equal(ftruncate(file, 79), 0);
		}
		sent.height = i == 2 ? 5 : 4;
		sent.width = i == 3 ? 70000 : 5;
		assert_true(scene_stream_write_message(ends[1], &sent, i == 4 ? -1 : file));
		close(file);
		assert_true(scene_stream_read_message(&stream, &got, &passed));
		assert_true((passed >= 0) == (i != 4));
		stilb_result result = scene_stream_take_picture(&stream, &got, passed, &back);
		assert_true((result == STILB_OK) == (i == 0));
		assert_true(fcntl(passed, F_GETFD) == -1); /* closed in any case */
		if (i == 0) {
			assert_int_equal(((uint16_t *)back.pixels)[39], 40000);
			((uint16_t *)back.pixels)[39] = 1; /* the mapping is private */
		}
		stilb_image_finish(&back);
	}
	stilb_image image, back;
	int file;
	sent = (scene_message){
		.kind = SCENE_MESSAGE_PICTURE, .width = 5, .height = 4, .channels = 2, .format = STILB_IMAGE_BC5_LINEAR};
	for (sent.levels = 0; sent.levels < 5; sent.levels++) { /* blocks, with their levels: 5x4, 2x2 and 1x1 */
		assert_int_equal(stilb_image_create_levels(&back, 5, 4, 2, STILB_IMAGE_BC5_LINEAR, 3), STILB_OK);
		assert_int_equal(stilb_image_copy(&back, true, &image), STILB_OK);
		stilb_image_finish(&back);
		((uint8_t *)image.pixels)[63] = 77; /* of the last one's block */
		uint64_t taken = stream.taken;
		file = stilb_image_share(&image);
		assert_true(scene_stream_write_message(ends[1], &sent, file));
		close(file);
		assert_true(scene_stream_read_message(&stream, &got, &passed));
		assert_true((scene_stream_take_picture(&stream, &got, passed, &back) == STILB_OK) == (sent.levels == 3));
		assert_int_equal(stream.taken - taken, sizeof sent + (sent.levels == 3 ? 64 : 0));
		assert_true(sent.levels != 3 || ((uint8_t *)back.pixels)[63] == 77);
		stilb_image_finish(&back);
	}
	sent.levels = 1;
	sent.format = STILB_IMAGE_U16_SRGB;
	stream.limit = stream.taken + sizeof sent + 79;
	assert_int_equal(stilb_image_create_shared(&image, 5, 4, 2, STILB_IMAGE_U16_SRGB), STILB_OK);
	file = stilb_image_share(&image);
	sent.width = 5, sent.height = 4;
	assert_true(scene_stream_write_message(ends[1], &sent, file));
	close(file);
	assert_true(scene_stream_read_message(&stream, &got, &passed));
	assert_int_equal(scene_stream_take_picture(&stream, &got, passed, &back), STILB_ERROR_FILE);
	assert_true(stream.too_much);
	close(ends[0]);
	close(ends[1]);
}

static stilb_result receive(int file, uint32_t height, stilb_image *picture)
{
	return stilb_image_receive(file, 1024, height, 4, STILB_IMAGE_U8_SRGB, 1, picture);
}

/* A lent picture is copied: what its owner does with the memory later changes nothing. */
static void lent_pictures_are_copied(void **state)
{
	(void)state;
	stilb_image image, first, second;
	uint32_t most = STILB_IMAGE_LEND_MAX / 4096; /* rows of 1024 pixels of 4 bytes */
	assert_int_equal(stilb_image_create_shared(&image, 1024, most, 4, STILB_IMAGE_U8_SRGB), STILB_OK);
	memset(image.pixels, 7, stilb_image_size(&image));
	assert_int_equal(receive(stilb_image_lend(&image), most, &first), STILB_OK);
	assert_int_equal(stilb_image_reshape_shared(&image, 1024, 2, 4, STILB_IMAGE_U8_SRGB), STILB_OK);
	memset(image.pixels, 9, stilb_image_size(&image));
	assert_int_equal(receive(stilb_image_lend(&image), 2, &second), STILB_OK);
	memset(image.pixels, 1, stilb_image_size(&image));
	for (size_t i = 0; i < stilb_image_size(&first); i++)
		assert_int_equal(((uint8_t *)first.pixels)[i], 7);
	for (size_t i = 0; i < stilb_image_size(&second); i++)
		assert_int_equal(((uint8_t *)second.pixels)[i], 9);
	stilb_image_finish(&first);
	stilb_image_finish(&second);
	stilb_image_finish(&image);
}

/* A taken-over process that cuts its memory off does no harm: nothing of it is mapped, and what is missing is told. */
static void lent_memory_may_vanish(void **state)
{
	(void)state;
	stilb_image picture;
	int file = memfd_create("vanishing", MFD_ALLOW_SEALING);
	assert_int_equal(ftruncate(file, 8192), 0);
	assert_int_equal(receive(file, 2, &picture), STILB_OK);
	assert_int_equal(ftruncate(file, 4096), 0);
	for (size_t i = 0; i < stilb_image_size(&picture); i++)
		assert_int_equal(((uint8_t *)picture.pixels)[i], 0);
	stilb_image_finish(&picture);
	assert_int_equal(receive(file, 2, &picture), STILB_ERROR_FILE);
	assert_non_null(strstr(stilb_error_message(), "smaller than its shape needs"));
	assert_null(picture.pixels);
	close(file);
}

/* Larger pictures are not copied, and nothing is read that might make the reader wait. */
static void what_is_not_lent(void **state)
{
	(void)state;
	uint32_t most = STILB_IMAGE_LEND_MAX / 4096;
	stilb_image picture;
	int large = memfd_create("large", MFD_ALLOW_SEALING), ends[2];
	assert_int_equal(ftruncate(large, STILB_IMAGE_LEND_MAX + 4096), 0);
	assert_int_equal(receive(large, most, &picture), STILB_OK);
	stilb_image_finish(&picture);
	assert_int_equal(receive(large, most + 1, &picture), STILB_ERROR_FILE);
	assert_non_null(strstr(stilb_error_message(), "not sealed"));
	close(large);
	FILE *file = tmpfile(); /* of a folder, perhaps of a slow network */
	assert_int_equal(ftruncate(fileno(file), 8192), 0);
	stilb_result result = receive(fileno(file), 2, &picture);
	bool memory = fcntl(fileno(file), F_GET_SEALS) >= 0; /* a folder in memory */
	assert_true(memory || result == STILB_ERROR_FILE);
	stilb_image_finish(&picture);
	fclose(file);
	assert_int_equal(pipe(ends), 0);
	assert_int_equal(receive(ends[0], 2, &picture), STILB_ERROR_FILE);
	assert_non_null(strstr(stilb_error_message(), "not sealed"));
	close(ends[0]);
	close(ends[1]);
}

/* The number of the memory file that the picture is in. */
static ino_t memory_of(const stilb_image *image)
{
	struct stat info;
	assert_int_equal(fstat(stilb_image_lend(image), &info), 0);
	return info.st_ino;
}

/* Memory is used again for what fits, and what is handed over then has the size of its picture alone. */
static void memory_is_used_again(void **state)
{
	(void)state;
	stilb_image image = {0}, back;
	assert_int_equal(stilb_image_reshape_shared(&image, 64, 64, 4, STILB_IMAGE_U8_SRGB), STILB_OK);
	ino_t memory = memory_of(&image);
	assert_int_equal(stilb_image_reshape_shared(&image, 3, 2, 3, STILB_IMAGE_F32_LINEAR), STILB_OK);
	assert_int_equal(memory_of(&image), memory);
	assert_int_equal(stilb_image_reshape_shared(&image, 64, 64, 4, STILB_IMAGE_U8_SRGB), STILB_OK);
	assert_int_equal(memory_of(&image), memory);
	assert_int_equal(stilb_image_reshape_shared(&image, 64, 65, 4, STILB_IMAGE_U8_SRGB), STILB_OK);
	assert_int_not_equal(memory_of(&image), memory);
	memset(image.pixels, 1, 64 * 65 * 4);
	assert_int_equal(stilb_image_reshape_shared(&image, 5, 4, 2, STILB_IMAGE_U16_SRGB), STILB_OK);
	((uint16_t *)image.pixels)[39] = 40000;
	int file = stilb_image_share(&image);
	assert_true(file >= 0 && !image.pixels);
	assert_int_equal(stilb_image_receive(file, 5, 4, 2, STILB_IMAGE_U16_SRGB, 1, &back), STILB_OK);
	assert_int_equal(((uint16_t *)back.pixels)[39], 40000);
	stilb_image_finish(&back);
	close(file);
	assert_int_equal(stilb_image_create_shared(&image, 5, 4, 2, STILB_IMAGE_U16_SRGB), STILB_OK);
	assert_int_equal(stilb_image_reshape_shared(&image, 0, 4, 2, STILB_IMAGE_U16_SRGB), STILB_ERROR_ARGUMENT);
	assert_null(image.pixels);
}

int main(void)
{
	const struct CMUnitTest tests[] = {
		cmocka_unit_test(a_scene_comes_back_the_same),
		cmocka_unit_test(what_is_announced_is_not_believed),
		cmocka_unit_test(damaged_streams_give_no_damaged_scene),
		cmocka_unit_test(nothing_points_past_the_end),
		cmocka_unit_test(what_moves_comes_back_the_same),
		cmocka_unit_test(what_moves_is_checked),
		cmocka_unit_test(what_moves_has_an_end),
		cmocka_unit_test(the_deadline_ends_waiting),
		cmocka_unit_test(what_is_sent_has_an_end),
		cmocka_unit_test(pictures_are_sealed),
		cmocka_unit_test(a_camera_can_project),
		cmocka_unit_test(lent_pictures_are_copied),
		cmocka_unit_test(lent_memory_may_vanish),
		cmocka_unit_test(what_is_not_lent),
		cmocka_unit_test(memory_is_used_again),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
