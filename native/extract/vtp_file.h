#pragma once

#include <string>
#include <vector>

#include "native/extract/mesh_file.h"
#include "native/files/output_file.h"
#include "native/files/spooled_bytes.h"

namespace isosplat {

/// A file of VTK's XML format for surfaces (.vtp), version 1.0, with raw appended data: points, or
/// triangles that share them. Positions have single precision, or double precision where that is
/// too coarse (position_precision.h). The point data are "Normals" and the fields by their names,
/// with their units (vtkDataArray::UNITS_LABEL); missing values are NaN. The arrays are kept in
/// temporary files until publish().
class VtpFile : public MeshFile {
 public:
  /// Errors: those of OutputFile.
  static Result<VtpFile> create(const std::filesystem::path& path,
                                const SurfaceDescription& surface);

  /// Errors: io_error.
  Result<void> append(const MeshPart& part) override;

  Result<void> publish() override;

  /// 0 until publish().
  uint64_t bytes() const override { return end_; }

 private:
  VtpFile(OutputFile file, std::vector<SpooledBytes> arrays, const SurfaceDescription& surface);

  std::string begin_array(const std::string& attributes, uint64_t bytes);
  std::string cells(const char* element);
  std::string header();
  Result<void> write(std::span<const std::byte> bytes);
  Result<void> write_array(const SpooledBytes& array);
  Result<void> write_connectivity();
  Result<void> write_offsets();
  uint64_t cell_count() const;

  OutputFile file_;
  SpooledBytes positions_, normals_, triangles_;
  std::vector<SpooledBytes> fields_;
  std::vector<FieldColumn> columns_;
  std::vector<std::string> names_;  ///< of the arrays of the fields
  bool has_doubles_, is_mesh_;
  uint64_t points_ = 0;
  uint64_t data_ = 0;  ///< bytes of the arrays that the header lists so far
  uint64_t end_ = 0;
};

}  // namespace isosplat
