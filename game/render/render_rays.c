#include "render_rays.h"

#include "shading/shade_tonemap.h"

#define RAYS_WORD(id, name, ...) #name,
#define RAYS_BRANCHED_DEPTH 2 /* default for montecarlo, whose N rays from each hit make N^depth at the last */

const char *const rays_integrators[] = {STILB_GI_INTEGRATORS(RAYS_WORD) NULL};
static const char *const rays_shadows[] = {"off", "on", NULL};

rays_flags rays_flags_default(void)
{
	return (rays_flags){.integrator = STILB_GI_INTEGRATOR_PATH, .shadows = true};
}

void rays_flags_add(rays_flags *rays, rays_flags_group group, flag_rows *table)
{
	STILB_ASSERT(rays && table);
	flag rows[] = {
		[RAYS_INTEGRATOR] = {"--integrator", FLAG_CHOICE, &rays->integrator, "NAME",
	                         "method that computes the light: 'stilb render --help' (path)", 0, 0, rays_integrators},
		[RAYS_SHADOWS] =
			{"--shadows", FLAG_CHOICE, &rays->shadows, "on|off",
	         "off: nothing hides a light from a surface, and emission lights nothing, as in frames without "
	         "shadows; --integrator direct (on)",
	         0, 0, rays_shadows},
	};
	flag_rows_add(table, &rows[group], 1);
}

static void rays_default_of(stilb_gi_settings *settings)
{
	switch (settings->integrator) {
	case STILB_GI_INTEGRATOR_AO:
	case STILB_GI_INTEGRATOR_SPLIT:
		settings->samples = 16;
		settings->rays = 16;
		break;
	case STILB_GI_INTEGRATOR_MONTECARLO:
		settings->samples = 4;
		settings->rays = 8;
		settings->depth = RAYS_BRANCHED_DEPTH;
		break;
	case STILB_GI_INTEGRATOR_IRRADIANCE_CACHE:
	case STILB_GI_INTEGRATOR_CHANNEL:
		settings->samples = 16;
		break;
	default:
		break;
	}
}

stilb_gi_settings rays_flags_settings(const rays_flags *rays, const stilb_scene *scene)
{
	stilb_gi_settings settings = stilb_gi_settings_default(scene);
	settings.integrator = (stilb_gi_integrator)rays->integrator;
	settings.channel = (stilb_scene_surface_channel)rays->channel;
	settings.no_shadows = !rays->shadows && rays->integrator == STILB_GI_INTEGRATOR_DIRECT;
	settings.progressive = true; /* a picture that is stopped early is complete, though coarse */
	rays_default_of(&settings);
	if (settings.integrator == STILB_GI_INTEGRATOR_CHANNEL) { /* values are shown as they are */
		settings.exposure = 0.0f;
		settings.tone = SHADE_TONE_NONE;
	}
	return settings;
}
