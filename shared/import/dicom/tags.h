#pragma once

#include <cstdint>
#include <string>
#include <string_view>

// The DICOM elements that the importer reads (PS3.6, Registry of DICOM Data Elements): group in the
// high 16 bits, element in the low 16 bits. Elements that tags.cpp does not list are skipped.
namespace isosplat::import::dicom {

using Tag = uint32_t;

/// The representation of an element's value if the file does not state its VR (PS3.5, 6.2).
enum class Kind : uint8_t { text, u16, i16, u32, i32, f32, f64, sequence };

inline constexpr Tag kMediaSopClass = 0x00020002;
inline constexpr Tag kTransferSyntax = 0x00020010;
inline constexpr Tag kImageType = 0x00080008;
inline constexpr Tag kSopClass = 0x00080016;
inline constexpr Tag kSopInstance = 0x00080018;
inline constexpr Tag kSeriesDate = 0x00080021;
inline constexpr Tag kAcquisitionDate = 0x00080022;
inline constexpr Tag kContentDate = 0x00080023;
inline constexpr Tag kAcquisitionDateTime = 0x0008002a;
inline constexpr Tag kAcquisitionTime = 0x00080032;
inline constexpr Tag kContentTime = 0x00080033;
inline constexpr Tag kModality = 0x00080060;
inline constexpr Tag kCodeValue = 0x00080100;
inline constexpr Tag kCodeMeaning = 0x00080104;
inline constexpr Tag kSeriesDescription = 0x0008103e;
inline constexpr Tag kFrameType = 0x00089007;
inline constexpr Tag kSliceThickness = 0x00180050;
inline constexpr Tag kEchoTime = 0x00180081;
inline constexpr Tag kInversionTime = 0x00180082;
inline constexpr Tag kEchoNumber = 0x00180086;
inline constexpr Tag kSpacingBetweenSlices = 0x00180088;
inline constexpr Tag kTriggerTime = 0x00181060;
inline constexpr Tag kFrameTime = 0x00181063;
inline constexpr Tag kFrameTimeVector = 0x00181065;
inline constexpr Tag kImagerPixelSpacing = 0x00181164;
inline constexpr Tag kSliceLocationVector = 0x00182005;
inline constexpr Tag kNominalScannedPixelSpacing = 0x00182010;
inline constexpr Tag kUltrasoundRegions = 0x00186011;
inline constexpr Tag kPhysicalUnitsX = 0x00186024;
inline constexpr Tag kPhysicalUnitsY = 0x00186026;
inline constexpr Tag kPhysicalDeltaX = 0x0018602c;
inline constexpr Tag kPhysicalDeltaY = 0x0018602e;
inline constexpr Tag kFrameAcquisitionDateTime = 0x00189074;
inline constexpr Tag kDiffusionGradientSequence = 0x00189076;
inline constexpr Tag kEffectiveEchoTime = 0x00189082;
inline constexpr Tag kDiffusionBValue = 0x00189087;
inline constexpr Tag kDiffusionGradient = 0x00189089;
inline constexpr Tag kMrEchoSequence = 0x00189114;
inline constexpr Tag kMrDiffusionSequence = 0x00189117;
inline constexpr Tag kCardiacSequence = 0x00189118;
inline constexpr Tag kMrFrameTypeSequence = 0x00189226;
inline constexpr Tag kCtFrameTypeSequence = 0x00189329;
inline constexpr Tag kPetFrameTypeSequence = 0x00189751;
inline constexpr Tag kStudyInstance = 0x0020000d;
inline constexpr Tag kSeriesInstance = 0x0020000e;
inline constexpr Tag kAcquisitionNumber = 0x00200012;
inline constexpr Tag kInstanceNumber = 0x00200013;
inline constexpr Tag kPatientOrientation = 0x00200020;
inline constexpr Tag kImagePosition = 0x00200032;
inline constexpr Tag kImageOrientation = 0x00200037;
inline constexpr Tag kFrameOfReference = 0x00200052;
inline constexpr Tag kTemporalPosition = 0x00200100;
inline constexpr Tag kSliceLocation = 0x00201041;
inline constexpr Tag kStackId = 0x00209056;
inline constexpr Tag kFrameContentSequence = 0x00209111;
inline constexpr Tag kPlanePositionSequence = 0x00209113;
inline constexpr Tag kPlaneOrientationSequence = 0x00209116;
inline constexpr Tag kTemporalPositionIndex = 0x00209128;
inline constexpr Tag kTriggerDelay = 0x00209153;
inline constexpr Tag kDimensionIndexValues = 0x00209157;
inline constexpr Tag kConcatenation = 0x00209161;
inline constexpr Tag kConcatenationNumber = 0x00209162;
inline constexpr Tag kConcatenationTotal = 0x00209163;
inline constexpr Tag kVolumePosition = 0x00209301;
inline constexpr Tag kVolumeOrientation = 0x00209302;
inline constexpr Tag kPlanePositionVolumeSequence = 0x0020930e;
inline constexpr Tag kPlaneOrientationVolumeSequence = 0x0020930f;
inline constexpr Tag kDimensionOrganization = 0x00209311;
inline constexpr Tag kSamplesPerPixel = 0x00280002;
inline constexpr Tag kPhotometric = 0x00280004;
inline constexpr Tag kNumberOfFrames = 0x00280008;
inline constexpr Tag kRows = 0x00280010;
inline constexpr Tag kColumns = 0x00280011;
inline constexpr Tag kPixelSpacing = 0x00280030;
inline constexpr Tag kPixelAspectRatio = 0x00280034;
inline constexpr Tag kBitsAllocated = 0x00280100;
inline constexpr Tag kBitsStored = 0x00280101;
inline constexpr Tag kHighBit = 0x00280102;
inline constexpr Tag kPixelRepresentation = 0x00280103;
inline constexpr Tag kPixelPadding = 0x00280120;
inline constexpr Tag kPixelPaddingLimit = 0x00280121;
inline constexpr Tag kFloatPadding = 0x00280122;
inline constexpr Tag kDoublePadding = 0x00280123;
inline constexpr Tag kFloatPaddingLimit = 0x00280124;
inline constexpr Tag kDoublePaddingLimit = 0x00280125;
inline constexpr Tag kRescaleIntercept = 0x00281052;
inline constexpr Tag kRescaleSlope = 0x00281053;
inline constexpr Tag kRescaleType = 0x00281054;
inline constexpr Tag kModalityLut = 0x00283000;
inline constexpr Tag kPixelMeasuresSequence = 0x00289110;
inline constexpr Tag kPixelValueTransformation = 0x00289145;
inline constexpr Tag kMeasurementUnits = 0x004008ea;
inline constexpr Tag kRealWorldMapping = 0x00409096;
inline constexpr Tag kMappingLabel = 0x00409210;
inline constexpr Tag kMappedLast = 0x00409211;
inline constexpr Tag kMappingTable = 0x00409212;
inline constexpr Tag kMappedLastDouble = 0x00409213;
inline constexpr Tag kMappedFirstDouble = 0x00409214;
inline constexpr Tag kMappedFirst = 0x00409216;
inline constexpr Tag kMappingIntercept = 0x00409224;
inline constexpr Tag kMappingSlope = 0x00409225;
inline constexpr Tag kTotalMatrixColumns = 0x00480006;
inline constexpr Tag kTotalMatrixRows = 0x00480007;
inline constexpr Tag kOpticalPaths = 0x00480302;
inline constexpr Tag kFocalPlanes = 0x00480303;
inline constexpr Tag kEnergyWindowVector = 0x00540010;
inline constexpr Tag kDetectorVector = 0x00540020;
inline constexpr Tag kDetectorInformation = 0x00540022;
inline constexpr Tag kRrIntervalVector = 0x00540060;
inline constexpr Tag kTimeSlotVector = 0x00540070;
inline constexpr Tag kSliceVector = 0x00540080;
inline constexpr Tag kTimeSliceVector = 0x00540100;
inline constexpr Tag kFrameReferenceTime = 0x00541300;
inline constexpr Tag kSegmentationType = 0x00620001;
inline constexpr Tag kSegments = 0x00620002;
inline constexpr Tag kSegmentNumber = 0x00620004;
inline constexpr Tag kSegmentLabel = 0x00620005;
inline constexpr Tag kSegmentIdentification = 0x0062000a;
inline constexpr Tag kReferencedSegment = 0x0062000b;
inline constexpr Tag kSegmentColour = 0x0062000d;  ///< Recommended Display CIELab Value
inline constexpr Tag kMaximumFraction = 0x0062000e;
inline constexpr Tag kPropertyType = 0x0062000f;
inline constexpr Tag kFractionType = 0x00620010;
inline constexpr Tag kPropertyModifier = 0x00620011;
inline constexpr Tag kGridFrameOffsets = 0x3004000c;
inline constexpr Tag kDoseGridScaling = 0x3004000e;
inline constexpr Tag kSharedGroups = 0x52009229;
inline constexpr Tag kPerFrameGroups = 0x52009230;
inline constexpr Tag kFloatPixels = 0x7fe00008;
inline constexpr Tag kDoublePixels = 0x7fe00009;
inline constexpr Tag kPixels = 0x7fe00010;

/// Private elements that the importer reads (PS3.5, 7.8). Files may use any block for private
/// elements; these are the tags in block 10.
inline constexpr Tag kMosaicImages = 0x0019100a;  ///< SIEMENS MR HEADER: number of slices
inline constexpr Tag kSiemensImage = 0x00291010;  ///< SIEMENS CSA HEADER: CSA Image Header Info

/// "(gggg,eeee)", in hexadecimal digits.
std::string name_of(Tag tag);

struct KnownTag {
  Tag tag;
  Kind kind;
};

/// The representation of the element `tag`; null for an element that the importer does not read.
const KnownTag* find_known_tag(Tag tag);

/// The representation of a private element, and its tag in block 10. `creator`: the text of the
/// element that reserves the block. Null for an element that the importer does not read.
const KnownTag* find_private_tag(std::string_view creator, Tag tag);

}  // namespace isosplat::import::dicom
