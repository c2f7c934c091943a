#include "shared/import/dicom/segment_order.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "shared/import/dicom/copies.h"
#include "shared/import/dicom/frame_positions.h"
#include "shared/import/dicom/stack_geometry.h"
#include "shared/import/dicom/step_frames.h"
#include "shared/import/dicom/unplaced_order.h"

namespace isosplat::import::dicom {
namespace {

/// Maximum number of slices of a segmentation.
constexpr double kMaxSegmentSlices = 65536;

/// The number of equal steps from the first position of a segmentation to the last. The stated
/// slice distance, or else the smallest distance, determines the step. Errors: if a position is not
/// at a step.
Result<double> lattice_steps(const OrderInput& in,
                             const std::vector<PositionedFrame>& distinct_frames) {
  const double begin = distinct_frames.front().along, extent = distinct_frames.back().along - begin;
  double smallest = extent;
  for (size_t i = 1; i < distinct_frames.size(); ++i) {
    smallest = std::min(smallest, distinct_frames[i].along - distinct_frames[i - 1].along);
  }
  const double stated = in.image_of(distinct_frames.front().frame).stated_slice_spacing;
  for (const double spacing : {stated, smallest}) {
    const double count = spacing > 0 ? std::round(extent / spacing) : 0;
    if (count < 1 || count >= kMaxSegmentSlices) continue;
    const double step = extent / count;
    const bool fits =
        std::all_of(distinct_frames.begin(), distinct_frames.end(), [&](const PositionedFrame& p) {
          const double at = (p.along - begin) / step;
          return std::abs(at - std::round(at)) * step <= position_tolerance(step);
        });
    if (!fits || std::abs(step - spacing) > 0.02 * spacing + 0.01) continue;
    if (!(stated > 0) && count >= static_cast<double>(distinct_frames.size())) {
      in.notes.push_back(fmt::format(
          "the file has no distance between slices (Spacing Between Slices): the smallest "
          "distance between its frames, {:.4g} mm, is assumed",
          step));
    }
    return count;
  }
  return in.malformed(fmt::format(
      "expected the frames of a segmentation at even steps, found distances of {:.4g} mm and "
      "others that are no multiples of it: export it again on evenly spaced slices",
      smallest));
}

}  // namespace

size_t SegmentLattice::slice_of(const Frame& frame) const {
  const double at = std::round((dot(frame.position, normal) - begin) / extent * steps);
  return static_cast<size_t>(std::clamp(at, 0.0, steps));
}

Result<SegmentLattice> segment_lattice(const OrderInput& in, const std::vector<uint32_t>& frames) {
  SegmentLattice out;
  const Frame& any = in.frame_of(frames.front());
  out.normal = cross(any.row, any.column);
  const std::vector<PositionedFrame> distinct_frames = distinct(in_order(in, frames, out.normal));
  if (distinct_frames.size() < 2) {
    return fail(Status::no_cells,
                fmt::format("{}: expected a segmentation with frames at several positions, found "
                            "one position: a single slice has no isosurface",
                            in.path.string()));
  }
  out.first = distinct_frames[0].frame;
  set_plane(in, in.frame_of(out.first), out.geometry);
  if (auto r = check_shift(in, distinct_frames, out.geometry); !r) return tl::unexpected(r.error());
  const auto count = lattice_steps(in, distinct_frames);
  if (!count) return tl::unexpected(count.error());
  out.steps = *count;
  out.begin = distinct_frames.front().along;
  out.extent = distinct_frames.back().along - out.begin;
  set_third_axis(in, distinct_frames, out.extent, out.steps, out.geometry);
  return out;
}

Result<Arrangement> arrange_segment(const OrderInput& in, const Stack& stack) {
  const auto all = without_copies(in, stack.lattice);
  if (!all) return tl::unexpected(all.error());
  std::vector<uint32_t> frames;
  std::set_intersection(stack.frames.begin(), stack.frames.end(), all->begin(), all->end(),
                        std::back_inserter(frames));
  if (!in.frame_of(all->front()).is_placed) return arrange_unplaced(in, std::move(frames));
  const auto lattice = segment_lattice(in, *all);
  if (!lattice) return tl::unexpected(lattice.error());
  const auto step = frames_of_step(in, in_order(in, frames, lattice->normal), true);
  if (!step) return tl::unexpected(step.error());

  Arrangement out;
  out.geometry = lattice->geometry;
  const Plane background{lattice->first, lattice->first, 0, true};
  out.planes.assign(static_cast<size_t>(lattice->steps) + 1, background);
  for (const uint32_t frame : *step) {
    out.planes[lattice->slice_of(in.frame_of(frame))] = {frame, frame, 0, false};
  }
  const auto empty = std::count_if(out.planes.begin(), out.planes.end(),
                                   [](const Plane& plane) { return plane.is_background; });
  if (empty > 0) {
    in.notes.push_back(
        fmt::format("{} of {} slices have no frame in the file: they are outside the segment",
                    empty, out.planes.size()));
  }
  return out;
}

}  // namespace isosplat::import::dicom
