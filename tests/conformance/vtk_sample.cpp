#include <fmt/format.h>

#include "tests/conformance/sample.h"

// Written from "VTK File Formats", simple legacy formats.
namespace isosplat::conformance {
namespace {

const char* type_name(Number type) {
  constexpr const char* kNames[] = {"unsigned_char", "char",  "unsigned_short", "short",
                                    "unsigned_int",  "int",   "vtktypeuint64",  "vtktypeint64",
                                    "float",         "double"};
  return kNames[static_cast<size_t>(type)];
}

}  // namespace

Sample make_vtk(Random& random) {
  Sample sample;
  Truth& truth = sample.truth;
  const auto type = static_cast<Number>(random.between(0, 9));
  choose_voxels(random, type, truth);
  const bool text = random.chance(45), of_cells = random.chance(25);
  const auto values_text = [&](const std::vector<double>& values, Number as) {
    return text ? text_of(values, random) : binary_of(values, as, true) + "\n";
  };
  std::array<int, 3> points = truth.sizes;
  if (of_cells) {
    for (int& n : points) ++n;
  }
  const size_t point_count = static_cast<size_t>(points[0] * points[1] * points[2]);
  const size_t cell_count =
      static_cast<size_t>((points[0] - 1) * (points[1] - 1) * (points[2] - 1));
  Vec3d spacing{random.between(1, 20) * 0.25, random.between(1, 20) * 0.25,
                random.between(1, 20) * 0.25};
  const Vec3d origin = choose_place(random);
  truth.steps = {Vec3d{spacing.x, 0, 0}, Vec3d{0, spacing.y, 0}, Vec3d{0, 0, spacing.z}};
  truth.origin = of_cells ? origin + spacing * 0.5 : origin;
  sample.must_be_noted = of_cells;

  std::string file = fmt::format("# vtk DataFile Version {}\nmade by a test\n{}\n",
                                 random.one_of({"2.0", "3.0", "4.2"}), text ? "ASCII" : "BINARY");
  file += "DATASET STRUCTURED_POINTS\n";
  file += fmt::format("DIMENSIONS {} {} {}\n", points[0], points[1], points[2]);
  const std::string spacing_line =
      fmt::format("{} {:.17g} {:.17g} {:.17g}\n", random.one_of({"SPACING", "ASPECT_RATIO"}),
                  spacing.x, spacing.y, spacing.z);
  const std::string origin_line =
      fmt::format("ORIGIN {:.17g} {:.17g} {:.17g}\n", origin.x, origin.y, origin.z);
  file += random.chance(50) ? spacing_line + origin_line : origin_line + spacing_line;
  if (random.chance(20)) {
    file += "FIELD FieldData 1\nTimeValue 1 1 double\n" + values_text({3.5}, Number::f64);
  }
  // Data of the other kind (points or cells), before or after; vectors and fields beside the
  // scalars.
  const auto others = [&](size_t count) {
    std::string out;
    if (random.chance(50)) {
      out += fmt::format("VECTORS v float\n{}",
                         values_text(std::vector<double>(3 * count, 1.5), Number::f32));
    }
    if (random.chance(50)) {
      out += fmt::format("FIELD FieldData 1\nextra 2 {} short\n{}", count,
                         values_text(std::vector<double>(2 * count, 9), Number::i16));
    }
    return out;
  };
  const std::string cells =
      fmt::format("CELL_DATA {}\nSCALARS other float\nLOOKUP_TABLE default\n{}", cell_count,
                  values_text(std::vector<double>(cell_count, 77), Number::f32));
  const bool before = !of_cells && random.chance(40), after = !of_cells && random.chance(30);
  // If the file is cut between two arrays, before the scalars of the points, it is a complete file
  // with values of cells.
  const auto add_part = [&](const std::string& part) {
    if (before && !part.empty()) sample.whole_at.insert(static_cast<int>(file.size()));
    file += part;
    const size_t field = part.find("FIELD ");
    if (before && field != part.npos) {
      sample.whole_at.insert(static_cast<int>(file.size() - part.size() + field));
    }
    if (before) sample.whole_at.insert(static_cast<int>(file.size()));
  };
  sample.try_allowances = !before;
  if (before) {
    add_part(cells);
    add_part(others(cell_count));
  }
  const size_t count = of_cells ? cell_count : point_count;
  file += fmt::format("{} {}\n", of_cells ? "CELL_DATA" : "POINT_DATA", count);
  if (random.chance(30)) add_part(others(count));
  file += fmt::format("SCALARS density {}{}\nLOOKUP_TABLE {}\n", type_name(type),
                      random.one_of({"", " 1"}), random.one_of({"default", "table"}));
  file += values_text(truth.values, type);
  if (after) file += cells;
  sample.main = "v.vtk";
  sample.files["v.vtk"] = file;
  sample.text = fmt::format("{} {}{}{} of {}", text ? "text" : "binary", type_name(type),
                            before ? ", cell data before" : "", after ? ", cell data after" : "",
                            of_cells ? "cells" : "points");
  sample.damages.push_back([](auto& files) {
    std::string& h = files["v.vtk"];
    const size_t at = h.find("DIMENSIONS ") + 11;
    h[at] = h[at] == '2' ? '3' : '2';
  });
  if (text && !after) {
    sample.damages.push_back([](auto& files) {
      std::string& h = files["v.vtk"];
      h.insert(h.find_last_of(" \n", h.size() - 4) + 1, "nonsense");
    });
  }
  return sample;
}

}  // namespace isosplat::conformance
