// Lighting of a surface: light.h states the formulas and their sources. Colours are linear, vectors in
// the camera's frame.
uniform int u_colour_by;                 // 0: the isosurface's colour; 1: the map at the scalar; 2: at depth
uniform vec4 u_colour[MAX_ISOSURFACES];  // w: opacity
uniform sampler2D u_colour_map;          // decodes sRGB
uniform vec4 u_key_direction;            // w: fourth power of the roughness
uniform vec3 u_key;
uniform vec3 u_sky[3];
uniform vec4 u_rim;                      // w: strength
uniform vec3 u_shading;                  // x: strength of highlights; y, z: limits of the diffuse light

// z: distance along the view. A loop that runs at most once: software renderers skip a loop that no
// pixel of a group runs, but not a branch.
vec3 colour_of(int colour_by, uint isosurface, float scalar, float z) {
  vec3 colour = u_colour[isosurface].rgb;
  for (int turn = colour_by == 0 ? 1 : 0; turn < 1; ++turn) {
    if (colour_by == 2) scalar = (z - u_depth.z) / (u_depth.w - u_depth.z);
    vec2 place = vec2((clamp(scalar, 0.0, 1.0) * 255.0 + 0.5) / 256.0, 0.5);
    colour = textureLod(u_colour_map, place, 0.0).rgb;
  }
  return colour;
}
vec3 base_colour(uint isosurface, float scalar, float z) {
  return colour_of(u_colour_by, isosurface, scalar, z);
}

float highlight(float n_l, float n_v, float n_h, float v_h) {
  float a2 = u_key_direction.w;
  float d = (n_h * a2 - n_h) * n_h + 1.0;
  float visibility = 0.5 / (n_l * sqrt((n_v - a2 * n_v) * n_v + a2) + n_v * sqrt((n_l - a2 * n_l) * n_l + a2));
  float away = 1.0 - v_h, away_2 = away * away;
  float fresnel = 0.04 + 0.96 * away_2 * away_2 * away;
  return u_shading.x * n_l * a2 / (d * d) * visibility * fresnel;
}

// normal, to_eye: of unit length. open, key_share: shares of sky and key light that reach the surface.
vec3 lit(vec3 normal, vec3 to_eye, vec3 colour, float open, float key_share) {
  if (dot(normal, to_eye) < 0.0) normal = -normal;
  float n_l = max(dot(normal, u_key_direction.xyz), 0.0);
  float rim = u_rim.w * max(dot(normal, u_rim.xyz), 0.0);
  float up = SKY_UP_Y * normal.y + SKY_UP_Z * normal.z;
  vec3 sky = u_sky[0] + (u_sky[1] + u_sky[2] * up) * up;
  vec3 light = (sky + rim) * open + u_key * (key_share * n_l);
  float n_v = max(dot(normal, to_eye), 1e-3);
  // The half vector is the sum of both directions, of length √(2 + 2 l·v). Where the surface faces away
  // from the key light, the highlight is 0.
  float l_v = dot(u_key_direction.xyz, to_eye), per_length = inversesqrt(2.0 + 2.0 * l_v + 1e-6);
  float strength = highlight(n_l, n_v, min((n_l + n_v) * per_length, 1.0), (1.0 + l_v) * per_length);
  return colour * clamp(light, u_shading.y, u_shading.z) + u_key * (key_share * strength);
}

vec3 lit(vec3 normal, vec3 to_eye, vec3 colour) { return lit(normal, to_eye, colour, 1.0, 1.0); }
