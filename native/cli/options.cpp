#include "native/cli/options.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>

namespace isosplat::cli {
namespace {

tl::unexpected<Error> usage(const std::string& message) {
  return fail(Status::invalid_argument, message);
}

std::optional<double> parse_number(std::string_view text) {
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(number)) {
    return std::nullopt;
  }
  return number;
}

}  // namespace

void VolumeFlags::add_to(CLI::App& command) {
  command.add_option("--spacing", spacing_, "Distance between voxels, instead of the file's")
      ->type_name("X,Y,Z");
  command.add_option("--time-step", time_step_, "Which volume of a 4D file, from 0")
      ->check(CLI::NonNegativeNumber);
  command
      .add_option("--series", series_,
                  "DICOM: which series, by its number in isosplat's messages or its UID (default: "
                  "the one with the most voxels)")
      ->type_name("NUMBER|UID");
  command.add_option("--dims", dims_, "Raw files: voxels along each axis")->type_name("XxYxZ");
  command.add_option("--type", type_, "Raw files: u8, i8, u16, i16, u32, i32, f32 or f64");
  command.add_option("--endian", endian_, "Raw files: byte order")
      ->check(CLI::IsMember({"little", "big"}));
  command.add_option("--skip-bytes", skip_bytes_, "Raw files: bytes before the first voxel");
  command
      .add_option("--missing-value", missing_value_,
                  "Voxels of this value have none; 'none': every voxel has one (default: what the "
                  "file says, or a single value far outside the range of all others)")
      ->type_name("VALUE");
  for (const AllowanceFlag& allowance : kAllowances) {
    command.add_flag_callback(
        allowance.flag, [this, &allowance] { allowed_.add(allowance.allowance); }, allowance.help);
  }
}

Result<ImportOptions> VolumeFlags::options() const {
  ImportOptions options;
  if (!dims_.empty()) {
    const auto dims = parse_triple(dims_);
    const auto fits = [](double d) { return d >= 1 && d <= 1e9 && d == std::floor(d); };
    if (!dims || !fits(dims->x) || !fits(dims->y) || !fits(dims->z)) {
      return usage(
          fmt::format("--dims {}: expected three whole numbers such as 256x256x128", dims_));
    }
    options.dims = {static_cast<int64_t>(dims->x), static_cast<int64_t>(dims->y),
                    static_cast<int64_t>(dims->z)};
  }
  if (!type_.empty()) {
    options.type = voxel_type_of(type_);
    if (!options.type) {
      return usage(
          fmt::format("--type {}: expected one of u8, i8, u16, i16, u32, i32, f32 and f64", type_));
    }
  }
  if (!spacing_.empty()) {
    options.spacing = parse_triple(spacing_);
    const auto positive = [](double d) { return d > 0 && d < 1e12; };
    if (!options.spacing || !positive(options.spacing->x) || !positive(options.spacing->y) ||
        !positive(options.spacing->z)) {
      return usage(
          fmt::format("--spacing {}: expected three positive numbers such as 1,1,2.5", spacing_));
    }
  }
  options.big_endian = endian_ == "big";
  options.skip_bytes = skip_bytes_;
  if (time_step_ >= 0) options.time_step = time_step_;
  options.series = series_;
  options.allowed = allowed_;
  if (missing_value_ == "none") {
    options.finds_missing_values = false;
  } else if (!missing_value_.empty()) {
    options.missing_value = parse_number(missing_value_);
    if (!options.missing_value) {
      return usage(fmt::format("--missing-value {}: expected a number such as -9999, or none",
                               missing_value_));
    }
  }
  return options;
}

std::string VolumeFlags::key() const {
  std::string text = fmt::format("{}\n{}\n{}\n{}\n{}\n{}\n{}\n{}", dims_, type_, spacing_, endian_,
                                 skip_bytes_, time_step_, missing_value_, series_);
  for (const AllowanceFlag& allowance : kAllowances) {
    if (allowed_.has(allowance.allowance)) text += fmt::format("\n{}", allowance.flag);
  }
  return text;
}

void BuildFlags::add_to(CLI::App& command) {
  command.add_option("--memory", memory_, "Most memory to use")
      ->type_name("SIZE")
      ->capture_default_str();
  command.add_option("--threads", threads_, "Threads (0: one per core)")->capture_default_str();
  command
      .add_option("--lambda", lambda_,
                  "Bytes stored against bytes fetched: smaller values make larger stores that "
                  "send fewer bytes for an isovalue")
      ->check(CLI::Range(1e-4, 10.0))
      ->capture_default_str();
  command.add_option("--name", title_, "The volume's name for people (default: the file's)");
  command.add_option("--units", units_, "Unit of the values, such as HU");
  command.add_option("--temporary-folder", temporary_folder_,
                     "Where coarse levels wait that do not fit in memory (default: beside the "
                     "store)");
}

Result<BuildOptions> BuildFlags::options() const {
  BuildOptions options;
  const auto memory = parse_bytes(memory_);
  if (!memory || *memory == 0) {
    return usage(fmt::format("--memory {}: expected a size such as 512M or 2G", memory_));
  }
  options.memory_bytes = *memory;
  options.threads = threads_;
  options.lambda = lambda_;
  options.title = title_;
  options.value_units = units_;
  options.temporary_folder = temporary_folder_;
  return options;
}

std::string BuildFlags::key() const {
  return fmt::format("{}\n{}\n{}", lambda_, title_, units_);  // the others do not change the store
}

std::optional<uint64_t> parse_bytes(const std::string& text) {
  size_t end = 0;
  while (end < text.size() && (text[end] == '.' || (text[end] >= '0' && text[end] <= '9'))) ++end;
  const auto number = parse_number(std::string_view(text).substr(0, end));
  if (!number) return std::nullopt;
  std::string unit = text.substr(end);
  for (char& c : unit) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  double factor = 1;
  if (unit == "K" || unit == "KB" || unit == "KIB") {
    factor = 1024;
  } else if (unit == "M" || unit == "MB" || unit == "MIB") {
    factor = 1024.0 * 1024;
  } else if (unit == "G" || unit == "GB" || unit == "GIB") {
    factor = 1024.0 * 1024 * 1024;
  } else if (unit == "T" || unit == "TB" || unit == "TIB") {
    factor = 1024.0 * 1024 * 1024 * 1024;
  } else if (!unit.empty() && unit != "B") {
    return std::nullopt;
  }
  const double bytes = *number * factor;
  if (bytes > 9e18) return std::nullopt;
  return static_cast<uint64_t>(bytes);
}

std::optional<Vec3d> parse_triple(const std::string& text) {
  std::array<double, 3> numbers{};
  std::string_view rest = text;
  for (size_t i = 0; i < 3; ++i) {
    const size_t end = i < 2 ? rest.find_first_of("xX,:") : rest.size();
    if (end == rest.npos) return std::nullopt;
    const auto number = parse_number(rest.substr(0, end));
    if (!number) return std::nullopt;
    numbers[i] = *number;
    rest.remove_prefix(i < 2 ? end + 1 : end);
  }
  return Vec3d{numbers[0], numbers[1], numbers[2]};
}

std::string examples(const std::string& lines) {
  return "Examples:\n" + lines;
}

}  // namespace isosplat::cli
