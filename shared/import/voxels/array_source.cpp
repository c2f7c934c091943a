#include "shared/import/voxels/array_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <limits>

#include "shared/import/volume/import_options.h"
#include "shared/import/volume/opened_volume.h"
#include "shared/import/volume/volume_name.h"
#include "shared/import/voxels/absent_voxels.h"
#include "shared/import/voxels/slice_range.h"

namespace isosplat::import {
namespace {

/// A file with less than 1/kMinShare of its voxels is an error even if truncation is allowed: the
/// header must be wrong.
constexpr uint64_t kMinShare = 1024;

/// The largest row with all its steps or channels.
constexpr uint64_t kMaxRowBytes = uint64_t{1} << 30;

tl::unexpected<Error> surplus_error(const std::string& path, uint64_t expected, uint64_t surplus,
                                    bool at_least) {
  return fail(Status::malformed_volume,
              fmt::format("{}: expected {} bytes of voxels, found {}{} more: the header's sizes or "
                          "type do not fit the data; correct them, or ignore the surplus with {}",
                          path, expected, at_least ? "at least " : "", surplus,
                          flag_of(Allowance::surplus)));
}

class ArraySource : public VolumeSource {
 public:
  ArraySource(ArrayVolume volume, Orientation orientation, std::unique_ptr<ByteReader> reader)
      : volume_(std::move(volume)),
        reverse_rows_(orientation.reverse_rows),
        reader_(std::move(reader)) {
    const VoxelType type = volume_.stored.type;
    header_ = {orientation.grid,
               volume_.missing.empty() ? type : type_with_absent(type),
               volume_.format,
               volume_.name,
               volume_.stored.slope,
               volume_.stored.intercept,
               std::string(volume_.geometry.frame_of_reference)};
  }

  const VolumeHeader& header() const override { return header_; }

  Result<void> read_slices(int32_t first, int32_t count, std::span<std::byte> out) override {
    const auto nx = static_cast<size_t>(volume_.voxels.x);
    const auto ny = static_cast<size_t>(volume_.voxels.y);
    const size_t slice = nx * ny * voxel_bytes(header_.type);
    if (auto inside = check_slices(header_, first, count, out.size()); !inside) return inside;
    const bool at_once = (volume_.steps == 1 || volume_.step_axis == 3) &&
                         volume_.missing.empty() && !volume_.stored.is_half;
    if (at_once) {
      const uint64_t voxels = nx * ny * static_cast<uint64_t>(volume_.voxels.z);
      const uint64_t begin = byte_offset(static_cast<uint64_t>(first) * nx * ny, voxels);
      if (auto r = reader_->read(begin, out); !r) return r;
      to_native_order(volume_.stored, out);
    }
    for (size_t z = 0; z < static_cast<size_t>(count); ++z) {
      const auto to = out.subspan(z * slice, slice);
      if (!at_once) {
        if (auto r = read_run((static_cast<uint64_t>(first) + z) * nx * ny, to); !r) return r;
      }
      if (reverse_rows_) reverse_rows(to, nx * voxel_bytes(header_.type));
    }
    if (int64_t{first} + count == volume_.voxels.z) return check_end();
    return {};
  }

  bool reads_rows() const override { return reader_->is_random_access(); }

  Result<void> read_rows(const SliceRows& part, std::span<std::byte> out) override {
    const auto nx = static_cast<uint64_t>(volume_.voxels.x);
    if (part.rows == volume_.voxels.y) return read_slices(part.first_slice, part.slices, out);
    if (auto inside = check_rows(header_, part, out.size()); !inside) return inside;
    const int64_t first_row =
        reverse_rows_ ? volume_.voxels.y - part.first_row - part.rows : part.first_row;
    const size_t bytes = out.size() / static_cast<size_t>(part.slices);
    for (int32_t z = 0; z < part.slices; ++z) {
      const auto row =
          static_cast<uint64_t>((int64_t{part.first_slice} + z) * volume_.voxels.y + first_row);
      const auto to = out.subspan(static_cast<size_t>(z) * bytes, bytes);
      if (auto r = read_run(row * nx, to); !r) return r;
      if (reverse_rows_) reverse_rows(to, bytes / static_cast<size_t>(part.rows));
    }
    return {};
  }

  uint64_t resident_bytes() const override { return reader_->resident_bytes(); }

  std::vector<std::filesystem::path> files() const override {
    std::vector<std::filesystem::path> files = reader_->files();
    const std::filesystem::path header = volume_.path;
    if (std::find(files.begin(), files.end(), header) == files.end()) files.push_back(header);
    return files;
  }

 private:
  size_t stored_voxel() const { return stored_bytes(volume_.stored); }

  /// Reads whole rows of a slice: as stored, converted, or with absent voxels. first: their first
  /// voxel.
  Result<void> read_run(uint64_t first, std::span<std::byte> out) {
    const bool converts = volume_.stored.is_half || header_.type != volume_.stored.type;
    std::span<std::byte> stored = out;
    if (converts) {
      stored_.resize(out.size() / voxel_bytes(header_.type) * stored_voxel());
      stored = stored_;
    }
    if (auto r = read_stored(first, stored); !r) return r;
    if (volume_.stored.is_half) {
      widen_halves(stored, out);
    } else if (converts) {
      convert_voxels(volume_.stored.type, stored, header_.type, out);
    }
    if (!volume_.missing.empty()) mark_absent(first, out);
    return {};
  }

  /// Reads whole rows as stored, in native byte order.
  Result<void> read_stored(uint64_t first, std::span<std::byte> out) {
    const uint64_t consecutive = consecutive_voxels();
    const size_t voxels = out.size() / stored_voxel();
    Result<void> read;
    if (consecutive == 1) {
      read = gather_rows(first, out);
    } else {
      for (uint64_t done = 0; done < voxels && read;) {
        const uint64_t voxel = first + done;
        const uint64_t batch = std::min(consecutive - voxel % consecutive, voxels - done);
        read = read_bytes(byte_offset(voxel, consecutive),
                          out.subspan(static_cast<size_t>(done) * stored_voxel(),
                                      static_cast<size_t>(batch) * stored_voxel()));
        done += batch;
      }
    }
    if (!read) return read;
    to_native_order(volume_.stored, out);
    return {};
  }

  /// Number of consecutive voxels of one step.
  uint64_t consecutive_voxels() const {
    const auto nx = static_cast<uint64_t>(volume_.voxels.x);
    const auto ny = static_cast<uint64_t>(volume_.voxels.y);
    const auto nz = static_cast<uint64_t>(volume_.voxels.z);
    const uint64_t inner[] = {1, nx, nx * ny, nx * ny * nz};  // by axis
    return volume_.steps == 1 ? inner[3] : inner[volume_.step_axis];
  }

  /// Byte offset of a voxel of the selected step in the reader.
  uint64_t byte_offset(uint64_t voxel, uint64_t consecutive) const {
    const uint64_t group = voxel / consecutive;
    const uint64_t steps_before = group * volume_.steps + volume_.step;
    return volume_.offset + (steps_before * consecutive + voxel % consecutive) * stored_voxel();
  }

  /// Reads rows whose voxels alternate with those of other steps.
  Result<void> gather_rows(uint64_t first, std::span<std::byte> stored) {
    const auto nx = static_cast<size_t>(volume_.voxels.x);
    const size_t bytes = stored_voxel(), steps = static_cast<size_t>(volume_.steps);
    row_.resize(((nx - 1) * steps + 1) * bytes);  // at most kMaxRowBytes: see open_array
    for (size_t done = 0; done < stored.size() / bytes; done += nx) {
      if (auto r = read_bytes(byte_offset(first + done, 1), row_); !r) return r;
      for (size_t x = 0; x < nx; ++x) {
        std::copy_n(row_.data() + x * steps * bytes, bytes, stored.data() + (done + x) * bytes);
      }
    }
    return {};
  }

  /// Reads bytes; missing bytes are 0.
  Result<void> read_bytes(uint64_t offset, std::span<std::byte> out) {
    if (volume_.missing.empty()) return reader_->read(offset, out);
    while (!out.empty()) {
      const auto range = std::find_if(volume_.missing.begin(), volume_.missing.end(),
                                      [&](const ByteRange& r) { return r.end > offset; });
      const uint64_t begin =
          range == volume_.missing.end() ? std::numeric_limits<uint64_t>::max() : range->begin;
      const bool is_missing = begin <= offset;
      const auto batch = static_cast<size_t>(
          std::min<uint64_t>(out.size(), (is_missing ? range->end : begin) - offset));
      if (is_missing) {
        std::fill_n(out.begin(), batch, std::byte{0});
      } else if (auto r = reader_->read(offset, out.first(batch)); !r) {
        return r;
      }
      out = out.subspan(batch);
      offset += batch;
    }
    return {};
  }

  void mark_absent(uint64_t first, std::span<std::byte> out) {
    const size_t bytes = voxel_bytes(header_.type);
    const uint64_t voxels = out.size() / bytes, consecutive = consecutive_voxels();
    for (uint64_t i = 0; i < voxels; ++i) {
      const uint64_t begin = byte_offset(first + i, consecutive), end = begin + stored_voxel();
      for (const ByteRange& range : volume_.missing) {
        if (range.begin < end && begin < range.end) {
          make_absent(header_.type, out.subspan(static_cast<size_t>(i) * bytes, bytes));
        }
      }
    }
  }

  /// The size of compressed data and text is known only at their end: checks there for surplus
  /// data.
  Result<void> check_end() {
    if (volume_.plain || !volume_.ends_with_file || end_is_checked_ || !volume_.missing.empty() ||
        volume_.allowed.has(Allowance::surplus)) {
      return {};
    }
    const uint64_t end =
        volume_.offset + array_bytes(volume_.voxels, volume_.steps, stored_voxel());
    const auto more = reader_->count_after(end, 1 << 20);
    if (!more) return tl::unexpected(more.error());
    end_is_checked_ = *more == 0;
    if (end_is_checked_) return {};
    return surplus_error(volume_.path, end - volume_.offset, *more, *more == 1 << 20);
  }

  ArrayVolume volume_;
  bool reverse_rows_;
  bool end_is_checked_ = false;
  std::unique_ptr<ByteReader> reader_;
  VolumeHeader header_;
  std::vector<std::byte> row_;     ///< one row with all its steps
  std::vector<std::byte> stored_;  ///< rows as stored, if they are converted
};

}  // namespace

ArrayVolume make_array(std::string format, const std::filesystem::path& path, Vec3<int64_t> voxels,
                       const HeaderGeometry& geometry, const ImportOptions& options) {
  ArrayVolume array;
  array.format = std::move(format);
  array.name = volume_name(path);
  array.path = path.string();
  array.voxels = voxels;
  array.geometry = geometry;
  array.allowed = options.allowed;
  if (options.spacing) array.geometry.spacing = *options.spacing;
  return array;
}

Result<OpenVolume> open_array(ArrayVolume volume, std::unique_ptr<ByteReader> reader,
                              std::vector<std::string> notes) {
  auto orientation = orient(volume.voxels, volume.geometry);
  if (!orientation) {
    return fail(orientation.error().status, volume.path + ": " + orientation.error().message);
  }
  const size_t bytes = stored_bytes(volume.stored);
  const uint64_t needed = array_bytes(volume.voxels, volume.steps, bytes);
  const uint64_t row = array_bytes({volume.voxels.x, 1, 1}, volume.steps, bytes);
  if (volume.steps > 1 && volume.step_axis == 0 && row > kMaxRowBytes) {
    return fail(Status::unsupported_format,
                fmt::format("{}: expected rows of at most {} bytes with all their steps, found {}: "
                            "save each step or channel as a file of its own",
                            volume.path, kMaxRowBytes, row));
  }
  const bool checks_all = volume.allowed.has(Allowance::truncated) && !volume.plain;
  const uint64_t limit = checks_all ? reader->available_bytes() : reader->size_limit();
  const uint64_t found = limit - std::min(limit, volume.offset);
  if (needed > found) {
    const auto text =
        fmt::format("{}: expected {} bytes of voxels ({} × {} × {}{}, {} bytes each), found {}{}",
                    volume.path, needed, volume.voxels.x, volume.voxels.y, volume.voxels.z,
                    volume.steps > 1 ? fmt::format(" × {}", volume.steps) : "", bytes,
                    volume.plain || checks_all ? "" : "at most ", found);
    if (!volume.allowed.has(Allowance::truncated) || found < needed / kMinShare) {
      return fail(
          Status::truncated,
          fmt::format("{}: the file is incomplete, or its header is wrong; copy or download "
                      "it again, or read the incomplete volume with {}",
                      text, flag_of(Allowance::truncated)));
    }
    notes.push_back(text + ": the missing voxels have no value");
    volume.missing.push_back({volume.offset + found - found % bytes, volume.offset + needed});
  } else if (volume.plain && volume.ends_with_file && found > needed) {
    if (!volume.allowed.has(Allowance::surplus)) {
      return surplus_error(volume.path, needed, found - needed, false);
    }
    notes.push_back(
        fmt::format("{}: {} bytes after the last voxel are ignored", volume.path, found - needed));
  }
  for (std::string& note : orientation->notes) notes.push_back(std::move(note));
  return OpenVolume{
      std::make_unique<ArraySource>(std::move(volume), std::move(*orientation), std::move(reader)),
      std::move(notes)};
}

uint64_t array_bytes(Vec3<int64_t> voxels, uint64_t steps, size_t voxel_bytes) {
  uint64_t bytes = voxel_bytes;
  for (const int64_t size : {voxels.x, voxels.y, voxels.z, static_cast<int64_t>(steps)}) {
    if (size < 0 || __builtin_mul_overflow(bytes, static_cast<uint64_t>(size), &bytes)) {
      return std::numeric_limits<uint64_t>::max();
    }
  }
  return bytes;
}

void reverse_rows(std::span<std::byte> slice, size_t row_bytes) {
  const size_t rows = slice.size() / row_bytes;
  for (size_t y = 0; y < rows / 2; ++y) {
    std::byte* a = slice.data() + y * row_bytes;
    std::swap_ranges(a, a + row_bytes, slice.data() + (rows - 1 - y) * row_bytes);
  }
}

uint64_t volume_bytes(Vec3<int64_t> voxels, size_t voxel_bytes) {
  return static_cast<uint64_t>(voxels.x) * static_cast<uint64_t>(voxels.y) *
         static_cast<uint64_t>(voxels.z) * voxel_bytes;
}

}  // namespace isosplat::import
