/* The peer of the suite `gltf`: tinygltf, which is C++, behind a function of C. */
#ifndef GLTF_TINYGLTF_H
#define GLTF_TINYGLTF_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Reads the file with its buffers and decodes its pictures, as the library does by itself, then frees all. Returns the
 * bytes of the decoded pictures; 0 and a reason: it failed. */
size_t gltf_tinygltf_read(const char *path, char why[256]);

#ifdef __cplusplus
}
#endif

#endif
