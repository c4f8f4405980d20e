// Label images as masks, as a segmenter and an evaluation read them.
#include <cstring>
#include <vector>

#include "fuzz_target.hpp"
#include "kinetrace/core/arena.hpp"
#include "kinetrace/evaluation/mask_overlap.hpp"
#include "kinetrace/segmentation/instance_image.hpp"

void kinetrace::fuzz::try_input(std::string_view input) {
  using namespace segmentation;
  if (input.size() < 4) {
    return;
  }
  constexpr int kFewObjects = 6;
  const int width = 1 + static_cast<std::uint8_t>(input[0]) % 16;
  const int min_area_px = static_cast<std::uint8_t>(input[1]) % 8;
  const auto encoding = input[2] % 2 == 0 ? MaskEncoding::kMots : MaskEncoding::kInstance;
  input.remove_prefix(3);
  const int height = static_cast<int>(input.size() / 2) / width;
  if (height < 1) {
    return;
  }
  const auto pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  std::vector<std::uint16_t> values(pixels);
  std::memcpy(values.data(), input.data(), pixels * 2);
  std::vector<std::uint8_t> labels(pixels);
  Arena arena(std::size_t{1} << 18U);
  InstanceRelabeler relabeler(arena);
  FixedVector<Detection> detections(arena, kFewObjects);
  require(!arena.exhausted());
  relabeler.relabel({values.data(), width, height, width}, encoding, kFewObjects, min_area_px,
                    {labels.data(), width, height, width}, detections);
  for (const std::uint8_t label : labels) {
    require(label <= detections.size() || label == kIgnoreLabel);
  }
  static_cast<void>(evaluation::label_mots_image({values.data(), width, height, width}));
}
