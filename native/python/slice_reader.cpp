#include "native/python/slice_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

namespace py = pybind11;

namespace isosplat::python {
namespace {

uint64_t count_from(uint64_t offset, uint64_t size, uint64_t max_count) {
  return std::min(size - std::min(size, offset), max_count);
}

tl::unexpected<Error> beyond_end() {
  return fail(Status::truncated, "expected the bytes of a voxel of the array, found its end");
}

/// The bytes of an object with the buffer protocol, until the end of the scope.
class Buffer {
 public:
  explicit Buffer(const py::object& object) {
    if (PyObject_GetBuffer(object.ptr(), &view_, PyBUF_SIMPLE) != 0) throw py::error_already_set();
  }
  Buffer(const Buffer&) = delete;
  Buffer& operator=(const Buffer&) = delete;
  ~Buffer() { PyBuffer_Release(&view_); }

  std::span<const std::byte> bytes() const {
    return {static_cast<const std::byte*>(view_.buf), static_cast<size_t>(view_.len)};
  }

 private:
  Py_buffer view_{};
};

}  // namespace

Result<void> MemoryReader::read(uint64_t offset, std::span<std::byte> out) {
  if (offset > bytes_.size() || out.size() > bytes_.size() - offset) return beyond_end();
  std::memcpy(out.data(), bytes_.data() + offset, out.size());
  return {};
}

Result<uint64_t> MemoryReader::count_after(uint64_t offset, uint64_t max_count) {
  return count_from(offset, bytes_.size(), max_count);
}

Result<uint64_t> SliceReader::count_after(uint64_t offset, uint64_t max_count) {
  return count_from(offset, size_limit(), max_count);
}

Result<void> SliceReader::read(uint64_t offset, std::span<std::byte> out) {
  if (offset > size_limit() || out.size() > size_limit() - offset) return beyond_end();
  while (!out.empty()) {
    const uint64_t slice = offset / slices_.bytes;
    if (auto loaded = load(slice - slice % slices_.read_count); !loaded) return loaded;
    const auto begin = static_cast<size_t>(offset - first_ * slices_.bytes);
    const size_t count = std::min(out.size(), bytes_.size() - begin);
    std::memcpy(out.data(), bytes_.data() + begin, count);
    out = out.subspan(count);
    offset += count;
  }
  return {};
}

/// Makes bytes_ those of the slices from `first` on.
Result<void> SliceReader::load(uint64_t first) {
  if (!bytes_.empty() && first_ == first) return {};
  if (auto go_on = interruption_.check(); !go_on) return go_on;
#if PY_VERSION_HEX >= 0x030d0000
  const bool is_ending = Py_IsFinalizing();
#else
  const bool is_ending = _Py_IsFinalizing();
#endif
  // A thread that then waits for the GIL would never get it.
  if (is_ending) return fail(Status::io_error, "Python is ending");
  const py::gil_scoped_acquire gil;
  try {
    call(first, std::min(slices_.read_count, slices_.count - first));
    return {};
  } catch (...) {
    bytes_.clear();
    interruption_.set_current_exception();
    return interruption_.check();
  }
}

void SliceReader::call(uint64_t first, uint64_t count) {
  const py::object slices = read_(first, count);
  const Buffer buffer(slices);
  if (buffer.bytes().size() != count * slices_.bytes) {
    throw py::value_error(
        fmt::format("expected {} bytes for the slices {} to {} of the array, found {}: its shape "
                    "or type changed while it was read",
                    count * slices_.bytes, first, first + count - 1, buffer.bytes().size()));
  }
  bytes_.assign(buffer.bytes().begin(), buffer.bytes().end());
  first_ = first;
}

}  // namespace isosplat::python
