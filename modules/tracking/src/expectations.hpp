// When what was expected of a track says something about what is seen.
#pragma once

namespace kinetrace::tracking {

/// Features of a track that has not been detected for so long lie on what hides it, or on nothing.
inline constexpr int kForeignAfterFrames = 2;

/// Nearer things have no size in the image that a similarity could carry.
inline constexpr double kMinForecastDepth_m = 0.2;

/// A mask of which less than this is in the image is not replaced by what is left of it, as long as it is still found
/// where it is expected.
inline constexpr double kWholeInImage = 0.99;

/// Less than this part of a mask in sight is not enough to be detected.
inline constexpr double kLeastVisiblePart = 0.3;

}  // namespace kinetrace::tracking
