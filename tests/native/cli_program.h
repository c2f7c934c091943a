#pragma once

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "tests/native/test_files.h"

// Runs the program as a process.
namespace isosplat::test {

struct Ended {
  int exit_code = -1;  ///< −1: the program was ended by a signal
  int signal = 0;      ///< the signal that ended it; 0: none
  std::string out, err;
  uint64_t peak_bytes = 0;  ///< of its memory, or the memory of the test before it
};

struct Call {
  std::vector<std::string> arguments;
  uint64_t file_limit = 0;        ///< largest file that it may write, in bytes; 0: no limit
  std::string cache{};            ///< XDG_CACHE_HOME
  bool ignores_hangup = false;    ///< as after nohup
  bool draws_thumbnails = false;  ///< which takes longer than building a small volume
  std::string program = ISOSPLAT_PROGRAM;
};

/// Starts the program with its output in two files.
inline pid_t start(const Call& call, const std::string& out, const std::string& err) {
  const pid_t child = fork();
  if (child != 0) return child;
  const auto redirect = [](const std::string& path, int to) {
    dup2(open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600), to);
  };
  redirect(out, 1);
  redirect(err, 2);
  if (call.file_limit > 0) {
    const rlimit limit{call.file_limit, call.file_limit};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  if (call.ignores_hangup) ::signal(SIGHUP, SIG_IGN);
  if (!call.draws_thumbnails) setenv("ISOSPLAT_NO_THUMBNAIL", "1", 1);
  if (!call.cache.empty()) setenv("XDG_CACHE_HOME", call.cache.c_str(), 1);
  std::vector<char*> arguments;
  std::string program = call.program;
  arguments.push_back(program.data());
  std::vector<std::string> copies = call.arguments;
  for (std::string& argument : copies) arguments.push_back(argument.data());
  arguments.push_back(nullptr);
  execv(program.c_str(), arguments.data());
  _exit(127);
}

/// Waits for the end of a started program.
inline Ended wait_for(pid_t child, const std::string& out, const std::string& err) {
  int status = 0;
  rusage usage{};
  wait4(child, &status, 0, &usage);
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, WIFSIGNALED(status) ? WTERMSIG(status) : 0,
          read_file(out), read_file(err), static_cast<uint64_t>(usage.ru_maxrss) * 1024};
}

inline Ended run(const Call& call) {
  const TempFolder folder;
  return wait_for(start(call, folder / "out", folder / "err"), folder / "out", folder / "err");
}

inline Ended run(std::vector<std::string> arguments) {
  return run(Call{.arguments = std::move(arguments)});
}

/// A ball in a cube of n³ voxels, as raw bytes: value 200 − distance from the centre · 300 / n.
inline std::string ball(int n) {
  std::string voxels;
  for (int z = 0; z < n; ++z) {
    for (int y = 0; y < n; ++y) {
      for (int x = 0; x < n; ++x) {
        const double half = (n - 1) / 2.0;
        const double r = std::hypot(x - half, y - half, z - half);
        voxels.push_back(static_cast<char>(std::max(0.0, 200 - r * 300 / n)));
      }
    }
  }
  return voxels;
}

/// A cube of n³ voxels as raw bytes, x fastest. `voxel`: the value at an index.
template <class T>
std::string cube(int n, const std::function<double(int)>& voxel) {
  std::string voxels;
  for (int i = 0; i < n * n * n; ++i) {
    const auto value = static_cast<T>(voxel(i));
    voxels.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  return voxels;
}

/// Writes a cube of n³ voxels as NRRD, and returns its path. `type`: NRRD's name of their type.
inline std::string write_cube(const TempFolder& folder, const std::string& name,
                              const std::string& type, int n, const std::string& voxels) {
  const std::string path = folder / name;
  write_file(path, fmt::format("NRRD0004\ntype: {1}\ndimension: 3\nsizes: {0} {0} {0}\n"
                               "encoding: raw\nendian: little\n\n",
                               n, type) +
                       voxels);
  return path;
}

inline std::string write_ball(const TempFolder& folder, int n, const std::string& name = "ball") {
  const std::string path = folder / (name + ".nrrd");
  write_file(path, fmt::format("NRRD0004\ntype: uint8\ndimension: 3\nsizes: {} {} {}\n"
                               "spacings: 1 1 2\nencoding: raw\n\n",
                               n, n, n) +
                       ball(n));
  return path;
}

/// Starts the program, waits until it prints that it is ready and has logged `awaited`, calls a
/// function, stops the program by SIGTERM, and returns its output.
inline Ended serve_and_stop(const Call& call, const std::function<void(pid_t)>& meanwhile = {},
                            const std::string& awaited = {}) {
  const TempFolder folder;
  const std::string out = folder / "out", err = folder / "err";
  const pid_t child = start(call, out, err);
  while (read_file(out).find("Isosplat is ready: http://") == std::string::npos ||
         read_file(err).find(awaited) == std::string::npos) {
    siginfo_t ended{};
    waitid(P_PID, static_cast<id_t>(child), &ended, WEXITED | WNOHANG | WNOWAIT);
    if (ended.si_pid == child) return wait_for(child, out, err);
    usleep(10'000);
  }
  if (meanwhile) meanwhile(child);
  kill(child, SIGTERM);
  return wait_for(child, out, err);
}

/// As serve_and_stop. A server reads its stores while it serves: a test that expects what is logged
/// about them must wait for it, or the server may stop first.
inline Ended serve_until_logged(const Call& call, const std::string& awaited) {
  return serve_and_stop(call, {}, awaited);
}

}  // namespace isosplat::test
