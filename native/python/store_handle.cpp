#include "native/python/store_handle.h"

#include <unistd.h>

#include <algorithm>
#include <thread>

#include "native/remote/open_remote.h"

namespace py = pybind11;

namespace isosplat::python {

Result<StoreHandle> StoreHandle::open(const std::string& path) {
  StoreHandle handle;
  handle.process_ = ::getpid();
  handle.is_remote_ = remote::is_address(path);
  Result<std::shared_ptr<StoreFile>> file;
  if (handle.is_remote_) {
    auto object = remote::open_object(path, {});
    if (!object) return tl::unexpected(object.error());
    file = remote::open_store(std::move(*object));
  } else {
    file = StoreFile::open(path);
  }
  if (!file) return tl::unexpected(file.error());
  handle.file_ = std::move(*file);
  return handle;
}

StoreHandle StoreHandle::of(std::shared_ptr<StoreFile> file) {
  StoreHandle handle;
  handle.process_ = ::getpid();
  handle.file_ = std::move(file);
  return handle;
}

std::shared_ptr<StoreFile> StoreHandle::file() const {
  if (!file_) throw py::value_error("the store is closed: open it again");
  if (is_remote_ && process_ != ::getpid()) {
    throw std::runtime_error(
        "the store was opened in the parent process, whose connections this process does not have: "
        "open the address again in this process");
  }
  return file_;
}

unsigned StoreHandle::threads(unsigned given) const {
  constexpr unsigned kRequests = 8;  // at the same time
  if (given > 0 || !is_remote_) return given;
  return std::max(kRequests, std::thread::hardware_concurrency());
}

}  // namespace isosplat::python
