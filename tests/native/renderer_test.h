#pragma once

#include <gtest/gtest.h>

#include <memory>

#include "native/headless/egl_context.h"
#include "shared/render/renderer.h"

namespace isosplat {

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

  /// What the tests of a class have in common: called when the renderer is there.
  virtual void prepare() {}

  std::unique_ptr<EglContext> context_;
  std::unique_ptr<Renderer> renderer_;
};

}  // namespace isosplat
