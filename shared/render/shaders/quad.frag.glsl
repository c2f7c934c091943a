#ifdef LIT
flat in uvec4 v_square;
layout(location = 0) out vec4 o_colour;
#else
flat in uvec4 v_pixel;
flat in vec3 v_band;
layout(location = 0) out uvec4 o_pixel;
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
#ifdef LIT
  o_colour = vec4(unpack_colour(v_square.w), 1.0);
#else
  o_pixel = v_pixel;
#endif
}
