#include "shared/import/dicom/order.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>
#include <tuple>

#include "shared/import/dicom/steps.h"
#include "shared/import/volume/choose_step.h"
#include "shared/import/volume/import_options.h"
#include "shared/import/volume/volume_choices.h"

namespace isosplat::import::dicom {
namespace {

/// Tolerance of positions: files round them to as little as 0.1 mm, so half of that, or a hundredth
/// of the slice distance, is accepted. A deviation of a tenth of the distance is always an error.
double position_tolerance(double spacing) {
  return std::max(0.01 * spacing, std::min(0.1 * spacing, 0.06));
}

/// Limit of interpolated slices (for missing ones) per existing slice.
constexpr double kMaxFilled = 16;

/// Limit of a segmentation's slices.
constexpr double kMaxSegmentSlices = 65536;

/// A smaller gantry tilt is treated as rounding.
constexpr double kMinTiltDegrees = 0.1;

struct PositionedFrame {
  uint32_t frame;
  double along;  ///< position along the normal
};

class StackOrderer {
 public:
  StackOrderer(const Collection& collection, const std::filesystem::path& path,
               const ImportOptions& options, std::vector<std::string>& notes)
      : collection_(collection), path_(path), options_(options), notes_(notes) {}

  Result<Arrangement> arrange(const Stack& stack) {
    auto frames = without_copies(stack.frames);
    if (!frames) return tl::unexpected(frames.error());
    const Frame& first = frame_of(frames->front());
    if (frames->size() < 2) {
      return fail(
          Status::no_cells,
          fmt::format(
              "{}: expected a volume, found a single DICOM slice: give the folder of the series",
              path_.string()));
    }
    if (!first.is_placed) return without_positions(std::move(*frames));

    const Vec3d normal = cross(first.row, first.column);
    const auto step = choose_step(in_order(*frames, normal), false);
    if (!step) return tl::unexpected(step.error());
    return stack_up(in_order(*step, normal));
  }

  /// Orders the frames of a segment. Files omit frames that have nothing of the segment, so slices
  /// without a frame are background.
  Result<Arrangement> arrange_segment(const Stack& stack) {
    const auto lattice = without_copies(stack.lattice);
    if (!lattice) return tl::unexpected(lattice.error());
    std::vector<uint32_t> frames;
    std::set_intersection(stack.frames.begin(), stack.frames.end(), lattice->begin(),
                          lattice->end(), std::back_inserter(frames));
    const Frame& first = frame_of(lattice->front());
    if (!first.is_placed) return without_positions(std::move(frames));
    const Vec3d normal = cross(first.row, first.column);
    const std::vector<PositionedFrame> places = distinct(in_order(*lattice, normal));
    if (places.size() < 2) {
      return fail(Status::no_cells,
                  fmt::format("{}: expected a segmentation with frames at several positions, found "
                              "one position: a single slice has no isosurface",
                              path_.string()));
    }
    const auto step = choose_step(in_order(frames, normal), true);
    if (!step) return tl::unexpected(step.error());

    Arrangement out;
    set_plane(frame_of(places[0].frame), out.geometry);
    if (auto r = check_shift(places, out.geometry); !r) return tl::unexpected(r.error());
    const auto count = lattice_steps(places);
    if (!count) return tl::unexpected(count.error());
    const double begin = places.front().along, extent = places.back().along - begin;
    const Plane background{places[0].frame, places[0].frame, 0, true};
    out.planes.assign(static_cast<size_t>(*count) + 1, background);
    for (const PositionedFrame& slice : in_order(*step, normal)) {
      const double at = std::round((slice.along - begin) / extent * *count);
      out.planes[static_cast<size_t>(at)] = {slice.frame, slice.frame, 0, false};
    }
    const auto empty = std::count_if(out.planes.begin(), out.planes.end(),
                                     [](const Plane& plane) { return plane.is_background; });
    if (empty > 0) {
      notes_.push_back(
          fmt::format("{} of {} slices have no frame in the file: they are outside the segment",
                      empty, out.planes.size()));
    }
    set_third_axis(places, extent, *count, out.geometry);
    return out;
  }

 private:
  const Frame& frame_of(uint32_t index) const { return collection_.frames[index]; }
  const Image& image_of(uint32_t index) const { return collection_.images[frame_of(index).image]; }

  tl::unexpected<Error> malformed(const std::string& text) const {
    return fail(Status::malformed_volume, fmt::format("{}: {}", path_.string(), text));
  }

  /// Frames with their positions along the normal, in order.
  std::vector<PositionedFrame> in_order(const std::vector<uint32_t>& frames, Vec3d normal) const {
    std::vector<PositionedFrame> positioned;
    for (const uint32_t frame : frames) {
      positioned.push_back({frame, dot(frame_of(frame).position, normal)});
    }
    std::stable_sort(
        positioned.begin(), positioned.end(),
        [](const PositionedFrame& a, const PositionedFrame& b) { return a.along < b.along; });
    return positioned;
  }

  /// Whether two positions in a stack are different. Distances may be much smaller than their mean
  /// if many slices are missing.
  static double same_position(const std::vector<PositionedFrame>& positioned) {
    const double extent = positioned.back().along - positioned.front().along;
    const double mean = extent / static_cast<double>(std::max<size_t>(positioned.size() - 1, 1));
    return std::min(0.05 * mean, 0.01);
  }

  /// One frame for each position.
  static std::vector<PositionedFrame> distinct(const std::vector<PositionedFrame>& positioned) {
    const double tolerance = same_position(positioned);
    std::vector<PositionedFrame> places;
    for (const PositionedFrame& slice : positioned) {
      if (places.empty() || slice.along - places.back().along > tolerance) places.push_back(slice);
    }
    return places;
  }

  /// The number of equal steps from the first place of a segmentation to the last, so that every
  /// place is at a step: by the stated distance of slices, or else by the smallest distance.
  Result<double> lattice_steps(const std::vector<PositionedFrame>& places) {
    const double begin = places.front().along, extent = places.back().along - begin;
    double smallest = extent;
    for (size_t i = 1; i < places.size(); ++i) {
      smallest = std::min(smallest, places[i].along - places[i - 1].along);
    }
    const double stated = image_of(places.front().frame).stated_slice_spacing;
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
        notes_.push_back(fmt::format(
            "the file has no distance between slices (Spacing Between Slices): the smallest "
            "distance between its frames, {:.4g} mm, is assumed",
            step));
      }
      return count;
    }
    return malformed(fmt::format(
        "expected the frames of a segmentation at even steps, found distances of {:.4g} mm and "
        "others that are no multiples of it: export it again on evenly spaced slices",
        smallest));
  }

  /// Removes duplicate files.
  Result<std::vector<uint32_t>> without_copies(const std::vector<uint32_t>& frames) {
    std::map<std::tuple<std::string_view, uint32_t, uint32_t>, uint32_t> frame_by_uid;
    std::vector<uint32_t> kept;
    for (const uint32_t frame : frames) {
      const std::string_view uid = image_of(frame).instance_uid;
      if (uid.empty()) {
        kept.push_back(frame);
        continue;
      }
      const auto [found, is_new] =
          frame_by_uid.try_emplace({uid, frame_of(frame).index, frame_of(frame).tile}, frame);
      if (is_new) {
        kept.push_back(frame);
      } else if (!is_copy(frame_of(frame), frame_of(found->second))) {
        return malformed(
            fmt::format("expected different instance numbers (SOP Instance UID) for "
                        "different slices, found {} in {} and {}: export the series "
                        "again",
                        uid, image_of(frame).file, image_of(found->second).file));
      }
    }
    if (const size_t copies = frames.size() - kept.size(); copies > 0) {
      notes_.push_back(fmt::format("{} slice{} duplicated: the copies are ignored", copies,
                                   copies > 1 ? "s are" : " is"));
    }
    return kept;
  }

  bool is_copy(const Frame& a, const Frame& b) const {
    const auto same = [](double x, double y) { return x == y || (std::isnan(x) && std::isnan(y)); };
    return a.position == b.position && a.slope == b.slope && a.intercept == b.intercept &&
           std::equal(a.keys.begin(), a.keys.end(), b.keys.begin(), same);
  }

  /// The frames of the selected time step, one per position. `may_lack`: positions without a frame
  /// of the step are no error.
  Result<std::vector<uint32_t>> choose_step(const std::vector<PositionedFrame>& positioned,
                                            bool may_lack) {
    const double tolerance = same_position(positioned);
    Positions positions;
    double last = 0;
    size_t max_frames = 1;
    for (const PositionedFrame& slice : positioned) {
      if (positions.empty() || slice.along - last > tolerance) {
        positions.emplace_back();
        last = slice.along;
      }
      positions.back().push_back(slice.frame);
      max_frames = std::max(max_frames, positions.back().size());
    }
    if (positions.size() < 2 && !may_lack) {
      return fail(Status::no_cells,
                  fmt::format("{}: expected slices at different positions, found all {} at the "
                              "same position: a single slice has no isosurface",
                              path_.string(), positioned.size()));
    }
    if (max_frames == 1) {
      if (auto r = chosen_step(1, ""); !r) return tl::unexpected(r.error());
      std::vector<uint32_t> frames;
      for (const auto& position : positions) frames.push_back(position[0]);
      return frames;
    }
    Steps steps = find_steps(collection_, positions);
    if (steps.frames.empty()) {
      return malformed(fmt::format(
          "expected slices at different positions, or an attribute that distinguishes them (time, "
          "echo, instance number, …), found up to {} slices at the same position, such as {} and "
          "{}: put the files of one volume into a separate folder",
          max_frames, name_of(nth_of_shared_position(positions, 0)),
          name_of(nth_of_shared_position(positions, 1))));
    }
    const size_t count = steps.frames.size();
    const auto step = chosen_step(count, steps.distinguished_by);
    if (!step) return tl::unexpected(step.error());
    std::vector<uint32_t>& frames = steps.frames[*step];
    notes_.push_back(fmt::format("this is volume {} of 0 to {}, distinguished by {}", *step,
                                 count - 1, steps.distinguished_by));
    if (frames.size() < positions.size() && !may_lack) {
      const std::string what =
          fmt::format("{} of {} slices are missing from volume {}",
                      positions.size() - frames.size(), positions.size(), *step);
      if (!options_.allowed.has(Allowance::gaps)) {
        return malformed(fmt::format("{}: add them, or interpolate them with {}", what,
                                     flag_of(Allowance::gaps)));
      }
      if (frames.size() < 2) {
        return fail(Status::no_cells,
                    fmt::format("{}: {}: a single slice has no isosurface", path_.string(), what));
      }
      notes_.push_back(what);
    }
    return std::move(frames);
  }

  /// Selects one of several volumes by the options. Errors: invalid_argument.
  Result<size_t> chosen_step(size_t count, const std::string& distinguished_by) const {
    if (count > 1 && !options_.time_step) {
      offer_steps(options_, count);
      return fail(
          Status::invalid_argument,
          fmt::format("{}: expected one volume, found {} at the same position, distinguished by "
                      "{}: choose one with --time-step 0 to --time-step {}",
                      path_.string(), count, distinguished_by, count - 1));
    }
    const int64_t step = options_.time_step.value_or(0);
    if (step < 0 || static_cast<uint64_t>(step) >= count) {
      return fail(Status::invalid_argument,
                  fmt::format("{}: expected a --time-step from 0 to {}, found {}: choose another",
                              path_.string(), count - 1, step));
    }
    return static_cast<size_t>(step);
  }

  /// The n-th frame of the first position that has several frames.
  static uint32_t nth_of_shared_position(const Positions& positions, size_t which) {
    for (const auto& position : positions) {
      if (position.size() > 1) return position[which];
    }
    return positions[0][0];
  }

  std::string name_of(uint32_t frame) const {
    const Image& image = image_of(frame);
    const std::string name = std::filesystem::path(image.file).filename().string();
    return image.frames == 1 ? name
                             : fmt::format("frame {} of {}", frame_of(frame).index + 1, name);
  }

  /// The pixel spacing of a stack; 1 if it is unknown.
  void set_plane(const Frame& frame, HeaderGeometry& geometry) {
    geometry.origin = frame.position;
    if (!(frame.spacing_x > 0) && !options_.spacing) {
      notes_.push_back(
          "the slices have no pixel spacing: 1 mm is assumed; --spacing sets "
          "another");
    }
    geometry.spacing.x = frame.spacing_x > 0 ? frame.spacing_x : 1;
    geometry.spacing.y = frame.spacing_y > 0 ? frame.spacing_y : 1;
    set_column(geometry, 0, frame.row);
    set_column(geometry, 1, frame.column);
    set_column(geometry, 2, cross(frame.row, frame.column));
  }

  static void set_column(HeaderGeometry& geometry, size_t column, Vec3d axis) {
    geometry.direction[column] = axis.x;
    geometry.direction[3 + column] = axis.y;
    geometry.direction[6 + column] = axis.z;
  }

  /// Slices at different positions, in order.
  Result<Arrangement> stack_up(const std::vector<PositionedFrame>& positioned) {
    Arrangement out;
    set_plane(frame_of(positioned[0].frame), out.geometry);
    const double begin = positioned.front().along;
    const double extent = positioned.back().along - begin;
    auto count = static_cast<double>(positioned.size() - 1);
    if (auto r = check_shift(positioned, out.geometry); !r) return tl::unexpected(r.error());

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
      if (!options_.allowed.has(Allowance::gaps)) {
        return malformed(fmt::format("{}: add the missing slices, or interpolate them with {}",
                                     what, flag_of(Allowance::gaps)));
      }
      // The lower median: of two distances, the larger one is a gap.
      const size_t middle = (gaps.size() - 1) / 2;
      std::nth_element(gaps.begin(), gaps.begin() + static_cast<std::ptrdiff_t>(middle),
                       gaps.end());
      count = std::max(1.0, std::round(extent / gaps[middle]));
      if (count > kMaxFilled * static_cast<double>(positioned.size())) {
        return malformed(what + ": too many are missing");
      }
      fill_gaps(positioned, extent / count, static_cast<size_t>(count) + 1, out);
      const auto made = std::count_if(out.planes.begin(), out.planes.end(),
                                      [](const Plane& plane) { return plane.weight > 0; });
      notes_.push_back(fmt::format("{}: {} of {} slices are interpolated from their neighbours",
                                   what, made, out.planes.size()));
    }
    set_third_axis(positioned, extent, count, out.geometry);
    return out;
  }

  /// Evenly spaced slices: existing slices, and linear interpolation between them.
  void fill_gaps(const std::vector<PositionedFrame>& positioned, double spacing, size_t count,
                 Arrangement& out) const {
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

  /// Each slice may be shifted in its plane relative to the previous one, all by the same vector
  /// (gantry tilt).
  Result<void> check_shift(const std::vector<PositionedFrame>& positioned,
                           const HeaderGeometry& geometry) const {
    const Frame& first = frame_of(positioned.front().frame);
    const Vec3d way = frame_of(positioned.back().frame).position - first.position;
    const double extent = positioned.back().along - positioned.front().along;
    const double pixel = std::min(geometry.spacing.x, geometry.spacing.y);
    const double tolerance = std::max(std::min(0.06, 0.25 * pixel), 0.05 * pixel);
    for (const PositionedFrame& slice : positioned) {
      const Vec3d expected =
          first.position + way * ((slice.along - positioned.front().along) / extent);
      const double off = length(frame_of(slice.frame).position - expected);
      if (off > tolerance) {
        return malformed(
            fmt::format("expected slices in line or with an even shift, found {} {:.3g} mm off "
                        "that line: they are no "
                        "volume",
                        name_of(slice.frame), off));
      }
    }
    return {};
  }

  /// The third axis points from the first slice to the last.
  void set_third_axis(const std::vector<PositionedFrame>& positioned, double extent, double count,
                      HeaderGeometry& geometry) {
    const Vec3d way =
        frame_of(positioned.back().frame).position - frame_of(positioned.front().frame).position;
    const double distance = length(way);
    geometry.spacing.z = distance / count;
    set_column(geometry, 2, way * (1 / distance));
    const double tilt = std::acos(std::min(1.0, extent / distance)) * 180 / 3.14159265358979;
    if (tilt >= kMinTiltDegrees) {
      notes_.push_back(fmt::format(
          "the slices are shifted relative to each other: the gantry was tilted by {:.1f}°", tilt));
    }
    const double stated = image_of(positioned[0].frame).stated_slice_spacing;
    const double found = extent / count;
    const auto agrees = [&](double d) { return std::abs(stated - d) <= 0.02 * d + 0.01; };
    if (stated > 0 && !agrees(found) && !agrees(distance / count)) {
      notes_.push_back(
          fmt::format("the slice distance is {:.4g} mm in the header, but {:.4g} mm by the "
                      "positions: the positions are used",
                      stated, found));
    }
  }

  /// Orders slices without positions: by their slice locations if all have different ones, else by
  /// their instance numbers.
  Result<Arrangement> without_positions(std::vector<uint32_t> frames) {
    const auto location = [&](uint32_t frame) { return frame_of(frame).location; };
    const auto number = [&](uint32_t frame) {
      return frame_of(frame).keys[static_cast<size_t>(Key::instance)];
    };
    const bool has_locations = all_differ(frames, location);
    const char* const by = has_locations ? "slice locations" : "instance numbers";
    const std::string what =
        fmt::format("{} slices have no position (Image Position)", frames.size());
    if (!options_.allowed.has(Allowance::unplaced)) {
      return malformed(
          fmt::format("{}: export them again, or stack them in the order of their {} with {}", what,
                      by, flag_of(Allowance::unplaced)));
    }
    if (!has_locations && !all_differ(frames, number)) {
      return malformed(
          what + ", and their instance numbers are missing or duplicated: their order is unknown");
    }
    std::sort(frames.begin(), frames.end(), [&](uint32_t a, uint32_t b) {
      return has_locations ? location(a) < location(b) : number(a) < number(b);
    });
    if (auto r = chosen_step(1, ""); !r) return tl::unexpected(r.error());
    Arrangement out;
    set_plane(frame_of(frames[0]), out.geometry);
    const Image& image = image_of(frames[0]);
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
          return malformed(what + ", and their slice locations are unevenly spaced");
        }
      }
    } else if (!(distance > 0)) {
      distance = image.slice_thickness > 0 ? image.slice_thickness : 1;
      source = image.slice_thickness > 0 ? "the slice thickness"
                                         : "assumed, since no file states a distance";
    }
    out.geometry.spacing.z = distance;
    notes_.push_back(
        fmt::format("{}: they are stacked along row × column in the order of their {}, at a "
                    "distance of {:.4g} mm ({}); --spacing sets another distance",
                    what, by, distance, source));
    for (const uint32_t frame : frames) out.planes.push_back({frame, frame, 0, false});
    return out;
  }

  /// Whether all frames have a number, and no two the same.
  template <class NumberOf>
  static bool all_differ(const std::vector<uint32_t>& frames, const NumberOf& number_of) {
    std::set<double> numbers;
    for (const uint32_t frame : frames) {
      if (std::isnan(number_of(frame))) return false;
      numbers.insert(number_of(frame));
    }
    return numbers.size() == frames.size();
  }

  const Collection& collection_;
  const std::filesystem::path& path_;
  const ImportOptions& options_;
  std::vector<std::string>& notes_;
};

}  // namespace

Result<Arrangement> arrange(const Collection& collection, const Stack& stack,
                            const std::filesystem::path& path, const ImportOptions& options,
                            std::vector<std::string>& notes) {
  StackOrderer orderer(collection, path, options, notes);
  return stack.lattice.empty() ? orderer.arrange(stack) : orderer.arrange_segment(stack);
}

}  // namespace isosplat::import::dicom
