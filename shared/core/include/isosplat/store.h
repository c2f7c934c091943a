#pragma once

/// \file
/// Which chunks of a store hold the cells of an isosurface, from bytes that the caller supplies.

#include <cstddef>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "isosplat/geometry.h"
#include "isosplat/status.h"
#include "isosplat/volume.h"

namespace isosplat {

/// The header of a store ends within this many bytes of the file's start.
inline constexpr size_t kMaxHeaderBytes = size_t{64} * 1024;

/// One chunk of a store: the cells of a block of 64×64×64 cells that are active for some isovalue
/// of a band. A cell is active where min ≤ isovalue < max over its voxels.
struct Chunk {
  uint32_t level = 0;       ///< 0 is the finest
  Index3 block;             ///< the block's index along each axis, in blocks of this level
  uint32_t band = 0;        ///< the band's index within the block, ascending by isovalue
  uint32_t band_begin = 0;  ///< the band's first quantized value
  uint32_t band_end = 0;    ///< one beyond its last
  uint64_t offset = 0;      ///< of the chunk's bytes in the store file
  uint32_t bytes = 0;       ///< size in the store file
  uint32_t cells = 0;       ///< number of cells that the bytes decode to, ≥ 1
  uint32_t checksum = 0;    ///< low 32 bits of XXH3-64 of the bytes
};

/// A page of the store's directory: it describes the chunks of some blocks.
struct Page {
  uint32_t index = 0;   ///< the argument of Store::add_page
  uint64_t offset = 0;  ///< of the page's bytes in the store file
  uint32_t bytes = 0;   ///< size in the store file
};

/// A store's directory. It reads nothing itself. The caller supplies the bytes, from a file, a
/// socket or an archive. They need not be trusted: invalid bytes give an error. Accepted bytes are
/// copied. Several threads may call const functions at a time. FileStore does the same for a file.
///
/// \code
/// auto store = isosplat::Store::open(first_bytes);
/// for (const isosplat::Page& page : store->missing_pages(level, isovalue)) {
///   store->add_page(page.index, fetch(page.offset, page.bytes));
/// }
/// auto chunks = store->chunks_for(level, isovalue);
/// \endcode
class Store {
 public:
  /// \param header the first min(kMaxHeaderBytes, file size) bytes of the store file; more is
  ///   ignored.
  /// Errors: not_a_store, unsupported_version, truncated, checksum_mismatch, malformed_header.
  [[nodiscard]] static Result<Store> open(std::span<const std::byte> header);

  /// After a move `other` can only be assigned to or destroyed.
  Store(Store&& other) noexcept;
  /// After a move `other` can only be assigned to or destroyed.
  Store& operator=(Store&& other) noexcept;
  ~Store();

  /// The volume that the store holds. Valid as long as the store.
  [[nodiscard]] const Volume& volume() const;

  /// Size of the whole store file in bytes.
  [[nodiscard]] uint64_t file_bytes() const;

  /// JSON text: the volume's name, its histogram and more. Valid as long as the store.
  [[nodiscard]] std::string_view metadata() const;

  /// The pages that chunks_for() needs for this level and isovalue and that have not been added.
  /// Empty for a level that does not exist and an isovalue that is not a number.
  [[nodiscard]] std::vector<Page> missing_pages(uint32_t level, double isovalue) const;

  /// Adds the bytes of a page. Adding a page again is harmless.
  /// Errors: not_found, truncated, checksum_mismatch, malformed_page.
  [[nodiscard]] Result<void> add_page(uint32_t page, std::span<const std::byte> bytes);

  /// The chunks that hold every active cell of a level: at most one of each block.
  /// \param level below volume().levels; 0 is the finest.
  /// \param isovalue in the volume's values.
  /// Errors: not_found (no such level), invalid_argument (the isovalue is not a finite number),
  /// page_not_resident (missing_pages() names the pages).
  [[nodiscard]] Result<std::vector<Chunk>> chunks_for(uint32_t level, double isovalue) const;

 private:
  struct State;
  explicit Store(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace isosplat
