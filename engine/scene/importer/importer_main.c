/*
 * stilb-scene-import BYTES PATH: reads a scene file through Assimp, in at most BYTES of memory, and writes what
 * scene_stream.h says to standard output. PATH "": Assimp's version. Started by scene_import.c, by nobody else.
 */
#include "scene/importer/importer.h"

#include "scene/open/scene_stream.h"

#include <assimp/cimport.h>
#include <assimp/commonMetaData.h>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/version.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

/* Their shadow memory is larger than any limit, and their reports are for the terminal. */
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define IMPORTER_SANITIZED 1
#elif defined(__has_feature)
#define IMPORTER_SANITIZED (__has_feature(address_sanitizer) || __has_feature(thread_sanitizer))
#else
#define IMPORTER_SANITIZED 0
#endif

#define IMPORTER_SMOOTH_DEGREES 60.0f /* where a file has no normals, faces that meet at more stay apart */

static int importer_output; /* the pipe: standard output is for those who print without being asked */

static void importer_say(scene_message_kind kind, stilb_result result, const char *format, va_list arguments)
{
	scene_message message = {.kind = kind, .result = result};
	vsnprintf(message.text, sizeof message.text, format, arguments);
	if (!scene_stream_write_message(importer_output, &message))
		_exit(1); /* nobody listens */
}

void importer_warn(const char *format, ...)
{
	va_list arguments;
	va_start(arguments, format);
	importer_say(SCENE_MESSAGE_WARNING, STILB_OK, format, arguments);
	va_end(arguments);
}

static void importer_send(scene_message_kind kind, stilb_result result, const char *format, ...)
	__attribute__((format(printf, 3, 4)));

static void importer_send(scene_message_kind kind, stilb_result result, const char *format, ...)
{
	va_list arguments;
	va_start(arguments, format);
	importer_say(kind, result, format, arguments);
	va_end(arguments);
}

/* The pipe out of the way of prints; nothing else goes out. */
static void importer_open_output(void)
{
	importer_output = fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, 3);
	int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
	if (importer_output < 0 || nowhere < 0)
		_exit(1);
	dup2(nowhere, STDOUT_FILENO);
#if !IMPORTER_SANITIZED
	dup2(nowhere, STDERR_FILENO);
#endif
}

static void importer_set_limits(const char *bytes)
{
#if !IMPORTER_SANITIZED
	const rlim_t memory = strtoull(bytes, NULL, 10);
	setrlimit(RLIMIT_AS, &(struct rlimit){memory, memory});
#else
	(void)bytes;
#endif
	setrlimit(RLIMIT_CORE, &(struct rlimit){0, 0}); /* a crash is an answer here */
	prctl(PR_SET_PDEATHSIG, SIGKILL);               /* and not one for a reader that is gone */
}

/* What Assimp's own words mean to somebody who only wants to see a scene. */
static stilb_result importer_refuse(const char *path, const char *words)
{
	if (strstr(words, "bad_alloc"))
		return stilb_fail(STILB_ERROR_MEMORY, "it asks for more memory than an import may have");
	if (strncmp(words, "No suitable reader", 18) == 0) {
		const char *dot = strrchr(path, '.');
		bool known = dot && !strchr(dot, '/') && aiIsExtensionSupported(dot);
		return stilb_fail(STILB_ERROR_FILE, known ? "it is damaged, or not of the format that its name says"
		                                          : "Assimp knows no such format");
	}
	return stilb_fail(STILB_ERROR_FILE, "%s", words[0] ? words : "Assimp does not say why");
}

/* Assimp's scene, in triangles. */
static stilb_result importer_read(const char *path, const struct aiScene **scene)
{
	const unsigned steps = aiProcess_Triangulate | aiProcess_JoinIdenticalVertices | aiProcess_SortByPType |
	                       aiProcess_GenSmoothNormals | aiProcess_GenUVCoords | aiProcess_TransformUVCoords |
	                       aiProcess_FlipUVs | aiProcess_RemoveComponent | aiProcess_ImproveCacheLocality;
	struct aiPropertyStore *properties = aiCreatePropertyStore();
	/* What no one here asks for only costs time, and is one more thing that can be damaged. */
	aiSetImportPropertyInteger(properties, AI_CONFIG_PP_RVC_FLAGS,
	                           aiComponent_COLORS | aiComponent_BONEWEIGHTS | aiComponent_ANIMATIONS |
	                               aiComponent_TANGENTS_AND_BITANGENTS);
	aiSetImportPropertyFloat(properties, AI_CONFIG_PP_GSN_MAX_SMOOTHING_ANGLE, IMPORTER_SMOOTH_DEGREES);
	*scene = aiImportFileExWithProperties(path, steps, NULL, properties);
	return *scene ? STILB_OK : importer_refuse(path, aiGetErrorString());
}

static bool importer_is_gltf(const struct aiScene *scene)
{
	for (unsigned i = 0; scene->mMetaData && i < scene->mMetaData->mNumProperties; i++) {
		const struct aiMetadataEntry *entry = &scene->mMetaData->mValues[i];
		if (strcmp(scene->mMetaData->mKeys[i].data, AI_METADATA_SOURCE_FORMAT) == 0 && entry->mType == AI_AISTRING)
			return strncmp(((const struct aiString *)entry->mData)->data, "glTF", 4) == 0;
	}
	return false;
}

static stilb_result importer_convert(const char *path, stilb_scene **scene)
{
	importer import = {.path = path};
	stilb_result result = importer_read(path, &import.from);
	if (result != STILB_OK)
		return result;
	import.gltf = importer_is_gltf(import.from);
	result = importer_list_nodes(&import);
	if (result == STILB_OK)
		result = importer_add_meshes(&import);
	if (result == STILB_OK)
		result = importer_add_materials(&import);
	if (result == STILB_OK)
		result = importer_add_view(&import);
	if (import.odd_nodes)
		importer_warn("%u of its nodes have a place that is no number: they are left out", import.odd_nodes);
	*scene = import.scene;
	return result;
}

int main(int argc, char **argv)
{
	char version[64];
	stilb_scene *scene = NULL;
	if (argc != 3) {
		fprintf(stderr, "stilb: stilb-scene-import is started by stilb, for scene files\n");
		return 2;
	}
	importer_open_output();
	importer_set_limits(argv[1]);
	scene_stream_version(version);
	importer_send(SCENE_MESSAGE_HELLO, STILB_OK, "%s", version);
	if (argv[2][0] == '\0') {
		importer_warn("%u.%u.%u", aiGetVersionMajor(), aiGetVersionMinor(), aiGetVersionPatch());
		_exit(0);
	}
	stilb_result result = importer_convert(argv[2], &scene);
	if (result != STILB_OK) {
		importer_send(SCENE_MESSAGE_ERROR, result, "%s", stilb_error_message());
		_exit(0);
	}
	importer_send(SCENE_MESSAGE_SCENE, STILB_OK, "%s", "");
	_exit(scene_stream_write(importer_output, scene) ? 0 : 1); /* Assimp's memory goes with the process */
}
