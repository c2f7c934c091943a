#include "native/build/slice_store.h"

#include <fcntl.h>
#include <unistd.h>

#include <utility>

#include "native/files/file_io.h"

namespace isosplat {

Result<SliceStore> SliceStore::create(size_t slice_bytes, int32_t slices, bool in_memory,
                                      const std::filesystem::path& folder) {
  SliceStore store;
  store.slice_bytes_ = slice_bytes;
  if (in_memory) {
    store.memory_.resize(slice_bytes * static_cast<size_t>(slices));
    return store;
  }
  std::string name = (folder / ".isosplat-spool-XXXXXX").string();
  store.file_ = ::mkostemp(name.data(), O_CLOEXEC);
  if (store.file_ < 0) return system_error("create a temporary file in", folder);
  ::unlink(name.c_str());
  return store;
}

SliceStore::SliceStore(SliceStore&& other) noexcept {
  *this = std::move(other);
}

SliceStore& SliceStore::operator=(SliceStore&& other) noexcept {
  std::swap(slice_bytes_, other.slice_bytes_);
  std::swap(memory_, other.memory_);
  std::swap(file_, other.file_);
  std::swap(prepared_first_, other.prepared_first_);
  std::swap(prepared_count_, other.prepared_count_);
  return *this;
}

SliceStore::~SliceStore() {
  if (file_ >= 0) ::close(file_);
}

std::byte* SliceStore::prepare(int32_t first, int32_t count) {
  prepared_first_ = first;
  prepared_count_ = count;
  if (file_ < 0) return memory_.data() + slice_bytes_ * static_cast<size_t>(first);
  memory_.resize(slice_bytes_ * static_cast<size_t>(count));
  return memory_.data();
}

Result<void> SliceStore::commit() {
  if (file_ < 0) return {};
  const size_t bytes = slice_bytes_ * static_cast<size_t>(prepared_count_);
  return write_fully(file_, slice_bytes_ * static_cast<uint64_t>(prepared_first_),
                     std::span(memory_).first(bytes), "a temporary file");
}

Result<const std::byte*> SliceStore::load(int32_t first, int32_t count) {
  if (file_ < 0) return memory_.data() + slice_bytes_ * static_cast<size_t>(first);
  memory_.resize(slice_bytes_ * static_cast<size_t>(count));
  if (auto read = read_fully(file_, slice_bytes_ * static_cast<uint64_t>(first), memory_,
                             "a temporary file");
      !read) {
    return tl::unexpected(read.error());
  }
  return memory_.data();
}

}  // namespace isosplat
