/* Which models may throw a shadow of a directional light on what the camera sees up to a distance: those in that part
 * of its frustum, a pyramid, swept to the light. The swept body is bounded by the faces of the pyramid that stay inside
 * when they move to the light, and by planes along the light through the edges between such a face and another. */
#include "shadow/shadow_internal.h"

#include "base/base_contract.h"

#include <math.h>

#define CASTERS_WIDER 0.1f /* tangent of the angle by which sides are turned outwards */
#define CASTERS_SIDES 4u

/* A pyramid from the eye to the plane `far` metres ahead of it. */
typedef struct casters_pyramid {
	stilb_vec3 eye, ahead;
	stilb_vec3 faces[CASTERS_SIDES + 1]; /* normals, inwards: left, top, right, bottom; the far one */
	stilb_vec3 corners[CASTERS_SIDES];   /* each between a side and the next one */
} casters_pyramid;

static casters_pyramid casters_pyramid_of(const stilb_shadow_view *view, float far, float wider)
{
	static const uint8_t order[CASTERS_SIDES] = {0, 3, 1, 2}; /* of stilb_frustum_from_matrix */
	stilb_frustum frustum = stilb_frustum_from_matrix(&view->view_projection);
	const float *m = view->view_projection.m, *eye = view->camera_position;
	casters_pyramid pyramid = {.eye = stilb_vec3_make(eye[0], eye[1], eye[2]),
	                           .ahead = stilb_vec3_normalize(stilb_vec3_make(m[3], m[7], m[11]))};
	stilb_vec3 *faces = pyramid.faces;
	for (uint32_t s = 0; s < CASTERS_SIDES; s++) {
		const stilb_plane *plane = &frustum.planes[order[s]];
		faces[s] = stilb_vec3_normalize(stilb_vec3_make(plane->x, plane->y, plane->z) + pyramid.ahead * wider);
	}
	faces[CASTERS_SIDES] = -pyramid.ahead;
	for (uint32_t s = 0; s < CASTERS_SIDES; s++) {
		stilb_vec3 edge = stilb_vec3_cross(faces[s], faces[(s + 1) % CASTERS_SIDES]);
		pyramid.corners[s] = pyramid.eye + edge * (far / stilb_vec3_dot(edge, pyramid.ahead));
	}
	return pyramid;
}

/* Adds the plane through a point with this normal, so many metres outside of it. */
static void casters_add(stilb_shadow_map *map, stilb_vec3 at, stilb_vec3 normal, float outside)
{
	STILB_ASSERT(map->caster_count < STILB_SHADOW_CASTER_PLANES);
	stilb_vec3 n = stilb_vec3_normalize(normal);
	map->casters[map->caster_count++] = (stilb_plane){n[0], n[1], n[2], outside - stilb_vec3_dot(n, at)};
}

/* Adds the plane along an edge and the light. */
static void casters_add_edge(stilb_shadow_map *map, const casters_pyramid *pyramid, stilb_vec3 from, stilb_vec3 to,
                             stilb_vec3 toward, float outside)
{
	stilb_vec3 edge = stilb_vec3_normalize(to - from), across = stilb_vec3_cross(edge, toward), middle = pyramid->eye;
	for (uint32_t s = 0; s < CASTERS_SIDES; s++)
		middle += (pyramid->corners[s] - pyramid->eye) * 0.2f;
	float in = stilb_vec3_dot(across, stilb_vec3_normalize(middle - from));
	if (fabsf(in) > 1e-4f) /* else the light shines along the edge */
		casters_add(map, from, in < 0.0f ? -across : across, outside);
}

void shadow_casters_choose(const stilb_shadow_view *view, const float direction[3], float far, float margin, float room,
                           stilb_shadow_map *map)
{
	casters_pyramid pyramid = casters_pyramid_of(view, far + room, CASTERS_WIDER);
	stilb_vec3 toward = stilb_vec3_make(-direction[0], -direction[1], -direction[2]);
	float outside = margin + room;
	bool kept[CASTERS_SIDES + 1];
	map->caster_count = 0;
	map->caster_margin = margin;
	for (uint32_t f = 0; f <= CASTERS_SIDES; f++) {
		kept[f] = stilb_vec3_dot(pyramid.faces[f], toward) >= 0.0f;
		if (kept[f])
			casters_add(map, f < CASTERS_SIDES ? pyramid.eye : pyramid.corners[0], pyramid.faces[f], outside);
	}
	for (uint32_t s = 0; s < CASTERS_SIDES; s++) {
		stilb_vec3 before = pyramid.corners[(s + CASTERS_SIDES - 1) % CASTERS_SIDES], here = pyramid.corners[s];
		if (kept[s] != kept[(s + 1) % CASTERS_SIDES])
			casters_add_edge(map, &pyramid, pyramid.eye, here, toward, outside);
		if (kept[s] != kept[CASTERS_SIDES])
			casters_add_edge(map, &pyramid, before, here, toward, outside);
	}
}

static bool casters_have_point(const stilb_shadow_map *map, stilb_vec3 at)
{
	for (uint32_t p = 0; p < map->caster_count; p++) {
		const stilb_plane *plane = &map->casters[p];
		if (!(plane->x * at[0] + plane->y * at[1] + plane->z * at[2] + plane->distance >= map->caster_margin))
			return false;
	}
	return true;
}

bool stilb_shadow_casters_hold(const stilb_shadow_map *kept, const stilb_shadow_map *now, const stilb_shadow_view *view)
{
	STILB_ASSERT(kept && now && view);
	if (kept->caster_count == 0 || now->caster_count == 0)
		return kept->caster_count == 0;
	casters_pyramid pyramid = casters_pyramid_of(view, now->far, 0.0f);
	bool holds = casters_have_point(kept, pyramid.eye);
	for (uint32_t s = 0; s < CASTERS_SIDES && holds; s++)
		holds = casters_have_point(kept, pyramid.corners[s]);
	return holds;
}

bool stilb_shadow_casters_have(const stilb_shadow_map *map, stilb_sphere sphere)
{
	STILB_ASSERT(map && map->caster_count <= STILB_SHADOW_CASTER_PLANES);
	for (uint32_t p = 0; p < map->caster_count; p++) {
		const stilb_plane *plane = &map->casters[p];
		if (plane->x * sphere.x + plane->y * sphere.y + plane->z * sphere.z + plane->distance < -sphere.radius)
			return false;
	}
	return true;
}
