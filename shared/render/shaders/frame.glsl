// The constants of a frame. Positions are coordinates along the volume's axes, with the eye at the
// origin; one unit is the smallest spacing. Cells are boxes in this space. The axes may be sheared, so
// there are vectors (positions, rays, displacements) and row vectors (camera axes, clip planes,
// gradients, normals). The dot product of a row vector with a vector equals that of the world; that of
// two vectors, or of two row vectors, does not. If the axes are perpendicular, both are the same, and
// u_ascent is the identity.
//
// FrameBlock (frame/frame.h) has the same members. Vectors are vec4 with an unused w, because some
// drivers lay out vec3 in a block wrongly.
layout(std140) uniform Frame {
  vec4 u_right;           // row vectors: the component of a vector to the right, up, forward
  vec4 u_up;
  vec4 u_forward;
  vec4 u_step_right;      // vectors: one unit to the right, up, forward
  vec4 u_step_up;
  vec4 u_step_forward;
  vec4 u_reach_of_unit;   // extent of a sphere of radius 1 along each axis
  mat3 u_ascent;          // transforms a gradient, a row vector, into a vector; symmetric
  vec4 u_cell_edges;      // of level 0
  vec4 u_clip_plane[MAX_CLIP_PLANES];  // keeps dot(xyz, position) >= w
  vec2 u_depth_terms;     // depth in [-1, 1] is x + y / z, orthographic x + y z
  float u_near_plane;     // distances along the view
  float u_far_plane;
  vec2 u_image_size;      // px
  vec2 u_guard_scale;     // image size / viewport size with guard band
  vec2 u_image_middle;    // middle of the whole image, in px of the tile that is drawn
  vec2 u_tile_corner;     // lower left corner of the tile in the whole image, px
  float u_focal_px;       // focal length in px, orthographic px per unit
  float u_per_focal_px;   // 1 / u_focal_px
  float u_largest_point_px;
  float u_splat_scale;
  float u_displacement_threshold;  // half the longest diagonal of a cell of level 0
  float u_log_distance_per_unit;   // change of log2(distance) per unit, at the target
  int u_clip_planes;      // their number
  int u_projects;         // 0: samples stay at their cells' centres
  int u_drops_far;        // 1: drops samples with far displacements
  int u_orthographic;     // 1: programs have ORTHOGRAPHIC then
};

// The functions that differ between perspective and orthographic cameras. z: distance along the
// view. Perspective programs are the only ones that divide by it.
#ifdef ORTHOGRAPHIC
// The divisor of image positions and sizes: the homogeneous coordinate w.
float w_at(float z) { return 1.0; }
float depth_in_clip_space(float z) { return u_depth_terms.x + u_depth_terms.y * z; }
float homogeneous_depth(float z) { return u_depth_terms.x + u_depth_terms.y * z; }
float distance_of(float depth) { return (2.0 * depth - 1.0 - u_depth_terms.x) / u_depth_terms.y; }
// One unit along the view, on the ray through the point e at this distance.
vec3 ray_to(vec3 e, float z) { return u_step_forward.xyz; }
// The components of this ray to the right and up.
vec2 aside_of(vec3 e, float z) { return vec2(0.0); }
// The point on the ray through an image position, at this distance.
vec3 point_at(vec2 px, float z) {
  vec2 across = (px - u_image_middle) * u_per_focal_px;
  return u_step_forward.xyz * z + u_step_right.xyz * across.x + u_step_up.xyz * across.y;
}
// The change of this point per unit along the view.
vec3 ray_at(vec2 px) { return u_step_forward.xyz; }
// In the camera's frame: the direction from a point, or an image position, to the eye.
vec3 to_eye_from(vec3 e) { return vec3(0.0, 0.0, 1.0); }
vec3 eye_from(vec2 px) { return vec3(0.0, 0.0, 1.0); }
float log_distance(float z) { return z * u_log_distance_per_unit; }
#else
float w_at(float z) { return z; }
float depth_in_clip_space(float z) { return u_depth_terms.x + u_depth_terms.y / z; }
// The same times w, which is defined beside and behind the eye as well.
float homogeneous_depth(float z) { return u_depth_terms.x * z + u_depth_terms.y; }
float distance_of(float depth) { return u_depth_terms.y / (2.0 * depth - 1.0 - u_depth_terms.x); }
vec3 ray_to(vec3 e, float z) { return e / z; }
vec2 aside_of(vec3 e, float z) { return vec2(dot(e, u_right.xyz), dot(e, u_up.xyz)) / z; }
vec3 ray_at(vec2 px) {
  vec2 slope = (px - u_image_middle) * u_per_focal_px;
  return u_step_forward.xyz + u_step_right.xyz * slope.x + u_step_up.xyz * slope.y;
}
vec3 point_at(vec2 px, float z) { return ray_at(px) * z; }
vec3 to_eye_from(vec3 e) {
  return normalize(-vec3(dot(e, u_right.xyz), dot(e, u_up.xyz), -dot(e, u_forward.xyz)));
}
vec3 eye_from(vec2 px) { return normalize(vec3((u_image_middle - px) * u_per_focal_px, 1.0)); }
float log_distance(float z) { return log2(z); }
#endif

float window_depth(float z) { return 0.5 + 0.5 * depth_in_clip_space(z); }

// Transform a row vector (gradient, normal) into the camera's frame, where its length is that of the
// world, and back.
vec3 row_to_view(vec3 row) {
  return vec3(dot(row, u_step_right.xyz), dot(row, u_step_up.xyz), -dot(row, u_step_forward.xyz));
}
vec3 row_from_view(vec3 v) { return v.x * u_right.xyz + v.y * u_up.xyz - v.z * u_forward.xyz; }

// The direction of steepest ascent. Programs for perpendicular axes omit the product, which saves a
// thirtieth of a software renderer's time for quads.
vec3 ascent_of(vec3 gradient) {
#ifdef SHEARED
  return u_ascent * gradient;
#else
  return gradient;
#endif
}

// The image position of a point at distance z along the view.
vec2 to_px(vec3 e, float z) {
  return u_image_middle + vec2(dot(e, u_right.xyz), dot(e, u_up.xyz)) * (u_focal_px / w_at(z));
}

// Homogeneous coordinates of a point, for triangles that GL clips.
vec4 in_clip_space(vec3 e) {
  float z = dot(e, u_forward.xyz), w = w_at(z);
  vec2 px = u_image_middle * w + vec2(dot(e, u_right.xyz), dot(e, u_up.xyz)) * u_focal_px;
  return vec4(2.0 * px / u_image_size - w, homogeneous_depth(z), w);
}

// Half the extent in px of a box with centre e and half sizes h. Conservative: never too small.
vec2 half_extent_px(vec3 e, vec3 h, float z) {
  vec2 aside = aside_of(e, z);
  vec3 right = u_right.xyz - u_forward.xyz * aside.x;
  vec3 up = u_up.xyz - u_forward.xyz * aside.y;
  float nearest = max(z - dot(abs(u_forward.xyz), h), u_near_plane);
  return vec2(dot(abs(right), h), dot(abs(up), h)) * (u_focal_px / w_at(nearest));
}

// Whether a box is completely outside of the frustum's sides. Its bounding rectangle in the image does
// not show this for boxes beside the eye: the near plane cuts them, and the rectangle spans the image.
bool is_beside(vec3 e, vec3 h) {
  vec2 least = -u_image_middle * u_per_focal_px, most = (u_image_size - u_image_middle) * u_per_focal_px;
#ifdef ORTHOGRAPHIC
  vec2 at = vec2(dot(e, u_right.xyz), dot(e, u_up.xyz));
  vec2 extent = vec2(dot(abs(u_right.xyz), h), dot(abs(u_up.xyz), h));
  return any(lessThan(at + extent, least)) || any(greaterThan(at - extent, most));
#else
  vec3 right = u_right.xyz - u_forward.xyz * least.x, left = u_forward.xyz * most.x - u_right.xyz;
  vec3 up = u_up.xyz - u_forward.xyz * least.y, down = u_forward.xyz * most.y - u_up.xyz;
  vec4 reach = vec4(dot(e, right) + dot(abs(right), h), dot(e, left) + dot(abs(left), h),
                    dot(e, up) + dot(abs(up), h), dot(e, down) + dot(abs(down), h));
  return any(lessThan(reach, vec4(0.0)));
#endif
}
