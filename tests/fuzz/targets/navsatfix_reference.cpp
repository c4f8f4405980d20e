// Fixes and poses over DDS, in any order and of any content: every pose put on the map must have a position.
#include <cmath>
#include <fuzzer/FuzzedDataProvider.h>

#include "fuzz_target.hpp"
#include "live_alignment.hpp"

namespace {

using namespace kinetrace;
using namespace kinetrace::fuzz;

constexpr std::int64_t kFarthest_ns = 4'000'000'000'000'000'000;  // Beyond, messages are left out.

/// A number near that of a continuing path, or any number.
double number(FuzzedDataProvider& values, double usual) {
  switch (values.ConsumeIntegralInRange(0, 3)) {
    case 0: return values.ConsumeFloatingPoint<double>();
    case 1: return values.ConsumeFloatingPointInRange(-1e4, 1e4);
    default: return usual + values.ConsumeFloatingPointInRange(-0.1, 0.1);
  }
}

Eigen::Vector3d numbers(FuzzedDataProvider& values, const Eigen::Vector3d& usual) {
  return {number(values, usual.x()), number(values, usual.y()), number(values, usual.z())};
}

class Follower {
 public:
  explicit Follower(FuzzedDataProvider& values)
      : values_(values),
        alignment_(geo::AlignmentWindow::create({.max_poses = 24, .max_fixes = 24}).value(), {}, std::nullopt,
                   values.ConsumeBool()) {}

  void step() {
    ++steps_;
    switch (values_.ConsumeIntegralInRange(0, 15)) {
      case 0: return alignment_.lose_camera();
      case 1: return alignment_.count_without_fix();
      case 2:
      case 3: return align();
      case 4:
      case 5:
      case 6:
      case 7:
      case 8: return add_fix();
      default: return add_pose();
    }
  }

 private:
  std::int64_t time_ns() {
    const bool is_usual = values_.ConsumeIntegralInRange(0, 7) > 0;
    return is_usual ? 100'000'000 * steps_ : values_.ConsumeIntegralInRange(-kFarthest_ns, kFarthest_ns);
  }
  void add_pose() {
    const std::int64_t timestamp_ns = time_ns();
    const Se3 T_world_cam{so3_exp(numbers(values_, {0.0, 0.05 * static_cast<double>(steps_), 0.0})),
                          numbers(values_, {0.3 * static_cast<double>(steps_), 0.0, 0.02 * steps_ * steps_})};
    if (T_world_cam.is_finite()) {
      alignment_.add_pose(values_.ConsumeBool() ? steps_ : values_.ConsumeIntegral<std::int64_t>(), timestamp_ns,
                          timestamp_ns + values_.ConsumeIntegralInRange(-1'000'000'000, 1'000'000'000), T_world_cam);
    }
  }
  void add_fix() {
    const double way = static_cast<double>(steps_);
    require(
        alignment_
            .add_fix(time_ns(),
                     {number(values_, 49.0 + 2e-6 * way), number(values_, 8.4 + 4e-6 * way), number(values_, 110.0)},
                     numbers(values_, {1.0, 1.0, 2.0}).cwiseSqrt())
            .has_value());
  }
  void align() {
    if (!alignment_.has_new_fixes()) {
      return;
    }
    map::AlignmentTask task;
    alignment_.fill(task);
    if (const Result<geo::Alignment> aligned = geo::align(task.path, task.fixes, task.config)) {
      alignment_.accept(task, *aligned);
    }
    if (alignment_.is_aligned()) {
      const map::MapPlace place = alignment_.place(numbers(values_, {10.0, 0.0, 20.0}));
      require(std::isfinite(place.geodetic.latitude_deg) && std::isfinite(place.geodetic.longitude_deg));
      require(std::isfinite(alignment_.horizontal_sigma_m()));
    }
  }

  FuzzedDataProvider& values_;
  map::LiveAlignment alignment_;
  std::int64_t steps_ = 0;
};

}  // namespace

void kinetrace::fuzz::try_input(std::string_view input) {
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast)
  FuzzedDataProvider values(reinterpret_cast<const std::uint8_t*>(input.data()), input.size());
  Follower follower(values);
  constexpr int kMaxSteps = 64;
  for (int i = 0; i < kMaxSteps && values.remaining_bytes() > 0; ++i) {
    follower.step();
  }
}
