#include "shared/import/volume/choose_step.h"

#include <fmt/format.h>

#include "shared/import/volume/volume_choices.h"

namespace isosplat::import {

Result<uint64_t> choose_time_step(const std::filesystem::path& path,
                                  const std::vector<int64_t>& sizes, const ImportOptions& options,
                                  const TimeAxis& times) {
  size_t axes = sizes.size();
  while (axes > 3 && sizes[axes - 1] == 1) --axes;
  if (axes < 3) {
    return fail(Status::no_cells,
                fmt::format("{}: expected a volume with three axes, found an image with {}: give "
                            "the folder of all slices, or the file that contains them all",
                            path.string(), axes));
  }
  if (axes > 4) {
    return fail(Status::unsupported_format,
                fmt::format("{}: expected three axes, or four with time, found {}: save one volume "
                            "as a separate file",
                            path.string(), axes));
  }
  return choose_step(path, axes == 4 ? sizes[3] : 1, options, times);
}

Result<uint64_t> choose_step(const std::filesystem::path& path, int64_t steps,
                             const ImportOptions& options, const TimeAxis& times) {
  if (steps > 1 && !options.time_step) {
    offer_steps(options, static_cast<uint64_t>(steps), times);
    return fail(Status::invalid_argument,
                fmt::format("{}: expected one volume, found {} time steps: choose one with "
                            "--time-step 0 to --time-step {}",
                            path.string(), steps, steps - 1));
  }
  const int64_t step = options.time_step.value_or(0);
  if (step < 0 || step >= steps) {
    return fail(Status::invalid_argument,
                fmt::format("{}: expected a --time-step from 0 to {}, found {}: choose another",
                            path.string(), steps - 1, step));
  }
  return static_cast<uint64_t>(step);
}

}  // namespace isosplat::import
