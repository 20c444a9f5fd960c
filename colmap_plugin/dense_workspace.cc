#include "colmap_plugin/dense_workspace.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <sstream>
#include <stdexcept>
#include <utility>

#include <colmap/util/endian.h>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

constexpr const char* kStereoFolders[] = {
    "depth_maps", "normal_maps", "consistency_graphs"};

// In the report folder. Depth, three of the normal, distinctness.
constexpr const char* kMatchedFolder = "matched";
constexpr size_t kMatchedChannels = 5;

// Of maps that are read; what is larger is no map of ours.
constexpr int kMaxMapSide = 1 << 16;

// COLMAP's own writers do not notice a full disk, this does.
void WriteFile(const std::string& path,
               const std::function<void(std::ostream*)>& write) {
  const std::string partial_path = path + ".partial";
  std::ofstream file(partial_path, std::ios::binary | std::ios::trunc);
  write(&file);
  file.close();
  std::error_code error;
  if (!file.fail()) {
    fs::rename(partial_path, path, error);
  }
  if (file.fail() || error) {
    fs::remove(partial_path, error);
    throw std::runtime_error("The file " + path +
                             " could not be written; is the disk full?");
  }
}

void WriteHeader(std::ostream* stream, int width, int height, int channels) {
  *stream << width << "&" << height << "&" << channels << "&";
}

void WriteMat(const std::string& path,
              const int width,
              const int height,
              const int channels,
              const std::vector<float>& data) {
  WriteFile(path, [&](std::ostream* stream) {
    WriteHeader(stream, width, height, channels);
    for (const float value : data) {
      colmap::WriteBinaryLittleEndian<float>(stream, value);
    }
  });
}

// Reads a map of `channels` planes into `data` and its size into `maps`.
void ReadMat(const std::string& path,
             const size_t channels,
             StereoMaps* maps,
             std::vector<float>* data) {
  std::ifstream file(path, std::ios::binary);
  int width = 0;
  int height = 0;
  size_t num_channels = 0;
  char separators[3] = {};
  file >> width >> separators[0] >> height >> separators[1] >> num_channels >>
      separators[2];
  const bool has_header = file && std::string(separators, 3) == "&&&" &&
                          width > 0 && height > 0 && width <= kMaxMapSide &&
                          height <= kMaxMapSide && num_channels == channels;
  const size_t num_values = channels * width * height;
  if (!has_header || fs::file_size(path) != static_cast<size_t>(file.tellg()) +
                                                num_values * sizeof(float)) {
    throw std::runtime_error("The map " + path +
                             " is missing or damaged; run again.");
  }
  maps->width = width;
  maps->height = height;
  data->resize(num_values);
  colmap::ReadBinaryLittleEndian<float>(&file, data);
}

}  // namespace

std::string MapTypeName(const MapType type) {
  return type == MapType::kPhotometric ? "photometric" : "geometric";
}

StereoMaps ReadDepthMap(const std::string& path) {
  StereoMaps maps;
  ReadMat(path, 1, &maps, &maps.depth);
  return maps;
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
          fs::path(MatchedMapsPath(image_name)).parent_path());
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
  WriteMat(DepthMapPath(image_name, type),
           maps.width,
           maps.height,
           /*channels=*/1,
           maps.depth);
  WriteMat(NormalMapPath(image_name, type),
           maps.width,
           maps.height,
           /*channels=*/3,
           maps.normal);
}

StereoMaps DenseWorkspace::ReadMaps(const std::string& image_name,
                                    const MapType type) const {
  StereoMaps maps;
  ReadMat(DepthMapPath(image_name, type), 1, &maps, &maps.depth);
  StereoMaps normals;
  ReadMat(NormalMapPath(image_name, type), 3, &normals, &maps.normal);
  if (normals.width != maps.width || normals.height != maps.height) {
    throw std::runtime_error("The depth and normal maps of " + image_name +
                             " have different sizes; run again.");
  }
  return maps;
}

std::string DenseWorkspace::MatchedMapsPath(
    const std::string& image_name) const {
  return (fs::path(ReportFolder()) / kMatchedFolder / image_name).string() +
         ".bin";
}

void DenseWorkspace::WriteMatchedMaps(const std::string& image_name,
                                      const DenseMaps& maps) const {
  std::vector<float> channels = maps.depth;
  channels.insert(channels.end(), maps.normal.begin(), maps.normal.end());
  channels.insert(
      channels.end(), maps.distinctness.begin(), maps.distinctness.end());
  const size_t num_pixels = maps.depth.size();
  channels.resize(kMatchedChannels * num_pixels, 0.0f);  // without matching
  WriteMat(MatchedMapsPath(image_name),
           maps.width,
           maps.height,
           kMatchedChannels,
           channels);
}

DenseMaps DenseWorkspace::ReadMatchedMaps(const std::string& image_name) const {
  StereoMaps size;
  std::vector<float> channels;
  ReadMat(MatchedMapsPath(image_name), kMatchedChannels, &size, &channels);
  const auto num_pixels = static_cast<ptrdiff_t>(channels.size()) /
                          static_cast<ptrdiff_t>(kMatchedChannels);
  const auto normal = channels.begin() + num_pixels;
  const auto distinctness = normal + 3 * num_pixels;
  DenseMaps maps;
  maps.width = size.width;
  maps.height = size.height;
  maps.depth.assign(channels.begin(), normal);
  maps.normal.assign(normal, distinctness);
  maps.distinctness.assign(distinctness, channels.end());
  return maps;
}

void DenseWorkspace::RemoveMatchedMaps() const {
  fs::remove_all(fs::path(ReportFolder()) / kMatchedFolder);
}

void DenseWorkspace::WriteConsistencyGraph(
    const std::string& image_name,
    const int width,
    const int height,
    const std::vector<ConsistencyRecord>& records) const {
  std::vector<int> data;
  for (const ConsistencyRecord& record : records) {
    data.push_back(record.col);
    data.push_back(record.row);
    data.push_back(static_cast<int>(record.view_idxs.size()));
    data.insert(data.end(), record.view_idxs.begin(), record.view_idxs.end());
  }
  WriteFile(ConsistencyGraphPath(image_name), [&](std::ostream* stream) {
    WriteHeader(stream, width, height, /*channels=*/1);
    for (const int value : data) {
      colmap::WriteBinaryLittleEndian<int>(stream, value);
    }
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
  const fs::path stereo_path = fs::path(path_) / "stereo";
  WriteFile((stereo_path / "patch-match.cfg").string(),
            [&](std::ostream* stream) { *stream << patch_match.str(); });
  WriteFile((stereo_path / "fusion.cfg").string(),
            [&](std::ostream* stream) { *stream << fusion.str(); });
}

}  // namespace structnerf
