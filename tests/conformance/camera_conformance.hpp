// What every StereoCamera must do, whatever it is made of. A camera joins by instantiating the suite with a bench:
// INSTANTIATE_TEST_SUITE_P(MyCamera, CameraConformance, ::testing::Values(&make_my_bench)).
#pragma once

#include <memory>

#include <gtest/gtest.h>

#include "kinetrace/hal/stereo_camera.hpp"

namespace kinetrace::hal::test {

/// A closed camera that will deliver at least three frames once started, and all that it needs to live.
class CameraBench {
 public:
  CameraBench() = default;
  CameraBench(const CameraBench&) = delete;
  CameraBench& operator=(const CameraBench&) = delete;
  CameraBench(CameraBench&&) = delete;
  CameraBench& operator=(CameraBench&&) = delete;
  virtual ~CameraBench() = default;
  [[nodiscard]] virtual StereoCamera& camera() = 0;
};

using MakeCameraBench = std::unique_ptr<CameraBench> (*)();
class CameraConformance : public ::testing::TestWithParam<MakeCameraBench> {
 protected:
  std::unique_ptr<CameraBench> bench_ = GetParam()();
  StereoCamera& camera_ = bench_->camera();
};

}  // namespace kinetrace::hal::test
