// Computes from the depths of a layer how much light is blocked by other parts of its surface:
// light of the sky by horizons in slices of the hemisphere (GTAO: Jimenez et al. 2016), the key
// light by a march towards it. Directions and steps differ from pixel to pixel and from picture to
// picture, so that the mean of the accumulated pictures has many of both.
uniform float u_ambient_strength;
uniform float u_ambient_radius, u_ambient_radius_per_distance;  // largest distance of occluders; per distance from the eye
uniform float u_shadow_strength;
uniform float u_light_radius;                                   // at distance 1
uniform float u_shadow_length, u_shadow_length_per_distance;    // the latter: per distance from the eye
uniform vec2 u_noise_offset;                                    // of slices and of steps
uniform vec2 u_point_in_light;                                  // in its unit disc

const float kHalfPi = 1.57079633;

// J. Jimenez, "Next generation post processing in Call of Duty: Advanced Warfare", SIGGRAPH 2014.
float interleaved_noise(vec2 px) { return fract(52.9829189 * fract(dot(px, vec2(0.06711056, 0.00583715)))); }

// The position of the surface in a pixel, in the camera's frame.
vec3 position_at(vec2 px, float z) { return vec3((px - u_image_middle) * (u_per_focal_px * w_at(z)), -z); }

#ifdef TILE
// Depths of the whole image, for positions beyond the tile: u_whole_scale of its pixels per pixel.
uniform highp sampler2DArray u_whole_depths;
uniform float u_whole_scale;

bool find_beyond_tile(vec2 px, int layer, out vec3 position) {
  vec2 size = vec2(textureSize(u_whole_depths, 0).xy), middle = 0.5 * size;
  vec2 at = middle + (px - u_image_middle) * u_whole_scale;
  position = vec3(0.0);
  if (any(lessThan(at, vec2(0.0))) || any(greaterThanEqual(at, size))) return false;
  float depth = texelFetch(u_whole_depths, ivec3(at, layer), 0).x;
  position = position_at(u_image_middle + (floor(at) + 0.5 - middle) / u_whole_scale, distance_of(depth));
  return depth < 1.0;
}
#endif

// The position of the surface in the pixel that contains px; false if there is none. There is none
// outside of the image: repeating its edge would darken it.
bool find_surface(vec2 px, int layer, out vec3 position) {
  position = vec3(0.0);
  if (any(lessThan(px, vec2(0.0))) || any(greaterThanEqual(px, u_image_size))) {
#ifdef TILE
    return find_beyond_tile(px, layer, position);
#else
    return false;
#endif
  }
  float depth = texelFetch(u_depths, ivec3(px, layer), 0).x;
  position = position_at(floor(px) + 0.5, distance_of(depth));
  return depth < 1.0;
}

float slice_openness(float normal, float negative_horizon, float positive_horizon) {
  vec2 h = 2.0 * vec2(negative_horizon, positive_horizon);
  vec2 part = cos(normal) + h * sin(normal) - cos(h - normal);
  return 0.25 * (part.x + part.y);
}

float with_reflections(float open, float albedo) {
  vec3 k = vec3(2.0404, -4.7951, 2.7552) * albedo + vec3(-0.3324, 0.6417, 0.6903);
  return max(open, ((open * k.x + k.y) * open + k.z) * open);
}

// The cosine of the highest horizon along a direction in the image, at least `lowest`. Occluders
// fade out in the outer half of the radius. An occluder is assumed to extend behind its visible
// surface by the radius, along the view. Its distance is that of its nearest point, which may lie
// behind the visible surface.
float horizon(vec3 position, vec3 to_eye, int layer, vec2 direction, float radius, float radius_px,
              float offset, float lowest) {
  float highest = lowest;
  for (int i = 0; i < AMBIENT_STEPS; ++i) {
    float t = (float(i) + offset) / float(AMBIENT_STEPS);
    // Steps grow, since near occluders matter most. They begin beyond the pixel itself.
    vec3 there;
    if (find_surface(gl_FragCoord.xy + direction * (1.2 + t * t * radius_px), layer, there)) {
      vec3 to_there = there - position;
      float ahead = dot(to_there, to_eye), aside_2 = dot(to_there, to_there) - ahead * ahead;
      float beyond = max(ahead - radius, min(ahead, 0.0));
      float distance = sqrt(max(aside_2 + beyond * beyond, 0.0));
      float weight = clamp(2.0 - 2.0 * distance / radius, 0.0, 1.0);
      float cosine = ahead * inversesqrt(aside_2 + ahead * ahead);
      highest = max(highest, mix(lowest, cosine, weight));
    }
  }
  return highest;
}

// Share of the sky that is not occluded. normal: towards the eye.
float openness(vec3 position, vec3 normal, vec3 to_eye, int layer, vec2 noise) {
  float w = w_at(-position.z), radius = min(u_ambient_radius, u_ambient_radius_per_distance * w);
  float radius_px = radius * u_focal_px / w;
  float sum = 0.0;
  for (int i = 0; i < AMBIENT_SLICES; ++i) {
    float angle = (float(i) + noise.x) * (2.0 * kHalfPi / float(AMBIENT_SLICES));
    vec2 direction = vec2(cos(angle), sin(angle));
    vec3 axis = normalize(cross(vec3(direction, 0.0), to_eye));
    vec3 in_slice = normal - axis * dot(normal, axis);
    float size = length(in_slice);
    vec3 across = cross(to_eye, axis);  // along the direction, perpendicular to the view
    float tilt = atan(dot(in_slice, across), dot(in_slice, to_eye));
    float positive = horizon(position, to_eye, layer, direction, radius, radius_px, noise.y, cos(tilt + kHalfPi));
    float negative = horizon(position, to_eye, layer, -direction, radius, radius_px, noise.y, cos(tilt - kHalfPi));
    sum += size * slice_openness(tilt, max(-acos(clamp(negative, -1.0, 1.0)), tilt - kHalfPi),
                                 min(acos(clamp(positive, -1.0, 1.0)), tilt + kHalfPi));
  }
  return clamp(sum / float(AMBIENT_SLICES), 0.0, 1.0);
}

float disc_share(float height) {
  float x = clamp(height, -1.0, 1.0);
  return 0.5 + x * (0.6366 - 0.1366 * x * x);
}

// Share of the key light that arrives. Each picture tests the direction to another point of the light,
// with a penumbra that fills the space between these points. Surfaces farther in front of the ray than a
// quarter of its length cast no shadow: only their front is known.
float key_arrives(vec3 position, vec3 normal, int layer, float offset) {
  vec3 key = u_key_direction;
  if (dot(normal, key) <= 0.0) return 1.0;  // the surface faces away
  vec3 side = normalize(cross(key, abs(key.y) < 0.9 ? vec3(0.0, 1.0, 0.0) : vec3(1.0, 0.0, 0.0)));
  vec2 disc = u_light_radius * u_point_in_light;
  vec3 to_light = normalize(key + disc.x * side + disc.y * cross(key, side));
  float w = w_at(-position.z), px = w * u_per_focal_px;  // the size of a pixel
  vec3 from = position + normal * px;
  float longest = min(u_shadow_length, u_shadow_length_per_distance * w), thickness = 0.25 * longest;
  float length_of_ray = min(longest, 0.9 * (-from.z - u_near_plane) / max(to_light.z, 1e-3));
  float across = max(sqrt(1.0 - to_light.z * to_light.z), 0.05);
  float share = 1.0;
  for (int i = 0; i < SHADOW_STEPS; ++i) {
    float t = (float(i) + offset) / float(SHADOW_STEPS);
    float way = 2.0 * px + t * t * length_of_ray;
    vec3 p = from + way * to_light;
    vec3 there;
    if (find_surface(u_image_middle + p.xy * (u_focal_px / w_at(-p.z)), layer, there)) {
      float clearance = p.z - there.z;  // positive: the ray is in front of the surface
      float height = clearance * across / (0.5 * u_light_radius * way);
      // Surfaces far in front of the ray do not reach back to it, and the light's reach ends softly.
      float weight = clamp(2.0 + clearance / thickness, 0.0, 1.0) * clamp(3.0 - 3.0 * t, 0.0, 1.0);
      share = min(share, mix(1.0, disc_share(height), weight));
    }
  }
  return share;
}
