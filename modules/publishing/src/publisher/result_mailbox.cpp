#include "kinetrace/publishing/result_mailbox.hpp"

#include <algorithm>

namespace kinetrace::publishing {
namespace {

constexpr std::memory_order kRelaxed = std::memory_order_relaxed;

// More than the objects: a track ends in the newest frame before its last poses are final, and its slot may be reused
// meanwhile.
std::size_t open_capacity(const PublishConfig& config) {
  return 4 * static_cast<std::size_t>(config.max_objects);
}

bool is_alive(const FrameResult& result, std::uint32_t track_id) noexcept {
  return std::any_of(result.bodies.begin(), result.bodies.end(),
                     [track_id](const BodyGeometry& body) { return body.track_id == track_id; });
}

}  // namespace

ResultMailbox::ResultMailbox(const PublishConfig& config, Arena& arena)
    : frames_([&] { return PublishedFrame(config, arena); }),
      events_(arena, static_cast<std::size_t>(config.trajectory_queue)),
      open_(arena, open_capacity(config)) {}

std::size_t ResultMailbox::required_bytes(const PublishConfig& config) {
  return measure_bytes([&](Arena& arena) { static_cast<void>(ResultMailbox(config, arena)); });
}

Result<std::unique_ptr<ResultMailbox>> ResultMailbox::create(const PublishConfig& config, Arena& arena) {
  if (const Status valid = config.validate(); !valid) {
    return Unexpected(valid.error());
  }
  std::unique_ptr<ResultMailbox> mailbox(new ResultMailbox(config, arena));
  if (arena.exhausted()) {
    return fail(ErrorCode::kCapacity,
                "the arena does not hold the results that wait for the publisher; size it from "
                "ResultMailbox::required_bytes");
  }
  return mailbox;
}

void ResultMailbox::offer(const FrameResult& result, std::int64_t handed_over_ns, std::int64_t exposed_ns) noexcept {
  frames_.slot().assign(result, handed_over_ns, exposed_ns);
  if (frames_.publish()) {
    superseded_.fetch_add(1, kRelaxed);
  }
  offered_.fetch_add(1, kRelaxed);
  offer_finalised(result);
}

void ResultMailbox::offer_finalised(const FrameResult& result) noexcept {
  if (result.has_finalised) {
    offer_poses(result.finalised);
    end_where_gone(result);
  }
}

void ResultMailbox::offer_health(const PublishedHealth& health) noexcept {
  health_.slot() = health;
  health_.publish();
}

void ResultMailbox::push(const TrajectoryEvent& event) noexcept {
  if (!events_.push(event)) {
    poses_dropped_.fetch_add(event.ends ? 0 : 1, kRelaxed);
  }
}

void ResultMailbox::push_end(const OpenTrajectory& open) noexcept {
  TrajectoryEvent end;
  end.ends = true;
  end.track_id = open.track_id;
  end.class_id = open.class_id;
  push(end);
}

void ResultMailbox::remember(const ObjectResult& object, std::int64_t frame) noexcept {
  const auto known = std::find_if(open_.begin(), open_.end(),
                                  [&](const OpenTrajectory& open) { return open.track_id == object.track_id; });
  if (known == open_.end()) {
    // At capacity the trajectory is published nevertheless; only its end is missed.
    static_cast<void>(open_.push_back({object.track_id, object.class_id, frame}));
  }
}

void ResultMailbox::offer_poses(const FrameEstimate& finalised) noexcept {
  for (const ObjectResult& object : finalised.objects) {
    remember(object, finalised.frame_index);
    push({.ends = false,
          .track_id = object.track_id,
          .class_id = object.class_id,
          .status = object.status,
          .frame_index = finalised.frame_index,
          .timestamp_ns = finalised.timestamp_ns,
          .T_world_obj = object.T_world_obj,
          .velocity_mps = object.velocity_mps});
  }
}

void ResultMailbox::end_where_gone(const FrameResult& result) noexcept {
  for (std::size_t i = open_.size(); i-- > 0;) {
    OpenTrajectory& open = open_[i];
    if (is_alive(result, open.track_id)) {
      open.last_alive_frame = result.newest.frame_index;
    } else if (result.finalised.frame_index >= open.last_alive_frame) {
      // All frames that may contain it are final.
      push_end(open);
      open_.swap_remove(i);
    }
  }
}

void ResultMailbox::end_trajectories() noexcept {
  for (const OpenTrajectory& open : open_) {
    push_end(open);
  }
  open_.clear();
}

MailboxCounters ResultMailbox::counters() const noexcept {
  return {offered_.load(kRelaxed), superseded_.load(kRelaxed), poses_dropped_.load(kRelaxed)};
}

}  // namespace kinetrace::publishing
