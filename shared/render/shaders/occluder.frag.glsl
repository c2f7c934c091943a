flat in vec4 v_plane;
flat in float v_distance;

void main() {
  vec2 px = gl_FragCoord.xy * float(OCCLUDER_PX) - v_plane.xy;
  gl_FragDepth = window_depth(max(v_distance + dot(v_plane.zw, px), u_depth.z));
}
