// Static surroundings of a street: added to a world mesh. Ground is y = 0, y points down, metres.
#pragma once

#include <cstdint>

#include "world/mesh.hpp"

namespace kinetrace::simulator {

/// A rectangle on the ground: x and z are ranges.
struct GroundArea {
  float x0 = 0.F;
  float x1 = 0.F;
  float z0 = 0.F;
  float z1 = 0.F;
};

/// A horizontal sheet, `height_m` above the ground.
void add_ground(Mesh& mesh, const GroundArea& area, float height_m, const Paint& paint);
/// A slab with vertical sides: sidewalks with their curbs.
void add_slab(Mesh& mesh, const GroundArea& area, float height_m, const Paint& top, const Paint& sides);
/// Dashes along z about `x`.
void add_lane_marks(Mesh& mesh, float x, float z0, float z1, float dash_m, float gap_m);
/// Stripes of a crossing over a street along z: the stripes are parallel to z.
void add_crosswalk(Mesh& mesh, float x0, float x1, float z);
/// Covers and mended places strewn over a street.
void add_road_wear(Mesh& mesh, const GroundArea& area, int count, std::uint32_t seed);

/// A house with windows, ledges and a gabled or flat roof. Its ridge runs along the longer side.
void add_building(Mesh& mesh, const GroundArea& area, float height_m, bool gabled, std::uint16_t seed);
/// Trunk and a crown of several rough balls.
void add_tree(Mesh& mesh, float x, float z, float height_m, std::uint16_t seed);
/// A row of clipped bushes.
void add_hedge(Mesh& mesh, const GroundArea& area, float height_m, std::uint16_t seed);
/// A street lamp reaching over `reach_m` along x.
void add_lamp(Mesh& mesh, float x, float z, float reach_m, std::uint16_t seed);
/// A traffic sign facing -z.
void add_sign(Mesh& mesh, float x, float z, std::uint16_t seed);
/// Posts and rails along z.
void add_fence(Mesh& mesh, float x, float z0, float z1, std::uint16_t seed);

}  // namespace kinetrace::simulator
