// A square with one depth and normal, around the part of the tangent plane inside of the cell. It is
// cut to the strip of the image that this part covers: whole squares would reach beyond the outline
// where a surface is seen edge-on.
#ifdef LIT
flat out uvec4 v_square;  // bits of the strip and the colour: software renderers pay for each output
#else
flat out uvec4 v_pixel;
flat out vec3 v_band;
#endif

// Whether a corner is far beyond the tangent plane, but not beyond the surface. The cell then contains
// a second sheet of the surface, or one so curved that a part of a plane would leave a hole.
// offset: distance of the plane from the cell's centre, along the normal.
bool is_more_than_a_plane(Cell cell, float quantized_isovalue, vec3 normal, vec3 size, float offset) {
  vec3 rise = 0.5 * normal * size;
  vec4 beyond = vec4(-rise.x - rise.y, rise.x - rise.y, rise.y - rise.x, rise.x + rise.y) - offset;
  vec4 agreement = min((beyond - rise.z) * sign(cell.lower - quantized_isovalue),
                       (beyond + rise.z) * sign(cell.upper - quantized_isovalue));
  float least = min(min(agreement.x, agreement.y), min(agreement.z, agreement.w));
  return least < -QUAD_BEYOND * (abs(rise.x) + abs(rise.y) + abs(rise.z));
}

void draw_square(Cell cell, vec3 size, vec3 centre) {
  float quantized_isovalue = reachable(cell, u_quantized_isovalue);
  Trilinear f = trilinear(cell.lower, cell.upper);
  vec4 at = value_and_gradient_at_centre(cell);
  vec3 gradient = at.yzw / size, displacement = vec3(0.0);
  if (u_switches.y != 0) {
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
  if (z < u_depth.z || is_clipped(position, vec3(0.0))) {
    drop();
    return;
  }
  vec3 in_view = row_to_view(gradient);  // the gradient, and then the normal
  float steepness = length(in_view);
  float per_steepness = 1.0 / steepness;
  in_view = steepness > 0.0 ? in_view * per_steepness : vec3(0.0, 0.0, 1.0);
  vec3 normal = steepness > 0.0 ? gradient * per_steepness : -u_forward.xyz;
  float scalar = scalar_of(f, displacement / size + 0.5, steepness);
#ifdef LIT
  vec3 base = base_colour(u_isosurface, scalar, z);
  vec3 light = lit(in_view, normalize(-to_view(position)), base);
  vec3 colour = apply_gamma(vec4(light, 1.0)).rgb;
#else
  v_pixel = encode_surface(in_view, scalar, u_isosurface, 1.0);
#endif

  // If the tangent plane cuts off a corner of the cell, its part inside of the cell lies in a smaller
  // box at that corner. Thin structures lie in a smaller box around the sample.
  vec3 half_box = 0.5 * u_lens.w * size, middle = -displacement;
  float footprint = thin_footprint(cell, quantized_isovalue);
  if (footprint < 1.0) {
    half_box *= footprint;
    in_view = towards_eye(in_view, position);
    normal = row_from_view(in_view);
    middle = displacement = vec3(0.0);
  }
  float offset = dot(normal, displacement);
  float room = max(dot(abs(normal), half_box) - QUAD_CORNER * abs(offset), 0.0);
  vec3 part = min(half_box, 0.5 * room / (abs(normal) + 1e-6));
  middle += sign(offset) * sign(normal) * (half_box - part);

  // The nearest of overlapping squares is visible, which moves the surface towards the eye: move the
  // square back.
  float flatness = QUAD_FLATNESS;
  vec3 along_view = u_forward.xyz + flatness * in_view.z * normal;
  float back = z + dot(along_view, middle) + QUAD_SETBACK * dot(abs(along_view), part);
  // If one plane cannot represent the surface, the square covers the whole cell.
  if (footprint == 1.0 && u_switches.y != 0 &&
      is_more_than_a_plane(cell, quantized_isovalue, normal, size, offset)) {
    part = half_box;
    middle = -displacement;
    flatness = 0.0;
  }

  // For any c, the part of a plane inside of a box extends no further along r than the box along
  // r - c n.
  vec3 to_hit = position / z;
  vec2 aside = vec2(dot(to_hit, u_right.xyz), dot(to_hit, u_up.xyz));
  vec3 right = u_right.xyz - u_forward.xyz * aside.x, up = u_up.xyz - u_forward.xyz * aside.y;
  vec2 edge = in_view.xy + in_view.z * aside;  // the normal along right and up
  vec3 n = flatness * normal;
  vec3 along_right = right - edge.x * n, along_up = up - edge.y * n;
  vec3 along_edge = edge.x * right + edge.y * up - dot(edge, edge) * n;
  float per_px = u_lens.x / z;
  vec2 half_px = per_px * vec2(dot(abs(along_right), part), dot(abs(along_up), part));
  vec2 centre_px =
      to_px(position, z) + per_px * vec2(dot(along_right, middle), dot(along_up, middle));
  float half_band = per_px * dot(abs(along_edge), part) + QUAD_MIN_PX * length(edge);
  vec2 across = edge / max(half_band, 1e-6);
  vec3 band = vec3(across, dot(across, centre_px));  // in half widths of the strip: per px across it; its centre
#ifdef LIT
  v_square = uvec4(floatBitsToUint(band), pack_colour(colour));
#else
  v_band = band;
#endif
  place_splat(centre_px, half_px + QUAD_MARGIN_PX, back, back);
}

void main() {
#ifdef LIT
  v_square = uvec4(0u);
#else
  v_pixel = uvec4(0u);
  v_band = vec3(0.0);
#endif
  drop();
  Cell cell;
  vec3 size, centre;
  if (find_cell(cell, size, centre)) draw_square(cell, size, centre);
}
