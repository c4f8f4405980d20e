// Publishing in a program built with DDS.
#include "cli/messages.hpp"
#include "dds/publish_config_file.hpp"
#include "dds/publishing_thread.hpp"
#include "dds/run_publishing.hpp"

namespace kinetrace::app {
namespace {

class DdsSetup final : public PublishingSetup {
 public:
  explicit DdsSetup(publishing::PublishConfig config) : config_(std::move(config)) {}

  [[nodiscard]] MemoryPlanEntry plan() const override {
    return {"publishing", PublishingThread::required_bytes(config_),
            "dds.max_points, dds.trajectory_queue, dds.piece_bytes, tracking.max_objects"};
  }
  [[nodiscard]] std::size_t library_bytes() const override { return publishing::Publisher::participant_bytes(config_); }
  [[nodiscard]] ConfigFields fields() override { return fields_of(config_); }
  [[nodiscard]] Outcome<std::unique_ptr<RunPublishing>> start(const StereoGeometry& geometry,
                                                              Arena& arena) const override {
    auto thread = PublishingThread::create(
        config_, geometry, [](const std::string& line) { print_warning(line); }, arena);
    if (!thread) {
      return failure(thread.error());
    }
    return std::move(*thread);
  }

 private:
  publishing::PublishConfig config_;
};

}  // namespace

Outcome<std::unique_ptr<PublishingSetup>> publishing_setup(const std::string& file, int max_objects) {
  Result<publishing::PublishConfig> config = load_publish_config(file);
  if (!config) {
    return failure(config.error());
  }
  config->max_objects = max_objects;
  return std::make_unique<DdsSetup>(std::move(*config));
}

}  // namespace kinetrace::app
