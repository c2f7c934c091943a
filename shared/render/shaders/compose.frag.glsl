// Lights the surface pixels of all layers, and blends the layers by depth. A layer holds the nearest
// surface of one translucent isosurface, or of all opaque ones. At most nine layers are sorted at each
// pixel, and the result does not depend on the order of drawing.
uniform highp usampler2DArray u_surfaces;
#ifndef ONE_LAYER
uniform int u_layers;
#endif
uniform vec4 u_background;         // linear, alpha
uniform bool u_linear;             // writes linear colours, for accumulation
layout(location = 0) out vec4 o_colour;

vec4 shade(ivec2 at, int layer, float depth) {
  uvec4 bits = texelFetch(u_surfaces, ivec3(at, layer), 0);
  uint isosurface = bits.w >> ISOSURFACE_SHIFT;
  float coverage = float(bits.w & uint(COVERAGE_MAX)) / COVERAGE_MAX;
  float z = distance_of(depth);
  vec3 base = base_colour(isosurface, float(bits.z) / 65535.0, z);
  vec3 colour = lit(decode_normal(bits.xy), eye_from(gl_FragCoord.xy), base);
#ifdef EYE_DOME
  colour *= eye_dome(at, layer, z);
#endif
  return vec4(colour, u_colour[isosurface].a * coverage);
}

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  vec3 sum = vec3(0.0);
  float through = 1.0;
#ifdef ONE_LAYER
  float depth = depth_at(at, 0);
  // A loop that runs at most once: software renderers skip a loop that no pixel of a group runs, but
  // not a branch.
  for (int turn = depth < 1.0 ? 0 : 1; turn < 1; ++turn) {
    vec4 colour = shade(at, 0, depth);
    sum = colour.a * colour.rgb;
    through = 1.0 - colour.a;
  }
#else
  float last = -1.0;
  int last_layer = -1;
  for (int turn = 0; turn < MAX_LAYERS; ++turn) {
    if (turn >= u_layers || through < 0.002) break;
    float nearest = 1.0;
    int layer = -1;
    for (int i = 0; i < MAX_LAYERS; ++i) {
      if (i >= u_layers) break;
      float depth = depth_at(at, i);
      bool behind = depth > last || (depth == last && i > last_layer);
      if (behind && depth < nearest) {
        nearest = depth;
        layer = i;
      }
    }
    if (layer < 0) break;
    vec4 colour = shade(at, layer, nearest);
    sum += through * colour.a * colour.rgb;
    through *= 1.0 - colour.a;
    last = nearest;
    last_layer = layer;
  }
#endif
  float alpha = 1.0 - through + through * u_background.a;
  vec4 linear = vec4(sum + through * u_background.a * u_background.rgb, alpha);
  o_colour = u_linear ? min(linear, 1.0) : apply_gamma(linear);
}
