#include "native/labels/label_rows.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>

#include <cstring>
#include <utility>

#include "shared/system/posix_file/posix_file.h"

namespace isosplat {

Result<LabelRows> LabelRows::create(Index3 size, uint64_t memory_bytes,
                                    const std::filesystem::path& folder) {
  LabelRows rows;
  rows.size_ = size;
  rows.bytes_ = sizeof(uint16_t) * static_cast<uint64_t>(size.x) * static_cast<uint64_t>(size.y) *
                static_cast<uint64_t>(size.z);
  rows.is_file_ = rows.bytes_ > memory_bytes;
  PosixFile file;  // the mapping keeps its content
  if (rows.is_file_) {
    auto created = PosixFile::create_temporary(folder);
    if (!created) return tl::unexpected(created.error());
    file = std::move(*created);
    // Reserves the space now: a full disk would end the program when a page is written.
    if (const int error = ::posix_fallocate(file.descriptor(), 0, static_cast<off_t>(rows.bytes_));
        error != 0) {
      return fail(
          Status::io_error,
          fmt::format("{}: expected space for {} bytes of labels ({}): free some, or choose "
                      "another folder with --temporary-folder",
                      folder.string(), rows.bytes_, std::strerror(error)));
    }
  }
  void* const mapped = ::mmap(nullptr, rows.bytes_, PROT_READ | PROT_WRITE,
                              rows.is_file_ ? MAP_SHARED : MAP_PRIVATE | MAP_ANONYMOUS,
                              rows.is_file_ ? file.descriptor() : -1, 0);
  if (mapped == MAP_FAILED) {
    return fail(Status::out_of_memory,
                fmt::format("the system refused {} bytes for labels: close other programs, or "
                            "reduce --memory",
                            rows.bytes_));
  }
  rows.labels_ = static_cast<uint16_t*>(mapped);
  return rows;
}

LabelRows::LabelRows(LabelRows&& other) noexcept
    : size_(other.size_),
      bytes_(other.bytes_),
      is_file_(other.is_file_),
      labels_(std::exchange(other.labels_, nullptr)) {}

LabelRows::~LabelRows() {
  if (labels_) ::munmap(labels_, bytes_);
}

uint16_t* LabelRows::row(int32_t y, int32_t z) {
  const size_t number =
      static_cast<size_t>(z) * static_cast<size_t>(size_.y) + static_cast<size_t>(y);
  return labels_ + number * static_cast<size_t>(size_.x);
}

LabelVolume LabelRows::volume() const {
  return {{labels_, static_cast<size_t>(bytes_ / sizeof(uint16_t))}, size_};
}

}  // namespace isosplat
