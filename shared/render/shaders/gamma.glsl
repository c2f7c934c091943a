// Light is added up in linear colours. Colours are sRGB; they are decoded by a gamma of 2 instead of
// sRGB's own curve, which is cheap, and exact where nothing is added: of a shaded colour at most 10
// of 255 differ from what sRGB's curve gives.
vec3 to_linear(vec3 c) { return c * c; }
vec3 from_linear(vec3 c) { return sqrt(c); }

// A linear colour that is multiplied by its alpha, in the picture's own coding: still multiplied,
// as canvases want it.
vec4 apply_gamma(vec4 linear) {
  vec3 straight = linear.a > 0.0 ? linear.rgb / linear.a : vec3(0.0);
  return vec4(from_linear(clamp(straight, 0.0, 1.0)) * linear.a, linear.a);
}

// 8 bits each, as pictures have them.
uint pack_colour(vec3 colour) {
  uvec3 bits = uvec3(colour * 255.0 + 0.5);
  return bits.r | bits.g << 8 | bits.b << 16;
}
vec3 unpack_colour(uint bits) { return vec3(uvec3(bits, bits >> 8, bits >> 16) & 255u) / 255.0; }
