#include "native/import/file_stamps.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace isosplat {
namespace {

constexpr size_t kBeginning = 4096;

uint64_t checksum_of(const std::filesystem::path& path) {
  std::array<std::byte, kBeginning> bytes;
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return 0;
  const ssize_t got = ::pread(file, bytes.data(), bytes.size(), 0);
  ::close(file);
  return got < 0 ? 0 : XXH3_64bits(bytes.data(), static_cast<size_t>(got));
}

class WatchedSource : public VolumeSource {
 public:
  explicit WatchedSource(std::unique_ptr<VolumeSource> source)
      : source_(std::move(source)), stamps_(FileStamps::of(source_->files())) {}

  const VolumeHeader& header() const override { return source_->header(); }

  Result<void> read_slices(int32_t first, int32_t count, std::span<std::byte> out) override {
    auto read = source_->read_slices(first, count, out);
    // A file that has changed explains whatever else went wrong.
    const bool is_last = first + count == header().grid.voxels.z;
    if (auto same = stamps_.check(is_last || !read); !same) return same;
    return read;
  }

  uint64_t resident_bytes() const override { return source_->resident_bytes(); }
  std::vector<std::filesystem::path> files() const override { return source_->files(); }

 private:
  std::unique_ptr<VolumeSource> source_;
  FileStamps stamps_;
};

}  // namespace

bool FileStamps::look(Stamp& stamp) {
  struct stat status {};
  if (::stat(stamp.path.c_str(), &status) != 0 || !S_ISREG(status.st_mode)) return false;
  stamp.size = static_cast<uint64_t>(status.st_size);
  stamp.seconds = status.st_mtim.tv_sec;
  stamp.nanoseconds = status.st_mtim.tv_nsec;
  return true;
}

FileStamps FileStamps::of(const std::vector<std::filesystem::path>& paths) {
  FileStamps stamps;
  for (const std::filesystem::path& path : paths) {
    Stamp stamp;
    stamp.path = path;
    if (!look(stamp)) continue;
    stamp.checksum = checksum_of(path);
    stamps.stamps_.push_back(std::move(stamp));
  }
  return stamps;
}

Result<void> FileStamps::check(bool with_checksums) const {
  for (const Stamp& before : stamps_) {
    Stamp now;
    now.path = before.path;
    const char* what = nullptr;
    if (!look(now)) {
      what = "is gone";
    } else if (now.size != before.size) {
      what = "has another size";
    } else if (now.seconds != before.seconds || now.nanoseconds != before.nanoseconds) {
      what = "was written to";
    } else if (with_checksums && checksum_of(before.path) != before.checksum) {
      what = "has another beginning";
    }
    if (what) {
      return fail(Status::io_error,
                  fmt::format("{}: it changed while it was read (it {}): start again when nothing "
                              "writes to it",
                              before.path.string(), what));
    }
  }
  return {};
}

std::unique_ptr<VolumeSource> watch_files(std::unique_ptr<VolumeSource> source) {
  return std::make_unique<WatchedSource>(std::move(source));
}

}  // namespace isosplat
