// The drawn regions of a chunk's block: 8×8×8 regions of 8³ cells, two words for each slice in z.
uniform uvec4 u_regions[4];

// low: the cell's low corner in the block, 0 to 63.
bool is_drawn(vec3 low) {
  uvec3 region = uvec3(low) >> 3;
  uvec4 two_slices = u_regions[region.z >> 1];
  uint bit = region.x + 8u * region.y;
  uint word = two_slices[2u * (region.z & 1u) + (bit >> 5)];
  return (word >> (bit & 31u) & 1u) != 0u;
}
