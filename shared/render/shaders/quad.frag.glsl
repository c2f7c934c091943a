#ifdef LIT
flat in vec3 v_colour;
layout(location = 0) out vec4 o_colour;
#else
flat in uvec4 v_pixel;
layout(location = 0) out uvec4 o_pixel;
#endif
flat in vec3 v_band;

void main() {
  if (abs(dot(gl_FragCoord.xy, v_band.xy) - v_band.z) > 1.0) discard;
#ifdef LIT
  o_colour = vec4(v_colour, 1.0);
#else
  o_pixel = v_pixel;
#endif
}
