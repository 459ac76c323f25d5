#include "scene/importer/gltf/gltf_draco.h"

#include <cstdlib>
#include <draco/compression/decode.h>
#include <new>

void gltf_draco_finish(gltf_draco_mesh *mesh)
{
	std::free(mesh->indices);
	mesh->indices = nullptr;
	for (gltf_draco_values &values : mesh->values) {
		std::free(values.data);
		values.data = nullptr;
	}
}

static const char *draco_take_indices(const draco::Mesh &from, gltf_draco_mesh *mesh)
{
	mesh->point_count = from.num_points();
	mesh->index_count = 3 * from.num_faces();
	mesh->indices = static_cast<uint32_t *>(std::calloc(mesh->index_count + size_t{1}, sizeof(uint32_t)));
	if (!mesh->indices)
		throw std::bad_alloc();
	uint32_t *out = mesh->indices;
	for (draco::FaceIndex f(0); f < from.num_faces(); ++f)
		for (int corner = 0; corner < 3; corner++) {
			uint32_t index = from.face(f)[corner].value();
			if (index >= mesh->point_count)
				return "its triangles have points that do not exist";
			*out++ = index;
		}
	return nullptr;
}

static const char *draco_take_values(const draco::Mesh &from, gltf_draco_values *values)
{
	const draco::PointAttribute *attribute = from.GetAttributeByUniqueId(values->id);
	if (!attribute || !attribute->buffer() || attribute->size() == 0)
		return "it lacks an attribute that the file names";
	size_t components = values->components, stored = size_t(attribute->num_components());
	if (stored < components && !(values->alpha && stored == 3))
		return "an attribute has too few numbers a point";
	values->data = static_cast<float *>(std::calloc(from.num_points() * components + 1, sizeof(float)));
	if (!values->data)
		throw std::bad_alloc();
	for (draco::PointIndex p(0); p < from.num_points(); ++p) {
		draco::AttributeValueIndex index = attribute->mapped_index(p);
		if (index.value() >= attribute->size() ||
		    !attribute->ConvertValue<float>(index, static_cast<int8_t>(components),
		                                    values->data + p.value() * components))
			return "the values of a point do not exist";
		if (stored < components)
			values->data[p.value() * components + 3] = 1.0f;
	}
	return nullptr;
}

static const char *draco_take(const draco::Mesh &from, gltf_draco_mesh *mesh)
{
	const char *why = draco_take_indices(from, mesh);
	for (gltf_draco_values &values : mesh->values)
		if (!why && values.wanted)
			why = draco_take_values(from, &values);
	return why;
}

const char *gltf_draco_decode(const unsigned char *data, size_t size, gltf_draco_mesh *mesh, bool *memory)
{
	const char *why = nullptr;
	*memory = false;
	try {
		draco::DecoderBuffer buffer;
		draco::Decoder decoder;
		buffer.Init(reinterpret_cast<const char *>(data), size);
		auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
		why = decoded.ok() ? draco_take(*decoded.value(), mesh) : "it is damaged";
	} catch (const std::bad_alloc &) {
		*memory = true;
		why = "it needs more memory than there is";
	} catch (...) {
		why = "the library gave it up";
	}
	if (why)
		gltf_draco_finish(mesh);
	return why;
}
