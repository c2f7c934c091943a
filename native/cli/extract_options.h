#pragma once

#include <CLI/CLI.hpp>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "native/cli/remote_flags.h"
#include "native/cli/write_surface.h"

namespace isosplat::cli {

/// The arguments of isosplat extract.
struct ExtractCall {
  std::string input, output;
  std::string dataset;              ///< of a mesh: the array whose isosurface is extracted
  std::optional<double> isovalue;   ///< of a store
  std::optional<uint64_t> step;     ///< of a scene; none: the one that it shows first
  std::vector<std::string> fields;  ///< names of the store's fields whose values are written
  std::vector<std::string> layers;  ///< of a scene: names or indices; empty: all that are visible
  uint32_t level = 0;
  unsigned threads = 0;
  ProjectionOptions projection;
  std::string shading = "smooth";
  std::vector<double> box;
  bool mesh = false;
  std::optional<bool> closed;  ///< none: as the format is used
  std::vector<std::array<double, 4>> clip_planes;
  MeshChanges changes;
  bool force = false;
  RemoteFlags remote_flags;

  SurfaceContent content() const {
    return mesh ? SurfaceContent::triangles : SurfaceContent::points;
  }
};

void add_extract_options(CLI::App* command, ExtractCall* call);

/// The options for a volume that lies there, with the cells of --box. Errors: invalid_argument.
Result<ExtractOptions> extract_options(const ExtractCall& call, const VolumeGrid& grid);

/// How the surfaces of a file of this format are closed, if they are: with --box and --clip-plane,
/// in the world. Errors: invalid_argument (clip planes for an open surface, or without a normal).
Result<std::optional<SolidRequest>> solid_request(const ExtractCall& call,
                                                  const MeshFormat& format);

/// Prints why there is no surface.
void explain_no_surface(const StoreInfo& info, double isovalue, const ExtractCall& call);

/// Prints what the changes of a mesh have done.
void explain_changes(const WrittenMesh& mesh, const ExtractCall& call);

}  // namespace isosplat::cli
