#include "config/security_files.hpp"

#include <ctime>
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "security_folder.hpp"

namespace kinetrace::publishing {
namespace {

using test::SecurityFolder;
using testing::HasSubstr;

constexpr std::int64_t kDay_s = 86'400;

class SecurityFilesTest : public testing::Test {
 protected:
  std::string refusal(const SecurityConfig& config, std::int64_t later_s = 0) {
    const Status valid = check_security_files(config, std::time(nullptr) + later_s);
    return valid ? "" : valid.error().message;
  }
  SecurityFolder folder_;
  SecurityConfig config_ = folder_.make_all("alice");
};

TEST_F(SecurityFilesTest, ACompleteSetIsTaken) {
  EXPECT_EQ(refusal(config_), "");
}

TEST_F(SecurityFilesTest, EachMissingFileIsNamed) {
  for (std::string SecurityConfig::*file :
       {&SecurityConfig::identity_ca, &SecurityConfig::certificate, &SecurityConfig::private_key,
        &SecurityConfig::governance, &SecurityConfig::permissions}) {
    SecurityConfig config = config_;
    config.*file = folder_.file("nowhere.pem");
    EXPECT_THAT(refusal(config), HasSubstr("nowhere.pem does not exist"));
  }
}

TEST_F(SecurityFilesTest, AFileThatIsSomethingElseIsNamed) {
  std::ofstream(folder_.file("text")) << "not what you think";
  for (std::string SecurityConfig::*file :
       {&SecurityConfig::identity_ca, &SecurityConfig::certificate, &SecurityConfig::private_key,
        &SecurityConfig::governance, &SecurityConfig::permissions}) {
    SecurityConfig config = config_;
    config.*file = folder_.file("text");
    EXPECT_THAT(refusal(config), HasSubstr("/text is no "));
  }
  SecurityConfig config = config_;
  config.certificate = std::filesystem::path(config_.certificate).parent_path();
  EXPECT_THAT(refusal(config), HasSubstr("cannot be read")) << "a folder";
}

TEST_F(SecurityFilesTest, CertificatesHaveTheirTime) {
  EXPECT_EQ(refusal(config_, 49 * kDay_s), "");
  EXPECT_THAT(refusal(config_, 51 * kDay_s), HasSubstr("alice.cert.pem has expired"));
  EXPECT_THAT(refusal(config_, 101 * kDay_s), HasSubstr("ca.cert.pem has expired"));
  EXPECT_THAT(refusal(config_, -kDay_s), HasSubstr("is not yet valid; set the system clock, or wait"));
  EXPECT_THAT(refusal(config_, -std::time(nullptr) + 100), HasSubstr("the system clock has not been set yet"));
}

TEST_F(SecurityFilesTest, AnIdentityOfSomebodyElsesAuthorityIsRefused) {
  folder_.make_authority("other_ca");
  folder_.make_identity("mallory", "other_ca");
  SecurityConfig config = config_;
  config.certificate = folder_.file("mallory.cert.pem");
  config.private_key = folder_.file("mallory.key.pem");
  EXPECT_THAT(refusal(config), HasSubstr("mallory.cert.pem is not signed by"));
}

TEST_F(SecurityFilesTest, TheKeyMustBeTheCertificates) {
  folder_.make_identity("bob", "ca");
  SecurityConfig config = config_;
  config.private_key = folder_.file("bob.key.pem");
  EXPECT_THAT(refusal(config), HasSubstr("bob.key.pem does not belong to"));
}

TEST_F(SecurityFilesTest, DocumentsOfAnotherSignerAreRefused) {
  folder_.make_authority("other_ca");
  folder_.sign("loose_governance", SecurityFolder::governance(), "other_ca");
  SecurityConfig config = config_;
  config.governance = folder_.file("loose_governance.p7s");
  EXPECT_THAT(refusal(config), HasSubstr("dds.security.governance: "));
  EXPECT_THAT(refusal(config), HasSubstr("is not signed by"));
  config.permissions_ca = folder_.file("other_ca.cert.pem");
  EXPECT_THAT(refusal(config), HasSubstr("dds.security.permissions: ")) << "that one is still the first authority's";
}

TEST_F(SecurityFilesTest, AChangedDocumentIsRefused) {
  std::ifstream original(config_.permissions);
  std::string text((std::istreambuf_iterator<char>(original)), {});
  const std::size_t place = text.find("DENY");
  ASSERT_NE(place, std::string::npos);
  text.replace(place, 4, "ALLO");
  SecurityConfig config = config_;
  config.permissions = folder_.file("changed.p7s");
  std::ofstream(config.permissions) << text;
  EXPECT_THAT(refusal(config), HasSubstr("or was changed afterwards"));
}

TEST_F(SecurityFilesTest, AnAuthorityThatMayNotSignDocumentsIsRefused) {
  folder_.make_authority("ca", "keyCertSign,cRLSign");
  folder_.make_identity("alice", "ca");
  EXPECT_THAT(refusal(config_), HasSubstr("its keyUsage lacks digitalSignature"));
}

TEST_F(SecurityFilesTest, PluginsAreFoundBesideTheLibraryOrNamed) {
  EXPECT_NE(security_plugin_folder({}), "");
  SecurityConfig config = config_;
  config.plugins = "/nowhere";
  EXPECT_THAT(refusal(config), HasSubstr("name their folder with dds.security.plugins"));
}

}  // namespace
}  // namespace kinetrace::publishing
