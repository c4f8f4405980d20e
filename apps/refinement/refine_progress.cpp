#include "refine_progress.hpp"

#include <algorithm>
#include <cstdio>

namespace kinetrace::batch {
namespace {

// Seconds per row: of measuring again, of refining the camera, of the loop search, of refining an object, and of
// writing; only their ratios matter.
constexpr double kMeasuredRow_s = 0.05;
constexpr double kCameraRow_s = 0.04;
constexpr double kLoopRow_s = 0.02;
constexpr double kObjectRow_s = 0.005;
constexpr double kWrittenRow_s = 0.004;

}  // namespace

RefineProgress::RefineProgress(bool enabled, std::size_t rows, std::size_t object_rows)
    : line_(enabled), rows_(static_cast<double>(rows)), object_rows_(static_cast<double>(object_rows)) {}

void RefineProgress::measured(std::size_t rows_done) {
  show("images", static_cast<double>(rows_done) * kMeasuredRow_s);
}

void RefineProgress::camera(std::size_t rows_done) {
  show("camera", rows_ * kMeasuredRow_s + static_cast<double>(rows_done) * kCameraRow_s);
}

void RefineProgress::loops(double part) {
  show("loops", rows_ * (kMeasuredRow_s + kCameraRow_s + part * kLoopRow_s));
}

void RefineProgress::objects(std::size_t rows_done) {
  show("objects", rows_ * (kMeasuredRow_s + kCameraRow_s + kLoopRow_s) + static_cast<double>(rows_done) * kObjectRow_s);
}

void RefineProgress::written(std::size_t rows_done) {
  show("writing", rows_ * (kMeasuredRow_s + kCameraRow_s + kLoopRow_s) + object_rows_ * kObjectRow_s +
                      static_cast<double>(rows_done) * kWrittenRow_s);
}

void RefineProgress::show(const char* doing, double part) {
  if (!line_.is_due()) {
    return;
  }
  const double whole =
      rows_ * (kMeasuredRow_s + kCameraRow_s + kLoopRow_s + kWrittenRow_s) + object_rows_ * kObjectRow_s;
  const double done = whole > 0.0 ? std::clamp(part / whole, 1e-3, 1.0) : 1.0;
  const int left_s = static_cast<int>(line_.elapsed_s() * (1.0 - done) / done);
  std::fprintf(stderr, "\r%-8s %3d %%, %d:%02d left \033[K", doing, static_cast<int>(100.0 * done), left_s / 60,
               left_s % 60);
}

}  // namespace kinetrace::batch
