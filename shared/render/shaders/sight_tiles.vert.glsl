// One vertex for each tile of the picture becomes one dot in the last row of a sight query's answer,
// if the opaque surfaces cover all of the tile: the row's sum counts these tiles.
uniform vec2 u_row;                   // as in sight.vert.glsl
uniform highp usampler2D u_farthest;  // opaque depth of each tile
flat out vec4 v_answer;

void main() {
  gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
  gl_PointSize = 1.0;
  v_answer = vec4(0.0);
  int columns = textureSize(u_farthest, 0).x;
  ivec2 tile = ivec2(gl_VertexID % columns, gl_VertexID / columns);
  if (uintBitsToFloat(texelFetch(u_farthest, tile, 0).x) >= 1.0) return;
  // Spread over the row, so that no sum grows beyond what a texel holds.
  int place = gl_VertexID % (4 * SIGHT_ROW_TEXELS);
  v_answer = vec4(equal(ivec4(place & 3), ivec4(0, 1, 2, 3))) / float(SIGHT_MOST_PX);
  float column = (float(place >> 2) + 0.5) / float(SIGHT_ROW_TEXELS);
  gl_Position = vec4(2.0 * vec2(column, u_row.x / u_row.y) - 1.0, 0.0, 1.0);
}
