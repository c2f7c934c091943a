// Surface pixels of all layers become the picture: light, colour, and layers over each other by
// depth. A layer holds the nearest surface of one translucent isosurface, or of all opaque ones, so
// at most nine are sorted at each pixel, and the result does not depend on the order of drawing.
uniform highp usampler2DArray u_surfaces;
uniform highp sampler2DArray u_depths;
uniform sampler2D u_colour_map;
#ifndef ONE_LAYER
uniform int u_layers;
#endif
uniform int u_colour_by;           // 0: the isosurface's colour; 1: the map at the scalar; 2: at depth
uniform vec4 u_colour[MAX_ISOSURFACES];  // linear; w: opacity
uniform vec4 u_background;         // linear, alpha
uniform vec4 u_light;              // x ambient, y specular, z eye-dome strength, w eye-dome radius px
uniform bool u_linear;             // leaves the colour linear, to be accumulated
layout(location = 0) out vec4 o_colour;

float depth_at(ivec2 at, int layer) {
  return texelFetch(u_depths, ivec3(clamp(at, ivec2(0), ivec2(u_image.xy) - 1), layer), 0).x;
}

#ifdef EYE_DOME
// Eye-dome lighting (Boucheny 2009): darkens what lies behind its neighbours in the image.
const ivec2 kAround[8] = ivec2[8](ivec2(1, 0), ivec2(2, 2), ivec2(0, 1), ivec2(-2, 2), ivec2(-1, 0),
                                  ivec2(-2, -2), ivec2(0, -1), ivec2(2, -2));
float eye_dome(ivec2 at, int layer, float z) {
  float sum = 0.0, here = log2(z);
  for (int i = 0; i < 8; ++i) {
    float depth = depth_at(at + kAround[i] * int(u_light.w), layer);
    if (depth < 1.0) sum += max(0.0, here - log2(distance_of(depth)));
  }
  return exp2(-u_light.z * 24.0 * min(sum, 0.1));
}
#else
float eye_dome(ivec2 at, int layer, float z) { return 1.0; }
#endif

float to_the_40th(float x) {
  float x2 = x * x, x4 = x2 * x2, x8 = x4 * x4, x16 = x8 * x8;
  return x16 * x16 * x8;
}

vec4 shade(ivec2 at, int layer, float depth) {
  uvec4 bits = texelFetch(u_surfaces, ivec3(at, layer), 0);
  uint isosurface = bits.w >> ISOSURFACE_SHIFT;
  float coverage = float(bits.w & uint(COVERAGE_MAX)) / COVERAGE_MAX;
  float z = distance_of(depth);
  vec3 to_eye = normalize(vec3((0.5 * u_image.xy - gl_FragCoord.xy) * u_lens.y, 1.0));
  vec3 n = decode_normal(bits.xy);
  if (dot(n, to_eye) < 0.0) n = -n;

  vec4 base = u_colour[isosurface];
  float scalar = float(bits.z) / 65535.0;
  for (int turn = u_colour_by == 0 ? 1 : 0; turn < 1; ++turn) {
    if (u_colour_by == 2) scalar = (z - u_depth.z) / (u_depth.w - u_depth.z);
    base.rgb = to_linear(texture(u_colour_map, vec2((scalar * 255.0 + 0.5) / 256.0, 0.5)).rgb);
  }
  // The headlight leaves nothing black; the key light, from the upper left, tells shapes apart.
  const vec3 key = vec3(-0.408, 0.577, 0.707);
  float diffuse = 0.45 * max(dot(n, to_eye), 0.0) + 0.55 * max(dot(n, key), 0.0);
  vec3 halfway = normalize(key + to_eye);
  float highlight = u_light.y * to_the_40th(max(dot(n, halfway), 0.0));
  float occlusion = eye_dome(at, layer, z);
  vec3 lit = occlusion * (base.rgb * (u_light.x + (1.0 - u_light.x) * diffuse) + highlight);
  return vec4(lit, base.a * coverage);
}

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  vec3 sum = vec3(0.0);
  float through = 1.0;
#ifdef ONE_LAYER
  float depth = depth_at(at, 0);
  // A loop that runs once or never: software renderers skip loops, but not branches, where no pixel
  // of a group needs them.
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
  o_colour = u_linear ? min(linear, 1.0) : picture_code(linear);
}
