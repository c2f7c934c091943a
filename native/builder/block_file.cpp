#include "native/builder/block_file.h"

#include <fmt/format.h>
#include <isosplat/version.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <string_view>

#include "shared/core/store/checksum.h"

namespace isosplat {
namespace {

constexpr std::array<char, 8> kMagic{'\x89', 'I', 'S', 'O', 'P', '\r', '\n', '\x1a'};

struct FileHead {
  std::array<char, 8> magic{};
  uint64_t key = 0;
  uint32_t part = 0, parts = 0;
  uint64_t version = 0;
  uint64_t checksum = 0;
};

struct FrameHead {
  uint32_t kind = 0, level = 0, z = 0, number = 0;
  uint64_t bytes = 0, content_checksum = 0;
  uint64_t checksum = 0;
};

/// The checksum of a head, whose last member it is.
template <class Head>
uint64_t checksum_of(const Head& head) {
  return checksum64(std::as_bytes(std::span(&head, 1)).first(sizeof head - sizeof head.checksum));
}

uint64_t version_number() {
  constexpr std::string_view kVersion = ISOSPLAT_VERSION;
  return checksum64(std::as_bytes(std::span(kVersion)));
}

bool is_known(uint32_t kind) {
  return kind >= static_cast<uint32_t>(FrameKind::block) &&
         kind <= static_cast<uint32_t>(FrameKind::end);
}

}  // namespace

Result<void> BlockFileWriter::write_header(const BlockFileHeader& header) {
  FileHead head{kMagic, header.key, header.part.number, header.part.count, version_number()};
  head.checksum = checksum_of(head);
  auto written = sink_.write(offset_, std::as_bytes(std::span(&head, 1)));
  offset_ += sizeof head;
  return written;
}

Result<void> BlockFileWriter::write(FrameKind kind, uint32_t level, uint32_t z, uint32_t number,
                                    std::span<const std::byte> content) {
  FrameHead head{static_cast<uint32_t>(kind), level, z, number, content.size(),
                 checksum64(content)};
  head.checksum = checksum_of(head);
  if (auto written = sink_.write(offset_, std::as_bytes(std::span(&head, 1))); !written) {
    return written;
  }
  offset_ += sizeof head;
  if (content.empty()) return {};
  auto written = sink_.write(offset_, content);
  offset_ += content.size();
  return written;
}

bool BlockFile::is_block_file(const PosixFile& file) {
  std::array<char, 8> magic{};
  const auto read = file.read_some(0, std::as_writable_bytes(std::span(magic)));
  return read && magic == kMagic;
}

Result<BlockFile> BlockFile::open(const std::filesystem::path& path) {
  auto file = PosixFile::open(path);
  if (!file) return tl::unexpected(file.error());
  BlockFile opened;
  opened.file_ = std::move(*file);
  const std::string& name = opened.file_.name();
  const auto identity = opened.file_.identity();
  if (!identity) return tl::unexpected(identity.error());
  FileHead head;
  const auto head_bytes = opened.file_.read_some(0, std::as_writable_bytes(std::span(&head, 1)));
  if (!head_bytes) return tl::unexpected(head_bytes.error());
  if (*head_bytes < sizeof head || head.magic != kMagic || head.checksum != checksum_of(head)) {
    return fail(Status::invalid_argument,
                fmt::format("{}: expected a part of a build, found another or a damaged file: "
                            "build this part again",
                            name));
  }
  if (head.version != version_number()) {
    return fail(Status::invalid_argument,
                fmt::format("{}: expected a part of a build by isosplat " ISOSPLAT_VERSION
                            ", found one by another version: build it again",
                            name));
  }
  opened.header_ = {head.key, {head.part, head.parts}};
  opened.end_ = sizeof head;
  while (opened.end_ < identity->bytes) {
    FrameHead frame;
    const auto read =
        opened.file_.read_some(opened.end_, std::as_writable_bytes(std::span(&frame, 1)));
    if (!read) return tl::unexpected(read.error());
    const bool is_head =
        *read == sizeof frame && frame.checksum == checksum_of(frame) && is_known(frame.kind);
    const uint64_t content = opened.end_ + sizeof frame;
    if (!is_head || content > identity->bytes || frame.bytes > identity->bytes - content) {
      opened.is_cut_off_ = true;
      break;
    }
    opened.frames_.push_back({static_cast<FrameKind>(frame.kind), frame.level, frame.z,
                              frame.number, frame.bytes, frame.content_checksum, content});
    opened.end_ = content + frame.bytes;
  }
  return opened;
}

Result<bool> BlockFile::read(const Frame& frame, std::vector<std::byte>& content) const {
  content.resize(frame.bytes);
  const auto read = file_.read_some(frame.offset, content);
  if (!read) return tl::unexpected(read.error());
  return *read == content.size() && checksum64(content) == frame.checksum;
}

}  // namespace isosplat
