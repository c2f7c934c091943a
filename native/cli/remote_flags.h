#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "native/remote/open_remote.h"

namespace isosplat::cli {

/// The options of commands that read stores at addresses, or write to them.
class RemoteFlags {
 public:
  void add_to(CLI::App& command);

  remote::RemoteOptions options() const;

 private:
  std::string endpoint_;
  unsigned timeout_s_ = remote::HttpOptions{}.stall_s;
};

/// The number of threads that read and decode a store. `threads`: that of --threads; 0: one per
/// core, but at least 8 for an address, because threads that wait for a network need no core.
unsigned threads_for(const std::string& path, unsigned threads);

/// Opens the store at a path or an address. Errors: those of StoreFile::open() and
/// open_remote_store().
Result<std::shared_ptr<StoreFile>> open_store(const std::string& path, const RemoteFlags& flags);

}  // namespace isosplat::cli
