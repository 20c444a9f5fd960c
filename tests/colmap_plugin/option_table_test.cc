#include "colmap_plugin/option_table.h"

#include "colmap_plugin/colmap_compat.h"

#include <limits>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

// Parses as the command does.
void Parse(std::vector<std::string> args, StructNerfOptions* options) {
  const auto table = MakeOptionTable(options);
  colmap::OptionManager manager;
  AddOptions(table, &manager);
  args.insert(args.begin(), "colmap");
  std::vector<char*> argv;
  for (std::string& arg : args) {
    argv.push_back(arg.data());
  }
  if (!ParseOptions(static_cast<int>(argv.size()), argv.data(), &manager)) {
    std::exit(EXIT_FAILURE);
  }
}

std::string CheckError(StructNerfOptions options) {
  try {
    CheckOptions(MakeOptionTable(&options), options);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

TEST(OptionTable, NamesAreUniqueAndEveryOptionIsExplained) {
  StructNerfOptions options;
  std::set<std::string> names;
  for (const OptionEntry& entry : MakeOptionTable(&options)) {
    EXPECT_THAT(entry.name, StartsWith("StructNeRF."));
    EXPECT_TRUE(names.insert(entry.name).second) << entry.name;
    EXPECT_FALSE(entry.help.empty()) << entry.name;
    EXPECT_LE(entry.min_value, entry.max_value) << entry.name;
  }
}

TEST(OptionTable, AllPresetsAreInRange) {
  for (const std::string quality : {"low", "medium", "high", "extreme"}) {
    StructNerfOptions options;
    options.reconstruction = QualityPreset(quality);
    EXPECT_EQ(CheckError(options), "") << quality;
  }
}

TEST(OptionTable, ParsesEveryType) {
  StructNerfOptions options;
  options.reconstruction.training.seed = 5;
  Parse({"--StructNeRF.num_steps",
         "17",
         "--StructNeRF.patch_weight=0.25",
         "--StructNeRF.input_type",
         "photometric"},
        &options);
  EXPECT_EQ(options.reconstruction.training.num_steps, 17);
  EXPECT_EQ(options.reconstruction.loss.patch_weight, 0.25);
  EXPECT_EQ(options.input_type, "photometric");
  EXPECT_EQ(options.reconstruction.training.seed, 5);  // present value stays
}

TEST(OptionTableDeathTest, UnknownOrUnreadableOptionIsNamed) {
  StructNerfOptions options;
  EXPECT_EXIT(Parse({"--StructNeRF.no_such_option", "1"}, &options),
              testing::ExitedWithCode(EXIT_FAILURE),
              "StructNeRF.no_such_option");
  EXPECT_EXIT(Parse({"--StructNeRF.num_steps", "many"}, &options),
              testing::ExitedWithCode(EXIT_FAILURE),
              "StructNeRF.num_steps");
}

TEST(OptionTable, NamesOptionOutOfRange) {
  StructNerfOptions options;
  options.reconstruction.training.num_steps = 0;
  EXPECT_EQ(CheckError(options),
            "The option --StructNeRF.num_steps must be at least 1, but is 0.");

  options = StructNerfOptions();
  options.reconstruction.loss.patch_ssim_share = 1.5;
  EXPECT_EQ(
      CheckError(options),
      "The option --StructNeRF.patch_ssim_share must be at least 0 and at "
      "most 1, but is 1.5.");

  options = StructNerfOptions();
  options.reconstruction.loss.color_weight =
      std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(CheckError(options), HasSubstr("StructNeRF.color_weight"));

  options = StructNerfOptions();
  options.input_type = "both";
  EXPECT_THAT(CheckError(options), HasSubstr("StructNeRF.input_type"));
}

TEST(OptionTable, TextIsThatOfAProjectFile) {
  StructNerfOptions options;
  options.max_memory_gb = 2.5;
  for (const OptionEntry& entry : MakeOptionTable(&options)) {
    if (entry.name == "StructNeRF.max_memory_gb") {
      EXPECT_EQ(OptionText(entry), "StructNeRF.max_memory_gb = 2.5");
      EXPECT_EQ(std::get<double>(entry.Value()), 2.5);
    }
  }
}

}  // namespace
}  // namespace structnerf
