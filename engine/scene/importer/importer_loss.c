/* What of a file is not shown: counted by kind while the file is read, told in one line for each kind. */
#include "scene/importer/importer.h"

#include <stdio.h>

static const struct importer_loss_words {
	const char *what; /* "<what>: 3 <of>s ('<first>', ...)" */
	const char *of;
} importer_loss_words[IMPORTER_LOSSES] = {
	[IMPORTER_LOSS_CUTOUTS] = {"surfaces cut out by a picture of their own are shown whole", "material"},
	[IMPORTER_LOSS_UNSEEN] = {"surfaces of opacity 0 are not seen", "material"},
	[IMPORTER_LOSS_NORMAL_MAPS] = {"bump maps of heights are not shown", "material"},
	[IMPORTER_LOSS_OCCLUSION_MAPS] = {"occlusion maps are not shown", "material"},
	[IMPORTER_LOSS_METAL_MAPS] = {"maps of metalness and roughness count by their mean", "material"},
	[IMPORTER_LOSS_SPECULAR_MAPS] = {"maps of specular reflection are not shown", "material"},
	[IMPORTER_LOSS_VARIANT_MAPPINGS] = {"textures of variants lie on the uv of the first", "mesh"},
	[IMPORTER_LOSS_SETS] = {"of maps on three and more uv, those on the highest are left out", "material"},
	[IMPORTER_LOSS_LINES] = {"points and lines are not drawn", "mesh"},
	[IMPORTER_LOSS_POSITIONS] = {"what has no positions is not drawn", "mesh"},
	[IMPORTER_LOSS_TRIANGLES] = {"triangles whose vertices do not exist are left out", "mesh"},
	[IMPORTER_LOSS_INFINITE] = {"triangles with a coordinate that is NaN or infinite are left out", "mesh"},
	[IMPORTER_LOSS_ANIMATIONS] = {"animations move nothing of the scene", "animation"},
	[IMPORTER_LOSS_BAD_DEFORMS] = {"skins and morph targets of meshes that are damaged are left out", "mesh"},
	[IMPORTER_LOSS_BAD_SKINS] = {"skins that are damaged are left out", "skin"},
	[IMPORTER_LOSS_BAD_ANIMATIONS] = {"animations that are damaged are left out", "animation"},
	[IMPORTER_LOSS_INFLUENCES] = {"of more than 32 bones that move a vertex, those of the most weight do", "mesh"},
	[IMPORTER_LOSS_NAMESAKES] = {"where nodes have the same name, animations and skins mean the first", "node"},
	[IMPORTER_LOSS_STRAYS] = {"what animations do with nodes that are not there is left out", "animation"},
	[IMPORTER_LOSS_REPEATS] = {"animations stand still before and behind their keys, and do not go on there",
                               "animation"},
	[IMPORTER_LOSS_MESH_FRAMES] = {"animations that replace meshes are not shown", "animation"},
	[IMPORTER_LOSS_EXTRAS] = {"seen, castShadow and receiveShadow of extras count where they are true or false",
                              "node"},
	[IMPORTER_LOSS_SCENES] = {"scenes besides the one that is shown", "scene"},
	[IMPORTER_LOSS_CAMERAS] = {"cameras that are not perspective are left out", "camera"},
	[IMPORTER_LOSS_FALLOFFS] = {"lights fade with the square of the distance, not as the file says", "light"},
	[IMPORTER_LOSS_MIRRORS] = {"mirrors beside a highlight, and pictures of what they mirror, are not shown",
                               "material"},
	[IMPORTER_LOSS_LAYERS] = {"of several textures of a colour the first is shown", "material"},
	[IMPORTER_LOSS_WIRES] = {"wire frames are shown as surfaces", "material"},
	[IMPORTER_LOSS_LIGHTS] = {"lights without brightness, or too far away, are left out", "light"},
};

void importer_lose(importer *import, importer_loss loss, const char *name)
{
	STILB_ASSERT(import && loss < IMPORTER_LOSSES);
	importer_lost *lost = &import->lost[loss];
	if (lost->count++ == 0)
		snprintf(lost->first, sizeof lost->first, "%s", name ? name : "");
}

void importer_tell_losses(const importer *import)
{
	for (int loss = 0; loss < IMPORTER_LOSSES; loss++) {
		const importer_lost *lost = &import->lost[loss];
		const struct importer_loss_words *words = &importer_loss_words[loss];
		if (lost->count == 0)
			continue;
		const char *plural = lost->count == 1 ? "" : words->of[0] == 'm' && words->of[2] == 's' ? "es" : "s";
		const char *more = lost->count > 1 ? ", ..." : "";
		if (lost->first[0])
			importer_warn("%s: %u %s%s ('%s'%s)", words->what, lost->count, words->of, plural, lost->first, more);
		else
			importer_warn("%s: %u %s%s", words->what, lost->count, words->of, plural);
	}
}
