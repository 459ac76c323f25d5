/*
 * glsl_begin: turns the vocabulary of the shading dialect on; glsl_end.h turns it off again. No include guard: every
 * shading header includes the pair around its own functions, after the other shading headers.
 *
 * The same text is then C (gcc 12, clang 14) and GLSL (4.20 or later): vec2, vec3, vec4 and uint with their
 * constructors, elements as v[0], the built-in functions below on float, vec2 and vec3, and
 *   SHADE_FN                before a function;
 *   SHADE_CONST             before a table;
 *   SHADE_STRUCT(name)      in front of { members };
 *   select(condition, a, b) a scalar condition, only the chosen side is evaluated;
 *   dot4(a, b)              four lanes, since in C dot of a vec3 and of a vec4 cannot be told apart.
 * What the dialect leaves out is in docs/design.md. Literals carry f: in C a double is
 * an error of -Wdouble-promotion, and an int as first operand does not compile.
 *
 * A macro of the same name from elsewhere (<tgmath.h> has sqrt, pow, ...; a user may have max) is put aside and comes
 * back with glsl_end.h.
 */
#ifdef SHADE_FN
#error "glsl_begin.h twice without glsl_end.h: include other shading headers before it"
#endif

#ifdef GL_ES
#error "the shading headers are GLSL 4.20 or later, core profile: '#version 450', not an 'es' version"
#endif

#ifdef GL_core_profile

#if __VERSION__ < 420
#error "the shading headers are GLSL 4.20 or later: '#version 450'"
#endif
#define SHADE_FN
#define SHADE_CONST const
#define SHADE_STRUCT(name) struct name
#define dot4(a, b) dot(a, b)
#define select(condition, a, b) ((condition) ? (a) : (b))

#else

#include "base/glsl_types.h"

/* Always: a call by an integer that the caller knows (shade_brdf_cos) then keeps the one branch, however large the
 * rest. */
#ifdef __OPTIMIZE__
#define SHADE_FN static inline __attribute__((always_inline))
#else
#define SHADE_FN static inline
#endif
#define SHADE_CONST static const __attribute__((unused))
#define SHADE_STRUCT(name)                                                                                             \
	typedef struct name name;                                                                                          \
	struct name

#pragma push_macro("vec2")
#pragma push_macro("vec3")
#pragma push_macro("vec4")
#pragma push_macro("float")
#pragma push_macro("int")
#pragma push_macro("uint")
#pragma push_macro("abs")
#pragma push_macro("sign")
#pragma push_macro("floor")
#pragma push_macro("ceil")
#pragma push_macro("fract")
#pragma push_macro("sqrt")
#pragma push_macro("inversesqrt")
#pragma push_macro("exp")
#pragma push_macro("exp2")
#pragma push_macro("log")
#pragma push_macro("log2")
#pragma push_macro("sin")
#pragma push_macro("cos")
#pragma push_macro("tan")
#pragma push_macro("asin")
#pragma push_macro("acos")
#pragma push_macro("atan")
#pragma push_macro("pow")
#pragma push_macro("mod")
#pragma push_macro("min")
#pragma push_macro("max")
#pragma push_macro("step")
#pragma push_macro("clamp")
#pragma push_macro("mix")
#pragma push_macro("smoothstep")
#pragma push_macro("dot")
#pragma push_macro("dot4")
#pragma push_macro("length")
#pragma push_macro("distance")
#pragma push_macro("normalize")
#pragma push_macro("cross")
#pragma push_macro("reflect")
#pragma push_macro("select")
#pragma push_macro("floatBitsToUint")
#pragma push_macro("uintBitsToFloat")

#undef vec2
#undef vec3
#undef vec4
#undef float
#undef int
#undef uint
#undef abs
#undef sign
#undef floor
#undef ceil
#undef fract
#undef sqrt
#undef inversesqrt
#undef exp
#undef exp2
#undef log
#undef log2
#undef sin
#undef cos
#undef tan
#undef asin
#undef acos
#undef atan
#undef pow
#undef mod
#undef min
#undef max
#undef step
#undef clamp
#undef mix
#undef smoothstep
#undef dot
#undef dot4
#undef length
#undef distance
#undef normalize
#undef cross
#undef reflect
#undef select
#undef floatBitsToUint
#undef uintBitsToFloat

/* Types that are constructors too: vec3 is the type stilb_vec3, and where a parenthesis follows, a function. */
#define vec2 stilb_vec2
#define vec3 stilb_vec3
#define vec4 stilb_vec4
#define uint glsl_uint
#define stilb_vec2(...) GLSL_CALL(GLSL_VEC2_, GLSL_COUNT(__VA_ARGS__))(__VA_ARGS__)
#define stilb_vec3(...) GLSL_CALL(GLSL_VEC3_, GLSL_COUNT(__VA_ARGS__))(__VA_ARGS__)
#define stilb_vec4(...) GLSL_CALL(GLSL_VEC4_, GLSL_COUNT(__VA_ARGS__))(__VA_ARGS__)
#define glsl_uint(x) ((glsl_uint)(x))
#ifdef __clang__
#pragma clang diagnostic push
#pragma clang diagnostic ignored "-Wkeyword-macro" /* of -pedantic */
#endif
#define float(x) ((float)(x))
#define int(x) ((int)(x))
#ifdef __clang__
#pragma clang diagnostic pop
#endif

// clang-format off
#define GLSL_VEC2_1(v) \
	_Generic((v), float: glsl_vec2_splat, stilb_vec2: glsl_vec2_same, stilb_vec4: glsl_vec2_first)(v)
#define GLSL_VEC2_2(x, y) glsl_vec2_make2(x, y)
#define GLSL_VEC3_1(v) _Generic((v), float: glsl_vec4_splat, stilb_vec4: glsl_vec4_same)(v)
#define GLSL_VEC3_2(v, z) glsl_vec3_make2(v, z)
#define GLSL_VEC3_3(x, y, z) glsl_vec3_make3(x, y, z)
#define GLSL_VEC4_1(v) GLSL_VEC3_1(v)
#define GLSL_VEC4_2(v, w) glsl_vec4_make2(v, w)
#define GLSL_VEC4_4(x, y, z, w) glsl_vec4_make4(x, y, z, w)
#define GLSL_ATAN_1(x) GLSL_PICK1(atan, x)(x)
#define GLSL_ATAN_2(y, x) GLSL_PICK1(atan2, y)(y, x)
#define GLSL_CALL(prefix, count) GLSL_PASTE(prefix, count)
#define GLSL_PASTE(a, b) a##b
#define GLSL_COUNT(...) GLSL_FIFTH(__VA_ARGS__, 4, 3, 2, 1, 0)
#define GLSL_FIFTH(a, b, c, d, e, ...) e

/* Names the C function that an overloaded GLSL function stands for: its suffix follows from the type of the first
 * operand x and, where a vector may be combined with a number, from whether the other operand is a float ("f"). */
#define GLSL_PICK1(name, x) \
	_Generic((x), float: glsl_##name##_1, stilb_vec2: glsl_##name##_2, stilb_vec4: glsl_##name##_4)
#define GLSL_PICK2(name, x, other) \
	_Generic((x), \
		float: glsl_##name##_1, \
		stilb_vec2: _Generic((other), float: glsl_##name##_2f, default: glsl_##name##_2), \
		stilb_vec4: _Generic((other), float: glsl_##name##_4f, default: glsl_##name##_4))
#define GLSL_PICK3(name, x) _Generic((x), stilb_vec2: glsl_##name##_2, stilb_vec3: glsl_##name##_3)
// clang-format on

#define abs(x) GLSL_PICK1(abs, x)(x)
#define sign(x) GLSL_PICK1(sign, x)(x)
#define floor(x) GLSL_PICK1(floor, x)(x)
#define ceil(x) GLSL_PICK1(ceil, x)(x)
#define fract(x) GLSL_PICK1(fract, x)(x)
#define sqrt(x) GLSL_PICK1(sqrt, x)(x)
#define inversesqrt(x) GLSL_PICK1(inversesqrt, x)(x)
#define exp(x) GLSL_PICK1(exp, x)(x)
#define exp2(x) GLSL_PICK1(exp2, x)(x)
#define log(x) GLSL_PICK1(log, x)(x)
#define log2(x) GLSL_PICK1(log2, x)(x)
#define sin(x) GLSL_PICK1(sin, x)(x)
#define cos(x) GLSL_PICK1(cos, x)(x)
#define tan(x) GLSL_PICK1(tan, x)(x)
#define asin(x) GLSL_PICK1(asin, x)(x)
#define acos(x) GLSL_PICK1(acos, x)(x)
#define atan(...) GLSL_CALL(GLSL_ATAN_, GLSL_COUNT(__VA_ARGS__))(__VA_ARGS__)
#define pow(x, y) GLSL_PICK1(pow, x)(x, y)
#define min(x, y) GLSL_PICK2(min, x, y)(x, y)
#define max(x, y) GLSL_PICK2(max, x, y)(x, y)
#define mod(x, y) GLSL_PICK2(mod, x, y)(x, y)
#define step(edge, x) GLSL_PICK2(step, x, edge)(edge, x)
#define clamp(x, low, high) GLSL_PICK2(clamp, x, low)(x, low, high)
#define mix(x, y, a) GLSL_PICK2(mix, x, a)(x, y, a)
#define smoothstep(edge0, edge1, x) GLSL_PICK2(smoothstep, x, edge0)(edge0, edge1, x)

#define dot(a, b) GLSL_PICK3(dot, a)(a, b)
#define dot4(a, b) glsl_dot4(a, b)
#define length(v) GLSL_PICK3(length, v)(v)
#define distance(a, b) GLSL_PICK3(distance, a)(a, b)
#define normalize(v) GLSL_PICK3(normalize, v)(v)
#define cross(a, b) glsl_cross(a, b)
#define reflect(i, n) GLSL_PICK3(reflect, i)(i, n)

#define select(condition, a, b) ((condition) ? (a) : (b))
#define floatBitsToUint(x) glsl_float_bits(x)
#define uintBitsToFloat(x) glsl_bits_float(x)

#endif
