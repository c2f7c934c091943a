// Triangles of cells (triangles.vert.glsl), lit at their vertices (LIT) or as surface pixels.
#ifdef LIT
in vec3 v_colour;
layout(location = 0) out vec4 o_colour;
#else
in vec3 v_normal;
in float v_scalar;
uniform uint u_isosurface;
layout(location = 0) out uvec4 o_pixel;
#endif

void main() {
#ifdef CLIPPED
  vec3 at = point_at(gl_FragCoord.xy, distance_of(gl_FragCoord.z));
  for (int i = 0; i < u_clip_planes; ++i) {
    if (dot(u_clip_plane[i].xyz, at) < u_clip_plane[i].w) discard;
  }
#endif
#ifdef LIT
  o_colour = vec4(v_colour, 1.0);
#else
  // Triangles are counter-clockwise seen from the side of lower values.
  int side = gl_FrontFacing ? SIDE_RISING : SIDE_FALLING;
  o_pixel = encode_surface(normalize(v_normal), v_scalar, u_isosurface, side);
#endif
}
