#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "native/remote/open_remote.h"
#include "shared/system/scene_file/scene_file.h"

namespace isosplat::cli {

/// The options of commands that read stores at addresses, or write to them.
class RemoteFlags {
 public:
  void add_to(CLI::App& command);

  remote::RemoteOptions options() const;

  /// The object at an address. The last one stays open, and is not opened again. Errors: those of
  /// remote::open_object().
  Result<std::shared_ptr<const remote::HttpFile>> object(const std::string& address) const;

 private:
  std::string endpoint_;
  unsigned timeout_s_ = remote::HttpOptions{}.stall_s;
  mutable std::shared_ptr<remote::HttpClient> client_;  // of all objects
  mutable std::string address_;
  mutable Result<std::shared_ptr<const remote::HttpFile>> object_;  // at address_
};

/// The number of threads that read and decode a store. `threads`: that of --threads; 0: one per
/// core, but at least 8 for an address, because threads that wait for a network need no core.
unsigned threads_for(const std::string& path, unsigned threads);

/// Whether a path or an address has a scene: see isosplat::scene_kind(). None if it cannot be read.
SceneKind scene_kind(const std::string& path, const RemoteFlags& flags);

/// Opens the scene at a path, or the bundle at an address. Errors: those of SceneFile::open() and
/// RemoteFlags::object(); invalid_argument for a document at an address.
Result<SceneFile> open_scene(const std::string& path, const RemoteFlags& flags);

/// Opens the store at a path or an address. Errors: those of StoreFile::open(),
/// RemoteFlags::object() and remote::open_store().
Result<std::shared_ptr<StoreFile>> open_store(const std::string& path, const RemoteFlags& flags);

}  // namespace isosplat::cli
