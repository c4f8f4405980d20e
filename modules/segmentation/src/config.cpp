#include "kinetrace/segmentation/config.hpp"

#include <algorithm>
#include <array>

#include "kinetrace/core/config_check.hpp"
#include "kinetrace/core/nearest_name.hpp"

namespace kinetrace::segmentation {

Status MotionConfig::validate() const {
  return first_failure({
      check_range("segmentation.motion.sigma_px", sigma_px, 0.01, 10.0),
      check_range("segmentation.motion.ego_sigma_px", ego_sigma_px, 0.0, 10.0),
      check_range("segmentation.motion.bias_disparity_px", bias_disparity_px, 0.0, 10.0),
      check_range("segmentation.motion.memory_s", memory_s, 0.05, 10.0),
      check_range("segmentation.motion.min_disparity_px", min_disparity_px, 0.5, 100.0),
      check_range("segmentation.motion.min_speed_mps", min_speed_mps, 0.0, 100.0),
      check_range("segmentation.motion.min_speed_ratio", min_speed_ratio, 0.0, 1.0),
      check_range("segmentation.motion.significance", significance, 1.0, 100.0),
      check_range("segmentation.motion.min_features", min_features, 2, 1000),
      check_range("segmentation.motion.link_distance_m", link_distance_m, 0.05, 100.0),
      check_range("segmentation.motion.confirm_frames", confirm_frames, 1, 100),
      check_range("segmentation.motion.hold_s", hold_s, 0.0, 1000.0),
  });
}

Status ExternalConfig::validate() const {
  return check_range("segmentation.dds.timeout_ms", timeout_ms, 0, 60'000);
}

Status NetworkConfig::validate() const {
  return first_failure({
      check_range("segmentation.onnx.latency_frames", latency_frames, 0, 100),
      check_range("segmentation.onnx.threads", threads, 1, 16),
      check_range("segmentation.onnx.regions", regions, 0, 4),
  });
}

Status SegmentationConfig::validate() const {
  if (mode == SegmentationMode::kMasks && left_dir.empty()) {
    return fail(ErrorCode::kInvalidConfig,
                "segmentation.left_dir must name the folder of left masks when segmentation.mode is masks");
  }
  return first_failure({
      check_range("segmentation.max_objects", max_objects, 1, kMaxObjects),
      check_range("segmentation.min_area_px", min_area_px, 1, 1000000),
      motion.validate(),
      dds.validate(),
      onnx.validate(),
  });
}

Result<SegmentationConfig> parse_segmentation(std::string_view text) {
  SegmentationConfig config;
  const std::string_view name = text.substr(0, text.find(':'));
  SegmentationMode named{};
  const bool is_named = from_string(name, named);
  if (is_named && name == text && named != SegmentationMode::kMasks) {
    config.mode = named;
    return config;
  }
  if (is_named && uses_network(named) && text.size() > name.size() + 1) {
    config.mode = named;
    config.onnx.model = text.substr(name.size() + 1);
    return config;
  }
  constexpr std::string_view kMasksPrefix = "masks:";
  if (text.starts_with(kMasksPrefix)) {
    const std::string_view dirs = text.substr(kMasksPrefix.size());
    const std::size_t comma = dirs.find(',');
    const std::string_view left = dirs.substr(0, comma);
    const std::string_view right = comma == std::string_view::npos ? std::string_view{} : dirs.substr(comma + 1);
    const bool right_is_bad = comma != std::string_view::npos && (right.empty() || right.find(',') != right.npos);
    if (!left.empty() && !right_is_bad) {
      config.mode = SegmentationMode::kMasks;
      config.left_dir = left;
      config.right_dir = right;
      return config;
    }
  }
  std::array<std::string_view, kSegmentationModes.size()> names;
  std::transform(kSegmentationModes.begin(), kSegmentationModes.end(), names.begin(),
                 [](SegmentationMode mode) { return to_string(mode); });
  return fail(ErrorCode::kInvalidArgument,
              "segmentation \"" + std::string(text) +
                  "\" is none of: auto[:MODEL.yaml], motion, none, masks:LEFT_DIR[,RIGHT_DIR], onnx[:MODEL.yaml], dds" +
                  (is_named ? "" : did_you_mean(name, names)));
}

}  // namespace kinetrace::segmentation
