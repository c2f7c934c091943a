#include "native/cli/options.h"

#include <fmt/format.h>

#include <limits>

#include "native/builder/machine_memory.h"
#include "native/cli/numbers.h"
#include "native/cli/terminal.h"
#include "shared/import/volume/type_names.h"

namespace isosplat::cli {
namespace {

tl::unexpected<Error> usage(const std::string& message) {
  return fail(Status::invalid_argument, message);
}

}  // namespace

void VolumeFlags::add_to(CLI::App& command) {
  command
      .add_option("--spacing", spacing_,
                  "Distance between voxels along each axis (default: as in the file)")
      ->type_name("X,Y,Z");
  command.add_option("--time-step", time_step_, "Index of the volume in a 4D file, from 0")
      ->check(is_whole_number(0, std::numeric_limits<int64_t>::max()));
  command
      .add_option("--series", series_,
                  "DICOM: number of the series in the list that isosplat prints, or its UID "
                  "(default: the series with the most voxels); TIFF: number or name of the image, "
                  "if the file has several")
      ->type_name("NUMBER|UID|NAME");
  command
      .add_option("--channel", channel_, "Index of the channel, from 0, if the file has several")
      ->check(is_whole_number(0, std::numeric_limits<int64_t>::max()));
  command
      .add_option("--segment", segment_,
                  "DICOM segmentations: number or label of the segment, if the file has several")
      ->type_name("NUMBER|LABEL");
  command
      .add_option(
          "--dataset", dataset_,
          "HDF5, netCDF: path of the dataset; .npz: name of the array, if the file has several; "
          "OME-Zarr: path of the scale (default: the finest); VTK XML: name of the array")
      ->type_name("PATH");
  command.add_option("--dims", dims_, "Raw files: number of voxels along each axis")
      ->type_name("XxYxZ");
  command.add_option(
      "--type", type_,
      "Raw files: type of the voxels: u8, i8, u16, i16, u32, i32, u64, i64, f32 or f64");
  command.add_option("--endian", endian_, "Raw files: byte order")
      ->check(CLI::IsMember({"little", "big"}));
  command.add_option("--skip-bytes", skip_bytes_, "Raw files: bytes before the first voxel")
      ->check(is_whole_number(0, std::numeric_limits<int64_t>::max()));
  command
      .add_option(
          "--missing-value", missing_value_,
          "Value of missing voxels, or the word none if no voxel is missing (default: the value "
          "that the file declares, or a single value far outside the range of all others)")
      ->type_name("VALUE");
  for (const import::AllowanceFlag& allowance : import::kAllowances) {
    command.add_flag_callback(
        allowance.flag, [this, &allowance] { allowed_.add(allowance.allowance); }, allowance.help);
  }
}

Result<import::ImportOptions> VolumeFlags::options() const {
  import::ImportOptions options;
  if (!dims_.empty()) {
    options.dims = parse_whole_triple(dims_);
    const auto fits = [](int64_t d) { return d >= 1 && d <= 1'000'000'000; };
    if (!options.dims || !fits(options.dims->x) || !fits(options.dims->y) ||
        !fits(options.dims->z)) {
      return usage(fmt::format(
          "--dims: expected three whole numbers such as 256x256x128, found '{}'", dims_));
    }
  }
  if (!type_.empty()) {
    options.type = import::voxel_type_of(type_);
    if (!options.type) {
      return usage(fmt::format(
          "--type: expected one of u8, i8, u16, i16, u32, i32, u64, i64, f32 and f64, found '{}'",
          type_));
    }
  }
  if (!spacing_.empty()) {
    options.spacing = parse_triple(spacing_);
    const auto positive = [](double d) { return d > 0 && d < 1e12; };
    if (!options.spacing || !positive(options.spacing->x) || !positive(options.spacing->y) ||
        !positive(options.spacing->z)) {
      return usage(fmt::format(
          "--spacing: expected three positive numbers such as 1,1,2.5, found '{}'", spacing_));
    }
  }
  if (!endian_.empty()) options.big_endian = endian_ == "big";
  options.skip_bytes = skip_bytes_;
  if (time_step_ >= 0) options.time_step = time_step_;
  if (channel_ >= 0) options.channel = channel_;
  options.series = series_;
  options.segment = segment_;
  options.dataset = dataset_;
  options.allowed = allowed_;
  if (missing_value_ == "none") {
    options.finds_missing_values = false;
  } else if (!missing_value_.empty()) {
    options.missing_value = parse_number(missing_value_);
    if (!options.missing_value) {
      return usage(fmt::format(
          "--missing-value: expected a number such as -9999, or none, found '{}'", missing_value_));
    }
  }
  return options;
}

std::string VolumeFlags::key() const {
  std::string text =
      fmt::format("{}\n{}\n{}\n{}\n{}\n{}\n{}\n{}\n{}\n{}\n{}", dims_, type_, spacing_, endian_,
                  skip_bytes_, time_step_, missing_value_, series_, segment_, channel_, dataset_);
  for (const import::AllowanceFlag& allowance : import::kAllowances) {
    if (allowed_.has(allowance.allowance)) text += fmt::format("\n{}", allowance.flag);
  }
  return text;
}

void BuildFlags::add_to(CLI::App& command) {
  command.add_option("--memory", memory_, "Limit of the memory that the build uses")
      ->type_name("SIZE")
      ->capture_default_str();
  command.add_option("--threads", threads_, "Number of threads (0: one per core)")
      ->check(is_whole_number(0, kMaxThreads))
      ->capture_default_str();
  command
      .add_option("--fetch-weight", fetch_weight_,
                  "Weight of the bytes that an isovalue fetches, relative to the bytes of the "
                  "store. A larger weight makes the store larger and each fetch smaller (isosplat "
                  "build --help has a table)")
      ->check(is_number(0.01, 100))
      ->capture_default_str();
  command
      .add_option(
          "--max-error", max_error_,
          "Largest difference between a voxel and its stored value, in the volume's units. "
          "A larger one makes the store smaller (default: integers and evenly spaced "
          "numbers are lossless, others are as exact as 16 bits allow). Unstructured grids: "
          "largest difference to the values of the mesh (default: 0.5 % of their range)")
      ->check(is_above_zero());
  command
      .add_option("--range", range_,
                  "LOW,HIGH: the range of values that the store keeps; values outside are set to "
                  "its ends. The volume is read once less, and all steps of a series have the same "
                  "quantized values")
      ->delimiter(',')
      ->check(is_number())
      ->expected(2);
  command.add_option("--name", title_, "Title of the volume (default: the file's name)");
  command.add_option("--units", units_, "Unit of the values, such as HU");
  command.add_option("--temporary-folder", temporary_folder_,
                     "Folder for coarse levels that do not fit in memory (default: the store's)");
}

Result<BuildOptions> BuildFlags::options() const {
  BuildOptions options;
  const auto memory = parse_bytes(memory_);
  if (!memory || *memory == 0) {
    return usage(fmt::format("--memory: expected a size such as 512M or 2G, found '{}'", memory_));
  }
  options.memory_bytes = std::min(*memory, machine_memory());
  if (options.memory_bytes < *memory) {
    note(fmt::format("--memory {} exceeds the memory of this machine: the limit is {}", memory_,
                     format_bytes(options.memory_bytes)));
  }
  options.threads = threads_;
  options.fetch_weight = fetch_weight_;
  options.max_error = max_error_;
  if (range_.size() == 2) {
    if (!(range_[0] < range_[1])) {
      return usage(fmt::format("--range: expected two numbers, the lower one first, found {},{}",
                               range_[0], range_[1]));
    }
    options.range = ValueRange{range_[0], range_[1]};
  }
  options.title = title_;
  options.value_units = units_;
  options.temporary_folder = temporary_folder_;
  return options;
}

std::string BuildFlags::key() const {
  // The other options do not change the store.
  return fmt::format("{}\n{}\n{}\n{}\n{}", fetch_weight_, title_, units_, max_error_,
                     fmt::join(range_, " "));
}

std::string examples(const std::string& lines) {
  return "Examples:\n" + lines;
}

}  // namespace isosplat::cli
