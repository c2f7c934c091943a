#include "shared/import/vasp/vasp.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "shared/import/text/header_text.h"
#include "shared/import/text/line_scanner.h"
#include "shared/import/volume/choose_channel.h"
#include "shared/import/volume/volume_choices.h"
#include "shared/import/voxels/text_grid.h"

// Reads volumes of VASP:
//
// a line       of text
// a line       a factor of all lengths; negative: the volume of the cell; or three factors
// three lines  the axes of the cell, in ångström
// a line       names of elements (since version 5)
// a line       number of atoms of each element
// a line       perhaps "Selective dynamics"
// a line       "Direct" or "Cartesian", then the atoms
// a line       voxels along x, y and z; then the values, x fastest
//
// After the values, other numbers may follow (augmentation occupancies), and with spin another
// line of voxels and other values: up to three components of the magnetization.
namespace isosplat::import {
namespace {

constexpr int64_t kMostAtoms = 10'000'000;

std::optional<std::vector<int64_t>> counts_in(std::string_view line) {
  auto counts = whole_numbers(line);
  if (!counts || counts->empty()) return std::nullopt;
  const bool are_positive =
      std::all_of(counts->begin(), counts->end(), [](int64_t n) { return n > 0; });
  return are_positive ? counts : std::nullopt;
}

/// Whether a line may say how the positions of atoms are given.
bool is_mode(std::string_view line) {
  line = trimmed(line);
  return !line.empty() && std::string_view("dDcCkKsS").find(line.front()) != line.npos;
}

class Reader {
 public:
  Reader(const std::filesystem::path& path, std::unique_ptr<ByteReader> file)
      : path_(path), scanner_(path, std::move(file), "VASP") {}

  Result<OpenVolume> open(const ImportOptions& options) {
    TextGrid grid;
    grid.format = "VASP";
    grid.unit = kAngstrom;
    grid.ends_with_file = false;
    if (auto read = read_cell(); !read) return tl::unexpected(read.error());
    if (auto read = skip_atoms(); !read) return tl::unexpected(read.error());
    const auto sizes = next_sizes();
    if (!sizes) return tl::unexpected(sizes.error());
    if (sizes->empty()) {
      return fail(Status::unsupported_format,
                  fmt::format("{}: expected a grid of values after the atoms, found none: this is "
                              "a structure (POSCAR, CONTCAR); give CHGCAR, PARCHG, LOCPOT or "
                              "ELFCAR",
                              path_.string()));
    }
    grid.voxels = {(*sizes)[0], (*sizes)[1], (*sizes)[2]};
    for (size_t axis = 0; axis < 3; ++axis) {
      grid.steps[axis] = cell_[axis] * (1 / static_cast<double>((*sizes)[axis]));
    }
    const auto begins = find_blocks(*sizes);
    if (!begins) return tl::unexpected(begins.error());
    std::vector<std::string> notes;
    const uint64_t channel = static_cast<uint64_t>(options.channel.value_or(0));
    std::vector<ChannelDescription> names{{"total", {}}};
    for (size_t i = 1; i < begins->size(); ++i) {
      names.push_back(
          {begins->size() == 2 ? "spin density" : fmt::format("magnetization {}", "xyz"[i - 1]),
           {}});
    }
    ImportOptions chosen = options;
    if (!chosen.channel && begins->size() > 1) {
      offer_channels(options, begins->size(), names);
      notes.push_back(
          fmt::format("the file has {} volumes: the total is read; --channel 1 to "
                      "--channel {} reads the magnetization",
                      begins->size(), begins->size() - 1));
      chosen.channel = 0;
    }
    if (const auto is = choose_channel(path_, begins->size(), chosen, names); !is) {
      return tl::unexpected(is.error());
    }
    grid.begin = (*begins)[static_cast<size_t>(channel)];
    const std::string name = lower_case(path_.filename().string());
    const bool is_density = name.find("locpot") == name.npos && name.find("elfcar") == name.npos;
    if (is_density) {
      grid.slope = 1 / volume();
      notes.push_back(fmt::format(
          "the values are divided by the volume of the cell, {:.6g} Å³, which VASP multiplies "
          "densities by (CHGCAR, PARCHG): they are per Å³; those of files named LOCPOT and ELFCAR "
          "are unchanged",
          volume()));
    }
    return open_text_grid(path_, grid, options, std::move(notes));
  }

 private:
  double volume() const { return std::abs(dot(cell_[0], cross(cell_[1], cell_[2]))); }

  Result<std::string> line() {
    auto text = scanner_.line();
    if (!text) return tl::unexpected(text.error());
    if (!*text) return scanner_.malformed("expected the cell and the atoms, found the end");
    return std::move(**text);
  }

  Result<void> read_cell() {
    if (auto title = line(); !title) return tl::unexpected(title.error());
    const auto factor = line();
    if (!factor) return tl::unexpected(factor.error());
    const auto factors = numbers_in(*factor);
    if (!factors || (factors->size() != 1 && factors->size() != 3)) {
      return scanner_.malformed("expected a factor of lengths");
    }
    for (Vec3d& axis : cell_) {
      const auto text = line();
      if (!text) return tl::unexpected(text.error());
      const auto numbers = numbers_in(*text);
      if (!numbers || numbers->size() != 3)
        return scanner_.malformed("expected an axis of the cell");
      axis = {(*numbers)[0], (*numbers)[1], (*numbers)[2]};
    }
    Vec3d by{factors->front(), factors->front(), factors->front()};
    if (factors->size() == 3) by = {(*factors)[0], (*factors)[1], (*factors)[2]};
    if (factors->size() == 1 && factors->front() < 0) {
      const double scale = std::cbrt(-factors->front() / volume());
      by = {scale, scale, scale};
    }
    for (Vec3d& axis : cell_) axis = {axis.x * by.x, axis.y * by.y, axis.z * by.z};
    if (!(volume() > 0) || !std::isfinite(volume())) {
      return scanner_.malformed("expected a cell with a volume");
    }
    return {};
  }

  Result<void> skip_atoms() {
    auto text = line();
    if (!text) return tl::unexpected(text.error());
    if (!counts_in(*text)) text = line();
    if (!text) return tl::unexpected(text.error());
    const auto counts = counts_in(*text);
    int64_t atoms = 0;
    for (const int64_t count : counts.value_or(std::vector<int64_t>{})) {
      atoms += std::min(count, kMostAtoms);
    }
    auto mode = line();
    if (mode && lower_case(trimmed(*mode)).starts_with('s')) mode = line();
    if (!mode) return tl::unexpected(mode.error());
    if (!counts || atoms > kMostAtoms || !is_mode(*mode)) {
      return scanner_.malformed("expected numbers of atoms, and Direct or Cartesian");
    }
    for (int64_t i = 0; i < atoms; ++i) {
      if (auto atom = line(); !atom) return tl::unexpected(atom.error());
    }
    return {};
  }

  /// The next three whole numbers alone in a line. Empty at the end of the file.
  Result<std::vector<int64_t>> next_sizes() {
    for (;;) {
      const auto text = scanner_.line();
      if (!text) return tl::unexpected(text.error());
      if (!*text) return std::vector<int64_t>{};
      const auto counts = counts_in(**text);
      if (counts && counts->size() == 3) return *counts;
    }
  }

  /// The offsets of the values of all volumes with these sizes. A file that ends within the values
  /// of one has no other.
  Result<std::vector<uint64_t>> find_blocks(const std::vector<int64_t>& sizes) {
    std::vector<uint64_t> begins;
    uint64_t count = 1;
    for (const int64_t size : sizes) {
      if (__builtin_mul_overflow(count, static_cast<uint64_t>(size), &count)) {
        return scanner_.malformed("expected fewer voxels");
      }
    }
    for (std::vector<int64_t> found = sizes; found == sizes && begins.size() < 4;) {
      begins.push_back(scanner_.position());
      const auto is_whole = scanner_.skip_numbers(count);
      if (!is_whole) return tl::unexpected(is_whole.error());
      if (!*is_whole) break;
      do {
        auto next = next_sizes();
        if (!next) return tl::unexpected(next.error());
        found = std::move(*next);
      } while (!found.empty() && found != sizes);
    }
    return begins;
  }

  const std::filesystem::path& path_;
  LineScanner scanner_;
  std::array<Vec3d, 3> cell_{};
};

}  // namespace

bool is_vasp(std::string_view head) {
  std::vector<std::string_view> lines;
  while (lines.size() < 8) {
    const auto line = pop_line(head);
    if (!line) return false;
    lines.push_back(*line);
  }
  const auto has = [&](size_t line, size_t count) {
    const auto numbers = numbers_in(lines[line]);
    return numbers && numbers->size() == count;
  };
  if ((!has(1, 1) && !has(1, 3)) || !has(2, 3) || !has(3, 3) || !has(4, 3)) return false;
  const size_t counts = counts_in(lines[5]) ? 5 : 6;
  return counts_in(lines[counts]) && is_mode(lines[counts + 1]);
}

Result<OpenVolume> open_vasp(const std::filesystem::path& path, const ImportOptions& options) {
  auto file = open_plain(path);
  if (!file) return tl::unexpected(file.error());
  return Reader(path, std::move(*file)).open(options);
}

}  // namespace isosplat::import
