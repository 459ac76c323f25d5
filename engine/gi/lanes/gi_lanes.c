#include "gi/lanes/gi_lanes.h"

const gi_lanes_kernels *gi_lanes_for(stilb_isa isa)
{
	STILB_ASSERT(isa < STILB_ISA_COUNT && isa <= stilb_cpu_widest_isa());
#if defined(__x86_64__)
	if (isa == STILB_ISA_AVX512)
		return &gi_lanes_avx512;
	if (isa == STILB_ISA_AVX2)
		return &gi_lanes_avx2;
#else
	(void)isa;
#endif
	return &gi_lanes_scalar;
}

const gi_lanes_kernels *gi_lanes_of_cpu(void)
{
	stilb_isa isa;
	return gi_lanes_for(stilb_cpu_isa(&isa) == STILB_OK ? isa : STILB_ISA_SCALAR);
}
