/* cases_dialect: the words of the shading dialect as rows: calls in which C and GPU are compared
 * (README.md). [any-thread] */
#ifndef SHADE_CASES_DIALECT_H
#define SHADE_CASES_DIALECT_H

#include "case_inputs.h"
#include "shading/shade_vocabulary.h"

#include "shading/glsl_begin.h"

/* X(row, name, relative, absolute) */
#define SHADE_CASES_DIALECT(X)                                                                                         \
	X(0, shade_vocabulary_fault, 0.0f, 0.0f)                                                                           \
	X(1, shade_case_direction, 1e-6f, 1e-6f)                                                                           \
	X(2, shade_case_above, 1e-6f, 1e-6f)                                                                               \
	X(3, shade_case_range_and_skewed, 1e-6f, 1e-6f)
#define SHADE_CASES_DIALECT_COUNT 4

SHADE_FN vec4 shade_case_dialect(int row, vec4 a, vec4 b)
{
	if (row == 0) // the line of the word that is wrong; the floor is 0, which no compiler knows
		return vec4(float(shade_vocabulary_fault(floor(a[0]))), 0.0f, 0.0f, 0.0f);
	vec3 direction = shade_case_direction(a[0], a[1]);
	if (row == 1)
		return vec4(direction, length(direction));
	if (row == 2)
		return vec4(shade_case_above(direction, b[0], b[1]), 0.0f);
	return vec4(shade_case_range(a[0], 2.0f, 3.0f), shade_case_skewed(a[1], 1e-3f, 1e3f), 0.0f, 0.0f);
}

#include "shading/glsl_end.h"
#endif
