// Failing networks and readers must not delay the thread that hands results over. The kernel counts its waits
// (voluntary context switches of the thread), so a busy machine changes no result.
#include <csignal>
#include <functional>
#include <optional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "network.hpp"
#include "parts.hpp"

namespace kinetrace::test {
namespace {

using ::testing::HasSubstr;

class DdsLink : public OwnNetworkTest {
 protected:
  static std::int64_t number(const Process& process, const std::string& name) {
    return process.report().at(name).get<std::int64_t>();
  }
  static Process::Condition state_is(const std::string& state) {
    return [state](const nlohmann::json& report) { return report["state"] == state; };
  }
  static Command network_scene(const Command& more = {}) {
    Command command = scene_command({std::string("dds.interface=") + Neighbour::kHere});
    command.insert(command.end(), more.begin(), more.end());
    return command;
  }
  static Command reader_at(const Neighbour& neighbour) {
    return neighbour.inside(fast_reader_command({"--address", Neighbour::kThereAddress}));
  }
  static void expect_never_waited(const Process& scene) {
    EXPECT_EQ(number(scene, "pipeline_waits"), 0) << scene.report();
    EXPECT_EQ(number(scene, "poses_dropped"), 0) << scene.report();
  }
};

TEST_F(DdsLink, AStoppedReaderBlocksNoOtherAndContinuesLater) {
  const Process scene(scene_command());
  const Process stopped(local_fast_reader_command());
  const Process other(local_fast_reader_command());
  ASSERT_TRUE(stopped.until(all_topics_have(1)) && other.until(all_topics_have(1)));
  stopped.send(SIGSTOP);
  const std::int64_t offered = number(scene, "offered");
  const std::int64_t published = number(scene, "dds_frames");
  EXPECT_TRUE(other.until(more_than_now(other, "total", 1500))) << "the other one reads on";
  EXPECT_TRUE(scene.until(at_least("offered", offered + 300)));
  EXPECT_GT(number(scene, "dds_frames") - published, (number(scene, "offered") - offered) / 2);
  expect_never_waited(scene);
  const auto reads_again = more_than_now(stopped, "total", 100);
  stopped.send(SIGCONT);
  EXPECT_TRUE(stopped.until(reads_again));
  EXPECT_THAT(stopped.report()["mistakes"], ::testing::IsEmpty());
}

TEST_F(DdsLink, ASaturatedLinkCostsMessagesAndNothingElse) {
  const Neighbour neighbour;
  const Process scene(network_scene({"--objects", "40", "dds.bytes_per_second=100000000"}));
  const Process reader(neighbour.inside(fast_reader_command({"--address", Neighbour::kThereAddress, "--no-check"})));
  ASSERT_TRUE(reader.until(all_topics_have(1))) << reader.report() << scene.err();
  const std::string queue = std::string(" dev ") + Neighbour::kHere + " root ";
  configure("tc qdisc add" + queue + "tbf rate 400kbit burst 16kb latency 20ms");
  EXPECT_TRUE(scene.until(more_than_now(scene, "offered", 300)));
  EXPECT_GT(dropped_packets(Neighbour::kHere), 100) << "the link was not saturated";
  expect_never_waited(scene);
  EXPECT_EQ(scene.report()["state"], "connected");
  configure("tc qdisc del" + queue);
  EXPECT_TRUE(reader.until(more_than_now(reader, "total", 300))) << "it recovers by itself";
  EXPECT_EQ(number(scene, "dds_participant_restarts"), 0);
}

TEST_F(DdsLink, AnInterfaceThatGoesDownIsTakenUpAgain) {
  const Neighbour neighbour;
  const Process scene(network_scene());
  const Process reader(reader_at(neighbour));
  ASSERT_TRUE(reader.until(all_topics_have(1))) << reader.report() << scene.err();
  const std::string link = std::string("ip link set ") + Neighbour::kHere;
  configure(link + " down");
  EXPECT_TRUE(scene.until(state_is("waiting")));
  EXPECT_TRUE(scene.until(more_than_now(scene, "dds_frames_without_link", 50)));
  EXPECT_THAT(scene.err(), HasSubstr(Neighbour::kHere));
  configure(link + " up");
  EXPECT_TRUE(scene.until(state_is("connected")));
  EXPECT_TRUE(reader.until(more_than_now(reader, "total", 200))) << scene.report() << scene.err();
  EXPECT_GE(number(scene, "dds_participant_restarts"), 1);
  EXPECT_THAT(reader.report()["mistakes"], ::testing::IsEmpty());
  expect_never_waited(scene);
}

TEST_F(DdsLink, ACableThatIsPulledAndPutBackChangesNothing) {
  const Neighbour neighbour;
  const Process scene(network_scene());
  const Process reader(reader_at(neighbour));
  ASSERT_TRUE(reader.until(all_topics_have(1))) << reader.report() << scene.err();
  const std::string far_end = std::string("ip link set ") + Neighbour::kThere;
  neighbour.configure_there(far_end + " down");
  EXPECT_TRUE(scene.until(more_than_now(scene, "offered", 100)));
  neighbour.configure_there(far_end + " up");
  EXPECT_TRUE(reader.until(more_than_now(reader, "total", 200))) << scene.report() << scene.err();
  expect_never_waited(scene);
}

TEST_F(DdsLink, AnotherAddressIsTakenUp) {
  const Neighbour neighbour;
  const Process scene(network_scene());
  const Process reader(reader_at(neighbour));
  ASSERT_TRUE(reader.until(all_topics_have(1))) << reader.report() << scene.err();
  configure(std::string("ip addr flush dev ") + Neighbour::kHere);
  configure(std::string("ip addr add 10.77.0.9/24 dev ") + Neighbour::kHere);
  EXPECT_TRUE(scene.until(at_least("dds_participant_restarts", 1))) << scene.report() << scene.err();
  EXPECT_TRUE(reader.until(more_than_now(reader, "total", 200))) << scene.report() << scene.err();
  EXPECT_THAT(scene.err(), HasSubstr("10.77.0.9"));
  expect_never_waited(scene);
}

TEST_F(DdsLink, AnInterfaceThatIsNotThereAtStartIsWaitedFor) {
  const Process scene(network_scene());
  ASSERT_TRUE(scene.until(at_least("dds_frames_without_link", 50))) << scene.err();
  EXPECT_EQ(scene.report()["state"], "waiting");
  EXPECT_THAT(scene.err(), HasSubstr(std::string("interface ") + Neighbour::kHere + " is not there"));
  const Neighbour neighbour;
  const Process reader(reader_at(neighbour));
  EXPECT_TRUE(reader.until(all_topics_have(1))) << reader.report() << scene.err();
  expect_never_waited(scene);
}

TEST_F(DdsLink, AReaderMayBeKilledAndAnotherOneCome) {
  const Process scene(scene_command());
  {
    Process first(local_fast_reader_command());
    ASSERT_TRUE(first.until(all_topics_have(1)));
    first.send(SIGKILL);
    EXPECT_EQ(first.wait(), 128 + SIGKILL);
  }
  const Process second(local_fast_reader_command());
  EXPECT_TRUE(second.until(all_topics_have(1))) << second.report();
  expect_never_waited(scene);
}

TEST_F(DdsLink, APublisherMayBeKilledAndStartedAgain) {
  const Process reader(local_fast_reader_command());
  {
    Process first(scene_command());
    ASSERT_TRUE(reader.until(all_topics_have(1)));
    first.send(SIGKILL);
    EXPECT_EQ(first.wait(), 128 + SIGKILL);
  }
  const auto all_again = more_than_now(reader, "total", 300);
  const Process second(scene_command());
  EXPECT_TRUE(reader.until(all_again)) << second.err();
  EXPECT_TRUE(reader.until([](const nlohmann::json& report) { return report["samples"]["rt/tf_static"] == 2; }));
}

}  // namespace
}  // namespace kinetrace::test
