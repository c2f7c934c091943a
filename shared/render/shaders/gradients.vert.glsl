// Splats that add a cell's gradients to the smooth gradients of the surface around it: each covers
// the cell's box and one cell more on every side, where the hat functions of its corners are not 0.
// Cells that the isosurface does not cross contribute as well, since their voxels belong to the
// central differences.
uniform float u_gradient_weight;
uniform float u_finest_side_px;  // side of the finest cells, at distance 1
uniform vec2 u_smooth_px;        // x: side up to which cells keep their exact normals; y: 1 / (side from
                                 // which on they are smooth - x)
flat out vec3 v_low;            // the cell's low corner
flat out vec4 v_lower, v_upper; // its values, weighted
flat out float v_fade;          // 0 where cells are too small for smooth normals, up to 1

void main() {
  Cell cell = unpack_sample(fetch_sample());
  vec3 size = cell_size();
  v_low = block_corner() + cell.low * size;
  vec3 centre = v_low + 0.5 * size, half_box = SMOOTH_REACH_CELLS * size;
  float z = dot(centre, u_forward.xyz);
  float side_px = u_finest_side_px / w_at(max(z, u_near_plane));
  v_fade = clamp((side_px - u_smooth_px.x) * u_smooth_px.y, 0.0, 1.0);
  // Differences from the least value are exact; large values would reduce the precision.
  float weight = u_gradient_weight * v_fade;
  v_lower = weight * (cell.lower - cell.interval.x);
  v_upper = weight * (cell.upper - cell.interval.x);
  if (v_fade <= 0.0 || z + dot(abs(u_forward.xyz), half_box) < u_near_plane) {
    drop();
    return;
  }
  place_box(centre, half_box, 0.51);
}
