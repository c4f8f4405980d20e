#include <cstdio>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cli/interrupt.hpp"
#include "cli/messages.hpp"
#include "dds/dds_command_line.hpp"
#include "dds/dds_link.hpp"
#include "dds/mask_files.hpp"
#include "kinetrace/publishing/mask_exchange.hpp"
#include "study/gray16_images.hpp"

namespace kinetrace::app {
namespace {

using publishing::MaskSender;
using MaskFiles = std::map<std::int64_t, std::filesystem::path>;

/// Answers requests with masks from files. A program with a neural network does the same with computed masks.
class MaskServer {
 public:
  MaskServer(const MaskOptions& options, MaskFiles left, MaskFiles right, publishing::Link& link,
             const std::string& device)
      : options_(options), left_(std::move(left)), right_(std::move(right)), link_(link), sender_(link, device) {}

  Status run() {
    const std::int64_t begin_ns = steady_time_ns();
    const auto is_over = [&] {
      const double seconds = static_cast<double>(steady_time_ns() - begin_ns) * 1e-9;
      return interrupted_by() != 0 || (options_.seconds > 0.0 && seconds >= options_.seconds);
    };
    while (!is_over()) {
      const Result<std::optional<MaskRequest>> request = sender_.take_request();
      if (!request) {
        return Unexpected(request.error());
      }
      if (*request) {
        note(answer(**request));
      }
      serve(link_);
    }
    return answered_ > 0 ? Status{} : first_failure_;
  }
  [[nodiscard]] std::int64_t answered() const noexcept { return answered_; }
  [[nodiscard]] std::int64_t failed() const noexcept { return failed_; }

 private:
  enum class Answer : std::uint8_t { kSent, kUnknownFrame };

  /// A failure on one frame must not deprive the others of masks.
  void note(const Result<Answer>& answer) {
    if (answer) {
      answered_ += *answer == Answer::kSent ? 1 : 0;
    } else if (failed_++ == 0) {
      first_failure_ = Unexpected(answer.error());
      print_warning(answer.error().message +
                    "; this frame goes without masks, and so does any other whose masks cannot be sent");
    }
  }

  [[nodiscard]] Result<Answer> answer(const MaskRequest& request) {
    if (request.right && right_.empty() && !std::exchange(has_warned_, true)) {
      print_warning(
          "masks of the right image are wanted too; name their folder, --masks LEFT_DIR,RIGHT_DIR, or set "
          "segmentation.dds.right=false in the run");
    }
    const auto left = left_.find(request.frame_index);
    const auto right = right_.find(request.frame_index);
    if (left == left_.end()) {
      return Answer::kUnknownFrame;  // The run propagates.
    }
    // Both views are read before sending: a run cannot use one view alone.
    std::vector<MaskSender::Image> images;
    for (const auto& [view, file] : {std::pair{View::kLeft, left}, std::pair{View::kRight, right}}) {
      if (view == View::kRight && (!request.right || file == right_.end())) {
        continue;
      }
      Result<MaskSender::Image> image = read(request, view, file->second);
      if (!image) {
        return Unexpected(image.error());
      }
      images.push_back(std::move(*image));
    }
    for (const MaskSender::Image& image : images) {
      if (const Status sent = sender_.send(image); !sent) {
        return Unexpected(sent.error());
      }
    }
    return Answer::kSent;
  }

  [[nodiscard]] Result<MaskSender::Image> read(const MaskRequest& request, View view,
                                               const std::filesystem::path& file) {
    const Result<ImageView<const std::uint16_t>> image = images_.read(file);
    if (!image) {
      return Unexpected(image.error());
    }
    return MaskSender::Image{request.frame_index, request.timestamp_ns, view,
                             image->width,        image->height,        masks_of(*image, images_.bit_depth())};
  }

  MaskOptions options_;
  MaskFiles left_;
  MaskFiles right_;
  publishing::Link& link_;
  MaskSender sender_;
  Gray16Images images_;
  std::int64_t answered_ = 0;
  std::int64_t failed_ = 0;
  Status first_failure_;
  bool has_warned_ = false;
};

Outcome<void> send_masks(const MaskOptions& options) {
  const MaskNaming naming = options.by_order ? MaskNaming::kOrder : MaskNaming::kNumber;
  const std::size_t comma = options.folders.find(',');
  Result<MaskFiles> left = find_mask_files(options.folders.substr(0, comma), naming);
  if (!left) {
    return failure(left.error());
  }
  MaskFiles right_files;
  if (const std::string right_dir = comma == std::string::npos ? "" : options.folders.substr(comma + 1);
      !right_dir.empty()) {
    Result<MaskFiles> right = find_mask_files(right_dir, naming);
    if (!right) {
      return failure(right.error());
    }
    right_files = std::move(*right);
  }
  const Result<publishing::PublishConfig> config = network_config(options.network);
  if (!config) {
    return failure(config.error());
  }
  auto link = publishing::Link::create(*config);
  if (!link) {
    return failure(link.error());
  }
  catch_interrupts();
  MaskServer server(options, std::move(*left), std::move(right_files), **link, config->device);
  const Status served = server.run();
  if (!options.quiet) {
    std::fprintf(stderr, "masks sent for %lld frames%s\n", static_cast<long long>(server.answered()),
                 server.failed() > 0 ? (", not for " + std::to_string(server.failed()) + " others").c_str() : "");
  }
  return served ? Outcome<void>{} : failure(served.error());
}

}  // namespace

int mask_command(const MaskOptions& options) {
  const Outcome<void> outcome = send_masks(options);
  return outcome ? 0 : report(outcome.error());
}

}  // namespace kinetrace::app
