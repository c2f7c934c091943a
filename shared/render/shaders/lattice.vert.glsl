// Adds the gradients of cells at their corners to the new pages of gradients: a point of one texel for
// each corner. gl_VertexID is 8 · sample + corner.
uniform highp usampler2D u_samples;
uniform highp usampler3D u_pages;
uniform ivec3 u_first_region;  // of the chunk's block, in u_pages
uniform vec2 u_texture_size;   // of the gradients
flat out vec4 v_gradient;      // times LATTICE_WEIGHT, in quantized values per cell; 1

void main() {
  int sample_ = gl_VertexID >> 3, corner = gl_VertexID & 7;
  Cell cell = unpack_sample(texelFetch(
      u_samples, ivec2(sample_ % SAMPLE_TEXTURE_WIDTH, sample_ / SAMPLE_TEXTURE_WIDTH), 0));
  ivec3 point = ivec3(cell.low) + ivec3(corner & 1, corner >> 1 & 1, corner >> 2);
  uint page = page_of(u_pages, u_first_region + (point >> 3));
  // The trilinear function's gradient at a corner: the differences along the cell's edges there.
  bool high_x = (corner & 1) != 0, high_y = (corner & 2) != 0;
  vec4 face = corner < 4 ? cell.lower : cell.upper, rise = cell.upper - cell.lower;
  vec2 row = high_y ? face.zw : face.xy, column = high_x ? face.yw : face.xz;
  vec2 up = high_y ? rise.zw : rise.xy;
  v_gradient = vec4(LATTICE_WEIGHT * vec3(row.y - row.x, column.y - column.x, high_x ? up.y : up.x), 1.0);
  vec2 texel = vec2(texel_of(page, point & 7)) + 0.5;
  bool is_new = (page & LATTICE_NEW_PAGE) != 0u;
  gl_Position = is_new ? vec4(2.0 * texel / u_texture_size - 1.0, 0.0, 1.0) : vec4(2.0, 2.0, 2.0, 1.0);
  gl_PointSize = 1.0;
}
