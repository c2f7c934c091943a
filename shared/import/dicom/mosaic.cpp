#include "shared/import/dicom/mosaic.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace isosplat::import::dicom {
namespace {

constexpr size_t kEntryBytes = 84, kNameBytes = 64, kItemBytes = 16;
constexpr uint32_t kMaxEntries = 1000, kMaxItems = 100'000;

/// Reads a header from front to back; returns zeros behind its end.
class CsaReader {
 public:
  explicit CsaReader(std::string_view bytes) : rest_(bytes) {}

  bool has(size_t bytes) const { return rest_.size() >= bytes; }

  uint32_t number_at(size_t at) const {
    uint32_t value = 0;
    if (has(at + sizeof value)) std::memcpy(&value, rest_.data() + at, sizeof value);
    return value;
  }

  std::string_view take(size_t bytes) {
    const std::string_view taken = rest_.substr(0, bytes);
    rest_.remove_prefix(taken.size());
    return taken;
  }

 private:
  std::string_view rest_;
};

std::string_view until_zero(std::string_view text) {
  return text.substr(0, text.find('\0'));
}

}  // namespace

std::vector<double> csa_numbers(std::string_view header, std::string_view name) {
  CsaReader reader(header);
  const bool is_sv10 = header.starts_with("SV10");
  if (is_sv10) reader.take(8);
  const uint32_t entries = reader.number_at(0);
  reader.take(8);
  uint32_t first_items = 0;
  if (entries > kMaxEntries) return {};
  for (uint32_t i = 0; i < entries && reader.has(kEntryBytes); ++i) {
    const uint32_t items = reader.number_at(kNameBytes + 12);
    if (i == 0) first_items = items;
    const std::string_view entry = until_zero(reader.take(kEntryBytes).substr(0, kNameBytes));
    if (items > kMaxItems) return {};
    Item values;
    Element& element = values.elements.emplace_back();
    for (uint32_t k = 0; k < items; ++k) {
      if (!reader.has(kItemBytes)) return {};
      const uint32_t length =
          is_sv10 ? reader.number_at(4)
                  : reader.number_at(0) - std::min(first_items, reader.number_at(0));
      reader.take(kItemBytes);
      if (!reader.has(length)) return {};
      const std::string_view text = until_zero(reader.take(length));
      reader.take((4 - length % 4) % 4);
      if (entry != name || text.find_first_not_of(' ') == text.npos) continue;
      if (!element.text.empty()) element.text += '\\';
      element.text += text;
    }
    if (entry == name) return values.numbers(0);
  }
  return {};
}

bool is_mosaic(const Item& data) {
  return data.text(kImageType).find("MOSAIC") != std::string_view::npos;
}

std::optional<Mosaic> read_mosaic(const Item& data) {
  Mosaic out;
  double slices = data.number(kMosaicImages).value_or(0);
  if (const Element* csa = data.find(kSiemensImage)) {
    const std::vector<double> count = csa_numbers(csa->text, "NumberOfImagesInMosaic");
    if (!count.empty()) slices = count.front();
    const std::vector<double> normal = csa_numbers(csa->text, "SliceNormalVector");
    if (normal.size() == 3 &&
        std::all_of(normal.begin(), normal.end(), [](double n) { return std::isfinite(n); })) {
      out.normal = Vec3d{normal[0], normal[1], normal[2]};
    }
  }
  if (!(slices >= 1 && slices <= 4096)) return std::nullopt;
  out.slices = static_cast<int>(slices);
  return out;
}

}  // namespace isosplat::import::dicom
