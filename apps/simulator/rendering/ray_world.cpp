#include "rendering/ray_world.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <span>
#include <stdexcept>
#include <string>

#include "rendering/embree.hpp"

namespace kinetrace::simulator {
namespace {

template <auto Release>
struct Releaser {
  template <typename T>
  void operator()(T* handle) const noexcept {
    Release(handle);
  }
};
using Device = std::unique_ptr<RTCDeviceTy, Releaser<&rtcReleaseDevice>>;
using SceneHandle = std::unique_ptr<RTCSceneTy, Releaser<&rtcReleaseScene>>;
using Geometry = std::unique_ptr<RTCGeometryTy, Releaser<&rtcReleaseGeometry>>;

constexpr float kFar = std::numeric_limits<float>::infinity();

void check(RTCDevice device, const char* step) {
  if (const RTCError error = rtcGetDeviceError(device); error != RTC_ERROR_NONE) {
    throw std::runtime_error(std::string("the ray tracer failed while ") + step + " (Embree error " +
                             std::to_string(static_cast<int>(error)) + ")");
  }
}

SceneHandle mesh_scene(RTCDevice device, const Mesh& mesh) {
  const Geometry geometry(rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE));
  auto* positions = static_cast<float*>(rtcSetNewGeometryBuffer(
      geometry.get(), RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), mesh.vertices.size()));
  auto* indices = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
      geometry.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), mesh.triangles.size()));
  check(device, "taking memory for a mesh");
  for (const Mesh::Vertex& vertex : mesh.vertices) {
    positions = std::copy_n(vertex.position.data(), 3, positions);
  }
  for (const Mesh::Triangle& triangle : mesh.triangles) {
    indices = std::copy_n(triangle.corners.data(), 3, indices);
  }
  rtcCommitGeometry(geometry.get());
  SceneHandle scene(rtcNewScene(device));
  rtcAttachGeometry(scene.get(), geometry.get());
  rtcCommitScene(scene.get());
  check(device, "building the tree of a mesh");
  return scene;
}

constexpr std::size_t kWidth = kGroupWidth;
constexpr std::size_t kGroups = RayPacket::kSize / kWidth;

std::size_t groups_of(const RayPacket& packet) {
  return (packet.count + kWidth - 1) / kWidth;
}

// The rays from `first` on. Lanes beyond the packet's end get an empty range.
template <typename Rays>
void fill_rays(const RayPacket& packet, std::size_t first, Rays& rays) {
  std::memcpy(rays.org_x, &packet.origin_x[first], sizeof rays.org_x);
  std::memcpy(rays.org_y, &packet.origin_y[first], sizeof rays.org_y);
  std::memcpy(rays.org_z, &packet.origin_z[first], sizeof rays.org_z);
  std::memcpy(rays.dir_x, &packet.direction_x[first], sizeof rays.dir_x);
  std::memcpy(rays.dir_y, &packet.direction_y[first], sizeof rays.dir_y);
  std::memcpy(rays.dir_z, &packet.direction_z[first], sizeof rays.dir_z);
  std::fill_n(rays.tnear, kWidth, 0.F);
  std::fill_n(rays.tfar, kWidth, kFar);
  std::fill_n(rays.time, kWidth, 0.F);
  std::fill_n(rays.mask, kWidth, ~0U);
  std::fill_n(rays.id, kWidth, 0U);
  std::fill_n(rays.flags, kWidth, 0U);
  for (std::size_t i = packet.count - first; i < kWidth; ++i) {
    rays.tfar[i] = -kFar;
  }
}

// Zero for a degenerate triangle.
RayWorld::UvSlope uv_slope(const Mesh::Vertex& a, const Mesh::Vertex& b, const Mesh::Vertex& c) {
  Eigen::Matrix<double, 3, 2> edges;
  edges << (b.position - a.position).cast<double>(), (c.position - a.position).cast<double>();
  Eigen::Matrix2d steps;
  steps << (b.uv - a.uv).cast<double>(), (c.uv - a.uv).cast<double>();
  const Eigen::Matrix2d squared = edges.transpose() * edges;
  const double area_squared = squared.determinant();
  if (!(area_squared > 0.0)) {
    return RayWorld::UvSlope::Zero();
  }
  return (steps * squared.inverse() * edges.transpose()).cast<float>();
}

std::vector<RayWorld::Facet> facets_of(const Mesh& mesh) {
  std::vector<RayWorld::Facet> facets;
  facets.reserve(mesh.triangles.size());
  for (const Mesh::Triangle& triangle : mesh.triangles) {
    const auto corner = [&](std::size_t i) -> const Mesh::Vertex& { return mesh.vertices[triangle.corners[i]]; };
    const Eigen::Vector3f& origin = corner(0).position;
    const Eigen::Vector3f normal = (corner(1).position - origin).cross(corner(2).position - origin).normalized();
    constexpr float kFlat = 0.9999F;
    const bool flat = std::abs(normal.dot(corner(0).normal)) > kFlat &&
                      std::abs(normal.dot(corner(1).normal)) > kFlat && std::abs(normal.dot(corner(2).normal)) > kFlat;
    facets.push_back({{corner(0), corner(1), corner(2)}, normal, flat, triangle.paint});
  }
  return facets;
}

std::vector<RayWorld::UvSlope> uv_slopes_of(const Mesh& mesh) {
  std::vector<RayWorld::UvSlope> slopes;
  slopes.reserve(mesh.triangles.size());
  for (const Mesh::Triangle& triangle : mesh.triangles) {
    const auto& [a, b, c] = triangle.corners;
    slopes.push_back(uv_slope(mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]));
  }
  return slopes;
}

void read_hits(const RTCRayHit8& rays, std::size_t first, RayPacket& packet) {
  static_assert(RTC_INVALID_GEOMETRY_ID == RayPacket::kMiss);
  std::memcpy(&packet.distance[first], rays.ray.tfar, sizeof rays.ray.tfar);
  std::memcpy(&packet.u[first], rays.hit.u, sizeof rays.hit.u);
  std::memcpy(&packet.v[first], rays.hit.v, sizeof rays.hit.v);
  std::memcpy(&packet.triangle[first], rays.hit.primID, sizeof rays.hit.primID);
  for (std::size_t i = 0; i < kWidth; ++i) {
    const bool on_world = rays.hit.geomID[i] != RayPacket::kMiss && rays.hit.instID[0][i] == RayPacket::kMiss;
    packet.part[first + i] = on_world ? 0 : rays.hit.instID[0][i];
  }
}

// The whole view for a box that reaches behind the camera; empty for one entirely behind it.
Eigen::AlignedBox2f view_of(const Eigen::AlignedBox3f& box, const Eigen::Isometry3f& T_view_part) {
  constexpr float kNearest_m = 0.01F;
  Eigen::AlignedBox2f view;
  bool before = false;
  bool behind = false;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3f corner = T_view_part * box.corner(static_cast<Eigen::AlignedBox3f::CornerType>(i));
    before = before || corner.z() > kNearest_m;
    behind = behind || corner.z() <= kNearest_m;
    view.extend(Eigen::Vector2f(corner.hnormalized()));
  }
  if (before && behind) {
    return {Eigen::Vector2f::Constant(-kFar), Eigen::Vector2f::Constant(kFar)};
  }
  return before ? view : Eigen::AlignedBox2f();
}

}  // namespace

// The static world is traced separately: as another instance among the actors it would be entered by every ray, most
// often before the actors in front of it.
struct RayWorld::Handles {
  Device device;
  std::vector<SceneHandle> meshes;  // One for each part.
  SceneHandle actors;
  std::vector<Geometry> instances;  // In `actors`, one for each part but the world.
};

RayWorld::RayWorld(const Scene& scene)
    : scene_(scene), to_sun_(scene.light.to_sun.normalized()), handles_(std::make_unique<Handles>()) {
  across_sun_.row(0) = to_sun_.unitOrthogonal();
  across_sun_.row(1) = to_sun_.cross(to_sun_.unitOrthogonal());
  const auto add_part = [&](const Mesh& mesh, int actor) {
    Part& part = parts_.emplace_back();
    part.mesh = &mesh;
    part.facets = facets_of(mesh);
    part.uv_slopes = uv_slopes_of(mesh);
    for (const Mesh::Vertex& vertex : mesh.vertices) {
      part.box.extend(vertex.position);
    }
    part.actor = actor;
  };
  add_part(scene.world, -1);
  for (std::size_t actor = 0; actor < scene.actors.size(); ++actor) {
    for (const Mesh& mesh : scene.actors[actor].parts) {
      add_part(mesh, static_cast<int>(actor));
    }
  }
  // One build thread and at most AVX2: the last bit of a distance must not depend on the machine. Besides, the AVX-512
  // code of Debian 12's Embree 3.13.5 sometimes never returns from rtcOccluded16 with coherent rays.
  handles_->device.reset(rtcNewDevice("threads=1,max_isa=avx2"));
  if (!handles_->device) {
    throw std::runtime_error("the ray tracer cannot be started; check the installation of Embree");
  }
  RTCDevice device = handles_->device.get();
  handles_->actors.reset(rtcNewScene(device));
  for (std::uint32_t i = 0; i < parts_.size(); ++i) {
    handles_->meshes.push_back(mesh_scene(device, *parts_[i].mesh));
    if (i == 0) {
      continue;
    }
    Geometry instance(rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE));
    rtcSetGeometryInstancedScene(instance.get(), handles_->meshes.back().get());
    rtcCommitGeometry(instance.get());
    rtcAttachGeometryByID(handles_->actors.get(), instance.get(), i);
    handles_->instances.push_back(std::move(instance));
  }
  set_time(0.0);
}

RayWorld::~RayWorld() = default;

void RayWorld::set_time(double time_s) {
  std::uint32_t i = 1;
  for (const Actor& actor : scene_.actors) {
    const Se3 T_scene_obj = actor.T_scene_obj(time_s);
    for (std::size_t part = 0; part < actor.parts.size(); ++part, ++i) {
      const Se3 pose = actor.T_obj_part ? T_scene_obj * actor.T_obj_part(time_s, part) : T_scene_obj;
      parts_[i].R_scene_part = pose.rotation.cast<float>();
      parts_[i].t_scene_part = pose.translation.cast<float>();
      RTCGeometry instance = handles_->instances[i - 1].get();
      Eigen::Matrix<float, 3, 4> matrix;
      matrix << parts_[i].R_scene_part, parts_[i].t_scene_part;
      rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, matrix.data());
      rtcCommitGeometry(instance);
    }
  }
  rtcCommitScene(handles_->actors.get());
  check(handles_->device.get(), "moving the scene");
  cast_outlines();
}

void RayWorld::cast_outlines() {
  constexpr float kMargin_m = 0.05F;
  outlines_.assign(scene_.actors.size(), {});
  for (const Part& part : parts()) {
    for (int i = 0; part.actor >= 0 && i < 8; ++i) {
      const Eigen::Vector3f corner = part.box.corner(static_cast<Eigen::AlignedBox3f::CornerType>(i));
      outlines_[static_cast<std::size_t>(part.actor)].extend(
          Eigen::Vector2f(across_sun_ * (part.R_scene_part * corner + part.t_scene_part)));
    }
  }
  for (Eigen::AlignedBox2f& outline : outlines_) {
    outline.min().array() -= kMargin_m;
    outline.max().array() += kMargin_m;
  }
}

// False for most sunlit points, which saves tracing the actors.
bool RayWorld::may_be_shaded_by_actor(const RayPacket& packet) const {
  using Column = Eigen::Map<const Eigen::ArrayXf>;
  const auto count = static_cast<Eigen::Index>(packet.count);
  const Column x(packet.origin_x.data(), count);
  const Column y(packet.origin_y.data(), count);
  const Column z(packet.origin_z.data(), count);
  Eigen::AlignedBox2f box;
  for (int axis = 0; axis < 2; ++axis) {
    const auto along = across_sun_(axis, 0) * x + across_sun_(axis, 1) * y + across_sun_(axis, 2) * z;
    box.min()[axis] = along.minCoeff();
    box.max()[axis] = along.maxCoeff();
  }
  return std::any_of(outlines_.begin(), outlines_.end(),
                     [&](const Eigen::AlignedBox2f& outline) { return outline.intersects(box); });
}

std::vector<Eigen::AlignedBox2f> RayWorld::actors_in_view(const Se3& T_scene_view) const {
  std::vector<Eigen::AlignedBox2f> views;
  const Eigen::Matrix3f R_view_scene = T_scene_view.rotation.transpose().cast<float>();
  const Eigen::Vector3f camera = T_scene_view.translation.cast<float>();
  for (std::size_t i = 1; i < parts_.size(); ++i) {
    Eigen::Isometry3f T_view_part;
    T_view_part.linear() = R_view_scene * parts_[i].R_scene_part;
    T_view_part.translation() = R_view_scene * (parts_[i].t_scene_part - camera);
    if (const Eigen::AlignedBox2f view = view_of(parts_[i].box, T_view_part); !view.isEmpty()) {
      views.push_back(view);
    }
  }
  return views;
}

void RayWorld::trace(RayPacket& packet, Reach reach) const {
  std::array<RTCRayHit8, kGroups> groups;
  const std::size_t count = groups_of(packet);
  if (count == 0) {
    return;
  }
  for (std::size_t group = 0; group < count; ++group) {
    RTCHit8& hit = groups[group].hit;
    fill_rays(packet, group * kWidth, groups[group].ray);
    std::fill_n(hit.primID, kWidth, RTC_INVALID_GEOMETRY_ID);
    std::fill_n(hit.geomID, kWidth, RTC_INVALID_GEOMETRY_ID);
    std::fill_n(hit.instID[0], kWidth, RTC_INVALID_GEOMETRY_ID);
  }
  const std::span rays(groups.data(), count);
  if (reach == Reach::kEverything) {
    intersect(handles_->actors.get(), rays);
  }
  intersect(handles_->meshes[0].get(), rays);
  for (std::size_t group = 0; group < count; ++group) {
    read_hits(groups[group], group * kWidth, packet);
  }
}

void RayWorld::trace_shadow(RayPacket& packet) const {
  std::array<RTCRay8, kGroups> groups;
  const std::size_t count = groups_of(packet);
  if (count == 0) {
    return;
  }
  packet.direction_x.fill(to_sun_.x());
  packet.direction_y.fill(to_sun_.y());
  packet.direction_z.fill(to_sun_.z());
  for (std::size_t group = 0; group < count; ++group) {
    fill_rays(packet, group * kWidth, groups[group]);
  }
  const std::span rays(groups.data(), count);
  if (may_be_shaded_by_actor(packet)) {
    occlude(handles_->actors.get(), rays);
  }
  occlude(handles_->meshes[0].get(), rays);
  for (std::size_t i = 0; i < count * kWidth; ++i) {
    packet.blocked[i] = groups[i / kWidth].tfar[i % kWidth] < 0.F;
  }
}

bool RayWorld::meets_part(std::size_t part, const Eigen::Vector3f& origin, const Eigen::Vector3f& direction) const {
  const Part& target = parts_[part];
  const Eigen::Vector3f local_origin = target.R_scene_part.transpose() * (origin - target.t_scene_part);
  const Eigen::Vector3f local_direction = target.R_scene_part.transpose() * direction;
  RTCRay ray{};
  ray.org_x = local_origin.x();
  ray.org_y = local_origin.y();
  ray.org_z = local_origin.z();
  ray.dir_x = local_direction.x();
  ray.dir_y = local_direction.y();
  ray.dir_z = local_direction.z();
  ray.tfar = kFar;
  ray.mask = ~0U;
  occlude(handles_->meshes[part].get(), ray);
  return ray.tfar < 0.F;
}

}  // namespace kinetrace::simulator
