// Container recordings of `kinetrace record`, see container_file.hpp.
#include <algorithm>
#include <array>
#include <cstdio>
#include <memory>

#include "dataset/dataset_builder.hpp"
#include "dataset/layouts.hpp"
#include "formats/calibration_text.hpp"
#include "formats/container_recording.hpp"
#include "util/image_folder.hpp"
#include "util/messages.hpp"

namespace kinetrace::hal {
namespace {

namespace fs = std::filesystem;

Result<std::vector<fs::path>> container_files(const fs::path& folder) {
  std::vector<fs::path> paths;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    if (entry->path().extension() == kContainerSuffix) {
      paths.push_back(entry->path());
    }
  }
  if (paths.empty()) {
    return fail(ErrorCode::kNotFound,
                concat(folder.string(), ": no container recording here (looked for *", kContainerSuffix, ")"));
  }
  std::sort(paths.begin(), paths.end());
  return paths;
}

std::string ten_digits(std::int64_t number) {
  std::array<char, 24> text{};
  std::snprintf(text.data(), text.size(), "%010lld", static_cast<long long>(number));
  return text.data();
}

// Damage of a recording, for the notes.
struct Damage {
  std::int64_t records = 0;
  std::int64_t out_of_order = 0;
};

Status add_records(const ContainerFile& file, FrameList& frames, ContainerRecording& recording, Damage& damage) {
  return file.for_each_record([&](std::int64_t number, const std::optional<RecordHeader>& record) {
    if (!record || !FrameList::holds(record->frame_index, record->timestamp_ns)) {
      ++damage.records;
      return;
    }
    const std::string stem = ten_digits(record->frame_index);
    if (frames.add({record->frame_index, record->timestamp_ns, stem, stem})) {
      recording.add_frame(number);
    } else {
      ++damage.out_of_order;
    }
  });
}

Status check_same(const fs::path& path, const ContainerHeader& first, const ContainerHeader& header) {
  if (header.width_px != first.width_px || header.height_px != first.height_px ||
      header.calibration != first.calibration) {
    return fail(ErrorCode::kBadFormat, path.string() + ": belongs to another recording than the files before it");
  }
  return {};
}

Status complete(Dataset& dataset, const ContainerHeader& header, const fs::path& first_file, const Damage& damage) {
  if (dataset.frames.empty()) {
    return fail(ErrorCode::kBadFormat, first_file.string() + ": holds no whole frame");
  }
  auto calibration = parse_calibration_text(header.calibration, first_file.string());
  if (!calibration) {
    return Unexpected(calibration.error());
  }
  dataset.calibration = std::move(*calibration);
  if (Status steps = check_steps(dataset); !steps) {
    return steps;
  }
  constexpr double kFallbackRate_hz = 10.0;
  const double rate_hz = header.rate_hz > 0.0 ? header.rate_hz : kFallbackRate_hz;
  dataset.nominal_rate_hz =
      1e9 / static_cast<double>(dataset.frames.median_period_ns(static_cast<std::int64_t>(1e9 / rate_hz)));
  if (damage.records + damage.out_of_order > 0) {
    dataset.notes.push_back(concat(std::to_string(damage.records), " records are damaged and ",
                                   std::to_string(damage.out_of_order), " out of order; they are left out"));
  }
  return dataset.calibration.validate();
}

}  // namespace

Result<Dataset> open_container(const DatasetSpec& spec) {
  const fs::path folder = spec.sequence.empty() ? spec.path : spec.path / spec.sequence;
  const auto paths = container_files(folder);
  if (!paths) {
    return Unexpected(paths.error());
  }
  Dataset dataset;
  dataset.name = fs::weakly_canonical(folder).filename().string();
  dataset.frames = FrameList({folder.string(), kContainerSuffix}, {folder.string(), kContainerSuffix});
  auto recording = std::make_shared<ContainerRecording>();
  std::optional<ContainerHeader> header;
  Damage damage;
  for (const fs::path& path : *paths) {
    auto file = ContainerFile::open(path);
    // The newest file may have been cut within its header.
    if (!file && header && file.error().code == ErrorCode::kBadFormat && path == paths->back()) {
      dataset.notes.push_back(file.error().message);
      break;
    }
    if (!file) {
      return Unexpected(file.error());
    }
    if (!header) {
      header = file->header();
    }
    if (const Status same = check_same(path, *header, file->header()); !same) {
      return Unexpected(same.error());
    }
    if (file->trailing_bytes() > 0) {
      dataset.notes.push_back(concat(path.string(), ": its last ", std::to_string(file->trailing_bytes()),
                                     " bytes are no whole record; was it copied completely?"));
    }
    recording->add_file(std::move(*file));
    if (const Status added = add_records(recording->newest_file(), dataset.frames, *recording, damage); !added) {
      return Unexpected(added.error());
    }
  }
  if (const Status completed = complete(dataset, *header, paths->front(), damage); !completed) {
    return Unexpected(completed.error());
  }
  dataset.container = std::move(recording);
  return dataset;
}

}  // namespace kinetrace::hal
