#include "native/headless/egl_context.h"

#include <fmt/format.h>

#include <EGL/egl.h>
#include <EGL/eglext.h>

#include <cstdlib>
#include <filesystem>
#include <string>
#include <string_view>

namespace isosplat {
namespace {

/// Mesa keeps compiled shaders below the first of these folders that is set, and writes a warning
/// to standard error if it cannot: services often have no home.
void disable_shader_cache_without_folder() {
  for (const char* name : {"MESA_SHADER_CACHE_DIR", "XDG_CACHE_HOME", "HOME"}) {
    std::error_code error;
    const char* folder = std::getenv(name);
    if (!folder) continue;
    if (std::filesystem::is_directory(folder, error)) return;
    break;
  }
  setenv("MESA_SHADER_CACHE_DISABLE", "true", 0);
}

Result<EGLDisplay> open_display() {
  const char* extensions = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
  const std::string_view offered = extensions ? extensions : "";
  const auto get_display = reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(
      eglGetProcAddress("eglGetPlatformDisplayEXT"));
  EGLint major = 0, minor = 0;
  // First a GPU, if its driver enumerates devices; then Mesa without surfaces (llvmpipe).
  if (get_display && offered.find("EGL_EXT_platform_device") != std::string_view::npos) {
    const auto query =
        reinterpret_cast<PFNEGLQUERYDEVICESEXTPROC>(eglGetProcAddress("eglQueryDevicesEXT"));
    const auto describe = reinterpret_cast<PFNEGLQUERYDEVICESTRINGEXTPROC>(
        eglGetProcAddress("eglQueryDeviceStringEXT"));
    EGLDeviceEXT devices[16];
    EGLint count = 0;
    if (query && describe && query(16, devices, &count)) {
      for (EGLint i = 0; i < count; ++i) {
        const char* text = describe(devices[i], EGL_EXTENSIONS);
        const std::string_view kind = text ? text : "";
        if (kind.find("software") != std::string_view::npos) continue;
        const EGLDisplay display = get_display(EGL_PLATFORM_DEVICE_EXT, devices[i], nullptr);
        if (display != EGL_NO_DISPLAY && eglInitialize(display, &major, &minor)) return display;
      }
    }
  }
  if (get_display && offered.find("EGL_MESA_platform_surfaceless") != std::string_view::npos) {
    const EGLDisplay display =
        get_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
    if (display != EGL_NO_DISPLAY && eglInitialize(display, &major, &minor)) return display;
  }
  return fail(Status::gl_error,
              "EGL offers no display without a window system: install Mesa's drivers "
              "(libegl1, libgl1-mesa-dri) or a GPU driver with EGL");
}

}  // namespace

Result<std::unique_ptr<EglContext>> EglContext::create() {
  disable_shader_cache_without_folder();
  const auto display = open_display();
  if (!display) return tl::unexpected(display.error());
  eglBindAPI(EGL_OPENGL_ES_API);
  const EGLint wanted[] = {EGL_RENDERABLE_TYPE, EGL_OPENGL_ES3_BIT, EGL_SURFACE_TYPE, 0, EGL_NONE};
  EGLConfig config = nullptr;
  EGLint configs = 0;
  eglChooseConfig(*display, wanted, &config, 1, &configs);
  const EGLint version[] = {EGL_CONTEXT_MAJOR_VERSION, 3, EGL_CONTEXT_MINOR_VERSION, 0, EGL_NONE};
  const EGLContext context =
      eglCreateContext(*display, configs ? config : nullptr, EGL_NO_CONTEXT, version);
  if (context == EGL_NO_CONTEXT) {
    eglTerminate(*display);
    return fail(Status::gl_error,
                fmt::format("EGL cannot create an OpenGL ES 3.0 context (error {}): install a "
                            "driver that supports it",
                            eglGetError()));
  }
  if (!eglMakeCurrent(*display, EGL_NO_SURFACE, EGL_NO_SURFACE, context)) {
    eglDestroyContext(*display, context);
    eglTerminate(*display);
    return fail(Status::gl_error,
                "EGL cannot use a context without a surface: install a newer Mesa or GPU driver");
  }
  return std::unique_ptr<EglContext>(new EglContext(*display, context));
}

EglContext::~EglContext() {
  eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  eglDestroyContext(display_, context_);
  eglTerminate(display_);
}

}  // namespace isosplat
