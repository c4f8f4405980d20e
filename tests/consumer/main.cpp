// trajectories LAYOUT PATH: a recording's moving objects, as rows of frame, object, x, y, z in metres.
#include <cstdio>
#include <cstdlib>
#include <kinetrace/hal/file_stereo_camera.hpp>
#include <kinetrace/hal/rectifier.hpp>
#include <kinetrace/pipeline/pipeline.hpp>
using namespace kinetrace;

template <typename T>
T must(Result<T> result) {
  if (!result)
    std::exit((std::fprintf(stderr, "%s\n", result.error().message.c_str()), 1));
  if constexpr (!std::is_void_v<T>)
    return *std::move(result);
}

void print(const FrameEstimate& estimate) {
  for (const ObjectResult& object : estimate.objects) {
    const Eigen::Vector3d& p = object.box.center_m;
    std::printf("%d %u %.3f %.3f %.3f\n", int(estimate.frame_index), object.track_id, p.x(), p.y(), p.z());
  }
}

int main(int argc, char** argv) {
  auto dataset = must(hal::open_dataset({.layout = must(hal::parse_layout(argc > 2 ? argv[1] : "")), .path = argv[2]}));
  pipeline::PipelineConfig config;
  config.segmentation.mode = segmentation::SegmentationMode::kMotion;
  const StereoGeometry geometry = must(hal::Rectifier::rectified_geometry(dataset.calibration, {}));
  Arena arena(hal::Rectifier::required_bytes(dataset.calibration, {}) +
              hal::FileStereoCamera::required_bytes(dataset, {}) +
              must(pipeline::Pipeline::plan(config, geometry)).total_bytes());
  auto rectifier = must(hal::Rectifier::create(dataset.calibration, {}, arena));
  auto camera = must(hal::FileStereoCamera::create(std::move(dataset), {}, arena));
  auto pipeline = must(pipeline::Pipeline::create(config, geometry, arena));
  must(camera.open());
  must(camera.start());
  while (const Result<StereoFrame> frame = camera.next(std::chrono::seconds(1))) {
    print(must(pipeline.process(must(rectifier.process(*frame))))->finalised);
  }
  while (const FrameResult* result = pipeline.drain())
    print(result->finalised);
}
