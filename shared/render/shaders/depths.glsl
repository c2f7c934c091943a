// Depths of the layers of surface pixels.
uniform highp sampler2DArray u_depths;

float depth_at(ivec2 at, int layer) {
  return texelFetch(u_depths, ivec3(clamp(at, ivec2(0), ivec2(u_image_size) - 1), layer), 0).x;
}
