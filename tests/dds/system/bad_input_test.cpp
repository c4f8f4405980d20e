// User errors, through `kinetrace run --publish`: one clear line with the remedy, and no start.
#include <algorithm>
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "network.hpp"
#include "parts.hpp"
#include "small_recording.hpp"
#include "temp_folder.hpp"

namespace kinetrace::test {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr int kConfig = 78;
constexpr int kNoInput = 66;

class DdsBadInput : public OwnNetworkTest {
 protected:
  void SetUp() override {
    OwnNetworkTest::SetUp();
    if (IsSkipped()) {
      return;
    }
    recording_.write();
  }
  [[nodiscard]] std::string written(const std::string& name, const std::string& text) const {
    std::string path = scratch_.file(name);
    std::ofstream(path) << text;
    return path;
  }
  /// `before` precedes the program, such as faketime.
  [[nodiscard]] Ending run(const std::string& settings, const Command& before = {}) const {
    Command command = before;
    const Command program = kinetrace_command({"run", "--dataset", recording_.dataset(), "--out",
                                               (scratch_.path() / "out").string(), "--quiet", "--publish", settings});
    command.insert(command.end(), program.begin(), program.end());
    return run_to_end(command);
  }
  void expect_refused(const Ending& ending, int exit_code, const std::string& culprit,
                      const std::string& remedy) const {
    EXPECT_EQ(ending.exit_code, exit_code) << ending.err;
    EXPECT_THAT(ending.err, AllOf(HasSubstr("error:"), HasSubstr(culprit), HasSubstr(remedy)));
    EXPECT_EQ(std::count(ending.err.begin(), ending.err.end(), '\n'), 1) << ending.err;
    EXPECT_FALSE(fs::exists(scratch_.path() / "out" / "camera.tum")) << "it ran all the same";
  }
  [[nodiscard]] fs::path made_keys(const Command& more = {}) const {
    make_keys(scratch_.path() / "keys", more);
    return enclave(scratch_.path() / "keys", "kinetrace");
  }

  TempFolder scratch_;
  SmallRecording recording_{.root = scratch_.path() / "recording"};
};

TEST_F(DdsBadInput, WhatIsRightRuns) {
  const Ending open = run(written("publish.yaml", "dds:\n  interface: lo\n"));
  EXPECT_EQ(open.exit_code, 0) << open.err;
  EXPECT_EQ(open.err, "");
  const Ending secured = run((made_keys() / "dds.yaml").string());
  EXPECT_EQ(secured.exit_code, 0) << secured.err;
  EXPECT_EQ(secured.err, "");
}

TEST_F(DdsBadInput, MalformedXml) {
  const std::string settings = written("publish.yaml", "dds:\n  xml: own.xml\n");
  expect_refused(run(settings), kNoInput, "own.xml", "does not exist");
  (void)written("own.xml", "<CycloneDDS><Domain Id=\"any\"><General></Domain>");
  expect_refused(run(settings), kConfig, "own.xml", "mismatch (Domain) at line 1");
  (void)written("own.xml", "<CycloneDDS><Domain Id=\"any\"><Genral/></Domain></CycloneDDS>");
  expect_refused(run(settings), kConfig, "own.xml", "Genral: unknown element");
}

TEST_F(DdsBadInput, WrongDomain) {
  expect_refused(run(written("publish.yaml", "dds:\n  domain: 231\n")), kConfig, "dds.domain", "0");
  expect_refused(run(written("publish.yaml", "dds:\n  domain: seven\n")), kConfig, "publish.yaml:2", "dds.domain");
  (void)written("own.xml", "<CycloneDDS><Domain Id=\"3\"/></CycloneDDS>");
  expect_refused(run(written("publish.yaml", "dds:\n  domain: 4\n  xml: own.xml\n")), kConfig, "own.xml",
                 "make the two agree");
}

TEST_F(DdsBadInput, UnknownKeysAndInterfacesThatCannotBe) {
  expect_refused(run(written("publish.yaml", "dds:\n  interfaces: lo\n")), kConfig, "publish.yaml:2", "dds.interfaces");
  expect_refused(run(written("publish.yaml", "dds:\n  interface: \"\"\n")), kConfig, "dds.interface", "letters");
  expect_refused(run((scratch_.path() / "none.yaml").string()), kNoInput, "none.yaml", "");
}

// The interface may be plugged in later, so the run continues, but with a warning.
TEST_F(DdsBadInput, AnUnknownInterfaceIsWaitedForLoudly) {
  const Ending ending = run(written("publish.yaml", "dds:\n  interface: eth9\n"));
  EXPECT_EQ(ending.exit_code, 0) << ending.err;
  EXPECT_THAT(ending.err, AllOf(HasSubstr("warning:"), HasSubstr("interface eth9 is not there"),
                                HasSubstr("there are lo"), HasSubstr("not_published")));
  EXPECT_EQ(ending.err.find("eth9"), ending.err.rfind("eth9")) << "once is enough: " << ending.err;
}

TEST_F(DdsBadInput, AnExpiredCertificate) {
  const std::string settings = (made_keys({"--days", "30"}) / "dds.yaml").string();
  expect_refused(run(settings, {"faketime", "-f", "+31d"}), kConfig, "cert.pem", "has expired; make a new one");
  EXPECT_EQ(run(settings, {"faketime", "-f", "+29d"}).exit_code, 0);
}

TEST_F(DdsBadInput, AClockIn1970) {
  const std::string settings = (made_keys() / "dds.yaml").string();
  expect_refused(run(settings, {"faketime", "1970-01-02 00:00:00"}), kConfig, "identity_ca.cert.pem",
                 "the system clock has not been set yet");
}

TEST_F(DdsBadInput, RequiredSecurityNeedsEveryFile) {
  const fs::path folder = made_keys();
  const std::string settings = (folder / "dds.yaml").string();
  for (const char* file : {"identity_ca.cert.pem", "permissions_ca.cert.pem", "cert.pem", "key.pem", "governance.p7s",
                           "permissions.p7s"}) {
    const fs::path aside = scratch_.path() / "aside";
    fs::rename(folder / file, aside);
    expect_refused(run(settings), kNoInput, file, "does not exist");
    std::ofstream(folder / file) << "nothing";
    expect_refused(run(settings), kConfig, file, "");
    fs::rename(aside, folder / file);
  }
  EXPECT_EQ(run(settings).exit_code, 0);
}

TEST_F(DdsBadInput, FilesOfSomebodyElseDoNotFit) {
  const fs::path folder = made_keys({"--device", "kinetrace", "--viewer", "viewer"});
  make_keys(scratch_.path() / "foreign");
  const fs::path foreign = enclave(scratch_.path() / "foreign", "kinetrace");
  const fs::path viewer = enclave(scratch_.path() / "keys", "viewer");
  const auto expect_no_fit = [&](const char* file, const fs::path& from, const std::string& remedy) {
    const std::string own = scratch_.file("own");
    fs::copy_file(folder / file, own, fs::copy_options::overwrite_existing);
    fs::copy_file(from / file, folder / file, fs::copy_options::overwrite_existing);
    expect_refused(run((folder / "dds.yaml").string()), kConfig, file, remedy);
    fs::copy_file(own, folder / file, fs::copy_options::overwrite_existing);
  };
  expect_no_fit("identity_ca.cert.pem", foreign, "is not signed by");
  expect_no_fit("key.pem", viewer, "does not belong to");
  expect_no_fit("governance.p7s", foreign, "is not signed by");
  expect_no_fit("permissions.p7s", foreign, "is not signed by");
  expect_no_fit("permissions.p7s", viewer, "must be for the subject of");
}

TEST_F(DdsBadInput, AViewerIsNoDevice) {
  (void)made_keys();
  const fs::path viewer = enclave(scratch_.path() / "keys", "viewer");
  expect_refused(run((viewer / "dds.yaml").string()), kConfig, "permissions.p7s", "allow its topics");
}

}  // namespace
}  // namespace kinetrace::test
