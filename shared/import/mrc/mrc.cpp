#include "shared/import/mrc/mrc.h"

#include <fmt/format.h>

#include <array>

#include "shared/import/codecs/deflated_reader.h"
#include "shared/import/mrc/header.h"
#include "shared/import/mrc/nibbles.h"
#include "shared/import/text/header_text.h"
#include "shared/import/volume/choose_step.h"
#include "shared/import/volume/refusals.h"
#include "shared/import/voxels/array_source.h"

// Reads MRC: maps of electron microscopy (.mrc, .rec, .st) and of crystallography (.map, .ccp4).
namespace isosplat::import {
namespace {

constexpr int32_t kMrc2014 = 20140;
constexpr int32_t kImodBytesAreSigned = 1;
constexpr int32_t kImodHalfBytes = 16;
constexpr int32_t kModeOfHalfBytes = 101;

/// Whether each byte has two voxels: mode 101, or mode 0 with IMOD's flag; then NX counts bytes.
bool has_half_bytes(const MrcHeader& h) {
  return h.mode == kModeOfHalfBytes || (h.mode == 0 && (h.imod_flags & kImodHalfBytes) != 0);
}

/// The type of voxels of mode 0: signed since MRC2014; unsigned in files of IMOD without its flag,
/// and in files whose header has values above 127.
VoxelType byte_type(const MrcHeader& h, std::vector<std::string>& notes) {
  if (h.is_imod) return h.imod_flags & kImodBytesAreSigned ? VoxelType::i8 : VoxelType::u8;
  const bool has_range = h.least < h.greatest;
  if (has_range && h.least >= 0 && h.greatest > 127) {
    notes.push_back(fmt::format(
        "the header says that the largest value is {}: the voxels are read as unsigned bytes, "
        "although MRC2014 defines signed ones",
        h.greatest));
    return VoxelType::u8;
  }
  // The range in a header may belong to other voxels. Only a negative range indicates signed bytes.
  if (h.version < kMrc2014 && !(has_range && h.least < 0)) {
    notes.push_back(
        "the header does not say whether its bytes are signed: they are read as signed ones, as "
        "MRC2014 defines them");
  }
  return VoxelType::i8;
}

Result<StoredVoxels> stored_voxels_of(const std::filesystem::path& path, const MrcHeader& h,
                                      std::vector<std::string>& notes) {
  StoredVoxels stored;
  stored.big_endian = h.big_endian;
  if (has_half_bytes(h)) return stored;
  switch (h.mode) {
    case 0:
      stored.type = byte_type(h, notes);
      return stored;
    case 1:
      stored.type = VoxelType::i16;
      return stored;
    case 2:
      stored.type = VoxelType::f32;
      return stored;
    case 6:
      stored.type = VoxelType::u16;
      return stored;
    case 12:
      stored.type = VoxelType::f32;
      stored.is_half = true;
      return stored;
    case 3:
    case 4:
      return not_scalar(path, 2);
    case 16:
      return not_scalar(path, 3);
    default:
      return unknown_type(path, fmt::format("MRC mode {}", h.mode));
  }
}

/// The number of volumes of the file. Errors: malformed_volume.
Result<int64_t> volumes_of(const std::filesystem::path& path, const MrcHeader& h,
                           std::vector<std::string>& notes) {
  const int32_t sections = h.size[2], each = h.sampling[2];
  if (h.space_group >= 401 && h.space_group <= 630) {
    if (each < 1 || sections < each || sections % each != 0) {
      return malformed_mrc(path, fmt::format("expected {} sections to be volumes of MZ sections "
                                             "each, found MZ {}",
                                             sections, each));
    }
    return sections / each;
  }
  if (h.space_group == 0 && each == 1 && sections > 1) {
    notes.push_back(
        "the header says that the sections are separate images: they are read as slices of a "
        "volume");
  }
  return 1;
}

/// Adds notes about header fields that are not used.
void note_unused(const std::filesystem::path& path, const MrcHeader& h,
                 std::vector<std::string>& notes) {
  if (h.has_skew) {
    notes.push_back(
        "the header turns or moves the map by a matrix (LSKFLG, SKWMAT, SKWTRN), which is not "
        "applied: positions are those of the map");
  }
  if (lower_case(path.extension().string()) == ".mrcs") {
    notes.push_back(
        "the file's name (.mrcs) says that the sections are separate images: they are read as "
        "slices "
        "of a volume");
  }
}

void note_byte_order(const MrcHeader& h, std::vector<std::string>& notes) {
  if (h.is_stamp_right) return;
  notes.push_back(fmt::format(
      "the header's machine stamp does not state the byte order of its numbers: they are {}-endian",
      h.big_endian ? "big" : "little"));
}

}  // namespace

Result<OpenVolume> open_mrc(const FileHead& head, const ImportOptions& options) {
  const std::filesystem::path& path = head.path;
  const bool deflated = head.is_gzip();
  auto bytes = deflated ? open_deflated(path) : open_plain(path);
  if (!bytes) return tl::unexpected(bytes.error());
  std::array<std::byte, kMrcBytes> raw{};
  if (auto read = (*bytes)->read(0, raw); !read) return tl::unexpected(read.error());
  const auto header = parse_mrc(raw, true);
  if (!header) {
    return malformed_mrc(path, "expected a mode and axes of MRC, found other numbers");
  }
  std::vector<std::string> notes;
  note_byte_order(*header, notes);
  note_unused(path, *header, notes);
  const auto stored = stored_voxels_of(path, *header, notes);
  if (!stored) return tl::unexpected(stored.error());
  const auto volumes = volumes_of(path, *header, notes);
  if (!volumes) return tl::unexpected(volumes.error());
  const auto step = choose_step(path, *volumes, options);
  if (!step) return tl::unexpected(step.error());
  if (header->extended_bytes < 0) {
    return malformed_mrc(path, fmt::format("expected an extended header (NSYMBT) of 0 bytes or "
                                           "more, found {}",
                                           header->extended_bytes));
  }
  const auto geometry = mrc_geometry(path, *header, notes);
  if (!geometry) return tl::unexpected(geometry.error());
  const auto [columns, rows, sections] = header->size;
  uint64_t offset = kMrcBytes + static_cast<uint64_t>(header->extended_bytes);
  const bool is_packed = has_half_bytes(*header) && columns > 0;
  const int64_t along_x = is_packed && header->mode == 0 ? int64_t{columns} * 2 : columns;
  if (is_packed) {
    *bytes = read_nibbles(std::move(*bytes), offset, static_cast<uint64_t>(along_x));
    offset = 0;
  }
  ArrayVolume array =
      make_array("MRC", path, {along_x, rows, sections / *volumes}, *geometry, options);
  array.stored = *stored;
  array.steps = static_cast<uint64_t>(*volumes);
  array.step = *step;
  array.offset = offset;
  array.plain = !deflated;
  return open_array(std::move(array), std::move(*bytes), std::move(notes));
}

}  // namespace isosplat::import
