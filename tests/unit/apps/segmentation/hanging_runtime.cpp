// A runtime that answers twice, as at the start, and then never again.
#include <chrono>
#include <cstdint>
#include <memory>
#include <thread>
#include <utility>
#include <vector>

#include "runtime.hpp"

namespace kinetrace::neural {
namespace {

class HangingRuntime final : public Runtime {
 public:
  explicit HangingRuntime(const ModelInput& input) {
    const int cells = input.width_px * input.height_px / 64 * 21 / 16;
    boxes_.resize(static_cast<std::size_t>(4 + 2 + 1) * static_cast<std::size_t>(cells));
    masks_.resize(static_cast<std::size_t>(input.width_px * input.height_px / 16));
    outputs_ = {{.values = boxes_, .sizes = {1, 4 + 2 + 1, cells}, .rank = 3},
                {.values = masks_, .sizes = {1, 1, input.height_px / 4, input.width_px / 4}, .rank = 4}};
  }
  Result<std::span<const Tensor>> run(std::span<const float> /*input*/) override {
    if (++runs_ > 2) {
      std::this_thread::sleep_for(std::chrono::hours(1));
    }
    return std::span<const Tensor>(outputs_);
  }
  Status match(std::span<const std::uint8_t> /*left*/, std::span<const std::uint8_t> /*right*/, int /*width_px*/,
               std::span<std::int16_t> /*disparity*/) override {
    return {};
  }

 private:
  int runs_ = 0;
  std::vector<float> boxes_;
  std::vector<float> masks_;
  std::vector<Tensor> outputs_;
};

Result<std::unique_ptr<Runtime>> make_hanging_runtime(const ModelConfig& model, int /*threads*/) {
  return std::unique_ptr<Runtime>(std::make_unique<HangingRuntime>(model.input));
}

}  // namespace
}  // namespace kinetrace::neural

extern "C" [[gnu::visibility("default")]] kinetrace::neural::MakeRuntime kinetrace_runtime_plugin() {
  return &kinetrace::neural::make_hanging_runtime;
}
