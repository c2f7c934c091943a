// The state of the point at which each pixel's ray enters the part that is shown. 0: there is no
// such point. 1: nothing is known. Otherwise it is 2 more than the number of isovalues that are
// reached there, with CAP_BY_CELL if a cell gives the state. The number follows from one of these:
// the values of the cell at the point; the first surface of any layer behind the point, since the
// volume's function is continuous, and crosses no isovalue before this surface; or the face of an
// active cell beside the point.
uniform highp usampler2DArray u_surfaces;
uniform highp sampler2DArray u_depths;
uniform highp usampler2D u_cut_cells;  // cut_cells.frag.glsl
uniform int u_layers;
uniform int u_isosurfaces[MAX_ISOSURFACES];  // of the volume; -1: none
uniform int u_rank[MAX_ISOSURFACES];   // number of different isovalues up to this one
layout(location = 0) out uint o_state;

uint state_by_surface(ivec2 at) {
  float nearest = 1.0;
  uvec4 surface = uvec4(0u);
  for (int layer = 0; layer < u_layers; ++layer) {
    float depth = texelFetch(u_depths, ivec3(at, layer), 0).x;
    if (depth >= nearest) continue;
    nearest = depth;
    surface = texelFetch(u_surfaces, ivec3(at, layer), 0);
  }
  int side = side_of(surface), rank = 0, isosurface = int(surface.w >> ISOSURFACE_SHIFT);
  for (int i = 0; i < MAX_ISOSURFACES; ++i) {
    if (u_isosurfaces[i] == isosurface) rank = u_rank[i];
  }
  return side == SIDE_UNKNOWN ? 1u : uint(side == SIDE_FALLING ? rank : rank - 1) + 2u;
}

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  uint cut = texelFetch(u_cut_cells, at, 0).x;
  float z;
  o_state = 0u;
  if (entry(gl_FragCoord.xy, z) < 0) return;
  o_state = state_by_surface(at);
  bool is_estimated = cut >= uint(CAP_ESTIMATED);
  uint by_cell = (cut & uint(CAP_ESTIMATED - 1)) + 1u;
  if (cut > 0u && (!is_estimated || o_state == 1u || o_state == by_cell)) o_state = by_cell | uint(CAP_BY_CELL);
}
