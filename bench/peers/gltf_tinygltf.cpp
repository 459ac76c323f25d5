/* tinygltf with its own decoder of pictures, stb_image: one thread, all pictures as RGBA. */
#include "bench/gltf/gltf_tinygltf.h"

#include <cstdio>
#include <exception>
#include <string>
#include <tiny_gltf.h>

size_t gltf_tinygltf_read(const char *path, char why[256])
{
	try {
		tinygltf::TinyGLTF reader;
		tinygltf::Model model;
		std::string error, warning;
		size_t bytes = 1;
		bool good = reader.LoadASCIIFromFile(&model, &error, &warning, path);
		for (const tinygltf::Image &image : model.images)
			bytes += image.image.size();
		std::snprintf(why, 256, "%s", error.c_str());
		return good ? bytes : 0;
	} catch (const std::exception &problem) {
		std::snprintf(why, 256, "%s", problem.what());
		return 0;
	}
}
