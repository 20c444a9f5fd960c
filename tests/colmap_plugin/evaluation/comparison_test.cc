#include "colmap_plugin/evaluation/comparison.h"

#include "colmap_plugin/dense_workspace.h"
#include "colmap_plugin/evaluation/comparison_report.h"
#include "tests/colmap_plugin/tiny_model.h"
#include "tests/support/temp_dir.h"

#include <algorithm>
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

namespace structnerf {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::Not;

// Two workspaces of a wall in a depth of 4 units, which is 2 metres.
class ComparisonTest : public testing::Test {
 protected:
  ComparisonTest()
      : workspaces_{DenseWorkspace(temp_dir_ / "a"),
                    DenseWorkspace(temp_dir_ / "b")} {
    TinyModel model = MakeTinyModel(3);
    model.images[2].name = "<&>.png";
    for (size_t i = 0; i < 2; ++i) {
      model.WriteModel(workspaces_[i].SparsePath());
      model.WriteImages(workspaces_[i].ImagesPath());
      workspaces_[i].CreateFolders({"0.png", "1.png", "<&>.png"});
      options_.workspace_paths[i] = workspaces_[i].Path();
    }
  }

  // Depth in the left part of the image only.
  void WriteMaps(const size_t workspace_idx,
                 const std::string& name,
                 const float depth,
                 const int num_cols,
                 const MapType type = MapType::kGeometric) const {
    StereoMaps maps{64,
                    48,
                    std::vector<float>(64 * 48, 0.0f),
                    std::vector<float>(3 * 64 * 48, 0.0f)};
    for (int row = 0; row < 48; ++row) {
      std::fill_n(maps.depth.begin() + row * 64, num_cols, depth);
    }
    workspaces_[workspace_idx].WriteMaps(name, type, maps);
  }

  void WriteTruth() {
    std::filesystem::create_directories(temp_dir_ / "depth");
    for (const char* name : {"0.png", "1.png"}) {
      cv::imwrite(temp_dir_ / "depth/" + name,
                  cv::Mat(48, 64, CV_16UC1, cv::Scalar(2000)));
    }
    options_.truth.path = temp_dir_ / "depth";
  }

  std::string Error() {
    try {
      Compare(options_, &progress_);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  }

  TempDir temp_dir_;
  std::array<DenseWorkspace, 2> workspaces_;
  ComparisonOptions options_;
  RunProgress progress_;
};

TEST_F(ComparisonTest, MeasuresCoverageAndAgreement) {
  WriteMaps(0, "0.png", 4, 64);
  WriteMaps(1, "0.png", 4.06f, 32);
  WriteMaps(0, "1.png", 4, 32);
  WriteMaps(1, "1.png", 4.02f, 64);
  WriteMaps(0, "<&>.png", 4, 64);
  const Comparison comparison = Compare(options_, &progress_);
  EXPECT_NEAR(comparison.a_per_b, 1, 1e-9);
  EXPECT_NEAR(comparison.workspaces[0].coverage, 2.5 / 3, 1e-9);
  EXPECT_NEAR(comparison.workspaces[1].coverage, 1.5 / 3, 1e-9);
  // Half of each of two views, of which one differs by 1.5 %, one by 0.5 %.
  EXPECT_EQ(comparison.agreement.num_common, 2 * 48 * 32);
  EXPECT_DOUBLE_EQ(comparison.agreement.shares[0], 0.5);
  EXPECT_DOUBLE_EQ(comparison.agreement.shares[1], 1);
  EXPECT_NEAR(comparison.agreement.median_difference, 0.01, 1e-5);
  ASSERT_EQ(comparison.views.size(), 3);
  EXPECT_EQ(comparison.views[0].name, "0.png");
  EXPECT_DOUBLE_EQ(comparison.views[0].coverage[1], 0.5);
  EXPECT_EQ(comparison.views[2].agreement.num_common, 0);
  EXPECT_FALSE(comparison.is_metric);
}

TEST_F(ComparisonTest, ComparesBothWithTheTruth) {
  for (const char* name : {"0.png", "1.png"}) {
    WriteMaps(0, name, 4.1f, 64);
    WriteMaps(1, name, 4, 32);
  }
  WriteTruth();
  const Comparison comparison = Compare(options_, &progress_);
  EXPECT_TRUE(comparison.is_metric);
  EXPECT_NEAR(*comparison.views[0].median_error[0], 0.05, 1e-6);
  EXPECT_NEAR(*comparison.views[0].median_error[1], 0, 1e-6);
  EXPECT_FALSE(comparison.views[2].median_error[0].has_value());
  const auto json = nlohmann::json::parse(ComparisonJson(comparison));
  EXPECT_NEAR(json["workspaces"][0]["evaluation"]["maps"]["geometric"]
                  ["sfm_scale"]["all"]["within_2cm"],
              0,
              1e-9);
  EXPECT_NEAR(json["workspaces"][1]["evaluation"]["maps"]["geometric"]
                  ["sfm_scale"]["all"]["within_2cm"],
              0.5,
              1e-9);
  EXPECT_TRUE(json["workspaces"][0]["seconds"].is_null());
  EXPECT_THAT(ComparisonText(comparison), HasSubstr("Within 5 cm, %"));
}

TEST_F(ComparisonTest, NothingIsNotPerfect) {
  WriteMaps(0, "0.png", 4, 64);
  WriteMaps(1, "0.png", 0, 64);
  WriteTruth();
  const Comparison comparison = Compare(options_, &progress_);
  for (const ComparisonRow& row : ComparisonRows(comparison)) {
    if (row.name.find("where there is depth") != std::string::npos) {
      EXPECT_NE(row.values[0], "-") << row.name;
      EXPECT_EQ(row.values[1], "-") << row.name;
    }
  }
  const auto json = nlohmann::json::parse(ComparisonJson(comparison));
  EXPECT_TRUE(json["agreement"]["median_relative_difference"].is_null());
}

TEST_F(ComparisonTest, PageShowsAllViewsAndNeedsNoOtherFile) {
  for (size_t i = 0; i < 2; ++i) {
    for (const char* name : {"0.png", "1.png", "<&>.png"}) {
      WriteMaps(i, name, 4, 64);
    }
  }
  WriteTruth();
  const std::string html = ComparisonHtml(Compare(options_, &progress_));
  for (const char* name : {"0.png", "1.png", "&lt;&amp;&gt;.png"}) {
    EXPECT_THAT(html, HasSubstr("<h2>" + std::string(name) + "</h2>"));
    for (const char* caption : {"Photograph",
                                "Depth A",
                                "Depth B",
                                "Difference of depths",
                                "Normals A",
                                "Normals B"}) {
      EXPECT_THAT(
          html,
          HasSubstr("alt=\"" + std::string(caption) + " of " + name + "\""));
    }
  }
  EXPECT_THAT(html, HasSubstr("alt=\"Error B of 1.png\""));
  EXPECT_THAT(html, HasSubstr("alt=\"Whose error is smaller of 1.png\""));
  EXPECT_THAT(html, Not(HasSubstr("<&>")));
  // Every picture is inside.
  size_t num_images = 0;
  for (size_t place = html.find(" src=\""); place != std::string::npos;
       place = html.find(" src=\"", place + 1)) {
    EXPECT_EQ(html.compare(place + 6, 11, "data:image/"), 0);
    ++num_images;
  }
  EXPECT_EQ(num_images, 4 + 3 * 6 + 2 * 4);  // 4 scales
  EXPECT_THAT(html, Not(HasSubstr("http")));
}

TEST_F(ComparisonTest, PageLeavesOutErrorsOfMapsThatAreMissing) {
  WriteMaps(0, "0.png", 4, 64);
  WriteMaps(0, "1.png", 4, 64);
  WriteMaps(1, "1.png", 4, 64);
  WriteTruth();
  const std::string html = ComparisonHtml(Compare(options_, &progress_));
  EXPECT_THAT(html, HasSubstr("alt=\"Error A of 0.png\""));
  EXPECT_THAT(html, HasSubstr("alt=\"Error B of 1.png\""));
  EXPECT_THAT(html, Not(HasSubstr("alt=\"Error B of 0.png\"")));
}

TEST_F(ComparisonTest, PicturesSomeViewsAndMeasuresAll) {
  for (size_t i = 0; i < 2; ++i) {
    for (const char* name : {"0.png", "1.png", "<&>.png"}) {
      WriteMaps(i, name, 4, 64);
    }
  }
  options_.max_pictured_views = 2;
  const Comparison comparison = Compare(options_, &progress_);
  EXPECT_EQ(comparison.agreement.num_common, 3 * 48 * 64);
  EXPECT_EQ(std::count_if(comparison.views.begin(),
                          comparison.views.end(),
                          [](const ViewComparison& view) {
                            return !view.pictures.empty();
                          }),
            2);
  EXPECT_THAT(ComparisonHtml(comparison), HasSubstr("2 of 3 views are shown"));
}

// A model of its own has its own unit.
TEST_F(ComparisonTest, ComparesInTheUnitOfA) {
  TinyModel model = MakeTinyModel(3);
  model.images[2].name = "<&>.png";
  for (TinyModel::Image& image : model.images) {
    image.x *= 10;
  }
  for (Eigen::Vector3d& point : model.points) {
    point *= 10;
  }
  model.WriteModel(workspaces_[1].SparsePath());
  WriteMaps(0, "0.png", 4, 64);
  WriteMaps(1, "0.png", 40, 64);
  const Comparison comparison = Compare(options_, &progress_);
  EXPECT_NEAR(comparison.a_per_b, 0.1, 1e-9);
  EXPECT_NEAR(comparison.agreement.median_difference, 0, 1e-6);
  EXPECT_NEAR(comparison.farthest_depth, 4, 1e-5);
}

// PatchMatch can be told to reduce the images.
TEST_F(ComparisonTest, TakesMapsOfReducedImages) {
  WriteMaps(0, "0.png", 4, 64);
  WriteMaps(0, "1.png", 4, 64);
  StereoMaps reduced{32,
                     24,
                     std::vector<float>(32 * 24, 4.0f),
                     std::vector<float>(3 * 32 * 24, 0.0f)};
  workspaces_[1].WriteMaps("0.png", MapType::kGeometric, reduced);
  const Comparison comparison = Compare(options_, &progress_);
  EXPECT_DOUBLE_EQ(comparison.views[0].coverage[1], 1);
  EXPECT_EQ(comparison.agreement.num_common, 64 * 48);
  EXPECT_NEAR(comparison.workspaces[1].coverage, 1.0 / 3, 1e-9);
}

TEST_F(ComparisonTest, TakesTheTypeThatBothHave) {
  for (size_t i = 0; i < 2; ++i) {
    WriteMaps(i, "0.png", 4, 64, MapType::kPhotometric);
  }
  WriteMaps(0, "0.png", 4, 32);
  const Comparison comparison = Compare(options_, &progress_);
  EXPECT_EQ(comparison.workspaces[0].map_type, MapType::kPhotometric);
  EXPECT_EQ(comparison.workspaces[1].map_type, MapType::kPhotometric);
  EXPECT_EQ(comparison.agreement.num_common, 64 * 48);
  EXPECT_THAT(comparison.notes, Contains(HasSubstr("B has no geometric")));
}

TEST_F(ComparisonTest, TakesWhatEachHasIfTheyShareNoType) {
  WriteMaps(0, "0.png", 4, 64, MapType::kPhotometric);
  WriteMaps(1, "0.png", 4, 64);
  const Comparison comparison = Compare(options_, &progress_);
  EXPECT_EQ(comparison.workspaces[0].map_type, MapType::kPhotometric);
  EXPECT_EQ(comparison.workspaces[1].map_type, MapType::kGeometric);
  EXPECT_EQ(comparison.agreement.num_common, 64 * 48);
  EXPECT_THAT(comparison.notes, Contains(HasSubstr("A has no geometric")));
  EXPECT_THAT(comparison.notes, Contains(HasSubstr("no report")));
}

TEST_F(ComparisonTest, OneErrorForBadInput) {
  EXPECT_THAT(Error(), HasSubstr("has no depth maps"));
  WriteMaps(0, "0.png", 4, 64);
  WriteMaps(1, "0.png", 4, 64);
  options_.map_type = "other";
  EXPECT_THAT(Error(), HasSubstr("--input_type"));
  options_.map_type = "geometric";
  options_.picture_size = 0;
  EXPECT_THAT(Error(), HasSubstr("--picture_size"));
  options_.picture_size = 320;
  TinyModel other = MakeTinyModel(3);
  for (TinyModel::Image& image : other.images) {
    image.name = "other_" + image.name;
  }
  other.WriteModel(workspaces_[1].SparsePath());
  workspaces_[1].CreateFolders({"other_0.png"});
  WriteMaps(1, "other_0.png", 4, 64);
  EXPECT_THAT(Error(), HasSubstr("have no image in common"));
  options_.workspace_paths[1] = temp_dir_ / "none";
  EXPECT_THAT(Error(), HasSubstr("does not exist"));
  options_.workspace_paths[1].clear();
  EXPECT_THAT(Error(), HasSubstr("Two workspaces are needed"));
}

}  // namespace
}  // namespace structnerf
