// What a store claims to have, and the memory for it.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <iterator>

#include "shared/core/store/store_header.h"
#include "shared/system/store_file/store_file.h"

namespace isosplat {
namespace {

constexpr uint64_t kClaimed = uint64_t{1} << 30;

/// A file of which only the first bytes arrive. Records the largest read.
class ShortFile final : public RandomAccessFile {
 public:
  ShortFile(std::vector<std::byte> bytes, uint64_t claimed)
      : bytes_(std::move(bytes)), claimed_(claimed) {}

  const std::string& name() const override { return name_; }
  Result<FileIdentity> identity(NoWait*) const override { return FileIdentity{.bytes = claimed_}; }
  Result<void> read(uint64_t offset, std::span<std::byte> out, NoWait*) const override {
    largest = std::max<uint64_t>(largest, out.size());
    if (offset + out.size() > bytes_.size()) return fail(Status::io_error, "no more bytes arrive");
    std::copy_n(bytes_.begin() + static_cast<ptrdiff_t>(offset), out.size(), out.begin());
    return {};
  }

  mutable uint64_t largest = 0;

 private:
  const std::string name_ = "short";
  const std::vector<std::byte> bytes_;
  const uint64_t claimed_;
};

TEST(RemoteClaims, APageGetsMemoryOnlyAsItsBytesArrive) {
  std::ifstream stream(ISOSPLAT_SOURCE_DIR "/tests/golden/v1.0/u8.isosplat", std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  const auto given = std::as_bytes(std::span(text));
  std::vector<std::byte> bytes(given.begin(), given.end());
  auto header = parse_store_header(bytes);
  ASSERT_TRUE(header) << header.error().message;
  header->pages.back().bytes += static_cast<uint32_t>(kClaimed);
  header->info.file_bytes += kClaimed;
  const auto written = write_store_header(*header);
  ASSERT_TRUE(written);
  std::ranges::copy(*written, bytes.begin());

  const uint64_t claimed = text.size() + kClaimed;
  bytes.resize(std::max(bytes.size(), kMaxStoreHeaderBytes));
  const auto file = std::make_shared<ShortFile>(std::move(bytes), claimed);
  const auto store = StoreFile::open(FileParts(file, claimed), "short");
  ASSERT_TRUE(store) << store.error().message;
  const auto page = (*store)->read_page(static_cast<uint32_t>(header->pages.size() - 1));
  ASSERT_FALSE(page);
  EXPECT_NE(page.error().message.find("no more bytes arrive"), std::string::npos);
  EXPECT_LE(file->largest, uint64_t{16} << 20);
}

}  // namespace
}  // namespace isosplat
