// Lighting of a surface: light.h states the formulas and their sources. Colours are linear, vectors in
// the camera's frame.
uniform int u_colour_by;                 // 0: the isosurface's colour; 1: the map at the scalar; 2: the map at the depth
#ifdef MANY_SURFACES
uniform highp sampler2D u_colours;       // of each isosurface; w: opacity
#else
uniform vec4 u_colour[MAX_ISOSURFACES];  // w: opacity
#endif
uniform sampler2D u_colour_map;          // decodes sRGB; the first row; the others: colours of categories
uniform vec3 u_key_direction;
uniform float u_roughness_4;             // fourth power of the roughness
uniform vec3 u_key;
uniform vec3 u_sky[3];
uniform vec3 u_rim_direction;
uniform float u_rim_strength, u_highlight_strength;
uniform float u_least_light, u_most_light;  // limits of the diffuse light

vec4 surface_colour(uint isosurface) {
#ifdef MANY_SURFACES
  return texelFetch(u_colours, ivec2(isosurface % uint(COLOURS_WIDTH), isosurface / uint(COLOURS_WIDTH)), 0);
#else
  return u_colour[isosurface];
#endif
}

// z: distance along the view.
vec3 colour_of(int colour_by, uint isosurface, float scalar, float z) {
  vec3 colour = surface_colour(isosurface).rgb;
  SKIPPABLE_IF(colour_by != 0) {
    if (colour_by == 2) scalar = (z - u_near_plane) / (u_far_plane - u_near_plane);
    float row = 0.5 / float(textureSize(u_colour_map, 0).y);
    vec2 place = vec2((clamp(scalar, 0.0, 1.0) * 255.0 + 0.5) / 256.0, row);
    colour = textureLod(u_colour_map, place, 0.0).rgb;
  }
  return colour;
}
#ifdef FIELD
uniform vec3 u_missing_colour;
uniform float u_field_steps;  // colours of the map; 0: all of them

// scalar: as that of surface pixels, 0 to 1 (field.glsl). Without values it is the isosurface's colour.
vec3 field_colour(uint isosurface, float scalar) {
#ifdef CATEGORIES
  float code = floor(scalar * 65535.0 + 0.5);
  int index = int(min(code, float(FIELD_HIGHEST)));
  vec3 mapped = texelFetch(u_colour_map, ivec2(index & 255, 1 + (index >> 8)), 0).rgb;
#else
#ifdef LINES
  // The bits of field_lines.glsl.
  float code = floor(scalar * 65535.0 + 0.5), index = floor((code + 0.5) / float(2 * LINE_TONE));
  float position = index / float(LINES_HIGHEST), line = code - index * float(2 * LINE_TONE);
  bool is_dark = line > float(LINE_TONE) - 0.5;
  float coverage = (line - (is_dark ? float(LINE_TONE) : 0.0)) / float(LINE_TONE - 1);
#else
  float code = scalar * 65535.0, position = code / float(FIELD_HIGHEST);
#endif
  SKIPPABLE_IF(u_field_steps > 1.0) {
    position = min(floor(position * u_field_steps), u_field_steps - 1.0) / (u_field_steps - 1.0);
  }
  vec3 mapped = colour_of(1, isosurface, position, 0.0);
#ifdef LINES
  // Between roots, as encoded colours are: bright lines then look as wide as dark ones.
  vec3 root = mix(sqrt(mapped), vec3(is_dark ? 0.0 : 1.0), float(LINE_OPACITY) * coverage);
  mapped = root * root;
#endif
#endif
  return code < float(FIELD_MISSING) - 0.5 ? mapped
         : code < float(FIELD_NO_VALUES) - 0.5 ? u_missing_colour : surface_colour(isosurface).rgb;
}
#endif

vec3 base_colour(uint isosurface, float scalar, float z) {
#ifdef FIELD
  return field_colour(isosurface, scalar);
#else
  return colour_of(u_colour_by, isosurface, scalar, z);
#endif
}

float highlight(float n_l, float n_v, float n_h, float v_h) {
  float a2 = u_roughness_4;
  float d = (n_h * a2 - n_h) * n_h + 1.0;
  float visibility = 0.5 / (n_l * sqrt((n_v - a2 * n_v) * n_v + a2) + n_v * sqrt((n_l - a2 * n_l) * n_l + a2));
  float away = 1.0 - v_h, away_2 = away * away;
  float fresnel = 0.04 + 0.96 * away_2 * away_2 * away;
  return u_highlight_strength * n_l * a2 / (d * d) * visibility * fresnel;
}

// normal, to_eye: of unit length. open, key_share: shares of sky and key light that reach the surface.
vec3 lit(vec3 normal, vec3 to_eye, vec3 colour, float open, float key_share) {
  if (dot(normal, to_eye) < 0.0) normal = -normal;
  float n_l = max(dot(normal, u_key_direction), 0.0);
  float rim = u_rim_strength * max(dot(normal, u_rim_direction), 0.0);
  float up = SKY_UP_Y * normal.y + SKY_UP_Z * normal.z;
  vec3 sky = u_sky[0] + (u_sky[1] + u_sky[2] * up) * up;
  vec3 light = (sky + rim) * open + u_key * (key_share * n_l);
  float n_v = max(dot(normal, to_eye), 1e-3);
  // The half vector is the sum of both directions, of length √(2 + 2 l·v). Where the surface faces away
  // from the key light, the highlight is 0.
  float l_v = dot(u_key_direction, to_eye), per_length = inversesqrt(2.0 + 2.0 * l_v + 1e-6);
  float strength = highlight(n_l, n_v, min((n_l + n_v) * per_length, 1.0), (1.0 + l_v) * per_length);
  return colour * clamp(light, u_least_light, u_most_light) + u_key * (key_share * strength);
}

vec3 lit(vec3 normal, vec3 to_eye, vec3 colour) { return lit(normal, to_eye, colour, 1.0, 1.0); }
