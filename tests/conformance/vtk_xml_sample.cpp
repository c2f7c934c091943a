#include <fmt/format.h>

#include <algorithm>

#include "tests/conformance/sample.h"

// Written from "VTK File Formats", XML formats, and "VTK XML Formats" of VTK's wiki (headers of
// compressed blocks, base64).
namespace isosplat::conformance {
namespace {

const char* type_name(Number type) {
  constexpr const char* kNames[] = {"UInt8", "Int8",   "UInt16", "Int16",   "UInt32",
                                    "Int32", "UInt64", "Int64",  "Float32", "Float64"};
  return kNames[static_cast<size_t>(type)];
}

std::string base64(const std::string& bytes) {
  constexpr const char* kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t bits = 0;
    for (size_t k = 0; k < 3; ++k) {
      bits = bits << 8 | (i + k < bytes.size() ? static_cast<uint8_t>(bytes[i + k]) : 0);
    }
    for (size_t k = 0; k < 4; ++k) {
      out += i + k > bytes.size() ? '=' : kDigits[bits >> (18 - 6 * k) & 63];
    }
  }
  return out;
}

/// A block of LZ4 without copies.
std::string lz4(const std::string& bytes) {
  std::string out(1, static_cast<char>(std::min<size_t>(bytes.size(), 15) << 4));
  if (bytes.size() >= 15) {
    size_t more = bytes.size() - 15;
    for (; more >= 255; more -= 255) out += '\xff';
    out += static_cast<char>(more);
  }
  return out + bytes;
}

using Box = std::array<int, 6>;  // as Extent

/// How the values of a file are written.
struct Coding {
  std::string format;  ///< ascii, binary, appended
  bool base64 = false, big_endian = false, wide = false;
  std::string compressor;
  int block = 32;
};

std::string numbers_of(const Coding& coding, std::initializer_list<size_t> numbers) {
  std::string out;
  for (const size_t number : numbers) {
    if (coding.wide) put(out, static_cast<uint64_t>(number), coding.big_endian);
    if (!coding.wide) put(out, static_cast<uint32_t>(number), coding.big_endian);
  }
  return out;
}

/// Values with their header.
std::string coded(const Coding& coding, const std::string& bytes) {
  const auto text = [&](const std::string& part) { return coding.base64 ? base64(part) : part; };
  if (coding.compressor.empty()) return text(numbers_of(coding, {bytes.size()}) + bytes);
  const auto block = static_cast<size_t>(coding.block);
  std::string sizes, blocks;
  for (size_t at = 0; at < bytes.size(); at += block) {
    const std::string part = bytes.substr(at, block);
    const std::string packed =
        coding.compressor == "vtkLZ4DataCompressor" ? lz4(part) : gzipped(part, true);
    sizes += numbers_of(coding, {packed.size()});
    blocks += packed;
  }
  return text(
             numbers_of(coding, {(bytes.size() + block - 1) / block, block, bytes.size() % block}) +
             sizes) +
         text(blocks);
}

/// A file with some of the pieces of a grid.
class Writer {
 public:
  Writer(Random& random, Coding coding, std::string grid)
      : random_(random), coding_(std::move(coding)), grid_(std::move(grid)) {}

  void array(const std::string& name, Number type, int components,
             const std::vector<double>& values) {
    body_ += fmt::format("<DataArray type=\"{}\" Name=\"{}\" format=\"{}\"", type_name(type), name,
                         coding_.format);
    if (components > 1) body_ += fmt::format(" NumberOfComponents=\"{}\"", components);
    if (coding_.format == "appended") {
      body_ += fmt::format(" offset=\"{}\" />\n", appended_.size());
      appended_ += coded(coding_, binary_of(values, type, coding_.big_endian));
      return;
    }
    std::string text = coding_.format == "ascii"
                           ? text_of(values, random_)
                           : coded(coding_, binary_of(values, type, coding_.big_endian)) + "\n";
    if (random_.chance(30)) text.pop_back();
    body_ += ">" + std::string(random_.chance(50) ? "\n  " : "") + text;
    if (random_.chance(20)) {
      body_ +=
          "<InformationKey name=\"L2_NORM_RANGE\" location=\"vtkDataArray\" length=\"2\">\n"
          "<Value index=\"0\">\n7\n</Value><Value index=\"1\">8</Value></InformationKey>";
    }
    body_ += "</DataArray>\n";
  }
  void text(const std::string& more) { body_ += more; }

  std::string file(const std::string& attributes) const {
    std::string out = random_.chance(80) ? "<?xml version=\"1.0\"?>\n" : "";
    out += fmt::format("<VTKFile type='{}' version=\"{}\" byte_order=\"{}\"", grid_,
                       coding_.wide ? "1.0" : "0.1",
                       coding_.big_endian ? "BigEndian" : "LittleEndian");
    if (coding_.wide) out += " header_type=\"UInt64\"";
    if (!coding_.compressor.empty()) out += " compressor=\"" + coding_.compressor + "\"";
    out +=
        fmt::format(">\n<!-- <Piece a > -->\n<{} {}>\n{}</{}>\n", grid_, attributes, body_, grid_);
    if (!appended_.empty()) {
      out += fmt::format("<AppendedData encoding=\"{}\">\n _{}\n</AppendedData>\n",
                         coding_.base64 ? "base64" : "raw", appended_);
    }
    return out + "</VTKFile>\n";
  }

 private:
  Random& random_;
  Coding coding_;
  std::string grid_, body_, appended_;
};

std::string text_of(const Box& box) {
  return fmt::format("{}", fmt::join(box, " "));
}

}  // namespace

Sample make_vtk_xml(Random& random) {
  Sample sample;
  Truth& truth = sample.truth;
  const auto type = static_cast<Number>(random.between(0, 9));
  choose_voxels(random, type, truth);
  const bool of_cells = random.chance(25), is_rectilinear = random.chance(25);
  const std::string grid = is_rectilinear ? "RectilinearGrid" : "ImageData";
  Box whole{};
  for (int axis = 0; axis < 3; ++axis) {
    whole[2 * axis] = random.one_of({0, 0, random.between(-9, 9)});
    whole[2 * axis + 1] = whole[2 * axis] + truth.sizes[axis] - (of_cells ? 0 : 1);
  }

  // Position = Origin + Direction · (Spacing · index), from index 0 on.
  const Vec3d origin = choose_place(random);
  truth.steps = choose_steps(random);
  if (is_rectilinear) {
    truth.steps = {Vec3d{0.5, 0, 0}, Vec3d{0, random.one_of({0.25, -2.0}), 0}, Vec3d{0, 0, 3}};
  }
  std::string direction, spacing;
  std::array<double, 3> lengths{};
  for (size_t axis = 0; axis < 3; ++axis) lengths[axis] = length(truth.steps[axis]);
  for (const auto row : {&Vec3d::x, &Vec3d::y, &Vec3d::z}) {
    for (size_t axis = 0; axis < 3; ++axis) {
      direction += fmt::format("{:.17g} ", truth.steps[axis].*row / lengths[axis]);
    }
  }
  spacing = fmt::format("{:.17g} {:.17g} {:.17g}", lengths[0], lengths[1], lengths[2]);
  const double shift = of_cells ? 0.5 : 0;
  truth.origin = origin + truth.steps[0] * (whole[0] + shift) +
                 truth.steps[1] * (whole[2] + shift) + truth.steps[2] * (whole[4] + shift);
  sample.must_be_noted = of_cells;

  Coding coding;
  coding.format = random.one_of({"ascii", "binary", "appended"});
  coding.base64 = coding.format == "binary" || random.chance(50);
  coding.big_endian = random.chance(40);
  coding.wide = random.chance(40);
  coding.block = 8 * random.between(1, 50);  // VTK needs whole numbers in a block
  if (coding.format != "ascii" && random.chance(60)) {
    coding.compressor = random.one_of({"vtkZLibDataCompressor", "vtkLZ4DataCompressor"});
  }

  // Pieces along one axis: they share a layer of points, and may have ghost levels.
  const int along = random.between(0, 2);
  const bool is_split = random.chance(50), is_parallel = random.chance(50);
  const bool has_ghosts = is_parallel && random.chance(50), has_vectors = random.chance(30);
  const int cut = random.between(whole[2 * along], whole[2 * along + 1]);
  std::vector<Box> pieces{whole};
  if (is_split && cut > whole[2 * along] && cut < whole[2 * along + 1]) {
    pieces = {whole, whole};
    pieces[0][2 * along + 1] = cut;
    pieces[1][2 * along] = cut;
    if (random.chance(50)) std::swap(pieces[0], pieces[1]);
  }
  const auto write_piece = [&](Writer& writer, Box box) {
    const int fewer = of_cells ? 1 : 0;
    std::vector<double> values;
    for (int z = box[4]; z <= box[5] - fewer; ++z) {
      for (int y = box[2]; y <= box[3] - fewer; ++y) {
        for (int x = box[0]; x <= box[1] - fewer; ++x) {
          const int index = (z - whole[4]) * truth.sizes[1] + y - whole[2];
          values.push_back(truth.values[index * truth.sizes[0] + x - whole[0]]);
        }
      }
    }
    const int points = (box[1] - box[0] + 1) * (box[3] - box[2] + 1) * (box[5] - box[4] + 1);
    writer.text(fmt::format("<Piece Extent=\"{}\">\n", text_of(box)));
    writer.text(of_cells ? "<PointData>\n</PointData>\n<CellData Scalars='density'>\n"
                         : "<PointData Scalars='density'>\n");
    if (has_vectors) writer.array("v", Number::f32, 3, std::vector<double>(3 * values.size(), 7));
    writer.array("density", type, 1, values);
    writer.text(of_cells ? "</CellData>\n" : "</PointData>\n<CellData>\n");
    if (!of_cells) {
      writer.array("other", Number::u8, 1, std::vector<double>(static_cast<size_t>(points), 3));
      writer.text("</CellData>\n");
    }
    if (is_rectilinear) {
      writer.text("<Coordinates>\n");
      const double first[] = {origin.x, origin.y, origin.z};
      const double step[] = {truth.steps[0].x, truth.steps[1].y, truth.steps[2].z};
      for (size_t axis = 0; axis < 3; ++axis) {
        std::vector<double> positions;
        for (int i = box[2 * axis]; i <= box[2 * axis + 1]; ++i) {
          positions.push_back(first[axis] + step[axis] * i);
        }
        writer.array(std::string(1, "xyz"[axis]), Number::f64, 1, positions);
      }
      writer.text("</Coordinates>\n");
    }
    writer.text("</Piece>\n");
  };
  std::string attributes = fmt::format("WholeExtent=\"{}\"", text_of(whole));
  if (!is_rectilinear) {
    attributes += fmt::format(" Origin='{:.17g} {:.17g} {:.17g}' Spacing=\"{}\" Direction=\"{}\"",
                              origin.x, origin.y, origin.z, spacing, direction);
  }
  if (is_parallel) {
    Writer main(random, Coding{}, "P" + grid);
    main.text("<PPointData Scalars=\"density\"/>\n");
    for (size_t i = 0; i < pieces.size(); ++i) {
      const std::string name = fmt::format("p{}.{}", i, is_rectilinear ? "vtr" : "vti");
      main.text(fmt::format("<Piece Extent=\"{}\" Source=\"{}\"/>\n", text_of(pieces[i]), name));
      Box box = pieces[i];
      if (has_ghosts) {
        box[2 * along] = std::max(box[2 * along] - 1, whole[2 * along]);
        box[2 * along + 1] = std::min(box[2 * along + 1] + 1, whole[2 * along + 1]);
      }
      Writer piece(random, coding, grid);
      write_piece(piece, box);
      sample.files[name] = piece.file(attributes);
      sample.removable.insert(name);
    }
    sample.main = is_rectilinear ? "v.pvtr" : "v.pvti";
    sample.files[sample.main] = main.file(attributes);
  } else {
    Writer writer(random, coding, grid);
    for (const Box& box : pieces) write_piece(writer, box);
    sample.main = is_rectilinear ? "v.vtr" : "v.vti";
    sample.files[sample.main] = writer.file(attributes);
  }
  sample.may_be_longer = true;  // text after the last tag has no meaning
  sample.text = fmt::format("{} {} {} of {}, {} pieces{}{}{}", coding.format, coding.compressor,
                            type_name(type), of_cells ? "cells" : "points", pieces.size(),
                            is_parallel ? ", files" : "", has_ghosts ? ", ghosts" : "",
                            is_rectilinear ? ", rectilinear" : "");
  const std::string& main = sample.main;
  sample.damages.push_back([=](auto& files) {  // the whole extent is larger than the pieces
    std::string& text = files[main];
    const std::string from = fmt::format("WholeExtent=\"{}\"", text_of(whole));
    Box larger = whole;
    larger[2 * along + 1] += 1;
    text.replace(text.find(from), from.size(), fmt::format("WholeExtent=\"{}\"", text_of(larger)));
  });
  sample.damages.push_back([=](auto& files) {  // another type
    std::string& text = files.begin()->second;
    const size_t at = text.find(fmt::format("type=\"{}\" Name=\"density\"", type_name(type)));
    if (at == text.npos) return;
    text.replace(at + 6, std::string(type_name(type)).size(),
                 bytes_of(type) == 1 ? "Float64" : "Int8");
  });
  return sample;
}

}  // namespace isosplat::conformance
