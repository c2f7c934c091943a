// Triangles of cells (triangles.vert.glsl), lit at their vertices (LIT) or as surface pixels.
uniform uint u_isosurface;
#ifdef FIELD
flat in vec4 v_field_a, v_field_b;
in vec3 v_place;
#endif
#ifdef LINES
flat in vec4 v_a, v_b;
flat in float v_least_sine;
#endif
#ifdef LIT
in vec3 v_colour;
layout(location = 0) out vec4 o_colour;
#else
in vec3 v_normal;
#ifndef FIELD
in float v_scalar;
#endif
layout(location = 0) out uvec4 o_pixel;
#endif

void main() {
#ifdef LINES
  vec3 place_x = dFdx(v_place), place_y = dFdy(v_place);  // before fragments are discarded
#endif
#ifdef CLIPPED
  vec3 at = point_at(gl_FragCoord.xy, distance_of(gl_FragCoord.z));
  for (int i = 0; i < u_clip_planes; ++i) {
    if (dot(u_clip_plane[i].xyz, at) < u_clip_plane[i].w) discard;
  }
#endif
#ifdef LINES
  Trilinear field = Trilinear(v_field_a, v_field_b);
  vec3 rise = value_and_gradient(field, v_place).yzw;
  // Triangles leave the surface: a field that is constant on it is not on them.
  bool has_lines = !is_constant(rise, value_and_gradient(Trilinear(v_a, v_b), v_place).yzw, v_least_sine);
  vec2 change = has_lines ? vec2(dot(rise, place_x), dot(rise, place_y)) : vec2(0.0);
  float scalar = scalar_with_lines(field, v_place, change);
#elif defined(CATEGORIES)
  float scalar = category_scalar(Trilinear(v_field_a, v_field_b), v_place, vec3(0.5));
#elif defined(FIELD)
  float scalar = field_scalar(Trilinear(v_field_a, v_field_b), v_place);
#elif !defined(LIT)
  float scalar = v_scalar;
#endif
#if defined(LIT) && defined(FIELD)
  o_colour = apply_gamma(vec4(v_colour * field_colour(u_isosurface, scalar), 1.0));
#elif defined(LIT)
  o_colour = vec4(v_colour, 1.0);
#else
  // Triangles are counter-clockwise seen from the side of lower values.
  int side = gl_FrontFacing ? SIDE_RISING : SIDE_FALLING;
  o_pixel = encode_surface(normalize(v_normal), scalar, u_isosurface, side);
#endif
}
