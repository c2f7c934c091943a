#pragma once

#include "native/builder/builder.h"
#include "native/builder/clamped_source.h"
#include "native/builder/refusals.h"

namespace isosplat {

/// Calls build(source, options) with the values of BuildOptions::range, if it is set. Memory and
/// threads that the system refuses become an error. Errors: also those of ClampedSource::create.
template <class Build>
auto with_range(VolumeSource& source, const BuildOptions& options, Build build)
    -> decltype(build(source, options)) {
  if (!options.range) {
    return with_refusals([&] { return build(source, options); });
  }
  auto clamped = ClampedSource::create(source, *options.range);
  if (!clamped) return tl::unexpected(clamped.error());
  BuildOptions with_scan = options;
  with_scan.scan = clamped->all_values();
  auto result = with_refusals([&] {
    return build(static_cast<VolumeSource&>(*clamped), static_cast<const BuildOptions&>(with_scan));
  });
  if (options.clamped) *options.clamped = clamped->clamped();
  return result;
}

}  // namespace isosplat
