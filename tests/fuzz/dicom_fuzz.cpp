// DICOM files: their elements, their frames and the order of these, and their pixels. Pixels are
// uncompressed, or decompressed as in browsers: GDCM, which runs in a child process, is not tested
// here.
//
// If the first byte of the input is 128 or more, the rest is a file. Otherwise the byte is the
// number of a valid file, and the rest are edits of it.
#include <sys/mman.h>
#include <unistd.h>

#include <numeric>

#include "shared/import/dicom/codec.h"
#include "shared/import/dicom/order.h"
#include "shared/import/dicom/pixels.h"
#include "shared/import/dicom/segment_maps.h"
#include "shared/import/dicom/segments.h"
#include "tests/fuzz/edits.h"
#include "tests/native/dicom_siemens.h"
#include "tests/native/segment_boxes.h"

namespace isosplat::import {
namespace {

std::vector<std::string> make_files() {
  test::BallSeries series;
  series.size = {4, 3, 3};
  test::DicomItem nuclear = series.common();
  nuclear[0x00080008] = test::dicom_text("CS", "ORIGINAL\\PRIMARY\\RECON TOMO");
  nuclear[0x00080060] = test::dicom_text("CS", "NM");
  nuclear[0x00180088] = test::dicom_text("DS", "-2");
  nuclear[0x00280008] = test::dicom_text("IS", "3");
  nuclear[0x00540022] = test::dicom_sequence(
      {{{0x00200032, series.position_value(0)}, {0x00200037, series.orientation_value()}}});
  nuclear[0x00540080] = test::dicom_numbers("US", std::vector<uint16_t>{2, 1, 3});
  test::DicomItem dose = series.slice(0);
  dose[0x00280008] = test::dicom_text("IS", "3");
  dose[0x3004000c] = test::dicom_text("DS", "0\\2\\4");
  dose[0x3004000e] = test::dicom_text("DS", "0.5");
  const auto pixels = test::dicom_numbers("OW", std::vector<uint16_t>(36, 7));
  nuclear[0x7fe00010] = dose[0x7fe00010] = pixels;
  test::DicomItem encapsulated = series.enhanced({0, 1, 2});
  encapsulated[0x7fe00010] =
      test::dicom_fragments({"first", "second", "third", "fourth"}, {0, 14, 28});
  test::DicomItem segments = series.enhanced({2, 0, 1, 2});
  segments[0x00280100] = segments[0x00280101] = test::dicom_u16(1);
  segments[0x00280102] = test::dicom_u16(0);
  segments[0x00620001] = test::dicom_text("CS", "BINARY");
  segments[0x7fe00010] = test::dicom_bits(std::vector<uint8_t>(48, 1));
  for (int i = 0; i < 4; ++i) {
    segments[0x52009230].items[static_cast<size_t>(i)][0x0062000a] =
        test::dicom_sequence({{{0x0062000b, test::dicom_u16(i < 2 ? 1 : 2)}}});
  }
  test::SegmentBoxes boxes;
  boxes.size = {4, 3, 3};
  boxes.boxes = {{1, "a", {0, 0, 0}, {2, 2, 1}, "A", "Left", {65535, 1, 2}},
                 {2, "b", {1, 1, 0}, {3, 2, 2}}};
  test::DicomItem overlapping = boxes.data();
  test::DicomItem mosaic = series.slice(0);
  mosaic[0x00080008] = test::dicom_text("CS", "ORIGINAL\\PRIMARY\\M\\MOSAIC");
  test::add_csa(mosaic, test::csa_of_mosaic(3, {0, 0, 1}, true));
  mosaic[0x00280010] = test::dicom_u16(6);
  mosaic[0x00280011] = test::dicom_u16(8);
  mosaic[0x7fe00010] = test::dicom_numbers("OW", std::vector<uint16_t>(48, 7));
  std::vector<std::string> files;
  for (test::DicomSyntax syntax : {test::DicomSyntax{}, test::implicit_little(),
                                   test::explicit_big(), test::deflated_little()}) {
    for (const bool undefined : {false, true}) {
      syntax.undefined_lengths = undefined;
      const test::DicomWriter writer(syntax);
      for (const auto& data : {series.enhanced({2, 0, 1}), nuclear, dose, series.slice(1), segments,
                               overlapping, mosaic}) {
        files.push_back(writer.file(data));
      }
    }
  }
  test::DicomSyntax compressed;
  compressed.uid = "1.2.840.10008.1.2.4.70";
  files.push_back(test::DicomWriter(compressed).file(encapsulated));
  std::vector<uint32_t> head(16);
  head[0] = 2;
  head[1] = 64;
  head[2] = 66;
  const std::string run_lengths = test::bytes_of(head) + "\xf5\x01\xf5\x02";
  encapsulated[0x7fe00010] = test::dicom_fragments({run_lengths, run_lengths, run_lengths});
  compressed.uid = "1.2.840.10008.1.2.5";
  files.push_back(test::DicomWriter(compressed).file(encapsulated));
  return files;
}

/// Reads all segments of a segmentation, unless a child process would decompress them.
void read_segment_maps(const dicom::Collection& collection, const dicom::Stack& stack,
                       const std::filesystem::path& path, const ImportOptions& options) {
  const dicom::Image& image = collection.images[0];
  if (image.segmentation.kind == dicom::Segmentation::Kind::none || image.is_encapsulated) return;
  if (int64_t{image.columns} * image.rows > 1 << 16) return;
  auto maps = dicom::map_segments(collection, stack, path, options, {});
  if (!maps) return;
  for (SegmentMap& map : *maps) {
    const VolumeHeader& header = map.volume.source->header();
    const Index3 n = header.grid.voxels;
    std::vector<std::byte> out(static_cast<size_t>(n.x) * static_cast<size_t>(n.y) *
                               voxel_bytes(header.type));
    for (int32_t z = 0; z < std::min(n.z, 64); ++z) {
      static_cast<void>(map.volume.source->read_slices(z, 1, out));
    }
  }
}

void read_file(const std::filesystem::path& path) {
  const auto elements = dicom::read_elements(path);
  if (!elements) return;
  dicom::Collection collection;
  const auto content = dicom::add_frames(*elements, path, collection);
  if (!content || *content != dicom::FileContent::frames) return;
  ImportOptions options;
  for (const AllowanceFlag& allowance : kAllowances) options.allowed.add(allowance.allowance);
  std::vector<std::string> notes;
  auto chosen = dicom::choose_stack(collection, path, options, notes);
  if (!chosen) return;
  options.segment =
      collection.images[0].segmentation.kind == dicom::Segmentation::Kind::none ? "" : "1";
  read_segment_maps(collection, *chosen, path, options);
  const auto stack = dicom::choose_segment(collection, std::move(*chosen), path, options, notes);
  if (!stack) return;
  const auto arranged = dicom::arrange(collection, *stack, path, options, notes);
  if (!arranged) return;
  std::vector<std::byte> out;
  for (const dicom::Plane& plane : arranged->planes) {
    const dicom::Frame& frame = collection.frames[plane.first];
    const dicom::Image& image = collection.images[frame.image];
    if (!image.obstacle.empty()) return;
    const uint64_t pixels =
        static_cast<uint64_t>(image.columns) * static_cast<uint64_t>(image.rows);
    if (pixels > 1 << 20) return;
    if (image.is_encapsulated) {
      const dicom::EncodedFrame encoded{&image, frame.index};
      std::vector<bool> absent;
      out.resize(static_cast<size_t>(dicom::stored_frame_bytes(image)));
      static_cast<void>(dicom::decompress_plainly({&encoded, 1}, true, out, absent));
      continue;
    }
    if (dicom::stored_frame_bytes(image) > 1 << 22) return;
    const dicom::FramePixels one{&image,      frame.index,     frame.tile,
                                 frame.slope, frame.intercept, stack->label};
    out.resize(static_cast<size_t>(8 * pixels));
    static_cast<void>(dicom::read_frames({&one, 1}, VoxelType::f64, true, 1 << 30, out));
  }
}

}  // namespace
}  // namespace isosplat::import

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace isosplat;
  using namespace isosplat::import;
  static const std::vector<std::string> files = make_files();
  static const int memory = memfd_create("dicom", 0);
  static const std::filesystem::path path = fmt::format("/proc/self/fd/{}", memory);
  fuzz::Input input(data, size);
  const uint32_t which = input.number(1);
  std::string file;
  if (which >= 128) {
    const auto rest = input.rest();
    file.assign(reinterpret_cast<const char*>(rest.data()), rest.size());
  } else {
    file = files[which % files.size()];
    if (which & 64) file.resize(input.number(2) % file.size());
    edit(std::as_writable_bytes(std::span(file)), input);
  }
  if (ftruncate(memory, 0) != 0) return 0;
  if (pwrite(memory, file.data(), file.size(), 0) != static_cast<ssize_t>(file.size())) return 0;
  read_file(path);
  return 0;
}
