// Eye-dome lighting of a picture whose surfaces are lit already.
uniform sampler2D u_picture;
layout(location = 0) out vec4 o_colour;

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  o_colour = texelFetch(u_picture, at, 0);
  float depth = depth_at(at, 0);
  // A loop that runs once or never: software renderers skip loops, but not branches, where no pixel
  // of a group needs them.
  for (int turn = depth < 1.0 ? 0 : 1; turn < 1; ++turn) {
    o_colour.rgb = from_linear(eye_dome(at, 0, distance_of(depth)) * to_linear(o_colour.rgb));
  }
}
