#include "kinetrace/neural/instance_network.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <system_error>
#include <utility>
#include <vector>

#include "candidates.hpp"
#include "disparity_channel.hpp"
#include "heads.hpp"
#include "kinetrace/core/config_check.hpp"
#include "kinetrace/core/files.hpp"
#include "letterbox.hpp"
#include "mask_assembly.hpp"
#include "onnx_summary.hpp"
#include "runtime.hpp"

namespace kinetrace::neural {
namespace {

constexpr int kMaskRcnnGrid = 64;  // Side; larger than any in use.

Status check(const ModelConfig& model, const NetworkOptions& options) {
  if (Status valid = model.validate(); !valid) {
    return valid;
  }
  if (Status valid = check_range("segmentation.onnx.threads", options.threads, 1, 16); !valid) {
    return valid;
  }
  for (const std::string& file : {model.file, model.graph}) {
    std::error_code error;
    if (!file.empty() && !std::filesystem::is_regular_file(file, error)) {
      return unreachable(file, "there is no such model");
    }
  }
  return {};
}

std::string text_of(const std::vector<std::int64_t>& sizes) {
  std::string text;
  for (const std::int64_t size : sizes) {
    text += (text.empty() ? "" : ", ") + (size == 0 ? std::string("any") : std::to_string(size));
  }
  return "[" + text + "]";
}

Status check_operators(const ModelConfig& model, const OnnxSummary& onnx) {
  // Operators that OpenCV 4.6 refuses.
  constexpr std::array kRejected{"Einsum", "GridSample", "NonMaxSuppression", "NonZero", "RoiAlign", "TopK", "Where"};
  for (const char* rejected : kRejected) {
    if (std::binary_search(onnx.operators.begin(), onnx.operators.end(), rejected)) {
      return fail(ErrorCode::kUnsupported,
                  model.file + ": OpenCV 4.6 has no operator " + rejected +
                      "; export the model without its own non-maximum suppression (nms=False), or cut the graph "
                      "before it: Kinetrace does the rest itself");
    }
  }
  if (onnx.has_uneven_split) {
    return fail(ErrorCode::kUnsupported, model.file +
                                             ": OpenCV 4.6 computes a Split into unequal parts wrongly at opset " +
                                             std::to_string(onnx.opset) + "; export the model with opset 12");
  }
  return {};
}

Status check_input(const ModelConfig& model, const OnnxSummary& onnx) {
  const ModelInput& input = model.input;
  std::vector<std::int64_t> described{1, input.channels(), input.height_px, input.width_px};
  const bool has_any_size = onnx.input.size() == described.size() && onnx.input[2] == 0 && onnx.input[3] == 0;
  if (model.family == ModelFamily::kKinetraceSeg && has_any_size) {
    described[2] = described[3] = 0;
  } else if (std::find(onnx.input.begin(), onnx.input.end(), 0) != onnx.input.end()) {
    return fail(ErrorCode::kUnsupported,
                model.file + ": its input " + text_of(onnx.input) +
                    " has no fixed size; export it with one (dynamic=False, imgsz=" + std::to_string(input.height_px) +
                    "," + std::to_string(input.width_px) + "), or say family: kinetrace-seg if it is of that");
  }
  if (onnx.input != described) {
    return fail(ErrorCode::kInvalidConfig, model.file + ": its input is " + text_of(onnx.input) +
                                               ", the YAML file beside it says " + text_of(described) +
                                               " (1, channels, height, width); correct the YAML file");
  }
  return {};
}

Status check_file(const ModelConfig& model) {
  if (model.family == ModelFamily::kMaskRcnn) {
    return std::filesystem::path(model.file).extension() == ".onnx"
               ? Status(fail(ErrorCode::kInvalidConfig,
                             model.file + ": family mask-rcnn takes a frozen graph of TensorFlow (.pb), not an ONNX "
                                          "model; name the graph, or another family"))
               : Status();
  }
  const Result<OnnxSummary> onnx = summarize_onnx(model.file);
  if (!onnx) {
    return Unexpected(onnx.error());
  }
  if (!onnx->weights_not_finite.empty()) {
    return fail(ErrorCode::kBadFormat, model.file + ": weights \"" + onnx->weights_not_finite +
                                           "\" are not finite numbers; the training diverged, or the file is damaged");
  }
  return first_failure({check_operators(model, *onnx), check_input(model, *onnx)});
}

// The model with its input sized for pictures of the options' size.
ModelConfig sized(ModelConfig model, const NetworkOptions& options) {
  model.input = model.input.sized_for(options.max_width_px, options.max_height_px);
  return model;
}

// Largest grid of the network's masks, before they are drawn.
GridSize largest_grid(const ModelConfig& model) {
  constexpr int kFinest_px = *std::min_element(kPrototypeStrides_px.begin(), kPrototypeStrides_px.end());
  return model.family == ModelFamily::kMaskRcnn
             ? GridSize{kMaskRcnnGrid, kMaskRcnnGrid}
             : GridSize{model.input.width_px / kFinest_px, model.input.height_px / kFinest_px};
}

bool is_finite(const Tensor& tensor) {
  return std::all_of(tensor.values.begin(), tensor.values.end(), [](float value) { return std::isfinite(value); });
}

}  // namespace

struct InstanceNetwork::State {
  ModelConfig model;
  NetworkOptions options;
  std::unique_ptr<Runtime> runtime;
  HeadLayout layout;
  Letterbox letterbox;
  std::span<float> input;
  // Only with a channel of disparities.
  DisparityChannel disparity;
  std::span<float> grey;
  std::span<float> other_grey;
  CandidateList candidates;
  MaskAssembly assembly;
  NetworkCounters counters;

  void carve(Arena& arena) {
    const ModelInput& size = model.input;
    const auto pixels = static_cast<std::size_t>(size.width_px) * static_cast<std::size_t>(size.height_px);
    letterbox = Letterbox(size, options.max_width_px, options.max_height_px, arena);
    input = arena.take<float>(pixels * static_cast<std::size_t>(size.channels()));
    if (size.disparity) {
      disparity = DisparityChannel(size, arena);
      grey = arena.take<float>(pixels);
      other_grey = arena.take<float>(pixels);
    }
    candidates = CandidateList(arena, kMaxCandidates);
    assembly = MaskAssembly(kMaxInstances, kMaxRuns, largest_grid(model), arena);
  }

  /// Writes the tensor of a part of the pictures. Errors: those of Runtime::match.
  Status fill_input(const StereoPicture& pictures, const PixelBox& part_px, const Placement& placement) {
    const Picture part = pictures.picture.part(part_px);
    letterbox.fill(part, placement, input);
    if (!model.input.disparity) {
      return {};
    }
    const std::span<float> channel = input.last(grey.size());
    if (pictures.other.data == nullptr) {
      std::fill(channel.begin(), channel.end(), 0.F);
      return {};
    }
    letterbox.fill_grey(part, placement, grey);
    letterbox.fill_grey(pictures.other.part(part_px), placement, other_grey);
    return disparity.fill(grey, other_grey, pictures.view, *runtime, channel);
  }

  /// Errors: those of create() that only show in a run.
  Status try_out() {
    std::fill(input.begin(), input.end(), 0.5F);
    const Result<std::span<const Tensor>> outputs = runtime->run(input);
    if (!outputs) {
      return Unexpected(outputs.error());
    }
    Result<HeadLayout> found = HeadLayout::find(model, *outputs);
    if (!found) {
      return Unexpected(found.error());
    }
    if (found->kind == HeadLayout::Kind::kDetections &&
        std::max(found->mask_width, found->mask_height) > kMaskRcnnGrid) {
      return fail(ErrorCode::kUnsupported, model.file + ": masks of more than 64x64 are not supported");
    }
    if (!std::all_of(outputs->begin(), outputs->end(), is_finite)) {
      return fail(ErrorCode::kBadFormat, model.file +
                                             ": its answer to a grey picture is not finite; its weights are "
                                             "damaged, or input.scale, mean and std are not what it expects");
    }
    layout = *found;
    return {};
  }
};

InstanceNetwork::InstanceNetwork(std::unique_ptr<State> state) : state_(std::move(state)) {}
InstanceNetwork::~InstanceNetwork() = default;

std::size_t InstanceNetwork::required_bytes(const ModelConfig& model, const NetworkOptions& options) {
  return measure_bytes([&](Arena& arena) {
    State state;
    state.model = sized(model, options);
    state.options = options;
    state.carve(arena);
  });
}

Result<std::unique_ptr<InstanceNetwork>> InstanceNetwork::create(const ModelConfig& described,
                                                                 const NetworkOptions& options, Arena& arena) {
  if (const Status fits = check(described, options); !fits) {
    return Unexpected(fits.error());
  }
  const ModelConfig model = sized(described, options);
  if (const Status usable = check_file(model); !usable) {
    return Unexpected(usable.error());
  }
  const Result<MakeRuntime> make = load_runtime(options.runtime);
  if (!make) {
    return Unexpected(make.error());
  }
  auto runtime = (*make)(model, options.threads);
  if (!runtime) {
    return Unexpected(runtime.error());
  }
  auto state = std::make_unique<State>();
  state->model = model;
  state->options = options;
  state->runtime = std::move(*runtime);
  state->carve(arena);
  if (arena.exhausted()) {
    return fail(ErrorCode::kCapacity, "segmentation.onnx: the arena does not hold " +
                                          std::to_string(required_bytes(model, options)) +
                                          " bytes; size it with InstanceNetwork::required_bytes");
  }
  if (const Status works = state->try_out(); !works) {
    return Unexpected(works.error());
  }
  return std::unique_ptr<InstanceNetwork>(new InstanceNetwork(std::move(state)));
}

Result<std::span<const RunLengthMask>> InstanceNetwork::segment(const Picture& picture) {
  return segment(StereoPicture{picture});
}

Result<std::span<const RunLengthMask>> InstanceNetwork::segment(const StereoPicture& pictures) {
  return segment(pictures, {0, 0, pictures.picture.width_px, pictures.picture.height_px});
}

Result<std::span<const RunLengthMask>> InstanceNetwork::segment(const StereoPicture& pictures,
                                                                const PixelBox& part_px) {
  State& state = *state_;
  const Picture& picture = pictures.picture;
  if (picture.width_px > state.options.max_width_px || picture.height_px > state.options.max_height_px) {
    return fail(ErrorCode::kInvalidArgument, "segmentation.onnx: a picture of " + std::to_string(picture.width_px) +
                                                 "x" + std::to_string(picture.height_px) +
                                                 " pixels is not what the network was made for");
  }
  const Picture& other = pictures.other;
  if (other.data != nullptr && (other.width_px != picture.width_px || other.height_px != picture.height_px)) {
    return fail(ErrorCode::kInvalidArgument,
                "segmentation.onnx: the pictures of a pair differ in size, " + std::to_string(picture.width_px) + "x" +
                    std::to_string(picture.height_px) + " and " + std::to_string(other.width_px) + "x" +
                    std::to_string(other.height_px) + " pixels");
  }
  if (part_px.empty() || part_px.x0 < 0 || part_px.y0 < 0 || part_px.x1 > picture.width_px ||
      part_px.y1 > picture.height_px) {
    return fail(ErrorCode::kInvalidArgument,
                "segmentation.onnx: the part to look at is empty, or not in the picture of " +
                    std::to_string(picture.width_px) + "x" + std::to_string(picture.height_px) + " pixels");
  }
  const PlacedPicture placed{picture.width_px, picture.height_px, part_px,
                             Placement::of(part_px.width(), part_px.height(), state.model.input)};
  if (const Status filled = state.fill_input(pictures, part_px, placed.placement); !filled) {
    return Unexpected(filled.error());
  }
  const Result<std::span<const Tensor>> outputs = state.runtime->run(state.input);
  if (!outputs) {
    return Unexpected(outputs.error());
  }
  state.candidates.clear();
  decode(state.layout, state.model, *outputs, state.candidates);
  state.candidates.suppress(state.model.thresholds.overlap);
  state.assembly.clear();
  for (Candidate candidate : state.candidates.all()) {
    const ModelClass& named = state.model.classes[static_cast<std::size_t>(candidate.class_index)];
    candidate.score = named.calibration.probability(candidate.score);
    state.counters.instances_dropped +=
        state.assembly.add(candidate, named.class_id, state.layout, (*outputs)[state.layout.masks], placed) ? 0 : 1;
  }
  ++state.counters.pictures;
  state.counters.instances += state.assembly.masks().size();
  state.counters.candidates_dropped += state.candidates.dropped();
  return state.assembly.masks();
}

const NetworkCounters& InstanceNetwork::counters() const noexcept {
  return state_->counters;
}

}  // namespace kinetrace::neural
