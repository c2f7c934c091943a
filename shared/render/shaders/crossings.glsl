// The points at which the isosurface crosses the edges of a cell. The extents of these points bound
// the part of the surface in the cell. Neighbouring cells join without gaps, because they share the
// crossings of their common face.

// Positions along the edges, 0 to 1, in the order of the other two coordinates (x before y before z);
// -1 if the edge is not crossed.
struct Crossings {
  vec4 x, y, z;
};

// start, end: values at the ends of four edges, minus the isovalue. Zero counts as below, as in
// is_active.
vec4 crossings_of(vec4 start, vec4 end) {
  bvec4 is_crossed = notEqual(greaterThan(start, vec4(0.0)), greaterThan(end, vec4(0.0)));
  return mix(vec4(-1.0), start / (start - end), is_crossed);
}

// lower, upper: values at the corners, in the order of Cell, minus the isovalue.
Crossings find_crossings(vec4 lower, vec4 upper) {
  return Crossings(crossings_of(vec4(lower.xz, upper.xz), vec4(lower.yw, upper.yw)),
                   crossings_of(vec4(lower.xy, upper.xy), vec4(lower.zw, upper.zw)),
                   crossings_of(lower, upper));
}

// The smallest and the largest `along * p` of all crossings p (0 to 1 in the cell). No crossings: 1e9,
// -1e9.
vec2 extent(Crossings crossings, vec3 along) {
  const vec4 none = vec4(1e9);
  vec4 x = along.x * crossings.x + vec4(0.0, along.y, along.z, along.y + along.z);
  vec4 y = along.y * crossings.y + vec4(0.0, along.x, along.z, along.x + along.z);
  vec4 z = along.z * crossings.z + vec4(0.0, along.x, along.y, along.x + along.y);
  bvec4 no_x = lessThan(crossings.x, vec4(0.0)), no_y = lessThan(crossings.y, vec4(0.0)),
        no_z = lessThan(crossings.z, vec4(0.0));
  vec4 low = min(min(mix(x, none, no_x), mix(y, none, no_y)), mix(z, none, no_z));
  vec4 high = max(max(mix(x, -none, no_x), mix(y, -none, no_y)), mix(z, -none, no_z));
  return vec2(min(min(low.x, low.y), min(low.z, low.w)), max(max(high.x, high.y), max(high.z, high.w)));
}

// The range of the crossings of four parallel edges. It extends to 0 or 1 if the face at this end
// is crossed.
vec2 range_of(vec4 crossings, bool low_face_is_crossed, bool high_face_is_crossed) {
  vec4 no_low = mix(crossings, vec4(1.0), lessThan(crossings, vec4(0.0)));
  float low = min(min(no_low.x, no_low.y), min(no_low.z, no_low.w));
  float high = max(max(crossings.x, crossings.y), max(crossings.z, crossings.w));
  return vec2(low_face_is_crossed ? 0.0 : low, high_face_is_crossed ? 1.0 : max(high, 0.0));
}

// The smallest box (0 to 1 in the cell) that contains the surface of the trilinear function. If no
// edge of a face is crossed, the surface lies behind the nearest crossing of an edge perpendicular
// to the face: in the slices before it, the bilinear function lies between the values at its
// corners, which are all on one side. If no edge of the cell is crossed, the box is the whole cell.
void bound_surface(Crossings c, out vec3 low, out vec3 high) {
  bvec4 x = greaterThanEqual(c.x, vec4(0.0)), y = greaterThanEqual(c.y, vec4(0.0)),
        z = greaterThanEqual(c.z, vec4(0.0));
  vec2 along_x = range_of(c.x, y.x || y.z || z.x || z.z, y.y || y.w || z.y || z.w);
  vec2 along_y = range_of(c.y, x.x || x.z || z.x || z.y, x.y || x.w || z.z || z.w);
  vec2 along_z = range_of(c.z, x.x || x.y || y.x || y.y, x.z || x.w || y.z || y.w);
  bool none = !(any(x) || any(y) || any(z));
  low = none ? vec3(0.0) : vec3(along_x.x, along_y.x, along_z.x);
  high = none ? vec3(1.0) : vec3(along_x.y, along_y.y, along_z.y);
}
