// Estimates of the last frames, kept until they have left the window and are final.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "kinetrace/core/arena.hpp"
#include "kinetrace/core/frame_result.hpp"

namespace kinetrace::pipeline {

/// Change of the object frame that a path is reported in.
enum class FrameChange : std::uint8_t {
  kNone,
  kRefined,   ///< Moved onto its points: earlier poses refer to the same point, as far as that was known.
  kReplaced,  ///< Earlier poses refer to another point.
};

/// An object in a buffered frame. `confirmed` turns true for its past frames too, once its track is confirmed.
struct BufferedObject {
  ObjectResult result;
  std::uint8_t slot = 0;
  bool confirmed = false;
  FrameChange change = FrameChange::kNone;       ///< Of the object's frame, against the frame before.
  Matrix6d drift_covariance = Matrix6d::Zero();  ///< See ObjectState::drift_covariance; not in that of the result.
};

struct BufferedFrame {
  std::int64_t frame_index = 0;
  std::int64_t timestamp_ns = 0;
  CameraResult camera;
  std::span<BufferedObject> objects;  ///< First `object_count` are in use.
  std::size_t object_count = 0;

  /// The object with this track id; null if this frame does not have it.
  [[nodiscard]] BufferedObject* find(std::uint32_t track_id) const noexcept {
    for (BufferedObject& entry : objects.first(object_count)) {
      if (entry.result.track_id == track_id) {
        return &entry;
      }
    }
    return nullptr;
  }
};

/// A queue of at most `capacity` frames; frame(0) is the newest.
class ResultRing {
 public:
  ResultRing() = default;
  ResultRing(Arena& arena, std::size_t capacity, std::size_t max_objects)
      : frames_(arena.take<BufferedFrame>(capacity)) {
    const std::span<BufferedObject> objects = arena.take<BufferedObject>(capacity * max_objects);
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      frames_[i].objects = objects.subspan(i * max_objects, max_objects);
    }
  }

  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  [[nodiscard]] bool full() const noexcept { return size_ == frames_.size(); }
  [[nodiscard]] BufferedFrame& frame(std::size_t age) noexcept {
    return frames_[(head_ + frames_.size() - age) % frames_.size()];
  }

  /// A new newest frame without objects; the caller has made room.
  BufferedFrame& push() noexcept {
    head_ = (head_ + 1) % frames_.size();
    ++size_;
    frames_[head_].object_count = 0;
    return frames_[head_];
  }
  void pop_oldest() noexcept { --size_; }
  /// The object with this track id continues in another slot.
  void move_slot(std::uint32_t track_id, std::uint8_t slot) noexcept {
    for (std::size_t age = 0; age < size_; ++age) {
      if (BufferedObject* entry = frame(age).find(track_id)) {
        entry->slot = slot;
      }
    }
  }

 private:
  std::span<BufferedFrame> frames_;
  std::size_t head_ = 0;
  std::size_t size_ = 0;
};

}  // namespace kinetrace::pipeline
