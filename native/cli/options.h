#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <optional>
#include <string>

#include "native/builder/builder.h"
#include "shared/import/open_volume.h"

// Options that several subcommands share.
namespace isosplat::cli {

/// Upper limit of --threads: more threads would only use more memory.
inline constexpr unsigned kMaxThreads = 256;

/// The options that control how a volume is read.
class VolumeFlags {
 public:
  void add_to(CLI::App& command);

  /// Errors: invalid_argument.
  Result<import::ImportOptions> options() const;

  /// All options as text: part of the key of a cached store.
  std::string key() const;

 private:
  std::string dims_, type_, spacing_, endian_, missing_value_, series_, segment_, dataset_;
  import::Allowances allowed_;
  uint64_t skip_bytes_ = 0;
  int64_t time_step_ = -1, channel_ = -1;
};

/// The options that control how a store is built.
class BuildFlags {
 public:
  void add_to(CLI::App& command);

  /// Limits the memory to that of the machine. Errors: invalid_argument.
  Result<BuildOptions> options() const;

  /// The options that change the store's bytes, as text: part of the key of a cached store.
  std::string key() const;

 private:
  std::string title_, units_, memory_ = "1G";
  std::string temporary_folder_;
  std::vector<double> range_;
  double max_error_ = 0;
  double fetch_weight_ = BuildOptions{}.fetch_weight;
  unsigned threads_ = 0;
};

/// The examples at the end of a subcommand's --help.
std::string examples(const std::string& lines);

}  // namespace isosplat::cli
