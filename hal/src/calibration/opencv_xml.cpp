// Reads OpenCV's calibration files in XML (cv::FileStorage). The library's own reader aborts on some malformed texts.
#include <cctype>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "calibration/yaml_document.hpp"
#include "util/messages.hpp"

namespace kinetrace::hal {
namespace {

constexpr int kMaxDepth = 16;

// Reads elements, texts and comments: all that cv::FileStorage writes. Skips attributes.
class XmlReader {
 public:
  explicit XmlReader(std::string_view text) : text_(text) {}

  /// The content of <opencv_storage>. Throws the problem as std::string.
  YAML::Node read() {
    skip_markup();
    const Tag root = opening_tag();
    if (root.name != "opencv_storage" || root.is_empty) {
      throw std::string("is no file of OpenCV: its root must be <opencv_storage>");
    }
    YAML::Node content = element(root.name, 0);
    if (!content.IsMap()) {
      throw std::string("holds no values");
    }
    return content;
  }

 private:
  struct Tag {
    std::string name;
    bool is_empty = false;  ///< <name/>
  };

  [[noreturn]] void fail_here(std::string_view what) const {
    const auto before = text_.substr(0, at_);
    std::size_t line = 1;
    for (const char c : before) {
      line += c == '\n' ? 1U : 0U;
    }
    throw concat("is no valid XML (line ", std::to_string(line), ": ", what, ")");
  }

  void skip_blanks() {
    while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_])) != 0) {
      ++at_;
    }
  }
  bool skip_between(std::string_view begin, std::string_view end) {
    if (!text_.substr(at_).starts_with(begin)) {
      return false;
    }
    const std::size_t found = text_.find(end, at_ + begin.size());
    if (found == std::string_view::npos) {
      fail_here(concat("'", begin, "' does not end"));
    }
    at_ = found + end.size();
    return true;
  }
  // Blanks, comments and declarations.
  void skip_markup() {
    do {
      skip_blanks();
    } while (skip_between("<!--", "-->") || skip_between("<?", "?>"));
  }

  Tag opening_tag() {
    if (at_ >= text_.size() || text_[at_] != '<') {
      fail_here("an element must begin here");
    }
    const std::size_t end = text_.find('>', at_);
    if (end == std::string_view::npos) {
      fail_here("a tag does not end");
    }
    std::string_view inside = text_.substr(at_ + 1, end - at_ - 1);
    Tag tag;
    tag.is_empty = inside.ends_with('/');
    tag.name = inside.substr(0, inside.find_first_of(" \t\r\n/"));
    if (tag.name.empty()) {
      fail_here("a tag has no name");
    }
    at_ = end + 1;
    return tag;
  }

  // The content of an element: elements, or words.
  YAML::Node element(const std::string& name, int depth) {
    if (depth > kMaxDepth) {
      fail_here("elements are nested too deep");
    }
    YAML::Node node;
    std::set<std::string> names;
    std::vector<std::string> words;
    for (;;) {
      skip_markup();
      if (at_ >= text_.size()) {
        fail_here(concat("<", name, "> does not end"));
      }
      if (text_.substr(at_).starts_with("</")) {
        close(name);
        return node.IsNull() ? of_words(words) : node;
      }
      if (text_[at_] != '<') {
        words.push_back(word());
        continue;
      }
      const Tag tag = opening_tag();
      const YAML::Node child = tag.is_empty ? YAML::Node("") : element(tag.name, depth + 1);
      add(node, names, tag.name, child);
    }
  }

  void close(const std::string& name) {
    const std::size_t end = text_.find('>', at_);
    std::string_view closed = text_.substr(at_ + 2, end == std::string_view::npos ? end : end - at_ - 2);
    while (!closed.empty() && std::isspace(static_cast<unsigned char>(closed.back())) != 0) {
      closed.remove_suffix(1);
    }
    if (end == std::string_view::npos || closed != name) {
      fail_here(concat("<", name, "> is not closed by </", name, ">"));
    }
    at_ = end + 1;
  }

  // Elements named _ are the items of a list.
  void add(YAML::Node& node, std::set<std::string>& names, const std::string& name, const YAML::Node& child) const {
    const bool is_list = name == "_";
    if (!node.IsNull() && node.IsSequence() != is_list) {
      fail_here("values with and without names are mixed");
    }
    if (is_list) {
      node.push_back(child);
      return;
    }
    if (!names.insert(name).second) {
      fail_here(concat("<", name, "> is there twice; remove one"));
    }
    node.force_insert(name, child);
  }

  std::string word() {
    const char quote = text_[at_];
    if (quote == '"') {
      const std::size_t end = text_.find('"', at_ + 1);
      if (end == std::string_view::npos) {
        fail_here("a text in quotes does not end");
      }
      std::string quoted(text_.substr(at_ + 1, end - at_ - 1));
      at_ = end + 1;
      return quoted;
    }
    const std::size_t begin = at_;
    while (at_ < text_.size() && text_[at_] != '<' && std::isspace(static_cast<unsigned char>(text_[at_])) == 0) {
      ++at_;
    }
    return std::string(text_.substr(begin, at_ - begin));
  }

  static YAML::Node of_words(const std::vector<std::string>& words) {
    if (words.size() == 1) {
      return YAML::Node(words.front());
    }
    YAML::Node list(YAML::NodeType::Sequence);
    for (const std::string& word : words) {
      list.push_back(word);
    }
    return list;
  }

  std::string_view text_;
  std::size_t at_ = 0;
};

}  // namespace

Result<YamlDocument> YamlDocument::parse_xml(const std::filesystem::path& path, std::string_view text) {
  YamlDocument document;
  document.path_ = path;
  try {
    document.root_ = XmlReader(text).read();
  } catch (const std::string& problem) {
    return fail(ErrorCode::kBadCalibration, concat(path.string(), ": ", problem));
  } catch (const YAML::Exception& exception) {
    return fail(ErrorCode::kBadCalibration, concat(path.string(), ": ", exception.msg));
  }
  return document;
}

}  // namespace kinetrace::hal
