// Packed samples and the trilinear interpolant. Implements the same formulas as
// shared/core/sampling/packed_sample.h and trilinear.h; a test compares the values.

struct Cell {
  vec3 low;       // corner 0, in cells of the level, in the block
  vec4 lower;     // quantized values of corners 0 to 3 (z = 0) ...
  vec4 upper;     // ... and 4 to 7 (z = 1)
  vec2 interval;  // min, max
  uint word;      // the first word of the sample
};

// f = dot(a + z b, (1, x, y, xy)): the eight polynomial coefficients.
struct Trilinear {
  vec4 a;
  vec4 b;
};

Cell unpack_sample(uvec4 w) {
  Cell cell;
  cell.low = vec3(w.x & 63u, w.x >> 6 & 63u, w.x >> 12 & 63u);
  uint low = w.y & 0xffffu, high = w.y >> 16;
  uint span = high - low;
  uint shift = uint(span > 511u) + uint(span > 1023u) + uint(span > 2047u) + uint(span > 4095u) +
               uint(span > 8191u) + uint(span > 16383u) + uint(span > 32767u);
  float unit = float(1u << shift), base = float(low + (1u << shift >> 1));
  uvec4 low_bits = uvec4(w.z & 255u, w.z >> 8 & 255u, w.z >> 16 & 255u, w.z >> 24);
  uvec4 high_bits = uvec4(w.w & 255u, w.w >> 8 & 255u, w.w >> 16 & 255u, w.w >> 24);
  low_bits |= (uvec4(w.x >> 14, w.x >> 15, w.x >> 16, w.x >> 17) & 256u);
  high_bits |= (uvec4(w.x >> 18, w.x >> 19, w.x >> 20, w.x >> 21) & 256u);
  cell.lower = base + unit * vec4(low_bits);
  cell.upper = base + unit * vec4(high_bits);
  cell.interval = vec2(low, high);
  cell.word = w.x;
  return cell;
}

// The quantized isovalue, clamped to the range of the corners. It can lie outside of the range:
// corners are rounded where the interval is wide, and intervals of coarse cells are wider than the
// range of their corners.
float reachable(Cell cell, float quantized_isovalue) {
  vec4 low = min(cell.lower, cell.upper), high = max(cell.lower, cell.upper);
  return clamp(quantized_isovalue, min(min(low.x, low.y), min(low.z, low.w)),
               max(max(high.x, high.y), max(high.z, high.w)));
}

bool is_active(vec2 interval, float quantized_isovalue) {
  return interval.x <= quantized_isovalue && quantized_isovalue < interval.y;
}

Trilinear trilinear(vec4 lower, vec4 upper) {
  vec4 d = upper - lower;
  return Trilinear(vec4(lower.x, lower.y - lower.x, lower.z - lower.x,
                        lower.w - lower.z - lower.y + lower.x),
                   vec4(d.x, d.y - d.x, d.z - d.x, d.w - d.z - d.y + d.x));
}

// The same function, of a position in the box from `low` to `low + extent` (0 to 1 in the box).
Trilinear in_box(Trilinear f, vec3 low, vec3 extent) {
  Trilinear at_low = Trilinear(f.a + low.z * f.b, extent.z * f.b);
  vec4 scale = vec4(1.0, extent.xy, extent.x * extent.y);
  vec4 a = at_low.a, b = at_low.b;
  a.xy += low.y * a.zw;
  b.xy += low.y * b.zw;
  a.xz += low.x * a.yw;
  b.xz += low.x * b.yw;
  return Trilinear(scale * a, scale * b);
}

// x: value; yzw: gradient in quantized values per cell, at p in the cell (0 to 1).
vec4 value_and_gradient(Trilinear f, vec3 p) {
  vec4 c = f.a + p.z * f.b;
  float dx = c.y + p.y * c.w, dy = c.z + p.x * c.w;
  return vec4(c.x + p.x * c.y + p.y * dy, dx, dy,
              f.b.x + p.x * f.b.y + p.y * (f.b.z + p.x * f.b.w));
}

// The same at the cell's centre, directly from the corners.
vec4 value_and_gradient_at_centre(Cell cell) {
  vec4 sum = cell.lower + cell.upper, rise = cell.upper - cell.lower;
  return 0.25 * vec4(0.5 * (sum.x + sum.y + sum.z + sum.w), sum.y + sum.w - sum.x - sum.z,
                     sum.z + sum.w - sum.x - sum.y, rise.x + rise.y + rise.z + rise.w);
}

// The displacement of one Newton step (paper, equations 5 and 6). ascent: the gradient as a vector
// (ascent_of). It equals the gradient if the axes are perpendicular.
vec3 newton_step(float value, vec3 gradient, vec3 ascent, float quantized_isovalue) {
  float squared = dot(gradient, ascent);
  return squared > 0.0 ? ascent * ((quantized_isovalue - value) / squared) : vec3(0.0);
}
