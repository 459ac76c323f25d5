// The lists of a view's lights, by cell (light/light.h).

// Where the list of a cell, of so many, begins and ends among the words of the lists. One that lists by compute have no
// room for is the list of all lights: sums are the same, since those that it lacks send nothing there.
uvec2 list_of(LightLists lists, uint cell, uint cells)
{
	uint begin = lists.words[cell], end = lists.words[cell + 1u], all = lists.all, first = cells + 1u;
	return end <= lists.room ? first + all + uvec2(begin, end) : first + uvec2(0u, all);
}

// Where the list of the cell begins and ends, among the words of the lists, that has this point in the pixel at.
uvec2 list_of_cell(LightLists lists, vec2 at, vec3 place)
{
	uvec2 grid = push.view.grid, tiles = uvec2(grid.x & 0xffffu, grid.x >> 16);
	uint slices = grid.y >> 8;
	uvec2 tile = uvec2(at) >> (grid.y & 0xffu);
	vec4 plane = lists.depth_plane;
	vec2 scale = lists.slice;
	float depth = max(dot(plane.xyz, place) + plane.w, 1e-30);
	uint slice = min(uint(max(log2(depth) * scale.x + scale.y, 0.0)), slices - 1u);
	uint cell = tile.x + tiles.x * (tile.y + tiles.y * slice);
	return list_of(lists, cell, tiles.x * tiles.y * slices);
}
