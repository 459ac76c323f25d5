/* Variants of materials in `stilb view`. */
#include "view.h"

#include <stdio.h>

stilb_result view_variant_begin(const view *v, stilb_scene *scene, bool again)
{
	const stilb_scene_variants *before = again && v->scene ? v->scene->variants : NULL;
	stilb_result result = STILB_OK;
	if (before && before->shown > 0)
		result = stilb_scene_show_variant_named(scene, before->names[before->shown - 1]);
	else if (!before)
		result = picture_flags_variant(&v->options.picture, scene);
	if (result != STILB_OK && v->scene) {
		live_run_warn(v->run, stilb_error_message());
		result = STILB_OK;
	}
	return result;
}

void view_variant_next(view *v)
{
	const stilb_scene_variants *variants = v->scene->variants;
	char text[128] = "the file has no variants of its materials";
	uint32_t next = variants && variants->shown < variants->count ? variants->shown + 1 : 0;
	view_rays_hold(v);
	stilb_result result = stilb_scene_show_variant(v->scene, next);
	if (variants && next > 0)
		snprintf(text, sizeof text, "variant %u of %u: %s", next, variants->count, variants->names[next - 1]);
	else if (variants)
		snprintf(text, sizeof text, "the file's own materials; %u variants", variants->count);
	if (result != STILB_OK)
		snprintf(text, sizeof text, "%s", stilb_error_message());
	fprintf(live_message_stream(&v->options), "%s\n", text);
	fflush(live_message_stream(&v->options));
	live_run_tell(v->run, text);
}
