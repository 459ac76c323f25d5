/* Reading by Assimp, and what its scene holds that is not shown. */
#include "scene/importer/importer.h"

#include <assimp/cimport.h>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <string.h>
#include <strings.h>

/* Without normals in a file, neighbouring faces are shaded smoothly if they meet at a smaller angle. */
#define IMPORTER_SMOOTH_DEGREES 60.0f

/* Translates an error message of Assimp for a user who does not know Assimp. */
static stilb_result assimp_refuse(const char *path, const char *words)
{
	if (strstr(words, "bad_alloc"))
		return stilb_fail(STILB_ERROR_MEMORY, "it asks for more memory than an import may have");
	if (strncmp(words, "No suitable reader", 18) == 0) {
		const char *dot = strrchr(path, '.');
		bool known = dot && !strchr(dot, '/') && aiIsExtensionSupported(dot);
		return stilb_fail(STILB_ERROR_FILE, known ? "it is damaged, or not of the format that its name says"
		                                          : "Assimp knows no such format; give glTF, OBJ, FBX, PLY, STL, ...");
	}
	return stilb_fail(STILB_ERROR_FILE, "%s", words[0] ? words : "Assimp does not say why");
}

/* ---- losses ------------------------------------------------------------------------------------------------------ */

static void assimp_lose_mesh(importer *import, const struct aiMesh *mesh)
{
	bool lines = false;
	for (uint32_t f = 0; f < mesh->mNumFaces && !lines; f++)
		lines = mesh->mFaces[f].mNumIndices < 3;
	if (lines)
		importer_lose(import, IMPORTER_LOSS_LINES, mesh->mName.data);
	bool finite = true;
	for (uint32_t v = 0; mesh->mVertices && v < mesh->mNumVertices && finite; v++)
		finite = importer_is_point(&mesh->mVertices[v]);
	if (!finite)
		importer_lose(import, IMPORTER_LOSS_INFINITE, mesh->mName.data);
}

/* Counts what the scene holds before parts of it are dropped. */
static void assimp_lose(importer *import)
{
	const struct aiScene *from = import->from;
	bool spikes = from->mFlags & AI_SCENE_FLAGS_INCOMPLETE && from->mNumMeshes == 1 && from->mMeshes[0]->mNumBones > 0;
	for (uint32_t m = 0; m < from->mNumMeshes && !spikes; m++)
		assimp_lose_mesh(import, from->mMeshes[m]);
	if (spikes)
		importer_warn("it has no meshes: spikes stand for its nodes");
}

/* Assimp's readers of some formats give triangles the same vertices also where an edge is sharp, and then makes their
 * normals smooth. */
static bool assimp_shares(const struct aiScene *scene)
{
	static const char *const formats[] = {"3mf", "Additive", "OFF", "Stanford Polygon"};
	bool found = false;
	for (size_t i = 0; i < sizeof formats / sizeof *formats; i++)
		found |= importer_is_format(scene, formats[i]);
	for (uint32_t m = 0; m < scene->mNumMeshes; m++)
		found = found && !scene->mMeshes[m]->mNormals;
	return found;
}

/* True if meshes have bones or morph targets. Assimp 5.2 joins vertices also if bones move them apart, and leaves bones
 * whose vertices are all joined to others with vertices that they do not move. */
static bool assimp_deforms(const struct aiScene *scene)
{
	for (uint32_t m = 0; m < scene->mNumMeshes; m++)
		if (scene->mMeshes[m]->mNumBones > 0 || scene->mMeshes[m]->mNumAnimMeshes > 0)
			return true;
	return false;
}

/* ---- reading ----------------------------------------------------------------------------------------------------- */

stilb_result importer_read(importer *import)
{
	unsigned steps = aiProcess_Triangulate | aiProcess_JoinIdenticalVertices | aiProcess_SortByPType |
	                 aiProcess_GenSmoothNormals | aiProcess_GenUVCoords | aiProcess_TransformUVCoords |
	                 aiProcess_FlipUVs | aiProcess_RemoveComponent | aiProcess_ImproveCacheLocality;
	int dropped = aiComponent_TANGENTS_AND_BITANGENTS; /* they are made anew */
	const char *dot = strrchr(import->path, '.');
	/* Assimp gives Blender's meshes smooth normals, also those that are flat: made anew, edges of a box are sharp. */
	if (dot && strcasecmp(dot, ".blend") == 0)
		dropped |= aiComponent_NORMALS;
	struct aiPropertyStore *properties = aiCreatePropertyStore();
	aiSetImportPropertyInteger(properties, AI_CONFIG_PP_RVC_FLAGS, dropped);
	aiSetImportPropertyFloat(properties, AI_CONFIG_PP_GSN_MAX_SMOOTHING_ANGLE, IMPORTER_SMOOTH_DEGREES);
	import->from = aiImportFileExWithProperties(import->path, 0, &importer_file_io, properties);
	aiReleasePropertyStore(properties);
	if (!import->from)
		return assimp_refuse(import->path, aiGetErrorString());
	assimp_lose(import);
	import->shares = assimp_shares(import->from);
	import->joins = assimp_deforms(import->from);
	if (import->joins)
		steps &= ~(unsigned)(aiProcess_JoinIdenticalVertices | aiProcess_ImproveCacheLocality);
	import->from = aiApplyPostProcessing(import->from, steps); /* frees the scene if it fails */
	return import->from ? STILB_OK : assimp_refuse(import->path, aiGetErrorString());
}
