// One sample becomes one splat: a point (attribute), or, where points cannot be that large, two
// triangles that fetch the sample by gl_VertexID (PULLED).
#ifdef PULLED
uniform highp usampler2D u_samples;
#else
layout(location = 0) in uvec4 a_sample;
#endif

uniform vec4 u_block;           // xyz: the block's corner 0; w: cells of level 0 per cell (2^level)
uniform uvec2 u_regions;         // a bit for each 16³ cells of the block: whether they are drawn
uniform float u_isocode;
uniform uint u_isosurface;
uniform vec3 u_scalar;          // weights of 1, gradient length, projection error

#if KIND == KIND_QUAD
flat out uvec4 v_pixel;
#elif KIND == KIND_ELLIPSE
flat out vec2 v_centre_px;
flat out vec3 v_distance;       // along the view: at the centre, and per px to the right and up
flat out vec3 v_place, v_place_x, v_place_y;  // in the cell, from its centre, in cells; likewise
flat out vec3 v_along;          // that place per unit along the view
flat out vec3 v_bend;           // how far the surface leaves the plane: along the view, per xy, xz, yz
flat out vec3 v_gradient, v_gradient_x, v_gradient_y;  // in the camera's frame, likewise
flat out float v_scalar;
#else
flat out vec4 v_centre;         // of the cell; w: distance along the view
#ifndef PULLED
flat out vec2 v_centre_px;
#endif
flat out vec3 v_size;           // of the cell
flat out vec4 v_a, v_b;         // the trilinear interpolant minus the isocode, in spans
flat out vec4 v_plane;          // tangent plane: dot(xyz, position - centre) = w
flat out vec4 v_sample;         // projected sample - centre; w: its footprint, 1 or less
flat out float v_scalar;
flat out float v_span;
#endif

// Half the extent in px of a box with half sizes h about e, and never less than the truth.
vec2 half_extent_px(vec3 e, vec3 h, float z) {
  vec3 right = u_right.xyz - u_forward.xyz * (dot(e, u_right.xyz) / z);
  vec3 up = u_up.xyz - u_forward.xyz * (dot(e, u_up.xyz) / z);
  float nearest = max(z - dot(abs(u_forward.xyz), h), u_depth.z);
  return vec2(dot(abs(right), h), dot(abs(up), h)) * (u_lens.x / nearest);
}

vec2 to_px(vec3 e, float z) {
  return 0.5 * u_image.xy + vec2(dot(e, u_right.xyz), dot(e, u_up.xyz)) * (u_lens.x / z);
}

#ifdef PULLED
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

// Bounds in px (lowest, highest) of the part of a box beyond the near plane.
vec4 bounds_px(vec3 e, vec3 h) {
  mat3 to_camera = transpose(mat3(u_right.xyz, u_up.xyz, u_forward.xyz));
  vec3 middle = to_camera * e;
  mat3 half_edges = mat3(to_camera[0] * h.x, to_camera[1] * h.y, to_camera[2] * h.z);
  vec3 reach = abs(half_edges[0]) + abs(half_edges[1]) + abs(half_edges[2]);
  vec2 low = vec2(1e9), high = vec2(-1e9);
  for (int i = 0; i < 8; ++i) {
    vec3 corner = middle + half_edges * (2.0 * vec3(i & 1, i >> 1 & 1, i >> 2) - 1.0);
    if (corner.z < u_depth.z) continue;
    low = min(low, corner.xy / corner.z);
    high = max(high, corner.xy / corner.z);
  }
  // Where the near plane cuts the box, no more of that plane is inside than the box is wide.
  if (middle.z - reach.z < u_depth.z) {
    low = min(low, (middle.xy - reach.xy) / u_depth.z);
    high = max(high, (middle.xy + reach.xy) / u_depth.z);
  }
  return 0.5 * u_image.xyxy + u_lens.x * vec4(low, high);
}
#endif

void drop() {
  gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
  gl_PointSize = 1.0;
}

/// low: the cell's (or octant's) low corner in the block, 0 to 64.
bool is_drawn(vec3 low) {
  uvec3 region = uvec3(low) >> 4;
  uint bit = region.x + 4u * region.y + 16u * region.z;
  return ((bit < 32u ? u_regions.x : u_regions.y) >> (bit & 31u) & 1u) != 0u;
}

void main() {
#ifdef PULLED
  int index = gl_VertexID / 6, corner = gl_VertexID - index * 6;
  uvec4 packed_sample = texelFetch(
      u_samples, ivec2(index % SAMPLE_TEXTURE_WIDTH, index / SAMPLE_TEXTURE_WIDTH), 0);
#else
  uvec4 packed_sample = a_sample;
#endif
#if KIND == KIND_QUAD
  v_pixel = uvec4(0u);
#elif KIND == KIND_ELLIPSE
  v_centre_px = vec2(0.0);
  v_distance = v_along = v_bend = v_place = v_place_x = v_place_y = v_gradient = v_gradient_x = v_gradient_y = vec3(0.0);
  v_scalar = 0.0;
#else
  v_centre = v_a = v_b = v_plane = v_sample = vec4(0.0);
#ifndef PULLED
  v_centre_px = vec2(0.0);
#endif
  v_size = vec3(1.0);
  v_scalar = v_span = 0.0;
#endif
  Cell cell = octant_of(unpack_sample(packed_sample), packed_sample);
  if (!is_active(cell.interval, u_isocode) || !is_drawn(cell.low)) {
    drop();
    return;
  }

  vec3 size = u_spacing.xyz * (u_block.w * cell.size);
  vec3 centre = u_block.xyz + (cell.low + 0.5 * cell.size) * u_block.w * u_spacing.xyz;

  // Corners are rounded where the interval is wide, and coarse cells reach beyond their corners:
  // go for the nearest value that they have.
  vec4 least = min(cell.lower, cell.upper), most = max(cell.lower, cell.upper);
  float low = min(min(least.x, least.y), min(least.z, least.w));
  float high = max(max(most.x, most.y), max(most.z, most.w));
  float isocode = clamp(u_isocode, low, high);
  float footprint = u_block.w > 1.0 && isocode != u_isocode ? THIN_FOOTPRINT : 1.0;

  Trilinear f = trilinear(cell.lower, cell.upper);
  vec4 at = value_and_gradient(f, vec3(0.5));
  vec3 gradient = at.yzw / size;
  vec3 displacement = vec3(0.0);
  if (u_switches.y != 0) {
    displacement = newton_step(at.x, gradient, isocode);
    float threshold = 0.5 * length(size), distance = length(displacement);
    if (distance > threshold) {
      if (u_switches.z != 0 && u_block.w == 1.0) {
        drop();
        return;
      }
      displacement *= threshold / distance;
    }
    displacement = clamp(displacement, -0.5 * size, 0.5 * size);
#if KIND != KIND_QUAD
    // Further steps, from where the first one led: the gradient there is the surface's.
    for (int i = 0; i < 2; ++i) {
      at = value_and_gradient(f, displacement / size + 0.5);
      gradient = at.yzw / size;
      displacement =
          clamp(displacement + newton_step(at.x, gradient, isocode), -0.5 * size, 0.5 * size);
    }
    at = value_and_gradient(f, displacement / size + 0.5);
    gradient = at.yzw / size;
#endif
  }
  float steepness = length(gradient);
  vec3 normal = steepness > 0.0 ? gradient / steepness : -u_forward.xyz;
  float error = 0.0;
  if (u_scalar.z != 0.0) {
    vec4 there = value_and_gradient(f, displacement / size + 0.5);
    error = abs(there.x - u_isocode) / max(length(there.yzw), 1e-6);
  }
  float scalar = dot(u_scalar, vec3(1.0, steepness, error));

  vec3 position = centre + displacement;
#if KIND == KIND_QUAD || KIND == KIND_ELLIPSE
#ifdef CLIPPED
  for (int i = 0; i < u_switches.x; ++i) {
    if (dot(u_clip_plane[i].xyz, position) < u_clip_plane[i].w) {
      drop();
      return;
    }
  }
#endif
  float z = dot(position, u_forward.xyz);
  if (z < u_depth.z) {
    drop();
    return;
  }
  vec2 centre_px = to_px(position, z);
#endif
#if KIND == KIND_QUAD
  vec2 half_px =
      half_extent_px(position, 0.5 * QUAD_FOOTPRINT * size * footprint * u_lens.w, z);
  half_px = vec2(max(half_px.x, half_px.y));
  v_pixel = encode_surface(to_view(normal), scalar, u_isosurface, 1.0);
  // Of overlapping squares the nearest is seen, which brings the surface forward: put it back.
  float back = z + QUAD_SETBACK * dot(abs(u_forward.xyz), size);
  float ndc_z = u_depth.x + u_depth.y / back;
#elif KIND == KIND_ELLIPSE
  // The disc in the tangent plane that the cell's shape scales. One px to the right, or up, moves
  // the hit in the plane by across_x, or across_y.
  vec3 to_hit = position / z;
  float facing = dot(normal, to_hit);
  facing = facing < 0.0 ? min(facing, -ELLIPSE_LEAST_FACING) : max(facing, ELLIPSE_LEAST_FACING);
  vec2 slope = -vec2(dot(normal, u_right.xyz), dot(normal, u_up.xyz)) / facing;
  float px = z * u_lens.y;  // size of a pixel there
  vec3 across_x = px * (u_right.xyz + to_hit * slope.x);
  vec3 across_y = px * (u_up.xyz + to_hit * slope.y);
  vec3 x = across_x / size, y = across_y / size;
  // The part of the disc inside of its cell's box, a little enlarged. Its bounds on the image: the
  // disc's, or the box's.
  vec3 form = vec3(dot(x, x), dot(x, y), dot(y, y)) /
              (ELLIPSE_RADIUS * ELLIPSE_RADIUS * footprint * footprint * u_lens.w * u_lens.w);
  float determinant = max(form.x * form.z - form.y * form.y, 1e-12);
  vec2 half_px = sqrt(form.zx / determinant) + ELLIPSE_LEAST_PX + 0.5;
  v_centre_px = centre_px;
  v_place = displacement / size;
  v_place_x = x;
  v_place_y = y;
  if (footprint < 1.0) v_place *= 0.0;
  v_distance = vec3(z, px * slope);
  // The second derivatives of a trilinear function: mixed ones only.
  vec3 p = displacement / size + 0.5;
  float xy = f.a.w + p.z * f.b.w, xz = f.b.y + p.y * f.b.w, yz = f.b.z + p.x * f.b.w;
  mat3 hessian = mat3(0.0, xy, xz, xy, 0.0, yz, xz, yz, 0.0);
  v_gradient = to_view(normal);
  float per = 1.0 / max(steepness, 1e-6);
  v_gradient_x = to_view((hessian * x) / size) * per;
  v_gradient_y = to_view((hessian * y) / size) * per;
  v_scalar = scalar;
  v_along = to_hit / size;
  v_bend = -vec3(xy, xz, yz) * (per / facing);
  if (footprint < 1.0) v_bend = vec3(0.0);
  float ndc_z = 0.0;
#else
  float z = dot(centre, u_forward.xyz);
  float reach = dot(abs(u_forward.xyz), 0.5 * size);
  if (z + reach < u_depth.z) {
    drop();
    return;
  }
#if KIND == KIND_EXACT
  vec3 half_box = (0.5 + EXACT_MARGIN_CELLS) * size;
  float pad_px = 0.51;
#else
  vec3 half_box = (0.5 + BLEND_MARGIN_CELLS) * size;
  float pad_px = 1.01;
#endif
  half_box *= footprint;
  vec3 middle = footprint < 1.0 ? position : centre;
  half_box *= u_lens.w;
#ifdef PULLED
  if (is_beside(middle, half_box)) {
    drop();
    return;
  }
  vec4 bounds = bounds_px(middle, half_box);
  vec2 low_px = max(bounds.xy - pad_px, vec2(-1.0)), high_px = min(bounds.zw + pad_px, u_image.xy + 1.0);
  vec2 centre_px = 0.5 * (low_px + high_px), half_px = 0.5 * (high_px - low_px);
#else
  z = max(z, u_depth.z);
  float middle_z = max(dot(middle, u_forward.xyz), u_depth.z);
  vec2 centre_px = to_px(middle, middle_z);
  vec2 half_px = half_extent_px(middle, half_box, middle_z) + pad_px;
  v_centre_px = to_px(centre, z);
#endif
  v_centre = vec4(centre, z);
  v_size = size;
  v_span = max(high - low, 1e-6);
  v_a = f.a / v_span;
  v_b = f.b / v_span;
  v_a.x = (f.a.x - isocode) / v_span;
  v_plane = vec4(normal, dot(normal, displacement));
  v_sample = vec4(displacement, footprint);
  v_scalar = dot(u_scalar.xz, vec2(1.0, error));
  float ndc_z = 0.0;
#endif

  // Splats wholly outside of the image cost nothing.
  if (any(lessThan(half_px, vec2(0.0))) || any(lessThan(centre_px + half_px, vec2(0.0))) ||
      any(greaterThan(centre_px - half_px, u_image.xy))) {
    drop();
    return;
  }
#ifdef PULLED
  vec2 sign_of_corner = vec2(corner == 1 || corner == 2 || corner == 4 ? 1.0 : -1.0,
                             corner == 2 || corner == 4 || corner == 5 ? 1.0 : -1.0);
  centre_px += sign_of_corner * half_px;
  gl_Position = vec4(2.0 * centre_px / u_image.xy - 1.0, ndc_z, 1.0);
#else
  gl_Position = vec4((2.0 * centre_px / u_image.xy - 1.0) * u_image.zw, ndc_z, 1.0);
  gl_PointSize = clamp(2.0 * max(half_px.x, half_px.y), 1.0, u_lens.z);
#endif
}
