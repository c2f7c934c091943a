// Adds eye-dome lighting to a lit picture.
uniform sampler2D u_picture;
layout(location = 0) out vec4 o_colour;

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  o_colour = texelFetch(u_picture, at, 0);
  float depth = depth_at(at, 0);
  // A loop that runs at most once: software renderers skip a loop that no pixel of a group runs, but
  // not a branch.
  for (int turn = depth < 1.0 ? 0 : 1; turn < 1; ++turn) {
    o_colour.rgb = from_linear(eye_dome(at, 0, distance_of(depth)) * to_linear(o_colour.rgb));
  }
}
