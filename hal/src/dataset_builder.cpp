#include "dataset_builder.hpp"

#include <algorithm>
#include <cmath>

#include "kinetrace/imaging/image_info.hpp"
#include "messages.hpp"
#include "text_file.hpp"

namespace kinetrace::hal {
namespace {

// A stem with the sides it is there on.
struct Member {
  std::string stem;
  bool left = false;
  bool right = false;
};

std::int64_t period_ns(double rate_hz) {
  return static_cast<std::int64_t>(std::llround(1e9 / rate_hz));
}

// How stems are numbered and timed.
enum class Numbering { kTimes, kNumbers, kPlaces };

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

Numbering numbering_of(const std::vector<Member>& members) {
  constexpr std::size_t kFewestTimeDigits = 16;
  bool times = true;
  for (std::size_t i = 0; i < members.size(); ++i) {
    const auto value = trailing_number(members[i].stem);
    if (!value || (i > 0 && *value == trailing_number(members[i - 1].stem))) {
      return Numbering::kPlaces;
    }
    times = times && members[i].stem.size() >= kFewestTimeDigits &&
            members[i].stem.find_first_not_of("0123456789") == std::string::npos;
  }
  return times ? Numbering::kTimes : Numbering::kNumbers;
}

std::vector<std::int64_t> numbers_of(const std::vector<Member>& members, Numbering numbering) {
  std::vector<std::int64_t> numbers;
  numbers.reserve(members.size());
  for (const Member& member : members) {
    numbers.push_back(numbering == Numbering::kPlaces ? static_cast<std::int64_t>(numbers.size())
                                                      : trailing_number(member.stem).value());
  }
  return numbers;
}

// Times of the frames from a file with one line per frame number or, for a clip cut from a longer recording, one line
// per frame.
Result<std::vector<std::int64_t>> times_from_file(const std::filesystem::path& path,
                                                  const std::vector<std::int64_t>& numbers) {
  Result<std::vector<std::int64_t>> lines = read_times_ns(path);
  if (!lines) {
    return lines;
  }
  const bool line_per_number = static_cast<std::size_t>(numbers.back()) < lines->size();
  if (!line_per_number && lines->size() != numbers.size()) {
    return fail(ErrorCode::kBadFormat,
                concat(path.string(), ": has ", std::to_string(lines->size()), " times, but there is a frame number ",
                       std::to_string(numbers.back()), "; it must have one line per frame"));
  }
  std::vector<std::int64_t> times;
  times.reserve(numbers.size());
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    times.push_back((*lines)[line_per_number ? static_cast<std::size_t>(numbers[i]) : i]);
  }
  return times;
}

std::vector<std::int64_t> times_at_rate(const std::vector<std::int64_t>& numbers, double rate_hz) {
  std::vector<std::int64_t> times;
  times.reserve(numbers.size());
  for (const std::int64_t number : numbers) {
    times.push_back(static_cast<std::int64_t>(std::llround(static_cast<double>(number) * 1e9 / rate_hz)));
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

// Number and time of each frame.
struct Timeline {
  std::vector<std::int64_t> numbers;
  std::vector<std::int64_t> times_ns;
};

// As the recorder wrote it. Frames that it did not come to the end of are left out.
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
  timeline.numbers = numbers_of(members, Numbering::kNumbers);
  for (const std::int64_t number : timeline.numbers) {
    timeline.times_ns.push_back(times->at(number));
  }
  return timeline;
}

// From the names of the files and the list of times. Adds a note where times had to be assumed.
Result<Timeline> deduced_timeline(const SequenceFiles& files, const std::vector<Member>& members,
                                  std::vector<std::string>& notes) {
  const Numbering numbering = numbering_of(members);
  Timeline timeline;
  timeline.numbers = numbers_of(members, numbering);
  if (numbering == Numbering::kTimes) {
    timeline.times_ns = timeline.numbers;
    timeline.numbers =
        numbers_from_times(timeline.times_ns, median_step_ns(timeline.times_ns, period_ns(files.rate_hz)));
  } else if (is_file(files.times_path)) {
    Result<std::vector<std::int64_t>> read = times_from_file(files.times_path, timeline.numbers);
    if (!read) {
      return Unexpected(read.error());
    }
    timeline.times_ns = std::move(*read);
  } else {
    timeline.times_ns = times_at_rate(timeline.numbers, files.rate_hz);
    notes.push_back(concat("no time stamps for ", files.left.files.folder, ": ", number(files.rate_hz), " Hz assumed"));
  }
  return timeline;
}

// Fills the frames and the file size.
Status add_frames(const SequenceFiles& files, Dataset& dataset) {
  std::vector<Member> members = merged(files.left, files.right);
  const Result<Timeline> timeline = is_file(files.frame_times_path)
                                        ? recorded_timeline(files.frame_times_path, members, dataset.notes)
                                        : deduced_timeline(files, members, dataset.notes);
  if (!timeline) {
    return Unexpected(timeline.error());
  }
  dataset.frames = FrameList(files.left.files, files.right.files);
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

std::string file_path(const FrameFolder& folder, std::string_view stem) {
  return concat(folder.folder, "/", stem, folder.suffix);
}

// Size of the first pair with readable headers of one size.
Result<ImageSize> probe_image_size(const FrameList& frames) {
  std::optional<Error> first_problem;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const FrameList::Frame frame = frames[i];
    if (!frame.complete()) {
      continue;
    }
    const std::string left_path = file_path(frames.left(), frame.left_stem);
    const std::string right_path = file_path(frames.right(), frame.right_stem);
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
                                              "; both eyes must have one size")};
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
  if (steps.empty()) {
    return fallback_ns;
  }
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return std::max<std::int64_t>(*middle, 1);
}

std::vector<std::int64_t> numbers_from_times(const std::vector<std::int64_t>& times_ns, std::int64_t period_ns) {
  std::vector<std::int64_t> numbers;
  numbers.reserve(times_ns.size());
  for (std::size_t i = 0; i < times_ns.size(); ++i) {
    const std::int64_t steps = i == 0 ? 0 : (times_ns[i] - times_ns[i - 1] + period_ns / 2) / period_ns;
    numbers.push_back(i == 0 ? 0 : numbers.back() + std::max<std::int64_t>(steps, 1));
  }
  return numbers;
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
  return dataset;
}

Result<EyePair> choose_eyes(const std::filesystem::path& root, CameraChoice choice, const EyePair& gray,
                            const EyePair& color) {
  const auto present = [&root](const EyePair& eyes) {
    return !eyes.left.empty() && is_folder(root / eyes.left) && is_folder(root / eyes.right);
  };
  if (choice != CameraChoice::kColor && present(gray)) {
    return gray;
  }
  if (choice != CameraChoice::kGray && present(color)) {
    return color;
  }
  const auto named = [](const EyePair& eyes) { return eyes.left + " and " + eyes.right; };
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
                     "; choose one: ", listed(sequences)));
}

double rate_or(const DatasetSpec& spec, double fallback_rate_hz) {
  return spec.frame_rate_hz > 0 ? spec.frame_rate_hz : fallback_rate_hz;
}

}  // namespace kinetrace::hal
