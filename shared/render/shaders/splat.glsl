// Common to the vertex shaders of all kinds of splats. A sample becomes a point, with the sample as
// its attribute. Splats that are too large for points are two triangles, which fetch the sample by
// gl_VertexID (PULLED).
#ifdef PULLED
uniform highp usampler2D u_samples;
#else
layout(location = 0) in uvec4 a_sample;
#endif

uniform float u_quantized_isovalue;
uniform uint u_isosurface;
uniform vec3 u_scalar;          // weights of 1, gradient length, projection error

#if KIND != KIND_QUAD || !defined(PULLED)
#define TESTED_FOR_OCCLUSION
uniform bool u_drops_hidden;          // drops samples that are occluded by u_drawn
#if KIND == KIND_QUAD
uniform highp sampler2D u_drawn;      // depths drawn so far
#else
uniform highp usampler2D u_drawn;     // depths of each tile (depth_tiles.frag.glsl)
#endif
#endif

// In the texture.
int sample_index() { return gl_VertexID / 6; }

uvec4 fetch_sample() {
#ifdef PULLED
  int index = sample_index();
  return texelFetch(u_samples, ivec2(index % SAMPLE_TEXTURE_WIDTH, index / SAMPLE_TEXTURE_WIDTH), 0);
#else
  return a_sample;
#endif
}

// Moves points to the corner of the viewport, outside of the image, which costs less than clipping
// them.
void drop() {
#ifdef PULLED
  gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
#else
  gl_Position = vec4(-1.0, -1.0, 0.0, 1.0);
  gl_PointSize = 1.0;
#endif
}

// Whether a box with centre e and half sizes h is outside of a clip plane.
bool is_clipped(vec3 e, vec3 h) {
#ifdef CLIPPED
  for (int i = 0; i < u_clip_planes; ++i) {
    vec4 plane = u_clip_plane[i];
    if (dot(plane.xyz, e) + dot(abs(plane.xyz), h) < plane.w) return true;
  }
#endif
  return false;
}

#ifndef GRADIENTS
// The quantized isovalue of the surface that is drawn in the cell, clamped to the range of its
// corners. is_inside: whether it lies in this range. If not, a coarse cell contains a thin
// structure; in other cells, rounding of the corners is the cause.
float drawn_isovalue(Cell cell, out bool is_inside) {
  float wanted = u_quantized_isovalue;
  SKIPPABLE_IF(is_coarse()) wanted = thickened(cell, wanted);
  float reached = reachable(cell, wanted);
  is_inside = reached == wanted;
  return reached;
}
#endif

// The normal halfway between `normal` and the direction to the eye. The orientation of a structure
// thinner than a cell is unknown, and its plane must not be seen edge-on. Both normals are in the
// camera's frame.
vec3 towards_eye(vec3 normal, vec3 position) {
  vec3 to_eye = to_eye_from(position);
  return normalize(dot(normal, to_eye) < 0.0 ? to_eye - normal : to_eye + normal);
}

#ifndef GRADIENTS
// Replaces a coarse cell by the box of the structure that it contains (thin_box), and the normal by that
// of a plane through the box's middle. The plane contains the axes along which the structure continues.
// centre, size: of the cell, then of the box. in_view: the normal in the camera's frame.
void bound_thin(Cell cell, inout vec3 centre, inout vec3 size, inout vec3 in_view, out vec3 normal) {
  vec3 low, high, spanned;
  thin_box(cell, u_quantized_isovalue, 1.0 / cell_scale(), low, high, spanned);
  centre += (0.5 * (low + high) - 0.5) * size;
  size *= high - low;
  in_view = towards_eye(in_view, centre);
  vec3 across = row_from_view(in_view), free = across * (1.0 - spanned);
  normal = dot(free, free) > 1e-6 ? normalize(free) : across;
}
#endif

// The displacement, from the cell's centre, of the approximate projection (paper, section 3.2).
// A displacement longer than the threshold drops the sample (returns false), or is clamped to the
// threshold. Displacements are also clamped to the cell.
bool displace(float value, vec3 gradient, vec3 size, float quantized_isovalue, out vec3 displacement) {
  vec3 ascent = ascent_of(gradient);
  displacement = newton_step(value, gradient, ascent, quantized_isovalue);
  float threshold = u_displacement_threshold * cell_scale();
  float distance = abs(quantized_isovalue - value) * inversesqrt(max(dot(gradient, ascent), 1e-30));
  if (distance > threshold) {
    if (u_drops_far != 0 && !is_coarse()) return false;
    displacement *= threshold / distance;
  }
  displacement = clamp(displacement, -0.5 * size, 0.5 * size);
  return true;
}

// Another Newton step from the last displacement, clamped to the cell.
vec3 displace_further(vec4 at, vec3 size, float quantized_isovalue, vec3 displacement) {
  vec3 gradient = at.yzw / size;
  vec3 further = displacement + newton_step(at.x, gradient, ascent_of(gradient), quantized_isovalue);
  return clamp(further, -0.5 * size, 0.5 * size);
}

float scalar_of(Trilinear f, vec3 place, float steepness) {
  float error = 0.0;
  if (u_scalar.z != 0.0) {
    vec4 there = value_and_gradient(f, place);
    error = abs(there.x - u_quantized_isovalue) / max(length(there.yzw), 1e-6);
  }
  return dot(u_scalar, vec3(1.0, steepness, error));
}

#ifdef TESTED_FOR_OCCLUSION
#if KIND == KIND_QUAD
// Tests points at most QUAD_PROBE_PX apart. Only a narrow visible part of the square can be missed.
bool is_hidden(vec2 centre_px, vec2 half_px, float nearest, float farthest) {
  float reach = 0.8 * half_px.x;
  int steps = max(int(ceil(2.0 * reach / float(QUAD_PROBE_PX))), 2);
  float drawn = 0.0;
  for (int y = 0; y <= steps; ++y) {
    for (int x = 0; x <= steps; ++x) {
      vec2 px = centre_px + reach * (2.0 / float(steps) * vec2(x, y) - 1.0);
      drawn = max(drawn, texelFetch(u_drawn, ivec2(clamp(px, vec2(0.0), u_image_size - 1.0)), 0).x);
    }
  }
  return window_depth(nearest) > drawn + 1e-6;
}
#else
// Tests all tiles that the splat touches, so visible splats are never dropped. Splats of gradients are
// dropped as well if they are nearer than all surfaces, since they cover more than their cells.
bool is_hidden(vec2 centre_px, vec2 half_px, float nearest, float farthest) {
  vec2 last = u_image_size - 1.0;
  ivec2 low = ivec2(clamp(centre_px - half_px, vec2(0.0), last)) / HIDING_TILE_PX;
  ivec2 high = ivec2(clamp(centre_px + half_px, vec2(0.0), last)) / HIDING_TILE_PX;
#ifdef GRADIENTS
  if (any(greaterThanEqual(high - low, ivec2(SMOOTH_MAX_TILES)))) return false;
  uvec2 range = uvec2(0xffffffffu, 0u);
  for (int y = low.y; y <= high.y; ++y) {
    for (int x = low.x; x <= high.x; ++x) {
      uvec2 depths = texelFetch(u_drawn, ivec2(x, y), 0).yz;
      range = uvec2(min(range.x, depths.x), max(range.y, depths.y));
    }
  }
  vec2 surfaces = uintBitsToFloat(range);
  return window_depth(max(nearest, u_near_plane)) > surfaces.y + 1e-6 ||
         window_depth(max(farthest, u_near_plane)) < surfaces.x - 1e-6;
#else
  if (any(greaterThanEqual(high - low, ivec2(HIDING_MAX_TILES)))) return false;
  uint drawn = 0u;
  for (int y = low.y; y <= high.y; ++y) {
    for (int x = low.x; x <= high.x; ++x) drawn = max(drawn, texelFetch(u_drawn, ivec2(x, y), 0).x);
  }
  return window_depth(max(nearest, u_near_plane)) > uintBitsToFloat(drawn) + 1e-6;
#endif
}
#endif

#endif

// The sample's cell, its size and its centre. Returns false if the cell is not active.
bool find_cell(out Cell cell, out vec3 size, out vec3 centre) {
  cell = unpack_sample(fetch_sample());
  size = cell_size();
  centre = block_corner() + (cell.low + 0.5) * size;
  return is_active(cell.interval, u_quantized_isovalue);
}

// Drops splats that are outside of the image or occluded, and writes the position of all others.
// nearest, farthest: distances along the view of the splat's nearest and farthest points.
void place_splat(vec2 centre_px, vec2 half_px, float nearest, float farthest) {
  if (any(lessThan(half_px, vec2(0.0))) || any(lessThan(centre_px + half_px, vec2(0.0))) ||
      any(greaterThan(centre_px - half_px, u_image_size))) {
    drop();
    return;
  }
#ifndef PULLED
  half_px = vec2(max(half_px.x, half_px.y));
#endif
#ifdef TESTED_FOR_OCCLUSION
  if (u_drops_hidden && is_hidden(centre_px, half_px, nearest, farthest)) {
    drop();
    return;
  }
#endif
  float ndc_z = depth_in_clip_space(max(nearest, u_near_plane));
#ifdef PULLED
  int corner = gl_VertexID % 6;
  centre_px += half_px * vec2(corner == 1 || corner == 2 || corner == 4 ? 1.0 : -1.0,
                              corner == 2 || corner == 4 || corner == 5 ? 1.0 : -1.0);
  gl_Position = vec4(2.0 * centre_px / u_image_size - 1.0, ndc_z, 1.0);
#else
  gl_Position = vec4((2.0 * centre_px / u_image_size - 1.0) * u_guard_scale, ndc_z, 1.0);
  gl_PointSize = clamp(2.0 * half_px.x, 1.0, u_largest_point_px);
#endif
}

#if KIND != KIND_QUAD && KIND != KIND_ELLIPSE
#ifdef PULLED
// Bounds in px (low, high) of the part of a box beyond the near plane.
vec4 bounds_px(vec3 e, vec3 h) {
  mat3 to_camera = transpose(mat3(u_right.xyz, u_up.xyz, u_forward.xyz));
  vec3 middle = to_camera * e;
  mat3 half_edges = mat3(to_camera[0] * h.x, to_camera[1] * h.y, to_camera[2] * h.z);
  vec3 reach = abs(half_edges[0]) + abs(half_edges[1]) + abs(half_edges[2]);
  vec2 low = vec2(1e9), high = vec2(-1e9);
  for (int i = 0; i < 8; ++i) {
    vec3 corner = middle + half_edges * (2.0 * vec3(i & 1, i >> 1 & 1, i >> 2) - 1.0);
    if (corner.z < u_near_plane) continue;
    low = min(low, corner.xy / w_at(corner.z));
    high = max(high, corner.xy / w_at(corner.z));
  }
  // If the near plane cuts the box, the cut is no wider than the box.
  if (middle.z - reach.z < u_near_plane) {
    low = min(low, (middle.xy - reach.xy) / w_at(u_near_plane));
    high = max(high, (middle.xy + reach.xy) / w_at(u_near_plane));
  }
  return u_image_middle.xyxy + u_focal_px * vec4(low, high);
}
#endif

// Places a splat that covers a box (centre e, half sizes h), at the depth of the box's nearest point.
void place_box(vec3 e, vec3 h, float pad_px) {
  float z = dot(e, u_forward.xyz), reach = dot(abs(u_forward.xyz), h);
#ifdef PULLED
  if (is_beside(e, h)) {
    drop();
    return;
  }
  vec4 bounds = bounds_px(e, h);
  vec2 low_px = max(bounds.xy - pad_px, vec2(-1.0)), high_px = min(bounds.zw + pad_px, u_image_size + 1.0);
  place_splat(0.5 * (low_px + high_px), 0.5 * (high_px - low_px), z - reach, z + reach);
#else
  float positive = max(z, u_near_plane);
  place_splat(to_px(e, positive), half_extent_px(e, h, positive) + pad_px, z - reach, z + reach);
#endif
}
#endif
