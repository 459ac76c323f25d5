/*
 * shade_gltf: from the factors and texels of a material as glTF 2.0 has it to what is shaded. Both renderers include
 * it. [any-thread]
 *
 * Every texel is linear: colours were decoded from sRGB, data are codes in [0, 1]. Factors and texels are multiplied
 * before they come here, by the colours of vertices too.
 * Sources: Khronos, "glTF 2.0 specification" (2021), 3.9 and appendix B; KHR_materials_ior, _specular,
 * _pbrSpecularGlossiness, _anisotropy.
 */
#ifndef SHADE_GLTF_H
#define SHADE_GLTF_H

#include "shade_energy.h"
#include "shade_frame.h"

#include "glsl_begin.h"

/* diffuse + specular <= 1 per channel; specular is the reflectance at normal incidence. roughness: [0, 1], its square
 * is alpha. */
SHADE_STRUCT(shade_gltf_base)
{
	vec3 diffuse;
	vec3 specular;
	float roughness;
};

/* Reflectance at normal incidence of a dielectric in air: ((n - 1) / (n + 1))^2. ior: 0, which stands for a mirror, or
 * at least 1. */
SHADE_FN float shade_gltf_reflectance(float ior)
{
	float root = select(ior > 0.0f, (ior - 1.0f) / (ior + 1.0f), 1.0f);
	return root * root;
}

/* The same with KHR_materials_specular: tinted, >= 0, at most 1 a channel, then weighted, [0, 1]. */
SHADE_FN vec3 shade_gltf_dielectric(float ior, vec3 tint, float weight)
{
	return min(tint * shade_gltf_reflectance(ior), 1.0f) * weight;
}

/* Metal reflects its colour as highlight and nothing as diffuse light; a dielectric its colour as diffuse light and
 * `dielectric` (shade_gltf_dielectric) as highlight. color, metalness, roughness: [0, 1]. What the highlight takes at
 * normal incidence is missing in the diffuse light, by its strongest channel, so that the surface keeps its hue. */
SHADE_FN shade_gltf_base shade_gltf_metallic(vec3 color, float metalness, float roughness, vec3 dielectric)
{
	float strongest = max(dielectric[0], max(dielectric[1], dielectric[2]));
	vec3 diffuse = color * ((1.0f - metalness) * (1.0f - strongest));
	vec3 specular = dielectric * (1.0f - metalness) + color * metalness;
	shade_gltf_base base = {diffuse, specular, roughness};
	return base;
}

/* KHR_materials_pbrSpecularGlossiness: the diffuse light is what the strongest channel of the highlight leaves of it.
 * All [0, 1]. */
SHADE_FN shade_gltf_base shade_gltf_specular(vec3 diffuse, vec3 specular, float gloss)
{
	float strongest = max(specular[0], max(specular[1], specular[2]));
	shade_gltf_base base = {diffuse * (1.0f - strongest), specular, 1.0f - gloss};
	return base;
}

/* ---- and back ---------------------------------------------------------------------------------------------------- */

SHADE_STRUCT(shade_gltf_color)
{
	vec3 color;
	float metalness;
};

#define SHADE_GLTF_PLASTIC 0.04f /* shade_gltf_reflectance of the index 1.5 */
#define SHADE_GLTF_PLASTIC_MOST 0.0401f
#define SHADE_GLTF_SHARE_MIN 1e-6f

/* The colour and metalness that give these reflectances, diffuse + specular <= 1: the inverse of shade_gltf_metallic
 * for the dielectric SHADE_GLTF_PLASTIC. With u = 1 - metalness, F = SHADE_GLTF_PLASTIC and c, d, s the means over the
 * channels of colour, diffuse and specular: d = (1 - F) u c and s = F u + (1 - u) c, so that
 * F (1 - F) u^2 - ((1 - F) s + d) u + d = 0, whose smaller root lies in [0, 1] for s > F. What reflects no more than
 * the dielectric is no metal, so that colours darker than F have no inverse; what reflects more counts as partly metal,
 * a dielectric of a higher index, too. */
SHADE_FN shade_gltf_color shade_gltf_unmixed(vec3 diffuse, vec3 specular)
{
	float d = (diffuse[0] + diffuse[1] + diffuse[2]) / 3.0f;
	float s = (specular[0] + specular[1] + specular[2]) / 3.0f;
	float b = (1.0f - SHADE_GLTF_PLASTIC) * s + d;
	float c = SHADE_GLTF_PLASTIC * (1.0f - SHADE_GLTF_PLASTIC);
	float u = 2.0f * d / max(b + sqrt(max(b * b - 4.0f * c * d, 0.0f)), SHADE_GLTF_SHARE_MIN);
	float metalness = select(s > SHADE_GLTF_PLASTIC_MOST, clamp(1.0f - u, 0.0f, 1.0f), 0.0f);
	float left = 1.0f - metalness;
	float taken = select(metalness > 0.0f, SHADE_GLTF_PLASTIC, max(specular[0], max(specular[1], specular[2])));
	vec3 of_metal = select(metalness > 0.0f, specular - SHADE_GLTF_PLASTIC * left, vec3(0.0f));
	vec3 color = diffuse / (1.0f - taken) + of_metal; /* u c and (1 - u) c */
	shade_gltf_color found = {clamp(color, 0.0f, 1.0f), metalness};
	return found;
}

/* ---- normals ----------------------------------------------------------------------------------------------------- */

#define SHADE_GLTF_NORMAL_MIN 1e-12f /* square of a length: shorter vectors have no direction */

/* A map's normal in the frame of tangent, bitangent and normal, unit: (2 texel - 1) with x and y times scale. Black,
 * which has no direction that is in front, and what is behind the surface count as they stand. */
SHADE_FN vec3 shade_gltf_normal(vec3 texel, float scale)
{
	vec3 n = texel * 2.0f - 1.0f;
	n = vec3(n[0] * scale, n[1] * scale, n[2]);
	float square = dot(n, n);
	return select(square > SHADE_GLTF_NORMAL_MIN, n / sqrt(max(square, SHADE_GLTF_NORMAL_MIN)), vec3(0.0f, 0.0f, 1.0f));
}

/* The third channel of a map of two, [0, 1] each, which holds unit vectors in front of the surface. */
SHADE_FN float shade_gltf_normal_z(float x, float y)
{
	float a = 2.0f * x - 1.0f, b = 2.0f * y - 1.0f;
	return 0.5f * sqrt(max(1.0f - a * a - b * b, 0.0f)) + 0.5f;
}

/* The map's normal in the space of tangent and normal, unit. These are interpolated, of any length, as MikkTSpace wants
 * it; sign: 1 or -1, of the bitangent. The normal itself where the sum has no length. */
SHADE_FN vec3 shade_gltf_turned(vec3 local, vec3 tangent, float sign, vec3 normal)
{
	vec3 n = tangent * local[0] + cross(normal, tangent) * (local[1] * sign) + normal * local[2];
	float square = dot(n, n);
	return select(square > SHADE_GLTF_NORMAL_MIN, n / sqrt(max(square, SHADE_GLTF_NORMAL_MIN)), normal);
}

/* The roughness of a surface whose facets have `roughness` about normals that spread themselves, [0, 1] both. spread:
 * the alpha of a lobe of normals, of shade_filter_convolution for an alpha of 0; widths of lobes are added as squares.
 * Where normals do not spread, the roughness as it is. Source: Karis, "Normal map filtering using vMF (part 3)" (2018):
 * alpha'^2 = alpha^2 + 2 / sharpness. */
SHADE_FN float shade_gltf_widened(float roughness, float spread)
{
	float alpha = roughness * roughness;
	float widened = sqrt(sqrt(min(alpha * alpha + spread * spread, 1.0f)));
	return select(spread > 0.0f, widened, roughness);
}

/* ---- the rest ---------------------------------------------------------------------------------------------------- */

/* The share of even light that arrives. texel, strength: [0, 1]. */
SHADE_FN float shade_gltf_occlusion(float texel, float strength)
{
	return 1.0f + strength * (texel - 1.0f);
}

#include "glsl_end.h"
#endif
