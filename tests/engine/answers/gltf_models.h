/* Models that a test writes, larger than the known answers: for comparing frames with rays, and with other viewers, in
 * the metric of Khronos' glTF-Render-Fidelity set (image/image_compare.h). */
#ifndef GLTF_MODELS_H
#define GLTF_MODELS_H

#include <stdbool.h>
#include <stdint.h>

/* Writes NAME.gltf, its .bin and its pictures into the current folder; side: of the pictures, texels.
 *
 * helmet:   15,128 triangles, one mesh; both halves share mirrored uv; five maps: colour, metalness and roughness,
 *           normals (without tangents in the file), occlusion, emission of a visor.
 * spheres:  7 x 7 spheres, metalness from 0 to 1 upwards, roughness from 0.1 to 1 to the right.
 *
 * False: a file cannot be written. */
bool gltf_model_helmet(uint32_t side);
bool gltf_model_spheres(void);

/* Writes a panorama of soft lamps in a grey room, width x width / 2 texels. */
bool gltf_model_room(const char *path, uint32_t width);

#endif
