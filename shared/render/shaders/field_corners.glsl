// The values of a volume's field at the corners of a sample's cell (PackedField in
// shared/core/sampling/packed_field.h). Splats that fetch their samples by index fetch these as well.
uniform float u_field_missing;  // quantized values from here on are missing
#ifdef PULLED
uniform highp usampler2D u_fields;
uvec4 fetch_field(int sample_) {
  return texelFetch(u_fields, ivec2(sample_ % SAMPLE_TEXTURE_WIDTH, sample_ / SAMPLE_TEXTURE_WIDTH), 0);
}
#else
layout(location = 1) in uvec4 a_field;
uvec4 fetch_field(int sample_) { return a_field; }
#endif

#ifdef CATEGORIES
vec3 field_middle = vec3(0.5);  // see category_scalar
#endif

// See field_scalar and category_scalar.
Trilinear trilinear_field(uvec4 w) {
  uvec4 low = w & 0xffffu, high = w >> 16;
  vec4 lower = vec4(low.x, high.x, low.y, high.y), upper = vec4(low.z, high.z, low.w, high.w);
#ifdef CATEGORIES
  vec4 missing = vec4(MISSING_VALUE), least = vec4(u_field_missing);
  return Trilinear(mix(lower, missing, greaterThanEqual(lower, least)),
                   mix(upper, missing, greaterThanEqual(upper, least)));
#else
  vec4 most = max(lower, upper);
  if (max(max(most.x, most.y), max(most.z, most.w)) >= u_field_missing) {
    return Trilinear(vec4(MISSING_VALUE, 0.0, 0.0, 0.0), vec4(0.0));
  }
  return trilinear(lower, upper);
#endif
}

// The field in the coordinates of a part of the cell.
Trilinear field_in_box(Trilinear field, vec3 low, vec3 extent) {
#ifdef CATEGORIES
  field_middle = (field_middle - low) / extent;
  return field;
#else
  return in_box(field, low, extent);
#endif
}
#ifdef LINES
// See is_constant in field_lines.glsl. interval: that of the cell.
float least_sine_of(vec2 interval) {
  return interval.y - interval.x > 511.0 ? LINE_ROUNDED_SINE : LINE_LEAST_SINE;
}
#endif
