#include "shared/import/dicom/step_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "shared/import/dicom/steps.h"
#include "shared/import/volume/allowances.h"
#include "shared/import/volume/choose_step.h"
#include "shared/import/volume/volume_choices.h"

namespace isosplat::import::dicom {
namespace {

/// The n-th frame of the first position that has several frames.
uint32_t nth_of_shared_position(const Positions& positions, size_t which) {
  for (const auto& position : positions) {
    if (position.size() > 1) return position[which];
  }
  return positions[0][0];
}

}  // namespace

Result<std::vector<uint32_t>> frames_of_step(const OrderInput& in,
                                             const std::vector<PositionedFrame>& positioned,
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
                            in.path.string(), positioned.size()));
  }
  if (max_frames == 1) {
    if (auto r = chosen_step(in, 1, ""); !r) return tl::unexpected(r.error());
    std::vector<uint32_t> frames;
    for (const auto& position : positions) frames.push_back(position[0]);
    return frames;
  }
  Steps steps = find_steps(in.collection, positions);
  if (steps.frames.empty()) {
    return in.malformed(fmt::format(
        "expected slices at different positions, or an attribute that distinguishes them (time, "
        "echo, instance number, …), found up to {} slices at the same position, such as {} and "
        "{}: put the files of one volume into a separate folder",
        max_frames, in.name_of(nth_of_shared_position(positions, 0)),
        in.name_of(nth_of_shared_position(positions, 1))));
  }
  const size_t count = steps.frames.size();
  const auto step = chosen_step(in, count, steps.distinguished_by, steps.times);
  if (!step) return tl::unexpected(step.error());
  std::vector<uint32_t>& frames = steps.frames[*step];
  in.notes.push_back(fmt::format("this is volume {} of 0 to {}, distinguished by {}", *step,
                                 count - 1, steps.distinguished_by));
  if (frames.size() < positions.size() && !may_lack) {
    const std::string what = fmt::format("{} of {} slices are missing from volume {}",
                                         positions.size() - frames.size(), positions.size(), *step);
    if (!in.options.allowed.has(Allowance::gaps)) {
      return in.malformed(
          fmt::format("{}: add them, or interpolate them with {}", what, flag_of(Allowance::gaps)));
    }
    if (frames.size() < 2) {
      return fail(Status::no_cells,
                  fmt::format("{}: {}: a single slice has no isosurface", in.path.string(), what));
    }
    in.notes.push_back(what);
  }
  return std::move(frames);
}

Result<size_t> chosen_step(const OrderInput& in, size_t count, const std::string& distinguished_by,
                           const TimeAxis& times) {
  if (count > 1 && !in.options.time_step) {
    offer_steps(in.options, count, times);
    return fail(
        Status::invalid_argument,
        fmt::format("{}: expected one volume, found {} at the same position, distinguished by "
                    "{}: choose one with --time-step 0 to --time-step {}",
                    in.path.string(), count, distinguished_by, count - 1));
  }
  const int64_t step = in.options.time_step.value_or(0);
  if (step < 0 || static_cast<uint64_t>(step) >= count) {
    return fail(Status::invalid_argument,
                fmt::format("{}: expected a --time-step from 0 to {}, found {}: choose another",
                            in.path.string(), count - 1, step));
  }
  return static_cast<size_t>(step);
}

}  // namespace isosplat::import::dicom
