#include "nerf/scene_file.h"

#include "nerf/util/checksummed_file.h"
#include "tests/nerf/plane_scene.h"
#include "tests/support/temp_dir.h"

#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::HasSubstr;

constexpr FileFormat kFormat = {
    {'S', 'N', 'S', 'C', 'E', 'N', 'E', '\0'}, /*version=*/2, "scene"};

// Every field has a value of its own; what may be empty is so in one view.
Scene MakeFullScene() {
  Scene scene;
  View turned = MakeView("hall/first picture.jpg",
                         {40, 30, 50.5, 49.25, 20.125, 14.75},
                         {1e6 + 0.1, -2, 3},
                         {0.3, -0.2, 1});
  turned.image = PlainImage(4, 3, 0);
  for (size_t i = 0; i < turned.image.data.size(); ++i) {
    turned.image.data[i] = static_cast<uint8_t>(7 * i);
  }
  turned.exposure.gain = {1.25f, 0.5f, 2.0f};
  turned.exposure.offset = {-0.125f, 0.25f, 0.5f};
  for (int i = 0; i < 12; ++i) {
    turned.mask.push_back(i % 3 == 0 ? 0 : 255);
    turned.segments.push_back(i - 1);
    turned.prior_depth.push_back(0.1f * i);
    turned.prior_deviation.push_back(0.01f * i);
    turned.near_depth.push_back(1.0f + i);
    turned.far_depth.push_back(2.0f + i);
  }
  View plain = MakeView("second.jpg", MakeCamera(40, 30, 50), {1, 0, 0});
  plain.image = PlainImage(20, 15, 128);
  scene.views = {turned, plain};
  scene.points = {MakePoint(scene, {1e6, 0, 4}, {0, 1}, 0.75),
                  MakePoint(scene, {0.5, 0.25, 5}, {1}, -1),
                  MakePoint(scene, {0, 0, 6}, {})};
  return scene;
}

void ExpectEqual(const View& a, const View& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.camera.width, b.camera.width);
  EXPECT_EQ(a.camera.height, b.camera.height);
  EXPECT_EQ(a.camera.CalibrationMatrix(), b.camera.CalibrationMatrix());
  EXPECT_EQ(a.cam_from_world_rotation, b.cam_from_world_rotation);
  EXPECT_EQ(a.cam_from_world_translation, b.cam_from_world_translation);
  EXPECT_EQ(a.image.width, b.image.width);
  EXPECT_EQ(a.image.height, b.image.height);
  EXPECT_EQ(a.image.data, b.image.data);
  EXPECT_EQ(a.exposure.gain, b.exposure.gain);
  EXPECT_EQ(a.exposure.offset, b.exposure.offset);
  EXPECT_EQ(a.mask, b.mask);
  EXPECT_EQ(a.segments, b.segments);
  EXPECT_EQ(a.prior_depth, b.prior_depth);
  EXPECT_EQ(a.prior_deviation, b.prior_deviation);
  EXPECT_EQ(a.near_depth, b.near_depth);
  EXPECT_EQ(a.far_depth, b.far_depth);
}

void ExpectEqual(const SparsePoint& a, const SparsePoint& b) {
  EXPECT_EQ(a.xyz, b.xyz);
  EXPECT_EQ(a.error, b.error);
  ASSERT_EQ(a.track.size(), b.track.size());
  for (size_t i = 0; i < a.track.size(); ++i) {
    EXPECT_EQ(a.track[i].view_idx, b.track[i].view_idx);
    EXPECT_EQ(a.track[i].xy, b.track[i].xy);
  }
}

class SceneFileTest : public testing::Test {
 protected:
  SceneFileTest() : path_(folder_ / "a scene.bin") {}

  std::string Bytes() const {
    std::ifstream file(path_, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  void SetBytes(const std::string& bytes) const {
    std::ofstream(path_, std::ios::binary) << bytes;
  }

  // What ReadScene says, which names the file; empty if it reads.
  std::string ReadError() const {
    try {
      ReadScene(path_);
      return "";
    } catch (const std::runtime_error& error) {
      EXPECT_THAT(error.what(), HasSubstr(path_));
      return error.what();
    }
  }

  // Of a file with a checksum that is right.
  std::string ReadError(const std::function<void(StateWriter*)>& write) const {
    ChecksummedFileWriter writer(kFormat, path_);
    write(&writer);
    writer.Commit();
    return ReadError();
  }

  TempDir folder_;
  const std::string path_;
};

TEST_F(SceneFileTest, RoundTripIsExact) {
  const Scene expected = MakeFullScene();
  WriteScene(expected, path_);
  const Scene scene = ReadScene(path_);
  ASSERT_EQ(scene.views.size(), expected.views.size());
  for (size_t i = 0; i < scene.views.size(); ++i) {
    ExpectEqual(scene.views[i], expected.views[i]);
  }
  ASSERT_EQ(scene.points.size(), expected.points.size());
  for (size_t i = 0; i < scene.points.size(); ++i) {
    ExpectEqual(scene.points[i], expected.points[i]);
  }
  EXPECT_FALSE(std::filesystem::exists(path_ + ".partial"));
}

// The two stop compiling when a field is added or removed: then the file needs
// the same, and a new version.
TEST_F(SceneFileTest, HasEveryField) {
  View view;
  auto& [name,
         camera,
         rotation,
         translation,
         image,
         exposure,
         mask,
         segments,
         prior_depth,
         prior_deviation,
         near_depth,
         far_depth] = view;
  EXPECT_EQ(&far_depth, &view.far_depth);
  SparsePoint point;
  auto& [xyz, error, track] = point;
  EXPECT_EQ(&track, &point.track);
}

TEST_F(SceneFileTest, EmptySceneIsOne) {
  WriteScene(Scene(), path_);
  EXPECT_TRUE(ReadScene(path_).views.empty());
}

TEST_F(SceneFileTest, DamageIsNoticed) {
  WriteScene(MakeFullScene(), path_);
  const std::string bytes = Bytes();
  for (size_t i = 0; i < bytes.size(); i += i < 60 ? 1 : 31) {
    std::string changed = bytes;
    changed[i] ^= 0x10;
    SetBytes(changed);
    EXPECT_NE(ReadError(), "") << "byte " << i;
    SetBytes(bytes.substr(0, i));
    EXPECT_NE(ReadError(), "") << "ends at " << i;
  }
  SetBytes(bytes + '\0');
  EXPECT_THAT(ReadError(), HasSubstr("damaged"));
  SetBytes(bytes);
  EXPECT_EQ(ReadError(), "");
}

TEST_F(SceneFileTest, OtherFilesAndVersionsAreNamed) {
  WriteScene(MakeFullScene(), path_);
  EXPECT_TRUE(IsSceneFile(path_));
  std::string bytes = Bytes();
  bytes[8] = 77;  // after the magic word
  SetBytes(bytes);
  EXPECT_TRUE(IsSceneFile(path_));
  EXPECT_THAT(ReadError(), HasSubstr("version 77"));
  SetBytes("a photograph");
  EXPECT_FALSE(IsSceneFile(path_));
  EXPECT_THAT(ReadError(), HasSubstr("is not a scene"));
  std::filesystem::remove(path_);
  EXPECT_FALSE(IsSceneFile(path_));
  EXPECT_NE(ReadError(), "");
}

// Numbers that no memory could hold, with a checksum that is right.
TEST_F(SceneFileTest, NumbersAreNotTrusted) {
  const uint64_t many = uint64_t{1} << 61;
  EXPECT_NE(ReadError([&](StateWriter* writer) { writer->WriteValue(many); }),
            "");
  EXPECT_NE(ReadError([&](StateWriter* writer) {
              writer->WriteValue(uint64_t{0});
              writer->WriteValue(many);
            }),
            "");
  EXPECT_NE(ReadError([&](StateWriter* writer) {
              writer->WriteValue(uint64_t{0});
              writer->WriteValue(uint64_t{1});
              for (int i = 0; i < 4; ++i) {
                writer->WriteValue(0.0);
              }
              writer->WriteValue(many);  // observations
            }),
            "");
  EXPECT_THAT(ReadError([&](StateWriter* writer) {
                writer->WriteValue(uint64_t{0});
                writer->WriteValue(uint64_t{0});
                writer->WriteValue(1);
              }),
              HasSubstr("behind its end"));
}

TEST_F(SceneFileTest, ScenesThatContradictThemselvesAreRefused) {
  Scene scene = MakeFullScene();
  scene.points[0].track[0].view_idx = 2;
  WriteScene(scene, path_);
  EXPECT_THAT(ReadError(), HasSubstr("sparse point 0"));
  scene = MakeFullScene();
  scene.views[1].image.height = 1 << 30;
  WriteScene(scene, path_);
  EXPECT_THAT(ReadError(), HasSubstr("second.jpg"));
}

TEST_F(SceneFileTest, NamesCannotLeadOutOfAFolder) {
  for (const char* name : {"../a.jpg", "/etc/a.jpg", "a/../../b.jpg", ""}) {
    Scene scene = MakeFullScene();
    scene.views[0].name = name;
    WriteScene(scene, path_);
    EXPECT_THAT(ReadError(), HasSubstr("lead out of the folder")) << name;
  }
}

TEST_F(SceneFileTest, FolderThatDoesNotExist) {
  EXPECT_THROW(WriteScene(Scene(), folder_ / "none/scene.bin"),
               std::runtime_error);
}

}  // namespace
}  // namespace structnerf
