// Runs the program as a user does.

#include "nerf/engine/render_engine.h"
#include "nerf/reconstructor.h"
#include "nerf/scene_file.h"
#include "nerf/tools/maps_folder.h"
#include "nerf/util/array_file.h"
#include "tests/support/synthetic_room.h"
#include "tests/support/temp_dir.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

namespace structnerf {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr char kSmallRun[] =
    "--StructNeRF.quality=low --StructNeRF.num_steps=40 "
    "--StructNeRF.rays_per_step=128 --StructNeRF.log2_table_size=12 "
    "--StructNeRF.stereo_num_iterations=2";

ReconstructionOptions SmallRun() {
  ReconstructionOptions options = QualityPreset("low");
  options.training.num_steps = 40;
  options.training.rays_per_step = 128;
  options.field.log2_table_size = 12;
  options.stereo.num_iterations = 2;
  return options;
}

class StructnerfTrainTest : public testing::Test {
 protected:
  StructnerfTrainTest() {
    static const Scene scene = []() {
      SyntheticRoomOptions options;
      options.num_views = 4;
      options.width = 48;
      options.height = 36;
      options.sub_folders = true;
      return MakeScene(MakeSyntheticRoom(options));
    }();
    scene_ = scene;
  }

  // Returns the exit code; what was printed is in `output_`.
  int Run(const std::string& arguments) {
    const std::string log = folder_ / "log";
    const std::string command = "'" TRAIN_PROGRAM "' --scene_path='" +
                                folder_ / "scene.bin" + "' --output_path='" +
                                MapsPath() + "' " + arguments + " >'" + log +
                                "' 2>&1";
    const int status = std::system(command.c_str());
    std::ifstream file(log);
    output_.assign(std::istreambuf_iterator<char>(file), {});
    return WEXITSTATUS(status);
  }

  std::string MapsPath() const { return folder_ / "maps"; }

  FloatArray ReadMap(const std::string& folder,
                     const std::string& name,
                     const size_t num_planes) const {
    return ReadArrayFile(MapsPath() + "/stereo/" + folder + "/" + name + ".bin",
                         num_planes);
  }

  TempDir folder_;
  Scene scene_;
  std::string output_;
};

TEST_F(StructnerfTrainTest, MapsAreThoseOfTheMethod) {
  // The left half of a view is masked.
  View& masked = scene_.views[1];
  masked.mask.assign(48 * 36, 255);
  for (int row = 0; row < 36; ++row) {
    std::fill_n(masked.mask.begin() + row * 48, 24, 0);
  }
  WriteScene(scene_, folder_ / "scene.bin");
  ASSERT_EQ(Run(std::string(kSmallRun) + " --StructNeRF.averaging_num_views=0"),
            0)
      << output_;
  EXPECT_THAT(output_, HasSubstr("40 steps"));
  EXPECT_THAT(output_, HasSubstr("Rendering depth maps"));
  EXPECT_THAT(output_, Not(HasSubstr("longer side")));

  Reconstructor reconstructor(scene_, SmallRun());
  Progress progress;
  reconstructor.Train(&progress);
  std::vector<DenseMaps> all_maps;
  std::vector<DenseMaps> fields(scene_.views.size());
  for (size_t i = 0; i < scene_.views.size(); ++i) {
    all_maps.push_back(reconstructor.RenderView(i, &progress, &fields[i]));
    reconstructor.AddMaps(i, all_maps.back());
  }
  reconstructor.FindPlanes(&progress);
  size_t num_geometric = 0;
  size_t num_of_field = 0;
  for (size_t i = 0; i < scene_.views.size(); ++i) {
    DenseMaps& completed = all_maps[i];
    reconstructor.CompletePlanes(i, &completed);
    const std::string& name = scene_.views[i].name;
    const FloatArray depth = ReadMap("depth_maps", name + ".photometric", 1);
    const FloatArray normal = ReadMap("normal_maps", name + ".photometric", 3);
    const FloatArray confirmed = ReadMap("depth_maps", name + ".geometric", 1);
    ASSERT_EQ(depth.width, 48);
    ASSERT_EQ(depth.height, 36);
    const size_t num_pixels = completed.depth.size();
    for (size_t pixel = 0; pixel < num_pixels; ++pixel) {
      const bool is_masked = i == 1 && pixel % 48 < 24;
      const bool is_confirmed = confirmed.values[pixel] != 0;
      const DenseMaps& maps = is_confirmed ? completed : fields[i];
      num_of_field += !is_masked && !is_confirmed &&
                      completed.depth[pixel] != maps.depth[pixel];
      EXPECT_EQ(depth.values[pixel], is_masked ? 0 : maps.depth[pixel]);
      EXPECT_EQ(normal.values[2 * num_pixels + pixel],
                is_masked ? 0 : maps.normal[2 * num_pixels + pixel]);
      if (is_confirmed) {
        ++num_geometric;
        EXPECT_EQ(confirmed.values[pixel], depth.values[pixel]);
      }
    }
  }
  EXPECT_GT(num_geometric, 0u);
  EXPECT_LT(num_geometric, 4u * 48 * 36);
  EXPECT_GT(num_of_field, 0u);
}

TEST_F(StructnerfTrainTest, DepthIsAveragedOverViews) {
  WriteScene(scene_, folder_ / "scene.bin");
  const std::string name = scene_.views[0].name;
  // Whether two views of a field that has learned so little agree is chance.
  const std::string lenient_run =
      std::string(kSmallRun) +
      " --StructNeRF.averaging_max_depth_error=0.5"
      " --StructNeRF.min_num_consistent=1 --StructNeRF.averaging_num_views=";
  ASSERT_EQ(Run(lenient_run + "0"), 0) << output_;
  const FloatArray own = ReadMap("depth_maps", name + ".photometric", 1);
  std::filesystem::remove_all(MapsPath());

  ASSERT_EQ(Run(lenient_run + "3"), 0) << output_;
  const FloatArray mean = ReadMap("depth_maps", name + ".photometric", 1);
  const FloatArray geometric = ReadMap("depth_maps", name + ".geometric", 1);
  size_t num_geometric = 0;
  size_t num_changed = 0;
  for (size_t pixel = 0; pixel < own.values.size(); ++pixel) {
    const bool is_changed = mean.values[pixel] != own.values[pixel];
    const bool is_geometric = geometric.values[pixel] != 0;
    num_changed += is_changed;
    num_geometric += is_geometric;
    if (is_geometric) {
      EXPECT_EQ(geometric.values[pixel], mean.values[pixel]);
    }
  }
  EXPECT_GT(num_changed, own.values.size() / 10);
  EXPECT_GT(num_geometric, own.values.size() / 10);
}

TEST_F(StructnerfTrainTest, SaysWhatIsWrongAndWritesNothing) {
  const auto expect_error = [&](const std::string& arguments,
                                const std::string& message) {
    EXPECT_EQ(Run(arguments), EXIT_FAILURE);
    EXPECT_THAT(output_, HasSubstr(message));
    EXPECT_EQ(std::count(output_.begin(), output_.end(), '\n'), 1) << output_;
    EXPECT_FALSE(std::filesystem::exists(MapsPath()));
    EXPECT_FALSE(std::filesystem::exists(MapsPath() + ".partial"));
  };
  expect_error("", "scene.bin");
  std::ofstream(folder_ / "scene.bin") << "a photograph of a room";
  expect_error("", "scene.bin is not a scene");
  WriteScene(Scene(), folder_ / "scene.bin");
  expect_error("", "fewer than two registered images");
  expect_error("--StructNeRF.device=tpu", "must be auto, cpu or cuda");
  expect_error("--output_path=" + folder_ / "log/maps", "could not be written");
}

TEST_F(StructnerfTrainTest, WarnsOfImagesOfAnotherQuality) {
  ReconstructionOptions options = SmallRun();
  options.training.num_steps = 1;
  options.training.max_image_size = 32;
  std::string warnings;
  Progress progress;
  ReconstructIntoFolder(
      scene_,
      options,
      MakeGridEngine,
      MapsPath(),
      [&](const std::string& warning) { warnings += warning; },
      &progress);
  EXPECT_THAT(warnings, HasSubstr("has 48 pixels along its longer side"));
  EXPECT_THAT(warnings, HasSubstr("has 32; export"));
}

TEST_F(StructnerfTrainTest, WarnsOfExposuresThatTheSceneDoesNotHave) {
  ReconstructionOptions options = SmallRun();
  options.training.num_steps = 1;
  Progress progress;
  std::string warnings;
  const auto run = [&](const std::string& path) {
    warnings.clear();
    ReconstructIntoFolder(
        scene_,
        options,
        MakeGridEngine,
        path,
        [&](const std::string& warning) { warnings += warning; },
        &progress);
  };
  run(folder_ / "none");
  EXPECT_THAT(warnings, Not(HasSubstr("exposure")));
  options.loss.exposure = "auto";
  run(folder_ / "auto");
  EXPECT_THAT(warnings,
              HasSubstr("--StructNeRF.exposure auto changes nothing"));
  scene_.views[0].exposure.offset.x() = 0.1f;
  run(folder_ / "with");
  EXPECT_THAT(warnings, Not(HasSubstr("exposure")));
}

TEST_F(StructnerfTrainTest, FoldersMayEndInASlash) {
  WriteScene(scene_, folder_ / "scene.bin");
  const std::string path = folder_ / "parent/with_slash";
  ASSERT_EQ(Run(std::string(kSmallRun) + " --output_path='" + path + "/'"), 0)
      << output_;
  EXPECT_TRUE(std::filesystem::exists(path + "/stereo/depth_maps"));
  EXPECT_EQ(Run(std::string(kSmallRun) + " --output_path='" + path + "/.'"),
            EXIT_FAILURE);
  EXPECT_THAT(output_, HasSubstr("exists already"));
}

TEST_F(StructnerfTrainTest, AbortingLeavesNothing) {
  class AbortingProgress : public Progress {
   public:
    void Report(const ProgressUpdate& update) override {
      if (update.stage == "Writing depth maps") {
        // Maps of a view have been written by now.
        EXPECT_TRUE(std::filesystem::exists(path + ".partial"));
        is_aborting = true;
      }
    }
    bool ShouldAbort() override { return is_aborting; }

    std::string path;
    bool is_aborting = false;
  };
  AbortingProgress progress;
  progress.path = MapsPath();
  EXPECT_THROW(ReconstructIntoFolder(
                   scene_,
                   SmallRun(),
                   MakeGridEngine,
                   MapsPath(),
                   [](const std::string&) {},
                   &progress),
               Aborted);
  EXPECT_TRUE(progress.is_aborting);
  EXPECT_TRUE(std::filesystem::is_empty(folder_.Path()));
}

TEST_F(StructnerfTrainTest, FoldersAreNotReplaced) {
  WriteScene(scene_, folder_ / "scene.bin");
  std::filesystem::create_directory(MapsPath());
  EXPECT_EQ(Run(kSmallRun), EXIT_FAILURE);
  EXPECT_THAT(output_, HasSubstr("exists already"));
  EXPECT_TRUE(std::filesystem::is_empty(MapsPath()));
}

TEST_F(StructnerfTrainTest, HelpListsOptions) {
  EXPECT_EQ(Run("--StructNeRF.no_such_option=1"), EXIT_FAILURE);
  EXPECT_THAT(output_, HasSubstr("--help"));
  EXPECT_EQ(
      std::system("'" TRAIN_PROGRAM "' --help | grep -q StructNeRF.num_steps"),
      0);
}

}  // namespace
}  // namespace structnerf
