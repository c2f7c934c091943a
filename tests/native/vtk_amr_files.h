#pragma once

#include <fmt/format.h>

#include <filesystem>
#include <string>

#include "tests/native/test_files.h"
#include "tests/shared/adaptive_fixture.h"

// Writes adaptive grids as VTK's XML format has them (VTK File Formats;
// vtkXMLUniformGridAMRWriter).
namespace isosplat::test {

struct VtkAmrFile {
  Vec3d origin{-1, -1, -1};
  double spacing = 0.0625;  ///< of level 0
};

/// Writes NAME.vthb, and the patches as NAME/NAME_I.vti in raw appended doubles. Returns its path.
inline std::string write_vtk_amr(const TempFolder& folder, const std::string& name,
                                 const adaptive_test::Case& grid, const VtkAmrFile& file = {}) {
  std::filesystem::create_directories(folder / name);
  std::string text = fmt::format(
      "<VTKFile type=\"vtkOverlappingAMR\" version=\"1.1\" byte_order=\"LittleEndian\" "
      "header_type=\"UInt32\">\n  <vtkOverlappingAMR origin=\"{} {} {}\" "
      "grid_description=\"XYZ\">\n",
      file.origin.x, file.origin.y, file.origin.z);
  size_t number = 0;
  for (size_t level = 0; level <= grid.ratios.size(); ++level) {
    const double spacing = file.spacing / grid.edge(0, level);
    text += fmt::format("    <Block level=\"{0}\" spacing=\"{1} {1} {1}\">\n", level, spacing);
    size_t index = 0;
    for (const adaptive_test::Patch& patch : grid.patches) {
      if (patch.level != level) continue;
      const Index3 low = patch.box.low, high = patch.box.high;
      const std::string piece = fmt::format("{0}/{0}_{1}.vti", name, number++);
      text +=
          fmt::format("      <DataSet index=\"{}\" amr_box=\"{} {} {} {} {} {}\" file=\"{}\"/>\n",
                      index++, low.x, high.x - 1, low.y, high.y - 1, low.z, high.z - 1, piece);
      const auto bytes = static_cast<uint32_t>(patch.values.size() * sizeof(double));
      const bool are_cells = grid.centring == Centring::cells;
      std::string vti = fmt::format(
          "<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" "
          "header_type=\"UInt32\">\n<ImageData WholeExtent=\"0 {0} 0 {1} 0 {2}\" Origin=\"{3} {4} "
          "{5}\" Spacing=\"{6} {6} {6}\">\n<Piece Extent=\"0 {0} 0 {1} 0 {2}\"><{7}>\n<DataArray "
          "type=\"Float64\" Name=\"density\" format=\"appended\" offset=\"0\"/></{7}></Piece>\n"
          "</ImageData>\n<AppendedData encoding=\"raw\">_",
          high.x - low.x, high.y - low.y, high.z - low.z, file.origin.x + low.x * spacing,
          file.origin.y + low.y * spacing, file.origin.z + low.z * spacing, spacing,
          are_cells ? "CellData" : "PointData");
      vti.append(reinterpret_cast<const char*>(&bytes), sizeof bytes);
      vti.append(reinterpret_cast<const char*>(patch.values.data()), bytes);
      write_file(folder / piece, vti + "</AppendedData></VTKFile>\n");
    }
    text += "    </Block>\n";
  }
  const std::string path = folder / (name + ".vthb");
  write_file(path, text + "  </vtkOverlappingAMR>\n</VTKFile>\n");
  return path;
}

}  // namespace isosplat::test
