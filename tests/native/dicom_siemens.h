#pragma once

#include <string>
#include <utility>
#include <vector>

#include "tests/native/dicom_files.h"

// Writes the private elements of Siemens' mosaics. Their layout is not public: this follows the
// description in NiBabel's documentation ("Siemens format DICOM with CSA header").
namespace isosplat::test {

/// The texts of a CSA entry.
using CsaEntry = std::pair<std::string, std::vector<std::string>>;

/// A CSA header in the layout "SV10", or in the one before it. Each entry has six items, as on
/// scanners; those without a text are empty.
inline std::string csa_header(const std::vector<CsaEntry>& entries, bool is_sv10) {
  const auto number = [](uint32_t value) {
    return std::string(reinterpret_cast<const char*>(&value), sizeof value);
  };
  constexpr uint32_t kItems = 6, kMark = 77;
  std::string out = is_sv10 ? std::string("SV10\4\3\2\1") : std::string();
  out += number(static_cast<uint32_t>(entries.size())) + number(kMark);
  for (const auto& [name, texts] : entries) {
    std::string field = name + '\0' + std::string(64, 'x');  // what follows the name is arbitrary
    field.resize(64);
    out += field + number(static_cast<uint32_t>(texts.size())) + std::string("FD\0\0", 4) +
           number(4) + number(kItems) + number(kMark);
    for (uint32_t i = 0; i < kItems; ++i) {
      std::string text = i < texts.size() ? texts[i] + std::string(1, '\0') : std::string();
      const auto length = static_cast<uint32_t>(text.size());
      out += number(is_sv10 ? kMark : length + kItems) + number(length) + number(kMark) + number(0);
      text.resize((text.size() + 3) / 4 * 4);
      out += text;
    }
  }
  return out + std::string(4, '\0');
}

/// The CSA header of a mosaic, between other entries.
inline std::string csa_of_mosaic(int slices, const std::vector<double>& normal, bool is_sv10) {
  std::vector<CsaEntry> entries{{"EchoLinePosition", {"32"}}, {"MosaicRefAcqTimes", {}}};
  entries.push_back({"NumberOfImagesInMosaic", {std::to_string(slices) + " "}});
  if (!normal.empty()) {
    CsaEntry entry{"SliceNormalVector", {}};
    for (const double n : normal) entry.second.push_back(fmt::format("{:.8f}", n));
    entries.push_back(entry);
  }
  entries.push_back({"ProtocolSliceNumber", {"0"}});
  return csa_header(entries, is_sv10);
}

/// Adds a CSA image header in a block of private elements, behind the block of another creator.
inline void add_csa(DicomItem& data, const std::string& header, uint32_t block = 0x10) {
  data[0x00290000 | (block - 1)] = dicom_text("LO", "SIEMENS MEDCOM HEADER");
  data[0x00290010 | ((block - 1) << 8)] = {"OB", "not this one", 1, {}};
  data[0x00290000 | block] = dicom_text("LO", "SIEMENS CSA HEADER");
  data[0x00290010 | (block << 8)] = {"OB", header + std::string(header.size() % 2, '\0'), 1, {}};
}

/// Slices as the tiles of a square image, row by row; the last tiles may be empty.
inline std::vector<uint16_t> tiled(const std::vector<std::vector<uint16_t>>& slices, int columns,
                                   int rows) {
  int across = 1;
  while (across * across < static_cast<int>(slices.size())) ++across;
  std::vector<uint16_t> out(static_cast<size_t>(across * across * columns * rows), 0);
  for (size_t i = 0; i < slices.size(); ++i) {
    const int left = static_cast<int>(i) % across * columns;
    const int top = static_cast<int>(i) / across * rows;
    for (int y = 0; y < rows; ++y) {
      for (int x = 0; x < columns; ++x) {
        out[static_cast<size_t>((top + y) * across * columns + left + x)] =
            slices[i][static_cast<size_t>(y * columns + x)];
      }
    }
  }
  return out;
}

}  // namespace isosplat::test
