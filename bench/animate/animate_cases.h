/* The cases of the suite `animate`: X(NAME, TITLE, FIGURES, JOINTS, VERTICES, TORN). TORN: neighbouring vertices
 * hang on joints of anywhere. */
#ifndef ANIMATE_CASES_H
#define ANIMATE_CASES_H

#define ANIMATE_CASES(X)                                                                                               \
	X("clips", "1,000 figures of 60 joints, each at its own time of one clip", 1000, 60, 0, false)                     \
	X("skin", "1,000 figures of 10,000 vertices, four joints each", 1000, 60, 10000, false)                            \
	X("torn", "the same, neighbours on joints of anywhere", 250, 60, 10000, true)                                      \
	X("horde", "10,000 figures of 20 joints and 300 vertices", 10000, 20, 300, false)

#endif
