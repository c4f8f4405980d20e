#include "kinetrace/publishing/mask_exchange.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "kinetrace.h"
#include "kinetrace/publishing/topics.hpp"
#include "native/native_samples.hpp"
#include "transport/outbox.hpp"
#include "transport/sequences.hpp"
#include "transport/topic_reader.hpp"

namespace kinetrace::publishing {
namespace {

// Some frames of several pieces each, both views.
constexpr TopicQos kMaskQos{.depth = 64};
constexpr TopicQos kRequestQos{.depth = 1, .keeps_last = true};
constexpr std::size_t kPieceBytes = 16'000;

struct ReceivingEnds {
  TopicReader masks;
  Writer requests;
};

struct SendingEnds {
  TopicReader requests;
  Writer masks;
};

template <typename Ends>
Result<Ends> make_ends(const Link& link, const LinkMembership& membership, const dds_topic_descriptor_t& read_type,
                       const char* read_topic, const TopicQos& read_qos, TopicReader Ends::*reader,
                       const dds_topic_descriptor_t& written_type, const char* written_topic,
                       const TopicQos& written_qos, Writer Ends::*writer) {
  Ends ends;
  Result<TopicReader> read = TopicReader::create(link, membership, read_type, read_topic, read_qos);
  if (!read) {
    return Unexpected(read.error());
  }
  ends.*reader = std::move(*read);
  Result<Writer> written =
      Writer::create(membership.participant, written_type, written_topic, written_qos, Priority::kEssential);
  if (!written) {
    return Unexpected(written.error());
  }
  ends.*writer = std::move(*written);
  return ends;
}

Status write(const Writer& writer, const void* message, const char* topic) {
  const ForeignCall foreign;
  const dds_return_t written = dds_write(writer.get(), message);
  return written == DDS_RETCODE_OK ? Status{}
                                   : fail(ErrorCode::kIo, std::string("DDS topic ") + topic +
                                                              " was not written: " + dds_strretcode(-written));
}

}  // namespace

struct MaskReceiver::Impl {
  InLink<ReceivingEnds> ends;
  std::string device;

  Result<ReceivingEnds*> get() {
    return ends.get([this](const LinkMembership& membership) {
      return make_ends<ReceivingEnds>(ends.link(), membership, kinetrace_InstanceMasks_desc, topics::kInstanceMasks,
                                      kMaskQos, &ReceivingEnds::masks, kinetrace_MaskRequest_desc, topics::kMaskRequest,
                                      kRequestQos, &ReceivingEnds::requests);
    });
  }
};

MaskReceiver::MaskReceiver(Link& link, std::string device)
    : impl_(new Impl{InLink<ReceivingEnds>(link), std::move(device)}) {}
MaskReceiver::~MaskReceiver() = default;

Status MaskReceiver::take(const std::function<void(const MaskMessage&)>& visit) {
  const Result<ReceivingEnds*> ends = impl_->get();
  if (!ends) {
    return Unexpected(ends.error());
  }
  if (*ends == nullptr) {
    return {};
  }
  (*ends)->masks.take<kinetrace_InstanceMasks>([&](const kinetrace_InstanceMasks& message, std::uint64_t sender) {
    if (message.device != impl_->device) {
      return;
    }
    tell(message, sender, visit);
  });
  return {};
}

Status MaskReceiver::request(const MaskRequest& request) {
  const Result<ReceivingEnds*> ends = impl_->get();
  if (!ends) {
    return Unexpected(ends.error());
  }
  if (*ends == nullptr) {
    return {};
  }
  kinetrace_MaskRequest message{};
  copy_text(impl_->device, message.device);
  message.frame = request.frame_index;
  message.timestamp_ns = request.timestamp_ns;
  message.width_px = request.width_px;
  message.height_px = request.height_px;
  message.right = request.right;
  return write((*ends)->requests, &message, topics::kMaskRequest);
}

std::uint32_t MaskReceiver::senders() const noexcept {
  const ReceivingEnds* ends = impl_->ends.peek();
  return ends == nullptr ? 0 : ends->masks.writers();
}

struct MaskSender::Impl {
  InLink<SendingEnds> ends;
  std::string device;

  Result<SendingEnds*> get() {
    return ends.get([this](const LinkMembership& membership) {
      return make_ends<SendingEnds>(ends.link(), membership, kinetrace_MaskRequest_desc, topics::kMaskRequest,
                                    kRequestQos, &SendingEnds::requests, kinetrace_InstanceMasks_desc,
                                    topics::kInstanceMasks, kMaskQos, &SendingEnds::masks);
    });
  }
};

MaskSender::MaskSender(Link& link, std::string device)
    : impl_(new Impl{InLink<SendingEnds>(link), std::move(device)}) {}
MaskSender::~MaskSender() = default;

Result<std::optional<MaskRequest>> MaskSender::take_request() {
  const Result<SendingEnds*> ends = impl_->get();
  if (!ends) {
    return Unexpected(ends.error());
  }
  std::optional<MaskRequest> newest;
  if (*ends != nullptr) {
    (*ends)->requests.take<kinetrace_MaskRequest>([&](const kinetrace_MaskRequest& message) {
      if (message.device == impl_->device) {
        newest = {message.frame, message.timestamp_ns, message.width_px, message.height_px, message.right};
      }
    });
  }
  return newest;
}

namespace {

Status check(const MaskSender::Image& image) {
  for (std::size_t i = 0; i < image.masks.size(); ++i) {
    const MaskSender::Image::Mask& mask = image.masks[i];
    const bool is_short = mask.runs.size() <= kMaxRunsOfMask;
    if (!is_short || !fits({mask.class_id, mask.score, mask.box_px, mask.runs}, image.width_px, image.height_px)) {
      return fail(ErrorCode::kInvalidArgument,
                  "mask " + std::to_string(i) + " of frame " + std::to_string(image.frame_index) +
                      (is_short ? ": its box leaves the image, or its runs do not add up to its box"
                                : " has " + std::to_string(mask.runs.size()) + " runs; a message holds " +
                                      std::to_string(kMaxRunsOfMask) + " of each, so smooth its outline"));
    }
  }
  return {};
}

/// First mask of each piece, and the end: each piece holds as many masks as fit into a message.
std::vector<std::size_t> cut_into_pieces(const std::vector<MaskSender::Image::Mask>& masks) {
  std::vector<std::size_t> cuts{0};
  std::size_t bytes = 0;
  for (std::size_t i = 0; i < masks.size(); ++i) {
    const std::size_t mask_bytes = sizeof(kinetrace_InstanceMask) + masks[i].runs.size() * sizeof(std::uint16_t);
    if (i > cuts.back() && (bytes + mask_bytes > kPieceBytes || i - cuts.back() == kMaxMasksInMessage)) {
      cuts.push_back(i);
      bytes = 0;
    }
    bytes += mask_bytes;
  }
  cuts.push_back(masks.size());
  return cuts;
}

kinetrace_InstanceMask instance_mask(const MaskSender::Image::Mask& mask) {
  kinetrace_InstanceMask out{};
  out.class_id = mask.class_id;
  out.score = mask.score;
  out.x0_px = static_cast<std::uint16_t>(mask.box_px.x0);
  out.y0_px = static_cast<std::uint16_t>(mask.box_px.y0);
  out.x1_px = static_cast<std::uint16_t>(mask.box_px.x1);
  out.y1_px = static_cast<std::uint16_t>(mask.box_px.y1);
  // Writing does not modify a sequence's data.
  set_items(out.runs, {const_cast<std::uint16_t*>(mask.runs.data()), mask.runs.size()});  // NOLINT(*-const-cast)
  return out;
}

}  // namespace

Status MaskSender::send(const Image& image) {
  if (Status valid = check(image); !valid) {
    return valid;
  }
  const Result<SendingEnds*> ends = impl_->get();
  if (!ends) {
    return Unexpected(ends.error());
  }
  if (*ends == nullptr) {
    return fail(ErrorCode::kDisconnected, "masks of frame " + std::to_string(image.frame_index) +
                                              " were not sent: the network interface is not there");
  }
  const std::vector<std::size_t> cuts = cut_into_pieces(image.masks);
  kinetrace_InstanceMasks message{};
  copy_text(impl_->device, message.device);
  message.frame = image.frame_index;
  message.timestamp_ns = image.timestamp_ns;
  message.view = image.view == View::kLeft ? 0 : 1;
  message.width_px = static_cast<std::uint32_t>(image.width_px);
  message.height_px = static_cast<std::uint32_t>(image.height_px);
  message.pieces = static_cast<std::uint32_t>(cuts.size() - 1);
  for (std::size_t piece = 0; piece + 1 < cuts.size(); ++piece) {
    std::vector<kinetrace_InstanceMask> masks;
    for (std::size_t i = cuts[piece]; i < cuts[piece + 1]; ++i) {
      masks.push_back(instance_mask(image.masks[i]));
    }
    message.piece = static_cast<std::uint32_t>(piece);
    set_items(message.masks, masks);
    if (Status written = write((*ends)->masks, &message, topics::kInstanceMasks); !written) {
      return written;
    }
  }
  return {};
}

}  // namespace kinetrace::publishing
