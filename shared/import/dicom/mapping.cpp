#include "shared/import/dicom/mapping.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "shared/import/dicom/pixels.h"

namespace isosplat::import::dicom {
namespace {

/// A Real World Value Mapping: a line, for the stored values from `first` to `last`.
struct Line {
  double slope = 1, intercept = 0;
  double first = 0, last = 0;
  std::string quantity;  ///< "ADC" (um2/s); empty: unnamed

  bool same_values(const Line& other) const {
    return slope == other.slope && intercept == other.intercept;
  }
  bool overlaps(const Line& other) const { return first <= other.last && other.first <= last; }
  std::string text() const {
    return quantity.empty() ? fmt::format("{:.10g} · stored + {:.10g}", slope, intercept)
                            : quantity;
  }
};

class MappingReader {
 public:
  MappingReader(const FrameGroups& groups, size_t i, const std::filesystem::path& path,
                Image& image)
      : groups_(groups), data_(groups.data()), i_(i), path_(path), image_(image) {}

  Result<void> read(Frame& frame, std::string& quantity) {
    const Item* transformation = groups_.find(i_, kPixelValueTransformation);
    const Item& item = transformation ? *transformation : data_;
    for (const Tag tag : {kRescaleSlope, kRescaleIntercept, kDoseGridScaling}) {
      const Item& holder = tag == kDoseGridScaling ? data_ : item;
      if (!holder.text(tag).empty() && !holder.number(tag)) {
        return malformed("its rescale slope or intercept is not a number");
      }
    }
    frame.slope = item.number(kRescaleSlope).value_or(1);
    frame.intercept = item.number(kRescaleIntercept).value_or(0);
    const auto scaling = data_.number(kDoseGridScaling);
    if (scaling) frame.slope = *scaling;
    if (const Element* lut = data_.find(kModalityLut); lut && !lut->items.empty()) {
      refuse_image(
          image_, Status::unsupported_type,
          "expected pixels with slope and intercept, found a lookup table for their values: "
          "export it with the table applied");
      return {};
    }
    const bool is_rescaled =
        scaling || item.number(kRescaleSlope) || item.number(kRescaleIntercept);
    const auto lines = read_lines(!is_rescaled);
    if (!lines) return tl::unexpected(lines.error());
    if (is_rescaled) {
      note_others(*lines, {frame.slope, frame.intercept, 0, 0, {}},
                  "Rescale Slope and Intercept are used");
    } else if (!lines->empty()) {
      apply(*lines, frame);
      quantity = lines->front().quantity;
    }
    if (frame.slope == 0) return malformed("its rescale slope is 0, so all values would be equal");
    return {};
  }

 private:
  tl::unexpected<Error> malformed(std::string_view why) const { return contradiction(path_, why); }

  void note(std::string text) { add_note(image_, std::move(text)); }

  /// The mappings of the frame that are lines. `is_needed`: tables refuse the image.
  Result<std::vector<Line>> read_lines(bool is_needed) {
    const std::vector<Item>* items = &groups_.items(i_, kRealWorldMapping);
    if (const Element* all = data_.find(kRealWorldMapping); items->empty() && all) {
      items = &all->items;
    }
    std::vector<Line> lines;
    bool has_table = false;
    for (const Item& item : *items) {
      Line line;
      line.quantity = quantity_of(item);
      const auto slope = item.number(kMappingSlope);
      if (!slope) {
        has_table = has_table || item.find(kMappingTable);
        continue;
      }
      line.slope = *slope;
      line.intercept = item.number(kMappingIntercept).value_or(0);
      const auto [low, high] = stored_range(image_);
      line.first = bound(item, kMappedFirst, kMappedFirstDouble).value_or(low);
      line.last = bound(item, kMappedLast, kMappedLastDouble).value_or(high);
      if (line.first > line.last) std::swap(line.first, line.last);
      lines.push_back(std::move(line));
    }
    if (is_needed && lines.empty() && !items->empty()) {
      if (!has_table) return malformed("its real world value mapping has no slope and no table");
      refuse_image(image_, Status::unsupported_type,
                   "expected pixels with slope and intercept, found a table for their values (Real "
                   "World Value LUT Data): export it with the table applied");
    }
    return lines;
  }

  std::optional<double> bound(const Item& item, Tag whole, Tag real) const {
    if (const auto number = item.number(real)) return number;
    const auto number = item.number(whole);
    // Without a VR, a negative number reads as an unsigned one.
    if (!number || !image_.is_signed || *number < 32768) return number;
    return *number - 65536;
  }

  static std::string quantity_of(const Item& item) {
    const std::string_view label = item.text(kMappingLabel);
    const Item* unit = item.first_item(kMeasurementUnits);
    const std::string_view code = unit ? unit->text(kCodeValue) : std::string_view();
    if (label.empty() && code.empty()) return {};
    if (label.empty()) return std::string(code);
    return code.empty() ? fmt::format("\"{}\"", label) : fmt::format("\"{}\" ({})", label, code);
  }

  void apply(const std::vector<Line>& lines, Frame& frame) {
    const Line& line = lines.front();
    // Lines for separate ranges make up one mapping; lines for the same range are alternatives.
    for (const Line& other : lines) {
      if (!other.overlaps(line) && !other.same_values(line)) {
        return refuse_image(image_, Status::unsupported_type,
                            "expected pixels with one slope and intercept, found different ones "
                            "for ranges of stored values (Real World Value Mapping): export it "
                            "with the values mapped");
      }
    }
    frame.slope = line.slope;
    frame.intercept = line.intercept;
    note_others(lines, line, fmt::format("that to {} is used", line.text()));
    double first = line.first, last = line.last;
    for (const Line& other : lines) {
      if (!other.same_values(line)) continue;
      first = std::min(first, other.first);
      last = std::max(last, other.last);
    }
    const auto [low, high] = stored_range(image_);
    if (!image_.is_float && (first > low || last < high)) {
      note(
          fmt::format("the mapping of stored pixels to values is stated for {:.10g} to {:.10g} "
                      "(Real World Value Mapping): it is applied to all pixels",
                      first, last));
    }
  }

  /// Notes mappings that give other values than `used`.
  void note_others(const std::vector<Line>& lines, const Line& used, std::string_view what) {
    const auto near = [](double a, double b) {
      return std::abs(a - b) <= 1e-5 * std::max(std::abs(a), std::abs(b));
    };
    std::string others;
    for (const Line& line : lines) {
      if (near(line.slope, used.slope) && near(line.intercept, used.intercept)) continue;
      others += (others.empty() ? "" : ", ") +
                (line.quantity.empty() ? std::string("other values") : line.quantity);
    }
    if (others.empty()) return;
    note(fmt::format("the file also maps its pixels to {} (Real World Value Mapping): {}", others,
                     what));
  }

  const FrameGroups& groups_;
  const Item& data_;
  size_t i_;
  const std::filesystem::path& path_;
  Image& image_;
};

}  // namespace

Result<void> read_mapping(const FrameGroups& groups, size_t i, const std::filesystem::path& path,
                          Image& image, Frame& frame, std::string& quantity) {
  return MappingReader(groups, i, path, image).read(frame, quantity);
}

}  // namespace isosplat::import::dicom
