// What stays the same throughout a frame. Space of all positions and directions here: the volume's
// axes, one unit = the smallest spacing, the eye at the origin. (Index space scaled by spacing:
// lengths and angles are true, so Newton steps run along the normal.)
layout(std140) uniform Frame {
  vec4 u_right;           // camera axes in that space; w unused
  vec4 u_up;
  vec4 u_forward;
  vec4 u_depth;           // x, y: depth in [-1, 1] is x + y / z; z, w: near and far plane
  vec4 u_image;           // x, y: width and height in px; z, w: shrink into the guard band
  vec4 u_lens;            // x: focal length in px; y: 1 / x; z: largest point in px; w: splat scale
  vec4 u_spacing;         // spacing / smallest spacing
  vec4 u_clip_plane[MAX_CLIP_PLANES];  // keeps dot(xyz, position) >= w
  ivec4 u_switches;       // x: clip planes; y: 1 projects samples; z: 1 drops those projected too far
};

float window_depth(float z) { return 0.5 + 0.5 * (u_depth.x + u_depth.y / z); }
float distance_of(float depth) { return u_depth.y / (2.0 * depth - 1.0 - u_depth.x); }

vec3 to_view(vec3 v) { return vec3(dot(v, u_right.xyz), dot(v, u_up.xyz), -dot(v, u_forward.xyz)); }

// Where a point z away along the view comes to lie on the image.
vec2 to_px(vec3 e, float z) {
  return 0.5 * u_image.xy + vec2(dot(e, u_right.xyz), dot(e, u_up.xyz)) * (u_lens.x / z);
}

// Half the extent in px of a box with half sizes h about e, and never less than the truth.
vec2 half_extent_px(vec3 e, vec3 h, float z) {
  vec3 right = u_right.xyz - u_forward.xyz * (dot(e, u_right.xyz) / z);
  vec3 up = u_up.xyz - u_forward.xyz * (dot(e, u_up.xyz) / z);
  float nearest = max(z - dot(abs(u_forward.xyz), h), u_depth.z);
  return vec2(dot(abs(right), h), dot(abs(up), h)) * (u_lens.x / nearest);
}
