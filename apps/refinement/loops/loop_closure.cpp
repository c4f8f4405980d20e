#include "loop_closure.hpp"

#include "revisits.hpp"

namespace kinetrace::batch {

Result<std::vector<Loop>> find_loops(const recording::Run& run, std::span<const Se3> T_world_cam,
                                     std::span<const Keyframe> keyframes, const PairReader& read,
                                     const AdjustmentOptions& options, const std::function<void(double)>& progress) {
  const std::vector<std::vector<std::size_t>> revisits = find_revisits(keyframes, T_world_cam);
  PlaceMatcher matcher(run, T_world_cam, read, options);
  std::vector<Loop> loops;
  for (std::size_t now = 0; now < keyframes.size() && options.keep_going(); ++now) {
    if (revisits[now].empty()) {
      continue;
    }
    const Result<std::optional<Loop>> loop = matcher.match(keyframes, now, revisits[now]);
    if (!loop) {
      return Unexpected(loop.error());
    }
    if (*loop) {
      loops.push_back(**loop);
    }
    progress(static_cast<double>(now + 1) / static_cast<double>(keyframes.size()));
  }
  return loops;
}

}  // namespace kinetrace::batch
