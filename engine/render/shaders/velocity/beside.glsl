// What programs that draw surfaces draw beside the picture, each into an image of its own where the constant `beside`
// has its bit (device/render_beside.c): velocities, models, normals, and the surroundings' light apart from all other.
// MESH_SEEN: programs that draw the first three alone.
#ifdef MESH_GBUFFER
#define BESIDE_FIRST 4 // behind the images of surfaces
#elif !defined(MESH_SEEN)
#define BESIDE_FIRST 1
#endif
#include "../velocity.glsl"
#include "../../../shading/shade_impostor.h"

layout(location = BESIDE_FIRST + 1) out uint seen_id; // 1 + the scene's model; 0: none
#ifdef MESH_GBUFFER
#define AROUND_FIRST 6
#else
layout(location = BESIDE_FIRST + 2) out vec2 seen_normal; // on the octahedral map, times 0.5, plus 0.5
#define AROUND_FIRST 4
#endif

// last: as of velocity_from. n: the unit shading normal.
void beside_write(vec3 last, vec3 n, uint model)
{
	if ((beside & BESIDE_VELOCITY) != 0u)
		velocity = velocity_from(last, vec2(push.view.rest.half_width, push.view.rest.half_height));
	if ((beside & BESIDE_ID) != 0u)
		seen_id = model;
#ifndef MESH_GBUFFER
	if ((beside & BESIDE_NORMAL) != 0u)
		seen_normal = shade_octahedral_from_direction(n) * 0.5 + 0.5;
#endif
}

// LIT_AROUND: programs of surfaces whose light may be apart: without layers and functions of the program's.
#if !defined(MESH_SEEN) && !defined(MAPS_LAYERS) && !defined(MAPS_FUNCTION)
#define LIT_AROUND
layout(location = AROUND_FIRST) out vec4 ambient;        // what they send on evenly
layout(location = AROUND_FIRST + 1) out vec4 reflection; // what their highlights mirror
#ifndef MESH_GBUFFER
layout(location = AROUND_FIRST + 2) out vec4 mirror; // which share of it, and their roughness
layout(location = AROUND_FIRST + 3) out vec2 mirror_normal;
#endif

// Of this pixel.
struct Around {
	vec3 even, mirrored, share, normal;
	float roughness;
};
Around around = Around(vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0, 1.0, 0.0), 0.0);

// none: the pixel has no such light.
void around_write(bool none)
{
	ambient = vec4(none ? vec3(0.0) : around.even, 1.0);
	reflection = vec4(none ? vec3(0.0) : around.mirrored, 1.0);
#ifndef MESH_GBUFFER
	if ((beside & BESIDE_MIRROR) != 0u) {
		mirror = none ? vec4(0.0) : vec4(around.share, around.roughness);
		mirror_normal = shade_octahedral_from_direction(around.normal) * 0.5 + 0.5;
	}
#endif
}
#endif
