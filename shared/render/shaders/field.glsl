// The scalar of surface pixels that show the field of a volume: the position of the field's value in
// the colour map, times FIELD_HIGHEST / 65535; with CATEGORIES, the index of its colour / 65535; or
// FIELD_MISSING / 65535 where the value is missing.
uniform vec3 u_field;  // position in the colour map: x · value + y, or, if z is not 0, z · log2 of it;
                       // index of a category's colour: x · value + y, below z

#define MISSING_VALUE 1e9

#ifdef CATEGORIES
// The category of the nearest corner of the cell. corners: quantized values, or MISSING_VALUE, at the
// lower (a) and upper (b) corners. middle: of the cell, in the coordinates of p.
float category_scalar(Trilinear corners, vec3 p, vec3 middle) {
  vec4 four = p.z < middle.z ? corners.a : corners.b;
  vec2 two = p.y < middle.y ? four.xy : four.zw;
  float value = p.x < middle.x ? two.x : two.y, index = floor(u_field.x * value + u_field.y + 0.5);
  bool has_colour = value < MISSING_VALUE && index >= 0.0 && index < u_field.z;
  return (has_colour ? index : float(FIELD_MISSING)) / 65535.0;
}
#else

// The value of a trilinear function at p in the cell (0 to 1).
float field_at(Trilinear f, vec3 p) {
  vec4 c = f.a + p.z * f.b;
  return c.x + p.x * c.y + p.y * (c.z + p.x * c.w);
}

// field: quantized values; those of cells with a missing corner are MISSING_VALUE everywhere.
float field_position(Trilinear field, vec3 p) {
  float position = u_field.x * field_at(field, p) + u_field.y;
  SKIPPABLE_IF(u_field.z != 0.0) position = u_field.z * log2(max(position, 1e-30));
  return clamp(position, 0.0, 1.0);
}

float field_scalar(Trilinear field, vec3 p) {
  float scalar = field_position(field, p) * (float(FIELD_HIGHEST) / 65535.0);
  return field.a.x < MISSING_VALUE ? scalar : float(FIELD_MISSING) / 65535.0;
}
#endif
