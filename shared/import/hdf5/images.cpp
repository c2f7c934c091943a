#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "shared/import/geometry/conventions.h"
#include "shared/import/hdf5/array.h"
#include "shared/import/hdf5/attributes.h"
#include "shared/import/hdf5/description.h"
#include "shared/import/text/header_text.h"

// Images with a geometry: those of VTK, ITK and Chimera.
//
// /VTKHDF                    attributes Type, WholeExtent (first and last point along x, y, z),
//                            Origin (of point 0), Spacing, Direction (columns are the axes)
//   PointData/NAME           (time,) z, y, x (, component)
//   CellData/NAME            the same for the cells between points
//   Steps/Values             the times, if there are time steps
// /ITKImage/N                datasets Origin, Spacing, Directions (a row per axis),
//                            VoxelData: z, y, x
// /Chimera/NAME              attributes step, origin, cell_angles, rotation_axis, rotation_angle
//   ARRAY                    z, y, x; attribute subsample_spacing of coarser copies; ångström
namespace isosplat::import {
namespace {

constexpr double kMillimetresPerAngstrom = 1e-7;

std::optional<Vec3d> vector_of(const std::optional<std::vector<double>>& numbers) {
  if (!numbers || numbers->size() != 3) return std::nullopt;
  return Vec3d{(*numbers)[0], (*numbers)[1], (*numbers)[2]};
}

double component(Vec3d v, size_t i) {
  return i == 0 ? v.x : i == 1 ? v.y : v.z;
}

/// Names the last three of `axes` z, y and x, and sets their steps.
void set_steps(std::span<ArrayAxis> axes, const std::optional<Vec3d>& steps) {
  for (size_t i = 0; i < 3; ++i) {
    ArrayAxis& axis = axes[axes.size() - 1 - i];
    axis.letter = "xyz"[i];
    if (steps) axis.step = component(*steps, i);
  }
}

/// A vector rotated about an axis through 0, in degrees (Rodrigues).
Vec3d turned(Vec3d v, Vec3d axis, double degrees) {
  const Vec3d k = axis * (1 / length(axis));
  const double angle = degrees * std::numbers::pi / 180, c = std::cos(angle), s = std::sin(angle);
  return v * c + cross(k, v) * s + k * (dot(k, v) * (1 - c));
}

Result<Hdf5Object> group_of(const std::shared_ptr<Hdf5File>& file, const std::string& path) {
  const auto group = hdf5_object_at(*file, path);
  if (!group) return tl::unexpected(group.error());
  return *group ? **group : Hdf5Object{};
}

}  // namespace

Result<bool> describe_vtk_hdf(const std::shared_ptr<Hdf5File>& file, const Hdf5Volume& volume,
                              ArrayDescription& description) {
  const bool has_points = volume.parent == "/VTKHDF/PointData";
  if (!has_points && volume.parent != "/VTKHDF/CellData") return false;
  const auto group = group_of(file, "VTKHDF");
  if (!group) return tl::unexpected(group.error());
  const auto steps = hdf5_object_at(*file, "VTKHDF/Steps");
  if (!steps) return tl::unexpected(steps.error());
  const auto extent = hdf5_numbers(*file, *group, "WholeExtent");
  if (hdf5_text(*file, *group, "Type") != "ImageData" || !extent || extent->size() != 6) {
    return false;
  }
  auto& axes = description.axes;
  size_t before = *steps ? 1 : 0;
  if (before > axes.size()) return false;
  const size_t after = axes.size() - before;
  if (after < 3 || after > 4) return false;
  if (before > 0) {
    axes[0].letter = 't';
    const auto values = hdf5_object_at(*file, "VTKHDF/Steps/Values");
    if (!values) return tl::unexpected(values.error());
    if (*values) {
      if (auto r = read_hdf5_times(file, **values, "", axes[0]); !r) {
        return tl::unexpected(r.error());
      }
    }
  }
  if (after == 4) axes.back().letter = 'c';
  const auto spatial = std::span(axes).subspan(before, 3);
  set_steps(spatial, vector_of(hdf5_numbers(*file, *group, "Spacing")));
  if (const auto turn = hdf5_numbers(*file, *group, "Direction"); turn && turn->size() == 9) {
    for (size_t i = 0; i < 3; ++i) {
      description.directions[i] = {(*turn)[i], (*turn)[3 + i], (*turn)[6 + i]};
    }
  }
  description.origin = vector_of(hdf5_numbers(*file, *group, "Origin")).value_or(Vec3d{0, 0, 0});
  for (size_t i = 0; i < 3; ++i) {
    const double first = (*extent)[2 * i], last = (*extent)[2 * i + 1];
    const ArrayAxis& axis = spatial[2 - i];
    const double expected = last - first + (has_points ? 1 : 0);
    if (expected != static_cast<double>(axis.size)) {
      return file->malformed(
          fmt::format("expected {} values along {} by VTKHDF's WholeExtent, found {}", expected,
                      axis.letter, axis.size));
    }
    const double place = first + (has_points ? 0 : 0.5);
    description.origin =
        description.origin + description.directions[i] * (axis.step.value_or(1) * place);
  }
  if (!has_points) {
    description.notes.push_back(
        "the values are those of cells: each becomes a voxel at the centre of its cell");
  }
  description.knows_axes = true;
  return true;
}

Result<bool> describe_itk(const std::shared_ptr<Hdf5File>& file, const Hdf5Volume& volume,
                          ArrayDescription& description) {
  if (!volume.parent.starts_with("/ITKImage/") || description.axes.size() < 3) return false;
  const auto numbers = [&](const char* name) -> Result<std::optional<std::vector<double>>> {
    const auto object = hdf5_object_at(*file, volume.parent + "/" + name);
    if (!object) return tl::unexpected(object.error());
    std::vector<uint64_t> sizes;
    if (!*object) return std::nullopt;
    return hdf5_small_array(file, **object, sizes);
  };
  const auto spacing = numbers("Spacing"), origin = numbers("Origin"),
             directions = numbers("Directions");
  for (const auto* each : {&spacing, &origin, &directions}) {
    if (!*each) return tl::unexpected(each->error());
  }
  // If images have several numbers per voxel, the fastest axis is an additional one.
  const size_t axes = *spacing ? (*spacing)->size() : 3;
  if (axes != 3 || description.axes.size() > 4) return false;
  if (description.axes.size() == 4) description.axes.back().letter = 'c';
  set_steps(std::span(description.axes).first(3), vector_of(*spacing));
  if (*directions && (*directions)->size() == 9) {
    const auto& d = **directions;
    for (size_t i = 0; i < 3; ++i) {
      description.directions[i] = {d[3 * i], d[3 * i + 1], d[3 * i + 2]};
    }
  }
  description.origin = vector_of(*origin).value_or(Vec3d{0, 0, 0});
  description.knows_axes = true;
  return true;
}

Result<bool> describe_chimera(const std::shared_ptr<Hdf5File>& file, const Hdf5Volume& volume,
                              ArrayDescription& description) {
  if (!volume.parent.starts_with("/Chimera/") || description.axes.size() != 3) return false;
  const auto group = group_of(file, volume.parent);
  if (!group) return tl::unexpected(group.error());
  const auto vector = [&](const Hdf5Object& object, const char* name) {
    return vector_of(hdf5_numbers(*file, object, name));
  };
  auto step = vector(*group, "step");
  if (step) {
    *step = *step * kMillimetresPerAngstrom;
    const auto copy = vector(volume.object, "subsample_spacing");
    if (copy) *step = {step->x * copy->x, step->y * copy->y, step->z * copy->z};
    description.notes.push_back("lengths of Chimera's maps are read as ångström");
  }
  set_steps(description.axes, step);
  if (const auto angles = vector(*group, "cell_angles")) {
    if (const auto axes = cell_axes({angles->x, angles->y, angles->z}))
      description.directions = *axes;
  }
  const auto axis = vector(*group, "rotation_axis");
  const auto angle = hdf5_numbers(*file, *group, "rotation_angle");
  if (axis && length(*axis) > 0 && angle && angle->size() == 1) {
    for (Vec3d& each : description.directions) each = turned(each, *axis, angle->front());
  }
  const auto origin = vector(*group, "origin");
  if (origin) description.origin = *origin * kMillimetresPerAngstrom;
  description.knows_axes = true;
  return true;
}

}  // namespace isosplat::import
