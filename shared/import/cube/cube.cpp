#include "shared/import/cube/cube.h"

#include <fmt/format.h>

#include <cmath>

#include "shared/import/text/header_text.h"
#include "shared/import/text/line_scanner.h"
#include "shared/import/volume/choose_channel.h"
#include "shared/import/volume/volume_choices.h"
#include "shared/import/voxels/text_grid.h"

// Reads cube files, which Gaussian defines:
//
// two lines   of text
// a line      atoms, origin (x y z), and perhaps the number of values of each voxel
// three lines voxels along an axis, and the step along it; negative: lengths are in ångström, else
//             in bohr
// lines       of the atoms: number, charge, position
// a line      only if the number of atoms is negative: the number of orbitals, and their numbers
// values      the last axis fastest; the values of a voxel together
namespace isosplat::import {
namespace {

constexpr int64_t kMostAtoms = 10'000'000;
constexpr uint64_t kMostOrbitals = 100'000;

/// A line of a whole number and numbers; nothing if it is another.
struct Row {
  int64_t count = 0;
  std::vector<double> numbers;
};

std::optional<Row> row_of(const std::vector<std::string_view>& parts) {
  if (parts.size() < 4 || parts.size() > 5) return std::nullopt;
  Row row;
  const auto count = whole_number(parts[0]);
  if (!count) return std::nullopt;
  row.count = *count;
  for (size_t i = 1; i < parts.size(); ++i) {
    const auto number = number_in(parts[i]);
    if (!number || !std::isfinite(*number)) return std::nullopt;
    row.numbers.push_back(*number);
  }
  return row;
}

class Reader {
 public:
  Reader(const std::filesystem::path& path, std::unique_ptr<ByteReader> file)
      : path_(path), scanner_(path, std::move(file), "cube") {}

  Result<OpenVolume> open(const ImportOptions& options) {
    for (int i = 0; i < 2; ++i) {
      if (auto text = scanner_.line(); !text) return tl::unexpected(text.error());
    }
    const auto first = row();
    if (!first) return tl::unexpected(first.error());
    TextGrid grid;
    grid.format = "cube";
    const auto vector = [](const Row& of) {
      return Vec3d{of.numbers[0], of.numbers[1], of.numbers[2]};
    };
    grid.origin = vector(*first);
    std::array<int64_t, 3> sizes{};
    for (size_t axis = 0; axis < 3; ++axis) {
      const auto line = row();
      if (!line) return tl::unexpected(line.error());
      if (line->count == INT64_MIN || (axis > 0 && (line->count < 0) != (sizes[0] < 0))) {
        return scanner_.malformed("expected numbers of voxels with the same sign");
      }
      sizes[axis] = line->count;
      grid.steps[2 - axis] = vector(*line);
    }
    grid.unit = sizes[0] < 0 ? kAngstrom : kBohr;
    for (int64_t& size : sizes) size = std::abs(size);
    grid.voxels = {sizes[2], sizes[1], sizes[0]};
    if (first->count < -kMostAtoms || first->count > kMostAtoms) {
      return scanner_.malformed("expected the number of atoms");
    }
    for (int64_t i = 0; i < std::abs(first->count); ++i) {
      const auto atom = scanner_.line();
      if (!atom) return tl::unexpected(atom.error());
      const auto numbers = *atom ? numbers_in(**atom) : std::nullopt;
      if (!numbers || numbers->size() != 5) {
        return scanner_.malformed("expected the number, charge and position of an atom");
      }
    }
    std::vector<ChannelDescription> names;
    if (first->count < 0) {
      auto read = orbitals();
      if (!read) return tl::unexpected(read.error());
      names = std::move(*read);
      grid.components = names.size();
    } else if (first->numbers.size() == 4) {
      const double values = first->numbers[3];
      if (!(values >= 1 && values <= static_cast<double>(kMostOrbitals) &&
            values == std::floor(values))) {
        return scanner_.malformed("expected the number of values of each voxel");
      }
      grid.components = static_cast<uint64_t>(values);
    }
    const auto channel = choose_channel(path_, grid.components, options, names);
    if (!channel) return tl::unexpected(channel.error());
    grid.component = *channel;
    grid.begin = scanner_.position();
    return open_text_grid(path_, grid, options, {});
  }

 private:
  Result<Row> row() {
    const auto text = scanner_.line();
    if (!text) return tl::unexpected(text.error());
    auto found = row_of(words(text->value_or("")));
    if (!found) return scanner_.malformed("expected a whole number and a vector");
    return std::move(*found);
  }

  /// The names of the orbitals, which may take several lines.
  Result<std::vector<ChannelDescription>> orbitals() {
    std::vector<ChannelDescription> names;
    std::optional<uint64_t> count;
    while (!count || names.size() < *count) {
      const auto parts = scanner_.next_words();
      if (!parts) return tl::unexpected(parts.error());
      for (const std::string& part : *parts) {
        const auto number = whole_number(part);
        const bool fits = number && (count ? names.size() < *count
                                           : *number > 0 && *number <= int64_t{kMostOrbitals});
        if (!fits) return scanner_.malformed("expected the number of orbitals, and their numbers");
        if (count) names.push_back({fmt::format("orbital {}", *number), {}});
        if (!count) count = static_cast<uint64_t>(*number);
      }
      if (parts->empty()) return scanner_.malformed("expected the numbers of the orbitals");
    }
    return names;
  }

  const std::filesystem::path& path_;
  LineScanner scanner_;
};

}  // namespace

bool is_cube(std::string_view head) {
  for (int line = 0; line < 6; ++line) {
    const auto text = pop_line(head);
    if (!text) return false;
    if (line < 2) continue;
    const auto row = row_of(words(*text));
    if (!row || (line > 2 && (row->count == 0 || row->numbers.size() != 3))) return false;
  }
  return true;
}

Result<OpenVolume> open_cube(const std::filesystem::path& path, const ImportOptions& options) {
  auto file = open_plain(path);
  if (!file) return tl::unexpected(file.error());
  return Reader(path, std::move(*file)).open(options);
}

}  // namespace isosplat::import
