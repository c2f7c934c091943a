// Copies the surface pixels and depths of layer 0 into a colour target: GL cannot read depths back.
uniform highp usampler2DArray u_surfaces;
uniform highp sampler2DArray u_depths;
layout(location = 0) out uvec4 o_words;

void main() {
  ivec3 at = ivec3(gl_FragCoord.xy, 0);
  uvec4 surface = texelFetch(u_surfaces, at, 0);
  float depth = texelFetch(u_depths, at, 0).x;
  o_words = uvec4(surface.x | surface.y << 16, surface.z | surface.w << 16,
                  floatBitsToUint(distance_of(depth)), depth < 1.0 ? 1u : 0u);
}
