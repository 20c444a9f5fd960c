#include "colmap_plugin/command_line.h"

#include <algorithm>
#include <fstream>
#include <stdexcept>

#include <boost/program_options.hpp>

namespace structnerf {
namespace {

bool StartsWith(const std::string& text, const std::string& prefix) {
  return text.compare(0, prefix.size(), prefix) == 0;
}

bool Contains(const std::vector<std::string>& values,
              const std::string& value) {
  return std::find(values.begin(), values.end(), value) != values.end();
}

// "name" of "--name" and "--name=value", else empty.
std::string OptionName(const std::string& arg) {
  return StartsWith(arg, "--") ? arg.substr(2, arg.find('=') - 2) : "";
}

bool HasOption(const std::vector<std::string>& args, const std::string& name) {
  return std::any_of(args.begin(), args.end(), [&](const std::string& arg) {
    return OptionName(arg) == name;
  });
}

std::vector<std::string> ReadProjectFile(
    const std::string& path, const std::vector<std::string>& project_keys) {
  std::ifstream file(path);
  if (!file) {
    throw std::runtime_error("The project file " + path +
                             " of --project_path cannot be read.");
  }
  namespace config = boost::program_options;
  std::vector<std::string> args;
  try {
    const auto parsed = config::parse_config_file(file,
                                                  config::options_description(),
                                                  /*allow_unregistered=*/true);
    for (const auto& option : parsed.options) {
      const std::string& name = option.string_key;
      const bool is_ours =
          Contains(project_keys, name) ||
          Contains(project_keys, name.substr(0, name.find('.') + 1));
      if (is_ours && !option.value.empty() && !option.value[0].empty()) {
        args.push_back("--" + name + "=" + option.value[0]);
      }
    }
  } catch (const config::error& error) {
    throw std::runtime_error("The project file " + path +
                             " cannot be understood: " + error.what() + ".");
  }
  return args;
}

}  // namespace

std::vector<std::string> ExpandCommandLine(
    const std::vector<std::string>& args,
    const std::vector<std::string>& project_keys,
    const std::vector<std::string>& flags) {
  std::vector<std::string> given;
  for (size_t i = 1; i < args.size(); ++i) {
    const bool is_option = StartsWith(args[i], "-");
    const bool is_value = StartsWith(args[i - 1], "--") &&
                          args[i - 1].find('=') == std::string::npos;
    if (!is_option && !is_value) {
      throw std::runtime_error("The argument \"" + args[i] +
                               "\" belongs to no option; put values with "
                               "spaces in quotes.");
    }
    given.push_back(args[i]);
    const bool has_value =
        i + 1 < args.size() && !StartsWith(args[i + 1], "--");
    if (StartsWith(args[i], "--") && Contains(flags, args[i].substr(2)) &&
        !has_value) {
      given.back() += "=1";
    }
  }

  std::vector<std::string> expanded = {args[0]};
  const std::string project_path = FindOption(given, "project_path", "");
  if (!project_path.empty()) {
    for (const std::string& arg : ReadProjectFile(project_path, project_keys)) {
      if (!HasOption(given, OptionName(arg))) {
        expanded.push_back(arg);
      }
    }
  }
  for (size_t i = 0; i < given.size(); ++i) {
    if (OptionName(given[i]) != "project_path") {
      expanded.push_back(given[i]);
    } else if (given[i] == "--project_path") {
      ++i;  // its value
    }
  }
  return expanded;
}

std::vector<std::string> KeepSection(const std::vector<std::string>& args,
                                     const std::string& section) {
  std::vector<std::string> kept = {args[0]};
  for (size_t i = 1; i < args.size(); ++i) {
    if (!StartsWith(args[i], "--" + section)) {
      continue;
    }
    kept.push_back(args[i]);
    if (args[i].find('=') == std::string::npos && i + 1 < args.size()) {
      kept.push_back(args[++i]);
    }
  }
  return kept;
}

std::string FindOption(const std::vector<std::string>& args,
                       const std::string& name,
                       const std::string& default_value) {
  std::string value = default_value;
  for (size_t i = 0; i < args.size(); ++i) {
    if (args[i] == "--" + name && i + 1 < args.size()) {
      value = args[i + 1];
    } else if (StartsWith(args[i], "--" + name + "=")) {
      value = args[i].substr(name.size() + 3);
    }
  }
  return value;
}

}  // namespace structnerf
