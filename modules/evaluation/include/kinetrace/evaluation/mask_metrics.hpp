// Multi-object tracking and segmentation against truth: HOTA and (s)MOTSA, as TrackEval computes them for KITTI MOTS.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>

#include "kinetrace/core/result.hpp"
#include "kinetrace/evaluation/mask_overlap.hpp"

namespace kinetrace::evaluation {

inline constexpr std::size_t kHotaThresholds = 19;  ///< Intersection over union 0.05, 0.10, ..., 0.95.

/// One threshold of HOTA (Luiten et al., IJCV 2021). All values in [0, 1], except counts of masks.
struct HotaAtThreshold {
  double tp = 0.0;
  double fn = 0.0;
  double fp = 0.0;
  double assa = 0.0;   ///< Association accuracy, eq. 16: mean over true positives of TPA / (TPA + FNA + FPA).
  double assre = 0.0;  ///< ... of TPA / (TPA + FNA).
  double asspr = 0.0;  ///< ... of TPA / (TPA + FPA).
  double loca = 1.0;   ///< Mean intersection over union of the true positives; 1 without any.

  [[nodiscard]] double deta() const noexcept;  ///< Detection accuracy, eq. 15: TP / (TP + FN + FP).
  [[nodiscard]] double detre() const noexcept;
  [[nodiscard]] double detpr() const noexcept;
  [[nodiscard]] double hota() const noexcept;  ///< Geometric mean of detection and association accuracy.
};

/// Means over the thresholds.
struct HotaScores {
  std::array<HotaAtThreshold, kHotaThresholds> thresholds{};

  [[nodiscard]] double hota() const noexcept;
  [[nodiscard]] double deta() const noexcept;
  [[nodiscard]] double assa() const noexcept;
  [[nodiscard]] double loca() const noexcept;
  [[nodiscard]] double detre() const noexcept;
  [[nodiscard]] double detpr() const noexcept;
  [[nodiscard]] double assre() const noexcept;
  [[nodiscard]] double asspr() const noexcept;
};

/// Masks matched at an intersection over union of 0.5 (Voigtlaender et al., CVPR 2019, section 5).
struct MotsScores {
  std::int64_t tp = 0;
  std::int64_t fn = 0;
  std::int64_t fp = 0;
  std::int64_t id_switches = 0;  ///< Matched to another track than when the object was matched last.
  double soft_tp = 0.0;          ///< Sum of the intersections over union of the true positives.

  [[nodiscard]] bool has_truth() const noexcept { return tp + fn > 0; }  ///< Without true masks, MOTSA is undefined.
  [[nodiscard]] double motsa() const noexcept;   ///< (TP - FP - IDS) / (TP + FN), at most 1, may be negative.
  [[nodiscard]] double smotsa() const noexcept;  ///< The same with the soft TP in the numerator.
  [[nodiscard]] double motsp() const noexcept;   ///< Soft TP / TP; 0 without any.
};

struct MaskScores {
  HotaScores hota;
  MotsScores mots;
};

struct MaskReport {
  /// The result's masks have no class (regions found by motion): they are scored regardless of class.
  bool is_classless = false;
  std::map<std::uint16_t, MaskScores> classes;  ///< Each class against itself alone; none if classless.
  MaskScores combined;   ///< The classes together, each by its number of masks (TrackEval's cls_comb_det_av); if
                         ///< classless, any_class.
  MaskScores any_class;  ///< Classes disregarded.
};

/// Takes a sequence frame by frame. First, per class, removes result masks that match no true mask (at 0.5) and lie by
/// more than half within the ignore region. HOTA's global alignment needs the whole sequence: until `report`, the ids
/// of each frame and the non-zero overlaps are kept, some dozen bytes a mask.
class MaskMetrics {
 public:
  MaskMetrics();
  MaskMetrics(MaskMetrics&&) noexcept;
  MaskMetrics& operator=(MaskMetrics&&) noexcept;
  ~MaskMetrics();

  /// Adds the next frame; without result masks, all true masks count as missed. Errors: those of overlap_masks; the
  /// frame is then not counted.
  [[nodiscard]] Status add(const InstanceMasks& truth, const InstanceMasks& result);

  [[nodiscard]] MaskReport report() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace kinetrace::evaluation
