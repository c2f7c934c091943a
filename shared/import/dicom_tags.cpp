#include "shared/import/dicom_tags.h"

#include <algorithm>
#include <iterator>

namespace isosplat::dicom {
namespace {

/// In ascending order of tags.
constexpr KnownTag kKnownTags[] = {
    {kMediaSopClass, Kind::text},
    {kTransferSyntax, Kind::text},
    {kImageType, Kind::text},
    {kSopClass, Kind::text},
    {kSopInstance, Kind::text},
    {kAcquisitionDate, Kind::text},
    {kContentDate, Kind::text},
    {kAcquisitionDateTime, Kind::text},
    {kAcquisitionTime, Kind::text},
    {kContentTime, Kind::text},
    {kModality, Kind::text},
    {kSeriesDescription, Kind::text},
    {kFrameType, Kind::text},
    {kSliceThickness, Kind::text},
    {kEchoTime, Kind::text},
    {kInversionTime, Kind::text},
    {kEchoNumber, Kind::text},
    {kSpacingBetweenSlices, Kind::text},
    {kTriggerTime, Kind::text},
    {kFrameTime, Kind::text},
    {kFrameTimeVector, Kind::text},
    {kImagerPixelSpacing, Kind::text},
    {kNominalScannedPixelSpacing, Kind::text},
    {kFrameAcquisitionDateTime, Kind::text},
    {kDiffusionGradientSequence, Kind::sequence},
    {kEffectiveEchoTime, Kind::f64},
    {kDiffusionBValue, Kind::f64},
    {kDiffusionGradient, Kind::f64},
    {kMrEchoSequence, Kind::sequence},
    {kMrDiffusionSequence, Kind::sequence},
    {kCardiacSequence, Kind::sequence},
    {kMrFrameTypeSequence, Kind::sequence},
    {kCtFrameTypeSequence, Kind::sequence},
    {kPetFrameTypeSequence, Kind::sequence},
    {kStudyInstance, Kind::text},
    {kSeriesInstance, Kind::text},
    {kAcquisitionNumber, Kind::text},
    {kInstanceNumber, Kind::text},
    {kImagePosition, Kind::text},
    {kImageOrientation, Kind::text},
    {kFrameOfReference, Kind::text},
    {kTemporalPosition, Kind::text},
    {kStackId, Kind::text},
    {kFrameContentSequence, Kind::sequence},
    {kPlanePositionSequence, Kind::sequence},
    {kPlaneOrientationSequence, Kind::sequence},
    {kTemporalPositionIndex, Kind::u32},
    {kTriggerDelay, Kind::f64},
    {kDimensionIndexValues, Kind::u32},
    {kVolumePosition, Kind::f64},
    {kVolumeOrientation, Kind::f64},
    {kPlanePositionVolumeSequence, Kind::sequence},
    {kPlaneOrientationVolumeSequence, Kind::sequence},
    {kSamplesPerPixel, Kind::u16},
    {kPhotometric, Kind::text},
    {kNumberOfFrames, Kind::text},
    {kRows, Kind::u16},
    {kColumns, Kind::u16},
    {kPixelSpacing, Kind::text},
    {kBitsAllocated, Kind::u16},
    {kBitsStored, Kind::u16},
    {kHighBit, Kind::u16},
    {kPixelRepresentation, Kind::u16},
    {kPixelPadding, Kind::u16},
    {kPixelPaddingLimit, Kind::u16},
    {kRescaleIntercept, Kind::text},
    {kRescaleSlope, Kind::text},
    {kRescaleType, Kind::text},
    {kModalityLut, Kind::sequence},
    {kPixelMeasuresSequence, Kind::sequence},
    {kPixelValueTransformation, Kind::sequence},
    {kEnergyWindowVector, Kind::u16},
    {kDetectorVector, Kind::u16},
    {kDetectorInformation, Kind::sequence},
    {kRrIntervalVector, Kind::u16},
    {kTimeSlotVector, Kind::u16},
    {kSliceVector, Kind::u16},
    {kTimeSliceVector, Kind::u16},
    {kFrameReferenceTime, Kind::text},
    {kGridFrameOffsets, Kind::text},
    {kDoseGridScaling, Kind::text},
    {kSharedGroups, Kind::sequence},
    {kPerFrameGroups, Kind::sequence},
};

constexpr bool before(const KnownTag& known, Tag tag) {
  return known.tag < tag;
}

static_assert(std::is_sorted(std::begin(kKnownTags), std::end(kKnownTags),
                             [](const KnownTag& a, const KnownTag& b) { return a.tag < b.tag; }));

}  // namespace

const KnownTag* find_known_tag(Tag tag) {
  const auto* found = std::lower_bound(std::begin(kKnownTags), std::end(kKnownTags), tag, before);
  return found != std::end(kKnownTags) && found->tag == tag ? found : nullptr;
}

}  // namespace isosplat::dicom
