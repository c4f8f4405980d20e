#include "candidates.hpp"

#include <algorithm>
#include <cmath>

namespace kinetrace::neural {
namespace {

// Descending score; ties by position, for deterministic results.
bool is_stronger(const Candidate& a, const Candidate& b) noexcept {
  return a.score != b.score ? a.score > b.score : std::pair(a.box.y0, a.box.x0) < std::pair(b.box.y0, b.box.x0);
}

}  // namespace

float overlap(const Box& a, const Box& b) noexcept {
  const Box shared{std::max(a.x0, b.x0), std::max(a.y0, b.y0), std::min(a.x1, b.x1), std::min(a.y1, b.y1)};
  const float both = shared.area();
  return both > 0.F ? both / (a.area() + b.area() - both) : 0.F;
}

void CandidateList::add(const Candidate& candidate) noexcept {
  const Box& box = candidate.box;
  if (!std::isfinite(candidate.score) || !std::isfinite(box.area()) || box.area() <= 0.F) {
    return;
  }
  if (candidates_.full()) {
    ++dropped_;
    if (candidates_.capacity() == 0 || !is_stronger(candidate, *candidates_.begin())) {
      return;
    }
    std::pop_heap(candidates_.begin(), candidates_.end(), is_stronger);
    candidates_.pop_back();
  }
  static_cast<void>(candidates_.push_back(candidate));
  std::push_heap(candidates_.begin(), candidates_.end(), is_stronger);
}

void CandidateList::suppress(float max_overlap) noexcept {
  std::sort(candidates_.begin(), candidates_.end(), is_stronger);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    const Candidate candidate = candidates_[i];
    const bool is_beaten = std::any_of(candidates_.begin(), candidates_.begin() + kept, [&](const Candidate& stronger) {
      return stronger.class_index == candidate.class_index && overlap(stronger.box, candidate.box) > max_overlap;
    });
    if (!is_beaten) {
      candidates_[kept++] = candidate;
    }
  }
  candidates_.resize(kept);
}

}  // namespace kinetrace::neural
