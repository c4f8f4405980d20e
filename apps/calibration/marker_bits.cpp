#include "marker_bits.hpp"

#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>
#include <array>
#include <cstdlib>
#include <string>

#include <opencv2/core.hpp>
// The dictionaries moved from OpenCV's contributed modules into objdetect.
#if CV_VERSION_MAJOR > 4 || CV_VERSION_MINOR >= 7
#include <opencv2/objdetect/aruco_detector.hpp>
#else
#include <opencv2/aruco.hpp>
#endif

namespace kinetrace::calibration {
namespace {

// In the order of OpenCV's numbers for them.
constexpr std::array<std::string_view, 21> kDictionaries{
    "DICT_4X4_50",        "DICT_4X4_100",        "DICT_4X4_250",       "DICT_4X4_1000",      "DICT_5X5_50",
    "DICT_5X5_100",       "DICT_5X5_250",        "DICT_5X5_1000",      "DICT_6X6_50",        "DICT_6X6_100",
    "DICT_6X6_250",       "DICT_6X6_1000",       "DICT_7X7_50",        "DICT_7X7_100",       "DICT_7X7_250",
    "DICT_7X7_1000",      "DICT_ARUCO_ORIGINAL", "DICT_APRILTAG_16h5", "DICT_APRILTAG_25h9", "DICT_APRILTAG_36h10",
    "DICT_APRILTAG_36h11"};

}  // namespace

Result<int> dictionary_number(std::string_view dictionary) {
  for (std::size_t i = 0; i < kDictionaries.size(); ++i) {
    if (kDictionaries[i] == dictionary) {
      return static_cast<int>(i);
    }
  }
  std::string names;
  for (const std::string_view name : kDictionaries) {
    names.append(names.empty() ? "" : ", ").append(name);
  }
  return fail(ErrorCode::kInvalidArgument, "unknown dictionary '" + std::string(dictionary) + "'; there are: " + names);
}

namespace {

MarkerBits aruco_bits(std::string_view name, int id) {
  const auto number = dictionary_number(name);
  if (!number) {
    return {};
  }
  cv::Mat cells;  // One pixel a cell.
  try {
#if CV_VERSION_MAJOR > 4 || CV_VERSION_MINOR >= 7
    const cv::aruco::Dictionary dictionary = cv::aruco::getPredefinedDictionary(*number);
    cv::aruco::generateImageMarker(dictionary, id, dictionary.markerSize + 2, cells, 1);
#else
    const cv::Ptr<cv::aruco::Dictionary> dictionary = cv::aruco::getPredefinedDictionary(*number);
    cv::aruco::drawMarker(dictionary, id, dictionary->markerSize + 2, cells, 1);
#endif
  } catch (const cv::Exception&) {
    return {};
  }
  MarkerBits bits;
  for (int y = 0; y < cells.rows; ++y) {
    bits.emplace_back();
    for (int x = 0; x < cells.cols; ++x) {
      bits.back().push_back(cells.at<std::uint8_t>(y, x) == 0);
    }
  }
  return bits;
}

// The library draws a white margin around the tag, and a border one bit wide.
MarkerBits april_bits(int id, int border_bits) {
  apriltag_family_t* family = tag36h11_create();
  MarkerBits bits;
  if (id >= 0 && static_cast<std::uint32_t>(id) < family->ncodes) {
    image_u8_t* image = apriltag_to_image(family, static_cast<std::uint32_t>(id));
    const int margin = (family->total_width - family->width_at_border) / 2;
    const int side = family->width_at_border;
    const int more = border_bits - 1;
    const auto more_bits = static_cast<std::size_t>(more);
    const std::size_t width = static_cast<std::size_t>(side) + 2 * more_bits;
    bits.assign(width, std::vector<bool>(width, true));
    for (int y = 0; y < side; ++y) {
      for (int x = 0; x < side; ++x) {
        bits[static_cast<std::size_t>(y) + more_bits][static_cast<std::size_t>(x) + more_bits] =
            image->buf[(y + margin) * image->stride + x + margin] == 0;
      }
    }
    std::free(image->buf);  // The library does not export its own function for this.
    std::free(image);
  }
  tag36h11_destroy(family);
  return bits;
}

}  // namespace

MarkerBits marker_bits(const Target& target, int id) {
  return target.kind == TargetKind::kAprilGrid ? april_bits(id, target.border_bits) : aruco_bits(target.dictionary, id);
}

}  // namespace kinetrace::calibration
