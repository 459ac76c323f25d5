/* The cases of the suite `prefilter`: X(NAME, TITLE, SIDE, IS_CUBE): the source is a panorama of SIDE columns, or a
 * cube of SIDE texels. */
#ifndef PREFILTER_CASES_H
#define PREFILTER_CASES_H

#define PREFILTER_CASES(X)                                                                                             \
	X("panorama-1024", "a panorama of 1024 x 512 texels, with a sun", 1024, 0)                                         \
	X("panorama-4096", "a panorama of 4096 x 2048 texels", 4096, 0)                                                    \
	X("cube-256", "a cube of 256 x 256 texels", 256, 1)

#define PREFILTER_MIPS 7 /* of the cube that is made, 256 x 256 */

/* X(METRIC, MIP): error of a mip, the root of the mean square over the mean, per cent; of the first case alone. */
#define PREFILTER_ERRORS(X)                                                                                            \
	X("error-1", 1) X("error-2", 2) X("error-3", 3) X("error-4", 4) X("error-5", 5) X("error-6", 6)

#endif
