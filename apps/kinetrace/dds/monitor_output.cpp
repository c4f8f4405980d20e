#include "dds/monitor_output.hpp"

#include <array>
#include <cstdio>

#include <nlohmann/json.hpp>

#include "cli/printable.hpp"
#include "kinetrace/core/class_name.hpp"

namespace kinetrace::app {
namespace {

using nlohmann::ordered_json;

template <typename... Arguments>
std::string formatted(const char* format, Arguments... arguments) {
  std::array<char, 256> line{};
  std::snprintf(line.data(), line.size(), format, arguments...);
  return line.data();
}

std::string text(std::string_view view) {
  return std::string(view);
}

std::string camera_line(const MonitoredDevice& device) {
  if (device.frame_index < 0) {
    return "  camera      no pose yet\n";
  }
  const Eigen::Vector3d& p = device.camera.T_world_cam.translation;
  return formatted("  camera      frame %lld, %s, at %.2f %.2f %.2f m, %.2f m/s, %.0f ms ago\n",
                   static_cast<long long>(device.frame_index), text(to_string(device.camera.status)).c_str(), p.x(),
                   p.y(), p.z(), device.velocity_mps.norm(), device.delay_ms);
}

std::string health_line(const MonitoredDevice& device) {
  if (!device.health) {
    return "  health      not received yet\n";
  }
  std::string line = "  health      " + text(to_string(*device.health));
  if (!device.camera_state.empty()) {
    line += ", camera " + printable(device.camera_state);
  }
  for (const MonitoredReason& reason : device.reasons) {
    line += ", " + printable(reason.name) + " " + std::to_string(reason.count) + "x";
  }
  return line + "\n";
}

std::string calibration_line(const MonitoredDevice& device) {
  if (!device.calibration) {
    return "  calibration not received yet\n";
  }
  const StereoGeometry& rig = *device.calibration;
  return formatted("  calibration %dx%d px, f %.1f px, baseline %.4f m; by the images: %s\n", rig.width_px,
                   rig.height_px, rig.fx_px, rig.baseline_m, text(to_string(device.rig.verdict)).c_str());
}

std::string object_line(const MonitoredObject& object) {
  const ObjectResult& result = object.result;
  const Eigen::Vector3d& p = result.box.center_m;
  return formatted("  %6u %-12s %-12s %9.2f %9.2f %9.2f %8.2f %8.1f\n", result.track_id,
                   ClassName(result.class_id).c_str(), text(to_string(result.status)).c_str(), p.x(), p.y(), p.z(),
                   result.velocity_mps.norm(), object.age_s);
}

// Units as in the message: radians, focal lengths.
ordered_json correction_json(const RigCorrection::Vector& v) {
  return {{"turn_rad", {v[0], v[1], v[2]}},
          {"baseline_rad", {v[3], v[4]}},
          {"shift", v[RigCorrection::kShift]},
          {"focal", v[RigCorrection::kFocal]}};
}

ordered_json rig_json(const RigEstimate& rig) {
  return {{"verdict", to_string(rig.verdict)},
          {"estimate", correction_json(rig.correction.vector())},
          {"sigma", correction_json(rig.sigma_rad)},
          {"applied", correction_json(rig.applied.vector())},
          {"windows", rig.windows},
          {"knocks", rig.knocks}};
}

ordered_json vector_json(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

ordered_json pose_json(const Se3& pose) {
  const Eigen::Quaterniond q = pose.quaternion();
  return {{"position_m", vector_json(pose.translation)}, {"orientation_xyzw", {q.x(), q.y(), q.z(), q.w()}}};
}

ordered_json object_json(const ObjectResult& object) {
  return {{"id", object.track_id},
          {"class", ClassName(object.class_id).view()},
          {"status", to_string(object.status)},
          {"moving", object.moving},
          {"T_world_obj", pose_json(object.T_world_obj)},
          {"velocity_mps", vector_json(object.velocity_mps)},
          {"heading_rad", object.heading_rad},
          {"box",
           {{"center_m", vector_json(object.box.center_m)},
            {"size_lhw_m", vector_json(object.box.size_m)},
            {"yaw_rad", object.box.yaw_rad},
            {"down", vector_json(object.box.down)},
            {"center_sigma_m", vector_json(object.box_sigma.center_m)},
            {"size_sigma_m", vector_json(object.box_sigma.size_m)},
            {"yaw_sigma_rad", object.box_sigma.yaw_rad},
            {"heading_known", object.box_sigma.heading_known}}},
          {"box_px", {object.box_px.x0, object.box_px.y0, object.box_px.x1, object.box_px.y1}},
          {"points", object.point_count},
          {"inliers", object.inliers}};
}

// Numbers that are not finite become null; received text is untrusted, so everything but plain ASCII is escaped.
std::string line_of(const ordered_json& value) {
  return value.dump(-1, ' ', true, ordered_json::error_handler_t::replace) + "\n";
}

void print(const ordered_json& value) {
  const std::string line = line_of(value);
  std::fwrite(line.data(), 1, line.size(), stdout);
  std::fflush(stdout);
}

}  // namespace

std::string monitor_table(const MonitorState& state, std::int64_t steady_ns) {
  std::string table;
  for (const MonitoredDevice& device : state.devices()) {
    table += formatted("%s: poses %.1f/s, objects %.1f/s\n", printable(device.name).c_str(),
                       device.poses.rate_hz(steady_ns), device.object_frames.rate_hz(steady_ns));
    table += camera_line(device) + health_line(device) + calibration_line(device);
    if (!device.objects.empty()) {
      table += formatted("  %6s %-12s %-12s %9s %9s %9s %8s %8s\n", "id", "class", "status", "x m", "y m", "z m", "m/s",
                         "age s");
    }
    for (const MonitoredObject& object : device.objects) {
      table += object_line(object);
    }
  }
  return table;
}

void JsonPrinter::receive(const publishing::ReceivedCamera& camera) {
  if (pass_on(camera)) {
    print({{"topic", "camera_pose"},
           {"device", camera.device},
           {"frame", camera.frame_index},
           {"timestamp_ns", camera.timestamp_ns},
           {"handed_over_ns", camera.handed_over_ns},
           {"status", to_string(camera.camera.status)},
           {"T_world_cam", pose_json(camera.camera.T_world_cam)},
           {"velocity_mps", vector_json(camera.velocity_mps)}});
  }
}

void JsonPrinter::receive(const publishing::ReceivedObjects& objects) {
  if (!pass_on(objects)) {
    return;
  }
  ordered_json list = ordered_json::array();
  for (const ObjectResult& object : objects.objects) {
    list.push_back(object_json(object));
  }
  print({{"topic", "objects"},
         {"device", objects.device},
         {"frame", objects.frame_index},
         {"timestamp_ns", objects.timestamp_ns},
         {"piece", objects.piece},
         {"pieces", objects.pieces},
         {"objects", std::move(list)}});
}

void JsonPrinter::receive(const publishing::ReceivedHealth& health) {
  if (!pass_on(health)) {
    return;
  }
  ordered_json reasons = ordered_json::array();
  for (const publishing::ReceivedReason& reason : health.reasons) {
    reasons.push_back({{"name", reason.name},
                       {"count", reason.count},
                       {"first_frame", reason.first_frame},
                       {"last_frame", reason.last_frame}});
  }
  ordered_json counters = ordered_json::object();
  for (const publishing::ReceivedCounter& counter : health.counters) {
    counters[std::string(counter.name)] = counter.value;
  }
  print({{"topic", "health"},
         {"device", health.device},
         {"frame", health.frame_index},
         {"state", to_string(health.state)},
         {"camera", health.camera},
         {"reasons", std::move(reasons)},
         {"counters", std::move(counters)},
         {"calibration", rig_json(health.rig)}});
}

void JsonPrinter::receive(const publishing::ReceivedCalibration& calibration) {
  if (pass_on(calibration)) {
    const StereoGeometry& rig = calibration.geometry;
    print({{"topic", "calibration"},
           {"device", calibration.device},
           {"width_px", rig.width_px},
           {"height_px", rig.height_px},
           {"fx_px", rig.fx_px},
           {"fy_px", rig.fy_px},
           {"cx_px", rig.cx_px},
           {"cy_px", rig.cy_px},
           {"baseline_m", rig.baseline_m}});
  }
}

std::string rates_json(const MonitoredDevice& device, std::int64_t steady_ns) {
  return line_of({{"topic", "rates"},
                  {"device", device.name},
                  {"camera_pose_hz", device.poses.rate_hz(steady_ns)},
                  {"objects_hz", device.object_frames.rate_hz(steady_ns)}});
}

}  // namespace kinetrace::app
