// Converts the sums of blended splats to surface pixels.
uniform sampler2D u_normals;
uniform sampler2D u_sums;
uniform uint u_isosurface;
layout(location = 0) out uvec4 o_pixel;

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  vec4 normal = texelFetch(u_normals, at, 0), sums = texelFetch(u_sums, at, 0);
  if (!(sums.x > 0.0) || normal.w <= 0.0) discard;
  gl_FragDepth = window_depth(sums.y / sums.x);
  vec3 n = dot(normal.xyz, normal.xyz) > 0.0 ? normal.xyz : vec3(0.0, 0.0, 1.0);
  o_pixel = encode_surface(n, sums.z / sums.x, u_isosurface, normal.w);
}
