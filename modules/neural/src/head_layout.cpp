#include <algorithm>
#include <string>
#include <vector>

#include "heads.hpp"

namespace kinetrace::neural {
namespace {

constexpr int kDistanceBins = 16;
constexpr std::array<int, 3> kStrides{8, 16, 32};

std::string text_of(const Tensor& tensor) {
  std::string text = "[";
  for (const int size : tensor.shape()) {
    text += (text.size() > 1 ? ", " : "") + std::to_string(size);
  }
  return text + "]";
}

std::string text_of(std::span<const Tensor> outputs) {
  std::string text;
  for (const Tensor& output : outputs) {
    text += (text.empty() ? "" : ", ") + text_of(output);
  }
  return text.empty() ? "none" : text;
}

// Export command of the model's own tools for OpenCV.
std::string export_command(ModelFamily family) {
  switch (family) {
    case ModelFamily::kYolov5Seg:
      return "export it with `python export.py --weights yolov5n-seg.pt --include onnx --opset 12 --imgsz 640 640`";
    case ModelFamily::kYolov8Seg:
      return "export it with `yolo export model=yolov8n-seg.pt format=onnx opset=12 imgsz=640,640`";
    case ModelFamily::kYolo11Seg:
      return "export it with `yolo export model=yolo11n-seg.pt format=onnx opset=12 imgsz=640,640`";
    case ModelFamily::kKinetraceSeg: return "export it with `apps/training/train --only-export`";
    case ModelFamily::kMaskRcnn:
      return "take a frozen TensorFlow graph (.pb) with the .pbtxt that OpenCV's tf_text_graph_mask_rcnn.py makes of "
             "it";
  }
  return {};
}

Unexpected<Error> unfit(const ModelConfig& model, std::span<const Tensor> outputs) {
  return fail(ErrorCode::kUnsupported, model.file + ": outputs " + text_of(outputs) + " are not those of a " +
                                           std::string(to_string(model.family)) + " with input " +
                                           std::to_string(model.input.width_px) + "x" +
                                           std::to_string(model.input.height_px) + "; " + export_command(model.family) +
                                           ", or correct family and input in the YAML file beside it");
}

Unexpected<Error> wrong_classes(const ModelConfig& model, int found) {
  return fail(ErrorCode::kInvalidConfig,
              model.file + ": the network has " + std::to_string(found) + " classes, the YAML file beside it names " +
                  std::to_string(model.classes.size()) + "; name all of them, in the network's order");
}

class Finder {
 public:
  Finder(const ModelConfig& model, std::span<const Tensor> outputs)
      : model_(model), outputs_(outputs), classes_(static_cast<int>(model.classes.size())) {}

  [[nodiscard]] Result<HeadLayout> find() {
    if (model_.family == ModelFamily::kMaskRcnn) {
      return find_detections();
    }
    if (!find_prototypes()) {
      return unfit(model_, outputs_);
    }
    switch (model_.family) {
      case ModelFamily::kYolov5Seg: return find_yolov5();
      case ModelFamily::kKinetraceSeg: return find_cells();
      default: return find_yolov8();
    }
  }

 private:
  using Shape = std::vector<int>;

  [[nodiscard]] const Tensor* output(auto&& fits) const {
    const auto found = std::find_if(outputs_.begin(), outputs_.end(), fits);
    return found == outputs_.end() ? nullptr : &*found;
  }
  [[nodiscard]] std::size_t index_of(const Tensor* output) const {
    return static_cast<std::size_t>(output - outputs_.data());
  }
  [[nodiscard]] int cells(int stride) const {
    return (model_.input.width_px / stride) * (model_.input.height_px / stride);
  }
  [[nodiscard]] int all_cells() const { return cells(kStrides[0]) + cells(kStrides[1]) + cells(kStrides[2]); }

  bool find_prototypes() {
    for (const int stride : kPrototypeStrides_px) {
      const int width = model_.input.width_px / stride;
      const int height = model_.input.height_px / stride;
      const Tensor* prototypes = output([&](const Tensor& tensor) {
        return tensor.rank == 4 && tensor.sizes[0] == 1 && tensor.sizes[2] == height && tensor.sizes[3] == width;
      });
      if (prototypes != nullptr) {
        layout_.masks = index_of(prototypes);
        layout_.mask_count = prototypes->sizes[1];
        layout_.mask_width = width;
        layout_.mask_height = height;
        layout_.prototype_stride_px = stride;
        return true;
      }
    }
    return false;
  }

  [[nodiscard]] Result<HeadLayout> finish(HeadLayout::Kind kind, std::size_t boxes, int classes) {
    layout_.kind = kind;
    layout_.boxes[0] = boxes;
    if (classes != classes_) {
      return wrong_classes(model_, classes);
    }
    return layout_;
  }

  [[nodiscard]] Result<HeadLayout> find_yolov8() {
    const Tensor* columns = output([&](const Tensor& tensor) {
      return tensor.rank == 3 && tensor.sizes[2] == all_cells() && tensor.sizes[1] > 4 + layout_.mask_count;
    });
    if (columns != nullptr) {
      return finish(HeadLayout::Kind::kColumns, index_of(columns), columns->sizes[1] - 4 - layout_.mask_count);
    }
    const Tensor* coefficients = output([&](const Tensor& tensor) {
      return tensor.rank == 3 && tensor.sizes[2] == all_cells() && tensor.sizes[1] == layout_.mask_count;
    });
    const int channels = find_maps(4 * kDistanceBins);
    if (channels == 0 || coefficients == nullptr) {
      return unfit(model_, outputs_);
    }
    layout_.coefficients = index_of(coefficients);
    return finish(HeadLayout::Kind::kDistanceMaps, layout_.boxes[0], channels - 4 * kDistanceBins);
  }

  // Finds one map [1, channels, h, w] for each stride, with the same number of channels, more than `others`; 0 without.
  [[nodiscard]] int find_maps(int others) {
    int channels = 0;
    for (std::size_t level = 0; level < kStrides.size(); ++level) {
      const Tensor* map = output([&](const Tensor& tensor) {
        return tensor.rank == 4 && tensor.sizes[1] > others &&
               tensor.sizes[2] == model_.input.height_px / kStrides[level] &&
               tensor.sizes[3] == model_.input.width_px / kStrides[level];
      });
      if (map == nullptr || (level > 0 && map->sizes[1] != channels)) {
        return 0;
      }
      channels = map->sizes[1];
      layout_.boxes[level] = index_of(map);
    }
    layout_.levels = kStrides.size();
    return channels;
  }

  [[nodiscard]] Result<HeadLayout> find_cells() {
    const int channels = find_maps(4 + layout_.mask_count);
    return channels == 0 ? unfit(model_, outputs_)
                         : finish(HeadLayout::Kind::kCellMaps, layout_.boxes[0], channels - 4 - layout_.mask_count);
  }

  [[nodiscard]] Result<HeadLayout> find_yolov5() {
    const Tensor* rows = output([&](const Tensor& tensor) {
      return tensor.rank == 3 && tensor.sizes[1] == 3 * all_cells() && tensor.sizes[2] > 5 + layout_.mask_count;
    });
    if (rows != nullptr) {
      return finish(HeadLayout::Kind::kRows, index_of(rows), rows->sizes[2] - 5 - layout_.mask_count);
    }
    int channels = 0;
    for (std::size_t level = 0; level < kStrides.size(); ++level) {
      const Tensor* map = output([&](const Tensor& tensor) {
        return tensor.rank == 5 && tensor.sizes[1] == 3 && tensor.sizes[4] > 5 + layout_.mask_count &&
               tensor.sizes[2] == model_.input.height_px / kStrides[level] &&
               tensor.sizes[3] == model_.input.width_px / kStrides[level];
      });
      if (map == nullptr || (level > 0 && map->sizes[4] != channels)) {
        return unfit(model_, outputs_);
      }
      channels = map->sizes[4];
      layout_.boxes[level] = index_of(map);
    }
    layout_.levels = kStrides.size();
    return finish(HeadLayout::Kind::kAnchorMaps, layout_.boxes[0], channels - 5 - layout_.mask_count);
  }

  [[nodiscard]] Result<HeadLayout> find_detections() {
    const Tensor* rows = output([](const Tensor& tensor) { return tensor.rank == 4 && tensor.sizes[3] == 7; });
    const Tensor* masks =
        output([&](const Tensor& tensor) { return tensor.rank == 4 && tensor.sizes[3] != 7 && tensor.sizes[1] > 0; });
    if (rows == nullptr || masks == nullptr || masks->sizes[0] < rows->sizes[2]) {
      return unfit(model_, outputs_);
    }
    layout_.masks = index_of(masks);
    layout_.mask_count = masks->sizes[1];
    layout_.mask_height = masks->sizes[2];
    layout_.mask_width = masks->sizes[3];
    return finish(HeadLayout::Kind::kDetections, index_of(rows), masks->sizes[1]);
  }

  const ModelConfig& model_;
  std::span<const Tensor> outputs_;
  int classes_;
  HeadLayout layout_;
};

}  // namespace

Result<HeadLayout> HeadLayout::find(const ModelConfig& model, std::span<const Tensor> outputs) {
  return Finder(model, outputs).find();
}

}  // namespace kinetrace::neural
