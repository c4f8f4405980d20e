// Parses the faults of --fault and of camera configurations.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "kinetrace/core/nearest_name.hpp"
#include "kinetrace/hal/fault_injector.hpp"
#include "util/messages.hpp"
#include "util/text_file.hpp"

namespace kinetrace::hal {
namespace {

struct Known {
  std::string_view name;
  FaultKind kind;
  double default_value;
  double lowest;
  double highest;
};

constexpr std::array<Known, 10> kKnown{{{"unplug", FaultKind::kUnplug, 2.0, 0.0, 1e6},
                                        {"stuck", FaultKind::kStuck, 0.0, 0.0, 0.0},
                                        {"slow", FaultKind::kSlow, 100.0, 0.0, 60e3},
                                        {"drop", FaultKind::kDrop, 0.0, 0.0, 0.0},
                                        {"duplicate", FaultKind::kDuplicate, 0.0, 0.0, 0.0},
                                        {"reorder", FaultKind::kReorder, 0.0, 0.0, 0.0},
                                        {"corrupt", FaultKind::kCorrupt, 60.0, 1.0, 100.0},
                                        {"desync", FaultKind::kDesync, 0.0, 0.0, 0.0},
                                        {"clock", FaultKind::kClock, 3600.0, -1e6, 1e6},
                                        {"size", FaultKind::kSize, 0.0, 0.0, 0.0}}};

constexpr auto kNames = [] {
  std::array<std::string_view, kKnown.size()> names{};
  std::transform(kKnown.begin(), kKnown.end(), names.begin(), [](const Known& known) { return known.name; });
  return names;
}();

Unexpected<Error> refused(std::string_view part, std::string_view why) {
  return fail(
      ErrorCode::kInvalidArgument,
      concat("fault '", part, "': ", why, "; write KIND@FIRST[-LAST][%PERCENT][:VALUE], for example drop@10-12"));
}

// Cuts `text` at the first `mark` and returns the rest; none without a mark.
std::optional<std::string_view> cut(std::string_view& text, char mark) {
  const std::size_t at = text.find(mark);
  if (at == std::string_view::npos) {
    return std::nullopt;
  }
  const std::string_view rest = text.substr(at + 1);
  text = text.substr(0, at);
  return rest;
}

std::optional<double> finite(std::string_view text) {
  const std::optional<double> value = parse_double(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

Result<Fault> parse_fault(std::string_view part) {
  std::string_view rest = part;
  const auto value = cut(rest, ':');
  const auto percent = cut(rest, '%');
  std::string_view name = rest;
  std::optional<std::string_view> frames = cut(name, '@');
  const auto known = std::find_if(kKnown.begin(), kKnown.end(), [&](const Known& k) { return k.name == name; });
  if (known == kKnown.end()) {
    return refused(part, concat("no kind '", name, "' (", listed(kNames, kNames.size()), ")",
                                did_you_mean(name, fault_kind_names())));
  }
  if (!frames) {
    return refused(part, "no frame");
  }
  const auto last_text = cut(*frames, '-');
  const auto first = parse_integer(*frames);
  const auto last = last_text ? parse_integer(*last_text) : first;
  if (!first || !last || *first < 0 || *last < *first) {
    return refused(part, "the frames must be whole numbers from 0, the first not after the last");
  }
  const auto chance = percent ? finite(*percent) : 100.0;
  if (!chance || *chance < 0.0 || *chance > 100.0) {
    return refused(part, "the percentage must be in [0, 100]");
  }
  const auto amount = value ? finite(*value) : known->default_value;
  if (!amount || *amount < known->lowest || *amount > known->highest) {
    return refused(part, known->lowest == known->highest ? "this kind takes no value"
                                                         : concat("the value must be in [", number(known->lowest), ", ",
                                                                  number(known->highest), "]"));
  }
  return Fault{known->kind, *first, *last, *chance / 100.0, *amount};
}

}  // namespace

std::span<const std::string_view> fault_kind_names() noexcept {
  return kNames;
}

Result<FaultPlan> parse_faults(std::string_view text) {
  constexpr std::string_view kSeed = "seed=";
  FaultPlan plan;
  std::optional<std::string_view> rest = text;
  while (rest) {
    std::string_view part = *rest;
    rest = cut(part, ',');
    if (part.starts_with(kSeed)) {
      const auto seed = parse_integer(part.substr(kSeed.size()));
      if (!seed || *seed < 0) {
        return refused(part, "the seed must be a whole number from 0");
      }
      plan.seed = static_cast<std::uint64_t>(*seed);
      continue;
    }
    const Result<Fault> fault = parse_fault(part);
    if (!fault) {
      return Unexpected(fault.error());
    }
    plan.faults.push_back(*fault);
  }
  return plan;
}

}  // namespace kinetrace::hal
