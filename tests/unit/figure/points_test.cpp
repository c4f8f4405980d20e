#include <fstream>

#include "figure/figure_points.hpp"
#include "run_for_test.hpp"
#include "temp_folder.hpp"

namespace kinetrace::figure {
namespace {

using ::testing::HasSubstr;

class Clouds : public ::testing::Test {
 protected:
  test::TempFolder scratch_;
  std::filesystem::path file_ = scratch_.path() / "cloud.ply";
};

TEST_F(Clouds, AreReadWithTheirGrayValues) {
  write_cloud(file_, 3, 1.0);
  const Result<Cloud> cloud = read_cloud(file_, 1000);
  ASSERT_TRUE(cloud) << cloud.error().message;
  ASSERT_EQ(cloud->points.size(), 27U);
  EXPECT_EQ(cloud->every, 1U);
  EXPECT_TRUE(cloud->points.front().position_m.isApprox(Eigen::Vector3f(-1, -1, -1)));
  EXPECT_TRUE(cloud->points.back().position_m.isApprox(Eigen::Vector3f(1, 1, 1)));
  EXPECT_EQ(cloud->points.back().gray, 26);
}

TEST_F(Clouds, AreThinnedEvenlyToTheLimitAndNoFurther) {
  write_cloud(file_, 10, 1.0);
  EXPECT_EQ(read_cloud(file_, 1000)->points.size(), 1000U);
  const Result<Cloud> thinned = read_cloud(file_, 999);
  ASSERT_TRUE(thinned);
  EXPECT_EQ(thinned->every, 2U);
  EXPECT_EQ(thinned->points.size(), 500U);
  EXPECT_EQ(thinned->points[1].gray, 2);
}

TEST_F(Clouds, EmptyOnesHaveNoPoints) {
  write_cloud(file_, 0, 1.0);
  const Result<Cloud> cloud = read_cloud(file_, 10);
  ASSERT_TRUE(cloud) << cloud.error().message;
  EXPECT_TRUE(cloud->points.empty());
}

TEST_F(Clouds, MissingCutOffAndForeignFilesAreErrorsThatNameThem) {
  EXPECT_EQ(read_cloud(file_, 10).error().code, ErrorCode::kNotFound);
  write_cloud(file_, 3, 1.0);
  std::filesystem::resize_file(file_, std::filesystem::file_size(file_) - 1);
  EXPECT_EQ(read_cloud(file_, 10).error().code, ErrorCode::kBadFormat);
  EXPECT_THAT(read_cloud(file_, 10).error().message, HasSubstr("ends after 26 of 27"));
  for (const char* text :
       {"", "no ply\n", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n",
        "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty float x\nend_header\n",
        "ply\nformat binary_little_endian 1.0\nelement face 1\nproperty list uchar int v\nend_header\n",
        "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty list uchar int v\nend_header\n"}) {
    std::ofstream(file_) << text;
    const Result<Cloud> cloud = read_cloud(file_, 10);
    ASSERT_FALSE(cloud) << text;
    EXPECT_EQ(cloud.error().code, ErrorCode::kBadFormat);
    EXPECT_THAT(cloud.error().message, HasSubstr(file_.string()));
  }
}

TEST_F(Clouds, PointsThatAreNotFiniteAreLeftOut) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::ofstream file(file_, std::ios::binary);
  file << "ply\nformat binary_little_endian 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float "
          "z\nend_header\n";
  for (const float value : {nan, 0.F, 0.F, 1.F, 2.F, 3.F}) {
    file.write(reinterpret_cast<const char*>(&value), sizeof(value));
  }
  file.close();
  const Result<Cloud> cloud = read_cloud(file_, 10);
  ASSERT_TRUE(cloud) << cloud.error().message;
  ASSERT_EQ(cloud->points.size(), 1U);
  EXPECT_TRUE(cloud->points[0].position_m.isApprox(Eigen::Vector3f(1, 2, 3)));
}

}  // namespace
}  // namespace kinetrace::figure
