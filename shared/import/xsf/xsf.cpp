#include "shared/import/xsf/xsf.h"

#include <fmt/format.h>

#include <algorithm>

#include "shared/import/text/header_text.h"
#include "shared/import/text/line_scanner.h"
#include "shared/import/volume/choose_channel.h"
#include "shared/import/volume/volume_choices.h"
#include "shared/import/voxels/text_grid.h"

// Reads datagrids of XCrySDen's XSF format. The words after the name of a datagrid may be in any
// lines:
//
// BEGIN_BLOCK_DATAGRID_3D
//   name of the block
//   BEGIN_DATAGRID_3D_name
//     points along x, y and z
//     origin
//     three vectors, from the first point to the last one along each axis
//     values, x fastest
//   END_DATAGRID_3D
// END_BLOCK_DATAGRID_3D
//
// Datagrids are general: the last plane along an axis of a periodic cell repeats the first one.
namespace isosplat::import {
namespace {

constexpr size_t kMostGrids = 10'000;

/// A name in capitals, without the underscores that some programs leave out.
std::string plain(std::string_view word) {
  std::string text = lower_case(word);
  std::erase(text, '_');
  return text;
}

struct Datagrid {
  std::string name;
  TextGrid grid;
};

class Reader {
 public:
  Reader(const std::filesystem::path& path, std::unique_ptr<ByteReader> file)
      : scanner_(path, std::move(file), "XSF") {}

  /// All datagrids of the file.
  Result<std::vector<Datagrid>> read() {
    std::vector<Datagrid> grids;
    bool is_inside = false;
    for (;;) {
      const auto parts = scanner_.next_words();
      if (!parts) return tl::unexpected(parts.error());
      if (parts->empty()) break;
      const std::string word = plain(parts->front());
      if (word == "beginblockdatagrid3d") is_inside = true;
      if (word.starts_with("endblockdatagrid")) is_inside = false;
      const bool begins = word.starts_with("begindatagrid3d") || word.starts_with("datagrid3d");
      if (!is_inside || !begins) continue;
      if (grids.size() == kMostGrids) return scanner_.malformed("expected fewer datagrids");
      auto grid = datagrid(parts->front());
      if (!grid) return tl::unexpected(grid.error());
      grids.push_back(std::move(*grid));
    }
    return grids;
  }

  tl::unexpected<Error> malformed(const std::string& what) const {
    return scanner_.malformed(what);
  }

 private:
  Result<Datagrid> datagrid(const std::string& keyword) {
    std::vector<double> numbers;  // sizes, origin, vectors
    while (numbers.size() < 15) {
      const auto parts = scanner_.next_words();
      if (!parts) return tl::unexpected(parts.error());
      if (parts->empty()) return scanner_.malformed("expected a datagrid, found the end");
      for (const std::string& part : *parts) {
        const auto number = number_in(part);
        if (!number || numbers.size() == 15) {
          return scanner_.malformed("expected points, origin and vectors of a datagrid, in lines");
        }
        numbers.push_back(*number);
      }
    }
    Datagrid found;
    const size_t name = keyword.find("3D_");
    if (name != keyword.npos) found.name = keyword.substr(name + 3);
    TextGrid& grid = found.grid;
    grid.format = "XSF";
    grid.unit = kAngstrom;
    grid.ends_with_file = false;
    std::array<int64_t, 3> sizes{};
    uint64_t count = 1;
    for (size_t axis = 0; axis < 3; ++axis) {
      const double size = numbers[axis];
      if (!(size >= 2 && size <= 1e9) || size != static_cast<double>(static_cast<int64_t>(size))) {
        return scanner_.malformed("expected at least 2 points along each axis");
      }
      sizes[axis] = static_cast<int64_t>(size);
      if (__builtin_mul_overflow(count, static_cast<uint64_t>(size), &count)) {
        return scanner_.malformed("expected fewer points");
      }
      const double* const vector = &numbers[6 + 3 * axis];
      grid.steps[axis] = Vec3d{vector[0], vector[1], vector[2]} * (1 / (size - 1));
    }
    grid.voxels = {sizes[0], sizes[1], sizes[2]};
    grid.origin = {numbers[3], numbers[4], numbers[5]};
    grid.begin = scanner_.position();
    const auto is_whole = scanner_.skip_numbers(count);
    if (!is_whole) return tl::unexpected(is_whole.error());
    const auto end = scanner_.next_words();
    if (!end) return tl::unexpected(end.error());
    if (!*is_whole || end->empty() || !plain(end->front()).starts_with("enddatagrid")) {
      return scanner_.malformed(
          fmt::format("expected {} values and END_DATAGRID_3D, found others", count));
    }
    return found;
  }

  LineScanner scanner_;
};

}  // namespace

bool is_xsf(std::string_view head) {
  // The first line that is neither empty nor a comment.
  while (const auto line = pop_line(head)) {
    const std::string_view text = trimmed(*line);
    if (text.empty() || text.starts_with('#')) continue;
    for (const std::string_view keyword :
         {"CRYSTAL", "SLAB", "POLYMER", "MOLECULE", "DIM-GROUP", "PRIMVEC", "CONVVEC", "PRIMCOORD",
          "ATOMS", "ANIMSTEPS", "BEGIN_BLOCK_DATAGRID", "BEGIN_INFO"}) {
      if (text.starts_with(keyword)) return true;
    }
    return false;
  }
  return false;
}

Result<OpenVolume> open_xsf(const std::filesystem::path& path, const ImportOptions& options) {
  auto file = open_plain(path);
  if (!file) return tl::unexpected(file.error());
  Reader reader(path, std::move(*file));
  const auto grids = reader.read();
  if (!grids) return tl::unexpected(grids.error());
  if (grids->empty()) {
    return reader.malformed("expected BEGIN_BLOCK_DATAGRID_3D with a datagrid, found none");
  }
  std::vector<ChannelDescription> names;
  for (const Datagrid& grid : *grids) names.push_back({grid.name, {}});
  const auto channel = choose_channel(path, grids->size(), options, names, " (datagrids)");
  if (!channel) return tl::unexpected(channel.error());
  return open_text_grid(path, (*grids)[static_cast<size_t>(*channel)].grid, options, {});
}

}  // namespace isosplat::import
