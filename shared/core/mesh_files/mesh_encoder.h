#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "shared/core/base/status.h"
#include "shared/core/grid/grid.h"
#include "shared/core/mesh/mesh_part.h"

namespace isosplat {

/// One of several surfaces in a file.
struct MeshObject {
  std::string name;               ///< UTF-8, for people; may be empty
  std::array<float, 3> colour{};  ///< sRGB, 0 … 1
  float opacity = 1;
  VolumeGrid grid;  ///< of the volume, in the world of the file
};

/// A field whose values a file has at each of its vertices.
struct FieldColumn {
  std::string name;          ///< FieldInfo::name
  std::string title, units;  ///< UTF-8, for people; may be empty
};

/// Names for the columns of fields in a file that has other columns of the names `used`: those of
/// the fields, with "_field" appended as long as another column has the name.
std::vector<std::string> column_names(std::span<const FieldColumn> fields,
                                      std::span<const std::string_view> used);

/// One line about a field, for people: "pressure: Static pressure, in Pa".
std::string description_of(const FieldColumn& field);

/// The bytes that a part of a mesh adds to a file: those after the header, and those at the end.
struct EncodedPart {
  std::vector<std::byte> body, tail;
};

/// Encodes a mesh as the bytes of a file, part by part. The file is its header, then the bodies of
/// all parts in order, then their tails in order. The header is computed last, but its size is
/// known from the beginning. So the number of vertices and triangles need not be known in advance.
class MeshEncoder {
 public:
  virtual ~MeshEncoder() = default;

  /// Appends a part to `out`. Parts are those of MeshAssembly, in its order. They have the values
  /// of the fields that the encoder was made for, in its order. Errors:
  /// invalid_argument if the format cannot hold this number of vertices or triangles.
  virtual Result<void> append(const MeshPart& part, EncodedPart& out) = 0;

  /// Starts the next object. The parts that follow belong to it, and number their vertices from 0.
  /// Formats without objects do not get this call.
  virtual void next_object() {}

  /// Appends the bytes that follow the tails of all parts. To be called once, before header().
  virtual void finish(std::vector<std::byte>&) {}

  /// The size of the header of a mesh that has triangles.
  virtual size_t header_bytes() const = 0;

  /// The header of the parts so far.
  virtual std::vector<std::byte> header() const = 0;

 protected:
  MeshEncoder() = default;
  MeshEncoder(const MeshEncoder&) = delete;
  MeshEncoder& operator=(const MeshEncoder&) = delete;
};

/// The formats that have an encoder; their numbers are part of the interface of
/// shared/bindings/wasm.
enum class MeshFormatId : uint32_t { stl, ply, glb };

/// `grid`: of the volume. `comment`: one line for the file's header.
std::unique_ptr<MeshEncoder> make_mesh_encoder(MeshFormatId format, const VolumeGrid& grid,
                                               std::string_view comment);

}  // namespace isosplat
