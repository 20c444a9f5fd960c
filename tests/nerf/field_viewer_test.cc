#include "nerf/field_viewer.h"

#include "nerf/reconstructor.h"
#include "tests/support/synthetic_room.h"
#include "tests/support/temp_dir.h"

#include <cmath>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

// A field that was trained on a small room and saved.
class FieldViewerTest : public testing::Test {
 protected:
  struct Training {
    Training() {
      SyntheticRoomOptions room_options;
      room_options.num_views = 6;
      room_options.width = 96;
      room_options.height = 72;
      scene = MakeScene(MakeSyntheticRoom(room_options));
      options.field.log2_table_size = 15;
      options.sampling.cache_resolution = 64;
      options.training.num_steps = 150;
      options.training.rays_per_step = 256;
      options.stereo.num_iterations = 0;
      Progress progress;
      Reconstructor reconstructor(scene, options);
      reconstructor.Train(&progress);
      reconstructor.SaveField(temp_dir / "field.bin");
      maps = reconstructor.RenderView(1, &progress);
    }

    TempDir temp_dir;
    Scene scene;
    ReconstructionOptions options;
    DenseMaps maps;  // of view 1
  };

  static void SetUpTestSuite() { training_ = new Training(); }
  static void TearDownTestSuite() { delete training_; }

  static const Training* training_;

  const std::string path_ = training_->temp_dir / "field.bin";
  Scene scene_ = training_->scene;
  const ReconstructionOptions options_ = training_->options;
  const DenseMaps& maps_ = training_->maps;
  Progress progress_;
};

const FieldViewerTest::Training* FieldViewerTest::training_ = nullptr;

TEST_F(FieldViewerTest, SeesWhatWasTrainedWithoutPhotographs) {
  const RgbImage photograph = scene_.views[1].image;
  for (View& view : scene_.views) {
    view.image = RgbImage();
  }
  const FieldViewer viewer(scene_, options_, path_);
  const RenderedView rendered = viewer.Render(scene_.views[1], 1, &progress_);
  ASSERT_EQ(rendered.width, 96);
  ASSERT_EQ(rendered.height, 72);
  ASSERT_EQ(rendered.color.size(), photograph.data.size());
  double sum = 0;
  for (size_t i = 0; i < rendered.color.size(); ++i) {
    const double difference = rendered.color[i] - photograph.data[i] / 255.0;
    sum += difference * difference;
  }
  EXPECT_GT(-10 * std::log10(sum / rendered.color.size()), 18);

  // Moved by half a pixel, the centres of its pixels are the points that maps
  // are rendered at. Pixels that those interpolate are left out.
  View moved = scene_.views[1];
  moved.camera.cx += 0.5;
  moved.camera.cy += 0.5;
  const RenderedView at_integers = viewer.Render(moved, -1, &progress_);
  int num_compared = 0;
  for (int row = 0; row < 72; row += 2) {
    for (int col = 0; col < 96; col += 2) {
      const size_t pixel = static_cast<size_t>(row) * 96 + col;
      if (maps_.depth[pixel] > 0) {
        EXPECT_NEAR(at_integers.depth[pixel],
                    maps_.depth[pixel],
                    1e-3 * maps_.depth[pixel]);
        ++num_compared;
      }
    }
  }
  EXPECT_GT(num_compared, 1000);
}

TEST_F(FieldViewerTest, NormalsAreThoseOfTheDepth) {
  const RenderedView rendered = FieldViewer(scene_, options_, path_)
                                    .Render(scene_.views[1], 1, &progress_);
  const size_t num_pixels = rendered.depth.size();
  ASSERT_EQ(rendered.normal.size(), 3 * num_pixels);
  const PinholeCamera& camera = scene_.views[1].camera;
  for (int row = 0; row < 72; ++row) {
    for (int col = 0; col < 96; ++col) {
      const size_t pixel = static_cast<size_t>(row) * 96 + col;
      const Eigen::Vector3d normal(rendered.normal[pixel],
                                   rendered.normal[num_pixels + pixel],
                                   rendered.normal[2 * num_pixels + pixel]);
      EXPECT_NEAR(normal.norm(), 1, 1e-4);
      EXPECT_LE(normal.dot(Eigen::Vector3d((col + 0.5 - camera.cx) / camera.fx,
                                           (row + 0.5 - camera.cy) / camera.fy,
                                           1)),
                1e-4);
    }
  }
}

TEST_F(FieldViewerTest, KnowsWhichCamerasAreInTheBox) {
  const FieldViewer viewer(scene_, options_, path_);
  for (const View& view : scene_.views) {
    EXPECT_TRUE(viewer.Contains(view));
  }
  View far = scene_.views[0];
  far.cam_from_world_translation.z() += 100;
  EXPECT_FALSE(viewer.Contains(far));
}

TEST_F(FieldViewerTest, RefusesAFieldOfAnotherSceneOrOtherOptions) {
  ReconstructionOptions other = options_;
  other.field.log2_table_size = 14;
  EXPECT_THROW(FieldViewer(scene_, other, path_), std::runtime_error);
  Scene larger = scene_;
  larger.views[0].cam_from_world_translation.x() += 100;
  EXPECT_THROW(FieldViewer(larger, options_, path_), std::runtime_error);
  EXPECT_THROW(FieldViewer(scene_, options_, path_ + "none"),
               std::runtime_error);
}

}  // namespace
}  // namespace structnerf
