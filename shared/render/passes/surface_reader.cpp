#include <cmath>
#include <cstring>

#include "shared/render/passes/image_passes.h"
#include "shared/render/shaders/shader_constants.h"

namespace isosplat::render {
namespace {

/// The inverse of encode_normal in shaders/surface_pixel.glsl.
Vec3f decode_normal(uint32_t bits) {
  float x = (static_cast<float>(bits & 0xffff) - 32768) / 32767;
  float y = (static_cast<float>(bits >> 16) - 32768) / 32767;
  const float z = 1 - std::abs(x) - std::abs(y);
  if (z < 0) {
    const float folded = (1 - std::abs(y)) * (x < 0 ? -1.0f : 1.0f);
    y = (1 - std::abs(x)) * (y < 0 ? -1.0f : 1.0f);
    x = folded;
  }
  return Vec3f{x, y, z} * (1 / length(Vec3f{x, y, z}));
}

/// The inverse of field_scalar or category_scalar in shaders/field.glsl, or of scalar_with_lines in
/// field_lines.glsl.
void decode_field(uint32_t code, FieldStyle style, SurfacePixel& pixel) {
  using Field = SurfacePixel::Field;
  pixel.field = code <= FIELD_HIGHEST   ? Field::value
                : code == FIELD_MISSING ? Field::missing
                                        : Field::none;
  pixel.scalar = 0;
  if (pixel.field != Field::value) return;
  pixel.scalar = style == FieldStyle::categories ? static_cast<float>(code)
                 : style == FieldStyle::lines
                     ? static_cast<float>(code / (2 * LINE_TONE)) / LINES_HIGHEST
                     : static_cast<float>(code) / FIELD_HIGHEST;
}

/// From the four words that shaders/read.frag.glsl writes.
SurfacePixel decode_pixel(const uint32_t* words, float world_unit, FieldStyle style) {
  SurfacePixel pixel;
  if (words[3] == 0) return pixel;
  pixel.hit = true;
  std::memcpy(&pixel.depth, &words[2], 4);
  pixel.depth *= world_unit;
  pixel.normal = decode_normal(words[0]);
  pixel.isosurface = words[1] >> (16 + ISOSURFACE_SHIFT);
  pixel.scalar = static_cast<float>(words[1] & 0xffff) / 65535;
  if (pixel.isosurface >= SLICE_VALUES) {
    using Slice = SurfacePixel::Slice;
    pixel.slice = pixel.isosurface == SLICE_VALUES ? Slice::values : Slice::no_data;
    pixel.isosurface = 0;
  }
  pixel.cap = (words[1] >> 16 & 3) == SIDE_CAP;
  if (style != FieldStyle::none && !pixel.cap && pixel.slice == SurfacePixel::Slice::none) {
    decode_field(words[1] & 0xffff, style, pixel);
  }
  return pixel;
}

}  // namespace

Result<std::vector<SurfacePixel>> read_surface_pixels(const DrawContext& context,
                                                      float world_unit) {
  const SurfaceTargets& targets = context.targets;
  const int width = targets.width(), height = targets.height();
  const auto program = context.programs.image(ImagePass::read);
  if (!program) return tl::unexpected(program.error());
  glActiveTexture(GL_TEXTURE0);
  ImageTarget image(GL_RGBA32UI, "to read an image");
  if (auto ok = image.prepare(width, height); !ok) return tl::unexpected(ok.error());
  glBindFramebuffer(GL_FRAMEBUFFER, image.framebuffer());
  glViewport(0, 0, width, height);
  glDisable(GL_DEPTH_TEST);
  glUseProgram((*program)->name());
  glBindTexture(GL_TEXTURE_2D_ARRAY, targets.surfaces());
  glActiveTexture(GL_TEXTURE1);
  glBindTexture(GL_TEXTURE_2D_ARRAY, targets.depths());
  glBindVertexArray(context.empty_vertex_array);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glBindTexture(GL_TEXTURE_2D_ARRAY, 0);
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D_ARRAY, 0);
  std::vector<uint32_t> words(4 * static_cast<size_t>(width) * static_cast<size_t>(height));
  glReadPixels(0, 0, width, height, GL_RGBA_INTEGER, GL_UNSIGNED_INT, words.data());
  std::vector<SurfacePixel> pixels(words.size() / 4);
  for (size_t i = 0; i < pixels.size(); ++i) {
    pixels[i] = decode_pixel(&words[4 * i], world_unit, context.field_style);
  }
  return pixels;
}

}  // namespace isosplat::render
