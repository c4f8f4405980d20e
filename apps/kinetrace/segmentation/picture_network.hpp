// A neural network for single pictures of any sizes.
#pragma once

#include <memory>
#include <optional>
#include <span>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/instance_masks.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/neural/instance_network.hpp"
#include "kinetrace/neural/model.hpp"
#include "kinetrace/neural/picture.hpp"

namespace kinetrace::app {

/// A network whose input follows the pictures' size (`input.pixels`) is loaded again where a picture needs another
/// input than the picture before.
class PictureNetwork {
 public:
  /// `threads` as in neural::NetworkOptions; pictures of at most `max_side_px` on either side.
  PictureNetwork(neural::ModelConfig model, int threads, int max_side_px);

  /// Loads the network for pictures of this size, unless it is loaded. Errors: those of InstanceNetwork::create.
  [[nodiscard]] Status prepare(int width_px, int height_px);
  /// The instances of a picture of the size that was prepared. They live until the next call. Errors: those of
  /// InstanceNetwork::segment.
  [[nodiscard]] Result<std::span<const RunLengthMask>> segment(const neural::StereoPicture& pictures);

 private:
  neural::ModelConfig model_;
  neural::NetworkOptions options_;
  neural::ModelInput input_;  ///< Of the loaded network.
  std::optional<Arena> arena_;
  std::unique_ptr<neural::InstanceNetwork> network_;
};

}  // namespace kinetrace::app
