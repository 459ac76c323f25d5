/* The cases of the suite `plan`: X(NAME, TITLE, PASSES). */
#ifndef PLAN_CASES_H
#define PLAN_CASES_H

#define PLAN_CASES(X)                                                                                                  \
	X("passes-10", "a frame of 10 passes, each into an image of its own that later ones sample", 10)                   \
	X("passes-100", "100 passes", 100)                                                                                 \
	X("passes-1000", "1,000 passes", 1000)

#endif
