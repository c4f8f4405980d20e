// DDS Security with keys of `kinetrace keys`: only permitted readers get data.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "network.hpp"
#include "parts.hpp"
#include "temp_folder.hpp"

namespace kinetrace::test {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

class DdsSecurity : public OwnNetworkTest {
 protected:
  void SetUp() override {
    OwnNetworkTest::SetUp();
    if (IsSkipped()) {
      return;
    }
    make_keys(keys_, {"--device", "kinetrace", "--device", "other", "--viewer", "viewer"});
  }
  [[nodiscard]] Command secured_scene(const Command& more = {}) const {
    Command command = scene_command(secured_by(enclave(keys_, "kinetrace")));
    command.insert(command.end(), more.begin(), more.end());
    return command;
  }
  [[nodiscard]] static Command reader_with(const std::filesystem::path& enclave, const Command& more = {}) {
    Command command = local_fast_reader_command({"--enclave", enclave.string()});
    command.insert(command.end(), more.begin(), more.end());
    return command;
  }

  TempFolder scratch_;
  std::filesystem::path keys_ = scratch_.path() / "keys";
};

TEST_F(DdsSecurity, OnlyAnAuthorisedReaderGetsAnything) {
  make_keys(scratch_.path() / "foreign");
  const Process scene(secured_scene());
  const Process viewer(reader_with(enclave(keys_, "viewer")));
  const Process unauthorised(reader_with(enclave(keys_, "other")));  // Known, but may not read.
  const Process foreign(reader_with(enclave(scratch_.path() / "foreign", "viewer")));
  const Process unsecured(local_fast_reader_command());
  ASSERT_TRUE(viewer.until(all_topics_have(1))) << viewer.report() << viewer.err() << scene.err();
  ASSERT_TRUE(viewer.until(more_than_now(viewer, "total", 500)));
  EXPECT_THAT(viewer.report()["mistakes"], IsEmpty());
  for (const Process* other : {&unauthorised, &foreign, &unsecured}) {
    ASSERT_TRUE(other->until(at_least("participants", 1))) << "it did not even hear of anybody: " << other->err();
    EXPECT_EQ(other->report()["total"], 0);
    EXPECT_THAT(other->report()["writers"], IsEmpty()) << "topics are nobody else's business either";
  }
}

TEST_F(DdsSecurity, AnUnsecuredPublisherIsRejected) {
  const Process scene(scene_command());
  const Process unsecured(local_fast_reader_command());
  const Process viewer(reader_with(enclave(keys_, "viewer")));
  ASSERT_TRUE(unsecured.until(at_least("total", 500)));
  ASSERT_TRUE(viewer.until(at_least("participants", 1)));
  EXPECT_EQ(viewer.report()["total"], 0);
}

TEST_F(DdsSecurity, AViewerMayReadButNotPublish) {
  const Process scene(secured_scene());
  const Process viewer(reader_with(enclave(keys_, "viewer"), {"--publish"}));
  ASSERT_TRUE(viewer.until(all_topics_have(1))) << viewer.report();
  EXPECT_EQ(viewer.err().find("may write odometry"), std::string::npos);

  const Ending publisher = run_to_end(scene_command(secured_by(enclave(keys_, "viewer"))));
  EXPECT_NE(publisher.exit_code, 0);
  EXPECT_THAT(publisher.err, HasSubstr("kinetrace/camera_pose"));
}

TEST_F(DdsSecurity, WithoutSecurityAReaderMayWriteWhatItLikes) {
  // Counterpart of the test above: writing succeeds if nothing forbids it.
  const Process reader(local_fast_reader_command({"--publish"}));
  ASSERT_TRUE(reader.until(at_least("total", 0)));
  EXPECT_THAT(reader.err(), HasSubstr("may write odometry"));
}

}  // namespace
}  // namespace kinetrace::test
