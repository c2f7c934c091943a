// The farthest of a texel and those about it: occluders were enlarged, and their outlines go back to
// where they were.
uniform highp sampler2D u_depths;
layout(location = 0) out uint o_depth;

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy), last = textureSize(u_depths, 0) - 1;
  float farthest = 0.0;
  for (int y = -1; y <= 1; ++y) {
    for (int x = -1; x <= 1; ++x) {
      farthest = max(farthest, texelFetch(u_depths, clamp(at + ivec2(x, y), ivec2(0), last), 0).x);
    }
  }
  o_depth = floatBitsToUint(farthest);
}
