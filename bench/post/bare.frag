#version 460
// A row that reads and writes what an effect's row does, and computes nothing: each texel of its images is read once,
// and each texel that it draws is their sum. BARE_IMAGES: how many there are; BARE_TEMPORAL: those of temporal
// antialiasing, of which two are of integers, and three are drawn.
layout(push_constant, std430) uniform Push { ivec2 size; } push; // of what is drawn into

#ifdef BARE_TEMPORAL
#define BARE_IMAGES 7
#define INTEGERS usampler2D
#else
#define INTEGERS sampler2D
#endif

layout(set = 0, binding = 0) uniform sampler2D image0;
#if BARE_IMAGES > 1
layout(set = 0, binding = 1) uniform sampler2D image1;
#endif
#if BARE_IMAGES > 2
layout(set = 0, binding = 2) uniform sampler2D image2;
#endif
#if BARE_IMAGES > 3
layout(set = 0, binding = 3) uniform INTEGERS image3;
#endif
#if BARE_IMAGES > 4
layout(set = 0, binding = 4) uniform sampler2D image4;
layout(set = 0, binding = 5) uniform INTEGERS image5;
layout(set = 0, binding = 6) uniform sampler2D image6;
#endif

layout(location = 0) out vec4 color;
#ifdef BARE_TEMPORAL
layout(location = 1) out uvec2 models;
layout(location = 2) out vec4 places;
#endif

vec4 sum = vec4(0.0);

// The texels of the image that lie below the pixel, or the one that it lies in.
#define ADD(image)                                                                          \
	{                                                                                       \
		ivec2 whole = textureSize(image, 0), each = max(whole / push.size, ivec2(1));       \
		ivec2 first = ivec2(gl_FragCoord.xy) * whole / push.size;                           \
		for (int y = 0; y < each.y; y++)                                                    \
			for (int x = 0; x < each.x; x++)                                                \
				sum += vec4(texelFetch(image, min(first + ivec2(x, y), whole - 1), 0));     \
	}

void main()
{
	ADD(image0)
#if BARE_IMAGES > 1
	ADD(image1)
#endif
#if BARE_IMAGES > 2
	ADD(image2)
#endif
#if BARE_IMAGES > 3
	ADD(image3)
#endif
#if BARE_IMAGES > 4
	ADD(image4)
	ADD(image5)
	ADD(image6)
#endif
	color = sum;
#ifdef BARE_TEMPORAL
	models = uvec2(sum.xy);
	places = sum;
#endif
}
