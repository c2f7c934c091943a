#pragma once

#include "native/extract/mesh_file.h"
#include "native/files/output_file.h"
#include "native/files/spooled_bytes.h"

namespace isosplat {

/// A ZIP archive of NumPy arrays (.npz), without compression:
///   positions.npy  (points, 3), f4, or f8 where single precision is too coarse: world
///   normals.npy    (points, 3), f4: of unit length, towards smaller values
///   triangles.npy  (triangles, 3), u4: indices of points; only of a mesh
///   isovalue.npy   (), f8
///   NAME.npy       (points,), f4: the values of the field NAME; missing values are NaN
/// The arrays are kept in temporary files until publish().
class NpzFile : public MeshFile {
 public:
  /// Errors: those of OutputFile.
  static Result<NpzFile> create(const std::filesystem::path& path,
                                const SurfaceDescription& surface);

  /// Errors: io_error.
  Result<void> append(const MeshPart& part) override;

  Result<void> publish() override;

  /// 0 until publish().
  uint64_t bytes() const override { return end_; }

 private:
  NpzFile(OutputFile file, SpooledBytes positions, SpooledBytes normals, SpooledBytes triangles,
          std::vector<SpooledBytes> fields, const SurfaceDescription& surface);

  OutputFile file_;
  SpooledBytes positions_, normals_, triangles_;
  std::vector<SpooledBytes> fields_;
  std::vector<std::string> names_;  ///< of the arrays of the fields
  bool has_doubles_, is_mesh_;
  double isovalue_;
  uint64_t end_ = 0;
};

}  // namespace isosplat
