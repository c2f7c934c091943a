// One step of jump flooding (G. Rong, T.-S. Tan, I3D 2006). In earlier steps, the nine tiles at this
// distance have found tiles with states. This shader writes the nearest of those as x | y << 16, or
// 0xffffffff if there are none. Tiles whose states follow from cells are preferred to all others.
uniform highp usampler2D u_tiles;    // cap_tiles.frag.glsl
uniform highp usampler2D u_nearest;  // of the last step
uniform int u_step;                  // 0 in the first step: each tile with states writes itself
layout(location = 0) out uint o_nearest;

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy), size = textureSize(u_tiles, 0);
  o_nearest = 0xffffffffu;
  if (u_step == 0) {
    if (texelFetch(u_tiles, at, 0).x != 0u) o_nearest = uint(at.x) | uint(at.y) << 16;
    return;
  }
  int least = 0x7fffffff;
  for (int i = 0; i < 9; ++i) {
    ivec2 asked = at + u_step * (ivec2(i % 3, i / 3) - 1);
    if (any(lessThan(asked, ivec2(0))) || any(greaterThanEqual(asked, size))) continue;
    uint known = texelFetch(u_nearest, asked, 0).x;
    if (known == 0xffffffffu) continue;
    ivec2 there = ivec2(known & 0xffffu, known >> 16), to = there - at;
    int later = texelFetch(u_tiles, there, 0).y == 0u ? 1 << 24 : 0;
    int distance_2 = to.x * to.x + to.y * to.y + later;
    if (distance_2 >= least) continue;
    least = distance_2;
    o_nearest = known;
  }
}
