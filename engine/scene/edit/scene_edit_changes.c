/* What has changed since the last frame, when nodes have placed their models and bounds are made. */
#include "scene/edit/scene_edit_internal.h"
#include "scene/edit/scene_node.h"

stilb_scene_changes stilb_scene_changes_read(stilb_scene *scene)
{
	STILB_ASSERT(scene);
	const stilb_scene_edits *edits = scene->edits;
	if (!edits)
		return (stilb_scene_changes){0};
	stilb_scene_update_nodes(scene, NULL, 0);
	scene_edit_settle(scene);
	return (stilb_scene_changes){
		.meshes = edits->meshes.changed,
		.mesh_count = edits->meshes.changed_count,
		.materials = edits->materials.changed,
		.material_count = edits->materials.changed_count,
		.textures = edits->textures.changed,
		.texture_count = edits->textures.changed_count,
		.functions = edits->functions.changed,
		.function_count = edits->functions.changed_count,
		.vertices = edits->ranges,
		.vertices_count = edits->range_count,
	};
}
