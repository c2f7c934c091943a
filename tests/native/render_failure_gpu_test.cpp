// Failures of the driver: a picture that fails halfway does not affect the next one.
#include <EGL/egl.h>
#include <GLES3/gl3.h>
#include <gtest/gtest.h>

#include "native/headless/draw_image.h"
#include "native/headless/egl_context.h"
#include "tests/native/test_volume.h"

namespace {

/// How many more programs link before one fails; negative: all link.
int links_left = -1;

}  // namespace

// Replaces the driver's function in this test program, to report that a program does not link.
extern "C" void glGetProgramiv(GLuint program, GLenum name, GLint* value) {
  using Function = void (*)(GLuint, GLenum, GLint*);
  static const auto driver = reinterpret_cast<Function>(eglGetProcAddress("glGetProgramiv"));
  driver(program, name, value);
  if (name == GL_LINK_STATUS && links_left >= 0 && links_left-- == 0) {
    *value = GL_FALSE;
    links_left = 0;
  }
}

namespace isosplat {
namespace {

TEST(RenderFailureGpu, AFailedProgramLinkLeavesNoState) {
  auto context = EglContext::create();
  ASSERT_TRUE(context) << context.error().message;
  const TestVolume volume = sphere_volume({65, 65, 65});
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
    int failures = 0;
    for (int after = 0;; ++after) {
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
    EXPECT_GE(failures, 3);
  }
}

}  // namespace
}  // namespace isosplat
