#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>

#include "shared/core/base/status.h"
#include "shared/core/store/store_reader.h"

namespace isosplat::cli {

/// Prints an error as one line on stderr. Returns its exit code: kUsage for invalid_argument, else
/// kFailure.
int report(const Error& error);

/// Suppresses notes and progress from now on, but not errors.
void set_quiet();

/// The text for a terminal. Names and notes come from files of strangers: control characters, which
/// could change what a terminal shows, are replaced.
std::string printable(std::string_view text);

/// Prints "note: …" on stderr.
void note(std::string_view text);

/// The reason why a volume has no isosurface at an isovalue: "no isosurface at …: …". Empty if some
/// values of the volume are below the isovalue and others are not.
std::string no_isosurface(const StoreInfo& info, double isovalue);

/// "5.87 MB", "12 bytes": decimal units.
std::string format_bytes(uint64_t bytes);

/// "2 min 5 s", "3.4 s".
std::string format_seconds(double seconds);

/// "8,388,608".
std::string with_commas(uint64_t number);

/// Progress of a task on stderr: a bar on a terminal, otherwise plain lines.
class ProgressLine {
 public:
  /// `label`: the task, such as "Building engine.isosplat".
  explicit ProgressLine(std::string label);
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;

  /// `fraction`: 0 to 1. `detail`: the phase or a rate. A bar is drawn at most ten times a second;
  /// lines are printed at each tenth of the task.
  void show(double fraction, std::string_view detail);

  /// Erases the bar, so that a result can be printed in its line.
  void clear();

 private:
  std::string label_;
  bool terminal_;
  bool drawn_ = false;
  int tenth_ = -1;
  std::chrono::steady_clock::time_point last_{};
};

}  // namespace isosplat::cli
