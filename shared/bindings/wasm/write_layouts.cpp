// Generates what JavaScript needs to read and write the records of records.h, and the limits:
//
//     write_layouts layouts.js layouts.d.ts
//
// layouts.js has xBytes for each record X, readX for those that C++ fills, writeX for those that
// JavaScript fills, and xOffsets for those whose arrays are copied as a whole. layouts.d.ts has the
// types; web/core/generated.d.ts is a copy. Both also have the names of some enumerations' values.
// The build runs this program as WebAssembly, so that the offsets are those of the modules.
#include <algorithm>
#include <cctype>
#include <cstdio>
#include <string>
#include <type_traits>
#include <vector>

#include "shared/bindings/wasm/core_api.h"
#include "shared/core/grid/region_mask.h"
#include "shared/core/include/isosplat/store.h"
#include "shared/core/sampling/packed_sample.h"
#include "shared/render/settings/colour_maps.h"
#include "shared/render/settings/render_settings.h"

namespace {

using namespace isosplat;
using namespace isosplat::render;

struct Field {
  const char* name;
  const char* type;  ///< as DataView names it: Float64, Uint32, …
  size_t offset;
  size_t bytes;  ///< of one element
  size_t count;  ///< of elements; 0: no array
};

enum class Filled {
  by_cpp,
  by_javascript,
  by_both,
  in_bulk,  ///< arrays of these records are copied as a whole
};

struct Record {
  const char* name;
  size_t bytes;
  Filled filled;
  std::vector<Field> fields;
};

template <class T>
constexpr const char* type_name() {
  if constexpr (std::is_same_v<T, double>) return "Float64";
  if constexpr (std::is_same_v<T, float>) return "Float32";
  if constexpr (std::is_same_v<T, int32_t>) return "Int32";
  if constexpr (std::is_same_v<T, uint32_t>) return "Uint32";
  if constexpr (std::is_same_v<T, uint8_t>) return "Uint8";
}

template <class T>
Field field(const char* name, size_t offset) {
  using Element = std::remove_extent_t<T>;
  return {name, type_name<Element>(), offset, sizeof(Element), std::extent_v<T>};
}

#define FIELD(member) field<decltype(R::member)>(#member, offsetof(R, member))
#define RECORD(name, filled, ...)                                   \
  [] {                                                              \
    using R = Isosplat##name;                                       \
    static_assert(std::is_standard_layout_v<R>);                    \
    return Record{#name, sizeof(R), Filled::filled, {__VA_ARGS__}}; \
  }()

std::vector<Record> all_records() {
  return {
      RECORD(Chunk, by_cpp, FIELD(offset), FIELD(handle), FIELD(level), FIELD(block), FIELD(band),
             FIELD(band_begin), FIELD(band_end), FIELD(bytes), FIELD(cells), FIELD(checksum),
             FIELD(block_cells)),
      RECORD(ChunkShape, by_javascript, FIELD(block_cells), FIELD(band_begin), FIELD(band_end),
             FIELD(cells), FIELD(level), FIELD(block)),
      RECORD(Block, by_javascript, FIELD(level), FIELD(block)),
      RECORD(Page, by_cpp, FIELD(offset), FIELD(bytes), FIELD(level), FIELD(first_block),
             FIELD(resident), FIELD(interval_min), FIELD(interval_max)),
      RECORD(StoreInfo, by_cpp, FIELD(spacing), FIELD(origin), FIELD(direction),
             FIELD(value_offset), FIELD(value_scale), FIELD(max_error), FIELD(chunk_count),
             FIELD(missing_voxels), FIELD(file_bytes), FIELD(voxels), FIELD(bits),
             FIELD(has_missing), FIELD(min_quantized), FIELD(max_quantized), FIELD(levels),
             FIELD(content_id)),
      RECORD(CoarseRange, by_cpp, FIELD(first_level), FIELD(offset), FIELD(bytes)),
      RECORD(SelectionView, by_javascript, FIELD(view_projection), FIELD(width_px),
             FIELD(height_px), FIELD(load_cell_px), FIELD(draw_cell_px), FIELD(cell_budget),
             FIELD(ahead), FIELD(occlusion)),
      RECORD(SelectionHeader, by_cpp, FIELD(finest_level), FIELD(coarsest_level),
             FIELD(limited_by_budget), FIELD(undecided)),
      RECORD(DrawnChunk, in_bulk, FIELD(handle), FIELD(regions)),
      RECORD(Visibility, in_bulk, FIELD(handle), FIELD(tested), FIELD(visible)),
      RECORD(Volume, by_javascript, FIELD(voxels), FIELD(spacing), FIELD(origin), FIELD(direction),
             FIELD(value_offset), FIELD(value_scale)),
      RECORD(Isosurface, by_javascript, FIELD(isovalue), FIELD(colour), FIELD(opacity)),
      RECORD(Appearance, by_javascript, FIELD(colour_low), FIELD(colour_high), FIELD(colour_by),
             FIELD(colour_map), FIELD(background), FIELD(eye_dome), FIELD(reserved)),
      RECORD(Light, by_javascript, FIELD(azimuth), FIELD(elevation), FIELD(key), FIELD(sky),
             FIELD(rim), FIELD(highlight), FIELD(roughness), FIELD(occlusion),
             FIELD(occlusion_radius), FIELD(shadow), FIELD(shadow_softness)),
      RECORD(ClipBox, by_javascript, FIELD(low), FIELD(high), FIELD(caps)),
      RECORD(Plane, by_javascript, FIELD(normal), FIELD(offset)),
      RECORD(Camera, by_both, FIELD(target), FIELD(distance), FIELD(azimuth), FIELD(elevation),
             FIELD(roll), FIELD(field_of_view), FIELD(orthographic)),
      RECORD(Pick, by_cpp, FIELD(position), FIELD(voxel), FIELD(normal), FIELD(gradient),
             FIELD(to_next), FIELD(value), FIELD(isosurface), FIELD(level), FIELD(found),
             FIELD(face)),
      RECORD(Projection, by_cpp, FIELD(clip_from_world)),
      RECORD(FrameStatistics, by_cpp, FIELD(samples_drawn), FIELD(samples_resident),
             FIELD(gpu_bytes), FIELD(chunks_drawn), FIELD(chunks_culled), FIELD(draw_calls),
             FIELD(programs_linked)),
      RECORD(OcclusionAnswer, by_cpp, FIELD(is_ready), FIELD(count)),
  };
}

struct Constant {
  const char* name;
  size_t value;
};

std::vector<Constant> all_constants() {
  return {
      {"maxHeaderBytes", kMaxHeaderBytes},
      {"maxIsosurfaces", kMaxIsosurfaces},
      {"maxClipPlanes", kMaxClipPlanes},
      {"maxSlices", kMaxSlices},
      {"colourMapColours", std::extent_v<decltype(kColourMapTable), 1>},
      {"regionWords", ISOSPLAT_REGION_WORDS},
      {"packedSampleBytes", sizeof(PackedSample)},
      {"infoRecord", ISOSPLAT_INFO_RECORD},
      {"infoMetadata", ISOSPLAT_INFO_METADATA},
      {"samplesPositions", ISOSPLAT_SAMPLES_POSITIONS},
      {"samplesValues", ISOSPLAT_SAMPLES_VALUES},
      {"samplesGradients", ISOSPLAT_SAMPLES_GRADIENTS},
      {"samplesIntervals", ISOSPLAT_SAMPLES_INTERVALS},
      {"decodedSamples", ISOSPLAT_DECODED_SAMPLES},
      {"decodedClusters", ISOSPLAT_DECODED_CLUSTERS},
      {"pointsPositions", ISOSPLAT_POINTS_POSITIONS},
      {"pointsNormals", ISOSPLAT_POINTS_NORMALS},
      {"selectionHeader", ISOSPLAT_SELECTION_HEADER},
      {"selectionLoad", ISOSPLAT_SELECTION_LOAD},
      {"selectionPages", ISOSPLAT_SELECTION_PAGES},
      {"selectionDraw", ISOSPLAT_SELECTION_DRAW},
      {"selectionTest", ISOSPLAT_SELECTION_TEST},
      {"selectionKeep", ISOSPLAT_SELECTION_KEEP},
  };
}

struct Enumeration {
  const char* name;
  std::vector<const char*> values;
};

// The compiler warns of a value that a switch does not handle, and warnings are errors.
const char* name_of(SplatKind kind) {
  switch (kind) {
    case SplatKind::quad:
      return "quad";
    case SplatKind::ellipse:
      return "ellipse";
    case SplatKind::exact:
      return "exact";
  }
  return nullptr;
}

const char* name_of(Shading shading) {
  switch (shading) {
    case Shading::smooth:
      return "smooth";
    case Shading::exact:
      return "exact";
  }
  return nullptr;
}

const char* name_of(ColourBy quantity) {
  switch (quantity) {
    case ColourBy::isosurface:
      return "isosurface";
    case ColourBy::isovalue:
      return "isovalue";
    case ColourBy::gradient:
      return "gradient";
    case ColourBy::depth:
      return "depth";
    case ColourBy::level:
      return "level";
    case ColourBy::projection_error:
      return "projection-error";
  }
  return nullptr;
}

const char* name_of(ColourMap map) {
  switch (map) {
    case ColourMap::viridis:
      return "viridis";
    case ColourMap::magma:
      return "magma";
    case ColourMap::cividis:
      return "cividis";
    case ColourMap::turbo:
      return "turbo";
  }
  return nullptr;
}

/// The names of all values, which must be 0, 1, 2, …
template <class Enum>
std::vector<const char*> names_of() {
  std::vector<const char*> names;
  for (int value = 0; const char* name = name_of(static_cast<Enum>(value)); ++value) {
    names.push_back(name);
  }
  return names;
}

std::vector<Enumeration> all_enumerations() {
  return {{"splatKindNames", names_of<SplatKind>()},
          {"shadingNames", names_of<Shading>()},
          {"colourByNames", names_of<ColourBy>()},
          {"colourMapNames", names_of<ColourMap>()}};
}

bool is_read(const Record& record) {
  return record.filled == Filled::by_cpp || record.filled == Filled::by_both;
}

bool is_written(const Record& record) {
  return record.filled == Filled::by_javascript || record.filled == Filled::by_both;
}

bool is_reserved(const Field& field) {
  return std::string(field.name) == "reserved";
}

/// A field that is missing in all_records() leaves a gap, and so does padding.
bool has_gap(const Record& record) {
  size_t end = 0;
  for (const Field& field : record.fields) {
    if (field.offset != end) return true;
    end += field.bytes * std::max<size_t>(field.count, 1);
  }
  return end != record.bytes;
}

/// view_projection → viewProjection
std::string camel_case(const std::string& snake_case) {
  std::string result;
  bool is_next_upper = false;
  for (const char c : snake_case) {
    if (c == '_') {
      is_next_upper = true;
    } else {
      result += is_next_upper ? char(std::toupper(c)) : c;
      is_next_upper = false;
    }
  }
  return result;
}

/// ChunkShape → chunkShape
std::string variable_name(const Record& record) {
  std::string result = record.name;
  result[0] = char(std::tolower(result[0]));
  return result;
}

/// The longest array of which each element has an expression of its own.
constexpr size_t kMaxUnrolled = 3;

/// data.getUint32(at + 8, true), for one element. `element`: what to add to the offset.
std::string call(const char* method, const Field& field, const std::string& element,
                 const std::string& value = "") {
  std::string result = std::string("data.") + method + field.type + "(at + " + element;
  if (!value.empty()) result += ", " + value;
  if (field.bytes > 1) result += ", true";
  return result + ")";
}

std::string offset_of(const Field& field, size_t index) {
  return std::to_string(field.offset + index * field.bytes);
}

/// The offset of element `i`, a variable of the script.
std::string offset_of_any(const Field& field) {
  return std::to_string(field.offset) + " + " + std::to_string(field.bytes) + " * i";
}

std::string read_expression(const Field& field) {
  if (field.count == 0) return call("get", field, offset_of(field, 0));
  if (field.count > kMaxUnrolled) {
    return "Array.from({ length: " + std::to_string(field.count) + " }, (_, i) => " +
           call("get", field, offset_of_any(field)) + ")";
  }
  std::string result = "[";
  for (size_t i = 0; i < field.count; ++i) {
    result += (i ? ", " : "") + call("get", field, offset_of(field, i));
  }
  return result + "]";
}

std::string write_statements(const Field& field, const std::string& value) {
  if (field.count == 0) return "  " + call("set", field, offset_of(field, 0), value) + ";\n";
  if (field.count > kMaxUnrolled) {
    return "  for (let i = 0; i < " + std::to_string(field.count) + "; ++i) " +
           call("set", field, offset_of_any(field), value + "[i]") + ";\n";
  }
  std::string result;
  for (size_t i = 0; i < field.count; ++i) {
    const std::string element = value + "[" + std::to_string(i) + "]";
    result += "  " + call("set", field, offset_of(field, i), element) + ";\n";
  }
  return result;
}

std::string javascript(const Record& record) {
  const std::string name = record.name, variable = variable_name(record);
  std::string offsets, read, write;
  for (const Field& field : record.fields) {
    if (is_reserved(field)) continue;
    const std::string key = camel_case(field.name);
    offsets += "  " + key + ": " + std::to_string(field.offset) + ",\n";
    read += "    " + key + ": " + read_expression(field) + ",\n";
    write += write_statements(field, "record." + key);
  }
  std::string text =
      "\nexport const " + variable + "Bytes = " + std::to_string(record.bytes) + ";\n";
  if (!is_read(record) && !is_written(record)) {
    text += "export const " + variable + "Offsets = {\n" + offsets + "};\n";
  }
  if (is_read(record)) {
    text += "export function read" + name + "(data, at) {\n  return {\n" + read + "  };\n}\n";
  }
  if (is_written(record)) {
    text += "export function write" + name + "(data, at, record) {\n" + write + "}\n";
  }
  return text;
}

std::string typescript(const Record& record) {
  const std::string name = record.name, variable = variable_name(record);
  std::string text = "\n  export interface " + name + " {\n";
  for (const Field& field : record.fields) {
    if (is_reserved(field)) continue;
    const std::string type = field.count == 0   ? "number"
                             : field.count == 3 ? "[number, number, number]"
                                                : "number[]";
    text += "    " + camel_case(field.name) + ": " + type + ";\n";
  }
  text += "  }\n  export const " + variable + "Bytes: number;\n";
  if (!is_read(record) && !is_written(record)) {
    text += "  export const " + variable + "Offsets: Record<keyof " + name + ", number>;\n";
  }
  if (is_read(record)) {
    text += "  export function read" + name + "(data: DataView, at: number): " + name + ";\n";
  }
  if (is_written(record)) {
    text += "  export function write" + name + "(data: DataView, at: number, record: " + name +
            "): void;\n";
  }
  return text;
}

bool write_file(const char* path, const std::string& text) {
  std::FILE* file = std::fopen(path, "wb");
  if (!file) return false;
  const bool is_written_whole = std::fwrite(text.data(), 1, text.size(), file) == text.size();
  return std::fclose(file) == 0 && is_written_whole;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: write_layouts layouts.js layouts.d.ts\n");
    return 2;
  }
  const std::string origin =
      "// Generated by shared/bindings/wasm/write_layouts.cpp from records.h.\n";
  std::string script = origin;
  std::string types = origin + "declare module \"*/layouts.js\" {\n";
  for (const Constant& constant : all_constants()) {
    script += std::string("export const ") + constant.name + " = " +
              std::to_string(constant.value) + ";\n";
    types += std::string("  export const ") + constant.name + ": number;\n";
  }
  for (const Enumeration& enumeration : all_enumerations()) {
    script += std::string("export const ") + enumeration.name + " = [";
    for (const char* name : enumeration.values) script += std::string("\"") + name + "\",";
    script += "];\n";
    types += std::string("  export const ") + enumeration.name + ": readonly string[];\n";
  }
  for (const Record& record : all_records()) {
    if (has_gap(record)) {
      std::fprintf(stderr, "Isosplat%s: expected a list of all its fields without padding\n",
                   record.name);
      return 1;
    }
    script += javascript(record);
    types += typescript(record);
  }
  types += "}\n";
  if (!write_file(argv[1], script) || !write_file(argv[2], types)) {
    std::fprintf(stderr, "expected to write %s and %s, but could not\n", argv[1], argv[2]);
    return 1;
  }
}
