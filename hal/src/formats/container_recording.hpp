// The files of one container recording.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "formats/container_file.hpp"

namespace kinetrace::hal {

class ContainerRecording {
 public:
  void add_file(ContainerFile file) { files_.push_back(std::move(file)); }
  /// The next frame is that record of the newest file.
  void add_frame(std::int64_t record) { places_.push_back({files_.size() - 1, record}); }

  [[nodiscard]] const ContainerFile& newest_file() const noexcept { return files_.back(); }
  /// Both images of a frame. Errors: kBadFormat, kIo.
  [[nodiscard]] InPlaceStatus read(std::size_t frame, MutableGrayView left, MutableGrayView right) const {
    const Place& place = places_[frame];
    return files_[place.file].read(place.record, left, right);
  }

 private:
  struct Place {
    std::size_t file = 0;
    std::int64_t record = 0;
  };
  std::vector<ContainerFile> files_;
  std::vector<Place> places_;
};

}  // namespace kinetrace::hal
