// The value of a cell's trilinear function where the pixel's ray meets the slice.
flat in vec3 v_low, v_size;
flat in vec4 v_a, v_b;

uniform vec2 u_slice_scalar;  // position in the colour map: slope and intercept, of the quantized value
layout(location = 0) out uvec4 o_pixel;

void main() {
  float z = slice_distance(gl_FragCoord.xy);
  vec3 p = point_at(gl_FragCoord.xy, z), q = (p - v_low) / v_size;
  if (any(greaterThan(abs(q - 0.5), vec3(0.5 + CUT_MARGIN_CELLS)))) discard;
  if (!is_in_shown_part(p, z)) discard;
  float value = value_and_gradient(Trilinear(v_a, v_b), clamp(q, 0.0, 1.0)).x;
  float scalar = value * u_slice_scalar.x + u_slice_scalar.y;
  o_pixel = encode_surface(vec3(0.0, 0.0, 1.0), scalar, uint(SLICE_VALUES), SIDE_UNKNOWN);
  gl_FragDepth = window_depth(z) - u_slice_nearer;
}
