/* The cases of the suite `simplify`: X(NAME, TITLE, MESH, PARTS). PARTS: of the triangles, one of this many is left. */
#ifndef SIMPLIFY_CASES_H
#define SIMPLIFY_CASES_H

#define SIMPLIFY_CASES(X)                                                                                              \
	X("sphere/2", "sphere of 81,920 triangles, half of them left", sphere, 2)                                          \
	X("sphere/8", "an eighth", sphere, 8)                                                                              \
	X("sphere/64", "a sixty-fourth", sphere, 64)                                                                       \
	X("bumpy/2", "bumpy sphere of 81,920 triangles, half of them left", bumpy, 2)                                      \
	X("bumpy/8", "an eighth", bumpy, 8)                                                                                \
	X("bumpy/64", "a sixty-fourth", bumpy, 64)                                                                         \
	X("hills/2", "hills with a border, 180,000 triangles, half of them left", hills, 2)                                \
	X("hills/8", "an eighth", hills, 8)                                                                                \
	X("hills/64", "a sixty-fourth", hills, 64)                                                                         \
	X("torus/2", "bumpy torus with seams of the texture, 160,000 triangles, half of them left", torus, 2)              \
	X("torus/8", "an eighth", torus, 8)                                                                                \
	X("torus/64", "a sixty-fourth", torus, 64)                                                                         \
	X("knot/2", "ribbed knot with seams, 144,000 triangles, half of them left", knot, 2)                               \
	X("knot/8", "an eighth", knot, 8)                                                                                  \
	X("knot/64", "a sixty-fourth", knot, 64)                                                                           \
	X("cliffs/2", "cliffs and plains with a border, 131,072 triangles, half of them left", cliffs, 2)                  \
	X("cliffs/8", "an eighth", cliffs, 8)                                                                              \
	X("cliffs/64", "a sixty-fourth", cliffs, 64)

#endif
