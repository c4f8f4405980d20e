// Default frame and object of a figure.
#pragma once

#include <cstdint>
#include <optional>

#include "figure/figure_run.hpp"

namespace kinetrace::figure {

/// The frame that shows most of the objects: the sum over its objects of the height in pixels, counted fully for moving
/// objects that are tracked and lie wholly in the picture, half if they are cut off by its edge, a tenth for other
/// tracked ones. Ties: the first. The middle frame of a run without tracked objects. `width_px` and `height_px`: size
/// of the image; zero if unknown.
[[nodiscard]] std::int64_t choose_frame(const FigureRun& run, int width_px, int height_px);

/// The tracked frame in which this track is tallest; its first frame if it is never tracked. `track` must have rows.
[[nodiscard]] std::int64_t choose_frame_of(const TrackRows& track);

/// The object whose reconstruction is shown: the tracked object of the frame with the largest product of height in
/// pixels and root of (its points times its tracked frames), weighted as above. Without one in the frame, the object
/// with most tracked frames in the run; none if no object was ever tracked.
[[nodiscard]] std::optional<std::uint32_t> choose_object(const FigureRun& run, std::int64_t frame, int width_px,
                                                         int height_px);

}  // namespace kinetrace::figure
