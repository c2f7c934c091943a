// The share of a cell in the smooth gradient at a point. Implements the same formulas as
// shared/core/sampling/smooth_gradients.h; a test compares the values.

// xyz: the sum, over the cell's corners, of hat function times the gradient of the trilinear function
// at the corner, in quantized values per cell. w: the sum of the hat functions. The hat function of a
// corner is 1 there, and 0 from the neighbouring lattice points on.
// low, high: hat functions along each axis, of the low and of the high side of the cell.
vec4 corner_gradients(vec4 lower, vec4 upper, vec3 low, vec3 high) {
  vec3 sum = low + high;
  // The gradient's x at a corner is the difference along the cell's edge there: the sum over the eight
  // corners needs four differences, weighted along y and z.
  vec4 face = low.z * lower + high.z * upper;  // corners weighted along z
  vec4 rise = upper - lower;
  vec2 along_x = vec2(low.x, high.x), along_y = vec2(low.y, high.y);
  return vec4(sum.x * dot(along_y, face.yw - face.xz), sum.y * dot(along_x, face.zw - face.xy),
              sum.z * (low.y * dot(along_x, rise.xy) + high.y * dot(along_x, rise.zw)),
              sum.x * sum.y * sum.z);
}

// Hat functions of the low and the high side of a cell at p (0 to 1 in the cell).
vec3 low_hats(vec3 p) { return max(1.0 - abs(p), 0.0); }
vec3 high_hats(vec3 p) { return max(1.0 - abs(p - 1.0), 0.0); }
