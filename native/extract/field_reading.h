#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "shared/core/codec/chunk_codec.h"
#include "shared/core/mesh/block_mesh.h"
#include "shared/core/mesh_files/mesh_encoder.h"
#include "shared/core/points/chunk_samples.h"
#include "shared/core/points/field_lattice.h"
#include "shared/system/store_file/store_file.h"

namespace isosplat {

/// Opened fields of a store (open_field). Null: the store has no such field, and all values are
/// missing.
using OpenedFields = std::vector<std::shared_ptr<const StoreFile>>;

/// Opens the fields of a store with these names, in this order. Errors: those of find_field and
/// open_field, and invalid_argument for a name that is given twice.
Result<OpenedFields> open_fields(const StoreFile& store, std::span<const std::string> names);

/// The same for the fields that the store has; null for the others.
Result<OpenedFields> open_known_fields(const StoreFile& store, std::span<const FieldColumn> fields);

/// Whether the store has a field of this name.
bool has_field(const StoreInfo& store, const std::string& name);

/// The names of opened fields in files, with the titles and units of their metadata. Not null.
std::vector<FieldColumn> columns_of(const OpenedFields& fields);

/// For each field, whether its values are labels.
std::vector<bool> are_categories(const OpenedFields& fields);

/// Interpolates the values of fields in the blocks of a store, one block after the other. One
/// object per thread.
class FieldReader {
 public:
  /// `fields`: borrowed.
  explicit FieldReader(const OpenedFields& fields);

  /// Reads the field chunks of a chunk of the store. cells: all cells of the chunk. Errors: those
  /// of StoreFile and ChunkDecoder.
  Result<void> read(ChunkDecoder& decoder, const ChunkRef& chunk, Index3 block_cells,
                    std::span<const uint32_t> cells);

  /// The values at points in cells of the chunk that was read last: see FieldLattice.
  FieldValues at(std::span<const PointPlace> places) const;
  FieldValues at(std::span<const MeshVertex> vertices) const;

 private:
  template <class Point, class ValueAt>
  FieldValues values_at(std::span<const Point> points, const ValueAt& value_at) const;

  const OpenedFields& fields_;
  std::vector<std::optional<FieldLattice>> lattices_;
  std::vector<std::byte> bytes_;
  std::vector<CellCorners> corners_;
};

}  // namespace isosplat
