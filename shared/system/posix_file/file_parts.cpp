#include "shared/system/posix_file/file_parts.h"

#include <algorithm>

namespace isosplat {

FileParts::FileParts(std::shared_ptr<const RandomAccessFile> file, uint64_t bytes)
    : file_(std::move(file)), parts_{{0, 0, bytes}}, bytes_(bytes) {}

FileParts::FileParts(std::shared_ptr<const RandomAccessFile> file, std::vector<Part> parts)
    : file_(std::move(file)), parts_(std::move(parts)) {
  for (const Part& part : parts_) bytes_ += part.bytes;
}

FileParts FileParts::range(uint64_t offset, uint64_t bytes) const {
  std::vector<Part> within;
  const uint64_t range_end = offset + bytes;
  for (const Part& part : parts_) {
    const uint64_t begin = std::max(part.offset, offset);
    const uint64_t end = std::min(part.offset + part.bytes, range_end);
    if (begin >= end) continue;
    within.push_back({begin - offset, part.file_offset + (begin - part.offset), end - begin});
  }
  return {file_, std::move(within)};
}

Result<void> FileParts::read(uint64_t offset, std::span<std::byte> out, NoWait* no_wait) const {
  if (offset > bytes_ || out.size() > bytes_ - offset) {
    return fail(Status::truncated, file_->name() + ": expected " + std::to_string(out.size()) +
                                       " bytes at " + std::to_string(offset) + ", found " +
                                       std::to_string(bytes_) + " bytes in all: copy it again");
  }
  auto part = std::upper_bound(parts_.begin(), parts_.end(), offset,
                               [](uint64_t at, const Part& each) { return at < each.offset; });
  while (!out.empty()) {
    const Part& from = *(part - 1);
    const uint64_t within = offset - from.offset;
    const auto count = static_cast<size_t>(std::min<uint64_t>(out.size(), from.bytes - within));
    const auto read = file_->read(from.file_offset + within, out.first(count), no_wait);
    if (!read) return read;
    offset += count;
    out = out.subspan(count);
    ++part;
  }
  return {};
}

}  // namespace isosplat
