// Splats whose fragments find the cell's trilinear surface: near the tangent plane (ellipse), or
// anywhere in the cell's box (exact).
#if KIND == KIND_ELLIPSE
flat out vec2 v_centre_px;
flat out vec4 v_distance;       // x: distance of the sample along the view; yz: change of the tangent
                                // plane's distance per px; w: curvature of the surface, negative where
                                // it is not that of the trilinear function
flat out vec3 v_place, v_place_x, v_place_y;  // position in the cell, 0 to 1: of the sample; change per px
flat out vec3 v_along;          // change of this position per unit along the view
#else
flat out vec4 v_centre;         // of the box around the surface; w: distance along the view
#ifndef PULLED
flat out vec2 v_centre_px;
#endif
flat out float v_span;          // negative if the surface is not that of the trilinear function
#endif
flat out vec3 v_size;           // of the cell, or of the box around the surface
flat out vec4 v_a, v_b;         // the trilinear interpolant minus the quantized isovalue, in spans
#ifdef FIELD
flat out vec4 v_field_a, v_field_b;  // the field's quantized values in the cell, or in the box
#ifdef CATEGORIES
flat out vec3 v_field_middle;
#endif
#ifdef LINES
flat out float v_least_sine;
#endif
#else
flat out float v_scalar;
#endif

// Values of all outputs, for samples that are dropped.
void clear_outputs() {
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
#ifdef FIELD
  v_field_a = v_field_b = vec4(0.0);
#ifdef CATEGORIES
  v_field_middle = vec3(0.5);
#endif
#ifdef LINES
  v_least_sine = 0.0;
#endif
#else
  v_scalar = 0.0;
#endif
}

// The sample after its projection.
struct Projected {
  vec3 displacement;  // from the cell's centre
  vec3 gradient;      // at the projected sample, in quantized values per unit
};

// Displaces the sample by Newton steps, each with the gradient at the last point. Returns false if the
// sample is dropped.
bool project_sample(Trilinear f, vec3 size, float quantized_isovalue, out Projected sample_) {
  vec4 at = value_and_gradient(f, vec3(0.5));
  sample_ = Projected(vec3(0.0), at.yzw / size);
  if (u_projects == 0) return true;
  vec3 displacement;
  if (!displace(at.x, sample_.gradient, size, quantized_isovalue, displacement)) return false;
  for (int i = 0; i < 2; ++i) {
    at = value_and_gradient(f, displacement / size + 0.5);
    displacement = displace_further(at, size, quantized_isovalue, displacement);
  }
  at = value_and_gradient(f, displacement / size + 0.5);
  sample_ = Projected(displacement, at.yzw / size);
  return true;
}

#if KIND == KIND_ELLIPSE
// Places the splat on the tangent plane of the projected sample, which has this normal (as row vector,
// and in the camera's frame). bent: curvature of the surface, as in v_distance.
void place_ellipse(vec3 centre, vec3 size, vec3 displacement, vec3 normal, vec3 in_view, float bent) {
  vec3 half_box = (0.5 + ELLIPSE_MARGIN_CELLS) * u_splat_scale * size;
  vec3 position = centre + displacement;
  float z = dot(position, u_forward.xyz);
  if (z < u_near_plane || is_clipped(centre, half_box)) {
    drop();
    return;
  }
  // One px to the right, or up, moves the ray's intersection with the tangent plane by `slope` px along
  // the view.
  vec3 to_hit = ray_to(position, z);
  float facing = dot(normal, to_hit);
  facing = facing < 0.0 ? min(facing, -ELLIPSE_MIN_FACING) : max(facing, ELLIPSE_MIN_FACING);
  vec2 slope = -in_view.xy / facing;
  float px = w_at(z) * u_per_focal_px;  // size of a pixel there
  // Bounds the part of the tangent plane inside of the cell's box. For any c, this part extends no
  // further along r than the box extends along r - c n. c is smaller the more curved the surface
  // is, according to the mixed second derivatives.
  vec2 aside = aside_of(position, z);
  vec3 right = u_right.xyz - u_forward.xyz * aside.x, up = u_up.xyz - u_forward.xyz * aside.y;
  vec2 edge = in_view.xy + in_view.z * aside;  // the normal along right and up
  float flatness = clamp(0.95 - max(bent, 0.0), 0.0, 1.0);
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
  float middle = dot(centre, u_forward.xyz), reach = dot(abs(u_forward.xyz), half_box);
  place_splat(v_centre_px + 0.5 * (low_px + high_px), 0.5 * (high_px - low_px) + 0.5, middle - reach,
              middle + reach);
}
#else
// Places the splat on a box, for fragments that search all of it. centre, size: those of the box.
void place_exact(vec3 centre, vec3 size, float span, bool is_plane) {
  float z = dot(centre, u_forward.xyz);
  if (z + dot(abs(u_forward.xyz), 0.5 * size) < u_near_plane) {
    drop();
    return;
  }
  v_span = max(span, 1e-6);
  v_a /= v_span;
  v_b /= v_span;
  if (is_plane) v_span = -v_span;
#ifdef PULLED
  v_centre = vec4(centre, z);
#else
  v_centre = vec4(centre, max(z, u_near_plane));
  v_centre_px = to_px(centre, v_centre.w);
#endif
  place_box(centre, 0.5 * u_splat_scale * size, 0.02);
}
#endif

void main() {
  clear_outputs();
  Cell cell;
  vec3 size, centre;
  if (!find_cell(cell, size, centre)) {
    drop();
    return;
  }
  bool is_inside;
  float quantized_isovalue = drawn_isovalue(cell, is_inside);
  Trilinear f = trilinear(cell.lower, cell.upper);
  Projected projected;
  if (!project_sample(f, size, quantized_isovalue, projected)) {
    drop();
    return;
  }
  vec3 displacement = projected.displacement, gradient = projected.gradient;
  vec3 in_view = row_to_view(gradient);  // the gradient, and then the normal
  float steepness = length(in_view);
  float per_steepness = 1.0 / steepness;
  in_view = steepness > 0.0 ? in_view * per_steepness : vec3(0.0, 0.0, 1.0);
  vec3 normal = steepness > 0.0 ? gradient * per_steepness : -u_forward.xyz;
#ifdef FIELD
  Trilinear field = trilinear_field(fetch_field(sample_index()));
  vec3 cell_centre = centre, cell_extent = size;
#elif KIND == KIND_ELLIPSE
  v_scalar = scalar_of(f, displacement / size + 0.5, steepness);
#else
  v_scalar = scalar_of(f, displacement / size + 0.5, 0.0);  // each fragment computes its own gradient
#endif
  bool thin = !is_inside && is_coarse(), is_plane = thin || u_projects == 0;
  if (is_plane) {
    // The trilinear function has no surface here, or projection is disabled: draws a plane through the
    // middle of a box. The box stays inside of the cell, since the occlusion query tests only the cell.
    SKIPPABLE_IF(thin) {
      bound_thin(cell, centre, size, in_view, normal);
#ifdef FIELD
      vec3 extent = size / cell_extent;
      field = field_in_box(field, (centre - cell_centre) / cell_extent + 0.5 - 0.5 * extent, extent);
#endif
    }
    displacement = vec3(0.0);
    vec3 across = size * normal * (steepness > 0.0 ? steepness : 1.0);
    f = Trilinear(vec4(quantized_isovalue - 0.5 * (across.x + across.y + across.z), across.xy, 0.0),
                  vec4(across.z, 0.0, 0.0, 0.0));
  }
  f.a.x -= quantized_isovalue;
#if KIND != KIND_ELLIPSE
  // Fragments search the box around the surface, in its coordinates.
  float span = cell.interval.y - cell.interval.x;
  vec3 low = vec3(0.0), high = vec3(1.0);
  if (is_inside && u_projects != 0) {
    bound_surface(find_crossings(cell.lower - quantized_isovalue, cell.upper - quantized_isovalue), low, high);
  }
  float margin = span > 511.0 ? ROUNDED_MARGIN_CELLS : EXACT_MARGIN_CELLS;
  low -= margin;
  high += margin;
  f = in_box(f, low, high - low);
#ifdef FIELD
  field = field_in_box(field, low, high - low);
#endif
  centre += (0.5 * (low + high) - 0.5) * size;
  size *= high - low;
#endif
  v_size = size;
  v_a = f.a;
  v_b = f.b;
#ifdef FIELD
  v_field_a = field.a;
  v_field_b = field.b;
#ifdef CATEGORIES
  v_field_middle = field_middle;
#endif
#ifdef LINES
  v_least_sine = least_sine_of(cell.interval);
#endif
#endif
#if KIND == KIND_ELLIPSE
  float mixed = abs(f.a.w) + abs(f.b.y) + abs(f.b.z) + abs(f.b.w);
  float bent = is_plane ? -1.0 : mixed / max(length(gradient * size), 1e-9);
  place_ellipse(centre, size, displacement, normal, in_view, bent);
#else
  place_exact(centre, size, span, is_plane);
#endif
}
