#include "kinetrace/hal/rectifier.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>

#include <opencv2/calib3d.hpp>

#include "calibration/opencv_lens.hpp"
#include "kinetrace/core/allocation_counter.hpp"
#include "rectification/lookup_kernel.hpp"
#include "rectification/rectification_plan.hpp"
#include "util/messages.hpp"

namespace kinetrace::hal {
namespace {

// Smallest number of rows that is worth another worker.
constexpr std::size_t kRowsAtOnce = 32;

// Headers over memory that the arena owns.
cv::Mat position_table(std::span<std::int16_t> memory, int width, int height) {
  return {height, width, CV_16SC2, memory.data()};
}
cv::Mat fraction_table(std::span<std::uint16_t> memory, int width, int height) {
  return {height, width, CV_16UC1, memory.data()};
}
// Fills the look-up tables in place: OpenCV keeps matrices that already have the right size and type.
void fill_tables(const CameraModel& camera, const Eigen::Matrix3d& R, const StereoGeometry& geometry, cv::Mat position,
                 cv::Mat fraction) {
  const cv::Matx33d K_new(geometry.fx_px, 0, geometry.cx_px, 0, geometry.fy_px, geometry.cy_px, 0, 0, 1);
  const cv::Size size(geometry.width_px, geometry.height_px);
  if (camera.lens == LensModel::kEquidistant) {
    cv::fisheye::initUndistortRectifyMap(camera_matrix(camera), distortion_vector(camera), to_opencv(R), K_new, size,
                                         CV_16SC2, position, fraction);
  } else {
    cv::initUndistortRectifyMap(camera_matrix(camera), distortion_vector(camera), to_opencv(R), K_new, size, CV_16SC2,
                                position, fraction);
  }
}

// Position along one axis in the form of the kernel; clamped to the source.
struct Place {
  int position;
  int fraction;
};
Place within(int position, int fraction, int size) {
  if (position < 0) {
    return {0, 0};
  }
  return position < size - 1 ? Place{position, fraction} : Place{size - 2, kLookupSteps};
}

// Converts OpenCV's tables to the form of the kernel, in place.
void align_tables(std::span<std::int16_t> positions, std::span<std::uint16_t> fractions, int width, int height) {
  constexpr int kBitsPerAxis = 5;
  constexpr int kBitsPerByte = 8;
  for (std::size_t i = 0; i < fractions.size(); ++i) {
    const Place x = within(positions[2 * i], fractions[i] % kLookupSteps, width);
    const Place y = within(positions[2 * i + 1], fractions[i] >> kBitsPerAxis, height);
    positions[2 * i] = static_cast<std::int16_t>(x.position);
    positions[2 * i + 1] = static_cast<std::int16_t>(y.position);
    fractions[i] = static_cast<std::uint16_t>(x.fraction + (y.fraction << kBitsPerByte));
  }
}

}  // namespace

Status RectifierConfig::validate() const {
  if (!std::isfinite(keep_borders) || keep_borders < 0.0 || keep_borders > 1.0) {
    return fail(ErrorCode::kInvalidConfig, "rectifier.keep_borders must be in [0, 1], got " + number(keep_borders));
  }
  return {};
}

void Rectifier::carve(const StereoGeometry& geometry, Arena& arena, std::array<View, 2>& views) {
  const auto pixels = static_cast<std::size_t>(geometry.width_px) * static_cast<std::size_t>(geometry.height_px);
  for (View& view : views) {
    view.position = arena.take<std::int16_t>(2 * pixels);
    view.fraction = arena.take<std::uint16_t>(pixels);
    view.image = take_image<std::uint8_t>(arena, geometry.width_px, geometry.height_px);
  }
}

std::size_t Rectifier::required_bytes(const RigCalibration& calibration, const RectifierConfig& config) {
  const auto plan = plan_rectification(calibration, config);
  if (!plan || plan->passes_through) {
    return 0;
  }
  return measure_bytes([&plan](Arena& arena) {
    std::array<View, 2> views;
    carve(plan->geometry, arena, views);
  });
}

Result<StereoGeometry> Rectifier::rectified_geometry(const RigCalibration& calibration, const RectifierConfig& config) {
  return plan_rectification(calibration, config).transform([](const RectificationPlan& plan) { return plan.geometry; });
}

Result<Rectifier> Rectifier::create(const RigCalibration& calibration, const RectifierConfig& config, Arena& arena) {
  const auto plan = plan_rectification(calibration, config);
  if (!plan) {
    return Unexpected(plan.error());
  }
  Rectifier rectifier;
  rectifier.geometry_ = plan->geometry;
  rectifier.raw_width_px_ = plan->calibration.raw_width_px();
  rectifier.raw_height_px_ = plan->calibration.raw_height_px();
  rectifier.passes_through_ = plan->passes_through;
  if (plan->passes_through) {
    return rectifier;
  }
  if (rectifier.raw_width_px_ < 2 || rectifier.raw_height_px_ < 2) {
    return fail(ErrorCode::kBadCalibration,
                concat(calibration.source, ": images of ", size_text(rectifier.raw_width_px_, rectifier.raw_height_px_),
                       " pixels cannot be rectified; give the size of the camera's images"));
  }
  carve(plan->geometry, arena, rectifier.views_);
  if (arena.exhausted()) {
    return fail(ErrorCode::kCapacity,
                concat("the arena does not hold the rectifier's ", std::to_string(required_bytes(calibration, config)),
                       " bytes; enlarge the memory budget"));
  }
  const ForeignCall foreign;
  // Stages run in parallel, OpenCV's loops do not: its thread pool would allocate hundreds of times in every call.
  cv::setNumThreads(1);
  try {
    const std::array<const CameraModel*, 2> cameras{&plan->calibration.left, &plan->calibration.right};
    const std::array<Eigen::Matrix3d, 2> rotations{plan->R_left, plan->R_right};
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      const View& view = rectifier.views_[i];
      fill_tables(*cameras[i], rotations[i], plan->geometry,
                  position_table(view.position, view.image.width, view.image.height),
                  fraction_table(view.fraction, view.image.width, view.image.height));
      align_tables(view.position, view.fraction, rectifier.raw_width_px_, rectifier.raw_height_px_);
    }
  } catch (const cv::Exception& exception) {
    return fail(ErrorCode::kInternal,
                calibration.source + ": rectification tables failed (OpenCV: " + exception.err + ")");
  }
  return rectifier;
}

void Rectifier::look_up(GrayView source, const View& view, int begin, int end) noexcept {
  const LookupKernel kernel = lookup_kernel();
  const auto width = static_cast<std::size_t>(view.image.width);
  for (int y = begin; y < end; ++y) {
    const std::size_t first = width * static_cast<std::size_t>(y);
    const LookupRow row{&view.position[2 * first], &view.fraction[first], view.image.width};
    kernel(source.data, source.stride, row, view.image.row(y));
  }
}

Result<RectifiedPair> Rectifier::process(const StereoFrame& frame, Workers* workers) {
  for (const GrayView* image : {&frame.left, &frame.right}) {
    if (image->width != raw_width_px_ || image->height != raw_height_px_) {
      return fail(ErrorCode::kInvalidArgument,
                  concat("frame ", std::to_string(frame.frame_index), " is ", size_text(image->width, image->height),
                         " pixels, the calibration is for ", size_text(raw_width_px_, raw_height_px_),
                         "; use the calibration of this camera mode"));
    }
  }
  RectifiedPair pair{frame.frame_index, frame.timestamp_ns, frame.name, frame.left, frame.right, geometry_};
  if (passes_through_) {
    return pair;
  }
  // Row indices: left image first, then the right one.
  const std::size_t height = static_cast<std::size_t>(geometry_.height_px);
  const std::array sources{frame.left, frame.right};
  in_pieces(workers, height * views_.size(), kRowsAtOnce, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = 0; i < views_.size(); ++i) {
      const std::size_t first = std::clamp(begin, i * height, (i + 1) * height) - i * height;
      const std::size_t last = std::clamp(end, i * height, (i + 1) * height) - i * height;
      look_up(sources[i], views_[i], static_cast<int>(first), static_cast<int>(last));
    }
  });
  pair.left = views_[0].image;
  pair.right = views_[1].image;
  return pair;
}

}  // namespace kinetrace::hal
