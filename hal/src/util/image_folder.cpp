#include "util/image_folder.hpp"

#include <algorithm>
#include <array>
#include <cctype>

#include "kinetrace/core/files.hpp"
#include "util/messages.hpp"
#include "util/text_file.hpp"

namespace kinetrace::hal {
namespace {

namespace fs = std::filesystem;

bool is_image_extension(std::string extension) {
  constexpr std::array<std::string_view, 4> kKnown{".png", ".pgm", ".jpg", ".jpeg"};
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return std::find(kKnown.begin(), kKnown.end(), extension) != kKnown.end();
}

void sort_by_number(std::vector<std::string>& stems) {
  std::sort(stems.begin(), stems.end(), [](const std::string& a, const std::string& b) {
    const auto number_a = trailing_number(a);
    const auto number_b = trailing_number(b);
    return number_a != number_b ? number_a < number_b : a < b;
  });
}

}  // namespace

bool is_folder(const fs::path& path) {
  std::error_code ignored;
  return fs::is_directory(path, ignored);
}

bool is_file(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

bool is_there(const fs::path& path) {
  std::error_code ignored;
  return !path.empty() && fs::exists(path, ignored);
}

Result<ImageFolder> list_images(const fs::path& folder, std::string_view prefix, std::string_view tag) {
  if (const Status there = check_folder(folder, "no such folder; check the path"); !there) {
    return Unexpected(there.error());
  }
  ImageFolder images;
  images.files.folder = folder.string();
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    const fs::path& path = entry->path();
    std::string stem = path.stem().string();
    const std::string extension = path.extension().string();
    // A copy from macOS has a "._NAME.png" beside each NAME.png.
    if (stem.starts_with('.') || !is_image_extension(extension) || !stem.starts_with(prefix) || !stem.ends_with(tag) ||
        stem.size() == tag.size()) {
      continue;
    }
    const std::string suffix = concat(tag, extension);
    if (!images.stems.empty() && suffix != images.files.suffix) {
      return fail(ErrorCode::kUnsupported, concat(folder.string(), ": holds both ", images.files.suffix, " and ",
                                                  suffix, " images; keep one kind"));
    }
    images.files.suffix = suffix;
    stem.erase(stem.size() - tag.size());
    images.stems.push_back(std::move(stem));
    std::error_code no_size;
    const std::uintmax_t size = entry->file_size(no_size);
    images.max_file_bytes = std::max(images.max_file_bytes, no_size ? 0 : static_cast<std::size_t>(size));
  }
  if (error) {
    return fail(ErrorCode::kIo, concat(folder.string(), ": cannot be listed (", error.message(), ")"));
  }
  if (images.stems.empty()) {
    return fail(ErrorCode::kNotFound, concat(folder.string(), ": holds no images (looked for ", prefix, "*", tag,
                                             ".png, .pgm, .jpg, .jpeg); the sequence is empty"));
  }
  sort_by_number(images.stems);
  return images;
}

std::string image_path(const FrameFolder& folder, std::string_view stem) {
  return concat(folder.folder, "/", stem, folder.suffix);
}

std::optional<std::int64_t> trailing_number(std::string_view stem) {
  const std::size_t last_other = stem.find_last_not_of("0123456789");
  return parse_integer(stem.substr(last_other == std::string_view::npos ? 0 : last_other + 1));
}

std::vector<std::string> subfolders(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    if (is_folder(entry->path())) {
      names.push_back(entry->path().filename().string());
    }
  }
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace kinetrace::hal
