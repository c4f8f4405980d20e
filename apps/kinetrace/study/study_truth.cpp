#include "study/study_truth.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

namespace kinetrace::app {
namespace {

constexpr double kUnitsPerMetre = 256.0;
constexpr double kMaxDepthRatio = 1.02;

}  // namespace

std::optional<double> TrueImages::depth_at(double x_px, double y_px, std::uint8_t label) const {
  const LabelView labels = masks.masks().labels;
  const int x0 = static_cast<int>(std::floor(x_px));
  const int y0 = static_cast<int>(std::floor(y_px));
  if (!labels.contains(x0, y0) || !labels.contains(x0 + 1, y0 + 1) || !depth.contains(x0 + 1, y0 + 1)) {
    return std::nullopt;
  }
  double inverse_depth = 0.0;
  std::uint16_t nearest = 0xFFFF;
  std::uint16_t farthest = 0;
  for (const auto& [dx, dy] : {std::array{0, 0}, std::array{1, 0}, std::array{0, 1}, std::array{1, 1}}) {
    const std::uint16_t value = depth.at(x0 + dx, y0 + dy);
    if (labels.at(x0 + dx, y0 + dy) != label || value == 0) {
      return std::nullopt;
    }
    nearest = std::min(nearest, value);
    farthest = std::max(farthest, value);
    const double weight = (1.0 - std::abs(x_px - x0 - dx)) * (1.0 - std::abs(y_px - y0 - dy));
    inverse_depth += weight * kUnitsPerMetre / value;
  }
  if (farthest > kMaxDepthRatio * nearest) {
    return std::nullopt;
  }
  return 1.0 / inverse_depth;
}

Result<StudyTruth> StudyTruth::open(const std::filesystem::path& recording) {
  StudyTruth study;
  study.directory_ = recording / "truth";
  evaluation::TruthSource source;
  source.path = study.directory_;
  source.format = evaluation::TruthFormat::kSimulator;
  Result<evaluation::Truth> truth = evaluation::read_truth(source);
  if (!truth) {
    return Unexpected(truth.error());
  }
  study.truth_ = std::move(*truth);
  return study;
}

std::optional<Se3> StudyTruth::camera_pose(std::int64_t frame) const {
  return truth_.camera.at(frame, 0, 0);
}

std::vector<evaluation::LocatedObject> StudyTruth::objects(std::int64_t frame) const {
  std::vector<evaluation::LocatedObject> chosen;
  if (const auto entry = truth_.objects.find(frame); entry != truth_.objects.end()) {
    std::copy_if(entry->second.begin(), entry->second.end(), std::back_inserter(chosen),
                 [](const evaluation::LocatedObject& o) { return o.object.rigid && o.object.moving; });
  }
  return chosen;
}

std::optional<evaluation::LocatedObject> StudyTruth::object(std::int64_t frame, std::uint32_t id) const {
  for (const evaluation::LocatedObject& candidate : objects(frame)) {
    if (candidate.object.id == id) {
      return candidate;
    }
  }
  return std::nullopt;
}

Result<TrueImages> StudyTruth::images(std::int64_t frame) {
  std::array<char, 32> name{};
  std::snprintf(name.data(), name.size(), "%010lld.png", static_cast<long long>(frame));
  Result<evaluation::MotsImage> masks = mots_.read(directory_ / "masks" / "instances_left" / name.data());
  if (!masks) {
    return Unexpected(masks.error());
  }
  const Result<ImageView<const std::uint16_t>> depth = depths_.read(directory_ / "depth" / "left" / name.data());
  if (!depth) {
    return Unexpected(depth.error());
  }
  return TrueImages{std::move(*masks), *depth};
}

}  // namespace kinetrace::app
