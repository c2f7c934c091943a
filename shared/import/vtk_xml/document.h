#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "shared/core/base/matrix3.h"
#include "shared/core/base/status.h"
#include "shared/core/grid/voxel_type.h"

namespace isosplat::import {

/// A box of points: the indices of the first and last one along each axis. Up to 2^31 in size.
struct VtkXmlExtent {
  std::array<int64_t, 3> low{}, high{};

  bool is_empty() const { return high[0] < low[0] || high[1] < low[1] || high[2] < low[2]; }
};

/// A DataArray: where its values are.
struct VtkXmlArray {
  enum class Format : uint8_t { ascii, base64, appended, plain };  ///< plain: of legacy files

  std::string name;
  std::optional<VoxelType> type;  ///< nothing for unsupported types
  std::string type_name;
  int64_t components = 1;
  bool of_cells = false;
  Format format = Format::ascii;
  uint64_t begin = 0, end = 0;  ///< the part of the file with its values, or up to the file's end
  uint64_t words = 0;           ///< in text form: the number of values
};

/// The kinds of grids: evenly spaced, with an array of positions for each axis, with a position for
/// each point of a lattice, and with cells of several shapes.
enum class VtkXmlGrid : uint8_t { image, rectilinear, structured, unstructured };

/// How a file states the number of nodes of each cell: by the array "offsets" of the ends of cells
/// in "connectivity"; by one with a 0 before them; or by numbers before the nodes in the array
/// "cells".
enum class VtkCellLayout : uint8_t { ends, offsets, counts };  // XML; legacy from 5.0 on; before

/// A part of the grid.
struct VtkXmlPiece {
  VtkXmlExtent extent;             ///< not of unstructured grids
  uint64_t points = 0, cells = 0;  ///< of unstructured grids, below 2^32 each
  std::string source;              ///< in files that refer to others: the name of the piece's file
  std::vector<VtkXmlArray> arrays;
  std::vector<VtkXmlArray> coordinates;  ///< of rectilinear grids: of x, y and z
  std::vector<VtkXmlArray> positions;    ///< the arrays in <Points>: one
  std::vector<VtkXmlArray> topology;     ///< those in <Cells>: connectivity, offsets, types, …
  VtkCellLayout layout = VtkCellLayout::ends;
};

enum class VtkXmlCompressor : uint8_t { none, zlib, lz4, lzma };

/// A file without its values.
struct VtkXmlFile {
  std::filesystem::path path;
  VtkXmlGrid grid = VtkXmlGrid::image;
  bool is_parallel = false;  ///< its pieces are in other files
  bool big_endian = false;
  size_t header_bytes = 4;  ///< of each number before the values of an array
  VtkXmlCompressor compressor = VtkXmlCompressor::none;
  bool appended_base64 = false;
  VtkXmlExtent whole;
  Vec3d origin{0, 0, 0};
  std::optional<Vec3d> spacing;
  std::optional<Matrix3d> direction;
  std::string point_scalars, cell_scalars;  ///< names; may be empty
  std::vector<VtkXmlPiece> pieces;  ///< without empty ones; unstructured grids may have none
};

/// The type of a file of VTK's XML format, such as "ImageData", by its first bytes; empty if it is
/// none.
std::string vtk_xml_type(std::string_view beginning);

/// Reads a file of the types ImageData, RectilinearGrid, StructuredGrid and UnstructuredGrid, with
/// or without a "P" before them, up to its appended data. Errors: io_error, malformed_volume,
/// truncated, unsupported_format.
Result<VtkXmlFile> read_vtk_xml(const std::filesystem::path& path);

/// The error truncated, for a file that ends before </VTKFile>.
tl::unexpected<Error> incomplete_vtk_xml(const std::filesystem::path& path);

/// The error malformed_volume.
tl::unexpected<Error> malformed_vtk_xml(const std::filesystem::path& path, const std::string& what);

}  // namespace isosplat::import
