#include "formats/calibration_text.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <map>
#include <vector>

#include "rectification/rectification_plan.hpp"
#include "util/messages.hpp"
#include "util/text_file.hpp"
#include "util/whole_pixels.hpp"

namespace kinetrace::hal {
namespace {

using Numbers = std::vector<double>;

std::string line(std::string_view key, const Numbers& values) {
  std::string text(key);
  text += ":";
  for (const double value : values) {
    std::array<char, 32> digits{};
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
    text.append(" ").append(digits.data(), end);
  }
  return text + "\n";
}

template <int kRows, int kColumns>
Numbers flat(const Eigen::Matrix<double, kRows, kColumns>& matrix) {
  Numbers values;
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      values.push_back(matrix(row, column));
    }
  }
  return values;
}

template <int kRows, int kColumns>
Eigen::Matrix<double, kRows, kColumns> matrix_at(const Numbers& values, std::size_t first) {
  Eigen::Matrix<double, kRows, kColumns> matrix;
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      matrix(row, column) = values[first++];
    }
  }
  return matrix;
}

Numbers lens_numbers(const CameraModel& view) {
  Numbers values{static_cast<double>(view.lens),
                 static_cast<double>(view.width_px),
                 static_cast<double>(view.height_px),
                 view.fx_px,
                 view.fy_px,
                 view.cx_px,
                 view.cy_px};
  values.insert(values.end(), view.distortion.begin(), view.distortion.end());
  return values;
}

CameraModel lens_of(const Numbers& values) {
  CameraModel view{.lens = values[0] == 0.0 ? LensModel::kRadialTangential : LensModel::kEquidistant,
                   .width_px = whole_pixels(values[1]),
                   .height_px = whole_pixels(values[2]),
                   .fx_px = values[3],
                   .fy_px = values[4],
                   .cx_px = values[5],
                   .cy_px = values[6]};
  std::copy(values.begin() + 7, values.end(), view.distortion.begin());
  return view;
}

// Values of the text by key; each key has a fixed number of values.
class KeyValues {
 public:
  explicit KeyValues(std::string_view text) {
    for (const std::string_view each : content_lines(text)) {
      const std::size_t colon = each.find(':');
      if (colon != std::string_view::npos) {
        values_[std::string(each.substr(0, colon))] = parse_numbers(each.substr(colon + 1)).value_or(Numbers{});
      }
    }
  }
  [[nodiscard]] bool has(const std::string& key, std::size_t count) const {
    const auto found = values_.find(key);
    return found != values_.end() && found->second.size() == count;
  }
  [[nodiscard]] const Numbers& of(const std::string& key) const { return values_.at(key); }

 private:
  std::map<std::string, Numbers> values_;
};

constexpr std::size_t kLensNumbers = 15;
constexpr std::size_t kPoseNumbers = 12;
constexpr std::size_t kGivenNumbers = 44;
constexpr std::size_t kRectifiedNumbers = 7;

RectifyingTransforms given_of(const Numbers& values) {
  RectifyingTransforms given;
  given.R_left = matrix_at<3, 3>(values, 0);
  given.R_right = matrix_at<3, 3>(values, 9);
  given.P_left = matrix_at<3, 4>(values, 18);
  given.P_right = matrix_at<3, 4>(values, 30);
  given.width_px = whole_pixels(values[42]);
  given.height_px = whole_pixels(values[43]);
  return given;
}

Numbers given_numbers(const RectifyingTransforms& given) {
  Numbers values;
  for (const Numbers& part : {flat(given.R_left), flat(given.R_right), flat(given.P_left), flat(given.P_right),
                              Numbers{static_cast<double>(given.width_px), static_cast<double>(given.height_px)}}) {
    values.insert(values.end(), part.begin(), part.end());
  }
  return values;
}

Eigen::Matrix<double, 3, 4> projection(const StereoGeometry& geometry, double baseline_m) {
  Eigen::Matrix<double, 3, 4> P;
  P << geometry.fx_px, 0, geometry.cx_px, -geometry.fx_px * baseline_m, 0, geometry.fy_px, geometry.cy_px, 0, 0, 0, 1,
      0;
  return P;
}

bool fits_kitti(const CameraModel& view) {
  constexpr std::size_t kCoefficients = 5;
  return view.lens == LensModel::kRadialTangential &&
         std::all_of(view.distortion.begin() + kCoefficients, view.distortion.end(), [](double d) { return d == 0.0; });
}

}  // namespace

std::string calibration_text(const RigCalibration& rig) {
  if (rig.rectified) {
    const StereoGeometry& g = *rig.rectified;
    return line("rectified", {g.fx_px, g.fy_px, g.cx_px, g.cy_px, g.baseline_m, static_cast<double>(g.width_px),
                              static_cast<double>(g.height_px)});
  }
  Numbers T = flat(rig.T_right_left.rotation);
  T.insert(T.end(), rig.T_right_left.translation.begin(), rig.T_right_left.translation.end());
  std::string text =
      line("left", lens_numbers(rig.left)) + line("right", lens_numbers(rig.right)) + line("T_right_left", T);
  if (rig.given) {
    text += line("given", given_numbers(*rig.given));
  }
  return text;
}

Result<RigCalibration> parse_calibration_text(std::string_view text, const std::string& source) {
  const KeyValues key_values(text);
  RigCalibration rig;
  rig.source = source;
  if (key_values.has("rectified", kRectifiedNumbers)) {
    const Numbers& v = key_values.of("rectified");
    rig.rectified = StereoGeometry{v[0], v[1], v[2], v[3], v[4], whole_pixels(v[5]), whole_pixels(v[6])};
    return rig;
  }
  if (!key_values.has("left", kLensNumbers) || !key_values.has("right", kLensNumbers) ||
      !key_values.has("T_right_left", kPoseNumbers)) {
    return fail(ErrorCode::kBadCalibration, source + ": holds no calibration that this version can read");
  }
  rig.left = lens_of(key_values.of("left"));
  rig.right = lens_of(key_values.of("right"));
  const Numbers& T = key_values.of("T_right_left");
  rig.T_right_left = {matrix_at<3, 3>(T, 0), {T[9], T[10], T[11]}};
  if (key_values.has("given", kGivenNumbers)) {
    rig.given = given_of(key_values.of("given"));
  }
  return rig;
}

Result<std::string> kitti_calibration_text(const RigCalibration& rig) {
  const Result<RectificationPlan> plan = plan_rectification(rig, {});
  if (!plan) {
    return Unexpected(plan.error());
  }
  if (!rig.rectified && (!fits_kitti(rig.left) || !fits_kitti(rig.right))) {
    return fail(ErrorCode::kUnsupported,
                rig.source + ": KITTI's calibration file cannot describe this lens; record into a container");
  }
  const StereoGeometry& geometry = plan->geometry;
  CameraModel pinhole{.width_px = geometry.width_px,
                      .height_px = geometry.height_px,
                      .fx_px = geometry.fx_px,
                      .fy_px = geometry.fy_px,
                      .cx_px = geometry.cx_px,
                      .cy_px = geometry.cy_px};
  const std::array<CameraModel, 2> views{rig.rectified ? pinhole : rig.left, rig.rectified ? pinhole : rig.right};
  const std::array<Eigen::Matrix3d, 2> rotations{plan->R_left, plan->R_right};
  std::string text;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const std::string id = i == 0 ? "_00" : "_01";
    const CameraModel& view = views[i];
    const auto size = [](int width_px, int height_px) {
      return Numbers{static_cast<double>(width_px), static_cast<double>(height_px)};
    };
    text += line("S" + id, size(view.width_px, view.height_px));
    text += line("K" + id, {view.fx_px, 0, view.cx_px, 0, view.fy_px, view.cy_px, 0, 0, 1});
    text += line("D" + id, Numbers(view.distortion.begin(), view.distortion.begin() + 5));
    text += line("S_rect" + id, size(geometry.width_px, geometry.height_px));
    text += line("R_rect" + id, flat(rotations[i]));
    text += line("P_rect" + id, flat(projection(geometry, i == 0 ? 0.0 : geometry.baseline_m)));
  }
  return text;
}

}  // namespace kinetrace::hal
