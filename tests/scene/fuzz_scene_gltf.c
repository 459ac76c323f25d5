/* glTF files of any bytes: the reader never crashes, and gives a scene that can be used or a reason. It starts from
 * files with every feature, and changes their numbers as well as their bytes. Draco and the decoders of pictures are
 * other people's, and left out. */
#include "scene/importer/gltf/gltf.h"
#include "scene/importer/gltf/gltf_draco.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
int LLVMFuzzerInitialize(int *argc, char ***argv);
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t most, unsigned seed);
size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t most);

/* ---- in place of the rest of the import process ------------------------------------------------------------------ */

void importer_warn(const char *format, ...)
{
	(void)format;
}

void importer_advance_textures(uint32_t done, uint32_t count)
{
	STILB_ASSERT(done <= count && count > 0);
}

void importer_advance_meshes(const importer *import, uint32_t done, uint32_t count)
{
	STILB_ASSERT(import && done <= count && count > 0);
}

int importer_files_ask(const char *name, bool quiet, char why[static 256])
{
	(void)name, (void)quiet;
	snprintf(why, 256, "there are no files here");
	return -1;
}

bool importer_bytes_read(int file, importer_bytes *bytes)
{
	(void)file, (void)bytes;
	return false;
}

void importer_bytes_free(importer_bytes *bytes)
{
	free(bytes->data);
	*bytes = (importer_bytes){0};
}

stilb_result importer_decode(const char *name, const importer_bytes *bytes, uint32_t flags, stilb_image *image)
{
	(void)name, (void)flags;
	*image = (stilb_image){0};
	for (size_t i = 0; i < bytes->size; i++)
		if (((volatile unsigned char *)bytes->data)[i] == 0)
			break; /* reads what a decoder may read */
	return stilb_fail(STILB_ERROR_FILE, "no pictures here");
}

const char *gltf_draco_decode(const unsigned char *data, size_t size, gltf_draco_mesh *mesh, bool *memory)
{
	(void)data, (void)size, (void)mesh;
	*memory = false;
	return "no Draco here";
}

/* ---- seeds ------------------------------------------------------------------------------------------------------- */

#define SEED_BUFFER                                                                                                    \
	"\"buffers\":[{\"byteLength\":36,\"uri\":\"data:;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA\"}],"     \
	"\"bufferViews\":[{\"buffer\":0,\"byteOffset\":0,\"byteLength\":36,\"byteStride\":12},{\"buffer\":0,"              \
	"\"byteLength\":"                                                                                                  \
	"36}]"
#define SEED_ASSET "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"

static const char *const seeds[] = {
	SEED_ASSET SEED_BUFFER
	",\"nodes\":[{\"mesh\":0,\"children\":[1],\"scale\":[1,2,3]},{\"mesh\":0,\"extensions\":{\"EXT_mesh_gpu_"
	"instancing\":"
	"{\"attributes\":{\"TRANSLATION\":0,\"SCALE\":1}}}}],\"meshes\":[{\"primitives\":[{\"mode\":5,\"indices\":2,"
	"\"attributes\":{\"POSITION\":0,\"NORMAL\":0,\"TEXCOORD_0\":3},\"material\":0},{\"mode\":6,\"attributes\":"
	"{\"POSITION\":1}}]}],\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"},"
	"{\"componentType\":5126,\"count\":3,\"type\":\"VEC3\",\"sparse\":{\"count\":2,\"indices\":{\"bufferView\":1,"
	"\"byteOffset\":12,\"componentType\":5121},\"values\":{\"bufferView\":1,\"byteOffset\":4}}},{\"bufferView\":1,"
	"\"byteOffset\":12,\"componentType\":5123,\"count\":4,\"type\":\"SCALAR\"},{\"bufferView\":1,\"componentType\":"
	"5122,"
	"\"count\":6,\"type\":\"VEC2\",\"normalized\":true}],\"materials\":[{\"alphaMode\":\"MASK\","
	"\"pbrMetallicRoughness\":"
	"{\"baseColorFactor\":[1,1,1,1],\"baseColorTexture\":{\"index\":0,\"extensions\":{\"KHR_texture_transform\":"
	"{\"offset\":[0,1],\"rotation\":2,\"scale\":[3,4],\"texCoord\":0}}}}}],\"textures\":[{\"source\":0,\"sampler\":0}],"
	"\"samplers\":[{\"wrapS\":33071}],\"images\":[{\"bufferView\":1,\"mimeType\":\"image/png\"},{\"uri\":"
	"\"data:image/png;base64,AAAA\"}]}",
	SEED_ASSET SEED_BUFFER
	",\"nodes\":[{\"mesh\":0,\"camera\":0,\"rotation\":[0,0,0,1],\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}"
	"}],"
	"\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],\"accessors\":[{\"bufferView\":0,"
	"\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}],\"cameras\":[{\"type\":\"perspective\",\"perspective\":"
	"{\"yfov\":0.6,\"znear\":0.1}}],\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[{\"type\":\"spot\","
	"\"intensity\":"
	"5,\"color\":[1,1,1],\"range\":3,\"spot\":{\"innerConeAngle\":0.1,\"outerConeAngle\":0.5}}]},"
	"\"KHR_materials_variants\":{\"variants\":[{\"name\":\"a\"}]}},\"extensionsUsed\":[\"ACME\"],"
	"\"animations\":[{\"name\":\"\\u00e9\\ud83d\\ude00\\n\"}],\"skins\":[{}]}",
	SEED_ASSET
	"\"buffers\":[{\"byteLength\":50},{\"byteLength\":21,\"uri\":\"data:;base64,oAAAAAAAAAAAAAAAAAAAAAAAAAAA\"}],"
	"\"bufferViews\":[{\"buffer\":0,\"byteLength\":36,\"extensions\":{\"EXT_meshopt_compression\":{\"buffer\":1,"
	"\"byteLength\":21,\"byteStride\":12,\"count\":3,\"mode\":\"ATTRIBUTES\",\"filter\":\"EXPONENTIAL\"}}}],\"nodes\":"
	"[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],\"accessors\":[{\"bufferView\":0,"
	"\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}]}",
	SEED_ASSET SEED_BUFFER
	",\"nodes\":[{\"mesh\":0,\"skin\":0,\"weights\":[0.5,1],\"children\":[1]},{\"rotation\":[0,0,0,1]}],\"meshes\":[{"
	"\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":0,\"TANGENT\":6,\"JOINTS_0\":1,\"WEIGHTS_0\":2,"
	"\"JOINTS_1\":1,\"WEIGHTS_1\":2},"
	"\"material\":0,\"targets\":[{\"POSITION\":0,\"NORMAL\":0,\"TANGENT\":0},{\"POSITION\":0}],\"extensions\":{"
	"\"KHR_materials_variants\":{\"mappings\":[{\"material\":1,\"variants\":[0,1]}]}}}]}],\"materials\":[{"
	"\"normalTexture\":{"
	"\"index\":0}},{}],\"textures\":[{\"source\":0}],\"images\":[{\"bufferView\":1,\"mimeType\":\"image/png\"}],"
	"\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"},{\"bufferView\":1,"
	"\"componentType\":5121,\"count\":3,\"type\":\"VEC4\"},{\"bufferView\":1,\"componentType\":5123,\"count\":3,"
	"\"type\":\"VEC4\",\"normalized\":true},{\"componentType\":5126,\"count\":1,\"type\":\"MAT4\"},{\"bufferView\":1,"
	"\"byteOffset\":8,\"componentType\":5126,\"count\":2,\"type\":\"SCALAR\"},{\"bufferView\":1,\"componentType\":5126,"
	"\"count\":2,\"type\":\"VEC4\"},{\"bufferView\":1,\"componentType\":5121,\"count\":3,\"type\":\"VEC4\","
	"\"normalized\":true}],\"skins\":[{\"joints\":[1],\"skeleton\":0,\"inverseBindMatrices\":3}],"
	"\"animations\":[{\"samplers\":[{\"input\":4,\"output\":5},{\"input\":4,\"output\":4,\"interpolation\":\"STEP\"}],"
	"\"channels\":[{\"sampler\":0,\"target\":{\"node\":1,\"path\":\"rotation\"}},{\"sampler\":1,\"target\":{\"node\":0,"
	"\"path\":\"weights\"}}]}],\"extensions\":{\"KHR_materials_variants\":{\"variants\":[{\"name\":\"a\"},{}]}}}",
};

static void seed_write(const char *folder, size_t number, const void *data, size_t size)
{
	char path[512];
	snprintf(path, sizeof path, "%s/%zu", folder, number);
	FILE *file = fopen(path, "wb");
	if (!file || fwrite(data, 1, size, file) != size)
		abort();
	fclose(file);
}

/* The last argument is the folder of the seeds, which the fuzzer reads after this and adds to. */
int LLVMFuzzerInitialize(int *argc, char ***argv)
{
	const char *folder = (*argv)[*argc - 1];
	if (*argc < 2 || folder[0] == '-') {
		fprintf(stderr, "usage: fuzz_scene_gltf [-OPTION=VALUE ...] FOLDER\n");
		exit(1);
	}
	mkdir(folder, 0777);
	for (size_t i = 0; i < sizeof seeds / sizeof *seeds; i++) {
		uint8_t whole[4096] = {'g', 'l', 'T', 'F', 2};
		uint32_t size = (uint32_t)strlen(seeds[i]);
		seed_write(folder, 2 * i, seeds[i], size);
		memcpy(whole + 12, &size, 4);
		memcpy(whole + 16, "JSON", 4);
		memcpy(whole + 20, seeds[i], size);
		seed_write(folder, 2 * i + 1, whole, 20 + size);
	}
	return 0;
}

/* ---- running ----------------------------------------------------------------------------------------------------- */

/* Every other time replaces a number, which changes of bytes rarely leave a number. */
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t most, unsigned seed)
{
	static const char *const numbers[] = {"0",
	                                      "1",
	                                      "2",
	                                      "3",
	                                      "4",
	                                      "7",
	                                      "12",
	                                      "-1",
	                                      "255",
	                                      "65535",
	                                      "70000",
	                                      "4294967295",
	                                      "9007199254740992",
	                                      "1e30",
	                                      "5121",
	                                      "5125",
	                                      "5126",
	                                      "0.5"};
	size_t at = size ? seed % size : 0, end;
	while (at < size && !isdigit(data[at]))
		at++;
	for (end = at; end < size && isdigit(data[end]);)
		end++;
	const char *number = numbers[seed / 64 % (sizeof numbers / sizeof *numbers)];
	size_t length = strlen(number);
	if (seed / 32 % 2 == 0 || at == size || size - (end - at) + length > most)
		return LLVMFuzzerMutate(data, size, most);
	memmove(data + at + length, data + end, size - end);
	memcpy(data + at, number, length);
	return size - (end - at) + length;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
	importer import = {.path = "fuzz.gltf"};
	importer_bytes bytes = {malloc(size ? size : 1), size}; /* of its exact size, so that a read behind it shows */
	if (!bytes.data)
		abort();
	memcpy(bytes.data, data, size);
	if (gltf_is(import.path, &bytes)) {
		stilb_result result = gltf_import(&import, &bytes);
		if (result == STILB_OK && (!import.scene || !scene_is_sound(import.scene) || import.scene->part_count == 0))
			abort();
		if (result != STILB_OK && stilb_error_message()[0] == '\0')
			abort();
		importer_tell_losses(&import);
	}
	importer_free_textures(&import);
	stilb_scene_destroy(import.scene);
	importer_bytes_free(&bytes);
	return 0;
}
