// The embedded example from the sparse model to the mesh, against its truth.

#include "tests/end_to_end/json_files.h"
#include "tests/end_to_end/run_program.h"
#include "tests/support/synthetic_room.h"
#include "tests/support/synthetic_room_writer.h"
#include "tests/support/temp_dir.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>

#include <colmap/mvs/depth_map.h>
#include <colmap/mvs/normal_map.h>
#include <colmap/util/ply.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

using testing::HasSubstr;

struct View {
  colmap::mvs::DepthMap depth;
  colmap::mvs::NormalMap normal;

  Eigen::Vector3f Normal(int row, int col) const {
    return {normal.Get(row, col, 0),
            normal.Get(row, col, 1),
            normal.Get(row, col, 2)};
  }
};

// One run, which all tests look at.
class RoomTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    temp_dir_ = std::make_unique<TempDir>();
    room_ = std::make_unique<SyntheticRoom>(
        MakeSyntheticRoom(SyntheticRoomOptions()));
    WriteSyntheticRoom(*room_, *temp_dir_ / "room");
    result_ = RunProgram({"structnerf_dense",
                          "--image_path",
                          *temp_dir_ / "room/images",
                          "--input_path",
                          *temp_dir_ / "room/sparse/0",
                          "--output_path",
                          Dense(),
                          "--StructNeRF.quality",
                          "low",
                          "--StructNeRF.test_every=10"});
  }

  static void TearDownTestSuite() {
    room_.reset();
    temp_dir_.reset();
  }

  void SetUp() override { ASSERT_EQ(result_.exit_code, 0) << result_.error; }

  static std::string Dense() { return *temp_dir_ / "dense"; }

  static View ReadView(const std::string& name, const std::string& type) {
    const std::string file_name = name + "." + type + ".bin";
    View view;
    view.depth.Read(Dense() + "/stereo/depth_maps/" + file_name);
    view.normal.Read(Dense() + "/stereo/normal_maps/" + file_name);
    return view;
  }

  static std::unique_ptr<TempDir> temp_dir_;
  static std::unique_ptr<SyntheticRoom> room_;
  static ProgramResult result_;
};

std::unique_ptr<TempDir> RoomTest::temp_dir_;
std::unique_ptr<SyntheticRoom> RoomTest::room_;
ProgramResult RoomTest::result_;

TEST_F(RoomTest, WritesAWholeWorkspace) {
  for (const char* name : {"sparse/images.bin",
                           "stereo/patch-match.cfg",
                           "stereo/fusion.cfg",
                           "fused.ply",
                           "fused.ply.vis",
                           "structnerf/report.json",
                           "structnerf/report.txt",
                           "structnerf/field.bin"}) {
    EXPECT_GT(fs::file_size(fs::path(Dense()) / name), 0) << name;
  }
  for (const SyntheticImage& image : room_->images) {
    for (const std::string& name :
         {"images/" + image.name,
          "stereo/depth_maps/" + image.name + ".photometric.bin",
          "stereo/depth_maps/" + image.name + ".geometric.bin",
          "stereo/normal_maps/" + image.name + ".photometric.bin",
          "stereo/normal_maps/" + image.name + ".geometric.bin",
          "stereo/consistency_graphs/" + image.name + ".geometric.bin"}) {
      EXPECT_TRUE(fs::exists(fs::path(Dense()) / name)) << name;
    }
  }
  for (const auto& entry : fs::recursive_directory_iterator(Dense())) {
    EXPECT_THAT(entry.path().string(), Not(HasSubstr("partial")));
  }
}

TEST_F(RoomTest, TellsWhatTheSceneDecided) {
  const nlohmann::json report = ReadReport(Dense());
  std::vector<std::string> subjects;
  for (const nlohmann::json& decision : report["scene"]["decisions"]) {
    subjects.push_back(decision["subject"]);
    EXPECT_NE(decision["choice"], "");
    EXPECT_NE(decision["reason"], "");
    EXPECT_THAT(result_.error, HasSubstr(subjects.back() + ": "));
  }
  EXPECT_THAT(subjects,
              testing::ElementsAre("undistortion",
                                   "training images",
                                   "masks",
                                   "exposure",
                                   "scene box",
                                   "finest grid level",
                                   "grid levels",
                                   "grid table",
                                   "patches",
                                   "samples",
                                   "view-dependent colour",
                                   "source views",
                                   "planar term",
                                   "far term"));

  // Known before the run, too.
  const ProgramResult printed = RunProgram({"structnerf_dense",
                                            "--StructNeRF.print_options",
                                            "--StructNeRF.quality",
                                            "low",
                                            "--image_path",
                                            *temp_dir_ / "room/images",
                                            "--input_path",
                                            *temp_dir_ / "room/sparse/0",
                                            "--output_path",
                                            *temp_dir_ / "other"});
  ASSERT_EQ(printed.exit_code, 0) << printed.error;
  for (const char* name : {"max_resolution", "num_levels", "log2_table_size"}) {
    const std::string option = std::string("StructNeRF.") + name;
    const int value = report["options"][option];
    EXPECT_GT(value, 0);
    EXPECT_THAT(printed.out,
                HasSubstr(option + " = " + std::to_string(value) + "\n"));
  }
  EXPECT_THAT(printed.out, HasSubstr("# grid table: "));
}

TEST_F(RoomTest, TellsAPersonWhatHappens) {
  for (const std::string stage : {"Undistorting images",
                                  "Loading images",
                                  "Training",
                                  "Rendering depth maps",
                                  "Checking consistency",
                                  "Fusing points",
                                  "Averaging depth maps"}) {
    EXPECT_THAT(result_.error, HasSubstr(stage + "\n"));
    EXPECT_THAT(result_.error, HasSubstr(stage + ": done in"));
  }
  EXPECT_THAT(result_.error, HasSubstr("held-out PSNR"));
  EXPECT_THAT(result_.error, Not(HasSubstr("\r")));
  EXPECT_THAT(result_.out, HasSubstr("Pixels with depth"));
  EXPECT_THAT(result_.out, HasSubstr("Peak memory"));
}

// That nothing had to be guarded against is worth knowing, too.
TEST_F(RoomTest, ReportCountsGuards) {
  const nlohmann::json report = ReadReport(Dense());
  const nlohmann::json& guards = report["training"]["guards"];
  for (const char* name : {"non_finite_gradient",
                           "non_finite_loss",
                           "restored_snapshot",
                           "restarted_dead_field",
                           "step_without_valid_patch",
                           "view_without_points"}) {
    ASSERT_TRUE(guards.contains(name)) << name;
    EXPECT_EQ(guards[name], 0) << name;
  }
}

TEST_F(RoomTest, DepthAndNormalsAreThoseOfTheRoom) {
  size_t num_pixels = 0;
  size_t num_photometric = 0;
  size_t num_geometric = 0;
  std::vector<double> depth_errors;
  std::vector<double> normal_errors;
  const nlohmann::json report = ReadReport(Dense());
  for (size_t i = 0; i < room_->images.size(); ++i) {
    const RoomTruth truth = CastTruth(*room_, i, PixelPoint::kInteger);
    const SyntheticCamera& camera = room_->cameras[room_->images[i].camera_idx];
    const std::string& name = room_->images[i].name;
    const View photometric = ReadView(name, "photometric");
    const View geometric = ReadView(name, "geometric");
    ASSERT_EQ(photometric.depth.GetWidth(), truth.width);
    ASSERT_EQ(photometric.depth.GetHeight(), truth.height);
    size_t num_view_geometric = 0;
    for (int row = 0; row < truth.height; ++row) {
      for (int col = 0; col < truth.width; ++col) {
        ++num_pixels;
        const float depth = photometric.depth.Get(row, col);
        const Eigen::Vector3f normal = photometric.Normal(row, col);
        const float geometric_depth = geometric.depth.Get(row, col);
        if (depth == 0) {
          EXPECT_EQ(normal.norm(), 0);
          EXPECT_EQ(geometric_depth, 0);
          continue;
        }
        ++num_photometric;
        const int pixel_idx = row * truth.width + col;
        const int plane = truth.width * truth.height;
        depth_errors.push_back(std::abs(depth / truth.depth[pixel_idx] - 1));
        EXPECT_NEAR(normal.norm(), 1, 1e-3);
        const Eigen::Vector3d ray = camera.Unproject({col, row});
        EXPECT_LT(normal.dot(ray.cast<float>()), 0);
        normal_errors.push_back(
            std::acos(std::clamp(normal.dot(Eigen::Vector3f(
                                     truth.normal[pixel_idx],
                                     truth.normal[plane + pixel_idx],
                                     truth.normal[2 * plane + pixel_idx])),
                                 -1.0f,
                                 1.0f)) *
            180 / M_PI);
        if (geometric_depth != 0) {
          ++num_geometric;
          ++num_view_geometric;
          EXPECT_EQ(geometric_depth, depth);
          EXPECT_EQ(geometric.Normal(row, col), normal);
        }
      }
    }
    const auto view = std::find_if(
        report["views"].begin(), report["views"].end(), [&](const auto& view) {
          return view["name"] == name;
        });
    ASSERT_NE(view, report["views"].end()) << name;
    EXPECT_EQ((*view)["geometric_pixels"], num_view_geometric);
  }
  EXPECT_EQ(report["maps"]["photometric_pixels"], num_photometric);
  EXPECT_EQ(report["maps"]["geometric_pixels"], num_geometric);

  const auto share_within = [](const std::vector<double>& errors,
                               const double limit) {
    return std::count_if(errors.begin(),
                         errors.end(),
                         [&](double error) { return error <= limit; }) /
           static_cast<double>(errors.size());
  };
  EXPECT_GT(num_photometric, 0.9 * num_pixels);
  EXPECT_GT(num_geometric, 0.5 * num_pixels);
  EXPECT_GT(share_within(depth_errors, 0.05), 0.6);
  EXPECT_GT(share_within(normal_errors, 30), 0.5);
}

TEST_F(RoomTest, CloudLiesOnTheRoom) {
  const auto points = colmap::ReadPly(Dense() + "/fused.ply");
  ASSERT_GT(points.size(), 5000);
  // A point is right if some view sees the room's surface there.
  std::vector<RoomTruth> truths;
  for (size_t i = 0; i < room_->images.size(); ++i) {
    truths.push_back(CastTruth(*room_, i, PixelPoint::kInteger));
  }
  size_t num_right = 0;
  for (const colmap::PlyPoint& point : points) {
    bool is_right = false;
    for (size_t i = 0; i < truths.size() && !is_right; ++i) {
      const SyntheticImage& image = room_->images[i];
      const Eigen::Vector3d x = image.cam_from_world_rotation *
                                    Eigen::Vector3d(point.x, point.y, point.z) +
                                image.cam_from_world_translation;
      if (x.z() <= 0) {
        continue;
      }
      const Eigen::Vector2d xy = room_->cameras[image.camera_idx].Project(x);
      const long col = std::lround(xy.x());
      const long row = std::lround(xy.y());
      is_right = col >= 0 && row >= 0 && col < truths[i].width &&
                 row < truths[i].height &&
                 std::abs(truths[i].depth[row * truths[i].width + col] / x.z() -
                          1) < 0.03;
    }
    num_right += is_right;
  }
  EXPECT_GT(num_right, 0.6 * points.size());
}

TEST_F(RoomTest, StockFusionAndMeshersWorkOnIt) {
  const std::string fused = *temp_dir_ / "stock.ply";
  ProgramResult result = RunProgram({"stereo_fusion",
                                     "--workspace_path",
                                     Dense(),
                                     "--output_path",
                                     fused,
                                     "--StereoFusion.min_num_pixels=2"});
  EXPECT_EQ(result.exit_code, 0) << result.error;
  EXPECT_THAT(result.error, Not(HasSubstr("Ignoring image")));
  const size_t num_points = colmap::ReadPly(fused).size();
  const size_t num_own_points = colmap::ReadPly(Dense() + "/fused.ply").size();
  EXPECT_NEAR(num_points, num_own_points, 0.05 * num_own_points);

  const std::string poisson = *temp_dir_ / "poisson.ply";
  result = RunProgram({"poisson_mesher",
                       "--input_path",
                       Dense() + "/fused.ply",
                       "--output_path",
                       poisson,
                       "--PoissonMeshing.depth=7",
                       "--PoissonMeshing.trim=5",
                       "--PoissonMeshing.num_threads=1"});
  EXPECT_EQ(result.exit_code, 0) << result.error;
  EXPECT_GT(fs::file_size(poisson), 10000);

  const std::string delaunay = *temp_dir_ / "delaunay.ply";
  result = RunProgram({"delaunay_mesher",
                       "--input_path",
                       Dense(),
                       "--output_path",
                       delaunay,
                       "--DelaunayMeshing.num_threads=1"});
  EXPECT_EQ(result.exit_code, 0) << result.error;
  EXPECT_GT(fs::file_size(delaunay), 10000);
}

TEST_F(RoomTest, RunsAgainOnItsWorkspaceOnlyWhenAllowed) {
  const auto before = ReadFolder(Dense());
  std::vector<std::string> arguments = {"structnerf_dense",
                                        "--workspace_path",
                                        Dense(),
                                        "--StructNeRF.num_steps=20",
                                        "--StructNeRF.stereo_num_iterations=0"};
  const ProgramResult refused = RunProgram(arguments);
  EXPECT_EQ(refused.exit_code, EXIT_FAILURE);
  EXPECT_THAT(refused.error, HasSubstr("--overwrite"));
  EXPECT_EQ(ReadFolder(Dense()), before);

  // In a copy, since the tests share the workspace.
  const std::string copy = *temp_dir_ / "copy";
  fs::copy(Dense(), copy, fs::copy_options::recursive);
  arguments[2] = copy;
  arguments.push_back("--overwrite");
  const ProgramResult result = RunProgram(arguments);
  EXPECT_EQ(result.exit_code, 0) << result.error;
  const auto after = ReadFolder(copy);
  ASSERT_EQ(after.size(), before.size());
  for (const auto& [name, content] : after) {
    if (name.rfind("images", 0) == 0 || name.rfind("sparse", 0) == 0) {
      EXPECT_EQ(content, before.at(name)) << name;
    } else if (name.find("depth_maps/") != std::string::npos) {
      EXPECT_NE(content, before.at(name)) << name;
    }
  }
}

#ifndef __SANITIZE_ADDRESS__  // which takes as much again
TEST_F(RoomTest, NeedsTheMemoryThatWasExpected) {
  const nlohmann::json memory = ReadReport(Dense())["memory"];
  const auto peak = memory["peak_bytes"].get<double>();
  EXPECT_NEAR(memory["expected_bytes"].get<double>(), peak, 0.2 * peak);
}

TEST_F(RoomTest, StaysWithinItsMemory) {
  const ProgramResult result = RunProgram({"structnerf_dense",
                                           "--image_path",
                                           *temp_dir_ / "room/images",
                                           "--input_path",
                                           *temp_dir_ / "room/sparse/0",
                                           "--output_path",
                                           *temp_dir_ / "small",
                                           "--StructNeRF.num_steps=10",
                                           "--StructNeRF.stereo_num_iterations",
                                           "1",
                                           "--StructNeRF.max_memory_gb=0.35"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const nlohmann::json report = ReadReport(*temp_dir_ / "small");
  EXPECT_LE(report["memory"]["peak_bytes"], report["memory"]["limit_bytes"]);
}
#endif

}  // namespace
}  // namespace structnerf
