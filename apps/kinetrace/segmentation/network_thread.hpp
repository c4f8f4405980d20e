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
  bool right = false;  ///< Segments the right image, too.
  bool waits = true;   ///< Wait for masks: for recordings; a camera would lose frames meanwhile.
  /// A frame that takes longer counts as hung: the network is abandoned.
  std::chrono::milliseconds timeout{5000};
};

struct NetworkThreadCounters {
  std::uint64_t frames = 0;  ///< Answered.
  std::uint64_t failed = 0;  ///< Of these: with an error.
  double median_ms = 0.0;    ///< Per frame, both views, over the last 256.
  double longest_ms = 0.0;
};

/// Segments one frame at a time in a thread of its own, which also loads the network, so that all allocations of the
/// runtime happen there. It owns its memory, so that a hung network can be abandoned.
class NetworkThread final : public DelayedMaskSource {
 public:
  /// Returns after the network was loaded and has run once. Errors: those of InstanceNetwork::create.
  [[nodiscard]] static Result<std::unique_ptr<NetworkThread>> create(const NetworkThreadConfig& config,
                                                                     const StereoGeometry& geometry);
  ~NetworkThread() override;

  void offer(const RectifiedPair& pair, const PixelBox& region_px) noexcept override;
  [[nodiscard]] DelayedMasks take() noexcept override;

  /// Growth of the resident set by the network at the start: libraries, weights, layers, buffers.
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
