#include "network.hpp"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <sched.h>
#include <sstream>
#include <stdexcept>
#include <unistd.h>

namespace kinetrace::test {
namespace {

std::vector<std::string> words(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> all;
  for (std::string word; stream >> word;) {
    all.push_back(word);
  }
  return all;
}

// Without privileges a network requires a user namespace, in which we are root.
bool enter_with_user_namespace() {
  const uid_t user = getuid();
  const gid_t group = getgid();
  if (unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0) {
    return false;
  }
  std::ofstream("/proc/self/setgroups") << "deny";
  std::ofstream("/proc/self/uid_map") << "0 " << user << " 1";
  std::ofstream("/proc/self/gid_map") << "0 " << group << " 1";
  return true;
}

}  // namespace

void OwnNetworkTest::SetUp() {
  if (!(geteuid() == 0 && unshare(CLONE_NEWNET) == 0) && !enter_with_user_namespace()) {
    GTEST_SKIP() << "no network namespace can be made (" << std::strerror(errno)
                 << "); run as root, or allow user namespaces (kernel.unprivileged_userns_clone)";
  }
  // Where tc is, which is not in the path of ordinary users.
  const char* path = std::getenv("PATH");
  setenv("PATH", ((path == nullptr ? "" : std::string(path) + ":") + "/usr/sbin:/sbin").c_str(), 1);
  configure("ip link set lo up");
}

void configure(const std::string& command) {
  const Ending ending = run_to_end(words(command));
  if (ending.exit_code != 0) {
    throw std::runtime_error(command + ": " + ending.err);
  }
}

long dropped_packets(const std::string& interface) {
  const Ending shown = run_to_end({"tc", "-s", "qdisc", "show", "dev", interface});
  constexpr std::string_view kKey = "dropped ";
  long dropped = 0;
  for (std::size_t at = shown.out.find(kKey); at != std::string::npos; at = shown.out.find(kKey, at + 1)) {
    dropped += std::stol(shown.out.substr(at + kKey.size()));
  }
  return dropped;
}

Neighbour::Neighbour() : holder_({"unshare", "--net", "sh", "-c", "ip link set lo up && echo {} && exec sleep 600"}) {
  if (!holder_.until([](const nlohmann::json&) { return true; })) {
    throw std::runtime_error("no second network namespace can be made: " + holder_.err());
  }
  const std::string there = std::to_string(holder_.pid());
  prefix_ = "nsenter --net=/proc/" + there + "/ns/net --";
  configure(std::string("ip link add name ") + kHere + " type veth peer name " + kThere);
  configure(std::string("ip link set ") + kThere + " netns " + there);
  configure(std::string("ip addr add ") + kHereAddress + "/24 dev " + kHere);
  configure(std::string("ip link set ") + kHere + " up");
  configure_there(std::string("ip addr add ") + kThereAddress + "/24 dev " + kThere);
  configure_there(std::string("ip link set ") + kThere + " up");
}

std::vector<std::string> Neighbour::inside(const std::vector<std::string>& command) const {
  std::vector<std::string> all = words(prefix_);
  all.insert(all.end(), command.begin(), command.end());
  return all;
}

void Neighbour::configure_there(const std::string& command) const {
  configure(prefix_ + " " + command);
}

}  // namespace kinetrace::test
