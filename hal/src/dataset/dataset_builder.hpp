// Common to all layouts: makes a list of frames from image folders and times, and does the final checks.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "calibration/calibration_reader.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/hal/dataset.hpp"
#include "util/image_folder.hpp"

namespace kinetrace::hal {

/// Where a sequence's images and times come from.
struct SequenceFiles {
  ImageFolder left;
  ImageFolder right;
  std::filesystem::path times_path;  ///< One time per line; empty or missing: `rate_hz` is assumed.
  double rate_hz = 10.0;
  /// "NUMBER NANOSECONDS" per line, as our recorder writes it; overrides `times_path`. Its end and the newest images
  /// may be missing: only frames with a complete line count.
  std::filesystem::path frame_times_path{};
  /// Times of the right camera, for comparison only; a note if they differ from those of the left.
  std::filesystem::path right_times_path{};
};

/// Pairs images by stem and gives every stem its number and time. The digits at the end of the stems are times if all
/// of them are dates (YYYYMMDDhhmmss, also with milliseconds), 16 to 19 digits of nanoseconds or 16 of microseconds, at
/// steps plausible for a camera. Otherwise they are frame numbers or, if unsuitable for that (equal, none, out of the
/// range of a FrameList), the position in the list is. `times_path` overrides times in names: its lines are indexed by
/// number, or one per frame. An existing `frame_times_path` overrides both. Then as finish_dataset.
[[nodiscard]] Result<Dataset> build_dataset(std::string name, const SequenceFiles& files, const DatasetSpec& spec,
                                            const CalibrationReader& read_calibration);

/// Adds rate, notes and calibration to a dataset with name, frames and file size. Errors: kInvalidArgument if no frame
/// has both sides, kBadFormat if no pair is readable (names the problem of the first), kBadCalibration.
[[nodiscard]] Result<Dataset> finish_dataset(Dataset dataset, double fallback_rate_hz,
                                             const CalibrationReader& read_calibration);

/// Steps between frames that are implausible for a camera are an error that names the file of the times; single ones
/// become a note. Errors: kBadFormat.
[[nodiscard]] Status check_steps(Dataset& dataset);

/// Frame numbers of ascending times: 0 for the first, then steps of whole periods, at least one; consecutive numbers if
/// gaps would exceed the range of a FrameList.
[[nodiscard]] std::vector<std::int64_t> numbers_from_times(const std::vector<std::int64_t>& times_ns,
                                                           std::int64_t period_ns);
[[nodiscard]] std::int64_t median_step_ns(const std::vector<std::int64_t>& times_ns, std::int64_t fallback_ns);

/// Folders of the two views, e.g. "image_00" and "image_01".
struct ViewPair {
  std::string left;
  std::string right;
};
/// The pair of views under `root` for `choice`; kAuto takes gray if both views exist, else colour. Errors: kNotFound,
/// with the names of the expected folders.
[[nodiscard]] Result<ViewPair> choose_views(const std::filesystem::path& root, CameraChoice choice,
                                            const ViewPair& gray, const ViewPair& color);

/// `wanted` if it is among the sequences; the only sequence if `wanted` is empty. Errors: kInvalidArgument, lists the
/// sequences.
[[nodiscard]] Result<std::string> choose_sequence(const std::filesystem::path& root, const std::string& wanted,
                                                  const std::vector<std::string>& sequences);

[[nodiscard]] double rate_or(const DatasetSpec& spec, double fallback_rate_hz);

}  // namespace kinetrace::hal
