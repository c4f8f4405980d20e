// The plugin kinetrace-opencv-dnn.so: computes networks by OpenCV's dnn.
#include <algorithm>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/dnn.hpp>

#include "kinetrace/core/allocation_counter.hpp"
#include "runtime.hpp"

namespace kinetrace::neural {
namespace {

// Extracts the reason from "OpenCV(4.6.0) ./modules/...:123: error: (-215:Assertion failed) reason in function 'f'".
std::string reason_of(const cv::Exception& exception) {
  std::string reason = exception.err;
  std::replace(reason.begin(), reason.end(), '\n', ' ');
  constexpr std::size_t kMax = 200;
  return reason.size() > kMax ? reason.substr(0, kMax) + "..." : reason;
}

Unexpected<Error> failed(const std::string& file, const cv::Exception& exception) {
  return fail(ErrorCode::kUnsupported, file + ": OpenCV cannot compute this network: " + reason_of(exception) +
                                           "; export it with opset 12 and a fixed input size");
}

class OpencvRuntime final : public Runtime {
 public:
  OpencvRuntime(const ModelConfig& model, const cv::dnn::Net& net) : model_(model), net_(net) {
    net_.setPreferableBackend(cv::dnn::DNN_BACKEND_OPENCV);
    net_.setPreferableTarget(cv::dnn::DNN_TARGET_CPU);
    if (model.family == ModelFamily::kMaskRcnn) {
      names_ = {"detection_out_final", "detection_masks"};
    } else {
      names_ = net_.getUnconnectedOutLayersNames();
    }
  }

  Result<std::span<const Tensor>> run(std::span<const float> input) override {
    const ForeignCall guard;
    const ModelInput& size = model_.input;
    const std::array<int, 4> shape{1, size.channels(), size.height_px, size.width_px};
    // OpenCV does not write to its input.
    const cv::Mat blob(4, shape.data(), CV_32F, const_cast<float*>(input.data()));
    try {
      net_.setInput(blob);
      net_.forward(outputs_, names_);
    } catch (const cv::Exception& exception) {
      return failed(model_.file, exception);
    }
    tensors_.clear();
    for (const cv::Mat& output : outputs_) {
      if (output.type() != CV_32F || !output.isContinuous() || output.dims > static_cast<int>(Tensor::kMaxRank)) {
        return fail(ErrorCode::kUnsupported, model_.file + ": an output is not a dense tensor of 32-bit floats");
      }
      Tensor tensor{.values = {output.ptr<float>(), output.total()}, .rank = static_cast<std::size_t>(output.dims)};
      std::copy_n(output.size.p, output.dims, tensor.sizes.begin());
      tensors_.push_back(tensor);
    }
    return std::span<const Tensor>(tensors_);
  }

 private:
  ModelConfig model_;
  cv::dnn::Net net_;
  std::vector<cv::String> names_;
  std::vector<cv::Mat> outputs_;
  std::vector<Tensor> tensors_;
};

Result<std::unique_ptr<Runtime>> make_opencv_runtime(const ModelConfig& model, int threads) {
  const ForeignCall guard;
  // Errors are reported once, by the caller.
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  cv::setNumThreads(threads);
  try {
    cv::dnn::Net net = model.family == ModelFamily::kMaskRcnn ? cv::dnn::readNetFromTensorflow(model.file, model.graph)
                                                              : cv::dnn::readNetFromONNX(model.file);
    return std::unique_ptr<Runtime>(std::make_unique<OpencvRuntime>(model, std::move(net)));
  } catch (const cv::Exception& exception) {
    return failed(model.file, exception);
  }
}

}  // namespace
}  // namespace kinetrace::neural

extern "C" [[gnu::visibility("default")]] kinetrace::neural::MakeRuntime kinetrace_runtime_plugin() {
  return &kinetrace::neural::make_opencv_runtime;
}
