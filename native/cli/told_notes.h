#pragma once

#include <set>
#include <string>

#include "native/cli/terminal.h"

namespace isosplat::cli {

/// Prints notes above a progress line, each once.
class ToldNotes {
 public:
  void tell(const std::string& text, ProgressLine& progress) {
    if (!told_.insert(text).second) return;
    progress.clear();
    note(text);
  }

 private:
  std::set<std::string> told_;
};

}  // namespace isosplat::cli
