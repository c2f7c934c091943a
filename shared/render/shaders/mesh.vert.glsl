// A triangle mesh through the same lights, for comparison.
layout(location = 0) in vec3 a_position;  // world, relative to the volume's centre
layout(location = 1) in vec3 a_normal;
uniform mat4 u_clip_from_world;
uniform mat3 u_view_from_world;
out vec3 v_normal;

void main() {
  gl_Position = u_clip_from_world * vec4(a_position, 1.0);
  v_normal = u_view_from_world * a_normal;
}
