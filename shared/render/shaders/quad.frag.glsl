#ifdef LIT
flat in uvec4 v_square;
layout(location = 0) out vec4 o_colour;
#else
flat in uvec4 v_pixel;
flat in vec3 v_band;
layout(location = 0) out uvec4 o_pixel;
#endif
#ifdef LINES
flat in vec3 v_line;
#ifdef LIT
flat in uint v_line_colour;
#endif
#endif
flat in vec4 v_low, v_high;

void main() {
#ifdef LIT
  vec3 band = uintBitsToFloat(v_square.xyz);
#else
  vec3 band = v_band;
#endif
  vec2 px = gl_FragCoord.xy;
  vec4 at = vec4(px, px.x + px.y, px.x - px.y);
  if (any(lessThan(at, v_low)) || any(greaterThan(at, v_high)) || abs(dot(px, band.xy) - band.z) > 1.0) {
    discard;
  }
#ifdef LINES
  float coverage = line_coverage(v_line.x + dot(v_line.yz, px), v_line.yz);
#endif
#ifdef LIT
  o_colour = vec4(unpack_colour(v_square.w), 1.0);
#ifdef LINES
  o_colour.rgb = mix(o_colour.rgb, unpack_colour(v_line_colour), coverage);
#endif
#else
  o_pixel = v_pixel;
#ifdef LINES
  o_pixel.z += uint(coverage * float(LINE_TONE - 1) + 0.5);
#endif
#endif
}
