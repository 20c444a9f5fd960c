#include "colmap_plugin/dense_workspace.h"

#include "nerf/util/whole_file.h"

#include <algorithm>
#include <filesystem>
#include <ostream>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

constexpr const char* kStereoFolders[] = {
    "depth_maps", "normal_maps", "consistency_graphs"};

// In the folder "stereo".
constexpr const char* kPatchMatchConfig = "patch-match.cfg";
constexpr const char* kFusionConfig = "fusion.cfg";

// In the report folder.
constexpr const char* kConfidenceFolder = "confidence";

// In the report folder.
constexpr const char* kInterimFolder = "interim";
constexpr const char* kInterimSuffixes[] = {
    ".rendered.bin", ".matched.bin", ".completed.bin"};

// Depth, three of the normal, and distinctness while it is of use.
size_t NumInterimChannels(const InterimStage stage) {
  return stage == InterimStage::kMatched ? 5 : 4;
}

}  // namespace

std::string MapTypeName(const MapType type) {
  return type == MapType::kPhotometric ? "photometric" : "geometric";
}

StereoMaps ReadDepthMap(const std::string& path) {
  FloatArray depth = ReadArrayFile(path, /*num_planes=*/1);
  return {depth.width, depth.height, std::move(depth.values), {}};
}

DenseWorkspace::DenseWorkspace(std::string path) : path_(std::move(path)) {}

std::string DenseWorkspace::ImagesPath() const {
  return (fs::path(path_) / "images").string();
}

std::string DenseWorkspace::SparsePath() const {
  return (fs::path(path_) / "sparse").string();
}

std::string DenseWorkspace::FusedPath() const {
  return (fs::path(path_) / "fused.ply").string();
}

std::string DenseWorkspace::ReportFolder() const {
  return (fs::path(path_) / "structnerf").string();
}

std::string DenseWorkspace::FieldPath() const {
  return (fs::path(ReportFolder()) / "field.bin").string();
}

std::string DenseWorkspace::ImagePath(const std::string& image_name) const {
  return (fs::path(ImagesPath()) / image_name).string();
}

std::string DenseWorkspace::DepthMapPath(const std::string& image_name,
                                         const MapType type) const {
  return (fs::path(path_) / "stereo/depth_maps" / image_name).string() + "." +
         MapTypeName(type) + ".bin";
}

std::string DenseWorkspace::NormalMapPath(const std::string& image_name,
                                          const MapType type) const {
  return (fs::path(path_) / "stereo/normal_maps" / image_name).string() + "." +
         MapTypeName(type) + ".bin";
}

std::string DenseWorkspace::ConsistencyGraphPath(
    const std::string& image_name) const {
  return (fs::path(path_) / "stereo/consistency_graphs" / image_name).string() +
         "." + MapTypeName(MapType::kGeometric) + ".bin";
}

void DenseWorkspace::CreateFolders(
    const std::vector<std::string>& image_names) const {
  try {
    fs::create_directories(ReportFolder());
    for (const char* folder : kStereoFolders) {
      const fs::path folder_path = fs::path(path_) / "stereo" / folder;
      fs::create_directories(folder_path);
      for (const std::string& image_name : image_names) {
        fs::create_directories((folder_path / image_name).parent_path());
      }
    }
    for (const std::string& image_name : image_names) {
      fs::create_directories(
          fs::path(InterimMapsPath(image_name, InterimStage::kMatched))
              .parent_path());
      fs::create_directories(
          fs::path(ConfidencePath(image_name)).parent_path());
    }
  } catch (const fs::filesystem_error& error) {
    throw std::runtime_error(
        "A folder in " + path_ +
        " could not be created: " + error.code().message() + ".");
  }
}

std::vector<std::string> DenseWorkspace::FindResults(
    const std::vector<std::string>& image_names, const size_t limit) const {
  std::vector<std::string> candidates = {FusedPath()};
  for (const std::string& image_name : image_names) {
    for (const MapType type : {MapType::kPhotometric, MapType::kGeometric}) {
      candidates.push_back(DepthMapPath(image_name, type));
      candidates.push_back(NormalMapPath(image_name, type));
    }
  }
  std::vector<std::string> found;
  for (const std::string& candidate : candidates) {
    if (found.size() < limit && fs::exists(candidate)) {
      found.push_back(candidate);
    }
  }
  return found;
}

void DenseWorkspace::WriteMaps(const std::string& image_name,
                               const MapType type,
                               const StereoMaps& maps) const {
  WriteArrayFile(
      DepthMapPath(image_name, type), maps.width, maps.height, maps.depth);
  WriteArrayFile(
      NormalMapPath(image_name, type), maps.width, maps.height, maps.normal);
}

StereoMaps DenseWorkspace::ReadMaps(const std::string& image_name,
                                    const MapType type) const {
  StereoMaps maps = ReadDepthMap(DepthMapPath(image_name, type));
  FloatArray normals =
      ReadArrayFile(NormalMapPath(image_name, type), /*num_planes=*/3);
  if (normals.width != maps.width || normals.height != maps.height) {
    throw std::runtime_error("The depth and normal maps of " + image_name +
                             " have different sizes; run again.");
  }
  maps.normal = std::move(normals.values);
  return maps;
}

std::string DenseWorkspace::InterimMapsPath(const std::string& image_name,
                                            const InterimStage stage) const {
  return (fs::path(ReportFolder()) / kInterimFolder / image_name).string() +
         kInterimSuffixes[static_cast<size_t>(stage)];
}

void DenseWorkspace::WriteInterimMaps(const std::string& image_name,
                                      const InterimStage stage,
                                      const DenseMaps& maps) const {
  std::vector<float> channels = maps.depth;
  channels.insert(channels.end(), maps.normal.begin(), maps.normal.end());
  channels.insert(
      channels.end(), maps.distinctness.begin(), maps.distinctness.end());
  // Without matching there is no distinctness.
  channels.resize(NumInterimChannels(stage) * maps.depth.size(), 0.0f);
  WriteArrayFile(
      InterimMapsPath(image_name, stage), maps.width, maps.height, channels);
}

DenseMaps DenseWorkspace::ReadInterimMaps(const std::string& image_name,
                                          const InterimStage stage) const {
  const FloatArray array = ReadArrayFile(InterimMapsPath(image_name, stage),
                                         NumInterimChannels(stage));
  const std::vector<float>& channels = array.values;
  const ptrdiff_t num_pixels =
      static_cast<ptrdiff_t>(array.width) * array.height;
  const auto normal = channels.begin() + num_pixels;
  const auto distinctness = normal + 3 * num_pixels;
  DenseMaps maps;
  maps.width = array.width;
  maps.height = array.height;
  maps.depth.assign(channels.begin(), normal);
  maps.normal.assign(normal, distinctness);
  maps.distinctness.assign(distinctness, channels.end());
  return maps;
}

void DenseWorkspace::RemoveInterimMaps() const {
  fs::remove_all(fs::path(ReportFolder()) / kInterimFolder);
}

std::string DenseWorkspace::ConfidencePath(
    const std::string& image_name) const {
  return (fs::path(ReportFolder()) / kConfidenceFolder / image_name).string() +
         ".bin";
}

void DenseWorkspace::WriteConfidence(
    const std::string& image_name,
    const int width,
    const int height,
    const std::vector<float>& confidence) const {
  WriteArrayFile(ConfidencePath(image_name), width, height, confidence);
}

FloatArray DenseWorkspace::ReadConfidence(const std::string& image_name) const {
  return ReadArrayFile(ConfidencePath(image_name), /*num_planes=*/1);
}

void DenseWorkspace::WriteConsistencyGraph(
    const std::string& image_name,
    const int width,
    const int height,
    const std::vector<int>& graph) const {
  WriteWholeFile(ConsistencyGraphPath(image_name), [&](std::ostream* stream) {
    *stream << width << "&" << height << "&1&";
    stream->write(reinterpret_cast<const char*>(graph.data()),
                  static_cast<std::streamsize>(graph.size() * sizeof(int)));
  });
}

void DenseWorkspace::WriteConfigs(
    const std::vector<std::string>& image_names,
    const std::vector<std::vector<int>>& source_idxs) const {
  // COLMAP splits the list of source images at commas.
  const bool can_list_sources = std::none_of(
      image_names.begin(), image_names.end(), [](const std::string& name) {
        return name.find(',') != std::string::npos;
      });
  std::ostringstream patch_match;
  std::ostringstream fusion;
  for (size_t i = 0; i < image_names.size(); ++i) {
    fusion << image_names[i] << "\n";
    patch_match << image_names[i] << "\n";
    if (!can_list_sources || source_idxs[i].empty()) {
      patch_match << "__auto__, 20\n";
      continue;
    }
    for (size_t j = 0; j < source_idxs[i].size(); ++j) {
      patch_match << (j > 0 ? ", " : "") << image_names[source_idxs[i][j]];
    }
    patch_match << "\n";
  }
  WriteWholeFile(ConfigPath(kPatchMatchConfig),
                 [&](std::ostream* stream) { *stream << patch_match.str(); });
  WriteWholeFile(FusionConfigPath(),
                 [&](std::ostream* stream) { *stream << fusion.str(); });
}

std::string DenseWorkspace::FusionConfigPath() const {
  return ConfigPath(kFusionConfig);
}

void DenseWorkspace::CopyConfigsOf(const DenseWorkspace& other) const {
  for (const char* const name : {kPatchMatchConfig, kFusionConfig}) {
    if (fs::exists(other.ConfigPath(name))) {
      fs::copy_file(other.ConfigPath(name),
                    ConfigPath(name),
                    fs::copy_options::overwrite_existing);
    }
  }
}

std::string DenseWorkspace::ConfigPath(const std::string& name) const {
  return (fs::path(path_) / "stereo" / name).string();
}

}  // namespace structnerf
