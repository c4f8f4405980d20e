// A frame's way through the modules: rectified stereo in, camera and object trajectories out.
#pragma once

#include <memory>
#include <string_view>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/effort.hpp"
#include "kinetrace/core/export.hpp"
#include "kinetrace/core/frame.hpp"
#include "kinetrace/core/frame_result.hpp"
#include "kinetrace/core/instance_masks.hpp"
#include "kinetrace/core/memory_plan.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/core/stage.hpp"
#include "kinetrace/core/workers.hpp"
#include "kinetrace/pipeline/config.hpp"

namespace kinetrace::pipeline {

/// The whole method, one frame at a time and deterministic: same input, same output, bit for bit, with any number of
/// workers.
class KINETRACE_API Pipeline {
 public:
  /// Bytes that `create` takes from the arena, by module; for mode auto, those with a network. Errors: kInvalidConfig.
  [[nodiscard]] static Result<MemoryPlan> plan(const PipelineConfig& config, const StereoGeometry& geometry);

  /// Takes all working memory from `arena`; afterwards the pipeline never allocates. `makers` of masks must outlive it;
  /// only segmentation.mode dds and onnx need one, and auto uses one if present: then the result depends on which masks
  /// arrive in time. `workers`, if any, share the most expensive stages, and must outlive it too. Errors:
  /// kInvalidConfig (which key), kCapacity (arena too small), kNotFound (mask folder).
  [[nodiscard]] static Result<Pipeline> create(const PipelineConfig& config, const StereoGeometry& geometry,
                                               Arena& arena, const MaskMakers& makers = {}, Workers* workers = nullptr);

  Pipeline(Pipeline&&) noexcept;
  Pipeline& operator=(Pipeline&&) noexcept;
  ~Pipeline();

  /// Processes one pair. The result lives until the next call. Errors: kInvalidArgument (size differs from the
  /// geometry, time does not advance). A bad image is no error: it shows as status in the result.
  [[nodiscard]] Result<const FrameResult*> process(const RectifiedPair& pair, StageObserver* observer = nullptr);

  /// Bounds the cost of the next frames, until called again. Without a call it is as configured.
  void limit(const Effort& effort) noexcept;

  /// The first mask file that was missing or could not be used: which, and why. Empty if there was none.
  [[nodiscard]] std::string_view mask_complaint() const noexcept;

  /// After the last frame: call until it returns nullptr. Each call gives one more finalised frame (`has_finalised`
  /// true, `newest` repeats the last frame, images empty); the first also carries, as retired, every point still alive.
  [[nodiscard]] const FrameResult* drain();

 private:
  struct Impl;
  explicit Pipeline(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace kinetrace::pipeline
