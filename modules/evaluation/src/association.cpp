#include "association.hpp"

#include <algorithm>

#include "kinetrace/evaluation/matching.hpp"

namespace kinetrace::evaluation {
namespace {

using TrackOfObject = std::map<std::uint32_t, std::uint32_t>;

std::optional<std::size_t> index_of(const ObjectFrame& frame, std::uint32_t track_id) {
  const auto found = std::find_if(frame.tracks.begin(), frame.tracks.end(),
                                  [&](const TrackInFrame& track) { return track.track_id == track_id; });
  return found == frame.tracks.end() ? std::nullopt
                                     : std::optional(static_cast<std::size_t>(found - frame.tracks.begin()));
}

// Weights with which a pair of the previous frame outweighs any other choice for its row or column.
Eigen::MatrixXd weights_of(const ObjectFrame& frame, const TrackOfObject& before, double min_similarity) {
  constexpr double kStay = 1000.0;
  Eigen::MatrixXd weights = frame.similarity;
  for (Eigen::Index row = 0; row < weights.rows(); ++row) {
    const auto last = before.find(frame.truth[static_cast<std::size_t>(row)].id);
    for (Eigen::Index column = 0; column < weights.cols(); ++column) {
      double& weight = weights(row, column);
      if (weight < min_similarity) {
        weight = 0.0;
      } else if (last != before.end() && last->second == frame.tracks[static_cast<std::size_t>(column)].track_id) {
        weight += kStay;
      }
    }
  }
  return weights;
}

}  // namespace

std::vector<FrameAssociation> associate(std::span<const ObjectFrame> frames, double min_similarity) {
  std::vector<FrameAssociation> associations;
  TrackOfObject before;      // In the previous frame.
  TrackOfObject last_known;  // In any frame so far.
  for (const ObjectFrame& frame : frames) {
    const std::vector<int> columns = best_matching(weights_of(frame, before, min_similarity));
    FrameAssociation association;
    association.matched.resize(frame.truth.size());
    before.clear();
    std::vector<bool> taken(frame.tracks.size(), false);
    for (std::size_t object = 0; object < frame.truth.size(); ++object) {
      if (columns[object] >= 0) {
        const auto track = static_cast<std::size_t>(columns[object]);
        association.matched[object] = track;
        taken[track] = true;
        before[frame.truth[object].id] = frame.tracks[track].track_id;
      }
    }
    association.followed = association.matched;
    for (std::size_t object = 0; object < frame.truth.size(); ++object) {
      const auto last = last_known.find(frame.truth[object].id);
      if (association.matched[object] || last == last_known.end()) {
        continue;
      }
      const std::optional<std::size_t> track = index_of(frame, last->second);
      if (track && !taken[*track]) {
        association.followed[object] = track;
        taken[*track] = true;
      }
    }
    for (const auto& [object_id, track_id] : before) {
      last_known[object_id] = track_id;
    }
    associations.push_back(std::move(association));
  }
  return associations;
}

}  // namespace kinetrace::evaluation
