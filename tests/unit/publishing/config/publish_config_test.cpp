#include "kinetrace/publishing/publish_config.hpp"

#include <functional>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace kinetrace::publishing {
namespace {

using testing::HasSubstr;

std::string refusal(const std::function<void(PublishConfig&)>& change) {
  PublishConfig config;
  change(config);
  const Status valid = config.validate();
  return valid ? "" : valid.error().message;
}

TEST(PublishConfig, DefaultsAreValidAndStayOnTheMachine) {
  const PublishConfig config;
  EXPECT_TRUE(config.validate());
  EXPECT_EQ(config.interface, "lo");
  EXPECT_EQ(config.security.mode, SecurityMode::kOff);
}

TEST(PublishConfig, RangesHoldAtTheirEndsAndNotBeyond) {
  EXPECT_EQ(refusal([](auto& c) { c.domain = 230; }), "");
  EXPECT_THAT(refusal([](auto& c) { c.domain = 231; }), HasSubstr("dds.domain"));
  EXPECT_THAT(refusal([](auto& c) { c.domain = -1; }), HasSubstr("dds.domain"));
  EXPECT_EQ(refusal([](auto& c) { c.piece_bytes = 20'000; }), "");
  EXPECT_THAT(refusal([](auto& c) { c.piece_bytes = 20'001; }), HasSubstr("dds.piece_bytes"));
  EXPECT_THAT(refusal([](auto& c) { c.piece_bytes = 4095; }), HasSubstr("dds.piece_bytes"));
  EXPECT_EQ(refusal([](auto& c) { c.max_points = 0; }), "");
  EXPECT_THAT(refusal([](auto& c) { c.max_points = 20'001; }), HasSubstr("dds.max_points"));
  EXPECT_THAT(refusal([](auto& c) { c.bytes_per_second = 0; }), HasSubstr("dds.bytes_per_second"));
  EXPECT_THAT(refusal([](auto& c) { c.max_objects = kMaxObjects + 1; }), HasSubstr("max_objects"));
}

TEST(PublishConfig, NamesAreWhatDdsAndRosTake) {
  EXPECT_EQ(refusal([](auto& c) { c.device = std::string(31, 'x'); }), "");
  EXPECT_THAT(refusal([](auto& c) { c.device = std::string(32, 'x'); }), HasSubstr("dds.device"));
  EXPECT_THAT(refusal([](auto& c) { c.device = ""; }), HasSubstr("dds.device"));
  EXPECT_THAT(refusal([](auto& c) { c.interface = ""; }), HasSubstr("dds.interface"));
  EXPECT_THAT(refusal([](auto& c) { c.interface = "eth0\"/>"; }), HasSubstr("dds.interface"));
  EXPECT_EQ(refusal([](auto& c) { c.peers = "10.0.0.1,fe80::1,host-b"; }), "");
  EXPECT_THAT(refusal([](auto& c) { c.peers = "10.0.0.1,,10.0.0.2"; }), HasSubstr("dds.peers"));
  EXPECT_EQ(refusal([](auto& c) { c.ros2.prefix = "car/front_2"; }), "");
  EXPECT_EQ(refusal([](auto& c) { c.ros2.prefix = ""; }), "");
  for (const char* prefix : {"/car", "car/", "car//front", "2car", "car/2", "car-a"}) {
    EXPECT_THAT(refusal([&](auto& c) { c.ros2.prefix = prefix; }), HasSubstr("dds.ros2.prefix")) << prefix;
  }
  EXPECT_THAT(refusal([](auto& c) { c.ros2.odom_frame = ""; }), HasSubstr("dds.ros2.odom_frame"));
}

TEST(PublishConfig, FramesHaveNamesOfTheirOwn) {
  EXPECT_THAT(refusal([](auto& c) { c.ros2.base_frame = c.ros2.odom_frame; }), HasSubstr("are both \"odom\""));
  EXPECT_THAT(refusal([](auto& c) { c.ros2.map_frame = c.ros2.odom_frame; }), HasSubstr("dds.ros2.map_frame"));
}

TEST(PublishConfig, SomethingIsPublished) {
  EXPECT_THAT(refusal([](auto& c) { c.native = c.ros2.enabled = false; }), HasSubstr("nothing would be published"));
}

void require_security(PublishConfig& config) {
  config.security = {SecurityMode::kRequired, "ca", "certificate", "key", "", "governance", "permissions", ""};
}

TEST(PublishConfig, RequiredSecurityNeedsEveryFile) {
  EXPECT_EQ(refusal(require_security), "");
  for (std::string SecurityConfig::*file :
       {&SecurityConfig::identity_ca, &SecurityConfig::certificate, &SecurityConfig::private_key,
        &SecurityConfig::governance, &SecurityConfig::permissions}) {
    EXPECT_THAT(refusal([file](PublishConfig& config) {
                  require_security(config);
                  (config.security.*file).clear();
                }),
                HasSubstr("is missing; dds.security.mode: required needs it"));
  }
}

TEST(PublishConfig, SettingsThatOnlySeemToProtectAreRefused) {
  EXPECT_THAT(refusal([](auto& c) { c.security.private_key = "key.pem"; }),
              HasSubstr("dds.security.private_key is named, but dds.security.mode is off"));
  EXPECT_THAT(refusal([](auto& c) {
                require_security(c);
                c.xml = "own.xml";
              }),
              HasSubstr("dds.xml cannot be combined"));
}

}  // namespace
}  // namespace kinetrace::publishing
