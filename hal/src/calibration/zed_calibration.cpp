// Factory calibration of a ZED camera, SN*.conf: an INI file with a section for each resolution.
#include <array>
#include <cctype>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "calibration/calibration_files.hpp"
#include "util/messages.hpp"
#include "util/text_file.hpp"

namespace kinetrace::hal {
namespace {

struct Resolution {
  std::string_view name;
  int width_px;
  int height_px;
};
// Sizes of one view by the maker's documentation.
constexpr std::array<Resolution, 6> kResolutions{{{"2k", 2208, 1242},
                                                  {"fhd", 1920, 1080},
                                                  {"fhd1200", 1920, 1200},
                                                  {"hd", 1280, 720},
                                                  {"svga", 960, 600},
                                                  {"vga", 672, 376}}};

std::string lower(std::string_view text) {
  std::string result;
  for (const char c : text) {
    result += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return result;
}

std::string_view trimmed(std::string_view text) {
  const auto is_blank = [](char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; };
  while (!text.empty() && is_blank(text.front())) {
    text.remove_prefix(1);
  }
  while (!text.empty() && is_blank(text.back())) {
    text.remove_suffix(1);
  }
  return text;
}

// Values by "section:key", all in lower case.
class ZedFile {
 public:
  ZedFile(const std::filesystem::path& path, std::string_view text) : path_(path) {
    std::string section;
    for (const std::string_view line : content_lines(text)) {
      const std::size_t equals = line.find('=');
      if (line.front() == '[') {
        section = lower(trimmed(line.substr(1, line.find(']') - 1)));
      } else if (equals != std::string_view::npos && line.front() != ';') {
        values_[section + ":" + lower(trimmed(line.substr(0, equals)))] = trimmed(line.substr(equals + 1));
      }
    }
  }

  /// `fallback`: value of a missing key; none: an error.
  [[nodiscard]] Result<double> number_at(const std::string& key, std::optional<double> fallback = {}) const {
    const auto found = values_.find(key);
    if (found == values_.end()) {
      return fallback ? Result<double>(*fallback) : bad(key + " is missing; fetch the file of this camera anew");
    }
    const auto value = parse_double(found->second);
    return value ? Result<double>(*value) : bad(key + " is '" + std::string(found->second) + "', which is no number");
  }
  [[nodiscard]] bool has(const std::string& key) const { return values_.contains(key); }
  [[nodiscard]] Unexpected<Error> bad(const std::string& what) const {
    return fail(ErrorCode::kBadCalibration, path_.string() + ": " + what);
  }

 private:
  std::filesystem::path path_;
  std::map<std::string, std::string_view> values_;
};

Result<CameraModel> read_camera(const ZedFile& file, const std::string& section, const ImageSize& size) {
  CameraModel camera{.width_px = size.width_px, .height_px = size.height_px};
  const std::array<std::pair<const char*, double*>, 4> needed{
      {{"fx", &camera.fx_px}, {"fy", &camera.fy_px}, {"cx", &camera.cx_px}, {"cy", &camera.cy_px}}};
  for (const auto& [key, value] : needed) {
    const auto read = file.number_at(section + ":" + key);
    if (!read) {
      return Unexpected(read.error());
    }
    *value = *read;
  }
  constexpr std::array<const char*, 8> kCoefficients{"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"};
  for (std::size_t i = 0; i < kCoefficients.size(); ++i) {
    const auto read = file.number_at(section + ":" + kCoefficients[i], 0.0);
    if (!read) {
      return Unexpected(read.error());
    }
    camera.distortion[i] = *read;
  }
  return camera;
}

// As in the maker's example (stereolabs/zed-open-capture, examples): Rodrigues' formula turns (RX, CV, RZ) into the
// rotation from left to right; (Baseline, TY, TZ), in millimetres, points to the right camera.
Result<Se3> read_pose(const ZedFile& file, const std::string& resolution) {
  std::array<double, 6> values{};
  const std::array<const char*, 6> keys{"rx", "cv", "rz", "baseline", "ty", "tz"};
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const std::string plain = std::string("stereo:") + keys[i];
    const std::string own = concat(plain, "_", resolution);
    const bool may_lack = i == 4 || i == 5;
    const auto read = file.number_at(file.has(own) ? own : plain, may_lack ? std::optional(0.0) : std::nullopt);
    if (!read) {
      return Unexpected(read.error());
    }
    values[i] = *read;
  }
  constexpr double kMetresPerMillimetre = 1e-3;
  return Se3{so3_exp({values[0], values[1], values[2]}),
             -kMetresPerMillimetre * Eigen::Vector3d(values[3], values[4], values[5])};
}

}  // namespace

Result<RigCalibration> read_zed_calibration(const std::filesystem::path& path, std::string_view text,
                                            const ImageSize& size) {
  const ZedFile file(path, text);
  for (const Resolution& resolution : kResolutions) {
    const std::string name(resolution.name);
    if (resolution.width_px != size.width_px || resolution.height_px != size.height_px) {
      continue;
    }
    const auto left = read_camera(file, "left_cam_" + name, size);
    const auto right = read_camera(file, "right_cam_" + name, size);
    const auto pose = read_pose(file, name);
    if (!left || !right || !pose) {
      return Unexpected(!left ? left.error() : !right ? right.error() : pose.error());
    }
    RigCalibration rig;
    rig.source = path.string();
    rig.left = *left;
    rig.right = *right;
    rig.T_right_left = *pose;
    return rig;
  }
  return file.bad("knows no images of " + size_text(size.width_px, size.height_px) +
                  "; use 2208x1242, 1920x1080, 1920x1200, 1280x720, 960x600 or 672x376 a view");
}

}  // namespace kinetrace::hal
