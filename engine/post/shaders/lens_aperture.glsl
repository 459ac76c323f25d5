// The aperture's shape: a disk, or a regular polygon whose corners lie on the circle, the first to the right.
#include "../../shading/shade_constants.h"

// Area of the aperture of radius 1.
float aperture_area()
{
	float sides = float(blades);
	return blades == 0u ? SHADE_PI : 0.5 * sides * sin(2.0 * SHADE_PI / sides);
}

// Radius of the aperture whose edge goes through a point; y points up.
float aperture_radius(vec2 at)
{
	if (blades == 0u)
		return length(at);
	float sector = 2.0 * SHADE_PI / float(blades), farthest = 0.0;
	for (uint side = 0u; side < blades; side++) {
		float angle = (float(side) + 0.5) * sector;
		farthest = max(farthest, dot(at, vec2(cos(angle), sin(angle))));
	}
	return farthest / cos(0.5 * sector);
}

// The share of a source's light per texel that a texel gets: radius is that of the source's circle, texels, and at
// from where to where light goes, in the aperture's orientation. Sums over all texels are about 1.
float aperture_share(float radius, float at)
{
	return clamp(radius - at + 0.5, 0.0, 1.0) / (aperture_area() * (radius * radius + 1.0 / 12.0));
}

// A circle's radius for texels of so many pixels, in pixels. Texels are squares on both ends, and what is made of them
// is interpolated over two pixels: both make the circle larger, so it is as much smaller, by the variances.
float aperture_narrowed(float radius, float pixels)
{
	float wider = 4.0 * (pixels * pixels / 6.0 + 4.0 / 6.0 - 1.0 / 6.0);
	return sqrt(max(radius * radius - wider, 0.25 * pixels * pixels));
}
