#include "dds/dds_command_line.hpp"

#include <CLI/CLI.hpp>

#include "cli/commands.hpp"
#include "cli/option_checks.hpp"

namespace kinetrace::app {
namespace {

// The names serve as folders and as certificate names.
std::string dds_name_error(const std::string& name) {
  constexpr std::size_t kMax = 31;
  const bool is_clean =
      !name.empty() && name.size() <= kMax && name.front() != '.' &&
      name.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_.-") == std::string::npos;
  return is_clean ? "" : "\"" + name + "\" is no name: 1 to 31 letters, digits or any of _ . -, the first no dot";
}

std::string dds_prefix_error(const std::string& prefix) {
  const bool is_clean =
      prefix.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_/") == std::string::npos;
  return is_clean ? "" : "\"" + prefix + "\" is no prefix: letters, digits and _, joined by /";
}

void add_network_options(CLI::App& command, NetworkOptions& network) {
  command.add_option("--publish", network.file, "File of the run's --publish; config/dds holds examples")
      ->type_name("FILE");
  command.add_option("--domain", network.domain, "DDS domain instead of the file's (0 without a file)")
      ->type_name("N")
      ->check(CLI::Range(0, 230));
  command.add_option("--interface", network.interface, "Network interface instead of the file's (lo without a file)")
      ->type_name("NAME");
}

void add_listening_time(CLI::App& command, double& seconds) {
  command.add_option("--seconds", seconds, "Ends after this time; without it, at Ctrl-C")
      ->type_name("S")
      ->check(number_within(0.001, 1e9));
}

void add_keys_options(CLI::App& keys, KeysOptions& options) {
  keys.add_option("--out", options.out,
                  "New folder, laid out as a keystore of ROS 2; one made earlier gets further identities")
      ->type_name("DIR")
      ->required();
  const auto add_names = [&keys](const char* option, std::vector<std::string>& names, const char* description) {
    keys.add_option(option, names, description)
        ->type_name("NAME")
        ->allow_extra_args(false)
        ->check(CLI::Validator(dds_name_error, "", "name"));
  };
  add_names("--device", options.devices,
            "Participant that publishes results and reads masks; may be repeated. Without any name: kinetrace");
  add_names("--viewer", options.viewers, "Participant that reads results; may be repeated. Without any name: viewer");
  add_names("--segmenter", options.segmenters, "Participant that publishes masks and reads results; may be repeated");
  keys.add_option("--days", options.days, "Validity of identities and permissions, days")
      ->type_name("N")
      ->check(CLI::Range(1, 3650))
      ->capture_default_str();
  keys.add_option("--ros2-prefix", options.ros_prefix, "dds.ros2.prefix of the devices, since permissions name topics")
      ->type_name("NAME")
      ->check(CLI::Validator(dds_prefix_error, "", "prefix"))
      ->capture_default_str();
}

void add_monitor_options(CLI::App& monitor, MonitorOptions& options) {
  add_network_options(monitor, options.network);
  monitor.add_option("--device", options.network.device, "Only this device; without it, all that are received")
      ->type_name("NAME");
  monitor
      .add_option("--record", options.record, "Records the ROS 2 topics into a new MCAP file, readable however it ends")
      ->type_name("FILE.mcap");
  add_listening_time(monitor, options.seconds);
  monitor.add_option("--messages", options.messages, "Ends after N messages of Kinetrace's own topics")
      ->type_name("N")
      ->check(at_least_one());
  monitor.add_flag("--json", options.json, "Prints each message as one line of JSON, and rates once a second");
  monitor.add_flag("--quiet", options.quiet, "Prints nothing but warnings, errors and the messages of --json");
  monitor.footer(
      "\nExit codes: 0 something was received; 74 nothing was, or writing failed; 73 the file cannot be made; "
      "others as of run. Ctrl-C is no failure.");
}

void add_masks_options(CLI::App& masks, MaskOptions& options) {
  masks.add_option("MASKS", options.folders, "Folders of KITTI MOTS PNG files")
      ->type_name("LEFT_DIR[,RIGHT_DIR]")
      ->required();
  masks.add_flag("--by-order", options.by_order,
                 "Assigns files to frames in the order of their names; without it, by the numbers in their names");
  add_network_options(masks, options.network);
  masks.add_option("--device", options.network.device, "Device of the run (dds.device) instead of the file's")
      ->type_name("NAME");
  add_listening_time(masks, options.seconds);
  masks.add_flag("--quiet", options.quiet, "Prints nothing but warnings and errors");
}

}  // namespace

Action add_keys(CLI::App& command) {
  return bind_options(command, add_keys_options, keys_command);
}

Action add_monitor(CLI::App& command) {
  return bind_options(command, add_monitor_options, monitor_command);
}

Action add_masks(CLI::App& command) {
  return bind_options(command, add_masks_options, mask_command);
}

}  // namespace kinetrace::app
