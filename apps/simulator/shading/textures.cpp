// Dispatch from materials to textures.
#include "shading/textures.hpp"

namespace kinetrace::simulator::KINETRACE_KERNEL_ISA {
namespace {

Looks raw_look(const Paint& paint, const Points& point) {
  switch (paint.material) {
    case Material::kAsphalt:
    case Material::kRoadMark:
    case Material::kPatch:
    case Material::kManhole:
    case Material::kSidewalk:
    case Material::kCurb: return road_look(paint, point);
    case Material::kBrickFacade:
    case Material::kPlasterFacade:
    case Material::kConcrete:
    case Material::kRoofTiles:
    case Material::kMetal:
    case Material::kWood:
    case Material::kSign: return building_look(paint, point);
    case Material::kGrass:
    case Material::kGravel:
    case Material::kFoliage:
    case Material::kBark: return nature_look(paint, point);
    case Material::kCarBody:
    case Material::kTruckBox:
    case Material::kTyre:
    case Material::kRim:
    case Material::kMirror: return vehicle_look(paint, point);
    case Material::kCloth:
    case Material::kTrousers:
    case Material::kHair:
    case Material::kSkin:
    case Material::kShoe: return person_look(paint, point);
    case Material::kCardboard:
    case Material::kFloorTiles:
    case Material::kPanelWall:
    case Material::kPoster:
    case Material::kPlain: return interior_look(paint, point);
  }
  return {};
}

}  // namespace

Looks look_of(const Paint& paint, const Points& points) {
  Looks look = raw_look(paint, points);
  look.albedo = clamp(look.albedo * paint.tone, 0.01F, 0.95F);
  return look;
}

}  // namespace kinetrace::simulator::KINETRACE_KERNEL_ISA
