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

/// The number of equal steps from the first position of a segmentation to the last, so that every
/// position is at a step: by the stated slice distance, or else by the smallest distance.
Result<double> lattice_steps(const OrderInput& in, const std::vector<PositionedFrame>& places) {
  const double begin = places.front().along, extent = places.back().along - begin;
  double smallest = extent;
  for (size_t i = 1; i < places.size(); ++i) {
    smallest = std::min(smallest, places[i].along - places[i - 1].along);
  }
  const double stated = in.image_of(places.front().frame).stated_slice_spacing;
  for (const double spacing : {stated, smallest}) {
    const double count = spacing > 0 ? std::round(extent / spacing) : 0;
    if (count < 1 || count >= kMaxSegmentSlices) continue;
    const double step = extent / count;
    const bool fits = std::all_of(places.begin(), places.end(), [&](const PositionedFrame& p) {
      const double at = (p.along - begin) / step;
      return std::abs(at - std::round(at)) * step <= position_tolerance(step);
    });
    if (!fits || std::abs(step - spacing) > 0.02 * spacing + 0.01) continue;
    if (!(stated > 0) && count >= static_cast<double>(places.size())) {
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

Result<Arrangement> arrange_segment(const OrderInput& in, const Stack& stack) {
  const auto lattice = without_copies(in, stack.lattice);
  if (!lattice) return tl::unexpected(lattice.error());
  std::vector<uint32_t> frames;
  std::set_intersection(stack.frames.begin(), stack.frames.end(), lattice->begin(), lattice->end(),
                        std::back_inserter(frames));
  const Frame& first = in.frame_of(lattice->front());
  if (!first.is_placed) return arrange_unplaced(in, std::move(frames));
  const Vec3d normal = cross(first.row, first.column);
  const std::vector<PositionedFrame> places = distinct(in_order(in, *lattice, normal));
  if (places.size() < 2) {
    return fail(Status::no_cells,
                fmt::format("{}: expected a segmentation with frames at several positions, found "
                            "one position: a single slice has no isosurface",
                            in.path.string()));
  }
  const auto step = frames_of_step(in, in_order(in, frames, normal), true);
  if (!step) return tl::unexpected(step.error());

  Arrangement out;
  set_plane(in, in.frame_of(places[0].frame), out.geometry);
  if (auto r = check_shift(in, places, out.geometry); !r) return tl::unexpected(r.error());
  const auto count = lattice_steps(in, places);
  if (!count) return tl::unexpected(count.error());
  const double begin = places.front().along, extent = places.back().along - begin;
  const Plane background{places[0].frame, places[0].frame, 0, true};
  out.planes.assign(static_cast<size_t>(*count) + 1, background);
  for (const PositionedFrame& slice : in_order(in, *step, normal)) {
    const double at = std::round((slice.along - begin) / extent * *count);
    out.planes[static_cast<size_t>(at)] = {slice.frame, slice.frame, 0, false};
  }
  const auto empty = std::count_if(out.planes.begin(), out.planes.end(),
                                   [](const Plane& plane) { return plane.is_background; });
  if (empty > 0) {
    in.notes.push_back(
        fmt::format("{} of {} slices have no frame in the file: they are outside the segment",
                    empty, out.planes.size()));
  }
  set_third_axis(in, places, extent, *count, out.geometry);
  return out;
}

}  // namespace isosplat::import::dicom
