// Caps: closes the faces at which the clip planes cut the solid, the part of the volume whose values
// are at least the isovalue. Copies a layer, and replaces its pixels where it has a cap.
uniform highp usampler2DArray u_surfaces;
uniform highp sampler2DArray u_depths;
uniform highp usampler2D u_states;          // cap_states.frag.glsl
uniform highp usampler2D u_tiles;           // cap_tiles.frag.glsl
uniform highp usampler2D u_nearest;         // cap_jump.frag.glsl
uniform int u_layer;
uniform int u_cap_order;                    // in one face, caps with a greater order are in front of others
uniform int u_cuts;                         // clip planes that cut; the planes after them bound the volume
uniform int u_cap[MAX_ISOSURFACES + 1];     // index: number of isovalues reached. The isosurface (of the volume) whose
                                            // cap the layer shows; -1: none
uniform int u_isosurfaces[MAX_ISOSURFACES];  // of the volume: their numbers
uniform float u_cap_scalar[MAX_ISOSURFACES];
layout(location = 0) out uvec4 o_pixel;

// The nearest known state. Searches up to the largest distance at which a state of the pixel's tile
// can be.
uint nearest_around(ivec2 at) {
  const int kReach = CAP_TILE_PX - 1, kSide = 2 * kReach + 1;
  ivec2 end = textureSize(u_states, 0);
  uint found = 1u;
  float least = 1e9;
  for (int i = 0; i < kSide * kSide; ++i) {
    ivec2 to = ivec2(i % kSide, i / kSide) - kReach, px = at + to;
    if (any(lessThan(px, ivec2(0))) || any(greaterThanEqual(px, end))) continue;
    uint state = texelFetch(u_states, px, 0).x;
    float way = length(vec2(to)) + unlikeliness(state);
    if (state < 2u || way >= least) continue;
    least = way;
    found = state & uint(CAP_BY_CELL - 1);
  }
  return found;
}

// The state of a pixel of which nothing is known: that of the nearest known pixel, since the
// isovalue is not crossed between them. All cells of the faces in which the isovalue is crossed are
// known (cut_cells.frag.glsl).
uint filled(ivec2 at) {
  ivec2 tile = at / CAP_TILE_PX;
  if (texelFetch(u_tiles, tile, 0).y != 0u) return nearest_around(at);
  uint known = texelFetch(u_nearest, tile, 0).x;
  if (known == 0xffffffffu) return 1u;
  ivec2 there = ivec2(known & 0xffffu, known >> 16), place = 1 + sign(tile - there);
  if (there == tile) return nearest_around(at);
  int k = place.x + 3 * place.y;
  return texelFetch(u_tiles, there, 0).x >> (4 * (k < 4 ? k : k - 1)) & 15u;
}

// Returns `state`, which follows from a surface, or the state of most pixels around it if that
// differs: a single splat may miss the surface, or be drawn beyond its outline. Where the isovalue
// is crossed, cells give the state.
uint without_outliers(uint state, ivec2 at) {
  ivec2 last = textureSize(u_states, 0) - 1;
  uint other = state;
  int differing = 0;
  for (int i = 0; i < 9; ++i) {
    ivec2 px = clamp(at + ivec2(i % 3, i / 3) - 1, ivec2(0), last);
    uint there = texelFetch(u_states, px, 0).x & uint(CAP_BY_CELL - 1);
    if (there < 2u || there == state) continue;
    other = there;
    ++differing;
  }
  return differing > 4 ? other : state;
}

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  o_pixel = texelFetch(u_surfaces, ivec3(at, u_layer), 0);
  gl_FragDepth = texelFetch(u_depths, ivec3(at, u_layer), 0).x;
  float z;
  int plane = entry(gl_FragCoord.xy, z);
  uint state = texelFetch(u_states, at, 0).x;
  SKIPPABLE_IF(state == 1u && plane < u_cuts) state = filled(at);
  bool by_surface = state > 1u && state < uint(CAP_BY_CELL) && plane < u_cuts;
  SKIPPABLE_IF(by_surface) state = without_outliers(state, at);
  int count = int(state & uint(CAP_BY_CELL - 1)) - 2, isosurface = count < 0 ? -1 : u_cap[count];
  SKIPPABLE_IF(isosurface >= 0 && plane >= 0 && plane < u_cuts) {
    vec3 normal = normalize(row_to_view(-u_clip_plane[plane].xyz));
    o_pixel = encode_surface(normal, u_cap_scalar[isosurface], uint(u_isosurfaces[isosurface]), SIDE_CAP);
    gl_FragDepth = window_depth(z) - CAP_DEPTH_STEP * float(count + u_cap_order);
  }
}
