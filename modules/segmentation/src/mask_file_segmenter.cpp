#include "kinetrace/segmentation/mask_file_segmenter.hpp"

#include <filesystem>
#include <string>
#include <system_error>
#include <unistd.h>

#include "kinetrace/core/files.hpp"
#include "kinetrace/imaging/image_info.hpp"
#include "kinetrace/imaging/image_reader.hpp"

namespace kinetrace::segmentation {
namespace {

constexpr std::string_view kExtension = ".png";

imaging::ImageReaderConfig reader_config(const StereoGeometry& geometry) {
  imaging::ImageReaderConfig config;
  config.max_width_px = geometry.width_px;
  config.max_height_px = geometry.height_px;
  // Upper bound of a PNG, apart from its headers: two bytes a pixel.
  config.max_file_bytes =
      static_cast<std::size_t>(geometry.width_px) * static_cast<std::size_t>(geometry.height_px) * 2 + (1U << 16U);
  return config;
}

Status check_directory(const std::string& directory, const char* key) {
  if (const Status there = check_folder(directory, "no such folder of masks"); !there) {
    return fail(there.error().code, std::string(key) + ": " + there.error().message);
  }
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(directory, error)) {
    if (entry.path().extension() == kExtension) {
      return {};
    }
  }
  return fail(ErrorCode::kNotFound, std::string(key) + ": mask folder " + directory +
                                        " holds no .png files; masks are named like the images");
}

}  // namespace

MaskFileSegmenter::MaskFileSegmenter() = default;
MaskFileSegmenter::~MaskFileSegmenter() = default;

void MaskFileSegmenter::carve(const SegmentationConfig& config, const StereoGeometry& geometry, Arena& arena,
                              MaskFileSegmenter& segmenter) {
  for (View* view : {&segmenter.left_, &segmenter.right_}) {
    if (view == &segmenter.right_ && config.right_dir.empty()) {
      continue;
    }
    view->values = take_image<std::uint16_t>(arena, geometry.width_px, geometry.height_px);
    view->labels = take_image<std::uint8_t>(arena, geometry.width_px, geometry.height_px);
    view->detections = FixedVector<Detection>(arena, static_cast<std::size_t>(config.max_objects));
  }
  segmenter.relabeler_ = InstanceRelabeler(arena);
}

std::size_t MaskFileSegmenter::required_bytes(const SegmentationConfig& config, const StereoGeometry& geometry) {
  return imaging::ImageReader::required_bytes(reader_config(geometry)) + measure_bytes([&](Arena& arena) {
           MaskFileSegmenter segmenter;
           carve(config, geometry, arena, segmenter);
         });
}

Result<std::unique_ptr<MaskFileSegmenter>> MaskFileSegmenter::create(const SegmentationConfig& config,
                                                                     const StereoGeometry& geometry, Arena& arena) {
  if (const Status valid = config.validate(); !valid) {
    return Unexpected(valid.error());
  }
  if (const Status found = check_directory(config.left_dir, "segmentation.left_dir"); !found) {
    return Unexpected(found.error());
  }
  if (!config.right_dir.empty()) {
    if (const Status found = check_directory(config.right_dir, "segmentation.right_dir"); !found) {
      return Unexpected(found.error());
    }
    if (std::error_code error; std::filesystem::equivalent(config.left_dir, config.right_dir, error)) {
      return fail(ErrorCode::kInvalidConfig, "segmentation.right_dir: " + config.right_dir +
                                                 " holds the masks of the left images; give those of the right ones, "
                                                 "or none");
    }
  }
  auto reader = imaging::ImageReader::create(reader_config(geometry), arena);
  if (!reader) {
    return Unexpected(reader.error());
  }
  std::unique_ptr<MaskFileSegmenter> segmenter(new MaskFileSegmenter());
  segmenter->config_ = config;
  segmenter->left_.directory = config.left_dir;
  segmenter->right_.directory = config.right_dir;
  segmenter->reader_ = std::make_unique<imaging::ImageReader>(std::move(*reader));
  carve(config, geometry, arena, *segmenter);
  if (arena.exhausted()) {
    return fail(ErrorCode::kCapacity, "segmentation: the arena does not hold " +
                                          std::to_string(required_bytes(config, geometry)) +
                                          " bytes; size it with segmentation::required_bytes");
  }
  return segmenter;
}

void MaskFileSegmenter::load(const RectifiedPair& pair, std::span<const Track> /*tracks*/) {
  load_view(left_, pair.name);
  load_view(right_, pair.name);
  loaded_ = true;
  loaded_frame_index_ = pair.frame_index;
}

void MaskFileSegmenter::load_view(View& view, std::string_view stem) {
  view.state = FileState::kMissing;
  if (view.directory.empty()) {
    return;
  }
  const std::string_view directory = view.directory;
  if (stem.empty() || directory.size() + stem.size() + kExtension.size() + 2 > kMaxPathBytes) {
    warnings_.add({"no mask for the frame \"", stem, "\" in ", directory, ": its name is empty or too long"});
    return;
  }
  std::size_t used = 0;
  for (const std::string_view part : {directory, std::string_view("/"), stem, kExtension}) {
    used += part.copy(path_.data() + used, kMaxPathBytes - 1 - used);
  }
  path_[used] = '\0';
  // A missing file is no error, so no message is made for it.
  if (::access(path_.data(), F_OK) != 0) {
    warnings_.add({"no mask file ", path_.data()});
    return;
  }

  view.state = FileState::kUnreadable;
  const InPlaceResult<imaging::ImageInfo> info = imaging::read_image_info(path_.data());
  if (!info) {
    warnings_.add({info.error().message});
    return;
  }
  view.encoding = info->bit_depth == 16 ? MaskEncoding::kMots : MaskEncoding::kInstance;
  if (const InPlaceStatus read = reader_->read_gray16(path_.data(), view.values); !read) {
    warnings_.add({read.error().message});
    return;
  }
  view.state = FileState::kLoaded;
}

Result<DetectionFrame> MaskFileSegmenter::process(const SegmentationInput& input) {
  if (!loaded_ || loaded_frame_index_ != input.pair.frame_index) {
    return fail(ErrorCode::kIllegalState,
                "segmentation: load() was not called for frame " + std::to_string(input.pair.frame_index));
  }
  ++counters_.frames;
  counters_.frames_missing += left_.state == FileState::kMissing ? 1U : 0U;
  for (View* view : {&left_, &right_}) {
    if (view->state == FileState::kLoaded) {
      relabel(*view, input.pair.name);
    }
  }
  counters_.frames_unreadable += left_.state == FileState::kUnreadable ? 1U : 0U;
  for (const View* view : {&left_, &right_}) {
    counters_.files_unreadable += view->state == FileState::kUnreadable ? 1U : 0U;
  }
  DetectionFrame frame;
  if (left_.state != FileState::kLoaded) {
    return frame;
  }
  frame.available = true;
  frame.left_labels = left_.labels;
  frame.left = left_.detections.span();
  counters_.detections += left_.detections.size();
  if (right_.state == FileState::kLoaded) {
    frame.right_labels = right_.labels;
    frame.right = right_.detections.span();
  }
  return frame;
}

void MaskFileSegmenter::relabel(View& view, std::string_view stem) noexcept {
  const int dropped = relabeler_.relabel(view.values, view.encoding, config_.max_objects, config_.min_area_px,
                                         view.labels, view.detections);
  counters_.detections_dropped += static_cast<std::uint64_t>(dropped);
  if (relabeler_.is_picture()) {
    view.state = FileState::kUnreadable;
    warnings_.add({view.directory, "/", stem, kExtension,
                   ": is a picture, not masks; give the folder of KITTI MOTS or instance images"});
  } else if (view.encoding == MaskEncoding::kInstance && relabeler_.ignores_all()) {
    // In a binary mask of objects, 255 is the only value.
    view.state = FileState::kUnreadable;
    warnings_.add({view.directory, "/", stem, kExtension,
                   ": holds nothing but 255, which 8-bit masks mean to be ignored; number its objects from 1"});
  }
}

void MaskFileSegmenter::reset() {
  loaded_ = false;
}

}  // namespace kinetrace::segmentation
