// Kernels for the baseline and for fast processors (x86-64-v3, NEON) give the same trajectories.
#include <array>
#include <cstdio>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "kinetrace/core/cpu.hpp"
#include "kinetrace/core/se3.hpp"

namespace kinetrace::pipeline {
namespace {

struct PrintedPath {
  std::string kernels;
  std::map<std::pair<std::string, int>, Eigen::Vector3d> position_m;  ///< By "camera" or "object", and frame.
};

PrintedPath print_path(const std::string& environment) {
  const std::string command = "env " + environment + " '" KINETRACE_PATH_PRINTER "'";
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(::popen(command.c_str(), "r"), ::pclose);
  PrintedPath path;
  std::array<char, 256> line{};
  while (pipe && std::fgets(line.data(), line.size(), pipe.get()) != nullptr) {
    std::istringstream text(line.data());
    std::string what;
    int frame = 0;
    Eigen::Vector3d p;
    if (text >> what >> frame >> p.x() >> p.y() >> p.z()) {
      path.position_m[{what, frame}] = p;
    } else {
      path.kernels = what;
    }
  }
  return path;
}

TEST(PipelineKernels, BaselineAndFastOnesAgreeOnTheTrajectories) {
  const PrintedPath fastest = print_path("-u KINETRACE_ISA");
  if (fastest.kernels == "baseline") {
    GTEST_SKIP() << "this processor has only the baseline";
  }
  const PrintedPath baseline = print_path("KINETRACE_ISA=baseline");
  ASSERT_EQ(baseline.kernels, "baseline");
  int camera = 0;
  int object = 0;
  for (const auto& [key, p] : fastest.position_m) {
    const auto other = baseline.position_m.find(key);
    if (key.first == "camera") {
      ASSERT_NE(other, baseline.position_m.end());
      EXPECT_LT((other->second - p).norm(), 0.02) << key.first << " in frame " << key.second;
      ++camera;
    } else if (other != baseline.position_m.end()) {
      EXPECT_LT((other->second - p).norm(), 0.10) << key.first << " in frame " << key.second;
      ++object;
    }
  }
  EXPECT_EQ(camera, 24);
  EXPECT_GE(object, 8);
}

}  // namespace
}  // namespace kinetrace::pipeline
