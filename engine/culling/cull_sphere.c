/* The test that decides, in scalar C. Plane after plane over arrays, without branches: both compilers turn it into SIMD. */
#include "culling/cull_internal.h"

#include <string.h>

static void cull_test_plane(cull_spheres spheres, uint32_t count, stilb_plane plane, uint8_t *restrict visible)
{
	const float *restrict x = spheres.x, *restrict y = spheres.y, *restrict z = spheres.z;
	const float *restrict radius = spheres.radius;
	for (uint32_t i = 0; i < count; i++) {
		float signed_distance = ((x[i] * plane.x + y[i] * plane.y) + z[i] * plane.z) + plane.distance;
		visible[i] &= signed_distance >= -radius[i];
	}
}

void cull_test_spheres(cull_spheres spheres, uint32_t count, const stilb_frustum *frustum, uint32_t planes,
                       uint8_t *visible)
{
	memset(visible, 1, count);
	for (; planes; planes &= planes - 1)
		cull_test_plane(spheres, count, frustum->planes[__builtin_ctz(planes)], visible);
}
