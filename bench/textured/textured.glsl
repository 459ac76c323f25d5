// What both shaders of the plain program read. Macros add the engine's habits one by one, to tell the price of each:
//   TEXTURED_ARRAYS   maps are layers of arrays
//   TEXTURED_ADDRESS  the table of irradiance is read by its address, not as a storage buffer
//   TEXTURED_SAMPLED  it is an image that a sampler interpolates (no habit of the engine's)
//   TEXTURED_FETCHED  it is an image of which four texels are read (no habit of the engine's)
//   TEXTURED_VIEW     vertices read the view's matrix and the transform by address, not as constants
//   TEXTURED_HANDED   vertices read the material by its address and hand it on to pixels
//   TEXTURED_EXTRAS   vertices read tangent and colour by address, packed, and hand the colour on
//   TEXTURED_SIDES    pixels find out which side of the triangle they are on
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference_uvec2 : require

// As textured_push.
layout(push_constant, std430) uniform Push {
	mat4 view_projection;
	vec4 transform[3]; // rows of the affine transform, model to world
	vec4 camera;
} push;

layout(buffer_reference, std430, buffer_reference_align = 16) readonly buffer Parts { vec4 at[]; };
layout(buffer_reference, std430, buffer_reference_align = 8) readonly buffer Pairs { uvec2 at[]; };

// As textured_material: four parts, the panorama's rotation, addresses.
layout(set = 0, binding = 8, std140) uniform Material {
	vec4 parts[4]; // color; specular, roughness; emission, metalness; scale of normals, occlusion
	vec2 turn;     // sine and cosine of the panorama's rotation
	uvec2 table;
	uvec2 record; // of these four parts
	uvec2 extras; // as render_extra has them
	uvec2 view;   // of a copy of the constants
} material;
