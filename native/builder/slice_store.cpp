#include "native/builder/slice_store.h"

#include <utility>

namespace isosplat {

Result<SliceStore> SliceStore::create(size_t slice_bytes, int32_t slices, bool in_memory,
                                      const std::filesystem::path& folder) {
  SliceStore store;
  store.slice_bytes_ = slice_bytes;
  if (in_memory) {
    store.memory_.resize(slice_bytes * static_cast<size_t>(slices));
    return store;
  }
  auto file = PosixFile::create_temporary(folder);
  if (!file) return tl::unexpected(file.error());
  store.file_ = std::move(*file);
  return store;
}

std::byte* SliceStore::prepare(int32_t first, int32_t count) {
  prepared_first_ = first;
  prepared_count_ = count;
  if (!file_.is_open()) return memory_.data() + slice_bytes_ * static_cast<size_t>(first);
  memory_.resize(slice_bytes_ * static_cast<size_t>(count));
  return memory_.data();
}

Result<void> SliceStore::commit() {
  if (!file_.is_open()) return {};
  const size_t bytes = slice_bytes_ * static_cast<size_t>(prepared_count_);
  return file_.write(slice_bytes_ * static_cast<uint64_t>(prepared_first_),
                     std::span(memory_).first(bytes));
}

Result<const std::byte*> SliceStore::load(int32_t first, int32_t count) {
  if (!file_.is_open()) return memory_.data() + slice_bytes_ * static_cast<size_t>(first);
  memory_.resize(slice_bytes_ * static_cast<size_t>(count));
  if (auto read = file_.read(slice_bytes_ * static_cast<uint64_t>(first), memory_); !read) {
    return tl::unexpected(read.error());
  }
  return memory_.data();
}

}  // namespace isosplat
