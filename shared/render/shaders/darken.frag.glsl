// Adds eye-dome lighting to a lit picture.
uniform sampler2D u_picture;
layout(location = 0) out vec4 o_colour;

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  o_colour = texelFetch(u_picture, at, 0);
  float depth = depth_at(at, 0);
  SKIPPABLE_IF(depth < 1.0) {
    o_colour.rgb = from_linear(eye_dome(at, 0, distance_of(depth)) * to_linear(o_colour.rgb));
  }
}
