#include "shared/import/volume/file_stamps.h"

#include <fmt/format.h>

#include <array>

#include "shared/import/volume/hash.h"

namespace isosplat::import {
namespace {

constexpr size_t kBeginning = 4096;

uint64_t checksum_of(const std::filesystem::path& path) {
  std::array<std::byte, kBeginning> bytes;
  const auto file = open_input(path);
  if (!file) return 0;
  const auto got = (*file)->read_some(0, bytes);
  return got ? hash_of({reinterpret_cast<const char*>(bytes.data()), *got}) : 0;
}

class WatchedSource : public VolumeSource {
 public:
  explicit WatchedSource(std::unique_ptr<VolumeSource> source)
      : source_(std::move(source)), stamps_(FileStamps::of(source_->files())) {}

  const VolumeHeader& header() const override { return source_->header(); }

  Result<void> read_slices(int32_t first, int32_t count, std::span<std::byte> out) override {
    return checked(source_->read_slices(first, count, out), first + count);
  }

  bool reads_rows() const override { return source_->reads_rows(); }
  Result<void> read_rows(const SliceRows& part, std::span<std::byte> out) override {
    return checked(source_->read_rows(part, out), part.first_slice + part.slices);
  }

  uint64_t resident_bytes() const override { return source_->resident_bytes(); }
  std::vector<std::filesystem::path> files() const override { return source_->files(); }

 private:
  /// The result of a read that ended before the slice `end`.
  Result<void> checked(Result<void> read, int32_t end) const {
    // A changed file explains any other error, so this error takes precedence.
    const bool is_last = end == header().grid.voxels.z;
    if (auto same = stamps_.check(is_last || !read); !same) return same;
    return read;
  }

  std::unique_ptr<VolumeSource> source_;
  FileStamps stamps_;
};

}  // namespace

FileStamps FileStamps::of(const std::vector<std::filesystem::path>& paths) {
  FileStamps stamps;
  for (const std::filesystem::path& path : paths) {
    const auto state = input_state(path);
    if (state) stamps.stamps_.push_back({path, *state, checksum_of(path)});
  }
  return stamps;
}

Result<void> FileStamps::check(bool with_checksums) const {
  for (const Stamp& before : stamps_) {
    const auto now = input_state(before.path);
    const char* what = nullptr;
    if (!now) {
      what = "was deleted";
    } else if (now->bytes != before.state.bytes) {
      what = "has a different size";
    } else if (now->modified_ns != before.state.modified_ns) {
      what = "was modified";
    } else if (with_checksums && checksum_of(before.path) != before.checksum) {
      what = "has a different beginning";
    }
    if (what) {
      return fail(Status::io_error, fmt::format("{}: the file changed while it was read (it {}): "
                                                "start again when no program writes to it",
                                                before.path.string(), what));
    }
  }
  return {};
}

std::unique_ptr<VolumeSource> watch_files(std::unique_ptr<VolumeSource> source) {
  return std::make_unique<WatchedSource>(std::move(source));
}

}  // namespace isosplat::import
