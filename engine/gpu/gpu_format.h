/*
 * gpu: formats of images and of their texels. Plain data; [any-thread].
 */
#ifndef STILB_GPU_FORMAT_H
#define STILB_GPU_FORMAT_H

#include "base/base.h"

#ifdef __cplusplus
extern "C" {
#endif
#pragma GCC visibility push(default)

/* A row for each format: X(ENUM, name for users, bytes of a block, texels along a block's side, kind). Names follow
 * Vulkan's: bits of each channel, then U unsigned and S signed integers that mean 0..1 and -1..1, UI and SI integers
 * that mean themselves, F floats, SRGB colours whose codes are sRGB. RGB32_F is of vertices alone: no device has images
 * of it. D32_F_S8, a depth and a stencil, is drawn into alone. */
#define STILB_GPU_FORMATS(X)                                                                                           \
	X(NONE, "none", 0, 1, COLOR)                                                                                       \
	X(R8_U, "r8_u", 1, 1, COLOR)                                                                                       \
	X(RG8_U, "rg8_u", 2, 1, COLOR)                                                                                     \
	X(RGBA8_U, "rgba8_u", 4, 1, COLOR)                                                                                 \
	X(RGBA8_SRGB, "rgba8_srgb", 4, 1, COLOR)                                                                           \
	X(RGB10A2_U, "rgb10a2_u", 4, 1, COLOR)                                                                             \
	X(R16_U, "r16_u", 2, 1, COLOR)                                                                                     \
	X(RG16_U, "rg16_u", 4, 1, COLOR)                                                                                   \
	X(RGBA16_U, "rgba16_u", 8, 1, COLOR)                                                                               \
	X(RG16_S, "rg16_s", 4, 1, COLOR)                                                                                   \
	X(R16_F, "r16_f", 2, 1, COLOR)                                                                                     \
	X(RG16_F, "rg16_f", 4, 1, COLOR)                                                                                   \
	X(RGBA16_F, "rgba16_f", 8, 1, COLOR)                                                                               \
	X(R11G11B10_F, "r11g11b10_f", 4, 1, COLOR)                                                                         \
	X(R32_F, "r32_f", 4, 1, COLOR)                                                                                     \
	X(RG32_F, "rg32_f", 8, 1, COLOR)                                                                                   \
	X(RGB32_F, "rgb32_f", 12, 1, COLOR)                                                                                \
	X(RGBA32_F, "rgba32_f", 16, 1, COLOR)                                                                              \
	X(R8_UI, "r8_ui", 1, 1, INTEGER)                                                                                   \
	X(R16_UI, "r16_ui", 2, 1, INTEGER)                                                                                 \
	X(R32_UI, "r32_ui", 4, 1, INTEGER)                                                                                 \
	X(RG32_UI, "rg32_ui", 8, 1, INTEGER)                                                                               \
	X(D16, "d16", 2, 1, DEPTH)                                                                                         \
	X(D32_F, "d32_f", 4, 1, DEPTH)                                                                                     \
	X(BC1_U, "bc1_u", 8, 4, COLOR)                                                                                     \
	X(BC1_SRGB, "bc1_srgb", 8, 4, COLOR)                                                                               \
	X(BC3_U, "bc3_u", 16, 4, COLOR)                                                                                    \
	X(BC3_SRGB, "bc3_srgb", 16, 4, COLOR)                                                                              \
	X(BC4_U, "bc4_u", 8, 4, COLOR)                                                                                     \
	X(BC5_U, "bc5_u", 16, 4, COLOR)                                                                                    \
	X(BC6H_F, "bc6h_f", 16, 4, COLOR)                                                                                  \
	X(BC7_U, "bc7_u", 16, 4, COLOR)                                                                                    \
	X(BC7_SRGB, "bc7_srgb", 16, 4, COLOR)                                                                              \
	X(D32_F_S8, "d32_f_s8", 8, 1, DEPTH)

#define STILB_GPU_FORMAT_ENUM(id, ...) STILB_GPU_##id,
typedef enum stilb_gpu_format { STILB_GPU_FORMATS(STILB_GPU_FORMAT_ENUM) STILB_GPU_FORMAT_COUNT } stilb_gpu_format;
#undef STILB_GPU_FORMAT_ENUM

typedef enum stilb_gpu_format_kind {
	STILB_GPU_FORMAT_COLOR,   /* sampled as floats */
	STILB_GPU_FORMAT_INTEGER, /* sampled as integers, never filtered or blended */
	STILB_GPU_FORMAT_DEPTH,
} stilb_gpu_format_kind;

typedef struct stilb_gpu_format_info {
	const char *name;
	uint8_t block_bytes;
	uint8_t block_side; /* texels; 4: compressed */
	stilb_gpu_format_kind kind;
} stilb_gpu_format_info;

/* What is known of a format. */
const stilb_gpu_format_info *stilb_gpu_format_describe(stilb_gpu_format format);

/* True if its texels have a stencil. */
static inline bool stilb_gpu_format_has_stencil(stilb_gpu_format format)
{
	return format == STILB_GPU_D32_F_S8;
}

/* Bytes of width x height x depth texels, in whole blocks. */
uint64_t stilb_gpu_format_bytes(stilb_gpu_format format, uint32_t width, uint32_t height, uint32_t depth);

#pragma GCC visibility pop
#ifdef __cplusplus
}
#endif

#endif
