#include "street_drive.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "kinetrace/imaging/png_writer.hpp"

namespace kinetrace::test {
namespace {

constexpr double kSpeed_mps = 5.0;
constexpr double kYawRate_rad_s = 0.04;
constexpr std::uint16_t kMotsClassFactor = 1000;

void write_mask(const std::filesystem::path& path, const RenderedPair& pair, const std::vector<std::uint8_t>& labels,
                std::uint16_t class_id) {
  std::vector<std::uint16_t> values(labels.size());
  for (std::size_t i = 0; i < labels.size(); ++i) {
    values[i] = labels[i] == 0 ? std::uint16_t{0} : static_cast<std::uint16_t>(class_id * kMotsClassFactor + labels[i]);
  }
  std::filesystem::create_directories(path.parent_path());
  const ImageView<const std::uint16_t> image{values.data(), pair.geometry.width_px, pair.geometry.height_px,
                                             pair.geometry.width_px};
  if (!imaging::write_png_gray16(path.c_str(), image)) {
    throw std::runtime_error("cannot write " + path.string());
  }
}

}  // namespace

Se3 StreetDrive::T_world_cam(int frame) {
  const double time_s = frame * kFrame_s;
  const double yaw = kYawRate_rad_s * time_s;
  const double radius = kSpeed_mps / kYawRate_rad_s;
  return {so3_exp({0.0, yaw, 0.0}), {radius * (1.0 - std::cos(yaw)), 0.0, radius * std::sin(yaw)}};
}

Se3 StreetDrive::T_world_mover(std::size_t mover, int frame) const {
  const Mover& m = movers_.at(mover);
  return {Eigen::Matrix3d::Identity(), m.start_m + frame * kFrame_s * m.velocity_mps};
}

RenderedPair StreetDrive::render(int frame) const {
  std::vector<RenderedBox> boxes = street_furniture();
  for (std::size_t k = 0; k < movers_.size(); ++k) {
    boxes.push_back({movers_[k].size_m, T_world_mover(k, frame), static_cast<std::uint8_t>(k + 1)});
  }
  return world_.render(T_world_cam(frame), boxes);
}

std::string stem_of(int frame) {
  std::array<char, 16> name{};
  std::snprintf(name.data(), name.size(), "%06d", frame);
  return name.data();
}

void write_masks(const RenderedPair& pair, int frame, const std::filesystem::path& folder, std::uint16_t class_id) {
  write_mask(folder / "left" / (stem_of(frame) + ".png"), pair, pair.left_labels, class_id);
  write_mask(folder / "right" / (stem_of(frame) + ".png"), pair, pair.right_labels, class_id);
}

pipeline::PipelineConfig small_config() {
  pipeline::PipelineConfig config;
  config.segmentation.mode = segmentation::SegmentationMode::kNone;
  config.features.bucket_px = 12;
  config.features.max_features = 700;
  config.features.max_background_features = 400;
  config.features.max_disparity_px = 64;
  config.tracking.max_objects = 4;
  return config;
}

pipeline::PipelineConfig small_config(const MaskFolder& masks) {
  pipeline::PipelineConfig config = small_config(segmentation::SegmentationMode::kMasks);
  config.segmentation.left_dir = masks.left().string();
  config.segmentation.right_dir = masks.right().string();
  return config;
}

pipeline::PipelineConfig small_config(segmentation::SegmentationMode mode) {
  pipeline::PipelineConfig config = small_config();
  config.segmentation.mode = mode;
  return config;
}

}  // namespace kinetrace::test
