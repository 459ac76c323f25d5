// The rows of draws, in buffers by address.
#extension GL_EXT_buffer_reference : require

// As render_row of render_internal.h.
struct Row {
	vec4 transform[3]; // rows of the affine transform, model to world; a 2D draw has its clip rectangle in the first
	uint material;
	uint mesh; // where the vertices have extras
	uint last; // 1 + the row, of the frame's, that has where it was in the frame before; 0: it has not moved
	uint model; // in ROW_MODEL 1 + the scene's, 0: it is drawn by hand; in the bits above its STILB_SCENE_MODEL_...
};
#define ROW_MODEL 0xffffffu
#define ROW_UNSHADOWED (4u << 24) // STILB_SCENE_MODEL_RECEIVES_NO_SHADOW

layout(buffer_reference, std430, buffer_reference_align = 16) readonly buffer Rows { Row rows[]; };

// A draw's firstInstance is the word of its row: an index, and the bit of rows of the frame (render_rows.h). Above it
// is how the draw fades or morphs.
#define ROW_FRAME (1u << 25)
