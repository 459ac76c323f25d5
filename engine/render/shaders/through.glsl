// What is seen through a surface: the picture so far, or the surroundings. Inside of layers_around.glsl.
#ifdef LIT_GLOSS
layout(set = 0, binding = 4) uniform sampler2D behind;
#else
layout(set = 0, binding = 1) uniform sampler2D behind;
#endif

// The image behind.frag and behind_half.frag make, between four times four texels of a mip by the cubic B-spline, which
// blurs squares away: four linear samples where it weighs pairs of texels.
vec4 behind_smooth(vec2 place, float lod)
{
	vec2 size = vec2(max(textureSize(behind, 0) >> int(lod), ivec2(1)));
	vec2 at = place * size - 0.5, low = floor(at), f = at - low, g = 1.0 - f;
	vec2 w0 = g * g * g / 6.0, w1 = (4.0 - 6.0 * f * f + 3.0 * f * f * f) / 6.0, w3 = f * f * f / 6.0;
	vec2 w2 = 1.0 - w0 - w1 - w3, left = w0 + w1, right = w2 + w3;
	vec2 a = (low - 0.5 + w1 / left) / size, b = (low + 1.5 + w3 / right) / size;
	return left.y * (left.x * textureLod(behind, a, lod) + right.x * textureLod(behind, vec2(b.x, a.y), lod)) +
		right.y * (left.x * textureLod(behind, vec2(a.x, b.y), lod) + right.x * textureLod(behind, b, lod));
}

// The surroundings in this direction, blurred by a lobe of this roughness about it.
vec3 through_around(vec3 toward, float roughness)
{
#ifdef LIT_GLOSS
	return gloss_light(toward, roughness);
#else
	if (lights_panorama)
		return panorama_irradiance(toward) / SHADE_PI;
	return sky_mirrored(toward, roughness);
#endif
}

// The way from the surface to the models behind it as a share of the way from the viewer to them, on average over those
// around the place: where they touch, nothing is blurred. 1: they are far away. radius: pixels. depth: of
// the surface.
float through_distance(vec2 place, float radius, float depth)
{
	const int TAPS = 16;
	ivec2 size = textureSize(behind, 0);
	float sum = 0.0, count = 0.0;
	for (int i = 0; i < TAPS; i++) { // a spiral of even density
		float angle = 2.39996 * float(i), away = radius * sqrt(float(i) / float(TAPS));
		ivec2 at = ivec2(place * vec2(size) + away * vec2(cos(angle), sin(angle)));
		float found = texelFetch(behind, clamp(at, ivec2(0), size - 1), 0).a;
		if (found > 0.0) {
			sum += max(1.0 - found / depth, 0.0);
			count += 1.0;
		}
	}
	return count > 0.0 ? sum / count : 0.25; // none was hit: few are there
}

// What is seen at a place of the picture, 0..1 inside of it, of a lobe of this roughness about `toward`. depth: of
// where light leaves the surface.
vec3 through_picture(vec2 place, float depth, vec3 toward, float roughness)
{
	vec2 size = vec2(textureSize(behind, 0));
	vec3 around = through_around(toward, roughness);
	vec2 outside = abs(place - 0.5) - 0.5; // > 0: so far
	vec3 sharp = max(outside.x, outside.y) <= 0.0 ? textureLod(behind, place, 0.0).rgb : around;
	// Half of the lobe is within twice alpha, as of a mirrored one; half of a spline's light within 0.76 texels.
	float radius = 2.0 * shade_alpha_from_roughness(roughness) * push.view.pixels;
	if (radius <= 0.76)
		return sharp;
	float lod = log2(max(radius * through_distance(place, min(radius, 0.25 * size.y), depth) / 0.76, 2.0));
	lod = min(lod, float(textureQueryLevels(behind) - 1));
	vec2 share = clamp(0.5 - 0.5 * outside * size / exp2(lod), 0.0, 1.0); // of the blur that is in the picture
	vec4 models = mix(behind_smooth(place, floor(lod)), behind_smooth(place, ceil(lod)), fract(lod));
	models *= share.x * share.y;
	return mix(sharp, models.rgb + around * (1.0 - models.a), clamp(log2(radius / 0.76), 0.0, 1.0));
}

// What comes through the surface to the viewer, of all but lights.
vec3 seen_through(shade_material material, vec3 n, vec3 v)
{
	float roughness = layers.roughness;
	float strongest = max(max(material.specular.x, material.specular.y), material.specular.z);
#ifdef LIT_GLOSS
	float share = gloss_shares(n, v, roughness).x * (1.0 - strongest); // what facets let through, of all directions
#else
	float share = shade_facet_left(material.specular, max(dot(n, v), 0.0));
#endif
	vec2 place = gl_FragCoord.xy / vec2(textureSize(behind, 0));
	float depth = gl_FragCoord.z;
	vec3 toward = -v, left = layers.tint * (layers.transmission * share);
	if (is_solid && layers.thickness > 0.0) {
		float ior = max(layers.ior, 1.0);
		vec3 leaves = world_position + refract(-v, n, 1.0 / ior) * layers.thickness;
		vec4 clip = push.view.rest.view_projection * vec4(leaves, 1.0);
		toward = normalize(leaves - push.view.camera_position.xyz);
		place = clip.w > 0.0 ? clip.xy / clip.w * 0.5 + 0.5 : vec2(-1.0);
		depth = clip.w > 0.0 ? clip.z / clip.w : 1.0;
		left *= exp(-layers.absorption * layers.thickness);
		roughness *= clamp(2.0 * ior - 2.0, 0.0, 1.0); // without refraction facets turn nothing
	}
#ifdef LIT_GLOSS
	else {
		vec3 lobe = shade_environment_direction(n, v, roughness);
		toward = lobe - n * (2.0 * dot(lobe, n));
	}
#endif
	return left * through_picture(place, depth, toward, roughness);
}
