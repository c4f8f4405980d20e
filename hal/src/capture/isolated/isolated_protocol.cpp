#include "capture/isolated/isolated_protocol.hpp"

#include <algorithm>

namespace kinetrace::hal {

void put(PacketWriter& packet, const CaptureConfig& config) {
  packet.put(config.backend).put(config.device).put(config.format).put(config.width_px).put(config.height_px);
  packet.put(config.rate_hz).put(config.exposure_us).put(config.gain).put(config.trigger).put(config.buffers);
}

CaptureConfig take_config(PacketReader& packet) {
  // Members are read in the order of this list.
  return {.backend = packet.take<CaptureBackend>(),
          .device = packet.text(),
          .format = packet.take<PixelFormat>(),
          .width_px = packet.take<int>(),
          .height_px = packet.take<int>(),
          .rate_hz = packet.take<double>(),
          .exposure_us = packet.take_optional<double>(),
          .gain = packet.take_optional<double>(),
          .trigger = packet.take<TriggerMode>(),
          .buffers = packet.take<int>()};
}

void put(PacketWriter& packet, const CaptureInfo& info) {
  packet.put(info.name).put(info.stable_id).put(info.serial).put(info.format).put(info.width_px).put(info.height_px);
  packet.put(info.stride_bytes).put(info.rate_hz).put(info.exposure_us).put(info.gain).put(info.timestamp_kind);
  packet.put(info.sequence_counts_losses);
}

CaptureInfo take_info(PacketReader& packet) {
  return {.name = packet.text(),
          .stable_id = packet.text(),
          .serial = packet.text(),
          .format = packet.take<PixelFormat>(),
          .width_px = packet.take<int>(),
          .height_px = packet.take<int>(),
          .stride_bytes = packet.take<int>(),
          .rate_hz = packet.take<double>(),
          .exposure_us = packet.take_optional<double>(),
          .gain = packet.take_optional<double>(),
          .timestamp_kind = packet.take<TimestampKind>(),
          .sequence_counts_losses = packet.take<bool>()};
}

void put(PacketWriter& packet, const std::vector<CaptureListing>& listings) {
  packet.put(listings.size());
  for (const CaptureListing& listing : listings) {
    packet.put(listing.backend).put(listing.path).put(listing.stable_id).put(listing.name).put(listing.problem);
    packet.put(listing.modes.size());
    for (const std::string& mode : listing.modes) {
      packet.put(mode);
    }
  }
}

std::vector<CaptureListing> take_listings(PacketReader& packet) {
  std::vector<CaptureListing> listings;
  for (auto left = packet.take<std::size_t>(); left > 0 && packet.complete(); --left) {
    CaptureListing listing{.backend = packet.take<CaptureBackend>(),
                           .path = packet.text(),
                           .stable_id = packet.text(),
                           .name = packet.text(),
                           .problem = packet.text(),
                           .modes = {}};
    for (auto modes = packet.take<std::size_t>(); modes > 0 && packet.complete(); --modes) {
      listing.modes.push_back(packet.text());
    }
    listings.push_back(std::move(listing));
  }
  return listings;
}

void put(PacketWriter& packet, const Status& status) {
  packet.put(static_cast<bool>(status));
  if (!status) {
    packet.put(status.error().code).put(status.error().message);
  }
}

Status take_status(PacketReader& packet) {
  if (packet.take<bool>()) {
    return {};
  }
  const auto code = packet.take<ErrorCode>();
  return fail(packet.complete() ? code : ErrorCode::kInternal, packet.text());
}

}  // namespace kinetrace::hal
