#include "kinetrace/recording/json_text.hpp"

#include <algorithm>
#include <string_view>

#include "kinetrace/core/input_file.hpp"

namespace kinetrace::recording {
namespace {

/// Nesting depth of objects and lists; ignores brackets within strings.
int depth_of(std::string_view text) {
  int depth = 0;
  int deepest = 0;
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string && c == '\\') {
      ++i;
    } else if (c == '"') {
      in_string = !in_string;
    } else if (!in_string && (c == '{' || c == '[')) {
      deepest = std::max(deepest, ++depth);
    } else if (!in_string && (c == '}' || c == ']')) {
      --depth;
    }
  }
  return deepest;
}

}  // namespace

Result<std::string> read_json_text(const std::filesystem::path& path) {
  constexpr std::size_t kMaxBytes = std::size_t{1} << 26U;
  constexpr int kMaxDepth = 64;
  Result<std::string> text = InputFile::read_whole(path, kMaxBytes);
  if (text && depth_of(*text) > kMaxDepth) {
    return fail(ErrorCode::kBadFormat,
                path.string() + ": is nested more than " + std::to_string(kMaxDepth) + " deep; write it anew");
  }
  return text;
}

}  // namespace kinetrace::recording
