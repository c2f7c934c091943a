#include "native/builder/file_slices.h"

#include <utility>

#include "shared/system/posix_file/posix_file.h"

namespace isosplat {
namespace {

class FileSlices : public SliceStore {
 public:
  FileSlices(PosixFile file, size_t slice_bytes)
      : file_(std::move(file)), slice_bytes_(slice_bytes) {}

  std::byte* prepare(int32_t first, int32_t count) override {
    prepared_ = first;
    buffer_.resize(slice_bytes_ * static_cast<size_t>(count));
    return buffer_.data();
  }

  Result<void> commit() override {
    return file_.write(slice_bytes_ * static_cast<uint64_t>(prepared_), buffer_);
  }

  Result<const std::byte*> load(int32_t first, int32_t count) override {
    buffer_.resize(slice_bytes_ * static_cast<size_t>(count));
    auto read = file_.read(slice_bytes_ * static_cast<uint64_t>(first), buffer_);
    if (!read) return tl::unexpected(read.error());
    return buffer_.data();
  }

 private:
  PosixFile file_;
  size_t slice_bytes_;
  std::vector<std::byte> buffer_;  // of the last prepare() or load()
  int32_t prepared_ = 0;
};

}  // namespace

Result<std::unique_ptr<SliceStore>> FileSliceStorage::create(size_t slice_bytes) {
  auto file = PosixFile::create_temporary(folder_);
  if (!file) return tl::unexpected(file.error());
  return std::make_unique<FileSlices>(std::move(*file), slice_bytes);
}

}  // namespace isosplat
