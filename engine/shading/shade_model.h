/*
 * shade_model: the names of the reflection models of shade_brdf.h and of the factors of shade_specular.h, as integers.
 * The only shading header that is C++ too.
 */
#ifndef SHADE_MODEL_H
#define SHADE_MODEL_H

#define SHADE_BRDF_LAMBERT 0
#define SHADE_BRDF_WRAPPED 1
#define SHADE_BRDF_PHONG 2
#define SHADE_BRDF_PHONG_MODIFIED 3
#define SHADE_BRDF_BLINN_PHONG 4
#define SHADE_BRDF_BLINN_PHONG_MODIFIED 5
#define SHADE_BRDF_MINIMALIST 6
#define SHADE_BRDF_MICROFACET 7 /* any D x G x F */
#define SHADE_BRDF_COUNT 8

/* X(integer, identifier): for lists of names; C makes a string of the identifier. */
#define SHADE_BRDFS(X)                                                                                                 \
	X(SHADE_BRDF_LAMBERT, lambert)                                                                                     \
	X(SHADE_BRDF_WRAPPED, wrapped)                                                                                     \
	X(SHADE_BRDF_PHONG, phong)                                                                                         \
	X(SHADE_BRDF_PHONG_MODIFIED, phong_modified)                                                                       \
	X(SHADE_BRDF_BLINN_PHONG, blinn_phong)                                                                             \
	X(SHADE_BRDF_BLINN_PHONG_MODIFIED, blinn_phong_modified)                                                           \
	X(SHADE_BRDF_MINIMALIST, minimalist)                                                                               \
	X(SHADE_BRDF_MICROFACET, microfacet)

#define SHADE_NDF_BLINN 0
#define SHADE_NDF_BECKMANN 1
#define SHADE_NDF_GGX 2
#define SHADE_NDF_GGX_ANISOTROPIC 3
#define SHADE_NDF_COUNT 4

#define SHADE_G_IMPLICIT 0
#define SHADE_G_NEUMANN 1
#define SHADE_G_COOK_TORRANCE 2
#define SHADE_G_KELEMEN 3
#define SHADE_G_SMITH_BECKMANN 4
#define SHADE_G_SMITH_GGX 5
#define SHADE_G_SCHLICK_BECKMANN 6
#define SHADE_G_SCHLICK_GGX 7
#define SHADE_G_COUNT 8

#define SHADE_F_NONE 0
#define SHADE_F_SCHLICK 1
#define SHADE_F_COOK_TORRANCE 2
#define SHADE_F_COUNT 3

#define SHADE_NDFS(X)                                                                                                  \
	X(SHADE_NDF_BLINN, blinn)                                                                                          \
	X(SHADE_NDF_BECKMANN, beckmann)                                                                                    \
	X(SHADE_NDF_GGX, ggx)                                                                                              \
	X(SHADE_NDF_GGX_ANISOTROPIC, ggx_anisotropic)
#define SHADE_GS(X)                                                                                                    \
	X(SHADE_G_IMPLICIT, implicit)                                                                                      \
	X(SHADE_G_NEUMANN, neumann)                                                                                        \
	X(SHADE_G_COOK_TORRANCE, cook_torrance)                                                                            \
	X(SHADE_G_KELEMEN, kelemen)                                                                                        \
	X(SHADE_G_SMITH_BECKMANN, smith_beckmann)                                                                          \
	X(SHADE_G_SMITH_GGX, smith_ggx)                                                                                    \
	X(SHADE_G_SCHLICK_BECKMANN, schlick_beckmann)                                                                      \
	X(SHADE_G_SCHLICK_GGX, schlick_ggx)
#define SHADE_FS(X)                                                                                                    \
	X(SHADE_F_NONE, none)                                                                                              \
	X(SHADE_F_SCHLICK, schlick)                                                                                        \
	X(SHADE_F_COOK_TORRANCE, cook_torrance)

/* kind is a SHADE_BRDF_; ndf, g and f are a SHADE_NDF_, SHADE_G_ and SHADE_F_, and say something for
 * SHADE_BRDF_MICROFACET alone. */
struct shade_brdf_model {
	int kind;
	int ndf;
	int g;
	int f;
};
#ifndef GL_core_profile
typedef struct shade_brdf_model shade_brdf_model;
#endif

#endif
