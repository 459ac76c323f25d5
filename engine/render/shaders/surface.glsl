// What a program's own function of a surface is given and returns. A program writes it in GLSL, in a file of its own:
//
//     Surface surface_function(Surface surface, SurfacePoint point)
//     {
//         float stripe = step(0.5, fract(point.local.y * surface_parameter(0).x + point.time));
//         surface.color = mix(surface.color, surface_parameter(1).rgb, stripe);
//         return surface;
//     }
//
// The file may have further functions and constants, whose names must not begin with gl_, surface_ or shade_, and may
// include Stilb's shading headers ("shading/shade_srgb.h"). stilb_surface() of the CMake package makes of it what
// scene/scene_function.h wants. For each pixel the function is called once: in passes of colour, of channels (--show)
// and, of materials with a mask, of depth alone. It may read nothing but its arguments and the parameters, so that all
// passes see the same surface. It must not discard: what shall not be there is alpha below the cutoff, of a material
// with a mask (discard does not compile). Derivatives (dFdx, fwidth) are right of what is made of the point, the
// parameters, color and alpha; of other members of the surface software devices have none at the edges of triangles.

// A surface as the factors, maps and vertices of its material make it (shading/shade_gltf.h). What the function returns
// may be anything: shares are cut off at 0 and 1, and what is not a number counts as 0.
struct Surface {
	vec3 color;      // base colour, linear, [0, 1]; of the specular workflow the diffuse colour
	float alpha;     // of masks and what blends; it has no say in opaque materials
	vec3 specular;   // reflectance at normal incidence, [0, 1]: of what is no metal; of the specular workflow of all
	float metalness; // [0, 1]; of the specular workflow it has no say
	float roughness; // [0, 1], perceptual
	float occlusion; // [0, 1], the share of even light that arrives
	vec3 normal;     // world space, unit, on the side that is seen; a longer or shorter one is made unit
	vec3 emission;   // radiance, >= 0; what the material emits it emits from the front alone
};
// Unlit materials show color, and nothing else of it but alpha. Coat, sheen, brushed metal and transmission stay the
// material's own; the colour of what goes through is `color`.

// Where it is.
struct SurfacePoint {
	vec3 position;  // world space, metres
	vec3 local;     // the same in the mesh's space, so that patterns move with the model
	vec3 normal;    // interpolated, world space, unit, on the side that is seen; maps and the function do not change it
	vec3 to_viewer; // world space, unit; where depth alone is drawn the viewer is that pass's: a light, for shadows
	vec2 uv, uv1;   // of the vertices; uv1: 0 of meshes without a second one
	vec4 color;     // of the vertices; 1 without
	float time;     // seconds, stilb_render_view.time
	bool front;     // the triangle's front is seen
};

// Number 0..3 of the material's parameters, which mean what the function takes them for.
vec4 surface_parameter(int number);
