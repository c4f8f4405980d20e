#include "config/domain_config.hpp"

#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "temp_folder.hpp"

namespace kinetrace::publishing {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(DomainXml, StaysOnTheMachineByDefault) {
  const std::string xml = domain_xml({}, true);
  EXPECT_THAT(xml, HasSubstr(R"(<NetworkInterface name="lo" multicast="false"/>)"));
  EXPECT_THAT(xml, HasSubstr("<AllowMulticast>false</AllowMulticast>"));
  EXPECT_THAT(xml, HasSubstr(R"(<Peer address="127.0.0.1"/>)"));
  EXPECT_THAT(xml, Not(HasSubstr("<Security>")));
  EXPECT_THAT(xml, Not(HasSubstr("SharedMemory")));
}

TEST(DomainXml, NamesTheOneInterfaceAndItsPeers) {
  PublishConfig config;
  config.interface = "eth0";
  config.peers = "10.0.0.2,10.0.0.3";
  const std::string xml = domain_xml(config, true);
  EXPECT_THAT(xml, HasSubstr(R"(<NetworkInterface name="eth0" multicast="true"/>)"));
  EXPECT_THAT(xml, HasSubstr("<AllowMulticast>spdp</AllowMulticast>"));
  EXPECT_THAT(xml, HasSubstr(R"(<Peer address="10.0.0.2"/><Peer address="10.0.0.3"/>)"));
  EXPECT_THAT(xml, Not(HasSubstr("127.0.0.1")));
}

TEST(DomainXml, DoesWithoutMulticastWhereThereIsNone) {
  PublishConfig config;
  config.interface = "eth0";
  EXPECT_THAT(domain_xml(config, false), HasSubstr("<AllowMulticast>false</AllowMulticast>"));
  config.multicast = Multicast::kOff;
  EXPECT_THAT(domain_xml(config, true), HasSubstr("<AllowMulticast>false</AllowMulticast>"));
  config.multicast = Multicast::kAll;
  EXPECT_THAT(domain_xml(config, true), HasSubstr("<AllowMulticast>true</AllowMulticast>"));
}

TEST(DomainXml, EscapesWhatAPathMayHold) {
  PublishConfig config;
  const std::string odd = "/keys/a&b<c>\"d\".pem";
  config.security = {SecurityMode::kRequired, odd, "certificate", "key", "", "governance", "permissions", ""};
  EXPECT_THAT(domain_xml(config, false), HasSubstr("file:/keys/a&amp;b&lt;c&gt;&quot;d&quot;.pem"));
}

class OwnXml : public testing::Test {
 protected:
  Result<std::string> read(const std::string& content, int domain = 0) {
    PublishConfig config;
    config.domain = domain;
    config.xml = folder_.file("own.xml");
    std::ofstream(config.xml) << content;
    return read_own_xml(config);
  }
  test::TempFolder folder_;
};

TEST_F(OwnXml, IsGivenAsItIs) {
  const std::string content = R"(<CycloneDDS><Domain Id="any"></Domain></CycloneDDS>)";
  const Result<std::string> xml = read(content);
  ASSERT_TRUE(xml) << xml.error().message;
  EXPECT_EQ(*xml, content);
  EXPECT_TRUE(read(R"(<CycloneDDS><Domain Id="3"></Domain></CycloneDDS>)", 3));
  EXPECT_TRUE(read("<CycloneDDS><Domain></Domain></CycloneDDS>", 3)) << "without an Id it is for all";
}

TEST_F(OwnXml, OfAnotherDomainWouldBeIgnored) {
  const Result<std::string> xml = read(R"(<CycloneDDS><Domain Id="4"></Domain></CycloneDDS>)", 3);
  ASSERT_FALSE(xml);
  EXPECT_EQ(xml.error().code, ErrorCode::kInvalidConfig);
  EXPECT_THAT(xml.error().message, HasSubstr("configures domain 4, but dds.domain is 3"));
}

TEST_F(OwnXml, MayNotBringSharedMemoryNorSecurity) {
  const auto with = [](const std::string& part) {
    return "<CycloneDDS><Domain><" + part + "></" + part + "></Domain></CycloneDDS>";
  };
  for (const char* part : {"SharedMemory", "sharedmemory", "Security", "DDSSecurity"}) {
    const Result<std::string> xml = read(with(part));
    ASSERT_FALSE(xml) << part;
    EXPECT_THAT(xml.error().message, HasSubstr("remove it"));
  }
  EXPECT_TRUE(read("<!-- <Security> --><CycloneDDS><Domain></Domain></CycloneDDS>")) << "comments are no elements";
}

TEST_F(OwnXml, IsMissingEmptyOrSomethingElse) {
  PublishConfig config;
  config.xml = folder_.file("nowhere.xml");
  EXPECT_EQ(read_own_xml(config).error().code, ErrorCode::kNotFound);
  EXPECT_EQ(read("").error().code, ErrorCode::kIo);
  EXPECT_THAT(read("<html></html>").error().message, HasSubstr("has no element CycloneDDS"));
}

}  // namespace
}  // namespace kinetrace::publishing
