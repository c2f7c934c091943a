#pragma once

#include <cstddef>
#include <vector>

// The content of layouts.js: the records of records.h with the layout of their fields, the limits
// that JavaScript uses as well, and the names of some enumerations' values.
namespace isosplat::layouts {

/// A field of a record.
struct Field {
  const char* name;
  const char* type;  ///< as DataView names it: Float64, Uint32, …
  size_t offset;
  size_t bytes;  ///< of one element
  size_t count;  ///< of elements; 0: no array
};

/// Who fills a record. The other side reads it.
enum class Filled {
  by_cpp,
  by_javascript,
  by_both,
  in_bulk,  ///< arrays of these records are copied as a whole
};

struct Record {
  const char* name;  ///< without "Isosplat"
  size_t bytes;
  Filled filled;
  std::vector<Field> fields;
};

/// The records of records.h.
std::vector<Record> all_records();

/// Whether a record has padding, or a field that all_records() does not list.
bool has_gap(const Record& record);

/// A limit, or the number of a result buffer.
struct Constant {
  const char* name;
  size_t value;
};

std::vector<Constant> all_constants();

/// The names of an enumeration's values, which are 0, 1, 2, …
struct Enumeration {
  const char* name;
  std::vector<const char*> values;
};

std::vector<Enumeration> all_enumerations();

}  // namespace isosplat::layouts
