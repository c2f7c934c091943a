// A surface pixel: the normal in the camera's frame (octahedral, 2 x 16 bits), a scalar for colouring
// (16 bits), isosurface (14 bits) and side (2 bits). The scalar is a position in the colour map, from 0
// to 65535, or that of a field (FIELD_HIGHEST in shader_constants.h).
uvec2 encode_normal(vec3 n) {
  n /= abs(n.x) + abs(n.y) + abs(n.z);
  vec2 folded = (1.0 - abs(n.yx)) * vec2(n.x < 0.0 ? -1.0 : 1.0, n.y < 0.0 ? -1.0 : 1.0);
  vec2 e = n.z < 0.0 ? folded : n.xy;
  return uvec2(clamp(e * 32767.0 + 32768.5, 1.0, 65535.0));
}

vec3 decode_normal(uvec2 bits) {
  vec2 e = (vec2(bits) - 32768.0) / 32767.0;
  vec3 n = vec3(e, 1.0 - abs(e.x) - abs(e.y));
  if (n.z < 0.0) {
    n.xy = (1.0 - abs(n.yx)) * vec2(n.x < 0.0 ? -1.0 : 1.0, n.y < 0.0 ? -1.0 : 1.0);
  }
  return normalize(n);
}

uvec4 encode_surface(vec3 normal, float scalar, uint isosurface, int side) {
  return uvec4(encode_normal(normal), uint(clamp(scalar, 0.0, 1.0) * 65535.0 + 0.5),
               isosurface << ISOSURFACE_SHIFT | uint(side));
}

int side_of(uvec4 pixel) { return int(pixel.w & 3u); }
