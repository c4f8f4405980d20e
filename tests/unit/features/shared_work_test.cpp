// Features are bit-identical for any number of threads.
#include <cstring>
#include <vector>

#include <gtest/gtest.h>

#include "front_end_harness.hpp"
#include "thread_per_round_workers.hpp"

namespace kinetrace::features {
namespace {

using test::ThreadPerRoundWorkers;
using testing::Harness;
using testing::Scene;
using testing::StereoImage;
using testing::Texture;

StereoImage view(const Texture& texture, double shift_px) {
  Scene scene;
  scene.left = [&](const Eigen::Vector2d& p) { return texture({p.x() + shift_px, p.y()}); };
  return scene.render(1 + static_cast<unsigned>(shift_px));
}

/// All reported data of the features of five frames; some are predicted, some rejected.
std::vector<Feature> seen_by(Workers* workers) {
  const Texture texture(5);
  Harness front_end({}, Scene{}.width, Scene{}.height, workers);
  std::vector<Feature> all;
  std::vector<FeaturePrediction> predictions;
  for (int frame = 0; frame < 5; ++frame) {
    const std::vector<Feature> features = front_end.process(view(texture, 2.0 * frame), {}, predictions);
    all.insert(all.end(), features.begin(), features.end());
    predictions.assign(FeatureConfig{}.max_features, {});
    for (const Feature& feature : features) {
      if (feature.slot % 3 != 0) {
        predictions[feature.slot] = {feature.left_px - Eigen::Vector2f(2.F, 0.F),
                                     feature.has_right() ? feature.disparity_px() : -1.F, true};
      }
    }
  }
  return all;
}

void expect_same(const std::vector<Feature>& a, const std::vector<Feature>& b) {
  ASSERT_EQ(a.size(), b.size());
  const auto bits = [](float value) {
    std::uint32_t pattern = 0;
    std::memcpy(&pattern, &value, sizeof(pattern));
    return pattern;
  };
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].id, b[i].id);
    EXPECT_EQ(a[i].slot, b[i].slot);
    EXPECT_EQ(a[i].age_frames, b[i].age_frames);
    EXPECT_EQ(bits(a[i].left_px.x()), bits(b[i].left_px.x()));
    EXPECT_EQ(bits(a[i].left_px.y()), bits(b[i].left_px.y()));
    EXPECT_EQ(bits(a[i].u_right_px), bits(b[i].u_right_px));
    EXPECT_EQ(bits(a[i].v_px), bits(b[i].v_px));
  }
}

TEST(SharedWork, FeaturesAreTheSameToTheBit) {
  const std::vector<Feature> alone = seen_by(nullptr);
  ASSERT_GT(alone.size(), 500U);
  for (const std::size_t count : {1U, 2U, 4U}) {
    ThreadPerRoundWorkers workers(count);
    expect_same(alone, seen_by(&workers));
    EXPECT_GT(workers.rounds, 10) << "work was shared";
  }
}

}  // namespace
}  // namespace kinetrace::features
