#include "shared/import/tiff/source.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <type_traits>

#include "shared/import/voxels/absent_voxels.h"
#include "shared/import/voxels/array_source.h"
#include "shared/import/voxels/slice_range.h"

namespace isosplat::import {
namespace {

/// Inverts unsigned voxels that are stored with 0 as white.
void invert(const TiffPage& page, std::span<std::byte> bytes) {
  with_voxel_type(page.type, [&]<class T>(T) {
    if constexpr (std::is_unsigned_v<T>) {
      const unsigned unused = 8 * sizeof(T) - page.stored.bits;
      const T greatest = static_cast<T>(static_cast<T>(~T{}) >> unused);
      for (size_t i = 0; i < bytes.size(); i += sizeof(T)) {
        T voxel;
        std::memcpy(&voxel, bytes.data() + i, sizeof(T));
        voxel = static_cast<T>(greatest - voxel);
        std::memcpy(bytes.data() + i, &voxel, sizeof(T));
      }
    }
  });
}

void reverse_columns(std::span<std::byte> row, size_t voxel) {
  for (size_t a = 0, b = row.size() - voxel; a < b; a += voxel, b -= voxel) {
    std::swap_ranges(row.data() + a, row.data() + a + voxel, row.data() + b);
  }
}

/// Reorders rows and columns so that the first pixel is at the top left.
void apply_orientation(uint16_t orientation, size_t row_bytes, size_t voxel,
                       std::span<std::byte> slice) {
  if (orientation == 3 || orientation == 4) {
    reverse_rows(slice, row_bytes);
  }
  if (orientation == 2 || orientation == 3) {
    for (size_t at = 0; at < slice.size(); at += row_bytes) {
      reverse_columns(slice.subspan(at, row_bytes), voxel);
    }
  }
}

class TiffSource : public VolumeSource {
 public:
  TiffSource(VolumeHeader header, TiffPage page, std::vector<TiffSlice> slices, bool inverts,
             double left_out)
      : header_(std::move(header)),
        page_(std::move(page)),
        slices_(std::move(slices)),
        inverts_(inverts && page_.white_is_zero()),
        left_out_(left_out) {
    has_planes_ =
        page_.depth > 1 || std::any_of(slices_.begin(), slices_.end(),
                                       [](const TiffSlice& slice) { return slice.part.plane > 0; });
    const bool lacks_some = std::any_of(slices_.begin(), slices_.end(),
                                        [](const TiffSlice& slice) { return slice.path.empty(); });
    if (lacks_some) header_.type = type_with_absent(header_.type);
  }

  const VolumeHeader& header() const override { return header_; }

  Result<void> read_slices(int32_t first, int32_t count, std::span<std::byte> out) override {
    const size_t pixels = static_cast<size_t>(page_.width) * static_cast<size_t>(page_.height);
    const size_t slice = pixels * voxel_bytes(header_.type);
    if (auto inside = check_slices(header_, first, count, out.size()); !inside) return inside;
    const size_t voxel = voxel_bytes(page_.type);
    for (int32_t i = 0; i < count; ++i) {
      auto to = out.subspan(static_cast<size_t>(i) * slice, slice);
      const TiffSlice& from = slices_[static_cast<size_t>(first + i)];
      if (from.path.empty()) {
        make_absent(header_.type, to);
        continue;
      }
      std::span<std::byte> stored = to;
      if (header_.type != page_.type) {
        stored_.resize(pixels * voxel);
        stored = stored_;
      }
      if (auto read = read_slice(from, stored); !read) return read;
      if (inverts_) invert(page_, stored);
      apply_orientation(page_.orientation, static_cast<size_t>(page_.width) * voxel, voxel, stored);
      if (header_.type != page_.type) convert_voxels(page_.type, stored, header_.type, to);
    }
    return {};
  }

  uint64_t resident_bytes() const override { return 0; }

  std::vector<std::filesystem::path> files() const override {
    std::vector<std::filesystem::path> files;
    for (const TiffSlice& slice : slices_) {
      if (!slice.path.empty() && (files.empty() || files.back() != slice.path)) {
        files.push_back(slice.path);
      }
    }
    return files;
  }

 private:
  Result<void> read_slice(const TiffSlice& slice, std::span<std::byte> out) {
    if (!open_ || open_path_ != slice.path) {
      open_ = open_tiff(slice.path, has_planes_);
      open_path_ = slice.path;
      if (open_) open_->set_left_out_value(left_out_);
    }
    const std::string where = fmt::format("{}, page at byte {}", slice.path.string(), slice.page);
    const auto page = open_ ? open_->go_to(slice.page) : std::nullopt;
    if (!page) return damaged_tiff(where);
    if (!page->same_kind(page_)) {
      return fail(Status::malformed_volume,
                  fmt::format("{}: expected a slice of {} × {} voxels like the first, found {} × "
                              "{} or another type: all slices of a stack must have the same size "
                              "and type; remove the different one",
                              where, page_.width, page_.height, page->width, page->height));
    }
    if (auto fine = check_decodable(slice.path, *page); !fine) return fine;
    if (!open_->read(out, slice.part)) return damaged_tiff(where);
    return {};
  }

  VolumeHeader header_;
  TiffPage page_;
  std::vector<TiffSlice> slices_;
  bool inverts_;
  double left_out_;
  bool has_planes_ = false;
  std::unique_ptr<TiffFile> open_;
  std::filesystem::path open_path_;
  std::vector<std::byte> stored_;  ///< a slice as stored, if other slices are absent
};

}  // namespace

Result<void> check_decodable(const std::filesystem::path& path, const TiffPage& page) {
  if (page.undecodable.empty()) return {};
#ifndef __EMSCRIPTEN__
  return fail(Status::unsupported_format,
              fmt::format("{}: expected pages with one slice each, found several slices of a page "
                          "compressed with {}: write them uncompressed, or with Deflate",
                          path.string(), page.undecodable));
#else
  return fail(Status::unsupported_format,
              fmt::format("{}: the browser does not decode TIFF with {}: build the store with the "
                          "program (isosplat build {}), and open that",
                          path.string(), page.undecodable, path.string()));
#endif
}

tl::unexpected<Error> damaged_tiff(const std::string& where) {
  return fail(Status::malformed_volume,
              fmt::format("{}: its voxels cannot be decoded: the TIFF file is damaged or "
                          "incomplete; copy or download it again",
                          where));
}

bool is_unsigned(VoxelType type) {
  return type == VoxelType::u8 || type == VoxelType::u16 || type == VoxelType::u32 ||
         type == VoxelType::u64;
}

std::unique_ptr<VolumeSource> make_tiff_source(VolumeHeader header, TiffPage page,
                                               std::vector<TiffSlice> slices, bool inverts,
                                               double left_out) {
  return std::make_unique<TiffSource>(std::move(header), std::move(page), std::move(slices),
                                      inverts, left_out);
}

}  // namespace isosplat::import
