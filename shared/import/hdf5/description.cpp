#include "shared/import/hdf5/description.h"

#include "shared/import/axes/cf_axis.h"
#include "shared/import/hdf5/array.h"
#include "shared/import/hdf5/attributes.h"

namespace isosplat::import {

Result<void> read_hdf5_times(const std::shared_ptr<Hdf5File>& file, const Hdf5Object& object,
                             std::string unit, ArrayAxis& axis) {
  std::vector<uint64_t> sizes;
  auto times = hdf5_small_array(file, object, sizes);
  if (!times && times.error().status == Status::io_error) return tl::unexpected(times.error());
  if (!times || !*times || sizes != std::vector{axis.size}) return {};
  set_times(axis, std::move(**times), std::move(unit));
  return {};
}

Result<ArrayDescription> describe_hdf5(const std::shared_ptr<Hdf5File>& file,
                                       const Hdf5Volume& volume) {
  for (const auto convention :
       {describe_imaris, describe_big_data_viewer, describe_vtk_hdf, describe_itk, describe_chimera,
        describe_emd, describe_open_pmd, describe_matlab, describe_by_attributes}) {
    ArrayDescription description;
    for (const uint64_t size : volume.sizes) {
      description.axes.emplace_back();
      description.axes.back().size = size;
    }
    const auto is_it = convention(file, volume, description);
    if (!is_it) return tl::unexpected(is_it.error());
    if (*is_it) return description;
  }
  return ArrayDescription{};  // the last convention always matches
}

}  // namespace isosplat::import
