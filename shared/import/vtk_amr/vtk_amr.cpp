#include "shared/import/vtk_amr/vtk_amr.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <set>

#include "shared/import/vtk_amr/hierarchy.h"
#include "shared/import/vtk_xml/document.h"
#include "shared/import/vtk_xml/vtk_xml.h"

namespace isosplat::import {
namespace {

using Path = std::filesystem::path;

/// Spacings of headers are rounded to some six digits.
constexpr double kTolerance = 1e-3;

/// The ratio between two levels. Nothing if it is not the same integer along all axes.
std::optional<int32_t> ratio_of(Vec3d coarse, Vec3d fine) {
  const double ratio = std::round(coarse.x / fine.x);
  for (const double each : {coarse.x / fine.x, coarse.y / fine.y, coarse.z / fine.z}) {
    if (!(std::abs(each - ratio) <= kTolerance * ratio)) return std::nullopt;
  }
  if (!(ratio >= 2 && ratio <= kMaxRefinement)) return std::nullopt;
  return static_cast<int32_t>(ratio);
}

/// The first and last cell of level 0 along each axis.
VtkAmrPatch domain_of(const VtkAmrLevel& level) {
  VtkAmrPatch domain = level.patches.front();
  for (const VtkAmrPatch& patch : level.patches) {
    for (size_t axis = 0; axis < 3; ++axis) {
      domain.low[axis] = std::min(domain.low[axis], patch.low[axis]);
      domain.high[axis] = std::max(domain.high[axis], patch.high[axis]);
    }
  }
  return domain;
}

class Reader {
 public:
  Reader(const Path& path, const ImportOptions& options, uint64_t memory_bytes)
      : path_(path), options_(options), memory_bytes_(memory_bytes) {}

  Result<OpenAdaptiveGrid> read() {
    auto hierarchy = read_vtk_hierarchy(path_);
    if (!hierarchy) return tl::unexpected(hierarchy.error());
    hierarchy_ = std::move(*hierarchy);
    if (options_.spacing) {
      return fail(Status::invalid_argument,
                  path_.string() +
                      ": --spacing: expected none for a hierarchy of grids, which "
                      "states a spacing for each level");
    }
    if (auto placed = place(); !placed) return tl::unexpected(placed.error());
    for (size_t level = 0; level < hierarchy_.levels.size(); ++level) {
      for (const VtkAmrPatch& patch : hierarchy_.levels[level].patches) {
        if (auto added = add(static_cast<uint32_t>(level), patch); !added) {
          return tl::unexpected(added.error());
        }
      }
    }
    if (const uint64_t dropped = grid_->resolve(); dropped > 0) {
      notes_.push_back(
          fmt::format("{} cells of finer levels cover cells of coarser levels only in "
                      "part: the coarser ones are used",
                      dropped));
    }
    if (grid_->centring() == Centring::cells) {
      notes_.push_back(
          "the values belong to cells of an adaptive grid: each node has the average of the cells "
          "around it, weighted by the inverse of their edges");
    }
    return OpenAdaptiveGrid{std::move(*grid_), std::move(header_), std::move(notes_),
                            std::move(files_)};
  }

 private:
  /// Finds the domain and the ratios of the levels, and checks the boxes of all patches.
  Result<void> place() {
    std::vector<VtkAmrLevel>& levels = hierarchy_.levels;
    while (levels.size() > 1 && levels.back().patches.empty()) levels.pop_back();
    if (levels.front().patches.empty()) {
      return malformed_vtk_xml(path_, "expected patches of level 0, found none");
    }
    const VtkAmrPatch domain = domain_of(levels.front());
    int64_t edge = 1;
    uint64_t values = 0;
    for (size_t level = 0; level < levels.size(); ++level) {
      if (level > 0) {
        const auto ratio = ratio_of(levels[level - 1].spacing, levels[level].spacing);
        if (!ratio) {
          return malformed_vtk_xml(
              path_, fmt::format("expected a spacing of level {} that divides that of level {} by "
                                 "the same integer from 2 to {} along all axes",
                                 level, level - 1, kMaxRefinement));
        }
        ratios_.push_back(*ratio);
        edge *= *ratio;
        if (edge >= kMaxVoxelsPerAxis) {
          return fail(Status::volume_too_large,
                      fmt::format("{}: expected fewer than {} cells of the finest level along an "
                                  "edge of a cell of level 0, found {} on level {}",
                                  path_.string(), kMaxVoxelsPerAxis, edge, level));
        }
      }
      for (VtkAmrPatch& patch : levels[level].patches) {
        uint64_t cells = 1;
        for (size_t axis = 0; axis < 3; ++axis) {
          const int64_t first = domain.low[axis] * edge, last = (domain.high[axis] + 1) * edge - 1;
          if (patch.low[axis] < first || patch.high[axis] > last) {
            return malformed_vtk_xml(
                path_,
                fmt::format("expected patches of level {} from cell {} to {} along {}, "
                            "inside of level 0, found one from {} to {}",
                            level, first, last, "xyz"[axis], patch.low[axis], patch.high[axis]));
          }
          // From here on, indices are from the first cell of the domain.
          patch.low[axis] -= first;
          patch.high[axis] -= first;
          cells *= static_cast<uint64_t>(patch.high[axis] - patch.low[axis] + 1);
          if (cells > memory_bytes_) break;
        }
        values = std::max(values, cells);
        if (values > memory_bytes_ / 16) {
          return fail(Status::out_of_memory,
                      fmt::format("{}: expected patches that fit into {} MiB, found one that does "
                                  "not: raise --memory",
                                  path_.string(), memory_bytes_ >> 20));
        }
      }
    }
    for (size_t axis = 0; axis < 3; ++axis) {
      if (domain.high[axis] - domain.low[axis] >= kMaxVoxelsPerAxis) {
        return fail(
            Status::volume_too_large,
            fmt::format("{}: expected fewer than {} cells of level 0 along each axis, found "
                        "{}",
                        path_.string(), kMaxVoxelsPerAxis,
                        domain.high[axis] - domain.low[axis] + 1));
      }
    }
    const auto cells = [&](size_t axis) {
      return static_cast<int32_t>(domain.high[axis] - domain.low[axis] + 1);
    };
    cells_ = {cells(0), cells(1), cells(2)};
    const Vec3d spacing = levels.front().spacing;
    header_.format = "VTK XML";
    header_.name = path_.stem().string();
    header_.grid.spacing = spacing;
    header_.grid.origin = hierarchy_.origin + Vec3d{static_cast<double>(domain.low[0]) * spacing.x,
                                                    static_cast<double>(domain.low[1]) * spacing.y,
                                                    static_cast<double>(domain.low[2]) * spacing.z};
    files_.push_back(path_);
    return {};
  }

  /// Reads a patch from its file.
  Result<void> add(uint32_t level, const VtkAmrPatch& patch) {
    const auto opened = open_vtk_xml(patch.file, options_);
    if (!opened) return tl::unexpected(opened.error());
    const auto index = [](const std::array<int64_t, 3>& at) {
      return Index3{static_cast<int32_t>(at[0]), static_cast<int32_t>(at[1]),
                    static_cast<int32_t>(at[2])};
    };
    const Index3 low = index(patch.low), high = index(patch.high) + Index3{1, 1, 1};
    const Index3 cells{high.x - low.x, high.y - low.y, high.z - low.z};
    const VolumeHeader& header = opened->source->header();
    const Index3 found = header.grid.voxels;
    const bool are_cells = found == cells, are_nodes = found == cells + Index3{1, 1, 1};
    const bool is_first = !grid_;
    if (is_first && (are_cells || are_nodes)) {
      auto made = AdaptiveGrid::create(
          cells_, ratios_, are_cells ? Centring::cells : Centring::nodes, memory_bytes_);
      if (!made) return fail(made.error().status, path_.string() + ": " + made.error().message);
      grid_ = std::move(*made);
    }
    if (!(are_cells || are_nodes) || (grid_->centring() == Centring::cells) != are_cells) {
      return malformed_vtk_xml(
          patch.file,
          fmt::format("expected {}×{}×{} cells as in {}, and values of cells in all patches or in "
                      "none, found {}×{}×{} values",
                      cells.x, cells.y, cells.z, path_.filename().string(), found.x, found.y,
                      found.z));
    }
    if (!is_at(level, low, header.grid, are_cells)) {
      return malformed_vtk_xml(
          patch.file,
          fmt::format("expected the position that {} states for the patch, found another",
                      path_.filename().string()));
    }
    const auto values = read_values(*opened->source);
    if (!values) return tl::unexpected(values.error());
    if (auto added = grid_->add(level, {low, high}, *values); !added) {
      return fail(added.error().status,
                  fmt::format("{}: {}", patch.file.string(), added.error().message));
    }
    for (const std::string& note : opened->notes) {
      // The reader's own note about cells is replaced by one about the nodes.
      if (note.find("belong to cells") == note.npos && known_notes_.insert(note).second) {
        notes_.push_back(note);
      }
    }
    for (const Path& file : opened->source->files()) files_.push_back(file);
    return {};
  }

  /// Whether an image lies where the hierarchy has the patch.
  bool is_at(uint32_t level, Index3 low, const VolumeGrid& image, bool are_cells) const {
    const Vec3d spacing = hierarchy_.levels[level].spacing;
    const double shift = are_cells ? 0.5 : 0;
    const Vec3d& from = header_.grid.origin;
    const auto fits = [&](double found, double origin, int32_t index, double step,
                          double found_step) {
      const double place = (found - origin) / step;
      // Rounded spacings add up over the cells before the patch.
      const double allowed = 0.05 + kTolerance * std::abs(index);
      return std::abs(place - (index + shift)) <= allowed &&
             std::abs(found_step - step) <= kTolerance * step;
    };
    return image.direction == kIdentity3 &&
           fits(image.origin.x, from.x, low.x, spacing.x, image.spacing.x) &&
           fits(image.origin.y, from.y, low.y, spacing.y, image.spacing.y) &&
           fits(image.origin.z, from.z, low.z, spacing.z, image.spacing.z);
  }

  Result<std::vector<double>> read_values(VolumeSource& source) const {
    const VolumeHeader& header = source.header();
    const Index3 n = header.grid.voxels;
    const size_t slice = static_cast<size_t>(n.x) * static_cast<size_t>(n.y);
    std::vector<std::byte> bytes(slice * voxel_bytes(header.type));
    std::vector<double> values;
    values.reserve(slice * static_cast<size_t>(n.z));
    for (int32_t z = 0; z < n.z; ++z) {
      if (auto read = source.read_slices(z, 1, bytes); !read) return tl::unexpected(read.error());
      with_voxel_type(header.type, [&]<class T>(T) {
        for (size_t i = 0; i < slice; ++i) {
          T voxel;
          std::memcpy(&voxel, bytes.data() + i * sizeof(T), sizeof(T));
          const double value = header.value(static_cast<double>(voxel));
          const bool is_missing = options_.missing_value && value == *options_.missing_value;
          values.push_back(is_missing ? std::numeric_limits<double>::quiet_NaN() : value);
        }
      });
    }
    return values;
  }

  const Path& path_;
  const ImportOptions& options_;
  uint64_t memory_bytes_;
  VtkHierarchy hierarchy_;
  std::vector<int32_t> ratios_;
  Index3 cells_;
  VolumeHeader header_;
  std::optional<AdaptiveGrid> grid_;
  std::vector<std::string> notes_;
  std::set<std::string> known_notes_;
  std::vector<Path> files_;
};

}  // namespace

bool is_vtk_amr(std::string_view beginning) {
  const std::string type = vtk_xml_type(beginning);
  return type == "vtkHierarchicalBoxDataSet" || type == "vtkOverlappingAMR";
}

Result<OpenAdaptiveGrid> open_vtk_amr(const Path& path, const ImportOptions& options,
                                      uint64_t memory_bytes) {
  return Reader(path, options, memory_bytes).read();
}

}  // namespace isosplat::import
