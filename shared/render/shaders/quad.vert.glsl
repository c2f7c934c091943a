// A square with one depth and normal. Its fragments cover the points at which the surface crosses
// the cell's edges. They lie inside of an octagon, which bounds these points along the axes and the
// diagonals of the image, and of a strip, which bounds them along the surface's normal in the
// image. A larger part of the square would reach beyond thin structures, and beyond the outline
// where a surface is seen edge-on.
#ifdef LIT
flat out uvec4 v_square;  // bits of the strip and the colour: software renderers pay for each output
#else
flat out uvec4 v_pixel;
flat out vec3 v_band;
#endif
#ifdef LINES
flat out vec3 v_line;  // the number of the contour line is x + dot(yz, px)
#ifdef LIT
flat out uint v_line_colour;
#endif
#endif
flat out vec4 v_low, v_high;  // limits of the octagon in px: of x, y, x + y, x - y

// The extent in px of the crossings in a box along a direction of the image, relative to the sample.
// along: px per unit. corner: that of the box, relative to the sample.
vec2 extent_px(Crossings crossings, vec3 along, vec3 corner, vec3 size) {
  vec2 px = extent(crossings, along * size) + dot(along, corner);
  float half_px = 0.5 * u_splat_scale * (px.y - px.x) + QUAD_MARGIN_PX;
  return 0.5 * (px.x + px.y) + vec2(-half_px, half_px);
}

void draw_square(Cell cell, vec3 size, vec3 centre) {
  bool is_inside;
  float quantized_isovalue = drawn_isovalue(cell, is_inside);
  Trilinear f = trilinear(cell.lower, cell.upper);
  vec4 at = value_and_gradient_at_centre(cell);
  vec3 gradient = at.yzw / size, displacement = vec3(0.0);
  if (u_projects != 0) {
    if (!displace(at.x, gradient, size, quantized_isovalue, displacement)) {
      drop();
      return;
    }
    at = value_and_gradient(f, displacement / size + 0.5);
    gradient = at.yzw / size;
    displacement = displace_further(at, size, quantized_isovalue, displacement);
  }
  vec3 position = centre + displacement;
  float z = dot(position, u_forward.xyz);
  if (z < u_near_plane || is_clipped(position, vec3(0.0))) {
    drop();
    return;
  }
  vec3 in_view = row_to_view(gradient);  // the gradient, and then the normal
  float steepness = length(in_view);
  float per_steepness = 1.0 / steepness;
  in_view = steepness > 0.0 ? in_view * per_steepness : vec3(0.0, 0.0, 1.0);
  vec3 normal = steepness > 0.0 ? gradient * per_steepness : -u_forward.xyz;
#ifdef LINES
  Trilinear field = trilinear_field(fetch_field(sample_index()));
  vec3 place = displacement / size + 0.5;
  vec4 field_value = value_and_gradient(field, place);
  vec2 line = line_number(field_value.x);
  float px = w_at(z) * u_per_focal_px, scalar = scalar_beside_lines(field, place, line.x);
  // The gradient of the surface at the same place, not that of the step before.
  vec3 surface_gradient = value_and_gradient(f, place).yzw / size;
  vec2 line_per_px = line.y * change_per_px(field_value.yzw / size, surface_gradient, ray_to(position, z),
                                            px * u_step_right.xyz, px * u_step_up.xyz,
                                            least_sine_of(cell.interval));
  bool has_lines = field.a.x < MISSING_VALUE && dot(line_per_px, line_per_px) < 1.0;
  v_line = has_lines ? vec3(line.x - floor(line.x + 0.5) - dot(line_per_px, to_px(position, z)), line_per_px) : vec3(0.5, 0.0, 0.0);
#elif defined(CATEGORIES)
  float scalar = category_scalar(trilinear_field(fetch_field(sample_index())), displacement / size + 0.5, vec3(0.5));
#elif defined(FIELD)
  float scalar = field_scalar(trilinear_field(fetch_field(sample_index())), displacement / size + 0.5);
#else
  float scalar = scalar_of(f, displacement / size + 0.5, steepness);
#endif
#ifdef LIT
  vec3 base = base_colour(u_isosurface, scalar, z);
  vec3 light = lit(in_view, to_eye_from(position), base);
  vec3 colour = apply_gamma(vec4(light, 1.0)).rgb;
#ifdef LINES
  vec3 line_base = base_colour(u_isosurface, scalar + float(LINE_TONE - 1) / 65535.0, z);
  v_line_colour = pack_colour(apply_gamma(vec4(lit(in_view, to_eye_from(position), line_base), 1.0)).rgb);
#endif
#else
  float facing = dot(in_view, to_eye_from(position));
  bool is_plane = !is_inside && is_coarse() || u_projects == 0;
  int side = is_plane || abs(facing) < QUAD_SIDE_FACING ? SIDE_UNKNOWN : facing < 0.0 ? SIDE_RISING : SIDE_FALLING;
  v_pixel = encode_surface(in_view, scalar, u_isosurface, side);
#endif

  // The values at the corners of the box whose crossings are covered, and the vector from the
  // sample to corner 0.
  vec4 lower = cell.lower - quantized_isovalue, upper = cell.upper - quantized_isovalue;
  vec3 corner = -0.5 * size - displacement;
  if (!is_inside || u_projects == 0) {
    // The trilinear function has no surface here, or projection is disabled: a plane through the sample,
    // or through the box of a thin structure.
    lower = vec4(dot(normal, corner));
    SKIPPABLE_IF(!is_inside && is_coarse()) {
      vec3 middle = centre;
      bound_thin(cell, middle, size, in_view, normal);
      corner = middle - 0.5 * size - position;
      lower = vec4(-0.5 * dot(normal, size));
    }
    vec3 rise = normal * size;
    lower += vec4(0.0, rise.xy, rise.x + rise.y);
    upper = lower + rise.z;
  }
  Crossings crossings = find_crossings(lower, upper);

  // In px to the right and up, for positions in the box.
  vec2 aside = aside_of(position, z);
  float per_px = u_focal_px / w_at(z);
  vec3 right = per_px * (u_right.xyz - u_forward.xyz * aside.x);
  vec3 up = per_px * (u_up.xyz - u_forward.xyz * aside.y);
  vec2 sample_px = to_px(position, z);
  vec2 x = extent_px(crossings, right, corner, size) + sample_px.x;
  vec2 y = extent_px(crossings, up, corner, size) + sample_px.y;
  vec2 rising = extent_px(crossings, right + up, corner, size) + sample_px.x + sample_px.y;
  vec2 falling = extent_px(crossings, right - up, corner, size) + sample_px.x - sample_px.y;
  v_low = vec4(x.x, y.x, rising.x, falling.x);
  v_high = vec4(x.y, y.y, rising.y, falling.y);

  vec2 edge = in_view.xy + in_view.z * aside;  // the normal along right and up
  vec2 strip = extent_px(crossings, edge.x * right + edge.y * up, corner, size) + dot(edge, sample_px);
  // In units of half the strip's width: one px across the strip; its centre.
  float per_strip = 2.0 / max(strip.y - strip.x, 1e-6);
  vec3 band = per_strip * vec3(edge, 0.5 * (strip.x + strip.y));

  // The nearest of overlapping squares is visible, which moves the surface towards the eye: move the
  // square back.
  vec2 depth = z + dot(u_forward.xyz, corner) + extent(crossings, u_forward.xyz * size);
  float back = mix(depth.x, depth.y, 0.5 + 0.5 * QUAD_SETBACK);

#ifdef LIT
  v_square = uvec4(floatBitsToUint(band), pack_colour(colour));
#else
  v_band = band;
#endif
  place_splat(0.5 * vec2(x.x + x.y, y.x + y.y), 0.5 * vec2(x.y - x.x, y.y - y.x), back, back);
}

void main() {
#ifdef LIT
  v_square = uvec4(0u);
#else
  v_pixel = uvec4(0u);
  v_band = vec3(0.0);
#endif
#ifdef LINES
  v_line = vec3(0.0);
#ifdef LIT
  v_line_colour = 0u;
#endif
#endif
  v_low = v_high = vec4(0.0);
  drop();
  Cell cell;
  vec3 size, centre;
  if (find_cell(cell, size, centre)) draw_square(cell, size, centre);
}
