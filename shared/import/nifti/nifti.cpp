#include "shared/import/nifti/nifti.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "shared/import/bytes/input_files.h"
#include "shared/import/codecs/deflated_reader.h"
#include "shared/import/nifti/header.h"
#include "shared/import/text/header_text.h"
#include "shared/import/volume/choose_channel.h"
#include "shared/import/volume/choose_step.h"
#include "shared/import/volume/refusals.h"
#include "shared/import/voxels/array_source.h"

// Reads NIfTI-1 and NIfTI-2, in one file (.nii, .nii.gz) or in a pair (.hdr and .img).
namespace isosplat::import {
namespace {

/// A path with the extension before ".gz" replaced; with or without ".gz", whichever exists.
std::optional<std::filesystem::path> sibling(std::filesystem::path path, const char* lower,
                                             const char* upper) {
  if (lower_case(path.extension().string()) == ".gz") path.replace_extension();
  for (const char* extension : {lower, upper}) {
    for (const char* gz : {"", ".gz"}) {
      std::filesystem::path other = path;
      other.replace_extension(std::string(extension) + gz);
      if (input_kind(other) == InputKind::file) return other;
    }
  }
  return std::nullopt;
}

Result<std::unique_ptr<ByteReader>> open_bytes(const std::filesystem::path& path, bool deflated) {
  return deflated ? open_deflated(path) : open_plain(path);
}

/// The numbers of a voxel that is a colour: 24-bit RGB or 32-bit RGBA.
uint64_t colours_of(int16_t data_type) {
  return data_type == 128 ? 3 : data_type == 2304 ? 4 : 1;
}

/// The fourth axis of the stored array, with more than one sample for files of several volumes.
struct FourthAxis {
  size_t position = 3;  ///< 0: colours alternate
  uint64_t count = 1, chosen = 0;
};

/// Checks the sizes: three spatial axes, and one of times, of channels (the fifth), or of colours.
Result<FourthAxis> fourth_axis(const std::filesystem::path& path, const NiftiHeader& header,
                               std::vector<int64_t>& sizes, const ImportOptions& options,
                               std::vector<std::string>& notes) {
  for (size_t i = 0; i < sizes.size(); ++i) {
    if (sizes[i] == 0 && i > 2) {
      notes.push_back(fmt::format("the header's size of dimension {} is 0: 1 is assumed", i + 1));
      sizes[i] = 1;
    }
    if (sizes[i] >= 1) continue;
    return fail(Status::malformed_volume,
                fmt::format("{}: expected sizes above 0, found {} along dimension {}: the NIfTI "
                            "header is damaged; export the volume again",
                            path.string(), sizes[i], i + 1));
  }
  const uint64_t colours = colours_of(header.data_type);
  const uint64_t components = sizes.size() > 4 ? static_cast<uint64_t>(sizes[4]) : 1;
  const uint64_t channels = colours > 1 ? colours : components;
  const int64_t others = sizes.size() < 4 ? 0
                                          : std::count_if(sizes.begin() + 3, sizes.end(),
                                                          [](int64_t size) { return size > 1; });
  if (channels > 1 && others > (colours > 1 ? 0 : 1)) {
    return not_scalar(path, static_cast<int>(std::min<uint64_t>(channels, 1000)));
  }
  const auto channel = choose_channel(
      path, channels, options, colours > 1 ? rgba_channels() : std::vector<ChannelDescription>{});
  if (!channel) return tl::unexpected(channel.error());
  if (channels > 1 && sizes.size() > 3) sizes.resize(3);
  const auto step = choose_time_step(path, sizes, options, nifti_times(header));
  if (!step) return tl::unexpected(step.error());
  if (colours > 1) return FourthAxis{0, colours, *channel};
  if (components > 1) return FourthAxis{3, components, *channel};
  return FourthAxis{3, static_cast<uint64_t>(sizes.size() > 3 ? sizes[3] : 1), *step};
}

/// Reads the header at the beginning of `bytes`.
Result<NiftiHeader> read_header(const std::filesystem::path& path, ByteReader& bytes) {
  std::array<std::byte, kNifti2Bytes> raw{};
  const auto some = bytes.count_after(0, raw.size());
  if (!some) return tl::unexpected(some.error());
  const auto header_bytes = std::span(raw).first(static_cast<size_t>(*some));
  if (*some < 348) {
    return fail(Status::truncated,
                fmt::format("{}: expected a header of 348 bytes, found {}: the file is incomplete; "
                            "copy or download it again",
                            path.string(), *some));
  }
  if (auto read = bytes.read(0, header_bytes); !read) return tl::unexpected(read.error());
  return parse_nifti(path, header_bytes);
}

/// The type of the voxels, or of each channel of a colour. Errors: also if a voxel is a complex
/// number.
Result<VoxelType> voxel_type_of(const std::filesystem::path& path, int16_t code) {
  if (colours_of(code) > 1) return VoxelType::u8;
  if (code == 32 || code == 1792 || code == 2048) return not_scalar(path, 2);
  const auto type = nifti_type(code);
  if (!type) return unknown_type(path, fmt::format("NIfTI data type {}", code));
  return *type;
}

/// The type, byte order, slope and intercept of the voxels.
Result<StoredVoxels> stored_voxels_of(const std::filesystem::path& path, const NiftiHeader& header,
                                      VoxelType type) {
  StoredVoxels stored;
  stored.type = type;
  stored.big_endian = header.big_endian;
  if (std::isfinite(header.slope) && header.slope != 0) {
    if (!std::isfinite(header.intercept)) {
      return malformed_nifti(path,
                             fmt::format("expected a finite scl_inter beside scl_slope {}, found "
                                         "{}",
                                         header.slope, header.intercept));
    }
    stored.slope = header.slope;
    stored.intercept = header.intercept;
  }
  return stored;
}

/// The offset of the first voxel in the file that contains the voxels.
Result<uint64_t> voxel_offset_of(const std::filesystem::path& path, const NiftiHeader& header) {
  const double offset = header.voxel_offset;
  const double min_offset = header.is_pair ? 0 : header.version == 2 ? 540 : 348;
  if (!(offset >= min_offset && offset < 1e12 && offset == std::floor(offset))) {
    return malformed_nifti(
        path, fmt::format("expected the voxels' offset to be a whole number from {} on, "
                          "found {}",
                          min_offset, offset));
  }
  return static_cast<uint64_t>(offset);
}

}  // namespace

Result<OpenVolume> open_nifti(const FileHead& head, const ImportOptions& options) {
  const std::filesystem::path& named = head.path;
  std::filesystem::path path = named;
  const bool names_voxels = lower_case(named.filename().string()).find(".img") != std::string::npos;
  if (names_voxels) path = sibling(named, ".hdr", ".HDR").value_or(named);
  bool deflated = path == named ? head.is_gzip() : is_gzip(path);
  auto bytes = open_bytes(path, deflated);
  if (!bytes) return tl::unexpected(bytes.error());
  const auto header = read_header(path, **bytes);
  if (!header) return tl::unexpected(header.error());
  const auto type = voxel_type_of(path, header->data_type);
  if (!type) return tl::unexpected(type.error());
  std::vector<std::string> notes;
  std::vector<int64_t> sizes = header->sizes;
  const auto axis = fourth_axis(path, *header, sizes, options, notes);
  if (!axis) return tl::unexpected(axis.error());
  const uint64_t bits = 8 * voxel_bytes(*type) * colours_of(header->data_type);
  if (header->bits != 0 && static_cast<uint64_t>(header->bits) != bits) {
    return malformed_nifti(path, fmt::format("expected {} bits per voxel of data type {}, found {}",
                                             bits, header->data_type, header->bits));
  }
  const auto geometry = nifti_geometry(path, *header, notes);
  if (!geometry) return tl::unexpected(geometry.error());
  const auto stored = stored_voxels_of(path, *header, *type);
  if (!stored) return tl::unexpected(stored.error());
  const auto offset = voxel_offset_of(path, *header);
  if (!offset) return tl::unexpected(offset.error());

  ArrayVolume array = make_array("NIfTI", path, {sizes[0], sizes[1], sizes[2]}, *geometry, options);
  array.stored = *stored;
  array.step_axis = axis->position;
  array.steps = axis->count;
  array.step = axis->chosen;
  array.offset = *offset;
  if (header->is_pair) {
    const auto voxels = names_voxels ? named : sibling(path, ".img", ".IMG");
    if (!voxels) {
      return fail(Status::io_error, fmt::format("{}: its voxels are missing: expected {} beside it",
                                                path.string(), path.stem().string() + ".img"));
    }
    deflated = *voxels == named ? head.is_gzip() : is_gzip(*voxels);
    bytes = open_bytes(*voxels, deflated);
    if (!bytes) return tl::unexpected(bytes.error());
  }
  array.plain = !deflated;
  return open_array(std::move(array), std::move(*bytes), std::move(notes));
}

}  // namespace isosplat::import
