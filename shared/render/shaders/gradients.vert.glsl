// Splats that add a cell's gradients to the smooth gradients of the surface around it: each covers the
// cell's box and one cell more on every side, where the hat functions of its corners are not 0. Cells
// that the isosurface does not cross contribute as well, since central differences would use their
// voxels.
// x: weight of the gradient; y: side of the finest cells in px at distance 1; z, w: side in px up to
// which cells keep their own normals, and 1 / the difference to that from which on they do not.
uniform vec4 u_support;
flat out vec3 v_low;            // the cell's low corner
flat out vec4 v_lower, v_upper; // its values, weighted
flat out float v_fade;          // 0 where cells are too small for smooth normals, up to 1

void main() {
  Cell cell = unpack_sample(fetch_sample());
  vec3 size = u_cell.xyz * u_block.w;
  v_low = u_block.xyz + cell.low * size;
  vec3 centre = v_low + 0.5 * size, half_box = SMOOTH_REACH_CELLS * size;
  float z = dot(centre, u_forward.xyz);
  float side_px = u_support.y / w_at(max(z, u_depth.z));
  v_fade = clamp((side_px - u_support.z) * u_support.w, 0.0, 1.0);
  // Differences from the least value are exact; large values would leave less precision.
  float weight = u_support.x * v_fade;
  v_lower = weight * (cell.lower - cell.interval.x);
  v_upper = weight * (cell.upper - cell.interval.x);
  if (v_fade <= 0.0 || z + dot(abs(u_forward.xyz), half_box) < u_depth.z) {
    drop();
    return;
  }
  place_box(centre, half_box, 0.51);
}
