// Keys and signed documents of DDS Security, made with the openssl program.
#pragma once

#include <cstdlib>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "kinetrace/publishing/publish_config.hpp"
#include "temp_folder.hpp"

namespace kinetrace::test {

/// Every file lies in the folder: NAME.cert.pem, NAME.key.pem, NAME.p7s. Each step is a separate call, so that tests
/// can omit one or do it wrong.
class SecurityFolder {
 public:
  [[nodiscard]] std::string file(const std::string& name) const { return folder_.file(name); }

  void make_authority(const std::string& name,
                      const std::string& usage = "digitalSignature,keyCertSign,cRLSign") const {
    run("openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -days 100 -subj /CN=" + name +
        " -keyout " + file(name + ".key.pem") + " -out " + file(name + ".cert.pem") +
        " -addext basicConstraints=critical,CA:true -addext keyUsage=critical," + usage);
  }
  void make_identity(const std::string& name, const std::string& authority) const {
    run("openssl req -new -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -subj /O=Kinetrace/CN=" + name +
        " -keyout " + file(name + ".key.pem") + " -out " + file(name + ".csr"));
    run("openssl x509 -req -days 50 -in " + file(name + ".csr") + " -CA " + file(authority + ".cert.pem") + " -CAkey " +
        file(authority + ".key.pem") + " -CAcreateserial -out " + file(name + ".cert.pem"));
  }
  void sign(const std::string& name, const std::string& text, const std::string& authority) const {
    std::ofstream(file(name + ".xml")) << text;
    run("openssl smime -sign -text -in " + file(name + ".xml") + " -out " + file(name + ".p7s") + " -signer " +
        file(authority + ".cert.pem") + " -inkey " + file(authority + ".key.pem"));
  }

  /// Of the identity `name`, with authority "ca" and documents "governance" and `name`_permissions.
  [[nodiscard]] publishing::SecurityConfig config(const std::string& name) const {
    return {.mode = publishing::SecurityMode::kRequired,
            .identity_ca = file("ca.cert.pem"),
            .certificate = file(name + ".cert.pem"),
            .private_key = file(name + ".key.pem"),
            .governance = file("governance.p7s"),
            .permissions = file(name + "_permissions.p7s")};
  }
  /// A complete, valid set for the identity `name`.
  [[nodiscard]] publishing::SecurityConfig make_all(const std::string& name) const {
    make_authority("ca");
    make_identity(name, "ca");
    sign("governance", governance(), "ca");
    sign(name + "_permissions", permissions(name), "ca");
    return config(name);
  }

  [[nodiscard]] static std::string governance() {
    return R"(<?xml version="1.0" encoding="UTF-8"?>
<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance">
<domain_access_rules><domain_rule><domains><id_range><min>0</min><max>230</max></id_range></domains>
<allow_unauthenticated_participants>false</allow_unauthenticated_participants>
<enable_join_access_control>true</enable_join_access_control>
<discovery_protection_kind>ENCRYPT</discovery_protection_kind><liveliness_protection_kind>ENCRYPT</liveliness_protection_kind>
<rtps_protection_kind>NONE</rtps_protection_kind>
<topic_access_rules><topic_rule><topic_expression>*</topic_expression>
<enable_discovery_protection>true</enable_discovery_protection><enable_liveliness_protection>true</enable_liveliness_protection>
<enable_read_access_control>true</enable_read_access_control><enable_write_access_control>true</enable_write_access_control>
<metadata_protection_kind>ENCRYPT</metadata_protection_kind><data_protection_kind>NONE</data_protection_kind>
</topic_rule></topic_access_rules></domain_rule></domain_access_rules></dds>
)";
  }
  [[nodiscard]] static std::string permissions(const std::string& name) {
    return R"(<?xml version="1.0" encoding="UTF-8"?>
<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"><permissions><grant name=")" +
           name + R"("><subject_name>CN=)" + name + R"(,O=Kinetrace</subject_name>
<validity><not_before>2020-01-01T00:00:00</not_before><not_after>2045-01-01T00:00:00</not_after></validity>
<allow_rule><domains><id_range><min>0</min><max>230</max></id_range></domains>
<publish><topics><topic>*</topic></topics></publish><subscribe><topics><topic>*</topic></topics></subscribe>
</allow_rule><default>DENY</default></grant></permissions></dds>
)";
  }

 private:
  static void run(const std::string& command) {
    ASSERT_EQ(std::system((command + " > /dev/null 2>&1").c_str()), 0) << command;
  }
  TempFolder folder_;
};

}  // namespace kinetrace::test
