#include "dataset/dataset_builder.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "dataset/image_files.hpp"
#include "kinetrace/core/quantiles.hpp"
#include "kinetrace/imaging/image_info.hpp"
#include "util/messages.hpp"
#include "util/text_file.hpp"

namespace kinetrace::hal {
namespace {

// The highest rate of a DatasetSpec is 1000 Hz; times at ten times that rate have another unit. Frames more than a day
// apart show no motion that can be tracked: their times are wrong or have another unit, too.
constexpr std::int64_t kFastestStep_ns = 1'000'000;
constexpr std::int64_t kMinStep_ns = kFastestStep_ns / 10;
constexpr std::int64_t kSlowestStep_ns = std::int64_t{24} * 3600 * 1'000'000'000;

// Slower than any camera used for tracking: probably milliseconds taken for seconds.
constexpr std::int64_t kSlowStep_ns = std::int64_t{10} * 1'000'000'000;

// A stem and the sides on which it exists.
struct Member {
  std::string stem;
  bool left = false;
  bool right = false;
};

std::int64_t period_ns(double rate_hz) {
  return static_cast<std::int64_t>(std::llround(1e9 / rate_hz));
}

std::vector<Member> merged(const ImageFolder& left, const ImageFolder& right) {
  std::vector<Member> members;
  members.reserve(left.stems.size());
  for (const std::string& stem : left.stems) {
    members.push_back({stem, true, false});
  }
  for (const std::string& stem : right.stems) {
    members.push_back({stem, false, true});
  }
  const auto before = [](const Member& a, const Member& b) {
    const auto number_a = trailing_number(a.stem);
    const auto number_b = trailing_number(b.stem);
    return number_a != number_b ? number_a < number_b : a.stem < b.stem;
  };
  std::stable_sort(members.begin(), members.end(), before);
  std::vector<Member> unique;
  unique.reserve(members.size());
  for (Member& member : members) {
    if (!unique.empty() && unique.back().stem == member.stem) {
      unique.back().left |= member.left;
      unique.back().right |= member.right;
    } else {
      unique.push_back(std::move(member));
    }
  }
  return unique;
}

// Numbers that the stems end with, if they tell the frames apart and fit into a FrameList.
std::optional<std::vector<std::int64_t>> numbers_of(const std::vector<Member>& members) {
  std::vector<std::int64_t> numbers;
  numbers.reserve(members.size());
  for (const Member& member : members) {
    const auto value = trailing_number(member.stem);
    if (!value || *value > FrameList::kMaxFrameIndex || (!numbers.empty() && *value == numbers.back())) {
      return std::nullopt;
    }
    numbers.push_back(*value);
  }
  return numbers;
}

std::vector<std::int64_t> numbers_by_place(std::size_t count) {
  std::vector<std::int64_t> numbers(count);
  std::iota(numbers.begin(), numbers.end(), 0);
  return numbers;
}

// A time format of the digits of a stem.
struct StemClock {
  std::size_t min_digits;
  std::size_t max_digits;
  std::optional<std::int64_t> (*time_ns)(std::string_view digits);
};

std::optional<std::int64_t> parse_microseconds_ns(std::string_view digits) {
  const auto time_us = parse_integer(digits);
  constexpr std::int64_t kMicrosecond_ns = 1000;
  return time_us && *time_us <= FrameList::kMaxTime_ns / kMicrosecond_ns ? std::optional(*time_us * kMicrosecond_ns)
                                                                         : std::nullopt;
}

// In order of trial; the last two count from 1970.
constexpr std::array<StemClock, 4> kStemClocks{{
    {14, 14, parse_calendar_ns},  // YYYYMMDDhhmmss
    {17, 17, parse_calendar_ns},  // With milliseconds.
    {16, 19, parse_integer},
    {16, 16, parse_microseconds_ns},
}};

std::string_view trailing_digits(std::string_view stem) {
  return stem.substr(stem.find_last_not_of("0123456789") + 1);
}

// Times of all stems by one clock; none if a stem is no time or if the steps are implausible for a camera: then the
// digits have another meaning.
std::optional<std::vector<std::int64_t>> times_by(const StemClock& clock, const std::vector<Member>& members) {
  std::vector<std::int64_t> times_ns;
  times_ns.reserve(members.size());
  for (const Member& member : members) {
    const std::string_view digits = trailing_digits(member.stem);
    const bool has_length = digits.size() >= clock.min_digits && digits.size() <= clock.max_digits;
    const auto time_ns = has_length ? clock.time_ns(digits) : std::nullopt;
    if (!time_ns || !FrameList::holds_time(*time_ns) || (!times_ns.empty() && *time_ns <= times_ns.back())) {
      return std::nullopt;
    }
    times_ns.push_back(*time_ns);
  }
  const std::int64_t step_ns = median_step_ns(times_ns, kFastestStep_ns);
  const bool is_plausible = step_ns >= kFastestStep_ns && step_ns <= kSlowestStep_ns;
  return is_plausible ? std::optional(std::move(times_ns)) : std::nullopt;
}

std::optional<std::vector<std::int64_t>> times_of(const std::vector<Member>& members) {
  for (const StemClock& clock : kStemClocks) {
    if (auto times_ns = times_by(clock, members)) {
      return times_ns;
    }
  }
  return std::nullopt;
}

// Times of the frames from a file with one line per frame number or, for a clip cut from a longer recording, one line
// per frame.
Result<std::vector<std::int64_t>> times_from_file(const std::filesystem::path& path,
                                                  const std::vector<std::int64_t>& numbers, bool numbered_by_place) {
  Result<std::vector<std::int64_t>> lines = read_times_ns(path);
  if (!lines || lines->size() == numbers.size()) {
    return lines;
  }
  if (numbered_by_place || static_cast<std::size_t>(numbers.back()) >= lines->size()) {
    return fail(ErrorCode::kBadFormat, concat(path.string(), ": has ", std::to_string(lines->size()), " times for ",
                                              std::to_string(numbers.size()), " frames up to number ",
                                              std::to_string(numbers.back()), "; it must have one line per frame"));
  }
  std::vector<std::int64_t> times;
  times.reserve(numbers.size());
  for (const std::int64_t number : numbers) {
    times.push_back((*lines)[static_cast<std::size_t>(number)]);
  }
  return times;
}

std::vector<std::int64_t> times_at_rate(const std::vector<std::int64_t>& numbers, double rate_hz) {
  std::vector<std::int64_t> times;
  times.reserve(numbers.size());
  for (const std::int64_t number : numbers) {
    constexpr double kBeyond_ns = 1.5 * static_cast<double>(FrameList::kMaxTime_ns);  // Still fits into 64 bits.
    times.push_back(std::llround(std::min(static_cast<double>(number) * 1e9 / rate_hz, kBeyond_ns)));
  }
  return times;
}

void note_missing_sides(Dataset& dataset) {
  const std::size_t incomplete = dataset.frames.size() - dataset.frames.complete_count();
  if (incomplete > 0) {
    dataset.notes.push_back(concat(std::to_string(incomplete), " of ", std::to_string(dataset.frames.size()),
                                   " frames have only one side and will be skipped"));
  }
}

std::string step_text(std::int64_t step_ns) {
  return step_ns < kFastestStep_ns ? concat(std::to_string(step_ns), " ns")
                                   : concat(number(static_cast<double>(step_ns) * 1e-9), " s");
}

// Number and time of each frame.
struct Timeline {
  std::vector<std::int64_t> numbers;
  std::vector<std::int64_t> times_ns;
  std::string source;  // Of the times.
};

// The timeline that the recorder wrote, without unfinished frames.
Result<Timeline> recorded_timeline(const std::filesystem::path& path, std::vector<Member>& members,
                                   std::vector<std::string>& notes) {
  const auto times = read_frame_times_ns(path);
  if (!times) {
    return Unexpected(times.error());
  }
  const std::size_t unfinished = std::erase_if(members, [&times](const Member& member) {
    const auto number = trailing_number(member.stem);
    return !number || times->count(*number) == 0;
  });
  if (members.empty()) {
    return fail(ErrorCode::kBadFormat, path.string() + ": has no time of any image; not one frame was recorded whole");
  }
  if (unfinished > 0) {
    notes.push_back(concat(std::to_string(unfinished), " frames were not recorded whole; they are left out"));
  }
  Timeline timeline;
  timeline.source = path.string();
  for (const Member& member : members) {
    timeline.numbers.push_back(trailing_number(member.stem).value());
    timeline.times_ns.push_back(times->at(timeline.numbers.back()));
  }
  return timeline;
}

// Deduces the timeline from file names and the list of times. Adds a note if numbers or times are assumed.
Result<Timeline> deduced_timeline(const SequenceFiles& files, const std::vector<Member>& members,
                                  std::vector<std::string>& notes) {
  const std::string& folder = files.left.files.folder;
  const auto name_times = times_of(members);
  const auto name_numbers = name_times ? std::nullopt : numbers_of(members);
  Timeline timeline{name_numbers ? *name_numbers : numbers_by_place(members.size()), {}, folder};
  if (!name_numbers && !name_times) {
    notes.push_back(concat(folder, ": the names of the images hold no frame numbers up to ",
                           std::to_string(FrameList::kMaxFrameIndex), "; numbered in the order of their names"));
  }
  if (is_there(files.times_path)) {
    Result<std::vector<std::int64_t>> read = times_from_file(files.times_path, timeline.numbers, !name_numbers);
    if (!read && !name_times) {
      return Unexpected(read.error());
    }
    if (read) {
      timeline.times_ns = std::move(*read);
      timeline.source = files.times_path.string();
    } else {
      notes.push_back(read.error().message + "; the times in the names of the images are used");
      timeline.times_ns = *name_times;
    }
  } else if (name_times) {
    timeline.times_ns = *name_times;
  } else {
    timeline.times_ns = times_at_rate(timeline.numbers, files.rate_hz);
    notes.push_back(concat("no time stamps for ", folder, ": ", number(files.rate_hz), " Hz assumed"));
  }
  if (name_times) {
    timeline.numbers =
        numbers_from_times(timeline.times_ns, median_step_ns(timeline.times_ns, period_ns(files.rate_hz)));
  }
  return timeline;
}

// The cameras of a rig are triggered together: their times differ by far less than a period.
void note_disagreeing_times(const SequenceFiles& files, std::vector<std::string>& notes) {
  if (!is_there(files.times_path) || !is_there(files.right_times_path)) {
    return;
  }
  const auto left = read_times_ns(files.times_path);
  const auto right = read_times_ns(files.right_times_path);
  if (!left || !right) {
    notes.push_back(concat(right ? left.error().message : right.error().message,
                           "; the times of both cameras could not be compared"));
    return;
  }
  if (left->size() != right->size()) {
    notes.push_back(concat(files.right_times_path.string(), ": has ", std::to_string(right->size()),
                           " times, the left camera's has ", std::to_string(left->size()),
                           "; are these images of one recording?"));
    return;
  }
  const std::int64_t tolerance_ns = median_step_ns(*left, period_ns(files.rate_hz)) / 4;
  std::size_t apart = 0;
  for (std::size_t i = 0; i < left->size(); ++i) {
    apart += std::abs((*right)[i] - (*left)[i]) > tolerance_ns ? 1 : 0;
  }
  if (apart > 0) {
    notes.push_back(concat(files.right_times_path.string(), ": ", std::to_string(apart), " of ",
                           std::to_string(left->size()),
                           " times are more than a quarter of a frame from the left camera's; ",
                           "were both images of a pair taken at one time?"));
  }
}

// Fills the frames and the file size.
Status add_frames(const SequenceFiles& files, Dataset& dataset) {
  std::vector<Member> members = merged(files.left, files.right);
  const Result<Timeline> timeline = is_there(files.frame_times_path)
                                        ? recorded_timeline(files.frame_times_path, members, dataset.notes)
                                        : deduced_timeline(files, members, dataset.notes);
  if (!timeline) {
    return Unexpected(timeline.error());
  }
  note_disagreeing_times(files, dataset.notes);
  dataset.frames = FrameList(files.left.files, files.right.files, timeline->source);
  for (std::size_t i = 0; i < members.size(); ++i) {
    const Member& member = members[i];
    Status added =
        dataset.frames.add({timeline->numbers[i], timeline->times_ns[i], member.left ? member.stem : std::string_view(),
                            member.right ? member.stem : std::string_view()});
    if (!added) {
      return added;
    }
  }
  dataset.max_file_bytes = std::max(files.left.max_file_bytes, files.right.max_file_bytes);
  return {};
}

// Size of the first pair with readable headers of one size.
Result<ImageSize> probe_image_size(const FrameList& frames) {
  std::optional<Error> first_problem;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const FrameList::Frame frame = frames[i];
    if (!frame.complete()) {
      continue;
    }
    const std::string left_path = image_path(frames.left(), frame.left_stem);
    const std::string right_path = image_path(frames.right(), frame.right_stem);
    const auto left = imaging::read_image_info(left_path.c_str());
    const auto right = imaging::read_image_info(right_path.c_str());
    if (left && right && left->width == right->width && left->height == right->height) {
      return ImageSize{left->width, left->height};
    }
    if (!first_problem) {
      first_problem = !left    ? left.error()
                      : !right ? right.error()
                               : Error{ErrorCode::kBadFormat,
                                       concat(right_path, ": is ", size_text(right->width, right->height),
                                              " pixels, but the left image is ", size_text(left->width, left->height),
                                              "; both views must have one size")};
    }
  }
  if (!first_problem) {
    return fail(ErrorCode::kInvalidArgument, concat(frames.left().folder, ", ", frames.right().folder,
                                                    ": no image has a partner of the same name on the other side"));
  }
  return fail(ErrorCode::kBadFormat,
              concat("no readable pair in ", frames.left().folder, "; the first: ", first_problem->message));
}

Status check_calibration(Dataset& dataset, const ImageSize& size) {
  const RigCalibration& calibration = dataset.calibration;
  if (Status valid = dataset.calibration.validate(); !valid) {
    return valid;
  }
  if (calibration.raw_width_px() != size.width_px || calibration.raw_height_px() != size.height_px) {
    return fail(ErrorCode::kBadCalibration,
                concat(calibration.source, ": is for images of ",
                       size_text(calibration.raw_width_px(), calibration.raw_height_px()), ", but those in ",
                       dataset.frames.left().folder, " are ", size_text(size.width_px, size.height_px),
                       "; use the calibration of these images"));
  }
  return {};
}

}  // namespace

std::int64_t median_step_ns(const std::vector<std::int64_t>& times_ns, std::int64_t fallback_ns) {
  std::vector<std::int64_t> steps;
  for (std::size_t i = 1; i < times_ns.size(); ++i) {
    steps.push_back(times_ns[i] - times_ns[i - 1]);
  }
  return steps.empty() ? fallback_ns : std::max<std::int64_t>(median(steps), 1);
}

Status check_steps(Dataset& dataset) {
  const FrameList& frames = dataset.frames;
  const std::int64_t step_ns = frames.median_period_ns(kFastestStep_ns);
  if (step_ns < kMinStep_ns || step_ns > kSlowestStep_ns) {
    return fail(ErrorCode::kBadFormat,
                concat(frames.times_source(), ": frames are ", step_text(step_ns),
                       " apart (median), and no camera takes images at less than 0.1 ms or more than a day; correct "
                       "the unit of the times"));
  }
  if (step_ns < kFastestStep_ns) {
    dataset.notes.push_back(concat(frames.times_source(), ": frames are ", step_text(step_ns),
                                   " apart (median), which is faster than 1000 Hz; is the unit of the times right?"));
  }
  if (step_ns > kSlowStep_ns) {
    dataset.notes.push_back(concat(frames.times_source(), ": frames are ", step_text(step_ns),
                                   " apart (median), too far to follow anything; are these seconds?"));
  }
  std::size_t odd_steps = 0;
  for (std::size_t i = 1; i < frames.size(); ++i) {
    const std::int64_t odd_ns = frames[i].timestamp_ns - frames[i - 1].timestamp_ns;
    odd_steps += odd_ns < kMinStep_ns || odd_ns > kSlowestStep_ns ? 1 : 0;
  }
  if (odd_steps > 0) {
    dataset.notes.push_back(concat(frames.times_source(), ": ", std::to_string(odd_steps),
                                   " of the steps between frames are shorter than 0.1 ms or longer than a day; are "
                                   "these times right?"));
  }
  return {};
}

std::vector<std::int64_t> numbers_from_times(const std::vector<std::int64_t>& times_ns, std::int64_t period_ns) {
  std::vector<std::int64_t> numbers;
  numbers.reserve(times_ns.size());
  for (std::size_t i = 0; i < times_ns.size(); ++i) {
    const std::int64_t steps = i == 0 ? 0 : (times_ns[i] - times_ns[i - 1] + period_ns / 2) / period_ns;
    numbers.push_back(i == 0 ? 0 : numbers.back() + std::max<std::int64_t>(steps, 1));
  }
  return numbers.empty() || numbers.back() <= FrameList::kMaxFrameIndex ? numbers : numbers_by_place(numbers.size());
}

Result<Dataset> build_dataset(std::string name, const SequenceFiles& files, const DatasetSpec& spec,
                              const CalibrationReader& read_calibration) {
  Dataset dataset;
  dataset.name = std::move(name);
  SequenceFiles timed = files;
  timed.rate_hz = rate_or(spec, files.rate_hz);
  if (const Status added = add_frames(timed, dataset); !added) {
    return Unexpected(added.error());
  }
  return finish_dataset(std::move(dataset), timed.rate_hz, read_calibration);
}

Result<Dataset> finish_dataset(Dataset dataset, double fallback_rate_hz, const CalibrationReader& read_calibration) {
  if (const Status steps = check_steps(dataset); !steps) {
    return Unexpected(steps.error());
  }
  dataset.nominal_rate_hz = 1e9 / static_cast<double>(dataset.frames.median_period_ns(period_ns(fallback_rate_hz)));
  note_missing_sides(dataset);
  const Result<ImageSize> size = probe_image_size(dataset.frames);
  if (!size) {
    return Unexpected(size.error());
  }
  Result<RigCalibration> rig = read_calibration(*size);
  if (!rig) {
    return Unexpected(rig.error());
  }
  dataset.calibration = std::move(*rig);
  if (const Status fits = check_calibration(dataset, *size); !fits) {
    return Unexpected(fits.error());
  }
  find_sample_bits(dataset);
  return dataset;
}

Result<ViewPair> choose_views(const std::filesystem::path& root, CameraChoice choice, const ViewPair& gray,
                              const ViewPair& color) {
  const auto present = [&root](const ViewPair& views) {
    return !views.left.empty() && is_folder(root / views.left) && is_folder(root / views.right);
  };
  if (choice != CameraChoice::kColor && present(gray)) {
    return gray;
  }
  if (choice != CameraChoice::kGray && present(color)) {
    return color;
  }
  for (const ViewPair& views : {gray, color}) {
    if (!views.left.empty() && is_folder(root / views.left) != is_folder(root / views.right)) {
      const std::string& missing = is_folder(root / views.left) ? views.right : views.left;
      return fail(ErrorCode::kNotFound,
                  concat((root / missing).string(), ": no such folder; images of both views are needed"));
    }
  }
  const auto named = [](const ViewPair& views) { return views.left + " and " + views.right; };
  std::string looked_for = choice == CameraChoice::kColor ? named(color) : named(gray);
  if (choice == CameraChoice::kAuto) {
    looked_for += ", or " + named(color);
  }
  return fail(ErrorCode::kNotFound, concat(root.string(), ": no image folders (looked for ", looked_for,
                                           "); check the path, the layout and the choice of cameras"));
}

Result<std::string> choose_sequence(const std::filesystem::path& root, const std::string& wanted,
                                    const std::vector<std::string>& sequences) {
  if (wanted.empty() && sequences.size() == 1) {
    return sequences.front();
  }
  if (std::find(sequences.begin(), sequences.end(), wanted) != sequences.end()) {
    return wanted;
  }
  return fail(ErrorCode::kInvalidArgument,
              concat(root.string(), wanted.empty() ? ": several sequences" : ": no sequence '" + wanted + "'",
                     "; choose one with --sequence: ", listed(sequences)));
}

double rate_or(const DatasetSpec& spec, double fallback_rate_hz) {
  return spec.frame_rate_hz > 0 ? spec.frame_rate_hz : fallback_rate_hz;
}

}  // namespace kinetrace::hal
