// The part of Pipeline that plans its memory before construction.
#include "camera/rig_calibrator.hpp"
#include "fixed_lag_results.hpp"
#include "frame_result_builder.hpp"
#include "frame_scratch.hpp"
#include "kinetrace/features/feature_front_end.hpp"
#include "kinetrace/pipeline/pipeline.hpp"
#include "kinetrace/segmentation/segmenter.hpp"
#include "kinetrace/tracking/stereo_tracker.hpp"
#include "kinetrace/trajectory/ground_plane.hpp"
#include "object_set.hpp"
#include "resolved_config.hpp"
#include "window_refiner.hpp"

namespace kinetrace::pipeline {

Result<MemoryPlan> Pipeline::plan(const PipelineConfig& config, const StereoGeometry& geometry) {
  if (const Status valid = config.validate(); !valid) {
    return Unexpected(valid.error());
  }
  const PipelineConfig c = resolved(config);
  MemoryPlan plan;
  plan.entries = {
      {"calibration", RigCalibrator::required_bytes(c), "calibration.refine, features.max_features"},
      {"features", features::FeatureFrontEnd::required_bytes(c.features, geometry.width_px, geometry.height_px),
       "image size, features.max_features, features.pyramid_levels"},
      {"segmentation", segmentation::required_bytes(c.segmentation, geometry, c.features.max_features),
       "image size, segmentation.mode, segmentation.max_objects"},
      {"tracking", tracking::StereoTracker::required_bytes(c.tracking, geometry.width_px, geometry.height_px),
       "image size, tracking.max_objects"},
      {"background", sfm::BodyReconstruction::required_bytes(c.background) + measure_bytes([&](Arena& arena) {
                       trajectory::GroundEstimator(static_cast<std::size_t>(c.background.max_points), arena);
                     }),
       "background.max_points, background.window_frames"},
      {"objects", ObjectSet::required_bytes(c), "tracking.max_objects, object.max_points, object.window_frames"},
      {"refinement", WindowRefiner::required_bytes(c.refinement, c.object),
       "background.max_points, background.window_frames, object.max_points"},
      {"results", measure_bytes([&](Arena& arena) {
         static_cast<void>(FixedLagResults(c, arena));
         static_cast<void>(FrameResultBuilder(c, arena));
         static_cast<void>(FrameScratch(c, arena));
       }),
       "tracking.max_objects, background.window_frames"},
  };
  return plan;
}

}  // namespace kinetrace::pipeline
