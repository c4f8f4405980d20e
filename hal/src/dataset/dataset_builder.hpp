// What all layouts share: from image folders and times to a list of frames, and the final checks.
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
  std::filesystem::path times_path;  ///< One time per line; empty or not there: `rate_hz` is assumed.
  double rate_hz = 10.0;
  /// "NUMBER NANOSECONDS" per line, as our recorder writes it; wins over `times_path` where it is there. Its end and
  /// the newest images may be missing: only frames with a whole line count.
  std::filesystem::path frame_times_path{};
  /// The right camera's, for comparison alone; a note where they are not those of the left.
  std::filesystem::path right_times_path{};
};

/// Pairs images by stem and gives every stem its number and time. The digits that the stems end with are times, if all
/// of them are dates (YYYYMMDDhhmmss, also with milliseconds) or 16 to 19 digits of nanoseconds, or 16 of microseconds,
/// and come at steps that a camera may have. Otherwise they are the number or, if those are no use (equal, none, beyond
/// what a FrameList holds), the place in the list is. A `times_path` comes before times in names: its lines by
/// number, or one per frame. Where `frame_times_path` is there, it alone counts. Then as finish_dataset.
[[nodiscard]] Result<Dataset> build_dataset(std::string name, const SequenceFiles& files, const DatasetSpec& spec,
                                            const CalibrationReader& read_calibration);

/// Completes a dataset whose name, frames and file size are known: rate, notes, calibration. Errors: kInvalidArgument
/// if no frame has both sides, kBadFormat if no pair is readable (says what is wrong with the first), kBadCalibration.
[[nodiscard]] Result<Dataset> finish_dataset(Dataset dataset, double fallback_rate_hz,
                                             const CalibrationReader& read_calibration);

/// Steps between frames that no camera has are an error that names the file of the times; single ones become a note.
/// Errors: kBadFormat.
[[nodiscard]] Status check_steps(Dataset& dataset);

/// Frame numbers of ascending times: 0 for the first, then as many steps as periods fit, at least one; one by one where
/// gaps would lead beyond what a FrameList holds.
[[nodiscard]] std::vector<std::int64_t> numbers_from_times(const std::vector<std::int64_t>& times_ns,
                                                           std::int64_t period_ns);
[[nodiscard]] std::int64_t median_step_ns(const std::vector<std::int64_t>& times_ns, std::int64_t fallback_ns);

/// Folders of the two views, e.g. "image_00" and "image_01".
struct ViewPair {
  std::string left;
  std::string right;
};
/// The pair under `root` that `choice` asks for; kAuto takes gray where both views are there, else colour.
/// Errors: kNotFound, naming the folders looked for.
[[nodiscard]] Result<ViewPair> choose_views(const std::filesystem::path& root, CameraChoice choice,
                                            const ViewPair& gray, const ViewPair& color);

/// `wanted` if it is among the sequences, or the only one if nothing is wanted. Errors: kInvalidArgument, listing them.
[[nodiscard]] Result<std::string> choose_sequence(const std::filesystem::path& root, const std::string& wanted,
                                                  const std::vector<std::string>& sequences);

[[nodiscard]] double rate_or(const DatasetSpec& spec, double fallback_rate_hz);

}  // namespace kinetrace::hal
