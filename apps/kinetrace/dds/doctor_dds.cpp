#include "dds/doctor_dds.hpp"

#include "dds/dds_link.hpp"

namespace kinetrace::app {
namespace {

using publishing::Link;
using publishing::LinkState;
using publishing::PublishConfig;

// Present participants answer an announcement at once.
constexpr std::int64_t kListen_ns = 1'500'000'000;

std::string where(const PublishConfig& config) {
  const std::string domain = "domain " + std::to_string(config.domain);
  return config.xml.empty() ? domain + " on " + config.interface : domain + " as in " + config.xml;
}

std::string described(const PublishConfig& config, const Link& link) {
  const bool is_secured = config.security.mode == publishing::SecurityMode::kRequired;
  const std::size_t others = link.others();
  return where(config) + (is_secured ? ", secured" : ", not secured") + "; " + std::to_string(others) +
         (others == 1 ? " other participant" : " other participants") + " seen";
}

NetworkFinding listened(const PublishConfig& config, Link& link) {
  const std::int64_t end_ns = steady_time_ns() + kListen_ns;
  std::string notice;
  for (std::int64_t now_ns = steady_time_ns(); now_ns < end_ns; now_ns = steady_time_ns()) {
    link.supervise(now_ns);
    notice = link.take_notice().value_or(notice);
    link.wait(end_ns - now_ns);
  }
  if (link.state() == LinkState::kConnected) {
    return {true, described(config, link)};
  }
  return {false, where(config) + ": " + notice + "; name another one with dds.interface"};
}

}  // namespace

NetworkFinding examine_network(const std::string& file) {
  const Result<PublishConfig> config = network_config({.file = file, .domain = {}, .interface = {}, .device = {}});
  if (!config) {
    return {false, config.error().message};
  }
  const auto link = Link::create(*config);
  return link ? listened(*config, **link) : NetworkFinding{false, link.error().message};
}

}  // namespace kinetrace::app
