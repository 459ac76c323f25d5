/*
 * shade_vocabulary: every word of the shading dialect, used once with a known answer; C and GLSL. [any-thread]
 *
 * shade_vocabulary_fault(zero) is 0, or the line of the first word that answers wrongly. zero is 0, from a buffer or a
 * volatile, so that no compiler works the answers out by itself.
 */
#ifndef SHADE_VOCABULARY_H
#define SHADE_VOCABULARY_H

#include "shading/glsl_begin.h"

SHADE_CONST vec3 SHADE_VOCABULARY_VEC3 = {1.0f, 2.0f, 4.0f};
SHADE_CONST float SHADE_VOCABULARY_TABLE[3] = {0.5f, 0.25f, 0.125f};

SHADE_STRUCT(shade_vocabulary_table)
{
	vec3 axis;
	float weights[4];
};

SHADE_FN bool shade_vocabulary_off(float got, float want)
{
	return !(abs(got - want) <= 2e-5f);
}

SHADE_FN bool shade_vocabulary_off2(vec2 got, float x, float y)
{
	return shade_vocabulary_off(got[0], x) || shade_vocabulary_off(got[1], y);
}

SHADE_FN bool shade_vocabulary_off3(vec3 got, float x, float y, float z)
{
	return shade_vocabulary_off(got[0], x) || shade_vocabulary_off(got[1], y) || shade_vocabulary_off(got[2], z);
}

SHADE_FN float shade_vocabulary_sum(float weights[4])
{
	float sum = 0.0f;
	for (int i = 0; i < 4; i++)
		sum += weights[i];
	return sum;
}

// clang-format off
#define SHADE_VOCABULARY_IS(got, want) if (shade_vocabulary_off(got, want)) return __LINE__
#define SHADE_VOCABULARY_IS2(got, x, y) if (shade_vocabulary_off2(got, x, y)) return __LINE__
#define SHADE_VOCABULARY_IS3(got, x, y, z) if (shade_vocabulary_off3(got, x, y, z)) return __LINE__
// clang-format on

SHADE_FN int shade_vocabulary_values(float zero)
{
	vec3 v = vec3(1.0f, 2.0f, 4.0f) + zero;
	SHADE_VOCABULARY_IS3(v, 1.0f, 2.0f, 4.0f);
	SHADE_VOCABULARY_IS3(vec3(zero + 3.0f), 3.0f, 3.0f, 3.0f);
	SHADE_VOCABULARY_IS3(vec3(vec2(1.0f, 2.0f), zero), 1.0f, 2.0f, 0.0f);
	SHADE_VOCABULARY_IS3(vec3(vec4(v, 9.0f)), 1.0f, 2.0f, 4.0f);
	SHADE_VOCABULARY_IS2(vec2(zero + 3.0f), 3.0f, 3.0f);
	SHADE_VOCABULARY_IS2(vec2(v), 1.0f, 2.0f);
	SHADE_VOCABULARY_IS2(vec2(vec2(1.0f, zero)), 1.0f, 0.0f);
	SHADE_VOCABULARY_IS(vec4(v, 9.0f)[3], 9.0f);
	SHADE_VOCABULARY_IS(vec4(1.0f, 2.0f, 3.0f, zero + 4.0f)[3], 4.0f);
	SHADE_VOCABULARY_IS(vec4(zero + 5.0f)[3], 5.0f);
	v[1] = 7.0f;
	v[2] += 1.0f;
	SHADE_VOCABULARY_IS3(v, 1.0f, 7.0f, 5.0f);
	SHADE_VOCABULARY_IS3(2.0f * v / vec3(2.0f, 7.0f, 5.0f) - 1.0f, 0.0f, 1.0f, 1.0f);
	SHADE_VOCABULARY_IS3(-SHADE_VOCABULARY_VEC3, -1.0f, -2.0f, -4.0f);
	SHADE_VOCABULARY_IS(SHADE_VOCABULARY_TABLE[int(zero) + 1], 0.25f);
	shade_vocabulary_table table = {v, {1.0f, 2.0f, 3.0f, 4.0f}};
	SHADE_VOCABULARY_IS(shade_vocabulary_sum(table.weights) + table.axis[1], 17.0f);
	uint bits = floatBitsToUint(zero + 1.0f);
	SHADE_VOCABULARY_IS(float(bits >> 23u), 127.0f);
	SHADE_VOCABULARY_IS(uintBitsToFloat(bits + (1u << 23u)), 2.0f);
	SHADE_VOCABULARY_IS(float(uint(zero + 3.7f)) + float(int(zero - 3.7f)), 0.0f);
	SHADE_VOCABULARY_IS(select(zero > 0.0f, 1.0f, 2.0f), 2.0f);
	SHADE_VOCABULARY_IS3(select(zero == 0.0f, v, vec3(0.0f)), 1.0f, 7.0f, 5.0f);
	return 0;
}

SHADE_FN int shade_vocabulary_lanes(float zero)
{
	vec3 v = vec3(-1.5f, 0.25f, 4.0f) + zero;
	vec2 w = vec2(-1.5f, 0.25f) + zero;
	SHADE_VOCABULARY_IS3(abs(v), 1.5f, 0.25f, 4.0f);
	SHADE_VOCABULARY_IS3(sign(vec3(-2.0f, zero, 3.0f)), -1.0f, 0.0f, 1.0f);
	SHADE_VOCABULARY_IS3(floor(v), -2.0f, 0.0f, 4.0f);
	SHADE_VOCABULARY_IS3(ceil(v), -1.0f, 1.0f, 4.0f);
	SHADE_VOCABULARY_IS2(fract(w), 0.5f, 0.25f);
	SHADE_VOCABULARY_IS2(mod(w, 1.0f), 0.5f, 0.25f);
	SHADE_VOCABULARY_IS(mod(zero - 1.0f, 3.0f), 2.0f);
	SHADE_VOCABULARY_IS2(sqrt(abs(vec2(4.0f, 0.25f) + zero)), 2.0f, 0.5f);
	SHADE_VOCABULARY_IS(inversesqrt(zero + 4.0f), 0.5f);
	SHADE_VOCABULARY_IS3(exp2(vec3(0.0f, 1.0f, -2.0f) + zero), 1.0f, 2.0f, 0.25f);
	SHADE_VOCABULARY_IS3(log2(vec3(1.0f, 2.0f, 0.25f) + zero), 0.0f, 1.0f, -2.0f);
	SHADE_VOCABULARY_IS2(log(exp(w)), -1.5f, 0.25f);
	SHADE_VOCABULARY_IS3(pow(vec3(2.0f, 3.0f, 4.0f) + zero, vec3(3.0f, 2.0f, 0.5f)), 8.0f, 9.0f, 2.0f);
	SHADE_VOCABULARY_IS(pow(zero + 2.0f, 0.5f), 1.41421356f);
	SHADE_VOCABULARY_IS2(sin(vec2(0.0f, 1.57079633f) + zero), 0.0f, 1.0f);
	SHADE_VOCABULARY_IS2(cos(vec2(0.0f, 3.14159265f) + zero), 1.0f, -1.0f);
	SHADE_VOCABULARY_IS(tan(zero + 0.78539816f), 1.0f);
	SHADE_VOCABULARY_IS(atan(zero + 1.0f), 0.78539816f);
	SHADE_VOCABULARY_IS(atan(zero - 1.0f, -1.0f), -2.35619449f);
	return 0;
}

/* acos and asin, whose answers are compared with a tolerance: lavapipe, the software GPU, has errors of up to 3e-4. */
SHADE_FN int shade_vocabulary_arcs(float zero)
{
	SHADE_VOCABULARY_IS(0.01f * asin(zero + 0.5f), 0.01f * 0.52359878f);
	SHADE_VOCABULARY_IS(0.01f * acos(zero + 0.5f), 0.01f * 1.04719755f);
	return 0;
}

SHADE_FN int shade_vocabulary_overloads(float zero)
{
	vec3 v = vec3(-1.5f, 0.25f, 4.0f) + zero;
	vec2 w = vec2(-1.5f, 0.25f) + zero;
	SHADE_VOCABULARY_IS(min(zero, 1.0f) + max(zero, 1.0f), 1.0f);
	SHADE_VOCABULARY_IS2(min(w, 0.0f), -1.5f, 0.0f);
	SHADE_VOCABULARY_IS2(max(w, vec2(0.0f, 1.0f)), 0.0f, 1.0f);
	SHADE_VOCABULARY_IS3(min(v, 1.0f), -1.5f, 0.25f, 1.0f);
	SHADE_VOCABULARY_IS3(max(v, vec3(0.0f, 1.0f, 2.0f)), 0.0f, 1.0f, 4.0f);
	SHADE_VOCABULARY_IS(clamp(zero - 3.0f, -1.0f, 1.0f), -1.0f);
	SHADE_VOCABULARY_IS2(clamp(w, -1.0f, 0.1f), -1.0f, 0.1f);
	SHADE_VOCABULARY_IS3(clamp(v, 0.0f, 1.0f), 0.0f, 0.25f, 1.0f);
	SHADE_VOCABULARY_IS3(clamp(v, vec3(-1.0f), vec3(0.0f, 0.1f, 9.0f)), -1.0f, 0.1f, 4.0f);
	SHADE_VOCABULARY_IS(mix(zero, 8.0f, 0.25f), 2.0f);
	SHADE_VOCABULARY_IS2(mix(w, vec2(0.5f, 0.25f), 0.5f), -0.5f, 0.25f);
	SHADE_VOCABULARY_IS3(mix(v, vec3(0.0f), 0.5f), -0.75f, 0.125f, 2.0f);
	SHADE_VOCABULARY_IS3(mix(v, vec3(0.0f), vec3(0.0f, 1.0f, 0.5f)), -1.5f, 0.0f, 2.0f);
	SHADE_VOCABULARY_IS(step(0.5f, zero) + step(0.0f, zero), 1.0f);
	SHADE_VOCABULARY_IS3(step(0.25f, v), 0.0f, 1.0f, 1.0f);
	SHADE_VOCABULARY_IS3(step(vec3(-2.0f, 1.0f, 9.0f), v), 1.0f, 0.0f, 0.0f);
	SHADE_VOCABULARY_IS(smoothstep(-1.0f, 1.0f, zero), 0.5f);
	SHADE_VOCABULARY_IS2(smoothstep(-1.0f, 1.0f, w), 0.0f, 0.68359375f);
	SHADE_VOCABULARY_IS3(max(min(max(v, 0.0f), max(vec3(2.0f), 1.0f)), mix(v, v, 0.5f)), 0.0f, 0.25f, 4.0f);
	return 0;
}

SHADE_FN int shade_vocabulary_geometry(float zero)
{
	vec3 v = vec3(2.0f, 3.0f, 6.0f) + zero;
	vec2 w = vec2(3.0f, 4.0f) + zero;
	SHADE_VOCABULARY_IS(dot(v, vec3(1.0f, 10.0f, 100.0f)), 632.0f);
	SHADE_VOCABULARY_IS(dot(w, vec2(1.0f, 10.0f)), 43.0f);
	SHADE_VOCABULARY_IS(dot4(vec4(v, 9.0f), vec4(1.0f, 10.0f, 100.0f, 1000.0f)), 9632.0f);
	SHADE_VOCABULARY_IS(length(v) + length(w), 12.0f);
	SHADE_VOCABULARY_IS(distance(v, vec3(2.0f, 3.0f, 5.0f)) + distance(w, vec2(0.0f)), 6.0f);
	SHADE_VOCABULARY_IS3(normalize(v) * 7.0f, 2.0f, 3.0f, 6.0f);
	SHADE_VOCABULARY_IS2(normalize(w) * 5.0f, 3.0f, 4.0f);
	SHADE_VOCABULARY_IS3(cross(vec3(1.0f, 0.0f, zero), vec3(0.0f, 1.0f, 0.0f)), 0.0f, 0.0f, 1.0f);
	SHADE_VOCABULARY_IS3(reflect(v, vec3(0.0f, 1.0f, 0.0f)), 2.0f, -3.0f, 6.0f);
	SHADE_VOCABULARY_IS2(reflect(w, vec2(1.0f, 0.0f)), -3.0f, 4.0f);
	return 0;
}

SHADE_FN int shade_vocabulary_fault(float zero)
{
	int line = shade_vocabulary_values(zero);
	line = select(line != 0, line, shade_vocabulary_lanes(zero));
	line = select(line != 0, line, shade_vocabulary_arcs(zero));
	line = select(line != 0, line, shade_vocabulary_overloads(zero));
	return select(line != 0, line, shade_vocabulary_geometry(zero));
}

#include "shading/glsl_end.h"
#endif
