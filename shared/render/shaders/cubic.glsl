// Intersection of a ray with a cell's trilinear surface, in cell units. Implements the same formulas
// as shared/core/sampling/exact_projection.cpp; a test compares the values.

// The interval of the ray inside of the cell, enlarged by `margin`; empty (x > y) if it misses.
vec2 ray_in_cell(vec3 origin, vec3 direction, float margin) {
  direction += vec3(equal(direction, vec3(0.0))) * 1e-9;
  vec3 per_place = 1.0 / direction;
  vec3 one = (-margin - origin) * per_place, other = (1.0 + margin - origin) * per_place;
  vec3 enter = min(one, other), leave = max(one, other);
  return vec2(max(max(enter.x, enter.y), enter.z), min(min(leave.x, leave.y), leave.z));
}

// Coefficients of the cubic f(o + t r), t^3 first (paper, equations 2 and 3).
vec4 cubic_along(Trilinear f, vec3 o, vec3 r) {
  float c1 = f.a.y, c2 = f.a.z, c3 = f.a.w, c4 = f.b.x, c5 = f.b.y, c6 = f.b.z, c7 = f.b.w;
  float xy = r.x * r.y, xz = r.x * r.z, yz = r.y * r.z;
  vec4 at = value_and_gradient(f, o);
  return vec4(c7 * xy * r.z,
              c3 * xy + c5 * xz + c6 * yz + c7 * (o.x * yz + o.y * xz + o.z * xy),
              dot(at.yzw, r), at.x);
}

float cubic(vec4 k, float t) { return ((k.x * t + k.y) * t + k.z) * t + k.w; }

// Whether the cubic may have a root in [0, end]. It has none if its control values (Bernstein's
// form), which bound it, all have the same sign. Zero counts as below.
bool may_cross(vec4 k, float end) {
  vec3 power = vec3(k.z, k.y * end, k.x * end * end) * end;
  vec4 control = k.w + vec4(0.0, power.x / 3.0, (2.0 * power.x + power.y) / 3.0, power.x + power.y + power.z);
  float least = min(min(control.x, control.y), min(control.z, control.w));
  float most = max(max(control.x, control.y), max(control.z, control.w));
  return least <= 0.0 && most > 0.0;
}

// The smallest root in [0, end]; negative if there is none. Between its extrema the cubic is
// monotonic: the first part whose ends have different signs contains the root. Zero counts as below,
// as in is_active.
float first_root(vec4 k, float end) {
  float a = 3.0 * k.x, b = k.y, c = k.z;  // a t^2 + 2 b t + c
  float discriminant = b * b - a * c;
  float e0 = end, e1 = end;
  if (discriminant > 0.0) {
    float q = -(b + (b < 0.0 ? -1.0 : 1.0) * sqrt(discriminant));
    float r0 = a != 0.0 ? q / a : end, r1 = q != 0.0 ? c / q : end;
    e0 = clamp(min(r0, r1), 0.0, end);
    e1 = clamp(max(r0, r1), 0.0, end);
  }
  float low = 0.0, high = end, f_low = k.w, f_high;
  float f0 = cubic(k, e0), f1 = cubic(k, e1);
  bool above = f_low > 0.0, found = true;
  if ((f0 > 0.0) != above) {
    high = e0;
    f_high = f0;
  } else if ((f1 > 0.0) != above) {
    low = e0;
    f_low = f0;
    high = e1;
    f_high = f1;
  } else {
    low = e1;
    f_low = f1;
    f_high = cubic(k, end);
    found = (f_high > 0.0) != above;
  }
  // Newton steps from the secant, or bisection where they leave the bracket. Without a root no step runs:
  // software renderers skip a loop that no pixel of a group runs.
  float t = (low * f_high - high * f_low) / (f_high - f_low), f_t = found ? 1.0 : 0.0;
  for (int i = 0; i < 8 && abs(f_t) > ROOT_TOLERANCE; ++i) {
    f_t = cubic(k, t);
    if ((f_t > 0.0) == (f_low > 0.0)) low = t;
    else high = t;
    float next = t - f_t / ((3.0 * k.x * t + 2.0 * k.y) * t + k.z);
    // A root has been reached. Another step improves it, unless it starts beside an extremum.
    if (abs(f_t) <= ROOT_TOLERANCE && !(abs(next - t) < 0.02)) break;
    t = next >= low && next <= high ? next : 0.5 * (low + high);
  }
  return found ? t : -1.0;
}
