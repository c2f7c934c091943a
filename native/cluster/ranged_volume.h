#pragma once

#include <memory>
#include <span>

#include "native/builder/builder.h"
#include "native/builder/clamped_source.h"

namespace isosplat {

/// The volume of a build by several ranks, with the values of BuildOptions::range if it is set.
class RangedVolume {
 public:
  /// Borrows the source. Errors: those of ClampedSource::create.
  static Result<RangedVolume> create(VolumeSource& source, const BuildOptions& options) {
    RangedVolume volume(source);
    if (!options.range) return volume;
    auto clamped = ClampedSource::create(source, *options.range);
    if (!clamped) return tl::unexpected(clamped.error());
    volume.clamped_ = std::make_unique<ClampedSource>(std::move(*clamped));
    return volume;
  }

  VolumeSource& source() { return clamped_ ? *clamped_ : source_; }
  /// Null without a range.
  ClampedSource* clamped() { return clamped_.get(); }
  /// ClampedSource::of_slices(); empty without a range.
  std::span<const ClampedVoxels> clamped_slices() const {
    return clamped_ ? std::span(clamped_->of_slices()) : std::span<const ClampedVoxels>();
  }

 private:
  explicit RangedVolume(VolumeSource& source) : source_(source) {}

  VolumeSource& source_;
  std::unique_ptr<ClampedSource> clamped_;
};

}  // namespace isosplat
