// Scenes on which an estimator fails that is not careful. The camera's pose may be lost in them, but never wrong; what
// stands still never moves; and nothing takes memory after start.
#include <algorithm>
#include <cmath>
#include <memory>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "simulated_sequence.hpp"
#include "temp_folder.hpp"

namespace kinetrace::test {
namespace {

constexpr int kWidth_px = 560;

class Sequence {
 public:
  Sequence(const std::string& scene, int frames) : sequence_(folder_.path() / scene, scene, frames, kWidth_px) {}
  [[nodiscard]] const SimulatedSequence* operator->() const { return &sequence_; }

 private:
  TempFolder folder_;
  SimulatedSequence sequence_;
};

bool is_tracked(const FollowedFrame& frame) {
  return frame.camera.status == BodyStatus::kTracked;
}

struct CameraErrors {
  int tracked = 0;
  double step_m = 0.0;   ///< The largest of a step between two frames that are both said to be tracked.
  double step_deg = 0.0;
};

CameraErrors camera_errors(const Followed& followed) {
  CameraErrors errors;
  for (std::size_t i = 1; i < followed.settled.size(); ++i) {
    const FollowedFrame& before = followed.settled[i - 1];
    const FollowedFrame& now = followed.settled[i];
    if (!is_tracked(before) || !is_tracked(now)) {
      continue;
    }
    ++errors.tracked;
    const Se3 step = before.camera.T_world_cam.inverse() * now.camera.T_world_cam;
    const Se3 true_step = before.T_world_cam_true.inverse() * now.T_world_cam_true;
    const Se3 error = true_step.inverse() * step;
    errors.step_m = std::max(errors.step_m, error.translation.norm());
    errors.step_deg = std::max(errors.step_deg, so3_log(error.rotation).norm() * 180.0 / M_PI);
  }
  return errors;
}

std::set<std::uint32_t> moving_ids(const Followed& followed) {
  std::set<std::uint32_t> ids;
  for (const FollowedFrame& frame : followed.settled) {
    for (const ObjectResult& object : frame.objects) {
      if (object.moving) {
        ids.insert(object.track_id);
      }
    }
  }
  return ids;
}

TEST(HardScenes, P) {
  for (const auto& [scene, frames] : {std::pair{"dark", 30}, {"textureless", 40}, {"pure-rotation", 50}, {"object-fills-image", 60}, {"static", 20}}) {
    const Sequence s(scene, frames);
    for (int m = 0; m < 2; ++m) {
      const Followed f = s->follow(m == 0 ? s->masked() : SimulatedSequence::by_motion());
      const CameraErrors e = camera_errors(f);
      printf("%s %d tracked %d step %.3f m %.3f deg moving %zu lost %zu\n", scene, m, e.tracked, e.step_m, e.step_deg, moving_ids(f).size(), (size_t)f.counters.background_lost_frames);
    }
  }
}

}  // namespace
}  // namespace kinetrace::test
