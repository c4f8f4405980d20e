#include "segmentation/picture_network.hpp"

#include <utility>

namespace kinetrace::app {

PictureNetwork::PictureNetwork(neural::ModelConfig model, int threads, int max_side_px)
    : model_(std::move(model)),
      options_{.threads = threads, .max_width_px = max_side_px, .max_height_px = max_side_px} {}

Status PictureNetwork::prepare(int width_px, int height_px) {
  const neural::ModelInput input = model_.input.sized_for(width_px, height_px);
  if (network_ != nullptr && input.width_px == input_.width_px && input.height_px == input_.height_px) {
    return {};
  }
  neural::ModelConfig sized = model_;
  sized.input = input_ = input;
  network_.reset();  // Before its memory.
  arena_.emplace(neural::InstanceNetwork::required_bytes(sized, options_));
  auto network = neural::InstanceNetwork::create(sized, options_, *arena_);
  if (!network) {
    return Unexpected(network.error());
  }
  network_ = std::move(*network);
  return {};
}

Result<std::span<const RunLengthMask>> PictureNetwork::segment(const neural::StereoPicture& pictures) {
  return network_->segment(pictures);
}

}  // namespace kinetrace::app
