#pragma once

/// \file
/// A store in a local file. Native only; link isosplat::store_file.

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string_view>
#include <vector>

#include "isosplat/status.h"
#include "isosplat/store.h"
#include "isosplat/volume.h"

namespace isosplat {

/// A store in a local file: like Store, but it reads the bytes itself. Several threads may call its
/// functions at the same time. It keeps the file open. If the file is modified while open, reading
/// fails.
class FileStore {
 public:
  /// Errors: io_error, and those of Store::open; the message begins with the path.
  [[nodiscard]] static Result<FileStore> open(const std::filesystem::path& path);

  /// After a move `other` can only be assigned to or destroyed.
  FileStore(FileStore&& other) noexcept;
  /// After a move `other` can only be assigned to or destroyed.
  FileStore& operator=(FileStore&& other) noexcept;
  ~FileStore();

  /// The volume that the store holds. Valid as long as the store.
  [[nodiscard]] const Volume& volume() const;

  /// JSON text: the volume's name, its histogram and more. Valid as long as the store.
  [[nodiscard]] std::string_view metadata() const;

  /// The chunks that hold every active cell of a level, in file order: at most one of each block.
  /// \param level below volume().levels; 0 is the finest.
  /// \param isovalue in the volume's values.
  /// Errors: not_found (no such level), invalid_argument (the isovalue is not a finite number),
  /// io_error, truncated, checksum_mismatch, malformed_page.
  [[nodiscard]] Result<std::vector<Chunk>> chunks_for(uint32_t level, double isovalue) const;

  /// The bytes of a chunk, for Decoder::decode. Errors: io_error, truncated, checksum_mismatch.
  [[nodiscard]] Result<std::vector<std::byte>> read_chunk(const Chunk& chunk) const;

 private:
  struct State;
  explicit FileStore(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace isosplat
