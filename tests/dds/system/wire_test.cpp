// Traffic on the wire, by tshark: types and content if unsecured, neither if secured, and no traffic at all where none
// may be.
#include <csignal>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "network.hpp"
#include "parts.hpp"
#include "temp_folder.hpp"

namespace kinetrace::test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* kMarker = "marker-4711";  ///< Name of the device, so that it is in every native message.

/// Everything on an interface, from the constructor to `stop`.
class Capture {
 public:
  explicit Capture(const std::string& interface, const std::filesystem::path& file)
      : file_(file), tshark_({"tshark", "-q", "-i", interface, "-w", file.string()}) {
    if (!tshark_.until_err("Capture started")) {
      throw std::runtime_error("tshark does not capture: " + tshark_.err());
    }
  }
  void stop() {
    tshark_.send(SIGINT);
    tshark_.wait();
  }
  /// Of all packets.
  [[nodiscard]] std::string bytes() const {
    std::ostringstream content;
    content << std::ifstream(file_, std::ios::binary).rdbuf();
    return content.str();
  }
  /// Output of tshark: one line for each packet that passes the filter.
  [[nodiscard]] std::string fields(const std::string& filter, const std::string& field) const {
    return run_to_end({"tshark", "-r", file_.string(), "-Y", filter, "-T", "fields", "-e", field}).out;
  }

 private:
  std::filesystem::path file_;
  Process tshark_;
};

class DdsWire : public OwnNetworkTest {
 protected:
  TempFolder scratch_;
};

TEST_F(DdsWire, TypesAndContentAreReadableInTheOpen) {
  Capture capture("lo", scratch_.path() / "open.pcapng");
  const Process scene(scene_command({std::string("dds.device=") + kMarker}));
  const Process reader(local_fast_reader_command({"--no-check"}));
  const Process native(native_reader_command());
  ASSERT_TRUE(reader.until(all_topics_have(1)) && native.until(at_least("total", 50)));
  capture.stop();
  const std::string types = capture.fields("rtps.param.typeName", "rtps.param.typeName");
  EXPECT_THAT(types, HasSubstr("nav_msgs::msg::dds_::Odometry_"));
  EXPECT_THAT(types, HasSubstr("kinetrace::TrackedObjects"));
  EXPECT_THAT(capture.bytes(), HasSubstr(kMarker));
  EXPECT_THAT(capture.bytes(), HasSubstr("camera_link"));
}

TEST_F(DdsWire, NothingIsReadableWhenSecured) {
  const std::filesystem::path keys = scratch_.path() / "keys";
  make_keys(keys);
  Capture capture("lo", scratch_.path() / "secured.pcapng");
  Command settings = secured_by(enclave(keys, "kinetrace"));
  settings.push_back(std::string("dds.device=") + kMarker);
  const Process scene(scene_command(settings));
  const Process reader(local_fast_reader_command({"--no-check", "--enclave", enclave(keys, "viewer").string()}));
  ASSERT_TRUE(reader.until(all_topics_have(1))) << reader.report() << scene.err();
  ASSERT_TRUE(reader.until(at_least("total", 200)));
  capture.stop();
  const std::string bytes = capture.bytes();
  EXPECT_GT(bytes.size(), 50'000U) << "hardly anything was captured";
  EXPECT_THAT(capture.fields("rtps.sm.id == 0x30", "rtps.sm.id"), HasSubstr("0x30"))
      << "no encrypted submessages (SEC_BODY)";
  EXPECT_EQ(capture.fields("rtps.param.typeName", "rtps.param.typeName"), "");
  // Topic names are visible: each side presents its permissions before the key exchange.
  for (const char* secret : {kMarker, "camera_link", "Odometry_", "TrackedObjects"}) {
    EXPECT_EQ(bytes.find(secret), std::string::npos) << secret;
  }
}

TEST_F(DdsWire, TheLoopbackIsNotLeft) {
  const Neighbour neighbour;
  Capture capture(Neighbour::kHere, scratch_.path() / "outside.pcapng");
  const Process scene(scene_command());
  const Process local(local_fast_reader_command());
  const Process outside(neighbour.inside(
      fast_reader_command({"--address", Neighbour::kThereAddress, "--peer", Neighbour::kHereAddress})));
  ASSERT_TRUE(local.until(at_least("total", 1000)));
  ASSERT_TRUE(outside.until(at_least("total", 0)));
  capture.stop();
  EXPECT_EQ(outside.report()["participants"], 0);
  const std::string from = "udp && !icmp && ip.src == ";  // Without the kernel's replies about closed ports.
  EXPECT_THAT(capture.fields(from + Neighbour::kThereAddress, "ip.src"), Not("")) << "nobody asked";
  EXPECT_EQ(capture.fields(from + Neighbour::kHereAddress, "ip.dst"), "") << "somebody answered";
  EXPECT_EQ(scene.report()["dds_log_lines"], 0) << scene.err();
}

TEST_F(DdsWire, OnlyTheNamedInterfaceIsUsed) {
  configure("ip link add name kt-aside type veth peer name kt-aside-far");
  configure("ip addr add 10.78.0.1/24 dev kt-aside");
  configure("ip link set kt-aside up");
  configure("ip link set kt-aside-far up");
  const Neighbour neighbour;
  Capture capture("kt-aside", scratch_.path() / "aside.pcapng");
  const Process scene(scene_command({std::string("dds.interface=") + Neighbour::kHere}));
  const Process reader(neighbour.inside(fast_reader_command({"--address", Neighbour::kThereAddress})));
  ASSERT_TRUE(reader.until(at_least("total", 500))) << scene.err();
  capture.stop();
  EXPECT_EQ(capture.fields("rtps && !icmp", "ip.dst"), "");
}

}  // namespace
}  // namespace kinetrace::test
