#include "native/files/spooled_bytes.h"

#include <algorithm>

namespace isosplat {

Result<SpooledBytes> SpooledBytes::create(const std::filesystem::path& folder) {
  auto file = PosixFile::create_temporary(folder.empty() ? "." : folder);
  if (!file) return tl::unexpected(file.error());
  return SpooledBytes(std::move(*file));
}

Result<void> SpooledBytes::append(std::span<const std::byte> bytes) {
  auto written = file_.write(size_, bytes);
  if (written) size_ += bytes.size();
  return written;
}

Result<void> SpooledBytes::read(
    const std::function<Result<void>(std::span<const std::byte>)>& use) const {
  constexpr uint64_t kPiece = uint64_t{1} << 20;
  std::vector<std::byte> piece;
  for (uint64_t done = 0; done < size_; done += piece.size()) {
    piece.resize(std::min(kPiece, size_ - done));
    if (auto read = file_.read(done, piece); !read) return read;
    if (auto used = use(piece); !used) return used;
  }
  return {};
}

}  // namespace isosplat
