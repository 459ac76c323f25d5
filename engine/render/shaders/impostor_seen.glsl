// What the fragment shaders of impostors share: which point of the model a pixel shows.
#include "impostor.glsl"
#include "../../shading/shade_impostor.h"

IMPOSTOR_VARYINGS(in)

layout(set = 1, binding = 0) uniform sampler2D maps; // stilb_scene_impostor.maps

// Steps by which the ray approaches the surface that a picture's heights describe.
const int STEPS = 2;

// What a picture has of the point that a pixel shows.
struct Seen {
	vec4 color;     // diffuse reflectance; the share of the texel that the model covers
	vec3 normal;    // in the model's space, unit
	float roughness;
	float along;    // how far the point lies from the camera, as a share of the way to the plate
};

// Texels of a picture from its top left corner, half a texel inside at least.
vec2 texel_of(vec2 at)
{
	return clamp(shade_impostor_texel(at, sides.x), vec2(0.5), vec2(sides.x - 0.5));
}

// The picture's surface where the ray from the camera through the plate's point meets it.
Seen look(vec3 plate, vec3 camera, vec3 direction, vec2 tile)
{
	vec3 ray = plate - camera;
	vec2 lower = tile + vec2(0.0, sides.y);
	vec2 at = plate.xy;
	ivec2 last = textureSize(maps, 0) - 1; // whatever a damaged dump says, no texel beyond it is read
	for (int i = 0; i < STEPS; i++) {
		float height = texelFetch(maps, clamp(ivec2(lower + texel_of(at)), ivec2(0), last), 0).z;
		at = camera.xy + ray.xy * ((height - camera.z) / ray.z);
	}
	vec2 texel = texel_of(at);
	vec2 scale = vec2(1.0, 0.5) / sides.y;
	vec4 shape = textureLod(maps, (lower + texel) * scale, 0.0);
	Seen seen;
	seen.color = textureLod(maps, (tile + texel) * scale, 0.0);
	seen.normal = shade_frame_to_world(shade_frame_from_normal(direction), shade_direction_from_octahedral(shape.xy));
	seen.roughness = shape.w;
	seen.along = (shape.z - camera.z) / ray.z;
	return seen;
}

// What the three pictures have, each with its weight.
struct Pictures {
	Seen a, b, c;
	vec3 weights; // their sum is 1
};

// Drops the pixel where the model does not cover it, and says which of its samples it covers.
Pictures look_at_pictures()
{
	Pictures p;
	p.a = look(plate_a, camera_a, direction_a, tile_a.xy);
	p.b = look(plate_b, camera_b, direction_b, tile_b.xy);
	p.c = look(plate_c, camera_c, direction_c, tile_c.xy);
	p.weights = vec3(tile_a.z, tile_b.z, tile_c.z) * vec3(p.a.color.a, p.b.color.a, p.c.color.a);
	float coverage = p.weights.x + p.weights.y + p.weights.z;
	// The pixel's samples that the model covers: of one all from a half on, of four as many as its share.
	const int masks[5] = int[5](0, 1, 9, 11, 15);
	int covered = samples == 1u ? int(coverage >= 0.5) : masks[clamp(int(coverage * 4.0 + 0.5), 0, 4)];
	if (covered == 0)
		discard;
	gl_SampleMask[0] = samples == 1u ? ~0 : covered;
	p.weights /= coverage;
	return p;
}

// The point of the model, in the world.
vec3 place_of(Pictures p)
{
	vec3 camera = push.view.camera_position.xyz;
	float along = dot(p.weights, vec3(p.a.along, p.b.along, p.c.along));
	return camera + (world_plate - camera) * along;
}

// x, y, w in clip space of where the point was in the frame before.
vec3 last_place(vec3 now)
{
	vec4 place = vec4(now, 1.0);
	vec4 last = vec4(dot(moved[0], place), dot(moved[1], place), dot(moved[2], place), 1.0);
	return (push.view.rest.last_view_projection * last).xyw;
}

float depth_of(vec3 place)
{
	precise vec4 clip = push.view.rest.view_projection * vec4(place, 1.0);
	precise float depth = clip.z / clip.w; // the same for programs of further lights
	return depth;
}
