/* The cases of the suite `clusters`: X(NAME, TITLE, MESH). */
#ifndef CLUSTERS_CASES_H
#define CLUSTERS_CASES_H

#define CLUSTERS_CASES(X)                                                                                              \
	X("sphere", "bumpy sphere, its poles squeezed into points, 10 million triangles", sphere)                          \
	X("terrain", "terrain with a border and a texture, 10 million triangles", terrain)                                 \
	X("torus", "torus with two seams of the texture and noise of half an edge, 10 million triangles", torus)           \
	X("debris", "30,000 spheres of 320 triangles each: 9.6 million", debris)                                           \
	X("facets", "bumpy sphere without shared vertices, 3.2 million triangles", facets)                                 \
	X("small", "torus of 200,000 triangles", small)

#endif
