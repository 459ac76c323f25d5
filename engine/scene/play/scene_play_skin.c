#include "scene/play/scene_play_skin.h"

void scene_play_skin_plain(play_skin *skin)
{
	if (skin->tangent[0])
		play_skin_run(skin, true);
	else
		play_skin_run(skin, false);
}

play_skin_fn *scene_play_skin_choose(void)
{
	return scene_play_skin_avx2 && stilb_cpu_widest_isa() >= STILB_ISA_AVX2 ? scene_play_skin_avx2
	                                                                        : scene_play_skin_plain;
}
