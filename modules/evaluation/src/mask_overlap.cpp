#include "kinetrace/evaluation/mask_overlap.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <string>

namespace kinetrace::evaluation {
namespace {

constexpr std::size_t kLabels = 256;
constexpr std::uint16_t kMotsIgnore = 10000;
constexpr std::uint16_t kMotsClassStep = 1000;

Status check_instances(const InstanceMasks& masks, const std::string& whose) {
  for (std::size_t i = 0; i < masks.instances.size(); ++i) {
    const MaskInstance& instance = masks.instances[i];
    const std::string name = whose + " instance " + std::to_string(instance.id);
    if (instance.label == kBackgroundLabel || instance.label == kIgnoreLabel) {
      return fail(ErrorCode::kInvalidArgument,
                  name + ": label " + std::to_string(instance.label) + " is no instance's; use 1 to 254");
    }
    for (const MaskInstance& other : masks.instances.first(i)) {
      if (other.label == instance.label || other.id == instance.id) {
        return fail(ErrorCode::kInvalidArgument, name + ": shares its " + (other.id == instance.id ? "id" : "label") +
                                                     " with another instance of the frame; give each its own");
      }
    }
  }
  return {};
}

Status check_sizes(LabelView truth, LabelView result) {
  if (truth.empty() || result.empty() || (truth.width == result.width && truth.height == result.height)) {
    return {};
  }
  const auto size = [](LabelView view) { return std::to_string(view.width) + " x " + std::to_string(view.height); };
  return fail(ErrorCode::kInvalidArgument, "masks of " + size(truth) + " pixels in truth, " + size(result) +
                                               " in the result; evaluate a run of the same rectified images");
}

/// Number of pixels with each pair of labels.
class PixelCounts {
 public:
  PixelCounts(LabelView truth, LabelView result) : counts_(kLabels * kLabels) {
    const LabelView any = truth.empty() ? result : truth;
    for (int y = 0; y < (any.empty() ? 0 : any.height); ++y) {
      for (int x = 0; x < any.width; ++x) {
        const std::size_t t = truth.empty() ? kBackgroundLabel : truth.row(y)[x];
        const std::size_t r = result.empty() ? kBackgroundLabel : result.row(y)[x];
        ++counts_[t * kLabels + r];
        ++truth_[t];
        ++result_[r];
      }
    }
  }
  [[nodiscard]] double both(std::size_t truth, std::size_t result) const { return counts_[truth * kLabels + result]; }
  [[nodiscard]] double truth(std::size_t label) const { return truth_[label]; }
  [[nodiscard]] double result(std::size_t label) const { return result_[label]; }

 private:
  std::vector<std::uint32_t> counts_;
  std::array<std::uint32_t, kLabels> truth_{};
  std::array<std::uint32_t, kLabels> result_{};
};

}  // namespace

Result<MotsImage> label_mots_image(ImageView<const std::uint16_t> image) {
  std::map<std::uint16_t, std::uint8_t> label_of_value;
  for (int y = 0; y < image.height; ++y) {
    std::uint16_t last = 0;
    for (int x = 0; x < image.width; ++x) {
      const std::uint16_t value = image.row(y)[x];
      if (value != last && value != 0) {
        label_of_value.emplace(value, kIgnoreLabel);
      }
      last = value;
    }
  }
  MotsImage mots{{}, image.width, image.height, {}};
  for (auto& [value, label] : label_of_value) {
    if (value == kMotsIgnore) {
      continue;
    }
    if (mots.instances.size() + 1 == kIgnoreLabel) {
      return fail(ErrorCode::kCapacity, "mask image with more than 254 instances; evaluate fewer at once");
    }
    label = static_cast<std::uint8_t>(mots.instances.size() + 1);
    mots.instances.push_back({label, value, static_cast<std::uint16_t>(value / kMotsClassStep)});
  }
  mots.labels.reserve(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const std::uint16_t value = image.row(y)[x];
      mots.labels.push_back(value == 0 ? kBackgroundLabel : label_of_value.at(value));
    }
  }
  return mots;
}

Result<MaskOverlap> overlap_masks(const InstanceMasks& truth, const InstanceMasks& result) {
  for (const Status& status : {check_instances(truth, "true"), check_instances(result, "resulting"),
                               check_sizes(truth.labels, result.labels)}) {
    if (!status) {
      return Unexpected(status.error());
    }
  }
  const PixelCounts counts(truth.labels, result.labels);
  const auto rows = static_cast<Eigen::Index>(truth.instances.size());
  const auto columns = static_cast<Eigen::Index>(result.instances.size());
  MaskOverlap overlap{Eigen::MatrixXd::Zero(rows, columns), Eigen::VectorXd(rows), Eigen::VectorXd(columns),
                      Eigen::VectorXd::Zero(columns)};
  for (Eigen::Index i = 0; i < rows; ++i) {
    overlap.truth_area_px(i) = counts.truth(truth.instances[static_cast<std::size_t>(i)].label);
  }
  for (Eigen::Index j = 0; j < columns; ++j) {
    const std::uint8_t label = result.instances[static_cast<std::size_t>(j)].label;
    const double area_px = counts.result(label);
    overlap.result_area_px(j) = area_px;
    if (area_px > 0.0) {
      overlap.ignored(j) = counts.both(kIgnoreLabel, label) / area_px;
    }
    for (Eigen::Index i = 0; i < rows; ++i) {
      const double shared_px = counts.both(truth.instances[static_cast<std::size_t>(i)].label, label);
      if (shared_px > 0.0) {
        overlap.iou(i, j) = shared_px / (overlap.truth_area_px(i) + area_px - shared_px);
      }
    }
  }
  return overlap;
}

}  // namespace kinetrace::evaluation
