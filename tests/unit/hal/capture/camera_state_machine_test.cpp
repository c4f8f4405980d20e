// Every event in every state, and the timers to the nanosecond.
#include "capture/camera_state_machine.hpp"

#include <array>
#include <initializer_list>
#include <limits>
#include <utility>

#include <gtest/gtest.h>

namespace kinetrace::hal::test {
namespace {

using State = CameraState;
using Event = CameraEvent;

constexpr CameraTimeouts kTimeouts{.stall_ns = 100, .lost_ns = 1000, .reopen_first_ns = 10, .reopen_longest_ns = 35};
constexpr std::int64_t kNow_ns = 5000;
constexpr std::int64_t kExposure_ns = 7;

constexpr std::array kStates{State::kClosed,  State::kConfigured, State::kStreaming,
                             State::kStalled, State::kLost,       State::kRecovering};
constexpr std::array kEvents{Event::kOpened,       Event::kStarted,  Event::kFrame,
                             Event::kStopped,      Event::kReopened, Event::kReopenFailed,
                             Event::kStallTimeout, Event::kLost,     Event::kClosed};

CameraStateMachine after(std::initializer_list<Event> events, const CameraTimeouts& timeouts = kTimeouts) {
  CameraStateMachine machine(timeouts);
  for (const Event event : events) {
    EXPECT_TRUE(machine.accepts(event));
    machine.handle(event, kNow_ns);
  }
  return machine;
}

CameraStateMachine machine_in(State state) {
  switch (state) {
    case State::kClosed: return after({});
    case State::kConfigured: return after({Event::kOpened});
    case State::kStreaming: return after({Event::kOpened, Event::kStarted});
    case State::kStalled: return after({Event::kOpened, Event::kStarted, Event::kStallTimeout});
    case State::kLost: return after({Event::kOpened, Event::kStarted, Event::kLost});
    case State::kRecovering: return after({Event::kOpened, Event::kStarted, Event::kLost, Event::kReopened});
  }
  return after({});
}

TEST(CameraStateMachine, LeadsFromEachStateByEachEventToTheStateOfTheTable) {
  constexpr std::optional<State> no;
  // A row for each of kStates, a column for each of kEvents.
  constexpr std::optional<State> closed = State::kClosed;
  constexpr std::optional<State> config = State::kConfigured;
  constexpr std::optional<State> stream = State::kStreaming;
  constexpr std::optional<State> stall = State::kStalled;
  constexpr std::optional<State> lost = State::kLost;
  constexpr std::optional<State> recover = State::kRecovering;
  // clang-format off
  constexpr std::optional<State> table[kStates.size()][kEvents.size()] = {
      // opened start   frame   stopped reopened  failed stall  lost  closed
      {config,  no,     no,     no,     no,       no,    no,    no,   closed},
      {no,      stream, no,     no,     no,       no,    no,    no,   closed},
      {no,      no,     stream, config, no,       no,    stall, lost, closed},
      {no,      no,     stream, config, no,       no,    no,    lost, closed},
      {no,      no,     no,     no,     recover,  lost,  no,    no,   closed},
      {no,      no,     stream, config, no,       no,    no,    lost, closed},
  };
  // clang-format on
  for (std::size_t row = 0; row < kStates.size(); ++row) {
    for (std::size_t column = 0; column < kEvents.size(); ++column) {
      CameraStateMachine machine = machine_in(kStates[row]);
      ASSERT_EQ(machine.state(), kStates[row]);
      const std::optional<State> expected = table[row][column];
      SCOPED_TRACE(testing::Message() << "event " << column << " while " << to_string(kStates[row]));
      EXPECT_EQ(machine.accepts(kEvents[column]), expected.has_value());
      machine.handle(kEvents[column], kNow_ns);
      EXPECT_EQ(machine.state(), expected.value_or(kStates[row]));
    }
  }
}

TEST(CameraStateMachine, NamesTheTimeoutThatHasPassed) {
  struct Case {
    State state;
    std::int64_t without_frame_ns;
    std::optional<Event> expired;
  };
  constexpr std::int64_t stall_ns = 100 + kExposure_ns;
  constexpr std::int64_t lost_ns = stall_ns + 1000;
  for (const Case& c : {Case{State::kStreaming, stall_ns, std::nullopt},
                        {State::kStreaming, stall_ns + 1, Event::kStallTimeout},
                        {State::kStreaming, lost_ns, Event::kStallTimeout},
                        {State::kStreaming, lost_ns + 1, Event::kLost},
                        {State::kStalled, stall_ns + 1, std::nullopt},
                        {State::kStalled, lost_ns, std::nullopt},
                        {State::kStalled, lost_ns + 1, Event::kLost},
                        {State::kRecovering, stall_ns + 1, std::nullopt},
                        {State::kRecovering, lost_ns + 1, Event::kLost}}) {
    const CameraStateMachine machine = machine_in(c.state);
    EXPECT_EQ(machine.expired(kNow_ns + c.without_frame_ns, kExposure_ns), c.expired)
        << to_string(c.state) << " after " << c.without_frame_ns;
    EXPECT_EQ(machine.loss_due_ns(kExposure_ns), kNow_ns + lost_ns + 1);
  }
}

TEST(CameraStateMachine, StartsItsTimeoutsAnewWithStreamingAndWithEachFrame) {
  for (const auto& [state, event] : {std::pair{State::kConfigured, Event::kStarted},
                                     {State::kLost, Event::kReopened},
                                     {State::kStreaming, Event::kFrame},
                                     {State::kStalled, Event::kFrame},
                                     {State::kRecovering, Event::kFrame}}) {
    CameraStateMachine machine = machine_in(state);
    machine.handle(event, kNow_ns + 90);
    EXPECT_EQ(machine.last_frame_ns(), kNow_ns + 90) << to_string(state);
    EXPECT_EQ(machine.expired(kNow_ns + 190, 0), std::nullopt) << to_string(state);
  }
}

TEST(CameraStateMachine, MissingDataIsNeverALossWithoutALostTimeout) {
  CameraTimeouts triggered = kTimeouts;
  triggered.lost_ns.reset();
  const CameraStateMachine machine = after({Event::kOpened, Event::kStarted}, triggered);
  constexpr std::int64_t kMax = std::numeric_limits<std::int64_t>::max();
  EXPECT_EQ(machine.loss_due_ns(kExposure_ns), kMax);
  EXPECT_EQ(machine.expired(kMax - 1, kExposure_ns), Event::kStallTimeout);
}

TEST(CameraStateMachine, DoublesTheIntervalOfAttemptsUpToTheLongestAndBeginsAnewWithEachLoss) {
  CameraStateMachine machine = machine_in(State::kStreaming);
  for (int loss = 0; loss < 2; ++loss) {
    std::int64_t now_ns = kNow_ns * (loss + 1);
    machine.handle(Event::kLost, now_ns);
    for (const std::int64_t interval_ns : {10, 20, 35, 35}) {
      EXPECT_FALSE(machine.is_reopen_due(now_ns + interval_ns - 1)) << interval_ns;
      EXPECT_TRUE(machine.is_reopen_due(now_ns + interval_ns)) << interval_ns;
      now_ns += interval_ns;
      machine.handle(Event::kReopenFailed, now_ns);
    }
    machine.handle(Event::kReopened, now_ns);
  }
}

}  // namespace
}  // namespace kinetrace::hal::test
