#include "config/refusal.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace kinetrace::publishing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

PublishConfig secured() {
  PublishConfig config;
  config.security.mode = SecurityMode::kRequired;
  config.security.certificate = "keys/cert.pem";
  config.security.permissions = "keys/permissions.p7s";
  config.security.governance = "keys/governance.p7s";
  return config;
}

Error io(const std::string& message) {
  return {ErrorCode::kIo, message};
}

TEST(Refusal, XmlIsTheUsersFileNotAVariable) {
  PublishConfig config;
  config.xml = "own.xml";
  const Error error =
      explained(config, io("config: //CycloneDDS/Domain: Genral: unknown element (CYCLONEDDS_URI+0 line 3)"));
  EXPECT_EQ(error.code, ErrorCode::kInvalidConfig);
  EXPECT_THAT(error.message, AllOf(HasSubstr("own.xml"), HasSubstr("Genral: unknown element (line 3)"),
                                   HasSubstr("correct"), Not(HasSubstr("CYCLONEDDS_URI"))));
}

TEST(Refusal, SecurityNamesTheDocument) {
  const auto expect = [](const std::string& words, const std::string& culprit, const std::string& remedy) {
    const Error error = explained(secured(), io(words));
    EXPECT_EQ(error.code, ErrorCode::kInvalidConfig);
    EXPECT_THAT(error.message, AllOf(HasSubstr(culprit), HasSubstr(remedy)));
  };
  expect("Error occurred while validating local permissions: Subject name is invalid(code: 146)",
         "keys/permissions.p7s", "must be for the subject of keys/cert.pem");
  expect("Permissions validity period expired for CN=kinetrace (expired: 2026-11-22T01:06:44)(code: 147)",
         "dds.security.permissions: keys/permissions.p7s", "kinetrace keys");
  expect("Could not find domain 0 in governance(code: 141)", "dds.security.governance: keys/governance.p7s", "sign");
  expect("DDS topic kinetrace/objects cannot be written: Not Allowed By Security", "keys/permissions.p7s",
         "allow its topics");
}

TEST(Refusal, WhatIsNotOfTheFilesStaysAsItIs) {
  for (const PublishConfig& config : {PublishConfig{}, secured()}) {
    const Error error = explained(config, io("DDS topic x cannot be made: Out of resources"));
    EXPECT_EQ(error.code, ErrorCode::kIo);
    EXPECT_EQ(error.message, "DDS topic x cannot be made: Out of resources");
  }
}

}  // namespace
}  // namespace kinetrace::publishing
