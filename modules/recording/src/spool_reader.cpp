#include "spool_reader.hpp"

namespace kinetrace::recording {

const std::byte* SpoolCursor::peek() {
  if (next_ >= last_ || !status_) {
    return nullptr;
  }
  if (next_ < buffered_first_ || next_ >= buffered_last_) {
    const std::uint64_t count = std::min<std::uint64_t>(last_ - next_, buffer_.size() / record_bytes_);
    status_ =
        read_at(*file_, next_ * record_bytes_, buffer_.first(static_cast<std::size_t>(count) * record_bytes_), *path_);
    if (!status_) {
      return nullptr;
    }
    buffered_first_ = next_;
    buffered_last_ = next_ + count;
  }
  return buffer_.data() + static_cast<std::size_t>(next_ - buffered_first_) * record_bytes_;
}

}  // namespace kinetrace::recording
