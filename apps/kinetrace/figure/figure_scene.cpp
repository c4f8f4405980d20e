#include "figure/figure_scene.hpp"

#include <algorithm>
#include <utility>

#include "figure/figure_choice.hpp"

namespace kinetrace::figure {
namespace {

// More points cannot be distinguished in a figure.
constexpr std::size_t kMaxBackgroundPoints = 60'000;
constexpr std::size_t kMaxObjectPoints = 20'000;

Status check(const FigureRun& run, const SceneChoice& choice) {
  if (choice.frame && run.camera_at(*choice.frame) == nullptr) {
    const std::string range = "frames " + std::to_string(run.first_frame()) + " to " + std::to_string(run.last_frame());
    const bool is_inside = *choice.frame >= run.first_frame() && *choice.frame <= run.last_frame();
    return fail(ErrorCode::kInvalidArgument,
                "--frame " + std::to_string(*choice.frame) + ": " +
                    (is_inside ? "the run, which has " + range + ", left this one out" : "the run has " + range));
  }
  if (choice.object && run.track(*choice.object) == nullptr) {
    std::string known;
    constexpr std::size_t kListed = 20;
    for (std::size_t i = 0; i < std::min(run.tracks().size(), kListed); ++i) {
      known += (i == 0 ? "" : ", ") + std::to_string(run.tracks()[i].track_id);
    }
    known += run.tracks().size() > kListed ? ", ..." : "";
    return fail(ErrorCode::kInvalidArgument,
                "--object " + std::to_string(*choice.object) + ": " +
                    (known.empty() ? "the run has no objects" : "the run has the objects " + known));
  }
  return {};
}

std::int64_t frame_of(const FigureRun& run, const SceneChoice& choice, const StereoGeometry& geometry) {
  if (choice.frame) {
    return *choice.frame;
  }
  return choice.object ? choose_frame_of(*run.track(*choice.object))
                       : choose_frame(run, geometry.width_px, geometry.height_px);
}

void take_image(RecordedImages& images, Scene& scene) {
  const Result<GrayView> image = images.left(scene.frame);
  if (!image) {
    scene.image_problem = image.error().message;
    return;
  }
  scene.image.resize(static_cast<std::size_t>(image->width) * static_cast<std::size_t>(image->height));
  copy_image(*image, MutableGrayView{scene.image.data(), image->width, image->height, image->width});
}

/// A point cloud, or an empty one if the run did not write it: clouds are written at the end of a run.
Result<Cloud> cloud_if_written(const recording::Run& run, const std::string& name, std::size_t most) {
  if (!run.is_finished) {
    return Cloud{};
  }
  Result<Cloud> cloud = read_cloud(run.directory / "points" / name, most);
  return !cloud && cloud.error().code == ErrorCode::kNotFound ? Cloud{} : cloud;
}

}  // namespace

StereoGeometry recorded_geometry(const recording::Run& run, LabelView labels) {
  if (run.rectified.width_px > 0 && run.rectified.height_px > 0 && run.rectified.fx_px > 0.0 &&
      run.rectified.fy_px > 0.0) {
    return run.rectified;
  }
  StereoGeometry geometry;
  geometry.width_px = labels.width > 0 ? labels.width : 1000;
  geometry.height_px = labels.height > 0 ? labels.height : 500;
  geometry.fx_px = geometry.fy_px = geometry.width_px / 2.0;
  geometry.cx_px = (geometry.width_px - 1) / 2.0;
  geometry.cy_px = (geometry.height_px - 1) / 2.0;
  return geometry;
}

Result<Cloud> background_of(const recording::Run& run) {
  return cloud_if_written(run, "background.ply", kMaxBackgroundPoints);
}

std::vector<TrackMask> separate(const recording::MaskFrame& frame) {
  std::vector<TrackMask> masks;
  for (const recording::FrameMask& from : frame.masks) {
    TrackMask& mask = masks.emplace_back();
    mask.track_id = from.track_id;
    mask.class_id = from.class_id;
    mask.box_px = from.box_px;
    const auto width = static_cast<std::size_t>(frame.labels.width);
    mask.pixels.assign(width * static_cast<std::size_t>(frame.labels.height), 0);
    for (int y = from.box_px.y0; y < from.box_px.y1; ++y) {
      const std::uint8_t* row = frame.labels.row(y);
      std::transform(
          row + from.box_px.x0, row + from.box_px.x1,
          mask.pixels.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(y) * width) + from.box_px.x0,
          [&](std::uint8_t label) { return label == from.label ? std::uint8_t{255} : std::uint8_t{0}; });
    }
  }
  return masks;
}

Result<Scene> make_scene(const FigureRun& run, const SceneChoice& choice, RecordedImages* images,
                         const std::string& image_problem, recording::MaskFrames& masks) {
  if (const Status valid = check(run, choice); !valid) {
    return Unexpected(valid.error());
  }
  const Result<recording::MaskFrame> any_frame = masks.at(run.first_frame());
  if (!any_frame) {
    return Unexpected(any_frame.error());
  }
  Scene scene;
  scene.run = &run;
  scene.image_problem = image_problem;
  scene.geometry = images != nullptr ? images->geometry() : recorded_geometry(run.run(), any_frame->labels);
  scene.frame = frame_of(run, choice, scene.geometry);
  scene.object = choice.object ? choice.object
                               : choose_object(run, scene.frame, scene.geometry.width_px, scene.geometry.height_px);

  if (images != nullptr) {
    take_image(*images, scene);
  }
  const Result<recording::MaskFrame> frame_masks = masks.at(scene.frame);
  if (!frame_masks) {
    return Unexpected(frame_masks.error());
  }
  const LabelView& labels = frame_masks->labels;
  if (!labels.empty() && (labels.width != scene.geometry.width_px || labels.height != scene.geometry.height_px)) {
    return fail(ErrorCode::kInvalidArgument, "the recording's images have " + std::to_string(scene.geometry.width_px) +
                                                 " x " + std::to_string(scene.geometry.height_px) +
                                                 " pixels, the run's masks " + std::to_string(labels.width) + " x " +
                                                 std::to_string(labels.height) +
                                                 "; --dataset must name the recording that the run was made from");
  }
  scene.masks = separate(*frame_masks);
  Result<Cloud> background = background_of(run.run());
  if (!background) {
    return Unexpected(background.error());
  }
  scene.background = std::move(*background);
  if (scene.object) {
    const std::string name = "object_" + std::to_string(*scene.object) + "_model.ply";
    Result<Cloud> model = cloud_if_written(run.run(), name, kMaxObjectPoints);
    if (!model) {
      return Unexpected(model.error());
    }
    scene.object_model = std::move(*model);
  }
  return scene;
}

}  // namespace kinetrace::figure
