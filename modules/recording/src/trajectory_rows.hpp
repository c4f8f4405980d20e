// The lines of the text files that grow with every finalised frame.
#pragma once

#include <cstdint>
#include <string_view>

#include "buffered_file.hpp"
#include "kinetrace/core/frame_result.hpp"
#include "spool.hpp"

namespace kinetrace::recording {

inline constexpr std::string_view kObjectsHeader =
    "frame,timestamp_ns,track_id,class,status,tx,ty,tz,qx,qy,qz,qw,vx,vy,vz,moving,heading,box_x,box_y,box_z,box_l,"
    "box_h,box_w,box_yaw,cov_rx,cov_ry,cov_rz,cov_tx,cov_ty,cov_tz,point_count,inliers,pixel_height,mask_x0,mask_y0,"
    "mask_x1,mask_y1,box_down_x,box_down_y,box_down_z,sd_along,sd_down,sd_across,sd_l,sd_h,sd_w,sd_yaw,heading_known\n";
/// Columns of earlier versions: boxes upright about the world's y axis, without uncertainty.
inline constexpr std::size_t kColumnsOfAllVersions = 37;

/// Frame numbers of the rows of camera.tum.
inline constexpr std::string_view kCameraFramesFile = "camera_frames.csv";
inline constexpr std::string_view kCameraFramesHeader = "frame,timestamp_ns\n";

/// Position and orientation of an object's box as KITTI labels have it: in the camera frame of its own image.
struct KittiPlacement {
  Eigen::Vector3d location_m;   ///< Centre of the bottom face.
  double rotation_y_rad = 0.0;  ///< About the camera's y axis; 0 = length along +x. In [-pi, pi].
  double alpha_rad = 0.0;       ///< The same as seen along the ray to the object. In [-pi, pi].
};
[[nodiscard]] KittiPlacement kitti_placement(const Box3& box, const Se3& T_world_cam);

/// `timestamp tx ty tz qx qy qz qw`, seconds with nine decimals.
void write_tum_row(std::int64_t timestamp_ns, const StoredPose& pose, BufferedWriter& out) noexcept;
/// A row of camera_frames.csv.
void write_frame_row(const FrameEstimate& frame, BufferedWriter& out) noexcept;
/// The upper 3 x 4 part of T_world_cam, row by row.
void write_kitti_row(const Se3& T_world_cam, BufferedWriter& out) noexcept;
void write_object_row(const FrameEstimate& frame, const ObjectResult& object, BufferedWriter& out) noexcept;
/// Writes nothing for an object that is lost or has no pixel in the image: KITTI labels list visible objects.
bool write_label_row(const FrameEstimate& frame, const ObjectResult& object, BufferedWriter& out) noexcept;

}  // namespace kinetrace::recording
