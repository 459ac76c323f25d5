// The rows of draws, in buffers by address.
#extension GL_EXT_buffer_reference : require

// As render_row of render_internal.h.
struct Row {
	vec4 transform[3]; // rows of the affine transform, model to world; a 2D draw has its clip rectangle in the first
	uint material;
	uint mesh; // where the vertices have extras
	uint last; // 1 + the row, of the frame's, that has where it was in the frame before; 0: it has not moved
	uint unused;
};

layout(buffer_reference, std430, buffer_reference_align = 16) readonly buffer Rows { Row rows[]; };

// A draw's firstInstance is the word of its row: an index, and the bit of rows of the frame (render_rows.h). Above it
// is how the draw fades or morphs.
#define ROW_FRAME (1u << 25)
