// The plugin kinetrace-opencv-dnn.so: computes networks by OpenCV's dnn, and disparities by its semi-global matching.
#include <algorithm>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <opencv2/calib3d.hpp>
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

/// Semi-global matching (Hirschmueller 2008), with the parameters of apps/training/stereo.py.
cv::Ptr<cv::StereoSGBM> make_matcher(int levels) {
  constexpr int kBlock_px = 5;
  constexpr int kSmallStepCost = 8 * kBlock_px * kBlock_px;
  constexpr int kStepCost = 32 * kBlock_px * kBlock_px;
  constexpr int kLeftRightDifference_px = 1;
  constexpr int kMaxGradient = 31;
  constexpr int kUniqueness_percent = 10;
  constexpr int kSpeckle_px = 50;
  constexpr int kSpeckleStep_px = 2;
  return cv::StereoSGBM::create(0, levels, kBlock_px, kSmallStepCost, kStepCost, kLeftRightDifference_px, kMaxGradient,
                                kUniqueness_percent, kSpeckle_px, kSpeckleStep_px, cv::StereoSGBM::MODE_SGBM_3WAY);
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

  Status match(std::span<const std::uint8_t> left, std::span<const std::uint8_t> right, int width_px,
               std::span<std::int16_t> disparity) override {
    const ForeignCall guard;
    const int height_px = static_cast<int>(disparity.size()) / width_px;
    // OpenCV leaves out the first columns, as many as levels.
    const auto widened = [&](std::span<const std::uint8_t> image, cv::Mat& wide) {
      const cv::Mat given(height_px, width_px, CV_8U, const_cast<std::uint8_t*>(image.data()));
      cv::copyMakeBorder(given, wide, 0, 0, kLevels, 0, cv::BORDER_REPLICATE);
    };
    try {
      widened(left, left_);
      widened(right, right_);
      matcher_->compute(left_, right_, disparity_);
    } catch (const cv::Exception& exception) {
      return fail(ErrorCode::kUnsupported, "OpenCV cannot match the pictures: " + reason_of(exception));
    }
    for (int y = 0; y < height_px; ++y) {
      std::copy_n(disparity_.ptr<std::int16_t>(y) + kLevels, width_px, disparity.data() + std::ptrdiff_t{y} * width_px);
    }
    return {};
  }

 private:
  static constexpr int kLevels = kMaxDisparity / kDisparityFraction;

  ModelConfig model_;
  cv::dnn::Net net_;
  std::vector<cv::String> names_;
  std::vector<cv::Mat> outputs_;
  std::vector<Tensor> tensors_;
  cv::Ptr<cv::StereoSGBM> matcher_ = make_matcher(kLevels);
  cv::Mat left_;
  cv::Mat right_;
  cv::Mat disparity_;
};

// Replaces the name of a size in an ONNX file by its value, in place: a Dimension of onnx.proto3 has either field 1, a
// varint, or field 2, text; the varint is padded to the length of the text. The first one is that of the input.
void give_size(std::string& onnx, std::string_view name, int size) {
  const std::string named = std::string{'\x12', static_cast<char>(name.size())} + std::string(name);
  const std::size_t at = onnx.find(std::string{'\x0A', static_cast<char>(named.size())} + named);
  if (at == std::string::npos) {
    return;
  }
  const std::size_t first = at + 2;
  const std::size_t last = first + named.size() - 1;
  onnx[first] = '\x08';
  auto rest = static_cast<unsigned>(size);
  for (std::size_t i = first + 1; i <= last; ++i, rest >>= 7U) {
    onnx[i] = static_cast<char>((rest & 0x7FU) | (i < last ? 0x80U : 0U));
  }
}

// Throws cv::Exception.
cv::dnn::Net read_network(const ModelConfig& model) {
  switch (model.family) {
    case ModelFamily::kMaskRcnn: return cv::dnn::readNetFromTensorflow(model.file, model.graph);
    case ModelFamily::kKinetraceSeg: {
      // OpenCV 4.10 computes all shapes while it reads, with 0 for a size that is only named: then nothing fits.
      std::ifstream in(model.file, std::ios::binary);
      std::string onnx{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
      give_size(onnx, "height", model.input.height_px);
      give_size(onnx, "width", model.input.width_px);
      return cv::dnn::readNetFromONNX(onnx.data(), onnx.size());
    }
    default: return cv::dnn::readNetFromONNX(model.file);
  }
}

Result<std::unique_ptr<Runtime>> make_opencv_runtime(const ModelConfig& model, int threads) {
  const ForeignCall guard;
  // Errors are reported once, by the caller.
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  cv::setNumThreads(threads);
  try {
    return std::unique_ptr<Runtime>(std::make_unique<OpencvRuntime>(model, read_network(model)));
  } catch (const cv::Exception& exception) {
    return failed(model.file, exception);
  }
}

}  // namespace
}  // namespace kinetrace::neural

extern "C" [[gnu::visibility("default")]] kinetrace::neural::MakeRuntime kinetrace_runtime_plugin() {
  return &kinetrace::neural::make_opencv_runtime;
}
