// Defaults of a figure: the frame and the object that it shows.
#pragma once

#include <cstdint>
#include <optional>

#include "figure/figure_run.hpp"

namespace kinetrace::figure {

/// The frame that shows most of the objects: the sum over its objects of the height in pixels, counted fully for moving
/// objects that are tracked and lie wholly in the picture, half if they are cut off by its edge, a tenth for other
/// tracked ones. The first of equals; the middle frame of a run without tracked objects. `width_px` and `height_px` are
/// the picture's; zero if they are not known.
[[nodiscard]] std::int64_t choose_frame(const FigureRun& run, int width_px, int height_px);

/// The frame in which this track, tracked, is tallest; its first frame if it never is. `track` has rows.
[[nodiscard]] std::int64_t choose_frame_of(const TrackRows& track);

/// The object of the frame to show the reconstruction of: of those that are tracked the one with the largest product of
/// height in pixels and root of (its points times the frames in which it was tracked), weighted as above. If there is
/// none in the frame, the object with most tracked frames in the run; none if nothing was ever tracked.
[[nodiscard]] std::optional<std::uint32_t> choose_object(const FigureRun& run, std::int64_t frame, int width_px,
                                                         int height_px);

}  // namespace kinetrace::figure
