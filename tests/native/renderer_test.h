#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <memory>
#include <string>

#include "native/headless/draw_image.h"
#include "native/headless/egl_context.h"
#include "shared/render/renderer.h"

namespace isosplat::render {

/// A test with an EGL context and a renderer in it.
class RendererTest : public testing::Test {
 protected:
  void SetUp() final {
    auto context = EglContext::create();
    ASSERT_TRUE(context) << context.error().message;
    context_ = std::move(*context);
    auto renderer = Renderer::create();
    ASSERT_TRUE(renderer) << renderer.error().message;
    renderer_ = std::move(*renderer);
    prepare();
  }
  void TearDown() final {
    renderer_.reset();
    context_.reset();
  }

  /// Prepares the renderer for all tests of a class. Called after the renderer was created.
  virtual void prepare() {}

  /// Saves a picture if ISOSPLAT_TEST_PICTURES is set to a folder.
  static void keep(const Image& image, const std::string& name) {
    if (const char* folder = std::getenv("ISOSPLAT_TEST_PICTURES")) {
      EXPECT_TRUE(write_png(std::string(folder) + "/" + name + ".png", image));
    }
  }

  /// Draws and keeps a square picture.
  Image draw_and_keep(const RenderSettings& settings, const Camera& camera, int size,
                      const std::string& name, bool still = false) {
    renderer_->set_settings(settings);
    renderer_->set_camera(camera);
    const auto image = draw_image(*renderer_, size, size, nullptr, still);
    EXPECT_TRUE(image) << image.error().message;
    if (image) keep(*image, name);
    return image.value();
  }

  std::unique_ptr<EglContext> context_;
  std::unique_ptr<Renderer> renderer_;
};

}  // namespace isosplat::render
