// Whole networks through the real runtime, with outputs known by construction (see make_models).
#include "kinetrace/neural/instance_network.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace kinetrace::neural {
namespace {

using ::testing::HasSubstr;

constexpr int kWidth = 128;
constexpr int kHeight = 64;

/// A dark picture with bright rectangles.
class Blobs {
 public:
  explicit Blobs(int channels, int width = kWidth, int height = kHeight)
      : width_(width),
        height_(height),
        channels_(channels),
        samples_(
            static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * static_cast<std::size_t>(channels),
            10) {}
  Blobs& add(const PixelBox& box, const std::array<std::uint8_t, 3>& colour) {
    for (int y = box.y0; y < box.y1; ++y) {
      for (int x = box.x0; x < box.x1; ++x) {
        for (int i = 0; i < channels_; ++i) {
          const std::ptrdiff_t pixel = std::ptrdiff_t{y} * width_ + x;
          samples_[static_cast<std::size_t>(pixel * channels_ + i)] = colour[static_cast<std::size_t>(i)];
        }
      }
    }
    return *this;
  }
  [[nodiscard]] Blobs mirrored() const {
    Blobs other(channels_, width_, height_);
    const auto row_samples = static_cast<std::ptrdiff_t>(width_) * channels_;
    for (std::ptrdiff_t y = 0; y < height_; ++y) {
      const auto from = samples_.begin() + y * row_samples;
      std::reverse_copy(from, from + row_samples, other.samples_.begin() + y * row_samples);
    }
    return other;
  }
  [[nodiscard]] Picture picture() const { return {samples_.data(), width_, height_, width_ * channels_, channels_}; }

 private:
  int width_;
  int height_;
  int channels_;
  std::vector<std::uint8_t> samples_;
};

constexpr std::array<std::uint8_t, 3> kWhite{250, 250, 250};
constexpr std::array<std::uint8_t, 3> kRed{250, 10, 10};
constexpr PixelBox kFirst{16, 16, 32, 32};
constexpr PixelBox kSecond{88, 24, 104, 40};

ModelConfig model(const std::string& name, ModelFamily family) {
  ModelConfig config;
  config.family = family;
  config.file = std::string(KINETRACE_MODELS) + "/" + name;
  config.input.width_px = kWidth;
  config.input.height_px = kHeight;
  config.classes = {{"white", kVehicleClass, 0.5F}, {"red", kPedestrianClass, 0.5F}};
  config.thresholds.overlap = 0.45F;
  return config;
}

struct Network {
  std::unique_ptr<Arena> arena;
  std::unique_ptr<InstanceNetwork> network;
};

Result<Network> make(const ModelConfig& config, int max_width = kWidth, int max_height = kHeight) {
  const NetworkOptions options{
      .runtime = KINETRACE_RUNTIME, .threads = 1, .max_width_px = max_width, .max_height_px = max_height};
  Network made;
  made.arena = std::make_unique<Arena>(InstanceNetwork::required_bytes(config, options));
  auto network = InstanceNetwork::create(config, options, *made.arena);
  if (!network) {
    return Unexpected(network.error());
  }
  made.network = std::move(*network);
  return made;
}

/// Shares of a mask inside and outside of `box`.
struct Coverage {
  double inside = 0.0;   ///< Part of the box.
  double outside = 0.0;  ///< Part of the mask.
};
Coverage coverage(const RunLengthMask& mask, const PixelBox& box) {
  int inside = 0;
  int all = 0;
  int at = 0;
  bool is_mask = false;
  for (const std::uint16_t run : mask.runs) {
    for (int end = at + run; at < end; ++at) {
      const int x = mask.box_px.x0 + at % mask.box_px.width();
      const int y = mask.box_px.y0 + at / mask.box_px.width();
      all += is_mask ? 1 : 0;
      inside += is_mask && x >= box.x0 && x < box.x1 && y >= box.y0 && y < box.y1 ? 1 : 0;
    }
    is_mask = !is_mask;
  }
  return {static_cast<double>(inside) / (box.width() * box.height()),
          all == 0 ? 0.0 : static_cast<double>(all - inside) / all};
}

void expect_covers(const RunLengthMask& mask, const PixelBox& box) {
  EXPECT_TRUE(fits(mask, 4096, 4096));
  const Coverage found = coverage(mask, box);
  EXPECT_GT(found.inside, 0.9);
  EXPECT_LT(found.outside, 0.2) << "a mask is right to a quarter of its prototypes' cells";
}

TEST(InstanceNetwork, SaysHowProbableItsInstancesAre) {
  ModelConfig config = model("yolov8-seg.onnx", ModelFamily::kYolov8Seg);
  const Blobs blobs = Blobs(3).add(kFirst, kWhite);
  const auto score = [&] {
    const Result<Network> made = make(config);
    EXPECT_TRUE(made) << made.error().message;
    return made->network->segment(blobs.picture()).value()[0].score;
  };
  const float plain = score();
  config.classes[0].calibration = {.slope = 0.5F, .even = 0.9F};
  EXPECT_NEAR(score(), config.classes[0].calibration.probability(plain), 1e-5F);
  EXPECT_LT(score(), plain);
}

struct Family {
  const char* file;
  ModelFamily family;
};

class KnownAnswer : public ::testing::TestWithParam<Family> {};

TEST_P(KnownAnswer, OfTwoBlobsTwoInstances) {
  const Result<Network> made = make(model(GetParam().file, GetParam().family));
  ASSERT_TRUE(made) << made.error().message;
  const Blobs blobs = Blobs(3).add(kFirst, kWhite).add(kSecond, kRed);
  const auto masks = made->network->segment(blobs.picture());
  ASSERT_TRUE(masks) << masks.error().message;
  ASSERT_EQ(masks->size(), 2U);
  for (const RunLengthMask& mask : *masks) {
    EXPECT_GT(mask.score, 0.99F);
    expect_covers(mask, mask.class_id == kVehicleClass ? kFirst : kSecond);
  }
  EXPECT_NE((*masks)[0].class_id, (*masks)[1].class_id);
}

TEST_P(KnownAnswer, OfADarkPictureNothing) {
  const Result<Network> made = make(model(GetParam().file, GetParam().family));
  ASSERT_TRUE(made) << made.error().message;
  EXPECT_TRUE(made->network->segment(Blobs(3).picture())->empty());
}

TEST_P(KnownAnswer, GreyPicturesGoThroughAColourNetwork) {
  const Result<Network> made = make(model(GetParam().file, GetParam().family));
  ASSERT_TRUE(made) << made.error().message;
  const Blobs blobs = Blobs(1).add(kFirst, kWhite);
  const auto masks = made->network->segment(blobs.picture());
  ASSERT_EQ(masks->size(), 1U);
  EXPECT_EQ((*masks)[0].class_id, kVehicleClass);
  expect_covers((*masks)[0], kFirst);
}

TEST_P(KnownAnswer, LargerPicturesAreScaled) {
  const Result<Network> made = make(model(GetParam().file, GetParam().family), 400, 160);
  ASSERT_TRUE(made) << made.error().message;
  // Three times as wide as the input, and less high: a border above and below.
  const PixelBox first{60, 48, 108, 96};
  const Blobs blobs = Blobs(3, 384, 150).add(first, kWhite);
  const auto masks = made->network->segment(blobs.picture());
  ASSERT_EQ(masks->size(), 1U);
  expect_covers((*masks)[0], first);
}

INSTANTIATE_TEST_SUITE_P(Families, KnownAnswer,
                         ::testing::Values(Family{"kinetrace-seg.onnx", ModelFamily::kKinetraceSeg},
                                           Family{"yolov8-seg.onnx", ModelFamily::kYolov8Seg},
                                           Family{"yolo11-seg.onnx", ModelFamily::kYolo11Seg},
                                           Family{"yolov8-seg-raw.onnx", ModelFamily::kYolov8Seg},
                                           Family{"yolov5-seg.onnx", ModelFamily::kYolov5Seg},
                                           Family{"yolov5-seg-raw.onnx", ModelFamily::kYolov5Seg}),
                         [](const auto& instance) {
                           std::string name = instance.param.file;
                           name = name.substr(0, name.find('.'));
                           name.erase(std::remove(name.begin(), name.end(), '-'), name.end());
                           return name;
                         });

TEST(InstanceNetwork, ItsInputFollowsThePicturesWhereTheModelAllows) {
  ModelConfig config = model("kinetrace-seg.onnx", ModelFamily::kKinetraceSeg);
  config.input.max_pixels = 192 * 96;
  const Result<Network> made = make(config, 384, 160);
  ASSERT_TRUE(made) << made.error().message;
  const PixelBox first{60, 48, 108, 96};
  const Blobs blobs = Blobs(3, 384, 160).add(first, kWhite);
  const auto masks = made->network->segment(blobs.picture());
  ASSERT_TRUE(masks) << masks.error().message;
  ASSERT_EQ(masks->size(), 1U);
  expect_covers((*masks)[0], first);
}

// OpenCV 4.10 could not read it without the size of its input.
TEST(InstanceNetwork, TheOneThatComesAlongIsComputed) {
  ModelConfig config = model("", ModelFamily::kKinetraceSeg);
  config.file = KINETRACE_OWN_NETWORK;
  config.input.max_pixels = kWidth * kHeight;
  config.input.colours = InputColours::kGray;
  config.input.disparity = true;
  const Result<Network> made = make(config);
  ASSERT_TRUE(made) << made.error().message;
  EXPECT_TRUE(made->network->segment(Blobs(1).picture()));
}

/// A textured pair: a plane behind, of 2 px disparity, and a nearer square, its box in the left picture, of 24 px.
struct Pair {
  Blobs left{1};
  Blobs right{1};
};
Pair textured_pair(const PixelBox& near) {
  constexpr int kNear_px = 24;
  constexpr int kFar_px = 2;
  const auto level = [](int x, int y) {
    const unsigned mixed = static_cast<unsigned>(x * 7919 + y * 104729) * 2654435761U;
    return static_cast<std::uint8_t>(mixed >> 24U);
  };
  Pair pair;
  const auto put = [&](Blobs& blobs, int x, int y, std::uint8_t grey) {
    if (x >= 0 && x < kWidth) {
      blobs.add({x, y, x + 1, y + 1}, {grey, grey, grey});
    }
  };
  // Blocks of two pixels, as the network's input is matched at half its size.
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth + kFar_px; ++x) {
      put(pair.left, x, y, level(x / 2, y / 2));
      put(pair.right, x - kFar_px, y, level(x / 2, y / 2));
    }
  }
  for (int y = near.y0; y < near.y1; ++y) {
    for (int x = near.x0; x < near.x1; ++x) {
      put(pair.left, x, y, level(x / 2 + 500, y / 2));
      put(pair.right, x - kNear_px, y, level(x / 2 + 500, y / 2));
    }
  }
  return pair;
}

ModelConfig stereo_model() {
  ModelConfig config = model("kinetrace-seg-stereo.onnx", ModelFamily::kKinetraceSeg);
  config.input.colours = InputColours::kGray;
  config.input.disparity = true;
  return config;
}

/// One instance in the pair, at this place of its picture.
void expect_seen(const StereoPicture& pictures, const PixelBox& near) {
  const Result<Network> made = make(stereo_model());
  ASSERT_TRUE(made) << made.error().message;
  const auto masks = made->network->segment(pictures);
  ASSERT_TRUE(masks) << masks.error().message;
  ASSERT_EQ(masks->size(), 1U);
  EXPECT_GT(coverage((*masks)[0], near).inside, 0.6);
  EXPECT_LT(coverage((*masks)[0], near).outside, 0.3);
}

TEST(InstanceNetwork, SeesWhatIsNearInAPair) {
  const PixelBox near{64, 24, 88, 48};
  const Pair pair = textured_pair(near);
  expect_seen({pair.left.picture(), pair.right.picture()}, near);
}

TEST(InstanceNetwork, SeesTheSameInAMirroredRightPicture) {
  const Pair pair = textured_pair({64, 24, 88, 48});
  const Blobs picture = pair.left.mirrored();
  const Blobs other = pair.right.mirrored();
  expect_seen({picture.picture(), other.picture(), View::kRight}, {kWidth - 88, 24, kWidth - 64, 48});
}

TEST(InstanceNetwork, WithoutAPairDisparitiesAreUnknown) {
  const Result<Network> made = make(stereo_model());
  ASSERT_TRUE(made) << made.error().message;
  const Pair pair = textured_pair({64, 24, 88, 48});
  ASSERT_EQ(made->network->segment({pair.left.picture(), pair.right.picture()})->size(), 1U);
  EXPECT_TRUE(made->network->segment(pair.left.picture())->empty());
}

TEST(InstanceNetwork, PicturesOfAPairHaveOneSize) {
  const Result<Network> made = make(stereo_model());
  ASSERT_TRUE(made) << made.error().message;
  const auto masks = made->network->segment({Blobs(1).picture(), Blobs(1, kWidth, kHeight - 1).picture()});
  ASSERT_FALSE(masks);
  EXPECT_EQ(masks.error().code, ErrorCode::kInvalidArgument);
  EXPECT_THAT(masks.error().message, HasSubstr("differ in size, 128x64 and 128x63"));
}

TEST(InstanceNetwork, OfAnySizeButNotOfAnyColours) {
  ModelConfig config = model("kinetrace-seg.onnx", ModelFamily::kKinetraceSeg);
  config.input.colours = InputColours::kGray;
  const Result<Network> made = make(config);
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().code, ErrorCode::kInvalidConfig);
  EXPECT_THAT(made.error().message, HasSubstr("[1, 3, any, any], the YAML file beside it says [1, 1, any, any]"));
}

TEST(InstanceNetwork, AGrayNetworkTakesColourPictures) {
  ModelConfig config = model("yolov8-seg-gray.onnx", ModelFamily::kYolov8Seg);
  config.input.colours = InputColours::kGray;
  const Result<Network> made = make(config);
  ASSERT_TRUE(made) << made.error().message;
  const Blobs blobs = Blobs(3).add(kFirst, kWhite);
  const auto masks = made->network->segment(blobs.picture());
  ASSERT_EQ(masks->size(), 1U);
  expect_covers((*masks)[0], kFirst);
}

TEST(InstanceNetwork, OrderOfColoursIsAsDescribed) {
  ModelConfig config = model("yolov8-seg.onnx", ModelFamily::kYolov8Seg);
  config.input.colours = InputColours::kBgr;
  const Result<Network> made = make(config);
  const Blobs blobs = Blobs(3).add(kFirst, {10, 10, 250});
  const auto masks = made->network->segment(blobs.picture());
  ASSERT_EQ(masks->size(), 1U);
  EXPECT_EQ((*masks)[0].class_id, kPedestrianClass) << "blue comes where the network expects red";
}

TEST(InstanceNetwork, DroppedClassesAreAsIfTheyWereNotThere) {
  ModelConfig config = model("yolov8-seg.onnx", ModelFamily::kYolov8Seg);
  config.classes[1].class_id = ModelClass::kDropped;
  const Result<Network> made = make(config);
  const Blobs blobs = Blobs(3).add(kFirst, kWhite).add(kSecond, kRed);
  const auto masks = made->network->segment(blobs.picture());
  ASSERT_EQ(masks->size(), 1U);
  EXPECT_EQ((*masks)[0].class_id, kVehicleClass);
}

TEST(InstanceNetwork, MaskRcnnFromAFrozenGraph) {
  for (const char* graph : {"", "mask-rcnn.pbtxt"}) {
    ModelConfig config = model("mask-rcnn.pb", ModelFamily::kMaskRcnn);
    config.graph = *graph == '\0' ? "" : std::string(KINETRACE_MODELS) + "/" + graph;
    config.input.scale = 1.F;
    config.input.fit = InputFit::kStretch;
    const Result<Network> made = make(config);
    ASSERT_TRUE(made) << made.error().message;
    const Blobs blobs = Blobs(3).add({8, 8, 56, 56}, kWhite);
    const auto masks = made->network->segment(blobs.picture());
    ASSERT_TRUE(masks) << masks.error().message;
    ASSERT_EQ(masks->size(), 1U);
    EXPECT_EQ((*masks)[0].class_id, kVehicleClass);
    EXPECT_GT(coverage((*masks)[0], {8, 8, 56, 56}).inside, 0.85);
    EXPECT_LT(coverage((*masks)[0], {8, 8, 56, 56}).outside, 0.2);
  }
}

TEST(InstanceNetwork, CountsWhatItFound) {
  const Result<Network> made = make(model("yolov8-seg.onnx", ModelFamily::kYolov8Seg));
  const Blobs blobs = Blobs(3).add(kFirst, kWhite).add(kSecond, kRed);
  static_cast<void>(made->network->segment(blobs.picture()));
  static_cast<void>(made->network->segment(blobs.picture()));
  EXPECT_EQ(made->network->counters().pictures, 2U);
  EXPECT_EQ(made->network->counters().instances, 4U);
}

TEST(InstanceNetwork, OfAPartWhatLiesWhollyInItWhereItIsInThePicture) {
  const Result<Network> made = make(model("yolov8-seg.onnx", ModelFamily::kYolov8Seg), 256, 128);
  ASSERT_TRUE(made) << made.error().message;
  const PixelBox inside{160, 80, 184, 104};
  const PixelBox cut{120, 72, 136, 88};
  const PixelBox elsewhere{16, 16, 40, 40};
  const Blobs blobs = Blobs(1, 256, 128).add(inside, kWhite).add(cut, kWhite).add(elsewhere, kWhite);
  const auto masks = made->network->segment({blobs.picture()}, {128, 64, 256, 128});
  ASSERT_TRUE(masks) << masks.error().message;
  ASSERT_EQ(masks->size(), 1U);
  expect_covers((*masks)[0], inside);
}

TEST(InstanceNetwork, WhatEndsWithThePictureIsNotCutByThePart) {
  const Result<Network> made = make(model("yolov8-seg.onnx", ModelFamily::kYolov8Seg), 256, 128);
  ASSERT_TRUE(made) << made.error().message;
  const PixelBox at_border{232, 80, 256, 104};
  const Blobs blobs = Blobs(1, 256, 128).add(at_border, kWhite);
  const auto masks = made->network->segment({blobs.picture()}, {128, 64, 256, 128});
  ASSERT_EQ(masks->size(), 1U);
  expect_covers((*masks)[0], at_border);
}

TEST(InstanceNetwork, PartsThatAreNotInThePictureAreRefused) {
  const Result<Network> made = make(model("yolov8-seg.onnx", ModelFamily::kYolov8Seg));
  const Blobs blobs(1);
  for (const PixelBox& part : {PixelBox{}, PixelBox{-1, 0, 10, 10}, PixelBox{0, 0, kWidth, kHeight + 1}}) {
    EXPECT_EQ(made->network->segment({blobs.picture()}, part).error().code, ErrorCode::kInvalidArgument);
  }
}

TEST(InstanceNetwork, PicturesLargerThanPlannedAreRefused) {
  const Result<Network> made = make(model("yolov8-seg.onnx", ModelFamily::kYolov8Seg));
  const Blobs large(3, kWidth + 1, kHeight);
  EXPECT_EQ(made->network->segment(large.picture()).error().code, ErrorCode::kInvalidArgument);
}

struct Wrong {
  const char* file;
  ErrorCode code;
  const char* says;
};

class WrongModel : public ::testing::TestWithParam<Wrong> {};

TEST_P(WrongModel, IsRefusedAtStartWithTheRemedy) {
  const Result<Network> made = make(model(GetParam().file, ModelFamily::kYolov8Seg));
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().code, GetParam().code) << made.error().message;
  EXPECT_THAT(made.error().message, HasSubstr(GetParam().file));
  EXPECT_THAT(made.error().message, HasSubstr(GetParam().says));
  EXPECT_EQ(made.error().message.find('\n'), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(
    Files, WrongModel,
    ::testing::Values(Wrong{"nowhere.onnx", ErrorCode::kNotFound, "no such model"},
                      Wrong{"not-a-model.onnx", ErrorCode::kBadFormat, "not an ONNX model"},
                      Wrong{"truncated.onnx", ErrorCode::kBadFormat, "only a part of one"},
                      Wrong{"nan-weights.onnx", ErrorCode::kBadFormat, "not finite"},
                      Wrong{"rejected-operator.onnx", ErrorCode::kUnsupported, "NonMaxSuppression"},
                      Wrong{"uneven-split.onnx", ErrorCode::kUnsupported, "opset 12"},
                      Wrong{"wrong-outputs.onnx", ErrorCode::kUnsupported, "[1, 10]"},
                      Wrong{"wrong-outputs.onnx", ErrorCode::kUnsupported, "yolo export"},
                      Wrong{"dynamic-shape.onnx", ErrorCode::kUnsupported, "no fixed size"},
                      Wrong{"huge-classes.onnx", ErrorCode::kInvalidConfig, "5 classes"},
                      Wrong{"yolov8-seg-gray.onnx", ErrorCode::kInvalidConfig, "[1, 3, 64, 128]"}));

TEST(InstanceNetwork, AMissingRuntimeIsNamedWithTheRemedy) {
  const ModelConfig config = model("yolov8-seg.onnx", ModelFamily::kYolov8Seg);
  Arena arena(1 << 24);
  const auto made = InstanceNetwork::create(
      config, {.runtime = "/nowhere/kinetrace-opencv-dnn.so", .threads = 1, .max_width_px = 128, .max_height_px = 64},
      arena);
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(made.error().message, HasSubstr("install the package kinetrace-networks"));
}

TEST(InstanceNetwork, AnArenaThatIsTooSmallIsRefused) {
  const ModelConfig config = model("yolov8-seg.onnx", ModelFamily::kYolov8Seg);
  const NetworkOptions options{
      .runtime = KINETRACE_RUNTIME, .threads = 1, .max_width_px = kWidth, .max_height_px = kHeight};
  Arena small(InstanceNetwork::required_bytes(config, options) - 1);
  EXPECT_EQ(InstanceNetwork::create(config, options, small).error().code, ErrorCode::kCapacity);
}

}  // namespace
}  // namespace kinetrace::neural
