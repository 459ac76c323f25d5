/*
 * glsl_end: turns the vocabulary of glsl_begin.h off; no macro of it is left, and those it put aside are back.
 */
#ifndef SHADE_FN
#error "glsl_end.h without glsl_begin.h"
#endif

#undef SHADE_FN
#undef SHADE_CONST
#undef SHADE_STRUCT

#ifdef GL_core_profile

#undef dot4
#undef select

#else

#undef stilb_vec2
#undef stilb_vec3
#undef stilb_vec4
#undef glsl_uint
#undef GLSL_VEC2_1
#undef GLSL_VEC2_2
#undef GLSL_VEC3_1
#undef GLSL_VEC3_2
#undef GLSL_VEC3_3
#undef GLSL_VEC4_1
#undef GLSL_VEC4_2
#undef GLSL_VEC4_4
#undef GLSL_ATAN_1
#undef GLSL_ATAN_2
#undef GLSL_CALL
#undef GLSL_PASTE
#undef GLSL_COUNT
#undef GLSL_FIFTH
#undef GLSL_PICK1
#undef GLSL_PICK2
#undef GLSL_PICK3

#pragma pop_macro("vec2")
#pragma pop_macro("vec3")
#pragma pop_macro("vec4")
#pragma pop_macro("float")
#pragma pop_macro("int")
#pragma pop_macro("uint")
#pragma pop_macro("abs")
#pragma pop_macro("sign")
#pragma pop_macro("floor")
#pragma pop_macro("ceil")
#pragma pop_macro("fract")
#pragma pop_macro("sqrt")
#pragma pop_macro("inversesqrt")
#pragma pop_macro("exp")
#pragma pop_macro("exp2")
#pragma pop_macro("log")
#pragma pop_macro("log2")
#pragma pop_macro("sin")
#pragma pop_macro("cos")
#pragma pop_macro("tan")
#pragma pop_macro("asin")
#pragma pop_macro("acos")
#pragma pop_macro("atan")
#pragma pop_macro("pow")
#pragma pop_macro("mod")
#pragma pop_macro("min")
#pragma pop_macro("max")
#pragma pop_macro("step")
#pragma pop_macro("clamp")
#pragma pop_macro("mix")
#pragma pop_macro("smoothstep")
#pragma pop_macro("dot")
#pragma pop_macro("dot4")
#pragma pop_macro("length")
#pragma pop_macro("distance")
#pragma pop_macro("normalize")
#pragma pop_macro("cross")
#pragma pop_macro("reflect")
#pragma pop_macro("select")
#pragma pop_macro("floatBitsToUint")
#pragma pop_macro("uintBitsToFloat")

#endif
