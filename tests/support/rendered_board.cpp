#include "rendered_board.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <opencv2/imgproc.hpp>

#include "lens.hpp"
#include "target_drawing.hpp"

namespace kinetrace::test {
namespace {

using calibration::Target;
using calibration::TargetKind;

constexpr std::uint8_t kBlack = 25;
constexpr std::uint8_t kWhite = 225;
constexpr std::uint8_t kBackground = 120;

}  // namespace

void BoardRenderer::Print::fill(const Eigen::Vector2d& from_m, const Eigen::Vector2d& to_m, std::uint8_t grey) {
  const auto place = [this](double value_m, double first_m, int size) {
    return std::clamp(static_cast<int>(std::lround((value_m - first_m) * px_per_m)), 0, size);
  };
  for (int y = place(from_m.y(), origin_m.y(), height_px); y < place(to_m.y(), origin_m.y(), height_px); ++y) {
    const auto row = pixels.begin() + static_cast<std::ptrdiff_t>(y) * width_px;
    std::fill(row + place(from_m.x(), origin_m.x(), width_px), row + place(to_m.x(), origin_m.x(), width_px), grey);
  }
}

int BoardRenderer::Print::grey_at(double x_m, double y_m) const {
  const int x = static_cast<int>(std::floor((x_m - origin_m.x()) * px_per_m));
  const int y = static_cast<int>(std::floor((y_m - origin_m.y()) * px_per_m));
  const bool inside = x >= 0 && y >= 0 && x < width_px && y < height_px;
  return inside ? pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_px) + static_cast<std::size_t>(x)]
                : -1;
}

BoardRenderer::BoardRenderer(const Target& target, const hal::CameraModel& camera) : camera_(camera) {
  const double margin_m = 1.6 * (target.kind == TargetKind::kAprilGrid ? target.square_m / 2 : target.square_m);
  Eigen::Vector3d first = target.points_m.front();
  for (const Eigen::Vector3d& point : target.points_m) {
    first = first.cwiseMin(point);
  }
  // Edges of squares and of marker cells lie between pixels of the print.
  constexpr double kCells = 40.0;
  print_.px_per_m = kCells / target.square_m;
  print_.origin_m = first.head<2>() - Eigen::Vector2d(margin_m, margin_m);
  const Eigen::Vector2d size_m = target.extent_m() + Eigen::Vector2d(2 * margin_m, 2 * margin_m);
  print_.width_px = static_cast<int>(std::lround(size_m.x() * print_.px_per_m));
  print_.height_px = static_cast<int>(std::lround(size_m.y() * print_.px_per_m));
  print_.pixels.assign(static_cast<std::size_t>(print_.width_px) * static_cast<std::size_t>(print_.height_px), kWhite);
  covered_from_m_ = print_.origin_m.x();
  width_m_ = size_m.x();
  const auto rectangles = calibration::black_rectangles(target);
  for (const calibration::BlackRectangle& black : rectangles.value()) {
    print_.fill(black.from_m, black.to_m, kBlack);
  }
  for (int y = 0; y <= camera.height_px; ++y) {
    for (int x = 0; x <= camera.width_px; ++x) {
      const double nan = std::numeric_limits<double>::quiet_NaN();
      rays_.push_back(calibration::normalised_ray(camera, {x - 0.5, y - 0.5}).value_or(Eigen::Vector2d(nan, nan)));
    }
  }
}

// The print at its pose before the camera, sampled by the camera's normalised rays.
class BoardRenderer::PosedPrint {
 public:
  PosedPrint(const Print& print, const Se3& T_cam_board, double covered_to_m, double near_m)
      : print_(print),
        to_board_(T_cam_board.rotation.transpose()),
        centre_(-(to_board_ * T_cam_board.translation)),
        covered_to_m_(covered_to_m),
        near_m_(near_m) {}

  [[nodiscard]] int grey_along(const Eigen::Vector2d& ray) const {
    const Eigen::Vector3d direction = to_board_ * ray.homogeneous();
    const double scale = -centre_.z() / direction.z();
    if (!(scale > 0.0)) {
      return kBackground;
    }
    const Eigen::Vector3d p = centre_ + scale * direction;
    const int grey = print_.grey_at(p.x(), p.y());
    return grey < 0 || p.x() < covered_to_m_ ? static_cast<int>(kBackground) : grey;
  }

  // Far enough from the board that no sample of the pixel hits it.
  [[nodiscard]] bool is_beside(const Eigen::Vector2d& ray) const {
    const Eigen::Vector3d direction = to_board_ * ray.homogeneous();
    const Eigen::Vector3d p = centre_ - centre_.z() / direction.z() * direction;
    const auto misses = [&](double dx, double dy) { return print_.grey_at(p.x() + dx, p.y() + dy) < 0; };
    return misses(-near_m_, -near_m_) && misses(near_m_, near_m_) && misses(-near_m_, near_m_) &&
           misses(near_m_, -near_m_) && misses(0.0, 0.0);
  }

 private:
  const Print& print_;
  Eigen::Matrix3d to_board_;
  Eigen::Vector3d centre_;
  double covered_to_m_;
  double near_m_;
};

std::vector<float> BoardRenderer::draw(const Se3& T_cam_board, double covered_to_m) const {
  const PosedPrint board(print_, T_cam_board, covered_to_m, 0.1 * width_m_);
  std::vector<float> greys;
  const auto stride = static_cast<std::size_t>(camera_.width_px) + 1;
  for (int y = 0; y < camera_.height_px; ++y) {
    for (int x = 0; x < camera_.width_px; ++x) {
      const std::size_t at = static_cast<std::size_t>(y) * stride + static_cast<std::size_t>(x);
      const Eigen::Vector2d& a = rays_[at];
      const Eigen::Vector2d& d = rays_[at + stride + 1];
      const Eigen::Vector2d right = rays_[at + 1] - a;
      const Eigen::Vector2d down = rays_[at + stride] - a;
      const bool seen = a.allFinite() && d.allFinite() && right.allFinite() && down.allFinite();
      if (!seen || board.is_beside(a + (d - a) / 2)) {
        greys.push_back(kBackground);
        continue;
      }
      constexpr int kSamples = 4;
      int sum = 0;
      for (int i = 0; i < kSamples * kSamples; ++i) {
        sum += board.grey_along(a + right * ((i % kSamples + 0.5) / kSamples) +
                                down * ((static_cast<double>(i / kSamples) + 0.5) / kSamples));
      }
      greys.push_back(static_cast<float>(sum) / (kSamples * kSamples));
    }
  }
  return greys;
}

BoardImage BoardRenderer::render(const Se3& T_cam_board, const BoardImageFaults& faults, std::uint32_t seed) const {
  std::vector<float> greys = draw(T_cam_board, covered_from_m_ + faults.covered * width_m_);
  cv::Mat image(camera_.height_px, camera_.width_px, CV_32F, greys.data());
  if (faults.blur_px > 0.0) {
    cv::GaussianBlur(image, image, {0, 0}, faults.blur_px);
  }
  std::mt19937 random(seed);
  std::normal_distribution<float> noise(0.0F, static_cast<float>(std::max(faults.noise_grey, 1e-6)));
  BoardImage result{.pixels = {}, .width_px = camera_.width_px, .height_px = camera_.height_px};
  for (const float grey : greys) {
    result.pixels.push_back(static_cast<std::uint8_t>(std::clamp(std::lround(grey + noise(random)), 0L, 255L)));
  }
  return result;
}

}  // namespace kinetrace::test
