#pragma once

#include <string>
#include <vector>

namespace structnerf {

// Rewrites a command line into what COLMAP's option manager understands in the
// same way in all versions:
//
// - the keys of the file of --project_path that are in `project_keys`, or in a
//   section that is ("StereoFusion."), come first and --project_path itself
//   goes; options on the command line win. Others are ignored, so a file saved
//   by COLMAP's user interface can be used as it is.
// - a flag in `flags` ("overwrite", ...) may stand without a value.
//
// `args[0]` is the program. Throws std::runtime_error if the project file
// cannot be read or an argument belongs to no option.
std::vector<std::string> ExpandCommandLine(
    const std::vector<std::string>& args,
    const std::vector<std::string>& project_keys,
    const std::vector<std::string>& flags);

// `args[0]`, and of the others the options of a section ("StructNeRF.") with
// their values.
std::vector<std::string> KeepSection(const std::vector<std::string>& args,
                                     const std::string& section);

// Value of `--name value` or `--name=value`, the last one; `default_value` if
// there is none.
std::string FindOption(const std::vector<std::string>& args,
                       const std::string& name,
                       const std::string& default_value);

}  // namespace structnerf
