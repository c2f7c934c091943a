#include "shared/import/dicom/order.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "shared/import/dicom/copies.h"
#include "shared/import/dicom/frame_positions.h"
#include "shared/import/dicom/order_input.h"
#include "shared/import/dicom/segment_order.h"
#include "shared/import/dicom/stack_geometry.h"
#include "shared/import/dicom/step_frames.h"
#include "shared/import/dicom/unplaced_order.h"
#include "shared/import/volume/allowances.h"

namespace isosplat::import::dicom {
namespace {

/// Maximum number of interpolated slices (for missing ones) per existing slice.
constexpr double kMaxFilled = 16;

/// Evenly spaced slices: existing slices, and linear interpolation between them.
void fill_gaps(const std::vector<PositionedFrame>& positioned, double spacing, size_t count,
               Arrangement& out) {
  size_t before = 0;
  for (size_t i = 0; i < count; ++i) {
    const double along = positioned[0].along + spacing * static_cast<double>(i);
    while (before + 2 < positioned.size() && positioned[before + 1].along <= along) ++before;
    const PositionedFrame &a = positioned[before], &b = positioned[before + 1];
    const double weight = (along - a.along) / (b.along - a.along);
    const double near = position_tolerance(spacing) / (b.along - a.along);
    if (weight <= near) {
      out.planes.push_back({a.frame, a.frame, 0, false});
    } else if (weight >= 1 - near) {
      out.planes.push_back({b.frame, b.frame, 0, false});
    } else {
      out.planes.push_back({a.frame, b.frame, weight, false});
    }
  }
}

/// Slices at different positions, in order.
Result<Arrangement> stack_up(const OrderInput& in, const std::vector<PositionedFrame>& positioned) {
  Arrangement out;
  set_plane(in, in.frame_of(positioned[0].frame), out.geometry);
  const double begin = positioned.front().along;
  const double extent = positioned.back().along - begin;
  auto count = static_cast<double>(positioned.size() - 1);
  if (auto r = check_shift(in, positioned, out.geometry); !r) return tl::unexpected(r.error());

  std::vector<double> gaps;
  for (size_t i = 1; i < positioned.size(); ++i)
    gaps.push_back(positioned[i].along - positioned[i - 1].along);
  const auto [min_gap, max_gap] = std::minmax_element(gaps.begin(), gaps.end());
  double worst = 0;
  for (size_t i = 0; i < positioned.size(); ++i) {
    const double even = begin + extent * static_cast<double>(i) / count;
    worst = std::max(worst, std::abs(positioned[i].along - even));
  }
  if (worst <= position_tolerance(extent / count)) {
    for (const PositionedFrame& slice : positioned)
      out.planes.push_back({slice.frame, slice.frame, 0, false});
  } else {
    const std::string what = fmt::format(
        "slices are missing or unevenly spaced (the distances between them are {:.4g} to "
        "{:.4g} mm)",
        *min_gap, *max_gap);
    if (!in.options.allowed.has(Allowance::gaps)) {
      return in.malformed(fmt::format("{}: add the missing slices, or interpolate them with {}",
                                      what, flag_of(Allowance::gaps)));
    }
    // The lower median: of two distances, the larger one includes a gap.
    const size_t middle = (gaps.size() - 1) / 2;
    std::nth_element(gaps.begin(), gaps.begin() + static_cast<std::ptrdiff_t>(middle), gaps.end());
    count = std::max(1.0, std::round(extent / gaps[middle]));
    if (count > kMaxFilled * static_cast<double>(positioned.size())) {
      return in.malformed(what + ": too many are missing");
    }
    fill_gaps(positioned, extent / count, static_cast<size_t>(count) + 1, out);
    const auto made = std::count_if(out.planes.begin(), out.planes.end(),
                                    [](const Plane& plane) { return plane.weight > 0; });
    in.notes.push_back(fmt::format("{}: {} of {} slices are interpolated from their neighbours",
                                   what, made, out.planes.size()));
  }
  set_third_axis(in, positioned, extent, count, out.geometry);
  return out;
}

Result<Arrangement> arrange_frames(const OrderInput& in, const Stack& stack) {
  auto frames = without_copies(in, stack.frames);
  if (!frames) return tl::unexpected(frames.error());
  const Frame& first = in.frame_of(frames->front());
  if (frames->size() < 2) {
    return fail(
        Status::no_cells,
        fmt::format(
            "{}: expected a volume, found a single DICOM slice: give the folder of the series",
            in.path.string()));
  }
  if (!first.is_placed) return arrange_unplaced(in, std::move(*frames));

  const Vec3d normal = cross(first.row, first.column);
  const auto step = frames_of_step(in, in_order(in, *frames, normal), false);
  if (!step) return tl::unexpected(step.error());
  return stack_up(in, in_order(in, *step, normal));
}

}  // namespace

Result<Arrangement> arrange(const Collection& collection, const Stack& stack,
                            const std::filesystem::path& path, const ImportOptions& options,
                            std::vector<std::string>& notes) {
  const OrderInput in{collection, path, options, notes};
  return stack.lattice.empty() ? arrange_frames(in, stack) : arrange_segment(in, stack);
}

}  // namespace isosplat::import::dicom
