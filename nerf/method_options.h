#pragma once

#include "nerf/option_entry.h"
#include "nerf/options.h"

#include <string>
#include <vector>

namespace structnerf {

// Every field of the method's options as "StructNeRF.<field>", or
// "StructNeRF.stereo_<field>" for those of StereoOptions, whose names repeat.
// The ranges are those of the Check() functions.
std::vector<OptionEntry> MakeMethodOptionEntries(
    ReconstructionOptions* options);

// The options of another preset, with those of `current` that differ from the
// preset it was made from.
ReconstructionOptions ChangePreset(ReconstructionOptions current,
                                   ReconstructionOptions preset,
                                   ReconstructionOptions new_preset);

// "StructNeRF.<field> must be ..." about the first field that is wrong; empty
// if there is none.
std::string FindMethodOptionError(const ReconstructionOptions& options);

}  // namespace structnerf
