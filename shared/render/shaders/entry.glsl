// Where the pixel's ray enters the part of the volume that is shown: the clip plane, and the distance
// along the view; -1 if the ray misses this part, or begins in it. With caps, clip planes bound the
// volume as well.
int entry(vec2 px, out float z) {
  vec3 ray = ray_at(px), from = point_at(px, 0.0);
  float leave = 1e30;
  int found = -1;
  z = u_near_plane;
  for (int i = 0; i < u_clip_planes; ++i) {
    float slope = dot(u_clip_plane[i].xyz, ray);
    float inside = dot(u_clip_plane[i].xyz, from) - u_clip_plane[i].w, t = -inside / slope;
    if (slope > 0.0 && t > z) {
      z = t;
      found = i;
    } else if (slope < 0.0) {
      leave = min(leave, t);
    } else if (slope == 0.0 && inside < 0.0) {
      return -1;
    }
  }
  return z < leave ? found : -1;
}
