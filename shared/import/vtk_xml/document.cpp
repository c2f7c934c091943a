#include "shared/import/vtk_xml/document.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "shared/import/text/header_text.h"
#include "shared/import/text/xml_scanner.h"
#include "shared/import/vtk_xml/tags.h"

namespace isosplat::import {
namespace {

constexpr int64_t kMaxIndex = int64_t{1} << 31;
constexpr int64_t kMaxCount = (int64_t{1} << 32) - 1;
constexpr size_t kMaxPieces = 100'000;
constexpr size_t kMaxArrays = 1'000'000;

std::optional<VoxelType> type_named(std::string_view name) {
  static constexpr std::pair<std::string_view, VoxelType> kTypes[] = {
      {"UInt8", VoxelType::u8},    {"Int8", VoxelType::i8},    {"UInt16", VoxelType::u16},
      {"Int16", VoxelType::i16},   {"UInt32", VoxelType::u32}, {"Int32", VoxelType::i32},
      {"UInt64", VoxelType::u64},  {"Int64", VoxelType::i64},  {"Float32", VoxelType::f32},
      {"Float64", VoxelType::f64},
  };
  for (const auto& [known, type] : kTypes) {
    if (known == name) return type;
  }
  return std::nullopt;
}

class Parser {
 public:
  Parser(std::filesystem::path path, ByteReader& bytes) : bytes_(bytes), tags_(bytes) {
    file_.path = std::move(path);
  }

  Result<VtkXmlFile> parse() {
    for (;;) {
      const auto tag = tags_.next();
      if (!tag) return tl::unexpected(tag.error());
      if (!*tag) return incomplete_vtk_xml(file_.path);
      take_values(**tag);
      if ((*tag)->name == "VTKFile" && (*tag)->ends) break;
      if ((*tag)->name == "AppendedData" && (*tag)->begins) {
        if (auto found = appended(**tag); !found) return tl::unexpected(found.error());
        break;
      }
      if (auto taken = take(**tag); !taken) return tl::unexpected(taken.error());
    }
    if (!has_grid_) return malformed("expected a grid with a WholeExtent, found none");
    for (VtkXmlPiece& piece : file_.pieces) {
      for (auto* arrays : {&piece.arrays, &piece.coordinates, &piece.positions, &piece.topology}) {
        for (VtkXmlArray& array : *arrays) {
          if (auto placed = place(array); !placed) return tl::unexpected(placed.error());
        }
      }
    }
    std::erase_if(file_.pieces, [&](const VtkXmlPiece& piece) {
      // Files that name others do not state the points of their pieces.
      return is_unstructured() ? !file_.is_parallel && piece.points == 0 : piece.extent.is_empty();
    });
    // Parallel programs write empty files for processes without a part of the mesh.
    if (file_.pieces.empty() && (!is_unstructured() || file_.is_parallel)) {
      return malformed("expected a <Piece> with points, found none");
    }
    return std::move(file_);
  }

 private:
  bool is_unstructured() const { return file_.grid == VtkXmlGrid::unstructured; }

  tl::unexpected<Error> malformed(const std::string& what) const {
    return malformed_vtk_xml(file_.path, what);
  }

  /// Records the text before a tag as the values of the DataArray around it.
  void take_values(const XmlTag& tag) {
    if (!open_) return;
    if (depth_ == 0 && tags_.words() > 0 && open_->words == 0) {
      open_->begin = open_begin_;
      open_->end = tags_.begin();
      open_->words = tags_.words();
    }
    if (tag.name == "DataArray") {
      open_ = nullptr;
    } else if (tag.begins != tag.ends) {
      depth_ += tag.begins ? 1 : -1;
    }
    open_begin_ = tags_.end();
  }

  Result<void> take(const XmlTag& tag) {
    const std::string_view plain = tag.name.starts_with('P') && tag.name != "Piece" &&
                                           tag.name != "PointData" && tag.name != "Points"
                                       ? tag.name.substr(1)
                                       : tag.name;
    if (tag.name == "VTKFile") return take_file(tag);
    if (plain == "ImageData" || plain == "RectilinearGrid" || plain == "StructuredGrid") {
      return tag.begins ? take_grid(tag) : Result<void>();
    }
    if (plain == "UnstructuredGrid") has_grid_ = true;
    if (tag.name == "Piece" && tag.begins) return take_piece(tag);
    if (plain == "PointData" || plain == "CellData") {
      section_ = tag.ends ? Section::none : plain == "CellData" ? Section::cells : Section::points;
      auto& scalars = plain == "CellData" ? file_.cell_scalars : file_.point_scalars;
      if (const auto name = tag.attribute("Scalars"); name && scalars.empty()) scalars = *name;
    }
    if (plain == "Coordinates") section_ = tag.ends ? Section::none : Section::coordinates;
    if (plain == "Points") section_ = tag.ends ? Section::none : Section::positions;
    if (plain == "Cells") section_ = tag.ends ? Section::none : Section::topology;
    if (tag.name == "DataArray" && tag.begins && section_ != Section::none &&
        !file_.pieces.empty()) {
      return take_array(tag);
    }
    return {};
  }

  Result<void> take_file(const XmlTag& tag) {
    const std::string type = tag.attribute("type").value_or("");
    file_.is_parallel = type.starts_with('P');
    file_.grid = type.ends_with("RectilinearGrid")    ? VtkXmlGrid::rectilinear
                 : type.ends_with("UnstructuredGrid") ? VtkXmlGrid::unstructured
                 : type.ends_with("StructuredGrid")   ? VtkXmlGrid::structured
                                                      : VtkXmlGrid::image;
    const std::string version = tag.attribute("version").value_or("0.1");
    const auto major = whole_number(std::string_view(version).substr(0, version.find('.')));
    if (!major || *major < 0 || *major > 2) {
      return fail(Status::unsupported_format,
                  fmt::format("{}: expected version 0.1 to 2 of VTK's XML format, found {}: save "
                              "it with an older version of VTK or ParaView",
                              file_.path.string(), version));
    }
    const std::string order = tag.attribute("byte_order").value_or("LittleEndian");
    if (order != "LittleEndian" && order != "BigEndian") {
      return malformed(fmt::format("expected a byte_order, found '{}'", order));
    }
    file_.big_endian = order == "BigEndian";
    const std::string header = tag.attribute("header_type").value_or("UInt32");
    if (header != "UInt32" && header != "UInt64") {
      return malformed(fmt::format("expected header_type UInt32 or UInt64, found '{}'", header));
    }
    file_.header_bytes = header == "UInt64" ? 8 : 4;
    const std::string compressor = tag.attribute("compressor").value_or("");
    if (compressor == "vtkZLibDataCompressor") file_.compressor = VtkXmlCompressor::zlib;
    if (compressor == "vtkLZ4DataCompressor") file_.compressor = VtkXmlCompressor::lz4;
    if (compressor == "vtkLZMADataCompressor") file_.compressor = VtkXmlCompressor::lzma;
    if (!compressor.empty() && file_.compressor == VtkXmlCompressor::none) {
      return fail(Status::unsupported_format,
                  fmt::format("{}: expected values compressed by ZLib, LZ4 or LZMA, found '{}': "
                              "save the volume with another compressor",
                              file_.path.string(), compressor));
    }
    return {};
  }

  /// Numbers of an attribute. Errors: malformed_volume if there is another number of them.
  Result<std::vector<double>> numbers(const XmlTag& tag, const char* name, size_t count) const {
    const auto found = numbers_in(tag.attribute(name).value_or(""));
    if (found && found->size() == count) return *found;
    return malformed(fmt::format("expected {} numbers in {}", count, name));
  }

  Result<VtkXmlExtent> extent(const XmlTag& tag, const char* name) const {
    const auto found = whole_numbers(tag.attribute(name).value_or(""));
    if (!found || found->size() != 6) {
      return malformed(fmt::format("expected 6 whole numbers in {}", name));
    }
    VtkXmlExtent extent;
    for (size_t axis = 0; axis < 3; ++axis) {
      extent.low[axis] = (*found)[2 * axis];
      extent.high[axis] = (*found)[2 * axis + 1];
    }
    for (const int64_t index : *found) {
      if (index < -kMaxIndex || index > kMaxIndex) {
        return malformed(fmt::format("expected indices below 2147483648 in {}", name));
      }
    }
    return extent;
  }

  Result<void> take_grid(const XmlTag& tag) {
    const auto whole = extent(tag, "WholeExtent");
    if (!whole) return tl::unexpected(whole.error());
    file_.whole = *whole;
    has_grid_ = true;
    for (const char* name : {"Origin", "Spacing"}) {
      if (!tag.attribute(name)) continue;
      const auto found = numbers(tag, name, 3);
      if (!found) return tl::unexpected(found.error());
      const Vec3d vector{(*found)[0], (*found)[1], (*found)[2]};
      if (*name == 'O') file_.origin = vector;
      if (*name == 'S') file_.spacing = vector;
    }
    if (!tag.attribute("Direction")) return {};
    const auto found = numbers(tag, "Direction", 9);
    if (!found) return tl::unexpected(found.error());
    file_.direction.emplace();
    std::copy(found->begin(), found->end(), file_.direction->begin());
    return {};
  }

  Result<void> take_piece(const XmlTag& tag) {
    if (file_.pieces.size() == kMaxPieces) {
      return malformed(fmt::format("expected at most {} pieces, found more", kMaxPieces));
    }
    VtkXmlPiece piece;
    piece.source = tag.attribute("Source").value_or("");
    if (!is_unstructured()) {
      const auto box = extent(tag, "Extent");
      if (!box) return tl::unexpected(box.error());
      piece.extent = *box;
    } else if (!file_.is_parallel) {
      for (const char* name : {"NumberOfPoints", "NumberOfCells"}) {
        const auto count = whole_number(tag.attribute(name).value_or(""));
        if (!count || *count < 0 || *count > kMaxCount) {
          return malformed(fmt::format("expected a number below 4294967296 in {}", name));
        }
        (name[8] == 'P' ? piece.points : piece.cells) = static_cast<uint64_t>(*count);
      }
    }
    const bool is_empty = !is_unstructured() && piece.extent.is_empty();
    if (file_.is_parallel && piece.source.empty() && !is_empty) {
      return malformed("expected a Source in each <Piece>");
    }
    file_.pieces.push_back(std::move(piece));
    return {};
  }

  Result<void> take_array(const XmlTag& tag) {
    VtkXmlPiece& piece = file_.pieces.back();
    VtkXmlArray array;
    array.name = tag.attribute("Name").value_or("");
    // Messages are one line.
    std::replace_if(
        array.name.begin(), array.name.end(), [](unsigned char c) { return c < ' '; }, ' ');
    array.type_name = tag.attribute("type").value_or("");
    array.type = type_named(array.type_name);
    array.of_cells = section_ == Section::cells;
    const auto components = whole_number(tag.attribute("NumberOfComponents").value_or("1"));
    const auto offset = whole_number(tag.attribute("offset").value_or("0"));
    const std::string format = tag.attribute("format").value_or("ascii");
    // VTK writes 0 components for arrays of one in some versions.
    array.components = std::max<int64_t>(components.value_or(-1), 1);
    if (!components || *components < 0 || *components > 1000 || !offset || *offset < 0 ||
        ++arrays_ > kMaxArrays ||
        (format != "ascii" && format != "binary" && format != "appended")) {
      return malformed(
          fmt::format("expected components, a format and an offset of the array '{}'", array.name));
    }
    array.format = format == "ascii"    ? VtkXmlArray::Format::ascii
                   : format == "binary" ? VtkXmlArray::Format::base64
                                        : VtkXmlArray::Format::appended;
    if (format == "appended") array.begin = static_cast<uint64_t>(*offset);
    auto& arrays = section_ == Section::coordinates ? piece.coordinates
                   : section_ == Section::positions ? piece.positions
                   : section_ == Section::topology  ? piece.topology
                                                    : piece.arrays;
    arrays.push_back(std::move(array));
    if (!tag.ends && format != "appended") {
      open_ = &arrays.back();
      open_begin_ = tags_.end();
      depth_ = 0;
    }
    return {};
  }

  /// Finds the "_" before the appended data.
  Result<void> appended(const XmlTag& tag) {
    const std::string encoding = tag.attribute("encoding").value_or("raw");
    if (encoding != "raw" && encoding != "base64") {
      return malformed(
          fmt::format("expected appended data in raw or base64, found '{}'", encoding));
    }
    file_.appended_base64 = encoding == "base64";
    std::array<std::byte, 1> byte{};
    for (uint64_t at = tags_.end(); at < bytes_.size_limit(); ++at) {
      if (auto read = bytes_.read(at, byte); !read) return read;
      const char c = static_cast<char>(byte[0]);
      if (c == '_') {
        appended_ = at + 1;
        return {};
      }
      if (c != ' ' && (c < '\t' || c > '\r')) break;
    }
    return malformed("expected '_' before the appended data");
  }

  /// Makes the offset of an appended array one in the file.
  Result<void> place(VtkXmlArray& array) {
    if (array.format != VtkXmlArray::Format::appended) return {};
    if (!appended_) return malformed("expected <AppendedData>, found none");
    array.begin += *appended_;
    array.end = std::max(bytes_.size_limit(), array.begin);
    return {};
  }

  enum class Section : uint8_t { none, points, cells, coordinates, positions, topology };

  ByteReader& bytes_;
  XmlTags tags_;
  VtkXmlFile file_;
  Section section_ = Section::none;
  bool has_grid_ = false;
  size_t arrays_ = 0;
  VtkXmlArray* open_ = nullptr;  ///< the DataArray around the text that is read
  uint64_t open_begin_ = 0;      ///< where this text begins
  int depth_ = 0;                ///< of elements in this DataArray
  std::optional<uint64_t> appended_;
};

}  // namespace

std::string vtk_xml_type(std::string_view beginning) {
  XmlScanner scanner(beginning);
  const auto tag = scanner.next();
  if (!tag || tag->name != "VTKFile") return {};
  return tag->attribute("type").value_or("");
}

Result<VtkXmlFile> read_vtk_xml(const std::filesystem::path& path) {
  auto bytes = open_plain(path);
  if (!bytes) return tl::unexpected(bytes.error());
  return Parser(path, **bytes).parse();
}

tl::unexpected<Error> incomplete_vtk_xml(const std::filesystem::path& path) {
  return fail(Status::truncated,
              fmt::format("{}: expected </VTKFile>, found the end of the file: it is incomplete; "
                          "copy or download it again",
                          path.string()));
}

tl::unexpected<Error> malformed_vtk_xml(const std::filesystem::path& path,
                                        const std::string& what) {
  return fail(
      Status::malformed_volume,
      fmt::format("{}: {}: the VTK file is damaged; export the volume again", path.string(), what));
}

}  // namespace isosplat::import
