#include <algorithm>
#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>
#include <memory>
#include <numbers>

#include <opencv2/imgproc.hpp>

#include "detector.hpp"
#include "marker_corners.hpp"
#include "opencv_image.hpp"

namespace kinetrace::calibration {
namespace {

struct FreeFamily {
  void operator()(apriltag_family_t* family) const { tag36h11_destroy(family); }
};
struct FreeDetector {
  void operator()(apriltag_detector_t* detector) const { apriltag_detector_destroy(detector); }
};

// The family's border is one bit wide; Kalibr prints the same codes with two.
void widen_border(apriltag_family_t& family, int border_bits) {
  const auto more = static_cast<std::uint32_t>(border_bits - 1);
  for (std::uint32_t i = 0; i < family.nbits; ++i) {
    family.bit_x[i] += more;
    family.bit_y[i] += more;
  }
  family.width_at_border += 2 * static_cast<int>(more);
  family.total_width += 2 * static_cast<int>(more);
}

class AprilDetector final : public TargetDetector {
 public:
  explicit AprilDetector(Target target)
      : target_(std::move(target)), family_(tag36h11_create()), detector_(apriltag_detector_create()) {
    widen_border(*family_, target_.border_bits);
    apriltag_detector_add_family(detector_.get(), family_.get());
    detector_->quad_decimate = 1.0F;  // Edges are measured at full resolution.
    detector_->nthreads = 1;
  }

  // Black squares touch the tags' corners and enclose the white beside their edges, which hides tags. Thinning black
  // separates them; without thinning, some corners are misplaced.
  std::vector<Corner> detect(GrayView view) override {
    const cv::Mat image = as_mat(view);
    std::vector<SeenMarker> seen;
    for (const int thinner_px : {1, 2, 0}) {
      cv::Mat thinned;
      cv::dilate(image, thinned, cv::Mat::ones(2 * thinner_px + 1, 2 * thinner_px + 1, CV_8U));
      add_tags(thinned, thinner_px, seen);
    }
    return refined_corners(target_, consistent_markers(target_, std::move(seen)), image);
  }

 private:
  void add_tags(const cv::Mat& image, int thinner_px, std::vector<SeenMarker>& seen) {
    image_u8_t pixels{image.cols, image.rows, static_cast<int>(image.step), image.data};
    zarray_t* found = apriltag_detector_detect(detector_.get(), &pixels);
    for (int i = 0; i < zarray_size(found); ++i) {
      apriltag_detection_t* tag = nullptr;
      zarray_get(found, i, static_cast<void*>(&tag));
      const auto is_same = [tag](const SeenMarker& marker) { return marker.id == tag->id; };
      if (std::none_of(seen.begin(), seen.end(), is_same)) {
        seen.push_back(marker_of(*tag, thinner_px));
      }
    }
    apriltag_detections_destroy(found);
  }

  // The library starts at the bottom left corner, goes the other way round, and has pixel centres at halves.
  static SeenMarker marker_of(const apriltag_detection_t& tag, int thinner_px) {
    SeenMarker marker{.id = tag.id, .corners_px = {}};
    const cv::Point2d middle(tag.c[0], tag.c[1]);
    for (std::size_t i = 0; i < 4; ++i) {
      const cv::Point2d corner(tag.p[3 - i][0], tag.p[3 - i][1]);
      const cv::Point2d outwards = corner - middle;
      const double scale = 1.0 + thinner_px * std::numbers::sqrt2 / std::max(cv::norm(outwards), 1.0);
      marker.corners_px[i] = middle + outwards * scale - cv::Point2d(0.5, 0.5);
    }
    return marker;
  }

  Target target_;
  std::unique_ptr<apriltag_family_t, FreeFamily> family_;
  std::unique_ptr<apriltag_detector_t, FreeDetector> detector_;
};

}  // namespace

std::unique_ptr<TargetDetector> make_april_detector(const Target& target) {
  return std::make_unique<AprilDetector>(target);
}

}  // namespace kinetrace::calibration
