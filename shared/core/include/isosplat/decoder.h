#pragma once

/// \file
/// Decodes the bytes of a chunk to cells, samples and points. "The paper" is Co, Hamann and Joy
/// (2003); see points.h.

#include <cstddef>
#include <memory>
#include <span>

#include "isosplat/points.h"
#include "isosplat/status.h"
#include "isosplat/store.h"
#include "isosplat/volume.h"

namespace isosplat {

/// The cells of one chunk, each with the values of its eight voxels.
class Cells {
 public:
  /// No cells.
  Cells();
  /// After a move `other` can only be assigned to or destroyed.
  Cells(Cells&& other) noexcept;
  /// After a move `other` can only be assigned to or destroyed.
  Cells& operator=(Cells&& other) noexcept;
  ~Cells();

  /// The number of cells, active or not.
  [[nodiscard]] size_t size() const;

  /// One sample at the centre of each cell, from which the isosurface can be reached (the paper,
  /// section 4). Arrays of size() entries.
  [[nodiscard]] SampleArrays samples() const;

  /// One point on the isosurface for each active cell, unless the options drop some (the paper,
  /// section 3). Normals are the gradients of each cell's own trilinear function: smooth ones
  /// (`isosplat extract`) need the cells of the neighbouring chunks. Empty where the isovalue lies
  /// outside the chunk's band, or is not a number.
  /// \param isovalue in the volume's values.
  /// \param options the paper's exact or approximate projection.
  [[nodiscard]] PointArrays project(double isovalue, const ProjectionOptions& options = {}) const;

 private:
  friend class Decoder;
  struct State;
  std::unique_ptr<State> state_;
};

/// Decodes chunks of one store. Keeps about 2 MB of scratch memory between calls: use one decoder
/// per thread.
class Decoder {
 public:
  /// \param volume that of the store, as Store::volume() and FileStore::volume() return it; copied.
  explicit Decoder(const Volume& volume);
  /// After a move `other` can only be assigned to or destroyed.
  Decoder(Decoder&& other) noexcept;
  /// After a move `other` can only be assigned to or destroyed.
  Decoder& operator=(Decoder&& other) noexcept;
  ~Decoder();

  /// Decodes exactly chunk.cells cells, or fails; the bytes may be anything.
  /// \param chunk as Store::chunks_for() returned it for the same volume.
  /// \param bytes the chunk.bytes bytes of the store file at chunk.offset.
  /// \param cells replaced; its memory is used again. Unspecified after an error.
  /// Errors: truncated (fewer or more bytes than chunk.bytes), checksum_mismatch,
  /// malformed_chunk, invalid_argument (the volume has no such chunk).
  [[nodiscard]] Result<void> decode(const Chunk& chunk, std::span<const std::byte> bytes,
                                    Cells& cells);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace isosplat
