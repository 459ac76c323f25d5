// What the mesh shaders share with the CPU: buffers by address, laid out as in render_internal.h and vulkan_internal.h.
#extension GL_EXT_buffer_reference : require

// render_row: one draw.
struct Row {
	vec4 transform[3]; // rows of the affine transform, model to world
	uint material;
	uint mesh; // read by the CPU alone
	uint unused[2];
};

// render_material.
struct Material {
	vec4 diffuse_shininess;
	vec4 specular;
};

layout(buffer_reference, std430, buffer_reference_align = 16) readonly buffer Rows { Row rows[]; };
layout(buffer_reference, std430, buffer_reference_align = 16) readonly buffer Materials { Material materials[]; };

// vulkan_view.
layout(buffer_reference, std430, buffer_reference_align = 16) readonly buffer View {
	mat4 view_projection;
	vec4 camera_position;
	vec4 sun_direction;
	vec4 sun_irradiance;
	vec4 sky;
	vec4 ground;
};

layout(push_constant, std430) uniform Push {
	View view;
	Rows rows;
	Materials materials;
} push;
