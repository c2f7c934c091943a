#include "shared/import/vtk_xml/parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "shared/import/voxels/array_source.h"
#include "shared/import/vtk_xml/array_bytes.h"

namespace isosplat::import {
namespace {

constexpr size_t kMaxOpen = 32;

bool contains(const VtkXmlPart& part, size_t axis, int64_t index) {
  return index >= part.low[axis] && index < part.high[axis];
}

class PartReader : public ByteReader {
 public:
  PartReader(std::vector<VtkXmlFile> files, std::vector<VtkXmlPart> parts, Vec3<int64_t> sizes)
      : files_(std::move(files)),
        parts_(std::move(parts)),
        readers_(parts_.size()),
        sizes_(sizes),
        voxel_(static_cast<uint64_t>(parts_[0].array.components) *
               voxel_bytes(*parts_[0].array.type)),
        row_(static_cast<uint64_t>(sizes.x) * voxel_),
        bytes_(array_bytes(sizes, 1, static_cast<size_t>(voxel_))) {}

  /// Opens each part once, which checks its size.
  Result<void> check() {
    for (size_t i = 0; i < parts_.size(); ++i) {
      if (auto opened = reader(i); !opened) return tl::unexpected(opened.error());
      resident_ = std::max(resident_, readers_[i]->resident_bytes());
    }
    return {};
  }

  Result<void> read(uint64_t offset, std::span<std::byte> out) override {
    if (offset > bytes_ || out.size() > bytes_ - offset) {
      return malformed_vtk_xml(files_[0].path, "expected more values");
    }
    while (!out.empty()) {
      const uint64_t row = offset / row_, in_row = offset % row_;
      const auto ny = static_cast<uint64_t>(sizes_.y);
      const std::array<int64_t, 3> at{static_cast<int64_t>(in_row / voxel_),
                                      static_cast<int64_t>(row % ny),
                                      static_cast<int64_t>(row / ny)};
      const auto index = part_of(at);
      if (!index) {
        return malformed_vtk_xml(files_[0].path,
                                 fmt::format("expected a piece with the point or cell {}, {}, {}, "
                                             "counted from the first one, found none",
                                             at[0], at[1], at[2]));
      }
      const VtkXmlPart& part = parts_[*index];
      const uint64_t end = static_cast<uint64_t>(part.high[0]) * voxel_;
      const auto count = static_cast<size_t>(std::min<uint64_t>(end - in_row, out.size()));
      uint64_t voxel = 0;
      for (const size_t axis : {2, 1, 0}) {
        voxel = voxel * static_cast<uint64_t>(part.stored[axis]) +
                static_cast<uint64_t>(at[axis] - part.stored_low[axis]);
      }
      const auto opened = reader(*index);
      if (!opened) return tl::unexpected(opened.error());
      auto read = (*opened)->read(voxel * voxel_ + in_row % voxel_, out.first(count));
      if (!read) return read;
      offset += count;
      out = out.subspan(count);
    }
    return {};
  }

  uint64_t size_limit() const override { return bytes_; }
  Result<uint64_t> count_after(uint64_t offset, uint64_t most) override {
    return std::min(most, bytes_ - std::min(bytes_, offset));
  }
  uint64_t available_bytes() override { return bytes_; }
  uint64_t resident_bytes() const override { return resident_ * std::min(kMaxOpen, parts_.size()); }
  std::vector<std::filesystem::path> files() const override {
    std::vector<std::filesystem::path> paths;
    for (const VtkXmlFile& file : files_) paths.push_back(file.path);
    return paths;
  }

 private:
  /// The first part with a voxel. The parts of its slice are kept for the next call.
  std::optional<size_t> part_of(const std::array<int64_t, 3>& at) {
    if (slice_ != at[2]) {
      slice_ = at[2];
      slice_parts_.clear();
      for (size_t i = 0; i < parts_.size(); ++i) {
        if (contains(parts_[i], 2, at[2])) slice_parts_.push_back(i);
      }
    }
    for (const size_t i : slice_parts_) {
      if (contains(parts_[i], 1, at[1]) && contains(parts_[i], 0, at[0])) return i;
    }
    return std::nullopt;
  }

  Result<ByteReader*> reader(size_t index) {
    if (!readers_[index]) {
      const VtkXmlPart& part = parts_[index];
      auto opened = open_vtk_xml_array(files_[part.file], part.array, vtk_xml_part_bytes(part));
      if (!opened) return tl::unexpected(opened.error());
      if (open_.size() == kMaxOpen) {
        readers_[open_.front()].reset();
        open_.erase(open_.begin());
      }
      open_.push_back(index);
      readers_[index] = std::move(*opened);
    }
    return readers_[index].get();
  }

  std::vector<VtkXmlFile> files_;
  std::vector<VtkXmlPart> parts_;
  std::vector<std::unique_ptr<ByteReader>> readers_;  ///< of the parts; null: not open
  std::vector<size_t> open_;                          ///< indices of those that are open
  Vec3<int64_t> sizes_;
  uint64_t voxel_, row_, bytes_;
  uint64_t resident_ = 0;
  int64_t slice_ = -1;
  std::vector<size_t> slice_parts_;
};

}  // namespace

uint64_t vtk_xml_part_bytes(const VtkXmlPart& part) {
  return array_bytes({part.stored[0], part.stored[1], part.stored[2]},
                     static_cast<uint64_t>(part.array.components), voxel_bytes(*part.array.type));
}

Result<std::unique_ptr<ByteReader>> open_vtk_xml_parts(std::vector<VtkXmlFile> files,
                                                       std::vector<VtkXmlPart> parts,
                                                       Vec3<int64_t> sizes) {
  uint64_t needed = array_bytes(sizes, 1, 1), found = 0;
  for (const VtkXmlPart& part : parts) {
    found += array_bytes(
        {part.high[0] - part.low[0], part.high[1] - part.low[1], part.high[2] - part.low[2]}, 1, 1);
    if (found >= needed) break;
  }
  if (found < needed) {
    return malformed_vtk_xml(
        files[0].path,
        fmt::format("expected pieces with {} points or cells, found {}", needed, found));
  }
  const VtkXmlPart& first = parts[0];
  if (first.stored_low == std::array<int64_t, 3>{} &&
      first.stored == std::array{sizes.x, sizes.y, sizes.z} && first.high == first.stored) {
    return open_vtk_xml_array(files[first.file], first.array, vtk_xml_part_bytes(first));
  }
  auto reader = std::make_unique<PartReader>(std::move(files), std::move(parts), sizes);
  if (auto checked = reader->check(); !checked) return tl::unexpected(checked.error());
  return reader;
}

}  // namespace isosplat::import
