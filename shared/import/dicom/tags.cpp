#include "shared/import/dicom/tags.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

namespace isosplat::import::dicom {
namespace {

/// In ascending order of tags.
constexpr KnownTag kKnownTags[] = {
    {kMediaSopClass, Kind::text},
    {kTransferSyntax, Kind::text},
    {kImageType, Kind::text},
    {kSopClass, Kind::text},
    {kSopInstance, Kind::text},
    {kSeriesDate, Kind::text},
    {kAcquisitionDate, Kind::text},
    {kContentDate, Kind::text},
    {kAcquisitionDateTime, Kind::text},
    {kAcquisitionTime, Kind::text},
    {kContentTime, Kind::text},
    {kModality, Kind::text},
    {kCodeValue, Kind::text},
    {kCodeMeaning, Kind::text},
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
    {kSliceLocationVector, Kind::text},
    {kNominalScannedPixelSpacing, Kind::text},
    {kUltrasoundRegions, Kind::sequence},
    {kPhysicalUnitsX, Kind::u16},
    {kPhysicalUnitsY, Kind::u16},
    {kPhysicalDeltaX, Kind::f64},
    {kPhysicalDeltaY, Kind::f64},
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
    {kPatientOrientation, Kind::text},
    {kImagePosition, Kind::text},
    {kImageOrientation, Kind::text},
    {kFrameOfReference, Kind::text},
    {kTemporalPosition, Kind::text},
    {kSliceLocation, Kind::text},
    {kStackId, Kind::text},
    {kFrameContentSequence, Kind::sequence},
    {kPlanePositionSequence, Kind::sequence},
    {kPlaneOrientationSequence, Kind::sequence},
    {kTemporalPositionIndex, Kind::u32},
    {kTriggerDelay, Kind::f64},
    {kDimensionIndexValues, Kind::u32},
    {kConcatenation, Kind::text},
    {kConcatenationNumber, Kind::u16},
    {kConcatenationTotal, Kind::u16},
    {kVolumePosition, Kind::f64},
    {kVolumeOrientation, Kind::f64},
    {kPlanePositionVolumeSequence, Kind::sequence},
    {kPlaneOrientationVolumeSequence, Kind::sequence},
    {kDimensionOrganization, Kind::text},
    {kSamplesPerPixel, Kind::u16},
    {kPhotometric, Kind::text},
    {kNumberOfFrames, Kind::text},
    {kRows, Kind::u16},
    {kColumns, Kind::u16},
    {kPixelSpacing, Kind::text},
    {kPixelAspectRatio, Kind::text},
    {kBitsAllocated, Kind::u16},
    {kBitsStored, Kind::u16},
    {kHighBit, Kind::u16},
    {kPixelRepresentation, Kind::u16},
    {kPixelPadding, Kind::u16},
    {kPixelPaddingLimit, Kind::u16},
    {kFloatPadding, Kind::f32},
    {kDoublePadding, Kind::f64},
    {kFloatPaddingLimit, Kind::f32},
    {kDoublePaddingLimit, Kind::f64},
    {kRescaleIntercept, Kind::text},
    {kRescaleSlope, Kind::text},
    {kRescaleType, Kind::text},
    {kModalityLut, Kind::sequence},
    {kPixelMeasuresSequence, Kind::sequence},
    {kPixelValueTransformation, Kind::sequence},
    {kMeasurementUnits, Kind::sequence},
    {kRealWorldMapping, Kind::sequence},
    {kMappingLabel, Kind::text},
    {kMappedLast, Kind::u16},
    {kMappingTable, Kind::f64},
    {kMappedLastDouble, Kind::f64},
    {kMappedFirstDouble, Kind::f64},
    {kMappedFirst, Kind::u16},
    {kMappingIntercept, Kind::f64},
    {kMappingSlope, Kind::f64},
    {kTotalMatrixColumns, Kind::u32},
    {kTotalMatrixRows, Kind::u32},
    {kOpticalPaths, Kind::u32},
    {kFocalPlanes, Kind::u32},
    {kEnergyWindowVector, Kind::u16},
    {kDetectorVector, Kind::u16},
    {kDetectorInformation, Kind::sequence},
    {kRrIntervalVector, Kind::u16},
    {kTimeSlotVector, Kind::u16},
    {kSliceVector, Kind::u16},
    {kTimeSliceVector, Kind::u16},
    {kFrameReferenceTime, Kind::text},
    {kSegmentationType, Kind::text},
    {kSegments, Kind::sequence},
    {kSegmentNumber, Kind::u16},
    {kSegmentLabel, Kind::text},
    {kSegmentIdentification, Kind::sequence},
    {kReferencedSegment, Kind::u16},
    {kSegmentColour, Kind::u16},
    {kMaximumFraction, Kind::u16},
    {kPropertyType, Kind::sequence},
    {kFractionType, Kind::text},
    {kPropertyModifier, Kind::sequence},
    {kGridFrameOffsets, Kind::text},
    {kDoseGridScaling, Kind::text},
    {kSharedGroups, Kind::sequence},
    {kPerFrameGroups, Kind::sequence},
};

struct PrivateTag {
  std::string_view creator;
  KnownTag known;
};

constexpr PrivateTag kPrivateTags[] = {
    {"SIEMENS MR HEADER", {kMosaicImages, Kind::u16}},
    {"SIEMENS CSA HEADER", {kSiemensImage, Kind::text}},
};

constexpr bool before(const KnownTag& known, Tag tag) {
  return known.tag < tag;
}

static_assert(std::is_sorted(std::begin(kKnownTags), std::end(kKnownTags),
                             [](const KnownTag& a, const KnownTag& b) { return a.tag < b.tag; }));

}  // namespace

std::string name_of(Tag tag) {
  return fmt::format("({:04x},{:04x})", tag >> 16, tag & 0xffff);
}

const KnownTag* find_known_tag(Tag tag) {
  const auto* found = std::lower_bound(std::begin(kKnownTags), std::end(kKnownTags), tag, before);
  return found != std::end(kKnownTags) && found->tag == tag ? found : nullptr;
}

const KnownTag* find_private_tag(std::string_view creator, Tag tag) {
  constexpr Tag kBlock = 0x0000ff00;
  for (const PrivateTag& candidate : kPrivateTags) {
    if (candidate.creator == creator && (candidate.known.tag & ~kBlock) == (tag & ~kBlock)) {
      return &candidate.known;
    }
  }
  return nullptr;
}

}  // namespace isosplat::import::dicom
