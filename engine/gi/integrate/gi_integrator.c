#include "gi/integrate/gi_integrator.h"

const gi_integrator *gi_integrator_of(stilb_gi_integrator name)
{
	STILB_ASSERT(name < STILB_GI_INTEGRATOR_COUNT);
	static const gi_integrator *const integrators[] = {
		[STILB_GI_INTEGRATOR_COLOR] = &gi_integrator_color,
		[STILB_GI_INTEGRATOR_DIRECT] = &gi_integrator_direct,
		[STILB_GI_INTEGRATOR_AO] = &gi_integrator_ao,
		[STILB_GI_INTEGRATOR_MONTECARLO] = &gi_integrator_montecarlo,
		[STILB_GI_INTEGRATOR_PATH] = &gi_integrator_path,
		[STILB_GI_INTEGRATOR_SPLIT] = &gi_integrator_split,
		[STILB_GI_INTEGRATOR_IRRADIANCE_CACHE] = &gi_integrator_irradiance_cache,
		[STILB_GI_INTEGRATOR_CHANNEL] = &gi_integrator_channel,
	};
	_Static_assert(sizeof integrators / sizeof integrators[0] == STILB_GI_INTEGRATOR_COUNT, "an integrator is missing");
	return integrators[name];
}
