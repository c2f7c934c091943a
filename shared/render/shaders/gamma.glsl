// Light is added in linear colours. Colours are encoded by the sRGB transfer function (light.h).
// Two roots approximate its power function with an error of at most 0.1/255. Quads are lit at each
// vertex, where pow() would cost a software renderer more time than all other lighting.
vec3 from_linear(vec3 c) {
  vec3 root = sqrt(c);
  vec3 curve = 0.833718 * root + 0.298142 * sqrt(root) - 0.055309 * c - 0.076912;
  return mix(curve, 12.92 * c, lessThanEqual(c, vec3(0.0031308)));
}
vec3 to_linear(vec3 c) {
  return mix(pow((c + 0.055) / 1.055, vec3(2.4)), c / 12.92, lessThanEqual(c, vec3(0.04045)));
}

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
