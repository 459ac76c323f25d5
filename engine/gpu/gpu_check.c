/* gpu: rules that follow from a device's limits and formats. Each error names the value, the limit and a way out. */
#include "gpu/gpu_internal.h"

#include <stdio.h>

#define FAIL(...) stilb_fail(STILB_ERROR_ARGUMENT, __VA_ARGS__)

uint64_t gpu_mip_bytes(const stilb_gpu_extent *extent, uint32_t mip)
{
	return stilb_gpu_format_bytes(extent->format, gpu_mip_side(extent->width, mip), gpu_mip_side(extent->height, mip),
	                              gpu_mip_side(extent->depth, mip));
}

/* ---- buffers, images, samplers ----------------------------------------------------------------------------------- */

stilb_result gpu_check_buffer(const stilb_gpu *gpu, const stilb_gpu_buffer_desc *desc)
{
	const char *name = desc->name ? desc->name : "";
	if ((uint32_t)desc->memory > STILB_GPU_MEMORY_READ)
		return FAIL("buffer '%s': there is no kind of memory %u, 0..3 are", name, (unsigned)desc->memory);
	if (desc->bytes == 0)
		return FAIL("buffer '%s' has no bytes; give it at least 1", name);
	if (desc->bytes > gpu->limits.buffer_bytes)
		return FAIL("buffer '%s' of %llu bytes: '%s' has buffers of up to %llu; cut it into several", name,
		            (unsigned long long)desc->bytes, gpu->name, (unsigned long long)gpu->limits.buffer_bytes);
	if (desc->uses == 0 || desc->uses >= 2 * STILB_GPU_BUFFER_UNIFORM)
		return FAIL("buffer '%s': uses %#x are none of STILB_GPU_BUFFER_...", name, desc->uses);
	return STILB_OK;
}

static const char *const use_words[] = {
	[STILB_GPU_USE_SAMPLED] = "be sampled",
	[STILB_GPU_USE_STORAGE_READ] = "be a storage image",
	[STILB_GPU_USE_STORAGE_WRITE] = "be a storage image",
	[STILB_GPU_USE_STORAGE] = "be a storage image",
	[STILB_GPU_USE_VERTICES] = "hold vertices",
	[STILB_GPU_USE_INDIRECT] = "hold commands",
	[STILB_GPU_USE_COPY_FROM] = "be copied from",
	[STILB_GPU_USE_COPY_TO] = "be copied to",
	[STILB_GPU_USE_UNIFORM] = "be uniform buffers",
	[STILB_GPU_USE_HOST] = "be mapped",
	[STILB_GPU_USE_KINDS] = "be drawn into",
};

static stilb_result check_image_uses(const stilb_gpu *gpu, const char *what, const stilb_gpu_extent *extent)
{
	const stilb_gpu_format_info *format = stilb_gpu_format_describe(extent->format);
	uint32_t missing = extent->uses & ~gpu->formats[extent->format];
	if (extent->uses == 0 || extent->uses >= 2 * STILB_GPU_EXTENT_ATTACHMENT)
		return FAIL("%s: uses %#x are none of an image", what, extent->uses);
	if (missing != 0)
		return FAIL("%s: images of format %s cannot %s on '%s'; take another format", what, format->name,
		            use_words[__builtin_ctz(missing)], gpu->name);
	uint32_t storage =
		1u << STILB_GPU_USE_STORAGE_READ | 1u << STILB_GPU_USE_STORAGE_WRITE | 1u << STILB_GPU_USE_STORAGE;
	if (extent->samples > 1 && (extent->uses & storage) != 0)
		return FAIL("%s: an image of %u samples cannot be a storage image; resolve it first", what, extent->samples);
	return STILB_OK;
}

static stilb_result check_sides(const stilb_gpu *gpu, const char *what, const stilb_gpu_extent *e)
{
	const stilb_gpu_limits *limits = &gpu->limits;
	bool solid = e->shape == STILB_GPU_SHAPE_3D;
	uint32_t most = solid                                   ? limits->image_side_3d
	                : e->uses & STILB_GPU_EXTENT_ATTACHMENT ? limits->attachment_side
	                                                        : limits->image_side;
	uint32_t side = e->width > e->height ? e->width : e->height;
	side = side > e->depth ? side : e->depth;
	if (e->width == 0 || e->height == 0 || e->depth == 0 || e->layers == 0 || e->mips == 0)
		return FAIL("%s: %ux%ux%u texels, %u layers, %u mips: none of them may be 0", what, e->width, e->height,
		            e->depth, e->layers, e->mips);
	bool drawn = (e->uses & STILB_GPU_EXTENT_ATTACHMENT) != 0;
	if (!drawn && gpu->faults.image_side > 0 && gpu->faults.image_side < most)
		most = gpu->faults.image_side;
	if (side > most)
		return FAIL("%s: %ux%ux%u texels: '%s' has up to %u a side; make it smaller", what, e->width, e->height,
		            e->depth, gpu->name, most);
	if (e->layers > limits->image_layers)
		return FAIL("%s: %u layers: '%s' has up to %u; use several images", what, e->layers, gpu->name,
		            limits->image_layers);
	if ((!solid && e->depth != 1) || (solid && e->layers != 1))
		return FAIL("%s: only images of shape 3D have depth, and they have 1 layer", what);
	if (e->shape == STILB_GPU_SHAPE_1D && e->height != 1)
		return FAIL("%s: an image of shape 1D has height 1, not %u", what, e->height);
	if (e->shape == STILB_GPU_SHAPE_CUBE && (e->layers % 6 != 0 || e->width != e->height))
		return FAIL("%s: %ux%u texels, %u layers: cubes are square and have 6 layers each", what, e->width, e->height,
		            e->layers);
	if (e->mips > 32u - (uint32_t)__builtin_clz(side))
		return FAIL("%s: %u mips: %u texels a side have at most %u", what, e->mips, side,
		            32u - (unsigned)__builtin_clz(side));
	return STILB_OK;
}

stilb_result gpu_check_image(const stilb_gpu *gpu, const char *name, const stilb_gpu_extent *extent)
{
	char what[GPU_NAME + 16];
	snprintf(what, sizeof what, name ? "image '%.*s'" : "the image%.*s", (int)GPU_NAME, name ? name : "");
	if (extent->format == STILB_GPU_NONE || (uint32_t)extent->format >= STILB_GPU_FORMAT_COUNT ||
	    (uint32_t)extent->shape > STILB_GPU_SHAPE_1D)
		return FAIL("%s: format %u, shape %u: there is no such format or shape", what, (unsigned)extent->format,
		            (unsigned)extent->shape);
	stilb_result result = check_sides(gpu, what, extent);
	if (result == STILB_OK)
		result = check_image_uses(gpu, what, extent);
	if (result != STILB_OK)
		return result;
	uint32_t samples = extent->samples;
	if (samples == 0 || (samples & (samples - 1)) != 0 || (samples > 1 && (gpu->limits.samples & samples) == 0))
		return FAIL("%s: '%s' has no images of %u samples a texel; use 1 or 4", what, gpu->name, samples);
	const stilb_gpu_format_info *format = stilb_gpu_format_describe(extent->format);
	if (samples > 1 && (extent->shape != STILB_GPU_SHAPE_2D || extent->mips > 1 || format->block_side > 1))
		return FAIL("%s: images of several samples are 2D, have 1 mip, and are not compressed", what);
	if (extent->shape == STILB_GPU_SHAPE_3D && extent->uses & STILB_GPU_EXTENT_ATTACHMENT)
		return FAIL("%s: images of shape 3D cannot be drawn into; write them as storage images", what);
	if (format->kind == STILB_GPU_FORMAT_DEPTH && extent->shape != STILB_GPU_SHAPE_2D &&
	    extent->shape != STILB_GPU_SHAPE_CUBE)
		return FAIL("%s: depth images are 2D or cubes", what);
	return STILB_OK;
}

stilb_result gpu_check_channels(const stilb_gpu_image_desc *desc)
{
	uint32_t uses = 1u << STILB_GPU_USE_SAMPLED | 1u << STILB_GPU_USE_COPY_FROM | 1u << STILB_GPU_USE_COPY_TO;
	if ((uint32_t)desc->channels >= STILB_GPU_CHANNELS_COUNT)
		return FAIL("image '%s' has channels %u; there are 0 to %d", desc->name ? desc->name : "",
		            (unsigned)desc->channels, STILB_GPU_CHANNELS_COUNT - 1);
	if (desc->channels != STILB_GPU_CHANNELS_OWN && desc->extent.uses & ~uses)
		return FAIL("image '%s' is seen as grey, so it can be sampled and copied alone; leave its other uses out",
		            desc->name ? desc->name : "");
	return STILB_OK;
}

stilb_result gpu_check_sampler(const stilb_gpu *gpu, const stilb_gpu_sampler_desc *desc)
{
	for (int i = 0; i < 3; i++)
		if (desc->wrap[i] > STILB_GPU_WRAP_MIRROR)
			return FAIL("a sampler with wrap %u: there are 0..2", desc->wrap[i]);
	if (desc->compare > 1)
		return FAIL("a sampler with compare %u: there are 0 and 1", desc->compare);
	if (!(desc->anisotropy >= 0.0f && desc->anisotropy <= gpu->limits.anisotropy))
		return FAIL("a sampler with anisotropy %g: '%s' has 0..%g", (double)desc->anisotropy, gpu->name,
		            (double)gpu->limits.anisotropy);
	return STILB_OK;
}

/* ---- programs ---------------------------------------------------------------------------------------------------- */

/* Bits of the bindings of set 0. */
typedef struct program_bindings {
	uint64_t sampled, storage, uniforms;
} program_bindings;

static program_bindings bindings_of(const stilb_gpu_program_desc *desc)
{
	uint64_t sampled = ((uint64_t)1 << desc->samplers) - 1;
	uint64_t images = ((uint64_t)1 << (desc->samplers + desc->storage_images)) - 1;
	uint64_t all = ((uint64_t)1 << (desc->samplers + desc->storage_images + desc->uniforms)) - 1;
	return (program_bindings){sampled, images & ~sampled, all & ~images};
}

/* What a vertex shader reads lies in vertices, and what a fragment shader reads comes from the stage before it. */
static stilb_result check_stages(const stilb_gpu_program_desc *desc, const gpu_spirv *vertex, const gpu_spirv *fragment)
{
	const char *name = desc->name ? desc->name : "";
	uint32_t given = 0, integers = 0, written = desc->vertex.words ? vertex->outputs : 1; /* uv of FULLSCREEN passes */
	for (uint32_t i = 0; i < desc->input_count; i++) {
		stilb_gpu_format format = (stilb_gpu_format)desc->inputs[i].format;
		uint32_t bit = desc->inputs[i].location < 32 ? 1u << desc->inputs[i].location : 0;
		given |= bit;
		integers |= stilb_gpu_format_describe(format)->kind == STILB_GPU_FORMAT_INTEGER ? bit : 0;
	}
	uint32_t missing = vertex->inputs & ~given, other = (vertex->integer_inputs ^ integers) & vertex->inputs;
	if (missing != 0)
		return FAIL("program '%s': its vertex shader reads location %u, which its vertices do not have", name,
		            (unsigned)__builtin_ctz(missing));
	if (other != 0)
		return FAIL("program '%s': location %u is %s in its vertex shader, and not in its vertices", name,
		            (unsigned)__builtin_ctz(other),
		            vertex->integer_inputs >> __builtin_ctz(other) & 1 ? "an integer" : "a float");
	missing = fragment->inputs & ~written;
	if (missing != 0)
		return FAIL("program '%s': its fragment shader reads location %u, which %s", name,
		            (unsigned)__builtin_ctz(missing),
		            desc->vertex.words ? "its vertex shader does not write" : "programs without a vertex shader lack");
	return STILB_OK;
}

static stilb_result check_shader(const stilb_gpu *gpu, const stilb_gpu_program_desc *desc, const char *stage,
                                 const stilb_gpu_shader *shader, gpu_spirv *out)
{
	gpu_spirv found;
	const char *name = desc->name ? desc->name : "";
	*out = (gpu_spirv){0};
	if (!gpu_spirv_read(shader, &found))
		return FAIL("program '%s': its %s shader is no SPIR-V; compile it with glslc", name, stage);
	if (found.no_memory)
		return stilb_fail(STILB_ERROR_MEMORY, "no memory for reading the shaders of program '%s'", name);
	if (found.wrong)
		return FAIL("program '%s': its %s shader has %s", name, stage, found.wrong);
	program_bindings bindings = bindings_of(desc);
	uint32_t items = (uint32_t)(((uint64_t)1 << desc->set_items) - 1);
	uint32_t wrong = (found.sampled & ~(uint32_t)bindings.sampled) | (found.storage & ~(uint32_t)bindings.storage) |
	                 (found.uniforms & ~(uint32_t)bindings.uniforms);
	if (wrong != 0)
		return FAIL(
			"program '%s': binding %u of set 0 of its %s shader is not declared so: samplers are 0..%d, storage "
			"images the %u behind them, uniform buffers the %u behind these",
			name, (unsigned)__builtin_ctz(wrong), stage, (int)desc->samplers - 1, desc->storage_images, desc->uniforms);
	if (found.uniform_bytes > gpu->limits.uniform_bytes)
		return FAIL("program '%s': a uniform buffer of %u bytes in its %s shader: '%s' has up to %u; read it by its "
		            "address",
		            name, found.uniform_bytes, stage, gpu->name, gpu->limits.uniform_bytes);
	if ((found.items & ~items) != 0)
		return FAIL("program '%s': binding %u of set 1 of its %s shader is not declared: set_items is %u", name,
		            (unsigned)__builtin_ctz(found.items & ~items), stage, desc->set_items);
	uint64_t invocations = 1;
	for (uint32_t i = 0; i < 3; i++) {
		if (found.group_size[i] > gpu->limits.group_size[i])
			return FAIL("program '%s': a work group of %ux%ux%u: '%s' has up to %u along side %u; make it smaller",
			            name, found.group_size[0], found.group_size[1], found.group_size[2], gpu->name,
			            gpu->limits.group_size[i], i);
		invocations *= found.group_size[i] ? found.group_size[i] : 1;
	}
	if (invocations > gpu->limits.group_invocations)
		return FAIL("program '%s': a work group of %llu invocations: '%s' has up to %u; make it smaller", name,
		            (unsigned long long)invocations, gpu->name, gpu->limits.group_invocations);
	for (uint32_t c = 0; c < desc->constant_count && found.wide_constant > 0; c++)
		if (desc->constants[c].id == found.wide_constant - 1)
			return FAIL("program '%s': specialization constant %u of its %s shader has not 32 bits", name,
			            desc->constants[c].id, stage);
	*out = found;
	return STILB_OK;
}

stilb_result gpu_check_program(const stilb_gpu *gpu, const stilb_gpu_program_desc *desc)
{
	const char *name = desc->name ? desc->name : "";
	bool compute = desc->compute.words;
	if (compute == (desc->vertex.words || desc->fragment.words))
		return FAIL("program '%s' has %s; give it vertex and fragment, fragment alone, vertex alone, or compute", name,
		            compute ? "a compute shader beside others" : "no shader");
	uint32_t samplers = (uint32_t)desc->samplers + desc->set_items;
	if (samplers > gpu->limits.samplers_stage || samplers > gpu->limits.images_stage)
		return FAIL("program '%s': %u sampled images: '%s' has up to %u; use layers of one image", name, samplers,
		            gpu->name,
		            gpu->limits.samplers_stage < gpu->limits.images_stage ? gpu->limits.samplers_stage
		                                                                  : gpu->limits.images_stage);
	if (desc->storage_images > gpu->limits.storage_images_stage)
		return FAIL("program '%s': %u storage images: '%s' has up to %u; use layers of one image", name,
		            desc->storage_images, gpu->name, gpu->limits.storage_images_stage);
	if (desc->uniforms > gpu->limits.uniforms_stage)
		return FAIL("program '%s': %u uniform buffers: '%s' has up to %u; make one of several", name, desc->uniforms,
		            gpu->name, gpu->limits.uniforms_stage);
	if ((uint32_t)desc->samplers + desc->storage_images + desc->uniforms > 32 ||
	    desc->set_items > STILB_GPU_MAX_SET_ITEMS)
		return FAIL("program '%s': %u + %u + %u bindings of set 0, %u of set 1: there are up to 32 and %u", name,
		            desc->samplers, desc->storage_images, desc->uniforms, desc->set_items, STILB_GPU_MAX_SET_ITEMS);
	if (desc->input_count > STILB_GPU_MAX_VERTEX_INPUTS || desc->constant_count > STILB_GPU_MAX_SPECIALIZATIONS)
		return FAIL("program '%s': %u vertex inputs, %u specialization constants: there are up to %u and %u", name,
		            desc->input_count, desc->constant_count, STILB_GPU_MAX_VERTEX_INPUTS,
		            STILB_GPU_MAX_SPECIALIZATIONS);
	if (desc->depth > STILB_GPU_COMPARE_EQUAL || desc->blend > STILB_GPU_BLEND_MULTIPLY)
		return FAIL("program '%s': depth %u, blend %u: there are 0..3 and 0..3", name, desc->depth, desc->blend);
	if (desc->stencil > STILB_GPU_STENCIL_COUNTED ||
	    (desc->stencil == STILB_GPU_STENCIL_COUNT && (desc->depth == STILB_GPU_COMPARE_NONE || desc->depth_write)))
		return FAIL("program '%s': stencil %u: there are 0..2, of which 1 has a depth test and writes no depth", name,
		            desc->stencil);
	if (desc->colors > 0 && !gpu->limits.some_colors)
		return FAIL("program '%s' leaves attachments as they are, which GPU '%s' cannot", name, gpu->name);
	if (desc->stencil != STILB_GPU_STENCIL_NONE && !gpu->limits.counts)
		return FAIL("program '%s': '%s' draws nothing beyond the far end (depthClamp); choose another GPU", name,
		            gpu->name);
	if (desc->lines && !gpu->limits.lines)
		return FAIL("program '%s': '%s' draws no edges of triangles (fillModeNonSolid); choose another GPU", name,
		            gpu->name);
	for (uint32_t i = 0; i < desc->input_count; i++)
		if (desc->inputs[i].format >= STILB_GPU_FORMAT_COUNT || desc->inputs[i].format == STILB_GPU_NONE ||
		    desc->inputs[i].offset + stilb_gpu_format_describe(desc->inputs[i].format)->block_bytes >
		        desc->vertex_bytes)
			return FAIL("program '%s': vertex input %u lies outside of the %u bytes of a vertex", name,
			            desc->inputs[i].location, desc->vertex_bytes);
	stilb_result result = STILB_OK;
	gpu_spirv vertex = {0}, fragment = {0};
	if (compute)
		return check_shader(gpu, desc, "compute", &desc->compute, &fragment);
	if (desc->vertex.words)
		result = check_shader(gpu, desc, "vertex", &desc->vertex, &vertex);
	if (result == STILB_OK && desc->fragment.words)
		result = check_shader(gpu, desc, "fragment", &desc->fragment, &fragment);
	return result == STILB_OK ? check_stages(desc, &vertex, &fragment) : result;
}

/* ---- uploads ----------------------------------------------------------------------------------------------------- */

static stilb_result check_upload_image(const gpu_image *image, const stilb_gpu_upload *u)
{
	const stilb_gpu_extent *e = &image->extent;
	const stilb_gpu_format_info *format = stilb_gpu_format_describe(e->format);
	if (!(e->uses & 1u << STILB_GPU_USE_COPY_TO))
		return FAIL("image '%s' was not made to be copied to; add that to its uses", image->name);
	if (u->mip >= e->mips || u->layer >= e->layers)
		return FAIL("image '%s' has %u mips and %u layers, and no mip %u of layer %u", image->name, e->mips, e->layers,
		            u->mip, u->layer);
	uint32_t side = format->block_side, width = gpu_mip_side(e->width, u->mip),
			 height = gpu_mip_side(e->height, u->mip);
	uint64_t right = (uint64_t)u->x + u->width, bottom = (uint64_t)u->y + u->height;
	if (right > width || bottom > height || (uint64_t)u->z + u->depth > gpu_mip_side(e->depth, u->mip) ||
	    u->width == 0 || u->height == 0 || u->depth == 0)
		return FAIL("image '%s': texels %u,%u,%u + %ux%ux%u are not in mip %u of %ux%u", image->name, u->x, u->y, u->z,
		            u->width, u->height, u->depth, u->mip, width, height);
	if (u->x % side != 0 || u->y % side != 0 || (right < width && u->width % side != 0) ||
	    (bottom < height && u->height % side != 0))
		return FAIL("image '%s' of format %s: texels %u,%u + %ux%u are not whole blocks of %ux%u", image->name,
		            format->name, u->x, u->y, u->width, u->height, side, side);
	uint64_t bytes = stilb_gpu_format_bytes(e->format, u->width, u->height, u->depth);
	if (bytes != u->bytes)
		return FAIL("image '%s': %ux%ux%u texels of %s are %llu bytes, not %llu", image->name, u->width, u->height,
		            u->depth, format->name, (unsigned long long)bytes, (unsigned long long)u->bytes);
	return STILB_OK;
}

stilb_result gpu_check_upload(const stilb_gpu *gpu, const stilb_gpu_upload *upload)
{
	const gpu_image *image = upload->image.id ? gpu_image_of(gpu, upload->image.id) : NULL;
	const gpu_buffer *buffer = upload->buffer.id ? gpu_buffer_of(gpu, upload->buffer.id) : NULL;
	if (image && !buffer)
		return check_upload_image(image, upload);
	if (image || !buffer)
		return FAIL("an upload goes to a buffer or to an image that is there, and to one of them");
	if (!(buffer->uses & STILB_GPU_BUFFER_COPY))
		return FAIL("buffer '%s' was not made to be copied to; add STILB_GPU_BUFFER_COPY to its uses", buffer->name);
	if (upload->bytes == 0 || upload->offset > buffer->bytes || upload->bytes > buffer->bytes - upload->offset)
		return FAIL("buffer '%s' of %llu bytes: bytes %llu + %llu are not in it", buffer->name,
		            (unsigned long long)buffer->bytes, (unsigned long long)upload->offset,
		            (unsigned long long)upload->bytes);
	return STILB_OK;
}

/* ---- passes ------------------------------------------------------------------------------------------------------ */

/* What is wrong with a pass's uniform buffer for the device; NULL: nothing. */
static const char *check_uniform(const stilb_gpu *gpu, const stilb_gpu_plan *plan, const stilb_gpu_use *use)
{
	const gpu_resource *resource = gpu_plan_resource(plan, use->resource);
	uint64_t bytes = use->bytes > 0 ? use->bytes : resource->bytes - use->first;
	const gpu_buffer *owned = resource->image.owned != 0 ? gpu_buffer_of(gpu, resource->image.owned) : NULL;
	if (owned && !(owned->uses & STILB_GPU_BUFFER_UNIFORM))
		return "a buffer was not made to be a uniform one; add STILB_GPU_BUFFER_UNIFORM to its uses";
	if (use->first % gpu->limits.uniform_align != 0)
		return "a uniform buffer begins at a byte that is not a multiple of the device's uniform_align";
	return bytes > gpu->limits.uniform_bytes ? "a uniform buffer has more bytes than the device's uniform_bytes" : NULL;
}

/* What keeps a program from having a pass's uses as its bindings; NULL: nothing. */
static const char *check_bindings(const stilb_gpu *gpu, const stilb_gpu_plan *plan, const stilb_gpu_program_desc *desc,
                                  const stilb_gpu_pass *pass)
{
	uint64_t sampled = 0, storage = 0, uniforms = 0;
	for (uint32_t u = 0; u < pass->use_count; u++) {
		const stilb_gpu_use *use = &pass->uses[u];
		const stilb_gpu_extent *extent = stilb_gpu_plan_extent(plan, use->resource);
		if (use->how == STILB_GPU_USE_UNIFORM) {
			const char *wrong = check_uniform(gpu, plan, use);
			if (wrong)
				return wrong;
			uniforms |= use->slot < 64 ? (uint64_t)1 << use->slot : 0;
		}
		if (extent->format == STILB_GPU_NONE)
			continue;
		bool integer = stilb_gpu_format_describe(extent->format)->kind == STILB_GPU_FORMAT_INTEGER;
		uint64_t bit = use->slot < 64 ? (uint64_t)1 << use->slot : 0;
		if (use->how == STILB_GPU_USE_SAMPLED) {
			if (bit == 0 || (sampled & bit) != 0)
				return "two of its uses are sampled by one binding, or the binding is above 63";
			if (use->sampler >=
			    atomic_load_explicit(&gpu->sampler_count, memory_order_acquire)) /* stilb_gpu_sampler_get */
				return "a use has a sampler that was never made";
			const stilb_gpu_sampler_desc *sampler = &gpu->samplers[use->sampler];
			bool linear = sampler->linear || sampler->mip_linear || sampler->anisotropy > 1.0f;
			if (linear && (integer || !(gpu->formats[extent->format] & GPU_FORMAT_LINEAR)))
				return "a use filters an image whose format the device cannot filter; take a nearest sampler";
			sampled |= bit;
		} else if (use->how <= STILB_GPU_USE_STORAGE) {
			if (bit == 0 || (storage & bit) != 0)
				return "two of its uses are storage images of one binding, or the binding is above 63";
			storage |= bit;
		}
	}
	program_bindings bindings = bindings_of(desc);
	if (sampled != bindings.sampled)
		return "the bindings that its uses sample are not those of its program (samplers)";
	if (storage != bindings.storage)
		return "the bindings of its storage images are not those of its program (storage_images)";
	if (uniforms != bindings.uniforms)
		return "the bindings of its uniform buffers are not those of its program (uniforms)";
	return NULL;
}

/* Images of a copy that are not copied texel by texel are filtered. */
static const char *check_scaled_copy(const stilb_gpu *gpu, const stilb_gpu_plan *plan, const stilb_gpu_pass *pass)
{
	const stilb_gpu_extent *from = NULL, *to = NULL;
	stilb_gpu_range from_range = {0}, to_range = {0};
	if (pass->program)
		return "a copy has no program";
	for (uint32_t u = 0; u < pass->use_count; u++) {
		const stilb_gpu_extent *extent = stilb_gpu_plan_extent(plan, pass->uses[u].resource);
		if (extent->format == STILB_GPU_NONE)
			continue;
		if (pass->uses[u].how == STILB_GPU_USE_COPY_FROM) {
			from = extent;
			from_range = stilb_gpu_plan_range(plan, &pass->uses[u]);
		} else {
			to = extent;
			to_range = stilb_gpu_plan_range(plan, &pass->uses[u]);
		}
	}
	if (!from || !to || gpu_copy_is_exact(from, from_range.mip, to, to_range.mip))
		return NULL;
	if (!(gpu->formats[from->format] & GPU_FORMAT_BLIT_FROM) || !(gpu->formats[to->format] & GPU_FORMAT_BLIT_TO))
		return "it scales or converts, and the device cannot with these formats";
	return from->samples > 1 || to->samples > 1 ? "it scales or converts images of several samples; resolve them"
	                                            : NULL;
}

/* What the CPU reads and writes must be mapped. */
static const char *check_host(const stilb_gpu *gpu, const stilb_gpu_plan *plan, const stilb_gpu_pass *pass)
{
	for (uint32_t u = 0; u < pass->use_count; u++) {
		const gpu_buffer *buffer = gpu_buffer_of(gpu, gpu_plan_resource(plan, pass->uses[u].resource)->image.owned);
		if (buffer && buffer->memory == STILB_GPU_MEMORY_DEVICE)
			return "a buffer is not mapped; make it of STILB_GPU_MEMORY_SHARED";
	}
	return NULL;
}

const char *gpu_check_pass(const stilb_gpu *gpu, const stilb_gpu_plan *plan, const stilb_gpu_pass *pass)
{
	if (pass->color_count > gpu->limits.color_attachments)
		return "it has more colour attachments than the device";
	/* Mesa's software driver (22.3) resolves the first layer, whichever the attachment is. */
	for (uint32_t i = 0; i < pass->color_count && gpu->software; i++)
		if (pass->color[i].resolve != 0 && pass->color[i].layer > 0)
			return "resolves a layer that is not the first, which this device cannot: draw it into an image of its own";
	if (pass->kind == STILB_GPU_PASS_COPY)
		return check_scaled_copy(gpu, plan, pass);
	if (pass->kind == STILB_GPU_PASS_HOST)
		return check_host(gpu, plan, pass);
	const gpu_program *program = pass->program ? gpu_program_of(gpu, pass->program) : NULL;
	if (pass->program && !program)
		return "its program is not there, or no longer";
	if (!program)
		return pass->kind == STILB_GPU_PASS_DRAWS ? NULL : "it has no program";
	const stilb_gpu_program_desc *desc = &program->desc;
	if ((pass->kind == STILB_GPU_PASS_DISPATCH) != (bool)desc->compute.words)
		return "its program is not of its kind: dispatches run compute shaders, and nobody else does";
	if (pass->kind == STILB_GPU_PASS_FULLSCREEN && !gpu_program_is_fullscreen(desc))
		return "the program of a fullscreen pass has a fragment shader alone";
	if (pass->kind == STILB_GPU_PASS_DRAWS && gpu_program_is_fullscreen(desc))
		return "a program without a vertex shader cannot draw a list";
	for (uint32_t i = 0; i < 3 && pass->kind == STILB_GPU_PASS_DISPATCH; i++)
		if (pass->groups[i] > gpu->limits.group_count[i])
			return "it dispatches more work groups than the device can";
	return check_bindings(gpu, plan, desc, pass);
}

/* ---- lists of draws ---------------------------------------------------------------------------------------------- */

/* The program's images with which a plan does more than to sample them: sets may not have them. */
typedef struct written_images {
	uint16_t resources[STILB_GPU_PLAN_MAX_RESOURCES];
	uint32_t count;
} written_images;

static void find_written(const stilb_gpu_plan *plan, written_images *written)
{
	uint32_t count = stilb_gpu_plan_resources(plan);
	for (uint32_t r = 1; r <= count; r++) {
		const stilb_gpu_placed *placed = stilb_gpu_plan_place(plan, (uint16_t)r);
		bool image = placed->owned != 0 && placed->extent.format != STILB_GPU_NONE;
		if (image && (placed->extent.uses & ~(1u << STILB_GPU_USE_SAMPLED)) != 0)
			written->resources[written->count++] = (uint16_t)r;
	}
}

static stilb_result check_set(const stilb_gpu_plan *plan, const written_images *written, const stilb_gpu_pass *pass,
                              const gpu_set *set)
{
	for (uint32_t w = 0; w < written->count; w++)
		for (uint32_t i = 0; i < set->count; i++)
			if (set->items[i].image.id == stilb_gpu_plan_place(plan, written->resources[w])->owned)
				return FAIL("pass '%s': item %u of a run's set is image '%s', which the plan writes, copies or shows; "
				            "sample it by a use of the pass",
				            pass->name, i, stilb_gpu_plan_name(plan, written->resources[w]));
	return STILB_OK;
}

static const gpu_program *binding_program(const stilb_gpu *gpu, const stilb_gpu_pass *pass,
                                          const stilb_gpu_binding *binding)
{
	return gpu_program_of(gpu, binding->program ? binding->program : pass->program);
}

static stilb_result check_binding(const stilb_gpu *gpu, const stilb_gpu_plan *plan, const stilb_gpu_pass *pass,
                                  const stilb_gpu_binding *binding)
{
	const gpu_program *program = binding_program(gpu, pass, binding);
	if (!program || gpu_program_is_fullscreen(&program->desc) || program->desc.compute.words)
		return FAIL("pass '%s': a binding's program is not there, or draws no lists", pass->name);
	const stilb_gpu_program_desc *desc = &program->desc;
	const char *wrong = check_bindings(gpu, plan, desc, pass);
	if (wrong)
		return FAIL("pass '%s' with program '%s': %s", pass->name, program->name, wrong);
	const gpu_buffer *indices = gpu_buffer_of(gpu, binding->indices);
	const gpu_buffer *vertices = binding->vertices ? gpu_buffer_of(gpu, binding->vertices) : NULL;
	if (!indices || !(indices->uses & STILB_GPU_BUFFER_INDICES) ||
	    (binding->index_bytes != 2 && binding->index_bytes != 4))
		return FAIL("pass '%s': a binding has no buffer of indices of 2 or 4 bytes", pass->name);
	if ((desc->vertex_bytes > 0) != (bool)vertices || (vertices && !(vertices->uses & STILB_GPU_BUFFER_VERTICES)))
		return FAIL("pass '%s': a binding's vertices are not what program '%s' reads", pass->name, program->name);
	return STILB_OK;
}

static stilb_result check_runs(const stilb_gpu *gpu, const stilb_gpu_plan *plan, const written_images *written,
                               const stilb_gpu_pass *pass, const stilb_gpu_draws *list)
{
	bool indirect = list->replay == STILB_GPU_REPLAY_INDIRECT;
	if (list->run_count == 0)
		return STILB_OK;
	const gpu_buffer *commands = gpu_buffer_of(gpu, list->commands.id);
	uint64_t most = indirect ? (commands->bytes - list->offset) / STILB_GPU_DRAW_STRIDE : UINT64_MAX;
	const stilb_gpu_run *last = NULL;
	for (uint32_t r = 0; r < list->run_count; last = &list->runs[r++]) {
		const stilb_gpu_run *run = &list->runs[r];
		if (run->binding >= list->binding_count)
			return FAIL("pass '%s': run %u has binding %u of %u", pass->name, r, run->binding, list->binding_count);
		if ((uint64_t)run->first + run->count > most)
			return FAIL("pass '%s': run %u ends at draw %llu of a buffer of %llu", pass->name, r,
			            (unsigned long long)run->first + run->count, (unsigned long long)most);
		if (last && run->set == last->set && run->binding == last->binding)
			continue;
		const gpu_program *program = binding_program(gpu, pass, gpu_binding_of(list, run));
		const gpu_set *set = run->set ? gpu_set_of(gpu, run->set) : NULL;
		if ((program->desc.set_items > 0 || run->set) && (!set || set->count != program->desc.set_items))
			return FAIL("pass '%s': a run's set is not there, or has not the %u items of program '%s'", pass->name,
			            program->desc.set_items, program->name);
		stilb_result result = set ? check_set(plan, written, pass, set) : STILB_OK;
		if (result != STILB_OK)
			return result;
	}
	return STILB_OK;
}

stilb_result gpu_check_lists(const stilb_gpu *gpu, const stilb_gpu_plan *plan, const stilb_gpu_draws *lists,
                             uint32_t list_count)
{
	const stilb_gpu_step *steps;
	uint32_t count = stilb_gpu_plan_steps(plan, &steps);
	stilb_result result = STILB_OK;
	written_images written;
	written.count = 0;
	if (list_count > 0)
		find_written(plan, &written);
	for (uint32_t s = 0; s < count && result == STILB_OK; s++) {
		const stilb_gpu_pass *pass = stilb_gpu_plan_row(plan, steps[s].pass);
		if (pass->kind != STILB_GPU_PASS_DRAWS)
			continue;
		if (pass->draws >= list_count)
			return FAIL("pass '%s' draws list %u of %u that came with the frame", pass->name, pass->draws, list_count);
		const stilb_gpu_draws *list = &lists[pass->draws];
		const gpu_buffer *commands = gpu_buffer_of(gpu, list->commands.id);
		bool indirect = list->replay == STILB_GPU_REPLAY_INDIRECT;
		if (list->run_count > 0 &&
		    (indirect ? !commands || !(commands->uses & STILB_GPU_BUFFER_INDIRECT) || list->offset > commands->bytes
		              : !list->draws))
			return FAIL("pass '%s': its list has no draws, or they are not where its mode of replay reads them",
			            pass->name);
		if (list->has_constants && (list->constant_place % 8 != 0 || list->constant_place + 8 > pass->constant_bytes))
			return FAIL("pass '%s': its runs' constants take bytes %u to %u of %u", pass->name, list->constant_place,
			            list->constant_place + 7, pass->constant_bytes);
		for (uint32_t b = 0; b < list->binding_count && result == STILB_OK; b++)
			result = check_binding(gpu, plan, pass, &list->bindings[b]);
		if (result == STILB_OK)
			result = check_runs(gpu, plan, &written, pass, list);
	}
	return result;
}
