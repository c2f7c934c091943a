// The first intersection of the pixel's ray with the cell's trilinear isosurface.
flat in vec4 v_centre;
#ifndef PULLED
flat in vec2 v_centre_px;
#endif
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
flat in float v_span;           // negative: the ray crosses no surface of the trilinear function

uniform uint u_isosurface;
uniform vec3 u_scalar;

#ifdef LIT
layout(location = 0) out vec4 o_colour;
#else
layout(location = 0) out uvec4 o_pixel;
#endif

void main() {
#ifdef PULLED
  Ray ray = pixel_ray(v_centre);
#else
  Ray ray = pixel_ray(v_centre, v_centre_px);
#endif
  vec3 origin = ray.origin / v_size + 0.5, direction = ray.direction / v_size;
  Trilinear f = Trilinear(v_a, v_b);
  vec2 between = ray_in_cell(origin, direction, 0.0);
  between.x = max(between.x, u_near_plane - v_centre.w);
#ifdef CLIPPED
  between = clip_ray(ray, v_centre.xyz, between);
#endif
  float length_ = between.y - between.x, t = -1.0;
  vec4 k = cubic_along(f, origin + between.x * direction, direction);
  SKIPPABLE_IF(length_ >= 0.0 && may_cross(k, length_)) t = first_root(k, length_);
  if (t < 0.0) discard;
  t += between.x;
  vec3 p = (ray.origin + t * ray.direction) / v_size + 0.5;
  vec3 in_cell = value_and_gradient(f, p).yzw, gradient = row_to_view(in_cell / v_size);
  float steepness = length(gradient);
  vec3 normal = steepness > 0.0 ? gradient / steepness : vec3(0.0, 0.0, 1.0);
  gl_FragDepth = window_depth(v_centre.w + t);
#ifdef LINES
  Trilinear field = Trilinear(v_field_a, v_field_b);
  vec3 per_px = w_at(v_centre.w + t) * u_per_focal_px / v_size;
  vec2 rise = change_per_px(value_and_gradient(field, p).yzw, in_cell, direction, per_px * u_step_right.xyz,
                            per_px * u_step_up.xyz, v_least_sine);
  float scalar = scalar_with_lines(field, p, rise);
#elif defined(CATEGORIES)
  float scalar = category_scalar(Trilinear(v_field_a, v_field_b), p, v_field_middle);
#elif defined(FIELD)
  float scalar = field_scalar(Trilinear(v_field_a, v_field_b), p);
#else
  float scalar = v_scalar + u_scalar.y * steepness * abs(v_span);
#endif
#ifdef LIT
  vec3 base = base_colour(u_isosurface, scalar, v_centre.w + t);
  o_colour = apply_gamma(vec4(lit(normal, eye_from(gl_FragCoord.xy), base), 1.0));
#else
  int side = v_span < 0.0 ? SIDE_UNKNOWN : k.w > 0.0 ? SIDE_FALLING : SIDE_RISING;
  o_pixel = encode_surface(normal, scalar, u_isosurface, side);
#endif
}
