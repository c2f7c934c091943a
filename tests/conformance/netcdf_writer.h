#pragma once

#include <optional>

#include "tests/conformance/sample.h"

// Written from the NetCDF Users Guide, appendix B (file format specifications).
namespace isosplat::conformance {

struct NetcdfAxis {
  std::string name;
  int size = 0;
  bool is_record = false;
};

struct NetcdfAttribute {
  std::string name;
  std::string text = {};
  std::optional<Number> type = {};
  std::vector<double> numbers = {};
};

struct NetcdfArray {
  std::string name;
  std::vector<int> axes;       ///< indices, the slowest first
  std::optional<Number> type;  ///< nothing: characters
  std::vector<double> values;
  std::vector<NetcdfAttribute> attributes = {};
};

/// A file of CDF-1, -2 or -5.
class NetcdfWriter {
 public:
  explicit NetcdfWriter(int version) : version_(version) {}

  std::vector<NetcdfAxis> axes;
  std::vector<NetcdfArray> arrays;
  int records = 0;
  bool is_streamed = false;  ///< the number of records is not stated
  std::string after = {};    ///< bytes behind the data

  std::string bytes() const {
    // The header's size does not depend on the offsets in it.
    std::vector<uint64_t> begins(arrays.size());
    uint64_t at = header(begins).size();
    for (const bool is_record : {false, true}) {
      for (size_t i = 0; i < arrays.size(); ++i) {
        if (has_records(arrays[i]) != is_record) continue;
        begins[i] = at;
        at += is_record ? record_bytes(arrays[i]) : padded(bytes_of_part(arrays[i]));
      }
    }
    std::string file = header(begins);
    for (const NetcdfArray& array : arrays) {
      if (!has_records(array)) file += data(array, 0);
    }
    for (int record = 0; record < records; ++record) {
      for (const NetcdfArray& array : arrays) {
        if (has_records(array)) file += data(array, record);
      }
    }
    return file + after;
  }

 private:
  static int code(const std::optional<Number>& type) {
    if (!type) return 2;
    switch (*type) {
      case Number::i8:
        return 1;
      case Number::i16:
        return 3;
      case Number::i32:
        return 4;
      case Number::f32:
        return 5;
      case Number::f64:
        return 6;
      case Number::u8:
        return 7;
      case Number::u16:
        return 8;
      case Number::u32:
        return 9;
      case Number::i64:
        return 10;
      case Number::u64:
        return 11;
    }
    return 0;
  }
  static uint64_t padded(uint64_t bytes) { return (bytes + 3) / 4 * 4; }
  bool has_records(const NetcdfArray& array) const {
    return !array.axes.empty() && axes[size_t(array.axes[0])].is_record;
  }
  uint64_t bytes_of_part(const NetcdfArray& array) const {
    uint64_t bytes = array.type ? bytes_of(*array.type) : 1;
    for (const int i : array.axes) {
      if (!axes[size_t(i)].is_record) bytes *= static_cast<uint64_t>(axes[size_t(i)].size);
    }
    return bytes;
  }
  uint64_t record_bytes(const NetcdfArray& array) const {
    int others = 0;
    for (const NetcdfArray& each : arrays) others += has_records(each);
    return others == 1 ? bytes_of_part(array) : padded(bytes_of_part(array));
  }

  void count(std::string& out, uint64_t number) const {
    if (version_ == 5) return put(out, number, true);
    put(out, static_cast<uint32_t>(number), true);
  }
  void text(std::string& out, const std::string& name) const {
    count(out, name.size());
    out += name + std::string(padded(name.size()) - name.size(), '\0');
  }
  void list(std::string& out, uint32_t tag, size_t elements) const {
    put(out, elements == 0 ? uint32_t{0} : tag, true);
    count(out, elements);
  }
  void attributes(std::string& out, const std::vector<NetcdfAttribute>& all) const {
    list(out, 12, all.size());
    for (const NetcdfAttribute& each : all) {
      text(out, each.name);
      put(out, static_cast<uint32_t>(code(each.type)), true);
      count(out, each.type ? each.numbers.size() : each.text.size());
      std::string values = each.type ? binary_of(each.numbers, *each.type, true) : each.text;
      values.resize(padded(values.size()));
      out += values;
    }
  }
  std::string header(const std::vector<uint64_t>& begins) const {
    std::string out = "CDF";
    out += static_cast<char>(version_);
    count(out, is_streamed ? ~uint64_t{0} : static_cast<uint64_t>(records));
    list(out, 10, axes.size());
    for (const NetcdfAxis& axis : axes) {
      text(out, axis.name);
      count(out, axis.is_record ? 0 : static_cast<uint64_t>(axis.size));
    }
    attributes(out, {{"title", "a test"}, {"version", "", Number::f64, {1, 2}}});
    list(out, 11, arrays.size());
    for (size_t i = 0; i < arrays.size(); ++i) {
      const NetcdfArray& array = arrays[i];
      text(out, array.name);
      count(out, array.axes.size());
      for (const int axis : array.axes) count(out, static_cast<uint64_t>(axis));
      attributes(out, array.attributes);
      put(out, static_cast<uint32_t>(code(array.type)), true);
      count(out, padded(bytes_of_part(array)));
      if (version_ == 1) {
        put(out, static_cast<uint32_t>(begins[i]), true);
      } else {
        put(out, begins[i], true);
      }
    }
    return out;
  }
  std::string data(const NetcdfArray& array, int record) const {
    const uint64_t bytes = bytes_of_part(array);
    std::string out;
    if (array.type) {
      const size_t part = static_cast<size_t>(bytes / bytes_of(*array.type));
      const size_t first = has_records(array) ? static_cast<size_t>(record) * part : 0;
      out = binary_of({array.values.begin() + static_cast<std::ptrdiff_t>(first),
                       array.values.begin() + static_cast<std::ptrdiff_t>(first + part)},
                      *array.type, true);
    } else {
      out.assign(bytes, 'c');
    }
    out.resize(has_records(array) ? record_bytes(array) : padded(bytes));
    return out;
  }

  int version_;
};

}  // namespace isosplat::conformance
