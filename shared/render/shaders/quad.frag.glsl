#ifdef LIT
flat in uvec4 v_square;
layout(location = 0) out vec4 o_colour;
#else
flat in uvec4 v_pixel;
flat in vec3 v_band;
layout(location = 0) out uvec4 o_pixel;
#endif

void main() {
#ifdef LIT
  vec3 band = uintBitsToFloat(v_square.xyz);
#else
  vec3 band = v_band;
#endif
  if (abs(dot(gl_FragCoord.xy, band.xy) - band.z) > 1.0) discard;
#ifdef LIT
  o_colour = vec4(unpack_colour(v_square.w), 1.0);
#else
  o_pixel = v_pixel;
#endif
}
