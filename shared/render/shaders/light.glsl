// Lighting of a surface. Colours are linear.
uniform int u_colour_by;                 // 0: the isosurface's colour; 1: the map at the scalar; 2: at depth
uniform vec4 u_colour[MAX_ISOSURFACES];  // w: opacity
uniform vec4 u_light;                    // x ambient, y specular, z eye-dome strength, w eye-dome radius px
uniform sampler2D u_colour_map;

// z: distance along the view. A loop that runs at most once: software renderers skip a loop that no
// pixel of a group runs, but not a branch.
vec3 base_colour(uint isosurface, float scalar, float z) {
  vec3 colour = u_colour[isosurface].rgb;
  for (int turn = u_colour_by == 0 ? 1 : 0; turn < 1; ++turn) {
    if (u_colour_by == 2) scalar = (z - u_depth.z) / (u_depth.w - u_depth.z);
    vec2 place = vec2((clamp(scalar, 0.0, 1.0) * 255.0 + 0.5) / 256.0, 0.5);
    colour = to_linear(textureLod(u_colour_map, place, 0.0).rgb);
  }
  return colour;
}

// Direction from an image position to the eye, in the camera's frame.
vec3 eye_from(vec2 px) { return normalize(vec3((0.5 * u_image.xy - px) * u_lens.y, 1.0)); }

float to_the_40th(float x) {
  float x2 = x * x, x4 = x2 * x2, x8 = x4 * x4, x16 = x8 * x8;
  return x16 * x16 * x8;
}

// The headlight avoids black surfaces; the key light, from the upper left, shows shape. Both sides of
// a surface are lit.
/// normal, to_eye: in the camera's frame, of unit length.
vec3 lit(vec3 normal, vec3 to_eye, vec3 colour) {
  const vec3 key = vec3(-0.408, 0.577, 0.707);
  if (dot(normal, to_eye) < 0.0) normal = -normal;
  float diffuse = 0.45 * max(dot(normal, to_eye), 0.0) + 0.55 * max(dot(normal, key), 0.0);
  float highlight = u_light.y * to_the_40th(max(dot(normal, normalize(key + to_eye)), 0.0));
  return colour * (u_light.x + (1.0 - u_light.x) * diffuse) + highlight;
}
