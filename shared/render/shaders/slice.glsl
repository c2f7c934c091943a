// A slice: a plane in which the volume's values are shown.
uniform vec4 u_slice;                            // xyz: row vector; dot(xyz, position) = w
uniform float u_slice_nearer;                    // depth by which it is drawn nearer
uniform vec3 u_volume_low, u_volume_high;        // the volume's faces, in frame space

// The distance along the view at which the pixel's ray meets the plane.
float slice_distance(vec2 px) {
  return (u_slice.w - dot(u_slice.xyz, point_at(px, 0.0))) / dot(u_slice.xyz, ray_at(px));
}

// Whether the point at this distance is in the volume, and in the part of it that is shown. Also false if
// the ray is parallel to the plane. The margin keeps slices that lie in a face.
bool is_in_shown_part(vec3 p, float z) {
  if (!(z >= u_near_plane && z <= u_far_plane)) return false;
  vec3 inside = min(p - u_volume_low, u_volume_high - p);
  if (!(min(min(inside.x, inside.y), inside.z) >= -SLICE_MARGIN)) return false;
  for (int i = 0; i < u_clip_planes; ++i) {
    vec4 plane = u_clip_plane[i];
    if (dot(plane.xyz, p) < plane.w - SLICE_MARGIN * length(plane.xyz)) return false;
  }
  return true;
}
