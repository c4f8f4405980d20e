// What the program can do; each returns the exit code for the shell.
#pragma once

#include "command_line.hpp"

namespace kinetrace::app {

/// Plays a recording or a camera through the whole chain into a run folder.
[[nodiscard]] int run_command(const RunOptions& options);

/// Records raw images.
[[nodiscard]] int record_command(const RecordOptions& options);

/// Looks for what is wrong with cameras, calibration and memory.
[[nodiscard]] int doctor_command(const DoctorOptions& options);

/// Prints the memory plan.
[[nodiscard]] int plan_command(const PlanOptions& options);

/// Times the stages on a recording.
[[nodiscard]] int bench_command(const BenchOptions& options);

/// Prints the configuration as commented YAML.
[[nodiscard]] int config_command(const ConfigOptions& options);

/// Compares a run with ground truth.
[[nodiscard]] int evaluate_command(const EvaluateOptions& options);

/// Measures how an object's reconstruction depends on its size in the image and on the frames it is made from.
[[nodiscard]] int study_command(const StudyOptions& options);

/// Shows what a running Kinetrace publishes, and records it.
[[nodiscard]] int monitor_command(const MonitorOptions& options);

/// Sends masks from files to a run that asks for them.
[[nodiscard]] int mask_command(const MaskOptions& options);

/// Tries a neural network on images.
[[nodiscard]] int segment_command(const SegmentOptions& options);

/// Prints what a run found.
[[nodiscard]] int summary_command(const SummaryOptions& options);

/// Draws the result figure of a run and, if asked for, every frame with what was found in it.
[[nodiscard]] int figure_command(const FigureOptions& options);

/// Makes keys, certificates and permissions for DDS Security.
[[nodiscard]] int keys_command(const KeysOptions& options);

}  // namespace kinetrace::app
