#pragma once

#include "nerf/engine/engine_factory.h"

#include <functional>
#include <string>

namespace structnerf {

// What the option StructNeRF.device stands for on this machine: "cpu" or
// "cuda", an NVIDIA graphics card.
//   device: one of the two, or "auto", which is the card if the program was
//     built for it, the card can be used, and it has the field.
//   field_type: FieldOptions::type; a card has "grid" only.
// Throws std::invalid_argument, a sentence about the option and the way out,
// for any other word or if "cuda" is not to be had.
std::string ResolveDevice(const std::string& device,
                          const std::string& field_type);

// The engines of a device that ResolveDevice() has returned. What the user
// should know of their work later on, `warn` is told in sentences.
EngineFactory EnginesOfDevice(const std::string& device,
                              std::function<void(const std::string&)> warn);

}  // namespace structnerf
