// Runs GLSL functions of a cell once for each of many samples.
#pragma once

#include <GLES3/gl3.h>
#include <gtest/gtest.h>

#include <array>
#include <random>
#include <string>
#include <vector>

#include "native/headless/egl_context.h"
#include "shared/core/sampling/packed_sample.h"
#include "shared/render/gl/gl_program.h"

namespace isosplat {

inline constexpr int kSamples = 1024;

inline GLuint compile(GLenum stage, const std::string& text) {
  const GLuint shader = glCreateShader(stage);
  const char* pointer = text.c_str();
  glShaderSource(shader, 1, &pointer, nullptr);
  glCompileShader(shader);
  GLint done = 0;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &done);
  char log[2048] = "";
  glGetShaderInfoLog(shader, sizeof(log), nullptr, log);
  EXPECT_TRUE(done) << log;
  return shader;
}

/// Runs `body` (which sets o_words[0] … [3] as bits of floats) once for each sample.
inline std::vector<std::array<std::array<float, 4>, 4>> run_shader(
    const std::vector<PackedSample>& samples, const std::string& body) {
  const std::string fragment =
      render::shader_text(
          "", {"cell.glsl", "crossings.glsl", "thin.glsl", "cubic.glsl", "smooth.glsl"}) +
      "uniform highp usampler2D u_samples;\n"
      "layout(location = 0) out vec4 o_0;\nlayout(location = 1) out vec4 o_1;\n"
      "layout(location = 2) out vec4 o_2;\nlayout(location = 3) out vec4 o_3;\n"
      "void main() {\n"
      "  uvec4 bits = texelFetch(u_samples, ivec2(gl_FragCoord.xy), 0);\n" +
      body + "}\n";
  const GLuint program = glCreateProgram();
  glAttachShader(program, compile(GL_VERTEX_SHADER, render::shader_text("", {"image.vert.glsl"})));
  glAttachShader(program, compile(GL_FRAGMENT_SHADER, fragment));
  glLinkProgram(program);
  glUseProgram(program);
  GLuint vertex_array = 0, framebuffer = 0, textures[5];
  glGenVertexArrays(1, &vertex_array);
  glBindVertexArray(vertex_array);
  glGenFramebuffers(1, &framebuffer);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  glGenTextures(5, textures);
  const GLenum buffers[4] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1, GL_COLOR_ATTACHMENT2,
                             GL_COLOR_ATTACHMENT3};
  for (int i = 0; i < 4; ++i) {
    glBindTexture(GL_TEXTURE_2D, textures[i]);
    glTexStorage2D(GL_TEXTURE_2D, 1, GL_RGBA32F, kSamples, 1);
    glFramebufferTexture2D(GL_FRAMEBUFFER, buffers[i], GL_TEXTURE_2D, textures[i], 0);
  }
  glDrawBuffers(4, buffers);
  EXPECT_EQ(glCheckFramebufferStatus(GL_FRAMEBUFFER), GLenum{GL_FRAMEBUFFER_COMPLETE});
  glBindTexture(GL_TEXTURE_2D, textures[4]);
  glTexStorage2D(GL_TEXTURE_2D, 1, GL_RGBA32UI, kSamples, 1);
  glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, kSamples, 1, GL_RGBA_INTEGER, GL_UNSIGNED_INT,
                  samples.data());
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  glViewport(0, 0, kSamples, 1);
  glDrawArrays(GL_TRIANGLES, 0, 3);
  std::vector<std::array<std::array<float, 4>, 4>> result(kSamples);
  std::vector<std::array<float, 4>> row(kSamples);
  for (size_t i = 0; i < 4; ++i) {
    glReadBuffer(buffers[i]);
    glReadPixels(0, 0, kSamples, 1, GL_RGBA, GL_FLOAT, row.data());
    for (size_t j = 0; j < kSamples; ++j) result[j][i] = row[j];
  }
  EXPECT_EQ(glGetError(), GLenum{GL_NO_ERROR});
  glDeleteTextures(5, textures);
  glDeleteFramebuffers(1, &framebuffer);
  glDeleteVertexArrays(1, &vertex_array);
  glDeleteProgram(program);
  return result;
}

class CellShaderTest : public ::testing::Test {
 protected:
  void SetUp() override {
    auto context = EglContext::create();
    ASSERT_TRUE(context) << context.error().message;
    context_ = std::move(*context);
    // The span of the intervals cycles, so that every corner shift from 0 to 7 occurs.
    std::mt19937 random(1);
    for (int i = 0; i < kSamples; ++i) {
      const uint32_t span = 1u << (2 + i % 15);
      const uint32_t base = random() % (65537 - span);
      CellCorners corners;
      for (QuantizedValue& corner : corners)
        corner = static_cast<QuantizedValue>(base + random() % span);
      const auto axis = [&] { return static_cast<int32_t>(random() % 64); };
      const Index3 cell{axis(), axis(), axis()};
      samples_.push_back(pack_sample(cell, corner_interval(corners), corners));
    }
  }
  void TearDown() override { context_.reset(); }

  std::unique_ptr<EglContext> context_;
  std::vector<PackedSample> samples_;
};

}  // namespace isosplat
