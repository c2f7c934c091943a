// The pixel's ray. It starts beside a cell's centre, since positions relative to the centre are
// precise at any distance from the eye. The centres of large cells (PULLED) may be beside the eye
// or behind it, and then have no image position.
struct Ray {
  vec3 origin;     // on the plane through the centre that faces the camera, minus the centre
  vec3 direction;  // one unit along the view
};

Ray pixel_ray(vec4 centre) {
  return Ray(point_at(gl_FragCoord.xy, centre.w) - centre.xyz, ray_at(gl_FragCoord.xy));
}

// The same, if the centre has an image position.
Ray pixel_ray(vec4 centre, vec2 centre_px) {
  vec2 offset = (gl_FragCoord.xy - centre_px) * u_per_focal_px;
  vec3 across = u_step_right.xyz * offset.x + u_step_up.xyz * offset.y;
#ifdef ORTHOGRAPHIC
  return Ray(across, u_step_forward.xyz);
#else
  return Ray(across * centre.w, centre.xyz / centre.w + across);
#endif
}

#ifdef CLIPPED
// Clips the interval (between.x, between.y) of the ray to the clip planes.
vec2 clip_ray(Ray ray, vec3 centre, vec2 between) {
  for (int i = 0; i < u_clip_planes; ++i) {
    float inside = dot(u_clip_plane[i].xyz, ray.origin + centre) - u_clip_plane[i].w;
    float along = dot(u_clip_plane[i].xyz, ray.direction);
    float t = -inside / along;
    if (along > 0.0) between.x = max(between.x, t);
    else if (along < 0.0) between.y = min(between.y, t);
    else if (inside < 0.0) between.y = between.x - 1.0;
  }
  return between;
}
#endif
