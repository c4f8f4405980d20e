// `kinetrace keys`, from outside.
#include <filesystem>
#include <fstream>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "parts.hpp"
#include "temp_folder.hpp"

namespace kinetrace::test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr int kUsage = 64;
constexpr int kCannotCreate = 73;

class Keys : public ::testing::Test {
 protected:
  [[nodiscard]] Ending make(const Command& more = {}) const {
    Command command = kinetrace_command({"keys", "--out", keys_.string()});
    command.insert(command.end(), more.begin(), more.end());
    return run_to_end(command);
  }
  [[nodiscard]] static std::string text_of(const fs::path& path) {
    std::ostringstream text;
    text << std::ifstream(path).rdbuf();
    return text.str();
  }

  TempFolder scratch_;
  fs::path keys_ = scratch_.path() / "keys";
};

TEST_F(Keys, MakesADeviceAndAViewerThatOpensslAccepts) {
  ASSERT_EQ(make().exit_code, 0);
  const std::string authority = (keys_ / "public" / "ca.cert.pem").string();
  for (const char* name : {"kinetrace", "viewer"}) {
    const fs::path folder = enclave(keys_, name);
    const auto openssl = [](const Command& arguments) {
      Command command{"openssl"};
      command.insert(command.end(), arguments.begin(), arguments.end());
      return run_to_end(command);
    };
    EXPECT_EQ(openssl({"verify", "-x509_strict", "-CAfile", authority, (folder / "cert.pem").string()}).exit_code, 0);
    for (const char* document : {"governance.p7s", "permissions.p7s"}) {
      const Ending verified = openssl({"smime", "-verify", "-text", "-in", (folder / document).string(), "-CAfile",
                                       authority, "-out", "/dev/null"});
      EXPECT_EQ(verified.exit_code, 0) << document << verified.err;
    }
    EXPECT_THAT(text_of(folder / "permissions.p7s"), HasSubstr(std::string("<subject_name>CN=") + name));
  }
}

TEST_F(Keys, SecretsAreForTheOwnerAlone) {
  ASSERT_EQ(make().exit_code, 0);
  for (const fs::path& secret : {keys_ / "private" / "ca.key.pem", enclave(keys_, "kinetrace") / "key.pem"}) {
    EXPECT_EQ(fs::status(secret).permissions(), fs::perms::owner_read | fs::perms::owner_write) << secret;
    EXPECT_EQ(fs::status(secret.parent_path()).permissions(), fs::perms::owner_all) << secret;
    EXPECT_THAT(text_of(secret), HasSubstr("PRIVATE KEY"));
  }
  EXPECT_FALSE(fs::exists(enclave(keys_, "kinetrace") / "ca.key.pem")) << "the authority stays at home";
}

TEST_F(Keys, NeverOverwrites) {
  ASSERT_EQ(make().exit_code, 0);
  const std::string before = text_of(enclave(keys_, "viewer") / "key.pem");
  const Ending again = make({"--viewer", "tablet", "--viewer", "viewer"});
  EXPECT_EQ(again.exit_code, kCannotCreate);
  EXPECT_THAT(again.err, HasSubstr("viewer exists already"));
  EXPECT_EQ(text_of(enclave(keys_, "viewer") / "key.pem"), before);
  EXPECT_FALSE(fs::exists(enclave(keys_, "tablet"))) << "all or nothing";
}

TEST_F(Keys, AnAuthorityCertifiesLaterOnesToo) {
  ASSERT_EQ(make().exit_code, 0);
  ASSERT_EQ(make({"--viewer", "tablet"}).exit_code, 0);
  EXPECT_EQ(text_of(enclave(keys_, "tablet") / "identity_ca.cert.pem"),
            text_of(enclave(keys_, "kinetrace") / "identity_ca.cert.pem"));
}

TEST_F(Keys, LeavesForeignFoldersAlone) {
  std::ofstream(scratch_.file("keys/notes.txt")) << "mine";
  const Ending ending = make();
  EXPECT_EQ(ending.exit_code, kCannotCreate);
  EXPECT_THAT(ending.err, HasSubstr("name a new folder"));
  EXPECT_FALSE(fs::exists(keys_ / "private"));
}

TEST_F(Keys, ADamagedAuthorityIsNamed) {
  ASSERT_EQ(make().exit_code, 0);
  std::ofstream(keys_ / "private" / "ca.key.pem") << "nothing";
  const Ending ending = make({"--viewer", "tablet"});
  EXPECT_EQ(ending.exit_code, 65);
  EXPECT_THAT(ending.err, HasSubstr("authority"));
}

TEST_F(Keys, NamesThatCannotBeAreRefused) {
  for (const Command& wrong : {Command{"--device", "../up"},
                               {"--device", ".hidden"},
                               {"--device", ""},
                               {"--viewer", "with space"},
                               {"--viewer", std::string(32, 'x')},
                               {"--device", "a", "--viewer", "a"},
                               {"--days", "0"},
                               {"--days", "3651"},
                               {"--ros2-prefix", "<x>"}}) {
    EXPECT_EQ(make(wrong).exit_code, kUsage) << wrong[1];
  }
  EXPECT_FALSE(fs::exists(keys_));
}

TEST_F(Keys, AClockThatIsNotSetMakesNone) {
  Command command{"faketime", "1970-01-02 00:00:00"};
  const Command keys = kinetrace_command({"keys", "--out", keys_.string()});
  command.insert(command.end(), keys.begin(), keys.end());
  const Ending ending = run_to_end(command);
  EXPECT_EQ(ending.exit_code, 78);
  EXPECT_THAT(ending.err, HasSubstr("system clock"));
  EXPECT_FALSE(fs::exists(keys_));
}

}  // namespace
}  // namespace kinetrace::test
