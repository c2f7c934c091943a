#include "native/builder/file_slices.h"

#include <utility>

#include "shared/system/posix_file/posix_file.h"

namespace isosplat {
namespace {

class FileSlices : public SliceStore {
 public:
  FileSlices(PosixFile file, size_t item_bytes, const LevelBox& level)
      : file_(std::move(file)), item_bytes_(item_bytes), level_(level) {}

  HeldBox<std::byte> prepare(const LevelBox& box) override {
    box_ = box;
    make_room(buffer_, item_bytes_ * box.count());
    return {buffer_.data(), box};
  }

  Result<void> commit() override {
    return for_each_slice(box_, [&](uint64_t offset, std::span<std::byte> items) {
      return file_.write(offset, items);
    });
  }

  Result<HeldBox<const std::byte>> load(const LevelBox& box) override {
    make_room(buffer_, item_bytes_ * box.count());
    auto read = for_each_slice(box, [&](uint64_t offset, std::span<std::byte> items) {
      return file_.read(offset, items);
    });
    if (!read) return tl::unexpected(read.error());
    return HeldBox<const std::byte>{buffer_.data(), box};
  }

 private:
  /// Calls part(offset in the file, items in the buffer) for the rows of each slice of a box.
  template <class Part>
  Result<void> for_each_slice(const LevelBox& box, Part part) {
    const size_t bytes =
        item_bytes_ * static_cast<size_t>(box.size.x) * static_cast<size_t>(box.size.y);
    for (int32_t z = 0; z < box.size.z; ++z) {
      const size_t first = level_.at({box.first.x, box.first.y, box.first.z + z});
      const auto items = std::span(buffer_).subspan(bytes * static_cast<size_t>(z), bytes);
      if (auto done = part(item_bytes_ * uint64_t{first}, items); !done) return done;
    }
    return {};
  }

  PosixFile file_;
  const size_t item_bytes_;
  const LevelBox level_;
  std::vector<std::byte> buffer_;  // of the last prepare() or load()
  LevelBox box_ = {};              // of the last prepare()
};

}  // namespace

Result<std::unique_ptr<SliceStore>> FileSliceStorage::create(size_t item_bytes,
                                                             const LevelBox& level) {
  auto file = PosixFile::create_temporary(folder_);
  if (!file) return tl::unexpected(file.error());
  return std::make_unique<FileSlices>(std::move(*file), item_bytes, level);
}

}  // namespace isosplat
