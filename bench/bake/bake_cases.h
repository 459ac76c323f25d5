/* The cases of the suite `bake`: X(NAME, TITLE, KIND). */
#ifndef BAKE_CASES_H
#define BAKE_CASES_H

#define BAKE_CASES(X)                                                                                                  \
	X("unwrap-land", "100,352 triangles: hills and cliffs", BAKE_LAND)                                                 \
	X("unwrap-knot", "100,000 triangles: a knotted tube with bumps", BAKE_KNOT)                                        \
	X("pack-ones", "1,000,000 charts of one texel, with borders, on pages of 4096", BAKE_PACK)                         \
	X("texels-large", "texels of a page of 2048 that a few large charts cover", BAKE_LARGE)                            \
	X("texels-small", "texels of a page of 2048, of 100,352 triangles", BAKE_SMALL)

typedef enum bake_case { BAKE_LAND, BAKE_KNOT, BAKE_PACK, BAKE_LARGE, BAKE_SMALL } bake_case;

#endif
