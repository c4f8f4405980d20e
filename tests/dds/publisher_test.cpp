// Life of the publisher: start, refusal, loss of the interface, bandwidth budget.
#include <cstdlib>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetrace.h"
#include "kinetrace/publishing/topics.hpp"
#include "message_reader.hpp"
#include "publisher_fixture.hpp"
#include "security_folder.hpp"

namespace kinetrace::publishing {
namespace {

using test::MessageReader;
using test::PublisherFixture;
using test::SampleResult;
using test::SecurityFolder;
using testing::HasSubstr;

std::string refusal(PublishConfig config) {
  config.domain = test::test_domain();
  Arena arena(Publisher::required_bytes(config));
  const auto publisher = Publisher::create(config, SampleResult::geometry(), arena);
  return publisher ? "" : publisher.error().message;
}

TEST(Publisher, IsConnectedOnTheLoopbackAtOnce) {
  PublisherFixture fixture({});
  EXPECT_EQ(fixture.publisher().state(), LinkState::kConnected);
  EXPECT_EQ(fixture.publisher().take_notice(), std::nullopt);
  fixture.publish(SampleResult({}));
  EXPECT_EQ(fixture.publisher().counters().frames, 1U);
  EXPECT_EQ(fixture.publisher().counters().participant_restarts, 0U);
}

TEST(Publisher, WaitsForAnInterfaceThatIsNotThere) {
  PublishConfig config;
  config.interface = "nothere0";
  PublisherFixture fixture(config);
  EXPECT_EQ(fixture.publisher().state(), LinkState::kWaiting);
  const std::optional<std::string> notice = fixture.publisher().take_notice();
  ASSERT_TRUE(notice);
  EXPECT_THAT(*notice, HasSubstr("interface nothere0 is not there or has no address (there are lo"));
  fixture.publish(SampleResult({}));
  fixture.publish(SampleResult({}, 1));
  EXPECT_EQ(fixture.publisher().counters().frames_without_link, 2U);
  EXPECT_EQ(fixture.publisher().take_notice(), std::nullopt) << "said once";
}

TEST(Publisher, MemoryThatIsTooSmallIsRefused) {
  const PublishConfig config;
  Arena arena(Publisher::required_bytes(config) - 1);
  const auto publisher = Publisher::create(config, SampleResult::geometry(), arena);
  ASSERT_FALSE(publisher);
  EXPECT_EQ(publisher.error().code, ErrorCode::kCapacity);
}

TEST(Publisher, MalformedXmlIsRefusedWithItsPlace) {
  const test::TempFolder folder;
  PublishConfig config;
  config.xml = folder.file("own.xml");
  std::ofstream(config.xml) << "<CycloneDDS><Domain Id=\"any\"><General></Domain></CycloneDDS>";
  EXPECT_THAT(refusal(config), testing::AllOf(HasSubstr("own.xml"), HasSubstr("mismatch (Domain) at line 1")));
  std::ofstream(config.xml)
      << "<CycloneDDS><Domain Id=\"any\"><General><Nonsense>1</Nonsense></General></Domain></CycloneDDS>";
  EXPECT_THAT(refusal(config), HasSubstr("Nonsense"));
}

TEST(Publisher, OwnXmlIsUsed) {
  const test::TempFolder folder;
  PublishConfig config;
  config.interface = "nothere0";
  config.xml = folder.file("own.xml");
  std::ofstream(config.xml) << "<CycloneDDS><Domain Id=\"any\"><General><Interfaces><NetworkInterface name=\"lo\"/>"
                               "</Interfaces><AllowMulticast>false</AllowMulticast></General></Domain></CycloneDDS>";
  EXPECT_EQ(refusal(config), "");
}

TEST(Publisher, TheEnvironmentDoesNotSpeak) {
  ASSERT_EQ(::setenv("CYCLONEDDS_URI", "<CycloneDDS><broken", 1), 0);
  EXPECT_EQ(refusal({}), "");
  ::unsetenv("CYCLONEDDS_URI");
}

TEST(Publisher, ThereIsOneInAProcess) {
  const PublisherFixture fixture({});
  EXPECT_THAT(refusal({}), HasSubstr("there is a publisher in this process already"));
}

TEST(Publisher, ASmallBudgetLeavesOutPointsFirst) {
  PublishConfig config;
  config.bytes_per_second = 50'000;  // Holds four pieces at most, and refills by three a second.
  PublisherFixture fixture(config);
  MessageReader<kinetrace_CameraPose> poses(fixture.domain(), kinetrace_CameraPose_desc, topics::kCameraPose,
                                            DDS_DATA_REPRESENTATION_XCDR2);
  const MessageReader<kinetrace_PointPiece> points(fixture.domain(), kinetrace_PointPiece_desc, topics::kPoints,
                                                   DDS_DATA_REPRESENTATION_XCDR2);
  for (std::int64_t frame = 0; frame < 30; ++frame) {
    fixture.mailbox().offer(SampleResult({.objects = 0, .background_points = 2000}, frame).result, 1);
    fixture.publisher().serve(fixture.mailbox(), 1'000'000'000 + frame * SampleResult::kPeriod_ns);
  }
  const PublishCounters counters = fixture.publisher().counters();
  EXPECT_GT(counters.skipped_for_budget, 60U);
  int poses_read = 0;
  while (poses.next(std::chrono::milliseconds(50)) != nullptr) {
    ++poses_read;
  }
  EXPECT_EQ(poses_read, 30);
}

TEST(Publisher, RequiredSecurityStartsWithACompleteSet) {
  const SecurityFolder folder;
  PublishConfig config;
  config.security = folder.make_all("alice");
  EXPECT_EQ(refusal(config), "");
}

TEST(Publisher, RequiredSecurityRefusesToStartWithout) {
  const SecurityFolder folder;
  PublishConfig config;
  config.security = folder.make_all("alice");
  config.security.governance = folder.file("nowhere.p7s");
  EXPECT_THAT(refusal(config), HasSubstr("nowhere.p7s does not exist"));
  config.interface = "nothere0";
  EXPECT_THAT(refusal(config), HasSubstr("nowhere.p7s does not exist")) << "whether there is a network or not";
}

TEST(Publisher, PermissionsOfSomebodyElseAreRefused) {
  const SecurityFolder folder;
  PublishConfig config;
  config.security = folder.make_all("alice");
  folder.sign("bob_permissions", SecurityFolder::permissions("bob"), "ca");
  config.security.permissions = folder.file("bob_permissions.p7s");
  EXPECT_THAT(refusal(config),
              testing::AllOf(HasSubstr("bob_permissions.p7s"), HasSubstr("must be for the subject of")));
}

}  // namespace
}  // namespace kinetrace::publishing
