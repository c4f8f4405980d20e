// What a surface is made of.
#pragma once

#include <cstdint>

#include <Eigen/Core>

namespace kinetrace::simulator {

enum class Material : std::uint8_t {
  kAsphalt,
  kRoadMark,
  kPatch,
  kManhole,
  kSidewalk,
  kCurb,
  kGrass,
  kGravel,
  kBrickFacade,
  kPlasterFacade,
  kConcrete,
  kRoofTiles,
  kFoliage,
  kBark,
  kMetal,
  kWood,
  kSign,
  kCarBody,
  kTruckBox,
  kTyre,
  kRim,
  kMirror,
  kCloth,
  kTrousers,
  kHair,
  kSkin,
  kShoe,
  kCardboard,
  kFloorTiles,
  kPanelWall,
  kPoster,
  kPlain,
};

/// The dimensions that a vehicle's painted details follow.
struct BodyShape {
  float length_m = 4.4F;
  float height_m = 1.5F;
  float width_m = 1.8F;
  float belt_m = 0.95F;  ///< Height where the windows begin.
  float wheel_radius_m = 0.32F;
  float front_axle_m = 1.3F;  ///< x of the axles.
  float rear_axle_m = -1.3F;
  float windscreen_m = 0.9F;        ///< x of the windscreen's foot ...
  float windscreen_top_m = 0.2F;    ///< ... and top.
  float rear_window_m = -1.9F;      ///< x of the rear window's foot ...
  float rear_window_top_m = -1.3F;  ///< ... and top.
  bool has_rear_side_windows = true;
  float origin_x_m = 0.F;  ///< Middle of this shape in the vehicle's frame; all other x are relative to it.
};

struct Paint {
  Material material = Material::kPlain;
  std::uint16_t seed = 0;            ///< Varies colours and patterns between things of one material.
  const BodyShape* shape = nullptr;  ///< For vehicle materials; outlives the mesh.
};

/// A point on a surface, in the frame of the body it belongs to.
struct SurfacePoint {
  Eigen::Vector3f position;
  Eigen::Vector3f normal;  ///< Unit length; smooth across an edge where its triangles share vertices.
  Eigen::Vector2f uv;      ///< Metres along and up the face, for textures that follow it.

  /// All of it, to be interpolated in one go.
  using Numbers = Eigen::Array<float, 8, 1>;
  [[nodiscard]] Eigen::Map<const Numbers> numbers() const noexcept {
    return Eigen::Map<const Numbers>(reinterpret_cast<const float*>(this));
  }
  [[nodiscard]] Eigen::Map<Numbers> numbers() noexcept { return Eigen::Map<Numbers>(reinterpret_cast<float*>(this)); }
};
static_assert(sizeof(SurfacePoint) == sizeof(SurfacePoint::Numbers));

}  // namespace kinetrace::simulator
