#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string_view>
#include <vector>

#include "shared/core/base/vec3.h"
#include "tests/native/test_volume.h"

namespace isosplat {

/// The ways to divide iso-splatting between preprocessing, extraction and rendering (paper, Table
/// 1), and the paper's baseline.
enum class Paradigm : uint8_t {
  a,              ///< samples in preprocessing, projection at extraction
  b,              ///< samples in preprocessing, projection at rendering, like Isosplat
  c,              ///< samples and projection at extraction
  d,              ///< samples at extraction, projection at rendering
  marching_cubes  ///< triangles at extraction (paper, section 6)
};
inline constexpr std::array<std::string_view, 5> kParadigmNames{"a", "b", "c", "d", "mc"};

/// The result of an extraction.
struct Extraction {
  /// For (B), 0 unless cells are counted, since the vertex shader finds them.
  uint64_t active_cells = 0;
  uint64_t bytes = 0;  ///< of samples, points with normals, or triangles' vertices with normals
  /// Σ over active cells of a hash of their index: equal for equal sets of cells.
  uint64_t cells_hash = 0;
};

/// A volume that is prepared for extractions by one paradigm. Runs on one thread.
class Extractor {
 public:
  virtual ~Extractor() = default;

  /// Replaces the result of the previous extraction.
  virtual Extraction extract(double isovalue) = 0;

  /// Bytes that preprocessing has made: the size of the store file, or of the interval tree.
  virtual uint64_t prepared_bytes() const = 0;
};

/// (A) and (B) use a store of the volume in `folder`, which is built if it does not exist. (C), (D)
/// and marching cubes keep the volume and an interval tree of its cells in memory. Ends the program
/// if that fails. `volume` must outlive the extractor; (A) and (B) do not use it afterwards.
/// `count_cells`: also count active cells and compute Extraction::cells_hash, which takes time.
std::unique_ptr<Extractor> make_extractor(Paradigm paradigm, const TestVolume& volume,
                                          const std::filesystem::path& folder, bool count_cells);

}  // namespace isosplat
