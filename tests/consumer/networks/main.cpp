// instances kinetrace-sim.onnx PICTURE: the network's detections, as rows of class, score and box x0, y0, x1, y1.
#include <cstdio>
#include <cstdlib>
#include <kinetrace/imaging/image_reader.hpp>
#include <kinetrace/neural/instance_network.hpp>
using namespace kinetrace;

template <typename T, typename E>
T must(Expected<T, E> result) {
  if (!result)
    std::exit((std::fprintf(stderr, "%s\n", result.error().message.c_str()), 1));
  if constexpr (!std::is_void_v<T>)
    return *std::move(result);
}

int main(int, char** argv) {
  neural::ModelConfig model;
  model.family = neural::ModelFamily::kKinetraceSeg;
  model.file = argv[1];
  model.input = {.max_pixels = 245760, .colours = neural::InputColours::kGray, .disparity = true};
  model.classes = {{"vehicle", kVehicleClass, 0.4F}, {"person", kPedestrianClass, 0.4F}};
  const imaging::ImageInfo size = must(imaging::read_image_info(argv[2]));
  const neural::NetworkOptions options{.max_width_px = size.width, .max_height_px = size.height};
  Arena arena(neural::InstanceNetwork::required_bytes(model, options) + imaging::ImageReader::required_bytes({}));
  auto network = must(neural::InstanceNetwork::create(model, options, arena));
  auto reader = must(imaging::ImageReader::create({}, arena));
  std::vector<std::uint8_t> pixels(std::size_t(size.width) * std::size_t(size.height));
  const MutableGrayView picture{pixels.data(), size.width, size.height, size.width};
  must(reader.read_gray(argv[2], picture));
  for (const RunLengthMask& mask : must(network->segment(GrayView(picture)))) {
    const PixelBox& box = mask.box_px;
    std::printf("%d %.3f %d %d %d %d\n", mask.class_id, mask.score, box.x0, box.y0, box.x1, box.y1);
  }
}
