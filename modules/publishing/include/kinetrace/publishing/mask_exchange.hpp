// Instance masks over DDS: requests and answers by frame.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "kinetrace/core/export.hpp"
#include "kinetrace/core/instance_masks.hpp"
#include "kinetrace/core/result.hpp"
#include "kinetrace/publishing/link.hpp"

namespace kinetrace::publishing {

/// Bounds of a message, as in the IDL.
inline constexpr std::size_t kMaxMasksInMessage = 64;
inline constexpr std::size_t kMaxRunsOfMask = 4096;

/// The requesting side. Called from one thread, which is not the pipeline's.
class KINETRACE_API MaskReceiver {
 public:
  /// Receives masks for `device` alone. `link` must outlive it.
  MaskReceiver(Link& link, std::string device);
  MaskReceiver(const MaskReceiver&) = delete;
  MaskReceiver& operator=(const MaskReceiver&) = delete;
  ~MaskReceiver();

  /// Passes on all messages since the last call, unchecked; does not wait, see Link::wait. Errors: kIo if the DDS
  /// library refuses a topic.
  [[nodiscard]] Status take(const std::function<void(const MaskMessage&)>& visit);
  /// Requests masks, also from senders that join later. No effect without a network. Errors: as take.
  [[nodiscard]] Status request(const MaskRequest& request);
  /// Number of possible senders, as of the last call.
  [[nodiscard]] std::uint32_t senders() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The answering side, for one device.
class KINETRACE_API MaskSender {
 public:
  /// All masks of one image, the topmost first; see RunLengthMask.
  struct Image {
    struct Mask {
      std::uint16_t class_id = kUnknownClass;
      float score = 1.F;
      PixelBox box_px;
      std::vector<std::uint16_t> runs;
    };
    std::int64_t frame_index = 0;
    std::int64_t timestamp_ns = 0;
    View view = View::kLeft;
    int width_px = 0;
    int height_px = 0;
    std::vector<Mask> masks{};
  };

  /// `link` must outlive it.
  MaskSender(Link& link, std::string device);
  MaskSender(const MaskSender&) = delete;
  MaskSender& operator=(const MaskSender&) = delete;
  ~MaskSender();

  /// The newest request not returned yet; does not wait, see Link::wait. Errors: kIo if the DDS library refuses a
  /// topic.
  [[nodiscard]] Result<std::optional<MaskRequest>> take_request();
  /// In pieces of about 16 kB. Errors: kInvalidArgument (a mask does not fit the image, or has more than kMaxRunsOfMask
  /// runs), kIo (nothing is sent), kDisconnected (there is no network).
  [[nodiscard]] Status send(const Image& image);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace kinetrace::publishing
