#include "run_for_test.hpp"

#include <array>
#include <cstdio>
#include <fstream>
#include <stdexcept>

#include "kinetrace/core/detections.hpp"
#include "kinetrace/imaging/mask_rle.hpp"
#include "kinetrace/imaging/png_writer.hpp"

namespace kinetrace::figure {
namespace {

constexpr double kFocal_px = 200.0;

void write_pose(std::ofstream& out, const Se3& pose, const char* separator) {
  const Eigen::Quaterniond q = pose.quaternion();
  for (const double value :
       {pose.translation.x(), pose.translation.y(), pose.translation.z(), q.x(), q.y(), q.z(), q.w()}) {
    out << separator << value;
  }
}

void write_object(std::ofstream& out, const recording::ObjectRow& row) {
  out << row.frame << ',' << row.timestamp_ns << ',' << row.track_id << ','
      << (row.class_id == kPedestrianClass ? "pedestrian" : "car") << ',' << to_string(row.status);
  write_pose(out, row.T_world_obj, ",");
  for (const double value : {row.velocity_mps.x(), row.velocity_mps.y(), row.velocity_mps.z()}) {
    out << ',' << value;
  }
  out << ',' << row.moving << ",0";
  for (const double value : {row.box.center_m.x(), row.box.center_m.y(), row.box.center_m.z(), row.box.size_m.x(),
                             row.box.size_m.y(), row.box.size_m.z(), row.box.yaw_rad}) {
    out << ',' << value;
  }
  out << ",1,1,1,1,1,1," << row.point_count << ",10," << row.pixel_height << ',' << row.mask_px.x0 << ','
      << row.mask_px.y0 << ',' << row.mask_px.x1 << ',' << row.mask_px.y1 << '\n';
}

void write_mask(std::ofstream& out, const recording::ObjectRow& row) {
  std::vector<std::uint8_t> labels(static_cast<std::size_t>(kImageWidth) * kImageHeight, kBackgroundLabel);
  for (int y = row.mask_px.y0; y < row.mask_px.y1; ++y) {
    for (int x = row.mask_px.x0; x < row.mask_px.x1; ++x) {
      labels[static_cast<std::size_t>(y) * kImageWidth + static_cast<std::size_t>(x)] = 1;
    }
  }
  out << row.frame << ' ' << 1000 * row.class_id + static_cast<int>(row.track_id) << ' ' << row.class_id << ' '
      << kImageHeight << ' ' << kImageWidth << ' ';
  imaging::encode_mask_rle({labels.data(), kImageWidth, kImageHeight, kImageWidth}, row.mask_px, 1,
                           [&](std::string_view piece) { out << piece; });
  out << '\n';
}

}  // namespace

recording::Run straight_drive(int frames) {
  recording::Run run;
  run.directory = "drive";
  run.sequence = "drive";
  for (int i = 0; i < frames; ++i) {
    recording::CameraRow row;
    row.frame = i;
    row.timestamp_ns = i * kPeriod_ns;
    row.T_world_cam.translation = {0.0, 0.0, static_cast<double>(i)};
    run.camera.push_back(row);
  }
  return run;
}

recording::ObjectRow object_row(std::int64_t frame, std::uint32_t track_id, const Eigen::Vector3d& position_m) {
  recording::ObjectRow row;
  row.frame = frame;
  row.timestamp_ns = frame * kPeriod_ns;
  row.track_id = track_id;
  row.class_id = kVehicleClass;
  row.status = BodyStatus::kTracked;
  row.T_world_obj.translation = position_m;
  row.box = {position_m, {4.0, 1.5, 2.0}, 0.0};
  row.point_count = 50;
  row.inliers = 10;
  row.pixel_height = 40;
  row.mask_px = {120, 60, 200, 100};
  return row;
}

recording::Run small_street() {
  recording::Run run = straight_drive(10);
  for (int i = 0; i < 10; ++i) {
    recording::ObjectRow car = object_row(i, 1, {0.0, 1.0, 10.0 + i});
    car.moving = true;
    car.velocity_mps = {0.0, 0.0, 10.0};
    run.objects.push_back(car);
    recording::ObjectRow parked = object_row(i, 2, {-4.0, 1.0, 20.0});
    parked.mask_px = {20, 70, 60, 90};
    parked.pixel_height = 20;
    run.objects.push_back(parked);
    recording::ObjectRow person = object_row(i, 3, {4.0, 1.0, 15.0});
    person.class_id = kPedestrianClass;
    person.status = i < 5 ? BodyStatus::kStereoOnly : BodyStatus::kLost;
    person.mask_px = {240, 60, 260, 120};
    run.objects.push_back(person);
  }
  return run;
}

FigureRun open(recording::Run run) {
  Result<FigureRun> figure = FigureRun::from(std::move(run));
  if (!figure) {
    throw std::runtime_error(figure.error().message);
  }
  return std::move(*figure);
}

void write_run(const recording::Run& run, const std::filesystem::path& directory, const std::string& dataset) {
  std::filesystem::create_directories(directory / "points");
  std::ofstream(directory / "run.json") << R"({"dataset": {"dataset": ")" << dataset
                                        << R"(", "sequence": "drive", "cameras": "auto"}, "config": {}, "frames": )"
                                        << run.camera.size() << "}\n";
  std::ofstream tum(directory / "camera.tum");
  std::ofstream kitti(directory / "camera_kitti.txt");
  for (const recording::CameraRow& row : run.camera) {
    std::array<char, 32> time{};
    std::snprintf(time.data(), time.size(), "%.9f", static_cast<double>(row.timestamp_ns) * 1e-9);
    tum << time.data();
    write_pose(tum, row.T_world_cam, " ");
    tum << '\n';
    Eigen::Matrix<double, 3, 4> pose;
    pose << row.T_world_cam.rotation, row.T_world_cam.translation;
    for (int i = 0; i < 12; ++i) {
      kitti << (i == 0 ? "" : " ") << pose(i / 4, i % 4);
    }
    kitti << '\n';
  }
  std::ofstream objects(directory / "objects.csv");
  objects << "frame,timestamp_ns,track_id,class,status,tx,ty,tz,qx,qy,qz,qw,vx,vy,vz,moving,heading,box_x,box_y,box_z,"
             "box_l,box_h,box_w,box_yaw,cov_rx,cov_ry,cov_rz,cov_tx,cov_ty,cov_tz,point_count,inliers,pixel_height,"
             "mask_x0,mask_y0,mask_x1,mask_y1\n";
  std::ofstream masks(directory / "mots.txt");
  for (const recording::ObjectRow& row : run.objects) {
    write_object(objects, row);
    if (row.status != BodyStatus::kLost) {
      write_mask(masks, row);
    }
  }
}

void write_cloud(const std::filesystem::path& path, int points_per_side, double spacing_m) {
  std::ofstream file(path, std::ios::binary);
  file << "ply\nformat binary_little_endian 1.0\ncomment a cube\nelement vertex "
       << points_per_side * points_per_side * points_per_side
       << "\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\nproperty uchar green\n"
          "property uchar blue\nproperty int frame\nproperty uint point_id\nend_header\n";
  std::uint32_t id = 0;
  const auto place = [&](int i) { return static_cast<float>(spacing_m * (i - (points_per_side - 1) / 2.0)); };
  for (int x = 0; x < points_per_side; ++x) {
    for (int y = 0; y < points_per_side; ++y) {
      for (int z = 0; z < points_per_side; ++z) {
        const std::array<float, 3> position{place(x), place(y), place(z)};
        const std::array<std::uint8_t, 3> color{static_cast<std::uint8_t>(id), static_cast<std::uint8_t>(id),
                                                static_cast<std::uint8_t>(id)};
        const std::int32_t frame = 0;
        file.write(reinterpret_cast<const char*>(position.data()), sizeof(position));
        file.write(reinterpret_cast<const char*>(color.data()), sizeof(color));
        file.write(reinterpret_cast<const char*>(&frame), sizeof(frame));
        file.write(reinterpret_cast<const char*>(&id), sizeof(id));
        ++id;
      }
    }
  }
}

std::string write_recording(const std::filesystem::path& directory, int frames) {
  const std::vector<std::uint8_t> gray(static_cast<std::size_t>(kImageWidth) * kImageHeight, 90);
  for (const char* view : {"image_0", "image_1"}) {
    std::filesystem::create_directories(directory / view);
    for (int i = 0; i < frames; ++i) {
      std::array<char, 16> name{};
      std::snprintf(name.data(), name.size(), "%06d.png", i);
      const Status written = imaging::write_png_gray8((directory / view / name.data()).c_str(),
                                                      {gray.data(), kImageWidth, kImageHeight, kImageWidth});
      if (!written) {
        throw std::runtime_error(written.error().message);
      }
    }
  }
  std::ofstream calibration(directory / "calib.txt");
  std::ofstream times(directory / "times.txt");
  for (int view = 0; view < 2; ++view) {
    calibration << 'P' << view << ": " << kFocal_px << " 0 160 " << (view == 0 ? 0.0 : -kFocal_px * 0.5) << " 0 "
                << kFocal_px << " 80 0 0 0 1 0\n";
  }
  for (int i = 0; i < frames; ++i) {
    times << 0.1 * i << '\n';
  }
  return "kitti-odometry:" + directory.string();
}

}  // namespace kinetrace::figure
