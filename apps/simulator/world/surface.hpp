// Materials and paints of surfaces.
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

/// Painted details of a vehicle: heights above the ground, widths relative to half the vehicle's.
struct BodyTrim {
  float paint = -1.F;  ///< Albedo; below 0, one of eight by the seed.
  float paint_gloss = 0.05F;
  float glass = 0.02F;  ///< Albedo of the interior visible through it.
  float glass_gloss = 0.055F;
  bool has_rear_window = true;
  int pillars = 1;  ///< Number that divide the side windows, from the front.
  float pillar_pitch_m = 1.1F;
  float sill_m = 0.3F;
  float strip_m = 0.52F;
  float plate_front_m = 0.42F;
  float plate_rear_m = 0.42F;
  float grille_low_m = 0.55F;
  float grille_high_m = 0.72F;
  float grille_half = 0.45F;
  float headlamp_m = 0.66F;
  float headlamp_radius_m = 0.17F;
  float headlamp_squeeze = 1.7F;  ///< Ratio of width to height.
  float headlamp_out = 0.72F;
  float rear_lamp_low_m = 0.64F;
  float rear_lamp_high_m = 0.88F;
  float rear_lamp_out = 0.58F;  ///< Where it begins.
  float print = -1.F;           ///< Albedo of writing on the sides; below 0, none.
};

/// Vehicle dimensions for the placement of painted details.
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
  float clearance_m = 0.17F;
  float lean = 0.24F;      ///< Of the side windows inwards, for their height.
  float rounding = 0.16F;  ///< Narrowing of the ends, relative to the width.
  BodyTrim trim = {};
};

struct Paint {
  Material material = Material::kPlain;
  std::uint16_t seed = 0;            ///< Varies colours and patterns between objects of one material.
  const BodyShape* shape = nullptr;  ///< For vehicle materials; outlives the mesh.
  float tone = 1.F;                  ///< Factor to the albedo.

  [[nodiscard]] bool operator==(const Paint&) const = default;
};

/// A point on a surface, in the frame of its body.
struct SurfacePoint {
  Eigen::Vector3f position;
  Eigen::Vector3f normal;  ///< Unit length; smooth across an edge where its triangles share vertices.
  Eigen::Vector2f uv;      ///< Metres along and up the face, for textures that follow it.

  /// All numbers, to be interpolated at once.
  using Numbers = Eigen::Array<float, 8, 1>;
  [[nodiscard]] Eigen::Map<const Numbers> numbers() const noexcept {
    return Eigen::Map<const Numbers>(reinterpret_cast<const float*>(this));
  }
  [[nodiscard]] Eigen::Map<Numbers> numbers() noexcept { return Eigen::Map<Numbers>(reinterpret_cast<float*>(this)); }
};
static_assert(sizeof(SurfacePoint) == sizeof(SurfacePoint::Numbers));

}  // namespace kinetrace::simulator
