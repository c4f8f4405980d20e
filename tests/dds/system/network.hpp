// Networks of a test, isolated from outside, that end with it in any case.
#pragma once

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "process.hpp"

namespace kinetrace::test {

/// Each test, with its children, is in a network of its own with only a loopback; skipped where none can be made.
class OwnNetworkTest : public ::testing::Test {
 protected:
  void SetUp() override;
};

/// Runs `ip ...`, or another command of a network; throws std::runtime_error with what it printed.
void configure(const std::string& command);

/// Packets dropped by the queues of the interface.
[[nodiscard]] long dropped_packets(const std::string& interface);

/// A second network, joined to this one by a cable: interface kHere with kHereAddress on this side, kThere with
/// kThereAddress on the other one.
class Neighbour {
 public:
  static constexpr const char* kHere = "kt-here";
  static constexpr const char* kThere = "kt-there";
  static constexpr const char* kHereAddress = "10.77.0.1";
  static constexpr const char* kThereAddress = "10.77.0.2";

  Neighbour();

  /// The command, to be run in the other network.
  [[nodiscard]] std::vector<std::string> inside(const std::vector<std::string>& command) const;
  /// As `configure`, in the other network.
  void configure_there(const std::string& command) const;

 private:
  std::string prefix_;
  Process holder_;  ///< Keeps the other network alive.
};

}  // namespace kinetrace::test
