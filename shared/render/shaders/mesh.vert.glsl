// Draws a triangle mesh, for comparison with splats: as surface pixels, or lit at its vertices
// (LIT) like quads.
layout(location = 0) in vec3 a_position;  // world, relative to the volume's centre
layout(location = 1) in vec3 a_normal;
uniform mat4 u_clip_from_world;
uniform mat3 u_view_from_world;
#ifdef LIT
out vec3 v_colour;
#else
out vec3 v_normal;
#endif

void main() {
  gl_Position = u_clip_from_world * vec4(a_position, 1.0);
  vec3 normal = u_view_from_world * a_normal;
#ifdef LIT
  vec3 ndc = gl_Position.xyz / gl_Position.w;
  float z = distance_of(0.5 + 0.5 * ndc.z);
  vec3 to_eye = eye_from((0.5 + 0.5 * ndc.xy) * u_image_size);
  vec3 light = lit(normalize(normal), to_eye, base_colour(0u, 0.0, z));
  v_colour = apply_gamma(vec4(light, 1.0)).rgb;
#else
  v_normal = normal;
#endif
}
