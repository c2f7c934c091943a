// The scalar of surface pixels that show the field of a volume: the position of the field's value in
// the colour map, times FIELD_HIGHEST / 65535, or FIELD_MISSING / 65535 where the value is missing.
uniform vec3 u_field;  // position in the colour map: x · value + y, or, if z is not 0, z · log2 of it

#define MISSING_VALUE 1e9

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
