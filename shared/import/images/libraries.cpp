#include <cstdio>  // jpeglib.h needs it
//
#include <fmt/format.h>
#include <jpeglib.h>
#include <openjpeg.h>

#include <algorithm>
#include <csetjmp>
#include <cstring>

#include "shared/import/codecs/isolated.h"
#include "shared/import/images/file.h"

namespace isosplat::import {
namespace {

struct JpegErrors {
  jpeg_error_mgr base;
  std::jmp_buf jump;
};

/// For truncated or damaged data, libjpeg only warns, and continues with grey.
bool decode_jpeg(std::span<const uint8_t> file, const ImageInfo& info, std::span<std::byte> out) {
  jpeg_decompress_struct jpeg{};
  JpegErrors errors{};
  jpeg.err = jpeg_std_error(&errors.base);
  errors.base.error_exit = [](j_common_ptr common) {
    std::longjmp(reinterpret_cast<JpegErrors*>(common->err)->jump, 1);
  };
  errors.base.emit_message = [](j_common_ptr common, int level) {
    if (level < 0) std::longjmp(reinterpret_cast<JpegErrors*>(common->err)->jump, 1);
  };
  if (setjmp(errors.jump) != 0) {
    jpeg_destroy_decompress(&jpeg);
    return false;
  }
  jpeg_create_decompress(&jpeg);
  jpeg_mem_src(&jpeg, file.data(), file.size());
  jpeg_read_header(&jpeg, TRUE);
  jpeg.dct_method = JDCT_ISLOW;
  jpeg_start_decompress(&jpeg);
  const auto width = static_cast<size_t>(info.width);
  bool fits = jpeg.output_width == width && jpeg.output_height == info.height &&
              jpeg.output_components == 1 && out.size() == width * jpeg.output_height;
  while (fits && jpeg.output_scanline < jpeg.output_height) {
    auto* row = reinterpret_cast<JSAMPROW>(out.data() + jpeg.output_scanline * width);
    fits = jpeg_read_scanlines(&jpeg, &row, 1) == 1;
  }
  if (fits) jpeg_finish_decompress(&jpeg);
  jpeg_destroy_decompress(&jpeg);
  return fits;
}

/// The input of OpenJPEG: bytes in memory.
struct Input {
  std::span<const uint8_t> file;
  size_t at = 0;
};

opj_stream_t* stream_of(Input& input) {
  opj_stream_t* stream = opj_stream_default_create(OPJ_TRUE);
  opj_stream_set_user_data(stream, &input, nullptr);
  opj_stream_set_user_data_length(stream, input.file.size());
  opj_stream_set_read_function(stream, [](void* to, OPJ_SIZE_T count, void* data) -> OPJ_SIZE_T {
    auto& from = *static_cast<Input*>(data);
    const size_t some = std::min<size_t>(count, from.file.size() - from.at);
    if (some == 0) return static_cast<OPJ_SIZE_T>(-1);
    std::memcpy(to, from.file.data() + from.at, some);
    from.at += some;
    return some;
  });
  opj_stream_set_skip_function(stream, [](OPJ_OFF_T count, void* data) -> OPJ_OFF_T {
    auto& from = *static_cast<Input*>(data);
    const auto left = static_cast<OPJ_OFF_T>(from.file.size() - from.at);
    const OPJ_OFF_T some = std::clamp<OPJ_OFF_T>(count, 0, left);
    from.at += static_cast<size_t>(some);
    return some;
  });
  opj_stream_set_seek_function(stream, [](OPJ_OFF_T to, void* data) -> OPJ_BOOL {
    auto& from = *static_cast<Input*>(data);
    if (to < 0 || static_cast<size_t>(to) > from.file.size()) return OPJ_FALSE;
    from.at = static_cast<size_t>(to);
    return OPJ_TRUE;
  });
  return stream;
}

bool decode_jpeg2000(std::span<const uint8_t> file, const ImageInfo& info,
                     std::span<std::byte> out) {
  Input input{file};
  const bool is_bare = file[0] == 0xff;
  opj_codec_t* codec = opj_create_decompress(is_bare ? OPJ_CODEC_J2K : OPJ_CODEC_JP2);
  opj_stream_t* stream = stream_of(input);
  opj_dparameters_t parameters;
  opj_set_default_decoder_parameters(&parameters);
  opj_image_t* image = nullptr;
  bool fine = opj_setup_decoder(codec, &parameters) &&
              opj_decoder_set_strict_mode(codec, OPJ_TRUE) &&
              opj_read_header(stream, codec, &image) && opj_decode(codec, stream, image) &&
              opj_end_decompress(codec, stream) && image->numcomps == 1;
  if (fine) {
    const opj_image_comp_t& samples = image->comps[0];
    const size_t count = size_t{samples.w} * samples.h;
    const size_t bytes = voxel_bytes(info.type());
    fine = samples.w == info.width && samples.h == info.height && samples.data &&
           out.size() == count * bytes;
    for (size_t i = 0; fine && i < count; ++i) {
      const auto sample = static_cast<uint32_t>(samples.data[i]);  // little-endian
      std::memcpy(out.data() + i * bytes, &sample, bytes);
    }
  }
  if (image) opj_image_destroy(image);
  opj_stream_destroy(stream);
  opj_destroy_codec(codec);
  return fine;
}

}  // namespace

Result<void> decode_with_library(const std::filesystem::path& path, std::span<const uint8_t> file,
                                 const ImageInfo& info, uint64_t memory_bytes,
                                 std::span<std::byte> out) {
  auto shared = SharedBytes::allocate(out.size());
  if (!shared) return tl::unexpected(shared.error());
  const auto decoded = run_isolated(path, memory_bytes, [&]() -> Result<std::string> {
    const bool fine = info.format == "JPEG" ? decode_jpeg(file, info, shared->bytes())
                                            : decode_jpeg2000(file, info, shared->bytes());
    if (!fine) return damaged_image(path);
    return std::string();
  });
  if (!decoded) return tl::unexpected(decoded.error());
  std::ranges::copy(shared->bytes(), out.begin());
  return {};
}

}  // namespace isosplat::import
