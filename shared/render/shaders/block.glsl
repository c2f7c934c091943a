// The block of a chunk. It is packed, since it changes with every chunk that is drawn.
uniform vec4 u_block;

// The low corner of its first cell, in frame space.
vec3 block_corner() { return u_block.xyz; }
// Cells of level 0 along an edge of a cell: 2^level.
float cell_scale() { return u_block.w; }
bool is_coarse() { return u_block.w > 1.0; }
vec3 cell_size() { return u_cell_edges.xyz * u_block.w; }
