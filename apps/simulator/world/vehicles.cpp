#include "world/vehicles.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace kinetrace::simulator {
namespace {

using Eigen::Vector3f;

constexpr std::array<OutlinePoint, 12> kHatchbackOutline{{{-0.5F, 0.42F},
                                                          {-0.495F, 0.58F},
                                                          {-0.47F, 0.68F},
                                                          {-0.38F, 0.92F},
                                                          {-0.3F, 0.98F},
                                                          {-0.1F, 1.F},
                                                          {0.03F, 0.98F},
                                                          {0.24F, 0.7F},
                                                          {0.36F, 0.63F},
                                                          {0.45F, 0.56F},
                                                          {0.49F, 0.47F},
                                                          {0.5F, 0.35F}}};
constexpr std::array<OutlinePoint, 12> kSedanOutline{{{-0.5F, 0.4F},
                                                      {-0.495F, 0.6F},
                                                      {-0.46F, 0.69F},
                                                      {-0.33F, 0.71F},
                                                      {-0.18F, 0.96F},
                                                      {-0.08F, 1.F},
                                                      {0.02F, 0.98F},
                                                      {0.2F, 0.7F},
                                                      {0.34F, 0.63F},
                                                      {0.45F, 0.56F},
                                                      {0.49F, 0.47F},
                                                      {0.5F, 0.35F}}};
constexpr std::array<OutlinePoint, 10> kVanOutline{{{-0.5F, 0.3F},
                                                    {-0.497F, 0.9F},
                                                    {-0.48F, 0.98F},
                                                    {-0.1F, 1.F},
                                                    {0.18F, 0.98F},
                                                    {0.24F, 0.94F},
                                                    {0.36F, 0.58F},
                                                    {0.45F, 0.5F},
                                                    {0.49F, 0.42F},
                                                    {0.5F, 0.28F}}};
constexpr std::array<OutlinePoint, 8> kCabOutline{{{-0.5F, 0.3F},
                                                   {-0.49F, 0.95F},
                                                   {-0.4F, 1.F},
                                                   {0.2F, 0.99F},
                                                   {0.36F, 0.93F},
                                                   {0.46F, 0.5F},
                                                   {0.495F, 0.42F},
                                                   {0.5F, 0.22F}}};
constexpr std::array<OutlinePoint, 8> kBusOutline{{{-0.5F, 0.12F},
                                                   {-0.498F, 0.9F},
                                                   {-0.49F, 0.98F},
                                                   {-0.2F, 1.F},
                                                   {0.47F, 0.99F},
                                                   {0.488F, 0.94F},
                                                   {0.497F, 0.4F},
                                                   {0.5F, 0.12F}}};

const VehicleDesign& design_of(VehicleKind kind) {
  static const VehicleDesign hatchback{
      {4.2F, 1.48F, 1.8F, 0.96F, 0.31F, 1.28F, -1.3F, 0.98F, 0.1F, -1.98F, -1.5F, true}, kHatchbackOutline};
  static const VehicleDesign sedan{{4.7F, 1.45F, 1.84F, 0.97F, 0.32F, 1.42F, -1.4F, 0.94F, 0.05F, -1.55F, -0.75F, true},
                                   kSedanOutline};
  static const VehicleDesign van{{5.2F, 2.1F, 1.98F, 1.15F, 0.34F, 1.65F, -1.6F, 1.85F, 1.1F, -2.5F, -2.5F, false},
                                 kVanOutline};
  // The shape is that of the cab alone, at the front of the truck.
  static const VehicleDesign truck{
      {2.0F, 2.3F, 2.1F, 1.35F, 0.42F, 0.1F, -4.7F, 0.88F, 0.66F, -0.9F, -0.9F, false, 2.5F}, kCabOutline, 5.0F, 2.9F};
  static const VehicleDesign bus{{.length_m = 11.F,
                                  .height_m = 3.F,
                                  .width_m = 2.5F,
                                  .belt_m = 1.25F,
                                  .wheel_radius_m = 0.48F,
                                  .front_axle_m = 3.2F,
                                  .rear_axle_m = -2.7F,
                                  .windscreen_m = 5.46F,
                                  .windscreen_top_m = 5.3F,
                                  .rear_window_m = -5.46F,
                                  .rear_window_top_m = -5.4F,
                                  .clearance_m = 0.32F,
                                  .lean = 0.04F,
                                  .rounding = 0.04F,
                                  .trim = {.pillars = 8, .pillar_pitch_m = 1.25F}},
                                 kBusOutline};
  switch (kind) {
    case VehicleKind::kHatchback: return hatchback;
    case VehicleKind::kSedan: return sedan;
    case VehicleKind::kVan: return van;
    case VehicleKind::kTruck: return truck;
    case VehicleKind::kBus: return bus;
  }
  return hatchback;
}

// Half width of the body along its length: rounded in plan.
float plan_half_width(const BodyShape& shape, float x) {
  const float end = std::abs(x) / (0.5F * shape.length_m);
  return 0.5F * shape.width_m * (1.F - shape.rounding * std::pow(end, 6.F));
}

// One closed cross-section: up the left side, down the right side.
std::vector<Vector3f> section(const BodyShape& shape, float x, float top) {
  const float half = plan_half_width(shape, x);
  const float belt = std::min(shape.belt_m, top);
  const float glass = top - belt;  // Height of the part with windows, if any.
  const float lean = shape.lean * glass;
  const float low = shape.clearance_m;
  const std::array<std::array<float, 2>, 8> left{{{0.8F * half, low},
                                                  {0.97F * half, low + 0.1F},
                                                  {half, 0.5F * (low + belt)},
                                                  {0.97F * half, belt - 0.02F},
                                                  {0.95F * half - lean * 0.5F, belt + 0.45F * glass},
                                                  {0.94F * half - lean, belt + 0.85F * glass},
                                                  {0.8F * half - lean, top - 0.02F * (glass > 0.F ? 1.F : 0.3F)},
                                                  {0.3F * half, top}}};
  std::vector<Vector3f> ring;
  for (const auto& [z, height] : left) {
    ring.emplace_back(x, -height, z);
  }
  for (std::size_t i = left.size(); i-- > 0;) {
    ring.emplace_back(x, -left[i][1], -left[i][0]);
  }
  return ring;
}

// The outline with intermediate points: a smooth skin needs short faces.
std::vector<std::vector<Vector3f>> sections(const VehicleDesign& design) {
  constexpr int kSteps = 3;
  std::vector<std::vector<Vector3f>> rings;
  const auto add = [&](float x, float height) {
    rings.push_back(section(design.shape, x * design.shape.length_m, height * design.shape.height_m));
  };
  for (std::size_t i = 0; i + 1 < design.outline.size(); ++i) {
    const OutlinePoint& from = design.outline[i];
    const OutlinePoint& to = design.outline[i + 1];
    for (int step = 0; step < kSteps; ++step) {
      const float t = static_cast<float>(step) / kSteps;
      add(from.x + (to.x - from.x) * t, from.height + (to.height - from.height) * t);
    }
  }
  add(design.outline.back().x, design.outline.back().height);
  return rings;
}

void add_wheel(Mesh& mesh, float x, float z, float radius, std::uint16_t seed) {
  constexpr float kWidth_m = 0.2F;
  const float side = z > 0.F ? 1.F : -1.F;
  const Vector3f outer(x, -radius, z);
  mesh.add_cylinder(outer, outer - Vector3f(0.F, 0.F, side * kWidth_m), radius, radius, 24, {Material::kTyre});
  mesh.add_cylinder(outer + Vector3f(0.F, 0.F, side * 0.012F), outer, 0.66F * radius, 0.68F * radius, 24,
                    {Material::kRim, seed});
}

void add_wheels(Mesh& mesh, const BodyShape& shape, std::uint16_t seed) {
  const float half_width = 0.5F * shape.width_m + 0.005F;
  for (const float z : {half_width, -half_width}) {
    add_wheel(mesh, shape.origin_x_m + shape.front_axle_m, z, shape.wheel_radius_m, seed);
    add_wheel(mesh, shape.origin_x_m + shape.rear_axle_m, z, shape.wheel_radius_m, seed);
  }
}

void add_mirrors(Mesh& mesh, const BodyShape& shape, const Paint& paint) {
  for (const float side : {1.F, -1.F}) {
    mesh.add_ellipsoid({shape.windscreen_m - 0.25F, -shape.belt_m - 0.06F, side * (0.5F * shape.width_m + 0.06F)},
                       {0.08F, 0.08F, 0.11F}, 6, {Material::kMirror, paint.seed, paint.shape});
  }
}

void add_truck_box(Mesh& mesh, const VehicleDesign& design, std::uint16_t seed) {
  const float floor_m = design.box_floor_m;
  const float middle_x = -0.5F * design.shape.length_m;
  const float height = design.box_height_m - floor_m;
  mesh.add_box({middle_x, -floor_m - 0.5F * height, 0.F},
               {design.box_length_m - 0.15F, height, design.shape.width_m + 0.15F},
               {design.box, seed, nullptr, design.box_tone});
  mesh.add_box({middle_x, 0.13F - floor_m, 0.F}, {design.box_length_m, 0.2F, 0.9F}, {Material::kTyre});
}

}  // namespace

Mesh vehicle_mesh(const VehicleDesign& design, std::uint16_t seed, std::uint16_t rim_seed) {
  const BodyShape& shape = design.shape;
  const Paint paint{Material::kCarBody, seed, &shape};
  Mesh skin;
  skin.add_loft(sections(design), paint);
  add_mirrors(skin, shape, paint);
  Mesh mesh;
  mesh.append(skin, Eigen::Matrix3f::Identity(), {shape.origin_x_m, 0.F, 0.F});
  if (design.box_length_m > 0.F) {
    add_truck_box(mesh, design, seed);
  }
  add_wheels(mesh, shape, rim_seed);
  return mesh;
}

Mesh vehicle_mesh(VehicleKind kind, std::uint16_t seed) {
  return vehicle_mesh(design_of(kind), seed);
}

Vector3f vehicle_size_m(VehicleKind kind) {
  return vehicle_size_m(design_of(kind));
}

Vector3f vehicle_size_m(const VehicleDesign& design) {
  return {design.shape.length_m + design.box_length_m, std::max(design.shape.height_m, design.box_height_m),
          design.shape.width_m + (design.box_length_m > 0.F ? 0.15F : 0.F)};
}

}  // namespace kinetrace::simulator
