#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "native/builder/part_build.h"
#include "native/cli/building.h"
#include "native/cli/options.h"
#include "shared/import/open_volume.h"

namespace isosplat::cli {

/// A store to build from one volume: at once, in parts, or from parts.
struct StoreCall {
  std::string volume;
  std::filesystem::path store;  ///< empty: default_store()
  import::ImportOptions import;
  BuildOptions build;
  std::string volume_key;    ///< VolumeFlags::key()
  std::optional<Part> part;  ///< build only this part, to part_path()
  /// Of the store's metadata; empty: that of volume and store.
  std::string source_path_hash;
  bool joins = false;          ///< take the encoded blocks of all parts
  bool resumes = false;        ///< keep finished blocks in a file, and take them from it
  bool removes_parts = false;  ///< remove the parts once the store is complete
  bool quiet = false, force = false, no_thumbnail = false;
  StoreBuilder builder = build_store_file;  ///< builds the store, unless it is a part
};

/// The options of the commands that build a store.
struct StoreFlags {
  std::string store;
  VolumeFlags volume_flags;
  BuildFlags build_flags;
  bool quiet = false, force = false, no_thumbnail = false;

  /// Adds all of them except the store, which commands describe.
  void add_to(CLI::App& command);
  /// The call that they state, without a volume and parts. Errors: invalid_argument.
  Result<StoreCall> store_call() const;
};

/// The default output: a store beside the volume.
std::filesystem::path default_store(const std::filesystem::path& volume);

/// The file of a part of a store, and of the finished blocks of a store that can be resumed: beside
/// the store.
std::filesystem::path part_path(const std::filesystem::path& store, Part part);
std::filesystem::path unfinished_path(const std::filesystem::path& store);

/// "3/16". No value for other texts, and if there is no such part.
std::optional<Part> parse_part(std::string_view text);

/// Builds, and prints the result or an error. Returns the exit code.
int build_one_store(StoreCall call);

}  // namespace isosplat::cli
