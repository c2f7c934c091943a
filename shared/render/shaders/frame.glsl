// What stays the same throughout a frame. Positions are coordinates along the volume's axes, one
// unit = the smallest spacing, the eye at the origin. So cells are boxes. The axes may be sheared:
// there are vectors (positions, rays, displacements: what moves a position) and row vectors (camera
// axes, clip planes, gradients and normals: what a dot product with a vector measures). The dot
// product of the one with the other is that of the world; lengths and angles of two of a kind are
// not. Where the axes are perpendicular, both are the same, and u_ascent is the identity.
layout(std140) uniform Frame {
  vec4 u_right;           // row vectors: how far a vector leads to the right, up, forward
  vec4 u_up;              // u_right.w: least distance between opposite faces of a cell, in its least
  vec4 u_forward;         // edges
  vec4 u_step_right;      // vectors: one unit to the right, up, forward. w: how far a sphere of one
  vec4 u_step_up;         // unit reaches along the first, second, third axis
  vec4 u_step_forward;
  mat3 u_ascent;          // the vector of a gradient, which is a row vector; symmetric
  vec4 u_depth;           // x, y: depth in [-1, 1] is x + y / z; z, w: near and far plane
  vec4 u_image;           // x, y: width and height in px; z, w: shrink into the guard band
  vec4 u_lens;            // x: focal length in px; y: 1 / x; z: largest point in px; w: splat scale
  vec4 u_cell;            // xyz: edges of a cell of level 0; w: half its longest diagonal
  vec4 u_clip_plane[MAX_CLIP_PLANES];  // keeps dot(xyz, position) >= w
  ivec4 u_switches;       // x: clip planes; y: 1 projects samples; z: 1 drops those projected too far
};

float window_depth(float z) { return 0.5 + 0.5 * (u_depth.x + u_depth.y / z); }
float distance_of(float depth) { return u_depth.y / (2.0 * depth - 1.0 - u_depth.x); }

// A vector in the camera's frame: right, up, towards the eye.
vec3 to_view(vec3 v) { return vec3(dot(v, u_right.xyz), dot(v, u_up.xyz), -dot(v, u_forward.xyz)); }

// A row vector (gradient, normal) in the camera's frame, where its length is the world's, and back.
vec3 row_to_view(vec3 row) {
  return vec3(dot(row, u_step_right.xyz), dot(row, u_step_up.xyz), -dot(row, u_step_forward.xyz));
}
vec3 row_from_view(vec3 v) { return v.x * u_right.xyz + v.y * u_up.xyz - v.z * u_forward.xyz; }

// The direction of steepest ascent. Programs for perpendicular axes save the product: a thirtieth of
// a software renderer's time for squares.
vec3 ascent_of(vec3 gradient) {
#ifdef SHEARED
  return u_ascent * gradient;
#else
  return gradient;
#endif
}

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

// Whether a box is wholly beside what the camera sees. Rectangles cannot tell: those of boxes beside
// the eye, which the near plane cuts, reach across the image.
bool is_beside(vec3 e, vec3 h) {
  vec2 slope = 0.5 * u_image.xy * u_lens.y;
  vec3 right = u_right.xyz + u_forward.xyz * slope.x, left = u_forward.xyz * slope.x - u_right.xyz;
  vec3 up = u_up.xyz + u_forward.xyz * slope.y, down = u_forward.xyz * slope.y - u_up.xyz;
  vec4 reach = vec4(dot(e, right) + dot(abs(right), h), dot(e, left) + dot(abs(left), h),
                    dot(e, up) + dot(abs(up), h), dot(e, down) + dot(abs(down), h));
  return any(lessThan(reach, vec4(0.0)));
}
