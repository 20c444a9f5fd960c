#include "nerf/tools/maps_folder.h"

#include "nerf/extract/consistency.h"
#include "nerf/extract/depth_averaging.h"
#include "nerf/util/array_file.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

// "folder" of "folder/" and "folder/.", so that a name can be put beside it.
std::string WithoutSlash(const std::string& path) {
  const fs::path normal = fs::path(path).lexically_normal();
  return (normal.has_filename() ? normal : normal.parent_path()).string();
}

// A folder beside the one that is wanted, until it is complete.
class PartialFolder {
 public:
  explicit PartialFolder(const std::string& path)
      : path_(WithoutSlash(path)), partial_path_(path_ + ".partial") {
    if (fs::exists(path_)) {
      throw std::runtime_error("The folder " + path_ +
                               " exists already; give another one.");
    }
    std::error_code error;
    fs::remove_all(partial_path_, error);
    fs::create_directories(partial_path_, error);
    ThrowIf(error);
  }

  ~PartialFolder() {
    std::error_code ignored;
    fs::remove_all(partial_path_, ignored);
  }

  PartialFolder(const PartialFolder&) = delete;
  PartialFolder& operator=(const PartialFolder&) = delete;

  void Write(const std::string& name,
             const int width,
             const int height,
             const std::vector<float>& values) const {
    const fs::path path = fs::path(partial_path_) / name;
    std::error_code error;
    fs::create_directories(path.parent_path(), error);
    ThrowIf(error);
    WriteArrayFile(path.string(), width, height, values);
  }

  void Commit() {
    std::error_code error;
    fs::rename(partial_path_, path_, error);
    ThrowIf(error);
  }

 private:
  void ThrowIf(const std::error_code& error) const {
    if (error) {
      throw std::runtime_error("The folder " + path_ +
                               " could not be written: " + error.message() +
                               ".");
    }
  }

  const std::string path_;
  const std::string partial_path_;
};

void ApplyMask(const View& view, DenseMaps* maps) {
  if (view.mask.empty()) {
    return;
  }
  const size_t width = maps->width;
  KeepOnly(
      [&](const size_t pixel) {
        const size_t col = pixel % width * view.image.width / width;
        const size_t row = pixel / width * view.image.height / maps->height;
        return view.mask[row * view.image.width + col] != 0;
      },
      maps);
}

// Depth of the pixels that are confirmed, of all views.
std::vector<DenseMaps> ConfirmedDepth(
    const std::vector<DenseMaps>& all_maps,
    const std::vector<std::vector<uint8_t>>& is_confirmed) {
  std::vector<DenseMaps> all_confirmed;
  for (size_t i = 0; i < all_maps.size(); ++i) {
    DenseMaps& confirmed = all_confirmed.emplace_back();
    confirmed.width = all_maps[i].width;
    confirmed.height = all_maps[i].height;
    for (size_t pixel = 0; pixel < all_maps[i].depth.size(); ++pixel) {
      confirmed.depth.push_back(
          is_confirmed[i][pixel] != 0 ? all_maps[i].depth[pixel] : 0.0f);
    }
  }
  return all_confirmed;
}

size_t NumDepths(const DenseMaps& maps) {
  return maps.depth.size() -
         std::count(maps.depth.begin(), maps.depth.end(), 0.0f);
}

void WriteMaps(const PartialFolder& folder,
               const std::string& view_name,
               const char* type,
               const DenseMaps& maps) {
  const std::string file_name = view_name + "." + type + ".bin";
  folder.Write(
      "stereo/depth_maps/" + file_name, maps.width, maps.height, maps.depth);
  folder.Write(
      "stereo/normal_maps/" + file_name, maps.width, maps.height, maps.normal);
}

// About the first view whose image has another size than these options would
// have given it; empty if there is none.
std::string ImageSizeWarning(const std::vector<View>& views,
                             const int max_image_size) {
  for (const View& view : views) {
    const int size = std::max(view.image.width, view.image.height);
    const int usual_size = std::min(
        max_image_size, std::max(view.camera.width, view.camera.height));
    if (size != usual_size) {
      return "The image of " + view.name + " has " + std::to_string(size) +
             " pixels along its longer side, where this quality has " +
             std::to_string(usual_size) +
             "; export the scene with the same quality.";
    }
  }
  return "";
}

// If `exposure` asks for what the scene does not have; else empty.
std::string ExposureWarning(const std::vector<View>& views,
                            const std::string& exposure) {
  const bool has_exposures =
      std::any_of(views.begin(), views.end(), [](const View& view) {
        return view.exposure.gain != Eigen::Vector3f::Ones() ||
               view.exposure.offset != Eigen::Vector3f::Zero();
      });
  return exposure == "none" || has_exposures
             ? ""
             : "The scene takes the exposures of all images to be equal, so "
               "--StructNeRF.exposure " +
                   exposure +
                   " changes nothing; they are measured when a scene is "
                   "exported with that option.";
}

// The maps before other views have confirmed them, of all views. With matching,
// `fields` receives those of the field.
std::vector<DenseMaps> RenderMaps(const std::vector<View>& views,
                                  Reconstructor* reconstructor,
                                  std::vector<DenseMaps>* fields,
                                  Progress* progress) {
  const ReconstructionOptions& options = reconstructor->Options();
  SilentProgress view_progress(progress);
  std::vector<DenseMaps> all_maps;
  for (size_t i = 0; i < views.size(); ++i) {
    DenseMaps* const field =
        options.MatchesViews() ? &fields->emplace_back() : nullptr;
    all_maps.push_back(reconstructor->RenderView(i, &view_progress, field));
    if (field != nullptr) {
      field->relative_std = std::vector<float>();
    }
    reconstructor->AddMaps(i, all_maps.back());
    ReportItems("Rendering depth maps", i + 1, views.size(), progress);
  }
  const std::string completion_name =
      options.CompletesPlanes() ? "Completing planes" : "Finishing depth maps";
  reconstructor->FindPlanes(&view_progress);
  for (size_t i = 0; i < views.size(); ++i) {
    DenseMaps& maps = all_maps[i];
    reconstructor->CompletePlanes(i, &maps);
    maps.relative_std = std::vector<float>();
    maps.distinctness = std::vector<float>();
    ApplyMask(views[i], &maps);
    ReportItems(completion_name, i + 1, views.size(), progress);
  }
  return all_maps;
}

}  // namespace

MapsSummary ReconstructIntoFolder(
    Scene scene,
    const ReconstructionOptions& options,
    const EngineFactory& make_engine,
    const std::string& path,
    const std::function<void(const std::string&)>& warn,
    Progress* progress) {
  PartialFolder folder(path);
  Scene poses;  // what is needed of the scene after training
  for (const View& view : scene.views) {
    View& pose = poses.views.emplace_back(PoseOf(view));
    pose.image.width = view.image.width;
    pose.image.height = view.image.height;
    pose.mask = view.mask;
  }
  const std::string exposure_warning =
      ExposureWarning(scene.views, options.loss.exposure);
  Reconstructor reconstructor(std::move(scene), options, make_engine);
  std::vector<std::string> warnings = reconstructor.Warnings();
  warnings.push_back(exposure_warning);
  warnings.push_back(
      ImageSizeWarning(poses.views, options.training.max_image_size));
  for (const std::string& warning : warnings) {
    if (!warning.empty()) {
      warn(warning);
    }
  }
  reconstructor.Train(progress);
  MapsSummary summary;
  summary.training = reconstructor.Summary();

  const auto begin = std::chrono::steady_clock::now();
  std::vector<DenseMaps> fields;
  std::vector<DenseMaps> all_maps =
      RenderMaps(poses.views, &reconstructor, &fields, progress);
  ThreadPool pool(options.training.num_threads);
  const ExtractionOptions& extraction = reconstructor.Options().extraction;
  std::vector<std::vector<uint8_t>> is_confirmed;
  for (size_t i = 0; i < all_maps.size(); ++i) {
    is_confirmed.push_back(CheckConsistency(poses,
                                            all_maps,
                                            i,
                                            reconstructor.SourceViews()[i],
                                            extraction,
                                            &pool,
                                            progress)
                               .is_confirmed);
    ReportItems("Checking consistency", i + 1, all_maps.size(), progress);
  }
  const bool averages_depth = reconstructor.Options().AveragesDepth();
  const std::vector<DenseMaps> confirmed =
      averages_depth ? ConfirmedDepth(all_maps, is_confirmed)
                     : std::vector<DenseMaps>();
  for (size_t i = 0; i < all_maps.size(); ++i) {
    const std::string& name = poses.views[i].name;
    DenseMaps& maps = all_maps[i];
    if (!fields.empty()) {
      ReplaceUnconfirmed(is_confirmed[i], fields[i], &maps);
    }
    if (averages_depth) {
      is_confirmed[i] = AverageDepth(poses,
                                     confirmed,
                                     i,
                                     reconstructor.AveragingViews()[i],
                                     extraction,
                                     &pool,
                                     progress,
                                     &maps.depth)
                            .is_confirmed;
    }
    WriteMaps(folder, name, "photometric", maps);
    summary.num_pixels += maps.depth.size();
    summary.num_photometric += NumDepths(maps);
    KeepOnly([&](const size_t pixel) { return is_confirmed[i][pixel] != 0; },
             &maps);
    WriteMaps(folder, name, "geometric", maps);
    summary.num_geometric += NumDepths(maps);
    ReportItems("Writing depth maps", i + 1, all_maps.size(), progress);
  }
  folder.Commit();
  summary.map_seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin)
          .count();
  return summary;
}

}  // namespace structnerf
