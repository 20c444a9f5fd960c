#pragma once

#include "colmap_plugin/stereo_maps.h"
#include "nerf/dense_maps.h"
#include "nerf/util/array_file.h"

#include <string>
#include <vector>

namespace structnerf {

// COLMAP's two kinds of maps, which its stereo fusion can be pointed at:
// photometric ones hold every confident pixel, geometric ones those that other
// views confirm.
enum class MapType { kPhotometric, kGeometric };

// "photometric" or "geometric".
std::string MapTypeName(MapType type);

// A depth map in COLMAP's format, without normals. Throws std::runtime_error if
// it is damaged or missing.
StereoMaps ReadDepthMap(const std::string& path);

// What has been done to the maps of a view that is not finished.
enum class InterimStage {
  kRendered,   // as the field has them
  kMatched,    // and refined by matching, if the options say so
  kCompleted,  // and with blank surfaces on planes
};

// Paths and files of one folder in COLMAP's dense layout:
//
//    images/ sparse/ stereo/{depth_maps,normal_maps,consistency_graphs}/
//    stereo/patch-match.cfg stereo/fusion.cfg fused.ply fused.ply.vis
//
// and our structnerf/. Image names may contain sub-folders. Writing throws
// std::runtime_error, naming the file, if the disk is full or not writable.
class DenseWorkspace {
 public:
  explicit DenseWorkspace(std::string path);

  const std::string& Path() const { return path_; }
  std::string ImagesPath() const;
  std::string SparsePath() const;
  std::string FusedPath() const;
  std::string ReportFolder() const;
  std::string FieldPath() const;
  std::string ImagePath(const std::string& image_name) const;
  std::string DepthMapPath(const std::string& image_name, MapType type) const;
  std::string NormalMapPath(const std::string& image_name, MapType type) const;
  std::string ConsistencyGraphPath(const std::string& image_name) const;

  // Creates the stereo and report folders with the sub-folders of the images.
  void CreateFolders(const std::vector<std::string>& image_names) const;

  // Paths of dense results that exist for one of the images, at most `limit`.
  std::vector<std::string> FindResults(
      const std::vector<std::string>& image_names, size_t limit) const;

  void WriteMaps(const std::string& image_name,
                 MapType type,
                 const StereoMaps& maps) const;

  // Throws std::runtime_error if a file is damaged or missing.
  StereoMaps ReadMaps(const std::string& image_name, MapType type) const;

  // Maps of a view on their way, each in one file of the report folder for the
  // time of a run: depth, normal and, of matched ones, distinctness.
  std::string InterimMapsPath(const std::string& image_name,
                              InterimStage stage) const;
  void WriteInterimMaps(const std::string& image_name,
                        InterimStage stage,
                        const DenseMaps& maps) const;
  DenseMaps ReadInterimMaps(const std::string& image_name,
                            InterimStage stage) const;
  void RemoveInterimMaps() const;

  // Probability that the photometric depth of each pixel is right
  // (nerf/extract/confidence.h), in COLMAP's format of depth maps, in the
  // report folder. ReadConfidence throws std::runtime_error if the file is
  // damaged or missing.
  std::string ConfidencePath(const std::string& image_name) const;
  void WriteConfidence(const std::string& image_name,
                       int width,
                       int height,
                       const std::vector<float>& confidence) const;
  FloatArray ReadConfidence(const std::string& image_name) const;

  // `graph`: as in nerf/extract/consistency.h; its indices are those of the
  // registered images in the model's order.
  void WriteConsistencyGraph(const std::string& image_name,
                             int width,
                             int height,
                             const std::vector<int>& graph) const;

  // stereo/patch-match.cfg with the source images of each image, and
  // stereo/fusion.cfg. `source_idxs[i]` index `image_names`, best first.
  void WriteConfigs(const std::vector<std::string>& image_names,
                    const std::vector<std::vector<int>>& source_idxs) const;

  std::string FusionConfigPath() const;

  // Takes those of the two that `other` has from there: somebody may have
  // chosen images or sources in them.
  void CopyConfigsOf(const DenseWorkspace& other) const;

 private:
  std::string ConfigPath(const std::string& name) const;

  const std::string path_;
};

}  // namespace structnerf
