/* The case of the suite `textured`, its picture's size, and the variants of the plain Vulkan program. */
#ifndef TEXTURED_CASES_H
#define TEXTURED_CASES_H

/* X(NAME, TITLE) */
#define TEXTURED_CASES(X) X("helmet", "15,128 triangles, five maps, a panorama, lavapipe, 640x360")

#define TEXTURED_WIDTH 640u
#define TEXTURED_HEIGHT 360u
#define TEXTURED_SIDE 1024u /* texels of the maps */

/* X(ENUM, identifier of its code, subject, words). textured.glsl tells what they are. */
#define TEXTURED_VARIANTS(X)                                                                                           \
	X(STRAIGHT, straight, "vulkan-bare", "one draw, one set, bound as usual; the same texels, tables and formulas")    \
	X(ARRAYS, arrays, "bare-arrays", "vulkan-bare, but maps are layers of arrays")                                     \
	X(ADDRESS, address, "bare-address", "vulkan-bare, but the table of irradiance is read by its address")             \
	X(SAMPLED, sampled, "bare-sampled", "vulkan-bare, but that table is an image")                                     \
	X(FETCHED, fetched, "bare-fetched", "vulkan-bare, but that table is an image of which four texels are read")       \
	X(VIEW, view, "bare-view", "vulkan-bare, but vertices read the view and the transform by address")                 \
	X(HANDED, handed, "bare-handed", "vulkan-bare, but vertices read the material by its address and hand it on")      \
	X(EXTRAS, extras, "bare-extras", "vulkan-bare, but vertices read tangent and colour by address")                   \
	X(SIDES, sides, "bare-sides", "vulkan-bare, but pixels find out which side they are on")                           \
	X(HABITS, habits, "bare-habits", "vulkan-bare with all of these but the images, as the engine has them")

#endif
