#include "shared/import/dicom/unplaced_order.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "shared/import/dicom/frame_positions.h"
#include "shared/import/dicom/stack_geometry.h"
#include "shared/import/dicom/step_frames.h"
#include "shared/import/volume/allowances.h"

namespace isosplat::import::dicom {
namespace {

/// Whether all frames have a number, and no two the same.
template <class NumberOf>
bool all_differ(const std::vector<uint32_t>& frames, const NumberOf& number_of) {
  std::set<double> numbers;
  for (const uint32_t frame : frames) {
    if (std::isnan(number_of(frame))) return false;
    numbers.insert(number_of(frame));
  }
  return numbers.size() == frames.size();
}

}  // namespace

Result<Arrangement> arrange_unplaced(const OrderInput& in, std::vector<uint32_t> frames) {
  const auto location = [&](uint32_t frame) { return in.frame_of(frame).location; };
  const auto number = [&](uint32_t frame) {
    return in.frame_of(frame).keys[static_cast<size_t>(Key::instance)];
  };
  const bool has_locations = all_differ(frames, location);
  const char* const by = has_locations ? "slice locations" : "instance numbers";
  const std::string what =
      fmt::format("{} slices have no position (Image Position)", frames.size());
  if (!in.options.allowed.has(Allowance::unplaced)) {
    return in.malformed(
        fmt::format("{}: export them again, or stack them in the order of their {} with {}", what,
                    by, flag_of(Allowance::unplaced)));
  }
  if (!has_locations && !all_differ(frames, number)) {
    return in.malformed(
        what + ", and their instance numbers are missing or duplicated: their order is unknown");
  }
  std::sort(frames.begin(), frames.end(), [&](uint32_t a, uint32_t b) {
    return has_locations ? location(a) < location(b) : number(a) < number(b);
  });
  if (auto r = chosen_step(in, 1, ""); !r) return tl::unexpected(r.error());
  Arrangement out;
  set_plane(in, in.frame_of(frames[0]), out.geometry);
  const Image& image = in.image_of(frames[0]);
  const auto steps = static_cast<double>(frames.size() - 1);
  double distance = image.stated_slice_spacing;
  std::string source = "Spacing Between Slices";
  if (has_locations) {
    const double begin = location(frames.front()), extent = location(frames.back()) - begin;
    distance = extent / steps;
    source = "their slice locations";
    for (size_t i = 0; i < frames.size(); ++i) {
      const double off = location(frames[i]) - begin - distance * static_cast<double>(i);
      if (std::abs(off) > position_tolerance(distance)) {
        return in.malformed(what + ", and their slice locations are unevenly spaced");
      }
    }
  } else if (!(distance > 0)) {
    distance = image.slice_thickness > 0 ? image.slice_thickness : 1;
    source = image.slice_thickness > 0 ? "the slice thickness"
                                       : "assumed, since no file states a distance";
  }
  out.geometry.spacing.z = distance;
  in.notes.push_back(
      fmt::format("{}: they are stacked along row × column in the order of their {}, at a "
                  "distance of {:.4g} mm ({}); --spacing sets another distance",
                  what, by, distance, source));
  for (const uint32_t frame : frames) out.planes.push_back({frame, frame, 0, false});
  return out;
}

}  // namespace isosplat::import::dicom
