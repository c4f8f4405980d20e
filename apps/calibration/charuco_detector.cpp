#include <utility>

#include <opencv2/core/version.hpp>
// The marker detector moved from OpenCV's contributed modules into objdetect.
#if CV_VERSION_MAJOR > 4 || CV_VERSION_MINOR >= 7
#include <opencv2/objdetect/aruco_detector.hpp>
#else
#include <opencv2/aruco.hpp>
#endif

#include "detector.hpp"
#include "marker_bits.hpp"
#include "marker_corners.hpp"
#include "opencv_image.hpp"

namespace kinetrace::calibration {
namespace {

using MarkerCorners = std::vector<std::vector<cv::Point2f>>;

#if CV_VERSION_MAJOR > 4 || CV_VERSION_MINOR >= 7
class MarkerDetector {
 public:
  explicit MarkerDetector(int dictionary) : detector_(cv::aruco::getPredefinedDictionary(dictionary)) {}
  void detect(const cv::Mat& image, MarkerCorners& corners, std::vector<int>& ids) const {
    detector_.detectMarkers(image, corners, ids);
  }

 private:
  cv::aruco::ArucoDetector detector_;
};
#else
class MarkerDetector {
 public:
  explicit MarkerDetector(int dictionary) : dictionary_(cv::aruco::getPredefinedDictionary(dictionary)) {}
  void detect(const cv::Mat& image, MarkerCorners& corners, std::vector<int>& ids) const {
    cv::aruco::detectMarkers(image, dictionary_, corners, ids);
  }

 private:
  cv::Ptr<cv::aruco::Dictionary> dictionary_;
};
#endif

class CharucoDetector final : public TargetDetector {
 public:
  CharucoDetector(Target target, int dictionary) : target_(std::move(target)), markers_(dictionary) {}

  std::vector<Corner> detect(GrayView view) override {
    const cv::Mat image = as_mat(view);
    MarkerCorners corners;
    std::vector<int> ids;
    markers_.detect(image, corners, ids);
    std::vector<SeenMarker> seen;
    for (std::size_t i = 0; i < ids.size(); ++i) {
      seen.push_back({ids[i], {corners[i][0], corners[i][1], corners[i][2], corners[i][3]}});
    }
    return refined_corners(target_, consistent_markers(target_, std::move(seen)), image);
  }

 private:
  Target target_;
  MarkerDetector markers_;
};

}  // namespace

Result<std::unique_ptr<TargetDetector>> make_charuco_detector(const Target& target) {
  const auto dictionary = dictionary_number(target.dictionary);
  if (!dictionary) {
    return Unexpected(dictionary.error());
  }
  return std::make_unique<CharucoDetector>(target, *dictionary);
}

}  // namespace kinetrace::calibration
