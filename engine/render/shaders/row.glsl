// The rows of the frame's draws, a buffer by address.
#extension GL_EXT_buffer_reference : require

// As render_row of render_internal.h.
struct Row {
	vec4 transform[3]; // rows of the affine transform, model to world; a 2D draw has its clip rectangle in the first
	uint material;
	uint mesh; // read by the CPU alone
	uint unused[2];
};

layout(buffer_reference, std430, buffer_reference_align = 16) readonly buffer Rows { Row rows[]; };
