#include "shared/import/dicom/fragments.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <span>

namespace isosplat::import::dicom {
namespace {

constexpr uint32_t kItem = 0xe000fffe;  // as little-endian bytes
constexpr uint32_t kSequenceEnd = 0xe0ddfffe;

/// Upper limit of the average number of fragments per frame.
constexpr size_t kMaxFragmentsPerFrame = 4096;

tl::unexpected<Error> malformed(const Image& image, std::string_view why) {
  return fail(Status::malformed_volume,
              fmt::format("{}: its compressed frames cannot be separated ({}): export the file "
                          "again, for example uncompressed",
                          image.file, why));
}

uint32_t u32_at(const std::byte* bytes) {
  uint32_t value;
  std::memcpy(&value, bytes, sizeof value);
  return value;
}

/// Whether a frame starts in this fragment: each RLE fragment is a frame; frames of JPEG, JPEG-LS
/// and JPEG 2000 start with a marker.
Result<bool> starts_frame(ByteReader& file, const Image& image, const Fragment& fragment) {
  if (image.transfer_syntax == "1.2.840.10008.1.2.5") return true;
  std::array<std::byte, 2> start{};
  if (fragment.bytes < start.size()) return false;
  if (auto r = file.read(fragment.offset, start); !r) return tl::unexpected(r.error());
  return start[0] == std::byte{0xff} &&
         (start[1] == std::byte{0xd8} || start[1] == std::byte{0x4f});
}

/// Reads the headers of all items of the pixel data: the offset table, then the fragments. With
/// `allow_partial`, items beyond the end of the file are left out.
Result<std::vector<Fragment>> read_items(ByteReader& file, const Image& image, bool allow_partial) {
  const auto cut_off = [&](uint64_t at) {
    return fail(Status::truncated,
                fmt::format("{}: expected another compressed fragment at byte {}, found the end of "
                            "the file: it is incomplete; copy or download it again",
                            image.file, at));
  };
  const uint64_t file_bytes = file.size_limit();
  std::vector<Fragment> items;
  uint64_t at = image.pixels.offset;
  for (;;) {
    std::array<std::byte, 8> header{};
    const bool has_header = at <= file_bytes && file_bytes - at >= header.size();
    if (!has_header && allow_partial) return items;
    if (!has_header) return cut_off(at);
    if (auto r = file.read(at, header); !r) return tl::unexpected(r.error());
    at += header.size();
    const uint32_t tag = u32_at(header.data()), bytes = u32_at(header.data() + 4);
    if (tag == kSequenceEnd) return items;
    if (tag != kItem) return malformed(image, fmt::format("no item at byte {}", at - 8));
    if (bytes > file_bytes - at && allow_partial) return items;
    if (bytes > file_bytes - at) return cut_off(at);
    items.push_back({at, bytes});
    if (items.size() > static_cast<size_t>(image.frames) * kMaxFragmentsPerFrame)
      return malformed(image, "too many fragments");
    at += bytes;
  }
}

/// Whether each fragment is the first of a frame, by the offset table. Offsets are relative to the
/// header of the first fragment.
Result<std::vector<bool>> starts_by_table(ByteReader& file, const Image& image, Fragment table,
                                          std::span<const Fragment> fragments, bool allow_partial) {
  std::vector<bool> starts(fragments.size());
  std::vector<std::byte> offsets(table.bytes);
  if (auto r = file.read(table.offset, offsets); !r) return tl::unexpected(r.error());
  for (size_t i = 0; i < static_cast<size_t>(image.frames); ++i) {
    const uint64_t start = fragments.front().offset + u32_at(offsets.data() + 4 * i);
    const auto found = std::lower_bound(fragments.begin(), fragments.end(), start,
                                        [](const Fragment& f, uint64_t o) { return f.offset < o; });
    if (found == fragments.end() && allow_partial) break;
    if (found == fragments.end() || found->offset != start) {
      return malformed(image, "the offset table points between fragments");
    }
    starts[static_cast<size_t>(found - fragments.begin())] = true;
  }
  return starts;
}

/// Whether each fragment is the first of a frame, by its bytes.
Result<std::vector<bool>> starts_by_content(ByteReader& file, const Image& image,
                                            std::span<const Fragment> fragments) {
  std::vector<bool> starts(fragments.size());
  for (size_t i = 0; i < fragments.size(); ++i) {
    const auto first = starts_frame(file, image, fragments[i]);
    if (!first) return tl::unexpected(first.error());
    starts[i] = *first;
  }
  return starts;
}

}  // namespace

Result<std::vector<std::vector<Fragment>>> find_fragments(ByteReader& file, const Image& image,
                                                          bool allow_partial) {
  auto items = read_items(file, image, allow_partial);
  if (!items) return tl::unexpected(items.error());
  const auto frames = static_cast<size_t>(image.frames);
  std::vector<std::vector<Fragment>> result(frames);
  if (items->size() < 2 && allow_partial) return result;
  if (items->size() < 2) return malformed(image, "no fragment");
  const Fragment table = items->front();
  items->erase(items->begin());
  const std::vector<Fragment>& fragments = *items;

  if (frames == 1) {
    result[0] = fragments;
    return result;
  }
  if (fragments.size() == frames) {
    for (size_t i = 0; i < frames; ++i) result[i] = {fragments[i]};
    return result;
  }
  if (fragments.size() < frames && !allow_partial) {
    return malformed(image, "fewer fragments than frames");
  }
  const auto starts = table.bytes == 4 * frames
                          ? starts_by_table(file, image, table, fragments, allow_partial)
                          : starts_by_content(file, image, fragments);
  if (!starts) return tl::unexpected(starts.error());
  const auto begun = static_cast<size_t>(std::count(starts->begin(), starts->end(), true));
  if (!starts->at(0) || begun > frames || (begun < frames && !allow_partial)) {
    return malformed(image, fmt::format("{} fragments for {} frames, without an offset table",
                                        fragments.size(), frames));
  }
  size_t frame = 0;
  for (size_t i = 0; i < fragments.size(); ++i) {
    if (i > 0 && starts->at(i)) ++frame;
    result[frame].push_back(fragments[i]);
  }
  return result;
}

}  // namespace isosplat::import::dicom
