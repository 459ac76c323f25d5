/* The cases of the suite `import`: X(NAME, TITLE, COLOR, BITS, INTERLACE, NOISE). COLOR: PNG_COLOR_TYPE_...; BITS a
 * channel; NOISE: added to smooth waves, as a share of the whole range; 1: nothing but noise. */
#ifndef IMPORT_CASES_H
#define IMPORT_CASES_H

#define IMPORT_CASES(X)                                                                                                \
	X("rgb", "PNG, 1024 x 1024, RGB of 8 bits, waves with a little noise", PNG_COLOR_TYPE_RGB, 8, false, 0.03)         \
	X("rgba", "the same with alpha", PNG_COLOR_TYPE_RGB_ALPHA, 8, false, 0.03)                                         \
	X("grey", "the same, grey", PNG_COLOR_TYPE_GRAY, 8, false, 0.03)                                                   \
	X("rgb16", "the same, RGB of 16 bits", PNG_COLOR_TYPE_RGB, 16, false, 0.03)                                        \
	X("adam7", "the same, RGB of 8 bits, interlaced", PNG_COLOR_TYPE_RGB, 8, true, 0.03)                               \
	X("palette", "the same, a palette of 256 colours, which becomes RGB", PNG_COLOR_TYPE_PALETTE, 8, false, 0.03)      \
	X("noise", "RGB of 8 bits, noise alone: hardly compressed, so the quickest to decode", PNG_COLOR_TYPE_RGB, 8,      \
	  false, 1.0)

#endif
