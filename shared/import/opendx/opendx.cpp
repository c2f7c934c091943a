#include "shared/import/opendx/opendx.h"

#include <fmt/format.h>

#include <algorithm>

#include "shared/import/text/header_text.h"
#include "shared/import/text/line_scanner.h"
#include "shared/import/voxels/text_grid.h"

// Reads regular grids of OpenDX's native format, as APBS, PyMOL, VMD and Chimera write them:
//
// object 1 class gridpositions counts NX NY NZ
// origin X Y Z
// delta  X Y Z   three times: the step along each axis
// object 2 class gridconnections counts NX NY NZ
// object 3 class array type double rank 0 items N data follows
// values, z fastest
// attribute, component and object lines
namespace isosplat::import {
namespace {

class Reader {
 public:
  Reader(const std::filesystem::path& path, std::unique_ptr<ByteReader> file)
      : path_(path), scanner_(path, std::move(file), "OpenDX") {}

  Result<OpenVolume> open(const ImportOptions& options) {
    TextGrid grid;
    grid.format = "OpenDX";
    grid.unit = kAngstrom;
    grid.ends_with_file = false;
    std::array<int64_t, 3> sizes{};
    size_t deltas = 0;
    bool has_origin = false;
    for (;;) {
      const auto parts = scanner_.next_words();
      if (!parts) return tl::unexpected(parts.error());
      if (parts->empty()) return scanner_.malformed("expected an array, found the end");
      const std::string key = lower_case(parts->front());
      const auto has = [&](const char* word) {
        return std::find(parts->begin(), parts->end(), word) != parts->end();
      };
      if (key == "origin" || key == "delta") {
        const auto vector = vector_of(*parts);
        if (!vector || deltas == 3)
          return scanner_.malformed("expected one origin and three deltas");
        (key == "origin" ? grid.origin : grid.steps[2 - deltas]) = *vector;
        has_origin = has_origin || key == "origin";
        deltas += key == "delta";
      } else if (key == "object" && has("gridpositions")) {
        const auto counts = std::find(parts->begin(), parts->end(), "counts");
        if (parts->end() - counts != 4 || sizes[0] != 0) {
          return scanner_.malformed("expected the counts of one grid of three axes");
        }
        for (size_t axis = 0; axis < 3; ++axis) {
          const auto count = whole_number(counts[static_cast<std::ptrdiff_t>(1 + axis)]);
          if (!count || *count < 1) return scanner_.malformed("expected counts above 0");
          sizes[axis] = *count;
        }
      } else if (key == "object" && has("array")) {
        if (deltas != 3 || sizes[0] == 0 || !has_origin) {
          return scanner_.malformed("expected gridpositions, origin and three deltas");
        }
        if (auto right = check_array(*parts, sizes); !right) return tl::unexpected(right.error());
        break;
      }
    }
    grid.voxels = {sizes[2], sizes[1], sizes[0]};
    grid.begin = scanner_.position();
    if (auto right = check_end(sizes); !right) return tl::unexpected(right.error());
    return open_text_grid(path_, grid, options,
                          {"an OpenDX file does not state its unit of length: ångström is assumed, "
                           "as APBS writes it; --spacing sets another in mm"});
  }

 private:
  static std::optional<Vec3d> vector_of(const std::vector<std::string>& parts) {
    if (parts.size() != 4) return std::nullopt;
    const auto x = number_in(parts[1]), y = number_in(parts[2]), z = number_in(parts[3]);
    if (!x || !y || !z) return std::nullopt;
    return Vec3d{*x, *y, *z};
  }

  Result<void> check_array(const std::vector<std::string>& parts,
                           const std::array<int64_t, 3>& sizes) const {
    const auto after = [&](const char* word) {
      const auto at = std::find(parts.begin(), parts.end(), word);
      return at == parts.end() || at + 1 == parts.end() ? std::string() : *(at + 1);
    };
    const std::string rank = after("rank");
    const bool is_text = parts[parts.size() - 1] == "follows" && after("binary").empty() &&
                         after("lsb").empty() && after("msb").empty() && after("ieee").empty();
    if ((rank != "0" && !(rank == "1" && after("shape") == "1")) || !is_text) {
      return fail(Status::unsupported_format,
                  fmt::format("{}: expected an array of rank 0 whose values follow as text, found "
                              "another: save the grid as text with one value for each point",
                              path_.string()));
    }
    int64_t count = 1;
    for (const int64_t size : sizes) {
      if (__builtin_mul_overflow(count, size, &count)) {
        return scanner_.malformed("expected fewer points");
      }
    }
    if (whole_number(after("items")) == count) return {};
    return scanner_.malformed(fmt::format("expected {} items for {} × {} × {} points, found '{}'",
                                          count, sizes[0], sizes[1], sizes[2], after("items")));
  }

  /// After the values, the file must end, or a line begin with a word.
  Result<void> check_end(const std::array<int64_t, 3>& sizes) {
    const auto is_whole =
        scanner_.skip_numbers(static_cast<uint64_t>(sizes[0]) * static_cast<uint64_t>(sizes[1]) *
                              static_cast<uint64_t>(sizes[2]));
    if (!is_whole) return tl::unexpected(is_whole.error());
    if (!*is_whole) {
      return fail(Status::truncated,
                  fmt::format("{}: expected more values, and white space after the last one, found "
                              "the end: the file is incomplete; copy or download it again",
                              path_.string()));
    }
    const auto next = scanner_.next_words();
    if (!next) return tl::unexpected(next.error());
    if (!next->empty() && number_in(next->front())) {
      return scanner_.malformed("expected the end of the values, found another");
    }
    return {};
  }

  const std::filesystem::path& path_;
  LineScanner scanner_;
};

}  // namespace

bool is_opendx(std::string_view head) {
  while (const auto line = pop_line(head)) {
    const auto parts = words(*line);
    if (parts.empty() || parts.front().starts_with('#')) continue;
    return parts.size() > 3 && parts[0] == "object" && parts[2] == "class" &&
           parts[3] == "gridpositions";
  }
  return false;
}

Result<OpenVolume> open_opendx(const std::filesystem::path& path, const ImportOptions& options) {
  auto file = open_plain(path);
  if (!file) return tl::unexpected(file.error());
  return Reader(path, std::move(*file)).open(options);
}

}  // namespace isosplat::import
