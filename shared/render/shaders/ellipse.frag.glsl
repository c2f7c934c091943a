// Draws a part of the tangent plane. Each fragment starts on this plane, and moves along its ray to
// the cell's trilinear surface by two Newton steps. Depth and normal are those of the surface;
// fragments without a surface are discarded.
flat in vec2 v_centre_px;
flat in vec4 v_distance;
flat in vec3 v_place, v_place_x, v_place_y;
flat in vec3 v_along;
flat in vec3 v_size;
flat in vec4 v_a, v_b;
#ifdef FIELD
flat in vec4 v_field_a, v_field_b;
#ifdef CATEGORIES
flat in vec3 v_field_middle;
#endif
#ifdef LINES
flat in float v_least_sine;
#endif
#else
flat in float v_scalar;
#endif

uniform uint u_isosurface;

layout(location = 0) out uvec4 o_pixel;

void main() {
  vec2 d = gl_FragCoord.xy - v_centre_px;
  vec3 across = d.x * v_place_x + d.y * v_place_y;
#ifdef ORTHOGRAPHIC
  vec3 p = v_place + across, along = v_along;
#else
  vec3 p = v_place + across, along = v_along + across / v_distance.x;
#endif
  vec2 between = ray_in_cell(p, along, 0.5 * u_splat_scale - 0.5 + ELLIPSE_MARGIN_CELLS);
#ifdef CLIPPED
  between = clip_ray(pixel_ray(vec4(0.0, 0.0, 0.0, v_distance.x)), vec3(0.0), between);
#endif
  if (!(between.x <= between.y)) discard;
  Trilinear f = Trilinear(v_a, v_b);
  vec4 k = cubic_along(f, p, along);
  float t = clamp(dot(v_distance.yz, d), between.x, between.y);
  for (int i = 0; i < 2; ++i) {
    float slope = (3.0 * k.x * t + 2.0 * k.y) * t + k.z;
    t = clamp(t - cubic(k, t) / slope, between.x, between.y);
  }
  vec4 at = value_and_gradient(f, p + t * along);
  bool found = abs(at.x) <= ELLIPSE_TOLERANCE_CELLS * length(at.yzw);
  bool crossed = (cubic(k, between.x) > 0.0) != (cubic(k, between.y) > 0.0);
  if (!found && !crossed && v_distance.w < 1.0) discard;
  // If the two steps fail, searches like the exact kind, provided that the ends of the ray are on
  // both sides of the surface, or that the surface is so curved that the ray may cross it twice.
  SKIPPABLE_IF(!found) {
    vec4 from = cubic_along(f, p + between.x * along, along);
    t = first_root(from, between.y - between.x);
    if (t < 0.0) discard;
    t += between.x;
    at = value_and_gradient(f, p + t * along);
  }
  gl_FragDepth = window_depth(v_distance.x + t);
  int side = v_distance.w < 0.0 ? SIDE_UNKNOWN : cubic(k, between.x) > 0.0 ? SIDE_FALLING : SIDE_RISING;
#ifdef LINES
  Trilinear field = Trilinear(v_field_a, v_field_b);
  vec3 rise = value_and_gradient(field, p + t * along).yzw;
  vec2 change = change_per_px(rise, at.yzw, along, v_place_x, v_place_y, v_least_sine);
  float scalar = scalar_with_lines(field, p + t * along, change);
#elif defined(CATEGORIES)
  float scalar = category_scalar(Trilinear(v_field_a, v_field_b), p + t * along, v_field_middle);
#elif defined(FIELD)
  float scalar = field_scalar(Trilinear(v_field_a, v_field_b), p + t * along);
#else
  float scalar = v_scalar;
#endif
  o_pixel = encode_surface(row_to_view(at.yzw / v_size), scalar, u_isosurface, side);
}
