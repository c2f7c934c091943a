// Light is added in linear colours. Colours are sRGB, decoded by a gamma of 2 instead of the sRGB
// curve. This is cheap, and exact for colours that are not shaded. Shaded colours differ from those
// of the sRGB curve by at most 10 of 255.
vec3 to_linear(vec3 c) { return c * c; }
vec3 from_linear(vec3 c) { return sqrt(c); }

// Encodes a linear, premultiplied colour. The result is premultiplied as well, as canvases expect.
vec4 apply_gamma(vec4 linear) {
  vec3 straight = linear.a > 0.0 ? linear.rgb / linear.a : vec3(0.0);
  return vec4(from_linear(clamp(straight, 0.0, 1.0)) * linear.a, linear.a);
}

// 8 bits per channel.
uint pack_colour(vec3 colour) {
  uvec3 bits = uvec3(colour * 255.0 + 0.5);
  return bits.r | bits.g << 8 | bits.b << 16;
}
vec3 unpack_colour(uint bits) { return vec3(uvec3(bits, bits >> 8, bits >> 16) & 255u) / 255.0; }
