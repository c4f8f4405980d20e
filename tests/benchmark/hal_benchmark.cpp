// Input: decoding and rectification at KITTI's size, and the full input path of every kind of camera at 640x480.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>
#include <opencv2/imgproc.hpp>

#include "fake_capture.hpp"
#include "kinetrace/core/allocation_counter.hpp"
#include "kinetrace/hal/dataset.hpp"
#include "kinetrace/hal/file_stereo_camera.hpp"
#include "kinetrace/hal/frame_guard.hpp"
#include "kinetrace/hal/live_stereo_camera.hpp"
#include "kinetrace/hal/raw_recorder.hpp"
#include "kinetrace/hal/rectifier.hpp"
#include "kinetrace/hal/sync_monitor.hpp"
#include "kinetrace/imaging/image_reader.hpp"
#include "kinetrace/imaging/png_writer.hpp"
#include "temp_folder.hpp"

namespace kinetrace {
namespace {

constexpr int kRawWidth = 1392;
constexpr int kRawHeight = 512;

// Structure at several scales, so that PNG takes about as much work as for a photograph.
std::vector<std::uint8_t> textured(int width, int height) {
  std::vector<std::uint8_t> pixels;
  pixels.reserve(static_cast<std::size_t>(width * height));
  std::uint32_t noise = 1;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      noise = noise * 1664525 + 1013904223;
      const double smooth = 110 + 60 * std::sin(x * 0.021) * std::cos(y * 0.034) + 25 * std::sin(x * 0.3 + y * 0.2);
      pixels.push_back(static_cast<std::uint8_t>(smooth + static_cast<double>(noise >> 29)));
    }
  }
  return pixels;
}

hal::RigCalibration kitti_rig() {
  hal::RigCalibration rig;
  rig.source = "benchmark";
  rig.left = {.width_px = kRawWidth,
              .height_px = kRawHeight,
              .fx_px = 984.2,
              .fy_px = 980.8,
              .cx_px = 690.0,
              .cy_px = 233.2,
              .distortion = {-0.373, 0.204, 0.0022, 0.0014, -0.072}};
  rig.right = rig.left;
  rig.T_right_left.translation = {-0.537, 0, 0};
  hal::RectifyingTransforms given;
  given.P_left << 721.5, 0, 609.6, 0, 0, 721.5, 172.9, 0, 0, 0, 1, 0;
  given.P_right = given.P_left;
  given.P_right(0, 3) = -721.5 * 0.537;
  given.width_px = 1242;
  given.height_px = 375;
  rig.given = given;
  return rig;
}

hal::RigCalibration fisheye_rig() {
  hal::RigCalibration rig;
  rig.source = "benchmark";
  rig.left = {.lens = hal::LensModel::kEquidistant,
              .width_px = 1242,
              .height_px = 375,
              .fx_px = 500,
              .fy_px = 500,
              .cx_px = 620,
              .cy_px = 187,
              .distortion = {0.01, -0.008, 0.003, -0.0006}};
  rig.right = rig.left;
  rig.T_right_left.translation = {-0.1, 0, 0};
  return rig;
}

void rectify_pair(benchmark::State& state, const hal::RigCalibration& rig) {
  Arena arena(hal::Rectifier::required_bytes(rig, {}));
  hal::Rectifier rectifier = hal::Rectifier::create(rig, {}, arena).value();
  const std::vector<std::uint8_t> pixels = textured(rig.left.width_px, rig.left.height_px);
  const GrayView image{pixels.data(), rig.left.width_px, rig.left.height_px, rig.left.width_px};
  for (auto _ : state) {
    benchmark::DoNotOptimize(rectifier.process({0, 0, {}, image, image})->left.data);
  }
}
void BM_RectifyPairKitti(benchmark::State& state) {
  rectify_pair(state, kitti_rig());
}
BENCHMARK(BM_RectifyPairKitti)->Unit(benchmark::kMillisecond);
void BM_RectifyPairFisheye(benchmark::State& state) {
  rectify_pair(state, fisheye_rig());
}
BENCHMARK(BM_RectifyPairFisheye)->Unit(benchmark::kMillisecond);

// The alternative: floating-point tables, exact to more than 1/32 px, twice the memory.
void BM_RectifyPairFloatTables(benchmark::State& state) {
  cv::setNumThreads(1);
  const std::vector<std::uint8_t> pixels = textured(kRawWidth, kRawHeight);
  const cv::Mat image(kRawHeight, kRawWidth, CV_8UC1, const_cast<std::uint8_t*>(pixels.data()));
  cv::Mat map_x(375, 1242, CV_32FC1);
  cv::Mat map_y(375, 1242, CV_32FC1);
  for (int y = 0; y < map_x.rows; ++y) {
    for (int x = 0; x < map_x.cols; ++x) {
      map_x.at<float>(y, x) = 75.3F + 1.02F * static_cast<float>(x);
      map_y.at<float>(y, x) = 60.7F + 1.01F * static_cast<float>(y);
    }
  }
  cv::Mat target;
  for (auto _ : state) {
    for (int view = 0; view < 2; ++view) {
      cv::remap(image, target, map_x, map_y, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
      benchmark::DoNotOptimize(target.data);
    }
  }
}
BENCHMARK(BM_RectifyPairFloatTables)->Unit(benchmark::kMillisecond);

void decode(benchmark::State& state, int width, int height, bool color) {
  const test::TempFolder folder;
  const std::string path = folder.file("image.png");
  const std::vector<std::uint8_t> pixels = textured(width, height);
  if (color) {
    std::vector<imaging::Rgb8> rgb;
    for (const std::uint8_t value : pixels) {
      rgb.push_back({value, static_cast<std::uint8_t>(value / 2), static_cast<std::uint8_t>(255 - value)});
    }
    (void)imaging::write_png_rgb8(path.c_str(), {rgb.data(), width, height, width});
  } else {
    (void)imaging::write_png_gray8(path.c_str(), {pixels.data(), width, height, width});
  }
  Arena arena(std::size_t{16} << 20);
  auto reader =
      imaging::ImageReader::create({.max_width_px = width, .max_height_px = height, .max_file_bytes = 4 << 20}, arena);
  const MutableGrayView target = take_image<std::uint8_t>(arena, width, height);
  for (auto _ : state) {
    if (!reader->read_gray(path.c_str(), target)) {
      state.SkipWithError("cannot decode");
      break;
    }
  }
  state.counters["file_bytes"] = static_cast<double>(std::filesystem::file_size(path));
}
void BM_DecodeGrayPng(benchmark::State& state) {
  decode(state, 1242, 375, false);
}
BENCHMARK(BM_DecodeGrayPng)->Unit(benchmark::kMillisecond);
void BM_DecodeRawGrayPng(benchmark::State& state) {
  decode(state, kRawWidth, kRawHeight, false);
}
BENCHMARK(BM_DecodeRawGrayPng)->Unit(benchmark::kMillisecond);
void BM_DecodeColourPng(benchmark::State& state) {
  decode(state, 1242, 375, true);
}
BENCHMARK(BM_DecodeColourPng)->Unit(benchmark::kMillisecond);

// From the camera to a rectified pair of 640x480, with and without the frame guard and the sync monitor.
hal::RigCalibration vga_rig() {
  hal::RigCalibration rig;
  rig.source = "benchmark";
  rig.left = {.width_px = 640,
              .height_px = 480,
              .fx_px = 460,
              .fy_px = 460,
              .cx_px = 320,
              .cy_px = 240,
              .distortion = {-0.28, 0.07, 0.0002, 0.0001}};
  rig.right = rig.left;
  rig.T_right_left.translation = {-0.1, 0, 0};
  return rig;
}

void capture(benchmark::State& state, std::unique_ptr<hal::StereoCamera> camera, Arena& arena) {
  hal::FrameGuard guard(std::move(camera), {});
  hal::Rectifier rectifier = hal::Rectifier::create(vga_rig(), {}, arena).value();
  const StereoGeometry& geometry = rectifier.geometry();
  hal::SyncMonitor monitor = hal::SyncMonitor::create({}, geometry.width_px, geometry.height_px, arena).value();
  if (!guard.open() || !guard.start()) {
    state.SkipWithError("cannot start");
  }
  const AllocationCounts before = allocation_counts();
  for (auto _ : state) {
    const auto frame = guard.next(std::chrono::milliseconds(100));
    const auto pair = frame ? rectifier.process(*frame) : Unexpected(frame.error());
    if (!pair) {
      state.SkipWithError(pair.error().message.c_str());
      break;
    }
    benchmark::DoNotOptimize(monitor.process(*pair));
  }
  state.counters["own_allocations"] = static_cast<double>(allocation_counts().own - before.own);
  state.counters["lost"] = static_cast<double>(guard.counters().gaps + guard.counters().skipped_missing_side);
}

void capture_live(benchmark::State& state, bool side_by_side) {
  hal::test::FakeMachine machine;
  machine.add({.path = "left", .stable_id = "left", .side_by_side = side_by_side});
  machine.add({.path = "right", .stable_id = "right"});
  hal::LiveCameraConfig config;
  config.left.device = "left";
  config.left.width_px = side_by_side ? 1280 : 640;
  if (!side_by_side) {
    config.right = config.left;
    config.right->device = "right";
  }
  Arena arena(std::size_t{32} << 20U);
  capture(state, std::make_unique<hal::LiveStereoCamera>(hal::LiveStereoCamera::create(config, arena, machine).value()),
          arena);
}
void BM_CaptureTwoDevices(benchmark::State& state) {
  capture_live(state, false);
}
BENCHMARK(BM_CaptureTwoDevices)->Unit(benchmark::kMillisecond);
void BM_CaptureSideBySide(benchmark::State& state) {
  capture_live(state, true);
}
BENCHMARK(BM_CaptureSideBySide)->Unit(benchmark::kMillisecond);

/// How a recording lies on the disk.
enum class Storage { kContainer, kPgm, kPng };

// Each image again, without compression.
void replace_by_pgm(const std::filesystem::path& folder, GrayView image) {
  std::vector<std::filesystem::path> pngs;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (entry.path().extension() == ".png") {
      pngs.push_back(entry.path());
    }
  }
  for (std::filesystem::path& path : pngs) {
    std::filesystem::remove(path);
    std::ofstream file(path.replace_extension(".pgm"), std::ios::binary);
    file << "P5\n" << image.width << ' ' << image.height << "\n255\n";
    file.write(reinterpret_cast<const char*>(image.data), static_cast<std::streamsize>(image.width) * image.height);
  }
}

void capture_recording(benchmark::State& state, Storage storage) {
  const test::TempFolder folder;
  const hal::RigCalibration rig = vga_rig();
  const bool is_container = storage == Storage::kContainer;
  const hal::RawRecorderConfig config{.directory = folder.path() / "raw",
                                      .format = is_container ? hal::RawFormat::kContainer : hal::RawFormat::kKittiRaw,
                                      .calibration = rig,
                                      .rate_hz = 30.0,
                                      .keep_free_bytes = 0};
  const std::vector<std::uint8_t> pixels = textured(640, 480);
  const GrayView image{pixels.data(), 640, 480, 640};
  Arena arena(std::size_t{64} << 20U);
  const auto recorder = hal::RawRecorder::create(config, arena).value();
  for (int i = 0; i < 20; ++i) {
    if (!recorder->write({i, i * 33'333'333, {}, image, image})) {
      state.SkipWithError("cannot record");
      return;
    }
  }
  if (storage == Storage::kPgm) {
    replace_by_pgm(config.directory, image);
  }
  const hal::DatasetLayout layout = is_container ? hal::DatasetLayout::kContainer : hal::DatasetLayout::kKittiRaw;
  hal::Dataset dataset = hal::open_dataset({.layout = layout, .path = folder.path() / "raw"}).value();
  auto camera = hal::FileStereoCamera::create(std::move(dataset), {.passes = 1'000'000}, arena).value();
  capture(state, std::make_unique<hal::FileStereoCamera>(std::move(camera)), arena);
}
void BM_CaptureContainer(benchmark::State& state) {
  capture_recording(state, Storage::kContainer);
}
BENCHMARK(BM_CaptureContainer)->Unit(benchmark::kMillisecond);
void BM_CapturePgmFiles(benchmark::State& state) {
  capture_recording(state, Storage::kPgm);
}
BENCHMARK(BM_CapturePgmFiles)->Unit(benchmark::kMillisecond);
// Unsuitable storage for 2 ms a pair: inflating alone takes longer.
void BM_CapturePngFiles(benchmark::State& state) {
  capture_recording(state, Storage::kPng);
}
BENCHMARK(BM_CapturePngFiles)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace kinetrace
