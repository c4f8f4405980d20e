#include "ros_expectations.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <sstream>

namespace kinetrace::test {
namespace {

// The scene in the axes of ROS (x forward, y left, z up): our (x, y, z) is (z, -x, -y) in ROS.
constexpr int kBegin_s = 1'700'000'000;
constexpr double kForward_m = 3.0;
constexpr double kSpeed_mps = 1.0;
const double kHalf = std::sqrt(0.5);

class Checklist {
 public:
  template <typename T, typename U>
  bool equal(const std::string& what, const T& got, const U& want) {
    if (!(got == want)) {
      note(what, got, want);
    }
    return got == want;
  }
  void near(const std::string& what, double got, double want) {
    constexpr double kTolerance = 1e-6;
    if (!(std::abs(got - want) < kTolerance)) {
      note(what, got, want);
    }
  }
  template <typename V>
  void vector(const std::string& what, const V& got, double x, double y, double z) {
    near(what + ".x", got.x(), x);
    near(what + ".y", got.y(), y);
    near(what + ".z", got.z(), z);
  }
  /// q and -q are the same rotation.
  void rotation(const std::string& what, const geometry_msgs::msg::Quaternion& got, double x, double y, double z,
                double w) {
    const double sign = got.x() * x + got.y() * y + got.z() * z + got.w() * w < 0.0 ? -1.0 : 1.0;
    vector(what, got, sign * x, sign * y, sign * z);
    near(what + ".w", got.w(), sign * w);
  }
  [[nodiscard]] Mistakes take() { return std::move(mistakes_); }

 private:
  template <typename T, typename U>
  void note(const std::string& what, const T& got, const U& want) {
    std::ostringstream line;
    line << what << " is " << got << " instead of " << want;
    mistakes_.push_back(line.str());
  }

  Mistakes mistakes_;
};

double seconds(const std_msgs::msg::Header& header) {
  return (header.stamp().sec() - kBegin_s) + 1e-9 * header.stamp().nanosec();
}

// Distance covered by the camera.
double forward_m(const std_msgs::msg::Header& header) {
  return kForward_m + kSpeed_mps * seconds(header);
}

void check_header(Checklist& check, const std_msgs::msg::Header& header) {
  check.equal("header.frame_id", header.frame_id(), "odom");
  check.equal("header.stamp is within an hour", seconds(header) >= 0.0 && seconds(header) < 3600.0, true);
}

void check_diagonal(Checklist& check, const std::string& what, const std::array<double, 36>& covariance,
                    const std::array<double, 6>& want) {
  for (std::size_t i = 0; i < want.size(); ++i) {
    check.near(what + "[" + std::to_string(7 * i) + "]", covariance[7 * i], want[i]);
  }
}

}  // namespace

Mistakes mistakes_in(const nav_msgs::msg::Odometry& message) {
  Checklist check;
  check_header(check, message.header());
  check.equal("child_frame_id", message.child_frame_id(), "camera_link");
  check.vector("pose.position", message.pose().pose().position(), forward_m(message.header()), -1.0, -2.0);
  check.rotation("pose.orientation", message.pose().pose().orientation(), 0.0, 0.0, -0.6, 0.8);
  check_diagonal(check, "pose.covariance", message.pose().covariance(), {6.0, 4.0, 5.0, 3.0, 1.0, 2.0});
  check.near("pose.covariance[z][ry]", message.pose().covariance()[2 * 6 + 4], 0.5);
  check.near("pose.covariance[ry][z]", message.pose().covariance()[4 * 6 + 2], 0.5);
  if (seconds(message.header()) > 0.0) {  // The first frame has no motion yet.
    check.vector("twist.linear", message.twist().twist().linear(), 0.28 * kSpeed_mps, 0.96 * kSpeed_mps, 0.0);
    check.vector("twist.angular", message.twist().twist().angular(), 0.0, 0.0, 0.0);
    // The camera turns about z only, so along z the two variances have the ratio of those of the poses.
    check.near("twist.covariance[z][z] / twist.covariance[rz][rz]",
               message.twist().covariance()[14] / message.twist().covariance()[35], 5.0 / 2.0);
  }
  return check.take();
}

Mistakes mistakes_in_tf(const tf2_msgs::msg::TFMessage& message) {
  Checklist check;
  if (check.equal("transforms.size", message.transforms().size(), 1U)) {
    const geometry_msgs::msg::TransformStamped& transform = message.transforms()[0];
    check_header(check, transform.header());
    check.equal("child_frame_id", transform.child_frame_id(), "camera_link");
    check.vector("translation", transform.transform().translation(), forward_m(transform.header()), -1.0, -2.0);
    check.rotation("rotation", transform.transform().rotation(), 0.0, 0.0, -0.6, 0.8);
  }
  return check.take();
}

Mistakes mistakes_in_static_tf(const tf2_msgs::msg::TFMessage& message) {
  Checklist check;
  if (check.equal("transforms.size", message.transforms().size(), 2U)) {
    const geometry_msgs::msg::TransformStamped& left = message.transforms()[0];
    check.equal("left parent", left.header().frame_id(), "camera_link");
    check.equal("left child", left.child_frame_id(), "camera_left_optical_frame");
    check.vector("left translation", left.transform().translation(), 0.0, 0.0, 0.0);
    check.rotation("left rotation", left.transform().rotation(), -0.5, 0.5, -0.5, 0.5);
    const geometry_msgs::msg::TransformStamped& right = message.transforms()[1];
    check.equal("right parent", right.header().frame_id(), "camera_left_optical_frame");
    check.equal("right child", right.child_frame_id(), "camera_right_optical_frame");
    check.vector("right translation", right.transform().translation(), 0.5, 0.0, 0.0);
    check.rotation("right rotation", right.transform().rotation(), 0.0, 0.0, 0.0, 1.0);
  }
  return check.take();
}

Mistakes mistakes_in(const vision_msgs::msg::Detection3DArray& message) {
  Checklist check;
  check_header(check, message.header());
  if (check.equal("detections.size", message.detections().size(), 1U)) {  // A lost object has no position.
    const vision_msgs::msg::Detection3D& detection = message.detections()[0];
    check_header(check, detection.header());
    check.equal("id", detection.id(), "17");
    check.vector("bbox.center", detection.bbox().center().position(), 10.0, -5.0, -0.5);
    // The length lies along our x, to the right.
    check.rotation("bbox.center", detection.bbox().center().orientation(), 0.0, 0.0, -kHalf, kHalf);
    check.vector("bbox.size", detection.bbox().size(), 4.5, 1.75, 1.5);
    if (check.equal("results.size", detection.results().size(), 1U)) {
      const vision_msgs::msg::ObjectHypothesisWithPose& result = detection.results()[0];
      check.equal("class_id", result.hypothesis().class_id(), "car");
      check.near("score", result.hypothesis().score(), 1.0);
      check.vector("pose.position", result.pose().pose().position(), 10.0, -5.0, -0.5);
      check.rotation("pose.orientation", result.pose().pose().orientation(), 0.0, 0.0, -kHalf, kHalf);
      check_diagonal(check, "pose.covariance", result.pose().covariance(), {0.09, 0.01, 0.04, 0.0009, 0.0009, 0.04});
    }
  }
  return check.take();
}

Mistakes mistakes_in(const visualization_msgs::msg::MarkerArray& message) {
  constexpr int kArrow = 0;
  constexpr int kCube = 1;
  constexpr int kText = 9;
  Checklist check;
  std::vector<int> types;
  for (const visualization_msgs::msg::Marker& marker : message.markers()) {
    types.push_back(marker.type());
    check_header(check, marker.header());
    check.equal("id", marker.id(), 17);
    check.equal("action", marker.action(), 0);
    check.equal("lifetime is set", marker.lifetime().sec() > 0, true);
    check.equal("colour can be seen", marker.color().a() > 0.0F, true);
    if (marker.type() == kCube) {
      check.vector("cube", marker.pose().position(), 10.0, -5.0, -0.5);
      check.rotation("cube", marker.pose().orientation(), 0.0, 0.0, -kHalf, kHalf);
      check.vector("cube.scale", marker.scale(), 4.5, 1.75, 1.5);
    } else if (marker.type() == kText) {
      check.equal("text", marker.text(), "car 17");
    } else if (check.equal("arrow.points.size", marker.points().size(), 2U)) {
      check.vector("arrow.points[0]", marker.points()[0], 10.0, -5.0, -0.5);
      check.vector("arrow.points[1]", marker.points()[1], 12.0, -5.0, -0.5);
    }
  }
  std::sort(types.begin(), types.end());
  check.equal("an arrow, a cube and a text", types == std::vector<int>{kArrow, kCube, kText}, true);
  return check.take();
}

Mistakes mistakes_in(const geometry_msgs::msg::PoseArray& message) {
  Checklist check;
  check_header(check, message.header());
  check.equal("poses.size > 1", message.poses().size() > 1, true);
  for (const geometry_msgs::msg::Pose& pose : message.poses()) {
    check.vector("position", pose.position(), 10.0, -5.0, -1.0);
    check.rotation("orientation", pose.orientation(), 0.0, 0.0, 0.0, 1.0);
  }
  return check.take();
}

Mistakes mistakes_in(const sensor_msgs::msg::PointCloud2& message) {
  struct Point {
    float x, y, z;
    std::uint32_t track_id;
  };
  constexpr std::array<Point, 3> kWant{{{3.0F, -1.0F, -2.0F, 0}, {60.0F, 4.0F, 5.0F, 0}, {9.0F, -5.5F, -1.25F, 17}}};
  Checklist check;
  check_header(check, message.header());
  std::string fields;
  for (const sensor_msgs::msg::PointField& field : message.fields()) {
    fields += field.name() + ":" + std::to_string(field.offset()) + ":" + std::to_string(field.datatype()) + ":" +
              std::to_string(field.count()) + " ";
  }
  check.equal("fields", fields, "x:0:7:1 y:4:7:1 z:8:7:1 track_id:12:6:1 ");
  check.equal("height", message.height(), 1U);
  check.equal("width", message.width(), kWant.size());
  check.equal("point_step", message.point_step(), sizeof(Point));
  check.equal("row_step", message.row_step(), sizeof(kWant));
  check.equal("is_bigendian", message.is_bigendian(), false);
  check.equal("is_dense", message.is_dense(), true);
  if (check.equal("data.size", message.data().size(), sizeof(kWant))) {
    check.equal("points are as they are", std::memcmp(message.data().data(), kWant.data(), sizeof(kWant)), 0);
  }
  return check.take();
}

Mistakes mistakes_in(const diagnostic_msgs::msg::DiagnosticArray& message) {
  constexpr int kWarn = 1;
  Checklist check;
  check.equal("header.stamp", message.header().stamp().sec(), kBegin_s);
  if (check.equal("status.size", message.status().size(), 1U)) {
    const diagnostic_msgs::msg::DiagnosticStatus& status = message.status()[0];
    check.equal("level", static_cast<int>(status.level()), kWarn);
    check.equal("name", status.name(), "kinetrace");
    check.equal("message", status.message(), "degraded");
    check.equal("hardware_id", status.hardware_id(), "kinetrace");
    const auto value_of = [&](const std::string& key) {
      const auto found = std::find_if(status.values().begin(), status.values().end(),
                                      [&](const diagnostic_msgs::msg::KeyValue& value) { return value.key() == key; });
      return found == status.values().end() ? "absent" : found->value();
    };
    check.equal("camera", value_of("camera"), "streaming");
    check.equal("frames_lost", value_of("frames_lost"), "7");
    check.equal("dds_write_errors", value_of("dds_write_errors"), "0");
  }
  return check.take();
}

}  // namespace kinetrace::test
