// A square with one depth and normal, as large as the tangent plane's part inside of the cell, and
// cut to the band that this part covers: where a surface is seen from its edge, whole squares would
// reach beyond the outline.
flat out uvec4 v_pixel;
flat out vec4 v_band;  // xy: centre in px; zw: across the band, in half its widths per px

void main() {
  v_pixel = uvec4(0u);
  v_band = vec4(0.0);
  Cell cell = unpack_sample(fetch_sample());
  if (!is_active(cell.interval, u_isocode) || !is_drawn(cell.low)) {
    drop();
    return;
  }
  vec3 size = u_spacing.xyz * u_block.w;
  vec3 centre = u_block.xyz + (cell.low + 0.5) * size;
  float isocode = reachable(cell, u_isocode);
  Trilinear f = trilinear(cell.lower, cell.upper);
  vec4 at = value_and_gradient_at_centre(cell);
  vec3 gradient = at.yzw / size, displacement = vec3(0.0);
  if (u_switches.y != 0) {
    if (!displace(at.x, gradient, size, isocode, displacement)) {
      drop();
      return;
    }
    at = value_and_gradient(f, displacement / size + 0.5);
    gradient = at.yzw / size;
    displacement =
        clamp(displacement + newton_step(at.x, gradient, isocode), -0.5 * size, 0.5 * size);
  }
  vec3 position = centre + displacement;
  float z = dot(position, u_forward.xyz);
  if (z < u_depth.z || is_clipped(position)) {
    drop();
    return;
  }
  float steepness = length(gradient);
  vec3 normal = steepness > 0.0 ? gradient / steepness : -u_forward.xyz;
  v_pixel = encode_surface(to_view(normal), scalar_of(f, displacement / size + 0.5, steepness),
                           u_isosurface, 1.0);

  // Where the tangent plane cuts off a corner of the cell, its part inside is in a smaller box at
  // that corner; what is thin is in a smaller box about the sample.
  vec3 half_box = 0.5 * u_lens.w * size, middle = -displacement;
  float footprint = thin_footprint(cell, isocode);
  if (footprint < 1.0) {
    half_box *= footprint;
    normal = towards_eye(normal, position);
    middle = displacement = vec3(0.0);
  }
  float offset = dot(normal, displacement);
  float room = max(dot(abs(normal), half_box) - QUAD_CORNER * abs(offset), 0.0);
  vec3 part = min(half_box, 0.5 * room / (abs(normal) + 1e-6));
  middle += sign(offset) * sign(normal) * (half_box - part);

  // For any c, no point of a plane's part inside of a box is further along r than the box is along
  // r - c n.
  vec3 to_hit = position / z;
  vec3 right = u_right.xyz - u_forward.xyz * dot(to_hit, u_right.xyz);
  vec3 up = u_up.xyz - u_forward.xyz * dot(to_hit, u_up.xyz);
  vec2 edge = vec2(dot(normal, right), dot(normal, up));
  vec3 n = QUAD_FLATNESS * normal;
  vec3 along_right = right - edge.x * n, along_up = up - edge.y * n;
  vec3 along_edge = edge.x * right + edge.y * up - dot(edge, edge) * n;
  float per_px = u_lens.x / z;
  vec2 half_px = per_px * vec2(dot(abs(along_right), part), dot(abs(along_up), part));
  vec2 centre_px =
      to_px(position, z) + per_px * vec2(dot(along_right, middle), dot(along_up, middle));
  float band = per_px * dot(abs(along_edge), part) + QUAD_LEAST_PX * length(edge);
  v_band = vec4(centre_px, edge / max(band, 1e-6));
  // Of overlapping squares the nearest is seen, which brings the surface forward: put it back.
  float back = z + QUAD_SETBACK * dot(abs(u_forward.xyz), size);
  place_splat(centre_px, half_px + QUAD_MARGIN_PX, back);
}
