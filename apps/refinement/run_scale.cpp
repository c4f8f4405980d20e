#include "run_scale.hpp"

namespace kinetrace::batch {

void scale_run(double scale, recording::Run& run) {
  run.rectified.baseline_m *= scale;
  for (recording::CameraRow& row : run.camera) {
    row.T_world_cam.translation *= scale;
  }
  for (recording::ObjectRow& row : run.objects) {
    row.T_world_obj.translation *= scale;
    row.velocity_mps *= scale;
    row.box.center_m *= scale;
    row.box.size_m *= scale;
    row.box_sigma.center_m *= scale;
    row.box_sigma.size_m *= scale;
    row.variances.tail<3>() *= scale * scale;
  }
}

}  // namespace kinetrace::batch
