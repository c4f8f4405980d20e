// The neural network beside the pipeline.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>

#include "kinetrace/core/instance_masks.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/core/stereo_geometry.hpp"
#include "kinetrace/neural/model.hpp"

namespace kinetrace::app {

struct NetworkThreadConfig {
  neural::ModelConfig model;
  std::string runtime = {};  ///< As NetworkOptions::runtime.
  int threads = 1;
  bool right = false;  ///< Looks at the right image too.
  bool waits = true;   ///< Recordings wait for masks; a camera would lose frames meanwhile.
  /// A frame that takes longer hangs: nobody waits for the network any more.
  std::chrono::milliseconds timeout{5000};
};

struct NetworkThreadCounters {
  std::uint64_t frames = 0;  ///< Answered.
  std::uint64_t failed = 0;  ///< Of these: with an error.
  double median_ms = 0.0;    ///< Of a frame, both views, over the last 256.
  double longest_ms = 0.0;
};

/// Segments one frame at a time in a thread of its own, which also loads the network, so that all that the runtime
/// allocates is allocated there. Its memory is its own: a network that hangs is left behind with all it has.
class NetworkThread final : public DelayedMaskSource {
 public:
  /// Returns when the network was loaded and has run once. Errors: those of InstanceNetwork::create.
  [[nodiscard]] static Result<std::unique_ptr<NetworkThread>> create(const NetworkThreadConfig& config,
                                                                     const StereoGeometry& geometry);
  ~NetworkThread() override;

  void offer(const RectifiedPair& pair, const PixelBox& region_px) noexcept override;
  [[nodiscard]] DelayedMasks take() noexcept override;

  /// By how much the resident set has grown through it, at the start: libraries, weights, layers, buffers.
  [[nodiscard]] std::size_t bytes() const noexcept { return bytes_; }
  /// For any thread.
  [[nodiscard]] NetworkThreadCounters counters() const;
  /// The first error of the network; empty if there was none.
  [[nodiscard]] std::string first_error() const;

 private:
  struct Shared;
  explicit NetworkThread(std::shared_ptr<Shared> shared);
  static void run(Shared& shared);

  std::shared_ptr<Shared> shared_;
  std::thread thread_;
  std::size_t bytes_ = 0;
  bool hangs_ = false;
};

}  // namespace kinetrace::app
