// Prints the finalised camera path of a rendered drive with one moving box, and the box's path, so that a test can
// compare instruction sets.
#include <cstdio>

#include "kinetrace/core/cpu.hpp"
#include "pipeline_run.hpp"

int main() {
  using namespace kinetrace;
  test::PipelineRun run(test::small_config(segmentation::SegmentationMode::kMotion));
  run.drive(test::StreetDrive({test::Mover{.velocity_mps = {1.0, 0.0, 8.0}}}), 0, 24);
  run.drain();
  std::printf("%s\n", kernel_isa());
  const auto print = [](const char* what, std::int64_t frame, const Eigen::Vector3d& p) {
    std::printf("%s %lld %.9f %.9f %.9f\n", what, static_cast<long long>(frame), p.x(), p.y(), p.z());
  };
  for (const test::KeptEstimate& estimate : run.finalised) {
    print("camera", estimate.frame_index, estimate.camera.T_world_cam.translation);
    for (const ObjectResult& object : estimate.objects) {
      print("object", estimate.frame_index, object.T_world_obj.translation);
    }
  }
  return 0;
}
