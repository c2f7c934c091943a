// For each tile of states (cap_states.frag.glsl): the known states nearest to its corners and to
// the middles of its edges, four bits each, in rows from the lower left one; 0: there is none in
// the tile or beside it. If cells at the face give some states, only these count (y is 1), since
// surfaces may be drawn a pixel beyond their outlines. If cells give no state in a tile, the
// isovalue is not crossed in it, and the whole tile has the state of the nearest tile's edge.
uniform highp usampler2D u_states;
layout(location = 0) out uvec2 o_tile;

void main() {
  const int kBeside = 2, kSide = CAP_TILE_PX + 2 * kBeside;
  ivec2 low = ivec2(gl_FragCoord.xy) * CAP_TILE_PX, end = textureSize(u_states, 0);
  uint found[8] = uint[8](0u, 0u, 0u, 0u, 0u, 0u, 0u, 0u);
  float nearest[8] = float[8](1e9, 1e9, 1e9, 1e9, 1e9, 1e9, 1e9, 1e9);
  uint by_cells = 0u;
  for (int i = 0; i < kSide * kSide; ++i) {
    ivec2 px = ivec2(i % kSide, i / kSide) - kBeside;
    if (any(lessThan(low + px, ivec2(0))) || any(greaterThanEqual(low + px, end))) continue;
    uint state = texelFetch(u_states, low + px, 0).x;
    if (state < 2u) continue;
    float later = unlikeliness(state);
    bool is_beside = any(lessThan(px, ivec2(0))) || any(greaterThanEqual(px, ivec2(CAP_TILE_PX)));
    if (state >= uint(CAP_BY_CELL) && !is_beside) by_cells = 1u;
    for (int k = 0; k < 8; ++k) {
      int place = k < 4 ? k : k + 1;  // the middle of the tile is left out
      vec2 corner = 0.5 * float(CAP_TILE_PX - 1) * vec2(place % 3, place / 3);
      float way = distance(corner, vec2(px)) + later;
      if (way >= nearest[k]) continue;
      nearest[k] = way;
      found[k] = state & uint(CAP_BY_CELL - 1);
    }
  }
  o_tile = uvec2(0u, by_cells);
  for (int k = 0; k < 8; ++k) o_tile.x |= found[k] << (4 * k);
}
