// Splats of the cells that a slice cuts.
flat out vec3 v_low, v_size;
flat out vec4 v_a, v_b;

void main() {
  Cell cell = unpack_sample(fetch_sample());
  v_size = cell_size();
  v_low = block_corner() + cell.low * v_size;
  Trilinear f = trilinear(cell.lower, cell.upper);
  v_a = f.a;
  v_b = f.b;
  vec3 centre = v_low + 0.5 * v_size, reach = (0.5 + CUT_MARGIN_CELLS) * v_size;
  // The distance of the plane from the cell's centre, and the bounds of the part of the cell that
  // the plane cuts. Along each axis, the bounds are the coordinates from which the plane can be
  // reached along the other axes.
  float away = u_slice.w - dot(u_slice.xyz, centre);
  vec3 steps = abs(u_slice.xyz) * reach, slope = max(abs(u_slice.xyz), 1e-6);
  float most = steps.x + steps.y + steps.z;
  vec3 middle = sign(u_slice.xyz) * away / slope, around = (most - steps) / slope + 1e-3 * reach;
  vec3 low = max(middle - around, -reach), high = min(middle + around, reach);
  if (abs(away) > most) drop();
  else place_box(centre + 0.5 * (low + high), 0.5 * (high - low), 0.02);
}
