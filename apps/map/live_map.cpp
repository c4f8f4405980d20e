#include "live_map.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include "alignment_thread.hpp"
#include "cli/interrupt.hpp"
#include "cli/messages.hpp"
#include "dds/dds_link.hpp"
#include "kinetrace/publishing/fix_exchange.hpp"
#include "kinetrace/publishing/result_reader.hpp"
#include "live_alignment.hpp"
#include "map_report.hpp"
#include "reference_arguments.hpp"

namespace kinetrace::map {
namespace {

using app::ExitCode;
using app::Failure;
using app::failure;
using app::MapOptions;
using app::Outcome;
using publishing::NavSatFix;

constexpr std::int64_t kSecond_ns = 1'000'000'000;

bool has_place(BodyStatus status) noexcept {
  return status != BodyStatus::kLost && status != BodyStatus::kInitializing;
}

/// Data from the network may be invalid.
bool is_plausible(const publishing::ReceivedCamera& received) noexcept {
  constexpr std::int64_t kFarthest_ns = 4'000'000'000'000'000'000;  // 126 years.
  const auto is_time = [](std::int64_t time_ns) { return time_ns > -kFarthest_ns && time_ns < kFarthest_ns; };
  return is_time(received.timestamp_ns) && is_time(received.handed_over_ns) &&
         is_time(received.handed_over_ns - received.timestamp_ns) && received.camera.T_world_cam.is_finite();
}

NavSatFix fix_at(const MapPlace& place, std::int64_t stamp_ns) {
  return {.stamp_ns = stamp_ns,
          .frame = "",
          .has_fix = true,
          .latitude_deg = place.geodetic.latitude_deg,
          .longitude_deg = place.geodetic.longitude_deg,
          .height_m = place.geodetic.height_m,
          .covariance_known = true,
          .covariance_m2 = place.covariance_m2};
}

/// Receives results, publishes positions on the map.
class Follower final : public publishing::ResultListener {
 public:
  Follower(LiveAlignment& alignment, publishing::MapSender& sender, const publishing::PublishConfig& config)
      : alignment_(alignment), sender_(sender), config_(config) {}

  void receive(const publishing::ReceivedCamera& received) override {
    if (received.device != config_.device || !is_plausible(received)) {
      return;
    }
    // The run's own stamps, so that tf can connect both.
    latency_ns_ =
        config_.ros2.stamps == publishing::RosStamps::kSystem ? received.handed_over_ns - received.timestamp_ns : 0;
    if (!has_place(received.camera.status)) {
      alignment_.lose_camera();
      return;
    }
    const Se3& T_world_cam = received.camera.T_world_cam;
    alignment_.add_pose(received.frame_index, received.timestamp_ns, received.handed_over_ns, T_world_cam);
    if (alignment_.is_aligned()) {
      const std::int64_t stamp_ns = received.timestamp_ns + latency_ns_;
      sender_.send_transform(stamp_ns, alignment_.aligned().T_map_world);
      sender_.send_camera(fix_at(alignment_.place(T_world_cam.translation), stamp_ns));
    }
  }
  void receive(const publishing::ReceivedObjects& received) override {
    if (received.device != config_.device || !alignment_.is_aligned()) {
      return;
    }
    for (const ObjectResult& object : received.objects) {
      if (has_place(object.status) && object.box.center_m.allFinite() && object.box_sigma.center_m.allFinite()) {
        send(object, received.timestamp_ns + latency_ns_);
      }
    }
  }
  void receive(const publishing::ReceivedHealth& /*health*/) override {}
  void receive(const publishing::ReceivedCalibration& /*calibration*/) override {}

 private:
  void send(const ObjectResult& object, std::int64_t stamp_ns) {
    MapPlace place = alignment_.place(object.box.center_m);
    const Eigen::Matrix3d axes = alignment_.aligned().T_map_world.rotation * object.box.rotation();
    place.covariance_m2 += axes * object.box_sigma.center_m.cwiseAbs2().asDiagonal() * axes.transpose();
    sender_.send_object(object.track_id, fix_at(place, stamp_ns));
  }

  LiveAlignment& alignment_;
  publishing::MapSender& sender_;
  const publishing::PublishConfig& config_;
  std::int64_t latency_ns_ = 0;
};

[[nodiscard]] Status take_fix(const NavSatFix& fix, LiveAlignment& alignment) {
  if (!fix.has_fix) {
    alignment.count_without_fix();
    return {};
  }
  const Eigen::Vector3d sigma_m =
      fix.covariance_known ? fix.covariance_m2.diagonal().cwiseSqrt().eval() : Eigen::Vector3d::Ones().eval();
  return alignment.add_fix(fix.stamp_ns, {fix.latitude_deg, fix.longitude_deg, fix.height_m}, sigma_m);
}

/// Prints changes, or each alignment as JSON.
class Display {
 public:
  Display(const MapOptions& options, const LiveAlignment& alignment) : options_(options), alignment_(alignment) {}

  void show_task(const AlignmentTask& task, const std::string& device) const {
    if (!options_.json || options_.quiet || !alignment_.newest()) {
      return;
    }
    const geo::Reference reference{*alignment_.frame(), task.fixes, alignment_.counts(), {}};
    print(report_json(
        {device, "navsatfix", live_topic(options_.reference), reference, task.config, *alignment_.newest()}, -1));
  }
  void show_state() {
    if (options_.json || options_.quiet) {
      return;
    }
    const std::string reason = alignment_.reason();
    // Compares the text's beginning only, as its numbers change with each alignment.
    const std::string kind = (alignment_.is_aligned() ? "aligned" : "waiting") + reason.substr(0, 20);
    if (kind != shown_) {
      shown_ = kind;
      print(text(reason) + '\n');
    }
  }

 private:
  static void print(const std::string& text) {
    std::fwrite(text.data(), 1, text.size(), stdout);
    std::fflush(stdout);
  }
  [[nodiscard]] std::string text(const std::string& reason) const {
    if (!alignment_.is_aligned()) {
      return "not aligned, nothing is published: " + reason;
    }
    if (!reason.empty()) {
      return "aligned by an earlier stretch, which holds; of the newest: " + reason;
    }
    const geo::Alignment& now = alignment_.aligned();
    char line[160];
    std::snprintf(line, sizeof line, "aligned: %lld of %lld fixes agree; sigma %.2f m; offset of the clocks %+.3f s",
                  static_cast<long long>(now.inliers), static_cast<long long>(now.fixes),
                  alignment_.horizontal_sigma_m(), now.time_offset_s);
    return line;
  }

  const MapOptions& options_;
  const LiveAlignment& alignment_;
  std::string shown_;
};

class LiveMap {
 public:
  LiveMap(const MapOptions& options, const publishing::PublishConfig& config, publishing::Link& link,
          LiveAlignment alignment)
      : options_(options),
        config_(config),
        link_(link),
        alignment_(std::move(alignment)),
        reader_(link),
        fixes_(link, live_topic(options.reference)),
        sender_(link, config),
        follower_(alignment_, sender_, config_),
        display_(options, alignment_),
        thread_([&link] { link.wake(); }) {}

  Outcome<int> run() {
    begin_ns_ = app::steady_time_ns();
    while (!is_over()) {
      if (const Status served = serve(); !served) {
        return failure(served.error());
      }
      app::serve(link_);
    }
    return outcome();
  }

 private:
  [[nodiscard]] Status serve() {
    const std::int64_t now_ns = app::steady_time_ns();
    if (Status ready = sender_.supervise(now_ns); !ready) {
      return ready;
    }
    Status usable;
    const auto take = [&](const NavSatFix& fix) { usable = usable ? take_fix(fix, alignment_) : usable; };
    if (Status taken = fixes_.take(take); !taken) {
      return taken;
    }
    if (!usable) {
      return usable;
    }
    if (Status taken = reader_.take(follower_); !taken) {
      return taken;
    }
    if (Status aligned = align(now_ns); !aligned) {
      return aligned;
    }
    report_state(now_ns);
    return {};
  }

  [[nodiscard]] Status align(std::int64_t now_ns) {
    if (const auto done = thread_.collect()) {
      if (!*done) {
        return Unexpected(done->error());
      }
      alignment_.accept(thread_.task(), **done);
      has_aligned_ = has_aligned_ || alignment_.is_aligned();
      // A quarter of one processor at most.
      next_task_ns_ = std::max(next_task_ns_, now_ns + 3 * thread_.took_ns());
      display_.show_task(thread_.task(), config_.device);
    }
    AlignmentTask* task = now_ns >= next_task_ns_ && alignment_.has_new_fixes() ? thread_.idle_task() : nullptr;
    if (task != nullptr) {
      constexpr std::int64_t kEvery_ns = kSecond_ns / 2;
      next_task_ns_ = now_ns + kEvery_ns;
      alignment_.fill(*task);
      thread_.begin();
    }
    return {};
  }

  void report_state(std::int64_t now_ns) {
    constexpr std::int64_t kFirstAlignmentTimeout_ns = 3 * kSecond_ns;
    if (alignment_.newest() || now_ns - begin_ns_ > kFirstAlignmentTimeout_ns) {
      display_.show_state();
    }
    if (now_ns < next_diagnostics_ns_) {
      return;
    }
    next_diagnostics_ns_ = now_ns + kSecond_ns;
    const std::string reason = alignment_.reason();
    publishing::MapDiagnostics diagnostics{.is_aligned = alignment_.is_aligned(),
                                           .message = reason.empty() ? "aligned" : std::string_view(reason)};
    if (alignment_.newest()) {
      diagnostics.fixes = alignment_.newest()->fixes;
      diagnostics.inliers = alignment_.newest()->inliers;
    }
    diagnostics.position_sigma_m = alignment_.is_aligned() ? alignment_.horizontal_sigma_m() : 0.0;
    sender_.send(diagnostics, app::system_time_ns());
  }

  [[nodiscard]] bool is_over() const {
    const double seconds = static_cast<double>(app::steady_time_ns() - begin_ns_) * 1e-9;
    // The reader of standard output may have closed it.
    return app::interrupted_by() != 0 || std::ferror(stdout) != 0 ||
           (options_.seconds > 0.0 && seconds >= options_.seconds);
  }

  [[nodiscard]] Outcome<int> outcome() const {
    if (has_aligned_) {
      return 0;
    }
    if (alignment_.has_poses() && alignment_.has_fixes()) {
      return Unexpected(Failure{ExitCode::kBadData, "not aligned: " + alignment_.reason()});
    }
    return Unexpected(
        Failure{ExitCode::kIo, "not aligned: " + alignment_.reason() + "; is `kinetrace run --publish` at work as " +
                                   config_.device + " in domain " + std::to_string(config_.domain) + " on " +
                                   config_.interface + ", and a receiver on " + live_topic(options_.reference) + '?'});
  }

  const MapOptions& options_;
  const publishing::PublishConfig& config_;
  publishing::Link& link_;
  LiveAlignment alignment_;
  publishing::ResultReader reader_;
  publishing::FixReader fixes_;
  publishing::MapSender sender_;
  Follower follower_;
  Display display_;
  AlignmentThread thread_;
  std::int64_t begin_ns_ = 0;
  std::int64_t next_task_ns_ = 0;
  std::int64_t next_diagnostics_ns_ = 0;
  bool has_aligned_ = false;
};

Status check(const MapOptions& options) {
  if (!options.run.empty() || !options.out.empty()) {
    return fail(ErrorCode::kInvalidArgument,
                "--reference navsatfix follows a run in progress: leave out the run folder and --out");
  }
  const std::string topic = live_topic(options.reference);
  const bool is_name =
      topic.size() > 1 && topic.front() == '/' && topic.back() != '/' &&
      topic.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_/") == std::string::npos;
  return is_name ? Status{}
                 : fail(ErrorCode::kInvalidArgument,
                        "--reference: expected navsatfix:TOPIC with a topic of ROS 2 such as /fix, got " +
                            options.reference.source);
}

Outcome<LiveAlignment> make_alignment(const MapOptions& options) {
  const Outcome<geo::AlignmentConfig> config = parse_config(options.reference);
  if (!config) {
    return Unexpected(config.error());
  }
  const auto origin = parse_origin(options.reference);
  if (!origin) {
    return Unexpected(origin.error());
  }
  std::optional<geo::LocalFrame> frame;
  if (*origin) {
    Result<geo::LocalFrame> made = geo::LocalFrame::at(**origin);
    if (!made) {
      return failure(made.error());
    }
    frame = std::move(*made);
  }
  Result<geo::AlignmentWindow> window = geo::AlignmentWindow::create({});
  if (!window) {
    return failure(window.error());
  }
  return LiveAlignment(std::move(*window), *config, std::move(frame), options.reference.time_offset_s.has_value());
}

}  // namespace

Outcome<int> follow_run(const MapOptions& options) {
  if (const Status valid = check(options); !valid) {
    return failure(valid.error());
  }
  Outcome<LiveAlignment> alignment = make_alignment(options);
  if (!alignment) {
    return Unexpected(alignment.error());
  }
  app::NetworkOptions network;
  network.file = options.publish;
  const Result<publishing::PublishConfig> config = app::network_config(network);
  if (!config) {
    return failure(config.error());
  }
  if (!config->native || !config->ros2.enabled) {
    return Unexpected(Failure{ExitCode::kConfig,
                              options.publish + ": dds.native and dds.ros2.enabled are both needed for --reference "
                                                "navsatfix; leave them on"});
  }
  const auto link = publishing::Link::create(*config);
  if (!link) {
    return failure(link.error());
  }
  app::catch_interrupts();
  return LiveMap(options, *config, **link, std::move(*alignment)).run();
}

}  // namespace kinetrace::map
