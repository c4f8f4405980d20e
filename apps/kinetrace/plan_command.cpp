#include <cstdio>
#include <memory>
#include <utility>

#include "app_config.hpp"
#include "commands.hpp"
#include "memory.hpp"
#include "messages.hpp"

namespace kinetrace::app {
namespace {

// A raw recording of the given size, as the most demanding kind: it has to be rectified.
hal::Dataset raw_recording(int width_px, int height_px) {
  hal::Dataset dataset;
  hal::CameraModel eye;
  eye.width_px = width_px;
  eye.height_px = height_px;
  eye.fx_px = 0.6 * width_px;
  eye.fy_px = eye.fx_px;
  eye.cx_px = 0.5 * (width_px - 1);
  eye.cy_px = 0.5 * (height_px - 1);
  eye.distortion[0] = -0.1;  // Without any, there would be nothing to rectify.
  dataset.calibration.source = "kinetrace plan";
  dataset.calibration.left = eye;
  dataset.calibration.right = eye;
  dataset.calibration.T_right_left.translation = {-0.5, 0.0, 0.0};
  // An uncompressed image.
  dataset.max_file_bytes = static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px);
  return dataset;
}

void print_line(const char* name, double bytes, const char* depends_on) {
  std::printf("%-20s %10.3f  %s\n", name, bytes / (1024.0 * 1024.0), depends_on);
}

void print_plan(const MemoryPlan& plan, const pipeline::MemoryConfig& memory, const PublishingSetup* publishing,
                const PlanOptions& options) {
  constexpr double kMib = 1024.0 * 1024.0;
  std::printf("Memory for raw images of %dx%d pixels\n\n%-20s %10s  %s\n", options.width_px, options.height_px, "part",
              "MiB", "size depends on");
  for (const MemoryPlanEntry& entry : plan.entries) {
    print_line(entry.name.c_str(), static_cast<double>(entry.bytes), entry.depends_on.c_str());
  }
  print_line("libraries", memory.libraries_mib * kMib, "memory.libraries_mib");
  if (publishing != nullptr) {
    print_line("DDS participant", static_cast<double>(publishing->library_bytes()), "dds.security.mode");
  }
  print_line("total", static_cast<double>(plan.total_bytes() + library_bytes(memory, publishing)), "");
  print_line("budget", memory.budget_mib * kMib, "memory.budget_mib");
}

}  // namespace

int plan_command(const PlanOptions& options) {
  const Result<AppConfig> config = load_config(options.config);
  if (!config) {
    return report(to_failure(config.error()));
  }
  std::unique_ptr<PublishingSetup> publishing;
  if (!options.publish.empty()) {
    auto setup = publishing_setup(options.publish, config->pipeline.tracking.max_objects);
    if (!setup) {
      return report(setup.error());
    }
    publishing = std::move(*setup);
  }
  const Result<MemoryPlan> plan =
      plan_memory(*config, recording_setup(raw_recording(options.width_px, options.height_px)), {}, publishing.get());
  if (!plan) {
    return report(to_failure(plan.error()));
  }
  print_plan(*plan, config->pipeline.memory, publishing.get(), options);
  const Status fits = check_budget(*plan, config->pipeline.memory, publishing.get());
  return fits ? 0 : report(to_failure(fits.error()));
}

}  // namespace kinetrace::app
