#include "frame_intake.hpp"

#include <string>

namespace kinetrace::pipeline {

Status FrameIntake::check(const RectifiedPair& pair) const {
  for (const GrayView& view : {pair.left, pair.right}) {
    if (view.empty() || view.width != geometry_.width_px || view.height != geometry_.height_px) {
      return fail(ErrorCode::kInvalidArgument, "frame " + std::to_string(pair.frame_index) + " has an image of " +
                                                   std::to_string(view.width) + "x" + std::to_string(view.height) +
                                                   ", the pipeline was made for " + std::to_string(geometry_.width_px) +
                                                   "x" + std::to_string(geometry_.height_px));
    }
  }
  if (frames_ > 0 && pair.timestamp_ns <= last_timestamp_ns_) {
    return fail(ErrorCode::kInvalidArgument,
                "frame " + std::to_string(pair.frame_index) +
                    " is not later than the frame before it; give frames in order of time");
  }
  if (closed_) {
    return fail(ErrorCode::kIllegalState, "the pipeline has been drained; make a new one for another sequence");
  }
  return {};
}

}  // namespace kinetrace::pipeline
