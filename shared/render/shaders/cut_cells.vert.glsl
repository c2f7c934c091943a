// Draws a splat for each cell at a face of the clipped volume. The fragments compute the volume's values on
// this face.
uniform float u_margin_px;  // px around the cell that are covered as well
flat out vec3 v_low, v_size;
flat out vec4 v_a, v_b;
flat out float v_isovalue;  // of the surface that is drawn in the cell

void main() {
  v_low = vec3(0.0);
  v_size = vec3(1.0);
  v_a = v_b = vec4(0.0);
  v_isovalue = 0.0;
  Cell cell;
  vec3 size, centre;
  if (!find_cell(cell, size, centre)) {
    drop();
    return;
  }
  bool is_inside;
  v_isovalue = drawn_isovalue(cell, is_inside);
  Trilinear f = trilinear(cell.lower, cell.upper);
  v_a = f.a;
  v_b = f.b;
  v_low = centre - 0.5 * size;
  v_size = size;
  place_box(centre, (0.5 + CUT_MARGIN_CELLS) * size, 0.02 + 2.0 * u_margin_px);
}
