#include "scene/play/scene_play_skin.h"

#if defined(__x86_64__)
static void skin_avx2(play_skin *skin)
{
	if (skin->tangent[0])
		play_skin_run(skin, true);
	else
		play_skin_run(skin, false);
}

play_skin_fn *const scene_play_skin_avx2 = skin_avx2;
#else
play_skin_fn *const scene_play_skin_avx2 = NULL;
#endif
