#include "colmap_plugin/report_reader.h"

#include "colmap_plugin/option_table.h"

#include <fstream>
#include <stdexcept>
#include <type_traits>

#include <nlohmann/json.hpp>

namespace structnerf {
namespace {

using nlohmann::json;

// Options that the report does not know keep their defaults.
void ReadOptions(const json& object, StructNerfOptions* options) {
  options->quality = object.value("StructNeRF.quality", options->quality);
  options->reconstruction = QualityPreset(options->quality);
  for (const OptionEntry& entry : MakeOptionTable(options)) {
    const auto found = object.find(entry.name);
    if (found != object.end()) {
      std::visit(
          [&](auto* pointer) {
            *pointer = found->get<std::remove_pointer_t<decltype(pointer)>>();
          },
          entry.value);
    }
  }
}

Eigen::Vector3f VectorOf(const json& array) {
  return {array.at(0).get<float>(),
          array.at(1).get<float>(),
          array.at(2).get<float>()};
}

// Runs of the time before exposures have none.
std::vector<Exposure> ReadExposures(const json& report) {
  std::vector<Exposure> exposures;
  for (const json& view : report.value("views", json::array())) {
    if (view.contains("exposure")) {
      const json& exposure = view["exposure"];
      exposures.push_back(
          {VectorOf(exposure.at("gain")), VectorOf(exposure.at("offset"))});
    }
  }
  return exposures;
}

}  // namespace

FinishedRun ReadReport(const std::string& path) {
  std::ifstream file(path);
  if (!file) {
    throw std::runtime_error("The report " + path + " cannot be read.");
  }
  try {
    const json report = json::parse(file);
    FinishedRun run;
    ReadOptions(report.at("options"), &run.options);
    run.seconds = report.at("seconds");
    run.cpu_seconds = report.at("cpu_seconds");
    run.exposures = ReadExposures(report);
    return run;
  } catch (const std::exception& error) {
    throw std::runtime_error("The file " + path +
                             " is no report of a finished run (" +
                             error.what() + ").");
  }
}

}  // namespace structnerf
