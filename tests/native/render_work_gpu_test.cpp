// The amount of ray casting for a picture, measured as the number of fragments, not as time.
#include <GLES3/gl3.h>
#include <gtest/gtest.h>

#include "native/headless/egl_context.h"
#include "shared/render/frame/frame.h"
#include "shared/render/gl/gl_program.h"
#include "shared/render/shaders/shader_constants.h"
#include "tests/native/test_volume.h"

namespace isosplat::render {
namespace {

void attach(GLuint program, GLenum stage, const std::string& text) {
  const GLuint shader = glCreateShader(stage);
  const char* pointer = text.c_str();
  glShaderSource(shader, 1, &pointer, nullptr);
  glCompileShader(shader);
  char log[2048] = "";
  glGetShaderInfoLog(shader, sizeof(log), nullptr, log);
  EXPECT_STREQ(log, "");
  glAttachShader(program, shader);
  glDeleteShader(shader);
}

/// Draws the block's samples as ray-cast triangles, and returns the mean number of fragments per
/// pixel. Each fragment adds 1/255 to its pixel, so pixels count up to 255.
double mean_fragments(const TestVolume& volume, double isovalue, SplatKind kind,
                      const Camera& camera, int size) {
  const auto samples = block_samples(volume, {0, {0, 0, 0}}, isovalue, isovalue);
  RenderSettings settings;
  const Frame frame(volume.grid, {bounding_sphere(volume.grid), volume.grid}, settings, camera,
                    ImageTile{size, size}, 0, 1);
  const GLuint program = glCreateProgram();
  attach(
      program, GL_VERTEX_SHADER,
      shader_text("#define PULLED\n#define KIND " + std::to_string(static_cast<int>(kind)) + "\n",
                  {"frame.glsl", "cell.glsl", "crossings.glsl", "thin.glsl", "block.glsl",
                   "splat.glsl", "splat.vert.glsl"}));
  attach(program, GL_FRAGMENT_SHADER,
         shader_text("", {}) +
             "layout(location = 0) out vec4 o_count;\n"
             "void main() { o_count = vec4(1.0 / 255.0); }\n");
  glLinkProgram(program);
  GLuint buffer = 0, vertex_array = 0, framebuffer = 0, textures[2];
  glGenBuffers(1, &buffer);
  glBindBufferBase(GL_UNIFORM_BUFFER, 0, buffer);
  glBufferData(GL_UNIFORM_BUFFER, sizeof(FrameBlock), &frame.block(), GL_STATIC_DRAW);
  glGenVertexArrays(1, &vertex_array);
  glBindVertexArray(vertex_array);
  glGenTextures(2, textures);
  glBindTexture(GL_TEXTURE_2D, textures[0]);
  glTexStorage2D(GL_TEXTURE_2D, 1, GL_RGBA8, size, size);
  glGenFramebuffers(1, &framebuffer);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, textures[0], 0);
  glBindTexture(GL_TEXTURE_2D, textures[1]);
  const int rows = static_cast<int>(samples.size() / SAMPLE_TEXTURE_WIDTH) + 1;
  std::vector<PackedSample> padded = samples;
  padded.resize(static_cast<size_t>(rows) * SAMPLE_TEXTURE_WIDTH);
  glTexStorage2D(GL_TEXTURE_2D, 1, GL_RGBA32UI, SAMPLE_TEXTURE_WIDTH, rows);
  glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, SAMPLE_TEXTURE_WIDTH, rows, GL_RGBA_INTEGER,
                  GL_UNSIGNED_INT, padded.data());
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);

  const auto uniform = [program](const char* name) { return glGetUniformLocation(program, name); };
  glUseProgram(program);
  glUniformBlockBinding(program, glGetUniformBlockIndex(program, "Frame"), 0);
  const Frame::Box box = frame.box({0, 0, 0}, {1, 1, 1});
  const Vec3d corner = box.centre - box.half;
  glUniform4f(uniform("u_block"), static_cast<float>(corner.x), static_cast<float>(corner.y),
              static_cast<float>(corner.z), 1);
  glUniform4uiv(uniform("u_regions"), 4, std::vector<GLuint>(16, ~0u).data());
  glUniform1f(uniform("u_quantized_isovalue"), volume.mapping.quantized_isovalue(isovalue));
  glUniform1i(uniform("u_samples"), 0);
  glViewport(0, 0, size, size);
  glClearColor(0, 0, 0, 0);
  glClear(GL_COLOR_BUFFER_BIT);
  glEnable(GL_BLEND);
  glBlendFunc(GL_ONE, GL_ONE);
  glDrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(6 * samples.size()));
  glDisable(GL_BLEND);
  std::vector<uint8_t> pixels(4 * static_cast<size_t>(size) * static_cast<size_t>(size));
  glReadPixels(0, 0, size, size, GL_RGBA, GL_UNSIGNED_BYTE, pixels.data());
  EXPECT_EQ(glGetError(), GLenum{GL_NO_ERROR});
  glDeleteBuffers(1, &buffer);
  glDeleteVertexArrays(1, &vertex_array);
  glDeleteFramebuffers(1, &framebuffer);
  glDeleteTextures(2, textures);
  glDeleteProgram(program);
  double sum = 0;
  for (size_t i = 0; i < pixels.size(); i += 4) sum += pixels[i];
  return sum / (double(size) * size);
}

// The camera is inside of a sphere, close to its wall. One layer of the surface is visible, and
// hundreds of cells in a ring intersect the plane through the eye.
TEST(RenderWorkGpu, CloseUpsCastFewRaysForEachPixel) {
  const auto context = EglContext::create();
  ASSERT_TRUE(context) << context.error().message;
  const TestVolume volume = sphere_volume({60, 60, 60});
  for (const double distance : {0.5, 1.5, 4.0, 12.0}) {
    for (const double azimuth : {0.0, 50.0}) {
      Camera camera;
      camera.azimuth = azimuth;
      camera.elevation = 25;
      const CameraFrame axes = camera_frame(camera);
      camera.target = Vec3d{29.5, 29.5, 29.5} + axes.forward * 25.0;
      camera.distance = distance;
      const double exact = mean_fragments(volume, 2500, SplatKind::exact, camera, 256);
      EXPECT_GE(exact, 1) << distance;  // no pixel is a hole
      EXPECT_LT(exact, 8) << distance;
    }
  }
}

}  // namespace
}  // namespace isosplat::render
