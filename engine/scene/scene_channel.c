#include "scene/scene_channel.h"

#include "base/base_contract.h"

#define CHANNEL_NAME(id, name, ...) #name,
#define CHANNEL_KIND(id, name, words, kind) STILB_SCENE_CHANNEL_##kind,

const char *const stilb_scene_channel_names[] = {STILB_SCENE_CHANNELS_OF_SURFACES(CHANNEL_NAME) NULL};

stilb_scene_channel_kind stilb_scene_channel_kind_of(stilb_scene_surface_channel channel)
{
	static const stilb_scene_channel_kind kinds[] = {STILB_SCENE_CHANNELS_OF_SURFACES(CHANNEL_KIND)};
	STILB_ASSERT(channel < STILB_SCENE_CHANNELS);
	return kinds[channel];
}
