#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>

#include "shared/base/status.h"
#include "shared/store/store_reader.h"

namespace isosplat::cli {

/// Prints an error as one line on stderr, and returns the exit code for it: kUsage where options do
/// not fit (invalid_argument), else kFailure.
int report(const Error& error);

/// From now on notes and progress are not printed; errors are.
void be_quiet();

/// Prints "note: …" on stderr.
void note(std::string_view text);

/// Why a volume has no isosurface at an isovalue: "no isosurface at …: …"; empty where its values
/// lie on both sides of it.
std::string no_isosurface(const StoreInfo& info, double isovalue);

/// "5.87 MB", "12 bytes": decimal units.
std::string in_bytes(uint64_t bytes);

/// "2 min 5 s", "3.4 s".
std::string in_seconds(double seconds);

/// "8,388,608".
std::string with_commas(uint64_t number);

/// How far a task is, on stderr: a bar that is drawn anew on a terminal, plain lines otherwise.
class ProgressLine {
 public:
  /// `label`: what is being done, e.g. "Building engine.isosplat".
  explicit ProgressLine(std::string label);
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;

  /// `fraction` 0 to 1; `detail` such as a rate. Draws at most ten times a second, and without a
  /// terminal at most at each tenth of the way.
  void show(double fraction, std::string_view detail);

  /// Removes the bar, so that a result can be printed in its place.
  void clear();

 private:
  std::string label_;
  bool terminal_;
  bool drawn_ = false;
  int tenth_ = -1;
  std::chrono::steady_clock::time_point last_{};
};

}  // namespace isosplat::cli
