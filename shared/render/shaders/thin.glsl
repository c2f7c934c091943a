// Coarse cells whose corners are all on one side of the isovalue contain a structure thinner than a
// cell. It is drawn as a box in the cell, as large as the part of the cell beyond the isovalue. The
// box reaches the faces beyond which the structure continues (mark_neighbours), so that boxes join:
// they form tubes where the structure continues across two opposite faces, and sheets where it
// continues across four.

// The bits of mark_neighbours: beyond the faces x = 0, y = 0 and z = 0, and x = 1, y = 1 and z = 1.
void neighbours_of(uint word, out bvec3 below, out bvec3 above) {
  uvec3 pairs = uvec3(word >> 18, word >> 20, word >> 30) & 3u;
  below = notEqual(pairs & 1u, uvec3(0u));
  above = notEqual(pairs & 2u, uvec3(0u));
}

// The isovalue at which the surface of a coarse cell is drawn, where corners are on both sides of
// it. Coarse values are averages, in which a thin structure is lower: its surface would be too
// small. The further the interval reaches beyond the corners, the more the isovalue is lowered.
float thickened(Cell cell, float quantized_isovalue) {
  float mean = 0.125 * dot(cell.lower + cell.upper, vec4(1.0));
  float side = mean < quantized_isovalue ? 1.0 : -1.0;
  float from = side > 0.0 ? cell.interval.x : cell.interval.y;
  float per_span = 1.0 / max(cell.interval.y - cell.interval.x, 1.0);
  vec4 most = max(side * cell.lower, side * cell.upper);
  float peak = (max(max(most.x, most.y), max(most.z, most.w)) - side * from) * per_span;
  float level = side * (quantized_isovalue - from) * per_span;
  if (peak < level) return quantized_isovalue;
  float lowered = peak * (1.0 - THIN_LOWER * sqrt(max(peak * (1.0 - peak) * (1.0 - level), 0.0)));
  return from + side * min(level, lowered) / per_span;
}

// The share of the cell's volume that is beyond the isovalue. Assumes that values fall from the
// middle of the structure, where they reach the end of the interval, like those of a tube with a
// Gaussian profile, and that their mean is that of the corners. from: the other end of the
// interval.
float thin_share(Cell cell, float quantized_isovalue, float mean, float from) {
  float span = (mean < quantized_isovalue ? cell.interval.y : cell.interval.x) - from;
  float level = clamp((quantized_isovalue - from) / span, 0.01, 1.0);
  return clamp(THIN_SHARE * (mean - from) / span * -log(level), THIN_LEAST, 1.0);
}

// Marks with 1 the axis with the largest slope among those that are allowed (1). At least one axis
// is allowed.
vec3 steepest(vec3 slope, vec3 allowed) {
  vec3 s = mix(vec3(-1.0), slope, allowed);
  return s.x >= s.y && s.x >= s.z ? vec3(1.0, 0.0, 0.0) : s.y >= s.z ? vec3(0.0, 1.0, 0.0) : vec3(0.0, 0.0, 1.0);
}

// The box of the structure, 0 to 1 in the cell. voxel: side of a voxel of level 0, in cells. spanned:
// the axes on which the box spans the cell.
void thin_box(Cell cell, float quantized_isovalue, float voxel, out vec3 low, out vec3 high, out vec3 spanned) {
  vec4 at = value_and_gradient_at_centre(cell);
  float from = at.x < quantized_isovalue ? cell.interval.x : cell.interval.y;
  float share = thin_share(cell, quantized_isovalue, at.x, from);
  bvec3 below, above;
  neighbours_of(cell.word, below, above);
  vec3 to_low = vec3(below), to_high = vec3(above);
  spanned = to_low * to_high;
  // A structure that continues everywhere is assumed to be a sheet. A sheet that would be thinner than a
  // voxel is assumed to be a tube, along the axes on which values change the least.
  vec3 slope = abs(at.yzw), one = vec3(1.0);
  if (dot(spanned, one) > 2.5) spanned -= steepest(slope, spanned);
  if (dot(spanned, one) > 1.5 && share < THIN_SHEET_VOXELS * voxel) spanned -= steepest(slope, spanned);
  vec3 extent = mix(vec3(pow(share, 1.0 / (3.0 - dot(spanned, one)))), one, spanned);
  // The structure is nearer to the corners whose values are nearer to its own.
  vec3 place = 0.5 + 0.25 * at.yzw / (abs(at.x - from) > 0.5 ? at.x - from : 1e9);
  vec3 free = clamp(place - 0.5 * extent, vec3(0.0), 1.0 - extent);
  vec3 only_low = to_low * (1.0 - to_high), only_high = to_high * (1.0 - to_low);
  low = (1.0 - only_low) * mix(free, 1.0 - extent, only_high);
  high = low + extent;
}
