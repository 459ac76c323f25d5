// What the vertex shader of impostors tells the fragment shader; way: in or out. Of each of the three pictures: the
// plate's point and the camera in its frame, in radii; its direction in the model's space; its first texel in the maps
// and its weight.
#define IMPOSTOR_VARYINGS(way) \
	layout(location = 0) way vec3 world_plate; \
	layout(location = 1) flat way uint material_word; \
	layout(location = 1, component = 1) flat way uint model_lights; \
	layout(location = 1, component = 2) flat way uint model_id; \
	layout(location = 2) flat way vec2 sides; /* texels of a picture's side, and of a map's */ \
	layout(location = 3) flat way vec3 normal_x; /* rows of the matrix that takes normals to the world */ \
	layout(location = 4) flat way vec3 normal_y; \
	layout(location = 5) flat way vec3 normal_z; \
	layout(location = 6) way vec3 plate_a; \
	layout(location = 7) way vec3 plate_b; \
	layout(location = 8) way vec3 plate_c; \
	layout(location = 9) flat way vec3 camera_a; \
	layout(location = 10) flat way vec3 camera_b; \
	layout(location = 11) flat way vec3 camera_c; \
	layout(location = 12) flat way vec3 direction_a; \
	layout(location = 13) flat way vec3 direction_b; \
	layout(location = 14) flat way vec3 direction_c; \
	layout(location = 15) flat way vec3 tile_a; \
	layout(location = 16) flat way vec3 tile_b; \
	layout(location = 17) flat way vec3 tile_c; \
	layout(location = 18) flat way vec4 moved[3]; /* rows: from the world now to the world in the frame before */
