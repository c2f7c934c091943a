// Failures of the driver: a picture that fails halfway does not affect the next one, and chunks for
// which the GPU has no memory do not affect the others.
#include <EGL/egl.h>
#include <GLES3/gl3.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <utility>
#include <vector>

#include "native/headless/draw_image.h"
#include "native/headless/egl_context.h"
#include "shared/render/samples/sample_buffers.h"
#include "tests/native/test_volume.h"

namespace {

/// How many more programs link before one fails; negative: all link.
int links_left = -1;

/// Whether the GPU has no memory for more buffers.
bool is_full = false;
/// The next result of glGetError. Errors of the driver follow it.
GLenum next_error = GL_NO_ERROR;

template <class Function>
Function driver_function(const char* name) {
  return reinterpret_cast<Function>(eglGetProcAddress(name));
}

}  // namespace

// Replaces the driver's function in this test program, to report that a program does not link.
extern "C" void glGetProgramiv(GLuint program, GLenum name, GLint* value) {
  static const auto driver = driver_function<void (*)(GLuint, GLenum, GLint*)>("glGetProgramiv");
  driver(program, name, value);
  if (name == GL_LINK_STATUS && links_left >= 0 && links_left-- == 0) {
    *value = GL_FALSE;
    links_left = 0;
  }
}

// Replaces the driver's function as well, to report that there is no memory for a buffer.
extern "C" void glBufferData(GLenum target, GLsizeiptr size, const void* data, GLenum usage) {
  using Function = void (*)(GLenum, GLsizeiptr, const void*, GLenum);
  static const auto driver = driver_function<Function>("glBufferData");
  if (is_full) {
    next_error = GL_OUT_OF_MEMORY;
  } else {
    driver(target, size, data, usage);
  }
}

extern "C" GLenum glGetError() {
  static const auto driver = driver_function<GLenum (*)()>("glGetError");
  const GLenum error = std::exchange(next_error, GL_NO_ERROR);
  return error != GL_NO_ERROR ? error : driver();
}

namespace isosplat::render {
namespace {

TEST(RenderFailureGpu, AFailedProgramLinkLeavesNoState) {
  auto context = EglContext::create();
  ASSERT_TRUE(context) << context.error().message;
  const TestVolume volume = sphere_volume({65, 65, 65});
  int failures = 0;
  for (const SplatKind kind : {SplatKind::quad, SplatKind::ellipse, SplatKind::exact}) {
    RenderSettings settings;
    settings.kind = kind;
    settings.isosurfaces = {{5000, {1, 1, 1}, 1}, {4000, {1, 0, 0}, 0.5f}};
    const auto draw = [&](Renderer& renderer) {
      renderer.set_camera(default_camera(volume.grid, 4.0 / 3));
      show_volume(renderer, volume, 3000, 5000, 0);
      renderer.set_settings(settings);
      return draw_image(renderer, 160, 120, nullptr, /*smooth=*/true);
    };
    links_left = -1;
    const auto wanted = draw(**Renderer::create());
    ASSERT_TRUE(wanted) << wanted.error().message;
    // Each kind fails at another third of the links: the kinds share most programs, and linking
    // takes long.
    for (int after = static_cast<int>(kind) % 3;; after += 3) {
      auto renderer = Renderer::create();
      ASSERT_TRUE(renderer);
      links_left = after;
      const auto failed = draw(**renderer);
      links_left = -1;
      if (failed) break;
      ++failures;
      EXPECT_EQ(failed.error().status, Status::gl_error);
      EXPECT_FALSE(glIsEnabled(GL_BLEND)) << "kind " << int(kind) << ", link " << after;
      GLboolean depth_mask = GL_FALSE, colour_mask[4] = {};
      glGetBooleanv(GL_DEPTH_WRITEMASK, &depth_mask);
      glGetBooleanv(GL_COLOR_WRITEMASK, colour_mask);
      EXPECT_TRUE(depth_mask) << "kind " << int(kind) << ", link " << after;
      EXPECT_TRUE(colour_mask[0]) << "kind " << int(kind) << ", link " << after;
      const auto again = draw(**renderer);
      ASSERT_TRUE(again) << again.error().message;
      EXPECT_EQ(again->rgba, wanted->rgba) << "kind " << int(kind) << ", link " << after;
    }
  }
  EXPECT_GE(failures, 5);
}

TEST(RenderFailureGpu, AFullGpuLosesOnlyTheChunksThatItHasNoMemoryFor) {
  auto context = EglContext::create();
  ASSERT_TRUE(context) << context.error().message;
  const TestVolume volume = sphere_volume({65, 65, 65});
  auto created = Renderer::create();
  ASSERT_TRUE(created);
  Renderer& renderer = **created;
  renderer.set_camera(default_camera(volume.grid, 4.0 / 3));
  show_volume(renderer, volume, 3000, 5000, 0);
  RenderSettings settings;
  settings.isosurfaces = {{4000, {1, 1, 1}, 1}};
  renderer.set_settings(settings);
  FrameStatistics before;
  const auto wanted = draw_image(renderer, 160, 120, &before, /*smooth=*/false);
  ASSERT_TRUE(wanted) << wanted.error().message;

  // Inactive samples that fill the rest of the first buffer, so that another buffer is needed.
  const std::vector<PackedSample> many(SampleBuffers::kBufferSamples / 2);
  const BlockKey block{0, {0, 0, 0}};
  constexpr ChunkHandle kFits = 1000, kLost = 1001;
  is_full = true;
  EXPECT_TRUE(renderer.add_chunk(kFits, block, many));
  EXPECT_TRUE(renderer.add_chunk(kLost, block, many));
  is_full = false;
  ASSERT_TRUE(renderer.draw(160, 120));
  const auto checked = renderer.check_gpu();
  ASSERT_FALSE(checked);
  EXPECT_EQ(checked.error().status, Status::out_of_memory);

  FrameStatistics after;
  const auto again = draw_image(renderer, 160, 120, &after, /*smooth=*/false);
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(again->rgba, wanted->rgba);
  EXPECT_EQ(after.samples_resident, before.samples_resident + many.size());
  EXPECT_EQ(after.gpu_bytes, before.gpu_bytes);

  // Once there is memory again, the chunk gets a working buffer.
  EXPECT_TRUE(renderer.add_chunk(kLost, block, many));
  EXPECT_TRUE(renderer.check_gpu());
  ASSERT_TRUE(draw_image(renderer, 160, 120, &after, /*smooth=*/false));
  EXPECT_EQ(after.samples_resident, before.samples_resident + 2 * many.size());
  EXPECT_GT(after.gpu_bytes, before.gpu_bytes);
}

TEST(RenderFailureGpu, AFullGpuLosesTheValuesOfAFieldAndKeepsTheChunks) {
  auto context = EglContext::create();
  ASSERT_TRUE(context) << context.error().message;
  const TestVolume volume = sphere_volume({49, 49, 49});
  auto created = Renderer::create();
  ASSERT_TRUE(created);
  Renderer& renderer = **created;
  renderer.set_camera(default_camera(volume.grid, 4.0 / 3));
  RenderSettings settings;
  settings.isosurfaces = {{2000, {1, 1, 1}, 1}};
  settings.colour_by = ColourBy::field;
  renderer.set_settings(settings);
  const uint64_t samples = show_volume(renderer, volume, 2000, 2000, 0);
  ASSERT_TRUE(renderer.check_gpu());
  ASSERT_TRUE(renderer.set_field(ValueMapping{}));
  FrameStatistics before;
  const auto wanted = draw_image(renderer, 160, 120, &before, /*smooth=*/false);
  ASSERT_TRUE(wanted) << wanted.error().message;

  std::vector<PackedField> values(samples);
  for (PackedField& each : values) std::fill(std::begin(each.word), std::end(each.word), 1u);
  is_full = true;
  EXPECT_TRUE(renderer.set_chunk_field(0, values));
  is_full = false;
  const auto checked = renderer.check_gpu();
  ASSERT_FALSE(checked);
  EXPECT_EQ(checked.error().status, Status::out_of_memory);
  FrameStatistics after;
  const auto again = draw_image(renderer, 160, 120, &after, /*smooth=*/false);
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(again->rgba, wanted->rgba);
  EXPECT_EQ(after.samples_resident, before.samples_resident);
  EXPECT_EQ(after.gpu_bytes, before.gpu_bytes);

  // Once there is memory again, they can be added.
  EXPECT_TRUE(renderer.set_chunk_field(0, values));
  EXPECT_TRUE(renderer.check_gpu());
  const auto coloured = draw_image(renderer, 160, 120, &after, /*smooth=*/false);
  ASSERT_TRUE(coloured) << coloured.error().message;
  EXPECT_NE(coloured->rgba, wanted->rgba);
  EXPECT_GT(after.gpu_bytes, before.gpu_bytes);
}

}  // namespace
}  // namespace isosplat::render
