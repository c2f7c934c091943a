// The scalar of surface pixels that show a field with contour lines (field.glsl): bits of the position
// in the colour map, whether the next line is dark, and how much of the pixel it covers.
uniform vec4 u_lines;  // number of the line at a value: x · value + y, or, if z is not 0,
                       // z · log2 of u_field's ratio + y; w: colours of the map, 0: all of them
// x: change of the position in the colour map per line; lines at positions from y to z are dark.
uniform vec3 u_line_tones;

// Whether a function with the gradient `rise` is constant on a surface with this gradient: the sine of
// their angle is at most least_sine.
bool is_constant(vec3 rise, vec3 gradient, float least_sine) {
  vec3 across = cross(rise, gradient);
  return dot(across, across) <= least_sine * least_sine * dot(rise, rise) * dot(gradient, gradient);
}

// The change per px, to the right and up, of a function with the gradient `rise` on a surface with
// this gradient; 0 where it is constant (is_constant). ray: one unit along the view. right, up: the change of the position per px in a plane
// that faces the camera. All in the same space.
vec2 change_per_px(vec3 rise, vec3 gradient, vec3 ray, vec3 right, vec3 up, float least_sine) {
  vec3 on_surface = rise - gradient * (dot(rise, ray) / dot(gradient, ray));
  bool has_lines = !is_constant(rise, gradient, least_sine);
  return has_lines ? vec2(dot(on_surface, right), dot(on_surface, up)) : vec2(0.0);
}

// x: the number of the line at a value of the field, a fraction between two lines; y: its change per
// quantized value, 0 where there are no lines.
vec2 line_number(float value) {
  vec2 line = vec2(u_lines.x * value + u_lines.y, u_lines.x);
  SKIPPABLE_IF(u_lines.z != 0.0) {
    float ratio = u_field.x * value + u_field.y;
    float per_value = u_lines.z * u_field.x / (ratio * log(2.0));
    line = ratio > 1e-30 ? vec2(u_lines.z * log2(ratio) + u_lines.y, per_value) : vec2(0.0);
  }
  return line;
}

// The scalar at a place in the cell that no line covers; number: that of the line.
float scalar_beside_lines(Trilinear field, vec3 p, float number) {
  float position = field_position(field, p);
  float at_line = clamp(position + (floor(number + 0.5) - number) * u_line_tones.x, 0.0, 1.0);
  // The colour of the step (field_colour); on the border of two, but for rounding, of the higher one.
  SKIPPABLE_IF(u_lines.w > 1.0) at_line = min(floor(at_line * u_lines.w + 1e-3), u_lines.w - 1.0) / (u_lines.w - 1.0);
  float dark = at_line >= u_line_tones.y && at_line <= u_line_tones.z ? 1.0 : 0.0;
  // The middle of a step, so that rounding does not change the step.
  SKIPPABLE_IF(u_lines.w > 1.0) position = (min(floor(position * u_lines.w), u_lines.w - 1.0) + 0.5) / u_lines.w;
  float code = floor(position * float(LINES_HIGHEST) + 0.5) * float(2 * LINE_TONE) + dark * float(LINE_TONE);
  return (field.a.x < MISSING_VALUE ? code : float(FIELD_MISSING)) / 65535.0;
}

// rise_per_px: change of the field's quantized value.
float scalar_with_lines(Trilinear field, vec3 p, vec2 rise_per_px) {
  vec2 line = line_number(field_at(field, p));
  float coverage = field.a.x < MISSING_VALUE ? line_coverage(line.x, line.y * rise_per_px) : 0.0;
  return scalar_beside_lines(field, p, line.x) + floor(coverage * float(LINE_TONE - 1) + 0.5) / 65535.0;
}
