#include "lens.hpp"

#include <gtest/gtest.h>

#include "board_scene.hpp"
#include "reprojection_cost.hpp"

namespace kinetrace::calibration {
namespace {

TEST(Lens, RaysLeadBackToTheirPixels) {
  for (const auto& [name, lens] : kLensNames) {
    const hal::CameraModel camera = test::true_rig(lens).left;
    for (double y = 0.0; y < camera.height_px; y += 40.0) {
      for (double x = 0.0; x < camera.width_px; x += 40.0) {
        // Corners of the fisheye image have rays beside the camera.
        const bool is_beside =
            lens == Lens::kFisheye && Eigen::Vector2d(x - camera.cx_px, y - camera.cy_px).norm() > 1.3 * camera.fx_px;
        if (is_beside) {
          continue;
        }
        const auto ray = normalised_ray(camera, {x, y});
        ASSERT_TRUE(ray) << name;
        EXPECT_LT((camera.project({ray->x(), ray->y(), 1.0}) - Eigen::Vector2d(x, y)).norm(), 1e-4) << name;
      }
    }
  }
}

TEST(Lens, HasNoRayBeyondWhatAFisheyeReaches) {
  hal::CameraModel camera = test::true_rig(Lens::kFisheye).left;
  camera.fx_px = camera.fy_px = 150.0;
  EXPECT_FALSE(normalised_ray(camera, {0.0, 0.0}));
  EXPECT_TRUE(normalised_ray(camera, {320.0, 240.0}));
}

TEST(Lens, TheEstimationProjectsAsTheCameraModelDoes) {
  for (const auto& [name, lens] : kLensNames) {
    const hal::CameraModel camera = test::true_rig(lens).right;
    std::array<double, 12> parameters{camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px};
    std::copy(camera.distortion.begin(), camera.distortion.end(), parameters.begin() + 4);
    for (const auto& [x, y] : {std::pair{0.0, 0.0}, {0.3, -0.2}, {-0.7, 0.5}}) {
      std::array<double, 2> px{};
      project(camera.lens, parameters.data(), x, y, px.data());
      EXPECT_LT((camera.project({x, y, 1.0}) - Eigen::Vector2d(px[0], px[1])).norm(), 1e-9) << name;
    }
  }
}

}  // namespace
}  // namespace kinetrace::calibration
