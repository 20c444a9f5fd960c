#include "colmap_plugin/input_check.h"

#include "colmap_plugin/colmap_compat.h"
#include "colmap_plugin/dense_workspace.h"
#include "colmap_plugin/image_file.h"
#include "colmap_plugin/log_level.h"
#include "colmap_plugin/masks.h"
#include "colmap_plugin/text_output.h"
#include "nerf/scene_file.h"
#include "nerf/util/image_name.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <unordered_set>

#include <boost/algorithm/string/trim.hpp>
#include <glog/logging.h>
#include <sys/stat.h>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

bool HasModelFiles(const fs::path& path, const std::string& extension) {
  return fs::is_regular_file(path / ("cameras" + extension)) &&
         fs::is_regular_file(path / ("images" + extension)) &&
         fs::is_regular_file(path / ("points3D" + extension));
}

bool HoldsModel(const std::string& path) {
  return HasModelFiles(path, ".bin") || HasModelFiles(path, ".txt");
}

// Results are moved into their folders once they are complete.
void RequireOneDisk(const std::string& path, const bool is_new) {
  std::vector<std::string> folders = {"stereo", "structnerf"};
  if (is_new) {
    folders.insert(folders.end(), {"images", "sparse"});
  }
  struct stat parent;
  if (stat(path.c_str(), &parent) != 0) {
    return;  // it will be made
  }
  for (const std::string& name : folders) {
    struct stat folder;
    const std::string folder_path = (fs::path(path) / name).string();
    if (stat(folder_path.c_str(), &folder) == 0 &&
        folder.st_dev != parent.st_dev) {
      throw std::runtime_error("The folder " + folder_path +
                               " is on another disk than " + path +
                               ", so results cannot be moved there in one "
                               "step; choose a folder on one disk.");
    }
  }
}

bool HasBlankAtEnd(const std::string& name) {
  return boost::trim_copy(name) != name;
}

// Every sparse point is finite, and was seen where the model says.
void CheckPoints(const colmap::Reconstruction& reconstruction) {
  const auto image_ids = RegisteredImageIds(reconstruction);
  const std::unordered_set<colmap::image_t> known(image_ids.begin(),
                                                  image_ids.end());
  for (const auto& [point3D_id, point3D] : reconstruction.Points3D()) {
    const std::string prefix =
        "The sparse point " + std::to_string(point3D_id) + " of the model ";
    if (!point3D.xyz.allFinite()) {
      throw std::runtime_error(prefix +
                               "has no finite coordinates; remove it.");
    }
    for (const colmap::TrackElement& element : point3D.track.Elements()) {
      if (known.count(element.image_id) == 0) {
        throw std::runtime_error(
            prefix + "was seen in image " + std::to_string(element.image_id) +
            ", which the model does not have; its files do not belong "
            "together. COLMAP's image_deleter removes images from all of "
            "them.");
      }
      if (element.point2D_idx >=
          reconstruction.Image(element.image_id).NumPoints2D()) {
        throw std::runtime_error(
            prefix + "refers to keypoint " +
            std::to_string(element.point2D_idx) + " of image " +
            reconstruction.Image(element.image_id).Name() +
            ", which the model does not have; its files do not belong "
            "together.");
      }
    }
  }
}

}  // namespace

colmap::Reconstruction ReadModel(const std::string& path) {
  if (!fs::is_directory(path)) {
    throw std::runtime_error("The model folder " + path +
                             " does not exist; give the folder of a COLMAP "
                             "model, or of a workspace that has one in sparse "
                             "(image_undistorter makes it).");
  }
  if (!HoldsModel(path)) {
    throw std::runtime_error(
        "The folder " + path +
        " holds no COLMAP model (cameras, images and points3D as .bin or "
        ".txt); the mapper usually writes it to sparse/0.");
  }
  colmap::Reconstruction reconstruction;
  try {
    const ScopedLogLevel quiet(google::GLOG_FATAL);
    reconstruction.Read(path);
  } catch (const std::exception& error) {
    throw std::runtime_error(
        "The COLMAP model in " + path + " cannot be read (" + error.what() +
        "); it is damaged or has a camera model that this COLMAP does not "
        "know, such as a spherical one.");
  }
  return reconstruction;
}

void CheckModel(const colmap::Reconstruction& reconstruction) {
  const auto image_ids = RegisteredImageIds(reconstruction);
  if (image_ids.size() < 2) {
    throw std::runtime_error("The model has " +
                             std::to_string(image_ids.size()) +
                             " registered images, but at least 2 are needed; "
                             "check the result of the mapper.");
  }
  if (reconstruction.NumPoints3D() == 0) {
    throw std::runtime_error(
        "The model has no sparse points; run point_triangulator or the mapper "
        "first.");
  }
  std::unordered_set<std::string> names;
  for (const colmap::image_t image_id : image_ids) {
    const colmap::Image& image = reconstruction.Image(image_id);
    if (!IsSafeImageName(image.Name())) {
      throw std::runtime_error(
          "The image name \"" + Printable(image.Name()) +
          "\" would leave the workspace or break its files; rename the image.");
    }
    if (!names.insert(fs::path(image.Name()).lexically_normal().string())
             .second) {
      throw std::runtime_error("The model has two images named " +
                               image.Name() + "; rename one of them.");
    }
    if (HasBlankAtEnd(image.Name())) {
      throw std::runtime_error("The image name \"" + image.Name() +
                               "\" begins or ends with a blank, which COLMAP "
                               "leaves out of its lists of images; rename the "
                               "image.");
    }
    const colmap::Camera& camera = reconstruction.Camera(image.CameraId());
    if (!IsPerspective(camera)) {
      throw std::runtime_error("The camera of image " + image.Name() + " (" +
                               camera.ModelName() +
                               ") cannot be undistorted; convert the images "
                               "to perspective ones first.");
    }
    if (IsIdealFisheye(camera)) {
      throw std::runtime_error("The camera of image " + image.Name() + " (" +
                               camera.ModelName() +
                               ") has no distortion coefficients, so COLMAP "
                               "would take this fisheye lens for a pinhole; "
                               "set its first coefficient to 1e-6.");
    }
  }
  CheckPoints(reconstruction);
}

void CheckFusionConfig(const std::string& workspace_path,
                       const std::vector<std::string>& image_names) {
  const std::string path = DenseWorkspace(workspace_path).FusionConfigPath();
  const std::unordered_set<std::string> names(image_names.begin(),
                                              image_names.end());
  std::ifstream file(path);
  int line_number = 0;
  for (std::string line; std::getline(file, line);) {
    ++line_number;
    boost::trim(line);
    if (!line.empty() && line[0] != '#' && names.count(line) == 0) {
      throw std::runtime_error("Line " + std::to_string(line_number) + " of " +
                               path + " names the image " + Printable(line) +
                               ", which the workspace's model does not have; "
                               "remove the line.");
    }
  }
}

void CheckWorkspaceFolder(const std::string& path) {
  if (!fs::is_directory(path)) {
    throw std::runtime_error("The workspace folder " + path +
                             " does not exist.");
  }
}

void CheckImages(const colmap::Reconstruction& reconstruction,
                 const std::string& image_path) {
  if (!fs::is_directory(image_path)) {
    throw std::runtime_error("The image folder " + image_path +
                             " does not exist.");
  }
  for (const colmap::image_t image_id : RegisteredImageIds(reconstruction)) {
    const colmap::Image& image = reconstruction.Image(image_id);
    const colmap::Camera& camera = reconstruction.Camera(image.CameraId());
    const std::string path = (fs::path(image_path) / image.Name()).string();
    if (!fs::exists(path)) {
      throw std::runtime_error("The image " + path +
                               " of the model does not exist; check the image "
                               "folder.");
    }
    ImageHeader header;
    if (!fs::is_regular_file(path) || !std::ifstream(path).is_open() ||
        !ReadImageHeader(path, &header)) {
      throw std::runtime_error(
          "The image " + path +
          " cannot be read; check its permissions and that it is an image.");
    }
    if (IsCutOff(path)) {
      throw std::runtime_error("The image " + path +
                               " is cut off, its end is missing; copy it "
                               "again.");
    }
    if (!header.has_readable_colors) {
      throw std::runtime_error("The image " + path +
                               " has a pixel format that COLMAP reads no "
                               "colours from (such as 16-bit grey); convert "
                               "the images to 8 bits per channel.");
    }
    if (static_cast<size_t>(header.width) != camera.width ||
        static_cast<size_t>(header.height) != camera.height) {
      throw std::runtime_error(
          "The image " + path + " is " + SizeText(header.width, header.height) +
          ", but its camera in the model is " +
          SizeText(camera.width, camera.height) +
          "; use the images that the model was made from.");
    }
  }
}

void CheckMasks(const colmap::Reconstruction& reconstruction,
                const std::string& mask_path) {
  if (mask_path.empty()) {
    return;
  }
  if (!fs::is_directory(mask_path)) {
    throw std::runtime_error("The mask folder " + mask_path +
                             " does not exist.");
  }
  const std::vector<std::string> names = ImageNames(reconstruction);
  if (std::none_of(names.begin(), names.end(), [&](const std::string& name) {
        return fs::exists(MaskPath(mask_path, name));
      })) {
    throw std::runtime_error(
        "The mask folder " + mask_path + " has no mask for any image, e.g. " +
        MaskPath(mask_path, names.front()) +
        "; a mask is named like its image with .png appended.");
  }
}

void CheckOutput(const StructNerfOptions& options,
                 const std::vector<std::string>& image_names) {
  const bool is_new = options.workspace_path.empty();
  const std::string& path =
      is_new ? options.output_path : options.workspace_path;
  const DenseWorkspace workspace(path);
  if (is_new && fs::exists(workspace.ImagesPath()) &&
      fs::equivalent(workspace.ImagesPath(), options.image_path)) {
    throw std::runtime_error("The output folder " + path +
                             " would overwrite the original images in " +
                             options.image_path + "; choose another one.");
  }
  RequireOneDisk(path, is_new);
  if (options.overwrite) {
    return;
  }
  const auto results = workspace.FindResults(image_names, /*limit=*/1);
  if (!results.empty()) {
    throw std::runtime_error("The folder " + path +
                             " already holds dense results (" + results[0] +
                             "); pass --overwrite to replace them" +
                             (is_new ? " or choose another folder." : "."));
  }
  if (is_new && (fs::exists(workspace.ImagesPath()) ||
                 fs::exists(workspace.SparsePath()))) {
    throw std::runtime_error(
        "The folder " + path + " already holds " +
        (HoldsModel(workspace.SparsePath())
             ? "a workspace; pass it as --workspace_path instead of "
               "--output_path to use it, or pass --overwrite to replace it."
             : "images or models; choose a new one, for instance " +
                   (fs::path(path) / "dense").string() + "."));
  }
}

void CheckOutputFile(const std::string& option, const std::string& path) {
  const std::string prefix =
      "The option --" + option + " is " + path + ", but ";
  if (!fs::is_directory(fs::absolute(path).parent_path())) {
    throw std::runtime_error(prefix + "that folder does not exist; create it.");
  }
  if (fs::is_directory(path)) {
    throw std::runtime_error(prefix +
                             "that is a folder; give the name of a file.");
  }
}

void CheckExport(const std::string& export_path) {
  if (export_path.empty()) {
    return;
  }
  CheckOutputFile("StructNeRF.export_path", export_path);
  if (fs::exists(export_path) && !IsSceneFile(export_path)) {
    throw std::runtime_error("The option --StructNeRF.export_path is " +
                             export_path +
                             ", but there is something that is not a scene; "
                             "give another name.");
  }
}

void CheckWrittenModel(const colmap::Reconstruction& original,
                       const colmap::Reconstruction& written) {
  bool is_complete = written.NumRegImages() == original.NumRegImages() &&
                     written.NumPoints3D() == original.NumPoints3D() &&
                     written.NumCameras() == original.NumCameras();
  for (const colmap::image_t image_id : RegisteredImageIds(original)) {
    const colmap::Image& image = original.Image(image_id);
    is_complete =
        is_complete && written.ExistsImage(image_id) &&
        written.Image(image_id).Name() == image.Name() &&
        written.Image(image_id).NumPoints2D() == image.NumPoints2D() &&
        written.Camera(image.CameraId()).width > 0;
  }
  for (const auto& [point3D_id, point3D] : original.Points3D()) {
    is_complete =
        is_complete && written.ExistsPoint3D(point3D_id) &&
        written.Point3D(point3D_id).xyz == point3D.xyz &&
        written.Point3D(point3D_id).track.Length() == point3D.track.Length();
  }
  if (!is_complete) {
    throw std::runtime_error(
        "The undistorted model could not be written; is the disk full?");
  }
}

colmap::Reconstruction ReadWrittenModel(const colmap::Reconstruction& original,
                                        const std::string& path) {
  colmap::Reconstruction written;
  try {
    written = ReadModel(path);
  } catch (const std::exception&) {
    throw std::runtime_error("The undistorted model in " + path +
                             " could not be written; is the disk full?");
  }
  CheckWrittenModel(original, written);
  return written;
}

std::vector<std::string> ImageNames(
    const colmap::Reconstruction& reconstruction) {
  std::vector<std::string> names;
  for (const colmap::image_t image_id : RegisteredImageIds(reconstruction)) {
    names.push_back(reconstruction.Image(image_id).Name());
  }
  return names;
}

}  // namespace structnerf
