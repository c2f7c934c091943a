// Depths of a tile of one layer, as the bits of floats, whose order is that of the depths. x: the
// farthest depth, with the background; y, z: the nearest and the farthest depth of a surface. If the
// tile shows no surface, y > z.
uniform highp sampler2DArray u_depths;
uniform int u_layer;
layout(location = 0) out uvec4 o_depths;

void main() {
  ivec2 low = ivec2(gl_FragCoord.xy) * HIDING_TILE_PX;
  ivec2 last = textureSize(u_depths, 0).xy - 1;
  float farthest = 0.0, nearest = 1.0, farthest_surface = 0.0;
  for (int y = 0; y < HIDING_TILE_PX; ++y) {
    for (int x = 0; x < HIDING_TILE_PX; ++x) {
      ivec2 at = min(low + ivec2(x, y), last);
      float depth = texelFetch(u_depths, ivec3(at, u_layer), 0).x;
      farthest = max(farthest, depth);
      nearest = min(nearest, depth);
      if (depth < 1.0) farthest_surface = max(farthest_surface, depth);
    }
  }
  o_depths = uvec4(floatBitsToUint(vec3(farthest, nearest, farthest_surface)), 0u);
}
