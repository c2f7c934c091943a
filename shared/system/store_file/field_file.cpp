#include "shared/system/store_file/field_file.h"

#include <algorithm>

namespace isosplat {
namespace {

bool is_same(const ValueMapping& a, const ValueMapping& b) {
  return a.offset == b.offset && a.scale == b.scale && a.max_error == b.max_error &&
         a.bits == b.bits && a.has_missing == b.has_missing;
}

bool is_same(const FieldInfo& a, const FieldInfo& b) {
  return a.name == b.name && is_same(a.mapping, b.mapping) && a.range == b.range &&
         a.missing_voxels == b.missing_voxels;
}

/// Whether pages have the same blocks and intervals, which select the same chunks.
bool is_same_page(const PageRef& a, const PageRef& b) {
  return a.level == b.level && a.first_block == b.first_block && a.end_block == b.end_block &&
         a.interval == b.interval;
}

/// What differs between a field and its store, in words; empty if nothing does.
const char* difference(const StoreFile& store, const StoreFile& field, const FieldInfo& listed) {
  const StoreInfo &a = store.info(), &b = field.info();
  if (a.grid.voxels != b.grid.voxels) return "the number of voxels of its store";
  if (!is_same(a.mapping, b.mapping)) return "the mapping of its store";
  if (a.chunk_count != b.chunk_count ||
      !std::equal(store.pages().begin(), store.pages().end(), field.pages().begin(),
                  field.pages().end(), is_same_page)) {
    return "the pages and chunks of its store";
  }
  return is_same(*b.field, listed) ? "" : "the description in the list of its store";
}

}  // namespace

Result<std::shared_ptr<StoreFile>> open_field(const StoreFile& store, size_t field,
                                              uint64_t directory_bytes) {
  const FieldRef& ref = store.info().fields[field];
  std::filesystem::path name = store.path();
  name += ", field '" + ref.info.name + "'";
  auto opened = StoreFile::open(store.file().range(ref.offset, ref.bytes), name, directory_bytes,
                                StoreKind::field);
  if (!opened) return opened;
  if (const std::string expected = difference(store, **opened, ref.info); !expected.empty()) {
    return fail(Status::malformed_header, name.string() + ": expected " + expected +
                                              ", found another: rebuild the store, or fetch it "
                                              "again");
  }
  return opened;
}

Result<size_t> find_field(const StoreInfo& store, const std::string& name) {
  std::string names;
  for (size_t i = 0; i < store.fields.size(); ++i) {
    const std::string& found = store.fields[i].info.name;
    if (found == name) return i;
    names += (i > 0 ? ", " : "") + found;
  }
  return fail(Status::not_found,
              "field '" + name + "': expected " +
                  (names.empty() ? "a store with fields, found one without: isosplat build --field "
                                   "adds them"
                                 : "a field of the store, which has " + names));
}

}  // namespace isosplat
