// bin/isosplat of an installation: starts the program in libexec/isosplat that was compiled for the
// newest instruction set of this machine, in the same process.
//
// There are two whole programs instead of AVX2 versions of some functions. Otherwise the linker
// could keep the AVX2 version of an inline function that other files use too, which would crash on
// a machine without AVX2. Each program is a plain build for its instruction set.

#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <string>
#include <system_error>

int main(int, char** argv) {
  std::error_code error;
  const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", error);
  if (error) {
    std::fprintf(stderr, "isosplat: cannot read /proc/self/exe (%s): mount /proc\n",
                 error.message().c_str());
    return 1;
  }
  const auto programs = self.parent_path().parent_path() / ISOSPLAT_LIBEXEC;
  const auto start = [&](const char* architecture) {
    ::execv((programs / architecture / "isosplat").c_str(), argv);
  };
  // The levels of the x86-64 psABI; libgcc checks both the processor and the operating system.
  __builtin_cpu_init();
  if (__builtin_cpu_supports("x86-64-v3")) start("x86-64-v3");
  start("x86-64");
  std::fprintf(stderr,
               "isosplat: %s: expected a program for this machine, found none (%s): "
               "install the package again\n",
               programs.c_str(), std::strerror(errno));
  return 1;
}
