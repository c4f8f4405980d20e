// Calibration in the EEPROM of DepthAI devices, as their library writes it to JSON (eepromToJsonFile).
#include <cmath>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "calibration/calibration_files.hpp"
#include "util/messages.hpp"
#include "util/whole_pixels.hpp"

namespace kinetrace::hal {
namespace {

using Json = nlohmann::json;

// Camera sockets by the library's numbers: CAM_B and CAM_C.
constexpr int kLeftSocket = 1;
constexpr int kRightSocket = 2;
constexpr double kMetresPerCentimetre = 1e-2;

// Reads by key; missing values and values of another type throw the exceptions of nlohmann-json.
class EepromFile {
 public:
  EepromFile(std::filesystem::path path, const Json& root) : path_(std::move(path)), root_(root) {}

  [[nodiscard]] RigCalibration rig(const ImageSize& size) const {
    int left = kLeftSocket;
    int right = kRightSocket;
    if (const auto stereo = root_.find("stereoRectificationData"); stereo != root_.end() && stereo->is_object()) {
      left = socket_in(*stereo, "leftCameraSocket").value_or(left);
      right = socket_in(*stereo, "rightCameraSocket").value_or(right);
    }
    RigCalibration rig;
    rig.source = path_.string();
    rig.left = camera(left, size);
    rig.right = camera(right, size);
    rig.T_right_left = pose(left, right);
    return rig;
  }

 private:
  static std::optional<int> socket_in(const Json& object, const char* key) {
    const auto found = object.find(key);
    const bool is_socket = found != object.end() && found->is_number_integer() && *found >= 0 && *found < 64;
    return is_socket ? std::optional(found->get<int>()) : std::nullopt;
  }

  [[nodiscard]] const Json& camera_data(int socket) const {
    for (const Json& entry : root_.at("cameraData")) {
      if (entry.at(0) == socket) {
        return entry.at(1);
      }
    }
    throw std::string("holds no camera of socket " + std::to_string(socket) + "; calibrate the device first");
  }

  static Eigen::Matrix3d matrix(const Json& rows) {
    Eigen::Matrix3d m;
    for (std::size_t row = 0; row < 3; ++row) {
      for (std::size_t column = 0; column < 3; ++column) {
        m(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(column)) = rows.at(row).at(column).get<double>();
      }
    }
    return m;
  }

  [[nodiscard]] CameraModel camera(int socket, const ImageSize& size) const {
    const Json& data = camera_data(socket);
    const Eigen::Matrix3d K = matrix(data.at("intrinsicMatrix"));
    CameraModel camera{.lens = data.at("cameraType") == 1 ? LensModel::kEquidistant : LensModel::kRadialTangential,
                       .width_px = whole_pixels(data.at("width").get<double>()),
                       .height_px = whole_pixels(data.at("height").get<double>()),
                       .fx_px = K(0, 0),
                       .fy_px = K(1, 1),
                       .cx_px = K(0, 2),
                       .cy_px = K(1, 2)};
    auto coefficients = data.at("distortionCoeff").get<std::vector<double>>();
    if (camera.lens == LensModel::kEquidistant && coefficients.size() > 4) {
      coefficients.resize(4);  // The file has 14 for every camera; the rest is unused here.
    }
    if (const auto problem = distortion_problem(camera, coefficients)) {
      throw "distortionCoeff " + *problem;
    }
    return resized(camera, size);
  }

  // Scales and crops as the device does: to the requested width, with rows removed at the top and the bottom.
  static CameraModel resized(CameraModel camera, const ImageSize& size) {
    const double scale = static_cast<double>(size.width_px) / std::max(camera.width_px, 1);
    const double left_out_px = camera.height_px * scale - size.height_px;
    if (left_out_px < -0.5) {
      return camera;  // More rows than the sensor has: the caller reports the size.
    }
    camera.fx_px *= scale;
    camera.fy_px *= scale;
    camera.cx_px = (camera.cx_px + 0.5) * scale - 0.5;
    camera.cy_px = (camera.cy_px + 0.5) * scale - 0.5 - left_out_px / 2;
    camera.width_px = size.width_px;
    camera.height_px = size.height_px;
    return camera;
  }

  // Extrinsics form a chain from camera to camera: p_to = R * p_from + t, in centimetres. The pose follows from the
  // poses of both cameras in the last camera that their chains share.
  [[nodiscard]] Se3 pose(int left, int right) const {
    const std::vector<Link> from_left = chain(left);
    const std::vector<Link> from_right = chain(right);
    for (const Link& a : from_left) {
      for (const Link& b : from_right) {
        if (a.socket == b.socket) {
          return b.T_socket_camera.inverse() * a.T_socket_camera;
        }
      }
    }
    throw std::string("does not say how the left and the right camera stand to each other; calibrate the device first");
  }

  struct Link {
    int socket = 0;
    Se3 T_socket_camera;
  };
  [[nodiscard]] std::vector<Link> chain(int socket) const {
    std::vector<Link> links{{socket, Se3{}}};
    std::set<int> seen{socket};
    for (;;) {
      const Json& extrinsics = camera_data(links.back().socket).at("extrinsics");
      const auto next = socket_in(extrinsics, "toCameraSocket");
      if (!next || !seen.insert(*next).second) {
        return links;
      }
      const Json& t = extrinsics.at("translation");
      const Se3 T_next_this{matrix(extrinsics.at("rotationMatrix")),
                            kMetresPerCentimetre * Eigen::Vector3d(t.at("x").get<double>(), t.at("y").get<double>(),
                                                                   t.at("z").get<double>())};
      links.push_back({*next, T_next_this * links.back().T_socket_camera});
    }
  }

  std::filesystem::path path_;
  const Json& root_;
};

}  // namespace

bool is_depthai_calibration(std::string_view text) {
  return text.find("\"cameraData\"") != std::string_view::npos;
}

Result<RigCalibration> read_depthai_calibration(const std::filesystem::path& path, std::string_view text,
                                                const ImageSize& size) {
  const auto bad = [&path](const std::string& what) {
    return fail(ErrorCode::kBadCalibration, path.string() + ": " + what);
  };
  try {
    const Json root = Json::parse(text);
    return EepromFile(path, root).rig(size);
  } catch (const std::string& problem) {
    return bad(problem);
  } catch (const Json::exception& exception) {
    return bad(std::string("is no calibration of a DepthAI device (") + exception.what() +
               "); write it with eepromToJsonFile");
  }
}

}  // namespace kinetrace::hal
