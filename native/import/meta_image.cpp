#include <fmt/format.h>

#include <map>

#include "native/import/array_source.h"
#include "native/import/data_files.h"
#include "native/import/formats.h"
#include "native/import/header_text.h"

// MetaImage (.mha with the voxels in the file, .mhd with the voxels beside it). ITK reads geometry
// and type; where the voxels are is read here, so that they can be streamed.
namespace isosplat {
namespace {

struct MetaHeader {
  std::map<std::string, std::string> fields;
  uint64_t data_offset = 0;

  std::string field(const char* name) const {
    const auto found = fields.find(name);
    return found == fields.end() ? std::string() : found->second;
  }
  bool is_true(const char* name) const {
    const std::string value = lower_case(field(name));
    return value == "true" || value == "1" || value == "t";
  }
};

Result<MetaHeader> read_header(const std::filesystem::path& path) {
  auto text = read_beginning(path);
  if (!text) return tl::unexpected(text.error());
  MetaHeader header;
  std::string_view rest = *text;
  while (!rest.empty()) {
    auto line = take_line(rest);
    if (!line) {  // the last line of an .mhd may lack its end
      line = rest;
      rest = {};
    }
    const size_t equals = line->find('=');
    if (equals == line->npos) {
      if (trimmed(*line).empty()) continue;
      break;
    }
    const std::string name(trimmed(line->substr(0, equals)));
    header.fields[name] = std::string(trimmed(line->substr(equals + 1)));
    if (name == "ElementDataFile") {
      header.data_offset = text->size() - rest.size();
      return header;
    }
  }
  return fail(Status::malformed_volume,
              fmt::format("{}: expected a line 'ElementDataFile = …', found none: the MetaImage "
                          "header is damaged; export the volume again",
                          path.string()));
}

}  // namespace

Result<OpenVolume> open_meta_image(const std::filesystem::path& path,
                                   const ImportOptions& options) {
  const auto header = read_header(path);
  if (!header) return tl::unexpected(header.error());
  const std::string data_name = header->field("ElementDataFile");
  const std::string lower_name = lower_case(data_name);
  const bool local = lower_name == "local";
  const bool several_files =
      lower_name.starts_with("list") || data_name.find('%') != data_name.npos;
  std::filesystem::path data = path;
  if (!local && !several_files) {
    data = std::filesystem::path(data_name);
    if (data.is_relative()) data = path.parent_path() / data;
    std::error_code error;
    if (!std::filesystem::exists(data, error)) {
      return fail(Status::io_error,
                  fmt::format("{}: the data file that it names is missing: expected {}: put it "
                              "there, or correct ElementDataFile in the header",
                              path.string(), data.string()));
    }
  }

  const auto itk_header = read_itk_header(ItkFormat::meta_image, path);
  if (!itk_header) return tl::unexpected(itk_header.error());
  const ItkHeader& info = *itk_header;
  const std::string binary = header->field("BinaryData");
  const bool text = !binary.empty() && !header->is_true("BinaryData");
  if (several_files || text) {
    std::vector<std::filesystem::path> data_files;
    if (several_files) data_files = named_data_files(path, data_name);
    if (!several_files && !local) data_files = {data};
    return open_whole(ItkFormat::meta_image, info, "MetaImage", path, options,
                      std::move(data_files));
  }
  auto array = make_array("MetaImage", path, info, header->field("ElementType"), options);
  if (!array) return tl::unexpected(array.error());
  array->stored.big_endian =
      header->is_true("BinaryDataByteOrderMSB") || header->is_true("ElementByteOrderMSB");
  const bool deflated = header->is_true("CompressedData");
  array->plain = !deflated;
  const uint64_t start = local ? header->data_offset : 0;
  auto bytes = deflated ? open_deflated(data, start) : open_plain(data);
  if (!bytes) return tl::unexpected(bytes.error());
  const int64_t skip = whole_number(header->field("HeaderSize")).value_or(0);
  if (!deflated) {
    array->offset = start;
    if (skip > 0) array->offset = static_cast<uint64_t>(skip);
    if (skip == -1) {
      array->offset = offset_from_end((*bytes)->size_limit(), info.sizes, stored_bytes(info.type));
    }
  }
  return open_array(std::move(*array), std::move(*bytes));
}

}  // namespace isosplat
