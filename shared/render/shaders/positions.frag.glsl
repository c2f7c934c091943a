// The position of the surface at each pixel, for gradients.frag.glsl. xyz: bits of the position in
// frame space (frame.glsl). w: the normal of the surface pixel, 14 bits for each of its two
// components, and the isosurface's index among those of the volume. Pixels without a surface of the
// volume have a position far from all cells.
uniform highp usampler2DArray u_surfaces;
uniform highp sampler2DArray u_depths;
uniform int u_layer;
uniform int u_isosurfaces[MAX_ISOSURFACES];  // of the volume; -1: none
layout(location = 0) out uvec4 o_place;

int among_volume(int isosurface) {
  for (int i = 0; i < MAX_ISOSURFACES; ++i) {
    if (u_isosurfaces[i] == isosurface) return i;
  }
  return NO_ISOSURFACE;
}

void main() {
  ivec3 at = ivec3(gl_FragCoord.xy, u_layer);
  float depth = texelFetch(u_depths, at, 0).x;
  uvec4 surface = texelFetch(u_surfaces, at, 0);
  int isosurface = depth < 1.0 ? among_volume(int(surface.w >> ISOSURFACE_SHIFT)) : NO_ISOSURFACE;
  vec3 place = isosurface < NO_ISOSURFACE ? point_at(gl_FragCoord.xy, distance_of(depth)) : vec3(1e18);
  o_place = uvec4(floatBitsToUint(place),
                  surface.x >> 2 | surface.y >> 2 << 14 | uint(isosurface) << 28);
}
