#include "shared/import/nifti/nifti.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "shared/import/bytes/input_files.h"
#include "shared/import/codecs/deflated_reader.h"
#include "shared/import/nifti/header.h"
#include "shared/import/text/header_text.h"
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

/// Checks the sizes: three spatial axes, optionally a time axis.
Result<uint64_t> check_sizes(const std::filesystem::path& path, const NiftiHeader& header,
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
  if (sizes.size() > 4 && sizes[4] > 1) return not_scalar(path, static_cast<int>(sizes[4]));
  return choose_time_step(path, sizes, options, nifti_times(header));
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

/// The type of the voxels. Errors: also if a voxel is a colour or a complex number.
Result<VoxelType> voxel_type_of(const std::filesystem::path& path, int16_t code) {
  if (code == 128 || code == 2304) return not_scalar(path, code == 128 ? 3 : 4);
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
  const auto step = check_sizes(path, *header, sizes, options, notes);
  if (!step) return tl::unexpected(step.error());
  if (header->bits != 0 && static_cast<size_t>(header->bits) != 8 * voxel_bytes(*type)) {
    return malformed_nifti(path,
                           fmt::format("expected {} bits per voxel of data type {}, found {}",
                                       8 * voxel_bytes(*type), header->data_type, header->bits));
  }
  const auto geometry = nifti_geometry(path, *header, notes);
  if (!geometry) return tl::unexpected(geometry.error());
  const auto stored = stored_voxels_of(path, *header, *type);
  if (!stored) return tl::unexpected(stored.error());
  const auto offset = voxel_offset_of(path, *header);
  if (!offset) return tl::unexpected(offset.error());

  ArrayVolume array = make_array("NIfTI", path, {sizes[0], sizes[1], sizes[2]}, *geometry, options);
  array.stored = *stored;
  array.steps = static_cast<uint64_t>(sizes.size() > 3 ? sizes[3] : 1);
  array.step = *step;
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
