#include "shared/bindings/wasm/layouts_text.h"

#include <cctype>

namespace isosplat::layouts {
namespace {

bool is_read(const Record& record) {
  return record.filled == Filled::by_cpp || record.filled == Filled::by_both;
}

bool is_written(const Record& record) {
  return record.filled == Filled::by_javascript || record.filled == Filled::by_both;
}

bool is_reserved(const Field& field) {
  return std::string(field.name) == "reserved";
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

/// The longest array whose elements are written as separate expressions.
constexpr size_t kMaxUnrolled = 3;

/// data.getUint32(at + 8, true), for one element. `element`: the text to add to the offset.
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

}  // namespace

std::string javascript(const Constant& constant) {
  return std::string("export const ") + constant.name + " = " + std::to_string(constant.value) +
         ";\n";
}

std::string javascript(const Enumeration& enumeration) {
  std::string text = std::string("export const ") + enumeration.name + " = [";
  for (const char* name : enumeration.values) text += std::string("\"") + name + "\",";
  return text + "];\n";
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

std::string typescript(const Constant& constant) {
  return std::string("  export const ") + constant.name + ": number;\n";
}

std::string typescript(const Enumeration& enumeration) {
  return std::string("  export const ") + enumeration.name + ": readonly string[];\n";
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

}  // namespace isosplat::layouts
