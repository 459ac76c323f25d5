/* What frames and rays show of materials, as a table of Markdown; docs/materials.md holds the same one. */
#include "info_materials.h"

/* X(part of a material, frames, rays) */
#define MATERIAL_PARTS(X)                                                                                              \
	X("base colour: factor, texture, colours of vertices", "yes", "yes")                                               \
	X("metalness and roughness: factors, texture", "yes", "yes")                                                       \
	X("specular and glossiness: factors, textures", "yes", "yes")                                                      \
	X("reflectance: index of refraction, specular factor and colour", "yes", "yes")                                    \
	X("specular textures", "yes", "yes")                                                                               \
	X("normal texture, tangents of the file or MikkTSpace", "yes", "yes")                                              \
	X("occlusion texture", "of even light", "no: rays find what occludes")                                             \
	X("emission: factor, strength, texture", "from the front; lights nothing",                                         \
	  "from the front; lights, where it glows")                                                                        \
	X("alpha: mask with cutoff", "yes", "yes")                                                                         \
	X("alpha: blend", "sorted by model", "by chance, a sample at a time")                                              \
	X("one-sided, of materials with a texture, alpha or vertex colours", "yes", "yes")                                 \
	X("unlit", "yes", "yes")                                                                                           \
	X("two uv, transforms, wrapping, hard texels", "yes", "yes")                                                       \
	X("textures of 16 bits and halves", "yes", "yes")                                                                  \
	X("compressed textures: DDS with BC1, BC3, BC4, BC5, BC7", "yes", "yes: decoded")                                  \
	X("clear coat: factors, textures", "yes", "yes")                                                                   \
	X("sheen: factors, textures", "yes; under a panorama by the light about its lobe's middle", "yes")                 \
	X("transmission: thin walls, smooth and rough, tinted", "yes, but not through one another", "yes")                 \
	X("volume: refraction, absorption", "once, by the thickness",                                                      \
	  "by the way inside; thickness only says that there is one")                                                      \
	X("anisotropy: strength, rotation, texture", "of GGX", "of GGX")                                                   \
	X("iridescence, dispersion", "no", "no")                                                                           \
	X("a function of the program's own", "yes", "no: they say so, by its name")

void info_print_materials(FILE *out)
{
	fputs("| part of a material | frames | rays |\n|---|---|---|\n", out);
#define PART(part, frames, rays) fputs("| " part " | " frames " | " rays " |\n", out);
	MATERIAL_PARTS(PART)
}
