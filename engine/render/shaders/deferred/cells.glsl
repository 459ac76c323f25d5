// A view's cells and the lights that reach it, and which columns of one row of a slice a light reaches: what
// light/light_scalar.h does, in the same order, so that where division and roots are rounded as there the lists are the
// same bit for bit. Sources: as of light/light.h and light/light_kernels.h.

// As stilb_light_reached.
struct ReachedLight {
	vec4 place; // clip x, y and w of its sphere's middle, and depth
	float radius;
	uint slices;
	float cosine, sine;
	vec4 base_slack;
	vec4 axis;
};

layout(buffer_reference, std430, buffer_reference_align = 16) readonly buffer ReachedLights { ReachedLight lights[]; };

// As stilb_light_cells.
layout(buffer_reference, std430, buffer_reference_align = 16) readonly buffer Cells {
	vec4 depth_plane;
	vec2 slice;
	uint columns, rows, slices, light_count;
	vec4 along, squares, column_scale;
	vec4 base_x, base_y, ray, ray_x, ray_y;
	vec4 planes[];
};

// The lists that are made: as LightLists of mesh.glsl.
layout(buffer_reference, std430, buffer_reference_align = 16) buffer MadeLists {
	vec4 depth_plane;
	vec2 slice;
	uint room, all;
	uint words[];
};

// For each row of each slice the lengths of its lists together; then what those of the rows before it have.
layout(buffer_reference, std430, buffer_reference_align = 4) buffer RowSums { uint sums[]; };
// For each pass of the frame the ids of all its lists.
layout(buffer_reference, std430, buffer_reference_align = 4) writeonly buffer PairCounts { uint counts[]; };

// As render_cells_push.
layout(push_constant, std430) uniform Push {
	MadeLists lists;
	RowSums rows;
	PairCounts counts;
	Cells cells;
	ReachedLights reached;
	uint room, pass;
} push;

// As in light_kernels.h.
const float SQUARE_GROWTH = 1.000002, TANGENT_LIMIT = 1.1, TANGENT_GROWTH = 7.62939453125e-06, COLUMN_GROWTH = 1e-3,
			ACROSS_MIN = 1e-20;
const uvec2 NO_SPAN = uvec2(1u, 0u);

// One row of one slice.
struct CellRow {
	vec4 upper, lower, upper_way, lower_way; // planes of its edges: inverse, offset, edge; x, w
	vec4 unit, unit_end, band, band_end;     // planes around wider strips
	float near_z, far_z;
	vec2 inverse; // one over the least and the greatest w of its points
	uint slice;
	bool open; // the last slice: it has no far end
};

CellRow cell_row(uint row, uint slice)
{
	Cells cells = push.cells;
	uint rows = cells.columns + 1u, at = rows + 3u * row;
	vec4 depth = cells.planes[rows + 3u * (cells.rows + 1u) + slice];
	uvec4 strips = rows + 3u * uvec4(cells.planes[at + 2u]);
	return CellRow(cells.planes[at], cells.planes[at + 3u], cells.planes[at + 1u], cells.planes[at + 4u],
		cells.planes[strips.x], cells.planes[strips.y], cells.planes[strips.z], cells.planes[strips.w], depth.x,
		depth.y, depth.zw, slice, slice + 1u == cells.slices);
}

// The distance by which a point with these y and w lies outside of two planes.
float beyond_planes(vec4 first, vec4 end, float y, float w, out bool lower)
{
	precise float above = w * first.y - y * first.x, below = y * end.x - w * end.y;
	lower = below > above;
	return max(max(below, above), 0.0);
}

bool in_strip(vec4 first, vec4 end, float y, float w, float square)
{
	bool lower;
	precise float beyond = beyond_planes(first, end, y, w, lower);
	precise float apart = beyond * beyond;
	return apart <= square;
}

float sum_of_products(vec3 a, vec3 b)
{
	precise float sum = a.x * b.x + a.y * b.y + a.z * b.z;
	return sum;
}

// Of a sphere that is too near to the eye for tangents: by the distance from each plane.
uvec2 span_near(float x, float w, float square)
{
	precise float radius = sqrt(square);
	uvec2 span = uvec2(push.cells.columns, 0u);
	for (uint c = 0u; c < push.cells.columns; c++) {
		vec4 a = push.cells.planes[c], b = push.cells.planes[c + 1u];
		precise float left = x * a.x - w * a.y, right = x * b.x - w * b.y;
		if (left >= -radius && right <= radius)
			span = uvec2(min(span.x, c), c);
	}
	return span;
}

// The planes n that touch the sphere solve (x - n w)^2 = r^2 (xx - 2 xw n + ww n^2).
uvec2 span_far(CellRow row, float x, float w, float square)
{
	vec4 squares = push.cells.squares, scale = push.cells.column_scale;
	precise float inverse = 1.0 / (w * w - squares.z * square);
	precise float middle = (x * w - squares.y * square) * inverse;
	precise float gradient = squares.x * (w * w) - (squares.y + squares.y) * (x * w) + squares.z * (x * x);
	precise float root = max(gradient - squares.w * square, 0.0);
	precise float radius = sqrt(square), half_span = radius * sqrt(root) * inverse;
	half_span = half_span + (abs(middle) + half_span) * TANGENT_GROWTH;
	precise float reach = radius * scale.z, low = x - reach, high = x + reach;
	precise float least = min(low * row.inverse.x, low * row.inverse.y);
	precise float most = max(high * row.inverse.x, high * row.inverse.y);
	precise float first = max(middle - half_span, least) * scale.x + (scale.y - COLUMN_GROWTH);
	precise float last = min(middle + half_span, most) * scale.x + (scale.y + COLUMN_GROWTH);
	float end = float(push.cells.columns);
	if (!(first < end && last >= 0.0 && first <= last))
		return NO_SPAN;
	return uvec2(max(first, 0.0), min(last, end - 1.0));
}

// The cone of a light as seen from a row: from its axis to the middle of the cell whose middle is nx, perpendicular to
// it, across + nx across_x.
struct ConeRow {
	vec3 base, axis, across, across_x;
	float cosine, sine, slack;
};

ConeRow cone_in_row(ReachedLight light, CellRow row)
{
	precise float y = 0.5 * (row.upper.z + row.lower.z), z = 0.5 * (row.near_z + row.far_z);
	if (row.open)
		z = 2.0 * row.near_z + 1.0;
	vec3 axis = light.axis.xyz, base = light.base_slack.xyz;
	precise vec3 across = base + y * push.cells.base_y.xyz + z * (push.cells.ray.xyz + y * push.cells.ray_y.xyz);
	precise vec3 across_x = push.cells.base_x.xyz + z * push.cells.ray_x.xyz;
	precise vec3 beside = across - sum_of_products(across, axis) * axis;
	precise vec3 beside_x = across_x - sum_of_products(across_x, axis) * axis;
	return ConeRow(base, axis, beside, beside_x, light.cosine, light.sine, light.base_slack.w);
}

// A convex cone and a cell are apart if a plane through the apex has the cone on one side and the cell on the other. Of
// the planes that touch the cone, the one that looks to the cell's middle is tried.
bool cone_meets(ConeRow cone, CellRow row, uint column)
{
	float x0 = push.cells.planes[column].z, x1 = push.cells.planes[column + 1u].z;
	float y0 = row.upper.z, y1 = row.lower.z;
	precise float x = 0.5 * (x0 + x1);
	precise vec3 normal = cone.across + x * cone.across_x;
	precise float len = sqrt(sum_of_products(normal, normal));
	precise float toward = cone.cosine / max(len, ACROSS_MIN);
	normal = toward * normal - cone.sine * cone.axis;
	float base_x = sum_of_products(normal, push.cells.base_x.xyz);
	float base_y = sum_of_products(normal, push.cells.base_y.xyz);
	float ray_x = sum_of_products(normal, push.cells.ray_x.xyz);
	float ray_y = sum_of_products(normal, push.cells.ray_y.xyz);
	precise float base =
		sum_of_products(normal, cone.base) + min(x0 * base_x, x1 * base_x) + min(y0 * base_y, y1 * base_y);
	precise float ray =
		sum_of_products(normal, push.cells.ray.xyz) + min(x0 * ray_x, x1 * ray_x) + min(y0 * ray_y, y1 * ray_y);
	if (row.open && ray < 0.0)
		return true;
	precise float most = base + (ray < 0.0 ? row.far_z : row.near_z) * ray;
	return most <= cone.slack;
}

uvec2 span_trim(ReachedLight light, CellRow row, uvec2 span)
{
	ConeRow cone = cone_in_row(light, row);
	uint first = span.x, end = span.y + 1u;
	while (first < end && !cone_meets(cone, row, first))
		first++;
	while (first < end && !cone_meets(cone, row, end - 1u))
		end--;
	return first < end ? uvec2(first, end - 1u) : NO_SPAN;
}

// The first and the last column of the row that the light reaches; the first above the last: none.
uvec2 span_of(ReachedLight light, CellRow row)
{
	if ((light.slices & 0xffu) > row.slice || (light.slices >> 8 & 0xffu) < row.slice)
		return NO_SPAN;
	vec4 place = light.place;
	precise float after = row.open ? 0.0 : max(place.w - row.far_z, 0.0);
	precise float shift = max(row.near_z - place.w, 0.0) - after;
	precise vec3 clip = place.xyz + shift * push.cells.along.xyz;
	precise float square = light.radius * light.radius * SQUARE_GROWTH - shift * shift;
	bool lower; // and of lights behind the eye wider strips are farther away
	precise float beyond = beyond_planes(row.upper, row.lower, clip.y, clip.z, lower);
	precise float left = square - beyond * beyond;
	if (!(left >= 0.0) || !in_strip(row.unit, row.unit_end, clip.y, clip.z, square) ||
		!in_strip(row.band, row.band_end, clip.y, clip.z, square))
		return NO_SPAN;
	vec2 way = lower ? -row.lower_way.xy : row.upper_way.xy;
	precise float x = clip.x + beyond * way.x, w = clip.z + beyond * way.y;
	precise float near_square = push.cells.squares.z * left * TANGENT_LIMIT;
	precise float w_square = w * w;
	uvec2 span = w_square > near_square && w > 0.0 ? span_far(row, x, w, left) : span_near(x, w, left);
	return span.x <= span.y && (light.slices >> 16) != 0u ? span_trim(light, row, span) : span;
}
