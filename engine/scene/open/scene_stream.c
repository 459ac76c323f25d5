#include "scene/open/scene_stream.h"

#include "scene/edit/scene_check.h"
#include "scene/open/scene_stream_bytes.h"
#include "scene/open/scene_stream_rest.h"
#include "scene/scene_animation.h"
#include "scene/scene_internal.h"
#include "shading/shade_tonemap.h"

#include <errno.h>
#include <math.h>
#include <poll.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

/* ---- messages ---------------------------------------------------------------------------------------------------- */

void scene_stream_version(char text[static 64])
{
	snprintf(text, 64, "stilb %s scene %zu %zu %zu %zu %zu %zu %zu", STILB_VERSION, sizeof(stilb_scene),
	         sizeof(stilb_scene_material), sizeof(stilb_scene_surface), sizeof(stilb_scene_vertex),
	         sizeof(stilb_scene_vertex_extra), sizeof(stilb_scene_deform), sizeof(scene_message));
}

/* A buffer for the one descriptor of a message, aligned as its header needs. */
typedef union stream_descriptor {
	struct cmsghdr header;
	char bytes[CMSG_SPACE(sizeof(int))];
} stream_descriptor;

bool scene_stream_write_message(int file, const scene_message *message, int passed)
{
	STILB_ASSERT(file >= 0 && message);
	STILB_ASSERT(memchr(message->text, 0, sizeof message->text) && "text ends with 0");
	stream_descriptor room = {.header = {CMSG_LEN(sizeof(int)), SOL_SOCKET, SCM_RIGHTS}};
	memcpy(CMSG_DATA(&room.header), &passed, sizeof passed);
	struct iovec part = {(scene_message *)message, sizeof *message};
	struct msghdr sent = {.msg_iov = &part, .msg_iovlen = 1};
	if (passed >= 0) {
		sent.msg_control = room.bytes;
		sent.msg_controllen = sizeof room.bytes;
	}
	ssize_t put;
	do
		put = sendmsg(file, &sent, MSG_NOSIGNAL); /* no SIGPIPE if the other side is gone */
	while (put < 0 && errno == EINTR);
	for (size_t done = put < 0 ? 0 : (size_t)put; put > 0 && done < sizeof *message; done += (size_t)put)
		do
			put = send(file, (const char *)message + done, sizeof *message - done, MSG_NOSIGNAL);
		while (put < 0 && errno == EINTR);
	return put > 0;
}

/* The descriptor that came with a message, or -1. */
static int stream_descriptor_of(struct msghdr *got)
{
	int file = -1;
	for (struct cmsghdr *part = CMSG_FIRSTHDR(got); part; part = CMSG_NXTHDR(got, part))
		if (part->cmsg_level == SOL_SOCKET && part->cmsg_type == SCM_RIGHTS && part->cmsg_len >= CMSG_LEN(sizeof file))
			memcpy(&file, CMSG_DATA(part), sizeof file); /* the buffer holds one, so there is no second */
	return file;
}

bool scene_stream_read_message(scene_stream *stream, scene_message *message, int *passed)
{
	STILB_ASSERT(stream && message && passed);
	stream_descriptor room;
	struct iovec part = {message, sizeof *message};
	struct msghdr got = {
		.msg_iov = &part, .msg_iovlen = 1, .msg_control = room.bytes, .msg_controllen = sizeof room.bytes};
	ssize_t size;
	*passed = -1;
	do {
		if (!scene_stream_wait(stream))
			return false;
		size = recvmsg(stream->file, &got, MSG_CMSG_CLOEXEC);
	} while (size < 0 && errno == EINTR);
	stream->ended |= size == 0 || (size < 0 && errno == ECONNRESET);
	if (size <= 0)
		return false;
	*passed = stream_descriptor_of(&got);
	if (!scene_stream_count(stream, (uint64_t)size) ||
	    !scene_stream_get(stream, (char *)message + size, sizeof *message - (size_t)size)) {
		if (*passed >= 0)
			close(*passed);
		*passed = -1;
		return false;
	}
	message->text[sizeof message->text - 1] = '\0';
	return true;
}

stilb_result scene_stream_take_picture(scene_stream *stream, const scene_message *message, int file,
                                       stilb_image *picture)
{
	STILB_ASSERT(message->kind == SCENE_MESSAGE_PICTURE);
	*picture = (stilb_image){0};
	stilb_result result = STILB_OK;
	if (file < 0)
		result = stilb_fail(STILB_ERROR_FILE, "a picture came without its pixels");
	if (result == STILB_OK)
		result = stilb_image_receive(file, message->width, message->height, message->channels, message->format,
		                             message->levels, picture);
	if (file >= 0)
		close(file);
	if (result == STILB_OK && !scene_stream_count(stream, stilb_image_levels_size(picture))) {
		stilb_image_finish(picture);
		result = stilb_fail(STILB_ERROR_FILE, "its pictures are too large together");
	}
	return result;
}

/* ---- scenes ------------------------------------------------------------------------------------------------------ */

typedef struct stream_counts {
	uint32_t models, parts, meshes, materials, surfaces, textures, lights, cameras;
} stream_counts;

typedef struct stream_array {
	void *data;
	size_t size;
} stream_array;

#define STREAM_MAX_VERTICES (1u << 28) /* of a mesh, 8 GiB: an import may not have more memory */

/* True if every count is at most STILB_SCENE_MAX_MODELS. */
static bool stream_counts_are_possible(const stream_counts *counts)
{
	uint32_t most = STILB_SCENE_MAX_MODELS;
	return counts->models <= most && counts->parts <= most && counts->meshes <= most && counts->materials <= most &&
	       counts->surfaces <= most && counts->textures <= most && counts->lights <= most && counts->cameras <= most;
}

#define STREAM_ARRAYS 12

/* The arrays of a scene in the order of the stream, without those inside meshes and textures. */
static void stream_arrays(const stilb_scene *scene, stream_array arrays[STREAM_ARRAYS])
{
	size_t models = scene->model_count, parts = scene->part_count;
	const stream_array all[STREAM_ARRAYS] = {
		{scene->bounds.x, models * sizeof(float)},
		{scene->bounds.y, models * sizeof(float)},
		{scene->bounds.z, models * sizeof(float)},
		{scene->bounds.radius, models * sizeof(float)},
		{scene->first_part, (models + 1) * sizeof(uint32_t)},
		{scene->part_mesh, parts * sizeof(uint32_t)},
		{scene->part_material, parts * sizeof(uint32_t)},
		{scene->part_transform, parts * sizeof(stilb_mat4)},
		{scene->materials, scene->material_count * sizeof(stilb_scene_material)},
		{scene->surfaces, scene->surface_count * sizeof(stilb_scene_surface)},
		{scene->lights, scene->light_count * sizeof(stilb_scene_light)},
		{scene->cameras, scene->camera_count * sizeof(stilb_scene_named_camera)},
	};
	for (int i = 0; i < STREAM_ARRAYS; i++)
		arrays[i] = all[i];
}

bool scene_stream_write(int file, const stilb_scene *scene)
{
	STILB_ASSERT(file >= 0 && scene);
	stream_counts counts = {scene->model_count,   scene->part_count,    scene->mesh_count,  scene->material_count,
	                        scene->surface_count, scene->texture_count, scene->light_count, scene->camera_count};
	stream_array arrays[STREAM_ARRAYS];
	stream_arrays(scene, arrays);
	const stilb_scene_surroundings *around = &scene->surroundings;
	bool good = scene_stream_put(file, &counts, sizeof counts) &&
	            scene_stream_put(file, around->sky, sizeof around->sky) &&
	            scene_stream_put(file, around->ground, sizeof around->ground);
	for (int i = 0; good && i < STREAM_ARRAYS; i++)
		good = scene_stream_put(file, arrays[i].data, arrays[i].size);
	for (uint32_t i = 0; good && i < scene->mesh_count; i++) {
		const stilb_scene_mesh *mesh = &scene->meshes[i];
		const uint32_t sizes[3] = {mesh->vertex_count, mesh->index_count, mesh->extras ? mesh->vertex_count : 0};
		good = scene_stream_put(file, sizes, sizeof sizes) &&
		       scene_stream_put(file, mesh->vertices, mesh->vertex_count * sizeof *mesh->vertices) &&
		       scene_stream_put(file, mesh->indices, mesh->index_count * sizeof *mesh->indices) &&
		       scene_stream_put(file, mesh->extras, sizes[2] * sizeof *mesh->extras);
	}
	return good && scene_stream_write_rest(file, scene);
}

/* ---- reading ----------------------------------------------------------------------------------------------------- */

static stilb_result stream_read_mesh(scene_stream *stream, stilb_scene_mesh *mesh)
{
	uint32_t sizes[3];
	if (!scene_stream_get(stream, sizes, sizeof sizes))
		return scene_stream_broken(stream);
	if (sizes[1] % 3 != 0 || (sizes[2] != 0 && sizes[2] != sizes[0]) || sizes[0] > STREAM_MAX_VERTICES ||
	    sizes[1] > 3 * STREAM_MAX_VERTICES)
		return scene_stream_wrong("triangles");
	if (!scene_stream_has_room(stream, sizes[0] * (uint64_t)sizeof *mesh->vertices +
	                                       sizes[1] * (uint64_t)sizeof *mesh->indices +
	                                       sizes[2] * (uint64_t)sizeof *mesh->extras))
		return scene_stream_broken(stream);
	stilb_result result = scene_mesh_create(mesh, sizes[0], sizes[1]);
	if (result == STILB_OK && sizes[2] > 0)
		result = scene_mesh_add_extras(mesh);
	if (result != STILB_OK)
		return result;
	if (!scene_stream_get(stream, mesh->vertices, sizes[0] * sizeof *mesh->vertices) ||
	    !scene_stream_get(stream, mesh->indices, sizes[1] * sizeof *mesh->indices) ||
	    !scene_stream_get(stream, mesh->extras, sizes[2] * sizeof *mesh->extras))
		return scene_stream_broken(stream);
	return STILB_OK;
}

/* A bool whose byte is neither 0 nor 1 is undefined behaviour. */
static void stream_settle_bool(bool *value)
{
	unsigned char byte;
	memcpy(&byte, value, 1);
	*value = byte != 0;
}

static void stream_settle_surface(stilb_scene_surface *surface)
{
	for (int i = 0; i < STILB_SCENE_MAPS; i++)
		stream_settle_bool(&surface->maps[i].nearest);
	stream_settle_bool(&surface->one_sided);
	stream_settle_bool(&surface->unlit);
	surface->function = 0; /* files have none */
}

static stilb_result stream_read_into(scene_stream *stream, stilb_scene *scene)
{
	stream_array arrays[STREAM_ARRAYS];
	stream_arrays(scene, arrays);
	stilb_scene_surroundings *around = &scene->surroundings;
	bool good = scene_stream_get(stream, around->sky, sizeof around->sky) &&
	            scene_stream_get(stream, around->ground, sizeof around->ground);
	for (int i = 0; good && i < STREAM_ARRAYS; i++)
		good = scene_stream_get(stream, arrays[i].data, arrays[i].size);
	if (!good)
		return scene_stream_broken(stream);
	for (uint32_t i = 0; i < scene->camera_count; i++)
		scene_stream_clean_name(scene->cameras[i].name, sizeof scene->cameras[i].name);
	for (uint32_t s = 0; s < scene->surface_count; s++)
		stream_settle_surface(&scene->surfaces[s]);
	stilb_result result = STILB_OK;
	for (uint32_t i = 0; result == STILB_OK && i < scene->mesh_count; i++)
		result = stream_read_mesh(stream, &scene->meshes[i]);
	return result;
}

static bool stream_camera_is_usable(const stilb_scene_camera *camera)
{
	bool finite = isfinite(camera->yaw) && isfinite(camera->pitch) && isfinite(camera->roll) &&
	              isfinite(camera->far_z) && fabsf(camera->exposure) <= 100.0f && camera->tone < SHADE_TONE_COUNT;
	for (int i = 0; i < 3; i++)
		finite = finite && isfinite(camera->position[i]);
	return finite && camera->fov_y > 0.0f && camera->fov_y < 3.1415927f && camera->near_z > 0.0f &&
	       camera->near_z < camera->far_z;
}

/* STILB_ERROR_FILE for an index, a kind or a camera that is out of range. */
static stilb_result stream_check(const stilb_scene *scene)
{
	for (uint32_t i = 0; i < scene->light_count; i++)
		if (stilb_scene_light_mistake(&scene->lights[i]))
			return scene_stream_wrong("lights");
	if (!scene_is_sound(scene))
		return scene_stream_wrong("indices or surfaces");
	for (uint32_t m = 0; m < scene->material_count; m++)
		if (scene_check_material(&scene->materials[m], m) != STILB_OK)
			return scene_stream_wrong("materials");
	for (uint32_t m = 0; m < scene->mesh_count; m++)
		if (scene->meshes[m].extras && scene_check_extras(&scene->meshes[m], m) != STILB_OK)
			return scene_stream_wrong("tangents or colours");
	for (uint32_t i = 0; i < scene->camera_count; i++)
		if (!stream_camera_is_usable(&scene->cameras[i].camera) ||
		    !memchr(scene->cameras[i].name, 0, sizeof scene->cameras[i].name))
			return scene_stream_wrong("cameras");
	return STILB_OK;
}

/* The least that a stream with these counts has: what is allocated for them is not much more. */
static uint64_t stream_bytes_of(const stream_counts *counts)
{
	stilb_scene counted = {.model_count = counts->models,
	                       .part_count = counts->parts,
	                       .material_count = counts->materials,
	                       .surface_count = counts->surfaces,
	                       .light_count = counts->lights,
	                       .camera_count = counts->cameras};
	stream_array arrays[STREAM_ARRAYS];
	stream_arrays(&counted, arrays);
	uint64_t bytes = counts->meshes * (uint64_t)(3 * sizeof(uint32_t));
	for (int i = 0; i < STREAM_ARRAYS; i++)
		bytes += arrays[i].size;
	return bytes;
}

static stilb_result stream_read_scene(scene_stream *stream, stilb_image *textures, uint32_t count, stilb_scene **out)
{
	stream_counts counts;
	stilb_scene *scene = NULL;
	*out = NULL;
	if (!scene_stream_get(stream, &counts, sizeof counts))
		return scene_stream_broken(stream);
	if (!stream_counts_are_possible(&counts))
		return stilb_fail(STILB_ERROR_FILE, "the scene has more than %u of something", STILB_SCENE_MAX_MODELS);
	if (!scene_stream_has_room(stream, stream_bytes_of(&counts)))
		return scene_stream_broken(stream);
	stilb_result result = scene_create(counts.models, counts.parts, counts.meshes, counts.materials, &scene);
	if (result == STILB_OK && counts.textures != count)
		result = scene_stream_wrong("textures");
	if (result == STILB_OK)
		result = scene_add_textures(scene, count);
	if (result == STILB_OK)
		result = scene_add_surfaces(scene, counts.surfaces);
	if (result == STILB_OK)
		result = scene_add_lights(scene, counts.lights);
	if (result == STILB_OK)
		result = scene_add_cameras(scene, counts.cameras);
	if (result == STILB_OK)
		result = stream_read_into(stream, scene);
	if (result == STILB_OK)
		result = scene_stream_read_rest(stream, scene);
	if (result == STILB_OK)
		result = stream_check(scene);
	if (result != STILB_OK) {
		stilb_scene_destroy(scene);
		return result;
	}
	for (uint32_t i = 0; i < count; i++) {
		scene->textures[i] = textures[i];
		textures[i] = (stilb_image){0};
	}
	scene->both_sides = true;
	scene->framed = scene->camera_count == 0;
	scene->camera = scene->framed ? stilb_scene_frame(scene, STILB_SCENE_FRAME_YAW, STILB_SCENE_FRAME_PITCH, 1.0f)
	                              : scene->cameras[0].camera;
	*out = scene;
	return STILB_OK;
}

stilb_result scene_stream_read(scene_stream *stream, stilb_image *textures, uint32_t count, stilb_scene **scene)
{
	STILB_ASSERT(stream && scene && (textures || count == 0));
	stilb_result result = stream_read_scene(stream, textures, count, scene);
	for (uint32_t i = 0; i < count; i++)
		stilb_image_finish(&textures[i]);
	return result;
}
