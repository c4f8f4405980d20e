#include "run_details.hpp"

#include <array>
#include <cstring>
#include <filesystem>
#include <optional>
#include <span>
#include <sstream>
#include <utility>
#include <vector>

#include "kinetrace/core/input_file.hpp"

namespace kinetrace::batch {
namespace {

namespace fs = std::filesystem;
using ImageNames = std::map<std::int64_t, std::string>;
using Intensities = std::map<std::uint32_t, std::uint8_t>;

/// Reads a file in blocks: memory grows neither with the file nor with a line of it.
class BlockReader {
 public:
  BlockReader(InputFile file, fs::path path) : file_(std::move(file)), path_(std::move(path)) {}

  /// The next line, of which the first kLineBytes are kept; false at the end.
  bool line(std::string& text) {
    constexpr std::size_t kLineBytes = 8192;  // A pose and the longest path.
    text.clear();
    char each = 0;
    bool is_there = false;
    while (byte(each)) {
      is_there = true;
      if (each == '\n') {
        break;
      }
      if (text.size() < kLineBytes) {
        text += each;
      }
    }
    return is_there;
  }

  /// The next bytes; false if there are fewer.
  bool bytes(std::span<char> out) {
    for (char& each : out) {
      if (!byte(each)) {
        return false;
      }
    }
    return true;
  }

  /// At the end: whether it is that of the file.
  [[nodiscard]] Status status() const {
    return at_ < file_.size_bytes() ? Status(fail(ErrorCode::kIo, path_.string() + ": cannot be read to its end; check "
                                                                                   "the storage device"))
                                    : Status();
  }

 private:
  bool byte(char& out) {
    if (used_ == filled_) {
      filled_ = file_.read(at_, block_);
      at_ += filled_;
      used_ = 0;
    }
    if (filled_ == 0) {
      return false;
    }
    out = static_cast<char>(block_[used_++]);
    return true;
  }

  InputFile file_;
  fs::path path_;
  std::vector<std::uint8_t> block_ = std::vector<std::uint8_t>(std::size_t{1} << 16U);
  std::size_t at_ = 0;  ///< Of the next block.
  std::size_t used_ = 0;
  std::size_t filled_ = 0;
};

/// None if there is no such file: the run was not asked to write it.
Result<std::optional<BlockReader>> open(const fs::path& path) {
  InPlaceResult<InputFile> file = InputFile::open(path.c_str());
  if (file) {
    return BlockReader(std::move(*file), path);
  }
  return file.error().code == ErrorCode::kNotFound ? Result<std::optional<BlockReader>>(std::nullopt)
                                                   : Unexpected<Error>(file.error());
}

fs::path images_path(const recording::Run& run) {
  return run.directory / "colmap" / "background" / "images.txt";
}

fs::path cloud_path(const recording::Run& run, std::uint32_t track_id) {
  return run.directory / "points" /
         (track_id == 0 ? "background.ply" : "object_" + std::to_string(track_id) + "_model.ply");
}

Status check_opens(const fs::path& path) {
  const Result<std::optional<BlockReader>> file = open(path);
  return file ? Status() : Unexpected(file.error());
}

}  // namespace

Status check_details(const recording::Run& run) {
  Status opens = check_opens(images_path(run));
  if (opens) {
    opens = check_opens(cloud_path(run, 0));
  }
  std::uint32_t checked = 0;
  for (const recording::ObjectRow& row : run.objects) {
    if (opens && row.track_id != checked) {
      opens = check_opens(cloud_path(run, row.track_id));
      checked = row.track_id;
    }
  }
  return opens;
}

Result<ImageNames> image_names(const recording::Run& run) {
  ImageNames names;
  Result<std::optional<BlockReader>> file = open(images_path(run));
  if (!file) {
    return Unexpected(file.error());
  }
  std::string line;
  bool is_image = true;  // Each image has two lines: its pose and its points.
  while (*file && (*file)->line(line)) {
    if (line.starts_with("#")) {
      continue;
    }
    std::istringstream fields(line);
    std::int64_t id = 0;
    std::string skipped;
    std::string name;
    if (is_image && fields >> id) {
      for (int i = 0; i < 8; ++i) {
        fields >> skipped;
      }
      fields >> name;
      names[id - 1] = name.substr(0, name.rfind('.'));
    }
    is_image = !is_image;
  }
  const Status read = *file ? (*file)->status() : Status();
  return read ? Result<ImageNames>(std::move(names)) : Unexpected(read.error());
}

Result<Intensities> point_intensities(const recording::Run& run, std::uint32_t track_id) {
  Intensities intensities;
  Result<std::optional<BlockReader>> file = open(cloud_path(run, track_id));
  if (!file) {
    return Unexpected(file.error());
  }
  std::string line;
  while (*file && line != "end_header" && (*file)->line(line)) {
  }
  constexpr std::size_t kGrayAt = 12;  // After x y z: red, green, blue, frame, point_id.
  constexpr std::size_t kIdAt = 19;
  std::array<char, 23> vertex{};
  while (*file && (*file)->bytes(vertex)) {
    std::uint32_t id = 0;
    std::memcpy(&id, vertex.data() + kIdAt, sizeof id);
    intensities[id] = static_cast<std::uint8_t>(vertex[kGrayAt]);
  }
  const Status read = *file ? (*file)->status() : Status();
  return read ? Result<Intensities>(std::move(intensities)) : Unexpected(read.error());
}

}  // namespace kinetrace::batch
