// Progress line with the remaining time.
#pragma once

#include <cstddef>

#include "cli/progress.hpp"

namespace kinetrace::batch {

class RefineProgress {
 public:
  RefineProgress(bool enabled, std::size_t rows, std::size_t object_rows);

  void measured(std::size_t rows_done);
  void camera(std::size_t rows_done);
  void loops(double part);
  void objects(std::size_t rows_done);
  void written(std::size_t rows_done);
  void clear() { line_.clear(); }

 private:
  void show(const char* doing, double part);

  app::RedrawnLine line_;
  double rows_;
  double object_rows_;
};

}  // namespace kinetrace::batch
