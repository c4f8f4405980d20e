// Controls of a driver that sets requested values, or does not.
#include "capture/v4l2/v4l2_controls.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <linux/videodev2.h>
#include <optional>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace kinetrace::hal {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr __u32 kTriggerId = V4L2_CID_USER_BASE + 0x1000;

struct Control {
  __u32 id = kTriggerId;
  std::string name = "Trigger Mode";
  __u32 type = V4L2_CTRL_TYPE_MENU;
  std::vector<std::string> entries{"Off", "External"};  ///< Menu entries; an empty text is a hole.
  __s32 minimum = 0;
  __s32 maximum = 1;
  __s32 value = 0;
  bool ignores_writes = false;  ///< Accepts a value without setting it.
  int refuses = 0;              ///< errno of the refusal to set it.
};

using Controls = std::vector<Control>;

class Driver {
 public:
  explicit Driver(Controls controls) : controls_(std::move(controls)) { current_ = this; }
  Driver(const Driver&) = delete;
  Driver& operator=(const Driver&) = delete;
  ~Driver() { current_ = nullptr; }

  [[nodiscard]] V4l2File file() const { return {"/dev/video0", OwnedFd(), &Driver::ioctl}; }
  [[nodiscard]] const Control& control(std::size_t index) const { return controls_[index]; }

 private:
  static int ioctl(int /*fd*/, unsigned long request, void* argument) {
    const int code = current_->answer(request, argument);
    errno = code;
    return code == 0 ? 0 : -1;
  }
  int answer(unsigned long request, void* argument) {
    switch (request) {
      case VIDIOC_QUERYCTRL: return describe(*static_cast<v4l2_queryctrl*>(argument));
      case VIDIOC_QUERYMENU: return describe(*static_cast<v4l2_querymenu*>(argument));
      case VIDIOC_S_CTRL: return set(*static_cast<v4l2_control*>(argument));
      case VIDIOC_G_CTRL: return get(*static_cast<v4l2_control*>(argument));
      default: return ENOTTY;
    }
  }
  Control* find(__u32 id) {
    const auto found =
        std::find_if(controls_.begin(), controls_.end(), [id](const Control& control) { return control.id == id; });
    return found == controls_.end() ? nullptr : &*found;
  }
  int describe(v4l2_queryctrl& query) {
    const bool wants_next = (query.id & V4L2_CTRL_FLAG_NEXT_CTRL) != 0;
    const __u32 id = query.id & ~V4L2_CTRL_FLAG_NEXT_CTRL;
    const Control* found = wants_next ? nullptr : find(id);
    for (const Control& control : controls_) {
      const bool is_nearer = control.id > id && (found == nullptr || control.id < found->id);
      found = wants_next && is_nearer ? &control : found;
    }
    if (found == nullptr) {
      return EINVAL;
    }
    query = {};
    query.id = found->id;
    query.type = found->type;
    query.minimum = found->minimum;
    query.maximum = found->maximum;
    std::snprintf(reinterpret_cast<char*>(query.name), sizeof query.name, "%s", found->name.c_str());
    return 0;
  }
  int describe(v4l2_querymenu& query) {
    const Control* control = find(query.id);
    if (control == nullptr || query.index >= control->entries.size() || control->entries[query.index].empty()) {
      return EINVAL;
    }
    std::snprintf(reinterpret_cast<char*>(query.name), sizeof query.name, "%s", control->entries[query.index].c_str());
    return 0;
  }
  int set(const v4l2_control& request) {
    Control* control = find(request.id);
    if (control == nullptr || control->refuses != 0) {
      return control == nullptr ? EINVAL : control->refuses;
    }
    control->value = control->ignores_writes ? control->value : request.value;
    return 0;
  }
  int get(v4l2_control& request) {
    const Control* control = find(request.id);
    request.value = control == nullptr ? 0 : control->value;
    return control == nullptr ? EINVAL : 0;
  }

  static Driver* current_;
  Controls controls_;
};
Driver* Driver::current_ = nullptr;

Status set(const Driver& driver, TriggerMode mode) {
  CaptureConfig config;
  config.trigger = mode;
  CaptureInfo info;
  info.name = "sensor";
  return set_v4l2_controls(driver.file(), config, info);
}

TEST(V4l2Trigger, ChoosesTheMenusEntryByItsWord) {
  const std::vector<std::vector<std::string>> menus{{"Off", "External"},
                                                    {"Free run", "", "Hardware trigger"},
                                                    {"Software trigger", "External, rising edge", "Disabled"}};
  const std::vector<std::pair<__s32, __s32>> expected{{0, 1}, {0, 2}, {2, 1}};
  for (std::size_t i = 0; i < menus.size(); ++i) {
    Driver driver(Controls{{.entries = menus[i], .maximum = static_cast<__s32>(menus[i].size()) - 1}});
    ASSERT_TRUE(set(driver, TriggerMode::kExternal));
    EXPECT_EQ(driver.control(0).value, expected[i].second) << i;
    ASSERT_TRUE(set(driver, TriggerMode::kFreeRunning)) << "what another program left behind is set back";
    EXPECT_EQ(driver.control(0).value, expected[i].first) << i;
  }
}

TEST(V4l2Trigger, ASwitchIsOnOrOff) {
  Driver driver(
      Controls{{.id = V4L2_CID_USER_BASE + 1, .name = "Brightness", .type = V4L2_CTRL_TYPE_INTEGER, .value = 77},
               {.name = "trigger mode", .type = V4L2_CTRL_TYPE_BOOLEAN}});
  ASSERT_TRUE(set(driver, TriggerMode::kExternal));
  EXPECT_EQ(driver.control(1).value, 1);
  ASSERT_TRUE(set(driver, TriggerMode::kFreeRunning));
  EXPECT_EQ(driver.control(1).value, 0);
  EXPECT_EQ(driver.control(0).value, 77);
}

TEST(V4l2Trigger, WhatTheDriverDidNotSetIsAnErrorThatPrintsBoth) {
  for (const TriggerMode mode : {TriggerMode::kExternal, TriggerMode::kFreeRunning}) {
    const bool external = mode == TriggerMode::kExternal;
    const Driver driver(Controls{{.value = external ? 0 : 1, .ignores_writes = true}});
    const Status failed = set(driver, mode);
    ASSERT_FALSE(failed);
    EXPECT_EQ(failed.error().code, ErrorCode::kUnsupported);
    EXPECT_THAT(failed.error().message, AllOf(HasSubstr(external ? "asked for trigger mode 1" : "for trigger mode 0"),
                                              HasSubstr(external ? "the driver set 0" : "the driver set 1")));
  }
}

TEST(V4l2Trigger, ARefusalOfTheDriverIsAnError) {
  const Driver driver(Controls{{.refuses = EBUSY}});
  const Status failed = set(driver, TriggerMode::kExternal);
  ASSERT_FALSE(failed);
  EXPECT_EQ(failed.error().code, ErrorCode::kIo);
  EXPECT_THAT(failed.error().message, HasSubstr("/dev/video0"));
}

TEST(V4l2Trigger, ModesThatADeviceLacksAreErrors) {
  const Status without_control = set(Driver(Controls{}), TriggerMode::kExternal);
  ASSERT_FALSE(without_control);
  EXPECT_EQ(without_control.error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(without_control.error().message, HasSubstr("no control 'Trigger Mode'"));
  EXPECT_TRUE(set(Driver(Controls{}), TriggerMode::kFreeRunning)) << "it can do nothing else";

  const Status without_entry = set(Driver(Controls{{.entries = {"Off", "Software"}}}), TriggerMode::kExternal);
  ASSERT_FALSE(without_entry);
  EXPECT_EQ(without_entry.error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(without_entry.error().message, HasSubstr("external"));
}

TEST(V4l2Exposure, IsReadBackInTheDriversUnit) {
  const auto exposure = [](bool ignores_writes) {
    return Control{.id = V4L2_CID_EXPOSURE_ABSOLUTE,
                   .name = "Exposure Time, Absolute",
                   .type = V4L2_CTRL_TYPE_INTEGER,
                   .minimum = 1,
                   .maximum = 5000,
                   .value = 157,
                   .ignores_writes = ignores_writes};
  };
  CaptureConfig config;
  config.exposure_us = 5040.0;
  CaptureInfo info;
  info.name = "sensor";
  const Driver good(Controls{exposure(false)});
  ASSERT_TRUE(set_v4l2_controls(good.file(), config, info));
  EXPECT_EQ(good.control(0).value, 50);
  EXPECT_EQ(info.exposure_us, 5000.0) << "what it was set to, not what was asked for";
  const Driver deaf(Controls{exposure(true)});
  const Status failed = set_v4l2_controls(deaf.file(), config, info);
  ASSERT_FALSE(failed);
  EXPECT_THAT(failed.error().message,
              AllOf(HasSubstr("asked for exposure_us 5040"), HasSubstr("the driver set 15700")));
}

}  // namespace
}  // namespace kinetrace::hal
