// A sample as an occluder: a piece of its tangent plane, enlarged to stand for the samples about it
// that are not drawn.
flat out vec4 v_plane;  // xy: the sample in px of the image; zw: distance per px across
flat out float v_distance;

void main() {
  v_plane = vec4(0.0);
  v_distance = 0.0;
  Cell cell;
  vec3 size, centre;
  if (!find_cell(cell, size, centre)) {
    drop();
    return;
  }
  vec4 at = value_and_gradient_at_centre(cell);
  vec3 gradient = at.yzw / size, displacement;
  displace(at.x, gradient, size, u_isocode, displacement);
  vec3 position = centre + displacement;
  float z = dot(position, u_forward.xyz);
  if (z < u_depth.z || is_clipped(position)) {
    drop();
    return;
  }
  float facing = dot(gradient, position) / z, least = OCCLUDER_LEAST_FACING * length(gradient);
  facing = facing < 0.0 ? min(facing, -least) : max(facing, least);
  vec2 slope = -vec2(dot(gradient, u_right.xyz), dot(gradient, u_up.xyz)) / facing;
  vec2 centre_px = to_px(position, z);
  v_plane = vec4(centre_px, z * u_lens.y * slope);
  v_distance = z;
  gl_Position = vec4(2.0 * centre_px / u_image.xy - 1.0, 0.0, 1.0);
  float cell_px = inversesqrt(3.0) * length(size) * u_lens.x / z;
  gl_PointSize = clamp(OCCLUDER_CELLS / float(OCCLUDER_PX) * cell_px, 1.0, u_lens.z);
}
