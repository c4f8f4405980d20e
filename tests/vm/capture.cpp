#include "capture.hpp"

#include <stdexcept>

namespace kinetrace::hal::test {
namespace {

void require(const Status& status) {
  if (!status) {
    throw std::runtime_error(status.error().message);
  }
}

}  // namespace

std::unique_ptr<CaptureDevice> make_device(const CaptureConfig& config) {
  auto device = make_capture_device(config);
  if (!device) {
    throw std::runtime_error(device.error().message);
  }
  return std::move(*device);
}

std::unique_ptr<CaptureDevice> make_streaming(const CaptureConfig& config) {
  auto device = make_device(config);
  require(device->open());
  require(device->start());
  return device;
}

Picture take_picture(CaptureDevice& device, const CaptureConfig& config) {
  Arena arena(LuminanceReader::required_bytes(config) + 1);
  LuminanceReader reader = LuminanceReader::create(config, arena).value();
  for (;;) {
    const auto image = device.next(kMaxLateFrames);
    if (!image) {
      throw std::runtime_error(image.error().message);
    }
    if (image->damaged) {
      device.release(image->slot);
      continue;
    }
    const auto view = reader.read(*image, device.info());
    if (!view) {
      throw std::runtime_error(view.error().message);
    }
    Picture picture{view->width, view->height, {}};
    for (int y = 0; y < view->height; ++y) {
      picture.pixels.insert(picture.pixels.end(), view->row(y), view->row(y) + view->width);
    }
    device.release(image->slot);
    return picture;
  }
}

}  // namespace kinetrace::hal::test
