#include "run/run_tally.hpp"

#include <algorithm>

#include "cli/formatted.hpp"

namespace kinetrace::app {

void RunTally::add(const FrameEstimate& finalised) noexcept {
  add_camera(finalised.camera.T_world_cam.translation);
  for (const ObjectResult& object : finalised.objects) {
    add_object(object.track_id, object.status, object.moving);
  }
}

void RunTally::add_camera(const Eigen::Vector3d& position_m) noexcept {
  if (found_.poses++ > 0) {
    found_.camera_path_m += (position_m - camera_m_).norm();
  }
  camera_m_ = position_m;
}

void RunTally::add_object(std::uint32_t track_id, BodyStatus status, bool moving) noexcept {
  if (status == BodyStatus::kInitializing || status == BodyStatus::kLost) {
    return;
  }
  Seen& object = seen(track_id);
  object.last = ++rows_;
  found_.objects_moved += moving && !object.moved ? 1 : 0;
  object.moved = object.moved || moving;
}

RunTally::Seen& RunTally::seen(std::uint32_t track_id) noexcept {
  const auto known =
      std::find_if(seen_.begin(), seen_.end(), [&](const Seen& one) { return one.track_id == track_id; });
  if (known != seen_.end()) {
    return *known;
  }
  ++found_.objects;
  Seen& oldest =
      *std::min_element(seen_.begin(), seen_.end(), [](const Seen& a, const Seen& b) { return a.last < b.last; });
  oldest = {.track_id = track_id};
  return oldest;
}

std::string geometry_text(const StereoGeometry& rectified) {
  return formatted("%dx%d pixels, focal length %.1f px, baseline %.3g m", rectified.width_px, rectified.height_px,
                   rectified.fx_px, rectified.baseline_m);
}

std::string found_text(const recording::FoundSummary& found, bool looked_for) {
  const std::string camera = formatted("camera: %.2f m in %llu frames; objects: ", found.camera_path_m,
                                       static_cast<unsigned long long>(found.poses));
  if (!looked_for) {
    return camera + "not looked for, segmentation is none";
  }
  return camera + (found.objects == 0 ? std::string("none")
                                      : std::to_string(found.objects) + ", of which " +
                                            std::to_string(found.objects_moved) + " moved");
}

}  // namespace kinetrace::app
