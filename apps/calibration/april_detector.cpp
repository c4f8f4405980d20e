#include <algorithm>
#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>
#include <memory>
#include <thread>

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

// The family has a border one bit wide; Kalibr prints the same bits with two.
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
    detector_->quad_decimate = 1.0F;  // Edges are measured in the image as it is.
    detector_->nthreads = 1;
  }

  std::vector<Corner> detect(GrayView view) override {
    image_u8_t image{view.width, view.height, view.stride, const_cast<std::uint8_t*>(view.data)};
    zarray_t* found = apriltag_detector_detect(detector_.get(), &image);
    std::vector<SeenMarker> seen;
    for (int i = 0; i < zarray_size(found); ++i) {
      apriltag_detection_t* tag = nullptr;
      zarray_get(found, i, static_cast<void*>(&tag));
      seen.push_back(marker_of(*tag));
    }
    apriltag_detections_destroy(found);
    return refined_corners(target_, consistent_markers(target_, std::move(seen)), as_mat(view));
  }

 private:
  // The library begins at the bottom left corner, goes the other way round, and has pixel centres at halves.
  static SeenMarker marker_of(const apriltag_detection_t& tag) {
    SeenMarker marker{.id = tag.id, .corners_px = {}};
    for (std::size_t i = 0; i < 4; ++i) {
      const double* corner = tag.p[3 - i];
      marker.corners_px[i] = {static_cast<float>(corner[0] - 0.5), static_cast<float>(corner[1] - 0.5)};
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
