/* The cases of the suite `gltf`: X(NAME, TITLE, PARTS, SIDE, TEXTURES, PIXELS, LENGTH). A part is a grid of SIDE x SIDE
 * quads; PIXELS: the width and the height of each texture; LENGTH: bench_case.length. */
#ifndef GLTF_CASES_H
#define GLTF_CASES_H

#define GLTF_CASES(X)                                                                                                  \
	X("million", "a million triangles in 200 parts, 20 PNG textures of 4096 x 4096", 200, 50, 20, 4096, 30.0)          \
	X("geometry", "the same without textures", 200, 50, 0, 0, 1.0)                                                     \
	X("small", "400 triangles in 2 parts, 2 textures of 64 x 64: mostly the start of the process", 2, 10, 2, 64, 1.0)

#endif
