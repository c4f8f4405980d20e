#include "kinetrace/recording/observations.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "buffered_file.hpp"
#include "observation_file.hpp"

namespace kinetrace::recording {
namespace {

bool is_usable(const Observation& seen) {
  constexpr float kFarthest_px = 1e6F;  // No image reaches that far.
  const auto is_inside = [](float at_px) { return std::abs(at_px) < kFarthest_px; };
  return seen.point_id > 0 && is_inside(seen.u_left_px) && is_inside(seen.v_px) &&
         (std::isnan(seen.u_right_px) || is_inside(seen.u_right_px));
}

}  // namespace

struct ObservationReader::Impl {
  std::filesystem::path path;
  FileHandle file;
  std::uint64_t count = 0;  ///< Records of the file.
  std::uint64_t next = 0;   ///< Record that is read next.
  std::vector<Observation> block;
  std::size_t used = 0;  ///< Of the block.
  std::vector<Observation> frame;

  [[nodiscard]] Unexpected<Error> damaged(const std::string& reason) const {
    return fail(ErrorCode::kBadFormat, path.string() + ": " + reason + "; copy the run folder again");
  }
  Status check_length(std::uint64_t bytes, const Run& run);
  Status refill();
};

Status ObservationReader::Impl::check_length(std::uint64_t bytes, const Run& run) {
  std::array<char, kObservationHeader.size()> header{};
  if (bytes < header.size()) {
    return damaged("is empty or cut off");
  }
  if (Status read = read_at(file, 0, std::as_writable_bytes(std::span(header)), path); !read) {
    return read;
  }
  if (std::string_view(header.data(), header.size()) != kObservationHeader) {
    return damaged("does not begin as observations of this version do");
  }
  count = bytes / sizeof(Observation) - 1;
  const bool is_cut = bytes % sizeof(Observation) != 0;
  if (run.is_finished && (is_cut || std::cmp_not_equal(count, run.observation_rows.value_or(-1)))) {
    return damaged("has " + std::to_string(count) + " records" + (is_cut ? " and a part of one" : "") +
                   ", run.json says " + std::to_string(run.observation_rows.value_or(0)));
  }
  return {};
}

Status ObservationReader::Impl::refill() {
  constexpr std::uint64_t kBlock = 8192;
  block.resize(static_cast<std::size_t>(std::min(kBlock, count - next)));
  used = 0;
  const std::uint64_t at = (next + 1) * sizeof(Observation);
  return read_at(file, at, std::as_writable_bytes(std::span(block)), path);
}

ObservationReader::ObservationReader(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
ObservationReader::ObservationReader(ObservationReader&&) noexcept = default;
ObservationReader& ObservationReader::operator=(ObservationReader&&) noexcept = default;
ObservationReader::~ObservationReader() = default;

Result<ObservationReader> ObservationReader::open(const Run& run) {
  auto impl = std::make_unique<Impl>();
  impl->path = run.directory / kObservationFile;
  std::error_code error;
  if (!std::filesystem::exists(impl->path, error)) {
    return fail(ErrorCode::kNotFound, impl->path.string() +
                                          ": the run kept no observations; run again with output.observations: true, "
                                          "by a version that writes them");
  }
  Result<FileHandle> file = open_file(impl->path, OpenMode::kRead);
  if (!file) {
    return Unexpected(file.error());
  }
  impl->file = std::move(*file);
  const Result<std::uint64_t> bytes = file_size(impl->file, impl->path);
  if (!bytes) {
    return Unexpected(bytes.error());
  }
  if (const Status checked = impl->check_length(*bytes, run); !checked) {
    return Unexpected(checked.error());
  }
  return ObservationReader(std::move(impl));
}

Result<std::span<const Observation>> ObservationReader::next_frame() {
  Impl& in = *impl_;
  const std::int64_t last_frame = in.frame.empty() ? -1 : in.frame.back().frame;
  in.frame.clear();
  while (true) {
    if (in.used == in.block.size()) {
      if (in.next == in.count) {
        break;
      }
      if (const Status read = in.refill(); !read) {
        return Unexpected(read.error());
      }
    }
    const Observation& seen = in.block[in.used];
    if (!in.frame.empty() && seen.frame != in.frame.back().frame) {
      break;
    }
    if (seen.frame <= last_frame || !is_usable(seen)) {
      return in.damaged("record " + std::to_string(in.next) + " is no observation, or of a frame that is over");
    }
    in.frame.push_back(seen);
    ++in.used;
    ++in.next;
  }
  return std::span<const Observation>(in.frame);
}

}  // namespace kinetrace::recording
