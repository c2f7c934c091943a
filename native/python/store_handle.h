#pragma once

#include <pybind11/pybind11.h>
#include <sys/types.h>

#include <memory>
#include <string>

#include "native/extract/extract.h"
#include "shared/system/store_file/store_file.h"

namespace isosplat::python {

/// An open store. Python objects share it between threads; each function keeps the file open until
/// it returns, even if another thread closes the store.
class StoreHandle {
 public:
  /// Opens the store at a path, or at an address (native/remote/remote_target.h). Errors: those of
  /// StoreFile::open() and remote::open_object().
  static Result<StoreHandle> open(const std::string& path);

  /// An open file of this machine.
  static StoreHandle of(std::shared_ptr<StoreFile> file);

  /// Raises ValueError after close(), and RuntimeError in a child process of the one that has
  /// opened an address, since its connections are those of the parent. Requires the GIL.
  std::shared_ptr<StoreFile> file() const;

  void close() { file_.reset(); }
  bool is_open() const { return file_ != nullptr; }

  /// The number of threads to use: that given; for 0 one per core, but at least 8 for an address,
  /// because threads that wait for a network need no core.
  unsigned threads(unsigned given) const;

 private:
  std::shared_ptr<StoreFile> file_;
  bool is_remote_ = false;
  pid_t process_ = 0;  ///< that has opened it
};

}  // namespace isosplat::python
