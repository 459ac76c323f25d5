/* Which way is up in a file: Assimp 5.2 turns the scenes of some formats whose z is up, and leaves others alone. */
#include "scene/importer/importer.h"

#include <assimp/commonMetaData.h>
#include <string.h>
#include <strings.h>

static const stilb_mat4 axes_z_up = {.m = {[0] = 1, [6] = -1, [9] = 1, [15] = 1}}; /* (x, y, z) becomes (x, z, -y) */

static const struct aiMetadataEntry *axes_metadata(const struct aiScene *scene, const char *key, aiMetadataType type)
{
	for (unsigned i = 0; scene->mMetaData && i < scene->mMetaData->mNumProperties; i++)
		if (strcmp(scene->mMetaData->mKeys[i].data, key) == 0)
			return scene->mMetaData->mValues[i].mType == type ? &scene->mMetaData->mValues[i] : NULL;
	return NULL;
}

bool importer_is_format(const struct aiScene *scene, const char *begins)
{
	const struct aiMetadataEntry *entry = axes_metadata(scene, AI_METADATA_SOURCE_FORMAT, AI_AISTRING);
	return entry && strncmp(((const struct aiString *)entry->mData)->data, begins, strlen(begins)) == 0;
}

/* A whole number of an FBX file's settings. */
static int32_t axes_setting(const struct aiScene *scene, const char *key, int32_t missing)
{
	const struct aiMetadataEntry *entry = axes_metadata(scene, key, AI_INT32);
	return entry ? *(const int32_t *)entry->mData : missing;
}

/* FBX files name the axes that point right, up and to who looks from the front. False: these are not three. */
static bool axes_of_fbx(const struct aiScene *scene, stilb_mat4 *axes)
{
	static const char *const names[3][2] = {
		{"CoordAxis", "CoordAxisSign"}, {"UpAxis", "UpAxisSign"}, {"FrontAxis", "FrontAxisSign"}};
	static const int32_t usual[3] = {0, 1, 2};
	uint32_t used = 0;
	*axes = (stilb_mat4){.m = {[15] = 1}};
	for (uint32_t row = 0; row < 3; row++) {
		int32_t axis = axes_setting(scene, names[row][0], usual[row]);
		int32_t sign = axes_setting(scene, names[row][1], 1);
		if (axis < 0 || axis > 2)
			return false;
		used |= 1u << axis;
		axes->m[4 * axis + (int32_t)row] = sign < 0 ? -1.0f : 1.0f;
	}
	return used == 7;
}

/* OpenGEX, chapter "Metric": up is "y" or "z", and "z" if the file does not say it. */
static bool axes_gex_is_y(const importer_bytes *bytes)
{
	static const char key[] = "\"up\"";
	const char *at = memmem(bytes->data, bytes->size, key, sizeof key - 1);
	const char *end = (const char *)bytes->data + bytes->size;
	const char *value = at ? memchr(at + sizeof key - 1, '"', (size_t)(end - at) - (sizeof key - 1)) : NULL;
	return value && end - value > 2 && value[1] == 'y';
}

bool importer_up_is_y(const char *path, const importer_bytes *bytes)
{
	const char *dot = strrchr(path, '.');
	return dot && strcasecmp(dot, ".ogex") == 0 && axes_gex_is_y(bytes);
}

/* The axes of Blender, of Valve's Source engine and of trueSpace are those of the program; 3MF's specification, 3.3.1,
 * has z point up from the plate. Quick3D's are those of the files that assimp-testmodels has. */
stilb_mat4 importer_axes(const struct aiScene *scene, bool up_is_y)
{
	static const char *const z_up[] = {"Blender 3D", "Valve SMD", "TrueSpace", "3mf", "Quick3D"};
	stilb_mat4 axes;
	for (size_t i = 0; i < sizeof z_up / sizeof *z_up; i++)
		if (importer_is_format(scene, z_up[i]))
			return axes_z_up;
	if (importer_is_format(scene, "Open Game Engine Exchange") && !up_is_y)
		return axes_z_up;
	if (importer_is_format(scene, "Autodesk FBX") && axes_of_fbx(scene, &axes))
		return axes;
	return stilb_mat4_identity();
}
