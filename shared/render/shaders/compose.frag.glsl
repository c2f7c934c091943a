// Lights the surface pixels of all layers, and blends the layers by depth. A layer holds the nearest
// surface of one translucent isosurface, or of all opaque ones. At most nine layers are sorted at each
// pixel, and the result does not depend on the order of drawing.
uniform highp usampler2DArray u_surfaces;
#ifndef ONE_LAYER
uniform int u_layers;
#endif
uniform vec4 u_background;         // linear, alpha
uniform int u_cap_colour_by;       // like u_colour_by, for caps, which have no gradient, level or error
uniform bool u_slice_mapped;       // slices have the colours of the map, else grey
#ifndef STILL
uniform bool u_linear;             // writes linear colours, for accumulation
#endif
layout(location = 0) out vec4 o_colour;

// Slices are not lit: their colours stand for values.
vec3 slice_colour(uint kind, float scalar) {
  float grey = kind == uint(SLICE_VALUES) ? scalar : SLICE_GREY;
  return kind == uint(SLICE_VALUES) && u_slice_mapped ? colour_of(1, 0u, scalar, 0.0) : to_linear(vec3(grey));
}

vec4 shade(ivec2 at, int layer, float depth) {
  uvec4 bits = texelFetch(u_surfaces, ivec3(at, layer), 0);
  uint isosurface = bits.w >> ISOSURFACE_SHIFT;
  SKIPPABLE_IF(isosurface >= uint(SLICE_VALUES)) {
    return vec4(slice_colour(isosurface, float(bits.z) / 65535.0), 1.0);
  }
  float z = distance_of(depth);
  bool is_cap = side_of(bits) == SIDE_CAP;
  float scalar = float(bits.z) / 65535.0;
#ifdef FIELD
  // Caps have no values of a field.
  vec3 base = is_cap ? surface_colour(isosurface).rgb : field_colour(isosurface, scalar);
#else
  vec3 base = colour_of(is_cap ? u_cap_colour_by : u_colour_by, isosurface, scalar, z);
#endif
  // Colours that stand for values stay those of the legend.
  if (is_cap && u_cap_colour_by == 0) base *= CAP_SHADE;
  vec3 normal = decode_normal(bits.xy), to_eye = eye_from(gl_FragCoord.xy);
  float opacity = surface_colour(isosurface).a, open = 1.0, key_share = 1.0;
#ifdef STILL
  // A translucent surface blocks only the share of light that it does not transmit.
  vec3 position = position_at(gl_FragCoord.xy, z);
  vec3 facing = dot(normal, to_eye) < 0.0 ? -normal : normal;
  // u_noise_offset is evenly spaced over the pictures. The noise of a pixel adds less than one step.
  vec2 noise = fract(interleaved_noise(gl_FragCoord.xy + u_tile_corner) / STILL_PICTURES + u_noise_offset);
  SKIPPABLE_IF(u_ambient_strength > 0.0) {
    float albedo = min(dot(base, vec3(0.2126, 0.7152, 0.0722)), 0.9);
    float seen = openness(position, facing, to_eye, layer, noise);
    open = mix(1.0, with_reflections(seen, albedo), opacity * u_ambient_strength);
  }
  SKIPPABLE_IF(u_shadow_strength > 0.0) {
    key_share = mix(1.0, key_arrives(position, facing, layer, noise.y), opacity * u_shadow_strength);
  }
#endif
  vec3 colour = lit(normal, to_eye, base, open, key_share);
#ifdef EYE_DOME
  colour *= eye_dome(at, layer, z);
#endif
  return vec4(colour, opacity);
}

void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  vec3 sum = vec3(0.0);
  float through = 1.0;
#ifdef ONE_LAYER
  float depth = depth_at(at, 0);
  SKIPPABLE_IF(depth < 1.0) {
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
#ifdef STILL
  o_colour = min(linear, 1.0);  // accumulation needs linear colours
#else
  o_colour = u_linear ? min(linear, 1.0) : apply_gamma(linear);
#endif
}
