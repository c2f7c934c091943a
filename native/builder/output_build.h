#pragma once

#include <filesystem>

#include "native/builder/builder.h"
#include "native/files/output_file.h"

namespace isosplat {

/// Calls build(sink, options) with a file as the sink, which appears under the name `target` when
/// the build has succeeded. options.temporary_folder is the target's folder if it was empty.
template <class Build>
Result<BuildReport> build_output_file(const std::filesystem::path& target,
                                      const BuildOptions& options, Build build) {
  auto file = OutputFile::create(target);
  if (!file) return tl::unexpected(file.error());
  BuildOptions with_folder = options;
  if (with_folder.temporary_folder.empty()) {
    with_folder.temporary_folder = target.has_parent_path() ? target.parent_path() : ".";
  }
  Result<BuildReport> report = build(static_cast<ByteSink&>(*file), with_folder);
  if (!report) return report;
  if (auto published = file->publish(); !published) return tl::unexpected(published.error());
  return report;
}

}  // namespace isosplat
