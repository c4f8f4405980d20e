// Requirements on every StereoCamera, whatever it is made of. A camera joins by instantiating the suite with a bench:
// INSTANTIATE_TEST_SUITE_P(My, CameraConformance, ::testing::Values(CameraKind{"Camera", &make_my_bench}),
// name_of_kind).
#pragma once

#include <memory>
#include <ostream>
#include <string>

#include <gtest/gtest.h>

#include "kinetrace/hal/stereo_camera.hpp"

namespace kinetrace::hal::test {

/// A closed camera that delivers at least three frames once started, with all its dependencies.
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

struct CameraKind {
  const char* name;
  std::unique_ptr<CameraBench> (*make)();
};
inline std::ostream& operator<<(std::ostream& stream, const CameraKind& kind) {
  return stream << kind.name;
}
inline std::string name_of_kind(const ::testing::TestParamInfo<CameraKind>& info) {
  return info.param.name;
}

class CameraConformance : public ::testing::TestWithParam<CameraKind> {
 protected:
  std::unique_ptr<CameraBench> bench_ = GetParam().make();
  StereoCamera& camera_ = bench_->camera();
};

}  // namespace kinetrace::hal::test
