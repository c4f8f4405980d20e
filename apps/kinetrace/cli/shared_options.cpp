#include "cli/shared_options.hpp"

#include <CLI/CLI.hpp>

#include "cli/option_checks.hpp"

namespace kinetrace::app {

void add_config_options(CLI::App& command, ConfigSource& source) {
  command.add_option("--board", source.board, "Begins with the settings for a board: those in config/boards")
      ->type_name("NAME");
  command.add_option("--config", source.file, "YAML file; `kinetrace config` prints one with all keys")
      ->type_name("FILE");
  command.add_option("--set", source.settings, "Sets one key, after the file; may be repeated")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
}

void add_source_options(CLI::App& command, SourceOptions& source) {
  CLI::Option_group& from = *command.add_option_group("Source", "Source of frames: one of");
  CLI::Option* dataset =
      from.add_option("--dataset", source.dataset,
                      "A recording; LAYOUT is kitti-raw, kitti-odometry, kitti-tracking, euroc, cityscapes, folder or "
                      "container")
          ->type_name("LAYOUT:PATH");
  from.add_option("--camera", source.camera, "A camera file; config/cameras holds commented examples")
      ->type_name("FILE");
  from.require_option(1);
  // A camera file contains these settings itself.
  command.add_option("--sequence", source.sequence, "Sequence, where the path holds several")
      ->type_name("NAME")
      ->needs(dataset);
  command.add_option("--cameras", source.cameras, "Pair of cameras, where the rig has both (gray or color)")
      ->check(CLI::IsMember({"gray", "color"}))
      ->needs(dataset);
  command.add_option("--loop", source.passes, "Plays the recording N times")
      ->type_name("N")
      ->needs(dataset)
      ->check(at_least_one());
  command
      .add_option("--fault", source.faults,
                  "Injected faults, for tests: KIND@FIRST[-LAST][%PERCENT][:VALUE],... with unplug, stuck, slow, drop, "
                  "duplicate, "
                  "reorder, corrupt, desync, clock or size, by frame from 0; seed=N")
      ->type_name("SPEC");
}

void add_until_options(CLI::App& command, UntilOptions& until) {
  command.add_option("--frames", until.max_frames, "Stops after N frames of the camera or recording")
      ->type_name("N")
      ->check(at_least_one());
  command.add_option("--seconds", until.max_seconds, "Stops after this time")
      ->type_name("S")
      ->check(number_within(0.001, 1e9));
}

void add_raw_options(CLI::App& command, RawOutputOptions& raw, CLI::Option* out) {
  CLI::Option* container = command
                               .add_flag("--container", raw.container,
                                         "Writes raw images into one file after another instead of KITTI's layout")
                               ->needs(out);
  command.add_option("--segment-mib", raw.segment_mib, "Size at which a container continues in a new file")
      ->type_name("MIB")
      ->needs(container)
      ->check(CLI::Range(1, 1 << 20))
      ->capture_default_str();
  command.add_option("--keep-free-mib", raw.keep_free_mib, "Free space of the disk below which raw recording stops")
      ->type_name("MIB")
      ->needs(out)
      ->check(CLI::Range(0, 1 << 30))
      ->capture_default_str();
}

void add_publish_option(CLI::App& command, std::string& publish) {
  command.add_option("--publish", publish, "Publishes results over DDS as this file says; config/dds holds examples")
      ->type_name("FILE");
}

}  // namespace kinetrace::app
