// The place of the surface at each pixel, for gradients.frag.glsl. xyz: bits of the position in frame
// space (frame.glsl). w: the normal of the surface pixel, 14 bits for each of its two components, and
// the isosurface. Pixels without a surface have a place far from all cells.
uniform highp usampler2DArray u_surfaces;
uniform highp sampler2DArray u_depths;
uniform int u_layer;
layout(location = 0) out uvec4 o_place;

void main() {
  ivec3 at = ivec3(gl_FragCoord.xy, u_layer);
  float depth = texelFetch(u_depths, at, 0).x;
  uvec4 surface = texelFetch(u_surfaces, at, 0);
  vec3 place = depth < 1.0 ? point_at(gl_FragCoord.xy, distance_of(depth)) : vec3(1e18);
  o_place = uvec4(floatBitsToUint(place),
                  surface.x >> 2 | surface.y >> 2 << 14 | surface.w >> ISOSURFACE_SHIFT << 28);
}
