#include "translation_consensus.hpp"

#include <algorithm>

namespace kinetrace::pipeline {
namespace {

bool compete(const AppearanceMatch& a, const AppearanceMatch& b) {
  return a.feature_slot == b.feature_slot || a.point == b.point;
}

TranslationConsensus group_around(const Eigen::Vector3d& centre_m, std::span<const AppearanceMatch> matches,
                                  double radius_m) {
  const auto off_m = [&](std::size_t i) { return (matches[i].shift_m - centre_m).norm(); };
  TranslationConsensus group;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    if (off_m(i) > radius_m) {
      continue;
    }
    const auto members = std::span(group.members).first(group.count);
    const auto rival = [&](std::uint16_t k) { return compete(matches[k], matches[i]); };
    if (std::any_of(members.begin(), members.end(),
                    [&](std::uint16_t k) { return rival(k) && off_m(k) <= off_m(i); })) {
      continue;
    }
    const auto rest = std::remove_if(members.begin(), members.end(), rival);
    group.count = static_cast<std::size_t>(rest - members.begin());
    group.members[group.count++] = static_cast<std::uint16_t>(i);
  }
  return group;
}

}  // namespace

TranslationConsensus largest_group(std::span<const AppearanceMatch> matches, double max_shift_m, double radius_m) {
  const std::span<const AppearanceMatch> considered =
      matches.first(std::min(matches.size(), TranslationConsensus::kMaxMembers));
  TranslationConsensus largest;
  for (const AppearanceMatch& centre : considered) {
    if (centre.shift_m.norm() > max_shift_m) {
      continue;
    }
    const TranslationConsensus group = group_around(centre.shift_m, considered, radius_m);
    if (group.count > largest.count) {
      largest = group;
    }
  }
  return largest;
}

}  // namespace kinetrace::pipeline
