#include "dds/publish_config_file.hpp"

#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "temp_folder.hpp"

namespace kinetrace::app {
namespace {

using testing::HasSubstr;

class PublishConfigFile : public testing::Test {
 protected:
  Result<publishing::PublishConfig> load(const std::string& yaml) {
    const std::string path = folder_.file("publish.yaml");
    std::ofstream(path) << yaml;
    return load_publish_config(path);
  }
  test::TempFolder folder_;
};

TEST_F(PublishConfigFile, KeysThatAreLeftOutKeepTheirDefault) {
  const auto config = load("dds:\n  domain: 7\n  multicast: off\n  ros2: {stamps: source}\n");
  ASSERT_TRUE(config) << config.error().message;
  EXPECT_EQ(config->domain, 7);
  EXPECT_EQ(config->multicast, publishing::Multicast::kOff);
  EXPECT_EQ(config->ros2.stamps, publishing::RosStamps::kSource);
  EXPECT_EQ(config->interface, "lo");
}

TEST_F(PublishConfigFile, PathsAreRelativeToTheFile) {
  const auto config = load(
      "dds:\n  security:\n    mode: required\n    identity_ca: keys/ca.pem\n    certificate: /abs/a.pem\n"
      "    private_key: k\n    governance: g\n    permissions: p\n");
  ASSERT_TRUE(config) << config.error().message;
  EXPECT_EQ(config->security.identity_ca, (folder_.path() / "keys/ca.pem").string());
  EXPECT_EQ(config->security.certificate, "/abs/a.pem");
  EXPECT_EQ(config->security.permissions_ca, "");
}

TEST_F(PublishConfigFile, ErrorsNameFileAndKey) {
  EXPECT_THAT(load("dds:\n  domian: 7\n").error().message, HasSubstr("did you mean dds.domain?"));
  EXPECT_THAT(load("dds:\n  domain: 999\n").error().message, HasSubstr("publish.yaml: dds.domain must be in [0, 230]"));
  EXPECT_THAT(load("dds:\n  security: {mode: maybe}\n").error().message, HasSubstr("off or required"));
  EXPECT_EQ(load_publish_config(folder_.file("nowhere.yaml")).error().code, ErrorCode::kNotFound);
}

TEST_F(PublishConfigFile, WhatIsMissingOrEmptyIsSentToTheExamples) {
  EXPECT_THAT(load_publish_config(folder_.file("nowhere.yaml")).error().message,
              HasSubstr("nowhere.yaml: no such file for publishing; copy one of config/dds"));
  EXPECT_THAT(load("").error().message, HasSubstr("is empty; copy one of config/dds"));
}

TEST_F(PublishConfigFile, TheExamplesAreValid) {
  for (const char* name : {"loopback.yaml", "network.yaml", "secured.yaml"}) {
    const auto config = load_publish_config(std::filesystem::path(KINETRACE_SOURCE_DIR) / "config/dds" / name);
    EXPECT_TRUE(config) << config.error().message;
  }
}

}  // namespace
}  // namespace kinetrace::app
