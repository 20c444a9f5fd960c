#include "tests/support/synthetic_room.h"
#include "tests/support/synthetic_room_writer.h"

#include <cstdlib>
#include <exception>
#include <functional>
#include <iostream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace structnerf {
namespace {

constexpr char kUsage[] =
    "structnerf_make_room OUTPUT_FOLDER [--option VALUE]...\n"
    "Photographs a made-up room, with a COLMAP model and the true depth.\n"
    "  --views N            photographs (20)\n"
    "  --width N            pixels (320)\n"
    "  --height N           pixels (240)\n"
    "  --seed N             varies textures, hand and noise (0)\n"
    "  --camera_models A,B  PINHOLE, SIMPLE_RADIAL, OPENCV or OPENCV_FISHEYE;\n"
    "                       one camera each (PINHOLE)\n"
    "  --sub_folders 0|1    images in two folders with equal names (0)\n"
    "  --exposure_sigma X   spread of the exposures' logarithm (0.03)\n"
    "  --noise_sigma X      sensor noise in grey levels (1.2)\n"
    "  --outlier_ratio X    share of wrong sparse points (0.025)\n"
    "  --world_scale X      world units per metre (1)\n"
    "  --fault NAME         one of the known difficulties (none):\n"
    "                       ";

template <typename T>
T Parse(const std::string& option, const std::string& text) {
  std::istringstream stream(text);
  T value;
  if (!(stream >> value) || !stream.eof()) {
    throw std::invalid_argument("The value of " + option +
                                " is not a number: " + text + ".");
  }
  return value;
}

std::vector<std::string> SplitAtCommas(const std::string& text) {
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, ',');) {
    parts.push_back(part);
  }
  return parts;
}

SyntheticRoomOptions ParseOptions(const std::vector<std::string>& arguments) {
  SyntheticRoomOptions options;
  const auto number = [](auto* field) {
    return [field](const std::string& option, const std::string& text) {
      *field = Parse<std::decay_t<decltype(*field)>>(option, text);
    };
  };
  const std::map<std::string,
                 std::function<void(const std::string&, const std::string&)>>
      setters = {
          {"--views", number(&options.num_views)},
          {"--width", number(&options.width)},
          {"--height", number(&options.height)},
          {"--seed", number(&options.seed)},
          {"--camera_models",
           [&](const std::string&, const std::string& text) {
             options.camera_models = SplitAtCommas(text);
           }},
          {"--sub_folders", number(&options.sub_folders)},
          {"--exposure_sigma", number(&options.exposure_sigma)},
          {"--noise_sigma", number(&options.noise_sigma)},
          {"--outlier_ratio", number(&options.outlier_ratio)},
          {"--world_scale", number(&options.world_scale)},
          {"--fault",
           [&](const std::string&, const std::string& text) {
             options.fault = RoomFaultFromName(text);
           }},
      };
  for (size_t i = 0; i < arguments.size(); i += 2) {
    const auto setter = setters.find(arguments[i]);
    if (setter == setters.end()) {
      throw std::invalid_argument("Unknown option " + arguments[i] +
                                  "; --help lists them.");
    }
    if (i + 1 == arguments.size()) {
      throw std::invalid_argument("The option " + arguments[i] +
                                  " needs a value.");
    }
    setter->second(arguments[i], arguments[i + 1]);
  }
  return options;
}

int Run(std::vector<std::string> arguments) {
  if (arguments.empty() || arguments[0] == "-h" || arguments[0] == "--help") {
    std::cout << kUsage;
    for (const std::string& name : RoomFaultNames()) {
      std::cout << name << " ";
    }
    std::cout << std::endl;
    return arguments.empty() ? EXIT_FAILURE : EXIT_SUCCESS;
  }
  const std::string folder = arguments[0];
  arguments.erase(arguments.begin());
  const SyntheticRoomOptions options = ParseOptions(arguments);
  CheckRoomFolder(folder);
  const SyntheticRoom room = MakeSyntheticRoom(options);
  WriteSyntheticRoom(room, folder);
  std::cout << "Wrote " << room.images.size() << " images and "
            << room.points.size() << " sparse points to " << folder
            << std::endl;
  return EXIT_SUCCESS;
}

}  // namespace
}  // namespace structnerf

int main(int argc, char** argv) {
  try {
    return structnerf::Run(std::vector<std::string>(argv + 1, argv + argc));
  } catch (const std::exception& error) {
    std::cerr << "structnerf_make_room: " << error.what() << std::endl;
    return EXIT_FAILURE;
  }
}
