#include "live/service_notifier.hpp"

#include <cstdlib>
#include <string>
#include <unistd.h>
#include <vector>

#include <gtest/gtest.h>

#include "service_manager.hpp"

namespace kinetrace::app {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;

using test::ServiceManager;
using Texts = std::vector<std::string>;

TEST(ServiceNotifier, IsReadyWithTheFirstProgressAndOnlyThen) {
  const ServiceManager manager;
  ServiceNotifier notifier;
  EXPECT_EQ(manager.received(), Texts{});
  notifier.progress(kSecond_ns);
  notifier.progress(100 * kSecond_ns);
  EXPECT_EQ(manager.received(), Texts{"READY=1"}) << "and there is no watchdog to feed";
  notifier.stopping();
  EXPECT_EQ(manager.received(), Texts{"STOPPING=1"});
}

TEST(ServiceNotifier, FeedsTheWatchdogWithProgressAlone) {
  const ServiceManager manager;
  setenv("WATCHDOG_USEC", "4000000", 1);
  setenv("WATCHDOG_PID", std::to_string(getpid()).c_str(), 1);
  ServiceNotifier notifier;
  notifier.progress(10 * kSecond_ns);
  EXPECT_EQ(manager.received(), (Texts{"READY=1", "WATCHDOG=1"}));
  notifier.progress(10 * kSecond_ns + kSecond_ns / 2);
  EXPECT_EQ(manager.received(), Texts{}) << "not more than four times in its interval";
  notifier.progress(11 * kSecond_ns);
  EXPECT_EQ(manager.received(), Texts{"WATCHDOG=1"});
}

TEST(ServiceNotifier, TheWatchdogOfAnotherProcessIsNotOurs) {
  const ServiceManager manager;
  setenv("WATCHDOG_USEC", "4000000", 1);
  setenv("WATCHDOG_PID", "1", 1);
  ServiceNotifier notifier;
  notifier.progress(10 * kSecond_ns);
  EXPECT_EQ(manager.received(), Texts{"READY=1"});
}

TEST(ServiceNotifier, TellsHowTheRunIsWhenThatChanges) {
  const ServiceManager manager;
  ServiceNotifier notifier;
  Condition now;
  notifier.tell(now);
  notifier.tell(now);
  EXPECT_EQ(manager.received(), Texts{"STATUS=ok"});
  now = {HealthState::kDegraded, {}};
  now.reasons.set(static_cast<std::size_t>(HealthReason::kFramesOutdated));
  now.reasons.set(static_cast<std::size_t>(HealthReason::kShedsPoints));
  notifier.tell(now);
  EXPECT_EQ(manager.received(), Texts{"STATUS=degraded: frames_outdated, sheds_points"});
  now = {HealthState::kLost, {}};
  now.reasons.set();
  notifier.tell(now);
  const Texts last = manager.received();
  ASSERT_EQ(last.size(), 1U);
  EXPECT_TRUE(last[0].ends_with("sheds_objects")) << last[0];
}

TEST(ServiceNotifier, IsSilentWithoutAManager) {
  unsetenv("NOTIFY_SOCKET");
  ServiceNotifier nobody;
  nobody.progress(kSecond_ns);
  setenv("NOTIFY_SOCKET", "/nowhere/socket", 1);
  ServiceNotifier gone;
  gone.progress(kSecond_ns);
  gone.stopping();
  unsetenv("NOTIFY_SOCKET");
}

}  // namespace
}  // namespace kinetrace::app
