// The farthest depth of a tile of one layer.
uniform highp sampler2DArray u_depths;
uniform int u_layer;
layout(location = 0) out uint o_farthest;

void main() {
  ivec2 low = ivec2(gl_FragCoord.xy) * HIDING_TILE_PX;
  ivec2 last = textureSize(u_depths, 0).xy - 1;
  float farthest = 0.0;
  for (int y = 0; y < HIDING_TILE_PX; ++y) {
    for (int x = 0; x < HIDING_TILE_PX; ++x) {
      ivec2 at = min(low + ivec2(x, y), last);
      farthest = max(farthest, texelFetch(u_depths, ivec3(at, u_layer), 0).x);
    }
  }
  o_farthest = floatBitsToUint(farthest);
}
