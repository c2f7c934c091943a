#include "shared/import/vtk_amr/hierarchy.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "shared/core/adaptive/adaptive_grid.h"
#include "shared/import/bytes/byte_reader.h"
#include "shared/import/text/header_text.h"
#include "shared/import/vtk_xml/document.h"
#include "shared/import/vtk_xml/tags.h"

namespace isosplat::import {
namespace {

/// More are refused before their files are opened.
constexpr size_t kMaxPatches = size_t{1} << 20;

constexpr int64_t kMaxIndex = int64_t{1} << 30;

class Parser {
 public:
  Parser(const std::filesystem::path& path, ByteReader& bytes) : path_(path), tags_(bytes) {}

  Result<VtkHierarchy> parse() {
    for (;;) {
      const auto tag = tags_.next();
      if (!tag) return tl::unexpected(tag.error());
      if (!*tag) return incomplete_vtk_xml(path_);
      if ((*tag)->name == "VTKFile" && (*tag)->ends) break;
      if (!(*tag)->begins) continue;
      auto taken = take(**tag);
      if (!taken) return tl::unexpected(taken.error());
    }
    if (made_.levels.empty()) return malformed("expected a <Block> for each level, found none");
    return std::move(made_);
  }

 private:
  tl::unexpected<Error> malformed(const std::string& what) {
    return malformed_vtk_xml(path_, what);
  }

  Result<void> take(const XmlTag& tag) {
    if (tag.name == "VTKFile") return take_version(tag);
    if (tag.name.starts_with("vtk")) return take_grid(tag);
    if (tag.name == "Block") return take_level(tag);
    if (tag.name == "DataSet") return take_patch(tag);
    return {};
  }

  Result<void> take_version(const XmlTag& tag) {
    const auto version = number_in(tag.attribute("version").value_or(""));
    if (version && *version >= 1.1) return {};
    return fail(Status::unsupported_format,
                fmt::format("{}: expected version 1.1 of a hierarchy of grids, found '{}', which "
                            "states no positions: open it in ParaView and save it again",
                            path_.string(), tag.attribute("version").value_or("")));
  }

  Result<void> take_grid(const XmlTag& tag) {
    const auto origin = numbers_in(tag.attribute("origin").value_or(""));
    if (!origin || origin->size() != 3) return malformed("expected an origin of three numbers");
    made_.origin = {(*origin)[0], (*origin)[1], (*origin)[2]};
    const std::string axes = tag.attribute("grid_description").value_or("XYZ");
    if (axes == "XYZ") return {};
    return fail(Status::unsupported_format,
                fmt::format("{}: expected a grid of three dimensions (XYZ), found '{}'",
                            path_.string(), axes));
  }

  Result<void> take_level(const XmlTag& tag) {
    const auto level = whole_number(tag.attribute("level").value_or(""));
    if (!level || *level != static_cast<int64_t>(made_.levels.size()) ||
        made_.levels.size() == kMaxRefinementLevels) {
      return malformed(
          fmt::format("expected a <Block> for each level from 0, at most {}, found '{}'",
                      kMaxRefinementLevels, tag.attribute("level").value_or("")));
    }
    const auto spacing = numbers_in(tag.attribute("spacing").value_or(""));
    const bool is_spacing = spacing && spacing->size() == 3 &&
                            std::all_of(spacing->begin(), spacing->end(), [](double each) {
                              return std::isfinite(each) && each > 0;
                            });
    if (!is_spacing) {
      return malformed(
          fmt::format("expected a spacing of level {} of three positive numbers, found "
                      "'{}'",
                      *level, tag.attribute("spacing").value_or("")));
    }
    made_.levels.push_back({{(*spacing)[0], (*spacing)[1], (*spacing)[2]}, {}});
    return {};
  }

  Result<void> take_patch(const XmlTag& tag) {
    if (made_.levels.empty()) return malformed("expected a <DataSet> in a <Block>");
    if (++patches_ > kMaxPatches) {
      return malformed(fmt::format("expected at most {} patches, found more", kMaxPatches));
    }
    const std::string text = tag.attribute("amr_box").value_or("");
    const auto box = whole_numbers(text);
    VtkAmrPatch patch;
    bool is_box = box && box->size() == 6;
    for (size_t axis = 0; axis < 3 && is_box; ++axis) {
      patch.low[axis] = (*box)[2 * axis];
      patch.high[axis] = (*box)[2 * axis + 1];
      is_box = patch.low[axis] >= -kMaxIndex && patch.high[axis] <= kMaxIndex &&
               patch.low[axis] <= patch.high[axis];
    }
    if (!is_box) {
      return malformed(
          fmt::format("expected an amr_box of the first and last cell along x, y and z "
                      "in each <DataSet>, found '{}'",
                      text));
    }
    const std::string file = tag.attribute("file").value_or("");
    if (file.empty()) return {};  // VTK writes patches without data so, in parallel
    patch.file = path_.parent_path() / file;
    made_.levels.back().patches.push_back(std::move(patch));
    return {};
  }

  const std::filesystem::path& path_;
  XmlTags tags_;
  VtkHierarchy made_;
  size_t patches_ = 0;
};

}  // namespace

Result<VtkHierarchy> read_vtk_hierarchy(const std::filesystem::path& path) {
  auto bytes = open_plain(path);
  if (!bytes) return tl::unexpected(bytes.error());
  return Parser(path, **bytes).parse();
}

}  // namespace isosplat::import
