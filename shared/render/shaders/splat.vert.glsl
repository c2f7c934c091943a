// Splats whose fragments find the cell's trilinear surface: near the tangent plane (ellipse), or
// anywhere in the cell's box (exact, blended).
#if KIND == KIND_ELLIPSE
flat out vec2 v_centre_px;
flat out vec4 v_distance;       // x: distance of the sample along the view; yz: change of the tangent
                                // plane's distance per px; w: curvature of the surface
flat out vec3 v_place, v_place_x, v_place_y;  // position in the cell, 0 to 1: of the sample; change per px
flat out vec3 v_along;          // change of this position per unit along the view
#else
flat out vec4 v_centre;         // of the cell; w: distance along the view
#ifndef PULLED
flat out vec2 v_centre_px;
#endif
flat out float v_span;
#endif
flat out vec3 v_size;           // of the cell
flat out vec4 v_a, v_b;         // the trilinear interpolant minus the quantized isovalue, in spans
flat out float v_scalar;

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
    if (corner.z < u_depth.z) continue;
    low = min(low, corner.xy / corner.z);
    high = max(high, corner.xy / corner.z);
  }
  // If the near plane cuts the box, the cut is no wider than the box.
  if (middle.z - reach.z < u_depth.z) {
    low = min(low, (middle.xy - reach.xy) / u_depth.z);
    high = max(high, (middle.xy + reach.xy) / u_depth.z);
  }
  return 0.5 * u_image.xyxy + u_lens.x * vec4(low, high);
}
#endif

void main() {
#if KIND == KIND_ELLIPSE
  v_distance = vec4(0.0);
  v_place = v_place_x = v_place_y = v_along = vec3(0.0);
#else
  v_centre = vec4(0.0);
  v_span = 0.0;
#endif
#if KIND == KIND_ELLIPSE || !defined(PULLED)
  v_centre_px = vec2(0.0);
#endif
  v_size = vec3(1.0);
  v_a = v_b = vec4(0.0);
  v_scalar = 0.0;
  Cell cell;
  vec3 size, centre;
  if (!find_cell(cell, size, centre)) {
    drop();
    return;
  }
  float quantized_isovalue = reachable(cell, u_quantized_isovalue);

  Trilinear f = trilinear(cell.lower, cell.upper);
  vec4 at = value_and_gradient(f, vec3(0.5));
  vec3 gradient = at.yzw / size, displacement = vec3(0.0);
  if (u_switches.y != 0) {
    if (!displace(at.x, gradient, size, quantized_isovalue, displacement)) {
      drop();
      return;
    }
    // More Newton steps, with the gradients at the displaced points.
    for (int i = 0; i < 2; ++i) {
      at = value_and_gradient(f, displacement / size + 0.5);
      displacement = displace_further(at, size, quantized_isovalue, displacement);
    }
    at = value_and_gradient(f, displacement / size + 0.5);
    gradient = at.yzw / size;
  }
  vec3 in_view = row_to_view(gradient);  // the gradient, and then the normal
  float steepness = length(in_view);
  float per_steepness = 1.0 / steepness;
  in_view = steepness > 0.0 ? in_view * per_steepness : vec3(0.0, 0.0, 1.0);
  vec3 normal = steepness > 0.0 ? gradient * per_steepness : -u_forward.xyz;
#if KIND == KIND_ELLIPSE
  v_scalar = scalar_of(f, displacement / size + 0.5, steepness);
#else
  v_scalar = scalar_of(f, displacement / size + 0.5, 0.0);  // fragments have gradients of their own
#endif
  vec3 position = centre + displacement;

  float footprint = thin_footprint(cell, quantized_isovalue);
  if (footprint < 1.0 || u_switches.y == 0) {
    // The trilinear function has no surface here, or projection is disabled: draws a plane in a smaller
    // box around the sample. The box stays inside of the cell, since the occlusion query tests no more
    // than the cell.
    vec3 room = 0.5 * (1.0 - footprint) * size;
    size *= footprint;
    centre += clamp(displacement, -room, room);
    position = centre;
    displacement = vec3(0.0);
    if (footprint < 1.0) {
      in_view = towards_eye(in_view, position);
      normal = row_from_view(in_view);
    }
    vec3 across = size * normal * (steepness > 0.0 ? steepness : 1.0);
    f = Trilinear(vec4(quantized_isovalue - 0.5 * (across.x + across.y + across.z), across.xy, 0.0),
                  vec4(across.z, 0.0, 0.0, 0.0));
  }
  v_size = size;
  v_a = f.a;
  v_a.x -= quantized_isovalue;
  v_b = f.b;

#if KIND == KIND_ELLIPSE
  vec3 half_box = (0.5 + ELLIPSE_MARGIN_CELLS) * u_lens.w * size;
  float reach = dot(abs(u_forward.xyz), half_box);
  float z = dot(position, u_forward.xyz);
  if (z < u_depth.z || is_clipped(centre, half_box)) {
    drop();
    return;
  }
  // One px to the right, or up, moves the ray's intersection with the tangent plane by `slope` px along
  // the view.
  vec3 to_hit = position / z;
  float facing = dot(normal, to_hit);
  facing = facing < 0.0 ? min(facing, -ELLIPSE_MIN_FACING) : max(facing, ELLIPSE_MIN_FACING);
  vec2 slope = -in_view.xy / facing;
  float px = z * u_lens.y;  // size of a pixel there
  // Bounds of the tangent plane's part inside of the cell's box: for any c, it extends no further along
  // r than the box along r - c n. The more curved the surface is, by the mixed second derivatives, the
  // smaller is c.
  vec2 aside = vec2(dot(to_hit, u_right.xyz), dot(to_hit, u_up.xyz));
  vec3 right = u_right.xyz - u_forward.xyz * aside.x, up = u_up.xyz - u_forward.xyz * aside.y;
  vec2 edge = in_view.xy + in_view.z * aside;  // the normal along right and up
  float bent = (abs(f.a.w) + abs(f.b.y) + abs(f.b.z) + abs(f.b.w)) /
               max(length(gradient * size), 1e-9);
  float flatness = clamp(0.95 - bent, 0.0, 1.0);
  vec3 along_right = right - flatness * edge.x * normal;
  vec3 along_up = up - flatness * edge.y * normal;
  vec2 box_px = vec2(dot(abs(right), half_box), dot(abs(up), half_box));
  vec2 plane_px = vec2(dot(abs(along_right), half_box), dot(abs(along_up), half_box));
  vec2 box_from = vec2(dot(right, displacement), dot(up, displacement));
  vec2 plane_from = vec2(dot(along_right, displacement), dot(along_up, displacement));
  vec2 low_px = max(-box_from - box_px, -plane_from - plane_px) / px;
  vec2 high_px = min(-box_from + box_px, -plane_from + plane_px) / px;
  v_centre_px = to_px(position, z);
  v_distance = vec4(z, px * slope, bent);
  v_place = displacement / size + 0.5;
  v_place_x = px * u_step_right.xyz / size;
  v_place_y = px * u_step_up.xyz / size;
  v_along = to_hit / size;
  place_splat(v_centre_px + 0.5 * (low_px + high_px), 0.5 * (high_px - low_px) + 0.5,
              dot(centre, u_forward.xyz) - reach);
#else
  float z = dot(centre, u_forward.xyz);
  if (z + dot(abs(u_forward.xyz), 0.5 * size) < u_depth.z) {
    drop();
    return;
  }
#if KIND == KIND_EXACT
  vec3 half_box = (0.5 + ROUNDED_MARGIN_CELLS) * u_lens.w * size;
  float pad_px = 0.51;
#else
  vec3 half_box = (0.5 + BLEND_MARGIN_CELLS) * u_lens.w * size;
  float pad_px = 1.01;
#endif
  v_span = max(cell.interval.y - cell.interval.x, 1e-6);
  v_a /= v_span;
  v_b /= v_span;
#ifdef PULLED
  v_centre = vec4(centre, z);
  if (is_beside(centre, half_box)) {
    drop();
    return;
  }
  vec4 bounds = bounds_px(centre, half_box);
  vec2 low_px = max(bounds.xy - pad_px, vec2(-1.0)), high_px = min(bounds.zw + pad_px, u_image.xy + 1.0);
  place_splat(0.5 * (low_px + high_px), 0.5 * (high_px - low_px), z);
#else
  z = max(z, u_depth.z);
  v_centre = vec4(centre, z);
  v_centre_px = to_px(centre, z);
  place_splat(v_centre_px, half_extent_px(centre, half_box, z) + pad_px,
              z - dot(abs(u_forward.xyz), half_box));
#endif
#endif
}
