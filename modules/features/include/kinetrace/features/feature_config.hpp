// Settings of the feature front end.
#pragma once

#include "kinetrace/core/export.hpp"
#include "kinetrace/core/result.hpp"

namespace kinetrace::features {

/// All settings of the feature front end. The patch is 16 x 11 pixels and fixed: the kernels are built for it.
struct KINETRACE_API FeatureConfig {
  // Capacities. Objects are served before the background; beyond, the weakest are dropped and counted.
  int max_features = 1600;            ///< Over all bodies; [50, 4000]. Number of slots.
  int max_background_features = 800;  ///< [0, 4000]: the rest is kept free for objects.
  int max_features_per_object = 120;  ///< [0, 4000].
  int pyramid_levels = 4;             ///< [1, 6], fewer on images too small for them.

  // Corners: at most one new feature per free bucket.
  int bucket_px = 24;               ///< Background, [8, 256].
  int object_bucket_px = 6;         ///< Objects, [4, 64].
  int min_distance_px = 5;          ///< Between a new corner and any live feature, [4, 64].
  float min_corner_strength = 6.F;  ///< Root of the smaller eigenvalue of the mean gradient matrix, gray per pixel,
                                    ///< > 0; a bucket without one stays empty.
  float min_object_corner_strength = 3.F;  ///< The same for objects, which may have faint texture; > 0.

  // Temporal tracking.
  float forward_backward_px = 0.7F;      ///< Largest distance after tracking there and back, > 0.
  float min_correlation = 0.8F;          ///< Zero-mean normalised correlation of a patch with its match, (0, 1).
  float max_residual = 3.F;              ///< ...or RMS gray difference after gain and offset below this: noise alone
                                         ///< spoils the correlation of faint texture. >= 0.
  float min_patch_strength = 1.5F;       ///< Like min_corner_strength, for a patch to be tracked at all; > 0.
  bool refine_against_reference = true;  ///< Align with the first patch, affinely warped, not only with the
                                         ///< previous frame: stops drift.

  // Left-right.
  int max_disparity_px = 192;         ///< [16, 256].
  float min_disparity_px = 0.5F;      ///< Smaller ones hold no depth; (0, 16].
  float max_row_difference_px = 3.F;  ///< Paper: three pixels; [0, 8].
  float uniqueness_ratio = 1.1F;      ///< Second-best cost over best cost, >= 1.

  float mask_border_px = 2.F;  ///< A feature this near a mask border keeps its body, [0, 16].

  /// kInvalidConfig naming the first key that is out of range.
  [[nodiscard]] Status validate() const;
};

}  // namespace kinetrace::features
