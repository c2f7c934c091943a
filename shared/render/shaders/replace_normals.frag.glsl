// Replaces the normals of surface pixels by those of lattice_normals.frag.glsl.
uniform highp usampler2D u_normals;
layout(location = 0) out uvec4 o_pixel;

void main() {
  uvec2 normal = texelFetch(u_normals, ivec2(gl_FragCoord.xy), 0).xy;
  if (normal.x == 0u) discard;
  o_pixel = uvec4(normal, 0u, 0u);
}
