// Packed samples and the trilinear interpolant: repeats shared/sampling/packed_sample.h and
// trilinear.h, and is tested against them by value.

struct Cell {
  vec3 low;       // corner 0, in cells of the level, in the block
  float size;     // 1, or 0.5 for an octant of a subdivided cell
  vec4 lower;     // codes of corners 0 to 3 (z = 0) ...
  vec4 upper;     // ... and 4 to 7 (z = 1)
  vec2 interval;  // min, max
};

// f = dot(a + z b, (1, x, y, xy)): the eight polynomial coefficients.
struct Trilinear {
  vec4 a;
  vec4 b;
};

Cell unpack_sample(uvec4 w) {
  Cell cell;
  cell.low = vec3(w.x & 63u, w.x >> 6 & 63u, w.x >> 12 & 63u);
  cell.size = 1.0;
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
  return cell;
}

// An octant is a cell of half the size, whose corners are interpolated.
Cell octant_of(Cell cell, uvec4 w) {
  if ((w.x >> 21 & 1u) == 0u) return cell;
  bvec3 far = bvec3(uvec3(w.x >> 18, w.x >> 19, w.x >> 20) & 1u);
  vec4 x0 = vec4(cell.lower.xz, cell.upper.xz), x1 = vec4(cell.lower.yw, cell.upper.yw);
  vec4 middle = 0.5 * (x0 + x1);
  if (far.x) x0 = middle; else x1 = middle;
  vec4 y0 = vec4(x0.x, x1.x, x0.z, x1.z), y1 = vec4(x0.y, x1.y, x0.w, x1.w);  // (x, z) pairs
  middle = 0.5 * (y0 + y1);
  if (far.y) y0 = middle; else y1 = middle;
  vec4 z0 = vec4(y0.xy, y1.xy), z1 = vec4(y0.zw, y1.zw);
  middle = 0.5 * (z0 + z1);
  if (far.z) z0 = middle; else z1 = middle;
  cell.low += vec3(far) * 0.5;
  cell.size = 0.5;
  cell.lower = z0;
  cell.upper = z1;
  vec4 low = min(z0, z1), high = max(z0, z1);
  cell.interval = vec2(min(min(low.x, low.y), min(low.z, low.w)),
                       max(max(high.x, high.y), max(high.z, high.w)));
  return cell;
}

bool is_active(vec2 interval, float isocode) {
  return interval.x <= isocode && isocode < interval.y;
}

Trilinear trilinear(vec4 lower, vec4 upper) {
  vec4 d = upper - lower;
  return Trilinear(vec4(lower.x, lower.y - lower.x, lower.z - lower.x,
                        lower.w - lower.z - lower.y + lower.x),
                   vec4(d.x, d.y - d.x, d.z - d.x, d.w - d.z - d.y + d.x));
}

// x: value; yzw: gradient in codes per cell, at p in the cell (0 to 1).
vec4 value_and_gradient(Trilinear f, vec3 p) {
  vec4 c = f.a + p.z * f.b;
  float dx = c.y + p.y * c.w, dy = c.z + p.x * c.w;
  return vec4(c.x + p.x * c.y + p.y * dy, dx, dy,
              f.b.x + p.x * f.b.y + p.y * (f.b.z + p.x * f.b.w));
}

// The displacement of one Newton step (paper, equations 5 and 6) in the units of `gradient`'s space.
vec3 newton_step(float value, vec3 gradient, float isocode) {
  float squared = dot(gradient, gradient);
  return squared > 0.0 ? gradient * ((isocode - value) / squared) : vec3(0.0);
}
