#include "shared/system/store_file/field_file.h"

namespace isosplat {

Result<std::shared_ptr<StoreFile>> open_field(const StoreFile& store, size_t field) {
  const StoreInfo& info = store.info();
  const FieldRef& ref = info.fields[field];
  auto opened = StoreFile::open(store.file().range(ref.offset, ref.bytes), store.path(),
                                uint64_t{256} << 20, StoreKind::field);
  if (!opened) return opened;
  const StoreInfo& found = (*opened)->info();
  if (found.grid.voxels != info.grid.voxels || found.mapping.offset != info.mapping.offset ||
      found.mapping.scale != info.mapping.scale || found.mapping.bits != info.mapping.bits) {
    return fail(Status::malformed_header,
                store.path().string() + ": field '" + ref.info.name +
                    "': expected the grid and the values of its store, found others: rebuild the "
                    "store");
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
