// Draws the pattern of a slice. The slice's cells are drawn over it. Where cells are missing, lines
// show the plane, and the surfaces behind it are visible between the lines. The lines are fixed in
// the image.
uniform float u_line_px;  // width of a line
layout(location = 0) out uvec4 o_pixel;

void main() {
  vec2 px = gl_FragCoord.xy, at = px + u_tile_corner;
  float z = slice_distance(px);
  vec3 p = point_at(px, z), per_px = fwidth(p);
  if (!is_in_shown_part(p, z)) discard;
  // A line around the slice: along the faces of the volume that are not parallel to it.
  vec3 from_face = min(p - u_volume_low, u_volume_high - p);
  from_face += 1e9 * step(per_px, vec3(0.01 * max(per_px.x, max(per_px.y, per_px.z))));
  bool is_line = any(lessThan(from_face, 1.2 * u_line_px * per_px)) ||
                 mod(at.x + at.y, SLICE_PERIOD_PX * u_line_px) < 1.2 * u_line_px;
  if (!is_line) discard;
  o_pixel = encode_surface(vec3(0.0, 0.0, 1.0), 0.0, uint(SLICE_NO_DATA), SIDE_UNKNOWN);
  gl_FragDepth = window_depth(z) - u_slice_nearer;
}
