#include "shared/import/dicom/stack_geometry.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace isosplat::import::dicom {
namespace {

/// A smaller gantry tilt is treated as rounding.
constexpr double kMinTiltDegrees = 0.1;

void set_column(HeaderGeometry& geometry, size_t column, Vec3d axis) {
  geometry.direction[column] = axis.x;
  geometry.direction[3 + column] = axis.y;
  geometry.direction[6 + column] = axis.z;
}

}  // namespace

void set_plane(const OrderInput& in, const Frame& frame, HeaderGeometry& geometry) {
  geometry.origin = frame.position;
  if (!(frame.spacing_x > 0) && !in.options.spacing) {
    in.notes.push_back(
        "the slices have no pixel spacing: 1 mm is assumed; --spacing sets "
        "another");
  }
  geometry.spacing.x = frame.spacing_x > 0 ? frame.spacing_x : 1;
  geometry.spacing.y = frame.spacing_y > 0 ? frame.spacing_y : 1;
  set_column(geometry, 0, frame.row);
  set_column(geometry, 1, frame.column);
  set_column(geometry, 2, cross(frame.row, frame.column));
}

Result<void> check_shift(const OrderInput& in, const std::vector<PositionedFrame>& positioned,
                         const HeaderGeometry& geometry) {
  const Frame& first = in.frame_of(positioned.front().frame);
  const Vec3d span = in.frame_of(positioned.back().frame).position - first.position;
  const double extent = positioned.back().along - positioned.front().along;
  const double pixel = std::min(geometry.spacing.x, geometry.spacing.y);
  const double tolerance = std::max(std::min(0.06, 0.25 * pixel), 0.05 * pixel);
  for (const PositionedFrame& slice : positioned) {
    const Vec3d expected =
        first.position + span * ((slice.along - positioned.front().along) / extent);
    const double off = length(in.frame_of(slice.frame).position - expected);
    if (off > tolerance) {
      return in.malformed(
          fmt::format("expected slices in line or with an even shift, found {} {:.3g} mm off "
                      "that line: they are no "
                      "volume",
                      in.name_of(slice.frame), off));
    }
  }
  return {};
}

void set_third_axis(const OrderInput& in, const std::vector<PositionedFrame>& positioned,
                    double extent, double count, HeaderGeometry& geometry) {
  const Vec3d span = in.frame_of(positioned.back().frame).position -
                     in.frame_of(positioned.front().frame).position;
  const double distance = length(span);
  geometry.spacing.z = distance / count;
  set_column(geometry, 2, span * (1 / distance));
  const double tilt = std::acos(std::min(1.0, extent / distance)) * 180 / 3.14159265358979;
  if (tilt >= kMinTiltDegrees) {
    in.notes.push_back(fmt::format(
        "the slices are shifted relative to each other: the gantry was tilted by {:.1f}°", tilt));
  }
  const double stated = in.image_of(positioned[0].frame).stated_slice_spacing;
  const double found = extent / count;
  const auto agrees = [&](double d) { return std::abs(stated - d) <= 0.02 * d + 0.01; };
  if (stated > 0 && !agrees(found) && !agrees(distance / count)) {
    in.notes.push_back(
        fmt::format("the slice distance is {:.4g} mm in the header, but {:.4g} mm by the "
                    "positions: the positions are used",
                    stated, found));
  }
}

}  // namespace isosplat::import::dicom
