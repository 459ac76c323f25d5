/* The cases of the suite `lights`: X(NAME, TITLE, LIGHTS). */
#ifndef LIGHTS_CASES_H
#define LIGHTS_CASES_H

#define LIGHTS_CASES(X)                                                                                                \
	X("lists-18", "lists of 18 spots and lamps in a room", 18)                                                         \
	X("lists-230", "lists of 230 bulbs on strings in a garden", 230)                                                   \
	X("lists-1000", "lists of 1,000 lamps in a hall, a quarter of them spots", 1000)                                   \
	X("lists-10000", "lists of 10,000 bulbs in a hall", 10000)                                                         \
	X("lists-100000", "lists of 100,000 lamps in a city, a quarter of them spots", 100000)

/* The case of lights in a loose octree. */
#define LIGHTS_OCTREE "octree-100000"
#define LIGHTS_OCTREE_COUNT 100000u

/* The case of frames. */
#define LIGHTS_FRAMES "frames-1000"

/* The case of a floor that is cut. */
#define LIGHTS_FLOOR "floor-18"

#endif
