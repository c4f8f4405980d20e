// Masks over DDS from several senders, in any order and of any content: masks for the pipeline must fit the image.
#include <deque>

#include "dds_sample.hpp"
#include "fuzz_target.hpp"
#include "native/native_samples.hpp"
#include "segmentation/mask_mailbox.hpp"

namespace {

using namespace kinetrace;
using namespace kinetrace::fuzz;

constexpr int kWidth = 20;
constexpr int kHeight = 10;

std::int64_t time_of(std::int64_t frame) {
  return 1'000'000 * frame;
}

kinetrace_InstanceMask any_mask(FuzzedDataProvider& values, std::vector<std::uint16_t>& runs) {
  auto mask = any_message<kinetrace_InstanceMask>(values);
  if (values.ConsumeBool()) {  // Inside the image and of the right area, which no fuzzer finds.
    mask.x0_px = static_cast<std::uint16_t>(mask.x0_px % kWidth);
    mask.y0_px = static_cast<std::uint16_t>(mask.y0_px % kHeight);
    mask.x1_px = static_cast<std::uint16_t>(mask.x0_px + 1 + mask.x1_px % (kWidth - mask.x0_px));
    mask.y1_px = static_cast<std::uint16_t>(mask.y0_px + 1 + mask.y1_px % (kHeight - mask.y0_px));
  }
  std::int64_t rest = std::int64_t{mask.x1_px} - mask.x0_px;
  rest *= std::int64_t{mask.y1_px} - mask.y0_px;
  const auto count = values.ConsumeIntegralInRange<std::size_t>(0, 5);
  while (runs.size() < count) {
    runs.push_back(values.ConsumeIntegral<std::uint8_t>());
    rest -= runs.back();
  }
  if (rest > 0 && rest <= 0xffff && values.ConsumeBool()) {
    runs.push_back(static_cast<std::uint16_t>(rest));
  }
  show(mask.runs, runs);
  return mask;
}

void offer(FuzzedDataProvider& values, app::MaskMailbox& mailbox, std::int64_t frame) {
  auto message = any_message<kinetrace_InstanceMasks>(values);
  if (values.ConsumeBool()) {
    message.frame = frame + values.ConsumeIntegralInRange(-2, 6);
    message.timestamp_ns = time_of(message.frame);
  }
  if (values.ConsumeBool()) {
    message.width_px = kWidth;
    message.height_px = kHeight;
    message.piece %= 4;
    message.pieces %= 4;
  }
  std::deque<std::vector<std::uint16_t>> runs;
  std::vector<kinetrace_InstanceMask> masks;
  const int count = values.ConsumeIntegralInRange(0, 4);
  for (int i = 0; i < count; ++i) {
    masks.push_back(any_mask(values, runs.emplace_back()));
  }
  show(message.masks, masks);
  publishing::tell(message, values.ConsumeIntegralInRange(1U, 3U),
                   [&mailbox](const MaskMessage& received) { mailbox.offer(received); });
}

void take(app::MaskMailbox& mailbox, std::int64_t frame) {
  RectifiedPair pair;
  pair.frame_index = frame;
  pair.timestamp_ns = time_of(frame);
  mailbox.request(pair);
  const MaskSet* masks = mailbox.await(frame);
  for (const auto& view :
       masks == nullptr ? std::array<std::span<const RunLengthMask>, 2>{} : std::array{masks->left, masks->right}) {
    for (const RunLengthMask& mask : view) {
      require(fits(mask, kWidth, kHeight));
    }
  }
}

}  // namespace

void kinetrace::fuzz::try_input(std::string_view input) {
  FuzzedDataProvider values(reinterpret_cast<const std::uint8_t*>(input.data()), input.size());
  const app::MaskMailboxConfig config{kWidth, kHeight, values.ConsumeBool(), std::chrono::milliseconds(0)};
  Arena arena(app::MaskMailbox::required_bytes(config));
  app::MaskMailbox mailbox(config, arena);
  mailbox.set_senders(1);
  std::int64_t frame = 0;
  while (values.remaining_bytes() > 0) {
    if (values.ConsumeIntegralInRange(0, 3) != 0) {
      offer(values, mailbox, frame);
    } else {
      frame += values.ConsumeIntegralInRange(0, 2);
      take(mailbox, frame);
    }
  }
}
