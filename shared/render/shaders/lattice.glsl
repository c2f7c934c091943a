// The gradients at lattice points: sums over the cells around each, in a texture of pages. A page has
// the 8³ lattice points of a region (lattice_regions.h).

// The number of the page of a region, with LATTICE_NEW_PAGE; 0 if it has none.
uint page_of(highp usampler3D pages, ivec3 region) {
  bool inside = all(greaterThanEqual(region, ivec3(0))) && all(lessThan(region, textureSize(pages, 0)));
  return inside ? texelFetch(pages, region, 0).x : 0u;
}

// point: in the region, 0 to 7. The page may have LATTICE_NEW_PAGE.
ivec2 texel_of(uint page, ivec3 point) {
  page &= ~LATTICE_NEW_PAGE;
  ivec2 first = ivec2(page % uint(LATTICE_COLUMNS), page / uint(LATTICE_COLUMNS));
  return first * ivec2(LATTICE_PAGE_WIDTH, LATTICE_PAGE_HEIGHT) +
         ivec2(point.x | (point.z & 3) << 3, point.y | (point.z >> 2) << 3);
}
