#include "shared/render/pick/ray_hits.h"

#include <algorithm>
#include <cmath>

#include "shared/core/base/matrix3.h"
#include "shared/core/sampling/exact_projection.h"
#include "shared/render/pick/thin_structure.h"

namespace isosplat::render {
namespace {

Vec3f to_floats(Vec3d v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

/// Limits [begin, end] to where inside + t · along >= 0. normal: of this plane, world.
void clip(PickRay& ray, double inside, double along, Vec3d normal) {
  if (along > 0) {
    const double begin = -inside / along;
    if (begin > ray.begin) {
      ray.begin = begin;
      ray.cut = normal;
    }
  } else if (along < 0) {
    ray.end = std::min(ray.end, -inside / along);
  } else if (inside < 0) {
    ray.end = ray.begin - 1;
  }
}

/// The part of the ray inside of a box; empty (first > second) if it misses.
std::pair<double, double> in_box(const PickRay& ray, Vec3d low, Vec3d high) {
  double enter = ray.begin, leave = ray.end;
  const double o[3] = {ray.origin.x, ray.origin.y, ray.origin.z};
  const double d[3] = {ray.direction.x, ray.direction.y, ray.direction.z};
  const double from[3] = {low.x, low.y, low.z}, to[3] = {high.x, high.y, high.z};
  for (int axis = 0; axis < 3; ++axis) {
    if (d[axis] == 0) {
      if (o[axis] < from[axis] || o[axis] > to[axis]) return {1, 0};
      continue;
    }
    const double first = (from[axis] - o[axis]) / d[axis], last = (to[axis] - o[axis]) / d[axis];
    enter = std::max(enter, std::min(first, last));
    leave = std::min(leave, std::max(first, last));
  }
  return {enter, leave};
}

/// A cell of any level on the ray.
struct CellRay {
  const Trilinear& f;
  Vec3d low;    // voxels of level 0
  double size;  // of the cell, in the same
  double enter, leave;

  Vec3d position(const PickRay& ray, double t) const {
    return (ray.origin + ray.direction * t - low) * (1 / size);
  }
  PickHit hit(const PickRay& ray, double t, uint32_t isosurface, uint32_t level) const {
    const Vec3f gradient = f.at(to_floats(position(ray, t))).gradient;
    return {t, ray.origin + ray.direction * t,
            Vec3d{gradient.x, gradient.y, gradient.z} * (1 / size), isosurface, level};
  }
};

/// Adds all intersections in the cell.
void add_cell_hits(const PickRay& ray, const CellRay& cell, float isovalue, uint32_t isosurface,
                   uint32_t level, std::vector<PickHit>& hits) {
  const double length_ = cell.leave - cell.enter;
  // The ray enters the cell at 0 and leaves it at 1. Rounding must not lose a root on a face.
  const RayRoots roots(cell.f, to_floats(cell.position(ray, cell.enter)),
                       to_floats(ray.direction * (length_ / cell.size)), isovalue, -1e-6, 1 + 1e-6);
  for (const double root : roots.all()) {
    const double t = cell.enter + std::clamp(root, 0.0, 1.0) * length_;
    hits.push_back(cell.hit(ray, t, isosurface, level));
  }
}

/// Adds the box of a structure that is thinner than the coarse cell, where the ray is in it. The
/// box is at least half as wide as the cell: a click need not hit the line exactly.
void add_thin_hit(const PickRay& ray, const CellRay& cell, ThinBox box, uint32_t isosurface,
                  uint32_t level, std::vector<PickHit>& hits) {
  const auto widen = [](double& low, double& high) {
    const double missing = std::max(0.0, 0.5 - (high - low));
    low = std::clamp(low - 0.5 * missing, 0.0, std::max(0.0, 1 - (high - low) - missing));
    high = std::max(high, low + 0.5);
  };
  widen(box.low.x, box.high.x);
  widen(box.low.y, box.high.y);
  widen(box.low.z, box.high.z);
  const auto [enter, leave] =
      in_box(ray, cell.low + box.low * cell.size, cell.low + box.high * cell.size);
  if (!(enter <= leave)) return;
  hits.push_back(cell.hit(ray, 0.5 * (enter + leave), isosurface, level));
  hits.back().crosses = false;
}

}  // namespace

std::optional<PickRay> pick_ray(const VolumeGrid& grid, const SceneExtent& scene,
                                const RenderSettings& settings, const Camera& camera,
                                const ImagePlace& place) {
  const CameraFrame frame = camera_frame(camera);
  const double px = 2 * frame.half_height(1) / place.height;
  const Vec3d across = frame.right * ((place.x - 0.5 * place.width) * px) +
                       frame.up * ((0.5 * place.height - place.y) * px);
  const Vec3d origin = frame.orthographic ? frame.eye + across : frame.eye;
  const Vec3d direction = frame.orthographic ? frame.forward : frame.forward + across;
  const Projection planes =
      projection(camera, scene.sphere, origin, std::max(place.width, 1), std::max(place.height, 1));
  const Matrix3d dual = grid.dual_edges();
  PickRay ray{multiply_transposed(dual, origin - grid.origin), multiply_transposed(dual, direction),
              planes.near_plane, planes.far_plane};
  for (size_t i = 0; i < settings.clip_planes.size() && i < kMaxClipPlanes; ++i) {
    const Plane& plane = settings.clip_planes[i];
    clip(ray, dot(plane.normal, origin) - plane.offset, dot(plane.normal, direction), plane.normal);
  }
  for (const Plane& face : clip_box_faces(scene.clip_grid, settings)) {
    clip(ray, dot(face.normal, origin) - face.offset, dot(face.normal, direction), face.normal);
  }
  if (!(ray.begin <= ray.end)) return std::nullopt;
  return ray;
}

bool meets_box(const PickRay& ray, Vec3d low, Vec3d high) {
  const auto [enter, leave] = in_box(ray, low, high);
  return enter <= leave;
}

bool is_in_box(Vec3d low, Vec3d voxel, Vec3d high) {
  constexpr double kMargin = 1e-3;
  return voxel.x >= low.x - kMargin && voxel.y >= low.y - kMargin && voxel.z >= low.z - kMargin &&
         voxel.x <= high.x + kMargin && voxel.y <= high.y + kMargin && voxel.z <= high.z + kMargin;
}

bool is_in_volume(const VolumeGrid& grid, Vec3d voxel) {
  return is_in_box({0, 0, 0}, voxel,
                   {grid.voxels.x - 1.0, grid.voxels.y - 1.0, grid.voxels.z - 1.0});
}

void add_hits(const PickRay& ray, const BlockKey& block, std::span<const PackedSample> samples,
              std::span<const float> quantized_isovalues, std::vector<PickHit>& hits) {
  const double size = std::ldexp(1.0, static_cast<int>(block.level));
  const Vec3d corner = Vec3d{double(block.index.x), double(block.index.y), double(block.index.z)} *
                       (kBlockCells * size);
  for (const PackedSample& packed : samples) {
    const UnpackedSample sample = unpack_sample(packed);
    const Vec3d low =
        corner + Vec3d{double(sample.cell.x), double(sample.cell.y), double(sample.cell.z)} * size;
    const auto [enter, leave] = in_box(ray, low, low + Vec3d{size, size, size});
    if (!(enter <= leave)) continue;
    const Trilinear f(sample.corners);
    for (size_t i = 0; i < quantized_isovalues.size(); ++i) {
      if (!is_active(sample.interval, quantized_isovalues[i])) continue;
      const CellRay cell{f, low, size, enter, leave};
      const auto isosurface = static_cast<uint32_t>(i);
      if (block.level == 0) {
        add_cell_hits(ray, cell, quantized_isovalues[i], isosurface, 0, hits);
        continue;
      }
      const float drawn = thickened_isovalue(sample, quantized_isovalues[i]);
      if (is_within_corners(sample, drawn)) {
        add_cell_hits(ray, cell, drawn, isosurface, block.level, hits);
      } else {
        add_thin_hit(ray, cell,
                     thin_box(sample, neighbours_of(packed), quantized_isovalues[i], 1 / size),
                     isosurface, block.level, hits);
      }
    }
  }
}

std::optional<SurfacePick> nearest_pick(const VolumeGrid& grid, const ValueMapping& mapping,
                                        const PickRay& ray, std::vector<PickHit> hits) {
  if (hits.empty()) return std::nullopt;
  std::sort(hits.begin(), hits.end(),
            [](const PickHit& a, const PickHit& b) { return a.distance < b.distance; });
  const PickHit& hit = hits.front();
  const Vec3d origin = grid.world(ray.origin);
  const Vec3d direction = grid.world(ray.origin + ray.direction) - origin;
  SurfacePick pick;
  pick.voxel = hit.voxel;
  pick.position = grid.world(hit.voxel);
  pick.isosurface = hit.isosurface;
  pick.level = hit.level;
  const Vec3d normal = grid.world_gradient(hit.gradient);
  const double steepness = length(normal);
  pick.gradient = steepness * std::abs(mapping.scale);
  pick.normal = steepness > 0 ? normal * (1 / steepness) : direction * (-1 / length(direction));
  if (dot(pick.normal, direction) > 0) pick.normal = pick.normal * -1.0;
  // Two cells find a crossing of their common face, at almost the same place.
  const double touching =
      1e-3 * std::min({grid.spacing.x, grid.spacing.y, grid.spacing.z}) / length(direction);
  const auto next = std::find_if(hits.begin(), hits.end(), [&](const PickHit& other) {
    return other.distance > hit.distance + touching;
  });
  if (next != hits.end()) pick.to_next = (next->distance - hit.distance) * length(direction);
  return pick;
}

}  // namespace isosplat::render
