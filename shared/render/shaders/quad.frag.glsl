flat in uvec4 v_pixel;
flat in vec4 v_band;
layout(location = 0) out uvec4 o_pixel;

void main() {
  if (abs(dot(gl_FragCoord.xy - v_band.xy, v_band.zw)) > 1.0) discard;
  o_pixel = v_pixel;
}
