#include "cli/command_reference.hpp"

#include <algorithm>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>

namespace kinetrace::app {
namespace {

std::string upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::toupper(c); });
  return text;
}

// "N" of "N:POSITIVE": checks append their description after a colon, but "LAYOUT:PATH" contains a colon, too.
std::string value_name(const CLI::Option& option) {
  std::string type = option.get_type_name();
  for (const char* check : {":{", ":POSITIVE", ":INT in [", ":FLOAT in [", ":name", ":prefix"}) {
    type.resize(std::min(type.size(), type.find(check)));
  }
  return type;
}

// The values that --help lists for an option, {a,b}; none if any value is accepted.
std::vector<std::string> choices(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const std::size_t begin = type.find('{');
  if (begin == std::string::npos) {
    return {};
  }
  return CLI::detail::split(type.substr(begin + 1, type.find('}', begin) - begin - 1), ',');
}

bool takes_value(const CLI::Option& option) {
  return option.get_items_expected_max() > 0;
}

// --- groff

// Escapes a paragraph: no part of it acts as a request or an escape, and hyphens are ASCII, so that options can be
// copied.
std::string escaped(std::string_view text) {
  std::string out;
  bool at_line_start = true;
  for (const char c : text) {
    if (at_line_start && (c == '.' || c == '\'')) {
      out += "\\&";
    }
    at_line_start = c == '\n';
    switch (c) {
      case '\\': out += "\\e"; break;
      case '-': out += "\\-"; break;
      default: out += c;
    }
  }
  return out;
}

std::string described(const CLI::Option& option) {
  std::string names = option.get_positional() ? option.get_name(true) : option.get_name(false, true);
  std::string text = ".TP\n\\fB" + escaped(names) + "\\fR";
  if (takes_value(option) && !option.get_positional()) {
    text += " \\fI" + escaped(value_name(option)) + "\\fR";
  }
  text += "\n" + escaped(option.get_description()) + "\n";
  if (const std::vector<std::string> values = choices(option); !values.empty()) {
    text += "One of " + escaped(CLI::detail::join(values, ", ")) + ".\n";
  }
  if (!option.get_default_str().empty()) {
    text += "Default: " + escaped(option.get_default_str()) + ".\n";
  }
  return text;
}

std::string options_section(const CLI::App& command) {
  std::string text;
  for (const CLI::Option* option : options_of(command)) {
    text += described(*option);
  }
  return text;
}

std::string command_section(const CLI::App& command, const std::string& prefix) {
  const std::string name = prefix + command.get_name();
  std::string text =
      ".SS \"" + escaped(name) + "\"\n" + escaped(command.get_description()) + "\n" + options_section(command);
  for (const CLI::App* each : commands_of(command)) {
    text += command_section(*each, name + " ");
  }
  return text;
}

// --- bash

// Completions after the words so far, as a branch of a case over the commands given.
std::string completion_branch(const CLI::App& command, const std::string& words, const ValueHints& hints) {
  std::vector<std::string> names;
  std::string values;
  for (const CLI::App* each : commands_of(command)) {
    names.push_back(each->get_name());
  }
  for (const CLI::Option* option : options_of(command)) {
    std::vector<std::string> known = choices(*option);
    const std::string shown = option->get_name(option->get_positional());
    for (const std::string& hinted : {shown, command.get_name() + " " + shown}) {
      if (const auto hint = hints.find(hinted); hint != hints.end()) {
        known.insert(known.end(), hint->second.begin(), hint->second.end());
      }
    }
    if (option->get_positional()) {
      names.insert(names.end(), known.begin(), known.end());
    }
    for (const std::string& name : option->get_lnames()) {
      names.push_back("--" + name);
      if (!known.empty() || takes_value(*option)) {
        values.append("    '").append(words).append(" --").append(name).append("') words='");
        values.append(CLI::detail::join(known, " ")).append("' ;;\n");
      }
    }
  }
  return values + "    '" + words + " '*) words='" + CLI::detail::join(names, " ") + "' ;;\n";
}

std::string completion_branches(const CLI::App& command, const std::string& words, const ValueHints& hints) {
  std::string text;
  for (const CLI::App* each : commands_of(command)) {
    text += completion_branches(*each, words + " " + each->get_name(), hints);
  }
  return text + completion_branch(command, words, hints);
}

std::string command_names(const CLI::App& command) {
  std::string names;
  for (const CLI::App* each : commands_of(command)) {
    names += each->get_name() + "|" + command_names(*each);
  }
  return names;
}

// Finds the commands among the words given; empty for a program without commands.
std::string command_search(const CLI::App& program) {
  std::string commands = command_names(program);
  if (commands.empty()) {
    return "";
  }
  commands.pop_back();
  return "  local word\n"
         "  for word in \"${COMP_WORDS[@]:1:COMP_CWORD-1}\"; do\n"
         "    case $word in\n"
         "    " +
         commands +
         ") given+=\" $word\" ;;\n"
         "    esac\n"
         "  done\n";
}

}  // namespace

std::vector<const CLI::App*> commands_of(const CLI::App& command) {
  return command.get_subcommands([](const CLI::App* each) { return !each->get_name().empty(); });
}

std::vector<const CLI::Option*> options_of(const CLI::App& command) {
  std::vector<const CLI::Option*> options = command.get_options();
  for (const CLI::App* group : command.get_subcommands([](const CLI::App* each) { return each->get_name().empty(); })) {
    const std::vector<const CLI::Option*> more = group->get_options();
    options.insert(options.end(), more.begin(), more.end());
  }
  return options;
}

std::string manual_page(const CLI::App& program) {
  const std::string& name = program.get_name();
  const std::vector<const CLI::App*> commands = commands_of(program);
  std::string text = ".TH " + upper(name) + " 1 \"\" \"" + escaped(program.version()) + "\" \"User Commands\"\n";
  text += ".SH NAME\n" + escaped(name) + " \\- " + escaped(program.get_description()) + "\n";
  text += ".SH SYNOPSIS\n\\fB" + escaped(name) + "\\fR";
  text += std::string(commands.empty() ? "" : " \\fICOMMAND\\fR") + " [\\fIOPTIONS\\fR]\n";
  text += ".SH OPTIONS\n" + options_section(program);
  if (!commands.empty()) {
    text += ".SH COMMANDS\n";
  }
  for (const CLI::App* command : commands) {
    text += command_section(*command, "");
  }
  return text + ".SH NOTES\n" + escaped(program.get_footer()) + "\n";
}

std::string bash_completion(const CLI::App& program, const ValueHints& hints) {
  const std::string& name = program.get_name();
  // The last word but one may be an option that takes a value.
  return "# bash completion for " + name + "\n_" + name +
         "() {\n"
         "  local words given='" +
         name + "' last=\"${COMP_WORDS[COMP_CWORD]}\" before=\"${COMP_WORDS[COMP_CWORD-1]}\"\n" +
         command_search(program) + "  case \"$given $before\" in\n" + completion_branches(program, name, hints) +
         "  esac\n"
         "  mapfile -t COMPREPLY < <(compgen -W \"$words\" -- \"$last\")\n"
         "  [[ \"${COMPREPLY[*]}\" == *[:@] ]] && compopt -o nospace 2>/dev/null\n"
         "  return 0\n"
         "}\n"
         "complete -o bashdefault -o default -F _" +
         name + " " + name + "\n";
}

}  // namespace kinetrace::app
