// Replaces the normals of surface pixels by the sums of gradients. The weight of a sum is at least
// 1 where the pixel's own cell contributes. Where it is less, a part of the pixel's own normal is
// kept, so that normals are continuous between cells that contribute and smaller ones that do not.
uniform highp usampler2D u_positions;
uniform sampler2D u_sums;
layout(location = 0) out uvec4 o_pixel;

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  vec4 sum = texelFetch(u_sums, at, 0);
  if (!(sum.w > 0.0)) discard;
  vec3 gradient = row_to_view(sum.xyz);
  float steepness = length(gradient);
  if (!(steepness > 0.0)) discard;
  uint bits = texelFetch(u_positions, at, 0).w;
  vec3 own = decode_normal(uvec2(bits & 0x3fffu, bits >> 14 & 0x3fffu) * 4u + 2u);
  vec3 normal = mix(own, gradient / steepness, min(sum.w, 1.0));
  if (dot(normal, normal) == 0.0) discard;
  o_pixel = uvec4(encode_normal(normal), 0u, 0u);
}
